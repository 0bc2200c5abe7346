//! Runs the hard set: mechanisms through singular poses and other hard cases, with every method, at tolerances from 1e-3 to 1e-13 and communication steps from 1 s
//! to 0.1 ms, and prints what came out. Run with `cargo run --release --example hard_set -- --help`.

#[path = "../tests/support/mod.rs"]
mod support;

/// The folder of the whole project.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use cotree_fmu::program::Engine;
use support::hard::families::FAMILIES;
use support::hard::four_bar::{neutral_with_flap, stiff_at_change_points};
use support::hard::random::Random;
use support::hard::{Case, Outcome, Points, cases};

/// What to run.
#[derive(Parser)]
struct Arguments {
    /// The sample by which a change of the runtime is judged: one member of each family, at the tolerances nearest to 1e-4, 1e-7 and 1e-10
    #[arg(long, conflicts_with_all = ["members", "tolerance"])]
    sample: bool,
    /// Members of each family
    #[arg(long, default_value_t = 6)]
    members: u64,
    /// Seed of the first member of the random families
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Only this method: automatic, series, explicit, implicit
    #[arg(long)]
    method: Option<String>,
    /// Only families with this in their names
    #[arg(long, default_value = "")]
    family: String,
    /// Only this tolerance
    #[arg(long)]
    tolerance: Option<f64>,
    /// Stiffnesses of springs at change points [N m/rad]
    #[arg(long, value_delimiter = ',', default_value = "1e4,1e6")]
    stiffness: Vec<f64>,
    /// Dampings of dampers at change points [N m s/rad]
    #[arg(long, value_delimiter = ',', default_value = "1e2,1e4")]
    damping: Vec<f64>,
    /// So many examples of what went wrong for each family and method
    #[arg(long, default_value_t = 6)]
    examples: usize,
}

/// One row of the table.
#[derive(Default)]
struct Row {
    runs: usize,
    lost: usize,
    failed: usize,
    /// By their messages without names and numbers, and by their tolerances.
    refused: BTreeMap<(String, i32), usize>,
    drift: f64,
    residual: f64,
    /// The largest error against the reference, in tolerances.
    error: f64,
    microseconds: f64,
    examples: Vec<String>,
}

/// What a row of the table is about besides a family.
type Method = (&'static str, Option<Engine>);

/// What the program chooses, and others.
const METHODS: [Method; 4] = [
    ("automatic", None),
    ("series", Some(Engine::Taylor)),
    ("explicit", Some(Engine::Dop853)),
    ("implicit", Some(Engine::Radau)),
];
/// What a run says that stiffness keeps from passing a singular pose.
const STOPS: [&str; 2] = ["comes to a singular pose", "has left its branch in a singular pose"];
/// The implicit method runs what is stiff, the explicit one only what has singular poses besides.
const STIFF: &str = "stiff";
const STIFF_AT_POSES: &str = "change point, stiff";
/// Those that are not chosen run only mechanisms with loops, and not longer than this [s].
const SHORT: f64 = 50.0;
/// Tolerances of the sample.
const SAMPLE: [f64; 3] = [1e-4, 1e-7, 1e-10];
const POINTS: [Points; 3] = [Points::Even(400), Points::Even(7), Points::Uneven(300)];
/// Communication steps of the families with references, shortest and longest, by their powers of ten [s].
const STEPS: [f64; 2] = [-4.0, 0.0];

/// What one of the workers takes up.
enum Job {
    Case(Box<Case>),
    /// A member of a family with references, which takes long to make.
    Member(fn(u64) -> Case, u64),
}

fn main() {
    let mut arguments = Arguments::parse();
    if arguments.sample {
        arguments.members = 1;
    }
    let jobs = jobs(&arguments);
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(BTreeMap::<(&str, &str), Row>::new()));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let (family, found) = job.study(&arguments);
                    for (method, row) in found {
                        if let Ok(mut rows) = rows.lock() {
                            rows.entry((family, method)).or_default().add(row);
                        }
                    }
                }
            });
        }
    });
    if let Ok(rows) = rows.into_inner() {
        print(&rows, arguments.examples);
    }
}

