//! What an importer sees of a variable, the same in both versions of FMI.

use std::sync::Arc;

use crate::model::Unit;

/// A variable of the description.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarVariable {
    /// The structured name, unique.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// What its values are.
    pub kind: Type,
    /// The unit of a real; the empty unit if it is not known or a pure number.
    pub unit: Unit,
    /// What it is to the importer.
    pub causality: Causality,
    /// When its value may change.
    pub variability: Variability,
    /// Its initial value, if it is calculated and that can be set.
    pub start: Option<StartValue>,
    /// Index of the variable whose derivative it is.
    pub derivative_of: Option<usize>,
    /// For a derivative, the place of its state among the states.
    pub state: Option<usize>,
    /// Indices of the inputs and states that it depends on while simulating.
    pub dependencies: Arc<[usize]>,
    /// The same with the parameters, and the number of variables if it depends on time: what FMI 3.0 counts as known.
    pub all_dependencies: Arc<[usize]>,
}

/// What the values of a variable are. Within the program each is a number: a Boolean 0 or 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Type {
    #[default]
    Real,
    /// Of 32 bits.
    Integer,
    Boolean,
}

/// When the value of a variable may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Before the end of initialisation only.
    Fixed,
    /// At communication points and events, if somebody sets it or what it follows.
    Tunable,
    /// At events.
    Discrete,
    /// At any time.
    Continuous,
}

/// The initial value of a calculated variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartValue {
    /// It holds.
    Exact(f64),
    /// A guess that picks the assembly.
    Approximate(f64),
}

/// What a variable is to the importer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Causality {
    /// Set before the simulation, or if tunable during it.
    Parameter {
        /// Default value, SI.
        start: f64,
        /// Smallest permitted value, SI.
        min: Option<f64>,
        /// Largest permitted value, SI.
        max: Option<f64>,
    },
    /// Follows parameters that can be set.
    CalculatedParameter,
    /// Set at communication points.
    Input {
        /// Value until it is set, SI.
        start: f64,
        /// Smallest permitted value, SI.
        min: Option<f64>,
        /// Largest permitted value, SI.
        max: Option<f64>,
    },
    /// Asked for by the scene.
    Output,
    /// Readable, but not asked for.
    Local,
    /// Time.
    Independent,
}

impl ScalarVariable {
    /// A real that may change at any time, and that nothing else is known of.
    pub fn new(name: String, description: String, unit: Unit, causality: Causality) -> Self {
        Self {
            name,
            description,
            kind: Type::Real,
            unit,
            causality,
            variability: Variability::Continuous,
            start: None,
            derivative_of: None,
            state: None,
            dependencies: [].into(),
            all_dependencies: [].into(),
        }
    }

    /// True for what is computed along the motion and changes with it all the time.
    pub fn flows(&self) -> bool {
        self.variability == Variability::Continuous && self.causality.follows_motion()
    }
}

impl Type {
    /// All of them.
    pub const ALL: [Type; 3] = [Type::Real, Type::Integer, Type::Boolean];

    /// The name of its element in FMI 2.0, and in FMI 3.0.
    pub fn elements(self) -> [&'static str; 2] {
        match self {
            Type::Real => ["Real", "Float64"],
            Type::Integer => ["Integer", "Int32"],
            Type::Boolean => ["Boolean", "Boolean"],
        }
    }

    /// A value as the standards write it; of a real the shortest text that reads back as the same number.
    pub fn text(self, value: f64) -> String {
        match self {
            Type::Real => format!("{value:?}"),
            Type::Integer => format!("{value:.0}"),
            Type::Boolean => (value != 0.0).to_string(),
        }
    }
}

impl Variability {
    /// The word for it in the standards.
    pub fn name(self) -> &'static str {
        match self {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        }
    }

    /// That of a parameter.
    pub fn of_parameter(is_tunable: bool) -> Self {
        if is_tunable { Variability::Tunable } else { Variability::Fixed }
    }
}

impl Causality {
    /// The word for it in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Causality::Parameter { .. } => "parameter",
            Causality::CalculatedParameter => "calculatedParameter",
            Causality::Input { .. } => "input",
            Causality::Output => "output",
            Causality::Local => "local",
            Causality::Independent => "independent",
        }
    }

    /// Of what the importer sets: its default, and the smallest and the largest value permitted, SI.
    pub fn range(self) -> Option<(f64, [Option<f64>; 2])> {
        match self {
            Causality::Parameter { start, min, max } | Causality::Input { start, min, max } => {
                Some((start, [min, max]))
            }
            Causality::CalculatedParameter | Causality::Output | Causality::Local | Causality::Independent => None,
        }
    }

    /// True if the value is computed along the motion.
    pub fn follows_motion(self) -> bool {
        matches!(self, Causality::Output | Causality::Local)
    }
}
