//! What is reported of a singular pose that the motion has passed.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::constraints::poses::{active_rows, constraint};
use crate::linalg::sparse::{Factors, Row, columns, independent_rows, product_with_transposed};
use crate::model::{Model, State};
use crate::singular::detect::SHARE;

/// At the pose less than this share of a loop equation is new if it depends on the others.
const NEW: f64 = 0.02;
/// Branches that miss each other by less than this meet.
const MEET: f64 = 1e-10;
/// The time of the pose, and the motion there, are wrong by about the tolerance: together they look like a defect of this many squares of it.
const UNCERTAIN: f64 = 10.0;
/// At most so many Newton steps, with the rows of the pose, close the loop equations that do not depend on others; at places this close to where they
/// are closed, in units of the scales, the others miss by as much.
const CLOSINGS: usize = 4;
const NEAR: f64 = 1e-7;
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
        passage.describe(model, state);
        passage
    }

    /// Do the branches only come close to each other, by more than can be overlooked at a tolerance?
    pub fn is_avoided(&self, tolerance: f64) -> bool {
        self.defect > f64::max(MEET, UNCERTAIN * tolerance * tolerance)
    }

    fn describe(&mut self, model: &Model, state: &State) {
        let program = model.program();
        let rows = active_rows(model, state);
        let Some(found) = Dependences::of(&rows) else { return };
        let combinations = &found.combinations;
        self.freedoms = combinations.len();
        let takes_part = |place: usize| combinations.iter().any(|shares| shares[place].abs() > SHARE);
        let part: Vec<usize> = (0..rows.len()).filter(|&place| takes_part(place)).collect();
        self.joints = part.iter().map(|&place| program.constraints[model.active()[place]].owner.clone()).collect();
        self.joints.dedup();
        let moved: BTreeSet<usize> = part.iter().flat_map(|&place| rows[place].keys().copied()).collect();
        let turning = moved.iter().filter_map(|&index| program.coordinates[index].name.strip_suffix(".angle"));
        self.bodies = turning.map(String::from).collect();
        self.defect = found.defect(model, state, &rows);
    }
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

/// Which rows of a matrix J depend on each other.
#[derive(Debug)]
struct Dependences {
    /// Rows that do not depend on those before them, and the factors of J J^T with them alone.
    independent: Vec<usize>,
    factors: Factors,
    /// For each other row the combination of rows that vanishes; its largest share is 1.
    combinations: Vec<Vec<f64>>,
}

impl Dependences {
    /// None if rounding errors hide it.
    fn of(rows: &[Row]) -> Option<Self> {
        let (_, independent) = independent_rows(rows.to_vec(), NEW, NEW);
        let own: Vec<Row> = independent.iter().map(|&row| rows[row].clone()).collect();
        let factors = Factors::new(product_with_transposed(&own))?;
        let others = (0..rows.len()).filter(|row| independent.binary_search(row).is_err());
        let columns = columns(&own);
        let combination = |other: usize| {
            let mut shares = vec![0.0; own.len()];
            for (column, entry) in &rows[other] {
                columns.get(column).into_iter().flatten().for_each(|&(row, own)| shares[row] += own * entry);
            }
            factors.solve(&mut shares);
            let mut combination = vec![0.0; rows.len()];
            independent.iter().zip(shares).for_each(|(&row, share)| combination[row] = -share);
            combination[other] = 1.0;
            let largest = combination.iter().fold(0.0, |largest: f64, share| largest.max(share.abs()));
            combination.iter().map(|share| share / largest).collect()
        };
        Some(Self { combinations: others.map(combination).collect(), independent, factors })
    }

    /// What is left of the loop equations that depend on the others when those are closed.
    fn defect(&self, model: &Model, state: &State, rows: &[Row]) -> f64 {
        let program = model.program();
        let mut state = state.clone();
        let open = |state: &State| -> Vec<f64> {
            let values = constraint(model, state);
            model.active().iter().map(|&row| values[row] / program.constraints[row].scale).collect()
        };
        for _ in 0..CLOSINGS {
            let change = self.shortest(rows, &open(&state));
            // What depends on the others changes with the square only.
            if change.values().all(|change| change.abs() < NEAR) {
                break;
            }
            for (column, change) in change {
                state.positions_mut()[column] -= change * program.coordinates[column].scale;
            }
        }
        self.misses(&open(&state))
    }

    /// The largest of the combinations of so open loop equations.
    fn misses(&self, open: &[f64]) -> f64 {
        let miss = |shares: &Vec<f64>| shares.iter().zip(open).map(|(share, open)| share * open).sum::<f64>().abs();
        self.combinations.iter().map(miss).fold(0.0, f64::max)
    }

    /// The shortest change of the coordinates that the independent rows turn into these values.
    fn shortest(&self, rows: &[Row], values: &[f64]) -> Row {
        let mut weights: Vec<f64> = self.independent.iter().map(|&row| values[row]).collect();
        self.factors.solve(&mut weights);
        let mut change = Row::new();
        for (&row, weight) in self.independent.iter().zip(weights) {
            rows[row].iter().for_each(|(&column, entry)| *change.entry(column).or_default() += weight * entry);
        }
        change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_depend_on_each_other_are_found_with_their_shares() {
        let rows =
            |entries: &[&[(usize, f64)]]| entries.iter().map(|row| Row::from_iter(row.iter().copied())).collect();
        let matrix: Vec<Row> = rows(&[&[(0, 1.0)], &[(1, 2.0)], &[(2, 1.0)], &[(1, 1.0), (2, -1.0)]]);
        let found = Dependences::of(&matrix).unwrap();
        let [shares] = &found.combinations[..] else { panic!("{found:?}") };
        let expected = [0.0, -0.5, 1.0, 1.0];
        assert!(shares.iter().zip(expected).all(|(share, expected)| (share - expected).abs() < 1e-12), "{found:?}");
        let change = found.shortest(&matrix, &[3.0, 4.0, 0.0, 9.0]);
        assert!((change[&0] - 3.0).abs() < 1e-12 && (change[&1] - 2.0).abs() < 1e-12, "{change:?}");
        assert!(Dependences::of(&matrix[..3]).unwrap().combinations.is_empty());
    }

    #[test]
    fn the_message_names_the_bodies_in_line() {
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let mut passage =
            Passage { time: 3.25, joints: names(&["pin"]), bodies: names(&["crank", "rod"]), freedoms: 1, defect: 0.0 };
        assert_eq!(passage.to_string(), "t = 3.250000 s: `crank` and `rod` are in line; passing with 1 freedom gained");
        passage.bodies = names(&["a", "b", "c", "d", "e"]);
        assert!(passage.to_string().contains("`a`, `b`, `c` and 2 others are in line"), "{passage}");
        (passage.joints, passage.freedoms) = (names(&["left", "right"]), 2);
        assert!(
            passage.to_string().ends_with("loops at `left` and `right`; passing with 2 freedoms gained"),
            "{passage}"
        );
    }
}
