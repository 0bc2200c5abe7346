//! Analyses of a scene with its settings.

use std::sync::Arc;

use cotree::compile::QuantityError;
use cotree::diagnostic::suggest;
use cotree::formulate::{Formulated, formulate_written, pattern};
use cotree::model::{CalculatedError, Experiment, Formula, Mechanism, Output, Unit, Units, ValueError};
use cotree::report::csv::CsvTable;
use cotree::run::{Gaps, SettingError};
use cotree::scene::{self, Fault, Faults, Resolved, Scene, Source};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::{Model, State};
use thiserror::Error;

use super::driven::{DrivenInputs, InputTableError};
use super::kept::{DerivativesKey, Kept, PoseKey};
use super::local::Local;
use super::report::{Linearization, Statics, VibrationModes};
use super::requested::{self, ModeError, RequestedMode};
use super::sensitivity::Differentiated;
use super::{AnalysisFailure, Equilibrium, OperatingPoint, StateSpace, Variation, at_rest, modes};

/// A scene to be analysed: its mechanism, with the parameters and inputs that were set.
#[derive(Clone, Debug)]
pub struct Study {
    pub(super) mechanism: Mechanism,
    /// As the scene has it, before anything is set; none once the study begins elsewhere than the scene.
    pub(super) written: Option<Arc<Mechanism>>,
    /// What was set, SI.
    set: Vec<(String, f64)>,
    pub(super) kept: Kept<DerivativesKey, Differentiated>,
    local: Kept<PoseKey, Local>,
    pub(super) outputs: Vec<Output>,
    driven: DrivenInputs,
    /// What is to be open or closed, caught or free, to stick or slide where it rests or is linearised.
    requested: Vec<RequestedMode>,
    pub(super) source: Source,
    pub(super) warnings: Vec<Fault>,
}

