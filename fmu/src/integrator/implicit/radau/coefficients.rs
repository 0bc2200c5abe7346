//! The numbers of the method. Their digits are those of the source, so that they can be compared with it.
#![allow(clippy::excessive_precision, reason = "to be compared with the source")]

use nalgebra::Complex;

use crate::linalg::lane;
use crate::linalg::lane::{Lane, splat};

const SQRT_6: f64 = 2.449_489_742_783_178;
/// Order of the polynomial that the dense output is.
pub const DENSE_ORDER: usize = 5;
/// Nodes.
pub const NODES: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];
/// The slope at the start of the cubic through zero at the start and the stages.
pub const SLOPE: [f64; 3] = [(13.0 + 7.0 * SQRT_6) / 3.0, (13.0 - 7.0 * SQRT_6) / 3.0, 1.0 / 3.0];
/// Eigenvalues of the inverse of the method's matrix: the real one, and one of the complex pair.
pub const REAL: f64 = 3.637_834_252_744_495_7;
pub const COMPLEX: Complex<f64> = Complex::new(2.681_082_873_627_752, 3.050_430_199_247_41);
/// Its eigenvectors: z = FROM w, w = INTO z.
const FROM_ROWS: [[f64; 3]; 3] = [
    [0.091_232_394_870_892_94, -0.141_255_295_020_954_2, -0.030_029_194_105_147_424],
    [0.241_717_932_707_107, 0.204_129_352_293_8, 0.382_942_112_757_261_94],
    [0.966_048_182_615_092_9, 1.0, 0.0],
];
const INTO_ROWS: [[f64; 3]; 3] = [
    [4.325_579_890_063_155, 0.339_199_251_815_809_9, 0.541_770_539_935_874_9],
    [-4.178_718_591_551_905, -0.327_682_820_761_062_4, 0.476_623_554_500_550_45],
    [-0.502_872_634_945_786_9, 2.571_926_949_855_605_4, -0.596_039_204_828_224_9],
];
const BLOCKS: [[f64; 3]; 3] = [[REAL, 0.0, 0.0], [0.0, COMPLEX.re, -COMPLEX.im], [0.0, COMPLEX.im, COMPLEX.re]];
const INVERSE_ROWS: [[f64; 3]; 3] = product(&product(&FROM_ROWS, &BLOCKS), &INTO_ROWS);
/// By columns: the eigenvectors, the inverse of the method's matrix and its square.
pub const FROM: [Lane; 3] = columns(&FROM_ROWS);
pub const INTO: [Lane; 3] = columns(&INTO_ROWS);
pub const INVERSE: [Lane; 3] = columns(&INVERSE_ROWS);
pub const SQUARE: [Lane; 3] = columns(&product(&INVERSE_ROWS, &INVERSE_ROWS));

/// Times of the nodes of a step.
pub fn nodes(time: f64, h: f64) -> [f64; 3] {
    NODES.map(|node| time + node * h)
}

/// The columns of a matrix, with the last row twice.
const fn columns(rows: &[[f64; 3]; 3]) -> [Lane; 3] {
    let [first, second, third] = rows;
    [
        [first[0], second[0], third[0], third[0]],
        [first[1], second[1], third[1], third[1]],
        [first[2], second[2], third[2], third[2]],
    ]
}

const fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut product = [[0.0; 3]; 3];
    let mut place = 0;
    while place < 9 {
        let (row, column) = (place / 3, place % 3);
        product[row][column] = a[row][0] * b[0][column] + a[row][1] * b[1][column] + a[row][2] * b[2][column];
        place += 1;
    }
    product
}

/// A matrix, by columns, times the first three numbers of a lane.
#[inline(always)]
pub fn turn(matrix: &[Lane; 3], from: Lane) -> Lane {
    let sum = lane::multiply(matrix[0], splat(from[0]));
    lane::plus(lane::plus(sum, matrix[1], splat(from[1])), matrix[2], splat(from[2]))
}
