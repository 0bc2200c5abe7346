//! Links the shared library so that it also runs with older C libraries than this machine's: glibc 2.28 and newer.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

const SOURCE: &str = "old_glibc.c";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    report();
    println!("cargo::rerun-if-changed={SOURCE}");
    let is = |name: &str, value: &str| env::var(name).is_ok_and(|found| found == value);
    let native = env::var_os("HOST") == env::var_os("TARGET");
    let glibc = is("CARGO_CFG_TARGET_OS", "linux") && is("CARGO_CFG_TARGET_ENV", "gnu");
    let known = is("CARGO_CFG_TARGET_ARCH", "x86_64") || is("CARGO_CFG_TARGET_ARCH", "aarch64");
    // Whoever chose another linker has also chosen what to link against.
    if !(native && glibc && known) || env::var_os("RUSTC_LINKER").is_some() {
        return;
    }
    if let Err(reason) = stand_in() {
        println!("cargo::warning=the runtime will need a C library as new as this machine's: {reason}");
    }
}

/// Tells the build script of cotree where this package is, and whether this build makes a library fit for FMUs at a place that is known: cargo
/// gives the libraries of packages from a registry or a repository names of its own.
fn report() {
    let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let is = |name: &str, value: &str| env::var(name).is_ok_and(|found| found == value);
    let checked = env::var_os("CARGO_CFG_DEBUG_ASSERTIONS").is_some();
    let fit = is("OPT_LEVEL", "3") && is("CARGO_CFG_PANIC", "unwind") && is("DEBUG", "false") && !checked;
    let foreign = Path::new(&folder)
        .components()
        .any(|part| [OsStr::new("registry"), OsStr::new("git")].contains(&part.as_os_str()));
    println!("cargo::metadata=manifest={}", Path::new(&folder).join("Cargo.toml").display());
    println!("cargo::metadata=optimised={}", fit && !foreign);
}

/// Compiles the stand-ins and links them, and the library that older systems have the originals in.
fn stand_in() -> Result<(), String> {
    let out = env::var("OUT_DIR").map_err(|error| error.to_string())?;
    let object = Path::new(&out).join("old_glibc.o");
    let options = ["-O2", "-fPIC", "-fno-lto", "-fvisibility=hidden", "-Wall", "-Werror", "-c", SOURCE, "-o"];
    let compiled = Command::new("cc").args(options).arg(&object).output();
    let compiled = compiled.map_err(|error| format!("cc: {error}"))?;
    if !compiled.status.success() {
        let complaint = String::from_utf8_lossy(&compiled.stderr);
        return Err(format!("cc: {}", complaint.lines().next().unwrap_or("failed")));
    }
    // A static library instead of a linker argument could be left out by the linker; an object cannot.
    println!("cargo::rustc-link-arg-cdylib={}", object.display());
    println!("cargo::rustc-link-arg-cdylib=-Wl,--no-as-needed,-l:libpthread.so.0,--as-needed");
    fs::metadata(&object).map(|_| ()).map_err(|error| format!("{}: {error}", object.display()))
}
