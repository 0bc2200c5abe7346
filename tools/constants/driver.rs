//! Runs the suite with half and twice every constant of the runtime, and prints what came of it as a table. An example of the copy that `constants.py rewrite` has
//! made. `constants suite` prints the runs of the suite.
#![allow(dead_code, unused_imports, reason = "of the modules of tests only scenes are used")]

#[path = "../../tests/backlash.rs"]
mod backlash;
#[path = "../../tests/coincidences.rs"]
mod coincidences;
#[path = "../../tests/engaging.rs"]
mod engaging;
#[path = "../../tests/flights.rs"]
mod flights;
#[path = "../../tests/freewheel.rs"]
mod freewheel;
#[path = "../../tests/friction_levels.rs"]
mod friction_levels;
#[path = "../../tests/lifting_cams.rs"]
mod lifting_cams;
mod modes;
#[path = "../../tests/one_sided.rs"]
mod one_sided;
#[path = "../../tests/one_sided_families.rs"]
mod one_sided_families;
#[path = "../../tests/profiles.rs"]
mod profiles;
#[path = "../../tests/rolling_on_circles.rs"]
mod rolling_on_circles;
#[path = "../../tests/ropes.rs"]
mod ropes;
#[path = "../../tests/several_frictions.rs"]
mod several_frictions;
#[path = "../../tests/support/mod.rs"]
mod support;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use cotree::compile::compile;
use cotree::run::{Ensemble, Run, Settings};
use cotree::scene::Scene;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::tuning::{self, NAMES};
use cotree_study::analysis::Study;
use support::hard::families::FAMILIES;
use support::hard::four_bar::{neutral_with_flap, stiff_at_change_points};
use support::hard::reference::Reference;
use support::hard::{Case, Outcome, Points, cases};

/// The folder of the project.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// Their references take long.
const SLOW: [&str; 6] = [
    "steep: stop",
    "steep: brake",
    "carriage far away",
    "unlike masses, branched",
    "stiff flap at change points",
    "chain with unlike masses",
];
/// Longest motion [s].
const LONGEST: f64 = 12.0;
const TOLERANCES: [f64; 3] = [1e-4, 1e-7, 1e-10];
/// The tolerance of references of cases that have none.
const TIGHT: f64 = 1e-12;
const MEMBERS: u64 = 2;
/// Most work and most looks at constants of a run of the suite.
const MOST: [u64; 2] = [3_000_000, 400_000];
/// Runs that end so are left out: those that take more, and those of methods that pass no singular poses.
const LEFT_OUT: [&str; 2] = ["endless", "only Taylor series can cross"];
/// So many times as much are endless.
const ENDLESS: u64 = 10;
/// An importer of Model Exchange integrates one in so many of the scenes with modes, by steps of this length \[s\], whose errors are about so large.
const EXCHANGED: usize = 3;
const EXCHANGE_STEP: f64 = 1e-3;
const EXCHANGE_ERROR: f64 = 1e-6;
/// Smaller errors, in tolerances, are none.
const NO_ERROR: f64 = 1e-2;
const METHODS: [&str; 6] = ["automatic", "explicit", "implicit", "ensemble", "sensitivities", "exchange"];

/// What a run gives: the error in tolerances and the bits of some results, or why there are none.
type Found = Result<(f64, Vec<u64>), String>;

struct Item {
    name: String,
    method: usize,
    run: Box<dyn Fn() -> Found>,
}

