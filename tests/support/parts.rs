//! Joints that the classical formulation in `absolute` does not have, each as plain functions of the bodies' coordinates.
//! Derivatives come from jets (a value with two derivatives along a straight line), not from formulas.

use super::absolute::{At, State, System, turned};
use super::jet::Jet;
use nalgebra::{DMatrix, DVector, Vector2};

/// A joint; loads are those on the second body (the rack).
#[derive(Clone, Debug)]
pub enum Part {
    Slot { between: [At; 2], axis: Vector2<f64> },
    Rolling { between: [At; 2], axis: Vector2<f64>, radius: f64, displacement: f64 },
    Distance { between: [At; 2], length: f64 },
    Gear { between: [Option<usize>; 2], carrier: Option<usize>, ratio: f64, angle: f64 },
    Rack { pinion: Option<usize>, slide: [At; 2], axis: Vector2<f64>, radius: f64, displacement: f64 },
}

/// The bodies' coordinates on a straight line in a direction.
struct Pose<'a> {
    q: &'a DVector<f64>,
    along: &'a DVector<f64>,
}

impl Pose<'_> {
    fn coordinate(&self, body: Option<usize>, which: usize) -> Jet {
        body.map_or(Jet::constant(0.0), |b| Jet([self.q[3 * b + which], self.along[3 * b + which], 0.0]))
    }

    fn angle(&self, body: Option<usize>) -> Jet {
        self.coordinate(body, 2)
    }

    fn turned(&self, body: Option<usize>, local: Vector2<f64>) -> [Jet; 2] {
        let (s, c) = self.angle(body).sin_cos();
        let [x, y] = [local.x, local.y].map(Jet::constant);
        [c * x - s * y, s * x + c * y]
    }

    fn point(&self, at: At) -> [Jet; 2] {
        let [x, y] = self.turned(at.body, at.local);
        [self.coordinate(at.body, 0) + x, self.coordinate(at.body, 1) + y]
    }

    /// (second - first) . direction, which is fixed in the first body.
    fn along(&self, [a, b]: [At; 2], direction: Vector2<f64>) -> Jet {
        let ([ax, ay], [bx, by]) = (self.point(a), self.point(b));
        let [ux, uy] = self.turned(a.body, direction);
        (bx - ax) * ux + (by - ay) * uy
    }
}

impl Part {
    /// The constraints; their multipliers are minus the loads.
    fn residuals(&self, pose: &Pose) -> Vec<Jet> {
        let number = Jet::constant;
        match *self {
            Part::Slot { between, axis } => vec![pose.along(between, turned(axis))],
            Part::Rolling { between, axis, radius, displacement } => {
                let [a, b] = between.map(|at| pose.angle(at.body));
                vec![
                    pose.along(between, turned(axis)) - number(radius),
                    pose.along(between, axis) + number(radius) * (b - a) - number(displacement),
                ]
            }
            Part::Distance { between, length } => {
                let [[ax, ay], [bx, by]] = between.map(|at| pose.point(at));
                let (x, y) = (bx - ax, by - ay);
                vec![(x * x + y * y).sqrt() - number(length)]
            }
            Part::Gear { between: [a, b], carrier, ratio, angle } => {
                let [a, b, c] = [a, b, carrier].map(|body| pose.angle(body));
                vec![b - c - number(ratio) * (a - c) - number(angle)]
            }
            Part::Rack { pinion, slide, axis, radius, displacement } => {
                let turn = pose.angle(pinion) - pose.angle(slide[0].body);
                vec![pose.along(slide, axis) - number(radius) * turn - number(displacement)]
            }
        }
    }
}

/// A classical system with further joints.
pub struct Extended {
    pub system: System,
    pub parts: Vec<Part>,
}

/// Accelerations and multipliers: those of `system`'s joints first, then of the parts.
pub struct Loads {
    pub acceleration: DVector<f64>,
    pub joints: Vec<f64>,
    pub parts: Vec<Vec<f64>>,
}

