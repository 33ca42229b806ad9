//! What is drawn in a panel: curves, steps, stems, markers, bands.

/// Colours that people with colour-blindness tell apart (after Okabe and Ito, darkened for thin lines on white).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// The first choice.
    Blue,
    /// Orange red.
    Vermilion,
    /// Bluish green.
    Green,
    /// Reddish purple.
    Purple,
    /// Yellowish orange.
    Amber,
    /// Light blue.
    Sky,
    /// Nearly black.
    Ink,
    /// For what stands behind: ideals, references.
    Grey,
}

impl Colour {
    /// The order in which series get their colours.
    pub(crate) const PALETTE: [Colour; 7] =
        [Colour::Blue, Colour::Vermilion, Colour::Green, Colour::Purple, Colour::Amber, Colour::Sky, Colour::Ink];

    pub(crate) fn css(self) -> &'static str {
        match self {
            Colour::Blue => "#1f5fa8",
            Colour::Vermilion => "#cc4e12",
            Colour::Green => "#00805c",
            Colour::Purple => "#a8508a",
            Colour::Amber => "#c98a00",
            Colour::Sky => "#4fa3d8",
            Colour::Ink => "#222222",
            Colour::Grey => "#8a8a8a",
        }
    }
}

/// How a line is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Dash {
    /// Not at all.
    #[default]
    Solid,
    /// Long strokes.
    Dashed,
    /// Points.
    Dotted,
    /// Both in turn.
    DashDot,
}

impl Dash {
    /// The pattern, in line widths; every line is drawn with butt ends except the solid one.
    pub(crate) fn pattern(self) -> Option<[f64; 4]> {
        match self {
            Dash::Solid => None,
            Dash::Dashed => Some([4.5, 2.6, 4.5, 2.6]),
            Dash::Dotted => Some([1.2, 1.8, 1.2, 1.8]),
            Dash::DashDot => Some([5.0, 2.2, 1.2, 2.2]),
        }
    }
}

/// The sign that marks a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Filled circle.
    Disc,
    /// Open circle, as zeros are drawn.
    Circle,
    /// x, as poles are drawn.
    Cross,
    /// +
    Plus,
    /// Open square.
    Square,
    /// Filled diamond.
    Diamond,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    Line,
    Step,
    Stem,
    Markers,
    Band { lower: Vec<f64> },
}

/// A series: points, and how they are drawn.
///
/// A value that has no place on its axis (NaN, infinite, not positive on a logarithmic axis) breaks the line. A name that
/// is not empty appears in the legend and owns a colour: series of the same name look alike in every panel of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) colour: Option<Colour>,
    pub(crate) dash: Dash,
    pub(crate) width: f64,
    pub(crate) marker: Option<Marker>,
}

/// Ordinary line width [px].
const LINE_WIDTH: f64 = 1.6;

impl Series {
    /// A curve through the points.
    ///
    /// Shapes: x and y equally long; panics otherwise, as every constructor here does.
    pub fn line(name: &str, x: &[f64], y: &[f64]) -> Series {
        Series::new(name, Shape::Line, x, y)
    }

    /// Each value held until the next one, as a converter does.
    pub fn step(name: &str, x: &[f64], y: &[f64]) -> Series {
        Series::new(name, Shape::Step, x, y)
    }

    /// A stem from zero (on a logarithmic axis from its lower end) to each point.
    pub fn stem(name: &str, x: &[f64], y: &[f64]) -> Series {
        Series { marker: Some(Marker::Disc), ..Series::new(name, Shape::Stem, x, y) }
    }

    /// The points alone.
    pub fn markers(name: &str, x: &[f64], y: &[f64], marker: Marker) -> Series {
        Series { marker: Some(marker), ..Series::new(name, Shape::Markers, x, y) }
    }

