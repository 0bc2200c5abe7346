//! Mechanisms through singular poses and other hard cases, each with what must hold of its motion.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cotree::pipeline::compile;
use cotree::scene::{Body, Driver, Load, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

/// A scene and what must come out.
pub struct Case {
    /// Row of the table.
    pub family: &'static str,
    pub scene: Scene,
    pub stop: f64,
    pub laws: Vec<Law>,
    /// Nothing drives or brakes it.
    pub conservative: bool,
    /// Part of its error that the scene must say, if it must end with one.
    pub refusal: Option<&'static str>,
    pub tolerances: &'static [f64],
}

/// What holds on the branch at all times.
#[derive(Clone, Debug)]
pub enum Law {
    /// One joint of a four-bar turns all the way round. The sine of the opposite angle changes sign where the four-bar lies flat (when that joint is
    /// folded, stretched, or both) and nowhere else.
    Assembly { turn: Angle, opposite: Angle, flat: [bool; 2] },
    /// A constant combination of variables, 2 pi more or less if they are angles.
    Constant { terms: Vec<(String, f64)>, value: f64, turns: bool },
    /// The value of a variable at every multiple of a period.
    Periodic { name: String, value: f64, period: f64 },
}

/// Differences of angles of bars, and half turns.
#[derive(Clone, Debug)]
pub struct Angle {
    pub plus: Option<String>,
    pub minus: Option<String>,
    pub shift: f64,
}

/// How a run is asked for results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// At equal steps.
    Even(u32),
    /// At steps of very different lengths.
    Uneven(u32),
}

/// What came of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Passed(Figures),
    /// On another branch, or with another energy.
    Lost(String),
    Failed(String),
    Refused(String),
}

/// What was measured in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Relative to the largest energy of motion.
    pub drift: f64,
    pub residual: f64,
    pub microseconds: f64,
    pub steps: u64,
    pub fallbacks: u64,
}

pub const ALL_TOLERANCES: [f64; 11] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];

/// An energy that changes more than this is another motion.
const OTHER_MOTION: f64 = 0.2;
/// Near the flat pose the sign of an assembly says nothing.
const UNDECIDED: f64 = 0.02;

impl Case {
    fn new(family: &'static str, scene: Scene, stop: f64, laws: Vec<Law>) -> Self {
        let scene = scene.stop(stop);
        Self { family, scene, stop, laws, conservative: true, refusal: None, tolerances: &ALL_TOLERANCES }
    }

    fn at(mut self, tolerances: &'static [f64]) -> Self {
        self.tolerances = tolerances;
        self
    }

    fn driven(mut self) -> Self {
        self.conservative = false;
        self
    }

    fn refused(mut self, message: &'static str) -> Self {
        self.refusal = Some(message);
        self
    }

    /// The model, or why there is none.
    pub fn model(&self) -> Result<Arc<Model>, String> {
        let names = ["energy.total", "energy.kinetic", "constraint.position"].map(String::from);
        let laws = self.laws.iter().flat_map(Law::variables);
        let outputs: BTreeSet<String> = names.into_iter().chain(laws).collect();
        let known = |name: &str| self.scene.outputs.variables.iter().any(|known| known.text == name);
        let scene =
            outputs.iter().filter(|name| !known(name)).fold(self.scene.clone(), |scene, name| scene.output(name));
        let compiled = compile(&scene).map_err(|faults| faults.render(false, 100))?;
        Ok(Arc::new(Model::new(compiled.program).map_err(|fault| fault.to_string())?))
    }

    /// Runs it to its end.
    pub fn run(&self, model: &Arc<Model>, engine: Option<Engine>, tolerance: f64, points: Points) -> Outcome {
        match self.follow(model, engine, tolerance, points) {
            Ok(outcome) => outcome,
            Err(error) if self.refusal.is_some_and(|part| error.contains(part)) => Outcome::Refused(error),
            Err(error) => Outcome::Failed(error),
        }
    }

