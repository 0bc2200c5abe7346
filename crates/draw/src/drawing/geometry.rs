//! The drawing as numbers in the bodies' own axes: what a page needs to move it.

use serde::Serialize;

use super::coupling::{self, CouplingKind, Teeth, Wheel};
use super::shapes::{difference, norm};
use super::view::View;
use super::{Drawing, Hold, Joint, Spring, Turn, is_finite};

/// A drawing whose every point says which body carries it. Lengths are in metres, symbols in pixels at `scale`.
#[derive(Clone, Debug, Serialize)]
pub struct Geometry {
    /// Pixels of a metre.
    scale: f64,
    /// Radius of a pin [px].
    pin: f64,
    bodies: Vec<BodyForm>,
    /// Bodies from back to front.
    order: Vec<usize>,
    joints: Vec<JointForm>,
    springs: Vec<SpringForm>,
    forces: Vec<Mark>,
    turns: Vec<TurnForm>,
    targets: Vec<Mark>,
    couplings: Vec<CouplingForm>,
}

/// A point of a body in its own axes, or of the ground in the world's.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Anchor {
    body: Option<usize>,
    at: [f64; 2],
    /// Which point of the body it is, if one of those with a name: these may move when a parameter changes.
    point: Option<usize>,
}

#[derive(Clone, Debug, Serialize)]
struct BodyForm {
    name: String,
    /// Position and angle at the start.
    start: [f64; 3],
    points: Vec<[f64; 2]>,
    centre: [f64; 2],
    /// The corners of its shape, in order; none if the shape is not known.
    rim: Vec<[f64; 2]>,
    /// Are its points joined by a bar?
    barred: bool,
    /// Is the mass centre a corner of the bar?
    cornered: bool,
    /// The radius of the mass centre's mark [pins].
    mark: f64,
    /// Does the mark lie around a joint?
    covered: bool,
    block: Option<Block>,
}

/// A block that slides: where, and along what in the axes of the body `along`.
#[derive(Clone, Debug, Serialize)]
struct Block {
    at: Anchor,
    axis: [f64; 2],
    along: Option<usize>,
}

#[derive(Clone, Debug, Serialize)]
struct JointForm {
    name: String,
    hold: &'static str,
    ends: [Anchor; 2],
    /// In the axes of the first body.
    axis: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Serialize)]
struct SpringForm {
    name: String,
    ends: [Anchor; 2],
    /// How far the sign stays away from the ends [m].
    retreat: [f64; 2],
    /// The length that the strokes are drawn for [px / pin].
    length: f64,
    strokes: Vec<StrokeForm>,
}

/// A line of a sign: where its points are, and how far they go along if the sign becomes longer by one.
#[derive(Clone, Debug, Serialize)]
pub struct StrokeForm {
    pub closed: bool,
    pub points: Vec<[f64; 3]>,
}

#[derive(Clone, Debug, Serialize)]
struct Mark {
    name: String,
    at: Anchor,
    /// Its direction at the start, in the world.
    direction: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Serialize)]
struct TurnForm {
    name: String,
    at: Anchor,
    /// The lines of its sign, around the place; none if it is an arrow.
    strokes: Vec<Vec<[f64; 2]>>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum CouplingForm {
    Gears { name: String, wheels: [WheelForm; 2] },
    Band { name: String, wheels: [WheelForm; 2], crossed: bool },
    Rack { name: String, pinion: WheelForm, bar: Anchor, foot: [f64; 2] },
    Rolling { name: String, disc: WheelForm, base: Anchor, axis: [f64; 2] },
    Link { name: String, ends: [Anchor; 2] },
    Cam { name: String, wheels: Vec<WheelForm>, rim: Vec<[f64; 2]>, face: Option<[Anchor; 2]> },
}

#[derive(Clone, Debug, Serialize)]
struct WheelForm {
    centre: Anchor,
    radius: f64,
    teeth: Option<TeethForm>,
}

#[derive(Clone, Debug, Serialize)]
struct TeethForm {
    count: f64,
    /// Where one tooth is, in the wheel's axes.
    phase: f64,
    inside: bool,
}

impl Drawing {
    /// The drawing in the axes of its bodies, which are at these positions and angles now.
    pub fn geometry(&self, frames: &[[f64; 3]]) -> Geometry {
        let view = View::fit(self);
        let forms = Forms { drawing: self, frames, view: &view };
        Geometry {
            scale: view.length(1.0),
            pin: view.pin,
            bodies: (0..self.bodies.len()).map(|body| forms.body(body)).collect(),
            order: self.drawing_order(&view),
            joints: self.joints.iter().filter(|joint| joint.is_finite()).map(|joint| forms.joint(joint)).collect(),
            springs: self.springs.iter().map(|spring| forms.spring(spring)).collect(),
            forces: forms.marks(self.forces.iter().map(|f| (&f.name, f.on, f.at, Some(f.direction)))),
            turns: self.turns.iter().filter(|turn| is_finite(&turn.at)).map(|turn| forms.turn(turn)).collect(),
            targets: forms.marks(self.targets.iter().map(|t| (&t.name, t.on, t.at, t.direction))),
            couplings: self.couplings.iter().filter(|c| c.is_finite()).map(|c| forms.coupling(c)).collect(),
        }
    }
}

#[cfg(test)]
impl Geometry {
    /// Which mass centres a joint covers.
    pub(super) fn covered(&self) -> Vec<bool> {
        self.bodies.iter().map(|body| body.covered).collect()
    }
}

struct Forms<'a> {
    drawing: &'a Drawing,
    frames: &'a [[f64; 3]],
    view: &'a View,
}

