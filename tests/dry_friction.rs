//! Dry friction that sticks, against closed forms and other formulations.

use crate::support::run::{model, started, value};

use cotree_fmu::program::Engine;

const METHODS: [Engine; 2] = [Engine::Dop853, Engine::Radau];

/// A mass on a spring that rubs: each swing is a half-cycle of a cosine about +-F/k.
const OSCILLATOR: &str = r#"
name = "oscillator"
[ground.points]
wall = [-1, 0]
[bodies.block]
mass = 3.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
friction = { coulomb = "2 N", static = RATIO }
[loads.spring]
type = "spring"
between = ["ground.wall", "block"]
stiffness = "120 N/m"
length = "1 m"
[initial]
"guide.s" = 0.17
"guide.v" = 0.0
[outputs]
variables = ["guide.s", "guide.v", "guide.force", "guide.mode", "guide.sliding"]
[experiment]
stop = "3 s"
tolerance = 1e-10
"#;

/// Place and velocity of the oscillator.
fn swings(time: f64, ratio: f64) -> [f64; 2] {
    let (omega, off) = ((120.0_f64 / 3.0).sqrt(), 2.0 / 120.0);
    let half = std::f64::consts::PI / omega;
    let (mut place, mut begin) = (0.17_f64, 0.0);
    while place.abs() > ratio * off {
        let centre = off * place.signum();
        if time < begin + half {
            let phase = omega * (time - begin);
            let size = place - centre;
            return [centre + size * phase.cos(), -omega * size * phase.sin()];
        }
        (place, begin) = (2.0 * centre - place, begin + half);
    }
    [place, 0.0]
}

#[test]
fn swings_end_where_the_spring_cannot_overcome_the_friction() {
    for (ratio, engine) in [1.0, 1.4, 4.0].into_iter().flat_map(|ratio| METHODS.map(|engine| (ratio, engine))) {
        let model = model(&OSCILLATOR.replace("RATIO", &ratio.to_string()));
        let mut run = started(&model, Some(engine), 3.0, 1e-10);
        for time in [0.1, 0.4, 0.77, 1.3, 1.9, 2.4, 3.0] {
            run.step_to(time).unwrap();
            let [s, v] = swings(time, ratio);
            let found = ["guide.s", "guide.v"].map(|name| value(&mut run, name));
            assert!((found[0] - s).abs() < 1e-9 && (found[1] - v).abs() < 1e-8, "{engine:?} {ratio} {time}: {found:?} {s}");
            let sliding = if v == 0.0 { 0.0 } else { v.signum() };
            assert_eq!(["guide.mode", "guide.sliding"].map(|name| value(&mut run, name)), [sliding; 2]);
            let force = if v == 0.0 { 120.0 * s } else { -2.0 * sliding };
            assert!((value(&mut run, "guide.force") - force).abs() < 1e-6, "{engine:?} {ratio} {time}");
        }
        assert_eq!(value(&mut run, "guide.v"), 0.0, "what sticks does not creep");
    }
}

/// A block on a belt that moves at 0.2 m/s, held by a spring.
const STICK_SLIP: &str = r#"
name = "stick_slip"
gravity = [0, -10]
[ground.points]
wall = [-1, 0]
[bodies.belt]
mass = 1.0
[bodies.block]
mass = 2.0
[joints.track]
type = "prismatic"
between = ["ground", "belt"]
axis = [1, 0]
[joints.slide]
type = "prismatic"
between = ["belt", "block"]
axis = [1, 0]
friction = { mu = 0.25, static = 1.6 }
[drivers.motor]
joint = "track"
displacement = "0.2*t"
[loads.spring]
type = "spring"
between = ["ground.wall", "block"]
stiffness = "80 N/m"
length = "1 m"
[initial]
"block.x" = 0.0
"slide.v" = 0.0
[outputs]
variables = ["block.x", "block.vx", "slide.force", "slide.mode", "slide.fn", "slide.power"]
[experiment]
stop = "400 s"
tolerance = 1e-10
"#;

#[test]
fn stick_and_slip_repeat_with_their_period() {
    // It sticks up to x1 = static F/k and slips about x0 = F/k until it moves with the belt again; then it sticks from 2 x0 - x1 on.
    let (omega, level) = ((80.0_f64 / 2.0).sqrt(), 0.25 * 2.0 * 10.0 / 80.0);
    let (size, speed) = (0.6 * level, 0.2);
    let sticks = 2.0 * size / speed;
    let period = sticks + slip_time(omega, size, speed);
    let mut run = started(&model(STICK_SLIP), None, 400.0, 1e-10);
    let first = 1.6 * level / speed;
    let cycles = ((399.0 - first) / period).floor();
    // In the middle of sticking after so many cycles.
    let time = first + cycles * period - 0.5 * sticks;
    run.step_to(time).unwrap();
    let expected = 1.6 * level - 0.5 * sticks * speed;
    assert!((value(&mut run, "block.x") - expected).abs() < 1e-9 * cycles, "{} {expected}", value(&mut run, "block.x"));
    assert!((value(&mut run, "block.vx") - speed).abs() < 1e-12);
    assert_eq!(value(&mut run, "slide.mode"), 0.0);
}

