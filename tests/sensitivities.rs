//! Derivatives of motions with respect to parameters, inputs and initial values, against high-order differences of whole runs.

use cotree::Scene;
use cotree::analysis::Study;
use cotree::simulate::{Run, settings};
use cotree_fmu::model::Model;
use std::sync::Arc;

#[path = "support/run.rs"]
mod run;

/// Outputs at the end of a run with one value changed.
fn end(compiled: &cotree::Compiled, name: &str, by: f64, stop: f64) -> Vec<f64> {
    let description = &compiled.description;
    let index = settings::settable(description, name).unwrap();
    let value = start_value(compiled, name) + by;
    let mut experiment = description.experiment;
    (experiment.stop, experiment.step, experiment.tolerance) = (stop, stop, 1e-13);
    let reported = compiled.reported();
    let run = Run { description, experiment, settings: vec![(index, value)], inputs: None, reported };
    let mut last = Vec::new();
    run.start(Arc::new(Model::new(compiled.program.clone()).unwrap()), |_, values| {
        last = values.to_vec();
        Ok(())
    })
    .unwrap();
    last
}

fn start_value(compiled: &cotree::Compiled, name: &str) -> f64 {
    let program = &compiled.program;
    let parameter = program.parameters.iter().find(|own| own.name == name).map(|own| own.start);
    parameter.or_else(|| program.inputs.iter().find(|own| own.name == name).map(|own| own.start)).unwrap()
}

/// Central differences of the sixth order.
fn difference(compiled: &cotree::Compiled, name: &str, stop: f64, step: f64) -> Vec<f64> {
    let step = step * start_value(compiled, name).abs().max(1.0);
    let at = |times: f64| end(compiled, name, times * step, stop);
    let pairs = [1.0, 2.0, 3.0].map(|times| (at(times), at(-times)));
    let weights = [45.0, -9.0, 1.0];
    (0..pairs[0].0.len())
        .map(|output| {
            let sum = |(pair, weight): (&(Vec<f64>, Vec<f64>), &f64)| weight * (pair.0[output] - pair.1[output]);
            pairs.iter().zip(&weights).map(sum).sum::<f64>() / (60.0 * step)
        })
        .collect()
}

/// The largest error, relative to the largest derivative of the same parameter among outputs of the scene.
fn check(text: &str, names: &[&str], stop: f64, step: f64, limit: f64) {
    let scene = Scene::from_toml(text).unwrap();
    let compiled = cotree::compile(&scene).unwrap();
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let found = Study::new(&scene).unwrap().sensitivities(&names, &[0.0, 0.5 * stop, stop]).unwrap();
    assert_eq!(found.parameters.len(), names.len());
    for (column, name) in names.iter().enumerate() {
        for (row, time) in [(1, 0.5 * stop), (2, stop)] {
            let exact = difference(&compiled, name, time, step);
            let largest = exact.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            for (output, exact) in exact.iter().enumerate() {
                let value = found.derivatives[row][(output, column)];
                let error = (value - exact).abs() / largest.max(1e-9);
                assert!(error < limit, "{name}, {}: {value} instead of {exact} at {time}", found.outputs[output].0);
            }
        }
    }
}

fn model(name: &str) -> String {
    let path = format!("{}/models/{name}/scene.toml", env!("CARGO_MANIFEST_DIR"));
    let text = run::from_here(name, std::fs::read_to_string(path).unwrap());
    assert!(text.contains("[experiment]"));
    let at = text.find("[experiment]").unwrap();
    let (before, after) = text.split_at(at);
    let mut lines: Vec<String> = after.lines().map(str::to_owned).collect();
    lines.retain(|line| !line.trim_start().starts_with("tolerance"));
    lines.insert(1, "tolerance = 1e-10".to_owned());
    format!("{before}{}\n", lines.join("\n"))
}

#[test]
fn a_slider_crank_with_lengths_masses_and_its_start() {
    check(&model("slider_crank"), &["crank_length", "rod_length", "crank.angle", "gas_force"], 1.0, 1e-3, 1e-7);
}

