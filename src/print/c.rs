//! The equations as C functions that compile alone and give the same bits as the kernels (without contraction to fused
//! multiply-add).

use std::fmt::Write;

use super::symbol_name;
use super::motion::has_masses;
use crate::equations::Equations;
use crate::expr::{Arena, Binary, Expr, Node, Order, Symbol, Unary};

/// Sine and cosine as the runtime computes them, and the small functions that C lacks.
const PRELUDE: &str = include_str!("prelude.c");

/// A C function: its name, what it is for, and its results.
struct Function {
    name: String,
    about: &'static str,
    results: Vec<(String, Expr)>,
    outputs: &'static str,
}

/// `NAME_equations` computes M, Q, Phi, Phi_q, Phi_t and gamma; `NAME_accelerations`, for a dynamic model, a and lambda
/// (`solved`).
pub fn c_code(equations: &mut Equations, solved: &[Expr]) -> String {
    let dynamic = has_masses(equations);
    let name = equations.system.mechanism.name.clone();
    let mut functions = vec![Function {
        name: format!("{name}_equations"),
        about: "Matrices by rows. M: n x n, Q: n, Phi, Phi_t, gamma: m, Phi_q: m x n.",
        results: matrices(equations, dynamic),
        outputs: "double *M, double *Q, double *Phi, double *Phi_q, double *Phi_t, double *gamma",
    }];
    if !solved.is_empty() {
        let count = equations.coordinates.len();
        let place =
            |index: usize| if index < count { format!("a[{index}]") } else { format!("lambda[{}]", index - count) };
        functions.push(Function {
            name: format!("{name}_accelerations"),
            about: "Accelerations a: n, and reactions lambda: m.",
            results: solved.iter().enumerate().map(|(index, &expr)| (place(index), expr)).collect(),
            outputs: "double *a, double *lambda",
        });
    }
    let mut text = format!(
        "/* Equations of motion of `{name}`. Compile without contraction: -ffp-contract=off.\n{} */\n",
        legend(equations)
    );
    text.push_str(PRELUDE);
    for function in functions {
        write_function(&mut text, &equations.system.arena, &function);
    }
    text
}

fn legend(equations: &Equations) -> String {
    let system = &equations.system;
    let list = |title: &str, names: Vec<String>| {
        if names.is_empty() { String::new() } else { format!("   {title}: {}\n", names.join(", ")) }
    };
    let parameters = system.mechanism.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let inputs = system.mechanism.inputs.iter().map(|input| input.name.clone()).collect();
    let followers =
        (0..system.followers.len()).map(|i| symbol_name(equations, Symbol::Follower(i, Order::Position))).collect();
    let coordinates = equations.coordinates.iter().map(|coordinate| coordinate.name.position.clone()).collect();
    let reactions = equations.constraints.iter().map(|row| system.element(row.element).name.clone()).collect();
    [
        list("p: parameters", parameters),
        list("u: value, rate and acceleration of the inputs", inputs),
        list("f: position, rate and acceleration of the drivers that integrate an input", followers),
        list("q, v: coordinates and their rates", coordinates),
        list("lambda: reactions", reactions),
    ]
    .concat()
}

/// Dense results, zeros included.
fn matrices(equations: &mut Equations, dynamic: bool) -> Vec<(String, Expr)> {
    let n = equations.coordinates.len();
    let mut results = Vec::new();
    let mut dense = |symbol: &str, row: usize, entries: &[(usize, Expr)]| {
        for column in 0..n {
            let entry = entries.iter().find(|(at, _)| *at == column).map_or(Expr::ZERO, |(_, entry)| *entry);
            results.push((format!("{symbol}[{}]", row * n + column), entry));
        }
    };
    if dynamic {
        for (row, entries) in equations.dynamics().mass.iter().enumerate() {
            dense("M", row, entries);
        }
    }
    for (row, constraint) in equations.constraints.iter().enumerate() {
        dense("Phi_q", row, &constraint.jacobian);
    }
    if dynamic {
        results.extend(equations.dynamics().load.iter().enumerate().map(|(row, &load)| (format!("Q[{row}]"), load)));
    }
    for (row, constraint) in equations.constraints.iter().enumerate() {
        results.push((format!("Phi[{row}]"), constraint.value));
        results.push((format!("Phi_t[{row}]"), constraint.time_rate));
        results.push((format!("gamma[{row}]"), constraint.gamma));
    }
    results
}

