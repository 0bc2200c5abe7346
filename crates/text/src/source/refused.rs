//! What a solver with a fixed step does not support, by name and place, and steps that are too long.

use cotree::diagnostic::Span;
use cotree::model::{Contact, Event, Mechanism};
use cotree::scene::{Fault, Faults, Source};
use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::{FollowerOrder, Program};
use cotree_fmu::tape::{ORDER, Series};

use super::tables::Tables;
use super::{FixedStep, SourceMethod, Start, poles};

const CODE: &str = "export::sources";

/// The state at the start, as the runtime finds it.
pub(super) fn start(program: &Program, source: &Source) -> Result<Start, Faults> {
    let refuse = |message: String| Faults::new(source.clone(), vec![Fault::new(CODE, message, Span::default())]);
    let model = Model::new(program.clone()).map_err(|fault| refuse(fault.to_string()))?;
    let mut state = model.default_state(program.experiment.start);
    solve_initial(&model, &mut state).map_err(|failure| refuse(failure.to_string()))?;
    let mut machine = Machine::new(&model);
    machine.load(&model, &state);
    let mut begin = vec![0.0; program.instants.begin.results.len()];
    machine.evaluate(&program.instants.begin, &mut begin);
    state.discrete_mut().iter_mut().zip(begin).for_each(|(place, value)| *place = value);
    // Once more: the parameter stage reads discrete variables.
    machine.load(&model, &state);
    Ok(Start { registers: machine.registers().to_vec() })
}

/// Refuses what the solver does not support, then a step that is not stable.
pub(super) fn check(
    program: &Program,
    mechanism: &Mechanism,
    start: &Start,
    source: &Source,
    step: FixedStep,
) -> Result<(), Faults> {
    let mut list = contacts(mechanism);
    list.extend(jumping(program, mechanism));
    list.extend(unsampled(program, mechanism, start, step));
    list.extend(mechanism.events.iter().filter(removes_constraints).map(|event| {
        let message = format!("event `{}` removes a joint or driver, which C sources do not support", event.name);
        Fault::new(CODE, message, event.span).help("export the FMU without `--sources` and without `--c`")
    }));
    list.extend(engaging(mechanism));
    let set = mechanism.events.iter().filter_map(|event| Some((event, event.states.first()?)));
    list.extend(set.map(|(event, (state, _))| {
        let state = &mechanism.states[state.0].name;
        let message = format!("event `{}` sets the state `{state}`, which C sources do not support", event.name);
        Fault::new(CODE, message, event.span).help("export the FMU without `--sources` and without `--c`")
    }));
    if step.method == SourceMethod::Taylor {
        list.extend(without_series(program, start));
    }
    if list.is_empty() {
        list.extend(unstable(program, start, step));
    }
    if list.is_empty() { Ok(()) } else { Err(Faults::new(source.clone(), list)) }
}

/// Joints that engage, and rates that are set.
fn engaging(mechanism: &Mechanism) -> Vec<Fault> {
    let joints = mechanism.engaging.iter().filter_map(|engaging| {
        let part = mechanism.parts().find(|part| part.owner == engaging.owner)?;
        Some((format!("joint `{}` engages by an event", part.name), part.span))
    });
    let rates = mechanism.set_rates.iter().map(|set| {
        let name = mechanism.variable_name(set.variable);
        (format!("an event sets the rate `{name}`"), set.span)
    });
    let fault = |(message, span): (String, Span)| {
        Fault::new(CODE, format!("{message}, which C sources do not support"), span)
            .help("export the FMU without `--sources` and without `--c`")
    };
    joints.chain(rates).map(fault).collect()
}

/// True for an event that removes more than loads.
fn removes_constraints(event: &&Event) -> bool {
    !event.removes.iter().all(|owner| owner.is_load())
}

/// A constant that single precision does not hold.
pub(super) fn beyond_single(number: &str, source: &Source) -> Faults {
    let message = format!(
        "the constant `{number}` is outside the range of `float`, from {:e} to {:e}",
        f32::MIN_POSITIVE,
        f32::MAX
    );
    let fault = Fault::new(CODE, message, Span::default()).help("export with `--real double`, or in other units");
    Faults::new(source.clone(), vec![fault])
}

