//! The tables of a scene that are no components: every key is written here once, with its unit and what it says.

use super::key::{Form, Key};
use crate::model::Range;
use crate::model::measure::{
    ACCELERATION, ANGLE, ANGULAR_VELOCITY, ANYTHING, ENERGY, FORCE, LENGTH, NUMBER, POWER, TIME, TORQUE, VELOCITY,
    Wanted,
};

/// The top of a scene.
pub(crate) const SCENE: &[Key] = &[
    Key::default("format", Form::Constant(NUMBER, Range::Any), "the version of the format", "1, the only one"),
    Key::required("name", Form::Text, "the name, also of the FMU", "`name = \"my_mechanism\"`"),
    Key::default("description", Form::Text, "one line about the mechanism", "none"),
    Key::default(
        "author",
        Form::Text,
        "the author; written into the description of the FMU, as are `version`, `license` and `copyright`",
        "none",
    ),
    Key::default("version", Form::Text, "the version of the model", "none"),
    Key::default("license", Form::Text, "the licence of the model", "none"),
    Key::default("copyright", Form::Text, "the owner of the rights, with the year", "none"),
    Key::default(
        "dimension",
        Form::Constant(NUMBER, Range::Any),
        "2 for a planar mechanism; 1 for masses on a line",
        "2",
    ),
    Key::default("gravity", Form::ConstantVector(ACCELERATION), "the acceleration of gravity", "none"),
    Key::default("parameters", Form::Table, "[named constants](#parameters) that become parameters of the FMU", "none"),
    Key::default("inputs", Form::Table, "[named inputs](#inputs) of the FMU", "none"),
    Key::default(
        "states",
        Form::Table,
        "[state variables](#states), whose rates are given: currents, pressures, integrals",
        "none",
    ),
    Key::default(
        "sampled",
        Form::Table,
        "[discrete variables](#sampled), which change at sample times only: digital controllers, counters",
        "none",
    ),
    Key::default("events", Form::Table, "[state events](#events): what happens when a comparison becomes true", "none"),
    Key::default(
        "signals",
        Form::Table,
        "[signals](#signals): laws that others use by name, controllers, filters",
        "none",
    ),
    Key::default("ground", Form::Table, "[points of the ground](#ground)", "none"),
    Key::default("bodies", Form::Table, "the [bodies](#bodies)", "none"),
    Key::default("joints", Form::Table, "the [joints](#joints)", "none"),
    Key::default("drivers", Form::Table, "[prescribed motions](#drivers)", "none"),
    Key::default("loads", Form::Table, "[forces, torques, springs and dampers](#loads)", "none"),
    Key::default("parts", Form::Table, "[parts](#parts): mechanisms of other files", "none"),
    Key::default("initial", Form::Table, "[initial values](#initial)", "none"),
    Key::default("outputs", Form::Table, "[the outputs](#outputs)", "none"),
    Key::default("experiment", Form::Table, "the [default experiment](#experiment)", "its defaults"),
    Key::default(
        "clearance",
        Form::Table,
        "[distances between outlines](#clearance) that `cotree motion` reports",
        "all pairs that share no joint, if an `outline` is given",
    ),
    Key::default("display", Form::Table, "the [units that results are shown in](#display)", "SI"),
    Key::default("solver", Form::Table, "[settings of the solver](#solver)", "its defaults"),
    Key::default("coordinates", Form::Table, "the [choice of trees](#coordinates)", "`preset = \"recommended\"`"),
];

/// A pulley that a rope or band runs over.
pub(crate) const PULLEY: &[Key] = &[
    Key::required("on", Form::CarrierPoint, "its centre", "give its centre, a point: `on = \"BODY.POINT\"`"),
    Key::required(
        "radius",
        Form::Constant(LENGTH, Range::NotNegative),
        "its radius; 0 is an eye",
        "give the radius of the pulley: `radius = \"50 mm\"`",
    ),
    SIDE_OF_ROPE,
    Key::default(
        "turns",
        Form::Constant(NUMBER, Range::NotNegative),
        "whole turns beyond the part of a turn that its straight parts show",
        "0",
    ),
    Key::default(
        "mu",
        Form::Constant(NUMBER, Range::NotNegative),
        "the coefficient of friction of a rope against the body of `on`; without it the rope slides freely",
        "none",
    ),
];

