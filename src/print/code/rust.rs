//! Rust.

use std::fmt::Write;

use super::{Function, Kinematics, Language, Operand, Output, Sizes, Step, argument, wrapped};
use crate::expr::{Binary, Symbol, Unary};

/// Sine and cosine as the runtime computes them, and the small functions that Rust lacks.
const PRELUDE: &str = include_str!("prelude.rs.txt");

/// Functions over arrays, matrices by rows; needs nothing but the standard library.
#[derive(Clone, Copy, Debug)]
pub struct Rust;

impl Language for Rust {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!(
            "//! Equations of motion of `{name}`. Matrices are arrays of rows. The same bits as the kernels; only tan, exp, powf\n\
             //! and their kin are those of the standard library.\n//!\n"
        );
        for line in legend.iter().flat_map(|line| wrapped(line, 110)) {
            let _ = writeln!(text, "//! {line}"); // writing to a string cannot fail
        }
        text + PRELUDE
    }

    fn function(&self, function: &Function, sizes: &Sizes, steps: &[Step]) -> String {
        let Sizes { parameters, inputs, followers, coordinates, constraints, .. } = sizes;
        let mut arguments = vec![
            "t: f64".to_owned(),
            format!("p: &[f64; {parameters}]"),
            format!("u: &[f64; {}]", 3 * inputs),
            format!("f: &[f64; {}]", 3 * followers),
            format!("q: &[f64; {coordinates}]"),
            format!("v: &[f64; {coordinates}]"),
        ];
        if function.knows_motion {
            arguments.extend([format!("a: &[f64; {coordinates}]"), format!("lambda: &[f64; {constraints}]")]);
        }
        let outputs = function.outputs.iter().map(|output| {
            let [rows, columns] = output.shape(sizes);
            let name = output.name();
            if output.is_matrix() {
                format!("{name}: &mut [[f64; {columns}]; {rows}]")
            } else {
                format!("{name}: &mut [f64; {rows}]")
            }
        });
        let arguments: Vec<String> = arguments.into_iter().chain(outputs).collect();
        let mut text = format!(
            "\n/// {}\n#[allow(dead_code, non_snake_case, unused_variables, clippy::too_many_arguments, clippy::excessive_precision)]\n\
             pub fn {}(\n    {},\n) {{\n",
            function.comment().join("\n/// "),
            function.name,
            arguments.join(",\n    ")
        );
        for step in steps {
            text.push_str(&line(step));
        }
        text + "}\n"
    }

    fn kinematics(&self, model: &Kinematics) -> String {
        model.fill(include_str!("kinematics.rs.txt"), model.name, 0)
    }

    fn end(&self, _name: &str) -> String {
        String::new()
    }
}

fn line(step: &Step) -> String {
    match *step {
        Step::One(own, function, a) => format!("    let x{own} = {};\n", unary(function, a)),
        Step::Two(own, function, a, b) => format!("    let x{own} = {};\n", binary(function, &operand(a), &operand(b))),
        Step::Select(own, a, b, c) => {
            let [a, b, c] = [a, b, c].map(operand);
            format!("    let x{own} = if {a} != 0.0 {{ {b} }} else {{ {c} }};\n")
        }
        Step::SineCosine([sine, cosine], angle) => {
            format!("    let (x{sine}, x{cosine}) = sine_cosine({});\n", operand(angle))
        }
        Step::Store(output, [row, column], value) => {
            format!("    {} = {};\n", place(output, row, column), operand(value))
        }
    }
}

fn place(output: Output, row: usize, column: usize) -> String {
    let name = output.name();
    if output.is_matrix() { format!("{name}[{row}][{column}]") } else { format!("{name}[{row}]") }
}

fn operand(operand: Operand) -> String {
    match operand {
        Operand::Number(value) if value.is_nan() => "f64::NAN".to_owned(),
        Operand::Number(f64::INFINITY) => "f64::INFINITY".to_owned(),
        Operand::Number(f64::NEG_INFINITY) => "f64::NEG_INFINITY".to_owned(),
        Operand::Number(value) => format!("{value:e}_f64"),
        Operand::Symbol(Symbol::Time) => "t".to_owned(),
        Operand::Symbol(symbol) => {
            argument(symbol).map_or_else(|| "f64::NAN".to_owned(), |(array, index)| format!("{array}[{index}]"))
        }
        Operand::Result(index) => format!("x{index}"),
    }
}

/// What a method is called on: a minus would come after the method.
fn receiver(a: &str) -> String {
    if a.starts_with('-') { format!("({a})") } else { a.to_owned() }
}

fn unary(function: Unary, a: Operand) -> String {
    let a = operand(a);
    let method = match function {
        Unary::Negate => return format!("-{a}"),
        Unary::Sign => return format!("signum({a})"),
        Unary::Log => "ln",
        other => super::unary_name(other),
    };
    format!("{}.{method}()", receiver(&a))
}

fn binary(function: Binary, a: &str, b: &str) -> String {
    match function {
        Binary::Add => format!("{a} + {b}"),
        Binary::Subtract => format!("{a} - {b}"),
        Binary::Multiply => format!("{a} * {b}"),
        Binary::Divide => format!("{a} / {b}"),
        Binary::Power => format!("{}.powf({b})", receiver(a)),
        Binary::Atan2 => format!("{}.atan2({b})", receiver(a)),
        Binary::Min => format!("smaller({a}, {b})"),
        Binary::Max => format!("larger({a}, {b})"),
        Binary::Less => format!("f64::from(u8::from({a} < {b}))"),
        Binary::LessEqual => format!("f64::from(u8::from({a} <= {b}))"),
    }
}
