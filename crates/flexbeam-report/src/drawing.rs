//! Ink: a laid-out figure becomes SVG.

use crate::figure::{Figure, Mark};
use crate::layout::{
    LABEL, LEGEND, LINE_HEIGHT, Layout, MARK, Placed, Rect, SAMPLE_GAP, TICK, TICK_LENGTH, TITLE, exponent,
};
use crate::placement::{Room, line_of, shaded};
use crate::scale::Scale;
use crate::series::{Colour, Dash, Marker, Series, Shape, stairs, thinned, unbroken};
use crate::svg::{Svg, polyline, px};
use crate::typeface::{FAMILIES, SCRIPT_SIZE, Weight, runs, width};

const PAPER: &str = "#ffffff";
const TEXT: &str = "#262626";
const AXIS: &str = "#5a5a5a";
const GRID: &str = "#e3e3e0";
const FINE_GRID: &str = "#f1f1ef";
const TINT: &str = "#b9c6d6";
const REFERENCE: &str = "#6b6b6b";
const WORDS: &str = "#4a4a4a";
/// Half the height of a marker [px].
const MARKER: f64 = 3.4;

type Points = Vec<(f64, f64)>;

/// The figure as SVG.
pub(crate) fn svg(figure: &Figure) -> String {
    let layout = Layout::of(figure);
    let mut ink = Ink { svg: Svg::default() };
    ink.sheet(figure);
    for (k, placed) in layout.panels.iter().enumerate() {
        ink.panel(&layout, placed);
        ink.y_axis(placed);
        ink.x_axis(placed, k + 1 == layout.panels.len(), &figure.x_label);
        ink.legend(&layout, placed);
    }
    ink.svg.close();
    ink.svg.finished()
}

#[derive(Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

/// How a line of text is set.
#[derive(Clone, Copy)]
struct Style {
    size: f64,
    weight: Weight,
    fill: &'static str,
    anchor: Anchor,
    upwards: bool,
    halo: bool,
}

impl Style {
    fn of(size: f64, anchor: Anchor) -> Style {
        Style { size, weight: Weight::Regular, fill: TEXT, anchor, upwards: false, halo: false }
    }
}

struct Ink {
    svg: Svg,
}

impl Ink {
    fn sheet(&mut self, figure: &Figure) {
        let (w, h) = (px(figure.width), px(figure.height));
        let words = if figure.title.is_empty() { &figure.x_label } else { &figure.title };
        self.svg.open(
            "svg",
            &[
                ("xmlns", "http://www.w3.org/2000/svg"),
                ("width", &w),
                ("height", &h),
                ("viewBox", &format!("0 0 {w} {h}")),
                ("font-family", FAMILIES),
                ("role", "img"),
                ("aria-label", words),
            ],
        );
        self.svg.empty("rect", &[("width", &w), ("height", &h), ("fill", PAPER)]);
        let style = Style { weight: Weight::Bold, ..Style::of(title_size(figure), Anchor::Start) };
        self.text(&figure.title, (16.0, 12.0 + TITLE), style);
    }

    fn panel(&mut self, layout: &Layout, placed: &Placed) {
        let clip = self.clip(&placed.frame);
        self.svg.open("g", &[("class", "panel"), ("clip-path", &format!("url(#{clip})"))]);
        self.shades(placed);
        self.grid(placed);
        let mut drawn: Vec<Points> = vec![];
        let is_band = |s: &&Series| matches!(s.shape, Shape::Band { .. });
        for series in placed.panel.series.iter().filter(is_band) {
            self.band(placed, series, layout.colour(placed.panel, series));
        }
        self.reference_lines(placed);
        for series in placed.panel.series.iter().filter(|s| !is_band(s)) {
            drawn.extend(self.series(placed, series, layout.colour(placed.panel, series)));
        }
        self.svg.close();
        self.words(placed, drawn);
    }

    /// The frame as a clip path, named by its place: equal names clip alike, wherever pictures share a page.
    fn clip(&mut self, frame: &Rect) -> String {
        let (x, y, w, h) = (px(frame.x), px(frame.y), px(frame.width), px(frame.height));
        let name = format!("clip-{x}-{y}-{w}-{h}").replace('.', "_");
        self.svg.open("clipPath", &[("id", &name)]);
        self.svg.empty("rect", &[("x", &x), ("y", &y), ("width", &w), ("height", &h)]);
        self.svg.close();
        name
    }

