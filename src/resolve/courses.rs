//! What ropes and bands run over: pulleys in `over`, drums among the ends.

use super::Resolver;
use super::context::Context;
use super::parts::KeyReader;
use crate::component::{Component, Section};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::model::measure::NUMBER;
use crate::model::{Course, Formula, KeyValue, Place, Pulley, Range};
use crate::scene::constant;
use crate::scene::decode::Fields;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::{Key, names};
use crate::scene::tables::{DRUM, PULLEY};

/// Keys that are not supported yet, and what to do instead.
const LATER: [(&str, &str); 2] = [
    (
        "grip",
        "end one rope on the body as a drum and begin another there: `{ drum = \"BODY\", radius = ..., side = ... }`",
    ),
    ("lift_off", "without it a run ends where the rope would leave the pulley"),
];
/// No rope is wound up more often.
const MOST_TURNS: f64 = 1e6;

/// An end of a part: a point, or the drum of a body.
pub(super) struct CourseEnd {
    pub name: Text,
    pub at: Place,
    pub drum: Option<Pulley>,
}

impl CourseEnd {
    fn point(name: Text, at: Place) -> CourseEnd {
        CourseEnd { name, at, drum: None }
    }
}

impl Resolver<'_> {
    /// The pulleys of a list.
    pub(super) fn pulleys(&mut self, node: &DocumentNode, what: &str, user: &str) -> Option<Vec<Pulley>> {
        let Content::Array(items) = &node.kind else {
            let message = format!("{what} is {}, but must be a list of pulleys", node.kind.name());
            let help = "write `over = [{ on = \"BODY.POINT\", radius = \"50 mm\", side = \"left\" }]`";
            self.faults.push(Fault::new("scene::wrong_type", message, node.span).label("not a list").help(help));
            return None;
        };
        let mut complete = true;
        let mut pulleys = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let called = format!("pulley {} of {user}", index + 1);
            let pulley = self.pulley(item, &called, PULLEY);
            complete &= pulley.is_some();
            pulleys.extend(pulley);
        }
        complete.then_some(pulleys)
    }

    /// The drum at an end, if a table stands there.
    pub(super) fn drum(&mut self, node: &DocumentNode, user: &str) -> Option<Pulley> {
        self.pulley(node, &format!("the drum of {user}"), DRUM)
    }

    fn pulley(&mut self, node: &DocumentNode, called: &str, keys: &'static [Key]) -> Option<Pulley> {
        let known = [&names(keys)[..], &LATER.map(|(key, _)| key)].concat();
        let fields = Fields::open(node, called, node.span, &known, self.faults)?;
        let mut is_supported = true;
        for (key, help) in LATER {
            if let Some(span) = fields.key_span(key) {
                let message = format!("`{key}` of {called} is not supported yet");
                self.faults.push(Fault::new("scene::unknown_key", message, span).label("not supported").help(help));
                is_supported = false;
            }
        }
        let on = fields.required(keys[0].name, keys[0].help(), self.faults);
        let radius = fields.required("radius", keys[1].help(), self.faults);
        let on = on.and_then(|node| self.faults.text(node, &fields.name_of(keys[0].name)));
        let on = on.and_then(|name| self.place(&name, called));
        let reader = KeyReader { fields: &fields, user: called, context: Context::Constant };
        let mut value = |key: &'static Key, node: &DocumentNode| self.value_of(key, node, &reader);
        let radius = radius.and_then(|node| value(&keys[1], node));
        let side = fields.get("side").map(|node| value(&keys[2], node));
        let mu = fields.get("mu").zip(keys.get(4)).map(|(node, key)| value(key, node));
        let turns = fields.get("turns").map_or(Some(0), |node| self.whole_turns(node, &fields));
        let is_eye = radius == Some(KeyValue::Formula(Formula::Number(0.0)));
        if side.is_none() && !is_eye {
            const SIDES: &str = "say where its centre is, seen along the rope from the first end: `side = \"left\"` or `side = \"right\"`";
            fields.required("side", SIDES, self.faults)?;
        }
        let (side, mu) = (given(side)?, given(mu)?);
        let KeyValue::Formula(radius) = radius? else { return None };
        let mu = mu.map(|mu| if let KeyValue::Formula(mu) = mu { mu } else { Formula::Number(0.0) });
        let is_left = side != Some(KeyValue::Choice("right"));
        let pulley = Pulley { on: on?, radius, is_left, turns: turns?, mu, span: node.span };
        is_supported.then_some(pulley)
    }

    fn whole_turns(&mut self, node: &DocumentNode, fields: &Fields<'_>) -> Option<u32> {
        let what = fields.name_of("turns");
        let quantity = self.faults.quantity(node, &what)?;
        let formula = self.constant_in(Range::NotNegative, &quantity, &what, &NUMBER);
        let turns = constant::number(&formula).filter(|turns| turns.fract() == 0.0 && *turns <= MOST_TURNS);
        if turns.is_none() {
            let message = format!("{what} must be a whole number, such as 0 or 2");
            let fault = Fault::new("scene::wrong_value", message, node.span).label("not a whole number");
            self.faults.push(fault.help("give the turns beyond the part of a turn that the tangents make"));
        }
        turns.map(|turns| turns.max(0.0) as u32)
    }

    /// Two points or drums. The same body may be at both ends of what runs over something else.
    pub(super) fn course_ends(
        &mut self,
        (key, node): (&Key, &DocumentNode),
        (fields, user): (&Fields<'_>, &str),
    ) -> Option<[CourseEnd; 2]> {
        let is_plain = |node: &DocumentNode| match &node.kind {
            Content::Array(items) => items.iter().all(|item| !matches!(item.kind, Content::Table(_))),
            _ => true,
        };
        let what = fields.name_of(key.name);
        if is_plain(node) {
            let names = self.faults.pair(node, &what, key.help())?;
            if fields.get("over").is_none() {
                let places = self.places(&names, user)?;
                let [first, second] = names;
                return Some([CourseEnd::point(first, places[0]), CourseEnd::point(second, places[1])]);
            }
            let (first, second) = (self.place(&names[0], user), self.place(&names[1], user));
            let [first_name, second_name] = names;
            return Some([CourseEnd::point(first_name, first?), CourseEnd::point(second_name, second?)]);
        }
        let Content::Array(items) = &node.kind else { return None };
        let [first, second] = &items[..] else {
            let message = format!("{what} must have two entries, but has {}", items.len());
            let fault = Fault::new("scene::wrong_value", message, node.span).label("two are needed");
            self.faults.push(fault.help(key.help().to_owned()));
            return None;
        };
        let (first, second) = (self.course_end(first, &what, user), self.course_end(second, &what, user));
        let (first, second) = (first?, second?);
        if fields.get("over").is_none() {
            let names = [first.name.clone(), second.name.clone()];
            self.different(first.at.body(), second.at.body(), &names, user)?;
        }
        Some([first, second])
    }

    fn course_end(&mut self, node: &DocumentNode, what: &str, user: &str) -> Option<CourseEnd> {
        if matches!(node.kind, Content::Table(_)) {
            let drum = self.drum(node, user)?;
            let name = Text::new(String::new(), node.span);
            return Some(CourseEnd { name, at: drum.on, drum: Some(drum) });
        }
        let name = self.faults.text(node, &format!("an entry of {what}"))?;
        let place = self.place(&name, user)?;
        Some(CourseEnd::point(name, place))
    }

    /// What a part runs over, if its keys say so. A course on one body alone moves nothing.
    pub(super) fn course(
        &mut self,
        (component, course): (&Component, Course),
        between: [Place; 2],
        (user, span): (&str, Span),
    ) -> Option<Option<KeyValue>> {
        if course.pulleys().next().is_none() {
            return Some(None);
        }
        let mut rubbing = course.over.iter().filter(|pulley| pulley.mu.is_some());
        if let Some((pulley, help)) = match (component.section, rubbing.next(), rubbing.next()) {
            (Section::Joints, _, Some(second)) => {
                Some((second, "leave one `mu`, or end two ropes on a drum between them"))
            }
            (Section::Loads, Some(first), _) => Some((first, "remove it: only a `rope` joint has friction on pulleys")),
            _ => None,
        } {
            let what = if component.section == Section::Joints { "a second `mu`" } else { "`mu`" };
            let message = format!("{user} has {what} on a pulley, which is not supported");
            self.faults.push(Fault::new("scene::friction", message, pulley.span).label("not supported").help(help));
            return None;
        }
        self.must_have_plane(user, span);
        let bodies = || between.into_iter().chain(course.over.iter().map(|pulley| pulley.on)).map(Place::body);
        if bodies().all(|body| body == between[0].body()) {
            let message = format!("{user} has its ends and pulleys on one body, so it moves nothing");
            let fault = Fault::new("scene::self_connection", message, span).label("on one body");
            self.faults.push(fault.help("name at least two different bodies, or a body and `ground`"));
            return None;
        }
        Some(Some(KeyValue::Course(course)))
    }
}

/// The value of a key that may be absent; none if what was written is faulty.
fn given(value: Option<Option<KeyValue>>) -> Option<Option<KeyValue>> {
    value.map_or(Some(None), |value| value.map(Some))
}
