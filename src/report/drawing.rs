//! A drawing of the mechanism in one position, as a textbook would draw it.

mod coupling;
mod labels;
mod shapes;
mod symbols;
mod view;

use super::svg::{Frame, Pixel, Svg, number};
pub use coupling::{Coupling, CouplingKind, Wheel};
use labels::Labels;
use view::View;

/// What is drawn, in the world \[m\]. What has a coordinate that is not finite is left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The scene's name.
    pub title: String,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Points of the ground that something is fixed to.
    pub ground: Vec<[f64; 2]>,
    /// The joints.
    pub joints: Vec<Joint>,
    /// Gears, racks, rolling discs and links.
    pub couplings: Vec<Coupling>,
    /// Springs and actuators between two points.
    pub springs: Vec<Spring>,
    /// Forces.
    pub forces: Vec<Force>,
    /// Torques, torsion springs and motors.
    pub turns: Vec<Turn>,
    /// Points that a driver leads.
    pub targets: Vec<Target>,
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The user's name.
    pub name: String,
    /// Its points.
    pub points: Vec<[f64; 2]>,
    /// Its mass centre.
    pub centre: [f64; 2],
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The user's name; empty for one that is drawn but not there.
    pub name: String,
    /// What it permits.
    pub kind: JointKind,
    /// Indices of the bodies; `None` is the ground.
    pub between: [Option<usize>; 2],
    /// Where the joint is on either body: the same place for a revolute joint.
    pub at: [[f64; 2]; 2],
}

/// What a joint permits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Turning.
    Revolute,
    /// Sliding along this direction in the world.
    Prismatic([f64; 2]),
    /// Sliding along this direction in the world, and turning.
    Slot([f64; 2]),
    /// Nothing.
    Weld,
}

/// A spring or an actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// The user's name.
    pub name: String,
    /// Indices of the bodies; `None` is the ground.
    pub between: [Option<usize>; 2],
    /// Its ends.
    pub ends: [[f64; 2]; 2],
}

/// A force.
#[derive(Clone, Debug, PartialEq)]
pub struct Force {
    /// The user's name.
    pub name: String,
    /// Index of the body; `None` is the ground.
    pub on: Option<usize>,
    /// The point it acts on.
    pub at: [f64; 2],
    /// Its direction in the world; the length is not looked at.
    pub direction: [f64; 2],
}

/// Something that turns a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// The user's name.
    pub name: String,
    /// Where to draw it: the joint, or the mass centre.
    pub at: [f64; 2],
}

/// A point whose position is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The driver's name.
    pub name: String,
    /// Index of the body; `None` is the ground.
    pub on: Option<usize>,
    /// Where the point is.
    pub at: [f64; 2],
    /// Where it goes from there, if it moves; the length is not looked at.
    pub direction: Option<[f64; 2]>,
}

/// Beyond so many bodies names would only cover the drawing.
const NAMED_BODIES: usize = 40;
/// Beyond so many joints only the bodies are named.
const NAMED_JOINTS: usize = 20;
/// Space around the drawing [px].
const MARGIN: f64 = 20.0;

impl Drawing {
    /// The picture, self-contained.
    pub fn svg(&self) -> String {
        let (svg, frame) = self.picture();
        svg.finish(frame, &self.title)
    }

    /// The picture as a group of elements with its upper left corner at the origin, to be put into another; width and height.
    pub fn nested(&self) -> (String, [f64; 2]) {
        let (svg, Frame { x, y, width, height }) = self.picture();
        let shift = [-x, -y].map(number);
        (format!("<g transform=\"translate({} {})\">\n{}</g>", shift[0], shift[1], svg.elements()), [width, height])
    }

    fn picture(&self) -> (Svg, Frame) {
        let view = View::fit(self);
        let mut svg = Svg::default();
        let mut labels = Labels::default();
        self.draw_couplings(&view, &mut svg, &mut labels);
        self.draw_ground(&view, &mut svg, &mut labels);
        self.draw_bodies(&view, &mut svg, &mut labels);
        self.draw_loads(&view, &mut svg, &mut labels);
        self.draw_joints(&view, &mut svg, &mut labels);
        self.draw_targets(&view, &mut svg, &mut labels);
        labels.place(&mut svg);
        let frame = labels.frame(MARGIN);
        (svg, frame)
    }

