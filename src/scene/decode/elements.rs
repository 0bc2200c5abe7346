//! Parameters, inputs, states, sampled values, events, points of the ground, and files that are parts.

use super::Decoder;
use super::fields::{Fields, as_vector, wrong_type};
use crate::diagnostic::span::Text;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::names;
use crate::scene::model::{Event, GroundOutline, Input, Parameter, Point, Sampled, SampledValue, Signal, State, Use};
use crate::scene::part::Part;
use crate::scene::quantity::Quantity;
use crate::scene::tables::{EVENT, GROUND, INPUT, PARAMETER, PART, SAMPLED, SAMPLED_VALUE, SIGNAL, STATE};

impl Decoder {
    pub(super) fn parameter(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Parameter> {
        if !matches!(node.kind, Content::Table(_)) {
            let value = self.faults.quantity(node, owner)?;
            return Some(Parameter { name: name.clone(), value, ..Parameter::default() });
        }
        let fields = Fields::open(node, owner, name.span, &names(PARAMETER), &mut self.faults)?;
        let value = self.faults.required_quantity(&fields, "value", PARAMETER[0].help());
        let tunable = fields.get("tunable").and_then(|node| self.faults.boolean(node, &fields.name_of("tunable")));
        Some(Parameter {
            name: name.clone(),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            min: self.faults.optional_quantity(&fields, "min"),
            max: self.faults.optional_quantity(&fields, "max"),
            tunable: tunable.unwrap_or(false),
            value: value?,
        })
    }

    pub(super) fn input(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Input> {
        if !matches!(node.kind, Content::Table(_)) {
            let start = Some(self.faults.quantity(node, owner)?);
            return Some(Input { name: name.clone(), start, ..Input::default() });
        }
        let fields = Fields::open(node, owner, name.span, &names(INPUT), &mut self.faults)?;
        Some(Input {
            name: name.clone(),
            start: self.faults.optional_quantity(&fields, "start"),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            min: self.faults.optional_quantity(&fields, "min"),
            max: self.faults.optional_quantity(&fields, "max"),
        })
    }

    pub(super) fn state(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<State> {
        let fields = Fields::open(node, owner, name.span, &names(STATE), &mut self.faults)?;
        let rate = self.faults.required_quantity(&fields, "rate", STATE[0].help());
        Some(State {
            name: name.clone(),
            start: self.faults.optional_quantity(&fields, "start"),
            nominal: self.faults.optional_quantity(&fields, "nominal"),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            rate: rate?,
            within: 0,
        })
    }

    /// The parts of a sampler may stand under headers of which one is misspelt.
    pub(super) fn samplers(&mut self, top: &Fields<'_>) -> Vec<Sampled> {
        let mut tables: Vec<(Text, DocumentNode)> = Vec::new();
        for (name, node) in self.entries(top, "sampled") {
            let known = tables.iter_mut().find(|(entry, _)| entry.text == name.text);
            match (known.map(|(_, entry)| &mut entry.kind), &node.kind) {
                (Some(Content::Table(rows)), Content::Table(more)) => rows.extend(more.iter().cloned()),
                _ => tables.push((name.clone(), node.clone())),
            }
        }
        let mut samplers = Vec::new();
        for (name, node) in &tables {
            match self.sampled(name, node, &format!("sampler `{}`", name.text)) {
                Some(sampler) => samplers.push(sampler),
                None => self.broken.push(name.text.clone()),
            }
        }
        samplers
    }

    fn sampled(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Sampled> {
        let fields = Fields::open(node, owner, name.span, &names(SAMPLED), &mut self.faults)?;
        let period = self.faults.required_quantity(&fields, "period", SAMPLED[0].help());
        let node = fields.required("values", SAMPLED[2].help(), &mut self.faults);
        let entries = node.and_then(|node| self.faults.entries(node, &fields.name_of("values")));
        let mut values = Vec::new();
        for (name, node) in entries.unwrap_or_default() {
            match self.sampled_value(name, node) {
                Some(value) => values.push(value),
                None => self.broken.push(name.text.clone()),
            }
        }
        let offset = self.faults.optional_quantity(&fields, "offset");
        if period.is_none() {
            self.broken.extend(values.iter().map(|value| value.name.text.clone()));
        }
        Some(Sampled { name: name.clone(), period: period?, offset, values, within: 0 })
    }

    fn sampled_value(&mut self, name: &Text, node: &DocumentNode) -> Option<SampledValue> {
        let owner = format!("sampled value `{}`", name.text);
        if !matches!(node.kind, Content::Table(_)) {
            let start = Some(self.faults.quantity(node, &owner)?);
            return Some(SampledValue { name: name.clone(), start, ..SampledValue::default() });
        }
        let fields = Fields::open(node, &owner, name.span, &names(SAMPLED_VALUE), &mut self.faults)?;
        Some(SampledValue {
            name: name.clone(),
            start: self.faults.optional_quantity(&fields, "start"),
            next: self.faults.optional_quantity(&fields, "next"),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
        })
    }

    pub(super) fn event(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Event> {
        let fields = Fields::open(node, owner, name.span, &names(EVENT), &mut self.faults)?;
        let when = self.faults.required_text(&fields, "when", EVENT[0].help());
        let mut switch = |key| fields.get(key).and_then(|node| self.faults.boolean(node, &fields.name_of(key)));
        let (stop, once) = (switch("stop"), switch("once"));
        let mut names = |key| {
            let names = fields.get(key).and_then(|node| self.faults.texts(node, &fields.name_of(key)));
            names.unwrap_or_default()
        };
        let (remove, engage, release) = (names("remove"), names("engage"), names("release"));
        let set = fields.get("set").and_then(|node| self.faults.entries(node, &fields.name_of("set")));
        let value = |(name, node): &(Text, DocumentNode)| {
            let what = format!("`set.{}` of {owner}", name.text);
            Some((name.clone(), self.faults.quantity(node, &what)?))
        };
        Some(Event {
            name: name.clone(),
            set: set.unwrap_or_default().iter().filter_map(value).collect(),
            description: self.faults.optional_text(&fields, "description"),
            once: once.unwrap_or(!remove.is_empty()),
            stop: stop.unwrap_or(false),
            remove,
            engage,
            release,
            when: when?,
            within: 0,
        })
    }

    /// A law that is used by its name, or an output that is an expression.
    pub(super) fn signal(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Signal> {
        if !matches!(node.kind, Content::Table(_)) {
            let value = self.faults.quantity(node, owner)?;
            return Some(Signal { name: name.clone(), value, ..Signal::default() });
        }
        let any = Fields::open_any(node, owner, name.span, &mut self.faults)?;
        // The keys of one with a type are known where its type is.
        let part = any.get("type").map(|_| Part::new(name.clone(), node.clone()));
        let fields = match part {
            Some(_) => any,
            None => Fields::open(node, owner, name.span, &names(SIGNAL), &mut self.faults)?,
        };
        let value = match part {
            Some(_) => Some(Quantity::default()),
            None => self.faults.required_quantity(&fields, "value", SIGNAL[0].help()),
        };
        Some(Signal {
            name: name.clone(),
            unit: self.faults.optional_text(&fields, "unit"),
            description: self.faults.optional_text(&fields, "description"),
            value: value?,
            part,
            within: 0,
        })
    }

    pub(super) fn part(&mut self, name: &Text, node: &DocumentNode, owner: &str) -> Option<Use> {
        let fields = Fields::open(node, owner, name.span, &names(PART), &mut self.faults)?;
        let file = self.faults.required_text(&fields, "file", PART[0].help());
        let parameters =
            fields.get("parameters").and_then(|node| self.faults.entries(node, &fields.name_of("parameters")));
        let value = |(name, node): &(Text, DocumentNode)| {
            let what = format!("parameter `{}` of {owner}", name.text);
            Some((name.clone(), self.faults.quantity(node, &what)?))
        };
        let parameters = parameters.unwrap_or_default().iter().filter_map(value).collect();
        let at = fields.get("at").and_then(|node| self.faults.vector(node, &fields.name_of("at")));
        let mirror = fields.get("mirror").and_then(|node| self.faults.boolean(node, &fields.name_of("mirror")));
        Some(Use {
            name: name.clone(),
            file: file?,
            parameters,
            on: self.faults.optional_text(&fields, "on").filter(|on| on.text != "ground"),
            at,
            angle: self.faults.optional_quantity(&fields, "angle"),
            mirror: mirror.unwrap_or(false),
            origin: Text::from("ground"),
            within: 0,
        })
    }

    pub(super) fn ground(&mut self, top: &Fields<'_>) -> (Vec<Point>, Vec<GroundOutline>) {
        let (Some(node), Some(span)) = (top.get("ground"), top.key_span("ground")) else {
            return Default::default();
        };
        let Some(fields) = Fields::open(node, "the ground", span, &names(GROUND), &mut self.faults) else {
            return Default::default();
        };
        let outline = fields.get("outline").map(|node| GroundOutline { node: node.clone(), within: 0 });
        (self.ground_points(&fields), outline.into_iter().collect())
    }

    /// What is no place among the points of the ground: several of them are the keys of a body whose header is missing.
    fn no_point(&mut self, node: &DocumentNode, what: &str) {
        const SUBJECT: &str = "the points of the ground";
        if !self.faults.again(SUBJECT, node.span) {
            let fault = wrong_type(node, what, "a list of two numbers");
            let help = format!(
                "{}; or, if a body begins here, write its header above: `[bodies.NAME]`",
                as_vector(node, what)
            );
            self.faults.push_about(SUBJECT, fault.help(help));
        }
    }

    fn ground_points(&mut self, fields: &Fields<'_>) -> Vec<Point> {
        let Some(node) = fields.get("points") else {
            return Vec::new();
        };
        let Some(entries) = self.faults.points(node, &fields.name_of("points")) else {
            return Vec::new();
        };
        let mut points = Vec::new();
        for (name, node) in entries {
            let what = format!("point `ground.{}`", name.text);
            if !matches!(node.kind, Content::Array(_)) {
                self.no_point(node, &what);
                continue;
            }
            match self.faults.vector(node, &what) {
                Some(at) => points.push(Point { name: name.clone(), at, within: 0 }),
                None => self.broken.push(format!("ground.{}", name.text)),
            }
        }
        points
    }
}
