//! Initial values, outputs, experiment, solver and coordinates.

use super::Decoder;
use super::fields::{Fields, wrong_type};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::{Form, Key, names};
use crate::scene::model::{Clearance, Coordinates, Experiment, Initial, Outputs, Scene, Solver};
use crate::scene::tables::{CLEARANCE, COORDINATES, DISPLAY, EXPERIMENT, GUESS, OUTPUTS, SOLVER};

impl Decoder {
    pub(super) fn settings(&mut self, top: &Fields<'_>, scene: &mut Scene) {
        if let Some(node) = top.get("initial")
            && let Some(entries) = self.faults.entries(node, "`initial`")
        {
            for (key, node) in entries {
                self.initial(key.clone(), node, &mut scene.initial);
            }
        }
        if let Some(node) = top.get("outputs") {
            scene.outputs = self.outputs(node);
        }
        if let Some(fields) = self.table(top, "experiment", EXPERIMENT) {
            scene.experiment = Experiment {
                start: self.faults.optional_quantity(&fields, "start"),
                stop: self.faults.optional_quantity(&fields, "stop"),
                step: self.faults.optional_quantity(&fields, "step"),
                tolerance: self.faults.optional_quantity(&fields, "tolerance"),
            };
        }
        if let Some(fields) = self.table(top, "clearance", CLEARANCE) {
            scene.clearance = Some(self.clearance(&fields));
        }
        if let Some(fields) = self.table(top, "display", DISPLAY) {
            scene.display = self.display(&fields);
        }
        if let Some(fields) = self.table(top, "solver", SOLVER) {
            scene.solver = Solver {
                method: self.faults.optional_text(&fields, "method"),
                rtol: self.faults.optional_quantity(&fields, "rtol"),
                atol: self.faults.optional_quantity(&fields, "atol"),
                max_step: self.faults.optional_quantity(&fields, "max_step"),
                time_budget: self.faults.optional_quantity(&fields, "time_budget"),
            };
        }
        if let Some(fields) = self.table(top, "coordinates", COORDINATES) {
            let mut tree = |key| fields.get(key).and_then(|node| self.faults.texts(node, &fields.name_of(key)));
            let (translation, rotation) = (tree("translation"), tree("rotation"));
            let preset = self.faults.optional_text(&fields, "preset");
            let spans = ["translation", "rotation"].map(|key| fields.key_span(key).unwrap_or_default());
            scene.coordinates = Coordinates { preset, translation, rotation, spans };
        }
    }

    fn clearance(&mut self, fields: &Fields<'_>) -> Clearance {
        let least = self.faults.optional_quantity(fields, "least");
        let Some(node) = fields.get("pairs") else { return Clearance { pairs: None, least } };
        let what = fields.name_of("pairs");
        let Content::Array(items) = &node.kind else {
            let fault = wrong_type(node, &what, "a list of pairs");
            self.faults.push(fault.help("write `pairs = [[\"BODY\", \"ground\"]]`"));
            return Clearance { pairs: Some(Vec::new()), least };
        };
        let each = format!("an entry of {what}");
        let help = "name two bodies, or a body and `ground`: `[\"BODY\", \"ground\"]`";
        let pairs = items.iter().filter_map(|item| self.faults.pair(item, &each, help)).collect();
        Clearance { pairs: Some(pairs), least }
    }

    /// The units of `[display]`, each with its key.
    fn display(&mut self, fields: &Fields<'_>) -> Vec<(Text, Text)> {
        let mut units = Vec::new();
        for key in DISPLAY {
            let Some((node, span)) = fields.get(key.name).zip(fields.key_span(key.name)) else { continue };
            let what = fields.name_of(key.name);
            let named = match key.form {
                Form::Names => self.faults.texts(node, &what).unwrap_or_default(),
                _ => self.faults.text(node, &what).into_iter().collect(),
            };
            units.extend(named.into_iter().map(|unit| (Text::new(key.name, span), unit)));
        }
        units
    }

    fn table<'n>(&mut self, top: &Fields<'n>, key: &str, keys: &[Key]) -> Option<Fields<'n>> {
        let (node, span) = (top.get(key)?, top.key_span(key)?);
        Fields::open(node, &format!("`[{key}]`"), span, &names(keys), &mut self.faults)
    }

    /// A value, a guess, or a table of them: TOML reads the key `crank.angle` without quotes as `angle` in `crank`.
    fn initial(&mut self, key: Text, node: &DocumentNode, values: &mut Vec<Initial>) {
        let what = format!("the initial value of `{}`", key.text);
        let Content::Table(entries) = &node.kind else {
            if let Some(value) = self.faults.quantity(node, &what) {
                values.push(Initial { variable: key, value, known: true, within: 0 });
            }
            return;
        };
        if entries.iter().all(|(inner, _)| inner.text != "guess") {
            for (inner, node) in entries {
                let name = format!("{}.{}", key.text, inner.text);
                self.initial(Text::new(name, inner.span), node, values);
            }
            return;
        }
        if let Some(fields) = Fields::open(node, &what, key.span, &names(GUESS), &mut self.faults)
            && let Some(value) = self.faults.optional_quantity(&fields, "guess")
        {
            values.push(Initial { variable: key, value, known: false, within: 0 });
        }
    }

    fn outputs(&mut self, node: &DocumentNode) -> Outputs {
        let mut outputs = Outputs::default();
        let Some(entries) = self.faults.entries(node, "`outputs`") else {
            return outputs;
        };
        for (key, node) in entries {
            let is_list = matches!(node.kind, Content::Array(_));
            let nearly = is_list && suggest::nearest(&key.text, [OUTPUTS[0].name]).is_some();
            if nearly && key.text != OUTPUTS[0].name {
                let message = format!("`[outputs]` has no list `{}`", key.text);
                let fault = Fault::new("scene::unknown_key", message, key.span).label("unknown key");
                self.faults.push(fault.help(format!("did you mean `{}`?", OUTPUTS[0].name)));
            }
            if nearly || key.text == OUTPUTS[0].name {
                outputs.variables = self.faults.texts(node, "`variables` of `[outputs]`").unwrap_or_default();
            } else {
                outputs.expressions.extend(self.signal(key, node, &format!("output `{}`", key.text)));
            }
        }
        outputs
    }
}
