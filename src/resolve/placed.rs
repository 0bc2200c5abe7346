//! Where parts are: their left and right exchanged, turned, moved, and fixed to a body, in this order. What the text of a part says is resolved as the
//! part sees it, and becomes what the scene sees.

use std::f64::consts::TAU;
use std::rc::Rc;

use super::Resolver;
use super::context::Context;
use super::names::Named;
use crate::component::{Component, PartFrame, Placed, Section, minus, sum};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::expr::Unary;
use crate::model::measure::{ANGLE, LENGTH};
use crate::model::{BodyId, Formula, Initial, Owner, Part, Place, Quantity, Variable};
use crate::scene::decode::Fields;
use crate::scene::key::Form;
use crate::scene::model::{Use, Within};
use crate::scene::part as written;

/// The place of a part.
#[derive(Clone, Default)]
pub(super) struct Placement {
    pub frame: Rc<PartFrame>,
    /// The same if all bodies that carry it are at zero, as their own parts see it.
    begin: PartFrame,
}

impl Use {
    fn is_placed(&self) -> bool {
        self.at.is_some() || self.angle.is_some() || self.mirror || self.on.is_some()
    }
}

impl Resolver<'_> {
    /// Says where the parts of the scene are.
    pub(super) fn place_parts(&mut self) {
        let scene = self.scene;
        for used in &scene.uses {
            let placement = match self.one_dimensional() {
                true => self.refuse_on_a_line(used),
                false => self.placement(used),
            };
            self.placements.push(placement);
        }
    }

    fn refuse_on_a_line(&mut self, used: &Use) -> Placement {
        if used.is_placed() {
            let message = format!("part `{}` cannot be placed on a line", used.name.text);
            let fault = Fault::new("scene::one_dimension", message, used.name.span).label("not with `dimension = 1`");
            self.faults.push(fault.help("give the places as parameters of the part"));
        }
        Placement::default()
    }

    fn placement(&mut self, used: &Use) -> Placement {
        let what = |key| format!("`{key}` of part `{}`", used.name.text);
        let at = used.at.as_ref().map(|at| self.vector(at, &what("at"), &LENGTH, Context::Constant));
        let angle = used.angle.as_ref().map(|angle| self.constant(angle, &what("angle"), &ANGLE));
        let zero = PartFrame::default();
        let offset =
            PartFrame { mirror: used.mirror, angle: angle.unwrap_or(zero.angle), at: at.unwrap_or(zero.at), ..zero };
        let Placement { frame: outer, begin } = self.placements[used.within].clone();
        let begin = offset.clone().within(&begin);
        let on = used.on.as_ref().and_then(|on| match self.names.get(&on.text) {
            Some(Named::Body(body)) => Some(body),
            _ => None,
        });
        let mut frame = match on {
            // It goes where the body goes, which has its left and right exchanged with its own part.
            Some(_) => offset.within(&PartFrame { mirror: outer.mirror, on, ..PartFrame::default() }),
            None => offset.within(&outer),
        };
        frame.origin = self.known_place(&used.origin.text).unwrap_or(frame.origin);
        Placement { frame: Rc::new(frame), begin }
    }

    /// Reads what is written in the text of a part.
    pub(super) fn within<T>(&mut self, part: Within, read: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.part, part);
        let read = read(self);
        self.part = before;
        read
    }

    /// Where the part is whose text is read.
    pub(super) fn frame(&self) -> Rc<PartFrame> {
        self.placements[self.part].frame.clone()
    }

    /// Makes an element of a part what the scene sees of it.
    pub(super) fn place_element(&mut self, part: &mut Part, fields: &Fields<'_>) {
        let (frame, component) = (self.frame(), part.component());
        let guide =
            component.keys.iter().find_map(|key| if let Form::Curve(guide, _) = key.form { Some(guide) } else { None });
        let turns = guide.is_some_and(|guide| self.turns(fields.get(guide)));
        let turned = self.turned(part.owner).map_or(Formula::Number(0.0), |(turned, _)| turned);
        let name = part.name.clone();
        let mut placed = Placed { frame: &frame, part, turned, turns, refused: Vec::new() };
        (component.placed)(&mut placed);
        for (key, why, help) in placed.refused {
            let span = fields.get(key).map_or(fields.span, |node| node.span);
            self.refuse_place(&format!("`{name}`: {why}"), span, help);
        }
    }

    /// What the place of the part adds to the angle of a body or an element, and whether that is an angle within a turn.
    fn turned(&self, owner: Owner) -> Option<(Formula, bool)> {
        let (part, section) = match owner {
            Owner::Place(_) => return Some((self.frame().angle.clone(), false)),
            Owner::Joint(id) => (&self.scene.joints[id.0], Section::Joints),
            Owner::Driver(id) => (&self.scene.drivers[id.0], Section::Drivers),
            Owner::Load(id) => (&self.scene.loads[id.0], Section::Loads),
            Owner::System => return None,
        };
        let component = part.component(section)?;
        let within = component.keys.iter().any(|key| matches!(key.form, Form::Curve(..)));
        Some((self.frame().turned(self.ends_of(part, component)?), within))
    }

    /// Between which bodies an element's angle is: its own, those of the joint that it moves, the shaft's if it is a cam, or the ground and a body.
    fn ends_of(&self, part: &written::Part, component: &Component) -> Option<[Option<BodyId>; 2]> {
        let bodies = self.bodies_between(part);
        let of_joint = |key: &str| match self.names.get(&part.text(key)?.text)? {
            Named::Joint(id) => self.bodies_between(&self.scene.joints[id.0]),
            _ => None,
        };
        let shaft = component.keys.iter().find(|key| matches!(key.form, Form::OtherJoint));
        if let (Some([cam, _]), Some([a, b])) = (bodies, shaft.and_then(|key| of_joint(key.name))) {
            return Some(if a == cam { [b, a] } else { [a, b] });
        }
        let on = || Some([self.body_named("ground", part)?, self.body_named(&part.text("on")?.text, part)?]);
        bodies.or_else(|| of_joint("joint")).or_else(on)
    }

    fn bodies_between(&self, part: &written::Part) -> Option<[Option<BodyId>; 2]> {
        let [first, second] = part.between()?;
        Some([self.body_named(&first.text, part)?, self.body_named(&second.text, part)?])
    }

    /// The body of a place that an element names.
    fn body_named(&self, name: &str, part: &written::Part) -> Option<Option<BodyId>> {
        match self.names.get(name.split('.').next()?) {
            Some(Named::Body(body)) => Some(Some(body)),
            _ => name.starts_with("ground").then(|| self.placements[part.within].frame.on),
        }
    }

    /// What a variable is for the part that names it, in terms of the scene's; none if its place makes that unknown.
    pub(super) fn seen(&self, variable: Variable) -> Option<Formula> {
        use Quantity::{Alpha, Angle, Ax, Ay, Fn, Ft, Fx, Fy, Omega, PressureAngle, Torque, Vx, Vy, X, Y};
        let (frame, itself) = (self.frame(), Formula::Variable(variable));
        let is_place = matches!(variable.owner, Owner::Place(_));
        if !frame.is_placed() {
            return Some(itself);
        }
        let both = |words: [Quantity; 2]| words.map(|quantity| Formula::Variable(Variable { quantity, ..variable }));
        let one = |[x, y]: [Formula; 2]| if matches!(variable.quantity, X | Vx) { x } else { y };
        Some(match variable.quantity {
            _ if is_place && frame.on.is_some() => return None,
            Omega | PressureAngle | Torque => frame.signed(itself),
            Angle => {
                let (turned, is_within) = self.turned(variable.owner)?;
                let angle = frame.signed(itself - turned);
                if is_within { within_a_turn(angle) } else { angle }
            }
            X | Y if is_place => {
                let ([x, y], [at_x, at_y]) = (both([X, Y]), frame.at.clone());
                one(frame.direction_back([x - at_x, y - at_y]))
            }
            Vx | Vy if is_place => one(frame.direction_back(both([Vx, Vy]))),
            // Where a load is, as its coordinates say, depends on both of its ends; the others have a direction in the scene, and none in the part.
            X | Y | Vx | Vy | Fx | Fy | Fn | Ft | Ax | Ay | Alpha => return None,
            _ => itself,
        })
    }

    /// An initial value of the part as the scene sees it, or what to do instead; `other` is what the part gives for another variable of the same owner.
    pub(super) fn seen_initial(
        &self,
        initial: &Initial,
        other: impl Fn(Quantity) -> Option<Formula>,
    ) -> Result<Formula, &'static str> {
        use Quantity::{Angle, Omega, Vx, Vy, X, Y};
        let (frame, value) = (self.frame(), initial.value.clone());
        let Variable { owner, quantity } = initial.variable;
        let is_place = matches!(owner, Owner::Place(_));
        if !frame.is_moved() {
            return Ok(value);
        }
        if is_place && frame.on.is_some() && initial.known {
            return Err(
                "its angle and position relative to the body are not known; give a guess, or the value of a joint",
            );
        }
        let zero = || Some(Formula::Number(0.0)).filter(|zero| frame.angle == *zero);
        let both = |words: [Quantity; 2]| {
            let [x, y] = words.map(|word| other(word).or_else(zero));
            x.zip(y).map(|(x, y)| [x, y]).ok_or("give both components, x and y")
        };
        let one = |[x, y]: [Formula; 2]| if matches!(quantity, X | Vx) { x } else { y };
        Ok(match quantity {
            Omega => frame.signed(value),
            Angle => {
                let (turned, is_within) = self.turned(owner).unwrap_or((Formula::Number(0.0), false));
                let angle = sum(turned, frame.signed(value));
                if is_within { within_a_turn(angle) } else { angle }
            }
            X | Y if is_place => one(frame.place(both([X, Y])?)),
            Vx | Vy if is_place => one(frame.direction(both([Vx, Vy])?)),
            _ => value,
        })
    }

    /// Where the bodies of parts begin, but for what begins at zero: where their parts have them at zero.
    pub(super) fn begins(&self) -> Vec<Initial> {
        let begin = |(index, body): (usize, &written::Part)| {
            let PartFrame { at: [x, y], angle, .. } = self.placements[body.within].begin.clone();
            let owner = Owner::Place(Place::Centre(BodyId(index)));
            [(Quantity::X, x), (Quantity::Y, y), (Quantity::Angle, angle)].map(|(quantity, value)| {
                let variable = Variable { owner, quantity };
                Initial { variable, value, display: None, known: false, span: Span::default() }
            })
        };
        let begins = self.scene.bodies.iter().enumerate().flat_map(begin);
        begins.filter(|begin| begin.value != Formula::Number(0.0)).collect()
    }

    /// Says once that something in the file of the part depends on its place in a way that is not known.
    pub(super) fn refuse_place(&mut self, what: &str, span: Span, help: &str) {
        if self.faults.again(what, span) {
            return;
        }
        let scene = self.scene;
        let used = |part: Within| scene.uses.get(part.wrapping_sub(1));
        let mut parts = std::iter::successors(used(self.part), |part| used(part.within));
        let Some(Use { name, .. }) = parts.find(|part| part.is_placed()) else { return };
        let message = format!(
            "part `{}` is mirrored, turned, moved or on a body, which cannot be combined with {what}",
            name.text
        );
        let mut fault = Fault::new("scene::placed_part", message, span).label("depends on the placement").help(help);
        fault.also.push(name.span);
        self.faults.push_about(what, fault);
    }
}

/// The angle from 0 to 2 pi.
fn within_a_turn(angle: Formula) -> Formula {
    let turn = Formula::Number(TAU);
    let turns = (angle.clone() / turn.clone()).of(Unary::Floor);
    minus(angle, turn * turns)
}