/// Why there is no Taylor series of the motion at the start.
fn without_series(program: &Program, start: &Start) -> Option<Fault> {
    if program.is_driven() {
        let message = "`--order 8` integrates motions, but drivers determine that of this mechanism".to_owned();
        return Some(Fault::new(CODE, message, Span::default()).help("leave out `--order`"));
    }
    let layout = program.layout();
    let mut registers: Vec<Series> = start.registers.iter().map(|value| Series::constant(*value)).collect();
    for (index, follower) in program.followers.iter().enumerate() {
        let [position, rate] = [layout.followers() + index, layout.follower_rates() + index];
        let input = start.registers[layout.inputs() + follower.input as usize];
        registers[rate].0[1] = input;
        registers[position].0[1] = start.registers[rate];
        registers[position].0[2] = input / 2.0;
    }
    registers[layout.time()].0[1] = 1.0;
    let tape = &program.tapes.acceleration;
    // Each run is right to one order more.
    for order in 0..ORDER {
        for index in 0..program.mechanical() {
            registers[layout.positions() + index] =
                registers[layout.rates() + index].integral(start.registers[layout.positions() + index]);
        }
        tape.run_series(&mut registers);
        for (index, result) in tape.results.iter().take(program.coordinates.len()).enumerate() {
            let acceleration = registers[*result as usize];
            if !acceleration.0[..=order].iter().all(|coefficient| coefficient.is_finite()) {
                let name = &program.coordinates[index].name;
                let message = format!(
                    "the motion has no Taylor series of order 8 at the start, as `{name}` has none: a law has an infinite slope there"
                );
                return Some(
                    Fault::new(CODE, message, Span::default()).help("leave out `--order 8`, or start elsewhere"),
                );
            }
            registers[layout.rates() + index] = acceleration.integral(start.registers[layout.rates() + index]);
        }
    }
    None
}

fn contacts(mechanism: &Mechanism) -> Vec<Fault> {
    let of = |contact: &Contact| {
        let kind = match (&contact.slip, contact.gap.of_rate) {
            (Some(_), _) => "friction that sticks",
            (None, true) => "a freewheel",
            (None, false) => "a unilateral constraint (contact, hard stop, rope or backlash)",
        };
        let message = format!("`{}` is {kind}, which C sources do not support", contact.name);
        Fault::new(CODE, message, contact.span)
            .help("export the FMU without `--sources` and without `--c`, or replace it by a spring and a damper")
    };
    mechanism.contacts.iter().map(of).collect()
}

/// An input is constant during a step: what it drives would move in jumps.
fn jumping(program: &Program, mechanism: &Mechanism) -> Vec<Fault> {
    let with_rates = program.inputs_with_rates();
    let integrated = |input: usize| {
        let mut followers = program.followers.iter().filter(|follower| follower.input as usize == input).peekable();
        followers.peek().is_some() && followers.all(|follower| follower.order == FollowerOrder::Acceleration)
    };
    let jumps =
        program.followed_inputs().into_iter().filter(|&input| with_rates.contains(&input) || !integrated(input));
    let of = |input: usize| {
        let name = &program.inputs[input].name;
        let driver = program.followers.iter().find(|follower| follower.input as usize == input);
        let span = mechanism
            .drivers
            .iter()
            .find(|part| driver.is_some_and(|follower| follower.name == part.name))
            .map(|part| part.span);
        let message = format!(
            "`{name}` drives the motion, but an input is constant during a step of C sources: what it drives would move in jumps"
        );
        Fault::new(CODE, message, span.unwrap_or_default())
            .help("let the input be the acceleration of the driver, or a force or torque")
    };
    jumps.map(of).collect()
}

fn unsampled(program: &Program, mechanism: &Mechanism, start: &Start, step: FixedStep) -> Vec<Fault> {
    let layout = program.layout();
    let settable = layout.constant_between_instants();
    let clocks = &program.instants.clocks;
    let stage = program
        .tapes
        .parameters
        .instructions()
        .iter()
        .flat_map(|instruction| instruction.targets())
        .collect::<Vec<u32>>();
    let operands = clocks
        .instructions()
        .iter()
        .flat_map(|instruction| instruction.operands())
        .chain(clocks.results.iter().copied());
    let is_fixed =
        !operands.into_iter().any(|operand| settable.contains(&(operand as usize)) || stage.contains(&operand));
    let times = Tables { program, step, start }.sample_times();
    let odd = times.into_iter().zip(&mechanism.samplers).filter(|(time, _)| time.is_none() || !is_fixed);
    let of = |sampler: &cotree::model::Sampler| {
        let message = if is_fixed {
            format!(
                "the period and the offset of `{}` must be multiples of the step, {} s",
                sampler.name,
                step.solver_step()
            )
        } else {
            format!("the sample times of `{}` depend on a parameter: C sources count them in steps", sampler.name)
        };
        Fault::new(CODE, message, sampler.span)
            .help("give numbers that are multiples of the step, or another step with `--step`")
    };
    odd.map(|(_, sampler)| of(sampler)).collect()
}

fn unstable(program: &Program, start: &Start, step: FixedStep) -> Option<Fault> {
    if program.is_driven() {
        return None;
    }
    let limit =
        poles::limit(program, &start.registers, step.method.order()).filter(|limit| limit.step < step.solver_step())?;
    let [real, imaginary] = limit.pole;
    let pole = if imaginary == 0.0 { format!("{real:.4}") } else { format!("{real:.4} ± {:.4} i", imaginary.abs()) };
    let message = format!(
        "the step of {} s is too long for `{}`, which has a pole at {pole} /s: steps up to {:.3e} s are stable",
        step.solver_step(),
        limit.part,
        limit.step
    );
    let substeps = (step.step / limit.step).ceil();
    Some(Fault::new(CODE, message, Span::default()).help(format!("`--substeps {substeps}` divides each step")))
}
