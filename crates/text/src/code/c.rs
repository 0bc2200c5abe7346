//! C99.

use std::fmt::Write;

use super::syntax::Syntax;
use super::{CodeBlock, CodeFunction, KinematicsCode, Language, Sizes, Statement};

/// Sine and cosine as the runtime computes them, and the small functions that C lacks.
const PRELUDE: &str = include_str!("prelude.c");

const SYNTAX: Syntax = Syntax {
    column: 0,
    assign: "    const double {x} = {v};\n",
    store: "    {x} = {v};\n",
    select: "{a} != 0.0 ? {b} : {c}",
    sine_cosine: "    double {x}, {y};\n    sine_cosine({a}, &{x}, &{y});\n",
    call: "{f}({a}{b})",
    special: ["NAN", "INFINITY", "(-INFINITY)"],
    suffix: "",
    parentheses: true,
    renamed: &[],
    place: |[row, column], columns| format!("[{}]", row * columns.unwrap_or(1) + column),
};

#[derive(Clone, Copy, Debug)]
pub struct C;

impl Language for C {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!(
            "/* Equations of motion of `{name}`, C99. Compile without contraction: -ffp-contract=off.\n   \
             Matrices are stored by rows. The same bits as the kernels; only tan, exp, pow and their kin are those of the\n   \
             C library.\n"
        );
        legend.iter().for_each(|line| text += &format!("   {line}\n"));
        text + "*/\n" + PRELUDE
    }

    fn function(&self, function: &CodeFunction, sizes: &Sizes, steps: &[Statement]) -> String {
        let known: &[CodeBlock] =
            if function.knows_motion { &[CodeBlock::Acceleration, CodeBlock::Reaction] } else { &[] };
        let known: String = known.iter().map(|known| format!("const double *{}, ", known.name())).collect();
        let states = if sizes.states > 0 { "const double *z, " } else { "" };
        let outputs: Vec<String> = function.outputs.iter().map(|output| format!("double *{}", output.name())).collect();
        let shapes: Vec<String> = function.outputs.iter().map(|output| output.described(sizes)).collect();
        let about = function.comment().join("\n   ");
        let mut text = format!(
            "\n/* {about}\n   Sizes: {}. */\nvoid {}(double t, const double *p, const double *u, const double *f, \
             const double *q, const double *v,\n    {states}{known}{})\n{{\n    \
             (void)t; (void)p; (void)u; (void)f; (void)q; (void)v;\n   ",
            shapes.join(", "),
            function.name,
            outputs.join(", ")
        );
        if sizes.states > 0 {
            text.push_str(" (void)z;");
        }
        if function.knows_motion {
            text.push_str(" (void)a; (void)lambda;");
        }
        for output in function.outputs {
            let _ = write!(text, " (void){};", output.name()); // writing to a string cannot fail
        }
        text.push('\n');
        text + &SYNTAX.lines(steps, sizes) + "}\n"
    }

    fn kinematics(&self, model: &KinematicsCode) -> String {
        model.fill(include_str!("kinematics.c"), model.name, 0)
    }
}
