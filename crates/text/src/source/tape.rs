//! A tape as a function in C: straight-line code with local constants, without unused values.

use std::collections::BTreeSet;
use std::fmt::Write;

use cotree_fmu::program::Program;
use cotree_fmu::tape::{Operation, Tape};

/// Where the value of a register comes from.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// An argument or a constant, as it is written.
    Known(String),
    /// The result of a line; of a sine and cosine also the second.
    Line(usize),
    Second(usize),
}

/// What the lines of a tape read, which of them are needed, and the values of its results.
pub(super) struct Lines {
    pub operands: Vec<Vec<Value>>,
    pub needed: Vec<bool>,
    pub results: Vec<Value>,
}

/// Small functions that a text needs, by the names of their sections.
pub(super) type Helpers = BTreeSet<&'static str>;

/// Writes the tapes of a program.
pub(super) struct TapeWriter<'a> {
    program: &'a Program,
    pub helpers: Helpers,
    /// True if coordinates are sums of two numbers, of which functions of angles need both.
    compensated: bool,
}

impl<'a> TapeWriter<'a> {
    pub fn new(program: &'a Program, compensated: bool) -> Self {
        Self { program, helpers: Helpers::new(), compensated }
    }

    /// The first register behind the constants.
    fn stage_begin(&self) -> usize {
        self.program.layout().constants() + self.program.constants.len()
    }

    /// Registers that the tape of the parameters leaves to the others.
    pub fn stage(&self) -> usize {
        let targets = self.program.tapes.parameters.instructions().iter().flat_map(|instruction| instruction.targets());
        targets.max().map_or(0, |last| (last as usize + 1).saturating_sub(self.stage_begin()))
    }

    /// The tape of the parameters: it writes to the instance.
    pub fn stage_function(&mut self) -> String {
        let begin = self.stage_begin();
        let tape = &self.program.tapes.parameters;
        let results = (0..self.stage()).map(|index| ((begin + index) as u32, format!("m->stage[{index}]"))).collect();
        let lines = self.lines(tape, results);
        format!("static void @_parameters(@_model *m)\n{{\n    (void)m;\n{lines}}}\n\n")
    }

    /// A tape whose results are an array.
    pub fn function(&mut self, name: &str, tape: &Tape) -> String {
        let results = tape.results.iter().enumerate();
        let results = results.map(|(index, register)| (*register, format!("r[{index}]"))).collect();
        let lines = self.lines(tape, results);
        format!(
            "static void @_{name}(const @_model *m, const @_point *x, double *r)\n{{\n    (void)m;\n    (void)x;\n    (void)r;\n{lines}}}\n\n"
        )
    }

    fn lines(&mut self, tape: &Tape, results: Vec<(u32, String)>) -> String {
        let registers: Vec<u32> = results.iter().map(|(register, _)| *register).collect();
        let lines = self.needed(tape, &registers);
        let mut text = self.constants(tape, &lines);
        for (value, (_, place)) in lines.results.iter().zip(results) {
            let _ = writeln!(text, "    {place} = {};", written(value)); // writing to a string cannot fail
        }
        text
    }

    /// What a tape computes for these registers.
    pub fn needed(&self, tape: &Tape, results: &[u32]) -> Lines {
        let mut values: Vec<Option<Value>> = vec![None; self.program.registers as usize];
        let value = |values: &[Option<Value>], register: u32| {
            values
                .get(register as usize)
                .cloned()
                .flatten()
                .unwrap_or_else(|| Value::Known(self.known(register as usize)))
        };
        let mut operands: Vec<Vec<Value>> = Vec::new();
        for (line, instruction) in tape.instructions().iter().enumerate() {
            operands.push(instruction.operands().map(|operand| value(&values, operand)).collect());
            if instruction.operation == Operation::SinCos {
                values[instruction.c as usize] = Some(Value::Second(line));
            }
            values[instruction.target as usize] = Some(Value::Line(line));
        }
        let results: Vec<Value> = results.iter().map(|register| value(&values, *register)).collect();
        let mut needed = vec![false; operands.len()];
        let mark = |needed: &mut Vec<bool>, value: &Value| match value {
            Value::Line(line) | Value::Second(line) => needed[*line] = true,
            Value::Known(_) => {}
        };
        results.iter().for_each(|value| mark(&mut needed, value));
        for line in (0..operands.len()).rev() {
            if needed[line] {
                operands[line].iter().for_each(|value| mark(&mut needed, value));
            }
        }
        Lines { operands, needed, results }
    }

