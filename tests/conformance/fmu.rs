//! An unpacked FMU as an importer sees it: its description, and its library through the C interface alone.

use std::ffi::{CStr, CString, c_void};
use std::ops::Deref;
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use cotree_fmu::fmi2::types::fmi2Status::{self, fmi2OK};
use cotree_fmu::fmi2::types::*;

pub use super::fmu_description::{Description, Variable};
pub use super::xml::attribute;

/// An unpacked FMU.
pub struct Fmu {
    pub about: Description,
    pub guid: String,
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
        Self { guid: about.head("guid").to_owned(), library: Library::load(&about.library_path()), about }
    }

    pub fn resources(&self) -> String {
        format!("file://{}/resources", self.folder.display())
    }

    pub fn instantiate(&self, kind: fmi2Type, location: &str, logging: bool) -> Option<Slave<'_>> {
        let messages = Box::<Messages>::default();
        let callbacks = callbacks(&messages);
        let [name, guid, location] =
            ["it's 100% # mine", &self.guid, location].map(|text| CString::new(text).expect("no zero"));
        // SAFETY: all pointers are valid during the call.
        let c = unsafe {
            (self.library.instantiate)(
                name.as_ptr(),
                kind,
                guid.as_ptr(),
                location.as_ptr(),
                &callbacks,
                fmi2False,
                logging.into(),
            )
        };
        (!c.is_null()).then_some(Slave { fmu: self, c, messages })
    }

    pub fn slave(&self) -> Slave<'_> {
        self.instantiate(fmi2CoSimulation, &self.resources(), false).expect("instantiates")
    }

    pub fn started(&self) -> Slave<'_> {
        let slave = self.slave();
        slave.start();
        slave
    }
}

/// Messages received: instance, status, category, message.
pub type Messages = Mutex<Vec<(String, fmi2Status, String, String)>>;

unsafe extern "C" fn record(
    environment: fmi2ComponentEnvironment,
    instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is the `Messages` of a slave, which outlives its component.
    let messages = unsafe { &*environment.cast::<Messages>() };
    // SAFETY: the FMU passes strings that end with zero.
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned();
    messages.lock().expect("not poisoned").push((text(instance), status, text(category), text(message)));
}

pub fn callbacks(messages: &Messages) -> fmi2CallbackFunctions {
    // SAFETY: the FMU passes no argument beyond the named ones; the calling convention is then the same on this platform.
    let logger = unsafe {
        std::mem::transmute::<
            unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String),
            unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String, ...),
        >(record)
    };
    fmi2CallbackFunctions {
        logger: Some(logger),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::from_ref(messages).cast_mut().cast(),
    }
}

type C = fmi2Component;
type S = fmi2Status;
type References = *const fmi2ValueReference;

