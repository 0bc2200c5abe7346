//! The equations as JSON, for other programs: names, and every formula as text and as a tree.

use cotree::equations::Equations;
use cotree::expr::{Order, Symbol};
use cotree::model::{DriverId, InputId};
use cotree::network::Constrained;
use serde_json::{Map, Value, json};

use super::matrices::Matrices;
use super::modes::Modes;
use super::motion::MotionEquations;
use super::name::Name;
use super::notation::plain::PLAIN;
use super::symbol_name;
use super::tree::{FormulaTree, Formulas};

/// The whole description. Numbers have 15 digits: those of the printed code are exact.
pub fn json(equations: &mut Equations) -> String {
    let motion = MotionEquations::new(equations);
    let value = described(equations, &motion);
    format!("{value:#}\n")
}

/// Some equations of a mechanism as JSON.
pub fn described(equations: &mut Equations, motion: &MotionEquations) -> Value {
    let Formulas { angles, definitions, formulas } = motion.formulas(equations);
    let mut formulas = formulas.into_iter();
    let mut groups = Map::new();
    for (_, entries) in &motion.groups {
        for (name, _) in entries {
            let group = name.plain.split('[').next().unwrap_or(&name.plain).to_owned();
            let entry = formula(name, &formulas.next().unwrap_or_else(FormulaTree::zero));
            match groups.entry(group).or_insert_with(|| Value::Array(Vec::new())) {
                Value::Array(list) => list.push(entry),
                _ => continue, // every group is a list
            }
        }
    }
    if !motion.sums.is_empty() {
        groups.insert("Q".to_owned(), motion.sums.iter().map(|(name, sum)| formula(name, sum)).collect());
    }
    let named = |pairs: &[(FormulaTree, FormulaTree)]| -> Vec<Value> {
        let pairs = pairs.iter().filter_map(|(name, value)| match name {
            FormulaTree::Name(name) => Some(formula(name, value)),
            _ => None,
        });
        pairs.collect()
    };
    let definitions = [named(&angles), named(&definitions)].concat();
    let matrices = Matrices::new(equations);
    let mut value = json!({
        "name": equations.system.mechanism.name,
        "dynamic": motion.dynamic,
        "parameters": parameters(equations),
        "inputs": inputs(equations),
        "followers": followers(equations),
        "coordinates": coordinates(equations),
        "reactions": reactions(equations),
        "definitions": definitions,
        "equations": groups,
    });
    if let Some(matrices) = matrices {
        value["matrices"] = matrices.json();
    }
    if let Some(modes) = Modes::new(equations) {
        [value["modes"], value["levels"]] = modes.json();
    }
    value
}

/// `at` are the places in the matrix, counted from 0.
pub fn formula(name: &Name, value: &FormulaTree) -> Value {
    let mut entry = json!({ "name": name.plain, "text": PLAIN.formula(value), "tree": tree(value) });
    let places: Vec<usize> = name.subscript.split(',').filter_map(|place| place.parse().ok()).collect();
    if name.plain.contains('[') {
        let places: Vec<usize> = places.into_iter().map(|place| place.saturating_sub(1)).collect();
        entry["at"] = json!(places);
    }
    entry
}

/// A number, a name, or `[operator, operand, ...]`.
pub fn tree(tree_of: &FormulaTree) -> Value {
    let call = |operator: &str, operands: &[FormulaTree]| -> Value {
        std::iter::once(json!(operator)).chain(operands.iter().map(tree)).collect()
    };
    match tree_of {
        FormulaTree::Number(value) => json!(value),
        FormulaTree::Pi => json!(std::f64::consts::PI),
        FormulaTree::Name(name) => json!(name.plain),
        FormulaTree::Sum(terms) => {
            let term = |(minus, term): &(bool, FormulaTree)| if *minus { json!(["-", tree(term)]) } else { tree(term) };
            std::iter::once(json!("+")).chain(terms.iter().map(term)).collect()
        }
        FormulaTree::Product(factors) => call("*", factors),
        FormulaTree::Quotient(parts) => call("/", parts.as_ref()),
        FormulaTree::Power(parts) => call("^", parts.as_ref()),
        FormulaTree::Root(inside) => call("sqrt", std::slice::from_ref(inside.as_ref())),
        FormulaTree::Call(function, arguments) => call(function, arguments),
        FormulaTree::Relation(sign, parts) => call(sign, parts.as_ref()),
    }
}

fn parameters(equations: &Equations) -> Vec<Value> {
    let mechanism = &equations.system.mechanism;
    let parameters = mechanism
        .parameters
        .iter()
        .map(|parameter| json!({ "name": parameter.name, "value": parameter.value, "unit": parameter.unit.si }));
    // Discrete variables of modes are listed behind the parameters; sampled values and times of events behind the inputs.
    let of_modes = mechanism
        .discrete
        .iter()
        .filter(|discrete| discrete.is_of_mode())
        .map(|discrete| json!({ "name": discrete.name, "value": discrete.start(), "unit": discrete.unit.si }));
    parameters.chain(of_modes).collect()
}

fn inputs(equations: &Equations) -> Vec<Value> {
    let mechanism = &equations.system.mechanism;
    let inputs =
        mechanism.inputs.iter().map(|input| json!({ "name": input.name, "start": input.start, "unit": input.unit.si }));
    let discrete = mechanism
        .discrete
        .iter()
        .filter(|discrete| !discrete.is_of_mode())
        .map(|discrete| json!({ "name": discrete.name, "start": discrete.start(), "unit": discrete.unit.si }));
    inputs.chain(discrete).collect()
}

fn followers(equations: &Equations) -> Vec<Value> {
    let mechanism = &equations.system.mechanism;
    let of = |(index, (driver, input, given)): (usize, &(DriverId, InputId, Order))| {
        let [position, rate, acceleration] =
            Order::ALL.map(|order| symbol_name(equations, Symbol::Follower(index, order)));
        json!({
            "name": position, "rate": rate, "acceleration": acceleration,
            "driver": mechanism.drivers[driver.0].name, "input": mechanism.inputs[input.0].name,
            "given": if *given == Order::Velocity { "rate" } else { "acceleration" },
        })
    };
    equations.system.followers.iter().enumerate().map(of).collect()
}

fn coordinates(equations: &Equations) -> Vec<Value> {
    let of = |(index, coordinate): (usize, &cotree::equations::Coordinate)| {
        let [position, rate, acceleration] =
            Order::ALL.map(|order| symbol_name(equations, Symbol::Coordinate(index, order)));
        json!({ "name": position, "rate": rate, "acceleration": acceleration, "unit": if coordinate.angular { "rad" } else { "m" } })
    };
    equations.coordinates.iter().enumerate().map(of).collect()
}

fn reactions(equations: &Equations) -> Vec<Value> {
    let of = |(index, constraint): (usize, &cotree::equations::Constraint)| {
        let unit = if constraint.constrained == Constrained::Angle { "N.m" } else { "N" };
        let name = symbol_name(equations, Symbol::Reaction(index));
        json!({ "name": name, "owner": equations.system.name(constraint.element), "unit": unit })
    };
    equations.loops().map(of).collect()
}
