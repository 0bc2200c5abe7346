//! Loop equations that depend on each other where a step of a run begins.

use crate::constraints::poses::sparse_jacobian;
use crate::context::Context;
use crate::failure::Failure;
use crate::linalg::sparse::independent_rows;
use crate::machine::Machine;
use crate::math::maximum;
use crate::model::Model;
use crate::motion::Run;
use crate::singular::detect::{dependent, depends_within};

/// A start closer to a singular pose than this is treated as one in it, and so is a state from which no step leads on.
const CLOSE_START: f64 = 1e-2;
/// Loop equations closer than this are as good as dependent, and a start closer to a singular pose is in it: the root of how well loops are closed there.
pub(crate) const DEPENDENT: f64 = 1e-5;
/// A driven mechanism that a step has brought as close as this does not go on: branches lie a thousand errors of steps apart there.
pub(crate) const STOPPED: f64 = 1e-6;
/// Closer to a singular pose than this a method does not go that does not pass poses.
const REFUSED: f64 = 3e-3;

/// Does the last step end so close to a singular pose that it must be left before anything is evaluated?
pub(crate) fn begins_near(context: &Context, run: &Run) -> bool {
    if !run.is_first() || context.model.active().is_empty() {
        return run.in_zone(run.last.end_time);
    }
    ends_within(context, run, CLOSE_START)
}

/// Does the last step end close to a singular pose, whatever the units of lengths and masses are?
pub(crate) fn is_close(context: &Context, run: &Run) -> bool {
    run.in_zone(run.last.end_time) || ends_within(context, run, CLOSE_START)
}

/// Does the last step end so close to a singular pose that a method which does not pass poses goes no further?
pub(crate) fn is_refused(context: &Context, run: &Run) -> bool {
    !context.model.active().is_empty() && ends_within(context, run, REFUSED)
}

/// Does the last step end in a singular pose?
pub(crate) fn is_singular(context: &Context, run: &Run) -> bool {
    !context.model.active().is_empty() && ends_within(context, run, DEPENDENT)
}

/// Why a method that does not pass poses goes no further where no other takes over.
pub(crate) fn singular_ahead(context: &Context, run: &Run) -> Failure {
    let named = context.settings.is_named();
    Failure::SingularAhead { time: run.last.end_time, joints: at_the_end(context, run).1, named }
}

/// What to say where the motion could go on in several ways.
pub(crate) fn undecided(context: &Context, run: &Run) -> Failure {
    Failure::Undecided { time: run.last.end_time, joints: at_the_end(context, run).1 }
}

/// What to say where no step leads on from next to a pose.
pub(crate) fn not_passed(context: &Context, run: &Run) -> Failure {
    Failure::NotPassed { time: run.last.end_time, joints: at_the_end(context, run).1 }
}

/// Why accelerations are not finite at the state in the registers, if it is a singular pose.
pub(crate) fn undetermined(model: &Model, machine: &Machine) -> Option<Failure> {
    let time = machine.registers()[model.layout().time()];
    let mut state = model.default_state(time);
    let count = state.registers().len();
    state.registers_mut().copy_from_slice(&machine.registers()[..count]);
    let (distance, joints) = dependent(model, &state);
    (distance < DEPENDENT).then_some(Failure::Undetermined { time, joints })
}

/// Why there is no step from the start of the step, if it is because the loops are at the end of their reach.
pub(crate) fn end_of_reach(context: &Context, run: &Run) -> Option<Failure> {
    let (distance, joints) = at_the_end(context, run);
    let time = run.last.end_time;
    let [rates, drive, change] = rates(context, run);
    // What is left to go until the drivers turn back, if they do, is of the order of the distance.
    let turns_back = context.model.is_driven() && rates * drive < change * distance.sqrt();
    let failure = match drive > 0.0 {
        true if turns_back => Failure::DriverTurnsBack { time, joints },
        true => Failure::EndOfReach { time, joints },
        // What nothing drives stops nowhere.
        false => Failure::NotPassed { time, joints },
    };
    (distance < CLOSE_START).then_some(failure)
}

/// How fast the mechanism moves where the step begins, how fast drivers would open its loops, and how that changes, in units of the scales.
fn rates(context: &Context, run: &Run) -> [f64; 3] {
    let (model, program) = (context.model, context.model.program());
    let mut state = run.state_at(model, run.last.end_time, &run.last.end);
    let scales = program.coordinates.iter().map(|coordinate| coordinate.scale);
    let moves = state.rates().iter().zip(scales).fold(0.0, |most, (rate, scale)| maximum(most, rate.abs() / scale));
    state.rates_mut().fill(0.0);
    let mut machine = Machine::new(model);
    machine.load(model, &state);
    let [opened, changed] = [&program.tapes.constraint_rate, &program.tapes.gamma].map(|tape| {
        machine.run(tape);
        let sizes = tape.results(machine.registers()).zip(&program.constraints);
        sizes.fold(0.0, |most, (rate, row)| maximum(most, rate.abs() / row.scale))
    });
    [moves, opened, changed]
}

/// The true reason where the loop equations that are imposed depend on each other, but not all that there are: redundant joints allow another choice, in which the pose is not singular.
pub(crate) fn not_singular(model: &Model, run: &Run, named: bool, failure: Failure) -> Failure {
    /// A row is another choice if more than this share of it is new.
    const NEW: f64 = 1e-3;
    let (Failure::NotPassed { time, joints, .. }
    | Failure::BranchLost { time, joints, .. }
    | Failure::SingularAhead { time, joints, .. }
    | Failure::Undetermined { time, joints }) = &failure
    else {
        return failure;
    };
    let state = run.state_at(model, run.last.end_time, &run.last.end);
    let rows = sparse_jacobian(model, &state);
    // The rows of laws and friction limits close no loop: they are no other choice.
    let (imposed, closing) = (model.active().len(), rows.iter().filter(|row| !row.is_empty()).count());
    if imposed == closing || independent_rows(rows, NEW, NEW).1.len() < imposed {
        return failure;
    }
    Failure::ChoiceDependent { time: *time, joints: joints.clone(), named }
}

/// Is the last step's end closer than this to a pose in which loop equations depend on each other?
fn ends_within(context: &Context, run: &Run, distance: f64) -> bool {
    depends_within(context.model, &run.state_at(context.model, run.last.end_time, &run.last.end), distance)
}

/// Which loop equations depend on each other where the step begins, and how far from it they are.
fn at_the_end(context: &Context, run: &Run) -> (f64, Vec<String>) {
    dependent(context.model, &run.state_at(context.model, run.last.end_time, &run.last.end))
}
