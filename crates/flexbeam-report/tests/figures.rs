//! Pictures, looked at through their structure: what must be in the SVG, and what must never be.

use flexbeam_report::{Error, Figure, Marker, Panel, Scale, Series, png_of_svg};
use proptest::prelude::*;
use roxmltree::{Document, Node};

fn every_kind(x: &[f64], y: &[f64]) -> Figure {
    let lower: Vec<f64> = y.iter().map(|v| v - 1.0).collect();
    let all = Panel::new("All kinds [1]")
        .band("band", x, &lower, y)
        .line("line", x, y)
        .step("step", x, y)
        .stem("stem", x, y)
        .markers("markers", x, y, Marker::Cross)
        .vertical(1.0, "v")
        .horizontal(0.5, "h")
        .shade(0.2, 0.8, "s")
        .note(1.0, 1.0, "n");
    Figure::new("Every kind", "x [1]").panel(all).panel(Panel::new("Lower [1]").log_y().line("line", x, y))
}

/// Numbers in all attributes that hold coordinates.
fn coordinates(document: &Document) -> Vec<f64> {
    let geometry = ["x", "y", "width", "height", "d", "dy", "viewBox"];
    let values = document.descendants().flat_map(|n| n.attributes().map(|a| (a.name(), a.value())).collect::<Vec<_>>());
    let text: Vec<&str> = values.filter(|(name, _)| geometry.contains(name)).map(|(_, value)| value).collect();
    let separated = text
        .join(" ")
        .replace(|c: char| c != 'e' && c != 'N' && c.is_ascii_alphabetic() || c == ',', " ")
        .replace('-', " -");
    separated.split_whitespace().map(|number| number.parse().expect(number)).collect()
}

fn drawn<'a>(document: &'a Document, name: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.attribute("data-name") == Some(name)).collect()
}

fn words(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts.map(|n| n.descendants().filter_map(|t| if t.is_text() { t.text() } else { None }).collect()).collect()
}

#[test]
fn every_series_mark_and_label_is_drawn() {
    let svg = every_kind(&[0.0, 1.0, 2.0], &[0.5, 1.5, 1.0]).svg();
    let document = Document::parse(&svg).unwrap();
    for (name, times) in [("band", 1), ("line", 2), ("step", 1), ("stem", 1), ("markers", 1)] {
        assert_eq!(drawn(&document, name).len(), times, "{name}");
    }
    let words = words(&svg);
    for word in [
        "Every kind",
        "x [1]",
        "All kinds [1]",
        "Lower [1]",
        "band",
        "line",
        "step",
        "stem",
        "markers",
        "v",
        "h",
        "s",
        "n",
    ] {
        assert_eq!(words.iter().filter(|w| *w == word).count(), 1, "{word} in {words:?}");
    }
}

#[test]
fn a_gap_in_the_data_is_a_gap_in_the_line() {
    let x: Vec<f64> = (0..9).map(f64::from).collect();
    let y = [0.0, 1.0, f64::NAN, 1.0, f64::INFINITY, 2.0, 3.0, 0.0, 1.0];
    let svg = Figure::new("", "x").panel(Panel::new("y").line("gaps", &x, &y)).svg();
    let document = Document::parse(&svg).unwrap();
    let path = drawn(&document, "gaps")[0].first_element_child().unwrap().attribute("d").unwrap();
    assert_eq!(path.matches('M').count(), 3, "{path}");
    assert_eq!(path.matches('L').count(), 1 + 3, "{path}");
}

#[test]
fn markup_in_names_stays_text() {
    let nasty = "</text><script>alert(\"1\")</script>&amp;'";
    let panel =
        Panel::new(nasty).line(nasty, &[0.0, 1.0], &[0.0, 1.0]).line("other", &[0.0], &[0.0]).horizontal(0.3, nasty);
    let svg = Figure::new(nasty, nasty).panel(panel).svg();
    let document = Document::parse(&svg).unwrap();
    assert!(document.descendants().all(|n| !n.has_tag_name("script")));
    assert!(words(&svg).iter().filter(|w| *w == nasty).count() >= 3);
}

#[test]
fn a_long_record_makes_a_small_picture() {
    let x: Vec<f64> = (0..100_000).map(|k| k as f64 * 1e-3).collect();
    let y: Vec<f64> = x.iter().map(|t| (37.0 * t * t).sin()).collect();
    let svg = Figure::new("", "t").panel(Panel::new("y").line("chirp", &x, &y)).svg();
    assert!(svg.len() < 80_000, "{} bytes", svg.len());
}

