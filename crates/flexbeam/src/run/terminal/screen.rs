//! A picture on the screen: where each number stands. Deliberately absent: where the numbers come from.

use flexbeam_report::engineering;
use flexbeam_runtime::Phase;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph};

use super::bar::bar;
use super::picture::Picture;
use super::strip::{LENGTH_S, bounds};

/// Below this the picture is a short form.
const SMALLEST: (u16, u16) = (60, 18);
/// Rows of the readings, and of the settings.
const READINGS: u16 = 7;
const SETTINGS: u16 = 5;
/// Rows of all that is always there: head, readings, settings and their rule, the rule of the events, keys.
const FIXED: u16 = 1 + READINGS + 1 + SETTINGS + 1 + 1;
/// A strip of fewer rows says nothing.
const LOWEST_STRIP: u16 = 4;
/// Share of its end at which a bar is a warning.
const NEAR_THE_END: f64 = 0.9;

/// Draws it.
pub fn draw(frame: &mut Frame<'_>, picture: &Picture) {
    let area = frame.area();
    if area.width < SMALLEST.0 || area.height < SMALLEST.1 {
        frame.render_widget(Paragraph::new(short(picture)), area);
        return;
    }
    let scope = picture.scope.as_ref().filter(|_| area.height > SMALLEST.1);
    let scope_rows = u16::from(scope.is_some());
    let (strip_rows, event_rows) = shares(area.height - FIXED - scope_rows);
    let rows = [1, scope_rows, READINGS, strip_rows, 1 + SETTINGS, 1, event_rows, 1].map(Constraint::Length);
    let [head_at, scope_at, readings_at, strip_at, settings_at, rule_at, events_at, keys_at] =
        Layout::vertical(rows).areas(area);
    head(frame, head_at, picture);
    frame.render_widget(scope.map_or(Line::default(), |url| Line::from(format!("scope {url}"))), scope_at);
    frame.render_widget(Paragraph::new(readings(picture, area.width)), readings_at);
    if strip_rows > 0 {
        strip(frame, strip_at, picture);
    }
    settings(frame, settings_at, picture);
    frame.render_widget(rule("events", area.width), rule_at);
    frame.render_widget(Paragraph::new(events(picture, usize::from(event_rows))), events_at);
    frame.render_widget(keys(picture.phase, area.width), keys_at);
}

/// Rows of the strip, its rule among them, and of the events.
fn shares(left: u16) -> (u16, u16) {
    let events = (left / 3).clamp(2, 6);
    let strip = left - events;
    if strip > LOWEST_STRIP { (strip, events) } else { (0, left) }
}

/// What must be seen on the smallest screen: where it stands, and how it is stopped.
fn short(picture: &Picture) -> Vec<Line<'static>> {
    let mut lines = vec![Line::from(phase(picture)), "space EMERGENCY STOP  q stop".bold().into()];
    if let Some(r) = &picture.reading {
        lines.push(format!("tip {} of {}", degrees(r.psi_rad), degrees(r.reference_rad)).into());
        lines.push(format!("hub {}  deflection {}", degrees(r.theta_rad), degrees(r.alpha_rad)).into());
        lines.push(format!("{} V", fixed(r.voltage_v, 3)).into());
    }
    lines.extend(events(picture, 1));
    lines.push(format!("needs {} x {} for more", SMALLEST.0, SMALLEST.1).dim().into());
    lines
}

fn head(frame: &mut Frame<'_>, area: Rect, picture: &Picture) {
    let right = phase(picture);
    let width = right.iter().map(|span| span.width() as u16).sum();
    let [left_at, right_at] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(width)]).areas(area);
    let rate = engineering(1.0 / picture.period_s, 3, "Hz");
    let left = Line::from(vec![picture.controller.clone().bold(), format!("  {}  {rate}", picture.port).into()]);
    frame.render_widget(left, left_at);
    frame.render_widget(Line::from(right), right_at);
}

