//! The matrix \[M J^T; J 0\] of a pose: inverted as a whole where it is small or full, factored where it is large and sparse or an open
//! chain's.

use super::factors::{Factors, Pattern};
use super::inverse::Inverse;
use super::lane::{Lane, WIDTH};
use super::tree::Recursion;

/// What a multiplication of four numbers costs, in units of one by itself whose places must be looked up.
pub(crate) const FOUR_AT_ONCE: f64 = 0.35;
/// So often a typical step solves.
const SOLUTIONS: usize = 16;

/// What a solution multiplies for each link of a chain.
const LINK: usize = 16;

/// Where an entry and its mirror image are kept.
pub(crate) type Places = [usize; 2];

/// Either way.
#[derive(Clone, Debug)]
pub(crate) enum Matrix {
    Whole(Box<Inverse>),
    Factored(Box<Factors>),
    /// Of an open chain, or tree, of arms.
    Chained(Recursion),
}

/// Receives the entries of a matrix.
pub(crate) trait Entries<N = f64> {
    /// Adds to an entry and its mirror image.
    fn add(&mut self, places: Places, value: N);
}

/// Receives entries by lanes, too.
pub(crate) trait Lanes<N, const L: usize>: Entries<N> {
    /// The entries of a lane of columns in a row, by places.
    fn put(&mut self, row: usize, lane: usize, entries: Lane<N, L>);
}

impl Matrix {
    /// For equations whose solutions go to `targets`, among so much room; those from `unknowns` on are loop equations. Pivots of `alike` masses
    /// need not be searched for.
    pub fn new(
        targets: &[usize],
        room: usize,
        unknowns: usize,
        entries: impl Iterator<Item = (usize, usize)>,
        alike: bool,
    ) -> Self {
        if alike && targets.len() > WIDTH * WIDTH {
            let pattern = Pattern::new(targets.len(), unknowns, entries);
            if cost_of_factors(&pattern) < cost_of_inverse(targets.len()) {
                return Self::Factored(Box::new(Factors::new(pattern, targets.to_vec())));
            }
        }
        Self::Whole(Box::new(Inverse::new(targets.to_vec(), room, unknowns == targets.len())))
    }

    /// The same where so many of the loop equations, which have these scales, repeat others.
    pub fn with_repeating(targets: Vec<usize>, room: usize, unknowns: usize, repeating: usize, scales: &[f64]) -> Self {
        Self::Whole(Box::new(Inverse::new(targets, room, false).with_repeating(repeating, unknowns, scales)))
    }

    /// Where an entry is kept.
    pub fn places(&self, row: usize, column: usize) -> Places {
        match self {
            Self::Whole(inverse) => inverse.places(row, column),
            Self::Factored(factors) => factors.places(row, column),
            // It takes no entries: it knows its links.
            Self::Chained(_) => [0; 2],
        }
    }

    /// What the matrix costs in a step, in multiplications whose places must be looked up.
    pub fn cost(&self) -> f64 {
        match self {
            Self::Whole(inverse) => cost_of_inverse(inverse.size()),
            Self::Factored(factors) => cost_of_factors(factors.pattern()),
            Self::Chained(recursion) => (LINK * SOLUTIONS * recursion.size()) as f64,
        }
    }

    /// An entry of the diagonal of the inverse, for a loop equation.
    pub fn inverse_diagonal(&self, equation: usize) -> f64 {
        match self {
            Self::Whole(inverse) => inverse.diagonal(equation),
            Self::Factored(factors) => factors.diagonal(equation),
            // It has no loop equations.
            Self::Chained(_) => 0.0,
        }
    }

    /// How many times the solution for the `unknowns` first equations multiplies rounding errors, and for which of them most; `masses` is the diagonal
    /// of the matrix there.
    pub fn cancellation(&self, masses: &[f64]) -> (f64, usize) {
        match self {
            // Multiplying by an inverse adds as many errors up as it has columns (Higham 2002, 14.1).
            Self::Whole(inverse) => {
                let size = inverse.size() as f64;
                most(masses.iter().enumerate().map(|(row, mass)| size * mass * inverse.diagonal(row).abs()))
            }
            Self::Factored(factors) => factors.cancellation(masses.len()),
            Self::Chained(recursion) => recursion.cancellation(),
        }
    }

