//! Mechanisms with parts that hold on one side only, in absolute coordinates (x, y, angle of every body): steps of a Runge-Kutta method of fifth order that end where a gap closes or a reaction falls
//! to zero, impacts and modes by trying all sets.
//!
//! It shares no code and no idea with the product: no trees, no masks, no series.

type Pair = [f64; 2];

/// A point of a body, from its mass centre in its axes, or of the ground.
#[derive(Clone, Copy, Debug)]
pub struct At(pub Option<usize>, pub Pair);

/// A scalar function of the coordinates.
#[derive(Clone, Debug)]
pub enum Shape {
    /// The component of the way from the first point to the second along a direction of the first one's body.
    Along([At; 2], Pair),
    /// The distance of two points.
    Length([At; 2]),
    /// A sum of angles.
    Angle(Vec<(usize, f64)>),
    /// The second point's way in the direction of the first body's axis less a factor times an angle.
    Slide([At; 2], Pair, (usize, f64)),
    /// How high a follower, which moves along y, is over its cam: over base + lift (1 - cos angle)/2.
    Cam { cam: usize, follower: usize, base: f64, lift: f64 },
}

/// What is held on one side: its value is never negative. One of rates is held where it stands while it is closed.
#[derive(Clone, Debug)]
pub struct OneSided {
    pub shape: Shape,
    pub sign: f64,
    pub bound: f64,
    pub restitution: f64,
    /// Of a freewheel: the rate is what is never negative.
    pub of_rate: bool,
}

/// What always holds: its value is zero.
#[derive(Clone, Debug)]
pub struct Always {
    pub shape: Shape,
    pub bound: f64,
}

/// A torque on a body, as a function of time and of all coordinates and rates.
pub type Torque = fn(f64, &[f64], &[f64]) -> f64;

#[derive(Clone, Debug, Default)]
pub struct World {
    /// Mass and inertia.
    pub bodies: Vec<Pair>,
    pub gravity: f64,
    pub always: Vec<Always>,
    pub one_sided: Vec<OneSided>,
    /// Body, torque.
    pub torques: Vec<(usize, Torque)>,
    /// A force along y on a body.
    pub lifts: Vec<(usize, Torque)>,
    /// A constant torque on the second body from the first, or from the ground, and a damping of its rate against that.
    pub dampings: Vec<([Option<usize>; 2], Pair)>,
    /// How often the steps are halved.
    pub halvings: i32,
}

#[derive(Clone, Debug)]
pub struct Motion {
    pub time: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub closed: Vec<bool>,
    pub impacts: usize,
}

/// A value with its gradient, and its second derivative without accelerations.
struct Row {
    value: f64,
    gradient: Vec<f64>,
    curved: f64,
}

/// A flight shorter than this ends a series of bounces \[s\].
const SHORTEST: f64 = 1e-7;
const STEP: f64 = 2e-3;
const MOST_EVENTS: usize = 1000;

fn add(a: Pair, b: Pair) -> Pair {
    [a[0] + b[0], a[1] + b[1]]
}
fn less(a: Pair, b: Pair) -> Pair {
    [a[0] - b[0], a[1] - b[1]]
}
fn times(s: f64, a: Pair) -> Pair {
    [s * a[0], s * a[1]]
}
fn dot(a: Pair, b: Pair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn left(a: Pair) -> Pair {
    [-a[1], a[0]]
}

/// What a linear system solves; none if it is singular.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))?;
        if rows[pivot][column].abs() < 1e-12 {
            return None;
        }
        rows.swap(column, pivot);
        let (upper, lower) = rows.split_at_mut(column + 1);
        let top = &upper[column];
        for row in lower {
            let factor = row[column] / top[column];
            if factor != 0.0 {
                row[column..].iter_mut().zip(&top[column..]).for_each(|(entry, above)| *entry -= factor * above);
            }
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let sum: f64 = (row + 1..n).map(|column| rows[row][column] * x[column]).sum();
        x[row] = (rows[row][n] - sum) / rows[row][row];
    }
    Some(x)
}

