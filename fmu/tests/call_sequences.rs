//! Random calls in random order with absurd arguments, against a model of the standard's state machines: what is permitted succeeds, what is
//! not is refused, nothing crashes, and values that may be read are numbers.

use std::ffi::CString;
use std::path::PathBuf;
use std::ptr::{null, null_mut};

use crate::support::*;
use cotree_fmu::fmi2::types::fmi2Status::{self, fmi2Discard, fmi2Error, fmi2OK, fmi2Warning};
use cotree_fmu::fmi2::types::*;
use cotree_fmu::fmi2::*;
use cotree_fmu::program::{Program, Source};
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Call {
    Setup { start: f64, stop: Option<f64>, tolerance: Option<f64> },
    Enter,
    Exit,
    Step { offset: f64, size: f64 },
    Get(u32),
    Set(u32, f64),
    SetDerivative(u32, i32, f64),
    Derivative(u32, u32),
    OutputDerivative(u32, i32),
    Save,
    Restore,
    Serialise { damage: Option<usize> },
    Terminate,
    Reset,
    Time(f64),
    States(f64),
    Rates,
    Completed,
    Event,
    NewStates,
    Continue,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Instantiated,
    Initialization,
    Stepping,
    Event,
    Continuous,
    Terminated,
}

/// What the importer knows about the instance.
#[derive(Clone, Debug)]
struct Expected {
    mode: Mode,
    set_up: bool,
    time: f64,
    stop: Option<f64>,
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -2.0..2.0,
        1 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(-1e300),
        1 => Just(1e-300),
        1 => Just(1e300),
    ]
}

fn call() -> impl Strategy<Value = Call> {
    let reference = || prop_oneof![8 => 0_u32..12, 1 => any::<u32>()];
    let step = (prop_oneof![8 => Just(0.0), 1 => number()], prop_oneof![8 => 0.001..0.1, 1 => number()]);
    prop_oneof![
        2 => (prop_oneof![3 => Just(0.0), 1 => number()], proptest::option::of(number()), proptest::option::of(number()))
            .prop_map(|(start, stop, tolerance)| Call::Setup { start, stop, tolerance }),
        2 => Just(Call::Enter),
        3 => Just(Call::Exit),
        8 => step.prop_map(|(offset, size)| Call::Step { offset, size }),
        4 => reference().prop_map(Call::Get),
        4 => (reference(), number()).prop_map(|(reference, value)| Call::Set(reference, value)),
        2 => (reference(), -1..4, number()).prop_map(|(reference, order, value)| Call::SetDerivative(reference, order, value)),
        2 => (reference(), reference()).prop_map(|(unknown, known)| Call::Derivative(unknown, known)),
        2 => (reference(), -1..7).prop_map(|(reference, order)| Call::OutputDerivative(reference, order)),
        2 => Just(Call::Save),
        2 => Just(Call::Restore),
        1 => proptest::option::of(any::<usize>()).prop_map(|damage| Call::Serialise { damage }),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        2 => number().prop_map(Call::Time),
        2 => number().prop_map(Call::States),
        1 => Just(Call::Rates),
        1 => Just(Call::Completed),
        1 => Just(Call::Event),
        2 => Just(Call::NewStates),
        2 => Just(Call::Continue),
    ]
}

/// An unpacked FMU.
struct Unpacked(PathBuf);

