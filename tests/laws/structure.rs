//! M is symmetric and moves no negative mass, reactions enter through the transposed Jacobian, derivatives are those of Phi, and tapes compute
//! what the expressions say. Points are the initial state and a random one at which the loops are open.

use cotree::equations::{Dynamics, Equations};
use cotree::expr::Expr;
use cotree::formulate::{Formulated, formulate};
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::tape::Tape;
use nalgebra::DMatrix;

use super::{cases, choices, resolved};
use crate::support::point::value;
use crate::support::random::{Family, Random};
use cotree::scene::Resolved;

#[test]
fn chains_and_trees() {
    check(Family::Chain, 25);
    check(Family::Tree, 25);
}

#[test]
fn loops() {
    check(Family::Loops, 30);
    check(Family::Redundant, 15);
}

#[test]
fn driven() {
    check(Family::Driven, 30);
}

fn check(family: Family, count: u64) {
    for (seed, case) in cases(family, count) {
        let Resolved { mut mechanism, outputs, .. } = resolved(&case.scene);
        for choice in choices(&mechanism, seed, 2) {
            mechanism.coordinates = choice;
            let mut formulated = formulate(&mechanism, &outputs).unwrap();
            let model = Model::new(formulated.lowered.program.clone()).unwrap();
            let dynamics = formulated.equations.dynamics().clone();
            for state in [formulated.state.clone(), elsewhere(&formulated.state, seed)] {
                let point = Point::new(&model, &state, seed);
                mass_is_symmetric(&formulated.equations, &dynamics, &point);
                reactions_are_the_transposed_jacobian(&formulated.equations, &dynamics, &point);
                derivatives_are_those_of_phi(&formulated, &point);
                tapes_have_the_bits_of_the_expressions(&formulated, &point);
            }
        }
    }
}

/// A state at which nothing fits together.
fn elsewhere(state: &State, seed: u64) -> State {
    let (mut state, mut random) = (state.clone(), Random(seed));
    let time = 0;
    state.registers_mut()[time] = random.number(0.0, 1.0);
    state.positions_mut().iter_mut().for_each(|q| *q += random.number(-1.0, 1.0));
    state.rates_mut().iter_mut().for_each(|v| *v = random.number(-2.0, 2.0));
    state
}

struct Point<'a> {
    model: &'a Model,
    state: &'a State,
    machine: Machine,
}

impl<'a> Point<'a> {
    /// Accelerations and reactions are random numbers.
    fn new(model: &'a Model, state: &'a State, seed: u64) -> Self {
        let (mut machine, mut random) = (Machine::new(model), Random(seed));
        machine.load(model, state);
        let mut numbers = |count: usize| -> Vec<f64> { (0..count).map(|_| random.number(-9.0, 9.0)).collect() };
        let accelerations = numbers(model.coordinates());
        machine.load_accelerations(model, &accelerations);
        machine.load_reactions(model, &numbers(model.program().constraints.len()));
        Point { model, state, machine }
    }

    fn evaluate(&self, equations: &Equations, exprs: &[Expr]) -> Vec<f64> {
        let registers = self.machine.registers();
        equations.system.arena.evaluate(exprs, &|symbol| value(self.model.layout(), registers, symbol))
    }

    fn run(&self, tape: &Tape) -> Vec<f64> {
        let mut machine = self.machine.clone();
        machine.run(tape);
        tape.results(machine.registers()).collect()
    }

    /// A tape h further in time and along a change of q.
    fn run_at(&self, tape: &Tape, h: f64, time: f64, change: &[f64]) -> Vec<f64> {
        let mut state = self.state.clone();
        self.model.advance_signals(self.state, self.state.time() + h * time, state.registers_mut());
        state.positions_mut().iter_mut().zip(change).for_each(|(q, change)| *q += h * change);
        let mut machine = Machine::new(self.model);
        machine.load(self.model, &state);
        machine.run(tape);
        tape.results(machine.registers()).collect()
    }

    /// The derivative of a tape by h, by central differences of fourth order.
    fn difference(&self, tape: &Tape, time: f64, change: &[f64]) -> Vec<f64> {
        let h = 2.5e-4;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| self.run_at(tape, k * h, time, change));
        (0..a.len()).map(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h)).collect()
    }
}

fn dense(point: &Point, equations: &Equations, rows: &[Vec<(usize, Expr)>], columns: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(rows.len(), columns);
    for (row, entries) in rows.iter().enumerate() {
        let exprs: Vec<Expr> = entries.iter().map(|(_, entry)| *entry).collect();
        for (&(column, _), value) in entries.iter().zip(point.evaluate(equations, &exprs)) {
            matrix[(row, column)] = value;
        }
    }
    matrix
}

