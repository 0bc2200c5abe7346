//! A branch of a closed linkage of one degree of freedom, past a pose where its branches cross: all its coordinates as functions of one of them.
//!
//! In such a pose the loop equations leave one direction free, and what they say next to it is wrong by rounding errors divided by the distance. But each branch by
//! itself is as smooth there as elsewhere: the interpolant through Chebyshev's points (Trefethen, *Approximation Theory and Approximation Practice*, 2013,
//! chapters 2 to 8), none of which is the pose, is exact to rounding errors, derivatives included. It replaces the loop equations of the linkage (coordinate
//! partitioning: Wehage, Haug, *J. Mech. Design* 104, 1982).

use serde::{Deserialize, Serialize};

use crate::constraints::poses::active_rows;
use crate::linalg::dense::Lu;
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};
use crate::program::Block;
use crate::singular::closeness::is_watched;
use crate::singular::detect::weakest_combination;

/// Numbers of points that are tried.
const POINTS: [usize; 4] = [24, 36, 54, 80];
/// How far the branch is known beyond the way of the motion, in shares of it.
const BEYOND: [f64; 3] = [0.4, 0.2, 0.1];
/// The last coefficients are rounding errors of the first ones if they are below this share of them.
const RESOLVED: f64 = 1e-12;
const LAST: usize = 4;
/// Points that predict the next one.
const NEIGHBOURS: usize = 6;
/// Newton's method stops below the first of these corrections, in units of the scales, or where they no longer shrink below the second.
const CLOSED: f64 = 1e-15;
const CLOSE: f64 = 1e-11;
const CORRECTIONS: usize = 20;
/// Halvings to the pose: down to rounding errors.
const HALVINGS: usize = 60;

/// The coordinates of a linkage along a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Curve {
    /// Which of the linkages of the program.
    linkage: usize,
    /// The coordinate that the others are functions of.
    pub parameter: usize,
    pub others: Vec<usize>,
    /// Where the branch is known.
    range: [f64; 2],
    /// The coordinate where the branches cross.
    pub pose: f64,
    /// Chebyshev coefficients of the other coordinates, one after the other, and those of their first two derivatives.
    coefficients: [Vec<f64>; 3],
}

impl Curve {
    /// The branch of the linkage that comes to a singular pose: from a motion (q, v) some way before it towards one near it, when this share of the way to the pose is
    /// left behind. None if there is no such linkage, or its branch is not resolved.
    pub fn trace(
        model: &Model,
        machine: &mut Machine,
        state: &State,
        [from, near]: [&[f64]; 2],
        share: f64,
    ) -> Option<Self> {
        let linkage = weakest_linkage(model, state)?;
        let block = &model.program().linkages[linkage];
        let parameter = parameter(model, block, [from, near])?;
        let begin = from[parameter];
        let way = (near[parameter] - begin) / share;
        machine.load(model, state);
        let mut tracer = Tracer::new(model, machine, block, parameter, from);
        let ranges = BEYOND.iter().map(|beyond| [begin - beyond * way, begin + (2.0 + beyond) * way]);
        ranges.flat_map(|range| POINTS.map(|count| (range, count))).find_map(|(range, count)| {
            let coefficients = tracer.coefficients(range, count)?;
            let others = tracer.others.clone();
            let mut curve = Self { linkage, parameter, others, range, pose: f64::NAN, coefficients };
            curve.pose = tracer.crossing(&curve, [begin, begin + 2.0 * way])?;
            Some(curve)
        })
    }