impl Drop for Unpacked {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn unpack(program: &Program, name: &str) -> Unpacked {
    let folder = std::env::temp_dir().join(format!("cotree-calls-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("program.bin"), program.to_bytes().expect("sound")).expect("a file");
    Unpacked(folder)
}

fn instantiate(program: &Program, folder: &Unpacked, kind: fmi2Type) -> fmi2Component {
    let [guid, location] = [program.guid.clone(), format!("file://{}", folder.0.display())]
        .map(|text| CString::new(text).expect("no zero"));
    let callbacks = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    // SAFETY: all pointers are valid during the call.
    unsafe { fmi2Instantiate(c"a".as_ptr(), kind, guid.as_ptr(), location.as_ptr(), &callbacks, 0, 0) }
}

/// An instance with what is expected of it.
struct Subject {
    c: fmi2Component,
    program: Program,
    exchange: bool,
    now: Expected,
    saved: Option<(fmi2FMUstate, Expected)>,
}

impl Subject {
    /// Does the model of the state machine permit the call? `None`: the answer depends on the numbers.
    fn permits(&self, call: &Call) -> Option<bool> {
        let mode = self.now.mode;
        let running = matches!(mode, Mode::Stepping | Mode::Event | Mode::Continuous);
        let readable = running || matches!(mode, Mode::Initialization | Mode::Terminated);
        let needs = |permitted: bool| if permitted { None } else { Some(false) };
        match call {
            Call::Setup { .. } => needs(mode == Mode::Instantiated),
            Call::Enter => Some(mode == Mode::Instantiated && self.now.set_up),
            Call::Exit => needs(mode == Mode::Initialization),
            Call::Step { offset, size } => {
                let sound = *offset == 0.0 && (1e-3..=0.1).contains(size);
                if mode != Mode::Stepping || !(offset.is_finite() && size.is_finite() && *size > 0.0) {
                    return Some(false);
                }
                let beyond = self.now.stop.is_some_and(|stop| self.now.time + size > stop + 2e-3 * size);
                if sound && beyond { Some(false) } else { None }
            }
            Call::Get(reference) => needs(readable && self.source(*reference).is_some()),
            Call::Set(reference, value) => {
                let calculated = !matches!(self.source(*reference), Some(Source::Parameter(_) | Source::Input(_)));
                needs(
                    (running || matches!(mode, Mode::Instantiated | Mode::Initialization))
                        && !calculated
                        && value.is_finite(),
                )
            }
            Call::SetDerivative(reference, order, value) => {
                let input = matches!(self.source(*reference), Some(Source::Input(_)));
                let modes = matches!(mode, Mode::Instantiated | Mode::Initialization | Mode::Stepping);
                Some(!self.exchange && modes && input && (1..=2).contains(order) && value.is_finite())
            }
            Call::Derivative(unknown, _) => needs(readable && self.source(*unknown).is_some()),
            Call::OutputDerivative(reference, order) => needs(
                matches!(mode, Mode::Stepping | Mode::Terminated)
                    && !self.exchange
                    && (1..=4).contains(order)
                    && self.source(*reference).is_some(),
            ),
            Call::Save | Call::Reset => Some(true),
            Call::Restore => Some(self.saved.is_some()),
            Call::Serialise { damage } => Some(self.saved.is_some() && damage.is_none()),
            Call::Terminate => Some(running),
            Call::Time(time) => Some(matches!(mode, Mode::Event | Mode::Continuous) && time.is_finite()),
            Call::States(value) => Some(mode == Mode::Continuous && (value.is_finite() || self.states() == 0)),
            Call::Rates => needs(self.exchange && readable),
            Call::Completed => needs(mode == Mode::Continuous),
            Call::Event => Some(mode == Mode::Continuous),
            Call::NewStates => needs(mode == Mode::Event),
            Call::Continue => Some(mode == Mode::Event),
        }
    }

    fn source(&self, reference: u32) -> Option<Source> {
        self.program.variables.get(reference as usize).map(|variable| variable.source)
    }

    fn states(&self) -> usize {
        if self.program.is_driven() { 0 } else { 2 * self.program.coordinates.len() }
    }

    // SAFETY of all calls: the component is alive, and arrays are as long as announced.
    fn make(&mut self, call: &Call) -> fmi2Status {
        let c = self.c;
        let mut value = 0.0;
        match *call {
            Call::Setup { start, stop, tolerance } => unsafe {
                let (stops, tolerates) = (stop.is_some().into(), tolerance.is_some().into());
                fmi2SetupExperiment(c, tolerates, tolerance.unwrap_or(0.0), start, stops, stop.unwrap_or(0.0))
            },
            Call::Enter => unsafe { fmi2EnterInitializationMode(c) },
            Call::Exit => unsafe { fmi2ExitInitializationMode(c) },
            Call::Step { offset, size } => unsafe { fmi2DoStep(c, self.now.time + offset, size, 1) },
            Call::Get(reference) => {
                let status = unsafe { fmi2GetReal(c, &reference, 1, &mut value) };
                assert!(if status == fmi2Warning { value.is_nan() } else { status != fmi2OK || value.is_finite() });
                status
            }
            Call::Set(reference, value) => unsafe { fmi2SetReal(c, &reference, 1, &value) },
            Call::SetDerivative(reference, order, value) => unsafe {
                fmi2SetRealInputDerivatives(c, &reference, 1, &order, &value)
            },
            Call::Derivative(unknown, known) => {
                let status = unsafe { fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &1.0, &mut value) };
                assert!(status != fmi2OK || value.is_finite());
                status
            }
            Call::OutputDerivative(reference, order) => {
                let status = unsafe { fmi2GetRealOutputDerivatives(c, &reference, 1, &order, &mut value) };
                assert!(status != fmi2OK || value.is_finite());
                status
            }
            Call::Save => self.save(),
            Call::Restore => unsafe { fmi2SetFMUstate(c, self.saved.as_ref().map_or(null_mut(), |saved| saved.0)) },
            Call::Serialise { damage } => self.serialise(damage),
            Call::Terminate => unsafe { fmi2Terminate(c) },
            Call::Reset => unsafe { fmi2Reset(c) },
            Call::Time(time) => unsafe { fmi2SetTime(c, time) },
            Call::States(value) => {
                let states = vec![value; self.states()];
                unsafe { fmi2SetContinuousStates(c, states.as_ptr(), states.len()) }
            }
            Call::Rates => {
                let mut rates = vec![0.0; self.states()];
                unsafe { fmi2GetDerivatives(c, rates.as_mut_ptr(), rates.len()) }
            }
            Call::Completed => unsafe { fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0) },
            Call::Event => unsafe { fmi2EnterEventMode(c) },
            Call::NewStates => {
                let mut info = std::mem::MaybeUninit::uninit();
                unsafe { fmi2NewDiscreteStates(c, info.as_mut_ptr()) }
            }
            Call::Continue => unsafe { fmi2EnterContinuousTimeMode(c) },
        }
    }

