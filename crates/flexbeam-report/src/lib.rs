//! Pictures and pages: plots as SVG and PNG, self-contained HTML reports, tables for the terminal.
//!
//! Enters: plain slices of numbers, names and units. Leaves: text and bytes; who calls writes the files.
//! Deliberately absent: anything of the domain. Nothing is computed here but where ink goes.
//!
//! ```
//! use flexbeam_report::{Figure, Panel};
//!
//! let t = [0.0, 0.5, 1.0];
//! let figure = Figure::new("Step response", "Time [s]")
//!     .panel(Panel::new("Tip angle ψ [deg]").line("measured", &t, &[0.0, 21.0, 30.0]).horizontal(30.0, "target"));
//! assert!(figure.svg().starts_with("<svg"));
//! ```

mod drawing;
mod error;
mod figure;
mod html;
mod layout;
mod number;
mod placement;
mod png;
mod scale;
mod series;
mod svg;
mod table;
mod typeface;

pub use error::Error;
pub use figure::{Figure, Panel};
pub use html::{Check, Report};
pub use number::{engineering, significant, typographic};
pub use png::png_of_svg;
pub use scale::{Axis, Scale, Tick, Ticks};
pub use series::{Colour, Dash, Marker, Series};
pub use table::{Cell, Column, Table, Verdict};
