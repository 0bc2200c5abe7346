//! Joints, drivers and loads: parts of a mechanism, each of a kind that its component knows.

use super::{BodyId, Contour, Course, Formula, Friction, InputId, JointId, Limits, Owner, ParameterId, Place};
use crate::diagnostic::Span;

/// A joint, driver or load with everything that its keys say.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The user's name.
    pub name: String,
    /// Which of the components it is, by its place among all of them: what makes a part has its component.
    pub(crate) kind: usize,
    /// Which joint, driver or load it is.
    pub owner: Owner,
    /// The points joined; the mass centre stands for a whole body, the origin for the ground.
    pub between: [Place; 2],
    /// What its keys say, without `between`.
    pub values: Vec<(&'static str, KeyValue)>,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a key says.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyValue {
    /// A number, SI.
    Formula(Formula),
    /// Two components, SI; the second is the number 0 in one dimension. A direction has length one.
    Vector([Formula; 2]),
    Place(Place),
    Joint(JointId),
    Motion(Motion),
    Friction(Friction),
    Limits(Limits),
    /// One of several words.
    Choice(&'static str),
    Switch(bool),
    /// What it runs over.
    Course(Course),
    /// The profile that it touches.
    Contour(Contour),
}

/// A scalar motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A function of time, parameters and inputs.
    Given(Formula),
    /// An input is the rate: integrated.
    Velocity(InputId),
    /// An input is the acceleration: integrated twice.
    Acceleration(InputId),
}

impl KeyValue {
    /// The formulas in it.
    pub fn formulas(&self) -> Vec<&Formula> {
        match self {
            Self::Formula(formula) | Self::Motion(Motion::Given(formula)) => vec![formula],
            Self::Vector(both) => both.iter().collect(),
            Self::Friction(friction) => friction.formulas().collect(),
            Self::Limits(limits) => limits.formulas().collect(),
            Self::Course(course) => {
                course.pulleys().flat_map(|pulley| [Some(&pulley.radius), pulley.mu.as_ref()]).flatten().collect()
            }
            Self::Motion(Motion::Velocity(_) | Motion::Acceleration(_))
            | Self::Place(_)
            | Self::Joint(_)
            | Self::Choice(_)
            | Self::Contour(_)
            | Self::Switch(_) => Vec::new(),
        }
    }
}

static ZERO: Formula = Formula::Number(0.0);

impl Part {
    /// What a key says.
    pub fn value(&self, key: &str) -> Option<&KeyValue> {
        self.values.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }

    /// Makes a key say this.
    pub fn set(&mut self, key: &'static str, value: KeyValue) {
        match self.values.iter_mut().find(|(name, _)| *name == key) {
            Some((_, old)) => *old = value,
            None => self.values.push((key, value)),
        }
    }

    /// The number of a key; zero if it is absent.
    pub fn formula(&self, key: &str) -> &Formula {
        if let Some(KeyValue::Formula(formula)) = self.value(key) { formula } else { &ZERO }
    }

    /// The components of a key; zeros if it is absent.
    pub fn vector(&self, key: &str) -> [Formula; 2] {
        if let Some(KeyValue::Vector(vector)) = self.value(key) { vector.clone() } else { [ZERO.clone(), ZERO.clone()] }
    }

    /// The point that a key names; the ground's origin if it is absent.
    pub fn place(&self, key: &str) -> Place {
        if let Some(KeyValue::Place(place)) = self.value(key) { *place } else { Place::Origin }
    }

    pub fn joint(&self) -> Option<JointId> {
        self.values.iter().find_map(|(_, value)| if let KeyValue::Joint(joint) = value { Some(*joint) } else { None })
    }

    pub fn motion(&self) -> Option<&Motion> {
        self.values.iter().find_map(|(_, value)| if let KeyValue::Motion(motion) = value { Some(motion) } else { None })
    }

    pub fn friction(&self) -> Option<&Friction> {
        self.values.iter().find_map(|(_, value)| match value {
            KeyValue::Friction(friction) => Some(friction),
            _ => None,
        })
    }

    /// Where its motion ends, if it does.
    pub fn limits(&self) -> Option<&Limits> {
        self.values.iter().find_map(|(_, value)| if let KeyValue::Limits(limits) = value { Some(limits) } else { None })
    }

    pub fn choice(&self, key: &str) -> Option<&'static str> {
        if let Some(KeyValue::Choice(word)) = self.value(key) { Some(word) } else { None }
    }

    /// What it runs over, if it does not run straight.
    pub fn course(&self) -> Option<&Course> {
        self.values.iter().find_map(|(_, value)| if let KeyValue::Course(course) = value { Some(course) } else { None })
    }

    /// True if it may not become longer than it is at the start: a rope without a length.
    pub fn holds_length_of_start(&self) -> bool {
        matches!(self.owner, Owner::Joint(_)) && self.course().is_some() && self.value("length").is_none()
    }

    /// Calls `visit` with every parameter that its keys use.
    pub fn visit_parameters(&self, visit: &mut dyn FnMut(ParameterId)) {
        for (_, value) in &self.values {
            value.formulas().into_iter().for_each(|formula| formula.visit_parameters(visit));
        }
    }

    /// The bodies joined; `None` is the ground.
    pub fn bodies(&self) -> [Option<BodyId>; 2] {
        self.between.map(Place::body)
    }

    /// The points that it uses.
    pub fn places(&self) -> impl Iterator<Item = Place> {
        let others = self.values.iter().flat_map(|(_, value)| match value {
            KeyValue::Place(place) => vec![*place],
            KeyValue::Course(course) => course.pulleys().map(|pulley| pulley.on).collect(),
            _ => Vec::new(),
        });
        self.between.into_iter().chain(others)
    }
}
