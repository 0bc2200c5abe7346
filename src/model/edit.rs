//! Changed copies of a mechanism: what studies move, hold or leave out is asked of a copy, and the scene stays as it is written.

use super::{
    BodyId, Class, CoordinateChoice, Dimension, DriverId, Formula, Initial, Input, InputId, JointId, KeyValue, LoadId,
    Mechanism, Output, Owner, Parameter, ParameterId, Part, Place, Quantity, Unit, Variable,
};
use crate::diagnostic::Span;

impl Mechanism {
    /// With one more driver.
    #[must_use]
    pub fn driven(&self, driver: Part) -> Mechanism {
        let mut changed = self.clone();
        let owner = Owner::Driver(DriverId(changed.drivers.len()));
        changed.drivers.push(Part { owner, ..driver });
        changed
    }

    /// With one more load.
    #[must_use]
    pub fn loaded(&self, load: Part) -> Mechanism {
        let mut changed = self.clone();
        let owner = Owner::Load(LoadId(changed.loads.len()));
        changed.loads.push(Part { owner, ..load });
        changed
    }

    /// Without dry friction that sticks.
    #[must_use]
    pub fn without_slips(&self) -> Mechanism {
        let mut changed = self.clone();
        changed.contacts.retain(|contact| contact.slip.is_none());
        changed
    }

    /// Without what stops on one side only. Limits, contacts and ropes hold nothing then, so that contacts have nothing to rub with; relations with play, and followers that may lift off, hold always.
    #[must_use]
    pub fn without_stops(&self) -> Mechanism {
        let mut changed = self.clone();
        changed.contacts.retain(|contact| contact.slip.as_ref().is_some_and(|slip| slip.on.is_none()));
        for joint in &mut changed.joints {
            joint.values.retain(|(_, value)| !matches!(value, KeyValue::Limits(_)));
        }
        changed
    }

    /// Where nothing happens: discrete variables stay at the numbers that they begin with.
    #[must_use]
    pub fn without_instants(&self) -> Mechanism {
        let mut changed = self.clone();
        (changed.samplers, changed.events) = (Vec::new(), Vec::new());
        changed.discrete.iter_mut().for_each(|discrete| discrete.begin = Formula::Number(discrete.start()));
        changed
    }

    /// With one more parameter, in SI, and where it is among the parameters.
    #[must_use]
    pub fn with_parameter(&self, name: &str, unit: Unit, value: f64) -> (Mechanism, ParameterId) {
        let mut changed = self.clone();
        changed.parameters.push(Parameter {
            name: name.to_owned(),
            description: String::new(),
            unit,
            value,
            min: None,
            max: None,
            tunable: false,
            span: Span::default(),
        });
        (changed, ParameterId(self.parameters.len()))
    }

    /// With one more input, in SI, and where it is among the inputs.
    #[must_use]
    pub fn with_input(&self, name: &str, unit: Unit, start: f64) -> (Mechanism, InputId) {
        let mut changed = self.without_instants();
        let (name, description) = (name.to_owned(), String::new());
        changed.inputs.push(Input { name, description, unit, start, min: None, max: None, span: Span::default() });
        (changed, InputId(self.inputs.len()))
    }

    /// Without the drivers of which this is true; and these outputs of it, without those that need such a driver.
    #[must_use]
    pub fn without_drivers(&self, outputs: &[Output], is_gone: impl Fn(&Part) -> bool) -> (Mechanism, Vec<Output>) {
        let mut changed = self.without_instants();
        let mut places: Vec<Option<DriverId>> = Vec::with_capacity(self.drivers.len());
        let mut count = 0;
        for driver in &self.drivers {
            let stays = !is_gone(driver);
            places.push(stays.then_some(DriverId(count)));
            count += usize::from(stays);
        }
        let place = |driver: DriverId| places.get(driver.0).copied().flatten();
        changed.drivers.retain(|driver| !is_gone(driver));
        for (index, driver) in changed.drivers.iter_mut().enumerate() {
            driver.owner = Owner::Driver(DriverId(index));
        }
        let mut left = outputs.to_vec();
        left.retain_mut(|output| renumber(&mut output.value, &place));
        (changed, left)
    }

