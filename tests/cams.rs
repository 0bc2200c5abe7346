//! Cams against what a workshop could measure: the follower touches the profile everywhere and enters it nowhere, its curvature is that
//! of three neighbouring points, forces are those of statics and of Newton's law, and the motion is that of a law without a cam.

use crate::outside::command;
use crate::support::cam;
use crate::support::run;

use std::f64::consts::{PI, TAU};

use cotree::scene::{Body, Joint, Scene};
use cotree_fmu::program::Engine;

use cam::{Cam, Place, Random, Touch, turned};
use command::{code, cotree, stderr, stdout};
use run::{distance, model, motion, sound, started};

/// The cam turns once, with the speed 1.
const TURN: &str = r#"
[drivers.motor]
joint = "shaft"
angle = "t"
[outputs]
variables = ["cam.angle", "follower.angle", "follower.tip.x", "follower.tip.y", "follower.ax", "follower.ay", "follower.alpha",
             "contact.fn", "contact.torque", "contact.pressure_angle", "contact.curvature", "contact.angle", "follower.x", "follower.y",
             "cam.ax", "cam.ay", "shaft.fx", "shaft.fy", "follower.guide.x", "follower.guide.y"]
[experiment]
stop = 6.283185307179586
step = 0.06283185307179587
tolerance = 1e-10
"#;

/// Columns of a run by their names.
fn columns(text: &str) -> impl Fn(&str) -> Vec<f64> + use<> {
    let results = sound(Scene::from_toml(text)).simulate().unwrap_or_else(|error| panic!("{error}\n{text}"));
    move |name: &str| results.get(name).unwrap_or_else(|| panic!("no {name}")).to_vec()
}

/// What `cotree trace` says of the profile: points and the follower's points, from the shaft in the cam's axes.
fn profile(text: &str) -> Vec<[f64; 4]> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cam.toml"), text).unwrap();
    let output = cotree(folder.path(), &["trace", "cam.toml", "contact"]);
    assert_eq!(code(&output), 0, "{}{text}", stderr(&output));
    let text = stdout(&output);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("angle [rad],contact.x [m],contact.y [m],contact.pitch_x [m],contact.pitch_y [m]"));
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        [numbers[1], numbers[2], numbers[3], numbers[4]]
    };
    lines.map(row).collect()
}

fn dot([ax, ay]: Place, [bx, by]: Place) -> f64 {
    ax * bx + ay * by
}

fn minus([ax, ay]: Place, [bx, by]: Place) -> Place {
    [ax - bx, ay - by]
}

/// How far a place is from a line between two others.
fn from_edge(at: Place, [a, b]: [Place; 2]) -> f64 {
    let (way, along) = (minus(at, a), minus(b, a));
    let share = (dot(way, along) / dot(along, along)).clamp(0.0, 1.0);
    let [x, y] = minus(way, [share * along[0], share * along[1]]);
    x.hypot(y)
}

/// Random cams of all kinds that the program does not call undercut, with the side on which a turning follower touches.
fn cams(seed: u64, count: usize) -> Vec<(Cam, &'static str)> {
    let mut random = Random(seed);
    let mut found = Vec::new();
    while found.len() < count {
        let (turning, flat) = (found.len() % 2 == 1, found.len() / 2 % 2 == 1);
        let cam = if turning { Cam::turning(&mut random, flat) } else { Cam::sliding(&mut random, flat) };
        let side = ["left", "right"][random.index(2)];
        let resolved = sound(sound(Scene::from_toml(&cam.scene(side, TURN))).resolve());
        if resolved.warnings.is_empty() {
            found.push((cam, side));
        }
    }
    found
}

/// At 100 angles the follower, where the simulation has it, touches the profile and does not enter it.
#[test]
fn the_profile_is_the_envelope_of_the_follower() {
    for (cam, side) in cams(1, 40) {
        let text = cam.scene(side, TURN);
        let (points, of) = (profile(&text), columns(&text));
        let [angles, turns, x, y] = ["cam.angle", "follower.angle", "follower.tip.x", "follower.tip.y"].map(of);
        // A polygon's sides lie inside a convex profile, and outside a hollow one.
        let limit = 1e-4 * cam.base;
        for index in 0..100 {
            let seen = |at: Place| turned(-angles[index], at);
            let tip = seen(minus([x[index], y[index]], cam.shaft));
            let gap = match cam.touch {
                Touch::Roller(radius) => {
                    let sides = (0..points.len()).map(|k| {
                        let [a, b] = [k, (k + 1) % points.len()].map(|k| [points[k][0], points[k][1]]);
                        from_edge(tip, [a, b])
                    });
                    sides.fold(f64::MAX, f64::min) - radius
                }
                Touch::Face(direction) => {
                    let out = seen(turned(turns[index] + direction + 0.5 * PI, [1.0, 0.0]));
                    let heights = points.iter().map(|&[u, v, ..]| dot(minus(tip, [u, v]), out));
                    heights.fold(f64::MAX, f64::min)
                }
            };
            assert!(gap.abs() < limit, "{gap} m at {} of\n{text}", angles[index]);
        }
        // On the base circle, and nowhere inside.
        let least = points.iter().map(|[u, v, ..]| u.hypot(*v)).fold(f64::MAX, f64::min);
        assert!(least > 0.8 * cam.base, "{least} {text}");
    }
}

