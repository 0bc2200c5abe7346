//! What is held on one side only or sticks, in a pose: stops at the ends of motions, and where to look for modes.

use cotree::component::Icon;
use cotree::expr::{Symbol, Values};
use cotree::model::{BodyId, Contact, Mechanism, ParameterId, Part, Place, Quantity, Variable};

use super::PoseValues;
use crate::alike::Alike;
use crate::drawing::{BodySpot, CouplingKind, Drawing, HeldPart, Stop, StopMotion};

impl PoseValues<'_> {
    /// The stops and marks of everything that has modes.
    pub(super) fn held(&mut self, drawing: &mut Drawing) {
        let mechanism = &*self.equations.system.mechanism.clone();
        for (index, contact) in mechanism.contacts.iter().enumerate() {
            let Some(part) = mechanism.parts().find(|part| part.owner == contact.owner) else { continue };
            let icon = (part.component().icon)(part);
            drawing.stops.extend(self.stop(part, &icon, (index, contact)));
            let spot = self.spot(part, &icon, drawing);
            let is_first = mechanism.gaps_of(contact.owner).next().is_some_and(|(first, _)| first == index);
            let named = |quantity: Quantity| mechanism.variable_name(Variable { owner: contact.owner, quantity });
            let impulses = [Quantity::Impulse, Quantity::AngularImpulse];
            let impulse =
                impulses.into_iter().find(|impulse| part.component().variables.contains(impulse)).filter(|_| is_first);
            drawing.held.push(HeldPart {
                name: contact.name.clone(),
                spot,
                sticks: contact.slip.is_some(),
                now: self.state.value(Symbol::Discrete(contact.state.closed.0)) == 1.0,
                while_held: while_held(mechanism, contact, &named),
                impulse: impulse.map(named),
            });
        }
    }

    /// Where a limit ends the motion of a joint that slides or turns.
    fn stop(&mut self, part: &Part, icon: &Icon, (index, contact): (usize, &Contact)) -> Option<Stop> {
        if contact.slip.is_some() || part.limits().is_none() {
            return None;
        }
        let row = self.equations.row_of_contact(index)?;
        let gap = self.equations.constraints[row].contact()?.value;
        let gap = self.values(&[gap])[0];
        let moving = usize::from(part.between[1].body().is_some());
        // In which sense the moving body goes towards the stop.
        let sense = -contact.gap.sign * if moving == 1 { 1.0 } else { -1.0 };
        let on = part.between[1 - moving].body().map(|body| body.0);
        let at = self.at(part.between[moving]);
        let (at, towards, course) = match icon {
            Icon::Slider(axis) | Icon::Slot(axis) => {
                let axis = self.direction(axis, part.between[0].body());
                let size = axis[0].length_with(axis[1]);
                let towards = axis.map(|component| sense * component / size);
                let course = if matches!(icon, Icon::Slider(_)) { StopMotion::Slides } else { StopMotion::InSlot };
                ([at[0] + gap * towards[0], at[1] + gap * towards[1]], towards, course)
            }
            Icon::Pin => {
                let body = part.between[moving].body()?;
                let [x, y] = self.bar(body.0, at);
                let (sine, cosine) = (sense * gap).sine_and_cosine();
                let bar = [cosine * x - sine * y, sine * x + cosine * y];
                (at, [-sense * bar[1], sense * bar[0]], StopMotion::Turns(bar))
            }
            _ => return None,
        };
        Some(Stop { joint: part.name.clone(), on, at, towards, course, needs: self.needs(part) })
    }

    /// The parameters of a joint and of its places.
    fn needs(&self, part: &Part) -> Vec<String> {
        let mechanism = &self.equations.system.mechanism;
        let mut found = std::collections::BTreeSet::new();
        let mut visit = |id: ParameterId| {
            found.insert(mechanism.parameters[id.0].name.clone());
        };
        part.visit_parameters(&mut visit);
        for place in part.between {
            let at = match place {
                Place::Ground(index) => &mechanism.ground[index].at,
                Place::Point(body, index) => &mechanism.bodies[body.0].points[index].at,
                Place::Origin | Place::Centre(_) => continue,
            };
            at.iter().for_each(|component| component.visit_parameters(&mut visit));
        }
        found.into_iter().collect()
    }

    /// The direction in which a body extends from its pin.
    fn bar(&mut self, body: usize, pin: [f64; 2]) -> [f64; 2] {
        let body = self.body(BodyId(body));
        let from = |at: &[f64; 2]| [at[0] - pin[0], at[1] - pin[1]];
        let size = |way: &[f64; 2]| way[0].length_with(way[1]);
        let ways = body.points.iter().chain([&body.centre]).map(from);
        let farthest = ways.max_by(|a, b| size(a).total_cmp(&size(b))).filter(|way| size(way) > 0.0);
        farthest.map_or([1.0, 0.0], |way| way.map(|component| component / size(&way)))
    }

    /// Where modes are seen: where something touches, slides or turns.
    fn spot(&mut self, part: &Part, icon: &Icon, drawing: &Drawing) -> BodySpot {
        let index = |place: Place| place.body().map(|body| body.0);
        let coupling =
            drawing.couplings.iter().find(|coupling| coupling.name == part.name).map(|coupling| &coupling.kind);
        match (icon, coupling) {
            (Icon::Gears { carrier, .. }, Some(CouplingKind::Gears(wheels))) => {
                // The pitch point is on the larger wheel, towards the other.
                let [large, small] = if wheels[0].radius > wheels[1].radius { [0, 1] } else { [1, 0] };
                let [from, to] = [wheels[large].centre, wheels[small].centre];
                let way = [to[0] - from[0], to[1] - from[1]];
                let share = wheels[large].radius / way[0].length_with(way[1]);
                let off = way.map(|component| share * component);
                BodySpot { on: wheels[large].body, at: from, off: Some((carrier.map(|body| body.0), off)) }
            }
            (Icon::Rolling { .. }, Some(CouplingKind::Rolling { disc, line, axis, .. })) => {
                let size = axis[0].length_with(axis[1]);
                let off = [axis[1], -axis[0]].map(|component| disc.radius * component / size);
                BodySpot { on: disc.body, at: disc.centre, off: Some((*line, off)) }
            }
            (Icon::Round(_), _) => {
                let place = self.turning_point(part.bodies());
                BodySpot { on: index(place), at: self.at(place), off: None }
            }
            _ => {
                let place = part.between[usize::from(part.between[1].body().is_some())];
                BodySpot { on: index(place), at: self.at(place), off: None }
            }
        }
    }
}

/// The variables that say that it holds, each with its value then.
fn while_held(mechanism: &Mechanism, contact: &Contact, named: &dyn Fn(Quantity) -> String) -> Vec<(String, f64)> {
    let Some(slip) = &contact.slip else {
        if contact.state.feature.is_some() {
            // Its mode is in how many places it touches its profile; one mark of as many shows.
            let number = mechanism.gaps_of(contact.owner).take_while(|(_, other)| other.name != contact.name).count();
            return vec![(named(Quantity::Mode), number as f64 + 1.0)];
        }
        let value = if contact.gap.word.is_empty() { 1.0 } else { -contact.gap.sign };
        return vec![(named(Quantity::Mode), value)];
    };
    let presses = slip.on.map(|on| &mechanism.contacts[on]).map(|_| (named(Quantity::Mode), 1.0));
    [(named(Quantity::Sliding), 0.0)].into_iter().chain(presses).collect()
}
