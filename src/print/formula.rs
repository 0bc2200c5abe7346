//! Expressions as text, with the fewest parentheses; what is long and used more than once gets a name.

use std::collections::HashMap;

use crate::expr::{Arena, Binary, Expr, Node, Symbol, Unary};

/// Prints expressions of one arena.
pub struct Printer<'a> {
    arena: &'a Arena,
    symbol: &'a dyn Fn(Symbol) -> String,
    /// Sub-expressions that have a name of their own.
    names: HashMap<Expr, String>,
}

/// How tightly an operator binds.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Binding {
    Sum,
    Product,
    Sign,
    Power,
    Atom,
}

impl<'a> Printer<'a> {
    /// Names what the roots share: `z1`, `z2`, ... in the order of definition.
    pub fn new(arena: &'a Arena, symbol: &'a dyn Fn(Symbol) -> String, roots: &[Expr]) -> (Self, Vec<(String, Expr)>) {
        let mut printer = Printer { arena, symbol, names: HashMap::new() };
        let order = arena.reachable(roots.iter().copied());
        let mut uses: HashMap<Expr, usize> = HashMap::new();
        let mut size: HashMap<Expr, usize> = HashMap::new();
        for &expr in &order {
            let operands: Vec<Expr> = arena.node(expr).operands().collect();
            for operand in &operands {
                *uses.entry(*operand).or_default() += 1;
            }
            size.insert(expr, 1 + operands.iter().map(|operand| size[operand]).sum::<usize>().min(1 << 20));
        }
        for root in roots {
            *uses.entry(*root).or_default() += 1;
        }
        let mut named = Vec::new();
        // Sizes shrink as parts get names, so that a few names keep everything short.
        for &expr in &order {
            let own: usize = 1 + arena.node(expr).operands().map(|operand| size[&operand]).sum::<usize>();
            let shared = uses.get(&expr).is_some_and(|&count| count > 1) && own >= 6;
            size.insert(expr, if shared { 1 } else { own });
            if shared {
                let name = format!("z{}", named.len() + 1);
                named.push((name.clone(), expr));
                printer.names.insert(expr, name);
            }
        }
        (printer, named)
    }

    /// An expression; one with a name as that name.
    pub fn print(&self, expr: Expr) -> String {
        self.bound(expr, Binding::Sum)
    }

    /// What a named expression stands for.
    pub fn definition(&self, expr: Expr) -> String {
        self.inner(expr).0
    }

    fn bound(&self, expr: Expr, least: Binding) -> String {
        if let Some(name) = self.names.get(&expr) {
            return name.clone();
        }
        let (text, binding) = self.inner(expr);
        if binding < least { format!("({text})") } else { text }
    }

    fn inner(&self, expr: Expr) -> (String, Binding) {
        match self.arena.node(expr) {
            Node::Constant(bits) => number(f64::from_bits(bits)),
            Node::Symbol(symbol) => ((self.symbol)(symbol), Binding::Atom),
            Node::Unary(Unary::Negate, a) => (format!("-{}", self.bound(a, Binding::Sign)), Binding::Sign),
            Node::Unary(function, a) => (format!("{}({})", unary_name(function), self.print(a)), Binding::Atom),
            Node::Binary(function, a, b) => self.binary(function, a, b),
            Node::Select(condition, a, b) => {
                (format!("if({}, {}, {})", self.print(condition), self.print(a), self.print(b)), Binding::Atom)
            }
        }
    }

    fn binary(&self, function: Binary, a: Expr, b: Expr) -> (String, Binding) {
        let call = |name| (format!("{name}({}, {})", self.print(a), self.print(b)), Binding::Atom);
        let infix =
            |sign, left, right, binding| (format!("{}{sign}{}", self.bound(a, left), self.bound(b, right)), binding);
        match function {
            Binary::Add => infix(" + ", Binding::Sum, Binding::Sum, Binding::Sum),
            Binary::Subtract => infix(" - ", Binding::Sum, Binding::Product, Binding::Sum),
            Binary::Multiply if a == b => (format!("{}^2", self.bound(a, Binding::Atom)), Binding::Power),
            Binary::Multiply if self.arena.as_constant(b).is_some() => self.binary(function, b, a),
            Binary::Multiply => infix("*", Binding::Product, Binding::Product, Binding::Product),
            Binary::Divide => infix("/", Binding::Product, Binding::Sign, Binding::Product),
            Binary::Power => infix("^", Binding::Atom, Binding::Atom, Binding::Power),
            Binary::Less => infix(" < ", Binding::Sum, Binding::Sum, Binding::Sum),
            Binary::LessEqual => infix(" <= ", Binding::Sum, Binding::Sum, Binding::Sum),
            Binary::Atan2 => call("atan2"),
            Binary::Min => call("min"),
            Binary::Max => call("max"),
        }
    }
}

fn number(value: f64) -> (String, Binding) {
    let size = value.abs();
    let text = if size != 0.0 && !(1e-4..1e7).contains(&size) { format!("{value:e}") } else { format!("{value}") };
    (text, if value < 0.0 { Binding::Sign } else { Binding::Atom })
}

fn unary_name(function: Unary) -> &'static str {
    match function {
        Unary::Negate => "-",
        Unary::Sqrt => "sqrt",
        Unary::Sin => "sin",
        Unary::Cos => "cos",
        Unary::Tan => "tan",
        Unary::Asin => "asin",
        Unary::Acos => "acos",
        Unary::Atan => "atan",
        Unary::Exp => "exp",
        Unary::Log => "log",
        Unary::Tanh => "tanh",
        Unary::Abs => "abs",
        Unary::Sign => "sign",
        Unary::Floor => "floor",
    }
}
