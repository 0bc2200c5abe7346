//! Consistent initial states, and what is said when there is none.

use crate::support::*;
use cotree_fmu::failure::Failure;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::program::*;

/// The slider-crank with other initial positions (register offset, known, value) and velocities.
fn with_initial(positions: &[(u32, bool, f64)], velocities: &[(u32, f64)]) -> Program {
    let mut program = slider_crank();
    let layout = program.layout();
    let names = ["crank", "rod"];
    let mut rows = Vec::new();
    program.initial = Initial::default();
    let first_constant = layout.constants() as u32;
    let mut put = |value: f64| {
        // The last constants are not used by the tapes.
        program.constants[31 - rows.len()] = value;
        rows.push(value);
        first_constant + 32 - rows.len() as u32
    };
    let one = put(1.0);
    let q = layout.positions() as u32;
    let targets: Vec<u32> = positions.iter().map(|item| put(item.2)).collect();
    let values = positions.iter().map(|item| q + item.0);
    program.initial.position.results = values.chain(targets).collect();
    let entries = positions.iter().enumerate().map(|(row, item)| (row as u32, item.0)).collect();
    program.initial.position_jacobian.entries = entries;
    program.initial.position_jacobian.tape.results = vec![one; positions.len()];
    let named = |item: &(u32, bool, f64)| condition(&format!("{}.angle", names[item.0 as usize]), item.1);
    program.initial.positions = positions.iter().map(named).collect();

    let v = layout.rates() as u32;
    let targets: Vec<u32> = velocities.iter().map(|item| put(item.1)).collect();
    program.initial.velocity.results = velocities.iter().map(|item| v + item.0).chain(targets).collect();
    let entries = velocities.iter().enumerate().map(|(row, item)| (row as u32, item.0)).collect();
    program.initial.velocity_jacobian.entries = entries;
    program.initial.velocity_jacobian.tape.results = vec![one; velocities.len()];
    let named = |item: &(u32, f64)| condition(&format!("{}.omega", names[item.0 as usize]), true);
    program.initial.velocities = velocities.iter().map(named).collect();
    program
}

fn failure(program: Program) -> Failure {
    match unstarted(program).initialise() {
        Err(InstanceError::Solver(failure)) => failure,
        other => panic!("{other:?}"),
    }
}

fn closed(instance: &mut Instance) {
    assert!(value(instance, "constraint.position").abs() < 1e-12);
}

#[test]
fn known_values_hold_and_guesses_pick_the_assembly() {
    let rod = (-0.5 * 0.6_f64.sin() / 1.5).acos();
    for (guess, expected) in [(-1.5, -rod), (1.5, rod)] {
        let mut instance = started(with_initial(&[(0, true, 0.6), (1, false, guess)], &[(0, 4.0)]));
        closed(&mut instance);
        assert!((value(&mut instance, "crank.angle") - 0.6).abs() < 1e-13);
        assert!((value(&mut instance, "rod.angle") - expected).abs() < 1e-12);
        assert!((value(&mut instance, "crank.omega") - 4.0).abs() < 1e-12);
        // From the loop: a cos(crank) crank' = b sin(rod) rod'.
        let rate = 0.5 * 0.6_f64.cos() * 4.0 / (1.5 * expected.sin());
        assert!((value(&mut instance, "rod.omega") - rate).abs() < 1e-12);
    }
}

#[test]
fn angles_stay_near_their_guess_and_rates_are_the_smallest() {
    let turns = 3.0 * std::f64::consts::TAU;
    let mut instance = started(with_initial(&[(0, true, 0.6 + turns), (1, false, -1.5 - turns)], &[]));
    closed(&mut instance);
    assert!((value(&mut instance, "rod.angle") + 1.5 + turns).abs() < 0.5);
    assert_eq!(value(&mut instance, "crank.omega"), 0.0);
    assert_eq!(value(&mut instance, "rod.omega"), 0.0);
}

#[test]
fn without_any_condition_the_loops_close_all_the_same() {
    let mut instance = started(with_initial(&[], &[]));
    closed(&mut instance);
}

#[test]
fn redundant_but_consistent_values_are_fine() {
    let rod = -(-0.5 * 0.6_f64.sin() / 1.5).acos();
    let mut instance = started(with_initial(&[(0, true, 0.6), (1, true, rod), (0, true, 0.6)], &[]));
    closed(&mut instance);
}

#[test]
fn contradictory_values_are_named() {
    let found = failure(with_initial(&[(0, true, 0.6), (1, true, 0.0)], &[]));
    // The crank cannot reach the rod if that stands upright: only leaving out the rod helps.
    assert_eq!(
        found,
        Failure::Contradiction { conditions: vec!["rod.angle".to_owned()], velocity: false, loops: true }
    );
    let found = failure(with_initial(&[(0, true, 0.6), (0, true, 0.7)], &[]));
    assert!(
        matches!(&found, Failure::Contradiction { conditions, .. } if conditions.iter().all(|c| c == "crank.angle"))
    );
    assert!(found.to_string().contains("`crank.angle`"));
    let found = failure(with_initial(&[(0, true, 0.6), (1, false, -1.5)], &[(0, 1.0), (1, 5.0)]));
    let conditions = vec!["crank.omega".to_owned(), "rod.omega".to_owned()];
    assert_eq!(found, Failure::Contradiction { conditions, velocity: true, loops: true });
}

