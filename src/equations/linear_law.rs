//! Stiffness, damping and rest of a load, read off its law: a component gives its law once, and no second statement about it can disagree with the first.

use super::Equations;
use crate::expr::{Arena, Expr, Symbol};
use crate::model::translate::translate;
use crate::model::{Formula, LoadId, Owner, Quantity, Variable};

/// F = rest - stiffness x - damping x', with x the length of the load (on a line the displacement between its ends).
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearLaw {
    pub stiffness: Expr,
    pub damping: Expr,
    /// The force at length and rate zero.
    pub rest: Expr,
}

/// What a law is, seen from the length and the rate of its load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OwnLaw {
    /// It reads neither, or there is no such law.
    Outer,
    /// Without force at length and rate zero.
    Centred,
    Linear,
    Nonlinear,
}

impl Equations {
    /// What the law of a load is. Nothing is added to the expressions of the mechanism.
    pub(super) fn own_law(&mut self, load: LoadId) -> OwnLaw {
        let Some(law) = self.system.mechanism.loads[load.0].law() else { return OwnLaw::Outer };
        let (mut own, mut other) = (false, false);
        law.visit(&mut |part| match part {
            Formula::Variable(variable) if is_own(*variable, load) => own = true,
            Formula::Variable(_) => other = true,
            _ => {}
        });
        match (own, other) {
            (false, _) => OwnLaw::Outer,
            (true, true) => OwnLaw::Nonlinear,
            (true, false) => match linear(&mut Arena::default(), &law) {
                Some(LinearLaw { rest: Expr::ZERO, .. }) => OwnLaw::Centred,
                Some(_) => OwnLaw::Linear,
                None => OwnLaw::Nonlinear,
            },
        }
    }

    /// Stiffness, damping and rest of a load whose law is [`OwnLaw::Linear`] or [`OwnLaw::Centred`].
    pub(super) fn linear_law(&mut self, load: LoadId) -> Option<LinearLaw> {
        let law = self.system.mechanism.loads[load.0].law()?;
        linear(&mut self.system.arena, &law)
    }
}

fn is_own(variable: Variable, load: LoadId) -> bool {
    variable.owner == Owner::Load(load) && matches!(variable.quantity, Quantity::Length | Quantity::Rate)
}

/// A law of its own length and rate is linear if its derivatives depend on neither.
fn linear(arena: &mut Arena, law: &Formula) -> Option<LinearLaw> {
    let mut at = |length: Option<Expr>, rate: Option<Expr>| {
        let argument = arena.symbol(Symbol::Argument);
        let [length, rate] = [length, rate].map(|value| value.unwrap_or(argument));
        let force = translate(arena, law, &mut |_, variable| match variable.quantity {
            Quantity::Rate => rate,
            _ => length,
        });
        (force, arena.derivative(force, Symbol::Argument))
    };
    let zero = Some(Expr::ZERO);
    let (rest, _) = at(zero, zero);
    let [(_, by_length), (_, while_moving), (_, by_rate)] =
        [(None, zero), (None, Some(Expr::ONE)), (zero, None)].map(|(length, rate)| at(length, rate));
    let is_constant = !arena.symbols([by_length, by_rate]).contains(&Symbol::Argument);
    (is_constant && by_length == while_moving).then(|| LinearLaw {
        stiffness: arena.negate(by_length),
        damping: arena.negate(by_rate),
        rest,
    })
}
