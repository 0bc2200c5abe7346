//! A four-bar at rest whose four pins rub by the forces that they carry: which of them hold it depends on the torque on its crank.

/// The scene with a torque on the crank [N.m].
pub fn linkage(torque: f64) -> String {
    let pin = |name: &str, between: [&str; 2], radius: u32| {
        format!(
            "[joints.{name}]\ntype = \"revolute\"\nbetween = {between:?}\nfriction = {{ mu = 0.4, radius = \"{radius} mm\" }}\n"
        )
    };
    let pins = [
        pin("pin1", ["ground", "crank.a"], 40),
        pin("pin2", ["crank.b", "coupler.a"], 30),
        pin("pin3", ["coupler.b", "rocker.b"], 35),
        pin("pin4", ["ground.right", "rocker.a"], 25),
    ];
    format!(
        r#"
name = "linkage"
gravity = [0, -9.81]
[ground.points]
right = [0.6, 0]
[bodies.crank]
mass = 1.0
inertia = 0.01
points = {{ a = [-0.15, 0], b = [0.15, 0] }}
[bodies.coupler]
mass = 1.5
inertia = 0.04
points = {{ a = [-0.3, 0], b = [0.3, 0] }}
[bodies.rocker]
mass = 1.2
inertia = 0.03
points = {{ a = [-0.25, 0], b = [0.25, 0] }}
{}
[loads.motor]
type = "torque"
on = "crank"
value = {torque:?}
[initial]
"crank.angle" = "50 deg"
"crank.omega" = 0.0
"coupler.angle" = {{ guess = "15 deg" }}
"rocker.angle" = {{ guess = "75 deg" }}
[outputs]
variables = ["crank.angle", "crank.alpha"]
[experiment]
stop = 0.5
tolerance = 1e-9
"#,
        pins.concat()
    )
}
