//! Dampers, constant-force and gas springs, screws and belts against closed forms, and the balance of power.

use crate::support::motion;
use crate::support::run;

use std::f64::consts::TAU;

use cotree::scene::{Body, Driver, Joint, Load, Scene};

use motion::Run;

const G: f64 = 9.81;

/// A block of 2 kg on a level guide, with every variable.
fn block(speed: f64, load: Load) -> Scene {
    Scene::new("block")
        .ground_point("wall", [-0.5, 0.0])
        .body("block", Body::new().mass(2.0).inertia(0.1))
        .prismatic("guide", "ground", "block", [1, 0])
        .load("own", load)
        .initial("guide.s", 0.0)
        .initial("guide.v", speed)
        .with_every_output()
}

fn wheel(inertia: f64) -> Body {
    Body::new().mass(1.5).inertia(inertia)
}

#[test]
fn a_damper_slows_a_block() {
    let (c, m, v0) = (3.0, 2.0, 1.2);
    let mut run = Run::new(&block(v0, Load::damper("ground.wall", "block", c)));
    for time in [0.0, 0.3, 1.0] {
        let v = v0 * (-c * time / m).exp();
        run.to(time).check("guide.v", v);
        run.check("guide.s", (v0 - v) * m / c);
        run.check("own.length", 0.5 + (v0 - v) * m / c);
        run.check("own.force", -c * v);
        run.check("own.power", -c * v * v);
    }
}

#[test]
fn a_rotational_damper_slows_a_wheel() {
    let (c, inertia, start) = (0.4, 0.2, 5.0);
    let scene = Scene::new("wheel")
        .body("wheel", wheel(inertia))
        .revolute("axle", "ground", "wheel")
        .load("brake", Load::torsion_damper("ground", "wheel", c))
        .initial("wheel.angle", 0.0)
        .initial("wheel.omega", start)
        .with_every_output();
    let mut run = Run::new(&scene);
    for time in [0.0, 0.4, 1.1] {
        let omega = start * (-c * time / inertia).exp();
        run.to(time).check("wheel.omega", omega);
        run.check("brake.torque", -c * omega);
        run.check("brake.power", -c * omega * omega);
    }
}

/// What a force and a torque are, in the world's axes whatever the axes they were given in.
#[test]
fn applied_forces_and_torques_can_be_read() {
    let (f, inertia, spin) = ([1.5, -0.4], 0.2, 3.0);
    let scene = Scene::new("wheel")
        .body("wheel", wheel(inertia).point("rim", [0.3, 0.0]))
        .revolute("axle", "ground", "wheel")
        .load("fixed", Load::force("wheel.rim", ("1.5*(1 + time)", -0.4)))
        .load("turning", Load::body_force("wheel.rim", (1.5, -0.4)))
        .load("motor", Load::torque("ground", "wheel", "0.7*cos(time)"))
        .initial("wheel.angle", 0.3)
        .initial("wheel.omega", spin)
        .with_every_output();
    let mut run = Run::new(&scene);
    for time in [0.0, 0.4, 1.1] {
        run.to(time).check("fixed.fx", f[0] * (1.0 + time));
        run.check("fixed.fy", f[1]);
        let (sine, cosine) = run.get("wheel.angle").sin_cos();
        let turned = [cosine * f[0] - sine * f[1], sine * f[0] + cosine * f[1]];
        run.check("turning.fx", turned[0]);
        run.check("turning.fy", turned[1]);
        let rim = ["vx", "vy"].map(|axis| run.get(&format!("wheel.rim.{axis}")));
        run.check("turning.power", turned[0] * rim[0] + turned[1] * rim[1]);
        run.check("motor.torque", 0.7 * time.cos());
        let omega = run.get("wheel.omega");
        run.check("motor.power", 0.7 * time.cos() * omega);
    }
    let line = Scene::new("line")
        .one_dimensional()
        .body("mass", Body::new().mass(2.0))
        .load("push", Load::force("mass", (-3.0, 0.0)))
        .initial("mass.x", 0.0)
        .initial("mass.vx", 0.0)
        .with_every_output();
    let mut run = Run::new(&line);
    run.to(1.0).check("push.fx", -3.0);
    run.check("mass.vx", -1.5);
}

#[test]
fn dampers_on_a_line_are_those_of_the_paper() {
    let chain = |load: Load| {
        Scene::new("chain")
            .one_dimensional()
            .body("mass", Body::new().mass(2.0))
            .load("own", load)
            .initial("mass.x", 0.1)
            .initial("mass.vx", 0.7)
            .with_every_output()
    };
    let mut own = Run::new(&chain(Load::damper("ground", "mass", 3.0)));
    let mut spring = Run::new(&chain(Load::spring("ground", "mass", 0).damping(3.0)));
    for time in [0.0, 0.5, 1.0] {
        let v = 0.7 * (-1.5_f64 * time).exp();
        own.to(time).check("mass.vx", v);
        own.check("own.force", 3.0 * v);
        let same = spring.to(time).get("own.force");
        own.check("own.force", same);
    }
}

