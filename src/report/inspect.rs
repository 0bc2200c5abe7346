//! Reads an FMU of cotree back.

use std::collections::HashSet;
use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use cotree_fmu::fmi3::token;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::{Experiment, Program};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use zip::ZipArchive;
use zip::result::ZipError;

use crate::cells;
use crate::diagnostic::visible::on_one_line;
use crate::model::{CREDITS, Credits};
use crate::program::Type;
use crate::typeset::{aligned, between, short};

/// No file inside an FMU of cotree is larger than this [bytes].
const LARGEST: u64 = 1 << 28;

/// Nobody reads more variables than this, and a table of a million is wider than any screen and takes seconds to lay out.
const MOST_SHOWN: usize = 1000;

/// What an FMU of cotree says of itself.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The scene's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Who made the model, and how it may be used.
    pub credits: Credits,
    /// The version of FMI, such as `2.0`.
    pub version: String,
    /// The program that made it.
    pub tool: String,
    /// What it must be instantiated with.
    pub guid: String,
    /// `Co-Simulation`, `Model Exchange`.
    pub interfaces: Vec<&'static str>,
    pub experiment: Experiment,
    /// Why it cannot start with the values in it, if it cannot.
    pub no_start: Option<String>,
    /// The platforms it runs on, with the size of their shared libraries \[bytes\].
    pub platforms: Vec<(String, u64)>,
    pub variables: Vec<InspectedVariable>,
    /// Size of the file \[bytes\].
    pub size: u64,
    /// The text of the scene it was made from, if that was a file.
    pub scene: Option<String>,
}

/// A variable as the model description has it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InspectedVariable {
    pub name: String,
    /// `parameter`, `input`, `output`, `local` or `independent`.
    pub causality: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// Value at the start, if it can be set.
    pub start: Option<String>,
    /// Is that a guess, which picks the assembly?
    pub guess: bool,
    /// When its value may change: `fixed`, `tunable`, `discrete` or `continuous`.
    pub variability: String,
    /// Smallest permitted value.
    pub min: Option<String>,
    /// Largest permitted value.
    pub max: Option<String>,
    /// One line; may be empty.
    pub description: String,
}

/// Why an FMU cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct InspectError(pub String);

crate::diagnostic::from_messages!(InspectError as InspectError: std::io::Error);

impl From<ZipError> for InspectError {
    fn from(error: ZipError) -> Self {
        InspectError(format!("it is damaged or incomplete: {error}"))
    }
}

crate::diagnostic::from_messages!(InspectError as InspectError: cotree_fmu::program::storage::LoadError);

/// It is a good description of another model, or the program is another's.
fn strangers(why: &str) -> InspectError {
    InspectError(format!(
        "it is damaged: its modelDescription.xml and its program belong to different models ({why}); export it again"
    ))
}

type Archive = ZipArchive<BufReader<File>>;

impl Contents {
    /// Reads an FMU.
    ///
    /// # Errors
    /// It cannot be read, is damaged, or was not made by cotree.
    pub fn read(path: &Path) -> Result<Self, InspectError> {
        let (mut file, size) = open(path)?;
        let mut begin = [0; 2];
        if size < 2 || file.read_exact(&mut begin).is_err() || begin != *b"PK" {
            return Err(InspectError("it is not an FMU: it is not a zip archive".to_owned()));
        }
        let mut archive = Archive::new(BufReader::new(file))?;
        let description = entry(&mut archive, "modelDescription.xml")?
            .ok_or_else(|| InspectError("it is not an FMU: it has no modelDescription.xml".to_owned()))?;
        let header = Header::parse(&description)?;
        if !header.tool.starts_with("cotree ") {
            return Err(InspectError(format!(
                "it was made by {}, not by cotree",
                if header.tool.is_empty() { "another program" } else { header.tool.as_str() }
            )));
        }
        let program = entry(&mut archive, cotree_fmu::PROGRAM_FILE)?;
        let program = Program::from_bytes(&program.ok_or_else(|| {
            InspectError(format!("it is incomplete: it has no {0}; export it again", cotree_fmu::PROGRAM_FILE))
        })?)?;
        let expected = if header.version.starts_with('2') { program.guid.clone() } else { token(&program.guid) };
        if header.guid != expected {
            return Err(strangers("their GUIDs differ"));
        }
        // FMI 3.0 has more than the program: the time, derivatives of inputs.
        let described: HashSet<&str> = header.variables.iter().map(|variable| variable.name.as_str()).collect();
        if !program.variables.iter().all(|variable| described.contains(variable.name.as_str())) {
            return Err(strangers("their variables differ"));
        }
        let mut scene = None;
        for name in ["resources/scene.toml", "resources/scene.json"] {
            scene = scene.or(entry(&mut archive, name)?);
        }
        let (experiment, guid) = (program.experiment, program.guid.clone());
        Ok(Self {
            platforms: platforms(&mut archive)?,
            experiment,
            guid,
            no_start: why_no_start(program),
            name: header.name,
            description: header.description,
            credits: header.credits,
            version: header.version,
            tool: header.tool,
            interfaces: header.interfaces,
            variables: header.variables,
            size,
            scene: scene.map(|text| String::from_utf8_lossy(&text).into_owned()),
        })
    }
}

