//! The scene with every name resolved, every unit converted and every expression parsed: what the equations are built from.
//!
//! Numbers are SI; points are relative to the mass centre of their body. A [`Mechanism`] has no faults left that can be
//! found without formulating equations.

use crate::scene::Span;

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
    /// Index of a body.
    BodyId,
    /// Index of a joint.
    JointId,
    /// Index of a driver.
    DriverId,
    /// Index of a load.
    LoadId,
}

/// A resolved scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    /// The scene's name.
    pub name: String,
    /// One line about it; may be empty.
    pub description: String,
    /// Plane or line.
    pub dimension: Dimension,
    /// Acceleration of gravity [m/s2]; constants and parameters only.
    pub gravity: [Formula; 2],
    /// Become FMU parameters.
    pub parameters: Vec<Parameter>,
    /// Become FMU inputs.
    pub inputs: Vec<Input>,
    /// Points of the ground.
    pub ground: Vec<Point>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// Joints.
    pub joints: Vec<Joint>,
    /// Prescribed motions.
    pub drivers: Vec<Driver>,
    /// Forces, torques, springs, actuators.
    pub loads: Vec<Load>,
    /// Known and guessed initial values.
    pub initial: Vec<Initial>,
    /// What is reported.
    pub outputs: Vec<Output>,
    /// Default experiment.
    pub experiment: Experiment,
    /// Solver settings.
    pub solver: Solver,
    /// Choice of trees.
    pub coordinates: Coordinates,
}

/// How many directions there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Masses on a line: x only, no rotation.
    One,
    /// The plane.
    Two,
}

/// A named parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Unit as the user sees it.
    pub unit: Unit,
    /// Default value, SI.
    pub value: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
    /// May it change after initialisation?
    pub tunable: bool,
    /// Where it stands in the file.
    pub span: Span,
}

/// A named input.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Unit as the user sees it.
    pub unit: Unit,
    /// Value until it is set, SI.
    pub start: f64,
    /// Smallest permitted value, SI.
    pub min: Option<f64>,
    /// Largest permitted value, SI.
    pub max: Option<f64>,
    /// Where it stands in the file.
    pub span: Span,
}

/// Exponents of kg, m, s and rad, and how the user writes the unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unit {
    /// Exponents of kilogram, metre, second, radian.
    pub exponents: [i8; 4],
    /// SI name, such as `N.m`; empty for a pure number.
    pub si: String,
    /// The user's unit, such as `mm`, if not the SI name.
    pub display: Option<DisplayUnit>,
}

/// A unit that the user wrote: `value in SI = factor * value`.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Its name, such as `mm`, `deg`, `rpm`.
    pub name: String,
    /// SI value of one of it.
    pub factor: f64,
}

/// A point with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The user's name within its body.
    pub name: String,
    /// Position relative to the body's mass centre in the body's axes; relative to the origin for the ground.
    pub at: [Formula; 2],
    /// Where it stands in the file.
    pub span: Span,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The user's name.
    pub name: String,
    /// Mass \[kg\]; a kinematic scene needs none.
    pub mass: Option<Formula>,
    /// Inertia about the mass centre [kg.m2]; a body that cannot turn needs none.
    pub inertia: Option<Formula>,
    /// Does gravity leave it alone?
    pub weightless: bool,
    /// Its points.
    pub points: Vec<Point>,
    /// Where it stands in the file.
    pub span: Span,
}

/// A point that an element uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// The origin of the ground (`ground`).
    Origin,
    /// Index into `Mechanism::ground` (`ground.bearing`).
    Ground(usize),
    /// A body's mass centre (`rod`).
    Centre(BodyId),
    /// Index into the body's points (`rod.big_end`).
    Point(BodyId, usize),
}

impl Place {
    /// The body that the point is fixed to, if not the ground.
    pub fn body(self) -> Option<BodyId> {
        match self {
            Place::Origin | Place::Ground(_) => None,
            Place::Centre(body) | Place::Point(body, _) => Some(body),
        }
    }
}

/// A joint: the second point (and body) relative to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The user's name.
    pub name: String,
    /// The points joined.
    pub between: [Place; 2],
    /// What it permits.
    pub kind: JointKind,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a joint permits.
