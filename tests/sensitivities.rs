//! Derivatives of motions with respect to parameters, inputs and initial values, against high-order differences of whole runs.

use crate::support::{ROOT, fine};

use cotree::Scene;
use cotree::run::{Run, settings};
use cotree_fmu::instance::{Instance, Variational, Varied};
use cotree_fmu::model::Model;
use cotree_fmu::program::arm_form::ArmForm;
use cotree_study::analysis::Study;
use std::sync::Arc;

use fine::model;

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
pub fn check(text: &str, names: &[&str], stop: f64, step: f64, limit: f64) {
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

/// A weight that falls from 0.5 m above a stop.
fn bounce(stiffness: &str, damping: &str) -> String {
    format!(
        "
        name = 'bounce'
        gravity = [0, -9.81]
        [parameters]
        stiffness = '{stiffness}'
        damping = '{damping}'
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
    "
    )
}

#[test]
fn a_weight_that_bounces_on_a_stiff_stop_with_damping() {
    // The force jumps at the beginning of a contact; it ends where the stop would have to pull.
    let names = ["stiffness", "damping", "mass", "height", "guide.v"];
    check(&bounce("40 kN/m", "20 N.s/m"), &names, 1.2, 1e-4, 1e-7);
}

/// Far outside the layer of dry friction its level is constant to rounding, and how it changes with the width of the layer is a staircase of rounding errors.
#[test]
fn a_law_that_a_parameter_does_not_move_yet() {
    let text = "
        name = 'sliding'
        [parameters]
        width = '0.0376 m/s'
        level = '0.3 N'
        [ground.points]
        wall = [-1, 0]
        [bodies.block]
        mass = 1.5
        [joints.guide]
        type = 'prismatic'
        between = ['ground', 'block']
        axis = [1, 0]
        friction = { coulomb = 'level', velocity = 'width' }
        [loads.spring]
        type = 'spring'
        between = ['ground.wall', 'block']
        stiffness = 47
        length = 1
        [initial]
        'guide.s' = 0.073
        'guide.v' = 0.96
        [outputs]
        variables = ['guide.s', 'guide.v']
        [experiment]
        tolerance = 1e-9
    ";
    check(text, &["width", "level"], 1.0, 1e-4, 1e-6);
}

/// A hard stop is touched for a millisecond within a long flight: no step may pass over that.
#[test]
fn a_short_contact_in_a_long_flight() {
    let end = 0.7;
    let found = derivatives(&bounce("20 MN/m", "0 N.s/m"), &["height", "stiffness"], &[end]);
    // Through the contact x'' = -w^2 x - g from the speed u; it lasts 2 (pi - atan(u w / g)) / w, and the weight leaves as fast as it came.
    let motion = |height: f64, stiffness: f64| {
        let (g, w) = (9.81, (stiffness / 2.0).sqrt());
        let u = (2.0 * g * (height + 0.2)).sqrt();
        let contact = 2.0 * (std::f64::consts::PI - (u * w / g).atan()) / w;
        let flown = end - u / g - contact;
        [u * flown - 0.5 * g * flown * flown - 0.2, u - g * flown]
    };
    let exact = motion(0.3, 2e7);
    for row in 0..2 {
        assert!((found.values[0][row] - exact[row]).abs() < 1e-7, "{} {}", found.values[0], exact[row]);
    }
    for (column, [height, stiffness]) in [[1e-4, 0.0], [0.0, 2e3]].into_iter().enumerate() {
        let [low, high] = [-1.0, 1.0].map(|sign| motion(0.3 + sign * height, 2e7 + sign * stiffness));
        let by = [0, 1].map(|row| (high[row] - low[row]) / (2.0 * (height + stiffness)));
        for row in 0..2 {
            let value = found.derivatives[0][(row, column)];
            assert!((value - by[row]).abs() < 1e-6 * by[0].abs().max(by[1].abs()), "{value} instead of {}", by[row]);
        }
    }
}

#[test]
fn a_driven_mechanism_and_its_reactions() {
    check(&model("quick_return"), &["l8", "l2", "l6"], 0.3, 1e-4, 1e-7);
}

#[test]
fn every_model_and_everything_that_can_be_set() {
    let folder = std::path::Path::new(ROOT).join("models");
    let mut checked = 0;
    for entry in folder.read_dir().unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let scene = Scene::from_toml(&model(&name)).unwrap();
        let compiled = cotree::compile(&scene).unwrap();
        let stop = 0.05 * compiled.description.experiment.stop.min(20.0);
        let program = &compiled.program;
        let inputs = program.inputs.iter().map(|input| input.name.clone());
        let names: Vec<String> =
            program.parameters.iter().map(|parameter| parameter.name.clone()).chain(inputs).collect();
        // The valve of the arm begins closed, at the corner of its law: oil comes in on one side and goes out on the other; the block and the worm begin at rest.
        let refused = [
            ("barrier", "would start to slide"),
            ("chain_hoist", "`chain` runs over pulleys"),
            ("excavator_arm", "starts at a corner"),
            ("play_train", "hit at the same time"),
            ("stick_slip", "would start to slide"),
            ("worm_hoist", "would start to slide"),
            ("valve_train", "compatible for these values only"),
        ];
        if let Some((_, why)) = refused.iter().find(|(own, _)| *own == name) {
            let message = Study::new(&scene).unwrap().sensitivities(&names, &[stop]).unwrap_err().to_string();
            assert!(message.contains(why), "{message}");
            continue;
        }
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
pub fn refused(text: &str, to: &str, stop: f64) -> String {
    let scene = Scene::from_toml(text).unwrap();
    Study::new(&scene).unwrap().sensitivities(&[to.to_owned()], &[stop]).unwrap_err().to_string()
}

/// The third crank.
const THIRD: &str = "
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
    let message = refused(&cranks(THIRD, "0.1 rad/s"), "length", 0.1);
    assert!(message.contains("compatible"), "{message}");
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

/// Derivatives of a model by these parameters at these times.
fn derivatives(text: &str, names: &[&str], times: &[f64]) -> cotree_study::analysis::Sensitivities {
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

/// Bodies in a row, each hanging from the one before.
fn hanging(count: usize) -> String {
    let mut text = "
        name = 'hanging'
        gravity = [0, -9.81]
        [parameters]
        mass = '0.5 kg'
        length = '0.1 m'
        damping = '0.002 N.m.s/rad'
        [outputs]
        variables = ['last.angle', 'last.omega']
        [experiment]
        tolerance = 1e-9
        "
    .to_owned();
    let name = |index: usize| if index + 1 == count { "last".to_owned() } else { format!("link{index}") };
    let mut initial = "[initial]\n".to_owned();
    for index in 0..count {
        let body = index.checked_sub(1).map_or("ground".to_owned(), name);
        let (own, before) = (name(index), if index == 0 { body.clone() } else { format!("{body}.end") });
        text += &format!(
            "
        [bodies.{own}]
        mass = 'mass'
        inertia = 0.01
        points = {{ end = ['length', 0] }}
        [joints.pin{index}]
        type = 'revolute'
        between = ['{before}', '{own}']
        [loads.damper{index}]
        type = 'torsion_damper'
        between = ['{body}', '{own}']
        damping = 'damping'
        "
        );
        initial += &format!("'pin{index}.angle' = '{} deg'\n", if index == 0 { -60 } else { 4 });
    }
    text + &initial
}

/// A slide that a massless rod pulls.
const ROD: &str = "
    name = 'pulled'
    gravity = [0, -9.81]
    [parameters]
    length = '0.4 m'
    mass = '2 kg'
    stiffness = '30 N/m'
    [ground.points]
    wall = [-1, 0]
    [bodies.slide]
    mass = 1.0
    [bodies.weight]
    mass = 'mass'
    inertia = 0.05
    points = { eye = [0, '0.1 m'] }
    [joints.guide]
    type = 'prismatic'
    between = ['ground', 'slide']
    axis = [1, 0]
    [joints.rod]
    type = 'distance'
    between = ['slide', 'weight.eye']
    length = 'length'
    [loads.spring]
    type = 'spring'
    between = ['ground.wall', 'slide']
    stiffness = 'stiffness'
    length = 1
    [initial]
    'slide.x' = 0.1
    'weight.x' = 0.3
    'weight.y' = { guess = -0.4 }
    'weight.angle' = 0.2
    [outputs]
    variables = ['slide.x', 'weight.y', 'rod.force']
    [experiment]
    tolerance = 1e-9
";

/// Rods, lines that turn, trees of many bodies and loop equations that repeat others are continued by series as everything else is.
#[test]
fn mechanisms_of_every_kind_have_series() {
    let parallel = cranks(&THIRD.replace("mass = 1.0", "mass = 'mass'"), "2 rad/s")
        .replace("[parameters]", "gravity = [0, -9.81]\n[parameters]\nmass = '1.2 kg'");
    let has = |text: &str, kind: fn(&ArmForm) -> bool| {
        let compiled = cotree::compile(&Scene::from_toml(text).unwrap()).unwrap();
        assert!(compiled.program.arms.as_ref().is_some_and(kind), "{text}");
        let model = Arc::new(Model::new(compiled.program).unwrap());
        let mut motion = Instance::new(Arc::clone(&model));
        motion.setup(0.0, None, Some(1e-10)).unwrap();
        motion.initialise().unwrap();
        let zeros = vec![0.0; model.coordinates()];
        let mut series = Variational::new(&model, &[Varied::Parameter(0)], 1e-9);
        assert!(series.begin(&mut motion, [&zeros, &zeros], &[0.0], 0.1).unwrap().is_some(), "{text}");
    };
    has(ROD, |form| !form.rods.is_empty());
    check(ROD, &["length", "mass", "stiffness", "weight.angle"], 0.6, 1e-4, 1e-7);
    let slotted = model("geneva_slot").replace("[drivers.motor]", "").replace("joint = \"crank_pivot\"\n", "");
    let slotted = slotted
        .replace("angle = \"-pi/4 + 0.5*pi*t\"", "")
        .replace("\"slot.s\" ", "\"crank.omega\" = 1.0\n\"slot.s\" ");
    let slotted = slotted.replace("\"wheel.angle\" = {", "\"crank.angle\" = -0.5\n\"wheel.angle\" = {");
    has(&slotted, |form| !form.auxiliary.is_empty());
    check(&slotted, &["crank_length", "crank.omega"], 0.3, 1e-4, 1e-7);
    let many = hanging(20);
    has(&many, |form| !form.links.is_empty());
    check(&many, &["length", "mass", "damping"], 0.5, 1e-4, 1e-7);
    has(&parallel, |form| form.repeating() > 0);
    check(&parallel, &["mass", "first.omega"], 0.4, 1e-4, 1e-7);
}

/// A cart that a force pushes by this law of time.
fn pushed(law: &str) -> String {
    format!(
        "name = 'cart'\ndimension = 1\n[parameters]\npush = '0.5 N'\nwidth = '0.3 s'\n[bodies.cart]\nmass = 2.0\n\
         [loads.drive]\ntype = 'force'\non = 'cart'\nvector = ['{law}']\n[initial]\n'cart.x' = 0.0\n'cart.vx' = 0.0\n\
         [outputs]\nvariables = ['cart.vx']\n[experiment]\nstop = 2.0\ntolerance = 1e-9\n"
    )
}

/// Exponentials and what saturates are continued by series as well, for the price of other smooth laws; where they are steep nothing is overlooked.
#[test]
fn laws_with_exponentials_have_series() {
    let (push, mass) = (0.5, 2.0);
    // The integrals of the laws up to 2 s, and their derivatives by the width.
    let root_pi = std::f64::consts::PI.sqrt();
    let fading = |width: f64| width * (1.0 - (-2.0 / width).exp());
    let fading_slope = |width: f64| 1.0 - (-2.0 / width).exp() * (1.0 + 2.0 / width);
    let ending = |width: f64| width * (2.0 / width).cosh().ln();
    let ending_slope = |width: f64| (2.0 / width).cosh().ln() - 2.0 / width * (2.0 / width).tanh();
    // The second one is past within a step that sees nothing of it at either end.
    for (law, width, integral, slope, most) in [
        ("push*exp(-t/width)", 0.3, fading(0.3), fading_slope(0.3), 6.0),
        ("push*exp(-((t - 1[s])/width)^2)", 0.15, 0.15 * root_pi, root_pi, 10.0),
        ("push*exp(-((t - 1[s])/width)^2)", 0.003, 0.003 * root_pi, root_pi, 30.0),
        ("push*tanh(t/width)", 0.3, ending(0.3), ending_slope(0.3), 10.0),
        ("push*tanh(t/width)", 0.01, 2.0 - 0.01 * std::f64::consts::LN_2, -std::f64::consts::LN_2, 30.0),
    ] {
        let text = pushed(law).replace("0.3 s", &format!("{width} s"));
        let (found, dear) = dearness(&text, &["push", "width"], &[2.0]);
        let [by_push, by_width] = [0, 1].map(|column| found.derivatives[0][(0, column)]);
        // What the bumps have beyond the run is nothing: erfc(1/0.15) is 4e-21.
        let exact = [integral / mass, push * slope / mass];
        assert!((by_push - exact[0]).abs() < 1e-7, "{law}, {width}: {by_push} instead of {}", exact[0]);
        assert!((by_width - exact[1]).abs() < 1e-6, "{law}, {width}: {by_width} instead of {}", exact[1]);
        assert!(dear <= most, "{law}, {width}: {dear} steps for each of the plain run");
        let model = Arc::new(Model::new(cotree::compile(&Scene::from_toml(&text).unwrap()).unwrap().program).unwrap());
        let mut motion = Instance::new(Arc::clone(&model));
        motion.setup(0.0, None, Some(1e-10)).unwrap();
        motion.initialise().unwrap();
        let mut series = Variational::new(&model, &[Varied::Parameter(0)], 1e-9);
        assert!(series.begin(&mut motion, [&[0.0], &[0.0]], &[0.0], 0.1).unwrap().is_some(), "{law}");
    }
}

/// Derivatives of outputs at times, and how many steps they took for each step of the plain run.
fn dearness(text: &str, names: &[&str], times: &[f64]) -> (cotree_study::analysis::Sensitivities, f64) {
    let compiled = cotree::compile(&Scene::from_toml(text).unwrap()).unwrap();
    let mut plain = Instance::new(Arc::new(Model::new(compiled.program).unwrap()));
    plain.setup(0.0, None, None).unwrap();
    plain.initialise().unwrap();
    plain.step_to(times[times.len() - 1]).unwrap();
    let found = derivatives(text, names, times);
    let dear = found.steps as f64 / plain.statistics().steps as f64;
    (found, dear)
}

/// A bar that hangs on a pin with friction and comes to rest.
const COMES_TO_REST: &str = "
    name = 'bar'
    gravity = [0, -9.81]
    [parameters]
    damping = '0.35 N.m.s'
    mass = '1.4 kg'
    shift = '3 cm'
    [bodies.bar]
    mass = 'mass'
    inertia = 0.03
    points = { top = ['shift', 0.22] }
    [joints.pin]
    type = 'revolute'
    between = ['ground', 'bar.top']
    [loads.friction]
    type = 'torsion_damper'
    between = ['ground', 'bar']
    damping = 'damping'
    [initial]
    'bar.angle' = '35 deg'
    [outputs]
    variables = ['bar.angle']
    [experiment]
    stop = 60.0
    tolerance = 1e-8
";

/// The centre of mass comes to rest below the pin: tan of the angle is shift/0.22.
#[test]
fn derivatives_of_what_comes_to_rest_become_those_of_the_rest_at_the_price_of_the_run() {
    check(COMES_TO_REST, &["damping", "mass", "shift"], 1.0, 1e-3, 1e-6);
    let (found, dear) = dearness(COMES_TO_REST, &["damping", "mass", "shift"], &[1.0, 60.0]);
    let [early, late] = [0, 1].map(|row| &found.derivatives[row]);
    let (long, shift) = (0.22, 0.03);
    assert!((late[(0, 2)].abs() - long / (long * long + shift * shift)).abs() < 1e-6, "{late}");
    assert!(
        late[(0, 0)].abs() < 1e-6 * early[(0, 0)].abs() && late[(0, 1)].abs() < 1e-6 * early[(0, 1)].abs(),
        "{late}"
    );
    assert!(dear <= 10.0, "{dear} steps for each of the plain run");
}

/// A light cart between a strong damper and a spring, under a load: one of its rates is ten million times the other.
#[test]
fn derivatives_of_a_stiff_motion_cost_a_few_steps_for_each_of_its_own() {
    let text = "
        name = 'cart'
        dimension = 1
        [parameters]
        damping = '900 N.s/m'
        stiffness = '9 N/mm'
        load = '300 N'
        [bodies.cart]
        mass = 1e-5
        [loads.strut]
        type = 'spring'
        between = ['ground', 'cart']
        stiffness = 'stiffness'
        damping = 'damping'
        length = 0.0
        [loads.pull]
        type = 'force'
        on = 'cart'
        vector = ['load']
        [initial]
        'cart.x' = 0.0
        'cart.vx' = 0.0
        [outputs]
        variables = ['cart.x']
        [experiment]
        stop = 4.0
        tolerance = 1e-8
    ";
    let times = [0.05, 0.1, 4.0];
    let (found, dear) = dearness(text, &["damping", "stiffness", "load"], &times);
    // x = load/stiffness (1 - exp(-s t)) but for 1e-7, with the slow rate s = stiffness/damping.
    let (damping, stiffness, load) = (900.0, 9000.0, 300.0);
    for (time, derivatives) in times.iter().zip(&found.derivatives) {
        let fading = (-stiffness / damping * time).exp();
        let exact = [
            -load * time * fading / damping.powi(2),
            -load * (1.0 - fading) / stiffness.powi(2) + load / stiffness * time * fading / damping,
            (1.0 - fading) / stiffness,
        ];
        for (column, exact) in exact.into_iter().enumerate() {
            let largest = [1.3e-5, 3.7e-6, 1.2e-4][column];
            let error = (derivatives[(0, column)] - exact).abs() / largest;
            assert!(error < 1e-5, "{column} at {time}: {} instead of {exact}", derivatives[(0, column)]);
        }
    }
    assert!(dear <= 10.0, "{dear} steps for each of the plain run");
}
