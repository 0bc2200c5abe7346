//! What holds from an event on: joints that engage and are released again, and rates that events set.
//!
//! Both are loop equations with a discrete variable that is 1 while they hold, chords in every tree. A rate is set by a loop equation that holds for its instant only, so that its impulse acts along
//! this rate and everything else takes part.

use super::{
    Aspect, BodyId, Comparison, ContactQuantity, Discrete, DiscreteId, DiscreteKind, Formula, KeyValue, Mechanism,
    Owner, Part, Place, Point, Quantity, Unit, Variable,
};
use crate::diagnostic::Span;
use crate::expr::Unary;

/// A joint that events engage or release.
#[derive(Clone, Debug, PartialEq)]
pub struct Engaging {
    pub owner: Owner,
    /// 1 while it is engaged, else 0.
    pub engaged: DiscreteId,
    /// Is it engaged at the start?
    pub begins: bool,
    /// Does it hold the pose in which it engages? Else its named one.
    pub here: bool,
    /// The impulses of its last engagement: one for each of its loop equations.
    pub impulses: Vec<(Quantity, DiscreteId)>,
    /// The energy that they took from the mechanism; none until the mechanism is complete.
    pub lost: Option<DiscreteId>,
    /// Those of its loop equations that others repeat.
    pub left_out: Vec<Quantity>,
}

/// A rate that events set.
#[derive(Clone, Debug, PartialEq)]
pub struct SetRate {
    pub variable: Variable,
    /// 1 at the instant, else 0.
    pub now: DiscreteId,
    /// What it becomes.
    pub value: DiscreteId,
    /// The impulse along it.
    pub impulse: DiscreteId,
    /// Where it is set.
    pub span: Span,
}

/// What of a joint is taken from where it engages.
#[derive(Clone, Copy, Debug)]
pub enum Captured {
    /// A key, and its value at which the joint is closed; none if it does not count.
    Key(&'static str, fn(&Part, &Mechanism) -> Option<Formula>),
    /// The first point: it is where the second is.
    Point,
    /// The same across the axis only.
    Normal,
}

/// The parts of a joint's motion that it may hold from where it stands: the discrete variable that is added, and what it becomes.
type Moved = Vec<(DiscreteId, Formula)>;

/// A rate that an event sets.
#[derive(Clone, Debug)]
pub(crate) struct RateChange {
    pub variable: Variable,
    pub value: Formula,
    pub span: Span,
}

impl Mechanism {
    /// The joint, if events engage it.
    pub fn engaging(&self, owner: Owner) -> Option<&Engaging> {
        self.engaging.iter().find(|engaging| engaging.owner == owner)
    }

    /// The points whose rates events set.
    pub(crate) fn places_of_set_rates(&self) -> impl Iterator<Item = Place> {
        self.set_rates.iter().filter_map(|set| match set.variable.owner {
            Owner::Place(place) => Some(place),
            Owner::Joint(_) | Owner::Driver(_) | Owner::Load(_) | Owner::System => None,
        })
    }

    /// True if events may change rates by themselves.
    pub fn has_impulses(&self) -> bool {
        !self.engaging.is_empty() || !self.set_rates.is_empty()
    }

    /// Lets joints engage where they stand, with what events write for that; and rates be set.
    pub(crate) fn add_engaging(&mut self, set: &[Vec<RateChange>]) {
        for index in 0..self.engaging.len() {
            let engaging = self.engaging[index].clone();
            let Owner::Joint(joint) = engaging.owner else { continue };
            let mut part = self.joints[joint.0].clone();
            let moved = if engaging.here { self.capture(&mut part) } else { Moved::new() };
            self.engaging[index].impulses = self.impulses_of(&part);
            let unit = Unit::of(&Quantity::LostEnergy.measure(), None);
            let lost = self.push_discrete(Quantity::LostEnergy.of(&part.name), unit, DiscreteKind::Impulse, part.span);
            self.engaging[index].lost = Some(lost);
            self.joints[joint.0] = part;
            for event in self.events.iter_mut().filter(|event| event.engages.contains(&engaging.owner)) {
                // Engaged already, it stays where it is.
                let held = Formula::Discrete(engaging.engaged);
                let write = |(id, value): (DiscreteId, Formula)| {
                    let parts = [held.clone(), Formula::Number(0.5), Formula::Discrete(id), value];
                    (id, Formula::If(Comparison::Greater, Box::new(parts)))
                };
                event.writes.extend(moved.iter().cloned().map(write));
                event.writes.push((engaging.engaged, Formula::Number(1.0)));
            }
        }
        for (event, rates) in set.iter().enumerate() {
            for RateChange { variable, value, span } in rates {
                let (now, target) = self.set_rate(*variable, *span);
                self.events[event].writes.extend([(target, value.clone()), (now, Formula::Number(1.0))]);
            }
        }
    }

