//! The terminal equations of couplings: the relation between across variables, and the loads factor x reaction (the transposed
//! relation), times the slope where an angle is the argument of a function.

use cotree::expr::{Expr, Symbol};
use cotree::network::{CouplingTerm, Direction, Element, ElementId, Port};

use super::{TerminalWriter, sum};
use crate::name::symbol_name;
use crate::steps::projection::Rows;
use crate::tree::FormulaTree;

impl TerminalWriter<'_> {
    /// The first across variable by the others: their factors change sides, and that of the first divides them.
    pub fn relation(&mut self, id: ElementId, element: &Element) -> Rows {
        let Some((first, others)) = element.coupling.as_ref().and_then(|coupling| coupling.terms.split_first()) else {
            return Rows::new();
        };
        let (mut terms, mut within) = (Vec::new(), Vec::new());
        for (index, term) in others.iter().enumerate() {
            let arena = &mut self.equations.system.arena;
            let minus = arena.negate(term.factor);
            let minus = arena.divide(minus, first.factor);
            let motion = self.across(id, element, index + 1, term);
            if let Port::Curve(_, curve) = term.port {
                let value = self.equations.system.arena.multiply(minus, curve.value[0]);
                terms.push((self.formula(value), None));
                within.push(motion);
            } else {
                terms.push((self.formula(minus), Some(motion)));
            }
        }
        let offset = element.coupling.as_ref().map_or(Expr::ZERO, |coupling| coupling.offset);
        let offset = self.equations.system.arena.divide(offset, first.factor);
        terms.push((self.formula(offset), None));
        let mut rows = vec![(self.across(id, element, 0, first), sum(terms))];
        // A function of an angle repeats every turn.
        let turn = || FormulaTree::product(vec![FormulaTree::Number(2.0), FormulaTree::Pi]);
        let theta = || FormulaTree::Name(symbol_name(self.equations, Symbol::Argument));
        rows.extend(within.into_iter().map(|angle| (theta(), FormulaTree::Call("mod", vec![angle, turn()]))));
        // The axis of a rolling disc is among its own rows.
        for term in std::iter::once(first).chain(others).filter(|_| element.translation.is_none()) {
            if let Port::Along(_, along @ Direction::Fixed(body, axis)) = term.port {
                rows.push((self.letters.direction(along, element, true), self.turned(body, axis)));
            }
        }
        rows
    }

    pub fn loads(&mut self, id: ElementId, element: &Element) -> Rows {
        let index = self.equations.constraints.iter().position(|row| row.element == id && !row.coupled.is_empty());
        let (Some(coupling), Some(index)) = (&element.coupling, index) else { return Rows::new() };
        let multiplier = FormulaTree::Name(symbol_name(self.equations, Symbol::Reaction(index)));
        let gap = self.equations.constraints[index].contact().cloned();
        let reaction = match gap.and_then(|gap| gap.slip) {
            Some(slip) => {
                let level = FormulaTree::Name(symbol_name(self.equations, Symbol::Reaction(index + 1)));
                FormulaTree::Sum(vec![(false, multiplier), (false, self.times(slip.direction, level))])
            }
            None => multiplier,
        };
        let row = |(number, term): (usize, &CouplingTerm)| {
            let label = self.label(id, element, number);
            let times = |vector: FormulaTree| FormulaTree::product(vec![reaction.clone(), vector]);
            let (force, torque) = (self.letters.force(label), self.letters.torque(label));
            match term.port {
                Port::Angle(_) => (torque, self.times(term.factor, reaction.clone())),
                Port::Curve(_, curve) => {
                    let slope = self.equations.system.arena.multiply(term.factor, curve.value[1]);
                    (torque, self.times(slope, reaction.clone()))
                }
                Port::Along(_, along) if element.translation.is_some() => {
                    let projected = self.letters.projected(force, along, element, true);
                    (projected, self.times(term.factor, reaction.clone()))
                }
                Port::Along(_, along) => {
                    (force, self.times(term.factor, times(self.letters.direction(along, element, true))))
                }
                Port::Feature(..) => {
                    let normal = FormulaTree::Call("normal", vec![self.letters.displacement(label)]);
                    (force, self.times(term.factor, times(normal)))
                }
                Port::Length(_) => (force, self.times(term.factor, times(self.unit(label)))),
                Port::Span(_, tangent) => (force, self.times(term.factor, times(self.unit_tangent(label, tangent)))),
                Port::Heading(_) => {
                    let across = FormulaTree::Call("turned", vec![self.unit(label)]);
                    let length = FormulaTree::Call("abs", vec![self.letters.displacement(label)]);
                    (force, self.times(term.factor, times(FormulaTree::quotient(vec![across], vec![length]))))
                }
            }
        };
        coupling.terms.iter().enumerate().map(row).collect()
    }

    /// theta, r . u, or |r|; a rolling disc's r . u is its slide.
    fn across(&self, id: ElementId, element: &Element, number: usize, term: &CouplingTerm) -> FormulaTree {
        let label = self.label(id, element, number);
        match term.port {
            Port::Angle(_) | Port::Curve(..) => self.letters.angle(label),
            Port::Along(..) if element.translation.is_some() => self.letters.slide(label),
            Port::Along(_, along) => self.letters.projected(self.letters.displacement(label), along, element, true),
            Port::Feature(..) => FormulaTree::Call("gap", vec![self.letters.displacement(label)]),
            Port::Length(_) => FormulaTree::Call("abs", vec![self.letters.displacement(label)]),
            Port::Heading(_) => FormulaTree::Call("heading", vec![self.letters.displacement(label)]),
            Port::Span(_, tangent) => {
                let straight = self.straight_length(label, tangent);
                if tangent.difference == Expr::ZERO {
                    return straight;
                }
                let heading = FormulaTree::Call("heading", vec![self.unit_tangent(label, tangent)]);
                let arc = FormulaTree::product(vec![self.formula(tangent.difference), heading]);
                FormulaTree::Sum(vec![(false, straight), (true, arc)])
            }
        }
    }

    /// The label of a term's edge: the element's own if it acts there.
    fn label<'l>(&'l self, id: ElementId, element: &'l Element, term: usize) -> &'l str {
        let label = self.translation.term(id, term).or_else(|| self.rotation.term(id, term));
        label.unwrap_or(&element.label)
    }
}
