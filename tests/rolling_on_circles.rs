//! Contacts with circles that rub: discs that roll on a hill, in a bowl and on each other, slide, and lift off; against equations of motion written by hand.

use crate::support::run::{model, started, value};

/// A disc of 0.1 m about a fixed circle of 1 m, which it touches at this heading, rolling with this rate of it [rad/s].
pub fn disc(side: &str, mu: f64, [heading, rate]: [f64; 2]) -> String {
    let apart = if side == "inside" { 0.9 } else { 1.1 };
    let turning = if side == "inside" { -apart / 0.1 } else { apart / 0.1 } * rate;
    let (sine, cosine) = heading.sin_cos();
    let [x, y, vx, vy] = [apart * cosine, apart * sine, -apart * rate * sine, apart * rate * cosine];
    format!(
        r#"
name = "disc"
gravity = [0, -9.81]
[bodies.disc]
mass = 2.0
inertia = 0.01
[joints.hill]
type = "contact"
between = ["ground", "disc"]
circle = 1.0
radius = 0.1
side = "{side}"
friction = {{ mu = {mu} }}
[initial]
"disc.x" = {x:e}
"disc.y" = {y:e}
"disc.angle" = 0.0
"disc.vx" = {vx:e}
"disc.vy" = {vy:e}
"disc.omega" = {turning:e}
[outputs]
variables = ["disc.x", "disc.y", "disc.vx", "disc.vy", "disc.omega", "hill.fn", "hill.ft", "hill.mode", "hill.sliding", "hill.gap"]
[experiment]
stop = 3.0
tolerance = 1e-11
"#
    )
}

/// Classical Runge-Kutta steps.
fn run<const N: usize>(mut state: [f64; N], time: f64, slope: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let steps = (time / 1e-4).ceil().max(1.0);
    let h = time / steps;
    for _ in 0..steps as usize {
        let at = |k: [f64; N], share: f64| std::array::from_fn(|index| state[index] + share * h * k[index]);
        let k1 = slope(state);
        let k2 = slope(at(k1, 0.5));
        let k3 = slope(at(k2, 0.5));
        let k4 = slope(at(k3, 1.0));
        state = std::array::from_fn(|index| {
            state[index] + h / 6.0 * (k1[index] + 2.0 * (k2[index] + k3[index]) + k4[index])
        });
    }
    state
}

/// True above zero, and of what is not a number.
fn is_over(value: f64) -> bool {
    value.is_nan() || value > 0.0
}

/// From the top: theta'' = (2/3)(g/R) sin theta while it rolls, then against mu fn while it slides, until nothing presses.
#[test]
fn a_disc_rolls_off_a_hill_slides_and_lifts_off() {
    let (g, apart, mu) = (9.81, 1.1, 0.3);
    let rolling = |[angle, rate]: [f64; 2]| [rate, 2.0 / 3.0 * g / apart * angle.sin()];
    let presses = |[angle, rate]: [f64; 2]| g * angle.cos() - apart * rate * rate;
    let start = [10f64.to_radians(), 0.0];
    // When a third of the weight along the slope exceeds mu times what presses; by halving. Far beyond it the steps have no value.
    let ends = |slope: &dyn Fn([f64; 2]) -> [f64; 2], from: [f64; 2], over: &dyn Fn([f64; 2]) -> bool| {
        let [mut low, mut high] = [0.0, 2.0];
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if over(run(from, middle, slope)) { high = middle } else { low = middle }
        }
        low
    };
    let slips = ends(&rolling, start, &|state| is_over(g * state[0].sin() / 3.0 - mu * presses(state)));
    let at_slip = run(start, slips, rolling);
    let sliding = |[angle, rate]: [f64; 2]| [rate, (g * angle.sin() - mu * presses([angle, rate])) / apart];
    let lifts = ends(&sliding, at_slip, &|state| is_over(-presses(state)));
    let text = disc("outside", mu, [std::f64::consts::FRAC_PI_2 - start[0], 0.0]);
    let mut run_of = started(&model(&text), None, 3.0, 1e-11);
    for (time, state) in [
        (0.4, run(start, 0.4, rolling)),
        (slips - 1e-3, run(start, slips - 1e-3, rolling)),
        (slips + 0.5 * lifts, run(at_slip, 0.5 * lifts, sliding)),
        (slips + lifts - 1e-3, run(at_slip, lifts - 1e-3, sliding)),
    ] {
        run_of.step_to(time).unwrap();
        let found = ["disc.x", "disc.y", "disc.vx", "hill.fn"].map(|name| value(&mut run_of, name));
        let expected =
            [apart * state[0].sin(), apart * state[0].cos(), apart * state[1] * state[0].cos(), 2.0 * presses(state)];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{time}: {found}, {expected}");
        }
        assert_eq!(value(&mut run_of, "hill.sliding") != 0.0, time > slips, "{time}");
    }
    run_of.step_to(slips + lifts + 1e-3).unwrap();
    assert!(value(&mut run_of, "hill.mode") == 0.0 && value(&mut run_of, "hill.gap") > 0.0);
}

