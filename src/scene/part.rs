//! Bodies, joints, drivers and loads as they are written: tables whose keys their components know.

use super::document::{Content, DocumentNode};
use super::model::{InputAs, Motion, Point, Vector, Within};
use super::quantity::{Quantity, Value};
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;

/// A body, joint, driver or load.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name.
    pub name: Text,
    /// A table, if it is well written.
    pub(crate) node: DocumentNode,
    /// In whose text it is written.
    pub(crate) within: Within,
    /// Its points that are those of the ground of a part which it carries.
    pub(crate) carried: Vec<(String, Within)>,
}

impl Part {
    pub(super) fn new(name: Text, node: DocumentNode) -> Part {
        Part { name, node, within: 0, carried: Vec::new() }
    }

    pub(super) fn empty() -> Part {
        Part::new(Text::default(), DocumentNode::built(Content::Table(Vec::new())))
    }

    pub(super) fn with_name(mut self, name: &str) -> Part {
        self.name = Text::from(name);
        self
    }

    /// With a value for a key, in place of the one that it has.
    pub(crate) fn set(mut self, key: &str, value: impl Into<DocumentNode>) -> Part {
        if let Content::Table(entries) = &mut self.node.kind {
            entries.retain(|(other, _)| other.text != key);
            entries.push((Text::from(key), value.into()));
        }
        self
    }

    /// With a number for a key, in place of the value that it has.
    pub fn with_number(self, key: &str, value: f64) -> Part {
        self.set(key, super::Quantity::from(value))
    }

    /// Adds an entry to the table that a key has.
    fn add(mut self, key: &str, name: &str, value: impl Into<DocumentNode>) -> Part {
        self.add_entry(key, Text::from(name), value.into());
        self
    }

    /// The same, if it is a table.
    fn add_entry(&mut self, key: &str, name: Text, value: DocumentNode) {
        let Content::Table(entries) = &mut self.node.kind else { return };
        let place = entries.iter().position(|(other, _)| other.text == key).unwrap_or(entries.len());
        if place == entries.len() {
            entries.push((Text::from(key), DocumentNode::built(Content::Table(Vec::new()))));
        }
        if let Content::Table(entries) = &mut entries[place].1.kind {
            entries.push((name, value));
        }
    }

    /// Is it a table, and so are its points, if it has any? Else nobody knows its points.
    pub(crate) fn is_readable(&self) -> bool {
        let is_table = |node: &DocumentNode| matches!(node.kind, Content::Table(_));
        is_table(&self.node) && self.get("points").is_none_or(is_table)
    }

    /// The entries of a table with names, if it is one.
    pub fn entries(&self, key: &str) -> &[(Text, DocumentNode)] {
        match self.get(key).or_else(|| self.meant(key)) {
            Some(DocumentNode { kind: Content::Table(entries), .. }) => entries,
            _ => &[],
        }
    }

    /// What a key says that is nearly this one.
    fn meant(&self, key: &str) -> Option<&DocumentNode> {
        let Content::Table(entries) = &self.node.kind else { return None };
        entries.iter().find(|(other, _)| suggest::nearest(&other.text, [key]).is_some()).map(|(_, node)| node)
    }

    /// What a key says, if it is there.
    pub fn get(&self, key: &str) -> Option<&DocumentNode> {
        let Content::Table(entries) = &self.node.kind else { return None };
        entries.iter().find(|(other, _)| other.text == key).map(|(_, node)| node)
    }

    /// Adds a point of the ground of a part, if it is a table and so are its points.
    pub(crate) fn carry(&mut self, point: Point) {
        self.carried.push((point.name.text.clone(), point.within));
        self.add_entry("points", point.name, point.at.into());
    }

    /// The text of a key, if it is one.
    pub(crate) fn text(&self, key: &str) -> Option<Text> {
        self.get(key).and_then(DocumentNode::text)
    }

    /// The two names of `between`, if it has two.
    pub(crate) fn between(&self) -> Option<[Text; 2]> {
        let Some(DocumentNode { kind: Content::Array(items), .. }) = self.get("between") else { return None };
        let [first, second] = &items[..] else { return None };
        Some([first.text()?, second.text()?])
    }
}