/// The circle through three points: its curvature, positive to the left.
fn curvature([a, b, c]: [Place; 3]) -> f64 {
    let (u, v, w) = (minus(b, a), minus(c, b), minus(c, a));
    let size = |[x, y]: Place| x.hypot(y);
    2.0 * (u[0] * v[1] - u[1] * v[0]) / (size(u) * size(v) * size(w))
}

/// Curvature and pressure angle at half a degree's steps against the points of the profile alone.
#[test]
fn curvature_and_pressure_angle_are_those_of_the_profile() {
    let mut compared = 0;
    for (cam, side) in cams(2, 24) {
        let text = cam.scene(side, &TURN.replace("0.06283185307179587", "0.008726646259971648"));
        let (points, of) = (profile(&text), columns(&text));
        let [curvatures, pressures] = ["contact.curvature", "contact.pressure_angle"].map(&of);
        let at = |k: usize| [points[k % 720][0], points[k % 720][1]];
        for k in 2..718 {
            let found = [curvatures[k - 2], curvatures[k], curvatures[k + 2]];
            // Where pieces of the law meet, its second derivative may have a corner.
            let smooth = (found[0] - 2.0 * found[1] + found[2]).abs() < 0.2 / cam.base;
            let step = minus(at(k + 1), at(k - 1));
            // A flat face rests on one point while the profile is sharp.
            if !smooth || step[0].hypot(step[1]) < 1e-4 * cam.base {
                continue;
            }
            // The contact goes clockwise while the cam turns counter-clockwise.
            let expected = -curvature([at(k - 1), at(k), at(k + 1)]);
            assert!((found[1] - expected).abs() < 0.03 / cam.base, "{} {expected} at {k} of\n{text}", found[1]);
            compared += 1;
            if !cam.turning {
                // The normal in the carrier against the direction of the slide, which the tip follows.
                let normal = turned(of_angle(k), turned(0.5 * PI, step));
                let rise = minus(tip(&of, k + 40), tip(&of, k - 2));
                if rise[0].hypot(rise[1]) > 1e-4 {
                    let cosine = dot(normal, rise).abs() / (normal[0].hypot(normal[1]) * rise[0].hypot(rise[1]));
                    assert!((cosine.acos() - pressures[k].abs()).abs() < 2e-3, "{} {}", cosine.acos(), pressures[k]);
                }
            }
        }
    }
    assert!(compared > 8000, "{compared}");
}

fn of_angle(k: usize) -> f64 {
    TAU * k as f64 / 720.0
}

fn tip(of: &impl Fn(&str) -> Vec<f64>, k: usize) -> Place {
    ["follower.tip.x", "follower.tip.y"].map(|name| of(name)[k.min(720)])
}

/// Newton's law for the follower and statics for the massless lever: the normal force at the profile's own point, along its own normal,
/// balances what accelerates the follower, and turns the cam.
#[test]
fn the_normal_force_accelerates_the_follower_and_turns_the_cam() {
    for (cam, side) in cams(3, 24) {
        let text = cam.scene(side, &TURN.replace("0.06283185307179587", "0.008726646259971648"));
        let (points, of) = (profile(&text), columns(&text));
        let names = ["contact.fn", "contact.torque", "follower.ax", "follower.ay", "follower.alpha"];
        let [force, torque, ax, ay, alpha] = names.map(&of);
        let [x, y, tip_x, tip_y] = ["follower.x", "follower.y", "follower.tip.x", "follower.tip.y"].map(&of);
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for k in (2..718).step_by(7) {
            let at = |k: usize| turned(of_angle(k), [points[k][0], points[k][1]]);
            let step =
                turned(of_angle(k), minus([points[k + 1][0], points[k + 1][1]], [points[k - 1][0], points[k - 1][1]]));
            let long = step[0].hypot(step[1]);
            if long < 1e-4 * cam.base {
                continue;
            }
            let contact = at(k);
            let out = turned(0.5 * PI, [step[0] / long, step[1] / long]);
            let out = if dot(out, contact) > 0.0 { out } else { [-out[0], -out[1]] };
            let push = [force[k] * out[0], force[k] * out[1]];
            // What the follower does to the cam, about the shaft.
            let expected = contact[1] * push[0] - contact[0] * push[1];
            let scale = largest(&torque).max(largest(&force) * 1e-2 * cam.base);
            assert!((torque[k] - expected).abs() < 3e-3 * scale, "{} {expected} at {k} of\n{text}", torque[k]);
            let inertia = [0.4 * ax[k], 0.4 * ay[k]];
            if cam.turning {
                // About the pivot: the guide exerts no torque there.
                let pivot = pivot(&text);
                let (arm, own) =
                    (minus([contact[0] + cam.shaft[0], contact[1] + cam.shaft[1]], pivot), minus([x[k], y[k]], pivot));
                let moment = arm[0] * push[1] - arm[1] * push[0];
                let needed = own[0] * inertia[1] - own[1] * inertia[0] + 3e-4 * alpha[k];
                let scale = largest(&force) * 0.05;
                assert!((moment - needed).abs() < 3e-3 * scale, "{moment} {needed} at {k} of\n{text}");
            } else {
                // Along the slide, the direction of the tip's acceleration: the guide exerts nothing along it.
                let size = ax[k].hypot(ay[k]);
                if size > 0.05 * largest(&ax).hypot(largest(&ay)) {
                    let along = [ax[k] / size, ay[k] / size];
                    let needed = dot(inertia, along);
                    assert!(
                        (dot(push, along) - needed).abs() < 3e-3 * largest(&force),
                        "{push:?} {needed} at {k} of\n{text}"
                    );
                }
            }
            assert!(tip_x[k].is_finite() && tip_y[k].is_finite());
        }
    }
}

