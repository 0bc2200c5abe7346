//! Where results go: standard output, or a file that is whole or not there.

use std::io::{self, BufWriter, IsTerminal, Read, StdoutLock, Write};
use std::path::{Path, PathBuf};

use cotree::compile::{self, Compiled};
use cotree::diagnostic::FaultKind;
use cotree::diagnostic::visible::visible;
use cotree::files::{self, Draft};
use cotree::report::csv::{CsvTable, CsvWriter, Naming};
use cotree::run::{Finish, Gaps};
use cotree::scene::{Fault, Faults, Requested, Scene, Source, Span};
use cotree::sheet::SheetError;
use cotree_draw::png::{self, Size};
use cotree_fmu::instance::Inaccuracy;
use cotree_text::tikz::tikz;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::MessageFormat;
use super::failure::{self, Failure};

/// The largest table of values over time [bytes].
const LARGEST_TABLE: u64 = 256 << 20;

/// Where a table goes.
pub enum Destination {
    Standard(BufWriter<StdoutLock<'static>>),
    File(Draft),
}

impl Destination {
    /// A file if a path is given, otherwise standard output.
    pub fn new(path: Option<&Path>) -> Result<Self, Failure> {
        match path {
            Some(path) => Ok(Destination::File(Draft::new(path).map_err(|error| Failure::file("write", path, error))?)),
            None => Ok(Destination::Standard(BufWriter::with_capacity(1 << 16, io::stdout().lock()))),
        }
    }

    /// Ends the output: only now does the file appear.
    pub fn commit(self) -> io::Result<()> {
        match self {
            Destination::Standard(mut out) => out.flush(),
            Destination::File(draft) => draft.commit(),
        }
    }
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Destination::Standard(out) => out.write(bytes),
            Destination::File(draft) => draft.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Destination::Standard(out) => out.flush(),
            Destination::File(draft) => draft.flush(),
        }
    }
}

/// The file for a table or a report: none if it is `-`, which stands for standard output.
pub fn file(path: Option<&Path>) -> Option<&Path> {
    path.filter(|path| !is_standard(path))
}

pub fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

/// Makes sure that nothing that is read is written over, and nothing is written twice.
pub fn apart(read: &[Option<&Path>], written: &[Option<&Path>]) -> Result<(), Failure> {
    // A file that is not there yet is known by its folder.
    let real = |path: &&Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let place = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
        path.canonicalize().ok().or_else(place).unwrap_or_else(|| path.to_path_buf())
    };
    if written.iter().flatten().any(|path| is_standard(path)) {
        let message = "only tables and reports (`-o`) go to standard output; name a file (`./-` for one of that name)";
        return Err(Failure::Usage(format!("cannot write `-`: {message}")));
    }
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

/// Writes to standard output; nothing in the text can make a terminal do or show something else.
pub fn print(text: &str) -> Result<(), Failure> {
    print_as_it_is(&visible(text))
}

/// Writes a file's own text to standard output: to the last byte, unless a terminal would obey it.
pub fn print_file(text: &str) -> Result<(), Failure> {
    if io::stdout().is_terminal() { print(text) } else { print_as_it_is(text) }
}

fn print_as_it_is(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes a file.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    files::write(path, content.as_ref()).map_err(|error| Failure::file("write", path, error))
}

/// Writes a text, to standard output if there is no file.
pub fn put(file: Option<&Path>, text: &str) -> Result<(), Failure> {
    file.map_or_else(|| print(text), |path| write(path, text))
}

/// Prints what scripts read.
pub fn json(value: &impl Serialize) -> Result<(), Failure> {
    print(&format!("{}\n", serde_json::to_string_pretty(value).map_err(io::Error::from)?))
}

/// Ends a table.
pub fn finish(table: CsvWriter<Destination>, file: Option<&Path>) -> Result<(), Failure> {
    table.finish().and_then(Destination::commit).map_err(|error| match file {
        Some(path) => Failure::file("write", path, error),
        None => Failure::from(error),
    })
}

/// A table with these columns, each with the SI value of one in it, into a file or to standard output.
pub fn begin(
    file: Option<&Path>,
    columns: impl IntoIterator<Item = (impl AsRef<str>, f64)>,
) -> Result<CsvWriter<Destination>, Failure> {
    Ok(CsvWriter::new(Destination::new(file)?, columns)?)
}

