//! Step 4: M, Q and their properties.

use cotree::equations::Standing;
use cotree::expr::Expr;
use cotree_study::analysis::dense;

use super::line;
use super::numbers::{agree, short};
use super::{Lesson, check, heading, words};
use crate::document::{DocumentBlock, Piece};
use crate::modes::sliding;
use crate::motion::{called, dynamics, governing};
use crate::tree::FormulaTree;

impl Lesson<'_> {
    pub fn results(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("9. Step 4. What results?")];
        if !self.dynamic {
            blocks.push(words(
                "No masses, no M and no Q: the loop equations alone are the result, and what is not driven stays open.",
            ));
            return blocks;
        }
        if self.equations.coordinates.is_empty() {
            blocks.push(words(
                "The drivers and joints determine every motion: there are no coordinates, so M and Q have no entries.",
            ));
            return blocks;
        }
        blocks.push(DocumentBlock::Equations(governing(&self.equations, true)));
        blocks.extend(self.mass_matrix());
        blocks.extend(self.reading());
        blocks.extend(self.loads());
        let (_, friction) = sliding(&mut self.equations);
        if !friction.is_empty() {
            blocks.push(words("Friction while it slides, with the levels of section 7:"));
            blocks.extend(self.written(friction));
        }
        blocks.extend(line::matrices(self));
        blocks.extend(self.checked());
        blocks
    }

    fn mass_matrix(&mut self) -> Vec<DocumentBlock> {
        let [(_, mass), _] = dynamics(&mut self.equations);
        self.written(mass)
    }

    /// {Q}, with what each part of it comes from.
    fn loads(&mut self) -> Vec<DocumentBlock> {
        let [_, (_, entries)] = dynamics(&mut self.equations);
        let load: Vec<Expr> = entries.iter().map(|(_, expr)| *expr).collect();
        let mut blocks = self.written(entries);
        let shares = self.equations.load_shares();
        let parts: Vec<&str> = shares.iter().map(|(share, _)| called(*share)[2]).collect();
        if !parts.is_empty() {
            blocks.push(words(format!("Q has parts from {}.", parts.join(", "))));
        }
        let mut sum = vec![0.0; load.len()];
        let values = self.moving();
        for (_, part) in &shares {
            sum.iter_mut().zip(values.of(&self.equations, part)).for_each(|(sum, term)| *sum += term);
        }
        blocks.push(check("the parts, each found alone, add up to Q", agree(&sum, &values.of(&self.equations, &load))));
        blocks
    }

    fn checked(&mut self) -> Vec<DocumentBlock> {
        let n = self.equations.coordinates.len();
        let dynamics = self.equations.dynamics().clone();
        let values = self.moving();
        let matrix = dense(&dynamics.mass, n, |exprs| values.of(&self.equations, exprs));
        let symmetric = agree(matrix.as_slice(), matrix.transpose().as_slice());
        let mut blocks = vec![check("M is symmetric, each pair of entries found from two different rows", symmetric)];
        if n <= 60 {
            let least = matrix.clone().symmetric_eigenvalues().min();
            let pieces = vec![
                Piece::words("The smallest eigenvalue of M at the start is "),
                Piece::Math(FormulaTree::number(short(least))),
                Piece::words(if least > 0.0 { ": M is positive definite." } else { ": M is singular there." }),
            ];
            blocks.push(DocumentBlock::Text(pieces));
        }
        let loops: Vec<usize> = self.equations.loops().map(|(index, _)| index).collect();
        if !loops.is_empty() {
            blocks.push(check(
                "the multipliers stand in the rows of Step 1 with the entries of the transposed Jacobian",
                self.transposed(&loops),
            ));
        }
        let (m, mobility) = (
            // What holds on one side only takes no freedom while it is open.
            loops.iter().filter(|&&row| self.equations.constraints[row].standing() == Some(Standing::Imposed)).count(),
            self.source.mobility(),
        );
        blocks.push(check(&format!("n - m = {n} - {m} = {mobility}, the mobility of section 1"), n == m + mobility));
        blocks
    }

    /// Are the coefficients of the multipliers in the cutset equations those of the loop equations?
    fn transposed(&mut self, loops: &[usize]) -> bool {
        let (n, values) = (self.equations.constraints.len(), self.moving());
        let reactions = self.equations.dynamics().reactions.clone();
        let cutsets = dense(&reactions, n, |exprs| values.of(&self.equations, exprs)).select_columns(loops);
        let circuits = values.jacobian(&self.equations, loops).transpose();
        agree(cutsets.as_slice(), circuits.as_slice())
    }
}
