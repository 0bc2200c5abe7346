//! `model.png`: the drawing as a small picture for the tools' libraries. It has no text: names would be too small to
//! read, and which fonts there are differs between computers.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use super::ExportError;
use crate::output::drawing::Drawing;

/// The longer side [px].
const SIZE: f32 = 320.0;

/// The picture as a PNG file.
pub fn png(drawing: &Drawing) -> Result<Vec<u8>, ExportError> {
    let tree = Tree::from_str(&drawing.svg(), &Options::default()).map_err(|error| failed(&error))?;
    let scale = SIZE / tree.size().width().max(tree.size().height());
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| failed(&"it has no extent"))?;
    let mut picture = Pixmap::new(size.width(), size.height()).ok_or_else(|| failed(&"it has no extent"))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.encode_png().map_err(|error| failed(&error))
}

fn failed(why: &dyn std::fmt::Display) -> ExportError {
    ExportError::Picture(why.to_string())
}
