//! Hostile calls: what an importer may do with a model in which something happens, in any order, with a stop time, times and values that no sensible importer gives.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, Snapshot};
use cotree_fmu::model::Model;

use crate::mutate::Random;
use crate::{ROOT, Target};

/// Calls of one input.
const CALLS: usize = 200;
/// A call that takes the processor longer is reported.
const LONGEST: Duration = Duration::from_secs(10);
/// A call may do a twenty-fifth of the work that an importer's may, which takes half a minute at most: some calls of one input are that much.
const WORK: u64 = 200_000_000;

/// A wheel that is driven the faster the faster it turns, behind a freewheel.
const RUNAWAY: &str = r#"
name = "overspeed"
[parameters]
gain = { value = "4 N.m.s", tunable = true }
[inputs]
torque = { start = "2 N.m" }
[bodies]
rotor = { mass = 1.0, inertia = 0.03 }
shaft = { mass = 2.0, inertia = 0.08 }
[joints.a]
type = "revolute"
between = ["ground", "rotor"]
[joints.b]
type = "revolute"
between = ["ground", "shaft"]
[joints.clutch]
type = "one_way"
between = ["shaft", "rotor"]
[loads.drive]
type = "torque"
on = "rotor"
value = "torque*sin(5*t)"
[loads.grows]
type = "torque"
on = "shaft"
value = "gain*shaft.omega"
[initial]
"rotor.angle" = 0.0
"rotor.omega" = 0.1
"shaft.angle" = 0.0
"shaft.omega" = 0.0
[experiment]
stop = "2 s"
step = "10 ms"
"#;

/// Models in which something happens.
pub struct Calls {
    models: Vec<Arc<Model>>,
}

impl Calls {
    pub fn new() -> Self {
        let models = Path::new(ROOT).join("models");
        let mut folders: Vec<_> =
            fs::read_dir(models).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        folders.sort();
        let scenes = folders.iter().filter_map(|folder| Scene::read(folder.join("scene.toml")).ok());
        let programs = scenes.chain(Scene::from_toml(RUNAWAY).ok()).filter_map(|scene| compile(&scene).ok());
        let models = programs.filter_map(|compiled| Model::new(compiled.program).ok());
        Self { models: models.filter(|model| !model.program().instants.is_empty()).map(Arc::new).collect() }
    }
}

impl Target for Calls {
    /// The seed of the calls.
    fn next(&mut self, random: &mut Random) -> Vec<u8> {
        (0..8).map(|_| random.below(256) as u8).collect()
    }

    fn attempt(&self, input: &[u8]) -> bool {
        let seed = input.iter().take(8).fold(0, |seed, &byte| seed << 8 | u64::from(byte));
        let mut random = Random::new(seed);
        if self.models.is_empty() {
            return false;
        }
        let mut importer = Importer::new(random.pick(&self.models).clone(), random);
        for _ in 0..CALLS {
            let begun = processor_time();
            let what = importer.call();
            let took = processor_time().saturating_sub(begun);
            assert!(took < LONGEST, "{what} of {} took {took:?}", importer.instance.model().program().name);
            // What is too much work once is so in every further step.
            if importer.is_tired {
                break;
            }
        }
        importer.has_started
    }
}

/// What this thread has had of a processor, whatever else the machine does; nothing where the system does not tell.
fn processor_time() -> Duration {
    let told = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    Duration::from_nanos(told.split(' ').next().and_then(|time| time.parse().ok()).unwrap_or_default())
}

/// One instance, and what its importer remembers.
struct Importer {
    random: Random,
    instance: Instance,
    saved: Vec<Snapshot>,
    start: f64,
    stop: f64,
    step: f64,
    has_started: bool,
    /// True where a step has been too much work.
    is_tired: bool,
}

