//! Each component alone, against the motion and the loads that mechanics books give.

use crate::support::ROOT;
use crate::support::run;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Joint, Load, Scene, Side};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use run::{formulated, sound, value};

const G: f64 = 9.81;

/// A scene in motion.
struct Run(Instance);

impl Run {
    fn new(scene: &Scene) -> Run {
        let compiled = sound(compile(scene));
        assert!(compiled.warnings.is_none(), "{}", compiled.warnings.unwrap().render(false, 100));
        let mut instance = Instance::new(Arc::new(Model::new(compiled.program).unwrap()));
        instance.setup(0.0, None, Some(1e-10)).unwrap();
        instance.initialise().unwrap();
        Run(instance)
    }

    fn to(&mut self, time: f64) -> &mut Run {
        if time > self.0.time() {
            self.0.step_to(time).unwrap();
        }
        self
    }

    fn get(&mut self, name: &str) -> f64 {
        value(&mut self.0, name)
    }

    fn check(&mut self, name: &str, expected: f64) {
        let (value, time) = (self.get(name), self.0.time());
        assert!(
            (value - expected).abs() <= 1e-7 * (1.0 + expected.abs()),
            "{name} at {time} s: {value}, not {expected}"
        );
    }
}

fn file(name: &str) -> Scene {
    let folder = Path::new(ROOT).join("tests/scenes/components");
    sound(Scene::read(folder.join(format!("{name}.toml"))))
}

fn with_outputs(scene: Scene, names: &[&str]) -> Scene {
    names.iter().fold(scene, |scene, name| scene.output(name))
}

fn wheel(inertia: f64) -> Body {
    Body::new().mass(1.5).inertia(inertia)
}

#[test]
fn a_gear_pair_on_the_ground() {
    let (ia, ib, ratio, torque, phase) = (0.02, 0.3, -0.25, 4.0, 0.7);
    let scene = Scene::new("gears")
        .ground_point("b", [0.5, 0.0])
        .body("pinion", wheel(ia))
        .body("wheel", wheel(ib))
        .revolute("left", "ground", "pinion")
        .revolute("right", "ground.b", "wheel")
        .joint("mesh", Joint::gear("pinion", "wheel", ratio).angle(phase))
        .load("motor", Load::torque("ground", "pinion", torque))
        .initial("pinion.angle", 0.2)
        .initial("pinion.omega", 3.0);
    let alpha = torque / (ia + ratio * ratio * ib);
    let names = ["pinion.alpha", "pinion.omega", "wheel.angle", "wheel.omega", "mesh.torque"];
    let mut run = Run::new(&with_outputs(scene, &names));
    run.check("wheel.angle", phase + ratio * 0.2);
    for time in [0.1, 0.8] {
        run.to(time).check("pinion.alpha", alpha);
        run.check("pinion.omega", 3.0 + alpha * time);
        run.check("wheel.omega", ratio * (3.0 + alpha * time));
        run.check("wheel.angle", phase + ratio * (0.2 + 3.0 * time + alpha * time * time / 2.0));
        run.check("mesh.torque", ib * ratio * alpha);
    }
}

/// The sun is fixed to the ground, the arm is turned: the planet makes 1 + zs/zp turns for one of the arm.
#[test]
fn a_planet_on_an_arm() {
    let (length, arm, planet, mass, teeth, torque) = (0.4, 0.05, 0.01, 1.5, [30.0, 12.0], 2.0);
    let turns = 1.0 + teeth[0] / teeth[1];
    let scene = file("gear");
    let alpha = torque / (arm + mass * length * length + planet * turns * turns);
    let mut run = Run::new(&scene);
    for time in [0.0, 0.3, 1.0] {
        run.to(time).check("arm.alpha", alpha);
        run.check("arm.angle", alpha * time * time / 2.0);
        run.check("planet.angle", turns * alpha * time * time / 2.0);
        run.check("mesh.torque", planet * turns * alpha);
    }
}