/// A drum on which a rope or band ends.
pub(crate) const DRUM: &[Key] = &[
    Key::required(
        "drum",
        Form::CarrierPoint,
        "its body, or a point of it",
        "give the body that is the drum: `drum = \"BODY\"`",
    ),
    Key::required(
        "radius",
        Form::Constant(LENGTH, Range::Positive),
        "its radius",
        "give the radius of the drum: `radius = \"60 mm\"`",
    ),
    SIDE_OF_ROPE,
];

/// A corner of a profile, with what leads to it.
pub(crate) const CORNER: &[Key] = &[
    Key::required(
        "to",
        Form::ConstantVector(LENGTH),
        "the corner, from the first point in the axes of its body, in metres",
        "give the corner to which the arc leads: `to = [0.2, 0.1]`",
    ),
    Key::required(
        "radius",
        Form::Constant(LENGTH, Range::Positive),
        "the radius of the arc that leads to it, which is at most half a circle",
        "give the radius of the arc: `radius = \"0.1 m\"`; a line needs no table: `[0.2, 0.1]`",
    ),
    Key::default(
        "turn",
        Form::Choice(&["left", "right"], "an arc turns `left` or `right`, seen along the profile"),
        "which way the arc turns, seen along the profile",
        "`\"left\"`",
    ),
];

const SIDE_OF_ROPE: Key = Key::default(
    "side",
    Form::Choice(&["left", "right"], "the centre is on the `left` or the `right` of the rope, seen from its first end"),
    "on which side of the rope its centre is, seen from the first end to the last; only an eye has none",
    "none",
);

const UNIT: Key = Key::default("unit", Form::Text, "the unit of numbers without one", "SI, as the value is used");
pub(crate) const DESCRIPTION: Key = Key::default("description", Form::Text, "one line about it", "none");
const MIN: Key = Key::default("min", Form::Constant(ANYTHING, Range::Any), "its smallest value", "none");
const MAX: Key = Key::default("max", Form::Constant(ANYTHING, Range::Any), "its largest value", "none");

pub(crate) const PARAMETER: &[Key] = &[
    Key::required(
        "value",
        Form::Constant(ANYTHING, Range::Any),
        "its default; a parameter that is an expression of others is calculated and cannot be set",
        "give its default: `value = \"0.5 m\"`",
    ),
    UNIT,
    DESCRIPTION,
    MIN,
    MAX,
    Key::default("tunable", Form::Switch, "whether it may change while the FMU runs", "`false`"),
];

pub(crate) const INPUT: &[Key] = &[
    Key::optional(
        "start",
        Form::Constant(ANYTHING, Range::Any),
        "its value until it is set; parameters in it have their values of the scene",
    ),
    UNIT,
    DESCRIPTION,
    MIN,
    MAX,
];

/// A quantity whose rate is given.
pub(crate) const STATE: &[Key] = &[
    Key::required(
        "rate",
        Form::Law(ANYTHING),
        "its rate: an expression of states, positions, velocities, laws of loads, inputs, the time and parameters, in SI units",
        "give its rate: `rate = \"(voltage - resistance*current)/inductance\"`",
    ),
    Key::default("start", Form::Constant(ANYTHING, Range::Any), "its value at the start", "0"),
    Key::default(
        "nominal",
        Form::Constant(ANYTHING, Range::Positive),
        "its usual size: tolerances are relative to it",
        "the size of its start, or 1",
    ),
    Key::default("unit", Form::Text, "its unit, that of numbers without one", "that of its start"),
    DESCRIPTION,
];