    fn save(&mut self) -> fmi2Status {
        let mut state = self.saved.take().map_or(null_mut(), |saved| saved.0);
        let status = unsafe { fmi2GetFMUstate(self.c, &mut state) };
        self.saved = Some((state, self.now.clone()));
        status
    }

    /// There and back again.
    fn serialise(&self, damage: Option<usize>) -> fmi2Status {
        let Some((state, _)) = &self.saved else { return fmi2Error };
        let (mut size, mut copy) = (0, null_mut());
        assert_eq!(unsafe { fmi2SerializedFMUstateSize(self.c, *state, &mut size) }, fmi2OK);
        let mut bytes = vec![0; size];
        assert_eq!(unsafe { fmi2SerializeFMUstate(self.c, *state, bytes.as_mut_ptr(), size) }, fmi2OK);
        if let Some(place) = damage {
            bytes[place % size] ^= 0x20;
        }
        let status = unsafe { fmi2DeSerializeFMUstate(self.c, bytes.as_ptr(), size, &mut copy) };
        assert_eq!(unsafe { fmi2FreeFMUstate(self.c, &mut copy) }, fmi2OK);
        status
    }

    /// What a call that succeeded leaves behind.
    fn succeed(&mut self, call: &Call) {
        let mode = &mut self.now.mode;
        match *call {
            Call::Setup { start, stop, .. } => {
                self.now = Expected { mode: *mode, set_up: true, time: start, stop };
            }
            Call::Enter => *mode = Mode::Initialization,
            Call::Exit if self.exchange => *mode = Mode::Event,
            Call::Exit => *mode = Mode::Stepping,
            Call::Step { offset, size } => self.now.time = self.now.time + offset + size,
            Call::Restore => self.now = self.saved.as_ref().expect("there").1.clone(),
            Call::Terminate => *mode = Mode::Terminated,
            Call::Reset => self.now = Expected { mode: Mode::Instantiated, set_up: false, time: 0.0, stop: None },
            Call::Event => *mode = Mode::Event,
            Call::Continue => *mode = Mode::Continuous,
            _ => {}
        }
    }
}

fn check(program: &Program, name: &str, kind: fmi2Type, calls: &[Call]) {
    let folder = unpack(program, name);
    let c = instantiate(program, &folder, kind);
    assert!(!c.is_null());
    let now = Expected { mode: Mode::Instantiated, set_up: false, time: 0.0, stop: None };
    let mut subject = Subject { c, program: program.clone(), exchange: kind == fmi2ModelExchange, now, saved: None };
    for call in calls {
        let permitted = subject.permits(call);
        let status = subject.make(call);
        // A value that does not exist, as a quotient by zero, comes as NaN with a warning.
        let warned = status == fmi2Warning && matches!(call, Call::Get(_));
        assert!(warned || [fmi2OK, fmi2Discard, fmi2Error].contains(&status), "{call:?}: {status:?}");
        if let Some(permitted) = permitted {
            assert_eq!(warned || status == fmi2OK, permitted, "{call:?} in {:?}", subject.now);
        }
        if status == fmi2OK {
            subject.succeed(call);
        }
    }
    // SAFETY: both came from this FMU and are not used again.
    unsafe {
        let mut state = subject.saved.take().map_or(null_mut(), |saved| saved.0);
        assert_eq!(fmi2FreeFMUstate(c, &mut state), fmi2OK);
        // Whatever happened: reset, and a plain run works.
        assert_eq!(fmi2Reset(c), fmi2OK);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), fmi2OK);
        assert_eq!([fmi2EnterInitializationMode(c), fmi2ExitInitializationMode(c)], [fmi2OK; 2]);
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), fmi2OK);
        if kind == fmi2CoSimulation {
            assert_eq!(fmi2DoStep(c, 0.0, 0.01, 1), fmi2OK);
        }
        fmi2FreeInstance(c);
    }
}

/// What most tests begin with, so that runs get somewhere.
fn calls() -> impl Strategy<Value = Vec<Call>> {
    let start = || vec![Call::Setup { start: 0.0, stop: None, tolerance: None }, Call::Enter, Call::Exit];
    (any::<bool>(), proptest::collection::vec(call(), 1..60))
        .prop_map(move |(started, calls)| if started { [start(), calls].concat() } else { calls })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn co_simulation_survives_any_calls(calls in calls(), model in 0..4) {
        let program = match model {
            0 => pendulum(),
            1 => slider_crank(),
            2 => four_bar(Drive::Velocity, true),
            _ => four_bar(Drive::Position, false),
        };
        check(&program, &format!("cs{model}"), fmi2CoSimulation, &calls);
    }

    #[test]
    fn model_exchange_survives_any_calls(calls in calls(), model in 0..3) {
        let program = match model {
            0 => pendulum(),
            1 => slider_crank(),
            _ => four_bar(Drive::Time, false),
        };
        check(&program, &format!("me{model}"), fmi2ModelExchange, &calls);
    }
}
