//! Many runs at once: each is a single run within the tolerance, with the same bits whatever its neighbours, the lanes and the threads are.

use crate::support::ROOT;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cotree::compile::{Compiled, compile};
use cotree::scene::Scene;
use cotree::simulate::{Ensemble, Run, Settings};
use cotree_fmu::instance::{Instance, Lanes, MOST_LANES};
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

    fn runs(&self, [stop, step]: [f64; 2], members: &[Settings], threads: usize, lanes: usize) -> Vec<Outcome> {
        let description = &self.compiled.description;
        let experiment = cotree::mechanism::Experiment { stop, step, ..description.experiment };
        let reported = self.compiled.reported();
        let run = Run { description, experiment, settings: Vec::new(), inputs: None, reported };
        let stop = AtomicBool::new(false);
        let ensemble = Ensemble::new(run, Arc::clone(&self.model), (threads, lanes), &stop).unwrap();
        let collect = |all: &mut Vec<f64>, time: f64, values: &[f64]| {
            all.push(time);
            all.extend_from_slice(values);
        };
        let runs = ensemble.run(members, Vec::new, collect).into_iter();
        runs.map(|(values, ended)| (values, ended.map(drop).map_err(|error| error.to_string()))).collect()
    }

    fn has_lanes(&self) -> bool {
        Lanes::new(&self.model, 1e-6, MOST_LANES).has_lanes()
    }
}

/// The largest difference, relative to the largest value of all.
fn apart(ours: &[Outcome], other: &[Outcome]) -> f64 {
    let size = other.iter().flat_map(|(values, _)| values).fold(1.0_f64, |most, value| most.max(value.abs()));
    let pairs = ours.iter().zip(other).flat_map(|((ours, _), (other, _))| {
        assert_eq!(ours.len(), other.len());
        ours.iter().zip(other)
    });
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size
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
        ("cart_pole", "", [0.0, 0.0], [2.0, 0.1]),
        ("vibration", "", [0.0, 0.0], [0.5, 0.05]),
        ("metronome", "", [0.0, 0.0], [2.0, 0.1]),
        ("friction", "", [0.0, 0.0], [1.0, 0.1]),
    ];
    let mut in_lanes = 0;
    for (model, varied, range, times) in cases {
        let study = Study::of(model);
        let variables = &study.compiled.description.variables;
        let found = variables.iter().position(|variable| variable.name == varied);
        // Of a model without it the first of its parameters or initial values that has one.
        let members = match found {
            Some(variable) => spread(variable, range, 11),
            None => vec![Settings::new(); 11],
        };
        in_lanes += usize::from(study.has_lanes());
        let singles = study.runs(times, &members, 1, 0);
        let all = study.runs(times, &members, 1, MOST_LANES);
        let tolerance = study.compiled.description.experiment.tolerance;
        assert!(apart(&all, &singles) < 10.0 * tolerance, "{model}: {:e}", apart(&all, &singles));
        for (threads, lanes) in [(1, 1), (1, 3), (2, MOST_LANES)] {
            assert_eq!(bits(&study.runs(times, &members, threads, lanes)), bits(&all), "{model}, {threads}, {lanes}");
        }
        // Other neighbours, another order.
        let turned: Vec<Settings> = members.iter().rev().skip(3).cloned().collect();
        let mut other = study.runs(times, &turned, 1, MOST_LANES);
        other.reverse();
        assert_eq!(bits(&other), bits(&all)[..8], "{model}");
    }
    assert!(in_lanes >= 7, "{in_lanes} models run in lanes");
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
fn four_frames_and_two_loop_equations() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/four_bar/scene.toml");
    let hanging = r#"
        [bodies.bob]
        mass = 0.3
        inertia = 0.002
        points = { top = [0, 0.15] }
        [joints.hook]
        type = "revolute"
        between = ["coupler.tracer", "bob.top"]
        damping = 0.01
    "#;
    let text = std::fs::read_to_string(path).unwrap() + hanging;
    let study = Study::new(&Scene::from_bytes(path.as_ref(), text.into()).unwrap());
    assert!(study.has_lanes());
    let members = spread(study.variable("coupler_length"), [0.48, 0.52], 9);
    let times = [2.0, 0.05];
    let singles = study.runs(times, &members, 1, 0);
    let [few, many] = [3, MOST_LANES].map(|lanes| study.runs(times, &members, 1, lanes));
    assert_eq!(bits(&few), bits(&many));
    assert!(apart(&many, &singles) < 1e-7, "{:e}", apart(&many, &singles));
}

