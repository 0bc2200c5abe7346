//! The linkages found, as a table and as JSON.

use cotree::model::Units;
use cotree::report::data::{Cell, Report, Table, named, number};
use cotree::task::TaskKind;
use cotree::{line, row};
use cotree_synthesis::path::CouplerPath;
use cotree_synthesis::tolerance::{Contribution, Measured, Tolerances, tolerances};
use cotree_synthesis::{Dyad, LinkageLimit, Point};
use serde_json::{Value, json};

use super::six::SixSolution;
use super::{Answer, Solution};

/// Most poses that a four-bar takes exactly.
const MOST_POSES: usize = 5;

/// Millimetres and degrees, in which people think of linkages.
pub fn usual() -> Units {
    crate::motion::usual()
}

impl Answer {
    pub fn report(&self) -> Report {
        let good = self.good().count();
        let title = format!("{}: {} for {}", self.task.name, count(good, "good linkage"), self.requested());
        let mut notes: Vec<Cell> = Vec::new();
        let others: Vec<String> = self.left_out.iter().map(|(reason, count)| format!("  {count}  {reason}")).collect();
        if !others.is_empty() {
            notes.push(Cell::from(format!("\nrejected, of {} candidates:", self.looked_at)));
            notes.extend(others.into_iter().map(Cell::from));
        }
        if good == 0 {
            let last = self.last.clone().unwrap_or_else(|| "the search ended without a candidate".to_owned());
            notes.push(Cell::from(format!("\n0 of {} meet the limits; {last}", count(self.looked_at, "candidate"))));
            let is_too_many = matches!(&self.task.kind, TaskKind::Poses { at, .. } if at.len() > MOST_POSES);
            notes.extend(is_too_many.then(|| {
                let advice = "a four-bar can meet at most five general poses, and these are far from any of its motions; remove some poses, or write `bars = 6` in `[limits]` for six-bars";
                Cell::from(advice)
            }));
        }
        notes.extend(self.costs.iter().map(|cost| Cell::from(format!("  {cost}"))));
        notes.extend(self.ground().map(|length| {
            line!["\nlengths are for a ground of ", number(length, "m"), " (`ground` in the task; default 1 m)"]
        }));
        let mut tables = if self.solutions.is_empty() { Vec::new() } else { vec![self.table()] };
        if !self.shorter.is_empty() {
            let title = "trade-off of size and error".to_owned();
            tables.push(Table { heading: Some(Cell::from(title)), ..self.rows(&self.shorter, "shorter_") });
        }
        if !self.six_bars.is_empty() {
            tables.push(self.six_table());
        }
        Report { tables, notes, data: self.data(), ..Report::new(row![title]) }
    }

    /// What deviations of lengths and pivots \[m\] do to each good four-bar, beside its error without them.
    pub fn tolerance_report(&self, [length, pivot]: [f64; 2]) -> Report {
        let measured = match self.task.kind {
            TaskKind::Path(CouplerPath { crank: None, .. }) => Measured::Across,
            TaskKind::Path(_) | TaskKind::Poses { .. } => Measured::Place,
            TaskKind::Function { .. } | TaskKind::Stroke { .. } => Measured::Output,
        };
        let unit = if measured == Measured::Output { "rad" } else { "m" };
        let good: Vec<&Solution> = self.good().collect();
        let found: Vec<(usize, Option<Tolerances>)> = good
            .iter()
            .enumerate()
            .map(|(index, solution)| {
                (index + 1, tolerances(&solution.linkage, &solution.poses, measured, length, pivot))
            })
            .collect();
        let all = || found.iter().filter_map(|(index, tolerances_found)| Some((index, tolerances_found.as_ref()?)));
        let columns =
            row!["scene", named("worst case", unit), named("3 sigma", unit), named("sampled", unit), "jammed"];
        let rows = all().map(|(index, found_tolerances)| {
            let [worst, sigma, sampled] =
                [found_tolerances.worst, found_tolerances.three_sigma, found_tolerances.sampled]
                    .map(|value| number(value, unit));
            row![format!("{index}.toml"), worst, sigma, sampled, found_tolerances.jammed.to_string()]
        });
        let mut tables = vec![Table::new(columns, rows)];
        tables.extend(all().take(1).map(|(index, found_tolerances)| {
            let columns = row!["dimension", named("deviates by", "m"), named("error of this deviation alone", unit)];
            let row = |contribution: &Contribution| {
                row![contribution.name.clone(), number(contribution.tolerance, "m"), number(contribution.error, unit)]
            };
            let heading = Cell::from(format!("{index}.toml, deviations of each dimension"));
            Table { heading: Some(heading), ..Table::new(columns, found_tolerances.contributions.iter().map(row)) }
        }));
        let without = found.iter().filter(|(_, tolerances_found)| tolerances_found.is_none()).count();
        let note = format!("{} have no table of deviations: they have a slider or a slot", count(without, "linkage"));
        let notes = (without > 0).then(|| Cell::from(note)).into_iter().collect();
        let data = all().map(|(index, found_tolerances)| {
            let each = found_tolerances
                .contributions
                .iter()
                .map(|contribution| json!({ "dimension": contribution.name, "tolerance": contribution.tolerance, "error": contribution.error }));
            json!({
                "scene": format!("{index}.toml"), "worst": found_tolerances.worst, "three_sigma": found_tolerances.three_sigma,
                "sampled": found_tolerances.sampled, "jammed": found_tolerances.jammed, "contributions": each.collect::<Vec<_>>(),
            })
        });
        let title = "effect of manufacturing deviations, in addition to the error of the task".to_owned();
        Report { tables, notes, data: json!(data.collect::<Vec<_>>()), ..Report::new(row![title]) }
    }

