//! Across variables. The branch transformation (Eq. 12) gives every node's motion from those of the branches; since "the
//! derivative of an across variable is another across variable", one walk through each tree serves positions, velocities and
//! accelerations.

mod frames;
mod motion;
mod paths;
mod terminal;
mod totals;

use std::collections::BTreeMap;

use super::form::Coefficient;
use super::vector::{FrameId, Frames, Vector};
use crate::expr::{Arena, Expr};
use crate::model::Place;
use crate::network::{ElementId, OutwardNode, RNode, Rotation, System, TNode, Topology, Translation};

pub use frames::is_constant;
pub use motion::{PointMotion, ScalarMotion};
pub use terminal::{known_angle, project};

use frames::{angles, frames};
use paths::PathEnd;
use totals::Totals;

/// The coordinates that each branch brings: index of the first.
pub type FirstCoordinate = BTreeMap<ElementId, usize>;

/// Motion of every node of both graphs, in terms of the branch coordinates.
#[derive(Clone, Debug)]
pub struct Kinematics {
    pub frames: Frames,
    angles: Vec<ScalarMotion>,
    /// For each rotational node its frame, and the constant angle from the frame to the body.
    placement: Vec<(FrameId, Expr)>,
    /// For each translational node but the datum, the step to it.
    steps: Vec<Option<PathEnd>>,
    /// Shared sums of nodes at the end of deep paths.
    totals: Vec<Totals>,
}

impl Kinematics {
    pub fn new(
        system: &mut System,
        translation: &Topology<Translation>,
        rotation: &Topology<Rotation>,
        t_coordinates: &FirstCoordinate,
        r_coordinates: &FirstCoordinate,
    ) -> Self {
        let angles = angles(system, rotation, r_coordinates);
        let (frames, placement) = frames(&mut system.arena, &angles);
        let steps = vec![None; system.translation.nodes()];
        let totals = vec![Totals::default(); steps.len()];
        let mut kinematics = Kinematics { frames, angles, placement, steps, totals };
        for OutwardNode { node, parent, branch, sign } in translation.outward() {
            let Some(row) = system.elements[branch.0].translation.clone() else { continue };
            let unsigned = kinematics.across_branch(system, &row, t_coordinates.get(&branch).copied());
            let sign = system.arena.constant(f64::from(sign));
            let mut across = PointMotion::default();
            across.accumulate(&mut system.arena, sign, &unsigned);
            let before = kinematics.steps[parent.index()].as_ref();
            let (depth, angles, frame) = before.map_or((0, 0, FrameId::WORLD), |s| (s.depth, s.angles, s.frame));
            let slides = before.map_or(0, |s| s.slides) + row.motion.len();
            let turned =
                across.position.frames().find(|&turned_frame| turned_frame != FrameId::WORLD && turned_frame != frame);
            let (angles, frame) = turned.map_or((angles, frame), |turned_frame| (angles + 1, turned_frame));
            kinematics.steps[node.index()] = Some(PathEnd { parent, depth: depth + 1, slides, angles, frame, across });
        }
        kinematics
    }

    pub fn node(&self, arena: &mut Arena, node: TNode) -> PointMotion {
        self.relative(arena, TNode::DATUM, node)
    }

    /// Across variable of an element from the branches that connect its nodes (Eq. 12).
    pub fn across(&self, arena: &mut Arena, ends: [TNode; 2]) -> PointMotion {
        let base = self.meeting(ends);
        let [from, to] = ends.map(|end| self.relative(arena, base, end));
        PointMotion::between(arena, &from, &to)
    }

    pub fn angle(&self, node: RNode) -> &ScalarMotion {
        &self.angles[node.index()]
    }

    /// Angle across an element from those of its nodes.
    pub fn angle_across(&self, arena: &mut Arena, ends: [RNode; 2]) -> ScalarMotion {
        let mut angle = self.angle(ends[1]).clone();
        let minus = arena.constant(-1.0);
        angle.accumulate(arena, minus, self.angle(ends[0]));
        angle
    }

    /// The frame that a body (or the ground) turns with, and the constant angle from the frame to the body.
    pub fn placement(&self, node: RNode) -> (FrameId, Expr) {
        self.placement[node.index()]
    }

    /// Motion of any point of the scene, whether an element uses it or not.
    pub fn place(&self, system: &mut System, place: Place) -> PointMotion {
        let mechanism = &*system.mechanism.clone();
        match place {
            _ if system.has_node(place) => {
                let node = system.t_node(place);
                self.node(&mut system.arena, node)
            }
            Place::Ground(point) => {
                let at = mechanism.ground[point].at.each_ref().map(|formula| system.value(formula));
                self.fixed(system, None, at)
            }
            Place::Point(body, point) => {
                let at = mechanism.bodies[body.0].points[point].at.each_ref().map(|formula| system.value(formula));
                let centre = system.t_node(Place::Centre(body));
                let mut motion = self.node(&mut system.arena, centre);
                let arm = self.fixed(system, Some(body), at);
                motion.accumulate(&mut system.arena, Expr::ONE, &arm);
                motion
            }
            Place::Origin | Place::Centre(_) => PointMotion::default(),
        }
    }

    /// Position of any point of the scene: [`Kinematics::place`] without the derivatives.
    pub fn position(&self, system: &mut System, place: Place) -> Vector {
        let sum = |arena: &mut Arena, node: TNode| {
            let mut position = Vector::default();
            self.path(TNode::DATUM, node).for_each(|across| position.accumulate(arena, &across.position));
            position
        };
        let node = system.t_node(place);
        match place {
            _ if system.has_node(place) => sum(&mut system.arena, node),
            Place::Point(body, point) => {
                let mechanism = &*system.mechanism.clone();
                let at = mechanism.bodies[body.0].points[point].at.each_ref();
                let at = at.map(|formula| system.value(formula));
                let centre = system.t_node(Place::Centre(body));
                let mut position = sum(&mut system.arena, centre);
                let arm = self.fixed(system, Some(body), at).position;
                position.accumulate(&mut system.arena, &arm);
                position
            }
            Place::Ground(_) | Place::Origin | Place::Centre(_) => self.place(system, place).position,
        }
    }
}
