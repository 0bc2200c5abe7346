//! The picture of a sweep: curves over one quantity, a map over two, histograms of random runs.

use cotree::model::DisplayUnit;
use cotree::typeset::rounded;
use cotree_study::sweep::{Outcome, Sweep};

use crate::plot::{Field, Histogram, HistogramSample, Map, Plot, PlotSeries};

/// A second quantity with at most so many values gives a curve for each of them instead of a map.
const MOST_CURVES: usize = 4;

/// The measures of all runs, and how they are drawn.
#[derive(Clone, Debug)]
pub struct SweepPicture {
    kind: Axes,
    /// A column for each measure, as it is shown; not a number where a run failed.
    values: Vec<Vec<f64>>,
    /// How each column is shown: what is set, then what is measured.
    units: Vec<DisplayUnit>,
    failed: usize,
}

#[derive(Clone, Copy, Debug)]
enum Axes {
    /// Over one factor, a curve for each value of the other if there is one.
    Curves(usize, Option<usize>),
    /// Over two factors.
    Map([usize; 2]),
    Histograms,
}

/// Why there is no picture of a sweep.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PictureRefused(pub String);

impl SweepPicture {
    /// Chooses by what is varied.
    ///
    /// # Errors
    /// Nothing is varied, or more than two quantities on a grid.
    pub fn new(sweep: &Sweep) -> Result<Self, PictureRefused> {
        let design = &sweep.design;
        let kind = match (design.is_grid(), &design.varied()[..]) {
            _ if design.is_drawn() => Axes::Histograms,
            (_, []) => return Err(PictureRefused("nothing is varied: there is one run to draw".to_owned())),
            (_, &[one]) => Axes::Curves(one, None),
            (true, &[one, other]) => {
                let [count, others] = [one, other].map(|factor| levels(sweep, factor).len());
                match (count <= MOST_CURVES, others <= MOST_CURVES) {
                    (_, true) if others <= count => Axes::Curves(one, Some(other)),
                    (true, _) => Axes::Curves(other, Some(one)),
                    _ => Axes::Map([one, other]),
                }
            }
            (true, varied) => {
                return Err(PictureRefused(format!(
                    "{count} quantities are varied, but a picture shows one or two of them; give the others one value, or draw runs at random",
                    count = varied.len()
                )));
            }
            (false, _) => Axes::Histograms,
        };
        Ok(SweepPicture { kind, values: vec![Vec::new(); sweep.measures.len()], units: sweep.shown(), failed: 0 })
    }

    /// Adds the next runs, in their order.
    pub fn add(&mut self, outcomes: &[Outcome]) {
        for outcome in outcomes {
            self.failed += usize::from(outcome.is_err());
            let measured = &self.units[self.units.len() - self.values.len()..];
            for (index, (column, unit)) in self.values.iter_mut().zip(measured).enumerate() {
                column.push(outcome.as_ref().map_or(f64::NAN, |values| values[index] / unit.factor));
            }
        }
    }

    /// Draws it, as SVG.
    pub fn svg(&self, sweep: &Sweep) -> String {
        match self.kind {
            Axes::Curves(along, other) => self.curves(sweep, along, other).svg(),
            Axes::Map(axes) => self.map(sweep, axes).svg(),
            Axes::Histograms => self.histogram(sweep).svg(),
        }
    }

    fn title(&self, sweep: &Sweep) -> String {
        let (name, runs) = (&sweep.compiled.description.model_name, sweep.design.len());
        match self.failed {
            0 => format!("{name}: {runs} runs"),
            failed => format!("{name}: {runs} runs, {failed} failed"),
        }
    }

    fn curves(&self, sweep: &Sweep, along: usize, other: Option<usize>) -> Plot {
        let mut runs: Vec<(Vec<f64>, usize)> =
            (0..sweep.design.len()).map(|run| (sweep.design.values(run), run)).collect();
        runs.sort_by(|a, b| a.0[along].total_cmp(&b.0[along]));
        let groups = match other {
            None => vec![(None, runs)],
            Some(other) => {
                let of = |level: f64| runs.iter().filter(|run| run.0[other] == level).cloned().collect();
                levels(sweep, other).into_iter().map(|level| (Some(level), of(level))).collect()
            }
        };
        let factors = sweep.design.factors();
        let mut series = Vec::new();
        for (index, measure) in sweep.measures.iter().enumerate() {
            for (level, runs) in &groups {
                let named = other.zip(*level).map(|(other, level)| {
                    let unit = &self.units[other];
                    let level = rounded(level / unit.factor, 12);
                    format!("{} = {level} {}", factors[other].name, unit.name)
                });
                series.push(PlotSeries {
                    panel: named.is_some().then(|| measure.to_string()),
                    name: named.map_or_else(|| measure.to_string(), |named| named.trim_end().to_owned()),
                    unit: self.units[factors.len() + index].name.clone(),
                    at: Some(runs.iter().map(|run| run.0[along] / self.units[along].factor).collect()),
                    values: runs.iter().map(|run| self.values[index][run.1]).collect(),
                    measured: None,
                });
            }
        }
        Plot { title: self.title(sweep), axis: headed(sweep, along), series, ..Plot::default() }
    }

    fn map(&self, sweep: &Sweep, axes: [usize; 2]) -> Map {
        let names = sweep.columns().into_iter().skip(sweep.design.factors().len());
        let levels = axes.map(|axis| levels(sweep, axis));
        let cell = |run: usize| {
            let values = sweep.design.values(run);
            let [column, row] = [0, 1].map(|axis| levels[axis].partition_point(|level| *level < values[axes[axis]]));
            column * levels[1].len() + row
        };
        let field = |(measured, name): (&Vec<f64>, String)| {
            let mut values = vec![f64::NAN; levels[0].len() * levels[1].len()];
            measured.iter().enumerate().for_each(|(run, &value)| values[cell(run)] = value);
            Field { name, values }
        };
        let fields = self.values.iter().zip(names).map(field).collect();
        let shown = |axis: usize| levels[axis].iter().map(|level| level / self.units[axes[axis]].factor).collect();
        let levels = [0, 1].map(shown);
        let note = if self.failed > 0 { " (grey)" } else { "" };
        Map { title: self.title(sweep) + note, axes: axes.map(|axis| headed(sweep, axis)), levels, fields }
    }

    fn histogram(&self, sweep: &Sweep) -> Histogram {
        let first = sweep.design.factors().len();
        let samples = sweep.columns().into_iter().skip(first).zip(&self.values);
        let samples = samples.map(|(name, values)| HistogramSample { name, values: values.clone() }).collect();
        Histogram { title: self.title(sweep), counted: "runs".to_owned(), samples }
    }
}

/// The name of a factor with its unit.
fn headed(sweep: &Sweep, factor: usize) -> String {
    sweep.columns().swap_remove(factor)
}

/// The different values of a factor of a grid, ascending.
fn levels(sweep: &Sweep, factor: usize) -> Vec<f64> {
    let mut levels = match &sweep.design.factors()[factor].values {
        cotree_study::sweep::FactorValues::Levels(levels) => levels.clone(),
        _ => Vec::new(),
    };
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    levels
}
