//! Finds the runtime's shared library, which cargo has built as a build dependency, and hands it to
//! `src/export/runtime.rs`: as it is, and compressed better than there would be time for at every export.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{env, fs};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Names another runtime to embed: needed when cotree itself is cross-compiled, useful for one linked against an old
/// C library.
const OVERRIDE: &str = "COTREE_RUNTIME";

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-env-changed={OVERRIDE}");
    let out = PathBuf::from(variable("OUT_DIR")?);
    let library = match env::var_os(OVERRIDE) {
        Some(path) => PathBuf::from(path),
        None => built_by_cargo(&out)?,
    };
    // The library changes exactly when cargo links it anew.
    println!("cargo::rerun-if-changed={}", library.display());
    let bytes =
        fs::read(&library).map_err(|error| format!("cannot read the runtime {}: {error}", library.display()))?;
    fs::write(out.join("runtime"), &bytes).map_err(|error| format!("cannot copy the runtime: {error}"))?;
    pack(&bytes, &out.join("runtime.zip")).map_err(|error| format!("cannot pack the runtime: {error}"))
}

/// An archive with the library in it, as it will lie in FMUs.
fn pack(library: &[u8], path: &Path) -> zip::result::ZipResult<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o755);
    let mut zip = ZipWriter::new(File::create(path)?);
    zip.start_file("runtime", options)?;
    zip.write_all(library)?;
    zip.finish().map(|_| ())
}

/// The shared library in the folder where cargo keeps the results of the build dependencies.
fn built_by_cargo(out: &Path) -> Result<PathBuf, String> {
    let (host, target) = (variable("HOST")?, variable("TARGET")?);
    if host != target {
        return Err(format!(
            "cross-compiling for {target}: build `tools/runtime` for {target} first and name its shared library in \
             {OVERRIDE}"
        ));
    }
    let folders = dependency_folders(out);
    newest_runtime(&folders).ok_or_else(|| {
        format!("no shared library of `cotree-runtime` in {folders:?}; build `tools/runtime` and name it in {OVERRIDE}")
    })
}

/// Where cargo puts build dependencies: `deps` beside `build`, or with `--target` in the profile folder one level up.
fn dependency_folders(out: &Path) -> Vec<PathBuf> {
    // OUT_DIR is target/[triple/]profile/build/package-hash/out.
    let Some(profile) = out.ancestors().nth(3) else {
        return Vec::new();
    };
    let host = profile.file_name().and_then(|name| Some(profile.ancestors().nth(2)?.join(name)));
    [Some(profile.to_path_buf()), host].into_iter().flatten().map(|folder| folder.join("deps")).collect()
}

/// The newest shared library of the runtime in these folders; a folder that does not exist has none.
fn newest_runtime(folders: &[PathBuf]) -> Option<PathBuf> {
    folders
        .iter()
        .filter_map(|folder| fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten())
        .filter(|entry| is_runtime(&entry.file_name().to_string_lossy()))
        .max_by_key(|entry| entry.metadata().and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH))
        .map(|entry| entry.path())
}

/// Is it `libcotree_runtime*.so`, `libcotree_runtime*.dylib` or `cotree_runtime*.dll`?
fn is_runtime(file: &str) -> bool {
    let stem = file.strip_prefix("lib").unwrap_or(file);
    stem.starts_with("cotree_runtime") && [".so", ".dylib", ".dll"].iter().any(|suffix| file.ends_with(suffix))
}

/// A variable that cargo sets.
fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|error| format!("{name}: {error}"))
}
