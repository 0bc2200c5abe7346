//! A linkage as the text of a scene, with comments.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fmt::Write;

use super::linkage::{Drive, DriveLaw, ImportedLink, ImportedLinkage, LinkForce, PinKind};
use crate::model::identifier;

/// Assumed where the file has no mass: kilograms of a metre, and the mass of what has no length.
const DENSITY: f64 = 1.0;
const LEAST: f64 = 0.1;
/// Seconds of a run without a drive that turns, and rows of any run.
const UNDRIVEN: f64 = 10.0;
const SAMPLES: f64 = 500.0;

/// A scene, and what its reader should know.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene file.
    pub scene: String,
    /// What was assumed or left out.
    pub notes: Vec<String>,
}

impl Imported {
    /// With one thing more that its reader should know.
    pub(super) fn with(mut self, note: String) -> Self {
        self.notes.push(note);
        self
    }
}

/// Names as a scene has them, each once.
struct UniqueNames {
    taken: BTreeSet<String>,
}

impl UniqueNames {
    fn new() -> Self {
        UniqueNames { taken: ["ground", "energy", "constraint", "time", "t", "pi", "g"].map(str::to_owned).into() }
    }

    fn fresh(&mut self, name: &str) -> String {
        let plain = identifier(name);
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let name = std::iter::once(plain.clone()).chain(numbered).find(|name| !self.taken.contains(name));
        let name = name.unwrap_or(plain);
        self.taken.insert(name.clone());
        name
    }
}

/// A linkage whose parts have the names of a scene.
struct SceneWriter<'a> {
    linkage: &'a ImportedLinkage,
    /// The names of the points that pins are, on every link and on the ground.
    points: Vec<String>,
    bodies: Vec<String>,
    names: UniqueNames,
    text: String,
}

