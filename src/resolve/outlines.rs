//! Outlines of bodies and of the ground, and the pairs whose distances are of interest. Whatever parameters make of them, a run does not depend on it:
//! they are no part of the program, and are checked once more where distances are computed.

use super::Resolver;
use super::context::Context;
use super::parts::KeyReader;
use crate::component::PartFrame;
use crate::component::outline::{ALL, OutlineKind};
use crate::component::shape::flaw_of_outline;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::measure::LENGTH;
use crate::model::{Body, BodyId, Clearance, Formula, KeyValue, Mechanism, Outline, Point, Range};
use crate::scene::decode::Fields;
use crate::scene::document::DocumentNode;
use crate::scene::key::{Key, Need, names};
use crate::scene::part::Part;

impl Resolver<'_> {
    /// The outline of a body whose points are in the frame in which they are written.
    pub(super) fn outline_of_body(
        &mut self,
        node: &DocumentNode,
        body_fields: &Fields<'_>,
        body: &Body,
    ) -> Option<Outline> {
        self.outline(node, &body_fields.name_of("outline"), body, None)
    }

    /// The outlines of the ground, which has these points.
    pub(super) fn ground_outlines(&mut self, points: &[Point]) -> Vec<Outline> {
        let scene = self.scene;
        let ground = Body { name: "ground".to_owned(), points: points.to_vec(), ..Body::default() };
        let mut outlines = Vec::new();
        for written in &scene.ground_outlines {
            let frame = self.placements[written.within].frame.clone();
            let owner = "`outline` of the ground";
            outlines.extend(
                self.within(written.within, |resolver| resolver.outline(&written.node, owner, &ground, Some(&frame))),
            );
        }
        outlines
    }

    fn outline(&mut self, node: &DocumentNode, owner: &str, body: &Body, frame: Option<&PartFrame>) -> Option<Outline> {
        self.must_have_plane(owner, node.span);
        let kind = self.kind_of_outline(node, owner)?;
        let fields = Fields::open(node, owner, node.span, &names(&kind.keys()), self.faults)?;
        let bounds = self.bounds.len();
        let (corners, offset) = (self.corners(&kind.place, &fields, body, frame), self.offset(kind, &fields));
        self.bounds.truncate(bounds);
        let (corners, offset) = (corners?, offset?);
        let values: Vec<[f64; 2]> = corners.iter().map(|at| at.each_ref().map(|x| self.value(x))).collect();
        if values.iter().flatten().all(|value| value.is_finite())
            && let Some(flaw) = flaw_of_outline(&values)
        {
            self.refuse_corners(kind.place.name, flaw, &fields)?;
            return None;
        }
        Some(Outline::Rounded(corners, offset))
    }

    /// How far the outline reaches beyond its corners.
    fn offset(&mut self, kind: &'static OutlineKind, fields: &Fields<'_>) -> Option<Formula> {
        let key: &'static Key = &kind.offset;
        let node = match key.need {
            Need::Required(help) => Some(fields.required(key.name, help, self.faults)?),
            _ => fields.get(key.name),
        };
        let Some(node) = node else { return Some(Formula::Number(0.0)) };
        let reader = KeyReader { fields, user: &fields.owner, context: Context::Constant };
        match self.value_of(key, node, &reader)? {
            KeyValue::Formula(value) if kind.share == 1.0 => Some(value),
            KeyValue::Formula(value) => Some(Formula::Number(kind.share) * value),
            _ => None,
        }
    }

    /// The kind of outline that a table names.
    fn kind_of_outline(&mut self, node: &DocumentNode, owner: &str) -> Option<&'static OutlineKind> {
        let fields = Fields::open_any(node, owner, node.span, self.faults)?;
        let given: Vec<&'static OutlineKind> =
            ALL.iter().copied().filter(|kind| fields.get(kind.place.name).is_some()).collect();
        if let [only] = given[..] {
            return Some(only);
        }
        let found = match given.is_empty() {
            true => "none of them".to_string(),
            false => suggest::list(given.iter().map(|kind| kind.place.name)),
        };
        let kinds = suggest::list(ALL.iter().map(|kind| kind.place.name));
        let message = format!("{owner} must have exactly one of {kinds}, but has {found}");
        let span = given.get(1).and_then(|kind| fields.key_span(kind.place.name)).unwrap_or(node.span);
        let help = "such as `outline = { polygon = [[0, 0], [0.2, 0], [0.1, 0.05]], round = \"2 mm\" }`";
        self.faults.push(Fault::new("scene::shape", message, span).label("exactly one is needed").help(help));
        None
    }

    /// The distances that are of interest: those of the scene, or all if it has outlines.
    pub(super) fn clearance(&mut self, mechanism: &Mechanism) -> Option<Clearance> {
        let scene = self.scene;
        let has_outlines =
            !scene.ground_outlines.is_empty() || scene.bodies.iter().any(|body| body.get("outline").is_some());
        let Some(written) = &scene.clearance else { return has_outlines.then(Clearance::default) };
        let bounds = self.bounds.len();
        let least = written.least.as_ref();
        let least = least.map(|least| self.constant_in(Range::Positive, least, "`least` of `[clearance]`", &LENGTH));
        self.bounds.truncate(bounds);
        let pairs = written.pairs.as_ref().map(|pairs| self.outlined_pairs(pairs, mechanism));
        Some(Clearance { pairs, least })
    }

    fn outlined_pairs(&mut self, pairs: &[[Text; 2]], mechanism: &Mechanism) -> Vec<[Option<BodyId>; 2]> {
        let mut known: Vec<[Option<BodyId>; 2]> = Vec::new();
        for names in pairs {
            let Some(pair) = self.body_pair(names, "`pairs` of `[clearance]`") else { continue };
            for (body, name) in pair.into_iter().zip(names) {
                if !mechanism.has_outline(body) && !self.writes_outline(body) {
                    self.refuse_without_outline(body.is_none(), name);
                }
            }
            let [first, second] = pair;
            if known.contains(&pair) || known.contains(&[second, first]) {
                let message = format!("`pairs` of `[clearance]` has `{}` and `{}` twice", names[0].text, names[1].text);
                let fault = Fault::new("scene::wrong_value", message, names[0].span).label("again");
                self.faults.push(fault.help("name each pair once"));
            }
            known.push(pair);
        }
        known
    }

    /// Is an outline written that has a fault of its own?
    fn writes_outline(&self, body: Option<BodyId>) -> bool {
        let written = |body: &Part| ["outline", "shape"].iter().any(|key| body.get(key).is_some());
        body.map_or(!self.scene.ground_outlines.is_empty(), |body| written(&self.scene.bodies[body.0]))
    }

    fn refuse_without_outline(&mut self, is_ground: bool, name: &Text) {
        let subject = format!("outline of {}", name.text);
        if self.is_reported(name, &subject) {
            return;
        }
        let (whose, help) = match is_ground {
            true => ("the ground has no outline".to_owned(), "[ground]".to_owned()),
            false => {
                (format!("body `{}` has neither an outline nor a shape", name.text), format!("[bodies.{}]", name.text))
            }
        };
        let message = format!("`pairs` of `[clearance]` needs distances from `{}`, but {whose}", name.text);
        let fault = Fault::new("scene::shape", message, name.span).label("no outline");
        let help =
            format!("give it one in `{help}`, such as `outline = {{ rod = [[0, 0], [0.2, 0]], width = \"20 mm\" }}`");
        self.faults.push_about(&subject, fault.help(help));
    }
}
