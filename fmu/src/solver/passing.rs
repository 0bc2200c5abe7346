//! What is told of a singular pose that the motion has passed.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::poses::{constraint, jacobian};
use super::singular::SHARE;
use crate::model::{Model, State};

/// At the pose less than this share of a loop equation is new if it depends on the others.
const NEW: f64 = 0.02;
/// Branches that miss each other by less than this meet.
const MEET: f64 = 1e-10;
/// The time of the pose, and the motion there, are wrong by about the tolerance: together they look like a defect of this many squares of it.
const UNCERTAIN: f64 = 10.0;
/// Newton steps that close the loop equations that do not depend on others.
const CLOSINGS: usize = 4;
/// With more loop equations nobody looks which of them depend on each other.
const MOST: usize = 500;
/// More bodies than this are counted.
const NAMED: usize = 4;

/// A singular pose that the motion has passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passage {
    /// When [s].
    pub time: f64,
    /// Joints and drivers whose loop equations depend on each other there.
    pub joints: Vec<String>,
    /// Bodies that turn in these loops; joints, where their angles are the coordinates.
    pub bodies: Vec<String>,
    /// How many loop equations follow from the others there.
    pub freedoms: usize,
    /// By how much the branches miss each other there, relative to the scales of the loop equations.
    pub defect: f64,
}

impl Passage {
    /// Describes the pose of a state.
    pub fn at(model: &Model, state: &State) -> Self {
        let mut passage = Self { time: state.time(), joints: Vec::new(), bodies: Vec::new(), freedoms: 0, defect: 0.0 };
        if model.active().len() <= MOST {
            passage.describe(model, state);
        }
        passage
    }

    /// Do the branches only come close to each other, by more than can be overlooked at a tolerance?
    pub fn is_avoided(&self, tolerance: f64) -> bool {
        self.defect > f64::max(MEET, UNCERTAIN * tolerance * tolerance)
    }

    fn describe(&mut self, model: &Model, state: &State) {
        let program = model.program();
        let matrix = scaled_jacobian(model, state);
        let Dependences { combinations, .. } = dependences(&matrix);
        self.freedoms = combinations.len();
        let takes_part = |place: usize| combinations.iter().any(|shares| shares[place].abs() > SHARE);
        let rows: Vec<usize> =
            (0..matrix.nrows()).filter(|&place| takes_part(place)).map(|place| model.active()[place]).collect();
        self.joints = rows.iter().map(|&row| program.constraints[row].owner.clone()).collect();
        self.joints.dedup();
        let turns = |(index, coordinate): (usize, &crate::program::Coordinate)| {
            let mut entries = program.tapes.jacobian.entries.iter();
            let moves = entries.any(|&(row, column)| column as usize == index && rows.contains(&(row as usize)));
            coordinate.name.strip_suffix(".angle").filter(|_| moves).map(String::from)
        };
        self.bodies = program.coordinates.iter().enumerate().filter_map(turns).collect();
        self.defect = defect(model, state);
    }
}

/// Phi_q of the active loop equations, in units of the scales.
fn scaled_jacobian(model: &Model, state: &State) -> DMatrix<f64> {
    let program = model.program();
    let mut matrix = jacobian(model, state).select_rows(model.active());
    for (mut row, &index) in matrix.row_iter_mut().zip(model.active()) {
        row /= program.constraints[index].scale;
    }
    for (mut column, coordinate) in matrix.column_iter_mut().zip(&program.coordinates) {
        column *= coordinate.scale;
    }
    matrix
}

/// What is left of the loop equations that depend on the others when those are closed.
fn defect(model: &Model, state: &State) -> f64 {
    let program = model.program();
    let (mut state, mut left) = (state.clone(), 0.0);
    for _ in 0..CLOSINGS {
        let residuals = constraint(model, &state).select_rows(model.active());
        let scales = model.active().iter().map(|&row| program.constraints[row].scale);
        let residuals =
            DVector::from_iterator(residuals.len(), residuals.iter().zip(scales).map(|(r, scale)| r / scale));
        let Dependences { basis, combinations } = dependences(&scaled_jacobian(model, &state));
        left = combinations.iter().fold(0.0, |most: f64, shares| most.max(shares.dot(&residuals).abs()));
        for (direction, parts) in &basis {
            let size = parts.dot(&residuals);
            let changes = direction.iter().zip(&program.coordinates);
            let places = state.positions_mut().iter_mut().zip(changes);
            places.for_each(|(q, (change, coordinate))| *q -= size * change * coordinate.scale);
        }
    }
    left
}

