//! Four-bars with a change point: exactly, nearly, and with a stiff spring on the rocker.

use std::f64::consts::PI;

use cotree::scene::{Body, Load, Scene};

use super::{Angle, Case, Law, Random};

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
    pub fn angles(&self) -> [f64; 2] {
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

    pub fn law(&self) -> Law {
        self.law_of(["crank", "coupler", "rocker"])
    }

    /// With these names of its bars.
    pub fn law_of(&self, names: [&str; 3]) -> Law {
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

    pub fn case(&self, family: &'static str, name: &str, stop: f64) -> Case {
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
/// Its damping, in shares of the critical one.
const DAMPED: [f64; 3] = [1.0, 0.01, 0.0];

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

/// Change points whose rocker carries a flap on a stiff spring, damped critically, weakly or not at all, or on a stiff damper alone. With the first member of the
/// family come kite, rhombus and parallelogram.
pub fn stiff_at_change_points(seed: u64, stiffnesses: &[f64], dampings: &[f64]) -> Vec<Case> {
    let special =
        [FourBar::new(0.8, 1.5, 1.5, 0.8), FourBar::new(1.0, 1.0, 1.0, 1.0), FourBar::new(1.0, 2.0, 1.0, 2.0)];
    let special = special.map(|bars| FourBar { omega: 5.0, ..bars });
    let bars = std::iter::once(neutral(seed)).chain(special.into_iter().filter(|_| seed == 0));
    let critical = |stiffness: f64| 2.0 * (stiffness * FLAP).sqrt();
    let damped = |&stiffness: &f64| DAMPED.map(|share| (stiffness, share * critical(stiffness)));
    let mut loads: Vec<(f64, f64)> = stiffnesses.iter().flat_map(damped).collect();
    loads.extend(dampings.iter().map(|&damping| (0.0, damping)));
    let named = |bars: FourBar| {
        loads.iter().map(move |&(stiffness, damping)| {
            with_flap(bars, &format!("flap_{seed}_{stiffness:e}_{damping:.0e}"), stiffness, damping)
        })
    };
    bars.flat_map(named).collect()
}

pub fn bar(mass: f64, length: f64) -> Body {
    let half = length / 2.0;
    let body = Body::new().mass(mass).inertia(mass * length * length / 12.0);
    body.point("a", [-half, 0.0]).point("b", [half, 0.0])
}
