//! A four-bar at rest whose four pins rub by the forces that they carry: which of them hold it depends on the torque on its crank.

/// The scene with a torque on the crank [N.m].
pub fn linkage(torque: f64) -> String {
    let rubs = [40, 30, 35, 25].map(|radius| format!("friction = {{ mu = 0.4, radius = \"{radius} mm\" }}\n"));
    let load = format!("[loads.motor]\ntype = \"torque\"\non = \"crank\"\nvalue = {torque:?}\n");
    let rest =
        "[outputs]\nvariables = [\"crank.angle\", \"crank.alpha\"]\n[experiment]\nstop = 0.5\ntolerance = 1e-9\n";
    four_bar(&rubs, 0.04, "\"crank.angle\" = \"50 deg\"\n\"crank.omega\" = 0.0\n", &format!("{load}{rest}"))
}

/// A four-bar with further keys of its pins, an inertia of its coupler, what its crank begins with, and the tables that follow.
pub fn four_bar(pins: &[String; 4], inertia: f64, crank: &str, rest: &str) -> String {
    let pin = |index: usize, between: [&str; 2]| {
        format!("[joints.pin{}]\ntype = \"revolute\"\nbetween = {between:?}\n{}", index + 1, pins[index])
    };
    let pins = [
        pin(0, ["ground", "crank.a"]),
        pin(1, ["crank.b", "coupler.a"]),
        pin(2, ["coupler.b", "rocker.b"]),
        pin(3, ["ground.right", "rocker.a"]),
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
inertia = {inertia}
points = {{ a = [-0.3, 0], b = [0.3, 0] }}
[bodies.rocker]
mass = 1.2
inertia = 0.03
points = {{ a = [-0.25, 0], b = [0.25, 0] }}
{}
[initial]
{crank}"coupler.angle" = {{ guess = "15 deg" }}
"rocker.angle" = {{ guess = "75 deg" }}
{rest}"#,
        pins.concat()
    )
}
