//! MJCF, the XML of MuJoCo, as a model in space.

mod actuators;
pub mod attributes;
mod bodies;
mod constraints;
mod contacts;
mod geometry;
mod keyframes;
mod resolve;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Vector3};

use self::attributes::{AttributeClass, GENERATED, REFUSED, class_of, is_idle, knows};
use self::contacts::ContactGeom;
use self::resolve::{AngleUnits, Defaults};
use super::Includes;
use super::options::ImportOptions;
use super::refusal::{Fallible, ImportRefusal};
use super::report::ImportReport;
use super::robot::{SpatialModel, Tendon};
use super::xml::{self, XmlElement};

/// What the compiler's settings are.
struct CompilerSettings {
    angles: AngleUnits,
    autolimits: bool,
    balance: bool,
    least_mass: f64,
    least_inertia: f64,
    /// Mass from geoms: always, never, or where there is no inertial.
    from_geoms: Option<bool>,
    groups: [f64; 2],
    total_mass: Option<f64>,
}

/// The option flags that change the motion.
struct Enabled {
    gravity: bool,
    contact: bool,
    limit: bool,
    frictionloss: bool,
    equality: bool,
    spring: bool,
    damper: bool,
    actuation: bool,
    clamp: bool,
}

/// Places of sites and names of what others refer to.
struct MjcfReader<'a> {
    settings: CompilerSettings,
    enabled: Enabled,
    defaults: Defaults<'a>,
    model: SpatialModel,
    options: &'a ImportOptions,
    report: &'a mut ImportReport,
    sites: BTreeMap<String, (usize, Isometry3<f64>)>,
    geoms: Vec<ContactGeom>,
    body_names: BTreeMap<String, usize>,
    joint_names: BTreeMap<String, usize>,
    /// `springref` of each joint.
    relaxed_joints: Vec<f64>,
    spatial_tendons: BTreeMap<String, super::robot::Course>,
    fixed_tendons: BTreeMap<String, Tendon>,
    /// For each actuator of the file, in order: its place in the model unless it is left out, and how many numbers `act` has for it.
    controls: Vec<(Option<usize>, usize)>,
    /// Lines and columns of elements that are refused or left out as a whole.
    dropped: BTreeSet<(usize, usize)>,
}

/// The model in a document.
///
/// # Errors
/// What the document says that MuJoCo would not read, or that cannot be imported.
pub fn read(
    root: &mut XmlElement,
    options: &ImportOptions,
    includes: Includes,
    report: &mut ImportReport,
) -> Fallible<SpatialModel> {
    let mut seen = BTreeSet::new();
    include(root, includes, &mut seen)?;
    check_names(root)?;
    refuse_generated(root, report)?;
    let settings = settings(root)?;
    let enabled = enabled(root)?;
    let mut gravity = Vector3::new(0.0, 0.0, -9.81);
    for option in root.all("option") {
        if let Some(attribute) = option.attribute("gravity") {
            gravity = Vector3::from(attribute.array::<3>()?);
        }
    }
    if !enabled.gravity {
        gravity = Vector3::zeros();
    }
    let name = root.get("model").unwrap_or_default().to_owned();
    let mut reader = MjcfReader {
        settings,
        enabled,
        defaults: Defaults::new(root)?,
        model: SpatialModel::new("MJCF", &name, gravity),
        options,
        report,
        sites: BTreeMap::new(),
        geoms: Vec::new(),
        body_names: BTreeMap::new(),
        joint_names: BTreeMap::new(),
        relaxed_joints: Vec::new(),
        spatial_tendons: BTreeMap::new(),
        fixed_tendons: BTreeMap::new(),
        controls: Vec::new(),
        dropped: BTreeSet::new(),
    };
    reader.fluid(root)?;
    reader.bodies(root)?;
    reader.tendons(root)?;
    reader.constraints(root)?;
    reader.actuators(root)?;
    reader.contacts(root)?;
    reader.keyframes(root)?;
    reader.refuse_unread(root, &mut vec!["mujoco"]);
    Ok(reader.model)
}

/// Puts included files into the tree: relative to the main file, each once.
fn include(element: &mut XmlElement, includes: Includes, seen: &mut BTreeSet<String>) -> Fallible<()> {
    let mut children = Vec::new();
    for mut child in std::mem::take(&mut element.children) {
        if child.name != "include" {
            include(&mut child, includes, seen)?;
            children.push(child);
            continue;
        }
        let file = child.must("file")?.to_owned();
        if !seen.insert(file.clone()) {
            return Err(child.refuse(format!("`{file}` is included twice; MuJoCo includes each file once")));
        }
        let bytes = includes(&file).ok_or_else(|| {
            child
                .refuse(format!("the included file `{file}` cannot be read"))
                .help("it is looked for beside the main file")
        })?;
        let text = xml::decode(&bytes).map_err(|why| child.refuse(format!("`{file}`: {why}")))?;
        let mut included = xml::parse(&file, &text)?;
        include(&mut included, includes, seen)?;
        children.append(&mut included.children);
    }
    element.children = children;
    Ok(())
}