/// Newton's and Euler's laws for cam and follower as free bodies, whatever the trees: shaft and guide carry what the contact needs.
#[test]
fn shaft_and_guide_carry_the_contact_force() {
    for (index, (cam, side)) in cams(4, 16).into_iter().enumerate() {
        let guide = if cam.turning { "\"guide.fx\", \"guide.fy\"" } else { "\"guide.fn\", \"guide.torque\"" };
        let outputs = TURN.replace("\"contact.fn\"", &format!("{guide}, \"contact.fn\""));
        let preset = ["", "[coordinates]\npreset = \"absolute\"\n", "[coordinates]\npreset = \"joint\"\n"][index % 3];
        let text = cam.scene(side, &(outputs.replace("0.06283185307179587", "0.008726646259971648") + preset));
        let (points, of) = (profile(&text), columns(&text));
        let vector = |names: [&str; 2]| {
            let [x, y] = names.map(&of);
            x.into_iter().zip(y).map(|(x, y)| [x, y]).collect::<Vec<Place>>()
        };
        let (force, shaft) = (of("contact.fn"), vector(["shaft.fx", "shaft.fy"]));
        let (of_cam, of_follower) = (vector(["cam.ax", "cam.ay"]), vector(["follower.ax", "follower.ay"]));
        let (centre, seat) = (vector(["follower.x", "follower.y"]), vector(["follower.guide.x", "follower.guide.y"]));
        let alpha = of("follower.alpha");
        let largest = force.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let near = |found: f64, expected: f64, scale: f64| {
            assert!((found - expected).abs() < 3e-3 * scale, "{found} {expected} of\n{text}");
        };
        for k in (2..718).step_by(7) {
            let place = |k: usize| [points[k][0], points[k][1]];
            let step = turned(of_angle(k), minus(place(k + 1), place(k - 1)));
            let long = step[0].hypot(step[1]);
            if long < 1e-4 * cam.base {
                continue;
            }
            let contact = turned(of_angle(k), place(k));
            let out = turned(0.5 * PI, [step[0] / long, step[1] / long]);
            let sign = dot(out, contact).signum();
            let push = out.map(|component| sign * force[k] * component);
            let contact = [0, 1].map(|axis| contact[axis] + cam.shaft[axis]);
            for axis in 0..2 {
                near(shaft[k][axis], 1.5 * of_cam[k][axis] + push[axis], largest);
            }
            // What the guide must exert on the follower.
            let needed = [0, 1].map(|axis| 0.4 * of_follower[k][axis] - push[axis]);
            let moment = |at: Place, [fx, fy]: Place| {
                let [x, y] = minus(at, centre[k]);
                x * fy - y * fx
            };
            let rest = 3e-4 * alpha[k] - moment(contact, push) - moment(seat[k], needed);
            if cam.turning {
                let found = vector(["guide.fx", "guide.fy"])[k];
                (0..2).for_each(|axis| near(found[axis], needed[axis], largest));
                near(rest, 0.0, 0.05 * largest);
            } else {
                near(of("guide.fn")[k].abs(), needed[0].hypot(needed[1]), largest);
                near(of("guide.torque")[k], rest, 0.05 * largest);
            }
        }
    }
}

/// The follower's pivot, as the scene says.
fn pivot(text: &str) -> Place {
    let (_, rest) = text.split_once("guide = [").unwrap();
    let numbers: Vec<f64> =
        rest.split(']').next().unwrap().split(',').map(|number| number.trim().parse().unwrap()).collect();
    [numbers[0], numbers[1]]
}