#[test]
fn very_different_members_do_not_wait_for_each_other() {
    let study = Study::new(&swing("push"));
    assert!(study.has_lanes());
    let length = study.variable("length");
    let members: Vec<Settings> = (0..23).map(|index| vec![(length, 0.02 * 1.3_f64.powi(index))]).collect();
    let (singles, all) = (study.runs([3.0, 0.1], &members, 1, 0), study.runs([3.0, 0.1], &members, 2, MOST_LANES));
    assert!(all.iter().all(|(_, ended)| ended.is_ok()));
    assert!(apart(&all, &singles) < 1e-6, "{:e}", apart(&all, &singles));
}

#[test]
fn a_member_that_fails_leaves_the_others_alone() {
    let study = Study::new(&swing("sqrt(limit - time)"));
    let (length, limit) = (study.variable("length"), study.variable("limit"));
    let mut members = spread(length, [0.5, 1.5], 9);
    // The law of one has no value from 1.05 s on; another has none at the start.
    members[4] = vec![(limit, 1.05)];
    members[6] = vec![(limit, -1.0)];
    let (singles, all) = (study.runs([3.0, 0.1], &members, 1, 0), study.runs([3.0, 0.1], &members, 1, MOST_LANES));
    let ends = |runs: &[Outcome]| runs.iter().map(|(_, ended)| ended.clone()).collect::<Vec<_>>();
    assert_eq!(ends(&all), ends(&singles));
    let failed = (0..9).filter(|member| all[*member].1.is_err());
    let failed: Vec<(usize, usize)> = failed.map(|member| (member, all[member].0.len())).collect();
    assert_eq!(failed, [(4, 3 * 11), (6, 0)]);
    assert!(apart(&all, &singles) < 1e-6);
}

/// A simulation whose input changes on the way.
struct Changing {
    instance: Instance,
    input: usize,
    force: f64,
    next: usize,
    angles: Vec<f64>,
}

impl cotree_fmu::instance::Member for Changing {
    fn instance(&mut self) -> &mut Instance {
        &mut self.instance
    }

    fn next(&mut self) -> Option<f64> {
        (self.next < 60).then_some(0.05 * (self.next + 1) as f64)
    }

    fn reach(&mut self) {
        self.instance.step_to(0.05 * (self.next + 1) as f64).unwrap();
        self.angles.push(self.instance.state().positions()[0]);
        if self.next.is_multiple_of(20) {
            self.instance.set(self.input, self.force * self.next as f64).unwrap();
        }
        self.next += 1;
    }
}

#[test]
fn inputs_change_for_one_member_only() {
    let study = Study::new(&swing("push"));
    let input = study.variable("push");
    let member = |force: f64| {
        let mut instance = Instance::new(Arc::clone(&study.model));
        instance.setup(0.0, Some(3.0), Some(1e-8)).unwrap();
        instance.initialise().unwrap();
        Changing { instance, input, force, next: 0, angles: Vec::new() }
    };
    let run = |width: usize, forces: &[f64]| {
        let mut ended = Vec::new();
        let members = forces.iter().map(|force| member(*force));
        Lanes::new(&study.model, 1e-8, width).run(members, |member| ended.push((member.force, member.angles)));
        ended.sort_by(|a, b| a.0.total_cmp(&b.0));
        ended
    };
    let forces = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
    let (singles, all) = (run(0, &forces), run(MOST_LANES, &forces));
    assert_eq!(all, run(2, &forces));
    assert_eq!(all[7..8], run(MOST_LANES, &forces[7..8]));
    for ((_, single), (_, ours)) in singles.iter().zip(&all) {
        assert!(single.iter().zip(ours).all(|(a, b)| (a - b).abs() < 1e-7));
    }
    assert!(all[0].1 != all[9].1);
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
        let (rows, ended) = study.runs([experiment.stop, experiment.step], &[settings], 1, MOST_LANES).remove(0);
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
