//! Several frictions on one degree of freedom, and friction beside stops, contacts, ropes and freewheels, against one equation of motion for the degree of freedom
//! ([`crate::support::one_freedom_with_friction`]).

use crate::one_sided::integrate_to_events;
use crate::support::hard::random::Random;
use crate::support::one_freedom_with_friction::Moving;
use crate::support::run::{model, started, value};

use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::program::Engine;

const METHODS: [Engine; 2] = [Engine::Dop853, Engine::Radau];
const TOLERANCES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];
const STOP: f64 = 3.0;
/// What a run may be off by, in tolerances, and what the reference is exact to.
const ALLOWED: f64 = 1e3;
const REFERENCE: f64 = 1e-6;
const GRAVITY: f64 = 9.81;

/// A load: a ramp, a sine, and a jump.
#[derive(Clone, Copy)]
struct Law {
    start: f64,
    ramp: f64,
    size: f64,
    rate: f64,
    jump: [f64; 2],
}

impl Law {
    /// Of about a size: from either side.
    fn random(random: &mut Random, size: f64) -> Self {
        let kind = random.next() % 4;
        let mut signed = |most: f64| random.between(-most, most) * size;
        let [start, ramp, swing, jump] = [signed(0.8), signed(1.5), signed(2.0), signed(2.5)];
        let has = |kinds: &[u64], value: f64| if kinds.contains(&kind) { value } else { 0.0 };
        Self {
            start: has(&[1, 2, 3], start),
            ramp: has(&[0, 3], ramp),
            size: has(&[1, 3], swing),
            rate: random.between(0.8, 6.0),
            jump: [random.between(0.3, 2.0), has(&[2, 3], jump)],
        }
    }

    fn at(&self, t: f64) -> f64 {
        let jump = if t < self.jump[0] { 0.0 } else { self.jump[1] };
        self.start + self.ramp * t + self.size * (self.rate * t).sin() + jump
    }

    fn text(&self) -> String {
        let Self { start, ramp, size, rate, jump: [time, jump] } = self;
        format!("{start:?} + {ramp:?}*t + {size:?}*sin({rate:?}*t) + if(t < {time:?}, 0, {jump:?})")
    }
}

