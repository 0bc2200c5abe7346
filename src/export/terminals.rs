//! Terminals of FMI 3.0 (2.4.9.2): what belongs to one body, point, joint, driver or load and can be connected, motions and forces.

use std::collections::{HashMap, HashSet};

use cotree_fmu::program::Source;

use super::description::{Flow, Member, Terminal};
use crate::model::{Formula, KeyValue, Mechanism, Motion, Output, Owner, Part, Unit, Variable};
use crate::program::{Of, TableRow};

/// The terminals of a mechanism, in the order of the outputs, then of the inputs.
pub(super) fn terminals(mechanism: &Mechanism, outputs: &[Output], rows: &[TableRow]) -> Vec<Terminal> {
    let known = |row: &TableRow| match row.of {
        Some(Of::Variable(variable)) => Some(variable),
        Some(Of::State(_) | Of::Discrete(_)) | None => None,
    };
    let places: HashMap<Variable, usize> =
        rows.iter().enumerate().filter_map(|(place, row)| Some((known(row)?, place))).collect();
    let mut found = TerminalList::default();
    for output in outputs {
        // The energy of the whole mechanism is nobody's.
        let variable = mechanism.variable_of(output).filter(|variable| variable.owner != Owner::System);
        let Some((variable, &place)) = variable.and_then(|variable| Some((variable, places.get(&variable)?))) else {
            continue;
        };
        let kind = if is_effort(&output.unit) { Flow::Out } else { Flow::None };
        found.add(&mechanism.owner_name(variable), variable.quantity.word().to_owned(), place, kind);
    }
    for part in mechanism.drivers.iter().chain(&mechanism.loads) {
        // A force acts on the second point.
        let joint = part.joint().map(|joint| mechanism.joints[joint.0].name.clone());
        let owner = joint.unwrap_or_else(|| mechanism.place_name(part.between[1]));
        for (member, index) in inputs(part) {
            let input = &mechanism.inputs[index];
            let source = Source::Input(index as u32);
            if let Some(place) = rows.iter().position(|row| row.source == source) {
                let kind = if is_effort(&input.unit) { Flow::In } else { Flow::None };
                found.add(&owner, member, place, kind);
            }
        }
    }
    found.terminals
}

/// Is it a force or a torque: what adds up to zero where things are connected?
fn is_effort(unit: &Unit) -> bool {
    ["N", "N.m"].contains(&unit.si.as_str())
}

/// The inputs that a part takes as they are, and what they are called as members.
fn inputs(part: &Part) -> Vec<(String, usize)> {
    let input = |formula: &Formula| if let Formula::Input(input) = formula { Some(input.0) } else { None };
    let found = part.values.iter().flat_map(|(_, value)| match value {
        KeyValue::Formula(formula) | KeyValue::Motion(Motion::Given(formula)) => vec![("", input(formula))],
        KeyValue::Motion(Motion::Velocity(variable) | Motion::Acceleration(variable)) => vec![("", Some(variable.0))],
        KeyValue::Vector([x, y]) => vec![("_x", input(x)), ("_y", input(y))],
        _ => vec![],
    });
    found.filter_map(|(end, input)| Some((format!("{}{end}", part.name), input?))).collect()
}

/// Terminals under way.
#[derive(Default)]
struct TerminalList {
    terminals: Vec<Terminal>,
    places: HashMap<String, usize>,
    /// Variables that are members of one.
    taken: HashSet<usize>,
}

impl TerminalList {
    /// A variable becomes a member, once; names within a terminal differ.
    fn add(&mut self, owner: &str, mut member: String, variable: usize, flow: Flow) {
        if !self.taken.insert(variable) {
            return;
        }
        let place = *self.places.entry(owner.to_owned()).or_insert_with(|| {
            self.terminals.push(Terminal { name: owner.to_owned(), members: Vec::new() });
            self.terminals.len() - 1
        });
        let members = &mut self.terminals[place].members;
        while members.iter().any(|candidate| candidate.name == member) {
            member.push('_');
        }
        members.push(Member { name: member, variable, flow });
    }
}
