//! Masses on a line with linear springs and dampers: \[M\]{q''} + \[D\]{q'} + \[K\]{q} = {F} (Eq. 24), each matrix a product of cutset
//! columns and a diagonal, A_i i A_i^T (Eq. 33).

use std::collections::BTreeMap;

use super::Equations;
use super::inertias::mass;
use crate::component::{Force, Known, Origin};
use crate::expr::{Expr, Symbol};
use crate::graph::{ElementId, Topology};
use crate::mechanism::Dimension;

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

/// The contribution of one element: its constants, and its force at q = 0.
struct Share {
    mass: Expr,
    damping: Expr,
    stiffness: Expr,
    force: Expr,
}

impl Equations {
    /// The matrices of Eq. (33) for these trees, for masses on a line with linear loads.
    pub fn vibration(&mut self) -> Option<Vibration> {
        self.linear()?.ok()
    }

    /// The same, or why a scene of masses on a line has no such matrices; none for a scene in the plane.
    pub fn linear(&mut self) -> Option<Result<Vibration, String>> {
        (self.system.mechanism.dimension == Dimension::One).then(|| self.matrices())
    }

    fn matrices(&mut self) -> Result<Vibration, String> {
        let n = self.coordinates.len();
        let zero = || vec![vec![Expr::ZERO; n]; n];
        let mut sum = Vibration { mass: zero(), damping: zero(), stiffness: zero(), force: vec![Expr::ZERO; n] };
        for (element, column) in self.cutset_columns() {
            let share = self.share(element)?;
            sum.add(self, &column, &share);
        }
        Ok(sum)
    }

    /// Columns of the cutset matrix \[A_f\]: for each element the coordinates in whose cutset it is, with its sign.
    fn cutset_columns(&self) -> BTreeMap<ElementId, Vec<(usize, i8)>> {
        let tree = &self.trees.translation;
        let rows = Topology::new(&self.system.translation, tree).cutsets(tree);
        let mut columns: BTreeMap<ElementId, Vec<(usize, i8)>> = BTreeMap::new();
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

    fn share(&mut self, element: ElementId) -> Result<Share, String> {
        let mechanism = &*self.system.mechanism.clone();
        let [position, rate, acceleration] = self.prescribed(element);
        let mut share = Share { mass: Expr::ZERO, damping: Expr::ZERO, stiffness: Expr::ZERO, force: Expr::ZERO };
        match self.system.element(element).origin {
            Origin::Body(body) => {
                share.mass = mass(&mut self.system, body);
                let weight = self.system.value(&mechanism.gravity[0]);
                let arena = &mut self.system.arena;
                let weight = if mechanism.bodies[body.0].weightless { Expr::ZERO } else { weight };
                let net = arena.subtract(weight, acceleration);
                share.force = arena.multiply(share.mass, net);
            }
            Origin::Load(load) => {
                let load = &mechanism.loads[load.0];
                match (load.component().linear)(load)? {
                    Some(linear) => {
                        let [stiffness, damping, free] = linear.each_ref().map(|formula| self.formula(formula));
                        (share.stiffness, share.damping) = (stiffness, damping);
                        let arena = &mut self.system.arena;
                        let short = arena.subtract(free, position);
                        let push = arena.multiply(share.stiffness, short);
                        share.force = arena.subtract_product(push, share.damping, rate);
                    }
                    None => share.force = self.outer_force(element, &load.name)?,
                }
            }
            _ => {}
        }
        Ok(share)
    }

    fn outer_force(&mut self, element: ElementId, name: &str) -> Result<Expr, String> {
        let through = self.system.element(element).translation.as_ref().map(|row| row.through.clone());
        let Some(Force::World([law, _])) = through else { return Ok(Expr::ZERO) };
        let force = self.formula(&law);
        let symbols = self.system.arena.symbols([force]);
        match symbols.iter().any(|symbol| matches!(symbol, Symbol::Coordinate(..))) {
            true => Err(format!("the law of `{name}` depends on the motion; write it as a spring if it is linear")),
            false => Ok(force),
        }
    }

    /// The part of an element's displacement that no coordinate changes, and its rate and acceleration: what arms, ground vectors and drivers
    /// prescribe, -\[B\]{r} of its circuit. A branch has none: its displacement is a coordinate.
    fn prescribed(&mut self, element: ElementId) -> [Expr; 3] {
        let tree = &self.trees.translation;
        let mut sums = [Expr::ZERO; 3];
        if tree.branches.contains(&element) {
            return sums;
        }
        let circuit = Topology::new(&self.system.translation, tree).circuit(element);
        for (other, sign) in circuit {
            let known = self.system.element(other).translation.as_ref().map(|row| row.known.clone());
            let own = match known {
                Some(Known::Fixed(_, [x, _])) => [x, Expr::ZERO, Expr::ZERO],
                Some(Known::Given([x, _])) => [x.value, x.rate, x.acceleration],
                _ => continue,
            };
            let arena = &mut self.system.arena;
            for (sum, x) in sums.iter_mut().zip(own) {
                *sum = if sign < 0 { arena.add(*sum, x) } else { arena.subtract(*sum, x) };
            }
        }
        sums
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
