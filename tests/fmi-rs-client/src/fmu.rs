//! An unpacked FMU and its instances, as fmi-rs sees them.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};
use fmi_rs::fmi2::types::{fmi2FMUstate, fmi2Status, fmi2StatusKind, fmi2True};
use fmi_rs::fmi2::{CS, FMU2, ME};
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, ScalarVariable, Variability, VariableType};
use fmi_rs::sim::SimulationError;

pub const NAME: &str = "it's 100% # mine";

/// What its description says.
pub struct Fmu {
    pub folder: PathBuf,
    pub description: ModelDescription,
}

impl Fmu {
    pub fn open(folder: &Path) -> Self {
        let description = ModelDescription::from_path(&folder.join("modelDescription.xml")).expect("a description");
        Self { folder: folder.to_owned(), description }
    }

    pub fn identifier(&self) -> &str {
        &self.description.coSimulation.as_ref().expect("Co-Simulation").modelIdentifier
    }

    pub fn references(&self, wanted: impl Fn(&ScalarVariable) -> bool) -> Vec<u32> {
        let variables = self.description.modelVariables.iter().filter(|variable| wanted(variable));
        variables.map(|variable| variable.valueReference).collect()
    }

    pub fn inputs(&self) -> Vec<u32> {
        self.references(|variable| variable.causality == Causality::Input)
    }

    pub fn outputs(&self) -> Vec<u32> {
        self.references(|variable| variable.causality == Causality::Output)
    }

    pub fn tunable(&self) -> Vec<u32> {
        self.references(|variable| variable.variability == Variability::Tunable)
    }

    pub fn fixed(&self) -> Vec<u32> {
        self.references(|one| one.causality == Causality::Parameter && one.variability == Variability::Fixed)
    }

    pub fn variable(&self, reference: u32) -> &ScalarVariable {
        let mut variables = self.description.modelVariables.iter();
        variables.find(|variable| variable.valueReference == reference).expect("known")
    }

    pub fn default(&self, reference: u32) -> f64 {
        start(self.variable(reference)).expect("has a start value")
    }

    /// Another permitted value than the default: small, so that loops still close.
    pub fn other(&self, reference: u32) -> f64 {
        let start = self.default(reference);
        if start == 0.0 { 0.5 } else { start * 1.01 }
    }

    pub fn slave(&self) -> Instance<'_, CS> {
        self.make(&Arguments::default()).expect("instantiates")
    }

    pub fn started(&self) -> Instance<'_, CS> {
        let slave = self.slave();
        slave.start();
        slave
    }

    /// An instance for Co-Simulation.
    pub fn make(&self, with: &Arguments) -> Result<Instance<'_, CS>, SimulationError> {
        self.instantiate(with, FMU2::<CS>::new)
    }

    /// An instance for Model Exchange.
    pub fn exchange(&self) -> Result<Instance<'_, ME>, SimulationError> {
        self.instantiate(&Arguments::default(), FMU2::<ME>::new)
    }

    fn instantiate<T>(&self, with: &Arguments, make: Make<T>) -> Result<Instance<'_, T>, SimulationError> {
        let log = Arc::new(Log::default());
        let folder = with.folder.as_deref().unwrap_or(&self.folder);
        let guid = with.guid.unwrap_or(&self.description.guid);
        let raw =
            make(folder, self.identifier(), with.name, guid, false, with.logging, false, log.clone(), with.memory)?;
        Ok(Instance { fmu: self, raw, log })
    }
}

type Make<T> =
    fn(&Path, &str, &str, &str, bool, bool, bool, Arc<dyn Logger>, bool) -> Result<Arc<FMU2<T>>, SimulationError>;

/// What an FMU is instantiated with.
pub struct Arguments {
    pub name: &'static str,
    pub guid: Option<&'static str>,
    pub folder: Option<PathBuf>,
    pub logging: bool,
    /// Are the functions for memory passed?
    pub memory: bool,
}

impl Default for Arguments {
    fn default() -> Self {
        Self { name: NAME, guid: None, folder: None, logging: false, memory: true }
    }
}

/// Messages received: status, category, message. The interface of fmi-rs leaves the instance's name out.
#[derive(Default)]
pub struct Log {
    pub messages: Mutex<Vec<(fmi2Status, String, String)>>,
}

impl Logger for Log {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, status: fmi2Status, category: &str, message: &str) {
        self.messages.lock().expect("not poisoned").push((status, category.to_owned(), message.to_owned()));
    }
}

pub fn start(variable: &ScalarVariable) -> Option<f64> {
    variable.variableType.start().as_ref().map(|text| text.parse().expect("a number"))
}

/// The limits of a variable.
pub fn limits(variable: &ScalarVariable) -> [Option<f64>; 2] {
    let VariableType::Real { min, max, .. } = &variable.variableType else { return [None; 2] };
    [min, max].map(|limit| limit.as_ref().map(|text| text.parse().expect("a number")))
}

