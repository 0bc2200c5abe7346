//! What was found, as a table for people and as JSON.

use cotree::model::Units;
use cotree::report::data::{Cell, Report, Table, named, number};
use cotree::task::TaskKind;
use cotree::{line, row};
use cotree_synthesis::{Dyad, Point};
use serde_json::{Value, json};

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
        let title = format!("{}: {} for {}", self.task.name, count(good, "good linkage"), self.asked());
        let mut notes: Vec<Cell> = Vec::new();
        let others: Vec<String> = self.left_out.iter().map(|(reason, count)| format!("  {count}  {reason}")).collect();
        if !others.is_empty() {
            notes.push(Cell::from(format!("\nleft out, of {} that meet the task:", self.looked_at)));
            notes.extend(others.into_iter().map(Cell::from));
        }
        if good == 0 {
            let last = self.last.clone().unwrap_or_else(|| "no linkage meets the task".to_owned());
            notes.push(Cell::from(format!("\nno linkage is left; {last}")));
            let is_too_many = matches!(&self.task.kind, TaskKind::Poses { at, .. } if at.len() > MOST_POSES);
            notes.extend(is_too_many.then(|| {
                let advice = "four-bars take five poses and no more, but for special ones: these are far from what any of them does; leave some out";
                Cell::from(advice)
            }));
        }
        notes.extend(self.ground().map(|length| {
            line![
                "\nlengths are for a ground of ",
                number(length, "m"),
                ": `ground` of the task, 1 m if it says nothing"
            ]
        }));
        let tables = if self.solutions.is_empty() { Vec::new() } else { vec![self.table()] };
        Report { tables, notes, data: self.data(), ..Report::new(row![title]) }
    }

    pub fn good(&self) -> impl Iterator<Item = &Solution> {
        self.solutions.iter().filter(|own| own.reason.is_none())
    }

    /// The ground that the task gives, or that is taken, where it has no size but that.
    fn ground(&self) -> Option<f64> {
        match self.task.kind {
            TaskKind::Function { is_slider: false, ground, .. } | TaskKind::Stroke { is_slider: false, ground, .. } => {
                Some(ground)
            }
            TaskKind::Function { .. } | TaskKind::Stroke { .. } | TaskKind::Poses { .. } | TaskKind::Path { .. } => {
                None
            }
        }
    }

    fn asked(&self) -> String {
        match &self.task.kind {
            TaskKind::Poses { at, .. } => count(at.len(), "pose"),
            TaskKind::Function { input, .. } => format!("a function of {}", count(input.len(), "pair")),
            TaskKind::Path { points, closed, .. } => {
                let kind = if *closed { "a closed path" } else { "a path" };
                format!("{kind} of {}", count(points.len(), "point"))
            }
            TaskKind::Stroke { is_slider: true, .. } => "a stroke".to_owned(),
            TaskKind::Stroke { .. } => "a swing".to_owned(),
        }
    }

    /// The unit of errors.
    fn error_unit(&self) -> &'static str {
        if matches!(self.task.kind, TaskKind::Function { is_slider: false, .. }) { "rad" } else { "m" }
    }

    fn table(&self) -> Table {
        let bars = |own: &Solution| own.lengths.map(|length| number(length.unwrap_or(f64::NAN), "m"));
        let line = |(index, own): (usize, &Solution)| {
            let [ground, first, coupler, second] = bars(own);
            let error = number(own.error, self.error_unit());
            let name = own
                .scene
                .as_ref()
                .filter(|_| own.reason.is_none())
                .map_or("-".to_owned(), |_| format!("{}.toml", index + 1));
            let note = own.reason.clone().unwrap_or_default();
            row![name, own.class, ground, first, coupler, second, error, number(own.transmission, "rad"), note]
        };
        let columns = row![
            "scene",
            "linkage, input first",
            named("ground", "m"),
            named("first", "m"),
            named("coupler", "m"),
            named("second", "m"),
            named("error", self.error_unit()),
            named("transmission", "rad"),
            ""
        ];
        Table { left: 2, ..Table::new(columns, self.solutions.iter().enumerate().map(line)) }
    }

    fn data(&self) -> Value {
        let kind = match self.task.kind {
            TaskKind::Poses { .. } => "poses",
            TaskKind::Function { .. } => "function",
            TaskKind::Path { .. } => "path",
            TaskKind::Stroke { .. } => "stroke",
        };
        let solution = |(index, own): (usize, &Solution)| {
            let scene = own.scene.as_ref().filter(|_| own.reason.is_none()).map(|_| format!("{}.toml", index + 1));
            let poses: Vec<[f64; 3]> = own.poses.iter().map(|pose| [pose.at.re, pose.at.im, pose.angle]).collect();
            json!({
                "class": own.class,
                "lengths": own.lengths,
                "first": dyad(&own.linkage.first),
                "second": dyad(&own.linkage.second),
                "error": own.error,
                "transmission": own.transmission,
                "full_turn": own.full_turn,
                "defects": own.defects.iter().map(|defect| defect.name()).collect::<Vec<_>>(),
                "reason": own.reason,
                "dyads": own.dyads,
                "poses": poses,
                "driven_within": own.driven,
                "scene": scene,
            })
        };
        json!({
            "name": self.task.name,
            "kind": kind,
            "dyads": self.dyads.iter().map(dyad).collect::<Vec<_>>(),
            "solutions": self.solutions.iter().enumerate().map(solution).collect::<Vec<_>>(),
            "left_out": self.left_out,
            "looked_at": self.looked_at,
            "last": self.last,
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
