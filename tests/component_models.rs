//! `expected.csv` of the models with gears, racks, rolling discs, slots, links, friction and shapes, computed again here: in absolute coordinates, or
//! by Lagrange's equations, with classical Runge-Kutta steps. The other tests compare the FMU with those files.
//!
//! `COTREE_WRITE_EXPECTED=1 cargo test --test library component_models::` writes the files.

use crate::support::ROOT;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::support::absolute::{At, Body, Joint, JointKind, Load, State, System};
use crate::support::parts::{Extended, Loads, Part};
use nalgebra::{DVector, Matrix2, Vector2};

const G: f64 = 9.81;
const ROWS: usize = 201;
const STEPS_PER_ROW: usize = 200;
/// Error of the file relative to its column's largest value: the drift of the steps here, and the digits there.
const LIMIT: f64 = 1e-9;

/// A function of positions and velocities, in one vector.
type Function<T> = Box<dyn Fn(&DVector<f64>) -> T>;

/// A motion as plain functions of one vector of positions and velocities.
struct Reference {
    start: DVector<f64>,
    rate: Function<DVector<f64>>,
    outputs: Function<Vec<f64>>,
}

impl Reference {
    /// A system in absolute coordinates; `outputs` are in the order of the scene's.
    fn absolute(
        system: Extended,
        q: Vec<f64>,
        outputs: impl Fn(&Extended, &State, &Loads) -> Vec<f64> + 'static,
    ) -> Reference {
        let bodies = q.len();
        let state =
            move |y: &DVector<f64>| State { q: y.rows(0, bodies).into_owned(), v: y.rows(bodies, bodies).into_owned() };
        let system = std::rc::Rc::new(system);
        let mover = system.clone();
        let rate = move |y: &DVector<f64>| {
            let now = state(y);
            let a = mover.solve(&now).acceleration;
            DVector::from_iterator(2 * bodies, now.v.iter().chain(a.iter()).copied())
        };
        let start = state(&DVector::from_vec(q.clone()).resize_vertically(2 * bodies, 0.0));
        let gap = system.constraints(&start).0.amax();
        assert!(gap < 1e-12, "the loops are open by {gap}");
        Reference {
            start: DVector::from_vec(q).resize_vertically(2 * bodies, 0.0),
            rate: Box::new(rate),
            outputs: Box::new(move |y| {
                let now = state(y);
                outputs(&system, &now, &system.solve(&now))
            }),
        }
    }

    fn advance(&self, y: &DVector<f64>, h: f64) -> DVector<f64> {
        let k1 = (self.rate)(y);
        let k2 = (self.rate)(&(y + &k1 * (h / 2.0)));
        let k3 = (self.rate)(&(y + &k2 * (h / 2.0)));
        let k4 = (self.rate)(&(y + &k3 * h));
        y + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0)
    }

    /// Times and outputs.
    fn table(&self, stop: f64) -> Vec<Vec<f64>> {
        let step = stop / (ROWS - 1) as f64;
        let mut y = self.start.clone();
        let mut rows = Vec::new();
        for row in 0..ROWS {
            if row > 0 {
                (0..STEPS_PER_ROW).for_each(|_| y = self.advance(&y, step / STEPS_PER_ROW as f64));
            }
            rows.push(std::iter::once(row as f64 * step).chain((self.outputs)(&y)).collect());
        }
        rows
    }
}

fn file(model: &str) -> PathBuf {
    Path::new(ROOT).join("models").join(model).join("expected.csv")
}

/// The names of the outputs, in the scene's order.
fn header(model: &str) -> String {
    let scene = cotree::scene::Scene::read(file(model).with_file_name("scene.toml")).unwrap();
    let resolved = scene.resolve().unwrap();
    let names: Vec<&str> = resolved.outputs.iter().map(|output| output.name.as_str()).collect();
    format!("time,{}", names.join(","))
}