    fn draw_ground(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for joint in self.joints.iter().filter(|joint| joint.is_grounded() && joint.is_finite()) {
            let at = view.pixel(joint.moving().1);
            match joint.kind {
                JointKind::Revolute => {
                    symbols::pedestal(svg, view, at);
                    labels.cover(shapes::along(at, 2.5 * view.pin, [0.0, 1.0]), 3.0 * view.pin);
                }
                JointKind::Prismatic(axis) => {
                    let ends = symbols::guide(svg, view, at, view.direction(axis));
                    labels.obstruct(&ends, 1.2 * view.pin);
                }
                JointKind::Weld => symbols::wall(svg, view, at, [0.0, -1.0]),
                JointKind::Slot(_) => {}
            }
        }
        let links = self.couplings.iter().filter(|coupling| coupling.is_finite());
        for end in links.flat_map(Coupling::link_ends).filter(|end| self.ground.contains(end)) {
            let at = view.pixel(end);
            symbols::pedestal(svg, view, at);
            labels.cover(shapes::along(at, 2.5 * view.pin, [0.0, 1.0]), 3.0 * view.pin);
        }
        let anchors = self.ground.iter().filter(|at| is_finite(at) && !self.is_jointed_to_ground(at, view));
        for anchor in anchors {
            let at = view.pixel(*anchor);
            if let Some(spring) = self.springs.iter().find(|spring| spring.ends.iter().any(|end| end == anchor)) {
                let other = if spring.ends[0] == *anchor { spring.ends[1] } else { spring.ends[0] };
                symbols::wall(svg, view, at, shapes::unit(shapes::difference(view.pixel(other), at)));
                labels.cover(at, 2.5 * view.pin);
            }
        }
    }

    /// All couplings but those that roll: these lie between the bodies.
    fn draw_couplings(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for coupling in self.couplings.iter().filter(|coupling| coupling.rolling_bodies().is_none()) {
            self.draw_coupling(coupling, view, svg, labels);
        }
    }

    fn draw_coupling(&self, coupling: &Coupling, view: &View, svg: &mut Svg, labels: &mut Labels) {
        if coupling.is_finite() {
            let anchor = coupling.draw(view, svg, labels);
            if self.joints.len() <= NAMED_JOINTS {
                labels.joint(&coupling.name, anchor, 2.0 * view.pin);
            }
        }
    }

    fn draw_bodies(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for joint in self.joints.iter().filter(|joint| joint.is_finite()) {
            symbols::rod(svg, view, joint);
            if let Some(slot) = symbols::slot(svg, view, joint) {
                labels.obstruct(&slot, 1.6 * view.pin);
            }
        }
        for index in self.drawing_order(view) {
            let rolls = |coupling: &&Coupling| coupling.rolling_bodies().is_some_and(|(_, disc)| disc == index);
            self.couplings.iter().filter(rolls).for_each(|coupling| self.draw_coupling(coupling, view, svg, labels));
            let outline = self.outline(index, view);
            let block = self.slider(index).map(|(at, axis)| (view.pixel(at), view.direction(axis)));
            symbols::body(svg, view, index, &outline, block);
            self.draw_centre(index, view, svg, labels);
            labels.obstruct(&outline, 1.5 * view.pin);
            if let Some((at, axis)) = block {
                let ends = [-1.0, 1.0].map(|side| shapes::along(at, 2.0 * side * view.pin, axis));
                labels.obstruct(&ends, 2.3 * view.pin);
            }
            if self.bodies.len() <= NAMED_BODIES {
                let anchor = shapes::middle(&outline);
                labels.body(&self.bodies[index].name, anchor, view.pin, symbols::colour(index).1);
            }
        }
    }