/// The free cam and its follower as one freedom: (I + m s'^2) theta'' + m s' s'' theta'^2 = -k s s', integrated by Runge and Kutta's method.
#[test]
fn a_free_cam_moves_as_one_freedom_with_the_law_in_it() {
    let (inertia, mass, stiffness, lift) = (2e-3, 0.5, 4000.0, 0.012);
    let text = format!(
        r#"
name = "free"
ground.points = {{ shaft = [0, 0], guide = [0.005, 0], seat = [0.005, 1.0] }}
[bodies]
cam = {{ mass = 1, inertia = {inertia}, points = {{ hub = [0, 0] }} }}
follower = {{ mass = {mass}, inertia = 1e-4, points = {{ tip = [0, 0], top = [0, 0.1] }} }}
[joints]
shaft = {{ type = "revolute", between = ["ground.shaft", "cam.hub"] }}
guide = {{ type = "prismatic", between = ["ground.guide", "follower.tip"], axis = [0, 1] }}
contact = {{ type = "cam", between = ["cam", "follower.tip"], shaft = "shaft", guide = "guide", base = 0.03, roller = 0.01, law = "{lift}*(poly4567(angle/2) - poly4567((angle - 3)/2.5))" }}
[loads.spring]
type = "force"
on = "follower.tip"
vector = [0, "-{stiffness}*(guide.s - 0.03968626966596886)"]
[initial]
"cam.angle" = 0.4
"cam.omega" = 20
[outputs]
variables = ["cam.angle", "cam.omega", "energy.kinetic"]
[experiment]
stop = 2
step = 0.5
tolerance = 1e-10
"#
    );
    // s0 = sqrt(0.04^2 - 0.005^2): the spring is free on the base circle.
    let unit = |x: f64| if (0.0..=1.0).contains(&x) { x } else { x.clamp(0.0, 1.0) };
    let poly = |x: f64| {
        let x = unit(x);
        let value = x.powi(4) * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)));
        let slope = 140.0 * x.powi(3) * (1.0 - x).powi(3);
        let second = 420.0 * x * x * (1.0 - x) * (1.0 - x) * (1.0 - 2.0 * x);
        [value, slope, second]
    };
    let law = |theta: f64| {
        let theta = theta.rem_euclid(TAU);
        let (up, down) = (poly(theta / 2.0), poly((theta - 3.0) / 2.5));
        [0, 1, 2].map(|order: usize| {
            lift * (up[order] / 2.0_f64.powi(order as i32) - down[order] / 2.5_f64.powi(order as i32))
        })
    };
    let rate = |[theta, omega]: [f64; 2]| {
        let [s, first, second] = law(theta);
        let effort = -stiffness * s * first - mass * first * second * omega * omega;
        [omega, effort / (inertia + mass * first * first)]
    };
    let mut state = [0.4, 20.0];
    let steps = 400_000;
    let h = 2.0 / f64::from(steps);
    let mut stored = Vec::new();
    for step in 0..=steps {
        if step % (steps / 4) == 0 {
            stored.push(state);
        }
        let add = |a: [f64; 2], s: f64, b: [f64; 2]| [a[0] + s * b[0], a[1] + s * b[1]];
        let k1 = rate(state);
        let k2 = rate(add(state, 0.5 * h, k1));
        let k3 = rate(add(state, 0.5 * h, k2));
        let k4 = rate(add(state, h, k3));
        state = [0, 1].map(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let of = columns(&text);
    let [angle, omega] = ["cam.angle", "cam.omega"].map(of);
    for (index, [theta, rate]) in stored.into_iter().enumerate() {
        assert!((angle[index] - theta).abs() < 1e-5, "{} {theta}", angle[index]);
        assert!((omega[index] - rate).abs() < 1e-4, "{} {rate}", omega[index]);
    }
    assert!(angle[4] > TAU, "it turns more than once: {}", angle[4]);
}

/// Free cams of all kinds under gravity, several turns: by series, whose loop equation has the law in it, as by Runge and Kutta's method.
#[test]
fn free_cams_move_alike_by_series_and_by_runge_kutta() {
    for (case, (cam, side)) in cams(6, 24).into_iter().enumerate() {
        let start = "[initial]\n\"cam.angle\" = 0.4\n\"cam.omega\" = 30\n[experiment]\nstop = 1\n";
        let text = format!("gravity = [0, -9.81]\n{}", cam.scene(side, start));
        let model = model(&text);
        assert_eq!(model.program().engine, Engine::Taylor, "{text}");
        let [series, stages] = [Engine::Taylor, Engine::Dop853].map(|engine| {
            let mut run = started(&model, Some(engine), 1.0, 1e-13);
            run.step_to(1.0).expect("regular");
            assert_eq!(run.statistics().fallbacks, 0, "{text}");
            motion(&run)
        });
        let error = distance(&series, &stages);
        assert!(error < 1e-11, "{case}: {error} {series:?}\n{text}");
    }
}

const LIFTED: &str = r#"
name = "cam"
gravity = [0, -9.81]
[parameters]
base = "30 mm"
lift = "12 mm"
[ground.points]
shaft = [0, 0]
guide = ["6 mm", 0]
[bodies]
disc = { mass = 1, inertia = 2e-3, points = { hub = [0, 0] } }
lifter = { mass = 2, inertia = 1e-3, points = { roller = [0, 0] } }
[joints]
shaft = { type = "revolute", between = ["ground.shaft", "disc.hub"] }
guide = { type = "prismatic", between = ["ground.guide", "lifter.roller"], axis = [0, 1] }
[joints.cam]
type = "cam"
between = ["disc", "lifter.roller"]
shaft = "shaft"
guide = "guide"
base = "base"
roller = "8 mm"
law = "lift*(harmonic(angle/2) - harmonic((angle - 3)/2))"
[initial]
"disc.angle" = "-20 deg"
"disc.omega" = 25
[outputs]
variables = ["disc.angle", "guide.s"]
[experiment]
stop = "0.5 s"
tolerance = 1e-9
"#;

/// The motion changes with base circle and lift as two runs differ, through the angles at which the law switches; at the beginning of a
/// turn the angle and a rise switch together.
#[test]
fn derivatives_of_the_motion_are_differences_of_runs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cam.toml"), LIFTED).unwrap();
    let run = |arguments: &[&str]| {
        let output = cotree(folder.path(), &[&["simulate", "cam.toml"], arguments].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let text = stdout(&output);
        let last: Vec<f64> = text.lines().last().unwrap().split(',').map(|number| number.parse().unwrap()).collect();
        (text.lines().next().unwrap().to_string(), last)
    };
    let (header, found) = run(&["--sensitivity", "base", "--sensitivity", "lift"]);
    for (parameter, value) in [("base", 0.03), ("lift", 0.012)] {
        let step = 1e-4 * value;
        let [less, more] = [-step, step].map(|step| run(&["--set", &format!("{parameter}={}", value + step)]).1);
        for (column, output) in ["disc.angle", "guide.s"].into_iter().enumerate() {
            let expected = (more[column + 1] - less[column + 1]) / (2.0 * step);
            let name = format!("d({output})/d({parameter})");
            let place = header.split(',').position(|own| own.starts_with(&name)).unwrap_or_else(|| panic!("{header}"));
            let error = (found[place] - expected).abs();
            assert!(error < 1e-3 * expected.abs().max(1.0), "{name} {} {expected}", found[place]);
        }
    }
}

/// A cam that is made in Rust is that of the text.
#[test]
fn a_cam_is_made_in_rust_as_in_a_text() {
    let law = "lift*(harmonic(angle/2) - harmonic((angle - 3)/2))";
    let scene = Scene::new("cam")
        .gravity([0.0, -9.81])
        .parameter("base", "30 mm")
        .parameter("lift", "12 mm")
        .ground_point("shaft", [0.0, 0.0])
        .ground_point("guide", ("6 mm", 0))
        .body("disc", Body::new().mass(1.0).inertia(2e-3).point("hub", [0.0, 0.0]))
        .body("lifter", Body::new().mass(2.0).inertia(1e-3).point("roller", [0.0, 0.0]))
        .revolute("shaft", "ground.shaft", "disc.hub")
        .joint("guide", Joint::prismatic("ground.guide", "lifter.roller", [0.0, 1.0]))
        .joint("cam", Joint::cam("disc", "lifter.roller", ["shaft", "guide"], "base", law).roller("8 mm"))
        .initial("disc.angle", "-20 deg")
        .initial("disc.omega", 25.0)
        .output("disc.angle")
        .output("guide.s")
        .stop("0.5 s")
        .tolerance(1e-9);
    let of_text = columns(LIFTED);
    let results = scene.simulate().unwrap();
    for name in ["disc.angle", "guide.s"] {
        assert_eq!(results.get(name).unwrap(), of_text(name), "{name}");
    }
}

/// A follower on an arm that swings, with places for what is different where the cam turns and where it is at rest.
const ON_AN_ARM: &str = r#"
name = "moving"
gravity = [0.0, -9.81]
[ground.points]
pivot = [0, 0]
[bodies.arm]
mass = 2.0
inertia = 0.05
com = [0.1, 0.02]
points = { pivot = [0, 0], POINTS }
DISC
[bodies.lifter]
mass = 0.5
inertia = 1e-3
com = [0.01, 0.03]
points = { roller = [0, 0], top = [0, 0.06] }
[joints.hinge]
type = "revolute"
between = ["ground.pivot", "arm.pivot"]
SHAFT
[joints.guide]
type = "prismatic"
between = ["arm.guide", "lifter.roller"]
axis = [0.2, 1]
angle = 0.3
[joints.cam]
type = "cam"
CAM
guide = "guide"
base = 0.03
roller = 0.01
law = "0.008*(1 - cos(angle)) + 0.002*sin(2*angle)"
[loads.spring]
type = "spring"
between = ["arm.seat", "lifter.top"]
stiffness = 2000
length = 0.2
[initial]
INITIAL
"arm.omega" = -1
[outputs]
variables = ["arm.angle", "guide.s", "cam.angle", "cam.fn", "cam.torque", "hinge.fx", "hinge.fy", "guide.fn", "guide.torque", "energy.total"]
[experiment]
stop = "0.5 s"
step = "10 ms"
tolerance = 1e-10
"#;

/// A cam on an arm that swings, and a follower that an arm carries around a cam at rest: energy stays, and all trees give the same motion
/// and the same loads.
#[test]
fn cams_work_on_carriers_that_move() {
    let turning = [
        ("POINTS", "shaft = [0.2, 0.05], guide = [0.206, 0.05], seat = [0.206, 0.25]"),
        ("DISC", "[bodies.disc]\nmass = 1.0\ninertia = 0.002\ncom = [0.004, 0.002]\npoints = { axis = [0, 0] }"),
        ("SHAFT", "[joints.shaft]\ntype = \"revolute\"\nbetween = [\"disc.axis\", \"arm.shaft\"]"),
        ("CAM", "between = [\"disc\", \"lifter.roller\"]\nshaft = \"shaft\""),
        ("INITIAL", "\"disc.angle\" = 0.3\n\"disc.omega\" = 30"),
    ];
    let at_rest = [
        ("POINTS", "guide = [0.006, 0.0], seat = [0.006, 0.2]"),
        ("DISC", ""),
        ("SHAFT", ""),
        ("CAM", "between = [\"ground\", \"lifter.roller\"]\nshaft = \"hinge\""),
        ("INITIAL", ""),
    ];
    for parts in [turning, at_rest] {
        let text = parts.iter().fold(ON_AN_ARM.to_owned(), |text, (place, part)| text.replace(place, part));
        let presets = ["recommended", "absolute", "joint"];
        let runs = presets.map(|preset| columns(&format!("{text}[coordinates]\npreset = \"{preset}\"\n")));
        let names = [
            "arm.angle",
            "guide.s",
            "cam.angle",
            "cam.fn",
            "cam.torque",
            "hinge.fx",
            "hinge.fy",
            "guide.fn",
            "guide.torque",
        ];
        for name in names {
            let [first, second, third] = [0, 1, 2].map(|run| runs[run](name));
            let scale = first.iter().fold(1e-3_f64, |most, value| most.max(value.abs()));
            for (row, value) in first.iter().enumerate() {
                for other in [second[row], third[row]] {
                    assert!((value - other).abs() < 1e-5 * scale, "{name} {value} {other} in row {row}");
                }
            }
        }
        let energy = runs[0]("energy.total");
        for value in &energy {
            assert!((value - energy[0]).abs() < 1e-7 * energy[0].abs(), "{value} {}", energy[0]);
        }
        let angle = runs[0]("cam.angle");
        assert!(angle.iter().all(|angle| (0.0..=TAU).contains(angle)), "{angle:?}");
        let turned = angle.iter().fold([TAU, 0.0_f64], |[low, high], angle| [low.min(*angle), high.max(*angle)]);
        assert!(turned[1] - turned[0] > 1.0, "{turned:?}");
    }
}

/// What is wrong with a cam is said with its place, and what has no effect.
#[test]
fn wrong_cams_are_told_from_right_ones() {
    let first = |text: &str| match Scene::from_toml(text).and_then(|scene| scene.resolve()) {
        Ok(resolved) => resolved.warnings.first().map(|fault| fault.code),
        Err(faults) => faults.list.first().map(|fault| fault.code),
    };
    assert_eq!(first(LIFTED), None);
    let changes = [
        ("roller = \"8 mm\"", "roller = \"8 mm\"\nface = [1, 0]", "scene::cam_contact"),
        ("roller = \"8 mm\"", "face = [0, 1]", "scene::cam_contact"),
        ("base = \"base\"\nroller = \"8 mm\"", "base = \"base/30\"\nface = [1, 0]", "scene::cam_undercut"),
        ("base = \"base\"", "base = \"base\"\nside = \"left\"", "scene::unused"),
        ("- harmonic((angle - 3)/2)", "", "scene::cam_law"),
        ("harmonic(angle/2)", "harmonic(t/2)", "scene::not_constant"),
        ("harmonic(angle/2)", "harmonic(disc.angle/2)", "scene::not_constant"),
        ("guide = \"guide\"", "guide = \"cam\"", "scene::cam_joint"),
        ("shaft = \"shaft\"", "shaft = \"guide\"", "scene::cam_joint"),
        ("shaft = \"shaft\"", "shaft = \"axle\"", "scene::unknown_joint"),
        ("shaft = \"shaft\"", "", "scene::missing_key"),
    ];
    for (right, wrong, code) in changes {
        assert!(LIFTED.contains(right), "{right}");
        assert_eq!(first(&LIFTED.replace(right, wrong)), Some(code), "{wrong}");
    }
}

/// Within the turn; narrow and steep rises are none.
#[test]
fn laws_that_jump_are_refused_and_corners_are_warned_of() {
    let law = |rise: &str| LIFTED.replace("harmonic(angle/2)", rise);
    let jump = Scene::from_toml(&law("if(angle < 1, 0, 1)")).and_then(|scene| scene.resolve()).unwrap_err();
    assert!(
        jump.list.len() == 1
            && jump.list[0].message.contains("discontinuous at 57.29578 deg: it jumps from 0 mm to 12 mm"),
        "{jump}"
    );
    let warnings = |rise: &str| {
        let resolved = Scene::from_toml(&law(rise)).unwrap().resolve().unwrap();
        resolved
            .warnings
            .iter()
            .map(|fault| fault.message.clone())
            .filter(|own| own.contains("corner"))
            .collect::<Vec<_>>()
    };
    let corners = warnings("if(angle < 1, 0, min((angle - 1)/2, 1))");
    assert!(corners.len() == 1 && corners[0].contains("at 57.29578 deg, as at 1 more"), "{corners:?}");
    for smooth in ["poly345((angle - 1)/0.003)", "cycloidal((angle - 1.3)/0.02)", "poly345((angle - 2.99)/0.01)"] {
        assert_eq!(warnings(smooth), Vec::<String>::new(), "{smooth}");
    }
}

/// The lift over a prescribed law: what the follower does and what its driver must exert are the same without a cam.
#[test]
fn a_follower_moves_as_if_its_law_were_prescribed() {
    let law = "0.02*(modified_sine(x/1.5) - modified_sine((x - 3)/2))";
    let scene = |joint: &str, outputs: &str| {
        format!(
            r#"
name = "lift"
gravity = [0, -9.81]
ground.points = {{ shaft = [0, 0], guide = [0.006, 0] }}
[bodies]
cam = {{ mass = 1, inertia = 1e-3, points = {{ hub = [0, 0] }} }}
follower = {{ mass = 0.5, inertia = 1e-4, points = {{ tip = [0, 0] }} }}
[joints]
shaft = {{ type = "revolute", between = ["ground.shaft", "cam.hub"] }}
guide = {{ type = "prismatic", between = ["ground.guide", "follower.tip"], axis = [0, 1] }}
{joint}
[drivers.motor]
joint = "shaft"
angle = "2*t"
[outputs]
variables = ["guide.s", "guide.v", "guide.a", {outputs}]
[experiment]
stop = 3.1
step = 0.01
tolerance = 1e-10
"#
        )
    };
    let law_of = |x: &str| law.replace('x', x);
    let joint = format!(
        "contact = {{ type = \"cam\", between = [\"cam\", \"follower.tip\"], shaft = \"shaft\", guide = \"guide\", base = 0.03, roller = 0.01, law = \"{}\" }}",
        law_of("angle")
    );
    let driver =
        format!("[drivers.lift]\njoint = \"guide\"\ndisplacement = \"sqrt(0.04^2 - 0.006^2) + {}\"", law_of("(2*t)"));
    let with_cam =
        columns(&scene(&joint, "\"contact.fn\", \"contact.pressure_angle\", \"motor.torque\", \"contact.torque\""));
    let without = columns(&scene(&driver, "\"lift.force\", \"energy.kinetic\""));
    for name in ["guide.s", "guide.v", "guide.a"] {
        let (found, expected) = (with_cam(name), without(name));
        let scale = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-7 * scale, "{name} {a} {b}");
        }
    }
    let [normal, pressure, motor, torque] =
        ["contact.fn", "contact.pressure_angle", "motor.torque", "contact.torque"].map(&with_cam);
    let (force, speed) = (without("lift.force"), without("guide.v"));
    for k in 0..force.len() {
        assert!((normal[k] * pressure[k].cos() - force[k]).abs() < 1e-6, "{} {}", normal[k], force[k]);
        // Virtual work: the motor's torque times its speed 2 is the force times the follower's.
        assert!((2.0 * motor[k] - force[k] * speed[k]).abs() < 1e-6, "{} {}", motor[k], force[k] * speed[k]);
        assert!((motor[k] + torque[k]).abs() < 1e-9);
    }
}

