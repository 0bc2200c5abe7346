//! Sparse matrices of complex constants, stored as the nonzero pieces of their columns.

use super::lane::{Lane, WIDTH, ZERO, add, minus, plus, splat};

/// One lane of one column.
#[derive(Clone, Copy, Debug)]
struct Piece {
    column: usize,
    re: Lane,
    im: Lane,
}

/// Pieces by the lanes that they add to.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    pieces: Vec<Piece>,
    /// First piece of each lane, and the end.
    first: Vec<usize>,
    /// For each entry: its piece and place, and its two coefficients.
    entries: Vec<(usize, usize, [u32; 2])>,
}

impl Columns {
    /// For entries (row, column, coefficients).
    pub fn new(lanes: usize, entries: &[(usize, usize, [u32; 2])]) -> Self {
        let mut places: Vec<(usize, usize)> = entries.iter().map(|(row, column, _)| (row / WIDTH, *column)).collect();
        places.sort_unstable();
        places.dedup();
        let first = (0..=lanes).map(|lane| places.partition_point(|place| place.0 < lane)).collect();
        let piece = |row: usize, column: usize| places.partition_point(|place| *place < (row / WIDTH, column));
        let entries = entries.iter().map(|&(row, column, c)| (piece(row, column), row % WIDTH, c)).collect();
        let pieces = places.iter().map(|&(_, column)| Piece { column, re: ZERO, im: ZERO }).collect();
        Self { pieces, first, entries }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[f64]) {
        self.pieces.iter_mut().for_each(|piece| (piece.re, piece.im) = (ZERO, ZERO));
        for &(piece, place, [re, im]) in &self.entries {
            self.pieces[piece].re[place] += coefficients[re as usize];
            self.pieces[piece].im[place] += coefficients[im as usize];
        }
    }

    /// sum + (re + i im)(x + i y)
    #[inline(always)]
    pub fn complex(&self, lane: usize, x: &[f64], y: &[f64], [mut gx, mut gy]: [Lane; 2]) -> [Lane; 2] {
        // Two sums for each, which do not wait for each other.
        let (mut hx, mut hy) = (ZERO, ZERO);
        for piece in &self.pieces[self.first[lane]..self.first[lane + 1]] {
            let (x, y) = (splat(x[piece.column]), splat(y[piece.column]));
            (gx, gy) = (plus(gx, piece.re, x), plus(gy, piece.re, y));
            (hx, hy) = (minus(hx, piece.im, y), plus(hy, piece.im, x));
        }
        [add(gx, hx), add(gy, hy)]
    }

    /// sum of re x + im y
    #[inline(always)]
    pub fn dot(&self, lane: usize, x: &[f64], y: &[f64]) -> Lane {
        let (mut re, mut im) = (ZERO, ZERO);
        for piece in &self.pieces[self.first[lane]..self.first[lane + 1]] {
            re = plus(re, piece.re, splat(x[piece.column]));
            im = plus(im, piece.im, splat(y[piece.column]));
        }
        add(re, im)
    }

    /// sum + (re + i im) x, x real
    #[inline(always)]
    pub fn real(&self, lane: usize, x: &[f64], [mut gx, mut gy]: [Lane; 2]) -> [Lane; 2] {
        for piece in &self.pieces[self.first[lane]..self.first[lane + 1]] {
            let x = splat(x[piece.column]);
            gx = plus(gx, piece.re, x);
            gy = plus(gy, piece.im, x);
        }
        [gx, gy]
    }
}
