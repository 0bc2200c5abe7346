//! `cotree import`

use std::cell::Cell;
use std::path::{Component, Path, PathBuf};

use clap::{Args, ValueEnum};
use cotree::files;
use cotree::import::{ContactChoice, DxfOptions, ImportOptions, Imported, WorldPlane, import_file};
use cotree::model::identifier;

use super::failure::{self, Failure};
use super::{MessageFormat, output};

/// Nobody writes a mechanism of more bytes by hand, nor does a converter.
const LARGEST: u64 = 50 << 20;

/// Import a linkage, a robot or a drawing as a commented scene
///
/// Reads `.pmks` files of PMKS+ and its addresses (in a text file), JSON of pylinkage, robots as MJCF, URDF or SDF, and drawings as DXF. The format is found
/// from the content. Each line of the report says what is exact, approximated, or left out; a load that cannot be imported is an error.
#[derive(Args)]
#[command(after_help = "Examples:
  cotree import linkage.pmks
  cotree import fourbar.json -o four_bar.toml
  cotree import robot.xml --lock wrist
  cotree import arm.urdf --root gripper -o gripper.toml
  cotree import sketch.dxf --unit mm --ground 0,0 --gravity")]
pub struct ImportCommand {
    /// File of PMKS+, pylinkage, MuJoCo (MJCF), ROS (URDF), Gazebo (SDF), or a drawing (DXF)
    file: PathBuf,
    /// Output file of the scene [default: the name of the file, .toml, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Plane of the motion, instead of the one across the hinges
    #[arg(long, help_heading = "Robots")]
    plane: Option<PlaneArgument>,
    /// Joints to lock at their start value
    #[arg(long, value_name = "JOINT,...", value_delimiter = ',', help_heading = "Robots")]
    lock: Vec<String>,
    /// Import only the subtree of this body, which becomes the ground
    #[arg(long, value_name = "BODY", help_heading = "Robots")]
    root: Option<String>,
    /// Restrict free bodies and ball joints to the plane
    #[arg(long, help_heading = "Robots")]
    in_plane: bool,
    /// Leave out loads that cannot be imported, by their name or kind (`muscle`, `tendon`, `fluid`), or `all`
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', help_heading = "Robots")]
    leave_out: Vec<String>,
    /// Folders in which included models are looked for, beside the folder of the file; may be given several times
    #[arg(long, value_name = "FOLDER", help_heading = "Robots")]
    model_path: Vec<PathBuf>,
    /// Keyframe from which the motion starts [default: the only one, else the reference configuration]
    #[arg(long, value_name = "NAME|NUMBER", help_heading = "Robots")]
    key: Option<String>,
    /// Contacts: none, those of the floor with spheres, capsules and boxes, or also those between spheres
    #[arg(long, default_value = "floor", help_heading = "Robots")]
    contacts: ContactArgument,
    /// Gravity of a drawing, m/s2; without a value 0,-9.81
    #[arg(long, value_name = "X,Y", num_args = 0..=1, default_missing_value = "0,-9.81", value_parser = pair, help_heading = "Drawings")]
    gravity: Option<[f64; 2]>,
    /// Unit of the drawing (mm, cm, m, in, ft), instead of the one in the file
    #[arg(long, value_name = "UNIT", value_parser = length_unit, help_heading = "Drawings")]
    unit: Option<f64>,
    /// Largest distance of ends that are joined, such as 0.1mm
    #[arg(long, value_name = "LENGTH", value_parser = length, help_heading = "Drawings")]
    snap: Option<f64>,
    /// Position of a pin on the ground, in the units of the drawing; may be given several times
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, help_heading = "Drawings")]
    ground: Vec<[f64; 2]>,
    /// Role of a layer: links, pins, ground, sliders, guides, tracers, springs or ignored
    #[arg(long, value_name = "NAME=ROLE", value_parser = layer, help_heading = "Drawings")]
    layer: Vec<(String, String)>,
    /// Mass per length of lines, such as "1 kg/m"
    #[arg(long, value_name = "DENSITY", value_parser = line_density, help_heading = "Drawings")]
    line_density: Option<f64>,
    /// Closed outlines are plates of this density and thickness, such as "7850 kg/m3,5 mm"
    #[arg(long, value_name = "DENSITY,THICKNESS", value_parser = plate, help_heading = "Drawings")]
    plate: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum PlaneArgument {
    Xy,
    Xz,
    Yz,
}

#[derive(Clone, Copy, ValueEnum)]
enum ContactArgument {
    None,
    Floor,
    All,
}

fn number(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("`{text}` is not a finite number")) }
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let (x, y) =
        text.split_once(',').ok_or_else(|| format!("`{text}` must be two numbers with a comma, such as 0,-9.81"))?;
    Ok([number(x)?, number(y)?])
}

fn length_unit(text: &str) -> Result<f64, String> {
    const UNITS: [(&str, f64); 8] = [
        ("mm", 1e-3),
        ("cm", 1e-2),
        ("m", 1.0),
        ("in", 0.0254),
        ("inch", 0.0254),
        ("ft", 0.3048),
        ("um", 1e-6),
        ("km", 1e3),
    ];
    let known = UNITS.iter().find(|(name, _)| *name == text.trim());
    known.map(|(_, metres)| *metres).ok_or_else(|| format!("`{text}` is not a unit of length: mm, cm, m, in or ft"))
}

