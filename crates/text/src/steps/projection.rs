//! Steps 1 and 2: cutsets on motion spaces, circuits on reaction spaces.

use cotree::component::{Angle, Direction, Element, Held, Known, Origin, System};
use cotree::equations::{Constraint, Edge};
use cotree::expr::Expr;
use cotree::graph::{ElementId, Translation};

use super::graphs::{list, shortened};
use super::view::View;
use super::{Lesson, check, heading, words};
use crate::document::Block;
use crate::name::Name;
use crate::tree::Tree;

pub type Rows = Vec<(Tree, Tree)>;

impl Lesson<'_> {
    /// Step 1: cutsets of branches, projected on their motion spaces.
    pub fn cutset_equations(&mut self) -> Vec<Block> {
        let mut blocks = vec![heading("6. Step 1. Which balances are needed? Cutsets on motion spaces (14)")];
        if !self.dynamic {
            blocks.push(words("The scene gives no masses: this is a kinematic analysis, and no balance is needed."));
            return blocks;
        }
        let known = self.through_variables();
        let (rows, reduced) = (self.balances(Tree::sum), self.balances(|terms| inserted(&known, terms.into_iter())));
        let none = self.without_balance();
        if rows.is_empty() {
            blocks.push(words("No branch is free to move: there are no equations of motion."));
        } else {
            blocks.push(words(
                "A branch gives one equation for each direction in which it is free to move; along the others stands an unknown reaction, \
                 and we do not look.",
            ));
            let count = rows.len();
            blocks.extend(list(rows));
            blocks.push(words("With the terminal equations; what is zero drops out:"));
            blocks.extend(list(reduced));
            blocks.push(check(
                &format!("{count} equations for {} coordinates", self.equations.coordinates.len()),
                count == self.equations.coordinates.len(),
            ));
        }
        if !none.is_empty() {
            let none: Vec<&str> = none.iter().map(String::as_str).collect();
            blocks.push(words(format!("No equation, because the motion space is empty: {}.", shortened(&none))));
        }
        let efforts = self.efforts();
        if !efforts.is_empty() {
            blocks.push(words("The cutset of a driver says what it must exert:"));
            blocks.push(Block::Equations(efforts));
        }
        blocks
    }

    /// The cutsets of T, then those of R.
    pub fn cuts(&self) -> Vec<Cut<'_>> {
        let (letters, system) = (self.letters, &self.equations.system);
        let forces = cuts(&self.translation, system, false, move |label| letters.force(label));
        forces.chain(cuts(&self.rotation, system, true, move |label| letters.torque(label))).collect()
    }

    /// The cutset of each branch, projected on each direction in which it is free; `sum` adds what is cut.
    fn balances(&self, sum: impl Fn(Vec<(bool, Tree)>) -> Tree) -> Rows {
        let mut rows = Rows::new();
        for cut in self.cuts() {
            let balance = sum(cut.terms);
            match &cut.element.translation {
                _ if cut.angular => rows.extend(is_free(cut.element).then(|| (balance, Tree::zero()))),
                row => rows.extend(row.iter().flat_map(|row| &row.motion).map(|(along, _)| {
                    (self.letters.projected(balance.clone(), *along, cut.element, true), Tree::zero())
                })),
            }
        }
        rows
    }

    /// Whole forces and torques that a terminal equation gives.
    pub fn through_variables(&mut self) -> Rows {
        let count = self.equations.system.elements.len();
        let mut known = Rows::new();
        for id in (0..count).map(ElementId) {
            let label = self.equations.system.element(id).label.clone();
            let own = [self.letters.force(&label), self.letters.torque(&label)];
            known.extend(self.says(id).into_iter().filter(|(left, _)| own.contains(left)));
        }
        known
    }

    fn without_balance(&self) -> Vec<String> {
        let without = self.cuts().into_iter().filter_map(|cut| match &cut.element.translation {
            _ if cut.angular => (!is_free(cut.element)).then(|| format!("{} (R)", cut.element.label)),
            row => row.as_ref().is_some_and(|row| row.motion.is_empty()).then(|| cut.element.label.clone()),
        });
        without.collect()
    }

    fn efforts(&self) -> Rows {
        self.by_chords(|cut| matches!(cut.element.origin, Origin::Driver(_)))
    }

    /// Through variables of some branches as sums of those of chords.
    pub fn by_chords(&self, is_one: impl Fn(&Cut) -> bool) -> Rows {
        let cuts = self.cuts().into_iter().filter(is_one);
        cuts.map(|cut| (cut.own(), Tree::sum(cut.others().collect()))).collect()
    }

    /// Step 2: circuits of chords, projected on their reaction spaces; and the displacements of slides.
    pub fn circuit_equations(&mut self) -> Vec<Block> {
        let mut blocks = vec![heading("7. Step 2. Which closures are needed? Circuits on reaction spaces (15)")];
        let loops: Vec<usize> = self.equations.loops().map(|(index, _)| index).collect();
        if loops.is_empty() {
            blocks.push(words(
                "No chord holds anything: there are no loops, no loop equations and no multipliers (m = 0).",
            ));
        } else {
            blocks.push(words(format!(
                "A chord gives one equation for each direction that it holds, and the reaction in that direction is its multiplier: m = {}.",
                loops.len()
            )));
            blocks.extend(list(self.held(false)));
            let struck = self.struck();
            if !struck.is_empty() {
                blocks.push(words("What is zero is struck:"));
                blocks.push(Block::Equations(struck));
                blocks.push(words("and there remains"));
                blocks.extend(list(self.held(true)));
            }
            blocks.extend(self.couplings());
            blocks.push(words("In the coordinates (19):"));
            let names = (0..loops.len()).map(|row| Tree::Name(Name::entry("Phi", &[row]))).collect();
            let values: Vec<Expr> = loops.iter().map(|&index| self.equations.constraints[index].value).collect();
            blocks.extend(self.equations(names, &values));
            blocks.push(self.closed(&values));
        }
        blocks.extend(self.slide_equations());
        blocks
    }

    /// Are the loops closed where the motion starts?
    fn closed(&mut self, values: &[Expr]) -> Block {
        let gaps = self.at_start(values);
        let largest = gaps.iter().fold(0.0_f64, |largest, gap| largest.max(gap.abs()));
        check(&format!("the largest of these at the start is {largest:.1e}"), largest < 1e-6)
    }

    fn couplings(&self) -> Vec<Block> {
        if !self.equations.constraints.iter().any(|constraint| !constraint.coupled.is_empty()) {
            return Vec::new();
        }
        let mut blocks = vec![words(
            "Couplings: each relation between across variables in the terminal equations is a loop equation, and its reaction is the \
             multiplier. The circuits of its chords give the variables:",
        )];
        // A rolling disc's are its own edge's, which Step 3 has anyway.
        let points = self.translation.of_terms(|label| self.letters.displacement(label));
        blocks.extend(list(points.chain(self.rotation.of_terms(|label| self.letters.angle(label))).collect()));
        blocks
    }

    /// Slides in the cotree: the circuit projected on the direction in which they slide.
    fn slide_equations(&mut self) -> Vec<Block> {
        let slides = self.slides();
        if slides.is_empty() {
            return Vec::new();
        }
        let mut blocks = vec![words(
            "Projected on the direction in which it slides, the circuit gives the slide itself, which is no coordinate (41):",
        )];
        let names: Vec<Tree> = slides.iter().map(|(name, _)| name.clone()).collect();
        blocks.extend(list(slides));
        let entries = crate::motion::slides(&mut self.equations);
        let exprs: Vec<Expr> = entries.into_iter().map(|(_, expr)| expr).collect();
        if exprs.len() == names.len() {
            blocks.extend(self.equations(names, &exprs));
        }
        blocks
    }

    /// The loop equations that are circuits of one chord.
    fn own_circuits(&self) -> impl Iterator<Item = &Constraint> {
        self.equations.loops().map(|(_, own)| own).filter(|own| own.coupled.is_empty())
    }

    /// The circuit equations; of the reduced ones what is zero is left out.
    fn held(&self, reduced: bool) -> Rows {
        self.own_circuits()
            .filter_map(|constraint| Some((self.circuit_row(constraint, reduced)?, Tree::zero())))
            .collect()
    }

    fn circuit_row(&self, constraint: &Constraint, reduced: bool) -> Option<Tree> {
        let Held::Along(along) = constraint.held else {
            let circuit = self.rotation.circuit(constraint.element)?;
            return Some(Tree::sum(self.rotation.terms(circuit, |label| self.letters.angle(label))));
        };
        let mut circuit = self.translation.circuit(constraint.element)?.clone();
        circuit.retain(|(edge, _)| !reduced || !self.is_struck(&self.translation.edges[*edge], along));
        let sum = Tree::sum(self.translation.terms(&circuit, |label| self.letters.displacement(label)));
        Some(self.held_part(sum, along, constraint.element))
    }

    /// The projection of a vector on the direction that a joint or driver holds.
    pub fn held_part(&self, vector: Tree, along: Direction, id: ElementId) -> Tree {
        let element = self.equations.system.element(id);
        // A driver holds its axis, a joint what is across it.
        self.letters.projected(vector, along, element, matches!(element.origin, Origin::Driver(_)))
    }

    /// What is zero in the circuit equations, each once.
    fn struck(&self) -> Rows {
        let mut rows = Rows::new();
        for constraint in self.own_circuits() {
            let (Held::Along(along), Some(circuit)) = (constraint.held, self.translation.circuit(constraint.element))
            else {
                continue;
            };
            let edges = circuit[1..].iter().chain(&circuit[..1]).map(|&(edge, _)| &self.translation.edges[edge]);
            for edge in edges.filter(|edge| self.is_struck(edge, along)) {
                let vector = self.letters.displacement(&edge.label);
                let left = if self.is_pin(edge) { vector } else { self.held_part(vector, along, constraint.element) };
                if !rows.iter().any(|(own, _)| *own == left) {
                    rows.push((left, Tree::zero()));
                }
            }
        }
        rows.truncate(24);
        rows
    }

    /// Is the displacement of an edge zero along a direction: a pin's, a slide's across its axis, that of an arm beside it?
    fn is_struck(&self, edge: &Edge<Translation>, along: Direction) -> bool {
        let Some(row) = &self.equations.system.element(edge.element).translation else { return false };
        let (carrier, normal) = along.in_body();
        let across = |body: Option<_>, vector: [Expr; 2]| {
            body == carrier && vector.iter().zip(&normal).all(|(a, b)| *a == Expr::ZERO || *b == Expr::ZERO)
        };
        let known = match row.known {
            Known::Zero => true,
            Known::Fixed(body, at) => across(body, at),
            Known::Along(..) | Known::Given(_) => false,
        };
        known
            && row.motion.iter().all(|(direction, _)| {
                let (body, unit) = direction.in_body();
                across(body, unit)
            })
    }

    fn is_pin(&self, edge: &Edge<Translation>) -> bool {
        let row = self.equations.system.element(edge.element).translation.as_ref();
        row.is_some_and(|row| matches!(row.known, Known::Zero) && row.motion.is_empty())
    }

    fn slides(&self) -> Rows {
        let view = &self.translation;
        let slides = view.elements(&self.equations.system, |element| matches!(element.origin, Origin::Joint(_)));
        let slides = slides.filter_map(|circuit| {
            let element = self.equations.system.element(view.own(circuit).element);
            let (along, _) = element.translation.as_ref()?.motion.first()?;
            let (_, sum) = view.by_others(circuit, |label| self.letters.displacement(label));
            Some((self.letters.slide(&element.label), self.letters.projected(sum, *along, element, true)))
        });
        slides.collect()
    }
}

