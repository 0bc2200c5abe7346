//! Everything that must hold before a program is run.
//!
//! Must: every register, index and count fits, so that running cannot fail; no tape reads what nobody has written, or
//! what its caller does not provide; no tape destroys the constants or the parameter stage; every number is finite,
//! every scale positive; names are there and unique.

use std::collections::HashSet;

use thiserror::Error;

use crate::program::contour::Slot;
use crate::program::{
    Condition, Contact, ContactState, Contacts, Engine, Initial, Instants, Layout, Program, Role, Source, SparseTape,
    Target, Write,
};
use crate::tape::Tape;

/// What is wrong with a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProgramError {
    /// NaN, infinite, or not positive where it must be, or outside its bounds.
    #[error("{what} has an impossible value")]
    Value {
        /// Whose value.
        what: String,
    },
    /// Anything else, as a message: no exporter writes such a program.
    #[error("{0}")]
    Damaged(String),
}

impl ProgramError {
    fn name(what: &str, name: &str) -> Self {
        ProgramError::Damaged(format!("{what}: the name `{name}` is empty or used twice"))
    }

    /// A variable, follower or contact points nowhere.
    fn reference(name: &str) -> Self {
        ProgramError::Damaged(format!("`{name}` refers to something that is not there"))
    }

    /// A register outside the file, or one that must not be written.
    fn register(tape: &str, register: u32) -> Self {
        ProgramError::Damaged(format!("tape `{tape}` uses register {register}, which it must not"))
    }

    /// A register is read before anything is in it.
    fn undefined(tape: &str, register: u32) -> Self {
        ProgramError::Damaged(format!("tape `{tape}` reads register {register} before it is written"))
    }
}

impl Program {
    /// Checks the whole program.
    pub fn check(&self) -> Result<(), ProgramError> {
        self.check_positions()?;
        let constrained = self.constraints.iter().any(|constraint| constraint.is_imposed());
        self.check_motion_counts(constrained)?;
        self.check_arms()
    }

    fn check_arms(&self) -> Result<(), ProgramError> {
        let fault = |what: &str| Err(ProgramError::Damaged(format!("the arm form is damaged: {what}")));
        if self.arms.is_none() && self.engine == Engine::Taylor {
            return fault("there is none");
        }
        if self.arms.is_some() && self.masses.is_some() {
            return fault("there are two");
        }
        let Some(form) = self.arms.as_ref().or(self.masses.as_ref()) else { return Ok(()) };
        if !form.coefficients.instructions().is_empty() {
            return fault("its coefficients");
        }
        form.check(self).or_else(fault)
    }

    /// Checks what the analysis of positions reads, before the kernels of the motion exist: everything but the numbers of results
    /// of the remaining tapes.
    pub fn check_positions(&self) -> Result<(), ProgramError> {
        self.check_names()?;
        self.check_values()?;
        self.check_references()?;
        self.check_registers()?;
        self.check_position_counts()
    }

    fn check_names(&self) -> Result<(), ProgramError> {
        let named = |what, name: &String| match name.is_empty() {
            true => Err(ProgramError::name(what, name)),
            false => Ok(()),
        };
        named("scene", &self.name)?;
        named("GUID", &self.guid)?;
        self.followers.iter().try_for_each(|follower| named("driver", &follower.name))?;
        self.constraints.iter().try_for_each(|constraint| named("joint", &constraint.owner))?;
        self.initial.positions.iter().try_for_each(|condition| named("initial value", &condition.name))?;
        self.initial.velocities.iter().try_for_each(|condition| named("initial value", &condition.name))?;
        unique("parameter", self.parameters.iter().map(|parameter| &parameter.name))?;
        self.instants.samplers.iter().try_for_each(|sampler| named("sampler", &sampler.name))?;
        unique("event", self.instants.events.iter().map(|event| &event.name))?;
        unique("contact", self.instants.contacts().iter().map(|contact| &contact.name))?;
        unique("discrete variable", self.discrete.iter().map(|discrete| &discrete.name))?;
        unique("input", self.inputs.iter().map(|input| &input.name))?;
        unique("coordinate", self.coordinates.iter().map(|coordinate| &coordinate.name))?;
        unique("variable", self.variables.iter().map(|variable| &variable.name))
    }

