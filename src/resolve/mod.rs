//! Scene to [`Mechanism`]: names become indices, units become SI, texts become formulas.
//!
//! A fault does not stop the work: a formula that cannot be resolved stands as "not a number" in the unfinished
//! mechanism, which is not returned, and checks of its value pass.

mod bodies;
mod calculated;
mod context;
mod contours;
mod courses;
mod efforts;
mod engaging;
mod formulas;
mod initial;
mod instants;
mod islands;
mod laws;
pub mod loosened;
mod names;
mod order;
mod outlines;
mod outputs;
mod parameters;
mod parts;
mod placed;
mod places;
mod requested;
mod reuse;
mod settings;
mod shapes;
mod signals;
mod states;
pub mod symbolic;
mod tables;
mod transfers;
mod variables;

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

use self::names::SceneNames;
use crate::component::{ALL, Room, Section};
use crate::diagnostic::fault::{Fault, Faults, Sink};
use crate::diagnostic::span::{Source, Span, Text};
use crate::diagnostic::suggest;
use crate::model::{
    Bound, Dimension, DiscreteId, Exponents, Formula, InputId, Mechanism, Output, Owner, Place, RateChange, StateId,
    Unit, Units, Variable,
};
use crate::scene::Requested;
use crate::scene::model::Within;
use crate::scene::{Resolved, Scene};

#[cfg(test)]
pub(crate) use context::formula_of_numbers;

impl Scene {
    /// Reads a scene from a text with a name for the messages. A scene with a fault in its form is resolved all the
    /// same, as far as it goes, so that all faults are reported at once.
    ///
    /// # Errors
    /// Everything that is wrong with its form.
    pub fn from_source(source: Source, json: bool) -> Result<Scene, Faults> {
        let mut faults = Sink::default();
        let Some(mut scene) = Scene::decode(source.own_text(), json, 0, false, &mut faults) else {
            return Err(faults.into_faults(source));
        };
        scene.source = source;
        let path = PathBuf::from(&scene.source.name);
        reuse::find_files(&mut scene, &path);
        let complete = reuse::put_in(&mut scene, &mut faults);
        tables::append(&mut scene);
        if faults.has_errors() {
            // What a missing part has is not known.
            if complete {
                scene.resolve_into(&Requested::Own, &mut faults);
            }
            return Err(faults.into_faults(scene.source));
        }
        Ok(scene)
    }

    /// Resolves names, units and expressions. All faults that can be found without formulating equations are reported
    /// at once.
    ///
    /// # Errors
    /// All of them.
    pub fn resolve(&self) -> Result<Resolved, Faults> {
        self.resolve_asking(&Requested::Own)
    }

    /// As [`Scene::resolve`], with the outputs that are asked for.
    ///
    /// # Errors
    /// All faults; an output that there is not among them.
    pub fn resolve_asking(&self, requested: &Requested) -> Result<Resolved, Faults> {
        let mut faults = Sink::default();
        let (mechanism, outputs) = self.resolve_into(requested, &mut faults);
        if faults.has_errors() {
            return Err(faults.into_faults(self.source.clone()));
        }
        Ok(Resolved { mechanism, outputs, warnings: faults.into_list() })
    }

    /// The mechanism and what is asked of it, as far as they can be resolved; complete if there are no errors.
    fn resolve_into(&self, requested: &Requested, faults: &mut Sink) -> (Mechanism, Vec<Output>) {
        let names = SceneNames::collect(self, faults);
        let mut resolver = Resolver::new(self, names, faults);
        resolver.name();
        let display = resolver.display();
        let (parameters, calculated) = resolver.parameters();
        let inputs = resolver.inputs();
        let mut discrete = resolver.declare_discrete();
        let states = resolver.declare_states();
        resolver.place_parts();
        resolver.signals(&mut discrete);
        let samplers = resolver.samplers(&mut discrete);
        let ground = resolver.ground();
        let mut mechanism = Mechanism {
            name: self.name.text.clone(),
            description: self.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
            credits: self.credits.clone(),
            dimension: self.dimension,
            gravity: resolver.gravity(),
            parameters,
            calculated,
            inputs,
            ground_outlines: resolver.ground_outlines(&ground),
            ground,
            bodies: resolver.bodies(),
            joints: resolver.parts(Section::Joints),
            drivers: resolver.parts(Section::Drivers),
            loads: resolver.loads(),
            discrete,
            states: resolver.states(states),
            samplers,
            events: resolver.events(),
            contacts: Vec::new(),
            engaging: Vec::new(),
            set_rates: Vec::new(),
            initial: resolver.initial(),
            begins: resolver.begins(),
            experiment: resolver.experiment(),
            solver: resolver.solver(),
            coordinates: resolver.coordinates(),
            clearance: None,
            // After all keys have been read.
            bounds: std::mem::take(&mut resolver.bounds),
            units: Units::default(),
            display,
        };
        mechanism.clearance = resolver.clearance(&mechanism);
        let outputs = resolver.outputs(requested);
        mechanism.add_own_states();
        mechanism.engaging = resolver.engaging(&mechanism.joints, &mechanism.discrete);
        if !resolver.incomplete && !resolver.faults.has_errors() {
            mechanism.add_engaging(&std::mem::take(&mut resolver.set_rates));
        }
        mechanism.add_courses();
        mechanism.add_contacts();
        mechanism.units = mechanism.display.clone().before(&resolver.written_in);
        resolver.islands(&mechanism.bodies);
        if !resolver.faults.has_errors() {
            // What only the outputs of the scene use is of use, whatever else is asked for.
            if !matches!(requested, Requested::These(_)) {
                resolver.unused();
            }
            mechanism.check().into_iter().for_each(|fault| resolver.faults.push(fault));
        }
        (mechanism, outputs)
    }
}

