//! Where words may stand: beside lines, in regions, around points, where they cover least.

use crate::figure::Mark;
use crate::layout::{MARK, Placed, Rect};
use crate::typeface::{Weight, width};

type Points = Vec<(f64, f64)>;

/// Ends of a reference line [px].
pub(crate) fn line_of(placed: &Placed, mark: &Mark) -> Option<[(f64, f64); 2]> {
    let frame = placed.frame;
    match mark {
        Mark::Vertical { x, .. } if inside(placed.x.place(*x)) => {
            let across = placed.at(*x, placed.y.low()).0;
            Some([(across, frame.bottom()), (across, frame.y)])
        }
        Mark::Horizontal { y, .. } if inside(placed.y.place(*y)) => {
            let up = placed.at(placed.x.low(), *y).1;
            Some([(frame.x, up), (frame.right(), up)])
        }
        _ => None,
    }
}

fn inside(place: f64) -> bool {
    (0.0..=1.0).contains(&place)
}

/// The visible part of a shaded region [px].
pub(crate) fn shaded(placed: &Placed, from: f64, to: f64) -> Option<(f64, f64)> {
    let (a, b) = (placed.at(from, placed.y.low()).0, placed.at(to, placed.y.low()).0);
    let (left, right) = (a.min(b).max(placed.frame.x), a.max(b).min(placed.frame.right()));
    (right > left).then_some((left, right))
}

/// Points every few pixels along a polyline.
fn sampled(points: &[(f64, f64)]) -> Points {
    const EVERY: f64 = 4.0;
    const MOST: f64 = 400.0;
    let between = |pair: &[(f64, f64)]| {
        let (a, b) = (pair[0], pair[1]);
        let count = ((b.0 - a.0).hypot(b.1 - a.1) / EVERY).ceil().clamp(1.0, MOST) as usize;
        (0..count).map(move |k| k as f64 / count as f64).map(move |t| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)))
    };
    points.windows(2).flat_map(between).chain(points.last().copied()).collect()
}

/// What is free in a panel.
pub(crate) struct Room {
    frame: Rect,
    covered: Points,
    taken: Vec<Rect>,
}

impl Room {
    /// The room that the drawn polylines and the panel's own lines leave.
    pub(crate) fn beside(placed: &Placed, drawn: Vec<Points>) -> Room {
        let lines = placed.panel.marks.iter().filter_map(|mark| line_of(placed, mark)).map(|ends| ends.to_vec());
        let covered = drawn.into_iter().chain(lines).flat_map(|p| sampled(&p)).collect();
        Room { frame: placed.frame, covered, taken: vec![] }
    }

    /// Takes the best place for the words of a mark; none where they do not fit, or where there are none.
    pub(crate) fn take(&mut self, placed: &Placed, mark: &Mark) -> Option<Rect> {
        let places = match mark {
            Mark::Vertical { x, name } => along_vertical(placed, *x, name),
            Mark::Horizontal { y, name } => along_horizontal(placed, *y, name),
            Mark::Shade { from, to, name } => inside_shade(placed, *from, *to, name),
            Mark::Note { x, y, text } => around_point(placed, *x, *y, text),
        };
        let best = self.best(&places).filter(|_| !mark.words().is_empty())?;
        self.taken.push(best);
        Some(best)
    }

    /// The first place of those that cover least: nothing outside the frame, no other words, few data.
    fn best(&self, places: &[Rect]) -> Option<Rect> {
        const WORDS: usize = 1_000_000;
        let cost = |place: &Rect| {
            let words = self.taken.iter().filter(|other| other.overlaps(place)).count();
            words * WORDS + self.covered.iter().filter(|p| place.holds(**p)).count()
        };
        places.iter().filter(|place| self.frame.encloses(place)).min_by_key(|place| cost(place)).copied()
    }
}

const WORD_HEIGHT: f64 = MARK + 3.0;

fn along_vertical(placed: &Placed, x: f64, name: &str) -> Vec<Rect> {
    let (frame, length) = (placed.frame, width(name, MARK, Weight::Regular));
    let across = placed.x.place(x);
    if !inside(across) {
        return vec![];
    }
    let line = frame.x + across * frame.width;
    let ends = [frame.y + 4.0, frame.bottom() - length - 6.0, frame.y + (frame.height - length) / 2.0];
    let sides = [line + 2.0, line - 2.0 - WORD_HEIGHT];
    let place = |y: f64| sides.map(|x| Rect { x, y, width: WORD_HEIGHT, height: length });
    ends.into_iter().flat_map(place).collect()
}

fn along_horizontal(placed: &Placed, y: f64, name: &str) -> Vec<Rect> {
    let (frame, length) = (placed.frame, width(name, MARK, Weight::Regular));
    let up = placed.y.place(y);
    if !inside(up) {
        return vec![];
    }
    let line = frame.bottom() - up * frame.height;
    let ends = [frame.right() - length - 6.0, frame.x + 6.0, frame.x + (frame.width - length) / 2.0];
    let sides = [line - WORD_HEIGHT - 1.0, line + 2.0];
    let place = |x: f64| sides.map(|y| Rect { x, y, width: length, height: WORD_HEIGHT });
    ends.into_iter().flat_map(place).collect()
}

fn inside_shade(placed: &Placed, from: f64, to: f64, name: &str) -> Vec<Rect> {
    let (frame, length) = (placed.frame, width(name, MARK, Weight::Regular));
    let Some((left, right)) = shaded(placed, from, to) else { return vec![] };
    let middle = ((left + right - length) / 2.0).clamp(frame.x, (frame.right() - length).max(frame.x));
    let levels = [frame.y + 3.0, frame.bottom() - WORD_HEIGHT - 3.0, frame.y + 3.0 + WORD_HEIGHT];
    levels.map(|y| Rect { x: middle, y, width: length, height: WORD_HEIGHT }).to_vec()
}

fn around_point(placed: &Placed, x: f64, y: f64, text: &str) -> Vec<Rect> {
    const BESIDE: f64 = 7.0;
    let (at, length) = (placed.at(x, y), width(text, MARK, Weight::Regular));
    if at.0.is_nan() || at.1.is_nan() {
        return vec![];
    }
    let (right, left, middle) = (at.0 + BESIDE, at.0 - BESIDE - length, at.0 - length / 2.0);
    let (above, below, beside) = (at.1 - WORD_HEIGHT - 2.0, at.1 + 2.0, at.1 - WORD_HEIGHT / 2.0);
    let corners = [(right, above), (right, below), (left, above), (left, below), (right, beside), (left, beside)];
    let stacked = [(middle, above - 4.0), (middle, below + 4.0)];
    let places = corners.into_iter().chain(stacked);
    places.map(|(x, y)| Rect { x, y, width: length, height: WORD_HEIGHT }).collect()
}
