//! Derivatives of expressions.
//!
//! A rate along a motion is the one on the right: the rate of what holds from that instant on. Where the sides of `min(t, 1)` meet it is 0, and that of `max(0, t - 1)` is 1; so the pieces of all
//! laws that change over at one instant are those that follow it, whichever way round a law is written.

use std::collections::HashMap;

use super::term::build;
use super::{Arena, Binary, Expr, ExprNode, Order, Symbol, Unary};

impl Arena {
    /// d expr / d symbol.
    pub fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        let of_symbol = |_: &mut Arena, s: Symbol| if s == symbol { Expr::ONE } else { Expr::ZERO };
        self.chain(expr, &of_symbol)
    }

    /// d roots / d symbol; shared subexpressions are differentiated once.
    pub fn derivatives(&mut self, roots: &[Expr], symbol: Symbol) -> Vec<Expr> {
        let of_symbol = |_: &mut Arena, s: Symbol| if s == symbol { Expr::ONE } else { Expr::ZERO };
        let known = self.chain_all(roots, &of_symbol, |_, _, _| None);
        roots.iter().map(|root| known[root]).collect()
    }

    /// d expr / dt, through time, inputs, followers and coordinates; the derivatives of accelerations are not known and must
    /// not be asked for.
    pub fn time_derivative(&mut self, expr: Expr) -> Expr {
        let rate = |arena: &mut Arena, symbol: Symbol| {
            let next = match symbol {
                Symbol::Time => return Expr::ONE,
                Symbol::Input(i, order) => order.next().map(|next| Symbol::Input(i, next)),
                Symbol::Follower(i, order) => order.next().map(|next| Symbol::Follower(i, next)),
                Symbol::Coordinate(i, order) => order.next().map(|next| Symbol::Coordinate(i, next)),
                // The rate of a state's rate is never asked for.
                Symbol::State(i, Order::Position) => Some(Symbol::State(i, Order::Velocity)),
                Symbol::State(..) => None,
                Symbol::Parameter(_) | Symbol::Discrete(_) | Symbol::Reaction(_) => None,
                Symbol::Missing(..) | Symbol::Argument => None,
            };
            next.map_or(Expr::ZERO, |next| arena.symbol(next))
        };
        self.chain_all(&[expr], &rate, Arena::rate_from_here)[&expr]
    }

    /// The rate from an instant on of what is smaller, larger, a size or chosen by a comparison, if it depends on which piece follows; the sides of a comparison may be equal there.
    fn rate_from_here(&mut self, inner: Expr, known: &HashMap<Expr, Expr>) -> Option<Expr> {
        match self.node(inner) {
            ExprNode::Binary(function @ (Binary::Min | Binary::Max), a, b) => {
                let [da, db] = [a, b].map(|side| known[&side]);
                let equal = self.binary(function, da, db);
                let [least, most] = if function == Binary::Min { [da, db] } else { [db, da] };
                Some(self.piece([a, b], [least, equal, most]))
            }
            ExprNode::Unary(Unary::Abs, a) => {
                let rate = known[&a];
                let [back, size] = [self.negate(rate), self.unary(Unary::Abs, rate)];
                Some(self.piece([a, Expr::ZERO], [back, size, rate]))
            }
            ExprNode::Select(condition, then, otherwise) => {
                let ExprNode::Binary(function @ (Binary::Less | Binary::LessEqual), a, b) = self.node(condition) else {
                    return None;
                };
                let [then, otherwise, da, db] = [then, otherwise, a, b].map(|part| known[&part]);
                // A comparison of sums may be one of what is left between them.
                let follows = self.compare(function, da, db);
                let equal = self.select(follows, then, otherwise);
                Some(self.piece([a, b], [then, equal, otherwise]))
            }
            _ => None,
        }
    }

    /// The first where a < b, the second where they are equal, else the third.
    fn piece(&mut self, [a, b]: [Expr; 2], [below, equal, above]: [Expr; 3]) -> Expr {
        let is_above = self.compare(Binary::Less, b, a);
        let rest = self.select(is_above, above, equal);
        let is_below = self.compare(Binary::Less, a, b);
        self.select(is_below, below, rest)
    }

    /// The chain rule, given the derivative of each symbol.
    fn chain(&mut self, expr: Expr, of_symbol: &dyn Fn(&mut Arena, Symbol) -> Expr) -> Expr {
        self.chain_all(&[expr], of_symbol, |_, _, _| None)[&expr]
    }

    /// The derivatives of all subexpressions; `special` has a rule of its own for some, given those of their operands.
    fn chain_all(
        &mut self,
        roots: &[Expr],
        of_symbol: &dyn Fn(&mut Arena, Symbol) -> Expr,
        special: impl Fn(&mut Arena, Expr, &HashMap<Expr, Expr>) -> Option<Expr>,
    ) -> HashMap<Expr, Expr> {
        let mut known: HashMap<Expr, Expr> = HashMap::new();
        for inner in self.reachable(roots.iter().copied()) {
            if let Some(derivative) = special(self, inner, &known) {
                known.insert(inner, derivative);
                continue;
            }
            let derivative = match self.node(inner) {
                ExprNode::Constant(_) => Expr::ZERO,
                ExprNode::Symbol(symbol) => of_symbol(self, symbol),
                ExprNode::Unary(_, a) if known[&a] == Expr::ZERO => Expr::ZERO,
                ExprNode::Unary(function, a) => {
                    let rule = function.definition().derivative;
                    build(self, [a, known[&a], inner], |[a, da, value]| rule([a], [da], value))
                }
                ExprNode::Binary(_, a, b) if known[&a] == Expr::ZERO && known[&b] == Expr::ZERO => Expr::ZERO,
                ExprNode::Binary(function, a, b) => {
                    let rule = function.definition().derivative;
                    build(self, [a, b, known[&a], known[&b], inner], |[a, b, da, db, value]| {
                        rule([a, b], [da, db], value)
                    })
                }
                ExprNode::Select(condition, a, b) => {
                    let (da, db) = (known[&a], known[&b]);
                    self.select(condition, da, db)
                }
            };
            known.insert(inner, derivative);
        }
        known
    }
}

impl Symbol {
    /// True for an acceleration or a reaction, which is known only after the equations of motion are solved.
    pub fn is_solved(self) -> bool {
        match self {
            Symbol::Coordinate(_, Order::Acceleration) | Symbol::State(_, Order::Velocity) | Symbol::Reaction(_) => {
                true
            }
            Symbol::Coordinate(_, Order::Position | Order::Velocity)
            | Symbol::State(_, Order::Position | Order::Acceleration)
            | Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Missing(..)
            | Symbol::Argument => false,
        }
    }

    /// True for a parameter, the one symbol that stays as it is along a motion, whatever happens in it.
    pub fn is_parameter(self) -> bool {
        self.is_constant_between_instants() && !matches!(self, Symbol::Discrete(_))
    }

    /// True for a parameter or a discrete variable, which stay as they are between instants.
    pub fn is_constant_between_instants(self) -> bool {
        match self {
            Symbol::Parameter(_) | Symbol::Discrete(_) => true,
            Symbol::Time
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Missing(..)
            | Symbol::Argument => false,
        }
    }
}