/// The cutset of each branch of a graph.
fn cuts<'v, D>(
    view: &'v View<D>,
    system: &'v System,
    angular: bool,
    letter: impl Fn(&str) -> Tree + 'v,
) -> impl Iterator<Item = Cut<'v>> {
    let element = |row| system.element(view.own(row).element);
    view.cutsets.iter().map(move |row| Cut { element: element(row), angular, terms: view.terms(row, &letter) })
}

/// A cutset in letters.
pub struct Cut<'l> {
    pub element: &'l Element,
    pub angular: bool,
    /// The through variable of its branch, and those of chords, true for minus.
    terms: Vec<(bool, Tree)>,
}

impl Cut<'_> {
    pub fn own(&self) -> Tree {
        self.terms[0].1.clone()
    }

    /// The branch's variable is the sum of these.
    pub fn others(&self) -> impl Iterator<Item = (bool, Tree)> {
        self.terms[1..].iter().map(|(minus, tree)| (!minus, tree.clone()))
    }
}

pub fn is_free(element: &Element) -> bool {
    element.rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
}

/// The terms of a sum, so that it needs no parentheses.
fn opened((minus, tree): (bool, Tree)) -> Vec<(bool, Tree)> {
    match tree {
        Tree::Sum(terms) => terms.into_iter().map(|(own, term)| (own != minus, term)).collect(),
        tree => vec![(minus, tree)],
    }
}

/// A sum with what is known in its place; what is zero drops out.
pub fn inserted(known: &Rows, terms: impl Iterator<Item = (bool, Tree)>) -> Tree {
    let replaced = |tree: Tree| known.iter().find(|(own, _)| *own == tree).map_or(tree, |(_, value)| value.clone());
    let terms = terms.map(|(minus, tree)| (minus, replaced(tree)));
    Tree::sum(terms.filter(|(_, tree)| *tree != Tree::zero()).flat_map(opened).collect())
}
