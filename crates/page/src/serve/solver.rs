//! The solver of served pages: what the runtime for browsers does inside a static page, here whole runs and pulls by one request each. Questions and answers are JSON.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::pull::{Grip, PullEnd};

/// Each new page of a scene that is drawn brings programs of its own; the oldest are let go.
const MOST: usize = 64;

/// A page asks for one picture: no pull takes longer \[ms\].
const LONGEST_PULL: f64 = 50.0;

/// Programs and held bodies, by the numbers that pages know them by.
#[derive(Default)]
pub struct Solvers {
    instances: Mutex<Kept<Instance>>,
    grips: Mutex<Kept<Numbered>>,
}

/// A body that a page pulls. A page draws while it waits, and each request has a connection and a thread: they may arrive in another order than they were sent.
struct Numbered {
    grip: Grip,
    /// Highest number of a request that was answered.
    last: u64,
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
    number: u64,
    time: Option<f64>,
    to: Option<[[f64; 2]; 2]>,
    /// The pull ends after this time at the latest \[ms\].
    share: f64,
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
                told(&json!({ "grip": locked(&self.grips).keep(Numbered { grip, last: 0 }) }))
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
    /// How the pull has ended, as a number of [`PullEnd`], and the values in the pose. A request that arrives after a later one reads values only: the page has let go, or reads its last pose.
    fn answer(&self, held: &mut Numbered) -> serde_json::Value {
        let is_late = self.number < held.last;
        held.last = held.last.max(self.number);
        let Numbered { grip, .. } = held;
        self.time.filter(|_| !is_late).into_iter().for_each(|time| grip.set_time(time));
        let end = self.to.filter(|_| !is_late).map(|[point, target]| self.pull(grip, point, target) as i32);
        let mut values = vec![f64::NAN; self.variables.len()];
        grip.values(&self.variables, &mut values);
        json!({ "end": end, "values": values })
    }

    fn pull(&self, grip: &mut Grip, point: [f64; 2], target: [f64; 2]) -> PullEnd {
        let began = Instant::now();
        let is_over = || began.elapsed().as_secs_f64() * 1e3 >= self.share.min(LONGEST_PULL);
        loop {
            let end = grip.pull(point, target);
            if end != PullEnd::OnItsWay || is_over() {
                return end;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use cotree::compile::compile;
    use cotree::scene::Scene;
    use serde_json::Value;

    use super::*;

    /// A rod of 1 m, balanced on its pin, whose tip is below it.
    const ROD: &str = "format = 1\nname = \"rod\"\n[ground.points]\no = [0, 0]\n[bodies.rod]\nmass = 1\n\
        inertia = 0.1\ncom = [0, 0]\npoints = { a = [0, 0], tip = [1, 0] }\n[joints.pin]\ntype = \"revolute\"\n\
        between = [\"ground.o\", \"rod.a\"]\n[initial]\n\"pin.angle\" = \"-90 deg\"\n[outputs]\nvariables = [\"rod.x\", \"rod.y\", \"rod.angle\"]\n";

    /// Solvers with the rod held, and its variables for `x`, `y` and `angle`.
    fn held() -> (Solvers, [usize; 3]) {
        let compiled = compile(&Scene::from_toml(ROD).unwrap()).unwrap();
        let named =
            |name: &str| compiled.description.variables.iter().position(|variable| variable.name == name).unwrap();
        let body = ["rod.x", "rod.y", "rod.angle"].map(named);
        let solvers = Solvers::default();
        solvers.load(&compiled.program.to_bytes().unwrap()).unwrap();
        let start = json!({ "model": 1, "start": 0.0, "stop": 1.0, "tolerance": 1e-6, "values": [],
            "pose": { "positions": [-std::f64::consts::FRAC_PI_2], "body": body } });
        solvers.ask("grip", start.to_string().as_bytes()).unwrap();
        (solvers, body)
    }

    /// The angle of the rod after its tip is pulled towards an angle.
    fn pulled(solvers: &Solvers, number: u64, angle: Option<f64>, variable: usize) -> (Option<i64>, f64) {
        let to = angle.map(|angle| [[1.0, 0.0], [angle.cos(), angle.sin()]]);
        let question =
            json!({ "grip": 1, "number": number, "time": null, "to": to, "share": 8, "variables": [variable] });
        let answer = solvers.ask("pull", question.to_string().as_bytes()).unwrap();
        let answer: Value = serde_json::from_slice(&answer).unwrap();
        (answer["end"].as_i64(), answer["values"][0].as_f64().unwrap())
    }

    /// A page sends its next request before the last one is answered: whichever arrives first, the later one decides.
    #[test]
    fn a_pull_that_arrives_after_a_later_one_moves_nothing() {
        let (solvers, [.., angle]) = held();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
        let (end, found) = pulled(&solvers, 1, Some(-1.2), angle);
        assert_eq!(end, Some(PullEnd::Near as i64));
        near(found, -1.2);
        near(pulled(&solvers, 3, Some(-0.8), angle).1, -0.8);
        let (end, found) = pulled(&solvers, 2, Some(-1.4), angle);
        assert_eq!(end, None);
        near(found, -0.8);
        near(pulled(&solvers, 4, None, angle).1, -0.8);
        near(pulled(&solvers, 5, Some(-1.0), angle).1, -1.0);
    }

    /// Whatever a request holds, the answer is a message.
    #[test]
    fn requests_that_are_not_understood_are_refused() {
        let (solvers, _) = held();
        for body in
            ["", "{}", "null", "[]", "{\"grip\":1}", "\u{0}", "{\"grip\":7,\"number\":1,\"share\":0,\"variables\":[]}"]
        {
            for name in ["solve", "grip", "pull"] {
                assert!(solvers.ask(name, body.as_bytes()).is_err(), "{name}: {body}");
            }
        }
        assert!(solvers.load(b"no program").is_err());
        let huge = "{\"grip\":1,\"number\":18446744073709551615,\"time\":1e308,\"to\":[[1e308,1e308],[-1e308,1e308]],\"share\":1e308,\"variables\":[4294967295]}";
        let answer: Value = serde_json::from_slice(&solvers.ask("pull", huge.as_bytes()).unwrap()).unwrap();
        assert!(answer["values"][0].is_null(), "{answer}");
    }
}