#[test]
fn loops_that_cannot_be_closed_name_the_largest_gap() {
    let mut program = four_bar(Drive::Time, false);
    program.parameters[0].start = 7.0;
    let found = failure(program);
    let Failure::LoopsOpen { gap } = &found else { panic!("{found:?}") };
    assert_eq!(gap.owner, "rocker_pin");
    assert!((gap.size - 0.5).abs() < 1e-3, "the bars reach 6.5 of 7: {gap}");
    assert!(found.to_string().contains("5.000e2 mm at `rocker_pin`"), "{found}");
}

#[test]
fn better_values_after_a_failure_work() {
    let mut program = four_bar(Drive::Time, false);
    program.parameters[0].start = 7.0;
    let mut instance = unstarted(program);
    assert!(instance.initialise().is_err());
    set(&mut instance, "ground_length", 3.5);
    instance.initialise().expect("closes");
    instance.step_to(0.1).expect("regular");
}

#[test]
fn another_branch_than_the_guess_is_an_error_that_names_it() {
    let found = failure(with_initial(&[(1, true, -1.5), (0, false, 1.4)], &[]));
    match found {
        Failure::OtherBranch { condition, guess, found, angular: true } => {
            assert_eq!((condition.as_str(), guess), ("crank.angle", 1.4));
            assert!((0.5 * found.sin() + 1.5 * 1.5_f64.cos()).abs() < 1e-9);
        }
        other => panic!("{other:?}"),
    }
}

/// The four-bar with a crank at angle 0 and these guesses.
fn guessed(coupler: f64, rocker: f64) -> Program {
    let mut program = four_bar(Drive::Time, false);
    let first = program.layout().constants();
    for (result, guess) in [(2, coupler), (3, rocker)] {
        let target = program.initial.position.results[result] as usize;
        program.constants[target - first] = guess;
    }
    program
}

#[test]
fn an_accepted_assembly_is_always_that_of_the_guess() {
    let (mut accepted, mut turned_over) = (0, 0);
    for i in -6..=6 {
        for j in -6..=6 {
            let guess = [f64::from(i) * 0.5, f64::from(j) * 0.5];
            // The sign of the determinant of Phi_q tells the two assemblies apart.
            let side = |pose: [f64; 2]| (pose[0] - pose[1]).sin();
            let mut instance = unstarted(guessed(guess[0], guess[1]));
            match instance.initialise() {
                Ok(()) => {
                    accepted += 1;
                    let pose = [value(&mut instance, "coupler.angle"), value(&mut instance, "rocker.angle")];
                    let moved = [pose[0] - guess[0], pose[1] - guess[1]].map(f64::abs);
                    assert!(moved.iter().all(|&moved| moved < 1.571), "{guess:?} became {pose:?}");
                    let small = moved.iter().all(|&moved| moved <= 0.5);
                    assert!(side(pose) * side(guess) >= 0.0 || small, "{guess:?} became {pose:?}");
                }
                Err(InstanceError::Solver(Failure::OtherBranch { guess, found, .. })) => {
                    turned_over += i32::from((found - guess).cos() > 0.0);
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(accepted > 20 && turned_over > 0, "{accepted}, {turned_over}");
}

#[test]
fn a_start_where_newton_stands_still_is_left_behind() {
    // All bars in line: the loop equation along the line has no slope.
    let mut program = four_bar(Drive::Time, false);
    program.initial = Initial::default();
    let mut instance = started(program);
    let pose = [value(&mut instance, "coupler.angle"), value(&mut instance, "rocker.angle")];
    let [a, b, c, d] = FOUR_BAR;
    assert!((a + b * pose[0].cos() - c * pose[1].cos() - d).abs() < 1e-9);
    assert!((b * pose[0].sin() - c * pose[1].sin()).abs() < 1e-9);
}

#[test]
fn thousands_of_coordinates_with_direct_values_are_no_trouble() {
    let count = 5000_u32;
    let mut program = pendulum();
    let named = |index: u32| Coordinate { name: format!("body{index}.angle"), scale: 1.0 };
    program.coordinates = (0..count).map(named).collect();
    program.tapes = Tapes::default();
    program.variables.truncate(4);
    let layout = program.layout();
    program.constants = (0..count).map(|index| f64::from(index) * 1e-3).chain([1.0]).collect();
    let first = layout.constants() as u32;
    program.registers = first + count + 1;
    let zero = first;
    program.tapes.acceleration.results = vec![zero; count as usize];
    let initial = &mut program.initial;
    initial.positions = (0..count).map(|index| condition(&format!("body{index}.angle"), true)).collect();
    let values = (0..count).map(|index| layout.positions() as u32 + index);
    initial.position.results = values.chain((0..count).map(|index| first + index)).collect();
    initial.position_jacobian.entries = (0..count).map(|index| (index, index)).collect();
    initial.position_jacobian.tape.results = vec![first + count; count as usize];
    let instance = started(program);
    assert_eq!(instance.state().positions()[4999], 4.999);
}
