//! The equations as functions of other languages: straight-line code in the order of the arena, one operation on a line, so that it
//! rounds exactly as the kernels do. A [`Language`] defines the syntax; the content is the same for all.

mod c;
mod fortran;
mod kinematics;
mod python;
mod rust;
mod syntax;

use cotree::equations::Equations;
use cotree::expr::{Arena, Binary, Expr, ExprNode, Order, Symbol, Unary};

use crate::motion::{self, Entry, has_masses};
use crate::symbol_name;
pub use c::C;
pub use fortran::Fortran;
pub use kinematics::KinematicsCode;
pub use python::Python;
pub use rust::Rust;

/// How a programming language writes the equations.
pub trait Language {
    /// The beginning of the file; `legend` describes the arguments.
    fn prelude(&self, name: &str, legend: &[String]) -> String;
    /// A function from its first line to its last; `steps` are the lines between.
    fn function(&self, function: &CodeFunction, sizes: &Sizes, steps: &[Statement]) -> String;
    /// The velocities and accelerations of a model whose motion the drivers prescribe.
    fn kinematics(&self, model: &KinematicsCode) -> String;
    fn end(&self, _name: &str) -> String {
        String::new()
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    pub parameters: usize,
    pub inputs: usize,
    pub followers: usize,
    pub coordinates: usize,
    /// States of the scene; functions take them after the rates if there are any.
    pub states: usize,
    pub constraints: usize,
    pub slides: usize,
    /// Reactions of all joints and efforts of all drivers.
    pub efforts: usize,
}

/// A function: its name, what it is for, and its results.
#[derive(Clone, Debug)]
pub struct CodeFunction {
    pub name: String,
    pub about: String,
    /// Are accelerations and reactions arguments too, after the rates?
    pub knows_motion: bool,
    /// The arrays that it fills, in the order in which it is given them.
    pub outputs: &'static [CodeBlock],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeBlock {
    /// \[M\]
    Mass,
    /// {Q}
    Load,
    /// {Phi}
    Constraint,
    /// \[Phi_q\]
    Jacobian,
    /// {Phi_t}
    TimeRate,
    /// gamma
    Gamma,
    Acceleration,
    Reaction,
    /// Rates of the states of the scene.
    StateRate,
    /// Displacements of the slides that are no coordinates.
    Slide,
    /// Reactions of all joints and efforts of all drivers.
    Effort,
}

/// One line of straight-line code. Operands are constants, symbols, or the results of earlier lines.
#[derive(Clone, Copy, Debug)]
pub enum Statement {
    /// result = f(a)
    One(usize, Unary, Operand),
    /// result = f(a, b)
    Two(usize, Binary, Operand, Operand),
    /// result = b if a is not zero, else c
    Select(usize, Operand, Operand, Operand),
    /// Both from one call: sine, cosine. One of them may be unused.
    SineCosine([usize; 2], Operand),
    /// An entry of an array of results: row, column.
    Store(CodeBlock, [usize; 2], Operand),
}

#[derive(Clone, Copy, Debug)]
pub enum Operand {
    Number(f64),
    Symbol(Symbol),
    Result(usize),
}

impl CodeFunction {
    /// What it is for, in lines that are not too long.
    pub fn comment(&self) -> Vec<String> {
        self.about.lines().flat_map(|line| wrapped(line, 110)).collect()
    }
}

const EQUATIONS: &[CodeBlock] = &[
    CodeBlock::Mass,
    CodeBlock::Load,
    CodeBlock::Constraint,
    CodeBlock::Jacobian,
    CodeBlock::TimeRate,
    CodeBlock::Gamma,
];
const SOLUTION: &[CodeBlock] = &[CodeBlock::Acceleration, CodeBlock::Reaction];

impl CodeBlock {
    /// Rows and columns; one column for what is no matrix.
    pub fn shape(self, sizes: &Sizes) -> [usize; 2] {
        let (n, m) = (sizes.coordinates, sizes.constraints);
        match self {
            CodeBlock::Mass => [n, n],
            CodeBlock::Load | CodeBlock::Acceleration => [n, 1],
            CodeBlock::Constraint | CodeBlock::TimeRate | CodeBlock::Gamma | CodeBlock::Reaction => [m, 1],
            CodeBlock::Jacobian => [m, n],
            CodeBlock::StateRate => [sizes.states, 1],
            CodeBlock::Slide => [sizes.slides, 1],
            CodeBlock::Effort => [sizes.efforts, 1],
        }
    }

    pub fn is_matrix(self) -> bool {
        matches!(self, CodeBlock::Mass | CodeBlock::Jacobian)
    }