/// Values that are sampled together.
pub(crate) const SAMPLED: &[Key] = &[
    Key::required(
        "period",
        Form::Constant(TIME, Range::Positive),
        "the sample time: samples are taken at `offset` + k `period`, k = 0, 1, ...",
        "give the sample time: `period = \"10 ms\"`",
    ),
    Key::default("offset", Form::Constant(TIME, Range::Any), "the time of the first sample", "0"),
    Key::required(
        "values",
        Form::Table,
        "the values, each a table with the keys below",
        "give the values: `values.x = { start = 0, next = \"x + 1\" }`",
    ),
];

/// A value that changes at ticks only.
pub(crate) const SAMPLED_VALUE: &[Key] = &[
    Key::default(
        "start",
        Form::Law(ANYTHING),
        "its value before the first sample: an expression of parameters, inputs, and positions, velocities and states at the start",
        "0",
    ),
    Key::default(
        "next",
        Form::Law(ANYTHING),
        "its new value at a sample time: an expression of all variables just before it; `new(x)` is the new value of `x` of the same sampler",
        "unchanged; events may set it",
    ),
    Key::default("unit", Form::Text, "its unit, that of numbers without one", "that of its start"),
    DESCRIPTION,
];

/// What happens when a comparison begins to hold.
pub(crate) const EVENT: &[Key] = &[
    Key::required(
        "when",
        Form::Text,
        "a comparison of two expressions of any variables; the event happens when it becomes true",
        "give a comparison: `when = \"beam.angle > 0.7\"`",
    ),
    Key::default("remove", Form::Names, "names of joints, drivers and loads that are removed", "none"),
    Key::default("engage", Form::Names, "names of joints that engage", "none"),
    Key::default("release", Form::Names, "names of joints that are released, and may engage again", "none"),
    Key::default(
        "set",
        Form::Table,
        "new values of [sampled values](#sampled), [states](#states) and rates such as `\"arm.omega\"`, expressions of all variables just before the event",
        "none",
    ),
    Key::default("stop", Form::Switch, "whether it ends the run", "`false`"),
    Key::default(
        "once",
        Form::Switch,
        "whether it happens only once",
        "`false`, but `true` where it removes something",
    ),
    DESCRIPTION,
];

/// A law with a name.
pub(crate) const SIGNAL: &[Key] = &[
    Key::required(
        "value",
        Form::Law(ANYTHING),
        "an expression of parameters, inputs, the time, variables and other signals, in SI units",
        "give its expression: `value = \"3[N]*sin(t)\"`",
    ),
    SIGNAL_UNIT,
    DESCRIPTION,
];

pub(crate) const SIGNAL_UNIT: Key =
    Key::default("unit", Form::Text, "its unit: the law must have it; a bare number is in it", "the unit of the law");

/// The ground.
pub(crate) const GROUND: &[Key] = &[
    Key::default("points", Form::NamedPoints, "its points", "none"),
    Key::default(
        "outline",
        Form::Outline,
        "its [outline](#outlines), for pictures and [clearance](#clearance)",
        "none",
    ),
];

/// Distances between outlines.
pub(crate) const CLEARANCE: &[Key] = &[
    Key::default(
        "pairs",
        Form::Pairs,
        "pairs of bodies, or of a body and `ground`, each with an outline or a shape: `[[\"coupler\", \"ground\"]]`",
        "all pairs with outlines or shapes that share no joint",
    ),
    Key::default(
        "least",
        Form::Constant(LENGTH, Range::Positive),
        "the least distance that is permitted; `cotree motion` ends with exit code 1 if a pair comes closer",
        "none",
    ),
];

/// A file whose mechanism is a part of the scene.
pub(crate) const PART: &[Key] = &[
    Key::required(
        "file",
        Form::Text,
        "the scene file, relative to the folder of the file that names it",
        "name the file: `file = \"wheel.toml\"`",
    ),
    Key::default(
        "parameters",
        Form::Table,
        "new values of its parameters: expressions of the parameters of this file",
        "its own",
    ),
    Key::default("on", Form::Text, "the body of this scene to which its ground is fixed", "`\"ground\"`"),
    Key::default("at", Form::ConstantVector(LENGTH), "the position of its origin", "`[0, 0]`"),
    Key::default("angle", Form::Constant(ANGLE, Range::Any), "its angle of rotation", "0"),
    Key::default("mirror", Form::Switch, "whether it is mirrored left to right, before the rotation", "`false`"),
];

