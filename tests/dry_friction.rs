//! Dry friction that sticks, against closed forms and other formulations.

use crate::outside::command::cotree;
use crate::support::ROOT;
use crate::support::hard::random::Random;
use crate::support::linkage::linkage;
use crate::support::run::{model, scene_of, started, value};

use cotree::scene::Scene;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::Engine;

const METHODS: [Engine; 3] = [Engine::Dop853, Engine::Radau, Engine::Taylor];

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
            assert!(
                (found[0] - s).abs() < 1e-9 && (found[1] - v).abs() < 1e-8,
                "{engine:?} {ratio} {time}: {found:?} {s}"
            );
            let sliding = if v == 0.0 { 0.0 } else { v.signum() };
            assert_eq!(["guide.mode", "guide.sliding"].map(|name| value(&mut run, name)), [sliding; 2]);
            let force = if v == 0.0 { 120.0 * s } else { -2.0 * sliding };
            assert!((value(&mut run, "guide.force") - force).abs() < 1e-6, "{engine:?} {ratio} {time}");
        }
        assert_eq!(value(&mut run, "guide.v"), 0.0, "what sticks does not creep");
    }
}

/// A block on a belt that moves at 0.2 m/s, held by a spring.
pub const STICK_SLIP: &str = r#"
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

/// A block on a belt: its natural frequency, the speed of the belt, and how far the spring stretches by the level while it slips and at rest.
struct Belt {
    omega: f64,
    speed: f64,
    slips: f64,
    rests: f64,
}

impl Belt {
    /// How long it sticks, and how long it slips, once it does.
    fn phases(&self) -> [f64; 2] {
        let size = self.rests - self.slips;
        // x = a cos(w t) + (v/w) sin(w t): the rate is v again where w t = 2 pi - 2 atan(a w / v).
        let slips = 2.0 * (std::f64::consts::PI - (size * self.omega / self.speed).atan()) / self.omega;
        [2.0 * size / self.speed, slips]
    }

    /// Place and velocity of the block, which begins to stick at zero; no velocity against the belt where it sticks.
    fn at(&self, time: f64) -> ([f64; 2], bool) {
        let first = self.rests / self.speed;
        let [sticks, slips] = self.phases();
        let since = (time - first).rem_euclid(sticks + slips);
        if time < first {
            return ([self.speed * time, self.speed], true);
        }
        if since >= slips {
            return ([2.0 * self.slips - self.rests + self.speed * (since - slips), self.speed], true);
        }
        let (size, phase) = (self.rests - self.slips, self.omega * since);
        let swing = self.speed / self.omega;
        let place = self.slips + size * phase.cos() + swing * phase.sin();
        ([place, self.speed * phase.cos() - size * self.omega * phase.sin()], false)
    }
}

#[test]
fn stick_and_slip_repeat_with_their_period() {
    let stretch = 0.25 * 2.0 * 10.0 / 80.0;
    let belt = Belt { omega: (80.0_f64 / 2.0).sqrt(), speed: 0.2, slips: stretch, rests: 1.6 * stretch };
    let mut run = started(&model(STICK_SLIP), None, 400.0, 1e-10);
    for time in [0.3, 1.0, 1.7, 2.2, 50.0, 399.0] {
        run.step_to(time).unwrap();
        let ([place, rate], sticks) = belt.at(time);
        let found = ["block.x", "block.vx"].map(|name| value(&mut run, name));
        assert!((found[0] - place).abs() < 1e-9 && (found[1] - rate).abs() < 1e-8, "{time} {found:?} {place} {rate}");
        assert_eq!(value(&mut run, "slide.mode"), if sticks { 0.0 } else { -1.0 });
    }
}

/// Over 1000 s every period is that of the closed form: what begins to stick forgets every error but that of the time.
#[test]
fn a_thousand_seconds_of_stick_and_slip_keep_their_period() {
    let stretch = 0.25 * 2.0 * 10.0 / 80.0;
    let belt = Belt { omega: (80.0_f64 / 2.0).sqrt(), speed: 0.2, slips: stretch, rests: 1.6 * stretch };
    let period: f64 = belt.phases().iter().sum();
    let folder = tempfile::tempdir().unwrap();
    let text = STICK_SLIP.replace("stop = \"400 s\"", "stop = \"1000 s\"\nstep = 1");
    std::fs::write(folder.path().join("belt.toml"), text).unwrap();
    let output = cotree(folder.path(), &["simulate", "belt.toml", "--log", "log.csv"]);
    assert!(output.status.success());
    let log = std::fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let slips = log.lines().filter(|line| line.ends_with(",slips,"));
    let times: Vec<f64> = slips.map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(times.len(), 1 + ((1000.0 - belt.rests / belt.speed) / period) as usize);
    for pair in times.windows(2) {
        assert!((pair[1] - pair[0] - period).abs() < 1e-11, "{pair:?} {period}");
    }
    let last = belt.rests / belt.speed + period * (times.len() - 1) as f64;
    assert!((times[times.len() - 1] - last).abs() < 1e-9, "{times:?}");
}