    pub fn good(&self) -> impl Iterator<Item = &Solution> {
        self.solutions.iter().filter(|solution| solution.reason.is_none())
    }

    /// The ground that the task gives, or that is taken, where it has no size but that.
    fn ground(&self) -> Option<f64> {
        match self.task.kind {
            TaskKind::Function { is_slider: false, ground, .. } | TaskKind::Stroke { is_slider: false, ground, .. } => {
                Some(ground)
            }
            TaskKind::Function { .. } | TaskKind::Stroke { .. } | TaskKind::Poses { .. } | TaskKind::Path(_) => None,
        }
    }

    fn requested(&self) -> String {
        match &self.task.kind {
            TaskKind::Poses { at, .. } => count(at.len(), "pose"),
            TaskKind::Function { pairs, .. } => format!("a function of {}", count(pairs.len(), "pair")),
            TaskKind::Path(CouplerPath { points, closed, .. }) => {
                let kind = if *closed { "a closed path" } else { "a path" };
                format!("{kind} of {}", count(points.len(), "point"))
            }
            TaskKind::Stroke { is_slider: true, .. } => "a stroke".to_owned(),
            TaskKind::Stroke { .. } => "a swing".to_owned(),
        }
    }

    /// The unit of errors.
    fn error_unit(&self) -> &'static str {
        if self.task.is_angular() { "rad" } else { "m" }
    }

    fn table(&self) -> Table {
        self.rows(&self.solutions, "")
    }

    /// The limits that a linkage has just reached, and what the first of them costs.
    fn limited(&self, solution: &Solution) -> String {
        if solution.active.is_empty() {
            return String::new();
        }
        let names: Vec<String> = solution.active.iter().map(|limit| format!("`{}`", limit.name())).collect();
        let price = solution.price * if self.task.is_angular() { 1.0 } else { 1e3 };
        let gain = (price > 1e-6 && solution.active.contains(&LinkageLimit::Length))
            .then(|| format!("; {} mm less error (RMS) per metre of `length`", cotree::typeset::number(price, 0.0)));
        format!("at {}{}", names.join(", "), gain.unwrap_or_default())
    }

    fn rows(&self, solutions: &[Solution], prefix: &str) -> Table {
        let bars = |solution: &Solution| solution.lengths.map(|length| number(length.unwrap_or(f64::NAN), "m"));
        let line = |(index, solution): (usize, &Solution)| {
            let [ground, first, coupler, second] = bars(solution);
            let error = number(solution.error, self.error_unit());
            let name = solution
                .scene
                .as_ref()
                .filter(|_| solution.reason.is_none())
                .map_or("-".to_owned(), |_| format!("{prefix}{}.toml", index + 1));
            let note = solution.reason.clone().unwrap_or_else(|| self.limited(solution));
            row![
                name,
                solution.class,
                ground,
                first,
                coupler,
                second,
                number(solution.size, "m"),
                error,
                number(solution.transmission, "rad"),
                note
            ]
        };
        let columns = row![
            "scene",
            "linkage, input first",
            named("ground", "m"),
            named("first", "m"),
            named("coupler", "m"),
            named("second", "m"),
            named("size", "m"),
            named("error", self.error_unit()),
            named("transmission", "rad"),
            ""
        ];
        Table { left: 2, ..Table::new(columns, solutions.iter().enumerate().map(line)) }
    }

    fn six_table(&self) -> Table {
        let names = ["ground", "crank", "coupler", "second", "link", "output"];
        let lengths = names.into_iter().map(|name| named(name, "m"));
        let mut columns = row!["scene", "six-bar"];
        columns.extend(lengths);
        columns.extend(row![
            named("size", "m"),
            named("error", self.error_unit()),
            named("transmission", "rad"),
            named("and", "rad")
        ]);
        let rows = self.six_bars.iter().enumerate().map(|(index, six_bar)| {
            let mut cells = row![format!("six_{}.toml", index + 1), six_bar.kind.name()];
            cells.extend(six_bar.lengths.map(|length| number(length, "m")));
            let [first, second] = six_bar.transmission.map(|angle| number(angle, "rad"));
            cells.extend(row![number(six_bar.size, "m"), number(six_bar.error, self.error_unit()), first, second]);
            cells
        });
        let heading = Cell::from("six-bars, driven through the task".to_owned());
        Table { heading: Some(heading), left: 2, ..Table::new(columns, rows) }
    }

    fn data(&self) -> Value {
        let kind = match self.task.kind {
            TaskKind::Poses { .. } => "poses",
            TaskKind::Function { .. } => "function",
            TaskKind::Path(_) => "path",
            TaskKind::Stroke { .. } => "stroke",
        };
        let solution = |prefix: &str, index: usize, solution_data: &Solution| {
            let there = solution_data.scene.as_ref().filter(|_| solution_data.reason.is_none());
            let scene = there.map(|_| format!("{prefix}{}.toml", index + 1));
            let poses: Vec<[f64; 3]> =
                solution_data.poses.iter().map(|pose| [pose.at.re, pose.at.im, pose.angle]).collect();
            json!({
                "class": solution_data.class,
                "lengths": solution_data.lengths,
                "size": solution_data.size,
                "first": dyad(&solution_data.linkage.first),
                "second": dyad(&solution_data.linkage.second),
                "error": solution_data.error,
                "transmission": solution_data.transmission,
                "full_turn": solution_data.full_turn,
                "defects": solution_data.defects.iter().map(|defect| defect.name()).collect::<Vec<_>>(),
                "active": solution_data.active.iter().map(|limit| limit.name()).collect::<Vec<_>>(),
                "error_per_length": solution_data.price,
                "reason": solution_data.reason,
                "dyads": solution_data.dyads,
                "poses": poses,
                "driven_within": solution_data.driven,
                "scene": scene,
            })
        };
        let six = |(index, six_data): (usize, &SixSolution)| {
            json!({
                "kind": six_data.kind.name(),
                "lengths": six_data.lengths,
                "size": six_data.size,
                "error": six_data.error,
                "transmission": six_data.transmission,
                "full_turn": six_data.full_turn,
                "driven_within": six_data.driven,
                "scene": format!("six_{}.toml", index + 1),
            })
        };
        let list = |prefix: &str, all: &[Solution]| -> Vec<Value> {
            all.iter().enumerate().map(|(index, solution_data)| solution(prefix, index, solution_data)).collect()
        };
        json!({
            "name": self.task.name,
            "kind": kind,
            "dyads": self.dyads.iter().map(dyad).collect::<Vec<_>>(),
            "solutions": list("", &self.solutions),
            "shorter": list("shorter_", &self.shorter),
            "six_bars": self.six_bars.iter().enumerate().map(six).collect::<Vec<_>>(),
            "left_out": self.left_out,
            "looked_at": self.looked_at,
            "last": self.last,
            "costs": self.costs,
        })
    }
}

fn count(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}

fn dyad(dyad: &Dyad) -> Value {
    let pair = |point: Point| [point.re, point.im];
    match *dyad {
        Dyad::Bar { moving, ground, length } => {
            json!({ "kind": dyad.kind(), "moving": pair(moving), "ground": pair(ground), "length": length })
        }
        Dyad::Slider { moving, normal, offset } => {
            json!({ "kind": dyad.kind(), "moving": pair(moving), "normal": pair(normal), "offset": offset })
        }
        Dyad::Slot { ground, normal, offset } => {
            json!({ "kind": dyad.kind(), "ground": pair(ground), "normal": pair(normal), "offset": offset })
        }
    }
}