impl Forms<'_> {
    fn frame(&self, body: Option<usize>) -> [f64; 3] {
        body.and_then(|body| self.frames.get(body)).copied().unwrap_or_default()
    }

    /// A point of the world in the axes of a body.
    fn local(&self, body: Option<usize>, [x, y]: [f64; 2]) -> [f64; 2] {
        let [u, v, _] = self.frame(body);
        self.turned(body, [x - u, y - v])
    }

    /// A direction of the world in the axes of a body.
    fn turned(&self, body: Option<usize>, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.frame(body)[2].sin_cos();
        [cosine * x + sine * y, cosine * y - sine * x]
    }

    fn anchor(&self, body: Option<usize>, at: [f64; 2]) -> Anchor {
        let points = body.and_then(|body| self.drawing.bodies.get(body)).map(|body| &body.points);
        let point = points.and_then(|points| points.iter().position(|point| *point == at));
        Anchor { body, at: self.local(body, at), point }
    }

    fn body(&self, index: usize) -> BodyForm {
        let body = &self.drawing.bodies[index];
        let local = |at: &[f64; 2]| self.local(Some(index), *at);
        let block = |(joint, axis): (&Joint, [f64; 2])| {
            let along = joint.between[0];
            Block { at: self.anchor(Some(index), joint.moving().1), axis: self.turned(along, axis), along }
        };
        BodyForm {
            name: body.name.clone(),
            start: self.frame(Some(index)),
            points: body.points.iter().map(local).collect(),
            centre: local(&body.centre),
            rim: body.shape.iter().flat_map(|shape| shape.rim()).map(|corner| local(&corner)).collect(),
            barred: !self.drawing.bar(index, self.view).is_empty(),
            cornered: self.drawing.is_cornered(index),
            mark: self.drawing.mark(index, self.view),
            covered: self.drawing.is_covered(body.centre, self.view),
            block: self.drawing.slider(index).map(block),
        }
    }

    fn joint(&self, joint: &Joint) -> JointForm {
        let (hold, axis) = match joint.kind {
            Hold::Pin => ("pin", None),
            Hold::Fixed => ("fixed", None),
            Hold::Slider(axis) => ("slider", Some(axis)),
            Hold::Slot(axis) => ("slot", Some(axis)),
        };
        JointForm {
            name: joint.name.clone(),
            hold,
            ends: [0, 1].map(|side| self.anchor(joint.between[side], joint.at[side])),
            axis: axis.map(|axis| self.turned(joint.between[0], axis)),
        }
    }

    fn spring(&self, spring: &Spring) -> SpringForm {
        let full = spring.ends.map(|end| self.view.pixel(end));
        let drawn = self.drawing.spring_ends(spring, self.view);
        let retreat = [0, 1].map(|side| norm(difference(drawn[side], full[side])) / self.view.length(1.0));
        // A sign without length at the start is drawn as if it had some.
        let length = (norm(difference(drawn[1], drawn[0])) / self.view.pin).max(10.0);
        SpringForm {
            name: spring.name.clone(),
            ends: [0, 1].map(|side| self.anchor(spring.between[side], spring.ends[side])),
            retreat,
            length,
            strokes: strokes(spring, length),
        }
    }

    fn turn(&self, turn: &Turn) -> TurnForm {
        let strokes = turn.glyph.iter().flat_map(|glyph| glyph()).map(|stroke| stroke.points).collect();
        TurnForm { name: turn.name.clone(), at: self.anchor(turn.on, turn.at), strokes }
    }

    fn marks<'m>(
        &self,
        marks: impl Iterator<Item = (&'m String, Option<usize>, [f64; 2], Option<[f64; 2]>)>,
    ) -> Vec<Mark> {
        let finite = marks.filter(|(_, _, at, direction)| is_finite(at) && direction.is_none_or(|d| is_finite(&d)));
        finite
            .map(|(name, on, at, direction)| Mark { name: name.clone(), at: self.anchor(on, at), direction })
            .collect()
    }

    fn coupling(&self, coupling: &coupling::Coupling) -> CouplingForm {
        let name = coupling.name.clone();
        match &coupling.kind {
            CouplingKind::Gears(wheels) => {
                let [a, b] = coupling::toothed(wheels, self.view);
                CouplingForm::Gears { name, wheels: [self.wheel(&wheels[0], Some(a)), self.wheel(&wheels[1], Some(b))] }
            }
            CouplingKind::Band { wheels, crossed } => {
                CouplingForm::Band { name, wheels: wheels.map(|wheel| self.wheel(&wheel, None)), crossed: *crossed }
            }
            CouplingKind::Rack { pinion, bar, at, foot } => CouplingForm::Rack {
                name,
                pinion: self.wheel(pinion, Some(coupling::of_pinion(pinion, *foot, self.view))),
                bar: self.anchor(*bar, *at),
                foot: self.turned(*bar, *foot),
            },
            CouplingKind::Rolling { disc, line, base, axis, .. } => CouplingForm::Rolling {
                name,
                disc: self.wheel(disc, None),
                base: self.anchor(*line, *base),
                axis: self.turned(*line, *axis),
            },
            CouplingKind::Cam(cam) => CouplingForm::Cam {
                name,
                wheels: coupling.wheels().iter().map(|wheel| self.wheel(wheel, None)).collect(),
                rim: cam.outline.iter().map(|&corner| self.local(cam.hub.body, corner)).collect(),
                face: cam.face.map(|(body, ends)| ends.map(|end| self.anchor(body, end))),
            },
            CouplingKind::Link(ends) => {
                CouplingForm::Link { name, ends: [0, 1].map(|side| self.anchor(coupling.between[side], ends[side])) }
            }
        }
    }

    fn wheel(&self, wheel: &Wheel, teeth: Option<Teeth>) -> WheelForm {
        let angle = self.frame(wheel.body)[2];
        let teeth = teeth.map(|Teeth { count, phase, inside }| TeethForm { count, phase: phase - angle, inside });
        WheelForm { centre: self.anchor(wheel.body, wheel.centre), radius: wheel.radius, teeth }
    }
}