    /// Solutions for several right-hand sides, by equations.
    #[inline(always)]
    pub fn solve_all<const D: usize>(&mut self, vectors: &[[f64; D]], solutions: &mut [[f64; D]]) {
        match self {
            Self::Whole(inverse) => inverse.times_all(vectors, solutions),
            Self::Factored(factors) => factors.solve_all(vectors, solutions),
            // It has no entries.
            Self::Chained(_) => {}
        }
    }

    /// Builds the matrix of a pose and makes it ready for solutions. Pivots of `alike` masses need not be searched for where that works. False if it is singular.
    #[inline(always)]
    pub fn factor(&mut self, alike: bool, pose: &mut impl Assemble) -> bool {
        match self {
            Self::Whole(inverse) => {
                let inverse = &mut **inverse;
                inverse.clear();
                pose.assemble_whole(inverse);
                if inverse.repeats() {
                    return inverse.invert_independent();
                }
                let in_order = alike && inverse.size() > WIDTH;
                if in_order && inverse.invert_in_order() {
                    return true;
                }
                if in_order {
                    inverse.clear();
                    pose.assemble(inverse);
                }
                inverse.invert()
            }
            Self::Factored(factors) => {
                factors.clear();
                pose.assemble(&mut **factors);
                factors.factor()
            }
            Self::Chained(recursion) => recursion.factor(pose.derivatives()),
        }
    }
}

/// Adds up the entries of the matrix of a pose.
pub(crate) trait Assemble {
    fn assemble(&mut self, matrix: &mut impl Entries);

    /// The same where the matrix is inverted as a whole.
    #[inline(always)]
    fn assemble_whole(&mut self, matrix: &mut Inverse) {
        self.assemble(matrix);
    }

    /// Derivatives of arms, of which that of a chain is made.
    fn derivatives(&self) -> [&[f64]; 2];
}

/// Solves the equations of a pose in some kind of number.
pub(crate) trait Solve<N>: Clone + std::fmt::Debug {
    /// No equations.
    fn none() -> Self;

    /// The solution for right-hand sides by equations, at its places.
    fn solve(&mut self, vector: &[N], solution: &mut [N]);

    /// Minus the solution for a vector that is zero before the equation `first`, if the inverse is at hand.
    fn solve_rest(&self, first: usize, vector: &[N], solution: &mut [N]) -> bool;

    /// The rows of the inverse by places, E lanes each, if it is at hand.
    #[inline(always)]
    fn rows<const L: usize, const E: usize>(&self) -> Option<&[[Lane<N, L>; E]]> {
        None
    }
}

impl Solve<f64> for Matrix {
    fn none() -> Self {
        Self::Whole(Box::new(Inverse::new(Vec::new(), 0, true)))
    }

    #[inline(always)]
    fn solve(&mut self, vector: &[f64], solution: &mut [f64]) {
        match self {
            Self::Whole(inverse) => inverse.times(vector, solution.as_chunks_mut().0),
            Self::Factored(factors) => factors.solve(vector, solution),
            Self::Chained(recursion) => recursion.solve(vector, solution),
        }
    }

    #[inline(always)]
    fn solve_rest(&self, first: usize, vector: &[f64], solution: &mut [f64]) -> bool {
        let Self::Whole(inverse) = self else { return false };
        inverse.minus_times_from(first, vector, solution.as_chunks_mut().0);
        true
    }

    #[inline(always)]
    fn rows<const L: usize, const E: usize>(&self) -> Option<&[[Lane<f64, L>; E]]> {
        if let Self::Whole(inverse) = self { Some(inverse.rows()) } else { None }
    }
}

/// The largest value, and its place.
pub(super) fn most(values: impl Iterator<Item = f64>) -> (f64, usize) {
    values.zip(0..).fold((0.0, 0), |most, found| if found.0 > most.0 { found } else { most })
}

/// What a step costs with factors, in multiplications whose places must be looked up.
fn cost_of_factors(pattern: &Pattern) -> f64 {
    let [factor, solve] = pattern.work();
    // The inverse where it is needed costs twice as much as the factors.
    (3 * factor + SOLUTIONS * solve) as f64
}

/// What it costs with the whole inverse.
fn cost_of_inverse(size: usize) -> f64 {
    FOUR_AT_ONCE * (size + SOLUTIONS) as f64 * (size * size.div_ceil(WIDTH)) as f64
}