/// A scene, the names of its place and rate, and the same as one equation.
struct Case {
    scene: String,
    names: [&'static str; 2],
    begin: [f64; 2],
    moving: Moving,
}

fn scene(parts: &str, initial: &str, names: [&str; 2]) -> String {
    format!(
        "name = \"one_freedom\"\n{parts}\n[initial]\n{initial}\n[outputs]\nvariables = [\"{}\", \"{}\"]\n[experiment]\nstop = \"3 s\"\n",
        names[0], names[1]
    )
}

/// A wheel with two to four brakes, perhaps with a freewheel.
fn wheel(random: &mut Random) -> Case {
    let inertia = random.between(0.3, 3.0);
    let levels: Vec<f64> = (0..2 + random.next() % 3).map(|_| random.between(0.5, 8.0)).collect();
    let level: f64 = levels.iter().sum();
    let law = Law::random(random, level);
    let rates = [[f64::NEG_INFINITY, f64::INFINITY], [0.0, f64::INFINITY], [f64::NEG_INFINITY, 0.0]]
        [(random.next() % 3) as usize];
    let mut parts = format!(
        "[bodies.wheel]\nmass = 1\ninertia = {inertia:?}\n[joints.axle]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\n[loads.motor]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"{}\"\n",
        law.text()
    );
    for (index, level) in levels.iter().enumerate() {
        parts +=
            &format!("[joints.b{index}]\ntype = \"brake\"\nbetween = [\"ground\", \"wheel\"]\nlevel = {level:?}\n");
    }
    if rates[0] == 0.0 || rates[1] == 0.0 {
        let way = if rates[0] == 0.0 { "" } else { "direction = \"clockwise\"\n" };
        parts += &format!("[joints.free]\ntype = \"one_way\"\nbetween = [\"ground\", \"wheel\"]\n{way}");
    }
    let begin = if random.next().is_multiple_of(2) {
        0.0
    } else {
        random.between(0.5, 3.0) * if rates[1] == 0.0 { -1.0 } else { 1.0 }
    };
    let names = ["wheel.angle", "wheel.omega"];
    let moving = Moving {
        slides: Box::new(move |t, _, _, direction| (law.at(t) - direction * level) / inertia),
        rests: Box::new(move |t, _| [law.at(t), level]),
        stops: [f64::NEG_INFINITY, f64::INFINITY],
        restitution: 0.0,
        rates,
        jumps: vec![law.jump[0]],
    };
    Case {
        scene: scene(&parts, &format!("\"axle.angle\" = 0.0\n\"axle.omega\" = {begin:?}"), names),
        names,
        begin: [0.0, begin],
        moving,
    }
}

/// A slider with friction, and stops, a wall or a rope.
fn slider(random: &mut Random) -> Case {
    let (mass, level) = (random.between(0.5, 4.0), random.between(1.0, 8.0));
    let ratio = if random.next().is_multiple_of(2) { 1.0 } else { random.between(1.0, 1.6) };
    let law = Law::random(random, 1.2 * level);
    let (high, low) = (random.between(0.02, 0.4), -random.between(0.02, 0.4));
    let restitution = if random.next().is_multiple_of(2) { 0.0 } else { random.between(0.1, 0.7) };
    let kind = random.next() % 3;
    let stiffness = if random.next().is_multiple_of(2) { 0.0 } else { random.between(1.0, 30.0) };
    let limits = if kind == 0 {
        format!("limits = {{ min = {low:?}, max = {high:?}, restitution = {restitution:?} }}\n")
    } else {
        String::new()
    };
    let mut parts = format!(
        "[ground.points]\nwall = [{high:?}, 0]\npost = [{low:?}, 0]\nfar = [-50, 0]\n[bodies.block]\nmass = {mass:?}\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [1, 0]\nfriction = {{ coulomb = {level:?}, static = {ratio:?} }}\n{limits}[loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"{}\", 0]\n[loads.spring]\ntype = \"spring\"\nbetween = [\"ground.far\", \"block\"]\nstiffness = {stiffness:?}\nlength = 50\n",
        law.text()
    );
    parts += &match kind {
        1 => format!(
            "[joints.pad]\ntype = \"contact\"\nbetween = [\"ground.wall\", \"block\"]\naxis = [0, 1]\nrestitution = {restitution:?}\n"
        ),
        2 => format!(
            "[joints.sling]\ntype = \"rope\"\nbetween = [\"ground.far\", \"block\"]\nlength = {:?}\nrestitution = {restitution:?}\n",
            50.0 + high
        ),
        _ => String::new(),
    };
    let begin = if random.next().is_multiple_of(2) { 0.0 } else { random.between(-2.0, 2.0) };
    let names = ["rail.s", "rail.v"];
    let force = move |t: f64, s: f64| law.at(t) - stiffness * s;
    let moving = Moving {
        slides: Box::new(move |t, s, _, direction| (force(t, s) - direction * level) / mass),
        rests: Box::new(move |t, s| [force(t, s), ratio * level]),
        stops: [if kind == 0 { low } else { f64::NEG_INFINITY }, high],
        restitution,
        rates: [f64::NEG_INFINITY, f64::INFINITY],
        jumps: vec![law.jump[0]],
    };
    Case {
        scene: scene(&parts, &format!("\"rail.s\" = 0.0\n\"rail.v\" = {begin:?}"), names),
        names,
        begin: [0.0, begin],
        moving,
    }
}

/// A box on two to four feet that does not tip. With more than two feet it is not determined how they carry it, and they have one coefficient of friction, so that this does not matter.
fn feet(random: &mut Random) -> Case {
    let (mass, height) = (random.between(1.0, 6.0), random.between(0.02, 0.1));
    let count = 2 + (random.next() % 3) as usize;
    let [mu, other] = [0, 1].map(|_| random.between(0.1, 0.6));
    let ratios = [0, 1].map(|_| if random.next().is_multiple_of(2) { 1.0 } else { random.between(1.0, 1.5) });
    let (mus, ratios) = if count == 2 { ([mu, other], ratios) } else { ([mu; 2], [ratios[0]; 2]) };
    let law = Law::random(random, 0.35 * mass * GRAVITY);
    let [left, right] = [-random.between(0.5, 0.8), random.between(0.5, 0.8)];
    let at = |index: usize| left + (right - left) * index as f64 / (count - 1) as f64;
    let mut parts =
        format!("gravity = [0, -9.81]\n[bodies.box]\nmass = {mass:?}\ninertia = 0.3\n[bodies.box.points]\n");
    (0..count).for_each(|index| parts += &format!("f{index} = [{:?}, {:?}]\n", at(index), -height));
    for index in 0..count {
        let own = usize::from(index > 0);
        parts += &format!(
            "[joints.c{index}]\ntype = \"contact\"\nbetween = [\"ground\", \"box.f{index}\"]\naxis = [1, 0]\nfriction = {{ mu = {:?}, static = {:?} }}\n",
            mus[own], ratios[own]
        );
    }
    parts += &format!("[loads.push]\ntype = \"force\"\non = \"box\"\nvector = [\"{}\", 0]\n", law.text());
    let begin = if random.next().is_multiple_of(2) { 0.0 } else { random.between(-2.0, 2.0) };
    let names = ["box.x", "box.vx"];
    let initial = format!(
        "\"box.x\" = 0.0\n\"box.y\" = {height:?}\n\"box.angle\" = 0.0\n\"box.vx\" = {begin:?}\n\"box.vy\" = 0.0\n\"box.omega\" = 0.0"
    );
    // With the friction T of all feet the balance of moments gives what the right one carries, N = carried - tilt T.
    let (weight, width) = (mass * GRAVITY, right - left);
    let (carried, tilt) = (-weight * left / width, height / width);
    let moving = Moving {
        slides: Box::new(move |t, _, _, direction| {
            let more = mus[1] - mus[0];
            let friction = -direction * (mus[0] * weight + more * carried) / (1.0 - direction * more * tilt);
            (law.at(t) + friction) / mass
        }),
        rests: Box::new(move |t, _| {
            let second = carried + tilt * law.at(t);
            [law.at(t), ratios[0] * mus[0] * (weight - second) + ratios[1] * mus[1] * second]
        }),
        stops: [f64::NEG_INFINITY, f64::INFINITY],
        restitution: 0.0,
        rates: [f64::NEG_INFINITY, f64::INFINITY],
        jumps: vec![law.jump[0]],
    };
    Case { scene: scene(&parts, &initial, names), names, begin: [0.0, begin], moving }
}

/// A slider-crank with friction in its pins and its guide.
#[derive(Clone, Copy)]
struct Crank {
    lengths: [f64; 2],
    masses: [f64; 3],
    levels: [f64; 4],
}

impl Crank {
    /// Rates of the coupler's angle and of the slider per that of the crank; the coupler's angle.
    fn shape(&self, angle: f64) -> [f64; 3] {
        let [crank, coupler] = self.lengths;
        let tilt = (-crank * angle.sin() / coupler).asin();
        let turns = -crank * angle.cos() / (coupler * tilt.cos());
        [turns, -crank * angle.sin() - coupler * tilt.sin() * turns, tilt]
    }

