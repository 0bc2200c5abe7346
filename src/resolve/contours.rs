//! Profiles of contacts: corners, and lines and arcs between them.

use super::Resolver;
use super::context::Context;
use super::parts::KeyReader;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::model::measure::LENGTH;
use crate::model::{Contour, ContourCorner, Flaw, Formula, KeyValue};
use crate::scene::constant;
use crate::scene::decode::Fields;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::names;
use crate::scene::tables::CORNER;

/// A profile has no more corners.
const MOST: usize = 200;
const HELP: &str =
    "write corners, and arcs between them: `profile = [[0, 0], [0.1, 0], { to = [0.2, 0.1], radius = \"0.1 m\" }]`";

impl Resolver<'_> {
    /// The corners of a list; what leads to them is known, but not from which side they are seen.
    pub(super) fn profile(&mut self, node: &DocumentNode, what: &str, user: &str) -> Option<Contour> {
        let Content::Array(items) = &node.kind else {
            let message = format!("{what} is {}, but must be a list of corners", node.kind.name());
            self.faults.push(Fault::new("scene::wrong_type", message, node.span).label("not a list").help(HELP));
            return None;
        };
        if items.len() < 2 || items.len() > MOST {
            let count = items.len();
            let message =
                format!("{what} has {count} corner{}, but must have 2 to {MOST}", if count == 1 { "" } else { "s" });
            let fault = Fault::new("scene::profile", message, node.span).label(format!("2 to {MOST} are needed"));
            self.faults.push(fault.help(HELP));
            return None;
        }
        let corner = |(index, item): (usize, &DocumentNode)| self.profile_corner(item, (index, what), user);
        let corners: Vec<Option<ContourCorner>> = items.iter().enumerate().map(corner).collect();
        Some(Contour { corners: corners.into_iter().collect::<Option<_>>()?, closed: false, radius: 0.0 })
    }

    fn profile_corner(
        &mut self,
        node: &DocumentNode,
        (index, what): (usize, &str),
        user: &str,
    ) -> Option<ContourCorner> {
        let called = format!("corner {} of {what}", index + 1);
        if !matches!(node.kind, Content::Table(_)) {
            let vector = self.faults.vector(node, &called)?;
            let at = self.vector(&vector, &called, &LENGTH, Context::Constant);
            return Some(ContourCorner { at: self.numbers(&at, &called, node.span)?, arc: None, span: node.span });
        }
        let fields = Fields::open(node, &called, node.span, &names(CORNER), self.faults)?;
        let reader = KeyReader { fields: &fields, user, context: Context::Constant };
        let [to, radius] = [0, 1].map(|key| fields.required(CORNER[key].name, CORNER[key].help(), self.faults));
        let mut value = |key: usize, node: Option<&DocumentNode>| self.value_of(&CORNER[key], node?, &reader);
        let (to, radius) = (value(0, to), value(1, radius));
        let turn = match fields.get(CORNER[2].name) {
            Some(node) => Some(value(2, Some(node))?),
            None => None,
        };
        let (KeyValue::Vector(to), KeyValue::Formula(radius)) = (to?, radius?) else { return None };
        let at = self.numbers(&to, &called, node.span);
        let radius = self.number_of(&radius, &format!("`radius` of {called}"), node.span)?;
        let is_right = turn == Some(KeyValue::Choice("right"));
        Some(ContourCorner { at: at?, arc: Some(if is_right { -radius } else { radius }), span: node.span })
    }

    fn numbers(&mut self, both: &[Formula; 2], what: &str, span: Span) -> Option<[f64; 2]> {
        let [x, y] = both.each_ref().map(|formula| self.number_of(formula, what, span));
        Some([x?, y?])
    }

    /// A number that no parameter changes: the lines and arcs of a profile are numbers of the program.
    fn number_of(&mut self, formula: &Formula, what: &str, span: Span) -> Option<f64> {
        let mut reads = false;
        formula.visit_parameters(&mut |_| reads = true);
        if reads {
            let message = format!("{what} depends on a parameter, but a profile is fixed when the scene is compiled");
            let fault = Fault::new("scene::profile", message, span).label("depends on a parameter");
            self.faults.push(fault.help("write numbers; different profiles are different scenes"));
            return None;
        }
        // What is not a number has been reported.
        Some(constant::evaluate(formula, &[])).filter(|value| value.is_finite())
    }

    /// The profile of a contact with everything that its keys say; or that there is none, which `closed` needs.
    pub(super) fn complete_profile(
        &mut self,
        values: &mut Vec<(&'static str, KeyValue)>,
        fields: &Fields<'_>,
        user: &str,
    ) -> Option<()> {
        let value = |values: &[(&str, KeyValue)], wanted: &str| {
            values.iter().find(|(key, _)| *key == wanted).map(|(_, value)| value.clone())
        };
        let Some(KeyValue::Contour(mut contour)) = value(values, "profile") else {
            if let (Some(span), true) =
                (fields.key_span("closed"), value(values, "axis").or(value(values, "circle")).is_some())
            {
                let message = format!("`closed` of {user} has no effect without a `profile`");
                let fault = Fault::new("scene::profile", message, span).label("no profile");
                self.faults.push(fault.help("remove it, or give a `profile` in place of the line or circle"));
                return None;
            }
            return Some(());
        };
        let mut is_sound = true;
        if let Some(span) = fields.key_span("friction") {
            let message = format!(
                "{user} has `friction` on a profile, which is not supported: how far a disc has slid is counted along one line or circle"
            );
            let fault = Fault::new("scene::friction", message, span).label("not supported");
            self.faults.push(fault.help("leave it out, or use a contact with a line or a circle"));
            is_sound = false;
        }
        if let Some(KeyValue::Formula(radius)) = value(values, "radius") {
            let span = fields.get("radius").map_or(fields.span, |node| node.span);
            match self.number_of(&radius, &format!("`radius` of {user}"), span) {
                Some(radius) => contour.radius = radius,
                None => is_sound = false,
            }
        }
        contour.closed = value(values, "closed") == Some(KeyValue::Switch(true));
        if contour.closed {
            contour.close();
        }
        let side = value(values, "side");
        if let Some(KeyValue::Choice(side @ ("outside" | "inside"))) = side {
            let span = fields.get("side").map_or(fields.span, |node| node.span);
            let message = format!("`side` of {user} is `{side}`, but it touches a profile");
            let fault = Fault::new("scene::wrong_value", message, span).label("not a side of a profile");
            self.faults.push(fault.help("write `side = \"left\"` or `side = \"right\"`, seen along the profile"));
            is_sound = false;
        }
        let first = contour.corners.first().filter(|corner| corner.arc.is_some() && !contour.closed);
        if let Some(span) = first.map(|corner| corner.span) {
            let message = format!("the profile of {user} begins with an arc, but has no corner before it");
            let fault = Fault::new("scene::profile", message, span).label("no corner before it");
            self.faults
                .push(fault.help("write the first corner as two coordinates, or an outline with `closed = true`"));
            is_sound = false;
        }
        if !is_sound {
            return None;
        }
        if side == Some(KeyValue::Choice("right")) {
            contour = contour.reversed();
        }
        let flaws = contour.flaws();
        for Flaw { span, message, label, help } in &flaws {
            let message = format!("the profile of {user} {message}");
            self.faults.push(Fault::new("scene::profile", message, *span).label(*label).help(help.clone()));
        }
        values.retain(|(key, _)| !["profile", "closed", "radius"].contains(key));
        values.push(("profile", KeyValue::Contour(contour)));
        flaws.is_empty().then_some(())
    }
}
