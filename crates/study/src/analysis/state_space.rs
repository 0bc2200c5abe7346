//! Small motions about a point: dx/dt = A x + B u, y = C x + D u.
//!
//! The states are the independent coordinates, their rates, those of the scene, and what drivers integrate: as many as the mechanism has, so the
//! loops leave no spurious modes. The derivatives go through the loop equations implicitly: with J = Phi_q, varying
//! Phi = 0 and its rate gives the dependent coordinates and rates, varying \[M J^T; J 0\] {a, lambda} = {Q, gamma} the accelerations and
//! reactions. What slides adds its level s to the unknowns and its law s = F + mu p(a, lambda) to the equations. Nothing is approximated.

use cotree::equations::MotionLayout;
use cotree::expr::{Order, Symbol, Values};
use cotree::formulate::Formulated;
use cotree::model::{DiscreteKind, Unit};
use cotree_fmu::program::FollowerOrder;
use nalgebra::DMatrix;

use super::contacts::{ContactStatus, statuses};
use super::independent::{Partition, SingularCoordinate};
use super::search::scales;
use super::variation::{ColumnBlock, Numbers, RowBlock, Variation};
use super::{AnalysisFailure, OperatingPoint};

/// A state, input or output, and its value at the point.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpaceSignal {
    pub name: String,
    pub unit: Unit,
    pub value: f64,
    /// The usual size of a state of the scene, SI; 1 of all else.
    pub size: f64,
}

#[derive(Clone, Debug)]
pub struct StateSpace {
    /// When \[s\].
    pub time: f64,
    /// Independent coordinates, their rates, the states of the scene, then positions and rates of drivers that integrate an input.
    pub states: Vec<StateSpaceSignal>,
    /// dx/dt at the point itself, beside which A x + B u are changes: zero at rest.
    pub rates: Vec<f64>,
    /// The inputs, then those of their time derivatives that a driver passes on.
    pub inputs: Vec<StateSpaceSignal>,
    pub outputs: Vec<StateSpaceSignal>,
    /// d(dx/dt)/dx
    pub a: DMatrix<f64>,
    /// d(dx/dt)/du
    pub b: DMatrix<f64>,
    /// dy/dx
    pub c: DMatrix<f64>,
    /// dy/du
    pub d: DMatrix<f64>,
    /// How all coordinates follow the independent ones.
    pub shape: DMatrix<f64>,
    /// What is held on one side only, as it is at the point.
    pub statuses: Vec<ContactStatus>,
    pub(super) partition: Partition,
}

impl StateSpace {
    /// Linearises at a point. `like` is a system of the same mechanism elsewhere: its states are kept if they are suitable here.
    ///
    /// # Errors
    /// The pose is singular, or an equation has no derivative there.
    pub fn new(
        formulated: &Formulated,
        variation: &Variation,
        point: &OperatingPoint,
        like: Option<&StateSpace>,
    ) -> Result<Self, AnalysisFailure> {
        if let Some(failure) = variation.together(&formulated.equations, point, formulated.lowered.program.length) {
            return Err(failure);
        }
        if let Some(symbol) = variation.discontinuity(&formulated.equations, point, &scales(formulated)) {
            let what = format!(
                "a piecewise law (`sign`, `if`, `abs`, `min`, `max`, `floor`) changes at this value of `{}`; use a point beside it, or a smooth law, such as `tanh(v/0.01)` for `sign(v)`",
                signal(formulated, point, symbol).name
            );
            return Err(AnalysisFailure::NoDerivative { time: point.time(), what });
        }
        let numbers = variation.motion_at(&formulated.equations, point)?;
        let partition = partition(formulated, &numbers, like.map(|other| &other.partition));
        let singular = |SingularCoordinate(index): SingularCoordinate| AnalysisFailure::Singular {
            time: point.time(),
            coordinate: formulated.lowered.program.coordinates[index].name.clone(),
        };
        let partition = partition.map_err(singular)?;
        let basis = Basis::new(formulated, variation, &partition);
        let motion = basis.motion(&numbers, &partition).ok_or_else(|| singular(SingularCoordinate(0)))?;
        let (states, count) = (basis.states.len(), basis.states.len() + basis.inputs.len());
        let mut rates = DMatrix::zeros(states, count);
        for (row, &state) in basis.states.iter().enumerate() {
            rates.row_mut(row).copy_from(&basis.rate(formulated, state, &motion));
        }
        let outputs = basis.outputs(&numbers, &motion).map(defined);
        let split = |matrix: &DMatrix<f64>| {
            (matrix.columns(0, states).into_owned(), matrix.columns(states, count - states).into_owned())
        };
        let ((a, b), (c, d)) = (split(&rates), split(&outputs));
        let mechanical = basis.layout.coordinates();
        let moving = partition.independent.iter().filter(|index| mechanical.contains(index)).count();
        let shape = motion.positions.view((0, 0), (mechanical.len(), moving)).into_owned();
        let signals = |symbols: &[Symbol]| symbols.iter().map(|&symbol| signal(formulated, point, symbol)).collect();
        Ok(StateSpace {
            time: point.time(),
            states: signals(&basis.states),
            rates: basis.states.iter().map(|&state| point.value(derivative(formulated, state))).collect(),
            inputs: signals(&basis.inputs),
            outputs: output_signals(formulated, &numbers),
            a,
            b,
            c,
            d,
            shape,
            statuses: statuses(formulated, point),
            partition,
        })
    }