struct Resolver<'s> {
    scene: &'s Scene,
    names: SceneNames<'s>,
    faults: &'s mut Sink,
    /// Has a joint, driver or load been left out because of its faults?
    incomplete: bool,
    /// Values that parameters can move out of their ranges.
    bounds: Vec<Bound>,
    /// The values of the parameters that have their own.
    values: Vec<f64>,
    /// Of all parameters of the scene.
    parameters: Vec<calculated::Meaning>,
    /// The units of the inputs, each with how many of its seconds are written as hertz.
    input_units: Vec<Option<(Exponents, i8)>>,
    /// The units of the states, in the same way.
    state_units: Vec<Option<(Exponents, i8)>>,
    /// The units that states have, by themselves or by their starts.
    declared_state_units: Vec<Option<Unit>>,
    /// The units of the discrete variables, in the same way.
    discrete_units: Vec<Option<(Exponents, i8)>>,
    /// The units that sampled values are given.
    declared_units: HashMap<DiscreteId, Unit>,
    /// The rates that each event sets, with their values.
    set_rates: Vec<Vec<RateChange>>,
    /// Next values of sampled values.
    nexts: instants::Nexts,
    /// What the names of the signals stand for; none if one is at fault.
    signals: Vec<Option<signals::ResolvedSignal>>,
    /// What signals with a type bring.
    transfers: transfers::Transfers<'s>,
    /// The inputs that something follows or depends on.
    used_inputs: HashSet<InputId>,
    /// The discrete variables that something depends on.
    used_discrete: HashSet<DiscreteId>,
    /// The states that something uses.
    used_states: HashSet<StateId>,
    /// The signals that something uses.
    used_signals: HashSet<usize>,
    /// The parameters that something uses.
    used_parameters: HashSet<usize>,
    /// The points of the ground that something uses.
    used_ground: HashSet<usize>,
    /// How the scene calls the variables that it names.
    called: HashMap<Variable, String>,
    /// The first unit of each kind of value in the scene.
    written_in: Units,
    /// The tables that expressions use, by their files; none if one is at fault.
    tables: HashMap<String, Option<Rc<tables::Table>>>,
    /// Where the scene itself is, and then its parts.
    placements: Vec<placed::Placement>,
    /// Whose text is read.
    part: Within,
}

const UNKNOWN: Formula = Formula::Number(f64::NAN);

impl<'s> Resolver<'s> {
    fn new(scene: &'s Scene, names: SceneNames<'s>, faults: &'s mut Sink) -> Self {
        Resolver {
            scene,
            names,
            faults,
            incomplete: false,
            bounds: Vec::new(),
            values: Vec::new(),
            parameters: Vec::new(),
            input_units: Vec::new(),
            state_units: Vec::new(),
            declared_state_units: Vec::new(),
            discrete_units: Vec::new(),
            declared_units: HashMap::new(),
            set_rates: Vec::new(),
            nexts: instants::Nexts::default(),
            signals: Vec::new(),
            transfers: transfers::Transfers::default(),
            used_inputs: HashSet::new(),
            used_discrete: HashSet::new(),
            used_states: HashSet::new(),
            used_signals: HashSet::new(),
            used_parameters: HashSet::new(),
            used_ground: HashSet::new(),
            called: HashMap::new(),
            written_in: Units::default(),
            tables: HashMap::new(),
            placements: vec![placed::Placement::default()],
            part: 0,
        }
    }
}