fn phase(picture: &Picture) -> Vec<Span<'static>> {
    let word = format!(" {} ", picture.phase.name().to_uppercase());
    let style = match picture.phase {
        Phase::Running => Style::new().fg(Color::Green),
        Phase::Armed | Phase::Configured => Style::new().fg(Color::Yellow),
        Phase::Stopped => Style::new(),
        Phase::Faulted => Style::new().fg(Color::Red),
    };
    let time = picture.reading.map_or(String::new(), |r| format!(" {:9.2} s", r.time_s));
    vec![Span::styled(word, style.add_modifier(Modifier::BOLD | Modifier::REVERSED)), time.into()]
}

/// A number with its bar.
struct Row {
    name: &'static str,
    number: String,
    /// The number as a part of the bar's end.
    part: f64,
    end: String,
    bar: Bar,
}

/// What the end of a bar is.
#[derive(PartialEq)]
enum Bar {
    Limit,
    Scale,
}

fn readings(picture: &Picture, width: u16) -> Vec<Line<'static>> {
    let (r, ends) = (picture.reading.unwrap_or_default(), picture.ends);
    let rows = [
        angle("reference", r.reference_rad, ends.angle_rad, Bar::Scale),
        angle("tip ψ", r.psi_rad, ends.angle_rad, Bar::Scale),
        angle("hub θ", r.theta_rad, ends.angle_rad, Bar::Scale),
        angle("deflection α", r.alpha_rad, ends.deflection_rad, Bar::Limit),
        angle("error", r.error_rad, ends.angle_rad, Bar::Scale),
        voltage("controller u", r.u_v, ends.voltage_v),
        voltage("voltage", r.voltage_v, ends.voltage_v),
    ];
    let known = picture.reading.is_some();
    rows.map(|row| if known { row } else { Row { number: "-".into(), ..row } }).map(|row| row.line(width)).into()
}

fn angle(name: &'static str, x_rad: f64, end_rad: f64, bar: Bar) -> Row {
    let end = format!("{:.0}°", end_rad.to_degrees());
    Row { name, number: degrees(x_rad), part: x_rad / end_rad, end, bar }
}

fn voltage(name: &'static str, x_v: f64, end_v: f64) -> Row {
    Row {
        name,
        number: format!("{} V", fixed(x_v, 3)),
        part: x_v / end_v,
        end: format!("{end_v:.0} V"),
        bar: Bar::Limit,
    }
}

impl Row {
    fn line(&self, width: u16) -> Line<'static> {
        let Row { name, number, part, end, .. } = self;
        let near = self.bar == Bar::Limit && part.abs() >= NEAR_THE_END;
        let style = if near { Style::new().fg(Color::Red) } else { Style::new() };
        let bar = Span::styled(bar(*part, usize::from(width).saturating_sub(36)), style);
        Line::from(vec![format!("{name:<13}{number:>11}  ").into(), bar, format!(" ±{end}").dim()])
    }
}

fn degrees(angle_rad: f64) -> String {
    format!("{}°", fixed(angle_rad.to_degrees(), 2))
}

/// So many decimals; a zero has no sign, which would flicker at rest.
fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if is_zero { text.trim_start_matches('-').into() } else { text }
}

/// The last seconds of tip and reference.
fn strip(frame: &mut Frame<'_>, area: Rect, picture: &Picture) {
    let [rule_at, chart_at] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    let title = format!("last {LENGTH_S:.0} s: tip ⠒⠒ reference ··");
    frame.render_widget(rule(&title, area.width), rule_at);
    let tip = picture.strip.curve(|point| point.psi_rad);
    let reference = picture.strip.curve(|point| point.reference_rad);
    let [low, high] = bounds(&[&tip, &reference]);
    let curves = vec![
        Dataset::default().data(&reference).marker(Marker::Custom('·')).style(Modifier::DIM),
        Dataset::default().data(&tip).marker(Marker::Braille).graph_type(GraphType::Line).style(Modifier::BOLD),
    ];
    let labels = [low, (low + high) / 2.0, high].map(|angle| format!("{angle:>6}°"));
    let (x, y) = (Axis::default().bounds([-LENGTH_S, 0.0]), Axis::default().bounds([low, high]).labels(labels));
    frame.render_widget(Chart::new(curves).x_axis(x).y_axis(y).legend_position(None), chart_at);
}