#[test]
fn a_spring_that_only_pushes_and_a_damper_that_is_cut_in() {
    let text = "
        name = 'bumper'
        dimension = 1
        [parameters]
        stiffness = '900 N/m'
        damping = '8 N.s/m'
        speed = '2 m/s'
        gap = '0.3 m'
        [bodies.cart]
        mass = 2.0
        [loads.wall]
        type = 'force'
        on = 'cart'
        vector = ['if(cart.x > gap, -stiffness*(cart.x - gap) - damping*cart.vx, 0)']
        [loads.pull]
        type = 'force'
        on = 'cart'
        vector = ['3*sin(2*t)']
        [initial]
        'cart.vx' = 'speed'
        [outputs]
        variables = ['cart.x', 'cart.vx']
        [experiment]
        tolerance = 1e-10
        stop = 1.0
    ";
    check(text, &["stiffness", "damping", "speed", "gap"], 0.4, 1e-4, 1e-6);
}

#[test]
fn a_weight_that_bounces_on_a_stiff_stop_with_damping() {
    // The force jumps at the beginning of a contact; it ends where the stop would have to pull.
    let text = "
        name = 'bounce'
        gravity = [0, -9.81]
        [parameters]
        stiffness = '40 kN/m'
        damping = '20 N.s/m'
        mass = '2 kg'
        height = '0.3 m'
        [ground.points]
        floor = [0, -1]
        [bodies.weight]
        mass = 'mass'
        [joints.guide]
        type = 'prismatic'
        between = ['ground', 'weight']
        axis = [0, 1]
        [loads.stop]
        type = 'spring'
        between = ['ground.floor', 'weight']
        stiffness = 'stiffness'
        length = '0.8 m'
        damping = 'damping'
        side = 'below'
        [initial]
        'guide.s' = 'height'
        'guide.v' = 0
        [outputs]
        variables = ['guide.s', 'guide.v']
        [experiment]
        tolerance = 1e-9
        stop = 1.2
    ";
    check(text, &["stiffness", "damping", "mass", "height", "guide.v"], 1.2, 1e-4, 1e-7);
}

#[test]
fn a_driven_mechanism_and_its_reactions() {
    check(&model("quick_return"), &["l8", "l2", "l6"], 0.3, 1e-4, 1e-7);
}

#[test]
fn every_model_and_everything_that_can_be_set() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let mut checked = 0;
    for entry in folder.read_dir().unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let scene = Scene::from_toml(&model(&name)).unwrap();
        let compiled = cotree::compile(&scene).unwrap();
        let stop = 0.05 * compiled.description.experiment.stop.min(20.0);
        let parameters = compiled.program.parameters.iter().map(|own| own.name.clone());
        let names: Vec<String> = parameters.chain(compiled.program.inputs.iter().map(|own| own.name.clone())).collect();
        let together = Study::new(&scene).unwrap().sensitivities(&names, &[stop]).unwrap();
        for (column, own) in names.iter().enumerate() {
            let exact = difference(&compiled, own, stop, 1e-4);
            let largest = exact.iter().fold(1.0, |largest: f64, value| largest.max(value.abs()));
            for (output, exact) in exact.iter().enumerate() {
                let error = (together.derivatives[0][(output, column)] - exact).abs() / largest;
                // Forces of thousands of newtons leave that much noise in a difference.
                let limit = if name == "double_wishbone" { 1e-6 } else { 1e-8 };
                assert!(error < limit, "{name}: {} by {own}: {error:.1e}", together.outputs[output].0);
            }
            checked += 1;
        }
    }
    assert!(checked > 80, "{checked}");
}

/// Why there are no derivatives.
fn refused(text: &str, to: &str, stop: f64) -> String {
    let scene = Scene::from_toml(text).unwrap();
    Study::new(&scene).unwrap().sensitivities(&[to.to_owned()], &[stop]).unwrap_err().to_string()
}