impl Resolver<'_> {
    fn name(&mut self) {
        if self.scene.name.text.trim().is_empty() {
            self.faults.push(
                Fault::new("scene::missing_key", "the scene's name is empty", self.scene.name.span)
                    .label("empty")
                    .help("give the name of the FMU: `name = \"my_mechanism\"`"),
            );
        }
    }

    /// Is this use of a name no further fault, because one has been reported about the name or about `subject`?
    fn is_reported(&mut self, name: &Text, subject: &str) -> bool {
        self.names.is_broken(&name.text) || self.faults.again(subject, name.span)
    }

    /// Warns of what is there by name and changes nothing: it may have been forgotten elsewhere.
    fn unused(&mut self) {
        let scene = self.scene;
        let inputs = scene.inputs.iter().enumerate().filter(|(index, _)| !self.used_inputs.contains(&InputId(*index)));
        let states = scene.states.iter().enumerate().filter(|(index, _)| !self.used_states.contains(&StateId(*index)));
        let sampled = scene.sampled_values().filter(|(id, _)| !self.used_discrete.contains(id));
        let signals = scene.signals.iter().enumerate().filter(|(index, _)| !self.used_signals.contains(index));
        // What a part does not use here may be for its own outputs and its own experiment.
        let is_own = |name: &Text| name.span.end <= scene.source.own_text().len();
        let parameters = scene.parameters.iter().enumerate();
        let parameters =
            parameters.filter(|(index, parameter)| !self.used_parameters.contains(index) && is_own(&parameter.name));
        let is_named = |index| {
            let place = Owner::Place(Place::Ground(index));
            self.used_ground.contains(&index) || self.called.keys().any(|variable| variable.owner == place)
        };
        let points = scene.ground.iter().enumerate().filter(|(index, point)| point.within == 0 && !is_named(*index));
        const LAW: &str = "use its name in a load, a driver or an output, or remove it";
        const VALUE: &str = "use it in an expression, or remove it";
        const POINT: &str = "connect a joint, a driver or a load to it, or remove it";
        let unused: Vec<(String, Span, &str)> = inputs
            .map(|(_, input)| (format!("input `{}`", input.name.text), input.name.span, LAW))
            .chain(states.map(|(_, state)| (format!("state `{}`", state.name.text), state.name.span, LAW)))
            .chain(
                sampled.map(|(_, sampled)| (format!("sampled value `{}`", sampled.name.text), sampled.name.span, LAW)),
            )
            .chain(signals.map(|(_, signal)| (format!("signal `{}`", signal.name.text), signal.name.span, LAW)))
            .chain(
                parameters
                    .map(|(_, parameter)| (format!("parameter `{}`", parameter.name.text), parameter.name.span, VALUE)),
            )
            .chain(points.map(|(_, point)| (format!("point `ground.{}`", point.name.text), point.name.span, POINT)))
            .collect();
        for (what, span, help) in unused {
            let fault = Fault::warning("scene::unused", format!("nothing uses {what}"), span).label("not used");
            self.faults.push(fault.help(help));
        }
    }

    fn one_dimensional(&self) -> bool {
        self.scene.dimension == Dimension::One
    }

    /// Refuses what turns in a scene of one dimension.
    fn must_not_turn(&mut self, what: &str, span: Span) {
        if self.one_dimensional() {
            self.faults.push(
                Fault::new(
                    "scene::one_dimension",
                    format!("{what} is a rotation, which one dimension does not have"),
                    span,
                )
                .label("not with `dimension = 1`")
                .help(format!("{}; for anything else remove `dimension = 1`", on_a_line())),
            );
        }
    }

    /// Refuses what needs two directions in a scene of one dimension.
    fn must_have_plane(&mut self, user: &str, span: Span) {
        if self.one_dimensional() {
            let message = format!("{user} needs two dimensions, but this scene has one");
            let help = format!("remove `dimension = 1`; {}", on_a_line());
            let fault = Fault::new("scene::one_dimension", message, span).label("not with `dimension = 1`");
            self.faults.push(fault.help(help));
        }
    }
}

fn on_a_line() -> String {
    let known = ALL.iter().filter(|component| component.room == Room::Line);
    let names: Vec<&str> = known.map(|component| component.name).collect();
    format!("in one dimension there are masses and {}", suggest::list(names))
}
