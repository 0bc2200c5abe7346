//! Profiles: when a disc touches one anew, and when it goes on from one of its features to the next.
//!
//! How far a disc is from a profile is the least of its distances from lines and arcs, which no polynomial says: it is looked for by conservative advancement. No disc comes nearer than its centre
//! moves, so that it may move on by its distance before it is looked at again (Mirtich, *Impulse-based Dynamic Simulation*, 1996, section 2.3). Near the profile steps are no shorter than a
//! small length, and where the distance has a least value between them, that is found. Which feature is touched is then the same question as for a contact with a line or a circle.

use super::super::snapshot::Snapshot;
use super::super::{Instance, InstanceError};
use super::Instants;
use super::events::between;
use crate::events::SECTIONS;
use crate::failure::Failure;
use crate::hybrid::contact::{TOUCHING, is_closed};
use crate::hybrid::contour::{Point, park, write};
use crate::hybrid::onset::{self, PARTS};
use crate::math::{largest_between, maximum, minimum};
use crate::model::State;
use crate::program::Contacts;
use crate::program::contour::{Contour, Contours, Feature, Joint, Slot};

/// Steps along a motion near a profile are no shorter than this share of the scale: the way in which a distance has one least value.
const SHORTEST_PROFILE_STEP: f64 = 1e-6;
/// The speed between two places of a piece is at most that of the chord and twice what chords beside it change by: six places in any part of it tell its course (see [`onset::fits`]).
const BENDS: f64 = 2.0;
/// After so many looks the search asks whether it may go on.
const CHECKED_EVERY: u64 = 1024;

const FROM_BEHIND: &str = "it reaches its profile from behind; if the body can be reached from all sides, write an outline with `closed = true`";
const INSIDE: &str = "it has entered its outline, and the time of the contact could not be located";
const TOO_MANY: &str =
    "it touches its profile in more places at once than are supported: one of a convex profile, three of any other";

/// Storage.
#[derive(Clone, Debug)]
pub(super) struct ContourValues {
    /// Where the discs are, x and y.
    places: Vec<f64>,
    /// Their places in the parts of a piece of a step.
    samples: Vec<[[f64; PARTS + 1]; 2]>,
}

impl ContourValues {
    pub fn new(count: usize) -> Self {
        Self { places: vec![0.0; 2 * count], samples: vec![[[0.0; PARTS + 1]; 2]; count] }
    }

    fn place(&self, contour: usize) -> Point {
        [self.places[2 * contour], self.places[2 * contour + 1]]
    }

    /// Keeps the places as those of a part of a piece.
    pub fn keep(&mut self, part: usize) {
        for (index, samples) in self.samples.iter_mut().enumerate() {
            (samples[0][part], samples[1][part]) = (self.places[2 * index], self.places[2 * index + 1]);
        }
    }

    /// True if the places at a share of a piece are what the parts of it say.
    pub fn fit(&self, share: f64) -> bool {
        let mut all = self.samples.iter().flatten().zip(&self.places);
        all.all(|(samples, &found)| onset::fits(samples, share, found, 0.0))
    }

    /// The way that the centre of a disc could go in a piece at its largest speed.
    fn way(&self, contour: usize) -> f64 {
        let [x, y] = &self.samples[contour];
        let length = |x: f64, y: f64| (x * x + y * y).sqrt();
        let chord = |part: usize| length(x[part + 1] - x[part], y[part + 1] - y[part]);
        let bend = |part: usize| {
            let second = |of: &[f64; PARTS + 1]| of[part + 1] - 2.0 * of[part] + of[part - 1];
            length(second(x), second(y))
        };
        let longest = (0..PARTS).fold(0.0, |most, part| maximum(most, chord(part)));
        let bent = (1..PARTS).fold(0.0, |most, part| maximum(most, bend(part)));
        PARTS as f64 * (longest + BENDS * bent)
    }
}

/// The number of the feature of a slot, if it has one.
fn feature_of(slot: &Slot, state: &State) -> Option<usize> {
    (state.discrete()[slot.number()] as usize).checked_sub(1)
}

