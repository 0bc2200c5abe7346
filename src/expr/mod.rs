//! Hash-consed expressions: equal expressions are the same handle, so sharing is free and equality is identity.

mod affine;
mod cam;
mod compare;
mod derivative;
mod evaluate;
mod expand;
mod function;
mod import;
mod indicators;
mod simplify;
mod term;

use std::collections::{BinaryHeap, HashMap};

pub use evaluate::Values;
pub use expand::Expansions;
pub use function::{Binary, Evaluation, Function, Shown, Unary, UnitRule};
pub use indicators::indicators;
pub use term::{ArenaTerm, build, build_all};

/// Handle of an expression in an [`Arena`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Expr(u32);

impl Expr {
    /// The number 0, the same in every arena.
    pub const ZERO: Expr = Expr(0);
    /// The number 1, the same in every arena.
    pub const ONE: Expr = Expr(1);

    pub fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Order {
    Position,
    Velocity,
    Acceleration,
}

impl Order {
    pub const ALL: [Order; 3] = [Order::Position, Order::Velocity, Order::Acceleration];

    /// The next derivative, if the equations ever need it.
    pub fn next(self) -> Option<Order> {
        match self {
            Order::Position => Some(Order::Velocity),
            Order::Velocity => Some(Order::Acceleration),
            Order::Acceleration => None,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Property {
    Mass,
    Inertia,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Symbol {
    Time,
    Parameter(usize),
    /// A discrete variable: constant between instants.
    Discrete(usize),
    /// An input of the scene or one of its time derivatives.
    Input(usize, Order),
    /// The position, rate or acceleration of a driver that integrates an input.
    Follower(usize, Order),
    /// Branch coordinate q, its rate v or its acceleration a.
    Coordinate(usize, Order),
    /// A state of the scene: its value (`Position`) or its rate (`Velocity`).
    State(usize, Order),
    /// Multiplier lambda.
    Reaction(usize),
    /// A mass or inertia that the scene does not give: an error if it is needed.
    Missing(usize, Property),
    /// What a law of one variable depends on, until the variable takes its place.
    Argument,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ExprNode {
    Constant(u64),
    Symbol(Symbol),
    Unary(Unary, Expr),
    Binary(Binary, Expr, Expr),
    /// b if a is not zero, else c
    Select(Expr, Expr, Expr),
}

impl ExprNode {
    pub fn operands(self) -> impl Iterator<Item = Expr> {
        let operands = match self {
            ExprNode::Constant(_) | ExprNode::Symbol(_) => [None; 3],
            ExprNode::Unary(_, a) => [Some(a), None, None],
            ExprNode::Binary(_, a, b) => [Some(a), Some(b), None],
            ExprNode::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        };
        operands.into_iter().flatten()
    }
}

/// Owns expressions. An operand always has a smaller index than what uses it.
#[derive(Clone, Debug)]
pub struct Arena {
    nodes: Vec<ExprNode>,
    known: HashMap<ExprNode, Expr>,
}

impl Default for Arena {
    fn default() -> Self {
        let mut arena = Arena { nodes: Vec::new(), known: HashMap::new() };
        arena.intern(ExprNode::Constant(0.0_f64.to_bits()));
        arena.intern(ExprNode::Constant(1.0_f64.to_bits()));
        arena
    }
}

impl Arena {
    pub fn node(&self, expr: Expr) -> ExprNode {
        self.nodes[expr.index()]
    }

    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// False: 0 and 1 are always there.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The value of a constant.
    pub fn as_constant(&self, expr: Expr) -> Option<f64> {
        match self.node(expr) {
            ExprNode::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub fn constant(&mut self, value: f64) -> Expr {
        // One zero: -0 and 0 must be the same handle.
        let value = if value == 0.0 { 0.0 } else { value };
        self.intern(ExprNode::Constant(value.to_bits()))
    }

    pub fn symbol(&mut self, symbol: Symbol) -> Expr {
        self.intern(ExprNode::Symbol(symbol))
    }

    pub fn sum(&mut self, terms: impl IntoIterator<Item = Expr>) -> Expr {
        terms.into_iter().fold(Expr::ZERO, |sum, term| self.add(sum, term))
    }

    /// All subexpressions of the given expressions, operands first.
    pub fn reachable(&self, roots: impl IntoIterator<Item = Expr>) -> Vec<Expr> {
        let mut stack: Vec<Expr> = roots.into_iter().collect();
        if let Some(few) = self.few_reachable(&stack) {
            return few;
        }
        let mut seen = vec![false; stack.iter().max().map_or(0, |root| root.index() + 1)];
        let mut found = Vec::new();
        while let Some(expr) = stack.pop() {
            if !std::mem::replace(&mut seen[expr.index()], true) {
                found.push(expr);
                stack.extend(self.node(expr).operands());
            }
        }
        found.sort_unstable();
        found
    }

    /// The same, if they are few: most questions are about small expressions of a large arena, whose size they must not cost. The largest first, which none
    /// of the others uses.
    fn few_reachable(&self, roots: &[Expr]) -> Option<Vec<Expr>> {
        const FEW: usize = 500;
        let mut left: BinaryHeap<Expr> = roots.iter().copied().collect();
        let mut found = Vec::new();
        while let Some(expr) = left.pop() {
            if found.last() != Some(&expr) {
                found.push(expr);
                left.extend(self.node(expr).operands());
            }
            if found.len() > FEW {
                return None;
            }
        }
        found.reverse();
        Some(found)
    }

    /// The symbols that the given expressions depend on, in order.
    pub fn symbols(&self, roots: impl IntoIterator<Item = Expr>) -> Vec<Symbol> {
        let mut symbols: Vec<Symbol> = self
            .reachable(roots)
            .into_iter()
            .filter_map(|expr| match self.node(expr) {
                ExprNode::Symbol(symbol) => Some(symbol),
                _ => None,
            })
            .collect();
        symbols.sort_unstable();
        symbols
    }

    pub fn all(&self) -> impl Iterator<Item = Expr> + use<> {
        (0..self.nodes.len()).map(|i| Expr(i as u32))
    }

    /// The handle of an operation that was made before.
    pub fn existing(&self, node: ExprNode) -> Option<Expr> {
        self.known.get(&node).copied()
    }

    fn intern(&mut self, node: ExprNode) -> Expr {
        if let Some(&expr) = self.known.get(&node) {
            return expr;
        }
        let expr = Expr(self.nodes.len() as u32);
        self.nodes.push(node);
        self.known.insert(node, expr);
        expr
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subexpressions_are_in_order_whether_few_or_many() {
        let mut arena = Arena::default();
        let mut all = vec![arena.symbol(Symbol::Time)];
        for last in 0..1000 {
            let next = arena.sin(all[last]);
            all.push(next);
            assert_eq!(arena.reachable([next, all[last / 2]]), all);
        }
    }
}
