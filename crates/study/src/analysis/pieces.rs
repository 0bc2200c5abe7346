//! Piecewise laws that change over at the point itself. `sign(v)` at rest has the derivative zero by its formula and none in truth, and so has `max(0, x)` at x = 0: no linear system describes the motion on both sides.

use cotree::equations::Equations;
use cotree::expr::{Expr, Symbol, Values};

use super::OperatingPoint;
use super::variation::{RowBlock, Variation};

/// How far from the point both sides are looked at, in units of a coordinate's scale; and what part of that again.
const BESIDE: f64 = 1e-7;
const NEARER: f64 = 0.125;
/// A difference of both sides counts from this share of the values; rounding is far below it.
const COUNTS: f64 = 1e-6;
/// What is continuous leaves `NEARER` of its difference on the nearer sides, a discontinuity all.
const LEFT: f64 = 0.5;

impl Variation {
    /// The first position, rate or state in which the forces or their derivatives are discontinuous at a point; the scales are those of the coordinates and states.
    pub(super) fn discontinuity(
        &self,
        equations: &Equations,
        point: &OperatingPoint,
        scales: &[f64],
    ) -> Option<Symbol> {
        let switches = self.switches();
        if switches.is_empty() {
            return None;
        }
        let forces = self.with_derivatives(RowBlock::Motion);
        let mut variables = self.moving().iter().zip(scales.iter().cycle());
        let found = variables.find(|&(&symbol, &scale)| {
            let at = |roots: &[Expr], shift: f64| {
                let value = |of: Symbol| point.value(of) + if of == symbol { shift } else { 0.0 };
                equations.system.arena.evaluate(roots, &value)
            };
            let sides = |roots: &[Expr], shift: f64| [-shift, shift].map(|shift| at(roots, shift));
            let [below, above] = sides(switches, BESIDE * scale);
            let switched = below.iter().zip(&above).any(|(below, above)| below * above < 0.0);
            switched && jumps(&sides(&forces, BESIDE * scale), &sides(&forces, NEARER * BESIDE * scale))
        });
        found.map(|(symbol, _)| *symbol)
    }
}

/// True if a value differs as much between the nearer sides as between the farther ones.
fn jumps([below, above]: &[Vec<f64>; 2], [nearer_below, nearer_above]: &[Vec<f64>; 2]) -> bool {
    (0..below.len()).any(|index| {
        let far = (above[index] - below[index]).abs();
        let near = (nearer_above[index] - nearer_below[index]).abs();
        far > COUNTS * above[index].abs().max(below[index].abs()) && near > LEFT * far
    })
}
