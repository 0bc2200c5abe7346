//! Step 3: secondary variables are eliminated, and one row is worked from its cutset to M and Q.

use cotree::equations::{Dynamics, Equations, Share};
use cotree::expr::{Expr, Symbol};
use cotree::network::{ElementId, Origin};

use super::graphs::list;
use super::numbers::agree;
use super::projection::{Rows, is_free};
use super::{Lesson, check, heading, with, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::FormulaTree;

/// The worked row has at most so many terms and columns.
const TERMS: usize = 16;
const COLUMNS: usize = 4;

/// What an element brings to the worked row: its label, and a formula for each column.
type Term = (String, Vec<Expr>);

impl Lesson<'_> {
    /// Arm forces by chords; chord accelerations and angles by branches; then the worked row.
    pub fn eliminations(&mut self) -> Vec<DocumentBlock> {
        let mut sections: Vec<(String, Rows, Vec<DocumentBlock>)> = Vec::new();
        if self.dynamic {
            sections.push(("(a) Forces in rigid arms, by their cutsets (16):".to_owned(), self.arms(), Vec::new()));
        }
        let what = if self.dynamic { "Accelerations" } else { "Positions" };
        let arms = match (self.dynamic, self.letters.has_two_components()) {
            (true, true) => "; an arm's is that of section 5, a pin's is zero",
            (true, false) => "; an arm's is zero",
            (false, _) => "",
        };
        let text = format!("(b) {what} of mass centres, by the circuits of the bodies (17){arms}:");
        let components = if self.dynamic { self.components() } else { Vec::new() };
        sections.push((text, self.centres(), components));
        sections.push((
            "(c) Angles of chords, and in the same way their rates, by the circuits of R (18):".to_owned(),
            self.angles(),
            Vec::new(),
        ));
        sections.retain(|(_, rows, _)| !rows.is_empty());
        let mut blocks = vec![heading("8. Step 3. What must go? Secondary variables, and one row worked")];
        if sections.is_empty() {
            blocks.push(words("Nothing: every variable is a coordinate, known, or a reaction."));
        }
        for (text, rows, further) in sections {
            blocks.push(words(text));
            blocks.extend(list(rows));
            blocks.extend(further);
        }
        if self.dynamic {
            blocks.extend(self.worked_row());
        }
        blocks
    }

    fn arms(&self) -> Rows {
        self.by_chords(|cut| !cut.angular && matches!(cut.element.origin, Origin::Arm(..)))
    }

    fn centres(&self) -> Rows {
        let letter = |label: &str| match self.dynamic {
            true => self.letters.acceleration(label),
            false => self.letters.displacement(label),
        };
        self.translation
            .elements(&self.equations.system, |element| matches!(element.origin, Origin::Body(_)))
            .map(|row| self.translation.by_others(row, letter))
            .collect()
    }

    fn angles(&self) -> Rows {
        let free = self.rotation.elements(&self.equations.system, is_free);
        free.map(|row| self.rotation.by_others(row, |label| self.letters.angle(label))).collect()
    }

    /// Which row has most to show: of few columns the one with most elements.
    fn chosen_row(&mut self) -> Option<usize> {
        let dynamics = self.equations.dynamics();
        let columns = |row: &usize| dynamics.mass[*row].len();
        let rows: Vec<usize> = (0..dynamics.mass.len()).collect();
        let few = rows.iter().copied().filter(|row| columns(row) <= COLUMNS);
        few.max_by_key(|row| (columns(row), std::cmp::Reverse(*row)))
            .or_else(|| rows.iter().copied().min_by_key(columns))
    }

    /// What each element brings to one balance: times the accelerations, and the rest.
    fn worked_row(&mut self) -> Vec<DocumentBlock> {
        let Some(row) = self.chosen_row() else { return Vec::new() };
        let all = self.equations.dynamics().clone();
        let columns: Vec<usize> = all.mass[row].iter().map(|(column, _)| *column).collect();
        let terms = self.terms_of(row, &columns);
        if terms.is_empty() || terms.len() > TERMS || columns.len() > COLUMNS {
            return vec![words(format!(
                "The shortest row has {} terms: it is not written out here. Each element brings its force times what its displacement \
                 changes with the coordinate.",
                terms.len()
            ))];
        }
        let coordinate = self.equations.coordinates[row].name.clone();
        let mut blocks = vec![DocumentBlock::Text(vec![
            Piece::words("(d) The balance of the coordinate "),
            Piece::Math(FormulaTree::Name(Name::symbol(&coordinate.position))),
            Piece::words(", element by element, with (a) to (c) put in:"),
        ])];
        let multipliers = self.multipliers_of(&all.reactions[row], columns.len());
        blocks.extend(self.table_of_terms(&columns, [terms.as_slice(), &multipliers].concat()));
        blocks.push(words(
            "The sum is zero. Accelerations and multipliers go to the left with the sign changed, and a row of (22) is there: the columns are \
             minus the entries of M, the rest is Q minus the multipliers' part.",
        ));
        if self.equations.rubs_dry() {
            blocks.push(words("The levels of friction that slides stay on the right, beside Q."));
        }
        let (whole, values) = (self.cells(&all, row, &columns), self.moving());
        let mut sums = vec![0.0; whole.len()];
        for (_, cells) in &terms {
            sums.iter_mut().zip(values.of(&self.equations, cells)).for_each(|(sum, value)| *sum += value);
        }
        let holds = agree(&sums, &values.of(&self.equations, &whole));
        blocks.push(check("the columns add up to this row of M and Q", holds));
        blocks
    }

    /// What each element brings to a row, without those that bring nothing.
    fn terms_of(&mut self, row: usize, columns: &[usize]) -> Vec<Term> {
        let elements = self.equations.system.elements.iter().enumerate();
        let acting = elements
            .filter(|(_, element)| matches!(element.origin, Origin::Body(_) | Origin::Load(_) | Origin::Joint(_)));
        let acting: Vec<_> = acting.map(|(index, element)| (ElementId(index), element.label.clone())).collect();
        if acting.len() > 4 * TERMS {
            return Vec::new();
        }
        let mut terms = Vec::new();
        for (id, label) in acting {
            let part = self.equations.share_of(Share::Element(id));
            if !part.mass[row].is_empty() || part.load[row] != Expr::ZERO {
                terms.push((label, self.cells(&part, row, columns)));
            }
        }
        terms
    }

    /// Minus the entries of some columns of M in a row, then that of Q.
    fn cells(&mut self, dynamics: &Dynamics, row: usize, columns: &[usize]) -> Vec<Expr> {
        let arena = &mut self.equations.system.arena;
        let entry =
            |column| dynamics.mass[row].iter().find(|(other, _)| other == column).map_or(Expr::ZERO, |other| other.1);
        let entries = columns.iter().map(|column| arena.negate(entry(column)));
        entries.chain([dynamics.load[row]]).collect()
    }

    /// What the multipliers bring to a row, minus Phi_q^T lambda.
    fn multipliers_of(&mut self, row: &[(usize, Expr)], columns: usize) -> Vec<Term> {
        let Equations { system, constraints, .. } = &mut self.equations;
        let term = |&(index, coefficient): &(usize, Expr)| {
            let lambda = system.arena.symbol(Symbol::Reaction(index));
            let product = system.arena.multiply(coefficient, lambda);
            let mut cells = vec![Expr::ZERO; columns];
            cells.push(system.arena.negate(product));
            (system.element(constraints[index].element).label.clone(), cells)
        };
        row.iter().map(term).collect()
    }

    fn table_of_terms(&mut self, columns: &[usize], terms: Vec<Term>) -> Vec<DocumentBlock> {
        let exprs: Vec<Expr> = terms.iter().flat_map(|(_, cells)| cells).copied().collect();
        let (formulas, new) = self.formulas(&exprs);
        let mut formulas = formulas.into_iter();
        let coordinates = &self.equations.coordinates;
        let head = columns.iter().map(|&column| {
            let name = FormulaTree::Name(Name::symbol(&coordinates[column].name.acceleration));
            Piece::Row(vec![Piece::words("times "), Piece::Math(name)])
        });
        let mut rows =
            vec![std::iter::once(Piece::words("element")).chain(head).chain([Piece::words("the rest")]).collect()];
        for (label, cells) in terms {
            let cells = formulas.by_ref().take(cells.len()).map(cell);
            rows.push(std::iter::once(Piece::words(label)).chain(cells).collect());
        }
        let mut blocks = vec![DocumentBlock::captioned("The terms of this row, element by element", Vec::new(), rows)];
        blocks.extend(with(new));
        blocks
    }
}

fn cell(tree: FormulaTree) -> Piece {
    if tree == FormulaTree::zero() { Piece::words(".") } else { Piece::Math(tree) }
}
