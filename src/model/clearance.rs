//! Distances between outlines.

use super::{BodyId, Formula, Mechanism};

/// Two bodies, or a body and the ground.
type Pair = [Option<BodyId>; 2];

/// Which distances between outlines are of interest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearance {
    /// The pairs; all that share no joint if absent.
    pub pairs: Option<Vec<Pair>>,
    /// The least distance that is permitted \[m\].
    pub least: Option<Formula>,
}

impl Mechanism {
    /// Is there an outline of this body, or of the ground?
    pub fn has_outline(&self, body: Option<BodyId>) -> bool {
        body.map_or(!self.ground_outlines.is_empty(), |body| self.bodies[body.0].outline.is_some())
    }

    /// The pairs whose distances are of interest.
    pub fn clearance_pairs(&self) -> Vec<Pair> {
        let Some(clearance) = &self.clearance else { return Vec::new() };
        if let Some(pairs) = &clearance.pairs {
            return pairs.clone();
        }
        let bodies = (0..self.bodies.len()).map(|index| Some(BodyId(index))).chain([None]);
        let outlined: Vec<Option<BodyId>> = bodies.filter(|body| self.has_outline(*body)).collect();
        let joined = |[a, b]: Pair| {
            self.joints.iter().any(|joint| matches!(joint.bodies(), ends if ends == [a, b] || ends == [b, a]))
        };
        let pairs = outlined.iter().enumerate();
        let pairs = pairs.flat_map(|(index, first)| outlined[index + 1..].iter().map(|second| [*first, *second]));
        pairs.filter(|pair| !joined(*pair)).collect()
    }
}
