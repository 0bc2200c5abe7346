//! Derivatives of a motion by parameters and inputs, and of what can be read along it.
//!
//! Where the laws permit, q_p and v_p are continued by their Taylor series. Derivatives at one point come from the tapes of the model, four directions at a time.

use std::iter::once;
use std::ops::Range;

use super::passage::{Columns, Passage, PassageError};
use super::{Happening, Instance, InstanceError};
use crate::integrator::taylor::{order_for, share};
use crate::linalg::lane::{Lane, WIDTH, ZERO};
use crate::machine::ROUNDING;
use crate::math;
use crate::model::Model;
use crate::program::{Layout, Source};
use crate::tape::Tape;
use crate::taylor::{Tangents, VARIED_DIRECTIONS, Variations, variations};

/// What a motion is differentiated with respect to, by its place in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Varied {
    /// A parameter; one that is an initial value changes nothing but the start.
    Parameter(usize),
    /// An input: by as much at all times, unless [`Variational::vary_input`] says otherwise.
    Input(usize),
}

/// How the registers change along a direction, besides those of q, v and discrete variables.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    register: usize,
    /// Of an input that of its rate.
    rate: Option<usize>,
    /// The change at a time \[s\], and how fast it grows from there on.
    from: f64,
    change: [f64; 2],
}

impl Direction {
    fn new(varied: Varied, layout: &Layout) -> Self {
        let (register, rate) = match varied {
            Varied::Parameter(index) => (layout.parameters() + index, None),
            Varied::Input(index) => (layout.inputs() + index, Some(layout.input_rates() + index)),
        };
        Direction { register, rate, from: 0.0, change: [1.0, 0.0] }
    }

    /// The registers that change, and by how much at a time.
    pub(super) fn changes(self, time: f64) -> impl Iterator<Item = (usize, f64)> {
        let Direction { register, rate, from, change: [change, growth] } = self;
        once((register, change + (time - from) * growth)).chain(rate.map(|rate| (rate, growth)))
    }
}

/// Derivatives of one motion by several parameters. Matrices have a column for each direction, one after the other.
#[derive(Debug)]
pub struct Variational {
    directions: Vec<Direction>,
    /// The registers of discrete variables, and how these change: a column for each parameter. Between instants they stay as they are.
    discrete: Range<usize>,
    discrete_values: Vec<f64>,
    /// Eight parameters each; none if there are no such series.
    groups: Vec<Group>,
    order: usize,
    tolerance: f64,
    /// The tangents of a whole register file.
    tangents: Vec<Lane>,
    solved: Vec<Lane>,
    /// Where accelerations and reactions are among the registers.
    results: Range<usize>,
}

/// The series of a motion with its derivatives by some parameters.
#[derive(Debug)]
struct Group {
    series: Box<dyn Variations>,
    tangents: Tangents,
    /// The parameters.
    places: Range<usize>,
    /// Are the coefficients those of the present parameters?
    entered: bool,
}

impl Variational {
    /// For motions of a model; the series are found to this tolerance.
    pub fn new(model: &Model, varied: &[Varied], tolerance: f64) -> Self {
        let (program, layout) = (model.program(), model.layout());
        let is_continued = !program.is_driven() && program.followers.is_empty();
        let has_series = is_continued && program.tapes.indicators.results.is_empty();
        let firsts = (0..varied.len()).step_by(VARIED_DIRECTIONS).take_while(|_| has_series);
        let groups = firsts.filter_map(|first| {
            let places = first..varied.len().min(first + VARIED_DIRECTIONS);
            let tangents = std::array::from_fn(|_| vec![ZERO; program.registers as usize]);
            Some(Group { series: variations(model, places.len())?, tangents, places, entered: false })
        });
        Self {
            directions: varied.iter().map(|&varied| Direction::new(varied, layout)).collect(),
            discrete_values: vec![0.0; program.discrete.len() * varied.len()],
            discrete: layout.discrete()..layout.inputs(),
            groups: groups.collect(),
            order: order_for(tolerance),
            tolerance: share(tolerance),
            tangents: vec![ZERO; program.registers as usize],
            solved: vec![ZERO; program.tapes.acceleration.results.len()],
            results: layout.accelerations()..layout.constants(),
        }
    }