impl World {
    fn masses(&self) -> Vec<f64> {
        self.bodies.iter().flat_map(|[mass, inertia]| [*mass, *mass, *inertia]).collect()
    }

    /// Place and arm of a point, its velocity, and its acceleration without those of the coordinates.
    fn point(&self, At(body, local): At, q: &[f64], v: &[f64]) -> [Pair; 4] {
        let Some(body) = body else { return [local, [0.0; 2], [0.0; 2], [0.0; 2]] };
        let (sine, cosine) = q[3 * body + 2].sin_cos();
        let arm = [cosine * local[0] - sine * local[1], sine * local[0] + cosine * local[1]];
        let omega = v[3 * body + 2];
        let place = add([q[3 * body], q[3 * body + 1]], arm);
        let velocity = add([v[3 * body], v[3 * body + 1]], times(omega, left(arm)));
        [place, arm, velocity, times(-omega * omega, arm)]
    }

    fn row(&self, shape: &Shape, q: &[f64], v: &[f64]) -> Row {
        let mut gradient = vec![0.0; q.len()];
        let mut put = |At(body, _): At, arm: Pair, direction: Pair| {
            if let Some(body) = body {
                gradient[3 * body] += direction[0];
                gradient[3 * body + 1] += direction[1];
                gradient[3 * body + 2] += dot(direction, left(arm));
            }
        };
        match shape {
            Shape::Along([a, b], axis) => {
                let ([pa, ra, va, ca], [pb, rb, vb, cb]) = (self.point(*a, q, v), self.point(*b, q, v));
                let (angle, omega) = a.0.map_or((0.0, 0.0), |body| (q[3 * body + 2], v[3 * body + 2]));
                let (sine, cosine) = angle.sin_cos();
                let w = [cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1]];
                let (d, rate, curved) = (less(pb, pa), less(vb, va), less(cb, ca));
                put(*b, rb, w);
                put(*a, ra, times(-1.0, w));
                if let Some(body) = a.0 {
                    gradient[3 * body + 2] += dot(left(w), d);
                }
                let curved = dot(w, curved) + 2.0 * omega * dot(left(w), rate) - omega * omega * dot(w, d);
                Row { value: dot(w, d), gradient, curved }
            }
            Shape::Length([a, b]) => {
                let ([pa, ra, va, ca], [pb, rb, vb, cb]) = (self.point(*a, q, v), self.point(*b, q, v));
                let (d, rate, curved) = (less(pb, pa), less(vb, va), less(cb, ca));
                let length = dot(d, d).sqrt();
                let e = times(1.0 / length, d);
                put(*b, rb, e);
                put(*a, ra, times(-1.0, e));
                let along = dot(e, rate);
                Row { value: length, gradient, curved: dot(e, curved) + (dot(rate, rate) - along * along) / length }
            }
            Shape::Angle(terms) => {
                terms.iter().for_each(|(body, factor)| gradient[3 * body + 2] += factor);
                let value = terms.iter().map(|(body, factor)| factor * q[3 * body + 2]).sum();
                Row { value, gradient, curved: 0.0 }
            }
            Shape::Slide(points, axis, (body, factor)) => {
                let mut row = self.row(&Shape::Along(*points, *axis), q, v);
                row.value -= factor * q[3 * body + 2];
                row.gradient[3 * body + 2] -= factor;
                row
            }
            Shape::Cam { cam, follower, base, lift } => {
                let (angle, omega) = (q[3 * cam + 2], v[3 * cam + 2]);
                gradient[3 * follower + 1] = 1.0;
                gradient[3 * cam + 2] = -0.5 * lift * angle.sin();
                let value = q[3 * follower + 1] - base - 0.5 * lift * (1.0 - angle.cos());
                Row { value, gradient, curved: -0.5 * lift * angle.cos() * omega * omega }
            }
        }
    }

    fn bound_row(&self, own: &OneSided, q: &[f64], v: &[f64]) -> Row {
        let row = self.row(&own.shape, q, v);
        Row {
            value: own.sign * (row.value - own.bound),
            gradient: row.gradient.iter().map(|entry| own.sign * entry).collect(),
            curved: own.sign * row.curved,
        }
    }

    fn rows(&self, q: &[f64], v: &[f64], closed: &[bool]) -> Vec<Row> {
        let always = self.always.iter().map(|own| {
            let row = self.row(&own.shape, q, v);
            Row { value: row.value - own.bound, ..row }
        });
        let one_sided = self.one_sided.iter().zip(closed).filter(|(_, closed)| **closed);
        // What holds a rate holds it where it stands.
        let held = |own: &OneSided| {
            let row = self.bound_row(own, q, v);
            Row { value: if own.of_rate { 0.0 } else { row.value }, ..row }
        };
        always.chain(one_sided.map(|(own, _)| held(own))).collect()
    }

    fn forces(&self, time: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; q.len()];
        for (body, [mass, _]) in self.bodies.iter().enumerate() {
            forces[3 * body + 1] -= mass * self.gravity;
        }
        self.torques.iter().for_each(|(body, torque)| forces[3 * body + 2] += torque(time, q, v));
        self.lifts.iter().for_each(|(body, force)| forces[3 * body + 1] += force(time, q, v));
        for ([first, second], [constant, damping]) in &self.dampings {
            let omega = |body: &Option<usize>| body.map_or(0.0, |body| v[3 * body + 2]);
            let torque = constant - damping * (omega(second) - omega(first));
            first.iter().for_each(|body| forces[3 * body + 2] -= torque);
            second.iter().for_each(|body| forces[3 * body + 2] += torque);
        }
        forces
    }

    /// M x + J^T y = right, J x = below: x, then -y.
    fn saddle(&self, rows: &[Row], right: &[f64], below: &[f64]) -> Option<Vec<f64>> {
        let (n, m, masses) = (right.len(), rows.len(), self.masses());
        let mut matrix = vec![vec![0.0; n + m + 1]; n + m];
        for i in 0..n {
            matrix[i][i] = masses[i];
            matrix[i][n + m] = right[i];
        }
        for (k, row) in rows.iter().enumerate() {
            for i in 0..n {
                matrix[i][n + k] = -row.gradient[i];
                matrix[n + k][i] = row.gradient[i];
            }
            matrix[n + k][n + m] = below[k];
        }
        solve(matrix)
    }

    /// Accelerations, then reactions: those of one-sided rows are positive where they press.
    fn accelerate(&self, time: f64, q: &[f64], v: &[f64], closed: &[bool]) -> Option<Vec<f64>> {
        let rows = self.rows(q, v, closed);
        let below: Vec<f64> = rows.iter().map(|row| -row.curved).collect();
        self.saddle(&rows, &self.forces(time, q, v), &below)
    }

    /// A step of the method of Dormand and Prince, and back onto what holds.
    fn stepped(&self, from: &Motion, h: f64) -> Motion {
        const A: [[f64; 5]; 5] = [
            [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0],
            [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
            [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0],
            [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0],
            [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        ];
        const B: [f64; 6] = [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
        const C: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
        let n = from.q.len();
        let mut slopes: Vec<Vec<f64>> = Vec::new();
        let at = |slopes: &[Vec<f64>], weights: &[f64]| {
            let along = |i: usize| slopes.iter().zip(weights).map(|(slope, weight)| weight * slope[i]).sum::<f64>();
            let q: Vec<f64> = (0..n).map(|i| from.q[i] + h * along(i)).collect();
            let v: Vec<f64> = (0..n).map(|i| from.v[i] + h * along(n + i)).collect();
            (q, v)
        };
        for stage in 0..6 {
            let (q, v) = if stage == 0 { (from.q.clone(), from.v.clone()) } else { at(&slopes, &A[stage - 1]) };
            let solved = self.accelerate(from.time + C[stage] * h, &q, &v, &from.closed).expect("no singular pose");
            slopes.push(v.iter().chain(&solved[..n]).copied().collect());
        }
        let (q, v) = at(&slopes, &B);
        let mut end = Motion { time: from.time + h, q, v, ..from.clone() };
        self.project(&mut end);
        end
    }

    fn project(&self, motion: &mut Motion) {
        let n = motion.q.len();
        for _ in 0..3 {
            let rows = self.rows(&motion.q, &motion.v, &motion.closed);
            let below: Vec<f64> = rows.iter().map(|row| -row.value).collect();
            let change = self.saddle(&rows, &vec![0.0; n], &below).expect("no singular pose");
            motion.q.iter_mut().zip(&change).for_each(|(q, change)| *q += change);
        }
        let rows = self.rows(&motion.q, &motion.v, &motion.closed);
        let below: Vec<f64> = rows.iter().map(|row| -rate(row, &motion.v)).collect();
        let change = self.saddle(&rows, &vec![0.0; n], &below).expect("no singular pose");
        motion.v.iter_mut().zip(&change).for_each(|(v, change)| *v += change);
    }

    /// What has to stay positive: rates of open freewheels, gaps of what else is open, reactions of what is closed.
    fn indicators(&self, motion: &Motion) -> Vec<f64> {
        let n = motion.q.len();
        let solved = self.accelerate(motion.time, &motion.q, &motion.v, &motion.closed).expect("no singular pose");
        let mut next = n + self.always.len();
        let of = |(index, own): (usize, &OneSided)| {
            if motion.closed[index] {
                next += 1;
                return solved[next - 1];
            }
            let row = self.bound_row(own, &motion.q, &motion.v);
            if own.of_rate { rate(&row, &motion.v) } else { row.value }
        };
        self.one_sided.iter().enumerate().map(of).collect()
    }

    fn gap_rates(&self, motion: &Motion) -> Vec<f64> {
        let rates = self.one_sided.iter().map(|own| rate(&self.bound_row(own, &motion.q, &motion.v), &motion.v));
        rates.collect()
    }

    /// The value of a function at a pose.
    pub fn start_value(&self, shape: &Shape, q: &[f64]) -> f64 {
        self.row(shape, q, &vec![0.0; q.len()]).value
    }

    /// Rates that keep what always holds, with the angular rates of the first bodies.
    pub fn consistent(&self, q: &[f64], v: &[f64], given: usize) -> Vec<f64> {
        let (n, always) = (q.len(), self.rows(q, v, &vec![false; self.one_sided.len()]));
        let mut matrix: Vec<Vec<f64>> =
            always.iter().map(|row| row.gradient.iter().copied().chain([0.0]).collect()).collect();
        for body in 0..given {
            let mut row = vec![0.0; n + 1];
            (row[3 * body + 2], row[n]) = (1.0, v[3 * body + 2]);
            matrix.push(row);
        }
        assert_eq!(matrix.len(), n, "as many rates as freedoms are given");
        solve(matrix).expect("no singular pose")
    }

    /// Starts from a pose on its loops; rates are put onto them.
    pub fn start(&self, q: Vec<f64>, v: Vec<f64>) -> Motion {
        let mut motion = Motion { time: 0.0, q, v, closed: vec![false; self.one_sided.len()], impacts: 0 };
        self.project(&mut motion);
        let free = vec![false; self.one_sided.len()];
        self.resolve(&mut motion, &free, &free);
        motion
    }

    /// Goes on to a time.
    pub fn go_to(&self, motion: &mut Motion, time: f64) {
        // Just after an event an indicator is zero but for rounding errors, and may not fall at once.
        let (mut floors, mut events) = (self.floors(motion), 0);
        while motion.time < time - 1e-13 {
            let h = (STEP * 0.5_f64.powi(self.halvings)).min(time - motion.time);
            let falls = |motion: &Motion, floors: &[f64]| -> Vec<bool> {
                self.indicators(motion).iter().zip(floors).map(|(now, floor)| now < floor).collect()
            };
            let end = self.stepped(motion, h);
            let mut to = falls(&end, &floors).contains(&true).then_some(h);
            if to.is_none() {
                to = self.dip(motion, &end, h, &floors);
            }
            let Some(to) = to else {
                let later = self.floors(&end);
                floors.iter_mut().zip(&later).filter(|(_, later)| **later == 0.0).for_each(|(floor, _)| *floor = 0.0);
                *motion = end;
                continue;
            };
            let [mut inside, mut outside] = [0.0, to];
            for _ in 0..46 {
                let middle = 0.5 * (inside + outside);
                let passed = falls(&self.stepped(motion, middle), &floors).contains(&true);
                *(if passed { &mut outside } else { &mut inside }) = middle;
            }
            let at = self.stepped(motion, outside);
            let due = falls(&at, &floors);
            let was = at.closed.clone();
            *motion = at;
            self.resolve(motion, &due, &was);
            events += 1;
            assert!(events < MOST_EVENTS, "events without end at {}", motion.time);
            floors = self.floors(motion);
        }
    }

    /// What may not be fallen below: zero, or a little less where something is zero but for rounding errors.
    fn floors(&self, motion: &Motion) -> Vec<f64> {
        let now = self.indicators(motion);
        let floor = |(index, now): (usize, &f64)| {
            let little = if motion.closed[index] { 1e-9 } else { 1e-13 };
            if *now > 10.0 * little { 0.0 } else { now.min(0.0) - little }
        };
        now.iter().enumerate().map(floor).collect()
    }

    /// Where a gap that is open at both ends of a step is not, between them.
    fn dip(&self, from: &Motion, end: &Motion, h: f64, floors: &[f64]) -> Option<f64> {
        let (before, after) = (self.gap_rates(from), self.gap_rates(end));
        for index in 0..before.len() {
            if from.closed[index] || floors[index] < 0.0 || self.one_sided[index].of_rate {
                continue;
            }
            if before[index] >= 0.0 || after[index] <= 0.0 {
                continue;
            }
            let [mut falling, mut rising] = [0.0, h];
            for _ in 0..40 {
                let middle = 0.5 * (falling + rising);
                let is_falling = self.gap_rates(&self.stepped(from, middle))[index] < 0.0;
                *(if is_falling { &mut falling } else { &mut rising }) = middle;
            }
            if self.indicators(&self.stepped(from, falling))[index] < 0.0 {
                return Some(falling);
            }
        }
        None
    }

    /// Impacts of what touches, then who stays closed. `due` says whose indicator has fallen, `was` who was closed.
    fn resolve(&self, motion: &mut Motion, due: &[bool], was: &[bool]) {
        let gaps: Vec<f64> = self.one_sided.iter().map(|own| self.bound_row(own, &motion.q, &motion.v).value).collect();
        let touches: Vec<bool> = (0..gaps.len())
            .map(|index| was[index] || due[index] || gaps[index] < 1e-11 || self.one_sided[index].of_rate)
            .collect();
        let rates = self.gap_rates(motion);
        let open = vec![false; gaps.len()];
        if (0..gaps.len()).any(|index| touches[index] && !was[index] && rates[index] < -1e-10) {
            motion.impacts += 1;
            let mut dead = open.clone();
            let before = motion.v.clone();
            self.collide(motion, &touches, &dead);
            let after = self.gap_rates(motion);
            motion.closed.copy_from_slice(was);
            let solved = self.accelerate(motion.time, &motion.q, &motion.v, was).expect("no singular pose");
            for index in (0..gaps.len()).filter(|&index| touches[index] && rates[index] < -1e-10) {
                let row = self.bound_row(&self.one_sided[index], &motion.q, &motion.v);
                let acceleration = rate(&row, &solved) + row.curved;
                dead[index] = acceleration < 0.0 && 2.0 * after[index] < SHORTEST * acceleration.abs();
            }
            if dead.contains(&true) {
                motion.v = before;
                self.collide(motion, &touches, &dead);
            }
        }
        let rates = self.gap_rates(motion);
        let concerned: Vec<usize> =
            (0..gaps.len()).filter(|&index| touches[index] && rates[index].abs() < 1e-9).collect();
        for trial in 0..1_usize << concerned.len() {
            motion.closed.clone_from(&open);
            for (place, &index) in concerned.iter().enumerate() {
                // First that what was closed and has fallen opens, and all else stays.
                let stays = was[index] != due[index] || !was[index] && due[index];
                motion.closed[index] = (trial >> place & 1 == 1) != stays;
            }
            if self.fits(motion, &concerned) {
                return;
            }
        }
        panic!("no mode fits at {}", motion.time);
    }

    fn fits(&self, motion: &Motion, concerned: &[usize]) -> bool {
        let Some(solved) = self.accelerate(motion.time, &motion.q, &motion.v, &motion.closed) else { return false };
        let mut next = motion.q.len() + self.always.len();
        for index in 0..self.one_sided.len() {
            if motion.closed[index] {
                next += 1;
                if solved[next - 1] < -1e-9 {
                    return false;
                }
            } else if concerned.contains(&index) {
                let row = self.bound_row(&self.one_sided[index], &motion.q, &motion.v);
                if rate(&row, &solved) + row.curved < -1e-9 {
                    return false;
                }
            }
        }
        true
    }

    /// 0 <= P, rate+ >= -e rate-, one of the two equal: the only set that fits.
    fn collide(&self, motion: &mut Motion, touches: &[bool], dead: &[bool]) {
        let concerned: Vec<usize> = (0..touches.len()).filter(|&index| touches[index]).collect();
        let before = self.gap_rates(motion);
        let wanted = |index: usize| {
            let share = if dead[index] { 0.0 } else { self.one_sided[index].restitution };
            if before[index] < 0.0 { -share * before[index] } else { 0.0 }
        };
        let n = motion.q.len();
        for trial in 0..1_usize << concerned.len() {
            let mut closed = vec![false; touches.len()];
            concerned.iter().enumerate().for_each(|(place, &index)| closed[index] = trial >> place & 1 == 1);
            let rows = self.rows(&motion.q, &motion.v, &closed);
            let always = self.always.len();
            let mut below = vec![0.0; always];
            below.extend((0..touches.len()).filter(|&index| closed[index]).map(|index| wanted(index) - before[index]));
            let Some(change) = self.saddle(&rows, &vec![0.0; n], &below) else { continue };
            if change[n + always..].iter().any(|impulse| *impulse < -1e-12) {
                continue;
            }
            let v: Vec<f64> = motion.v.iter().zip(&change).map(|(v, change)| v + change).collect();
            let after = self.gap_rates(&Motion { v: v.clone(), ..motion.clone() });
            if concerned.iter().all(|&index| closed[index] || after[index] >= wanted(index) - 1e-11) {
                motion.v = v;
                return;
            }
        }
        panic!("no impulses fit at {}", motion.time);
    }
}

fn rate(row: &Row, v: &[f64]) -> f64 {
    row.gradient.iter().zip(v).map(|(entry, v)| entry * v).sum()
}

/// The pose of a chain: coordinates of bodies, each at the end of the one before, or at an anchor.
pub fn chained(anchor: Pair, arms: &[[Pair; 2]], angles: &[f64]) -> (Vec<f64>, Pair) {
    let (mut at, mut q) = (anchor, Vec::new());
    for ([begin, end], angle) in arms.iter().zip(angles) {
        let (sine, cosine) = angle.sin_cos();
        let turn = |[x, y]: Pair| [cosine * x - sine * y, sine * x + cosine * y];
        let centre = less(at, turn(*begin));
        q.extend([centre[0], centre[1], *angle]);
        at = add(centre, turn(*end));
    }
    (q, at)
}