/// Writes a picture, as PNG or for LaTeX if its name ends so, and says what it is.
pub fn picture(path: &Path, picture: &str, what: &str, format: MessageFormat) -> Result<(), Failure> {
    if has_extension(path, "png") {
        write(path, png::png(picture, Size::Times(2.0)).map_err(|error| Failure::file("draw", path, error))?)?;
    } else if has_extension(path, "tex") {
        write(path, tikz(picture).map_err(|error| Failure::file("draw", path, error))?)?;
    } else {
        write(path, picture)?;
    }
    wrote(path, what, format);
    Ok(())
}

/// Pictures and pages are written in the format that the end of the name says, never in another.
pub fn is_written_as(path: Option<&Path>, kinds: &[&str]) -> Result<(), Failure> {
    let Some(path) = path.filter(|path| !kinds.iter().any(|kind| has_extension(path, kind))) else { return Ok(()) };
    let names: Vec<String> = kinds.iter().map(|kind| format!("`.{kind}`")).collect();
    let name = path.display();
    Err(Failure::Usage(format!("cannot write `{name}`: its name must end with {}", names.join(" or "))))
}

/// What is not written as CSV, by how names end.
const NO_TABLES: [&str; 12] =
    ["json", "html", "svg", "png", "pdf", "dxf", "xlsx", "ods", "mat", "parquet", "toml", "fmu"];

/// Tables are CSV: never under a name that promises something else.
pub fn is_table(path: Option<&Path>, instead: &str) -> Result<(), Failure> {
    let Some(path) = path.filter(|path| NO_TABLES.iter().any(|kind| has_extension(path, kind))) else { return Ok(()) };
    Err(Failure::Usage(format!(
        "cannot write `{}`: the table is CSV, let its name end with `.csv`{instead}",
        path.display()
    )))
}

/// Does a name end with this, in any case?
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// The file that a command writes if none is named: called after the scene's file, since several may have one name in them; after that name where
/// the file is `scene.toml`. Says so if it was there already.
pub fn after(scene: &Path, name: &str, extension: &str, format: MessageFormat) -> PathBuf {
    let stem = scene.file_stem().filter(|stem| *stem != "scene").map_or(name.into(), |stem| stem.to_string_lossy());
    let path = PathBuf::from(format!("{stem}.{extension}"));
    if path.exists() && format == MessageFormat::Human {
        failure::say(&format!("{} existed and is overwritten\n", path.display()));
    }
    path
}

/// Says on standard error what has been written.
pub fn wrote(path: &Path, what: &str, format: MessageFormat) {
    if format == MessageFormat::Human {
        failure::say(&format!("wrote {}: {what}\n", path.display()));
    }
}

/// Reads a scene file, or a scene from standard input if it is called `-`: its parts are looked for in the current folder.
pub fn load(path: &Path) -> Result<Scene, Failure> {
    if is_standard(path) {
        let mut bytes = Vec::new();
        let read = io::stdin().lock().take(Scene::LARGEST).read_to_end(&mut bytes);
        read.map_err(|error| Failure::file("read", path, error))?;
        return Ok(Scene::from_bytes(Path::new("standard input"), bytes)?);
    }
    // A file that cannot be read is no fault of the scene.
    let bytes = files::read(path, Scene::LARGEST).map_err(|error| Failure::file("read", path, unreadable(&error)))?;
    Ok(Scene::from_bytes(path, bytes)?)
}

/// A variable that was asked for elsewhere and does not exist is no fault of the scene.
pub fn unknown(faults: Faults, requested: &str) -> Failure {
    let is_asked = |fault: &&Fault| fault.kind() == FaultKind::UnknownOutput && fault.span.is_nowhere();
    let asked_for = faults.list.iter().filter(is_asked);
    let message = |fault: &Fault| {
        let message = fault.message.replace("the request names", &format!("{requested} names"));
        format!("{message}; {}", fault.help)
    };
    let messages: Vec<String> = asked_for.map(message).collect();
    if messages.is_empty() { Failure::Scene(faults) } else { Failure::Usage(messages.join("\n")) }
}

/// What a command does now, on standard error if that is a terminal.
pub fn spinner() -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_spinner());
    ProgressBar::new_spinner().with_style(style)
}