/// How long a mass slips about a centre that it leaves at `size` with a speed, until it has that speed again.
fn slip_time(omega: f64, size: f64, speed: f64) -> f64 {
    // x = a cos(w t) + (v/w) sin(w t): the rate is v again where w t = 2 pi - 2 atan(a w / v).
    2.0 * (std::f64::consts::PI - (size * omega / speed).atan()) / omega
}

/// A wheel on a pin that carries its weight.
const WHEEL: &str = r#"
name = "wheel"
gravity = [0, -9.81]
[bodies.wheel]
mass = 4.0
inertia = 0.05
[joints.pin]
type = "revolute"
between = ["ground", "wheel"]
friction = { mu = 0.3, radius = "12 mm" }
[initial]
"wheel.omega" = 9.0
[outputs]
variables = ["wheel.angle", "wheel.omega", "pin.torque", "pin.mode", "pin.power"]
[experiment]
stop = "4 s"
tolerance = 1e-10
"#;

#[test]
fn a_wheel_runs_down_on_its_pin() {
    let torque = 0.3 * 0.012 * 4.0 * 9.81;
    let slowing = torque / 0.05;
    let stops = 9.0 / slowing;
    for engine in METHODS {
        let mut run = started(&model(WHEEL), Some(engine), 4.0, 1e-10);
        for time in [0.5, 2.0, 3.0, stops + 0.1, 4.0] {
            run.step_to(time).unwrap();
            let since = time.min(stops);
            let expected = [9.0 * since - 0.5 * slowing * since * since, 9.0 - slowing * since];
            let found = ["wheel.angle", "wheel.omega"].map(|name| value(&mut run, name));
            assert!((0..2).all(|index| (found[index] - expected[index]).abs() < 1e-10), "{engine:?} {time} {found:?}");
            let slides = f64::from(u8::from(time < stops));
            assert!((value(&mut run, "pin.torque") + torque * slides).abs() < 1e-12);
            assert!((value(&mut run, "pin.power") + torque * slides * found[1]).abs() < 1e-9);
        }
    }
}

/// A pendulum whose pin rubs: the force in the pin depends on the motion, and that on the friction.
const PENDULUM: &str = r#"
name = "pendulum"
gravity = [0, -9.81]
[bodies.bar]
mass = 1.5
inertia = 0.03
points = { top = [0, 0.4] }
[joints.pin]
type = "revolute"
between = ["ground", "bar.top"]
friction = { mu = 0.4, radius = "50 mm" }
[initial]
"bar.angle" = "100 deg"
"bar.omega" = 0.0
[outputs]
variables = ["bar.angle", "bar.omega", "pin.fx", "pin.fy", "pin.torque", "pin.mode"]
[experiment]
stop = "6 s"
tolerance = 1e-11
"#;

/// The same by Newton's and Euler's equations of the bar, with the friction by repeated substitution, in steps of Runge and Kutta that end where it turns.
fn rubbing_pendulum(until: f64) -> [f64; 2] {
    let (m, inertia, l, g, mu_r) = (1.5, 0.03 + 1.5 * 0.16, 0.4, 9.81, 0.4 * 0.05);
    let force = |angle: f64, omega: f64, alpha: f64| {
        // The centre is at l (sin, -cos) of the angle.
        let along = m * (l * omega * omega + g * angle.cos());
        let across = m * (l * alpha + g * angle.sin());
        along.hypot(across)
    };
    let alpha = |angle: f64, omega: f64, sign: f64| {
        let mut alpha = -m * g * l * angle.sin() / inertia;
        for _ in 0..60 {
            alpha = (-m * g * l * angle.sin() - sign * mu_r * force(angle, omega, alpha)) / inertia;
        }
        alpha
    };
    let step = |[angle, omega]: [f64; 2], sign: f64, h: f64| {
        let f = |[a, w]: [f64; 2]| [w, alpha(a, w, sign)];
        let at = |k: [f64; 2], share: f64| [angle + share * k[0], omega + share * k[1]];
        let k1 = f([angle, omega]);
        let k2 = f(at(k1, 0.5 * h));
        let k3 = f(at(k2, 0.5 * h));
        let k4 = f(at(k3, h));
        std::array::from_fn(|i| [angle, omega][i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    };
    let (mut state, mut time, mut sign) = ([100.0_f64.to_radians(), 0.0], 0.0, -1.0);
    let h = 2e-4_f64;
    while time < until {
        let length = h.min(until - time);
        let next: [f64; 2] = step(state, sign, length);
        if next[1] * sign >= 0.0 || time == 0.0 {
            (state, time) = (next, time + length);
            continue;
        }
        let (mut low, mut high) = (0.0, length);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if step(state, sign, middle)[1] * sign >= 0.0 { &mut low } else { &mut high }) = middle;
        }
        (state, time) = (step(state, sign, low), time + low);
        state[1] = 0.0;
        if (m * g * l * state[0].sin()).abs() <= mu_r * m * g {
            return state;
        }
        sign = -state[0].signum();
        state = step(state, sign, h);
        time += h;
    }
    state
}

