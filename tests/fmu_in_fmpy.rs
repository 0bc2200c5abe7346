//! Every model's FMU, in an independent importer: fmpy, in a private Python environment under `target/`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs};

const REQUIREMENTS: &str = include_str!("fmpy/requirements.txt");

#[test]
fn every_model_runs_in_fmpy() {
    if env::var_os("COTREE_SKIP_FMPY").is_some_and(|value| value == "1") {
        // Not `eprintln!`: the test harness would hide it.
        let note = "SKIPPED: no model was run in fmpy, because COTREE_SKIP_FMPY=1 is set";
        writeln!(io::stderr(), "{note}").expect("standard error is open");
        return;
    }
    let work = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fmpy");
    fs::create_dir_all(&work).expect("the target folder is writable");
    let python = environment(&work).unwrap_or_else(|reason| {
        panic!(
            "fmpy could not be installed, so no FMU was run in it: {reason}\n\
             Go online (PyPI is needed once), or set COTREE_SKIP_FMPY=1 to leave this test out."
        )
    });
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut check = Command::new(python);
    check.arg(root.join("tests/fmpy/check.py")).arg(env!("CARGO_BIN_EXE_cotree"));
    check.arg(root.join("models")).arg(&work);
    if let Err(report) = run(&mut check) {
        panic!("{report}");
    }
}

/// The Python of an environment that holds the pinned requirements; made anew when they change.
fn environment(work: &Path) -> Result<PathBuf, String> {
    let folder = work.join("environment");
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let installed = folder.join("requirements.txt");
    if fs::read_to_string(&installed).is_ok_and(|text| text == REQUIREMENTS) {
        return Ok(python);
    }
    let system = env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    run(Command::new(system).args(["-m", "venv", "--clear"]).arg(&folder))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    run(Command::new(&python).args(pip).args(REQUIREMENTS.lines()))?;
    fs::write(installed, REQUIREMENTS).map_err(|fault| fault.to_string())?;
    Ok(python)
}

/// Runs a command; what it prints is passed on, or given back if it fails.
fn run(command: &mut Command) -> Result<(), String> {
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|fault| format!("{command:?}: {fault}"))?;
    let printed = [output.stdout, output.stderr].concat();
    let printed = String::from_utf8_lossy(&printed);
    if !output.status.success() {
        return Err(format!("{command:?} failed:\n{printed}"));
    }
    println!("{printed}");
    Ok(())
}