/// The model of the gallery: every output by its closed form.
#[test]
fn the_block_on_a_belt_follows_its_closed_form() {
    let weight = 1.5 * 9.81;
    let stretch = 0.3 * weight / 60.0;
    let belt = Belt { omega: (60.0_f64 / 1.5).sqrt(), speed: 0.2, slips: stretch, rests: 1.5 * stretch };
    let names = ["block.x", "block.vx", "rubbing.force", "rubbing.sliding", "rubbing.fn"];
    let rows = (0..=500).map(|row| {
        let time = 0.01 * f64::from(row);
        let ([place, rate], sticks) = belt.at(time);
        let force = if sticks { 60.0 * place } else { 0.3 * weight };
        [time, place, rate, force, if sticks { 0.0 } else { -1.0 }, weight]
    });
    let rows: Vec<[f64; 6]> = rows.collect();
    let file = format!("{ROOT}/models/stick_slip/expected.csv");
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let digits = |value: &f64| format!("{value:.14e}").parse::<f64>().unwrap().to_string();
        let line = |row: &[f64; 6]| row.iter().map(digits).collect::<Vec<_>>().join(",") + "\n";
        let table: String = rows.iter().map(line).collect();
        std::fs::write(&file, format!("time,{}\n{table}", names.join(","))).unwrap();
    }
    let text = std::fs::read_to_string(&file).unwrap();
    let stored = text.lines().skip(1).map(|line| line.split(',').map(|own| own.parse::<f64>().unwrap()).collect());
    let stored: Vec<Vec<f64>> = stored.collect();
    assert_eq!(stored.len(), rows.len());
    let mut run = started(&model(&scene_of("stick_slip")), None, 5.0, 1e-10);
    for (row, stored) in rows.iter().zip(&stored) {
        if row[0] > 0.0 {
            run.step_to(row[0]).unwrap();
        }
        for ((name, expected), stored) in names.iter().zip(&row[1..]).zip(&stored[1..]) {
            let found = value(&mut run, name);
            assert!((found - expected).abs() < 1e-8, "{name} at {} s: {found}, expected {expected}", row[0]);
            assert!((stored - expected).abs() < 1e-12, "{name} at {} s: stored {stored}", row[0]);
        }
    }
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
            assert!(
                (0..2).all(|index| (found[index] - expected[index]).abs() < 1e-8),
                "{engine:?} {time} {found:?} {expected:?}"
            );
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
    // Nothing is assumed of its friction, as it is of a disc that cannot slide.
    let needed = |joint: &str| cotree_study::contact::of_experiment(&Scene::from_toml(&disc(joint)).unwrap()).needed;
    assert_eq!(needed(rolling), Vec::<String>::new());
    let contact = rolling.replace("rolling", "contact");
    let (slows, turns) = (0.2 * 9.81, 2.0 * 0.2 * 9.81 / 0.1);
    let rolls = 6.0 / (3.0 * slows);
    for (joint, engine) in [rolling, &contact].into_iter().flat_map(|joint| METHODS.map(|engine| (joint, engine))) {
        let text = if joint == rolling {
            disc(joint)
        } else {
            disc(joint).replace("[initial]", "[initial]\n\"disc.y\" = 0.1")
        };
        let text = if joint == rolling {
            text
        } else {
            text.replace("\"lane.s\" = 0.0", "\"disc.angle\" = 0.0\n\"disc.x\" = 0.0\n\"disc.vy\" = 0.0")
        };
        let mut run = started(&model(&text), Some(engine), 3.0, 1e-10);
        for time in [0.4, rolls + 0.05, 2.5] {
            run.step_to(time).unwrap();
            let since = time.min(rolls);
            let speed = 6.0 - slows * since;
            let x = 6.0 * since - 0.5 * slows * since * since + (time - since) * speed;
            let slides = time < rolls;
            let expected = [
                x,
                speed,
                -turns * since,
                3.0 * 9.81,
                if slides { -0.2 * 3.0 * 9.81 } else { 0.0 },
                f64::from(u8::from(slides)),
            ];
            let names = ["disc.x", "disc.vx", "disc.omega", "lane.fn", "lane.ft", "lane.sliding"];
            let found = names.map(|name| value(&mut run, name));
            assert!(
                (0..6).all(|index| (found[index] - expected[index]).abs() < 1e-8),
                "{engine:?} {time} {found:?} {expected:?}"
            );
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
            assert!((found - expected).abs() < 1e-8, "{engine:?} {time}: {found} {expected}");
        }
    }
}

