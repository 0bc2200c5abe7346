//! A mechanism as C source for real-time targets: one file with a solver of fixed step and fixed cost.
//!
//! The tapes of the program, which the runtime of an FMU runs, become functions in C with the same operations in the same order. Around them stands a solver that is written
//! once (`solver.c`): the Runge-Kutta method of order 4 or a Taylor series of order 8, one projection onto the loop equations at each step, and a guard that ends the run where
//! that projection would correct more than the method can have missed.

mod fmi;
mod poles;
mod refused;
mod series;
mod single;
mod tables;
mod tape;

use std::collections::BTreeSet;

use cotree::export::description::Description;
use cotree::model::Mechanism;
use cotree::scene::{Faults, Source};
use cotree_fmu::program::domain::Limit;
use cotree_fmu::program::{Program, Role};

pub use fmi::{fmu_sources, wrapper_name};
pub use poles::StepLimit;
use series::SeriesWriter;
use tables::Tables;
use tape::{TapeWriter, number};

const SOLVER: &str = include_str!("solver.c");
const CORRECTION: &str = include_str!("assemble.c");
const ASSEMBLY: &str = include_str!("closing.c");

/// The step that a scene is stepped with, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedStep {
    /// From one communication point to the next \[s\].
    pub step: f64,
    /// Into how many steps of the solver it is divided.
    pub substeps: u32,
    /// What the solver does in a step.
    pub method: SourceMethod,
    /// What its numbers are.
    pub real: Real,
}

/// A method of fixed step and order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SourceMethod {
    /// The classical one, of order 4.
    #[default]
    RungeKutta,
    /// Taylor series in time of order 8.
    Taylor,
}

impl SourceMethod {
    /// Each order, and the method that has it.
    pub const WORDS: [(&'static str, &'static str, Self); 2] = [
        ("4", "the Runge-Kutta method", Self::RungeKutta),
        ("8", "Taylor series in time, for longer steps", Self::Taylor),
    ];

    fn order(self) -> usize {
        match self {
            Self::RungeKutta => 4,
            Self::Taylor => series::ORDER,
        }
    }
}

/// The floating-point type of the sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Real {
    /// Double precision.
    #[default]
    Double,
    /// Single precision.
    Float,
}

impl Real {
    /// Each type in C, its meaning, and the type.
    pub const WORDS: [(&'static str, &'static str, Self); 2] = [
        ("double", "double precision", Self::Double),
        ("float", "single precision, with compensated sums", Self::Float),
    ];
}

impl FixedStep {
    /// The step of the solver \[s\].
    pub fn solver_step(self) -> f64 {
        self.step / f64::from(self.substeps)
    }

    /// Time after so many steps of the solver, as C computes it.
    fn time(self, steps: &str) -> String {
        let step = self.solver_step();
        // A step such as 1 ms is no binary number, but a thousand of them are a second.
        let per_second = (1.0 / step).round();
        if per_second >= 1.0 && 1.0 / per_second == step {
            format!("(double){steps} / {}", number(per_second))
        } else {
            format!("(double){steps} * {}", number(step))
        }
    }
}

/// The file, which stands alone.
///
/// # Errors
/// What this solver does not support, with its name and place; a step that is not stable.
pub fn c_file(
    program: &Program,
    mechanism: &Mechanism,
    description: &Description,
    source: &Source,
    step: FixedStep,
) -> Result<String, Faults> {
    let start = refused::start(program, source)?;
    refused::check(program, mechanism, &start, source, step)?;
    let text = Writer { program, description, step, start: &start }.file();
    match step.real {
        Real::Double => Ok(text),
        Real::Float => single::in_single_precision(&text).map_err(|number| refused::beyond_single(&number, source)),
    }
}

/// Where a run begins, as the runtime finds it: the registers, with what the parameters determine.
struct Start {
    registers: Vec<f64>,
}

struct Writer<'a> {
    program: &'a Program,
    description: &'a Description,
    step: FixedStep,
    start: &'a Start,
}

