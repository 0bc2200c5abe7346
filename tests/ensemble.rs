//! Many runs at once: each has the bits of a single run, however many threads there are.

use crate::support::ROOT;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cotree::compile::{Compiled, compile};
use cotree::run::{Ensemble, Run, Settings};
use cotree::scene::Scene;
use cotree_fmu::model::Model;

/// Time and values at the communication points, or why there are no more.
type Outcome = (Vec<f64>, Result<(), String>);

struct Study {
    compiled: Compiled,
    model: Arc<Model>,
}

impl Study {
    fn new(scene: &Scene) -> Self {
        let compiled = compile(scene).unwrap();
        let model = Arc::new(Model::new(compiled.program.clone()).unwrap());
        Self { compiled, model }
    }

    fn of(model: &str) -> Self {
        let path = format!("{ROOT}/models/{model}/scene.toml");
        Self::new(&Scene::read(path).unwrap())
    }

    fn variable(&self, name: &str) -> usize {
        self.compiled.description.variables.iter().position(|variable| variable.name == name).unwrap()
    }

    fn runs(&self, [stop, step]: [f64; 2], members: &[Settings], threads: usize) -> Vec<Outcome> {
        let description = &self.compiled.description;
        let experiment = cotree::model::Experiment { stop, step, ..description.experiment };
        let reported = self.compiled.reported();
        let run = Run { description, experiment, settings: Vec::new(), inputs: None, reported };
        let stop = AtomicBool::new(false);
        let ensemble = Ensemble::new(run, Arc::clone(&self.model), threads, &stop).unwrap();
        let collect = |all: &mut Vec<f64>, time: f64, values: &[f64]| {
            all.push(time);
            all.extend_from_slice(values);
        };
        let runs = ensemble.run(members, Vec::new, collect).into_iter();
        runs.map(|(values, ended)| (values, ended.map(drop).map_err(|error| error.to_string()))).collect()
    }
}

fn bits(runs: &[Outcome]) -> Vec<(Vec<u64>, Result<(), String>)> {
    runs.iter().map(|(values, ended)| (values.iter().map(|value| value.to_bits()).collect(), ended.clone())).collect()
}

/// Members with one variable at evenly spaced values.
fn spread(variable: usize, [from, to]: [f64; 2], count: usize) -> Vec<Settings> {
    (0..count).map(|index| vec![(variable, from + (to - from) * index as f64 / (count - 1) as f64)]).collect()
}

#[test]
fn members_are_single_runs_whatever_is_beside_them() {
    let cases = [
        ("bench_slider_crank", "crank.angle", [0.3, 0.8], [1.0, 0.05]),
        ("slider_crank", "rod_length", [1.2, 1.8], [1.0, 0.05]),
        ("andrews", "K1.angle", [-0.0618, -0.0616], [0.03, 0.001]),
        ("pendulum", "bob.angle", [0.1, 1.5], [2.0, 0.1]),
        ("double_pendulum", "upper.angle", [0.5, 2.5], [2.0, 0.1]),
        ("four_bar", "crank.angle", [0.6, 0.9], [1.0, 0.05]),
        ("excavator", "boom_mass", [300.0, 500.0], [0.5, 0.05]),
        ("cart_pole", "pole_mass", [0.1, 0.4], [2.0, 0.1]),
        ("watt_six_bar", "", [0.0, 0.0], [0.5, 0.05]),
        ("vibration", "", [0.0, 0.0], [0.5, 0.05]),
        ("metronome", "", [0.0, 0.0], [2.0, 0.1]),
        ("friction", "", [0.0, 0.0], [1.0, 0.1]),
    ];
    for (model, varied, range, times) in cases {
        let study = Study::of(model);
        let variables = &study.compiled.description.variables;
        let found = variables.iter().position(|variable| variable.name == varied);
        // Of a model without it the first of its parameters or initial values that has one.
        let members = match found {
            Some(variable) => spread(variable, range, 11),
            None => vec![Settings::new(); 11],
        };
        let all = study.runs(times, &members, 2);
        assert_eq!(bits(&study.runs(times, &members, 1)), bits(&all), "{model}");
        for (member, ours) in members.into_iter().zip(&all) {
            assert_eq!(bits(&study.runs(times, &[member], 1)), bits(std::slice::from_ref(ours)), "{model}");
        }
    }
}