fn check(model: &str, stop: f64, reference: &Reference) {
    let (table, header) = (reference.table(stop), header(model));
    assert_eq!(table[0].len(), header.split(',').count(), "{model}: {header}");
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let mut text = header.clone() + "\n";
        for row in &table {
            let digits = |value: &f64| format!("{value:.14e}").parse::<f64>().unwrap().to_string();
            let _ = writeln!(text, "{}", row.iter().map(digits).collect::<Vec<_>>().join(","));
        }
        std::fs::write(file(model), text).unwrap();
    }
    let text = std::fs::read_to_string(file(model)).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header.as_str()), "{model}");
    let stored: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect();
    assert_eq!(stored.len(), ROWS, "{model}");
    for (column, name) in header.split(',').enumerate() {
        let scale = table.iter().fold(0.0_f64, |scale, row| scale.max(row[column].abs()));
        for (row, expected) in stored.iter().zip(&table) {
            let error = (row[column] - expected[column]).abs() / if scale > 1e-6 { scale } else { 1.0 };
            assert!(error <= LIMIT, "{model}: {name} at {} s is off by {error:e} of its scale", row[0]);
        }
    }
}

fn at(body: usize, x: f64, y: f64) -> At {
    At { body: Some(body), local: Vector2::new(x, y) }
}

fn fixed(x: f64, y: f64) -> At {
    At { body: None, local: Vector2::new(x, y) }
}

fn body(mass: f64, inertia: f64) -> Body {
    Body { mass, inertia }
}

fn pin(a: At, b: At, damping: f64) -> Joint {
    Joint { between: [a, b], kind: JointKind::Revolute, damping }
}

fn slide(a: At, b: At, axis: Vector2<f64>, damping: f64) -> Joint {
    Joint { between: [a, b], kind: JointKind::Prismatic { axis, angle: 0.0 }, damping }
}

/// stall (1 - omega/free) on a body, as a constant torque and a damper.
fn motor(body: usize, stall: f64, free: f64) -> [Load; 2] {
    let between = [None, Some(body)];
    [
        Load::Torque { between, value: stall },
        Load::TorsionSpring { between, stiffness: 0.0, angle: 0.0, damping: stall / free },
    ]
}

fn energy(system: &Extended, state: &State) -> f64 {
    system.system.kinetic_energy(state) + system.system.potential_energy(state)
}

fn spring_force(system: &Extended, load: usize, state: &State) -> f64 {
    crate::support::loads::line_force(&system.system.loads[load], state)
}

#[test]
fn planetary_gear() {
    let (sun, arm, planet) = (0, 1, 2);
    let (teeth, length, stall, free) = ([24.0, 18.0, 60.0], 0.105, 2.0, 60.0);
    let gear = |a, ratio| Part::Gear { between: [a, Some(planet)], carrier: Some(arm), ratio, angle: 0.0 };
    let system = Extended {
        system: System {
            gravity: Vector2::new(0.0, -G),
            bodies: vec![body(0.5, 0.0009), body(0.4, 0.002), body(0.3, 0.0003)],
            joints: vec![
                pin(fixed(0.0, 0.0), at(sun, 0.0, 0.0), 0.0),
                pin(fixed(0.0, 0.0), at(arm, 0.0, 0.0), 0.05),
                pin(at(arm, length, 0.0), at(planet, 0.0, 0.0), 0.0),
            ],
            loads: motor(sun, stall, free).to_vec(),
            ..System::default()
        },
        parts: vec![gear(Some(sun), -teeth[0] / teeth[1]), gear(None, teeth[2] / teeth[1])],
    };
    let start = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, length, 0.0, 0.0];
    let reference = Reference::absolute(system, start, move |system, state, loads| {
        let turn = |body: usize| [state.angle(Some(body)), state.omega(Some(body))];
        let mut row = [turn(sun), turn(arm), turn(planet)].concat();
        row.extend([loads.parts[0][0], loads.parts[1][0], loads.joints[4], loads.joints[5], loads.joints[2]]);
        row.extend([loads.joints[3], stall * (1.0 - state.omega(Some(sun)) / free), energy(system, state)]);
        row
    });
    check("planetary_gear", 2.0, &reference);
}