/// Round and round in a ring: it rolls over the heading at which a turn ends, and its energy stays.
#[test]
fn a_disc_rolls_through_all_headings() {
    let text = disc("inside", 3.0, [-1.0, 9.0]);
    let mut run = started(&model(&text), None, 3.0, 1e-11);
    let energy = |run: &mut _| {
        let mut of = |name: &str| value(run, name);
        let [vx, vy, omega, y] = ["disc.vx", "disc.vy", "disc.omega", "disc.y"].map(&mut of);
        vx * vx + vy * vy + 0.005 * omega * omega + 2.0 * 9.81 * y
    };
    let begin = energy(&mut run);
    let mut sides = [false; 2];
    for step in 1..=60 {
        run.step_to(0.05 * f64::from(step)).unwrap();
        let [x, y, sliding, vx, omega] =
            ["disc.x", "disc.y", "hill.sliding", "disc.vx", "disc.omega"].map(|name| value(&mut run, name));
        assert!((energy(&mut run) - begin).abs() < 1e-7, "{step}");
        assert_eq!(sliding, 0.0);
        // It rolls: the velocity along the ring is that of turning.
        assert!((vx * 0.9 - omega * 0.1 * y).abs() < 1e-8 && (x.hypot(y) - 0.9).abs() < 1e-9, "{step}");
        sides[usize::from(x < -0.6)] |= y.abs() < 0.5;
    }
    assert_eq!(sides, [true; 2]);
}

/// Two discs that turn about pins of their own, one on an arm, pressed together: whichever is called the circle, they do the same, and the one that is driven takes the other along.
#[test]
fn whichever_is_called_the_circle() {
    let scene = |contact: &str| {
        format!(
            r#"
name = "wheels"
gravity = [0, -9.81]
[ground.points]
arm = [-0.5, 0.3]
[bodies.wheel]
mass = 3.0
inertia = 0.05
[bodies.arm]
mass = 0.5
inertia = 0.01
points = {{ root = [-0.3, 0], tip = [0.3, 0] }}
[bodies.roller]
mass = 1.0
inertia = 0.004
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[joints.hinge]
type = "revolute"
between = ["ground.arm", "arm.root"]
[joints.pin]
type = "revolute"
between = ["arm.tip", "roller"]
[joints.touch]
type = "contact"
{contact}
friction = {{ mu = 0.4 }}
[loads.motor]
type = "torque"
on = "wheel"
value = "1.5*sin(3*t)"
[initial]
"wheel.omega" = 0.0
"arm.angle" = 0.1
"arm.omega" = 0.0
"roller.omega" = 6.0
[outputs]
variables = ["wheel.angle", "wheel.omega", "roller.omega", "arm.angle", "touch.mode"]
[experiment]
stop = 2.0
tolerance = 1e-11
"#
        )
    };
    let radii = [0.15, 0.12];
    let contact = |first: &str, second: &str, [circle, radius]: [f64; 2]| {
        format!("between = [\"{first}\", \"{second}\"]\ncircle = {circle}\nradius = {radius}")
    };
    let [mut one, mut other] = [contact("wheel", "roller", radii), contact("roller", "wheel", [radii[1], radii[0]])]
        .map(|text| started(&model(&scene(&text)), None, 2.0, 1e-11));
    let mut taken = false;
    for step in 1..=20 {
        let read = [&mut one, &mut other].map(|run| {
            run.step_to(0.1 * f64::from(step)).unwrap();
            ["wheel.angle", "wheel.omega", "roller.omega", "arm.angle", "touch.mode"].map(|name| value(run, name))
        });
        for (one, other) in read[0].iter().zip(read[1]) {
            assert!((one - other).abs() < 1e-8, "{step}: {read:?}");
        }
        // Rolling on each other they turn against each other.
        let slides = 0.15 * read[0][1] + 0.12 * read[0][2];
        taken |= read[0][4] == 1.0 && slides.abs() < 1e-9 && read[0][1].abs() > 0.1;
    }
    assert!(taken);
}
