//! Grips that take parts lying on one, two or three feet, with and without friction, at rest or sliding: the impact and the motion that begins after it, against an own solver in absolute coordinates.
//!
//! The solver is projected Gauss-Seidel for the rows of guide, grip and feet (Moreau's form of Newton's and Coulomb's laws), which needs no independent rows, and shares nothing with the program.

use crate::support::run;
use cotree_fmu::math::Random;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use std::collections::BTreeMap;
use std::sync::Arc;

const GRAVITY: f64 = 9.81;
const WHEN: f64 = 0.2;
/// Hand, then part: x, y and the angle of each.
type Six = [f64; 6];

/// A row of constraints.
struct Row {
    of: Six,
    /// What is added to its rate or acceleration.
    bias: f64,
    law: Law,
}

#[derive(Clone, Copy)]
enum Law {
    Both,
    Presses,
    /// Friction of a row that presses, which slides in this direction or may stick.
    Rubs {
        on: usize,
        mu: f64,
        slides: Option<f64>,
    },
}

fn dot(a: &Six, b: &Six) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The rates, or accelerations, after the impulses, or forces, of the rows; none if they depend on where the search for these begins.
fn solve(masses: &Six, free: Six, rows: &[Row]) -> Option<Six> {
    let [one, other] = [0.0, 10.0].map(|begin| search(masses, free, rows, begin));
    one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-7).then_some(one)
}

fn search(masses: &Six, free: Six, rows: &[Row], begin: f64) -> Six {
    let scaled: Vec<Six> = rows.iter().map(|row| std::array::from_fn(|k| row.of[k] / masses[k])).collect();
    let pressing = rows.iter().map(|row| if matches!(row.law, Law::Presses) { begin } else { 0.0 });
    let (mut rates, mut impulses) = (free, pressing.collect::<Vec<f64>>());
    for (impulse, scaled) in impulses.iter().zip(&scaled) {
        (0..6).for_each(|k| rates[k] += impulse * scaled[k]);
    }
    for _ in 0..400_000 {
        let mut largest: f64 = 0.0;
        for (index, row) in rows.iter().enumerate() {
            let wanted = impulses[index] - (dot(&row.of, &rates) + row.bias) / dot(&row.of, &scaled[index]);
            let allowed = match row.law {
                Law::Both => wanted,
                Law::Presses => wanted.max(0.0),
                Law::Rubs { on, mu, slides: Some(way) } => -mu * way * impulses[on],
                Law::Rubs { on, mu, slides: None } => wanted.clamp(-mu * impulses[on], mu * impulses[on]),
            };
            let change = allowed - impulses[index];
            impulses[index] = allowed;
            (0..6).for_each(|k| rates[k] += change * scaled[index][k]);
            largest =
                largest.max(change.abs() * scaled[index].iter().fold(0.0, |most: f64, value| most.max(value.abs())));
        }
        if largest < 1e-15 {
            break;
        }
    }
    rates
}

/// A random grip.
struct Grip {
    masses: Six,
    /// Feet of the part; a disc has none.
    feet: Vec<f64>,
    mu: f64,
    guide: &'static str,
    slope: f64,
    weld: bool,
    force: [f64; 2],
    rates: Six,
}

const LOW: f64 = 0.05;
const TOP: [f64; 2] = [0.02, 0.06];
const HAND: [f64; 2] = [0.1, 0.5];

