//! Drawing order: ground, couplings, bodies, loads, joints, targets, each with space for its name.

use super::coupling::DrawnCoupling;
use super::labels::Labels;
use super::view::View;
use super::{Drawing, DrawnJoint, Hold, Stop, is_finite, shapes, symbols};
use crate::carrier::{Anchor, Carrier};
use crate::svg::{Pixel, Svg};

/// Beyond so many bodies names would only cover the drawing.
const NAMED_BODIES: usize = 40;
/// Beyond so many joints only the bodies are named.
const NAMED_JOINTS: usize = 20;

impl Drawing {
    pub(super) fn draw_ground(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for shape in &self.ground_shapes {
            let rim = shape.rim();
            if rim.iter().all(is_finite) {
                let rim: Vec<Pixel> = rim.into_iter().map(|corner| view.pixel(corner)).collect();
                svg.carry(Carrier::Body { body: None });
                symbols::ground_plate(svg, &rim);
                labels.obstruct(&rim, view.pin);
            }
        }
        let pedestal = |place: [f64; 2], at: [f64; 2], svg: &mut Svg, labels: &mut Labels| {
            let at = view.pixel(at);
            svg.carry(Carrier::At { at: Anchor::new(None, place) });
            symbols::pedestal(svg, view, at);
            labels.cover(shapes::along(at, 2.5 * view.pin, [0.0, 1.0]), 3.0 * view.pin);
        };
        let wall = |place: [f64; 2], at: [f64; 2], outward: Pixel, svg: &mut Svg| {
            svg.carry(Carrier::At { at: Anchor::new(None, place) });
            symbols::wall(svg, view, view.pixel(at), outward);
        };
        let joints = self.joints.iter().enumerate();
        for (index, joint) in joints.filter(|(_, joint)| joint.is_grounded() && joint.is_finite()) {
            let (place, at) = (joint.at[usize::from(joint.between[1].is_none())], joint.moving().1);
            match joint.kind {
                Hold::Pin => pedestal(place, at, svg, labels),
                Hold::Fixed => wall(place, at, [0.0, -1.0], svg),
                Hold::Slider(_) => self.draw_track((index, joint), 1.2, view, svg, labels),
                Hold::Slot(_) => {}
            }
        }
        let links = self.couplings.iter().filter(|coupling| coupling.is_finite());
        for end in links.flat_map(DrawnCoupling::link_ends).filter(|end| self.ground.contains(end)) {
            pedestal(end, end, svg, labels);
        }
        let anchors = self.ground.iter().filter(|at| is_finite(at) && !self.is_jointed_to_ground(at, view));
        for anchor in anchors {
            let at = view.pixel(*anchor);
            if let Some(spring) = self.springs.iter().find(|spring| spring.ends.iter().any(|end| end == anchor)) {
                let other = if spring.ends[0] == *anchor { spring.ends[1] } else { spring.ends[0] };
                wall(*anchor, *anchor, shapes::unit(shapes::difference(view.pixel(other), at)), svg);
                labels.cover(at, 2.5 * view.pin);
            }
        }
    }

    fn draw_track(
        &self,
        (index, joint): (usize, &DrawnJoint),
        room: f64,
        view: &View,
        svg: &mut Svg,
        labels: &mut Labels,
    ) {
        if let Some(mut track) = joint.track(view) {
            let stops: Vec<&Stop> = self.stops.iter().filter(|stop| stop.joint == joint.name).collect();
            track.cover(&stops, view);
            let ends = track.draw(self.range.joints.get(index).copied(), view, svg);
            labels.obstruct(&ends, room * view.pin);
        }
    }

    /// All couplings but those that roll: these lie between the bodies.
    pub(super) fn draw_couplings(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for (index, coupling) in self.couplings.iter().enumerate() {
            if coupling.rolling_bodies().is_none() {
                self.draw_coupling((index, coupling), view, svg, labels);
            }
        }
    }

    fn draw_coupling(
        &self,
        (index, coupling): (usize, &DrawnCoupling),
        view: &View,
        svg: &mut Svg,
        labels: &mut Labels,
    ) {
        if coupling.is_finite() {
            let anchor = coupling.draw(self.range.couplings.get(index).copied(), view, svg, labels);
            if self.joints.len() <= NAMED_JOINTS {
                labels.joint(&coupling.name, anchor, 2.0 * view.pin);
            }
        }
    }

    pub(super) fn draw_bodies(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for (index, joint) in self.joints.iter().enumerate().filter(|(_, joint)| joint.is_finite()) {
            match joint.kind {
                Hold::Slot(_) => self.draw_track((index, joint), 1.6, view, svg, labels),
                // Names may lie beside a rod, and on it.
                Hold::Slider(_) if !joint.is_grounded() => {
                    self.draw_track((index, joint), 0.0, view, svg, &mut Labels::default());
                }
                _ => {}
            }
        }
        for index in self.drawing_order(view) {
            let rolls = |coupling: &DrawnCoupling| coupling.rolling_bodies().is_some_and(|(_, disc)| disc == index);
            let couplings = self.couplings.iter().enumerate().filter(|(_, coupling)| rolls(coupling));
            couplings.for_each(|coupling| self.draw_coupling(coupling, view, svg, labels));
            let (outline, bar, slider) = (self.outline(index, view), self.bar(index, view), self.slider(index));
            let width = symbols::bar_width(view, &bar, slider.is_some());
            svg.carry(Carrier::Bar { body: index, drawn: width.is_some() });
            symbols::bar(svg, index, &bar, width);
            let block = slider.map(|(joint, axis)| (joint.moving().1, view.direction(axis)));
            if let Some((at, axis)) = block {
                svg.carry(Carrier::At { at: Anchor::new(Some(index), at) });
                symbols::block(svg, view, index, view.pixel(at), axis);
            }
            if self.bodies[index].shape.is_some() {
                svg.carry(Carrier::Body { body: Some(index) });
                symbols::plate(svg, index, &outline);
            }
            if !self.is_covered(self.bodies[index].centre, view) {
                svg.carry(Carrier::Centre { body: index });
                self.draw_centre(index, view, svg, labels);
            }
            labels.obstruct(&outline, 1.5 * view.pin);
            if let Some((at, axis)) = block {
                let ends = [-1.0, 1.0].map(|side| shapes::along(view.pixel(at), 2.0 * side * view.pin, axis));
                labels.obstruct(&ends, 2.3 * view.pin);
            }
            if self.bodies.len() <= NAMED_BODIES {
                let anchor = shapes::middle(&outline);
                labels.body(&self.bodies[index].name, anchor, view.pin, symbols::colour(index).1);
            }
        }
    }