#[derive(Clone, Debug, PartialEq)]
pub enum JointKind {
    /// Turning about the common point.
    Revolute {
        /// [N.m.s]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// Sliding along an axis fixed in the first body.
    Prismatic {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// Second body's angle minus the first's \[rad\].
        angle: Formula,
        /// [N.s/m]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// Nothing.
    Weld {
        /// Second body's angle minus the first's \[rad\].
        angle: Formula,
    },
    /// The second point slides along a line fixed in the first body and turns freely.
    Slot {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// [N.s/m]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// A disc about the second point rolls without slip on a line fixed in the first body, to the left of its axis.
    Rolling {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// Of the disc \[m\].
        radius: Formula,
        /// Of the centre along the axis where the relative angle is zero \[m\].
        displacement: Formula,
    },
    /// A constant distance between the points.
    Distance {
        /// \[m\]
        length: Formula,
    },
    /// The second body turns `ratio` times as far as the first, both against the carrier.
    Gear {
        /// `None` is the ground.
        carrier: Option<BodyId>,
        /// Negative if they turn against each other.
        ratio: Formula,
        /// Second wheel's angle where the first's is zero \[rad\].
        angle: Formula,
    },
    /// The second point moves along an axis of the carrier by `radius` times the angle that the first body, the pinion, turns against it.
    Rack {
        /// The point from which the displacement counts.
        carrier: Place,
        /// Unit vector in the carrier's axes.
        axis: [Formula; 2],
        /// Of the pinion \[m\]; negative if the rack goes back when the pinion turns forward.
        radius: Formula,
        /// Where the pinion's angle is zero \[m\].
        displacement: Formula,
    },
}

/// Dry friction of a constant level, smooth through zero velocity: level x tanh(v / velocity).
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Level [N.m] or \[N\].
    pub coulomb: Formula,
    /// Velocity at which three quarters of the level act [rad/s] or [m/s].
    pub velocity: Formula,
}

impl Joint {
    /// The points that it uses.
    pub fn places(&self) -> Vec<Place> {
        let [first, second] = self.between;
        match self.kind {
            JointKind::Rack { carrier, .. } => vec![first, second, carrier],
            _ => vec![first, second],
        }
    }
}

impl JointKind {
    /// The forces and torques with which it holds or couples.
    pub fn reactions(&self, dimension: Dimension) -> &'static [Quantity] {
        match self {
            JointKind::Weld { .. } if dimension == Dimension::One => &[Quantity::Fx],
            JointKind::Revolute { .. } => &[Quantity::Fx, Quantity::Fy],
            JointKind::Prismatic { .. } => &[Quantity::Fn, Quantity::Torque],
            JointKind::Weld { .. } => &[Quantity::Fx, Quantity::Fy, Quantity::Torque],
            JointKind::Slot { .. } => &[Quantity::Fn],
            JointKind::Rolling { .. } => &[Quantity::Fn, Quantity::Ft],
            JointKind::Distance { .. } => &[Quantity::Force],
            JointKind::Gear { .. } => &[Quantity::Torque],
            JointKind::Rack { .. } => &[Quantity::Force, Quantity::Torque],
        }
    }
}

/// A prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// The user's name.
    pub name: String,
    /// What is prescribed.
    pub kind: DriverKind,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a driver prescribes.
#[derive(Clone, Debug, PartialEq)]
pub enum DriverKind {
    /// The angle of the second body minus the first's; `None` is the ground.
    Angle {
        /// First and second body.
        between: [Option<BodyId>; 2],
        /// The revolute joint named by the user, if one was.
        joint: Option<JointId>,
        /// The motion \[rad\].
        motion: Motion,
    },
    /// The displacement of a prismatic joint \[m\].
    Displacement {
        /// A prismatic joint.
        joint: JointId,
        /// The motion \[m\].
        motion: Motion,
    },
    /// The position of a point in the world \[m\]; one component in one dimension (the second is then the number 0).
    Position {
        /// The point.
        on: Place,
        /// World components.
        position: [Formula; 2],
    },
}

/// A scalar motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A function of time, parameters and inputs.
    Given(Formula),
    /// An input is the rate: integrated.
    Velocity(InputId),
    /// An input is the acceleration: integrated twice.
    Acceleration(InputId),
}

/// A load.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// The user's name.
    pub name: String,
    /// What it is.
    pub kind: LoadKind,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a load is.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// A force on a point \[N\].
    Force {
        /// The point.
        on: Place,
        /// Components; the second is the number 0 in one dimension.
        vector: [Formula; 2],
        /// Are the components in the body's axes? Otherwise in the world's.
        in_body: bool,
    },
    /// A torque on the second body, its opposite on the first [N.m].
    Torque {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// Counter-clockwise.
        value: Formula,
    },
    /// A spring and damper along the line between two points.
    Spring {
        /// The points.
        between: [Place; 2],
        /// Force by length \[N\] and \[m\].
        law: SpringLaw,
    },
    /// A torsion spring and damper.
    TorsionSpring {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// Torque by angle [N.m] and \[rad\].
        law: SpringLaw,
    },
    /// A force law along the line between two points.
    Actuator {
        /// The points.
        between: [Place; 2],
        /// Positive pushes the points apart \[N\]. `length` and `rate` are resolved to this load's own variables.
        force: Formula,
    },
    /// A torque law between two bodies.
    TorsionActuator {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// On the second body [N.m]. `angle` and `omega` are resolved to this load's own variables.
        torque: Formula,
    },
}

