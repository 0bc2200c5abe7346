//! What changes at instants: sampled values and events.

use std::collections::{HashMap, HashSet};

use super::Resolver;
use super::context::Context;
use super::formulas::ReadFormula;
use super::names::Named;
use super::parameters::{bare_factor, hertz};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::measure::{ANYTHING, TIME};
use crate::model::{
    Discrete, DiscreteId, DiscreteKind, DriverId, Event, Formula, JointId, LoadId, Owner, Range, Sampler, StateId, Unit,
};
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
    known: HashMap<DiscreteId, Next>,
    /// Those that are being looked for, each for the one before it.
    pending: Vec<DiscreteId>,
}

impl model::Scene {
    /// All sampled values, as the discrete variables that they are.
    pub(super) fn sampled_values(&self) -> impl Iterator<Item = (DiscreteId, &model::SampledValue)> {
        let values = self.sampled.iter().flat_map(|sampler| &sampler.values);
        values.enumerate().map(|(index, value)| (DiscreteId(index), value))
    }

    /// When an event happened last.
    fn time_of(&self, event: usize) -> DiscreteId {
        DiscreteId(self.sampled_values().count() + event)
    }

    /// The name of a sampled value, or of an event's time.
    pub(super) fn name_of_discrete(&self, id: DiscreteId) -> Option<String> {
        let event = id.0.checked_sub(self.time_of(0).0).and_then(|event| self.events.get(event));
        let sampled =
            self.sampled_values().find(|(candidate, _)| *candidate == id).map(|(_, value)| value.name.text.clone());
        sampled.or_else(|| event.map(|event| format!("events.{}.time", event.name.text)))
    }

    /// The event whose time is called so.
    pub(super) fn event_of_time(&self, name: &str) -> Option<(usize, DiscreteId)> {
        let event = name.strip_prefix("events.")?.strip_suffix(".time")?;
        let place = self.events.iter().position(|candidate| candidate.name.text == event)?;
        Some((place, self.time_of(place)))
    }

    /// The variable that says whether a part is there, if an event removes, engages or releases it.
    pub(super) fn presence(&self, owner: Owner) -> Option<DiscreteId> {
        let place = self.removed().iter().position(|(removed, _)| *removed == owner)?;
        Some(DiscreteId(self.time_of(self.events.len()).0 + place))
    }

    /// The parts that events remove, engage or release, each once, with their names.
    fn removed(&self) -> Vec<(Owner, &Text)> {
        let names: HashSet<&str> =
            self.events.iter().flat_map(|event| &event.remove).map(|name| name.text.as_str()).collect();
        let all = (self.joints.iter().enumerate().map(|(index, part)| (Owner::Joint(JointId(index)), &part.name)))
            .chain(self.drivers.iter().enumerate().map(|(index, part)| (Owner::Driver(DriverId(index)), &part.name)))
            .chain(self.loads.iter().enumerate().map(|(index, part)| (Owner::Load(LoadId(index)), &part.name)));
        let is_one =
            |(owner, name): &(Owner, &Text)| names.contains(name.text.as_str()) || self.engaging(*owner).is_some();
        all.filter(is_one).collect()
    }
}

