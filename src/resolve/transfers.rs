//! Signals with a type: controllers, filters, delays. Their keys become states or sampled values, and a law of these.

use std::collections::{BTreeSet, HashMap};

use super::context::Context;
use super::formulas::ReadFormula;
use super::names::Named;
use super::parameters::bare_factor;
use super::signals::ResolvedSignal;
use super::{Resolver, UNKNOWN};
use crate::component::transfer::{ALL, Flaw, Inner, Like, NOMINAL, Transfer, TransferKeys, TransferParts};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::expr::Binary;
use crate::model::measure::{ANYTHING, TIME};
use crate::model::{Discrete, DiscreteId, DiscreteKind, Exponents, Formula, Range, Sampler, State, StateId, Unit};
use crate::scene::decode::Fields;
use crate::scene::dimension::{self, KnownUnit};
use crate::scene::key::{Form, Key, Need};
use crate::scene::unit::from_exponents;
use crate::scene::{constant, model, part};

/// The states and sampled values of all signals with a type.
#[derive(Default)]
pub(super) struct Transfers<'s> {
    /// Behind those of the scene.
    pub states: Vec<State>,
    pub samplers: Vec<Sampler>,
    /// What its states and sampled values are called.
    pub inner: HashMap<String, Named>,
    /// Signals that may depend on themselves.
    waiting: Vec<TransferReading<'s>>,
}

/// A signal whose constant keys are known.
struct TransferReading<'s> {
    signal: &'s model::Signal,
    transfer: &'static Transfer,
    fields: Fields<'s>,
    /// "pid `opening`"
    what: String,
    values: Vec<(&'static str, Formula)>,
    /// The units of these values, and where they are written.
    units: Vec<(&'static str, KnownUnit, Span)>,
    declared: Option<Unit>,
    /// Its first state and its first sampled value.
    first: (usize, usize),
}

impl part::Part {
    /// What kind of signal it is.
    pub(crate) fn transfer(&self) -> Option<&'static Transfer> {
        let kind = self.text("type")?;
        ALL.iter().copied().find(|transfer| transfer.name == kind.text)
    }
}

impl TransferReading<'_> {
    fn is_there(&self, key: &str) -> bool {
        self.fields.get(key).is_some()
    }

    fn is_sampled(&self) -> bool {
        self.transfer.sampled_by.is_some_and(|key| self.is_there(key))
    }

    fn is_at_once(&self) -> bool {
        self.transfer.sampled_by.is_some() && !self.is_sampled()
    }

    fn made(&self, heard: Formula) -> Result<TransferParts, Flaw> {
        (self.transfer.made)(&TransferKeys { heard, values: &self.values, first: self.first })
    }
}

impl<'s> Resolver<'s> {
    /// The signals that one with a type must know before it is known itself: those that it hears, unless its own unit is given and it gives nothing at once.
    pub(super) fn awaited(&self, signal: &model::Signal) -> BTreeSet<usize> {
        let transfer = signal.part.as_ref().and_then(|part| part.transfer());
        let Some((part, transfer)) = signal.part.as_ref().zip(transfer) else { return BTreeSet::new() };
        if signal.unit.is_some() && transfer.sampled_by.is_none_or(|key| part.get(key).is_some()) {
            return BTreeSet::new();
        }
        part.text(transfer.hears.name).map(|text| self.signals_in(&text)).unwrap_or_default()
    }

    /// What a signal with a type gives.
    pub(super) fn transfer(
        &mut self,
        signal: &'s model::Signal,
        discrete: &mut Vec<Discrete>,
    ) -> Option<ResolvedSignal> {
        let reading = self.constant_keys(signal, discrete)?;
        let waits = reading.declared.is_some() && !reading.is_at_once();
        let (heard, known) = if waits { (UNKNOWN, KnownUnit::Nothing) } else { self.hear(&reading)? };
        let unit = self.unit_given(&reading, known, waits)?;
        let made = match reading.made(heard) {
            Ok(made) => made,
            Err(flaw) => {
                self.refuse_flaw(&reading, flaw);
                return None;
            }
        };
        self.keep_positive(&reading, &made);
        self.declare(&reading, &made, (unit, known), discrete);
        if waits {
            self.transfers.waiting.push(reading);
        }
        let known = unit.map_or(KnownUnit::Nothing, |unit| KnownUnit::moving(Some(unit)));
        let shown = signal.unit.as_ref().and_then(|text| self.unit(Some(text)));
        Some(ResolvedSignal { formula: made.output, known, unit: shown.or(unit.map(from_exponents)) })
    }