/// A four-bar linkage, the third crank of which is parallel to the others.
fn cranks(third: &str, speed: &str) -> String {
    format!(
        "
        name = 'cranks'
        [parameters]
        length = '0.5 m'
        [ground.points]
        a = [0, 0]
        b = [1, 0]
        c = [2, 0]
        [bodies.first]
        mass = 1.0
        inertia = 0.1
        points = {{ tip = ['length', 0] }}
        [bodies.second]
        mass = 1.0
        inertia = 0.1
        points = {{ tip = ['0.5 m', 0] }}
        [bodies.coupler]
        mass = 1.0
        inertia = 0.1
        points = {{ middle = [1, 0], end = [2, 0] }}
        [joints.a]
        type = 'revolute'
        between = ['ground.a', 'first']
        [joints.b]
        type = 'revolute'
        between = ['ground.b', 'second']
        [joints.tip]
        type = 'revolute'
        between = ['first.tip', 'coupler']
        [joints.middle]
        type = 'revolute'
        between = ['second.tip', 'coupler.middle']
        {third}
        [initial]
        'first.angle' = '60 deg'
        'second.angle' = {{ guess = '60 deg' }}
        'first.omega' = '{speed}'
        [outputs]
        variables = ['second.angle']
        [experiment]
        stop = 1.0
        "
    )
}

#[test]
fn derivatives_that_do_not_exist_are_refused_with_the_reason() {
    let third = "
        [bodies.third]
        mass = 1.0
        inertia = 0.1
        points = { tip = ['0.5 m', 0] }
        [joints.c]
        type = 'revolute'
        between = ['ground.c', 'third']
        [joints.end]
        type = 'revolute'
        between = ['third.tip', 'coupler.end']
    ";
    let message = refused(&cranks(third, "0.1 rad/s"), "length", 0.1);
    assert!(message.contains("fit"), "{message}");
    // Both bars are flat after a third of a turn back: there changed lengths part the branches.
    let message = refused(&cranks("", "-5 rad/s"), "length", 1.0);
    assert!(message.contains("singular"), "{message}");
    let message = refused(&cranks("", "1 rad/s"), "lenght", 1.0);
    assert!(message.contains("did you mean `length`"), "{message}");
}

#[test]
fn parameters_that_do_nothing_give_zeros_and_many_are_those_of_one_by_one() {
    let text = cranks("", "1 rad/s").replace("[parameters]", "[parameters]\n        idle = 3.0\n");
    let scene = Scene::from_toml(&text).unwrap();
    let names = ["idle", "length", "first.omega"].map(str::to_owned);
    let together = Study::new(&scene).unwrap().sensitivities(&names, &[0.3]).unwrap();
    assert_eq!(together.derivatives[0][(0, 0)], 0.0);
    let alone = Study::new(&scene).unwrap().sensitivities(&names[1..2], &[0.3]).unwrap();
    let [both, one] = [together.derivatives[0][(0, 1)], alone.derivatives[0][(0, 0)]];
    assert!((both - one).abs() < 1e-6 * one.abs(), "{both} {one}");
}

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

