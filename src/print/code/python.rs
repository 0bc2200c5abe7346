//! Python with numpy.

use std::fmt::Write;

use super::{Function, Kinematics, Language, Operand, Output, Sizes, Step, argument, wrapped};
use crate::expr::{Binary, Symbol, Unary};

/// The small functions that numpy lacks.
const PRELUDE: &str = "import numpy as np


def sine_cosine(x):
    return np.sin(x), np.cos(x)
";

/// Functions that return numpy arrays.
#[derive(Clone, Copy, Debug)]
pub struct Python;

impl Language for Python {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!("\"\"\"Equations of motion of `{name}`.\n\n");
        for line in legend.iter().flat_map(|line| wrapped(line, 110)) {
            let _ = writeln!(text, "{line}"); // writing to a string cannot fail
        }
        text + "\"\"\"\n\n" + PRELUDE
    }

    fn function(&self, function: &Function, sizes: &Sizes, steps: &[Step]) -> String {
        let names: Vec<&str> = function.outputs.iter().map(|output| name(*output)).collect();
        let names = names.join(", ");
        let known = if function.knows_motion { ["a", "lambda_"].as_slice() } else { &[] };
        let arguments = ["p", "u", "f", "q", "v"].iter().chain(known).copied().collect::<Vec<_>>().join(", ");
        let about = function.comment().join("\n    ");
        let mut text = format!(
            "\n\ndef {}(t, {arguments}):\n    \"\"\"{about}\n\n    Returns {names}.\n    \"\"\"\n    t = np.float64(t)\n    \
             {arguments} = (np.asarray(values, dtype=float) for values in ({arguments}))\n",
            function.name
        );
        for output in function.outputs {
            let [rows, columns] = output.shape(sizes);
            let shape = if output.is_matrix() { format!("({rows}, {columns})") } else { rows.to_string() };
            let _ = writeln!(text, "    {} = np.zeros({shape})", name(*output)); // writing to a string cannot fail
        }
        for step in steps {
            text.push_str(&line(step));
        }
        text + &format!("    return {names}\n")
    }

    fn kinematics(&self, model: &Kinematics) -> String {
        model.fill(include_str!("kinematics.py"), model.name, 0)
    }

    fn end(&self, _name: &str) -> String {
        String::new()
    }
}

/// `lambda` is a word of the language.
fn name(output: Output) -> &'static str {
    if output == Output::Reaction { "lambda_" } else { output.name() }
}

fn line(step: &Step) -> String {
    match *step {
        Step::One(own, function, a) => format!("    x{own} = {}\n", unary(function, &operand(a))),
        Step::Two(own, function, a, b) => format!("    x{own} = {}\n", binary(function, &operand(a), &operand(b))),
        Step::Select(own, a, b, c) => {
            format!("    x{own} = {} if {} != 0.0 else {}\n", operand(b), operand(a), operand(c))
        }
        Step::SineCosine([sine, cosine], angle) => {
            format!("    x{sine}, x{cosine} = sine_cosine({})\n", operand(angle))
        }
        Step::Store(output, [row, column], value) => {
            let place = if output.is_matrix() { format!("{row}, {column}") } else { row.to_string() };
            format!("    {}[{place}] = {}\n", name(output), operand(value))
        }
    }
}

fn operand(operand: Operand) -> String {
    match operand {
        Operand::Number(value) if value.is_nan() => "np.nan".to_owned(),
        Operand::Number(f64::INFINITY) => "np.inf".to_owned(),
        Operand::Number(f64::NEG_INFINITY) => "(-np.inf)".to_owned(),
        Operand::Number(value) if value < 0.0 => format!("({value:e})"),
        Operand::Number(value) => format!("{value:e}"),
        Operand::Symbol(Symbol::Time) => "t".to_owned(),
        Operand::Symbol(Symbol::Reaction(index)) => format!("{}[{index}]", name(Output::Reaction)),
        Operand::Symbol(symbol) => {
            argument(symbol).map_or_else(|| "np.nan".to_owned(), |(array, index)| format!("{array}[{index}]"))
        }
        Operand::Result(index) => format!("x{index}"),
    }
}

fn unary(function: Unary, a: &str) -> String {
    let name = match function {
        Unary::Negate => return format!("-{a}"),
        Unary::Asin => "arcsin",
        Unary::Acos => "arccos",
        Unary::Atan => "arctan",
        other => super::unary_name(other),
    };
    format!("np.{name}({a})")
}

fn binary(function: Binary, a: &str, b: &str) -> String {
    match function {
        Binary::Add => format!("{a} + {b}"),
        Binary::Subtract => format!("{a} - {b}"),
        Binary::Multiply => format!("{a} * {b}"),
        Binary::Divide => format!("np.divide({a}, {b})"),
        Binary::Power => format!("np.power({a}, {b})"),
        Binary::Atan2 => format!("np.arctan2({a}, {b})"),
        Binary::Min => format!("np.minimum({a}, {b})"),
        Binary::Max => format!("np.maximum({a}, {b})"),
        Binary::Less => format!("np.float64({a} < {b})"),
        Binary::LessEqual => format!("np.float64({a} <= {b})"),
    }
}
