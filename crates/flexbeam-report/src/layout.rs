//! Where everything stands: margins from measured text, panels over one another, legends above them.

use crate::figure::{Figure, Mark, Panel};
use crate::scale::{Axis, Scale, Ticks};
use crate::series::{Colour, Series, Shape};
use crate::typeface::{Weight, width};

/// Sizes of text [px].
pub(crate) const TITLE: f64 = 15.0;
pub(crate) const LABEL: f64 = 13.0;
pub(crate) const TICK: f64 = 12.0;
pub(crate) const LEGEND: f64 = 12.5;
pub(crate) const MARK: f64 = 11.5;

/// Lengths [px].
pub(crate) const LINE_HEIGHT: f64 = 17.0;
pub(crate) const TICK_LENGTH: f64 = 4.0;
const SAMPLE: f64 = 24.0;
const SAMPLE_OF_POINTS: f64 = 10.0;
pub(crate) const SAMPLE_GAP: f64 = 7.0;
const ENTRY_GAP: f64 = 22.0;
const LEGEND_ROW: f64 = 20.0;
const EDGE: f64 = 12.0;
const PANEL_GAP: f64 = 18.0;
/// Between labels that follow one another upwards.
const AIR: f64 = 4.0;
const LEAST_RIGHT: f64 = 20.0;

/// Space beside the data, relative to their span.
const MARGIN: f64 = 0.06;
const MARGIN_OF_POINTS: f64 = 0.04;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl Rect {
    pub(crate) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    pub(crate) fn holds(&self, (x, y): (f64, f64)) -> bool {
        self.x <= x && x <= self.right() && self.y <= y && y <= self.bottom()
    }

    pub(crate) fn encloses(&self, other: &Rect) -> bool {
        self.holds((other.x, other.y)) && self.holds((other.right(), other.bottom()))
    }

    pub(crate) fn overlaps(&self, other: &Rect) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }
}

/// A legend entry: the series of one name, and where its sample begins.
pub(crate) struct Entry<'a> {
    pub x: f64,
    pub sample: f64,
    pub base: f64,
    pub series: Vec<&'a Series>,
}

/// A panel with its place on the sheet.
pub(crate) struct Placed<'a> {
    pub panel: &'a Panel,
    pub frame: Rect,
    pub x: Axis,
    pub y: Axis,
    pub x_ticks: Ticks,
    pub y_ticks: Ticks,
    pub y_label: Vec<String>,
    pub legend: Vec<Entry<'a>>,
}

impl Placed<'_> {
    /// Place [px] of a point; NaN where an axis has none. Far outside it stops, so that coordinates stay short.
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        const FAR: f64 = 50.0;
        let across = self.x.place(x).clamp(-FAR, FAR);
        let up = self.y.place(y).clamp(-FAR, FAR);
        (self.frame.x + across * self.frame.width, self.frame.bottom() - up * self.frame.height)
    }
}

/// The whole sheet.
pub(crate) struct Layout<'a> {
    pub panels: Vec<Placed<'a>>,
    pub colours: Vec<(&'a str, Colour)>,
}

