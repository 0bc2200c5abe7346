//! Natural vibrations: the eigenvalues of the independent motion, with shapes in all coordinates.

use cotree::equations::MotionVariable;
use cotree::formulate::Formulated;
use nalgebra::{Complex, DMatrix, DVector};

use super::AnalysisFailure;
use super::decompose::{self, null_vector};
use super::search::{null_space, scales};
use super::state_space::StateSpace;

/// Stiffness counts as none below this share of the largest.
const FREE: f64 = 1e-12;
/// An eigenvalue counts as zero below this share of the largest.
const ZERO: f64 = 1e-9;
/// Rounding errors move a double eigenvalue by their root.
const DOUBLE: f64 = 1e-7;
/// Eigenvalues are the same within this share.
const SAME: f64 = 1e-6;

/// One mode; of a conjugate pair the one that turns forward.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationMode {
    /// [1/s]; zero for free motion.
    pub eigenvalue: Complex<f64>,
    /// Of every branch coordinate, then of every state of the scene; the largest part, in natural units, is 1.
    pub shape: Vec<Complex<f64>>,
}

impl VibrationMode {
    /// Moves on without any stiffness against it.
    pub fn is_free(&self) -> bool {
        self.eigenvalue == Complex::default()
    }

    /// Oscillations a second \[Hz\]; zero if it does not oscillate.
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.im / std::f64::consts::TAU
    }

    /// Oscillations a second without damping, |eigenvalue| / 2 pi \[Hz\].
    pub fn natural_frequency(&self) -> f64 {
        self.eigenvalue.norm() / std::f64::consts::TAU
    }

    /// 1 or more: no oscillation; negative: it grows. Free motion has none.
    pub fn damping_ratio(&self) -> Option<f64> {
        (!self.is_free()).then(|| (0.0 - self.eigenvalue.re) / self.eigenvalue.norm())
    }
}

/// The modes of a linear system, slowest first: the independent coordinates z with z'' = K z + C z'.
///
/// # Errors
/// The eigenvalues do not converge, or the numbers are too large.
pub fn modes(formulated: &Formulated, system: &StateSpace) -> Result<Vec<VibrationMode>, AnalysisFailure> {
    if !formulated.equations.states.is_empty() {
        return with_states(formulated, system);
    }
    let scales = scales(formulated);
    let scale_of: Vec<f64> = system.partition.independent.iter().map(|&index| scales[index]).collect();
    let f = scale_of.len();
    let natural =
        |first: usize| DMatrix::from_fn(f, f, |i, j| system.a[(f + i, first + j)] * scale_of[j] / scale_of[i]);
    let (stiffness, damping) = (natural(0), natural(f));
    let free = null_space(&stiffness, FREE)?;
    let mut shapes: Vec<(Complex<f64>, DVector<Complex<f64>>)> =
        free.column_iter().map(|motion| (Complex::default(), motion.map(Complex::from))).collect();
    let eigenvalues = eigenvalues(&stiffness, &damping, &free)?;
    for (index, &eigenvalue) in eigenvalues.iter().enumerate() {
        let repeated =
            eigenvalues[..index].iter().filter(|other| (*other - eigenvalue).norm() < SAME * eigenvalue.norm());
        shapes.push((eigenvalue, vibration(&stiffness, &damping, eigenvalue, repeated.count())?));
    }
    let expand = |(eigenvalue, natural): (Complex<f64>, DVector<Complex<f64>>)| {
        let z = DVector::from_fn(f, |row, _| natural[row] * scale_of[row]);
        let shape = normalised(system.shape.map(Complex::from) * z, &scales);
        VibrationMode { eigenvalue: unsigned(eigenvalue), shape: shape.into_iter().map(unsigned).collect() }
    };
    Ok(shapes.into_iter().map(expand).collect())
}

/// The same with states of the scene: the eigenvalues of the whole system x' = A x, one of each conjugate pair.
fn with_states(formulated: &Formulated, system: &StateSpace) -> Result<Vec<VibrationMode>, AnalysisFailure> {
    let (scales, layout) = (scales(formulated), formulated.equations.motion_layout());
    let scale_of: Vec<f64> = system.partition.independent.iter().map(|&index| scales[index]).collect();
    let states = formulated.equations.states.len();
    let f = scale_of.len() - states;
    // The positions, their rates, the states.
    let natural: Vec<f64> = scale_of[..f].iter().chain(&scale_of).copied().collect();
    let size = natural.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| system.a[(i, j)] * natural[j] / natural[i]);
    let found = eigenvalues_with_states(&matrix)?;
    let mut modes = Vec::new();
    for (index, &eigenvalue) in found.iter().enumerate() {
        let same = |other: &&Complex<f64>| (**other - eigenvalue).norm() <= SAME * eigenvalue.norm();
        let repeated = found[..index].iter().filter(same).count();
        let turned = DMatrix::from_fn(size, size, |i, j| {
            let diagonal = if i == j { eigenvalue } else { Complex::default() };
            diagonal - Complex::from(matrix[(i, j)])
        });
        let x = null_vector(turned, repeated)?;
        let q = DVector::from_fn(f, |row, _| x[row] * natural[row]);
        let q = system.shape.map(Complex::from) * q;
        let all = DVector::from_fn(scales.len(), |row, _| match layout.variable(row) {
            MotionVariable::Coordinate(row) => q[row],
            MotionVariable::State(state) => x[2 * f + state] * natural[2 * f + state],
        });
        let shape = normalised(all, &scales).into_iter().map(unsigned).collect();
        modes.push(VibrationMode { eigenvalue: unsigned(eigenvalue), shape });
    }
    Ok(modes)
}

