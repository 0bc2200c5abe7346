//! Runs whose own results contradict each other are wrong, even without a reference: loops must be closed, all of them; rates must change as the accelerations say that the tapes
//! find; and where nothing drives or dissipates, the energy must stay.

use std::sync::Arc;

use crate::support::hard::cases;
use crate::support::power::PowerBalance;
use crate::support::random::{Family, random_case};
use crate::support::run::{mechanism, models, scene_of, sound, started, value};
use cotree::compile::{compile, compile_asking};
use cotree::model::Mechanism;
use cotree::scene::{Requested, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Source;

const TOLERANCE: f64 = 1e-9;
/// How often a run is looked at, and how long the rates are compared, as a share of the run; fast mechanisms for as long as they move by so much.
const PLACES: usize = 16;
const SHORT: f64 = 2e-5;
const MOVED: f64 = 1e-3;
/// So many of these may lie across a switch or a corner of a law.
const SWITCHES: usize = PLACES / 4;
const RESIDUAL: &str = "constraint.position";
const ENERGY: &str = "energy.total";
const KINETIC: &str = "energy.kinetic";

/// A run that is watched; the energy stays if `conserves`.
struct Watched {
    name: String,
    scene: Scene,
    stop: f64,
    conserves: bool,
}

/// Does nothing drive or dissipate? What engages takes energy, which tests/engaging.rs compares.
fn conserves(mechanism: &Mechanism) -> bool {
    let still = mechanism.drivers.is_empty() && mechanism.inputs.is_empty() && !mechanism.has_impulses();
    let stores = mechanism.loads.iter().all(|load| load.energy().is_some());
    let resists = |key: &str| ["damping", "friction", "drag"].iter().any(|word| key.contains(word));
    let parts = || mechanism.joints.iter().chain(&mechanism.loads);
    still && stores && !parts().flat_map(|part| &part.values).any(|(key, _)| resists(key))
}

fn watched() -> Vec<Watched> {
    let of_models = models().into_iter().map(|name| {
        let scene = Scene::from_toml(&scene_of(&name)).unwrap_or_else(|faults| panic!("{faults}"));
        let mechanism = scene.resolve().unwrap_or_else(|faults| panic!("{faults}")).mechanism;
        Watched { name, stop: mechanism.experiment.stop, conserves: conserves(&mechanism), scene }
    });
    let hard = cases(1).into_iter().filter(|case| case.refusal.is_none() && case.input.is_none());
    let of_hard = hard.map(|case| Watched {
        name: case.family.to_owned(),
        stop: case.stop,
        conserves: case.conservative,
        scene: case.scene,
    });
    of_models.chain(of_hard).collect()
}

/// What contradicts itself in a run; how many places were compared.
fn contradictions(run: &Watched) -> (Vec<String>, usize) {
    let watched = if run.conserves { &[RESIDUAL, ENERGY, KINETIC][..] } else { &[RESIDUAL] };
    let mut scene = run.scene.clone();
    for name in watched {
        let requested = scene.outputs.variables.iter().any(|known| known.text == *name);
        scene = if requested { scene } else { scene.output(name) };
    }
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}: {}", run.name, faults.render(false, 100)));
    let start = compiled.program.experiment.start;
    let model = Arc::new(Model::new(compiled.program).expect("a sound program"));
    let mut instance = Instance::new(model.clone());
    instance.setup(start, Some(run.stop), Some(TOLERANCE)).expect("times");
    if let Err(error) = instance.initialise() {
        return (vec![error.to_string()], 0);
    }
    let before = run.conserves.then(|| value(&mut instance, ENERGY));
    let (mut wrong, mut unlike, mut compared) = (Vec::new(), Vec::new(), 0);
    let (length, short) = (run.stop - start, SHORT * (run.stop - start));
    for place in 0..PLACES {
        let time = start + length * (place as f64 + 0.37) / (PLACES as f64 + 1.0);
        // Where a run ends with a reason, nothing is said any more.
        let Some(found) = rates(&model, &mut instance, time, short) else { break };
        compared += 1;
        unlike.extend(found);
        let open = value(&mut instance, RESIDUAL);
        if open > TOLERANCE * model.program().length.max(1.0) {
            wrong.push(format!("t = {time}: loops are open by {open:e}"));
        }
        if let Some(before) = before {
            let (now, size) = (value(&mut instance, ENERGY), value(&mut instance, KINETIC).abs());
            let near = (now - before).abs() <= 1e-5 * (before.abs() + size).max(1e-3);
            if !near {
                wrong.push(format!("t = {time}: the energy {before} becomes {now}"));
            }
        }
    }
    if unlike.len() > SWITCHES {
        wrong.append(&mut unlike);
    }
    (wrong, compared)
}