/// The linkage as a scene of that name, with a run that ends no later than it is said.
///
/// # Errors
/// What makes it no mechanism.
pub fn scene(name: &str, linkage: &ImportedLinkage, end: Option<f64>) -> Result<Imported, Vec<String>> {
    let mut faults = Vec::new();
    if linkage.links.is_empty() {
        faults.push("it has no link that moves".to_owned());
    }
    for link in linkage.links.iter().filter(|link| link.pins.is_empty()) {
        faults.push(format!("link `{}` has no joint", link.name));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut of_points = UniqueNames::new();
    let mut names = UniqueNames::new();
    let mut writer = SceneWriter {
        linkage,
        points: linkage.pins.iter().map(|pin| of_points.fresh(&pin.name)).collect(),
        bodies: linkage.links.iter().map(|link| names.fresh(&link.name)).collect(),
        names,
        text: String::new(),
    };
    let mut notes = linkage.notes.clone();
    writer.head(name, &notes);
    writer.ground();
    linkage.links.iter().enumerate().for_each(|(index, link)| writer.body(index, link));
    let turned = writer.joints();
    for drive in &linkage.drives {
        writer.drive(drive, &turned, &mut notes);
    }
    for force in &linkage.forces {
        writer.force(force);
    }
    writer.tail(end);
    Ok(Imported { scene: writer.text, notes })
}

impl SceneWriter<'_> {
    fn add(&mut self, text: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(text);
    }

    fn head(&mut self, name: &str, notes: &[String]) {
        let ImportedLinkage { program, title, gravity, .. } = self.linkage;
        let visible: String = title.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let of = if visible.is_empty() { String::new() } else { format!(": {visible}") };
        self.add(format_args!("# From {program}{of}\n"));
        for note in notes {
            self.add(format_args!("# {note}\n"));
        }
        self.add(format_args!("format = 1\nname   = \"{}\"\n", identifier(name)));
        match gravity {
            Some([x, y]) => {
                let [x, y] = [x, y].map(|part| if *part == 0.0 { "0".to_owned() } else { format!("{part:?}") });
                self.add(format_args!("gravity = [{x}, {y}]               # m/s2\n"));
            }
            None => self.add(format_args!("# gravity = [0, -9.81]             # m/s2; the file has none\n")),
        }
    }

    fn ground(&mut self) {
        let linkage = self.linkage;
        self.text.push_str("\n[ground.points]                      # m\n");
        for (index, pin) in linkage.pins.iter().enumerate().filter(|(_, pin)| pin.grounded) {
            let [x, y] = pin.at;
            let name = self.points[index].clone();
            self.add(format_args!("{name} = [{x:?}, {y:?}]\n"));
        }
    }

    /// Where the frame of a body has its origin: the frames are not turned in the pose of the file.
    fn origin(&self, link: &ImportedLink) -> [f64; 2] {
        link.centre.unwrap_or_else(|| {
            let pins = link.pins.iter().map(|&pin| self.linkage.pins[pin].at);
            let sum = pins.fold([0.0, 0.0], |[x, y], [u, v]| [x + u, y + v]);
            sum.map(|x| x / link.pins.len() as f64)
        })
    }

    fn body(&mut self, index: usize, link: &ImportedLink) {
        let [x, y] = self.origin(link);
        let pins = link.pins.iter().map(|&pin| self.linkage.pins[pin].at);
        let guided = self
            .linkage
            .pins
            .iter()
            .enumerate()
            .filter(|(_, pin)| pin.kind.guide().is_some_and(|guide| guide.on == Some(index)));
        let marked = link.pins.iter().copied().chain(guided.map(|(pin, _)| pin).filter(|pin| !link.pins.contains(pin)));
        let points = marked.map(|pin| {
            let [u, v] = self.linkage.pins[pin].at;
            format!("{} = [{:?}, {:?}]", self.points[pin], u - x, v - y)
        });
        let points = points.collect::<Vec<_>>().join(", ");
        let length = 2.0 * pins.map(|[u, v]| (u - x).hypot(v - y)).fold(0.0, f64::max);
        let mass = link.mass.unwrap_or_else(|| (DENSITY * length).max(LEAST));
        let inertia = link.inertia.unwrap_or(mass * length.max(0.1) * length.max(0.1) / 12.0);
        let assumed = |known: bool| if known { "" } else { "               # assumed" };
        let name = self.bodies[index].clone();
        let (of_mass, of_inertia) = (assumed(link.mass.is_some()), assumed(link.inertia.is_some()));
        self.add(format_args!(
            "\n[bodies.{name}]\nmass    = {mass:?}{of_mass}\ninertia = {inertia:?}{of_inertia}\npoints  = {{ {points} }}\n"
        ));
    }

    /// All joints.
    fn joints(&mut self) -> Vec<PinJoint> {
        let linkage = self.linkage;
        let mut joints = Vec::new();
        for (index, pin) in linkage.pins.iter().enumerate() {
            let links: Vec<usize> =
                (0..linkage.links.len()).filter(|&link| linkage.links[link].pins.contains(&index)).collect();
            let Some(&first) = links.first() else { continue };
            let held = self.point_on(Some(first), index);
            let ground = self.point_on(None, index);
            if let Some(SlidingJoint { kind, on, along: [u, v] }) = slide(pin.kind) {
                let name = self.names.fresh(&format!("{}_guide", pin.name));
                let guide = self.point_on(on, index);
                self.add(format_args!(
                    "\n[joints.{name}]\ntype    = \"{kind}\"\nbetween = [\"{guide}\", \"{held}\"]\naxis    = [{u:?}, {v:?}]\n"
                ));
                joints.push(PinJoint { pin: index, link: first, joint: name });
            } else if pin.grounded {
                let joint = self.joint("revolute", &pin.name, [&ground, &held]);
                joints.push(PinJoint { pin: index, link: first, joint });
            }
            let onto = if pin.grounded && pin.kind == PinKind::Turning && !pin.welded { &ground } else { &held };
            for &link in &links[1..] {
                let kind = if pin.welded { "weld" } else { "revolute" };
                let second = self.point_on(Some(link), index);
                let joint = self.joint(kind, &pin.name, [onto, &second]);
                joints.push(PinJoint { pin: index, link, joint });
            }
        }
        joints
    }

    /// The point that a pin is on a link, or on the ground.
    fn point_on(&self, link: Option<usize>, pin: usize) -> String {
        let body = link.map_or("ground", |link| self.bodies[link].as_str());
        format!("{body}.{}", self.points[pin])
    }

    fn joint(&mut self, kind: &str, name: &str, [first, second]: [&String; 2]) -> String {
        let name = self.names.fresh(name);
        self.add(format_args!("\n[joints.{name}]\ntype    = \"{kind}\"\nbetween = [\"{first}\", \"{second}\"]\n"));
        name
    }

    fn drive(&mut self, drive: &Drive, joints: &[PinJoint], notes: &mut Vec<String>) {
        let Some(PinJoint { joint, .. }) = joints.iter().find(|one| (one.pin, one.link) == (drive.pin, drive.link))
        else {
            let link = &self.linkage.links[drive.link].name;
            notes.push(format!("the drive of link `{link}` is left out: its pin is not on the ground"));
            return;
        };
        let (joint, name) = (joint.clone(), self.names.fresh("drive"));
        let (counts, key, unit) = match self.linkage.pins[drive.pin].kind {
            PinKind::Turning => ("Angles count", "angle", "rad"),
            PinKind::Sliding(_) | PinKind::Slot(_) => ("The displacement counts", "displacement", "m"),
        };
        let law = law(drive.course);
        self.add(format_args!(
            "\n# {counts} from the configuration of the file.\n[drivers.{name}]\njoint = \"{joint}\"\n{key} = \"{law}\"            # {unit}, t in s\n"
        ));
    }

    fn force(&mut self, force: &LinkForce) {
        let [x, y] = self.origin(&self.linkage.links[force.link]);
        let (name, body) = (self.names.fresh(&force.name), self.bodies[force.link].clone());
        let [at_x, at_y] = [force.at[0] - x, force.at[1] - y];
        let [u, v] = force.vector;
        let frame = if force.turns { "frame  = \"body\"\n" } else { "" };
        self.add(format_args!(
            "\n# It acts on the point {name} of {body}.\n[loads.{name}]\ntype   = \"force\"\non     = \"{body}.{name}\"\nvector = [{u:?}, {v:?}]            # N\n{frame}"
        ));
        // The point that the force acts on.
        let points = format!("[bodies.{body}]");
        if let Some(start) = self.text.find(&points)
            && let Some(end) = self.text[start..].find(" }\n")
        {
            self.text.insert_str(start + end, &format!(", {name} = [{at_x:?}, {at_y:?}]"));
        }
    }

    /// Guesses, outputs, times.
    fn tail(&mut self, end: Option<f64>) {
        let linkage = self.linkage;
        self.text.push_str("\n# The configuration of the file: all angles are zero there. The guesses choose the assembly mode.\n[initial]\n");
        let guessed = self.bodies.iter().enumerate().filter(|(link, _)| !self.angle_is_known(*link));
        let guesses: String = guessed.map(|(_, name)| format!("\"{name}.angle\" = {{ guess = 0 }}\n")).collect();
        self.text.push_str(&guesses);
        let angles: Vec<String> = self.bodies.iter().map(|body| format!("\"{body}.angle\"")).collect();
        let traced = linkage.pins.iter().enumerate().filter(|(_, pin)| pin.traced && !pin.grounded);
        let places = traced.filter_map(|(index, _)| {
            let link = linkage.links.iter().position(|link| link.pins.contains(&index))?;
            let point = format!("{}.{}", self.bodies[link], self.points[index]);
            Some(format!("\"{point}.x\", \"{point}.y\""))
        });
        let variables: Vec<String> = angles.into_iter().chain(places).collect();
        let (stop, why) = end.map_or_else(|| self.stop(), |end| (end, "  # the motion ends there"));
        self.add(format_args!(
            "\n[outputs]\nvariables = [{}]\n\n[experiment]\nstop = {stop:?}{why}\nstep = {:?}\n",
            variables.join(", "),
            stop / SAMPLES
        ));
    }

    /// Is the angle of a link given, by a drive against the ground or because it cannot turn?
    fn angle_is_known(&self, link: usize) -> bool {
        let linkage = self.linkage;
        let driven = |drive: &Drive| drive.link == link && linkage.pins[drive.pin].grounded;
        let slides = |pin: usize| matches!(linkage.pins[pin].kind, PinKind::Sliding(guide) if guide.on.is_none());
        linkage.drives.iter().any(driven) || linkage.links[link].pins.iter().any(|&pin| slides(pin))
    }

    /// How long the drives are looked at, and why so long.
    fn stop(&self) -> (f64, &'static str) {
        let period = |drive: &Drive| match (drive.course, self.linkage.pins[drive.pin].kind) {
            (DriveLaw::ToAndFro { rate, from, to }, _) => Some((2.0 * (to - from) / rate, "  # twice to and fro")),
            (DriveLaw::Steady(rate), PinKind::Turning) => Some((TAU / rate.abs(), "  # two turns of the drive")),
            (DriveLaw::Steady(_), PinKind::Sliding(_) | PinKind::Slot(_)) => None,
        };
        let shortest = self.linkage.drives.iter().filter_map(period).filter(|(period, _)| period.is_finite());
        let shortest = shortest.min_by(|(one, _), (other, _)| one.total_cmp(other));
        shortest.map_or((UNDRIVEN, ""), |(period, why)| (2.0 * period, why))
    }
}

