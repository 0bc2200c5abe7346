//! Sensitivities of an equilibrium and of the vibrations about it.
//!
//! With H = d/dq (Phi_q^T lambda - Q) at rest,
//!
//! \[H Phi_q^T; Phi_q 0\] \[q_p; lambda_p\] = -\[d/dp (Phi_q^T lambda - Q); Phi_p\].
//!
//! An eigenvalue s of N(s) = \[s^2 M + s C + H, Phi_q^T; Phi_q, 0\], with N v = 0 and u^H N = 0, changes by s_p = -u^H N_p v / u^H (2 s M + C) v. N_p is the whole
//! change: the pose moves with the parameter (Murthy and Haftka, *Int. J. Numer. Methods Eng.* 26, 1988).

use cotree::expr::Symbol;
use cotree::formulate::Formulated;
use cotree::model::Mechanism;
use nalgebra::{Complex, DMatrix};

use super::super::decompose::{null_vector, svd};
use super::super::driven::DrivenInputs;
use super::super::modes::{VibrationMode, modes};
use super::super::search::scales;
use super::super::state_space::StateSpace;
use super::super::variation::{ColumnBlock, Numbers, RowBlock, Variation};
use super::super::{AnalysisFailure, Equilibrium, OperatingPoint, Study, StudyError, saddle};
use super::start::{check_repeated, stacked};
use super::{Sensitivities, VariedQuantity, varied};

/// A motion has no stiffness against it below this share of the largest singular value.
const SOFT: f64 = 1e-13;
/// Eigenvalues are the same within this share.
const SAME: f64 = 1e-6;
/// The eigenvalue of a defective pair has no derivative: u^H (2 s M + C) v is zero within this share.
const DEFECTIVE: f64 = 1e-8;

/// How the vibrations about an equilibrium change.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeChanges {
    /// The name of the scene.
    pub name: String,
    /// With respect to what, with its unit.
    pub parameters: Vec<(String, String)>,
    pub modes: Vec<VibrationMode>,
    /// Derivatives of each eigenvalue, one for each parameter; none of free motions and of eigenvalues that are there twice.
    pub derivatives: Vec<Option<Vec<Complex<f64>>>>,
}

/// The equilibrium and its change: a column for each parameter.
struct VariedRest {
    variation: Variation,
    positions: DMatrix<f64>,
    reactions: DMatrix<f64>,
}

impl Study {
    /// Derivatives of the scene's outputs where the mechanism rests.
    ///
    /// # Errors
    /// A name that cannot be set, no equilibrium, or one without derivatives: a motion without stiffness against it, or redundant joints that fit for these
    /// very lengths only.
    pub fn equilibrium_sensitivities(&mut self, to: &[String]) -> Result<Sensitivities, StudyError> {
        can_differentiate(&self.mechanism)?;
        self.rest(|formulated, _, equilibrium| {
            let parameters = varied(formulated, &DrivenInputs::default(), to)?;
            let rest = VariedRest::new(formulated, &equilibrium.point, &parameters)?;
            let numbers = rest.variation.at(&formulated.equations, &equilibrium.point)?;
            let of = |column: ColumnBlock| numbers.block(RowBlock::Outputs, column);
            let derivatives = of(ColumnBlock::Positions) * &rest.positions
                + of(ColumnBlock::Reactions) * &rest.reactions
                + of(ColumnBlock::Signals);
            let outputs = &formulated.outputs;
            Ok(Sensitivities {
                times: vec![equilibrium.point.time()],
                outputs: outputs.iter().map(|output| (output.name.clone(), output.unit.si.clone())).collect(),
                parameters: named(&parameters),
                values: vec![numbers.values(RowBlock::Outputs)],
                derivatives: vec![derivatives],
                steps: 0,
            })
        })
    }

    /// Vibrations about the equilibrium next to the start, and the derivatives of their eigenvalues.
    ///
    /// # Errors
    /// Those of [`Study::equilibrium_sensitivities`].
    pub fn mode_sensitivities(&mut self, to: &[String]) -> Result<ModeChanges, StudyError> {
        can_differentiate(&self.mechanism)?;
        self.rest(|formulated, variation, equilibrium| {
            let Equilibrium { point, .. } = equilibrium;
            let modes = modes(formulated, &StateSpace::new(formulated, variation, point, None)?)?;
            let parameters = varied(formulated, &DrivenInputs::default(), to)?;
            let rest = VariedRest::new(formulated, point, &parameters)?;
            let derivatives = rest.eigenvalues(formulated, point, &modes)?;
            let name = formulated.equations.system.mechanism.name.clone();
            Ok(ModeChanges { name, parameters: named(&parameters), modes, derivatives })
        })
    }
}

