//! Letters of pictures as outlines, from a font that the program brings with it: the same on every computer.

use std::fmt::Write;

use resvg::usvg::roxmltree::{self, Document, Node};
use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::{Face, FaceParsingError, GlyphId, OutlineBuilder};

use crate::svg::escape;

#[cfg(not(target_family = "wasm"))]
const FONT: &[u8] = include_bytes!("../vendor/dejavu/DejaVuSans.ttf");
/// In a browser only pictures without text are drawn, so that pages need no font.
#[cfg(target_family = "wasm")]
const FONT: &[u8] = &[];
/// The size of letters where none is given (`medium` in CSS) [px].
const MEDIUM: f64 = 16.0;
/// From this weight on letters are bold: 700 is `bold` in CSS, and pictures here ask for 600.
const BOLD: f64 = 600.0;

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct PictureError(pub String);

cotree::diagnostic::from_messages!(PictureError as PictureError: roxmltree::Error, resvg::usvg::Error, FaceParsingError);

/// A text of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    pub text: String,
    pub at: [f64; 2],
    /// What of its line is there.
    pub anchor: TextAnchor,
    /// Of the letters \[px\].
    pub size: f64,
    pub is_bold: bool,
}

/// A place on a line of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextAnchor {
    Start,
    Middle,
    End,
}

/// An SVG picture whose texts are paths, and what they say: the path of a text has the name that [`name`] gives it.
///
/// # Errors
/// It is no SVG picture, or the font is damaged.
pub fn outlined(svg: &str) -> Result<(String, Vec<Label>), PictureError> {
    let document = Document::parse(svg)?;
    let is_text = |node: &Node| node.has_tag_name("text");
    if !document.descendants().any(|node| is_text(&node)) {
        return Ok((svg.to_owned(), Vec::new()));
    }
    let font = Font::new()?;
    let (mut picture, mut labels, mut end) = (String::with_capacity(2 * svg.len()), Vec::new(), 0);
    for text in document.descendants().filter(is_text) {
        let (range, label) = (text.range(), Label::of(text));
        picture.push_str(&svg[end..range.start]);
        picture.push_str(&font.path(text, &label, labels.len()));
        labels.push(label);
        end = range.end;
    }
    picture.push_str(&svg[end..]);
    Ok((picture, labels))
}

/// What the path of a text is called in the picture.
pub fn name(index: usize) -> String {
    format!("letters-{index}")
}

impl Label {
    fn of(node: Node) -> Label {
        let number =
            |key: &str, otherwise: f64| node.attribute(key).and_then(|value| value.parse().ok()).unwrap_or(otherwise);
        let written: String = node.descendants().filter_map(|inner| inner.text().filter(|_| inner.is_text())).collect();
        Label {
            // Line breaks and further blanks are one blank in SVG.
            text: written.split_whitespace().collect::<Vec<_>>().join(" "),
            at: [number("x", 0.0), number("y", 0.0)],
            anchor: match node.attribute("text-anchor") {
                Some("middle") => TextAnchor::Middle,
                Some("end") => TextAnchor::End,
                _ => TextAnchor::Start,
            },
            size: number("font-size", MEDIUM),
            is_bold: number("font-weight", 0.0) >= BOLD || node.attribute("font-weight") == Some("bold"),
        }
    }
}

/// The font with what is needed of it. It has one weight and no slant.
struct Font {
    face: Face<'static>,
}

impl Font {
    fn new() -> Result<Font, PictureError> {
        Ok(Font { face: Face::parse(FONT, 0)? })
    }

