//! Singular values of a matrix as one function: generic code is compiled with the crate that names its types, and the exporter's own code is optimised less than the runtime.

use nalgebra::{DMatrix, Dyn, SVD};

/// Singular values in descending order, with the vectors to the left and to the right if they are asked for.
#[inline(never)]
pub fn svd(matrix: DMatrix<f64>, left: bool, right: bool) -> SVD<f64, Dyn, Dyn> {
    matrix.svd(left, right)
}
