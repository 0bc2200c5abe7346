//! How a motion changes with parameters, constant inputs and initial values: the variational equations along the motion (direct differentiation;
//! Haug, Wehage and Mani, *ASME J. Mech. Transm. Autom. Des.* 106, 1984).
//!
//! With K = \[M Phi_q^T; Phi_q 0\] and all derivatives at fixed time,
//!
//! K \[a_p; lambda_p\] = -(d/dq q_p + d/dv v_p + d/dp) \[M a + Phi_q^T lambda - Q; Phi_q a - gamma\].
//!
//! Its solution comes from Taylor series in dual numbers ([`cotree_fmu::instance::Variational`]); where there are none, from collocation at the Gauss nodes, with steps that
//! the last coefficients of a_p choose. The motion is that of the program that runs in the FMU; q_p and v_p are put back onto the varied loop equations after each step.

mod collocation;
mod corner;
mod event;
mod feature;
mod instants;
mod rest;
mod rule;
mod start;
mod step;

use std::sync::Arc;

use cotree::diagnostic::{every, suggest};
use cotree::expr::{Order, Symbol};
use cotree::formulate::{Formulated, formulate_written};
use cotree::model::{Mechanism, Unit};
use cotree::scene::Faults;
use cotree_fmu::instance::{self, InstanceError};
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Condition;
use nalgebra::{DMatrix, DVector};

use super::driven::{DrivenInputs, InputRow};
use super::kept::DerivativesKey;
use super::variation::Variation;
use super::{AnalysisFailure, SetError, Study, StudyError};
use corner::Switched;
pub use feature::{Feature, FeatureDerivatives, FeatureKind, NotDifferentiable};
pub use rest::ModeChanges;
pub use step::At;
use step::DifferentiatedMotion;
pub(super) use step::counts_as_imposed;

/// A guess that is further away from what has become of it, in units of its scale, is written anew.
const MOVED: f64 = 0.1;

/// Derivatives of outputs along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivities {
    /// \[s\]
    pub times: Vec<f64>,
    /// What was differentiated, with its unit.
    pub outputs: Vec<(String, String)>,
    /// With respect to what, with its unit.
    pub parameters: Vec<(String, String)>,
    /// The outputs at each time, SI; not a number where one has no value.
    pub values: Vec<DVector<f64>>,
    /// Their derivatives at fixed time: for each time a row for each output and a column for each parameter, SI.
    pub derivatives: Vec<DMatrix<f64>>,
    /// Steps that the derivatives took, those included that were not good enough.
    pub steps: u64,
}

/// A motion, its derivatives, and what they took.
#[derive(Clone, Debug)]
pub struct Along {
    /// At each time.
    pub rows: Vec<At>,
    /// How it began: motions with values close to these begin nearby.
    pub start: State,
    /// Steps of the derivatives, those included that were not good enough.
    pub steps: u64,
    /// How much work it was, in steps of the motion and points at which its derivatives were evaluated.
    pub work: u64,
    /// The event that has ended the motion, where rows have no fixed time: the last one is that of the end, with the derivatives along with it.
    pub ended: Option<EarlyEnd>,
    /// The laws that have switched.
    switched: Vec<Switched>,
}

/// A variable of `[initial]` that only picks the assembly.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    pub name: String,
    pub unit: Unit,
    /// What was guessed, and what it is, SI.
    pub guessed: f64,
    pub found: f64,
    /// How much counts as one.
    pub scale: f64,
}

/// A motion that can be repeated with other values of what it is differentiated with respect to: the equations are differentiated once.
#[derive(Debug)]
pub struct Varying<'f> {
    differentiated: &'f Differentiated,
    parameters: Vec<VariedQuantity>,
    /// What else has other values than the program, SI.
    set: Vec<(String, f64)>,
    driven: DrivenInputs,
}

/// How a run ends before its stop time.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlyEnd {
    /// The event.
    pub event: String,
    /// When \[s\].
    pub time: f64,
    /// How that changes, one for each parameter.
    pub changes: Vec<f64>,
}

/// Equations and their derivatives, for motions with any values.
#[derive(Debug)]
pub(crate) struct Differentiated {
    formulated: Formulated,
    variation: Variation,
    model: Arc<Model>,
    /// With the values of the program.
    parameters: Vec<VariedQuantity>,
}

