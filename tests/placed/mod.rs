//! Parts with every kind of component, mirrored, turned, moved, on the ground and on a body, against two scenes that the program has to place nothing for:
//! the part alone, and the part written out on a body that is welded where the frame of the part is. What both show is mapped by the frame here, by
//! rules of their own: places and vectors by at + R(angle) F, angles by their ends, what has a sense of rotation by its sign.

use crate::support::hard::random as split_mix;
use crate::support::run;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Faults, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

mod writer;
use run::sound;
use split_mix::Random;
use writer::{Allowed, Owner, Sort, Written, write};

/// What happens in this time is compared.
const STOP: f64 = 0.1;
const MEMBERS: u64 = 200;

/// Where a part is.
#[derive(Clone, Copy, Debug)]
struct Place {
    mirror: bool,
    angle: f64,
    at: [f64; 2],
}

impl Place {
    fn random(random: &mut Random) -> Place {
        let angle = if random.unit() < 0.2 { 0.0 } else { random.between(-3.0, 3.0) };
        let at = if random.unit() < 0.2 { [0.0; 2] } else { [random.between(-1.0, 1.0), random.between(-1.0, 1.0)] };
        Place { mirror: random.unit() < 0.5, angle, at }
    }

    fn sign(&self) -> f64 {
        if self.mirror { -1.0 } else { 1.0 }
    }

    fn vector(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.angle.sin_cos();
        let x = self.sign() * x;
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    fn point(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.vector(place);
        [self.at[0] + x, self.at[1] + y]
    }

    /// This place in the frame of a body at another.
    fn on(&self, body: &Place) -> Place {
        Place { mirror: self.mirror, angle: body.angle + self.angle, at: body.point(self.at) }
    }

    fn keys(&self, on: &str) -> String {
        let Place { mirror, angle, at: [x, y] } = self;
        format!(
            "[parts.p]\nfile = \"part.toml\"\non = \"{on}\"\nat = [{x:e}, {y:e}]\nangle = \"turned\"\nmirror = {mirror}\n[parameters]\nturned = \"{angle:e} rad\"\n"
        )
    }
}

fn started(scene: &Scene) -> Result<Instance, Faults> {
    let model = Arc::new(Model::new(compile(&scene.with_every_output())?.program).expect("a sound program"));
    let mut instance = run::started(&model, None, STOP, 1e-10);
    instance.step_to(STOP).unwrap_or_else(|failure| panic!("{failure:?}"));
    Ok(instance)
}

/// A part in a file of its own, used by a scene.
fn used(seed: u64, kind: &str, part: &str, scene: &str) -> Result<Instance, Faults> {
    let folder = std::env::temp_dir().join(format!("cotree_placed_{kind}_{seed}_{}", std::process::id()));
    let removed = Removed(folder.clone());
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("part.toml"), part).expect("a file");
    std::fs::write(folder.join("scene.toml"), scene).expect("a file");
    let instance = Scene::read(folder.join("scene.toml")).and_then(|scene| started(&scene));
    drop(removed);
    instance
}

struct Removed(PathBuf);