crate::library! {
    types_platform = "fmi2GetTypesPlatform"() -> fmi2String;
    version = "fmi2GetVersion"() -> fmi2String;
    set_debug_logging = "fmi2SetDebugLogging"(C, fmi2Boolean, usize, *const fmi2String) -> S;
    instantiate = "fmi2Instantiate"(fmi2String, fmi2Type, fmi2String, fmi2String, *const fmi2CallbackFunctions, fmi2Boolean, fmi2Boolean) -> C;
    free_instance = "fmi2FreeInstance"(C);
    setup_experiment = "fmi2SetupExperiment"(C, fmi2Boolean, f64, f64, fmi2Boolean, f64) -> S;
    enter_initialization = "fmi2EnterInitializationMode"(C) -> S;
    exit_initialization = "fmi2ExitInitializationMode"(C) -> S;
    terminate = "fmi2Terminate"(C) -> S;
    reset = "fmi2Reset"(C) -> S;
    get_real = "fmi2GetReal"(C, References, usize, *mut f64) -> S;
    get_integer = "fmi2GetInteger"(C, References, usize, *mut fmi2Integer) -> S;
    get_boolean = "fmi2GetBoolean"(C, References, usize, *mut fmi2Boolean) -> S;
    get_string = "fmi2GetString"(C, References, usize, *mut fmi2String) -> S;
    set_real = "fmi2SetReal"(C, References, usize, *const f64) -> S;
    set_integer = "fmi2SetInteger"(C, References, usize, *const fmi2Integer) -> S;
    set_boolean = "fmi2SetBoolean"(C, References, usize, *const fmi2Boolean) -> S;
    set_string = "fmi2SetString"(C, References, usize, *const fmi2String) -> S;
    get_state = "fmi2GetFMUstate"(C, *mut fmi2FMUstate) -> S;
    set_state = "fmi2SetFMUstate"(C, fmi2FMUstate) -> S;
    free_state = "fmi2FreeFMUstate"(C, *mut fmi2FMUstate) -> S;
    serialized_size = "fmi2SerializedFMUstateSize"(C, fmi2FMUstate, *mut usize) -> S;
    serialize = "fmi2SerializeFMUstate"(C, fmi2FMUstate, *mut fmi2Byte, usize) -> S;
    deserialize = "fmi2DeSerializeFMUstate"(C, *const fmi2Byte, usize, *mut fmi2FMUstate) -> S;
    directional_derivative = "fmi2GetDirectionalDerivative"(C, References, usize, References, usize, *const f64, *mut f64) -> S;
    set_input_derivatives = "fmi2SetRealInputDerivatives"(C, References, usize, *const fmi2Integer, *const f64) -> S;
    get_output_derivatives = "fmi2GetRealOutputDerivatives"(C, References, usize, *const fmi2Integer, *mut f64) -> S;
    do_step = "fmi2DoStep"(C, f64, f64, fmi2Boolean) -> S;
    cancel_step = "fmi2CancelStep"(C) -> S;
    get_status = "fmi2GetStatus"(C, fmi2StatusKind, *mut S) -> S;
    get_real_status = "fmi2GetRealStatus"(C, fmi2StatusKind, *mut f64) -> S;
    get_integer_status = "fmi2GetIntegerStatus"(C, fmi2StatusKind, *mut fmi2Integer) -> S;
    get_boolean_status = "fmi2GetBooleanStatus"(C, fmi2StatusKind, *mut fmi2Boolean) -> S;
    get_string_status = "fmi2GetStringStatus"(C, fmi2StatusKind, *mut fmi2String) -> S;
    enter_event_mode = "fmi2EnterEventMode"(C) -> S;
    new_discrete_states = "fmi2NewDiscreteStates"(C, *mut fmi2EventInfo) -> S;
    enter_continuous_time_mode = "fmi2EnterContinuousTimeMode"(C) -> S;
    completed_integrator_step = "fmi2CompletedIntegratorStep"(C, fmi2Boolean, *mut fmi2Boolean, *mut fmi2Boolean) -> S;
    set_time = "fmi2SetTime"(C, f64) -> S;
    set_continuous_states = "fmi2SetContinuousStates"(C, *const f64, usize) -> S;
    get_derivatives = "fmi2GetDerivatives"(C, *mut f64, usize) -> S;
    get_event_indicators = "fmi2GetEventIndicators"(C, *mut f64, usize) -> S;
    get_continuous_states = "fmi2GetContinuousStates"(C, *mut f64, usize) -> S;
    get_nominals = "fmi2GetNominalsOfContinuousStates"(C, *mut f64, usize) -> S;
}

/// An instance.
pub struct Slave<'a> {
    pub fmu: &'a Fmu,
    pub c: fmi2Component,
    messages: Box<Messages>,
}

impl Drop for Slave<'_> {
    fn drop(&mut self) {
        // SAFETY: it came from `fmi2Instantiate` and is not used again.
        unsafe { (self.fmu.library.free_instance)(self.c) }
    }
}

