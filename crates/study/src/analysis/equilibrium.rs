//! Static equilibrium: the configuration, its reactions, and its stability.

use cotree::formulate::Formulated;
use cotree_fmu::constraints::projection::check_redundant;
use cotree_fmu::model::Model;
use nalgebra::DMatrix;

use super::decompose::symmetric_eigen;
use super::modes::{VibrationMode, modes};
use super::requested::RequestedMode;
use super::search::{null_space, scales};
use super::supports::{Rest, rest};
use super::variation::{ColumnBlock, RowBlock, Variation};
use super::{AnalysisFailure, OperatingPoint, StateSpace};

/// Stiffness counts as none below this share of the largest.
const NEUTRAL: f64 = 1e-11;
/// A motion grows or decays if its rate is above this share of its own speed, and the other of the fastest motion's.
const OWN_RATE: f64 = 1e-9;
const RATE: f64 = 1e-12;
/// Singular values of the loop equations count as zero below this share of the largest.
const DETERMINED: f64 = 1e-10;
/// Loads have a potential if opposite entries of the stiffness differ by less than this share of the largest.
const SYMMETRIC: f64 = 1e-9;

/// A pose without accelerations, with its reactions.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    pub point: OperatingPoint,
    pub stability: Stability,
    /// What holds something together with others: how they share it is not determined, and the point has one way.
    pub shared: Vec<String>,
    /// Was that judged by the linearised motion, with damping and inertia? Otherwise, where that cannot be had, by stiffness alone.
    pub by_motion: bool,
    /// Eigenvalues of the projected stiffness \[J\], for changes of 1 rad and of the mechanism's length, ascending.
    pub stiffness: Vec<f64>,
}

/// The behaviour after a small disturbance from rest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stability {
    /// Nothing can move: joints and drivers constrain all coordinates.
    Held,
    /// Every motion that is left is pushed back, and none grows.
    Stable,
    /// A motion that meets no stiffness, with the coordinate that moves most; none grows.
    Neutral(String),
    /// A motion that neither grows nor decays, under loads without a potential: small terms that linearising drops decide.
    Undecided(String),
    /// A motion grows by itself, with the coordinate that moves most.
    Unstable(String),
}

impl Equilibrium {
    /// Searches from the scene's guess, with these parts held as they are asked to be. `formulated` belongs to the mechanism [at rest](super::at_rest).
    ///
    /// # Errors
    /// There is no equilibrium, or none was found.
    pub fn find(
        formulated: &Formulated,
        variation: &Variation,
        requested: &[RequestedMode],
    ) -> Result<Self, AnalysisFailure> {
        if let Some(part) = formulated.equations.system.mechanism.first_at_profile() {
            // The features on which a disc rests are found by events, not by an equilibrium.
            return Err(AnalysisFailure::Other(format!(
                "`{}` touches a profile, and which of its lines and arcs carry a load follows from a motion: no equilibrium is searched for; let `simulate` come to rest with dampers",
                part.name
            )));
        }
        let model = Model::new(formulated.lowered.program.clone())?;
        let guess = OperatingPoint::resting(&model, &formulated.state);
        let lasts = |point: &OperatingPoint| {
            let statics = TangentStiffness::new(formulated, variation, point)?;
            Ok(!matches!(statics.stability(formulated), Stability::Unstable(_)))
        };
        let Rest { point, shared } = rest(formulated, variation, &guess, requested, lasts)?;
        let mut state = formulated.state.clone();
        state.positions_mut().copy_from_slice(point.positions());
        check_redundant(&model, &state)?;
        check_courses(formulated, &point)?;
        let statics = TangentStiffness::new(formulated, variation, &point)?;
        let motion = StateSpace::new(formulated, variation, &point, None).and_then(|system| modes(formulated, &system));
        let held = statics.stiffness.is_empty() && formulated.equations.states.is_empty();
        let (stability, by_motion) = match motion {
            _ if held => (Stability::Held, true),
            Ok(modes) => (judged(formulated, &statics, &modes), true),
            Err(_) => (statics.stability(formulated), false),
        };
        Ok(Equilibrium { point, stability, shared, by_motion, stiffness: statics.stiffness })
    }
}

