//! Random laws with `sign`, `if`, `floor`, `min`, `max`, `abs` and tables, of everything that a load can read, against equations of motion that are written and integrated here. The laws are evaluated here, too: nothing of
//! the program takes part.
//!
//! The reference knows the piece of each function. A step keeps them; where one would change, the step ends there, and the next begins with the pieces that follow.

use std::sync::Arc;

use cotree::compile::compile_asking;
use cotree::scene::{Requested, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

use crate::support::hard::random::Random;
use crate::support::power::PowerBalance;
use crate::support::run::{resolved, value};

/// How long a run is, and how often it is compared.
const STOP: f64 = 0.6;
const COMPARED: usize = 12;
/// The steps of the reference, a Runge-Kutta method of order 4.
const STEP: f64 = 2.5e-4;
const TOLERANCE: f64 = 1e-9;
/// How far the motions may be apart [m, rad and their rates, relative to what is above 1]: passages of pieces at small angles enlarge the errors of both.
const APART: f64 = 2e-6;

/// A law of what a load reads first (a length, an angle), its rate, and the time.
#[derive(Clone, Debug)]
enum Law {
    Number(f64),
    /// A multiple of one of the three.
    Read(f64, usize),
    Add(Box<[Law; 2]>),
    Multiply(Box<[Law; 2]>),
    Min(Box<[Law; 2]>),
    Max(Box<[Law; 2]>),
    Abs(Box<Law>),
    Sign(Box<Law>),
    Floor(Box<Law>),
    /// if(a < b, c, d), or with <=
    If(bool, Box<[Law; 4]>),
    /// The table with these values at 0, 0.5, 1, 1.5 ..., held beyond.
    Table([f64; 5], Box<Law>),
}

/// The pieces of a law in the order of its functions, as they are found or kept.
struct Pieces {
    list: Vec<i64>,
    kept: bool,
    next: usize,
}

impl Pieces {
    fn here(&mut self, found: i64) -> i64 {
        self.next += 1;
        if !self.kept {
            self.list.push(found);
        }
        self.list[self.next - 1]
    }
}

impl Law {
    fn random(random: &mut Random, depth: usize) -> Law {
        let number = |random: &mut Random| {
            let size = random.between(0.5, 6.0);
            if random.unit() < 0.5 { size } else { -size }
        };
        let pair = |random: &mut Random| Box::new([Law::random(random, depth - 1), Law::random(random, depth - 1)]);
        let one = |random: &mut Random| Box::new(Law::random(random, depth - 1));
        if depth == 0 {
            let which = (random.unit() * 3.5) as usize;
            return if which == 3 { Law::Number(number(random)) } else { Law::Read(number(random), which) };
        }
        match (random.unit() * 10.0) as usize {
            0 => Law::Add(pair(random)),
            1 => Law::Multiply(Box::new([Law::Number(number(random)), Law::random(random, depth - 1)])),
            2 => Law::Min(pair(random)),
            3 => Law::Max(pair(random)),
            4 => Law::Abs(one(random)),
            5 => Law::Multiply(Box::new([Law::Number(number(random)), Law::Sign(one(random))])),
            6 => Law::Floor(one(random)),
            7 => Law::Table([(); 5].map(|()| number(random)), one(random)),
            _ => {
                let [a, b, c, d] = [(); 4].map(|()| Law::random(random, depth - 1));
                Law::If(random.unit() < 0.5, Box::new([a, b, c, d]))
            }
        }
    }

    /// As a scene has it.
    fn written(&self, names: [&str; 3]) -> String {
        let of = |law: &Law| law.written(names);
        match self {
            Law::Number(number) => format!("({number:?})"),
            Law::Read(factor, which) => format!("({factor:?})*{}", names[*which]),
            Law::Add(two) => format!("({} + {})", of(&two[0]), of(&two[1])),
            Law::Multiply(two) => format!("({}*{})", of(&two[0]), of(&two[1])),
            Law::Min(two) => format!("min({}, {})", of(&two[0]), of(&two[1])),
            Law::Max(two) => format!("max({}, {})", of(&two[0]), of(&two[1])),
            Law::Abs(one) => format!("abs({})", of(one)),
            Law::Sign(one) => format!("sign({})", of(one)),
            Law::Floor(one) => format!("floor({})", of(one)),
            Law::If(or_equal, four) => {
                let [a, b, c, d] = four.each_ref().map(|part| part.written(names));
                format!("if({a} {} {b}, {c}, {d})", if *or_equal { "<=" } else { "<" })
            }
            // A table as a sum of slopes: straight from one of its places to the next.
            Law::Table(values, one) => {
                let x = of(one);
                let slope = |place: usize| {
                    let rise = values[place + 1] - values[place];
                    format!("({rise:?})*min(1, max(0, 2*{x} - {place}))")
                };
                let slopes: Vec<String> = (0..4).map(slope).collect();
                format!("(({:?}) + {})", values[0], slopes.join(" + "))
            }
        }
    }

    fn value(&self, read: [f64; 3], pieces: &mut Pieces) -> f64 {
        match self {
            Law::Number(number) => *number,
            Law::Read(factor, which) => factor * read[*which],
            Law::Add(two) => two[0].value(read, pieces) + two[1].value(read, pieces),
            Law::Multiply(two) => two[0].value(read, pieces) * two[1].value(read, pieces),
            Law::Min(two) | Law::Max(two) => {
                let [a, b] = two.each_ref().map(|part| part.value(read, pieces));
                let first_is_less = pieces.here(i64::from(a <= b)) == 1;
                if first_is_less == matches!(self, Law::Min(_)) { a } else { b }
            }
            Law::Abs(one) => {
                let inner = one.value(read, pieces);
                if pieces.here(i64::from(inner >= 0.0)) == 1 { inner } else { -inner }
            }
            Law::Sign(one) => {
                let inner = one.value(read, pieces);
                pieces.here(if inner > 0.0 { 1 } else { -i64::from(inner < 0.0) }) as f64
            }
            Law::Floor(one) => {
                let inner = one.value(read, pieces);
                pieces.here(inner.floor() as i64) as f64
            }
            Law::If(or_equal, four) => {
                let [a, b, c, d] = four.each_ref().map(|part| part.value(read, pieces));
                let holds = if *or_equal { a <= b } else { a < b };
                if pieces.here(i64::from(holds)) == 1 { c } else { d }
            }
            Law::Table(values, one) => {
                let inner = 2.0 * one.value(read, pieces);
                let place = pieces.here(inner.floor().clamp(-1.0, 4.0) as i64);
                match usize::try_from(place) {
                    Err(_) => values[0],
                    Ok(4) => values[4],
                    Ok(place) => values[place] + (values[place + 1] - values[place]) * (inner - place as f64),
                }
            }
        }
    }
}

/// What the law acts in, and by which component.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// An actuator along a guide.
    Guide,
    /// An actuator between masses on a line.
    Line,
    /// A torsion actuator.
    Turning,
    /// An actuator on a ball that moves in the plane.
    Ball,
    /// A force that reads the joint.
    Force,
    /// A torque that reads the joint.
    Torque,
    /// An actuator from a cart that a driver moves by a law in pieces.
    Driven,
}

