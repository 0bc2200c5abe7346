//! Where results go: standard output, or a file that is whole or not there.

use std::io::{self, BufWriter, StdoutLock, Write};
use std::path::Path;

use super::MessageFormat;
use super::failure::{self, Failure};
use crate::files::{self, Draft};
use crate::pipeline::{self, Compiled};
use crate::scene::{Faults, Scene};

/// Where a table goes.
pub enum Output {
    /// Standard output.
    Standard(BufWriter<StdoutLock<'static>>),
    /// A file.
    File(Draft),
}

impl Output {
    /// A file if a path is given, otherwise standard output.
    pub fn new(path: Option<&Path>) -> Result<Self, Failure> {
        match path {
            Some(path) => Ok(Output::File(Draft::new(path).map_err(|error| Failure::file("write", path, error))?)),
            None => Ok(Output::Standard(BufWriter::with_capacity(1 << 16, io::stdout().lock()))),
        }
    }

    /// Ends the output: only now does the file appear.
    pub fn commit(self) -> io::Result<()> {
        match self {
            Output::Standard(mut out) => out.flush(),
            Output::File(draft) => draft.commit(),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Output::Standard(out) => out.write(bytes),
            Output::File(draft) => draft.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Output::Standard(out) => out.flush(),
            Output::File(draft) => draft.flush(),
        }
    }
}

/// Makes sure that nothing that is read is written over, and nothing is written twice.
pub fn apart(read: &[Option<&Path>], written: &[Option<&Path>]) -> Result<(), Failure> {
    let real = |path: &&Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let mut taken: Vec<_> = read.iter().flatten().map(|path| (real(path), "is read")).collect();
    for path in written.iter().flatten() {
        let place = real(path);
        if let Some((_, why)) = taken.iter().find(|(other, _)| *other == place) {
            return Err(Failure::file("write", path, format!("it {why} by this command; choose another file")));
        }
        taken.push((place, "is already written"));
    }
    Ok(())
}

/// Writes to standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes a text file.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    files::write(path, text.as_bytes()).map_err(|error| Failure::file("write", path, error))
}

/// Reads a scene file.
pub fn load(path: &Path) -> Result<Scene, Failure> {
    // A file that is not there is no fault of the scene.
    std::fs::File::open(path).map_err(|error| Failure::file("read", path, error))?;
    if path.is_dir() {
        return Err(Failure::file("read", path, "is a folder, not a scene file"));
    }
    Ok(pipeline::load(path)?)
}

/// Reads and compiles a scene file; its warnings go to standard error.
pub fn compile(path: &Path, format: MessageFormat) -> Result<Compiled, Failure> {
    compile_scene(&load(path)?, format)
}

/// Compiles a scene; its warnings go to standard error.
pub fn compile_scene(scene: &Scene, format: MessageFormat) -> Result<Compiled, Failure> {
    let compiled = pipeline::compile(scene)?;
    if let Some(warnings) = &compiled.warnings {
        warn(warnings, format);
    }
    Ok(compiled)
}

/// Shows warnings on standard error.
pub fn warn(warnings: &Faults, format: MessageFormat) {
    match format {
        MessageFormat::Human => failure::warn(warnings),
        MessageFormat::Json => failure::say(&format!("{}\n", warnings.to_json())),
    }
}