impl Arguments {
    /// Is this one of the tolerances of a case that it is run at?
    fn runs_at(&self, case: &Case, tolerance: f64) -> bool {
        let apart = |one: f64, other: f64| (one / other).log10().abs();
        let nearest = |wanted: f64| {
            case.tolerances.iter().copied().min_by(|a, b| apart(*a, wanted).total_cmp(&apart(*b, wanted)))
        };
        let in_sample = !self.sample || SAMPLE.into_iter().filter_map(nearest).any(|chosen| chosen == tolerance);
        in_sample && self.tolerance.is_none_or(|only| only == tolerance)
    }
}

fn jobs(arguments: &Arguments) -> Vec<Job> {
    let wanted = |name: &str| name.contains(&arguments.family);
    let seeds = arguments.seed..arguments.seed + arguments.members;
    let stiff = (0..3 * arguments.members).map(neutral_with_flap);
    let loads = seeds.clone().flat_map(|seed| stiff_at_change_points(seed, &arguments.stiffness, &arguments.damping));
    let known = cases(arguments.members).into_iter().chain(stiff).chain(loads);
    let families = FAMILIES.iter().filter(|family| wanted(family.name));
    let members = families.flat_map(|family| seeds.clone().map(|seed| Job::Member(family.member, seed)));
    known.filter(|case| wanted(case.family)).map(|case| Job::Case(Box::new(case))).chain(members).collect()
}

impl Job {
    fn study(&self, arguments: &Arguments) -> (&'static str, Vec<(&'static str, Row)>) {
        match self {
            Job::Case(case) => {
                let loops = case.model().is_ok_and(|model| !model.active().is_empty());
                let applies = |engine: Option<Engine>| match engine {
                    None => true,
                    Some(Engine::Radau) => case.family.contains(STIFF),
                    Some(Engine::Taylor) => false,
                    Some(Engine::Dop853) => {
                        let stiff = case.family.contains(STIFF) && !case.family.contains(STIFF_AT_POSES);
                        loops && case.stop < SHORT && !stiff
                    }
                };
                (case.family, study(case, arguments, applies, |_| POINTS.into()))
            }
            Job::Member(member, seed) => {
                let case = member(*seed);
                // Every run with a communication step of its own, the same for all methods.
                let mut random = Random(*seed);
                let steps: Vec<f64> =
                    case.tolerances.iter().map(|_| 10.0_f64.powf(random.between(STEPS[0], STEPS[1]))).collect();
                (case.family, study(&case, arguments, |_| true, |place| vec![Points::Every(steps[place])]))
            }
        }
    }
}

fn study(
    case: &Case,
    arguments: &Arguments,
    applies: impl Fn(Option<Engine>) -> bool,
    points: impl Fn(usize) -> Vec<Points>,
) -> Vec<(&'static str, Row)> {
    let model = case.model();
    let wanted = |name: &str| arguments.method.as_ref().is_none_or(|method| method == name);
    let mut rows = Vec::new();
    for (method, engine) in METHODS.into_iter().filter(|(name, engine)| wanted(name) && applies(*engine)) {
        let mut row = Row::default();
        for (place, &tolerance) in case.tolerances.iter().enumerate() {
            if !arguments.runs_at(case, tolerance) {
                continue;
            }
            let points = points(place).into_iter().take(if arguments.sample { 1 } else { usize::MAX });
            for points in points {
                let outcome = match &model {
                    Ok(model) => case.run(model, engine, tolerance, points),
                    Err(fault) => Outcome::Failed(format!("no model: {fault}")),
                };
                // Where there is a reference, an error is no wrong result: it is counted by its kind.
                let outcome = match outcome {
                    Outcome::Failed(why) if model.is_ok() && case.reference.is_some() => Outcome::Refused(why),
                    Outcome::Failed(why) if STOPS.iter().any(|stop| why.contains(stop)) => Outcome::Refused(why),
                    other => other,
                };
                let run = format!("{method}, {} at {tolerance:e}, {points:?}", case.scene.name.text);
                row.count(&run, tolerance, outcome);
            }
        }
        rows.push((method, row));
    }
    rows
}

