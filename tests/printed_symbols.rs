//! Formulas of the JSON notation, evaluated by a reader of their own, give the accelerations and reactions that the runtime computes: with the
//! scene's numbers, and with a name for every number.

use crate::support::ROOT;
use crate::support::run::formulated;
use std::collections::HashMap;

use cotree::compile;
use cotree::run::Results;
use cotree::scene::{Requested, Scene};
use cotree_text::Prose;
use cotree_text::SymbolNotation;
use cotree_text::written::{self, EquationFormat};
use nalgebra::{DMatrix, DVector};
use serde_json::Value;

fn model(name: &str) -> Scene {
    let path = format!("{ROOT}/models/{name}/scene.toml");
    Scene::read(path).unwrap_or_else(|faults| panic!("{faults}"))
}

fn named(scene: &Scene, written: SymbolNotation) -> String {
    written::named(&mut formulated(&scene.resolve().unwrap()), written).unwrap()
}

fn value(tree: &Value, names: &HashMap<String, f64>) -> f64 {
    let list = match tree {
        Value::Number(number) => return number.as_f64().unwrap(),
        Value::String(name) => return *names.get(name).unwrap_or_else(|| panic!("`{name}` has no value")),
        Value::Array(list) => list,
        other => panic!("{other}"),
    };
    let operands: Vec<f64> = list[1..].iter().map(|operand| value(operand, names)).collect();
    match (list[0].as_str().unwrap(), operands.as_slice()) {
        ("+", all) => all.iter().sum(),
        ("*", all) => all.iter().product(),
        ("-", [a]) => -a,
        ("/", [a, b]) => a / b,
        ("^", [a, b]) => a.powf(*b),
        ("sqrt", [a]) => a.sqrt(),
        ("abs", [a]) => a.abs(),
        ("sin", [a]) => a.sin(),
        ("cos", [a]) => a.cos(),
        ("exp", [a]) => a.exp(),
        ("tanh", [a]) => a.tanh(),
        ("asin", [a]) => a.asin(),
        ("acos", [a]) => a.acos(),
        ("atan2", [a, b]) => a.atan2(*b),
        (other, _) => panic!("`{other}` is not in these models"),
    }
}

/// All named formulas at one instant, in the order in which they can be computed.
fn evaluate(json: &Value, names: &mut HashMap<String, f64>, solved: bool) {
    let mut formulas: Vec<&Value> = json["definitions"].as_array().unwrap().iter().collect();
    let groups = json["equations"].as_object().unwrap();
    let (sums, others): (Vec<_>, Vec<_>) = groups.iter().partition(|(group, _)| *group == "Q");
    formulas.extend(others.iter().chain(&sums).flat_map(|(_, list)| list.as_array().unwrap()));
    for formula in formulas {
        let unknown = |name: &str| name.starts_with("lambda[") || name.ends_with("alpha") || name.ends_with(".ax");
        if solved || !mentions(&formula["tree"], &|name| unknown(name) && !names.contains_key(name), names) {
            let result = value(&formula["tree"], names);
            names.insert(formula["name"].as_str().unwrap().to_owned(), result);
        }
    }
}

/// Does a formula depend on what is not known yet?
fn mentions(tree: &Value, unknown: &dyn Fn(&str) -> bool, names: &HashMap<String, f64>) -> bool {
    match tree {
        Value::String(name) => unknown(name) || !names.contains_key(name),
        Value::Array(list) => list[1..].iter().any(|operand| mentions(operand, unknown, names)),
        _ => false,
    }
}

/// Accelerations and multipliers of M a + Phi_q^T lambda = Q, Phi_q a = gamma.
fn solve(json: &Value, names: &HashMap<String, f64>) -> Vec<f64> {
    let n = json["coordinates"].as_array().unwrap().len();
    let m = json["reactions"].as_array().unwrap().len();
    let mut matrix = DMatrix::zeros(n + m, n + m);
    let mut right = DVector::zeros(n + m);
    for (group, list) in json["equations"].as_object().unwrap() {
        for formula in list.as_array().unwrap() {
            let at: Vec<usize> =
                formula["at"].as_array().into_iter().flatten().map(|at| at.as_u64().unwrap() as usize).collect();
            let result = || names[formula["name"].as_str().unwrap()];
            match group.as_str() {
                "M" => {
                    matrix[(at[0], at[1])] = result();
                    matrix[(at[1], at[0])] = result();
                }
                "Phi_q" => {
                    matrix[(n + at[0], at[1])] = result();
                    matrix[(at[1], n + at[0])] = result();
                }
                "Q" => right[at[0]] = result(),
                "gamma" => right[n + at[0]] = result(),
                _ => {}
            }
        }
    }
    matrix.lu().solve(&right).expect("a regular pose").iter().copied().collect()
}

/// A run with every variable that can be computed.
fn with_everything(scene: &Scene) -> Results {
    let (names, _) = compile::everything(scene).unwrap();
    let (compiled, _) = compile::compile_asking(scene, &Requested::Also(names)).unwrap();
    compiled.simulate().unwrap()
}

