//! Linear systems and modes against closed forms, and against themselves in other coordinates.

use super::support::*;
use cotree_fmu::model::Model;
use cotree_study::analysis::{AnalysisFailure, OperatingPoint, StateSpace, Variation, modes};
use nalgebra::{Complex, DMatrix, DVector, Matrix2};

#[test]
fn a_pendulum_on_a_cart_as_in_the_textbook() {
    at_equilibrium(&scene_of("cart_pole"), |_, system| {
        // Upright: q = (s, angle), the pole's centre at half its length.
        let (m, total, g, l) = (0.2, 1.2, 9.81, 0.5);
        let inertia = m * 1.0 / 12.0 + m * l * l;
        let mass = Matrix2::new(total, -m * l, -m * l, inertia);
        let inverse = mass.try_inverse().unwrap();
        let stiffness = inverse * Matrix2::new(0.0, 0.0, 0.0, m * g * l);
        let damping = inverse * Matrix2::new(-0.5, 0.0, 0.0, -0.01);
        let names: Vec<&str> = system.states.iter().map(|state| state.name.as_str()).collect();
        assert_eq!(names, ["rail.s", "pole.angle", "rail.v", "pole.omega"]);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            close("K", system.a[(2 + i, j)], stiffness[(i, j)], 1e-12, 1.0);
            close("C", system.a[(2 + i, 2 + j)], damping[(i, j)], 1e-12, 1.0);
            close("v", system.a[(i, 2 + j)], f64::from(u8::from(i == j)), 1e-15, 1.0);
        }
        close("B", system.b[(2, 0)], inverse[(0, 0)], 1e-12, 1.0);
        close("B", system.b[(3, 0)], inverse[(1, 0)], 1e-12, 1.0);
    });
}

/// The block with a law, in the middle, moving at this speed.
fn with_law(law: &str, speed: f64) -> String {
    block_with_law(law, &format!("[initial]\n\"guide.s\" = 0\n\"guide.v\" = {speed}\n"))
}

/// Laws that have a derivative on each side but none at the point have no linear system there; those with one derivative have.
#[test]
fn a_law_that_changes_its_piece_at_the_point_has_no_linear_system() {
    let system = |law: &str, speed: f64| {
        with(&with_law(law, speed), |formulated| {
            let variation = Variation::new(formulated);
            let model = Model::new(formulated.lowered.program.clone()).unwrap();
            let point = OperatingPoint::moving(&model, &formulated.state).unwrap();
            StateSpace::new(formulated, &variation, &point, None).map(|system| [system.a[(1, 0)], system.a[(1, 1)]])
        })
    };
    for (law, name) in [
        ("-5*sign(rate)", "`guide.v`"),
        ("-5*abs(rate)", "`guide.v`"),
        ("-50*max(length - 1, 0)", "`guide.s`"),
        ("if(length > 1, -50*(length - 1) - 1e-3, 0)", "`guide.s`"),
        ("-2*floor(length)", "`guide.s`"),
    ] {
        let why = system(law, 0.0).expect_err(law).to_string();
        assert!(why.contains("no derivatives: a piecewise law") && why.contains(name), "{law}: {why}");
    }
    for (law, speed, expected) in [
        ("-5*sign(rate)", 0.3, [-100.0, 0.0]),
        ("-5*abs(rate)*rate", 0.0, [-100.0, 0.0]),
        ("-5*abs(rate)*rate", 0.3, [-100.0, -3.0]),
        ("-50*max(length - 1, 0)^2", 0.0, [-100.0, 0.0]),
        ("-50*max(length - 0.5, 0)", 0.0, [-150.0, 0.0]),
    ] {
        let found = system(law, speed).unwrap_or_else(|why| panic!("{law}: {why}"));
        for (found, expected) in found.into_iter().zip(expected) {
            close(law, found, expected, 1e-12, 1.0);
        }
    }
}