/// A bar that swings from a pin.
fn swing(law: &str) -> Scene {
    let text = r#"
        format = 1
        name = "swing"
        gravity = [0.0, -9.81]
        [parameters]
        length = "1 m"
        limit = 5.0
        [inputs]
        push = { start = "0 N*m" }
        [ground.points]
        pin = [0, 0]
        [bodies.bar]
        mass = 2.0
        inertia = 0.1
        points = { pin = ["-length/2", 0] }
        [joints.pin]
        type = "revolute"
        between = ["ground.pin", "bar.pin"]
        [loads.motor]
        type = "torque"
        on = "bar"
        value = "LAW"
        [initial]
        "bar.angle" = 0.5
        [outputs]
        variables = ["bar.angle", "pin.fy"]
        [experiment]
        stop = 3.0
    "#;
    Scene::from_bytes("swing.toml".as_ref(), text.replace("LAW", law).into())
        .unwrap_or_else(|faults| panic!("{faults}"))
}

#[test]
fn a_member_that_fails_leaves_the_others_alone() {
    let study = Study::new(&swing("sqrt(limit - time)"));
    let (length, limit) = (study.variable("length"), study.variable("limit"));
    let mut members = spread(length, [0.5, 1.5], 9);
    // The law of one has no value from 1.05 s on; another has none at the start.
    members[4] = vec![(limit, 1.05)];
    members[6] = vec![(limit, -1.0)];
    let all = study.runs([3.0, 0.1], &members, 2);
    let failed = (0..9).filter(|member| all[*member].1.is_err());
    let failed: Vec<(usize, usize)> = failed.map(|member| (member, all[member].0.len())).collect();
    assert_eq!(failed, [(4, 3 * 11), (6, 0)]);
}

#[test]
fn members_are_given_by_name() {
    let study = Study::of("slider_crank");
    let variables = ["rod_length", "crank.angle"].map(|name| study.variable(name));
    let mut members: Vec<_> =
        (0..7).map(|run| vec![("rod_length", 1.2 + 0.05 * f64::from(run)), ("crank.angle", 0.5)]).collect();
    members.push(vec![("crank_length", 9.0)]); // cannot be assembled
    let found = study.compiled.simulate_many(&members).unwrap();
    assert!(found[7].is_err());
    let experiment = study.compiled.description.experiment;
    for (run, results) in found.iter().take(7).enumerate() {
        let results = results.as_ref().unwrap();
        let settings = variables.into_iter().zip(members[run].iter().map(|(_, value)| *value)).collect();
        let (rows, ended) = study.runs([experiment.stop, experiment.step], &[settings], 1).remove(0);
        assert_eq!(ended, Ok(()));
        for (index, row) in rows.chunks(1 + results.columns().len()).enumerate() {
            let values = results.columns().iter().map(|column| column.values[index]);
            assert!(row[0] == results.times()[index] && values.eq(row[1..].iter().copied()), "{run}: {row:?}");
        }
        // Among others.
        assert_eq!(study.compiled.simulate_many(&members[run..=run]).unwrap()[0].as_ref().unwrap(), results);
    }
    let wrong = study.compiled.simulate_many(&[vec![("rod_lenght", 1.0)], vec![("rod_length", 0.1)]]);
    let wrong = wrong.unwrap_err().to_string();
    assert!(wrong.contains("`rod_length`") && wrong.contains("0.1 must be at least 0.6 m"), "{wrong}");
}
