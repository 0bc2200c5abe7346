//! Planar mechanisms in absolute coordinates (x, y, angle of every body), solved by one dense system with multipliers.
//!
//! It shares no code and no idea with the product: no graphs, no trees, no symbols. Loads of joints and drivers are those on the
//! second body, at its point.

use super::variables::points;
use nalgebra::{DMatrix, DVector, Rotation2, Vector2};

/// A point of a body (relative to its mass centre, in its axes) or of the ground (`None`).
#[derive(Clone, Copy, Debug)]
pub struct At {
    pub body: Option<usize>,
    pub local: Vector2<f64>,
}

#[derive(Clone, Debug)]
pub struct Body {
    pub mass: f64,
    pub inertia: f64,
}

#[derive(Clone, Debug)]
pub enum JointKind {
    Revolute,
    /// `axis`: unit vector in the first body's axes.
    Prismatic {
        axis: Vector2<f64>,
        angle: f64,
    },
    Weld {
        angle: f64,
    },
}

#[derive(Clone, Debug)]
pub struct Joint {
    pub between: [At; 2],
    pub kind: JointKind,
    pub damping: f64,
}

/// What a driver prescribes; `motion` holds value, rate and acceleration at time zero, the acceleration being constant.
#[derive(Clone, Debug)]
pub enum Driver {
    Angle { between: [Option<usize>; 2], motion: [f64; 3] },
    Displacement { joint: usize, motion: [f64; 3] },
    Position { on: At, motion: [Vector2<f64>; 3] },
}

#[derive(Clone, Debug)]
pub enum Load {
    Force { on: At, vector: Vector2<f64>, in_body: bool },
    Torque { between: [Option<usize>; 2], value: f64 },
    Spring { between: [At; 2], stiffness: f64, length: f64, damping: f64 },
    TorsionSpring { between: [Option<usize>; 2], stiffness: f64, angle: f64, damping: f64 },
}

#[derive(Clone, Debug, Default)]
pub struct System {
    pub gravity: Vector2<f64>,
    pub bodies: Vec<Body>,
    pub joints: Vec<Joint>,
    pub drivers: Vec<Driver>,
    pub loads: Vec<Load>,
}

/// Three numbers for each body: x, y, angle, and their rates.
#[derive(Clone, Debug)]
pub struct State {
    pub q: DVector<f64>,
    pub v: DVector<f64>,
}

/// Accelerations, and the loads on the second body: fx fy | fn torque | fx fy torque for joints, the effort for drivers.
pub struct Solution {
    pub acceleration: DVector<f64>,
    pub joints: Vec<Vec<f64>>,
    pub drivers: Vec<Vec<f64>>,
}

/// Everything about the constraints at one state: residual, Jacobian, time derivative and right-hand side J a = gamma.
pub struct Constraints {
    pub residual: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    pub rate: DVector<f64>,
    pub gamma: DVector<f64>,
}

/// One scalar constraint: partial derivatives as (body, [x, y, angle]).
struct Row {
    residual: f64,
    partials: Vec<(usize, [f64; 3])>,
    rate: f64,
    gamma: f64,
}

/// Turned by +90 degrees.
pub fn turned(u: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-u.y, u.x)
}

/// Value, rate and acceleration at time `t`.
fn at_time(motion: [f64; 3], t: f64) -> [f64; 3] {
    let [p, v, a] = motion;
    [p + v * t + a * t * t / 2.0, v + a * t, a]
}

impl State {
    /// The first two of a body's three numbers.
    pub fn vector(x: &DVector<f64>, body: usize) -> Vector2<f64> {
        Vector2::new(x[3 * body], x[3 * body + 1])
    }

    pub fn angle(&self, body: Option<usize>) -> f64 {
        body.map_or(0.0, |b| self.q[3 * b + 2])
    }

    pub fn omega(&self, body: Option<usize>) -> f64 {
        body.map_or(0.0, |b| self.v[3 * b + 2])
    }

    /// A vector fixed in the body, in world axes.
    pub fn world(&self, body: Option<usize>, local: Vector2<f64>) -> Vector2<f64> {
        Rotation2::new(self.angle(body)) * local
    }

    pub fn position(&self, at: At) -> Vector2<f64> {
        let centre = at.body.map_or(Vector2::zeros(), |b| Self::vector(&self.q, b));
        centre + self.world(at.body, at.local)
    }

    pub fn velocity(&self, at: At) -> Vector2<f64> {
        let centre = at.body.map_or(Vector2::zeros(), |b| Self::vector(&self.v, b));
        centre + self.omega(at.body) * turned(self.world(at.body, at.local))
    }

