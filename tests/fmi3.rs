//! FMUs of FMI 3.0: rules for the archive and the descriptions, and calls through the C interface alone, each case in a fresh process. Prints a
//! table; with COTREE_CONFORMANCE_TABLE_3=FILE also writes it there (see tools/conformance.sh).

use crate::outside::{archive_rules, fmi3_functions, fmu_description, fresh, process, python, xml};
use crate::support::ROOT;

#[path = "fmi3/archive.rs"]
mod archive;
#[path = "fmi3/cases.rs"]
mod cases;
#[path = "fmi3/derivatives.rs"]
mod derivatives;
#[path = "fmi3/description.rs"]
mod description;
#[path = "fmi3/exchange.rs"]
mod exchange;
#[path = "fmi3/fmu.rs"]
mod fmu;
#[path = "fmi3/surroundings.rs"]
mod surroundings;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use cotree::export::FmiVersion;
use cotree::report::inspect::Contents;
use cotree::scene::Scene;
use cotree_page::export_fmu;
use fmu::Fmu;
pub use fresh::NOTHING;

/// An open chain with an input, closed loops, a mechanism driven by time, one driven by an input, a law in pieces.
const MODELS: [&str; 5] = ["cart_pole", "slider_crank", "quick_return", DRIVEN, CORNER];
/// Models with modes: hard stops, play, contacts, dry friction.
const WITH_MODES: [&str; 6] = ["end_stop", "play_train", "valve_train", "barrier", "stick_slip", "gripper"];
/// Cases about several lives of one instance.
const LIVES: [&str; 4] = ["3D19", "3D20", "3D55", "3M12"];
const DRIVEN: &str = "driven";
const CORNER: &str = "corner";
const CASE: &str = "COTREE_FMI3_CASE";
const FOLDER: &str = "COTREE_FMI3_FMU";
const TABLE: &str = "COTREE_CONFORMANCE_TABLE_3";
const REQUIREMENTS: &str = include_str!("fmpy/requirements.txt");

/// A case: what it is called in the catalogue, what it checks, the check.
pub type Case = (&'static str, &'static str, fn(&Fmu));

/// Is there nothing that the case is about? Says so.
fn nothing<T>(found: &[T], what: &str) -> bool {
    if found.is_empty() {
        println!("{NOTHING}it has no {what}");
    }
    found.is_empty()
}

fn cases() -> impl Iterator<Item = &'static Case> {
    [cases::CASES, surroundings::CASES, derivatives::CASES, exchange::CASES].into_iter().flatten()
}

fn scene(model: &str) -> Scene {
    let name = match model {
        DRIVEN => "quick_return",
        CORNER => "cart_pole",
        other => other,
    };
    let file = Path::new(ROOT).join(format!("models/{name}/scene.toml"));
    let mut text = fs::read_to_string(&file).expect("a scene");
    if model == DRIVEN {
        text = text.replace("angle = \"0.4356 + 4*pi*t\"", "angle = { input = \"turn\", as = \"position\" }");
        text = text.replace("[parameters]", "[inputs]\nturn = \"0.4356 rad\"\n\n[parameters]");
    }
    if model == CORNER {
        text = text.replace("vector = [\"push\", 0]", "vector = [\"push + if(rail.s > 0.01, 1, 4)\", 0]");
    }
    Scene::from_bytes(&file, text.into_bytes()).expect("a sound scene")
}

/// Exports a model and unpacks it.
fn unpacked(model: &str, version: FmiVersion, work: &Path) -> PathBuf {
    let file = work.join(format!("{model} é {}.fmu", version.number()));
    export_fmu(&scene(model), version, &file).expect("an FMU");
    let folder = file.with_extension("");
    let mut zip = zip::ZipArchive::new(fs::File::open(&file).expect("a file")).expect("an archive");
    zip.extract(&folder).expect("a folder");
    folder
}

#[test]
#[ignore = "run by the others, in processes of their own"]
fn one_case() {
    let (case, folder) = (env::var(CASE).expect("a case"), env::var(FOLDER).expect("a folder"));
    let (_, _, check) = cases().find(|known| known.0 == case).expect("a known case");
    check(&Fmu::open(Path::new(&folder)));
}

/// Which documents have an official schema.
const SCHEMAS: [(&str, &str, &str); 2] = [
    ("3S01", "the description is valid by the official schema", "modelDescription.xml"),
    ("3S29", "terminals are valid by the official schema", "terminalsAndIcons/terminalsAndIcons.xml"),
];