/// Declares what builds the entries of a section in Rust; the constructors are in the components' own files.
macro_rules! builders {
    ($($(#[$doc:meta])* $name:ident),*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name(pub(super) Part);

        impl $name {
            pub(crate) fn set(self, key: &str, value: impl Into<DocumentNode>) -> $name {
                $name(self.0.set(key, value))
            }
        }
    )*};
}

builders! {
    /// A rigid body that is built in Rust.
    Body,
    /// The shape of a body that is built in Rust.
    Shape,
    /// The outline of a body or of the ground that is built in Rust.
    Outline,
    /// A joint that is built in Rust.
    Joint,
    /// A prescribed motion that is built in Rust.
    Driver,
    /// A load that is built in Rust.
    Load
}

impl Joint {
    pub(crate) fn new(kind: &str, first: &str, second: &str) -> Joint {
        Joint(Part::empty()).set("type", kind).set("between", [first, second])
    }

    /// Whether it is engaged at the start.
    #[must_use]
    pub fn engaged(self, engaged: bool) -> Joint {
        self.set("engaged", DocumentNode::built(Content::Boolean(engaged)))
    }

    /// Where it engages: `here`, where it stands, or `named`, in the pose that its constants give.
    #[must_use]
    pub fn at(self, place: &str) -> Joint {
        self.set("at", place)
    }

    /// The body that carries two wheels, or the point from which a displacement counts.
    #[must_use]
    pub fn carrier(self, name: &str) -> Joint {
        self.set("carrier", name)
    }

    /// Viscous friction of what turns [N.m.s] or slides [N.s/m].
    #[must_use]
    pub fn damping(self, value: impl Into<Quantity>) -> Joint {
        self.set("damping", value.into())
    }

    /// Dry friction of what turns [N.m] or slides \[N\], and the velocity below which it fades.
    #[must_use]
    pub fn friction(self, coulomb: impl Into<Quantity>, velocity: impl Into<Quantity>) -> Joint {
        let entry = |key: &str, value: Quantity| (Text::from(key), DocumentNode::from(value));
        let entries = vec![entry("coulomb", coulomb.into()), entry("velocity", velocity.into())];
        self.set("friction", DocumentNode { span: Span::default(), kind: Content::Table(entries) })
    }

    /// The second body's angle minus the first's, or the second wheel's angle where the first's is zero.
    #[must_use]
    pub fn angle(self, value: impl Into<Quantity>) -> Joint {
        self.set("angle", value.into())
    }

    /// The displacement where the angle is zero \[m\].
    #[must_use]
    pub fn displacement(self, value: impl Into<Quantity>) -> Joint {
        self.set("displacement", value.into())
    }
}

impl Body {
    /// A body without mass and points.
    pub fn new() -> Body {
        Body(Part::empty())
    }

    /// \[kg\]
    #[must_use]
    pub fn mass(self, mass: impl Into<Quantity>) -> Body {
        self.set("mass", mass.into())
    }

    /// About the mass centre [kg.m2].
    #[must_use]
    pub fn inertia(self, inertia: impl Into<Quantity>) -> Body {
        self.set("inertia", inertia.into())
    }

    /// Mass centre in the frame of the points \[m\].
    #[must_use]
    pub fn com(self, at: impl Into<Vector>) -> Body {
        self.set("com", at.into())
    }

    /// Gravity leaves it alone.
    #[must_use]
    pub fn weightless(self) -> Body {
        self.set("gravity", DocumentNode::built(Content::Boolean(false)))
    }

    /// Its shape: gives the mass centre, and with a density the mass and the moment of inertia.
    #[must_use]
    pub fn shape(self, shape: Shape) -> Body {
        self.set("shape", shape.0.node)
    }

    /// Its outline, for pictures and clearance; that of its shape if absent.
    #[must_use]
    pub fn outline(self, outline: Outline) -> Body {
        self.set("outline", outline.0.node)
    }

    /// Adds a point \[m\].
    #[must_use]
    pub fn point(self, name: &str, at: impl Into<Vector>) -> Body {
        Body(self.0.add("points", name, at.into()))
    }
}

impl Default for Body {
    fn default() -> Body {
        Body::new()
    }
}

/// A place in a body's frame: two coordinates \[m\], or the name of one of the body's points.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner(DocumentNode);

impl From<&str> for Corner {
    fn from(point: &str) -> Corner {
        Corner(point.into())
    }
}

impl<T: Into<Vector>> From<T> for Corner {
    fn from(at: T) -> Corner {
        Corner(at.into().into())
    }
}

impl Shape {
    /// A shape with these corners.
    pub(crate) fn new(kind: &str, corners: Vec<Corner>) -> Shape {
        let corners = corners.into_iter().map(|corner| corner.0).collect();
        Shape(Part::empty()).set(kind, DocumentNode::built(Content::Array(corners)))
    }

    /// A shape about a place.
    pub(crate) fn about(kind: &str, at: Corner) -> Shape {
        Shape(Part::empty()).set(kind, at.0)
    }

    /// Its density: `"7850 kg/m3"`, or per length or area in `kg/m` or `kg/m2`. A number alone is in kg/m3.
    #[must_use]
    pub fn density(self, density: impl Into<Quantity>) -> Shape {
        self.set("density", density.into())
    }

    /// The thickness of what is flat, with a density in kg/m3 \[m\].
    #[must_use]
    pub fn thickness(self, thickness: impl Into<Quantity>) -> Shape {
        self.set("thickness", thickness.into())
    }

    /// The cross-section of a rod, with a density in kg/m3 \[m2\].
    #[must_use]
    pub fn area(self, area: impl Into<Quantity>) -> Shape {
        self.set("area", area.into())
    }
}

impl Corner {
    /// Corners as a list.
    pub(crate) fn list<C: Into<Corner>>(corners: impl IntoIterator<Item = C>) -> DocumentNode {
        DocumentNode::built(Content::Array(corners.into_iter().map(|corner| corner.into().0).collect()))
    }
}

impl Outline {
    /// An outline with these corners.
    pub(crate) fn new(kind: &str, corners: Vec<Corner>) -> Outline {
        let corners = corners.into_iter().map(|corner| corner.0).collect();
        Outline(Part::empty()).set(kind, DocumentNode::built(Content::Array(corners)))
    }

    /// An outline about a place.
    pub(crate) fn about(kind: &str, at: Corner) -> Outline {
        Outline(Part::empty()).set(kind, at.0)
    }
}

impl Driver {
    pub(crate) fn new() -> Driver {
        Driver(Part::empty())
    }
}

impl Load {
    pub(crate) fn new(kind: &str) -> Load {
        Load(Part::empty()).set("type", kind)
    }

    pub(crate) fn is(&self, kind: &str) -> bool {
        self.0.text("type").is_some_and(|text| text.text == kind)
    }
}

impl DocumentNode {
    fn built(kind: Content) -> DocumentNode {
        DocumentNode { span: Span::default(), kind }
    }

    pub(crate) fn text(&self) -> Option<Text> {
        let Content::Text(text) = &self.kind else { return None };
        Some(Text::new(text.as_str(), self.span))
    }
}

impl From<&str> for DocumentNode {
    fn from(text: &str) -> DocumentNode {
        DocumentNode::built(Content::Text(text.to_string()))
    }
}

impl From<[&str; 2]> for DocumentNode {
    fn from(pair: [&str; 2]) -> DocumentNode {
        DocumentNode::built(Content::Array(pair.map(DocumentNode::from).into()))
    }
}

impl From<Quantity> for DocumentNode {
    fn from(quantity: Quantity) -> DocumentNode {
        let kind = match quantity.value {
            Value::Number(number) => Content::Number(number),
            Value::Text(text) => Content::Text(text),
        };
        DocumentNode { span: quantity.span, kind }
    }
}

impl From<Vector> for DocumentNode {
    fn from(vector: Vector) -> DocumentNode {
        DocumentNode {
            span: vector.span,
            kind: Content::Array(vector.components.into_iter().map(DocumentNode::from).collect()),
        }
    }
}

impl From<Motion> for DocumentNode {
    fn from(motion: Motion) -> DocumentNode {
        match motion {
            Motion::Given(law) => law.into(),
            Motion::Follows { input, r#as } => {
                let entry = |key: &str, text: &str| (Text::from(key), DocumentNode::from(text));
                let entries = vec![entry("input", &input.text), entry("as", r#as.word())];
                DocumentNode::built(Content::Table(entries))
            }
        }
    }
}

impl InputAs {
    /// What an input can be of a motion, in the order of the derivatives.
    pub(crate) const WORDS: [&'static str; 3] = ["position", "velocity", "acceleration"];

    fn word(self) -> &'static str {
        InputAs::WORDS[self as usize]
    }
}

/// On which side of its free length or angle a spring acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Everywhere.
    #[default]
    Both,
    /// Where it is longer than free; it only pulls.
    Above,
    /// Where it is shorter than free; it only pushes.
    Below,
}