    /// The same for inputs that are held from one instant to the next, `step` seconds later: x of the next instant is A x + B u, exactly, also where A is
    /// singular: both are blocks of exp(\[A B; 0 0\] step).
    ///
    /// # Errors
    /// The states over that step leave the range of numbers.
    pub fn held(mut self, step: f64) -> Result<Self, AnalysisFailure> {
        let (states, inputs) = (self.states.len(), self.inputs.len());
        let mut whole = DMatrix::zeros(states + inputs, states + inputs);
        whole.view_mut((0, 0), (states, states)).copy_from(&(&self.a * step));
        whole.view_mut((0, states), (states, inputs)).copy_from(&(&self.b * step));
        let whole = whole.exp();
        if whole.iter().any(|entry| !entry.is_finite()) {
            return Err(AnalysisFailure::Range);
        }
        self.a = whole.view((0, 0), (states, states)).into_owned();
        self.b = whole.view((0, states), (states, inputs)).into_owned();
        Ok(self)
    }

    /// The outputs, and for each of them a number that is none if it has a value, but not all derivatives.
    pub(super) fn gaps(&self) -> Vec<f64> {
        let derivatives = (self.c.row_iter().zip(self.d.row_iter())).zip(&self.outputs).map(|((c, d), output)| {
            let all = c.iter().chain(d.iter()).all(|entry| entry.is_finite());
            if all || output.value.is_nan() { 0.0 } else { f64::NAN }
        });
        self.outputs.iter().map(|output| output.value).chain(derivatives).collect()
    }
}

/// Independent coordinates of a pose: those of another point if they serve here.
fn partition(
    formulated: &Formulated,
    numbers: &Numbers,
    like: Option<&Partition>,
) -> Result<Partition, SingularCoordinate> {
    let constraints = &formulated.lowered.program.constraints;
    let scales = scales(formulated);
    let mut jacobian = numbers.block(RowBlock::Loops, ColumnBlock::Positions);
    for (mut row, constraint) in jacobian.row_iter_mut().zip(numbers.rows()) {
        row /= constraints[constraint].scale;
    }
    for (mut column, scale) in jacobian.column_iter_mut().zip(scales) {
        column *= scale;
    }
    let best = Partition::new(&jacobian)?;
    Ok(like.filter(|other| other.serves(&jacobian)).cloned().unwrap_or(best))
}

/// Variations of the motion, one column for each state and input.
struct MotionChanges {
    positions: DMatrix<f64>,
    rates: DMatrix<f64>,
    accelerations: DMatrix<f64>,
    reactions: DMatrix<f64>,
    /// Changes of the levels of what slides, and of loads that read the motion.
    levels: DMatrix<f64>,
}

struct Basis {
    layout: MotionLayout,
    states: Vec<Symbol>,
    inputs: Vec<Symbol>,
    /// How the signals of the equations vary: one row for each signal, one column for each state and input.
    signals: DMatrix<f64>,
}

