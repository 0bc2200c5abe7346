//! Builds a mechanism, simulates it, reads results by name and exports the FMU; `cotree info` and fmpy look at that afterwards.

use std::error::Error;
use std::path::PathBuf;

use cotree::{Body, Load, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("motor_pendulum.fmu"), PathBuf::from);
    let results = scene("bar.top").simulate()?;
    let angle = results.column("bar.angle").ok_or("no bar.angle")?;
    let last = angle.values.last().ok_or("no values")?;
    println!("bar.angle ends at {last:.6} {}", angle.unit);

    scene("bar.top").export_fmu(&path)?;
    println!("{} bytes: {}", std::fs::metadata(&path)?.len(), path.display());

    // A wrong scene says what to do.
    let faults = cotree::compile(&scene("bar.tip")).err().ok_or("the scene has no such point")?.to_string();
    println!("{faults}");
    if faults.contains("help: ") { Ok(()) } else { Err("no help".into()) }
}

/// A pendulum with a motor in its hinge.
fn scene(hinge: &str) -> Scene {
    Scene::new("motor_pendulum")
        .gravity([0.0, -9.81])
        .input("torque", "0 N.m")
        .body("bar", Body::new().mass(2.0).inertia(0.0416667).point("top", ("-250 mm", 0)))
        .revolute("hinge", "ground", hinge)
        .load("motor", Load::torque("ground", "bar", "torque"))
        .initial("bar.angle", "-60 deg")
        .output("bar.angle")
        .stop("10 s")
}
