//! The FMI functions as an importer calls them, pointer by pointer.

use std::ffi::{CStr, CString, c_void};
use std::path::PathBuf;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use crate::support::*;
use cotree_fmu::fmi2::types::fmi2Status::{self, fmi2Discard, fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;
use cotree_fmu::fmi2::*;
use cotree_fmu::program::Program;

/// Messages received: instance, status, category, message.
type Messages = Mutex<Vec<(String, fmi2Status, String, String)>>;

unsafe extern "C" fn record(
    environment: fmi2ComponentEnvironment,
    instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is the `Messages` of the test, which outlives its instances.
    let messages = unsafe { &*environment.cast::<Messages>() };
    // SAFETY: the FMU passes strings that end with zero.
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned();
    messages.lock().expect("not poisoned").push((text(instance), status, text(category), text(message)));
}

/// An unpacked FMU in a folder of its own.
struct Unpacked {
    folder: PathBuf,
    guid: CString,
    messages: Box<Messages>,
}

impl Unpacked {
    fn new(name: &str, program: &Program) -> Self {
        let folder = std::env::temp_dir().join(format!("cotree fmu é {} {name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("program.bin"), program.to_bytes().expect("sound")).expect("a file");
        let guid = CString::new(program.guid.as_str()).expect("no zero");
        Self { folder, guid, messages: Box::default() }
    }

    fn location(&self) -> String {
        let path = self.folder.to_str().expect("UTF-8").replace('%', "%25").replace(' ', "%20").replace('é', "%C3%A9");
        format!("file://{path}")
    }

    fn callbacks(&self) -> fmi2CallbackFunctions {
        // SAFETY: the FMU never passes arguments beyond the named ones, and the calling convention is then the same.
        let logger = unsafe {
            std::mem::transmute::<
                unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String),
                unsafe extern "C" fn(*mut c_void, fmi2String, fmi2Status, fmi2String, fmi2String, ...),
            >(record)
        };
        let environment = std::ptr::from_ref::<Messages>(&self.messages).cast_mut().cast();
        fmi2CallbackFunctions {
            logger: Some(logger),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: environment,
        }
    }

    fn instantiate(&self, location: &str, logging: fmi2Boolean) -> fmi2Component {
        let name = CString::new("my %s # instance").expect("no zero");
        let location = CString::new(location).expect("no zero");
        let callbacks = self.callbacks();
        // SAFETY: all pointers are valid during the call.
        unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                fmi2CoSimulation,
                self.guid.as_ptr(),
                location.as_ptr(),
                &callbacks,
                0,
                logging,
            )
        }
    }

    fn component(&self) -> fmi2Component {
        let component = self.instantiate(&self.location(), fmi2False);
        assert!(!component.is_null(), "{:?}", self.log());
        component
    }

    fn log(&self) -> Vec<(String, fmi2Status, String, String)> {
        std::mem::take(&mut self.messages.lock().expect("not poisoned"))
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

// SAFETY of all calls below: the component is alive, and arrays are as long as announced.

fn get(c: fmi2Component, reference: u32) -> Result<f64, fmi2Status> {
    let mut value = f64::NAN;
    match unsafe { fmi2GetReal(c, &reference, 1, &mut value) } {
        fmi2OK => Ok(value),
        status => Err(status),
    }
}

fn put(c: fmi2Component, reference: u32, value: f64) -> fmi2Status {
    unsafe { fmi2SetReal(c, &reference, 1, &value) }
}

fn setup(c: fmi2Component, stop: Option<f64>) -> fmi2Status {
    unsafe { fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, stop.is_some().into(), stop.unwrap_or(0.0)) }
}

fn enter(c: fmi2Component) -> fmi2Status {
    unsafe { fmi2EnterInitializationMode(c) }
}

fn exit(c: fmi2Component) -> fmi2Status {
    unsafe { fmi2ExitInitializationMode(c) }
}

fn step(c: fmi2Component, t: f64, h: f64) -> fmi2Status {
    unsafe { fmi2DoStep(c, t, h, fmi2True) }
}

fn free(c: fmi2Component) {
    unsafe { fmi2FreeInstance(c) }
}

fn start(c: fmi2Component) {
    assert_eq!([setup(c, None), enter(c), exit(c)], [fmi2OK; 3]);
}

const TIME: u32 = 0;
const GRAVITY: u32 = 1;
const LENGTH: u32 = 2;
const TORQUE: u32 = 3;
const ANGLE: u32 = 4;
const ENERGY: u32 = 7;

#[test]
fn all_forms_of_the_resource_location_work() {
    let fmu = Unpacked::new("location", &pendulum());
    let location = fmu.location();
    for form in [location.clone(), location.replacen("file://", "file:", 1), location.clone() + "/"] {
        let c = fmu.instantiate(&form, fmi2False);
        assert!(!c.is_null(), "{form}: {:?}", fmu.log());
        free(c);
    }
    for wrong in ["", "file:///nowhere", "http://example.org/x"] {
        assert!(fmu.instantiate(wrong, fmi2False).is_null());
        assert_eq!(fmu.log().len(), 1, "{wrong}");
    }
    std::fs::write(fmu.folder.join("program.bin"), b"rubbish").expect("a file");
    assert!(fmu.instantiate(&location, fmi2False).is_null());
    let log = fmu.log();
    assert!(log[0].3.contains("not a cotree program"), "{log:?}");
}

#[test]
fn wrong_arguments_of_instantiate_give_null_and_a_reason() {
    let fmu = Unpacked::new("arguments", &pendulum());
    let location = CString::new(fmu.location()).expect("no zero");
    let callbacks = fmu.callbacks();
    let make = |name: fmi2String, kind, guid: fmi2String, callbacks: *const fmi2CallbackFunctions| unsafe {
        fmi2Instantiate(name, kind, guid, location.as_ptr(), callbacks, 0, 0)
    };
    let (name, guid) = (c"a".as_ptr(), fmu.guid.as_ptr());
    for (name, kind, guid) in [
        (null(), fmi2CoSimulation, guid),
        (c"".as_ptr(), fmi2CoSimulation, guid),
        (name, 7, guid),
        (name, fmi2CoSimulation, null()),
        (name, fmi2CoSimulation, c"{other}".as_ptr()),
    ] {
        assert!(make(name, kind, guid, &callbacks).is_null());
        let log = fmu.log();
        assert_eq!((log.len(), log[0].1, log[0].2.as_str()), (1, fmi2Error, "errors"));
    }
    assert!(make(name, fmi2CoSimulation, guid, null()).is_null());
    let silent = fmi2CallbackFunctions { logger: None, ..callbacks };
    let c = make(name, fmi2CoSimulation, guid, &silent);
    assert_eq!(put(c, 99, 1.0), fmi2Error);
    free(c);
    free(null_mut());
    assert_eq!(step(null_mut(), 0.0, 1.0), fmi2Error);
}

#[test]
fn the_state_machine_refuses_calls_out_of_order() {
    let fmu = Unpacked::new("order", &pendulum());
    let c = fmu.component();
    let terminate = || unsafe { fmi2Terminate(c) };
    assert_eq!([step(c, 0.0, 0.1), exit(c), terminate(), enter(c)], [fmi2Error; 4]);
    assert_eq!(get(c, ANGLE), Err(fmi2Error));
    assert_eq!([setup(c, None), enter(c)], [fmi2OK; 2]);
    assert_eq!([enter(c), setup(c, None), step(c, 0.0, 0.1), terminate()], [fmi2Error; 4]);
    assert_eq!(get(c, ANGLE), Ok(1.0), "outputs in initialization mode");
    assert_eq!(exit(c), fmi2OK);
    assert_eq!([enter(c), exit(c), setup(c, None)], [fmi2Error; 3]);
    assert_eq!(step(c, 0.0, 0.1), fmi2OK);
    let angle = get(c, ANGLE);
    assert_eq!(terminate(), fmi2OK);
    assert_eq!([step(c, 0.1, 0.1), put(c, TORQUE, 1.0), terminate()], [fmi2Error; 3]);
    assert_eq!(get(c, ANGLE), angle, "final values stay readable");
    assert_eq!(unsafe { fmi2Reset(c) }, fmi2OK);
    assert_eq!(enter(c), fmi2Error, "the experiment must be set up again");
    start(c);
    assert_eq!(step(c, 0.0, 0.1), fmi2OK);
    assert_eq!(get(c, ANGLE), angle);
    free(c);
}

#[test]
fn values_are_set_when_and_where_the_standard_permits() {
    let fmu = Unpacked::new("values", &pendulum());
    let c = fmu.component();
    assert_eq!([put(c, LENGTH, 2.0), put(c, TORQUE, 0.5), put(c, GRAVITY, 9.0)], [fmi2OK; 3], "before initialization");
    assert_eq!([setup(c, None), enter(c)], [fmi2OK; 2]);
    assert_eq!((get(c, LENGTH), get(c, TORQUE)), (Ok(2.0), Ok(0.5)));
    assert_eq!(put(c, LENGTH, 3.0), fmi2OK);
    assert_eq!(exit(c), fmi2OK);
    assert_eq!(put(c, LENGTH, 4.0), fmi2Error, "fixed");
    assert_eq!(get(c, LENGTH), Ok(3.0));
    assert_eq!([put(c, TIME, 1.0), put(c, ANGLE, 1.0), put(c, ENERGY, 1.0), put(c, 99, 1.0)], [fmi2Error; 4]);
    assert_eq!([put(c, TORQUE, f64::NAN), put(c, TORQUE, f64::INFINITY)], [fmi2Error; 2]);
    assert_eq!(put(c, TORQUE, 101.0), fmi2Discard, "more than the largest permitted value");
    assert_eq!(step(c, 0.0, 0.1), fmi2OK);
    assert_eq!(put(c, GRAVITY, 1.0), fmi2OK, "tunable");
    assert_eq!(get(c, GRAVITY), Ok(1.0));
    assert_eq!(step(c, 0.1, 0.1), fmi2OK);
    // All or nothing.
    let (references, values) = ([TORQUE, LENGTH], [7.0, 7.0]);
    assert_eq!(unsafe { fmi2SetReal(c, references.as_ptr(), 2, values.as_ptr()) }, fmi2Error);
    assert_eq!(get(c, TORQUE), Ok(0.5));
    free(c);
}

#[test]
fn arrays_may_be_empty_but_not_missing() {
    let fmu = Unpacked::new("arrays", &pendulum());
    let c = fmu.component();
    start(c);
    let reference = TORQUE;
    let (mut real, mut integer, mut text) = (0.0, 0, null());
    unsafe {
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(fmi2SetReal(c, null(), 0, null()), fmi2OK);
        assert_eq!(fmi2GetReal(c, null(), 1, &mut real), fmi2Error);
        assert_eq!(fmi2GetReal(c, &reference, 1, null_mut()), fmi2Error);
        assert_eq!(fmi2GetReal(c, &reference, usize::MAX, &mut real), fmi2Error);
        assert_eq!(fmi2SetReal(c, &reference, 1, null()), fmi2Error);
        assert_eq!(fmi2GetInteger(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(fmi2GetInteger(c, &reference, 1, &mut integer), fmi2Error);
        assert_eq!(fmi2GetBoolean(c, &reference, 1, &mut integer), fmi2Error);
        assert_eq!(fmi2GetString(c, &reference, 1, &mut text), fmi2Error);
        assert_eq!(fmi2SetInteger(c, &reference, 1, &integer), fmi2Error);
        assert_eq!(fmi2SetBoolean(c, &reference, 1, &integer), fmi2Error);
        assert_eq!(fmi2SetString(c, &reference, 1, &text), fmi2Error);
        assert_eq!(fmi2GetDirectionalDerivative(c, &reference, 1, &reference, 1, &real, &mut real), fmi2Error);
        assert_eq!(fmi2GetRealOutputDerivatives(c, &reference, 1, &1, &mut real), fmi2Error);
    }
    free(c);
}

#[test]
fn steps_must_follow_each_other() {
    let fmu = Unpacked::new("steps", &pendulum());
    let c = fmu.component();
    assert_eq!([setup(c, Some(1.0)), enter(c), exit(c)], [fmi2OK; 3]);
    for (t, h) in
        [(0.0, 0.0), (0.0, -0.1), (0.0, f64::NAN), (f64::NAN, 0.1), (f64::INFINITY, 0.1), (0.0, f64::INFINITY)]
    {
        assert_eq!(step(c, t, h), fmi2Error, "{t} {h}");
    }
    assert_eq!([step(c, 36_000.0, 0.1), step(c, -36_000.0, 0.1), step(c, 0.05, 0.1)], [fmi2Error; 3]);
    let mut t = 0.0;
    for h in [0.1, 0.05, 0.2, 0.1] {
        assert_eq!(step(c, t, h), fmi2OK);
        t += h;
        assert_eq!(get(c, TIME), Ok(t));
    }
    let h = (1.0 - t) / 1000.0;
    for _ in 0..1000 {
        assert_eq!(step(c, t, h), fmi2OK);
        t += h;
    }
    assert_eq!(step(c, t, 0.1), fmi2Error, "past the stop time");
    assert_eq!(get(c, TIME), Ok(t));
    free(c);
}

#[test]
fn wrong_experiments_are_refused() {
    let fmu = Unpacked::new("experiments", &pendulum());
    let c = fmu.component();
    let setup = |tolerance: f64, start, stop| unsafe {
        fmi2SetupExperiment(c, (tolerance != 1.0).into(), tolerance, start, fmi2True, stop)
    };
    for (tolerance, start, stop) in
        [(1.0, 1.0, 0.0), (1.0, f64::NAN, 1.0), (0.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (f64::NAN, 0.0, 1.0)]
    {
        assert_eq!(setup(tolerance, start, stop), fmi2Error);
    }
    assert_eq!(setup(1e-10, 5.0, 6.0), fmi2OK);
    assert_eq!([enter(c), exit(c)], [fmi2OK; 2]);
    assert_eq!(get(c, TIME), Ok(5.0));
    assert_eq!(step(c, 0.0, 0.1), fmi2Error);
    assert_eq!(step(c, 5.0, 0.1), fmi2OK);
    free(c);
}

#[test]
fn states_are_saved_restored_and_serialized() {
    let fmu = Unpacked::new("states", &pendulum());
    let (c, other) = (fmu.component(), fmu.component());
    start(c);
    assert_eq!([put(c, TORQUE, 1.0), step(c, 0.0, 0.3)], [fmi2OK; 2]);
    let mut state = null_mut();
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &mut state), fmi2OK);
        let first = state;
        assert_eq!(fmi2GetFMUstate(c, &mut state), fmi2OK);
        assert_eq!(state, first, "an existing state is reused");
        assert_eq!(step(c, 0.3, 0.7), fmi2OK);
        let expected = get(c, ANGLE);
        assert_eq!(fmi2Terminate(c), fmi2OK);
        assert_eq!(fmi2SetFMUstate(c, state), fmi2OK);
        assert_eq!(get(c, TIME), Ok(0.3));
        assert_eq!(step(c, 0.3, 0.7), fmi2OK);
        assert_eq!(get(c, ANGLE), expected);

        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), fmi2OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1), fmi2Error);
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), fmi2OK);
        let mut copy = null_mut();
        for length in 0..size {
            assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr(), length, &mut copy), fmi2Error);
            bytes[length] ^= 4;
            assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr(), size, &mut copy), fmi2Error);
            bytes[length] ^= 4;
        }
        assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr(), size, &mut copy), fmi2OK);
        assert_eq!(fmi2SetFMUstate(other, copy), fmi2OK);
        assert_eq!(step(other, 0.3, 0.7), fmi2OK);
        assert_eq!(get(other, ANGLE), expected);

        assert_eq!(fmi2FreeFMUstate(c, &mut state), fmi2OK);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), fmi2OK);
        assert_eq!(fmi2FreeFMUstate(c, null_mut()), fmi2OK);
        assert_eq!(fmi2FreeFMUstate(other, &mut copy), fmi2OK);
        assert_eq!(fmi2SetFMUstate(c, null_mut()), fmi2Error);
        assert_eq!(fmi2GetFMUstate(c, null_mut()), fmi2Error);
        assert_eq!(fmi2SerializedFMUstateSize(c, null_mut(), &mut size), fmi2Error);
    }
    free(c);
    free(other);
}