impl Basis {
    fn new(formulated: &Formulated, variation: &Variation, partition: &Partition) -> Self {
        let program = &formulated.lowered.program;
        let source_of = |symbol: &Symbol| source(formulated, *symbol);
        let followers = || program.followers.iter().enumerate();
        let layout = formulated.equations.motion_layout();
        let coordinates = |order: Order| {
            // Integrals of states are no states.
            let is_state = move |index| order != Order::Position || layout.coordinates().contains(index);
            let rows = partition.independent.iter().filter(move |index| is_state(index));
            rows.map(move |&i| layout.variable(i).symbol(order))
        };
        let states: Vec<Symbol> = coordinates(Order::Position)
            .chain(coordinates(Order::Velocity))
            .chain(followers().map(|(index, _)| Symbol::Follower(index, Order::Position)))
            .chain(
                followers()
                    .filter(|(_, follower)| follower.order == FollowerOrder::Acceleration)
                    .map(|(index, _)| Symbol::Follower(index, Order::Velocity)),
            )
            .collect();
        let mut derivatives: Vec<Symbol> = variation.signals().iter().map(source_of).collect();
        derivatives.retain(|symbol| matches!(symbol, Symbol::Input(_, Order::Velocity | Order::Acceleration)));
        derivatives.sort_unstable();
        derivatives.dedup();
        let values = (0..program.inputs.len()).map(|index| Symbol::Input(index, Order::Position));
        // Between sample times sampled values are inputs; no other discrete variable is one.
        let sampled = formulated.equations.system.mechanism.discrete_variables();
        let sampled = sampled.filter(|(_, discrete)| discrete.kind == DiscreteKind::Sampled);
        let sampled = sampled.map(|(id, _)| Symbol::Discrete(id.0));
        let inputs: Vec<Symbol> = values.chain(sampled).chain(derivatives).collect();
        let columns: Vec<Symbol> = states.iter().chain(&inputs).copied().collect();
        let rows = variation.signals();
        let same = |row: usize, column: usize| f64::from(u8::from(source_of(&rows[row]) == columns[column]));
        let signals = DMatrix::from_fn(rows.len(), columns.len(), same);
        Basis { layout, states, inputs, signals }
    }

    /// Varies the loop equations, their rates, and the equations of motion; `None` in a singular pose.
    fn motion(&self, numbers: &Numbers, partition: &Partition) -> Option<MotionChanges> {
        let Partition { independent, dependent } = partition;
        let jacobian = numbers.block(RowBlock::Loops, ColumnBlock::Positions);
        let (n, count) = (jacobian.ncols(), self.signals.ncols());
        let held = jacobian.select_columns(dependent);
        let mechanical = self.layout.coordinates();
        let moving: Vec<usize> = independent.iter().copied().filter(|index| mechanical.contains(index)).collect();
        // Columns of the independent coordinates and rates are unit columns; the dependent ones follow.
        let complete = |first: usize, rows: &[usize], rest: DMatrix<f64>| {
            let mut all = DMatrix::zeros(n, count);
            for (column, &row) in rows.iter().enumerate() {
                all[(row, first + column)] = 1.0;
            }
            let gap = &jacobian * &all + rest;
            let followed = solve(held.clone(), &-gap)?;
            for (row, values) in dependent.iter().zip(followed.row_iter()) {
                all.row_mut(*row).copy_from(&values);
            }
            Some(all)
        };
        let positions = complete(0, &moving, numbers.block(RowBlock::Loops, ColumnBlock::Signals) * &self.signals)?;
        let turning = numbers.block(RowBlock::Rates, ColumnBlock::Positions) * &positions
            + numbers.block(RowBlock::Rates, ColumnBlock::Signals) * &self.signals;
        let rates = complete(moving.len(), independent, turning)?;
        let system = numbers.system();
        let m = jacobian.nrows();
        let levels = system.nrows() - n - m;
        let mut right = DMatrix::zeros(n + m + levels, count);
        for (first, size, row) in
            [(0, n, RowBlock::Motion), (n, m, RowBlock::Accelerations), (n + m, levels, RowBlock::Levels)]
        {
            let change = numbers.block(row, ColumnBlock::Positions) * &positions
                + numbers.block(row, ColumnBlock::Rates) * &rates
                + numbers.block(row, ColumnBlock::Signals) * &self.signals;
            right.rows_mut(first, size).copy_from(&-change);
        }
        let solution = solve(system, &right)?;
        let [accelerations, reactions, levels] =
            [(0, n), (n, m), (n + m, levels)].map(|(first, size)| solution.rows(first, size).into_owned());
        Some(MotionChanges { positions, rates, accelerations, reactions, levels })
    }

    fn outputs(&self, numbers: &Numbers, motion: &MotionChanges) -> DMatrix<f64> {
        let of = |column: ColumnBlock| numbers.block(RowBlock::Outputs, column);
        of(ColumnBlock::Positions) * &motion.positions
            + of(ColumnBlock::Rates) * &motion.rates
            + of(ColumnBlock::Accelerations) * &motion.accelerations
            + of(ColumnBlock::Reactions) * &motion.reactions
            + of(ColumnBlock::Levels) * &motion.levels
            + of(ColumnBlock::Signals) * &self.signals
    }