    /// What a joint holds is counted from where it stands: discrete variables are added to its constants, zero at the start.
    fn capture(&mut self, part: &mut Part) -> Moved {
        let mut moved = Moved::new();
        for captured in part.component().captures {
            match captured {
                Captured::Key(key, at) => {
                    let Some(now) = at(part, self) else { continue };
                    let base = part.key(key);
                    let id = self.captured(part, key, Unit::default());
                    part.set(key, KeyValue::Formula(plus(base.clone(), Formula::Discrete(id))));
                    moved.push((id, now - base));
                }
                Captured::Point => {
                    let (base, now) = (self.local(part.between[0]), self.second_in_first(part));
                    let ids = ["x", "y"].map(|axis| self.captured(part, axis, Unit::length()));
                    let at = [0, 1].map(|axis| plus(base[axis].clone(), Formula::Discrete(ids[axis])));
                    part.between[0] = self.add_point(part, at);
                    let [x, y] = now;
                    let [base_x, base_y] = base;
                    moved.extend([(ids[0], x - base_x), (ids[1], y - base_y)]);
                }
                Captured::Normal => {
                    let (base, [x, y]) = (self.local(part.between[0]), self.second_in_first(part));
                    let [ux, uy] = part.vector("axis");
                    let normal = [-uy, ux];
                    let id = self.captured(part, "offset", Unit::length());
                    let offset = Formula::Discrete(id);
                    let at = [0, 1].map(|axis| plus(base[axis].clone(), normal[axis].clone() * offset.clone()));
                    part.between[0] = self.add_point(part, at);
                    let [nx, ny] = normal;
                    let [base_x, base_y] = base;
                    moved.push((id, nx * (x - base_x) + ny * (y - base_y)));
                }
            }
        }
        moved
    }

    /// The impulses of a joint, one for each of its loop equations.
    fn impulses_of(&mut self, part: &Part) -> Vec<(Quantity, DiscreteId)> {
        let all: Vec<Quantity> = part.component().engaging.to_vec();
        let all = all.into_iter().filter(|quantity| {
            matches!(quantity.aspect(), Aspect::Contact(ContactQuantity::Impulse)) && self.has(*quantity)
        });
        // A lock holds an angle or a displacement.
        let slides = part.joint().is_some_and(|joint| !self.joints[joint.0].is_angular());
        let holds_one =
            [Quantity::Impulse, Quantity::AngularImpulse].map(|either| part.component().engaging.contains(&either));
        let other = if slides { Quantity::AngularImpulse } else { Quantity::Impulse };
        let names: Vec<Quantity> = all.filter(|quantity| holds_one != [true, true] || *quantity != other).collect();
        let hold = |quantity: Quantity| {
            let unit = Unit::of(&quantity.measure(), None);
            (quantity, self.push_discrete(quantity.of(&part.name), unit, DiscreteKind::Impulse, part.span))
        };
        names.into_iter().map(hold).collect()
    }

    /// The loop equation that sets a rate.
    fn set_rate(&mut self, variable: Variable, span: Span) -> (DiscreteId, DiscreteId) {
        if let Some(known) = self.set_rates.iter().find(|known| known.variable == variable) {
            return (known.now, known.value);
        }
        let name = self.variable_name(variable);
        let unit = Unit::of(&variable.quantity.measure(), None);
        let mut add = |word: &str, unit: Unit, kind| self.push_discrete(format!("{name}.{word}"), unit, kind, span);
        let now = add("set", Unit::default(), DiscreteKind::Setting);
        let value = add("value", unit, DiscreteKind::Setting);
        let impulse = add("impulse", Unit::default(), DiscreteKind::Impulse);
        self.set_rates.push(SetRate { variable, now, value, impulse, span });
        (now, value)
    }

    fn captured(&mut self, part: &Part, word: &str, unit: Unit) -> DiscreteId {
        self.push_discrete(format!("{}.held_{word}", part.name), unit, DiscreteKind::Captured(part.owner), part.span)
    }