/// What came of a run.
#[derive(Clone, PartialEq)]
struct Came {
    found: Found,
    done: [u64; 2],
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let start = Instant::now();
    let mut items = items();
    eprintln!("{} runs, made in {:?}", items.len(), start.elapsed());
    std::panic::set_hook(Box::new(|_| {}));
    let show = arguments.first().is_some_and(|first| first == "suite");
    items.retain(|item| {
        let start = Instant::now();
        let came = item.come([MOST[0], MOST[1]]);
        let is_left_out = |why: &String| LEFT_OUT.iter().any(|part| why.contains(part));
        let keep = came.done[0] > 0 && !came.found.as_ref().is_err_and(is_left_out);
        if show {
            let found = match &came.found {
                Ok((error, _)) => format!("{error:.2e}"),
                Err(why) => why.lines().next().unwrap_or_default().to_owned(),
            };
            let time = start.elapsed().as_micros();
            println!("{}\t{}\t{keep}\t{:?}\t{time}\t{found}", item.name, METHODS[item.method], came.done);
        }
        keep
    });
    let start = Instant::now();
    let base: Vec<Came> = items.iter().map(|item| item.come([u64::MAX; 2])).collect();
    let failed = base.iter().filter(|came| came.found.is_err()).count();
    eprintln!("{} runs of the suite, {failed} of them fail, {:?}", items.len(), start.elapsed());
    if show {
        return;
    }
    let again: Vec<Came> = items.iter().map(|item| item.come([u64::MAX; 2])).collect();
    assert!(base == again, "not the same twice");
    let factors: Vec<f64> = arguments[0].split(',').map(|factor| factor.parse().expect("a factor")).collect();
    let known: BTreeSet<String> = arguments[1..].iter().cloned().collect();
    println!("suite\t\t1\t{}\t{failed}", items.len());
    for (place, (file, name)) in NAMES.iter().enumerate() {
        if !known.is_empty() && !known.contains(&format!("{file}:{name}")) {
            continue;
        }
        for &factor in &factors {
            let start = Instant::now();
            tuning::set(place, factor);
            let limited = |(item, base): (&Item, &Came)| item.come(base.done.map(|done| ENDLESS * done + 100_000));
            let all: Vec<Came> = items.iter().zip(&base).map(limited).collect();
            tuning::set(place, 1.0);
            println!(
                "{file}\t{name}\t{factor}\t{}\t{:.1}",
                compare(&items, &base, &all),
                start.elapsed().as_secs_f64()
            );
        }
    }
}

/// The columns of the table: runs that differ at all; new failures, failures no more, endless runs among the new; factor of the error, worst error;
/// factor of the work of all and of each method; the run with the largest change of work; what fails, what no longer fails.
fn compare(items: &[Item], base: &[Came], all: &[Came]) -> String {
    let changed = base.iter().zip(all).filter(|(base, now)| base.found != now.found || base.done[0] != now.done[0]);
    let changed = changed.count();
    let failed = base.iter().zip(all).filter(|(base, now)| base.found.is_ok() && now.found.is_err()).count();
    let healed = base.iter().zip(all).filter(|(base, now)| base.found.is_err() && now.found.is_ok()).count();
    let is_endless = |now: &&Came| now.found.as_ref().is_err_and(|why| why.contains("endless"));
    let endless = all.iter().filter(is_endless).count();
    let (mut work, mut error, mut worst) = ([[0.0; 2]; METHODS.len() + 1], [0.0; 2], 0.0_f64);
    let (mut most, mut where_most) = (0.0_f64, String::new());
    let mut other_ends = String::new();
    for ((item, base), now) in items.iter().zip(base).zip(all) {
        if base.found.is_ok() != now.found.is_ok() {
            let sign = if now.found.is_ok() { '+' } else { '-' };
            other_ends = format!("{other_ends}{sign}{}; ", item.name);
        }
        let (Ok((before, _)), Ok((after, _))) = (&base.found, &now.found) else { continue };
        let ratio = (now.done[0] as f64 / base.done[0] as f64).ln();
        for place in [item.method, METHODS.len()] {
            work[place] = [work[place][0] + ratio, work[place][1] + 1.0];
        }
        error = [error[0] + (after.max(NO_ERROR) / before.max(NO_ERROR)).ln(), error[1] + 1.0];
        worst = worst.max(*after);
        if ratio.abs() > most.abs() {
            (most, where_most) = (ratio, item.name.clone());
        }
    }
    let mean = |[sum, count]: [f64; 2]| format!("{:.5}", (sum / count).exp());
    let works: Vec<String> = work.iter().rev().map(|sum| mean(*sum)).collect();
    format!(
        "{changed}\t{failed}\t{healed}\t{endless}\t{}\t{worst:.2e}\t{}\t{where_most} {:.2}\t{other_ends}",
        mean(error),
        works.join("\t"),
        most.exp()
    )
}

impl Item {
    fn come(&self, most: [u64; 2]) -> Came {
        tuning::begin(most);
        let found = catch_unwind(AssertUnwindSafe(|| (self.run)())).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<&str>().map_or_else(|| "panic".to_owned(), |text| (*text).to_owned());
            Err(text)
        });
        Came { found, done: tuning::done() }
    }
}