/// A ball with spin strikes the floor.
fn spinning(mu: f64, omega: f64) -> String {
    format!(
        r#"
name = "spinning"
gravity = [0, -9.81]
[bodies.ball]
mass = 2.0
inertia = "0.4*2*0.1^2"
[joints.lane]
type = "contact"
between = ["ground", "ball"]
axis = [1, 0]
radius = 0.1
restitution = 0.7
friction = {{ mu = {mu} }}
[initial]
"ball.x" = 0.0
"ball.y" = 1.1
"ball.vx" = 3.0
"ball.vy" = 0.0
"ball.omega" = {omega:?}
[outputs]
variables = ["ball.vx", "ball.vy", "ball.omega", "lane.impulse", "lane.v"]
[experiment]
stop = "0.6 s"
tolerance = 1e-10
"#
    )
}

#[test]
fn an_impact_rubs() {
    let came = (2.0 * 9.81_f64).sqrt();
    let impulse = 2.0 * 1.7 * came;
    let (mass, inertia, r) = (2.0_f64, 0.4 * 2.0 * 0.01, 0.1);
    for (mu, omega) in [(0.05, 0.0), (0.05, -80.0), (0.4, 0.0), (0.4, 15.0), (0.0, 5.0)] {
        // v + r omega, the rate of the touching point, has the mass 1 / (1/m + r^2/I) along the floor.
        let slip: f64 = 3.0 + r * omega;
        let stops: f64 = slip / (1.0 / mass + r * r / inertia);
        let along = -stops.clamp(-mu * impulse, mu * impulse);
        let expected =
            [3.0 + along / mass, 0.7 * came - 9.81 * (0.5 - (2.0 / 9.81_f64).sqrt()), omega + r * along / inertia];
        let mut run = started(&model(&spinning(mu, omega)), None, 0.6, 1e-10);
        run.step_to(0.5).unwrap();
        let found = ["ball.vx", "ball.vy", "ball.omega"].map(|name| value(&mut run, name));
        assert!(
            (0..3).all(|index| (found[index] - expected[index]).abs() < 1e-9),
            "{mu} {omega}: {found:?} {expected:?}"
        );
        assert!((value(&mut run, "lane.impulse") - impulse).abs() < 1e-9);
    }
}

/// A motor, a worm, a wheel with a load, all on pins.
fn worm(mu: f64, motor: f64, load: f64) -> String {
    format!(
        r#"
name = "worm"
[ground.points]
right = [0.2, 0]
[bodies.worm]
mass = 1.0
inertia = 0.002
[bodies.wheel]
mass = 2.0
inertia = 0.05
[joints.first]
type = "revolute"
between = ["ground", "worm"]
[joints.second]
type = "revolute"
between = ["ground.right", "wheel"]
[joints.mesh]
type = "gear"
between = ["worm", "wheel"]
ratio = 0.05
friction = {{ mu = {mu} }}
[loads.motor]
type = "torque"
on = "worm"
value = {motor:?}
[loads.load]
type = "torque"
on = "wheel"
value = {load:?}
[initial]
"worm.omega" = 0.0
[outputs]
variables = ["worm.omega", "worm.alpha", "mesh.torque", "mesh.sliding"]
[experiment]
stop = "1 s"
tolerance = 1e-10
"#
    )
}

#[test]
fn a_mesh_rubs_and_locks_itself() {
    // With the mesh torque T on the wheel: 0.05 alpha I2 = T + load; I1 alpha = motor - 0.05 T - mu |0.05 T| sign(omega).
    let (first, second, ratio) = (0.002, 0.05, 0.05_f64);
    let alpha = |mu: f64, motor: f64, load: f64, direction: f64| {
        let of = |sign: f64| {
            // T = ratio alpha I2 - load; the friction is mu sign ratio T direction.
            let share = ratio * (1.0 + mu * sign * direction);
            let alpha = (motor + share * load) / (first + share * ratio * second);
            (alpha, (ratio * alpha * second - load) * sign >= 0.0)
        };
        [1.0, -1.0].into_iter().map(of).find(|(_, fits)| *fits).unwrap().0
    };
    for (mu, motor, load, direction) in
        [(0.1, 2.0, -10.0, 1.0), (0.1, 0.0, -10.0, -1.0), (1.5, 3.0, -10.0, 1.0), (1.5, -0.6, -10.0, -1.0)]
    {
        let mut run = started(&model(&worm(mu, motor, load)), None, 1.0, 1e-10);
        run.step_to(0.5).unwrap();
        let expected = alpha(mu, motor, load, direction);
        assert!(expected * direction > 0.0, "{expected}");
        let found = value(&mut run, "worm.omega");
        assert!(
            (found - 0.5 * expected).abs() < 1e-9 * (1.0 + expected.abs()),
            "{mu} {motor} {load}: {found} {expected}"
        );
    }
    // The load alone cannot drive it.
    for load in [-10.0, 10.0, 1e4] {
        let mut run = started(&model(&worm(1.5, 0.0, load)), None, 1.0, 1e-10);
        run.step_to(1.0).unwrap();
        assert!(value(&mut run, "worm.omega").abs() < 1e-12 * (1.0 + load.abs()));
        assert!((value(&mut run, "mesh.torque") + load).abs() < 1e-9 * load.abs());
    }
}