    pub fn name(self) -> &'static str {
        match self {
            CodeBlock::Mass => "M",
            CodeBlock::Load => "Q",
            CodeBlock::Constraint => "Phi",
            CodeBlock::Jacobian => "Phi_q",
            CodeBlock::TimeRate => "Phi_t",
            CodeBlock::Gamma => "gamma",
            CodeBlock::Acceleration => "a",
            CodeBlock::Reaction => "lambda",
            CodeBlock::StateRate => "dz",
            CodeBlock::Slide => "s",
            CodeBlock::Effort => "effort",
        }
    }
}

/// Functions that compute M, Q, Phi, Phi_q, Phi_t and gamma and, for a dynamic model, the accelerations and reactions
/// (`solved`); for a kinematic one the velocities and accelerations, from the loop equations that are not `redundant`. Then what follows
/// from the motion: slides that are no coordinates and, with masses, the reactions of all joints and the efforts of all drivers. Without
/// masses M, Q and the reactions are zero.
pub fn code(equations: &mut Equations, solved: &[Expr], redundant: &[usize], language: &dyn Language) -> String {
    // A scene may be called `my scene`: functions may not.
    let name = cotree::model::identifier(&equations.system.mechanism.name);
    let masses = has_masses(equations);
    let matrices = matrices(equations);
    let loops: Vec<usize> = equations.loops().map(|(index, _)| index).collect();
    let slides = motion::slides(equations);
    let efforts = if masses { [motion::held(equations), motion::efforts(equations)].concat() } else { Vec::new() };
    let sizes = Sizes {
        parameters: equations.system.mechanism.parameters.len() + equations.system.mechanism.discrete.len(),
        inputs: equations.system.mechanism.inputs.len(),
        followers: equations.system.followers.len(),
        coordinates: equations.coordinates.len(),
        states: equations.states.len(),
        constraints: loops.len(),
        slides: slides.len(),
        efforts: efforts.len(),
    };
    let legend: Vec<String> = legend(equations).iter().flat_map(|line| wrapped(line, 110)).collect();
    let mut text = language.prelude(&name, &legend);
    let writer = CodeWriter {
        name: &name,
        arena: &equations.system.arena,
        loops: &loops,
        scene_parameters: equations.system.mechanism.parameters.len(),
        sizes: &sizes,
        language,
    };
    text.push_str(&writer.equations(&matrices, masses));
    let rows: Vec<usize> = (0..sizes.constraints).filter(|&row| !redundant.contains(&loops[row])).collect();
    if !solved.is_empty() {
        text.push_str(&writer.accelerations(solved));
    } else if !rows.is_empty() && rows.len() == sizes.coordinates {
        text.push_str(&language.kinematics(&KinematicsCode { name: &name, sizes, rows: &rows, masses }));
    }
    if sizes.states > 0 {
        text.push_str(&writer.states(&equations.states));
    }
    if !slides.is_empty() {
        text.push_str(&writer.slides(&slides));
    }
    if !efforts.is_empty() {
        text.push_str(&writer.efforts(&efforts));
    }
    text.push_str(&language.end(&name));
    text
}

/// An element of an output.
#[derive(Clone, Copy)]
struct CodeEntry {
    output: CodeBlock,
    /// Row and column.
    place: [usize; 2],
    expr: Expr,
}

fn column<'a>(output: CodeBlock, exprs: impl IntoIterator<Item = &'a Expr>) -> Vec<CodeEntry> {
    exprs.into_iter().enumerate().map(|(row, &expr)| CodeEntry { output, place: [row, 0], expr }).collect()
}

fn list(entries: &[Entry]) -> String {
    entries.iter().map(|(name, _)| name.plain.as_str()).collect::<Vec<_>>().join(", ")
}

struct CodeWriter<'a> {
    name: &'a str,
    arena: &'a Arena,
    /// The loop equations that constrain the motion: their reactions are numbered in this order.
    loops: &'a [usize],
    /// How many parameters of the scene come before the discrete variables.
    scene_parameters: usize,
    sizes: &'a Sizes,
    language: &'a dyn Language,
}