#[test]
fn rack_and_pinion() {
    let (pinion, rack) = (0, 1);
    let (radius, eccentricity, turn) = (0.04, 0.03, 80.0_f64.to_radians());
    let guide = fixed(0.0, -radius);
    let slide_on = slide(guide, at(rack, 0.0, 0.0), Vector2::x(), 0.0);
    let system = Extended {
        system: System {
            gravity: Vector2::new(0.0, -G),
            bodies: vec![body(1.5, 0.002), body(0.8, 1.0)],
            joints: vec![pin(fixed(0.0, 0.0), at(pinion, -eccentricity, 0.0), 0.002), slide_on],
            loads: vec![Load::Spring {
                between: [fixed(-0.4, -radius), at(rack, 0.0, 0.0)],
                stiffness: 150.0,
                length: 0.4,
                damping: 0.3,
            }],
            ..System::default()
        },
        parts: vec![Part::Rack {
            pinion: Some(pinion),
            slide: [guide, at(rack, 0.0, 0.0)],
            axis: Vector2::x(),
            radius,
            displacement: 0.0,
        }],
    };
    let start = vec![eccentricity * turn.cos(), eccentricity * turn.sin(), turn, radius * turn, -radius, 0.0];
    let reference = Reference::absolute(system, start, move |system, state, loads| {
        let force = loads.parts[0][0];
        let mut row = vec![state.q[2], state.v[2], state.q[3], state.v[3], force, -radius * force];
        row.extend([loads.joints[2], loads.joints[3], loads.joints[0], loads.joints[1]]);
        row.extend([spring_force(system, 0, state), energy(system, state)]);
        row
    });
    check("rack_and_pinion", 3.0, &reference);
}

#[test]
fn rolling_disc() {
    let (plank, disc) = (0, 1);
    let (radius, tilt, s): (f64, f64, f64) = (0.1, 0.1, 0.15);
    let part = Part::Rolling {
        between: [at(plank, 0.0, 0.0), at(disc, 0.0, 0.0)],
        axis: Vector2::x(),
        radius,
        displacement: 0.0,
    };
    let system = Extended {
        system: System {
            gravity: Vector2::new(0.0, -G),
            bodies: vec![body(3.0, 0.25), body(2.0, 0.5 * 2.0 * radius * radius)],
            joints: vec![pin(fixed(0.0, 0.0), at(plank, 0.0, 0.0), 0.0)],
            loads: vec![
                Load::TorsionSpring { between: [None, Some(plank)], stiffness: 60.0, angle: 0.0, damping: 0.5 },
                Load::Spring {
                    between: [at(plank, -0.4, radius), at(disc, 0.0, 0.0)],
                    stiffness: 80.0,
                    length: 0.4,
                    damping: 0.2,
                },
            ],
            ..System::default()
        },
        parts: vec![part.clone()],
    };
    let centre = [s * tilt.cos() - radius * tilt.sin(), s * tilt.sin() + radius * tilt.cos()];
    let start = vec![0.0, 0.0, tilt, centre[0], centre[1], tilt - s / radius];
    let reference = Reference::absolute(system, start, move |system, state, loads| {
        let [slide, _] = system.motion(&part, state, &loads.acceleration).expect("a rolling disc has a motion");
        let mut row = vec![state.q[2], state.v[2], slide[0], slide[1], loads.parts[0][0], loads.parts[0][1]];
        row.extend([state.q[3], state.q[4], state.q[5], loads.joints[0], loads.joints[1]]);
        row.push(crate::support::loads::torsion(&system.system.loads[0], state));
        row.extend([spring_force(system, 1, state), energy(system, state)]);
        row
    });
    check("rolling_disc", 4.0, &reference);
}

#[test]
fn scotch_yoke() {
    let (crank, yoke) = (0, 1);
    let (length, stall, free, turn) = (0.12, 3.0, 25.0, 40.0_f64.to_radians());
    let part = Part::Slot { between: [at(yoke, 0.0, 0.0), at(crank, length / 2.0, 0.0)], axis: Vector2::y() };
    let mut loads = motor(crank, stall, free).to_vec();
    let between = [fixed(0.3, 0.0), at(yoke, 0.0, 0.0)];
    loads.push(Load::Spring { between, stiffness: 60.0, length: 0.3, damping: 0.0 });
    let system = Extended {
        system: System {
            bodies: vec![body(0.8, 0.004), body(1.2, 1.0)],
            joints: vec![
                pin(fixed(0.0, 0.0), at(crank, -length / 2.0, 0.0), 0.0),
                slide(fixed(0.0, 0.0), at(yoke, 0.0, 0.0), Vector2::x(), 4.0),
            ],
            loads,
            ..System::default()
        },
        parts: vec![part.clone()],
    };
    let [x, y] = [length * turn.cos(), length * turn.sin()];
    let reference =
        Reference::absolute(system, vec![x / 2.0, y / 2.0, turn, x, 0.0, 0.0], move |system, state, loads| {
            let [slide, _] = system.motion(&part, state, &loads.acceleration).expect("a slot has a motion");
            let mut row = vec![state.q[2], state.v[2], state.q[3], state.v[3], slide[0], slide[1]];
            row.extend([loads.parts[0][0], loads.joints[2], loads.joints[3], loads.joints[0], loads.joints[1]]);
            row.push(stall * (1.0 - state.v[2] / free));
            row.extend([spring_force(system, 2, state), energy(system, state)]);
            row
        });
    check("scotch_yoke", 2.0, &reference);
}