    fn shades(&mut self, placed: &Placed) {
        for mark in &placed.panel.marks {
            if let Mark::Shade { from, to, .. } = mark
                && let Some((left, right)) = shaded(placed, *from, *to)
            {
                let (y, h) = (px(placed.frame.y), px(placed.frame.height));
                let place = [("x", &*px(left)), ("y", &y), ("width", &px(right - left)), ("height", &h)];
                self.svg.empty("rect", &[&place[..], &[("fill", TINT), ("fill-opacity", "0.25")]].concat());
            }
        }
    }

    fn grid(&mut self, placed: &Placed) {
        let frame = placed.frame;
        let vertical = |v: f64| placed.frame.x + placed.x.place(v) * frame.width;
        let horizontal = |v: f64| frame.bottom() - placed.y.place(v) * frame.height;
        let mut fine = String::new();
        placed.x_ticks.minor.iter().for_each(|v| fine += &upright(vertical(*v), &frame));
        placed.y_ticks.minor.iter().for_each(|v| fine += &level(horizontal(*v), &frame));
        let mut main = String::new();
        placed.x_ticks.major.iter().for_each(|t| main += &upright(vertical(t.value), &frame));
        placed.y_ticks.major.iter().for_each(|t| main += &level(horizontal(t.value), &frame));
        for (data, colour) in [(fine, FINE_GRID), (main, GRID)].into_iter().filter(|(data, _)| !data.is_empty()) {
            self.svg.empty("path", &[("class", "grid"), ("d", &data), ("stroke", colour), ("stroke-width", "0.8")]);
        }
    }

    fn reference_lines(&mut self, placed: &Placed) {
        let ends = placed.panel.marks.iter().filter_map(|mark| line_of(placed, mark));
        let lines: String = ends.map(|ends| polyline(&ends)).collect();
        if !lines.is_empty() {
            let dashes = [("stroke-width", "1"), ("stroke-dasharray", "5 3")];
            self.svg.empty(
                "path",
                &[&[("class", "reference"), ("d", &*lines), ("stroke", REFERENCE)], &dashes[..]].concat(),
            );
        }
    }

    fn band(&mut self, placed: &Placed, series: &Series, colour: Colour) {
        let Shape::Band { lower } = &series.shape else { return };
        let edge = |y: &[f64]| -> Points { series.x.iter().zip(y).map(|(x, y)| placed.at(*x, *y)).collect() };
        let (mut above, mut below) = (edge(&series.y), edge(lower));
        for (a, b) in above.iter_mut().zip(&mut below) {
            if a.1.is_nan() || b.1.is_nan() {
                (a.1, b.1) = (f64::NAN, f64::NAN);
            }
        }
        let outline = |above: &[(f64, f64)], below: &[(f64, f64)]| {
            let back: Points = thinned(below).into_iter().rev().collect();
            polyline(&[thinned(above), back].concat()) + "Z"
        };
        let data: String = unbroken(&above).zip(unbroken(&below)).map(|(a, b)| outline(a, b)).collect();
        let fill = [("fill", colour.css()), ("fill-opacity", "0.15")];
        self.svg
            .empty("path", &[&[("class", "series"), ("data-name", &*series.name), ("d", &data)], &fill[..]].concat());
    }

    /// Draws the series and returns what it covers.
    fn series(&mut self, placed: &Placed, series: &Series, colour: Colour) -> Vec<Points> {
        let points: Points = series.x.iter().zip(&series.y).map(|(x, y)| placed.at(*x, *y)).collect();
        self.svg.open("g", &[("class", "series"), ("data-name", &series.name)]);
        let parts: Vec<Points> = match series.shape {
            Shape::Line => unbroken(&points).map(thinned).collect(),
            Shape::Step => unbroken(&points).map(|part| thinned(&stairs(part))).collect(),
            Shape::Stem => {
                let foot = if placed.y.scale() == Scale::Log { placed.y.low() } else { 0.0 };
                let foot = placed.at(placed.x.low(), foot).1;
                unbroken(&points).flatten().map(|(x, y)| vec![(*x, foot), (*x, *y)]).collect()
            }
            Shape::Markers | Shape::Band { .. } => vec![],
        };
        let data: String = parts.iter().map(|part| polyline(part)).collect();
        self.stroke(&data, series, colour);
        let signs: Points = unbroken(&points).flatten().copied().filter(|_| series.marker.is_some()).collect();
        if let Some(marker) = series.marker {
            self.markers(&apart(&signs), marker, colour);
        }
        self.svg.close();
        [parts, signs.into_iter().map(|p| vec![p]).collect()].concat()
    }