    /// A constant in C for each line that is needed.
    pub fn constants(&mut self, tape: &Tape, lines: &Lines) -> String {
        let mut text = String::new();
        for (line, instruction) in tape.instructions().iter().enumerate().filter(|(line, _)| lines.needed[*line]) {
            let given: Vec<String> = lines.operands[line].iter().map(written).collect();
            // Writing to a string cannot fail.
            let _ = if instruction.operation == Operation::SinCos {
                self.helpers.insert("sines");
                let angle = self.angle(&given[0]);
                writeln!(text, "    double x{line}, y{line};\n    @_sine_cosine({angle}, &x{line}, &y{line});")
            } else {
                let expression = self.expression(instruction.operation, &given);
                writeln!(text, "    const double x{line} = {expression};")
            };
        }
        text
    }

    /// The arguments of sine and cosine: the low part of an angle that turns on and on is more than the rounding of the functions.
    fn angle(&self, angle: &str) -> String {
        let low = angle.strip_prefix("x->q[").map(|index| format!("x->q_low[{index}"));
        match (self.compensated, low) {
            (false, _) => angle.to_owned(),
            (true, Some(low)) => format!("{angle}, {low}"),
            (true, None) => format!("{angle}, 0.0"),
        }
    }

    pub fn expression(&mut self, operation: Operation, given: &[String]) -> String {
        let [a, b, c] = [0, 1, 2].map(|index| given.get(index).map_or("", String::as_str));
        let mut helped = |helper: &'static str| {
            self.helpers.insert(helper);
        };
        match operation {
            Operation::Add => format!("{a} + {b}"),
            Operation::Subtract => format!("{a} - {b}"),
            Operation::Multiply => format!("{a} * {b}"),
            Operation::Divide => format!("{a} / {b}"),
            Operation::Negate => format!("-{a}"),
            Operation::MultiplyAdd => format!("{a} * {b} + {c}"),
            Operation::MultiplySubtract => format!("{a} * {b} - {c}"),
            Operation::SubtractProduct => format!("{c} - {a} * {b}"),
            Operation::SquareRoot => format!("sqrt({a})"),
            Operation::SinCos | Operation::Copy => a.to_owned(),
            Operation::Absolute => format!("fabs({a})"),
            Operation::Tangent => format!("tan({a})"),
            Operation::ArcSine => format!("asin({a})"),
            Operation::ArcCosine => format!("acos({a})"),
            Operation::ArcTangent => format!("atan({a})"),
            Operation::ArcTangent2 => format!("atan2({a}, {b})"),
            Operation::Exponential => format!("exp({a})"),
            Operation::Logarithm => format!("log({a})"),
            Operation::HyperbolicTangent => format!("tanh({a})"),
            Operation::Power => format!("pow({a}, {b})"),
            Operation::Floor => format!("floor({a})"),
            Operation::Sign => {
                helped("sign");
                format!("@_sign({a})")
            }
            Operation::Minimum => {
                helped("minimum");
                format!("@_minimum({a}, {b})")
            }
            Operation::Maximum => {
                helped("maximum");
                format!("@_maximum({a}, {b})")
            }
            Operation::Less => format!("{a} < {b} ? 1.0 : 0.0"),
            Operation::LessEqual => format!("{a} <= {b} ? 1.0 : 0.0"),
            Operation::Select => format!("{a} != 0.0 ? {b} : {c}"),
        }
    }

    /// A register that the tape does not write.
    fn known(&self, register: usize) -> String {
        let layout = self.program.layout();
        let begins: [(usize, &str); 12] = [
            (self.stage_begin(), "m->stage"),
            (layout.constants(), ""),
            (layout.reactions(), "x->lambda"),
            (layout.accelerations(), "x->a"),
            (layout.rates(), "x->v"),
            (layout.positions(), "x->q"),
            (layout.follower_accelerations(), "x->f_acceleration"),
            (layout.follower_rates(), "x->f_rate"),
            (layout.followers(), "x->f"),
            (layout.inputs(), "m->u"),
            (layout.discrete(), "m->d"),
            (layout.parameters(), "m->p"),
        ];
        let Some((begin, array)) = begins.into_iter().find(|(begin, _)| register >= *begin) else {
            return "x->t".to_owned();
        };
        let index = register - begin;
        match array {
            "" => number(self.program.constants[index]),
            // An input is constant during a step.
            "m->u" if index >= self.program.inputs.len() => "0.0".to_owned(),
            _ => format!("{array}[{index}]"),
        }
    }
}

pub(super) fn written(value: &Value) -> String {
    match value {
        Value::Known(text) => text.clone(),
        Value::Line(line) => format!("x{line}"),
        Value::Second(line) => format!("y{line}"),
    }
}

/// A number as C reads it back.
pub(super) fn number(value: f64) -> String {
    match value {
        _ if value.is_nan() => "((double)NAN)".to_owned(),
        f64::INFINITY => "((double)INFINITY)".to_owned(),
        f64::NEG_INFINITY => "(-(double)INFINITY)".to_owned(),
        _ if value.is_sign_negative() => format!("({value:?})"),
        _ => format!("{value:?}"),
    }
}