/// The settings in two columns, the clock beside them.
fn settings(frame: &mut Frame<'_>, area: Rect, picture: &Picture) {
    let third = area.width / 3;
    let columns = [Constraint::Length(2 * third), Constraint::Fill(1)];
    let [settings_at, clock_at] = Layout::horizontal(columns).areas(area);
    let rows = |k: usize| {
        let both = [k, k + usize::from(SETTINGS)].into_iter().flat_map(|k| setting(picture, k, usize::from(third)));
        Line::from(both.collect::<Vec<_>>())
    };
    let lines = [rule("settings", settings_at.width)].into_iter().chain((0..usize::from(SETTINGS)).map(rows));
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), settings_at);
    let lines = [rule("lateness", clock_at.width)].into_iter().chain(clock(picture));
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), clock_at);
}

/// One setting, marked when it is the selected one; a gap after it.
fn setting(picture: &Picture, k: usize, width: usize) -> Vec<Span<'static>> {
    let Some((name, value)) = picture.settings.get(k) else { return Vec::new() };
    let text = format!(" {name:<9}{value:>9} ");
    let gap = " ".repeat(width.saturating_sub(text.chars().count()));
    let style = if k == picture.selected { Style::new().reversed() } else { Style::new() };
    vec![Span::styled(text, style), gap.into()]
}

fn clock(picture: &Picture) -> Vec<Line<'static>> {
    let t = &picture.timing;
    let time = |name: &str, ns: u64| Line::from(format!("{name:<8}{:>9}", engineering(ns as f64 * 1e-9, 3, "s")));
    let count = |name: &str, n: u64| Line::from(format!("{name:<8}{n:>9}"));
    let silent = picture.reading.is_some_and(|reading| reading.stale);
    let stale = count(if silent { "silent" } else { "stale" }, t.stale);
    vec![
        time("median", t.median_ns),
        time("99 %", t.p99_ns),
        time("longest", t.max_ns),
        count("missed", t.missed),
        if silent { stale.fg(Color::Red).bold() } else { stale },
    ]
}

/// The newest events, one line each; hints are told when the run is over.
fn events(picture: &Picture, rows: usize) -> Vec<Line<'static>> {
    let newest = picture.events.iter().rev().take(rows).rev();
    let first_line = |text: &str| text.lines().next().unwrap_or_default().to_string();
    newest.map(|(time_s, text)| Line::from(format!("{time_s:9.3} s  {}", first_line(text)))).collect()
}

/// A line across, with a title in it.
fn rule(title: &str, width: u16) -> Line<'static> {
    let rest = usize::from(width).saturating_sub(title.chars().count() + 5);
    Line::from(format!("── {title} {} ", "─".repeat(rest))).dim()
}