    /// From a time on \[s\] the input that a column varies changes by so much, and that at this rate.
    pub fn vary_input(&mut self, column: usize, time: f64, change: [f64; 2]) {
        let direction = &mut self.directions[column];
        (direction.from, direction.change) = (time, change);
    }

    /// How discrete variables change at the start of a motion, with these q_p and v_p.
    ///
    /// # Errors
    /// Why there are no derivatives there.
    pub fn begin_discrete(&mut self, motion: &Instance, state: [&[f64]; 2]) -> Result<(), PassageError> {
        let mut columns =
            Columns::new(motion.model.coordinates(), self.discrete.len(), [state[0], state[1], &self.discrete_values]);
        self.passage(&motion.model, 0.0).begin(&motion.now.state, &mut columns)?;
        self.discrete_values = columns.discrete_values;
        Ok(())
    }

    /// Carries q_p and v_p, and the derivatives of discrete variables, over everything that has happened at one instant of a motion; says how that moves with each parameter. Events are found to this
    /// tolerance.
    ///
    /// # Errors
    /// Why there are no derivatives behind it.
    pub fn pass(
        &mut self,
        model: &Model,
        happened: &[Happening],
        [positions, rates]: [&mut [f64]; 2],
        tolerance: f64,
    ) -> Result<Vec<f64>, PassageError> {
        let mut columns =
            Columns::new(model.coordinates(), self.discrete.len(), [positions, rates, &self.discrete_values]);
        let moves = self.passage(model, tolerance).pass(happened, &mut columns)?;
        positions.copy_from_slice(&columns.positions);
        rates.copy_from_slice(&columns.rates);
        self.discrete_values = columns.discrete_values;
        // What is open or closed is among the coefficients.
        self.groups.iter_mut().for_each(|group| group.entered = false);
        Ok(moves)
    }

    fn passage<'a>(&'a self, model: &'a Model, tolerance: f64) -> Passage<'a> {
        Passage { model, parameters: &self.directions, tolerance }
    }

    /// How discrete variables change: a column for each parameter.
    pub fn discrete_values(&self) -> &[f64] {
        &self.discrete_values
    }

    /// Begins the series at the present state of a motion, with these q_p and v_p, of which the largest of each direction have reached so far: errors count relative to that. Says how long a step they permit, up to a limit; none where there are none, because of the laws
    /// or of the pose.
    ///
    /// # Errors
    /// Those of [`Instance::get`].
    pub fn begin(
        &mut self,
        motion: &mut Instance,
        state: [&[f64]; 2],
        reached: &[f64],
        limit: f64,
    ) -> Result<Option<f64>, InstanceError> {
        if self.groups.is_empty() {
            return Ok(None);
        }
        motion.load()?;
        let mut length = limit;
        for group in &mut self.groups {
            group.load(motion, &self.directions, state, (self.discrete.clone(), &self.discrete_values));
            let registers = motion.machine.registers();
            let reached = &reached[group.places.clone()];
            if !group.series.begin(&motion.model, self.order, registers, &group.tangents, reached) {
                return Ok(None);
            }
            length = length.min(group.series.step_length(self.order, self.tolerance, limit));
        }
        Ok(Some(length))
    }

    /// q_p and v_p so long after the series began.
    pub fn continued(&mut self, dt: f64, [positions, rates]: [&mut [f64]; 2]) {
        let n = positions.len() / self.directions.len().max(1);
        for Group { series, places, .. } in &mut self.groups {
            series.continued(self.order, dt, &mut |index, direction, tangent| {
                let column = places.start + direction;
                if column < places.end {
                    let target =
                        if index < n { &mut positions[column * n + index] } else { &mut rates[column * n + index - n] };
                    *target = tangent;
                }
            });
        }
    }