    fn push_discrete(&mut self, name: String, unit: Unit, kind: DiscreteKind, span: Span) -> DiscreteId {
        let (description, begin) = (String::new(), Formula::Number(0.0));
        self.discrete.push(Discrete { name, description, unit, kind, begin, span });
        DiscreteId(self.discrete.len() - 1)
    }

    /// A point of the body that has a joint's first point.
    fn add_point(&mut self, part: &Part, at: [Formula; 2]) -> Place {
        let point = Point { name: format!("{}.held", part.name), at, span: part.span };
        match part.between[0].body() {
            Some(body) => {
                let points = &mut self.bodies[body.0].points;
                points.push(point);
                Place::Point(body, points.len() - 1)
            }
            None => {
                self.ground.push(point);
                Place::Ground(self.ground.len() - 1)
            }
        }
    }

    /// A place in the frame of its body, or of the ground.
    fn local(&self, place: Place) -> [Formula; 2] {
        match place {
            Place::Origin | Place::Centre(_) => [Formula::Number(0.0), Formula::Number(0.0)],
            Place::Ground(point) => self.ground[point].at.clone(),
            Place::Point(body, point) => self.bodies[body.0].points[point].at.clone(),
        }
    }

    /// Where the second point of a joint is, in the frame of the first body.
    fn second_in_first(&self, part: &Part) -> [Formula; 2] {
        self.in_frame(part.between[0].body(), part.between[1])
    }

    /// The displacement that a rack or screw keeps: of the second point along the axis of the carrier, less the way by radian of the first body times its angle against the carrier.
    pub(crate) fn slid_apart(&self, part: &Part, by_radian: Formula) -> Formula {
        let carrier = part.place("carrier");
        let ([x, y], [from_x, from_y]) = (self.in_frame(carrier.body(), part.between[1]), self.local(carrier));
        let [ux, uy] = part.vector("axis");
        let turned = angle_of(part.between[0].body()) - angle_of(carrier.body());
        ux * (x - from_x) + uy * (y - from_y) - by_radian * turned
    }

    /// Where a place is in the frame of a body, or of the ground.
    fn in_frame(&self, body: Option<BodyId>, place: Place) -> [Formula; 2] {
        let [x, y] = self.in_world(place);
        let Some(body) = body else { return [x, y] };
        let [from_x, from_y] = self.in_world(Place::Centre(body));
        let (dx, dy, angle) = (x - from_x, y - from_y, angle_of(Some(body)));
        let (sine, cosine) = (angle.clone().of(Unary::Sin), angle.of(Unary::Cos));
        [cosine.clone() * dx.clone() + sine.clone() * dy.clone(), cosine * dy - sine * dx]
    }

    fn in_world(&self, place: Place) -> [Formula; 2] {
        match place.body() {
            None => self.local(place),
            Some(_) => [Quantity::X, Quantity::Y]
                .map(|quantity| Formula::Variable(Variable { owner: Owner::Place(place), quantity })),
        }
    }

    /// The distance of a joint's points.
    pub(crate) fn distance(&self, part: &Part) -> Formula {
        let [[x, y], [from_x, from_y]] = [part.between[1], part.between[0]].map(|place| self.in_world(place));
        let squares = [x - from_x, y - from_y].map(|along| along.clone() * along);
        let [first, second] = squares;
        (first + second).of(Unary::Sqrt)
    }
}

/// The angle of a body; zero for the ground.
fn angle_of(body: Option<BodyId>) -> Formula {
    let variable = |body| Variable { owner: Owner::Place(Place::Centre(body)), quantity: Quantity::Angle };
    body.map_or(Formula::Number(0.0), |body| Formula::Variable(variable(body)))
}

/// The angle of a joint's second body against its first.
pub(crate) fn relative_angle(part: &Part, _: &Mechanism) -> Option<Formula> {
    let [first, second] = part.bodies().map(angle_of);
    Some(second - first)
}

/// The angle that a gear pair or belt keeps: that of the second wheel less ratio times that of the first, both against the carrier.
pub(crate) fn turned_apart(part: &Part, ratio: Formula) -> Formula {
    let [first, second, carrier] =
        [part.between[0].body(), part.between[1].body(), part.place("carrier").body()].map(angle_of);
    second - carrier.clone() - ratio * (first - carrier)
}

/// A sum without a zero in front.
fn plus(base: Formula, added: Formula) -> Formula {
    if base == Formula::Number(0.0) { added } else { base + added }
}
