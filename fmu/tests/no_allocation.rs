//! Nothing allocates while stepping.

use crate::counting::allocations;
use crate::support::*;

#[test]
fn stepping_setting_getting_differentiating_and_saving_do_not_allocate() {
    for program in [pendulum(), slider_crank(), four_bar(Drive::Velocity, true), four_bar(Drive::Position, false)] {
        let variables = program.variables.len();
        let mut instance = started(program);
        let input = instance
            .model()
            .program()
            .variables
            .iter()
            .position(|variable| matches!(variable.source, cotree_fmu::program::Source::Input(_)));
        let input = input.expect("all have one");
        let mut snapshot = instance.save();
        instance.differentiate_motion(1).expect("regular");
        let before = allocations();
        for step in 1..=200_u32 {
            if step % 3 == 0 {
                instance.set(input, f64::from(step % 5) * 0.1).expect("input");
                instance.set_derivative(input, 1, 0.1).expect("input");
            }
            instance.step_to(f64::from(step) * 0.01).expect("regular");
            for variable in 0..variables {
                instance.get(variable).expect("defined");
            }
            instance.begin_direction();
            instance.add_direction(input, 1.0).expect("input");
            instance.differentiate().expect("regular");
            instance.differentiate_motion(4).expect("regular");
            instance.save_into(&mut snapshot);
            instance.restore(&snapshot).expect("own state");
        }
        assert_eq!(allocations(), before);
    }
}

/// Steps do not allocate where ticks and events happen on the way, impacts among them.
#[test]
fn ticks_and_events_do_not_allocate() {
    for (name, expected) in [("balancing_cart", vec![1, 0]), ("end_stop", vec![31])] {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs").join(name).with_extension("bin");
        let bytes = std::fs::read(path).expect("a stored program");
        let program = cotree_fmu::program::Program::from_bytes(&bytes).expect("of today's format");
        let mut instance = started(program);
        let mut snapshot = instance.save();
        let before = allocations();
        for step in 1..=200_u32 {
            instance.step_to(f64::from(step) * 0.013).expect("regular");
            instance.save_into(&mut snapshot);
            instance.restore(&snapshot).expect("own state");
        }
        assert_eq!(allocations(), before, "{name}");
        let happened: Vec<u32> = instance.events().map(|(_, count)| count).collect();
        assert_eq!(happened, expected, "{name}");
    }
}

/// Nothing that an importer's integrator calls all the time allocates; the look for singular poses after a completed step may, where there are loops.
#[test]
fn model_exchange_does_not_allocate() {
    for program in [pendulum(), slider_crank(), four_bar(Drive::Time, true)] {
        let loops = program.constraints.clone();
        let mut instance = unstarted(program);
        instance.initialise_exchange().expect("offered");
        let mut states = vec![0.0; instance.state_count()];
        let mut rates = states.clone();
        let (before, mut looking) = (allocations(), 0);
        for step in 0..200_u32 {
            instance.set_time(f64::from(step) * 1e-3).expect("finite");
            instance.states(&mut states).expect("regular");
            instance.state_derivatives(&mut rates).expect("regular");
            states.iter_mut().zip(&rates).for_each(|(state, rate)| *state += 1e-3 * rate);
            instance.set_states(&states).expect("finite");
            let completed = allocations();
            let apart = instance.complete_step().expect("regular");
            if apart {
                instance.close_loops().expect("regular");
            }
            looking += allocations() - completed;
        }
        assert_eq!(allocations() - looking, before);
        assert!(looking == 0 || !loops.is_empty());
    }
}
