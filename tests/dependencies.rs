//! The dependencies that the model description declares: nothing that changes a variable is missing. What they list besides may have no effect
//! where terms cancel, but never crosses from one mechanism of a scene to another.

use crate::support::large_scenes;

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::support::random_parts::random_parts;
use crate::support::run::{models, scene_of};
use cotree::compile::compile;
use cotree::export::description::{Causality, Description, ScalarVariable, StartValue};
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use large_scenes::{arms, parallelograms, two_chains};

const APART: &str = include_str!("scenes/dependencies/apart.toml");
const DRIVEN: &str = include_str!("scenes/dependencies/three_driven.toml");
const PARALLELOGRAM: &str = include_str!("scenes/dependencies/parallelogram.toml");
const HALF_KNOWN: &str = include_str!("scenes/dependencies/half_known.toml");
const FOLLOWED: &str = include_str!("scenes/dependencies/followed.toml");
const DRIVEN_ARM: &str = include_str!("scenes/dependencies/driven_arm.toml");

fn scenes() -> Vec<(String, String)> {
    let mut scenes: Vec<_> = models().into_iter().map(|name| (name.clone(), scene_of(&name))).collect();
    scenes.push(("apart".to_owned(), APART.to_owned()));
    scenes.push(("three driven".to_owned(), DRIVEN.to_owned()));
    scenes.push(("stiff".to_owned(), include_str!("scenes/stiff.toml").to_owned()));
    scenes.extend((1..=RANDOM).map(|seed| (format!("random {seed}"), random_parts(seed, 2).scene)));
    let large = [("two chains", two_chains(55)), ("arms", arms(36)), ("parallelograms", parallelograms(16))];
    scenes.extend(large.map(|(name, text)| (name.to_owned(), text)));
    scenes
}

/// So many random mechanisms with gears, racks, slots, rolling discs and distance links.
const RANDOM: u64 = 8;

/// What a calculated variable changes with, of all states and inputs, at some states and with some parameters of the model.
fn found(model: &Arc<Model>, description: &Description) -> Vec<BTreeSet<usize>> {
    let calculated: Vec<usize> = (0..description.variables.len()).filter(|&v| is_calculated(description, v)).collect();
    let mut found = vec![BTreeSet::new(); description.variables.len()];
    for sample in 0..5 {
        let Some(mut instance) = somewhere(model, description, sample) else { continue };
        let mut slopes = vec![Vec::new(); description.variables.len()];
        for known in 0..description.variables.len() {
            if matches!(description.variables[known].causality, Causality::Parameter { .. }) {
                continue;
            }
            instance.begin_direction();
            if instance.add_direction(known, 1.0).is_err() || instance.differentiate().is_err() {
                continue;
            }
            for &unknown in &calculated {
                slopes[unknown].extend(instance.derivative(unknown).ok().map(|slope| (known, slope)));
            }
        }
        for (known, unknown) in with_rates(&mut instance, description, &calculated) {
            found[unknown].insert(known);
        }
        for (unknown, slopes) in slopes.into_iter().enumerate() {
            let largest = slopes.iter().fold(0.0, |largest: f64, (_, slope)| largest.max(slope.abs()));
            // Rounding errors of what cancels are far below, and nothing that counts here is that small.
            let count = slopes.into_iter().filter(|(_, slope)| slope.abs() > 1e-10 * largest.max(1e-3));
            found[unknown].extend(count.map(|(known, _)| known));
        }
    }
    found
}

/// Inputs, and what changes when only their derivatives change: a driver hands these on as rates and accelerations.
fn with_rates(instance: &mut Instance, description: &Description, calculated: &[usize]) -> Vec<(usize, usize)> {
    let mut changed = Vec::new();
    for known in 0..description.variables.len() {
        for order in 1..=2 {
            let mut at = |derivative: f64| -> Vec<f64> {
                if instance.set_derivative(known, order, derivative).is_err() {
                    return Vec::new();
                }
                calculated.iter().map(|&unknown| instance.get(unknown).unwrap_or_default()).collect()
            };
            let (before, after) = (at(0.3), at(0.8));
            for ((&unknown, before), after) in calculated.iter().zip(before).zip(after) {
                if (after - before).abs() > 1e-9 * before.abs().max(1e-3) {
                    changed.push((known, unknown));
                }
            }
        }
    }
    changed
}