/// Compares with the runtime at instants of a run; returns how many reactions there were.
fn agrees(name: &str, json: &str, stop: f64) -> usize {
    let json: Value = serde_json::from_str(json).unwrap();
    let mut scene = model(name);
    scene.experiment.stop = Some(format!("{stop} s").as_str().into());
    let results = with_everything(&scene);
    let column = |own: &str| &results.column(own).unwrap_or_else(|| panic!("{own}")).values;
    let rows = results.times().len();
    let mut compared = 0;
    for row in [0, rows / 3, 2 * rows / 3, rows - 1] {
        let mut names = HashMap::from([("t".to_owned(), results.times()[row])]);
        for own in json["parameters"].as_array().unwrap() {
            names.insert(own["name"].as_str().unwrap().to_owned(), own["value"].as_f64().unwrap());
        }
        for own in json["inputs"].as_array().unwrap() {
            names.insert(own["name"].as_str().unwrap().to_owned(), own["start"].as_f64().unwrap());
        }
        let coordinates = json["coordinates"].as_array().unwrap();
        for own in coordinates {
            for key in ["name", "rate"] {
                let variable = own[key].as_str().unwrap();
                names.insert(variable.to_owned(), column(variable)[row]);
            }
        }
        evaluate(&json, &mut names, false);
        let solution = solve(&json, &names);
        for (own, &found) in coordinates.iter().zip(&solution) {
            let variable = own["acceleration"].as_str().unwrap();
            // The acceleration of a spring's length is no output on a line.
            if let Some(expected) = results.column(variable) {
                close(found, expected.values[row], &format!("{name}: {variable}"));
            }
            names.insert(variable.to_owned(), found);
        }
        for (own, &found) in json["reactions"].as_array().unwrap().iter().zip(&solution[coordinates.len()..]) {
            names.insert(own["name"].as_str().unwrap().to_owned(), found);
        }
        evaluate(&json, &mut names, true);
        for (variable, list) in json["equations"].as_object().unwrap() {
            if let Some(own) = results.column(variable) {
                let result = names[list[0]["name"].as_str().unwrap()];
                close(result, own.values[row], &format!("{name}: {variable}"));
                compared += 1;
            }
        }
    }
    compared
}

fn close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-7 * (1.0 + expected.abs()), "{what}: {found} instead of {expected}");
}

#[test]
fn formulas_with_numbers_and_with_names_give_what_the_runtime_computes() {
    for (name, stop, reactions) in [
        ("slider_crank", 0.3, 9),
        ("double_pendulum", 0.5, 4),
        ("four_bar", 0.2, 8),
        ("cart_pole", 0.4, 4),
        ("vibration", 0.4, 0),
    ] {
        let scene = model(name);
        let plain = written::equations(&scene, EquationFormat::Json).unwrap();
        let symbols = named(&scene, SymbolNotation::Json);
        assert!(symbols.len() > plain.len(), "{name}");
        for json in [plain, symbols] {
            let compared = agrees(name, &json, stop);
            assert!(compared >= 4 * reactions, "{name}: {compared} reactions");
        }
    }
}

#[test]
fn every_number_has_a_name_and_the_loads_are_apart() {
    let text = named(&model("slider_crank"), SymbolNotation::Prose(Prose::Text));
    for line in [
        "M[1,1] = I_crank + m_crank*l6^2 + (l6 + l7)^2*(m_rod + m_slider)",
        "M[1,2] = (l6 + l7)*(m_rod*l8 + m_slider*(l8 + l9))*(c1*c2 + s1*s2)",
        "Q_gravity[2] = -g*(m_rod*l8 + m_slider*(l8 + l9))*c2",
        "Q_velocity[2] = (l6 + l7)*(m_rod*l8 + m_slider*(l8 + l9))*crank.omega^2*(s1*c2 - c1*s2)",
        "Q[2] = Q_applied[2] + Q_gravity[2] + Q_velocity[2] + Q_elastic[2]",
    ] {
        assert!(text.lines().any(|own| own.trim() == line), "`{line}` is missing:\n{text}");
    }
    // Behind the values there is not a number but factors, powers and indices.
    let equations = text.split("\nEquations\n").nth(1).unwrap();
    assert!(!equations.contains("9.81") && !equations.contains("0.25") && !equations.contains("0.5625"), "{equations}");
    let text = named(&model("vibration"), SymbolNotation::Prose(Prose::Text));
    assert!(text.contains("M[2,2] = m2 + m3 + m4") && text.contains("K[1,2] = -k9 - k10"), "{text}");
    let latex = named(&model("slider_crank"), SymbolNotation::Prose(Prose::Latex));
    assert!(latex.contains(r"m_{\mathrm{rod}}") && latex.contains(r"Q_{\mathrm{1, gravity}}"), "{latex}");
}

