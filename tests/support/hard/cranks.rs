//! Cranks side by side: more of them than a platform needs, and pairs that come close to lying flat.

use cotree::scene::{Body, Scene};

use super::closed_form::{ClosedForm, State};
use super::dyad::{Arm, dyad, fixed};
use super::four_bar::bar;
use super::reference::Reference;
use super::{Case, Law, Random};
use crate::support::jet::Jet;

/// A platform on parallel cranks that turn alike.
struct Platform {
    family: &'static str,
    name: String,
    length: f64,
    mass: f64,
    /// Of the cranks.
    angle: f64,
    omega: f64,
    pins: Vec<[f64; 2]>,
    masses: Vec<f64>,
}

/// A platform on three to six parallel cranks: it needs two, and all of them turn alike. Its pins lie on no line, so nothing ever lies flat.
pub fn redundant(seed: u64) -> Case {
    let mut random = Random(seed);
    let count = 3 + (random.unit() * 4.0) as usize;
    let (length, mass) = (random.between(0.3, 1.0), random.between(0.5, 5.0));
    let (angle, omega) = (random.between(-3.0, 3.0), random.between(2.0, 12.0));
    let pins = (0..count).map(|k| [k as f64 + few_digits(&mut random, -0.2, 0.2), few_digits(&mut random, -0.5, 0.5)]);
    let pins = pins.collect();
    let masses = (0..count).map(|_| few_digits(&mut random, 0.5, 2.5)).collect();
    let (family, name) = ("redundant cranks", format!("redundant_cranks_{seed}"));
    Platform { family, name, length, mass, angle, omega, pins, masses }.case()
}

/// The same with all pins in a row: twice a turn all cranks lie in line, where the loops have more freedoms than the motion, and they begin there, or close to it.
pub fn in_line(seed: u64) -> Case {
    let mut random = Random(seed);
    let count = 3 + (random.unit() * 4.0) as usize;
    let (length, mass) = (random.between(0.3, 1.0), random.between(0.5, 5.0));
    // Exactly in line, or beside it by a hundredth down to a ten-millionth.
    let beside = if seed.is_multiple_of(3) { 0.0 } else { 10.0_f64.powf(random.between(-7.0, -2.0)) };
    let omega = random.between(2.0, 12.0);
    let pins = (0..count).map(|k| [k as f64 + few_digits(&mut random, -0.2, 0.2), 0.0]).collect();
    let masses = (0..count).map(|_| few_digits(&mut random, 0.5, 2.5)).collect();
    let (family, name) = ("redundant cranks from a line", format!("cranks_from_a_line_{seed}"));
    Platform { family, name, length, mass, angle: beside, omega, pins, masses }.case()
}

/// Numbers with few digits, so that cranks are parallel to the last bit.
fn few_digits(random: &mut Random, low: f64, high: f64) -> f64 {
    (64.0 * random.between(low, high)).round() / 64.0
}

impl Platform {
    fn scene(&self) -> Scene {
        let mut platform = Body::new().mass(self.mass).inertia(0.4 * self.mass);
        let mut scene = Scene::new(&self.name).gravity([0.0, -9.81]);
        for (k, &pin) in self.pins.iter().enumerate() {
            platform = platform.point(&format!("p{k}"), pin);
            scene = scene.ground_point(&format!("g{k}"), pin);
        }
        scene = scene.body("platform", platform).guess("platform.angle", 0.0);
        if self.angle == 0.0 {
            // The loops leave this open where the cranks lie in line.
            scene = scene.initial("platform.omega", 0.0);
        }
        for (k, &mass) in self.masses.iter().enumerate() {
            let crank = format!("crank_{k}");
            scene = scene
                .body(&crank, bar(mass, self.length))
                .revolute(&format!("low_{k}"), &format!("ground.g{k}"), &format!("{crank}.a"))
                .revolute(&format!("high_{k}"), &format!("{crank}.b"), &format!("platform.p{k}"));
            scene = match k {
                0 => scene.initial("crank_0.angle", self.angle).initial("crank_0.omega", self.omega),
                _ => scene.guess(&format!("{crank}.angle"), self.angle),
            };
        }
        scene
    }