    fn check_values(&self) -> Result<(), ProgramError> {
        let value = |holds: bool, what: &str| match holds {
            true => Ok(()),
            false => Err(ProgramError::Value { what: what.to_owned() }),
        };
        value(self.states as usize <= self.coordinates.len(), "the number of states")?;
        let positive = |number: f64| number > 0.0 && number.is_finite();
        let times = &self.experiment;
        value(times.start.is_finite() && times.stop.is_finite() && times.stop >= times.start, "the experiment")?;
        value(
            positive(times.step) && positive(times.tolerance) && times.max_step > 0.0 && times.budget > 0.0,
            "the experiment",
        )?;
        value(positive(self.length), "the length of the mechanism")?;
        value(self.constants.iter().all(|constant| constant.is_finite()), "a constant")?;
        for parameter in &self.parameters {
            value(within(parameter.start, parameter.min, parameter.max), &parameter.name)?;
        }
        for discrete in &self.discrete {
            value(discrete.start.is_finite(), &discrete.name)?;
        }
        for input in &self.inputs {
            value(within(input.start, input.min, input.max), &input.name)?;
        }
        let scales = (self.coordinates.iter().map(|coordinate| (coordinate.scale, &coordinate.name)))
            .chain(self.followers.iter().map(|follower| (follower.scale, &follower.name)))
            .chain(self.constraints.iter().map(|constraint| (constraint.scale, &constraint.owner)))
            .chain(self.conditions().map(|condition| (condition.scale, &condition.name)));
        for (scale, name) in scales {
            value(positive(scale), name)?;
        }
        let unknowns = self.coordinates.len() + self.followers.len();
        let Initial { first_positions, first_rates, found_positions, found_rates, .. } = &self.initial;
        let first = [first_positions, first_rates, found_positions, found_rates];
        let serves = |values: &Vec<f64>| values.is_empty() || values.len() == unknowns;
        value(first.iter().all(|values| serves(values)), "the number of first values")?;
        value(first.into_iter().flatten().all(|value| value.is_finite()), "a first value")
    }

    fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.initial.positions.iter().chain(&self.initial.velocities)
    }

    fn check_references(&self) -> Result<(), ProgramError> {
        for follower in &self.followers {
            if follower.input as usize >= self.inputs.len() {
                return Err(ProgramError::reference(&follower.name));
            }
        }
        let is_discrete = |place: u32| (place as usize) < self.discrete.len();
        let Instants { begin, written, .. } = &self.instants;
        let is_target = |write: &Write| match self.target(*write) {
            Target::Discrete(_) => true,
            Target::State(state) => state < self.states as usize,
        };
        let is_there = |write: &Write| is_target(write) && (write.result as usize) < written.results.len();
        if begin.results.len() > self.discrete.len() || !self.instants.writes().all(is_there) {
            return Err(ProgramError::reference("what is written"));
        }
        let is_masked = |row: &u32| {
            let row = self.constraints.get(*row as usize);
            row.is_some_and(|row| row.role.is_masked())
        };
        let masks = self.instants.masks.iter().all(|(row, mask)| is_masked(row) && is_discrete(*mask));
        let removes = self.instants.events.iter().flat_map(|event| &event.removes).all(|removed| is_discrete(*removed));
        let places = self.constraints.iter().flat_map(|row| row.role.places()).all(is_discrete);
        let has_impulses =
            self.instants.contacts.is_some() || self.constraints.iter().all(|row| row.role.places().next().is_none());
        if !masks || !removes || !places || !has_impulses {
            return Err(ProgramError::reference("what does not always hold"));
        }
        let has_sizes = |all: &Contacts| all.row_sizes.results.len() == self.tapes.reciprocal_pivots.len();
        if !self.instants.contacts.iter().all(has_sizes) {
            return Err(ProgramError::reference("what is redundant"));
        }
        for contact in self.instants.contacts() {
            let row = self.constraints.get(contact.constraint as usize);
            let slip = contact.slip.as_ref();
            let slips = slip.is_none_or(|slip| {
                let sums = slip.sums as usize + contact.state.signs.len();
                (slip.level as usize) < self.constraints.len()
                    && slip.on.is_none_or(|on| (on as usize) < self.instants.contacts().len())
                    && self.instants.contacts.as_ref().is_some_and(|all| sums <= all.pressing.results.len())
            });
            if row.is_none_or(|row| row.role != Role::Contact) || !contact.has_its_state(&is_discrete) || !slips {
                return Err(ProgramError::reference(&contact.name));
            }
        }
        for contour in self.instants.contours() {
            let counts = |slot: &Slot| (slot.contact as usize) < self.instants.contacts().len();
            let held = contour.slots.iter().flat_map(|slot| slot.held).chain(contour.there);
            if !contour.is_sound() || !contour.slots.iter().all(counts) || !held.into_iter().all(is_discrete) {
                return Err(ProgramError::reference(&contour.name));
            }
        }
        for variable in &self.variables {
            let (index, count) = match variable.source {
                Source::Time => (0, 1),
                Source::Parameter(index) => (index, self.parameters.len()),
                Source::Input(index) => (index, self.inputs.len()),
                Source::Discrete(index) => (index, self.discrete.len()),
                Source::Output { result, .. } => (result, self.tapes.outputs.results.len()),
                Source::Coordinate(index) | Source::Rate(index) | Source::Acceleration(index) => {
                    (index, self.coordinates.len())
                }
            };
            let initial = variable.initial.is_none_or(|initial| (initial as usize) < self.parameters.len());
            if index as usize >= count || !initial {
                return Err(ProgramError::reference(&variable.name));
            }
        }
        Ok(())
    }

    fn check_registers(&self) -> Result<(), ProgramError> {
        let layout = self.layout();
        let tapes = &self.tapes;
        let smallest = layout.constants() + self.constants.len();
        let written = self.every_tape().map(|tape| 2 * tape.instructions().len()).sum::<usize>();
        // The upper bound keeps a damaged file from asking for all of the memory.
        if (self.registers as usize) < smallest || self.registers as usize > smallest + written {
            return Err(ProgramError::Damaged(format!(
                "a register file of {} does not fit the program",
                self.registers
            )));
        }
        let mut registers = RegisterCheck::new(self, &layout);
        registers.parameters(&tapes.parameters, &layout)?;
        let (positions, rates) = (layout.rates(), layout.accelerations());
        registers.kernel("constraint", &tapes.constraint, positions)?;
        registers.kernel("jacobian", &tapes.jacobian.tape, positions)?;
        registers.kernel("constraint_rate", &tapes.constraint_rate, rates)?;
        registers.kernel("gamma", &tapes.gamma, rates)?;
        registers.kernel("acceleration", &tapes.acceleration, rates)?;
        registers.left("reciprocal pivots", &tapes.acceleration, &tapes.reciprocal_pivots)?;
        registers.kernel("project_position", &tapes.project_position, positions)?;
        registers.kernel("project_velocity", &tapes.project_velocity, rates)?;
        for form in self.arms.iter().chain(&self.masses) {
            registers.kernel("coefficients", &form.coefficients, layout.inputs())?;
        }
        registers.kernel("indicators", &tapes.indicators, rates)?;
        registers.kernel("laws", &tapes.laws.tape, rates)?;
        registers.kernel("domains", &tapes.domains.tape, rates)?;
        registers.kernel("ranges", &tapes.ranges.tape, layout.inputs())?;
        registers.kernel("outputs", &tapes.outputs, layout.constants())?;
        registers.kernel("begin", &self.instants.begin, rates)?;
        registers.kernel("clocks", &self.instants.clocks, layout.inputs())?;
        registers.kernel("written", &self.instants.written, layout.constants())?;
        registers.kernel("sides", &self.instants.sides, layout.constants())?;
        if let Some(contacts) = &self.instants.contacts {
            registers.kernel("gaps", &contacts.gaps, positions)?;
            registers.kernel("gap rates", &contacts.rates, rates)?;
            registers.kernel("gap accelerations", &contacts.accelerations, layout.reactions())?;
            registers.kernel("restitutions", &contacts.restitutions, rates)?;
            registers.kernel("impact", &contacts.impact, layout.constants())?;
            registers.kernel("pressing", &contacts.pressing, layout.constants())?;
            registers.kernel("locks", &contacts.locks, rates)?;
            registers.kernel("row sizes", &contacts.row_sizes, positions)?;
            if let Some(contours) = &contacts.contours {
                registers.kernel("places at profiles", &contours.places, positions)?;
            }
        }
        registers.kernel("initial position", &self.initial.position, positions)?;
        registers.kernel("initial position jacobian", &self.initial.position_jacobian.tape, positions)?;
        registers.kernel("initial velocity", &self.initial.velocity, rates)?;
        registers.kernel("initial velocity jacobian", &self.initial.velocity_jacobian.tape, rates)?;
        registers.stage_survives()
    }

    fn every_tape(&self) -> impl Iterator<Item = &Tape> {
        let (tapes, initial) = (&self.tapes, &self.initial);
        let contacts = self.instants.contacts.iter();
        let contacts = contacts.flat_map(|contact| {
            let of_gaps =
                [&contact.gaps, &contact.rates, &contact.accelerations, &contact.restitutions, &contact.impact];
            let places = contact.contours.iter().map(|contours| &contours.places);
            of_gaps.into_iter().chain([&contact.pressing, &contact.locks, &contact.row_sizes]).chain(places)
        });
        [
            &tapes.parameters,
            &tapes.constraint,
            &tapes.jacobian.tape,
            &tapes.constraint_rate,
            &tapes.gamma,
            &tapes.acceleration,
            &tapes.project_position,
            &tapes.project_velocity,
            &tapes.indicators,
            &tapes.laws.tape,
            &tapes.domains.tape,
            &tapes.ranges.tape,
            &tapes.outputs,
            &self.instants.begin,
            &self.instants.clocks,
            &self.instants.written,
            &self.instants.sides,
            &initial.position,
            &initial.position_jacobian.tape,
            &initial.velocity,
            &initial.velocity_jacobian.tape,
        ]
        .into_iter()
        .chain(contacts)
    }

    fn check_position_counts(&self) -> Result<(), ProgramError> {
        let (m, columns) = (self.constraints.len(), self.coordinates.len() + self.followers.len());
        let (tapes, initial) = (&self.tapes, &self.initial);
        let (positions, velocities) = (initial.positions.len(), initial.velocities.len());
        results("constraint", &tapes.constraint, m)?;
        sparse("jacobian", &tapes.jacobian, m, columns)?;
        results("constraint_rate", &tapes.constraint_rate, m)?;
        results("initial position", &initial.position, 2 * positions)?;
        sparse("initial position jacobian", &initial.position_jacobian, positions, columns)?;
        results("initial velocity", &initial.velocity, 2 * velocities)?;
        sparse("initial velocity jacobian", &initial.velocity_jacobian, velocities, columns)
    }

    fn check_motion_counts(&self, constrained: bool) -> Result<(), ProgramError> {
        let (n, m) = (self.coordinates.len(), self.constraints.len());
        let tapes = &self.tapes;
        results("laws", &tapes.laws.tape, tapes.laws.kinds.len())?;
        results("domains", &tapes.domains.tape, tapes.domains.domains.len())?;
        results("ranges", &tapes.ranges.tape, tapes.ranges.domains.len())?;
        let Instants { samplers, events, clocks, sides, .. } = &self.instants;
        results("clocks", clocks, 2 * samplers.len())?;
        results("sides", sides, 2 * events.len())?;
        if let Some(contacts) = &self.instants.contacts {
            let count = contacts.all.len();
            results("gaps", &contacts.gaps, count)?;
            results("gap rates", &contacts.rates, count)?;
            results("gap accelerations", &contacts.accelerations, count)?;
            results("restitutions", &contacts.restitutions, count)?;
            results("impact", &contacts.impact, n + m)?;
            if let Some(contours) = &contacts.contours {
                results("places at profiles", &contours.places, 2 * contours.all.len())?;
            }
        }
        results("acceleration", &tapes.acceleration, n + m)?;
        if constrained {
            results("project_position", &tapes.project_position, m + n)?;
            results("project_velocity", &tapes.project_velocity, m + n)?;
        }
        Ok(())
    }
}