#[test]
fn a_pinion_drives_a_rack() {
    let (inertia, mass, radius, torque) = (0.01, 2.0, 0.05, 1.2);
    let scene = file("rack");
    let alpha = torque / (inertia + mass * radius * radius);
    let mut run = Run::new(&scene);
    for time in [0.0, 0.4] {
        run.to(time).check("pinion.alpha", alpha);
        run.check("bar.x", 0.3 + radius * alpha * time * time / 2.0);
        run.check("mesh.force", mass * radius * alpha);
        run.check("mesh.torque", -radius * mass * radius * alpha);
        run.check("slide.torque", 0.0);
    }
}

#[test]
fn a_disc_rolls_down_a_slope() {
    let (slope, mass, radius) = (0.4_f64, 3.0, 0.2);
    let inertia = 0.5 * mass * radius * radius;
    let mut run = Run::new(&file("rolling"));
    let a = G * slope.sin() / 1.5;
    let energy = run.get("energy.total");
    for time in [0.0, 0.5, 1.5] {
        run.to(time).check("contact.a", a);
        run.check("contact.v", a * time);
        run.check("contact.s", 0.1 + a * time * time / 2.0);
        run.check("contact.angle", -a * time * time / 2.0 / radius);
        run.check("contact.fn", mass * G * slope.cos());
        run.check("contact.ft", -inertia * a / (radius * radius));
        run.check("energy.total", energy);
    }
}

/// A bead on a rod that turns steadily: r'' = omega^2 r, and the rod pushes with 2 m r' omega.
#[test]
fn a_bead_in_a_turning_slot() {
    let (omega, mass, start) = (2.0_f64, 0.5, 0.1);
    let mut run = Run::new(&file("slot"));
    for time in [0.0, 0.6, 1.5_f64] {
        let (r, v) = (start * (omega * time).cosh(), start * omega * (omega * time).sinh());
        run.to(time).check("slot.s", r);
        run.check("slot.v", v);
        run.check("slot.a", omega * omega * r);
        run.check("slot.fn", 2.0 * mass * omega * v);
        run.check("slot.omega", 1.0 - omega);
        run.check("bead.omega", 1.0);
        run.check("motor.torque", 2.0 * mass * omega * v * r);
    }
}

/// A weight on a rod: the tension is m g cos + m v^2 / L, wherever it is; the weight itself does not turn.
#[test]
fn a_pendulum_on_a_distance_link() {
    let (mass, length, start) = (0.7, 1.3, 1.1_f64);
    let mut run = Run::new(&file("distance"));
    run.check("weight.y", -length * start.cos());
    run.check("rod.force", -mass * G * start.cos());
    let energy = run.get("energy.total");
    for time in [0.2, 0.9, 3.0] {
        run.to(time).check("energy.total", energy);
        let [x, y, vx, vy] = ["weight.x", "weight.y", "weight.vx", "weight.vy"].map(|name| run.get(name));
        assert!((x.hypot(y) - length).abs() < 1e-9);
        run.check("rod.force", mass * G * y / length - mass * (vx * vx + vy * vy) / length);
        run.check("weight.angle", 0.0);
    }
}

/// A block on a horizontal guide.
fn block(mass: f64) -> Scene {
    Scene::new("block").body("block", Body::new().mass(mass))
}

fn on_guide(scene: Scene) -> Scene {
    scene.prismatic("guide", "ground", "block", [1.0, 0.0])
}

/// m v' = -f tanh(v/v0) has the solution sinh(v/v0) = sinh(v(0)/v0) exp(-f t / (m v0)).
fn slowed(start: f64, transition: f64, rate: f64, time: f64) -> f64 {
    transition * ((start / transition).sinh() * (-rate * time / transition).exp()).asinh()
}

#[test]
fn dry_friction_stops_a_slider() {
    let (mass, level, transition, start) = (2.0, 3.0, 0.05, 0.4);
    let scene = block(mass)
        .joint("guide", Joint::prismatic("ground", "block", [1.0, 0.0]).friction(level, transition))
        .initial("block.vx", start);
    let mut run = Run::new(&with_outputs(scene, &["guide.v", "guide.force"]));
    for time in [0.1, 0.25, 0.4] {
        let v = slowed(start, transition, level / mass, time);
        run.to(time).check("guide.v", v);
        run.check("guide.force", -level * (v / transition).tanh());
    }
}

