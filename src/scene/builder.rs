//! Builds scenes in Rust, with the words of the scene file.

use super::model::{
    Coordinates, Event, Experiment, GroundOutline, Initial, Input, InputAs, Motion, Outputs, Parameter, Point, Sampled,
    SampledValue, Scene, Signal, Solver, State, Vector,
};
use super::part::{Body, Driver, Joint, Load, Outline, Part};
use super::quantity::Quantity;
use crate::diagnostic::span::{Source, Span, Text};
use crate::model::Dimension;

impl Scene {
    /// An empty scene in the plane.
    pub fn new(name: &str) -> Scene {
        Scene {
            name: Text::from(name),
            description: None,
            credits: Vec::new(),
            dimension: Dimension::Two,
            gravity: None,
            parameters: Vec::new(),
            inputs: Vec::new(),
            states: Vec::new(),
            sampled: Vec::new(),
            events: Vec::new(),
            signals: Vec::new(),
            ground: Vec::new(),
            ground_outlines: Vec::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            drivers: Vec::new(),
            loads: Vec::new(),
            initial: Vec::new(),
            outputs: Outputs::default(),
            experiment: Experiment::default(),
            solver: Solver::default(),
            coordinates: Coordinates::default(),
            clearance: None,
            display: Vec::new(),
            source: Source::default(),
            broken: Vec::new(),
            uses: Vec::new(),
        }
    }

    /// One line about the scene.
    #[must_use]
    pub fn description(mut self, text: &str) -> Scene {
        self.description = Some(Text::from(text));
        self
    }

    /// Who made it.
    #[must_use]
    pub fn author(self, text: &str) -> Scene {
        self.credit("author", text)
    }

    /// The version of the model, such as `1.2`.
    #[must_use]
    pub fn version(self, text: &str) -> Scene {
        self.credit("version", text)
    }

    /// The licence that the model may be used under.
    #[must_use]
    pub fn license(self, text: &str) -> Scene {
        self.credit("license", text)
    }

    /// Whose the rights to the model are, and since when.
    #[must_use]
    pub fn copyright(self, text: &str) -> Scene {
        self.credit("copyright", text)
    }

    fn credit(mut self, key: &'static str, text: &str) -> Scene {
        self.credits.retain(|(known, _)| *known != key);
        self.credits.push((key, text.to_owned()));
        self
    }

    /// Shows results in this unit, such as `deg`, `mm` or `kN`; one for each kind of value.
    #[must_use]
    pub fn show_in(mut self, unit: &str) -> Scene {
        self.display.push((Text::from("units"), Text::from(unit)));
        self
    }

    /// Masses on a line instead of bodies in the plane.
    #[must_use]
    pub fn one_dimensional(mut self) -> Scene {
        self.dimension = Dimension::One;
        self
    }

    /// Acceleration of gravity [m/s2].
    #[must_use]
    pub fn gravity(mut self, gravity: impl Into<Vector>) -> Scene {
        self.gravity = Some(gravity.into());
        self
    }

    /// Adds a parameter: a value, or a [`Parameter`] with unit, limits and description.
    #[must_use]
    pub fn parameter(mut self, name: &str, parameter: impl Into<Parameter>) -> Scene {
        self.parameters.push(Parameter { name: Text::from(name), ..parameter.into() });
        self
    }

    /// Adds an input: its start value, or an [`Input`] with unit, limits and description.
    #[must_use]
    pub fn input(mut self, name: &str, input: impl Into<Input>) -> Scene {
        self.inputs.push(Input { name: Text::from(name), ..input.into() });
        self
    }

    /// Adds values that change at ticks only.
    #[must_use]
    pub fn sampled(mut self, name: &str, sampled: Sampled) -> Scene {
        self.sampled.push(Sampled { name: Text::from(name), ..sampled });
        self
    }

    /// Adds what happens when a comparison begins to hold.
    #[must_use]
    pub fn event(mut self, name: &str, event: Event) -> Scene {
        self.events.push(Event { name: Text::from(name), ..event });
        self
    }

    /// Adds a quantity whose rate is given.
    #[must_use]
    pub fn state(mut self, name: &str, state: State) -> Scene {
        self.states.push(State { name: Text::from(name), ..state });
        self
    }

    /// Adds a law that others use by its name: an expression, or a [`Signal`] with unit and description.
    #[must_use]
    pub fn signal(mut self, name: &str, signal: impl Into<Signal>) -> Scene {
        self.signals.push(Signal { name: Text::from(name), ..signal.into() });
        self
    }