impl Importer {
    fn new(model: Arc<Model>, mut random: Random) -> Self {
        let experiment = model.program().experiment;
        let mut instance = Instance::new(model);
        instance.limit_work(WORK);
        let start = *random.pick(&[0.0, 0.0, 0.0, 1000.0, -3.0]);
        let share = *random.pick(&[1.0, 0.3, 0.1, 0.037]);
        let stop = start + share * (experiment.stop - experiment.start);
        let step = experiment.step * *random.pick(&[1.0, 1.0, 3.0, 0.1]);
        let tolerance = *random.pick(&[None, Some(1e-4), Some(1e-7), Some(1e-12)]);
        _ = instance.setup(start, Some(stop), tolerance);
        Self { random, instance, saved: Vec::new(), start, stop, step, has_started: false, is_tired: false }
    }

    /// The name of what has been called.
    fn call(&mut self) -> &'static str {
        match self.random.below(24) {
            0 => self.set(),
            1 => {
                self.saved.truncate(3);
                self.saved.insert(0, self.instance.save());
                "save"
            }
            2 if !self.saved.is_empty() => {
                let saved = self.random.pick(&self.saved).clone();
                _ = self.instance.restore(&saved);
                "restore"
            }
            3 => {
                let count = self.instance.model().program().variables.len();
                _ = self.instance.get(self.random.below(count + 1));
                "get"
            }
            4 | 5 if !self.has_started => {
                self.has_started = match self.random.below(2) {
                    0 => self.instance.initialise().is_ok(),
                    _ => self.instance.initialise_exchange().is_ok(),
                };
                "start"
            }
            6 if self.random.below(20) == 0 => {
                self.instance.reset();
                self.has_started = false;
                _ = self.instance.setup(self.start, Some(self.stop), None);
                "reset"
            }
            7..=11 => self.exchange(),
            12 => {
                let end = self.end();
                self.is_tired = self.instance.step_towards(end).is_err_and(|failure| failure.is_unfinished());
                "step towards a time"
            }
            _ => {
                let end = self.end();
                self.is_tired = self.instance.step_to(end).is_err_and(|failure| failure.is_unfinished());
                "step"
            }
        }
    }

    fn set(&mut self) -> &'static str {
        let count = self.instance.model().program().variables.len();
        let variable = self.random.below(count + 1);
        let usual = self.instance.get(variable.min(count.saturating_sub(1))).unwrap_or(1.0);
        let value =
            *self.random.pick(&[0.0, usual, 0.9 * usual, 1.1 * usual, -usual, 1e3 * usual, 1e-9, f64::NAN, 1e300]);
        _ = self.instance.set(variable, value);
        "set"
    }

    /// Where a communication step ends: as usual, at the stop, or behind it by what rounding errors may be.
    fn end(&mut self) -> f64 {
        let now = self.instance.time();
        let behind =
            *self.random.pick(&[0.0, 0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4]) * self.stop.abs().max(self.step);
        let usual = now + self.step;
        match self.random.below(40) {
            0 => f64::NAN,
            1 => now,
            2 => now - self.step,
            3 => f64::INFINITY,
            4 => now.next_up(),
            5 => now + 1e-9 * self.step,
            6..=8 => self.stop + behind,
            _ if usual >= self.stop => self.stop + behind,
            _ => usual,
        }
    }

    /// One of the calls of Model Exchange.
    fn exchange(&mut self) -> &'static str {
        let [states, indicators] = [self.instance.state_count(), self.instance.model().program().indicators()];
        let mut values = vec![0.0; states.max(indicators)];
        match self.random.below(7) {
            0 => {
                let time = self.end();
                _ = self.instance.set_time(time);
                "set time"
            }
            1 => {
                let (shift, mut values) = (*self.random.pick(&[0.0, 1e-12, 1e-6, -1e-6, 1e-2, 1e9]), vec![0.0; states]);
                _ = self.instance.states(&mut values);
                values.iter_mut().for_each(|value| *value += shift);
                _ = self.instance.set_states(&values);
                "set states"
            }
            2 => {
                _ = self.instance.state_derivatives(&mut values[..states]);
                "derivatives"
            }
            3 | 4 => {
                _ = self.instance.indicators(&mut values[..indicators]);
                "indicators"
            }
            5 => {
                _ = self.instance.complete_step();
                "completed step"
            }
            _ => {
                _ = self.instance.handle_event();
                "event"
            }
        }
    }
}