#[test]
fn input_derivatives_act_and_wrong_ones_are_refused() {
    let fmu = Unpacked::new("derivatives", &pendulum());
    let c = fmu.component();
    start(c);
    let set = |reference: u32, order: i32, value: f64| unsafe {
        fmi2SetRealInputDerivatives(c, &reference, 1, &order, &value)
    };
    let wrong =
        [set(TORQUE, 0, 1.0), set(TORQUE, 3, 1.0), set(GRAVITY, 1, 1.0), set(99, 1, 1.0), set(TORQUE, 1, f64::NAN)];
    assert_eq!(wrong, [fmi2Error; 5]);
    assert_eq!([put(c, TORQUE, 1.0), set(TORQUE, 1, 2.0), set(TORQUE, 2, 4.0)], [fmi2OK; 3]);
    assert_eq!(step(c, 0.0, 0.5), fmi2OK);
    assert_eq!(get(c, TORQUE), Ok(2.5));
    free(c);
}

#[test]
fn status_functions_tell_the_time_and_nothing_else() {
    let fmu = Unpacked::new("status", &pendulum());
    let c = fmu.component();
    start(c);
    assert_eq!(step(c, 0.0, 0.25), fmi2OK);
    let (mut real, mut integer, mut boolean, mut status, mut text) = (0.0, 0, 7, fmi2OK, null());
    unsafe {
        assert_eq!(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &mut real), fmi2OK);
        assert_eq!(real, 0.25);
        assert_eq!(fmi2GetRealStatus(c, fmi2DoStepStatus, &mut real), fmi2Discard);
        assert_eq!(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, null_mut()), fmi2Error);
        assert_eq!(fmi2GetStatus(c, fmi2DoStepStatus, &mut status), fmi2Discard);
        assert_eq!(fmi2GetIntegerStatus(c, 99, &mut integer), fmi2Discard);
        assert_eq!(fmi2GetBooleanStatus(c, fmi2Terminated, &mut boolean), fmi2OK);
        assert_eq!(boolean, fmi2False);
        assert_eq!(fmi2GetStringStatus(c, fmi2PendingStatus, &mut text), fmi2Discard);
        assert_eq!(fmi2CancelStep(c), fmi2Error);
    }
    free(c);
}

