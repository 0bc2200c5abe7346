//! The terminal equations of couplings: the relation between across variables, and the loads factor x reaction (the transposed
//! relation), times the slope where an angle is the argument of a function.

use cotree::component::{Direction, Port, System, Term};
use cotree::equations::Equations;
use cotree::expr::Symbol;
use cotree::graph::ElementId;
use cotree::mechanism::BodyId;

use super::{Rows, Side, turned, unit};
use crate::name::symbol_name;
use crate::steps::letters::Letters;
use crate::tree::Tree;

/// The first across variable by the others: their factors change sides. The factor of the first is one.
pub fn relation(equations: &mut Equations, letters: Letters, id: ElementId, rows: &mut Rows) {
    let element = equations.system.element(id).clone();
    let Some(coupling) = &element.coupling else { return };
    let Some((first, others)) = coupling.terms.split_first() else { return };
    let (mut terms, mut within) = (Vec::new(), Vec::new());
    for (index, term) in others.iter().enumerate() {
        let minus = equations.system.arena.negate(term.factor);
        let own = across(&equations.system, letters, id, index + 1, term);
        if let Port::Curve(_, curve) = term.port {
            terms.push((equations.system.arena.multiply(minus, curve.value[0]), None));
            within.push(own);
        } else {
            terms.push((minus, Some(own)));
        }
    }
    terms.push((coupling.offset, None));
    rows.push((across(&equations.system, letters, id, 0, first), Side::Sum(terms)));
    // A function of an angle repeats every turn.
    let turn = || Tree::product(vec![Tree::Number(2.0), Tree::Pi]);
    let theta = || Tree::Name(symbol_name(equations, Symbol::Argument));
    rows.extend(within.into_iter().map(|angle| (theta(), Side::Tree(Tree::Call("mod", vec![angle, turn()])))));
    // The axis of a rolling disc is among its own rows.
    for term in coupling.terms.iter().filter(|_| element.translation.is_none()) {
        if let Port::Along(_, along @ Direction::Fixed(body, axis)) = term.port {
            rows.push((letters.direction(along, &element, true), turned(equations, letters, body, axis)));
        }
    }
}

pub fn loads(equations: &mut Equations, letters: Letters, id: ElementId, rows: &mut Rows) {
    let element = &equations.system.element(id).clone();
    let index = equations.constraints.iter().position(|row| row.element == id && !row.coupled.is_empty());
    let (Some(coupling), Some(index)) = (&element.coupling, index) else { return };
    let name = symbol_name(equations, Symbol::Reaction(index));
    let reaction = || Tree::Name(name.clone());
    for (number, term) in coupling.terms.iter().enumerate() {
        let label = label(&equations.system, id, number);
        let row = match term.port {
            Port::Angle(_) => (letters.torque(&label), Side::times(term.factor, reaction())),
            Port::Curve(_, curve) => {
                let slope = equations.system.arena.multiply(term.factor, curve.value[1]);
                (letters.torque(&label), Side::times(slope, reaction()))
            }
            Port::Along(_, along) if element.translation.is_some() => {
                let projected = letters.projected(letters.force(&label), along, element, true);
                (projected, Side::times(term.factor, reaction()))
            }
            Port::Along(_, along) => {
                let vector = Tree::product(vec![reaction(), letters.direction(along, element, true)]);
                (letters.force(&label), Side::times(term.factor, vector))
            }
            Port::Length(_) => {
                let vector = Tree::product(vec![reaction(), unit(letters, &label)]);
                (letters.force(&label), Side::times(term.factor, vector))
            }
        };
        rows.push(row);
    }
}

/// Couplings along an axis that turns with a body; one on its own element's edge is that element's.
pub fn carried(system: &System, body: BodyId) -> Vec<String> {
    let edges = system.coupled_points().into_iter().filter(|edge| {
        let terms = system.element(edge.element).coupling.iter().flat_map(|coupling| &coupling.terms);
        let mut ports = terms.skip(edge.term).map(|term| term.port);
        matches!(ports.next(), Some(Port::Along(_, direction)) if direction.carrier() == Some(body))
    });
    edges.map(|edge| edge.label).collect()
}

/// theta, r . u, or |r|; a rolling disc's r . u is its slide.
fn across(system: &System, letters: Letters, id: ElementId, number: usize, term: &Term) -> Tree {
    let element = system.element(id);
    let label = label(system, id, number);
    match term.port {
        Port::Angle(_) | Port::Curve(..) => letters.angle(&label),
        Port::Along(..) if element.translation.is_some() => letters.slide(&label),
        Port::Along(_, along) => letters.projected(letters.displacement(&label), along, element, true),
        Port::Length(_) => Tree::Call("abs", vec![letters.displacement(&label)]),
    }
}

/// The label of a term's edge: the element's own if it acts there.
fn label(system: &System, id: ElementId, term: usize) -> String {
    let points = system.coupled_points().into_iter().map(|edge| (edge.element, edge.term, edge.label));
    let bodies = system.coupled_bodies().into_iter().map(|edge| (edge.element, edge.term, edge.label));
    let own = points.chain(bodies).find(|(element, number, _)| (*element, *number) == (id, term));
    own.map_or_else(|| system.element(id).label.clone(), |(.., label)| label)
}