#[test]
fn a_pendulum_swings_as_its_length_says() {
    let text = PENDULUM.replace("GUESS", "-80 deg");
    at_equilibrium(&text, |formulated, system| {
        let modes = modes(formulated, system).unwrap();
        let (inertia, arm, mass) = (0.3, 0.7, 2.0);
        let square: f64 = mass * 9.81 * arm / (inertia + mass * arm * arm);
        assert_eq!(modes.len(), 1);
        close("frequency", modes[0].frequency(), square.sqrt() / std::f64::consts::TAU, 1e-12, 1.0);
        close("damping", modes[0].damping_ratio().unwrap(), 0.0, 1e-12, 1.0);
        assert_eq!(modes[0].shape, [Complex::from(1.0)]);
    });
}

#[test]
fn a_double_pendulum_has_the_modes_of_its_closed_form() {
    let text = scene_of("double_pendulum").replace("-20 deg", "-89 deg").replace("40 deg", "-88 deg");
    at_equilibrium(&text, |formulated, system| {
        let (m1, l1, m2, l2, g) = (1.0, 1.0, 0.7, 0.8, 9.81);
        let coupling = m2 * l1 * l2 / 2.0;
        let mass = Matrix2::new(m1 * l1 * l1 / 3.0 + m2 * l1 * l1, coupling, coupling, m2 * l2 * l2 / 3.0);
        let stiffness = Matrix2::new((m1 / 2.0 + m2) * g * l1, 0.0, 0.0, m2 * g * l2 / 2.0);
        // det(K - w^2 M) = 0
        let (a, c) = (mass.determinant(), stiffness.determinant());
        let b = -(mass[(0, 0)] * stiffness[(1, 1)] + mass[(1, 1)] * stiffness[(0, 0)]);
        let root = f64::sqrt(b * b - 4.0 * a * c);
        let modes = modes(formulated, system).unwrap();
        assert_eq!(modes.len(), 2);
        for (mode, square) in modes.iter().zip([(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]) {
            close("eigenvalue", mode.eigenvalue.im, f64::sqrt(square), 1e-11, 1.0);
            // (K - w^2 M) shape = 0
            let ratio = (stiffness[(0, 0)] - square * mass[(0, 0)]) / (square * coupling);
            close("shape", (mode.shape[1] / mode.shape[0]).re, ratio, 1e-9, 1.0);
        }
    });
}

/// Eigenvalues with a positive imaginary part of M x'' + D x' + K x = 0.
fn of_second_order(mass: &DMatrix<f64>, damping: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let n = mass.nrows();
    let inverse = mass.clone().try_inverse().unwrap();
    let mut system = DMatrix::zeros(2 * n, 2 * n);
    system.view_mut((0, n), (n, n)).fill_with_identity();
    system.view_mut((n, 0), (n, n)).copy_from(&(-&inverse * stiffness));
    system.view_mut((n, n), (n, n)).copy_from(&(-inverse * damping));
    let mut values: Vec<_> = system.complex_eigenvalues().iter().copied().filter(|value| value.im > 0.0).collect();
    values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    values
}

#[test]
fn masses_on_a_line_have_the_eigenvalues_of_their_matrices() {
    // In x1..x4 of models/vibration.
    let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 1.5, 0.8]));
    let assemble = |elements: &[(Option<usize>, usize, f64)]| {
        let mut matrix = DMatrix::zeros(4, 4);
        for &(from, to, value) in elements {
            matrix[(to, to)] += value;
            if let Some(from) = from {
                matrix[(from, from)] += value;
                matrix[(from, to)] -= value;
                matrix[(to, from)] -= value;
            }
        }
        matrix
    };
    let damping = assemble(&[(None, 0, 0.6), (Some(2), 3, 0.4), (None, 3, 0.5)]);
    let stiffness = assemble(&[
        (None, 0, 40.0),
        (Some(0), 1, 25.0),
        (Some(0), 2, 15.0),
        (None, 2, 30.0),
        (Some(2), 3, 12.0),
        (Some(2), 1, 35.0),
        (None, 1, 10.0),
        (Some(1), 3, 20.0),
        (None, 3, 50.0),
    ]);
    let expected = of_second_order(&mass, &damping, &stiffness);
    at_equilibrium(&scene_of("vibration"), |formulated, system| {
        let modes = modes(formulated, system).unwrap();
        assert_eq!(modes.len(), 4);
        for (mode, expected) in modes.iter().zip(&expected) {
            assert!((mode.eigenvalue - expected).norm() < 1e-11 * expected.norm(), "{} {expected}", mode.eigenvalue);
            // x2 = x3 + length of k13, x4 = x2 + length of k15.
            let [x1, x3, k13, k15] = [0, 1, 2, 3].map(|index| mode.shape[index]);
            let x = DVector::from_vec(vec![x1, x3 + k13, x3, x3 + k13 + k15]);
            let complex = |matrix: &DMatrix<f64>| matrix.map(Complex::from);
            let lambda = mode.eigenvalue;
            let rest =
                complex(&mass) * &x * (lambda * lambda) + complex(&damping) * &x * lambda + complex(&stiffness) * &x;
            assert!(rest.camax() < 1e-9 * stiffness.amax());
        }
    });
}