#[test]
fn dry_and_viscous_friction_stop_a_wheel() {
    let (inertia, level, damping, start) = (0.2, 0.5, 0.3, -1.5);
    let spin = |joint: Joint| {
        let scene = Scene::new("wheel").body("wheel", wheel(inertia)).joint("bearing", joint);
        let scene = scene.initial("wheel.omega", start);
        Run::new(&with_outputs(scene, &["bearing.omega", "bearing.torque", "bearing.alpha"]))
    };
    let mut dry = spin(Joint::revolute("ground", "wheel").friction("0.5 N.m", "0.1 rad/s"));
    for time in [0.2, 0.6] {
        dry.to(time).check("bearing.omega", slowed(start, 0.1, level / inertia, time));
    }
    let mut both = spin(Joint::revolute("ground", "wheel").friction(level, 0.1).damping(damping));
    let torque = -level * (start / 0.1).tanh() - damping * start;
    both.check("bearing.torque", torque);
    both.check("bearing.alpha", torque / inertia);
}

#[test]
fn friction_in_a_slot_acts_along_it() {
    let scene = Scene::new("slot")
        .body("pin", Body::new().mass(2.0).inertia(0.1))
        .joint("slot", Joint::slot("ground", "pin", [3.0, 4.0]).friction(1.0, 0.01).damping(0.5))
        .initial("slot.v", 0.2)
        .initial("pin.omega", 3.0);
    let mut run = Run::new(&with_outputs(scene, &["slot.a", "slot.force", "pin.alpha"]));
    run.check("slot.force", -(20.0_f64.tanh()) - 0.1);
    run.check("slot.a", (-(20.0_f64.tanh()) - 0.1) / 2.0);
    run.check("pin.alpha", 0.0);
}

/// m x'' = -k x - k3 x^3 keeps its energy; the force is as the law says.
#[test]
fn a_hardening_spring() {
    let (mass, k, k3, free, start) = (1.2, 10.0, 300.0, 0.5, 0.8);
    let scene = on_guide(block(mass))
        .load("spring", Load::spring("ground", "block", k).cubic(k3).free(free))
        .initial("block.x", start);
    let names = ["block.x", "block.vx", "spring.force", "energy.potential", "energy.total"];
    let mut run = Run::new(&with_outputs(scene, &names));
    let potential = |x: f64| k * x * x / 2.0 + k3 * x.powi(4) / 4.0;
    run.check("energy.total", potential(start - free));
    for time in [0.1, 0.5, 2.0] {
        run.to(time).check("energy.total", potential(start - free));
        let x = run.get("block.x") - free;
        run.check("spring.force", -k * x - k3 * x.powi(3));
        run.check("energy.potential", potential(x));
    }
}

#[test]
fn a_hardening_torsion_spring() {
    let (inertia, k, k3, start) = (0.3, 2.0, 5.0, 0.9);
    let scene = Scene::new("torsion")
        .body("wheel", wheel(inertia))
        .revolute("bearing", "ground", "wheel")
        .load("spring", Load::torsion_spring("ground", "wheel", k).cubic(k3).free(0.1))
        .initial("wheel.angle", start);
    let mut run = Run::new(&with_outputs(scene, &["wheel.alpha", "wheel.angle", "spring.torque", "energy.total"]));
    let x = start - 0.1;
    run.check("wheel.alpha", (-k * x - k3 * x.powi(3)) / inertia);
    let energy = k * x * x / 2.0 + k3 * x.powi(4) / 4.0;
    run.to(1.7).check("energy.total", energy);
    let x = run.get("wheel.angle") - 0.1;
    run.check("spring.torque", -k * x - k3 * x.powi(3));
}

