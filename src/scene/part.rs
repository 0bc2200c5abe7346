//! Joints, drivers and loads as they are written: tables whose keys their components know.

use super::document::{Kind, Node};
use super::model::{InputAs, Motion, Vector};
use super::quantity::{Quantity, Value};
use crate::diagnostic::span::{Span, Text};

/// A joint, driver or load.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name.
    pub name: Text,
    /// A table, if it is well written.
    pub(crate) node: Node,
}

impl Part {
    fn new() -> Part {
        Part { name: Text::default(), node: Node { span: Span::default(), kind: Kind::Table(Vec::new()) } }
    }

    pub(super) fn with_name(mut self, name: &str) -> Part {
        self.name = Text::from(name);
        self
    }

    fn set(mut self, key: &str, value: impl Into<Node>) -> Part {
        if let Kind::Table(entries) = &mut self.node.kind {
            entries.retain(|(other, _)| other.text != key);
            entries.push((Text::from(key), value.into()));
        }
        self
    }

    /// What a key says, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        let Kind::Table(entries) = &self.node.kind else { return None };
        entries.iter().find(|(other, _)| other.text == key).map(|(_, node)| node)
    }

    /// The text of a key, if it is one.
    pub(crate) fn text(&self, key: &str) -> Option<Text> {
        self.get(key).and_then(Node::text)
    }

    /// The two names of `between`, if it has two.
    pub(crate) fn between(&self) -> Option<[Text; 2]> {
        let Some(Node { kind: Kind::Array(items), .. }) = self.get("between") else { return None };
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
            pub(crate) fn set(self, key: &str, value: impl Into<Node>) -> $name {
                $name(self.0.set(key, value))
            }
        }
    )*};
}

builders! {
    /// A joint that is built in Rust.
    Joint,
    /// A prescribed motion that is built in Rust.
    Driver,
    /// A load that is built in Rust.
    Load
}

impl Joint {
    pub(crate) fn new(kind: &str, first: &str, second: &str) -> Joint {
        Joint(Part::new()).set("type", kind).set("between", [first, second])
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
        let entry = |key: &str, value: Quantity| (Text::from(key), Node::from(value));
        let entries = vec![entry("coulomb", coulomb.into()), entry("velocity", velocity.into())];
        self.set("friction", Node { span: Span::default(), kind: Kind::Table(entries) })
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

impl Driver {
    pub(crate) fn new() -> Driver {
        Driver(Part::new())
    }
}

impl Load {
    pub(crate) fn new(kind: &str) -> Load {
        Load(Part::new()).set("type", kind)
    }

    pub(crate) fn is(&self, kind: &str) -> bool {
        self.0.text("type").is_some_and(|own| own.text == kind)
    }
}

impl Node {
    fn built(kind: Kind) -> Node {
        Node { span: Span::default(), kind }
    }

    fn text(&self) -> Option<Text> {
        let Kind::Text(text) = &self.kind else { return None };
        Some(Text::new(text.as_str(), self.span))
    }
}

impl From<&str> for Node {
    fn from(text: &str) -> Node {
        Node::built(Kind::Text(text.to_string()))
    }
}

impl From<[&str; 2]> for Node {
    fn from(pair: [&str; 2]) -> Node {
        Node::built(Kind::Array(pair.map(Node::from).into()))
    }
}

impl From<Quantity> for Node {
    fn from(quantity: Quantity) -> Node {
        let kind = match quantity.value {
            Value::Number(number) => Kind::Number(number),
            Value::Text(text) => Kind::Text(text),
        };
        Node { span: quantity.span, kind }
    }
}

impl From<Vector> for Node {
    fn from(vector: Vector) -> Node {
        Node { span: vector.span, kind: Kind::Array(vector.components.into_iter().map(Node::from).collect()) }
    }
}

impl From<Motion> for Node {
    fn from(motion: Motion) -> Node {
        match motion {
            Motion::Given(law) => law.into(),
            Motion::Follows { input, r#as } => {
                let entry = |key: &str, text: &str| (Text::from(key), Node::from(text));
                let entries = vec![entry("input", &input.text), entry("as", r#as.word())];
                Node::built(Kind::Table(entries))
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