#[test]
fn messages_are_finished_strings_of_declared_categories() {
    let mut program = pendulum();
    program.variables[7].name = "100% energy".into();
    let fmu = Unpacked::new("messages", &program);
    let c = fmu.component();
    start(c);
    assert_eq!([step(c, 0.0, 0.1), unsafe { fmi2Terminate(c) }], [fmi2OK; 2]);
    assert_eq!(fmu.log(), [], "a normal run is silent");
    assert_eq!(put(c, 99, 0.0), fmi2Error);
    assert_eq!(fmu.log().len(), 1);
    free(c);

    let c = fmu.instantiate(&fmu.location(), fmi2True);
    start(c);
    assert_eq!(put(c, ENERGY, 0.0), fmi2Error);
    assert_eq!(unsafe { fmi2Terminate(c) }, fmi2OK);
    let log = fmu.log();
    assert!(log.iter().all(|entry| entry.0 == "my %s # instance" && !entry.3.ends_with('\n')));
    let categories: Vec<&str> = log.iter().map(|entry| entry.2.as_str()).collect();
    assert_eq!(categories, ["events", "errors", "events", "solver"]);
    assert!(log[1].3.contains("`100%% energy`"), "{log:?}");

    let switch = |on, names: &[fmi2String]| unsafe { fmi2SetDebugLogging(c, on, names.len(), names.as_ptr()) };
    assert_eq!(switch(fmi2True, &[c"nonsense".as_ptr()]), fmi2Error);
    assert_eq!(switch(fmi2True, &[null()]), fmi2Error);
    let all = [c"events".as_ptr(), c"solver".as_ptr(), c"errors".as_ptr()];
    assert_eq!([switch(fmi2True, &all), switch(fmi2False, &[]), switch(fmi2False, &all[..1])], [fmi2OK; 3]);
    fmu.log();
    assert_eq!(put(c, ENERGY, 0.0), fmi2Error);
    assert_eq!(fmu.log(), []);
    free(c);
}