impl Grip {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
        let [hand, part] = [between(0.5, 2.0), between(0.3, 2.0)];
        let feet = match seed % 4 {
            0 => Vec::new(),
            1 => vec![0.0],
            2 => vec![-between(0.06, 0.12), between(0.06, 0.12)],
            _ => vec![-between(0.06, 0.12), between(-0.04, 0.04), between(0.06, 0.12)],
        };
        let mu = if (seed / 4).is_multiple_of(3) { 0.0 } else { between(0.1, 0.7) };
        let guide = ["up", "across", "none", "inclined"][(seed / 12 % 4) as usize];
        let slope = match guide {
            "across" => 0.0,
            // So steep that friction does not jam.
            _ => between(0.8, 1.5) * between(-1.0, 1.0).signum(),
        };
        // The tangent of the guide is (1, slope), or up.
        let tangent = if guide == "up" { [0.0, 1.0] } else { [1.0, slope] };
        let speed = if between(0.0, 1.0) < 0.25 { 0.0 } else { between(-0.8, 0.8) };
        let mut rates = [speed * tangent[0], speed * tangent[1], 0.0, 0.0, 0.0, 0.0];
        if guide == "none" {
            (rates[0], rates[1], rates[2]) = (between(-0.5, 0.5), between(-1.0, 3.0), between(-2.0, 2.0));
        }
        let slides = feet.len() > 1 || mu == 0.0 && feet.is_empty();
        if slides && between(0.0, 1.0) < 0.6 {
            let way = between(-1.0, 1.0).signum();
            rates[3] = way * (between(0.3, 0.8) + mu * GRAVITY * WHEN);
        }
        let force = [between(-8.0, 8.0), hand * GRAVITY + between(-12.0, 20.0)];
        let masses = [hand, hand, hand * between(0.005, 0.03), part, part, part * between(0.003, 0.01)];
        Self { masses, feet, mu, guide, slope, weld: between(0.0, 1.0) < 0.6, force, rates }
    }

    fn text(&self) -> String {
        let [m, _, j, mp, _, jp] = self.masses;
        let mut points = format!("top = {TOP:?}");
        let mut joints = String::new();
        let friction = if self.mu > 0.0 { format!(", friction = {{ mu = {:?} }}", self.mu) } else { String::new() };
        for (index, x) in self.feet.iter().enumerate() {
            points += &format!(", f{index} = [{x:?}, {:?}]", -LOW);
            joints += &format!(
                "f{index} = {{ type = \"contact\", between = [\"ground\", \"part.f{index}\"], axis = [1, 0]{friction} }}\n"
            );
        }
        if self.feet.is_empty() {
            joints += &format!(
                "f = {{ type = \"contact\", between = [\"ground\", \"part\"], axis = [1, 0], radius = {LOW:?}{friction} }}\n"
            );
        }
        let axis = match self.guide {
            "up" => "[0, 1]".to_owned(),
            _ => format!("[1, {:?}]", self.slope),
        };
        let [vx, vy, omega, px, ..] = self.rates;
        let [x, y] = HAND;
        let start = if self.guide == "none" {
            format!(
                "\"hand.vx\" = {vx:?}\n\"hand.vy\" = {vy:?}\n\"hand.omega\" = {omega:?}\n\"hand.x\" = {x:?}\n\"hand.y\" = {y:?}\n\"hand.angle\" = 0\n"
            )
        } else {
            joints +=
                &format!("guide = {{ type = \"prismatic\", between = [\"ground.p\", \"hand\"], axis = {axis} }}\n");
            format!(
                "\"guide.s\" = 0\n\"guide.v\" = {:?}\n",
                if self.guide == "up" { vy } else { vx * self.slope.hypot(1.0) }
            )
        };
        format!(
            r#"name = "grip"
gravity = [0, -9.81]
[bodies]
hand = {{ mass = {m:?}, inertia = {j:?} }}
part = {{ mass = {mp:?}, inertia = {jp:?}, points = {{ {points} }} }}
[ground.points]
p = {HAND:?}
[joints]
{joints}grip = {{ type = "{}", between = ["hand", "part.top"], engaged = false }}
[loads.drive]
type = "force"
on = "hand"
vector = {:?}
[events.grab]
when = "t > 0.2"
once = true
engage = ["grip"]
[initial]
{start}"part.x" = 0
"part.y" = {LOW:?}
"part.angle" = 0
"part.vx" = {px:?}
"part.vy" = 0
"part.omega" = 0
[outputs]
variables = [{}]
[experiment]
stop = 1
"#,
            if self.weld { "weld" } else { "revolute" },
            self.force,
            names().iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
        )
    }

    /// The accelerations that loads alone give.
    fn free(&self) -> Six {
        let m = self.masses[0];
        [self.force[0] / m, self.force[1] / m - GRAVITY, 0.0, 0.0, -GRAVITY, 0.0]
    }

    fn guide(&self) -> Vec<Six> {
        match self.guide {
            "none" => Vec::new(),
            "up" => vec![[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]],
            _ => vec![[-self.slope, 1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]],
        }
    }

    /// Where each foot touches, from the centre of the part.
    fn touching(&self) -> Vec<[f64; 2]> {
        match self.feet.is_empty() {
            true => vec![[0.0, -LOW]],
            false => self.feet.iter().map(|&x| [x, -LOW]).collect(),
        }
    }

    /// Positions and rates just before the grip, in closed form.
    fn before(&self) -> (Six, Six) {
        let rows: Vec<Row> = self.guide().into_iter().map(|of| Row { of, bias: 0.0, law: Law::Both }).collect();
        let mut by = search(&self.masses, self.free(), &rows, 0.0);
        by[4] = 0.0;
        by[3] = if self.rates[3] == 0.0 { 0.0 } else { -self.rates[3].signum() * self.mu * GRAVITY };
        let begin = [HAND[0], HAND[1], 0.0, 0.0, LOW, 0.0];
        let at = std::array::from_fn(|k| begin[k] + WHEN * (self.rates[k] + 0.5 * WHEN * by[k]));
        (at, std::array::from_fn(|k| self.rates[k] + WHEN * by[k]))
    }

    /// Rates just after it, and accelerations; none if rigid bodies do not determine them.
    fn after(&self) -> Option<(Six, Six)> {
        let (at, before) = self.before();
        let held = [at[3] + TOP[0], at[4] + TOP[1]];
        let (of_hand, of_part) = ([held[0] - at[0], held[1] - at[1]], TOP);
        let mut equal: Vec<(Six, [f64; 2])> = self.guide().into_iter().map(|of| (of, [0.0; 2])).collect();
        equal.push(([-1.0, 0.0, of_hand[1], 1.0, 0.0, -of_part[1]], [of_hand[0], -of_part[0]]));
        equal.push(([0.0, -1.0, -of_hand[0], 0.0, 1.0, of_part[0]], [of_hand[1], -of_part[1]]));
        if self.weld {
            equal.push(([0.0, 0.0, -1.0, 0.0, 0.0, 1.0], [0.0; 2]));
        }
        let is_disc = self.feet.is_empty();
        let normal = |r: [f64; 2]| [0.0, 0.0, 0.0, 0.0, 1.0, r[0]];
        let along = |r: [f64; 2]| [0.0, 0.0, 0.0, 1.0, 0.0, -r[1]];
        let mut rows: Vec<Row> = equal.iter().map(|(of, _)| Row { of: *of, bias: 0.0, law: Law::Both }).collect();
        for r in self.touching() {
            rows.push(Row { of: normal(r), bias: 0.0, law: Law::Presses });
            let on = rows.len() - 1;
            rows.push(Row { of: along(r), bias: 0.0, law: Law::Rubs { on, mu: self.mu, slides: None } });
        }
        let rates = solve(&self.masses, before, &rows)?;
        let (hand, part) = (rates[2] * rates[2], rates[5] * rates[5]);
        let mut rows: Vec<Row> = equal
            .iter()
            .map(|(of, [by_hand, by_part])| Row { of: *of, bias: by_hand * hand + by_part * part, law: Law::Both })
            .collect();
        for r in self.touching().into_iter().filter(|&r| dot(&normal(r), &rates) < 1e-9) {
            let bias = if is_disc { [0.0; 2] } else { r.map(|r| -r * part) };
            rows.push(Row { of: normal(r), bias: bias[1], law: Law::Presses });
            let (on, rate) = (rows.len() - 1, dot(&along(r), &rates));
            let slides = (rate.abs() > 1e-9).then(|| rate.signum());
            rows.push(Row { of: along(r), bias: bias[0], law: Law::Rubs { on, mu: self.mu, slides } });
        }
        Some((rates, solve(&self.masses, self.free(), &rows)?))
    }
}

