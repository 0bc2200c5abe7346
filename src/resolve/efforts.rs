//! Laws that use the force or torque of another load: in its place stands the law by which that load acts.

use super::Resolver;
use super::order::{Uses, sorted};
use super::signals::{is_too_long, too_long, variables};
use crate::component::Section;
use crate::model::{Class, Dimension, Formula, KeyValue, LoadId, Owner, Part, Variable};
use crate::scene::constant::negate;

impl Resolver<'_> {
    /// The loads, with the laws of others written out in those that use their forces or torques.
    pub(super) fn loads(&mut self) -> Vec<Part> {
        let mut loads = self.parts(Section::Loads);
        if loads.len() < self.scene.loads.len() {
            return loads;
        }
        let used = |load: &Part| {
            let variables = laws(load).into_iter().flat_map(variables);
            variables.filter_map(effort_of).map(|id| id.0).collect()
        };
        let uses: Uses = loads.iter().map(used).enumerate().collect();
        let (order, circle) = sorted(&uses);
        let circle: Vec<_> = circle.iter().map(|&index| (loads[index].name.as_str(), loads[index].span)).collect();
        self.refuse_circle(&circle, "loads", "let one of them depend on positions and velocities only");
        for index in order.into_iter().filter(|index| !uses[index].is_empty()) {
            let mut load = loads[index].clone();
            let scene = self.scene;
            let presence = |load| scene.presence(Owner::Load(load)).map(Formula::Discrete);
            laws_mut(&mut load).for_each(|law| write_out(law, &loads, (scene.dimension, &presence)));
            if laws(&load).into_iter().any(is_too_long) {
                self.faults.push(too_long(&format!("load `{}`", load.name), "loads", load.span));
                break;
            }
            loads[index] = load;
        }
        loads
    }
}

/// Whose force or torque a variable is.
fn effort_of(variable: Variable) -> Option<LoadId> {
    match variable.owner {
        Owner::Load(id) if variable.quantity.class() == Class::Effort => Some(id),
        Owner::Place(_) | Owner::Joint(_) | Owner::Driver(_) | Owner::Load(_) | Owner::System => None,
    }
}

/// What a load's keys say.
fn laws(load: &Part) -> Vec<&Formula> {
    let formulas = load.values.iter().map(|(_, value)| match value {
        KeyValue::Formula(law) => std::slice::from_ref(law),
        KeyValue::Vector(both) => &both[..],
        _ => &[],
    });
    formulas.flatten().collect()
}

fn laws_mut(load: &mut Part) -> impl Iterator<Item = &mut Formula> {
    let formulas = load.values.iter_mut().map(|(_, value)| match value {
        KeyValue::Formula(law) => std::slice::from_mut(law),
        KeyValue::Vector(both) => &mut both[..],
        _ => &mut [],
    });
    formulas.flatten()
}

fn write_out(
    formula: &mut Formula,
    loads: &[Part],
    (dimension, presence): (Dimension, &dyn Fn(LoadId) -> Option<Formula>),
) {
    match formula {
        Formula::Variable(variable) => {
            let Some(id) = effort_of(*variable) else { return };
            let load = &loads[id.0];
            let Some(law) = load.law() else { return };
            let law = presence(id).into_iter().fold(law, |law, presence| law * presence);
            // On a line the force of a spring is its tension.
            let pulls = dimension == Dimension::One && load.component().pulls;
            *formula = if pulls { negate(law) } else { law };
        }
        other => other.parts_mut().iter_mut().for_each(|part| write_out(part, loads, (dimension, presence))),
    }
}