    fn follow(
        &self,
        model: &Arc<Model>,
        engine: Option<Engine>,
        tolerance: f64,
        points: Points,
    ) -> Result<Outcome, String> {
        let mut instance = Instance::new(model.clone());
        instance.setup(0.0, Some(self.stop), Some(tolerance)).map_err(|error| error.to_string())?;
        if let Some(engine) = engine {
            instance.set_engine(engine).map_err(|error| error.to_string())?;
        }
        let mut figures = Figures::default();
        instance.initialise().map_err(|error| error.to_string())?;
        let mut watch = Watch::new(self, &mut instance)?;
        for time in times(points, self.stop) {
            let start = Instant::now();
            instance.step_to(time).map_err(|error| error.to_string())?;
            figures.microseconds += start.elapsed().as_secs_f64() * 1e6;
            if let Some(lost) = watch.look(&mut instance)? {
                return Ok(Outcome::Lost(format!("t = {time:.4}: {lost}")));
            }
        }
        (figures.drift, figures.residual) = (if self.conservative { watch.drift() } else { 0.0 }, watch.residual);
        (figures.steps, figures.fallbacks) = (instance.statistics().steps, instance.statistics().fallbacks);
        if self.conservative && figures.drift > OTHER_MOTION {
            return Ok(Outcome::Lost(format!("the energy changes by {:.1e}", figures.drift)));
        }
        match self.refusal {
            Some(part) => Ok(Outcome::Failed(format!("runs to its end instead of refusing with `{part}`"))),
            None => Ok(Outcome::Passed(figures)),
        }
    }
}

fn times(points: Points, stop: f64) -> Vec<f64> {
    match points {
        Points::Even(count) => (1..=count).map(|k| stop * f64::from(k) / f64::from(count)).collect(),
        Points::Uneven(count) => {
            let mut random = Random(u64::from(count));
            let mut times: Vec<f64> = (1..count).map(|_| stop * random.unit().powf(0.7)).collect();
            times.push(stop);
            times.sort_by(f64::total_cmp);
            times.dedup();
            times
        }
    }
}

fn get(instance: &mut Instance, name: &str) -> Result<f64, String> {
    let variable = instance.variable(name).ok_or_else(|| format!("no variable {name}"))?;
    instance.get(variable).map_err(|error| error.to_string())
}

struct Watch<'a> {
    laws: &'a [Law],
    signs: Vec<f64>,
    energy: f64,
    kinetic: f64,
    change: f64,
    residual: f64,
}

impl<'a> Watch<'a> {
    fn new(case: &'a Case, instance: &mut Instance) -> Result<Self, String> {
        let energy = get(instance, "energy.total")?;
        let signs = vec![0.0; case.laws.len()];
        let mut watch = Self { laws: &case.laws, signs, energy, kinetic: 0.0, change: 0.0, residual: 0.0 };
        watch.look(instance)?;
        Ok(watch)
    }

    fn drift(&self) -> f64 {
        if self.change == 0.0 { 0.0 } else { self.change / self.kinetic }
    }

    fn look(&mut self, instance: &mut Instance) -> Result<Option<String>, String> {
        let energy = get(instance, "energy.total")?;
        self.kinetic = self.kinetic.max(get(instance, "energy.kinetic")?);
        self.change = self.change.max((energy - self.energy).abs());
        self.residual = self.residual.max(get(instance, "constraint.position")?);
        if !(energy.is_finite() && self.residual.is_finite()) {
            return Ok(Some("not finite".into()));
        }
        for (law, sign) in self.laws.iter().zip(&mut self.signs) {
            let broken = law.is_broken(instance, sign)?;
            if broken.is_some() {
                return Ok(broken);
            }
        }
        Ok(None)
    }
}