    /// Without a joint and what drives it, as far as positions need it.
    #[must_use]
    pub fn without_joint(&self, joint: JointId) -> Mechanism {
        let renumber = |id: &mut JointId| id.0 -= usize::from(id.0 > joint.0);
        let renumbered = |part: &Part| {
            let mut part = part.clone();
            for (_, value) in &mut part.values {
                if let KeyValue::Joint(id) = value {
                    renumber(id);
                }
            }
            if let Owner::Joint(id) = &mut part.owner {
                renumber(id);
            }
            part
        };
        let mut rest = self.clone();
        rest.joints.remove(joint.0);
        rest.joints = rest.joints.iter().map(renumbered).collect();
        rest.drivers = rest.drivers.iter().filter(|driver| driver.joint() != Some(joint)).map(renumbered).collect();
        rest.initial.retain(|initial| initial.variable.owner != Owner::Joint(joint));
        for initial in &mut rest.initial {
            if let Owner::Joint(id) = &mut initial.variable.owner {
                renumber(id);
            }
        }
        rest.kinematic()
    }

    /// What positions need: no loads, no states, the recommended trees.
    #[must_use]
    pub fn kinematic(&self) -> Mechanism {
        let mut rest = self.without_instants();
        rest.initial.retain(|initial| matches!(initial.variable.owner, Owner::Place(_) | Owner::Joint(_)));
        (rest.loads, rest.coordinates) = (Vec::new(), CoordinateChoice::Recommended);
        rest.states.clear();
        rest
    }

    /// With what `[initial]` says of positions as guesses, and no rates.
    #[must_use]
    pub fn guessed(&self) -> Mechanism {
        let mut changed = self.clone();
        changed.initial.retain(|initial| initial.variable.quantity.class() == Class::Position);
        changed.initial.iter_mut().for_each(|initial| initial.known = false);
        changed
    }

    /// With this pose of the bodies as guesses, and nothing else said of the start.
    #[must_use]
    pub fn posed(&self, pose: impl Fn(Variable) -> Option<f64>) -> Mechanism {
        let guess = |variable: Variable| {
            let value = Formula::Number(pose(variable)?);
            Some(Initial { variable, value, display: None, known: false, span: Span::default() })
        };
        Mechanism { initial: self.pose().into_iter().filter_map(guess).collect(), ..self.clone() }
    }

    /// With this mass \[kg\] and moment of inertia [kg.m2] where a body has none.
    #[must_use]
    pub fn with_mass(&self, value: f64) -> Mechanism {
        let mut changed = self.clone();
        for body in &mut changed.bodies {
            body.mass.get_or_insert(Formula::Number(value));
            body.inertia.get_or_insert(Formula::Number(value));
        }
        changed
    }

    /// A variable as an output.
    pub fn output(&self, variable: Variable) -> Output {
        Output {
            name: self.variable_name(variable),
            description: String::new(),
            unit: Unit::of(&variable.quantity.measure(), None),
            is_open: false,
            value: Formula::Variable(variable),
            span: Span::default(),
        }
    }

    /// The variables that say where the bodies are.
    pub fn pose(&self) -> Vec<Variable> {
        let quantities = [Quantity::X, Quantity::Y, Quantity::Angle].into_iter().filter(|&quantity| self.has(quantity));
        let of = |body: usize| {
            let owner = Owner::Place(Place::Centre(BodyId(body)));
            quantities.clone().map(move |quantity| Variable { owner, quantity })
        };
        (0..self.bodies.len()).flat_map(of).collect()
    }

    /// Is there such a thing in its dimension?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.dimension == Dimension::Two || quantity.is_on_a_line()
    }
}

/// Gives the drivers in a formula their new numbers; false if one of them has none.
fn renumber(formula: &mut Formula, place: &impl Fn(DriverId) -> Option<DriverId>) -> bool {
    if let Formula::Variable(Variable { owner: Owner::Driver(driver), .. }) = formula {
        let Some(new) = place(*driver) else { return false };
        *driver = new;
    }
    formula.parts_mut().iter_mut().all(|part| renumber(part, place))
}