    /// Adds a point of the ground \[m\].
    #[must_use]
    pub fn ground_point(mut self, name: &str, at: impl Into<Vector>) -> Scene {
        self.ground.push(Point { name: Text::from(name), at: at.into(), within: 0 });
        self
    }

    /// Adds an outline of the ground, for pictures and clearance.
    #[must_use]
    pub fn ground_outline(mut self, outline: Outline) -> Scene {
        self.ground_outlines.push(GroundOutline { node: outline.0.node, within: 0 });
        self
    }

    /// Has the distance between the outlines of two bodies, or of a body and `ground`, reported for a turn or stroke.
    #[must_use]
    pub fn clearance(mut self, first: &str, second: &str) -> Scene {
        let pairs = &mut self.clearance.get_or_insert_default().pairs;
        pairs.get_or_insert_default().push([first, second].map(Text::from));
        self
    }

    /// The least distance that is permitted between outlines \[m\].
    #[must_use]
    pub fn least_clearance(mut self, distance: impl Into<Quantity>) -> Scene {
        self.clearance.get_or_insert_default().least = Some(distance.into());
        self
    }

    /// Adds a body.
    #[must_use]
    pub fn body(mut self, name: &str, body: Body) -> Scene {
        self.bodies.push(body.0.with_name(name));
        self
    }

    /// Adds a joint.
    #[must_use]
    pub fn joint(mut self, name: &str, joint: Joint) -> Scene {
        self.joints.push(joint.0.with_name(name));
        self
    }

    /// Adds a prescribed motion.
    #[must_use]
    pub fn driver(mut self, name: &str, driver: Driver) -> Scene {
        self.drivers.push(driver.0.with_name(name));
        self
    }

    /// Adds a load.
    #[must_use]
    pub fn load(mut self, name: &str, load: Load) -> Scene {
        self.loads.push(load.0.with_name(name));
        self
    }

    /// Gives a known initial position or velocity, such as `crank.angle`.
    #[must_use]
    pub fn initial(mut self, variable: &str, value: impl Into<Quantity>) -> Scene {
        self.initial.push(Initial { variable: Text::from(variable), value: value.into(), known: true, within: 0 });
        self
    }

    /// Gives a guess that picks the assembly.
    #[must_use]
    pub fn guess(mut self, variable: &str, value: impl Into<Quantity>) -> Scene {
        self.initial.push(Initial { variable: Text::from(variable), value: value.into(), known: false, within: 0 });
        self
    }

    /// Reports a variable of the scene, such as `crank.angle`.
    #[must_use]
    pub fn output(mut self, variable: &str) -> Scene {
        self.outputs.variables.push(Text::from(variable));
        self
    }

    /// Reports an expression under a name of its own.
    #[must_use]
    pub fn output_expression(mut self, name: &str, expression: impl Into<Quantity>) -> Scene {
        self.outputs.expressions.push(Signal { name: Text::from(name), ..Signal::new(expression) });
        self
    }

    /// Reports an expression with the unit in which it is shown, such as `mm`, and a description. The expression itself is in SI units.
    #[must_use]
    pub fn output_expression_in(
        self,
        unit: &str,
        name: &str,
        expression: impl Into<Quantity>,
        description: &str,
    ) -> Scene {
        let mut scene = self.output_expression(name, expression);
        if let Some(output) = scene.outputs.expressions.last_mut() {
            (output.unit, output.description) = (Some(Text::from(unit)), Some(Text::from(description)));
        }
        scene
    }

    /// Start of the default experiment \[s\].
    #[must_use]
    pub fn start(mut self, time: impl Into<Quantity>) -> Scene {
        self.experiment.start = Some(time.into());
        self
    }

    /// End of the default experiment \[s\].
    #[must_use]
    pub fn stop(mut self, time: impl Into<Quantity>) -> Scene {
        self.experiment.stop = Some(time.into());
        self
    }

    /// Communication step of the default experiment \[s\].
    #[must_use]
    pub fn step(mut self, time: impl Into<Quantity>) -> Scene {
        self.experiment.step = Some(time.into());
        self
    }

    /// Relative tolerance of the default experiment.
    #[must_use]
    pub fn tolerance(mut self, tolerance: impl Into<Quantity>) -> Scene {
        self.experiment.tolerance = Some(tolerance.into());
        self
    }

