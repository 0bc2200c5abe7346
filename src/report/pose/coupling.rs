//! Where couplings are drawn: wheels whose radii follow from the ratio and the distance of their centres.

use super::Pose;
use crate::mechanism::{BodyId, Formula, Joint, JointKind, Place};
use crate::report::drawing::{Coupling, CouplingKind, Wheel};

impl Pose<'_, '_> {
    /// All couplings that can be drawn.
    pub(super) fn couplings(&mut self) -> Vec<Coupling> {
        let joints = &self.equations.system.mechanism.joints;
        joints
            .iter()
            .filter_map(|joint| self.coupling(joint).map(|kind| Coupling { name: joint.name.clone(), kind }))
            .collect()
    }

    fn coupling(&mut self, joint: &Joint) -> Option<CouplingKind> {
        let [first, second] = joint.between;
        match &joint.kind {
            JointKind::Distance { .. } => Some(CouplingKind::Link([self.at(first), self.at(second)])),
            JointKind::Gear { carrier, ratio, .. } => {
                let centres = [first, second].map(|wheel| self.hub(wheel.body(), *carrier));
                let radii = radii(self.number(ratio), centres)?;
                let wheel = |side: usize| Wheel {
                    body: joint.between[side].body().map(|body| body.0),
                    centre: centres[side],
                    radius: radii[side],
                };
                Some(CouplingKind::Gears([wheel(0), wheel(1)]))
            }
            JointKind::Rack { carrier, axis, radius, .. } => {
                let [x, y] = self.direction(axis, carrier.body());
                let radius = self.number(radius);
                let pinion = Wheel {
                    body: first.body().map(|body| body.0),
                    centre: self.hub(first.body(), carrier.body()),
                    radius: radius.abs(),
                };
                // Turning counter-clockwise moves the side on the right of the axis along it.
                let foot = [radius * y, -radius * x];
                Some(CouplingKind::Rack { pinion, bar: second.body().map(|body| body.0), at: self.at(second), foot })
            }
            JointKind::Rolling { axis, radius, .. } => Some(CouplingKind::Rolling {
                disc: Wheel {
                    body: second.body().map(|body| body.0),
                    centre: self.at(second),
                    radius: self.number(radius),
                },
                angle: self.angle(second.body()),
                line: first.body().map(|body| body.0),
                base: self.at(first),
                axis: self.direction(axis, first.body()),
            }),
            JointKind::Revolute { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Slot { .. }
            | JointKind::Weld { .. } => None,
        }
    }

    /// Where a wheel turns on its carrier: at the pin between them, else at its mass centre.
    fn hub(&mut self, wheel: Option<BodyId>, carrier: Option<BodyId>) -> [f64; 2] {
        let joints = &self.equations.system.mechanism.joints;
        let pin = joints.iter().filter(|joint| matches!(joint.kind, JointKind::Revolute { .. })).find(|joint| {
            let bodies = joint.between.map(Place::body);
            bodies == [wheel, carrier] || bodies == [carrier, wheel]
        });
        let place = pin.map_or_else(|| wheel.map_or(Place::Origin, Place::Centre), |joint| joint.between[1]);
        self.at(place)
    }

    fn number(&mut self, formula: &Formula) -> f64 {
        let expr = self.equations.formula(formula);
        self.values(&[expr])[0]
    }
}

/// Radii of the pitch circles of wheels that turn in this ratio; `None` if no wheels with these centres can.
fn radii(ratio: f64, [a, b]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let distance = (b[0] - a[0]).hypot(b[1] - a[1]);
    let second = distance / (1.0 - ratio).abs();
    let first = ratio.abs() * second;
    (second.is_finite() && first.min(second) > 1e-3 * distance && first.max(second) < 20.0 * distance)
        .then_some([first, second])
}

#[cfg(test)]
mod tests {
    use super::radii;

    #[test]
    fn pitch_circles_touch_outside_or_inside() {
        assert_eq!(radii(-2.0, [[0.0, 0.0], [3.0, 0.0]]), Some([2.0, 1.0]));
        assert_eq!(radii(3.0, [[0.0, 0.0], [0.0, 2.0]]), Some([3.0, 1.0]));
        assert_eq!(radii(1.0, [[0.0, 0.0], [0.0, 2.0]]), None, "equal wheels side by side turn against each other");
        assert_eq!(radii(-1.0, [[0.0, 0.0]; 2]), None);
    }
}
