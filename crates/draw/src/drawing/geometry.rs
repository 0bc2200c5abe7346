//! The drawing as a list of parts, each with what carries it: a page moves them, and draws nothing of its own.

use serde::Serialize;

use super::coupling::Wheel;
use super::held::{HeldForm, HeldPart, StopForm};
use super::labels::Labels;
use super::shapes::unit;
use super::view::View;
use super::{Drawing, DrawnJoint, Hold, LAYERS, is_finite, symbols};
use crate::alike::Alike;
use crate::carrier::{Anchor, Carrier, Stretch, Track, joined};
use crate::svg::Svg;

/// A drawing whose every point says which body carries it. Lengths are in metres, symbols in pixels at `scale`.
#[derive(Clone, Debug, Serialize)]
pub struct Geometry {
    /// Pixels of a metre.
    scale: f64,
    /// Radius of a pin [px].
    pin: f64,
    bodies: Vec<BodyForm>,
    joints: Vec<JointForm>,
    springs: Vec<SpringForm>,
    forces: Vec<MarkForm>,
    turns: Vec<MarkForm>,
    targets: Vec<MarkForm>,
    wheels: Vec<WheelForm>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    held: Vec<HeldForm>,
    /// Where limits end the motion of joints; the last of the parts, in the same order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stops: Vec<StopForm>,
    /// From back to front.
    parts: Vec<CarriedPart>,
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
    /// Is the mass centre a corner of the bar?
    cornered: bool,
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
}

#[derive(Clone, Debug, Serialize)]
struct MarkForm {
    name: String,
    at: Anchor,
    /// Its direction at the start, in the world.
    direction: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Serialize)]
struct WheelForm {
    centre: Anchor,
    radius: f64,
}

/// Some elements of the picture as they are at the start, in the world [px], and what carries them.
#[derive(Clone, Debug, Serialize)]
struct CarriedPart {
    layer: &'static str,
    svg: String,
    #[serde(flatten)]
    carrier: Carrier,
}

impl Drawing {
    /// The drawing in the axes of its bodies, which are at these positions and angles now.
    pub fn geometry(&self, frames: &[[f64; 3]]) -> Geometry {
        let view = View::fit(self).in_world();
        let forms = Forms { drawing: self, frames };
        let wheels =
            self.couplings.iter().filter(|coupling| coupling.is_finite()).flat_map(|coupling| coupling.wheels());
        Geometry {
            scale: view.length(1.0),
            pin: view.pin,
            bodies: (0..self.bodies.len()).map(|body| forms.body(body)).collect(),
            joints: self.joints.iter().filter(|joint| joint.is_finite()).map(|joint| forms.joint(joint)).collect(),
            springs: self
                .springs
                .iter()
                .map(|s| SpringForm { name: s.name.clone(), ends: forms.anchors(s.between, s.ends) })
                .collect(),
            forces: forms.marks(self.forces.iter().map(|f| (&f.name, f.on, f.at, Some(f.direction)))),
            turns: forms.marks(self.turns.iter().map(|t| (&t.name, t.on, t.at, None))),
            targets: forms.marks(self.targets.iter().map(|t| (&t.name, t.on, t.at, t.direction))),
            wheels: wheels
                .map(|Wheel { body, centre, radius }| WheelForm { centre: forms.anchor(body, centre), radius })
                .collect(),
            held: self.held.iter().filter(|held| is_finite(&held.spot.place())).map(|held| forms.held(held)).collect(),
            stops: self
                .placed_stops()
                .map(|placed_stop| StopForm {
                    at: forms.anchor(placed_stop.on, placed_stop.at),
                    needs: placed_stop.needs.clone(),
                })
                .collect(),
            parts: forms.parts(&view),
        }
    }
}

