//! Step 3: secondary variables are eliminated, and one row is worked from its cutset to M and Q.

use cotree::component::Origin;
use cotree::equations::{Dynamics, Share};
use cotree::expr::Expr;
use cotree::graph::ElementId;

use super::graphs::list;
use super::numbers::agree;
use super::projection::{Rows, by_branches, is_free};
use super::view::Edge;
use super::{Lesson, check, heading, with, words};
use crate::document::{Block, Piece};
use crate::name::Name;
use crate::tree::Tree;

/// The worked row has at most so many terms and columns.
const TERMS: usize = 16;
const COLUMNS: usize = 4;

impl Lesson<'_> {
    /// Arm forces by chords; chord accelerations and angles by branches; then the worked row.
    pub fn eliminations(&mut self) -> Vec<Block> {
        let mut sections: Vec<(String, Rows, Vec<Block>)> = Vec::new();
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
        let is_body = |edge: &&Edge<_>| matches!(self.equations.system.element(edge.element).origin, Origin::Body(_));
        let letter = |label: &str| match self.dynamic {
            true => self.letters.acceleration(label),
            false => self.letters.displacement(label),
        };
        let bodies = self.translation.chords.iter().filter(|chord| !chord.is_term).filter(is_body);
        bodies.map(|chord| by_branches(&self.translation, chord, letter)).collect()
    }

    fn angles(&self) -> Rows {
        let free = self
            .rotation
            .chords
            .iter()
            .filter(|chord| !chord.is_term && is_free(self.equations.system.element(chord.element)));
        free.map(|chord| by_branches(&self.rotation, chord, |label| self.letters.angle(label))).collect()
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
    fn worked_row(&mut self) -> Vec<Block> {
        let Some(row) = self.chosen_row() else { return Vec::new() };
        let all = self.equations.dynamics().clone();
        let columns: Vec<usize> = all.mass[row].iter().map(|(column, _)| *column).collect();
        let terms = self.terms_of(row);
        if terms.is_empty() || terms.len() > TERMS || columns.len() > COLUMNS {
            return vec![words(format!(
                "The shortest row has {} terms: it is not written out here. Each element brings its force times what its displacement \
                 changes with the coordinate.",
                terms.len()
            ))];
        }
        let own = self.equations.coordinates[row].name.clone();
        let mut blocks = vec![Block::Text(vec![
            Piece::words("(d) The balance of the coordinate "),
            Piece::Math(Tree::Name(Name::symbol(&own.position))),
            Piece::words(", element by element, with (a) to (c) put in:"),
        ])];
        blocks.extend(self.table_of_terms(&columns, &terms));
        blocks.push(words(
            "The sum is zero. Accelerations and multipliers go to the left with the sign changed, and a row of (22) is there: the columns are \
             minus the entries of M, the rest is Q minus the multipliers' part.",
        ));
        let sums = self.sums(&columns, &terms);
        let entries: Vec<Expr> =
            columns.iter().map(|column| entry(&all, row, *column)).chain([all.load[row]]).collect();
        let values = self.moving();
        let whole = values.of(&self.equations, &entries);
        blocks.push(check("the columns add up to this row of M and Q", agree(&sums, &whole)));
        blocks
    }

    /// The part that each element has in a row, without those that have none.
    fn terms_of(&mut self, row: usize) -> Vec<(String, Dynamics)> {
        let count = self.equations.system.elements.len();
        let acts = |id: &ElementId| {
            let element = self.equations.system.element(*id);
            matches!(element.origin, Origin::Body(_) | Origin::Load(_) | Origin::Joint(_))
        };
        let ids: Vec<ElementId> = (0..count).map(ElementId).filter(acts).collect();
        if ids.len() > 4 * TERMS {
            return Vec::new();
        }
        let mut terms = Vec::new();
        for id in ids {
            let part = self.equations.share_of(Share::Element(id));
            if !part.mass[row].is_empty() || part.load[row] != Expr::ZERO {
                terms.push((self.equations.system.element(id).label.clone(), part));
            }
        }
        for part in terms.iter_mut().map(|(_, part)| part) {
            *part = part.row(row);
        }
        terms
    }

    fn sums(&self, columns: &[usize], terms: &[(String, Dynamics)]) -> Vec<f64> {
        let values = self.moving();
        let mut sums = vec![0.0; columns.len() + 1];
        for (_, part) in terms {
            let entries: Vec<Expr> =
                columns.iter().map(|column| entry(part, 0, *column)).chain([part.load[0]]).collect();
            sums.iter_mut().zip(values.of(&self.equations, &entries)).for_each(|(sum, value)| *sum += value);
        }
        sums
    }

    fn table_of_terms(&mut self, columns: &[usize], terms: &[(String, Dynamics)]) -> Vec<Block> {
        let mut exprs = Vec::new();
        for (_, part) in terms {
            for column in columns {
                let own = entry(part, 0, *column);
                exprs.push(self.equations.system.arena.negate(own));
            }
            exprs.push(part.load[0]);
        }
        let (formulas, mut new) = self.formulas(&exprs);
        let mut formulas = formulas.into_iter();
        let reactions = self.reactions_of(columns.len(), terms, &mut new);
        let mut rows: Vec<Vec<Piece>> = Vec::new();
        for (label, _) in terms {
            let cells = formulas.by_ref().take(columns.len() + 1).map(cell);
            rows.push(std::iter::once(Piece::words(label)).chain(cells).collect());
        }
        rows.extend(reactions);
        let coordinates = &self.equations.coordinates;
        let head = columns.iter().map(|&column| {
            let name = Tree::Name(Name::symbol(&coordinates[column].name.acceleration));
            Piece::Row(vec![Piece::words("times "), Piece::Math(name)])
        });
        let head = std::iter::once(Piece::words("element")).chain(head).chain([Piece::words("the rest")]);
        rows.insert(0, head.collect());
        let mut blocks = vec![Block::captioned("The terms of this row, element by element", Vec::new(), rows)];
        blocks.extend(with(new));
        blocks
    }

    /// What the multipliers bring to the row, minus Phi_q^T lambda, and abbreviations in it.
    fn reactions_of(
        &mut self,
        columns: usize,
        terms: &[(String, Dynamics)],
        definitions: &mut Vec<(Tree, Tree)>,
    ) -> Vec<Vec<Piece>> {
        let Some((_, first)) = terms.first() else { return Vec::new() };
        let mut rows = Vec::new();
        for (index, coefficient) in first.reactions[0].clone() {
            let arena = &mut self.equations.system.arena;
            let lambda = arena.symbol(cotree::expr::Symbol::Reaction(index));
            let product = arena.multiply(coefficient, lambda);
            let minus = arena.negate(product);
            let label = self.equations.system.element(self.equations.constraints[index].element).label.clone();
            let (mut formulas, new) = self.formulas(&[minus]);
            definitions.extend(new);
            let tree = formulas.pop().unwrap_or_else(Tree::zero);
            let empty = (0..columns).map(|_| Piece::words("."));
            rows.push(std::iter::once(Piece::words(label)).chain(empty).chain([cell(tree)]).collect());
        }
        rows
    }
}

fn entry(dynamics: &Dynamics, row: usize, column: usize) -> Expr {
    dynamics.mass[row].iter().find(|(own, _)| *own == column).map_or(Expr::ZERO, |(_, entry)| *entry)
}

fn cell(tree: Tree) -> Piece {
    if tree == Tree::zero() { Piece::words(".") } else { Piece::Math(tree) }
}
