//! The program file: what is written can be read, and nothing else can.

use crate::support::*;
use cotree_fmu::program::check::ProgramError;
use cotree_fmu::program::{Program, Source};
use cotree_fmu::tape::{Instruction, Operation};

fn programs() -> [Program; 4] {
    [pendulum(), slider_crank(), four_bar(Drive::Time, true), four_bar(Drive::Acceleration, false)]
}

#[test]
fn a_program_survives_the_file() {
    for program in programs() {
        let bytes = program.to_bytes().expect("can be written");
        assert_eq!(Program::from_bytes(&bytes), Ok(program));
    }
}

#[test]
fn every_changed_byte_is_noticed() {
    let bytes = slider_crank().to_bytes().expect("can be written");
    for place in 0..bytes.len() {
        for change in [1, 0x80, 0xFF] {
            let mut damaged = bytes.clone();
            damaged[place] ^= change;
            assert!(Program::from_bytes(&damaged).is_err(), "byte {place}");
        }
    }
}

#[test]
fn every_truncation_and_addition_is_noticed() {
    let bytes = pendulum().to_bytes().expect("can be written");
    for length in 0..bytes.len() {
        assert!(Program::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
    }
    let longer = [bytes, vec![0]].concat();
    for foreign in [&longer[..], b"PK\x03\x04 something else"] {
        let why = Program::from_bytes(foreign).expect_err("refused").to_string();
        assert!(why.starts_with("the program cannot be read: "), "{why}");
    }
}

/// Damage behind a correct checksum: whatever decodes either passes every check and can be run, or is refused.
#[test]
fn damage_with_a_correct_checksum_never_crashes() {
    let checksum = |bytes: &[u8]| {
        bytes
            .iter()
            .fold(0xCBF2_9CE4_8422_2325_u64, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
    };
    for program in programs() {
        let bytes = program.to_bytes().expect("can be written");
        let mut seed = 7_u64;
        for _ in 0..3000 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let mut damaged = bytes.clone();
            let place = 24 + (seed >> 33) as usize % (bytes.len() - 24);
            damaged[place] ^= (seed >> 20) as u8 | 1;
            let sum = checksum(&damaged[24..]).to_le_bytes();
            damaged[16..24].copy_from_slice(&sum);
            if let Ok(program) = Program::from_bytes(&damaged) {
                let mut registers = vec![0.0; program.registers as usize];
                program.tapes.outputs.run(&mut registers);
                program.tapes.constraint.run(&mut registers);
            }
        }
    }
}

fn fault(change: impl FnOnce(&mut Program)) -> ProgramError {
    let mut program = slider_crank();
    change(&mut program);
    program.check().expect_err("must be refused")
}

#[test]
fn check_finds_what_would_go_wrong() {
    let is = |error: ProgramError, expected: &str| assert!(error.to_string().contains(expected), "{error}");
    let program = slider_crank();
    let (layout, last) = (program.layout(), program.registers - 1);
    let constraint = |change: fn(&mut [Instruction], u32), to| {
        fault(move |p| edit(&mut p.tapes.constraint, |code| change(code, to)))
    };
    is(constraint(|code, to| code[0].a = to, 9999), "uses register");
    is(constraint(|code, to| code[0].c = to, 9999), "uses register");
    is(constraint(|code, to| code[1].target = to, 0), "uses register");
    is(constraint(|code, to| code[1].target = to, layout.constants() as u32), "uses register");
    is(fault(|p| p.tapes.constraint.results[0] = 9999), "uses register");
    is(constraint(|code, to| code[2].a = to, last), "before it is written");
    is(constraint(|code, to| code[2].a = to, layout.rates() as u32), "before it is written");
    is(fault(|p| edit(&mut p.tapes.parameters, |code| code[0].a = 0)), "before it is written");
}

#[test]
fn check_finds_wrong_counts_values_and_names() {
    let is = |error: ProgramError, expected: &str| assert!(error.to_string().contains(expected), "{error}");
    is(fault(|p| p.tapes.acceleration.results.truncate(2)), "results instead of");
    is(fault(|p| p.tapes.project_position.results.clear()), "results instead of");
    is(fault(|p| p.initial.position.results.truncate(3)), "results instead of");
    is(fault(|p| p.tapes.jacobian.entries[0].0 = 1), "a wrong matrix entry");
    is(fault(|p| p.tapes.jacobian.entries[0].1 = 2), "a wrong matrix entry");
    is(fault(|p| p.tapes.jacobian.entries[0] = (0, 1)), "a wrong matrix entry");
    is(fault(|p| p.registers = u32::MAX), "a register file of");
    is(fault(|p| p.registers = 5), "a register file of");
    is(fault(|p| p.constants[0] = f64::NAN), "has an impossible value");
    is(fault(|p| p.coordinates[0].scale = 0.0), "has an impossible value");
    is(fault(|p| p.parameters[0].min = Some(1.0)), "has an impossible value");
    is(fault(|p| p.experiment.max_step = f64::NAN), "has an impossible value");
    is(fault(|p| p.experiment.stop = -1.0), "has an impossible value");
    is(fault(|p| p.coordinates[0].name = "rod.angle".into()), "is empty or used twice");
    is(fault(|p| p.constraints[0].owner.clear()), "is empty or used twice");
    is(fault(|p| p.variables[1].source = Source::Coordinate(2)), "refers to something that is not there");
    is(
        fault(|p| p.variables[1].source = Source::Output { result: 9, accelerated: false }),
        "refers to something that is not there",
    );
}

#[test]
fn the_parameter_stage_must_survive() {
    let mut program = slider_crank();
    let stage = program.tapes.acceleration.instructions().iter().flat_map(|i| i.operands().collect::<Vec<_>>());
    let written: Vec<u32> = program.tapes.parameters.instructions().iter().map(|i| i.target).collect();
    let needed = stage.into_iter().find(|register| written.contains(register)).expect("the stage is used");
    edit(&mut program.tapes.outputs, |code| {
        let last = code.last_mut().expect("not empty");
        assert_ne!(last.operation, Operation::SinCos);
        last.target = needed;
    });
    program.tapes.outputs.results[1] = needed;
    let told = program.check().expect_err("must be refused").to_string();
    assert_eq!(told, format!("register {needed} of the parameter stage is overwritten by another tape"));
}