    /// The region between two curves.
    pub fn band(name: &str, x: &[f64], lower: &[f64], upper: &[f64]) -> Series {
        assert_eq!(x.len(), lower.len(), "band {name:?}: as many lower ends as places");
        Series::new(name, Shape::Band { lower: lower.to_vec() }, x, upper)
    }

    fn new(name: &str, shape: Shape, x: &[f64], y: &[f64]) -> Series {
        assert_eq!(x.len(), y.len(), "series {name:?}: as many values as places");
        let (colour, dash, width, marker) = (None, Dash::Solid, LINE_WIDTH, None);
        Series { name: name.into(), shape, x: x.to_vec(), y: y.to_vec(), colour, dash, width, marker }
    }

    /// In this colour instead of the next free one.
    pub fn colour(self, colour: Colour) -> Series {
        Series { colour: Some(colour), ..self }
    }

    /// With a broken line.
    pub fn dash(self, dash: Dash) -> Series {
        Series { dash, ..self }
    }

    /// With a line of this width [px]; 1.6 otherwise.
    pub fn width(self, width: f64) -> Series {
        Series { width, ..self }
    }

    /// With each point marked.
    pub fn marker(self, marker: Marker) -> Series {
        Series { marker: Some(marker), ..self }
    }
}

/// The polyline cut where a coordinate is not a number.
pub(crate) fn unbroken(points: &[(f64, f64)]) -> impl Iterator<Item = &[(f64, f64)]> {
    points.split(|(x, y)| x.is_nan() || y.is_nan()).filter(|part| !part.is_empty())
}

/// The polyline [px] with at most four points a pixel column: where it enters, its lowest, its highest, where it leaves.
///
/// It covers the same pixels. Consecutive points count, so a curve that turns back keeps its way.
pub(crate) fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = Vec::with_capacity(points.len().min(1 << 13));
    for column in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let by = |best: fn(f64, f64) -> bool| {
            (1..column.len()).fold(0, |k, i| if best(column[i].1, column[k].1) { i } else { k })
        };
        let mut corners = [0, by(|new, old| new < old), by(|new, old| new > old), column.len() - 1];
        corners.sort_unstable();
        let distinct = (0..4).filter(|k| *k == 0 || corners[*k] != corners[*k - 1]);
        kept.extend(distinct.map(|k| column[corners[k]]));
    }
    kept
}

/// The corners of the held values.
pub(crate) fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut corners = Vec::with_capacity(2 * points.len());
    for pair in points.windows(2) {
        corners.extend([pair[0], (pair[1].0, pair[0].1)]);
    }
    corners.extend(points.last());
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nan_breaks_the_line() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, 1.0), (f64::NAN, 0.0)];
        let parts: Vec<usize> = unbroken(&points).map(<[_]>::len).collect();
        assert_eq!(parts, [1, 2]);
    }

    #[test]
    fn stairs_hold_each_value() {
        assert_eq!(stairs(&[(0.0, 1.0), (1.0, 3.0)]), [(0.0, 1.0), (1.0, 1.0), (1.0, 3.0)]);
        assert_eq!(stairs(&[]), []);
    }

    proptest! {
        #[test]
        fn thinning_keeps_the_extremes_of_every_column(y in prop::collection::vec(-50.0f64..50.0, 1..4000), columns in 1.0f64..300.0) {
            let points: Vec<_> = y.iter().enumerate().map(|(k, y)| (k as f64 * columns / y.abs().max(4000.0), *y)).collect();
            let kept = thinned(&points);
            let extremes = |points: &[(f64, f64)]| -> Vec<(f64, f64, f64)> {
                let runs = points.chunk_by(|a, b| a.0.floor() == b.0.floor());
                runs.map(|run| run.iter().fold((run[0].0.floor(), f64::MAX, f64::MIN), |e, p| (e.0, e.1.min(p.1), e.2.max(p.1)))).collect()
            };
            prop_assert_eq!(extremes(&points), extremes(&kept));
            prop_assert!(kept.len() <= 4 * extremes(&points).len());
            prop_assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        }
    }
}