#[test]
fn a_constant_force_spring_pulls_evenly() {
    let (pull, m, v0) = (0.8, 2.0, 1.0);
    let mut run = Run::new(&block(v0, Load::constant_force_spring("ground.wall", "block", pull)));
    let energy = 0.5 * m * v0 * v0 + pull * 0.5;
    for time in [0.0, 0.7, 1.5] {
        run.to(time).check("guide.s", v0 * time - 0.5 * pull / m * time * time);
        run.check("own.force", -pull);
        run.check("energy.total", energy);
    }
}

/// The work of the gas is the integral of its force, with an exponent and at constant temperature.
#[test]
fn a_gas_spring_does_the_work_of_its_gas() {
    let (push, column, m, v0) = (6.0, 0.3, 2.0, -0.4);
    for exponent in [1.0, 1.4] {
        let load = Load::gas_spring("ground.wall", "block", push, [0.5, column], exponent);
        let mut run = Run::new(&block(v0, load));
        let energy = run.get("energy.total");
        for time in [0.1, 0.35, 0.8] {
            let x = run.to(time).get("guide.s");
            let ratio = column / (column + x);
            let work = match exponent {
                1.0 => -push * column * ratio.ln(),
                n => push * column / (n - 1.0) * (1.0 - ratio.powf(n - 1.0)),
            };
            let v = run.get("guide.v");
            run.check("own.force", push * ratio.powf(exponent));
            assert!((0.5 * m * (v * v - v0 * v0) - work).abs() < 1e-8, "{exponent} at {time} s: {v}, {work}");
            run.check("energy.total", energy);
        }
    }
}

#[test]
fn a_screw_lifts_a_nut() {
    let (lead, inertia, m, torque, offset) = (0.02, 0.004, 3.0, 0.5, 0.1);
    let scene = Scene::new("jack")
        .gravity([0.0, -G])
        .body("spindle", wheel(inertia))
        .body("nut", Body::new().mass(m).inertia(0.01))
        .revolute("bearing", "ground", "spindle")
        .prismatic("column", "ground", "nut", [0, 1])
        .joint("thread", Joint::screw("spindle", "nut", [0, 1], lead).displacement(offset))
        .load("motor", Load::torque("ground", "spindle", torque))
        .initial("spindle.angle", 0.0)
        .initial("spindle.omega", 0.0)
        .with_every_output();
    let mut run = Run::new(&scene);
    let p = lead / TAU;
    let alpha = (torque - p * m * G) / (inertia + p * p * m);
    for time in [0.0, 0.5, 1.0] {
        let angle = 0.5 * alpha * time * time;
        run.to(time).check("spindle.angle", angle);
        run.check("nut.y", offset + p * angle);
        run.check("thread.force", m * (G + p * alpha));
        run.check("thread.torque", -p * m * (G + p * alpha));
        run.check("thread.power", 0.0);
    }
}

#[test]
fn a_belt_turns_a_pulley() {
    let (ia, ib, torque) = (0.02, 0.3, 4.0);
    for (crossed, sign) in [(false, 1.0), (true, -1.0)] {
        let belt = Joint::belt("pinion", "wheel", [0.05, 0.2]).angle(0.3);
        let scene = Scene::new("drive")
            .ground_point("b", [0.5, 0.0])
            .body("pinion", wheel(ia))
            .body("wheel", wheel(ib))
            .revolute("a", "ground", "pinion")
            .revolute("b", "ground.b", "wheel")
            .joint("belt", if crossed { belt.crossed() } else { belt })
            .load("motor", Load::torque("ground", "pinion", torque))
            .initial("pinion.angle", 0.0)
            .initial("pinion.omega", 0.0)
            .with_every_output();
        let mut run = Run::new(&scene);
        let ratio = sign * 0.25;
        let alpha = torque / (ia + ratio * ratio * ib);
        for time in [0.0, 0.2, 0.6] {
            let angle = 0.5 * alpha * time * time;
            run.to(time).check("pinion.angle", angle);
            run.check("wheel.angle", 0.3 + ratio * angle);
            run.check("belt.torque", ib * ratio * alpha);
        }
    }
}