impl Resolver<'_> {
    /// The discrete variables of the scene, still without what sampled ones begin with; their units are known from here on.
    pub(super) fn declare_discrete(&mut self) -> Vec<Discrete> {
        let scene = self.scene;
        let mut all = Vec::new();
        for sampler in &scene.sampled {
            for value in &sampler.values {
                let id = DiscreteId(all.len());
                all.push(self.within(sampler.within, |resolver| resolver.declare_sampled(id, value)));
            }
        }
        let before = crate::expr::Function::Two(crate::expr::Binary::Min);
        let never = Formula::Call(before, vec![Formula::Number(-1.0), Formula::Time + Formula::Number(-1.0)]);
        for event in &scene.events {
            self.discrete_units.push(Some((crate::model::Exponents::SECOND, 0)));
            all.push(Discrete {
                name: format!("events.{}.time", event.name.text),
                description: format!("time of the last event `{}`; negative before the first", event.name.text),
                unit: Unit::time(),
                kind: DiscreteKind::Time,
                begin: never.clone(),
                span: event.name.span,
            });
        }
        for (owner, name) in scene.removed() {
            self.discrete_units.push(None);
            let (word, description, begins) = match scene.engaging(owner) {
                Some(begins) => ("engaged", format!("1 while `{}` is engaged", name.text), begins),
                None => ("there", format!("1 until `{}` is removed", name.text), true),
            };
            all.push(Discrete {
                name: format!("{}.{word}", name.text),
                description,
                unit: Unit::default(),
                kind: DiscreteKind::Presence(owner),
                begin: Formula::Number(f64::from(u8::from(begins))),
                span: name.span,
            });
        }
        all
    }

    fn declare_sampled(&mut self, id: DiscreteId, value: &model::SampledValue) -> Discrete {
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
        self.declared_units.extend(unit.clone().map(|unit| (id, unit)));
        let hertz = hertz(unit.as_ref(), value.start.as_ref(), value.unit.as_ref());
        self.discrete_units.push(unit.as_ref().map(|unit| (unit.exponents, hertz)));
        let description = value.description.as_ref().map(|text| text.text.clone()).unwrap_or_default();
        Discrete {
            name: value.name.text.clone(),
            description,
            unit: unit.unwrap_or_default(),
            kind: DiscreteKind::Sampled,
            begin: Formula::Number(0.0),
            span: value.name.span,
        }
    }

    /// The samplers; sampled values get what they begin with.
    pub(super) fn samplers(&mut self, discrete: &mut [Discrete]) -> Vec<Sampler> {
        let scene = self.scene;
        let mut samplers = Vec::new();
        let mut ids = scene.sampled_values();
        for (place, sampler) in scene.sampled.iter().enumerate() {
            let sampled: Vec<_> = ids.by_ref().take(sampler.values.len()).collect();
            let what = format!("`period` of sampler `{}`", sampler.name.text);
            let (period, offset) = self.within(sampler.within, |resolver| {
                let period = resolver.constant_in(Range::Positive, &sampler.period, &what, &TIME);
                let what = format!("`offset` of sampler `{}`", sampler.name.text);
                let offset = sampler.offset.as_ref().map(|offset| resolver.constant(offset, &what, &TIME));
                (period, offset.unwrap_or(Formula::Number(0.0)))
            });
            let mut writes = Vec::new();
            for (id, value) in sampled {
                discrete[id.0].begin = self.within(sampler.within, |resolver| resolver.begin(id, value));
                if let Some((next, _)) = value.next.as_ref().and_then(|_| self.next(id, place)) {
                    writes.push((id, next));
                }
            }
            let name = sampler.name.text.clone();
            samplers.push(Sampler { name, period, offset, writes, span: sampler.name.span });
        }
        samplers.append(&mut self.transfers.samplers);
        samplers
    }

    fn begin(&mut self, id: DiscreteId, value: &model::SampledValue) -> Formula {
        let Some(start) = &value.start else { return Formula::Number(0.0) };
        let what = format!("`start` of sampled value `{}`", value.name.text);
        self.discrete_formula(start, id, &what, Context::Start).0
    }

    /// What a sampled value gets at a tick of its sampler.
    pub(super) fn next(&mut self, id: DiscreteId, sampler: usize) -> Next {
        if let Some(known) = self.nexts.known.get(&id) {
            return known.clone();
        }
        let scene = self.scene;
        let (_, value) = scene.sampled_values().find(|(candidate, _)| *candidate == id)?;
        let Some(next) = &value.next else {
            let unit = self.discrete_units[id.0].map(|(exponents, _)| exponents);
            return Some((Formula::Discrete(id), KnownUnit::moving(unit)));
        };
        if let Some(first) = self.nexts.pending.iter().position(|candidate| *candidate == id) {
            self.refuse_circle_of_news(first);
            return None;
        }
        self.nexts.pending.push(id);
        let found = self.within(scene.sampled[sampler].within, |resolver| {
            let what = format!("`next` of sampled value `{}`", value.name.text);
            resolver.discrete_formula(next, id, &what, Context::Instant(Some(sampler)))
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
            |id: &DiscreteId| scene.sampled_values().find(|(candidate, _)| candidate == id).map(|(_, value)| value);
        let place = |sampled: &model::SampledValue| sampled.next.as_ref().map_or(sampled.name.span, |next| next.span);
        let pending = self.nexts.pending[first..].iter().chain([&self.nexts.pending[first]]);
        let circle: Vec<_> =
            pending.filter_map(value).map(|sampled| (sampled.name.text.as_str(), place(sampled))).collect();
        let help = "use the previous value in one of them: `x` instead of `new(x)`";
        self.refuse_circle(&circle, "new values of sampled values", help);
    }

    /// What a sampled value becomes: a bare number is in its unit, an expression must have it.
    fn discrete_formula(
        &mut self,
        quantity: &crate::scene::quantity::Quantity,
        id: DiscreteId,
        what: &str,
        context: Context,
    ) -> (Formula, KnownUnit) {
        let ReadFormula { formula, unit, known } = self.formula_and_known(quantity, what, &ANYTHING, context);
        let declared = self.declared_units.get(&id).cloned();
        self.must_agree(what, declared.as_ref(), unit.as_ref().filter(|_| known != KnownUnit::Number), quantity.span);
        let factor = bare_factor(declared.as_ref(), quantity);
        let known = declared.map_or(known, |unit| KnownUnit::moving(Some(unit.exponents)));
        (formula * Formula::Number(factor), known)
    }

    /// What `new(x)` stands for.
    pub(super) fn new_value(&mut self, name: &Text, sampler: Option<usize>, what: &str) -> Next {
        let variable = match self.names.get(&name.text) {
            Some(Named::Sampled(id)) => Some(id),
            _ => None,
        };
        let scene = self.scene;
        let values = sampler.map(|sampler| &scene.sampled[sampler].values[..]).unwrap_or_default();
        let is_here = values.iter().any(|value| value.name.text == name.text);
        if let (Some(id), Some(sampler), true) = (variable, sampler, is_here) {
            self.used_discrete.insert(id);
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
        let changes = [&event.remove, &event.engage, &event.release].iter().any(|names| !names.is_empty());
        if !changes && event.set.is_empty() && !event.stop {
            self.nothing_happens(event, &what);
        }
        let (mut writes, mut states) = (vec![(scene.time_of(place), Formula::Time)], Vec::new());
        let mut rates = Vec::new();
        for (name, value) in &event.set {
            match self.names.get(&name.text) {
                Some(Named::State(id)) => states.push((id, self.set_state(id, name, value, &what))),
                None if name.text.contains('.') => rates.extend(self.set_rate(name, value, &what)),
                _ => writes.extend(self.set(name, value, &what)),
            }
        }
        self.set_rates.push(rates);
        let mut removes: Vec<Owner> = event.remove.iter().filter_map(|name| self.removed(name, &what)).collect();
        removes.extend(event.release.iter().filter_map(|name| self.engaged(name, ("releases", "released"), &what)));
        let engages = event.engage.iter().filter_map(|name| self.engaged(name, ("engages", "engaged"), &what));
        let engages: Vec<Owner> = engages.collect();
        self.check_once(event, &what);
        let (comparison, sides) = self.sides(&event.when, &format!("`when` of {what}"))?;
        Some(Event {
            name: event.name.text.clone(),
            description: event.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
            comparison,
            sides,
            writes,
            states,
            engages,
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
        let help =
            "give its effect: `remove = [\"spring\"]`, `engage = [\"latch\"]`, `set = { x = 0 }` or `stop = true`";
        let label = "has neither `remove` nor `engage` nor `release` nor `set` nor `stop`";
        self.faults.push(fault.label(label).help(help));
    }

    /// What a state becomes: a bare number is in its unit, an expression must have it.
    fn set_state(&mut self, id: StateId, name: &Text, value: &crate::scene::quantity::Quantity, what: &str) -> Formula {
        let what = format!("`set.{}` of {what}", name.text);
        let unit = self.declared_state_units.get(id.0).cloned().flatten();
        let ReadFormula { formula, unit: found, known } =
            self.formula_and_known(value, &what, &ANYTHING, Context::Instant(None));
        self.must_agree(&what, unit.as_ref(), found.as_ref().filter(|_| known != KnownUnit::Number), value.span);
        formula * Formula::Number(bare_factor(unit.as_ref(), value))
    }

    fn set(
        &mut self,
        name: &Text,
        value: &crate::scene::quantity::Quantity,
        what: &str,
    ) -> Option<(DiscreteId, Formula)> {
        let scene = self.scene;
        let Some(Named::Sampled(id)) = self.names.get(&name.text) else {
            if !self.is_reported(name, &name.text) {
                let names = scene.sampled_values().map(|(_, value)| value.name.text.as_str());
                let known: Vec<&str> = names.chain(scene.states.iter().map(|state| state.name.text.as_str())).collect();
                let otherwise = match known.is_empty() {
                    true => "the scene has none: define it under `[sampled]` or `[states]`".to_owned(),
                    false => format!("they are {}", suggest::list(known.iter().copied())),
                };
                let message = format!("{what} sets `{}`, which is neither a sampled value nor a state", name.text);
                let fault = Fault::new("scene::unknown_name", message, name.span).label("cannot be set");
                self.faults.push(fault.help(suggest::hint(&name.text, known, otherwise)));
            }
            return None;
        };
        let what = format!("`set.{}` of {what}", name.text);
        Some((id, self.discrete_formula(value, id, &what, Context::Instant(None)).0))
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
                | Named::Sampled(_)
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
