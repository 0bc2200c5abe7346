//! The matrices of linear systems against differences of what the runtime computes.

use super::support::*;
use cotree_fmu::instance::Instance;
use cotree_fmu::integrator::accelerations::Accelerations;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Source;
use cotree_study::analysis::{OperatingPoint, StateSpace, Variation};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// States of a model near a motion: what is independent is set, the loops give the rest.
struct Nearby<'a> {
    model: &'a Model,
    /// Coordinates that are states.
    independent: Vec<usize>,
    state: State,
}

impl Nearby<'_> {
    /// (dx/dt, y) when the named states and inputs differ by these amounts.
    fn evaluate(&self, system: &StateSpace, change: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (model, f) = (self.model, self.independent.len());
        let mut state = self.state.clone();
        for (place, &index) in self.independent.iter().enumerate() {
            state.positions_mut()[index] += change[place];
            state.rates_mut()[index] += change[f + place];
        }
        let followers = state.follower_positions().len();
        for index in 0..followers {
            state.follower_positions_mut()[index] += change[2 * f + index];
        }
        for (place, rate) in (2 * f + followers..system.states.len()).zip(0..) {
            state.follower_rates_mut()[rate] += change[place];
        }
        for (signal, change) in system.inputs.iter().zip(&change[system.states.len()..]) {
            let order = usize::from(signal.name.ends_with("/dt")) + usize::from(signal.name.ends_with("/dt2")) * 2;
            let base = signal.name.trim_start_matches("d2(").trim_start_matches("d(");
            let base = base.trim_end_matches(")/dt2").trim_end_matches(")/dt");
            let input = model.program().inputs.iter().position(|input| input.name == base).unwrap();
            let mut polynomial = state.input_polynomial(input);
            polynomial[order] += change;
            state.set_input_polynomial(input, polynomial);
        }
        model.follow(state.registers_mut());
        self.close(&mut state);
        self.read(system, &state)
    }

    /// Dependent positions by Newton's method, dependent rates from the linear equations.
    fn close(&self, state: &mut State) {
        let (model, tapes) = (self.model, &self.model.program().tapes);
        // Rows of what is open, free or slides are empty.
        let here = cotree::redundancy::matrices::jacobian(model, state);
        let holds = |row: &usize| here.row(*row).amax() > 0.0;
        let active = &model.active().iter().copied().filter(holds).collect::<Vec<usize>>()[..];
        if active.is_empty() {
            return;
        }
        let dependent: Vec<usize> =
            (0..model.coordinates()).filter(|index| !self.independent.contains(index)).collect();
        let mut machine = Machine::new(model);
        let mut step = |tape: &cotree_fmu::tape::Tape, state: &State| {
            machine.load(model, state);
            machine.run(tape);
            let residuals: Vec<f64> = tape.results(machine.registers()).collect();
            let right = DVector::from_iterator(active.len(), active.iter().map(|&row| -residuals[row]));
            let jacobian = cotree::redundancy::matrices::jacobian(model, state);
            jacobian.select_rows(active).select_columns(&dependent).lu().solve(&right).unwrap()
        };
        for _ in 0..8 {
            let change = step(&tapes.constraint, state);
            dependent.iter().zip(&change).for_each(|(&index, change)| state.positions_mut()[index] += change);
        }
        for _ in 0..2 {
            let change = step(&tapes.constraint_rate, state);
            dependent.iter().zip(&change).for_each(|(&index, change)| state.rates_mut()[index] += change);
        }
    }

    fn read(&self, system: &StateSpace, state: &State) -> (Vec<f64>, Vec<f64>) {
        let (model, program) = (self.model, self.model.program());
        let mut machine = Machine::new(model);
        machine.load(model, state);
        let mut accelerations = Accelerations::new(model);
        accelerations.evaluate(model, &mut machine).unwrap();
        let own = |values: &[f64]| self.independent.iter().map(|&index| values[index]).collect::<Vec<_>>();
        let mut rates = [own(state.rates()), own(accelerations.accelerations())].concat();
        let registers = machine.registers().to_vec();
        let layout = program.layout();
        let followers = program.followers.len();
        rates.extend(&registers[layout.follower_rates()..][..followers]);
        let integrated = system.states.len() - rates.len();
        rates.extend(&registers[layout.follower_accelerations()..][..integrated]);
        machine.run(&program.tapes.outputs);
        let results: Vec<f64> = program.tapes.outputs.results(machine.registers()).collect();
        let value = |name: &str| {
            let variable = program.variables.iter().find(|variable| variable.name == name).unwrap();
            match variable.source {
                Source::Output { result, .. } => results[result as usize],
                Source::Coordinate(index) => state.positions()[index as usize],
                Source::Rate(index) => state.rates()[index as usize],
                Source::Acceleration(index) => registers[layout.accelerations() + index as usize],
                Source::Input(index) => state.inputs()[index as usize],
                Source::Discrete(index) => state.discrete()[index as usize],
                Source::Parameter(_) | Source::Time => panic!("{name} is no output"),
            }
        };
        (rates, system.outputs.iter().map(|output| value(&output.name)).collect())
    }
}