// SAFETY of all calls: the component is alive, and arrays are as long as announced.
impl Slave<'_> {
    pub fn fmi(&self) -> &Library {
        &self.fmu.library
    }

    pub fn log(&self) -> Vec<(String, fmi2Status, String, String)> {
        std::mem::take(&mut self.messages.lock().expect("not poisoned"))
    }

    pub fn setup(&self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> fmi2Status {
        let (has_stop, has_tolerance) = (stop.is_some().into(), tolerance.is_some().into());
        let (stop, tolerance) = (stop.unwrap_or_default(), tolerance.unwrap_or_default());
        unsafe { (self.fmi().setup_experiment)(self.c, has_tolerance, tolerance, start, has_stop, stop) }
    }

    pub fn enter(&self) -> fmi2Status {
        unsafe { (self.fmi().enter_initialization)(self.c) }
    }

    pub fn exit(&self) -> fmi2Status {
        unsafe { (self.fmi().exit_initialization)(self.c) }
    }

    pub fn start(&self) {
        assert_eq!([self.setup(0.0, None, None), self.enter(), self.exit()], [fmi2OK; 3], "{:?}", self.log());
    }

    pub fn terminate(&self) -> fmi2Status {
        unsafe { (self.fmi().terminate)(self.c) }
    }

    pub fn reset(&self) -> fmi2Status {
        unsafe { (self.fmi().reset)(self.c) }
    }

    pub fn step(&self, t: f64, h: f64) -> fmi2Status {
        unsafe { (self.fmi().do_step)(self.c, t, h, fmi2True) }
    }

    pub fn get(&self, reference: u32) -> Result<f64, fmi2Status> {
        let mut value = f64::NAN;
        match unsafe { (self.fmi().get_real)(self.c, &reference, 1, &mut value) } {
            fmi2OK => Ok(value),
            status => Err(status),
        }
    }

    pub fn put(&self, reference: u32, value: f64) -> fmi2Status {
        unsafe { (self.fmi().set_real)(self.c, &reference, 1, &value) }
    }

    /// All variables, bit by bit.
    pub fn all(&self) -> Vec<u64> {
        self.read(&self.fmu.references(|_| true)).into_iter().map(f64::to_bits).collect()
    }

    pub fn read(&self, references: &[u32]) -> Vec<f64> {
        let mut values = vec![f64::NAN; references.len()];
        let status =
            unsafe { (self.fmi().get_real)(self.c, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        assert_eq!(status, fmi2OK, "{:?}", self.log());
        values
    }

    /// Steps of 10 ms from step number `from` on, with an input that changes now and then; all variables after each.
    pub fn run(&self, steps: std::ops::Range<u32>) -> Vec<Vec<u64>> {
        steps
            .map(|step| {
                if step % 5 == 0 {
                    for input in self.fmu.inputs() {
                        assert_eq!(self.put(input, 0.1 * f64::from(step % 7)), fmi2OK);
                    }
                }
                assert_eq!(self.step(f64::from(step) * 0.01, 0.01), fmi2OK, "{:?}", self.log());
                self.all()
            })
            .collect()
    }

    pub fn save(&self) -> fmi2FMUstate {
        let mut state = null_mut();
        assert_eq!(unsafe { (self.fmi().get_state)(self.c, &mut state) }, fmi2OK);
        state
    }

    pub fn restore(&self, state: fmi2FMUstate) -> fmi2Status {
        unsafe { (self.fmi().set_state)(self.c, state) }
    }

    pub fn free(&self, mut state: fmi2FMUstate) {
        assert_eq!(unsafe { (self.fmi().free_state)(self.c, &mut state) }, fmi2OK);
        assert!(state.is_null());
    }

    pub fn bytes(&self, state: fmi2FMUstate) -> Vec<i8> {
        let mut size = 0;
        assert_eq!(unsafe { (self.fmi().serialized_size)(self.c, state, &mut size) }, fmi2OK);
        let mut bytes = vec![0; size];
        assert_eq!(unsafe { (self.fmi().serialize)(self.c, state, bytes.as_mut_ptr(), size) }, fmi2OK);
        bytes
    }

    pub fn deserialize(&self, bytes: &[i8]) -> Result<fmi2FMUstate, fmi2Status> {
        let mut state = null_mut();
        match unsafe { (self.fmi().deserialize)(self.c, bytes.as_ptr(), bytes.len(), &mut state) } {
            fmi2OK => Ok(state),
            status => Err(status),
        }
    }

    /// Derivatives of the unknowns by one known.
    pub fn derivatives(&self, unknowns: &[u32], known: u32) -> Vec<f64> {
        let mut values = vec![f64::NAN; unknowns.len()];
        let status = unsafe {
            let call = self.fmi().directional_derivative;
            call(self.c, unknowns.as_ptr(), unknowns.len(), &known, 1, &1.0, values.as_mut_ptr())
        };
        assert_eq!(status, fmi2OK, "{:?}", self.log());
        values
    }

    pub fn debug(&self, on: bool, names: &[&CStr]) -> fmi2Status {
        let names: Vec<fmi2String> = names.iter().map(|name| name.as_ptr()).collect();
        let pointer = if names.is_empty() { null() } else { names.as_ptr() };
        unsafe { (self.fmi().set_debug_logging)(self.c, on.into(), names.len(), pointer) }
    }
}