    fn rate(&self, formulated: &Formulated, state: Symbol, motion: &MotionChanges) -> nalgebra::RowDVector<f64> {
        match state {
            Symbol::Coordinate(index, Order::Position) => motion.rates.row(index).into_owned(),
            Symbol::Coordinate(index, _) => motion.accelerations.row(index).into_owned(),
            Symbol::State(index, _) => motion.accelerations.row(self.layout.state(index)).into_owned(),
            Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Reaction(_)
            | Symbol::Missing(..)
            | Symbol::Argument => {
                let wanted = derivative(formulated, state);
                let columns = self.states.iter().chain(&self.inputs);
                let entries = columns.map(|&column| f64::from(u8::from(column == wanted)));
                nalgebra::RowDVector::from_iterator(self.signals.ncols(), entries)
            }
        }
    }
}

/// The signal that is the derivative of a state by time.
fn derivative(formulated: &Formulated, state: Symbol) -> Symbol {
    let next = |order: Order| if order == Order::Position { Order::Velocity } else { Order::Acceleration };
    match state {
        Symbol::Coordinate(index, order) => Symbol::Coordinate(index, next(order)),
        Symbol::State(index, order) => Symbol::State(index, next(order)),
        Symbol::Follower(index, order) => source(formulated, Symbol::Follower(index, next(order))),
        // No state.
        Symbol::Time
        | Symbol::Parameter(_)
        | Symbol::Discrete(_)
        | Symbol::Input(..)
        | Symbol::Reaction(_)
        | Symbol::Missing(..)
        | Symbol::Argument => state,
    }
}

/// X of A X = B with a square matrix, which may be empty.
fn solve(a: DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if a.is_empty() { Some(b.clone()) } else { a.lu().solve(b) }
}

/// The state or input behind a signal: the rate of a driver that follows an input is that input.
fn source(formulated: &Formulated, symbol: Symbol) -> Symbol {
    let Symbol::Follower(index, order) = symbol else { return symbol };
    let follower = &formulated.lowered.program.followers[index];
    let input = follower.input as usize;
    match (follower.order, order) {
        (_, Order::Position) | (FollowerOrder::Acceleration, Order::Velocity) => symbol,
        (FollowerOrder::Velocity, Order::Velocity) | (FollowerOrder::Acceleration, Order::Acceleration) => {
            Symbol::Input(input, Order::Position)
        }
        (FollowerOrder::Velocity, Order::Acceleration) => Symbol::Input(input, Order::Velocity),
    }
}

fn signal(formulated: &Formulated, point: &OperatingPoint, symbol: Symbol) -> StateSpaceSignal {
    let equations = &formulated.equations;
    let mechanism = &equations.system.mechanism;
    let kind = |angular: bool| if angular { Unit::angle() } else { Unit::length() };
    let (name, unit, order) = match symbol {
        Symbol::Coordinate(index, order) => {
            let coordinate = &equations.coordinates[index];
            let names = &coordinate.name;
            let name = if order == Order::Position { &names.position } else { &names.rate };
            (name.clone(), kind(coordinate.angular), order)
        }
        Symbol::Follower(index, order) => {
            let driver = &mechanism.drivers[equations.system.followers[index].0.0];
            let word = if order == Order::Position { "position" } else { "rate" };
            (format!("{}.{word}", driver.name), kind(driver.is_angular()), order)
        }
        Symbol::State(index, order) => {
            let state = &mechanism.states[index];
            (state.name.clone(), state.unit.clone(), order)
        }
        Symbol::Input(index, order) => {
            let input = &mechanism.inputs[index];
            let name = match order {
                Order::Position => input.name.clone(),
                Order::Velocity => format!("d({})/dt", input.name),
                Order::Acceleration => format!("d2({})/dt2", input.name),
            };
            (name, input.unit.clone(), order)
        }
        Symbol::Discrete(index) => {
            let discrete = &mechanism.discrete[index];
            (discrete.name.clone(), discrete.unit.clone(), Order::Position)
        }
        // No other symbol is varied.
        Symbol::Time | Symbol::Parameter(_) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => {
            (String::new(), Unit::default(), Order::Position)
        }
    };
    let unit = match order {
        Order::Position => unit,
        Order::Velocity => unit.per_second(),
        Order::Acceleration => unit.per_second().per_second(),
    };
    let size = if let Symbol::State(index, _) = symbol { mechanism.states[index].nominal } else { 1.0 };
    StateSpaceSignal { name, unit, value: point.value(symbol), size }
}

/// Not a number where something has no finite value.
fn defined(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

fn output_signals(formulated: &Formulated, numbers: &Numbers) -> Vec<StateSpaceSignal> {
    let outputs = formulated.outputs.iter();
    let values = numbers.values(RowBlock::Outputs);
    outputs
        .zip(values.iter())
        .map(|(output, &value)| {
            let (name, unit) = (output.name.clone(), output.unit.clone());
            StateSpaceSignal { name, unit, value: defined(value), size: 1.0 }
        })
        .collect()
}