/// On which side of its free length (or angle) a spring acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Everywhere.
    #[default]
    Both,
    /// Where it is longer than free; it only pulls.
    Above,
    /// Where it is shorter than free; it only pushes.
    Below,
}

/// What a spring or torsion spring says: the force -k x - k3 x^3 - c x', with x from the free length (or angle).
#[derive(Clone, Debug, PartialEq)]
pub struct SpringLaw {
    /// k [N/m] or [N.m/rad]
    pub stiffness: Formula,
    /// k3 [N/m3] or [N.m/rad3]
    pub cubic: Formula,
    /// c [N.s/m] or [N.m.s]
    pub damping: Formula,
    /// Length \[m\] or angle \[rad\] where x is zero.
    pub free: Formula,
    /// Where it acts.
    pub side: Side,
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
    /// Its value: any variable of the naming table may occur.
    pub value: Formula,
    /// Where it stands in the file.
    pub span: Span,
}

/// Default experiment, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Start time \[s\].
    pub start: f64,
    /// Stop time \[s\].
    pub stop: f64,
    /// Communication step \[s\].
    pub step: f64,
    /// Relative tolerance.
    pub tolerance: f64,
}

/// Solver settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Which integrator.
    pub method: Method,
    /// Relative tolerance, if not the experiment's.
    pub rtol: Option<f64>,
    /// Absolute tolerance, if cotree is not to choose it.
    pub atol: Option<f64>,
    /// Longest step \[s\].
    pub max_step: Option<f64>,
}

/// Which integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// cotree chooses.
    Auto,
    /// Explicit Runge-Kutta.
    Explicit,
    /// Implicit Runge-Kutta, for stiff mechanisms.
    Implicit,
}

/// Choice of trees.
#[derive(Clone, Debug, PartialEq)]
pub enum Coordinates {
    /// Tables 2 and 3.
    Recommended,
    /// All bodies in both trees.
    Absolute,
    /// The same joints in both trees.
    Joint,
    /// Those whose equations cost least, by a fixed model of the cost.
    Cheapest,
    /// Names of bodies, joints, drivers and loads that are branches, beside the rigid arms and ground vectors; `None`: recommended.
    Chosen {
        /// Branches of the translational tree.
        translation: Option<Vec<(String, Span)>>,
        /// Branches of the rotational tree.
        rotation: Option<Vec<(String, Span)>>,
    },
}

/// Who owns a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Owner {
    /// A point of a body or of the ground; `Place::Centre` is the body itself.
    Place(Place),
    /// A joint.
    Joint(JointId),
    /// A driver.
    Driver(DriverId),
    /// A load.
    Load(LoadId),
    /// `energy.*`, `constraint.*`.
    System,
}

/// What is said of the owner: the last word of a variable's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are those of the naming table")]
pub enum Quantity {
    X,
    Y,
    Angle,
    Vx,
    Vy,
    Omega,
    Ax,
    Ay,
    Alpha,
    S,
    V,
    A,
    Fx,
    Fy,
    Fn,
    Ft,
    Force,
    Torque,
    Power,
    Length,
    Rate,
    KineticEnergy,
    PotentialEnergy,
    TotalEnergy,
    PositionResidual,
    VelocityResidual,
}

/// A variable of the naming table, such as `crank.angle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variable {
    /// Whose.
    pub owner: Owner,
    /// Which.
    pub quantity: Quantity,
}

/// A parsed expression with its names resolved.
#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    /// A number, SI.
    Number(f64),
    /// `t`
    Time,
    /// A parameter.
    Parameter(ParameterId),
    /// An input.
    Input(InputId),
    /// A variable of the naming table.
    Variable(Variable),
    /// -a
    Negate(Box<Formula>),
    /// a op b
    Binary(BinaryOperator, Box<[Formula; 2]>),
    /// f(a) or f(a, b)
    Call(Function, Vec<Formula>),
    /// if(left op right, then, otherwise)
    If(Comparison, Box<[Formula; 4]>),
}

/// + - * / ^
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// < <= > >=
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

/// The functions of the expression language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Exp,
    Log,
    Sqrt,
    Abs,
    Sign,
    Tanh,
    Min,
    Max,
    Floor,
}