/// What a motion is differentiated with respect to.
#[derive(Clone, Debug)]
pub struct VariedQuantity {
    /// The user's name.
    pub name: String,
    pub unit: Unit,
    /// Its value in the scene, SI.
    pub start: f64,
    /// Smallest and largest permitted value, SI.
    pub bounds: [Option<f64>; 2],
    /// What it is in the program, and in the equations.
    place: instance::Varied,
    symbol: Symbol,
    /// The row of an input over time.
    row: Option<InputRow>,
}

impl Differentiated {
    fn new(mut formulated: Formulated, driven: &DrivenInputs, to: &[String]) -> Result<Self, AnalysisFailure> {
        let parameters = varied(&formulated, driven, to)?;
        let program = &formulated.lowered.program;
        let refused = |what: String| AnalysisFailure::NoDerivative { time: program.experiment.start, what };
        let given = |varied: &&VariedQuantity| {
            varied.row.is_none()
                && matches!(varied.place, instance::Varied::Input(index) if driven.inputs().contains(&index))
        };
        if let Some(VariedQuantity { name, .. }) = parameters.iter().find(given) {
            return Err(refused(format!(
                "`{name}` is an input over time: it has no single value that could change; differentiate with respect to its rows, such as `{name}[0]`"
            )));
        }
        let with_rates = program.inputs_with_rates();
        if let Some(&input) = driven.inputs().iter().find(|input| !program.is_driven() && with_rates.contains(input)) {
            let name = &program.inputs[input].name;
            return Err(refused(format!(
                "a driver follows `{name}`, whose rate may jump: derivatives are available for constant inputs only"
            )));
        }
        if let Some(part) = formulated.equations.system.mechanism.parts_over_pulleys().next() {
            return Err(refused(format!(
                "`{}` runs over pulleys, and derivatives of its wraps are not available; compare runs by `cotree sweep`",
                part.name
            )));
        }
        if let Some(part) = formulated.equations.system.mechanism.first_at_profile() {
            return Err(refused(format!(
                "`{}` touches a profile, and derivatives of where it goes on from one line or arc to the next are not available; compare runs by `cotree sweep`",
                part.name
            )));
        }
        if program.is_driven() && !program.instants.is_empty() {
            return Err(refused(
                "drivers determine the motion, and values jump at events: derivatives are not available; compare runs by `cotree sweep`".to_owned(),
            ));
        }
        if !program.followers.is_empty() {
            return Err(refused("a driver integrates an input: derivatives are not available".to_owned()));
        }
        let model = Arc::new(Model::new(program.clone())?);
        // Time is a column of its own, and so are the inputs that change with it: switching functions may depend on them.
        let moving = driven.inputs().iter().map(|&input| Symbol::Input(input, Order::Position));
        // Discrete variables follow from the motion so far.
        let discrete = instants::following(program).map(Symbol::Discrete);
        let signals = parameters
            .iter()
            .map(|parameter| parameter.symbol)
            .chain([Symbol::Time])
            .chain(moving)
            .chain(discrete)
            .collect();
        let variation = Variation::of_constraints(&mut formulated, signals);
        Ok(Differentiated { formulated, variation, model, parameters })
    }

    /// The value that the program gives a parameter, an initial value or an input.
    fn value(&self, name: &str) -> Option<f64> {
        let program = self.model.program();
        let parameters = program.parameters.iter().map(|parameter| (&parameter.name, parameter.start));
        let mut all = parameters.chain(program.inputs.iter().map(|input| (&input.name, input.start)));
        all.find(|(parameter, _)| *parameter == name).map(|(_, value)| value)
    }
}

impl<'f> Varying<'f> {
    fn new(differentiated: &'f Differentiated, settings: &[(String, f64)], driven: DrivenInputs) -> Self {
        let set = |name: &str| settings.iter().find(|(known, _)| known == name).map(|(_, value)| *value);
        let start = |parameter: &VariedQuantity| match parameter.row {
            Some(row) => driven.row_value(row),
            None => set(&parameter.name).unwrap_or(parameter.start),
        };
        let started = |parameter: &VariedQuantity| VariedQuantity { start: start(parameter), ..parameter.clone() };
        let parameters: Vec<VariedQuantity> = differentiated.parameters.iter().map(started).collect();
        let others = settings.iter().filter(|(name, value)| {
            differentiated.value(name) != Some(*value) && parameters.iter().all(|parameter| parameter.name != *name)
        });
        Varying { differentiated, set: others.cloned().collect(), parameters, driven }
    }

    /// What is varied.
    pub fn parameters(&self) -> &[VariedQuantity] {
        &self.parameters
    }

