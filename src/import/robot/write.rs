//! A planar robot as the text of a scene, with the report at its head.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::closing::{self, ClosedStart};
use super::planar::{LinkPoint, PlanarClosure, PlanarCoordinate, PlanarModel};
use super::{Closure, ClosureKind, JointLaws, JointMotion, SpatialJoint};
use crate::import::options::ImportOptions;
use crate::import::refusal::ImportRefusal;
use crate::import::report::ImportReport;
use crate::model::identifier;
use crate::typeset::counted;

/// Names that a scene gives a meaning of its own, of its parts and of points of bodies.
const RESERVED: &[&str] = &["ground", "energy", "constraint", "time", "t", "pi", "g", "world"];
const VARIABLES: &[&str] = &["x", "y", "angle", "vx", "vy", "omega", "ax", "ay", "alpha", "power"];

/// A number as a scene has it.
pub fn number(value: f64) -> String {
    // Minus zero is zero.
    format!("{:?}", value + 0.0)
}

pub fn pair([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", number(x), number(y))
}

/// What is being written.
pub struct RobotWriter<'a> {
    pub planar: &'a PlanarModel<'a>,
    taken: BTreeSet<String>,
    /// The next number of a name that is taken.
    numbered: BTreeMap<String, usize>,
    pub links: Vec<String>,
    /// The scene's names of the joints that are coordinates.
    pub joints: Vec<Option<String>>,
    points: Vec<Vec<(String, [f64; 2])>>,
    /// The same by their names.
    places: Vec<BTreeMap<String, [f64; 2]>>,
    /// Massless bodies that couplings need.
    pub wheel_text: String,
    pub inputs: String,
    pub states: String,
    pub joint_text: String,
    pub load_text: String,
    pub outputs: Vec<String>,
    pub report: &'a mut ImportReport,
    renamed: Vec<String>,
}

