//! Initial values.

use std::collections::HashMap;

use super::context::Context;
use super::{Resolver, UNKNOWN};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::model::{Class, Initial, Owner, Place, Variable};
use crate::scene::model;

impl Resolver<'_> {
    pub(super) fn initial(&mut self) -> Vec<Initial> {
        let scene = self.scene;
        let mut seen: HashMap<Variable, Span> = HashMap::new();
        let mut values = Vec::new();
        for line in &scene.initial {
            let Some(initial) = self.one_initial(line) else {
                continue;
            };
            if let Some(first) = seen.insert(initial.variable, line.variable.span) {
                let message = format!("`{}` has two initial values", line.variable.text);
                let mut fault = Fault::new("scene::duplicate_name", message, line.variable.span)
                    .label("second time")
                    .help("keep one of them");
                fault.also.push(first);
                self.faults.push(fault);
            }
            values.push((line, initial));
        }
        let place = |(line, initial): &(&model::Initial, Initial)| {
            self.within(line.within, |resolver| resolver.placed_initial(line, initial, &values))
        };
        values.iter().map(place).collect()
    }

    /// An initial value of a part as a value of the scene, among all of them.
    fn placed_initial(
        &mut self,
        line: &model::Initial,
        initial: &Initial,
        all: &[(&model::Initial, Initial)],
    ) -> Initial {
        let other = |quantity| {
            let variable = Variable { quantity, ..initial.variable };
            let is_other = |(initial, other): &&(&model::Initial, Initial)| {
                other.variable == variable && (initial.known, initial.within) == (line.known, line.within)
            };
            all.iter().find(is_other).map(|(_, other)| other.value.clone())
        };
        let value = self.seen_initial(initial, other).unwrap_or_else(|help| {
            let what = format!("the initial value of `{}`", line.variable.text);
            self.refuse_place(&what, line.value.span, help);
            UNKNOWN
        });
        Initial { value, ..initial.clone() }
    }

    fn one_initial(&mut self, line: &model::Initial) -> Option<Initial> {
        let variable = self.variable(&line.variable, "`[initial]`", "scene::unknown_variable");
        let what = format!("the initial value of `{}`", line.variable.text);
        let Some(variable) = variable else {
            self.constant(&line.value, &what, &crate::model::measure::ANYTHING);
            return None;
        };
        let (value, unit) = self.formula_and_unit(&line.value, &what, &variable.quantity.measure(), Context::Constant);
        let value = self.check_finite(value, &line.value, &what);
        if !self.may_be_initial(variable) {
            self.faults.push(
                Fault::new("scene::not_initial", format!("`{}` cannot have an initial value", line.variable.text), line.variable.span)
                    .label("not a position or velocity of a body or joint")
                    .help("give positions or velocities of bodies (`BODY.angle`, `BODY.vx`), revolute joints (`JOINT.angle`, `JOINT.omega`) or prismatic joints (`JOINT.s`, `JOINT.v`)"),
            );
        }
        let display = unit.and_then(|unit| unit.display);
        Some(Initial { variable, value, display, known: line.known, span: line.variable.span })
    }

    fn may_be_initial(&self, variable: Variable) -> bool {
        let moving = matches!(variable.quantity.class(), Class::Position | Class::Velocity);
        let owner = match variable.owner {
            Owner::Place(Place::Centre(_)) => true,
            Owner::Joint(_) => true,
            Owner::Load(_) => self.one_dimensional(),
            Owner::Place(Place::Origin | Place::Ground(_) | Place::Point(..)) | Owner::Driver(_) | Owner::System => {
                false
            }
        };
        moving && owner
    }
}