/// A nut on a square thread under a weight, its spindle free to turn: it runs down if the thread is steeper than its friction.
#[test]
fn a_thread_holds_its_nut_or_lets_it_run() {
    let (lead, radius, mass, inertia, g) = (0.02_f64, 0.008, 5.0, 1e-3, 9.81);
    let slope = lead / (std::f64::consts::TAU * radius);
    for mu in [0.0, 0.1, 0.3, 0.39, 0.41, 0.8] {
        let text = format!(
            r#"
name = "thread"
gravity = [0, -9.81]
[bodies.spindle]
mass = 1.0
inertia = 1e-3
[bodies.nut]
mass = 5.0
[joints.bearing]
type = "revolute"
between = ["ground", "spindle"]
[joints.rail]
type = "prismatic"
between = ["ground", "nut"]
axis = [0, 1]
[joints.thread]
type = "screw"
between = ["spindle", "nut"]
axis = [0, 1]
lead = "20 mm"
friction = {{ mu = {mu}, radius = "8 mm" }}
[initial]
"spindle.omega" = 0.0
[outputs]
variables = ["spindle.omega", "nut.vy", "thread.force", "thread.sliding"]
[experiment]
stop = "1 s"
tolerance = 1e-10
"#
        );
        let mut run = started(&model(&text), None, 1.0, 1e-10);
        run.step_to(0.4).unwrap();
        // Down the thread: the torque by the force of the nut is F r (tan(slope) - mu) / (1 + mu tan(slope)).
        let lever = radius * (slope - mu) / (1.0 + mu * slope);
        let advance = lead / std::f64::consts::TAU;
        let alpha = if lever > 0.0 { -mass * g * lever / (inertia + mass * advance * lever) } else { 0.0 };
        let found = value(&mut run, "spindle.omega");
        assert!(
            (found - 0.4 * alpha).abs() < 1e-9 * (1.0 + alpha.abs()),
            "{mu} (slope {slope}): {found} {}",
            0.4 * alpha
        );
    }
}

/// Painleve's rod slides on the floor at one end: with too much friction no motion fits, or two do.
#[test]
fn the_rod_of_painleve_is_refused_beyond_its_limit() {
    let (sin, cos) = 1.0471975511965976_f64.sin_cos();
    let rod = |mu: f64, omega: f64| {
        format!(
            r#"
name = "rod"
gravity = [0, -9.81]
[bodies.rod]
mass = 1.0
inertia = "2^2/12"
points = {{ low = [-1, 0] }}
[joints.lane]
type = "contact"
between = ["ground", "rod.low"]
axis = [1, 0]
friction = {{ mu = {mu} }}
[initial]
"rod.angle" = 1.0471975511965976
"rod.x" = {cos:?}
"rod.y" = {sin:?}
"rod.vx" = {:?}
"rod.vy" = {:?}
"rod.omega" = {omega:?}
[outputs]
variables = ["rod.angle", "lane.fn", "lane.mode"]
[experiment]
stop = "0.01 s"
tolerance = 1e-8
"#,
            -1.0 - omega * sin,
            omega * cos,
        )
    };
    // For a rod of this inertia: 1 + 3 cos^2 - 3 mu sin cos > 0 of the angle, here mu < 1.347...
    let limit = (1.0 + 3.0 * cos * cos) / (3.0 * sin * cos);
    for (mu, omega, begins) in
        [(0.5, 0.0, true), (limit - 1e-6, 0.0, true), (limit + 1e-6, 0.0, false), (2.0, 0.0, false), (2.0, -4.0, false)]
    {
        let mut run = cotree_fmu::instance::Instance::new(model(&rod(mu, omega)));
        let begun = run.initialise();
        assert_eq!(begun.is_ok(), begins, "{mu} {omega} {begun:?}");
        if let Err(failure) = begun {
            let text = failure.to_string();
            assert!(text.contains("lane") && text.contains("friction"), "{text}");
        }
    }
}

