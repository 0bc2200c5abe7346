//! Equations for people: the paper's examples look as in the paper, and what is printed says the same as the kernels.

use crate::support::ROOT;
use std::collections::HashMap;
use std::path::Path;

use crate::support::random::{Family, random_case};
use crate::support::run::{RUBBING_IN_DRIVEN, models};
use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol};
use cotree::formulate::equations;
use cotree::model::{CoordinateChoice, JointId, Mechanism, Owner, Quantity, Variable};
use cotree::scene::Scene;
use cotree_text::written::{self, EquationFormat};
use cotree_text::{self as text, Prose};
use serde_json::Value;

/// Section 5.3 of the paper, then its sections 5.2 and 5.1.
const PAPER: [&str; 3] =
    ["tests/scenes/figure_1.toml", "models/quick_return/scene.toml", "models/vibration/scene.toml"];

fn scene(path: &str) -> Scene {
    Scene::read(Path::new(ROOT).join(path)).unwrap_or_else(|faults| panic!("{faults}"))
}

fn model(name: &str) -> Scene {
    scene(&format!("models/{name}/scene.toml"))
}

#[test]
fn the_examples_of_the_paper_as_text() {
    for path in PAPER {
        let scene = scene(path);
        let text = written::equations(&scene, EquationFormat::Text).unwrap_or_else(|faults| panic!("{faults}"));
        insta::assert_snapshot!(format!("text_{}", &*scene.resolve().unwrap().mechanism.name), text);
    }
}

#[test]
fn the_examples_of_the_paper_as_latex() {
    for path in PAPER {
        let scene = scene(path);
        let text = written::equations(&scene, EquationFormat::Latex).unwrap_or_else(|faults| panic!("{faults}"));
        insta::assert_snapshot!(format!("latex_{}", &*scene.resolve().unwrap().mechanism.name), text);
    }
}

#[test]
fn the_derivation_of_the_slider_crank() {
    let text = written::steps(&scene(PAPER[0]), Prose::Text).unwrap_or_else(|faults| panic!("{faults}"));
    insta::assert_snapshot!("steps_figure_1", text);
}

/// Letter by letter, with the user's names for the paper's.
#[test]
fn eqs_57_to_62_look_as_in_the_paper() {
    let text = written::equations(&scene(PAPER[0]), EquationFormat::Text).unwrap_or_else(|faults| panic!("{faults}"));
    for line in [
        "M[1,1] = I1 + m1*l5^2 + (m2 + m3)*(l5 + l6)^2",
        "M[1,2] = (m2*l7 + m3*(l7 + l8))*(l5 + l6)*(s1*c2 - c1*s2)",
        "M[2,2] = I2 + m2*l7^2 + m3*(l7 + l8)^2",
        "Q[1] = (m2*l7 + m3*(l7 + l8))*(l5 + l6)*rod.omega^2*(c1*c2 + s1*s2) - (l5 + l6)*F*s1",
        "Q[2] = -(l7 + l8)*F*c2 - (m2*l7 + m3*(l7 + l8))*(l5 + l6)*crank.omega^2*(c1*c2 + s1*s2)",
        "Phi[1] = -(l5 + l6)*s1 - (l7 + l8)*c2",
    ] {
        assert!(text.lines().any(|own| own.trim() == line), "`{line}` is not in\n{text}");
    }
}

#[test]
fn eqs_38_39_and_42_look_as_in_the_paper() {
    let text = written::equations(&scene(PAPER[1]), EquationFormat::Text).unwrap_or_else(|faults| panic!("{faults}"));
    for line in [
        "Phi[1] = (l7 + l8)*(s1*c3 - c1*s3) - l2*c1",
        "Phi[2] = l1 + l2 - (l3 + l4)*s1 - (l5 + l6)*c2",
        "tool_slide.s  = (l3 + l4)*c1 - (l5 + l6)*s2",
    ] {
        assert!(text.lines().any(|own| own.trim() == line), "`{line}` is not in\n{text}");
    }
}

