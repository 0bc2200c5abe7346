//! Effect of deviations of lengths, pivots and parameters on one turn or stroke of an input: to first order by exact derivatives, and by samples.
//!
//! The input is where it is without deviations. Each dimension is a parameter of a copy of the mechanism, 0 in the scene: derivatives and samples are those of every parameter. A
//! body's dimensions are those of its drawing, from the first of its joints on: how far the second one is from it, and along and across that line where others are.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cotree::compile::{QuantityError, quantity};
use cotree::diagnostic::suggest;
use cotree::model::{BodyId, Formula, Mechanism, Output, Owner, Place, Quantity, Unit, Variable};
use cotree::report::data::{Cell, Report, Table, named, number};
use cotree::run::{Ensemble, Run, RunError, Settings};
use cotree::scene::Scene;
use cotree::scene::constant::evaluate;
use cotree::{line, row};
use cotree_fmu::model::Model;
use cotree_synthesis::tolerance::{FirstOrder, Tolerances};
use nalgebra::{DMatrix, DVector};
use serde_json::json;

use super::drive::{self, Way};
use super::{InputRun, MotionError, MotionRequest, SpecialPlaces, unit_of};
use crate::analysis::{Study, StudyError};
use crate::sweep::{Design, DesignFactor, FactorValues, Sampling};

/// Positions of the input at which deviations are looked at.
const POSITIONS: usize = 72;
/// Samples, and the seed that they are drawn with.
const SAMPLES: usize = 2000;
const SEED: u64 = 0;
/// A tolerance is so many standard deviations.
const SIGMAS: f64 = 3.0;
/// All distances between joints of a body, and all pivots in the ground.
const LENGTH: &str = "length";
const PIVOT: &str = "pivot";

/// By how much something deviates, as it is written: `length=0.1mm`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deviation {
    /// `length`, `pivot`, or a parameter of the scene.
    pub what: String,
    /// A number with its unit.
    pub size: String,
}

impl Deviation {
    /// Reads `length=0.1mm`, `pivot=0.1mm` or `parameter=value`.
    ///
    /// # Errors
    /// There is no `=`.
    pub fn read(text: &str) -> Result<Deviation, String> {
        let (what, size) = text.split_once('=').ok_or("write `length=0.1mm`, `pivot=0.1mm` or `parameter=0.1mm`")?;
        Ok(Deviation { what: what.trim().to_owned(), size: size.trim().to_owned() })
    }
}

/// What deviations do to what is of interest.
#[derive(Clone, Debug)]
pub struct TurnTolerances {
    /// The name of the scene.
    pub name: String,
    pub deviating: Vec<DeviatingOutput>,
}

/// What deviates, its SI unit, by how much, and the input at which the worst case is largest.
#[derive(Clone, Debug)]
pub struct DeviatingOutput {
    pub name: String,
    pub unit: String,
    pub tolerances: Tolerances,
    /// The SI units of the dimensions.
    pub units: Vec<String>,
    /// And that of the input.
    pub worst_at: (f64, String),
}

/// A dimension that deviates: its parameter in the copy of the mechanism.
struct Dimension {
    name: String,
    parameter: String,
    value: f64,
    unit: String,
    size: f64,
}

/// What is measured: columns among the outputs.
enum Measured {
    Value(usize),
    /// x, y of a point, then its velocity: only what is across the path counts.
    Across([usize; 4]),
}