#[test]
fn vibrations_about_an_equilibrium_that_moves() {
    let scene = resting();
    let found = Study::new(&scene).unwrap().mode_sensitivities(&names(&AT_REST)).unwrap();
    assert_eq!(found.modes.len(), 1);
    assert!(found.modes[0].frequency() > 0.1 && found.modes[0].damping_ratio().unwrap() > 1e-3, "{:?}", found.modes);
    for (column, name) in AT_REST.iter().enumerate() {
        let values = |mut study: Study| {
            let modes = study.modes(None).unwrap().modes;
            modes.iter().flat_map(|mode| [mode.eigenvalue.re, mode.eigenvalue.im]).collect::<Vec<f64>>()
        };
        let own: Vec<f64> = found.derivatives.iter().flatten().flat_map(|by| [by[column].re, by[column].im]).collect();
        assert_close(&own, &difference_of(&scene, name, values), 1e-7, name);
    }
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

#[test]
fn what_rests_without_stiffness_has_no_derivatives() {
    let text = model("slider_crank").replace("gravity = [0.0, -9.81]", "gravity = [0.0, 0.0]");
    let error =
        Study::new(&Scene::from_toml(&text).unwrap()).unwrap().equilibrium_sensitivities(&names(&["rod_length"]));
    assert!(error.unwrap_err().to_string().contains("no stiffness against it"));
}

#[test]
fn peaks_and_crossings() {
    let scene = Scene::from_toml(&model("slider_crank")).unwrap();
    let to = ["crank_length", "rod_length", "crank.angle"];
    let times: Vec<f64> = (0..=125).map(|index| 0.02 * f64::from(index)).collect();
    let levels = [("cylinder.s".to_owned(), 1.7), ("crank.angle".to_owned(), 0.0)];
    let found = Study::new(&scene).unwrap().features(&names(&to), &times, &levels).unwrap().features;
    assert!(found.iter().filter(|own| own.kind == cotree::analysis::Kind::Crossing).count() >= 3, "{found:?}");
    for (column, name) in to.iter().enumerate() {
        let values = |mut study: Study| {
            let features = study.features(&[], &times, &levels).unwrap().features;
            features.iter().flat_map(|own| [own.value, own.time]).collect::<Vec<f64>>()
        };
        let exact = difference_of(&scene, name, values);
        for (own, exact) in found.iter().zip(exact.chunks(2)) {
            let what = format!("{name}, {own:?}, {exact:?}");
            if own.output.0 == "energy.total" {
                assert!(own.changes.as_ref().is_err_and(|why| why.contains("constant")), "{what}");
                continue;
            }
            let by = own.changes.as_ref().unwrap();
            let error = [by.value[column] - exact[0], by.time[column] - exact[1]].map(f64::abs);
            assert!(error[0] < 1e-7 * exact[0].abs().max(own.value.abs()).max(1e-2), "{what}");
            assert!(error[1] < 1e-6 * exact[1].abs().max(1.0), "{what}");
        }
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
        found.iter().find(|own| own.output.0 == name && own.kind == cotree::analysis::Kind::Largest).unwrap()
    };
    let speed_by = [rate * depth / (2.0 * force), 0.0, rate * (1.0 + c) / depth];
    let check = |own: &cotree::analysis::Feature, value: f64, by: [f64; 3]| {
        assert!((own.value - value).abs() < 1e-7 && (own.time - time).abs() < 1e-7, "{own:?}");
        let changes = own.changes.as_ref().unwrap();
        assert_close(&changes.value, &by, 1e-6, "value");
        assert_close(&changes.time, &time_by, 1e-6, "time");
    };
    check(largest("a.vx"), rate * depth, speed_by);
    check(largest("push.fx"), force * (1.0 + c), [1.0 + c, 0.0, force]);
    let crossings: Vec<_> = found.iter().filter(|own| own.kind == cotree::analysis::Kind::Crossing).collect();
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
    assert!(kink.value.abs() < 1e-6 && (why.contains("corner") || why.contains("equally high")), "{kink:?}");
    // The deepest place in the wall is one: where a contact law is continuous the peak has a derivative.
    assert!(found.features[0].changes.as_ref().unwrap().value[0] < 0.0, "{:?}", found.features[0]);
}

/// A hard stop is touched for a few milliseconds within a long free flight: no step may pass over that.
#[test]
fn a_short_contact_in_a_long_flight() {
    let scene = r#"
name = "falling ball"
gravity = [0, -9.81]
[parameters]
stiffness = "2e7 N/m"
height = "0.3 m"
[ground.points]
o = [0, 0]
below = [0, -1]
[bodies.ball]
mass = 2.0
[joints.guide]
type = "prismatic"
between = ["ground.o", "ball"]
axis = [0, 1]
[loads.stop]
type = "spring"
between = ["ground.below", "ball"]
stiffness = "stiffness"
length = "1 m"
side = "below"
[initial]
"guide.s" = "height"
"guide.v" = 0
[outputs]
variables = ["guide.s", "guide.v"]
[experiment]
stop = "0.7 s"
tolerance = 1e-10
"#;
    let (m, g, k, h, end) = (2.0_f64, 9.81_f64, 2e7_f64, 0.3_f64, 0.7_f64);
    let found = derivatives(scene, &["height", "stiffness"], &[end]);
    // Through the contact x'' = -w^2 x - g from the speed u; it lasts 2 (pi - atan(u w / g)) / w, and the ball leaves as fast as it came.
    let motion = |h: f64, k: f64| {
        let (u, w) = ((2.0 * g * h).sqrt(), (k / m).sqrt());
        let contact = 2.0 * (std::f64::consts::PI - (u * w / g).atan()) / w;
        let flown = end - u / g - contact;
        [u * flown - 0.5 * g * flown * flown, u - g * flown]
    };
    let exact = motion(h, k);
    for row in 0..2 {
        assert!((found.values[0][row] - exact[row]).abs() < 1e-7, "{} {}", found.values[0], exact[row]);
    }
    for (column, [dh, dk]) in [[1e-4, 0.0], [0.0, 2e3]].into_iter().enumerate() {
        let [low, high] = [motion(h - dh, k - dk), motion(h + dh, k + dk)];
        let by: Vec<f64> = low.iter().zip(&high).map(|(low, high)| (high - low) / (2.0 * (dh + dk))).collect();
        let column: Vec<f64> = found.derivatives[0].column(column).iter().copied().collect();
        assert_close(&column, &by, 1e-6, "after the contact");
    }
}

/// Derivatives of a model by these parameters at these times.
fn derivatives(text: &str, names: &[&str], times: &[f64]) -> cotree::analysis::Sensitivities {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    Study::new(&Scene::from_toml(text).unwrap()).unwrap().sensitivities(&names, times).unwrap()
}

#[test]
fn many_parameters_have_the_bits_of_one_by_one() {
    let pendulum = ["upper_length", "lower_length", "upper_mass", "lower_mass"];
    let crank = ["crank_length", "rod_length", "load_stiffness", "gas_force", "crank.angle", "crank.omega"];
    let rates = ["upper.angle", "lower.angle", "upper.omega", "lower.omega"];
    // More than eight are found in two groups.
    let twice: Vec<&str> = [&pendulum[..], &rates, &pendulum].concat();
    for (name, parameters) in [("double_pendulum", &twice[..]), ("slider_crank", &crank)] {
        let text = model(name);
        let times = [0.0, 0.7, 1.9];
        let together = derivatives(&text, parameters, &times);
        for (column, parameter) in parameters.iter().enumerate() {
            let alone = derivatives(&text, &[parameter], &times);
            for row in 0..times.len() {
                let both = [together.derivatives[row].column(column), alone.derivatives[row].column(0)];
                let bits = both.map(|column| column.iter().map(|value| value.to_bits()).collect::<Vec<u64>>());
                assert_eq!(bits[0], bits[1], "{name}: {parameter} at {}", times[row]);
            }
        }
    }
}

#[test]
fn motions_under_gravity_do_not_depend_on_the_scale_of_masses() {
    let found = derivatives(&model("double_pendulum"), &["upper_mass", "lower_mass"], &[0.5, 2.0]);
    for derivatives in &found.derivatives {
        for output in 0..4 {
            let [upper, lower] = [derivatives[(output, 0)], 0.7 * derivatives[(output, 1)]];
            assert!(upper.abs() > 1e-3 && (upper + lower).abs() < 1e-9 * upper.abs(), "{output}: {upper} {lower}");
        }
    }
}

#[test]
fn the_derivative_of_a_conserved_energy_is_conserved() {
    for (name, parameters) in
        [("double_pendulum", ["upper_length", "lower_mass"]), ("slider_crank", ["crank_length", "load_stiffness"])]
    {
        let found = derivatives(&model(name), &parameters, &[0.0, 0.4, 1.1, 2.0]);
        let energy = found.outputs.iter().position(|(name, _)| name == "energy.total").unwrap();
        for column in 0..parameters.len() {
            let [first, rest @ ..] = &found.derivatives[..] else { panic!() };
            let size = found.derivatives.iter().map(|own| own.column(column).amax()).fold(0.0, f64::max);
            for own in rest {
                let change = own[(energy, column)] - first[(energy, column)];
                assert!(change.abs() < 1e-8 * size, "{name}, {}: {change} of {size}", parameters[column]);
            }
        }
    }
}

#[test]
fn other_trees_give_the_same_derivatives() {
    let text = model("slider_crank");
    let parameters = ["crank_length", "rod_length", "crank.angle"];
    let times = [0.3, 1.0];
    let minimal = derivatives(&text, &parameters, &times);
    for preset in ["joint", "absolute"] {
        let other = derivatives(&format!("coordinates = {{ preset = '{preset}' }}\n{text}"), &parameters, &times);
        for (one, two) in minimal.derivatives.iter().zip(&other.derivatives) {
            let scale = one.amax();
            assert!((one - two).amax() < 1e-9 * scale, "{preset}: {one} {two}");
        }
    }
}