impl<'a> Writer<'a> {
    fn file(&self) -> String {
        let program = self.program;
        let mut tapes = TapeWriter::new(program, self.step.real == Real::Float);
        let mut flags = self.flags();
        let functions = self.functions(&mut tapes, &flags);
        flags.extend(tapes.helpers.iter().copied());
        flags.extend(series::HELPERS.iter().filter(|helper| functions.contains(&format!("@_{helper}("))));
        if self.step.real == Real::Float && flags.remove("sines") {
            flags.insert("single_sines");
        }
        let tables = Tables { program, step: self.step, start: self.start };
        let mut marks = self.sizes(tapes.stage());
        marks.extend(self.texts(&flags));
        marks.extend(tables.counts());
        marks.extend(tolerances(self.step.real));
        marks.push(("FUNCTIONS", functions));
        marks.push(("TABLES", tables.text(&flags)));
        marks.push(("ASSEMBLE", self.assembly(&flags, &marks)));
        let text = filled(&sections(SOLVER, &flags), &marks);
        text.replace('@', &self.description.identifier)
    }

    /// Which sections of the solver are needed.
    fn flags(&self) -> BTreeSet<&'static str> {
        let (program, instants) = (self.program, &self.program.instants);
        let loops = !program.tapes.project_position.results.is_empty();
        let driven = loops && program.is_driven();
        let writes = !instants.samplers.is_empty() || !instants.events.is_empty();
        let tables = Tables { program, step: self.step, start: self.start };
        let known = [
            ("loops", loops),
            ("driven", driven),
            ("free", !driven),
            ("free_loops", loops && !driven),
            ("runge", !driven && self.step.method == SourceMethod::RungeKutta),
            ("taylor", !driven && self.step.method == SourceMethod::Taylor),
            ("compensated", self.step.real == Real::Float),
            ("plain", self.step.real == Real::Double),
            ("followers", !program.followers.is_empty()),
            ("discrete", !program.discrete.is_empty()),
            ("removes", instants.events.iter().any(|event| !event.removes.is_empty())),
            ("happens", writes),
            ("samplers", !instants.samplers.is_empty()),
            ("events", !instants.events.is_empty()),
            ("ranges", !program.tapes.ranges.tape.results.is_empty()),
            ("outputs", !program.tapes.outputs.results.is_empty()),
            ("positions", tables.rows(Level::Position) > 0),
            ("velocities", tables.rows(Level::Velocity) > 0),
            ("searched", tables.rows(Level::Position) + tables.rows(Level::Velocity) > 0),
            ("undetermined", tables.rows(Level::Position) != tables.columns(Level::Position)),
            ("guessed", !tables.guesses().is_empty()),
        ];
        known.into_iter().filter(|(_, is)| *is).map(|(name, _)| name).collect()
    }

    fn functions(&self, tapes: &mut TapeWriter<'a>, flags: &BTreeSet<&'static str>) -> String {
        let (program, initial, instants) = (self.program, &self.program.initial, &self.program.instants);
        let kernels = &program.tapes;
        let all = [
            ("constraint", &kernels.constraint, true),
            ("acceleration", &kernels.acceleration, true),
            ("project_position", &kernels.project_position, flags.contains("loops")),
            ("project_velocity", &kernels.project_velocity, flags.contains("loops")),
            ("constraint_rate", &kernels.constraint_rate, flags.contains("velocities")),
            ("jacobian", &kernels.jacobian.tape, flags.contains("searched")),
            ("position_condition", &initial.position, flags.contains("positions") || flags.contains("guessed")),
            ("position_condition_jacobian", &initial.position_jacobian.tape, flags.contains("positions")),
            ("velocity_condition", &initial.velocity, flags.contains("velocities")),
            ("velocity_condition_jacobian", &initial.velocity_jacobian.tape, flags.contains("velocities")),
            ("ranges", &kernels.ranges.tape, flags.contains("ranges")),
            ("begin", &instants.begin, flags.contains("discrete")),
            ("written", &instants.written, flags.contains("happens")),
            ("sides", &instants.sides, flags.contains("events")),
            ("evaluate", &kernels.outputs, flags.contains("outputs")),
        ];
        let needed = all.into_iter().filter(|(.., needed)| *needed);
        let mut text = tapes.stage_function();
        needed.for_each(|(name, tape, _)| text += &tapes.function(name, tape));
        if flags.contains("taylor") {
            text += &SeriesWriter::new(program, tapes).function();
        }
        text
    }

    /// How long arrays are; none is empty.
    fn sizes(&self, stage: usize) -> Vec<(&'static str, String)> {
        let (program, instants) = (self.program, &self.program.instants);
        let sizes: [(&str, &str, usize); 10] = [
            ("P", "P1", program.parameters.len()),
            ("D", "D1", program.discrete.len()),
            ("U", "U1", program.inputs.len()),
            ("Y", "Y1", program.tapes.outputs.results.len()),
            ("N", "N1", program.coordinates.len()),
            ("M", "M1", program.constraints.len()),
            ("F", "F1", program.followers.len()),
            ("S", "S1", stage),
            ("E", "E1", instants.events.len()),
            ("WRITTEN", "W1", instants.written.results.len()),
        ];
        let mut marks: Vec<(&'static str, String)> = sizes
            .into_iter()
            .flat_map(|(name, array, size)| [(name, size.to_string()), (array, size.max(1).to_string())])
            .collect();
        marks.extend([
            ("NZ", program.states.to_string()),
            ("NQ", program.mechanical().to_string()),
            ("K", self.step.substeps.to_string()),
            ("BEGIN", instants.begin.results.len().to_string()),
            ("RANGES", program.tapes.ranges.tape.results.len().max(1).to_string()),
        ]);
        marks
    }

    fn texts(&self, flags: &BTreeSet<&'static str>) -> Vec<(&'static str, String)> {
        let program = self.program;
        let FixedStep { step, substeps, .. } = self.step;
        let [loops, driven, taylor] = ["loops", "driven", "taylor"].map(|section| flags.contains(section));
        let method = if taylor { "Taylor series of order 8" } else { "the Runge-Kutta method of order 4" };
        let divided = if substeps > 1 { format!(", divided into {substeps}") } else { String::new() };
        let quoted = |names: Vec<&str>| match names.is_empty() {
            true => "\"\"".to_owned(),
            false => names
                .iter()
                .map(|name| format!("\"{}\"", comment(name).replace(['"', '\\'], "'")))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let closed = match (loops, driven) {
            (_, true) => "; drivers determine the motion, by a fixed number of Newton steps",
            (true, _) => ", and one projection onto the loop equations",
            _ => "",
        };
        let of_ranges = program.tapes.ranges.domains.iter().enumerate();
        let in_range: Vec<String> =
            of_ranges.map(|(index, range)| allowed(range.limit, &format!("r[{index}]"))).collect();
        vec![
            ("TITLE", comment(&self.description.model_name)),
            ("VERSION", env!("CARGO_PKG_VERSION").to_owned()),
            ("STEP", format!("{step}")),
            ("SUBSTEPS", divided),
            ("METHOD", method.to_owned()),
            ("CLOSED", closed.to_owned()),
            ("METRIC", if driven { "" } else { " in the metric of the mass matrix" }.to_owned()),
            ("LEGEND", self.legend()),
            ("TIME", self.step.time("step")),
            ("H", number(self.step.solver_step())),
            ("ORDER", self.step.method.order().to_string()),
            ("WIDTH", (self.step.method.order() + 1).to_string()),
            ("DIVERGED", if taylor { ", @_DIVERGED" } else { "" }.to_owned()),
            ("DIVERGED_MESSAGE", if taylor { DIVERGED } else { "" }.to_owned()),
            ("NEWTON", if driven { "4" } else { "1" }.to_owned()),
            ("START", number(program.experiment.start)),
            ("IN_RANGE", if in_range.is_empty() { "1".to_owned() } else { in_range.join("\n        && ") }),
            ("FOLLOWED_INPUT", if program.followers.is_empty() { "0.0" } else { "m->u[@_followed[i]]" }.to_owned()),
            ("COORDINATES", quoted(program.coordinates.iter().map(|coordinate| coordinate.name.as_str()).collect())),
            ("LOOPS", quoted(program.constraints.iter().map(|constraint| constraint.owner.as_str()).collect())),
        ]
    }

    /// What stands in the arrays of an instance.
    fn legend(&self) -> String {
        use cotree_fmu::program::Source as Of;
        let variables = self.program.variables.iter().zip(&self.description.variables);
        let rows = variables.filter_map(|(variable, described)| {
            let place = match variable.source {
                Of::Parameter(index) => format!("p[{index}]"),
                Of::Discrete(index) => format!("d[{index}]"),
                Of::Input(index) => format!("u[{index}]"),
                Of::Output { result, .. } => format!("y[{result}]"),
                Of::Coordinate(index) => format!("x.q[{index}]"),
                Of::Rate(index) => format!("x.v[{index}]"),
                Of::Acceleration(index) => format!("x.a[{index}]"),
                Of::Time => return None,
            };
            Some(format!("   {place:10} {} [{}]\n", comment(&variable.name), comment(&described.unit.si)))
        });
        format!("\n{}", rows.collect::<String>())
    }

    fn assembly(&self, flags: &BTreeSet<&'static str>, marks: &[(&'static str, String)]) -> String {
        let tables = Tables { program: self.program, step: self.step, start: self.start };
        let mut text = String::new();
        for level in [Level::Position, Level::Velocity].into_iter().filter(|level| tables.rows(*level) > 0) {
            text += &filled(CORRECTION, &tables.marks(level));
        }
        let closing = filled(&sections(ASSEMBLY, flags), &tables.of_guesses());
        filled(&(text + &closing), marks)
    }
}