impl Formula {
    /// Calls `visit` with every variable that occurs.
    pub fn visit_variables(&self, visit: &mut dyn FnMut(Variable)) {
        match self {
            Formula::Number(_) | Formula::Time | Formula::Parameter(_) | Formula::Input(_) => {}
            Formula::Variable(variable) => visit(*variable),
            Formula::Negate(inner) => inner.visit_variables(visit),
            Formula::Binary(_, operands) => operands.iter().for_each(|operand| operand.visit_variables(visit)),
            Formula::Call(_, arguments) => arguments.iter().for_each(|argument| argument.visit_variables(visit)),
            Formula::If(_, parts) => parts.iter().for_each(|part| part.visit_variables(visit)),
        }
    }
}

impl Mechanism {
    /// The user's name of a variable, such as `crank.angle`.
    pub fn variable_name(&self, variable: Variable) -> String {
        let owner = match variable.owner {
            Owner::Place(place) => self.place_name(place),
            Owner::Joint(joint) => self.joints[joint.0].name.clone(),
            Owner::Driver(driver) => self.drivers[driver.0].name.clone(),
            Owner::Load(load) => self.loads[load.0].name.clone(),
            Owner::System => return variable.quantity.word().to_string(),
        };
        format!("{owner}.{}", variable.quantity.word())
    }

    /// What each joint holds.
    pub fn joint_reactions(&self) -> Vec<Variable> {
        let reactions = |(index, joint): (usize, &Joint)| {
            let owner = Owner::Joint(JointId(index));
            joint.kind.reactions(self.dimension).iter().map(move |&quantity| Variable { owner, quantity })
        };
        self.joints.iter().enumerate().flat_map(reactions).collect()
    }

    /// What each driver must exert.
    pub fn driver_efforts(&self) -> Vec<Variable> {
        let efforts = |(index, driver): (usize, &Driver)| {
            let quantities: &[Quantity] = match (&driver.kind, self.dimension) {
                (DriverKind::Angle { .. }, _) => &[Quantity::Torque],
                (DriverKind::Displacement { .. }, _) => &[Quantity::Force],
                (DriverKind::Position { .. }, Dimension::One) => &[Quantity::Fx],
                (DriverKind::Position { .. }, Dimension::Two) => &[Quantity::Fx, Quantity::Fy],
            };
            let owner = Owner::Driver(DriverId(index));
            quantities.iter().map(move |&quantity| Variable { owner, quantity })
        };
        self.drivers.iter().enumerate().flat_map(efforts).collect()
    }
}

impl Quantity {
    /// The last word of a variable's name; the whole name for those of the system.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::X => "x",
            Quantity::Y => "y",
            Quantity::Angle => "angle",
            Quantity::Vx => "vx",
            Quantity::Vy => "vy",
            Quantity::Omega => "omega",
            Quantity::Ax => "ax",
            Quantity::Ay => "ay",
            Quantity::Alpha => "alpha",
            Quantity::S => "s",
            Quantity::V => "v",
            Quantity::A => "a",
            Quantity::Fx => "fx",
            Quantity::Fy => "fy",
            Quantity::Fn => "fn",
            Quantity::Ft => "ft",
            Quantity::Force => "force",
            Quantity::Torque => "torque",
            Quantity::Power => "power",
            Quantity::Length => "length",
            Quantity::Rate => "rate",
            Quantity::KineticEnergy => "energy.kinetic",
            Quantity::PotentialEnergy => "energy.potential",
            Quantity::TotalEnergy => "energy.total",
            Quantity::PositionResidual => "constraint.position",
            Quantity::VelocityResidual => "constraint.velocity",
        }
    }
}

impl Unit {
    /// s
    pub fn time() -> Unit {
        Unit { exponents: [0, 0, 1, 0], si: "s".to_string(), display: None }
    }

    /// rad
    pub fn angle() -> Unit {
        Unit { exponents: [0, 0, 0, 1], si: "rad".to_string(), display: None }
    }

    /// m
    pub fn length() -> Unit {
        Unit { exponents: [0, 1, 0, 0], si: "m".to_string(), display: None }
    }

    /// This unit divided by the second: rad/s, m/s2.
    pub fn per_second(&self) -> Unit {
        let [kg, m, s, rad] = self.exponents;
        let si = match self.si.strip_suffix("/s") {
            Some(base) => format!("{base}/s2"),
            None => format!("{}/s", self.si),
        };
        Unit { exponents: [kg, m, s - 1, rad], si, display: None }
    }
}

impl Mechanism {
    /// The user's name of a point.
    pub fn place_name(&self, place: Place) -> String {
        match place {
            Place::Origin => "ground".to_string(),
            Place::Ground(point) => format!("ground.{}", self.ground[point].name),
            Place::Centre(body) => self.bodies[body.0].name.clone(),
            Place::Point(body, point) => {
                let body = &self.bodies[body.0];
                format!("{}.{}", body.name, body.points[point].name)
            }
        }
    }
}