/// On a turning arm a belt of equal pulleys, the first of which stands still, only shifts the second: it keeps its angle.
#[test]
fn a_belt_on_a_turning_arm_keeps_a_pulley_level() {
    let scene = Scene::new("arm")
        .body("arm", Body::new().mass(1.0).inertia(0.1).point("pin", [0.4, 0.0]))
        .body("tray", wheel(0.05))
        .revolute("shoulder", "ground", "arm")
        .revolute("wrist", "arm.pin", "tray")
        .joint("belt", Joint::belt("ground", "tray", [0.06, 0.06]).carrier("arm"))
        .initial("arm.angle", 0.2)
        .initial("arm.omega", 1.5)
        .with_every_output();
    let mut run = Run::new(&scene);
    for time in [0.0, 0.5, 2.0] {
        run.to(time).check("arm.angle", 0.2 + 1.5 * time);
        run.check("tray.angle", 0.0);
    }
}

/// What joints, drivers and loads put into the bodies is what the kinetic energy gains; the total energy gains what those put in that
/// store nothing.
#[test]
fn the_power_of_all_parts_is_the_rate_of_the_energy() {
    let scene = Scene::new("all")
        .ground_point("high", [0.3, 0.9])
        .body("crank", Body::new().mass(1.2).inertia(0.05).point("end", [0.4, 0.1]))
        .body("rod", Body::new().mass(0.8).inertia(0.03).point("start", [-0.3, 0.0]).point("tip", [0.35, 0.05]))
        .body("cart", Body::new().mass(2.0).inertia(0.1))
        .joint("axle", Joint::revolute("ground", "crank").damping(0.2).friction(0.1, 0.5))
        .joint("knee", Joint::revolute("crank.end", "rod.start").damping(0.05))
        .joint("rail", Joint::prismatic("ground", "cart", [1.0, 0.2]).damping(0.7))
        .driver("shuttle", Driver::displacement("rail", "0.2*sin(3*t)"))
        .load("spring", Load::spring("ground.high", "rod.tip", 40).free(0.4))
        .load("gas", Load::gas_spring("cart", "rod", 5, [0.6, 0.5], 1.3))
        .load("damper", Load::damper("ground.high", "crank.end", 1.1))
        .load("strip", Load::constant_force_spring("cart", "crank.end", 1.5))
        .load("twist", Load::torsion_damper("crank", "rod", 0.1))
        .load("push", Load::body_force("rod.tip", ("2*cos(t)", 0.5)))
        .load("motor", Load::torque("crank", "rod", "0.3*t"))
        .initial("crank.angle", 0.3)
        .initial("rod.angle", -0.4)
        .initial("crank.omega", 1.0)
        .initial("rod.omega", -0.5)
        .with_every_output();
    let dissipating = ["axle", "knee", "rail", "shuttle", "damper", "twist", "push", "motor"];
    let storing = ["spring", "gas", "strip"];
    let mut run = Run::new(&scene);
    let step = 2.5e-4;
    for middle in [0.2_f64, 0.5, 1.1] {
        let (mut kinetic, mut total, mut powers) = (Vec::new(), Vec::new(), [0.0; 2]);
        for shift in [-2.0, -1.0, 0.0, 1.0, 2.0] {
            run.to(middle + shift * step);
            kinetic.push(run.get("energy.kinetic"));
            total.push(run.get("energy.total"));
            if shift == 0.0 {
                let mut sum = |names: &[&str]| names.iter().map(|name| run.get(&format!("{name}.power"))).sum::<f64>();
                powers = [sum(&dissipating), sum(&storing)];
            }
        }
        // The rate by differences of fourth order.
        let rate = |values: &[f64]| (values[0] - 8.0 * values[1] + 8.0 * values[3] - values[4]) / (12.0 * step);
        for (found, power) in [(rate(&kinetic), powers[0] + powers[1]), (rate(&total), powers[0])] {
            assert!((found - power).abs() < 1e-6 * (1.0 + power.abs()), "at {middle} s: {found}, not {power}");
        }
    }
}

/// The models whose `expected.csv` comes from one equation of motion by hand: in closed form, or integrated by a method of order four.
#[test]
fn models_agree_with_their_equation_by_hand() {
    for (model, rows, tolerance) in [("screw_lift", 201, 1e-7), ("gas_strut", 301, 1e-7), ("metronome", 201, 1e-7)] {
        let text = run::file(&format!("models/{model}/expected.csv"));
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let mut run = Run::new(&run::sound(Scene::from_toml(&run::scene_of(model))));
        let mut count = 0;
        for line in lines {
            let values: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            run.to(values[0]);
            for (name, expected) in names.iter().zip(&values).skip(1) {
                let value = run.get(name);
                let close = (value - expected).abs() <= tolerance * (1.0 + expected.abs());
                assert!(close, "{model}: {name} at {} s is {value}, not {expected}", values[0]);
            }
            count += 1;
        }
        assert_eq!(count, rows);
    }
}

