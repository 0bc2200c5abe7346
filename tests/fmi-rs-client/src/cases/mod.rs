//! What must happen when the functions are called, as far as fmi-rs can call them: one function for each case.

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

use crate::fmu::*;

/// What a case ends with, unless it panics.
pub enum Outcome {
    Passed,
    /// The model has nothing that the case is about.
    Nothing(&'static str),
}

/// How a case is run.
pub enum Check {
    Run(fn(&Fmu) -> Outcome),
    /// The interface of fmi-rs cannot express it; with the reason.
    Beyond(&'static str),
}
use Check::{Beyond, Run};

pub const CASES: &[(&str, Check)] = &[
    ("D01", Run(instantiation::platform)),
    ("D02", Run(instantiation::located)),
    ("D03", Beyond("FMU2::new makes the resource location itself, always of the form file:///path")),
    ("D04", Run(instantiation::escapes)),
    ("D05", Run(instantiation::no_location)),
    ("D06", Run(instantiation::wrong_guid)),
    ("D07", Run(instantiation::missing_strings)),
    (
        "D08",
        Beyond(
            "FMU2::new always passes its callbacks and a logger; leaving out the functions for memory is tried in D10",
        ),
    ),
    ("D09", Run(instantiation::wrong_interface)),
    ("D10", Run(instantiation::transient_arguments)),
    ("D11", Run(instantiation::free_anywhere)),
    ("D12", Run(order::before_initialization)),
    ("D13", Run(order::no_experiment)),
    ("D14", Run(order::during_initialization)),
    ("D15", Run(order::while_stepping)),
    ("D16", Run(order::after_termination)),
    ("D17", Run(order::final_values)),
    ("D18", Run(order::reset_is_fresh)),
    ("D19", Run(order::reset_restores)),
    ("D20", Run(order::reset_after_error)),
    ("D21", Run(values::unknown_references)),
    ("D22", Run(values::wrong_type)),
    ("D23", Run(values::empty_arrays)),
    ("D24", Beyond("its arrays are slices, which are never null pointers")),
    ("D25", Run(values::set_calculated)),
    ("D26", Run(values::fixed_late)),
    ("D27", Run(values::initial_late)),
    ("D28", Run(values::tunable)),
    ("D29", Run(values::fixed_early)),
    ("D30", Run(values::start_values)),
    ("D31", Run(values::inputs)),
    ("D32", Run(values::outputs_early)),
    ("D33", Run(values::read_all)),
    ("D34", Run(values::nan_values)),
    ("D35", Run(values::out_of_range)),
    ("D36", Run(stepping::no_steps)),
    ("D37", Run(stepping::nan_steps)),
    ("D38", Run(stepping::far_steps)),
    ("D39", Run(stepping::stop_time)),
    ("D40", Run(stepping::start_time)),
    ("D41", Run(stepping::wrong_first_step)),
    ("D42", Run(stepping::variable_steps)),
    ("D43", Run(stepping::determinism)),
    ("D44", Run(stepping::accumulated)),
    ("D45", Run(process::two_instances)),
    ("D46", Run(process::threads)),
    ("D47", Run(process::another_thread)),
    ("D48", Run(process::memory)),
    ("D49", Run(process::reload)),
    ("D50", Run(process::silent)),
    ("D51", Run(state::saved_state)),
    ("D52", Run(state::reused_state)),
    ("D53", Run(state::whole_state)),
    ("D54", Run(state::serialised)),
    ("D55", Run(state::damaged)),
    ("D56", Run(derivatives::capabilities)),
    ("D57", Run(derivatives::directional)),
    ("D58", Beyond("FMU2 loads fmi2SetRealInputDerivatives, but has no method that calls it")),
    ("D59", Beyond("FMU2 loads fmi2GetRealOutputDerivatives, but has no method that calls it")),
    ("D60", Run(messages::status)),
    ("D61", Run(messages::terminated_status)),
    ("D62", Beyond("FMU2 loads fmi2SetDebugLogging, but has no method that calls it")),
    ("D63", Run(messages::log_messages)),
    ("D64", Run(messages::log_silence)),
    ("D65", Run(messages::log_printf)),
    ("D66", Run(values::strings)),
    ("D67", Run(stepping::tolerances)),
    ("D68", Run(stepping::stop_before_start)),
    ("M01", Run(exchange::exchange_order)),
    ("M02", Run(exchange::exchange_sizes)),
    ("M03", Run(exchange::exchange_derivatives)),
    ("M04", Run(exchange::exchange_state)),
    ("X01", Run(libraries::second_library)),
    ("X02", Run(state::state_from_file)),
    ("X03", Run(values::impossible_initial)),
    ("X04", Run(libraries::damaged_resources)),
    ("X05", Run(libraries::another_model)),
    ("X07", Run(libraries::description)),
];