#[test]
fn trammel() {
    let between = [at(0, 0.0, 0.0), at(1, 0.0, 0.0)];
    let system = Extended {
        system: System {
            gravity: Vector2::new(0.0, -G),
            bodies: vec![body(1.0, 1.0), body(0.6, 1.0)],
            joints: vec![
                slide(fixed(0.0, 0.0), between[0], Vector2::x(), 0.4),
                slide(fixed(0.0, 0.0), between[1], Vector2::y(), 0.0),
            ],
            loads: vec![Load::Spring {
                between: [fixed(0.9, 0.0), between[0]],
                stiffness: 40.0,
                length: 0.5,
                damping: 0.0,
            }],
            ..System::default()
        },
        parts: vec![Part::Distance { between, length: 0.5 }],
    };
    let reference = Reference::absolute(system, vec![0.3, 0.0, 0.0, 0.0, 0.4, 0.0], |system, state, loads| {
        let mut row = vec![state.q[0], state.v[0], state.q[4], state.v[4], loads.parts[0][0]];
        row.extend([loads.joints[0], loads.joints[2], spring_force(system, 0, state), energy(system, state)]);
        row
    });
    check("trammel", 4.0, &reference);
}

/// Lagrange's equations of a block on a spring with a pendulum, whose angle counts from the level.
#[test]
fn friction() {
    let (block, bob, inertia, arm, stiffness) = (1.2, 0.5, 0.004, 0.2, 120.0);
    let rub = |v: f64| -1.5 * (v / 0.02).tanh();
    let drag = |omega: f64| -0.03 * (omega / 0.1).tanh();
    let motion = move |y: &DVector<f64>| {
        let ([x, angle], [v, omega]) = ([y[0], y[1]], [y[2], y[3]]);
        let (sine, cosine) = angle.sin_cos();
        let coupling = -bob * arm * sine;
        let mass = Matrix2::new(block + bob, coupling, coupling, inertia + bob * arm * arm);
        let load = Vector2::new(
            bob * arm * cosine * omega * omega - stiffness * x + rub(v),
            -bob * G * arm * cosine + drag(omega),
        );
        mass.lu().solve(&load).expect("the mass matrix is regular")
    };
    let rate = move |y: &DVector<f64>| {
        let a = motion(y);
        DVector::from_vec(vec![y[2], y[3], a.x, a.y])
    };
    let outputs = move |y: &DVector<f64>| {
        let (a, [v, omega]) = (motion(y), [y[2], y[3]]);
        let (sine, cosine) = y[1].sin_cos();
        let bob_velocity = [v - arm * sine * omega, arm * cosine * omega];
        let fx = bob * (a.x - arm * (sine * a.y + cosine * omega * omega));
        let fy = bob * (arm * (cosine * a.y - sine * omega * omega) + G);
        let kinetic = (block * v * v
            + bob * (bob_velocity[0] * bob_velocity[0] + bob_velocity[1] * bob_velocity[1])
            + inertia * omega * omega)
            / 2.0;
        let potential = bob * G * arm * sine + stiffness * y[0] * y[0] / 2.0;
        let mut row = vec![y[0], v, y[1], omega, rub(v), drag(omega), fx, fy];
        row.extend([block * G + fy, -stiffness * y[0], kinetic + potential]);
        row
    };
    let start = DVector::from_vec(vec![0.15, -FRAC_PI_2 * 2.0 / 3.0, 0.0, 0.0]);
    let reference = Reference { start, rate: Box::new(rate), outputs: Box::new(outputs) };
    check("friction", 4.0, &reference);
}