    /// The loop equations that it replaces.
    pub fn rows<'m>(&self, model: &'m Model) -> &'m [u32] {
        &model.program().linkages[self.linkage].rows
    }

    /// The other coordinates with their first two derivatives; no numbers out of its range.
    pub fn at(&self, parameter: f64, values: &mut [[f64; 3]]) {
        let [low, high] = self.range;
        let place = (2.0 * parameter - low - high) / (high - low);
        let is_known = place.abs() <= 1.0;
        let count = self.coefficients[0].len() / self.others.len().max(1);
        for (index, value) in values.iter_mut().enumerate() {
            *value = self
                .coefficients
                .each_ref()
                .map(|all| if is_known { clenshaw(&all[index * count..][..count], place) } else { f64::NAN });
        }
    }

    /// Puts a motion (q, v) on it.
    pub fn put(&self, motion: &mut [f64], values: &mut [[f64; 3]]) {
        let n = motion.len() / 2;
        let rate = motion[n + self.parameter];
        self.at(motion[self.parameter], values);
        for (&index, value) in self.others.iter().zip(values) {
            (motion[index], motion[n + index]) = (value[0], value[1] * rate);
        }
    }

    /// Could a run of that model have written it?
    pub fn belongs_to(&self, model: &Model) -> bool {
        let Some(block) = model.program().linkages.get(self.linkage) else { return false };
        let fits = |index: &usize| block.columns.contains(&(*index as u32));
        let size = self.coefficients[0].len();
        fits(&self.parameter)
            && self.others.len() == block.rows.len()
            && self.others.iter().all(|index| fits(index) && *index != self.parameter)
            && size.is_multiple_of(self.others.len())
            && self.coefficients.iter().all(|all| all.len() == size && all.iter().all(|value| value.is_finite()))
            && [self.range[0], self.range[1], self.pose].iter().all(|value| value.is_finite())
    }
}

/// The linkage that the loop equations belong to which hold least.
fn weakest_linkage(model: &Model, state: &State) -> Option<usize> {
    let linkages = &model.program().linkages;
    if linkages.is_empty() || !is_watched(model) {
        return None;
    }
    let (combination, _) = weakest_combination(model, &active_rows(model, state))?;
    let size = |place: &usize| combination[*place].abs();
    let place = (0..combination.len()).max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let row = model.active()[place] as u32;
    linkages.iter().position(|linkage| linkage.rows.contains(&row))
}

/// The coordinate that moves most evenly between two motions, in units of the scales.
fn parameter(model: &Model, block: &Block, [from, near]: [&[f64]; 2]) -> Option<usize> {
    let n = model.coordinates();
    let evenness = |index: usize| {
        let [first, last] = [from, near].map(|motion| motion[n + index] / model.program().coordinates[index].scale);
        if first * last > 0.0 { first.abs().min(last.abs()) } else { 0.0 }
    };
    let best =
        block.columns.iter().map(|&column| column as usize).max_by(|&a, &b| evenness(a).total_cmp(&evenness(b)))?;
    (evenness(best) > 0.0).then_some(best)
}

/// Finds points of a branch.
struct Tracer<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    block: &'a Block,
    parameter: usize,
    others: Vec<usize>,
    /// The motion where it begins.
    from: &'a [f64],
    q: Vec<f64>,
    matrix: Lu,
    step: Vec<f64>,
}

impl<'a> Tracer<'a> {
    fn new(model: &'a Model, machine: &'a mut Machine, block: &'a Block, parameter: usize, from: &'a [f64]) -> Self {
        let columns = block.columns.iter().map(|&column| column as usize);
        let others: Vec<usize> = columns.filter(|&column| column != parameter).collect();
        let (size, q) = (others.len(), from[..model.coordinates()].to_vec());
        Self { model, machine, block, parameter, others, from, q, matrix: Lu::new(size), step: vec![0.0; size] }
    }

    /// The coefficients through so many points, if they resolve the branch.
    fn coefficients(&mut self, range: [f64; 2], count: usize) -> Option<[Vec<f64>; 3]> {
        let points = self.points(range, count)?;
        let size = self.others.len();
        let mut all = [vec![0.0; size * count], vec![0.0; size * count], vec![0.0; size * count]];
        let slope = 2.0 / (range[1] - range[0]);
        for index in 0..size {
            let own = index * count..(index + 1) * count;
            let [values, first, second] = all.each_mut().map(|all| &mut all[own.clone()]);
            interpolate(|point| points[point][index], values);
            let largest = values.iter().fold(0.0, |largest, value: &f64| math::maximum(largest, value.abs()));
            let rest =
                values[count - LAST..].iter().fold(0.0, |largest, value: &f64| math::maximum(largest, value.abs()));
            // Written so that NaN is not resolved.
            let resolved = rest <= RESOLVED * largest.max(1.0);
            if !resolved {
                return None;
            }
            derive(values, slope, first);
            derive(first, slope, second);
        }
        Some(all)
    }