impl Law {
    fn variables(&self) -> Vec<String> {
        match self {
            Law::Assembly { turn, opposite, .. } => {
                [&turn.plus, &turn.minus, &opposite.plus, &opposite.minus].into_iter().flatten().cloned().collect()
            }
            Law::Periodic { name, .. } => vec![name.clone()],
            Law::Constant { terms, .. } => terms.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    fn is_broken(&self, instance: &mut Instance, sign: &mut f64) -> Result<Option<String>, String> {
        match self {
            Law::Assembly { turn, opposite, flat } => {
                let half = turn.value(instance)? / 2.0;
                let apex = opposite.value(instance)?.sin();
                let flips = if flat[0] { half.sin() } else { 1.0 } * if flat[1] { half.cos() } else { 1.0 };
                if flips.abs() < UNDECIDED || apex.abs() < UNDECIDED {
                    return Ok(None);
                }
                let now = (apex * flips).signum();
                if *sign == 0.0 {
                    *sign = now;
                }
                Ok((now != *sign).then(|| format!("another assembly, {turn:?}")))
            }
            Law::Periodic { name, value, period } => {
                let periods = instance.time() / period;
                let off = (get(instance, name)? - value).sin().abs();
                Ok(((periods - periods.round()).abs() < 1e-9 && (off.is_nan() || off >= 1e-3))
                    .then(|| format!("{name} is off by {off:.2e}")))
            }
            Law::Constant { terms, value, turns } => {
                let mut sum = -value;
                for (name, factor) in terms {
                    sum += factor * get(instance, name)?;
                }
                if *turns {
                    sum -= TAU * (sum / TAU).round();
                }
                Ok((sum.is_nan() || sum.abs() >= 0.05).then(|| format!("{terms:?} is off by {sum:.2e}")))
            }
        }
    }
}

impl Angle {
    fn value(&self, instance: &mut Instance) -> Result<f64, String> {
        let mut value = self.shift;
        for (name, sign) in [(&self.plus, 1.0), (&self.minus, -1.0)] {
            if let Some(name) = name {
                value += sign * get(instance, name)?;
            }
        }
        Ok(value)
    }
}

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    /// Between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

fn bar(mass: f64, length: f64) -> Body {
    let half = length / 2.0;
    let body = Body::new().mass(mass).inertia(mass * length * length / 12.0);
    body.point("a", [-half, 0.0]).point("b", [half, 0.0])
}

/// Lengths, masses, start and gravity of a four-bar on the ground's X axis.
#[derive(Clone, Copy, Debug)]
pub struct FourBar {
    pub crank: f64,
    pub coupler: f64,
    pub rocker: f64,
    pub base: f64,
    pub masses: [f64; 3],
    pub angle: f64,
    pub omega: f64,
    pub up: bool,
    pub gravity: f64,
}

impl FourBar {
    pub fn new(crank: f64, coupler: f64, rocker: f64, base: f64) -> Self {
        Self { crank, coupler, rocker, base, masses: [1.0; 3], angle: 1.0, omega: 2.0, up: true, gravity: 9.81 }
    }

    /// Angles of coupler and rocker.
    fn angles(&self) -> [f64; 2] {
        let (x, y) = (self.crank * self.angle.cos(), self.crank * self.angle.sin());
        let (dx, dy) = (self.base - x, -y);
        let distance = dx.hypot(dy);
        let cosine =
            (self.coupler.powi(2) + distance * distance - self.rocker.powi(2)) / (2.0 * self.coupler * distance);
        let turn = if self.up { cosine.clamp(-1.0, 1.0).acos() } else { -cosine.clamp(-1.0, 1.0).acos() };
        let coupler = dy.atan2(dx) + turn;
        let (px, py) = (x + self.coupler * coupler.cos(), y + self.coupler * coupler.sin());
        [coupler, py.atan2(px - self.base)]
    }

    fn law(&self) -> Law {
        self.law_of(["crank", "coupler", "rocker"])
    }

    /// With these names of its bars.
    fn law_of(&self, names: [&str; 3]) -> Law {
        let sides = [self.crank, self.coupler, self.rocker, self.base];
        let names = names.map(|name| Some(format!("{name}.angle")));
        let [crank, coupler, rocker] = &names;
        let angle = |plus: &Option<String>, minus: &Option<String>, shift: f64| Angle {
            plus: plus.clone(),
            minus: minus.clone(),
            shift,
        };
        // At the joints before the crank, before the coupler, before the rocker, before the base.
        let joints = [
            angle(crank, &None, 0.0),
            angle(coupler, crank, -PI),
            angle(coupler, rocker, 0.0),
            angle(rocker, &None, -PI),
        ];
        let shortest = (0..4).min_by(|&a, &b| sides[a].total_cmp(&sides[b])).unwrap_or_default();
        let [one, two, three, four] = [0, 1, 2, 3].map(|k| sides[(shortest + k) % 4]);
        // The joint before the shortest bar: that bar and the one before it, against the other two.
        let flat = [(one - four).abs(), one + four]
            .map(|distance| [(two - three).abs(), two + three].iter().any(|limit| (limit - distance).abs() < 1e-9));
        Law::Assembly { turn: joints[shortest].clone(), opposite: joints[(shortest + 2) % 4].clone(), flat }
    }

    pub fn scene(&self, name: &str) -> Scene {
        let [coupler, rocker] = self.angles();
        self.scene_from(name, [self.angle, coupler, rocker], self.omega)
    }

    /// From these angles of the bars.
    pub fn scene_from(&self, name: &str, [crank, coupler, rocker]: [f64; 3], omega: f64) -> Scene {
        let mut scene = Scene::new(name)
            .gravity([0.0, -self.gravity])
            .ground_point("far", [self.base, 0.0])
            .body("crank", bar(self.masses[0], self.crank))
            .body("coupler", bar(self.masses[1], self.coupler))
            .body("rocker", bar(self.masses[2], self.rocker))
            .revolute("crank_pivot", "ground", "crank.a")
            .revolute("crank_pin", "crank.b", "coupler.a")
            .revolute("rocker_pin", "coupler.b", "rocker.b")
            .revolute("rocker_pivot", "rocker.a", "ground.far")
            .initial("crank.angle", crank)
            .initial("crank.omega", omega)
            .guess("coupler.angle", coupler)
            .guess("rocker.angle", rocker);
        if self.masses[1] == 0.0 {
            scene = scene.description("the coupler has no mass");
        }
        scene
    }

    fn case(&self, family: &'static str, name: &str, stop: f64) -> Case {
        Case::new(family, self.scene(name), stop, vec![self.law()])
    }
}

/// Lengths with shortest + longest = sum of the others, in a random order; crank and start at random.
pub fn neutral(seed: u64) -> FourBar {
    let mut random = Random(seed);
    let [short, middle] = [random.between(0.4, 0.8), random.between(0.9, 1.2)];
    let other = random.between(1.0, 1.6);
    let sides = [short, middle, other, middle + other - short];
    let mut order = [0, 1, 2, 3];
    for k in (1..4).rev() {
        order.swap(k, (random.unit() * (k + 1) as f64) as usize);
    }
    let [crank, coupler, rocker, base] = order.map(|k| sides[k]);
    let mut bars = FourBar::new(crank, coupler, rocker, base);
    bars.masses = [0.0; 3].map(|_| random.between(0.3, 2.0));
    bars.omega = random.between(3.0, 9.0) * (random.unit() - 0.5).signum();
    bars.up = random.unit() < 0.5;
    // A start at which the loop closes, not too near to the flat pose.
    loop {
        bars.angle = random.between(-PI, PI);
        let distance = (bars.base - bars.crank * bars.angle.cos()).hypot(bars.crank * bars.angle.sin());
        if distance < 0.98 * (coupler + rocker) && distance > 1.02 * (coupler - rocker).abs() {
            return bars;
        }
    }
}

/// One of these whose longest bar is a little too short to meet the others in line, or too long if that is negative.
pub fn nearly_neutral(seed: u64, defect: f64) -> FourBar {
    let mut bars = neutral(seed);
    let sides = [&mut bars.crank, &mut bars.coupler, &mut bars.rocker, &mut bars.base];
    if let Some(longest) = sides.into_iter().max_by(|a, b| a.total_cmp(b)) {
        *longest -= defect;
    }
    bars
}

/// Inertia of a flap.
const FLAP: f64 = 0.05;

/// One of these whose rocker carries a flap on a stiff spring with critical damping, turning along with it.
pub fn neutral_with_flap(seed: u64) -> Case {
    const STIFFNESS: f64 = 1e6;
    let case = with_flap(neutral(seed), &format!("flap_{seed}"), STIFFNESS, 2.0 * (STIFFNESS * FLAP).sqrt());
    case.at(&[1e-3, 1e-4, 1e-6, 1e-8, 1e-10])
}

/// A four-bar whose rocker carries a flap on a spring, a damper, or both; the flap starts as it would turn along.
pub fn with_flap(bars: FourBar, name: &str, stiffness: f64, damping: f64) -> Case {
    let [coupler, rocker] = bars.angles();
    // Of the velocities of the loop.
    let along = |angle: f64| [-angle.sin(), angle.cos()];
    let ([a, b, c], r) = ([along(bars.angle), along(coupler), along(rocker)], bars.crank * bars.omega);
    let omega = r * (a[0] * b[1] - a[1] * b[0]) / (bars.rocker * (c[0] * b[1] - c[1] * b[0]));
    let scene = bars
        .scene(name)
        .body("flap", Body::new().mass(0.1).inertia(FLAP))
        .revolute("hinge", "rocker.b", "flap")
        .load("hinge_spring", Load::torsion_spring("rocker", "flap", stiffness).damping(damping))
        .initial("flap.angle", rocker)
        .initial("flap.omega", omega);
    let case = Case::new("change point, stiff spring", scene, 8.0, vec![bars.law()]);
    if damping > 0.0 { case.driven() } else { case }
}

/// Change points whose rocker carries a flap on a stiff spring, a stiff damper, or both. With the first member of the family come kite, rhombus and
/// parallelogram.
pub fn stiff_at_change_points(seed: u64, stiffnesses: &[f64], dampings: &[f64]) -> Vec<Case> {
    let special =
        [FourBar::new(0.8, 1.5, 1.5, 0.8), FourBar::new(1.0, 1.0, 1.0, 1.0), FourBar::new(1.0, 2.0, 1.0, 2.0)];
    let special = special.map(|bars| FourBar { omega: 5.0, ..bars });
    let bars = std::iter::once(neutral(seed)).chain(special.into_iter().filter(|_| seed == 0));
    let critical = |&stiffness: &f64| (stiffness, 2.0 * (stiffness * FLAP).sqrt());
    let mut loads: Vec<(f64, f64)> = stiffnesses.iter().map(critical).collect();
    loads.extend(stiffnesses.iter().map(|&stiffness| (stiffness, 0.0)));
    loads.extend(dampings.iter().map(|&damping| (0.0, damping)));
    let named = |bars: FourBar| {
        loads.iter().map(move |&(stiffness, damping)| {
            with_flap(bars, &format!("flap_{seed}_{stiffness:e}_{damping:.0e}"), stiffness, damping)
        })
    };
    bars.flat_map(named).collect()
}

/// N four-bar loops of bars of length 1 side by side (IFToMM benchmark A02).
pub fn loops(count: usize, angle: f64, speed: f64) -> Case {
    let mut scene = Scene::new(&format!("loops_{count}")).gravity([0.0, -9.81]);
    let mut laws = Vec::new();
    for k in 0..=count {
        scene = scene.body(&format!("crank_{k}"), bar(1.0, 1.0));
        if k > 0 {
            let name = format!("coupler_{k}");
            scene = scene.ground_point(&format!("p{k}"), [k as f64, 0.0]).body(&name, bar(1.0, 1.0));
            laws.push(Law::Constant { terms: vec![(format!("{name}.angle"), 1.0)], value: 0.0, turns: true });
        }
    }
    scene = scene.revolute("pivot_0", "ground", "crank_0.a");
    for k in 1..=count {
        let (crank, coupler) = (format!("crank_{k}"), format!("coupler_{k}"));
        scene = scene
            .revolute(&format!("pivot_{k}"), &format!("ground.p{k}"), &format!("{crank}.a"))
            .revolute(&format!("left_{k}"), &format!("crank_{}.b", k - 1), &format!("{coupler}.a"))
            .revolute(&format!("right_{k}"), &format!("{coupler}.b"), &format!("{crank}.b"))
            .guess(&format!("{crank}.angle"), angle)
            .guess(&format!("{coupler}.angle"), 0.0);
    }
    let scene = scene.initial("crank_0.angle", angle).initial("crank_0.omega", -speed);
    Case::new(
        if count < 3 { "four-bars side by side, 1-2" } else { "four-bars side by side, 5-100" },
        scene,
        10.0,
        laws,
    )
}

/// Two four-bars on one crank, flat at the same time.
fn coupled(seed: u64) -> Case {
    let mut random = Random(seed);
    let first = FourBar { angle: 1.0, omega: random.between(4.0, 8.0), ..FourBar::new(0.5, 1.1, 1.3, 1.9) };
    let base = random.between(1.5, 1.8);
    let second =
        FourBar { up: seed.is_multiple_of(2), ..FourBar { coupler: 1.0, rocker: base + 0.5 - 1.0, base, ..first } };
    let [coupler, rocker] = second.angles();
    let scene = first
        .scene("coupled")
        .ground_point("near", [second.base, 0.0])
        .body("link", bar(0.7, second.coupler))
        .body("arm", bar(0.9, second.rocker))
        .revolute("link_pin", "crank.b", "link.a")
        .revolute("arm_pin", "link.b", "arm.b")
        .revolute("arm_pivot", "arm.a", "ground.near")
        .guess("link.angle", coupler)
        .guess("arm.angle", rocker);
    let other = second.law_of(["crank", "link", "arm"]);
    Case::new("coupled change points", scene, 6.0, vec![first.law(), other])
}

/// Crank and rod of the same length.
fn equal_slider_crank(omega: f64, angle: f64) -> Case {
    let scene = Scene::new("equal_slider_crank")
        .gravity([0.0, -9.81])
        .body("crank", bar(1.0, 1.0))
        .body("rod", bar(1.3, 1.0))
        .body("slider", Body::new().mass(0.7))
        .revolute("bearing", "ground", "crank.a")
        .revolute("pin", "crank.b", "rod.a")
        .revolute("wrist", "rod.b", "slider")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", angle)
        .initial("crank.omega", omega)
        .guess("rod.angle", -angle);
    let terms = vec![("rod.angle".into(), 1.0), ("crank.angle".into(), 1.0)];
    Case::new("equal slider-crank", scene, 10.0, vec![Law::Constant { terms, value: 0.0, turns: true }])
}

/// A platform on three parallel cranks: one of them repeats what the others say.
fn redundant(omega: f64) -> Case {
    let mut scene = Scene::new("redundant").gravity([0.0, -9.81]).body(
        "platform",
        Body::new().mass(2.0).inertia(0.9).point("p0", [-1.0, 0.0]).point("p1", [0.2, 0.0]).point("p2", [1.0, 0.0]),
    );
    for (k, x) in [0.0, 1.2, 2.0].into_iter().enumerate() {
        let crank = format!("crank_{k}");
        scene = scene
            .ground_point(&format!("g{k}"), [x, 0.0])
            .body(&crank, bar(1.0, 0.6))
            .revolute(&format!("low_{k}"), &format!("ground.g{k}"), &format!("{crank}.a"))
            .revolute(&format!("high_{k}"), &format!("{crank}.b"), &format!("platform.p{k}"));
        scene = if k == 0 { scene.initial("crank_0.angle", 1.1) } else { scene.guess(&format!("{crank}.angle"), 1.1) };
    }
    let scene = scene.initial("crank_0.omega", omega).guess("platform.angle", 0.0);
    let law = Law::Constant { terms: vec![("platform.angle".into(), 1.0)], value: 0.0, turns: true };
    Case::new("five-link with a redundant rod", scene, 10.0, vec![law])
}

/// A slider-crank of common proportions.
fn slider_crank(name: &str, omega: f64, gravity: f64) -> Scene {
    Scene::new(name)
        .gravity([0.0, -gravity])
        .body("crank", bar(1.0, 0.05))
        .body("rod", bar(0.5, 0.15))
        .body("piston", Body::new().mass(0.4))
        .revolute("bearing", "ground", "crank.a")
        .revolute("pin", "crank.b", "rod.a")
        .revolute("wrist", "rod.b", "piston")
        .prismatic("cylinder", "ground", "piston", [1.0, 0.0])
        .initial("crank.angle", 0.5)
        .initial("crank.omega", omega)
        .guess("rod.angle", -0.16)
}

/// A mass on a spring, damped or not, that a slow pendulum shakes.
fn stiff(stiffness: f64, damping: f64, stop: f64) -> Case {
    let scene = Scene::new("stiff")
        .gravity([0.0, -9.81])
        .body("carriage", Body::new().mass(1.0))
        .body("bob", bar(1.0, 0.5))
        .prismatic("rail", "ground", "carriage", [1.0, 0.0])
        .revolute("eye", "carriage", "bob.a")
        .ground_point("wall", [-1.0, 0.0])
        .load("spring", Load::spring("ground.wall", "carriage", stiffness).free(1.0).damping(damping))
        .initial("carriage.x", 0.0)
        .initial("carriage.vx", 0.0)
        .initial("bob.angle", 0.3)
        .initial("bob.omega", 1.0);
    let case = Case::new(if damping > 0.0 { "stiff spring, damped" } else { "stiff spring" }, scene, stop, vec![]);
    if damping > 0.0 { case.driven() } else { case }
}

/// Jansen's leg: its crank turns 1000 times and everything comes back.
fn jansen() -> Case {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m] =
        [38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0].map(|mm: f64| mm * 1e-3);
    // Points by intersecting circles, crank at angle 0: crank pin, knees and foot.
    let (pin, fixed) = ([m, 0.0], [-a, -l]);
    let upper = meet(pin, j, fixed, b, true);
    let lower = meet(pin, k, fixed, c, false);
    let left = meet(fixed, d, upper, e, false);
    let knee = meet(left, f, lower, g, false);
    let angle = |from: [f64; 2], to: [f64; 2]| (to[1] - from[1]).atan2(to[0] - from[0]);
    let triangle = |base: f64, first: f64, second: f64, sign: f64| {
        let x = (base * base + first * first - second * second) / (2.0 * base);
        [x, sign * (first * first - x * x).sqrt()]
    };
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).signum()
    };
    let thin = |length: f64| {
        Body::new().mass(length).inertia(length.powi(3) / 12.0).point("a", [0.0, 0.0]).point("b", [length, 0.0])
    };
    let top = triangle(b, d, e, side(fixed, upper, left));
    let foot = triangle(g, i, h, 1.0);
    let scene = Scene::new("jansen")
        .gravity([0.0, -9.81])
        .ground_point("fixed", fixed)
        .body("crank", thin(m))
        .body("upper_rod", thin(j))
        .body("lower_rod", thin(k))
        .body("upper", thin(b).point("c", top))
        .body("lower", thin(c))
        .body("shin", thin(f))
        .body("foot", thin(g).point("c", foot))
        .revolute("shaft", "ground", "crank.a")
        .revolute("pin_1", "crank.b", "upper_rod.a")
        .revolute("pin_2", "crank.b", "lower_rod.a")
        .revolute("pin_3", "upper_rod.b", "upper.b")
        .revolute("pin_4", "upper.a", "ground.fixed")
        .revolute("pin_5", "lower_rod.b", "lower.b")
        .revolute("pin_6", "lower.a", "ground.fixed")
        .revolute("pin_7", "upper.c", "shin.a")
        .revolute("pin_8", "shin.b", "foot.b")
        .revolute("pin_9", "foot.a", "lower.b")
        .driver("motor", Driver::angle("shaft", "2*pi*t"))
        .guess("upper_rod.angle", angle(pin, upper))
        .guess("lower_rod.angle", angle(pin, lower))
        .guess("upper.angle", angle(fixed, upper))
        .guess("lower.angle", angle(fixed, lower))
        .guess("shin.angle", angle(left, knee))
        .guess("foot.angle", angle(lower, knee));
    let home = |name: &str, value: f64| Law::Periodic { name: format!("{name}.angle"), value, period: 1.0 };
    let laws =
        vec![home("upper", angle(fixed, upper)), home("lower", angle(fixed, lower)), home("foot", angle(lower, knee))];
    Case::new("Jansen's leg, 1000 turns", scene, 1000.0, laws).driven().at(&[1e-6, 1e-10])
}