/// An initial value that is a table.
pub(crate) const GUESS: &[Key] = &[Key::default(
    "guess",
    Form::Constant(ANYTHING, Range::Any),
    "its approximate value: it chooses the assembly mode, while the loops give the exact value",
    "none",
)];

/// What is reported.
pub(crate) const OUTPUTS: &[Key] = &[Key::default(
    "variables",
    Form::Names,
    "names of [variables](#variables); every other key is the name of an additional output, given by an expression of variables or by a table",
    "none",
)];

pub(crate) const OUTPUT: &[Key] = &[
    Key::required(
        "value",
        Form::Constant(ANYTHING, Range::Any),
        "an expression of variables, in SI units",
        "give its expression: `value = \"2*BODY.x\"`",
    ),
    Key::default("unit", Form::Text, "the unit in which it is shown", "the unit of its expression"),
    DESCRIPTION,
];

pub(crate) const EXPERIMENT: &[Key] = &[
    Key::optional("start", Form::Constant(TIME, Range::Any), "its start"),
    Key::default("stop", Form::Constant(TIME, Range::Any), "its end", "10 s after the start"),
    Key::default("step", Form::Constant(TIME, Range::Positive), "the communication step", "1/1000 of the time"),
    Key::default(
        "tolerance",
        Form::Constant(NUMBER, Range::Positive),
        "relative tolerance of the variables of the scene",
        "1e-6",
    ),
];

const fn unit_of(name: &'static str, wanted: Wanted, about: &'static str) -> Key {
    Key::default(name, Form::UnitOf(wanted), about, "SI")
}

/// The units that results are shown in.
pub(crate) const DISPLAY: &[Key] = &[
    Key::default("units", Form::Names, "units, one for each kind of value: `[\"deg\", \"mm\", \"kN\"]`", "none"),
    unit_of("length", LENGTH, "the unit of lengths; velocities and accelerations follow it"),
    unit_of("angle", ANGLE, "the unit of angles; angular velocities and accelerations follow it"),
    unit_of("time", TIME, "the unit of the time"),
    unit_of("velocity", VELOCITY, "the unit of velocities"),
    unit_of("angular_velocity", ANGULAR_VELOCITY, "the unit of angular velocities"),
    unit_of("force", FORCE, "the unit of forces"),
    unit_of("torque", TORQUE, "the unit of torques"),
    unit_of("energy", ENERGY, "the unit of energies"),
    unit_of("power", POWER, "the unit of powers"),
];

pub(crate) const SOLVER: &[Key] = &[
    Key::optional(
        "method",
        Form::Choice(&["auto", "explicit", "implicit"], ""),
        "the integrator: automatic switching between stiff and non-stiff methods, or one of them",
    ),
    Key::default("rtol", Form::Constant(NUMBER, Range::Positive), "relative tolerance of a step", "the solver's"),
    Key::default("atol", Form::Constant(NUMBER, Range::Positive), "absolute tolerance of a step", "the solver's"),
    Key::default("max_step", Form::Constant(TIME, Range::Positive), "the longest step", "none"),
    Key::default(
        "time_budget",
        Form::Constant(TIME, Range::Positive),
        "limit of the computing time of one communication step; more is an error",
        "none",
    ),
];

pub(crate) const COORDINATES: &[Key] = &[
    Key::optional(
        "preset",
        Form::Choice(&["recommended", "absolute", "joint", "cheapest"], ""),
        "the [choice of trees](trees.md)",
    ),
    Key::default("translation", Form::Names, "the branches of the translational tree", "the preset's"),
    Key::default("rotation", Form::Names, "the branches of the rotational tree", "the preset's"),
];
