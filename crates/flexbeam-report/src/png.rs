//! SVG drawn into pixels, with the shipped typeface and no other.

use crate::error::Error;
use crate::typeface;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::{Arc, LazyLock};

/// Largest width and height: a picture of this size squared takes a gigabyte.
const LARGEST: u32 = 16_384;

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    typeface::FACES.iter().for_each(|face| fonts.load_font_data(face.to_vec()));
    fonts.set_sans_serif_family("Noto Sans");
    Arc::new(fonts)
});

/// PNG of an SVG, `scale` pixels for each of its own.
///
/// Errors: [`Error::Svg`], [`Error::Size`], [`Error::Encoding`].
pub fn png_of_svg(svg: &str, scale: f64) -> Result<Vec<u8>, Error> {
    let options = Options { fontdb: FONTS.clone(), font_family: "Noto Sans".into(), ..Options::default() };
    let bytes = svg.len();
    let tree = Tree::from_str(svg, &options).map_err(|cause| Error::Svg { bytes, cause: cause.to_string() })?;
    let mut canvas = canvas(f64::from(tree.size().width()) * scale, f64::from(tree.size().height()) * scale)?;
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut canvas.as_mut());
    canvas.encode_png().map_err(|cause| Error::Encoding { cause: cause.to_string() })
}

fn canvas(width: f64, height: f64) -> Result<Pixmap, Error> {
    let wrong = Error::Size { width, height, largest: LARGEST };
    let drawable = 1.0..=f64::from(LARGEST);
    if !(drawable.contains(&width.round()) && drawable.contains(&height.round())) {
        return Err(wrong);
    }
    Pixmap::new(width.round() as u32, height.round() as u32).ok_or(wrong)
}