const KINDS: [Kind; 7] = [Kind::Guide, Kind::Line, Kind::Turning, Kind::Ball, Kind::Force, Kind::Torque, Kind::Driven];

/// Stiffness and damping beside the law, which keep the motion in bounds.
const STIFFNESS: f64 = 40.0;
const DAMPING: f64 = 0.2;
/// When the driver's law changes over, and how fast the cart goes then.
const CHANGES: f64 = 0.23;
const DRIVEN: f64 = 1.7;

/// The laws of a load that have been wrong or whose derivative is zero, each with other numbers.
fn bare(random: &mut Random) -> Law {
    let [force, at] = [random.between(1.0, 6.0), random.between(-1.0, 1.5)];
    let read = |factor: f64, which: usize| Box::new(Law::Read(factor, which));
    let times = |factor: f64, law: Law| Law::Multiply(Box::new([Law::Number(factor), law]));
    let choice = |which: usize, or_equal: bool, [then, otherwise]: [f64; 2]| {
        let parts = [Law::Read(1.0, which), Law::Number(at), Law::Number(then), Law::Number(otherwise)];
        Law::If(or_equal, Box::new(parts))
    };
    match (random.unit() * 6.0) as usize {
        0 => times(-force, Law::Sign(read(1.0, 1))),
        1 => times(force, Law::Floor(read(3.0, 0))),
        2 => times(-force, Law::Floor(read(2.0, 1))),
        3 => choice(0, true, [force, -force]),
        4 => choice(1, false, [0.0, -force]),
        _ => Law::Add(Box::new([Law::Read(-4.0, 0), times(-force, Law::Sign(read(1.0, 1)))])),
    }
}

struct Case {
    kind: Kind,
    law: Law,
}

