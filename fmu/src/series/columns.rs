//! Sparse matrices of complex constants, stored as the nonzero pieces of their columns.

use super::lane::{Lane, WIDTH, ZERO, add, minus, plus, splat};

/// An entry: row, column, coefficients.
pub(super) type Entry = (usize, usize, [u32; 2]);

/// One lane of one column for each piece, by the lanes that they add to.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    columns: Vec<usize>,
    re: Vec<Lane>,
    im: Vec<Lane>,
    /// Are all constants real?
    real: bool,
    /// First piece of each lane, and the end.
    first: Vec<usize>,
    /// For each entry: its piece and place, and its two coefficients.
    entries: Vec<(usize, usize, [u32; 2])>,
}

impl Columns {
    /// For entries of so many lanes.
    pub fn new(lanes: usize, entries: &[Entry]) -> Self {
        let mut places: Vec<(usize, usize)> = entries.iter().map(|(row, column, _)| (row / WIDTH, *column)).collect();
        places.sort_unstable();
        places.dedup();
        let first = (0..=lanes).map(|lane| places.partition_point(|place| place.0 < lane)).collect();
        let piece = |row: usize, column: usize| places.partition_point(|place| *place < (row / WIDTH, column));
        let entries = entries.iter().map(|&(row, column, c)| (piece(row, column), row % WIDTH, c)).collect();
        let columns: Vec<usize> = places.iter().map(|&(_, column)| column).collect();
        Self { re: vec![ZERO; columns.len()], im: vec![ZERO; columns.len()], columns, real: false, first, entries }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[f64]) {
        self.re.fill(ZERO);
        self.im.fill(ZERO);
        for &(piece, place, [re, im]) in &self.entries {
            self.re[piece][place] += coefficients[re as usize];
            self.im[piece][place] += coefficients[im as usize];
        }
        self.real = self.im.iter().all(|im| *im == ZERO);
    }

    /// Number of entries.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// So many lanes are added to.
    pub fn lanes(&self) -> usize {
        self.first.len() - 1
    }

    /// The pieces of a lane: column, real and imaginary parts.
    #[inline(always)]
    pub fn pieces(&self, lane: usize) -> impl Iterator<Item = (usize, Lane, Lane)> {
        let range = self.first[lane]..self.first[lane + 1];
        let parts = self.re[range.clone()].iter().zip(&self.im[range.clone()]);
        self.columns[range].iter().zip(parts).map(|(column, (re, im))| (*column, *re, *im))
    }

    /// sum + (re + i im)(x + i y)
    #[inline(always)]
    pub fn complex(&self, lane: usize, x: &[f64], y: &[f64], [mut gx, mut gy]: [Lane; 2]) -> [Lane; 2] {
        // Two sums for each, which do not wait for each other.
        let (mut hx, mut hy) = (ZERO, ZERO);
        if self.real {
            let range = self.first[lane]..self.first[lane + 1];
            let (columns, re) = (&self.columns[range.clone()], &self.re[range]);
            let mut i = 0;
            while i + 1 < columns.len() {
                (gx, gy) = (plus(gx, re[i], splat(x[columns[i]])), plus(gy, re[i], splat(y[columns[i]])));
                i += 1;
                (hx, hy) = (plus(hx, re[i], splat(x[columns[i]])), plus(hy, re[i], splat(y[columns[i]])));
                i += 1;
            }
            if i < columns.len() {
                (gx, gy) = (plus(gx, re[i], splat(x[columns[i]])), plus(gy, re[i], splat(y[columns[i]])));
            }
        } else {
            for (column, re, im) in self.pieces(lane) {
                let (x, y) = (splat(x[column]), splat(y[column]));
                (gx, gy) = (plus(gx, re, x), plus(gy, re, y));
                (hx, hy) = (minus(hx, im, y), plus(hy, im, x));
            }
        }
        [add(gx, hx), add(gy, hy)]
    }

    /// sum of re x + im y
    #[inline(always)]
    pub fn dot(&self, lane: usize, x: &[f64], y: &[f64]) -> Lane {
        let (mut re, mut im) = (ZERO, ZERO);
        for (column, by_x, by_y) in self.pieces(lane) {
            re = plus(re, by_x, splat(x[column]));
            im = plus(im, by_y, splat(y[column]));
        }
        add(re, im)
    }

    /// sum + (re + i im) x, x real
    #[inline(always)]
    pub fn real(&self, lane: usize, x: &[f64], [mut gx, mut gy]: [Lane; 2]) -> [Lane; 2] {
        for (column, re, im) in self.pieces(lane) {
            let x = splat(x[column]);
            gx = plus(gx, re, x);
            gy = plus(gy, im, x);
        }
        [gx, gy]
    }
}
