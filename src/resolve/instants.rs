//! What changes at instants: sampled values and events.

use std::collections::HashMap;

use super::Resolver;
use super::context::Context;
use super::names::Named;
use super::parameters::{bare_factor, hertz};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::measure::{ANYTHING, TIME};
use crate::model::{Event, Formula, Held, HeldWhat, Input, InputId, LoadId, Owner, Range, Sampler, Unit};
use crate::scene::constant;
use crate::scene::dimension::KnownUnit;
use crate::scene::expression::comparison;
use crate::scene::model;
use crate::scene::quantity::{QuantityReading, Value, read};

/// What the next value of a sampled value is.
pub(super) type Next = Option<(Formula, KnownUnit)>;

/// Next values of sampled values, as far as they are known.
#[derive(Default)]
pub(super) struct Nexts {
    known: HashMap<InputId, Next>,
    /// Those that are being looked for, each for the one before it.
    pending: Vec<InputId>,
}

impl model::Scene {
    /// All sampled values, as the inputs that they are.
    pub(super) fn sampled_values(&self) -> impl Iterator<Item = (InputId, &model::SampledValue)> {
        let first = self.inputs.len();
        let values = self.sampled.iter().flat_map(|sampler| &sampler.values);
        values.enumerate().map(move |(index, value)| (InputId(first + index), value))
    }

    /// When an event happened last, as an input.
    fn time_of(&self, event: usize) -> InputId {
        InputId(self.inputs.len() + self.sampled_values().count() + event)
    }

    /// The name of a sampled value, or of an event's time.
    pub(super) fn held_name(&self, id: InputId) -> Option<String> {
        let event = id.0.checked_sub(self.time_of(0).0).and_then(|event| self.events.get(event));
        let sampled =
            self.sampled_values().find(|(candidate, _)| *candidate == id).map(|(_, value)| value.name.text.clone());
        sampled.or_else(|| event.map(|event| format!("events.{}.time", event.name.text)))
    }

    /// The event whose time is called so.
    pub(super) fn event_of_time(&self, name: &str) -> Option<(usize, InputId)> {
        let event = name.strip_prefix("events.")?.strip_suffix(".time")?;
        let place = self.events.iter().position(|candidate| candidate.name.text == event)?;
        Some((place, self.time_of(place)))
    }

    /// The input that says whether a load is there, if an event removes it.
    pub(super) fn presence(&self, load: LoadId) -> Option<InputId> {
        let place = self.removed().iter().position(|removed| *removed == load)?;
        Some(InputId(self.time_of(self.events.len()).0 + place))
    }

    /// The loads that events remove, each once.
    fn removed(&self) -> Vec<LoadId> {
        let names = self.events.iter().flat_map(|event| &event.remove);
        let place = |name: &Text| self.loads.iter().position(|load| load.name.text == name.text);
        let mut removed: Vec<LoadId> = names.filter_map(place).map(LoadId).collect();
        removed.sort_unstable();
        removed.dedup();
        removed
    }
}

