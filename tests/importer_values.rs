//! What importers read and set: outputs without a value, inputs without their derivatives, steps that are too much work.

use std::ffi::CString;
use std::ptr::null_mut;
use std::sync::Arc;

use cotree::compile::{Compiled, compile};
use cotree::scene::{Body, Driver, InputAs, Motion, Scene};
use cotree_fmu::fmi2::types::fmi2Status::{self, fmi2OK, fmi2Warning};
use cotree_fmu::fmi2::types::{fmi2CallbackFunctions, fmi2CoSimulation, fmi2Component};
use cotree_fmu::fmi2::*;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_study::analysis::Study;

use crate::support::chain::chain;
use crate::support::run::sound;

/// An importer of FMI 2.0 for Co-Simulation, its model initialised at zero. In all calls the component is alive, and arrays are as long as announced.
struct Importer {
    compiled: Compiled,
    c: fmi2Component,
    _folder: tempfile::TempDir,
}

impl Importer {
    fn new(scene: &Scene) -> Importer {
        let compiled = sound(compile(scene));
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("program.bin"), compiled.program.to_bytes().unwrap()).unwrap();
        let [guid, place] = [&compiled.program.guid, &format!("file://{}", folder.path().display())]
            .map(|text| CString::new(text.as_str()).unwrap());
        let callbacks = fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: null_mut(),
        };
        let name = c"importer".as_ptr();
        let c = unsafe { fmi2Instantiate(name, fmi2CoSimulation, guid.as_ptr(), place.as_ptr(), &callbacks, 0, 0) };
        assert!(!c.is_null());
        Importer { compiled, c, _folder: folder }
    }

    fn start(self) -> Importer {
        let started = unsafe {
            [
                fmi2SetupExperiment(self.c, 0, 0.0, 0.0, 0, 0.0),
                fmi2EnterInitializationMode(self.c),
                fmi2ExitInitializationMode(self.c),
            ]
        };
        assert_eq!(started, [fmi2OK; 3]);
        self
    }

    fn reference(&self, name: &str) -> u32 {
        self.compiled.program.variables.iter().position(|variable| variable.name == name).expect(name) as u32
    }

    fn get(&self, name: &str) -> (fmi2Status, f64) {
        let (reference, mut value) = (self.reference(name), 0.0);
        let status = unsafe { fmi2GetReal(self.c, &reference, 1, &mut value) };
        (status, value)
    }

    fn set(&self, name: &str, value: f64) {
        let reference = self.reference(name);
        assert_eq!(unsafe { fmi2SetReal(self.c, &reference, 1, &value) }, fmi2OK);
    }

    fn set_rate(&self, name: &str, rate: f64) {
        let reference = self.reference(name);
        assert_eq!(unsafe { fmi2SetRealInputDerivatives(self.c, &reference, 1, &1, &rate) }, fmi2OK);
    }

    fn step(&self, time: f64, step: f64) -> fmi2Status {
        unsafe { fmi2DoStep(self.c, time, step, 1) }
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.c) };
    }
}

/// A block at x = t - 1/2, and what is made of x.
fn passing() -> Scene {
    let scene = Scene::new("passing")
        .body("block", Body::new().mass(2.0))
        .prismatic("guide", "ground", "block", [1.0, 0.0])
        .driver("motor", Driver::displacement("guide", "1[m/s]*t - 0.5[m]"))
        .output("block.x")
        .stop(1.0)
        .step(0.25);
    let outputs = [
        ("inverse", "1[m]/block.x"),
        ("square", "(block.x/1[m])^(-2)"),
        ("root", "sqrt(block.x/1[m])"),
        ("logarithm", "log(block.x/1[m])"),
        ("cotangent", "1/tan(block.x/1[m])"),
    ];
    outputs.iter().fold(scene, |scene, (name, value)| scene.output_expression(name, *value))
}

