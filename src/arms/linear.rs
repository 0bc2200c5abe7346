//! Vectors and angles as constant combinations of arms and of displacements.

use super::{Arm, ArmFactor, Arms, Equations, NoSeries};
use crate::equations::form::Coefficient;
use crate::equations::kinematics::is_constant;
use crate::equations::vector::Vector;
use crate::expr::{Arena, Binary, Expr, ExprNode, Order, Symbol, Unary};

impl Equations {
    pub(super) fn decompose(&mut self, vector: &Vector) -> Result<Arms, NoSeries> {
        let mut arms = Arms::new();
        for (frame, components) in vector.parts() {
            for (axis, component) in components.into_iter().enumerate() {
                let mut terms = Vec::new();
                linear(&mut self.system.arena, component, Expr::ONE, &mut terms)?;
                for (factor, coefficient) in terms {
                    let z = arms.entry(Arm { frame, factor }).or_insert([Expr::ZERO; 2]);
                    z[axis] = self.system.arena.add(z[axis], coefficient);
                }
            }
        }
        arms.retain(|_, z| *z != [Expr::ZERO; 2]);
        Ok(arms)
    }
}

/// conj(a) b
pub fn conjugate_product(arena: &mut Arena, a: [Expr; 2], b: [Expr; 2]) -> [Expr; 2] {
    let [rr, ii, ri, ir] = [(a[0], b[0]), (a[1], b[1]), (a[0], b[1]), (a[1], b[0])].map(|(x, y)| arena.multiply(x, y));
    [arena.add(rr, ii), arena.subtract(ri, ir)]
}

/// Splits an expression that is linear in displacements: factors with constant coefficients.
pub(super) fn linear(
    arena: &mut Arena,
    expr: Expr,
    coefficient: Expr,
    terms: &mut Vec<(ArmFactor, Expr)>,
) -> Result<(), NoSeries> {
    if is_constant(arena, expr) {
        let term = arena.multiply(coefficient, expr);
        if !term.is_zero() {
            terms.push((ArmFactor::One, term));
        }
        return Ok(());
    }
    match arena.node(expr) {
        ExprNode::Symbol(Symbol::Coordinate(index, Order::Position)) => {
            terms.push((ArmFactor::Displacement(index), coefficient));
            Ok(())
        }
        ExprNode::Unary(Unary::Negate, a) => {
            let minus = arena.negate(coefficient);
            linear(arena, a, minus, terms)
        }
        ExprNode::Binary(Binary::Add, a, b) => {
            linear(arena, a, coefficient, terms)?;
            linear(arena, b, coefficient, terms)
        }
        ExprNode::Binary(Binary::Subtract, a, b) => {
            linear(arena, a, coefficient, terms)?;
            let minus = arena.negate(coefficient);
            linear(arena, b, minus, terms)
        }
        ExprNode::Binary(Binary::Multiply, a, b) if is_constant(arena, a) || is_constant(arena, b) => {
            let (constant, moving) = if is_constant(arena, a) { (a, b) } else { (b, a) };
            let product = arena.multiply(coefficient, constant);
            linear(arena, moving, product, terms)
        }
        ExprNode::Binary(Binary::Divide, a, b) if is_constant(arena, b) => {
            let quotient = arena.divide(coefficient, b);
            linear(arena, a, quotient, terms)
        }
        _ if arena.symbols([expr]).iter().all(|symbol| !matches!(symbol, Symbol::Coordinate(..))) => {
            terms.push((ArmFactor::Signal(expr), coefficient));
            Ok(())
        }
        _ => Err(NoSeries("a displacement is not a linear function of the coordinates".to_owned())),
    }
}