impl CodeWriter<'_> {
    fn equations(&self, matrices: &[CodeEntry], masses: bool) -> String {
        let without = if masses { "" } else { "\nThe scene gives no masses: M and Q are zero." };
        let about = format!(
            "Equations of motion: M a + Phi_q^T lambda = Q, Phi = 0, Phi_q v = -Phi_t, Phi_q a = gamma.{without}"
        );
        self.function("equations", about, EQUATIONS, matrices)
    }

    fn accelerations(&self, solved: &[Expr]) -> String {
        let (accelerations, others) = solved.split_at(self.sizes.coordinates.min(solved.len()));
        let reactions = others.get(self.sizes.states..).unwrap_or_default();
        let reactions = self.loops.iter().filter_map(|&index| reactions.get(index));
        let results = [column(CodeBlock::Acceleration, accelerations), column(CodeBlock::Reaction, reactions)].concat();
        let about = "Accelerations a and reactions lambda, from the equations of motion.".to_owned();
        self.function("accelerations", about, SOLUTION, &results)
    }

    fn states(&self, rates: &[Expr]) -> String {
        let about = "Rates dz of the states z of the scene.".to_owned();
        self.function("states", about, &[CodeBlock::StateRate], &column(CodeBlock::StateRate, rates))
    }

    fn slides(&self, slides: &[Entry]) -> String {
        let about = format!("Displacements s of the slides that are no coordinates: {}.", list(slides));
        let results = column(CodeBlock::Slide, slides.iter().map(|(_, expr)| expr));
        self.function("slides", about, &[CodeBlock::Slide], &results)
    }

    fn efforts(&self, efforts: &[Entry]) -> String {
        let about = format!(
            "Reactions of joints and efforts of drivers, on their second side, from accelerations a and reactions lambda:\n{}.",
            list(efforts)
        );
        let results = column(CodeBlock::Effort, efforts.iter().map(|(_, expr)| expr));
        self.function("efforts", about, &[CodeBlock::Effort], &results)
    }

    fn function(&self, suffix: &str, about: String, outputs: &'static [CodeBlock], results: &[CodeEntry]) -> String {
        let name = format!("{}_{suffix}", self.name);
        let function = CodeFunction { name, about, knows_motion: outputs == [CodeBlock::Effort], outputs };
        let roots: Vec<Expr> = results.iter().map(|entry| entry.expr).collect();
        let (arena, expansions) = self.arena.runnable(&roots);
        let expanded = results.iter().zip(expansions.of(&roots));
        let results: Vec<CodeEntry> = expanded.map(|(entry, expr)| CodeEntry { expr, ..*entry }).collect();
        self.language.function(&function, self.sizes, &steps(&arena, (self.loops, self.scene_parameters), &results))
    }
}

fn matrices(equations: &mut Equations) -> Vec<CodeEntry> {
    let n = equations.coordinates.len();
    let mut results = Vec::new();
    let mut dense = |output: CodeBlock, row: usize, entries: &[(usize, Expr)]| {
        for column in 0..n {
            let entry = entries.iter().find(|(at, _)| *at == column).map_or(Expr::ZERO, |(_, entry)| *entry);
            results.push(CodeEntry { output, place: [row, column], expr: entry });
        }
    };
    let dynamic = has_masses(equations);
    let none = vec![Vec::new(); n];
    for (row, entries) in if dynamic { &equations.dynamics().mass } else { &none }.iter().enumerate() {
        dense(CodeBlock::Mass, row, entries);
    }
    for (row, (_, constraint)) in equations.loops().enumerate() {
        dense(CodeBlock::Jacobian, row, &constraint.jacobian);
    }
    let none = vec![Expr::ZERO; n];
    results.extend(column(CodeBlock::Load, if dynamic { &equations.dynamics().load } else { &none }));
    let gaps = equations.gaps();
    for (row, (index, constraint)) in equations.loops().enumerate() {
        let mut push = |output, expr| results.push(CodeEntry { output, place: [row, 0], expr });
        push(CodeBlock::Constraint, gaps[index]);
        push(CodeBlock::TimeRate, constraint.time_rate);
        push(CodeBlock::Gamma, constraint.gamma);
    }
    results
}

fn steps(arena: &Arena, (loops, parameters): (&[usize], usize), results: &[CodeEntry]) -> Vec<Statement> {
    let order = arena.reachable(results.iter().map(|entry| entry.expr));
    let mut steps = Vec::with_capacity(order.len() + results.len());
    let mut done = std::collections::HashSet::new();
    let of = |expr: Expr| match arena.node(expr) {
        ExprNode::Constant(bits) => Operand::Number(f64::from_bits(bits)),
        // A trivial loop equation has no reaction.
        ExprNode::Symbol(Symbol::Reaction(index)) => match loops.iter().position(|&row| row == index) {
            Some(number) => Operand::Symbol(Symbol::Reaction(number)),
            None => Operand::Number(0.0),
        },
        ExprNode::Symbol(Symbol::Discrete(index)) => Operand::Symbol(Symbol::Parameter(parameters + index)),
        ExprNode::Symbol(symbol) => Operand::Symbol(symbol),
        _ => Operand::Result(expr.index()),
    };
    for &expr in &order {
        let number = expr.index();
        match arena.node(expr) {
            ExprNode::Constant(_) | ExprNode::Symbol(_) => {}
            ExprNode::Unary(function @ (Unary::Sin | Unary::Cos), a) => {
                let other = if function == Unary::Sin { Unary::Cos } else { Unary::Sin };
                // An unused partner has a number beyond all others.
                let partner = arena.existing(ExprNode::Unary(other, a)).map_or(arena.len() + number, Expr::index);
                if done.insert(a) {
                    let pair = if function == Unary::Sin { [number, partner] } else { [partner, number] };
                    steps.push(Statement::SineCosine(pair, of(a)));
                }
            }
            ExprNode::Unary(function, a) => steps.push(Statement::One(number, function, of(a))),
            ExprNode::Binary(function, a, b) => steps.push(Statement::Two(number, function, of(a), of(b))),
            ExprNode::Select(a, b, c) => steps.push(Statement::Select(number, of(a), of(b), of(c))),
        }
    }
    steps.extend(results.iter().map(|entry| Statement::Store(entry.output, entry.place, of(entry.expr))));
    steps
}