/// The point at distance r of p and s of q, left or right of the way from p to q.
fn meet(p: [f64; 2], r: f64, q: [f64; 2], s: f64, left: bool) -> [f64; 2] {
    let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
    let d = dx.hypot(dy);
    let along = (r * r - s * s + d * d) / (2.0 * d);
    let across = (r * r - along * along).sqrt() * if left { -1.0 } else { 1.0 };
    [p[0] + (along * dx - across * dy) / d, p[1] + (along * dy + across * dx) / d]
}

/// A truss and a drive that together leave no freedom.
fn no_freedom() -> Case {
    let scene = Scene::new("truss")
        .ground_point("far", [1.0, 0.0])
        .body("left", bar(1.0, 1.0))
        .body("right", bar(1.0, 1.0))
        .revolute("foot", "ground", "left.a")
        .revolute("top", "left.b", "right.a")
        .revolute("other_foot", "right.b", "ground.far")
        .guess("left.angle", 1.0)
        .guess("right.angle", -1.0);
    let law = Law::Constant { terms: vec![("left.angle".into(), 1.0)], value: PI / 3.0, turns: false };
    Case::new("no freedom", scene, 10.0, vec![law])
}

fn free_floating() -> Case {
    let scene = Scene::new("floating")
        .body("one", bar(1.0, 1.0))
        .body("two", bar(2.0, 1.5))
        .revolute("pin", "one.b", "two.a")
        .initial("one.x", 0.0)
        .initial("one.y", 0.0)
        .initial("one.angle", 0.2)
        .initial("two.angle", 1.0)
        .initial("one.vx", 1.0)
        .initial("one.vy", -0.5)
        .initial("one.omega", 3.0)
        .initial("two.omega", -4.0);
    Case::new("free-floating", scene, 20.0, vec![])
}