    pub fn outputs(&self) -> impl Iterator<Item = (&str, &Unit)> + Clone {
        let outputs = &self.differentiated.formulated.outputs;
        outputs.iter().map(|output| (output.name.as_str(), &output.unit))
    }

    /// The outputs at these times \[s\], ascending, and their derivatives, with the parameters at these values \[SI\].
    ///
    /// # Errors
    /// A motion that cannot be continued, or derivatives that do not exist.
    pub fn at(&self, values: &[f64], times: &[f64]) -> Result<Vec<At>, AnalysisFailure> {
        let rows = self.along(values, times, None, u64::MAX)?.rows;
        self.check_values(times, &rows)?;
        Ok(rows)
    }

    /// Checks that all outputs have a value and derivatives at these times.
    ///
    /// # Errors
    /// The first that has none.
    fn check_values(&self, times: &[f64], rows: &[At]) -> Result<(), AnalysisFailure> {
        for (&time, (values, derivatives)) in times.iter().zip(rows) {
            let missing = (0..values.len()).find(|&output| !is_finite(values, derivatives, output));
            let named = missing.and_then(|output| self.outputs().nth(output));
            if let Some((name, _)) = named {
                return Err(AnalysisFailure::NotFinite { time, what: name.to_owned() });
            }
        }
        Ok(())
    }

    /// The outputs and their derivatives along a motion of at most this much work; not a number where an output has no value or no derivative. The start is followed from that of another motion, if there is one, instead of being sought from the guesses.
    ///
    /// # Errors
    /// As of [`Varying::at`], or the work is more.
    pub fn along(
        &self,
        values: &[f64],
        times: &[f64],
        from: Option<&State>,
        most: u64,
    ) -> Result<Along, AnalysisFailure> {
        let along = self.along_to_end(values, times, from, most)?;
        match &along.ended {
            Some(EarlyEnd { event, time, .. }) => {
                Err(InstanceError::Ended { event: event.clone(), time: *time }.into())
            }
            None => Ok(along),
        }
    }

    /// The same of a motion that an event may end.
    ///
    /// # Errors
    /// As of [`Varying::along`].
    pub fn along_to_end(
        &self,
        values: &[f64],
        times: &[f64],
        from: Option<&State>,
        most: u64,
    ) -> Result<Along, AnalysisFailure> {
        let mut course = self.begin(values, from)?;
        let start = course.motion.state();
        let mut rows = Vec::with_capacity(times.len());
        course.run(times, most, |outputs| rows.push(outputs))?;
        let work = course.work();
        Ok(Along { rows, start, steps: course.tried, work, ended: course.ended, switched: course.switched })
    }

    /// The motion and its derivatives at the start, with the parameters at these values \[SI\].
    fn begin(&self, values: &[f64], from: Option<&State>) -> Result<DifferentiatedMotion<'_>, AnalysisFailure> {
        let mut driven = self.driven.clone();
        let mut changed: Vec<(&str, f64)> = self.set.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        for (parameter, &value) in self.differentiated.parameters.iter().zip(values) {
            match parameter.row {
                Some(row) => driven.set_row(row, value),
                None if parameter.start != value => changed.push((&parameter.name, value)),
                None => {}
            }
        }
        DifferentiatedMotion::new(self.differentiated, (&self.parameters, driven), &changed, from)
    }

    /// The guesses, and what has become of them at a start.
    ///
    /// # Errors
    /// A program that is none.
    pub fn guesses(&self, start: &State) -> Result<Vec<Guess>, AnalysisFailure> {
        let model = &self.differentiated.model;
        let initial = &model.program().initial;
        let mut machine = Machine::new(model);
        machine.load(model, start);
        machine.run(&initial.position);
        let mechanism = &self.differentiated.formulated.equations.system.mechanism;
        let count = initial.positions.len();
        let guess = |(index, condition): (usize, &Condition)| {
            let line =
                mechanism.initial.iter().find(|line| mechanism.variable_name(line.variable) == condition.name)?;
            let [found, guessed] = [index, count + index].map(|result| machine.result(&initial.position, result));
            let unit = Unit::of(&line.variable.quantity.measure(), line.display.clone());
            Some(Guess { name: condition.name.clone(), unit, guessed, found, scale: condition.scale })
        };
        let guesses = initial.positions.iter().enumerate().filter(|(_, condition)| !condition.known);
        Ok(guesses.filter_map(guess).collect())
    }
}

