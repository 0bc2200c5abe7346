//! The model as data: everything that an FMU needs to move one mechanism.
//!
//! A [`Program`] is written at export by the root package and only read here. It holds no scene, no graph and no
//! symbol: names for messages, straight-line [`Tape`]s over one register file, and the tables that say which
//! register is what.

pub mod arm_form;
pub mod check;
pub mod contour;
pub mod domain;
pub(crate) mod seal;
pub mod storage;
pub(crate) mod time_switches;

use std::collections::BTreeSet;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::tape::Tape;
use arm_form::ArmForm;
use contour::{Contour, Contours};

/// One mechanism, ready to run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// The scene's name.
    pub name: String,
    /// What the FMU must be instantiated with.
    pub guid: String,
    /// Default experiment.
    pub experiment: Experiment,
    /// FMU parameters, in the order of their registers; then the initial values that can be set under the names of their variables.
    pub parameters: Vec<Parameter>,
    /// Discrete variables, in the order of their registers.
    pub discrete: Vec<Discrete>,
    /// FMU inputs, in the order of their registers.
    pub inputs: Vec<Input>,
    /// Drivers that follow an input as a velocity or an acceleration.
    pub followers: Vec<Follower>,
    /// Branch coordinates {q}; then one for each state of the scene, which is its rate: z' = g is the equation of a coordinate of unit mass that nothing else moves.
    pub coordinates: Vec<Coordinate>,
    /// How many of them, the last ones, are integrals of states.
    pub states: u32,
    /// Loop equations {Phi}; redundant ones are listed too, with `active = false`.
    pub constraints: Vec<Constraint>,
    /// A typical length of the mechanism [m]: tolerances on positions are relative to it.
    pub length: f64,
    /// What can be read by name, in the order of the value references.
    pub variables: Vec<Variable>,
    /// Constants, loaded into the registers from `layout().constants()` on.
    pub constants: Vec<f64>,
    /// Size of the register file.
    pub registers: u32,
    /// The kernels.
    pub tapes: Tapes,
    /// What is known and guessed of the initial state.
    pub initial: Initial,
    /// How the motion is integrated, unless the caller asks for something else.
    pub engine: Engine,
    /// May a run change to the implicit method while the motion is stiff?
    pub automatic: bool,
    /// What ticks and events change.
    pub instants: Instants,
    /// What the Taylor series of the motion are found from, if they exist.
    pub arms: Option<ArmForm>,
    /// The same without loads, where there are no series: what the attainable accuracy is measured by.
    pub masses: Option<ArmForm>,
}

/// Values that only ticks and events change, and when. Nothing of it is there in most scenes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Instants {
    /// Values that are sampled together.
    pub samplers: Vec<Sampler>,
    /// What happens when a comparison begins to hold.
    pub events: Vec<Event>,
    /// What the first discrete variables begin with, in their order; the others begin with [`Discrete::start`]. Reads everything but accelerations and reactions.
    pub begin: Tape,
    /// Period and offset of each sampler [s]. Reads parameters.
    pub clocks: Tape,
    /// What is written, at the left limits. Reads everything, a and lambda included.
    pub written: Tape,
    /// Both sides of the comparison of each event, the one that is then larger first. Reads as `written`.
    pub sides: Tape,
    /// Loop equations that do not always hold, each with the discrete variable that is 1 while it holds, else 0.
    pub masks: Vec<(u32, u32)>,
    /// What the mechanism holds on one side only.
    pub contacts: Option<Contacts>,
}

/// All contacts: unilateral constraints, whose gap is never negative and whose reaction acts in one direction, and friction that sticks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// One for each.
    pub all: Vec<Contact>,
    /// The gaps. Reads time, inputs, followers, q.
    pub gaps: Tape,
    /// Their rates. Reads v, too.
    pub rates: Tape,
    /// Their second derivatives. Reads a, too.
    pub accelerations: Tape,
    /// Share of the speed with which each rebounds; of friction, the ratio of its limit at rest to that while it slips. Reads time, inputs, followers, q, v.
    pub restitutions: Tape,
    /// Changes of the rates of coordinates, then minus the impulses of all loop equations, that change the rate of each loop equation by minus what stands in the registers of reactions. Reads
    /// as `constraint`.
    pub impact: Tape,
    /// The sums whose sizes press where something rubs. Reads a and lambda, too.
    pub pressing: Tape,
    /// All positive, or friction locks the mechanism so that no accelerations fit. Reads as `acceleration`.
    pub locks: Tape,
    /// The size of the row of each of [`Tapes::reciprocal_pivots`] before elimination, in the unit of the pivot: redundant is what leaves rounding errors of it. Reads as `constraint`.
    pub row_sizes: Tape,
    /// The profiles that contacts touch, if there are any.
    pub contours: Option<Contours>,
}