/// Positions or rates at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Position,
    Velocity,
}

/// True for a loop equation that the start solves.
fn is_solved(role: Role) -> bool {
    role == Role::Imposed
}

const DIVERGED: &str =
    ",\n        \"the Taylor series of the motion does not converge within the step: the step is too long\"";

/// What rounding leaves at least, as the guards of the start and of the loops must allow it.
fn tolerances(real: Real) -> Vec<(&'static str, String)> {
    let [pivot, same, close, open] = match real {
        Real::Double => ["1.0e-12", "1.0e-12", "1.0e-9", "1.0e-6"],
        Real::Float => ["1.0e-6", "1.0e-6", "1.0e-5", "1.0e-5"],
    };
    [("PIVOT", pivot), ("SAME", same), ("CLOSE", close), ("GAP", open)]
        .map(|(name, value)| (name, value.to_owned()))
        .into()
}

/// What stands in a comment cannot end it.
fn comment(text: &str) -> String {
    text.replace("*/", "* /").replace("/*", "/ *").replace(['\n', '@', '$'], " ")
}

/// The condition under which a value is allowed, as C writes it.
fn allowed(limit: Limit, value: &str) -> String {
    let finite = format!("@_is_finite({value})");
    match limit {
        Limit::Divisor => format!("({value} < 0.0 || {value} > 0.0)"),
        Limit::NotZero => format!("({finite} && ({value} < 0.0 || {value} > 0.0))"),
        Limit::Root | Limit::Base | Limit::NotNegative => format!("{value} >= 0.0"),
        Limit::Share => format!("({value} >= 0.0 && {value} <= 1.0)"),
        Limit::Logarithm | Limit::Distance | Limit::Positive => format!("{value} > 0.0"),
        Limit::AtLeast(least) => format!("({finite} && {value} >= {})", number(least)),
        Limit::AtMost(most) => format!("({finite} && {value} <= {})", number(most)),
        Limit::ArcSine => format!("fabs({value}) <= 1.0"),
        Limit::Value => finite,
    }
}

/// The lines of a text without those sections, from a line `//?name` to a line `//.`, that are not wanted.
fn sections(text: &str, flags: &BTreeSet<&'static str>) -> String {
    let mut open: Vec<bool> = Vec::new();
    let mut kept = String::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("//?") {
            open.push(flags.contains(name));
        } else if line == "//." {
            open.pop();
        } else if open.iter().all(|wanted| *wanted) {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

/// A text in which each `$NAME$` is replaced.
fn filled(text: &str, marks: &[(&'static str, String)]) -> String {
    marks.iter().fold(text.to_owned(), |text, (name, value)| text.replace(&format!("${name}$"), value))
}