/// The model at a state, off the loops too: each state counts by itself.
fn somewhere(model: &Arc<Model>, description: &Description, sample: u32) -> Option<Instance> {
    let random = |place: usize| 0.5 + 0.5 * f64::sin(f64::from(7 * place as u32 + 13 * sample + 1));
    let mut instance = Instance::new(model.clone());
    for (place, variable) in description.variables.iter().enumerate() {
        match variable.causality {
            Causality::Parameter { start, min, max } => {
                let value = if start == 0.0 { random(place) } else { start * (0.95 + 0.1 * random(place)) };
                let value = value.max(min.unwrap_or(f64::NEG_INFINITY)).min(max.unwrap_or(f64::INFINITY));
                instance.set(place, value).ok()?;
            }
            Causality::Input { start, min, max } => {
                let value = start + 0.1 * random(place);
                let value = value.max(min.unwrap_or(f64::NEG_INFINITY)).min(max.unwrap_or(f64::INFINITY));
                instance.set(place, value).ok()?;
                instance.set_derivative(place, 1, random(place + 1)).ok()?;
                instance.set_derivative(place, 2, random(place + 2)).ok()?;
            }
            _ => (),
        }
    }
    match instance.initialise_exchange() {
        // A driver follows an input: there are no states to be set from outside.
        Err(InstanceError::NoExchange) => return instance.initialise().ok().map(|()| instance),
        result => result.ok()?,
    }
    let mut states = vec![0.0; instance.state_count()];
    instance.states(&mut states).ok()?;
    states.iter_mut().enumerate().for_each(|(place, state)| *state += 0.6 * (random(place + 100) - 0.4));
    if !states.is_empty() {
        instance.set_states(&states).ok()?;
    }
    Some(instance)
}

fn is_calculated(description: &Description, variable: usize) -> bool {
    matches!(description.variables[variable].causality, Causality::Output | Causality::Local)
}