/// Mass, mass centre from the pivot and moment of inertia about the mass centre of the metronome's parts, by hand.
fn metronome_parts(slide_height: f64) -> [[f64; 3]; 4] {
    let [low, high] = [-0.06, 0.20];
    let (arm, bob, hub) = (0.12 * (high - low), 7850.0 * 0.012 * PI * 0.018 * 0.018, 21.0 * 0.012 * 0.030);
    // A trapezoid of height d with the sides a below and b above: mass centre d/3 (a + 2 b)/(a + b) from a; its second moments are those of
    // strips of the width w = a + (b - a) s/d at s: integrals of w s^2 and w^3/12.
    let (a, b, d) = (0.012, 0.020, 0.016);
    let area = 0.5 * (a + b) * d;
    let centre = d / 3.0 * (a + 2.0 * b) / (a + b);
    let along = d * d * d * (a + 3.0 * b) / 12.0 - area * centre * centre;
    let across = d * (a + b) * (a * a + b * b) / 48.0;
    let slide = 8500.0 * 0.010;
    [
        [arm, 0.5 * (low + high), arm * (high - low) * (high - low) / 12.0],
        [bob, low, 0.5 * bob * 0.018 * 0.018],
        [slide * area, slide_height - 0.5 * d + centre, slide * (along + across)],
        [hub, 0.0, hub * (0.012 * 0.012 + 0.030 * 0.030) / 12.0],
    ]
}

#[test]
fn metronome() {
    let parts = metronome_parts(0.08);
    let mass: f64 = parts.iter().map(|[m, _, _]| m).sum();
    let first: f64 = parts.iter().map(|[m, x, _]| m * x).sum();
    let inertia: f64 = parts.iter().map(|[m, x, i]| i + m * x * x).sum();
    let slide = parts[2][1];
    let turning = move |angle: f64| -first * G * angle.cos() / inertia;
    let rate = move |y: &DVector<f64>| DVector::from_vec(vec![y[1], turning(y[0])]);
    let outputs = move |y: &DVector<f64>| {
        let ((sine, cosine), omega, alpha) = (y[0].sin_cos(), y[1], turning(y[0]));
        let fx = -first * (alpha * sine + omega * omega * cosine);
        let fy = mass * G + first * (alpha * cosine - omega * omega * sine);
        let energy = 0.5 * inertia * omega * omega + first * G * sine;
        vec![y[0], omega, slide * cosine, slide * sine, fx, fy, energy]
    };
    let start = DVector::from_vec(vec![70.0_f64.to_radians(), 0.0]);
    let reference = Reference { start, rate: Box::new(rate), outputs: Box::new(outputs) };
    check("metronome", 4.0, &reference);
    // The period by the arithmetic-geometric mean, as the model's page gives it.
    let (mut a, mut b) = (1.0_f64, 10.0_f64.to_radians().cos());
    for _ in 0..5 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let beats = 120.0 * a * (G * first.abs() / inertia).sqrt() / TAU;
    assert!((beats - 87.62).abs() < 0.005, "{beats}");
}

