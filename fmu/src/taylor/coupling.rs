//! Masses between arms: the forces that go with second derivatives of arms.

use crate::linalg::chain::Chain;
use crate::linalg::columns::{Columns, Entry};
use crate::linalg::lane::{Lane, WIDTH, lanes};

/// With fewer lanes of frames sums along a chain gain nothing.
const LONG: usize = 4;

/// The matrix A.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    all: Columns,
    /// Of frames in an open chain.
    chain: Option<Chain>,
    /// Of a long one: what is left without the entries between different lanes of frames.
    rest: Option<Columns>,
}

impl Coupling {
    /// For entries of so many lanes, and so many frames, which come first.
    pub fn new(count: usize, frames: usize, entries: &[Entry]) -> Self {
        let chain = if frames > WIDTH { Chain::new(frames, entries) } else { None };
        let is_between = |row: usize, column: usize| row < frames && column < frames && row / WIDTH != column / WIDTH;
        let rest = || -> Vec<Entry> { entries.iter().filter(|entry| !is_between(entry.0, entry.1)).copied().collect() };
        let long = chain.is_some() && lanes(frames) >= LONG;
        Self { all: Columns::new(count, entries), chain, rest: long.then(|| Columns::new(count, &rest())) }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[f64]) {
        self.all.fill(coefficients);
        if let Some(chain) = &mut self.chain {
            chain.fill(coefficients);
        }
        if let Some(rest) = &mut self.rest {
            rest.fill(coefficients);
        }
    }

    /// Entry by entry.
    pub fn entries(&self) -> &Columns {
        &self.all
    }

    /// So many constants the forces are found with.
    pub fn count(&self) -> usize {
        self.sums().map_or(self.all.count(), |(chain, rest)| rest.count() + chain.count())
    }

    /// The chain of frames, if they are one with the present coefficients.
    pub fn chain(&self) -> Option<&Chain> {
        self.chain.as_ref().filter(|chain| chain.holds())
    }

    /// Is there a chain, and so long that forces are sums along it?
    pub fn is_long(&self) -> bool {
        self.sums().is_some()
    }

    #[inline(always)]
    fn sums(&self) -> Option<(&Chain, &Columns)> {
        self.chain().zip(self.rest.as_ref())
    }

    /// forces + A (x + i y), all lanes.
    #[inline(always)]
    pub fn add_forces(&self, x: &[Lane], y: &[Lane], forces: &mut [Vec<Lane>; 2]) {
        let sums = self.sums();
        let entries = sums.map_or(&self.all, |(_, rest)| rest);
        let [fx, fy] = forces;
        for (lane, (fx, fy)) in fx.iter_mut().zip(fy.iter_mut()).enumerate() {
            [*fx, *fy] = entries.complex(lane, x.as_flattened(), y.as_flattened(), [*fx, *fy]);
        }
        if let Some((chain, _)) = sums {
            chain.add_forces(x, y, fx, fy);
        }
    }
}
