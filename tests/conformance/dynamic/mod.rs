//! What must happen when the functions are called: one function for each case, run in a process of its own.

mod derivatives;
mod exchange;
mod instantiation;
mod libraries;
mod messages;
mod order;
mod process;
mod state;
mod stepping;
mod values;

use super::fmu::*;
use super::fresh::NOTHING;

/// A case: what it is called in the catalogue, what it checks, the check.
pub type Case = (&'static str, &'static str, fn(&Fmu));

pub const CASES: &[Case] = &[
    ("D01", "platform and version before instantiation", instantiation::platform),
    ("D02", "file:///path", |fmu| instantiation::located(fmu, &fmu.resources())),
    ("D03", "file:/path", |fmu| instantiation::located(fmu, &fmu.resources().replacen("file://", "file:", 1))),
    ("D04", "escapes in the resource location", instantiation::escapes),
    ("D05", "no resource location", instantiation::no_location),
    ("D06", "wrong GUID", instantiation::wrong_guid),
    ("D07", "missing GUID or name", instantiation::missing_strings),
    ("D08", "missing callbacks", instantiation::missing_callbacks),
    ("D09", "an interface that is not offered", instantiation::wrong_interface),
    ("D10", "arguments of instantiate may be overwritten", instantiation::transient_arguments),
    ("D11", "free in every state", instantiation::free_anywhere),
    ("D12", "calls before initialization", order::before_initialization),
    ("D13", "initialization without an experiment", order::no_experiment),
    ("D14", "calls during initialization", order::during_initialization),
    ("D15", "calls while stepping", order::while_stepping),
    ("D16", "calls after termination", order::after_termination),
    ("D17", "final values", order::final_values),
    ("D18", "reset is a fresh start", order::reset_is_fresh),
    ("D19", "reset restores defaults", order::reset_restores),
    ("D20", "reset after an error", order::reset_after_error),
    ("D21", "unknown value references", values::unknown_references),
    ("D22", "wrong base type", values::wrong_type),
    ("D23", "empty arrays", values::empty_arrays),
    ("D24", "missing arrays", values::missing_arrays),
    ("D25", "setting what is calculated", values::set_calculated),
    ("D26", "fixed parameters after initialization", values::fixed_late),
    ("D27", "initial values after initialization", values::initial_late),
    ("D28", "tunable parameters", values::tunable),
    ("D29", "fixed parameters before initialization", values::fixed_early),
    ("D30", "start values hold", values::start_values),
    ("D31", "inputs read back", values::inputs),
    ("D32", "outputs in initialization mode", values::outputs_early),
    ("D33", "every variable can be read", values::read_all),
    ("D34", "NaN and infinity as values", values::nan_values),
    ("D35", "values out of range", values::out_of_range),
    ("D36", "steps of zero or less", stepping::no_steps),
    ("D37", "steps that are no numbers", stepping::nan_steps),
    ("D38", "a step from elsewhere", stepping::far_steps),
    ("D39", "stop time", stepping::stop_time),
    ("D40", "start time", stepping::start_time),
    ("D41", "a first step from elsewhere", stepping::wrong_first_step),
    ("D42", "steps of different lengths", stepping::variable_steps),
    ("D43", "determinism", stepping::determinism),
    ("D44", "a thousand accumulated points", stepping::accumulated),
    ("D45", "two instances", process::two_instances),
    ("D46", "eight threads", process::threads),
    ("D47", "another thread", process::another_thread),
    ("D48", "no memory is lost", process::memory),
    ("D49", "unload and load again", process::reload),
    ("D50", "silent, and nothing of the process changes", process::silent),
    ("D51", "saved state", state::saved_state),
    ("D52", "states are reused and freed", state::reused_state),
    ("D53", "a state holds everything", state::whole_state),
    ("D54", "serialised state", state::serialised),
    ("D55", "damaged states", state::damaged),
    ("D56", "capabilities and functions agree", derivatives::capabilities),
    ("D57", "directional derivatives", derivatives::directional),
    ("D58", "derivatives of inputs", derivatives::input_derivatives),
    ("D59", "derivatives of outputs", derivatives::output_derivatives),
    ("D60", "status functions", messages::status),
    ("D61", "not terminated", messages::terminated_status),
    ("D62", "log categories", messages::log_categories),
    ("D63", "log messages", messages::log_messages),
    ("D64", "silence when all is well", messages::log_silence),
    ("D65", "printf safety", messages::log_printf),
    ("D66", "strings", values::strings),
    ("D67", "tolerances", stepping::tolerances),
    ("D68", "stop before start", stepping::stop_before_start),
    ("M01", "Model Exchange: order of calls", exchange::exchange_order),
    ("M02", "Model Exchange: sizes", exchange::exchange_sizes),
    ("M03", "Model Exchange: derivatives are those of the states", exchange::exchange_derivatives),
    ("M04", "Model Exchange: saved state", exchange::exchange_state),
    ("X01", "a second copy of the library in the same process", libraries::second_library),
    ("X02", "a state from another process", state::state_from_file),
    ("X03", "an initial value that does not fit", values::impossible_initial),
    ("X04", "damaged resources", libraries::damaged_resources),
    ("X05", "another model's FMU in the same process", libraries::another_model),
    ("X06", "a runtime of another version in the same process", libraries::another_version),
    ("X08", "a call while another one is under way", process::busy),
    ("X09", "an importer that traps and rounds otherwise", process::traps),
    ("X10", "states that events move are declared", exchange::reinitialised),
    ("X11", "a thread with a small stack", process::small_stack),
    ("X12", "Model Exchange: states beyond all numbers", exchange::beyond),
];

/// Is there nothing that the case is about? Says so.
fn nothing<T>(found: &[T], what: &str) -> bool {
    if found.is_empty() {
        println!("{NOTHING}it has no {what}");
    }
    found.is_empty()
}
