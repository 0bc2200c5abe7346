//! An unpacked FMU of FMI 3.0 as an importer sees it: its description, and its library through the C interface alone.

use std::ffi::CStr;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use cotree_fmu::fmi3::types::fmi3Status::{self, fmi3OK};
use cotree_fmu::fmi3::types::*;

pub use super::fmu_description::{Description, Variable};
use super::xml::{Tag, attribute, tags};

/// An unpacked FMU.
pub struct Fmu {
    pub about: Description,
    pub token: String,
    pub library: Library,
}

impl Deref for Fmu {
    type Target = Description;

    fn deref(&self) -> &Description {
        &self.about
    }
}

impl Fmu {
    pub fn open(folder: &Path) -> Self {
        let about = Description::read(folder);
        Self {
            token: about.head("instantiationToken").to_owned(),
            library: Library::load(&about.library_path()),
            about,
        }
    }

    pub fn resources(&self) -> String {
        format!("{}/resources/", self.folder.display())
    }

    /// The file that it was unpacked from.
    pub fn archive(&self) -> PathBuf {
        let mut name = self.folder.clone().into_os_string();
        name.push(".fmu");
        name.into()
    }

    /// The tags of `terminalsAndIcons.xml`, if there is one.
    pub fn terminals(&self) -> Vec<Tag> {
        std::fs::read(self.folder.join("terminalsAndIcons/terminalsAndIcons.xml")).map_or(vec![], |file| tags(&file))
    }

    /// The value references of a list in the model structure.
    pub fn structure(&self, element: &str) -> Vec<u32> {
        let tags = self.below(&format!("ModelStructure/{element}"));
        tags.iter().map(|tag| attribute(tag, "valueReference").expect("required").parse().expect("a number")).collect()
    }

    /// What an unknown of the model structure depends on; everything if nothing is said.
    pub fn dependencies(&self, element: &str, reference: u32) -> Option<Vec<u32>> {
        let tags = self.below(&format!("ModelStructure/{element}"));
        let tag = tags.into_iter().find(|tag| attribute(tag, "valueReference") == Some(&reference.to_string()))?;
        let list = attribute(tag, "dependencies")?;
        Some(list.split_whitespace().map(|text| text.parse().expect("a number")).collect())
    }

    pub fn make(&self, how: &Making) -> Option<Instance<'_>> {
        let messages = Box::<Messages>::default();
        let environment = std::ptr::from_ref(&*messages).cast_mut().cast();
        let token = how.token.clone().unwrap_or_else(|| self.token.clone());
        let resources = how.resources.clone().unwrap_or_else(|| self.resources());
        let mut texts = ["it's 100% # mine".to_owned(), token, resources].map(|text| text.into_bytes());
        texts.iter_mut().for_each(|text| text.push(0));
        let [name, token, resources] = texts.each_ref().map(|text| text.as_ptr().cast());
        let logger: fmi3LogMessageCallback = if how.logging.is_some() { Some(record) } else { None };
        let logging = how.logging.unwrap_or(false).into();
        // SAFETY: all pointers are valid during the call.
        let c = unsafe {
            match how.exchange {
                true => (self.library.instantiate_exchange)(name, token, resources, 0, logging, environment, logger),
                false => (self.library.instantiate_cosimulation)(
                    name,
                    token,
                    resources,
                    0,
                    logging,
                    how.events.into(),
                    how.early_return.into(),
                    how.intermediate.as_ptr(),
                    how.intermediate.len(),
                    environment,
                    logger,
                    how.update,
                ),
            }
        };
        // The importer may use the places of its strings for something else now (3D11).
        texts.iter_mut().for_each(|text| text.fill(b'?'));
        std::hint::black_box(&texts);
        (!c.is_null()).then_some(Instance { fmu: self, c, messages })
    }

    pub fn made(&self) -> Instance<'_> {
        self.make(&Making::default()).expect("instantiates")
    }

    pub fn started(&self) -> Instance<'_> {
        let instance = self.made();
        instance.start();
        instance
    }

    /// For Model Exchange, in event mode; nothing if that is not offered.
    pub fn exchanged(&self) -> Option<Instance<'_>> {
        if self.below("fmiModelDescription/ModelExchange").is_empty() {
            println!("{}it has no Model Exchange", super::NOTHING);
            return None;
        }
        let instance = self.make(&Making { exchange: true, logging: Some(true), ..Making::default() })?;
        instance.start();
        Some(instance)
    }
}