#[test]
fn outputs_without_a_value_are_nothing_at_that_time_only() {
    let compiled = sound(compile(&passing()));
    assert_eq!(compiled.without_value_at_start(), ["root", "logarithm"]);
    let found = compiled.simulate().expect("the motion goes on");
    assert_eq!(found.times(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    let missing = |name: &str| -> Vec<bool> { found.get(name).unwrap().iter().map(|value| value.is_nan()).collect() };
    for name in ["inverse", "square", "cotangent"] {
        assert_eq!(missing(name), [false, false, true, false, false], "{name}");
    }
    assert_eq!(missing("root"), [true, true, false, false, false]);
    assert_eq!(missing("logarithm"), [true, true, true, false, false]);
    let last = |name: &str| *found.get(name).unwrap().last().unwrap();
    assert_eq!(["inverse", "square"].map(last), [2.0, 4.0]);
    assert!(
        (last("logarithm") - 0.5_f64.ln()).abs() < 1e-15 && (last("cotangent") - 1.0 / 0.5_f64.tan()).abs() < 1e-15
    );
    let mut table = Vec::new();
    found.write_csv(&mut table).unwrap();
    let table = String::from_utf8(table).unwrap();
    assert!(table.contains("\n0.5,0.0,,,0.0,,\n"), "{table}");
}

#[test]
fn importers_read_nan_with_a_warning_and_go_on() {
    let importer = Importer::new(&passing()).start();
    assert_eq!(importer.get("inverse"), (fmi2OK, -2.0));
    assert_eq!(importer.step(0.0, 0.5), fmi2OK);
    let (status, value) = importer.get("inverse");
    assert!(status == fmi2Warning && value.is_nan());
    assert_eq!(importer.get("block.x"), (fmi2OK, 0.0));
    assert_eq!([importer.step(0.5, 0.25), importer.step(0.75, 0.25)], [fmi2OK; 2]);
    assert_eq!(importer.get("inverse"), (fmi2OK, 2.0));
}

/// At rest drivers are numbers, and so is what outputs make of them: 1/0 among them.
#[test]
fn what_rests_needs_no_output() {
    let scene = Scene::new("resting")
        .body("lever", Body::new().mass(2.0).inertia(0.1).point("tip", [0.3, 0.0]))
        .revolute("pin", "ground", "lever")
        .driver("motor", Driver::angle("pin", "0.4*sin(3*t)"))
        .output_expression("steep", "1/(0.4*sin(3*t)) + 1/tan(pin.angle)")
        .stop(1.0);
    let found = Study::new(&scene).unwrap().equilibrium().unwrap();
    assert_eq!(found.value("lever.angle"), Some(0.0));
}

/// A lever whose angle is an input, its mass centre 0.2 m from the pin.
fn lever() -> Scene {
    Scene::new("lever")
        .gravity([0.0, -9.81])
        .input("measured", 0.1)
        .body("lever", Body::new().mass(3.0).inertia(0.05).point("pin", [-0.2, 0.0]))
        .revolute("pin", "ground", "lever.pin")
        .driver("motor", Driver::angle("pin", Motion::follows("measured", InputAs::Position)))
        .output("lever.omega")
        .output("motor.torque")
        .stop(1.0)
}

fn angle(time: f64) -> f64 {
    0.1 + 0.7 * time - 0.9 * time * time
}

/// What turns the lever so: (I + m r^2) alpha + m g r cos(angle).
fn torque(time: f64, acceleration: f64) -> f64 {
    (0.05 + 3.0 * 0.04) * acceleration + 3.0 * 9.81 * 0.2 * angle(time).cos()
}

#[test]
fn differences_of_a_parabola_are_its_derivatives() {
    let importer = Importer::new(&lever()).start();
    let steps = [0.05, 0.05, 0.1, 0.02, 0.08, 0.1, 0.1];
    let mut time = 0.0;
    for (done, step) in steps.into_iter().enumerate() {
        importer.set("measured", angle(time));
        // Three values make a parabola.
        let known = done >= 2;
        assert_eq!(importer.step(time, step), fmi2OK);
        time += step;
        let expected = if known { 0.7 - 1.8 * time } else { 0.0 };
        let (_, omega) = importer.get("lever.omega");
        assert!((omega - expected).abs() < 1e-11, "{omega} at {time} s, not {expected}");
        if known {
            let (_, found) = importer.get("motor.torque");
            assert!((found - torque(time, -1.8)).abs() < 1e-9, "{found} at {time} s, not {}", torque(time, -1.8));
        }
    }
}

#[test]
fn jumps_are_jumps_and_repeated_values_rest() {
    let importer = Importer::new(&lever()).start();
    for step in 0..12 {
        let time = 0.1 * f64::from(step);
        // Set at every point at first, then at changes only: the same.
        if step < 6 || step == 8 {
            importer.set(
                "measured",
                if step < 3 {
                    0.1
                } else if step < 8 {
                    0.3
                } else {
                    0.25
                },
            );
        }
        assert_eq!(importer.step(time, 0.1), fmi2OK);
        assert_eq!(importer.get("lever.omega"), (fmi2OK, 0.0), "after {step} steps");
    }
    let (_, torque) = importer.get("motor.torque");
    assert!((torque - 3.0 * 9.81 * 0.2 * 0.25_f64.cos()).abs() < 1e-12);
}

#[test]
fn derivatives_that_are_given_come_first() {
    let importer = Importer::new(&lever()).start();
    for step in 0..6 {
        let time = 0.1 * f64::from(step);
        importer.set("measured", angle(time));
        importer.set_rate("measured", 0.5);
        assert_eq!(importer.step(time, 0.1), fmi2OK);
        let (_, omega) = importer.get("lever.omega");
        assert!((omega - 0.5).abs() < 1e-12, "{omega}");
    }
}

#[test]
fn a_saved_state_keeps_the_values_before() {
    let importer = Importer::new(&lever()).start();
    let go = |step: u32| {
        let time = 0.1 * f64::from(step);
        importer.set("measured", angle(time) + 0.02 * time.powi(4));
        assert_eq!(importer.step(time, 0.1), fmi2OK);
        ["lever.omega", "motor.torque"].map(|name| importer.get(name).1.to_bits())
    };
    (0..4).for_each(|step| {
        go(step);
    });
    let mut state = null_mut();
    assert_eq!(unsafe { fmi2GetFMUstate(importer.c, &mut state) }, fmi2OK);
    let after: Vec<_> = (4..8).map(go).collect();
    assert_eq!(unsafe { fmi2SetFMUstate(importer.c, state) }, fmi2OK);
    assert_eq!((4..8).map(go).collect::<Vec<_>>(), after);
    assert_eq!(unsafe { fmi2FreeFMUstate(importer.c, &mut state) }, fmi2OK);
}

/// A step that is too much work ends early, with what it has done; the run goes on from there.
#[test]
fn steps_that_are_too_much_work_keep_what_is_done() {
    let model = Arc::new(Model::new(sound(compile(&chain(3))).program).unwrap());
    let started = || {
        let mut instance = Instance::new(Arc::clone(&model));
        instance.setup(0.0, None, Some(1e-8)).unwrap();
        instance.initialise().unwrap();
        instance
    };
    let (mut free, mut limited) = (started(), started());
    free.step_to(1.0).unwrap();
    let work = free.statistics().work;
    assert!(work > 0);
    limited.limit_work(work / 4);
    let mut ends = vec![0.0];
    while limited.time() < 1.0 {
        match limited.step_to(1.0) {
            Ok(()) => {}
            Err(error @ InstanceError::Solver(_)) if error.is_unfinished() => {
                assert!(error.to_string().contains(&format!("at t = {} s", limited.time())), "{error}");
            }
            Err(error) => panic!("{error}"),
        }
        assert!(limited.time() > *ends.last().unwrap(), "{ends:?}");
        ends.push(limited.time());
    }
    assert!((4..=8).contains(&ends.len()), "{ends:?}");
    let [one, other] = [&free, &limited].map(|instance| instance.state().positions().to_vec());
    one.iter().zip(&other).for_each(|(one, other)| assert!((one - other).abs() < 1e-6, "{one} {other}"));
}
