//! The catalogue of what an FMU must do, on real FMUs: rules for the archive and the description, and calls through the C interface
//! alone, each case in a fresh process. Prints a table; with COTREE_CONFORMANCE_TABLE=FILE also writes it there (see tools/conformance.sh).

use crate::outside::archive_rules;
use crate::outside::fmi3_functions;
use crate::outside::fmu_description;
use crate::outside::fresh;
use crate::outside::process;
use crate::outside::python;
use crate::outside::xml;
use crate::support::ROOT;

#[path = "conformance/clients.rs"]
mod clients;
#[path = "conformance/dynamic/mod.rs"]
mod dynamic;
#[path = "conformance/fixed.rs"]
mod fixed;
#[path = "conformance/fmu.rs"]
mod fmu;
#[path = "conformance/table.rs"]
mod table;
#[path = "conformance/version.rs"]
mod version;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use cotree::export::FmiVersion;
use cotree::scene::Scene;
use cotree_page::export_fmu;
use fmu::Fmu;
use table::{Outcome, Row};

/// An open chain, closed loops, a stiff one, a mechanism driven by time, and the same driven by an input.
const MODELS: [&str; 5] = ["cart_pole", "slider_crank", "stiff", "quick_return", DRIVEN];
/// Models with modes: hard stops, play, contacts, dry friction.
const WITH_MODES: [&str; 6] = ["end_stop", "play_train", "valve_train", "barrier", "stick_slip", "gripper"];
/// Cases about several lives of one instance.
const LIVES: [&str; 4] = ["D18", "D19", "D20", "D51"];
const DRIVEN: &str = "driven";
const CASE: &str = "COTREE_CONFORMANCE_CASE";
const FOLDER: &str = "COTREE_CONFORMANCE_FMU";
/// The shared library of another version.
const OTHER: &str = "COTREE_CONFORMANCE_OTHER";
const TABLE: &str = "COTREE_CONFORMANCE_TABLE";
/// The schema comes with this importer.
const REQUIREMENTS: &str = include_str!("fmpy/requirements.txt");

/// The scene of a model.
fn text(model: &str) -> String {
    let file = match model {
        "stiff" => "tests/scenes/stiff.toml".to_owned(),
        DRIVEN => "models/quick_return/scene.toml".to_owned(),
        _ => format!("models/{model}/scene.toml"),
    };
    let text = fs::read_to_string(Path::new(ROOT).join(file)).expect("a scene");
    if model != DRIVEN {
        return text;
    }
    let text = text.replace("angle = \"0.4356 + 4*pi*t\"", "angle = { input = \"speed\", as = \"velocity\" }");
    let text = text.replace("[initial]", "[initial]\n\"crank.angle\" = \"0.4356 rad\"");
    text.replace("[parameters]", "[inputs]\nspeed = \"0.5 rad/s\"\n\n[parameters]")
}

/// Exports a model and unpacks it.
fn unpacked(model: &str, work: &Path) -> PathBuf {
    let archive = work.join(format!("{model}.fmu"));
    let scene = Scene::from_toml(&text(model)).expect("a sound scene");
    export_fmu(&scene, FmiVersion::V2, &archive).expect("an FMU");
    let folder = work.join(model);
    let mut zip = zip::ZipArchive::new(fs::File::open(&archive).expect("a file")).expect("an archive");
    zip.extract(&folder).expect("a folder");
    folder
}

/// Runs one case in a process of its own; the reason if it fails.
fn run(case: &str, folder: &Path, other: &Path) -> Result<Outcome, String> {
    let variables = [(CASE, Path::new(case)), (FOLDER, folder), (OTHER, other)];
    let nothing = fresh::run("conformance::one_case", variables, &folder.join("output.txt"))?;
    Ok(nothing.map_or(Outcome::Passed, Outcome::Nothing))
}