/// How an instance is made.
#[derive(Default)]
pub struct Making {
    pub exchange: bool,
    /// No logger, a logger that is off, a logger.
    pub logging: Option<bool>,
    pub token: Option<String>,
    pub resources: Option<String>,
    pub events: bool,
    pub early_return: bool,
    pub intermediate: Vec<u32>,
    pub update: fmi3IntermediateUpdateCallback,
}

/// Messages received, and what intermediate updates have seen.
#[derive(Default)]
pub struct Messages {
    pub log: Mutex<Vec<(fmi3Status, String, String)>>,
    pub updates: Mutex<Vec<Update>>,
}

/// An intermediate update.
#[derive(Clone, Copy, Debug)]
pub struct Update {
    pub time: f64,
    pub can_return: bool,
}

unsafe extern "C" fn record(
    environment: fmi3InstanceEnvironment,
    status: fmi3Status,
    category: fmi3String,
    message: fmi3String,
) {
    // SAFETY: the environment is the `Messages` of an instance, which outlives it.
    let messages = unsafe { &*environment.cast::<Messages>() };
    // SAFETY: the FMU passes strings that end with zero.
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned();
    messages.log.lock().expect("not poisoned").push((status, text(category), text(message)));
}

/// Notes every intermediate update, and never ends a step.
pub unsafe extern "C" fn watch(
    environment: fmi3InstanceEnvironment,
    time: f64,
    _set_requested: fmi3Boolean,
    _get_allowed: fmi3Boolean,
    _finished: fmi3Boolean,
    can_return: fmi3Boolean,
    _requested: *mut fmi3Boolean,
    _until: *mut f64,
) {
    // SAFETY: as in `record`.
    let messages = unsafe { &*environment.cast::<Messages>() };
    messages.updates.lock().expect("not poisoned").push(Update { time, can_return: can_return != fmi3False });
}

/// Ends every step where it can.
pub unsafe extern "C" fn interrupt(
    environment: fmi3InstanceEnvironment,
    time: f64,
    set_requested: fmi3Boolean,
    get_allowed: fmi3Boolean,
    finished: fmi3Boolean,
    can_return: fmi3Boolean,
    requested: *mut fmi3Boolean,
    until: *mut f64,
) {
    // SAFETY: the places are valid during the call.
    unsafe {
        watch(environment, time, set_requested, get_allowed, finished, can_return, requested, until);
        (*requested, *until) = (fmi3True, time);
    }
}

type C = fmi3Instance;
type S = fmi3Status;
type V = *const fmi3ValueReference;
type B = *mut fmi3Boolean;
type Log = fmi3LogMessageCallback;
type Text = fmi3String;