/// Unknown elements and attributes are errors, as in MuJoCo: nothing is passed over because it is misspelt.
fn check_names(root: &XmlElement) -> Fallible<()> {
    fn check<'a>(element: &'a XmlElement, path: &mut Vec<&'a str>) -> Fallible<()> {
        for attribute in &element.attributes {
            if class_of(path, &attribute.name).is_none() {
                return Err(ImportRefusal::new(format!(
                    "{}: MJCF has no attribute `{}` here",
                    element.called(),
                    attribute.name
                ))
                .at(&attribute.place));
            }
        }
        for child in &element.children {
            let near = &path[path.len().saturating_sub(attributes::DEEPEST)..];
            let inert = near.iter().zip(near.iter().skip(1)).any(|(parent, name)| is_idle(parent, name))
                || REFUSED.contains(path.last().unwrap_or(&""));
            if !inert && !knows(path.last().unwrap_or(&""), &child.name) {
                return Err(child.refuse(format!("MJCF has no element <{}> here", child.name)));
            }
            path.push(&child.name);
            check(child, path)?;
            path.pop();
        }
        Ok(())
    }
    check(root, &mut vec!["mujoco"])
}

/// What makes bodies that are not in the file, before anything refers to one of them. All but the first are in the report.
fn refuse_generated(root: &XmlElement, report: &mut ImportReport) -> Fallible<()> {
    fn find<'e>(element: &'e XmlElement, found: &mut Vec<&'e XmlElement>) {
        for child in &element.children {
            match GENERATED.contains(&child.name.as_str()) {
                true => found.push(child),
                false => find(child, found),
            }
        }
    }
    let mut found = Vec::new();
    find(root, &mut found);
    let mut refusals = found.into_iter().map(|element| {
        element
            .refuse(format!("<{}> makes bodies that are not in the file", element.name))
            .help("load the model in MuJoCo, save it with mj_saveLastXML, and import that file")
    });
    let first = refusals.next();
    refusals.for_each(|refusal| report.refuse(refusal));
    first.map_or(Ok(()), Err)
}

fn settings(root: &XmlElement) -> Fallible<CompilerSettings> {
    let mut settings = CompilerSettings {
        angles: AngleUnits { unit: 1f64.to_radians(), sequence: "xyz".to_owned() },
        autolimits: true,
        balance: false,
        least_mass: 0.0,
        least_inertia: 0.0,
        from_geoms: None,
        groups: [0.0, 5.0],
        total_mass: None,
    };
    for compiler in root.all("compiler") {
        let flag = |name: &str| match compiler.get(name) {
            None => Ok(None),
            Some("true") => Ok(Some(true)),
            Some("false") => Ok(Some(false)),
            Some(other) => Err(compiler.refuse(format!("`{name}` is `{other}`, but must be `true` or `false`"))),
        };
        match compiler.get("angle") {
            Some("radian") => settings.angles.unit = 1.0,
            Some("degree") => settings.angles.unit = 1f64.to_radians(),
            None => {}
            Some(other) => {
                return Err(compiler.refuse(format!("`angle` is `{other}`, but must be `degree` or `radian`")));
            }
        }
        if let Some(sequence) = compiler.get("eulerseq") {
            if sequence.len() != 3 || !sequence.chars().all(|letter| "xyzXYZ".contains(letter)) {
                return Err(
                    compiler.refuse(format!("`eulerseq` is `{sequence}`, but must be three of x, y, z, X, Y, Z"))
                );
            }
            settings.angles.sequence = sequence.to_owned();
        }
        if compiler.get("coordinate").is_some_and(|value| value != "local") {
            return Err(compiler
                .refuse("`coordinate` is `global`, which MuJoCo no longer reads")
                .help("convert the file with MuJoCo 2.3.3"));
        }
        settings.autolimits = flag("autolimits")?.unwrap_or(settings.autolimits);
        settings.balance = flag("balanceinertia")?.unwrap_or(settings.balance);
        settings.from_geoms = match compiler.get("inertiafromgeom") {
            Some("auto") => None,
            Some(_) => flag("inertiafromgeom")?,
            None => settings.from_geoms,
        };
        let number = |name: &str| compiler.attribute(name).map(|attribute| attribute.number()).transpose();
        settings.least_mass = number("boundmass")?.unwrap_or(settings.least_mass);
        settings.least_inertia = number("boundinertia")?.unwrap_or(settings.least_inertia);
        settings.total_mass = number("settotalmass")?.or(settings.total_mass).filter(|mass| *mass > 0.0);
        if let Some(groups) = compiler.attribute("inertiagrouprange") {
            settings.groups = groups.array::<2>()?;
        }
    }
    Ok(settings)
}

