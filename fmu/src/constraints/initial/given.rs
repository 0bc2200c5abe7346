//! What of the start is known without a search: coordinates that conditions name, and conditions that are linear.

use std::collections::{HashMap, HashSet};

use super::column_scale;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::{Condition, SparseTape};
use crate::tape::{Operation, Tape};

/// Of the conditions of one level.
pub(super) struct Given {
    /// By unknown: the known condition whose value is that unknown itself.
    conditions: Vec<Option<usize>>,
    /// What the conditions demand.
    targets: Vec<f64>,
    /// Is the condition linear in all unknowns?
    linear: Vec<bool>,
    /// Are the loop equations? Known once somebody has asked for it.
    linear_loops: Vec<bool>,
}

impl Given {
    /// `unknowns`: the registers of the coordinates, and those of the integrated inputs. The state must be in the registers.
    pub fn new(
        model: &Model,
        machine: &mut Machine,
        (conditions, tape, jacobian): (&[Condition], &Tape, &SparseTape),
        unknowns: impl Iterator<Item = usize>,
    ) -> Self {
        let values = &tape.results[..conditions.len()];
        // The first condition on each register.
        let mut names = HashMap::new();
        for index in (0..conditions.len()).filter(|&index| conditions[index].known) {
            names.entry(values[index] as usize).or_insert(index);
        }
        let conditions = unknowns.map(|unknown| names.get(&unknown).copied()).collect();
        let linear = linear(model, jacobian, values.len());
        let mut given = Self { conditions, targets: vec![0.0; values.len()], linear, linear_loops: Vec::new() };
        given.demand(machine, tape);
        given
    }

    /// Takes over what the conditions demand with the parameters in the registers.
    pub fn demand(&mut self, machine: &mut Machine, tape: &Tape) {
        machine.run(tape);
        let first = self.targets.len();
        for (index, target) in self.targets.iter_mut().enumerate() {
            *target = machine.result(tape, first + index);
        }
    }

    /// Writes what is known among the unknowns, in units of their scales.
    pub fn substitute(&self, model: &Model, x: &mut [f64]) {
        for (unknown, (place, condition)) in x.iter_mut().zip(&self.conditions).enumerate() {
            if let Some(condition) = *condition {
                *place = self.targets[condition] / column_scale(model, unknown);
            }
        }
    }

    /// The condition that names an unknown.
    pub fn condition(&self, unknown: usize) -> Option<usize> {
        self.conditions[unknown]
    }

    /// What a condition demands.
    pub fn target(&self, condition: usize) -> f64 {
        self.targets[condition]
    }

    /// Is a condition linear in all unknowns?
    pub fn is_linear(&self, condition: usize) -> bool {
        self.linear[condition]
    }

    /// Looks which loop equations are linear in all unknowns.
    pub fn find_linear_loops(&mut self, model: &Model) {
        let program = model.program();
        self.linear_loops = linear(model, &program.tapes.jacobian, program.constraints.len());
    }

    /// Is a loop equation linear in all unknowns, as far as anybody has looked?
    pub fn is_linear_loop(&self, row: usize) -> bool {
        self.linear_loops.get(row).copied().unwrap_or_default()
    }
}

/// Rows whose entries are constants, or depend on parameters alone.
fn linear(model: &Model, jacobian: &SparseTape, rows: usize) -> Vec<bool> {
    let instructions = jacobian.tape.instructions().iter();
    let written: HashSet<u32> = instructions
        .flat_map(|one| {
            let cosine = (one.operation == Operation::SinCos).then_some(one.c);
            std::iter::once(one.target).chain(cosine)
        })
        .collect();
    let layout = model.layout();
    let constant = |register: u32| {
        let place = register as usize;
        let parameter = (layout.parameters()..layout.discrete()).contains(&place);
        parameter || (place >= layout.constants() && !written.contains(&register))
    };
    let mut linear = vec![true; rows];
    for (&(row, _), &register) in jacobian.entries.iter().zip(&jacobian.tape.results) {
        linear[row as usize] &= constant(register);
    }
    linear
}
