//! Functions that the runtime has no operation for, in terms of those that it has.

use std::borrow::Cow;
use std::collections::HashMap;

use super::function::Evaluation;
use super::term::build;
use super::{Arena, Binary, Expr, ExprNode, Symbol, Unary};

/// Expressions without composed functions, by the original ones.
#[derive(Clone, Debug, Default)]
pub struct Expansions(HashMap<Expr, Expr>);

impl Expansions {
    pub fn of(&self, roots: &[Expr]) -> Vec<Expr> {
        roots.iter().map(|root| self.0.get(root).copied().unwrap_or(*root)).collect()
    }
}

impl Arena {
    /// The composition of a function; none for a function with an operation of its own.
    fn composed(&mut self, expr: Expr) -> Option<Expr> {
        match self.node(expr) {
            ExprNode::Unary(function, a) => match function.definition().run {
                Evaluation::As(formula) => Some(build(self, [a], formula)),
                Evaluation::Own(..) => None,
            },
            ExprNode::Binary(function, a, b) => match function.definition().run {
                Evaluation::As(formula) => Some(build(self, [a, b], formula)),
                Evaluation::Own(..) => None,
            },
            _ => None,
        }
    }

    /// The composition of a function for Taylor series, if they have no operation for it.
    pub fn series_of_unary(&mut self, function: Unary, a: Expr) -> Option<Expr> {
        function.definition().for_series().map(|formula| build(self, [a], formula))
    }

    pub fn series_of_binary(&mut self, function: Binary, a: Expr, b: Expr) -> Option<Expr> {
        function.definition().for_series().map(|formula| build(self, [a, b], formula))
    }

    /// The same expressions without functions that are composed of others.
    pub fn expanded(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let mut known = Expansions::default();
        self.expand(roots, &mut known.0);
        known.of(roots)
    }

    /// An arena that contains the roots without composed functions: this one if they have none.
    pub fn runnable(&self, roots: &[Expr]) -> (Cow<'_, Arena>, Expansions) {
        let (mut arena, mut known) = (Cow::Borrowed(self), Expansions::default());
        if self.reachable(roots.iter().copied()).into_iter().any(|expr| self.is_composed(expr)) {
            arena.to_mut().expand(roots, &mut known.0);
        }
        (arena, known)
    }

    /// The expression with a value in the place of a symbol.
    pub fn substituted(&mut self, expr: Expr, symbol: Symbol, value: Expr) -> Expr {
        let replaced = self.symbol(symbol);
        let mut known = HashMap::from([(replaced, value)]);
        for inner in self.reachable([expr]) {
            let of = |operand: Expr| known.get(&operand).copied().unwrap_or(operand);
            if !self.node(inner).operands().any(|operand| of(operand) != operand) {
                continue;
            }
            let rebuilt = match self.node(inner) {
                ExprNode::Unary(function, a) => self.apply_unary(function, of(a)),
                ExprNode::Binary(function, a, b) => self.apply_binary(function, of(a), of(b)),
                ExprNode::Select(a, b, c) => self.select(of(a), of(b), of(c)),
                ExprNode::Constant(_) | ExprNode::Symbol(_) => inner,
            };
            known.insert(inner, rebuilt);
        }
        known.get(&expr).copied().unwrap_or(expr)
    }

    fn is_composed(&self, expr: Expr) -> bool {
        match self.node(expr) {
            ExprNode::Unary(function, _) => matches!(function.definition().run, Evaluation::As(_)),
            ExprNode::Binary(function, ..) => matches!(function.definition().run, Evaluation::As(_)),
            _ => false,
        }
    }

    fn expand(&mut self, roots: &[Expr], known: &mut HashMap<Expr, Expr>) {
        for expr in self.reachable(roots.iter().copied()) {
            if known.contains_key(&expr) {
                continue;
            }
            let of = |operand: Expr| known.get(&operand).copied().unwrap_or(operand);
            let changed = self.node(expr).operands().any(|operand| of(operand) != operand);
            let rebuilt = match self.node(expr) {
                ExprNode::Unary(function, a) if changed => self.apply_unary(function, of(a)),
                ExprNode::Binary(function, a, b) if changed => self.apply_binary(function, of(a), of(b)),
                ExprNode::Select(a, b, c) if changed => self.select(of(a), of(b), of(c)),
                _ => expr,
            };
            let mut meaning = rebuilt;
            if let Some(composed) = self.composed(rebuilt) {
                self.expand(&[composed], known);
                meaning = known.get(&composed).copied().unwrap_or(composed);
            }
            if meaning != expr {
                known.insert(expr, meaning);
            }
        }
    }
}
