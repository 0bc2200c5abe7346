//! Steps 1 and 2: cutsets on motion spaces, circuits on reaction spaces.

use cotree::equations::{Edge, RowKind};
use cotree::expr::Expr;
use cotree::network::{Angle, Constrained, Direction, Element, ElementId, Known, Origin, System, Translation};

use super::graphs::{list, shortened};
use super::view::GraphView;
use super::{Lesson, check, heading, words};
use crate::document::DocumentBlock;
use crate::modes::{Modes, indicators};
use crate::name::Name;
use crate::tree::FormulaTree;

pub type Rows = Vec<(FormulaTree, FormulaTree)>;

impl Lesson<'_> {
    /// Step 1: cutsets of branches, projected on their motion spaces.
    pub fn cutset_equations(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("6. Step 1. Which balances are needed? Cutsets on motion spaces (14)")];
        if !self.dynamic {
            blocks.push(words("The scene gives no masses: this is a kinematic analysis, and no balance is needed."));
            return blocks;
        }
        let known = self.through_variables();
        let (rows, reduced) =
            (self.balances(FormulaTree::sum), self.balances(|terms| inserted(&known, terms.into_iter())));
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
            blocks.push(DocumentBlock::Equations(efforts));
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
    fn balances(&self, sum: impl Fn(Vec<(bool, FormulaTree)>) -> FormulaTree) -> Rows {
        let mut rows = Rows::new();
        for cut in self.cuts() {
            let balance = sum(cut.terms);
            match &cut.element.translation {
                _ if cut.angular => rows.extend(is_free(cut.element).then(|| (balance, FormulaTree::zero()))),
                row => rows.extend(row.iter().flat_map(|row| &row.motion).map(|(along, _)| {
                    (self.letters.projected(balance.clone(), *along, cut.element, true), FormulaTree::zero())
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
            let reactions = [self.letters.force(&label), self.letters.torque(&label)];
            known.extend(self.says(id).into_iter().filter(|(left, _)| reactions.contains(left)));
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
        cuts.map(|cut| (cut.of_branch(), FormulaTree::sum(cut.others().collect()))).collect()
    }

    /// Step 2: circuits of chords, projected on their reaction spaces; and the displacements of slides.
    pub fn circuit_equations(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("7. Step 2. Which closures are needed? Circuits on reaction spaces (15)")];
        let loops: Vec<usize> = self.equations.loops().map(|(index, _)| index).collect();
        if loops.is_empty() {
            blocks.push(words(
                "No chord holds anything: there are no loops, no loop equations and no multipliers (m = 0).",
            ));
        } else {
            let switch = loops
                .iter()
                .filter(|&&row| matches!(self.equations.constraints[row].kind, RowKind::Contact(_)))
                .count();
            let switch = match switch {
                0 => String::new(),
                1 => ", of which 1 holds in one mode only".to_owned(),
                _ => format!(", of which {switch} hold in one mode each"),
            };
            blocks.push(words(format!(
                "A chord gives one equation for each direction that it holds, and the reaction in that direction is its multiplier: m = {}{switch}.",
                loops.len()
            )));
            blocks.extend(self.own_circuits());
            blocks.extend(self.couplings());
            blocks.push(words("In the coordinates (19):"));
            let names = (0..loops.len()).map(|row| FormulaTree::Name(Name::entry("Phi", &[row]))).collect();
            let values: Vec<Expr> = loops.iter().map(|&index| self.equations.constraints[index].value).collect();
            blocks.extend(self.equations(names, &values));
            let gaps = self.equations.gaps();
            blocks.push(self.closed(&loops.iter().map(|&index| gaps[index]).collect::<Vec<_>>()));
            blocks.extend(self.modes());
        }
        blocks.extend(self.slide_equations());
        blocks
    }

    /// Which of these hold in which mode.
    fn modes(&mut self) -> Vec<DocumentBlock> {
        let Some(modes) = Modes::new(&mut self.equations) else { return Vec::new() };
        let entries = indicators(&mut self.equations).into_iter().flat_map(|(_, entries)| entries);
        let mut blocks = modes.blocks();
        blocks.push(words("with the gaps, the sliding speeds and the relative speeds of freewheels:"));
        blocks.extend(self.written(entries.collect()));
        blocks
    }

    /// Are the loops closed where the motion starts?
    fn closed(&mut self, values: &[Expr]) -> DocumentBlock {
        let gaps = self.at_start(values);
        let largest = gaps.iter().fold(0.0_f64, |largest, gap| largest.max(gap.abs()));
        check(&format!("the largest of these at the start is {largest:.1e}"), largest < 1e-6)
    }

    fn couplings(&self) -> Vec<DocumentBlock> {
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
    fn slide_equations(&mut self) -> Vec<DocumentBlock> {
        let slides = self.slides();
        if slides.is_empty() {
            return Vec::new();
        }
        let mut blocks = vec![words(
            "Projected on the direction in which it slides, the circuit gives the slide itself, which is not a coordinate (41):",
        )];
        let names: Vec<FormulaTree> = slides.iter().map(|(name, _)| name.clone()).collect();
        blocks.extend(list(slides));
        let entries = crate::motion::slides(&mut self.equations);
        let exprs: Vec<Expr> = entries.into_iter().map(|(_, expr)| expr).collect();
        if exprs.len() == names.len() {
            blocks.extend(self.equations(names, &exprs));
        }
        blocks
    }

    /// The loop equations that are circuits of one chord, then without what is zero.
    fn own_circuits(&mut self) -> Vec<DocumentBlock> {
        let constraints = self.equations.loops().filter(|(_, constraint)| constraint.coupled.is_empty());
        let constraints: Vec<(ElementId, Constrained)> =
            constraints.map(|(_, constraint)| (constraint.element, constraint.constrained)).collect();
        let struck: Vec<Vec<usize>> = constraints.iter().map(|constraint| self.struck(*constraint)).collect();
        let mut blocks = list(constraints.iter().filter_map(|constraint| self.circuit_row(*constraint, &[])).collect());
        let mut zeros = Rows::new();
        for row in constraints.iter().zip(&struck).flat_map(|(constraint, edges)| self.zeros(*constraint, edges)) {
            if !zeros.contains(&row) {
                zeros.push(row);
            }
        }
        if !zeros.is_empty() {
            zeros.truncate(24);
            blocks.extend([
                words("Terms that are zero drop out:"),
                DocumentBlock::Equations(zeros),
                words("and there remains"),
            ]);
            let rest =
                constraints.iter().zip(&struck).filter_map(|(constraint, edges)| self.circuit_row(*constraint, edges));
            blocks.extend(list(rest.collect()));
        }
        blocks
    }

    /// The edges of a circuit whose displacements are zero where it is projected, by their terminal equations: branches, then the chord.
    fn struck(&mut self, (chord, held): (ElementId, Constrained)) -> Vec<usize> {
        let (Constrained::Along(along), Some(circuit)) = (held, self.translation.record.circuit(chord)) else {
            return Vec::new();
        };
        let edges = circuit[1..].iter().chain(&circuit[..1]).map(|(edge, _)| *edge);
        edges.filter(|edge| self.equations.is_zero(self.translation.record.edges[*edge].element, along)).collect()
    }

    /// What is zero in a circuit equation.
    fn zeros(&self, (chord, held): (ElementId, Constrained), edges: &[usize]) -> Rows {
        let Constrained::Along(along) = held else { return Rows::new() };
        let left = |edge: &Edge<Translation>| {
            let vector = self.letters.displacement(&edge.label);
            if self.is_pin(edge) { vector } else { self.held_part(vector, along, chord) }
        };
        edges.iter().map(|edge| (left(&self.translation.record.edges[*edge]), FormulaTree::zero())).collect()
    }

    /// The circuit of a chord, projected on what it holds, without some edges.
    fn circuit_row(
        &self,
        (chord, held): (ElementId, Constrained),
        without: &[usize],
    ) -> Option<(FormulaTree, FormulaTree)> {
        let Constrained::Along(along) = held else {
            let circuit = self.rotation.record.circuit(chord)?;
            let sum = FormulaTree::sum(self.rotation.terms(circuit, |label| self.letters.angle(label)));
            return Some((sum, FormulaTree::zero()));
        };
        let mut circuit = self.translation.record.circuit(chord)?.clone();
        circuit.retain(|(edge, _)| !without.contains(edge));
        let sum = FormulaTree::sum(self.translation.terms(&circuit, |label| self.letters.displacement(label)));
        Some((self.held_part(sum, along, chord), FormulaTree::zero()))
    }

    /// The projection of a vector on the direction that a joint or driver holds.
    pub fn held_part(&self, vector: FormulaTree, along: Direction, id: ElementId) -> FormulaTree {
        let element = self.equations.system.element(id);
        // A driver holds its axis, a joint what is across it.
        self.letters.projected(vector, along, element, matches!(element.origin, Origin::Driver(_)))
    }

    fn is_pin(&self, edge: &Edge<Translation>) -> bool {
        let row = self.equations.system.element(edge.element).translation.as_ref();
        row.is_some_and(|row| matches!(row.known, Known::Zero) && row.motion.is_empty())
    }

    fn slides(&self) -> Rows {
        let view = &self.translation;
        let slides = view.elements(&self.equations.system, |element| matches!(element.origin, Origin::Joint(_)));
        let slides = slides.filter_map(|circuit| {
            let element = self.equations.system.element(view.record.edge_of(circuit).element);
            let (along, _) = element.translation.as_ref()?.motion.first()?;
            let (_, sum) = view.by_others(circuit, |label| self.letters.displacement(label));
            Some((self.letters.slide(&element.label), self.letters.projected(sum, *along, element, true)))
        });
        slides.collect()
    }
}

/// The cutset of each branch of a graph.
fn cuts<'v, D>(
    view: &'v GraphView<D>,
    system: &'v System,
    angular: bool,
    letter: impl Fn(&str) -> FormulaTree + 'v,
) -> impl Iterator<Item = Cut<'v>> {
    let element = |row| system.element(view.record.edge_of(row).element);
    view.record.cutsets.iter().map(move |row| Cut { element: element(row), angular, terms: view.terms(row, &letter) })
}

/// A cutset in letters.
pub struct Cut<'l> {
    pub element: &'l Element,
    pub angular: bool,
    /// The through variable of its branch, and those of chords, true for minus.
    terms: Vec<(bool, FormulaTree)>,
}

impl Cut<'_> {
    pub fn of_branch(&self) -> FormulaTree {
        self.terms[0].1.clone()
    }

    /// The branch's variable is the sum of these.
    pub fn others(&self) -> impl Iterator<Item = (bool, FormulaTree)> {
        self.terms[1..].iter().map(|(minus, tree)| (!minus, tree.clone()))
    }
}

pub fn is_free(element: &Element) -> bool {
    element.rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
}

/// The terms of a sum, so that it needs no parentheses.
fn opened((minus, tree): (bool, FormulaTree)) -> Vec<(bool, FormulaTree)> {
    match tree {
        FormulaTree::Sum(terms) => terms.into_iter().map(|(negative, term)| (negative != minus, term)).collect(),
        tree => vec![(minus, tree)],
    }
}

/// A sum with what is known in its place; what is zero drops out.
pub fn inserted(known: &Rows, terms: impl Iterator<Item = (bool, FormulaTree)>) -> FormulaTree {
    let replaced =
        |tree: FormulaTree| known.iter().find(|(name, _)| *name == tree).map_or(tree, |(_, value)| value.clone());
    let terms = terms.map(|(minus, tree)| (minus, replaced(tree)));
    FormulaTree::sum(terms.filter(|(_, tree)| *tree != FormulaTree::zero()).flat_map(opened).collect())
}
