//! One turn or stroke of an input with other values: the figures of `motion` as courses. Derivatives of full turns are exact; of others they are differences of turns, which are computed to
//! twelve digits.

use cotree::compile;
use cotree::model::Unit;
use cotree::scene::Scene;
use nalgebra::{DMatrix, DVector};

use super::course::SampledValues;
use super::search::SeenCourses;
use crate::analysis::{AnalysisFailure, Study};
use crate::motion::{self, DifferentiatedTurn, Figures};

/// Differences are over this share of the range of a quantity: its square and the errors of the figures over it are both far below what a search needs.
const STEP: f64 = 1e-4;
/// The smallest of the transmission angles at all joints.
const TRANSMISSION: &str = "transmission";

/// The turns of a scene.
pub struct Turns<'a> {
    pub scene: &'a Scene,
    /// What else was set.
    pub study: &'a Study,
    pub request: &'a motion::MotionRequest,
    pub names: Vec<String>,
    pub bounds: Vec<[f64; 2]>,
    pub ranges: Vec<f64>,
    /// The figures that are measured.
    pub measured: Vec<String>,
    /// The derivatives of the turn, if it is a full one that has them.
    pub differentiated: Option<DifferentiatedTurn<'a>>,
}

/// A figure over the input, or a single one.
struct Figure {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// All figures that can be measured, with their units.
///
/// # Errors
/// There is no turn.
pub fn known(
    scene: &Scene,
    study: &Study,
    request: &motion::MotionRequest,
) -> Result<Vec<(String, Unit)>, AnalysisFailure> {
    let figures = figures_of(&turned(scene, study, request)?);
    // A unit such as `1/rad` has no name of its own: numbers in it are bare.
    let unit = |text: String| compile::unit(&text).unwrap_or_else(|_| Unit { si: text, ..Unit::default() });
    Ok(figures.into_iter().map(|figure| (figure.name, unit(figure.unit))).collect())
}

fn turned(scene: &Scene, study: &Study, request: &motion::MotionRequest) -> Result<Figures, AnalysisFailure> {
    motion::table_of(scene, study.mechanism(), request).map_err(|error| AnalysisFailure::Other(error.to_string()))
}

/// The columns of the table, and what is one number for the whole turn.
fn figures_of(figures: &Figures) -> Vec<Figure> {
    let columns = figures.table.iter().skip(1);
    let mut all: Vec<Figure> = columns
        .map(|column| Figure { name: column.name.clone(), unit: column.unit.clone(), values: column.values.clone() })
        .collect();
    let angles = all.iter().filter(|own| own.name.starts_with("transmission at ")).map(|own| own.values.clone());
    let smallest =
        |one: Vec<f64>, other: Vec<f64>| one.iter().zip(&other).map(|(one, other)| one.min(*other)).collect();
    if let Some(values) = angles.reduce(smallest) {
        all.push(Figure { name: TRANSMISSION.to_owned(), unit: "rad".to_owned(), values });
    }
    let stroke = figures.output.as_ref().map_or("", |own| &own.unit);
    let single = [("stroke", stroke, figures.stroke), ("time_ratio", "", figures.time_ratio)];
    let single = single.into_iter().filter_map(|(name, unit, value)| {
        Some(Figure { name: name.to_owned(), unit: unit.to_owned(), values: vec![value?] })
    });
    all.extend(single);
    all
}

impl Turns<'_> {
    /// What is seen with these values.
    ///
    /// # Errors
    /// There is no such turn, or none beside it.
    pub fn seen(&self, values: &[f64]) -> Result<SeenCourses, AnalysisFailure> {
        match self.exactly(values) {
            Some(seen) => Ok(seen),
            None => self.by_differences(values),
        }
    }

