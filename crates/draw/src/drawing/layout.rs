//! Places in the picture, and the order of drawing.

use cotree::component::IconStroke;

use super::coupling::DrawnCoupling;
use super::view::View;
use super::{Drawing, DrawnBody, DrawnJoint, DrawnShape, DrawnSpring, Hold, is_finite, shapes, symbols};
use crate::alike::Alike;
use crate::carrier::{Anchor, CarriedLine, Stretch};
use crate::svg::Pixel;

impl Drawing {
    /// Bodies from back to front: what slides on the ground, what carries a slider or a rolling disc, those, the others; long ones
    /// first.
    pub(super) fn drawing_order(&self, view: &View) -> Vec<usize> {
        let layer = |body: usize| {
            let prismatic = self.joints.iter().filter(|joint| matches!(joint.kind, Hold::Slider(_)));
            let rolling = self.couplings.iter().filter_map(DrawnCoupling::rolling_bodies).filter_map(|(line, disc)| {
                let carries = (line == Some(body)).then_some(1);
                carries.or((disc == body).then_some(2))
            });
            prismatic
                .filter_map(|joint| match joint.between {
                    [Some(first), Some(_)] if first == body => Some(1),
                    [Some(_), Some(second)] if second == body => Some(2),
                    sides if sides.contains(&Some(body)) => Some(0),
                    _ => None,
                })
                .chain(rolling)
                .min()
                .unwrap_or(3)
        };
        let mut order: Vec<(i32, f64, usize)> = (0..self.bodies.len())
            .filter(|&body| self.bodies[body].is_finite())
            .map(|body| (layer(body), shapes::extent(&self.outline(body, view)), body))
            .collect();
        order.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        order.into_iter().map(|(_, _, body)| body).collect()
    }

    /// The ends of a spring in the picture; at a slider the face of its block along the spring.
    pub(super) fn spring_ends(&self, spring: &DrawnSpring, view: &View) -> [Pixel; 2] {
        let ends = spring.ends.map(|end| view.pixel(end));
        let axis = shapes::unit(shapes::difference(ends[1], ends[0]));
        let length = shapes::norm(shapes::difference(ends[1], ends[0]));
        let is_face = |joint: &DrawnJoint, end: [f64; 2]| {
            let Hold::Slider(slide) = joint.kind else {
                return false;
            };
            let slide = view.direction(slide);
            let level = (slide[0] * axis[0] + slide[1] * axis[1]).abs() > 0.95;
            joint.moving().1 == end && level
        };
        let retreat = |side: usize| {
            let block = self.joints.iter().any(|joint| is_face(joint, spring.ends[side]));
            if block { symbols::block_length(view).min(0.3 * length) } else { 0.0 }
        };
        [shapes::along(ends[0], retreat(0), axis), shapes::along(ends[1], -retreat(1), axis)]
    }

    /// A spring as it follows its ends. One without length at the start is drawn as if it had some.
    pub(super) fn stretch(&self, spring: &DrawnSpring, view: &View) -> Stretch {
        let (full, drawn) = (spring.ends.map(|end| view.pixel(end)), self.spring_ends(spring, view));
        let length = (shapes::norm(shapes::difference(drawn[1], drawn[0])) / view.pin).max(10.0);
        Stretch {
            name: spring.name.clone(),
            ends: [0, 1].map(|side| Anchor::new(spring.between[side], spring.ends[side])),
            retreat: [0, 1].map(|side| shapes::norm(shapes::difference(drawn[side], full[side]))),
            length,
            lines: spring.lines(length),
        }
    }

    /// Does a body extend from a point in about this direction?
    pub(super) fn is_crowded(&self, at: Pixel, direction: Pixel, view: &View) -> bool {
        (0..self.bodies.len()).map(|body| self.outline(body, view)).any(|outline| {
            let touches = outline.iter().any(|&corner| shapes::norm(shapes::difference(corner, at)) < view.pin);
            let away = shapes::unit(shapes::difference(shapes::middle(&outline), at));
            touches && outline.len() > 1 && away[0] * direction[0] + away[1] * direction[1] > 0.7
        })
    }

