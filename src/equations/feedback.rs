//! Loads whose laws read accelerations or reactions, which follow from these loads in turn.
//!
//! The value of such a law is the multiplier of a row that is no loop equation: so the equations of motion name it as they name a reaction, and everything that acts with it can be read.

use super::{Constraint, Equations, RowKind};
use crate::expr::{Expr, Symbol};
use crate::model::Formula;
use crate::network::{Constrained, Direction, ElementId, Force, System, Torque};

/// A law that reads what it acts on.
#[derive(Clone, Debug)]
pub struct Feedback {
    /// Its row, whose multiplier is its value.
    pub row: usize,
    /// The law, in terms of accelerations and multipliers.
    pub value: Expr,
}

/// The rows of all such laws, each a number of its element along one of its axes or about it.
pub(super) fn rows(system: &System) -> Vec<Constraint> {
    let mut rows = Vec::new();
    for (index, element) in system.elements.iter().enumerate() {
        let force = element.translation.as_ref().map(|row| &row.through);
        let torque = element.rotation.as_ref().map(|row| &row.through);
        for (constrained, law) in laws(force, torque) {
            if law.reads_the_motion() {
                rows.push(Constraint::of_law(ElementId(index), constrained, RowKind::LoadValue));
            }
        }
    }
    rows
}

/// The laws of an element, each with what it is along or about.
fn laws<'s>(force: Option<&'s Force>, torque: Option<&'s Torque>) -> Vec<(Constrained, &'s Formula)> {
    let mut laws = match force {
        Some(Force::World([x, y]) | Force::InBody(_, [x, y])) => {
            vec![(Constrained::Along(Direction::X), x), (Constrained::Along(Direction::Y), y)]
        }
        Some(Force::Line(law) | Force::Tangent(law, _)) => vec![(Constrained::Length, law)],
        Some(Force::None | Force::Inertia(_) | Force::Resistance(_)) | None => Vec::new(),
    };
    if let Some(Torque::Law(law)) = torque {
        laws.push((Constrained::Angle, law));
    }
    laws
}

impl Equations {
    /// True if what is integrated depends on a law that reads accelerations or reactions.
    pub fn reads_the_motion(&self) -> bool {
        let of_states = self.system.arena.symbols(self.states.iter().copied());
        let acts = !self.is_driven() && self.constraints.iter().any(|row| matches!(row.kind, RowKind::LoadValue));
        acts || of_states.into_iter().any(Symbol::is_solved)
    }

    /// The laws of all loads that read accelerations or reactions.
    pub fn feedback(&mut self) -> Vec<Feedback> {
        let rows = self.constraints.iter().enumerate().filter(|(_, row)| matches!(row.kind, RowKind::LoadValue));
        let rows: Vec<(usize, ElementId, Constrained)> =
            rows.map(|(index, row)| (index, row.element, row.constrained)).collect();
        let value = |(row, element, constrained): (usize, ElementId, Constrained)| {
            let element = self.system.element(element);
            let force = element.translation.as_ref().map(|row| row.through.clone());
            let torque = element.rotation.as_ref().map(|row| row.through.clone());
            let matching = laws(force.as_ref(), torque.as_ref()).into_iter().find(|(along, _)| *along == constrained);
            let value = matching.map_or(Expr::ZERO, |(_, law)| self.formula(law));
            Feedback { row, value }
        };
        rows.into_iter().map(value).collect()
    }

    /// The value of a law of an element: an expression of what is known, or the multiplier that stands for it.
    pub(super) fn law(&mut self, id: ElementId, constrained: Constrained, law: &Formula) -> Expr {
        if !law.reads_the_motion() {
            return self.formula(law);
        }
        let is_law = |row: &Constraint| {
            matches!(row.kind, RowKind::LoadValue) && (row.element, row.constrained) == (id, constrained)
        };
        let row = self.constraints.iter().position(is_law);
        row.map_or(Expr::ZERO, |row| self.system.arena.symbol(Symbol::Reaction(row)))
    }
}
