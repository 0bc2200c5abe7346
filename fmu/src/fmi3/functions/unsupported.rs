//! Clocks, configuration and scheduled execution: the standard wants these functions in every FMU (2.5), also where there is nothing for them to do.

use crate::fmi::boundary::plain;
use crate::fmi::component::Refusal;
use crate::fmi3::component::Fmi3;
use crate::fmi3::types::*;

fn refuse(instance: fmi3Instance, call: &'static str, why: &str) -> fmi3Status {
    plain::<Fmi3>(instance, call, |_| Err(Refusal::new(format!("{call}: {why}"))))
}

/// Functions that only fail, with the reason.
macro_rules! unsupported {
    ($why:literal: $($name:ident($($argument:ident: $type:ty),*);)*) => {$(
        /// Not supported: an error.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: fmi3Instance $(, $argument: $type)*) -> fmi3Status {
            $(_ = $argument;)*
            refuse(instance, stringify!($name), $why)
        }
    )*};
}

unsupported! {
    "this FMU has no structural parameters":
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
}

unsupported! {
    "this FMU has nothing to evaluate but in fmi3UpdateDiscreteStates":
    fmi3EvaluateDiscreteStates();
}

unsupported! {
    "this FMU says what depends on what in modelDescription.xml only":
    fmi3GetNumberOfVariableDependencies(valueReference: fmi3ValueReference, nDependencies: *mut usize);
    fmi3GetVariableDependencies(
        dependent: fmi3ValueReference, elementIndicesOfDependent: *mut usize, independents: *mut fmi3ValueReference,
        elementIndicesOfIndependents: *mut usize, dependencyKinds: *mut fmi3DependencyKind, nDependencies: usize
    );
}

unsupported! {
    "this FMU has no clocks":
    fmi3GetIntervalDecimal(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64,
        qualifiers: *mut fmi3IntervalQualifier
    );
    fmi3GetIntervalFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64,
        qualifiers: *mut fmi3IntervalQualifier
    );
    fmi3GetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64);
    fmi3GetShiftFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64
    );
    fmi3SetIntervalDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64);
    fmi3SetIntervalFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64
    );
    fmi3SetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64);
    fmi3SetShiftFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64
    );
}

unsupported! {
    "this FMU is not for Scheduled Execution":
    fmi3ActivateModelPartition(clockReference: fmi3ValueReference, activationTime: fmi3Float64);
}
