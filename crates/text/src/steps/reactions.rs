//! Reactions: the cutsets that Step 1 did not use, on the reaction spaces of their branches; and the numbers of the start.

use cotree::equations::RowKind;
use cotree::expr::{Expr, Order, Symbol};
use cotree::formulate::equations;
use cotree::model::{BodyId, CoordinateChoice, Mechanism, Owner, Place, Quantity, Variable};
use cotree::network::{Constrained, ElementId, Origin};

use super::graphs::list;
use super::numbers::{Moment, agree, short};
use super::projection::{Cut, Rows, inserted, is_free};
use super::{Lesson, check, heading, words};
use crate::document::{DocumentBlock, Piece};
use crate::motion::{self, dynamics};
use crate::name::{Name, symbol_name};
use crate::tree::FormulaTree;

/// Larger systems in absolute coordinates are not solved for the check.
const LARGEST: usize = 150;

impl Lesson<'_> {
    pub fn reactions(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("11. Which reactions? The cutsets not used in Step 1, on reaction spaces")];
        if !self.dynamic {
            blocks.push(words("Without masses there is nothing to balance: reactions are not asked for."));
            let mut values = self.start();
            if !self.equations.coordinates.is_empty() && values.solve(&mut self.equations).is_some() {
                blocks.extend(self.numbers(&values));
            }
            return blocks;
        }
        let rows = self.tree_joints();
        if rows.is_empty() {
            blocks.push(words("No joint is in a tree: every reaction is a multiplier."));
        } else {
            blocks.push(words("Joints in the trees, on their second side; first the cutset, then with the terminal equations of what it holds:"));
            blocks.extend(list(rows));
        }
        blocks.extend(self.multipliers());
        let system = &self.equations.system;
        if (0..system.elements.len()).any(|index| system.curve(ElementId(index)).is_some()) {
            blocks.push(words(
                "A cam's coupling has the load along the guide alone. The normal force of the contact passes through the shaft and the \
                 guide: beside what stands above they carry a share of it, the multiplier times a function of the cam's angle. \
                 It does no work, and the numbers have it.",
            ));
        }
        if let Err(why) = &self.modes {
            blocks.push(words(format!("The motion does not begin, so there are no numbers to check: {why}")));
            return blocks;
        }
        let mut values = self.start();
        if values.solve(&mut self.equations).is_some() {
            blocks.extend(self.numbers(&values));
            blocks.extend(self.against_absolute(&values));
            blocks.push(self.power(&values));
        } else {
            blocks.push(words("At the start the equations are singular: there are no numbers to check."));
        }
        blocks
    }

    /// F and T of the joints that are branches, by their cutsets, in two steps.
    fn tree_joints(&mut self) -> Rows {
        let known = self.through_variables();
        let holds = |cut: &Cut| match &cut.element.translation {
            _ if cut.angular => cut.element.rotation.is_some() && !is_free(cut.element),
            row => row.as_ref().is_some_and(|row| !row.reaction.is_empty()),
        };
        let joints = self.cuts().into_iter().filter(|cut| matches!(cut.element.origin, Origin::Joint(_)) && holds(cut));
        let both = joints.flat_map(|cut| {
            let [whole, with] = [FormulaTree::sum(cut.others().collect()), inserted(&known, cut.others())];
            [(cut.of_branch(), whole), (cut.of_branch(), with)]
        });
        both.collect()
    }

    fn multipliers(&self) -> Vec<DocumentBlock> {
        let rows: Rows = self
            .equations
            .loops()
            .enumerate()
            .filter(|(_, (_, constraint))| constraint.coupled.is_empty())
            .map(|(row, (_, constraint))| {
                let element = self.equations.system.element(constraint.element);
                let lambda = FormulaTree::Name(Name::entry("lambda", &[row]));
                let left = match constraint.constrained {
                    Constrained::Along(along) => {
                        self.held_part(self.letters.force(&element.label), along, constraint.element)
                    }
                    _ => self.letters.torque(&element.label),
                };
                (left, lambda)
            })
            .collect();
        if rows.is_empty() {
            return Vec::new();
        }
        let text = "Joints and drivers in the cotrees: their reactions are the multipliers themselves:";
        std::iter::once(words(text)).chain(list(rows)).collect()
    }

    /// Coordinates, rates, accelerations, multipliers and reactions at the start.
    fn numbers(&mut self, values: &Moment) -> Vec<DocumentBlock> {
        let mut rows = Vec::new();
        for (index, coordinate) in self.equations.coordinates.iter().enumerate() {
            let of = |list: &[f64]| list.get(index).copied().unwrap_or(0.0);
            let numbers = [of(&values.positions), of(&values.rates), of(&values.accelerations)];
            for (name, number) in [&coordinate.name.position, &coordinate.name.rate, &coordinate.name.acceleration]
                .into_iter()
                .zip(numbers)
            {
                rows.push((FormulaTree::Name(Name::symbol(name)), FormulaTree::number(short(number))));
            }
        }
        for (row, (index, _)) in self.equations.loops().enumerate().filter(|_| self.dynamic) {
            rows.push((
                FormulaTree::Name(Name::entry("lambda", &[row])),
                FormulaTree::number(short(values.reactions[index])),
            ));
        }
        let levels = self
            .equations
            .constraints
            .iter()
            .enumerate()
            .filter(|(_, row)| matches!(row.kind, RowKind::FrictionLimit | RowKind::DrivenContact(_)));
        for (index, _) in levels.filter(|_| self.dynamic) {
            let name = symbol_name(&self.equations, Symbol::Reaction(index));
            rows.push((FormulaTree::Name(name), FormulaTree::number(short(values.reactions[index]))));
        }
        let few = self.dynamic && self.equations.coordinates.len() <= 3;
        let mut reactions = if few { self.entries() } else { Vec::new() };
        reactions.extend(motion::slides(&mut self.equations));
        if self.dynamic {
            reactions.extend(motion::held(&mut self.equations));
        }
        let exprs: Vec<Expr> = reactions.iter().map(|(_, expr)| *expr).collect();
        let numbers = values.of(&self.equations, &exprs);
        rows.extend(
            reactions
                .into_iter()
                .zip(numbers)
                .map(|((name, _), number)| (FormulaTree::Name(name), FormulaTree::number(short(number)))),
        );
        let time = FormulaTree::number(short(values.time));
        let text = DocumentBlock::Text(vec![
            Piece::words("At the start, t = "),
            Piece::Math(time),
            Piece::words(" s, in SI units:"),
        ]);
        let mut blocks = vec![text];
        blocks.extend(if rows.len() <= 40 { vec![DocumentBlock::Equations(rows)] } else { list(rows) });
        blocks
    }

    /// The entries of M, Q, Phi_q and gamma.
    fn entries(&mut self) -> Vec<(Name, Expr)> {
        let [(_, mut entries), (_, load)] = dynamics(&mut self.equations);
        entries.extend(load);
        let [_, (_, jacobian), _, (_, gammas)] = motion::loops(&self.equations);
        entries.extend(jacobian.into_iter().chain(gammas));
        entries
    }

    /// Accelerations of the bodies and joint forces against those in absolute coordinates, where all is found in another way.
    fn against_absolute(&mut self, values: &Moment) -> Vec<DocumentBlock> {
        let mechanism = &*self.source.equations.system.mechanism.clone();
        let Ok(mut other) = equations(mechanism, &CoordinateChoice::Absolute) else { return Vec::new() };
        let size = other.coordinates.len() + other.loops().count();
        if size > LARGEST {
            return vec![words(format!("In absolute coordinates these would be {size} equations: not solved here."))];
        }
        let mut absolute = self.in_mode(Moment::new(mechanism, &self.source.state));
        let wanted = other.coordinates.clone();
        for (order, list) in [(Order::Position, 0), (Order::Velocity, 1)] {
            let exprs: Vec<Expr> = wanted.iter().map(|name| self.source.equations.value_of(name, order)).collect();
            let start = self.in_mode(Moment::new(mechanism, &self.source.state));
            let numbers = start.of(&self.source.equations, &exprs);
            if list == 0 { absolute.positions = numbers } else { absolute.rates = numbers }
        }
        if absolute.solve(&mut other).is_none() {
            return vec![words(
                "In absolute coordinates some conditions repeat others: these trees are not used for a check.",
            )];
        }
        let variables = compared(mechanism);
        let mine: Vec<Expr> = variables.iter().map(|&variable| self.equations.variable(variable)).collect();
        let theirs: Vec<Expr> = variables.iter().map(|&variable| other.variable(variable)).collect();
        let same = agree(&values.of(&self.equations, &mine), &absolute.of(&other, &theirs));
        let text = format!(
            "the absolute trees of section 12, {size} equations, give the same accelerations of all bodies and forces of all joints"
        );
        vec![check(&text, same)]
    }

    /// The kinetic energy grows by the power of all loads, weights and drivers.
    fn power(&mut self, values: &Moment) -> DocumentBlock {
        let kinetic = self.equations.variable(Variable { owner: Owner::System, quantity: Quantity::KineticEnergy });
        let growth = self.equations.system.arena.time_derivative(kinetic);
        let mechanism = &*self.equations.system.mechanism.clone();
        let owners: Vec<Owner> = mechanism.parts().map(|part| part.owner).collect();
        let mut powers: Vec<Expr> = owners
            .into_iter()
            .map(|owner| self.equations.variable(Variable { owner, quantity: Quantity::Power }))
            .collect();
        let gravity = mechanism.gravity.each_ref().map(|component| self.equations.system.value(component));
        for (index, body) in mechanism.bodies.iter().enumerate().filter(|(_, body)| !body.weightless) {
            let Some(mass) = body.mass.as_ref().map(|mass| self.equations.system.value(mass)) else { continue };
            for (quantity, component) in [Quantity::Vx, Quantity::Vy].into_iter().zip(gravity) {
                let owner = Owner::Place(Place::Centre(BodyId(index)));
                let speed = self.equations.variable(Variable { owner, quantity });
                let arena = &mut self.equations.system.arena;
                let weight = arena.multiply(mass, component);
                powers.push(arena.multiply(weight, speed));
            }
        }
        let total: f64 = values.of(&self.equations, &powers).iter().sum();
        let grown = values.of(&self.equations, &[growth])[0];
        let size = values.of(&self.equations, &powers).iter().fold(1e-6_f64, |size, value| size.max(value.abs()));
        let holds = (total - grown).abs() <= 1e-6 * size.max(grown.abs());
        check(
            &format!(
                "the kinetic energy grows by {} W, loads, weights, drivers and friction give {} W",
                short(grown),
                short(total)
            ),
            holds,
        )
    }
}

/// Accelerations of the bodies, forces of the joints.
fn compared(mechanism: &Mechanism) -> Vec<Variable> {
    let bodies = (0..mechanism.bodies.len()).map(|index| Owner::Place(Place::Centre(BodyId(index))));
    let plane = mechanism.dimension == cotree::model::Dimension::Two;
    let quantities: &[Quantity] = if plane { &[Quantity::Ax, Quantity::Ay, Quantity::Alpha] } else { &[Quantity::Ax] };
    let motions = bodies.flat_map(|owner| quantities.iter().map(move |&quantity| Variable { owner, quantity }));
    let forces = mechanism.joint_reactions().into_iter();
    motions.chain(forces).collect()
}
