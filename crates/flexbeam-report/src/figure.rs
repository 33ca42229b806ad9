//! The plot model: a figure is a stack of panels over one x axis.

use crate::error::Error;
use crate::scale::Scale;
use crate::series::{Marker, Series};
use crate::{drawing, png};

/// A figure: a title, one x axis, and one or several panels over it.
///
/// A legend stands above the panels and covers nothing; it is left out where the axis label says it all (one series).
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub(crate) title: String,
    pub(crate) x_label: String,
    pub(crate) x_scale: Scale,
    pub(crate) x_range: Option<(f64, f64)>,
    pub(crate) equal_aspect: bool,
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) panels: Vec<Panel>,
}

/// One coordinate system of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    pub(crate) y_label: String,
    pub(crate) y_scale: Scale,
    pub(crate) y_range: Option<(f64, f64)>,
    pub(crate) share: f64,
    pub(crate) series: Vec<Series>,
    pub(crate) marks: Vec<Mark>,
}

/// What stands beside the data: lines, regions, words.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mark {
    Vertical { x: f64, name: String },
    Horizontal { y: f64, name: String },
    Shade { from: f64, to: f64, name: String },
    Note { x: f64, y: f64, text: String },
}

impl Mark {
    /// What is written beside it.
    pub(crate) fn words(&self) -> &str {
        match self {
            Mark::Vertical { name, .. } | Mark::Horizontal { name, .. } | Mark::Shade { name, .. } => name,
            Mark::Note { text, .. } => text,
        }
    }
}

/// Size of a figure [px] that nobody chose: 16:9, readable across a page.
const SIZE: (f64, f64) = (800.0, 450.0);
/// Smallest size [px] at which labels still find room.
const SMALLEST: (f64, f64) = (240.0, 160.0);

impl Figure {
    /// A figure without panels, 800 x 450 px, on a linear x axis that fits the data. The title may be empty.
    pub fn new(title: &str, x_label: &str) -> Figure {
        Figure {
            title: title.into(),
            x_label: x_label.into(),
            x_scale: Scale::Linear,
            x_range: None,
            equal_aspect: false,
            width: SIZE.0,
            height: SIZE.1,
            panels: vec![],
        }
    }

    /// Adds a panel below the others.
    pub fn panel(mut self, panel: Panel) -> Figure {
        self.panels.push(panel);
        self
    }

    /// Size [px]; at least 240 x 160.
    pub fn size(self, width: f64, height: f64) -> Figure {
        Figure { width: width.max(SMALLEST.0), height: height.max(SMALLEST.1), ..self }
    }

    /// Kind of x axis.
    pub fn x_scale(self, scale: Scale) -> Figure {
        Figure { x_scale: scale, ..self }
    }

    /// A logarithmic x axis.
    pub fn log_x(self) -> Figure {
        self.x_scale(Scale::Log)
    }

    /// Ends of the x axis; what lies outside is cut off, and the y axes fit what remains.
    pub fn x_range(self, from: f64, to: f64) -> Figure {
        Figure { x_range: Some((from, to)), ..self }
    }

    /// One unit is as long upwards as it is sideways, as a pole map needs it. Linear axes and a single panel only.
    pub fn equal_aspect(self) -> Figure {
        Figure { equal_aspect: true, ..self }
    }

    /// The picture as SVG, the same text for the same figure. It can stand in a page as it is.
    pub fn svg(&self) -> String {
        drawing::svg(self)
    }

    /// The picture as PNG, `scale` pixels for each of the figure's (2 prints well).
    ///
    /// Errors: [`Error::Size`] for a scale that makes nothing, or too much; [`Error::Encoding`].
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, Error> {
        png::png_of_svg(&self.svg(), scale)
    }
}

impl Panel {
    /// An empty panel on a linear y axis that fits the data. The label names quantity and unit: `Tip angle ψ [deg]`.
    pub fn new(y_label: &str) -> Panel {
        let (series, marks) = (vec![], vec![]);
        Panel { y_label: y_label.into(), y_scale: Scale::Linear, y_range: None, share: 1.0, series, marks }
    }

    /// Kind of y axis.
    pub fn y_scale(self, scale: Scale) -> Panel {
        Panel { y_scale: scale, ..self }
    }

    /// A logarithmic y axis.
    pub fn log_y(self) -> Panel {
        self.y_scale(Scale::Log)
    }

    /// Ends of the y axis; what lies outside is cut off.
    pub fn y_range(self, from: f64, to: f64) -> Panel {
        Panel { y_range: Some((from, to)), ..self }
    }

    /// Height in proportion to the other panels; 1 otherwise.
    pub fn share(self, share: f64) -> Panel {
        Panel { share, ..self }
    }

    /// Adds a series.
    pub fn with(mut self, series: Series) -> Panel {
        self.series.push(series);
        self
    }

    /// Adds [`Series::line`].
    pub fn line(self, name: &str, x: &[f64], y: &[f64]) -> Panel {
        self.with(Series::line(name, x, y))
    }

    /// Adds [`Series::step`].
    pub fn step(self, name: &str, x: &[f64], y: &[f64]) -> Panel {
        self.with(Series::step(name, x, y))
    }

    /// Adds [`Series::stem`].
    pub fn stem(self, name: &str, x: &[f64], y: &[f64]) -> Panel {
        self.with(Series::stem(name, x, y))
    }

    /// Adds [`Series::markers`].
    pub fn markers(self, name: &str, x: &[f64], y: &[f64], marker: Marker) -> Panel {
        self.with(Series::markers(name, x, y, marker))
    }

    /// Adds [`Series::band`].
    pub fn band(self, name: &str, x: &[f64], lower: &[f64], upper: &[f64]) -> Panel {
        self.with(Series::band(name, x, lower, upper))
    }

    /// A line across the panel at x, with its name written along it. Outside the axis it is not drawn.
    pub fn vertical(self, x: f64, name: &str) -> Panel {
        self.mark(Mark::Vertical { x, name: name.into() })
    }

    /// A line across the panel at y, with its name written on it.
    pub fn horizontal(self, y: f64, name: &str) -> Panel {
        self.mark(Mark::Horizontal { y, name: name.into() })
    }

    /// A tinted region between two places on the x axis.
    pub fn shade(self, from: f64, to: f64, name: &str) -> Panel {
        self.mark(Mark::Shade { from, to, name: name.into() })
    }

    /// Words at a point, set to the side where they cover least.
    pub fn note(self, x: f64, y: f64, text: &str) -> Panel {
        self.mark(Mark::Note { x, y, text: text.into() })
    }

    fn mark(mut self, mark: Mark) -> Panel {
        self.marks.push(mark);
        self
    }
}