    /// Bodies from back to front: what slides on the ground, what carries a slider or a rolling disc, those, the others; long ones
    /// first.
    fn drawing_order(&self, view: &View) -> Vec<usize> {
        let layer = |body: usize| {
            let prismatic = self.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Prismatic(_)));
            let rolling = self.couplings.iter().filter_map(Coupling::rolling_bodies).filter_map(|(line, disc)| {
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

    /// The mass centre, unless a joint covers it.
    fn draw_centre(&self, index: usize, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let centre = view.pixel(self.bodies[index].centre);
        let covered = self.joints.iter().flat_map(|joint| joint.at).any(|at| {
            let away = shapes::norm(shapes::difference(view.pixel(at), centre));
            away < 1.8 * view.pin
        });
        if !covered {
            symbols::centre(svg, view, index, centre);
            labels.cover(centre, view.pin);
        }
    }

    fn draw_loads(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let named = self.joints.len() <= NAMED_JOINTS;
        for spring in self.springs.iter().filter(|spring| spring.ends.iter().all(is_finite)) {
            let ends = self.spring_ends(spring, view);
            symbols::spring(svg, view, ends);
            labels.obstruct(&ends, 1.3 * view.pin);
            if named {
                labels.load(&spring.name, shapes::middle(&ends), 1.8 * view.pin, symbols::SPRING);
            }
        }
        for force in self.forces.iter().filter(|force| is_finite(&force.at) && is_finite(&force.direction)) {
            let (at, direction) = (view.pixel(force.at), view.direction(force.direction));
            let ends = symbols::force(svg, view, at, direction, self.is_crowded(at, direction, view));
            labels.obstruct(&ends, view.pin);
            if named {
                labels.load(&force.name, shapes::middle(&ends), 1.4 * view.pin, symbols::FORCE);
            }
        }
        for turn in self.turns.iter().filter(|turn| is_finite(&turn.at)) {
            let at = view.pixel(turn.at);
            symbols::turn(svg, view, at);
            labels.cover(at, 3.2 * view.pin);
            if named {
                labels.load(&turn.name, at, 3.8 * view.pin, symbols::FORCE);
            }
        }
    }

    /// The ends of a spring in the picture; at a slider the face of its block that looks along the spring.
    fn spring_ends(&self, spring: &Spring, view: &View) -> [Pixel; 2] {
        let ends = spring.ends.map(|end| view.pixel(end));
        let axis = shapes::unit(shapes::difference(ends[1], ends[0]));
        let length = shapes::norm(shapes::difference(ends[1], ends[0]));
        let is_face = |joint: &Joint, end: [f64; 2]| {
            let JointKind::Prismatic(slide) = joint.kind else {
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

    fn draw_joints(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for coupling in self.couplings.iter().filter(|coupling| coupling.is_finite()) {
            coupling.draw_front(view, svg);
        }
        for joint in self.joints.iter().filter(|joint| joint.is_finite()) {
            let at = view.pixel(joint.moving().1);
            match joint.kind {
                JointKind::Revolute | JointKind::Slot(_) => symbols::pin(svg, view, at),
                JointKind::Weld => symbols::weld(svg, view, at),
                JointKind::Prismatic(_) => {}
            }
            labels.cover(at, 1.3 * view.pin);
            if self.joints.len() <= NAMED_JOINTS && !joint.name.is_empty() {
                labels.joint(&joint.name, at, 2.0 * view.pin);
            }
        }
    }

    /// Above the pins: a driver often leads one.
    fn draw_targets(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for target in self.targets.iter().filter(|target| is_finite(&target.at)) {
            let at = view.pixel(target.at);
            symbols::target(svg, view, at);
            labels.cover(at, 2.8 * view.pin);
            if let Some(direction) = target.direction.filter(is_finite) {
                let ends = symbols::departure(svg, view, at, view.direction(direction));
                labels.obstruct(&ends, view.pin);
            }
            if self.joints.len() <= NAMED_JOINTS {
                labels.load(&target.name, at, 3.4 * view.pin, symbols::FORCE);
            }
        }
    }

    /// Does a body lead away from a point in about this direction?
    fn is_crowded(&self, at: Pixel, direction: Pixel, view: &View) -> bool {
        (0..self.bodies.len()).map(|body| self.outline(body, view)).any(|outline| {
            let touches = outline.iter().any(|&corner| shapes::norm(shapes::difference(corner, at)) < view.pin);
            let away = shapes::unit(shapes::difference(shapes::middle(&outline), at));
            touches && outline.len() > 1 && away[0] * direction[0] + away[1] * direction[1] > 0.7
        })
    }

    /// The corners of a body in the picture, in order.
    fn outline(&self, index: usize, view: &View) -> Vec<Pixel> {
        let body = &self.bodies[index];
        let mut points: Vec<_> = body.points.iter().map(|&point| view.pixel(point)).collect();
        if points.len() < 2 {
            points.push(view.pixel(body.centre));
        }
        shapes::hull(points)
    }

    /// Where and along what a body slides, if it does.
    fn slider(&self, body: usize) -> Option<([f64; 2], [f64; 2])> {
        self.joints.iter().filter(|joint| joint.is_finite()).find_map(|joint| match joint.kind {
            JointKind::Prismatic(axis) if joint.moving().0 == Some(body) => Some((joint.moving().1, axis)),
            _ => None,
        })
    }

    fn is_jointed_to_ground(&self, point: &[f64; 2], view: &View) -> bool {
        self.joints
            .iter()
            .filter(|joint| joint.is_grounded() && joint.kind == JointKind::Revolute)
            .any(|joint| shapes::norm(shapes::difference(view.pixel(joint.at[0]), view.pixel(*point))) < view.pin)
    }
}

impl Body {
    fn is_finite(&self) -> bool {
        is_finite(&self.centre) && self.points.iter().all(is_finite)
    }
}

impl Joint {
    /// The body that a slider is drawn on, and where: the second unless it is the ground.
    fn moving(&self) -> (Option<usize>, [f64; 2]) {
        let side = usize::from(self.between[1].is_some());
        (self.between[side], self.at[side])
    }

    fn is_grounded(&self) -> bool {
        self.between.contains(&None)
    }

    fn is_finite(&self) -> bool {
        let axis = match self.kind {
            JointKind::Prismatic(axis) | JointKind::Slot(axis) => axis,
            JointKind::Revolute | JointKind::Weld => [0.0, 0.0],
        };
        self.at.iter().all(is_finite) && is_finite(&axis)
    }
}

fn is_finite(point: &[f64; 2]) -> bool {
    point.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slider-crank with everything that can be drawn.
    fn slider_crank() -> Drawing {
        let (bearing, pin, wrist, wall) = ([0.0, 0.0], [0.3, 0.4], [1.5, 0.0], [2.5, 0.0]);
        let body =
            |name: &str, points: &[[f64; 2]], centre| Body { name: name.into(), points: points.to_vec(), centre };
        let joint = |name: &str, kind, between, at| Joint { name: name.into(), kind, between, at };
        Drawing {
            title: "slider & crank".into(),
            bodies: vec![
                body("crank", &[bearing, pin], [0.15, 0.2]),
                body("rod", &[pin, wrist, [0.9, 0.6]], [0.9, 0.2]),
                body("slider", &[], wrist),
            ],
            ground: vec![bearing, wall],
            couplings: vec![],
            joints: vec![
                joint("main_bearing", JointKind::Revolute, [None, Some(0)], [bearing; 2]),
                joint("crank_pin", JointKind::Revolute, [Some(0), Some(1)], [pin; 2]),
                joint("wrist_pin", JointKind::Weld, [Some(1), Some(2)], [wrist; 2]),
                joint("cylinder", JointKind::Prismatic([1.0, 0.0]), [None, Some(2)], [bearing, wrist]),
            ],
            springs: vec![Spring { name: "return_spring".into(), between: [Some(2), None], ends: [wrist, wall] }],
            forces: vec![Force { name: "gas".into(), on: Some(2), at: wrist, direction: [-5.0, 0.0] }],
            turns: vec![Turn { name: "motor".into(), at: bearing }],
            targets: vec![Target { name: "path".into(), on: Some(1), at: wrist, direction: Some([0.0, 1.0]) }],
        }
    }

    /// Panics if the picture is not well-formed XML.
    fn elements(svg: &str) -> usize {
        let mut reader = quick_xml::Reader::from_str(svg);
        let mut count = 0;
        loop {
            match reader.read_event().unwrap() {
                quick_xml::events::Event::Eof => return count,
                _ => count += 1,
            }
        }
    }

    #[test]
    fn every_part_is_drawn_and_named() {
        let svg = slider_crank().svg();
        assert!(elements(&svg) > 50);
        for name in ["crank", "rod", "slider", "main_bearing", "cylinder", "return_spring", "gas", "motor", "path"] {
            assert!(svg.contains(&format!(">{name}</text>")), "{name}");
        }
        assert_eq!(svg, slider_crank().svg());
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut drawing = slider_crank();
        drawing.bodies[0].centre[0] = f64::NAN;
        drawing.joints[1].at[0][1] = f64::INFINITY;
        drawing.springs[0].ends[1][0] = f64::NAN;
        drawing.forces[0].direction = [f64::NAN; 2];
        drawing.targets[0].direction = Some([f64::NAN; 2]);
        drawing.ground.push([f64::NAN; 2]);
        let svg = drawing.svg();
        elements(&svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn nothing_is_still_a_picture() {
        elements(&Drawing::default().svg());
        let body = Body { name: "mass".into(), points: vec![], centre: [3.0, 3.0] };
        elements(&Drawing { bodies: vec![body], ..Drawing::default() }.svg());
    }

    #[test]
    fn a_crowd_is_drawn_without_names() {
        let body = |index: usize| {
            let x = index as f64;
            Body { name: format!("body{index}"), points: vec![[x, 0.0], [x + 1.0, 1.0]], centre: [x, 0.5] }
        };
        let svg = Drawing { bodies: (0..1000).map(body).collect(), ..Drawing::default() }.svg();
        assert!(!svg.contains("<text"));
    }
}
