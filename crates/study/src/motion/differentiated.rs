//! A full turn with other values of parameters and constant inputs, and its exact derivatives: its equations are formulated and differentiated once, for all values of a search.
//!
//! How the columns of a turn change with a quantity is exact; the figures are made of them as they are of those of one motion.

use std::collections::HashMap;
use std::sync::Arc;

use cotree::model::Mechanism;
use cotree::scene::Scene;

use super::drive::{self, InputTable, Moved, Way};
use super::figures::{self, Figures, Subject};
use super::{InputRun, MotionRequest, SpecialPlaces, input};
use crate::analysis::{AlongAt, Differentiated, Study};

/// Speeds that differ by this share are different ones.
const SAME_SPEED: f64 = 1e-12;

/// The turn of a scene.
pub(crate) struct DifferentiatedTurn<'a> {
    scene: &'a Scene,
    request: &'a MotionRequest,
    names: Vec<String>,
    course: InputRun,
    /// As it is; with a unit load on the output, if a joint is.
    plain: DifferentiatedWay,
    loaded: Option<DifferentiatedWay>,
}

/// The figures with some values, and with each quantity a step more and a step less.
pub(crate) type FiguresBeside = (Figures, Vec<[Figures; 2]>);

impl<'a> DifferentiatedTurn<'a> {
    /// None where something else than the columns depends on the values: a range between dead points or hard stops, samples of cams, friction that may stick, forces at rest; or where
    /// the motion has no derivatives.
    pub fn new(scene: &'a Scene, study: &Study, request: &'a MotionRequest, names: &[String]) -> Option<Self> {
        let mechanism = study.mechanism();
        let is_known = |name: &String| {
            mechanism.parameters.iter().any(|own| own.name == *name)
                || mechanism.inputs.iter().any(|own| own.name == *name)
        };
        let course = InputRun::of(scene, mechanism, request).ok()?;
        let is_plain = course.drive.range.is_none()
            && course.drive.speed != 0.0
            && course.table.periodic
            && course.places == SpecialPlaces::Ordinary
            && course.stops.is_none()
            && mechanism.profiles(&mechanism.parameter_values()).is_empty()
            && course.moved.mechanism.first_slip().is_none();
        if !is_plain || !names.iter().all(is_known) {
            return None;
        }
        let plain = DifferentiatedWay::new(&course.moved, &course, names)?;
        let loaded = match figures::load(&subject(&course, &course.mechanism, request)) {
            Some(load) => {
                let moved = Moved { mechanism: course.moved.mechanism.loaded(load), ..course.moved.clone() };
                Some(DifferentiatedWay::new(&moved, &course, names)?)
            }
            None => None,
        };
        Some(DifferentiatedTurn { scene, request, names: names.to_vec(), course, plain, loaded })
    }

    /// None where the turn does not close with these values, has another speed, or has no derivatives.
    pub fn figures(&self, values: &[f64], steps: &[f64]) -> Option<FiguresBeside> {
        let mechanism = self.with(values);
        if self.request.speed.is_none() && !self.is_as_fast(&mechanism) {
            return None;
        }
        let subject = subject(&self.course, &mechanism, self.request);
        let plain = self.plain.tables(values, &self.course)?;
        let loaded = match &self.loaded {
            Some(loaded) => Some(loaded.tables(values, &self.course)?),
            None => None,
        };
        let changed = |quantity: usize, step: f64| {
            let mut moved = values.to_vec();
            moved[quantity] += step;
            let mechanism = self.with(&moved);
            let subject = Subject { mechanism: &mechanism, ..subject };
            let loaded = loaded.as_ref().map(|loaded| loaded.changed(quantity, step));
            figures::of_tables(&subject, &plain.changed(quantity, step), None, loaded.as_ref()).ok()
        };
        let here = figures::of_tables(&subject, &plain.table, None, loaded.as_ref().map(|own| &own.table)).ok()?;
        let both = |(quantity, step): (usize, &f64)| Some([changed(quantity, *step)?, changed(quantity, -step)?]);
        Some((here, steps.iter().enumerate().map(both).collect::<Option<_>>()?))
    }

    fn with(&self, values: &[f64]) -> Mechanism {
        let mut mechanism = self.course.mechanism.clone();
        for (name, value) in self.names.iter().zip(values) {
            let parameters = mechanism.parameters.iter_mut().map(|own| (&own.name, &mut own.value));
            let inputs = mechanism.inputs.iter_mut().map(|own| (&own.name, &mut own.start));
            parameters.chain(inputs).filter(|(own, _)| *own == name).for_each(|(_, own)| *own = *value);
        }
        mechanism
    }

    /// Does the scene move the input as fast as with its own values?
    fn is_as_fast(&self, mechanism: &Mechanism) -> bool {
        let drive = &self.course.drive;
        let start = input::start(self.scene, mechanism, &[], (drive.joint, drive.motion));
        start.is_ok_and(|start| (start.speed - self.course.speed).abs() <= SAME_SPEED * self.course.speed.abs())
    }
}

fn subject<'s>(course: &'s InputRun, mechanism: &'s Mechanism, request: &'s MotionRequest) -> Subject<'s> {
    Subject {
        moved: &course.moved,
        mechanism,
        drive: &course.drive,
        output: course.output.as_ref(),
        request,
        lacking: &course.lacking,
        places: &course.places,
        stops: None,
        only_table: true,
    }
}

/// A driven mechanism whose outputs are differentiated.
struct DifferentiatedWay {
    way: Way,
    study: Study,
    differentiated: Arc<Differentiated>,
    times: Vec<f64>,
}

/// The samples of a turn, and how they change with each quantity.
struct DifferentiatedTable {
    table: InputTable,
    slopes: Vec<HashMap<String, Vec<f64>>>,
}

impl DifferentiatedWay {
    fn new(moved: &Moved, course: &InputRun, names: &[String]) -> Option<DifferentiatedWay> {
        let way = drive::way(moved, &course.drive).ok()?;
        let outputs = drive::outputs(&way.driven, &course.drive);
        let mut study = Study::of(way.driven.mechanism.clone(), outputs, moved.source.clone());
        let differentiated = study.differentiated(names).ok()?;
        let times = (0..=way.count).map(|index| way.step * index as f64 / course.drive.pace()).collect();
        Some(DifferentiatedWay { way, study, differentiated, times })
    }

    fn tables(&self, values: &[f64], course: &InputRun) -> Option<DifferentiatedTable> {
        let varying = self.study.varying_of(&self.differentiated);
        let rows = varying.along(values, &self.times, None, u64::MAX).ok()?.rows;
        let named = |of: &dyn Fn(&AlongAt, usize) -> f64| -> HashMap<String, Vec<f64>> {
            let column = |output: usize| rows.iter().map(|row| of(row, output)).collect();
            varying.outputs().enumerate().map(|(output, (name, _))| (name.to_owned(), column(output))).collect()
        };
        let table = |columns| self.way.table_of_turn(columns, &course.moved.mechanism, &course.drive);
        let values_of = table(named(&|(values, _), output| values[output]))?;
        let slopes = (0..values.len())
            .map(|quantity| self.way.ordered(named(&|(_, slopes), output| slopes[(output, quantity)]), &course.drive));
        Some(DifferentiatedTable { table: values_of, slopes: slopes.collect() })
    }
}

impl DifferentiatedTable {
    /// A quantity a step further.
    fn changed(&self, quantity: usize, step: f64) -> InputTable {
        self.table.moved(&self.slopes[quantity], step)
    }
}
