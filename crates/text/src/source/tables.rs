//! The constants of a model as arrays in C: start values, scales, names, what sample times and events write.

use std::collections::BTreeSet;
use std::fmt::{Display, Write};

use cotree_fmu::program::{Condition, Program, SparseTape, Write as Written};

use super::tape::number;
use super::{FixedStep, Level, Start, is_solved};

pub(super) struct Tables<'a> {
    pub program: &'a Program,
    pub step: FixedStep,
    pub start: &'a Start,
}

/// When a sampler is due, counted in steps from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SampleTime {
    pub first: u64,
    pub period: u64,
}

impl SampleTime {
    /// None if the period or the offset is no multiple of the step.
    pub fn new([period, offset]: [f64; 2], begin: f64, step: f64) -> Option<Self> {
        let steps = |time: f64| {
            let count = (time / step).round();
            (count.abs() < 1e15 && (time - count * step).abs() <= 1e-6 * step).then_some(count as i64)
        };
        let period = steps(period).filter(|period| *period > 0)?;
        let offset = steps(offset - begin)?;
        let first = if offset < 0 { offset.rem_euclid(period) } else { offset };
        Some(Self { first: first as u64, period: period as u64 })
    }
}

impl Tables<'_> {
    /// What one level of the start solves: numbers of loop equations, then of conditions.
    fn solved(&self, level: Level) -> Vec<usize> {
        let loops = self
            .program
            .constraints
            .iter()
            .enumerate()
            .filter(|(_, constraint)| is_solved(constraint.role))
            .map(|(row, _)| row);
        let known = self.conditions(level).iter().enumerate().filter(|(_, condition)| condition.known);
        loops.chain(known.map(|(index, _)| self.program.constraints.len() + index)).collect()
    }

    pub fn rows(&self, level: Level) -> usize {
        self.solved(level).len()
    }

    pub fn columns(&self, level: Level) -> usize {
        self.unknowns(level) + self.program.followers.len()
    }

    fn unknowns(&self, level: Level) -> usize {
        match level {
            Level::Position => self.program.mechanical(),
            Level::Velocity => self.program.coordinates.len(),
        }
    }

    fn conditions(&self, level: Level) -> &[Condition] {
        match level {
            Level::Position => &self.program.initial.positions,
            Level::Velocity => &self.program.initial.velocities,
        }
    }

    /// Conditions that pick the assembly mode: the one that the export has found holds for their values only.
    pub fn guesses(&self) -> Vec<usize> {
        let conditions = self.program.initial.positions.iter().enumerate();
        conditions.filter(|(_, condition)| !condition.known).map(|(index, _)| index).collect()
    }

    pub fn of_guesses(&self) -> Vec<(&'static str, String)> {
        vec![
            ("GUESSES", self.guesses().len().to_string()),
            ("CONDITION_RESULTS", (2 * self.program.initial.positions.len()).max(1).to_string()),
        ]
    }

    pub fn counts(&self) -> Vec<(&'static str, String)> {
        vec![
            ("SAMPLER_WRITES", self.sampled().len().to_string()),
            ("REMOVES", self.removed().len().to_string()),
            ("EVENT_WRITES", self.on_events().len().max(1).to_string()),
        ]
    }

    /// The marks of the text that corrects one level.
    pub fn marks(&self, level: Level) -> Vec<(&'static str, String)> {
        let initial = &self.program.initial;
        let (name, gap, [x, follower], entries) = match level {
            Level::Position => ("position", "constraint", ["q", "f"], &initial.position_jacobian),
            Level::Velocity => ("velocity", "constraint_rate", ["v", "f_rate"], &initial.velocity_jacobian),
        };
        let jacobian = &self.program.tapes.jacobian;
        let count = |tape: &SparseTape, first: usize| self.entries(level, tape, first).len();
        let size = jacobian.entries.len().max(entries.entries.len()).max(1);
        vec![
            ("LEVEL", name.to_owned()),
            ("GAP", gap.to_owned()),
            ("X", x.to_owned()),
            ("FX", follower.to_owned()),
            ("ROWS", self.rows(level).to_string()),
            ("COLUMNS", self.columns(level).to_string()),
            ("UNKNOWNS", self.unknowns(level).to_string()),
            ("CONDITIONS", self.conditions(level).len().to_string()),
            ("ENTRIES", size.to_string()),
            ("LOOP_ENTRIES", count(jacobian, 0).to_string()),
            ("CONDITION_ENTRIES", count(entries, self.program.constraints.len()).to_string()),
            ("REACH", if level == Level::Position { "0.5" } else { "1.0e30" }.to_owned()),
        ]
    }

    /// Row and column of each entry of a Jacobian that one level needs, and its place among the results; rows of the tape are numbered from `first`.
    fn entries(&self, level: Level, jacobian: &SparseTape, first: usize) -> Vec<[usize; 3]> {
        let (solved, rates) = (self.solved(level), self.program.coordinates.len());
        let column = |column: usize| match column.checked_sub(rates) {
            Some(follower) => Some(self.unknowns(level) + follower),
            None => (column < self.unknowns(level)).then_some(column),
        };
        let entries = jacobian.entries.iter().enumerate();
        let needed = entries.filter_map(|(result, &(row, unknown))| {
            let row = solved.iter().position(|solved| *solved == first + row as usize)?;
            Some([row, column(unknown as usize)?, result])
        });
        needed.collect()
    }

    /// All arrays that the sections of the solver read.
    pub fn text(&self, flags: &BTreeSet<&'static str>) -> String {
        let program = self.program;
        let layout = program.layout();
        let mut text = String::new();
        let mut add = |array: String| text += &array;
        let registers = |first: usize, count: usize| self.start.registers.iter().skip(first).take(count).copied();
        let rates = program.coordinates.len();
        add(numbers("start_p", program.parameters.iter().map(|parameter| parameter.start)));
        if flags.contains("discrete") {
            add(numbers("start_d", program.discrete.iter().map(|discrete| discrete.start)));
        }
        add(numbers("start_u", program.inputs.iter().map(|input| input.start)));
        add(numbers("start_q", registers(layout.positions(), rates)));
        add(numbers("start_v", registers(layout.rates(), rates)));
        add(numbers("start_f", registers(layout.followers(), 2 * program.followers.len())));
        add(numbers("gap_scale", program.constraints.iter().map(|constraint| constraint.scale)));
        if flags.contains("loops") || flags.contains("taylor") {
            add(numbers("scale", program.coordinates.iter().map(|coordinate| coordinate.scale)));
        }
        if flags.contains("followers") {
            add(integers("followed", "int", program.followers.iter().map(|follower| follower.input)));
        }
        if flags.contains("guessed") {
            add(self.guess_arrays());
        }
        for (level, name) in [(Level::Position, "positions"), (Level::Velocity, "velocities")] {
            if flags.contains(name) {
                add(self.level_arrays(level));
            }
        }
        if flags.contains("samplers") {
            add(self.sample_arrays());
        }
        if flags.contains("events") {
            add(self.event_arrays());
        }
        text
    }

    fn guess_arrays(&self) -> String {
        let (initial, guesses) = (&self.program.initial, self.guesses());
        let mut registers = self.start.registers.clone();
        initial.position.run(&mut registers);
        let targets: Vec<f64> = initial.position.results(&registers).collect();
        let places = guesses.iter().map(|index| index + initial.positions.len());
        let values = places.clone().filter_map(|place| targets.get(place).copied());
        integers("guess", "int", places.clone()) + &numbers("guessed", values)
    }

    fn level_arrays(&self, level: Level) -> String {
        let (program, initial) = (self.program, &self.program.initial);
        let (name, conditions) = match level {
            Level::Position => ("position", &initial.position_jacobian),
            Level::Velocity => ("velocity", &initial.velocity_jacobian),
        };
        let count = program.constraints.len();
        let scale = |row: &usize| match row.checked_sub(count) {
            Some(condition) => self.conditions(level)[condition].scale,
            None => program.constraints[*row].scale,
        };
        let followers = program.followers.iter().map(|follower| follower.scale);
        let columns =
            program.coordinates.iter().take(self.unknowns(level)).map(|coordinate| coordinate.scale).chain(followers);
        let solved = self.solved(level);
        integers(&format!("{name}_row"), "int", solved.iter())
            + &numbers(&format!("{name}_row_scale"), solved.iter().map(scale))
            + &numbers(&format!("{name}_column_scale"), columns)
            + &triples(&format!("{name}_loop_entries"), self.entries(level, &program.tapes.jacobian, 0))
            + &triples(&format!("{name}_condition_entries"), self.entries(level, conditions, count))
    }

    /// When each sampler is due.
    pub fn sample_times(&self) -> Vec<Option<SampleTime>> {
        let mut registers = self.start.registers.clone();
        let clocks = &self.program.instants.clocks;
        clocks.run(&mut registers);
        let times: Vec<f64> = clocks.results(&registers).collect();
        let begin = self.program.experiment.start;
        let (pairs, _) = times.as_chunks::<2>();
        pairs.iter().map(|pair| SampleTime::new(*pair, begin, self.step.solver_step())).collect()
    }

    /// What samplers write, each with its sample time.
    fn sampled(&self) -> Vec<(SampleTime, &Written)> {
        let samplers = self.sample_times().into_iter().zip(&self.program.instants.samplers);
        samplers
            .flat_map(|(time, sampler)| sampler.writes.iter().filter_map(move |write| Some((time?, write))))
            .collect()
    }

    fn on_events(&self) -> Vec<[usize; 3]> {
        let events = self.program.instants.events.iter().enumerate();
        events
            .flat_map(|(event, event_data)| {
                event_data.writes.iter().map(move |write| [write.target as usize, write.result as usize, event])
            })
            .collect()
    }

    /// Discrete variables that events set to zero, each with its event.
    fn removed(&self) -> Vec<[usize; 2]> {
        let events = self.program.instants.events.iter().enumerate();
        events.flat_map(|(event, data)| data.removes.iter().map(move |&place| [place as usize, event])).collect()
    }

    fn removals(&self) -> String {
        let removed: Vec<String> =
            self.removed().iter().map(|[place, event]| format!("{{ {place}, {event} }}")).collect();
        if removed.is_empty() {
            return String::new();
        }
        format!("static const int @_event_removes[][2] = {{ {} }};\n", removed.join(", "))
    }

    fn sample_arrays(&self) -> String {
        let sampled = self.sampled();
        let writes: Vec<String> =
            sampled.iter().map(|(_, write)| format!("{{ {}, {} }}", write.target, write.result)).collect();
        integers("sample_first", "unsigned long", sampled.iter().map(|(time, _)| time.first))
            + &integers("sample_period", "unsigned long", sampled.iter().map(|(time, _)| time.period))
            + &format!("static const int @_sample_writes[][2] = {{ {} }};\n", writes.join(", "))
    }

    fn event_arrays(&self) -> String {
        let events = &self.program.instants.events;
        integers("event_is_strict", "int", events.iter().map(|event| u8::from(event.strict)))
            + &integers("event_is_single", "int", events.iter().map(|event| u8::from(event.once)))
            + &integers("event_is_last", "int", events.iter().map(|event| u8::from(event.stop)))
            + &self.removals()
            + &if self.on_events().is_empty() {
                "static const int @_event_writes[1][3] = { { 0, 0, -1 } };\n".to_owned()
            } else {
                triples("event_writes", self.on_events())
            }
    }
}

