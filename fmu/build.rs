//! Names the format of what is stored (programs, saved states) after the sources that define it, so that none is ever read by a runtime
//! with another idea of it.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// A saved state as an importer sees it has no type of its own.
const FROM_IMPORTERS: &str = "src/fmi/component.rs";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=src");
    let mut files = Vec::new();
    collect(Path::new("src"), &mut files)?;
    files.sort();
    let mut hash = 0x811C_9DC5_u32;
    for file in files {
        let text = fs::read_to_string(&file)?;
        let defines = text.lines().any(|line| line.trim_start().starts_with("#[derive(") && line.contains("Serialize"));
        if defines || file == Path::new(FROM_IMPORTERS) {
            // Line ends differ between checkouts. FNV-1a.
            let bytes = text.bytes().filter(|byte| *byte != b'\r');
            hash = bytes.fold(hash, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
        }
    }
    println!("cargo::rustc-env=COTREE_FORMAT={hash:08x}");
    Ok(())
}

/// All sources of a folder and of those in it.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
