//! From the arena to sums of products; long subexpressions that are used more than once become definitions.

use std::collections::{HashMap, HashSet};

use cotree::expr::{Arena, Binary, Expr, ExprNode, Symbol, Unary};

use super::contract::contracted;
use super::normal::{CalledFunction, ProductTerm, Sum, TermFactor};

/// Shared subexpressions with so many symbols are named; roots, such as lengths, with fewer.
const LONG: usize = 10;
const LONG_ROOT: usize = 3;
/// Expressions with more levels of parentheses are split.
const DEEP: usize = 12;
/// Expressions with more symbols are split.
const WIDE: usize = 300;

#[derive(Clone, Debug, Default)]
pub struct Readable {
    /// The definitions that [`TermFactor::Named`] refers to, operands first.
    pub definitions: Vec<Definition>,
    /// The expressions, in the order in which they were given.
    pub roots: Vec<Sum>,
}

#[derive(Clone, Debug, Default)]
pub struct ReadingContext {
    pub variables: HashMap<Expr, String>,
    /// Parameters with mass in their unit, and masses.
    pub weights: HashSet<Symbol>,
}

#[derive(Clone, Debug)]
pub struct Definition {
    /// The user's name for it, if there is one.
    pub variable: Option<String>,
    pub value: Sum,
    pub uses: usize,
}

impl Readable {
    pub fn new(arena: &Arena, roots: &[Expr], context: &ReadingContext) -> Self {
        let order = arena.reachable(roots.iter().copied());
        let (mut names, forced) = candidates(arena, &order, roots, &context.variables);
        loop {
            let (reading, expressions) = SumReader::read(arena, &order, roots, context, (&names, &forced));
            let before = names.len();
            for (definition, expr) in reading.definitions.iter().zip(expressions) {
                if definition.uses < 2 && !forced.contains(&expr) {
                    names.remove(&expr);
                }
            }
            if names.len() == before {
                return reading;
            }
        }
    }
}

/// Subexpressions to be named: those that are shared and long, or too long or too deep for one formula; and of these the latter.
fn candidates(
    arena: &Arena,
    order: &[Expr],
    roots: &[Expr],
    variables: &HashMap<Expr, String>,
) -> (HashSet<Expr>, HashSet<Expr>) {
    let mut uses: HashMap<Expr, usize> = HashMap::new();
    for operand in order.iter().flat_map(|&expr| arena.node(expr).operands()).chain(roots.iter().copied()) {
        *uses.entry(operand).or_default() += 1;
    }
    let (mut names, mut forced) = (HashSet::new(), HashSet::new());
    let (mut sizes, mut depths) = (HashMap::new(), HashMap::new());
    for &expr in order {
        let operands: Vec<Expr> = arena.node(expr).operands().collect();
        let size: usize = match arena.node(expr) {
            ExprNode::Constant(_) => 0,
            ExprNode::Symbol(_) | ExprNode::Unary(Unary::Sin | Unary::Cos, _) => 1,
            _ => operands.iter().map(|operand| sizes[operand]).sum(),
        };
        let depth = operands.iter().map(|operand| depths[operand]).max().unwrap_or(0) + level(arena, expr);
        let shared = uses.get(&expr).is_some_and(|&count| count > 1) && size >= long(arena, expr);
        let unreadable = size >= WIDE || depth >= DEEP;
        let named = shared || unreadable;
        if named {
            names.insert(expr);
        }
        if unreadable {
            forced.insert(expr);
        }
        let atom = named || variables.contains_key(&expr);
        sizes.insert(expr, if atom { 1 } else { size });
        depths.insert(expr, if atom { 0 } else { depth });
    }
    (names, forced)
}

/// The number of symbols from which a shared subexpression is named.
fn long(arena: &Arena, expr: Expr) -> usize {
    if matches!(arena.node(expr), ExprNode::Unary(Unary::Sqrt, _)) { LONG_ROOT } else { LONG }
}

