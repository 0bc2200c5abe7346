//! The tree of steps from node to node, and the paths through it.

use super::{Kinematics, PointMotion};
use crate::equations::vector::{FrameId, Vector};
use crate::expr::{Arena, Expr};
use crate::network::TNode;

/// Beyond so many turning frames and displacements, sums along a path are shared by its nodes.
pub(super) const DEEP: usize = 30;

/// The branch between a node and the one before it. Sums along paths are made where they are needed: of a deep tree only
/// few are.
#[derive(Clone, Debug)]
pub(super) struct PathEnd {
    pub(super) parent: TNode,
    pub(super) depth: usize,
    pub(super) slides: usize,
    /// The number of changes to another turning frame on the path from the datum, and the last of these frames.
    pub(super) angles: usize,
    pub(super) frame: FrameId,
    /// Motion of the node relative to the one before it.
    pub(super) across: PointMotion,
}

impl Kinematics {
    fn depth(&self, node: TNode) -> usize {
        self.steps[node.index()].as_ref().map_or(0, |step| step.depth)
    }

    /// Motion of a node relative to one that its path to the datum passes.
    pub(super) fn relative(&self, arena: &mut Arena, base: TNode, node: TNode) -> PointMotion {
        let mut motion = PointMotion::default();
        for across in self.path(base, node) {
            motion.accumulate(arena, Expr::ONE, across);
        }
        motion
    }

    /// The nodes but the datum, each after the one before it: their places and its, and their positions relative to it.
    pub fn outward(&self) -> impl Iterator<Item = (usize, usize, &Vector)> {
        let mut nodes: Vec<(usize, usize, &PathEnd)> = self
            .steps
            .iter()
            .enumerate()
            .filter_map(|(node, step)| step.as_ref().map(|s| (s.depth, node, s)))
            .collect();
        nodes.sort_unstable_by_key(|(depth, node, _)| (*depth, *node));
        nodes.into_iter().map(|(_, node, step)| (node, step.parent.index(), &step.across.position))
    }

    /// Across variables of the branches from a node on the path to the datum to another node.
    pub(super) fn path(&self, base: TNode, node: TNode) -> impl Iterator<Item = &PointMotion> {
        let mut path = Vec::new();
        let mut at = node;
        while let (true, Some(step)) = (at != base, &self.steps[at.index()]) {
            path.push(&step.across);
            at = step.parent;
        }
        path.into_iter().rev()
    }

    /// Does the path from the datum to a node change frames so often that sums along it must be shared?
    pub fn is_deep(&self, node: TNode) -> bool {
        self.moving(node) > DEEP
    }

    /// How many turning frames and displacements lie on the path from the datum to a node.
    pub fn moving(&self, node: TNode) -> usize {
        self.steps[node.index()].as_ref().map_or(0, |step| step.angles + step.slides)
    }

    /// How many turning frames lie on the path between two nodes.
    pub fn angles_between(&self, ends: [TNode; 2]) -> usize {
        let angles = |node: TNode| self.steps[node.index()].as_ref().map_or(0, |step| step.angles);
        angles(ends[0]) + angles(ends[1]) - 2 * angles(self.meeting(ends))
    }

    /// Where the paths of two nodes to the datum meet.
    pub(super) fn meeting(&self, [mut a, mut b]: [TNode; 2]) -> TNode {
        if a == TNode::DATUM || b == TNode::DATUM {
            return TNode::DATUM;
        }
        while a != b {
            let deeper = if self.depth(a) >= self.depth(b) { &mut a } else { &mut b };
            match &self.steps[deeper.index()] {
                Some(step) => *deeper = step.parent,
                None => return TNode::DATUM,
            }
        }
        a
    }
}
