//! Joints.

use super::Decoder;
use super::elements::{TWO_BODIES, TWO_POINTS};
use super::fields::Fields;
use crate::scene::document::Node;
use crate::scene::fault::Fault;
use crate::scene::model::{Friction, Joint, JointKind, Vector};
use crate::scene::span::Text;

const TYPES: [&str; 8] = ["revolute", "prismatic", "weld", "slot", "rolling", "distance", "gear", "rack"];

/// The keys of a joint beside `type` and `between`.
fn keys(kind: &str) -> &'static [&'static str] {
    match kind {
        "revolute" => &["type", "between", "damping", "friction"],
        "prismatic" => &["type", "between", "axis", "angle", "damping", "friction"],
        "slot" => &["type", "between", "axis", "damping", "friction"],
        "rolling" => &["type", "between", "axis", "radius", "displacement"],
        "distance" => &["type", "between", "length"],
        "gear" => &["type", "between", "carrier", "ratio", "angle"],
        "rack" => &["type", "between", "carrier", "axis", "radius", "displacement"],
        _ => &["type", "between", "angle"],
    }
}

impl Decoder {
    pub(super) fn joint(&mut self, name: &Text, node: &Node, owner: &str) -> Option<Joint> {
        let kind = self.kind(name, node, owner, &TYPES)?.text;
        let owner = owner.replacen("joint", &format!("{kind} joint"), 1);
        let fields = Fields::open(node, &owner, name.span, keys(&kind), &mut self.faults)?;
        let between = self.required_pair(&fields, if kind == "gear" { TWO_BODIES } else { TWO_POINTS });
        let kind = self.joint_kind(&kind, &fields);
        Some(Joint { name: name.clone(), between: between?, kind: kind? })
    }

    fn joint_kind(&mut self, kind: &str, fields: &Fields<'_>) -> Option<JointKind> {
        let damping = self.optional_quantity(fields, "damping");
        let friction = self.friction(fields);
        let angle = self.optional_quantity(fields, "angle");
        let displacement = self.optional_quantity(fields, "displacement");
        let carrier = self.optional_text(fields, "carrier");
        Some(match kind {
            "revolute" => JointKind::Revolute { damping, friction },
            "prismatic" => JointKind::Prismatic { axis: self.axis(fields, "first body")?, angle, damping, friction },
            "slot" => JointKind::Slot { axis: self.axis(fields, "first body")?, damping, friction },
            "rolling" => {
                let axis = self.axis(fields, "first body");
                let radius =
                    self.required_quantity(fields, "radius", "give the radius of the disc: `radius = \"0.2 m\"`");
                JointKind::Rolling { axis: axis?, radius: radius?, displacement }
            }
            "distance" => {
                let length =
                    self.required_quantity(fields, "length", "give the length of the rod: `length = \"0.5 m\"`");
                JointKind::Distance { length: length? }
            }
            "gear" => {
                let help =
                    "give the second wheel's turns for one of the first: `ratio = -0.5`, negative for external teeth";
                let ratio = self.required_quantity(fields, "ratio", help);
                JointKind::Gear { carrier, ratio: ratio?, angle }
            }
            "rack" => {
                let axis = self.axis(fields, "carrier");
                let radius =
                    self.required_quantity(fields, "radius", "give the radius of the pinion: `radius = \"30 mm\"`");
                JointKind::Rack { carrier, axis: axis?, radius: radius?, displacement }
            }
            _ => JointKind::Weld { angle },
        })
    }

    fn axis(&mut self, fields: &Fields<'_>, whose: &str) -> Option<Vector> {
        self.required_vector(fields, "axis", &format!("give the direction in the {whose}'s frame: `axis = [1.0, 0.0]`"))
    }

    /// `{ coulomb = 0.1, velocity = 0.01 }`
    fn friction(&mut self, fields: &Fields<'_>) -> Option<Friction> {
        let node = fields.get("friction")?;
        let what = fields.name_of("friction");
        let keys = ["coulomb", "velocity", "viscous", "coefficient"];
        let fields = Fields::open(node, &what, node.span, &keys, &mut self.faults)?;
        self.refuse_friction_key(
            &fields,
            "viscous",
            "viscous friction is a key of the joint itself",
            "write `damping = ...` beside `friction`",
        );
        if self.refuse_friction_key(
            &fields,
            "coefficient",
            "friction in proportion to the load is not available: loads may not depend on reactions",
            "give a constant level instead: `coulomb = 0.1`",
        ) {
            return None;
        }
        let coulomb = self.required_quantity(
            &fields,
            "coulomb",
            "give the level of the friction: a torque or a force, such as `coulomb = 0.1`",
        );
        let velocity = self.required_quantity(
            &fields,
            "velocity",
            "give the velocity below which friction fades to zero, small against the usual ones, such as `velocity = 0.01`",
        );
        Some(Friction { coulomb: coulomb?, velocity: velocity? })
    }

    /// Is a key there that friction does not have? Says why.
    fn refuse_friction_key(&mut self, fields: &Fields<'_>, key: &str, why: &str, help: &str) -> bool {
        let span = fields.key_span(key);
        if let Some(span) = span {
            let message = format!("{} has `{key}`, but {why}", fields.owner);
            self.faults.push(Fault::new("scene::friction", message, span).label("not here").help(help));
        }
        span.is_some()
    }
}
