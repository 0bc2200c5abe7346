//! Masses on a line with linear springs and dampers: \[M\]{q''} + \[D\]{q'} + \[K\]{q} = {F} (Eq. 24), each matrix a product of cutset
//! columns and a diagonal, A_i i A_i^T (Eq. 33).

use std::collections::HashMap;

use super::Equations;
use super::dynamics::mass;
use crate::element::{Known, Origin};
use crate::expr::Expr;
use crate::graph::{ElementId, Topology};
use crate::mechanism::{Dimension, LoadKind, Side, SpringLaw};

/// The matrices of Eq. (24), n x n by rows, and the forces {F}.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vibration {
    /// \[M\] \[kg\]
    pub mass: Vec<Vec<Expr>>,
    /// \[D\] [N.s/m]
    pub damping: Vec<Vec<Expr>>,
    /// \[K\] [N/m]
    pub stiffness: Vec<Vec<Expr>>,
    /// {F} \[N\]: external forces, actuators, and what springs exert at q = 0.
    pub force: Vec<Expr>,
}

/// What one element adds: its constants, and its force when nothing moves.
struct Share {
    mass: Expr,
    damping: Expr,
    stiffness: Expr,
    force: Expr,
}

impl Equations<'_> {
    /// The matrices of Eq. (33) for these trees, if the scene is one of masses on a line whose springs are all linear and
    /// whose motion nothing prescribes.
    pub fn vibration(&mut self) -> Option<Vibration> {
        let mechanism = self.system.mechanism;
        if mechanism.dimension != Dimension::One || !mechanism.drivers.is_empty() {
            return None;
        }
        let n = self.coordinates.len();
        let zero = || vec![vec![Expr::ZERO; n]; n];
        let mut sum = Vibration { mass: zero(), damping: zero(), stiffness: zero(), force: vec![Expr::ZERO; n] };
        for (element, column) in self.cutset_columns() {
            let share = self.share(element)?;
            sum.add(self, &column, &share);
        }
        Some(sum)
    }

    /// Columns of the cutset matrix \[A_f\]: for each element the coordinates in whose cutset it is, with its sign.
    fn cutset_columns(&self) -> HashMap<ElementId, Vec<(usize, i8)>> {
        let tree = &self.trees.translation;
        let rows = Topology::new(&self.system.translation, tree).cutsets(tree);
        let mut columns: HashMap<ElementId, Vec<(usize, i8)>> = HashMap::new();
        for (&branch, cutset) in tree.branches.iter().zip(rows) {
            let Some(row) = self.coordinates.iter().position(|coordinate| coordinate.element == branch) else {
                continue;
            };
            for (element, sign) in cutset.into_iter().chain([(branch, 1)]) {
                columns.entry(element).or_default().push((row, sign));
            }
        }
        columns
    }

    fn share(&mut self, element: ElementId) -> Option<Share> {
        let none = Share { mass: Expr::ZERO, damping: Expr::ZERO, stiffness: Expr::ZERO, force: Expr::ZERO };
        let mechanism = self.system.mechanism;
        match self.system.element(element).origin {
            Origin::Body(body) => {
                let mass = mass(&mut self.system, body);
                let weight = self.system.value(&mechanism.gravity[0]);
                let weightless = mechanism.bodies[body.0].weightless;
                let force = if weightless { Expr::ZERO } else { self.system.arena.multiply(mass, weight) };
                Some(Share { mass, force, ..none })
            }
            Origin::Load(load) => match &mechanism.loads[load.0].kind {
                LoadKind::Spring { law, .. } => self.spring(law, element),
                LoadKind::Force { vector, .. } => Some(Share { force: self.formula(&vector[0]), ..none }),
                LoadKind::Actuator { force, .. } => Some(Share { force: self.formula(force), ..none }),
                _ => None,
            },
            _ => Some(none),
        }
    }

    fn spring(&mut self, law: &SpringLaw, element: ElementId) -> Option<Share> {
        let [stiffness, cubic, damping, free] =
            [&law.stiffness, &law.cubic, &law.damping, &law.free].map(|formula| self.formula(formula));
        let linear = cubic == Expr::ZERO && law.side == Side::Both;
        // Points away from the mass centres, and of the ground: the length at q = 0 is not zero.
        let fixed = self.fixed_length(element);
        let short = self.system.arena.subtract(free, fixed);
        let force = self.system.arena.multiply(stiffness, short);
        linear.then_some(Share { mass: Expr::ZERO, damping, stiffness, force })
    }

    /// The part of a spring's length that arms and ground vectors make: -\[B\]{r} of its circuit. A branch has none: its length is a
    /// coordinate.
    fn fixed_length(&mut self, element: ElementId) -> Expr {
        let tree = &self.trees.translation;
        if tree.branches.contains(&element) {
            return Expr::ZERO;
        }
        let circuit = Topology::new(&self.system.translation, tree).circuit(element);
        let mut length = Expr::ZERO;
        for (other, sign) in circuit {
            let known = self.system.element(other).translation.as_ref().map(|row| row.known.clone());
            let Some(Known::Fixed(_, [x, _])) = known else { continue };
            let arena = &mut self.system.arena;
            let x = if sign < 0 { x } else { arena.negate(x) };
            length = arena.add(length, x);
        }
        length
    }
}

impl Vibration {
    /// += a i a^T, and a F.
    fn add(&mut self, equations: &mut Equations, column: &[(usize, i8)], share: &Share) {
        let arena = &mut equations.system.arena;
        for &(row, sign) in column {
            let force = if sign > 0 { share.force } else { arena.negate(share.force) };
            self.force[row] = arena.add(self.force[row], force);
            for &(other, opposite) in column {
                let matrices = [&mut self.mass, &mut self.damping, &mut self.stiffness];
                for (matrix, constant) in matrices.into_iter().zip([share.mass, share.damping, share.stiffness]) {
                    let entry = if sign == opposite { constant } else { arena.negate(constant) };
                    matrix[row][other] = arena.add(matrix[row][other], entry);
                }
            }
        }
    }
}
