//! Signals: laws that are written once under a name. For the name stands what it is given by, as if that were written there.

use super::Resolver;
use super::context::Context;
use super::names::Named;
use super::order::{Pending, sorted};
use super::parameters::{bare_factor, hertz};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::model::measure::ANYTHING;
use crate::model::{Discrete, Formula, Unit, Variable};
use crate::scene::dimension::KnownUnit;
use crate::scene::unit::from_exponents;
use crate::scene::{constant, model};

/// What the name of a signal stands for.
#[derive(Clone)]
pub(super) struct ResolvedSignal {
    pub formula: Formula,
    pub known: KnownUnit,
    /// What it is shown in.
    pub unit: Option<Unit>,
}

/// Longer or deeper laws with all that they use written out are refused: each signal may use others twice, and so on.
const LONGEST: usize = 100_000;
const DEEPEST: usize = 1000;

impl<'s> Resolver<'s> {
    /// Gives the names of the signals their meanings.
    pub(super) fn signals(&mut self, discrete: &mut Vec<Discrete>) {
        let scene = self.scene;
        let place = |named| if let Named::Signal(index) = named { Some(index) } else { None };
        let (pending, mut uses) = self.expressions(scene.signals.iter().map(|signal| &signal.value), place);
        for (index, signal) in scene.signals.iter().enumerate().filter(|(_, signal)| signal.part.is_some()) {
            uses.insert(index, self.awaited(signal));
        }
        let (order, circle) = sorted(&uses);
        self.signals = vec![None; scene.signals.len()];
        let others = (0..scene.signals.len()).filter(|index| !uses.contains_key(index));
        for index in others.chain(order) {
            self.signals[index] = {
                let signal = &scene.signals[index];
                self.within(signal.within, |resolver| match signal.part {
                    Some(_) => resolver.transfer(signal, discrete),
                    None => resolver.signal(signal, pending.get(&index)),
                })
            };
        }
        let signals = circle.iter().map(|&index| &scene.signals[index]);
        let place = |signal: &model::Signal| if signal.part.is_some() { signal.name.span } else { signal.value.span };
        let help = match signals.clone().any(|signal| signal.part.is_some()) {
            true => {
                "give a filter, delay or sampled controller among them its `unit`: it may then depend on its output"
            }
            false => "make one of them independent of the others",
        };
        let circle: Vec<_> = signals.map(|signal| (signal.name.text.as_str(), place(signal))).collect();
        self.refuse_circle(&circle, "signals", help);
        self.hear_of_all();
    }

    fn signal(&mut self, signal: &model::Signal, pending: Option<&Pending>) -> Option<ResolvedSignal> {
        let what = format!("signal `{}`", signal.name.text);
        let declared = self.unit(signal.unit.as_ref());
        let (formula, known) = match pending {
            Some(Pending { text, tree }) => {
                let (formula, known) = self.law_tree(tree, text, &what)?;
                let has_variables = !variables(&formula).is_empty();
                if !has_variables {
                    self.suspect_unit(&what, known.unit(), declared.as_ref(), text);
                }
                let number = constant::number(&formula);
                (number.map_or(formula, |number| self.finite(number, &what, text.span)), known)
            }
            None => {
                let (formula, formula_unit) = self.formula_and_unit(&signal.value, &what, &ANYTHING, Context::Output);
                let factor = bare_factor(declared.as_ref(), &signal.value);
                let hertz = hertz(formula_unit.as_ref(), Some(&signal.value), None);
                let known = formula_unit
                    .map_or(KnownUnit::Number, |unit| KnownUnit::constant(Some(unit.exponents)).in_hertz(hertz));
                (formula * Formula::Number(factor), known)
            }
        };
        if constant::number(&formula).is_some_and(f64::is_nan) {
            return None;
        }
        if is_too_long(&formula) {
            self.faults.push(too_long(&what, "signals", signal.value.span));
            return None;
        }
        let formula_unit = known.unit().map(from_exponents);
        if let (Some(declared), Some(formula_unit)) = (&declared, &formula_unit)
            && !declared.exponents.is_compatible(formula_unit.exponents)
        {
            self.declared_mismatch(&what, declared, formula_unit, signal.value.span);
        }
        let known = match &declared {
            Some(unit) => {
                KnownUnit::moving(Some(unit.exponents)).in_hertz(hertz(Some(unit), None, signal.unit.as_ref()))
            }
            None => known,
        };
        Some(ResolvedSignal { formula, known, unit: declared.or(formula_unit) })
    }
}

pub(super) fn is_too_long(formula: &Formula) -> bool {
    formula.operations() > LONGEST || formula.depth() > DEEPEST
}

pub(super) fn too_long(what: &str, others: &str, span: Span) -> Fault {
    let message = format!("the scene is too large: {what} is too long with the {others} that it uses");
    let fault = Fault::new("scene::too_large", message, span).label("too long when written out");
    fault.help(format!("use fewer of the other {others} in it"))
}

/// The variables of a formula.
pub(super) fn variables(formula: &Formula) -> Vec<Variable> {
    let mut found = Vec::new();
    formula.visit(&mut |part| {
        if let Formula::Variable(variable) = part {
            found.push(*variable);
        }
    });
    found
}
