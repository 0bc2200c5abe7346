//! Loop equations whose direction turns: n(theta) . r = 0.
//!
//! The arm form states that both components of r - s d vanish, where the displacement s along d(theta) (or the angle of a massless rod, whose arm turns along d) is an unknown without
//! mass that no other equation contains: two equations and an unknown, all of them linear in arms, so that series need no product of the direction and
//! the gap. Neither is part of the matrix, though. With lambda = l d / |d| + m n the equation of s says what l is, the component of the gap along d says what s is,
//! and what is left is the component across d, with its reaction m: one equation.

use super::terms::{Plan, Slope};
use crate::linalg::matrix::{Entries, Places};
use crate::linalg::number::Elementary;
use crate::linalg::quad::Quad;
use crate::program::arm_form::ArmForm;

/// All of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs<N = f64> {
    pairs: Vec<Pair<N>>,
}

/// One of them.
#[derive(Clone, Debug, Default)]
struct Pair<N> {
    /// The first of the two rows, and the equation that is left of them.
    row: usize,
    equation: usize,
    /// Place of the unknown s.
    place: usize,
    /// How the components of the gap change with it.
    gap_slopes: [Vec<Slope>; 2],
    /// Equations of the unknowns that move the gap besides, where their entries are, and how they do: the column, then the slope or the constant.
    columns: Vec<usize>,
    places: Vec<Places>,
    slopes: [Vec<(usize, Slope)>; 2],
    linear: [Vec<(usize, u32)>; 2],
    /// d / |d| and |d| of the pose.
    direction: [N; 2],
    size: N,
    /// The component along d of each column.
    along: Vec<N>,
    /// The component of the reaction, and of the gap, along d.
    reaction: N,
    gap: N,
}

/// First rows and places of unknowns that may be left out. Mechanisms of frames only have kernels of their own, which know rods as frames.
pub(super) fn candidates(form: &ArmForm, place: impl Fn(u32) -> usize) -> Vec<(usize, usize)> {
    let auxiliary = form.auxiliary.iter().map(|auxiliary| (auxiliary.row as usize, place(auxiliary.arm)));
    let only_frames = form.products.is_empty() && form.world.is_empty();
    let rods = form.rods.iter().filter(|_| !only_frames).map(|rod| (rod.row as usize, place(rod.frame)));
    auxiliary.chain(rods).collect()
}

impl<N: Elementary> Pairs<N> {
    /// For rows and unknowns that may be left out, by their equations in the plan.
    pub(super) fn add(&mut self, plan: &Plan, row: usize, equation: usize, place: usize) {
        let mut columns = Vec::new();
        let mut pair =
            Pair { row, equation, place, direction: [N::all(1.0), N::ZERO], size: N::all(1.0), ..Pair::default() };
        let mut column = |equation: usize| {
            columns.iter().position(|known| *known == equation).unwrap_or_else(|| {
                columns.push(equation);
                columns.len() - 1
            })
        };
        for axis in 0..2 {
            for (unknown, slope) in plan.slopes(row + axis) {
                match plan.equation(unknown) {
                    None => pair.gap_slopes[axis].push(slope),
                    Some(equation) => pair.slopes[axis].push((column(equation), slope)),
                }
            }
            for (unknown, factor) in plan.linear(row + axis) {
                pair.linear[axis].extend(plan.equation(unknown).map(|equation| (column(equation), factor)));
            }
        }
        pair.along = vec![N::ZERO; columns.len()];
        pair.places = vec![[0; 2]; columns.len()];
        pair.columns = columns;
        self.pairs.push(pair);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Rows and columns of the entries.
    pub(super) fn entries(&self) -> impl Iterator<Item = (usize, usize)> {
        self.pairs.iter().flat_map(|pair| pair.columns.iter().map(|column| (pair.equation, *column)))
    }

    /// Entries go to their places in this matrix from now on.
    pub(super) fn aim(&mut self, at: impl Fn(usize, usize) -> Places) {
        for Pair { equation, columns, places, .. } in &mut self.pairs {
            for (place, column) in places.iter_mut().zip(columns) {
                *place = at(*equation, *column);
            }
        }
    }

    /// Directions of the pose.
    pub(super) fn turn(&mut self, c: &[N], derivatives: [&[N]; 2]) {
        for pair in &mut self.pairs {
            let [x, y] = [0, 1].map(|axis| {
                pair.gap_slopes[axis]
                    .iter()
                    .map(|slope| slope.value(c, derivatives))
                    .fold(N::ZERO, |sum, slope| sum + slope)
            });
            pair.size = (x * x + y * y).root();
            pair.direction = [x, y].map(|part| part.over(pair.size));
        }
    }

    /// Adds the components across to the matrix, and keeps those along.
    pub(super) fn assemble(&mut self, matrix: &mut impl Entries<N>, c: &[N], derivatives: [&[N]; 2]) {
        self.turn(c, derivatives);
        for Pair { slopes, linear, places, along, direction: [dx, dy], .. } in &mut self.pairs {
            along.fill(N::ZERO);
            for (axis, (part, turned)) in [(*dx, -*dy), (*dy, *dx)].into_iter().enumerate() {
                let slopes = slopes[axis].iter().map(|(column, slope)| (*column, slope.value(c, derivatives)));
                let linear = linear[axis].iter().map(|(column, factor)| (*column, c[*factor as usize]));
                for (column, value) in slopes.chain(linear) {
                    along[column] += part * value;
                    matrix.add(places[column], turned * value);
                }
            }
        }
    }

    /// Takes the components along out of the right-hand sides: `rest` by places of unknowns, `gaps` by rows, both with their signs turned.
    pub(super) fn reduce(&mut self, rest: &[N], gaps: &[N], vector: &mut [N]) {
        for Pair { row, equation, place, columns, direction: [dx, dy], size, along, reaction, gap, .. } in
            &mut self.pairs
        {
            let [x, y] = [gaps[*row], gaps[*row + 1]];
            (*reaction, *gap) = ((-rest[*place]).over(*size), -(*dx * x + *dy * y));
            vector[*equation] = *dy * x - *dx * y;
            for (column, along) in columns.iter().zip(along) {
                vector[*column] -= *along * *reaction;
            }
        }
    }

    /// Completes a solution by places, the reactions from `first` on.
    pub(super) fn complete(&self, first: usize, unknowns: &[usize], solution: &mut [N]) {
        for Pair { row, place, columns, direction: [dx, dy], size, along, reaction, gap, .. } in &self.pairs {
            let across = solution[first + row];
            let moved = columns
                .iter()
                .zip(along)
                .fold(N::ZERO, |sum, (column, along)| sum + *along * solution[unknowns[*column]]);
            solution[*place] = (*gap - moved).over(*size);
            solution[first + row] = *dx * *reaction - *dy * across;
            solution[first + row + 1] = *dy * *reaction + *dx * across;
        }
    }
}

impl Pairs<Quad> {
    /// Takes the pose of one motion over.
    pub(super) fn take(&mut self, member: usize, alone: &Pairs) {
        for (all, one) in self.pairs.iter_mut().zip(&alone.pairs) {
            let places = all.direction.iter_mut().chain([&mut all.size]).chain(&mut all.along);
            for (place, value) in places.zip(one.direction.iter().chain([&one.size]).chain(&one.along)) {
                place.set(member, *value);
            }
        }
    }
}
