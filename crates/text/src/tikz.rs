//! Converts paths and texts of an SVG picture to TikZ commands for LaTeX.

use std::collections::HashMap;
use std::fmt::Write;

use cotree_draw::letters::{self, Label, TextAnchor};
use cotree_draw::png::{self, PictureError};
use resvg::tiny_skia::{PathSegment, Point, Transform};
use resvg::usvg::{Group, Node, Paint, Path};

use crate::latex_text;

/// The widest picture, in points of TeX.
const WIDEST: f32 = 470.0;
/// TeX's points for a pixel of the picture.
const POINT: f32 = 0.7;

/// The picture in an environment `tikzpicture`.
///
/// # Errors
/// Why it cannot be read.
pub fn tikz(svg: &str) -> Result<String, PictureError> {
    let (tree, labels) = png::tree(svg)?;
    let labels = labels.into_iter().enumerate().map(|(index, label)| (letters::name(index), label)).collect();
    let scale = (WIDEST / tree.size().width()).min(POINT);
    let mut text = format!("\\begin{{tikzpicture}}[x={scale:.4}pt,y=-{scale:.4}pt]\n");
    group(tree.root(), &labels, scale, &mut text);
    text.push_str("\\end{tikzpicture}\n");
    Ok(text)
}

fn group(parent: &Group, labels: &HashMap<String, Label>, scale: f32, out: &mut String) {
    for node in parent.children() {
        match node {
            Node::Group(inner) => group(inner, labels, scale, out),
            Node::Path(inner) => match labels.get(inner.id()) {
                Some(label) => words(inner, label, scale, out),
                None => path(inner, scale, out),
            },
            Node::Text(_) | Node::Image(_) => {} // drawings have none
        }
    }
}

fn path(path: &Path, scale: f32, out: &mut String) {
    let mut style = Vec::new();
    if let Some(colour) = path.fill().and_then(|fill| colour(fill.paint())) {
        style.push(format!("fill={colour}"));
    }
    if let Some(stroke) = path.stroke() {
        let width = stroke.width().get() * scale;
        let colour = colour(stroke.paint()).unwrap_or_else(|| "black".to_owned());
        style.push(format!("draw={colour},line width={width:.2}pt"));
        if let Some(dashes) = stroke.dasharray() {
            let lengths = dashes.chunks(2).map(|pair| match pair {
                [on, off] => format!("on {:.2}pt off {:.2}pt", on * scale, off * scale),
                _ => String::new(),
            });
            style.push(format!("dash pattern={}", lengths.collect::<Vec<_>>().join(" ")));
        }
    }
    if style.is_empty() {
        return;
    }
    // Writing to a string cannot fail.
    let _ = writeln!(out, "\\path[{}]{};", style.join(","), segments(path));
}

fn segments(path: &Path) -> String {
    let at = |point: Point| place(path.abs_transform(), point);
    let (mut text, mut before) = (String::new(), Point::zero());
    for segment in path.data().segments() {
        match segment {
            PathSegment::MoveTo(to) => {
                text += &format!(" {}", at(to));
                before = to;
            }
            PathSegment::LineTo(to) => {
                text += &format!(" -- {}", at(to));
                before = to;
            }
            PathSegment::QuadTo(over, to) => {
                // A cubic curve with the same shape.
                let control = |end: Point| {
                    Point::from_xy(end.x + (over.x - end.x) * 2.0 / 3.0, end.y + (over.y - end.y) * 2.0 / 3.0)
                };
                text += &format!(" .. controls {} and {} .. {}", at(control(before)), at(control(to)), at(to));
                before = to;
            }
            PathSegment::CubicTo(first, second, to) => {
                text += &format!(" .. controls {} and {} .. {}", at(first), at(second), at(to));
                before = to;
            }
            PathSegment::Close => text += " -- cycle",
        }
    }
    text
}

/// A text, which has an outline in the picture; its white edge is left out.
fn words(outline: &Path, label: &Label, scale: f32, out: &mut String) {
    let Some(colour) = outline.fill().and_then(|fill| colour(fill.paint())) else { return };
    let anchor = match label.anchor {
        TextAnchor::Start => "base west",
        TextAnchor::Middle => "base",
        TextAnchor::End => "base east",
    };
    let [x, y] = label.at.map(|at| at as f32);
    let at = place(outline.abs_transform(), Point::from_xy(x, y));
    let size = label.size as f32 * scale;
    let bold = if label.is_bold { "\\bfseries" } else { "" };
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "\\node[anchor={anchor},inner sep=0,text={colour},font=\\fontsize{{{size:.2}}}{{{size:.2}}}\\selectfont\\sffamily{bold}] at {at} \
         {{{}}};",
        latex_text(&label.text)
    );
}

fn place(transform: Transform, mut point: Point) -> String {
    transform.map_point(&mut point);
    format!("({:.2},{:.2})", point.x, point.y)
}

fn colour(paint: &Paint) -> Option<String> {
    match paint {
        Paint::Color(color) => Some(format!("{{rgb,255:red,{};green,{};blue,{}}}", color.red, color.green, color.blue)),
        _ => None,
    }
}