/// Compares with central differences at some times of a motion.
pub fn against_differences(text: &str, times: &[f64]) {
    with(text, |formulated| {
        let variation = Variation::new(formulated);
        let model = Arc::new(Model::new(formulated.lowered.program.clone()).unwrap());
        let mut instance = Instance::new(Arc::clone(&model));
        instance.setup(0.0, None, Some(1e-10)).unwrap();
        instance.initialise().unwrap();
        for &time in times {
            if time > 0.0 {
                instance.step_to(time).unwrap();
            }
            let point = OperatingPoint::moving(&model, &instance.state()).unwrap();
            let system = StateSpace::new(formulated, &variation, &point, None).unwrap();
            let f = (system.states.len() - model.program().followers.len()) / 2;
            let coordinates = &model.program().coordinates;
            let place = |name: &str| coordinates.iter().position(|coordinate| coordinate.name == name).unwrap();
            let independent: Vec<usize> = system.states.iter().take(f).map(|state| place(&state.name)).collect();
            let nearby = Nearby { model: &model, independent, state: instance.state() };
            compare(&system, &nearby);
        }
    });
}

fn compare(system: &StateSpace, nearby: &Nearby) {
    let states = system.states.len();
    let count = states + system.inputs.len();
    let step = 1e-5;
    for column in 0..count {
        let at = |size: f64| {
            let mut change = vec![0.0; count];
            change[column] = size;
            nearby.evaluate(system, &change)
        };
        // Fourth order, so that the differences are good to 1e-6 of the largest entry.
        let [a, b, c, d] = [2.0 * step, step, -step, -2.0 * step].map(at);
        let slope = |a: f64, b: f64, c: f64, d: f64| (8.0 * (b - c) - (a - d)) / (12.0 * step);
        let exact = |rows: [&DMatrix<f64>; 2], row: usize| match column.checked_sub(states) {
            None => rows[0][(row, column)],
            Some(input) => rows[1][(row, input)],
        };
        for row in 0..states {
            let expected = slope(a.0[row], b.0[row], c.0[row], d.0[row]);
            close("A or B", exact([&system.a, &system.b], row), expected, 1e-6, system.a.amax());
        }
        for row in 0..system.outputs.len() {
            let expected = slope(a.1[row], b.1[row], c.1[row], d.1[row]);
            let name = &system.outputs[row].name;
            close(name, exact([&system.c, &system.d], row), expected, 1e-6, system.outputs[row].value.abs());
        }
    }
}

#[test]
fn matrices_are_the_slopes_of_the_runtime() {
    against_differences(&scene_of("slider_crank"), &[0.0, 0.4]);
    against_differences(&scene_of("four_bar"), &[0.0, 0.3, 0.8]);
    against_differences(&scene_of("cart_pole"), &[0.5]);
    against_differences(&scene_of("double_pendulum"), &[0.7]);
    against_differences(&scene_of("vibration"), &[1.0]);
}