/// What deviations do to the output and to the point that are requested.
///
/// # Errors
/// Faults of the scene, a request that does not fit it, a motion that has no derivatives.
pub fn tolerances(
    scene: &Scene,
    mechanism: &Mechanism,
    request: &MotionRequest,
    deviations: &[Deviation],
) -> Result<TurnTolerances, MotionError> {
    let course = InputRun::of(scene, mechanism, request)?;
    is_regular(&course)?;
    let mut deviating = Deviating { mechanism: course.moved.mechanism.clone(), dimensions: Vec::new() };
    deviating.add(deviations, request.point.as_deref())?;
    let Deviating { mechanism: with_parameters, dimensions } = deviating;
    let moved = drive::Moved { mechanism: with_parameters, ..course.moved.clone() };
    let way = drive::way(&moved, &course.drive)?;
    let (outputs, measured) = measured(&course, &way, request.point.as_deref())?;
    let positions = Positions::new(&way, course.drive.pace());
    let names: Vec<String> = dimensions.iter().map(|dimension| dimension.parameter.clone()).collect();
    let mut study = Study::of(way.driven.mechanism.clone(), outputs.clone(), course.moved.source.clone());
    let start: Vec<f64> = dimensions.iter().map(|dimension| dimension.value).collect();
    let rows = study.varying(&names, |varying| varying.at(&start, &positions.times)).map_err(refused)?;
    let samples = sampled(&way, outputs, &dimensions, &positions.times)?;
    let deviating = measured.into_iter().map(|(name, unit, measured)| {
        let (tolerances, worst) = measured.tolerances(&dimensions, &rows, &samples);
        let units = dimensions.iter().map(|dimension| dimension.unit.clone()).collect();
        let worst_at = (positions.inputs[worst], unit_of(course.drive.motion).si);
        DeviatingOutput { name, unit, tolerances, units, worst_at }
    });
    Ok(TurnTolerances { name: mechanism.name.clone(), deviating: deviating.collect() })
}

/// At a dead point of the input a deviation is infinite in first order, or the input no longer gets there.
fn is_regular(course: &InputRun) -> Result<(), MotionError> {
    let refused = |what: &str| {
        Err(MotionError::Request(format!(
            "deviations have no first-order effect where {what}: give a range of the input without such positions, such as `--range \"10 deg..60 deg\"`"
        )))
    };
    match &course.places {
        SpecialPlaces::Ordinary => Ok(()),
        SpecialPlaces::Folds(_) => refused("the input reaches a dead point"),
        SpecialPlaces::Crossings(_) => refused("the mechanism passes a change point"),
    }
}

fn refused(error: StudyError) -> MotionError {
    match error {
        StudyError::Scene(faults) => faults.into(),
        StudyError::Analysis(error) => {
            MotionError::Request(format!("the effect of deviations is not determined: {error}"))
        }
    }
}

/// Positions of the input, and when they are reached.
struct Positions {
    inputs: Vec<f64>,
    times: Vec<f64>,
}

impl Positions {
    fn new(way: &Way, pace: f64) -> Positions {
        let every = (way.count / POSITIONS).max(1);
        let indices = (0..=way.count).step_by(every);
        let inputs = indices.clone().map(|index| way.begin + way.step * index as f64).collect();
        Positions { inputs, times: indices.map(|index| way.step.abs() * index as f64 / pace).collect() }
    }
}

/// A mechanism with a parameter for each dimension that deviates.
struct Deviating {
    mechanism: Mechanism,
    dimensions: Vec<Dimension>,
}

impl Deviating {
    fn add(&mut self, deviations: &[Deviation], point: Option<&str>) -> Result<(), MotionError> {
        for Deviation { what, size } in deviations {
            let parameter = self.mechanism.parameters.iter().find(|own| own.name == *what).cloned();
            let is_word = what == LENGTH || what == PIVOT;
            let unit = parameter.as_ref().map_or_else(Unit::length, |own| own.unit.clone());
            let size = positive(what, size, &unit)?;
            match (parameter, is_word) {
                (Some(_), true) => {
                    return Err(MotionError::Request(format!(
                        "--tolerance {what}: `{what}` is also a parameter of the scene; rename the parameter"
                    )));
                }
                (Some(own), false) => self.dimensions.push(Dimension {
                    name: own.name.clone(),
                    parameter: own.name,
                    value: own.value,
                    unit: own.unit.si,
                    size,
                }),
                (None, true) => self.add_points(what == PIVOT, size, point)?,
                (None, false) => return Err(self.unknown(what)),
            }
        }
        Ok(())
    }

    fn unknown(&self, what: &str) -> MotionError {
        if let Some(why) = self.mechanism.why_calculated(what) {
            return MotionError::Request(format!("--tolerance {what}: {why}"));
        }
        let names = self.mechanism.parameters.iter().map(|own| own.name.as_str());
        let known = suggest::known(what, [LENGTH, PIVOT].into_iter().chain(names));
        MotionError::Request(format!("--tolerance {what}: there is no such dimension; {known}"))
    }