/// A symbol's value: anything, but always the same.
fn value(symbol: Symbol) -> f64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    symbol.hash(&mut hasher);
    0.3 + (hasher.finish() >> 11) as f64 / (1_u64 << 53) as f64
}

/// The value of a printed tree.
fn evaluate(tree: &Value, names: &HashMap<String, f64>) -> f64 {
    match tree {
        Value::Number(number) => number.as_f64().unwrap(),
        Value::String(name) => *names.get(name).unwrap_or_else(|| panic!("`{name}` is not defined")),
        Value::Array(parts) => {
            let operands: Vec<f64> = parts[1..].iter().map(|part| evaluate(part, names)).collect();
            let a = operands[0];
            match parts[0].as_str().unwrap() {
                "+" => operands.iter().sum(),
                "-" => -a,
                "*" => operands.iter().product(),
                "/" => a / operands[1],
                "^" => a.powf(operands[1]),
                "sqrt" => a.sqrt(),
                "sin" => a.sin(),
                "cos" => a.cos(),
                "exp" => a.exp(),
                "abs" => a.abs(),
                "tanh" => a.tanh(),
                "acos" => a.acos(),
                "atan2" => a.atan2(operands[1]),
                "floor" => a.floor(),
                "poly345" => {
                    let s = a.clamp(0.0, 1.0);
                    s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
                }
                "poly4567" => {
                    let s = a.clamp(0.0, 1.0);
                    s.powi(4) * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)))
                }
                "cycloidal" => {
                    let s = a.clamp(0.0, 1.0);
                    s - (std::f64::consts::TAU * s).sin() / std::f64::consts::TAU
                }
                "<" => f64::from(u8::from(a < operands[1])),
                "<=" => f64::from(u8::from(a <= operands[1])),
                "if" => operands[if a != 0.0 { 1 } else { 2 }],
                "min" => a.min(operands[1]),
                "max" => a.max(operands[1]),
                other => panic!("`{other}` is not expected in the models"),
            }
        }
        other => panic!("{other} is no formula"),
    }
}

/// Every printed entry of M, Q, Phi, Phi_q, Phi_t and gamma has the value of the expression behind it, and none is missing.
fn check_values(title: &str, equations: &mut Equations) -> usize {
    let json: Value = serde_json::from_str(&text::json(equations)).unwrap();
    let mut names: HashMap<String, f64> = HashMap::new();
    let arena = &equations.system.arena;
    for expr in arena.all() {
        if let cotree::expr::ExprNode::Symbol(symbol) = arena.node(expr) {
            names.insert(text::symbol_name(equations, symbol), value(symbol));
        }
    }
    let mut definitions: Vec<&Value> = json["definitions"].as_array().unwrap().iter().collect();
    // Cosines of angles that are defined themselves come first in print.
    while !definitions.is_empty() {
        let before = definitions.len();
        definitions.retain(|definition| {
            let known = mentioned(&definition["tree"]).iter().all(|name| names.contains_key(*name));
            if known {
                let own = evaluate(&definition["tree"], &names);
                names.insert(definition["name"].as_str().unwrap().to_owned(), own);
            }
            !known
        });
        assert!(definitions.len() < before, "{title}: {definitions:?} depend on each other");
    }
    let mut exact: HashMap<String, Expr> = HashMap::new();
    if json["dynamic"] == true {
        let dynamics = equations.dynamics().clone();
        for (row, entries) in dynamics.mass.iter().enumerate() {
            let upper = entries.iter().filter(|(column, _)| *column >= row);
            exact.extend(upper.map(|(column, entry)| (format!("M[{},{}]", row + 1, column + 1), *entry)));
        }
        exact.extend(dynamics.load.iter().enumerate().map(|(row, entry)| (format!("Q[{}]", row + 1), *entry)));
    }
    for (index, &rate) in equations.states.iter().enumerate() {
        let state = Symbol::State(index, Order::Velocity);
        exact.insert(text::symbol_name(equations, state), rate);
    }
    // Rows that say nothing are not printed.
    for (index, (_, row)) in equations.loops().enumerate() {
        let row_number = index + 1;
        exact.insert(format!("Phi[{row_number}]"), row.value);
        exact.insert(format!("gamma[{row_number}]"), row.gamma);
        exact.extend(row.jacobian.iter().map(|(column, e)| (format!("Phi_q[{row_number},{}]", column + 1), *e)));
        if row.time_rate != Expr::ZERO {
            exact.insert(format!("Phi_t[{row_number}]"), row.time_rate);
        }
    }
    if let Some(vibration) = equations.vibration() {
        for (symbol, matrix) in [("D", &vibration.damping), ("K", &vibration.stiffness)] {
            let entries = matrix.iter().enumerate().flat_map(|(row, entries)| {
                (row..entries.len())
                    .map(move |column| (format!("{symbol}[{},{}]", row + 1, column + 1), entries[column]))
            });
            exact.extend(entries.filter(|(_, entry)| *entry != Expr::ZERO));
        }
        exact.extend(vibration.force.iter().enumerate().map(|(row, &force)| (format!("F[{}]", row + 1), force)));
    }
    exact.extend(slides(equations));
    exact.extend(modes(equations));
    if json["dynamic"] == true {
        let mechanism = &*equations.system.mechanism.clone();
        let efforts = mechanism.driver_efforts().into_iter().chain(mechanism.joint_reactions());
        exact.extend(efforts.map(|effort| (mechanism.variable_name(effort), equations.variable(effort))));
    }
    let mut count = 0;
    let groups = json["equations"].as_object().unwrap();
    for entry in groups.values().flat_map(|group| group.as_array().unwrap()) {
        let name = entry["name"].as_str().unwrap();
        let expr = exact.remove(name).unwrap_or_else(|| panic!("{title}: `{name}` is not expected"));
        let expected = equations.system.arena.evaluate(&[expr], &value)[0];
        let printed = evaluate(&entry["tree"], &names);
        let close = (printed - expected).abs() <= 1e-9 * (1e-3 + expected.abs());
        assert!(close, "{title}: {name} = {} is {printed}, not {expected}", entry["text"]);
        count += 1;
    }
    assert!(exact.is_empty(), "{title}: not printed: {exact:?}");
    count
}

