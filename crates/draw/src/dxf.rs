//! Drawings for CAD: DXF of release 12 (AC1009), which every program reads. Coordinates are in millimetres; the format cannot say so.

use std::fmt::{Display, Write};

use super::drawing::{CouplingKind, Drawing, DrawnCoupling, DrawnShape, Hold, Wheel};

const MILLIMETRES: f64 = 1e3;
/// The longest name of a layer in release 12.
const LONGEST: usize = 31;
/// AutoCAD colour indices of bodies, in the order of cotree's own: blue, orange, green, violet, red, teal, yellow, brown.
const COLOURS: [u8; 8] = [5, 30, 94, 200, 1, 134, 52, 34];
const INK: u8 = 7;
const CURVE: u8 = 144;

/// A DXF file under way; places are given in metres.
#[derive(Clone, Debug, Default)]
pub struct Dxf {
    entities: String,
    layers: Vec<(String, u8)>,
    extent: Option<[[f64; 2]; 2]>,
}

impl Dxf {
    /// A layer of that name, made fit for the format and unlike all others. Returns its name in the file.
    pub fn layer(&mut self, name: &str, colour: u8) -> String {
        let fit: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' }).collect();
        let fit = fit.to_ascii_uppercase();
        let numbered = (1..).map(|number| match number {
            1 => cut(&fit, LONGEST).to_owned(),
            _ => format!("{}_{number}", cut(&fit, LONGEST - 6)),
        });
        let taken = |name: &String| self.layers.iter().any(|(known, _)| known == name);
        let name = numbered.filter(|name| !name.is_empty()).find(|name| !taken(name)).unwrap_or_default();
        self.layers.push((name.clone(), colour));
        name
    }

    /// Straight lines through the points; what is not finite is left out.
    pub fn polyline(&mut self, layer: &str, points: &[[f64; 2]], closed: bool) {
        if points.is_empty() || points.iter().flatten().any(|x| !x.is_finite()) {
            return;
        }
        self.begin("POLYLINE", layer);
        // Vertices follow; the point says only how high they lie.
        self.groups(&[(66, &1), (10, &"0.0"), (20, &"0.0"), (30, &"0.0"), (70, &u8::from(closed))]);
        for &point in points {
            self.begin("VERTEX", layer);
            self.place(point);
        }
        self.begin("SEQEND", layer);
    }

    pub fn circle(&mut self, layer: &str, centre: [f64; 2], radius: f64) {
        if centre.iter().all(|x| x.is_finite()) && radius.is_finite() && radius > 0.0 {
            self.begin("CIRCLE", layer);
            self.place(centre);
            self.groups(&[(40, &real(radius))]);
            self.reach([centre[0] - radius, centre[1] - radius]);
            self.reach([centre[0] + radius, centre[1] + radius]);
        }
    }

    pub fn point(&mut self, layer: &str, at: [f64; 2]) {
        if at.iter().all(|x| x.is_finite()) {
            self.begin("POINT", layer);
            self.place(at);
        }
    }

    /// The whole file.
    pub fn finish(self) -> String {
        let [low, high] = self.extent.unwrap_or_default();
        let mut file = Dxf::default();
        file.groups(&[
            (999, &"cotree: coordinates are in millimetres"),
            (0, &"SECTION"),
            (2, &"HEADER"),
            (9, &"$ACADVER"),
            (1, &"AC1009"),
        ]);
        for (name, [x, y]) in [("$EXTMIN", low), ("$EXTMAX", high)] {
            file.groups(&[(9, &name), (10, &real(x)), (20, &real(y)), (30, &"0.0")]);
        }
        file.groups(&[(0, &"ENDSEC"), (0, &"SECTION"), (2, &"TABLES"), (0, &"TABLE"), (2, &"LTYPE"), (70, &1)]);
        file.groups(&[
            (0, &"LTYPE"),
            (2, &"CONTINUOUS"),
            (70, &0),
            (3, &"Solid line"),
            (72, &65),
            (73, &0),
            (40, &"0.0"),
        ]);
        file.groups(&[(0, &"ENDTAB"), (0, &"TABLE"), (2, &"LAYER"), (70, &self.layers.len())]);
        for (name, colour) in &self.layers {
            file.groups(&[(0, &"LAYER"), (2, name), (70, &0), (62, colour), (6, &"CONTINUOUS")]);
        }
        file.groups(&[(0, &"ENDTAB"), (0, &"ENDSEC"), (0, &"SECTION"), (2, &"ENTITIES")]);
        file.entities += &self.entities;
        file.groups(&[(0, &"ENDSEC"), (0, &"EOF")]);
        file.entities
    }

    fn begin(&mut self, entity: &str, layer: &str) {
        self.groups(&[(0, &entity), (8, &layer)]);
    }

    fn place(&mut self, at: [f64; 2]) {
        self.groups(&[(10, &real(at[0])), (20, &real(at[1])), (30, &"0.0")]);
        self.reach(at);
    }

