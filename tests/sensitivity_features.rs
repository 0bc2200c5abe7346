//! Derivatives of equilibria, vibrations, peaks and crossing times, against high-order differences and closed forms.

use crate::support::fine;

use cotree::Scene;
use cotree_study::analysis::{NotDifferentiable, Study};

use fine::model;

/// Rests between gravity and its spring; every motion is damped.
fn resting() -> Scene {
    let text = model("slider_crank").replace("load_stiffness = { value = 0.0,", "load_stiffness = { value = 60.0,");
    let text = text.replace("[parameters]", "[parameters]\ndrag = \"0.2 N.s/m\"\n");
    let text = text.replace("\"0.6 rad\"", "\"-1.2 rad\"").replace("\"-0.19 rad\"", "\"0.3 rad\"");
    let text = text.replace("damping   = 0.0", "damping   = \"drag\"");
    assert!(text.contains("60.0") && text.contains("damping   = \"drag\""), "{text}");
    Scene::from_toml(&text).unwrap()
}

/// Central differences of the sixth order of what a study finds with a value changed.
fn difference_of(scene: &Scene, name: &str, find: impl Fn(Study) -> Vec<f64>) -> Vec<f64> {
    let mut nominal = 0.0;
    let with = |value: Option<f64>| {
        let mut study = Study::new(scene).unwrap();
        value.iter().for_each(|value| study.set(name, |_| Ok(*value)).unwrap());
        study
    };
    with(None)
        .varying(&[name.to_owned()], |varying| {
            nominal = varying.parameters()[0].start;
            Ok(())
        })
        .unwrap();
    let step = 2e-3 * nominal.abs().max(0.5);
    let at = |times: f64| find(with(Some(nominal + times * step)));
    let pairs = [1.0, 2.0, 3.0].map(|times| (at(times), at(-times)));
    let weights = [45.0, -9.0, 1.0];
    let sum = |index: usize| {
        let term = |(pair, weight): (&(Vec<f64>, Vec<f64>), &f64)| weight * (pair.0[index] - pair.1[index]);
        pairs.iter().zip(&weights).map(term).sum::<f64>() / (60.0 * step)
    };
    (0..pairs[0].0.len()).map(sum).collect()
}

const AT_REST: [&str; 5] = ["crank_length", "rod_length", "load_stiffness", "gas_force", "drag"];

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn assert_close(found: &[f64], exact: &[f64], limit: f64, what: &str) {
    assert_eq!(found.len(), exact.len(), "{what}");
    let largest = exact.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() <= limit * largest.max(1e-9), "{what}: {found} instead of {exact}");
    }
}

#[test]
fn an_equilibrium() {
    let scene = resting();
    let found = Study::new(&scene).unwrap().equilibrium_sensitivities(&names(&AT_REST)).unwrap();
    for (column, name) in AT_REST.iter().enumerate() {
        let values = |mut study: Study| {
            study.equilibrium_sensitivities(&[]).unwrap().values[0].iter().copied().collect::<Vec<f64>>()
        };
        let exact = difference_of(&scene, name, values);
        let own: Vec<f64> = found.derivatives[0].column(column).iter().copied().collect();
        assert_close(&own, &exact, 1e-7, name);
    }
    // A damper does nothing at rest, and the derivative says so exactly; the others do something.
    assert_eq!(found.derivatives[0].column(4).amax(), 0.0);
    assert!((0..4).all(|column| found.derivatives[0].column(column).amax() > 1e-4));
}

/// Derivatives of eigenvalues against differences.
fn check_eigenvalues(scene: &Scene, by: &[&str], found: &cotree_study::analysis::ModeChanges) {
    for (column, name) in by.iter().enumerate() {
        let values = |mut study: Study| {
            let modes = study.modes(None).unwrap().modes;
            modes.iter().flat_map(|mode| [mode.eigenvalue.re, mode.eigenvalue.im]).collect::<Vec<f64>>()
        };
        let own: Vec<f64> = found.derivatives.iter().flatten().flat_map(|by| [by[column].re, by[column].im]).collect();
        assert_close(&own, &difference_of(scene, name, values), 1e-7, name);
    }
}