/// A drawer whose guide is pushed off its middle jams, however hard the push is.
#[test]
fn a_drawer_jams_where_its_guide_is_short() {
    let drawer = |arm: f64, push: f64| {
        format!(
            r#"
name = "drawer"
[bodies.drawer]
mass = 2.0
inertia = 0.1
points = {{ knob = [0, {arm:?}] }}
[joints.guide]
type = "prismatic"
between = ["ground", "drawer"]
axis = [1, 0]
friction = {{ mu = 0.45, length = "0.4 m" }}
limits = {{ max = "0.3 m" }}
[loads.push]
type = "force"
on = "drawer.knob"
vector = [{push:?}, 0]
[initial]
"guide.s" = 0.0
"guide.v" = 0.0
[outputs]
variables = ["guide.s", "guide.v", "guide.mode", "guide.sliding", "guide.stop"]
[experiment]
stop = "2 s"
tolerance = 1e-10
"#
        )
    };
    // mu x 2 T / length = 0.45 x 2 x 0.5 / 0.4 > 1 of the push.
    for push in [1.0, 20.0, 1e5] {
        let mut run = started(&model(&drawer(0.5, push)), None, 2.0, 1e-10);
        run.step_to(2.0).unwrap();
        assert_eq!(["guide.s", "guide.v"].map(|name| value(&mut run, name)), [0.0; 2]);
    }
    let mut run = started(&model(&drawer(0.2, 20.0)), None, 2.0, 1e-10);
    let slides = 20.0 * (1.0 - 0.45 * 2.0 * 0.2 / 0.4) / 2.0;
    run.step_to(0.2).unwrap();
    assert!((value(&mut run, "guide.v") - slides * 0.2).abs() < 1e-10, "{}", value(&mut run, "guide.v"));
    // At its stop it stays.
    run.step_to(2.0).unwrap();
    assert!((value(&mut run, "guide.s") - 0.3).abs() < 1e-12);
    assert_eq!(["guide.v", "guide.mode", "guide.sliding"].map(|name| value(&mut run, name)), [0.0, 1.0, 0.0]);
}

/// A chain of blocks on a line, each on the one before with friction, a spring to the wall and a load that swings.
struct Chain {
    masses: Vec<f64>,
    levels: Vec<[f64; 2]>,
    springs: Vec<f64>,
    loads: Vec<[f64; 2]>,
}

impl Chain {
    fn random(seed: u64) -> Self {
        let mut random = Random(seed + 1);
        let count = 1 + (seed % 4) as usize;
        let mut list = |least: f64, most: f64| (0..count).map(|_| random.between(least, most)).collect::<Vec<f64>>();
        let (masses, levels, ratios) = (list(0.3, 5.0), list(0.2, 6.0), list(0.6, 2.0));
        let (springs, sizes, rates) = (list(0.0, 60.0), list(0.5, 12.0), list(1.0, 9.0));
        let levels = levels.iter().zip(&ratios).map(|(&level, &ratio)| [level, ratio.max(1.0)]).collect();
        let loads = sizes.iter().zip(&rates).map(|(&size, &rate)| [size, rate]).collect();
        Self { masses, levels, springs, loads }
    }

    fn scene(&self) -> String {
        let mut text = String::from("name = \"chain\"\n[ground.points]\nwall = [-50, 0]\n");
        let (mut initial, mut before) = (String::from("[initial]\n"), "ground".to_owned());
        for (index, mass) in self.masses.iter().enumerate() {
            let [level, ratio] = self.levels[index];
            let [size, rate] = self.loads[index];
            let spring = self.springs[index];
            text += &format!(
                r#"
[bodies.b{index}]
mass = {mass:?}
[joints.j{index}]
type = "prismatic"
between = ["{before}", "b{index}"]
axis = [1, 0]
friction = {{ coulomb = {level:?}, static = {ratio:?} }}
[loads.s{index}]
type = "spring"
between = ["ground.wall", "b{index}"]
stiffness = {spring:?}
length = 50
[loads.l{index}]
type = "force"
on = "b{index}"
vector = ["{size:?}*sin({rate:?}*t + {index})", 0]
"#
            );
            initial += &format!("\"j{index}.s\" = 0.0\n\"j{index}.v\" = 0.0\n");
            before = format!("b{index}");
        }
        let outputs = (0..self.masses.len())
            .map(|i| format!("\"b{i}.x\", \"b{i}.vx\", \"j{i}.v\", \"j{i}.force\", \"j{i}.sliding\""));
        let outputs = outputs.collect::<Vec<_>>().join(", ");
        text + &initial
            + &format!("[outputs]\nvariables = [{outputs}]\n[experiment]\nstop = \"3 s\"\ntolerance = 1e-10\n")
    }

