//! No step allocates: not those of any model, and not those that pass singular poses, but for what is found and said of a pose.

use crate::counting::allocations;
use crate::support::ROOT;
use crate::support::hard::cases;
use crate::support::run::{models, sound};

use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

/// Communication points of a run.
const POINTS: u32 = 200;

/// Families that come to poses where branches almost meet, or come to poses in short steps: what is looked at there is not reported, and has storage of its own.
const UNREPORTED: [&str; 2] = ["nearly neutral", "stiff"];

/// At how many communication points something had been allocated, and how many singular poses were reported.
fn allocating(instance: &mut Instance, start: f64, stop: f64) -> [usize; 2] {
    let mut counts = [0, 0];
    for point in 1..=POINTS {
        let time = start + (stop - start) * f64::from(point) / f64::from(POINTS);
        let before = allocations();
        let done = instance.step_to(time).is_ok();
        let allocated = allocations() > before;
        // What ends a run says why.
        if !done {
            break;
        }
        counts[0] += usize::from(allocated);
        counts[1] += instance.take_passages().len();
    }
    counts
}

#[test]
fn no_step_of_a_model_allocates() {
    let mut found = Vec::new();
    for name in models() {
        let scene = Path::new(ROOT).join("models").join(&name).join("scene.toml");
        let program = sound(Scene::read(&scene).and_then(|scene| compile(&scene))).program;
        let (start, stop) = (program.experiment.start, program.experiment.stop);
        let mut instance = Instance::new(Arc::new(Model::new(program).expect("a sound program")));
        instance.setup(start, Some(stop), None).expect("times");
        instance.initialise().expect("consistent");
        let [allocating, poses] = allocating(&mut instance, start, stop);
        if allocating > poses {
            found.push(format!("{name}: {allocating} times, {poses} poses"));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A pose is judged, and described with names, at each trial of a step over it: once or twice. The last one may be reported later.
#[test]
fn no_step_of_the_hard_set_allocates() {
    let mut found = Vec::new();
    for case in cases(1).into_iter().filter(|case| !UNREPORTED.iter().any(|part| case.family.contains(part))) {
        let Ok(model) = case.model() else { continue };
        for tolerance in [1e-4, 1e-7, 1e-10] {
            let mut instance = Instance::new(model.clone());
            let begun = instance.setup(0.0, Some(case.stop), Some(tolerance)).and_then(|()| instance.initialise());
            if begun.is_err() {
                continue;
            }
            let [allocating, poses] = allocating(&mut instance, 0.0, case.stop);
            if allocating > 2 * poses + 1 {
                found.push(format!("{} {tolerance:e}: {allocating} times, {poses} poses", case.family));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A point that slides in a notch and rests there, and a disc that goes over a corner: what a profile is touched by is searched for and changes without new storage.
#[test]
fn no_step_at_a_profile_allocates() {
    const NOTCH: &str = "profile = [[-1, 1], [0, 0], [1, 0.5]]";
    const TABLE: &str = "profile = [[0, -2], [0, 0], [-1, 0]]\nside = \"right\"\nradius = 0.2";
    for (profile, at, rate) in [(NOTCH, [-0.5, 0.5], 0.0), (TABLE, [-0.3, 0.2], 0.6)] {
        let [x, y] = at;
        let text = format!(
            "name = \"p\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 1\ninertia = 1\n[joints.edge]\ntype = \"contact\"\nbetween = [\"ground\", \"ball\"]\n{profile}\n[initial]\n\"ball.x\" = {x}\n\"ball.y\" = {y}\n\"ball.angle\" = 0\n\"ball.vx\" = {rate}\n\"ball.vy\" = 0\n\"ball.omega\" = 0\n"
        );
        let program = sound(Scene::from_toml(&text).and_then(|scene| compile(&scene))).program;
        let mut instance = Instance::new(Arc::new(Model::new(program).expect("a sound program")));
        instance.setup(0.0, Some(2.0), None).expect("times");
        instance.initialise().expect("consistent");
        assert_eq!(allocating(&mut instance, 0.0, 1.5), [0, 0], "{profile}");
    }
}
