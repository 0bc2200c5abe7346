//! Other mechanisms with poses in which they could turn off, and starts in such a pose.

use cotree::scene::{Body, Scene};

use super::four_bar::bar;
use super::{Case, FourBar, Law, Random};

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
pub fn coupled(seed: u64) -> Case {
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
pub fn equal_slider_crank(omega: f64, angle: f64) -> Case {
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
pub fn redundant(omega: f64) -> Case {
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

/// Starts that lie flat: rates that belong to one branch lead on, others do not say which.
pub fn starts(seed: u64) -> Vec<Case> {
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