impl Case {
    fn of(seed: u64) -> Case {
        let mut random = Random(seed);
        let kind = KINDS[(random.unit() * 7.0) as usize];
        let law = if random.unit() < 0.4 { bare(&mut random) } else { Law::random(&mut random, 3) };
        Case { kind, law }
    }

    fn scene(&self) -> String {
        let own = self.law.written(match self.kind {
            Kind::Turning => ["angle", "omega", "t"],
            Kind::Force => ["guide.s", "guide.v", "t"],
            Kind::Torque => ["pin.angle", "pin.omega", "t"],
            Kind::Guide | Kind::Line | Kind::Ball | Kind::Driven => ["length", "rate", "t"],
        });
        let block = "[bodies.block]\nmass = 1\ninertia = 0.3\n";
        let guide = "[joints.guide]\ntype = 'prismatic'\nbetween = ['ground', 'block']\naxis = [1, 0]\n";
        let pin = "[joints.pin]\ntype = 'revolute'\nbetween = ['ground', 'block']\n";
        let spring = |between: &str, length: f64| {
            format!(
                "[loads.spring]\ntype = 'spring'\nbetween = {between}\nstiffness = {STIFFNESS}\ndamping = {DAMPING}\nlength = {length}\n"
            )
        };
        let torsion = format!(
            "[loads.spring]\ntype = 'torsion_spring'\nbetween = ['ground', 'block']\nstiffness = {STIFFNESS}\ndamping = {DAMPING}\n"
        );
        let wall = "['ground.wall', 'block']";
        let actuator =
            |between: &str| format!("[loads.law]\ntype = 'actuator'\nbetween = {between}\nforce = '{own}'\n");
        let rest = match self.kind {
            Kind::Guide => format!("{block}{guide}{}{}", spring(wall, 1.0), actuator(wall)),
            Kind::Line => format!(
                "[bodies.block]\nmass = 1\n{}{}",
                spring("['ground', 'block']", 0.0),
                actuator("['ground', 'block']")
            ),
            Kind::Turning => format!(
                "{block}{pin}{torsion}[loads.law]\ntype = 'torsion_actuator'\nbetween = ['ground', 'block']\ntorque = '{own}'\n"
            ),
            Kind::Ball => format!("{block}{}{}", spring(wall, 1.0), actuator(wall)),
            Kind::Force => format!(
                "{block}{guide}{}[loads.law]\ntype = 'force'\non = 'block'\nvector = ['{own}', 0]\n",
                spring(wall, 1.0)
            ),
            Kind::Torque => {
                format!("{block}{pin}{torsion}[loads.law]\ntype = 'torque'\non = 'block'\nvalue = '{own}'\n")
            }
            Kind::Driven => format!(
                "{block}[bodies.cart]\nmass = 2\ninertia = 0.3\n{guide}[joints.rail]\ntype = 'prismatic'\nbetween = ['ground', 'cart']\naxis = [1, 0]\n[drivers.drive]\njoint = 'rail'\ndisplacement = 'if(t < {CHANGES}, 0, {DRIVEN}*(t - {CHANGES})^2) - 1'\n{}{}",
                spring(wall, 1.0),
                actuator("['cart', 'block']")
            ),
        };
        let start = match self.kind {
            Kind::Line => "\"block.x\" = 0.33\n\"block.vx\" = 0.4",
            Kind::Ball => "\"block.x\" = 0.33\n\"block.vx\" = 0.4\n\"block.y\" = 0.1\n\"block.vy\" = 0.8",
            Kind::Turning | Kind::Torque => "\"pin.angle\" = 0.33\n\"pin.omega\" = 0.4",
            Kind::Guide | Kind::Force | Kind::Driven => "\"guide.s\" = 0.33\n\"guide.v\" = 0.4",
        };
        let ground = if self.kind == Kind::Line { "" } else { "[ground.points]\nwall = [-1, 0]\n" };
        let head = match self.kind {
            Kind::Line => "dimension = 1\n",
            Kind::Ball => "gravity = [0, -2]\n",
            _ => "",
        };
        format!("name = 'pieces'\n{head}{ground}{rest}[initial]\n{start}\n[experiment]\nstop = {STOP}\n")
    }

    fn start(&self) -> [f64; 4] {
        if self.kind == Kind::Ball { [0.33, 0.1, 0.4, 0.8] } else { [0.33, 0.0, 0.4, 0.0] }
    }