/// Rates that change otherwise than the accelerations say (Simpson's rule); none if the run ends.
fn rates(model: &Model, instance: &mut Instance, time: f64, short: f64) -> Option<Option<String>> {
    let accelerations: Vec<(usize, usize)> = model
        .program()
        .variables
        .iter()
        .enumerate()
        .filter_map(|(index, variable)| match variable.source {
            Source::Acceleration(place) => Some((index, place as usize)),
            _ => None,
        })
        .collect();
    instance.step_to(time).ok()?;
    let fastest = instance
        .state()
        .rates()
        .iter()
        .zip(&model.program().coordinates)
        .fold(0.0, |most: f64, (rate, own)| most.max(rate.abs() / own.scale));
    let short = short.min(MOVED / fastest.max(1.0));
    let mut seen = Vec::new();
    for step in 0..3 {
        if step > 0 {
            instance.step_to(time + f64::from(step) * short).ok()?;
        }
        let state = instance.state();
        let now: Option<Vec<[f64; 2]>> = accelerations
            .iter()
            .map(|&(index, place)| Some([state.rates()[place], instance.get(index).ok()?]))
            .collect();
        seen.push(now?);
    }
    let found = (0..accelerations.len()).find_map(|place| {
        let [[v, a], [_, b], [w, c]] = [0, 1, 2].map(|step: usize| seen[step][place]);
        let (change, expected) = (w - v, short / 3.0 * (a + 4.0 * b + c));
        let size = 1e-7 * (1.0 + v.abs()) + 1e-3 * short * (a.abs() + b.abs() + c.abs());
        // Written so that NaN is a contradiction.
        let agrees = (change - expected).abs() <= size;
        (!agrees).then(|| {
            let name = &model.program().variables[accelerations[place].0].name;
            format!("t = {time}: `{name}` adds up to {expected:e}, the rate changes by {change:e}")
        })
    });
    Some(found)
}

#[test]
fn no_run_contradicts_itself() {
    let (mut wrong, mut compared, mut conserving) = (Vec::new(), 0, 0);
    for run in watched() {
        let (found, places) = contradictions(&run);
        compared += places;
        conserving += usize::from(run.conserves);
        if !found.is_empty() {
            wrong.push(format!("{}: {}", run.name, found.join("; ")));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(compared > 600 && conserving > 10, "{compared} places, {conserving} runs that conserve energy");
}

/// What bodies gain in energy is what gravity, joints, drivers and loads put in, at any time of any run: forces that the equations leave out would show.
#[test]
fn random_mechanisms_keep_the_balance_of_power() {
    for family in [Family::Chain, Family::Tree, Family::Loops, Family::Driven] {
        for seed in 0..20 {
            let text = random_case(seed, family).scene;
            let balance = PowerBalance::new(&mechanism(&text));
            let scene = sound(Scene::from_toml(&text));
            let (compiled, _) = sound(compile_asking(&scene, &Requested::Also(balance.names())));
            let model = Arc::new(Model::new(compiled.program).unwrap());
            let mut instance = started(&model, None, 0.04, TOLERANCE);
            for time in [0.0, 0.02, 0.04] {
                if time > 0.0 {
                    instance.step_to(time).unwrap();
                }
                let gap = balance.gap(&mut instance);
                assert!(gap < 1e-8, "{family:?} {seed} at {time} s: {gap:e}\n{text}");
            }
        }
    }
}
