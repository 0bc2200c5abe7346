//! The crates of the project rust-fmi against our FMUs.
//!
//! usage: fmi-crates COTREE MODELS        the program that exports, the folder with its models
//!
//! Prints what has been checked; fails with everything that is wrong.

mod boundary;
mod description;
mod importer;
mod shape;

use std::error::Error;
use std::path::Path;
use std::process::{Command, ExitCode};

use fmi::schema::fmi2::Fmi2ModelDescription;
use fmi::schema::fmi3::Fmi3ModelDescription;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [cotree, models] = &arguments[..] else {
        eprintln!("usage: fmi-crates COTREE MODELS");
        return ExitCode::from(2);
    };
    let mut complaints = boundary::complaints();
    if let Err(error) = check_models(cotree, Path::new(models), &mut complaints) {
        complaints.push(error.to_string());
    }
    complaints.iter().for_each(|complaint| eprintln!("{complaint}"));
    if complaints.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn check_models(cotree: &str, models: &Path, complaints: &mut Vec<String>) -> Result<(), Box<dyn Error>> {
    let work = tempfile::tempdir()?;
    let mut folders: Vec<_> =
        models.read_dir()?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    folders.retain(|folder| folder.join("scene.toml").is_file());
    folders.sort();
    for folder in &folders {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let mut files = Vec::new();
        for version in ["2", "3"] {
            let file = work.path().join(format!("{name}{version}.fmu"));
            let mut export = Command::new(cotree);
            export.arg("export").arg(folder.join("scene.toml")).args(["--fmi", version, "-o"]).arg(&file);
            if !export.output()?.status.success() {
                return Err(format!("{export:?} fails").into());
            }
            files.push(file);
        }
        println!("{name}");
        let simulate = |step| simulated(cotree, &folder.join("scene.toml"), step);
        let wrong = check(&files[0], &files[1], simulate).unwrap_or_else(|error| vec![error.to_string()]);
        let right = "the same bits in both versions, and the values of `cotree simulate`";
        println!("  {}", if wrong.is_empty() { right } else { "WRONG" });
        complaints.extend(wrong.into_iter().map(|complaint| format!("{name}: {complaint}")));
    }
    println!("{} models run in the crate fmi", folders.len());
    if folders.is_empty() { Err("there are no models".into()) } else { Ok(()) }
}

/// The table of `cotree simulate`: times and outputs.
fn simulated(cotree: &str, scene: &Path, step: f64) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let stop = f64::from(importer::POINTS) * step;
    let mut simulate = Command::new(cotree);
    simulate.arg("simulate").arg(scene).arg("--step").arg(step.to_string()).arg("--stop").arg(stop.to_string());
    let table = String::from_utf8(simulate.output()?.stdout)?;
    let rows = table.lines().skip(1).map(|line| line.split(',').map(str::parse).collect());
    Ok(rows.collect::<Result<_, _>>()?)
}

/// What is wrong with the FMUs of both versions of a scene, beside the table of its simulation with a step.
fn check(
    second: &Path,
    third: &Path,
    simulate: impl Fn(f64) -> Result<Vec<Vec<f64>>, Box<dyn Error>>,
) -> Result<Vec<String>, Box<dyn Error>> {
    let mut wrong = Vec::new();
    let (before, now) = (importer::version_2(second)?, importer::version_3(third)?);
    if before.names.is_empty() || (&before.names, &before.rows) != (&now.names, &now.rows) {
        wrong.push("the outputs of both versions differ".to_owned());
    }
    if !before.agrees(&simulate(before.step)?) {
        wrong.push("the outputs are not those of `cotree simulate`".to_owned());
    }
    let lost = [
        description::lost::<Fmi2ModelDescription>(&before.description),
        description::lost::<Fmi3ModelDescription>(&now.description),
    ];
    if lost.iter().all(|lost| lost.as_ref().is_ok_and(Vec::is_empty)) {
        wrong.push("fmi-schema writes both descriptions whole: use it in place of src/export/xml".to_owned());
    }
    for (version, lost) in ["2.0", "3.0"].into_iter().zip(&lost) {
        println!(
            "  {version} through fmi-schema: {}",
            match lost {
                Ok(lost) => format!("without {}", lost.join(", ")),
                Err(error) => format!("not at all: {error}"),
            }
        );
    }
    // Flanks that rattle strike at the ends of this importer's steps: it does not look for events within them.
    let share = if third.to_string_lossy().contains("play_train") { 5e-3 } else { 2e-4 };
    for (version, run) in [("2.0", before), ("3.0", now)] {
        if !run.exchange_agrees(share) {
            wrong.push(format!("FMI {version}: Model Exchange ends elsewhere than Co-Simulation: {:?}", run.end));
        }
    }
    Ok(wrong)
}