/// A front axle whose corner is a part: right as it is written, left in a mirror.
#[test]
fn double_wishbone() {
    let car = 0;
    let (lower, upper, height, turn) = (0.36, 0.26, -0.04, 2.0_f64.to_radians());
    let (lower_ball, upper_ball) = (Vector2::new(-0.06, -0.12), Vector2::new(-0.09, 0.13));
    let mut system = System {
        gravity: Vector2::new(0.0, -G),
        bodies: vec![body(520.0, 160.0)],
        loads: Vec::new(),
        ..System::default()
    };
    let mut start = vec![0.0, height, turn];
    for side in [1.0, -1.0] {
        let [low, high, upright] = [1, 2, 3].map(|place| system.bodies.len() - 1 + place);
        let mirrored = |v: Vector2<f64>| Vector2::new(side * v.x, v.y);
        let on = |body: usize, v: Vector2<f64>| At { body: Some(body), local: mirrored(v) };
        let [low_pivot, high_pivot, strut] =
            [(0.34, -0.09), (0.40, 0.13), (0.44, 0.40)].map(|(x, y)| Vector2::new(x, y));
        system.bodies.extend([body(4.0, 0.05), body(2.0, 0.015), body(32.0, 0.9)]);
        let x = |x: f64| Vector2::new(x, 0.0);
        system.joints.extend([
            pin(on(car, low_pivot), on(low, x(-lower / 2.0)), 0.0),
            pin(on(car, high_pivot), on(high, x(-upper / 2.0)), 0.0),
            pin(on(low, x(lower / 2.0)), on(upright, lower_ball), 0.0),
            pin(on(high, x(upper / 2.0)), on(upright, upper_ball), 0.0),
        ]);
        let spring = |between, stiffness, length, damping| Load::Spring { between, stiffness, length, damping };
        system.loads.extend([
            spring([on(low, x(0.08)), on(car, strut)], 22e3, 0.67, 1800.0),
            spring([fixed(side * 0.75, -1.0), on(upright, x(0.0))], 180e3, 1.0, 0.0),
        ]);
        // The pose, in the car's frame and as if it were the right side; then in the world.
        let angle = 2.0_f64.to_radians();
        let ball = low_pivot + lower * Vector2::new(angle.cos(), angle.sin());
        let (gap, reach) = (high_pivot - ball, (upper_ball - lower_ball).norm());
        let along = (gap.norm_squared() + reach * reach - upper * upper) / (2.0 * gap.norm());
        let aside = (reach * reach - along * along).sqrt();
        let unit = gap.normalize();
        let other = ball + along * unit + aside * Vector2::new(unit.y, -unit.x);
        let arm = other - high_pivot;
        let leg = other - ball;
        let lean = leg.y.atan2(leg.x) - (upper_ball - lower_ball).y.atan2((upper_ball - lower_ball).x);
        let wheel = ball - nalgebra::Rotation2::new(lean) * lower_ball;
        let car_turn = nalgebra::Rotation2::new(turn);
        for (place, angle) in
            [((low_pivot + ball) / 2.0, angle), ((high_pivot + other) / 2.0, arm.y.atan2(arm.x)), (wheel, lean)]
        {
            let place = car_turn * mirrored(place) + Vector2::new(0.0, height);
            start.extend([place.x, place.y, turn + side * angle]);
        }
    }
    let slot = Part::Slot { between: [fixed(0.0, 0.0), at(car, 0.0, 0.0)], axis: Vector2::y() };
    let extended = Extended { system, parts: vec![slot] };
    let reference = Reference::absolute(extended, start, move |system, state, _| {
        let angle = |body: usize| state.angle(Some(body));
        let force = |load: usize| spring_force(system, load, state);
        let mut row = vec![state.q[1], angle(car), force(1), force(3), energy(system, state)];
        for (low, load) in [(1, 0), (4, 2)] {
            let upright = low + 2;
            row.extend([
                angle(low) - angle(car),
                angle(upright),
                state.q[3 * upright],
                state.q[3 * upright + 1],
                force(load),
            ]);
        }
        row.extend([angle(3) - angle(car), angle(6) - angle(car)]);
        row
    });
    check("double_wishbone", 2.0, &reference);
}