    /// By how much the accelerations that the series continued so long differ from those at which the series that have begun since start, in the motion and its derivatives, as a
    /// multiple of what the tolerance permits.
    pub fn defect(&self, dt: f64) -> f64 {
        let defects = self.groups.iter().map(|group| group.series.defect(self.order, dt));
        // Rounding errors leave 4e-14 of a defect (Andrews' mechanism and the double pendulum).
        defects.fold(0.0, math::maximum) / self.tolerance.max(ROUNDING)
    }

    /// How accelerations change with each coordinate, each rate and each parameter, everything else the same.
    ///
    /// # Errors
    /// Those of [`Instance::get`].
    pub fn accelerations(&mut self, motion: &mut Instance, matrix: &mut [f64]) -> Result<(), InstanceError> {
        let layout = *motion.model.layout();
        let n = motion.model.coordinates();
        let (first, time) = (layout.positions(), motion.time());
        let all: Vec<usize> = (0..2 * n + self.directions.len()).collect();
        for (four, columns) in all.chunks(WIDTH).zip(matrix.chunks_mut(WIDTH * n)) {
            self.tangents.fill(ZERO);
            for (place, &index) in four.iter().enumerate() {
                let Some(column) = index.checked_sub(2 * n) else {
                    self.tangents[first + index][place] = 1.0;
                    continue;
                };
                let discrete = discrete_of((self.discrete.clone(), &self.discrete_values), column);
                for (register, tangent) in self.directions[column].changes(time).chain(discrete) {
                    self.tangents[register][place] = tangent;
                }
            }
            self.accelerate(motion)?;
            for (place, column) in columns.chunks_mut(n).enumerate() {
                column.iter_mut().zip(&self.solved).for_each(|(target, lane)| *target = lane[place]);
            }
        }
        Ok(())
    }

    /// How variables change with each parameter, with these q_p and v_p: a row for each variable, not a number where it has no finite derivative. A driven mechanism needs neither.
    /// Where the time itself moves with the parameters, by so much with each, q_p and v_p are those along with it.
    ///
    /// # Errors
    /// Those of [`Instance::get`].
    pub fn outputs(
        &mut self,
        motion: &mut Instance,
        state: [&[f64]; 2],
        moves: Option<&[f64]>,
        variables: &[usize],
        derivatives: &mut [f64],
    ) -> Result<(), InstanceError> {
        if motion.model.is_driven() {
            return self.driven(motion, variables, derivatives);
        }
        let time = motion.time();
        for first in (0..self.directions.len()).step_by(WIDTH) {
            self.tangents.fill(ZERO);
            let columns = first..self.directions.len().min(first + WIDTH);
            for (place, column) in columns.clone().enumerate() {
                for (register, tangent) in changes(&motion.model, self.directions[column].changes(time), column, state)
                    .chain(discrete_of((self.discrete.clone(), &self.discrete_values), column))
                {
                    self.tangents[register][place] = tangent;
                }
                if let Some(moves) = moves {
                    given_rates(motion)
                        .for_each(|(register, rate)| self.tangents[register][place] += rate * moves[column]);
                }
            }
            self.accelerate(motion)?;
            let tape = &motion.model.program().tapes.outputs;
            motion.machine.run_tangents(tape, &mut self.tangents);
            for (row, &variable) in variables.iter().enumerate() {
                let lane = self.tangents[motion.register(variable, tape)];
                for (place, column) in columns.clone().enumerate() {
                    derivatives[column * variables.len() + row] =
                        if lane[place].is_finite() { lane[place] } else { f64::NAN };
                }
            }
        }
        Ok(())
    }

    /// Those of accelerations and reactions along the directions.
    fn accelerate(&mut self, motion: &mut Instance) -> Result<(), InstanceError> {
        motion.accelerate()?;
        motion.load()?;
        let tapes = &motion.model.program().tapes;
        motion.machine.run_tangents(&tapes.parameters, &mut self.tangents);
        motion.machine.run_tangents(&tapes.acceleration, &mut self.tangents);
        for (place, &register) in self.solved.iter_mut().zip(&tapes.acceleration.results) {
            *place = self.tangents[register as usize];
        }
        self.tangents[self.results.clone()].copy_from_slice(&self.solved);
        Ok(())
    }