impl Extended {
    /// Residual, Jacobian and right-hand side J a = gamma.
    pub fn constraints(&self, state: &State) -> (DVector<f64>, DMatrix<f64>, DVector<f64>) {
        let classical = self.system.constraints(state, 0.0);
        let residuals = |along: &DVector<f64>| -> Vec<Jet> {
            let pose = Pose { q: &state.q, along };
            self.parts.iter().flat_map(|part| part.residuals(&pose)).collect()
        };
        let columns = state.q.len();
        let moving = residuals(&state.v);
        let (before, rows) = (classical.gamma.len(), moving.len());
        let mut residual = classical.residual.resize_vertically(before + rows, 0.0);
        let mut jacobian = classical.jacobian.resize_vertically(before + rows, 0.0);
        let mut gamma = classical.gamma.resize_vertically(before + rows, 0.0);
        for (row, jet) in moving.iter().enumerate() {
            residual[before + row] = jet.0[0];
            gamma[before + row] = -jet.0[2];
        }
        for column in 0..columns {
            let unit = DVector::from_fn(columns, |i, _| f64::from(u8::from(i == column)));
            for (row, jet) in residuals(&unit).iter().enumerate() {
                jacobian[(before + row, column)] = jet.0[1];
            }
        }
        (residual, jacobian, gamma)
    }

    /// s and theta of a slot or rolling disc, each with its rate and acceleration.
    pub fn motion(&self, part: &Part, state: &State, acceleration: &DVector<f64>) -> Option<[[f64; 3]; 2]> {
        let (Part::Slot { between, axis } | Part::Rolling { between, axis, .. }) = *part else { return None };
        let at = |along| {
            let pose = Pose { q: &state.q, along };
            let [a, b] = between.map(|at| pose.angle(at.body));
            [pose.along(between, axis), b - a]
        };
        let (moving, pushed) = (at(&state.v), at(acceleration));
        Some([0, 1].map(|i| [moving[i].0[0], moving[i].0[1], moving[i].0[2] + pushed[i].0[1]]))
    }

    /// The velocity nearest to that of the state which all joints permit.
    pub fn permitted_velocity(&self, state: &State) -> DVector<f64> {
        let (_, jacobian, _) = self.constraints(state);
        let svd = jacobian.clone().svd(true, true);
        let correct = |v: DVector<f64>| &v - svd.solve(&(&jacobian * &v), 1e-11).expect("both factors were asked for");
        correct(correct(state.v.clone()))
    }

    /// M a + J^T lambda = Q, J a = gamma; all constraints must be independent.
    pub fn solve(&self, state: &State) -> Loads {
        let (_, jacobian, gamma) = self.constraints(state);
        let (n, m) = (state.q.len(), gamma.len());
        let mut matrix = DMatrix::zeros(n + m, n + m);
        matrix.view_mut((0, 0), (n, n)).set_diagonal(&self.system.masses());
        matrix.view_mut((n, 0), (m, n)).copy_from(&jacobian);
        matrix.view_mut((0, n), (n, m)).copy_from(&jacobian.transpose());
        let mut right = self.system.applied(state).resize_vertically(n + m, 0.0);
        right.rows_mut(n, m).copy_from(&gamma);
        let solution = matrix.lu().solve(&right).expect("the constraints are independent");
        let mut multipliers = solution.iter().skip(n).map(|lambda| -lambda);
        let classical = self.system.constraints(state, 0.0).gamma.len();
        let joints = multipliers.by_ref().take(classical).collect();
        let pose = Pose { q: &state.q, along: &state.v };
        let parts = self.parts.iter().map(|part| multipliers.by_ref().take(part.residuals(&pose).len()).collect());
        Loads { acceleration: solution.rows(0, n).into_owned(), joints, parts: parts.collect() }
    }
}
