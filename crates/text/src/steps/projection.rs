//! Steps 1 and 2: cutsets on motion spaces, circuits on reaction spaces.

use cotree::component::{Angle, Direction, Element, Held, Known, Origin};
use cotree::equations::Constraint;
use cotree::expr::Expr;
use cotree::graph::ElementId;

use super::graphs::{list, shortened};
use super::view::{Edge, TopologyRow, View};
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
        let mut cuts = Vec::new();
        let mut add = |branch: (&str, ElementId), cutset: TopologyRow, angular: bool, letter: &dyn Fn(&str) -> Tree| {
            let element = self.equations.system.element(branch.1);
            let chords = cutset.iter().map(|(label, sign)| (*sign < 0, letter(label))).collect();
            cuts.push(Cut { element, angular, own: letter(branch.0), chords });
        };
        for (branch, cutset) in self.translation.branches.iter().zip(self.translation.cutsets()) {
            add((&branch.label, branch.element), cutset, false, &|label| self.letters.force(label));
        }
        for (branch, cutset) in self.rotation.branches.iter().zip(self.rotation.cutsets()) {
            add((&branch.label, branch.element), cutset, true, &|label| self.letters.torque(label));
        }
        cuts
    }

    /// The cutset of each branch, projected on each direction in which it is free; `sum` adds what is cut.
    fn balances(&self, sum: impl Fn(Vec<(bool, Tree)>) -> Tree) -> Rows {
        let mut rows = Rows::new();
        for cut in self.cuts() {
            let terms: Vec<_> = std::iter::once((false, cut.own.clone())).chain(cut.chords.iter().cloned()).collect();
            match &cut.element.translation {
                _ if cut.angular => rows.extend(is_free(cut.element).then(|| (sum(terms), Tree::zero()))),
                row => rows.extend(row.iter().flat_map(|row| &row.motion).map(|(along, _)| {
                    (self.letters.projected(sum(terms.clone()), *along, cut.element, true), Tree::zero())
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
        cuts.map(|cut| (cut.own.clone(), Tree::sum(cut.others().collect()))).collect()
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
        blocks.extend(list(self.coupled()));
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
            let chord = self.rotation.chord(constraint.element)?;
            return Some(signed(Some(&chord.label), &self.rotation.circuit(chord), |label| self.letters.angle(label)));
        };
        let chord = self.translation.chord(constraint.element)?;
        let keeps = |label: &str| !reduced || !self.is_struck(label, along);
        let circuit: TopologyRow =
            self.translation.circuit(chord).into_iter().filter(|(label, _)| keeps(label)).collect();
        let own = keeps(&chord.label).then_some(chord.label.as_str());
        let sum = signed(own, &circuit, |label| self.letters.displacement(label));
        let element = self.equations.system.element(constraint.element);
        Some(self.letters.projected(sum, along, element, is_along(element)))
    }

    /// What is zero in the circuit equations, each once.
    fn struck(&self) -> Rows {
        let mut rows = Rows::new();
        for constraint in self.own_circuits() {
            let (Held::Along(along), Some(chord)) = (constraint.held, self.translation.chord(constraint.element))
            else {
                continue;
            };
            let element = self.equations.system.element(constraint.element);
            let others = self.translation.circuit(chord).into_iter().map(|(label, _)| label);
            for label in others.chain([chord.label.clone()]).filter(|label| self.is_struck(label, along)) {
                let vector = self.letters.displacement(&label);
                let left = match self.is_pin(&label) {
                    true => vector,
                    false => self.letters.projected(vector, along, element, is_along(element)),
                };
                if !rows.iter().any(|(own, _)| *own == left) {
                    rows.push((left, Tree::zero()));
                }
            }
        }
        rows.truncate(24);
        rows
    }

    /// Is the displacement of an edge zero along a direction: a pin's, a slide's across its axis, that of an arm beside it?
    fn is_struck(&self, label: &str, along: Direction) -> bool {
        let system = &self.equations.system;
        let Some(element) = system.elements.iter().find(|element| element.label == label) else { return false };
        let Some(row) = &element.translation else { return false };
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

    fn is_pin(&self, label: &str) -> bool {
        let element = self.equations.system.elements.iter().find(|element| element.label == label);
        let row = element.and_then(|element| element.translation.as_ref());
        row.is_some_and(|row| matches!(row.known, Known::Zero) && row.motion.is_empty())
    }

    /// The across variables of the terms of couplings, but for those that Step 3 has anyway: a rolling disc's.
    fn coupled(&self) -> Rows {
        let (displacement, angle) =
            (|label: &str| self.letters.displacement(label), |label: &str| self.letters.angle(label));
        let points = self.translation.chords.iter().filter(|chord| chord.is_term);
        let points = points.map(|chord| by_branches(&self.translation, chord, displacement));
        let bodies = self.rotation.chords.iter().filter(|chord| chord.is_term);
        points.chain(bodies.map(|chord| by_branches(&self.rotation, chord, angle))).collect()
    }

    fn slides(&self) -> Rows {
        let slides = self.translation.chords.iter().filter(|chord| !chord.is_term).filter_map(|chord| {
            let element = self.equations.system.element(chord.element);
            let along: Direction = match (element.origin, &element.translation) {
                (Origin::Joint(_), Some(row)) => row.motion.first().map(|(along, _)| *along)?,
                _ => return None,
            };
            let sum = signed(None, &self.translation.path(chord), |label| self.letters.displacement(label));
            Some((self.letters.slide(&chord.label), self.letters.projected(sum, along, element, true)))
        });
        slides.collect()
    }
}

/// A cutset in letters: the through variable of its branch, and those of the chords with their signs, true for minus.
pub struct Cut<'l> {
    pub element: &'l Element,
    pub angular: bool,
    pub own: Tree,
    chords: Vec<(bool, Tree)>,
}

impl Cut<'_> {
    /// The branch's variable is the sum of these.
    pub fn others(&self) -> impl Iterator<Item = (bool, Tree)> {
        self.chords.iter().map(|(minus, tree)| (!minus, tree.clone()))
    }
}

pub fn is_free(element: &Element) -> bool {
    element.rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
}

/// Is the direction that a joint holds its axis, and not across it?
pub fn is_along(element: &Element) -> bool {
    matches!(element.origin, Origin::Driver(_))
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

/// An across variable of a chord as a sum of those of branches.
pub fn by_branches<D>(view: &View<D>, chord: &Edge<D>, letter: impl Fn(&str) -> Tree) -> (Tree, Tree) {
    (letter(&chord.label), signed(None, &view.path(chord), &letter))
}

/// A sum of variables of edges with the signs of a row.
pub fn signed(own: Option<&str>, row: &TopologyRow, letter: impl Fn(&str) -> Tree) -> Tree {
    let others = row.iter().map(|(label, sign)| (*sign < 0, letter(label)));
    Tree::sum(own.map(|label| (false, letter(label))).into_iter().chain(others).collect())
}
