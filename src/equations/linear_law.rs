//! Stiffness, damping and rest of a load, read off its law: a component gives its law once, and no second statement about it can disagree with the first.
//!
//! A law is linear only if it is built so ([`Arena::is_affine`]), and only if the form that replaces it has the law's value at random lengths and rates. Any other law keeps its exact form.

use cotree_fmu::math::Random;

use super::Equations;
use crate::expr::{Arena, Expr, Order, Symbol};
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
            (true, false) => match self.confirmed_linear(&law) {
                Some(LinearLaw { rest: Expr::ZERO, .. }) => OwnLaw::Centred,
                Some(_) => OwnLaw::Linear,
                None => OwnLaw::Nonlinear,
            },
        }
    }

    /// The linear form of a law, in an arena of its own; none if the law is not built so or differs from it anywhere.
    fn confirmed_linear(&self, law: &Formula) -> Option<LinearLaw> {
        let mut arena = Arena::default();
        let form = linear(&mut arena, law)?;
        agrees(&mut arena, law, form, &self.system.mechanism.parameter_values()).then_some(form)
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

/// What stands for the length of a load, and for its rate, in an arena where no coordinate occurs.
const LENGTH: Symbol = Symbol::Coordinate(0, Order::Position);
const RATE: Symbol = Symbol::Coordinate(0, Order::Velocity);

/// A law of its own length and rate, as an expression of these.
fn of_both(arena: &mut Arena, law: &Formula) -> Expr {
    translate(arena, law, &mut |arena, variable| match variable.quantity {
        Quantity::Rate => arena.symbol(RATE),
        _ => arena.symbol(LENGTH),
    })
}

fn is_built_linear(law: &Formula) -> bool {
    let mut arena = Arena::default();
    let force = of_both(&mut arena, law);
    arena.is_affine(&[force], |symbol| [LENGTH, RATE].contains(&symbol))
}

/// The linear form of a law of its own length and rate, if it is built so.
fn linear(arena: &mut Arena, law: &Formula) -> Option<LinearLaw> {
    if !is_built_linear(law) {
        return None;
    }
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
    let [(rest, _), (_, by_length), (_, by_rate)] =
        [(zero, zero), (None, zero), (zero, None)].map(|(length, rate)| at(length, rate));
    Some(LinearLaw { stiffness: arena.negate(by_length), damping: arena.negate(by_rate), rest })
}

/// True if a law has the value of its linear form at random lengths, rates, times and inputs, for the parameters of the scene?
fn agrees(arena: &mut Arena, law: &Formula, form: LinearLaw, parameters: &[f64]) -> bool {
    /// How often they are compared: rates and lengths are of both signs, from thousandths to thousands.
    const PLACES: u64 = 16;
    /// What rounding may leave of the largest term.
    const ROUNDING: f64 = 1e-9;
    let force = of_both(arena, law);
    let [length, rate] = [LENGTH, RATE].map(|symbol| arena.symbol(symbol));
    let (elastic, viscous) = (arena.multiply(form.stiffness, length), arena.multiply(form.damping, rate));
    (0..PLACES).all(|place| {
        let values = |symbol: Symbol| match symbol {
            Symbol::Parameter(index) => parameters[index],
            other => random_value(place, other),
        };
        let found = arena.evaluate(&[force, form.rest, elastic, viscous], &values);
        let [force, rest, elastic, viscous] = found[..] else { return false };
        let size = [force, rest, elastic, viscous].into_iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        // A law without a value has none in either form.
        let difference = force - (rest - elastic - viscous);
        difference.abs() <= ROUNDING * size || (force.is_nan() && difference.is_nan())
    })
}

/// A value of either sign between a thousandth and a thousand, the same for a symbol whenever it is asked for.
fn random_value(place: u64, symbol: Symbol) -> f64 {
    let seed = match symbol {
        LENGTH => 1,
        RATE => 2,
        Symbol::Input(index, _) => 4 + 4 * index as u64,
        Symbol::Discrete(index) => 5 + 4 * index as u64,
        Symbol::State(index, _) => 6 + 4 * index as u64,
        _ => 3,
    };
    let mut random = Random::new(place << 32 | seed);
    let size = 1e3_f64.powf(random.symmetric());
    size.copysign(random.symmetric())
}
