//! Names the format of what is stored (programs, saved states) after the sources that define it, so that none is ever read by a runtime
//! with another idea of it.

use std::fs;

/// Where the stored types and their meaning are.
const DEFINITIONS: [&str; 17] = [
    "src/program/mod.rs",
    "src/tape/mod.rs",
    "src/tape/operations.rs",
    "src/taylor/form.rs",
    "src/events/switch.rs",
    "src/model.rs",
    "src/instance/snapshot.rs",
    "src/integrator/run.rs",
    "src/integrator/signals.rs",
    "src/integrator/last_step.rs",
    "src/integrator/taylor/memory.rs",
    "src/singular/branch.rs",
    "src/singular/passing.rs",
    "src/singular/supervisor.rs",
    "src/integrator/stiffness.rs",
    "src/integrator/implicit/memory.rs",
    "src/fmi/component.rs",
];

fn main() -> Result<(), String> {
    let mut hash = 0x811C_9DC5_u32;
    for file in DEFINITIONS {
        println!("cargo::rerun-if-changed={file}");
        let text = fs::read(file).map_err(|error| format!("{file}: {error}"))?;
        // Line ends differ between checkouts. FNV-1a.
        let bytes = text.iter().filter(|byte| **byte != b'\r');
        hash = bytes.fold(hash, |hash, &byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    }
    println!("cargo::rustc-env=COTREE_FORMAT={hash:08x}");
    Ok(())
}