fn reduced(scene: &Scene, symbols: bool) -> Value {
    let json =
        written::reduced(&mut formulated(&scene.resolve().unwrap()), SymbolNotation::Json, symbols).unwrap().unwrap();
    serde_json::from_str(&json).unwrap()
}

/// Names with values at an instant: parameters, inputs, coordinates and their rates.
fn known(json: &Value, results: &cotree::run::Results, row: usize) -> HashMap<String, f64> {
    let mut names = HashMap::from([("t".to_owned(), results.times()[row])]);
    for (list, key) in [("parameters", "value"), ("inputs", "start")] {
        for own in json[list].as_array().unwrap() {
            names.insert(own["name"].as_str().unwrap().to_owned(), own[key].as_f64().unwrap());
        }
    }
    for own in json["coordinates"].as_array().unwrap() {
        for variable in ["name", "rate"].map(|key| own[key].as_str().unwrap()) {
            names.insert(variable.to_owned(), results.column(variable).unwrap().values[row]);
        }
    }
    names
}

#[test]
fn reduced_equations_move_as_all_equations_do() {
    // Model, degrees of freedom, dependent coordinates, how many of them in closed form.
    for (name, freedoms, dependent, closed) in
        [("slider_crank", 1, 1, 1), ("double_pendulum", 2, 0, 0), ("four_bar", 1, 2, 0), ("quick_return", 0, 2, 2)]
    {
        let mut scene = model(name);
        scene.experiment.stop = Some("0.05 s".into());
        for symbols in [false, true] {
            let json = reduced(&scene, symbols);
            let independent: Vec<&str> =
                json["independent"].as_array().unwrap().iter().map(|own| own.as_str().unwrap()).collect();
            assert_eq!(independent.len(), freedoms, "{name}");
            let results = with_everything(&scene);
            let equations = json["equations"].as_object().unwrap();
            let rows = results.times().len();
            for row in [0, rows / 2, rows - 1] {
                let mut names = known(&json, &results, row);
                evaluate(&json, &mut names, false);
                let mut matrix = DMatrix::zeros(freedoms, freedoms);
                let mut right = DVector::zeros(freedoms);
                for entry in equations.get("M").into_iter().flat_map(|list| list.as_array().unwrap()) {
                    let at = [0, 1].map(|place| entry["at"][place].as_u64().unwrap() as usize);
                    let value = names[entry["name"].as_str().unwrap()];
                    (matrix[(at[0], at[1])], matrix[(at[1], at[0])]) = (value, value);
                }
                for entry in equations.get("Q").into_iter().flat_map(|list| list.as_array().unwrap()) {
                    right[entry["at"][0].as_u64().unwrap() as usize] = names[entry["name"].as_str().unwrap()];
                }
                let solution = if freedoms > 0 { matrix.lu().solve(&right).unwrap() } else { right };
                let coordinates = json["coordinates"].as_array().unwrap();
                for (own, found) in independent.iter().zip(solution.iter()) {
                    let own = coordinates.iter().find(|other| other["name"] == **own).unwrap();
                    let variable = own["acceleration"].as_str().unwrap();
                    close(*found, results.column(variable).unwrap().values[row], &format!("{name}: {variable}"));
                    names.insert(variable.to_owned(), *found);
                }
                evaluate(&json, &mut names, true);
                let (mut followed, mut positions) = (0, 0);
                for own in coordinates.iter().filter(|own| !independent.contains(&own["name"].as_str().unwrap())) {
                    for key in ["rate", "acceleration"] {
                        let variable = own[key].as_str().unwrap();
                        assert!(equations.contains_key(variable), "{name}: {variable}");
                        close(
                            names[variable],
                            results.column(variable).unwrap().values[row],
                            &format!("{name}: {variable}"),
                        );
                    }
                    let variable = own["name"].as_str().unwrap();
                    if equations.contains_key(variable) {
                        let gap = names[variable] - results.column(variable).unwrap().values[row];
                        close(gap.cos(), 1.0, &format!("{name}: {variable}"));
                        positions += 1;
                    }
                    followed += 1;
                }
                assert_eq!((followed, positions), (dependent, closed), "{name}");
            }
        }
    }
}

/// `push.fx` is along the x axis of the world, in `cotree simulate` too.
#[test]
fn a_force_in_the_axes_of_a_body_does_not_get_the_name_of_one_in_those_of_the_world() {
    let text = |frame: &str| {
        let scene = format!(
            "name = \"push\"\n[inputs]\nu = 0\n[bodies.rod]\nmass = 1\ninertia = 0.1\npoints = {{ tip = [1, 0] }}\n[joints.pin]\ntype = \"revolute\"\n\
             between = [\"ground\", \"rod\"]\n[loads.push]\ntype = \"force\"\non = \"rod.tip\"\nvector = [\"2*u\", \"3*u + sin(u)\"]\nframe = \"{frame}\"\n"
        );
        named(&Scene::from_toml(&scene).unwrap(), SymbolNotation::Prose(Prose::Text))
    };
    assert!(text("world").contains("push.fy") && !text("body").contains("push.fy"), "{}", text("body"));
}
