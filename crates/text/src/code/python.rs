//! Python with numpy.

use std::fmt::Write;

use super::syntax::Syntax;
use super::{CodeFunction, KinematicsCode, Language, Sizes, Statement};

const PRELUDE: &str = "import numpy as np


def sine_cosine(x):
    return np.sin(x), np.cos(x)
";

/// `lambda` is a word of the language.
const SYNTAX: Syntax = Syntax {
    column: 3,
    assign: "    {x} = {v}\n",
    store: "    {x} = {v}\n",
    select: "{b} if {a} != 0.0 else {c}",
    sine_cosine: "    {x}, {y} = sine_cosine({a})\n",
    call: "np.{f}({a}{b})",
    special: ["np.nan", "np.inf", "(-np.inf)"],
    suffix: "",
    parentheses: true,
    renamed: &[("lambda", "lambda_")],
    place: |[row, column], columns| match columns {
        Some(_) => format!("[{row}, {column}]"),
        None => format!("[{row}]"),
    },
};

#[derive(Clone, Copy, Debug)]
pub struct Python;

impl Language for Python {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!("\"\"\"Equations of motion of `{name}`.\n\n");
        legend.iter().for_each(|line| text += &format!("{line}\n"));
        text + "\"\"\"\n\n" + PRELUDE
    }

    fn function(&self, function: &CodeFunction, sizes: &Sizes, steps: &[Statement]) -> String {
        let names: Vec<&str> = function.outputs.iter().map(|output| SYNTAX.array(output.name())).collect();
        let names = names.join(", ");
        let known = if function.knows_motion { ["a", "lambda_"].as_slice() } else { &[] };
        let states = if sizes.states > 0 { ["z"].as_slice() } else { &[] };
        let arguments =
            ["p", "u", "f", "q", "v"].iter().chain(states).chain(known).copied().collect::<Vec<_>>().join(", ");
        let about = function.comment().join("\n    ");
        let mut text = format!(
            "\n\ndef {}(t, {arguments}):\n    \"\"\"{about}\n\n    Returns {names}.\n    \"\"\"\n    t = np.float64(t)\n    \
             {arguments} = (np.asarray(values, dtype=float) for values in ({arguments}))\n",
            function.name
        );
        for output in function.outputs {
            let [rows, columns] = output.shape(sizes);
            let shape = if output.is_matrix() { format!("({rows}, {columns})") } else { rows.to_string() };
            let _ = writeln!(text, "    {} = np.zeros({shape})", SYNTAX.array(output.name())); // writing to a string cannot fail
        }
        text.push_str(&SYNTAX.lines(steps, sizes));
        text + &format!("    return {names}\n")
    }

    fn kinematics(&self, model: &KinematicsCode) -> String {
        model.fill(include_str!("kinematics.py"), model.name, 0)
    }
}
