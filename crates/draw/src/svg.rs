//! Just enough SVG to draw a mechanism and a plot.

use std::fmt::Write;

use crate::carrier::Carrier;

/// A point of the picture \[px\], y down.
pub type Pixel = [f64; 2];

/// Readable on any system; no font is embedded.
pub const FONT: &str = "Inter, 'Segoe UI', 'Helvetica Neue', Helvetica, Arial, sans-serif";

/// An SVG picture under way. Styles are attributes, such as `fill="none"`.
#[derive(Clone, Debug, Default)]
pub struct Svg {
    elements: String,
    /// From which byte of the elements on what carries them.
    carriers: Vec<(usize, Carrier)>,
}

/// A rectangle of the picture \[px\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureFrame {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl PictureFrame {
    pub fn centred([x, y]: Pixel, width: f64, height: f64) -> Self {
        PictureFrame { x: x - 0.5 * width, y: y - 0.5 * height, width, height }
    }

    /// The box around others.
    pub fn around<'a>(frames: impl Iterator<Item = &'a PictureFrame> + Clone) -> Self {
        let low = |pick: fn(&PictureFrame) -> f64| frames.clone().map(pick).reduce(f64::min).unwrap_or(0.0);
        let high = |pick: fn(&PictureFrame) -> f64| frames.clone().map(pick).reduce(f64::max).unwrap_or(0.0);
        let (x, y) = (low(|frame| frame.x), low(|frame| frame.y));
        PictureFrame { x, y, width: high(|f| f.x + f.width) - x, height: high(|f| f.y + f.height) - y }
    }

    pub fn widened(self, margin: f64) -> Self {
        let PictureFrame { x, y, width, height } = self;
        PictureFrame { x: x - margin, y: y - margin, width: width + 2.0 * margin, height: height + 2.0 * margin }
    }

    /// Common area [px2].
    pub fn overlap(&self, other: &PictureFrame) -> f64 {
        let common = |a: f64, wa: f64, b: f64, wb: f64| ((a + wa).min(b + wb) - a.max(b)).max(0.0);
        common(self.x, self.width, other.x, other.width) * common(self.y, self.height, other.y, other.height)
    }
}

impl Svg {
    pub fn line(&mut self, [x1, y1]: Pixel, [x2, y2]: Pixel, style: &str) {
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(number);
        self.element(format_args!(r#"<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" {style}/>"#));
    }

    pub fn circle(&mut self, [x, y]: Pixel, radius: f64, style: &str) {
        let [x, y, radius] = [x, y, radius].map(number);
        self.element(format_args!(r#"<circle cx="{x}" cy="{y}" r="{radius}" {style}/>"#));
    }

    /// A path; `data` as by [`polyline`].
    pub fn path(&mut self, data: &str, style: &str) {
        self.element(format_args!(r#"<path d="{data}" {style}/>"#));
    }

    pub fn rectangle(&mut self, frame: PictureFrame, radius: f64, style: &str) {
        let [x, y, width, height] = [frame.x, frame.y, frame.width, frame.height].map(number);
        let radius = number(radius);
        self.element(format_args!(
            r#"<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" {style}/>"#
        ));
    }

    pub fn text(&mut self, [x, y]: Pixel, style: &str, text: &str) {
        let ([x, y], text) = ([x, y].map(number), escape(text));
        self.element(format_args!(r#"<text x="{x}" y="{y}" {style}>{text}</text>"#));
    }

    /// Any element that is not listed here.
    pub fn raw(&mut self, element: &str) {
        self.element(format_args!("{element}"));
    }

    /// What is drawn from now on is carried by this.
    pub fn carry(&mut self, carrier: Carrier) {
        self.carriers.push((self.elements.len(), carrier));
    }

    /// The elements in order, each part with what carries it.
    pub fn parts(&self) -> impl Iterator<Item = (&Carrier, String)> {
        let ends = self.carriers.iter().skip(1).map(|(start, _)| *start).chain([self.elements.len()]);
        self.carriers.iter().zip(ends).map(|((start, carrier), end)| (carrier, self.elements[*start..end].to_owned()))
    }

    /// The elements so far, without a sheet.
    pub fn elements(&self) -> &str {
        &self.elements
    }

    /// The whole picture on a white sheet; `title` is read out by screen readers.
    pub fn finish(self, frame: PictureFrame, title: &str) -> String {
        let [x, y, width, height] = [frame.x, frame.y, frame.width, frame.height].map(number);
        let title = escape(title);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{x} {y} {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"{FONT}\" role=\"img\">\n<title>{title}</title>\n\
             <rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"6\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.elements
        )
    }

    fn element(&mut self, element: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.elements, "{element}");
    }
}

/// Path data of straight lines through the points.
pub fn polyline(points: &[Pixel]) -> String {
    let mut data = String::new();
    for (index, point) in points.iter().enumerate() {
        let [x, y] = point.map(number);
        let _ = write!(data, "{}{x} {y}", if index == 0 { "M" } else { "L" });
    }
    data
}

pub fn number(value: f64) -> String {
    match cotree::typeset::without_zeros(&format!("{value:.2}")) {
        "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Text as it may stand in XML and HTML, also inside quotes.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// How wide a text will be, near enough for laying it out.
pub fn text_width(text: &str, size: f64) -> f64 {
    0.6 * size * text.chars().count() as f64
}
