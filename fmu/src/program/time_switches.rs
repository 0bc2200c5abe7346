//! Comparisons of laws that change over at a time known beforehand.
//!
//! A load that is switched off at 20 ms jumps at a time that no motion moves. Only comparisons count one side of which grows or falls with time and the other one stays, such as `t < 1.3` or
//! `2*(t - start) >= length`: rounded or not, those change over once. Whether both sides of others touch, cross or stay together is for the steps to find.

use super::{Layout, Program, Steep};
use crate::tape::{Instruction, Operation};

/// How a register depends on time while steps are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dependence {
    /// Not at all.
    Held,
    /// It never falls, or never rises: one operand of each operation does so, and rounding keeps the order of numbers.
    Monotone,
    /// In another way, or the motion moves it.
    Other,
}

/// The switching functions of laws that change over once, at a time that no motion moves: their indices among the results of the laws.
pub(crate) fn of_laws(program: &Program, layout: &Layout) -> Vec<usize> {
    let laws = &program.tapes.laws;
    let mut known: Vec<Dependence> = (0..program.registers as usize)
        .map(|register| match register {
            0 => Dependence::Monotone,
            _ if (layout.inputs()..layout.constants()).contains(&register) => Dependence::Other,
            _ => Dependence::Held,
        })
        .collect();
    for instruction in laws.tape.instructions() {
        let dependence = dependence(instruction, &known);
        for target in instruction.targets() {
            // A program that is being checked may name registers that do not exist.
            known.get_mut(target as usize).into_iter().for_each(|register| *register = dependence);
        }
    }
    let results = laws.kinds.iter().zip(&laws.tape.results).enumerate();
    let is_known = |(_, (kind, result)): &(usize, (&Steep, &u32))| {
        **kind == Steep::Switching && known.get(**result as usize) == Some(&Dependence::Monotone)
    };
    results.filter(is_known).map(|(index, _)| index).collect()
}

/// How the result of an instruction depends on time.
fn dependence(instruction: &Instruction, known: &[Dependence]) -> Dependence {
    let of = |register: u32| known.get(register as usize).copied().unwrap_or(Dependence::Other);
    let mut moving = instruction.operands().map(of).filter(|operand| *operand != Dependence::Held);
    let is_linear = match instruction.operation {
        Operation::Add
        | Operation::Subtract
        | Operation::Negate
        | Operation::Copy
        | Operation::Multiply
        | Operation::MultiplyAdd
        | Operation::MultiplySubtract
        | Operation::SubtractProduct => true,
        Operation::Divide => of(instruction.b) == Dependence::Held,
        // Whatever else there is, is left to the steps: they find its jumps by their errors.
        _ => false,
    };
    match [moving.next(), moving.next()] {
        [None, _] => Dependence::Held,
        [Some(Dependence::Monotone), None] if is_linear => Dependence::Monotone,
        _ => Dependence::Other,
    }
}
