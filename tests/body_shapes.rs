//! Shapes of bodies against closed forms, the parallel axis theorem and Green's theorem.

use crate::support::{motion, run};

use std::f64::consts::PI;

use cotree::model::{Formula, Outline};
use cotree::scene::{Body, Corner, Scene, Shape};
use proptest::prelude::*;

use motion::Run;

const G: f64 = 9.81;

fn number(formula: &Formula) -> f64 {
    match formula {
        Formula::Number(number) => *number,
        other => panic!("{other:?} is not a number"),
    }
}

/// A body with the point `origin` at the origin of its frame: mass, mass centre, and inertia about it.
fn properties(body: Body) -> (f64, [f64; 2], f64) {
    let scene = Scene::new("body").body("body", body.point("origin", [0.0, 0.0]));
    let mechanism = run::sound(scene.resolve()).mechanism;
    let body = &mechanism.bodies[0];
    let origin = body.points.last().unwrap().at.each_ref().map(number);
    (number(body.mass.as_ref().unwrap()), origin.map(|x| -x), number(body.inertia.as_ref().unwrap()))
}

fn close(value: f64, expected: f64, scale: f64) -> bool {
    (value - expected).abs() <= 1e-12 * scale.abs().max(expected.abs())
}

fn assert_properties(shape: Shape, mass: f64, centre: [f64; 2], inertia: f64) {
    let (m, c, i) = properties(Body::new().shape(shape));
    assert!(close(m, mass, mass) && close(i, inertia, inertia), "{m} {i}, not {mass} {inertia}");
    assert!((0..2).all(|axis| close(c[axis], centre[axis], 1.0)), "{c:?}, not {centre:?}");
}

#[test]
fn a_rod_a_disc_and_a_plate_have_their_closed_forms() {
    let length = 0.5_f64.hypot(0.3);
    let mass = 2.1 * length;
    assert_properties(
        Shape::rod([0.1, 0.2], [0.6, 0.5]).density("2.1 kg/m"),
        mass,
        [0.35, 0.35],
        mass * length.powi(2) / 12.0,
    );
    let mass = 7850.0 * 2e-4 * length;
    let rod = Shape::rod([0.1, 0.2], [0.6, 0.5]).density("7850 kg/m3").area("2 cm2");
    assert_properties(rod, mass, [0.35, 0.35], mass * length.powi(2) / 12.0);
    let mass = 7850.0 * 0.012 * PI * 0.06 * 0.06;
    let disc = Shape::disc([0.3, -0.1], "60 mm").density(7850.0).thickness("12 mm");
    assert_properties(disc, mass, [0.3, -0.1], mass * 0.06 * 0.06 / 2.0);
    let mass = 21.0 * 0.4 * 0.1;
    // Either pair of opposite corners, in either order.
    for corners in [[[-0.1, 0.0], [0.3, 0.1]], [[0.3, 0.1], [-0.1, 0.0]], [[0.3, 0.0], [-0.1, 0.1]]] {
        let plate = Shape::plate(corners[0], corners[1]).density("21 kg/m2");
        assert_properties(plate, mass, [0.1, 0.05], mass * (0.16 + 0.01) / 12.0);
    }
}

#[test]
fn an_angle_is_two_plates_by_the_parallel_axis_theorem() {
    let corners = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.1, 0.1], [0.1, 0.4], [0.0, 0.4]];
    let parts = [(0.03, [0.15, 0.05], 0.09 + 0.01), (0.03, [0.05, 0.25], 0.01 + 0.09)];
    let area: f64 = parts.iter().map(|part| part.0).sum();
    let centre = [0, 1].map(|axis| parts.iter().map(|(a, c, _)| a * c[axis]).sum::<f64>() / area);
    let away = |c: [f64; 2]| (c[0] - centre[0]).powi(2) + (c[1] - centre[1]).powi(2);
    let second: f64 = parts.iter().map(|(a, c, sides)| a * (sides / 12.0 + away(*c))).sum();
    assert_properties(Shape::polygon(corners).density("10 kg/m2"), 10.0 * area, centre, 10.0 * second);
}

#[test]
fn what_is_given_comes_before_the_shape() {
    let rod = || Shape::rod([0.0, 0.0], [0.6, 0.0]);
    let (mass, centre, inertia) = properties(Body::new().mass(3.0).shape(rod()));
    assert_eq!((mass, centre), (3.0, [0.3, 0.0]));
    assert!(close(inertia, 3.0 * 0.36 / 12.0, 0.1));
    let body = Body::new().mass(3.0).inertia(0.2).com([0.1, 0.0]).shape(rod());
    assert_eq!(properties(body), (3.0, [0.1, 0.0], 0.2));
}

#[test]
fn a_text_and_rust_give_the_same_body() {
    let text = "name = 'plate'\n[bodies.plate]\npoints = { pin = [0, 0], end = ['200 mm', 0] }\n\
                shape = { polygon = ['pin', [0.1, -0.05], 'end', ['0.1 m', 0.15]], thickness = '5 mm', density = '2700 kg/m3' }\n";
    let corners: [Corner; 4] = ["pin".into(), [0.1, -0.05].into(), "end".into(), ("0.1 m", 0.15).into()];
    let shape = Shape::polygon(corners).thickness("5 mm").density("2700 kg/m3");
    let body = Body::new().point("pin", [0, 0]).point("end", ("200 mm", 0)).shape(shape);
    let built = Scene::new("plate").body("plate", body);
    let resolved = run::sound(Scene::from_toml(text)).resolve().unwrap();
    assert_eq!(resolved.mechanism.bodies[0].mass, built.resolve().unwrap().mechanism.bodies[0].mass);
    assert_eq!(resolved.mechanism.bodies[0].inertia, built.resolve().unwrap().mechanism.bodies[0].inertia);
    assert_eq!(resolved.mechanism.bodies[0].points, built.resolve().unwrap().mechanism.bodies[0].points);
    assert!(matches!(&resolved.mechanism.bodies[0].outline, Some(Outline::Polygon(corners)) if corners.len() == 4));
}