/// The gaps of what is held on one side, the rates of what rubs, and what friction adds to Q while it slides.
fn modes(equations: &mut Equations) -> Vec<(String, Expr)> {
    let mechanism = equations.system.mechanism.clone();
    let mut all = Vec::new();
    let mut friction = vec![Expr::ZERO; equations.coordinates.len()];
    for (index, own) in mechanism.contacts.iter().enumerate() {
        let row = equations.row_of_contact(index).unwrap();
        let gap = equations.constraints[row].contact().cloned().unwrap();
        let Some(direction) = own.state.direction else {
            all.push((format!("{}.gap", own.name), gap.value));
            continue;
        };
        let level = equations.row_of_level(index).unwrap();
        let arena = &mut equations.system.arena;
        let [direction, level] = [Symbol::Discrete(direction.0), Symbol::Reaction(level)].map(|own| arena.symbol(own));
        let force = arena.multiply(direction, level);
        let mut rate = gap.time_rate;
        for (column, entry) in gap.jacobian {
            let speed = arena.symbol(Symbol::Coordinate(column, Order::Velocity));
            rate = arena.add_product(rate, entry, speed);
            friction[column] = arena.subtract_product(friction[column], entry, force);
        }
        all.push((format!("{}.rate", own.name), rate));
    }
    let rubbing = friction.into_iter().enumerate().filter(|(_, force)| *force != Expr::ZERO);
    all.extend(rubbing.map(|(row, force)| (format!("Q_friction[{}]", row + 1), force)));
    all
}

/// The displacements of what slides without being a coordinate: of prismatic joints, pins in slots and rolling discs.
fn slides(equations: &mut Equations) -> Vec<(String, Expr)> {
    let mut slides = Vec::new();
    for (index, joint) in equations.system.mechanism.clone().joints.iter().enumerate() {
        let name = format!("{}.s", joint.name);
        let slides_freely = ["prismatic", "slot", "rolling"].contains(&joint.component().name);
        if slides_freely && equations.coordinates.iter().all(|coordinate| coordinate.name.position != name) {
            let slide = Variable { owner: Owner::Joint(JointId(index)), quantity: Quantity::S };
            slides.push((name, equations.variable(slide)));
        }
    }
    slides
}