    fn reach(&mut self, [x, y]: [f64; 2]) {
        let [low, high] = self.extent.unwrap_or([[x, y]; 2]);
        self.extent = Some([[low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]]);
    }

    fn groups(&mut self, groups: &[(u16, &dyn Display)]) {
        for (code, value) in groups {
            // Writing to a string cannot fail.
            let _ = write!(self.entities, "{code:>3}\r\n{value}\r\n");
        }
    }
}

/// A length in millimetres, to a millionth of one.
fn real(metres: f64) -> String {
    let text = format!("{:.6}", MILLIMETRES * metres);
    let text = text.trim_end_matches('0');
    if text.ends_with('.') { format!("{text}0") } else { text.to_owned() }
}

fn cut(name: &str, length: usize) -> &str {
    &name[..name.len().min(length)]
}

/// The paths of points, each with its name.
pub fn curves(curves: &[(String, Vec<[f64; 2]>)]) -> String {
    let mut dxf = Dxf::default();
    for (name, places) in curves {
        let layer = dxf.layer(name, CURVE);
        dxf.polyline(&layer, places, false);
    }
    dxf.finish()
}

impl Drawing {
    /// The pose that is drawn, a layer for each body: outlines, points, mass centres, joints, springs, pitch circles.
    pub fn dxf(&self) -> String {
        let mut dxf = Dxf::default();
        let ground = dxf.layer("ground", INK);
        let joints = dxf.layer("joints", INK);
        let bodies: Vec<String> =
            self.bodies.iter().enumerate().map(|(index, body)| dxf.layer(&body.name, COLOURS[index % 8])).collect();
        let of = |body: Option<usize>| body.and_then(|body| bodies.get(body)).unwrap_or(&ground);
        for (index, body) in self.bodies.iter().enumerate() {
            match &body.shape {
                Some(DrawnShape::Disc(centre, radius)) => dxf.circle(&bodies[index], *centre, *radius),
                Some(DrawnShape::Polygon(corners)) => dxf.polyline(&bodies[index], corners, true),
                None => {}
            }
            let corners = self.corners(index);
            dxf.polyline(&bodies[index], &corners, corners.len() > 2);
            body.points.iter().chain([&body.centre]).for_each(|&at| dxf.point(&bodies[index], at));
        }
        self.ground.iter().for_each(|&at| dxf.point(&ground, at));
        for shape in &self.ground_shapes {
            match shape {
                DrawnShape::Disc(centre, radius) => dxf.circle(&ground, *centre, *radius),
                DrawnShape::Polygon(corners) => dxf.polyline(&ground, corners, corners.len() > 2),
            }
        }
        for joint in &self.joints {
            joint.at.iter().for_each(|&at| dxf.point(&joints, at));
            if let Hold::Slider(_) | Hold::Slot(_) = joint.kind {
                dxf.polyline(&joints, &joint.at, false);
            }
        }
        if !self.springs.is_empty() {
            let springs = dxf.layer("springs", INK);
            self.springs.iter().for_each(|spring| dxf.polyline(&springs, &spring.ends, false));
        }
        for DrawnCoupling { kind, .. } in &self.couplings {
            let mut wheel = |wheel: &Wheel| dxf.circle(of(wheel.body), wheel.centre, wheel.radius);
            match kind {
                CouplingKind::Gears(wheels) | CouplingKind::Band { wheels, .. } => wheels.iter().for_each(wheel),
                CouplingKind::Rack { pinion: disc, .. } | CouplingKind::Rolling { disc, .. } => wheel(disc),
                CouplingKind::Link(ends) => dxf.polyline(&joints, ends, false),
                CouplingKind::Cam(cam) => {
                    cam.roller.iter().for_each(&mut wheel);
                    dxf.polyline(of(cam.hub.body), &cam.outline, true);
                    cam.face.iter().for_each(|(body, ends)| dxf.polyline(of(*body), ends, false));
                }
            }
        }
        dxf.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_have_names_that_the_format_knows_and_no_two_the_same() {
        let mut dxf = Dxf::default();
        let long = "a".repeat(60);
        let names = ["rod", "Rod", "rod.end é", &long, &long, ""].map(|name| dxf.layer(name, 1));
        assert_eq!(names[..3], ["ROD", "ROD_2", "ROD_END__"]);
        assert!(names.iter().all(|name| !name.is_empty() && name.len() <= LONGEST), "{names:?}");
        let mut different = names.to_vec();
        different.sort();
        different.dedup();
        assert_eq!(different.len(), names.len());
    }

    #[test]
    fn lengths_are_millimetres_and_what_is_not_finite_is_left_out() {
        let text = curves(&[("tip".into(), vec![[0.0, 0.5], [-1.25e-3, 1.0]]), ("lost".into(), vec![[f64::NAN, 0.0]])]);
        assert!(text.contains(" 10\r\n-1.25\r\n 20\r\n1000.0\r\n"), "{text}");
        assert_eq!(text.matches("VERTEX").count(), 2);
        assert!(text.ends_with("  0\r\nEOF\r\n") && !text.contains("NaN"));
    }
}