/// A contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The user's name, such as `hinge.max`.
    pub name: String,
    /// Its loop equation, of the role [`Role::Contact`].
    pub constraint: u32,
    /// Its discrete variables.
    pub state: ContactState,
    /// True for a freewheel, whose rate is what is never negative.
    pub of_rate: bool,
    /// The friction, if it is one: its relation holds on both sides while it sticks, and it slides while it is open.
    pub slip: Option<Slip>,
}

/// The discrete variables of a contact: their places in [`Program::discrete`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactState {
    /// 1 while it is closed, or sticks; else 0.
    pub closed: u32,
    /// The impulse of the last impact.
    pub impulse: u32,
    /// From where its gap counts: of friction and freewheels, which stick or engage wherever they are.
    pub place: Option<u32>,
    /// 1 or -1 while it slides that way, else 0: of friction.
    pub direction: Option<u32>,
    /// The signs of what presses: of friction.
    pub signs: Vec<u32>,
}

/// How something rubs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slip {
    /// The row whose multiplier is the level while it slips. The level at rest is that times what stands among the restitutions.
    pub level: u32,
    /// What must be closed for it to rub.
    pub on: Option<u32>,
    /// The first of its sums among those that press, of which each has a sign.
    pub sums: u32,
    /// True if its level follows from reactions.
    pub follows: bool,
}

/// Discrete variables that change together at offset + k period, k = 0, 1, ...
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampler {
    /// The user's name.
    pub name: String,
    /// What a tick writes.
    pub writes: Vec<Write>,
}

/// What happens when a comparison begins to hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// The user's name.
    pub name: String,
    /// True if the comparison holds only where its sides differ.
    pub strict: bool,
    /// True if the event happens once only.
    pub once: bool,
    /// True if the event ends the run.
    pub stop: bool,
    /// What it writes.
    pub writes: Vec<Write>,
    /// Discrete variables that are 0 from then on: what they are the factors of is removed.
    pub removes: Vec<u32>,
}

impl Event {
    /// False for what the exporter adds for parts over pulleys, with names such as `rope.turn_1`: names of events in scenes have no point.
    pub fn is_of_scene(&self) -> bool {
        !self.name.contains('.')
    }
}

/// A discrete variable or a state, and the result of [`Instants::written`] that it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Write {
    /// The place of a discrete variable in [`Program::discrete`]; behind them come the states.
    pub target: u32,
    /// Which result of the tape.
    pub result: u32,
}

/// What a write changes, by its place among others of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A discrete variable.
    Discrete(usize),
    /// A state of the scene.
    State(usize),
}

impl Instants {
    /// True if nothing ever happens.
    pub fn is_empty(&self) -> bool {
        self.samplers.is_empty() && self.events.is_empty() && self.contacts.is_none()
    }

    /// How many things can happen at an instant that is not known beforehand: events, then openings, closings and impacts of contacts, at last what happens at profiles.
    pub fn occasions(&self) -> usize {
        let at_profiles = self.contours().iter().map(|contour| 1 + contour.slots.len()).sum::<usize>();
        self.first_at_profiles() + at_profiles
    }

    /// The first of those at profiles: one for each of them, where it is touched anew, then one for each of their slots, whose feature is left.
    pub fn first_at_profiles(&self) -> usize {
        let turns =
            self.contacts.as_ref().map_or(0, |contacts| contacts.pressing.results.len() + contacts.locks.results.len());
        self.events.len() + self.contacts().len() + turns
    }

    /// All profiles.
    pub fn contours(&self) -> &[Contour] {
        self.contacts.as_ref().and_then(|contacts| contacts.contours.as_ref()).map_or(&[], |contours| &contours.all)
    }

    /// All contacts.
    pub fn contacts(&self) -> &[Contact] {
        self.contacts.as_ref().map_or(&[], |contacts| &contacts.all)
    }

    /// Everything that is ever written.
    pub fn writes(&self) -> impl Iterator<Item = &Write> {
        let of_samplers = self.samplers.iter().flat_map(|sampler| &sampler.writes);
        of_samplers.chain(self.events.iter().flat_map(|event| &event.writes))
    }
}