fn enabled(root: &XmlElement) -> Fallible<Enabled> {
    let disabled = |name: &str| {
        let flags = root.all("option").flat_map(|option| option.children.iter().filter(|child| child.name == "flag"));
        flags.filter_map(|flag| flag.get(name)).any(|value| value == "disable")
    };
    let (all, passive) = (!disabled("constraint"), !disabled("passive"));
    Ok(Enabled {
        gravity: !disabled("gravity"),
        contact: all && !disabled("contact"),
        limit: all && !disabled("limit"),
        frictionloss: all && !disabled("frictionloss"),
        equality: all && !disabled("equality"),
        spring: passive && !disabled("spring"),
        damper: passive && !disabled("damper"),
        actuation: !disabled("actuation"),
        clamp: !disabled("clampctrl"),
    })
}

impl MjcfReader<'_> {
    /// Refuses what acts, unless the user leaves it out.
    fn refuse_or_leave(&mut self, element: &XmlElement, kind: &str, why: impl Into<String>) {
        self.dropped.insert((element.place.line, element.place.column));
        let name = element.attribute("name").map_or("", |name| &name.value);
        self.report.refuse_or_leave(element, self.options, &[name, kind], &why.into());
    }

    /// Fluid forces act on every body.
    fn fluid(&mut self, root: &XmlElement) -> Fallible<()> {
        for option in root.all("option") {
            for name in ["density", "viscosity"] {
                let Some(attribute) = option.attribute(name) else { continue };
                if attribute.number()? > 0.0 {
                    self.refuse_or_leave(
                        option,
                        "fluid",
                        format!("a fluid acts on all bodies: `{name}` is {}", attribute.value),
                    );
                }
            }
            option.attribute("wind").map(|attribute| attribute.value());
        }
        Ok(())
    }

    /// What nothing has read: without effect, or it acts.
    fn refuse_unread<'e>(&mut self, element: &'e XmlElement, path: &mut Vec<&'e str>) {
        let name = path.last().copied().unwrap_or_default();
        let parent = path.len().checked_sub(2).map_or("", |index| path[index]);
        if is_idle(parent, name) {
            self.report.idle(format!("<{name}>"));
            return;
        }
        if parent == "default" && REFUSED.contains(&name) {
            return;
        }
        if REFUSED.contains(&name) {
            if parent != "actuator" && name != "pulley" {
                self.refuse_or_leave(element, name, format!("{} acts and has no counterpart", element.called()));
            }
            return;
        }
        if self.dropped.contains(&(element.place.line, element.place.column)) {
            return;
        }
        for attribute in &element.attributes {
            match class_of(path, &attribute.name) {
                Some(AttributeClass::Refused) if acts(&attribute.name, &attribute.value) => {
                    let message = format!(
                        "{}: `{}` is `{}`, which acts and has no counterpart",
                        element.called(),
                        attribute.name,
                        attribute.value
                    );
                    if self.options.leaves_out(&[
                        &attribute.name,
                        element.attribute("name").map_or("", |attribute| &attribute.value),
                    ]) {
                        self.report.left_out.push(message);
                    } else {
                        let help = format!("--leave-out {} imports the file without it", attribute.name);
                        self.report.refuse(ImportRefusal::new(message).at(&attribute.place).help(help));
                    }
                }
                Some(AttributeClass::Approximated) => {
                    self.report.approximated(format!(
                        "`{}`, the softness of MuJoCo's constraints, is replaced by exact ones",
                        attribute.name
                    ));
                }
                Some(AttributeClass::Exact | AttributeClass::Idle | AttributeClass::Refused) | None => {}
            }
        }
        for child in &element.children {
            path.push(&child.name);
            self.refuse_unread(child, path);
            path.pop();
        }
    }
}

/// Does an attribute act with this value? Zeros do not.
fn acts(name: &str, value: &str) -> bool {
    let zero = xml::numbers(value).is_ok_and(|numbers| numbers.iter().all(|number| *number == 0.0));
    let off = matches!(value, "false" | "none" | "auto");
    let unlimited = name == "range" && value.is_empty();
    !(zero || off || unlimited)
}