/// A pendulum whose sizes and density are parameters starts as one with numbers does, and as the parallel axis theorem says.
#[test]
fn parameters_reach_mass_and_inertia() {
    let scene = |shape: Shape| {
        Scene::new("pendulum")
            .gravity([0.0, -G])
            .parameter("height", "0.4 m")
            .parameter("rho", "30 kg/m2")
            .body("plate", Body::new().point("pin", [0.0, 0.0]).shape(shape))
            .revolute("hinge", "ground", "plate.pin")
            .initial("plate.angle", 0.0)
            .initial("plate.omega", 0.0)
            .with_every_output()
    };
    let corner: [Corner; 3] = ["pin".into(), (0.3, 0.0).into(), (0.0, "height").into()];
    let mut run = Run::new(&scene(Shape::polygon(corner).density("rho")));
    let (mass, centre) = (30.0 * 0.06, [0.1, 0.4 / 3.0]);
    // A right triangle with the legs a and b: m (a^2 + b^2)/18 about its mass centre, m (a^2 + b^2)/6 about the right angle.
    let about_pin = mass * (0.09 + 0.16) / 6.0;
    run.check("plate.alpha", -mass * G * centre[0] / about_pin);
    run.check("energy.total", mass * G * centre[1]);
    run.check("plate.x", centre[0]);
    run.check("plate.y", centre[1]);
    run.to(0.3).check("energy.total", mass * G * centre[1]);
}

/// Area, mass centre and second moment about the origin as integrals along the rim (Green's theorem), by Gauss's rule of three points, which
/// is exact for them.
fn along_the_rim(corners: &[[f64; 2]]) -> (f64, [f64; 2], f64) {
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], 0.0);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        for (node, weight) in [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)] {
            let [x, y] = [0, 1].map(|axis| a[axis] + 0.5 * (1.0 + node) * [dx, dy][axis]);
            area += weight * 0.5 * (x * dy - y * dx);
            first = [first[0] + weight * 0.5 * x * x * dy, first[1] - weight * 0.5 * y * y * dx];
            second += weight * (x * x * x * dy - y * y * y * dx) / 3.0;
        }
    }
    (area, first.map(|moment| moment / area), second)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Star-shaped polygons, convex and not, anywhere and turned by any angle.
    #[test]
    fn a_polygon_is_what_greens_theorem_says(
        radii in proptest::collection::vec(0.2..1.0_f64, 3..12),
        turn in 0.0..6.2_f64,
        shift in [-5.0..5.0_f64, -5.0..5.0_f64],
    ) {
        let step = 2.0 * PI / radii.len() as f64;
        let at = |(index, radius): (usize, &f64)| {
            let angle = turn + step * index as f64;
            [radius * angle.cos(), radius * angle.sin()]
        };
        let corners: Vec<[f64; 2]> = radii.iter().enumerate().map(at).collect();
        let (area, centre, about_origin) = along_the_rim(&corners);
        let inertia = about_origin - area * (centre[0].powi(2) + centre[1].powi(2));
        let moved: Vec<[f64; 2]> = corners.iter().map(|[x, y]| [x + shift[0], y + shift[1]]).collect();
        let (m, c, i) = properties(Body::new().shape(Shape::polygon(moved).density("1 kg/m2")));
        let near = |value: f64, expected: f64| (value - expected).abs() <= 1e-11 * expected.abs().max(1.0);
        prop_assert!(near(m, area) && near(i, inertia), "{} {}, not {} {}", m, i, area, inertia);
        prop_assert!((0..2).all(|axis| near(c[axis], centre[axis] + shift[axis])));
    }

    /// Of the orders of the corners of a star-shaped polygon, only those that go around counter-clockwise are taken.
    #[test]
    fn corners_in_another_order_are_refused(order in Just([0, 1, 2, 3, 4]).prop_shuffle()) {
        let corner = |index: usize| {
            let angle = 2.0 * PI * index as f64 / 5.0;
            [angle.cos(), angle.sin()]
        };
        let shape = Shape::polygon(order.map(corner)).density("1 kg/m2");
        let taken = Scene::new("body").body("body", Body::new().shape(shape)).resolve().is_ok();
        let around = (0..5).all(|i| order[(i + 1) % 5] == (order[i] + 1) % 5);
        prop_assert_eq!(taken, around, "{:?}", order);
    }
}

/// A polygon turned over by a parameter that is set has no mass: the size is that of the corners in their order.
#[test]
fn a_shape_that_a_parameter_turns_over_is_refused() {
    let text = "name = \"turned\"\n[parameters]\nw = \"1 m\"\n[bodies.b]\npoints = { a = [0, 0] }\n\
                shape = { polygon = [[0, 0], [\"w\", 0], [\"w\", 1], [0, 1]], density = \"1 kg/m2\" }\n\
                [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b.a\"]\naxis = [1, 0]\n\
                [outputs]\nvariables = [\"guide.s\"]\n[experiment]\nstop = 0.1\nstep = 0.1\n";
    let scene = cotree::Scene::from_toml(text).expect("a scene");
    let runs = scene.simulate_many(&[vec![("w", 2.0)], vec![("w", -2.0)]]).expect("a parameter");
    assert!(runs[0].is_ok());
    let error = runs[1].as_ref().expect_err("no mass").to_string();
    assert!(error.contains("the size of") && error.contains("must be positive") && error.contains("is -2"), "{error}");
}
