//! `model.png`: the drawing as a small picture for the tools' libraries. It has no text: names would be too small to read.

use cotree::export::ExportError;
use cotree_draw::drawing::Drawing;
use cotree_draw::png::{self, Size};

/// The longer side [px].
const SIZE: f32 = 320.0;

/// The picture as a PNG file.
pub fn png(drawing: &Drawing) -> Result<Vec<u8>, ExportError> {
    png::png(&drawing.svg_without_names(), Size::Longer(SIZE))
        .map_err(|error| ExportError(format!("cannot draw model.png: {error}")))
}