    /// What moves a block beside the friction at both its sides.
    fn load(&self, block: usize, x: f64, time: f64) -> f64 {
        let [size, rate] = self.loads[block];
        size * (rate * time + block as f64).sin() - self.springs[block] * x
    }
}

/// The law of friction and the balance of momentum at every millisecond determine the motion: so they prove it, whatever has found it.
#[test]
fn random_chains_obey_the_law_of_friction_and_newtons() {
    let mut seen = [0, 0];
    for seed in 0..12 {
        let chain = Chain::random(seed);
        let count = chain.masses.len();
        let method = METHODS[seed as usize % METHODS.len()];
        let mut run = started(&model(&chain.scene()), Some(method), 3.0, 1e-10);
        let rows = (0..=1500).map(|row| {
            let time = 1e-3 * f64::from(row);
            if time > 0.0 {
                run.step_to(time).unwrap();
            }
            let of = |run: &mut cotree_fmu::instance::Instance, block: usize| {
                [
                    format!("b{block}.x"),
                    format!("b{block}.vx"),
                    format!("j{block}.v"),
                    format!("j{block}.force"),
                    format!("j{block}.sliding"),
                ]
                .map(|name| value(run, &name))
            };
            (0..count).map(|block| of(&mut run, block)).collect::<Vec<[f64; 5]>>()
        });
        let rows: Vec<Vec<[f64; 5]>> = rows.collect();
        for (row, now) in rows.iter().enumerate() {
            for (block, &[_, _, rate, force, sliding]) in now.iter().enumerate() {
                let [level, ratio] = chain.levels[block];
                if sliding == 0.0 {
                    seen[0] += 1;
                    assert!(
                        rate.abs() < 1e-10 && force.abs() <= level * ratio * (1.0 + 1e-9),
                        "{seed} {row} {rate} {force}"
                    );
                } else {
                    seen[1] += 1;
                    assert!(
                        rate * sliding >= -1e-9 && (force + level * sliding).abs() < 1e-9,
                        "{seed} {row} {rate} {force}"
                    );
                }
            }
        }
        for (row, three) in rows.windows(3).enumerate() {
            let steady = (0..count).all(|block| three.iter().all(|now| now[block][4] == three[0][block][4]));
            for block in (0..count).filter(|_| steady) {
                let total = |place: usize| {
                    let time = 1e-3 * (row + place) as f64;
                    let next = three[place].get(block + 1).map_or(0.0, |next| next[3]);
                    chain.load(block, three[place][block][0], time) + three[place][block][3] - next
                };
                let pushed = 1e-3 / 3.0 * (total(0) + 4.0 * total(1) + total(2));
                let gained = chain.masses[block] * (three[2][block][1] - three[0][block][1]);
                // The implicit method reads rates within a step from a polynomial of its order.
                let allowed = if method == Engine::Radau { 1e-7 } else { 1e-8 };
                assert!((pushed - gained).abs() < allowed, "{seed} {row} {block}: {pushed} {gained}");
            }
        }
    }
    assert!(seen.iter().all(|count| *count > 1000), "{seen:?}");
}

/// Two links with friction in both pins by the force that they carry: coordinates, trees and methods are different ways to the same motion.
#[test]
fn trees_and_methods_agree_on_pins_that_rub() {
    let text = |preset: &str, mu: f64| {
        format!(
            r#"
name = "links"
gravity = [0, -9.81]
[bodies.upper]
mass = 1.2
inertia = 0.02
points = {{ a = [-0.2, 0], b = [0.25, 0] }}
[bodies.lower]
mass = 0.7
inertia = 0.01
points = {{ a = [-0.15, 0] }}
[joints.first]
type = "revolute"
between = ["ground", "upper.a"]
friction = {{ mu = {mu}, radius = "30 mm" }}
[joints.second]
type = "revolute"
between = ["upper.b", "lower.a"]
friction = {{ mu = {mu}, radius = "20 mm", static = 1.2 }}
[initial]
"upper.angle" = "20 deg"
"upper.omega" = 2.0
"lower.angle" = "-40 deg"
"lower.omega" = -3.0
[coordinates]
preset = "{preset}"
[outputs]
variables = ["upper.angle", "lower.angle", "first.fx", "second.fy", "first.torque", "second.sliding", "energy.total"]
[experiment]
stop = "5 s"
tolerance = 1e-11
"#
        )
    };
    for mu in [0.2, 0.6] {
        let mut runs: Vec<_> = ["recommended", "absolute", "joint"]
            .into_iter()
            .flat_map(|preset| METHODS.map(|engine| started(&model(&text(preset, mu)), Some(engine), 5.0, 1e-11)))
            .collect();
        let mut energy = f64::INFINITY;
        for time in [0.2, 0.5, 0.9, 1.4, 2.0, 5.0] {
            let rows = runs.iter_mut().map(|run| {
                run.step_to(time).unwrap();
                let names = [
                    "upper.angle",
                    "lower.angle",
                    "first.fx",
                    "second.fy",
                    "first.torque",
                    "second.sliding",
                    "energy.total",
                ];
                names.map(|name| value(run, name))
            });
            let rows: Vec<[f64; 7]> = rows.collect();
            for row in &rows[1..] {
                assert!(
                    (0..7).all(|index| (row[index] - rows[0][index]).abs() < 1e-6),
                    "{mu} {time} {row:?} {:?}",
                    rows[0]
                );
            }
            assert!(rows[0][6] <= energy + 1e-9, "friction takes energy");
            energy = rows[0][6];
        }
    }
}