impl Resolver<'_> {
    /// Adds the held values to the inputs, still without what they begin with; their units are known from here on.
    pub(super) fn declare_held(&mut self, inputs: &mut Vec<Input>) {
        let scene = self.scene;
        for sampler in &scene.sampled {
            for value in &sampler.values {
                let id = InputId(inputs.len());
                inputs.push(self.within(sampler.within, |resolver| resolver.declare_sampled(id, value)));
            }
        }
        for event in &scene.events {
            self.input_units.push(Some((crate::model::Exponents::SECOND, 0)));
            inputs.push(Input {
                name: format!("events.{}.time", event.name.text),
                description: format!("time of the last event `{}`; negative before the first", event.name.text),
                unit: Unit::time(),
                ..held_input(&event.name)
            });
        }
        for load in scene.removed() {
            let name = &scene.loads[load.0].name;
            self.input_units.push(None);
            let (description, start) = (format!("1 until load `{}` is removed", name.text), 1.0);
            inputs.push(Input { name: format!("{}.presence", name.text), description, start, ..held_input(name) });
        }
    }

    fn declare_sampled(&mut self, id: InputId, value: &model::SampledValue) -> Input {
        let declared = self.unit(value.unit.as_ref());
        // What moves is not known yet, and has no unit of its own.
        let measure = value.start.as_ref().filter(|start| match &start.value {
            Value::Number(_) => false,
            Value::Text(text) => !matches!(read(&Text::from(text.as_str())), Ok(QuantityReading::Expression) | Err(_)),
        });
        let measured = measure.and_then(|start| {
            let what = format!("`start` of sampled value `{}`", value.name.text);
            self.formula_and_unit(start, &what, &ANYTHING, Context::Constant).1
        });
        let unit = declared.or(measured);
        self.held_units.extend(unit.clone().map(|unit| (id, unit)));
        let hertz = hertz(unit.as_ref(), value.start.as_ref(), value.unit.as_ref());
        self.input_units.push(unit.as_ref().map(|unit| (unit.exponents, hertz)));
        let description = value.description.as_ref().map(|text| text.text.clone()).unwrap_or_default();
        Input { description, unit: unit.unwrap_or_default(), ..held_input(&value.name) }
    }

    /// What held values begin with, and the samplers.
    pub(super) fn held(&mut self, inputs: &mut [Input]) -> (Vec<Held>, Vec<Sampler>) {
        let scene = self.scene;
        let (mut held, mut samplers) = (Vec::new(), Vec::new());
        let mut ids = scene.sampled_values();
        for (place, sampler) in scene.sampled.iter().enumerate() {
            let input_ids: Vec<_> = ids.by_ref().take(sampler.values.len()).collect();
            let what = format!("`period` of sampler `{}`", sampler.name.text);
            let (period, offset) = self.within(sampler.within, |resolver| {
                let period = resolver.constant_in(Range::Positive, &sampler.period, &what, &TIME);
                let what = format!("`offset` of sampler `{}`", sampler.name.text);
                let offset = sampler.offset.as_ref().map(|offset| resolver.constant(offset, &what, &TIME));
                (period, offset.unwrap_or(Formula::Number(0.0)))
            });
            let mut writes = Vec::new();
            for (id, value) in input_ids {
                let begin = self.within(sampler.within, |resolver| resolver.begin(id, value));
                if let Formula::Number(start) = begin {
                    inputs[id.0].start = start;
                }
                held.push(Held { what: HeldWhat::Sampled, begin });
                if let Some((next, _)) = value.next.as_ref().and_then(|_| self.next(id, place)) {
                    writes.push((id, next));
                }
            }
            let name = sampler.name.text.clone();
            samplers.push(Sampler { name, period, offset, writes, span: sampler.name.span });
        }
        let before = crate::expr::Function::Two(crate::expr::Binary::Min);
        let never = Formula::Call(before, vec![Formula::Number(-1.0), Formula::Time + Formula::Number(-1.0)]);
        held.extend(scene.events.iter().map(|_| Held { what: HeldWhat::Time, begin: never.clone() }));
        let there = |load| Held { what: HeldWhat::Presence(load), begin: Formula::Number(1.0) };
        held.extend(scene.removed().into_iter().map(there));
        held.append(&mut self.transfers.held);
        samplers.append(&mut self.transfers.samplers);
        (held, samplers)
    }

    fn begin(&mut self, id: InputId, value: &model::SampledValue) -> Formula {
        let Some(start) = &value.start else { return Formula::Number(0.0) };
        let what = format!("`start` of sampled value `{}`", value.name.text);
        self.held_formula(start, id, &what, Context::Start).0
    }

    /// What a sampled value gets at a tick of its sampler.
    pub(super) fn next(&mut self, id: InputId, sampler: usize) -> Next {
        if let Some(known) = self.nexts.known.get(&id) {
            return known.clone();
        }
        let scene = self.scene;
        let (_, value) = scene.sampled_values().find(|(candidate, _)| *candidate == id)?;
        let Some(next) = &value.next else {
            let unit = self.input_units[id.0].map(|(exponents, _)| exponents);
            return Some((Formula::Input(id), KnownUnit::moving(unit)));
        };
        if let Some(first) = self.nexts.pending.iter().position(|candidate| *candidate == id) {
            self.refuse_circle_of_news(first);
            return None;
        }
        self.nexts.pending.push(id);
        let found = self.within(scene.sampled[sampler].within, |resolver| {
            let what = format!("`next` of sampled value `{}`", value.name.text);
            resolver.held_formula(next, id, &what, Context::Instant(Some(sampler)))
        });
        self.nexts.pending.pop();
        // What it cannot be found from has its fault already.
        let found = Some(found).filter(|(formula, _)| !constant::number(formula).is_some_and(f64::is_nan));
        self.nexts.known.insert(id, found.clone());
        found
    }

    /// The fault of sampled values whose new values depend on each other.
    fn refuse_circle_of_news(&mut self, first: usize) {
        let scene = self.scene;
        let value =
            |id: &InputId| scene.sampled_values().find(|(candidate, _)| candidate == id).map(|(_, value)| value);
        let place = |sampled: &model::SampledValue| sampled.next.as_ref().map_or(sampled.name.span, |next| next.span);
        let pending = self.nexts.pending[first..].iter().chain([&self.nexts.pending[first]]);
        let circle: Vec<_> =
            pending.filter_map(value).map(|sampled| (sampled.name.text.as_str(), place(sampled))).collect();
        let help = "use the previous value in one of them: `x` instead of `new(x)`";
        self.refuse_circle(&circle, "new values of sampled values", help);
    }

    /// What a held value becomes: a bare number is in its unit, an expression must have it.
    fn held_formula(
        &mut self,
        quantity: &crate::scene::quantity::Quantity,
        id: InputId,
        what: &str,
        context: Context,
    ) -> (Formula, KnownUnit) {
        let (formula, unit, known) = self.formula_and_known(quantity, what, &ANYTHING, context);
        let declared = self.held_units.get(&id).cloned();
        self.must_agree(what, declared.as_ref(), unit.as_ref().filter(|_| known != KnownUnit::Number), quantity.span);
        let factor = bare_factor(declared.as_ref(), quantity);
        let known = declared.map_or(known, |unit| KnownUnit::moving(Some(unit.exponents)));
        (formula * Formula::Number(factor), known)
    }

    /// What `new(x)` stands for.
    pub(super) fn new_value(&mut self, name: &Text, sampler: Option<usize>, what: &str) -> Next {
        let variable = match self.names.get(&name.text) {
            Some(Named::Held(id)) => Some(id),
            _ => None,
        };
        let scene = self.scene;
        let values = sampler.map(|sampler| &scene.sampled[sampler].values[..]).unwrap_or_default();
        let is_here = values.iter().any(|value| value.name.text == name.text);
        if let (Some(id), Some(sampler), true) = (variable, sampler, is_here) {
            self.used_inputs.insert(id);
            return self.next(id, sampler);
        }
        if !self.is_reported(name, &name.text) {
            let names = values.iter().map(|value| value.name.text.as_str());
            let help = match values.is_empty() {
                true => "`new(x)` is permitted in `next` only".to_owned(),
                false => format!("the values of this sampler are {}", suggest::list(names)),
            };
            let message = format!("{what} uses `new({})`, but that is not a value of the same sampler", name.text);
            self.faults
                .push(Fault::new("scene::unknown_name", message, name.span).label("not sampled here").help(help));
        }
        None
    }

    pub(super) fn events(&mut self) -> Vec<Event> {
        let scene = self.scene;
        let mut events = Vec::new();
        for (place, event) in scene.events.iter().enumerate() {
            events.extend(self.within(event.within, |resolver| resolver.event(place, event)));
        }
        events
    }

    fn event(&mut self, place: usize, event: &model::Event) -> Option<Event> {
        let scene = self.scene;
        let what = format!("event `{}`", event.name.text);
        if event.remove.is_empty() && event.set.is_empty() && !event.stop {
            self.nothing_happens(event, &what);
        }
        let mut writes = vec![(scene.time_of(place), Formula::Time)];
        for (name, value) in &event.set {
            writes.extend(self.set(name, value, &what));
        }
        let mut removes = Vec::new();
        for name in &event.remove {
            match self.removed(name, &what) {
                Some(Owner::Load(load)) => {
                    writes.extend(scene.presence(load).map(|presence| (presence, Formula::Number(0.0))));
                }
                Some(owner) => removes.push(owner),
                None => {}
            }
        }
        let (comparison, sides) = self.sides(&event.when, &format!("`when` of {what}"))?;
        Some(Event {
            name: event.name.text.clone(),
            description: event.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
            comparison,
            sides,
            writes,
            removes,
            once: event.once,
            stop: event.stop,
            span: event.name.span,
        })
    }

    fn sides(&mut self, when: &Text, what: &str) -> Option<(crate::model::Comparison, [Formula; 2])> {
        let (comparison, trees) = match comparison(when) {
            Ok(found) => found,
            Err(fault) => {
                self.faults.push(fault);
                return None;
            }
        };
        let [left, right] = trees.map(|tree| self.instant_tree(&tree, when, what));
        let ((left, first), (right, second)) = (left?, right?);
        self.must_compare(first, second, when, what);
        Some((comparison, [left, right]))
    }

    fn nothing_happens(&mut self, event: &model::Event, what: &str) {
        let fault = Fault::new("scene::missing_key", format!("{what} has no effect"), event.name.span);
        let help = "give its effect: `remove = [\"spring\"]`, `set = { x = 0 }` or `stop = true`";
        self.faults.push(fault.label("has neither `remove` nor `set` nor `stop`").help(help));
    }

    fn set(&mut self, name: &Text, value: &crate::scene::quantity::Quantity, what: &str) -> Option<(InputId, Formula)> {
        let scene = self.scene;
        let Some(Named::Held(id)) = self.names.get(&name.text) else {
            if !self.is_reported(name, &name.text) {
                let names = scene.sampled_values().map(|(_, value)| value.name.text.as_str());
                let known: Vec<&str> = names.collect();
                let otherwise = match known.is_empty() {
                    true => "the scene has none: define it under `[sampled]`".to_owned(),
                    false => format!("they are {}", suggest::list(known.iter().copied())),
                };
                let message = format!("{what} sets `{}`, which is not a sampled value", name.text);
                let fault = Fault::new("scene::unknown_name", message, name.span).label("not a sampled value");
                self.faults.push(fault.help(suggest::hint(&name.text, known, otherwise)));
            }
            return None;
        };
        let what = format!("`set.{}` of {what}", name.text);
        Some((id, self.held_formula(value, id, &what, Context::Instant(None)).0))
    }

    /// The joint, driver or load with that name, if it can be removed.
    fn removed(&mut self, name: &Text, what: &str) -> Option<Owner> {
        let scene = self.scene;
        match self.names.get(&name.text) {
            Some(Named::Load(load)) => return Some(Owner::Load(load)),
            Some(Named::Driver(driver)) => return Some(Owner::Driver(driver)),
            Some(Named::Joint(joint)) => return Some(Owner::Joint(joint)),
            Some(
                Named::Body(_)
                | Named::Parameter(_)
                | Named::Input(_)
                | Named::State(_)
                | Named::Held(_)
                | Named::Signal(_),
            )
            | None => {}
        }
        if !self.is_reported(name, &name.text) {
            let message = match self.names.get(&name.text) {
                Some(named) => {
                    let word = named.word();
                    format!(
                        "{what} removes the {word} `{}`, but only joints, drivers and loads can be removed",
                        name.text
                    )
                }
                None => format!("{what} removes `{}`, which is not in the scene", name.text),
            };
            let parts = scene.joints.iter().chain(&scene.drivers).chain(&scene.loads);
            let names: Vec<&str> = parts.map(|part| part.name.text.as_str()).collect();
            let otherwise = match names.is_empty() {
                true => "there is nothing to remove".to_owned(),
                false => format!("there are {}", suggest::list(names.iter().copied())),
            };
            let fault = Fault::new("scene::unknown_name", message, name.span).label("cannot be removed");
            self.faults.push(fault.help(suggest::hint(&name.text, names, otherwise)));
        }
        None
    }
}

fn held_input(name: &Text) -> Input {
    Input {
        name: name.text.clone(),
        description: String::new(),
        unit: Unit::default(),
        start: 0.0,
        min: None,
        max: None,
        span: name.span,
    }
}
