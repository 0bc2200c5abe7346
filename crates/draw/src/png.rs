//! Pictures as PNG files, with the letters of a font that the program brings with it: the same on every computer.

#[cfg(not(target_family = "wasm"))]
use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
#[cfg(not(target_family = "wasm"))]
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};

#[cfg(not(target_family = "wasm"))]
const LETTERS: &[u8] = include_bytes!("../vendor/dejavu/DejaVuSans.ttf");
#[cfg(not(target_family = "wasm"))]
const FAMILY: &str = "DejaVu Sans";
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
pub fn png(svg: &str, size: Size) -> Result<Vec<u8>, String> {
    let tree = tree(svg)?;
    let longer = tree.size().width().max(tree.size().height());
    let scale = match size {
        Size::Times(scale) => scale.min(LONGEST / longer),
        Size::Longer(pixels) => pixels / longer,
        Size::Wide(pixels) => (pixels / tree.size().width()).min(LONGEST / longer),
    };
    let empty = || "it has no extent".to_string();
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(empty)?;
    let mut picture = Pixmap::new(size.width(), size.height()).ok_or_else(empty)?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.encode_png().map_err(|error| error.to_string())
}

/// The shapes and texts of an SVG picture.
///
/// # Errors
/// Why it cannot be read.
pub fn tree(svg: &str) -> Result<Tree, String> {
    Tree::from_str(svg, &options()).map_err(|error| error.to_string())
}

/// With the letters of the font.
#[cfg(not(target_family = "wasm"))]
fn options() -> Options<'static> {
    let mut letters = Database::new();
    letters.load_font_data(LETTERS.to_vec());
    letters.set_sans_serif_family(FAMILY);
    letters.set_serif_family(FAMILY);
    letters.set_monospace_family(FAMILY);
    Options { fontdb: Arc::new(letters), font_family: FAMILY.to_string(), ..Options::default() }
}

/// In a browser only pictures without text are drawn.
#[cfg(target_family = "wasm")]
fn options() -> Options<'static> {
    Options::default()
}
