//! Simulations side by side have the bits that each has alone, whatever their neighbours do.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cotree_fmu::instance::{Batch, Instance, InstanceError, Snapshot};
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;

/// Groups of each model, legs of each way, and communication points of the first member in a leg.
const GROUPS: u64 = 6;
const LEGS: u32 = 4;
const POINTS: u32 = 2;

/// Mechanisms with loops and without, with kernels of few frames and in general, of which many series are begun together.
const OFTEN: [&str; 5] = ["bench_slider_crank", "cart_pole", "double_pendulum", "four_bar", "whitworth"];

/// Numbers between -1 and 1 that are the same in every run (a linear congruential generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn programs() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs");
    let entries = fs::read_dir(folder).expect("stored programs");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths
}

/// A simulation that has begun with values of its own, and a stop of its own; none if it cannot begin.
fn begun(model: &Arc<Model>, numbers: &mut Numbers, tolerance: f64) -> Option<Instance> {
    let mut instance = Instance::new(Arc::clone(model));
    let experiment = &model.program().experiment;
    let share = if numbers.next() > 0.5 { 0.6 } else { 1.0 };
    let stop = experiment.start + share * (experiment.stop - experiment.start);
    instance.setup(experiment.start, Some(stop), Some(tolerance)).expect("times");
    for variable in &model.program().parameters {
        let spread = if numbers.next() > 0.7 { 0.4 } else { 0.03 };
        let value = variable.start * (1.0 + spread * numbers.next());
        if let Some(index) = instance.variable(&variable.name) {
            // Not every value is permitted.
            let _ = instance.set(index, value);
        }
    }
    instance.initialise().ok().map(|()| instance)
}

/// Everything that its future depends on.
fn bytes(instance: &Instance) -> Vec<u8> {
    let snapshot: Snapshot = instance.clone().save();
    snapshot.to_bytes().expect("a sound state")
}

fn assert_same(
    name: &str,
    time: f64,
    (alone, done): (&Instance, &Result<(), InstanceError>),
    (together, found): (&Instance, &Result<(), InstanceError>),
) {
    assert_eq!(done, found, "{name} at {time} s");
    assert_eq!(alone.statistics(), together.statistics(), "{name} at {time} s");
    assert!(bytes(alone) == bytes(together), "{name} at {time} s");
}

/// Moves simulations side by side and alone; says how many series were found together, and how many were begun so.
fn compare(name: &str, model: &Arc<Model>, seed: u64) -> [u64; 2] {
    let mut batches = [(); 2].map(|()| Batch::new(model).expect("a model whose motions can take their steps together"));
    let mut numbers = Numbers(seed);
    let tolerance = [1e-4, 1e-6, 1e-8, 1e-10][(seed % 4) as usize];
    // One more than can be together.
    let members = (0..=Batch::MEMBERS).filter_map(|_| begun(model, &mut numbers, tolerance));
    let mut alone: Vec<Instance> = members.collect();
    let mut together = alone.clone();
    for leg in 0..LEGS {
        let mut ways: Vec<_> = (0..alone.len()).map(|member| times(model, member as u32, leg)).collect();
        let mut sent = vec![None; alone.len()];
        let mut next = |index: usize, instance: &mut Instance, found: Result<(), InstanceError>| {
            if let Some(time) = sent[index] {
                let done = alone[index].step_to(time);
                assert_same(name, time, (&alone[index], &done), (instance, &found));
            }
            sent[index] = ways[index].next();
            sent[index]
        };
        // A series that one batch has begun goes on without it, and in another one.
        if leg == 1 {
            for (index, instance) in together.iter_mut().enumerate() {
                let mut done = Ok(());
                while let Some(time) = next(index, instance, done) {
                    done = instance.step_to(time);
                }
            }
        } else {
            // The order of the members is another one in the last leg.
            let last = together.len().saturating_sub(1);
            let place = |index: usize| if leg == LEGS - 1 { last - index } else { index };
            let mut group: Vec<&mut Instance> = together.iter_mut().collect();
            if leg == LEGS - 1 {
                group.reverse();
            }
            let next = |index, instance: &mut Instance, found| next(place(index), instance, found);
            batches[usize::from(leg > 1)].travel(&mut group, next);
        }
        // Some inputs change now and then: those of one member, not of the others.
        if let (Some(input), Some(first)) = (model.program().inputs.first(), alone.first()) {
            let index = first.variable(&input.name).expect("an input");
            let value = input.start + 0.1 * numbers.next();
            let _ = (alone[0].set(index, value), together[0].set(index, value));
        }
    }
    batches.iter().fold([0; 2], |[found, begun], batch| [found + batch.found(), begun + batch.begun()])
}

/// Communication points of a member in one of the legs of its way: each has more of them than the one before.
fn times(model: &Model, member: u32, leg: u32) -> impl Iterator<Item = f64> + use<> {
    let experiment = &model.program().experiment;
    let (start, stop, points) = (experiment.start, experiment.stop, POINTS * (1 + member));
    let time = move |point: u32| start + f64::from(point) / f64::from(LEGS * points) * (stop - start);
    (leg * points + 1..=(leg + 1) * points).map(time)
}

#[test]
fn simulations_side_by_side_have_the_bits_that_each_has_alone() {
    let (mut models, mut often) = (0, 0);
    for path in programs() {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let program = Program::from_bytes(&fs::read(&path).expect("a file")).expect("a sound program");
        let model = Arc::new(Model::new(program).expect("a sound program"));
        if Batch::new(&model).is_none() {
            continue;
        }
        let counts = (1..=GROUPS).map(|seed| compare(&name, &model, seed));
        let [found, begun] = counts.fold([0; 2], |sum, counts| [sum[0] + counts[0], sum[1] + counts[1]]);
        println!("{name}: {found} {begun}");
        models += usize::from(found > 0);
        if OFTEN.contains(&name.as_str()) {
            often += usize::from(4 * begun > found);
        }
    }
    assert!(models >= 20, "{models}");
    assert_eq!(often, OFTEN.len());
}
