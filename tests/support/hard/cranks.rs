//! Cranks side by side: more of them than a platform needs, and pairs that come close to lying flat.

use cotree::scene::{Body, Scene};

use super::closed_form::{ClosedForm, State};
use super::dyad::{Arm, dyad, fixed};
use super::four_bar::bar;
use super::reference::Reference;
use super::{Case, Law, Random};
use crate::support::jet::Jet;

/// A platform on three to six parallel cranks: it needs two, and all of them turn alike. Its pins lie on no line, so nothing ever lies flat.
pub fn redundant(seed: u64) -> Case {
    const TIMES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
    let mut random = Random(seed);
    let count = 3 + (random.unit() * 4.0) as usize;
    let (length, mass) = (random.between(0.3, 1.0), random.between(0.5, 5.0));
    let (angle, omega) = (random.between(-3.0, 3.0), random.between(2.0, 12.0));
    // Numbers with few digits, so that the cranks are parallel to the last bit.
    let mut short = |low: f64, high: f64| (64.0 * random.between(low, high)).round() / 64.0;
    let pins: Vec<[f64; 2]> = (0..count).map(|k| [k as f64 + short(-0.2, 0.2), short(-0.5, 0.5)]).collect();
    let masses: Vec<f64> = (0..count).map(|_| short(0.5, 2.5)).collect();
    let mut platform = Body::new().mass(mass).inertia(0.4 * mass);
    let mut scene = Scene::new(&format!("redundant_cranks_{seed}")).gravity([0.0, -9.81]);
    for (k, &pin) in pins.iter().enumerate() {
        platform = platform.point(&format!("p{k}"), pin);
        scene = scene.ground_point(&format!("g{k}"), pin);
    }
    scene = scene.body("platform", platform).guess("platform.angle", 0.0);
    for (k, &crank_mass) in masses.iter().enumerate() {
        let crank = format!("crank_{k}");
        scene = scene
            .body(&crank, bar(crank_mass, length))
            .revolute(&format!("low_{k}"), &format!("ground.g{k}"), &format!("{crank}.a"))
            .revolute(&format!("high_{k}"), &format!("{crank}.b"), &format!("platform.p{k}"));
        scene = if k == 0 {
            scene.initial("crank_0.angle", angle).initial("crank_0.omega", omega)
        } else {
            scene.guess(&format!("{crank}.angle"), angle)
        };
    }
    // The platform only goes round: a pendulum.
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
    Case::new("redundant cranks", scene, 4.0, vec![law]).against(reference)
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
    Case::new("three cranks, nearly flat", scene, 3.0, vec![]).against(reference)
}
