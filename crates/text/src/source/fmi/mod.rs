//! The Functional Mock-up Interface around the C file: the files in `sources/` of an FMU.

use cotree::export::FmiVersion;
use cotree::export::archive::Extra;
use cotree::export::description::{Causality, Description, Variability};
use cotree_fmu::fmi3::references::{References, reference};
use cotree_fmu::fmi3::token;
use cotree_fmu::program::{Program, Source};

use super::tape::number;
use super::{FixedStep, Real, filled};

const COMMON: &str = include_str!("common.c");
const FMI2: &str = include_str!("fmi2.c");
const FMI3: &str = include_str!("fmi3.c");

/// The headers of the standards, by the Modelica Association under the 2-Clause BSD License, which stands in each.
const HEADERS2: [(&str, &str); 3] = [
    ("fmi2Functions.h", include_str!("../../../vendor/fmi/fmi2Functions.h")),
    ("fmi2FunctionTypes.h", include_str!("../../../vendor/fmi/fmi2FunctionTypes.h")),
    ("fmi2TypesPlatform.h", include_str!("../../../vendor/fmi/fmi2TypesPlatform.h")),
];
const HEADERS3: [(&str, &str); 3] = [
    ("fmi3Functions.h", include_str!("../../../vendor/fmi/fmi3Functions.h")),
    ("fmi3FunctionTypes.h", include_str!("../../../vendor/fmi/fmi3FunctionTypes.h")),
    ("fmi3PlatformTypes.h", include_str!("../../../vendor/fmi/fmi3PlatformTypes.h")),
];

/// All files of the folder, whose functions have no prefix unless the importer defines one; `model` is the file that stands alone. The one to be compiled is `fmi2.c` or `fmi3.c`, which includes it.
pub fn fmu_sources(
    program: &Program,
    description: &Description,
    step: FixedStep,
    version: FmiVersion,
    model: String,
) -> Vec<Extra> {
    let (wrapper, headers) = match version {
        FmiVersion::V2 => (FMI2, HEADERS2),
        FmiVersion::V3 => (FMI3, HEADERS3),
    };
    let text = filled(&format!("{COMMON}{wrapper}"), &marks(program, description, step, version));
    let file = |name: &str, text: String| Extra { name: format!("sources/{name}"), bytes: text.into_bytes() };
    let wrapper = file(wrapper_name(version), text.replace('@', &description.identifier));
    let model = file(&format!("{}.c", description.identifier), model);
    [model, wrapper].into_iter().chain(headers.map(|(name, text)| file(name, text.to_owned()))).collect()
}

/// The file that is compiled.
pub fn wrapper_name(version: FmiVersion) -> &'static str {
    match version {
        FmiVersion::V2 => "fmi2.c",
        FmiVersion::V3 => "fmi3.c",
    }
}

fn marks(
    program: &Program,
    description: &Description,
    step: FixedStep,
    version: FmiVersion,
) -> Vec<(&'static str, String)> {
    let (token, callbacks, digit, ok) = match version {
        FmiVersion::V2 => (description.guid.clone(), "    fmi2CallbackFunctions functions;", "2", "fmi2Error"),
        FmiVersion::V3 => (
            token(&description.guid),
            "    fmi3InstanceEnvironment environment;\n    fmi3LogMessageCallback log;",
            "3",
            "fmi3Error",
        ),
    };
    let start = number(program.experiment.start);
    // Sample times are counted from the start of the export.
    let check = if program.instants.samplers.is_empty() {
        String::new()
    } else {
        format!(
            "    if (fabs(start - {start}) > 1.0e-9) {{\n        (void)@_refused(c, \"the simulation must start at {start} s\");\n        return {ok};\n    }}\n"
        )
    };
    let variables = description.variables.len();
    // The interface has double precision.
    let [narrow, wide, time] = match step.real {
        Real::Double => ["", "", "c->model.x.t"].map(str::to_owned),
        Real::Float => {
            ["(float)".to_owned(), "(double)".to_owned(), format!("c->start + {}", step.time("c->model.step"))]
        }
    };
    let reference_of_time =
        description.variables.iter().position(|variable| variable.causality == Causality::Independent);
    let references = References::new(variables, description.followed.clone(), description.indicators);
    vec![
        ("ID", description.identifier.clone()),
        ("VERSION", digit.to_owned()),
        ("CALLBACKS", callbacks.to_owned()),
        ("VARIABLES", lines(variable_rows(program, description), "{ 0, 0, -1, 0 }")),
        ("BOUNDS", lines(bounds(description), "{ 0.0, 0.0 }")),
        ("COUNT", variables.to_string()),
        ("START_CHECK", check),
        ("START", start),
        ("STEP", number(step.step)),
        ("TOKEN", token),
        ("NARROW", narrow),
        ("WIDE", wide),
        ("TIME", time),
        ("TIME_REFERENCE", reference_of_time.map_or(references.time(), reference).to_string()),
    ]
}

fn lines(rows: Vec<String>, none: &str) -> String {
    if rows.is_empty() { format!("    {none}") } else { format!("    {}", rows.join(",\n    ")) }
}

fn variable_rows(program: &Program, description: &Description) -> Vec<String> {
    let variables = program.variables.iter().zip(&description.variables);
    let row =
        |(variable, described): (&cotree_fmu::program::Variable, &cotree::export::description::ScalarVariable)| {
            let (array, index) = match variable.source {
                Source::Time => ("TIME", 0),
                Source::Parameter(index) => ("P", index),
                Source::Discrete(index) => ("D", index),
                Source::Input(index) => ("U", index),
                Source::Output { result, .. } => ("Y", result),
                Source::Coordinate(index) => ("Q", index),
                Source::Rate(index) => ("V", index),
                Source::Acceleration(index) => ("A", index),
            };
            let is_set = matches!(described.causality, Causality::Parameter { .. } | Causality::Input { .. });
            let initial = match (variable.initial, variable.source) {
                (Some(parameter), _) => i64::from(parameter),
                (None, Source::Parameter(index)) if is_set => i64::from(index),
                _ => -1,
            };
            let later = is_set && described.variability != Variability::Fixed;
            format!("{{ @_OF_{array}, {index}, {initial}, {} }}", u8::from(later))
        };
    variables.map(row).collect()
}

fn bounds(description: &Description) -> Vec<String> {
    let row = |variable: &cotree::export::description::ScalarVariable| {
        let [min, max] = variable.causality.range().map_or([None, None], |(_, ends)| ends);
        format!("{{ {}, {} }}", number(min.unwrap_or(f64::NEG_INFINITY)), number(max.unwrap_or(f64::INFINITY)))
    };
    description.variables.iter().map(row).collect()
}