#[test]
fn every_derivative_that_is_not_zero_is_listed() {
    let mut wrong = Vec::new();
    for (name, text) in scenes() {
        let compiled = compile(&Scene::from_toml(&text).expect("a scene")).expect("a model");
        let description = &compiled.description;
        let model = Arc::new(Model::new(compiled.program.clone()).expect("a program"));
        let found = found(&model, description);
        for (variable, found) in description.variables.iter().zip(found) {
            let declared: BTreeSet<usize> = variable.dependencies.iter().copied().collect();
            let words = |set: BTreeSet<usize>| -> Vec<&str> {
                set.into_iter().map(|index| description.variables[index].name.as_str()).collect()
            };
            let missing = words(&found - &declared);
            if !missing.is_empty() {
                wrong.push(format!("{name}: `{}` also depends on {missing:?}", variable.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What the initial state follows from, with its defaults: parameters, inputs and known initial values.
fn knowns(description: &Description) -> Vec<(usize, f64)> {
    let start = |variable: &ScalarVariable| match (variable.causality, variable.start) {
        (Causality::Parameter { start, .. } | Causality::Input { start, .. }, _) => Some(start),
        (_, Some(StartValue::Exact(start))) => Some(start),
        _ => None,
    };
    let all = description.variables.iter().enumerate();
    all.filter_map(|(place, variable)| Some((place, start(variable)?))).collect()
}

/// A value that is set before initialisation: of a variable, or of an input's first or second derivative.
type Setting = (usize, i32, f64);

/// Everything that is calculated, at the start that follows from these values, before anything has ticked there.
fn at_the_start(model: &Arc<Model>, values: &[Setting], calculated: &[usize]) -> Option<Vec<f64>> {
    let mut instance = Instance::new(model.clone());
    let mut set = |&(known, order, value): &Setting| match order {
        0 => instance.set(known, value),
        order => instance.set_derivative(known, order, value),
    };
    values.iter().try_for_each(&mut set).ok()?;
    instance.clone().initialise().ok()?;
    Some(calculated.iter().map(|&unknown| instance.get(unknown).unwrap_or(f64::NAN)).collect())
}

/// What is set near the defaults, as far away as the loops can follow, and what follows from it.
fn start_near(
    model: &Arc<Model>,
    description: &Description,
    unknowns: &[usize],
    (sample, by): (u32, &[f64]),
) -> Option<(Vec<Setting>, Vec<f64>)> {
    let random = |place: usize| f64::sin(f64::from(7 * place as u32 + 13 * sample + 1));
    by.iter().find_map(|by| {
        let mut values = Vec::new();
        for (place, start) in knowns(description) {
            values.push((place, 0, start + by * if start == 0.0 { 1.0 } else { start } * random(place)));
            if matches!(description.variables[place].causality, Causality::Input { .. }) {
                values.extend([1, 2].map(|order| (place, order, random(place + order as usize))));
            }
        }
        at_the_start(model, &values, unknowns).map(|after| (values, after))
    })
}

/// How far parameters, inputs and known values are moved from their defaults: as far as the loops can follow.
const FAR: [f64; 4] = [0.1, 0.01, 1e-3, 0.0];

/// Where the equations leave the start open, too: then it follows from how the search for it goes.
#[test]
fn derivatives_of_the_start_are_those_that_differences_show() {
    for (name, text) in scenes().into_iter().chain(start_scenes()) {
        let compiled = compile(&Scene::from_toml(&text).expect("a scene")).expect("a model");
        let description = &compiled.description;
        let model = Arc::new(Model::new(compiled.program.clone()).expect("a program"));
        let unknowns: Vec<usize> =
            (0..description.variables.len()).filter(|&place| is_calculated(description, place)).collect();
        let (values, _) = start_near(&model, description, &unknowns, (1, &FAR)).expect("a start");
        for (index, &(known, order, value)) in values.iter().enumerate() {
            if order > 0 {
                continue;
            }
            let at = |by: f64| {
                let mut moved = values.clone();
                moved[index].2 += by;
                at_the_start(&model, &moved, &unknowns)
            };
            let size = if value.abs() < 0.1 { 1.0 } else { value };
            // Short steps where the start bends, long ones where it is rounded.
            let tried: Vec<Vec<[f64; 2]>> = [1e-3, 2e-4].iter().filter_map(|step| slopes_by(at, step * size)).collect();
            if tried.is_empty() {
                continue;
            }
            let slopes = start_slopes(&model, &values, known, &unknowns);
            for (place, (&unknown, slope)) in unknowns.iter().zip(slopes).enumerate() {
                let names = (&description.variables[unknown].name, &description.variables[known].name);
                let found: Vec<[f64; 2]> = tried.iter().map(|of| of[place]).collect();
                let agrees = found.iter().any(|[difference, bound]| (slope - difference).abs() <= *bound);
                assert!(agrees, "{name}: {names:?}: {slope} for {found:?}");
            }
        }
    }
}

/// Differences of fourth order for each unknown, and how far they may be off; none where there is no start.
fn slopes_by(at: impl Fn(f64) -> Option<Vec<f64>>, step: f64) -> Option<Vec<[f64; 2]>> {
    let [a, b, c, d] = [at(-step)?, at(-step / 2.0)?, at(step / 2.0)?, at(step)?];
    let slope = |place: usize| {
        let near = (c[place] - b[place]) / step;
        let far = (d[place] - a[place]) / (2.0 * step);
        let difference = (4.0 * near - far) / 3.0;
        let size = difference.abs().max((a[place].abs() + d[place].abs()) * 1e-2).max(1.0);
        [difference, 1e-7 * size + 1e-2 * (near - far).abs()]
    };
    Some((0..a.len()).map(slope).collect())
}

/// Directional derivatives at the start that follows from these values.
fn start_slopes(model: &Arc<Model>, values: &[Setting], known: usize, unknowns: &[usize]) -> Vec<f64> {
    let mut instance = Instance::new(model.clone());
    for &(known, order, value) in values {
        match order {
            0 => instance.set(known, value).expect("settable"),
            order => instance.set_derivative(known, order, value).expect("an input"),
        }
    }
    instance.begin_direction();
    instance.add_direction(known, 1.0).expect("known");
    instance.differentiate().expect("a start");
    unknowns.iter().map(|&unknown| instance.derivative(unknown).expect("defined")).collect()
}

/// Scenes in which much cancels at the start, or is left open.
fn start_scenes() -> Vec<(String, String)> {
    let own =
        [("parallelogram", PARALLELOGRAM), ("half known", HALF_KNOWN), ("followed", FOLLOWED), ("arm", DRIVEN_ARM)];
    own.map(|(name, text)| (name.to_owned(), text.to_owned())).into()
}

#[test]
fn what_is_apart_stays_apart_while_it_moves() {
    let variables = compile(&Scene::from_toml(APART).expect("a scene")).expect("a model").description.variables;
    let own = |name: &str, place: usize| !variables[place].name.starts_with(name);
    for variable in &variables {
        let apart = match variable.name.split(['.', '_']).next() {
            Some("left") => variable.dependencies.iter().all(|&place| own("right", place)),
            Some("right") => variable.dependencies.iter().all(|&place| own("left", place) && own("torque", place)),
            _ => true,
        };
        assert!(apart, "{variable:?}");
        assert!(!variable.name.ends_with(".alpha") || !variable.dependencies.is_empty(), "{variable:?}");
    }
}

/// The velocity that a driver follows does not move the mechanism at once: an importer must not see a loop there.
#[test]
fn what_a_driver_integrates_does_not_depend_on_its_input() {
    // The acceleration is the rate of a velocity that is followed.
    for (order, dependent) in
        [("velocity", ["crank.omega", "crank.alpha", "speed"].as_slice()), ("acceleration", &["crank.alpha"])]
    {
        let text = format!(
            r#"
            format = 1
            name = "driven"
            [inputs]
            signal = 0.5
            [bodies.crank]
            points = {{ pin = [-1, 0], tip = [1, 0] }}
            [joints.bearing]
            type = "revolute"
            between = ["ground", "crank.pin"]
            [drivers.motor]
            joint = "bearing"
            angle = {{ input = "signal", as = "{order}" }}
            [initial]
            "crank.angle" = 0.3
            [outputs]
            variables = ["crank.angle", "crank.omega", "crank.alpha", "crank.tip.x"]
            speed = "crank.tip.vx"
            "#
        );
        let compiled = compile(&Scene::from_toml(&text).expect("a scene")).expect("a model");
        let variables = compiled.description.variables.clone();
        let signal = variables.iter().position(|variable| variable.name == "signal").expect("an input");
        let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a program")));
        instance.initialise().expect("consistent");
        instance.step_to(0.2).expect("regular");
        let mut read = |change: f64| -> Vec<u64> {
            instance.set(signal, 0.5 + change).expect("an input");
            (0..variables.len()).map(|place| instance.get(place).expect("defined").to_bits()).collect()
        };
        let (before, after) = (read(0.0), read(0.25));
        for (place, variable) in variables.iter().enumerate().filter(|&(place, _)| place != signal) {
            let listed = variable.dependencies.contains(&signal);
            assert_eq!(dependent.contains(&variable.name.as_str()), listed, "{order}: {}", variable.name);
            assert!(listed || before[place] == after[place], "{order}: {}", variable.name);
        }
    }
}
