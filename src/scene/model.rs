//! The scene as it is written: names are texts, numbers may be units or expressions.

use super::document::DocumentNode;
use super::part::Part;
use super::quantity::Quantity;
use crate::diagnostic::span::{Source, Span, Text};
use crate::model::{Credits, Dimension};

/// A mechanism as the user describes it: the scene file in Rust, field by field.
///
/// ```
/// use cotree::scene::{Body, Load, Scene};
///
/// let scene = Scene::new("slider_crank")
///     .gravity([0.0, -9.81])
///     .parameter("crank_length", "0.5 m")
///     .input("gas_force", "0 N")
///     .ground_point("bearing", [0.0, 0.0])
///     .ground_point("guide", [0.0, 0.0])
///     .body(
///         "crank",
///         Body::new()
///             .mass(2.0)
///             .inertia("0.0416667 kg.m2")
///             .point("inner", ("-crank_length/2", 0))
///             .point("outer", ("crank_length/2", 0)),
///     )
///     .body("rod", Body::new().mass(3.0).inertia(0.5625).point("big_end", [-0.75, 0.0]).point("small_end", [0.75, 0.0]))
///     .body("slider", Body::new().mass(1.0))
///     .revolute("main_bearing", "ground.bearing", "crank.inner")
///     .revolute("crank_pin", "crank.outer", "rod.big_end")
///     .revolute("wrist_pin", "rod.small_end", "slider")
///     .prismatic("cylinder", "ground.guide", "slider", [1, 0])
///     .load("gas", Load::force("slider", ("-gas_force", 0)))
///     .initial("crank.angle", "0.6 rad")
///     .guess("rod.angle", "-0.19 rad")
///     .output("crank.angle")
///     .stop("10 s");
///
/// let mechanism = scene.resolve()?.mechanism;
/// assert_eq!(mechanism.bodies.len(), 3);
/// # Ok::<(), cotree::scene::Faults>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The name, of the FMU too.
    pub name: Text,
    /// One line about it.
    pub description: Option<Text>,
    /// Who made it, and how it may be used.
    pub credits: Credits,
    /// Plane or line.
    pub dimension: Dimension,
    /// Acceleration of gravity [m/s2]; none if absent.
    pub gravity: Option<Vector>,
    /// Become FMU parameters.
    pub parameters: Vec<Parameter>,
    /// Become FMU inputs.
    pub inputs: Vec<Input>,
    /// Quantities whose rates are given.
    pub states: Vec<State>,
    /// Values that change at ticks only.
    pub sampled: Vec<Sampled>,
    /// What happens when a comparison begins to hold.
    pub events: Vec<Event>,
    /// Laws that others use by their names.
    pub signals: Vec<Signal>,
    /// Points of the ground.
    pub ground: Vec<Point>,
    /// Outlines of the ground: that of the scene, and those of its parts.
    pub(crate) ground_outlines: Vec<GroundOutline>,
    /// Rigid bodies.
    pub bodies: Vec<Part>,
    /// Joints.
    pub joints: Vec<Part>,
    /// Prescribed motions.
    pub drivers: Vec<Part>,
    /// Forces, torques, springs, actuators.
    pub loads: Vec<Part>,
    /// Known and guessed initial values.
    pub initial: Vec<Initial>,
    /// What is reported.
    pub outputs: Outputs,
    /// Default experiment.
    pub experiment: Experiment,
    /// Solver settings.
    pub solver: Solver,
    /// Choice of trees.
    pub coordinates: Coordinates,
    /// What is reported of distances between outlines.
    pub clearance: Option<Clearance>,
    /// Units that results are shown in, such as `deg`, `mm`, `kN`, each with the key that names it.
    pub display: Vec<(Text, Text)>,
    /// The text that it was read from.
    pub source: Source,
    /// Names of what could not be read: they exist, so that their uses are no further faults.
    pub(crate) broken: Vec<String>,
    /// Files whose mechanisms are parts of it, and of these parts.
    pub(crate) uses: Vec<Use>,
}

/// A file whose mechanism is a part of the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Use {
    /// Its names begin with this one.
    pub name: Text,
    /// Its path as it is written.
    pub file: Text,
    /// New values of its parameters.
    pub parameters: Vec<(Text, Quantity)>,
    /// The body that its ground is fixed to; the ground if absent.
    pub on: Option<Text>,
    /// Where its origin is \[m\].
    pub at: Option<Vector>,
    /// By how much it is turned \[rad\].
    pub angle: Option<Quantity>,
    /// Are its left and right exchanged?
    pub mirror: bool,
    /// How its texts could name its origin: `ground`, or a point that is there.
    pub origin: Text,
    /// Whose part it is.
    pub within: Within,
}

/// Whose text something is written in: that of a part, by its place among the uses of the scene from 1 on, or that of the scene itself.
pub(crate) type Within = usize;

/// Components along x and y; x alone in one dimension.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vector {
    /// One or two components.
    pub components: Vec<Quantity>,
    /// Where it is written.
    pub span: Span,
}

/// A named parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameter {
    /// The name.
    pub name: Text,
    /// Default value; may be an expression of other parameters.
    pub value: Quantity,
    /// Unit of bare numbers.
    pub unit: Option<Text>,
    /// One line.
    pub description: Option<Text>,
    /// Smallest value.
    pub min: Option<Quantity>,
    /// Largest value.
    pub max: Option<Quantity>,
    /// May it change after initialisation?
    pub tunable: bool,
}