fn legend(equations: &Equations) -> Vec<String> {
    let system = &equations.system;
    let list = |title: &str, names: Vec<String>| (!names.is_empty()).then(|| format!("{title}: {}", names.join(", ")));
    let mechanism = &system.mechanism;
    let parameters = mechanism.parameters.iter().map(|parameter| parameter.name.clone());
    let parameters = parameters.chain(mechanism.discrete.iter().map(|discrete| discrete.name.clone())).collect();
    let of_p = if mechanism.discrete.is_empty() { "p: parameters" } else { "p: parameters, then discrete variables" };
    let inputs = system.mechanism.inputs.iter().map(|input| input.name.clone()).collect();
    let followers = system.followers.iter().enumerate().map(|(i, (_, input, given))| {
        let name = symbol_name(equations, Symbol::Follower(i, Order::Position));
        let given = if *given == Order::Velocity { "rate" } else { "acceleration" };
        format!("{name} (its {given} is the input {})", system.mechanism.inputs[input.0].name)
    });
    let coordinates = equations.coordinates.iter().map(|coordinate| coordinate.name.position.clone()).collect();
    let reactions = equations.loops().map(|(_, row)| system.name(row.element).to_owned()).collect();
    let factors = mechanism.contacts.iter().map(|contact| &mechanism.discrete[contact.state.closed.0].name);
    let factors: Vec<&str> = factors.map(String::as_str).collect();
    let modes = (!factors.is_empty()).then(|| {
        format!(
            "{}: 1 in the mode in which it holds, else 0; then its loop equation is 0 = 0, and its lambda 0",
            factors.join(", ")
        )
    });
    let lines = [
        Some("t: time; all quantities in SI units".to_owned()),
        list(of_p, parameters),
        modes,
        list("u: value, rate and acceleration of the inputs", inputs),
        list("f: position, rate and acceleration of the drivers that integrate an input", followers.collect()),
        list("q, v: coordinates and their rates", coordinates),
        list("z: states", system.mechanism.states.iter().map(|state| state.name.clone()).collect()),
        list("lambda: reactions", reactions),
    ];
    lines.into_iter().flatten().collect()
}

/// Arguments that the functions take, as arrays, and the index of a symbol in its array.
pub fn argument(symbol: Symbol) -> Option<(&'static str, usize)> {
    match symbol {
        // Discrete variables come after the parameters; `steps` has added their number.
        Symbol::Parameter(i) | Symbol::Discrete(i) => Some(("p", i)),
        Symbol::Input(i, order) => Some(("u", 3 * i + order as usize)),
        Symbol::Follower(i, order) => Some(("f", 3 * i + order as usize)),
        Symbol::Coordinate(i, Order::Position) => Some(("q", i)),
        Symbol::Coordinate(i, Order::Velocity) => Some(("v", i)),
        Symbol::Coordinate(i, Order::Acceleration) => Some(("a", i)),
        Symbol::State(i, Order::Position) => Some(("z", i)),
        Symbol::Reaction(i) => Some(("lambda", i)),
        // Time is a scalar; rates of states are results; missing masses and arguments of laws are not part of the code.
        Symbol::Time | Symbol::State(..) | Symbol::Missing(..) | Symbol::Argument => None,
    }
}

/// A comment cannot be ended by what stands in it, and lines stay short.
pub fn wrapped(line: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in line.split(' ') {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].len() + word.len() + 1 > width {
            lines.push(format!("  {word}"));
        } else {
            let gap = if lines[last].is_empty() { "" } else { " " };
            lines[last].push_str(&format!("{gap}{word}"));
        }
    }
    lines
}
