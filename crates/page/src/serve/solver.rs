//! The solver of served pages: what the runtime for browsers does inside a static page, here whole runs and pulls by one request each. Questions and answers are JSON.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::pull::Grip;

/// Each new page of a scene that is drawn brings programs of its own; the oldest are let go.
const MOST: usize = 64;

/// Programs and held bodies, by the numbers that pages know them by.
#[derive(Default)]
pub struct Solvers {
    instances: Mutex<Kept<Instance>>,
    grips: Mutex<Kept<Grip>>,
}

struct Kept<T> {
    next: u64,
    all: BTreeMap<u64, Arc<Mutex<T>>>,
}

/// A run: values by the indices of variables.
#[derive(Deserialize)]
struct Start {
    model: u64,
    start: f64,
    stop: f64,
    tolerance: f64,
    values: Vec<(usize, f64)>,
    #[serde(default)]
    pose: Option<Pose>,
}

/// Coordinates, and the variables of the body that is held.
#[derive(Deserialize)]
struct Pose {
    positions: Vec<f64>,
    body: [usize; 3],
    /// Parameters and inputs that follow the pose, and whether each is an angle.
    #[serde(default)]
    released: Vec<(usize, bool)>,
}

#[derive(Deserialize)]
struct Solve {
    #[serde(flatten)]
    start: Start,
    /// Inputs that change: when, which, to what.
    moves: Vec<(f64, usize, f64)>,
    times: Vec<f64>,
    /// What is recorded.
    variables: Vec<usize>,
}

/// A point of the body and where it is to be, or only another time; then values.
#[derive(Deserialize)]
struct Pull {
    grip: u64,
    time: Option<f64>,
    to: Option<[[f64; 2]; 2]>,
    variables: Vec<u32>,
}

/// What has been recorded, and why the run has ended before its last time.
#[derive(Serialize)]
struct Solved {
    columns: Vec<Vec<f64>>,
    last: i64,
    /// Where it failed: `set`, `start`, `step` or `record`.
    failed: Option<&'static str>,
    message: String,
    warning: Option<String>,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Kept { next: 0, all: BTreeMap::new() }
    }
}

impl<T> Kept<T> {
    fn keep(&mut self, value: T) -> u64 {
        self.next += 1;
        self.all.insert(self.next, Arc::new(Mutex::new(value)));
        if self.all.len() > MOST {
            self.all.pop_first();
        }
        self.next
    }

    fn get(&self, number: u64) -> Result<Arc<Mutex<T>>, String> {
        self.all.get(&number).cloned().ok_or_else(|| "this page is out of date: reload it".to_owned())
    }
}

/// A call that failed has left whole values, or an instance that the next start resets.
fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

fn read<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, String> {
    serde_json::from_slice(body).map_err(|error| error.to_string())
}

fn told(answer: &impl Serialize) -> Result<Vec<u8>, String> {
    serde_json::to_vec(answer).map_err(|error| error.to_string())
}

impl Solvers {
    /// Takes a program, as an FMU has it; the answer is its number.
    ///
    /// # Errors
    /// The bytes are no program.
    pub fn load(&self, program: &[u8]) -> Result<Vec<u8>, String> {
        let program = Program::from_bytes(program).map_err(|error| error.to_string())?;
        let model = Model::new(program).map_err(|error| error.to_string())?;
        told(&json!({ "model": locked(&self.instances).keep(Instance::new(Arc::new(model))) }))
    }

    /// Answers `solve`, `grip` or `pull`.
    ///
    /// # Errors
    /// The question is none, or the body cannot be held.
    pub fn ask(&self, name: &str, body: &[u8]) -> Result<Vec<u8>, String> {
        match name {
            "solve" => {
                let question: Solve = read(body)?;
                let instance = self.instance(question.start.model)?;
                told(&question.run(&mut locked(&instance)))
            }
            "grip" => {
                let question: Start = read(body)?;
                let instance = self.instance(question.model)?;
                let grip = question.grip(&mut locked(&instance))?;
                told(&json!({ "grip": locked(&self.grips).keep(grip) }))
            }
            _ => {
                let question: Pull = read(body)?;
                let grip = locked(&self.grips).get(question.grip)?;
                told(&question.answer(&mut locked(&grip)))
            }
        }
    }

    fn instance(&self, number: u64) -> Result<Arc<Mutex<Instance>>, String> {
        locked(&self.instances).get(number)
    }
}

impl Start {
    /// Back to the values of the program, with these.
    fn prepare(&self, instance: &mut Instance) -> Result<(), InstanceError> {
        instance.reset();
        instance.setup(self.start, Some(self.stop.max(self.start)), Some(self.tolerance))?;
        self.values.iter().try_for_each(|&(variable, value)| instance.set(variable, value))
    }

    fn grip(&self, instance: &mut Instance) -> Result<Grip, String> {
        self.prepare(instance).map_err(|error| error.to_string())?;
        self.pose.as_ref().ok_or("there is no configuration")?.hold(instance)
    }

    /// From the pose, wherever the guesses of the scene would lead.
    fn begin(&self, instance: &mut Instance) -> Result<(), String> {
        if let Some(pose) = &self.pose {
            let pose = pose.hold(instance)?.at_the_values_of(&instance.state());
            instance.start_from(pose).map_err(|error| error.to_string())?;
        }
        instance.initialise().map_err(|error| error.to_string())
    }
}

impl Pose {
    fn hold(&self, instance: &Instance) -> Result<Grip, String> {
        Grip::new(Arc::clone(instance.model()), instance.state(), &self.positions, &self.released, self.body)
    }
}

impl Solve {
    fn run(&self, instance: &mut Instance) -> Solved {
        let columns = vec![vec![f64::NAN; self.times.len()]; self.variables.len()];
        let mut solved = Solved { columns, last: -1, failed: None, message: String::new(), warning: None };
        if let Err((failed, message)) = self.record(instance, &mut solved) {
            (solved.failed, solved.message) = (Some(failed), message);
        }
        solved.warning = instance.take_inaccuracy().map(|found| format!("{found}; {}", found.help()));
        solved
    }

    fn record(&self, instance: &mut Instance, solved: &mut Solved) -> Result<(), (&'static str, String)> {
        let at = |stage| move |error: InstanceError| (stage, error.to_string());
        self.start.prepare(instance).map_err(at("set"))?;
        self.start.begin(instance).map_err(|message| ("start", message))?;
        let mut moves = self.moves.iter().peekable();
        for (sample, &time) in self.times.iter().enumerate() {
            if sample > 0 {
                instance.step_to(time).map_err(at("step"))?;
            }
            while let Some(&(_, variable, value)) = moves.next_if(|(when, ..)| *when <= time) {
                instance.set(variable, value).map_err(at("record"))?;
            }
            for (column, &variable) in solved.columns.iter_mut().zip(&self.variables) {
                column[sample] = instance.reading(variable).map_err(at("record"))?;
            }
            solved.last = sample as i64;
        }
        Ok(())
    }
}

impl Pull {
    /// How the pull has ended, as a number of [`crate::pull::End`], and the values in the pose.
    fn answer(&self, grip: &mut Grip) -> serde_json::Value {
        self.time.into_iter().for_each(|time| grip.set_time(time));
        let end = self.to.map(|[point, target]| grip.pull(point, target) as i32);
        let mut values = vec![f64::NAN; self.variables.len()];
        grip.values(&self.variables, &mut values);
        json!({ "end": end, "values": values })
    }
}