#[test]
fn vibrations_about_an_equilibrium_that_moves() {
    let scene = resting();
    let found = Study::new(&scene).unwrap().mode_sensitivities(&names(&AT_REST)).unwrap();
    assert_eq!(found.modes.len(), 1);
    assert!(found.modes[0].frequency() > 0.1 && found.modes[0].damping_ratio().unwrap() > 1e-3, "{:?}", found.modes);
    check_eigenvalues(&scene, &AT_REST, &found);
}

/// Two equal masses on equal springs: s^2 = -k/m, with the same damping; a third one apart.
#[test]
fn eigenvalues_of_oscillators() {
    let scene = |stiffness: f64| {
        let mass = |name: &str, stiffness: &str| {
            format!(
                "[bodies.{name}]\nmass = \"m\"\n[loads.s_{name}]\ntype = \"spring\"\nbetween = [\"ground\", \"{name}\"]\n\
                 stiffness = {stiffness}\nlength = 0.0\ndamping = \"c\"\n"
            )
        };
        let parts = [mass("a", "\"k\""), mass("b", &format!("{stiffness:?}"))].concat();
        let head = "name = \"o\"\ndimension = 1\n[parameters]\nk = \"200 N/m\"\nc = \"6 N.s/m\"\nm = \"2 kg\"\n";
        Scene::from_toml(&format!("{head}{parts}[outputs]\nvariables = [\"a.x\"]\n")).unwrap()
    };
    let by = names(&["k", "c", "m"]);
    let found = Study::new(&scene(450.0)).unwrap().mode_sensitivities(&by).unwrap();
    let slow = found.modes.iter().position(|mode| (mode.eigenvalue.norm() - 10.0).abs() < 1e-9).unwrap();
    let s = found.modes[slow].eigenvalue;
    // m s^2 + c s + k = 0.
    let slope = s * 4.0 + 6.0;
    let exact = [-1.0 / slope, -s / slope, -s * s / slope];
    for (own, exact) in found.derivatives[slow].as_ref().unwrap().iter().zip(exact) {
        assert!((own - exact).norm() < 1e-9 * exact.norm(), "{own} instead of {exact}");
    }
    let other = found.derivatives[1 - slow].as_ref().unwrap();
    assert!(other[0].norm() < 1e-12, "{other:?}");
    // Twice the same: which of the two changes is not determined.
    let found = Study::new(&scene(200.0)).unwrap().mode_sensitivities(&by).unwrap();
    assert!(found.modes.len() == 2 && found.derivatives.iter().all(Option::is_none), "{found:?}");
}

/// Damping that is no multiple of masses and stiffnesses: left and right vectors are complex, and not the same.
#[test]
fn eigenvalues_of_coupled_masses() {
    let ways = [("ground", "a", 29.7, 0.95), ("a", "b", 44.0, 1.09), ("b", "c", 61.0, 0.4), ("ground", "c", 17.0, 0.0)];
    let masses = [("a", 1.2), ("b", 0.84), ("c", 2.1)].map(|(name, mass)| format!("[bodies.{name}]\nmass = {mass}\n"));
    let springs = ways.map(|(from, to, stiffness, damping)| {
        let between = format!("between = [\"{from}\", \"{to}\"]\nlength = 0.0\n");
        let own = format!("stiffness = \"{stiffness}*factor_{to}\"\ndamping = \"{damping}*loss\"\n");
        format!("[loads.{from}_{to}]\ntype = \"spring\"\n{between}{own}")
    });
    let head = "name = \"o\"\ndimension = 1\n[parameters]\nfactor_a = \"1 N/m\"\nfactor_b = \"1 N/m\"\nfactor_c = \"1 N/m\"\nloss = \"1 N.s/m\"\n";
    let text = format!("{head}{}{}[outputs]\nvariables = [\"a.x\"]\n", masses.concat(), springs.concat());
    let scene = Scene::from_toml(&text).unwrap();
    let by = ["factor_a", "factor_b", "factor_c", "loss"];
    let found = Study::new(&scene).unwrap().mode_sensitivities(&names(&by)).unwrap();
    assert_eq!(found.modes.len(), 3);
    check_eigenvalues(&scene, &by, &found);
}

