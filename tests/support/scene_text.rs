//! A system as a scene file, every number in full precision and every initial value known.

use super::absolute::{At, Driver, Joint, JointKind, Load, State, System};
use super::variables::{Variables, owner, points};
use nalgebra::Vector2;
use std::fmt::Write;

/// The scene whose outputs are all of `variables`, starting in `state`.
pub fn scene_text(name: &str, system: &System, state: &State, variables: &Variables) -> String {
    let mut text = format!("format = 1\nname = \"{name}\"\ngravity = {}\n", pair(system.gravity));
    write_points(&mut text, "ground", system, None);
    for (i, body) in system.bodies.iter().enumerate() {
        let _ = write!(text, "\n[bodies.b{i}]\nmass = {:?}\ninertia = {:?}\n", body.mass, body.inertia);
        write_points(&mut text, &format!("bodies.b{i}"), system, Some(i));
    }
    for (i, joint) in system.joints.iter().enumerate() {
        let _ = write!(text, "\n[joints.j{i}]\n{}", joint_text(i, joint));
    }
    for (i, driver) in system.drivers.iter().enumerate() {
        let _ = write!(text, "\n[drivers.d{i}]\n{}", driver_text(i, driver));
    }
    for (i, load) in system.loads.iter().enumerate() {
        let _ = write!(text, "\n[loads.l{i}]\n{}", load_text(i, load));
    }
    text.push_str("\n[initial]\n");
    for (i, body) in state.q.as_slice().chunks(3).zip(state.v.as_slice().chunks(3)).enumerate() {
        for (quantity, value) in ["x", "y", "angle", "vx", "vy", "omega"].iter().zip(body.0.iter().chain(body.1)) {
            let _ = writeln!(text, "\"b{i}.{quantity}\" = {value:?}");
        }
    }
    let names: Vec<_> = variables.keys().map(|name| format!("\"{name}\"")).collect();
    let _ = write!(text, "\n[outputs]\nvariables = [\n  {},\n]\n", names.join(",\n  "));
    text.push_str("\n[experiment]\nstop = 0.1\nstep = 0.01\ntolerance = 1e-9\n");
    text
}

fn pair(v: Vector2<f64>) -> String {
    format!("[{:?}, {:?}]", v.x, v.y)
}

fn write_points(text: &mut String, table: &str, system: &System, body: Option<usize>) {
    let own: Vec<_> = points(system).into_iter().filter(|(_, at)| at.body == body).collect();
    if !own.is_empty() {
        let _ = write!(text, "\n[{table}.points]\n");
    }
    for (name, at) in own {
        let _ = writeln!(text, "{name} = {}", pair(at.local));
    }
}

/// `between = ["ground.j0a", "b2.j0b"]`
fn between_points(element: &str, between: [At; 2]) -> String {
    let [a, b] = between.map(|at| owner(at.body));
    format!("between = [\"{a}.{element}a\", \"{b}.{element}b\"]\n")
}

fn between_bodies(between: [Option<usize>; 2]) -> String {
    let [a, b] = between.map(owner);
    format!("between = [\"{a}\", \"{b}\"]\n")
}

fn joint_text(i: usize, joint: &Joint) -> String {
    let between = between_points(&format!("j{i}"), joint.between);
    let damping = format!("damping = {:?}\n", joint.damping);
    match joint.kind {
        JointKind::Revolute => format!("type = \"revolute\"\n{between}{damping}"),
        JointKind::Weld { angle } => format!("type = \"weld\"\n{between}angle = {angle:?}\n"),
        JointKind::Prismatic { axis, angle } => {
            format!("type = \"prismatic\"\n{between}axis = {}\nangle = {angle:?}\n{damping}", pair(axis))
        }
    }
}

/// Value, rate and acceleration at time zero as an expression.
fn motion_text([p, v, a]: [f64; 3]) -> String {
    format!("\"({p:?}) + ({v:?})*t + ({:?})*t^2\"", a / 2.0)
}

fn driver_text(i: usize, driver: &Driver) -> String {
    match *driver {
        Driver::Angle { between, motion } => format!("{}angle = {}\n", between_bodies(between), motion_text(motion)),
        Driver::Displacement { joint, motion } => {
            format!("joint = \"j{joint}\"\ndisplacement = {}\n", motion_text(motion))
        }
        Driver::Position { on, motion } => {
            let [x, y] = [0, 1].map(|c| motion_text(motion.map(|m| m[c])));
            format!("on = \"{}.d{i}\"\nposition = [{x}, {y}]\n", owner(on.body))
        }
    }
}

fn load_text(i: usize, load: &Load) -> String {
    match *load {
        Load::Force { on, vector, in_body } => {
            let frame = if in_body { "body" } else { "world" };
            format!(
                "type = \"force\"\non = \"{}.l{i}\"\nvector = {}\nframe = \"{frame}\"\n",
                owner(on.body),
                pair(vector)
            )
        }
        Load::Torque { between, value } => format!("type = \"torque\"\n{}value = {value:?}\n", between_bodies(between)),
        Load::Spring { between, stiffness, length, damping } => format!(
            "type = \"spring\"\n{}stiffness = {stiffness:?}\nlength = {length:?}\ndamping = {damping:?}\n",
            between_points(&format!("l{i}"), between)
        ),
        Load::TorsionSpring { between, stiffness, angle, damping } => format!(
            "type = \"torsion_spring\"\n{}stiffness = {stiffness:?}\nangle = {angle:?}\ndamping = {damping:?}\n",
            between_bodies(between)
        ),
    }
}