    /// The mass centre, around the joint that covers it if one does.
    fn draw_centre(&self, index: usize, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let (centre, radius) = (view.pixel(self.bodies[index].centre), self.mark(index, view));
        symbols::centre(svg, view, index, centre, radius);
        labels.cover(centre, radius * view.pin);
    }

    pub(super) fn draw_loads(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let named = self.joints.len() <= NAMED_JOINTS;
        let springs = self.springs.iter();
        for spring in springs.filter(|spring| spring.ends.iter().all(is_finite)) {
            svg.carry(Carrier::Stretch(self.stretch(spring, view)));
            let ends = self.spring_ends(spring, view);
            symbols::spring(svg, view, ends, spring);
            let side = shapes::normal(shapes::unit(shapes::difference(ends[1], ends[0])));
            let ends = ends.map(|end| shapes::along(end, spring.beside * view.pin, side));
            labels.obstruct(&ends, 1.3 * view.pin);
            if named {
                labels.load(&spring.name, shapes::middle(&ends), 1.8 * view.pin, symbols::SPRING);
            }
        }
        for force in self.forces.iter().filter(|force| is_finite(&force.at) && is_finite(&force.direction)) {
            svg.carry(Carrier::Name);
            let (at, direction) = (view.pixel(force.at), view.direction(force.direction));
            let ends = symbols::force(svg, view, at, direction, self.is_crowded(at, direction, view));
            labels.obstruct(&ends, view.pin);
            if named {
                labels.load(&force.name, shapes::middle(&ends), 1.4 * view.pin, symbols::FORCE);
            }
        }
        for turn in self.turns.iter().filter(|turn| is_finite(&turn.at)) {
            let at = Anchor::new(turn.on, turn.at);
            svg.carry(Carrier::Turn { name: turn.name.clone(), at, arrow: turn.glyph.is_none() });
            let at = view.pixel(turn.at);
            match turn.glyph {
                Some(glyph) => symbols::round_glyph(svg, view, at, glyph),
                None => symbols::turn(svg, view, at),
            }
            labels.cover(at, 3.2 * view.pin);
            if named {
                labels.load(&turn.name, at, 3.8 * view.pin, symbols::FORCE);
            }
        }
    }

    pub(super) fn draw_joints(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        let covered = |body: &usize| self.is_covered(self.bodies[*body].centre, view);
        // The larger ones first: what lies around others is behind them.
        let mut covered: Vec<usize> = self.drawing_order(view).into_iter().filter(covered).collect();
        covered.sort_by(|a, b| self.mark(*b, view).total_cmp(&self.mark(*a, view)));
        for body in covered {
            svg.carry(Carrier::Body { body: Some(body) });
            self.draw_centre(body, view, svg, labels);
        }
        for coupling in self.couplings.iter().filter(|coupling| coupling.is_finite()) {
            coupling.draw_front(view, svg);
        }
        for joint in self.joints.iter().filter(|joint| joint.is_finite()) {
            let (body, place) = joint.moving();
            let at = view.pixel(place);
            svg.carry(Carrier::At { at: Anchor::new(body, place) });
            match joint.kind {
                Hold::Pin | Hold::Slot(_) | Hold::Fixed if joint.open => symbols::open(svg, view, at),
                Hold::Pin | Hold::Slot(_) => symbols::pin(svg, view, at),
                Hold::Fixed => symbols::weld(svg, view, at),
                Hold::Slider(_) => {}
            }
            labels.cover(at, 1.3 * view.pin);
            if self.joints.len() <= NAMED_JOINTS && !joint.name.is_empty() {
                labels.joint(&joint.name, at, 2.0 * view.pin);
            }
        }
        self.draw_stops(view, svg, labels);
    }

    /// Above the pins: a driven point is often one.
    pub(super) fn draw_targets(&self, view: &View, svg: &mut Svg, labels: &mut Labels) {
        for target in self.targets.iter().filter(|target| is_finite(&target.at)) {
            svg.carry(Carrier::Point { at: Anchor::new(target.on, target.at) });
            let at = view.pixel(target.at);
            symbols::target(svg, view, at);
            labels.cover(at, 2.8 * view.pin);
            if let Some(direction) = target.direction.filter(is_finite) {
                svg.carry(Carrier::Name);
                let ends = symbols::departure(svg, view, at, view.direction(direction));
                labels.obstruct(&ends, view.pin);
            }
            if self.joints.len() <= NAMED_JOINTS {
                labels.load(&target.name, at, 3.4 * view.pin, symbols::FORCE);
            }
        }
    }
}