fn mentioned(tree: &Value) -> Vec<&str> {
    match tree {
        Value::String(name) => vec![name],
        Value::Array(parts) => parts[1..].iter().flat_map(mentioned).collect(),
        _ => Vec::new(),
    }
}

fn mechanism(scene: &Scene) -> Mechanism {
    scene.resolve().unwrap_or_else(|faults| panic!("{faults}")).mechanism
}

#[test]
fn what_is_printed_has_the_value_of_the_equations() {
    let mut count = 0;
    for name in models() {
        let mechanism = mechanism(&model(&name));
        let choices = [
            mechanism.coordinates.clone(),
            CoordinateChoice::Absolute,
            CoordinateChoice::Joint,
            CoordinateChoice::Recommended,
        ];
        for choice in choices {
            let mut equations = equations(&mechanism, &choice).unwrap();
            count += check_values(&format!("{name}, {choice:?}"), &mut equations);
        }
    }
    assert!(count > 500, "only {count} formulas");
}

#[test]
fn random_mechanisms_are_printed_rightly() {
    for seed in 0..12 {
        for family in [Family::Chain, Family::Tree, Family::Loops, Family::Driven, Family::Redundant] {
            let case = random_case(seed, family);
            let scene = Scene::from_toml(&case.scene).unwrap_or_else(|faults| panic!("{faults}"));
            let mechanism = mechanism(&scene);
            let mut equations = equations(&mechanism, &mechanism.coordinates).unwrap();
            check_values(&format!("{family:?} {seed}"), &mut equations);
        }
    }
}

/// A page is well-formed XML but for its first line, so that it can be checked here.
fn elements(html: &str) -> usize {
    let mut reader = quick_xml::Reader::from_str(html);
    let mut count = 0;
    loop {
        match reader.read_event().unwrap_or_else(|error| panic!("{error}\n{html}")) {
            quick_xml::events::Event::Eof => return count,
            quick_xml::events::Event::Start(_) => count += 1,
            _ => {}
        }
    }
}

#[test]
fn pages_are_well_formed() {
    for name in models().into_iter().filter(|name| name != RUBBING_IN_DRIVEN) {
        let scene = model(&name);
        let motion = written::equations(&scene, EquationFormat::Html).unwrap_or_else(|faults| panic!("{faults}"));
        let steps = written::steps(&scene, Prose::Html).unwrap_or_else(|faults| panic!("{faults}"));
        assert!(elements(&motion) > 60 && elements(&steps) > 60, "{name}");
        assert!(!motion.contains("http"), "{name}: the page needs the network");
        let mechanism = mechanism(&scene);
        let mut equations = equations(&mechanism, &mechanism.coordinates).unwrap();
        assert!(elements(&format!("<div>{}</div>", text::mathml(&mut equations))) > 50, "{name}");
    }
}

#[test]
fn latex_documents_are_balanced() {
    for name in models().into_iter().filter(|name| name != RUBBING_IN_DRIVEN) {
        let scene = model(&name);
        let motion = written::equations(&scene, EquationFormat::Latex).unwrap_or_else(|faults| panic!("{faults}"));
        let steps = written::steps(&scene, Prose::Latex).unwrap_or_else(|faults| panic!("{faults}"));
        for document in [motion, steps] {
            let count = |what: &str| document.matches(what).count();
            let plain = document.replace("\\{", "").replace("\\}", "");
            assert_eq!(plain.matches('{').count(), plain.matches('}').count(), "{name}: braces");
            assert_eq!(count("\\begin{"), count("\\end{"), "{name}: environments");
            for line in document.lines() {
                let [left, right] = ["\\left", "\\right"].map(|side| line.matches(side).count());
                assert_eq!(left, right, "{name}: {line}");
                assert_eq!(line.matches('$').count() % 2, 0, "{name}: {line}");
            }
        }
    }
}