#[test]
fn a_pin_rubs_by_the_force_that_it_carries() {
    for engine in METHODS {
        let mut run = started(&model(PENDULUM), Some(engine), 6.0, 1e-11);
        for time in [0.3, 0.9, 1.7, 2.5] {
            run.step_to(time).unwrap();
            let expected = rubbing_pendulum(time);
            let found = ["bar.angle", "bar.omega"].map(|name| value(&mut run, name));
            assert!((0..2).all(|index| (found[index] - expected[index]).abs() < 1e-8), "{engine:?} {time} {found:?} {expected:?}");
            let [fx, fy, torque] = ["pin.fx", "pin.fy", "pin.torque"].map(|name| value(&mut run, name));
            assert!((torque.abs() - 0.02 * fx.hypot(fy)).abs() < 1e-9);
        }
    }
}

/// A disc that is thrown along the floor slides until it rolls: at two thirds of its speed.
#[test]
fn a_disc_slides_until_it_rolls() {
    let disc = |joint: &str| {
        format!(
            r#"
name = "bowl"
gravity = [0, -9.81]
[bodies.disc]
mass = 3.0
inertia = "0.5*3*0.1^2"
{joint}
[initial]
"lane.s" = 0.0
"disc.vx" = 6.0
"disc.omega" = 0.0
[outputs]
variables = ["disc.x", "disc.vx", "disc.omega", "lane.fn", "lane.ft", "lane.sliding"]
[experiment]
stop = "3 s"
tolerance = 1e-10
"#
        )
    };
    let rolling = r#"
[joints.lane]
type = "rolling"
between = ["ground", "disc"]
axis = [1, 0]
radius = 0.1
friction = { mu = 0.2 }
"#;
    let contact = rolling.replace("rolling", "contact");
    let (slows, turns) = (0.2 * 9.81, 2.0 * 0.2 * 9.81 / 0.1);
    let rolls = 6.0 / (3.0 * slows);
    for (joint, engine) in [rolling, &contact].into_iter().flat_map(|joint| METHODS.map(|engine| (joint, engine))) {
        let text = if joint == rolling { disc(joint) } else { disc(joint).replace("[initial]", "[initial]\n\"disc.y\" = 0.1") };
        let text = if joint == rolling { text } else { text.replace("\"lane.s\" = 0.0", "\"disc.angle\" = 0.0\n\"disc.x\" = 0.0\n\"disc.vy\" = 0.0") };
        let mut run = started(&model(&text), Some(engine), 3.0, 1e-10);
        for time in [0.4, rolls + 0.05, 2.5] {
            run.step_to(time).unwrap();
            let since = time.min(rolls);
            let speed = 6.0 - slows * since;
            let x = 6.0 * since - 0.5 * slows * since * since + (time - since) * speed;
            let slides = time < rolls;
            let expected = [x, speed, -turns * since, 3.0 * 9.81, if slides { -0.2 * 3.0 * 9.81 } else { 0.0 }, f64::from(u8::from(slides))];
            let names = ["disc.x", "disc.vx", "disc.omega", "lane.fn", "lane.ft", "lane.sliding"];
            let found = names.map(|name| value(&mut run, name));
            assert!((0..6).all(|index| (found[index] - expected[index]).abs() < 1e-8), "{engine:?} {time} {found:?} {expected:?}");
        }
    }
}

/// A flywheel that a torque drives against a brake whose level follows a law of time.
#[test]
fn a_brake_stops_holds_and_lets_go() {
    let text = r#"
name = "braked"
[bodies.wheel]
mass = 1.0
inertia = 0.4
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[joints.stop]
type = "brake"
between = ["ground", "wheel"]
level = "if(t < 1, 0, 10)"
[loads.motor]
type = "torque"
on = "wheel"
value = "2 + 3*t"
[initial]
"wheel.omega" = 0.0
[outputs]
variables = ["wheel.omega", "stop.torque", "stop.mode", "stop.omega", "stop.power"]
[experiment]
stop = "5 s"
tolerance = 1e-10
"#;
    // Free to 1 s; then slowed by 8 - 3 t; held until 2 + 3 t = 10; then faster by 3 t - 8.
    let free = |t: f64| (2.0 * t + 1.5 * t * t) / 0.4;
    let slowed = |t: f64| free(1.0) - (8.0 * (t - 1.0) - 1.5 * (t * t - 1.0)) / 0.4;
    let loses = 8.0 / 3.0;
    for engine in METHODS {
        let mut run = started(&model(text), Some(engine), 5.0, 1e-10);
        for time in [0.5, 1.4, 2.4, 4.0, 5.0] {
            run.step_to(time).unwrap();
            let expected = match time {
                time if time < 1.0 => free(time),
                time if time < loses => slowed(time).max(0.0),
                _ => 1.5 * (time - loses) * (time - loses) / 0.4,
            };
            let found = value(&mut run, "wheel.omega");
            assert!((found - expected).abs() < 1e-9, "{engine:?} {time}: {found} {expected}");
        }
    }
}