fn near(what: &str, a: &DMatrix<f64>, b: &DMatrix<f64>, tolerance: f64) {
    assert_eq!(a.shape(), b.shape(), "{what}");
    let scale = 1.0 + a.iter().chain(b.iter()).fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let error = (a - b).iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    assert!(error <= tolerance * scale, "{what}: {a} instead of {b}, error {error:e}");
}

fn mass_is_symmetric(equations: &Equations, dynamics: &Dynamics, point: &Point) {
    let mass = dense(point, equations, &dynamics.mass, dynamics.mass.len());
    near("M", &mass, &mass.transpose(), 1e-14);
    if !mass.is_empty() {
        let eigenvalues = mass.symmetric_eigenvalues();
        assert!(eigenvalues.min() > 0.0, "M moves no mass: {eigenvalues}");
    }
}

fn jacobian(equations: &Equations, point: &Point) -> DMatrix<f64> {
    let rows: Vec<_> = equations.constraints.iter().map(|row| row.jacobian.clone()).collect();
    dense(point, equations, &rows, equations.coordinates.len())
}

fn reactions_are_the_transposed_jacobian(equations: &Equations, dynamics: &Dynamics, point: &Point) {
    let reactions = dense(point, equations, &dynamics.reactions, equations.constraints.len());
    near("reactions", &reactions, &jacobian(equations, point).transpose(), 1e-14);
}

fn derivatives_are_those_of_phi(formulated: &Formulated, point: &Point) {
    let (equations, tapes) = (&formulated.equations, &formulated.lowered.program.tapes);
    let (n, m) = (equations.coordinates.len(), equations.constraints.len());
    let at_rest = vec![0.0; n];
    let mut differences = DMatrix::zeros(m, n);
    for column in 0..n {
        let mut unit = at_rest.clone();
        unit[column] = 1.0;
        differences.set_column(column, &nalgebra::DVector::from_vec(point.difference(&tapes.constraint, 0.0, &unit)));
    }
    near("Phi_q", &jacobian(equations, point), &differences, 1e-10);

    let column = |values: Vec<f64>| DMatrix::from_vec(m, 1, values);
    let of = |pick: fn(&cotree::equations::Constraint) -> Expr| {
        let exprs: Vec<Expr> = equations.constraints.iter().map(pick).collect();
        column(point.evaluate(equations, &exprs))
    };
    let phi_t = column(point.difference(&tapes.constraint, 1.0, &at_rest));
    near("Phi_t", &of(|row| row.time_rate), &phi_t, 1e-10);
    let rates = point.state.rates().to_vec();
    let total = column(point.difference(&tapes.constraint, 1.0, &rates));
    near("rate of Phi", &column(point.run(&tapes.constraint_rate)), &total, 1e-9);
    let minus_gamma = column(point.difference(&tapes.constraint_rate, 1.0, &rates));
    near("gamma", &-of(|row| row.gamma), &minus_gamma, 1e-8);
}

fn tapes_have_the_bits_of_the_expressions(formulated: &Formulated, point: &Point) {
    let (equations, tapes) = (&formulated.equations, &formulated.lowered.program.tapes);
    let same = |what: &str, tape: &Tape, exprs: &[Expr]| {
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(point.run(tape)), bits(point.evaluate(equations, exprs)), "{what}");
    };
    let of =
        |pick: fn(&cotree::equations::Constraint) -> Expr| equations.constraints.iter().map(pick).collect::<Vec<_>>();
    same("Phi", &tapes.constraint, &of(|row| row.value));
    same("gamma", &tapes.gamma, &of(|row| row.gamma));
    let entries: Vec<Expr> = equations
        .constraints
        .iter()
        .flat_map(|row| row.jacobian.iter().chain(&row.followers).map(|(_, e)| *e))
        .collect();
    same("Phi_q", &tapes.jacobian.tape, &entries);
    if !formulated.lowered.solved.is_empty() {
        same("a and lambda", &tapes.acceleration, &formulated.lowered.solved);
    }
    same("outputs", &tapes.outputs, &formulated.lowered.table.results);
    let mut equations = equations.clone();
    let rates: Vec<Expr> = (0..equations.constraints.len()).map(|row| equations.constraint_rate(row)).collect();
    let values: Vec<u64> = point.evaluate(&equations, &rates).into_iter().map(f64::to_bits).collect();
    let found: Vec<u64> = point.run(&tapes.constraint_rate).into_iter().map(f64::to_bits).collect();
    assert_eq!(found, values, "rate of Phi");
}