/// The strokes of a sign of this length, and how they follow it: those of one a little longer show that. A spring keeps its coils.
pub fn strokes(spring: &Spring, length: f64) -> Vec<StrokeForm> {
    const LONGER: f64 = 1e-3;
    let (now, then) = (spring.strokes(length), spring.strokes(length + LONGER));
    let stroke = |(now, then): (&cotree::component::Stroke, &cotree::component::Stroke)| {
        let same = now.points.len() == then.points.len();
        let point = |(index, &[x, y]): (usize, &[f64; 2])| {
            let slope = if same { (then.points[index][0] - x) / LONGER } else { x / length };
            [x, y, slope]
        };
        StrokeForm { closed: now.closed, points: now.points.iter().enumerate().map(point).collect() }
    };
    now.iter().zip(&then).map(stroke).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Body, Force};
    use super::*;

    fn turned_bar() -> Drawing {
        let points = vec![[1.0, 1.0], [1.0, 3.0]];
        let body = Body { name: "bar".into(), points, centre: [1.0, 2.0], shape: None };
        let force = Force { name: "f".into(), on: Some(0), at: [1.0, 3.0], direction: [0.0, 1.0] };
        Drawing { bodies: vec![body], forces: vec![force], ..Drawing::default() }
    }

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        norm(difference(a, b)) < 1e-12
    }

    #[test]
    fn points_are_in_the_axes_of_their_bodies() {
        let geometry = turned_bar().geometry(&[[1.0, 2.0, std::f64::consts::FRAC_PI_2]]);
        assert!(near(geometry.bodies[0].points[0], [-1.0, 0.0]), "{geometry:?}");
        assert!(near(geometry.bodies[0].points[1], [1.0, 0.0]), "{geometry:?}");
        let Anchor { body, at, point } = geometry.forces[0].at.clone();
        assert!(near(at, [1.0, 0.0]) && (body, point) == (Some(0), Some(1)), "{geometry:?}");
        assert_eq!(geometry.forces[0].direction, Some([0.0, 1.0]), "directions stay in the world");
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut drawing = turned_bar();
        drawing.forces[0].at[0] = f64::NAN;
        assert!(drawing.geometry(&[[1.0, 2.0, 0.0]]).forces.is_empty());
    }
}