/// Places and rates of the blocks at so many times, at a tolerance.
fn chain_at(chain: &Chain, method: Engine, tolerance: f64) -> Result<Vec<f64>, InstanceError> {
    let mut run = started(&model(&chain.scene()), Some(method), 3.0, tolerance);
    let mut found = Vec::new();
    for time in 1..=15 {
        run.step_to(0.1 * f64::from(time))?;
        for block in 0..chain.masses.len() {
            found.extend(["x", "vx"].map(|own| value(&mut run, &format!("b{block}.{own}"))));
        }
    }
    Ok(found)
}

/// The largest error of a chain at each of these tolerances, by that tolerance; the finest run is the reference, and obeys the law of friction and momentum as the chains above.
fn chain_errors(seed: u64, tolerances: &[f64]) -> Vec<f64> {
    let chain = Chain::random(seed);
    let method = METHODS[seed as usize % METHODS.len()];
    let reference = chain_at(&chain, Engine::Dop853, 1e-12).unwrap_or_else(|refused| panic!("{seed}: {refused}"));
    let error = |&tolerance: &f64| {
        let found = match chain_at(&chain, method, tolerance) {
            Ok(found) => found,
            Err(refused) => {
                println!("{seed} at {tolerance:e}: {refused}");
                return f64::INFINITY;
            }
        };
        let errors = found.iter().zip(&reference).map(|(one, other)| (one - other).abs() / (1.0 + other.abs()));
        errors.fold(0.0, f64::max) / tolerance
    };
    tolerances.iter().map(error).collect()
}

/// What a run at a tolerance may be off by after it has stuck and slid many times, in tolerances: each change of mode passes on the error of its step.
const CHAIN_ERROR: f64 = 1e4;

#[test]
fn random_chains_are_as_exact_as_was_asked_for() {
    for seed in 100..104 {
        for error in chain_errors(seed, &[1e-5, 1e-7, 1e-9]) {
            assert!(error < CHAIN_ERROR, "{seed}: {error} tolerances");
        }
    }
}

#[test]
#[ignore = "takes many minutes: .ci/nightly runs it"]
fn all_random_chains() {
    let tolerances: Vec<f64> = (4..12).map(|digits| 10f64.powi(-digits)).collect();
    let seeds = std::env::var("COTREE_CHAINS").ok().and_then(|count| count.parse().ok()).unwrap_or(1000);
    let (mut largest, mut wrong, mut refused) = (vec![0.0; tolerances.len()], Vec::new(), 0);
    for seed in 1000..1000 + seeds {
        for ((most, error), tolerance) in largest.iter_mut().zip(chain_errors(seed, &tolerances)).zip(&tolerances) {
            if error.is_infinite() {
                refused += 1;
                continue;
            }
            *most = f64::max(*most, error);
            wrong.extend((error >= CHAIN_ERROR).then_some((seed, *tolerance, error)));
        }
    }
    println!("{seeds} chains, {refused} runs refused, largest errors in tolerances: {largest:.2?}");
    // By the implicit method alone: where something turns for less than a step, or again and again.
    assert!(refused <= seeds / 50, "{refused} of {seeds}");
    assert!(wrong.is_empty(), "seeds, tolerances, errors in tolerances: {wrong:.0?}");
}

/// Four pins hold a linkage of one freedom: one of them sticks, or the equations of what sticks would depend on each other.
#[test]
fn a_linkage_stays_where_its_pins_hold_it() {
    for (torque, holds) in [(3.0, true), (3.5, true), (5.0, false)] {
        let mut run = started(&model(&linkage(torque)), None, 0.5, 1e-9);
        run.step_to(0.5).unwrap();
        let moved = value(&mut run, "crank.angle") - 50f64.to_radians();
        assert!(if holds { moved.abs() < 1e-12 } else { moved > 0.1 }, "{torque}: {moved}");
    }
}