    /// Acceleration of a point if the bodies' accelerations are `a`.
    pub fn acceleration(&self, at: At, a: &DVector<f64>) -> Vector2<f64> {
        let Some(body) = at.body else {
            return Vector2::zeros();
        };
        let arm = self.world(at.body, at.local);
        Self::vector(a, body) + a[3 * body + 2] * turned(arm) + self.centripetal(at)
    }

    fn centripetal(&self, at: At) -> Vector2<f64> {
        -self.omega(at.body).powi(2) * self.world(at.body, at.local)
    }

    /// Unit vector, length and rate of the line from the first point to the second.
    pub fn line(&self, between: [At; 2]) -> (Vector2<f64>, f64, f64) {
        let line = self.position(between[1]) - self.position(between[0]);
        let (along, length) = (line.normalize(), line.norm());
        (along, length, along.dot(&(self.velocity(between[1]) - self.velocity(between[0]))))
    }
}

/// How the world component `direction` of a point moves with its body's coordinates, times `sign`.
fn point_partials(state: &State, at: At, direction: Vector2<f64>, sign: f64) -> Option<(usize, [f64; 3])> {
    let turn = direction.dot(&turned(state.world(at.body, at.local)));
    at.body.map(|b| (b, [sign * direction.x, sign * direction.y, sign * turn]))
}

/// The second point minus the first along `direction`, which turns with the first body if `turns`.
fn relative_row(state: &State, between: [At; 2], direction: Vector2<f64>, turns: bool) -> Row {
    let [a, b] = between;
    let gap = state.position(b) - state.position(a);
    let gap_rate = state.velocity(b) - state.velocity(a);
    let mut partials: Vec<_> = point_partials(state, b, direction, 1.0).into_iter().collect();
    partials.extend(point_partials(state, a, direction, -1.0));
    let mut gamma = -direction.dot(&(state.centripetal(b) - state.centripetal(a)));
    if turns {
        let omega = state.omega(a.body);
        partials.extend(a.body.map(|body| (body, [0.0, 0.0, turned(direction).dot(&gap)])));
        gamma += omega * omega * direction.dot(&gap) - 2.0 * omega * turned(direction).dot(&gap_rate);
    }
    Row { residual: direction.dot(&gap), partials, rate: 0.0, gamma }
}

fn angle_row(state: &State, between: [Option<usize>; 2], motion: [f64; 3]) -> Row {
    let mut partials: Vec<_> = between[1].map(|b| (b, [0.0, 0.0, 1.0])).into_iter().collect();
    partials.extend(between[0].map(|b| (b, [0.0, 0.0, -1.0])));
    let residual = state.angle(between[1]) - state.angle(between[0]) - motion[0];
    Row { residual, partials, rate: -motion[1], gamma: motion[2] }
}

impl Row {
    fn driven(self, motion: [f64; 3]) -> Row {
        let (residual, gamma) = (self.residual - motion[0], self.gamma + motion[2]);
        Row { residual, rate: -motion[1], gamma, ..self }
    }
}

impl Joint {
    pub fn bodies(&self) -> [Option<usize>; 2] {
        self.between.map(|at| at.body)
    }

    fn rows(&self, state: &State) -> Vec<Row> {
        let fixed = |direction| relative_row(state, self.between, direction, false);
        let held = |angle| angle_row(state, self.bodies(), [angle, 0.0, 0.0]);
        match self.kind {
            JointKind::Revolute => vec![fixed(Vector2::x()), fixed(Vector2::y())],
            JointKind::Weld { angle } => {
                vec![fixed(Vector2::x()), fixed(Vector2::y()), held(angle)]
            }
            JointKind::Prismatic { axis, angle } => {
                let normal = turned(state.world(self.between[0].body, axis));
                vec![relative_row(state, self.between, normal, true), held(angle)]
            }
        }
    }
}

impl System {
    fn driver_rows(&self, driver: &Driver, state: &State, t: f64) -> Vec<Row> {
        match *driver {
            Driver::Angle { between, motion } => {
                vec![angle_row(state, between, at_time(motion, t))]
            }
            Driver::Displacement { joint, motion } => {
                let Joint { between, kind: JointKind::Prismatic { axis, .. }, .. } = self.joints[joint] else {
                    panic!("a displacement driver needs a prismatic joint")
                };
                let along = state.world(between[0].body, axis);
                vec![relative_row(state, between, along, true).driven(at_time(motion, t))]
            }
            Driver::Position { on, motion } => {
                let origin = At { body: None, local: Vector2::zeros() };
                let component = |i: usize, direction| {
                    relative_row(state, [origin, on], direction, false).driven(at_time(motion.map(|m| m[i]), t))
                };
                vec![component(0, Vector2::x()), component(1, Vector2::y())]
            }
        }
    }

