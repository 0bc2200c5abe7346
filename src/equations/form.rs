//! Linear forms: sums of `scalar expression x coefficient`. Accelerations, forces and torques are linear forms in
//! the accelerations of the coordinates, the reactions, products of rates, and loads; adding them merges what belongs to the same
//! scalar, so that nothing is ever multiplied out twice.

use std::collections::BTreeMap;

use crate::expr::{Arena, Binary, Expr, ExprNode, Unary};

pub trait Coefficient: Clone {
    fn zero() -> Self;
    /// self += other
    fn accumulate(&mut self, arena: &mut Arena, other: &Self);
    fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self;
    fn is_zero(&self) -> bool;
}

impl Coefficient for Expr {
    fn zero() -> Self {
        Expr::ZERO
    }
    fn accumulate(&mut self, arena: &mut Arena, other: &Self) {
        *self = arena.add(*self, *other);
    }
    fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self {
        arena.multiply(factor, *self)
    }
    fn is_zero(&self) -> bool {
        *self == Expr::ZERO
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct LinearForm<C>(BTreeMap<Expr, C>);

impl<C> Default for LinearForm<C> {
    fn default() -> Self {
        LinearForm(BTreeMap::new())
    }
}

impl<C: Coefficient> LinearForm<C> {
    pub fn term(arena: &mut Arena, key: Expr, coefficient: &C) -> Self {
        let mut form = LinearForm::default();
        form.add_term(arena, key, coefficient);
        form
    }

    pub fn keys(&self) -> impl Iterator<Item = Expr> {
        self.0.keys().copied()
    }

    /// self += key x coefficient. Numbers and signs go from the key to the coefficient.
    pub fn add_term(&mut self, arena: &mut Arena, key: Expr, coefficient: &C) {
        let (number, key) = split_number(arena, key);
        let coefficient = coefficient.scaled(arena, number);
        if coefficient.is_zero() {
            return;
        }
        let entry = self.0.entry(key).or_insert_with(C::zero);
        entry.accumulate(arena, &coefficient);
        if entry.is_zero() {
            self.0.remove(&key);
        }
    }

    /// self += factor x other
    pub fn accumulate(&mut self, arena: &mut Arena, factor: Expr, other: &Self) {
        for (&key, coefficient) in &other.0 {
            let coefficient = coefficient.scaled(arena, factor);
            self.add_term(arena, key, &coefficient);
        }
    }

    /// factor x self, in the coefficients.
    pub fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self {
        let mut form = LinearForm::default();
        form.accumulate(arena, factor, self);
        form
    }

    /// factor x self, in the keys: for factors that change with the motion.
    pub fn times(&self, arena: &mut Arena, factor: Expr) -> Self {
        let mut form = LinearForm::default();
        for (&key, coefficient) in &self.0 {
            let key = arena.multiply(key, factor);
            form.add_term(arena, key, coefficient);
        }
        form
    }

    pub fn map<D: Coefficient>(&self, arena: &mut Arena, mut linear: impl FnMut(&mut Arena, &C) -> D) -> LinearForm<D> {
        let mut form = LinearForm::default();
        for (&key, coefficient) in &self.0 {
            let image = linear(arena, coefficient);
            form.add_term(arena, key, &image);
        }
        form
    }

    pub fn terms(&self) -> impl Iterator<Item = (Expr, &C)> {
        self.0.iter().map(|(&key, coefficient)| (key, coefficient))
    }
}

impl LinearForm<Expr> {
    pub fn total(&self, arena: &mut Arena) -> Expr {
        let mut total = Expr::ZERO;
        for (key, coefficient) in self.terms() {
            total = arena.add_product(total, key, *coefficient);
        }
        total
    }
}

fn split_number(arena: &mut Arena, key: Expr) -> (Expr, Expr) {
    if arena.as_constant(key).is_some() {
        return (key, Expr::ONE);
    }
    match arena.node(key) {
        ExprNode::Unary(Unary::Negate, inner) => {
            let (number, rest) = split_number(arena, inner);
            (arena.negate(number), rest)
        }
        ExprNode::Binary(Binary::Multiply, a, b) if arena.as_constant(a).is_some() => (a, b),
        ExprNode::Binary(Binary::Multiply, a, b) if arena.as_constant(b).is_some() => (b, a),
        _ => (Expr::ONE, key),
    }
}
