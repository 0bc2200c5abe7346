//! Finds the runtime's shared library, or builds it, and says where it is: `src/export/runtime.rs` embeds it.
//!
//! The library goes into every exported FMU, so it is always optimised and stripped, whatever the profile of the build around it and whoever's workspace
//! that is. In this workspace's own profiles it is: the package `cotree-runtime` is then compiled once, as the library that is embedded and as what cotree
//! itself calls. Elsewhere, where profiles of dependencies cannot ask for that, a cargo of its own builds it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// Names another runtime to embed: useful for one linked against an old C library.
const OVERRIDE: &str = "COTREE_RUNTIME";
/// What the runtime's build script says of it: where its package is, and whether this build optimises it.
const MANIFEST: &str = "DEP_COTREE_RUNTIME_MANIFEST";
const OPTIMISED: &str = "DEP_COTREE_RUNTIME_OPTIMISED";
/// How it is built otherwise.
const PROFILE: [&str; 5] = ["opt-level=3", "codegen-units=1", "debug=false", "strip=\"symbols\"", "panic=\"unwind\""];
/// What the cargo around this one sets for its own compiler calls.
const OUTER: [&str; 5] =
    ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "RUSTC_WORKSPACE_WRAPPER", "CLIPPY_ARGS", "CARGO_BUILD_TARGET"];

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={OVERRIDE}");
    let out = PathBuf::from(variable("OUT_DIR")?);
    let place = match env::var_os(OVERRIDE) {
        Some(path) => copy(Path::new(&path), &out)?,
        // In a browser nothing is loaded from a library: the page brings those of other platforms along.
        None if variable("CARGO_CFG_TARGET_FAMILY")? == "wasm" => none(&out)?,
        None if variable(OPTIMISED)? == "true" => shared(&out)?,
        None => copy(&build(&out)?, &out)?,
    };
    versions(&out)?;
    println!("cargo::rustc-env=COTREE_EMBEDDED={place}");
    println!("cargo::rustc-env=COTREE_PACKAGES={}", packages().unwrap_or_default());
    Ok(())
}

/// Writes a line `name version` for each package of the lock file: all of that file would be in what a browser loads.
fn versions(out: &Path) -> Result<(), String> {
    let lock = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("Cargo.lock");
    println!("cargo::rerun-if-changed={}", lock.display());
    let text = fs::read_to_string(&lock).map_err(|error| format!("cannot read {}: {error}", lock.display()))?;
    let value =
        |line: &str, key: &str| Some(line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"')?.to_owned());
    let (mut name, mut lines) = (String::new(), String::new());
    for line in text.lines() {
        if let Some(found) = value(line, "name") {
            name = found;
        } else if let Some(version) = value(line, "version") {
            lines += &format!("{name} {version}\n");
        }
    }
    fs::write(out.join("versions"), lines).map_err(|error| format!("cannot write into {}: {error}", out.display()))
}

/// Where cargo keeps the sources of packages: messages of the library would name it, and with it who built it.
fn packages() -> Option<String> {
    let own = env::var("CARGO_HOME").ok();
    let usual = || env::home_dir().map(|home| home.join(".cargo").display().to_string());
    own.or_else(usual).filter(|folder| !folder.is_empty())
}

/// An empty file, which no export takes for a library.
fn none(out: &Path) -> Result<String, String> {
    fs::write(out.join("runtime"), b"").map_err(|error| format!("cannot write into {}: {error}", out.display()))?;
    Ok("/runtime".to_owned())
}

/// Puts a library into the output folder. Returns its place there.
fn copy(library: &Path, out: &Path) -> Result<String, String> {
    println!("cargo::rerun-if-changed={}", library.display());
    let copied = fs::copy(library, out.join("runtime"));
    copied.map_err(|error| format!("cannot copy the runtime {}: {error}", library.display()))?;
    Ok("/runtime".to_owned())
}

/// Where this build puts the library before it compiles cotree, seen from the output folder. Whoever only checks the code gets an empty one, which no export takes for a library.
fn shared(out: &Path) -> Result<String, String> {
    // OUT_DIR is target/[triple/]profile/build/package-hash/out.
    let place = format!("/../../../deps/{}", file_name()?);
    let library = PathBuf::from(format!("{}{place}", out.display()));
    if !library.exists() {
        fs::write(&library, b"").map_err(|error| format!("cannot write {}: {error}", library.display()))?;
    }
    Ok(place)
}

/// Builds the shared library, once for all profiles: beside the folders of the profiles.
fn build(out: &Path) -> Result<PathBuf, String> {
    let (manifest, target) = (PathBuf::from(variable(MANIFEST)?), variable("TARGET")?);
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
    let root = variable("CARGO_MANIFEST_DIR")?;
    let packages = packages().map(|folder| format!("\u{1f}--remap-path-prefix={folder}=cargo")).unwrap_or_default();
    cargo.env("CARGO_ENCODED_RUSTFLAGS", format!("--remap-path-prefix={root}=cotree{packages}"));
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

/// A variable that cargo sets.
fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|error| format!("{name}: {error}"))
}
