//! Velocities and accelerations: (20) and (21) by the graph and by calculus.

use cotree::equations::Standing;
use cotree::expr::{Expr, Order, Symbol};
use cotree::network::{Constrained, Direction, ElementId};

use super::numbers::agree;
use super::projection::Rows;
use super::{Lesson, check, heading, words};
use crate::document::{DocumentBlock, Piece};
use crate::motion;
use crate::name::Name;
use crate::tree::FormulaTree;

impl Lesson<'_> {
    pub fn rates(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("10. How do the rates follow? Velocities (20) and accelerations (21)")];
        let loops: Vec<usize> = self.equations.loops().map(|(index, _)| index).collect();
        if loops.is_empty() {
            blocks.push(words(
                "There are no loop equations: every rate is a coordinate's, and M a = Q gives the accelerations.",
            ));
            return blocks;
        }
        let [_, (_, jacobian), (_, by_time), (_, gammas)] = motion::loops(&self.equations);
        blocks.extend(self.written([jacobian, by_time].concat()));
        blocks.extend(self.written(gammas));
        let worked = loops.iter().position(|&index| self.turns(index)).unwrap_or(0);
        blocks.extend(self.by_graph(loops[worked]));
        blocks.extend(self.by_calculus(worked, loops[worked]));
        let both = self.agrees(&loops);
        blocks.push(check("both ways give the same rates and gamma for all loop equations", both));
        blocks.extend(self.order(&loops));
        blocks
    }

    /// Does the axis of a loop equation turn?
    fn turns(&self, index: usize) -> bool {
        let constraint = &self.equations.constraints[index];
        matches!(constraint.constrained, Constrained::Along(Direction::Fixed(Some(_), _)))
            && constraint.coupled.is_empty()
    }

    /// The circuit holds for velocities and accelerations.
    fn by_graph(&mut self, index: usize) -> Vec<DocumentBlock> {
        let constraint = self.equations.constraints[index].clone();
        let Constrained::Along(along) = constraint.constrained else {
            return vec![words(
                "By the graph: the circuit holds for rates and accelerations term by term, with the same factors.",
            )];
        };
        let Some(circuit) = self.translation.record.circuit(constraint.element) else {
            return vec![words(
                "By the graph: the circuits of the coupled chords hold for velocities and accelerations, with the same factors.",
            )];
        };
        let label = &self.translation.record.edge_of(circuit).label;
        let row = |letter: &dyn Fn(&str) -> FormulaTree| {
            let sum = FormulaTree::sum(self.translation.terms(circuit, letter));
            (self.held_part(sum, along, constraint.element), FormulaTree::zero())
        };
        let mut rows = vec![row(&|label| self.letters.velocity(label)), row(&|label| self.letters.acceleration(label))];
        let text = match self.turns(index) {
            true => format!(
                "By the graph, for {}, whose axis turns: the circuit holds for velocities and accelerations, with the arms' rates of section 5; the \
                 slide enters its own loop, Coriolis term included, because its axis turns:",
                label
            ),
            false => format!(
                "By the graph, for {}: the circuit holds for velocities and accelerations, and the axis does not turn, so the arms' rates of \
                 section 5 are simply projected:",
                label
            ),
        };
        rows.extend(if self.turns(index) { self.slide(constraint.element, along) } else { Rows::new() });
        vec![words(text), DocumentBlock::Equations(rows)]
    }

    /// n.v = omega s, n.a = alpha s + 2 omega s' of a slide r = s u
    fn slide(&self, id: ElementId, along: Direction) -> Rows {
        let element = self.equations.system.element(id);
        let label = &element.label;
        if element.translation.as_ref().is_none_or(|row| row.motion.is_empty()) {
            return Rows::new();
        }
        let name = |letter: &str| FormulaTree::Name(Name::word(letter));
        let (s, rate) = (self.letters.slide(label), self.letters.rate_of_slide(label));
        let projected = |vector: FormulaTree| self.letters.projected(vector, along, element, false);
        let coriolis = FormulaTree::product(vec![FormulaTree::Number(2.0), name("omega"), rate]);
        let tangential = FormulaTree::product(vec![name("alpha"), s.clone()]);
        vec![
            (projected(self.letters.velocity(label)), FormulaTree::product(vec![name("omega"), s])),
            (
                projected(self.letters.acceleration(label)),
                FormulaTree::Sum(vec![(false, tangential), (false, coriolis)]),
            ),
        ]
    }

    fn by_calculus(&mut self, row: usize, index: usize) -> Vec<DocumentBlock> {
        let terms = self.calculus(index);
        let matrix = |below: &str| FormulaTree::Name(Name::matrix("Phi", below));
        let speeds = || FormulaTree::Name(Name::column("v", ""));
        let minus = |factors: Vec<FormulaTree>| FormulaTree::Sum(vec![(true, FormulaTree::product(factors))]);
        let (mut names, mut exprs) = (Vec::new(), Vec::new());
        for (left, expr) in [
            minus(vec![matrix("qq"), speeds(), speeds()]),
            minus(vec![FormulaTree::Number(2.0), matrix("qt"), speeds()]),
            minus(vec![matrix("tt")]),
        ]
        .into_iter()
        .zip(terms)
        {
            if expr != Expr::ZERO {
                names.push(left);
                exprs.push(expr);
            }
        }
        let text = format!(
            "By calculus, gamma has three terms: the derivatives of loop equation {}, as it stands in section 7, twice by the coordinates, by them \
             and time, and twice by time{}:",
            row + 1,
            if exprs.len() == 3 { "" } else { "; terms that are not listed are zero" }
        );
        let mut blocks = vec![words(text)];
        blocks.extend(self.equations(names, &exprs));
        blocks
    }

    /// The terms of gamma (21) by the rates, by rates and time, and by time, from derivatives of Phi alone.
    fn calculus(&mut self, index: usize) -> [Expr; 3] {
        let value = self.equations.constraints[index].value;
        let n = self.equations.coordinates.len();
        let along = |lesson: &mut Self, expr: Expr| {
            let mut sum = Expr::ZERO;
            for column in 0..n {
                let arena = &mut lesson.equations.system.arena;
                let slope = arena.derivative(expr, Symbol::Coordinate(column, Order::Position));
                let speed = arena.symbol(Symbol::Coordinate(column, Order::Velocity));
                sum = arena.add_product(sum, slope, speed);
            }
            sum
        };
        let rate = along(self, value);
        let second = along(self, rate);
        let mixed = self.by_time(rate);
        let time = self.by_time(value);
        let time = self.by_time(time);
        let arena = &mut self.equations.system.arena;
        let twice = arena.constant(-2.0);
        [arena.negate(second), arena.multiply(twice, mixed), arena.negate(time)]
    }

    /// The partial derivative by time, through inputs and the drivers that follow them.
    fn by_time(&mut self, expr: Expr) -> Expr {
        let arena = &mut self.equations.system.arena;
        let mut sum = arena.derivative(expr, Symbol::Time);
        for symbol in arena.symbols([expr]) {
            let next = match symbol {
                Symbol::Input(input, order) => order.next().map(|next| Symbol::Input(input, next)),
                Symbol::Follower(follower, order) => order.next().map(|next| Symbol::Follower(follower, next)),
                Symbol::Time | Symbol::Parameter(_) | Symbol::Discrete(_) | Symbol::Coordinate(..) => None,
                // No prescribed motion depends on a state.
                Symbol::State(..) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => None,
            };
            if let Some(next) = next {
                let (slope, rate) = (arena.derivative(expr, symbol), arena.symbol(next));
                sum = arena.add_product(sum, slope, rate);
            }
        }
        sum
    }

    /// Phi_q, Phi_t and gamma from the graph against derivatives of Phi, where the loops are closed and everything moves.
    fn agrees(&mut self, loops: &[usize]) -> bool {
        let values = self.moving();
        let (mut graph, mut calculus) = (Vec::new(), Vec::new());
        for &index in loops {
            let constraint = self.equations.constraints[index].clone();
            let terms = self.calculus(index);
            for (column, entry) in constraint.jacobian {
                graph.push(entry);
                let symbol = Symbol::Coordinate(column, Order::Position);
                calculus.push(self.equations.system.arena.derivative(constraint.value, symbol));
            }
            graph.extend([constraint.time_rate, constraint.gamma]);
            calculus.push(self.by_time(constraint.value));
            calculus.push(self.equations.system.arena.sum(terms));
        }
        agree(&values.of(&self.equations, &graph), &values.of(&self.equations, &calculus))
    }

    /// Where the drivers prescribe everything: which equation gives which coordinate, read from the zeros in Phi_q.
    fn order(&self, loops: &[usize]) -> Vec<DocumentBlock> {
        let mut open: Vec<usize> = (0..self.equations.coordinates.len()).collect();
        let always =
            |&(_, index): &(usize, usize)| self.equations.constraints[index].standing() == Some(Standing::Imposed);
        let mut rows: Vec<(usize, usize)> = loops.iter().copied().enumerate().filter(always).collect();
        if rows.len() != open.len() || rows.is_empty() {
            return Vec::new();
        }
        let mut steps = Vec::new();
        loop {
            let alone = rows.iter().position(|&(_, index)| self.columns(index, &open).len() == 1);
            let Some((number, index)) = alone.map(|place| rows.remove(place)) else { break };
            let column = self.columns(index, &open)[0];
            open.retain(|other| *other != column);
            let name = FormulaTree::Name(Name::symbol(&self.equations.coordinates[column].name.position));
            steps.push(Piece::words(if steps.is_empty() { "" } else { ", then " }));
            steps.extend([Piece::Math(name), Piece::words(" from ")]);
            steps.push(Piece::Math(FormulaTree::Name(Name::entry("Phi", &[number]))));
        }
        if !open.is_empty() {
            let before = if steps.is_empty() { "" } else { ", then " };
            steps.push(Piece::words(format!("{before}the other {} together", open.len())));
        }
        let text = Piece::words("Order of solution, read from the zeros in the Jacobian: ");
        vec![DocumentBlock::Text(std::iter::once(text).chain(steps).chain([Piece::words(".")]).collect())]
    }

    fn columns(&self, index: usize, open: &[usize]) -> Vec<usize> {
        let jacobian = &self.equations.constraints[index].jacobian;
        jacobian.iter().map(|(column, _)| *column).filter(|column| open.contains(column)).collect()
    }
}
