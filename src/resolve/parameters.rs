//! Parameters and inputs: units, default values, limits.

use super::Resolver;
use super::context::Context;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::model::measure::ANYTHING;
use crate::model::{Calculated, Formula, Input, Parameter, Unit};
use crate::scene::quantity::{Quantity, QuantityReading, Value, read};
use crate::scene::unit;

impl Resolver<'_> {
    /// Resolves the parameters: those with values of their own, and those that are calculated from others.
    pub(super) fn parameters(&mut self) -> (Vec<Parameter>, Vec<Calculated>) {
        let scene = self.scene;
        let declared: Vec<Option<Unit>> =
            scene.parameters.iter().map(|parameter| self.unit(parameter.unit.as_ref())).collect();
        let place = |named| if let Named::Parameter(index) = named { Some(index) } else { None };
        let (expressions, uses) = self.expressions(scene.parameters.iter().map(|parameter| &parameter.value), place);
        self.introduce_parameters(&declared, &uses);
        let mut units = declared.clone();
        for (index, parameter) in scene.parameters.iter().enumerate() {
            if expressions.contains_key(&index) {
                continue;
            }
            let what = format!("parameter `{}`", parameter.name.text);
            let (value, unit) = self.declared(&parameter.value, declared[index].as_ref(), &what);
            self.give(index, Formula::Number(value));
            self.parameters[index].unit = unit.as_ref().map(|unit| unit.exponents);
            self.parameters[index].hertz = hertz(unit.as_ref(), Some(&parameter.value), parameter.unit.as_ref());
            units[index] = unit;
        }
        self.evaluate_in_order(&expressions, &uses, &mut units);
        let (mut independent, mut others) = (Vec::new(), Vec::new());
        for (index, (declared, unit)) in declared.iter().zip(units).enumerate() {
            let parameter = self.parameter(index, declared.as_ref(), unit);
            match self.calculated_from(index) {
                None => independent.push(parameter),
                Some(formula) => others.push((parameter, formula)),
            }
        }
        let others =
            others.into_iter().map(|(parameter, formula)| self.calculated(parameter, formula, &independent)).collect();
        (independent, others)
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

    pub(super) fn inputs(&mut self) -> Vec<Input> {
        let scene = self.scene;
        let mut inputs = Vec::new();
        for input in &scene.inputs {
            let what = format!("input `{}`", input.name.text);
            let declared = self.unit(input.unit.as_ref());
            let zero = Quantity::from(0.0);
            let (start, unit) = self.declared(input.start.as_ref().unwrap_or(&zero), declared.as_ref(), &what);
            let [min, max] = self.limits([&input.min, &input.max], start, declared.as_ref(), unit.as_ref(), &what);
            let hertz = hertz(unit.as_ref(), input.start.as_ref(), input.unit.as_ref());
            self.input_units.push(unit.as_ref().map(|unit| (unit.exponents, hertz)));
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
        let (formula, formula_unit) = self.formula_and_unit(quantity, what, &ANYTHING, Context::Constant);
        if let (Some(declared), Some(formula_unit)) = (declared, &formula_unit)
            && !declared.exponents.is_compatible(formula_unit.exponents)
        {
            self.declared_mismatch(what, declared, formula_unit, quantity.span);
        }
        let formula = self.check_finite(formula, quantity, what);
        let value = self.value(&formula) * bare_factor(declared, quantity);
        (value, declared.cloned().or(formula_unit))
    }

    pub(super) fn declared_mismatch(&mut self, what: &str, declared: &Unit, unit: &Unit, span: Span) {
        let is_pure = unit.shown().is_empty();
        let actual = if is_pure { "a pure number".to_owned() } else { format!("in `{}`", unit.shown()) };
        let declared = declared.shown();
        self.faults.push(
            Fault::new(
                "scene::wrong_unit",
                format!("{what} is {actual}, which does not agree with `{declared}`"),
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
            let (bound, bound_unit) = self.declared(limit, declared, &format!("`{name}` of {what}"));
            if let (None, Some(unit), Some(bound_unit)) = (declared, unit, &bound_unit)
                && !unit.exponents.is_compatible(bound_unit.exponents)
            {
                self.declared_mismatch(&format!("`{name}` of {what}"), unit, bound_unit, limit.span);
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
}

/// What a value in a declared unit is multiplied by, so that it is SI: a bare number is in that unit, all else is SI already.
pub(super) fn bare_factor(declared: Option<&Unit>, quantity: &Quantity) -> f64 {
    let display = declared.and_then(|unit| unit.display.as_ref()).filter(|_| is_bare(quantity));
    display.map_or(1.0, |display| display.factor)
}

/// Is this a number without a unit, in a text or not?
fn is_bare(quantity: &Quantity) -> bool {
    match &quantity.value {
        Value::Number(_) => true,
        Value::Text(text) => matches!(read(&Text::from(text.as_str())), Ok(QuantityReading::Number(_))),
    }
}

/// How many seconds of a unit are written as hertz, in a value or as a declared unit.
pub(super) fn hertz(unit: Option<&Unit>, value: Option<&Quantity>, declared: Option<&Text>) -> i8 {
    let of_value = value.is_some_and(|value| match &value.value {
        Value::Text(text) => {
            matches!(read(&Text::from(text.as_str())), Ok(QuantityReading::Measure(..))) && text.contains("Hz")
        }
        Value::Number(_) => false,
    });
    let in_hertz = of_value || declared.is_some_and(|declared| declared.text.contains("Hz"));
    unit.filter(|_| in_hertz).map_or(0, |unit| unit.exponents.second.saturating_neg())
}