/// A positive number with a unit.
fn with_unit(text: &str) -> Result<(f64, &str), String> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E').unwrap_or(text.len());
    let value = number(&text[..end])?;
    if value > 0.0 { Ok((value, text[end..].trim())) } else { Err(format!("`{text}` must be positive")) }
}

fn length(text: &str) -> Result<f64, String> {
    let (value, unit) = with_unit(text)?;
    if unit.is_empty() {
        return Err(format!("`{text}` needs a unit, such as {value} mm"));
    }
    Ok(value * length_unit(unit)?)
}

fn line_density(text: &str) -> Result<f64, String> {
    match with_unit(text)? {
        (value, "kg/m" | "") => Ok(value),
        (value, "g/mm") => Ok(value),
        (value, "g/m") => Ok(value * 1e-3),
        (_, unit) => Err(format!("`{unit}` is not a mass per length: write kg/m")),
    }
}

/// kg/m2
fn plate(text: &str) -> Result<f64, String> {
    let (density, thickness) =
        text.split_once(',').ok_or("write a density and a thickness, such as \"7850 kg/m3,5 mm\"")?;
    let density = match with_unit(density)? {
        (value, "kg/m3" | "") => value,
        (value, "g/cm3") => value * 1e3,
        (_, unit) => return Err(format!("`{unit}` is not a density: write kg/m3")),
    };
    Ok(density * length(thickness)?)
}

fn layer(text: &str) -> Result<(String, String), String> {
    const ROLES: [&str; 8] = ["links", "pins", "ground", "sliders", "guides", "tracers", "springs", "ignored"];
    let (name, role) = text.split_once('=').ok_or_else(|| format!("`{text}` must be NAME=ROLE"))?;
    let role = role.to_lowercase();
    match ROLES.contains(&role.as_str()) {
        true => Ok((name.to_owned(), role)),
        false => Err(format!("`{role}` is not a role: {}", ROLES.join(", "))),
    }
}

impl ImportCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let stem = self.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let given = self.output.clone();
        let path = given.unwrap_or_else(|| PathBuf::from(format!("{}.toml", identifier(&stem))));
        output::apart(&[Some(&self.file)], &[Some(&path)])?;
        if path.exists() {
            return Err(Failure::Usage(format!("`{}` exists already; choose another name with -o", path.display())));
        }
        let bytes = files::read(&self.file, LARGEST).map_err(|error| Failure::file("read", &self.file, error))?;
        let name = path.file_stem().map_or(stem, |stem| stem.to_string_lossy().into_owned());
        let shown = self.file.file_name().map_or_else(|| "file".to_owned(), |name| name.to_string_lossy().into_owned());
        let beside_file = self.file.parent().unwrap_or(Path::new("")).to_owned();
        let folders: Vec<PathBuf> = std::iter::once(beside_file).chain(self.model_path.iter().cloned()).collect();
        let left = Cell::new(LARGEST.saturating_sub(bytes.len() as u64));
        let include = |file: &str| folders.iter().find_map(|folder| included(folder, file, &left));
        let file = self.file.clone();
        let imported = import_file(&name, &shown, &bytes, &self.options(), &include);
        let Imported { scene, notes } =
            imported.map_err(|faults| Failure::file("import", &file, faults.join("\n  ")))?;
        output::write(&path, &scene)?;
        if format == MessageFormat::Human {
            notes.iter().for_each(|note| failure::say(&format!("note: {note}\n")));
        }
        output::print(&format!("{0}\nNext: cotree check {0}\n", path.display()))
    }

    fn options(self) -> ImportOptions {
        ImportOptions {
            plane: self.plane.map(|plane| match plane {
                PlaneArgument::Xy => WorldPlane::Xy,
                PlaneArgument::Xz => WorldPlane::Xz,
                PlaneArgument::Yz => WorldPlane::Yz,
            }),
            lock: self.lock,
            root: self.root,
            in_plane: self.in_plane,
            leave_out: self.leave_out,
            key: self.key,
            contacts: match self.contacts {
                ContactArgument::None => ContactChoice::None,
                ContactArgument::Floor => ContactChoice::Floor,
                ContactArgument::All => ContactChoice::All,
            },
            gravity: self.gravity,
            dxf: DxfOptions {
                unit: self.unit,
                snap: self.snap,
                ground: self.ground,
                layers: self.layer,
                line_density: self.line_density,
                plate: self.plate,
            },
        }
    }
}

/// A file that another names by a relative path; all together no larger than one may be.
fn included(folder: &Path, file: &str, left: &Cell<u64>) -> Option<Vec<u8>> {
    let is_relative = Path::new(file)
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir | Component::ParentDir));
    let bytes = is_relative.then(|| files::read(&folder.join(file), left.get()).ok()).flatten()?;
    left.set(left.get().saturating_sub(bytes.len() as u64));
    Some(bytes)
}