#[test]
fn what_rests_without_stiffness_has_no_derivatives() {
    let text = model("slider_crank").replace("gravity = [0.0, -9.81]", "gravity = [0.0, 0.0]");
    let error =
        Study::new(&Scene::from_toml(&text).unwrap()).unwrap().equilibrium_sensitivities(&names(&["rod_length"]));
    assert!(error.unwrap_err().to_string().contains("no stiffness"));
}

#[test]
fn peaks_and_crossings() {
    let scene = Scene::from_toml(&model("slider_crank")).unwrap();
    let to = ["crank_length", "rod_length", "crank.angle"];
    let times: Vec<f64> = (0..=125).map(|index| 0.02 * f64::from(index)).collect();
    let levels = [("cylinder.s".to_owned(), 1.7), ("crank.angle".to_owned(), 0.0)];
    let found = Study::new(&scene).unwrap().features(&names(&to), &times, &levels).unwrap().features;
    assert!(
        found.iter().filter(|own| own.kind == cotree_study::analysis::FeatureKind::Crossing).count() >= 3,
        "{found:?}"
    );
    for (column, name) in to.iter().enumerate() {
        let values = |mut study: Study| {
            let features = study.features(&[], &times, &levels).unwrap().features;
            features.iter().flat_map(|own| [own.value, own.time]).collect::<Vec<f64>>()
        };
        let exact = difference_of(&scene, name, values);
        for (own, exact) in found.iter().zip(exact.chunks(2)) {
            let what = format!("{name}, {own:?}, {exact:?}");
            if own.output.0 == "energy.total" {
                assert!(own.changes.as_ref().is_err_and(|why| *why == NotDifferentiable::Constant), "{what}");
                continue;
            }
            let by = own.changes.as_ref().unwrap();
            let error = [by.value[column] - exact[0], by.time[column] - exact[1]].map(f64::abs);
            assert!(error[0] < 1e-7 * exact[0].abs().max(own.value.abs()).max(1e-2), "{what}");
            assert!(error[1] < 1e-6 * exact[1].abs().max(1.0), "{what}");
        }
    }
}

/// They do not depend on the communication points.
#[test]
fn peaks_and_crossings_between_two_times() {
    let scene = Scene::from_toml(&model("slider_crank")).unwrap();
    let levels = [("cylinder.s".to_owned(), 1.7), ("crank.angle".to_owned(), 0.0)];
    let at = |points: u32| {
        let times: Vec<f64> = (0..=points).map(|index| 2.5 / f64::from(points) * f64::from(index)).collect();
        Study::new(&scene).unwrap().features(&names(&["rod_length"]), &times, &levels).unwrap().features
    };
    let (few, many) = (at(1), at(700));
    assert!(few.len() == many.len() && few.len() > 10);
    for (few, many) in few.iter().zip(&many).filter(|(few, _)| few.output.0 != "energy.total") {
        assert_eq!((&few.output, few.kind), (&many.output, many.kind));
        let apart = [few.time - many.time, few.value - many.value];
        assert!(apart[0].abs() < 1e-7 && apart[1].abs() < 1e-7 * few.value.abs().max(1.0), "{few:?} {many:?}");
    }
}