fn within(value: f64, min: Option<f64>, max: Option<f64>) -> bool {
    let finite = [Some(value), min, max].into_iter().flatten().all(f64::is_finite);
    finite && min.is_none_or(|min| min <= value) && max.is_none_or(|max| value <= max)
}

fn unique<'a>(what: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), ProgramError> {
    let mut seen = HashSet::new();
    for name in names {
        if name.is_empty() || !seen.insert(name) {
            return Err(ProgramError::name(what, name));
        }
    }
    Ok(())
}

fn results(tape: &'static str, content: &Tape, expected: usize) -> Result<(), ProgramError> {
    let found = content.results.len();
    match found == expected {
        true => Ok(()),
        false => Err(ProgramError::Damaged(format!("tape `{tape}` has {found} results instead of {expected}"))),
    }
}

fn sparse(tape: &'static str, content: &SparseTape, rows: usize, columns: usize) -> Result<(), ProgramError> {
    results(tape, &content.tape, content.entries.len())?;
    let mut seen = HashSet::new();
    for &(row, column) in &content.entries {
        if row as usize >= rows || column as usize >= columns || !seen.insert((row, column)) {
            return Err(ProgramError::Damaged(format!("tape `{tape}` has a wrong matrix entry ({row}, {column})")));
        }
    }
    Ok(())
}