/// What is held wherever it stands keeps its place, and slides where a parameter takes it past its level.
fn can_differentiate(mechanism: &Mechanism) -> Result<(), AnalysisFailure> {
    let Some(held) = mechanism.first_held_anywhere() else { return Ok(()) };
    let what = format!(
        "{held} sticks in a whole range of equilibria, which has no derivatives; compare equilibria by `--set`, or give the friction a `velocity`"
    );
    Err(AnalysisFailure::NoDerivative { time: mechanism.experiment.start, what })
}

fn named(parameters: &[VariedQuantity]) -> Vec<(String, String)> {
    parameters.iter().map(|parameter| (parameter.name.clone(), parameter.unit.si.clone())).collect()
}

impl VariedRest {
    fn new(
        formulated: &mut Formulated,
        point: &OperatingPoint,
        parameters: &[VariedQuantity],
    ) -> Result<Self, AnalysisFailure> {
        let variation = Variation::by(formulated, parameters.iter().map(|parameter| parameter.symbol).collect());
        let numbers = variation.at(&formulated.equations, point)?;
        let refused = |what: &str| AnalysisFailure::NoDerivative { time: point.time(), what: what.to_owned() };
        let stiff = stiffness(&numbers);
        let n = stiff.nrows() - numbers.rows().count();
        let change = stacked(
            &numbers.block(RowBlock::Motion, ColumnBlock::Signals),
            &numbers.block(RowBlock::Loops, ColumnBlock::Signals),
        );
        let units = units(formulated, &stiff, n);
        let scaled = DMatrix::from_fn(stiff.nrows(), stiff.ncols(), |i, j| stiff[(i, j)] * units[i] * units[j]);
        let solution = if scaled.is_empty() {
            change
        } else {
            let values = svd(scaled.clone(), false, false)?.singular_values;
            let right = DMatrix::from_fn(change.nrows(), change.ncols(), |i, j| -change[(i, j)] * units[i]);
            let solved = scaled.lu().solve(&right).filter(|_| values.min() > SOFT * values.max());
            let soft = || refused("a degree of freedom has no stiffness, so the equilibrium is not determined");
            let mut solved = solved.ok_or_else(soft)?;
            solved.row_iter_mut().zip(&units).for_each(|(mut row, unit)| row.scale_mut(*unit));
            solved
        };
        let positions = solution.rows(0, n).into_owned();
        let reactions = solution.rows(n, solution.nrows() - n).into_owned();
        check_repeated(&numbers, &numbers.block(RowBlock::Repeated, ColumnBlock::Signals), &positions)
            .map_err(|_| refused("redundant joints are compatible for these values only"))?;
        drop(numbers);
        Ok(VariedRest { variation, positions, reactions })
    }