    /// The glyphs of a text, each with its distance from the start of the line; and the length of the line.
    fn line(&self, text: &str) -> (Vec<(GlyphId, f64)>, f64) {
        let (mut glyphs, mut along): (Vec<(GlyphId, f64)>, f64) = (Vec::new(), 0.0);
        for letter in text.chars() {
            // The first glyph of a font stands for what it has not.
            let glyph = self.face.glyph_index(letter).unwrap_or_default();
            along += glyphs.last().map_or(0.0, |(before, _)| self.kerning(*before, glyph));
            glyphs.push((glyph, along));
            along += f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0));
        }
        (glyphs, along)
    }

    /// By how much two letters move apart.
    fn kerning(&self, first: GlyphId, second: GlyphId) -> f64 {
        let lookups = self.face.tables().gpos.iter().flat_map(|table| table.lookups);
        let mut pairs = lookups.flat_map(|lookup| lookup.subtables.into_iter::<PositioningSubtable>());
        let moved = pairs.find_map(|subtable| match subtable {
            PositioningSubtable::Pair(PairAdjustment::Format1 { coverage, sets }) => {
                sets.get(coverage.get(first)?)?.get(second).map(|(moved, _)| moved.x_advance)
            }
            PositioningSubtable::Pair(PairAdjustment::Format2 { coverage, classes, matrix }) => {
                coverage.get(first)?;
                matrix.get((classes.0.get(first), classes.1.get(second))).map(|(moved, _)| moved.x_advance)
            }
            _ => None,
        });
        moved.map_or(0.0, f64::from)
    }

    /// The path in place of a text, with the attributes that are not of letters.
    fn path(&self, node: Node, label: &Label, index: usize) -> String {
        let scale = label.size / f64::from(self.face.units_per_em());
        let (glyphs, length) = self.line(&label.text);
        let share = match label.anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => 0.5,
            TextAnchor::End => 1.0,
        };
        let mut outline = GlyphOutline { data: String::new(), at: label.at, scale };
        for (glyph, along) in glyphs {
            outline.at[0] = label.at[0] + scale * (along - share * length);
            self.face.outline_glyph(glyph, &mut outline);
        }
        let of_letters = ["x", "y", "text-anchor", "font-size", "font-weight", "font-style", "font-family"];
        let kept = node.attributes().filter(|attribute| !of_letters.contains(&attribute.name()));
        let kept: String =
            kept.map(|attribute| format!(" {}=\"{}\"", attribute.name(), escape(attribute.value()))).collect();
        format!("<path id=\"{}\" d=\"{}\"{kept}/>", name(index), outline.data)
    }
}

/// Outlines of glyphs as path data; in a font y points up.
struct GlyphOutline {
    data: String,
    at: [f64; 2],
    scale: f64,
}

impl GlyphOutline {
    fn add(&mut self, command: char, points: &[(f32, f32)]) {
        self.data.push(command);
        for (x, y) in points {
            let [x, y] = [self.at[0] + self.scale * f64::from(*x), self.at[1] - self.scale * f64::from(*y)];
            // Writing to a text cannot fail.
            let _ = write!(self.data, "{x:.3} {y:.3} ");
        }
    }
}

impl OutlineBuilder for GlyphOutline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.add('M', &[(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.add('L', &[(x, y)]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.add('Q', &[(x1, y1), (x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.add('C', &[(x1, y1), (x2, y2), (x, y)]);
    }

    fn close(&mut self) {
        self.data.push('Z');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_paths_where_they_were() {
        let svg = r##"<svg xmlns="http://www.w3.org/2000/svg"><rect id="a"/><text x="10" y="20" font-size="12" text-anchor="end"
            fill="#123456" transform="rotate(-90 10 20)">l &amp; l</text><g><text x="1" y="2" font-weight="600"> I  I </text></g></svg>"##;
        let (picture, labels) = outlined(svg).unwrap();
        let label = |text: &str, at, anchor, size, is_bold| Label { text: text.into(), at, anchor, size, is_bold };
        let expected = [
            label("l & l", [10.0, 20.0], TextAnchor::End, 12.0, false),
            label("I I", [1.0, 2.0], TextAnchor::Start, 16.0, true),
        ];
        assert_eq!(labels, expected);
        let document = Document::parse(&picture).unwrap();
        let paths: Vec<Node> = document.descendants().filter(|node| node.has_tag_name("path")).collect();
        assert_eq!((paths.len(), paths[0].attribute("id")), (2, Some("letters-0")));
        assert_eq!(paths[0].attribute("transform"), Some("rotate(-90 10 20)"));
        // The letter I of this font is an upright of 200 of 2048 units, 1493 high, after 201.
        let data = paths[1].attribute("d").unwrap();
        let unit = 16.0 / 2048.0;
        let corner = format!("M{:.3} {:.3} ", 1.0 + 201.0 * unit, 2.0 - 1493.0 * unit);
        assert!(data.starts_with(&corner), "{data} {corner}");
        assert_eq!(data.matches('Z').count(), 2);
    }
}