/// The integrator of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Engine {
    /// Taylor series of the motion (`solver::taylor`); needs [`Program::arms`].
    Taylor,
    /// Explicit Runge-Kutta method of order 8 with dense output of order 7.
    #[default]
    Dop853,
    /// Implicit Runge-Kutta method Radau IIA of order 5 (`solver::implicit`), for stiff motion.
    Radau,
}

/// The default experiment of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time [s].
    pub start: f64,
    /// Stop time [s].
    pub stop: f64,
    /// Communication step [s].
    pub step: f64,
    /// Relative tolerance on what the user sees.
    pub tolerance: f64,
    /// Longest step of the solver [s]; infinite if the scene sets none.
    pub max_step: f64,
    /// Longest time that the computer may take for a communication step [s]; infinite if the scene sets none.
    pub budget: f64,
}

/// A parameter of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// The user's name.
    pub name: String,
    /// Default value, SI.
    pub start: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
    /// May it change after initialisation?
    pub tunable: bool,
}

/// An input of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// The user's name.
    pub name: String,
    /// Value until it is set, SI.
    pub start: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
}

/// A discrete variable: constant between instants, at which sample times, events and contacts change it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Discrete {
    /// Its name.
    pub name: String,
    /// Its first value, SI, where [`Instants::begin`] gives none.
    pub start: f64,
}

/// A driver that follows an input by integrating it. Its position, rate and acceleration are registers; between
/// communication points the input is a polynomial of time, so the integrals are exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Follower {
    /// The driver's name.
    pub name: String,
    /// Index of the input.
    pub input: u32,
    /// What the input prescribes.
    pub order: FollowerOrder,
    /// Absolute tolerance scale of the position: 1 for an angle, `length` for a displacement.
    pub scale: f64,
}

/// What an integrated input prescribes (a prescribed position needs no follower).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FollowerOrder {
    /// The input is the driver's rate.
    Velocity,
    /// The input is the driver's acceleration.
    Acceleration,
}

/// A branch coordinate q.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coordinate {
    /// The user's name of the coordinate, such as `crank.angle`.
    pub name: String,
    /// Absolute tolerance scale: 1 for an angle [rad], [`Program::length`] for a displacement [m].
    pub scale: f64,
}

/// What the motion has to do with a loop equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// It is redundant: checked for consistency, but not imposed.
    LeftOut,
    /// One of as many as are independent.
    Imposed,
    /// Imposed while it is closed: what it holds, it holds on one side only.
    Contact,
    /// Of a driven mechanism, redundant: it helps to determine the motion where those that are imposed depend on each other.
    Repeating,
    /// Imposed while a joint is engaged.
    Engaging {
        /// The discrete variable that gets the impulse of an engagement.
        impulse: u32,
        /// The one that gets the energy lost by all loop equations of the joint.
        lost: u32,
    },
    /// Imposed at the instant at which an event sets a rate: minus that rate is its own.
    Set {
        /// The discrete variable that is the rate to be.
        value: u32,
        /// The one that gets the impulse.
        impulse: u32,
    },
}

impl Role {
    /// True for an equation that is imposed while a discrete variable is 1.
    pub fn is_masked(self) -> bool {
        matches!(self, Role::Contact) || self.is_by_event()
    }

    /// True for an equation that an event imposes.
    pub fn is_by_event(self) -> bool {
        matches!(self, Role::Engaging { .. } | Role::Set { .. })
    }

    /// The discrete variables that it writes or reads at instants.
    pub fn places(self) -> impl Iterator<Item = u32> {
        let places = match self {
            Role::Engaging { impulse, lost } => [Some(impulse), Some(lost)],
            Role::Set { value, impulse } => [Some(value), Some(impulse)],
            Role::LeftOut | Role::Imposed | Role::Contact | Role::Repeating => [None; 2],
        };
        places.into_iter().flatten()
    }
}

/// What the gap of a loop equation measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GapMeasure {
    /// A length [m].
    Length,
    /// An angle [rad] whose whole turns count, as of gears.
    Angle,
    /// The angle [rad] of a direction, as of a cam's turning follower: whole turns leave it closed.
    Direction,
}

/// One scalar loop equation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constraint {
    /// The joint or driver that the equation belongs to, such as `wrist_pin`.
    pub owner: String,
    /// 1 for an angle [rad], [`Program::length`] for a gap [m].
    pub scale: f64,
    /// What kind of number its gap is.
    pub measure: GapMeasure,
    /// What the motion has to do with it.
    pub role: Role,
    /// Do the others imply it, in second order, with the parameters of the export? Then it stands for rows that are not imposed.
    pub implied: bool,
}

