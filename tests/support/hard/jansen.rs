//! Jansen's leg over many turns.

use cotree::scene::{Body, Driver, Scene};

use super::{Case, Law};

/// Jansen's leg: its crank turns 1000 times and everything comes back.
pub fn jansen() -> Case {
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
