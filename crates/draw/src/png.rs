//! Pictures as PNG files, the same on every computer.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

pub use crate::letters::PictureError;
use crate::letters::{Label, outlined};

/// The longest side that is drawn [px].
const LONGEST: f32 = 8000.0;

/// How large a picture becomes.
#[derive(Clone, Copy, Debug)]
pub enum Size {
    /// So many pixels for one of the picture.
    Times(f32),
    /// So many pixels for its longer side.
    Longer(f32),
    /// So many pixels for its width.
    Wide(f32),
}

/// An SVG picture as a PNG file.
///
/// # Errors
/// Why it cannot be drawn.
pub fn png(svg: &str, size: Size) -> Result<Vec<u8>, PictureError> {
    let (tree, _) = tree(svg)?;
    let longer = tree.size().width().max(tree.size().height());
    let scale = match size {
        Size::Times(scale) => scale.min(LONGEST / longer),
        Size::Longer(pixels) => pixels / longer,
        Size::Wide(pixels) => (pixels / tree.size().width()).min(LONGEST / longer),
    };
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| PictureError("it has no extent".to_owned()))?;
    let mut picture =
        Pixmap::new(size.width(), size.height()).ok_or_else(|| PictureError("it has no extent".to_owned()))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.encode_png().map_err(|error| PictureError(error.to_string()))
}

/// The shapes of an SVG picture, and its texts: each has a path of its own among the shapes ([`crate::letters::name`]).
///
/// # Errors
/// Why it cannot be read.
pub fn tree(svg: &str) -> Result<(Tree, Vec<Label>), PictureError> {
    let (picture, labels) = outlined(svg)?;
    Ok((Tree::from_str(&picture, &Options::default())?, labels))
}
