//! Linear algebra of the runtime.
//!
//! * `dense`: LU factors of a square matrix.
//! * `elimination`: rows with few entries, solved for as many unknowns as are independent.
//! * [`sparse`], `factors`: sparse factors, of normal equations and of a symmetric matrix with a static pattern.
//! * `inverse`, `matrix`: the matrix of a pose, as a whole or by its entries.
//! * `chain`, `tree`, `columns`: open chains of frames, trees of arms, and sparse constants by columns.
//! * [`least_squares`], [`singular_values`], `spectrum`: minimum-norm solutions, the decomposition of a matrix, and the ends of a spectrum.
//! * `lane`, `turn`: four numbers and four angles at a time; `number`, `dual`, `varied`: numbers alone, numbers and matrices with their
//!   derivatives; `quad`, `inverses`: numbers and inverses of four motions.

pub(crate) mod chain;
pub(crate) mod columns;
pub(crate) mod dense;
pub(crate) mod dual;
pub(crate) mod elimination;
pub(crate) mod factors;
pub(crate) mod inverse;
pub(crate) mod inverses;
pub(crate) mod lane;
pub mod least_squares;
pub(crate) mod matrix;
pub(crate) mod number;
pub(crate) mod quad;
pub mod singular_values;
pub mod sparse;
pub(crate) mod spectrum;
pub(crate) mod tree;
pub(crate) mod turn;
pub(crate) mod varied;

/// Rounding errors of some operations with numbers of size 1: some fifty of them.
pub(crate) const ROUNDING_OF_SUMS: f64 = 1e-14;
/// The least that a few operations with numbers of size 1 are wrong by.
pub(crate) const SPACINGS: f64 = 4.0 * f64::EPSILON;
/// Singular values below this share of the largest do not count.
pub(crate) const RANK: f64 = 1e-10;
/// A pivot counts as zero if it is less than this share of what it is left of: some hundred roundings.
const SINGULAR: f64 = 1e-13;