/// A four-bar with friction in all pins.
fn rubbing_four_bar(mu: f64, more: &str) -> String {
    let pin = |name: &str, ends: &str| {
        format!(
            "[joints.{name}]\ntype = \"revolute\"\nbetween = {ends}\nfriction = {{ mu = {mu}, radius = \"12 mm\" }}\n"
        )
    };
    let body = |name: &str, [mass, inertia, half]: [f64; 3]| {
        format!(
            "[bodies.{name}]\nmass = {mass}\ninertia = {inertia}\npoints = {{ a = [{}, 0], b = [{half}, 0] }}\n",
            -half
        )
    };
    format!(
        "name = \"four_bar\"\ngravity = [0, -9.81]\n[ground.points]\nright = [0.66, 0.05]\n{}{}{}{}{}{}{}{more}\n[initial]\n\"crank.angle\" = \"40 deg\"\n\"crank.omega\" = 10.0\n\"coupler.angle\" = {{ guess = \"20 deg\" }}\n\"rocker.angle\" = {{ guess = \"75 deg\" }}\n[outputs]\nvariables = [\"crank.angle\", \"p2.fx\", \"p3.fy\", \"p1.torque\", \"energy.total\"]\n[experiment]\nstop = 1\n",
        body("crank", [0.7, 0.005, 0.14]),
        body("coupler", [1.5, 0.08, 0.38]),
        body("rocker", [1.1, 0.03, 0.29]),
        pin("p1", "[\"ground\", \"crank.a\"]"),
        pin("p2", "[\"crank.b\", \"coupler.a\"]"),
        pin("p3", "[\"coupler.b\", \"rocker.b\"]"),
        pin("p4", "[\"ground.right\", \"rocker.a\"]"),
    )
}

#[test]
fn a_four_bar_whose_pins_rub_moves_alike_by_series_and_by_other_methods() {
    for mu in [0.05, 0.2, 0.4] {
        let model = model(&rubbing_four_bar(mu, ""));
        assert_eq!(model.program().engine, Engine::Taylor);
        for (tolerance, allowed) in [(1e-4, 1e-2), (1e-6, 1e-4), (1e-8, 1e-6), (1e-11, 1e-8)] {
            let engines = [None, Some(Engine::Dop853), Some(Engine::Radau)];
            let finest = f64::min(tolerance, 1e-9);
            let mut runs =
                engines.map(|engine| started(&model, engine, 1.0, if engine.is_none() { tolerance } else { finest }));
            for time in [0.05, 0.31, 0.5, 0.77, 1.0] {
                let rows = runs.each_mut().map(|run| {
                    run.step_to(time).unwrap();
                    ["crank.angle", "p2.fx", "p3.fy", "p1.torque", "energy.total"].map(|name| value(run, name))
                });
                for other in &rows[1..] {
                    for (one, other) in rows[0].iter().zip(other) {
                        let off = (one - other).abs() / (1.0 + other.abs());
                        assert!(off < allowed, "{mu} {tolerance:e} {time}: {rows:?}");
                    }
                }
            }
        }
    }
}

/// The load is zero at small rates, so that a normal force without it would be right in most states.
#[test]
fn a_load_that_begins_at_a_rate_is_in_the_normal_forces() {
    let load = "[loads.air]\ntype = \"force\"\non = \"coupler.b\"\nvector = [\"-20*max(crank.omega - 3, 0)\", 0]\n";
    let model = model(&rubbing_four_bar(0.3, load));
    assert_eq!(model.program().engine, Engine::Taylor);
    let mut runs = [None, Some(Engine::Dop853)].map(|engine| started(&model, engine, 0.5, 1e-9));
    for time in [0.1, 0.25, 0.5] {
        let rows = runs.each_mut().map(|run| {
            run.step_to(time).unwrap();
            ["crank.angle", "p2.fx", "p3.fy", "energy.total"].map(|name| value(run, name))
        });
        for (one, other) in rows[0].iter().zip(&rows[1]) {
            assert!((one - other).abs() < 1e-6 * (1.0 + other.abs()), "{time}: {rows:?}");
        }
    }
    // The steps are those of the series: accelerations without the load would differ, and each step be left to another method.
    let [series, explicit] = runs.map(|run| run.statistics());
    assert!(4 * series.evaluations < explicit.evaluations, "{series:?} {explicit:?}");
    assert_eq!(series.fallbacks, 0, "{series:?}");
}

#[test]
fn friction_next_to_hard_stops_is_integrated_by_runge_kutta_steps() {
    let stop = "[bodies.free]\nmass = 1.0\n[joints.slide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"free\"]\naxis = [1, 0]\nlimits = { max = 1 }\n";
    assert_eq!(model(&rubbing_four_bar(0.1, stop)).program().engine, Engine::Dop853);
}