#[test]
fn matrices_are_the_slopes_in_absolute_and_joint_coordinates_too() {
    for preset in ["absolute", "joint"] {
        let text = format!("{}\n[coordinates]\npreset = \"{preset}\"\n", scene_of("four_bar"));
        against_differences(&text, &[0.3]);
    }
}

/// The crank's pivot of a slider-crank that a driver moves by an input.
fn driven(how: &str) -> String {
    format!(
        r#"
        format = 1
        name = "driven"
        gravity = [0, -9.81]
        [inputs]
        command = {{ start = 0.7, unit = "{unit}" }}
        push = {{ start = 2.0, unit = "N" }}
        [bodies.crank]
        mass = 1.0
        inertia = 0.1
        points = {{ inner = [-0.2, 0], outer = [0.2, 0] }}
        [bodies.arm]
        mass = 0.5
        inertia = 0.05
        points = {{ root = [-0.3, 0], tip = [0.3, 0] }}
        [joints.shoulder]
        type = "revolute"
        between = ["ground", "crank.inner"]
        [joints.elbow]
        type = "revolute"
        between = ["crank.outer", "arm.root"]
        damping = 0.1
        [drivers.motor]
        joint = "shoulder"
        angle = {{ input = "command", as = "{how}" }}
        [loads.wind]
        type = "force"
        on = "arm.tip"
        vector = ["push", "0.5*push"]
        [initial]
        "crank.angle" = {start}
        "arm.angle" = 0.9
        [outputs]
        variables = ["crank.angle", "crank.omega", "crank.alpha", "arm.tip.x", "arm.tip.ay", "motor.torque", "shoulder.fx", "elbow.fy"]
        "#,
        unit = match how {
            "position" => "rad",
            "velocity" => "rad/s",
            _ => "rad/s2",
        },
        start = if how == "position" { "{ guess = 0.7 }" } else { "0.4" },
    )
}

#[test]
fn inputs_of_drivers_act_with_their_derivatives() {
    for how in ["position", "velocity", "acceleration"] {
        against_differences(&driven(how), &[0.0, 0.6]);
    }
    with(&driven("position"), |formulated| {
        let names: Vec<String> = at_start(formulated).inputs.into_iter().map(|signal| signal.name).collect();
        assert_eq!(names, ["command", "push", "d(command)/dt", "d2(command)/dt2"]);
    });
    with(&driven("acceleration"), |formulated| {
        let names: Vec<String> = at_start(formulated).states.into_iter().map(|signal| signal.name).collect();
        assert_eq!(names, ["arm.angle", "arm.omega", "motor.position", "motor.rate"]);
    });
}

#[test]
fn a_driven_mechanism_passes_its_inputs_on_without_states() {
    let text = driven("position")
        .replace("[drivers.motor]", "[drivers.second]\njoint = \"elbow\"\nangle = 0.3\n[drivers.motor]");
    let text = text.replace("\"arm.angle\" = 0.9", "");
    against_differences(&text, &[0.0]);
    with(&text, |formulated| {
        let system = at_start(formulated);
        assert!(system.states.is_empty());
        // Both turn as one body: the torque accelerates all of it.
        let place = |name: &str| system.outputs.iter().position(|output| output.name == name).unwrap();
        let column = system.inputs.iter().position(|input| input.name == "d2(command)/dt2").unwrap();
        assert_eq!(system.d[(place("crank.alpha"), column)], 1.0);
        let reach = (0.4_f64 + 0.3 * 0.3_f64.cos()).powi(2) + (0.3 * 0.3_f64.sin()).powi(2);
        let inertia = 0.1 + 0.04 + 0.05 + 0.5 * reach;
        close("inertia", system.d[(place("motor.torque"), column)], inertia, 1e-12, 1.0);
    });
}