    /// Settings of the solver.
    #[must_use]
    pub fn solver(mut self, solver: Solver) -> Scene {
        self.solver = solver;
        self
    }

    /// Chooses the trees: `recommended`, `absolute` or `joint`.
    #[must_use]
    pub fn preset(mut self, preset: &str) -> Scene {
        self.coordinates.preset = Some(Text::from(preset));
        self
    }

    /// Names the branches of the translational tree.
    #[must_use]
    pub fn translation<'n>(mut self, branches: impl IntoIterator<Item = &'n str>) -> Scene {
        self.coordinates.translation = Some(branches.into_iter().map(Text::from).collect());
        self
    }

    /// Names the branches of the rotational tree.
    #[must_use]
    pub fn rotation<'n>(mut self, branches: impl IntoIterator<Item = &'n str>) -> Scene {
        self.coordinates.rotation = Some(branches.into_iter().map(Text::from).collect());
        self
    }
}

impl<T: Into<Quantity>> From<[T; 2]> for Vector {
    fn from(components: [T; 2]) -> Vector {
        Vector { components: components.into_iter().map(Into::into).collect(), span: Span::default() }
    }
}

/// One component, in one dimension.
impl<T: Into<Quantity>> From<[T; 1]> for Vector {
    fn from([x]: [T; 1]) -> Vector {
        Vector { components: vec![x.into()], span: Span::default() }
    }
}

/// Components of different types: `("crank_length/2", 0)`.
impl<X: Into<Quantity>, Y: Into<Quantity>> From<(X, Y)> for Vector {
    fn from((x, y): (X, Y)) -> Vector {
        Vector { components: vec![x.into(), y.into()], span: Span::default() }
    }
}

impl<T: Into<Quantity>> From<T> for Parameter {
    fn from(value: T) -> Parameter {
        Parameter { value: value.into(), ..Parameter::default() }
    }
}

impl Parameter {
    /// A parameter with a default value.
    pub fn new(value: impl Into<Quantity>) -> Parameter {
        Parameter::from(value)
    }

    /// The unit of bare numbers.
    #[must_use]
    pub fn unit(mut self, unit: &str) -> Parameter {
        self.unit = Some(Text::from(unit));
        self
    }

    /// One line about it.
    #[must_use]
    pub fn description(mut self, text: &str) -> Parameter {
        self.description = Some(Text::from(text));
        self
    }

    /// Smallest value.
    #[must_use]
    pub fn min(mut self, min: impl Into<Quantity>) -> Parameter {
        self.min = Some(min.into());
        self
    }

    /// Largest value.
    #[must_use]
    pub fn max(mut self, max: impl Into<Quantity>) -> Parameter {
        self.max = Some(max.into());
        self
    }

    /// May change after initialisation.
    #[must_use]
    pub fn tunable(mut self) -> Parameter {
        self.tunable = true;
        self
    }
}

impl<T: Into<Quantity>> From<T> for Input {
    fn from(start: T) -> Input {
        Input { start: Some(start.into()), ..Input::default() }
    }
}

impl Input {
    /// An input with a start value.
    pub fn new(start: impl Into<Quantity>) -> Input {
        Input::from(start)
    }

    /// The unit of bare numbers.
    #[must_use]
    pub fn unit(mut self, unit: &str) -> Input {
        self.unit = Some(Text::from(unit));
        self
    }

    /// One line about it.
    #[must_use]
    pub fn description(mut self, text: &str) -> Input {
        self.description = Some(Text::from(text));
        self
    }

    /// Smallest value.
    #[must_use]
    pub fn min(mut self, min: impl Into<Quantity>) -> Input {
        self.min = Some(min.into());
        self
    }

    /// Largest value.
    #[must_use]
    pub fn max(mut self, max: impl Into<Quantity>) -> Input {
        self.max = Some(max.into());
        self
    }
}

impl Sampled {
    /// Values that change from tick to tick, so long apart.
    pub fn every(period: impl Into<Quantity>) -> Sampled {
        Sampled { period: period.into(), ..Sampled::default() }
    }

    /// The time of the first tick.
    #[must_use]
    pub fn offset(mut self, offset: impl Into<Quantity>) -> Sampled {
        self.offset = Some(offset.into());
        self
    }