/// A rocker that a cam turns, guessed so many turns on: the tip is on the base circle at the start, and the angle is next to the guess, whatever is added to it.
#[test]
fn a_turning_follower_keeps_the_turn_of_its_guess() {
    for (guess, part) in
        [(160.0, 0.0), (-170.0, 0.0), (190.0, 0.0), (160.0, 47.0), (520.0, 0.0), (-200.0, 0.0), (160.0, 300.0)]
    {
        let scene = rocker(guess);
        let text = match part {
            0.0 => scene,
            _ => {
                let folder = tempfile::tempdir().unwrap();
                std::fs::write(folder.path().join("rocker.toml"), rocker(guess)).unwrap();
                let host = format!(
                    "format = 1\nname = \"host\"\ngravity = [0, 0]\n[parts.p]\nfile = \"rocker.toml\"\nangle = \"{part} deg\"\n[experiment]\nstop = 0.1\n"
                );
                std::fs::write(folder.path().join("host.toml"), host).unwrap();
                let results = sound(Scene::read(folder.path().join("host.toml"))).simulate().unwrap();
                let at_start = |name: &str| results.get(name).unwrap_or_else(|| panic!("no {name}"))[0];
                check_rocker(guess, part, ["p_rocker.angle", "p_spring.torque"].map(at_start));
                continue;
            }
        };
        let columns = columns(&text);
        let at_start = |name: &str| columns(name)[0];
        let [x, y] = ["rocker.tip.x", "rocker.tip.y"].map(at_start);
        assert!((x.hypot(y) - 0.025).abs() < 1e-9, "{guess}: {x} {y}");
        check_rocker(guess, part, ["rocker.angle", "spring.torque"].map(at_start));
    }
}

