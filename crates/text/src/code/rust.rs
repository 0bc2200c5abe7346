//! Rust.

use super::syntax::Syntax;
use super::{CodeFunction, KinematicsCode, Language, Sizes, Statement};

/// Sine and cosine as the runtime computes them, and the small functions that Rust lacks.
const PRELUDE: &str = include_str!("prelude.rs.txt");

const SYNTAX: Syntax = Syntax {
    column: 2,
    assign: "    let {x} = {v};\n",
    store: "    {x} = {v};\n",
    select: "if {a} != 0.0 { {b} } else { {c} }",
    sine_cosine: "    let ({x}, {y}) = sine_cosine({a});\n",
    call: "{a}.{f}({b})",
    special: ["f64::NAN", "f64::INFINITY", "f64::NEG_INFINITY"],
    suffix: "_f64",
    parentheses: false,
    renamed: &[],
    place: |[row, column], columns| match columns {
        Some(_) => format!("[{row}][{column}]"),
        None => format!("[{row}]"),
    },
};

/// Functions over arrays, matrices by rows; needs nothing but the standard library.
#[derive(Clone, Copy, Debug)]
pub struct Rust;

impl Language for Rust {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!(
            "//! Equations of motion of `{name}`. Matrices are arrays of rows. The same bits as the kernels; only tan, exp, powf\n\
             //! and their kin are those of the standard library.\n//!\n"
        );
        legend.iter().for_each(|line| text += &format!("//! {line}\n"));
        text + PRELUDE
    }

    fn function(&self, function: &CodeFunction, sizes: &Sizes, steps: &[Statement]) -> String {
        let Sizes { parameters, inputs, followers, coordinates, constraints, .. } = sizes;
        let mut arguments = vec![
            "t: f64".to_owned(),
            format!("p: &[f64; {parameters}]"),
            format!("u: &[f64; {}]", 3 * inputs),
            format!("f: &[f64; {}]", 3 * followers),
            format!("q: &[f64; {coordinates}]"),
            format!("v: &[f64; {coordinates}]"),
        ];
        if sizes.states > 0 {
            arguments.push(format!("z: &[f64; {}]", sizes.states));
        }
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
        let text = format!(
            "\n/// {}\n#[allow(dead_code, non_snake_case, unused_variables, clippy::too_many_arguments, clippy::excessive_precision)]\n\
             pub fn {}(\n    {},\n) {{\n",
            function.comment().join("\n/// "),
            function.name,
            arguments.join(",\n    ")
        );
        text + &SYNTAX.lines(steps, sizes) + "}\n"
    }

    fn kinematics(&self, model: &KinematicsCode) -> String {
        model.fill(include_str!("kinematics.rs.txt"), model.name, 0)
    }
}