/// True for a feature that is not in a slot, and on which nothing goes on from one that is touched.
fn counts(contour: &Contour, feature: usize, is_closed: impl Fn(&Slot) -> bool, state: &State) -> bool {
    contour.slots.iter().all(|slot| {
        let held = feature_of(slot, state);
        held != Some(feature) && !held.is_some_and(|held| is_closed(slot) && contour.are_joined(held, feature))
    })
}

/// Where a search is.
struct Search {
    contour: usize,
    piece: [f64; 2],
}

impl Instance {
    /// What happens at profiles where the registers have a state: their features end where the indicators say, and where they are touched anew is searched for.
    pub(super) fn indicate_profiles(&mut self, instants: &mut Instants, data: &Contours) {
        self.machine.evaluate(&data.places, &mut instants.contours.places);
        let model = self.model.clone();
        let program = model.program();
        let mut next = program.instants.first_at_profiles() - program.instants.events.len();
        for _ in &data.all {
            instants.indicators[next] = -1.0;
            next += 1;
        }
        for (index, contour) in data.all.iter().enumerate() {
            for slot in &contour.slots {
                let feature = feature_of(slot, &self.now.state).and_then(|feature| contour.features.get(feature));
                let place = instants.contours.place(index);
                // What has just opened at an end is on one curve with what follows: rounding errors would have it go on and back.
                let closed = self.is_closed_contact(program.instants.events.len() + slot.contact as usize);
                let band = if closed { 0.0 } else { TOUCHING.sqrt() * contour.radius };
                let left = |feature: &Feature| {
                    let is_left = !closed && feature.gap(place).abs() <= TOUCHING * program.length;
                    feature.left(place) - if is_left { band } else { 0.0 }
                };
                instants.indicators[next] = feature.map_or(-1.0, left);
                next += 1;
            }
        }
    }

    /// The first time before another event at which a profile is touched anew, in a piece of a step whose places are known.
    pub(super) fn first_at_profiles(
        &mut self,
        instants: &mut Instants,
        piece: [f64; 2],
        mut first: Option<(f64, usize)>,
    ) -> Option<(f64, usize)> {
        let model = self.model.clone();
        let event = model.program().instants.first_at_profiles();
        for (index, contour) in model.program().instants.contours().iter().enumerate() {
            if contour.there.is_some_and(|there| self.now.state.discrete()[there as usize] == 0.0) {
                continue;
            }
            let limit = first.map_or(1.0, |(at, _)| (at - piece[0]) / (piece[1] - piece[0]));
            let search = Search { contour: index, piece };
            if let Some(share) = self.advance_to_profile(instants, contour, &search, limit) {
                first = Some((between(piece, share), event + index));
            }
        }
        first
    }

    /// The share of a piece up to a limit at which a disc touches its profile anew.
    fn advance_to_profile(
        &mut self,
        instants: &mut Instants,
        contour: &Contour,
        search: &Search,
        limit: f64,
    ) -> Option<f64> {
        let near = SHORTEST_PROFILE_STEP * self.model.program().length;
        let way = instants.contours.way(search.contour);
        let (mut from, mut before) = (0.0, self.place_at(instants, search, 0.0));
        let mut distance = self.distance_from(contour, before);
        let mut last = (0.0, f64::INFINITY);
        while from < limit {
            if instants.evaluated.is_multiple_of(CHECKED_EVERY)
                && let Err(failure) = self.check_search(instants, [between(search.piece, from), search.piece[1]])
            {
                instants.known.overlooked = Some(failure);
                return None;
            }
            // What does not move, or is not a number, is looked at where the piece ends.
            let to = from + maximum(distance, near) / way;
            let to = if to < limit { to } else { limit };
            let now = self.place_at(instants, search, to);
            let next = self.distance_from(contour, now);
            if minimum(next, distance) < 2.0 * near {
                if let Some(found) =
                    self.touched_between(instants, (contour, search), [(from, before), (to, now)], near)
                {
                    return Some(found);
                }
                if distance <= last.1 && distance <= next {
                    let found = self.touched_about(instants, (contour, search), [last.0, from, to], (before, near));
                    if found.is_some() {
                        return found;
                    }
                }
            }
            if next < -near {
                self.fail_at_profile(instants, contour, search, to);
                return None;
            }
            last = (from, distance);
            (from, before, distance) = (to, now, next);
        }
        None
    }

