//! Every type, constant and function of our boundary against those that bindgen makes of the standard's headers.

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::process::Command;

use crate::shape::*;

/// Compares; what is called differently in the two is given with both names.
macro_rules! same {
    (
        $version:ident, $binding:ident, $complaints:ident, $names:ident;
        types: $($type:ident),*;
        constants: $($ours:expr => $theirs:ident $name:ident),*;
        functions: $($arity:ident: $($function:ident),*;)*
    ) => {{
        use cotree_fmu::$version as ours;
        use ours::types::*;
        use fmi_sys::$version as theirs;
        let mut compare = |name: &'static str, ours: String, theirs: String| {
            $names.insert(name);
            if ours != theirs {
                $complaints.push(format!("{name} is {ours}, and in the standard {theirs}"));
            }
        };
        $(compare(stringify!($type), <$type>::shape(), <theirs::$type>::shape());)*
        $(compare(stringify!($name), ($ours as i64).to_string(), (theirs::$theirs as i64).to_string());)*
        $($(
            let declared = field(|binding: &theirs::$binding| binding.$function.as_ref().unwrap_or_else(|error| panic!("{error}")));
            compare(stringify!($function), $arity(ours::$function), declared);
        )*)*
    }};
}

crate::structure!(cotree_fmu::fmi2::types::fmi2EventInfo: newDiscreteStatesNeeded terminateSimulation nominalsOfContinuousStatesChanged
    valuesOfContinuousStatesChanged nextEventTimeDefined nextEventTime);
crate::structure!(fmi_sys::fmi2::fmi2EventInfo: newDiscreteStatesNeeded terminateSimulation nominalsOfContinuousStatesChanged
    valuesOfContinuousStatesChanged nextEventTimeDefined nextEventTime);
crate::structure!(cotree_fmu::fmi2::types::fmi2CallbackFunctions: logger allocateMemory freeMemory stepFinished componentEnvironment);
crate::structure!(fmi_sys::fmi2::fmi2CallbackFunctions: logger allocateMemory freeMemory stepFinished componentEnvironment);

/// What differs, or is missing in one of the two.
pub fn complaints() -> Vec<String> {
    let (mut complaints, mut names) = (Vec::new(), BTreeSet::new());
    version_2(&mut complaints, &mut names);
    version_3(&mut complaints, &mut names);
    // SAFETY: the functions give texts that end with zero and last for ever.
    let texts = unsafe {
        [
            (CStr::from_ptr(cotree_fmu::fmi2::fmi2GetTypesPlatform()), &fmi_sys::fmi2::fmi2TypesPlatform[..]),
            (CStr::from_ptr(cotree_fmu::fmi2::fmi2GetVersion()), fmi_sys::fmi2::fmi2Version),
            (CStr::from_ptr(cotree_fmu::fmi3::fmi3GetVersion()), fmi_sys::fmi3::fmi3Version),
        ]
    };
    let different = texts.into_iter().filter(|(ours, theirs)| ours.to_bytes_with_nul() != *theirs);
    complaints.extend(different.map(|(ours, _)| format!("{ours:?} is another version or platform")));
    for name in declared() {
        if !names.contains(name.as_str()) {
            complaints.push(format!("{name} of the standard's headers is not compared"));
        }
    }
    println!("{} types, constants and functions compared with fmi-sys", names.len());
    complaints
}