    /// The other coordinates in Chebyshev's points, found one after the other from the beginning of the way.
    fn points(&mut self, range: [f64; 2], count: usize) -> Option<Vec<Vec<f64>>> {
        let places: Vec<f64> = (0..count).map(|index| place(range, node(index, count))).collect();
        let begin = self.from[self.parameter];
        let nearest = |a: &usize, b: &usize| (places[*a] - begin).abs().total_cmp(&(places[*b] - begin).abs());
        let first = (0..count).min_by(nearest)?;
        let mut found: Vec<Vec<f64>> = vec![Vec::new(); count];
        let ways: [Vec<usize>; 2] = [(first..count).collect(), (0..first).rev().collect()];
        for index in ways.into_iter().flatten() {
            let known = |other: &usize| !found[*other].is_empty();
            let mut near: Vec<usize> = (0..count).filter(known).collect();
            near.sort_by_key(|other| other.abs_diff(index));
            near.truncate(NEIGHBOURS);
            let guess = self.predicted(&places, &found, &near, places[index]);
            found[index] = self.closed(places[index], guess)?;
        }
        Some(found)
    }

    /// From points next to a place: the polynomial through them; with less than two the tangent where the way begins.
    fn predicted(&self, places: &[f64], found: &[Vec<f64>], near: &[usize], place: f64) -> Vec<f64> {
        let n = self.model.coordinates();
        let ahead = (place - self.from[self.parameter]) / self.from[n + self.parameter];
        if near.len() < 2 {
            return self.others.iter().map(|&other| self.from[other] + ahead * self.from[n + other]).collect();
        }
        let weight = |&point: &usize| {
            let others = near.iter().filter(|&&other| other != point);
            others.map(|&other| (place - places[other]) / (places[point] - places[other])).product::<f64>()
        };
        let weights: Vec<f64> = near.iter().map(weight).collect();
        let value = |index: usize| near.iter().zip(&weights).map(|(&point, weight)| weight * found[point][index]).sum();
        (0..self.others.len()).map(value).collect()
    }

    /// The other coordinates at a place on the loops, by Newton's method from a guess.
    fn closed(&mut self, place: f64, mut guess: Vec<f64>) -> Option<Vec<f64>> {
        let mut last = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            self.load(place, &guess);
            self.factor()?;
            let mut step = std::mem::take(&mut self.step);
            self.residuals(&mut step);
            self.matrix.solve(&mut step);
            let mut size = 0.0;
            for ((value, step), &other) in guess.iter_mut().zip(&step).zip(&self.others) {
                *value -= step;
                size = math::maximum(size, step.abs() / self.model.program().coordinates[other].scale);
            }
            self.step = step;
            if size <= CLOSED || size <= CLOSE && size >= last {
                return Some(guess);
            }
            last = size;
        }
        None
    }

    fn load(&mut self, place: f64, others: &[f64]) {
        self.q[self.parameter] = place;
        self.others.iter().zip(others).for_each(|(&index, value)| self.q[index] = *value);
        self.machine.load_positions(self.model, &self.q);
    }

    fn residuals(&mut self, residuals: &mut [f64]) {
        let tape = &self.model.program().tapes.constraint;
        self.machine.run(tape);
        let rows = self.block.rows.iter().zip(residuals);
        rows.for_each(|(&row, residual)| *residual = self.machine.result(tape, row as usize));
    }

    /// Factors the derivatives by the other coordinates.
    fn factor(&mut self) -> Option<()> {
        let jacobian = &self.model.program().tapes.jacobian;
        self.machine.run(&jacobian.tape);
        let size = self.others.len();
        let matrix = self.matrix.matrix();
        let mut largest: f64 = 0.0;
        for (entry, &(row, column)) in jacobian.entries.iter().enumerate() {
            let row = self.block.rows.iter().position(|own| *own == row);
            let column = self.others.iter().position(|own| *own == column as usize);
            if let (Some(row), Some(column)) = (row, column) {
                matrix[row * size + column] = self.machine.result(&jacobian.tape, entry);
                largest = math::maximum(largest, matrix[row * size + column].abs());
            }
        }
        self.matrix.factor(largest).ok()
    }

    /// Where the derivatives by the other coordinates are singular, if that is in one place of a range: their determinant changes its sign there.
    fn crossing(&mut self, curve: &Curve, range: [f64; 2]) -> Option<f64> {
        let mut values = vec![[0.0; 3]; self.others.len()];
        let mut is_positive = |place: f64| {
            curve.at(place, &mut values);
            let others: Vec<f64> = values.iter().map(|value| value[0]).collect();
            self.load(place, &others);
            // A pivot of zero is the place itself.
            let regular = self.factor().is_some();
            let negative =
                self.matrix.diagonal().filter(|pivot| *pivot < 0.0).count() + usize::from(self.matrix.is_odd());
            regular.then_some(negative.is_multiple_of(2))
        };
        let count = POINTS[0];
        let places: Vec<f64> = (0..count).map(|index| place(range, node(index, count))).collect();
        let signs: Vec<bool> = places.iter().map(|&place| is_positive(place)).collect::<Option<_>>()?;
        let mut changes = (1..count).filter(|&index| signs[index] != signs[index - 1]);
        let (change, None) = (changes.next()?, changes.next()) else { return None };
        let (mut low, mut high) = (places[change - 1], places[change]);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match is_positive(middle) {
                None => return Some(middle),
                Some(sign) if sign == signs[change - 1] => low = middle,
                Some(_) => high = middle,
            }
        }
        Some(0.5 * (low + high))
    }
}