    /// What the law reads.
    fn read(&self, y: [f64; 4], time: f64) -> [f64; 3] {
        let [x, height, v, rise] = y;
        match self.kind {
            Kind::Guide => [1.0 + x, v, time],
            Kind::Line | Kind::Turning | Kind::Force | Kind::Torque => [x, v, time],
            Kind::Ball => {
                let length = (1.0 + x).hypot(height);
                [length, ((1.0 + x) * v + height * rise) / length, time]
            }
            Kind::Driven => {
                let since = (time - CHANGES).max(0.0);
                [x + 1.0 - DRIVEN * since * since, v - 2.0 * DRIVEN * since, time]
            }
        }
    }

    /// The rates of the state, and the pieces of the law.
    fn rates(&self, y: [f64; 4], time: f64, kept: Option<&[i64]>) -> ([f64; 4], Vec<i64>) {
        let mut pieces = Pieces { list: kept.map_or_else(Vec::new, <[i64]>::to_vec), kept: kept.is_some(), next: 0 };
        let [x, height, v, rise] = y;
        let law = self.law.value(self.read(y, time), &mut pieces);
        let accelerations = match self.kind {
            Kind::Turning | Kind::Torque => [(law - STIFFNESS * x - DAMPING * v) / 0.3, 0.0],
            Kind::Ball => {
                let [length, rate, _] = self.read(y, time);
                let pull = law - STIFFNESS * (length - 1.0) - DAMPING * rate;
                [pull * (1.0 + x) / length, pull * height / length - 2.0]
            }
            Kind::Guide | Kind::Line | Kind::Force | Kind::Driven => [law - STIFFNESS * x - DAMPING * v, 0.0],
        };
        ([v, rise, accelerations[0], accelerations[1]], pieces.list)
    }

    /// One step with the same pieces.
    fn step(&self, y: [f64; 4], time: f64, step: f64, pieces: &[i64]) -> [f64; 4] {
        let plus = |rates: [f64; 4], by: f64| [0, 1, 2, 3].map(|i| y[i] + by * rates[i]);
        let at = |y: [f64; 4], time: f64| self.rates(y, time, Some(pieces)).0;
        let a = at(y, time);
        let b = at(plus(a, step / 2.0), time + step / 2.0);
        let c = at(plus(b, step / 2.0), time + step / 2.0);
        let d = at(plus(c, step), time + step);
        plus([0, 1, 2, 3].map(|i| (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0), step)
    }
}

/// A motion in steps of its own, and why it ends.
struct Reference<'a> {
    case: &'a Case,
    y: [f64; 4],
    time: f64,
    pieces: Vec<i64>,
    /// Changes that followed each other at once.
    changes: usize,
}

/// Why a reference has no further values.
#[derive(Debug)]
enum End {
    /// Each piece leads back into the other.
    Chatters,
    /// The motion is out of bounds: a length has come near zero, or the law drives it away.
    OutOfBounds,
}

impl<'a> Reference<'a> {
    fn new(case: &'a Case) -> Self {
        let y = case.start();
        let pieces = case.rates(y, 0.0, None).1;
        Reference { case, y, time: 0.0, pieces, changes: 0 }
    }

    fn to(&mut self, time: f64) -> Result<(), End> {
        /// A look behind a change [s].
        const BEHIND: f64 = 1e-9;
        while self.time < time {
            let step = STEP.min(time - self.time);
            // The driver's law has an own change.
            let until = if self.time < CHANGES { CHANGES - self.time } else { f64::INFINITY };
            let step = if until > 1e-12 { step.min(until) } else { step };
            let stays = |reference: &Self, step: f64| {
                let next = reference.case.step(reference.y, reference.time, step, &reference.pieces);
                reference.case.rates(next, reference.time + step, None).1 == reference.pieces
            };
            let mut taken = step;
            let changes = !stays(self, step);
            if changes {
                let [mut low, mut high] = [0.0, step];
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    *(if stays(self, middle) { &mut low } else { &mut high }) = middle;
                }
                taken = high + BEHIND;
                self.changes = if high < 1e-7 { self.changes + 1 } else { 0 };
            } else {
                self.changes = 0;
            }
            self.y = self.case.step(self.y, self.time, taken, &self.pieces);
            self.time += taken;
            if changes {
                self.pieces = self.case.rates(self.y, self.time, None).1;
            }
            if self.changes > 10 {
                return Err(End::Chatters);
            }
            let length = self.case.read(self.y, self.time)[0];
            let is_line = matches!(self.case.kind, Kind::Guide | Kind::Ball | Kind::Driven);
            if !self.y.iter().all(|value| value.abs() < 50.0) || (is_line && length < 0.2) {
                return Err(End::OutOfBounds);
            }
        }
        Ok(())
    }
}