/// Why there is no result.
#[derive(Debug, Error)]
pub enum StudyError {
    #[error(transparent)]
    Scene(#[from] Faults),
    #[error(transparent)]
    Analysis(#[from] AnalysisFailure),
}

/// Why something cannot be set or varied.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct SetError(pub String);

cotree::diagnostic::from_messages!(SetError as SetError: SettingError, CalculatedError, QuantityError, ValueError);

/// Where a mechanism is linearised.
#[derive(Clone, Debug, PartialEq)]
pub enum LinearisedAt {
    /// At the equilibrium next to the start.
    Equilibrium,
    /// At these times of the motion, ascending \[s\].
    Times(Vec<f64>),
}

impl Study {
    /// Resolves a scene.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn new(scene: &Scene) -> Result<Self, Faults> {
        Study::asking(scene, &scene::Requested::Own)
    }

    /// Resolves a scene, with the outputs that are asked for.
    ///
    /// # Errors
    /// Everything that is wrong with it; an output that it does not have.
    pub fn asking(scene: &Scene, requested: &scene::Requested) -> Result<Self, Faults> {
        let Resolved { mechanism, outputs, warnings } = scene.resolve_asking(requested)?;
        Ok(Study { warnings, ..Study::of(mechanism, outputs, scene.source.clone()) })
    }

    /// Of a mechanism that is made of a scene's, with these outputs.
    pub(crate) fn of(mechanism: Mechanism, outputs: Vec<Output>, source: Source) -> Self {
        Study {
            written: Some(Arc::new(mechanism.clone())),
            mechanism,
            set: Vec::new(),
            kept: Kept::default(),
            local: Kept::default(),
            outputs,
            driven: DrivenInputs::default(),
            requested: Vec::new(),
            source,
            warnings: Vec::new(),
        }
    }

    pub fn name(&self) -> &str {
        &self.mechanism.name
    }

    pub fn output_unit(&self, name: &str) -> Option<&Unit> {
        self.outputs.iter().find(|output| output.name == name).map(|output| &output.unit)
    }

    pub fn input_unit(&self, name: &str) -> Option<&Unit> {
        self.mechanism.inputs.iter().find(|input| input.name == name).map(|input| &input.unit)
    }

    /// The units of the scene's `[display]`.
    pub fn display(&self) -> &Units {
        &self.mechanism.display
    }

    /// Times and tolerance of the scene.
    pub fn experiment(&self) -> Experiment {
        self.mechanism.experiment
    }

    /// The mechanism, with what was set.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Other times and another tolerance than those of the scene.
    pub fn set_experiment(&mut self, experiment: Experiment) {
        self.mechanism.experiment = experiment;
    }

    /// What parts are where it rests or is linearised, in words: limits, contacts and ropes `closed` or `open`, freewheels `caught` or `free`; what rubs `sticks`, `slides` (as it does), `slides+` or
    /// `slides-`, or is `idle`: something else holds what it could.
    ///
    /// # Errors
    /// There is no such part, or it cannot be that.
    pub fn set_modes(&mut self, modes: &[(String, String)]) -> Result<(), ModeError> {
        self.requested = requested::requested(&self.mechanism, modes)?;
        Ok(())
    }

    /// Inputs over time, for every analysis of a motion: columns named like inputs.
    ///
    /// # Errors
    /// A column that is no input, or in another kind of unit.
    pub fn set_inputs(&mut self, table: CsvTable) -> Result<(), InputTableError> {
        self.driven = DrivenInputs::new(&self.mechanism, table)?;
        Ok(())
    }

    pub(super) fn driven(&self) -> &DrivenInputs {
        &self.driven
    }

    /// What is odd but no error, so far; each is given once.
    pub fn take_warnings(&mut self) -> Option<Faults> {
        let warnings = std::mem::take(&mut self.warnings);
        (!warnings.is_empty()).then(|| Faults::new(self.source.clone(), warnings))
    }

    /// Sets a parameter, an input, a value that `[initial]` gives, or a row of an input over time such as `push[3]`: `read` gives the value \[SI\] for its unit.
    ///
    /// # Errors
    /// There is nothing of that name, `read` fails, or the value is out of bounds.
    pub fn set(&mut self, name: &str, read: impl FnOnce(&Unit) -> Result<f64, QuantityError>) -> Result<(), SetError> {
        if let Some(row) = self.driven.row(name) {
            let row = row?;
            let input = &self.mechanism.inputs[row.input];
            let value = read(&input.unit)?;
            input.unit.permit(value, [input.min, input.max])?;
            self.driven.set_row(row, value);
            return Ok(());
        }
        let mechanism = &mut self.mechanism;
        if let Some(place) = (mechanism.initial.iter()).position(|line| mechanism.variable_name(line.variable) == name)
        {
            let line = &mut mechanism.initial[place];
            let unit = Unit::of(&line.variable.quantity.measure(), line.display.clone());
            let value = read(&unit)?;
            unit.permit(value, [None, None])?;
            line.value = Formula::Number(value);
            self.note(name, value);
            return Ok(());
        }
        let parameters = mechanism
            .parameters
            .iter_mut()
            .map(|parameter| (&parameter.name, &parameter.unit, [parameter.min, parameter.max], &mut parameter.value));
        let inputs = mechanism
            .inputs
            .iter_mut()
            .map(|input| (&input.name, &input.unit, [input.min, input.max], &mut input.start));
        let Some((_, unit, bounds, place)) = parameters.chain(inputs).find(|(known, ..)| *known == name) else {
            return Err(self.unknown(name));
        };
        let value = read(unit)?;
        unit.permit(value, bounds)?;
        *place = value;
        self.note(name, value);
        Ok(())
    }

    /// Of what is set twice the last counts.
    fn note(&mut self, name: &str, value: f64) {
        self.set.retain(|(known, _)| known != name);
        self.set.push((name.to_owned(), value));
    }

    /// What was set: names and values \[SI\].
    pub(super) fn settings(&self) -> &[(String, f64)] {
        &self.set
    }

    /// Does what was set change which loop equations are imposed? A program for the values of the scene would be refused.
    pub fn restricts_otherwise(&self, scene: &Scene) -> bool {
        let Ok(resolved) = scene.resolve() else { return false };
        let set = pattern(&self.mechanism);
        set.is_some() && set != pattern(&resolved.mechanism)
    }

    fn unknown(&self, name: &str) -> SetError {
        if let Some(why) = self.mechanism.why_calculated(name) {
            return why.into();
        }
        let parameters = self.mechanism.parameters.iter().map(|parameter| parameter.name.as_str());
        let known =
            suggest::known(name, parameters.chain(self.mechanism.inputs.iter().map(|input| input.name.as_str())));
        SettingError(format!("the scene has no parameter or input `{name}`; {known}")).into()
    }

    /// Where the mechanism rests: its pose, the reactions of all joints and drivers, and whether it is stable.
    ///
    /// # Errors
    /// The equations cannot be formulated, or no equilibrium is found.
    pub fn equilibrium(&mut self) -> Result<Statics, StudyError> {
        self.rest(|formulated, _, equilibrium| Ok(Statics::new(formulated, equilibrium)))
    }

    /// A, B, C, D from the inputs of the scene to its outputs.
    ///
    /// # Errors
    /// The equations cannot be formulated, the motion cannot be continued, or a pose is singular.
    pub fn linearize(&mut self, at: &LinearisedAt) -> Result<Linearization, StudyError> {
        let name = self.mechanism.name.clone();
        let points = match at {
            LinearisedAt::Equilibrium => self.rest(|formulated, variation, equilibrium| {
                Ok(vec![StateSpace::new(formulated, variation, &equilibrium.point, None)?])
            })?,
            LinearisedAt::Times(times) => {
                let (driven, requested) = (self.driven.clone(), self.requested.clone());
                self.formulated(false, |formulated, variation| {
                    along(formulated, variation, (driven, &requested), times)
                })?
            }
        };
        self.warnings.extend(self.without_value(&points));
        Ok(Linearization { name, points, step: None })
    }

    /// Which outputs of linear systems have no value, or not all derivatives.
    fn without_value(&self, points: &[StateSpace]) -> Option<Fault> {
        let mut gaps = Gaps::default();
        points.iter().for_each(|point| gaps.note(point.time, &point.gaps()));
        let outputs = &self.outputs;
        let derivatives: Vec<String> = outputs.iter().map(|output| format!("d({})", output.name)).collect();
        let names: Vec<&str> =
            outputs.iter().map(|output| &output.name).chain(&derivatives).map(String::as_str).collect();
        let place =
            |name: &str| names.iter().position(|output| *output == name).map_or(0, |place| place % outputs.len());
        gaps.warning(&names, |name| outputs[place(name)].span)
    }

    /// Natural frequencies, damping ratios and shapes, about the equilibrium next to the start or about the pose at a time \[s\].
    ///
    /// # Errors
    /// The equations cannot be formulated, there is no equilibrium, or the motion cannot be continued.
    pub fn modes(&mut self, at: Option<f64>) -> Result<VibrationModes, StudyError> {
        let Some(time) = at else {
            return self
                .rest(|formulated, variation, equilibrium| vibration(formulated, variation, &equilibrium.point, true));
        };
        let (driven, requested) = (self.driven.clone(), self.requested.clone());
        self.formulated(false, |formulated, variation| {
            let point = Followed::new(formulated, driven)?.point((formulated, variation), (time, time), &requested)?;
            vibration(formulated, variation, &point, false)
        })
    }

    /// Hands over the equations of the mechanism with their first variation, at rest or in motion: those of the scene where what was set can be given to its program, so that they are made once; of their
    /// own where it cannot.
    fn formulated<T>(
        &mut self,
        rests: bool,
        then: impl FnOnce(&mut Formulated, &Variation) -> Result<T, AnalysisFailure>,
    ) -> Result<T, StudyError> {
        let mut local = self.local(rests)?;
        Ok(then(&mut local.formulated, &local.variation)?)
    }

    fn local(&mut self, rests: bool) -> Result<Local, StudyError> {
        let of = |mechanism: &Mechanism| if rests { at_rest(mechanism) } else { mechanism.clone() };
        let (found_at, experiment) = (of(&self.mechanism), self.experiment());
        if let Some(written) = self.written.clone() {
            let known = self.warnings.clone();
            let key = PoseKey { rests, experiment };
            let kept = match self.local.find(&key) {
                Some(found) => Ok(found),
                None => self.made_local(&of(&Mechanism { experiment, ..Mechanism::clone(&written) })).map(|made| {
                    let made = Arc::new(made);
                    self.local.keep(key, &made);
                    made
                }),
            };
            if self.set.is_empty() {
                return kept.map(|kept| Local::clone(&kept));
            }
            if let Some(found) = kept.ok().and_then(|kept| kept.with_values(&found_at)) {
                return Ok(found);
            }
            self.warnings = known;
        }
        self.made_local(&found_at)
    }

    fn made_local(&mut self, mechanism: &Mechanism) -> Result<Local, StudyError> {
        let formulated = formulate_written(mechanism, &self.outputs);
        let mut formulated = formulated.map_err(|list| Faults::new(self.source.clone(), list))?;
        if let Some(slips) = formulated.equations.first_led().and_then(|index| mechanism.what_holds(index)) {
            return Err(AnalysisFailure::Other(format!(
                "{slips} acts on a driven motion: at rest its force is not determined, so there is no linear system; use `simulate` or `motion`"
            ))
            .into());
        }
        self.warnings.append(&mut formulated.warnings);
        Ok(Local::new(formulated))
    }

    /// Hands over the equations of the mechanism at rest with its equilibrium.
    pub(super) fn rest<T>(
        &mut self,
        then: impl FnOnce(&mut Formulated, &Variation, &Equilibrium) -> Result<T, AnalysisFailure>,
    ) -> Result<T, StudyError> {
        can_rest(&self.mechanism)?;
        let requested = self.requested.clone();
        self.formulated(true, |formulated, variation| {
            let equilibrium = Equilibrium::find(formulated, variation, &requested)?;
            then(formulated, variation, &equilibrium)
        })
    }
}

/// What is sampled goes on changing where everything else rests.
fn can_rest(mechanism: &Mechanism) -> Result<(), AnalysisFailure> {
    let Some(sampler) = mechanism.samplers.iter().find(|sampler| !sampler.writes.is_empty()) else { return Ok(()) };
    Err(AnalysisFailure::Other(format!(
        "the values of sampler `{}` never become constant, so there is no equilibrium: use `simulate`, or `--at` a time",
        sampler.name
    )))
}

/// The linear systems at these times of the motion.
fn along(
    formulated: &Formulated,
    variation: &Variation,
    (driven, requested): (DrivenInputs, &[RequestedMode]),
    times: &[f64],
) -> Result<Vec<StateSpace>, AnalysisFailure> {
    let mut motion = Followed::new(formulated, driven)?;
    let mut systems: Vec<StateSpace> = Vec::with_capacity(times.len());
    let end = times.last().copied().unwrap_or_default();
    for &time in times {
        let point = motion.point((formulated, variation), (time, end), requested)?;
        systems.push(StateSpace::new(formulated, variation, &point, systems.last())?);
    }
    Ok(systems)
}

fn vibration(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
    resting: bool,
) -> Result<VibrationModes, AnalysisFailure> {
    let system = StateSpace::new(formulated, variation, point, None)?;
    let sticking: Vec<&str> =
        system.statuses.iter().filter(|status| status.most().is_some()).map(|status| &*status.name).collect();
    if let Some(first) = sticking.first().filter(|_| system.states.is_empty()) {
        let sticking = match &sticking[..] {
            [one] => format!("`{one}` sticks"),
            all => format!("`{}` stick", all.join("`, `")),
        };
        return Err(AnalysisFailure::Other(format!(
            "no degree of freedom can vibrate: {sticking} in this mode; use a mode in which it slides at a time of the motion (`--at 0 --mode {first}=slides+`), or one without its friction (`--mode {first}=idle`)"
        )));
    }
    Ok(VibrationModes {
        name: formulated.equations.system.mechanism.name.clone(),
        time: point.time(),
        resting,
        coordinates: formulated.lowered.program.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect(),
        states: formulated.equations.states.len(),
        statuses: system.statuses.clone(),
        modes: modes(formulated, &system)?,
    })
}

/// The state of a mechanism at a time of its motion.
///
/// # Errors
/// The motion cannot be continued until then.
pub fn state_at(formulated: &Formulated, time: f64) -> Result<State, AnalysisFailure> {
    Followed::new(formulated, DrivenInputs::default())?.state(time, time)
}

/// A motion from its start on.
struct Followed {
    model: Arc<Model>,
    instance: Instance,
    driven: DrivenInputs,
}

impl Followed {
    /// Assembles the mechanism at the start of its experiment.
    fn new(formulated: &Formulated, driven: DrivenInputs) -> Result<Self, AnalysisFailure> {
        let program = formulated.lowered.program.clone();
        let experiment = program.experiment;
        let model = Arc::new(Model::new(program)?);
        let mut instance = Instance::new(Arc::clone(&model));
        instance.setup(experiment.start, None, Some(experiment.tolerance))?;
        driven.set(&mut instance, experiment.start, false)?;
        instance.initialise()?;
        Ok(Followed { model, instance, driven })
    }

    /// Moves on to a time, not before the last one, of a motion that ends then or later.
    fn state(&mut self, time: f64, end: f64) -> Result<State, AnalysisFailure> {
        for knot in self.driven.knots([self.instance.time(), time]) {
            self.instance.step_to(knot)?;
            self.driven.set(&mut self.instance, knot, knot == end)?;
        }
        if time > self.instance.time() {
            self.instance.step_to(time)?;
        }
        Ok(self.instance.state())
    }

    /// The point at a time, with parts held as they are asked to be.
    fn point(
        &mut self,
        equations: (&Formulated, &Variation),
        (time, end): (f64, f64),
        requested: &[RequestedMode],
    ) -> Result<OperatingPoint, AnalysisFailure> {
        let mut state = self.state(time, end)?;
        requested::put(equations, &self.model, &mut state, requested)
    }
}
