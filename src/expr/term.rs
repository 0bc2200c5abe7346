//! Expressions written as formulas are: `1.0 - x.square()`.

use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arena, Binary, Expr, Unary};

/// An expression, with the arena in which others are made of it.
#[derive(Clone, Copy)]
pub struct ArenaTerm<'a> {
    arena: &'a RefCell<&'a mut Arena>,
    expr: Expr,
}

impl fmt::Debug for ArenaTerm<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expr.fmt(f)
    }
}

/// The expression that a formula makes of others.
pub fn build<const N: usize>(
    arena: &mut Arena,
    operands: [Expr; N],
    formula: impl for<'a> FnOnce([ArenaTerm<'a>; N]) -> ArenaTerm<'a>,
) -> Expr {
    let [made] = build_all(arena, operands, |operands| [formula(operands)]);
    made
}

/// The expressions that formulas make of others.
pub fn build_all<const N: usize, const M: usize>(
    arena: &mut Arena,
    operands: [Expr; N],
    formulas: impl for<'a> FnOnce([ArenaTerm<'a>; N]) -> [ArenaTerm<'a>; M],
) -> [Expr; M] {
    let arena = RefCell::new(arena);
    formulas(operands.map(|expr| ArenaTerm { arena: &arena, expr })).map(|term| term.expr)
}

impl<'a> ArenaTerm<'a> {
    fn make(self, make: impl FnOnce(&mut Arena, Expr) -> Expr) -> Self {
        let expr = make(&mut self.arena.borrow_mut(), self.expr);
        ArenaTerm { expr, ..self }
    }

    fn with(self, other: Self, make: impl FnOnce(&mut Arena, Expr, Expr) -> Expr) -> Self {
        self.make(|arena, a| make(arena, a, other.expr))
    }

    /// Another expression of the same arena.
    pub fn other(self, expr: Expr) -> Self {
        ArenaTerm { expr, ..self }
    }

    pub fn number(self, value: f64) -> Self {
        self.make(|arena, _| arena.constant(value))
    }

    /// Is it the number 0?
    pub fn is_zero(self) -> bool {
        self.expr == Expr::ZERO
    }

    pub fn square(self) -> Self {
        self.make(Arena::square)
    }

    pub fn power(self, exponent: Self) -> Self {
        self.with(exponent, Arena::power)
    }

    pub fn sin(self) -> Self {
        self.make(Arena::sin)
    }

    pub fn cos(self) -> Self {
        self.make(Arena::cos)
    }

    pub fn of(self, function: Unary) -> Self {
        self.make(|arena, a| arena.unary(function, a))
    }

    pub fn and(self, function: Binary, other: Self) -> Self {
        self.with(other, |arena, a, b| arena.binary(function, a, b))
    }

    /// Where the operand is not zero the first, else the second.
    pub fn select(self, then: Self, otherwise: Self) -> Self {
        self.make(|arena, condition| arena.select(condition, then.expr, otherwise.expr))
    }

    pub fn clamp(self, least: f64, most: f64) -> Self {
        self.and(Binary::Max, self.number(least)).and(Binary::Min, self.number(most))
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $build:ident;)*) => {$(
        impl<'a> $trait for ArenaTerm<'a> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.with(other, Arena::$build)
            }
        }

        impl<'a> $trait<ArenaTerm<'a>> for f64 {
            type Output = ArenaTerm<'a>;
            fn $method(self, other: ArenaTerm<'a>) -> ArenaTerm<'a> {
                other.number(self).with(other, Arena::$build)
            }
        }
    )*};
}

operators! {
    Add add add;
    Sub sub subtract;
    Mul mul multiply;
    Div div divide;
}

impl Neg for ArenaTerm<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.make(Arena::negate)
    }
}