    fn inertia(&self, angle: f64) -> f64 {
        let ([crank, coupler], [first, second, third]) = (self.lengths, self.masses);
        let [turns, slides, tilt] = self.shape(angle);
        let middle = [
            -crank * angle.sin() - 0.5 * coupler * tilt.sin() * turns,
            crank * angle.cos() + 0.5 * coupler * tilt.cos() * turns,
        ];
        first * crank * crank / 3.0
            + second * (middle[0] * middle[0] + middle[1] * middle[1] + coupler * coupler / 12.0 * turns * turns)
            + third * slides * slides
    }

    fn level(&self, angle: f64) -> f64 {
        let [turns, slides, _] = self.shape(angle);
        [1.0, 1.0 - turns, turns, slides].iter().zip(&self.levels).map(|(rate, level)| rate.abs() * level).sum()
    }
}

fn crank(random: &mut Random) -> Case {
    let lengths = [random.between(0.1, 0.3), random.between(0.5, 0.9)];
    let masses = [0, 1, 2].map(|_| random.between(0.3, 2.0));
    let levels =
        [random.between(0.1, 1.0), random.between(0.1, 0.5), random.between(0.1, 0.5), random.between(0.5, 4.0)];
    let own = Crank { lengths, masses, levels };
    let begin = random.between(0.4, 2.7);
    let law = Law::random(random, own.level(begin));
    let ([a, b], [m1, m2, m3], [l1, l2, l3, l4]) = (lengths, masses, levels);
    let tilt = own.shape(begin)[2];
    let parts = format!(
        "[bodies.crank]\nmass = {m1:?}\ninertia = {:?}\npoints = {{ a = [{:?}, 0], b = [{:?}, 0] }}\n[bodies.coupler]\nmass = {m2:?}\ninertia = {:?}\npoints = {{ a = [{:?}, 0], b = [{:?}, 0] }}\n[bodies.slider]\nmass = {m3:?}\n[joints.shaft]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank.a\"]\nfriction = {{ coulomb = {l1:?} }}\n[joints.big_end]\ntype = \"revolute\"\nbetween = [\"crank.b\", \"coupler.a\"]\nfriction = {{ coulomb = {l2:?} }}\n[joints.small_end]\ntype = \"revolute\"\nbetween = [\"coupler.b\", \"slider\"]\nfriction = {{ coulomb = {l3:?} }}\n[joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"slider\"]\naxis = [1, 0]\nfriction = {{ coulomb = {l4:?} }}\n[loads.motor]\ntype = \"torque\"\non = \"crank\"\nvalue = \"{}\"\n",
        m1 * a * a / 12.0,
        -a / 2.0,
        a / 2.0,
        m2 * b * b / 12.0,
        -b / 2.0,
        b / 2.0,
        law.text()
    );
    let names = ["crank.angle", "crank.omega"];
    let initial =
        format!("\"crank.angle\" = {begin:?}\n\"coupler.angle\" = {{ guess = {tilt:?} }}\n\"crank.omega\" = 0.0");
    const STEP: f64 = 1e-5;
    let moving = Moving {
        slides: Box::new(move |t, s, v, direction| {
            let grows = (own.inertia(s + STEP) - own.inertia(s - STEP)) / (2.0 * STEP);
            (law.at(t) - direction * own.level(s) - 0.5 * grows * v * v) / own.inertia(s)
        }),
        rests: Box::new(move |t, s| [law.at(t), own.level(s)]),
        stops: [f64::NEG_INFINITY, f64::INFINITY],
        restitution: 0.0,
        rates: [f64::NEG_INFINITY, f64::INFINITY],
        jumps: vec![law.jump[0]],
    };
    Case { scene: scene(&parts, &initial, names), names, begin: [begin, 0.0], moving }
}

/// Makes a random case of one kind.
type Maker = fn(&mut Random) -> Case;

const KINDS: [(&str, Maker); 4] = [("wheel", wheel), ("slider", slider), ("feet", feet), ("crank", crank)];

fn case(seed: u64) -> (&'static str, Case) {
    let (name, kind) = KINDS[(seed % 4) as usize];
    (name, kind(&mut Random(seed + 1)))
}

/// The largest error of a run relative to one or the value.
fn error_of(case: &Case, expected: &[[f64; 3]], method: Engine, tolerance: f64) -> Result<f64, InstanceError> {
    let mut run = started(&model(&case.scene), Some(method), STOP, tolerance);
    let mut most: f64 = 0.0;
    for own in expected {
        run.step_to(own[0])?;
        for (name, right) in case.names.iter().zip(&own[1..]) {
            most = most.max((value(&mut run, name) - right).abs() / (1.0 + right.abs()));
        }
    }
    Ok(most)
}

/// What has come of some runs.
#[derive(Debug, Default)]
struct Count {
    runs: usize,
    moved: usize,
    refused: Vec<String>,
    wrong: Vec<String>,
    largest: [f64; 4],
}

/// True for a box, whose feet share what holds it in proportion to how they press.
fn is_box(case: &Case) -> bool {
    case.scene.contains("[joints.c1]")
}

fn count(seeds: std::ops::Range<u64>, boxes: bool) -> Count {
    let mut all = Count::default();
    for seed in seeds {
        let (kind, case) = case(seed);
        if !boxes && is_box(&case) {
            continue;
        }
        let mut state = [0.0, case.begin[0], case.begin[1]];
        let expected: Vec<[f64; 3]> = (1..=30)
            .map(|row| {
                state = case.moving.run(state, 0.1 * f64::from(row));
                state
            })
            .collect();
        all.moved += usize::from((expected[29][1] - case.begin[0]).abs() > 1e-3);
        for method in METHODS {
            for (index, tolerance) in TOLERANCES.into_iter().enumerate() {
                all.runs += 1;
                let name = format!("{kind} {seed} {method:?} {tolerance:e}");
                match error_of(&case, &expected, method, tolerance) {
                    Err(refused) => all.refused.push(format!("{name}: {refused}")),
                    Ok(error) if error < REFERENCE.max(ALLOWED * tolerance) => {
                        all.largest[index] = all.largest[index].max(error);
                    }
                    Ok(error) => all.wrong.push(format!("{name}: {error:e}")),
                }
            }
        }
    }
    all
}

fn check(seeds: std::ops::Range<u64>, boxes: bool) {
    let all = count(seeds, boxes);
    println!(
        "{} runs, {} refused, {} wrong; errors {:?}\n{:#?}\n{:#?}",
        all.runs,
        all.refused.len(),
        all.wrong.len(),
        all.largest,
        all.refused,
        all.wrong
    );
    assert!(all.moved * 16 > all.runs, "hardly anything moves: {} of {}", all.moved, all.runs / 8);
    assert!(all.wrong.is_empty() && all.refused.len() * 8 <= all.runs, "{:#?}\n{:#?}", all.wrong, all.refused);
}

#[test]
fn one_degree_of_freedom_moves_as_its_equation_says() {
    check(0..40, false);
}

/// An importer that looks for events sees them break away as well, wherever its steps end.
#[test]
fn an_integrator_outside_sees_them_break_away() {
    let mut seen = 0;
    for seed in 0..24 {
        let (kind, case) = case(seed);
        // Its steps do not end where a law jumps.
        if is_box(&case)
            || case.moving.jumps[0] < STOP && case.scene.contains("if(t < ") && !case.scene.contains(", 0, 0.0)")
        {
            continue;
        }
        let mut outside = Instance::new(model(&case.scene));
        outside.setup(0.0, None, None).unwrap();
        let events = integrate_to_events(&mut outside, STOP, 2.5e-4);
        let right = case.moving.run([0.0, case.begin[0], case.begin[1]], STOP);
        for (name, right) in case.names.iter().zip(&right[1..]) {
            let found = value(&mut outside, name);
            assert!(
                (found - right).abs() < 1e-5 * (1.0 + right.abs()),
                "{kind} {seed} {name}: {found} {right}, {events} events"
            );
        }
        seen += 1;
    }
    assert!(seen > 6, "{seen}");
}

#[test]
#[ignore = "takes many minutes: .ci/nightly runs it"]
fn two_thousand_of_them() {
    let seeds = std::env::var("COTREE_FRICTIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(2000);
    check(1000..1000 + seeds, false);
}

/// Not solved yet: of ten boxes three go astray by a single method at a breakaway, two of them on more than two feet.
#[test]
#[ignore = "known to fail: boxes on several feet"]
fn boxes_on_several_feet() {
    check(0..40, true);
}