#[test]
fn free_motion_is_named_and_leaves_the_rest_exact() {
    let chain = r#"
        format = 1
        name = "free"
        dimension = 1
        [bodies.left]
        mass = 2.0
        [bodies.right]
        mass = 3.0
        [loads.spring]
        type = "spring"
        between = ["left", "right"]
        stiffness = 6.0
        length = 0.0
        damping = DAMPING
    "#;
    for damping in [0.0, 0.3] {
        at_equilibrium(&chain.replace("DAMPING", &format!("{damping:?}")), |formulated, system| {
            let modes = modes(formulated, system).unwrap();
            assert_eq!(modes.len(), 2);
            assert!(modes[0].is_free() && modes[0].damping_ratio().is_none());
            // Together: the length of the spring, if it is a coordinate, does not change.
            let moving: Vec<f64> = modes[0].shape.iter().map(|value| value.re).collect();
            let names: Vec<&str> = formulated.equations.coordinates.iter().map(|q| q.name.position.as_str()).collect();
            for (name, value) in names.iter().zip(moving) {
                close(name, value, if name.ends_with(".x") { 1.0 } else { 0.0 }, 1e-12, 1.0);
            }
            let square: f64 = 6.0 * (1.0 / 2.0 + 1.0 / 3.0);
            let real = -damping * (1.0 / 2.0 + 1.0 / 3.0) / 2.0;
            close("real", modes[1].eigenvalue.re, real, 1e-12, 1.0);
            close("imaginary", modes[1].eigenvalue.im, (square - real * real).sqrt(), 1e-12, 1.0);
        });
    }
}

