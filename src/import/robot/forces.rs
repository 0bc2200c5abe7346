//! Springs, tendons and actuators as loads and joints of the scene.

use super::planar::LinkPoint;
use super::write::{RobotWriter, number};
use super::{Activation, BodyPoint, Course, CourseBend, PointSpring, SpatialActuator, Transmission};
use crate::import::options::{ContactChoice, ImportOptions};
use crate::import::refusal::{FilePlace, ImportRefusal};

/// How far the cosine of the angle between the axis of a cylinder and the normal of the plane may be from one.
const OBLIQUE: f64 = 1e-6;

impl RobotWriter<'_> {
    pub fn forces(&mut self, options: &ImportOptions) {
        let file = self.planar.file;
        for index in 0..self.planar.coordinates.len() {
            self.joint_spring(index);
        }
        for tendon in &file.tendons {
            if let Some([length, rate]) = self.sum(&tendon.terms) {
                let [low, high] = tendon.relaxed;
                let mut laws = Vec::new();
                if tendon.stiffness != 0.0 {
                    laws.push(format!("-{}*({})", number(tendon.stiffness), beyond(&length, low, high)));
                }
                if tendon.damping != 0.0 {
                    laws.push(format!("-{}*({rate})", number(tendon.damping)));
                }
                let law = laws.join(" ");
                if !law.is_empty() {
                    self.efforts(&tendon.name, "tendon", &tendon.terms, &law);
                    self.report.exact("fixed tendon");
                }
            }
        }
        file.springs.iter().for_each(|spring| self.point_spring(spring));
        for bushing in &file.bushings {
            let [Some(a), Some(b)] = bushing.ends.each_ref().map(|end| self.planar.point(end)) else { continue };
            let name = self.fresh(&bushing.name, "load", "bushing");
            let [a, b] = self.ends([a, b], &name);
            self.load_text += &format!(
                "\n[loads.{name}]\ntype    = \"bushing\"\nbetween = [\"{a}\", \"{b}\"]\nstiffness = {}\ndamping = {}\ntorsion_stiffness = {}\ntorsion_damping = {}\n",
                number(bushing.stiffness),
                number(bushing.damping),
                number(bushing.torsion_stiffness),
                number(bushing.torsion_damping)
            );
            self.report.exact("bushing");
        }
        file.actuators.iter().for_each(|actuator| self.actuator(actuator));
        if options.contacts != ContactChoice::None {
            file.contacts.iter().for_each(|contact| self.contact(contact, options));
        }
    }

    fn joint_spring(&mut self, index: usize) {
        let planar = self.planar;
        let Some(joint) = planar.coordinates[index].joint().map(|joint| &planar.file.joints[joint]) else { return };
        let Some([stiffness, relaxed]) = joint.laws.spring.filter(|[stiffness, _]| *stiffness != 0.0) else { return };
        let joint_name = self.joints[index].clone().unwrap_or_default();
        if let super::planar::PlanarCoordinate::Turn { parent, child, sign, .. } = planar.coordinates[index] {
            self.torsion_spring(&joint_name, [parent, child], stiffness, sign * relaxed);
            return;
        }
        let name = self.fresh(&format!("{joint_name}_spring"), "load", "spring");
        let law = format!("-{}*({joint_name}.s - {})", number(stiffness), number(relaxed));
        self.effort(index, &name, &law);
        self.report.exact("spring of a joint");
    }

    /// A sum of file coordinates and its rate; none if a joint is not there.
    fn sum(&self, terms: &[(usize, f64)]) -> Option<[String; 2]> {
        let mut sums = [Vec::new(), Vec::new()];
        for &(joint, factor) in terms {
            let Some(index) = self.planar.coordinate_of(joint) else {
                // A locked joint adds a constant.
                let joint_data = &self.planar.file.joints[joint];
                sums[0].push(number(factor * (joint_data.zero + joint_data.start)));
                continue;
            };
            for (sum, term) in sums.iter_mut().zip(self.coordinate(index)) {
                sum.push(if factor == 1.0 { term } else { format!("{}*({term})", number(factor)) });
            }
        }
        let [length, rate] = sums;
        (!rate.is_empty()).then(|| [length.join(" + "), rate.join(" + ")])
    }

    /// An effort by a sum of coordinates acts on each by its factor.
    fn efforts(&mut self, name: &str, otherwise: &str, terms: &[(usize, f64)], law: &str) {
        for &(joint, factor) in terms {
            let Some(index) = self.planar.coordinate_of(joint) else { continue };
            let load_name = self.fresh(name, "load", otherwise);
            let value = if factor == 1.0 { law.to_owned() } else { format!("{}*({law})", number(factor)) };
            self.effort(index, &load_name, &value);
        }
    }

    fn point_spring(&mut self, spring: &PointSpring) {
        let Some(points) = self.points_of(&spring.course) else { return };
        if points.iter().all(|point| point.0 == points[0].0) {
            self.report.idle("tendon within one body");
            return;
        }
        let name = self.fresh(&spring.name, "spring", "tendon");
        let Some(between) = self.course(&spring.course, &points, &name, &spring.place) else { return };
        let [low, high] = spring.relaxed;
        let sides: Vec<(&str, f64)> = match (spring.stiffness != 0.0, low == high) {
            (false, _) => Vec::new(),
            (true, true) => vec![("both", low)],
            (true, false) => [("below", low), ("above", high)]
                .into_iter()
                .filter(|(side, at)| *side == "above" || *at > 0.0)
                .collect(),
        };
        let mut spring_name = Some(name.clone());
        for (side, length) in &sides {
            let name = spring_name.take().unwrap_or_else(|| self.fresh(&spring.name, "spring", "tendon"));
            let damping = if *side == "both" && spring.damping != 0.0 {
                format!("damping = {}\n", number(spring.damping))
            } else {
                String::new()
            };
            let side = if *side == "both" { String::new() } else { format!("side    = \"{side}\"\n") };
            self.load_text += &format!(
                "\n[loads.{name}]\ntype    = \"spring\"\n{between}stiffness = {}\nlength  = {}\n{damping}{side}",
                number(spring.stiffness),
                number(*length)
            );
            self.report.exact("spring tendon");
        }
        if spring.damping != 0.0 && sides.iter().all(|(side, _)| *side != "both") {
            let name = spring_name.take().unwrap_or_else(|| self.fresh(&spring.name, "damper", "tendon"));
            self.load_text +=
                &format!("\n[loads.{name}]\ntype    = \"damper\"\n{between}damping = {}\n", number(spring.damping));
            self.report.exact("damper tendon");
        }
        if let Some(longest) = spring.longest {
            let name = spring_name.take().unwrap_or_else(|| self.fresh(&spring.name, "limit", "tendon"));
            self.joint_text +=
                &format!("\n[joints.{name}]\ntype    = \"rope\"\n{between}length  = {}\n", number(longest));
            self.report.exact("rope");
        }
        let planar = self.planar;
        let across = |point: &BodyPoint| planar.plane.normal.dot(&(planar.world[point.body] * point.at).coords);
        let out: Vec<f64> = spring.course.points().map(across).collect();
        let apart = out.windows(2).map(|ends| (ends[1] - ends[0]).abs()).sum::<f64>();
        if apart > 1e-9 {
            self.report.approximated(format!(
                "{} is {apart:.4} m long along the normal: its length in the plane is shorter",
                if spring.name.is_empty() { "a tendon".to_owned() } else { format!("`{}`", spring.name) },
            ));
        }
    }

    /// The points of a course in the plane; none if the import leaves one of their bodies out.
    fn points_of(&self, course: &Course) -> Option<Vec<LinkPoint>> {
        course.points().map(|point| self.planar.point(point)).collect()
    }

    /// `between` and `over` of what runs along a course; none where it is refused.
    fn course(&mut self, course: &Course, points: &[LinkPoint], name: &str, place: &FilePlace) -> Option<String> {
        let names: Vec<String> = points.iter().map(|&(link, at)| self.place(link, name, at)).collect();
        let mut bends = Vec::new();
        for (index, bend) in course.over.iter().enumerate() {
            let on = &names[index + 1];
            bends.push(match bend.radius > 0.0 {
                false => format!("{{ on = \"{on}\", radius = 0 }}"),
                true => {
                    let side = self.side(bend, [points[index].1, points[index + 1].1, points[index + 2].1], place)?;
                    format!("{{ on = \"{on}\", radius = {}, side = \"{side}\" }}", number(bend.radius))
                }
            });
        }
        let over = if bends.is_empty() { String::new() } else { format!("over    = [{}]\n", bends.join(", ")) };
        Some(format!("between = [\"{}\", \"{}\"]\n{over}", names[0], names[names.len() - 1]))
    }

    /// On which side of the tendon the centre of a cylinder is, as the tendon passes it in the reference configuration.
    fn side(
        &mut self,
        bend: &CourseBend,
        [from, centre, to]: [[f64; 2]; 3],
        place: &FilePlace,
    ) -> Option<&'static str> {
        let planar = self.planar;
        let oblique = bend.axis.is_some_and(|axis| {
            let along = planar.plane.normal.dot(&(planar.world[bend.at.body] * axis));
            along.abs() < 1.0 - OBLIQUE
        });
        let chord = [to[0] - from[0], to[1] - from[1]];
        let length = chord[0].hypot(chord[1]);
        let left_of_chord = |at: [f64; 2]| (chord[0] * (at[1] - from[1]) - chord[1] * (at[0] - from[0])) / length;
        let centre_is_left = left_of_chord(centre);
        let side =
            bend.side.as_ref().and_then(|side| planar.point(side)).map(|(_, at)| left_of_chord(at) - centre_is_left);
        let is_left = side.map_or(centre_is_left > 0.0, |side| side < 0.0);
        let touches = centre_is_left.abs() < bend.radius || (centre_is_left > 0.0) != is_left;
        if oblique || !touches {
            let why = if oblique {
                "is oblique to the plane of motion"
            } else {
                "does not touch in the reference configuration"
            };
            let message = format!("a tendon runs about `{}`, which {why}", bend.called);
            self.report
                .refuse(ImportRefusal::new(message).at(place).help("--leave-out tendon imports the file without it"));
            return None;
        }
        self.report.approximated(format!(
            "a tendon stays on `{}` as on a pulley, where MuJoCo lets it leave the surface",
            bend.called
        ));
        Some(if is_left { "left" } else { "right" })
    }

    fn actuator(&mut self, actuator: &SpatialActuator) {
        let name = self.fresh(&actuator.name, "input", "input");
        let range = actuator
            .control
            .map_or(String::new(), |[min, max]| format!(", min = {}, max = {}", number(min), number(max)));
        // MuJoCo clamps what it is given, and a scene's input starts within its range.
        let start = actuator.control.map_or(actuator.start, |[min, max]| actuator.start.clamp(min, max));
        self.inputs += &format!("{name} = {{ start = {}{range} }}\n", number(start));
        let clamped = clamp(&name, actuator.control);
        let driven = self.activation(&actuator.activation, &name, &clamped);
        let motion = match &actuator.transmission {
            Transmission::Joints(terms) => self.sum(terms),
            Transmission::Along(_) => Some(["length".to_owned(), "rate".to_owned()]),
        };
        let Some([length, rate]) = motion else {
            self.report.note(format!(
                "actuator `{}` moves a body that is not imported: its input has no effect",
                actuator.name
            ));
            return;
        };
        let gear = actuator.gear;
        let geared = |term: &str| if gear == 1.0 { format!("({term})") } else { format!("{}*({term})", number(gear)) };
        let mut law = String::new();
        let mut add = |factor: f64, of: &str| {
            if factor != 0.0 {
                let sign = if law.is_empty() { "" } else { " + " };
                let term = match (factor == 1.0, of.is_empty()) {
                    (true, false) => of.to_owned(),
                    (_, true) => number(factor),
                    (false, false) => format!("{}*{of}", number(factor)),
                };
                law += &format!("{sign}{term}");
            }
        };
        add(actuator.gain, &driven);
        add(actuator.rate_gain, &format!("{driven}*{}", geared(&rate)));
        add(actuator.bias[0], "");
        add(actuator.bias[1], &geared(&length));
        add(actuator.bias[2], &geared(&rate));
        if law.is_empty() {
            law = "0".to_owned();
        }
        let law = clamp(&law, actuator.force);
        let law = if gear == 1.0 { law } else { format!("{}*({law})", number(gear)) };
        let load = format!("{name}_load");
        match &actuator.transmission {
            Transmission::Joints(terms) => {
                let law = match terms[..] {
                    [(joint, _)] => clamp(&law, self.planar.file.joints[joint].effort),
                    _ => law,
                };
                self.efforts(&load, "load", terms, &law);
            }
            Transmission::Along(course) => {
                let Some(points) = self.points_of(course) else { return };
                let load = self.fresh(&load, "load", "load");
                let Some(between) = self.course(course, &points, &load, &actuator.place) else { return };
                self.load_text += &format!("\n[loads.{load}]\ntype    = \"actuator\"\n{between}force   = \"{law}\"\n");
            }
        }
        self.report.exact("actuator as input");
    }

    /// What the gain acts on: the input, or a state that follows it.
    fn activation(&mut self, activation: &Activation, name: &str, clamped: &str) -> String {
        if *activation == Activation::Direct {
            return format!("({clamped})");
        }
        let state = self.fresh(&format!("{name}_act"), "state", "act");
        let (rate, range, start) = match activation {
            Activation::Direct => (clamped.to_owned(), None, 0.0),
            Activation::Integrator(range, start) => (clamped.to_owned(), *range, *start),
            Activation::Filter(time, range, start) => {
                (format!("({clamped} - {state})/{}", number(*time)), *range, *start)
            }
        };
        // At the ends of its range the state stands still until its rate leads back.
        let rate = match range {
            Some([low, high]) => format!(
                "if({state} >= {}, min(0, {rate}), if({state} <= {}, max(0, {rate}), {rate}))",
                number(high),
                number(low)
            ),
            None => rate,
        };
        self.states += &format!("{state} = {{ start = {}, rate = \"{rate}\" }}\n", number(start));
        match range {
            Some(_) => format!("({})", clamp(&state, range)),
            None => state,
        }
    }
}

/// A law within a range.
fn clamp(law: &str, range: Option<[f64; 2]>) -> String {
    match range {
        Some([min, max]) => format!("max({}, min({}, {law}))", number(min), number(max)),
        None => law.to_owned(),
    }
}

/// By how much a length is beyond the range where a spring is relaxed.
fn beyond(length: &str, low: f64, high: f64) -> String {
    match low == high {
        true => format!("{length} - {}", number(low)),
        false => format!("max(0, {length} - {}) + min(0, {length} - {})", number(high), number(low)),
    }
}