impl Varying<'_> {
    /// True if there is a start with the values that were set, and the loop equations count there as the program imposes them.
    fn begins(&self) -> bool {
        let start: Vec<f64> = self.parameters.iter().map(|parameter| parameter.start).collect();
        self.begin(&start, None).and_then(|course| course.counts_as_imposed()).unwrap_or(false)
    }

    /// The guesses that lie so far from the start that they are written anew.
    ///
    /// # Errors
    /// A program that is none.
    pub fn moved_guesses(&self, start: &State) -> Result<Vec<Guess>, AnalysisFailure> {
        let mut guesses = self.guesses(start)?;
        guesses.retain(|guess| (guess.found - guess.guessed).abs() > MOVED * guess.scale);
        Ok(guesses)
    }
}

impl Study {
    /// Derivatives of the scene's outputs with respect to parameters, constant inputs and initial values, at these times \[s\], ascending.
    ///
    /// Exact up to the tolerance of the scene: nothing is differenced. Where laws switch, the derivatives of rates jump as they should. A guess only picks the
    /// assembly; of what is left open at the start the pose next to the nominal one counts.
    ///
    /// # Errors
    /// A name that cannot be set, equations that cannot be formulated, a motion that cannot be continued, or derivatives that do not exist: at a
    /// singular pose, where a law is touched without being crossed, or where redundant joints fit for these very lengths only.
    pub fn sensitivities(&mut self, to: &[String], times: &[f64]) -> Result<Sensitivities, StudyError> {
        match self.sensitivities_to_end(to, times)? {
            (_, Some(EarlyEnd { event, time, .. })) => {
                Err(AnalysisFailure::from(InstanceError::Ended { event, time }).into())
            }
            (found, None) => Ok(found),
        }
    }

    /// The same of a motion that an event may end: then the last row is that of the end, with the derivatives along with it.
    ///
    /// # Errors
    /// As of [`Study::sensitivities`].
    pub fn sensitivities_to_end(
        &mut self,
        to: &[String],
        times: &[f64],
    ) -> Result<(Sensitivities, Option<EarlyEnd>), StudyError> {
        self.varying(to, |varying| {
            let start: Vec<f64> = varying.parameters.iter().map(|parameter| parameter.start).collect();
            let Along { rows, steps, ended, .. } = varying.along_to_end(&start, times, None, u64::MAX)?;
            let mut times = times.to_vec();
            if let Some(end) = &ended {
                times.truncate(rows.len().saturating_sub(1));
                times.push(end.time);
            }
            let (values, derivatives) = rows.into_iter().unzip();
            let found = Sensitivities {
                times,
                outputs: varying.outputs().map(|(name, unit)| (name.to_owned(), unit.si.clone())).collect(),
                parameters: varying
                    .parameters
                    .iter()
                    .map(|parameter| (parameter.name.clone(), parameter.unit.si.clone()))
                    .collect(),
                values,
                derivatives,
                steps,
            };
            Ok((found, ended))
        })
    }

    /// Hands over a motion that can be repeated with other values.
    ///
    /// # Errors
    /// A name that cannot be set, equations that cannot be formulated, or `then` fails.
    pub fn varying<T>(
        &mut self,
        to: &[String],
        then: impl FnOnce(&Varying) -> Result<T, AnalysisFailure>,
    ) -> Result<T, StudyError> {
        let differentiated = self.differentiated(to)?;
        Ok(then(&self.varying_of(&differentiated))?)
    }

    /// The equations and their derivatives: those of the scene where what was set can be given to its program, so that they are made once; of their own where it cannot.
    ///
    /// # Errors
    /// A name that cannot be set, or equations that cannot be formulated.
    pub(crate) fn differentiated(&mut self, to: &[String]) -> Result<Arc<Differentiated>, StudyError> {
        let rows = to.iter().filter_map(|name| self.driven().row(name));
        every(rows.map(|row| Ok(row?))).map_err(AnalysisFailure::Unknown)?;
        let experiment = self.experiment();
        let written = self.written.as_ref().map(|written| Mechanism { experiment, ..Mechanism::clone(written) });
        match written {
            Some(written) if self.settings().is_empty() => self.kept_or_made(&written, to),
            Some(written) => {
                let known = self.warnings.clone();
                match self.kept_or_made(&written, to) {
                    Ok(differentiated) if self.varying_of(&differentiated).begins() => Ok(differentiated),
                    Ok(_) | Err(_) => {
                        self.warnings = known;
                        self.made(&self.mechanism().clone(), to)
                    }
                }
            }
            None => self.made(&self.mechanism().clone(), to),
        }
    }