/// Runs the present case again in a process of its own.
fn respawn() {
    let [case, folder, other] = [CASE, FOLDER, OTHER].map(|name| env::var(name).expect("set by the first process"));
    let outcome = run(&case, Path::new(&folder), Path::new(&other)).unwrap_or_else(|reason| panic!("{reason}"));
    assert_eq!(outcome, Outcome::Passed);
}

#[test]
#[ignore = "run by the others, in processes of their own"]
fn one_case() {
    let (case, folder) = (env::var(CASE).expect("a case"), env::var(FOLDER).expect("a folder"));
    let (_, _, check) = dynamic::CASES.iter().find(|known| known.0 == case).expect("a known case");
    check(&Fmu::open(Path::new(&folder)));
}

/// S01: every description against the official schema.
fn schema(folders: &[PathBuf]) -> Row {
    let outcomes = match python::python("fmpy", REQUIREMENTS) {
        None => folders.iter().map(|_| Outcome::Nothing("COTREE_SKIP_FMPY=1 is set".to_owned())).collect(),
        Some((_, python)) => folders.iter().map(|folder| valid(&python, folder)).collect(),
    };
    Row::new("S01", "valid by the official schema", outcomes, vec![])
}

fn valid(python: &Path, folder: &Path) -> Outcome {
    let script = Path::new(ROOT).join("tests/fmpy/schema.py");
    match python::run(Command::new(python).arg(script).arg(folder.join("modelDescription.xml"))) {
        Ok(_) => Outcome::Passed,
        Err(complaints) => Outcome::Failed(complaints),
    }
}

/// The cases of the catalogue that the standard and the users ask for.
fn expected() -> impl Iterator<Item = String> {
    (1..=19)
        .map(|number| format!("S{number:02}"))
        .chain((1..=68).map(|number| format!("D{number:02}")))
        .chain((1..=12).map(|number| format!("X{number:02}")))
}

#[test]
fn models_with_modes_live_many_times() {
    let work = tempfile::tempdir().expect("a folder");
    for model in WITH_MODES {
        let folder = unpacked(model, work.path());
        for case in LIVES {
            run(case, &folder, &folder).unwrap_or_else(|reason| panic!("{model}, {case}: {reason}"));
        }
    }
}

#[test]
fn every_case_of_the_catalogue() {
    let work = tempfile::tempdir().expect("a folder");
    let folders: Vec<PathBuf> = MODELS.iter().map(|model| unpacked(model, work.path())).collect();
    let archives = MODELS.iter().zip(&folders);
    let archives: Vec<_> = archives
        .map(|(model, folder)| fixed::Archive::open(&work.path().join(format!("{model}.fmu")), folder))
        .collect();
    let other = version::other_runtime();
    let mut rows = vec![schema(&folders)];
    for &(case, what, check) in fixed::CASES {
        let outcomes = archives.iter().map(|archive| Outcome::of_complaints(check(archive))).collect();
        rows.push(Row::new(case, what, outcomes, vec![]));
    }
    for &(case, what, _) in dynamic::CASES {
        let outcomes = folders.iter().map(|folder| run(case, folder, &other).unwrap_or_else(Outcome::Failed)).collect();
        rows.push(Row::new(case, what, outcomes, vec!["C"]));
    }
    let own =
        clients::OWN.iter().map(|&(case, what)| Row::new(case, what, vec![Outcome::Passed; MODELS.len()], vec![]));
    rows.extend(own);
    if let Some(fmpy) = clients::fmpy(&folders) {
        rows.iter_mut().filter(|row| !row.case.starts_with('S')).for_each(|row| fmpy.add(row));
    }
    println!("{}", table::plain(&MODELS, &rows));
    if let Some(file) = env::var_os(TABLE) {
        fs::write(file, table::markdown(&MODELS, &rows, &archive_rules::glibc(&archives[0].library)))
            .expect("the table can be written");
    }
    let known: Vec<&str> = rows.iter().map(|row| row.case).collect();
    let missing: Vec<String> = expected().filter(|case| !known.contains(&case.as_str())).collect();
    assert!(missing.is_empty(), "{missing:?} are not checked");
    let failures = table::failures(&MODELS, &rows);
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