/// A block flies against a stop, is thrown back after half a period, and flies away as fast as it came.
#[test]
fn a_stop_only_pushes() {
    let (mass, k, free, start, speed) = (0.5, 2000.0_f64, 0.2, 0.5, 1.5);
    let scene = on_guide(block(mass))
        .load("stop", Load::spring("ground", "block", k).free(free).side(Side::Below))
        .initial("block.x", start)
        .initial("block.vx", -speed);
    let mut run = Run::new(&with_outputs(scene, &["block.x", "block.vx", "stop.force", "energy.total"]));
    let (arrival, frequency) = ((start - free) / speed, (k / mass).sqrt());
    let leaving = arrival + std::f64::consts::PI / frequency;
    run.to(arrival / 2.0).check("stop.force", 0.0);
    run.check("energy.total", mass * speed * speed / 2.0);
    let inside = arrival + 0.3 / frequency;
    run.to(inside).check("block.x", free - speed / frequency * 0.3_f64.sin());
    run.check("stop.force", k * speed / frequency * 0.3_f64.sin());
    run.check("energy.total", mass * speed * speed / 2.0);
    run.to(leaving + 0.1).check("block.vx", speed);
    run.check("block.x", free + speed * 0.1);
    run.check("stop.force", 0.0);
}

/// A damped rope pulls or hangs loose; it never pushes, however fast it is let go.
#[test]
fn a_rope_only_pulls() {
    let force = |x: f64, v: f64| {
        let load = Load::spring("ground", "block", 100.0).damping(20.0).free(1.0).side(Side::Above);
        let scene = on_guide(block(1.0)).load("rope", load).initial("block.x", x).initial("block.vx", v);
        Run::new(&with_outputs(scene, &["rope.force"])).get("rope.force")
    };
    let cases = BTreeMap::from([("taut", (force(1.2, 0.5), -30.0)), ("slack", (force(0.8, 5.0), 0.0))]);
    for (name, (found, expected)) in cases {
        assert!((found - expected).abs() < 1e-12, "{name}: {found}");
    }
    assert_eq!(force(1.01, -3.0), 0.0, "let go faster than it contracts");
}

#[test]
fn gravity_leaves_a_weightless_body_alone() {
    let scene = Scene::new("two")
        .gravity([0.0, -G])
        .body("stone", Body::new().mass(2.0).inertia(0.1))
        .body("balloon", Body::new().mass(3.0).inertia(0.1).weightless())
        .initial("balloon.y", 5.0);
    let mut run = Run::new(&with_outputs(scene, &["stone.y", "balloon.y", "balloon.ay", "energy.potential"]));
    run.to(0.5).check("stone.y", -G / 8.0);
    run.check("balloon.y", 5.0);
    run.check("balloon.ay", 0.0);
    run.check("energy.potential", -2.0 * G * G / 8.0);
}

/// The same key in a file.
#[test]
fn gravity_is_switched_off_in_the_file() {
    let text = "name = \"a\"\ngravity = [0, -9.81]\n[bodies.balloon]\nmass = 1\ninertia = 1\ngravity = false\n\
                [outputs]\nvariables = [\"balloon.ay\"]\n";
    Run::new(&Scene::from_toml(text).unwrap()).check("balloon.ay", 0.0);
    Run::new(&Scene::from_toml(&text.replace("false", "true")).unwrap()).check("balloon.ay", -G);
}

/// A jet fixed in a spinning body: v = F/(m omega) (sin, 1 - cos).
#[test]
fn a_force_fixed_in_the_body_turns_with_it() {
    let (mass, force, omega) = (2.0, 3.0, 4.0);
    let scene = Scene::new("jet")
        .body("craft", Body::new().mass(mass).inertia(0.5).point("nozzle", [-0.3, 0.0]))
        .load("jet", Load::body_force("craft.nozzle", [force, 0.0]))
        .initial("craft.omega", omega);
    let mut run = Run::new(&with_outputs(scene, &["craft.vx", "craft.vy", "craft.omega"]));
    for time in [0.3_f64, 1.1] {
        let size = force / (mass * omega);
        run.to(time).check("craft.vx", size * (omega * time).sin());
        run.check("craft.vy", size * (1.0 - (omega * time).cos()));
        run.check("craft.omega", omega);
    }
    let off_centre = Scene::new("jet")
        .body("craft", Body::new().mass(mass).inertia(0.5).point("side", [0.0, 0.2]))
        .load("jet", Load::body_force("craft.side", [force, 0.0]))
        .initial("craft.angle", 0.9);
    let mut run = Run::new(&with_outputs(off_centre, &["craft.alpha", "craft.ax"]));
    run.check("craft.alpha", -0.2 * force / 0.5);
    run.check("craft.ax", force / mass * 0.9_f64.cos());
}