/// A disc held at its centre by a bushing alone swings in three ways that do not know of each other.
#[test]
fn a_bushing_holds_a_disc_by_a_force_and_a_torque() {
    let (m, inertia) = (2.0, 0.1);
    let (k, c, kt, ct, free) = (90.0, 3.0, 4.0, 0.2, 0.3);
    let bushing = Load::bushing("ground", "disc", k).damping(c).torsion_stiffness(kt).torsion_damping(ct).free(free);
    let scene = Scene::new("disc")
        .body("disc", Body::new().mass(m).inertia(inertia))
        .load("ring", bushing)
        .initial("disc.x", 0.05)
        .initial("disc.y", -0.02)
        .initial("disc.angle", 0.9)
        .initial("disc.vx", 0.0)
        .initial("disc.vy", 0.3)
        .initial("disc.omega", 0.0)
        .with_every_output();
    // m z" + c z' + k z = 0
    let free_swing = |[m, c, k]: [f64; 3], [z, v]: [f64; 2], t: f64| {
        let (decay, omega) = (0.5 * c / m, (k / m - (0.5 * c / m).powi(2)).sqrt());
        (-decay * t).exp() * (z * (omega * t).cos() + (v + decay * z) / omega * (omega * t).sin())
    };
    let mut run = Run::new(&scene);
    for time in [0.0, 0.2, 0.9] {
        run.to(time).check("disc.x", free_swing([m, c, k], [0.05, 0.0], time));
        run.check("disc.y", free_swing([m, c, k], [-0.02, 0.3], time));
        let turned = free_swing([inertia, ct, kt], [0.9 - free, 0.0], time);
        run.check("disc.angle", free + turned);
        let [x, y, vx, vy, omega] = ["disc.x", "disc.y", "disc.vx", "disc.vy", "disc.omega"].map(|name| run.get(name));
        run.check("ring.fx", -k * x - c * vx);
        run.check("ring.fy", -k * y - c * vy);
        let torque = -kt * turned - ct * omega;
        run.check("ring.torque", torque);
        run.check("ring.power", (-k * x - c * vx) * vx + (-k * y - c * vy) * vy + torque * omega);
    }
}

/// At a point beside the mass centre, and between two bodies that move: a spring of free length zero and a torsion spring do the same.
#[test]
fn a_bushing_is_springs_across_each_other_and_a_torsion_spring() {
    let chain = |loads: fn(Scene) -> Scene| {
        let scene = Scene::new("chain")
            .gravity([0.0, -G])
            .body("arm", Body::new().mass(1.5).inertia(0.08).point("inner", [-0.4, 0.0]).point("outer", [0.4, 0.1]))
            .body("hand", Body::new().mass(0.6).inertia(0.02).point("grip", [-0.2, 0.05]))
            .revolute("shoulder", "ground", "arm.inner")
            .initial("arm.angle", 0.2)
            .initial("arm.omega", 1.0)
            .initial("hand.x", 1.02)
            .initial("hand.y", 0.1)
            .initial("hand.angle", -0.4)
            .initial("hand.vx", 0.0)
            .initial("hand.vy", 0.5)
            .initial("hand.omega", -0.7);
        loads(scene).with_every_output()
    };
    let mut bushing = Run::new(&chain(|scene| {
        scene.load("ring", Load::bushing("arm.outer", "hand.grip", 700).torsion_stiffness(3).free(-0.25))
    }));
    let mut springs = Run::new(&chain(|scene| {
        scene
            .load("ring", Load::spring("arm.outer", "hand.grip", 700).free(0.0))
            .load("coil", Load::torsion_spring("arm", "hand", 3).free(-0.25))
    }));
    for time in [0.0, 0.3, 1.0] {
        springs.to(time);
        bushing.to(time);
        for name in ["arm.angle", "hand.x", "hand.y", "hand.angle", "hand.vx", "hand.omega", "energy.total"] {
            bushing.check(name, springs.get(name));
        }
        bushing.check("ring.torque", springs.get("coil.torque"));
    }
}

/// A rotor of 0.004 kg.m2 beside a flywheel of 0.05: it is read as `alpha`, unless the scene has a number of that name.
#[test]
fn a_torsion_actuator_reads_its_acceleration() {
    let scene = |law: &str, more: &str| {
        format!(
            "name = 'rotor'\n{more}[bodies.flywheel]\nmass = 1\ninertia = 0.05\n[joints.axle]\ntype = 'revolute'\nbetween = ['ground', 'flywheel']\n[loads.rotor]\ntype = 'torsion_actuator'\nbetween = ['ground', 'flywheel']\ntorque = '{law}'\n[outputs]\nvariables = ['flywheel.omega']\n"
        )
    };
    let own = scene("0.2 - 0.004*alpha", "");
    let parameter = scene("0.1*alpha", "[parameters]\nalpha = 2\n");
    for (text, inertia) in [(own, 0.054), (parameter, 0.05)] {
        let mut run = Run::new(&run::sound(Scene::from_toml(&text)));
        run.to(1.5).check("flywheel.omega", 0.2 * 1.5 / inertia);
    }
}
