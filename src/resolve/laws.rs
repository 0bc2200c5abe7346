//! Directions, dry friction and prescribed motions.

use super::Resolver;
use super::context::Context;
use super::formulas::FACTOR;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::expr::{Binary, Function, Unary};
use crate::model::measure::{ANGLE, ANYTHING, FORCE, LENGTH, NUMBER, Wanted};
use crate::model::{Formula, Friction, InputId, KeyValue, Limits, Motion, Pressed, Range};
use crate::scene::constant;
use crate::scene::decode::{Fields, written};
use crate::scene::document::{Content, DocumentNode};
use crate::scene::model::{InputAs, Vector};
use crate::scene::quantity::Quantity;
use crate::scene::record::Record;
use crate::scene::unit::from_exponents;

impl Resolver<'_> {
    pub(super) fn axis(&mut self, axis: &Vector, what: &str) -> [Formula; 2] {
        let [x, y] = self.vector(axis, what, &ANYTHING, Context::Constant);
        let length = libm::hypot(self.value(&x), self.value(&y));
        if length == 0.0 {
            self.faults.push(
                Fault::new("scene::zero_axis", format!("{what} is zero, so it has no direction"), axis.span)
                    .label("length zero")
                    .help("give a vector of any length but zero: `axis = [1.0, 0.0]`"),
            );
        }
        match (constant::number(&x), constant::number(&y)) {
            (Some(x), Some(y)) => [Formula::Number(x / length), Formula::Number(y / length)],
            _ => {
                let squared = |a: &Formula| constant::combine(Binary::Power, a.clone(), Formula::Number(2.0));
                let norm = constant::apply(Function::One(Unary::Sqrt), vec![squared(&x) + squared(&y)]);
                [x, y].map(|component| component / norm.clone())
            }
        }
    }

    /// The values of a record.
    pub(super) fn record(&mut self, record: Record, node: &DocumentNode, what: &str, user: &str) -> Option<KeyValue> {
        if let Some(table) = record_as_table(record, node) {
            let message = format!("{what} is {}, but must be a table", node.kind.name());
            let fault = Fault::new("scene::wrong_type", message, node.span).label("not a table");
            self.faults.push(fault.help(format!("write `{table}`")));
            return None;
        }
        let fields = match record {
            Record::Friction(_, pressed) => self.friction_fields(node, what, record.names(), pressed)?,
            Record::Limits(_) | Record::Play(_) | Record::Rebound => {
                Fields::open(node, what, node.span, &record.names(), self.faults)?
            }
        };
        match record {
            Record::Friction(wanted, _) => self.friction(&fields, user, &wanted).map(KeyValue::Friction),
            Record::Limits(wanted) => self.stops(&fields, user, &wanted).map(KeyValue::Limits),
            Record::Play(wanted) => self.play(&fields, user, &wanted).map(KeyValue::Limits),
            Record::Rebound => self.rebound(&fields, user).map(KeyValue::Limits),
        }
    }

    /// The fields of friction, if they belong together.
    fn friction_fields<'n>(
        &mut self,
        node: &'n DocumentNode,
        what: &str,
        mut known: Vec<&str>,
        pressed: Pressed,
    ) -> Option<Fields<'n>> {
        let example = pressed.example();
        if matches!(node.kind, Content::Number(_) | Content::Text(_)) {
            let message = format!("{what} is a number, but needs a table");
            let fault = Fault::new("scene::friction", message, node.span).label("not a table");
            self.faults.push(fault.help(format!("write `friction = {example}`")));
            return None;
        }
        let refused = [
            (
                "viscous",
                "viscous friction is a key of the joint itself",
                "write `damping = ...` next to `friction`, as a key of the joint",
            ),
            ("coefficient", "the coefficient of friction is called `mu`", "write `mu = ...`"),
        ];
        known.extend(refused.map(|(key, ..)| key));
        let fields = Fields::open(node, what, node.span, &known, self.faults)?;
        let mut is_refused = false;
        for (key, why, help) in refused {
            // What is only in the wrong place is not missed here.
            is_refused |= self.refuse_friction_key(&fields, key, why, help) && key == "coefficient";
        }
        (!is_refused && self.check_friction_keys(&fields, pressed, node.span, example)).then_some(fields)
    }

    /// `{ coulomb = 0.1, velocity = 0.01 }`, which is smooth, or `{ coulomb = 0.1 }`, `{ mu = 0.2 }`, which sticks: then these and `static` may be laws.
    fn friction(&mut self, fields: &Fields, user: &str, [level, speed]: &[Wanted; 2]) -> Option<Friction> {
        let of = |key: &str| format!("`{key}` of the friction of {user}");
        let sticks = fields.get("velocity").is_none();
        let mut given = |key: &str, range: Range, wanted: &Wanted| -> Option<Option<Formula>> {
            let Some(node) = fields.get(key) else { return Some(None) };
            let quantity = self.faults.quantity(node, &of(key))?;
            let is_law = sticks && ["coulomb", "mu", "static"].contains(&key);
            Some(Some(match is_law {
                true => self.law_in(range, &quantity, &of(key), wanted),
                false => self.constant_in(range, &quantity, &of(key), wanted),
            }))
        };
        let coulomb = given("coulomb", Range::NotNegative, level);
        let velocity = given("velocity", Range::Positive, speed);
        let (mu, ratio) = (given("mu", Range::NotNegative, &NUMBER), given("static", Range::FromOne, &NUMBER));
        let (radius, length) = (given("radius", Range::Positive, &LENGTH), given("length", Range::Positive, &LENGTH));
        let (wrap, pretension) =
            (given("wrap", Range::Positive, &ANGLE), given("pretension", Range::NotNegative, &FORCE));
        let [zero, one] = [0.0, 1.0].map(Formula::Number);
        Some(Friction {
            coulomb: coulomb?.unwrap_or_else(|| zero.clone()),
            velocity: velocity?,
            mu: mu?.unwrap_or(zero),
            ratio: ratio?.unwrap_or(one),
            radius: radius?,
            length: length?,
            belt: wrap?.zip(pretension?).map(|(wrap, pretension)| [wrap, pretension]),
        })
    }

    /// A law, which must be in a range: one that is constant now, others while the mechanism moves.
    fn law_in(&mut self, range: Range, quantity: &Quantity, what: &str, wanted: &Wanted) -> Formula {
        let law = self.formula(quantity, what, wanted, Context::Level);
        if law.varies() {
            return law;
        }
        let law = self.check_finite(law, quantity, what);
        self.keep_in(range, law, quantity, what, wanted)
    }

    /// True if the keys belong together, and to what presses here.
    fn check_friction_keys(&mut self, fields: &Fields<'_>, pressed: Pressed, span: Span, example: &str) -> bool {
        let has = |key: &str| fields.get(key).is_some();
        let is_long = pressed == Pressed::Guide { holds_angle: true };
        let is_round = matches!(pressed, Pressed::Pin | Pressed::Reaction(crate::model::Quantity::Force));
        let fades = matches!(pressed, Pressed::Pin | Pressed::Guide { .. });
        let wrong: Option<(&str, &str)> = match pressed {
            _ if has("velocity") && !fades => Some(("velocity", "it sticks at rest: remove `velocity`")),
            Pressed::Contact if has("coulomb") => {
                Some(("coulomb", "friction of a contact is in proportion to the normal force: give `mu`"))
            }
            Pressed::Belt if has("mu") != has("wrap") || has("mu") != has("pretension") => Some((
                "mu",
                "a belt with `mu` needs its angle of wrap and its tension: give `mu`, `wrap` and `pretension`",
            )),
            Pressed::Belt if has("mu") && has("coulomb") => {
                Some(("coulomb", "`mu`, `wrap` and `pretension` give the friction limit: remove `coulomb`"))
            }
            Pressed::Nothing if has("mu") => Some(("mu", "it has no normal force: give the friction limit, `coulomb`")),
            _ if has("velocity") && !has("coulomb") => {
                Some(("velocity", "`velocity` smooths the friction limit: give `coulomb`"))
            }
            _ if has("velocity") && has("mu") => {
                Some(("velocity", "friction in proportion to a normal force sticks at rest"))
            }
            _ if has("velocity") && has("static") => {
                Some(("static", "friction with a `velocity` does not stick, so it has no static limit"))
            }
            _ if is_round && has("mu") && !has("radius") => Some(("mu", "its lever arm is missing: give `radius`")),
            _ if has("radius") && !(has("mu") && is_round) => {
                Some(("radius", "it belongs to a pin or a thread with `mu`"))
            }
            _ if has("length") && !(has("mu") && is_long) => {
                Some(("length", "it belongs to a guide with `mu` that keeps the angle"))
            }
            _ if !has("coulomb") && !has("mu") => Some(("", "it has no friction limit")),
            _ => None,
        };
        let Some((key, why)) = wrong else { return true };
        let message = format!("{}: {why}", fields.owner);
        let fault = Fault::new("scene::friction", message, fields.key_span(key).unwrap_or(span))
            .label("not a valid combination");
        self.faults.push(fault.help(format!("write, for example, `friction = {example}`")));
        false
    }

    /// `{ min = -0.1, max = 0.2, restitution = 0.5 }`
    fn stops(&mut self, fields: &Fields, user: &str, wanted: &Wanted) -> Option<Limits> {
        let of = |key: &str| format!("`{key}` of the limits of {user}");
        let mut quantity = |key: &str| match fields.get(key) {
            Some(node) => self.faults.quantity(node, &of(key)).map(Some),
            None => Some(None),
        };
        let (min, max, restitution) = (quantity("min"), quantity("max"), quantity("restitution"));
        let [min, max] =
            [("min", min?), ("max", max?)].map(|(key, end)| end.map(|end| self.constant(&end, &of(key), wanted)));
        let restitution = self.share(restitution?, &of("restitution"));
        self.check_limits([min.as_ref(), max.as_ref()], &fields.owner, user, fields.span)?;
        Some(Limits { ends: [min, max], restitution })
    }

    /// `{ play = "0.5 deg", restitution = 0.4 }`: a relation that may be off by half of the play either way.
    fn play(&mut self, fields: &Fields, user: &str, wanted: &Wanted) -> Option<Limits> {
        let of = |key: &str| format!("`{key}` of the backlash of {user}");
        let play = self.faults.required_quantity(
            fields,
            "play",
            "give the play between the flanks: `backlash = { play = \"0.5 deg\", restitution = 0.4 }`, a length if it moves a slide",
        );
        let restitution = match fields.get("restitution") {
            Some(node) => Some(self.faults.quantity(node, &of("restitution"))?),
            None => None,
        };
        let half = self.constant_in(Range::Positive, &play?, &of("play"), wanted) / Formula::Number(2.0);
        let restitution = self.share(restitution, &of("restitution"));
        Some(Limits { ends: [Some(-half.clone()), Some(half)], restitution })
    }

    /// `{ restitution = 0.4 }`: a relation that presses only.
    fn rebound(&mut self, fields: &Fields, user: &str) -> Option<Limits> {
        let of = format!("`restitution` of {user}");
        let restitution = match fields.get("restitution") {
            Some(node) => Some(self.faults.quantity(node, &of)?),
            None => None,
        };
        let restitution = self.share(restitution, &of);
        Some(Limits { ends: [Some(Formula::Number(0.0)), None], restitution })
    }

    /// A share of a speed with which something rebounds; none if it is not given.
    fn share(&mut self, given: Option<Quantity>, what: &str) -> Formula {
        given.map_or(Formula::Number(0.0), |share| self.constant_in(Range::Share, &share, what, &NUMBER))
    }

    /// There must be one, and the lower one below the upper one.
    fn check_limits(&mut self, ends: [Option<&Formula>; 2], what: &str, user: &str, span: Span) -> Option<()> {
        let values = ends.map(|end| end.map(|end| constant::evaluate(end, &self.values)));
        let (message, label) = match values {
            [None, None] => (format!("{what} has neither `min` nor `max`"), "no limit"),
            [Some(min), Some(max)] if min >= max => {
                (format!("the limits of {user} contradict each other: `min` must be below `max`"), "nothing between")
            }
            _ => return Some(()),
        };
        let fault = Fault::new("scene::limits", message, span).label(label);
        self.faults.push(fault.help("give the hard stops: `limits = { min = -0.1, max = 0.2, restitution = 0.5 }`"));
        None
    }

    /// Is a key there that friction does not have? Says why.
    fn refuse_friction_key(&mut self, fields: &Fields<'_>, key: &str, why: &str, help: &str) -> bool {
        let span = fields.key_span(key);
        if let Some(span) = span {
            let message = format!("{} has `{key}`, but {why}", fields.owner);
            self.faults.push(Fault::new("scene::friction", message, span).label("not here").help(help));
        }
        span.is_some()
    }

    /// An expression, or `{ input = "name", as = "position" | "velocity" | "acceleration" }`.
    pub(super) fn motion(
        &mut self,
        node: &DocumentNode,
        key: &str,
        what: &str,
        wanted: &[Wanted; 3],
    ) -> Option<Motion> {
        if !matches!(node.kind, Content::Table(_)) {
            let law = self.faults.quantity(node, what)?;
            return Some(Motion::Given(self.formula(&law, what, &wanted[0], Context::Driver)));
        }
        let help = format!("write `{key} = {{ input = \"name\", as = \"velocity\" }}`");
        let fields = Fields::open(node, what, node.span, &["input", "as"], self.faults)?;
        let input = self.faults.required_text(&fields, "input", &help);
        let word = self.faults.required_text(&fields, "as", &help)?;
        let Some(order) = InputAs::WORDS.iter().position(|known| *known == word.text) else {
            let otherwise = format!("an input can be {}", suggest::list(InputAs::WORDS));
            let message =
                format!("`as` of {what} is `{}`, but must be `position`, `velocity` or `acceleration`", word.text);
            self.faults.push(
                Fault::new("scene::wrong_value", message, word.span).label("not a type of motion").help(suggest::hint(
                    &word.text,
                    InputAs::WORDS,
                    otherwise,
                )),
            );
            return None;
        };
        let input = input?;
        let id = self.input_named(&input, what)?;
        self.check_input_unit(id, &wanted[order], what, input.span);
        Some(match order {
            0 => Motion::Given(Formula::Input(id)),
            1 => Motion::Velocity(id),
            _ => Motion::Acceleration(id),
        })
    }

    fn check_input_unit(&mut self, id: InputId, wanted: &Wanted, what: &str, span: Span) {
        let known = self.input_units.get(id.0).copied().flatten();
        let (Some((found, hertz)), Some(exponents)) = (known, wanted.exponents) else {
            return;
        };
        if found.is_compatible(exponents) && hertz != 0 && wanted.is_turning() {
            self.open_hertz(&format!("{what} is {}", wanted.what), span, FACTOR);
        } else if !found.is_compatible(exponents) {
            let found = from_exponents(found).si;
            self.faults.push(
                Fault::new(
                    "scene::wrong_unit",
                    format!("{what} follows an input as {}, but the unit of the input is `{found}`", wanted.what),
                    span,
                )
                .label(format!("not {}", wanted.what))
                .help(format!("declare the input with a unit such as `{}`, or change `as`", wanted.si)),
            );
        }
    }

    fn input_named(&mut self, name: &Text, what: &str) -> Option<InputId> {
        if let Some(Named::Input(id)) = self.names.get(&name.text) {
            self.used_inputs.insert(id);
            return Some(id);
        }
        if !self.is_reported(name, &name.text) {
            let inputs = self.names.all(|named| matches!(named, Named::Input(_)));
            let otherwise = match inputs.is_empty() {
                true => format!("give it in `[inputs]`: `{} = 0.0`", name.text),
                false => format!("the inputs are {}", suggest::list(inputs.iter().copied())),
            };
            let help = suggest::hint(&name.text, inputs.iter().copied(), otherwise);
            let message = format!("{what} follows an input that is not in the scene: `{}`", name.text);
            self.faults.push_about(
                &name.text,
                Fault::new("scene::unknown_input", message, name.span).label("no such input").help(help),
            );
        }
        None
    }
}

/// Limits, play or a rebound that are written as a number, a list or a word, as the table that they must be.
fn record_as_table(record: Record, node: &DocumentNode) -> Option<String> {
    let parts: Vec<String> = match &node.kind {
        Content::Array(items) => items.iter().filter_map(written).collect(),
        Content::Table(_) => return None,
        _ => written(node).into_iter().collect(),
    };
    match (record, &parts[..]) {
        (Record::Friction(..), _) => None,
        (Record::Limits(_), [low, high]) => Some(format!("limits = {{ min = {low}, max = {high} }}")),
        (Record::Limits(_), [high]) => Some(format!("limits = {{ max = {high} }}")),
        (Record::Limits(_), _) => Some("limits = { min = LOWEST, max = HIGHEST }".to_owned()),
        (Record::Play(_), [play]) => Some(format!("backlash = {{ play = {play} }}")),
        (Record::Play(_), _) => Some("backlash = { play = \"0.5 deg\" }".to_owned()),
        (Record::Rebound, _) => Some("unilateral = { restitution = 0 }".to_owned()),
    }
}