/// All of a file's springs and frictions at once: what they say at the start, and that they only take energy out.
#[test]
fn springs_and_frictions_of_a_file() {
    let mut run = Run::new(&file("springs"));
    let x: f64 = 0.3;
    run.check("spring.force", -10.0 * x - 300.0 * x.powi(3));
    run.check("stop.force", 0.0);
    let turn: f64 = 0.8;
    run.check("coil.torque", -2.0 * turn - 5.0 * turn.powi(3));
    run.check("energy.total", 5.0 * x * x + 75.0 * x.powi(4) + turn * turn + 1.25 * turn.powi(4));
    let start = run.get("energy.total");
    let mut energy = start;
    for step in 1..40 {
        run.to(0.05 * f64::from(step));
        let now = run.get("energy.total");
        assert!(now < energy + 1e-9, "step {step}: {now} after {energy}");
        energy = now;
    }
    assert!(energy < 0.7 * start, "{energy} of {start} is left");
}

/// A disc that rolls on the last of many links: deep enough for the kernel to be made in other trees than the equations.
fn disc_on_a_chain() -> Scene {
    let mut scene = Scene::new("chain").gravity([0.0, -G]);
    for link in 0..10 {
        let name = format!("link{link}");
        let before = if link == 0 { "ground".to_string() } else { format!("link{}.end", link - 1) };
        let body = Body::new().mass(1.0).inertia(0.02).point("start", [-0.1, 0.0]).point("end", [0.1, 0.0]);
        scene = scene
            .body(&name, body)
            .revolute(&format!("pin{link}"), &before, &format!("{name}.start"))
            .initial(&format!("{name}.angle"), 0.1 * f64::from(link * link))
            .initial(&format!("{name}.omega"), 1.0 - 0.3 * f64::from(link));
    }
    scene
        .body("disc", Body::new().mass(0.7).inertia(0.003))
        .joint("contact", Joint::rolling("link9.start", "disc", [0.8, 0.6], 0.05))
        .initial("contact.s", 0.12)
        .initial("contact.v", 0.4)
}

#[test]
fn couplings_in_a_solve_tree() {
    let names = ["contact.fn", "contact.ft", "contact.a", "disc.alpha", "pin9.fx", "pin0.fy", "link4.alpha"];
    let scene = with_outputs(disc_on_a_chain(), &names);
    assert!(formulated(&scene.resolve().unwrap()).lowered.solve_tree.is_some());
    let (mut deep, mut absolute) = (Run::new(&scene), Run::new(&scene.clone().preset("absolute")));
    for name in names {
        let expected = absolute.get(name);
        deep.check(name, expected);
    }
}

/// The words of the file and those of Rust mean the same.
#[test]
fn joints_of_files_and_of_the_builder() {
    let built = [
        ("gear", "mesh", Joint::gear("ground", "planet", "-sun_teeth/planet_teeth").carrier("arm")),
        ("rack", "mesh", Joint::rack("pinion", "bar", [1, 0], 0.05).carrier("ground.guide").displacement(0.3)),
        ("rolling", "contact", {
            Joint::rolling("ground", "disc", ("cos(slope)", "-sin(slope)"), "radius").displacement(0.1)
        }),
        ("slot", "slot", Joint::slot("rod", "bead", [0, 1])),
        ("distance", "rod", Joint::distance("ground", "weight", 1.3)),
        ("springs", "bearing", Joint::revolute("ground.shaft", "wheel").friction(0.02, 0.1)),
        ("springs", "guide", Joint::prismatic("ground", "block", [1, 0]).friction(0.5, 0.01).damping(0.2)),
    ];
    for (name, joint, built) in built {
        let mut scene = file(name);
        let place = scene.joints.iter().position(|other| other.name.text == joint).unwrap();
        let read = scene.resolve().unwrap().mechanism.joints[place].clone();
        scene = scene.joint(joint, built);
        scene.joints.swap_remove(place);
        let mut own = scene.resolve().unwrap().mechanism.joints[place].clone();
        own.span = read.span;
        assert_eq!(own, read, "{name}");
    }
}