/// Sums and signs nest without parentheses, and so do products.
fn level(arena: &Arena, expr: Expr) -> usize {
    match arena.node(expr) {
        ExprNode::Constant(_) | ExprNode::Symbol(_) | ExprNode::Unary(Unary::Negate, _) => 0,
        ExprNode::Binary(Binary::Add | Binary::Subtract, a, b) => {
            let is_product = |e| matches!(arena.node(e), ExprNode::Binary(Binary::Multiply | Binary::Divide, ..));
            usize::from(is_product(a) || is_product(b))
        }
        ExprNode::Binary(Binary::Multiply, a, b) => {
            let is_sum = |e| matches!(arena.node(e), ExprNode::Binary(Binary::Add | Binary::Subtract, ..));
            usize::from(is_sum(a) || is_sum(b))
        }
        _ => 1,
    }
}

/// Sums whose only use is another sum: their terms are collected there, once for the whole sum.
fn parts_of_sums(arena: &Arena, order: &[Expr], roots: &[Expr], is_atom: impl Fn(&Expr) -> bool) -> HashSet<Expr> {
    let mut uses: HashMap<Expr, usize> = roots.iter().map(|&root| (root, 2)).collect();
    let mut within_sums: HashSet<Expr> = HashSet::new();
    for &expr in order {
        for operand in arena.node(expr).operands() {
            *uses.entry(operand).or_default() += 1;
            if is_sum(arena, expr) {
                within_sums.insert(operand);
            }
        }
    }
    within_sums.retain(|expr| uses[expr] == 1 && is_sum(arena, *expr) && !is_atom(expr));
    within_sums
}

fn is_sum(arena: &Arena, expr: Expr) -> bool {
    matches!(arena.node(expr), ExprNode::Unary(Unary::Negate, _) | ExprNode::Binary(Binary::Add | Binary::Subtract, ..))
}

struct SumReader<'a> {
    arena: &'a Arena,
    /// What [`parts_of_sums`] found.
    parts: HashSet<Expr>,
    /// Collected but not yet tidy: sums may still grow.
    known: HashMap<Expr, Sum>,
    products: HashMap<Expr, ProductTerm>,
    weights: &'a HashSet<Symbol>,
    definitions: Vec<Definition>,
}

impl<'a> SumReader<'a> {
    fn read(
        arena: &'a Arena,
        order: &[Expr],
        roots: &[Expr],
        context: &'a ReadingContext,
        (names, forced): (&HashSet<Expr>, &HashSet<Expr>),
    ) -> (Readable, Vec<Expr>) {
        let is_atom = |expr: &Expr| names.contains(expr) || context.variables.contains_key(expr);
        let mut reader = SumReader {
            arena,
            parts: parts_of_sums(arena, order, roots, is_atom),
            known: HashMap::new(),
            products: HashMap::new(),
            weights: &context.weights,
            definitions: Vec::new(),
        };
        let mut expressions = Vec::new();
        for &expr in order {
            if reader.parts.contains(&expr) {
                continue;
            }
            let sum = reader.sum(expr);
            let variable = context.variables.get(&expr).cloned();
            let sum = if variable.is_none() && !names.contains(&expr) {
                sum
            } else {
                let value = contracted(&sum.tidy(), &reader.definitions);
                let short =
                    if forced.contains(&expr) { value.leaves() < 2 } else { value.leaves() < long(arena, expr) };
                if variable.is_none() && short {
                    value
                } else {
                    let factor = TermFactor::Named(reader.definitions.len(), value.is_constant());
                    reader.definitions.push(Definition { variable, value, uses: 0 });
                    expressions.push(expr);
                    Sum::of(ProductTerm::factor(factor))
                }
            };
            reader.known.insert(expr, sum);
        }
        let root = |root| contracted(&reader.known[root].clone().tidy(), &reader.definitions);
        let roots: Vec<Sum> = roots.iter().map(root).collect();
        (Readable::counted(reader.definitions, roots), expressions)
    }

