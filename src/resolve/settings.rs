//! Experiment, solver and coordinates.

use std::collections::HashSet;

use cotree_fmu::instance::TOLERANCES;

use super::Resolver;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::model::measure::{NUMBER, TIME, Wanted};
use crate::model::{CoordinateChoice, Experiment, Method, SolverSettings, Units};
use crate::scene::key::Form;
use crate::scene::quantity::Quantity;
use crate::scene::tables::DISPLAY;

/// Defaults.
const START: f64 = 0.0;
const DURATION: f64 = 10.0;
const STEPS: f64 = 1000.0;
const TOLERANCE: f64 = 1e-6;

/// More rows than this of an experiment are hardly meant.
const MOST_ROWS: f64 = 1e7;

impl Resolver<'_> {
    pub(super) fn experiment(&mut self) -> Experiment {
        let given = &self.scene.experiment;
        let start = self.setting(given.start.as_ref(), "`start` of `[experiment]`", &TIME).unwrap_or(START);
        let stop = self.setting(given.stop.as_ref(), "`stop` of `[experiment]`", &TIME).unwrap_or(start + DURATION);
        if stop <= start {
            let span = given.stop.as_ref().or(given.start.as_ref()).map_or(Span::default(), |stop| stop.span);
            self.faults.push(
                Fault::new(
                    "scene::experiment",
                    format!("the experiment stops at {stop} s, not after its start at {start} s"),
                    span,
                )
                .label("not after the start")
                .help("`stop` must be greater than `start`"),
            );
        }
        let step = self.positive(given.step.as_ref(), "`step` of `[experiment]`", &TIME);
        let tolerance = self.positive(given.tolerance.as_ref(), "`tolerance` of `[experiment]`", &NUMBER);
        let step = step.unwrap_or((stop - start) / STEPS);
        let rows = (stop - start) / step;
        if rows < 1.0 && rows > 0.0 {
            let span = given.step.as_ref().map_or(Span::default(), |step| step.span);
            let message =
                format!("`step` of `[experiment]` is {step} s, longer than the experiment from {start} s to {stop} s");
            let fault = Fault::warning("scene::experiment", message, span).label("longer than the experiment");
            self.faults.push(fault.help("only the start and the end are reported; give a shorter step"));
        }
        if rows > MOST_ROWS && step > 0.0 {
            let span = given.step.as_ref().or(given.stop.as_ref()).map_or(Span::default(), |step| step.span);
            let message = format!("the experiment has {rows:.0e} rows: {start} s to {stop} s in steps of {step} s");
            let fault = Fault::warning("scene::experiment", message, span).label("too many rows");
            self.faults
                .push(fault.help("make `step` longer or `stop` earlier; the solver chooses shorter steps itself"));
        }
        let tolerance = self.meaningful(tolerance.unwrap_or(TOLERANCE));
        Experiment { start, stop, step, tolerance }
    }

    /// The tolerance, or the nearest one that the solver takes.
    fn meaningful(&mut self, tolerance: f64) -> f64 {
        let nearest = tolerance.clamp(TOLERANCES[0], TOLERANCES[1]);
        if nearest != tolerance && tolerance > 0.0 {
            let span = self.scene.experiment.tolerance.as_ref().map_or(Span::default(), |quantity| quantity.span);
            let message = format!("`tolerance` of `[experiment]` is {tolerance:e}; {nearest:e} is used");
            let fault = Fault::warning("scene::experiment", message, span).label("out of the range of the solver");
            self.faults.push(fault.help(format!("give a value from {:e} to {}", TOLERANCES[0], TOLERANCES[1])));
        }
        nearest
    }

    /// The units of `[display]`.
    pub(super) fn display(&mut self) -> Units {
        let mut units = Units::default();
        for (key, name) in &self.scene.display {
            let Some(unit) = self.unit(Some(name)) else { continue };
            let form = DISPLAY.iter().find(|known| known.name == key.text).map(|key| key.form);
            if let Some(Form::UnitOf(wanted)) = form
                && wanted.exponents != Some(unit.exponents)
            {
                let message =
                    format!("`{}` of `[display]` is `{}`, which is not a unit of {}", key.text, name.text, wanted.what);
                let fault = Fault::new("scene::wrong_unit", message, name.span).label(format!("not {}", wanted.what));
                self.faults.push(fault.help(format!("give a unit such as `{}`", wanted.si)));
            }
            units.add(unit);
        }
        units
    }

    fn setting(&mut self, quantity: Option<&Quantity>, what: &str, wanted: &Wanted) -> Option<f64> {
        quantity.map(|quantity| self.number(quantity, what, wanted))
    }

    fn positive(&mut self, quantity: Option<&Quantity>, what: &str, wanted: &Wanted) -> Option<f64> {
        let value = self.setting(quantity, what, wanted)?;
        if value <= 0.0 {
            let span = quantity.map_or(Span::default(), |quantity| quantity.span);
            self.faults.push(
                Fault::new("scene::experiment", format!("{what} is {value}"), span).label("must be greater than zero"),
            );
        }
        Some(value)
    }

    pub(super) fn solver(&mut self) -> SolverSettings {
        let given = &self.scene.solver;
        SolverSettings {
            method: self.method(given.method.as_ref()),
            rtol: self.positive(given.rtol.as_ref(), "`rtol` of `[solver]`", &NUMBER),
            atol: self.positive(given.atol.as_ref(), "`atol` of `[solver]`", &NUMBER),
            max_step: self.positive(given.max_step.as_ref(), "`max_step` of `[solver]`", &TIME),
            time_budget: self.positive(given.time_budget.as_ref(), "`time_budget` of `[solver]`", &TIME),
        }
    }

    fn method(&mut self, name: Option<&Text>) -> Method {
        let Some(name) = name else {
            return Method::Auto;
        };
        match name.text.as_str() {
            "auto" => return Method::Auto,
            "explicit" => return Method::Explicit,
            "implicit" => return Method::Implicit,
            other => self.unknown_choice("solver method", other, &["auto", "explicit", "implicit"], name.span),
        }
        Method::Auto
    }

    pub(super) fn coordinates(&mut self) -> CoordinateChoice {
        let given = &self.scene.coordinates;
        let preset = given.preset.as_ref().map_or(CoordinateChoice::Recommended, |preset| self.preset(preset));
        let [t_span, r_span] = given.spans;
        let translation = given.translation.as_ref().map(|names| self.branches(names, "translation", t_span));
        let rotation = given.rotation.as_ref().map(|names| self.branches(names, "rotation", r_span));
        if let (true, Some(names)) = (self.one_dimensional(), &given.rotation) {
            let span = names.first().map_or(r_span, |name| name.span);
            self.must_not_turn("the tree `rotation` of `[coordinates]`", span);
        }
        if translation.is_none() && rotation.is_none() {
            return preset;
        }
        if let (Some(name), true) = (&given.preset, preset != CoordinateChoice::Recommended) {
            self.faults.push(
                Fault::new(
                    "scene::coordinates",
                    format!("`[coordinates]` has the preset `{}` and trees of its own", name.text),
                    name.span,
                )
                .label("one or the other")
                .help("remove `preset`, or remove `translation` and `rotation`"),
            );
        }
        CoordinateChoice::Chosen { translation, rotation }
    }

    fn preset(&mut self, name: &Text) -> CoordinateChoice {
        match name.text.as_str() {
            "recommended" => return CoordinateChoice::Recommended,
            "absolute" => return CoordinateChoice::Absolute,
            "joint" => return CoordinateChoice::Joint,
            // Kept by the format.
            "cheapest" => self.not_searched(name),
            other => self.unknown_choice("preset", other, &["recommended", "absolute", "joint"], name.span),
        }
        CoordinateChoice::Recommended
    }

    /// The search for trees that cost less than the recommended ones is gone: it gained 2.5 % in the mean.
    fn not_searched(&mut self, name: &Text) {
        let message = "`cheapest` is obsolete and means the recommended trees";
        let fault = Fault::warning("scene::coordinates", message, name.span).label("as `recommended`");
        self.faults.push(fault.help("remove `preset`"));
    }

    fn unknown_choice(&mut self, what: &str, name: &str, choices: &[&str], span: Span) {
        let otherwise = format!("the choices are {}", suggest::list(choices.iter().copied()));
        self.faults.push(
            Fault::new("scene::wrong_value", format!("there is no {what} `{name}`"), span)
                .label(format!("no such {what}"))
                .help(suggest::hint(name, choices.iter().copied(), otherwise)),
        );
    }

    /// Branches that the user names for a tree: bodies, joints, drivers and loads, each once.
    fn branches(&mut self, names: &[Text], tree: &str, span: Span) -> Vec<(String, Span)> {
        let mut seen = HashSet::new();
        if names.is_empty() && !(tree == "rotation" && self.one_dimensional()) {
            self.faults.push(
                Fault::new("scene::empty_tree", format!("the tree `{tree}` of `[coordinates]` has no branches"), span)
                    .label("nothing is listed")
                    .help(format!(
                        "list bodies, joints, drivers or loads, or remove `{tree}` for the recommended tree"
                    )),
            );
        }
        for name in names {
            let is_element = |named| !matches!(named, Named::Parameter(_) | Named::Input(_));
            if !self.names.get(&name.text).is_some_and(is_element) {
                self.unknown_branch(name, tree);
            } else if !seen.insert(&name.text) {
                let message = format!("`{}` is listed twice in `{tree}`", name.text);
                self.faults.push(
                    Fault::new("scene::duplicate_name", message, name.span).label("second time").help("remove it"),
                );
            }
        }
        names.iter().map(|name| (name.text.clone(), name.span)).collect()
    }

    fn unknown_branch(&mut self, name: &Text, tree: &str) {
        if self.is_reported(name, &name.text) {
            return;
        }
        if name.text == "ground" {
            let fault = Fault::new(
                "scene::ground_in_tree",
                "`ground` cannot be a branch: it is the root of every tree",
                name.span,
            );
            self.faults
                .push(fault.label("need not be named").help("remove it: name bodies, joints, drivers and loads only"));
            return;
        }
        if let Some((owner, _)) = name.text.split_once('.')
            && (owner == "ground" || self.names.get(owner).is_some_and(|named| matches!(named, Named::Body(_))))
        {
            let message = format!("`{}` is a rigid arm or a ground vector, which is always in the tree", name.text);
            let fault = Fault::new("scene::arm_in_tree", message, name.span).label("need not be named");
            self.faults.push(fault.help("remove it: name bodies, joints, drivers and loads only"));
            return;
        }
        let known = self.names.all(|named| !matches!(named, Named::Parameter(_) | Named::Input(_)));
        let otherwise = "name bodies, joints, drivers or loads of the scene".to_string();
        let help = suggest::hint(&name.text, known, otherwise);
        let message = format!("the tree `{tree}` names an element that is not in the scene: `{}`", name.text);
        self.faults.push_about(
            &name.text,
            Fault::new("scene::unknown_element", message, name.span).label("no such element").help(help),
        );
    }
}
