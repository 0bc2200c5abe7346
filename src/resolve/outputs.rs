//! Outputs.

use std::collections::HashSet;

use super::Resolver;
use super::context::Context;
use super::formulas::ReadFormula;
use super::names::{Named, check_identifier};
use super::signals::ResolvedSignal;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::model::measure::ANYTHING;
use crate::model::{DiscreteId, Formula, Output, StateId, Unit};
use crate::scene::dimension::KnownUnit;
use crate::scene::quantity::Quantity;
use crate::scene::{Requested, model};

impl Resolver<'_> {
    pub(super) fn outputs(&mut self, requested: &Requested) -> Vec<Output> {
        let scene = self.scene;
        let (variables, expressions) = scene.requested(requested);
        let mut seen = HashSet::new();
        let mut outputs = Vec::new();
        for name in &variables {
            outputs.extend(self.variable_output(name));
            if !seen.insert(&name.text) {
                self.duplicate_output(format!("output `{}` is listed twice", name.text), name.span);
            }
        }
        for output in expressions {
            let name = &output.name;
            check_identifier(name, "output", self.faults);
            if let Some(named) = self.names.get(&name.text) {
                let problem = format!("output `{}` has the name of a {}", name.text, named.word());
                self.duplicate_output(problem, name.span);
            } else if !seen.insert(&name.text) {
                self.duplicate_output(format!("output `{}` is defined twice", name.text), name.span);
            }
            outputs.push(self.expression_output(output));
        }
        outputs
    }

    fn variable_output(&mut self, name: &Text) -> Option<Output> {
        // What is asked for beside the scene has no place in it.
        let user = if name.span.is_nowhere() { "the request" } else { "`[outputs]`" };
        if let Some(Named::Signal(index)) = self.names.get(&name.text) {
            return self.signal_output(index, name.span);
        }
        if let Some(Named::State(id)) = self.named(&name.text) {
            return Some(self.state_output(id, name.span));
        }
        if let Some(Named::Sampled(id)) = self.named(&name.text) {
            return Some(self.discrete_output(id, name));
        }
        if let Some((_, id)) = self.scene.event_of_time(&name.text) {
            return Some(self.discrete_output(id, name));
        }
        let variable = self.variable(name, user, "scene::unknown_output")?;
        Some(Output {
            name: name.text.clone(),
            description: Resolver::describe(variable, &name.text),
            unit: Unit::of(&variable.quantity.measure(), None),
            is_open: false,
            value: Formula::Variable(variable),
            span: name.span,
        })
    }

    fn state_output(&mut self, id: StateId, span: Span) -> Output {
        self.used_states.insert(id);
        let description = self
            .scene
            .states
            .get(id.0)
            .map_or_else(String::new, |state| described(state.description.as_ref(), &state.rate));
        let unit = self.state_units[id.0].map(|(exponents, _)| crate::scene::unit::from_exponents(exponents));
        Output {
            name: self.state_name(id),
            description,
            is_open: unit.is_none(),
            unit: unit.unwrap_or_default(),
            value: Formula::State(id),
            span,
        }
    }

    fn discrete_output(&mut self, id: DiscreteId, name: &Text) -> Output {
        self.used_discrete.insert(id);
        let unit = self.discrete_units[id.0].map(|(exponents, _)| crate::scene::unit::from_exponents(exponents));
        Output {
            name: name.text.clone(),
            description: String::new(),
            is_open: unit.is_none(),
            unit: unit.unwrap_or_default(),
            value: Formula::Discrete(id),
            span: name.span,
        }
    }

    fn signal_output(&mut self, index: usize, span: Span) -> Option<Output> {
        self.used_signals.insert(index);
        let ResolvedSignal { formula, known, unit } = self.signals[index].clone()?;
        let signal = &self.scene.signals[index];
        let description = signal.description.as_ref().map(|text| text.text.clone());
        Some(Output {
            name: signal.name.text.clone(),
            description: description.unwrap_or_else(|| Resolver::wording_of_signal(signal)),
            is_open: unit.is_none() && known != KnownUnit::Number,
            unit: unit.unwrap_or_default(),
            value: formula,
            span,
        })
    }

    fn expression_output(&mut self, output: &model::Signal) -> Output {
        let model::Signal { name, value, unit, description, .. } = output;
        let what = format!("output `{}`", name.text);
        let ReadFormula { formula, unit: formula_unit, known } =
            self.formula_and_known(value, &what, &ANYTHING, Context::Output);
        let declared = self.unit(unit.as_ref());
        if let (Some(declared), Some(formula_unit)) = (&declared, &formula_unit)
            && !declared.exponents.is_compatible(formula_unit.exponents)
        {
            let (problem, span) =
                (format!("{what} is in `{}`", formula_unit.shown()), unit.as_ref().map_or(name.span, |unit| unit.span));
            self.faults.push(
                Fault::new(
                    "scene::wrong_unit",
                    format!("{problem}, which cannot be converted to `{}`", declared.shown()),
                    span,
                )
                .label(format!("not a unit for `{}`", formula_unit.shown()))
                .help("give a unit of the same kind; the expression itself is in SI units"),
            );
        }
        Output {
            name: name.text.clone(),
            description: described(description.as_ref(), value),
            is_open: declared.is_none() && formula_unit.is_none() && known != KnownUnit::Number,
            unit: declared.or(formula_unit).unwrap_or_default(),
            value: formula,
            span: name.span,
        }
    }

    fn duplicate_output(&mut self, problem: String, span: Span) {
        self.faults.push(
            Fault::new("scene::duplicate_name", problem, span)
                .label("second time")
                .help("remove it or choose another name"),
        );
    }
}

/// A description, or the expression in its place.
fn described(description: Option<&Text>, value: &Quantity) -> String {
    description.map_or_else(|| Resolver::wording(value), |text| text.text.clone())
}