/// What a variable's value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Source {
    /// The independent variable.
    Time,
    /// Index into [`Program::parameters`].
    Parameter(u32),
    /// Index into [`Program::inputs`].
    Input(u32),
    /// Index into [`Program::discrete`].
    Discrete(u32),
    /// Index into the results of [`Tapes::outputs`], and whether the value needs accelerations or reactions.
    Output {
        /// Which result of the tape.
        result: u32,
        /// Must [`Tapes::acceleration`] have run?
        accelerated: bool,
    },
    /// Coordinate q of that index.
    Coordinate(u32),
    /// Rate of the coordinate of that index.
    Rate(u32),
    /// Acceleration of the coordinate of that index.
    Acceleration(u32),
}

/// A readable variable. Its place in [`Program::variables`] is its value reference in FMI 2.0, and one less than that in FMI 3.0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// The structured name, unique.
    pub name: String,
    /// Where its value comes from.
    pub source: Source,
    /// Before initialisation, setting it sets this parameter: its value (or its guess) at the start.
    pub initial: Option<u32>,
}

/// A sparse matrix whose nonzero entries are the results of a tape, in the order of `entries`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SparseTape {
    /// (row, column) of each result.
    pub entries: Vec<(u32, u32)>,
    /// Computes the entries.
    pub tape: Tape,
}

/// Arguments of functions that may be steep, each a result of a tape.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LawTape {
    /// How the function of each result is steep.
    pub kinds: Vec<Steep>,
    /// Computes the arguments.
    pub tape: Tape,
}

/// The kernels. Each reads the registers named in its comment and the parameter stage, and may use every register from
/// the end of the parameter stage on as scratch: results must be copied out before another tape runs.
///
/// Sizes: n coordinates (those of states included), m loop equations (whatever their role), f followers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tapes {
    /// What depends on parameters and discrete variables only. Run when these change; its registers persist.
    pub parameters: Tape,
    /// Phi(q, t), m results. Reads time, inputs, followers, q.
    pub constraint: Tape,
    /// Phi_q, m x (n + f): the last f columns are the derivatives by follower positions. Reads as `constraint`.
    pub jacobian: SparseTape,
    /// Phi_t + Phi_q v, m results (the total rate of Phi). Reads as `constraint`, and v.
    pub constraint_rate: Tape,
    /// gamma of Eq. (21), m results: Phi_q a = gamma. Reads as `constraint_rate`.
    pub gamma: Tape,
    /// Accelerations, then reactions of all m constraints: zero for those that are left out, and where drivers determine the motion and no output needs them. Reads
    /// time, inputs, followers, q, v.
    pub acceleration: Tape,
    /// Registers that hold, after `acceleration`, 1 / r^2 with any sign, where r is how far a loop equation is from others: all of them regular unless one
    /// grows without bound.
    pub reciprocal_pivots: Vec<u32>,
    /// When there are active constraints: m residuals Phi, then n corrections dq of one Newton step in the metric of the mass matrix, to be
    /// added to q. Reads as `constraint`.
    pub project_position: Tape,
    /// When there are active constraints: m residuals of the rate, then n corrections dv. Reads as `constraint_rate`.
    pub project_velocity: Tape,
    /// Values that change sign where the accelerations, or the rates that drivers prescribe, have a step or a corner. Reads time, inputs, followers, q, v.
    pub indicators: Tape,
    /// Arguments of what may be steep in laws. Reads time, inputs, followers, q, v.
    pub laws: LawTape,
    /// Where laws have values: for messages only. Reads as `laws`.
    pub domains: domain::DomainTape,
    /// Values of keys that parameters could move out of their ranges. Reads parameters.
    pub ranges: domain::DomainTape,
    /// Every variable with `Source::Output`. Reads everything, a and lambda included.
    pub outputs: Tape,
}

