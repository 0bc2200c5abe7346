//! Parameters and inputs: units, default values, limits.

use std::collections::{HashMap, HashSet};

use super::Resolver;
use super::lower::Context;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::{Input, Parameter, Unit};
use crate::scene::dimension::ANYTHING;
use crate::scene::expression::{self, Tree, TreeKind};
use crate::scene::quantity::{Quantity, Reading, Value, read};
use crate::scene::unit;

/// A value that is given by an expression, and the parameters that it uses.
struct Pending {
    text: Text,
    tree: Tree,
    uses: HashSet<usize>,
}

impl Resolver<'_> {
    /// Resolves the parameters in the order of their dependences.
    pub(super) fn parameters(&mut self) -> Vec<Parameter> {
        let scene = self.scene;
        let count = scene.parameters.len();
        let units: Vec<Option<Unit>> =
            scene.parameters.iter().map(|parameter| self.unit(parameter.unit.as_ref())).collect();
        self.parameter_units = units.iter().map(|unit| unit.as_ref().map(|unit| unit.exponents)).collect();
        self.values = vec![f64::NAN; count];
        let mut found = units.clone();
        let mut pending = HashMap::new();
        for (index, parameter) in scene.parameters.iter().enumerate() {
            if let Some(expression) = self.pending(&parameter.value) {
                pending.insert(index, expression);
                continue;
            }
            let what = format!("parameter `{}`", parameter.name.text);
            let (value, unit) = self.declared(&parameter.value, units[index].as_ref(), &what);
            self.values[index] = value;
            self.parameter_units[index] = unit.as_ref().map(|unit| unit.exponents);
            found[index] = unit;
        }
        self.evaluate_in_order(pending, &mut found);
        scene
            .parameters
            .iter()
            .zip(found)
            .enumerate()
            .map(|(index, (parameter, unit))| {
                let what = format!("parameter `{}`", parameter.name.text);
                let value = self.values[index];
                let limits = [&parameter.min, &parameter.max];
                let [min, max] = self.limits(limits, value, units[index].as_ref(), unit.as_ref(), &what);
                Parameter {
                    name: parameter.name.text.clone(),
                    description: parameter.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
                    unit: unit.unwrap_or_default(),
                    value,
                    min,
                    max,
                    tunable: parameter.tunable,
                    span: parameter.name.span,
                }
            })
            .collect()
    }

    pub(super) fn inputs(&mut self) -> Vec<Input> {
        let scene = self.scene;
        let mut inputs = Vec::new();
        for input in &scene.inputs {
            let what = format!("input `{}`", input.name.text);
            let declared = self.unit(input.unit.as_ref());
            let zero = Quantity::from(0.0);
            let (start, unit) = self.declared(input.start.as_ref().unwrap_or(&zero), declared.as_ref(), &what);
            let [min, max] = self.limits([&input.min, &input.max], start, declared.as_ref(), unit.as_ref(), &what);
            self.input_units.push(unit.as_ref().map(|unit| unit.exponents));
            inputs.push(Input {
                name: input.name.text.clone(),
                description: input.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
                unit: unit.unwrap_or_default(),
                start,
                min,
                max,
                span: input.name.span,
            });
        }
        inputs
    }

    pub(super) fn unit(&mut self, text: Option<&Text>) -> Option<Unit> {
        match unit::parse(text?) {
            Ok(unit) => Some(unit),
            Err(fault) => {
                self.faults.push(fault);
                None
            }
        }
    }

    /// A value in a declared unit: a bare number is in that unit, other quantities are SI or have units of their own.
    fn declared(&mut self, quantity: &Quantity, declared: Option<&Unit>, what: &str) -> (f64, Option<Unit>) {
        let (formula, own) = self.formula_and_unit(quantity, what, &ANYTHING, Context::Constant);
        if let (Some(declared), Some(own)) = (declared, &own)
            && !unit::compatible(declared.exponents, own.exponents)
        {
            self.declared_mismatch(what, declared, own, quantity.span);
        }
        let formula = self.check_finite(formula, quantity, what);
        let display = declared.and_then(|unit| unit.display.as_ref());
        let factor = display.filter(|_| is_bare(quantity)).map_or(1.0, |display| display.factor);
        let value = self.value(&formula) * factor;
        (value, declared.cloned().or(own))
    }

    fn declared_mismatch(&mut self, what: &str, declared: &Unit, own: &Unit, span: Span) {
        let (declared, own) = (declared.shown(), own.shown());
        self.faults.push(
            Fault::new(
                "scene::wrong_unit",
                format!("{what} is in `{own}`, which does not agree with `{declared}`"),
                span,
            )
            .label(format!("not in `{declared}`"))
            .help(format!("give a bare number (it is taken in `{declared}`) or a unit of the same kind")),
        );
    }

    /// The smallest and largest value, and whether the value lies between.
    fn limits(
        &mut self,
        limits: [&Option<Quantity>; 2],
        value: f64,
        declared: Option<&Unit>,
        unit: Option<&Unit>,
        what: &str,
    ) -> [Option<f64>; 2] {
        let mut result = [None, None];
        for ((limit, found), name) in limits.into_iter().zip(&mut result).zip(["min", "max"]) {
            let Some(limit) = limit else { continue };
            let (bound, own) = self.declared(limit, declared, &format!("`{name}` of {what}"));
            if let (None, Some(unit), Some(own)) = (declared, unit, &own)
                && !unit::compatible(unit.exponents, own.exponents)
            {
                self.declared_mismatch(&format!("`{name}` of {what}"), unit, own, limit.span);
            }
            let outside = if name == "min" { value < bound } else { value > bound };
            if outside {
                self.faults.push(
                    Fault::new(
                        "scene::out_of_range",
                        format!("{what} is {value} (SI), outside its limit `{name}` of {bound}"),
                        limit.span,
                    )
                    .label(format!("`{name}`"))
                    .help("change the value or the limit"),
                );
            }
            *found = Some(bound);
        }
        result
    }

    /// The parsed value of a parameter that is an expression, if it is one that can be parsed.
    fn pending(&mut self, quantity: &Quantity) -> Option<Pending> {
        let Value::Text(text) = &quantity.value else {
            return None;
        };
        let text = Text::new(text.as_str(), quantity.span);
        if !matches!(read(&text), Ok(Reading::Expression)) {
            return None;
        }
        let tree = expression::parse(&text).ok()?;
        let mut uses = HashSet::new();
        self.parameters_in(&tree, &mut uses);
        Some(Pending { text, tree, uses })
    }

    fn parameters_in(&self, tree: &Tree, uses: &mut HashSet<usize>) {
        match &tree.kind {
            TreeKind::Name(name) => {
                if let Some(Named::Parameter(id)) = self.names.get(name) {
                    uses.insert(id.0);
                }
            }
            kind => kind.parts().iter().for_each(|part| self.parameters_in(part, uses)),
        }
    }

    /// Evaluates the expressions in topological order; the rest is a cycle.
    fn evaluate_in_order(&mut self, pending: HashMap<usize, Pending>, units: &mut [Option<Unit>]) {
        let mut waiting: HashMap<usize, usize> = HashMap::new();
        let mut users: HashMap<usize, Vec<usize>> = HashMap::new();
        for (&index, expression) in &pending {
            let uses = expression.uses.iter().filter(|used| pending.contains_key(used));
            waiting.insert(index, uses.clone().count());
            uses.for_each(|&used| users.entry(used).or_default().push(index));
        }
        let mut ready: Vec<usize> = waiting.iter().filter(|(_, count)| **count == 0).map(|(index, _)| *index).collect();
        ready.sort_unstable();
        let mut done = 0;
        while let Some(&index) = ready.get(done) {
            done += 1;
            waiting.remove(&index);
            self.evaluate(index, &pending[&index], units);
            for user in users.get(&index).into_iter().flatten() {
                if let Some(count) = waiting.get_mut(user) {
                    *count -= 1;
                    if *count == 0 {
                        ready.push(*user);
                    }
                }
            }
        }
        self.cycle(&pending, &waiting);
    }

    fn evaluate(&mut self, index: usize, pending: &Pending, units: &mut [Option<Unit>]) {
        let what = format!("parameter `{}`", self.scene.parameters[index].name.text);
        let Some((formula, known)) = self.constant_tree(&pending.tree, &pending.text, &what) else {
            return;
        };
        let known = known.unit();
        let found = known.map(unit::from_exponents);
        if let (Some(declared), Some(found)) = (&units[index], &found)
            && !unit::compatible(declared.exponents, found.exponents)
        {
            let (declared, found) = (declared.clone(), found.clone());
            self.declared_mismatch(&what, &declared, &found, pending.text.span);
        }
        self.values[index] = self.value(&formula);
        let spoiled = pending.uses.iter().any(|used| !self.values[*used].is_finite());
        if !self.values[index].is_finite() && !spoiled {
            let message = format!("{what} is not a finite number");
            let label = format!("this is {}", self.values[index]);
            self.faults.push(Fault::new("scene::not_finite", message, pending.text.span).label(label));
        }
        if units[index].is_none() {
            self.parameter_units[index] = known;
            units[index] = found;
        }
    }

    /// Reports one cycle among the parameters that wait for each other.
    fn cycle(&mut self, pending: &HashMap<usize, Pending>, waiting: &HashMap<usize, usize>) {
        let Some(&first) = waiting.keys().min() else {
            return;
        };
        let mut path = vec![first];
        let mut at = HashMap::from([(first, 0)]);
        // Each waiting parameter uses another waiting one, so the walk returns to where it was.
        while let Some(next) =
            path.last().and_then(|last| pending[last].uses.iter().filter(|used| waiting.contains_key(used)).min())
        {
            if let Some(&start) = at.get(next) {
                let names: Vec<String> = path[start..]
                    .iter()
                    .chain([next])
                    .map(|index| format!("`{}`", self.scene.parameters[*index].name.text))
                    .collect();
                let message = format!("parameters depend on each other in a circle: {}", names.join(" -> "));
                self.faults.push(
                    Fault::new("scene::cycle", message, pending[next].text.span)
                        .label("part of the circle")
                        .help("give one of them a number"),
                );
                return;
            }
            at.insert(*next, path.len());
            path.push(*next);
        }
    }
}

/// Is this a number without a unit, in a text or not?
fn is_bare(quantity: &Quantity) -> bool {
    match &quantity.value {
        Value::Number(_) => true,
        Value::Text(text) => matches!(read(&Text::from(text.as_str())), Ok(Reading::Number(_))),
    }
}
