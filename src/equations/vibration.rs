//! Masses on a line with linear springs and dampers: \[M\]{q''} + \[D\]{q'} + \[K\]{q} = {F} (Eq. 24), each matrix a product of cutset
//! columns and a diagonal, A_i i A_i^T (Eq. 33).

use std::collections::BTreeMap;

use super::inertias::mass;
use super::linear_law::{LinearLaw, OwnLaw};
use super::{Equations, GraphRecord};
use crate::expr::{Expr, Symbol};
use crate::model::{Dimension, Owner};
use crate::network::{ElementId, Force, Known, Origin, Translation};

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
    /// What these are the sums of, for each element that a coordinate moves.
    pub columns: Vec<ElementColumn>,
}

/// The contribution of one element: its column of the cutset matrix, its constants, and its force at q = 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ElementColumn {
    pub element: ElementId,
    /// The coordinates in whose cutset it is, with its sign.
    pub signs: Vec<(usize, i8)>,
    pub mass: Expr,
    pub damping: Expr,
    pub stiffness: Expr,
    pub force: Expr,
}

/// Why masses on a line have no matrices of a linear vibrating system.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NonlinearLoad(pub String);

impl Equations {
    /// The matrices of Eq. (33) for these trees, for masses on a line with linear loads.
    pub fn vibration(&mut self) -> Option<Vibration> {
        self.linear()?.ok()
    }

    /// The same, or why a scene of masses on a line has no such matrices; none for a scene in the plane.
    pub fn linear(&mut self) -> Option<Result<Vibration, NonlinearLoad>> {
        (self.system.mechanism.dimension == Dimension::One).then(|| self.matrices())
    }

    fn matrices(&mut self) -> Result<Vibration, NonlinearLoad> {
        let n = self.coordinates.len();
        let zero = || vec![vec![Expr::ZERO; n]; n];
        let force = vec![Expr::ZERO; n];
        let mut sum = Vibration { mass: zero(), damping: zero(), stiffness: zero(), force, columns: Vec::new() };
        let (record, _) = self.record();
        for (element, signs) in self.cutset_columns(&record) {
            let column = self.column(element, signs, &record)?;
            sum.add(self, &column);
            sum.columns.push(column);
        }
        Ok(sum)
    }

    /// The signs in the columns of the cutset matrix \[A_f\].
    fn cutset_columns(&self, record: &GraphRecord<Translation>) -> BTreeMap<ElementId, Vec<(usize, i8)>> {
        let mut columns: BTreeMap<ElementId, Vec<(usize, i8)>> = BTreeMap::new();
        for (row, coordinate) in self.coordinates.iter().enumerate() {
            for &(edge, sign) in record.cutset(coordinate.element).into_iter().flatten() {
                columns.entry(record.edges[edge].element).or_default().push((row, sign));
            }
        }
        columns
    }

    fn column(
        &mut self,
        element: ElementId,
        signs: Vec<(usize, i8)>,
        record: &GraphRecord<Translation>,
    ) -> Result<ElementColumn, NonlinearLoad> {
        let mechanism = &*self.system.mechanism.clone();
        let [position, rate, acceleration] = self.prescribed(element, record);
        let zero = Expr::ZERO;
        let mut column = ElementColumn { element, signs, mass: zero, damping: zero, stiffness: zero, force: zero };
        match self.system.element(element).origin {
            Origin::Body(body) => {
                column.mass = mass(&mut self.system, body);
                let weight = self.system.value(&mechanism.gravity[0]);
                let arena = &mut self.system.arena;
                let weight = if mechanism.bodies[body.0].weightless { Expr::ZERO } else { weight };
                let net = arena.subtract(weight, acceleration);
                column.force = arena.multiply(column.mass, net);
            }
            Origin::Load(load) if mechanism.there(Owner::Load(load)).is_some() => {
                return Err(NonlinearLoad(format!("an event can remove `{}`", mechanism.loads[load.0].name)));
            }
            Origin::Load(load) => {
                let name = &mechanism.loads[load.0].name;
                let linear = match self.own_law(load) {
                    OwnLaw::Outer => {
                        column.force = self.outer_force(element, name)?;
                        return Ok(column);
                    }
                    OwnLaw::Centred | OwnLaw::Linear => self.linear_law(load),
                    OwnLaw::Nonlinear => None,
                };
                let nonlinear = || NonlinearLoad(format!("the law of `{name}` is not linear"));
                let LinearLaw { stiffness, damping, rest } = linear.ok_or_else(nonlinear)?;
                (column.stiffness, column.damping) = (stiffness, damping);
                let arena = &mut self.system.arena;
                let push = arena.subtract_product(rest, stiffness, position);
                column.force = arena.subtract_product(push, damping, rate);
            }
            _ => {}
        }
        Ok(column)
    }

    fn outer_force(&mut self, element: ElementId, name: &str) -> Result<Expr, NonlinearLoad> {
        let through = self.system.element(element).translation.as_ref().map(|row| row.through.clone());
        let Some(Force::World([law, _])) = through else { return Ok(Expr::ZERO) };
        let force = self.formula(&law);
        let symbols = self.system.arena.symbols([force]);
        match symbols.iter().any(|symbol| matches!(symbol, Symbol::Coordinate(..))) {
            true => Err(NonlinearLoad(format!(
                "the law of `{name}` depends on the motion; if it is linear, write it as a spring"
            ))),
            false => Ok(force),
        }
    }

    /// The part of an element's displacement that no coordinate changes, and its rate and acceleration: what arms, ground vectors and drivers
    /// prescribe, -\[B\]{r} of its circuit. A branch has none: its displacement is a coordinate.
    fn prescribed(&mut self, element: ElementId, record: &GraphRecord<Translation>) -> [Expr; 3] {
        let mut sums = [Expr::ZERO; 3];
        for &(edge, sign) in record.circuit(element).into_iter().flat_map(|circuit| &circuit[1..]) {
            let known =
                self.system.element(record.edges[edge].element).translation.as_ref().map(|row| row.known.clone());
            let motion = match known {
                Some(Known::Fixed(_, [x, _])) => [x, Expr::ZERO, Expr::ZERO],
                Some(Known::Given([x, _])) => [x.value, x.rate, x.acceleration],
                _ => continue,
            };
            let arena = &mut self.system.arena;
            for (sum, x) in sums.iter_mut().zip(motion) {
                *sum = if sign < 0 { arena.add(*sum, x) } else { arena.subtract(*sum, x) };
            }
        }
        sums
    }
}

impl Vibration {
    /// += a i a^T, and a F.
    fn add(&mut self, equations: &mut Equations, element_column: &ElementColumn) {
        let arena = &mut equations.system.arena;
        for &(row, sign) in &element_column.signs {
            let force = if sign > 0 { element_column.force } else { arena.negate(element_column.force) };
            self.force[row] = arena.add(self.force[row], force);
            for &(other, opposite) in &element_column.signs {
                let matrices = [&mut self.mass, &mut self.damping, &mut self.stiffness];
                for (matrix, constant) in
                    matrices.into_iter().zip([element_column.mass, element_column.damping, element_column.stiffness])
                {
                    let entry = if sign == opposite { constant } else { arena.negate(constant) };
                    matrix[row][other] = arena.add(matrix[row][other], entry);
                }
            }
        }
    }
}