crate::library! {
    version = "fmi3GetVersion"() -> Text;
    set_debug_logging = "fmi3SetDebugLogging"(C, fmi3Boolean, usize, *const Text) -> S;
    instantiate_exchange = "fmi3InstantiateModelExchange"(Text, Text, Text, fmi3Boolean, fmi3Boolean, C, Log) -> C;
    instantiate_cosimulation = "fmi3InstantiateCoSimulation"(
        Text, Text, Text, fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean, V, usize, C, Log, fmi3IntermediateUpdateCallback
    ) -> C;
    instantiate_scheduled = "fmi3InstantiateScheduledExecution"(
        Text, Text, Text, fmi3Boolean, fmi3Boolean, C, Log, fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
        fmi3UnlockPreemptionCallback
    ) -> C;
    free = "fmi3FreeInstance"(C);
    enter_initialization = "fmi3EnterInitializationMode"(C, fmi3Boolean, f64, f64, fmi3Boolean, f64) -> S;
    exit_initialization = "fmi3ExitInitializationMode"(C) -> S;
    enter_event = "fmi3EnterEventMode"(C) -> S;
    terminate = "fmi3Terminate"(C) -> S;
    reset = "fmi3Reset"(C) -> S;
    get = "fmi3GetFloat64"(C, V, usize, *mut f64, usize) -> S;
    set = "fmi3SetFloat64"(C, V, usize, *const f64, usize) -> S;
    get_int32 = "fmi3GetInt32"(C, V, usize, *mut i32, usize) -> S;
    get_boolean = "fmi3GetBoolean"(C, V, usize, B, usize) -> S;
    get_string = "fmi3GetString"(C, V, usize, *mut Text, usize) -> S;
    set_int64 = "fmi3SetInt64"(C, V, usize, *const i64, usize) -> S;
    get_clock = "fmi3GetClock"(C, V, usize, B) -> S;
    get_state = "fmi3GetFMUState"(C, *mut fmi3FMUState) -> S;
    set_state = "fmi3SetFMUState"(C, fmi3FMUState) -> S;
    free_state = "fmi3FreeFMUState"(C, *mut fmi3FMUState) -> S;
    state_size = "fmi3SerializedFMUStateSize"(C, fmi3FMUState, *mut usize) -> S;
    serialize = "fmi3SerializeFMUState"(C, fmi3FMUState, *mut u8, usize) -> S;
    deserialize = "fmi3DeserializeFMUState"(C, *const u8, usize, *mut fmi3FMUState) -> S;
    directional = "fmi3GetDirectionalDerivative"(C, V, usize, V, usize, *const f64, usize, *mut f64, usize) -> S;
    adjoint = "fmi3GetAdjointDerivative"(C, V, usize, V, usize, *const f64, usize, *mut f64, usize) -> S;
    output_derivatives = "fmi3GetOutputDerivatives"(C, V, usize, *const i32, *mut f64, usize) -> S;
    enter_configuration = "fmi3EnterConfigurationMode"(C) -> S;
    evaluate = "fmi3EvaluateDiscreteStates"(C) -> S;
    dependency_count = "fmi3GetNumberOfVariableDependencies"(C, u32, *mut usize) -> S;
    dependencies = "fmi3GetVariableDependencies"(C, u32, *mut usize, V, *mut usize, *mut fmi3DependencyKind, usize) -> S;
    activate = "fmi3ActivateModelPartition"(C, u32, f64) -> S;
    update = "fmi3UpdateDiscreteStates"(C, B, B, B, B, B, *mut f64) -> S;
    enter_step = "fmi3EnterStepMode"(C) -> S;
    do_step = "fmi3DoStep"(C, f64, f64, fmi3Boolean, B, B, B, *mut f64) -> S;
    enter_continuous = "fmi3EnterContinuousTimeMode"(C) -> S;
    completed = "fmi3CompletedIntegratorStep"(C, fmi3Boolean, B, B) -> S;
    set_time = "fmi3SetTime"(C, f64) -> S;
    set_states = "fmi3SetContinuousStates"(C, *const f64, usize) -> S;
    get_states = "fmi3GetContinuousStates"(C, *mut f64, usize) -> S;
    get_derivatives = "fmi3GetContinuousStateDerivatives"(C, *mut f64, usize) -> S;
    get_indicators = "fmi3GetEventIndicators"(C, *mut f64, usize) -> S;
    get_nominals = "fmi3GetNominalsOfContinuousStates"(C, *mut f64, usize) -> S;
    state_count = "fmi3GetNumberOfContinuousStates"(C, *mut usize) -> S;
    indicator_count = "fmi3GetNumberOfEventIndicators"(C, *mut usize) -> S;
}

/// An instance.
pub struct Instance<'a> {
    pub fmu: &'a Fmu,
    pub c: fmi3Instance,
    pub messages: Box<Messages>,
}

// SAFETY: the interface allows an instance to be used by one thread at a time, whichever that is.
unsafe impl Send for Instance<'_> {}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: it was made here and is not used again.
        unsafe { (self.fmu.library.free)(self.c) }
    }
}

/// What a step came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    pub status: fmi3Status,
    pub event: bool,
    pub early: bool,
    pub time: f64,
}