impl fmt::Display for Passage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "t = {:.6} s: ", self.time)?;
        match (self.joints.as_slice(), self.bodies.as_slice()) {
            // One loop, whose joints are then on a line.
            ([_], [_, _, ..]) => write!(formatter, "{} are in line", listed(&self.bodies))?,
            ([], _) => write!(formatter, "singular pose")?,
            _ => write!(formatter, "singular pose of the loops at {}", listed(&self.joints))?,
        }
        let freedoms = if self.freedoms == 1 { "freedom" } else { "freedoms" };
        write!(formatter, "; passing with {} {freedoms} gained", self.freedoms)
    }
}

/// Names in backticks, the last ones counted if there are many.
fn listed(names: &[String]) -> String {
    let shown = if names.len() > NAMED { NAMED - 1 } else { names.len() };
    let mut words: Vec<String> = names[..shown].iter().map(|name| format!("`{name}`")).collect();
    if shown < names.len() {
        words.push(format!("{} others", names.len() - shown));
    }
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// Which rows of a matrix depend on each other.
#[derive(Debug)]
struct Dependences {
    /// Orthonormal rows, and each of them as a combination of the matrix's.
    basis: Vec<(DVector<f64>, DVector<f64>)>,
    /// For each row that depends on the rows before it the combination of rows that vanishes; its largest share is 1.
    combinations: Vec<DVector<f64>>,
}

fn dependences(matrix: &DMatrix<f64>) -> Dependences {
    let rows = matrix.nrows();
    let mut found = Dependences { basis: Vec::new(), combinations: Vec::new() };
    for index in 0..rows {
        let mut rest: DVector<f64> = matrix.row(index).transpose();
        let mut combination = DVector::zeros(rows);
        combination[index] = 1.0;
        for _ in 0..2 {
            for (direction, parts) in &found.basis {
                let share = direction.dot(&rest);
                rest.axpy(-share, direction, 1.0);
                combination.axpy(-share, parts, 1.0);
            }
        }
        let size = rest.norm();
        if size <= NEW * matrix.row(index).norm().max(1.0) {
            let largest = combination.amax();
            found.combinations.push(combination / largest);
        } else {
            found.basis.push((rest / size, combination / size));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_depend_on_each_other_are_found_with_their_shares() {
        let matrix = DMatrix::from_row_slice(4, 3, &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, -1.0]);
        let found = dependences(&matrix).combinations;
        assert_eq!(found.len(), 1);
        assert!((&found[0] - DVector::from_column_slice(&[0.0, -0.5, 1.0, 1.0])).amax() < 1e-12, "{found:?}");
        assert!(dependences(&DMatrix::identity(3, 3)).combinations.is_empty());
    }

    #[test]
    fn the_message_names_the_bodies_in_line() {
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let mut passage = Passage {
            time: 3.14159265,
            joints: names(&["pin"]),
            bodies: names(&["crank", "rod"]),
            freedoms: 1,
            defect: 0.0,
        };
        assert_eq!(passage.to_string(), "t = 3.141593 s: `crank` and `rod` are in line; passing with 1 freedom gained");
        passage.bodies = names(&["a", "b", "c", "d", "e"]);
        assert!(passage.to_string().contains("`a`, `b`, `c` and 2 others are in line"), "{passage}");
        (passage.joints, passage.freedoms) = (names(&["left", "right"]), 2);
        assert!(
            passage.to_string().ends_with("loops at `left` and `right`; passing with 2 freedoms gained"),
            "{passage}"
        );
    }
}