#[test]
fn an_assembly_that_fails_is_explained_and_can_be_repaired() {
    let mut program = four_bar(Drive::Time, false);
    program.parameters[0].start = 7.0;
    let fmu = Unpacked::new("assembly", &program);
    let c = fmu.component();
    assert_eq!([setup(c, None), enter(c)], [fmi2OK; 2]);
    assert_eq!(get(c, 4), Err(fmi2Error));
    assert_eq!(exit(c), fmi2Error);
    let log = fmu.log();
    assert!(log[1].3.contains("the loops cannot be closed") && log[1].3.contains("`rocker_pin`"), "{log:?}");
    assert_eq!([put(c, 1, 3.5), exit(c), step(c, 0.0, 0.1)], [fmi2OK; 3], "better parameters");
    assert_eq!(unsafe { fmi2Reset(c) }, fmi2OK);
    assert_eq!(put(c, 1, 3.5), fmi2OK);
    start(c);
    free(c);
}

#[test]
fn instances_in_threads_do_not_disturb_each_other() {
    let fmu = Unpacked::new("threads", &slider_crank());
    let run = |component: usize| {
        let c = component as fmi2Component;
        start(c);
        for index in 0..200 {
            assert_eq!(step(c, f64::from(index) * 0.01, 0.01), fmi2OK);
        }
        let result = get(c, 3).map(f64::to_bits);
        free(c);
        result
    };
    let single = run(fmu.component() as usize);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8)
            .map(|_| {
                let component = fmu.component() as usize;
                scope.spawn(move || run(component))
            })
            .collect();
        for thread in threads {
            assert_eq!(thread.join().expect("no panic"), single);
        }
    });
}

#[test]
fn the_platform_and_the_version_are_those_of_the_standard() {
    // SAFETY: both return static strings.
    let text = |pointer| unsafe { CStr::from_ptr(pointer) };
    assert_eq!((text(fmi2GetTypesPlatform()), text(fmi2GetVersion())), (c"default", c"2.0"));
}
