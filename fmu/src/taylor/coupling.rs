//! Masses between arms: the forces that go with second derivatives of arms.

use crate::linalg::chain::Chain;
use crate::linalg::columns::{Columns, Entry};
use crate::linalg::lane::{Lane, WIDTH, lanes};
use crate::linalg::number::Number;
use crate::linalg::tree::{Limb, Masses, Tree};

/// With fewer lanes of frames sums along a chain gain nothing.
const LONG: usize = 4;

/// The matrix A.
#[derive(Clone, Debug)]
pub(crate) struct Coupling<N = f64, const L: usize = WIDTH> {
    all: Columns<N, L>,
    /// Of frames in an open chain.
    chain: Option<Chain<N, L>>,
    /// Of a long one: what is left without the entries between different lanes of frames.
    rest: Option<Columns<N, L>>,
    /// Of all arms, instead of the entries; a long chain has both.
    tree: Option<Tree<N>>,
    /// Of such a chain the pairs of frames within a lane, and the masses between them.
    near: Vec<(usize, usize)>,
    products: Vec<N>,
}

impl<N: Number, const L: usize> Coupling<N, L> {
    /// For entries of so many lanes, and so many frames, which come first.
    pub fn new(count: usize, frames: usize, entries: &[Entry]) -> Self {
        let chain = if frames > WIDTH { Chain::new(frames, entries) } else { None };
        let is_between = |row: usize, column: usize| row < frames && column < frames && row / L != column / L;
        let rest = || -> Vec<Entry> { entries.iter().filter(|entry| !is_between(entry.0, entry.1)).copied().collect() };
        let long = chain.is_some() && lanes(frames) >= LONG;
        let rest = long.then(|| Columns::new(count, &rest()));
        Self { all: Columns::new(count, entries), chain, rest, tree: None, near: Vec::new(), products: Vec::new() }
    }

    /// For all arms of so many lanes as a tree; places before `lines` are those of frames.
    pub fn of_tree(count: usize, lines: usize, limbs: Vec<Limb<N>>, masses: Vec<Masses>) -> Self {
        let frames = limbs.len();
        let tree = Tree::new(limbs, masses, lines);
        let chained = tree.is_chain() && lanes(frames) >= LONG;
        let (near, far): (Vec<(usize, usize)>, Vec<Entry>) = within_lanes::<L>(frames);
        Self {
            all: Columns::new(count, &[]),
            chain: chained.then(|| Chain::of_limbs(frames)),
            rest: chained.then(|| Columns::new(count, &far)),
            products: vec![N::ZERO; 2 * near.len()],
            near,
            tree: Some(tree),
        }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[N]) {
        if let Some(tree) = &mut self.tree {
            tree.fill(coefficients);
            if let (Some(chain), Some(rest)) = (&mut self.chain, &mut self.rest) {
                chain.renew(tree.limbs());
                for (&(row, column), product) in self.near.iter().zip(self.products.as_chunks_mut().0) {
                    *product = tree.between(row, column);
                }
                rest.fill(&self.products);
            }
            return;
        }
        self.all.fill(coefficients);
        if let Some(chain) = &mut self.chain {
            chain.fill(coefficients);
        }
        if let Some(rest) = &mut self.rest {
            rest.fill(coefficients);
        }
    }

    /// Entry by entry; none of a tree.
    pub fn entries(&self) -> &Columns<N, L> {
        &self.all
    }

    /// So many constants the forces are found with.
    pub fn count(&self) -> usize {
        match (self.sums(), &self.tree) {
            (Some((chain, rest)), _) => rest.count() + chain.count(),
            (None, Some(tree)) => 4 * tree.limbs().len(),
            (None, None) => self.all.count(),
        }
    }

    /// The arms, if they are a tree.
    pub fn tree(&self) -> Option<&Tree<N>> {
        self.tree.as_ref()
    }

    /// The chain of frames, if they are one with the present coefficients.
    pub fn chain(&self) -> Option<&Chain<N, L>> {
        self.chain.as_ref().filter(|chain| chain.holds())
    }

    /// Can forces be sums along a tree or a chain, whatever the coefficients are?
    pub fn may_have_sums(&self) -> bool {
        self.tree.is_some() || self.rest.is_some()
    }

    /// Is there a chain, and so long that forces are sums along it?
    pub fn is_long(&self) -> bool {
        self.sums().is_some()
    }

    #[inline(always)]
    fn sums(&self) -> Option<(&Chain<N, L>, &Columns<N, L>)> {
        self.chain().zip(self.rest.as_ref())
    }

    /// forces + A (x + i y), all lanes.
    #[inline(always)]
    pub fn add_forces(&mut self, x: &[Lane<N, L>], y: &[Lane<N, L>], forces: &mut [Vec<Lane<N, L>>; 2]) {
        let [fx, fy] = forces;
        if let (None, Some(tree)) = (&self.chain, &mut self.tree) {
            let forces = [fx.as_flattened_mut(), fy.as_flattened_mut()];
            return tree.add_forces([x.as_flattened(), y.as_flattened()], forces);
        }
        let sums = self.sums();
        let entries = sums.map_or(&self.all, |(_, rest)| rest);
        for (lane, (fx, fy)) in fx.iter_mut().zip(fy.iter_mut()).enumerate() {
            [*fx, *fy] = entries.complex(lane, x.as_flattened(), y.as_flattened(), [*fx, *fy]);
        }
        if let Some((chain, _)) = sums {
            chain.add_forces(x, y, fx, fy);
        }
    }
}

/// Pairs of different frames of one lane, and entries for them whose coefficients are numbered likewise.
fn within_lanes<const L: usize>(frames: usize) -> (Vec<(usize, usize)>, Vec<Entry>) {
    let end = |row: usize| frames.min((row / L + 1) * L);
    let columns = |row: usize| (row / L * L..end(row)).filter(move |&column| column != row);
    let pairs: Vec<(usize, usize)> =
        (0..frames).flat_map(|row| columns(row).map(move |column| (row, column))).collect();
    let entries =
        pairs.iter().zip(0..).map(|(&(row, column), index)| (row, column, [2 * index, 2 * index + 1])).collect();
    (pairs, entries)
}