/// Follows the tapes through the register file.
struct RegisterCheck {
    constants: core::ops::Range<usize>,
    /// Written by the parameter stage.
    stage: Vec<bool>,
    /// Read from the parameter stage by a kernel.
    needed: Vec<bool>,
    /// Written by a kernel.
    overwritten: Vec<bool>,
}

impl Contact {
    /// True if it has the discrete variables that its kind needs, and all are there.
    fn has_its_state(&self, is_discrete: &impl Fn(u32) -> bool) -> bool {
        let ContactState { closed, impulse, place, direction, signs } = &self.state;
        let all = [*closed, *impulse].into_iter().chain(*place).chain(*direction).chain(signs.iter().copied());
        let rubs = self.slip.is_some();
        all.into_iter().all(is_discrete) && place.is_some() == (rubs || self.of_rate) && direction.is_some() == rubs
    }
}

impl RegisterCheck {
    fn new(program: &Program, layout: &Layout) -> Self {
        let empty = vec![false; program.registers as usize];
        Self {
            constants: layout.constants()..layout.constants() + program.constants.len(),
            stage: empty.clone(),
            needed: empty.clone(),
            overwritten: empty,
        }
    }

    /// The parameter stage reads parameters, discrete variables and constants only.
    fn parameters(&mut self, tape: &Tape, layout: &Layout) -> Result<(), ProgramError> {
        let readable = layout.constant_between_instants();
        self.stage = self.follow("parameters", tape, |register| readable.contains(&register), |_| {})?;
        Ok(())
    }

    /// A kernel reads registers below `limit`, the constants and the parameter stage.
    fn kernel(&mut self, name: &'static str, tape: &Tape, limit: usize) -> Result<(), ProgramError> {
        let mut needed = std::mem::take(&mut self.needed);
        let provided = |register: usize| register < limit || self.stage[register];
        let written = self.follow(name, tape, provided, |register| needed[register] = true)?;
        self.needed = needed;
        self.overwritten.iter_mut().zip(written).for_each(|(all, here)| *all |= here);
        Ok(())
    }

    /// Registers that a tape, or the parameter stage, leaves behind.
    fn left(&self, name: &'static str, tape: &Tape, registers: &[u32]) -> Result<(), ProgramError> {
        let mut known = self.stage.clone();
        let targets = tape.instructions().iter().flat_map(|instruction| instruction.targets());
        targets.for_each(|register| known[register as usize] = true);
        let unknown = registers.iter().find(|&&register| !known.get(register as usize).is_some_and(|known| *known));
        unknown.map_or(Ok(()), |&register| Err(ProgramError::undefined(name, register)))
    }

    /// Returns which registers the tape writes; `reads` hears of every register read before the tape itself wrote it.
    fn follow(
        &self,
        tape: &'static str,
        content: &Tape,
        provided: impl Fn(usize) -> bool,
        mut reads: impl FnMut(usize),
    ) -> Result<Vec<bool>, ProgramError> {
        let size = self.stage.len();
        let mut written = vec![false; size];
        let mut read = |register: u32, written: &[bool]| {
            let index = register as usize;
            if index >= size {
                return Err(ProgramError::register(tape, register));
            }
            if written[index] || self.constants.contains(&index) {
                return Ok(());
            }
            reads(index);
            if provided(index) { Ok(()) } else { Err(ProgramError::undefined(tape, register)) }
        };
        for instruction in content.instructions() {
            // Every field must name a register: the interpreter fetches operands before it looks at the operation.
            for register in [instruction.target, instruction.a, instruction.b, instruction.c] {
                if register as usize >= size {
                    return Err(ProgramError::register(tape, register));
                }
            }
            for register in instruction.operands() {
                read(register, &written)?;
            }
            let mut previous = None;
            for register in instruction.targets() {
                if (register as usize) < self.constants.end || previous == Some(register) {
                    return Err(ProgramError::register(tape, register));
                }
                written[register as usize] = true;
                previous = Some(register);
            }
        }
        for &register in &content.results {
            read(register, &written)?;
        }
        Ok(written)
    }

    fn stage_survives(&self) -> Result<(), ProgramError> {
        let lost = |&register: &usize| self.stage[register] && self.needed[register] && self.overwritten[register];
        match (0..self.stage.len()).find(lost) {
            Some(register) => Err(ProgramError::Damaged(format!(
                "register {register} of the parameter stage is overwritten by another tape"
            ))),
            None => Ok(()),
        }
    }
}
