//! The slider-crank of the paper.

use super::*;

/// The slider-crank of McPhee (1998), Eqs. (48)-(62): two angles, one loop equation, no gravity; the force on the slider is an
/// input. The crank's length is a parameter.
pub fn slider_crank() -> Program {
    let mut program = empty("slider_crank");
    program.parameters = vec![parameter("crank_length", 0.5, true)];
    program.inputs = vec![input("force", 0.0)];
    program.coordinates = vec![coordinate("crank.angle"), coordinate("rod.angle")];
    program.constraints = vec![constraint("wrist_pin")];
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let [a, force, q, v] =
        [layout.parameters(), layout.inputs(), layout.positions(), layout.rates()].map(|place| place as u32);
    let [b, i1, m1, i2, m2, m3, l7] = [1.5, 0.04, 2.0, 0.6, 3.0, 1.0, 0.75].map(|value| w.constant(value));
    let zero = w.constant(0.0);
    let half = w.constant(0.5);

    let square = w.mul(a, a);
    let quarter = {
        let l5 = w.mul(half, a);
        w.mul(l5, l5)
    };
    let m23 = w.add(m2, m3);
    let m11 = w.dot(&[(m1, quarter), (m23, square)]);
    let m11 = w.add(i1, m11);
    let (l7_square, b_square) = (w.mul(l7, l7), w.mul(b, b));
    let m22 = w.dot(&[(m2, l7_square), (m3, b_square)]);
    let m22 = w.add(i2, m22);
    let coupling = w.dot(&[(m2, l7), (m3, b)]);
    let coupling = w.mul(coupling, a);
    program.tapes.parameters = w.tape(vec![]);

    struct Pose {
        phi: u32,
        phi_q: [u32; 2],
        m12: u32,
        cosine: u32,
        gradient: [u32; 2],
    }
    let pose = |w: &mut Writer| {
        let ([s1, c1], [s2, c2]) = (w.sin_cos(q), w.sin_cos(q + 1));
        let phi = w.dot(&[(a, s1), (b, c2)]);
        let j1 = w.mul(a, c1);
        let j2 = w.mul(b, s2);
        let j2 = w.neg(j2);
        let first = w.mul(s1, c2);
        let second = w.mul(c1, s2);
        let sine = w.sub(first, second);
        let m12 = w.mul(coupling, sine);
        let cosine = w.dot(&[(c1, c2), (s1, s2)]);
        let g1 = w.mul(a, s1);
        let g2 = w.mul(b, c2);
        Pose { phi, phi_q: [j1, j2], m12, cosine, gradient: [g1, g2] }
    };
    let system = |p: &Pose| {
        let [j1, j2] = p.phi_q;
        vec![vec![m11, p.m12, j1], vec![p.m12, m22, j2], vec![j1, j2, zero]]
    };

    let p = pose(&mut w);
    program.tapes.constraint = w.tape(vec![p.phi]);
    let p = pose(&mut w);
    program.tapes.jacobian = SparseTape { entries: vec![(0, 0), (0, 1)], tape: w.tape(p.phi_q.to_vec()) };
    let p = pose(&mut w);
    let rate = w.dot(&[(p.phi_q[0], v), (p.phi_q[1], v + 1)]);
    program.tapes.constraint_rate = w.tape(vec![rate]);

    let gamma = |w: &mut Writer, p: &Pose| {
        let (w1, w2) = (w.mul(v, v), w.mul(v + 1, v + 1));
        let gamma = w.dot(&[(p.gradient[0], w1), (p.gradient[1], w2)]);
        (gamma, w1, w2)
    };
    let p = pose(&mut w);
    let (g, _, _) = gamma(&mut w, &p);
    program.tapes.gamma = w.tape(vec![g]);

    let p = pose(&mut w);
    let (g, w1, w2) = gamma(&mut w, &p);
    let k = w.mul(coupling, p.cosine);
    let q1 = w.mul(k, w2);
    let q2 = w.mul(k, w1);
    let f1 = w.mul(force, p.gradient[0]);
    let f2 = w.mul(force, p.gradient[1]);
    let q1 = w.sub(q1, f1);
    let q2 = w.neg(q2);
    let q2 = w.sub(q2, f2);
    let solution = w.solve(system(&p), vec![q1, q2, g]);
    program.tapes.acceleration = w.tape(solution);

    let p = pose(&mut w);
    let right = w.neg(p.phi);
    let solution = w.solve(system(&p), vec![zero, zero, right]);
    program.tapes.project_position = w.tape(vec![p.phi, solution[0], solution[1]]);
    let p = pose(&mut w);
    let rate = w.dot(&[(p.phi_q[0], v), (p.phi_q[1], v + 1)]);
    let right = w.neg(rate);
    let solution = w.solve(system(&p), vec![zero, zero, right]);
    program.tapes.project_velocity = w.tape(vec![rate, solution[0], solution[1]]);

    let p = pose(&mut w);
    let [w1, w2, w12] = [w.mul(v, v), w.mul(v + 1, v + 1), w.mul(v, v + 1)];
    let (t1, t2, t12) = (w.mul(m11, w1), w.mul(m22, w2), w.mul(p.m12, w12));
    let diagonal = w.add(t1, t2);
    let kinetic = w.dot(&[(half, diagonal)]);
    let kinetic = w.add(kinetic, t12);
    let ([_, c1], [s2, _]) = (w.sin_cos(q), w.sin_cos(q + 1));
    let crank = w.mul(a, c1);
    let rod = w.mul(b, s2);
    let slider = w.sub(crank, rod);
    program.tapes.outputs = w.tape(vec![kinetic, slider, p.phi, layout.reactions() as u32]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("crank_length", Source::Parameter(0)),
        variable("force", Source::Input(0)),
        variable("crank.angle", Source::Coordinate(0)),
        variable("rod.angle", Source::Coordinate(1)),
        variable("crank.omega", Source::Rate(0)),
        variable("rod.omega", Source::Rate(1)),
        variable("energy.kinetic", output(0, false)),
        variable("slider.x", output(1, false)),
        variable("constraint.position", output(2, false)),
        variable("cylinder.fn", output(3, true)),
        variable("crank.alpha", Source::Acceleration(0)),
    ];
    let positions = [(condition("crank.angle", true), q, 0.6), (condition("rod.angle", false), q + 1, -1.5)];
    let initial = &mut program.initial;
    (initial.positions, initial.position, initial.position_jacobian) =
        conditions(&mut w, &positions, |register| register - q);
    (initial.velocities, initial.velocity, initial.velocity_jacobian) =
        conditions(&mut w, &[(condition("crank.omega", true), v, 4.0)], |register| register - v);
    w.finish(program)
}