fn keys(phase: Phase, width: u16) -> Line<'static> {
    let mut spans = vec!["space ".into(), "EMERGENCY STOP".bold(), "  q stop".into()];
    if phase == Phase::Armed {
        spans.push("  s START".bold());
    }
    spans.push(if width < 80 { "  ↑↓ ←→ set" } else { "  ↑↓ select  ←→ set  shift fine" }.into());
    // Both can be selected, too; the start cannot.
    if width >= 80 || phase != Phase::Armed {
        spans.push("  l law  r shape".into());
    }
    Line::from(spans)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::terminal::picture::{Ends, Reading};
    use crate::run::terminal::strip::{Point, Strip};
    use flexbeam_runtime::SeenTiming;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn picture() -> Picture {
        let mut strip = Strip::default();
        for k in 0..=500 {
            let time_s = f64::from(k) * 0.02;
            let psi_rad = (30.0 * (time_s - 4.0).clamp(0.0, 2.0) / 2.0).to_radians();
            strip.push(Point { time_s, reference_rad: if k < 200 { 0.0 } else { 30f64.to_radians() }, psi_rad });
        }
        let reading = Reading {
            time_s: 10.0,
            reference_rad: 30f64.to_radians(),
            psi_rad: 15f64.to_radians(),
            theta_rad: 16.5f64.to_radians(),
            alpha_rad: -1.5f64.to_radians(),
            error_rad: 0.25f64.to_radians(),
            u_v: -2.5,
            voltage_v: 9.5,
            stale: false,
        };
        let names = ["shape", "amplitude", "offset", "period", "smooth", "law", "u_p+", "u_p-", "eps_u", "eps_e"];
        Picture {
            controller: "controller.toml".into(),
            port: "udp:192.168.1.7:4810".into(),
            scope: None,
            period_s: 0.001,
            phase: Phase::Running,
            reading: Some(reading),
            ends: Ends { angle_rad: 40f64.to_radians(), deflection_rad: 30f64.to_radians(), voltage_v: 10.0 },
            settings: names.into_iter().zip((1..).map(|k| format!("{k}.5000 V"))).collect(),
            selected: 1,
            timing: SeenTiming {
                ticks: 10_000,
                median_ns: 21_800,
                p99_ns: 43_400,
                max_ns: 3_100_000,
                missed: 6,
                stale: 2,
            },
            strip,
            events: vec![(0.0, "armed: the clock runs, 0 V".into()), (9.5, "lost: 3 periods\nhint: none".into())],
        }
    }

    fn drawn(picture: &Picture, width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, picture)).unwrap();
        let buffer = terminal.backend().buffer();
        let row = |y: u16| (0..width).map(|x| buffer[(x, y)].symbol()).collect::<String>().trim_end().to_string();
        (0..height).map(row).collect()
    }

    #[test]
    fn every_number_has_its_place() {
        let expected = [
            "controller.toml  udp:192.168.1.7:4810  1.00 kHz             RUNNING      10.00 s",
            "reference         30.00°                       │━━━━━━━━━━━━━━━━      ±40°",
            "tip ψ             15.00°                       │━━━━━━━━              ±40°",
            "hub θ             16.50°                       │━━━━━━━━╸             ±40°",
            "deflection α      -1.50°                      ━│                      ±30°",
            "error              0.25°                       │                      ±40°",
            "controller u    -2.500 V                 ╺━━━━━│                      ±10 V",
            "voltage          9.500 V                       │━━━━━━━━━━━━━━━━━━━━  ±10 V",
            "── last 10 s: tip ⠒⠒ reference ·· ─────────────────────────────────────────────",
            "    30°│                            ············⢀⡤⠞⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉",
            "       │                                     ⢀⡤⠞⠁",
            "    15°│                                  ⢀⡤⠞⠁",
            "       │                               ⢀⡴⠚⠁",
            "     0°│⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⡴⠚⠁",
            "── settings ─────────────────────────────────────── ── lateness ───────────────",
            " shape     1.5000 V        law       6.5000 V       median    21.8 µs",
            " amplitude 2.5000 V        u_p+      7.5000 V       99 %      43.4 µs",
            " offset    3.5000 V        u_p-      8.5000 V       longest   3.10 ms",
            " period    4.5000 V        eps_u     9.5000 V       missed          6",
            " smooth    5.5000 V        eps_e    10.5000 V       stale           2",
            "── events ─────────────────────────────────────────────────────────────────────",
            "    0.000 s  armed: the clock runs, 0 V",
            "    9.500 s  lost: 3 periods",
            "space EMERGENCY STOP  q stop  ↑↓ select  ←→ set  shift fine  l law  r shape",
        ];
        assert_eq!(drawn(&picture(), 80, 24), expected);
    }

    #[test]
    fn the_smallest_whole_picture_leaves_out_the_strip_only() {
        let expected = [
            "controller.toml  udp:192.168.1.7:4810   RUNNING      10.00 s",
            "reference         30.00°             │━━━━━━━━╸   ±40°",
            "tip ψ             15.00°             │━━━━        ±40°",
            "hub θ             16.50°             │━━━━╸       ±40°",
            "deflection α      -1.50°            ╺│            ±30°",
            "error              0.25°             │            ±40°",
            "controller u    -2.500 V          ━━━│            ±10 V",
            "voltage          9.500 V             │━━━━━━━━━━╸ ±10 V",
            "── settings ─────────────────────────── ── lateness ───────",
            " shape     1.5000 V  law       6.5000 V median    21.8 µs",
            " amplitude 2.5000 V  u_p+      7.5000 V 99 %      43.4 µs",
            " offset    3.5000 V  u_p-      8.5000 V longest   3.10 ms",
            " period    4.5000 V  eps_u     9.5000 V missed          6",
            " smooth    5.5000 V  eps_e    10.5000 V stale           2",
            "── events ─────────────────────────────────────────────────",
            "    0.000 s  armed: the clock runs, 0 V",
            "    9.500 s  lost: 3 periods",
            "space EMERGENCY STOP  q stop  ↑↓ ←→ set  l law  r shape",
        ];
        assert_eq!(drawn(&picture(), 60, 18), expected);
    }

    #[test]
    fn the_scope_has_a_line_where_there_is_room() {
        let url = "http://127.0.0.1:8787/#abcdefghijklmnopqrstuvwxyz";
        let picture = Picture { scope: Some(url.into()), ..picture() };
        assert_eq!(drawn(&picture, 80, 24)[1], format!("scope {url}"));
        assert_eq!(drawn(&picture, 60, 19)[1], format!("scope {url}"));
        assert!(!drawn(&picture, 60, 18).concat().contains("scope"), "the events are more");
    }

    /// A terminal of any size shows how the run is stopped, as far as it has room for words.
    #[test]
    fn every_size_is_drawn() {
        let picture = Picture { scope: Some("http://127.0.0.1:8787/#token".into()), ..picture() };
        for (width, height) in (1..=130).step_by(3).flat_map(|w| (1..=50).map(move |h| (w, h))) {
            let rows = drawn(&picture, width, height);
            if width >= 28 && height >= 2 {
                assert!(rows.iter().any(|row| row.contains("EMERGENCY STOP  q stop")), "{width} x {height}: {rows:#?}");
            }
        }
    }

    #[test]
    fn before_the_first_sample_there_are_no_numbers() {
        let none = Picture { reading: None, phase: Phase::Armed, strip: Strip::default(), ..picture() };
        let rows = drawn(&none, 80, 24);
        assert!(rows[1].starts_with("reference              -  "), "{rows:#?}");
        assert!(rows[0].ends_with("ARMED") && rows[23].contains("s START"), "{rows:#?}");
    }

    #[test]
    fn a_zero_has_no_sign() {
        let found = [-0.0004, 0.0004, -0.0, -0.0006, -12.3456, f64::NAN].map(|x| fixed(x, 3));
        assert_eq!(found, ["0.000", "0.000", "0.000", "-0.001", "-12.346", "NaN"]);
    }

    #[test]
    fn a_bar_near_its_limit_is_red_and_silence_is_told() {
        let stale = Reading { stale: true, ..picture().reading.unwrap() };
        let picture = Picture { reading: Some(stale), ..picture() };
        let mut terminal = Terminal::new(TestBackend::new(80, 24)).unwrap();
        terminal.draw(|frame| draw(frame, &picture)).unwrap();
        let buffer = terminal.backend().buffer();
        let red = |y: u16| (0..80).filter(|x| buffer[(*x, y)].fg == Color::Red).count();
        assert_eq!((red(4), red(6), red(7)), (0, 0, 43), "deflection, controller u, voltage");
        assert!(red(19) > 0 && drawn(&picture, 60, 18)[13].contains("silent"));
    }
}