    /// None where the turn is not a full one, or a figure has no derivatives there.
    fn exactly(&self, values: &[f64]) -> Option<SeenCourses> {
        let steps: Vec<f64> = self.ranges.iter().map(|range| STEP * range).collect();
        let (here, differences) = self.differentiated.as_ref()?.figures(values, &steps)?;
        let (times, here) = self.of(&here).ok()?;
        let mut slopes: Vec<DMatrix<f64>> = here.iter().map(|here| DMatrix::zeros(here.len(), values.len())).collect();
        for (quantity, [more, less]) in differences.iter().enumerate() {
            let [more, less] = [self.of(more).ok()?.1, self.of(less).ok()?.1];
            for (figure, own) in here.iter().enumerate() {
                if [&more, &less].iter().any(|other| other[figure].len() != own.len()) {
                    return None;
                }
                for row in 0..own.len() {
                    slopes[figure][(row, quantity)] = (more[figure][row] - less[figure][row]) / (2.0 * steps[quantity]);
                }
            }
        }
        self.courses(&times, here, slopes).ok()
    }

    fn by_differences(&self, values: &[f64]) -> Result<SeenCourses, AnalysisFailure> {
        let (times, here) = self.measured(values)?;
        let mut slopes: Vec<DMatrix<f64>> = here.iter().map(|here| DMatrix::zeros(here.len(), values.len())).collect();
        for quantity in 0..values.len() {
            let [p, q] = self.around(quantity, values[quantity]);
            let [at_p, at_q] = [p, q].map(|step| {
                let mut moved = values.to_vec();
                moved[quantity] += step;
                self.measured(&moved).map(|(_, own)| own)
            });
            let (at_p, at_q) = (at_p?, at_q?);
            for (figure, own) in here.iter().enumerate() {
                let alike = [&at_p, &at_q].iter().all(|other| other[figure].len() == own.len());
                if !alike {
                    return Err(AnalysisFailure::Other(format!(
                        "`{}` exists for other configurations near these values only",
                        self.measured[figure]
                    )));
                }
                for (row, value) in own.iter().enumerate() {
                    let [up, down] = [at_p[figure][row] - value, at_q[figure][row] - value];
                    // The slope of the parabola through three values.
                    slopes[figure][(row, quantity)] = (q * q * up - p * p * down) / (p * q * (q - p));
                }
            }
        }
        self.courses(&times, here, slopes)
    }

    fn courses(
        &self,
        times: &[f64],
        here: Vec<Vec<f64>>,
        slopes: Vec<DMatrix<f64>>,
    ) -> Result<SeenCourses, AnalysisFailure> {
        let courses = here.into_iter().zip(slopes).map(|(own, slopes)| {
            let times = if own.len() == times.len() { times.to_vec() } else { vec![0.0; own.len()] };
            SampledValues { times, values: DVector::from_vec(own), slopes }
        });
        let courses: Vec<SampledValues> = courses.collect();
        let infinite =
            |course: &SampledValues| course.values.iter().chain(course.slopes.iter()).any(|value| !value.is_finite());
        match courses.iter().position(infinite) {
            None => Ok(SeenCourses { courses, residuals: None }),
            Some(figure) => {
                Err(AnalysisFailure::Other(format!("`{}` has no finite value somewhere", self.measured[figure])))
            }
        }
    }

    /// Two steps of a quantity within its bounds.
    fn around(&self, quantity: usize, value: f64) -> [f64; 2] {
        let step = STEP * self.ranges[quantity];
        let [low, high] = self.bounds[quantity];
        match (value - step < low, value + step > high) {
            (true, _) => [step, 2.0 * step],
            (_, true) => [-step, -2.0 * step],
            _ => [step, -step],
        }
    }

    /// The input at each sample, and the values of each figure.
    fn measured(&self, values: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>), AnalysisFailure> {
        let mut study = self.study.clone();
        for (name, value) in self.names.iter().zip(values) {
            study.set(name, |_| Ok(*value)).map_err(|error| AnalysisFailure::Unknown(vec![error]))?;
        }
        self.of(&turned(self.scene, &study, self.request)?)
    }

    fn of(&self, figures: &Figures) -> Result<(Vec<f64>, Vec<Vec<f64>>), AnalysisFailure> {
        let inputs = figures.table.first().map_or(Vec::new(), |own| own.values.clone());
        let all = figures_of(figures);
        let of = |name: &String| {
            let found = all.iter().find(|own| own.name == *name).map(|own| own.values.clone());
            found
                .filter(|own| !own.is_empty())
                .ok_or_else(|| AnalysisFailure::Other(format!("there is no `{name}` with these values")))
        };
        Ok((inputs, self.measured.iter().map(of).collect::<Result<_, _>>()?))
    }
}
