//! Matrix decompositions that terminate for any numbers: those of the library loop or panic if an entry is not finite.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, ComplexField, DMatrix, DVector, Dyn, SVD, Schur, SymmetricEigen};

use super::AnalysisFailure;

/// Iterations for each row and column.
const ITERATIONS: usize = 300;
/// A singular value below this share of the largest is a rounding error.
const NOTHING: f64 = 1e-12;

/// Singular values, in descending order, and vectors.
///
/// # Errors
/// The numbers are too large.
pub(crate) fn svd<T: ComplexField<RealField = f64>>(
    matrix: DMatrix<T>,
    left: bool,
    right: bool,
) -> Result<SVD<T, Dyn, Dyn>, AnalysisFailure> {
    let most = iterations(&matrix)?;
    let found = SVD::try_new_unordered(matrix, left, right, 5.0 * f64::EPSILON, most);
    let mut found = found.filter(|svd| !svd.singular_values.iter().any(|value| value.is_nan()));
    found.iter_mut().for_each(SVD::sort_by_singular_values);
    found.ok_or(AnalysisFailure::Range)
}

/// x of the damped least-squares problem |A x - b|^2 + damping |x|^2; without damping the smallest of the best.
///
/// # Errors
/// The numbers are too large.
pub(crate) fn least_squares(a: &DMatrix<f64>, b: &DVector<f64>, damping: f64) -> Result<DVector<f64>, AnalysisFailure> {
    if a.is_empty() {
        return Ok(DVector::zeros(a.ncols()));
    }
    let svd = svd(a.clone(), true, true)?;
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(AnalysisFailure::Range) };
    let least = NOTHING * svd.singular_values.max();
    let mut parts = u.tr_mul(b);
    for (part, &s) in parts.iter_mut().zip(&svd.singular_values) {
        *part *= if s > least { s / (s * s + damping) } else { 0.0 };
    }
    Ok(v_t.tr_mul(&parts))
}

/// v with N v = 0, or of a smallest singular value that is there more than once the one so many before. With the adjoint matrix the left one: those that the
/// library gives beside the right ones may be wrong.
///
/// # Errors
/// Those of [`svd`].
pub(super) fn null_vector(
    matrix: DMatrix<Complex<f64>>,
    before: usize,
) -> Result<DVector<Complex<f64>>, AnalysisFailure> {
    let last = matrix.ncols() - 1;
    let vectors = svd(matrix, false, true)?.v_t.ok_or(AnalysisFailure::Range)?;
    Ok(vectors.row(last - before.min(last)).adjoint())
}

/// Eigenvalues and vectors of a symmetric matrix.
///
/// # Errors
/// The numbers are too large.
pub(super) fn symmetric_eigen(matrix: DMatrix<f64>) -> Result<SymmetricEigen<f64, Dyn>, AnalysisFailure> {
    let most = iterations(&matrix)?;
    SymmetricEigen::try_new(matrix, f64::EPSILON, most).ok_or(AnalysisFailure::Range)
}

/// Eigenvalues of a square matrix.
///
/// # Errors
/// The numbers are too large, or the iteration does not converge.
pub(super) fn eigenvalues(mut matrix: DMatrix<f64>) -> Result<Vec<Complex<f64>>, AnalysisFailure> {
    let most = iterations(&matrix)?;
    // Balancing squares the entries: in units of a power of two near the largest, which rounds nothing, the squares are numbers.
    let largest = matrix.amax();
    let unit = if largest > 0.0 { 2.0_f64.powi(libm::ilogb(largest).clamp(-1022, 1022)) } else { 1.0 };
    matrix /= unit;
    balance_parlett_reinsch(&mut matrix);
    let schur = Schur::try_new(matrix, f64::EPSILON, most).ok_or_else(|| {
        AnalysisFailure::Other("the eigenvalues cannot be computed: the iteration does not converge".to_owned())
    })?;
    let found: Vec<_> = schur.complex_eigenvalues().iter().map(|value| value * unit).collect();
    let finite = found.iter().all(|value| value.re.is_finite() && value.im.is_finite());
    if finite { Ok(found) } else { Err(AnalysisFailure::Range) }
}

