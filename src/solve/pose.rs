//! The pose in which the sizes of expressions are judged.

/// A consistent pose at default parameters: where the weight of pivots is judged.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// Time \[s\].
    pub time: f64,
    pub positions: Vec<f64>,
    pub followers: Vec<f64>,
    pub states: Vec<f64>,
}