    fn stroke(&mut self, data: &str, series: &Series, colour: Colour) {
        if data.is_empty() {
            return;
        }
        let dashes = series.dash.pattern().map(|p| p.map(|part| px(part * series.width)).join(" "));
        let cap = if series.dash == Dash::Solid { "round" } else { "butt" };
        let line_width = px(series.width);
        let mut attributes =
            vec![("d", data), ("fill", "none"), ("stroke", colour.css()), ("stroke-width", &line_width)];
        attributes.extend([("stroke-linejoin", "round"), ("stroke-linecap", cap)]);
        attributes.extend(dashes.as_deref().map(|d| ("stroke-dasharray", d)));
        self.svg.empty("path", &attributes);
    }

    fn markers(&mut self, points: &[(f64, f64)], marker: Marker, colour: Colour) {
        let data: String = points.iter().map(|p| sign(*p, marker)).collect();
        if data.is_empty() {
            return;
        }
        let fill = match marker {
            Marker::Disc | Marker::Diamond => colour.css(),
            Marker::Circle | Marker::Square => PAPER,
            Marker::Cross | Marker::Plus => "none",
        };
        let line = [("stroke", colour.css()), ("stroke-width", "1.5"), ("stroke-linecap", "round")];
        self.svg.empty("path", &[&[("class", "markers"), ("d", &*data), ("fill", fill)], &line[..]].concat());
    }

    /// Names of lines and regions, and notes, where they cover least.
    fn words(&mut self, placed: &Placed, drawn: Vec<Points>) {
        if placed.panel.marks.is_empty() {
            return;
        }
        let mut room = Room::beside(placed, drawn);
        for mark in &placed.panel.marks {
            if let Some(place) = room.take(placed, mark) {
                let upwards = matches!(mark, Mark::Vertical { .. });
                let base =
                    if upwards { (place.right() - 3.5, place.bottom()) } else { (place.x, place.bottom() - 3.5) };
                let style = Style { upwards, halo: true, fill: WORDS, ..Style::of(MARK, Anchor::Start) };
                self.text(mark.words(), base, style);
            }
        }
    }

    fn y_axis(&mut self, placed: &Placed) {
        let frame = placed.frame;
        let axis = format!("M{0},{1}V{2}H{3}", px(frame.x), px(frame.y), px(frame.bottom()), px(frame.right()));
        self.svg.empty("path", &[("class", "axis"), ("d", &axis), ("fill", "none"), ("stroke", AXIS)]);
        let mut ticks = String::new();
        for tick in &placed.y_ticks.major {
            let y = frame.bottom() - placed.y.place(tick.value) * frame.height;
            ticks += &format!("M{},{}h{}", px(frame.x), px(y), px(-TICK_LENGTH));
            let at = (frame.x - 2.0 * TICK_LENGTH, y + 0.36 * TICK);
            self.text(&tick.label, at, Style::of(TICK, Anchor::End));
        }
        self.svg.empty("path", &[("class", "ticks"), ("d", &ticks), ("stroke", AXIS)]);
        let at = (frame.x - 2.0 * TICK_LENGTH, frame.y - 8.0);
        self.text(&exponent(&placed.y_ticks), at, Style::of(TICK, Anchor::End));
        for (k, line) in placed.y_label.iter().enumerate() {
            let at = (12.0 + LABEL * 0.85 + k as f64 * LINE_HEIGHT, frame.y + frame.height / 2.0);
            self.text(line, at, Style { upwards: true, ..Style::of(LABEL, Anchor::Middle) });
        }
    }

    fn x_axis(&mut self, placed: &Placed, labelled: bool, label: &str) {
        let frame = placed.frame;
        let mut ticks = String::new();
        for tick in &placed.x_ticks.major {
            let x = frame.x + placed.x.place(tick.value) * frame.width;
            ticks += &format!("M{},{}v{}", px(x), px(frame.bottom()), px(TICK_LENGTH));
            if labelled {
                let at = (x, frame.bottom() + TICK_LENGTH + LINE_HEIGHT - 3.0);
                self.text(&tick.label, at, Style::of(TICK, Anchor::Middle));
            }
        }
        self.svg.empty("path", &[("class", "ticks"), ("d", &ticks), ("stroke", AXIS)]);
        if labelled {
            let base = frame.bottom() + TICK_LENGTH + 2.0 * LINE_HEIGHT + 3.0;
            self.text(label, (frame.x + frame.width / 2.0, base), Style::of(LABEL, Anchor::Middle));
            self.text(&exponent(&placed.x_ticks), (frame.right(), base), Style::of(TICK, Anchor::End));
        }
    }

