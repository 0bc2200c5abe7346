//! Parameters, inputs, bodies, drivers and loads.

use super::Decoder;
use super::fields::Fields;
use crate::mechanism::Side;
use crate::scene::document::{Kind, Node};
use crate::scene::fault::Fault;
use crate::scene::model::{
    Body, Driver, DriverKind, Input, InputAs, Load, LoadKind, Motion, Parameter, Point, Turning,
};
use crate::scene::span::Text;
use crate::scene::suggest;

pub(super) const TWO_POINTS: &str = "give two points: `between = [\"ground.bearing\", \"crank.inner\"]`";
pub(super) const TWO_BODIES: &str = "give two bodies: `between = [\"ground\", \"crank\"]`";
const ONE_POINT: &str = "give a point: `on = \"slider\"` or `on = \"crank.outer\"`";
const TWO_COMPONENTS: &str = "give two components, such as `[\"-gas_force\", 0.0]`";
const LOAD_TYPES: [&str; 6] = ["force", "torque", "spring", "torsion_spring", "actuator", "torsion_actuator"];
const MOTIONS: [&str; 3] = ["angle", "displacement", "position"];

impl Decoder {
    pub(super) fn parameter(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Parameter> {
        if !matches!(node.kind, Kind::Table(_)) {
            let value = self.quantity(node, owner)?;
            return Some(Parameter { name: name.clone(), value, ..Parameter::default() });
        }
        let keys = ["value", "unit", "description", "min", "max", "tunable"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        let value = self.required_quantity(&fields, "value", "give its default: `value = \"0.5 m\"`");
        let tunable = fields.get("tunable").and_then(|node| self.boolean(node, &fields.name_of("tunable")));
        Some(Parameter {
            name: name.clone(),
            unit: self.optional_text(&fields, "unit"),
            description: self.optional_text(&fields, "description"),
            min: self.optional_quantity(&fields, "min"),
            max: self.optional_quantity(&fields, "max"),
            tunable: tunable.unwrap_or(false),
            value: value?,
        })
    }

    pub(super) fn input(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Input> {
        if !matches!(node.kind, Kind::Table(_)) {
            let start = Some(self.quantity(node, owner)?);
            return Some(Input { name: name.clone(), start, ..Input::default() });
        }
        let keys = ["start", "unit", "description", "min", "max"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        Some(Input {
            name: name.clone(),
            start: self.optional_quantity(&fields, "start"),
            unit: self.optional_text(&fields, "unit"),
            description: self.optional_text(&fields, "description"),
            min: self.optional_quantity(&fields, "min"),
            max: self.optional_quantity(&fields, "max"),
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
        let Some(entries) = self.entries(node, &fields.name_of("points")) else {
            return Vec::new();
        };
        let mut points = Vec::new();
        for (name, node) in entries {
            let what = format!("point `{body}.{}`", name.text);
            match self.vector(node, &what) {
                Some(at) => points.push(Point { name: name.clone(), at }),
                None => self.broken.push(format!("{body}.{}", name.text)),
            }
        }
        points
    }

    pub(super) fn body(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Body> {
        let keys = ["mass", "inertia", "com", "gravity", "points"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        let gravity = fields.get("gravity").and_then(|node| self.boolean(node, &fields.name_of("gravity")));
        Some(Body {
            name: name.clone(),
            mass: self.optional_quantity(&fields, "mass"),
            inertia: self.optional_quantity(&fields, "inertia"),
            com: fields.get("com").and_then(|node| self.vector(node, &fields.name_of("com"))),
            weightless: gravity == Some(false),
            points: self.points(&fields, &name.text),
        })
    }

    /// The `type` of a joint or load, one of `types`.
    pub(super) fn kind(&mut self, name: &Text, node: &Node, owner: &str, types: &[&str]) -> Option<Text> {
        let Kind::Table(entries) = &node.kind else {
            // Reports that it is no table.
            Fields::open(node, owner, name.span, types, &mut self.faults);
            return None;
        };
        let known = suggest::list(types.iter().copied());
        let Some((_, value)) = entries.iter().find(|(key, _)| key.text == "type") else {
            self.faults.push(
                Fault::new("scene::missing_key", format!("{owner} has no `type`"), name.span)
                    .label("`type` is missing")
                    .help(format!("the types are {known}")),
            );
            return None;
        };
        let kind = self.text(value, &format!("`type` of {owner}"))?;
        if !types.contains(&kind.text.as_str()) {
            self.faults.push(
                Fault::new("scene::unknown_type", format!("{owner} has an unknown type: `{}`", kind.text), kind.span)
                    .label("no such type")
                    .help(suggest::hint(&kind.text, types.iter().copied(), format!("the types are {known}"))),
            );
            return None;
        }
        Some(kind)
    }

    pub(super) fn driver(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Driver> {
        let keys = ["joint", "between", "on", "angle", "displacement", "position"];
        let fields = Fields::open(node, owner, name.span, &keys, &mut self.faults)?;
        let given: Vec<&str> = MOTIONS.into_iter().filter(|key| fields.get(key).is_some()).collect();
        let [motion] = given[..] else {
            let found =
                if given.is_empty() { "none of them".to_string() } else { suggest::list(given.iter().copied()) };
            let span = given.get(1).and_then(|key| fields.key_span(key)).unwrap_or(name.span);
            self.faults.push(
                Fault::new(
                    "scene::driver_motion",
                    format!("{owner} must have exactly one of `angle`, `displacement`, `position`, but has {found}"),
                    span,
                )
                .label("exactly one is wanted")
                .help(
                    "`angle` turns a revolute joint, `displacement` slides a prismatic joint, `position` moves a point",
                ),
            );
            return None;
        };
        let permitted: &[&str] = match motion {
            "angle" => &["joint", "between"],
            "displacement" => &["joint"],
            _ => &["on"],
        };
        let kind = self.driven(&fields, motion, permitted)?;
        Some(Driver { name: name.clone(), kind })
    }

    /// A driver's kind, given which motion it has and which keys may say of what.
    fn driven(&mut self, fields: &Fields<'_>, motion: &str, permitted: &[&str]) -> Option<DriverKind> {
        let given: Vec<&str> = ["joint", "between", "on"].into_iter().filter(|key| fields.get(key).is_some()).collect();
        let wanted = permitted.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" or ");
        if given.len() != 1 || !permitted.contains(&given[0]) {
            let wrong = given.iter().rev().find(|key| given.len() > 1 || !permitted.contains(key));
            let span = wrong.and_then(|key| fields.key_span(key)).unwrap_or(fields.span);
            self.faults.push(
                Fault::new("scene::driver_target", format!("{} has `{motion}`, so it needs {wanted} and nothing else", fields.owner), span)
                    .label(format!("{wanted} is wanted"))
                    .help("`angle` needs `joint` or `between` (two bodies), `displacement` needs `joint`, `position` needs `on` (a point)"),
            );
            return None;
        }
        if motion == "position" {
            let on = self.required_text(fields, "on", ONE_POINT);
            let position = self.required_vector(fields, "position", TWO_COMPONENTS);
            return Some(DriverKind::Position { on: on?, position: position? });
        }
        let law = self.motion(fields, motion);
        let joint = self.optional_text(fields, "joint");
        if motion == "displacement" {
            return Some(DriverKind::Displacement { joint: joint?, motion: law? });
        }
        let of = match fields.get("between") {
            Some(_) => Turning::Between(self.required_pair(fields, TWO_BODIES)?),
            None => Turning::Joint(joint?),
        };
        Some(DriverKind::Angle { of, motion: law? })
    }

    /// An expression, or `{ input = "name", as = "position" | "velocity" | "acceleration" }`.
    fn motion(&mut self, fields: &Fields<'_>, key: &str) -> Option<Motion> {
        let node = fields.get(key)?;
        let what = fields.name_of(key);
        if !matches!(node.kind, Kind::Table(_)) {
            return self.quantity(node, &what).map(Motion::Given);
        }
        let help = format!("write `{key} = {{ input = \"name\", as = \"velocity\" }}`");
        let fields = Fields::open(node, &what, node.span, &["input", "as"], &mut self.faults)?;
        let input = self.required_text(&fields, "input", &help);
        let r#as = self.required_text(&fields, "as", &help)?;
        let r#as = match r#as.text.as_str() {
            "position" => InputAs::Position,
            "velocity" => InputAs::Velocity,
            "acceleration" => InputAs::Acceleration,
            other => {
                let choices = ["position", "velocity", "acceleration"];
                let otherwise = format!("an input can be {}", suggest::list(choices));
                self.faults.push(
                    Fault::new("scene::wrong_value", format!("{what} follows an input as `{other}`"), r#as.span)
                        .label("not a kind of motion")
                        .help(suggest::hint(other, choices, otherwise)),
                );
                return None;
            }
        };
        Some(Motion::Follows { input: input?, r#as })
    }

    pub(super) fn load(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Load> {
        let kind = self.kind(name, node, owner, &LOAD_TYPES)?;
        let keys: &[&str] = match kind.text.as_str() {
            "force" => &["type", "on", "vector", "frame"],
            "torque" => &["type", "on", "between", "value"],
            "spring" => &["type", "between", "stiffness", "length", "damping", "cubic", "side"],
            "torsion_spring" => &["type", "between", "stiffness", "angle", "damping", "cubic", "side"],
            "actuator" => &["type", "between", "force"],
            _ => &["type", "between", "torque"],
        };
        let owner = format!("{} `{}`", kind.text.replace('_', " "), name.text);
        let fields = Fields::open(node, &owner, name.span, keys, &mut self.faults)?;
        let kind = match kind.text.as_str() {
            "force" => self.force(&fields),
            "torque" => self.torque(&fields),
            "spring" => self.spring(&fields),
            "torsion_spring" => self.torsion_spring(&fields),
            "actuator" => {
                let between = self.required_pair(&fields, TWO_POINTS);
                let force = self.required_quantity(&fields, "force", "give the law: `force = \"-k*(length - l0)\"`");
                (|| Some(LoadKind::Actuator { between: between?, force: force? }))()
            }
            _ => {
                let between = self.required_pair(&fields, TWO_BODIES);
                let torque = self.required_quantity(&fields, "torque", "give the law: `torque = \"-c*omega\"`");
                (|| Some(LoadKind::TorsionActuator { between: between?, torque: torque? }))()
            }
        }?;
        Some(Load { name: name.clone(), kind })
    }

    fn force(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let on = self.required_text(fields, "on", ONE_POINT);
        let vector = self.required_vector(fields, "vector", TWO_COMPONENTS);
        let frame = self.optional_text(fields, "frame");
        let in_body = match frame.as_ref().map(|frame| frame.text.as_str()) {
            None | Some("world") => false,
            Some("body") => true,
            Some(other) => {
                let span = frame.as_ref().map_or(fields.span, |frame| frame.span);
                self.faults.push(
                    Fault::new("scene::wrong_value", format!("`frame` of {} is `{other}`", fields.owner), span)
                        .label("no such frame")
                        .help("`frame` is \"world\" (the default) or \"body\""),
                );
                false
            }
        };
        Some(LoadKind::Force { on: on?, vector: vector?, in_body })
    }

    fn torque(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let value = self.required_quantity(fields, "value", "give the torque [N.m]: `value = \"tau\"`");
        let between = match (fields.get("on"), fields.get("between")) {
            (Some(on), None) => {
                let on = self.text(on, &fields.name_of("on"));
                on.map(|on| [Text::new("ground", on.span), on])
            }
            (None, Some(_)) => self.required_pair(fields, TWO_BODIES),
            (on, _) => {
                let problem = if on.is_some() { "both `on` and `between`" } else { "neither `on` nor `between`" };
                self.faults.push(
                    Fault::new("scene::torque_target", format!("{} has {problem}", fields.owner), fields.span)
                        .label("exactly one is wanted")
                        .help("`on = \"crank\"` turns a body, `between = [\"rod\", \"crank\"]` turns the second against the first"),
                );
                None
            }
        };
        Some(LoadKind::Torque { between: between?, value: value? })
    }

    fn spring(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let between = self.required_pair(fields, TWO_POINTS);
        let stiffness = self.required_quantity(fields, "stiffness", "give the stiffness [N/m]; 0 makes it a damper");
        let length = self.optional_quantity(fields, "length");
        let damping = self.optional_quantity(fields, "damping");
        let cubic = self.optional_quantity(fields, "cubic");
        let side = self.side(fields);
        Some(LoadKind::Spring { between: between?, stiffness: stiffness?, length, damping, cubic, side })
    }

    /// `side` of a spring.
    fn side(&mut self, fields: &Fields<'_>) -> Side {
        let Some(side) = self.optional_text(fields, "side") else { return Side::Both };
        match side.text.as_str() {
            "both" => Side::Both,
            "above" => Side::Above,
            "below" => Side::Below,
            other => {
                let choices = ["both", "above", "below"];
                let otherwise =
                    "a spring acts on \"both\" sides of its free length or angle, or only \"above\" or \"below\" it";
                self.faults.push(
                    Fault::new("scene::wrong_value", format!("`side` of {} is `{other}`", fields.owner), side.span)
                        .label("no such side")
                        .help(suggest::hint(other, choices, otherwise.to_string())),
                );
                Side::Both
            }
        }
    }

    fn torsion_spring(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let between = self.required_pair(fields, TWO_BODIES);
        let stiffness =
            self.required_quantity(fields, "stiffness", "give the stiffness [N.m/rad]; 0 makes it a damper");
        let angle = self.optional_quantity(fields, "angle");
        let damping = self.optional_quantity(fields, "damping");
        let cubic = self.optional_quantity(fields, "cubic");
        let side = self.side(fields);
        Some(LoadKind::TorsionSpring { between: between?, stiffness: stiffness?, angle, damping, cubic, side })
    }
}