/// Chebyshev's point of the first kind, in the order of their places.
fn node(index: usize, count: usize) -> f64 {
    -libm::cos((index as f64 + 0.5) * std::f64::consts::PI / count as f64)
}

fn place([low, high]: [f64; 2], node: f64) -> f64 {
    0.5 * (low + high) + 0.5 * (high - low) * node
}

/// The coefficients of the interpolant through values in all points.
fn interpolate(value: impl Fn(usize) -> f64, coefficients: &mut [f64]) {
    let count = coefficients.len();
    for (order, coefficient) in coefficients.iter_mut().enumerate() {
        let turn = |point: usize| {
            libm::cos(
                order as f64 * (count - 1 - point) as f64 * std::f64::consts::PI / count as f64
                    + 0.5 * order as f64 * std::f64::consts::PI / count as f64,
            )
        };
        let sum: f64 = (0..count).map(|point| value(point) * turn(point)).sum();
        *coefficient = sum * if order == 0 { 1.0 } else { 2.0 } / count as f64;
    }
}

/// The coefficients of the derivative, times what a unit of its place is in the variable.
fn derive(coefficients: &[f64], slope: f64, derivative: &mut [f64]) {
    let count = coefficients.len();
    derivative.fill(0.0);
    for order in (1..count).rev() {
        let above = derivative.get(order + 1).copied().unwrap_or(0.0);
        derivative[order - 1] = above + 2.0 * order as f64 * coefficients[order];
    }
    derivative[0] *= 0.5;
    derivative.iter_mut().for_each(|value| *value *= slope);
}

/// The value of a sum of Chebyshev's polynomials (Clenshaw).
fn clenshaw(coefficients: &[f64], place: f64) -> f64 {
    let (mut one, mut two) = (0.0, 0.0);
    for coefficient in coefficients[1..].iter().rev() {
        (one, two) = (2.0 * place * one - two + coefficient, one);
    }
    place * one - two + coefficients[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interpolant_of_a_smooth_function_is_exact_to_rounding_with_its_derivatives() {
        let (range, count) = ([0.3, 1.9], 24);
        let mut all = [vec![0.0; count], vec![0.0; count], vec![0.0; count]];
        let [values, first, second] = &mut all;
        interpolate(|point| place(range, node(point, count)).sin(), values);
        let slope = 2.0 / (range[1] - range[0]);
        derive(values, slope, first);
        derive(first, slope, second);
        for x in [0.31_f64, 0.7, 1.1, 1.89] {
            let place = (2.0 * x - range[0] - range[1]) / (range[1] - range[0]);
            let found = all.each_ref().map(|all| clenshaw(all, place));
            let exact = [x.sin(), x.cos(), -x.sin()];
            let errors: Vec<f64> = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).collect();
            assert!(errors[0] < 1e-14 && errors[1] < 1e-12 && errors[2] < 1e-10, "{x}: {errors:?}");
        }
    }
}