/// The spring is free where the rocker is guessed.
fn check_rocker(guess: f64, part: f64, [angle, torque]: [f64; 2]) {
    let away = angle - (guess + part).to_radians();
    assert!(away.abs() < 1.0, "{guess} {part}: {angle}");
    assert!((torque.abs() - 3.0 * away.abs()).abs() < 1e-9, "{guess} {part}: {torque}");
}

fn rocker(guess: f64) -> String {
    format!(
        r#"
format = 1
name = "rocker"
gravity = [0, 0]
[ground.points]
shaft = [0, 0]
pivot = ["70 mm", 0]
[bodies.disc]
mass = 1.0
inertia = 0.001
[bodies.rocker]
mass = 0.2
inertia = 0.0004
points = {{ pivot = [0, 0], tip = ["62 mm", 0] }}
[joints.shaft]
type = "revolute"
between = ["ground.shaft", "disc"]
[joints.pivot]
type = "revolute"
between = ["ground.pivot", "rocker.pivot"]
[joints.cam]
type = "cam"
between = ["disc", "rocker.tip"]
shaft = "shaft"
guide = "pivot"
base = "25 mm"
law = "0.2*(1 - cos(angle))/2"
[loads.spring]
type = "torsion_spring"
between = ["ground", "rocker"]
stiffness = 3.0
angle = "{guess} deg"
[drivers.motor]
joint = "shaft"
angle = "2*t"
[initial]
"rocker.angle" = {{ guess = "{guess} deg" }}
[outputs]
variables = ["rocker.angle", "spring.torque", "rocker.tip.x", "rocker.tip.y"]
[experiment]
stop = 0.1
"#
    )
}