    fn legend(&mut self, layout: &Layout, placed: &Placed) {
        for entry in &placed.legend {
            let middle = entry.base - 0.34 * LEGEND;
            self.svg.open("g", &[("class", "legend")]);
            for series in &entry.series {
                let colour = layout.colour(placed.panel, series);
                self.sample(series, colour, (entry.x, middle), entry.sample);
            }
            let at = (entry.x + entry.sample + SAMPLE_GAP, entry.base);
            self.text(&entry.series[0].name, at, Style::of(LEGEND, Anchor::Start));
            self.svg.close();
        }
    }

    fn sample(&mut self, series: &Series, colour: Colour, (x, y): (f64, f64), length: f64) {
        match series.shape {
            Shape::Band { .. } => {
                let place = [("x", &*px(x)), ("y", &px(y - 5.0)), ("width", &px(length)), ("height", "10")];
                self.svg.empty("rect", &[&place[..], &[("fill", colour.css()), ("fill-opacity", "0.2")]].concat());
            }
            Shape::Markers => (),
            _ => self.stroke(&polyline(&[(x, y), (x + length, y)]), series, colour),
        }
        if let Some(marker) = series.marker {
            self.markers(&[(x + length / 2.0, y)], marker, colour);
        }
    }

    fn text(&mut self, text: &str, (x, y): (f64, f64), style: Style) {
        if text.is_empty() {
            return;
        }
        let size = px(style.size);
        let anchor = match style.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (px_x, px_y) = (px(x), px(y));
        let turn = format!("rotate(-90 {px_x} {px_y})");
        let mut attributes = vec![("x", &*px_x), ("y", &px_y), ("font-size", &size), ("fill", style.fill)];
        attributes.push(("text-anchor", anchor));
        attributes.extend((style.weight == Weight::Bold).then_some(("font-weight", "bold")));
        attributes.extend(style.upwards.then_some(("transform", &*turn)));
        if style.halo {
            attributes.extend([("stroke", PAPER), ("stroke-width", "3"), ("stroke-opacity", "0.7")]);
            attributes.extend([("stroke-linejoin", "round"), ("paint-order", "stroke")]);
        }
        self.svg.text(&attributes, &spans(text, style.size));
    }
}

/// The size at which the title fits the sheet.
fn title_size(figure: &Figure) -> f64 {
    const BESIDE: f64 = 32.0;
    let needed = width(&figure.title, TITLE, Weight::Bold);
    TITLE * ((figure.width - BESIDE) / needed.max(1.0)).min(1.0)
}

