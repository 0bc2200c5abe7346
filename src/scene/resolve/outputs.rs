//! Outputs.

use std::collections::HashSet;

use super::Resolver;
use super::lower::Context;
use super::names::check_identifier;
use super::variables::wanted;
use crate::mechanism::{Formula, Output, Unit};
use crate::scene::dimension::ANYTHING;
use crate::scene::fault::Fault;
use crate::scene::quantity::Quantity;
use crate::scene::span::Text;

impl Resolver<'_> {
    pub(super) fn outputs(&mut self) -> Vec<Output> {
        let scene = self.scene;
        let mut seen = HashSet::new();
        let mut outputs = Vec::new();
        for name in &scene.outputs.variables {
            outputs.extend(self.variable_output(name));
            self.check_once(&mut seen, name);
        }
        for (name, value) in &scene.outputs.expressions {
            check_identifier(name, "output", self.faults);
            self.check_once(&mut seen, name);
            outputs.push(self.expression_output(name, value));
        }
        outputs
    }

    fn variable_output(&mut self, name: &Text) -> Option<Output> {
        let variable = self.variable(name, "`[outputs]`", "scene::unknown_output")?;
        let wanted = wanted(variable.quantity);
        Some(Output {
            name: name.text.clone(),
            description: Resolver::describe(variable, &name.text),
            unit: Unit { exponents: wanted.exponents.unwrap_or_default(), si: wanted.si.to_string(), display: None },
            value: Formula::Variable(variable),
            span: name.span,
        })
    }

    fn expression_output(&mut self, name: &Text, value: &Quantity) -> Output {
        let what = format!("output `{}`", name.text);
        let (formula, unit) = self.formula_and_unit(value, &what, &ANYTHING, Context::Output);
        Output {
            name: name.text.clone(),
            description: Resolver::wording(value),
            unit: unit.unwrap_or_default(),
            value: formula,
            span: name.span,
        }
    }

    fn check_once<'s>(&mut self, seen: &mut HashSet<&'s str>, name: &'s Text) {
        let other =
            self.names.get(&name.text).map(|named| format!("the {} `{}` has this name", named.word(), name.text));
        let other = other.or_else(|| (!seen.insert(&name.text)).then(|| "it is listed already".to_string()));
        if let Some(other) = other {
            self.faults.push(
                Fault::new(
                    "scene::duplicate_name",
                    format!("output `{}` is there twice: {other}", name.text),
                    name.span,
                )
                .label("second time")
                .help("remove it or choose another name"),
            );
        }
    }
}