// SAFETY of all calls: the instance is alive, and arrays are as long as announced.
impl Instance<'_> {
    pub fn fmi(&self) -> &Library {
        &self.fmu.library
    }

    pub fn log(&self) -> Vec<(fmi3Status, String, String)> {
        std::mem::take(&mut self.messages.log.lock().expect("not poisoned"))
    }

    pub fn updates(&self) -> Vec<Update> {
        std::mem::take(&mut self.messages.updates.lock().expect("not poisoned"))
    }

    pub fn enter_from(&self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> S {
        let (has_stop, has_tolerance) = (stop.is_some().into(), tolerance.is_some().into());
        let (stop, tolerance) = (stop.unwrap_or_default(), tolerance.unwrap_or_default());
        unsafe { (self.fmi().enter_initialization)(self.c, has_tolerance, tolerance, start, has_stop, stop) }
    }

    pub fn enter(&self) -> S {
        self.enter_from(0.0, None, None)
    }

    /// A call without arguments.
    pub fn call(&self, function: unsafe extern "C" fn(C) -> S) -> S {
        unsafe { function(self.c) }
    }

    pub fn exit(&self) -> S {
        self.call(self.fmi().exit_initialization)
    }

    pub fn start(&self) {
        assert_eq!([self.enter(), self.exit()], [fmi3OK; 2], "{:?}", self.log());
    }

    pub fn terminate(&self) -> S {
        self.call(self.fmi().terminate)
    }

    pub fn reset(&self) -> S {
        self.call(self.fmi().reset)
    }

    pub fn step(&self, t: f64, h: f64) -> Step {
        let (mut event, mut terminate, mut early, mut time) = (9, 9, 9, f64::NAN);
        let status =
            unsafe { (self.fmi().do_step)(self.c, t, h, 1, &mut event, &mut terminate, &mut early, &mut time) };
        assert!([event, terminate, early].iter().all(|flag| *flag <= 1) && terminate == 0);
        Step { status, event: event == 1, early: early == 1, time }
    }

    pub fn get(&self, reference: u32) -> Result<f64, S> {
        let mut value = f64::NAN;
        match unsafe { (self.fmi().get)(self.c, &reference, 1, &mut value, 1) } {
            fmi3OK => Ok(value),
            status => Err(status),
        }
    }

    pub fn put(&self, reference: u32, value: f64) -> S {
        unsafe { (self.fmi().set)(self.c, &reference, 1, &value, 1) }
    }

    pub fn read(&self, references: &[u32]) -> Vec<f64> {
        let (count, mut values) = (references.len(), vec![f64::NAN; references.len()]);
        let status = unsafe { (self.fmi().get)(self.c, references.as_ptr(), count, values.as_mut_ptr(), count) };
        assert_eq!(status, fmi3OK, "{:?}", self.log());
        values
    }

    /// All variables, bit by bit.
    pub fn all(&self) -> Vec<u64> {
        self.read(&self.fmu.references(|_| true)).into_iter().map(f64::to_bits).collect()
    }

    /// Steps of 10 ms from step number `from` on, with an input that changes now and then; all variables after each.
    pub fn run(&self, steps: std::ops::Range<u32>) -> Vec<Vec<u64>> {
        let step = |step: u32| {
            if step.is_multiple_of(5) {
                for input in self.fmu.inputs() {
                    assert_eq!(self.put(input, 0.1 * f64::from(step % 7)), fmi3OK);
                }
            }
            self.go(f64::from(step) * 0.01, 0.01);
            self.all()
        };
        steps.map(step).collect()
    }

    /// A step with as many returns in between as the FMU likes.
    pub fn go(&self, t: f64, h: f64) {
        let mut now = t;
        loop {
            let step = self.step(now, t + h - now);
            assert_eq!(step.status, fmi3OK, "{:?}", self.log());
            if !step.early {
                return;
            }
            assert!(step.time < t + h && step.time >= now);
            now = step.time;
        }
    }

    pub fn save(&self) -> fmi3FMUState {
        let mut state = null_mut();
        assert_eq!(unsafe { (self.fmi().get_state)(self.c, &mut state) }, fmi3OK);
        state
    }

    pub fn restore(&self, state: fmi3FMUState) -> S {
        unsafe { (self.fmi().set_state)(self.c, state) }
    }

    pub fn free_state(&self, mut state: fmi3FMUState) {
        assert_eq!(unsafe { (self.fmi().free_state)(self.c, &mut state) }, fmi3OK);
        assert!(state.is_null());
    }

    pub fn bytes(&self, state: fmi3FMUState) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(unsafe { (self.fmi().state_size)(self.c, state, &mut size) }, fmi3OK);
        let mut bytes = vec![0; size];
        assert_eq!(unsafe { (self.fmi().serialize)(self.c, state, bytes.as_mut_ptr(), size) }, fmi3OK);
        bytes
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Result<fmi3FMUState, S> {
        let mut state = null_mut();
        match unsafe { (self.fmi().deserialize)(self.c, bytes.as_ptr(), bytes.len(), &mut state) } {
            fmi3OK => Ok(state),
            status => Err(status),
        }
    }

    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, S> {
        let mut found = vec![f64::NAN; unknowns.len()];
        let (nu, nk) = (unknowns.len(), knowns.len());
        let status = unsafe {
            let (seed, ns) = (seed.as_ptr(), seed.len());
            (self.fmi().directional)(
                self.c,
                unknowns.as_ptr(),
                nu,
                knowns.as_ptr(),
                nk,
                seed,
                ns,
                found.as_mut_ptr(),
                nu,
            )
        };
        if status == fmi3OK { Ok(found) } else { Err(status) }
    }

    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, S> {
        let mut found = vec![f64::NAN; knowns.len()];
        let (nu, nk) = (unknowns.len(), knowns.len());
        let status = unsafe {
            let (seed, ns) = (seed.as_ptr(), seed.len());
            (self.fmi().adjoint)(self.c, unknowns.as_ptr(), nu, knowns.as_ptr(), nk, seed, ns, found.as_mut_ptr(), nk)
        };
        if status == fmi3OK { Ok(found) } else { Err(status) }
    }

    /// Whether event mode needs another turn, whether states have moved.
    pub fn update(&self) -> Result<(bool, bool), S> {
        let (mut again, mut end, mut nominals, mut values, mut defined, mut time) = (9, 9, 9, 9, 9, 0.0);
        let status = unsafe {
            (self.fmi().update)(self.c, &mut again, &mut end, &mut nominals, &mut values, &mut defined, &mut time)
        };
        if status == fmi3OK { Ok((again == 1, values == 1)) } else { Err(status) }
    }

    pub fn count(&self, function: unsafe extern "C" fn(C, *mut usize) -> S) -> usize {
        let mut count = usize::MAX;
        assert_eq!(unsafe { function(self.c, &mut count) }, fmi3OK);
        count
    }

    /// A vector of the whole state space.
    pub fn vector(&self, function: unsafe extern "C" fn(C, *mut f64, usize) -> S) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.count(self.fmi().state_count)];
        assert_eq!(unsafe { function(self.c, values.as_mut_ptr(), values.len()) }, fmi3OK, "{:?}", self.log());
        values
    }

    pub fn set_states(&self, states: &[f64]) -> S {
        unsafe { (self.fmi().set_states)(self.c, states.as_ptr(), states.len()) }
    }

    pub fn set_time(&self, time: f64) -> S {
        unsafe { (self.fmi().set_time)(self.c, time) }
    }

    /// Whether an event is due after a step of the importer's integrator.
    pub fn completed(&self) -> Result<bool, S> {
        let (mut enter, mut end) = (9, 9);
        let status = unsafe { (self.fmi().completed)(self.c, 1, &mut enter, &mut end) };
        if status == fmi3OK { Ok(enter == 1) } else { Err(status) }
    }

    /// From event mode to continuous-time mode.
    pub fn settle(&self) {
        assert_eq!(self.update().map(|(again, _)| again), Ok(false), "{:?}", self.log());
        assert_eq!(self.call(self.fmi().enter_continuous), fmi3OK);
    }

    pub fn category(&self, names: &[&CStr], on: bool) -> S {
        let pointers: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
        let first = if pointers.is_empty() { null() } else { pointers.as_ptr() };
        unsafe { (self.fmi().set_debug_logging)(self.c, on.into(), pointers.len(), first) }
    }
}