/// Why a model does not start with its own values; none where it does.
fn why_no_start(program: Program) -> Option<String> {
    let model = match Model::new(program) {
        Ok(model) => model,
        Err(fault) => return Some(fault.to_string()),
    };
    Instance::boxed(Arc::new(model)).initialise().err().map(|failure| failure.to_string())
}

/// An ordinary file and its size.
fn open(path: &Path) -> Result<(File, u64), InspectError> {
    let data = std::fs::metadata(path)?;
    match data {
        _ if data.is_dir() => Err(InspectError(format!("it is {0}, not an FMU", "a folder"))),
        _ if !data.is_file() => Err(InspectError(format!("it is {0}, not an FMU", "a pipe or a device"))),
        _ => Ok((File::open(path)?, data.len())),
    }
}

/// A file of the archive, if it is there.
fn entry(archive: &mut Archive, name: &str) -> Result<Option<Vec<u8>>, InspectError> {
    let mut content = Vec::new();
    let file = match archive.by_name(name) {
        Ok(file) => file,
        Err(ZipError::FileNotFound) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    if file.take(LARGEST + 1).read_to_end(&mut content)? as u64 > LARGEST {
        return Err(InspectError(format!("its `{name}` is larger than any that cotree writes")));
    }
    Ok(Some(content))
}

/// Folders of shared libraries, with the libraries' sizes.
fn platforms(archive: &mut Archive) -> Result<Vec<(String, u64)>, InspectError> {
    let mut platforms = Vec::new();
    for index in 0..archive.len() {
        let file = archive.by_index_raw(index)?;
        let name = file.name().map(|name| name.into_owned()).unwrap_or_default();
        if let Some((platform, _)) = name.strip_prefix("binaries/").and_then(|rest| rest.split_once('/')) {
            platforms.push((platform.to_owned(), file.size()));
        }
    }
    platforms.sort();
    Ok(platforms)
}

/// What the model description says.
#[derive(Default)]
struct Header {
    name: String,
    description: String,
    credits: Credits,
    version: String,
    tool: String,
    guid: String,
    interfaces: Vec<&'static str>,
    variables: Vec<InspectedVariable>,
}

impl Header {
    fn parse(document: &[u8]) -> Result<Self, InspectError> {
        let damaged = |error: &dyn fmt::Display| InspectError(format!("its modelDescription.xml is damaged: {error}"));
        let mut reader = Reader::from_reader(document);
        let (mut header, mut buffer, mut depth) = (Self::default(), Vec::new(), 0_u32);
        loop {
            match reader.read_event_into(&mut buffer).map_err(|error| damaged(&error))? {
                Event::Start(tag) => {
                    depth += 1;
                    header.add(&tag).map_err(|error| damaged(&error))?;
                }
                Event::Empty(tag) => header.add(&tag).map_err(|error| damaged(&error))?,
                Event::End(_) => depth = depth.saturating_sub(1),
                // The reader takes an end in the middle of elements for an end.
                Event::Eof if depth > 0 => return Err(damaged(&"it is truncated")),
                Event::Eof => return Ok(header),
                _ => {}
            }
            buffer.clear();
        }
    }

    fn add(&mut self, tag: &BytesStart) -> Result<(), quick_xml::Error> {
        let get = |key: &str| -> Result<Option<String>, quick_xml::Error> {
            let Some(attribute) = tag.try_get_attribute(key)? else { return Ok(None) };
            Ok(Some(quick_xml::escape::unescape(&attribute.value)?.into_owned()))
        };
        let text = |key: &str| get(key).map(Option::unwrap_or_default);
        let name = tag.name();
        let name = name.as_ref();
        let is_type = |version: usize| Type::ALL.iter().any(|kind| kind.elements()[version] == name);
        match name {
            "fmiModelDescription" => {
                (self.name, self.description) = (text("modelName")?, text("description")?);
                for key in CREDITS {
                    self.credits.extend(get(key)?.map(|text| (key, text)));
                }
                (self.tool, self.version) = (text("generationTool")?, text("fmiVersion")?);
                self.guid = text(if self.version.starts_with('2') { "guid" } else { "instantiationToken" })?;
            }
            "CoSimulation" => self.interfaces.push("Co-Simulation"),
            "ModelExchange" => self.interfaces.push("Model Exchange"),
            "ScalarVariable" => self.add_variable(&get)?,
            // FMI 2.0 writes the values of a variable in an element of their own.
            _ if self.version.starts_with('2') && is_type(0) => self.add_values(&get)?,
            _ if is_type(1) => self.add_variable(&get)?,
            _ => {}
        }
        Ok(())
    }
}

impl Header {
    fn add_variable<E>(&mut self, get: &impl Fn(&str) -> Result<Option<String>, E>) -> Result<(), E> {
        let text = |key: &str| get(key).map(Option::unwrap_or_default);
        self.variables.push(InspectedVariable {
            name: text("name")?,
            causality: get("causality")?.unwrap_or_else(|| "local".into()),
            description: text("description")?,
            variability: text("variability")?,
            guess: text("initial")? == "approx",
            ..InspectedVariable::default()
        });
        self.add_values(get)
    }

    fn add_values<E>(&mut self, get: &impl Fn(&str) -> Result<Option<String>, E>) -> Result<(), E> {
        if let Some(variable) = self.variables.last_mut() {
            (variable.unit, variable.start) = (get("unit")?.unwrap_or_default(), get("start")?);
            (variable.min, variable.max) = (get("min")?, get("max")?);
        }
        Ok(())
    }
}

impl InspectedVariable {
    fn start(&self) -> String {
        let what = if self.guess { "guess" } else { "start" };
        self.start.as_ref().map(|start| format!("{what} {start}")).unwrap_or_default()
    }

    /// What values it may have, and when it may change.
    fn remark(&self) -> String {
        let changes =
            Some(&self.variability).filter(|variability| ["tunable", "discrete"].contains(&variability.as_str()));
        let parts = [changes.cloned(), between([self.min.clone(), self.max.clone()])];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for Contents {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Experiment { start, stop, step, tolerance, .. } = self.experiment;
        let [start, stop, step] = [start, stop, step].map(short);
        let platforms = self.platforms.iter().map(|(name, size)| format!("{name} ({})", kilobytes(*size)));
        let scene = if self.scene.is_some() { "included: print it with --scene" } else { "not inside" };
        let mut facts: Vec<Vec<String>> = self.credits.iter().map(|(key, text)| cells![key, text]).collect();
        facts.extend([
            cells!["made by", self.tool],
            cells!["guid", self.guid],
            cells!["interfaces", format!("FMI {} {}", self.version, self.interfaces.join(", "))],
            cells!["platforms", platforms.collect::<Vec<_>>().join(", ")],
            cells!["experiment", format!("{start} s to {stop} s, step {step} s, tolerance {tolerance:?}")],
            cells!["size", kilobytes(self.size)],
            cells!["scene", scene],
        ]);
        facts.extend(self.no_start.iter().map(|why| cells!["start", format!("fails: {why}")]));
        let variable = |variable: &InspectedVariable| {
            cells![
                variable.causality,
                variable.name,
                variable.unit,
                variable.start(),
                variable.remark(),
                variable.description
            ]
        };
        let table = |rows: Vec<Vec<String>>| {
            let rows = rows.iter().map(|row| row.iter().map(|cell| on_one_line(cell)).collect());
            aligned(&rows.collect::<Vec<_>>(), usize::MAX, "  ")
        };
        let about = if self.description.is_empty() { String::new() } else { format!(": {}", self.description) };
        let shown = self.variables.iter().take(MOST_SHOWN).map(variable);
        let tables = [facts, shown.collect()].map(table).concat();
        write!(f, "{}\n{tables}", on_one_line(&format!("{}{about}", self.name)))?;
        match self.variables.len().saturating_sub(MOST_SHOWN) {
            0 => Ok(()),
            further => writeln!(f, "  and {further} further variables: all are in its modelDescription.xml"),
        }
    }
}

fn kilobytes(size: u64) -> String {
    format!("{} kB", size.div_ceil(1000))
}
