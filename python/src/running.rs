//! A run that is taken step by step.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cotree::diagnostic::suggest;
use cotree::model::{Experiment, Unit};
use cotree::run::Logged;
use cotree_fmu::instance::{Instance, InstanceError, Snapshot};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::listening::interruptible;
use crate::outcome::{LogRow, RunError, log_rows, warn, wrong};
use crate::request::{self, Times, Value};
use crate::scene::{Core, Ready};

/// A motion at a time, and the way on.
#[pyclass(frozen, module = "cotree._cotree")]
pub struct Running {
    ready: Arc<Ready>,
    /// What is reported.
    reported: Arc<[usize]>,
    places: Arc<HashMap<String, usize>>,
    motion: Mutex<Motion>,
}

/// Where a run is, and what has happened on the way there.
#[derive(Clone)]
struct Motion {
    instance: Box<Instance>,
    log: Vec<LogRow>,
}

impl Running {
    /// Begins where these settings let it begin; `experiment` says when and how accurately.
    pub fn start(
        py: Python<'_>,
        (ready, reported): (Arc<Ready>, Vec<usize>),
        experiment: Experiment,
        settings: &[(String, Value)],
    ) -> PyResult<Self> {
        let description = &ready.compiled.description;
        let settings = request::settings(description, settings)?;
        let places =
            description.variables.iter().enumerate().map(|(place, variable)| (variable.name.clone(), place)).collect();
        let model = Arc::clone(&ready.model);
        let begun = interruptible(py, move || {
            let mut instance = Instance::boxed(model);
            let log = begin(&mut instance, experiment, &settings)?;
            Ok(Motion { instance, log })
        })?;
        let motion = Mutex::new(begun.map_err(refused)?);
        Ok(Running { ready, reported: reported.into(), places: Arc::new(places), motion })
    }

    fn motion(&self) -> MutexGuard<'_, Motion> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn place(&self, name: &str) -> PyResult<usize> {
        self.places.get(name).copied().ok_or_else(|| {
            let known = suggest::known(
                name,
                self.ready.compiled.description.variables.iter().map(|variable| variable.name.as_str()),
            );
            PyKeyError::new_err(format!("the run has no variable `{name}`; {known}; `outputs` of `start` names others"))
        })
    }

    /// A value that is given, in SI units.
    fn value(&self, place: usize, name: &str, value: &Value) -> PyResult<f64> {
        let unit = &self.ready.compiled.description.variables[place].unit;
        value.read(unit).map_err(|message| wrong(format!("{name}: {message}")))
    }
}

#[pymethods]
impl Running {
    #[getter]
    fn time(&self) -> f64 {
        self.motion().instance.time()
    }

    /// The event that has ended the run.
    #[getter]
    fn ended(&self) -> Option<String> {
        self.motion().instance.ended().map(str::to_owned)
    }

    /// What has happened up to now.
    fn log(&self) -> Vec<LogRow> {
        self.motion().log.clone()
    }

    /// The names and units of the outputs.
    fn outputs(&self) -> Vec<(String, String)> {
        self.ready.columns(&self.reported)
    }