/// Reads a table of values over time.
pub fn table(path: &Path, naming: &Naming<'_>, format: MessageFormat) -> Result<CsvTable, Failure> {
    let table = table_by(path, |text| CsvTable::read(text, naming))?;
    warn_of_degrees(&table, path, naming, format);
    Ok(table)
}

/// Reads a table whose cells may be empty.
pub fn table_with_gaps(path: &Path, naming: &Naming<'_>, format: MessageFormat) -> Result<CsvTable, Failure> {
    let table = table_by(path, |text| CsvTable::read_with_gaps(text, naming))?;
    warn_of_degrees(&table, path, naming, format);
    Ok(table)
}

fn table_by(path: &Path, read: impl Fn(&str) -> Result<CsvTable, SheetError>) -> Result<CsvTable, Failure> {
    let bytes = files::read(path, LARGEST_TABLE).map_err(|error| Failure::file("read", path, error))?;
    let text = String::from_utf8(bytes).ok().filter(|text| !text.contains('\0')).ok_or_else(|| {
        Failure::file("read", path, "it is not a text file; an input table is CSV and begins with `time,name`")
    })?;
    read(&text).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

/// Shows on standard error which columns of a table look like degrees without saying so.
fn warn_of_degrees(table: &CsvTable, path: &Path, naming: &Naming<'_>, format: MessageFormat) {
    let found = table.suspect_degrees(naming.unit_of);
    let source = Source::new(path.display().to_string(), "");
    warn((!found.is_empty()).then(|| Faults::new(source, found)).as_ref(), format);
}

/// Why no scene can be read.
fn unreadable(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::FileTooLarge | io::ErrorKind::IsADirectory => format!("{error}, not a scene file"),
        _ => error.to_string(),
    }
}

/// Compiles a scene; its warnings go to standard error.
pub fn compile(scene: &Scene, format: MessageFormat) -> Result<Compiled, Failure> {
    compile_asking(scene, &Requested::Own, format)
}

/// As [`compile()`], with the outputs that are asked for.
pub fn compile_asking(scene: &Scene, requested: &Requested, format: MessageFormat) -> Result<Compiled, Failure> {
    let (compiled, _) = compile::compile_asking(scene, requested)?;
    warn(compiled.warnings.as_ref(), format);
    Ok(compiled)
}

/// Shows on standard error why a motion may be less accurate than asked for; `of` says in which runs.
pub fn warn_inaccurate(compiled: &Compiled, of: &str, inaccuracy: &Inaccuracy, format: MessageFormat) {
    let fault =
        Fault::warning("solver::accuracy", format!("{of}{inaccuracy}"), Span::default()).help(inaccuracy.help());
    warn(Some(&Faults::new(compiled.source.clone(), vec![fault])), format);
}

/// Shows on standard error which event has ended a run, and why a motion may be less accurate than asked for.
pub fn tell_end(compiled: &Compiled, finish: &Finish, format: MessageFormat) {
    if let Some((event, time)) = &finish.ended
        && format == MessageFormat::Human
    {
        super::failure::say(&format!("event `{event}` ends the run at t = {time} s\n"));
    }
    if let Some(inaccuracy) = &finish.inaccuracy {
        warn_inaccurate(compiled, "", inaccuracy, format);
    }
}

/// Shows on standard error which variables have no value in rows of a run.
pub fn warn_gaps(scene: &Scene, gaps: &Gaps, names: &[&str], format: MessageFormat) {
    let fault = gaps.warning(names, |name| output_span(scene, name));
    let faults = fault.map(|fault| Faults::new(scene.source.clone(), vec![fault]));
    warn(faults.as_ref(), format);
}

/// Where a scene asks for an output; nowhere if the command line does.
pub fn output_span(scene: &Scene, name: &str) -> Span {
    let outputs = &scene.outputs;
    let named = outputs.variables.iter().chain(outputs.expressions.iter().map(|output| &output.name));
    named.into_iter().find(|text| text.text == name).map_or_else(Span::default, |text| text.span)
}

/// Shows warnings, if there are any, on standard error.
pub fn warn(warnings: Option<&Faults>, format: MessageFormat) {
    let Some(warnings) = warnings else { return };
    match format {
        MessageFormat::Human => failure::warn(warnings),
        MessageFormat::Json => failure::say(&format!("{}\n", warnings.to_json())),
    }
}