#[test]
fn one_name_has_one_colour_and_two_names_have_two() {
    let line = |name: &str| Series::line(name, &[0.0, 1.0], &[0.0, 1.0]);
    let top = Panel::new("a").with(line("first")).with(line("second"));
    let svg = Figure::new("", "x").panel(top).panel(Panel::new("b").with(line("second"))).svg();
    let document = Document::parse(&svg).unwrap();
    let colours = |name| -> Vec<&str> {
        drawn(&document, name).iter().map(|n| n.first_element_child().unwrap().attribute("stroke").unwrap()).collect()
    };
    assert_eq!(colours("second")[0], colours("second")[1]);
    assert_ne!(colours("first")[0], colours("second")[0]);
}

#[test]
fn equal_aspect_draws_a_circle_round() {
    let angle: Vec<f64> = (0..200).map(|k| k as f64 * std::f64::consts::TAU / 199.0).collect();
    let (x, y): (Vec<f64>, Vec<f64>) = angle.iter().map(|a| (a.cos(), a.sin())).unzip();
    let svg = Figure::new("", "x").equal_aspect().panel(Panel::new("y").line("circle", &x, &y)).svg();
    let document = Document::parse(&svg).unwrap();
    let path = drawn(&document, "circle")[0].first_element_child().unwrap().attribute("d").unwrap();
    let points = path[1..].split('L').map(|p| p.split_once(',').unwrap());
    let (x, y): (Vec<f64>, Vec<f64>) =
        points.map(|(x, y)| (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap())).unzip();
    let extent = |v: &[f64]| v.iter().fold(f64::MIN, |a, b| a.max(*b)) - v.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!((extent(&x) / extent(&y) - 1.0).abs() < 1e-3);
}

#[test]
fn pictures_without_data_are_still_pictures() {
    let nothing = Panel::new("y").line("none", &[], &[]).log_y();
    for figure in [
        Figure::new("", ""),
        Figure::new("t", "x").panel(nothing),
        every_kind(&[3.0], &[f64::NAN]),
        every_kind(&[0.0], &[2.0]),
    ] {
        let svg = figure.svg();
        assert!(coordinates(&Document::parse(&svg).unwrap()).iter().all(|c| c.is_finite()));
        assert!(figure.png(1.0).is_ok());
    }
}

#[test]
fn png_has_the_size_and_the_ink() {
    let figure = every_kind(&[0.0, 1.0, 2.0], &[0.5, 1.5, 1.0]).size(400.0, 300.0);
    let bytes = figure.png(1.5).unwrap();
    let image = resvg::tiny_skia::Pixmap::decode_png(&bytes).unwrap();
    assert_eq!((image.width(), image.height()), (600, 450));
    let dark = image.pixels().iter().filter(|p| p.red() < 128).count();
    let white = image.pixels().iter().filter(|p| (p.red(), p.green(), p.blue()) == (255, 255, 255)).count();
    assert!(dark > 1000 && white > 100_000, "{dark} dark and {white} white pixels");
}

#[test]
fn greek_letters_leave_ink() {
    let word = |text: &str| {
        let svg = Figure::new(text, "").size(240.0, 160.0).svg();
        let image = resvg::tiny_skia::Pixmap::decode_png(&png_of_svg(&svg, 1.0).unwrap()).unwrap();
        image.pixels().iter().filter(|p| p.red() < 128).count()
    };
    let missing_glyph = word("\u{e123}");
    for letter in ["θ", "α", "ψ", "ω", "β", "σ", "ζ", "Δ"] {
        assert!(word(letter) > 10 && word(letter) != missing_glyph, "{letter}");
    }
}

#[test]
fn png_refuses_what_is_no_picture() {
    let figure = every_kind(&[0.0, 1.0], &[0.5, 1.5]);
    assert!(matches!(figure.png(0.0), Err(Error::Size { .. })));
    assert!(matches!(figure.png(1e6), Err(Error::Size { .. })));
    assert!(matches!(figure.png(f64::NAN), Err(Error::Size { .. })));
    assert!(matches!(png_of_svg("no picture", 1.0), Err(Error::Svg { bytes: 10, .. })));
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-1.0f64..1.0, -300i32..300).prop_map(|(v, e)| v * 10f64.powi(e)),
        4 => -10.0f64..10.0,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::MAX),
        1 => Just(0.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, max_shrink_iters: 200, ..ProptestConfig::default() })]

    #[test]
    fn whatever_the_data_coordinates_are_numbers(
        points in prop::collection::vec((any_value(), any_value()), 0..40),
        scale in prop_oneof![Just(Scale::Linear), Just(Scale::Log), Just(Scale::Degrees), Just(Scale::Integer), Just(Scale::Decibels)],
        range in (any_value(), any_value()),
    ) {
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        for figure in [every_kind(&x, &y).x_scale(scale), every_kind(&x, &y).x_scale(scale).x_range(range.0, range.1)] {
            let svg = figure.svg();
            let document = Document::parse(&svg).unwrap();
            for c in coordinates(&document) {
                prop_assert!(c.is_finite() && c.abs() < 1e5, "coordinate {c}");
            }
        }
    }
}