fn items() -> Vec<Item> {
    let stiff = (0..2).map(neutral_with_flap);
    let loads = stiff_at_change_points(0, &[1e4, 1e6], &[1e2, 1e4]);
    let known = cases(1).into_iter().chain(stiff).chain(loads).filter(|case| case.stop <= LONGEST);
    let families = FAMILIES.iter().filter(|family| !SLOW.contains(&family.name));
    let members = families.flat_map(|family| (0..MEMBERS).map(|seed| (family.member)(seed)));
    let own = known.filter_map(compared).chain(members.filter(|case| case.stop <= LONGEST));
    let models = support::run::models().into_iter().filter_map(|name| {
        let path = format!("{ROOT}/models/{name}/scene.toml");
        let scene = Scene::read(path).expect("a scene");
        let stop = compile(&scene).expect("a sound scene").program.experiment.stop.min(2.0);
        compared(Case::new("models", scene, stop, vec![]).driven())
    });
    let modes = modes::scenes()
        .into_iter()
        .filter_map(|(scene, stop)| compared(Case::new("modes", scene, stop, vec![]).driven()));
    let mut items = Vec::new();
    for (place, case) in own.chain(models).chain(modes).enumerate() {
        if case.family == "modes" && place % EXCHANGED == 0 {
            items.extend(exchange(&case));
        }
        add(&mut items, place, case);
    }
    items.extend(["andrews", "double_pendulum", "four_bar", "metronome", "excavator"].map(ensemble));
    items.extend(SENSITIVE.into_iter().flat_map(sensitivities));
    items
}

/// A case without a reference against its own run at a tight tolerance, if it has one.
fn compared(mut case: Case) -> Option<Case> {
    if case.reference.is_some() || case.refusal.is_some() {
        return Some(case);
    }
    let names: Vec<String> = case.scene.outputs.variables.iter().map(|name| name.text.clone()).collect();
    let names = if names.is_empty() { case.laws.iter().flat_map(|law| law.variables()).collect() } else { names };
    let times: Vec<f64> = (1..=4).map(|k| case.stop * f64::from(k) / 4.0).collect();
    let model = case.model().ok()?;
    let mut instance = cotree_fmu::instance::Instance::new(model);
    let mut run = || {
        instance.setup(0.0, Some(case.stop), Some(TIGHT)).ok()?;
        instance.initialise().ok()?;
        let mut values = Vec::new();
        for &time in &times {
            instance.step_to(time).ok()?;
            values.push(
                names.iter().map(|name| support::hard::law::get(&mut instance, name).ok()).collect::<Option<_>>()?,
            );
        }
        Some(values)
    };
    if let Some(values) = run() {
        let tolerances = case.tolerances;
        case = case.against(Reference { names, times, values }).at(tolerances).within(1e6, 1e-3);
    }
    Some(case)
}

fn add(items: &mut Vec<Item>, place: usize, case: Case) {
    let Ok(model) = case.model() else { return };
    let case = Arc::new(case);
    for (index, tolerance) in TOLERANCES.into_iter().enumerate() {
        for (method, engine) in [None, Some(Engine::Dop853), Some(Engine::Radau)].into_iter().enumerate() {
            // Each of the other methods at one tolerance.
            if method > 0 && index != (place + method) % 3 || !case.tolerances.contains(&tolerance) {
                continue;
            }
            let points = [Points::Even(7), Points::Even(40), Points::Uneven(30)][(place + index) % 3];
            let (case, model) = (case.clone(), model.clone());
            let name = format!("{} at {tolerance:e}, {}", case.scene.name.text, METHODS[method]);
            let run = move || match case.run(&model, engine, tolerance, points) {
                Outcome::Passed(found) => {
                    let error = found.error.max(found.drift) / tolerance;
                    let bits = [found.error, found.drift, found.residual].map(f64::to_bits);
                    Ok((error, [&bits[..], &[found.steps, found.fallbacks]].concat()))
                }
                Outcome::Refused(why) if case.refusal.is_some() => Ok((0.0, why.bytes().map(u64::from).collect())),
                Outcome::Refused(why) | Outcome::Failed(why) => Err(why),
                Outcome::Lost(how) => Err(format!("lost: {how}")),
            };
            items.push(Item { name, method, run: Box::new(run) });
        }
    }
}

