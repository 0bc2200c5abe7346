//! How time, memory and size grow with the number of bodies.
#![allow(missing_docs, reason = "a program, not a library")]
#[path = "../../benches/performance/scenes.rs"]
#[allow(dead_code)]
mod scenes;

use cotree::pipeline::compile;
use cotree::scene::Scene;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let n: usize = arguments[2].parse()?;
    let text = match arguments[1].as_str() {
        "chain" => scenes::chain(n),
        _ => scenes::four_bars(n),
    };
    let t = Instant::now();
    let scene = Scene::from_toml(&text)?;
    println!("parse {:?}", t.elapsed());
    let t = Instant::now();
    let resolved = scene.resolve()?;
    println!("resolve {:?}", t.elapsed());
    drop(resolved);
    let t = Instant::now();
    let compiled = compile(&scene)?;
    println!("compile {:?}", t.elapsed());
    let t = Instant::now();
    if arguments.len() > 3 {
        scene.export_fmu("/tmp/scale-growth.fmu")?;
        println!("export {:?}", t.elapsed());
    }
    println!(
        "bytes {} acceleration {}",
        compiled.program.to_bytes()?.len(),
        compiled.program.tapes.acceleration.instructions.len()
    );
    Ok(())
}
