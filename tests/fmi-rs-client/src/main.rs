//! Reads and steps an FMU with fmi-rs, and prints its outputs as CSV with all digits.
//!
//! usage: fmi-rs-client MODEL.fmu STEP COUNT

use std::error::Error;
use std::path::PathBuf;

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2Status, fmi2True};
use fmi_rs::model_description::fmi2::Causality;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fmu, step, count] = &arguments[..] else { return Err("usage: fmi-rs-client MODEL.fmu STEP COUNT".into()) };
    let (step, count): (f64, u32) = (step.parse()?, count.parse()?);
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
