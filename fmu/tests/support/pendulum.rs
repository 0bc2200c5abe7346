//! A pendulum.

use super::*;

/// A mathematical pendulum of 1 kg: angle'' = -gravity / length sin(angle) + torque / length^2, from 1 rad at rest.
pub fn pendulum() -> Program {
    let mut program = empty("pendulum");
    program.parameters = vec![parameter("gravity", 9.81, true), parameter("length", 1.0, false)];
    program.parameters[1].min = Some(0.1);
    program.inputs = vec![input("torque", 0.0)];
    program.inputs[0].max = Some(100.0);
    program.coordinates = vec![coordinate("arm.angle")];
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let [gravity, length] = [layout.parameters() as u32, layout.parameters() as u32 + 1];
    let [torque, q, v, a] =
        [layout.inputs(), layout.positions(), layout.rates(), layout.accelerations()].map(|place| place as u32);

    let stiffness = w.div(gravity, length);
    let inertia = w.mul(length, length);
    program.tapes.parameters = w.tape(vec![]);

    let [sine, _] = w.sin_cos(q);
    let restoring = w.mul(stiffness, sine);
    let drive = w.div(torque, inertia);
    let acceleration = w.sub(drive, restoring);
    program.tapes.acceleration = w.tape(vec![acceleration]);

    let [_, cosine] = w.sin_cos(q);
    let half = w.constant(0.5);
    let square = w.mul(v, v);
    let kinetic = w.dot(&[(half, square)]);
    let potential = w.mul(stiffness, cosine);
    let energy = w.sub(kinetic, potential);
    let tangential = w.mul(a, length);
    program.tapes.outputs = w.tape(vec![energy, tangential]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("gravity", Source::Parameter(0)),
        variable("length", Source::Parameter(1)),
        variable("torque", Source::Input(0)),
        variable("arm.angle", Source::Coordinate(0)),
        variable("arm.omega", Source::Rate(0)),
        variable("arm.alpha", Source::Acceleration(0)),
        variable("energy", output(0, false)),
        variable("tangential", output(1, true)),
    ];
    let (list, tape, jacobian) = conditions(&mut w, &[(condition("arm.angle", true), q, 1.0)], |_| 0);
    (program.initial.positions, program.initial.position, program.initial.position_jacobian) = (list, tape, jacobian);
    w.finish(program)
}
