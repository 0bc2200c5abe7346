//! Runs the hard set: mechanisms through singular poses and other hard cases, at tolerances from 1e-3 to 1e-13, and prints what came
//! out, for each method. Run with `cargo run --release --example hard_set [members] [automatic|explicit|implicit|all] [part of a family's name]`.

#[path = "../tests/support/hard/mod.rs"]
mod hard;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use cotree_fmu::program::Engine;
use hard::four_bar::{neutral_with_flap, stiff_at_change_points};
use hard::{Case, Outcome, Points, cases};

/// One row of the table.
#[derive(Default)]
struct Row {
    runs: usize,
    lost: usize,
    failed: usize,
    refused: usize,
    drift: f64,
    residual: f64,
    microseconds: f64,
    examples: Vec<String>,
}

/// What a row of the table is about besides a family.
type Method = (&'static str, Option<Engine>);

/// What the program chooses, and others.
const METHODS: [Method; 3] =
    [("automatic", None), ("explicit", Some(Engine::Dop853)), ("implicit", Some(Engine::Radau))];
/// What a run says that stiffness keeps from passing a singular pose.
const STOPS: [&str; 2] = ["comes to a singular pose", "has left its branch in a singular pose"];
/// The implicit method runs what is stiff, the explicit one only what has singular poses besides.
const STIFF: &str = "stiff";
const STIFF_AT_POSES: &str = "change point, stiff";
/// Stiffnesses [N m/rad] and dampings [N m s/rad] at change points.
const STIFFNESSES: [f64; 2] = [1e4, 1e6];
const DAMPINGS: [f64; 2] = [1e2, 1e4];
/// Those that are not chosen run only mechanisms with loops, and not longer than this [s].
const SHORT: f64 = 50.0;
const POINTS: [Points; 3] = [Points::Even(400), Points::Even(7), Points::Uneven(300)];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let members = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(6);
    let method = arguments.next().unwrap_or_else(|| "all".into());
    let methods: Vec<Method> = METHODS.into_iter().filter(|(name, _)| method == "all" || method == *name).collect();
    let part = arguments.next().unwrap_or_default();
    let stiff = (0..3 * members).map(neutral_with_flap);
    let loads = (0..members).flat_map(|seed| stiff_at_change_points(seed, &STIFFNESSES, &DAMPINGS));
    let cases: Vec<Case> =
        cases(members).into_iter().chain(stiff).chain(loads).filter(|case| case.family.contains(&part)).collect();
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(BTreeMap::<(&str, &str), Row>::new()));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    for (method, row) in study(case, &methods) {
                        if let Ok(mut rows) = rows.lock() {
                            rows.entry((case.family, method)).or_default().add(row);
                        }
                    }
                }
            });
        }
    });
    if let Ok(rows) = rows.into_inner() {
        print(&rows);
    }
}

fn study(case: &Case, methods: &[Method]) -> Vec<(&'static str, Row)> {
    let model = case.model();
    let loops = model.as_ref().is_ok_and(|model| !model.active().is_empty());
    let applies = |engine: Option<Engine>| match engine {
        None => true,
        Some(Engine::Radau) => case.family.contains(STIFF),
        Some(_) => loops && case.stop < SHORT && (!case.family.contains(STIFF) || case.family.contains(STIFF_AT_POSES)),
    };
    let mut rows = Vec::new();
    for &(method, engine) in methods.iter().filter(|(_, engine)| applies(*engine)) {
        let mut row = Row::default();
        for &tolerance in case.tolerances {
            for points in POINTS {
                let outcome = match &model {
                    Ok(model) => case.run(model, engine, tolerance, points),
                    Err(fault) => Outcome::Failed(fault.clone()),
                };
                let outcome = match outcome {
                    Outcome::Failed(why) if STOPS.iter().any(|stop| why.contains(stop)) => Outcome::Refused(why),
                    other => other,
                };
                row.count(&format!("{method}, {} at {tolerance:e}, {points:?}", case.scene.name.text), outcome);
            }
        }
        rows.push((method, row));
    }
    rows
}

impl Row {
    fn count(&mut self, run: &str, outcome: Outcome) {
        self.runs += 1;
        match outcome {
            Outcome::Passed(figures) => {
                self.drift = self.drift.max(figures.drift);
                self.residual = self.residual.max(figures.residual);
                self.microseconds += figures.microseconds;
            }
            Outcome::Refused(_) => self.refused += 1,
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
        self.refused += other.refused;
        self.drift = self.drift.max(other.drift);
        self.residual = self.residual.max(other.residual);
        self.microseconds += other.microseconds;
        self.examples.extend(other.examples);
    }
}

fn print(rows: &BTreeMap<(&str, &str), Row>) {
    println!(
        "{:<32}{:<11}{:>6}{:>6}{:>8}{:>8}{:>10}{:>10}{:>12}",
        "scene", "method", "runs", "lost", "failed", "errors", "drift", "residual", "us per run"
    );
    let mut totals = BTreeMap::<&str, Row>::new();
    for ((family, method), row) in rows {
        line(family, method, row);
        let total = totals.entry(method).or_default();
        total.runs += row.runs;
        total.lost += row.lost;
        total.failed += row.failed;
        total.refused += row.refused;
    }
    totals.iter().for_each(|(method, total)| line("all", method, total));
    for row in rows.values() {
        row.examples.iter().take(6).for_each(|example| println!("{example}"));
    }
}

fn line(name: &str, method: &str, row: &Row) {
    let passed = row.runs - row.lost - row.failed - row.refused;
    println!(
        "{name:<32}{method:<11}{:>6}{:>6}{:>8}{:>8}{:>10.1e}{:>10.1e}{:>12.0}",
        row.runs,
        row.lost,
        row.failed,
        row.refused,
        row.drift,
        row.residual,
        row.microseconds / passed.max(1) as f64
    );
}
