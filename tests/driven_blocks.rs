//! Driven mechanisms fall apart into small systems that are solved one after another; the recommended trees keep them small.

use std::sync::Arc;

use cotree::formulate::{Formulated, formulate};
use cotree::model::{CoordinateChoice, Mechanism};
use cotree::scene::{Body, Driver, Resolved, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

type Point = [f64; 2];

/// The meeting point of two circles on the left of the way from the first centre to the second.
fn meet(a: Point, ra: f64, b: Point, rb: f64) -> Point {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let distance = dx.hypot(dy);
    let along = (ra * ra - rb * rb + distance * distance) / (2.0 * distance);
    let across = (ra * ra - along * along).sqrt();
    let (ux, uy) = (dx / distance, dy / distance);
    [a[0] + along * ux - across * uy, a[1] + along * uy + across * ux]
}

/// A body whose frame lies in its first corner with the second on its x axis, and its angle.
fn plate(corners: &[(&str, Point)]) -> (Body, f64) {
    let ((_, origin), (_, second)) = (corners[0], corners[1]);
    let angle = (second[1] - origin[1]).atan2(second[0] - origin[0]);
    let (sine, cosine) = angle.sin_cos();
    let body = corners.iter().fold(Body::new(), |body, (name, [x, y])| {
        let (x, y) = (x - origin[0], y - origin[1]);
        body.point(name, [cosine * x + sine * y, cosine * y - sine * x])
    });
    (body, angle)
}

/// Jansen's leg with his numbers: a crank, and three pairs of bodies that follow one after another.
fn leg() -> Scene {
    let (o, p, c) = ([0.0, 0.0], [-38.0, -7.8], [15.0, 0.0]);
    let a = meet(p, 41.5, c, 50.0);
    let d = meet(c, 61.9, p, 39.3);
    let b = meet(p, 40.1, a, 55.8);
    let e = meet(d, 36.7, b, 39.4);
    let f = meet(d, 49.0, e, 65.7);
    let bodies = [
        ("crank", plate(&[("o", o), ("c", c)])),
        ("upper", plate(&[("c", c), ("a", a)])),
        ("wing", plate(&[("p", p), ("a", a), ("b", b)])),
        ("lower", plate(&[("c", c), ("d", d)])),
        ("swing", plate(&[("p", p), ("d", d)])),
        ("rear", plate(&[("b", b), ("e", e)])),
        ("foot", plate(&[("d", d), ("e", e), ("f", f)])),
    ];
    let scene = Scene::new("leg").ground_point("p", p).driver("motor", Driver::angle("shaft", "2*t"));
    let scene = bodies.into_iter().fold(scene, |scene, (name, (body, angle))| {
        let scene = scene.body(name, body);
        if name == "crank" { scene } else { scene.guess(&format!("{name}.angle"), angle) }
    });
    let pins = [
        ("shaft", "ground", "crank.o"),
        ("c1", "crank.c", "upper.c"),
        ("c2", "crank.c", "lower.c"),
        ("a1", "upper.a", "wing.a"),
        ("p1", "ground.p", "wing.p"),
        ("p2", "ground.p", "swing.p"),
        ("d1", "lower.d", "swing.d"),
        ("d2", "swing.d", "foot.d"),
        ("b1", "wing.b", "rear.b"),
        ("e1", "rear.e", "foot.e"),
    ];
    let scene = pins.into_iter().fold(scene, |scene, (name, first, second)| scene.revolute(name, first, second));
    OUTPUTS.into_iter().fold(scene, |scene, name| scene.output(name)).stop(1.0)
}

const OUTPUTS: [&str; 4] = ["foot.f.x", "foot.f.y", "foot.omega", "foot.alpha"];

fn with(mechanism: &Mechanism, coordinates: CoordinateChoice) -> Mechanism {
    Mechanism { coordinates, ..mechanism.clone() }
}

/// The outputs half a second later.
fn later(formulated: &Formulated) -> Vec<f64> {
    let mut instance = Instance::new(Arc::new(Model::new(formulated.lowered.program.clone()).unwrap()));
    instance.setup(0.0, None, Some(1e-10)).unwrap();
    instance.initialise().unwrap();
    instance.step_to(0.5).unwrap();
    OUTPUTS.map(|name| instance.get(instance.variable(name).unwrap()).unwrap()).to_vec()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-8 * (1.0 + expected.abs()), "{found} instead of {expected}");
    }
}

fn block_sizes(formulated: &Formulated) -> Vec<usize> {
    formulated.lowered.blocks.iter().map(|block| block.columns.len()).collect()
}

#[test]
fn a_leg_keeps_its_three_pairs_apart_where_absolute_coordinates_tie_more_together_and_move_alike() {
    let Resolved { mechanism, outputs, .. } = leg().resolve().unwrap();
    let formulate = |mechanism: &Mechanism| formulate(mechanism, &outputs);
    let absolute = with(&mechanism, CoordinateChoice::Absolute);
    let [fine, coarse] = [&mechanism, &absolute].map(|mechanism| block_sizes(&formulate(mechanism).unwrap()));
    assert_eq!(fine, [2, 2, 2]);
    let work = |sizes: &[usize]| sizes.iter().map(|size| size.pow(3)).sum::<usize>();
    assert!(work(&coarse) > work(&fine), "{coarse:?}");
    assert_close(&later(&formulate(&absolute).unwrap()), &later(&formulate(&mechanism).unwrap()));
}