/// Model Exchange of a scene with modes up to its end, by an importer that looks for events.
fn exchange(case: &Case) -> Option<Item> {
    let (model, reference, stop) = (case.model().ok()?, case.reference.clone()?, case.stop);
    let name = format!("{}, exchange", case.scene.name.text);
    let run = move || {
        let mut instance = cotree_fmu::instance::Instance::new(model.clone());
        instance.setup(0.0, Some(stop), None).map_err(|error| error.to_string())?;
        one_sided::integrate_to_events(&mut instance, stop, EXCHANGE_STEP);
        let found = reference.names.iter().map(|name| support::hard::law::get(&mut instance, name));
        let found: Vec<f64> = found.collect::<Result<_, _>>()?;
        let error = reference.error(reference.times.len() - 1, &found) / EXCHANGE_ERROR;
        Ok((error, found.iter().map(|value| value.to_bits()).collect()))
    };
    Some(Item { name, method: 5, run: Box::new(run) })
}

/// The largest difference, relative to the largest value.
fn apart(found: &[f64], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(1e-9, |largest: f64, value| largest.max(value.abs()));
    found.iter().zip(exact).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / largest
}

/// Five runs of a model at once.
fn ensemble(name: &str) -> Item {
    const TOLERANCE: f64 = 1e-8;
    let path = format!("{ROOT}/models/{name}/scene.toml");
    let compiled = compile(&Scene::read(path).expect("a scene")).expect("a sound scene");
    let model = Arc::new(Model::new(compiled.program.clone()).expect("a sound program"));
    let all = move |tolerance: f64| -> Result<Vec<f64>, String> {
        let description = &compiled.description;
        let stop = description.experiment.stop.min(1.0);
        let experiment = cotree::model::Experiment { stop, step: stop / 10.0, tolerance, ..description.experiment };
        let run = Run { description, experiment, settings: Vec::new(), inputs: None, reported: compiled.reported() };
        let stop = AtomicBool::new(false);
        let ensemble = Ensemble::new(run, model.clone(), 1, &stop).map_err(|error| error.to_string())?;
        let collect = |all: &mut Vec<f64>, _: f64, values: &[f64]| all.extend_from_slice(values);
        let mut values = Vec::new();
        for (own, ended) in ensemble.run(&vec![Settings::new(); 5], Vec::new, collect) {
            ended.map_err(|error| error.to_string())?;
            values.extend(own);
        }
        Ok(values)
    };
    let exact = all(TIGHT).expect("a motion");
    let run = move || {
        let found = all(TOLERANCE)?;
        Ok((apart(&found, &exact) / TOLERANCE, found.iter().map(|value| value.to_bits()).collect()))
    };
    Item { name: format!("{name}, ensemble"), method: 3, run: Box::new(run) }
}

/// A model and what its motion is differentiated by.
type Sensitive = (&'static str, &'static [&'static str]);

const SENSITIVE: [Sensitive; 6] = [
    ("models/slider_crank/scene.toml", &["crank_length", "rod_length", "crank.angle", "gas_force"]),
    ("models/pendulum/scene.toml", &["bob.angle"]),
    ("tools/constants/bounce.toml", &["stiffness", "damping", "mass", "height"]),
    ("models/end_stop/scene.toml", &["torque", "restitution", "crank.angle"]),
    ("models/clutch_start/scene.toml", &["torque", "most"]),
    ("models/friction/scene.toml", &["guide.s", "pendulum.angle"]),
];

fn sensitivities((file, names): Sensitive) -> Vec<Item> {
    let path = format!("{ROOT}/{file}");
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let scene = Scene::read(&path).expect("a scene");
    let all = move |tolerance: f64| -> Result<Vec<f64>, String> {
        let mut study = Study::new(&scene).map_err(|faults| faults.render(false, 100))?;
        study.set_experiment(cotree::model::Experiment { tolerance, ..study.experiment() });
        let found = study.sensitivities(&names, &[0.0, 0.5, 1.0]).map_err(|error| error.to_string())?;
        Ok(found.derivatives.iter().flat_map(|matrix| matrix.iter().copied().collect::<Vec<_>>()).collect())
    };
    let exact = all(TIGHT).expect("derivatives");
    let of = |tolerance: f64| {
        let (all, exact) = (all.clone(), exact.clone());
        let run = move || {
            let found = all(tolerance)?;
            Ok((apart(&found, &exact) / tolerance, found.iter().map(|value| value.to_bits()).collect()))
        };
        Item { name: format!("{file} at {tolerance:e}, sensitivities"), method: 4, run: Box::new(run) }
    };
    vec![of(1e-6), of(1e-9)]
}