impl<'a> Layout<'a> {
    pub(crate) fn of(figure: &'a Figure) -> Layout<'a> {
        let axes: Vec<(Axis, Axis)> = axes(figure);
        let legends = legends(figure);
        let above: Vec<f64> = axes.iter().zip(&legends).map(|((_, y), l)| above_panel(y, l, figure.width)).collect();
        let heights = panel_heights(figure, &above);
        let upwards: Vec<Ticks> = axes.iter().zip(&heights).map(|((_, y), h)| y_ticks(y, *h)).collect();
        let labels: Vec<_> =
            figure.panels.iter().zip(&heights).map(|(p, h)| lines(&p.y_label, h + PANEL_GAP - AIR)).collect();
        let left = left_margin(&upwards, &labels);
        let ticks = axes.first().map(|(x, _)| x_ticks(x, figure.width - left - LEAST_RIGHT));
        let right = ticks.as_ref().map_or(LEAST_RIGHT, right_margin);
        let mut top = top(figure);
        let mut panels = vec![];
        for (k, panel) in figure.panels.iter().enumerate() {
            let rows = legend_rows(&legends[k], figure.width);
            let first_base = top + LEGEND;
            let frame = Rect { x: left, y: top + above[k], width: figure.width - left - right, height: heights[k] };
            let (x, y) = if figure.equal_aspect && figure.panels.len() == 1 { equal(axes[k], &frame) } else { axes[k] };
            panels.push(Placed {
                panel,
                frame,
                x,
                y,
                x_ticks: x_ticks(&x, frame.width),
                y_ticks: y_ticks(&y, frame.height),
                y_label: labels[k].clone(),
                legend: placed_entries(rows, left, first_base),
            });
            top = frame.bottom() + PANEL_GAP;
        }
        Layout { panels, colours: colours(figure) }
    }

    /// The colour of a series: its own, or the one that belongs to its name.
    pub(crate) fn colour(&self, panel: &Panel, series: &Series) -> Colour {
        let unnamed = || panel.series.iter().filter(|s| s.name.is_empty() && s.colour.is_none());
        let named = || self.colours.iter().find(|(name, _)| *name == series.name).map(|(_, colour)| *colour);
        match series.colour {
            Some(colour) => colour,
            None if series.name.is_empty() => {
                let k = unnamed().position(|s| std::ptr::eq(s, series)).unwrap_or(0);
                Colour::PALETTE[k % Colour::PALETTE.len()]
            }
            None => named().unwrap_or(Colour::Blue),
        }
    }
}

/// Names, each with its colour: lines first, in the order of appearance, then bands. Chosen colours are not dealt out.
fn colours(figure: &Figure) -> Vec<(&str, Colour)> {
    let series = || figure.panels.iter().flat_map(|panel| &panel.series).filter(|s| !s.name.is_empty());
    let chosen: Vec<Colour> = series().filter_map(|s| s.colour).collect();
    let mut free = Colour::PALETTE.iter().copied().filter(|c| !chosen.contains(c)).collect::<Vec<_>>().into_iter();
    let mut colours: Vec<(&str, Colour)> = vec![];
    let is_band = |s: &&Series| matches!(s.shape, Shape::Band { .. });
    for s in series().filter(|s| !is_band(s)).chain(series().filter(is_band)) {
        if colours.iter().all(|(name, _)| *name != s.name) {
            let own = series().filter(|t| t.name == s.name).find_map(|t| t.colour);
            let dealt = own.or_else(|| free.next()).unwrap_or(Colour::PALETTE[colours.len() % Colour::PALETTE.len()]);
            colours.push((&s.name, dealt));
        }
    }
    colours
}

fn axes(figure: &Figure) -> Vec<(Axis, Axis)> {
    let x = x_axis(figure);
    figure.panels.iter().map(|panel| (x, y_axis(panel, &x))).collect()
}

fn x_axis(figure: &Figure) -> Axis {
    if let Some((from, to)) = figure.x_range {
        return Axis::new(figure.x_scale, from, to);
    }
    let points = |s: &Series| s.marker.is_some();
    let margin = if figure.panels.iter().flat_map(|p| &p.series).any(points) { MARGIN_OF_POINTS } else { 0.0 };
    Axis::fit(figure.x_scale, figure.panels.iter().flat_map(x_values), margin)
}

fn x_values(panel: &Panel) -> impl Iterator<Item = f64> {
    let marked = panel.marks.iter().flat_map(|mark| match mark {
        Mark::Vertical { x, .. } | Mark::Note { x, .. } => vec![*x],
        Mark::Shade { .. } | Mark::Horizontal { .. } => vec![],
    });
    panel.series.iter().flat_map(|s| s.x.iter().copied()).chain(marked)
}

fn y_axis(panel: &Panel, x: &Axis) -> Axis {
    match panel.y_range {
        Some((from, to)) => Axis::new(panel.y_scale, from, to),
        None => Axis::fit(panel.y_scale, y_values(panel, x), MARGIN),
    }
}

/// The values over the visible part of the x axis.
fn y_values<'a>(panel: &'a Panel, x: &'a Axis) -> impl Iterator<Item = f64> + 'a {
    const ROUNDING: f64 = 1e-9;
    let visible = |at: f64| (-ROUNDING..=1.0 + ROUNDING).contains(&x.place(at));
    let of_series = move |s: &'a Series| {
        let lower = match &s.shape {
            Shape::Band { lower } => lower.as_slice(),
            _ => &[],
        };
        let foot = (s.shape == Shape::Stem && panel.y_scale != Scale::Log).then_some(0.0);
        let over =
            move |values: &'a [f64]| s.x.iter().zip(values).filter(move |(at, _)| visible(**at)).map(|(_, y)| *y);
        over(&s.y).chain(over(lower)).chain(foot)
    };
    let marked = panel.marks.iter().filter_map(|mark| match mark {
        Mark::Horizontal { y, .. } | Mark::Note { y, .. } => Some(*y),
        Mark::Vertical { .. } | Mark::Shade { .. } => None,
    });
    panel.series.iter().flat_map(of_series).chain(marked)
}