    fn sum(&mut self, expr: Expr) -> Sum {
        if let ExprNode::Binary(Binary::Multiply | Binary::Divide, a, b) = self.arena.node(expr) {
            let (a, b) = (self.product(a), self.product(b));
            let is_quotient = matches!(self.arena.node(expr), ExprNode::Binary(Binary::Divide, ..));
            return Sum::of(a.times(&if is_quotient { b.inverse() } else { b }));
        }
        let known = |operand: Expr| &self.known[&operand];
        match self.arena.node(expr) {
            ExprNode::Constant(bits) => Sum::of(ProductTerm::number(f64::from_bits(bits))),
            ExprNode::Symbol(symbol) => {
                Sum::of(ProductTerm::factor(TermFactor::Symbol(symbol, self.weights.contains(&symbol))))
            }
            ExprNode::Unary(Unary::Negate, a) if !self.parts.contains(&a) => known(a).scaled(-1.0),
            ExprNode::Unary(Unary::Negate, _) | ExprNode::Binary(Binary::Add | Binary::Subtract, ..) => {
                Sum::collect(self.terms(expr))
            }
            ExprNode::Unary(function @ (Unary::Sin | Unary::Cos), a) => {
                let angle = known(a).clone().tidy();
                Sum::of(ProductTerm::factor(TermFactor::Trigonometric(angle, function == Unary::Sin)))
            }
            ExprNode::Unary(function, a) => self.call(CalledFunction::One(function), &[a]),
            ExprNode::Binary(function, a, b) => self.call(CalledFunction::Two(function), &[a, b]),
            ExprNode::Select(a, b, c) => self.call(CalledFunction::Select, &[a, b, c]),
        }
    }

    /// The terms of a sum and of the sums that are part of it, from left to right.
    fn terms(&self, sum: Expr) -> Vec<ProductTerm> {
        let mut terms = Vec::new();
        let mut waiting = vec![(sum, 1.0)];
        while let Some((expr, sign)) = waiting.pop() {
            match self.arena.node(expr) {
                _ if expr != sum && !self.parts.contains(&expr) => {
                    terms.extend(self.known[&expr].0.iter().map(|term| term.scaled(sign)));
                }
                ExprNode::Binary(Binary::Add, a, b) => waiting.extend([(b, sign), (a, sign)]),
                ExprNode::Binary(Binary::Subtract, a, b) => waiting.extend([(b, -sign), (a, sign)]),
                ExprNode::Unary(Unary::Negate, a) => waiting.push((a, -sign)),
                _ => {} // no sum has other operations
            }
        }
        terms
    }

    fn product(&mut self, operand: Expr) -> ProductTerm {
        let known = &self.known;
        self.products.entry(operand).or_insert_with(|| known[&operand].clone().tidy().product()).clone()
    }

    fn call(&self, function: CalledFunction, operands: &[Expr]) -> Sum {
        let arguments = operands.iter().map(|operand| self.known[operand].clone().tidy()).collect();
        Sum::of(ProductTerm::factor(TermFactor::Call(function, arguments)))
    }
}

impl Readable {
    fn counted(mut definitions: Vec<Definition>, roots: Vec<Sum>) -> Readable {
        let mut uses = vec![0; definitions.len()];
        roots.iter().for_each(|root| count(root, &mut uses));
        // Later definitions may use earlier ones, but only those that are used themselves count.
        for index in (0..definitions.len()).rev() {
            if uses[index] > 0 {
                count(&definitions[index].value, &mut uses);
            }
        }
        for (definition, uses) in definitions.iter_mut().zip(uses) {
            definition.uses = uses;
        }
        Readable { definitions, roots }
    }
}

fn count(sum: &Sum, uses: &mut [usize]) {
    for (factor, _) in sum.0.iter().flat_map(|term: &ProductTerm| &term.factors) {
        match factor {
            TermFactor::Symbol(..) => {}
            TermFactor::Named(index, _) => uses[*index] += 1,
            TermFactor::Trigonometric(inner, _) | TermFactor::Sum(inner) => count(inner, uses),
            TermFactor::Call(_, arguments) => arguments.iter().for_each(|argument| count(argument, uses)),
        }
    }
}
