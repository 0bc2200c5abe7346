//! The motion of a scene with other values: its measures over time, and its distance from the curve to match.

use cotree::model::Experiment;
use cotree::report::csv::CsvTable;
use cotree::run::points;
use cotree_fmu::model::State;
use nalgebra::{DMatrix, DVector};

use super::course::SampledValues;
use super::search::SeenCourses;
use crate::analysis::{Along, AnalysisFailure, Varying};
use crate::fit::{DEAREST, Residuals};

/// The motions of a scene.
pub struct Motions<'a, 'f> {
    varying: &'a Varying<'f>,
    /// The outputs that are measured.
    outputs: Vec<usize>,
    matched: Option<Matched<'a>>,
    /// Communication points and the times of the table, ascending.
    times: Vec<f64>,
    /// Which of them are communication points.
    grid: Vec<usize>,
    /// The start of the scene's own motion, and what one motion may cost.
    home: Option<State>,
    most: u64,
}

/// What is to be matched.
struct Matched<'a> {
    table: &'a CsvTable,
    /// The output of each column.
    outputs: Vec<usize>,
    /// Where the times of the table are among all.
    rows: Vec<usize>,
}

impl<'a, 'f> Motions<'a, 'f> {
    /// Of these outputs, and of those of the columns of a table.
    pub fn new(
        varying: &'a Varying<'f>,
        experiment: Experiment,
        outputs: Vec<usize>,
        table: Option<(&'a CsvTable, Vec<usize>)>,
    ) -> Self {
        let grid: Vec<f64> = if outputs.is_empty() { Vec::new() } else { points(experiment).collect() };
        let measured = table.as_ref().map_or(&[][..], |(table, _)| table.times());
        let mut times: Vec<f64> = grid.iter().chain(measured).copied().collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let place = |time: &f64| times.partition_point(|earlier| earlier < time);
        let (grid, rows) = (grid.iter().map(place).collect(), measured.iter().map(place).collect());
        let matched = table.map(|(table, outputs)| Matched { table, outputs, rows });
        let mut motions = Motions { varying, outputs, matched, times, grid, home: None, most: u64::MAX };
        let start: Vec<f64> = varying.parameters().iter().map(|parameter| parameter.start).collect();
        if let Ok(Along { start, work, .. }) = motions.along(&start, None) {
            (motions.home, motions.most) = (Some(start), DEAREST.saturating_mul(work));
        }
        motions
    }

    fn along(&self, values: &[f64], from: Option<&State>) -> Result<Along, AnalysisFailure> {
        self.varying.along(values, &self.times, from, self.most)
    }

    /// What is seen with these values, and how the motion starts: on the branch on which another one does. The first one of a search is on that of the scene, or where its guesses lead.
    ///
    /// # Errors
    /// There is no motion, it has no derivatives, or something has no value.
    pub fn seen(&self, values: &[f64], from: Option<&State>) -> Result<(SeenCourses, State), AnalysisFailure> {
        let along = match (from, &self.home) {
            (Some(from), _) => self.along(values, Some(from))?,
            (None, Some(home)) => self.along(values, Some(home)).or_else(|_| self.along(values, None))?,
            (None, None) => self.along(values, None)?,
        };
        let courses = self.outputs.iter().map(|&output| self.course(&along, output)).collect::<Result<_, _>>()?;
        let residuals = self.matched.as_ref().map(|matched| matched.residuals(&along, values.len()));
        Ok((SeenCourses { courses, residuals }, along.start))
    }

    fn course(&self, along: &Along, output: usize) -> Result<SampledValues, AnalysisFailure> {
        let times: Vec<f64> = self.grid.iter().map(|&row| self.times[row]).collect();
        let rows = || self.grid.iter().map(|&row| &along.rows[row]);
        let values = DVector::from_iterator(times.len(), rows().map(|(values, _)| values[output]));
        let count = self.varying.parameters().len();
        let slopes = DMatrix::from_fn(times.len(), count, |row, column| along.rows[self.grid[row]].1[(output, column)]);
        let is_there = |row: &usize| values[*row].is_finite() && slopes.row(*row).iter().all(|slope| slope.is_finite());
        match (0..times.len()).find(|row| !is_there(row)) {
            None => Ok(SampledValues { times, values, slopes }),
            Some(row) => {
                let name = self.varying.outputs().nth(output).map_or("", |(name, _)| name);
                Err(AnalysisFailure::NotFinite { time: times[row], what: name.to_owned() })
            }
        }
    }
}

impl Matched<'_> {
    fn residuals(&self, along: &Along, quantities: usize) -> Residuals {
        let columns = self.outputs.len();
        let count = columns * self.rows.len();
        let mut residuals = Residuals { values: DVector::zeros(count), derivatives: DMatrix::zeros(count, quantities) };
        for (row, &time) in self.rows.iter().enumerate() {
            let (values, derivatives) = &along.rows[time];
            for (column, &output) in self.outputs.iter().enumerate() {
                let index = row * columns + column;
                residuals.values[index] = values[output] - self.table.column(column)[row];
                residuals.derivatives.row_mut(index).copy_from(&derivatives.row(output));
            }
        }
        residuals
    }
}