/// The same unit per pixel both ways: the axis with the smaller one is widened about its middle.
fn equal((x, y): (Axis, Axis), frame: &Rect) -> (Axis, Axis) {
    let per_px = ((x.high() - x.low()) / frame.width).max((y.high() - y.low()) / frame.height);
    let widened = |axis: Axis, length: f64| {
        let (middle, half) = ((axis.low() + axis.high()) / 2.0, per_px * length / 2.0);
        Axis::new(axis.scale(), middle - half, middle + half)
    };
    (widened(x, frame.width), widened(y, frame.height))
}

/// As many ticks as the height carries; where not even three labels stand apart, those that do.
fn y_ticks(y: &Axis, height: f64) -> Ticks {
    const SPACING: f64 = 30.0;
    let mut ticks = y.ticks((height / SPACING).clamp(3.0, 10.0) as usize);
    let mut last = f64::NEG_INFINITY;
    ticks.major.retain(|tick| {
        let at = y.place(tick.value) * height;
        let apart = at - last >= TICK;
        if apart {
            last = at;
        }
        apart
    });
    ticks
}

/// As many ticks as the length carries with air between the labels.
fn x_ticks(x: &Axis, length: f64) -> Ticks {
    const AIR: f64 = 16.0;
    let fits = |ticks: &Ticks| {
        let places: Vec<(f64, f64)> =
            ticks.major.iter().map(|t| (x.place(t.value) * length, width(&t.label, TICK, Weight::Regular))).collect();
        places.windows(2).all(|p| p[1].0 - p[0].0 >= (p[0].1 + p[1].1) / 2.0 + AIR)
    };
    let most = if x.scale() == Scale::Integer { 25 } else { 11 };
    (3..=most).rev().map(|most| x.ticks(most)).find(fits).unwrap_or_else(|| x.ticks(3))
}

fn left_margin(ticks: &[Ticks], labels: &[Vec<String>]) -> f64 {
    let measured = |words: &str| width(words, TICK, Weight::Regular);
    let of_axis = |t: &Ticks| t.major.iter().map(|t| measured(&t.label)).fold(measured(&exponent(t)), f64::max);
    let numbers = ticks.iter().map(of_axis).fold(0.0, f64::max);
    let lines = labels.iter().map(Vec::len).max().unwrap_or(0);
    EDGE + lines as f64 * LINE_HEIGHT + 6.0 + numbers + 2.0 * TICK_LENGTH
}

/// What stands at the end of an axis whose labels are to be multiplied: `×10⁻⁶`, or nothing.
pub(crate) fn exponent(ticks: &Ticks) -> String {
    match ticks.exponent {
        0 => String::new(),
        exponent => format!("×{}", crate::typographic(&format!("1e{exponent}"))),
    }
}

fn right_margin(ticks: &Ticks) -> f64 {
    let last = ticks.major.last().map_or(0.0, |t| width(&t.label, TICK, Weight::Regular));
    LEAST_RIGHT.max(last / 2.0 + 6.0)
}

fn top(figure: &Figure) -> f64 {
    if figure.title.is_empty() { EDGE + 4.0 } else { EDGE + TITLE + 15.0 }
}