/// A driver that asks a four-bar to go beyond its reach.
fn lock_up() -> Case {
    let bars = FourBar { angle: 1.0, ..FourBar::new(1.0, 0.7, 0.8, 1.2) };
    let [coupler, rocker] = bars.angles();
    let scene = Scene::new("lock_up")
        .ground_point("far", [1.2, 0.0])
        .body("crank", bar(1.0, 1.0))
        .body("coupler", bar(1.0, 0.7))
        .body("rocker", bar(1.0, 0.8))
        .revolute("crank_pivot", "ground", "crank.a")
        .revolute("crank_pin", "crank.b", "coupler.a")
        .revolute("rocker_pin", "coupler.b", "rocker.b")
        .revolute("rocker_pivot", "rocker.a", "ground.far")
        .driver("motor", Driver::angle("crank_pivot", "1 + t"))
        .guess("coupler.angle", coupler)
        .guess("rocker.angle", rocker);
    Case::new("lock-up", scene, 3.0, vec![]).driven().refused("lock")
}

/// The same with a load that swings on the rocker, so that there is freedom left.
fn lock_up_with_freedom() -> Case {
    let mut case = lock_up();
    case.scene = case
        .scene
        .body("bob", bar(0.3, 0.4))
        .revolute("hook", "rocker.b", "bob.a")
        .initial("bob.angle", 0.0)
        .initial("bob.omega", 0.0);
    case
}

