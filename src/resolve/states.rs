//! States: quantities whose rates are given, such as currents and pressures.

use super::Resolver;
use super::context::Context;
use super::formulas::ReadFormula;
use super::parameters::{bare_factor, hertz};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::model::measure::ANYTHING;
use crate::model::{Formula, State, Unit};
use crate::scene::dimension::KnownUnit;
use crate::scene::model;
use crate::scene::quantity::Quantity;
use crate::scene::unit::from_exponents;

impl Resolver<'_> {
    /// The states without their rates, which may name everything; their units are known from here on.
    pub(super) fn declare_states(&mut self) -> Vec<State> {
        let scene = self.scene;
        let mut states = Vec::new();
        for state in &scene.states {
            let declared = self.within(state.within, |resolver| resolver.declare_state(state));
            states.push(declared);
        }
        states
    }

    fn declare_state(&mut self, state: &model::State) -> State {
        let what = format!("state `{}`", state.name.text);
        let declared = self.unit(state.unit.as_ref());
        let zero = Quantity::from(0.0);
        let start = state.start.as_ref().unwrap_or(&zero);
        let (formula, start_unit) = self.in_unit(start, declared.as_ref(), &format!("`start` of {what}"));
        let unit = declared.clone().or(start_unit);
        let hertz = hertz(unit.as_ref(), state.start.as_ref(), state.unit.as_ref());
        self.declared_state_units.push(unit.clone());
        self.state_units.push(unit.as_ref().map(|unit| (unit.exponents, hertz)));
        let nominal = self.nominal(state, (&formula, declared.as_ref(), unit.as_ref()), &what);
        State {
            name: state.name.text.clone(),
            description: state.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
            unit: unit.unwrap_or_default(),
            start: formula,
            rate: super::UNKNOWN,
            nominal,
            variable: None,
            span: state.name.span,
        }
    }

    /// A constant in a declared unit: a bare number is in that unit.
    fn in_unit(&mut self, quantity: &Quantity, declared: Option<&Unit>, what: &str) -> (Formula, Option<Unit>) {
        let (formula, formula_unit) = self.formula_and_unit(quantity, what, &ANYTHING, Context::Constant);
        self.must_agree(what, declared, formula_unit.as_ref(), quantity.span);
        let formula = self.check_finite(formula, quantity, what);
        (formula * Formula::Number(bare_factor(declared, quantity)), formula_unit)
    }

    pub(super) fn must_agree(&mut self, what: &str, declared: Option<&Unit>, actual: Option<&Unit>, span: Span) {
        if let (Some(declared), Some(actual)) = (declared, actual)
            && !declared.exponents.is_compatible(actual.exponents)
        {
            self.declared_mismatch(what, declared, actual, span);
        }
    }

    /// The usual size: as it is given, or that of the start, or 1.
    fn nominal(
        &mut self,
        state: &model::State,
        (start, declared, unit): (&Formula, Option<&Unit>, Option<&Unit>),
        what: &str,
    ) -> f64 {
        let Some(nominal) = &state.nominal else {
            let size = self.value(start).abs();
            return if size > 0.0 && size.is_finite() { size } else { 1.0 };
        };
        let what = format!("`nominal` of {what}");
        let (formula, nominal_unit) = self.in_unit(nominal, declared, &what);
        self.must_agree(&what, unit, nominal_unit.as_ref().filter(|_| declared.is_none()), nominal.span);
        let formula = self.check_positive(formula, nominal, &what, &ANYTHING);
        self.value(&formula)
    }

    /// The states with their rates, and behind them those of the signals.
    pub(super) fn states(&mut self, mut states: Vec<State>) -> Vec<State> {
        let scene = self.scene;
        for (state, written) in states.iter_mut().zip(&scene.states) {
            state.rate = self.within(written.within, |resolver| resolver.rate(written, &state.unit));
        }
        states.extend(self.transfers.states.iter().cloned());
        states
    }

    fn rate(&mut self, state: &model::State, unit: &Unit) -> Formula {
        let what = format!("`rate` of state `{}`", state.name.text);
        let ReadFormula { formula, unit: rate_unit, known } =
            self.formula_and_known(&state.rate, &what, &ANYTHING, Context::Rate);
        let wanted = unit.per_second();
        let differs = |actual: &Unit| known != KnownUnit::Number && !actual.exponents.is_compatible(wanted.exponents);
        if let Some(rate_unit) = rate_unit.filter(|actual| !unit.si.is_empty() && differs(actual)) {
            let wanted = from_exponents(wanted.exponents).si;
            let actual =
                if rate_unit.si.is_empty() { "a pure number".to_owned() } else { format!("in `{}`", rate_unit.si) };
            let message = format!("{what} must be in `{wanted}`, but is {actual}");
            let fault = Fault::new("scene::wrong_unit", message, state.rate.span).label(format!("not in `{wanted}`"));
            self.faults.push(fault.help(format!(
                "the state is in `{}`, so its rate must be in that unit per second; check the units of the parameters",
                unit.si
            )));
        }
        formula
    }
}