/// One of each conjugate pair, the slowest first; exactly zero for free motions.
fn eigenvalues_with_states(matrix: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, AnalysisFailure> {
    let free = null_space(matrix, FREE)?.ncols();
    let mut found = decompose::eigenvalues(matrix.clone())?;
    found.retain(|value| value.im >= 0.0);
    found.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    let largest = found.iter().map(|value| value.norm()).fold(0.0, f64::max);
    // What moves on without any stiffness is a double zero, which rounding turns into a slow motion.
    let still = found.iter().take(2 * free).filter(|value| value.norm() <= DOUBLE * largest).count();
    found[..still].fill(Complex::default());
    if free == 1 {
        found.dedup_by(|a, b| [*a, *b] == [Complex::default(); 2]);
    }
    Ok(found)
}

/// Eigenvalues other than zero with a positive or no imaginary part, by size. Free motions are deflated first: the rest has no double zero, which
/// rounding would turn into a slow oscillation.
fn eigenvalues(
    stiffness: &DMatrix<f64>,
    damping: &DMatrix<f64>,
    free: &DMatrix<f64>,
) -> Result<Vec<Complex<f64>>, AnalysisFailure> {
    let (f, p) = (stiffness.nrows(), free.ncols());
    if f == 0 {
        return Ok(Vec::new());
    }
    // First the free motions, then what is perpendicular to them.
    let mut columns = free.clone().resize_horizontally(p + f, 0.0);
    columns.view_mut((0, p), (f, f)).fill_with_identity();
    let axes = columns.qr().q();
    let turned = |matrix: &DMatrix<f64>| axes.transpose() * matrix * &axes;
    let (stiffness, damping) = (turned(stiffness), turned(damping));
    let size = 2 * f - p;
    let mut system = DMatrix::zeros(size, size);
    system.view_mut((0, f), (f - p, f - p)).fill_with_identity();
    system.view_mut((f - p, 0), (f, f - p)).copy_from(&stiffness.columns(p, f - p));
    system.view_mut((f - p, f - p), (f, f)).copy_from(&damping);
    let mut found = decompose::eigenvalues(system)?;
    let largest = found.iter().map(|value| value.norm()).fold(0.0, f64::max);
    found.retain(|value| value.norm() > ZERO * largest && value.im >= 0.0);
    found.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    // Which of two of the same size comes first must not depend on rounding.
    for same in found.chunk_by_mut(|a, b| b.norm() - a.norm() <= SAME * b.norm()) {
        same.sort_by(|a, b| a.re.total_cmp(&b.re));
    }
    Ok(found)
}

/// The null vector of lambda^2 - lambda C - K, or the next one of a repeated eigenvalue.
fn vibration(
    stiffness: &DMatrix<f64>,
    damping: &DMatrix<f64>,
    eigenvalue: Complex<f64>,
    repeated: usize,
) -> Result<DVector<Complex<f64>>, AnalysisFailure> {
    let f = stiffness.nrows();
    let square = eigenvalue * eigenvalue;
    let matrix = DMatrix::from_fn(f, f, |i, j| {
        let diagonal = if i == j { square } else { Complex::default() };
        diagonal - eigenvalue * damping[(i, j)] - stiffness[(i, j)]
    });
    null_vector(matrix, repeated)
}

/// Zero has no sign: adding it takes one away.
fn unsigned(value: Complex<f64>) -> Complex<f64> {
    Complex::new(value.re + 0.0, value.im + 0.0)
}

/// Scaled so that its largest part, in natural units, is 1.
fn normalised(shape: DVector<Complex<f64>>, scales: &[f64]) -> Vec<Complex<f64>> {
    let sizes = shape.iter().zip(scales).map(|(value, scale)| (value.norm() / scale, *value));
    // Of equal parts the first, independently of rounding.
    let largest =
        sizes.fold((0.0, Complex::from(1.0)), |most, part| if part.0 > most.0 * (1.0 + SAME) { part } else { most });
    shape.iter().map(|value| value / largest.1).collect()
}