/// The scene.
pub fn scene(
    name: &str,
    planar: &PlanarModel,
    start: &ClosedStart,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> String {
    let mut writer = RobotWriter {
        planar,
        taken: RESERVED.iter().map(|name| (*name).to_owned()).collect(),
        numbered: BTreeMap::new(),
        links: Vec::new(),
        joints: Vec::new(),
        points: vec![Vec::new(); planar.links.len()],
        places: vec![BTreeMap::new(); planar.links.len()],
        wheel_text: String::new(),
        inputs: String::new(),
        states: String::new(),
        joint_text: String::new(),
        load_text: String::new(),
        outputs: Vec::new(),
        report,
        renamed: Vec::new(),
    };
    writer.name_parts();
    for (link, link_data) in planar.links.iter().enumerate() {
        for (name, at) in &link_data.points {
            writer.place(link, name, *at);
        }
    }
    (0..planar.coordinates.len()).for_each(|index| writer.tree_joint(index));
    (0..planar.closures.len()).for_each(|index| writer.closure(index));
    planar.followers.iter().for_each(|follower| writer.follower(follower));
    writer.forces(options);
    writer.head_lines(start);
    writer.text(name, start)
}

impl RobotWriter<'_> {
    /// A name that is free, with a suffix if the file's is taken.
    pub fn fresh(&mut self, name: &str, suffix: &str, otherwise: &str) -> String {
        let plain = identifier(if name.is_empty() { otherwise } else { name });
        let first = [plain.clone(), format!("{plain}_{suffix}")].into_iter();
        let from = self.numbered.get(&plain).copied().unwrap_or(2);
        let mut candidates = first.chain((from..).map(|number| format!("{plain}_{number}")));
        let fresh_name = candidates.find(|name| !self.taken.contains(name)).unwrap_or_else(|| plain.clone());
        self.numbered.insert(plain, from + 1);
        let is_of_file = !matches!(suffix, "contact" | "output" | "load");
        if !name.is_empty() && fresh_name != name && is_of_file {
            self.renamed.push(format!("{suffix} `{name}` is `{fresh_name}`"));
        }
        self.taken.insert(fresh_name.clone());
        fresh_name
    }

    fn name_parts(&mut self) {
        let planar = self.planar;
        for (index, link) in planar.links.iter().enumerate() {
            let name =
                if index == 0 { "ground".to_owned() } else { self.fresh(&link.name, "body", &format!("body_{index}")) };
            self.links.push(name);
        }
        for coordinate in &planar.coordinates {
            let joint = coordinate.joint().map(|joint| &planar.file.joints[joint]);
            let name = joint.map(|joint| self.fresh(&joint.name, "joint", "joint"));
            self.joints.push(name);
        }
    }

    /// The scene's name of a place on a link.
    pub fn place(&mut self, link: usize, name: &str, at: [f64; 2]) -> String {
        let mut plain = identifier(if name.is_empty() { "point" } else { name });
        if VARIABLES.contains(&plain.as_str()) {
            plain.push_str("_point");
        }
        let mut point_name = plain.clone();
        let mut number = 2;
        while self.places[link].get(&point_name).is_some_and(|known| *known != at) {
            point_name = format!("{plain}_{number}");
            number += 1;
        }
        if self.places[link].insert(point_name.clone(), at).is_none() {
            self.points[link].push((point_name.clone(), at));
        }
        format!("{}.{point_name}", self.links[link])
    }

    fn joint_of(&self, index: usize) -> Option<&SpatialJoint> {
        self.planar.coordinates[index].joint().map(|joint| &self.planar.file.joints[joint])
    }

    fn tree_joint(&mut self, index: usize) {
        let planar = self.planar;
        let coordinate = planar.coordinates[index];
        let Some(joint) = coordinate.joint().map(|joint| &planar.file.joints[joint]) else { return };
        let name = self.joints[index].clone().unwrap_or_default();
        let (kind, parent, child, at, sign, axis) = match coordinate {
            PlanarCoordinate::Turn { parent, child, at, sign, .. } => ("revolute", parent, child, at, sign, None),
            PlanarCoordinate::Slide { parent, child, at, along, .. } => {
                ("prismatic", parent, child, at, 1.0, Some(along))
            }
            _ => return,
        };
        let ends = [parent, child].map(|link| self.place(link, &name, at));
        let mut text =
            format!("\n[joints.{name}]\ntype    = \"{kind}\"\nbetween = [\"{}\", \"{}\"]\n", ends[0], ends[1]);
        if let Some(axis) = axis {
            text += &format!("axis    = {}\n", pair(axis));
        }
        text += &self.joint_keys(&joint.laws, sign);
        self.joint_text += &text;
        let word = if axis.is_some() { "slide" } else { "hinge" };
        self.report.exact(word);
        self.joint_output(joint, &name, sign, index);
    }

    /// What acts along a joint.
    fn joint_keys(&mut self, laws: &JointLaws, sign: f64) -> String {
        let mut text = String::new();
        let mut key = |name: &str, value: String, word: &str, report: &mut ImportReport| {
            text += &format!("{name:<7} = {value}\n");
            report.exact(word);
        };
        if laws.damping != 0.0 {
            key("damping", number(laws.damping), "damping", self.report);
        }
        if laws.armature != 0.0 {
            key("armature", number(laws.armature), "armature", self.report);
        }
        if laws.friction != 0.0 {
            key(
                "friction",
                format!("{{ coulomb = {} }}", number(laws.friction)),
                "Coulomb friction with sticking",
                self.report,
            );
        }
        if let Some([low, high]) = laws.range {
            let [min, max] = if sign < 0.0 { [-high, -low] } else { [low, high] };
            key("limits", format!("{{ min = {}, max = {} }}", number(min), number(max)), "limits", self.report);
        }
        text
    }

    /// The coordinate with the file's name, sign and zero.
    fn joint_output(&mut self, joint: &SpatialJoint, name: &str, sign: f64, index: usize) {
        let variable = if self.planar.coordinates[index].turns() { "angle" } else { "s" };
        let term = format!("{}{name}.{variable}", if sign < 0.0 { "-" } else { "" });
        let value = if joint.zero == 0.0 { term.clone() } else { format!("{term} + {}", number(joint.zero)) };
        if joint.kind == JointMotion::Ball {
            return;
        }
        let named = if joint.name.is_empty() { name } else { &joint.name };
        let output = self.fresh(&format!("q_{named}"), "output", "q");
        self.outputs.push(format!("{output} = \"{value}\""));
    }

    fn closure(&mut self, index: usize) {
        let planar = self.planar;
        let file: &Closure = &planar.file.closures[planar.closure_sources[index]];
        let name = self.fresh(&file.name, "joint", "closure");
        let ends = planar.closures[index].ends().map(|(link, at)| self.place(link, &name, at));
        let (kind, more, word) = match planar.closures[index] {
            PlanarClosure::Pin(_) => ("revolute", String::new(), "loop closed by a revolute joint"),
            PlanarClosure::Weld(_, angle) => {
                ("weld", format!("angle   = {}\n", number(angle)), "loop closed by a weld")
            }
            PlanarClosure::Slide(_, along) => {
                ("prismatic", format!("axis    = {}\n", pair(along)), "loop closed by a slide")
            }
        };
        let sign = match &file.kind {
            ClosureKind::Hinge(axis) => {
                let axis = planar.world[file.ends[0].body] * axis;
                if axis.dot(&planar.plane.normal) < 0.0 { -1.0 } else { 1.0 }
            }
            ClosureKind::Slide(_) | ClosureKind::Point | ClosureKind::Weld(_) => 1.0,
        };
        let keys = self.joint_keys(&file.laws, sign);
        self.joint_text += &format!(
            "\n[joints.{name}]\ntype    = \"{kind}\"\nbetween = [\"{}\", \"{}\"]\n{more}{keys}",
            ends[0], ends[1]
        );
        self.report.exact(word);
        let Some([stiffness, relaxed]) = file.laws.spring.filter(|[stiffness, _]| *stiffness != 0.0) else { return };
        match kind {
            "revolute" => {
                let links = planar.closures[index].ends().map(|(link, _)| link);
                self.torsion_spring(&name, links, stiffness, sign * relaxed);
            }
            _ => self.report.refuse(
                ImportRefusal::new(format!("slide `{name}` closes a loop and has a spring, which is not imported"))
                    .at(&file.place)
                    .help("name its links the other way round, so that another joint closes the loop"),
            ),
        }
    }

    /// The spring of a hinge.
    pub fn torsion_spring(&mut self, joint: &str, links: [usize; 2], stiffness: f64, angle: f64) {
        let name = self.fresh(&format!("{joint}_spring"), "load", "spring");
        let [from, to] = links.map(|link| self.links[link].clone());
        self.load_text += &format!(
            "\n[loads.{name}]\ntype    = \"torsion_spring\"\nbetween = [\"{from}\", \"{to}\"]\nstiffness = {}\nangle   = {}\n",
            number(stiffness),
            number(angle)
        );
        self.report.exact("spring of a joint");
    }

    fn head_lines(&mut self, start: &ClosedStart) {
        let planar = self.planar;
        let freedom = start.independent.iter().filter(|is_free| **is_free).count();
        let inputs = self.inputs.lines().count();
        let count = |count: usize, word: &str| counted(count, word);
        let bodies = counted(planar.links.len() - 1, "body");
        let joints = planar.coordinates.iter().filter(|coordinate| coordinate.joint().is_some()).count();
        let degrees =
            if freedom == 1 { "1 degree of freedom".to_owned() } else { format!("{freedom} degrees of freedom") };
        self.report.head.push(format!(
            "{}: {bodies}, {}, {}, {degrees}, {}",
            planar.file.format,
            count(joints, "joint"),
            count(planar.closures.len(), "loop"),
            count(inputs, "input")
        ));
        let signs = planar.coordinates.iter().filter_map(|coordinate| match coordinate {
            PlanarCoordinate::Turn { sign, .. } => Some(*sign),
            _ => None,
        });
        let turned = match (signs.clone().any(|sign| sign < 0.0), signs.clone().any(|sign| sign > 0.0)) {
            (true, true) => {
                "; hinges against the normal have the opposite sign in the scene, outputs q_JOINT have that of the file"
            }
            (true, false) => {
                "; the hinges are against its normal, so scene angles are minus the file's (outputs q_JOINT have the file's signs)"
            }
            (false, _) => "",
        };
        self.report.head.push(format!("plane: {}{turned}", planar.plane.called()));
        let gravity = planar.file.gravity.dot(&planar.plane.normal).abs();
        if gravity > 1e-9 && planar.gravity == [0.0; 2] {
            self.report.note("gravity is along the hinges and has no component in the plane");
        } else if gravity > 1e-9 {
            self.report.approximated(format!("gravity of {gravity:.4} m/s2 along the normal is dropped"));
        }
        if !self.renamed.is_empty() {
            self.report.note(format!("renamed: {}", self.renamed.join(", ")));
        }
    }

    fn text(mut self, name: &str, start: &ClosedStart) -> String {
        let initial = self.initial(start);
        let planar = self.planar;
        let mut text = String::new();
        for line in self.report.lines() {
            for part in line.lines() {
                text +=
                    &format!("# {}\n", part.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>());
            }
        }
        let title: String = planar.file.name.chars().filter(|c| !c.is_control() && !matches!(c, '"' | '\\')).collect();
        let title = if title.is_empty() { String::new() } else { format!("description = \"{title}\"\n") };
        text += &format!("format = 1\nname   = \"{}\"\n{title}", identifier(name));
        if planar.gravity != [0.0; 2] {
            text += &format!("gravity = {}               # m/s2\n", pair(planar.gravity));
        }
        for (section, lines) in [("inputs", &self.inputs), ("states", &self.states)] {
            if !lines.is_empty() {
                text += &format!("\n[{section}]\n{lines}");
            }
        }
        for link in 0..planar.links.len() {
            text += &self.link_text(link);
        }
        text += &self.wheel_text;
        text += &self.joint_text;
        text += &self.load_text;
        text +=
            &format!("\n# All angles are measured from the reference configuration of the file.\n[initial]\n{initial}");
        let bodies =
            self.links[1..].iter().flat_map(|name| ["x", "y", "angle"].map(|suffix| format!("\"{name}.{suffix}\"")));
        let bodies = bodies.collect::<Vec<_>>().join(", ");
        text += &format!("\n[outputs]\nvariables = [{bodies}]\n");
        if !self.outputs.is_empty() {
            text += &format!("# The joints with the signs and zeros of the file.\n{}\n", self.outputs.join("\n"));
        }
        text + "\n[experiment]\nstop = 2\nstep = 0.01\n"
    }

    fn link_text(&self, index: usize) -> String {
        let link = &self.planar.links[index];
        let points = self.points[index]
            .iter()
            .map(|(name, at)| format!("{name} = {}", pair([at[0] - link.origin[0], at[1] - link.origin[1]])));
        let points: Vec<String> = points.collect();
        if index == 0 {
            return match points.is_empty() {
                true => String::new(),
                false => format!("\n[ground.points]                      # m\n{}\n", points.join("\n")),
            };
        }
        let mut text = format!(
            "\n[bodies.{}]\nmass    = {}\ninertia = {}\n",
            self.links[index],
            number(link.mass),
            number(link.inertia)
        );
        let com = [link.centre[0] - link.origin[0], link.centre[1] - link.origin[1]];
        if com != [0.0; 2] {
            text += &format!("com     = {}\n", pair(com));
        }
        if link.weightless {
            text += "gravity = false\n";
        }
        if !points.is_empty() {
            text += &format!("points  = {{ {} }}\n", points.join(", "));
        }
        text
    }

    /// Independent coordinates are given, with all their rates if anything moves: a scene chooses the rates that it is not given. Bodies behind the other
    /// coordinates have guesses.
    fn initial(&mut self, start: &ClosedStart) -> String {
        let planar = self.planar;
        let poses = closing::poses(planar, &start.values);
        let moves = start.rates.iter().any(|rate| *rate != 0.0);
        let mut text = String::new();
        for (index, coordinate) in planar.coordinates.iter().enumerate() {
            let (value, rate, given) = (start.values[index], start.rates[index], start.independent[index]);
            let child = coordinate.child();
            let body = &self.links[child];
            let joint_name = self.joints[index].clone().unwrap_or_default();
            let mut line = |variable: String, rate_of: String, sign: f64, about: f64| {
                // Writing to a string cannot fail.
                let _ = match given {
                    true => writeln!(text, "\"{variable}\" = {}", number(sign * value)),
                    false => writeln!(text, "\"{variable}\" = {{ guess = {} }}", number(about)),
                };
                if given && moves {
                    let _ = writeln!(text, "\"{rate_of}\" = {}", number(sign * rate));
                }
            };
            match *coordinate {
                PlanarCoordinate::Turn { sign, .. } if given => {
                    line(format!("{joint_name}.angle"), format!("{joint_name}.omega"), sign, 0.0);
                }
                PlanarCoordinate::Turn { .. } => line(format!("{body}.angle"), String::new(), 1.0, poses[child].1),
                PlanarCoordinate::Slide { .. } => {
                    line(format!("{joint_name}.s"), format!("{joint_name}.v"), 1.0, value)
                }
                PlanarCoordinate::FreeX(_) | PlanarCoordinate::FreeY(_) => {
                    let part = usize::from(matches!(coordinate, PlanarCoordinate::FreeY(_)));
                    let link = &planar.links[child];
                    let at = closing::place_of(&poses[child], link.origin, link.centre);
                    let arm = [at[0] - poses[child].0[0], at[1] - poses[child].0[1]];
                    let spin = start.rates[index + 2 - part];
                    let speed = rate + [-spin * arm[1], spin * arm[0]][part];
                    let axis = ["x", "y"][part];
                    let _ = match given {
                        true => writeln!(text, "\"{body}.{axis}\" = {}", number(at[part])),
                        false => writeln!(text, "\"{body}.{axis}\" = {{ guess = {} }}", number(at[part])),
                    };
                    if given && moves {
                        let _ = writeln!(text, "\"{body}.v{axis}\" = {}", number(speed));
                    }
                }
                PlanarCoordinate::FreeAngle(_) => line(format!("{body}.angle"), format!("{body}.omega"), 1.0, value),
            }
        }
        text
    }

    /// An effort of the file along a coordinate: a torque, or a force along the slide and its opposite.
    pub fn effort(&mut self, index: usize, name: &str, value: &str) {
        match self.planar.coordinates[index] {
            PlanarCoordinate::Turn { parent, child, sign, .. } => {
                let value = if sign < 0.0 { format!("-({value})") } else { value.to_owned() };
                let ends = [parent, child].map(|link| self.links[link].clone());
                self.load_text += &format!(
                    "\n[loads.{name}]\ntype    = \"torque\"\nbetween = [\"{}\", \"{}\"]\nvalue   = \"{value}\"\n",
                    ends[0], ends[1]
                );
            }
            PlanarCoordinate::Slide { parent, child, at, along, .. } => {
                let joint_name = self.joints[index].clone().unwrap_or_default();
                let on = self.place(child, &joint_name, at);
                self.force(name, &on, along, value, child != 0);
                if parent != 0 {
                    let on = self.place(parent, &joint_name, at);
                    let against = self.fresh(&format!("{name}_reaction"), "load", "load");
                    self.force(&against, &on, [-along[0], -along[1]], value, true);
                }
            }
            _ => {}
        }
    }

    fn force(&mut self, name: &str, on: &str, [x, y]: [f64; 2], value: &str, turns: bool) {
        let part = |factor: f64| match factor + 0.0 {
            0.0 => "0".to_owned(),
            1.0 => format!("\"{value}\""),
            factor => format!("\"{}*({value})\"", number(factor)),
        };
        let frame = if turns { "frame   = \"body\"\n" } else { "" };
        self.load_text += &format!(
            "\n[loads.{name}]\ntype    = \"force\"\non      = \"{on}\"\nvector  = [{}, {}]\n{frame}",
            part(x),
            part(y)
        );
    }

    /// The file's coordinate as an expression, and its rate.
    pub fn coordinate(&self, index: usize) -> [String; 2] {
        let name = self.joints[index].clone().unwrap_or_default();
        let zero = self.joint_of(index).map_or(0.0, |joint| joint.zero);
        let [value, rate] = match self.planar.coordinates[index] {
            PlanarCoordinate::Turn { sign, .. } if sign < 0.0 => [format!("-{name}.angle"), format!("-{name}.omega")],
            PlanarCoordinate::Turn { .. } => [format!("{name}.angle"), format!("{name}.omega")],
            _ => [format!("{name}.s"), format!("{name}.v")],
        };
        let value = if zero == 0.0 { value } else { format!("({value} + {})", number(zero)) };
        [value, rate]
    }

    /// The scene's names of two places.
    pub fn ends(&mut self, ends: [LinkPoint; 2], name: &str) -> [String; 2] {
        ends.map(|(link, at)| self.place(link, name, at))
    }
}
