//! Parameters, inputs, points and bodies.

use super::Decoder;
use super::fields::Fields;
use crate::diagnostic::span::Text;
use crate::scene::document::{Kind, Node};
use crate::scene::model::{Body, Input, Parameter, Point};

impl Decoder {
    pub(super) fn parameter(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Parameter> {
        if !matches!(node.kind, Kind::Table(_)) {
            let value = self.faults.quantity(node, owner)?;
            return Some(Parameter { name: name.clone(), value, ..Parameter::default() });
        }
        let keys = ["value", "unit", "description", "min", "max", "tunable"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        let value = self.faults.required_quantity(&fields, "value", "give its default: `value = \"0.5 m\"`");
        let tunable = fields.get("tunable").and_then(|node| self.faults.boolean(node, &fields.name_of("tunable")));
        Some(Parameter {
            name: name.clone(),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            min: self.faults.optional_quantity(&fields, "min"),
            max: self.faults.optional_quantity(&fields, "max"),
            tunable: tunable.unwrap_or(false),
            value: value?,
        })
    }

    pub(super) fn input(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Input> {
        if !matches!(node.kind, Kind::Table(_)) {
            let start = Some(self.faults.quantity(node, owner)?);
            return Some(Input { name: name.clone(), start, ..Input::default() });
        }
        let keys = ["start", "unit", "description", "min", "max"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        Some(Input {
            name: name.clone(),
            start: self.faults.optional_quantity(&fields, "start"),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            min: self.faults.optional_quantity(&fields, "min"),
            max: self.faults.optional_quantity(&fields, "max"),
        })
    }

    pub(super) fn ground(&mut self, top: &Fields<'_>) -> Vec<Point> {
        let (Some(node), Some(span)) = (top.get("ground"), top.key_span("ground")) else {
            return Vec::new();
        };
        let fields = Fields::open(node, "the ground", span, &["points"], &mut self.faults);
        fields.map(|fields| self.points(&fields, "ground")).unwrap_or_default()
    }

    fn points(&mut self, fields: &Fields<'_>, body: &str) -> Vec<Point> {
        let Some(node) = fields.get("points") else {
            return Vec::new();
        };
        let Some(entries) = self.faults.entries(node, &fields.name_of("points")) else {
            return Vec::new();
        };
        let mut points = Vec::new();
        for (name, node) in entries {
            let what = format!("point `{body}.{}`", name.text);
            match self.faults.vector(node, &what) {
                Some(at) => points.push(Point { name: name.clone(), at }),
                None => self.broken.push(format!("{body}.{}", name.text)),
            }
        }
        points
    }

    pub(super) fn body(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Body> {
        let keys = ["mass", "inertia", "com", "gravity", "points"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        let gravity = fields.get("gravity").and_then(|node| self.faults.boolean(node, &fields.name_of("gravity")));
        Some(Body {
            name: name.clone(),
            mass: self.faults.optional_quantity(&fields, "mass"),
            inertia: self.faults.optional_quantity(&fields, "inertia"),
            com: fields.get("com").and_then(|node| self.faults.vector(node, &fields.name_of("com"))),
            weightless: gravity == Some(false),
            points: self.points(&fields, &name.text),
        })
    }
}
