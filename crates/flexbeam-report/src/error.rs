/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The text handed to the PNG writer is no SVG.
    #[error("tried to draw an SVG of {bytes} bytes as PNG, found that it does not parse: {cause}")]
    Svg {
        /// Length of the text.
        bytes: usize,
        /// What the parser said.
        cause: String,
    },
    /// The picture would be empty or larger than memory should bear.
    #[error(
        "tried to draw a PNG of {width} x {height} pixels, needed 1 to {largest} in each direction\nhint: choose another scale"
    )]
    Size {
        /// Width [pixels].
        width: f64,
        /// Height [pixels].
        height: f64,
        /// Largest width or height that is drawn.
        largest: u32,
    },
    /// The PNG encoder failed.
    #[error("tried to encode a PNG: {cause}")]
    Encoding {
        /// What the encoder said.
        cause: String,
    },
}