    /// The derivatives of each eigenvalue.
    fn eigenvalues(
        &self,
        formulated: &mut Formulated,
        point: &OperatingPoint,
        modes: &[VibrationMode],
    ) -> Result<Vec<Option<Vec<Complex<f64>>>>, AnalysisFailure> {
        let changes = self.changes(formulated, point)?;
        let numbers = self.variation.at(&formulated.equations, point)?;
        let stiffness = stiffness(&numbers);
        let (size, n) = (stiffness.nrows(), stiffness.nrows() - numbers.rows().count());
        let [mass, damping] = [ColumnBlock::Accelerations, ColumnBlock::Rates]
            .map(|column| numbers.block(RowBlock::Motion, column).resize(size, size, 0.0));
        let derivative = |mode: &VibrationMode| -> Result<Option<Vec<Complex<f64>>>, AnalysisFailure> {
            let s = mode.eigenvalue;
            let twice = |other: &&VibrationMode| (other.eigenvalue - s).norm() <= SAME * s.norm();
            if mode.is_free() || modes.iter().filter(twice).count() > 1 {
                return Ok(None);
            }
            let whole = |[mass, damping, rest]: [&DMatrix<f64>; 3]| {
                mass.map(Complex::from) * (s * s) + damping.map(Complex::from) * s + rest.map(Complex::from)
            };
            let system = whole([&mass, &damping, &stiffness]);
            let units = units(formulated, &system.map(Complex::norm), n);
            let scaled = |matrix: &DMatrix<Complex<f64>>| {
                DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * units[i] * units[j])
            };
            let system = scaled(&system);
            let [left, right] = [null_vector(system.adjoint(), 0)?, null_vector(system, 0)?];
            let slope = mass.map(Complex::from) * (s * 2.0) + damping.map(Complex::from);
            let slope = scaled(&slope);
            let along = |matrix: &DMatrix<Complex<f64>>| left.dotc(&(matrix * &right));
            let below = along(&slope);
            if below.norm() <= DEFECTIVE * slope.norm() {
                return Ok(None);
            }
            let change =
                |blocks: &[DMatrix<f64>; 3]| -along(&scaled(&whole([&blocks[0], &blocks[1], &blocks[2]]))) / below;
            Ok(Some(changes.iter().map(change).collect()))
        };
        modes.iter().map(derivative).collect()
    }

    /// The whole derivatives of mass, damping and \[H Phi_q^T; Phi_q 0\] for each parameter: the pose moves too.
    fn changes(
        &self,
        formulated: &mut Formulated,
        point: &OperatingPoint,
    ) -> Result<Vec<[DMatrix<f64>; 3]>, AnalysisFailure> {
        let numbers = self.variation.at(&formulated.equations, point)?;
        let all: Vec<Symbol> = [ColumnBlock::Positions, ColumnBlock::Reactions, ColumnBlock::Signals]
            .into_iter()
            .flat_map(|column| numbers.symbols(column))
            .collect();
        let second =
            self.variation.second(&mut formulated.equations, point, &all, &[RowBlock::Motion, RowBlock::Loops])?;
        let moving = self.positions.nrows() + self.reactions.nrows();
        let change = |parameter: usize| {
            let shares = self.positions.column(parameter).into_owned();
            let shares = shares
                .iter()
                .chain(self.reactions.column(parameter).into_owned().iter())
                .copied()
                .collect::<Vec<f64>>();
            let mut sum = second[moving + parameter].clone();
            for (matrix, share) in second[..moving].iter().zip(shares) {
                sum += matrix * share;
            }
            let of = |row: RowBlock, column: ColumnBlock| numbers.block_of(&sum, row, column);
            let (n, m) = (self.positions.nrows(), self.reactions.nrows());
            let [mass, damping] = [ColumnBlock::Accelerations, ColumnBlock::Rates]
                .map(|column| of(RowBlock::Motion, column).resize(n + m, n + m, 0.0));
            let [stiff, reactions] =
                [ColumnBlock::Positions, ColumnBlock::Reactions].map(|column| of(RowBlock::Motion, column));
            [mass, damping, saddle(&stiff, &reactions, &of(RowBlock::Loops, ColumnBlock::Positions))]
        };
        Ok((0..self.positions.ncols()).map(change).collect())
    }
}

/// \[H Phi_q^T; Phi_q 0\]
fn stiffness(numbers: &Numbers) -> DMatrix<f64> {
    let [stiff, reactions] =
        [ColumnBlock::Positions, ColumnBlock::Reactions].map(|column| numbers.block(RowBlock::Motion, column));
    saddle(&stiff, &reactions, &numbers.block(RowBlock::Loops, ColumnBlock::Positions))
}

/// Units of rows and columns in which the matrix has entries of one size.
fn units(formulated: &Formulated, matrix: &DMatrix<f64>, n: usize) -> Vec<f64> {
    let scales = scales(formulated);
    let largest = |rows: std::ops::Range<usize>| {
        let entries = rows.flat_map(|i| (0..n).map(move |j| (i, j)));
        entries
            .map(|(i, j)| matrix[(i, j)].abs() * scales[j] * scales.get(i).copied().unwrap_or(1.0))
            .fold(0.0, f64::max)
    };
    let [motion, loops] = [largest(0..n), largest(n..matrix.nrows())];
    let reaction = if motion > 0.0 && loops > 0.0 { motion / loops } else { 1.0 };
    scales.iter().copied().chain((n..matrix.nrows()).map(|_| reaction)).collect()
}
