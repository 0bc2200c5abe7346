//! C99.

use std::fmt::Write;

use super::{Function, Kinematics, Language, Operand, Output, Sizes, Step, argument, wrapped};
use crate::expr::{Binary, Symbol, Unary};

/// Sine and cosine as the runtime computes them, and the small functions that C lacks.
const PRELUDE: &str = include_str!("prelude.c");

/// Functions over arrays, matrices by rows.
#[derive(Clone, Copy, Debug)]
pub struct C;

impl Language for C {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!(
            "/* Equations of motion of `{name}`, C99. Compile without contraction: -ffp-contract=off.\n   \
             Matrices are stored by rows. The same bits as the kernels; only tan, exp, pow and their kin are those of the\n   \
             C library.\n"
        );
        for line in legend.iter().flat_map(|line| wrapped(line, 110)) {
            let _ = writeln!(text, "   {line}"); // writing to a string cannot fail
        }
        text + "*/\n" + PRELUDE
    }

    fn function(&self, function: &Function, sizes: &Sizes, steps: &[Step]) -> String {
        let known: &[Output] = if function.knows_motion { &[Output::Acceleration, Output::Reaction] } else { &[] };
        let known: String = known.iter().map(|known| format!("const double *{}, ", known.name())).collect();
        let outputs: Vec<String> = function.outputs.iter().map(|output| format!("double *{}", output.name())).collect();
        let shapes: Vec<String> = function.outputs.iter().map(|output| shape(*output, sizes)).collect();
        let about = function.comment().join("\n   ");
        let mut text = format!(
            "\n/* {about}\n   Sizes: {}. */\nvoid {}(double t, const double *p, const double *u, const double *f, \
             const double *q, const double *v,\n    {known}{})\n{{\n    \
             (void)t; (void)p; (void)u; (void)f; (void)q; (void)v;\n   ",
            shapes.join(", "),
            function.name,
            outputs.join(", ")
        );
        if function.knows_motion {
            text.push_str(" (void)a; (void)lambda;");
        }
        for output in function.outputs {
            let _ = write!(text, " (void){};", output.name()); // writing to a string cannot fail
        }
        text.push('\n');
        for step in steps {
            text.push_str(&line(step, sizes));
        }
        text + "}\n"
    }

    fn kinematics(&self, model: &Kinematics) -> String {
        model.fill(include_str!("kinematics.c"), model.name, 0)
    }

    fn end(&self, _name: &str) -> String {
        String::new()
    }
}

fn shape(output: Output, sizes: &Sizes) -> String {
    let [rows, columns] = output.shape(sizes);
    let name = output.name();
    if output.is_matrix() { format!("{name} {rows} x {columns}") } else { format!("{name} {rows}") }
}

fn line(step: &Step, sizes: &Sizes) -> String {
    match *step {
        Step::One(own, function, a) => format!("    const double x{own} = {};\n", unary(function, &operand(a))),
        Step::Two(own, function, a, b) => {
            format!("    const double x{own} = {};\n", binary(function, &operand(a), &operand(b)))
        }
        Step::Select(own, a, b, c) => {
            format!("    const double x{own} = {} != 0.0 ? {} : {};\n", operand(a), operand(b), operand(c))
        }
        Step::SineCosine([sine, cosine], angle) => {
            format!("    double x{sine}, x{cosine};\n    sine_cosine({}, &x{sine}, &x{cosine});\n", operand(angle))
        }
        Step::Store(output, [row, column], value) => {
            let place = row * output.shape(sizes)[1] + column;
            format!("    {}[{place}] = {};\n", output.name(), operand(value))
        }
    }
}

fn operand(operand: Operand) -> String {
    match operand {
        Operand::Number(value) if value.is_nan() => "NAN".to_owned(),
        Operand::Number(f64::INFINITY) => "INFINITY".to_owned(),
        Operand::Number(f64::NEG_INFINITY) => "(-INFINITY)".to_owned(),
        Operand::Number(value) if value < 0.0 => format!("({value:e})"),
        Operand::Number(value) => format!("{value:e}"),
        Operand::Symbol(Symbol::Time) => "t".to_owned(),
        Operand::Symbol(symbol) => {
            argument(symbol).map_or_else(|| "NAN".to_owned(), |(array, index)| format!("{array}[{index}]"))
        }
        Operand::Result(index) => format!("x{index}"),
    }
}

fn unary(function: Unary, a: &str) -> String {
    let name = match function {
        Unary::Negate => return format!("-{a}"),
        Unary::Abs => "fabs",
        Unary::Sign => "signum",
        other => super::unary_name(other),
    };
    format!("{name}({a})")
}

fn binary(function: Binary, a: &str, b: &str) -> String {
    match function {
        Binary::Add => format!("{a} + {b}"),
        Binary::Subtract => format!("{a} - {b}"),
        Binary::Multiply => format!("{a} * {b}"),
        Binary::Divide => format!("{a} / {b}"),
        Binary::Power => format!("pow({a}, {b})"),
        Binary::Atan2 => format!("atan2({a}, {b})"),
        Binary::Min => format!("smaller({a}, {b})"),
        Binary::Max => format!("larger({a}, {b})"),
        Binary::Less => format!("{a} < {b} ? 1.0 : 0.0"),
        Binary::LessEqual => format!("{a} <= {b} ? 1.0 : 0.0"),
    }
}
