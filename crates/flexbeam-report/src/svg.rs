//! The SVG writer: elements, escaped text, numbers at a hundredth of a pixel.

use std::fmt::Write;

/// SVG text under construction.
#[derive(Default)]
pub(crate) struct Svg {
    text: String,
    open: Vec<&'static str>,
}

impl Svg {
    /// Opens an element; attributes are escaped.
    pub(crate) fn open(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.start(name, attributes);
        self.text.push_str(">\n");
        self.open.push(name);
    }

    /// Closes the innermost open element.
    pub(crate) fn close(&mut self) {
        let name = self.open.pop().expect("every close has its open");
        let _ = writeln!(self.text, "</{name}>");
    }

    /// An element without content.
    pub(crate) fn empty(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.start(name, attributes);
        self.text.push_str("/>\n");
    }

    /// A line of text in spans. No white space between them, because it would show.
    pub(crate) fn text(&mut self, attributes: &[(&str, &str)], spans: &[(String, Vec<(&str, String)>)]) {
        self.start("text", attributes);
        self.text.push('>');
        for (span, own) in spans {
            let own: Vec<(&str, &str)> = own.iter().map(|(key, value)| (*key, value.as_str())).collect();
            if own.is_empty() {
                self.text.push_str(&escaped(span));
                continue;
            }
            self.start("tspan", &own);
            let _ = write!(self.text, ">{}</tspan>", escaped(span));
        }
        self.text.push_str("</text>\n");
    }

    /// The finished text.
    pub(crate) fn finished(self) -> String {
        assert!(self.open.is_empty(), "every open element is closed");
        self.text
    }

    fn start(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let _ = write!(self.text, "<{name}");
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escaped(value));
        }
    }
}

/// Text made safe for elements and for quoted attributes; characters that XML forbids become U+FFFD.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'.. => safe.push(c),
            _ => safe.push('\u{fffd}'),
        }
    }
    safe
}

/// A coordinate [px], to 0.01, without trailing zeros.
pub(crate) fn px(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// Path data of a polyline. A lone point becomes a line of no length, which round caps draw as a dot.
pub(crate) fn polyline(points: &[(f64, f64)]) -> String {
    let mut data = String::with_capacity(points.len() * 12);
    for (k, (x, y)) in points.iter().enumerate() {
        let _ = write!(data, "{}{},{}", if k == 0 { 'M' } else { 'L' }, px(*x), px(*y));
    }
    if points.len() == 1 {
        data.push_str("h0.01");
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        for (x, text) in [(1.0, "1"), (1.005, "1"), (-0.001, "0"), (12.345, "12.35"), (-3.1, "-3.1"), (100.0, "100")] {
            assert!((text.parse::<f64>().unwrap() - x).abs() < 0.0051);
            assert_eq!(px(x).len(), text.len(), "{x}");
        }
    }

    #[test]
    fn markup_in_text_is_harmless() {
        let nasty = "<script>\"a\" & 'b'\u{0}\u{b}]]></script>";
        let document = format!("<t a=\"{0}\">{0}</t>", escaped(nasty));
        let tree = roxmltree::Document::parse(&document).unwrap();
        let read_back = "<script>\"a\" & 'b'\u{fffd}\u{fffd}]]></script>";
        assert_eq!(tree.root_element().text(), Some(read_back));
        assert_eq!(tree.root_element().attribute("a"), Some(read_back));
    }

    #[test]
    fn a_lone_point_is_drawn() {
        assert_eq!(polyline(&[(1.0, 2.0)]), "M1,2h0.01");
        assert_eq!(polyline(&[(1.0, 2.0), (3.5, 4.25)]), "M1,2L3.5,4.25");
    }
}
