//! A driven four-bar.

use super::*;

/// What turns the crank of the four-bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    Time,
    Position,
    Velocity,
    Acceleration,
}

/// Lengths of the four-bar: crank, coupler, rocker, ground.
pub const FOUR_BAR: [f64; 4] = [1.0, 3.0, 2.5, 3.5];
/// Moment of inertia of its rocker.
pub const ROCKER: f64 = 0.7;
/// Speed of its crank if driven by time.
pub const SPEED: f64 = 2.0;

/// A four-bar with a driven crank: coupler and rocker angles, two loop equations. The rocker has an inertia and a load torque;
/// the driver's torque follows from the reactions. With `redundant`, a copy of the first equation is listed as inactive.
pub fn four_bar(drive: Drive, redundant: bool) -> Program {
    let mut program = empty("four_bar");
    program.parameters = vec![parameter("ground_length", FOUR_BAR[3], true)];
    program.inputs = vec![input("load", 0.0), input("crank_drive", 0.0)];
    program.coordinates = vec![coordinate("coupler.angle"), coordinate("rocker.angle")];
    program.constraints = vec![constraint("rocker_pin"), constraint("rocker_pin")];
    if redundant {
        program.constraints.push(Constraint { role: Role::LeftOut, ..constraint("spare_pin") });
    }
    let order = match drive {
        Drive::Velocity => Some(FollowerOrder::Velocity),
        Drive::Acceleration => Some(FollowerOrder::Acceleration),
        Drive::Time | Drive::Position => None,
    };
    program.followers.extend(order.map(|order| Follower { name: "motor".into(), input: 1, order, scale: 1.0 }));
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let register = |place: usize| place as u32;
    let [q, v] = [layout.positions(), layout.rates()].map(register);
    let ground = register(layout.parameters());
    let [crank, coupler, rocker] = [0, 1, 2].map(|index| w.constant(FOUR_BAR[index]));
    let [speed, zero, inertia] = [SPEED, 0.0, ROCKER].map(|value| w.constant(value));

    // Angle of the crank, its rate and its acceleration.
    let driven = |w: &mut Writer| match drive {
        Drive::Time => [w.mul(speed, 0), speed, zero],
        Drive::Position => {
            [layout.inputs(), layout.input_rates(), layout.input_accelerations()].map(|place| register(place) + 1)
        }
        Drive::Velocity | Drive::Acceleration => {
            [layout.followers(), layout.follower_rates(), layout.follower_accelerations()].map(register)
        }
    };
    // (sine, cosine) times length of the three moving bars.
    let bars = |w: &mut Writer, angle: u32| {
        [(crank, angle), (coupler, q), (rocker, q + 1)].map(|(length, angle)| {
            let [sine, cosine] = w.sin_cos(angle);
            [w.mul(length, sine), w.mul(length, cosine)]
        })
    };
    let extend = |mut rows: Vec<u32>| {
        if redundant {
            rows.push(rows[0]);
        }
        rows
    };

    // Phi_q, then the loop equations.
    let position = |w: &mut Writer| {
        let [angle, _, _] = driven(w);
        let [[s1, c1], [s2, c2], [s3, c3]] = bars(w, angle);
        let x = w.add(c1, c2);
        let x = w.sub(x, c3);
        let x = w.sub(x, ground);
        let y = w.add(s1, s2);
        let y = w.sub(y, s3);
        (vec![vec![w.neg(s2), s3], vec![c2, w.neg(c3)]], [x, y])
    };
    // What closes the loops to first order.
    let closing = |w: &mut Writer, matrix: Vec<Vec<u32>>, [x, y]: [u32; 2]| {
        let minus = vec![w.neg(x), w.neg(y)];
        let corrections = w.solve(matrix, minus);
        w.tape([extend(vec![x, y]), corrections].concat())
    };
    let (_, [x, y]) = position(&mut w);
    program.tapes.constraint = w.tape(extend(vec![x, y]));
    let (matrix, gap) = position(&mut w);
    program.tapes.project_position = closing(&mut w, matrix, gap);

    let [angle, _, _] = driven(&mut w);
    let [[s1, c1], [s2, c2], [s3, c3]] = bars(&mut w, angle);
    let (minus_s1, minus_s2, minus_c3) = (w.neg(s1), w.neg(s2), w.neg(c3));
    let mut entries = vec![(0, 0), (0, 1), (1, 0), (1, 1)];
    let mut results = vec![minus_s2, s3, c2, minus_c3];
    if order.is_some() {
        entries.extend([(0, 2), (1, 2)]);
        results.extend([minus_s1, c1]);
    }
    if redundant {
        entries.extend([(2, 0), (2, 1)]);
        results.extend([minus_s2, s3]);
        if order.is_some() {
            entries.push((2, 2));
            results.push(minus_s1);
        }
    }
    program.tapes.jacobian = SparseTape { entries, tape: w.tape(results) };

    let rate = |w: &mut Writer| {
        let [angle, omega, _] = driven(w);
        let [[s1, c1], [s2, c2], [s3, c3]] = bars(w, angle);
        let x = w.dot(&[(s1, omega), (s2, v)]);
        let third = w.mul(s3, v + 1);
        let x = w.sub(third, x);
        let y = w.dot(&[(c1, omega), (c2, v)]);
        let third = w.mul(c3, v + 1);
        [x, w.sub(y, third)]
    };
    let gap = rate(&mut w);
    program.tapes.constraint_rate = w.tape(extend(gap.to_vec()));
    let (matrix, _) = position(&mut w);
    let gap = rate(&mut w);
    program.tapes.project_velocity = closing(&mut w, matrix, gap);

    let gamma = |w: &mut Writer| {
        let [angle, omega, alpha] = driven(w);
        let [[s1, c1], [s2, c2], [s3, c3]] = bars(w, angle);
        let squares = [w.mul(omega, omega), w.mul(v, v), w.mul(v + 1, v + 1)];
        let x = w.dot(&[(s1, alpha), (c1, squares[0]), (c2, squares[1])]);
        let third = w.mul(c3, squares[2]);
        let x = w.sub(x, third);
        let y = w.dot(&[(s1, squares[0]), (s2, squares[1])]);
        let third = w.mul(s3, squares[2]);
        let y = w.sub(y, third);
        let tangential = w.mul(c1, alpha);
        vec![x, w.sub(y, tangential)]
    };
    let right = gamma(&mut w);
    program.tapes.gamma = w.tape(extend(right));

    let (matrix, _) = position(&mut w);
    let right = gamma(&mut w);
    let mut solved = w.solve(matrix.clone(), right);
    let inertial = w.mul(inertia, solved[1]);
    let moment = w.sub(register(layout.inputs()), inertial);
    let transposed = (0..2).map(|column| vec![matrix[0][column], matrix[1][column]]).collect();
    solved.extend(w.solve(transposed, vec![zero, moment]));
    solved.extend(redundant.then_some(zero));
    program.tapes.acceleration = w.tape(solved);

    let [angle, omega, _] = driven(&mut w);
    let [[s1, c1], _, _] = bars(&mut w, angle);
    let lambda = register(layout.reactions());
    let first = w.mul(s1, lambda);
    let second = w.mul(c1, lambda + 1);
    let torque = w.sub(second, first);
    program.tapes.outputs = w.tape(vec![angle, omega, torque]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("ground_length", Source::Parameter(0)),
        variable("load", Source::Input(0)),
        variable("crank_drive", Source::Input(1)),
        variable("coupler.angle", Source::Coordinate(0)),
        variable("rocker.angle", Source::Coordinate(1)),
        variable("coupler.omega", Source::Rate(0)),
        variable("rocker.omega", Source::Rate(1)),
        variable("rocker.alpha", Source::Acceleration(1)),
        variable("crank.angle", output(0, false)),
        variable("crank.omega", output(1, false)),
        variable("motor.torque", output(2, true)),
    ];
    let mut positions =
        vec![(condition("coupler.angle", false), q, 0.6), (condition("rocker.angle", false), q + 1, 1.2)];
    if order.is_some() {
        positions.push((condition("crank.angle", true), register(layout.followers()), 0.1));
    }
    let initial = &mut program.initial;
    let column = |r: u32| if r >= q { r - q } else { 2 };
    (initial.positions, initial.position, initial.position_jacobian) = conditions(&mut w, &positions, column);
    w.finish(program)
}