    /// Resolves the inputs of the signals that give their unit, which may depend on their own output: by now every name is known.
    pub(super) fn hear_of_all(&mut self) {
        for reading in std::mem::take(&mut self.transfers.waiting) {
            self.within(reading.signal.within, |resolver| resolver.hear_late(&reading));
        }
    }

    fn hear_late(&mut self, reading: &TransferReading<'s>) -> Option<()> {
        let (heard, known) = self.hear(reading)?;
        self.unit_given(reading, known, false)?;
        let made = reading.made(heard).ok()?;
        let states = &mut self.transfers.states[reading.first.0 - self.scene.states.len()..];
        states.iter_mut().zip(&made.states).for_each(|(state, inner)| state.rate = inner.next.clone());
        let sampler = self.transfers.samplers.iter_mut().find(|sampler| sampler.name == reading.signal.name.text);
        if let Some(sampler) = sampler {
            sampler.writes = writes(reading, &made);
        }
        Some(())
    }

    fn constant_keys(&mut self, signal: &'s model::Signal, discrete: &[Discrete]) -> Option<TransferReading<'s>> {
        let part = signal.part.as_ref()?;
        let Some(transfer) = part.transfer() else {
            self.unknown_transfer(signal, part);
            return None;
        };
        let what = format!("{} `{}`", transfer.name, signal.name.text);
        let keys = transfer.all_keys();
        let names: Vec<&str> = std::iter::once("type").chain(keys.iter().map(|key| key.name)).collect();
        let fields = Fields::open(&part.node, &what, signal.name.span, &names, self.faults)?;
        let declared = self.unit(signal.unit.as_ref());
        let first = (self.scene.states.len() + self.transfers.states.len(), discrete.len());
        let (values, units) = (Vec::new(), Vec::new());
        let mut reading = TransferReading { signal, transfer, fields, what, values, units, declared, first };
        self.one_of_these(&reading)?;
        let mut complete = true;
        for key in transfer.keys.iter().chain([&NOMINAL]) {
            complete &= self.constant_key(key, &mut reading).is_some();
        }
        complete.then_some(reading)
    }

    fn unknown_transfer(&mut self, signal: &model::Signal, part: &part::Part) {
        let kind = part.get("type");
        let names = || ALL.iter().map(|transfer| transfer.name);
        let known = suggest::list(names());
        let owner = format!("signal `{}`", signal.name.text);
        let Some(text) = kind.and_then(|kind| self.faults.text(kind, &format!("`type` of {owner}"))) else { return };
        let message = format!("{owner} has an unknown type: `{}`", text.text);
        let help = suggest::hint(&text.text, names(), format!("the types of signals are {known}"));
        self.faults.push(Fault::new("scene::unknown_type", message, text.span).label("no such type").help(help));
    }

    /// Exactly one of the keys that stand for one another must be there.
    fn one_of_these(&mut self, reading: &TransferReading<'_>) -> Option<()> {
        let alternatives = || reading.transfer.keys.iter().filter(|key| matches!(key.need, Need::OneOf(_)));
        let given: Vec<&Key> = alternatives().filter(|key| reading.is_there(key.name)).collect();
        if alternatives().count() == 0 || given.len() == 1 {
            return Some(());
        }
        let names: Vec<String> = alternatives().map(|key| format!("`{}`", key.name)).collect();
        let names = names.join(" or ");
        let found = if given.is_empty() { "neither" } else { "both" };
        let problem = format!("has {found} of {names}");
        let helps: Vec<String> = alternatives().map(|key| format!("`{}`: {}", key.name, key.about)).collect();
        let key = given.get(1).map_or("", |key| key.name);
        self.refuse_keys(reading, key, &problem, &helps.join(", "));
        None
    }

    fn refuse_flaw(&mut self, reading: &TransferReading<'_>, flaw: Flaw) {
        self.refuse_keys(reading, flaw.key, &flaw.problem, flaw.help);
    }

    fn refuse_keys(&mut self, reading: &TransferReading<'_>, key: &str, problem: &str, help: &str) {
        let span = reading.fields.key_span(key).unwrap_or(reading.signal.name.span);
        let fault = Fault::new("scene::signal_keys", format!("{} {problem}", reading.what), span);
        self.faults.push(fault.label("cannot be combined").help(help));
    }

    /// Reads a key whose value does not change, if it is there.
    fn constant_key(&mut self, key: &'static Key, reading: &mut TransferReading<'_>) -> Option<()> {
        let node = match key.need {
            Need::Required(help) => Some(reading.fields.required(key.name, help, self.faults)?),
            _ => reading.fields.get(key.name),
        };
        let (Some(node), Form::Constant(wanted, range)) = (node, key.form) else { return Some(()) };
        let quantity = self.faults.quantity(node, &reading.fields.name_of(key.name))?;
        let what = format!("`{}` of {}", key.name, reading.what);
        let ReadFormula { formula, known, .. } = self.formula_and_known(&quantity, &what, &wanted, Context::Constant);
        // A bare value is in the unit of the signal; a gain, and what is no value of the signal, is in SI.
        let in_unit = reading.transfer.terms.contains(&(key.name, Like::Given)) || key.name == NOMINAL.name;
        let factor = bare_factor(reading.declared.as_ref().filter(|_| in_unit), &quantity);
        let formula = self.check_finite(formula * Formula::Number(factor), &quantity, &what);
        let formula = self.keep_in(range, formula, &quantity, &what, &wanted);
        if constant::number(&formula).is_some_and(f64::is_nan) {
            return None;
        }
        reading.values.push((key.name, formula));
        reading.units.push((key.name, known, quantity.span));
        Some(())
    }

    /// What it hears: in a state as in any rate, at a tick everything.
    fn hear(&mut self, reading: &TransferReading<'s>) -> Option<(Formula, KnownUnit)> {
        let key = &reading.transfer.hears;
        let node = reading.fields.required(key.name, key.help(), self.faults)?;
        let quantity = self.faults.quantity(node, &reading.fields.name_of(key.name))?;
        let what = format!("`{}` of {}", key.name, reading.what);
        let context = if reading.is_sampled() { Context::Instant(None) } else { Context::Rate };
        let ReadFormula { formula, known, .. } = self.formula_and_known(&quantity, &what, &ANYTHING, context);
        (!constant::number(&formula).is_some_and(f64::is_nan)).then_some((formula, known))
    }

    /// The unit of what it gives, if it is known; none if its keys contradict each other.
    fn unit_given(
        &mut self,
        reading: &TransferReading<'_>,
        heard: KnownUnit,
        waits: bool,
    ) -> Option<Option<Exponents>> {
        let mut known = match &reading.declared {
            Some(unit) => KnownUnit::moving(Some(unit.exponents)),
            None => KnownUnit::Number,
        };
        for &(key, like) in reading.transfer.terms {
            let span = reading.fields.key_span(key);
            let unit = match reading.units.iter().find(|(candidate, ..)| *candidate == key) {
                Some((_, unit, _)) => *unit,
                None if key == reading.transfer.hears.name => heard,
                None => continue,
            };
            let (term, other) = match like {
                Like::Gain(_) | Like::Heard if waits => continue,
                Like::Given | Like::Rate => (unit, known),
                Like::Heard => (unit, heard),
                Like::Gain(seconds) => (gained(unit, heard, seconds), known),
            };
            match dimension::join(other, term) {
                Ok(joined) if like != Like::Heard => known = joined,
                Ok(_) => {}
                Err((wanted, found)) => {
                    self.refuse_unit(reading, (key, span.unwrap_or(reading.signal.name.span)), [wanted, found]);
                    return None;
                }
            }
        }
        Some(known.unit())
    }

    fn refuse_unit(&mut self, reading: &TransferReading<'_>, (key, span): (&str, Span), units: [Exponents; 2]) {
        let [wanted, found] = units.map(|unit| match from_exponents(unit).si {
            si if si.is_empty() => "a pure number".to_owned(),
            si => format!("in `{si}`"),
        });
        let message = format!(
            "`{key}` of {} gives an output that is {found}, but its other keys give one that is {wanted}",
            reading.what
        );
        let fault = Fault::new("scene::wrong_unit", message, span).label(format!("not {wanted}"));
        let help = "`proportional` must have the unit of the output per unit of the error, `integral` the same per second, `derivative` the same times second";
        self.faults.push(fault.help(help));
    }

    fn keep_positive(&mut self, reading: &TransferReading<'_>, made: &TransferParts) {
        for (called, key, value) in &made.positive {
            let Some(node) = reading.fields.get(key) else { continue };
            let Some(quantity) = self.faults.quantity(node, &reading.fields.name_of(key)) else { continue };
            let what = format!("{called} of {}", reading.what);
            self.keep_in(Range::Positive, value.clone(), &quantity, &what, &ANYTHING);
        }
    }

    /// Adds its states, its sampled values and its sampler.
    fn declare(
        &mut self,
        reading: &TransferReading<'_>,
        made: &TransferParts,
        (given, heard): (Option<Exponents>, KnownUnit),
        discrete: &mut Vec<Discrete>,
    ) {
        let unit = |inner: &Inner| match inner.unit {
            Like::Given | Like::Gain(_) => given,
            Like::Rate => given.and_then(|unit| Exponents::product([(unit, 1), (Exponents::SECOND, -1)])),
            Like::Heard => heard.unit(),
        };
        let nominal = self.usual_size(reading, made);
        for inner in &made.states {
            let size = if inner.unit == Like::Given { nominal } else { 1.0 };
            self.add_state(reading, inner, unit(inner), size);
        }
        for inner in &made.sampled {
            self.add_sampled(reading, inner, unit(inner), discrete);
        }
        if let Some([period, offset]) = made.ticks.clone() {
            let name = &reading.signal.name;
            let writes = writes(reading, made);
            self.transfers.samplers.push(Sampler { name: name.text.clone(), period, offset, writes, span: name.span });
        }
    }

    fn add_state(&mut self, reading: &TransferReading<'_>, inner: &Inner, unit: Option<Exponents>, nominal: f64) {
        let signal = &reading.signal.name;
        let name = inner.name(&signal.text);
        let id = StateId(self.scene.states.len() + self.transfers.states.len());
        self.transfers.inner.insert(name.clone(), Named::State(id));
        self.state_units.push(unit.map(|unit| (unit, 0)));
        self.transfers.states.push(State {
            name,
            description: inner.description(&signal.text),
            unit: unit.map(from_exponents).unwrap_or_default(),
            start: inner.start.clone(),
            rate: inner.next.clone(),
            nominal,
            variable: None,
            span: signal.span,
        });
    }

    fn add_sampled(
        &mut self,
        reading: &TransferReading<'_>,
        inner: &Inner,
        unit: Option<Exponents>,
        discrete: &mut Vec<Discrete>,
    ) {
        let signal = &reading.signal.name;
        let name = inner.name(&signal.text);
        self.transfers.inner.insert(name.clone(), Named::Sampled(DiscreteId(discrete.len())));
        self.discrete_units.push(unit.map(|unit| (unit, 0)));
        discrete.push(Discrete {
            name,
            description: inner.description(&signal.text),
            unit: unit.map(from_exponents).unwrap_or_default(),
            kind: DiscreteKind::Sampled,
            begin: inner.start.clone(),
            span: signal.span,
        });
    }

    fn usual_size(&self, reading: &TransferReading<'_>, made: &TransferParts) -> f64 {
        let value =
            |key: &str| reading.values.iter().find(|(candidate, _)| *candidate == key).map(|(_, value)| value.clone());
        let sizes = [value(NOMINAL.name), made.size.clone(), value("start")];
        let sizes = sizes.into_iter().flatten().map(|size| self.value(&size).abs());
        sizes.into_iter().find(|size| *size > 0.0 && size.is_finite()).unwrap_or(1.0)
    }

    /// The name of a state of the scene or of a signal.
    pub(super) fn state_name(&self, id: StateId) -> String {
        let count = self.scene.states.len();
        match self.scene.states.get(id.0) {
            Some(state) => state.name.text.clone(),
            None => self.transfers.states[id.0 - count].name.clone(),
        }
    }

    /// The name of a discrete variable of the scene or of a signal.
    pub(super) fn name_of_discrete(&self, id: DiscreteId) -> Option<String> {
        let inner = || self.transfers.inner.iter().find(|(_, named)| **named == Named::Sampled(id));
        self.scene.name_of_discrete(id).or_else(|| inner().map(|(name, _)| name.clone()))
    }

    /// What a name stands for, be it a state of a signal.
    pub(super) fn named(&self, name: &str) -> Option<Named> {
        self.names.get(name).or_else(|| self.transfers.inner.get(name).copied())
    }

    /// What is said of a signal that has no description.
    pub(super) fn wording_of_signal(signal: &model::Signal) -> String {
        let Some((part, transfer)) = signal.part.as_ref().and_then(|part| Some((part, part.transfer()?))) else {
            return Resolver::wording(&signal.value);
        };
        let heard: Option<Text> = part.text(transfer.hears.name);
        format!("{} of {}", transfer.name, heard.map(|text| text.text).unwrap_or_default())
    }
}

fn writes(reading: &TransferReading<'_>, made: &TransferParts) -> Vec<(DiscreteId, Formula)> {
    let place = |(index, inner): (usize, &Inner)| (DiscreteId(reading.first.1 + index), inner.next.clone());
    made.sampled.iter().enumerate().map(place).collect()
}

/// The unit of a gain times what is heard and so many times the second.
fn gained(gain: KnownUnit, heard: KnownUnit, seconds: i8) -> KnownUnit {
    let product = dimension::multiply(Binary::Multiply, gain, heard, &UNKNOWN);
    let second = KnownUnit::constant(TIME.exponents);
    match seconds {
        0 => product,
        1 => dimension::multiply(Binary::Multiply, product, second, &UNKNOWN),
        _ => dimension::multiply(Binary::Divide, product, second, &UNKNOWN),
    }
}