/// A named input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Input {
    /// The name.
    pub name: Text,
    /// Value until it is set; zero if absent.
    pub start: Option<Quantity>,
    /// Unit of bare numbers.
    pub unit: Option<Text>,
    /// One line.
    pub description: Option<Text>,
    /// Smallest value.
    pub min: Option<Quantity>,
    /// Largest value.
    pub max: Option<Quantity>,
}

/// A quantity whose rate is given: a current, a pressure, the integral of a controller.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The name.
    pub name: Text,
    /// Value at the start; zero if absent.
    pub start: Option<Quantity>,
    /// Its rate, in SI units.
    pub rate: Quantity,
    /// Its usual size; that of its start, or 1, if absent.
    pub nominal: Option<Quantity>,
    /// Unit of bare numbers.
    pub unit: Option<Text>,
    /// One line.
    pub description: Option<Text>,
    /// Whose it is.
    pub(crate) within: Within,
}

/// Values that are sampled together: they change at ticks and are constant in between.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// The name.
    pub name: Text,
    /// From tick to tick \[s\].
    pub period: Quantity,
    /// The first tick \[s\]; zero if absent.
    pub offset: Option<Quantity>,
    /// What is sampled.
    pub values: Vec<SampledValue>,
    /// Whose it is.
    pub(crate) within: Within,
}

/// A value that changes at ticks only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledValue {
    /// The name.
    pub name: Text,
    /// Its value at the start, before the first tick; zero if absent.
    pub start: Option<Quantity>,
    /// Its value from a tick on, seen from just before it; as it was if absent.
    pub next: Option<Quantity>,
    /// Its unit, that of bare numbers.
    pub unit: Option<Text>,
    /// One line.
    pub description: Option<Text>,
}

/// What happens when a comparison begins to hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Event {
    /// The name.
    pub name: Text,
    /// The comparison, such as `beam.angle > 0.7`.
    pub when: Text,
    /// Joints, drivers and loads that are there no longer.
    pub remove: Vec<Text>,
    /// Joints that engage.
    pub engage: Vec<Text>,
    /// Joints that are released, and may engage again.
    pub release: Vec<Text>,
    /// New values of sampled values, states and rates.
    pub set: Vec<(Text, Quantity)>,
    /// True if the event ends the run.
    pub stop: bool,
    /// True if the event happens once only.
    pub once: bool,
    /// One line.
    pub description: Option<Text>,
    /// Whose it is.
    pub(crate) within: Within,
}

/// An expression with a name: a law that is written once, or an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// The name.
    pub name: Text,
    /// The expression, in SI units.
    pub value: Quantity,
    /// The unit that it is shown in; without one what its variables make of it.
    pub unit: Option<Text>,
    /// One line; without one the expression.
    pub description: Option<Text>,
    /// The keys of one with a type, such as a filter; it has no value then.
    pub(crate) part: Option<Part>,
    /// Whose law it is.
    pub(crate) within: Within,
}

/// A named point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The name within its body.
    pub name: Text,
    /// Where it is in the body's frame \[m\].
    pub at: Vector,
    /// In whose ground that is.
    pub(crate) within: Within,
}

/// An outline of the ground as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroundOutline {
    pub node: DocumentNode,
    /// In whose ground that is.
    pub within: Within,
}

/// What is reported of distances between outlines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearance {
    /// Pairs of bodies or of a body and the ground; all that share no joint if absent.
    pub pairs: Option<Vec<[Text; 2]>>,
    /// The least distance that is permitted \[m\].
    pub least: Option<Quantity>,
}

/// A scalar motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A function of time, parameters and inputs.
    Given(Quantity),
    /// An FMU input.
    Follows {
        /// Its name.
        input: Text,
        /// What it is of the motion.
        r#as: InputAs,
    },
}

/// What an input is of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputAs {
    /// The motion itself.
    Position,
    /// Its rate.
    Velocity,
    /// The rate of its rate.
    Acceleration,
}

/// An initial value.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Such as `crank.angle`.
    pub variable: Text,
    /// Its value.
    pub value: Quantity,
    /// Known, or a guess?
    pub known: bool,
    /// Who gives it.
    pub(crate) within: Within,
}

/// What is reported.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Variables of the scene.
    pub variables: Vec<Text>,
    /// Expressions that are reported under names of their own.
    pub expressions: Vec<Signal>,
}

/// Default experiment; what is absent is start 0 s, stop 10 s after the start, a thousand steps, tolerance 1e-6.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Experiment {
    /// \[s\]
    pub start: Option<Quantity>,
    /// \[s\]
    pub stop: Option<Quantity>,
    /// Communication step \[s\].
    pub step: Option<Quantity>,
    /// Relative tolerance.
    pub tolerance: Option<Quantity>,
}

/// Solver settings; cotree chooses what is absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solver {
    /// `auto` or `explicit`.
    pub method: Option<Text>,
    /// Relative tolerance.
    pub rtol: Option<Quantity>,
    /// Absolute tolerance.
    pub atol: Option<Quantity>,
    /// Longest step \[s\].
    pub max_step: Option<Quantity>,
    /// Longest time that the computer may take for a communication step \[s\].
    pub time_budget: Option<Quantity>,
}

/// Choice of trees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coordinates {
    /// `recommended`, `absolute` or `joint`.
    pub preset: Option<Text>,
    /// Branches of the translational tree.
    pub translation: Option<Vec<Text>>,
    /// Branches of the rotational tree.
    pub rotation: Option<Vec<Text>>,
    /// Where both lists are written.
    pub spans: [Span; 2],
}
