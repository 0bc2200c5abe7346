//! Sparse matrices of complex constants, stored as the nonzero pieces of their columns.

use super::lane::{Lane, WIDTH, add, minus, plus, splat};
use super::number::Number;

/// An entry: row, column, coefficients.
pub(crate) type Entry = (usize, usize, [u32; 2]);

/// One lane of one column for each piece, by the lanes that they add to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns<N = f64, const L: usize = WIDTH> {
    columns: Vec<usize>,
    re: Vec<Lane<N, L>>,
    im: Vec<Lane<N, L>>,
    /// Are all constants real?
    real: bool,
    /// First piece of each lane, and the end.
    first: Vec<usize>,
    /// For each entry: its piece and place, and its two coefficients.
    entries: Vec<(usize, usize, [u32; 2])>,
}

impl<N: Number, const L: usize> Columns<N, L> {
    /// For entries of so many lanes.
    pub fn new(lanes: usize, entries: &[Entry]) -> Self {
        let mut places: Vec<(usize, usize)> = entries.iter().map(|(row, column, _)| (row / L, *column)).collect();
        places.sort_unstable();
        places.dedup();
        let first = (0..=lanes).map(|lane| places.partition_point(|place| place.0 < lane)).collect();
        let piece = |row: usize, column: usize| places.partition_point(|place| *place < (row / L, column));
        let entries = entries.iter().map(|&(row, column, c)| (piece(row, column), row % L, c)).collect();
        let columns: Vec<usize> = places.iter().map(|&(_, column)| column).collect();
        let zeros = vec![splat(N::ZERO); columns.len()];
        Self { re: zeros.clone(), im: zeros, columns, real: false, first, entries }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[N]) {
        self.re.fill(splat(N::ZERO));
        self.im.fill(splat(N::ZERO));
        for &(piece, place, [re, im]) in &self.entries {
            self.re[piece][place] += coefficients[re as usize];
            self.im[piece][place] += coefficients[im as usize];
        }
        self.real = self.im.iter().all(|im| *im == splat(N::ZERO));
    }

    /// Number of entries.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// So many lanes are added to.
    pub fn lanes(&self) -> usize {
        self.first.len() - 1
    }

    /// The pieces of a lane: columns, real and imaginary parts.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> (&[usize], &[Lane<N, L>], &[Lane<N, L>]) {
        let (first, end) = (self.first[lane], self.first[lane + 1]);
        let columns = &self.columns[first..end];
        (columns, &self.re[first..][..columns.len()], &self.im[first..][..columns.len()])
    }

    /// sum + (re + i im)(x + i y)
    #[inline(always)]
    pub fn complex(&self, lane: usize, x: &[N], y: &[N], [mut gx, mut gy]: [Lane<N, L>; 2]) -> [Lane<N, L>; 2] {
        let (columns, re, im) = self.lane(lane);
        let mut i = 0;
        if self.real {
            while i < columns.len() {
                let (x, y) = (splat(x[columns[i]]), splat(y[columns[i]]));
                (gx, gy) = (plus(gx, re[i], x), plus(gy, re[i], y));
                i += 1;
            }
            return [gx, gy];
        }
        let (mut hx, mut hy) = (splat(N::ZERO), splat(N::ZERO));
        while i < columns.len() {
            let (x, y) = (splat(x[columns[i]]), splat(y[columns[i]]));
            (gx, gy) = (plus(gx, re[i], x), plus(gy, re[i], y));
            (hx, hy) = (minus(hx, im[i], y), plus(hy, im[i], x));
            i += 1;
        }
        [add(gx, hx), add(gy, hy)]
    }

    /// sum of re x + im y
    #[inline(always)]
    pub fn dot(&self, lane: usize, x: &[N], y: &[N]) -> Lane<N, L> {
        let (columns, by_x, by_y) = self.lane(lane);
        let (mut re, mut im, mut i) = (splat(N::ZERO), splat(N::ZERO), 0);
        while i < columns.len() {
            re = plus(re, by_x[i], splat(x[columns[i]]));
            im = plus(im, by_y[i], splat(y[columns[i]]));
            i += 1;
        }
        add(re, im)
    }

    /// sum + (re + i im) x, x real
    #[inline(always)]
    pub fn real(&self, lane: usize, x: &[N], [mut gx, mut gy]: [Lane<N, L>; 2]) -> [Lane<N, L>; 2] {
        let (columns, re, im) = self.lane(lane);
        let mut i = 0;
        while i < columns.len() {
            let x = splat(x[columns[i]]);
            (gx, gy) = (plus(gx, re[i], x), plus(gy, im[i], x));
            i += 1;
        }
        [gx, gy]
    }
}
