//! What has happened in a run: each thing with its time in a file, and counted below a summary.

use std::collections::BTreeMap;

use cotree::report::data::composed;
use cotree::run::{Finish, Logged, What};
use cotree::typeset::{counted, short};
use serde_json::{Value, json};

use super::super::failure::Failure;
use super::super::output;
use super::super::units::ShownUnits;
use super::SimulateCommand;

/// Everything of one name.
#[derive(Default)]
struct Told {
    events: Vec<f64>,
    /// Times and impulses.
    impacts: Vec<(f64, f64)>,
    angular: bool,
    /// When it has closed or opened, or what rubs has begun to stick, to slide or to turn.
    changes: Vec<(f64, What)>,
}

impl SimulateCommand {
    /// A line for everything that has happened: CSV with the impulses of impacts.
    pub(super) fn write_log(&self, log: &[Logged]) -> Result<(), Failure> {
        let Some(path) = &self.log else { return Ok(()) };
        let mut text = "time,name,what,impulse\n".to_owned();
        for Logged { time, name, what } in log {
            let impulse = if let What::Impact { impulse, .. } = what { format!("{impulse:?}") } else { String::new() };
            text += &format!("{time:?},{name},{},{impulse}\n", what.word());
        }
        output::put(output::file(Some(path)), &text)
    }

    /// How often each event has happened, and what each limit, contact, rope and joint that engages has done.
    pub(super) fn say_happened(&self, finish: &Finish, shown: &ShownUnits) -> Result<(), Failure> {
        let all = told(finish);
        let of = |(name, count): &(String, u32)| match all.get(name.as_str()) {
            Some(of_name) if of_name.events.is_empty() => format!("{name}: {}\n", of_name.sentence(shown)),
            Some(of_name) => format!("event {name}: {}{}\n", counted(*count as usize, "time"), of_name.last()),
            None => format!("{name}: no events\n"),
        };
        let is_counted = |name: &str| finish.events.iter().any(|(counted, _)| counted == name);
        let joined = all.iter().filter(|(name, _)| !is_counted(name));
        let joined = joined.map(|(name, of_name)| format!("{name}: {}\n", of_name.sentence(shown)));
        output::print(&finish.events.iter().map(of).chain(joined).collect::<String>())
    }
}

fn told(finish: &Finish) -> BTreeMap<&str, Told> {
    let mut all: BTreeMap<&str, Told> = BTreeMap::new();
    for Logged { time, name, what } in &finish.log {
        let of_name = all.entry(name).or_default();
        match *what {
            What::Event => of_name.events.push(*time),
            What::Impact { impulse, angular } => {
                of_name.impacts.push((*time, impulse));
                of_name.angular = angular;
            }
            What::Closes | What::Opens | What::Sticks | What::Slips | What::Turns => {
                of_name.changes.push((*time, *what))
            }
            What::Engages { .. } | What::Releases => of_name.changes.push((*time, *what)),
        }
    }
    all
}

impl Told {
    /// When an event has happened last.
    fn last(&self) -> String {
        self.events.last().map(|time| format!(", the last at t = {} s", short(*time))).unwrap_or_default()
    }

    fn sentence(&self, shown: &ShownUnits) -> String {
        let mut parts = Vec::new();
        let largest = self.impacts.iter().copied().max_by(|one, other| one.1.total_cmp(&other.1));
        if let (Some((when, most)), Some((last, _))) = (largest, self.impacts.last()) {
            let unit = composed(&shown.units, if self.angular { "N.m.s" } else { "N.s" });
            let (most, when, last) = (short(most / unit.factor), short(when), short(*last));
            parts.push(format!(
                "{}, the largest of {most} {} at t = {when} s, the last at t = {last} s",
                counted(self.impacts.len(), "impact"),
                unit.name
            ));
        }
        for change in [What::Opens, What::Slips, What::Turns] {
            let count = self.changes.iter().filter(|(_, what)| *what == change).count();
            if count > 0 {
                parts.push(format!("{} {}", change.word(), counted(count, "time")));
            }
        }
        if let Some((time, what)) = self.changes.last() {
            let state = match what {
                What::Closes => "stays closed",
                What::Opens => "is open",
                What::Sticks => "sticks",
                What::Slips | What::Turns => "slides",
                What::Engages { .. } => "is engaged",
                What::Releases => "is released",
                What::Event | What::Impact { .. } => "has happened",
            };
            parts.push(format!("{state} from t = {} s on", short(*time)));
        }
        let lost = self
            .changes
            .iter()
            .filter_map(|(_, what)| if let What::Engages { lost } = what { Some(lost) } else { None });
        if let Some(lost) = lost.copied().reduce(|sum, lost| sum + lost) {
            let unit = composed(&shown.units, "J");
            parts.push(format!("{} {} lost by engaging", short(lost / unit.factor), unit.name));
        }
        parts.join("; ")
    }
}

/// Everything that has happened, for scripts.
pub(super) fn data(finish: &Finish) -> Value {
    let one = |entry: &Logged| {
        let mut value = json!({"time": entry.time, "name": entry.name, "what": entry.what.word()});
        if let What::Impact { impulse, .. } = entry.what {
            value["impulse"] = json!(impulse);
        }
        if let What::Engages { lost } = entry.what {
            value["lost_energy"] = json!(lost);
        }
        value
    };
    finish.log.iter().map(one).collect()
}