/// What came of a run.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Right,
    /// By a message with this text.
    Refused(String),
    Wrong(String),
}

fn run(case: &Case, engine: Option<Engine>) -> Outcome {
    let text = case.scene();
    let balance = PowerBalance::new(&resolved(&text).mechanism);
    let scene = Scene::from_toml(&text).unwrap_or_else(|faults| panic!("{text}\n{}", faults.render(false, 100)));
    let positions: &[&str] = match case.kind {
        Kind::Turning | Kind::Torque => &["block.angle"],
        Kind::Ball => &["block.x", "block.y"],
        Kind::Guide | Kind::Line | Kind::Force | Kind::Driven => &["block.x"],
    };
    let names = balance.names().into_iter().chain(positions.iter().map(|&name| name.to_owned())).collect();
    let compiled = match compile_asking(&scene, &Requested::Also(names)) {
        Ok((compiled, _)) => compiled,
        Err(faults) => return Outcome::Refused(faults.render(false, 100).to_string()),
    };
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
    instance.setup(0.0, Some(STOP), Some(TOLERANCE)).expect("times");
    if let Some(engine) = engine {
        instance.set_engine(engine).expect("not begun");
    }
    if let Err(error) = instance.initialise() {
        return Outcome::Refused(error.to_string());
    }
    compare(case, &balance, &mut instance)
}

fn compare(case: &Case, balance: &PowerBalance, instance: &mut Instance) -> Outcome {
    let mut reference = Reference::new(case);
    let [place, rate] = if matches!(case.kind, Kind::Turning | Kind::Torque) {
        ["block.angle", "block.omega"]
    } else {
        ["block.x", "block.vx"]
    };
    for number in 1..=COMPARED {
        let time = STOP * number as f64 / COMPARED as f64;
        let moved = instance.step_to(time).map_err(|error| error.to_string());
        match (reference.to(time), moved) {
            (Err(End::OutOfBounds), _) => return Outcome::Right,
            (Ok(()), Ok(())) => {}
            (Err(End::Chatters), Err(why)) if why.contains("chatters") => return Outcome::Refused(why),
            (Err(End::Chatters), moved) => return Outcome::Wrong(format!("the law chatters: {moved:?}")),
            (Ok(()), Err(why)) => return Outcome::Refused(why),
        }
        let mut pairs = vec![(place, reference.y[0]), (rate, reference.y[2])];
        if case.kind == Kind::Ball {
            pairs.extend([("block.y", reference.y[1]), ("block.vy", reference.y[3])]);
        }
        for (name, expected) in pairs {
            let found = value(instance, name);
            if (found - expected).abs() > APART * expected.abs().max(1.0) {
                return Outcome::Wrong(format!("{name} at {time} s is {found}, not {expected}"));
            }
        }
        let gap = balance.gap(instance);
        if gap > 1e-9 {
            return Outcome::Wrong(format!("the power balance at {time} s is open by {gap:e}"));
        }
    }
    Outcome::Right
}

fn all(seeds: std::ops::Range<u64>) {
    let (mut right, mut refused, mut wrong) = (0, Vec::new(), Vec::new());
    for seed in seeds {
        let case = Case::of(seed);
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            match run(&case, engine) {
                Outcome::Right => right += 1,
                Outcome::Refused(why) => refused.push(format!("{seed} {:?} {engine:?}: {why}", case.kind)),
                Outcome::Wrong(why) => wrong.push(format!("{seed} {engine:?}: {why}\n{}", case.scene())),
            }
        }
    }
    let others: Vec<&String> = refused.iter().filter(|why| !why.contains("chatters")).collect();
    println!(
        "{right} right, {} refused, {} of them for chattering, {} wrong",
        refused.len(),
        refused.len() - others.len(),
        wrong.len()
    );
    others.iter().for_each(|why| println!("{why}"));
    assert!(wrong.is_empty(), "{} wrong\n{}", wrong.len(), wrong.join("\n"));
    assert!(5 * refused.len() < right, "{right} right, refused:\n{}", refused.join("\n"));
}

#[test]
fn laws_in_pieces_move_as_they_say() {
    all(0..60);
}

#[test]
#[ignore = "500 laws: .ci/nightly"]
fn five_hundred_laws_in_pieces_move_as_they_say() {
    all(0..500);
}
