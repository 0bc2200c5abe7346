//! FMUs in fmi-rs.
//!
//! `outputs MODEL.fmu STEP COUNT` steps an FMU and prints its outputs as CSV with all digits.
//! `catalogue FOLDER` runs every dynamic case of the catalogue on an unpacked FMU, each in a process of its own (`case FOLDER CASE`), and
//! prints a line for each: its name, `pass`, `fail`, `nothing` (the model has nothing that the case is about) or `beyond` (fmi-rs cannot
//! express it), and why.

mod cases;
mod fmu;

use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use cases::{CASES, Check, Outcome};
use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2Status, fmi2True};
use fmi_rs::model_description::fmi2::Causality;
use fmu::Fmu;

/// A case that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(300);
/// Comes before the reason why a model has nothing that a case is about.
const NOTHING: &str = "nothing: ";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["outputs", fmu, step, count] => outputs(Path::new(fmu), step.parse()?, count.parse()?),
        ["catalogue", folder] => catalogue(Path::new(folder)),
        ["case", folder, name] => one_case(Path::new(folder), name),
        _ => Err("usage: fmi-rs-client outputs MODEL.fmu STEP COUNT | catalogue FOLDER | case FOLDER CASE".into()),
    }
}

fn catalogue(folder: &Path) -> Result<(), Box<dyn Error>> {
    for (name, check) in CASES {
        let ended = match check {
            Check::Beyond(reason) => format!("beyond\t{reason}"),
            Check::Run(_) => in_process(folder, name)?,
        };
        println!("{name}\t{}", ended.trim_end().replace('\n', " | "));
    }
    Ok(())
}

/// Runs a case in a process of its own; how it ended.
fn in_process(folder: &Path, name: &str) -> Result<String, Box<dyn Error>> {
    let printed = tempfile::NamedTempFile::new()?;
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("case").arg(folder).arg(name).stdin(Stdio::null());
    let mut child =
        command.stdout(printed.reopen()?).stderr(File::options().append(true).open(printed.path())?).spawn()?;
    let began = Instant::now();
    while child.try_wait()?.is_none() {
        if began.elapsed() > PATIENCE {
            child.kill()?;
            return Ok("fail\tit hangs".to_owned());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let (status, said) = (child.wait()?, std::fs::read_to_string(printed.path())?);
    Ok(match said.strip_prefix(NOTHING) {
        _ if !status.success() => format!("fail\t{status}: {said}"),
        Some(reason) => format!("nothing\t{reason}"),
        // Nothing is printed by anybody else.
        None if said.is_empty() => "pass\t".to_owned(),
        None => format!("fail\tit prints {said}"),
    })
}

fn one_case(folder: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let found = CASES.iter().find(|known| known.0 == name).map(|known| &known.1);
    let Some(Check::Run(check)) = found else { return Err(format!("no case {name}").into()) };
    if let Outcome::Nothing(reason) = check(&Fmu::open(folder)) {
        println!("{NOTHING}{reason}");
    }
    Ok(())
}

fn outputs(fmu: &Path, step: f64, count: u32) -> Result<(), Box<dyn Error>> {
    let builder = FMU2Builder::new(&PathBuf::from(fmu))?;
    let variables = builder.model_description.modelVariables.iter();
    let outputs: Vec<_> = variables.filter(|variable| variable.causality == Causality::Output).collect();
    let names: Vec<&str> = outputs.iter().map(|variable| variable.name.as_str()).collect();
    let references: Vec<u32> = outputs.iter().map(|variable| variable.valueReference).collect();
    let instance = builder.instantiate_cs("client")?;
    let mut values = vec![0.0; references.len()];
    check("setupExperiment", instance.setupExperiment(None, 0.0, Some(f64::from(count) * step)))?;
    check("enterInitializationMode", instance.enterInitializationMode())?;
    check("exitInitializationMode", instance.exitInitializationMode())?;
    println!("time,{}", names.join(","));
    for point in 0..=count {
        let time = f64::from(point) * step;
        check("getReal", instance.getReal(&references, &mut values))?;
        let row: Vec<String> = values.iter().map(f64::to_string).collect();
        println!("{time},{}", row.join(","));
        if point < count {
            check("doStep", instance.doStep(time, step, fmi2True))?;
        }
    }
    check("terminate", instance.terminate())
}

fn check(call: &str, status: fmi2Status) -> Result<(), Box<dyn Error>> {
    if status == fmi2Status::Ok { Ok(()) } else { Err(format!("{call}: {status:?}").into()) }
}
