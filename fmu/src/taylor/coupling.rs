//! Masses between arms: the forces that go with second derivatives of arms.

use crate::linalg::columns::{Columns, Entry};
use crate::linalg::lane::{Lane, WIDTH};
use crate::linalg::number::Number;
use crate::linalg::tree::{Limb, Masses, Tree};

/// The matrix A.
#[derive(Clone, Debug)]
pub(crate) struct Coupling<N = f64, const L: usize = WIDTH> {
    all: Columns<N, L>,
    /// Of all arms, instead of the entries.
    tree: Option<Tree<N>>,
}

impl<N: Number, const L: usize> Coupling<N, L> {
    /// For entries of so many lanes.
    pub fn new(count: usize, entries: &[Entry]) -> Self {
        Self { all: Columns::new(count, entries), tree: None }
    }

    /// For all arms of so many lanes as a tree; places before `lines` are those of frames.
    pub fn of_tree(count: usize, lines: usize, limbs: Vec<Limb<N>>, masses: Vec<Masses>) -> Self {
        Self { all: Columns::new(count, &[]), tree: Some(Tree::new(limbs, masses, lines)) }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[N]) {
        match &mut self.tree {
            Some(tree) => tree.fill(coefficients),
            None => self.all.fill(coefficients),
        }
    }

    /// Entry by entry; none of a tree.
    pub fn entries(&self) -> &Columns<N, L> {
        &self.all
    }

    /// So many constants the forces are found with.
    pub fn count(&self) -> usize {
        self.tree.as_ref().map_or(self.all.count(), |tree| 4 * tree.limbs().len())
    }

    /// The arms, if they are a tree.
    pub fn tree(&self) -> Option<&Tree<N>> {
        self.tree.as_ref()
    }

    /// forces + A (x + i y), all lanes.
    #[inline(always)]
    pub fn add_forces(&mut self, x: &[Lane<N, L>], y: &[Lane<N, L>], forces: &mut [Vec<Lane<N, L>>; 2]) {
        let [fx, fy] = forces;
        let (x, y) = (x.as_flattened(), y.as_flattened());
        if let Some(tree) = &mut self.tree {
            return tree.add_forces([x, y], [fx.as_flattened_mut(), fy.as_flattened_mut()]);
        }
        for (lane, (fx, fy)) in fx.iter_mut().zip(fy.iter_mut()).enumerate() {
            [*fx, *fy] = self.all.complex(lane, x, y, [*fx, *fy]);
        }
    }
}