    /// The loops alone determine the derivatives.
    fn driven(&self, motion: &mut Instance, variables: &[usize], derivatives: &mut [f64]) -> Result<(), InstanceError> {
        let time = motion.time();
        for (direction, column) in self.directions.iter().zip(derivatives.chunks_mut(variables.len().max(1))) {
            motion.begin_direction();
            direction.changes(time).for_each(|(register, change)| motion.tangent.direction()[register] = change);
            motion.differentiate()?;
            for (target, &variable) in column.iter_mut().zip(variables) {
                *target = match motion.derivative(variable) {
                    Err(InstanceError::NoDerivative { .. }) => f64::NAN,
                    found => found?,
                };
            }
        }
        Ok(())
    }
}

impl Group {
    /// The directions, with the coefficients of the series where they do not have them yet.
    fn load(
        &mut self,
        motion: &mut Instance,
        directions: &[Direction],
        state: [&[f64]; 2],
        (discrete, values): (Range<usize>, &[f64]),
    ) {
        let time = motion.time();
        for (direction, column) in self.places.clone().enumerate() {
            let (half, place) = (&mut self.tangents[direction / WIDTH], direction % WIDTH);
            let changes = changes(&motion.model, directions[column].changes(time), column, state);
            for (register, tangent) in changes.chain(discrete_of((discrete.clone(), values), column)) {
                half[register][place] = tangent;
            }
        }
        if !self.entered {
            for half in &mut self.tangents {
                motion.machine.run_tangents(&motion.model.program().tapes.parameters, half);
            }
            self.series.enter(motion.machine.registers(), &self.tangents);
            self.entered = true;
        }
    }
}

/// How fast the time and the inputs change.
fn given_rates(motion: &Instance) -> impl Iterator<Item = (usize, f64)> + use<> {
    let (layout, state) = (*motion.model.layout(), motion.state());
    let inputs = (0..motion.model.program().inputs.len()).flat_map(move |input| {
        let [_, rate, acceleration] = state.input_polynomial(input);
        [(layout.inputs() + input, rate), (layout.input_rates() + input, acceleration)]
    });
    once((layout.time(), 1.0)).chain(inputs)
}

/// How discrete variables change with a parameter.
fn discrete_of(
    (discrete, values): (Range<usize>, &[f64]),
    column: usize,
) -> impl Iterator<Item = (usize, f64)> + use<'_> {
    let count = discrete.len();
    discrete.zip(values[column * count..][..count].iter().copied())
}

/// The registers that change with a parameter at a point, and by how much: its own, and those of q and v.
fn changes<'a, I: Iterator<Item = (usize, f64)>>(
    model: &Model,
    direction: I,
    column: usize,
    [positions, rates]: [&'a [f64]; 2],
) -> impl Iterator<Item = (usize, f64)> + use<'a, I> {
    let (layout, n) = (model.layout(), model.coordinates());
    let changes_of = |first: usize, all: &'a [f64]| (first..).zip(all[column * n..][..n].iter().copied());
    direction.chain(changes_of(layout.positions(), positions)).chain(changes_of(layout.rates(), rates))
}

impl Instance {
    /// The register of a variable after a tape of outputs has run.
    fn register(&self, variable: usize, outputs: &Tape) -> usize {
        let layout = self.model.layout();
        match self.model.program().variables[variable].source {
            Source::Time => layout.time(),
            Source::Parameter(index) => layout.parameters() + index as usize,
            Source::Input(index) => layout.inputs() + index as usize,
            Source::Discrete(index) => layout.discrete() + index as usize,
            Source::Coordinate(index) => layout.positions() + index as usize,
            Source::Rate(index) => layout.rates() + index as usize,
            Source::Acceleration(index) => layout.accelerations() + index as usize,
            Source::Output { result, .. } => outputs.results[result as usize] as usize,
        }
    }
}
