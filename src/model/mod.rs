//! The scene with every name resolved, every unit converted and every expression parsed: what the equations are built from.
//!
//! Numbers are SI; points are relative to the mass centre of their body. A [`Mechanism`] has no faults left that can be
//! found without formulating equations.

mod body;
mod bound;
mod clearance;
mod contact;
mod contour;
mod course;
mod discrete;
mod display;
mod edit;
mod engaging;
mod exponents;
mod formula;
mod friction;
mod instants;
pub(crate) mod measure;
mod name;
mod part;
mod settings;
mod state;
pub(crate) mod translate;

mod unit;
mod variable;
mod written;

pub use body::{Body, Outline, Place, Point};
pub use bound::{Bound, Range};
pub use clearance::Clearance;
pub use contact::{Contact, ContactVariables, GapLaw, Limits};
pub use contour::{Contour, ContourCorner, Feature, FeatureJoint, Flaw};
pub use course::{Course, CourseValue, Pulley, Station};
pub use discrete::{Discrete, DiscreteKind};
pub use display::Units;
pub use engaging::{Captured, Engaging, SetRate};
pub(crate) use engaging::{RateChange, relative_angle, turned_apart};
pub use exponents::Exponents;
pub use formula::{Comparison, Formula};
pub use friction::{Friction, Pressed, Slip};
pub use instants::{Event, Sampler};
pub use name::identifier;
pub use part::{KeyValue, Motion, Part};
pub use settings::{CoordinateChoice, Experiment, Method, SolverSettings};
pub use state::State;
pub use unit::{Calculated, DisplayUnit, Input, Parameter, Unit, ValueError};
pub use variable::{Aspect, Axis, Class, ContactQuantity, Effort, Owner, Quantity, Variable, Whole};

use crate::diagnostic::{Span, suggest};

/// Declares an index type: `BodyId(3)` indexes `Mechanism::bodies`.
macro_rules! index {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub usize);
    )*};
}

index! {
    /// Index of a parameter.
    ParameterId,
    /// Index of an input.
    InputId,
    /// Index of a discrete variable.
    DiscreteId,
    /// Index of a state.
    StateId,
    /// Index of a body.
    BodyId,
    /// Index of a joint.
    JointId,
    /// Index of a driver.
    DriverId,
    /// Index of a load.
    LoadId,
}

/// What a scene may say of its origin and of its use; FMI has attributes of these names.
pub const CREDITS: [&str; 4] = ["author", "version", "license", "copyright"];

/// Those of [`CREDITS`] that are given, with their texts.
pub type Credits = Vec<(&'static str, String)>;

/// A resolved scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    /// The scene's name.
    pub name: String,
    /// One line about it; may be empty.
    pub description: String,
    /// Who made it, and how it may be used.
    pub credits: Credits,
    pub dimension: Dimension,
    /// Acceleration of gravity [m/s2]; constants and parameters only.
    pub gravity: [Formula; 2],
    /// Become FMU parameters.
    pub parameters: Vec<Parameter>,
    /// Become calculated parameters of the FMU.
    pub calculated: Vec<Calculated>,
    /// Become FMU inputs.
    pub inputs: Vec<Input>,
    /// What sample times, events and contacts change: those of the scene, then those of contacts.
    pub discrete: Vec<Discrete>,
    /// States of its own: quantities whose rates are given.
    pub states: Vec<State>,
    /// When discrete variables are sampled.
    pub samplers: Vec<Sampler>,
    /// What happens when comparisons begin to hold.
    pub events: Vec<Event>,
    /// What parts hold on one side only.
    pub contacts: Vec<Contact>,
    /// Joints that events engage.
    pub engaging: Vec<Engaging>,
    /// Rates that events set.
    pub set_rates: Vec<SetRate>,
    /// Points of the ground.
    pub ground: Vec<Point>,
    /// Outlines of the ground.
    pub ground_outlines: Vec<Outline>,
    pub bodies: Vec<Body>,
    pub joints: Vec<Part>,
    /// Prescribed motions.
    pub drivers: Vec<Part>,
    /// Forces, torques, springs, actuators.
    pub loads: Vec<Part>,
    /// Known and guessed initial values.
    pub initial: Vec<Initial>,
    /// Where positions that `[initial]` does not mention are looked for, if not at zero.
    pub begins: Vec<Initial>,
    pub experiment: Experiment,
    pub solver: SolverSettings,
    pub coordinates: CoordinateChoice,
    /// The distances between outlines that are of interest, if any are.
    pub clearance: Option<Clearance>,
    /// Values of keys that parameters can move out of their ranges.
    pub bounds: Vec<Bound>,
    /// The units to show values in: those that the scene asks for, then those that it is written in.
    pub units: Units,
    /// The units that the scene asks for.
    pub display: Units,
}

/// A parameter that cannot be set, because it is calculated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` cannot be set: it is calculated as `{formula}`; set {used}, or give `{name}` a number in the scene")]
pub struct CalculatedError {
    /// The parameter.
    pub name: String,
    /// How it is calculated.
    pub formula: String,
    /// The parameters of which it is calculated.
    pub used: String,
}

impl Mechanism {
    /// The parameters' default values, SI.
    pub fn parameter_values(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// Why a parameter cannot be set, if it is one that is calculated.
    pub fn why_calculated(&self, name: &str) -> Option<CalculatedError> {
        let Calculated { formula, .. } = self.calculated.iter().find(|calculated| calculated.parameter.name == name)?;
        let mut used: Vec<&str> = Vec::new();
        formula.visit_parameters(&mut |id| used.push(&self.parameters[id.0].name));
        used.sort_unstable();
        used.dedup();
        let formula = self.written(formula);
        Some(CalculatedError { name: name.to_owned(), formula, used: suggest::list(used) })
    }

    /// All joints, drivers and loads, in this order.
    pub fn parts(&self) -> impl Iterator<Item = &Part> {
        self.joints.iter().chain(&self.drivers).chain(&self.loads)
    }
}

/// How many directions there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Masses on a line: x only, no rotation.
    One,
    /// The plane.
    Two,
}

/// A line of `[initial]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// A position or velocity of a body, a revolute or a prismatic joint (or a spring's length in one dimension).
    pub variable: Variable,
    /// Its value; constants and parameters only.
    pub value: Formula,
    /// The unit that it is written in, if not SI.
    pub display: Option<DisplayUnit>,
    /// Known, or a guess?
    pub known: bool,
    /// Where it stands in the file.
    pub span: Span,
}

/// A reported value.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The name of the variable, or the user's key for an expression.
    pub name: String,
    /// One line.
    pub description: String,
    /// Its unit; the empty unit if it is not known.
    pub unit: Unit,
    /// Is its unit unknown, because something in its expression has none?
    pub is_open: bool,
    /// Its value: any variable of the naming table may occur.
    pub value: Formula,
    /// Where it stands in the file.
    pub span: Span,
}