    /// Rows of every joint, then of every driver.
    fn rows(&self, state: &State, t: f64) -> [Vec<Vec<Row>>; 2] {
        [
            self.joints.iter().map(|joint| joint.rows(state)).collect(),
            self.drivers.iter().map(|driver| self.driver_rows(driver, state, t)).collect(),
        ]
    }

    pub fn constraints(&self, state: &State, t: f64) -> Constraints {
        let rows: Vec<Row> = self.rows(state, t).into_iter().flatten().flatten().collect();
        let mut jacobian = DMatrix::zeros(rows.len(), 3 * self.bodies.len());
        for (r, row) in rows.iter().enumerate() {
            for (body, partials) in &row.partials {
                for (c, partial) in partials.iter().enumerate() {
                    jacobian[(r, 3 * body + c)] += partial;
                }
            }
        }
        let column = |value: fn(&Row) -> f64| DVector::from_iterator(rows.len(), rows.iter().map(value));
        Constraints { residual: column(|r| r.residual), jacobian, rate: column(|r| r.rate), gamma: column(|r| r.gamma) }
    }

    /// The diagonal of the mass matrix.
    pub fn masses(&self) -> DVector<f64> {
        DVector::from_vec(self.bodies.iter().flat_map(|b| [b.mass, b.mass, b.inertia]).collect())
    }

    /// How far the farthest point is from its mass centre or from the origin: what makes torques and forces alike.
    fn longest_arm(&self) -> f64 {
        let longest = points(self).iter().map(|(_, at)| at.local.norm()).fold(0.0, f64::max);
        if longest > 0.0 { longest } else { 1.0 }
    }

    /// Accelerations and reactions; of all possible reactions those of the smallest norm, torques divided by the longest arm.
    pub fn solve(&self, state: &State, t: f64) -> Solution {
        let Constraints { mut jacobian, mut gamma, .. } = self.constraints(state, t);
        // Rows of angles times the arm: their multipliers are torques divided by it. It matters only where something is redundant.
        let independent = jacobian.is_empty() || jacobian.rank(1e-9) == jacobian.nrows();
        let arm = if independent { 1.0 } else { self.longest_arm() };
        let angular = |row: &Row| row.partials.iter().all(|(_, partial)| partial[..2] == [0.0, 0.0]);
        let rows = self.rows(state, t).into_iter().flatten().flatten();
        let sizes: Vec<f64> = rows.map(|row| if angular(&row) { arm } else { 1.0 }).collect();
        for (row, &size) in sizes.iter().enumerate() {
            jacobian.row_mut(row).scale_mut(size);
            gamma[row] *= size;
        }
        let (n, m) = (3 * self.bodies.len(), gamma.len());
        let mut matrix = DMatrix::zeros(n + m, n + m);
        matrix.view_mut((0, 0), (n, n)).set_diagonal(&self.masses());
        matrix.view_mut((n, 0), (m, n)).copy_from(&jacobian);
        matrix.view_mut((0, n), (n, m)).copy_from(&jacobian.transpose());
        let mut right = DVector::zeros(n + m);
        right.rows_mut(0, n).copy_from(&self.applied(state));
        right.rows_mut(n, m).copy_from(&gamma);
        let svd = matrix.clone().svd(true, true);
        let cutoff = 1e-11 * svd.singular_values.max();
        let solve = |right: &DVector<f64>| svd.solve(right, cutoff).expect("both factors were asked for");
        let first = solve(&right);
        let refined = &first + solve(&(&right - &matrix * &first));
        let mut multipliers = refined.iter().skip(n).zip(&sizes).map(|(lambda, size)| lambda * size);
        let [joints, drivers] = self.rows(state, t).map(|groups| {
            // M a + J^T lambda = Q: the constraint pulls the second body with -lambda.
            let loads = |group: Vec<Row>| multipliers.by_ref().take(group.len()).map(|lambda| -lambda).collect();
            groups.into_iter().map(loads).collect()
        });
        Solution { acceleration: refined.rows(0, n).into_owned(), joints, drivers }
    }

    /// The velocity nearest to `v` that joints and drivers permit.
    pub fn permitted_velocity(&self, state: &State, t: f64) -> DVector<f64> {
        let Constraints { jacobian, rate, .. } = self.constraints(state, t);
        if rate.is_empty() {
            return state.v.clone();
        }
        let svd = jacobian.clone().svd(true, true);
        let cutoff = 1e-11 * svd.singular_values.max();
        let correct = |v: DVector<f64>| {
            let excess = &jacobian * &v + &rate;
            v - svd.solve(&excess, cutoff).expect("both factors were asked for")
        };
        correct(correct(state.v.clone()))
    }
}