/// What is known and guessed of the initial state. Results of the tapes come in two halves: first the k values as
/// functions of the state, then the k targets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Initial {
    /// Known and guessed positions.
    pub positions: Vec<Condition>,
    /// k values, k targets. Reads as `Tapes::constraint`.
    pub position: Tape,
    /// d value / d (q, follower position): k x (n + f).
    pub position_jacobian: SparseTape,
    /// Known velocities.
    pub velocities: Vec<Condition>,
    /// k values, k targets. Reads as `Tapes::constraint_rate`.
    pub velocity: Tape,
    /// d value / d (v, follower rate): k x (n + f).
    pub velocity_jacobian: SparseTape,
    /// Where the search for positions begins: q, then those of followers. Nothing stands for zeros.
    pub first_positions: Vec<f64>,
    /// The same for the rates.
    pub first_rates: Vec<f64>,
    /// The positions that were found at the export, where time, parameters and inputs have the values that they have here: then nothing is searched for. Nothing stands for none.
    pub found_positions: Vec<f64>,
    /// The same for the rates.
    pub found_rates: Vec<f64>,
}

/// One line of the scene's `[initial]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The variable, such as `crank.angle`.
    pub name: String,
    /// Known, or a guess that picks the assembly.
    pub known: bool,
    /// Is it an angle [rad] or angular rate?
    pub angular: bool,
    /// 1 for an angle, [`Program::length`] for a displacement.
    pub scale: f64,
}

/// Where things lie in the register file, in this order: time, parameters, discrete variables, inputs, input rates, input accelerations, follower
/// positions, follower rates, follower accelerations, q, v, a, lambda, constants, parameter stage, scratch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    parameters: usize,
    discrete: usize,
    inputs: usize,
    followers: usize,
    coordinates: usize,
    states: usize,
    constraints: usize,
}

impl Layout {
    /// The layout for these counts; the coordinates are those of the mechanism and, after them, one for each state.
    pub fn new(
        [parameters, discrete, inputs, followers]: [usize; 4],
        [mechanical, states]: [usize; 2],
        constraints: usize,
    ) -> Self {
        Self { parameters, discrete, inputs, followers, coordinates: mechanical + states, states, constraints }
    }

    /// Register of time.
    pub fn time(&self) -> usize {
        0
    }
    /// First parameter.
    pub fn parameters(&self) -> usize {
        1
    }
    /// First discrete variable.
    pub fn discrete(&self) -> usize {
        self.parameters() + self.parameters
    }
    /// Parameters and discrete variables: what is constant between instants.
    pub fn constant_between_instants(&self) -> Range<usize> {
        self.parameters()..self.inputs()
    }
    /// First input value.
    pub fn inputs(&self) -> usize {
        self.discrete() + self.discrete
    }
    /// First input rate.
    pub fn input_rates(&self) -> usize {
        self.inputs() + self.inputs
    }
    /// First input acceleration.
    pub fn input_accelerations(&self) -> usize {
        self.input_rates() + self.inputs
    }
    /// First follower position.
    pub fn followers(&self) -> usize {
        self.input_accelerations() + self.inputs
    }
    /// First follower rate.
    pub fn follower_rates(&self) -> usize {
        self.followers() + self.followers
    }
    /// First follower acceleration.
    pub fn follower_accelerations(&self) -> usize {
        self.follower_rates() + self.followers
    }
    /// First coordinate q.
    pub fn positions(&self) -> usize {
        self.follower_accelerations() + self.followers
    }
    /// First rate v.
    pub fn rates(&self) -> usize {
        self.positions() + self.coordinates
    }
    /// First state of the scene: they are the last rates.
    pub fn states(&self) -> usize {
        self.accelerations() - self.states
    }
    /// First rate of a state: they are the last accelerations.
    pub fn state_rates(&self) -> usize {
        self.reactions() - self.states
    }
    /// First acceleration a.
    pub fn accelerations(&self) -> usize {
        self.rates() + self.coordinates
    }
    /// First reaction lambda.
    pub fn reactions(&self) -> usize {
        self.accelerations() + self.coordinates
    }
    /// First constant.
    pub fn constants(&self) -> usize {
        self.reactions() + self.constraints
    }
}

impl Constraint {
    /// True for an angle [rad], false for a length [m].
    pub fn is_angle(&self) -> bool {
        matches!(self.measure, GapMeasure::Angle | GapMeasure::Direction)
    }

    /// True for one of the independent ones: what is held on one side only counts as one in every mode.
    pub fn is_imposed(&self) -> bool {
        self.role == Role::Imposed || self.role.is_masked()
    }
}

impl Program {
    /// Can somebody else integrate it? Not if a driver follows an input: loops, accelerations or outputs then need its rates, which nobody
    /// tells. Nor with profiles: where they are touched is searched for in each step.
    pub fn offers_exchange(&self) -> bool {
        self.followed_inputs().is_empty() && self.instants.contours().is_empty()
    }