    fn kept_or_made(&mut self, written: &Mechanism, to: &[String]) -> Result<Arc<Differentiated>, StudyError> {
        let driven = self.driven().inputs().to_vec();
        let key = DerivativesKey { to: to.to_vec(), driven, experiment: written.experiment };
        if let Some(found) = self.kept.find(&key) {
            return Ok(found);
        }
        let made = self.made(written, to)?;
        self.kept.keep(key, &made);
        Ok(made)
    }

    fn made(&mut self, mechanism: &Mechanism, to: &[String]) -> Result<Arc<Differentiated>, StudyError> {
        let formulated = formulate_written(mechanism, &self.outputs);
        let mut formulated = formulated.map_err(|list| Faults::new(self.source.clone(), list))?;
        self.warnings.append(&mut formulated.warnings);
        Ok(Arc::new(Differentiated::new(formulated, self.driven(), to)?))
    }

    /// A motion of this study.
    pub(crate) fn varying_of<'f>(&self, differentiated: &'f Differentiated) -> Varying<'f> {
        Varying::new(differentiated, self.settings(), self.driven().clone())
    }
}

/// True if an output has a value and derivatives.
pub(crate) fn is_finite(values: &DVector<f64>, derivatives: &DMatrix<f64>, output: usize) -> bool {
    values[output].is_finite() && derivatives.row(output).iter().all(|derivative| derivative.is_finite())
}

/// The parameters, inputs, initial values or rows of inputs over time behind names.
fn varied(
    formulated: &Formulated,
    driven: &DrivenInputs,
    names: &[String],
) -> Result<Vec<VariedQuantity>, AnalysisFailure> {
    let quantity = |name: &String| match driven.row(name) {
        Some(row) => Ok(input_row(formulated, name, row?)),
        None => parameter(formulated, name),
    };
    every(names.iter().map(quantity)).map_err(AnalysisFailure::Unknown)
}

/// A row of an input over time. Its value is that of the table.
fn input_row(formulated: &Formulated, name: &str, row: InputRow) -> VariedQuantity {
    let cotree_fmu::program::Input { start, min, max, .. } = formulated.lowered.program.inputs[row.input];
    VariedQuantity {
        name: name.to_owned(),
        unit: formulated.equations.system.mechanism.inputs[row.input].unit.clone(),
        start,
        bounds: [min, max],
        place: instance::Varied::Input(row.input),
        symbol: Symbol::Input(row.input, Order::Position),
        row: Some(row),
    }
}

/// The parameter, input or initial value behind a name; or that there is none.
fn parameter(formulated: &Formulated, name: &str) -> Result<VariedQuantity, SetError> {
    let mechanism = &formulated.equations.system.mechanism;
    let program = &formulated.lowered.program;
    // In the program, initial values come after the parameters of the scene.
    let known = program.parameters.iter().position(|parameter| parameter.name == name);
    if let Some(index) = known {
        let place = || (mechanism.initial.iter()).position(|line| mechanism.variable_name(line.variable) == name);
        let unit = match mechanism.parameters.get(index) {
            Some(output) => output.unit.clone(),
            None => place().map_or_else(Unit::default, |place| {
                let line = &mechanism.initial[place];
                Unit::of(&line.variable.quantity.measure(), line.display.clone())
            }),
        };
        let cotree_fmu::program::Parameter { start, min, max, .. } = program.parameters[index];
        let (name, symbol) = (name.to_owned(), Symbol::Parameter(index));
        let place = instance::Varied::Parameter(index);
        return Ok(VariedQuantity { name, unit, start, bounds: [min, max], place, symbol, row: None });
    }
    if let Some(index) = program.inputs.iter().position(|input| input.name == name) {
        let cotree_fmu::program::Input { start, min, max, .. } = program.inputs[index];
        let (name, symbol) = (name.to_owned(), Symbol::Input(index, Order::Position));
        let place = instance::Varied::Input(index);
        let unit = mechanism.inputs[index].unit.clone();
        return Ok(VariedQuantity { name, unit, start, bounds: [min, max], place, symbol, row: None });
    }
    if let Some(why) = mechanism.why_calculated(name) {
        return Err(why.into());
    }
    let names = program.parameters.iter().map(|parameter| parameter.name.as_str());
    let names = names.chain(program.inputs.iter().map(|input| input.name.as_str()));
    Err(SetError(format!(
        "the scene has no parameter, input or initial value `{name}`; {known}",
        known = suggest::known(name, names)
    )))
}