/// An instance.
pub struct Instance<'a, T> {
    pub fmu: &'a Fmu,
    pub raw: Arc<FMU2<T>>,
    pub log: Arc<Log>,
}

impl<T> Instance<'_, T> {
    pub fn messages(&self) -> Vec<(fmi2Status, String, String)> {
        std::mem::take(&mut self.log.messages.lock().expect("not poisoned"))
    }

    pub fn setup(&self) -> fmi2Status {
        self.raw.setupExperiment(None, 0.0, None)
    }

    pub fn start(&self) {
        self.start_with(None, 0.0, None);
    }

    pub fn start_with(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) {
        assert_eq!(self.raw.setupExperiment(tolerance, start, stop), OK);
        assert_eq!([self.raw.enterInitializationMode(), self.raw.exitInitializationMode()], [OK; 2]);
    }

    pub fn get(&self, reference: u32) -> Result<f64, fmi2Status> {
        let mut value = [f64::NAN];
        match self.raw.getReal(&[reference], &mut value) {
            OK => Ok(value[0]),
            status => Err(status),
        }
    }

    pub fn put(&self, reference: u32, value: f64) -> fmi2Status {
        self.raw.setReal(&[reference], &[value])
    }

    pub fn read(&self, references: &[u32]) -> Vec<f64> {
        let mut values = vec![f64::NAN; references.len()];
        assert_eq!(self.raw.getReal(references, &mut values), OK, "{:?}", self.messages());
        values
    }

    /// All variables, bit by bit.
    pub fn all(&self) -> Vec<u64> {
        self.read(&self.fmu.references(|_| true)).into_iter().map(f64::to_bits).collect()
    }

    pub fn save(&self) -> fmi2FMUstate {
        let mut state = std::ptr::null_mut();
        assert_eq!(self.raw.getFMUstate(&mut state), OK);
        state
    }

    pub fn free(&self, mut state: fmi2FMUstate) {
        assert_eq!(self.raw.freeFMUstate(&mut state), OK);
        assert!(state.is_null());
    }

    pub fn bytes(&self, state: fmi2FMUstate) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(self.raw.serializedFMUstateSize(state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(self.raw.serializeFMUstate(state, &mut bytes), OK);
        bytes
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Result<fmi2FMUstate, fmi2Status> {
        let mut state = std::ptr::null_mut();
        match self.raw.deSerializeFMUstate(bytes, &mut state) {
            OK => Ok(state),
            status => Err(status),
        }
    }

    /// Derivatives of the unknowns by one known.
    pub fn derivatives(&self, unknowns: &[u32], known: u32) -> Vec<f64> {
        let mut values = vec![f64::NAN; unknowns.len()];
        let status = self.raw.getDirectionalDerivative(unknowns, &[known], &[1.0], &mut values);
        assert_eq!(status, OK, "{:?}", self.messages());
        values
    }

    /// Get and set of other types are refused. Not of strings: fmi-rs reads the pointers that a refused call leaves null.
    pub fn refuses_other_types(&self, reference: u32) {
        let (raw, mut value) = (&self.raw, [0]);
        let found = [
            raw.getInteger(&[reference], &mut value),
            raw.getBoolean(&[reference], &mut value),
            raw.setInteger(&[reference], &value),
            raw.setBoolean(&[reference], &value),
            raw.setString(&[reference], &["text"]),
        ];
        assert_eq!(found, [Error; 5]);
    }
}

impl Instance<'_, CS> {
    pub fn step(&self, time: f64, step: f64) -> fmi2Status {
        self.raw.doStep(time, step, fmi2True)
    }

    /// Steps of 10 ms from step number `from` on, with an input that changes now and then; all variables after each.
    pub fn run(&self, steps: std::ops::Range<u32>) -> Vec<Vec<u64>> {
        steps
            .map(|step| {
                if step % 5 == 0 {
                    for input in self.fmu.inputs() {
                        assert_eq!(self.put(input, 0.1 * f64::from(step % 7)), OK);
                    }
                }
                assert_eq!(self.step(f64::from(step) * 0.01, 0.01), OK, "{:?}", self.messages());
                self.all()
            })
            .collect()
    }

    pub fn last_time(&self) -> f64 {
        let mut time = f64::NAN;
        assert_eq!(self.raw.getRealStatus(&fmi2StatusKind::LastSuccessfulTime, &mut time), OK);
        time
    }
}

/// Central differences of fourth order.
pub fn difference(values_at: impl Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| values_at(k * h));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h)).collect()
}

pub fn agree(fmu: &Fmu, unknowns: &[u32], exact: &[f64], found: &[f64], limit: f64) {
    for ((&unknown, exact), found) in unknowns.iter().zip(exact).zip(found) {
        let name = &fmu.variable(unknown).name;
        assert!((exact - found).abs() <= limit * exact.abs().max(1.0), "{name}: {exact}, not {found}");
    }
}