/// Two followers on one disc, all lengths in multiples of a unit, and moments of inertia in those of its square.
fn two_followers(unit: f64) -> String {
    let inertia = 1.5 * (25.0 * unit) * (25.0 * unit);
    let [distance, arm, base, roller, lift] = [85.0, 72.0, 28.0, 7.0, 4.0].map(|length| length * unit);
    format!(
        r#"
name = "two_followers"
gravity = [0, 0]
[ground.points]
pivot = [{distance:e}, 0]
[bodies.disc]
mass = 1.5
inertia = {inertia:e}
[bodies.rocker]
mass = 1.5
inertia = {inertia:e}
points = {{ tip = [{arm:e}, 0] }}
[bodies.lifter]
mass = 1.5
[joints.shaft]
type = "revolute"
between = ["ground", "disc"]
[joints.pivot]
type = "revolute"
between = ["ground.pivot", "rocker"]
[joints.guide]
type = "prismatic"
between = ["ground", "lifter"]
axis = [0, 1]
[joints.swing]
type = "cam"
between = ["disc", "rocker.tip"]
shaft = "shaft"
guide = "pivot"
base = {base:e}
roller = {roller:e}
law = "0.35*(1 - cos(angle))/2"
[joints.lift]
type = "cam"
between = ["disc", "lifter"]
shaft = "shaft"
guide = "guide"
base = {base:e}
law = "{lift:e}*(1 - cos(angle))/2"
[initial]
"rocker.angle" = {{ guess = "150 deg" }}
"disc.angle" = 0.7
"disc.omega" = 2.5
[outputs]
variables = ["disc.angle", "rocker.angle"]
[experiment]
stop = 1.0
step = 0.25
tolerance = 1e-8
"#
    )
}

/// Without gravity the motion does not depend on the size; very small lengths beside angles are no singular pose.
#[test]
fn cams_of_any_size_move_alike() {
    let usual = columns(&two_followers(1e-3));
    for unit in [1e-6, 1e-9, 1e-12] {
        let own = columns(&two_followers(unit));
        for name in ["disc.angle", "rocker.angle"] {
            let apart = usual(name).iter().zip(own(name)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-6, "{unit:e} {name}: {apart:e}");
        }
    }
}
