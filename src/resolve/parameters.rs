//! Parameters and inputs: units, default values, limits.

use std::collections::{HashMap, HashSet};

use super::lower::Context;
use super::names::Named;
use super::{Resolver, UNKNOWN};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::{Bound, Calculated, Formula, Input, Parameter, ParameterId, Range, Unit};
use crate::scene::dimension::ANYTHING;
use crate::scene::expression::{self, Tree, TreeKind};
use crate::scene::quantity::{Quantity, Reading, Value, read};
use crate::scene::unit::{self, Exponents};

/// A value that is given by an expression, and the parameters that it uses.
struct Pending {
    text: Text,
    tree: Tree,
    uses: HashSet<usize>,
}

/// More operations than a calculated parameter may take when all that it uses is written out.
const LONGEST: usize = 10_000;

/// A parameter of the scene in expressions.
pub(super) struct Known {
    /// Its place among those with values of their own; nothing for calculated ones.
    id: Option<ParameterId>,
    /// Itself, or what it is calculated from.
    pub formula: Formula,
    pub unit: Option<Exponents>,
}

impl Resolver<'_> {
    /// Resolves the parameters in the order of their dependences: those with values of their own, and those that are calculated from others.
    pub(super) fn parameters(&mut self) -> (Vec<Parameter>, Vec<Calculated>) {
        let scene = self.scene;
        let mut units: Vec<Option<Unit>> =
            scene.parameters.iter().map(|parameter| self.unit(parameter.unit.as_ref())).collect();
        let declared = units.clone();
        let pending: HashMap<usize, Pending> = (scene.parameters.iter().enumerate())
            .filter_map(|(index, parameter)| Some((index, self.pending(&parameter.value)?)))
            .collect();
        let mut own = 0..;
        for (index, unit) in units.iter().enumerate() {
            let calculated = pending.get(&index).is_some_and(|expression| !expression.uses.is_empty());
            let id = if calculated { None } else { own.next().map(ParameterId) };
            let unit = unit.as_ref().map(|unit| unit.exponents);
            self.parameters.push(Known { id, formula: id.map_or(UNKNOWN, Formula::Parameter), unit });
        }
        self.values = vec![f64::NAN; own.start];
        for (index, parameter) in scene.parameters.iter().enumerate().filter(|(index, _)| !pending.contains_key(index))
        {
            let what = format!("parameter `{}`", parameter.name.text);
            let (value, unit) = self.declared(&parameter.value, declared[index].as_ref(), &what);
            self.give(index, Formula::Number(value));
            self.parameters[index].unit = unit.as_ref().map(|unit| unit.exponents);
            units[index] = unit;
        }
        self.evaluate_in_order(pending, &mut units);
        let mut found = Vec::new();
        for (index, unit) in units.into_iter().enumerate() {
            found.push(self.parameter(index, declared[index].as_ref(), unit));
        }
        let is_own = |index: &usize| self.parameters[*index].id.is_some();
        let (own, others): (Vec<usize>, Vec<usize>) = (0..found.len()).partition(is_own);
        let independent = own.into_iter().map(|index| found[index].clone()).collect::<Vec<Parameter>>();
        let calculated = others.into_iter().map(|index| self.calculated(index, found[index].clone(), &independent));
        let calculated = calculated.collect();
        (independent, calculated)
    }

    /// A parameter whose value is known.
    fn parameter(&mut self, index: usize, declared: Option<&Unit>, unit: Option<Unit>) -> Parameter {
        let scene = &self.scene.parameters[index];
        let what = format!("parameter `{}`", scene.name.text);
        let value = self.value(&self.parameters[index].formula);
        let [min, max] = self.limits([&scene.min, &scene.max], value, declared, unit.as_ref(), &what);
        Parameter {
            name: scene.name.text.clone(),
            description: scene.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
            unit: unit.unwrap_or_default(),
            value,
            min,
            max,
            tunable: scene.tunable,
            span: scene.name.span,
        }
    }

    /// A parameter that is calculated: its limits hold whatever the others are, and it changes in a run if one of them does.
    fn calculated(&mut self, index: usize, parameter: Parameter, independent: &[Parameter]) -> Calculated {
        let formula = self.parameters[index].formula.clone();
        let what = format!("parameter `{}`", parameter.name);
        let ranges = [parameter.min.map(Range::AtLeast), parameter.max.map(Range::AtMost)];
        let bound = |range| Bound { name: what.clone(), value: formula.clone(), range };
        self.bounds.extend(ranges.into_iter().flatten().map(bound));
        let mut tunable = false;
        formula.visit_parameters(&mut |id| tunable |= independent[id.0].tunable);
        Calculated { parameter: Parameter { tunable, ..parameter }, formula }
    }

    /// The value of a parameter of its own, or what another one is calculated from.
    fn give(&mut self, index: usize, formula: Formula) {
        match self.parameters[index].id {
            Some(id) => self.values[id.0] = self.value(&formula),
            None => self.parameters[index].formula = formula,
        }
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
                if let Some(Named::Parameter(index)) = self.names.get(name) {
                    uses.insert(index);
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
        let value = self.value(&formula);
        let spoiled = pending.uses.iter().any(|used| !self.value(&self.parameters[*used].formula).is_finite());
        if !value.is_finite() && !spoiled {
            let message = format!("{what} is not a finite number");
            let label = format!("this is {value}");
            self.faults.push(Fault::new("scene::not_finite", message, pending.text.span).label(label));
        }
        if formula.operations() > LONGEST {
            let message =
                format!("the scene is too large: {what} takes more than {LONGEST} operations with what it uses");
            let fault = Fault::new("scene::too_large", message, pending.text.span).label("too long when written out");
            self.faults.push(fault.help("give one of the parameters that it uses a number"));
            return;
        }
        self.give(index, formula);
        if units[index].is_none() {
            self.parameters[index].unit = known;
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