    /// Adds a value with what it begins with, and what it is from a tick on.
    #[must_use]
    pub fn value(self, name: &str, start: impl Into<Quantity>, next: impl Into<Quantity>) -> Sampled {
        let (start, next) = (Some(start.into()), Some(next.into()));
        self.with(SampledValue { name: Text::from(name), start, next, ..SampledValue::default() })
    }

    /// Adds a value.
    #[must_use]
    pub fn with(mut self, value: SampledValue) -> Sampled {
        self.values.push(value);
        self
    }
}

impl Event {
    /// What happens when this comparison begins to hold.
    pub fn when(comparison: &str) -> Event {
        Event { when: Text::from(comparison), ..Event::default() }
    }

    /// A joint, driver or load is there no longer; it then happens once only.
    #[must_use]
    pub fn remove(mut self, part: &str) -> Event {
        self.remove.push(Text::from(part));
        self.once = true;
        self
    }

    /// A joint engages.
    #[must_use]
    pub fn engage(mut self, joint: &str) -> Event {
        self.engage.push(Text::from(joint));
        self
    }

    /// A joint is released, and may engage again.
    #[must_use]
    pub fn release(mut self, joint: &str) -> Event {
        self.release.push(Text::from(joint));
        self
    }

    /// A sampled value, a state or a rate gets another value.
    #[must_use]
    pub fn set(mut self, name: &str, value: impl Into<Quantity>) -> Event {
        self.set.push((Text::from(name), value.into()));
        self
    }

    /// It ends the run.
    #[must_use]
    pub fn stop(mut self) -> Event {
        self.stop = true;
        self
    }

    /// It happens once only.
    #[must_use]
    pub fn once(mut self) -> Event {
        self.once = true;
        self
    }
}

impl State {
    /// A state with its value at the start and its rate.
    pub fn new(start: impl Into<Quantity>, rate: impl Into<Quantity>) -> State {
        State { start: Some(start.into()), rate: rate.into(), ..State::default() }
    }

    /// Its usual size: tolerances are relative to it.
    #[must_use]
    pub fn nominal(mut self, nominal: impl Into<Quantity>) -> State {
        self.nominal = Some(nominal.into());
        self
    }

    /// Its unit, that of numbers without one.
    #[must_use]
    pub fn unit(mut self, unit: &str) -> State {
        self.unit = Some(Text::from(unit));
        self
    }

    /// One line about it.
    #[must_use]
    pub fn description(mut self, description: &str) -> State {
        self.description = Some(Text::from(description));
        self
    }
}

impl<T: Into<Quantity>> From<T> for Signal {
    fn from(value: T) -> Signal {
        Signal { value: value.into(), ..Signal::default() }
    }
}

impl Signal {
    /// A law.
    pub fn new(value: impl Into<Quantity>) -> Signal {
        Signal::from(value)
    }

    /// Its unit.
    #[must_use]
    pub fn unit(mut self, unit: &str) -> Signal {
        self.unit = Some(Text::from(unit));
        self
    }

    /// One line about it.
    #[must_use]
    pub fn description(mut self, text: &str) -> Signal {
        self.description = Some(Text::from(text));
        self
    }
}

impl Signal {
    /// A signal of a type: `pid` of an error, `filter` or `delay` of an input.
    fn of_type(kind: &str, hears: &str, law: Quantity) -> Signal {
        Signal { part: Some(Part::empty().set("type", kind).set(hears, law)), ..Signal::default() }
    }

    /// A controller of an error; its gains and limits are its keys.
    pub fn pid(error: impl Into<Quantity>) -> Signal {
        Signal::of_type("pid", "error", error.into())
    }

    /// A low pass; `time` or `cutoff` is one of its keys.
    pub fn filter(input: impl Into<Quantity>) -> Signal {
        Signal::of_type("filter", "input", input.into())
    }

    /// What was heard so long ago \[s\].
    pub fn delay(input: impl Into<Quantity>, time: impl Into<Quantity>) -> Signal {
        Signal::of_type("delay", "input", input.into()).with("time", time)
    }

    /// A key of a signal with a type.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Quantity>) -> Signal {
        self.part = self.part.map(|part| part.set(key, value.into()));
        self
    }
}

impl<T: Into<Quantity>> From<T> for Motion {
    fn from(law: T) -> Motion {
        Motion::Given(law.into())
    }
}

impl Motion {
    /// Follows an FMU input.
    pub fn follows(input: &str, r#as: InputAs) -> Motion {
        Motion::Follows { input: Text::from(input), r#as }
    }
}