struct Forms<'a> {
    drawing: &'a Drawing,
    frames: &'a [[f64; 3]],
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
        let (sine, cosine) = self.frame(body)[2].sine_and_cosine();
        [cosine * x + sine * y, cosine * y - sine * x]
    }

    fn anchor(&self, body: Option<usize>, at: [f64; 2]) -> Anchor {
        let points = body.and_then(|body| self.drawing.bodies.get(body)).map(|body| &body.points);
        let point = points.and_then(|points| points.iter().position(|point| *point == at));
        Anchor { body, at: self.local(body, at), point }
    }

    fn anchors(&self, bodies: [Option<usize>; 2], places: [[f64; 2]; 2]) -> [Anchor; 2] {
        [0, 1].map(|side| self.anchor(bodies[side], places[side]))
    }

    fn body(&self, index: usize) -> BodyForm {
        let body = &self.drawing.bodies[index];
        let local = |at: &[f64; 2]| self.local(Some(index), *at);
        BodyForm {
            name: body.name.clone(),
            start: self.frame(Some(index)),
            points: body.points.iter().map(local).collect(),
            centre: local(&body.centre),
            rim: body.shape.iter().flat_map(|shape| shape.rim()).map(|corner| local(&corner)).collect(),
            cornered: self.drawing.is_cornered(index),
        }
    }

    fn joint(&self, joint: &DrawnJoint) -> JointForm {
        let (hold, axis) = match joint.kind {
            Hold::Pin => ("pin", None),
            Hold::Fixed => ("fixed", None),
            Hold::Slider(axis) => ("slider", Some(axis)),
            Hold::Slot(axis) => ("slot", Some(axis)),
        };
        JointForm {
            name: joint.name.clone(),
            hold,
            ends: self.anchors(joint.between, joint.at),
            axis: axis.map(|axis| self.turned(joint.between[0], axis)),
        }
    }

    fn held(&self, held: &HeldPart) -> HeldForm {
        let off = held.spot.off.map(|(body, off)| Anchor { body, at: self.turned(body, off), point: None });
        HeldForm {
            name: held.name.clone(),
            at: self.anchor(held.spot.on, held.spot.at),
            off,
            sticks: held.sticks,
            while_held: held.while_held.clone(),
            impulse: held.impulse.clone(),
        }
    }

    fn marks<'m>(
        &self,
        marks: impl Iterator<Item = (&'m String, Option<usize>, [f64; 2], Option<[f64; 2]>)>,
    ) -> Vec<MarkForm> {
        let finite = marks.filter(|(_, _, at, direction)| is_finite(at) && direction.is_none_or(|d| is_finite(&d)));
        finite
            .map(|(name, on, at, direction)| MarkForm { name: name.clone(), at: self.anchor(on, at), direction })
            .collect()
    }

    fn parts(&self, view: &View) -> Vec<CarriedPart> {
        let parts = LAYERS.into_iter().flat_map(|(layer, draw)| {
            let mut drawn = Svg::default();
            draw(self.drawing, view, &mut drawn, &mut Labels::default());
            let elements = drawn.parts().map(|(carrier, elements)| (carrier, elements_of(carrier, &elements)));
            let parts = joined(elements, Carrier::whole).into_iter().filter(|(carrier, _)| is_carried(carrier));
            parts.map(|(carrier, svg)| CarriedPart { layer, svg, carrier: self.carrier(carrier) }).collect::<Vec<_>>()
        });
        parts.collect()
    }

    /// With its places in the axes of their bodies.
    fn carrier(&self, carrier: &Carrier) -> Carrier {
        let mut copy = carrier.clone();
        if let Carrier::Track(Track { way, .. }) = &mut copy {
            way.axis = self.turned(way.base.body, unit(way.axis));
        }
        copy.anchors().into_iter().for_each(|anchor| *anchor = self.anchor(anchor.body, anchor.at));
        copy
    }
}

/// Does a page draw it like this? It has arrows and names of its own.
fn is_carried(carrier: &Carrier) -> bool {
    !matches!(carrier, Carrier::Name | Carrier::Point { .. } | Carrier::Turn { arrow: true, .. })
}

/// The elements in the colours of a page: of what changes its shape lines that it draws anew; marks are seen from near only.
fn elements_of(carrier: &Carrier, drawn: &str) -> String {
    let path = |style: &String| format!("<path {style}/>");
    let elements = match carrier {
        Carrier::Stretch(Stretch { lines, .. }) => {
            [0, 1].map(|layer| lines.iter().map(|line| path(&line.styles[layer])).collect::<String>()).concat()
        }
        Carrier::Centre { .. } => format!("<g class=\"mark\">{drawn}</g>"),
        Carrier::Track(track) => track.rails.iter().map(|rail| path(&rail.style)).collect(),
        Carrier::Band(_) => path(&symbols::band_style()).repeat(2),
        _ => drawn.to_owned(),
    };
    symbols::named(&elements)
}

#[cfg(test)]
mod tests {
    use super::super::shapes::{difference, norm};
    use super::super::{DrawnBody, DrawnForce};
    use super::*;

    fn turned_bar() -> Drawing {
        let points = vec![[1.0, 1.0], [1.0, 3.0]];
        let body = DrawnBody { name: "bar".into(), points, centre: [1.0, 2.0], shape: None };
        let force = DrawnForce { name: "f".into(), on: Some(0), at: [1.0, 3.0], direction: [0.0, 1.0] };
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
        let Anchor { body, at, point } = geometry.forces[0].at;
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