fn valid(document: &Path) -> Result<Option<String>, String> {
    let Some((_, python)) = python::python("fmpy", REQUIREMENTS) else {
        return Ok(Some("COTREE_SKIP_FMPY=1 is set".to_owned()));
    };
    let script = Path::new(ROOT).join("tests/fmpy/schema.py");
    python::run(Command::new(python).arg(script).arg(document)).map(|_| None)
}

#[test]
fn models_with_modes_live_many_times() {
    let work = tempfile::tempdir().expect("a folder");
    for model in WITH_MODES {
        let folder = unpacked(model, FmiVersion::V3, work.path());
        for case in LIVES {
            let variables = [(CASE, Path::new(case)), (FOLDER, folder.as_path())];
            let found = fresh::run("fmi3::one_case", variables, &work.path().join("output.txt"));
            found.unwrap_or_else(|reason| panic!("{model}, {case}: {reason}"));
        }
    }
}

#[test]
fn every_case_of_the_catalogue() {
    let work = tempfile::tempdir().expect("a folder");
    let folders: Vec<PathBuf> = MODELS.iter().map(|model| unpacked(model, FmiVersion::V3, work.path())).collect();
    let (mut table, mut failures, mut counts) = (String::new(), Vec::new(), [0; 3]);
    let mut note = |case: &str, what: &str, outcomes: Vec<Result<Option<String>, String>>| {
        let word = |outcome: &Result<Option<String>, String>| match outcome {
            Ok(None) => 0,
            Ok(Some(_)) => 1,
            Err(_) => 2,
        };
        outcomes.iter().for_each(|outcome| counts[word(outcome)] += 1);
        let words: Vec<&str> = outcomes.iter().map(|outcome| ["pass", "-", "FAIL"][word(outcome)]).collect();
        table.push_str(&format!("| {case} | {what} | {} |\n", words.join(" | ")));
        // The schemas are left out when the user asks for that.
        let skipped = SCHEMAS.iter().any(|schema| schema.0 == case);
        if !skipped && outcomes.iter().all(|outcome| matches!(outcome, Ok(Some(_)))) {
            failures.push(format!("{case}: no model shows: {what}"));
        }
        for (outcome, model) in outcomes.into_iter().zip(MODELS) {
            failures.extend(outcome.err().map(|reason| format!("{case} {model}: {what}\n{reason}")));
        }
    };
    for (case, what, file) in SCHEMAS {
        note(case, what, folders.iter().map(|folder| valid(&folder.join(file))).collect());
    }
    for &(case, what, check) in archive::RULES.iter().chain(description::RULES) {
        let checked = folders.iter().map(|folder| match check(&Fmu::open(folder)) {
            complaints if complaints.is_empty() => Ok(None),
            complaints => Err(complaints.join("\n")),
        });
        note(case, what, checked.collect());
    }
    for &(case, what, _) in cases() {
        let run = |folder: &PathBuf| {
            let variables = [(CASE, Path::new(case)), (FOLDER, folder.as_path())];
            fresh::run("fmi3::one_case", variables, &work.path().join("output.txt"))
        };
        note(case, what, folders.iter().map(run).collect());
    }
    println!("{table}");
    if let Some(file) = env::var_os(TABLE) {
        fs::write(file, markdown(&table, counts)).expect("the table can be written");
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

/// The table as a page of the documentation. Date and commit come from the script that asks for it.
fn markdown(table: &str, [passed, nothing, failed]: [usize; 3]) -> String {
    let said = |name: &str| env::var(name).unwrap_or_else(|_| "unknown".to_owned());
    format!(
        "# Conformance with FMI 3.0\n\nWritten by `tools/conformance.sh` on {}, commit {}. Do not edit.\n\n{passed} passed, {failed} failed, \
         {nothing} where the model has nothing that the case is about.\n3S: rules for the archive. 3D: calls, each case in a fresh process, through \
         the raw C interface. 3M: Model Exchange. 3X: beyond the standard.\n\n| case | what | {} |\n|---|---|{}\n{table}",
        said("COTREE_DATE"),
        said("COTREE_COMMIT"),
        MODELS.join(" | "),
        "---|".repeat(MODELS.len())
    )
}

/// The names of all models.
fn every_model() -> Vec<String> {
    let folders = fs::read_dir(Path::new(ROOT).join("models")).expect("the models");
    let folders =
        folders.map(|folder| folder.expect("readable")).filter(|folder| folder.path().join("scene.toml").exists());
    folders.map(|folder| folder.file_name().into_string().expect("UTF-8")).collect()
}

/// Somebody must set the derivatives of an input, and some importers warn where nobody does: only drivers need them.
#[test]
fn inputs_have_derivatives_where_a_driver_follows_them() {
    let work = tempfile::tempdir().expect("a folder");
    for (model, wanted) in [("cart_pole", vec!["push"]), (DRIVEN, vec!["turn", "der(turn)", "der(turn,2)"])] {
        let fmu = Fmu::open(&unpacked(model, FmiVersion::V3, work.path()));
        let inputs: Vec<&str> = fmu.of_causality("input").iter().map(|&input| &*fmu.variable(input).name).collect();
        assert_eq!(inputs, wanted, "{model}");
    }
}

/// Both versions of an FMU hold the same program: all outputs of FMI 2.0 take the same values in FMI 3.0. fmpy finds no fault in its description, and
/// Model Exchange gives the same motion.
#[test]
fn both_versions_of_every_model_give_the_same_bits() {
    let Some((work, python)) = python::python("fmpy", REQUIREMENTS) else { return };
    let script = Path::new(ROOT).join("tests/fmpy/versions.py");
    let others = every_model().into_iter().filter(|name| !MODELS.contains(&name.as_str()));
    for model in MODELS.into_iter().map(str::to_owned).chain(others) {
        let files = [FmiVersion::V2, FmiVersion::V3].map(|version| {
            let file = work.join(format!("{model}{}.fmu", version.number()));
            export_fmu(&scene(&model), version, &file).expect("an FMU");
            file
        });
        let mut command = Command::new(&python);
        command.arg(&script).args(&files).args(MODELS.contains(&model.as_str()).then_some("exchange"));
        python::run(&mut command).unwrap_or_else(|report| panic!("{model}: {report}"));
    }
}

#[test]
fn an_fmu_of_either_version_says_what_it_is() {
    let work = tempfile::tempdir().expect("a folder");
    for version in [FmiVersion::V2, FmiVersion::V3] {
        let file = work.path().join("model.fmu");
        export_fmu(&scene("cart_pole"), version, &file).expect("an FMU");
        let contents = Contents::read(&file).expect("an FMU of cotree");
        assert_eq!(contents.version, version.number());
        let mass = contents.variables.iter().find(|variable| variable.name == "cart_mass").expect("a parameter");
        assert_eq!((mass.start.as_deref(), mass.min.as_deref(), &*mass.unit), (Some("1.0"), Some("0.001"), "kg"));
        assert!(contents.to_string().contains(&format!("FMI {} ", version.number())));
    }
}

/// The members of a terminal: what they are called there, which variables they are, how they are connected.
fn members(fmu: &Fmu, terminal: &str) -> Vec<[String; 3]> {
    let (tags, mut found, mut within) = (fmu.terminals(), Vec::new(), false);
    for tag in tags {
        let text = |key| xml::attribute(&tag, key).unwrap_or_default().to_owned();
        match tag.0.ends_with("/TerminalMemberVariable") {
            true if within => found.push([text("memberName"), text("variableName"), text("variableKind")]),
            true => {}
            false => within = text("name") == terminal,
        }
    }
    found
}

#[test]
fn a_terminal_has_the_motions_and_forces_of_its_part() {
    let work = tempfile::tempdir().expect("a folder");
    let at = |model: &str, terminal: &str| {
        let fmu = Fmu::open(&unpacked(model, FmiVersion::V3, work.path()));
        members(&fmu, terminal).into_iter().map(|member| member.join(" ")).collect::<Vec<_>>()
    };
    assert_eq!(at("cart_pole", "cart"), ["drive_x push inflow"]);
    assert_eq!(at("cart_pole", "hinge"), ["fx hinge.fx outflow", "fy hinge.fy outflow"]);
    assert_eq!(at("cart_pole", "rail")[..3], ["s rail.s signal", "v rail.v signal", "fn rail.fn outflow"]);
    assert_eq!(at("cart_pole", "energy"), [""; 0]);
    for model in every_model() {
        let terminals = Fmu::open(&unpacked(&model, FmiVersion::V3, work.path())).terminals();
        assert!(terminals.iter().any(|tag| tag.0.ends_with("/TerminalMemberVariable")), "{model} has none");
    }
    assert!(at(DRIVEN, "crank_pivot").contains(&"motor turn signal".to_owned()));
}