/// Runs of one level, each with the attributes that set it.
fn spans(text: &str, size: f64) -> Vec<(String, Vec<(&'static str, String)>)> {
    let mut rise = 0.0;
    let runs = runs(text).into_iter();
    runs.map(|(run, level)| {
        let step = std::mem::replace(&mut rise, level.rise() * size) - rise;
        let small = (level.rise() != 0.0).then(|| ("font-size", px(size * SCRIPT_SIZE)));
        let moved = (step != 0.0).then(|| ("dy", px(step)));
        (run, moved.into_iter().chain(small).collect())
    })
    .collect()
}

fn upright(x: f64, frame: &Rect) -> String {
    format!("M{},{}V{}", px(x), px(frame.bottom()), px(frame.y))
}

fn level(y: f64, frame: &Rect) -> String {
    format!("M{},{}H{}", px(frame.x), px(y), px(frame.right()))
}

fn sign((x, y): (f64, f64), marker: Marker) -> String {
    let r = MARKER;
    let (left, up) = (px(x - r), px(y - r));
    match marker {
        Marker::Disc | Marker::Circle => {
            format!("M{left},{0}a{1},{1} 0 1 0 {2},0a{1},{1} 0 1 0 -{2},0Z", px(y), px(r), px(2.0 * r))
        }
        Marker::Cross => format!("M{left},{up}l{0},{0}m0,-{0}l-{0},{0}", px(2.0 * r)),
        Marker::Plus => format!("M{left},{0}h{1}M{2},{up}v{1}", px(y), px(2.0 * r), px(x)),
        Marker::Square => format!("M{left},{up}h{0}v{0}h-{0}Z", px(2.0 * r)),
        Marker::Diamond => format!("M{left},{0}l{1},-{1}l{1},{1}l-{1},{1}Z", px(y), px(r)),
    }
}

/// Markers that would stand on one another within half a pixel are drawn once.
fn apart(points: &[(f64, f64)]) -> Points {
    let cell = |v: f64| (2.0 * v).round() as i64;
    let mut seen = std::collections::HashSet::new();
    points.iter().filter(|(x, y)| seen.insert((cell(*x), cell(*y)))).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Panel;
    use proptest::prelude::*;
    use roxmltree::{Document, Node};

    /// The place that a line of text takes: from below the base line to the height of its capitals.
    fn taken(text: Node) -> Rect {
        let number = |node: Node, name: &str| node.attribute(name).map(|v| v.parse::<f64>().unwrap());
        let size = number(text, "font-size").unwrap();
        let weight = if text.attribute("font-weight").is_some() { Weight::Bold } else { Weight::Regular };
        let own = |t: Node| number(t.parent().unwrap(), "font-size").unwrap_or(size);
        let parts = text.descendants().filter(Node::is_text);
        let length: f64 = parts.map(|t| width(t.text().unwrap(), own(t), weight)).sum();
        let (x, y) = (number(text, "x").unwrap(), number(text, "y").unwrap());
        let before = match text.attribute("text-anchor").unwrap() {
            "start" => 0.0,
            "middle" => length / 2.0,
            _ => length,
        };
        let (ascent, height) = (0.72 * size, 0.78 * size);
        match text.attribute("transform") {
            None => Rect { x: x - before, y: y - ascent, width: length, height },
            Some(_) => Rect { x: x - ascent, y: y + before - length, width: height, height: length },
        }
    }

    fn collision(figure: &Figure) -> Option<String> {
        let svg = svg(figure);
        let document = Document::parse(&svg).unwrap();
        let sheet = Rect { x: 0.0, y: 0.0, width: figure.width, height: figure.height };
        let texts: Vec<Node> = document.descendants().filter(|n| n.has_tag_name("text")).collect();
        let places: Vec<Rect> = texts.iter().map(|t| taken(*t)).collect();
        let words = |k: usize| texts[k].descendants().filter_map(|t| t.text()).next().unwrap_or("");
        let outside =
            (0..texts.len()).find(|k| !sheet.encloses(&places[*k])).map(|k| format!("{:?} outside", words(k)));
        let pairs = (0..texts.len()).flat_map(|k| (0..k).map(move |i| (k, i)));
        let mut overlaps = pairs.filter(|(k, i)| places[*k].overlaps(&places[*i]));
        outside.or_else(|| overlaps.next().map(|(k, i)| format!("{:?} on {:?}", words(k), words(i))))
    }

    /// Span, exponent, offset, logarithmic or not, and number of series.
    type Drawn = (f64, i32, f64, bool, usize);

    fn drawn(size: (f64, f64), panels: Vec<Drawn>, x: (i32, bool), title: usize) -> Figure {
        let t: Vec<f64> = (0..50).map(|k| f64::from(k + 1) / 50.0 * 10f64.powi(x.0)).collect();
        let scale = if x.1 { Scale::Log } else { Scale::Linear };
        let mut figure = Figure::new(&"title ".repeat(title / 6), "Time [s]").x_scale(scale).size(size.0, size.1);
        for (span, exponent, offset, log, count) in panels {
            let mut panel = Panel::new("Deflection angle α [deg]").vertical(t[20], "mode 1").horizontal(0.0, "zero");
            if log {
                panel = panel.log_y();
            }
            for k in 0..count {
                let value = |t: &f64| 10f64.powi(exponent) * (offset + span * (7.0 * t + k as f64).sin());
                panel = panel.line(&format!("series {k}"), &t, &t.iter().map(value).collect::<Vec<_>>());
            }
            figure = figure.panel(panel);
        }
        figure
    }

    /// What once collided: two decades upwards on a low panel, where 1-2-5 is too much.
    #[test]
    fn a_low_logarithmic_panel_keeps_its_labels_apart() {
        let panels = vec![(9.124, 0, -2.573, true, 3), (0.0, -4, 2.648, false, 1), (0.0, 0, 0.0, false, 1)];
        assert_eq!(collision(&drawn((480.0, 400.0), panels, (1, false), 6)), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 96, max_shrink_iters: 300, ..ProptestConfig::default() })]

        #[test]
        fn words_stay_on_the_sheet_and_off_one_another(
            size in (480.0f64..1000.0, 400.0f64..800.0),
            panels in prop::collection::vec((0.0f64..10.0, -8i32..8, -5.0f64..5.0, any::<bool>(), 1usize..5), 1..4),
            x in (-3i32..3, any::<bool>()),
            title in 0usize..90,
        ) {
            prop_assert_eq!(collision(&drawn(size, panels, x, title)), None);
        }
    }
}
