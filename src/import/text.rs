//! A linkage as the text of a scene, with comments.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fmt::Write;

use super::linkage::{Drive, Force, Link, Linkage, PinKind};
use crate::mechanism::identifier;

/// Assumed where the file has no mass: kilograms of a metre, and the mass of what has no length.
const DENSITY: f64 = 1.0;
const LEAST: f64 = 0.1;

/// A scene, and what its reader should know.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene file.
    pub scene: String,
    /// What was assumed or left out.
    pub notes: Vec<String>,
}

/// Names as a scene has them, each once.
struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    fn new() -> Self {
        Names { taken: ["ground", "energy", "constraint", "time", "t", "pi", "g"].map(str::to_owned).into() }
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
struct Writer<'a> {
    linkage: &'a Linkage,
    /// The names of the points that pins are, on every link and on the ground.
    points: Vec<String>,
    bodies: Vec<String>,
    names: Names,
    text: String,
}

/// The linkage as a scene of that name.
///
/// # Errors
/// What makes it no mechanism.
pub fn scene(name: &str, linkage: &Linkage) -> Result<Imported, Vec<String>> {
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
    let mut of_points = Names::new();
    let mut names = Names::new();
    let mut writer = Writer {
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
    writer.tail();
    Ok(Imported { scene: writer.text, notes })
}

impl Writer<'_> {
    fn add(&mut self, text: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(text);
    }

    fn head(&mut self, name: &str, notes: &[String]) {
        let Linkage { program, title, gravity, .. } = self.linkage;
        let visible: String = title.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let of = if visible.is_empty() { String::new() } else { format!(": {visible}") };
        self.add(format_args!("# From {program}{of}\n"));
        for note in notes {
            self.add(format_args!("# {note}\n"));
        }
        self.add(format_args!("format = 1\nname   = \"{}\"\n", identifier(name)));
        match gravity {
            true => self.add(format_args!("gravity = [0, -9.81]               # m/s2\n")),
            false => self.add(format_args!("# gravity = [0, -9.81]             # m/s2; the file has none\n")),
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
    fn origin(&self, link: &Link) -> [f64; 2] {
        link.centre.unwrap_or_else(|| {
            let pins = link.pins.iter().map(|&pin| self.linkage.pins[pin].at);
            let sum = pins.fold([0.0, 0.0], |[x, y], [u, v]| [x + u, y + v]);
            sum.map(|x| x / link.pins.len() as f64)
        })
    }

    fn body(&mut self, index: usize, link: &Link) {
        let [x, y] = self.origin(link);
        let pins = link.pins.iter().map(|&pin| self.linkage.pins[pin].at);
        let points = link
            .pins
            .iter()
            .zip(pins.clone())
            .map(|(&pin, [u, v])| format!("{} = [{:?}, {:?}]", self.points[pin], u - x, v - y));
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

    /// All joints; returns for each pin and link the joint that turns the link there against the ground.
    fn joints(&mut self) -> Vec<(usize, usize, String)> {
        let linkage = self.linkage;
        let mut turned = Vec::new();
        for (index, pin) in linkage.pins.iter().enumerate() {
            let links: Vec<usize> =
                (0..linkage.links.len()).filter(|&link| linkage.links[link].pins.contains(&index)).collect();
            let point = self.points[index].clone();
            let on = |writer: &Self, link: usize| format!("{}.{point}", writer.bodies[link]);
            let ground = format!("ground.{point}");
            let Some(&first) = links.first() else { continue };
            let (held, others) = match pin.kind {
                PinKind::Turning if pin.grounded => (ground.clone(), &links[..]),
                _ => (on(self, first), &links[1..]),
            };
            if let Some((kind, [u, v])) = slide(pin.kind) {
                let second = on(self, first);
                let name = self.names.fresh(&format!("{}_guide", pin.name));
                self.add(format_args!(
                    "\n[joints.{name}]\ntype    = \"{kind}\"\nbetween = [\"{ground}\", \"{second}\"]\naxis    = [{u:?}, {v:?}]\n"
                ));
            }
            for &link in others {
                let name = self.names.fresh(&pin.name);
                let second = on(self, link);
                self.add(format_args!(
                    "\n[joints.{name}]\ntype    = \"revolute\"\nbetween = [\"{held}\", \"{second}\"]\n"
                ));
                if held == ground {
                    turned.push((index, link, name));
                }
            }
        }
        turned
    }

    fn drive(&mut self, drive: &Drive, turned: &[(usize, usize, String)], notes: &mut Vec<String>) {
        let Some((.., joint)) = turned.iter().find(|(pin, link, _)| (*pin, *link) == (drive.pin, drive.link)) else {
            let link = &self.linkage.links[drive.link].name;
            notes.push(format!("the drive of link `{link}` is left out: its pin does not hold it on the ground"));
            return;
        };
        let (joint, name) = (joint.clone(), self.names.fresh("drive"));
        let rate = drive.rate;
        self.add(format_args!(
            "\n# Angles count from the pose of the file.\n[drivers.{name}]\njoint = \"{joint}\"\nangle = \"{rate:?}*t\"            # rad, t in s\n"
        ));
    }

    fn force(&mut self, force: &Force) {
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
    fn tail(&mut self) {
        let linkage = self.linkage;
        let driven: Vec<usize> = linkage.drives.iter().map(|drive| drive.link).collect();
        let free: Vec<usize> = (0..linkage.links.len()).filter(|link| !driven.contains(link)).collect();
        self.text.push_str("\n# The pose of the file: all angles are zero there. It picks one of the ways to assemble the loops.\n[initial]\n");
        for &link in &free {
            let slides =
                linkage.links[link].pins.iter().any(|&pin| matches!(linkage.pins[pin].kind, PinKind::Sliding(_)));
            if !slides {
                let name = self.bodies[link].clone();
                self.add(format_args!("\"{name}.angle\" = {{ guess = 0 }}\n"));
            }
        }
        let angles: Vec<String> = self.bodies.iter().map(|body| format!("\"{body}.angle\"")).collect();
        let traced = linkage.pins.iter().enumerate().filter(|(_, pin)| pin.traced && !pin.grounded);
        let places = traced.filter_map(|(index, _)| {
            let link = linkage.links.iter().position(|link| link.pins.contains(&index))?;
            let point = format!("{}.{}", self.bodies[link], self.points[index]);
            Some(format!("\"{point}.x\", \"{point}.y\""))
        });
        let variables: Vec<String> = angles.into_iter().chain(places).collect();
        let rate = linkage.drives.iter().map(|drive| drive.rate.abs()).fold(0.0, f64::max);
        let stop = if rate > 0.0 { 2.0 * TAU / rate } else { 10.0 };
        let why = if rate > 0.0 { "  # two turns of the drive" } else { "" };
        self.add(format_args!(
            "\n[outputs]\nvariables = [{}]\n\n[experiment]\nstop = {stop:?}{why}\nstep = {:?}\n",
            variables.join(", "),
            stop / 500.0
        ));
    }
}

/// The joint that lets a pin slide on the ground, and along what.
fn slide(kind: PinKind) -> Option<(&'static str, [f64; 2])> {
    match kind {
        PinKind::Turning => None,
        PinKind::Sliding(axis) => Some(("prismatic", axis)),
        PinKind::Slot(axis) => Some(("slot", axis)),
    }
}