    /// The platform only goes round: a pendulum.
    fn case(self) -> Case {
        const TIMES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
        let scene = self.scene();
        let Self { family, length, mass, angle, omega, pins, masses, .. } = self;
        let mut inertias = vec![[mass, 0.4 * mass]];
        inertias.extend(masses.iter().map(|m| [*m, m * length * length / 12.0]));
        let pose = |q: &[Jet]| {
            let (s, c) = q[0].sin_cos();
            let arm = |[x, y]: [f64; 2]| Arm::from(fixed([x, y]), [c, s], length);
            let [x, y] = arm([0.0, 0.0]).tip;
            let mut poses = vec![[x, y, Jet::constant(1.0), Jet::constant(0.0)]];
            poses.extend(pins.iter().map(|&pin| arm(pin).middle()));
            poses
        };
        let exact = ClosedForm { inertias, pose, force: |_: f64, _: &[f64], _: &[f64]| vec![0.0], gravity: 9.81 };
        let states = exact.states([vec![angle], vec![omega]], &TIMES);
        let values = states.iter().map(|[q, v]| vec![q[0], v[0], q[0], v[0], 0.0]).collect();
        let names = ["crank_0.angle", "crank_0.omega", "crank_2.angle", "crank_2.omega", "platform.angle"];
        let reference = Reference { names: names.map(String::from).into(), times: TIMES.into(), values };
        let law = Law::Constant { terms: vec![("platform.angle".into(), 1.0)], value: 0.0, turns: true };
        Case::new(family, scene, 4.0, vec![law]).against(reference)
    }
}

/// Three cranks in a row, nearly parallelograms, the outer cranks a little longer each. The first turns all the way round; where it lies along its base, one after the
/// other of the two loops comes close to lying flat, and the next crank turns back.
pub fn three_cranks(seed: u64) -> Case {
    const TIMES: [f64; 4] = [0.5, 1.0, 2.0, 3.0];
    let mut random = Random(seed);
    let (first, bases) = (random.between(0.4, 0.6), [random.between(0.9, 1.2), random.between(0.9, 1.2)]);
    let (angle, omega) = (random.between(0.7, 2.2), random.between(4.0, 8.0));
    // Crank and coupler: with an excess of the coupler smaller than the crank's, no pose is out of reach.
    let mut longer = |crank: f64, base: f64| {
        let excess = 10.0_f64.powf(random.between(-4.0, -2.0));
        [base + excess * random.between(-0.5, 0.5), crank + excess]
    };
    let second = longer(first, bases[0]);
    let third = longer(second[1], bases[1]);
    let [near, far] = [[bases[0], 0.0], [bases[0] + bases[1], 0.0]];
    let arms = |q: &[Jet]| {
        let (s, c) = q[0].sin_cos();
        let crank = Arm::from(fixed([0.0, 0.0]), [c, s], first);
        let [coupler_1, crank_1] = dyad(crank.tip, fixed(near), second, true);
        let [coupler_2, crank_2] = dyad(crank_1.tip, fixed(far), third, true);
        [crank, coupler_1, crank_1, coupler_2, crank_2]
    };
    const NAMES: [&str; 5] = ["crank_0", "coupler_1", "crank_1", "coupler_2", "crank_2"];
    let lengths = [first, second[0], second[1], third[0], third[1]];
    let inertias = lengths.map(|length| [length, length.powi(3) / 12.0]).to_vec();
    let pose = |q: &[Jet]| arms(q).map(|arm| arm.middle()).to_vec();
    let exact = ClosedForm { inertias, pose, force: |_: f64, _: &[f64], _: &[f64]| vec![0.0], gravity: 9.81 };
    let motions = |state: &State| [0, 1, 2, 3, 4].map(|body| exact.motion(body, state));
    let start: State = [vec![angle], vec![omega]];
    let states = exact.states(start.clone(), &TIMES);
    let values = states.iter().map(|state| motions(state).iter().flat_map(|motion| [motion[2], motion[5]]).collect());
    let names = NAMES.iter().flat_map(|body| [format!("{body}.angle"), format!("{body}.omega")]).collect();
    let reference = Reference { names, times: TIMES.into(), values: values.collect() };
    let mut scene = Scene::new(&format!("three_cranks_{seed}"))
        .gravity([0.0, -9.81])
        .ground_point("p1", near)
        .ground_point("p2", far);
    for (body, length) in NAMES.into_iter().zip(lengths) {
        scene = scene.body(body, bar(length, length));
    }
    scene = scene
        .revolute("pivot_0", "ground", "crank_0.a")
        .initial("crank_0.angle", angle)
        .initial("crank_0.omega", omega);
    for k in [1, 2] {
        let (crank, coupler) = (format!("crank_{k}"), format!("coupler_{k}"));
        scene = scene
            .revolute(&format!("pivot_{k}"), &format!("ground.p{k}"), &format!("{crank}.a"))
            .revolute(&format!("left_{k}"), &format!("crank_{}.b", k - 1), &format!("{coupler}.a"))
            .revolute(&format!("right_{k}"), &format!("{coupler}.b"), &format!("{crank}.b"));
    }
    for (body, motion) in NAMES.into_iter().zip(motions(&start)).skip(1) {
        scene = scene.guess(&format!("{body}.angle"), motion[2]);
    }
    // Next to the flat poses rounding errors are divided by how little the bars are too long: the reference is known to 1e-8.
    Case::new("three cranks, nearly flat", scene, 3.0, vec![]).against(reference).within(1000.0, 1e-7)
}
