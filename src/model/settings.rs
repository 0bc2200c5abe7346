//! How the mechanism is to be formulated, integrated and run.

use crate::diagnostic::Span;

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

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// How motion is integrated.
    pub method: Method,
    /// Relative tolerance, if not the experiment's.
    pub rtol: Option<f64>,
    /// Absolute tolerance, if cotree is not to choose it.
    pub atol: Option<f64>,
    /// Longest step \[s\].
    pub max_step: Option<f64>,
    /// Longest time that the computer may take for a communication step \[s\].
    pub time_budget: Option<f64>,
}

/// How motion is integrated.
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
pub enum CoordinateChoice {
    /// Tables 2 and 3.
    Recommended,
    /// All bodies in both trees.
    Absolute,
    /// The same joints in both trees.
    Joint,
    /// Names of bodies, joints, drivers and loads that are branches, beside the rigid arms and ground vectors; `None`: recommended.
    Chosen {
        /// Branches of the translational tree.
        translation: Option<Vec<(String, Span)>>,
        /// Branches of the rotational tree.
        rotation: Option<Vec<(String, Span)>>,
    },
}
