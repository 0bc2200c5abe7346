//! Which law has no value, where the motion cannot go on.

use crate::failure::{Failure, Outside};
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::domain::{Domain, DomainTape, Limit};

/// So far behind the end of the last step laws are looked at as well, and at least so many seconds: the steps before a root or a pole become as short as
/// numbers permit.
const TIME_AHEAD: f64 = 1e-9;
/// A force in newtons or a speed in metres a second that is larger than this is why a motion cannot be followed: no mechanism bears it.
const BOUNDLESS: f64 = 1e15;

/// The first law that has no value at the state in the registers.
pub(crate) fn outside(model: &Model, machine: &mut Machine) -> Option<Failure> {
    let law = first_broken(&model.program().tapes.domains, machine)?;
    let time = machine.registers()[model.layout().time()];
    Some(Failure::NoValue { time, law: Box::new(law) })
}

/// The first key that has a value out of its range, with the parameters in the registers.
pub(crate) fn out_of_range(model: &Model, machine: &mut Machine) -> Option<Failure> {
    let law = first_broken(&model.program().tapes.ranges, machine)?;
    Some(Failure::OutOfRange { law: Box::new(law) })
}

fn first_broken(laws: &DomainTape, machine: &mut Machine) -> Option<Outside> {
    machine.run(&laws.tape);
    laws.domains.iter().enumerate().find_map(|(index, domain)| {
        let value = machine.result(&laws.tape, index);
        (!domain.limit.allows(value)).then(|| Outside { domain: domain.clone(), value })
    })
}

/// Why a law has no finite value at the state in the registers, or one that it must not have, if one has: nobody else may notice, because nothing that is asked for depends on it.
pub(crate) fn undefined(model: &Model, machine: &mut Machine) -> Option<Failure> {
    let laws = &model.program().tapes.domains;
    machine.run(&laws.tape);
    let without_value = |(index, domain): (usize, &Domain)| {
        is_noticed_here_alone(domain) && !domain.limit.allows(machine.result(&laws.tape, index))
    };
    let without_value = laws.domains.iter().enumerate().any(without_value);
    if without_value { outside(model, machine) } else { None }
}

/// True for the value of a whole law, and for a friction limit that must not be negative: the motion goes on without it.
pub(crate) fn is_noticed_here_alone(domain: &Domain) -> bool {
    matches!(domain.limit, Limit::Value | Limit::NotNegative | Limit::AtLeast(_))
}

/// The law with the largest value at the state in the registers, if no motion keeps pace with that.
fn boundless(model: &Model, machine: &mut Machine) -> Option<Failure> {
    let laws = &model.program().tapes.domains;
    machine.run(&laws.tape);
    let time = machine.registers()[model.layout().time()];
    let values = laws.domains.iter().enumerate().filter(|(_, domain)| domain.limit == Limit::Value);
    let sizes = values.map(|(index, domain)| (machine.result(&laws.tape, index), domain));
    let (value, domain) = sizes.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    (value.abs() > BOUNDLESS)
        .then(|| Failure::Boundless { time, law: Box::new(Outside { domain: domain.clone(), value }) })
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
    let ahead = TIME_AHEAD * time.abs().max(1.0);
    let mut later = motion.to_vec();
    (0..n).for_each(|index| later[index] += ahead * motion[n + index]);
    machine.load_signals(model, origin, time + ahead);
    machine.load_motion(model, &later);
    machine.run(&laws.tape);
    let broken = laws.domains.iter().zip(before).enumerate().find_map(|(index, (domain, from))| {
        let value = domain.limit.passed(from, machine.result(&laws.tape, index))?;
        Some(Outside { domain: domain.clone(), value })
    });
    let failure = broken.map(|law| Failure::NoValue { time, law: Box::new(law) });
    failure.or_else(|| boundless(model, machine))
}