    /// Those of all bodies, or of the ground.
    fn add_points(&mut self, of_ground: bool, size: f64, point: Option<&str>) -> Result<(), MotionError> {
        let before = self.dimensions.len();
        for (body, places) in used(&self.mechanism, point) {
            match (body, of_ground) {
                (None, true) => self.add_pivots(&places, size),
                (Some(_), false) => self.add_lengths(&places, size),
                (None, false) | (Some(_), true) => {}
            }
        }
        if self.dimensions.len() > before {
            return Ok(());
        }
        let message = match of_ground {
            true => "--tolerance pivot: no joint is at a point of the ground",
            false => "--tolerance length: no body has two joints at points of its own",
        };
        Err(MotionError::Request(message.to_owned()))
    }

    fn add_pivots(&mut self, places: &[Place], size: f64) {
        for &place in places {
            let name = self.mechanism.place_name(place);
            self.deviate(format!("{name} x"), place, [1.0, 0.0], size);
            self.deviate(format!("{name} y"), place, [0.0, 1.0], size);
        }
    }

    /// From the first place on: the distance of the second one, and the others along and across.
    fn add_lengths(&mut self, places: &[Place], size: f64) {
        let Some((&first, others)) = places.split_first() else { return };
        let start = at(&self.mechanism, first);
        let mut along: Option<[f64; 2]> = None;
        for &place in others {
            let [x, y] = at(&self.mechanism, place);
            let (dx, dy) = (x - start[0], y - start[1]);
            let distance = dx.hypot(dy);
            let names = [first, place].map(|place| self.mechanism.place_name(place));
            let between = format!("{} to {}", names[0], names[1]);
            match along {
                None if distance > 0.0 => {
                    let direction = [dx / distance, dy / distance];
                    self.deviate(between, place, direction, size);
                    along = Some(direction);
                }
                _ => {
                    let [c, s] = along.unwrap_or([1.0, 0.0]);
                    self.deviate(format!("{between}, along"), place, [c, s], size);
                    self.deviate(format!("{between}, across"), place, [-s, c], size);
                }
            }
        }
    }

    /// One more parameter, 0 in the scene, by which a point moves in a direction.
    fn deviate(&mut self, name: String, place: Place, direction: [f64; 2], size: f64) {
        let parameter = format!("cotree_deviation_{}", self.dimensions.len());
        let (mut mechanism, id) = self.mechanism.with_parameter(&parameter, Unit::length(), 0.0);
        let point = match place {
            Place::Ground(point) => &mut mechanism.ground[point],
            Place::Point(body, point) => &mut mechanism.bodies[body.0].points[point],
            Place::Origin | Place::Centre(_) => return,
        };
        for (coordinate, share) in point.at.iter_mut().zip(direction) {
            if share != 0.0 {
                *coordinate = coordinate.clone() + Formula::Number(share) * Formula::Parameter(id);
            }
        }
        self.mechanism = mechanism;
        self.dimensions.push(Dimension { name, parameter, value: 0.0, unit: "m".to_owned(), size });
    }
}

fn positive(what: &str, size: &str, unit: &Unit) -> Result<f64, MotionError> {
    let wrong = |message: String| MotionError::Request(format!("--tolerance {what}: {message}"));
    let size = quantity(size, unit).map_err(|error: QuantityError| wrong(error.to_string()))?;
    if size > 0.0 && size.is_finite() { Ok(size) } else { Err(wrong("a deviation must be positive".to_owned())) }
}

/// Places of joints, and the point of interest, body by body; the ground is none. What stands for the centre of mass comes first: it has no point that could deviate.
fn used(mechanism: &Mechanism, point: Option<&str>) -> BTreeMap<Option<BodyId>, Vec<Place>> {
    let of_joints = mechanism.joints.iter().flat_map(|joint| joint.between);
    let named = mechanism.body_places().find(|place| Some(&*mechanism.place_name(*place)) == point);
    let mut used: BTreeMap<Option<BodyId>, Vec<Place>> = BTreeMap::new();
    for place in of_joints.chain(named) {
        let places = used.entry(place.body()).or_default();
        match place {
            Place::Origin => {}
            Place::Centre(_) | Place::Ground(_) | Place::Point(..) if places.contains(&place) => {}
            Place::Centre(_) => places.insert(0, place),
            Place::Ground(_) | Place::Point(..) => places.push(place),
        }
    }
    used
}

