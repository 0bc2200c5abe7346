//! The catalogue of what an FMU must do, on real FMUs: rules for the archive and the description, and calls through the C interface
//! alone, each case in a fresh process. Prints a table.

#[path = "conformance/dynamic.rs"]
mod dynamic;
#[path = "conformance/fixed.rs"]
mod fixed;
#[path = "conformance/fmu.rs"]
mod fmu;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use cotree::scene::Scene;
use fmu::Fmu;

/// An open chain, closed loops, a mechanism driven by time, and the same driven by an input.
const MODELS: [&str; 4] = ["cart_pole", "slider_crank", "quick_return", DRIVEN];
const DRIVEN: &str = "driven";
/// A case that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(120);
const CASE: &str = "COTREE_CONFORMANCE_CASE";
const FOLDER: &str = "COTREE_CONFORMANCE_FMU";

/// The scene of a model.
fn text(model: &str) -> String {
    let file = if model == DRIVEN { "quick_return" } else { model };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file).join("scene.toml");
    let text = fs::read_to_string(path).expect("a scene");
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
    Scene::from_toml(&text(model)).expect("a sound scene").export_fmu(&archive).expect("an FMU");
    let folder = work.join(model);
    let mut zip = zip::ZipArchive::new(fs::File::open(&archive).expect("a file")).expect("an archive");
    zip.extract(&folder).expect("a folder");
    folder
}

/// Runs one case in a process of its own; the reason if it fails.
fn run(case: &str, folder: &Path) -> Result<(), String> {
    let mut command = Command::new(env::current_exe().map_err(|error| error.to_string())?);
    command.args(["one_case", "--exact", "--ignored", "--nocapture"]).env(CASE, case).env(FOLDER, folder);
    let output = folder.join("output.txt");
    let file = fs::File::create(&output).map_err(|error| error.to_string())?;
    let copy = file.try_clone().map_err(|error| error.to_string())?;
    let mut child =
        command.stdin(Stdio::null()).stdout(file).stderr(copy).spawn().map_err(|error| error.to_string())?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            let printed = fs::read_to_string(&output).unwrap_or_default();
            return if status.success() && printed.contains("1 passed") {
                Ok(())
            } else {
                Err(format!("{status}\n{printed}"))
            };
        }
        if started.elapsed() > PATIENCE {
            child.kill().map_err(|error| error.to_string())?;
            return Err("it hangs".to_owned());
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Runs the present case again in a process of its own.
fn respawn() {
    let (case, folder) = (env::var(CASE).expect("a case"), env::var(FOLDER).expect("a folder"));
    run(&case, Path::new(&folder)).unwrap_or_else(|reason| panic!("{reason}"));
}

#[test]
#[ignore = "run by the others, in processes of their own"]
fn one_case() {
    let (case, folder) = (env::var(CASE).expect("a case"), env::var(FOLDER).expect("a folder"));
    let (_, _, check) = dynamic::CASES.iter().find(|known| known.0 == case).expect("a known case");
    check(&Fmu::open(Path::new(&folder)));
}

#[test]
fn every_dynamic_case() {
    let work = tempfile::tempdir().expect("a folder");
    let folders = MODELS.map(|model| unpacked(model, work.path()));
    let mut failures = Vec::new();
    println!("{:5}{}  what", "case", MODELS.map(|model| format!("{model:>14}")).concat());
    for (case, what, _) in dynamic::CASES {
        let results = folders.each_ref().map(|folder| run(case, folder));
        let words = results.each_ref().map(|result| if result.is_ok() { "ok" } else { "FAILED" });
        println!("{case:5}{}  {what}", words.map(|word| format!("{word:>14}")).concat());
        let failed = results.into_iter().zip(MODELS).filter_map(|(result, model)| Some((model, result.err()?)));
        failures.extend(failed.map(|(model, reason)| format!("{case} {model}: {what}\n{reason}")));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn every_static_case() {
    let work = tempfile::tempdir().expect("a folder");
    let mut failures = Vec::new();
    println!("{:5}{}  what", "case", MODELS.map(|model| format!("{model:>14}")).concat());
    let archives = MODELS.map(|model| {
        let folder = unpacked(model, work.path());
        fixed::Archive::open(&work.path().join(format!("{model}.fmu")), &folder)
    });
    for (case, what, check) in fixed::CASES {
        let results = archives.each_ref().map(check);
        let words = results.each_ref().map(|found| if found.is_empty() { "ok" } else { "FAILED" });
        println!("{case:5}{}  {what}", words.map(|word| format!("{word:>14}")).concat());
        let failed = results.into_iter().zip(MODELS).filter(|(found, _)| !found.is_empty());
        failures.extend(failed.map(|(found, model)| format!("{case} {model}: {what}\n{}", found.join("\n"))));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