/// Axis label in one line, or broken between words where it is too long for the panel.
fn lines(label: &str, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in label.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match longer.filter(|line| width(line, LABEL, Weight::Regular) <= room) {
            Some(line) => *lines.last_mut().expect("there is a line to make longer") = line,
            None => lines.push(word.into()),
        }
    }
    lines
}

/// Height that the legend, or the exponent of the y axis, needs above a panel.
fn above_panel(y: &Axis, legend: &[Vec<&Series>], sheet: f64) -> f64 {
    const TYPICAL_TICKS: usize = 6;
    let exponent = if y.ticks(TYPICAL_TICKS).exponent == 0 { 0.0 } else { LINE_HEIGHT };
    exponent.max(legend_rows(legend, sheet).len() as f64 * LEGEND_ROW)
}

fn panel_heights(figure: &Figure, above: &[f64]) -> Vec<f64> {
    const SMALLEST: f64 = 20.0;
    let below = EDGE + TICK_LENGTH + LINE_HEIGHT + if figure.x_label.is_empty() { 0.0 } else { LINE_HEIGHT + 6.0 };
    let gaps = figure.panels.len().saturating_sub(1) as f64 * PANEL_GAP;
    let room = figure.height - top(figure) - below - gaps - above.iter().sum::<f64>();
    let shares: f64 = figure.panels.iter().map(|p| p.share).sum();
    figure.panels.iter().map(|p| (room * p.share / shares).max(SMALLEST)).collect()
}

/// For each panel the entries that no panel above it has shown; none where a panel has one name only.
fn legends(figure: &Figure) -> Vec<Vec<Vec<&Series>>> {
    let mut shown: Vec<&str> = vec![];
    let of_panel = |panel| {
        let entries = entries(panel);
        let alone = entries.len() < 2;
        let fresh: Vec<_> = entries.into_iter().filter(|e| !alone && !shown.contains(&e[0].name.as_str())).collect();
        shown.extend(fresh.iter().map(|e| e[0].name.as_str()));
        fresh
    };
    figure.panels.iter().map(of_panel).collect()
}

fn entries(panel: &Panel) -> Vec<Vec<&Series>> {
    let mut entries: Vec<Vec<&Series>> = vec![];
    for s in panel.series.iter().filter(|s| !s.name.is_empty()) {
        match entries.iter_mut().find(|entry| entry[0].name == s.name) {
            Some(entry) => entry.push(s),
            None => entries.push(vec![s]),
        }
    }
    entries
}

/// Width of the sample before a name.
fn sample_width(entry: &[&Series]) -> f64 {
    if entry.iter().all(|s| s.shape == Shape::Markers) { SAMPLE_OF_POINTS } else { SAMPLE }
}

fn entry_width(entry: &[&Series]) -> f64 {
    sample_width(entry) + SAMPLE_GAP + width(&entry[0].name, LEGEND, Weight::Regular)
}

/// Entries in rows that fit the sheet.
fn legend_rows<'a>(entries: &[Vec<&'a Series>], sheet: f64) -> Vec<Vec<Vec<&'a Series>>> {
    const MARGINS: f64 = 120.0;
    let mut rows: Vec<Vec<Vec<&Series>>> = vec![];
    let mut used = f64::INFINITY;
    for entry in entries {
        let needed = entry_width(entry) + ENTRY_GAP;
        if used + needed > sheet - MARGINS {
            rows.push(vec![]);
            used = 0.0;
        }
        used += needed;
        rows.last_mut().expect("the first entry opens a row").push(entry.clone());
    }
    rows
}

fn placed_entries<'a>(rows: Vec<Vec<Vec<&'a Series>>>, left: f64, first_base: f64) -> Vec<Entry<'a>> {
    let mut placed = vec![];
    for (row, entries) in rows.into_iter().enumerate() {
        let (mut x, base) = (left, first_base + row as f64 * LEGEND_ROW - 4.0);
        for series in entries {
            let next = x + entry_width(&series) + ENTRY_GAP;
            placed.push(Entry { x, sample: sample_width(&series), base, series });
            x = next;
        }
    }
    placed
}