fn at(mechanism: &Mechanism, place: Place) -> [f64; 2] {
    let parameters = mechanism.parameter_values();
    let of = |point: &cotree::model::Point| point.at.each_ref().map(|part| evaluate(part, &parameters));
    match place {
        Place::Ground(point) => of(&mechanism.ground[point]),
        Place::Point(body, point) => of(&mechanism.bodies[body.0].points[point]),
        Place::Origin | Place::Centre(_) => [0.0; 2],
    }
}

/// What is requested of the driven mechanism, and what is measured of it: name, unit, columns.
type RequestedOutputs = (Vec<Output>, Vec<(String, String, Measured)>);

fn measured(course: &InputRun, way: &Way, point: Option<&str>) -> Result<RequestedOutputs, MotionError> {
    let (mut outputs, mut measured) = (Vec::new(), Vec::new());
    let mechanism = &way.driven.mechanism;
    if let Some(watched) = &course.output {
        let of_scene = way.driven.watched.iter().find(|output| output.name == watched.requested.name);
        outputs.push(of_scene.unwrap_or(&watched.requested).clone());
        measured.push((watched.name.clone(), watched.unit.si.clone(), Measured::Value(0)));
    }
    if let Some(point) = point {
        let place = mechanism.body_places().find(|place| mechanism.place_name(*place) == point);
        let place = place.ok_or_else(|| super::figures::unknown_point(mechanism, point))?;
        let first = outputs.len();
        let variable = |quantity| mechanism.output(Variable { owner: Owner::Place(place), quantity });
        outputs.extend([Quantity::X, Quantity::Y, Quantity::Vx, Quantity::Vy].map(variable));
        let columns = std::array::from_fn(|index| first + index);
        measured.push((format!("{point} across its path"), "m".to_owned(), Measured::Across(columns)));
    }
    if measured.is_empty() {
        let message = "--tolerance: nothing is of interest: give --output or --point";
        return Err(MotionError::Request(message.to_owned()));
    }
    Ok((outputs, measured))
}

/// The outputs at all positions, sample by sample; none of a sample that does not reach them all.
type Samples = Vec<Option<Vec<Vec<f64>>>>;

fn sampled(way: &Way, outputs: Vec<Output>, dimensions: &[Dimension], times: &[f64]) -> Result<Samples, MotionError> {
    let names: Vec<String> = outputs.iter().map(|output| output.name.clone()).collect();
    let compiled = way.driven.compiled(outputs)?;
    let description = &compiled.description;
    let place = |name: &String| description.variables.iter().position(|variable| variable.name == *name);
    let reported: Vec<usize> = names.iter().filter_map(place).collect();
    let factor = |dimension: &Dimension| {
        Some(DesignFactor {
            variable: place(&dimension.parameter)?,
            name: dimension.name.clone(),
            unit: dimension.unit.clone(),
            values: FactorValues::Normal(dimension.value, dimension.size / SIGMAS),
        })
    };
    let factors: Vec<DesignFactor> = dimensions.iter().filter_map(factor).collect();
    let design = Design::random(factors, Sampling::Random, SAMPLES, SEED)
        .map_err(|error| MotionError::Request(format!("--tolerance: {error}")))?;
    let members: Vec<Settings> = (0..design.len()).map(|index| design.settings(index)).collect();
    let model = Arc::new(Model::new(compiled.program.clone()).map_err(RunError::from)?);
    let run = Run { description, experiment: description.experiment, settings: Vec::new(), inputs: None, reported };
    let stop = AtomicBool::new(false);
    let ensemble = Ensemble::new(run, model, 0, &stop).map_err(|error| RunError::from(io::Error::other(error)))?;
    let ended = ensemble.at(times).run(&members, Vec::new, |rows, _, values| rows.push(values.to_vec()));
    let reached = |(rows, ended): (Vec<Vec<f64>>, cotree::run::Ended)| ended.is_ok().then_some(rows);
    Ok(ended.into_iter().map(reached).map(|rows| rows.filter(|rows| rows.len() == times.len())).collect())
}

