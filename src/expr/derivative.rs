//! Derivatives of expressions.

use std::collections::HashMap;

use super::{Arena, Binary, Expr, Node, Order, Symbol, Unary};

impl Arena {
    /// d expr / d symbol.
    pub fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        let of_symbol = |_: &mut Arena, s: Symbol| if s == symbol { Expr::ONE } else { Expr::ZERO };
        self.chain(expr, &of_symbol)
    }

    /// d roots / d symbol; what the roots share is differentiated once.
    pub fn derivatives(&mut self, roots: &[Expr], symbol: Symbol) -> Vec<Expr> {
        let of_symbol = |_: &mut Arena, s: Symbol| if s == symbol { Expr::ONE } else { Expr::ZERO };
        let known = self.chain_all(roots, &of_symbol);
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
                Symbol::Parameter(_) | Symbol::Reaction(_) | Symbol::Missing(..) => None,
            };
            next.map_or(Expr::ZERO, |next| arena.symbol(next))
        };
        self.chain(expr, &rate)
    }

    /// The chain rule, given the derivative of each symbol.
    fn chain(&mut self, expr: Expr, of_symbol: &dyn Fn(&mut Arena, Symbol) -> Expr) -> Expr {
        self.chain_all(&[expr], of_symbol)[&expr]
    }

    /// The derivatives of everything that the roots are made of.
    fn chain_all(&mut self, roots: &[Expr], of_symbol: &dyn Fn(&mut Arena, Symbol) -> Expr) -> HashMap<Expr, Expr> {
        let mut known: HashMap<Expr, Expr> = HashMap::new();
        for inner in self.reachable(roots.iter().copied()) {
            let derivative = match self.node(inner) {
                Node::Constant(_) => Expr::ZERO,
                Node::Symbol(symbol) => of_symbol(self, symbol),
                Node::Unary(function, a) => {
                    let da = known[&a];
                    if da == Expr::ZERO {
                        Expr::ZERO
                    } else {
                        let slope = self.slope(function, a, inner);
                        self.multiply(slope, da)
                    }
                }
                Node::Binary(function, a, b) => self.binary_derivative(function, [a, b], [known[&a], known[&b]], inner),
                Node::Select(condition, a, b) => {
                    let (da, db) = (known[&a], known[&b]);
                    self.select(condition, da, db)
                }
            };
            known.insert(inner, derivative);
        }
        known
    }

    /// f'(a), where `value` is f(a).
    fn slope(&mut self, function: Unary, a: Expr, value: Expr) -> Expr {
        match function {
            Unary::Negate => self.constant(-1.0),
            Unary::Sqrt => {
                let half = self.constant(0.5);
                self.divide(half, value)
            }
            Unary::Sin => self.cos(a),
            Unary::Cos => {
                let sine = self.sin(a);
                self.negate(sine)
            }
            Unary::Tan => {
                let square = self.square(value);
                self.add(Expr::ONE, square)
            }
            Unary::Asin | Unary::Acos => {
                let square = self.square(a);
                let rest = self.subtract(Expr::ONE, square);
                let root = self.unary(Unary::Sqrt, rest);
                let slope = self.divide(Expr::ONE, root);
                if function == Unary::Asin { slope } else { self.negate(slope) }
            }
            Unary::Atan => {
                let square = self.square(a);
                let sum = self.add(Expr::ONE, square);
                self.divide(Expr::ONE, sum)
            }
            Unary::Exp => value,
            Unary::Log => self.divide(Expr::ONE, a),
            Unary::Tanh => {
                let square = self.square(value);
                self.subtract(Expr::ONE, square)
            }
            Unary::Abs => self.unary(Unary::Sign, a),
            Unary::Sign | Unary::Floor => Expr::ZERO,
        }
    }

    fn binary_derivative(&mut self, function: Binary, [a, b]: [Expr; 2], [da, db]: [Expr; 2], value: Expr) -> Expr {
        if da == Expr::ZERO && db == Expr::ZERO {
            return Expr::ZERO;
        }
        match function {
            Binary::Add => self.add(da, db),
            Binary::Subtract => self.subtract(da, db),
            Binary::Multiply => {
                let (left, right) = (self.multiply(da, b), self.multiply(a, db));
                self.add(left, right)
            }
            Binary::Divide => {
                let right = self.multiply(value, db);
                let rise = self.subtract(da, right);
                self.divide(rise, b)
            }
            Binary::Power => self.power_derivative([a, b], [da, db], value),
            Binary::Atan2 => {
                let (left, right) = (self.multiply(b, da), self.multiply(a, db));
                let rise = self.subtract(left, right);
                let (aa, bb) = (self.square(a), self.square(b));
                let norm = self.add(aa, bb);
                self.divide(rise, norm)
            }
            Binary::Min => {
                let first = self.binary(Binary::LessEqual, a, b);
                self.select(first, da, db)
            }
            Binary::Max => {
                let second = self.binary(Binary::LessEqual, a, b);
                self.select(second, db, da)
            }
            Binary::Less | Binary::LessEqual => Expr::ZERO,
        }
    }

    /// d a^b = b a^(b-1) da + a^b ln(a) db
    fn power_derivative(&mut self, [a, b]: [Expr; 2], [da, db]: [Expr; 2], value: Expr) -> Expr {
        let less = self.subtract(b, Expr::ONE);
        let lowered = self.power(a, less);
        let slope = self.multiply(b, lowered);
        let base = self.multiply(slope, da);
        if db == Expr::ZERO {
            return base;
        }
        let log = self.unary(Unary::Log, a);
        let rate = self.multiply(value, log);
        let exponent = self.multiply(rate, db);
        self.add(base, exponent)
    }
}

impl Symbol {
    /// Is this an acceleration or a reaction, known only after the equations of motion are solved?
    pub fn is_solved(self) -> bool {
        matches!(self, Symbol::Coordinate(_, Order::Acceleration) | Symbol::Reaction(_))
    }
}
