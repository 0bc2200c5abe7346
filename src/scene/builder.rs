//! Builds scenes in Rust, with the words of the scene file.

use super::model::{
    Body, Coordinates, Driver, DriverKind, Experiment, Initial, Input, InputAs, Joint, Load, LoadKind, Motion, Outputs,
    Parameter, Point, Scene, Solver, Turning, Vector,
};
use super::quantity::Quantity;
use super::span::{Source, Span, Text};
use crate::mechanism::{Dimension, Side};

impl Scene {
    /// An empty scene in the plane.
    pub fn new(name: &str) -> Scene {
        Scene {
            name: Text::from(name),
            description: None,
            dimension: Dimension::Two,
            gravity: None,
            parameters: Vec::new(),
            inputs: Vec::new(),
            ground: Vec::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            drivers: Vec::new(),
            loads: Vec::new(),
            initial: Vec::new(),
            outputs: Outputs::default(),
            experiment: Experiment::default(),
            solver: Solver::default(),
            coordinates: Coordinates::default(),
            source: Source::default(),
            broken: Vec::new(),
        }
    }

    /// One line about the scene.
    #[must_use]
    pub fn description(mut self, text: &str) -> Scene {
        self.description = Some(Text::from(text));
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

    /// Adds a point of the ground \[m\].
    #[must_use]
    pub fn ground_point(mut self, name: &str, at: impl Into<Vector>) -> Scene {
        self.ground.push(Point { name: Text::from(name), at: at.into() });
        self
    }

    /// Adds a body.
    #[must_use]
    pub fn body(mut self, name: &str, body: Body) -> Scene {
        self.bodies.push(Body { name: Text::from(name), ..body });
        self
    }

    /// Adds a joint.
    #[must_use]
    pub fn joint(mut self, name: &str, joint: Joint) -> Scene {
        self.joints.push(Joint { name: Text::from(name), ..joint });
        self
    }

    /// Adds a revolute joint between two points.
    #[must_use]
    pub fn revolute(self, name: &str, first: &str, second: &str) -> Scene {
        self.joint(name, Joint::revolute(first, second))
    }

    /// Adds a prismatic joint between two points along an axis in the first body's frame.
    #[must_use]
    pub fn prismatic(self, name: &str, first: &str, second: &str, axis: impl Into<Vector>) -> Scene {
        self.joint(name, Joint::prismatic(first, second, axis))
    }

    /// Adds a weld between two points.
    #[must_use]
    pub fn weld(self, name: &str, first: &str, second: &str) -> Scene {
        self.joint(name, Joint::weld(first, second))
    }

    /// Adds a prescribed motion.
    #[must_use]
    pub fn driver(mut self, name: &str, driver: Driver) -> Scene {
        self.drivers.push(Driver { name: Text::from(name), ..driver });
        self
    }

    /// Adds a load.
    #[must_use]
    pub fn load(mut self, name: &str, load: Load) -> Scene {
        self.loads.push(Load { name: Text::from(name), ..load });
        self
    }

    /// Gives a known initial position or velocity, such as `crank.angle`.
    #[must_use]
    pub fn initial(mut self, variable: &str, value: impl Into<Quantity>) -> Scene {
        self.initial.push(Initial { variable: Text::from(variable), value: value.into(), known: true });
        self
    }

    /// Gives a guess that picks the assembly.
    #[must_use]
    pub fn guess(mut self, variable: &str, value: impl Into<Quantity>) -> Scene {
        self.initial.push(Initial { variable: Text::from(variable), value: value.into(), known: false });
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
        self.outputs.expressions.push((Text::from(name), expression.into()));
        self
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

impl Body {
    /// A body without mass and points.
    pub fn new() -> Body {
        Body::default()
    }

    /// \[kg\]
    #[must_use]
    pub fn mass(mut self, mass: impl Into<Quantity>) -> Body {
        self.mass = Some(mass.into());
        self
    }

    /// About the mass centre [kg.m2].
    #[must_use]
    pub fn inertia(mut self, inertia: impl Into<Quantity>) -> Body {
        self.inertia = Some(inertia.into());
        self
    }

    /// Mass centre in the frame of the points \[m\].
    #[must_use]
    pub fn com(mut self, at: impl Into<Vector>) -> Body {
        self.com = Some(at.into());
        self
    }

    /// Gravity leaves it alone.
    #[must_use]
    pub fn weightless(mut self) -> Body {
        self.weightless = true;
        self
    }

    /// Adds a point \[m\].
    #[must_use]
    pub fn point(mut self, name: &str, at: impl Into<Vector>) -> Body {
        self.points.push(Point { name: Text::from(name), at: at.into() });
        self
    }
}

pub(super) fn pair(first: &str, second: &str) -> [Text; 2] {
    [Text::from(first), Text::from(second)]
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

impl Driver {
    fn of(kind: DriverKind) -> Driver {
        Driver { name: Text::default(), kind }
    }

    /// The angle of a revolute joint.
    pub fn angle(joint: &str, motion: impl Into<Motion>) -> Driver {
        Driver::of(DriverKind::Angle { of: Turning::Joint(Text::from(joint)), motion: motion.into() })
    }

    /// The angle of the second body relative to the first.
    pub fn angle_between(first: &str, second: &str, motion: impl Into<Motion>) -> Driver {
        Driver::of(DriverKind::Angle { of: Turning::Between(pair(first, second)), motion: motion.into() })
    }

    /// The displacement of a prismatic joint.
    pub fn displacement(joint: &str, motion: impl Into<Motion>) -> Driver {
        Driver::of(DriverKind::Displacement { joint: Text::from(joint), motion: motion.into() })
    }

    /// The position of a point in the world.
    pub fn position(on: &str, position: impl Into<Vector>) -> Driver {
        Driver::of(DriverKind::Position { on: Text::from(on), position: position.into() })
    }
}

impl Load {
    fn of(kind: LoadKind) -> Load {
        Load { name: Text::default(), kind }
    }

    /// A force on a point, in the world frame.
    pub fn force(on: &str, vector: impl Into<Vector>) -> Load {
        Load::of(LoadKind::Force { on: Text::from(on), vector: vector.into(), in_body: false })
    }

    /// A force on a point, in the body's frame.
    pub fn body_force(on: &str, vector: impl Into<Vector>) -> Load {
        Load::of(LoadKind::Force { on: Text::from(on), vector: vector.into(), in_body: true })
    }

    /// A torque on the second body, its opposite on the first.
    pub fn torque(first: &str, second: &str, value: impl Into<Quantity>) -> Load {
        Load::of(LoadKind::Torque { between: pair(first, second), value: value.into() })
    }

    /// A spring between two points.
    pub fn spring(first: &str, second: &str, stiffness: impl Into<Quantity>) -> Load {
        let between = pair(first, second);
        Load::of(LoadKind::Spring {
            between,
            stiffness: stiffness.into(),
            length: None,
            damping: None,
            cubic: None,
            side: Side::Both,
        })
    }

    /// A spring that resists turning.
    pub fn torsion_spring(first: &str, second: &str, stiffness: impl Into<Quantity>) -> Load {
        let between = pair(first, second);
        Load::of(LoadKind::TorsionSpring {
            between,
            stiffness: stiffness.into(),
            angle: None,
            damping: None,
            cubic: None,
            side: Side::Both,
        })
    }

    /// A force law between two points.
    pub fn actuator(first: &str, second: &str, force: impl Into<Quantity>) -> Load {
        Load::of(LoadKind::Actuator { between: pair(first, second), force: force.into() })
    }

    /// A torque law between two bodies.
    pub fn torsion_actuator(first: &str, second: &str, torque: impl Into<Quantity>) -> Load {
        Load::of(LoadKind::TorsionActuator { between: pair(first, second), torque: torque.into() })
    }

    /// The free length of a spring \[m\], the free angle of a torsion spring \[rad\]; other loads have none.
    #[must_use]
    pub fn free(mut self, value: impl Into<Quantity>) -> Load {
        if let LoadKind::Spring { length: free, .. } | LoadKind::TorsionSpring { angle: free, .. } = &mut self.kind {
            *free = Some(value.into());
        }
        self
    }

    /// The damping of a spring [N.s/m] or torsion spring [N.m.s]; other loads have none.
    #[must_use]
    pub fn damping(mut self, value: impl Into<Quantity>) -> Load {
        if let LoadKind::Spring { damping, .. } | LoadKind::TorsionSpring { damping, .. } = &mut self.kind {
            *damping = Some(value.into());
        }
        self
    }

    /// The cubic stiffness of a spring [N/m3] or torsion spring [N.m/rad3]; other loads have none.
    #[must_use]
    pub fn cubic(mut self, value: impl Into<Quantity>) -> Load {
        if let LoadKind::Spring { cubic, .. } | LoadKind::TorsionSpring { cubic, .. } = &mut self.kind {
            *cubic = Some(value.into());
        }
        self
    }

    /// Lets a spring or torsion spring act on one side of its free length or angle only; other loads have none.
    #[must_use]
    pub fn side(mut self, value: Side) -> Load {
        if let LoadKind::Spring { side, .. } | LoadKind::TorsionSpring { side, .. } = &mut self.kind {
            *side = value;
        }
        self
    }
}