    /// How many coordinates are those of the mechanism.
    pub fn mechanical(&self) -> usize {
        self.coordinates.len() - self.states as usize
    }

    /// The branch coordinates: those of the mechanism, without the integrals of states. Loop equations depend on no others.
    pub fn branch_coordinates(&self) -> &[Coordinate] {
        &self.coordinates[..self.mechanical()]
    }

    /// How many event indicators Model Exchange has: those of laws, then one for each event of the scene.
    pub fn indicators(&self) -> usize {
        self.tapes.indicators.results.len() + self.instants.occasions()
    }

    /// Do drivers determine all that moves, so that there are no states: are there as many independent loop equations as coordinates?
    pub fn is_driven(&self) -> bool {
        self.constraints.iter().filter(|constraint| constraint.role == Role::Imposed).count() == self.coordinates.len()
    }

    /// The inputs that a driver follows, in order: those whose rates something needs, and those that a driver integrates.
    pub fn followed_inputs(&self) -> Vec<usize> {
        let integrated = self.followers.iter().map(|follower| follower.input as usize);
        self.inputs_read_from(self.layout().inputs())
            .chain(integrated)
            .collect::<BTreeSet<usize>>()
            .into_iter()
            .collect()
    }

    /// The inputs whose rates or accelerations something reads, in order: not those that are themselves the acceleration of a driver.
    pub fn inputs_with_rates(&self) -> Vec<usize> {
        self.inputs_read_from(self.layout().input_rates()).collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The inputs of which the loop equations read what stands in this register or behind it, and other kernels the rates.
    fn inputs_read_from(&self, first: usize) -> impl Iterator<Item = usize> {
        let layout = self.layout();
        let tapes = &self.tapes;
        let loops = [&tapes.constraint, &tapes.jacobian.tape, &tapes.constraint_rate, &tapes.gamma];
        let loops = loops.into_iter().map(move |tape| (tape, first));
        let others = [&tapes.acceleration, &tapes.outputs].into_iter();
        loops.chain(others.map(move |tape| (tape, layout.input_rates()))).flat_map(move |(tape, first)| {
            let operands = tape.instructions().iter().flat_map(|instruction| instruction.operands());
            let registers = operands.chain(tape.results.iter().copied()).map(|register| register as usize);
            // Inputs, their rates and their accelerations follow each other.
            registers
                .filter(move |register| (first..layout.followers()).contains(register))
                .map(move |register| (register - layout.inputs()) % self.inputs.len())
        })
    }

    /// Has its integrator steps of its own, at the ends of which a communication step may end as well?
    pub fn has_own_steps(&self) -> bool {
        !self.is_driven()
    }

    /// Can somebody else integrate it who tells the rates of inputs? Not if a driver integrates an input.
    pub fn offers_exchange_with_rates(&self) -> bool {
        self.followers.is_empty() && self.instants.contours().is_empty()
    }

    /// True if events may change rates or states themselves, and not only what these follow from.
    pub fn has_jumping_events(&self) -> bool {
        let jumps = |write: &Write| matches!(self.target(*write), Target::State(_));
        self.constraints.iter().any(|row| row.role.places().next().is_some()) || self.instants.writes().any(jumps)
    }

    /// The loop equations that events engage or set, each with the place of its mask among the discrete variables.
    pub fn masks_by_event(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let masks = self.instants.masks.iter().map(|&(row, mask)| (row as usize, mask as usize));
        masks.filter(|(row, _)| self.constraints[*row].role.is_by_event())
    }

    /// What a write changes.
    pub fn target(&self, write: Write) -> Target {
        let place = write.target as usize;
        place.checked_sub(self.discrete.len()).map_or(Target::Discrete(place), Target::State)
    }

    /// The layout of this program's register file.
    pub fn layout(&self) -> Layout {
        Layout::new(
            [self.parameters.len(), self.discrete.len(), self.inputs.len(), self.followers.len()],
            [self.mechanical(), self.states as usize],
            self.constraints.len(),
        )
    }
}

/// How a function is steep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Steep {
    /// Constant but for a layer about zero: tanh.
    Saturating,
    /// Where its argument is large: exp.
    Growing,
    /// Where its argument changes sign: `if`, `min`, `max`, `abs`, `sign`, `floor`.
    Switching,
    /// Where its argument is next to nothing of what it is elsewhere: roots, powers, logarithms, divisors.
    Vanishing,
}