/// A message without its names and numbers.
fn kind(message: &str) -> String {
    let mut kind = String::new();
    for (index, part) in message.split('`').enumerate() {
        kind.push_str(if index % 2 == 0 { part } else { "_" });
    }
    let words = kind.split(' ').map(|word| if word.parse::<f64>().is_ok() { "_" } else { word });
    let words: Vec<&str> = words.filter(|word| *word != "_," && *word != "and").collect();
    words.join(" ")
}

impl Row {
    fn count(&mut self, run: &str, tolerance: f64, outcome: Outcome) {
        self.runs += 1;
        match outcome {
            Outcome::Passed(figures) => {
                self.drift = self.drift.max(figures.drift);
                self.residual = self.residual.max(figures.residual);
                self.error = self.error.max(figures.error / tolerance);
                self.microseconds += figures.microseconds;
            }
            Outcome::Refused(why) => {
                *self.refused.entry((kind(&why), tolerance.log10().round() as i32)).or_default() += 1;
            }
            Outcome::Lost(how) => {
                self.lost += 1;
                self.examples.push(format!("{run}: lost: {how}"));
            }
            Outcome::Failed(why) => {
                self.failed += 1;
                self.examples.push(format!("{run}: failed: {why}"));
            }
        }
    }

    fn add(&mut self, other: Row) {
        self.runs += other.runs;
        self.lost += other.lost;
        self.failed += other.failed;
        for (kind, count) in other.refused {
            *self.refused.entry(kind).or_default() += count;
        }
        self.drift = self.drift.max(other.drift);
        self.residual = self.residual.max(other.residual);
        self.error = self.error.max(other.error);
        self.microseconds += other.microseconds;
        self.examples.extend(other.examples);
    }

    fn refusals(&self) -> usize {
        self.refused.values().sum()
    }
}

fn print(rows: &BTreeMap<(&str, &str), Row>, examples: usize) {
    println!(
        "{:<32}{:<11}{:>6}{:>6}{:>8}{:>9}{:>10}{:>10}{:>13}{:>12}",
        "scene", "method", "runs", "lost", "failed", "refused", "drift", "residual", "error / tol", "us per run"
    );
    let mut totals = BTreeMap::<&str, Row>::new();
    for ((family, method), row) in rows {
        line(family, method, row);
        let total = totals.entry(method).or_default();
        total.runs += row.runs;
        total.lost += row.lost;
        total.failed += row.failed;
        for (kind, count) in &row.refused {
            *total.refused.entry(kind.clone()).or_default() += count;
        }
    }
    totals.iter().for_each(|(method, total)| line("all", method, total));
    totals.iter().for_each(|(method, total)| print_refusals(method, total));
    for row in rows.values() {
        row.examples.iter().take(examples).for_each(|example| println!("{example}"));
    }
}

/// Refusals of a method by their kind, at each tolerance.
fn print_refusals(method: &str, row: &Row) {
    let mut kinds = BTreeMap::<&str, BTreeMap<i32, usize>>::new();
    for ((kind, power), count) in &row.refused {
        *kinds.entry(kind).or_default().entry(*power).or_default() += count;
    }
    for (kind, counts) in kinds {
        let counts: Vec<String> = counts.iter().rev().map(|(power, count)| format!("{count} at 1e{power}")).collect();
        println!("\n{method} refused {}\n    {kind}", counts.join(", "));
    }
}

fn line(name: &str, method: &str, row: &Row) {
    let passed = row.runs - row.lost - row.failed - row.refusals();
    println!(
        "{name:<32}{method:<11}{:>6}{:>6}{:>8}{:>9}{:>10.1e}{:>10.1e}{:>13.1e}{:>12.0}",
        row.runs,
        row.lost,
        row.failed,
        row.refusals(),
        row.drift,
        row.residual,
        row.error,
        row.microseconds / passed.max(1) as f64
    );
}
