//! A private Python environment under `target/`, with pinned packages from PyPI.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::{env, fs};

/// A folder of its own under `target/` for a test, and the Python of an environment with these packages. Nothing if
/// COTREE_SKIP_FMPY=1 is set: then the test is left out, and says so.
pub fn python(name: &str, requirements: &str) -> Option<(PathBuf, PathBuf)> {
    if env::var_os("COTREE_SKIP_FMPY").is_some_and(|value| value == "1") {
        // Not `eprintln!`: the test harness would hide it.
        let note = format!("SKIPPED: nothing of {name} was run in Python, because COTREE_SKIP_FMPY=1 is set");
        writeln!(io::stderr(), "{note}").expect("standard error is open");
        return None;
    }
    // Tests run side by side; the first one makes the environment.
    static FIRST: Mutex<()> = Mutex::new(());
    let _turn = FIRST.lock();
    let work = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&work).expect("the target folder is writable");
    let python = environment(&work, requirements).unwrap_or_else(|reason| {
        panic!(
            "fmpy could not be installed, so no FMU was run in it: {reason}\n\
             Go online (PyPI is needed once), or set COTREE_SKIP_FMPY=1 to leave this test out."
        )
    });
    Some((work, python))
}

/// The Python of an environment that holds the pinned requirements; made anew when they change.
fn environment(work: &Path, requirements: &str) -> Result<PathBuf, String> {
    let folder = work.join("environment");
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let installed = folder.join("requirements.txt");
    if fs::read_to_string(&installed).is_ok_and(|text| text == requirements) {
        return Ok(python);
    }
    let system = env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    run(Command::new(system).args(["-m", "venv", "--clear"]).arg(&folder))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    run(Command::new(&python).args(pip).args(requirements.lines()))?;
    fs::write(installed, requirements).map_err(|fault| fault.to_string())?;
    Ok(python)
}

/// Runs a command: what it prints, also as the error if it fails.
pub fn run(command: &mut Command) -> Result<String, String> {
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|fault| format!("{command:?}: {fault}"))?;
    let printed = [output.stdout, output.stderr].concat();
    let printed = String::from_utf8_lossy(&printed).into_owned();
    if !output.status.success() {
        return Err(format!("{command:?} failed:\n{printed}"));
    }
    Ok(printed)
}