    /// The corners of a body in the picture, in order: of its shape, or of the bar along its points.
    pub(super) fn outline(&self, index: usize, view: &View) -> Vec<Pixel> {
        match &self.bodies[index].shape {
            Some(shape) => shape.rim().into_iter().map(|corner| view.pixel(corner)).collect(),
            None => self.bar(index, view),
        }
    }

    /// What joins the points of a body: all there is of one without a shape; of one with a shape none if no point sticks out.
    pub(super) fn bar(&self, index: usize, view: &View) -> Vec<Pixel> {
        let body = &self.bodies[index];
        if let Some(shape) = &body.shape {
            let rim: Vec<Pixel> = shape.rim().into_iter().map(|corner| view.pixel(corner)).collect();
            let covered = |point: &[f64; 2]| shapes::covers(&rim, view.pixel(*point), 1.5 * view.pin);
            if body.points.iter().all(covered) {
                return Vec::new();
            }
        }
        let mut points: Vec<_> = body.points.iter().map(|&point| view.pixel(point)).collect();
        if self.is_cornered(index) {
            points.push(view.pixel(body.centre));
        }
        shapes::hull(points)
    }

    /// The bar along the points of a body, in the world; none if it has a shape.
    pub(crate) fn corners(&self, index: usize) -> Vec<[f64; 2]> {
        let body = &self.bodies[index];
        if body.shape.is_some() {
            return Vec::new();
        }
        let centre = self.is_cornered(index).then_some(body.centre);
        shapes::hull(body.points.iter().copied().chain(centre).collect())
    }

    /// Is the mass centre of a body a corner of it? It is where the body is joined, or there is hardly another.
    pub(super) fn is_cornered(&self, index: usize) -> bool {
        let body = &self.bodies[index];
        let joined =
            |joint: &DrawnJoint| (0..2).any(|side| joint.between[side] == Some(index) && joint.at[side] == body.centre);
        body.points.len() < 2 || self.joints.iter().any(joined)
    }

    /// Does the sign of a joint cover this place? A slide has none.
    pub(super) fn is_covered(&self, at: [f64; 2], view: &View) -> bool {
        let signs = self.joints.iter().filter(|joint| !matches!(joint.kind, Hold::Slider(_)));
        let links = self.couplings.iter().flat_map(DrawnCoupling::link_ends);
        signs.map(|joint| joint.moving().1).chain(links).any(|sign| view.distance(sign, at) < 1.8 * view.pin)
    }

    /// The radius of the mark of a mass centre in pins: around the joint that covers it, and around the marks of bodies before it that lie there too.
    pub(super) fn mark(&self, index: usize, view: &View) -> f64 {
        const FREE: f64 = 0.72;
        const AROUND: f64 = 1.45;
        const NEXT: f64 = 0.6;
        let at = self.bodies[index].centre;
        if !self.is_covered(at, view) {
            return FREE;
        }
        let before = self.bodies[..index].iter().filter(|body| view.distance(body.centre, at) < 0.5 * view.pin);
        AROUND + NEXT * before.count() as f64
    }

    /// The joint in which a body slides, if it does, and along what.
    pub(super) fn slider(&self, body: usize) -> Option<(&DrawnJoint, [f64; 2])> {
        self.joints.iter().filter(|joint| joint.is_finite()).find_map(|joint| match joint.kind {
            Hold::Slider(axis) if joint.moving().0 == Some(body) => Some((joint, axis)),
            _ => None,
        })
    }

    /// Where several springs and dampers have the same ends they lie side by side.
    pub(crate) fn part_springs(&mut self) {
        /// From one to the next [pins].
        const APART: f64 = 4.4;
        let ends: Vec<[[f64; 2]; 2]> = self.springs.iter().map(|spring| spring.ends).collect();
        let near = |a: [f64; 2], b: [f64; 2], size: f64| shapes::norm(shapes::difference(a, b)) <= 1e-6 * size;
        let along = |[a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]| {
            let size = shapes::norm(shapes::difference(b, a));
            near(a, c, size) && near(b, d, size)
        };
        for (index, spring) in self.springs.iter_mut().enumerate() {
            let [a, b] = spring.ends;
            let same = |other: &usize| *other == index || along([a, b], ends[*other]) || along([b, a], ends[*other]);
            let group: Vec<usize> = (0..ends.len()).filter(same).collect();
            let rank = group.iter().filter(|&&other| other < index).count() as f64;
            let side = APART * (rank - 0.5 * (group.len() as f64 - 1.0));
            // The sides are those of the first one's direction.
            spring.beside = if group[0] == index || along([a, b], ends[group[0]]) { side } else { -side };
        }
    }

