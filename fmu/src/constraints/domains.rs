//! Which law has no value, where the motion cannot go on.

use crate::failure::{Failure, Outside};
use crate::machine::Machine;
use crate::model::{Model, State};

/// So far behind the end of the last step laws are looked at as well, and at least so many seconds: the steps before a root or a pole become as short as
/// numbers permit.
const AHEAD: f64 = 1e-9;

/// The first law that has no value at the state in the registers.
pub(crate) fn outside(model: &Model, machine: &mut Machine) -> Option<Failure> {
    let laws = &model.program().tapes.domains;
    machine.run(&laws.tape);
    let time = machine.registers()[model.layout().time()];
    let broken = laws.domains.iter().enumerate().find_map(|(index, domain)| {
        let value = machine.result(&laws.tape, index);
        (!domain.limit.allows(value)).then(|| Outside { domain: domain.clone(), value })
    });
    broken.map(|law| Failure::NoValue { time, law: Box::new(law) })
}

/// The first law that has no value where the motion has come to, or goes on to at once.
pub(crate) fn outside_soon(
    model: &Model,
    machine: &mut Machine,
    origin: &State,
    time: f64,
    motion: &[f64],
) -> Option<Failure> {
    let laws = &model.program().tapes.domains;
    if laws.domains.is_empty() {
        return None;
    }
    let n = model.coordinates();
    machine.load_signals(model, origin, time);
    machine.load_motion(model, motion);
    if let Some(failure) = outside(model, machine) {
        return Some(failure);
    }
    let before: Vec<f64> = laws.tape.results(machine.registers()).collect();
    let ahead = AHEAD * time.abs().max(1.0);
    let mut later = motion.to_vec();
    (0..n).for_each(|index| later[index] += ahead * motion[n + index]);
    machine.load_signals(model, origin, time + ahead);
    machine.load_motion(model, &later);
    machine.run(&laws.tape);
    let broken = laws.domains.iter().zip(before).enumerate().find_map(|(index, (domain, from))| {
        let value = domain.limit.passed(from, machine.result(&laws.tape, index))?;
        Some(Outside { domain: domain.clone(), value })
    });
    broken.map(|law| Failure::NoValue { time, law: Box::new(law) })
}