    /// Where a feature is touched between two places near the profile, at the first of which it is not.
    fn touched_between(
        &mut self,
        instants: &mut Instants,
        (contour, search): (&Contour, &Search),
        [(from, before), (to, now)]: [(f64, Point); 2],
        near: f64,
    ) -> Option<f64> {
        let mut first: Option<f64> = None;
        for (index, feature) in contour.features.iter().enumerate() {
            if feature.distance(now, contour.radius) > 2.0 * near || !self.is_counted(contour, index) {
                continue;
            }
            let [gap_before, gap] = [before, now].map(|point| feature.gap(point));
            // What begins to be touched where the piece begins is so within errors of the method.
            let comes = gap_before >= 0.0 || from == 0.0 && gap_before > -near && gap < gap_before;
            if gap < 0.0 && comes && self.is_touched_anew(contour, index, now, near) {
                let found = self.turn_of(instants, feature, search, [from, to]);
                first = Some(first.map_or(found, |first| minimum(first, found)));
            }
            let behind = -2.0 * contour.radius;
            let is_behind = gap_before < behind.min(-0.0) && gap >= behind;
            if is_behind && self.is_touched_anew(contour, index, now, near) && first.is_none() {
                self.fail_at_profile(instants, contour, search, to);
            }
        }
        first
    }

    /// Where a feature is touched about a place at which the distance is least of three.
    fn touched_about(
        &mut self,
        instants: &mut Instants,
        (contour, search): (&Contour, &Search),
        [from, middle, to]: [f64; 3],
        (point, near): (Point, f64),
    ) -> Option<f64> {
        let counting = (0..contour.features.len()).filter(|&index| self.is_counted(contour, index));
        let distance = |index: &usize| contour.features[*index].distance(point, contour.radius);
        let nearest = counting.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let feature = &contour.features[nearest];
        let (top, value) = largest_between([from, to], SECTIONS, |share| {
            let point = self.place_at(instants, search, share);
            -feature.gap(point)
        });
        let is_touched = value > 0.0 && {
            let point = self.place_at(instants, search, top);
            feature.is_touched(point, 0.0) && self.is_touched_anew(contour, nearest, point, near)
        };
        is_touched.then(|| self.turn_of(instants, feature, search, [minimum(from, middle), top]))
    }

    /// The first share between two at which the gap of a feature is negative, which it is at the second.
    fn turn_of(&mut self, instants: &mut Instants, feature: &Feature, search: &Search, shares: [f64; 2]) -> f64 {
        let mut depth = |share: f64| -feature.gap(self.place_at(instants, search, share));
        let [before, after] = shares.map(|share| (share, depth(share)));
        onset::turn(&|depth| depth > 0.0, before, after, 0.0, &mut depth)
    }

    /// Where a disc is at a share of a piece of the last step.
    fn place_at(&mut self, instants: &mut Instants, search: &Search, share: f64) -> Point {
        instants.evaluated += 1;
        let settings = self.settings();
        let Snapshot { run, memory, .. } = &mut self.now;
        let at = (between(search.piece, share), &mut instants.within);
        // Where the motion is not known the step fails by itself.
        let known = self.stepper.interpolate(&self.model, &mut self.machine, (run, memory), at, &settings).is_ok();
        self.machine.load(&self.model, &instants.within);
        if let Some(data) = self.model.program().instants.contacts.as_ref().and_then(|data| data.contours.as_ref()) {
            self.machine.evaluate(&data.places, &mut instants.contours.places);
        }
        if known { instants.contours.place(search.contour) } else { [f64::NAN; 2] }
    }

    fn is_counted(&self, contour: &Contour, feature: usize) -> bool {
        let state = &self.now.state;
        let contacts = self.model.program().instants.contacts.as_ref();
        let closed = |slot: &Slot| contacts.is_some_and(|data| is_closed(data, state, slot.contact as usize));
        counts(contour, feature, closed, state)
    }