fn version_2(complaints: &mut Vec<String>, names: &mut BTreeSet<&'static str>) {
    same! {
        fmi2, Fmi2Binding, complaints, names;
        types: fmi2Component, fmi2ComponentEnvironment, fmi2FMUstate, fmi2ValueReference, fmi2Real, fmi2Integer, fmi2Boolean, fmi2Char,
            fmi2String, fmi2Byte, fmi2Status, fmi2Type, fmi2StatusKind, fmi2CallbackLogger, fmi2CallbackAllocateMemory,
            fmi2CallbackFreeMemory, fmi2StepFinished, fmi2CallbackFunctions, fmi2EventInfo;
        constants: fmi2True => fmi2True fmi2True, fmi2False => fmi2False fmi2False,
            fmi2Status::fmi2OK => fmi2Status_fmi2OK fmi2OK, fmi2Status::fmi2Warning => fmi2Status_fmi2Warning fmi2Warning,
            fmi2Status::fmi2Discard => fmi2Status_fmi2Discard fmi2Discard, fmi2Status::fmi2Error => fmi2Status_fmi2Error fmi2Error,
            fmi2Status::fmi2Fatal => fmi2Status_fmi2Fatal fmi2Fatal, fmi2Status::fmi2Pending => fmi2Status_fmi2Pending fmi2Pending,
            fmi2ModelExchange => fmi2Type_fmi2ModelExchange fmi2ModelExchange,
            fmi2CoSimulation => fmi2Type_fmi2CoSimulation fmi2CoSimulation,
            fmi2DoStepStatus => fmi2StatusKind_fmi2DoStepStatus fmi2DoStepStatus,
            fmi2PendingStatus => fmi2StatusKind_fmi2PendingStatus fmi2PendingStatus,
            fmi2LastSuccessfulTime => fmi2StatusKind_fmi2LastSuccessfulTime fmi2LastSuccessfulTime,
            fmi2Terminated => fmi2StatusKind_fmi2Terminated fmi2Terminated;
        functions:
            f0: fmi2GetTypesPlatform, fmi2GetVersion;
            f1: fmi2FreeInstance, fmi2EnterInitializationMode, fmi2ExitInitializationMode, fmi2Terminate, fmi2Reset, fmi2EnterEventMode,
                fmi2EnterContinuousTimeMode, fmi2CancelStep;
            f2: fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate, fmi2NewDiscreteStates, fmi2SetTime;
            f3: fmi2SerializedFMUstateSize, fmi2SetContinuousStates, fmi2GetDerivatives, fmi2GetEventIndicators, fmi2GetContinuousStates,
                fmi2GetNominalsOfContinuousStates, fmi2GetStatus, fmi2GetRealStatus, fmi2GetIntegerStatus, fmi2GetBooleanStatus,
                fmi2GetStringStatus;
            f4: fmi2SetDebugLogging, fmi2GetReal, fmi2GetInteger, fmi2GetBoolean, fmi2GetString, fmi2SetReal, fmi2SetInteger,
                fmi2SetBoolean, fmi2SetString, fmi2SerializeFMUstate, fmi2DeSerializeFMUstate, fmi2CompletedIntegratorStep, fmi2DoStep;
            f5: fmi2SetRealInputDerivatives, fmi2GetRealOutputDerivatives;
            f6: fmi2SetupExperiment;
            f7: fmi2Instantiate, fmi2GetDirectionalDerivative;
    }
}