    /// The outputs now.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let instance = &mut self.motion().instance;
        let values: Result<Vec<f64>, _> = self.reported.iter().map(|&variable| instance.reading(variable)).collect();
        Ok(PyArray1::from_vec(py, values.map_err(refused)?))
    }

    fn get(&self, name: &str) -> PyResult<f64> {
        let place = self.place(name)?;
        self.motion().instance.reading(place).map_err(refused)
    }

    /// Sets inputs and tunable parameters: all of them, or none if one cannot be set.
    fn set(&self, values: Vec<(String, Value)>) -> PyResult<()> {
        if values.is_empty() {
            return Ok(());
        }
        let instance = &mut self.motion().instance;
        let mut checked = Vec::with_capacity(values.len());
        for (name, value) in &values {
            let place = self.place(name).map_err(|error| wrong(error.to_string()))?;
            let value = self.value(place, name, value)?;
            instance.check_set(place, value).map_err(refused)?;
            checked.push((place, value));
        }
        checked.into_iter().try_for_each(|(place, value)| instance.set(place, value)).map_err(refused)
    }

    /// Moves on by a duration, or to a time. Where that is more work than one step may take, or is interrupted, it stays where it has come to.
    fn step(&self, py: Python<'_>, duration: Value, absolute: bool) -> PyResult<()> {
        let given = duration.read(&Unit::time()).map_err(|message| wrong(format!("step: {message}")))?;
        let moved = interruptible(py, || {
            let Motion { instance, log } = &mut *self.motion();
            let from = instance.time();
            let target = if absolute { given } else { from + given };
            if !(target.is_finite() && target >= from) {
                return Err(wrong(format!("step: {target:?} s is not after the present time, {from:?} s")));
            }
            if target > from {
                let has_ended = instance.ended().is_some();
                let moved = instance.step_to(target);
                log.extend(log_rows(Logged::taken(instance)));
                match moved {
                    // A result like any other: `ended` names the event.
                    Err(InstanceError::Ended { .. }) if !has_ended => {}
                    moved => moved.map_err(refused)?,
                }
            }
            Ok(instance.take_inaccuracy())
        })?;
        moved?.map_or(Ok(()), |inaccuracy| warn(py, "", &inaccuracy))
    }

    /// The same run once more, from here on for itself.
    fn copy(&self) -> Self {
        Running {
            ready: Arc::clone(&self.ready),
            reported: Arc::clone(&self.reported),
            places: Arc::clone(&self.places),
            motion: Mutex::new(self.motion().clone()),
        }
    }

    /// All that the future depends on.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.motion().instance.save().to_bytes().map_err(refused)?))
    }

    fn restore(&self, state: Vec<u8>) -> PyResult<()> {
        let Motion { instance, log } = &mut *self.motion();
        let snapshot =
            Snapshot::from_bytes(instance.model(), &state).map_err(|error| wrong(format!("state: {error}")))?;
        instance.restore(&snapshot).map_err(refused)?;
        log.retain(|(time, ..)| *time <= instance.time());
        Ok(())
    }

    /// Takes what has happened from a run that has come here.
    fn remember(&self, log: Vec<(f64, String, String, Option<f64>)>) {
        let row = |(time, name, what, impulse)| (time, name, Cow::Owned(what), impulse);
        self.motion().log = log.into_iter().map(row).collect();
    }

    /// Begins again with these settings. False if they need another program, so that a new run is to be begun. Where there is no start with them the run stays where it is.
    fn restart(
        &self,
        py: Python<'_>,
        core: &Bound<'_, Core>,
        times: Times,
        settings: Vec<(String, Value)>,
    ) -> PyResult<bool> {
        let Some((experiment, settings)) = core.get().restarted(&self.ready, &times, &settings)? else {
            return Ok(false);
        };
        let begun = interruptible(py, || {
            let Motion { instance, log } = &mut *self.motion();
            let before = instance.save();
            instance.reset();
            match begin(instance, experiment, &settings) {
                Ok(rows) => {
                    *log = rows;
                    Ok(())
                }
                Err(error) => {
                    instance.restore(&before)?;
                    Err(error)
                }
            }
        })?;
        begun.map_err(refused)?;
        Ok(true)
    }

    /// How variables change now along a direction of inputs, parameters and states.
    fn directional(&self, of: Vec<String>, along: Vec<(String, f64)>) -> PyResult<Vec<f64>> {
        let instance = &mut self.motion().instance;
        instance.begin_direction();
        for (name, change) in &along {
            instance.add_direction(self.place(name)?, *change).map_err(|error| wrong(error.to_string()))?;
        }
        instance.differentiate().map_err(refused)?;
        of.iter().map(|name| instance.derivative(self.place(name)?).map_err(|error| wrong(error.to_string()))).collect()
    }
}

/// Begins a motion in an instance that has none; what has happened at its start.
fn begin(
    instance: &mut Instance,
    experiment: Experiment,
    settings: &[(usize, f64)],
) -> Result<Vec<LogRow>, InstanceError> {
    instance.setup(experiment.start, None, Some(experiment.tolerance))?;
    settings.iter().try_for_each(|&(variable, value)| instance.set(variable, value))?;
    instance.record_instants();
    instance.initialise()?;
    Ok(log_rows(Logged::taken(instance)))
}

/// What is given is at fault, or the motion.
fn refused(error: InstanceError) -> PyErr {
    match error {
        InstanceError::OutOfRange { .. }
        | InstanceError::NotANumber { .. }
        | InstanceError::Fixed { .. }
        | InstanceError::Calculated { .. }
        | InstanceError::UnknownVariable { .. } => wrong(error.to_string()),
        other => RunError::new_err(other.to_string()),
    }
}