/// How many iterations a matrix is worth.
fn iterations<T: ComplexField>(matrix: &DMatrix<T>) -> Result<usize, AnalysisFailure> {
    let finite = matrix.iter().all(ComplexField::is_finite);
    if finite { Ok(ITERATIONS * (matrix.nrows() + matrix.ncols()).max(1)) } else { Err(AnalysisFailure::Range) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ODD: [f64; 5] = [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, 0.0];

    /// Matrices of any size up to 6 in which numbers out of all range stand beside ordinary ones.
    fn matrices() -> impl Iterator<Item = DMatrix<f64>> {
        let filled = |size: usize, odd: f64, place: usize| {
            DMatrix::from_fn(size, size, |i, j| if (i + 2 * j) % 5 == place { odd } else { (1 + i * size + j) as f64 })
        };
        (1..=6).flat_map(move |size| {
            ODD.into_iter().flat_map(move |odd| (0..5).map(move |place| filled(size, odd, place)))
        })
    }

    #[test]
    fn every_decomposition_ends() {
        for matrix in matrices() {
            let finite = matrix.iter().all(|value| value.is_finite());
            let complex = matrix.map(|value| Complex::new(value, -value));
            let ends = [
                svd(matrix.clone(), true, true).is_ok(),
                svd(complex, false, true).is_ok(),
                symmetric_eigen(&matrix + matrix.transpose()).is_ok(),
                eigenvalues(matrix.clone()).is_ok(),
            ];
            assert!(finite || ends == [false; 4], "{matrix}{ends:?}");
        }
    }

    #[test]
    fn numbers_far_from_one_have_their_eigenvalues() {
        for size in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let mut found = eigenvalues(DMatrix::from_row_slice(2, 2, &[0.0, 2.0, 8.0, 0.0]) * size).unwrap();
            found.sort_by(|a, b| a.re.total_cmp(&b.re));
            for (found, expected) in found.iter().zip([-4.0, 4.0]) {
                assert!((found.re / size - expected).abs() < 1e-12 && found.im == 0.0, "{found} at {size}");
            }
        }
    }

    fn null_vectors(matrix: &DMatrix<Complex<f64>>) -> [DVector<Complex<f64>>; 2] {
        [matrix.adjoint(), matrix.clone()].map(|matrix| null_vector(matrix, 0).expect("numbers"))
    }

    /// Two damped masses at one of their eigenvalues: by the complex decomposition the left vector leaves 5.4.
    #[test]
    fn null_vectors_of_two_damped_masses() {
        let coupling = Complex::new(23.785532594135713, -7.482043350450101);
        let expected = [(23.554504622836582, -13.491347659062852), (22.81303183960336, -2.0442046662145783)];
        let [first, second] = expected.map(|(re, im)| Complex::new(re, im));
        let matrix = DMatrix::from_row_slice(2, 2, &[first, coupling, coupling, second]);
        let [left, right] = null_vectors(&matrix);
        assert!((left.adjoint() * &matrix).norm() < 1e-12 && (&matrix * &right).norm() < 1e-12);
    }

    /// Products of n x (n - 1) and (n - 1) x n matrices with entries about one.
    #[test]
    fn null_vectors_are_those_of_the_matrix() {
        let mut seed = 1.0_f64;
        let mut random = || {
            seed = (seed * 78.233).sin() * 43758.5453;
            seed -= seed.floor();
            2.0 * seed - 1.0
        };
        for n in (2..7).flat_map(|n| [n; 20]) {
            let mut factor = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| Complex::new(random(), random()));
            let matrix = factor(n, n - 1) * factor(n - 1, n);
            let [left, right] = null_vectors(&matrix);
            let (across, along) = (left.adjoint() * &matrix, &matrix * &right);
            assert!(along.norm() < 1e-12 && across.norm() < 1e-12, "{n}: {across} {along}");
            assert!((left.norm() - 1.0).abs() < 1e-12 && (right.norm() - 1.0).abs() < 1e-12, "{n}");
        }
    }
}
