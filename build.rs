//! Builds the runtime's shared library and hands it to `src/export/runtime.rs`: as it is, and compressed better than
//! there would be time for at every export.
//!
//! The library goes into every exported FMU, so it is always optimised and stripped, whatever the profile of the build
//! around it and whoever's workspace that is: profiles of dependencies cannot ask for that, hence a cargo of its own.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Names another runtime to embed: useful for one linked against an old C library.
const OVERRIDE: &str = "COTREE_RUNTIME";
/// The package that is nothing but the shared library, and what it is made of.
const PACKAGE: &str = "tools/runtime";
const SOURCES: [&str; 4] = ["fmu/Cargo.toml", "fmu/build.rs", "fmu/src", PACKAGE];
/// How it is built.
const PROFILE: [&str; 5] = ["opt-level=3", "codegen-units=1", "debug=false", "strip=\"symbols\"", "panic=\"unwind\""];
/// What the cargo around this one sets for its own compiler calls.
const OUTER: [&str; 5] =
    ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "RUSTC_WORKSPACE_WRAPPER", "CLIPPY_ARGS", "CARGO_BUILD_TARGET"];
/// The highest level of zlib.
const LEVEL: i64 = 9;

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-env-changed={OVERRIDE}");
    let out = PathBuf::from(variable("OUT_DIR")?);
    let library = match env::var_os(OVERRIDE) {
        Some(path) => PathBuf::from(path),
        None => build(&out)?,
    };
    println!("cargo::rerun-if-changed={}", library.display());
    let bytes =
        fs::read(&library).map_err(|error| format!("cannot read the runtime {}: {error}", library.display()))?;
    fs::write(out.join("runtime"), &bytes).map_err(|error| format!("cannot copy the runtime: {error}"))?;
    pack(&bytes, &out.join("runtime.zip")).map_err(|error| format!("cannot pack the runtime: {error}"))
}

/// Builds the shared library, once for all profiles: beside the folders of the profiles.
fn build(out: &Path) -> Result<PathBuf, String> {
    let (root, target) = (PathBuf::from(variable("CARGO_MANIFEST_DIR")?), variable("TARGET")?);
    let manifest = root.join(PACKAGE).join("Cargo.toml");
    if !manifest.is_file() {
        return Err(format!("{} is missing: name the runtime's shared library in {OVERRIDE}", manifest.display()));
    }
    SOURCES.iter().for_each(|source| println!("cargo::rerun-if-changed={}", root.join(source).display()));
    // OUT_DIR is target/[triple/]profile/build/package-hash/out.
    let folder = out.ancestors().nth(4).ok_or("the output folder has an unknown place")?.join("cotree-runtime");
    let mut cargo = Command::new(variable("CARGO")?);
    cargo.args(["build", "--quiet", "--release", "--target", &target]);
    cargo.arg("--manifest-path").arg(&manifest).arg("--target-dir").arg(&folder);
    for setting in PROFILE {
        cargo.args(["--config", &format!("profile.release.{setting}")]);
    }
    for name in OUTER {
        cargo.env_remove(name);
    }
    // No path of this machine in what others receive.
    cargo.env("RUSTFLAGS", format!("--remap-path-prefix={}=cotree", root.display()));
    let status = cargo.status().map_err(|error| format!("cargo cannot be run for the runtime: {error}"))?;
    if !status.success() {
        return Err(format!("the runtime cannot be built ({status}): name its shared library in {OVERRIDE}"));
    }
    Ok(folder.join(&target).join("release").join(file_name()?))
}

/// What a shared library of the package is called on the platform it is built for.
fn file_name() -> Result<String, String> {
    let name = match variable("CARGO_CFG_TARGET_OS")?.as_str() {
        "windows" => "cotree_runtime.dll",
        "macos" => "libcotree_runtime.dylib",
        _ => "libcotree_runtime.so",
    };
    Ok(name.to_owned())
}

/// An archive with the library in it, as it will lie in FMUs.
fn pack(library: &[u8], path: &Path) -> zip::result::ZipResult<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(LEVEL))
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o755);
    let mut zip = ZipWriter::new(File::create(path)?);
    zip.start_file("runtime", options)?;
    zip.write_all(library)?;
    zip.finish().map(|_| ())
}

/// A variable that cargo sets.
fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|error| format!("{name}: {error}"))
}