/// A cart is pushed by F as far as c and braked by G from there on: v^2 = 2 F c / m where it is fastest.
#[test]
fn peaks_and_jumps_where_a_law_switches() {
    let scene = r#"
name = "cart"
dimension = 1
[parameters]
F = "8 N"
G = "3 N"
c = "0.5 m"
l = "1 m"
[bodies.a]
mass = 2.0
[loads.push]
type = "force"
on = "a"
vector = ["if(a.x < c, F*(1 + a.x/l), -G)"]
[initial]
"a.x" = 0.0
"a.vx" = 0.0
[outputs]
variables = ["a.vx", "push.fx"]
[experiment]
stop = "1.2 s"
tolerance = 1e-10
"#;
    let scene = Scene::from_toml(scene).unwrap();
    let times: Vec<f64> = (0..=60).map(|index| 0.02 * f64::from(index)).collect();
    let to = ["F", "G", "c"];
    let levels = [("push.fx".to_owned(), 5.0)];
    let found = Study::new(&scene).unwrap().features(&names(&to), &times, &levels).unwrap().features;
    // x'' = k (1 + x), x = cosh(w t) - 1 with w^2 = F/m: v = w sinh(w t) where cosh(w t) = 1 + c.
    let (force, c, mass) = (8.0_f64, 0.5_f64, 2.0);
    let rate = (force / mass).sqrt();
    let (time, depth) = ((1.0 + c).acosh() / rate, ((1.0 + c).powi(2) - 1.0).sqrt());
    let time_by = [-time / (2.0 * force), 0.0, 1.0 / (rate * depth)];
    let largest = |name: &str| {
        found
            .iter()
            .find(|own| own.output.0 == name && own.kind == cotree_study::analysis::FeatureKind::Largest)
            .unwrap()
    };
    let speed_by = [rate * depth / (2.0 * force), 0.0, rate * (1.0 + c) / depth];
    let check = |own: &cotree_study::analysis::Feature, value: f64, by: [f64; 3]| {
        assert!((own.value - value).abs() < 1e-7 && (own.time - time).abs() < 1e-7, "{own:?}");
        let changes = own.changes.as_ref().unwrap();
        assert_close(&changes.value, &by, 1e-6, "value");
        assert_close(&changes.time, &time_by, 1e-6, "time");
    };
    check(largest("a.vx"), rate * depth, speed_by);
    check(largest("push.fx"), force * (1.0 + c), [1.0 + c, 0.0, force]);
    let crossings: Vec<_> =
        found.iter().filter(|own| own.kind == cotree_study::analysis::FeatureKind::Crossing).collect();
    let [jump] = crossings[..] else { panic!("{crossings:?}") };
    check(jump, 5.0, [0.0; 3]);
}

/// The highest value is at a corner of the output itself.
#[test]
fn peaks_that_have_no_derivative_are_refused() {
    let scene = r#"
name = "bouncer"
dimension = 1
[parameters]
k = "100 N/m"
[bodies.a]
mass = 1.0
[loads.wall]
type = "force"
on = "a"
vector = ["if(a.x > 0, -k*a.x, 0)"]
[loads.damp]
type = "force"
on = "a"
vector = ["-3"]
[initial]
"a.x" = -1.0
"a.vx" = 4.0
[outputs]
variables = ["a.x"]
kink = "-abs(a.x - 0.1)"
[experiment]
stop = "1 s"
tolerance = 1e-10
"#;
    let scene = Scene::from_toml(scene).unwrap();
    let times: Vec<f64> = (0..=50).map(|index| 0.02 * f64::from(index)).collect();
    let found = Study::new(&scene).unwrap().features(&names(&["k"]), &times, &[]).unwrap();
    let kink = found.features.iter().find(|own| own.output.0 == "kink").unwrap();
    let why = kink.changes.as_ref().unwrap_err();
    assert!(
        kink.value.abs() < 1e-6 && matches!(why, NotDifferentiable::Corner | NotDifferentiable::EquallyHigh { .. }),
        "{kink:?}"
    );
    // The deepest place in the wall is one: where a contact law is continuous the peak has a derivative.
    assert!(found.features[0].changes.as_ref().unwrap().value[0] < 0.0, "{:?}", found.features[0]);
}