/// A four-bar at rest between torsion springs that are free in this pose: one degree of freedom, w^2 = K/M by the velocity ratios.
#[test]
fn a_four_bar_on_torsion_springs_has_the_frequency_of_its_one_degree_of_freedom() {
    let (a, b, c, d) = (0.2_f64, 0.5, 0.4, 0.5);
    let crank = 1.1_f64;
    let (x, y) = (d - a * crank.cos(), -a * crank.sin());
    let diagonal = x.hypot(y);
    let coupler = y.atan2(x) + ((b * b + diagonal * diagonal - c * c) / (2.0 * b * diagonal)).acos();
    let rocker = (a * crank.sin() + b * coupler.sin()).atan2(a * crank.cos() + b * coupler.cos() - d);
    // Velocity ratios from the loop's rate.
    let coupler_ratio = -a * (crank - rocker).sin() / (b * (coupler - rocker).sin());
    let rocker_ratio = a * (crank - coupler).sin() / (c * (rocker - coupler).sin());
    let centre = nalgebra::Vector2::new(-crank.sin(), crank.cos()) * a
        + nalgebra::Vector2::new(-coupler.sin(), coupler.cos()) * (b / 2.0 * coupler_ratio);
    let mass = 0.01
        + 1.0 * (a / 2.0).powi(2)
        + 0.8 * centre.norm_squared()
        + 0.017 * coupler_ratio.powi(2)
        + (0.008 + 0.6 * (c / 2.0).powi(2)) * rocker_ratio.powi(2);
    let stiffness = 2.0 + 3.0 * rocker_ratio.powi(2);
    let damping = 0.02 + 0.05 * rocker_ratio.powi(2);
    let text = scene_of("four_bar")
        .replace("gravity = [0.0, -9.81]", "")
        .replace("torsion_actuator", "torsion_spring")
        .replace("torque  = \"stall_torque*(1 - omega/no_load_speed)\"", &format!("stiffness = 2.0\nangle = {crank:?}"))
        .replace("angle     = \"100 deg\"", &format!("angle = {rocker:?}"))
        .replace("\"60 deg\"", &format!("{crank:?}"));
    for preset in ["recommended", "absolute", "joint"] {
        let text = format!("{text}\n[coordinates]\npreset = \"{preset}\"\n");
        at_equilibrium(&text, |formulated, system| {
            assert_eq!(system.states.len(), 2, "{preset}");
            let modes = modes(formulated, system).unwrap();
            let real = -damping / (2.0 * mass);
            close("real", modes[0].eigenvalue.re, real, 1e-9, 1.0);
            close("imaginary", modes[0].eigenvalue.im, (stiffness / mass - real * real).sqrt(), 1e-9, 1.0);
            let place = |name: &str| formulated.equations.coordinates.iter().position(|q| q.name.position == name);
            if let (Some(first), Some(second)) = (place("crank.angle"), place("rocker.angle")) {
                close("shape", (modes[0].shape[second] / modes[0].shape[first]).re, rocker_ratio, 1e-9, 1.0);
            }
        });
    }
}

/// A parallelogram folded flat can open in two ways.
#[test]
fn a_pose_with_more_freedom_is_named() {
    let text = scene_of("four_bar")
        .replace("\"0.2 m\"", "\"0.4 m\"")
        .replace("\"60 deg\"", "\"70 deg\"")
        .replace("{ guess = \"90 deg\" }", "{ guess = \"70 deg\" }")
        .replace("{ guess = \"20 deg\" }", "{ guess = \"0 deg\" }");
    with(&text, |formulated| {
        let variation = Variation::new(formulated);
        let model = Model::new(formulated.lowered.program.clone()).unwrap();
        let mut point = OperatingPoint::resting(&model, &formulated.state);
        assert!(StateSpace::new(formulated, &variation, &point, None).is_ok());
        point.positions_mut().fill(0.0);
        let failure = StateSpace::new(formulated, &variation, &point, None).unwrap_err();
        assert!(matches!(failure, AnalysisFailure::Singular { .. }), "{failure}");
        assert!(failure.to_string().contains(".angle` is not determined"), "{failure}");
    });
}

#[test]
fn trees_do_not_change_the_eigenvalues() {
    for scene in ["slider_crank", "double_pendulum", "andrews"] {
        let of = |preset: &str| {
            let text = format!("{}\n[coordinates]\npreset = \"{preset}\"\n", scene_of(scene));
            let mut values = Vec::new();
            at_equilibrium(&text, |formulated, system| {
                let modes = modes(formulated, system).unwrap();
                values = modes.into_iter().map(|mode| mode.eigenvalue).collect::<Vec<_>>();
                assert_eq!(system.states.len(), 2 * formulated.mobility(), "{scene} {preset}");
            });
            values
        };
        let expected = of("recommended");
        assert!(!expected.is_empty());
        for preset in ["absolute", "joint"] {
            let values = of(preset);
            assert_eq!(values.len(), expected.len());
            for (value, expected) in values.iter().zip(&expected) {
                assert!((value - expected).norm() < 1e-7 * expected.norm(), "{scene} {preset}: {value} {expected}");
            }
        }
    }
}