    pub(super) fn is_jointed_to_ground(&self, point: &[f64; 2], view: &View) -> bool {
        self.joints
            .iter()
            .filter(|joint| joint.is_grounded() && joint.kind == Hold::Pin)
            .any(|joint| shapes::norm(shapes::difference(view.pixel(joint.at[0]), view.pixel(*point))) < view.pin)
    }
}

impl DrawnSpring {
    /// The lines of its sign at a length in pins; if it lies beside another, with its feet on the line between their ends.
    pub(super) fn strokes(&self, length: f64) -> Vec<IconStroke> {
        if self.beside == 0.0 {
            return (self.glyph)(length);
        }
        let foot = (0.12 * length).min(1.6);
        let mut strokes = (self.glyph)(length - 2.0 * foot);
        for [x, y] in strokes.iter_mut().flat_map(|stroke| &mut stroke.points) {
            (*x, *y) = (*x + foot, *y + self.beside);
        }
        let feet = [[0.0, foot], [length, length - foot]];
        strokes.extend(feet.map(|[end, x]| IconStroke::open(vec![[end, 0.0], [x, 0.0], [x, self.beside]])));
        strokes
    }

    /// The lines of its sign at this length, and how they follow it: those of one a little longer show that. A spring keeps its coils.
    fn lines(&self, length: f64) -> Vec<CarriedLine> {
        const LONGER: f64 = 1e-3;
        let (now, then) = (self.strokes(length), self.strokes(length + LONGER));
        let line = |(now, then): (&IconStroke, &IconStroke)| {
            let same = now.points.len() == then.points.len();
            let point = |(index, &[x, y]): (usize, &[f64; 2])| {
                let slope = if same { (then.points[index][0] - x) / LONGER } else { x / length };
                [x, y, slope]
            };
            let styles = [false, true].map(|front| symbols::stroke_style(front, now.closed));
            CarriedLine { closed: now.closed, points: now.points.iter().enumerate().map(point).collect(), styles }
        };
        now.iter().zip(&then).map(line).collect()
    }
}

impl DrawnBody {
    pub(super) fn is_finite(&self) -> bool {
        self.extent().iter().all(is_finite)
    }

    /// Every place that it reaches.
    pub(super) fn extent(&self) -> Vec<[f64; 2]> {
        let rim = self.shape.as_ref().map(DrawnShape::rim).unwrap_or_default();
        self.points.iter().copied().chain([self.centre]).chain(rim).collect()
    }
}

impl DrawnShape {
    /// Points around it, in order.
    pub(super) fn rim(&self) -> Vec<[f64; 2]> {
        match self {
            DrawnShape::Polygon(corners) => corners.clone(),
            DrawnShape::Disc([x, y], radius) => {
                let angle = |step: u32| std::f64::consts::TAU * f64::from(step) / 48.0;
                (0..48).map(|step| [x + radius * angle(step).cosine(), y + radius * angle(step).sine()]).collect()
            }
        }
    }
}

impl DrawnJoint {
    /// The body that a slider is drawn on, and where: the second unless it is the ground.
    pub(super) fn moving(&self) -> (Option<usize>, [f64; 2]) {
        let side = usize::from(self.between[1].is_some());
        (self.between[side], self.at[side])
    }

    pub(super) fn is_grounded(&self) -> bool {
        self.between.contains(&None)
    }

    pub(super) fn is_finite(&self) -> bool {
        let axis = match self.kind {
            Hold::Slider(axis) | Hold::Slot(axis) => axis,
            Hold::Pin | Hold::Fixed => [0.0, 0.0],
        };
        self.at.iter().all(is_finite) && is_finite(&axis)
    }
}