fn names() -> Vec<String> {
    let all =
        ["vx", "vy", "omega", "ax", "ay", "alpha"].map(|word| ["hand", "part"].map(|body| format!("{body}.{word}")));
    all.into_iter().flatten().collect()
}

/// True if a grip goes as the solver says, false if that says that there is more than one motion, and so does the program; or why it is refused.
fn judge(seed: u64, model: &Arc<Model>, grip: &Grip) -> Result<bool, String> {
    let engine = [None, Some(Engine::Radau), Some(Engine::Dop853)][(seed % 3) as usize];
    let mut instance = run::started(model, engine, 1.0, 1e-10);
    let Some((rates, accelerations)) = grip.after() else {
        let message = run::message(&instance.step_to(WHEN + 1e-9).expect_err("more than one motion"));
        assert!(message.contains("not determined"), "{seed}: {message}");
        return Ok(false);
    };
    instance.step_to(WHEN + 1e-9).map_err(|error| run::message(&error))?;
    for (place, (body, k)) in [("hand", 0), ("part", 3)]
        .into_iter()
        .flat_map(|(body, first)| (0..3).map(move |k| (body, first + k)))
        .enumerate()
    {
        let [rate, acceleration] = [["vx", "vy", "omega"], ["ax", "ay", "alpha"]]
            .map(|words| run::value(&mut instance, &format!("{body}.{}", words[place % 3])));
        let right = rates[k];
        assert!((rate - right).abs() < 1e-6, "{seed}: rate {k} of {body}: {rate}, not {right}\n{}", grip.text());
        let right = accelerations[k];
        let size = accelerations.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        assert!(
            (acceleration - right).abs() < 1e-6 * size,
            "{seed}: acceleration {k} of {body}: {acceleration}, not {right}\n{}",
            grip.text()
        );
    }
    instance.step_to(0.6).map_err(|error| run::message(&error)).map(|()| true)
}

/// Counts grips that are right, and undetermined, and those that are refused by their reasons; every other one fails the test.
fn grips(seeds: std::ops::Range<u64>) -> ([usize; 2], BTreeMap<String, usize>) {
    let (mut right, mut refused) = ([0; 2], BTreeMap::new());
    for seed in seeds {
        let grip = Grip::new(seed);
        match judge(seed, &run::model(&grip.text()), &grip) {
            Ok(determined) => right[usize::from(!determined)] += 1,
            Err(message) => {
                println!("{seed} {message}");
                let reason = message.rsplit("`").next().unwrap_or_default().to_owned();
                *refused.entry(reason).or_insert(0) += 1;
            }
        }
    }
    (right, refused)
}

#[test]
fn parts_are_taken_from_their_feet() {
    let (right, refused) = grips(0..48);
    assert!(refused.is_empty(), "{right:?} right and undetermined, refused {refused:?}");
}

#[test]
#[ignore = "1000 of them: .ci/nightly"]
fn many_parts_are_taken_from_their_feet() {
    let (right, refused) = grips(0..1000);
    println!("{right:?} right and undetermined, refused {refused:?}");
    assert!(refused.values().sum::<usize>() <= 10, "{right:?} right and undetermined, refused {refused:?}");
}