/// Starts that lie flat: rates that belong to one branch lead on, others do not say which.
fn starts(seed: u64) -> Vec<Case> {
    let mut random = Random(seed);
    let omega = random.between(1.0, 5.0);
    let parallel = |rocker: Option<f64>, coupler: f64| {
        let bars = FourBar { angle: 0.0, omega, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
        let mut scene = bars.scene("flat_start");
        if let Some(rocker) = rocker {
            scene = scene.initial("rocker.omega", rocker).initial("coupler.omega", coupler);
        }
        Case::new("start in the pose", scene, 5.0, vec![])
    };
    let constant = |terms: &[(&str, f64)]| Law::Constant {
        terms: terms.iter().map(|(name, factor)| (format!("{name}.angle"), *factor)).collect(),
        value: 0.0,
        turns: true,
    };
    let mut parallelogram = parallel(Some(omega), 0.0);
    parallelogram.laws = vec![constant(&[("coupler", 1.0)])];
    // On the other branch, the antiparallelogram: J v = 0 and the second-order condition give coupler -+ (crank - rocker).
    let still = FourBar { angle: 0.0, omega: 0.0, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
    let rest = Case::new("start in the pose, undecided", still.scene("rest"), 5.0, vec![]).refused("singular");
    let mut undecided = parallel(None, 0.0).refused("singular");
    undecided.family = "start in the pose, undecided";
    vec![parallelogram, rest, undecided]
}

fn andrews() -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/andrews/scene.toml");
    let scene = Scene::read(&path).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    // The published value of beta at 0.03 s.
    Case::new("Andrews' mechanism", scene, 0.03, vec![]).driven()
}

/// The whole set: families with so many members each.
pub fn cases(members: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let parallelogram = FourBar { omega: 5.0, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
    for seed in 0..members {
        let mut random = Random(1000 + seed);
        let omega = random.between(2.0, 9.0);
        let angle = random.between(0.4, 2.6);
        cases.push(FourBar { omega, angle, ..parallelogram }.case("parallelogram", "parallelogram", 10.0));
        cases.push(FourBar { omega, angle, ..FourBar::new(0.8, 1.5, 1.5, 0.8) }.case("kite", "kite", 10.0));
        cases.push(FourBar { omega, angle, ..FourBar::new(1.0, 1.0, 1.0, 1.0) }.case("rhombus", "rhombus", 10.0));
        cases.push(coupled(seed));
        cases.push(equal_slider_crank(omega, angle));
        cases.push(redundant(omega + 3.0));
        cases.extend(starts(seed));
    }
    for seed in 0..3 * members {
        cases.push(neutral(seed).case("neutral four-bar", &format!("neutral_{seed}"), 8.0));
    }
    for (seed, power) in (0..members).flat_map(|seed| (3..=8).map(move |power| (seed, power))) {
        let bars = nearly_neutral(seed, 10.0_f64.powi(-power));
        let name = format!("nearly_neutral_{seed}_1e-{power}");
        cases.push(bars.case("nearly neutral four-bar", &name, 8.0).at(&[1e-6, 1e-7, 1e-8, 1e-9, 1e-10]));
    }
    for count in [1, 2, 5, 10, 20, 40, 100] {
        // The benchmark itself: upright, 1 m/s.
        cases.push(loops(count, PI / 2.0, 1.0));
    }
    for mass in [1e-9, 1e-14, 0.0] {
        let bars = FourBar { masses: [1.0, mass, 1.0], ..parallelogram };
        cases.push(bars.case("near-massless coupler", "massless", 10.0));
    }
    for masses in [[1.0, 1.0, 1e6], [1.0, 1e-6, 1.0], [1e6, 1.0, 1.0]] {
        cases.push(FourBar { masses, ..parallelogram }.case("mass ratio 1e6", "ratio", 10.0));
    }
    cases.extend([stiff(1e6, 1e2, 1.0), stiff(1e9, 1e3, 0.02), stiff(1e7, 0.0, 1.0)]);
    cases.push(Case::new("1000 s", slider_crank("long", 20.0, 9.81), 1000.0, vec![]).at(&[1e-6, 1e-8, 1e-10, 1e-12]));
    let fast = slider_crank("fast", 10_000.0 * TAU / 60.0, 9.81);
    cases.push(Case::new("10 000 rpm for 60 s", fast, 60.0, vec![]).at(&[1e-6, 1e-9, 1e-12]));
    cases.extend([jansen(), andrews(), no_freedom(), free_floating(), lock_up(), lock_up_with_freedom()]);
    cases
}
