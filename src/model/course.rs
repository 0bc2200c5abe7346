//! The course of a rope or band: from its first end over pulleys to its last.
//!
//! Between neighbours it is straight, on a tangent of both circles; on a pulley it is an arc. An end is a point, or a drum that winds it up.

use super::{Discrete, DiscreteId, DiscreteKind, Formula, Mechanism, Owner, Part, Place, Unit};
use crate::diagnostic::Span;
use crate::model::measure::{ANGLE, LENGTH};

/// A circle that a rope or band touches.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulley {
    /// Its centre.
    pub on: Place,
    /// Its radius \[m\]; the number zero is an eye.
    pub radius: Formula,
    /// True if the centre is on the left of the rope, seen from the first end to the last: it is wound counterclockwise.
    pub is_left: bool,
    /// Whole turns beyond the wrap from zero to one turn.
    pub turns: u32,
    /// Coefficient of friction against the body that it belongs to; without it the rope slides freely, or the pulley turns with it and has no inertia.
    pub mu: Option<Formula>,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a rope or band runs over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// The drums on which it ends.
    pub drums: [Option<Pulley>; 2],
    /// The pulleys in their order.
    pub over: Vec<Pulley>,
}

/// A discrete variable of a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CourseValue {
    /// The direction from which that of a straight part counts, so that its angle is continuous over many turns \[rad\].
    Turn(usize),
    /// What is wound up on drums at the start \[m\]: the length does not count it.
    Wound,
    /// The length at the start \[m\].
    Length,
}

/// A point or circle of a course.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    pub at: Place,
    /// With its sign: positive on the left of the rope. Zero is a point.
    pub radius: Formula,
    /// True if the centre is on the left of the rope.
    pub is_left: bool,
    /// Whole turns beyond the wrap from zero to one turn.
    pub turns: u32,
    /// True for a drum: the rope ends on it.
    pub is_drum: bool,
}

impl Station {
    /// True for a point.
    pub fn is_eye(&self) -> bool {
        self.radius == Formula::Number(0.0)
    }
}

impl Pulley {
    /// Its radius with the sign of its side.
    fn signed_radius(&self) -> Formula {
        match &self.radius {
            Formula::Number(radius) if self.is_left => Formula::Number(*radius),
            Formula::Number(radius) => Formula::Number(0.0 - radius),
            radius if self.is_left => radius.clone(),
            radius => -radius.clone(),
        }
    }

    fn station(&self, is_drum: bool) -> Station {
        Station { at: self.on, radius: self.signed_radius(), is_left: self.is_left, turns: self.turns, is_drum }
    }
}

impl Course {
    /// Every pulley and drum.
    pub fn pulleys(&self) -> impl Iterator<Item = &Pulley> {
        self.drums.iter().flatten().chain(&self.over)
    }

    pub fn pulleys_mut(&mut self) -> impl Iterator<Item = &mut Pulley> {
        self.drums.iter_mut().flatten().chain(&mut self.over)
    }
}

impl Part {
    /// The points and circles along the rope or band, its ends among them; none if it is straight from point to point.
    pub fn stations(&self) -> Option<Vec<Station>> {
        let course = self.course()?;
        let end = |side: usize| match &course.drums[side] {
            Some(drum) => drum.station(true),
            None => {
                let radius = Formula::Number(0.0);
                Station { at: self.between[side], radius, is_left: true, turns: 0, is_drum: false }
            }
        };
        let over = course.over.iter().map(|pulley| pulley.station(false));
        Some(std::iter::once(end(0)).chain(over).chain([end(1)]).collect())
    }
}

impl Mechanism {
    /// Adds the discrete variables of all courses, before those of contacts.
    pub(crate) fn add_courses(&mut self) {
        let of = |part: &Part| {
            let course = part.course()?;
            let turns = (0..=course.over.len()).map(CourseValue::Turn);
            let wound = course.drums.iter().any(Option::is_some).then_some(CourseValue::Wound);
            let taut = part.holds_length_of_start().then_some(CourseValue::Length);
            Some((part.owner, part.name.clone(), turns.chain(wound).chain(taut).collect::<Vec<_>>(), part.span))
        };
        let all: Vec<_> = self.parts().filter_map(of).collect();
        for (owner, part, values, span) in all {
            for value in values {
                let (name, measure) = match value {
                    CourseValue::Turn(number) => (format!("{part}.turn_{}", number + 1), ANGLE),
                    CourseValue::Wound => (format!("{part}.wound"), LENGTH),
                    CourseValue::Length => (format!("{part}.length_at_start"), LENGTH),
                };
                let (unit, kind) = (Unit::of(&measure, None), DiscreteKind::Course(owner, value));
                let (description, begin) = (String::new(), Formula::Number(0.0));
                self.discrete.push(Discrete { name, description, unit, kind, begin, span });
            }
        }
    }

    /// A discrete variable of a course.
    pub fn course_value(&self, owner: Owner, value: CourseValue) -> Option<DiscreteId> {
        let kind = DiscreteKind::Course(owner, value);
        self.discrete_variables().find(|(_, discrete)| discrete.kind == kind).map(|(id, _)| id)
    }

    /// The straight parts of all courses whose directions are followed, with the variable of each.
    pub fn turns(&self) -> impl Iterator<Item = (DiscreteId, Owner, usize)> {
        self.discrete_variables().filter_map(|(id, discrete)| match discrete.kind {
            DiscreteKind::Course(owner, CourseValue::Turn(number)) => Some((id, owner, number)),
            DiscreteKind::Course(..)
            | DiscreteKind::Captured(_)
            | DiscreteKind::Impulse
            | DiscreteKind::Setting
            | DiscreteKind::Sampled
            | DiscreteKind::Time
            | DiscreteKind::Presence(_)
            | DiscreteKind::Contact => None,
        })
    }

    /// The pulleys that ropes and bands lie on, each by its number on its part: all that are no eyes.
    pub fn lying(&self) -> impl Iterator<Item = (&Part, usize)> {
        let of = |part: &'_ Part| {
            let over = part.course().map_or(&[][..], |course| &course.over);
            let lying = over.iter().enumerate().filter(|(_, pulley)| pulley.radius != Formula::Number(0.0));
            lying.map(|(number, _)| number).collect::<Vec<usize>>()
        };
        self.parts().flat_map(move |part| of(part).into_iter().map(move |number| (part, number)))
    }

    /// The parts that run over pulleys or onto drums.
    pub fn parts_over_pulleys(&self) -> impl Iterator<Item = &Part> {
        self.parts().filter(|part| part.course().is_some())
    }

    /// The part that owns variables.
    pub fn part_of(&self, owner: Owner) -> Option<&Part> {
        match owner {
            Owner::Joint(joint) => self.joints.get(joint.0),
            Owner::Driver(driver) => self.drivers.get(driver.0),
            Owner::Load(load) => self.loads.get(load.0),
            Owner::Place(_) | Owner::System => None,
        }
    }
}
