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
use crate::program::Source;
use crate::tape::Tape;
use crate::taylor::{Tangents, VARIED_DIRECTIONS, Variations, variations};

/// What a motion is differentiated with respect to, by its place in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Varied {
    /// A parameter; one that is an initial value changes nothing but the start.
    Parameter(usize),
    /// An input that stays as it is.
    Input(usize),
}

/// Derivatives of one motion by several parameters. Matrices have a column for each direction, one after the other.
#[derive(Debug)]
pub struct Variational {
    /// The register of each parameter.
    registers: Vec<usize>,
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
        let register = |varied: &Varied| match varied {
            Varied::Parameter(index) => layout.parameters() + index,
            Varied::Input(index) => layout.inputs() + index,
        };
        let is_continued = !program.is_driven() && program.followers.is_empty();
        let has_series = is_continued && program.tapes.indicators.results.is_empty();
        let firsts = (0..varied.len()).step_by(VARIED_DIRECTIONS).take_while(|_| has_series);
        let groups = firsts.filter_map(|first| {
            let places = first..varied.len().min(first + VARIED_DIRECTIONS);
            let tangents = std::array::from_fn(|_| vec![ZERO; program.registers as usize]);
            Some(Group { series: variations(model, places.len())?, tangents, places, entered: false })
        });
        Self {
            registers: varied.iter().map(register).collect(),
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
        Passage { model, parameters: &self.registers, tolerance }
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
            group.load(motion, &self.registers, state, (self.discrete.clone(), &self.discrete_values));
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
        let n = positions.len() / self.registers.len().max(1);
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
        let direction = (layout.positions()..layout.positions() + 2 * n).chain(self.registers.clone());
        let directions: Vec<usize> = direction.collect();
        for (four, columns) in directions.chunks(WIDTH).zip(matrix.chunks_mut(WIDTH * n)) {
            self.tangents.fill(ZERO);
            for (place, &register) in four.iter().enumerate() {
                self.tangents[register][place] = 1.0;
                let parameter = self.registers.iter().position(|parameter_register| *parameter_register == register);
                let changes =
                    parameter.map(|column| discrete_of((self.discrete.clone(), &self.discrete_values), column));
                for (register, tangent) in changes.into_iter().flatten() {
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
    ///
    /// # Errors
    /// Those of [`Instance::get`].
    pub fn outputs(
        &mut self,
        motion: &mut Instance,
        state: [&[f64]; 2],
        variables: &[usize],
        derivatives: &mut [f64],
    ) -> Result<(), InstanceError> {
        if motion.model.is_driven() {
            return self.driven(motion, variables, derivatives);
        }
        for first in (0..self.registers.len()).step_by(WIDTH) {
            self.tangents.fill(ZERO);
            let columns = first..self.registers.len().min(first + WIDTH);
            for (place, column) in columns.clone().enumerate() {
                for (register, tangent) in direction(&motion.model, self.registers[column], column, state)
                    .chain(discrete_of((self.discrete.clone(), &self.discrete_values), column))
                {
                    self.tangents[register][place] = tangent;
                }
            }
            self.accelerate(motion)?;
            let tape = &motion.model.program().tapes.outputs;
            motion.machine.run_tangents(tape, &mut self.tangents);
            for (row, &variable) in variables.iter().enumerate() {
                let lane = motion.register(variable, tape).map_or(ZERO, |register| self.tangents[register]);
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
        for (&register, column) in self.registers.iter().zip(derivatives.chunks_mut(variables.len().max(1))) {
            motion.begin_direction();
            motion.tangent.direction()[register] = 1.0;
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
        registers: &[usize],
        state: [&[f64]; 2],
        (discrete, values): (Range<usize>, &[f64]),
    ) {
        for (direction, column) in self.places.clone().enumerate() {
            let (half, place) = (&mut self.tangents[direction / WIDTH], direction % WIDTH);
            let changes = self::direction(&motion.model, registers[column], column, state);
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

/// How discrete variables change with a parameter.
fn discrete_of(
    (discrete, values): (Range<usize>, &[f64]),
    column: usize,
) -> impl Iterator<Item = (usize, f64)> + use<'_> {
    let count = discrete.len();
    discrete.zip(values[column * count..][..count].iter().copied())
}

/// The registers that change with a parameter at a point, and by how much: its own, and those of q and v.
fn direction<'a>(
    model: &Model,
    register: usize,
    column: usize,
    [positions, rates]: [&'a [f64]; 2],
) -> impl Iterator<Item = (usize, f64)> + use<'a> {
    let (layout, n) = (model.layout(), model.coordinates());
    let changes_of = |first: usize, all: &'a [f64]| (first..).zip(all[column * n..][..n].iter().copied());
    once((register, 1.0)).chain(changes_of(layout.positions(), positions)).chain(changes_of(layout.rates(), rates))
}

impl Instance {
    /// The register of a variable after a tape of outputs has run; none of what does not change with the parameters.
    fn register(&self, variable: usize, outputs: &Tape) -> Option<usize> {
        let layout = self.model.layout();
        Some(match self.model.program().variables[variable].source {
            Source::Time => return None,
            Source::Parameter(index) => layout.parameters() + index as usize,
            Source::Input(index) => layout.inputs() + index as usize,
            Source::Discrete(index) => layout.discrete() + index as usize,
            Source::Coordinate(index) => layout.positions() + index as usize,
            Source::Rate(index) => layout.rates() + index as usize,
            Source::Acceleration(index) => layout.accelerations() + index as usize,
            Source::Output { result, .. } => outputs.results[result as usize] as usize,
        })
    }
}