/// The joint that moves a link at a pin.
struct PinJoint {
    pin: usize,
    link: usize,
    joint: String,
}

/// The joint that lets a pin slide.
struct SlidingJoint {
    kind: &'static str,
    /// On which link; else on the ground.
    on: Option<usize>,
    along: [f64; 2],
}

fn slide(kind: PinKind) -> Option<SlidingJoint> {
    match kind {
        PinKind::Turning => None,
        PinKind::Sliding(guide) => Some(SlidingJoint { kind: "prismatic", on: guide.on, along: guide.along }),
        PinKind::Slot(guide) => Some(SlidingJoint { kind: "slot", on: guide.on, along: guide.along }),
    }
}

/// The motion of a drive over time, from zero in the pose of the file.
fn law(course: DriveLaw) -> String {
    match course {
        DriveLaw::Steady(rate) => format!("{rate:?}*t"),
        // How far it is from the turning point below, without its returns; it goes back over what exceeds the way up.
        DriveLaw::ToAndFro { rate, from, to } => {
            let (way, below, twice) = (to - from, -from, 2.0 * (to - from));
            let far = format!("{rate:?}*t + {below:?}");
            format!("{to:?} - abs({way:?} - ({far} - {twice:?}*floor(({far})/{twice:?})))")
        }
    }
}