    /// True if a disc touches a feature there. What follows on the curve of a feature that is in a slot begins where that ends: a disc that has just left a corner is beneath the line before it.
    fn is_touched(&self, contour: &Contour, index: usize, point: Point, near: f64) -> bool {
        let follows =
            |slot: &Slot| feature_of(slot, &self.now.state).is_some_and(|held| contour.are_joined(held, index));
        let near = if contour.slots.iter().any(follows) { 0.0 } else { near };
        contour.features[index].is_touched(point, near)
    }

    /// The same of a feature that nothing watches: what follows on the curve of a feature in a slot gets that slot where the disc comes to it.
    fn is_touched_anew(&self, contour: &Contour, index: usize, point: Point, near: f64) -> bool {
        let watches = |slot: &Slot| {
            let held = feature_of(slot, &self.now.state).filter(|&held| contour.are_joined(held, index));
            held.is_some_and(|held| contour.features[held].gap(point).abs() <= near)
        };
        !contour.slots.iter().any(watches) && self.is_touched(contour, index, point, near)
    }

    fn distance_from(&self, contour: &Contour, point: Point) -> f64 {
        contour.distance(point, |feature| self.is_counted(contour, feature))
    }

    /// The run ends where a disc is on the wrong side of its profile.
    fn fail_at_profile(&self, instants: &mut Instants, contour: &Contour, search: &Search, share: f64) {
        let why = if contour.closed { INSIDE } else { FROM_BEHIND };
        let time = between(search.piece, share);
        instants.known.overlooked = Some(Failure::Contact { time, names: vec![contour.name.clone()], why });
    }