/// A motor with a controller on a four-bar: its current, and how far the crank is behind.
#[test]
fn motor_four_bar() {
    let (resistance, inductance, constant, kp, ki, speed) = (0.9, 6e-3, 0.28, 1.2, 9.0, 8.0);
    let (crank, coupler, rocker) = (0, 1, 2);
    let system = System {
        gravity: Vector2::new(0.0, -G),
        bodies: vec![body(0.6, 0.004), body(0.9, 0.023), body(1.1, 0.016)],
        joints: vec![
            pin(fixed(0.0, 0.0), at(crank, -0.09, 0.0), 0.0),
            pin(at(crank, 0.09, 0.0), at(coupler, -0.275, 0.0), 0.0),
            pin(at(coupler, 0.275, 0.0), at(rocker, 0.21, 0.0), 0.0),
            pin(fixed(0.5, 0.0), at(rocker, -0.21, 0.0), 0.02),
        ],
        ..System::default()
    };
    // Where the circles of coupler and rocker meet, above.
    let knee = Vector2::new(0.5_f64.cos(), 0.5_f64.sin()) * 0.18;
    let (to, foot) = (Vector2::new(0.5, 0.0) - knee, Vector2::new(0.5, 0.0));
    let along = (0.55_f64.powi(2) - 0.42_f64.powi(2) + to.norm_squared()) / (2.0 * to.norm());
    let across = (0.55_f64.powi(2) - along * along).sqrt();
    let top = knee + to.normalize() * along + Vector2::new(-to.y, to.x).normalize() * across;
    let place = |from: Vector2<f64>, to: Vector2<f64>| {
        let (middle, way) = ((from + to) / 2.0, to - from);
        [middle.x, middle.y, way.y.atan2(way.x)]
    };
    let q = [place(Vector2::zeros(), knee), place(knee, top), place(foot, top)].concat();
    let voltage = move |y: &DVector<f64>| kp * (speed - y[11]) + ki * y[19];
    let rate = move |y: &DVector<f64>| {
        let now = State { q: y.rows(0, 9).into_owned(), v: y.rows(9, 9).into_owned() };
        let torque = Load::Torque { between: [None, Some(crank)], value: constant * y[18] };
        let a = System { loads: vec![torque], ..system.clone() }.solve(&now, 0.0).acceleration;
        let states = [(voltage(y) - resistance * y[18] - constant * y[11]) / inductance, speed - y[11]];
        DVector::from_iterator(20, now.v.iter().chain(a.iter()).copied().chain(states))
    };
    let reference = Reference {
        start: DVector::from_vec(q).resize_vertically(20, 0.0),
        rate: Box::new(rate),
        outputs: Box::new(move |y| vec![y[2], y[11], y[18], y[19], voltage(y), constant * y[18]]),
    };
    check("motor_four_bar", 2.0, &reference);
}

/// A lever on two chambers of oil: its angle and rate, and both pressures; the time is counted, too.
#[test]
fn hydraulic_lever() {
    let (cap_area, rod_area, bulk, [cap_volume, rod_volume]) = (7e-4, 4.5e-4, 1.1e9, [1.8e-4, 2.6e-4]);
    let (supply, tank, valve, retracted, leakage): (f64, f64, f64, f64, f64) = (11e6, 1e5, 1.9e-8, 0.5, 2e-13);
    let (mass, inertia, centre, eye, base) = (22.0, 2.4, 0.55, 0.45, Vector2::new(0.35, -0.35));
    // The eye, the length of the cylinder, and how both change with the angle.
    let cylinder = move |angle: f64| {
        let way = Vector2::new(angle.cos(), angle.sin()) * eye - base;
        let slope = way.dot(&(Vector2::new(-angle.sin(), angle.cos()) * eye)) / way.norm();
        [way.norm(), slope]
    };
    let force = move |y: &DVector<f64>| y[2] * cap_area - y[3] * rod_area;
    let opening = |time: f64| -0.5 * (4.0 * (time - 0.75)).sin();
    let rate = move |y: &DVector<f64>| {
        let ([length, slope], open) = (cylinder(y[0]), opening(y[4]));
        let (speed, stroke, leak) = (slope * y[1], length - retracted, leakage * (y[2] - y[3]));
        let root = |high: f64, low: f64| valve * open * (high - low).sqrt();
        let (into, out) =
            if open > 0.0 { (root(supply, y[2]), root(y[3], tank)) } else { (root(y[2], tank), root(supply, y[3])) };
        let turning = (force(y) * slope - mass * G * centre * y[0].cos()) / (inertia + mass * centre * centre);
        let cap = bulk * (into - cap_area * speed - leak) / (cap_volume + cap_area * stroke);
        let rod = bulk * (rod_area * speed - out + leak) / (rod_volume - rod_area * stroke);
        DVector::from_vec(vec![y[1], turning, cap, rod, 1.0])
    };
    let outputs = move |y: &DVector<f64>| vec![y[0], y[1], y[2], y[3], opening(y[4]), cylinder(y[0])[0], force(y)];
    let reference = Reference {
        start: DVector::from_vec(vec![18_f64.to_radians(), 0.0, 1.6e6, 2e6, 0.0]),
        rate: Box::new(rate),
        outputs: Box::new(outputs),
    };
    check("hydraulic_lever", 1.5, &reference);
}