fn write_function(text: &mut String, arena: &Arena, function: &Function) {
    let Function { name, about, results, outputs } = function;
    // Writing to a String cannot fail.
    let _ = writeln!(text, "\n/* {about} */");
    let _ = writeln!(
        text,
        "void {name}(double t, const double *p, const double *u, const double *f, const double *q, const double *v,\n    {outputs})\n{{"
    );
    let _ = writeln!(text, "    (void)t; (void)p; (void)u; (void)f; (void)q; (void)v;");
    for parameter in outputs.split(", ") {
        let _ = writeln!(text, "    (void){};", parameter.trim_start_matches("double *"));
    }
    for expr in arena.reachable(results.iter().map(|(_, expr)| *expr)) {
        write_step(text, arena, expr);
    }
    for (place, expr) in results {
        let _ = writeln!(text, "    {place} = {};", operand(arena, *expr));
    }
    text.push_str("}\n");
}

fn write_step(text: &mut String, arena: &Arena, expr: Expr) {
    let of = |e: Expr| operand(arena, e);
    let own = expr.index();
    let value = match arena.node(expr) {
        Node::Constant(_) | Node::Symbol(_) => return,
        Node::Unary(function, a) => unary(function, &of(a)),
        Node::Binary(function, a, b) => binary(function, &of(a), &of(b)),
        Node::Select(a, b, c) => format!("{} != 0.0 ? {} : {}", of(a), of(b), of(c)),
    };
    let _ = writeln!(text, "    const double x{own} = {value};");
}

fn operand(arena: &Arena, expr: Expr) -> String {
    let order = |order: Order| order as usize;
    match arena.node(expr) {
        Node::Constant(bits) => {
            let value = f64::from_bits(bits);
            if value < 0.0 { format!("({value:e})") } else { format!("{value:e}") }
        }
        Node::Symbol(symbol) => match symbol {
            Symbol::Time => "t".to_string(),
            Symbol::Parameter(i) => format!("p[{i}]"),
            Symbol::Input(i, of) => format!("u[{}]", 3 * i + order(of)),
            Symbol::Follower(i, of) => format!("f[{}]", 3 * i + order(of)),
            Symbol::Coordinate(i, Order::Position) => format!("q[{i}]"),
            Symbol::Coordinate(i, Order::Velocity) => format!("v[{i}]"),
            Symbol::Coordinate(i, Order::Acceleration) => format!("a[{i}]"),
            Symbol::Reaction(i) => format!("lambda[{i}]"),
            // Refused before: the functions are only written when all masses are there.
            Symbol::Missing(..) => "NAN".to_string(),
        },
        _ => format!("x{}", expr.index()),
    }
}

fn unary(function: Unary, a: &str) -> String {
    match function {
        Unary::Negate => format!("-{a}"),
        Unary::Sqrt => format!("sqrt({a})"),
        Unary::Sin => format!("sine({a})"),
        Unary::Cos => format!("cosine({a})"),
        Unary::Tan => format!("tan({a})"),
        Unary::Asin => format!("asin({a})"),
        Unary::Acos => format!("acos({a})"),
        Unary::Atan => format!("atan({a})"),
        Unary::Exp => format!("exp({a})"),
        Unary::Log => format!("log({a})"),
        Unary::Tanh => format!("tanh({a})"),
        Unary::Abs => format!("fabs({a})"),
        Unary::Sign => format!("signum({a})"),
        Unary::Floor => format!("floor({a})"),
    }
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
