//! The equations of one level, positions or rates, with their unknowns: what both searches have in common.

use super::given::Given;
use super::{Family, Wanted, column_scale, fulfilled};
use crate::linalg::least_squares::{Entry, ResidualFunction};
use crate::machine::Machine;
use crate::model::{Model, State};

/// One level of a state that is sought.
pub(super) struct Level<'a> {
    pub model: &'a Model,
    pub machine: &'a mut Machine,
    pub state: &'a mut State,
    pub given: Given,
    /// Which equations are imposed now.
    pub wanted: Wanted,
    family: Family<'a>,
    /// By column: where the unknown stands in the state; none for what is prescribed.
    unknowns: Vec<Option<usize>>,
}

impl<'a> Level<'a> {
    /// `columns`: the registers of the coordinates and of the integrated inputs at this level, of which `free` says whether one is an unknown.
    pub fn new(
        model: &'a Model,
        machine: &'a mut Machine,
        state: &'a mut State,
        family: Family<'a>,
        columns: impl Iterator<Item = usize> + Clone,
        free: impl Fn(usize) -> bool,
    ) -> Self {
        machine.load(model, state);
        let given = Given::new(model, machine, family.conditions, columns.clone());
        let unknowns = columns.enumerate().map(|(column, register)| free(column).then_some(register)).collect();
        Self { model, machine, state, given, wanted: Wanted::ALL, family, unknowns }
    }

    /// Is nothing set that the program was not made for? Then what was found at its export is the solution, if it is one; it is left in the state.
    pub fn is_found(&mut self, values: &[f64]) -> bool {
        let (program, state) = (self.model.program(), &mut *self.state);
        let parameters = program.parameters.iter().map(|parameter| parameter.start);
        let discrete = program.discrete.iter().map(|discrete| discrete.start);
        let inputs = program.inputs.iter().map(|input| input.start);
        let as_exported = state.time() == program.experiment.start
            && parameters.eq(state.parameters().iter().copied())
            && discrete.eq(state.discrete().iter().copied())
            && inputs.eq(state.inputs().iter().copied());
        if !as_exported || values.is_empty() {
            return false;
        }
        for (register, value) in
            self.unknowns.iter().zip(values).filter_map(|(register, value)| Some(((*register)?, value)))
        {
            state.registers_mut()[register] = *value;
        }
        self.machine.load(self.model, state);
        let mut r = Vec::new();
        self.family.residuals(self.model, self.machine, (Wanted::ALL, &self.given), &mut r);
        fulfilled(&r)
    }

    /// The unknowns of a state, in units of their scales.
    pub fn unknowns(&self, state: &State) -> Vec<f64> {
        let value = |(column, register): (usize, &Option<usize>)| {
            register.map_or(0.0, |register| state.registers()[register] / column_scale(self.model, column))
        };
        self.unknowns.iter().enumerate().map(value).collect()
    }

    /// The state that the program was made with; none if it was made without its pose.
    pub fn exported(&self) -> Option<State> {
        let program = self.model.program();
        let found = &program.initial.found_positions;
        let mut state = self.model.default_state(program.experiment.start);
        for (register, value) in
            self.unknowns.iter().zip(found).filter_map(|(register, value)| Some(((*register)?, value)))
        {
            state.registers_mut()[register] = *value;
        }
        (!found.is_empty()).then_some(state)
    }

    /// What the conditions demand in a state.
    pub fn targets(&mut self, state: &State) -> Vec<f64> {
        let (conditions, tape, _) = self.family.conditions;
        self.machine.load(self.model, state);
        self.machine.run(tape);
        (0..conditions.len()).map(|index| self.machine.result(tape, conditions.len() + index)).collect()
    }

    /// Sets time, parameters, discrete variables and inputs to what they are after a share of the way from one state to another.
    pub fn set_between(&mut self, [from, to]: [&State; 2], share: f64) {
        // At the ends these are the bits of the ends.
        let between = |from: f64, to: f64| from * (1.0 - share) + to * share;
        self.state.set_time(between(from.time(), to.time()));
        let constant = self.model.layout().constant_between_instants();
        let ends = from.constant_between_instants().iter().zip(to.constant_between_instants());
        for (place, (&from, &to)) in self.state.registers_mut()[constant].iter_mut().zip(ends) {
            *place = between(from, to);
        }
        for input in 0..from.inputs().len() {
            let [from, to] = [from, to].map(|state| state.input_polynomial(input));
            self.state.set_input_polynomial(input, std::array::from_fn(|order| between(from[order], to[order])));
        }
        self.model.follow(self.state.registers_mut());
        self.machine.load(self.model, self.state);
        self.given.demand(self.machine, self.family.conditions.1);
    }

    /// Writes the unknowns, in units of their scales, and what is substituted into the state and the registers.
    pub fn load(&mut self, x: &[f64]) {
        for (column, register) in self.unknowns.iter().enumerate() {
            if let Some(register) = *register {
                let known = self.wanted.substitute(column, &self.given);
                let value = known.unwrap_or_else(|| x[column] * column_scale(self.model, column));
                self.state.registers_mut()[register] = value;
            }
        }
        self.machine.load(self.model, self.state);
    }
}

impl ResidualFunction for Level<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        self.family.residuals(self.model, self.machine, (self.wanted, &self.given), r);
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        self.family.jacobian(self.model, self.machine, (self.wanted, &self.given), entries);
        entries.retain(|&(_, column, _)| self.unknowns[column].is_some());
    }
}