/// An array is never empty.
fn array(name: &str, kind: &str, mut values: Vec<String>) -> String {
    if values.is_empty() {
        values.push("0".to_owned());
    }
    let mut text = format!("static const {kind} @_{name}[] = {{");
    for (index, value) in values.iter().enumerate() {
        let gap = if index % 8 == 0 { "\n    " } else { " " };
        let comma = if index + 1 < values.len() { "," } else { "" };
        let _ = write!(text, "{gap}{value}{comma}"); // writing to a string cannot fail
    }
    text + "\n};\n"
}

fn numbers(name: &str, values: impl Iterator<Item = f64>) -> String {
    array(name, "double", values.map(number).collect())
}

fn integers(name: &str, kind: &str, values: impl Iterator<Item = impl Display>) -> String {
    array(name, kind, values.map(|value| value.to_string()).collect())
}

fn triples(name: &str, values: Vec<[usize; 3]>) -> String {
    let mut written: Vec<String> = values.iter().map(|[a, b, c]| format!("{{ {a}, {b}, {c} }}")).collect();
    if written.is_empty() {
        written.push("{ 0, 0, 0 }".to_owned());
    }
    format!("static const int @_{name}[][3] = {{\n    {}\n}};\n", written.join(",\n    "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_times_are_counted_in_steps_and_refused_between_them() {
        let of = |period, offset| SampleTime::new([period, offset], 0.0, 1e-3);
        assert_eq!(of(0.02, 0.005), Some(SampleTime { first: 5, period: 20 }));
        assert_eq!(of(0.02, -0.005), Some(SampleTime { first: 15, period: 20 }));
        assert_eq!(of(0.0205, 0.0), None);
        assert_eq!(of(0.02, 0.0003), None);
        assert_eq!(of(0.0, 0.0), None);
    }
}
