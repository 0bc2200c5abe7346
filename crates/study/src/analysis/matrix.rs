//! Matrices of numbers, from blocks and from sparse rows of expressions.

use cotree::expr::Expr;
use nalgebra::DMatrix;

/// \[A B; C 0\]
pub fn saddle(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = b.shape();
    let mut whole = DMatrix::zeros(n + m, n + m);
    whole.view_mut((0, 0), (n, n)).copy_from(a);
    whole.view_mut((0, n), (n, m)).copy_from(b);
    whole.view_mut((n, 0), (m, n)).copy_from(c);
    whole
}

/// Rows of (column, entry) as numbers; `values` are those of expressions.
pub fn dense<'e>(
    rows: impl IntoIterator<Item = &'e Vec<(usize, Expr)>>,
    columns: usize,
    values: impl Fn(&[Expr]) -> Vec<f64>,
) -> DMatrix<f64> {
    let rows: Vec<&Vec<(usize, Expr)>> = rows.into_iter().collect();
    let entries = || {
        rows.iter().enumerate().flat_map(|(row, entries_of_row)| entries_of_row.iter().map(move |entry| (row, entry)))
    };
    let exprs: Vec<Expr> = entries().map(|(_, (_, expr))| *expr).collect();
    let mut matrix = DMatrix::zeros(rows.len(), columns);
    for ((row, (column, _)), number) in entries().zip(values(&exprs)) {
        matrix[(row, *column)] = number;
    }
    matrix
}
