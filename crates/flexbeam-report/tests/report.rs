//! The page, read back as XML.

use flexbeam_report::{Cell, Check, Figure, Panel, Report, Table, Verdict};
use roxmltree::{Document, Node};

fn page() -> String {
    let mut report = Report::new("Beam <1> & more", "What was found.");
    report.section("First & only");
    report.heading("Part");
    report.paragraph("σ₅ < 10⁻³ σ₄ \"quoted\"");
    report.formula("G₀ = N/D");
    report.verbatim("a < b\n  c");
    for title in ["One", "Two"] {
        report.figure(
            &Figure::new(title, "t [s]").panel(Panel::new("y [m]").line("y", &[0.0, 1.0], &[1.0, 2.0])),
            "Caption & all.",
        );
    }
    report.table("Poles.", &Table::new(&[("pole", "1/s")]).row([Cell::number(-1.24e-7, 3)]));
    let check = |verdict| Check {
        name: "Norm".into(),
        symbol: "‖S‖".into(),
        value: "-0.85".into(),
        unit: String::new(),
        required: "≤ 1".into(),
        verdict,
    };
    report.certificate("Certificate.", &[check(Verdict::Pass), check(Verdict::Fail), check(Verdict::Info)]);
    report.section("Second");
    report.facts("Origin.", &[("file", "a<b>.csv")]);
    report.html("flexbeam & seed 1")
}

fn text(node: Node) -> String {
    node.descendants().filter(Node::is_text).filter_map(|n| n.text()).collect()
}

fn all<'a>(document: &'a Document, tag: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.has_tag_name(tag) || n.tag_name().name() == tag).collect()
}

#[test]
fn the_page_is_well_formed_and_complete() {
    let page = page();
    let document = Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    assert_eq!(all(&document, "svg").len(), 2);
    assert_eq!(all(&document, "h1").into_iter().map(text).collect::<Vec<_>>(), ["Beam <1> & more"]);
    let captions: Vec<String> = all(&document, "caption").into_iter().map(text).collect();
    assert_eq!(captions, ["Table 1. Poles.", "Table 2. Certificate.", "Table 3. Origin."]);
    let under: Vec<String> = all(&document, "figcaption").into_iter().map(text).collect();
    assert_eq!(under, ["Figure 1. Caption & all.", "Figure 2. Caption & all."]);
    assert!(all(&document, "td").into_iter().map(text).any(|cell| cell == "−1.24 × 10−7"));
    assert_eq!(all(&document, "footer").into_iter().map(text).collect::<Vec<_>>(), ["flexbeam & seed 1"]);
}

#[test]
fn every_link_has_its_target() {
    let page = page();
    let document = Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    let links: Vec<&str> = all(&document, "a").into_iter().filter_map(|n| n.attribute("href")).collect();
    assert_eq!(links.len(), 2);
    for link in links {
        let targets = document.descendants().filter(|n| n.attribute("id").is_some_and(|id| link == format!("#{id}")));
        assert_eq!(targets.count(), 1, "{link}");
    }
}

#[test]
fn the_page_needs_nothing_from_outside() {
    let page = page();
    let document = Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    for node in document.descendants() {
        assert!(!["script", "link", "img", "iframe"].contains(&node.tag_name().name()));
        assert!(node.attribute("src").is_none());
        assert!(node.attribute("href").is_none_or(|href| href.starts_with('#')));
    }
    assert!(!page.contains("url(http") && !page.contains("@import"));
}

#[test]
fn verdicts_are_told_by_word_and_by_colour() {
    let page = page();
    assert_eq!(page.matches("<span class=\"pass\">✓ pass</span>").count(), 1);
    assert_eq!(page.matches("<span class=\"fail\">✗ fail</span>").count(), 1);
}