impl Drop for Removed {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// How a variable of the part alone is seen where it is: how its vectors and points are, and by how much angles that count from its ground turn.
struct Seen {
    world: Place,
    from_ground: f64,
}

impl Seen {
    fn value(&self, own: &Owner, word: &str, value: &dyn Fn(&str) -> f64) -> f64 {
        let sign = self.world.sign();
        let pair = |words: [&str; 2], second: bool, map: &dyn Fn([f64; 2]) -> [f64; 2]| {
            map(words.map(value))[usize::from(second)]
        };
        let vector = |v| self.world.vector(v);
        match word {
            "x" | "y" => pair(["x", "y"], word == "y", &|p| self.world.point(p)),
            "vx" | "vy" => pair(["vx", "vy"], word == "vy", &vector),
            "ax" | "ay" => pair(["ax", "ay"], word == "ay", &vector),
            "fx" | "fy" => pair(["fx", "fy"], word == "fy", &vector),
            "angle" if own.sort == Sort::Body => self.world.angle + sign * value(word),
            "angle" => own.from_ground * self.from_ground + sign * value(word),
            "omega" | "alpha" | "torque" | "pressure_angle" => sign * value(word),
            "fn" if own.sort == Sort::Slide => sign * value(word),
            _ => value(word),
        }
    }
}

const WORDS: [&str; 24] = [
    "x",
    "y",
    "vx",
    "vy",
    "ax",
    "ay",
    "angle",
    "omega",
    "alpha",
    "s",
    "v",
    "a",
    "fx",
    "fy",
    "fn",
    "ft",
    "force",
    "torque",
    "power",
    "length",
    "rate",
    "pressure_angle",
    "curvature",
    "acceleration",
];

/// What differs, by more than the tolerance of two runs.
fn differences(part: &Written, alone: Instance, placed: Instance, seen: &Seen) -> Vec<String> {
    let (alone, placed) = (std::cell::RefCell::new(alone), std::cell::RefCell::new(placed));
    let mut different = Vec::new();
    let mut compared = 0;
    for own in &part.owners {
        for word in WORDS {
            let (name, there) = (format!("{}.{word}", own.name), format!("p_{}.{word}", own.name));
            let has = |of: &std::cell::RefCell<Instance>, name: &str| of.borrow().variable(name).is_some();
            if !has(&alone, &name) || !has(&placed, &there) || is_coordinate_of_load(own, word) {
                continue;
            }
            let value = |word: &str| run::value(&mut alone.borrow_mut(), &format!("{}.{word}", own.name));
            let (expected, found) = (seen.value(own, word, &value), run::value(&mut placed.borrow_mut(), &there));
            let mut gap = found - expected;
            if word == "angle" && own.turns {
                gap = (gap + 0.1).rem_euclid(std::f64::consts::TAU) - 0.1;
            }
            compared += 1;
            if gap.is_nan() || gap.abs() > 1e-5 * (1.0 + expected.abs()) {
                different.push(format!("{there}: {found} instead of {expected}"));
            }
        }
    }
    assert!(compared > 20, "{compared}");
    different
}

/// Where a load is, is no variable that its place maps.
fn is_coordinate_of_load(own: &Owner, word: &str) -> bool {
    own.sort == Sort::Load && matches!(word, "x" | "y" | "vx" | "vy" | "ax" | "ay" | "acceleration")
}

/// Runs members, and says which are wrong or refused.
fn all(
    kind: &str,
    member: impl Fn(u64) -> (BTreeSet<&'static str>, Result<Vec<String>, Faults>),
) -> BTreeSet<&'static str> {
    let mut wrong = Vec::new();
    let mut kinds = BTreeSet::new();
    for seed in 0..MEMBERS / 4 {
        let (own, result) = member(seed);
        kinds.extend(own);
        match result {
            Ok(different) if different.is_empty() => {}
            Ok(different) => wrong.push(format!("{kind} {seed}: {}", different.join("; "))),
            Err(faults) => wrong.push(format!("{kind} {seed}: {}", faults.render(false, 100))),
        }
    }
    assert!(wrong.is_empty(), "{} wrong\n{}", wrong.len(), wrong.join("\n"));
    kinds
}

fn gravity([x, y]: [f64; 2]) -> String {
    format!("gravity = [{x:e}, {y:e}]\n")
}

const WEIGHT: [f64; 2] = [1.7, -9.3];

fn part_file(part: &Written) -> String {
    format!("name = \"part\"\n{}{}", gravity(WEIGHT), part.text)
}

/// On the ground a part does what it does alone, seen from elsewhere.
#[test]
fn on_the_ground_a_part_does_what_it_does_alone() {
    let kinds = all("ground", |seed| {
        let random = &mut Random(seed);
        let place = Place::random(random);
        let part = write(random.next(), "ground", Allowed { world: true, absolute: true });
        let alone = sound(Scene::from_toml(&part_file(&part)).and_then(|scene| started(&scene)));
        let scene = format!("name = \"s\"\n{}{}", gravity(place.vector(WEIGHT)), place.keys("ground"));
        let seen = Seen { world: place, from_ground: place.angle };
        let placed = used(seed, "ground", &part_file(&part), &scene);
        (part.kinds.clone(), placed.map(|placed| differences(&part, alone, placed, &seen)))
    });
    let known = cotree::component::examples();
    // Runs with impacts and friction are too rough to be compared by differences: those are in tests/one_sided.rs, tests/freewheel.rs and tests/dry_friction.rs.
    // Locks hold by events: those are in tests/engaging.rs.
    let rough = ["contact", "rope", "one_way", "brake", "clutch", "lock"];
    let known = known.iter().map(|(_, name, _)| *name).filter(|name| !rough.contains(name));
    assert_eq!(kinds, known.collect::<BTreeSet<&str>>());
}

/// On a body that stands still anywhere it does so too; the body is welded, or held by drivers.
#[test]
fn on_a_body_that_stands_a_part_does_what_it_does_alone() {
    all("fixed", |seed| {
        let random = &mut Random(1000 + seed);
        let (place, body) = (Place::random(random), Place { mirror: false, ..Place::random(random) });
        let part = write(random.next(), "ground", Allowed { world: false, absolute: false });
        let alone = sound(Scene::from_toml(&part_file(&part)).and_then(|scene| started(&scene)));
        let world = place.on(&body);
        let ([x, y], angle) = (body.at, body.angle);
        let held = match random.unit() < 0.5 {
            true => format!(
                "[ground.points]\nhere = [{x:e}, {y:e}]\n[joints.fixed]\ntype = \"weld\"\nbetween = [\"ground.here\", \"car.middle\"]\nangle = {angle:e}\n"
            ),
            false => format!(
                "[drivers.place]\non = \"car.middle\"\nposition = [{x:e}, {y:e}]\n[drivers.turn]\nbetween = [\"ground\", \"car\"]\nangle = {angle:e}\n"
            ),
        };
        let car = "[bodies.car]\nmass = 2.0\ninertia = 1.0\ncom = [0.3, -0.2]\npoints = { middle = [0, 0] }\n";
        let keys = place.keys("car");
        let scene = format!("name = \"s\"\n{}{car}{held}{keys}", gravity(world.vector(WEIGHT)));
        let seen = Seen { world, from_ground: place.angle };
        let placed = used(seed, "fixed", &part_file(&part), &scene);
        (part.kinds.clone(), placed.map(|placed| differences(&part, alone, placed, &seen)))
    });
}

/// On a body that moves as it is told it does what the same part does that is written out on that body: on a frame that is welded to it, and all of
/// that seen in a mirror if the part is mirrored.
#[test]
fn on_a_body_that_moves_a_part_is_the_part_written_out() {
    for half in 0..2 {
        all(["moving", "moved"][half], |seed| {
            let random = &mut Random(2000 + 1000 * half as u64 + seed);
            let place = Place::random(random);
            let (own, allowed) = (random.next(), Allowed { world: false, absolute: false });
            let (part, written) = (write(own, "ground", allowed), write(own, "frame", allowed));
            let [phase, turn] = [random.between(-3.0, 3.0), random.between(-3.0, 3.0)];
            let drivers = |sign: f64| {
                format!(
                    "[drivers.place]\non = \"car.middle\"\nposition = [\"{sign:e}*0.2*sin(3*t + {phase:e})\", \"0.1*cos(2*t)\"]\n\
                     [drivers.turn]\nbetween = [\"ground\", \"car\"]\nangle = \"{sign:e}*({turn:e} + 0.4*sin(2*t))\"\n"
                )
            };
            let weight = |sign: f64| gravity([sign * WEIGHT[0], WEIGHT[1]]);
            let car = |at: [f64; 2]| {
                format!(
                    "[bodies.car]\nmass = 2.0\ninertia = 1.0\npoints = {{ middle = [0, 0], here = [{:e}, {:e}] }}\n",
                    at[0], at[1]
                )
            };
            let sign = place.sign();
            let scene = format!("name = \"s\"\n{}{}{}{}", weight(1.0), car([0.0; 2]), drivers(1.0), place.keys("car"));
            let frame = format!(
                "[bodies.frame]\nmass = 0.1\ninertia = 0.1\npoints = {{ {} }}\n[joints.weld]\ntype = \"weld\"\nbetween = [\"car.here\", \"frame\"]\nangle = {:e}\n",
                written.points,
                sign * place.angle
            );
            let here = car([sign * place.at[0], place.at[1]]);
            let text = format!("name = \"w\"\n{}{here}{}{frame}{}", weight(sign), drivers(sign), written.text);
            let alone = sound(Scene::from_toml(&text).and_then(|scene| started(&scene)));
            let mirror = Place { mirror: place.mirror, angle: 0.0, at: [0.0; 2] };
            let seen = Seen { world: mirror, from_ground: place.angle };
            let placed = used(seed, "moving", &part_file(&part), &scene);
            (part.kinds.clone(), placed.map(|placed| differences(&part, alone, placed, &seen)))
        });
    }
}