fn version_3(complaints: &mut Vec<String>, names: &mut BTreeSet<&'static str>) {
    same! {
        fmi3, Fmi3Binding, complaints, names;
        types: fmi3Instance, fmi3InstanceEnvironment, fmi3FMUState, fmi3ValueReference, fmi3Float32, fmi3Float64, fmi3Int8, fmi3UInt8,
            fmi3Int16, fmi3UInt16, fmi3Int32, fmi3UInt32, fmi3Int64, fmi3UInt64, fmi3Boolean, fmi3Char, fmi3String, fmi3Byte, fmi3Binary,
            fmi3Clock, fmi3Status, fmi3DependencyKind, fmi3IntervalQualifier, fmi3LogMessageCallback, fmi3ClockUpdateCallback,
            fmi3IntermediateUpdateCallback, fmi3LockPreemptionCallback, fmi3UnlockPreemptionCallback;
        constants: fmi3True => fmi3True fmi3True, fmi3False => fmi3False fmi3False,
            fmi3Status::fmi3OK => fmi3Status_fmi3OK fmi3OK, fmi3Status::fmi3Warning => fmi3Status_fmi3Warning fmi3Warning,
            fmi3Status::fmi3Discard => fmi3Status_fmi3Discard fmi3Discard, fmi3Status::fmi3Error => fmi3Status_fmi3Error fmi3Error,
            fmi3Status::fmi3Fatal => fmi3Status_fmi3Fatal fmi3Fatal;
        functions:
            f0: fmi3GetVersion;
            f1: fmi3FreeInstance, fmi3ExitInitializationMode, fmi3EnterEventMode, fmi3Terminate, fmi3Reset, fmi3EnterConfigurationMode,
                fmi3ExitConfigurationMode, fmi3EvaluateDiscreteStates, fmi3EnterContinuousTimeMode, fmi3EnterStepMode;
            f2: fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState, fmi3SetTime, fmi3GetNumberOfEventIndicators,
                fmi3GetNumberOfContinuousStates;
            f3: fmi3GetNumberOfVariableDependencies, fmi3SerializedFMUStateSize, fmi3SetContinuousStates, fmi3GetContinuousStateDerivatives,
                fmi3GetEventIndicators, fmi3GetContinuousStates, fmi3GetNominalsOfContinuousStates, fmi3ActivateModelPartition;
            f4: fmi3SetDebugLogging, fmi3GetClock, fmi3SetClock, fmi3SerializeFMUState, fmi3DeserializeFMUState, fmi3GetShiftDecimal,
                fmi3SetIntervalDecimal, fmi3SetShiftDecimal, fmi3CompletedIntegratorStep;
            f5: fmi3GetFloat32, fmi3GetFloat64, fmi3GetInt8, fmi3GetUInt8, fmi3GetInt16, fmi3GetUInt16, fmi3GetInt32, fmi3GetUInt32,
                fmi3GetInt64, fmi3GetUInt64, fmi3GetBoolean, fmi3GetString, fmi3SetFloat32, fmi3SetFloat64, fmi3SetInt8, fmi3SetUInt8,
                fmi3SetInt16, fmi3SetUInt16, fmi3SetInt32, fmi3SetUInt32, fmi3SetInt64, fmi3SetUInt64, fmi3SetBoolean, fmi3SetString,
                fmi3GetIntervalDecimal, fmi3GetShiftFraction, fmi3SetIntervalFraction, fmi3SetShiftFraction;
            f6: fmi3EnterInitializationMode, fmi3GetBinary, fmi3SetBinary, fmi3GetIntervalFraction, fmi3GetOutputDerivatives;
            f7: fmi3InstantiateModelExchange, fmi3GetVariableDependencies, fmi3UpdateDiscreteStates;
            f8: fmi3DoStep;
            f9: fmi3GetDirectionalDerivative, fmi3GetAdjointDerivative;
            f10: fmi3InstantiateScheduledExecution;
            f12: fmi3InstantiateCoSimulation;
    }
}

/// Names in the headers that nothing at the boundary stands for: how the headers name functions, and the numbers of enumerations that only
/// unsupported functions use.
const ELSEWHERE: &[&str] = &[
    "fmi2FullName",
    "fmi2Paste",
    "fmi2PasteB",
    "fmi2TypesPlatform",
    "fmi2Version",
    "fmi2eventInfo",
    "fmi3FullName",
    "fmi3Paste",
    "fmi3PasteB",
    "fmi3Version",
    "fmi3ClockActive",
    "fmi3ClockInactive",
    "fmi3Independent",
    "fmi3Constant",
    "fmi3Fixed",
    "fmi3Tunable",
    "fmi3Discrete",
    "fmi3Dependent",
    "fmi3IntervalNotYetKnown",
    "fmi3IntervalUnchanged",
    "fmi3IntervalChanged",
];

/// Every name that the standard's headers declare, where `fmi-sys` keeps them.
fn declared() -> BTreeSet<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args([
        "metadata",
        "--format-version",
        "1",
        "--manifest-path",
        concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"),
    ]);
    let output = cargo.output().expect("cargo can be run");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let manifests = text.split("\"manifest_path\":\"").skip(1).filter_map(|rest| rest.split('"').next());
    let manifest = manifests.into_iter().find(|path| path.contains("/fmi-sys-")).expect("a dependency");
    let folder = std::path::Path::new(manifest).parent().expect("a folder");
    let mut names = BTreeSet::new();
    for version in ["2", "3"] {
        for entry in folder.join(format!("fmi-standard{version}/headers")).read_dir().expect("the headers") {
            let text = std::fs::read_to_string(entry.expect("a header").path()).expect("UTF-8");
            let code: String =
                text.split("/*").map(|part| part.split_once("*/").map_or(part, |(_, code)| code)).collect();
            let lines = code.lines().filter(|line| !line.starts_with("#include") && !line.starts_with("#ifndef"));
            let lines = lines.map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n");
            let words = lines.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
            names.extend(words.filter(|word| word.starts_with("fmi2") || word.starts_with("fmi3")).map(str::to_owned));
        }
    }
    names.retain(|name| !name.ends_with("TYPE") && !name.ends_with("_h") && !ELSEWHERE.contains(&name.as_str()));
    assert!(names.len() > 150, "the headers have more names than that");
    names
}