/// Ropes and bands over pulleys are followed by motions only: an equilibrium far from the start may have other wraps than those with which it was found.
fn check_courses(formulated: &Formulated, point: &OperatingPoint) -> Result<(), AnalysisFailure> {
    if formulated.equations.system.mechanism.turns().next().is_none() {
        return Ok(());
    }
    match formulated.equations.clone().off_course(point) {
        Some(why) => Err(AnalysisFailure::Other(format!(
            "no equilibrium was found from the guess: in the one that balances, {why}; start nearer to it in `[initial]`, or let `simulate` come to rest with dampers"
        ))),
        None => Ok(()),
    }
}

/// Stability by the linearised motion (Lyapunov's first method): unstable if a mode grows. Where modes neither grow nor decay, a potential decides, if there
/// is one: its minimum is stable (Dirichlet).
fn judged(formulated: &Formulated, statics: &TangentStiffness, modes: &[VibrationMode]) -> Stability {
    let scales = scales(formulated);
    let most = |mode: &VibrationMode| {
        let sizes = mode.shape.iter().zip(&scales).map(|(part, scale)| part.norm() / scale).enumerate();
        let index = sizes.fold((0, 0.0), |most, part| if part.1 > most.1 { part } else { most }).0;
        coordinate(formulated, index)
    };
    let fastest = modes.iter().map(|mode| mode.eigenvalue.norm()).fold(0.0, f64::max);
    let bound = |mode: &VibrationMode| OWN_RATE * mode.eigenvalue.norm() + RATE * fastest;
    let fastest_growing = modes.iter().max_by(|a, b| a.eigenvalue.re.total_cmp(&b.eigenvalue.re));
    if let Some(mode) = fastest_growing.filter(|mode| mode.eigenvalue.re > bound(mode)) {
        return Stability::Unstable(most(mode));
    }
    if let Some(mode) = modes.iter().find(|mode| mode.is_free()) {
        return Stability::Neutral(most(mode));
    }
    match modes.iter().find(|mode| mode.eigenvalue.re >= -bound(mode)) {
        None => Stability::Stable,
        Some(_) if statics.has_potential && formulated.equations.states.is_empty() => statics.stability(formulated),
        Some(mode) => Stability::Undecided(most(mode)),
    }
}

fn coordinate(formulated: &Formulated, index: usize) -> String {
    formulated.lowered.program.coordinates[index].name.clone()
}

struct TangentStiffness {
    /// Eigenvalues of the tangent stiffness on the motions that the loops permit, ascending. Of loads without a potential the symmetric
    /// part counts.
    stiffness: Vec<f64>,
    /// The coordinate that moves most in the softest of them.
    softest: usize,
    has_potential: bool,
}

impl TangentStiffness {
    fn new(formulated: &Formulated, variation: &Variation, point: &OperatingPoint) -> Result<Self, AnalysisFailure> {
        let numbers = variation.motion_at(&formulated.equations, point)?;
        // The states are held: how they answer is in the linearised motion.
        let mechanical = formulated.equations.coordinates.len();
        let scales = &scales(formulated)[..mechanical];
        let tangent = numbers.block(RowBlock::Motion, ColumnBlock::Positions);
        let loops = numbers.block(RowBlock::Loops, ColumnBlock::Positions);
        let tangent = DMatrix::from_fn(scales.len(), scales.len(), |i, j| tangent[(i, j)] * scales[i] * scales[j]);
        let loops = DMatrix::from_fn(loops.nrows(), scales.len(), |i, j| loops[(i, j)] * scales[j]);
        let free = null_space(&loops, DETERMINED)?;
        if free.is_empty() {
            return Ok(TangentStiffness { stiffness: Vec::new(), softest: 0, has_potential: true });
        }
        let projected = free.transpose() * tangent * &free;
        let has_potential = (&projected - projected.transpose()).amax() <= SYMMETRIC * projected.amax();
        let eigen = symmetric_eigen(0.5 * (&projected + projected.transpose()))?;
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let softest = (free * eigen.eigenvectors.column(order[0])).icamax();
        let stiffness = order.into_iter().map(|index| eigen.eigenvalues[index]).collect();
        Ok(TangentStiffness { stiffness, softest, has_potential })
    }

    fn stability(&self, formulated: &Formulated) -> Stability {
        let hardest = self.stiffness.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        match self.stiffness.first() {
            None => Stability::Held,
            Some(&least) if least < -NEUTRAL * hardest => Stability::Unstable(coordinate(formulated, self.softest)),
            Some(&least) if least <= NEUTRAL * hardest => Stability::Neutral(coordinate(formulated, self.softest)),
            Some(_) => Stability::Stable,
        }
    }
}