    /// At an instant: what touches a profile anew gets a slot, what has left a feature goes on with the next one, and an open slot that is beyond its feature has none.
    ///
    /// # Errors
    /// All slots are taken.
    pub(super) fn find_features(&mut self) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let instants = &model.program().instants;
        let Some((data, contours)) = instants.contacts.as_ref().and_then(|data| Some((data, data.contours.as_ref()?)))
        else {
            return Ok(());
        };
        let Some(mut run) = self.instants.take() else { return Ok(()) };
        self.machine.load(&model, &self.now.state);
        self.machine.evaluate(&contours.places, &mut run.contours.places);
        let first = instants.first_at_profiles();
        let mut number = first + contours.all.len();
        let (scale, events) = (model.program().length, instants.events.len());
        let mut done = Ok(());
        for (index, contour) in contours.all.iter().enumerate() {
            let point = run.contours.place(index);
            for slot in &contour.slots {
                let closed = is_closed(data, &self.now.state, slot.contact as usize);
                let contact = events + slot.contact as usize;
                let state = &mut self.now.state;
                if let Some(feature) = feature_of(slot, state) {
                    let feature = &contour.features[feature];
                    if run.due[number] {
                        go_on((data, contour), slot, feature, point, state);
                    } else if !closed && !feature.is_touched(point, SHORTEST_PROFILE_STEP * scale) {
                        // What is there of its line or circle is no part of the profile.
                        park(slot, state);
                        run.due[contact] = false;
                    }
                }
                number += 1;
            }
            if contour.there.is_none_or(|there| self.now.state.discrete()[there as usize] != 0.0) {
                let due = run.due[first + index];
                done = done.and_then(|()| self.fill_slots((contour, point), &mut run, due));
            }
        }
        self.instants = Some(run);
        done.map_err(InstanceError::Solver)
    }

    /// Gives slots to features that are touched: those within rounding errors, and the nearest one if one has been found.
    fn fill_slots(
        &mut self,
        (contour, point): (&Contour, Point),
        run: &mut Instants,
        found: bool,
    ) -> Result<(), Failure> {
        let program = self.model.clone();
        let program = program.program();
        let Some(data) = &program.instants.contacts else { return Ok(()) };
        let (scale, events) = (program.length, program.instants.events.len());
        let mut found = found;
        loop {
            let near = SHORTEST_PROFILE_STEP * scale;
            let state = &self.now.state;
            // Where two features are one curve, a disc touches one of them.
            let holds = |slot: &Slot, feature: usize| {
                let held = feature_of(slot, state).filter(|&held| contour.are_joined(held, feature));
                held.is_some_and(|held| contour.features[held].gap(point).abs() <= TOUCHING * scale)
            };
            let is_held = |feature: usize| contour.slots.iter().any(|slot| holds(slot, feature));
            let all = contour.features.iter().enumerate();
            let touched = all.filter(|(index, _)| {
                let is_new = found || !is_held(*index);
                is_new && self.is_touched(contour, *index, point, near) && self.is_counted(contour, *index)
            });
            let gap = |(_, feature): &(usize, &Feature)| feature.gap(point).abs();
            let Some((index, feature)) = touched.min_by(|a, b| gap(a).total_cmp(&gap(b))) else { return Ok(()) };
            if !found && gap(&(index, feature)) > TOUCHING * scale {
                return Ok(());
            }
            // The first without a feature, else one that is open, the farthest. One that has just opened is free for what follows on its curve.
            let farness = |slot: &Slot| match feature_of(slot, state) {
                None => f64::INFINITY,
                Some(_) if is_closed(data, state, slot.contact as usize) => f64::NEG_INFINITY,
                Some(_) if holds(slot, index) && !run.due[events + slot.contact as usize] => f64::MAX,
                Some(held) => contour.features[held].gap(point),
            };
            let farthest = contour.slots.iter().rev().max_by(|a, b| farness(a).total_cmp(&farness(b)));
            let Some(slot) = farthest.filter(|slot| farness(slot) > TOUCHING * scale) else {
                let (time, names) = (self.now.state.time(), vec![contour.name.clone()]);
                return Err(Failure::Contact { time, names, why: TOO_MANY });
            };
            let contact = events + slot.contact as usize;
            write(slot, index, feature, &mut self.now.state);
            run.due[contact] |= found;
            self.now.happened.armed[contact] = false;
            found = false;
        }
    }

    /// At the start: looks whether a disc is inside its profile.
    ///
    /// # Errors
    /// It is.
    pub(super) fn check_profiles(&mut self) -> Result<(), InstanceError> {
        let model = self.model.clone();
        let Some(data) = model.program().instants.contacts.as_ref().and_then(|data| data.contours.as_ref()) else {
            return Ok(());
        };
        let Some(run) = &mut self.instants else { return Ok(()) };
        self.machine.load(&model, &self.now.state);
        self.machine.evaluate(&data.places, &mut run.contours.places);
        for (index, contour) in data.all.iter().enumerate() {
            let by = contour.depth(run.contours.place(index));
            if by > TOUCHING * model.program().length {
                let (name, time) = (contour.name.clone(), self.now.state.time());
                return Err(Failure::Beyond { name, time, by, angular: false }.into());
            }
        }
        Ok(())
    }

    /// After an impact at a profile its impulses are those of this impact.
    pub(super) fn forget_impulses(&mut self) {
        let Some(run) = &self.instants else { return };
        let instants = &self.model.program().instants;
        for contour in instants.contours() {
            let hit = |slot: &Slot| run.contacts.hit[slot.contact as usize];
            if contour.slots.iter().any(hit) {
                for slot in contour.slots.iter().filter(|slot| !hit(slot)) {
                    let impulse = instants.contacts()[slot.contact as usize].state.impulse;
                    self.now.state.discrete_mut()[impulse as usize] = 0.0;
                }
            }
        }
    }
}

/// A slot goes on with what follows behind the end of its feature that a disc has come to: with another feature, unless another slot is closed there, or with none.
fn go_on((data, contour): (&Contacts, &Contour), slot: &Slot, feature: &Feature, point: Point, state: &mut State) {
    let end = usize::from(feature.foot(point) > 0.0);
    let next = match feature.ends[end].joint {
        Joint::Smooth(next) => Some(next as usize),
        Joint::Free => None,
        Joint::Concave => return,
    };
    let holds = |other: &&Slot, state: &State| next.is_some() && feature_of(other, state) == next;
    let other = contour.slots.iter().find(|other| holds(other, state));
    let is_taken = other.is_some_and(|other| is_closed(data, state, other.contact as usize));
    match next.filter(|_| !is_taken) {
        Some(next) => {
            other.into_iter().for_each(|other| park(other, state));
            write(slot, next, &contour.features[next], state);
        }
        None => {
            park(slot, state);
            state.discrete_mut()[data.all[slot.contact as usize].state.closed as usize] = 0.0;
        }
    }
}