impl Measured {
    /// What the deviations do, and at which position most.
    fn tolerances(
        &self,
        dimensions: &[Dimension],
        rows: &[(DVector<f64>, DMatrix<f64>)],
        samples: &Samples,
    ) -> (Tolerances, usize) {
        let names = dimensions.iter().map(|dimension| dimension.name.clone()).collect();
        let mut first = FirstOrder::new(names, dimensions.iter().map(|dimension| dimension.size).collect());
        for (values, derivatives) in rows {
            let slopes = self.weights(values.as_slice()).into_iter().fold(
                vec![0.0; dimensions.len()],
                |mut slopes, (column, weight)| {
                    slopes.iter_mut().enumerate().for_each(|(i, slope)| *slope += weight * derivatives[(column, i)]);
                    slopes
                },
            );
            first.add(&[slopes]);
        }
        let worst = first.worst_position();
        let error = |sample: &Vec<Vec<f64>>| {
            let errors = rows.iter().zip(sample).map(|((values, _), sample)| {
                let parts = self.weights(values.as_slice()).into_iter();
                parts.map(|(column, weight)| weight * (sample[column] - values[column])).sum::<f64>().abs()
            });
            errors.fold(0.0, f64::max)
        };
        let errors = samples.iter().flatten().map(error).collect();
        (first.sampled(errors, samples.len()), worst)
    }

    /// The error is this sum of deviations of outputs.
    fn weights(&self, values: &[f64]) -> Vec<(usize, f64)> {
        match *self {
            Measured::Value(column) => vec![(column, 1.0)],
            Measured::Across([x, y, vx, vy]) => {
                let speed = values[vx].hypot(values[vy]).max(f64::MIN_POSITIVE);
                vec![(x, -values[vy] / speed), (y, values[vx] / speed)]
            }
        }
    }
}

impl TurnTolerances {
    /// Tables for people, and what scripts read.
    pub fn report(&self) -> Report {
        let columns = row!["", "worst case", "at input", "3 sigma", "sampled", "jammed"];
        let rows = self.deviating.iter().map(|own| {
            let Tolerances { worst, three_sigma, sampled, jammed, .. } = own.tolerances;
            let [worst, sigma, sampled] = [worst, three_sigma, sampled].map(|value| line![number(value, &own.unit)]);
            let (input, unit) = &own.worst_at;
            row![own.name.clone(), worst, line![number(*input, unit)], sigma, sampled, jammed.to_string()]
        });
        let mut tables = vec![Table { left: 1, ..Table::new(columns, rows) }];
        tables.extend(self.deviating.iter().map(DeviatingOutput::contributions));
        let title = format!("{}: effect of deviations, with the input held", self.name);
        let data = self.deviating.iter().map(DeviatingOutput::data).collect::<Vec<_>>();
        Report { tables, data: json!(data), ..Report::new(row![title]) }
    }
}

impl DeviatingOutput {
    fn contributions(&self) -> Table {
        let columns = row!["dimension", "deviates by", named("error of this deviation alone", &self.unit)];
        let rows = self.tolerances.contributions.iter().zip(&self.units).map(|(own, unit)| {
            row![own.name.clone(), line![number(own.tolerance, unit)], number(own.error, &self.unit)]
        });
        Table {
            heading: Some(Cell::from(format!("{}, deviation by deviation", self.name))),
            left: 1,
            ..Table::new(columns, rows)
        }
    }

    fn data(&self) -> serde_json::Value {
        let own = &self.tolerances;
        let each = own.contributions.iter().zip(&self.units).map(|(own, unit)| {
            json!({ "dimension": own.name, "tolerance": own.tolerance, "unit": unit, "error": own.error })
        });
        json!({
            "of": self.name, "unit": self.unit, "worst": own.worst, "worst_at": self.worst_at.0, "three_sigma": own.three_sigma,
            "sampled": own.sampled, "jammed": own.jammed, "contributions": each.collect::<Vec<_>>(),
        })
    }
}
