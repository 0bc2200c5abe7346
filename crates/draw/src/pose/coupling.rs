//! Couplings in the initial pose: the radii of wheels follow from the ratio and the distance of their centres.

use cotree::component::Icon;
use cotree::model::{BodyId, Formula, Part, Place};

use super::PoseValues;
use crate::alike::Alike;
use crate::drawing::{CouplingKind, DrawnCam, DrawnCoupling, Wheel};

/// Corners of a drawn profile.
const OUTLINE: usize = 240;

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).length_with(a[1] - b[1])
}

impl PoseValues<'_> {
    pub(super) fn coupling(&mut self, part: &Part, icon: &Icon) -> Option<DrawnCoupling> {
        let kind = self.coupling_kind(part, icon)?;
        let between = part.bodies().map(|body| body.map(|body| body.0));
        Some(DrawnCoupling { name: part.name.clone(), between, kind })
    }

    fn coupling_kind(&mut self, part: &Part, icon: &Icon) -> Option<CouplingKind> {
        let [first, second] = part.between;
        let index = |place: Place| place.body().map(|body| body.0);
        match icon {
            Icon::Link => Some(CouplingKind::Link([self.at(first), self.at(second)])),
            Icon::Gears { carrier, ratio } => {
                let centres = part.between.map(|wheel| self.hub(wheel.body(), *carrier));
                let radii = radii(self.number(ratio), centres)?;
                let wheel =
                    |side: usize| Wheel { body: index(part.between[side]), centre: centres[side], radius: radii[side] };
                Some(CouplingKind::Gears([wheel(0), wheel(1)]))
            }
            Icon::Band { carrier, radii, crossed } => {
                let wheel = |side: usize| {
                    let place = part.between[side];
                    let (centre, radius) = (self.hub(place.body(), *carrier), self.number(&radii[side]));
                    Wheel { body: index(place), centre, radius }
                };
                Some(CouplingKind::Band { wheels: [0, 1].map(wheel), crossed: *crossed })
            }
            Icon::Rack { carrier, axis, radius } => {
                let [x, y] = self.direction(axis, carrier.body());
                let radius = self.number(radius);
                let centre = self.hub(first.body(), carrier.body());
                let pinion = Wheel { body: index(first), centre, radius: radius.abs() };
                // Turning counter-clockwise moves the side on the right of the axis along it.
                let foot = [radius * y, -radius * x];
                Some(CouplingKind::Rack { pinion, bar: index(second), at: self.at(second), foot })
            }
            Icon::Rolling { axis, radius } => Some(CouplingKind::Rolling {
                disc: Wheel { body: index(second), centre: self.at(second), radius: self.number(radius) },
                angle: self.angle(second.body()),
                line: index(first),
                base: self.at(first),
                axis: self.direction(axis, first.body()),
            }),
            Icon::Cam => self.cam(part).map(CouplingKind::Cam),
            _ => None,
        }
    }

    /// A cam for the parameters of the pose.
    fn cam(&mut self, part: &Part) -> Option<DrawnCam> {
        let mechanism = &self.equations.system.mechanism;
        let parameters = &self.state.parameters()[..mechanism.parameters.len()];
        let profile = (part.component().profile)(part, mechanism, parameters)?;
        let samples = profile.samples(OUTLINE);
        let outline = samples.iter().map(|sample| self.carried(profile.body, sample.contact)).collect();
        let radius = samples.iter().map(|sample| distance(sample.contact, profile.hub)).fold(0.0, f64::max);
        let index = |body: Option<BodyId>| body.map(|body| body.0);
        let (foot, follower) = (self.at(part.between[1]), index(profile.follower));
        let roller = profile.roller.filter(|radius| *radius > 0.0);
        let face = profile.roller.is_none().then(|| {
            let [x, y] = self.direction(&part.vector("face"), profile.follower);
            let beyond = 0.1 * profile.base;
            let reaches = samples.iter().map(|sample| sample.reach);
            let [low, high] = reaches.fold([0.0_f64; 2], |[low, high], reach| [low.min(reach), high.max(reach)]);
            (follower, [low - beyond, high + beyond].map(|reach| [foot[0] + reach * x, foot[1] + reach * y]))
        });
        Some(DrawnCam {
            hub: Wheel { body: index(profile.body), centre: self.carried(profile.body, profile.hub), radius },
            outline,
            roller: roller.map(|radius| Wheel { body: follower, centre: foot, radius }),
            face,
        })
    }

    /// A place of a body in its axes from its mass centre.
    fn carried(&mut self, body: Option<BodyId>, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.angle(body).sine_and_cosine();
        let [u, v] = self.at(body.map_or(Place::Origin, Place::Centre));
        [u + cosine * x - sine * y, v + sine * x + cosine * y]
    }

    /// Where a wheel turns on its carrier: at the pin between them, else at its mass centre.
    fn hub(&mut self, wheel: Option<BodyId>, carrier: Option<BodyId>) -> [f64; 2] {
        let joints = &self.equations.system.mechanism.joints;
        let pin = joints.iter().filter(|joint| matches!((joint.component().icon)(joint), Icon::Pin)).find(|joint| {
            let bodies = joint.bodies();
            bodies == [wheel, carrier] || bodies == [carrier, wheel]
        });
        let place = pin.map_or_else(|| wheel.map_or(Place::Origin, Place::Centre), |joint| joint.between[1]);
        self.at(place)
    }

    pub(super) fn number(&mut self, formula: &Formula) -> f64 {
        let expr = self.equations.formula(formula);
        self.values(&[expr])[0]
    }
}

/// Radii of the pitch circles of wheels that turn in this ratio; `None` if no wheels with these centres can.
fn radii(ratio: f64, [a, b]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let distance = (b[0] - a[0]).length_with(b[1] - a[1]);
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
