//! Drawings (ASCII DXF) as linkages: bars, rigid polylines and blocks, pins, ground, sliders and guides, by their layers.

mod entities;
mod outline;

pub use self::entities::looks_like_it;
use self::entities::{Drawing, DrawnEntity, DrawnShape};
use self::outline::{DxfOutline, Uniform};
use super::linkage::{ImportedGuide, ImportedLink, ImportedLinkage, Pin, PinKind};
use super::options::ImportOptions;
use super::refusal::{Fallible, ImportRefusal};

/// Ends are joined within this share of the diagonal: CAD programs round to 1e-6.
const SNAP: f64 = 1e-5;
/// Ends that are nearly joined are errors within so many of these.
const NEAR: f64 = 100.0;
/// The most bodies of a mechanism that somebody draws.
const MOST: usize = 1000;
/// The end nearest to a pin with one body only is named if it is within this share of the diagonal.
const BESIDE: f64 = 0.05;

/// What a layer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerRole {
    Links,
    Pins,
    Ground,
    Sliders,
    Guides,
    Tracers,
    Springs,
    Ignored,
}

impl LayerRole {
    fn named(name: &str) -> Option<LayerRole> {
        Some(match name {
            "links" | "link" | "bars" | "bar" => LayerRole::Links,
            "pins" | "pin" | "joints" | "joint" | "pivots" | "pivot" => LayerRole::Pins,
            "ground" | "frame" | "fixed" | "base" => LayerRole::Ground,
            "sliders" | "slider" => LayerRole::Sliders,
            "guides" | "guide" => LayerRole::Guides,
            "tracers" | "tracer" => LayerRole::Tracers,
            "springs" | "spring" => LayerRole::Springs,
            "ignored" => LayerRole::Ignored,
            _ => return None,
        })
    }

    /// By the options, or by the name up to a separator or digit.
    fn of(layer: &str, options: &ImportOptions) -> LayerRole {
        let lower = layer.to_lowercase();
        let given = options.dxf.layers.iter().find(|(name, _)| name.to_lowercase() == lower);
        if let Some((_, role)) = given {
            return LayerRole::named(role).unwrap_or(LayerRole::Ignored);
        }
        let stem = lower.split(|c: char| matches!(c, '_' | '-' | ' ') || c.is_ascii_digit()).next().unwrap_or("");
        LayerRole::named(&lower).or_else(|| LayerRole::named(stem)).unwrap_or(LayerRole::Ignored)
    }
}

/// A rigid body of the drawing, metres.
struct DrawnBody {
    name: String,
    /// What a message calls it: its kind and its line in the file.
    called: String,
    outlines: Vec<DxfOutline>,
    holes: Vec<([f64; 2], f64)>,
    guides: Vec<[[f64; 2]; 2]>,
    is_slider: bool,
}

impl DrawnBody {
    /// Ends, corners and centres of holes.
    fn marks(&self) -> impl Iterator<Item = [f64; 2]> {
        let corners = self.outlines.iter().flat_map(|outline| outline.corners.iter().copied());
        corners.chain(self.holes.iter().map(|hole| hole.0))
    }

    /// Is a place one of its marks, on one of its lines, or within a slider?
    fn has(&self, at: [f64; 2], snap: f64) -> bool {
        self.marks().any(|mark| apart(mark, at) <= snap)
            || self
                .outlines
                .iter()
                .any(|outline| outline.distance(at) <= snap || self.is_slider && outline.surrounds(at))
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The linkage of a drawing.
///
/// # Errors
/// What is no drawing, or leaves open what is joined to what.
pub fn read(file: &str, text: &str, options: &ImportOptions) -> Fallible<ImportedLinkage> {
    let drawing = entities::read(file, text, options)?;
    let mut sketch = Sketch::new(&drawing, options)?;
    sketch.find_pins();
    sketch.ground()?;
    sketch.check_misses()?;
    Ok(sketch.linkage())
}

struct Sketch<'a> {
    drawing: &'a Drawing,
    options: &'a ImportOptions,
    /// Is there a layer for bodies? Else those of layer 0 count.
    has_links: bool,
    bodies: Vec<DrawnBody>,
    pins: Vec<[f64; 2]>,
    grounded: Vec<bool>,
    tracers: Vec<[f64; 2]>,
    guides: Vec<[[f64; 2]; 2]>,
    snap: f64,
    diagonal: f64,
    notes: Vec<String>,
}

impl<'a> Sketch<'a> {
    fn new(drawing: &'a Drawing, options: &'a ImportOptions) -> Fallible<Self> {
        let mut sketch = Sketch {
            drawing,
            options,
            has_links: drawing.entities.iter().any(|entity| LayerRole::of(&entity.layer, options) == LayerRole::Links),
            bodies: Vec::new(),
            pins: Vec::new(),
            grounded: Vec::new(),
            tracers: Vec::new(),
            guides: Vec::new(),
            snap: 0.0,
            diagonal: 0.0,
            notes: drawing.notes.clone(),
        };
        sketch.collect()?;
        let marks: Vec<[f64; 2]> = sketch.bodies.iter().flat_map(|body| body.marks().collect::<Vec<_>>()).collect();
        if marks.is_empty() {
            let layers: Vec<&str> = drawing.layers.iter().map(String::as_str).collect();
            return Err(ImportRefusal::new("it has no body: no line, polyline or block on a layer LINKS or BARS")
                .help(format!(
                    "its layers are {}; name the one with the bodies by --layer NAME=links",
                    layers.join(", ")
                )));
        }
        let span = |part: usize| {
            let values = marks.iter().map(|mark| mark[part]);
            values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
        };
        sketch.diagonal = span(0).hypot(span(1));
        sketch.snap = options.dxf.snap.unwrap_or(SNAP * sketch.diagonal);
        sketch.notes.push(format!("the bodies are {:.4} m wide and {:.4} m high", span(0), span(1)));
        Ok(sketch)
    }

    fn role(&self, entity: &DrawnEntity) -> LayerRole {
        let role = LayerRole::of(&entity.layer, self.options);
        if role == LayerRole::Ignored && entity.layer == "0" && !self.has_links { LayerRole::Links } else { role }
    }

    /// Bodies, guides and tracers by the layers of the entities.
    fn collect(&mut self) -> Fallible<()> {
        let mut ignored = 0;
        for entity in &self.drawing.entities {
            match self.role(entity) {
                LayerRole::Links | LayerRole::Sliders => self.body(entity)?,
                LayerRole::Guides => match &entity.shape {
                    DrawnShape::Outline(outline) => self.guides.extend(outline.straight()),
                    _ => ignored += 1,
                },
                LayerRole::Tracers => self.tracers.extend(entity.centre()),
                LayerRole::Springs => self.notes.push(format!(
                    "the spring of line {} is left out: a drawing has no stiffness; add it as `type = \"spring\"`",
                    entity.place.line
                )),
                LayerRole::Pins | LayerRole::Ground => {}
                LayerRole::Ignored => ignored += 1,
            }
        }
        if ignored > 0 {
            self.notes.push(format!("{ignored} entities on other layers are left out"));
        }
        // Bodies that slide come first: the joint with the guide is theirs.
        self.bodies.sort_by_key(|body| !body.is_slider);
        Ok(())
    }

    fn body(&mut self, entity: &DrawnEntity) -> Fallible<()> {
        if self.bodies.len() >= MOST {
            return Err(ImportRefusal::new(format!(
                "it has more than {MOST} bodies: each line, polyline and block is one"
            ))
            .at(&entity.place)
            .help("draw the mechanism alone on a layer LINKS, or name its layer with --layer NAME=links"));
        }
        let is_slider = self.role(entity) == LayerRole::Sliders;
        let called = format!("{} of line {}", entity.kind, entity.place.line);
        let name = entity
            .block
            .clone()
            .unwrap_or_else(|| format!("{}_{}", if is_slider { "slider" } else { "link" }, self.bodies.len() + 1));
        let mut body =
            DrawnBody { name, called, outlines: Vec::new(), holes: Vec::new(), guides: Vec::new(), is_slider };
        match &entity.shape {
            DrawnShape::Outline(outline) => body.outlines.push(outline.clone()),
            // A circle or point beside the blocks is a pin.
            DrawnShape::Circle(..) | DrawnShape::Point(_) => return Ok(()),
            DrawnShape::Block(parts) => {
                for part in parts {
                    match (&part.shape, LayerRole::of(&part.layer, self.options)) {
                        (DrawnShape::Outline(outline), LayerRole::Guides) => body.guides.extend(outline.straight()),
                        (DrawnShape::Outline(outline), _) => body.outlines.push(outline.clone()),
                        (DrawnShape::Circle(at, radius), _) => body.holes.push((*at, *radius)),
                        (DrawnShape::Point(at), _) => body.holes.push((*at, 0.0)),
                        (DrawnShape::Block(_), _) => {}
                    }
                }
                if body.outlines.is_empty() {
                    return Ok(());
                }
            }
        }
        let same = |other: &&DrawnBody| {
            other.outlines == body.outlines && other.is_slider == is_slider && other.holes == body.holes
        };
        if let Some(other) = self.bodies.iter().find(same) {
            self.notes.push(format!(
                "{called} is drawn twice, as {}: it is taken as one bar",
                other.called,
                called = body.called
            ));
            return Ok(());
        }
        self.bodies.push(body);
        Ok(())
    }

    /// Circles and points of the pin layers, holes, marks of the ground; without any, the ends that meet.
    fn find_pins(&mut self) {
        let counts = |entity: &&DrawnEntity| {
            entity.block.is_none() && matches!(self.role(entity), LayerRole::Pins | LayerRole::Links)
        };
        let drawn = self.drawing.entities.iter().filter(counts);
        let mut places: Vec<[f64; 2]> = drawn.filter_map(DrawnEntity::centre).collect();
        places.extend(self.bodies.iter().flat_map(|body| body.holes.iter().map(|hole| hole.0)));
        if places.is_empty() {
            let marks: Vec<(usize, [f64; 2])> = self
                .bodies
                .iter()
                .enumerate()
                .flat_map(|(index, body)| body.marks().map(move |mark| (index, mark)).collect::<Vec<_>>())
                .collect();
            let meets = |(index, mark): &&(usize, [f64; 2])| {
                self.bodies.iter().enumerate().any(|(other, body)| other != *index && body.has(*mark, self.snap))
            };
            places.extend(marks.iter().filter(meets).map(|(_, mark)| *mark));
        }
        places.extend(
            self.ground_marks().into_iter().filter(|at| self.bodies.iter().any(|body| body.has(*at, self.snap))),
        );
        for at in places {
            if self.pins.iter().all(|pin| apart(*pin, at) > self.snap) {
                self.pins.push(at);
            }
        }
    }

    /// Places of the ground: points, circles, blocks of that name, and those of the options.
    fn ground_marks(&self) -> Vec<[f64; 2]> {
        let unit = self.drawing.unit;
        let given = self.options.dxf.ground.iter().map(|at| at.map(|part| part * unit));
        let is_block = |entity: &DrawnEntity| {
            let name = entity.block.as_deref().unwrap_or_default().to_lowercase();
            matches!(name.as_str(), "ground" | "pivot")
        };
        let drawn = self.drawing.entities.iter();
        let marks = drawn
            .filter(|entity| self.role(entity) == LayerRole::Ground || is_block(entity))
            .filter_map(DrawnEntity::centre);
        given.chain(marks).collect()
    }

    fn ground(&mut self) -> Fallible<()> {
        self.grounded = vec![false; self.pins.len()];
        let lines: Vec<DxfOutline> = self
            .drawing
            .entities
            .iter()
            .filter(|entity| self.role(entity) == LayerRole::Ground)
            .filter_map(|entity| match &entity.shape {
                DrawnShape::Outline(outline) => Some(outline.clone()),
                _ => None,
            })
            .collect();
        let marks = self.ground_marks();
        for (pin, at) in self.pins.iter().enumerate() {
            let marked = marks.iter().any(|mark| apart(*mark, *at) <= self.snap);
            self.grounded[pin] = marked || lines.iter().any(|line| line.distance(*at) <= self.snap);
        }
        let list = || {
            let places: Vec<String> = self.pins.iter().take(20).map(|pin| self.shown(*pin)).collect();
            places.join(", ")
        };
        for mark in &marks {
            if self.pins.iter().all(|pin| apart(*pin, *mark) > self.snap) {
                return Err(ImportRefusal::new(format!("the ground at {} is not at a pin", self.shown(*mark)))
                    .help(format!("the pins are {}", list())));
            }
        }
        if !self.grounded.iter().any(|grounded| *grounded) && self.guides.is_empty() {
            return Err(ImportRefusal::new(
                "nothing is fixed to the ground: no pin has a point, circle or line of a layer GROUND",
            )
            .help(format!("--ground X,Y names one of the pins {}", list())));
        }
        Ok(())
    }

    /// A place in the units of the drawing.
    fn shown(&self, at: [f64; 2]) -> String {
        let [x, y] = at.map(|part| part / self.drawing.unit);
        format!("{x:.6},{y:.6}").replace("-0.000000", "0.000000")
    }

    /// Ends that are nearly joined, and what touches nothing.
    fn check_misses(&self) -> Fallible<()> {
        for (index, at) in self.pins.iter().enumerate() {
            let joined = self.bodies.iter().filter(|body| body.has(*at, self.snap)).count();
            let alone = joined + usize::from(self.grounded[index]) + usize::from(self.guide_of(*at).is_some()) < 2;
            let reach = if alone { (BESIDE * self.diagonal).max(NEAR * self.snap) } else { NEAR * self.snap };
            let others = self.bodies.iter().filter(|body| !body.has(*at, self.snap));
            let marks = others.flat_map(|body| body.marks().map(move |mark| (body, mark)).collect::<Vec<_>>());
            let nearest = marks.min_by(|a, b| apart(a.1, *at).total_cmp(&apart(b.1, *at)));
            let Some((body, mark)) = nearest.filter(|(_, mark)| apart(*mark, *at) <= reach) else { continue };
            let taken = self.pins.iter().any(|pin| apart(*pin, mark) <= self.snap);
            if alone || !taken {
                let millimetres = apart(mark, *at) * 1e3;
                let enough = round_up(millimetres);
                return Err(ImportRefusal::new(format!(
                    "{} ends at {}, {millimetres:.4} mm from the pin at {}: they are not joined",
                    body.called,
                    self.shown(mark),
                    self.shown(*at)
                ))
                .help(format!("--snap {enough}mm joins them")));
            }
        }
        for body in &self.bodies {
            if !self.pins.iter().any(|pin| body.has(*pin, self.snap)) {
                let at = body.marks().next().unwrap_or_default();
                return Err(ImportRefusal::new(format!("{} at {} does not touch a pin", body.called, self.shown(at)))
                    .help("draw a circle on a layer PINS where it is joined, or move it to an ignored layer"));
            }
        }
        Ok(())
    }

    /// The guide that a place is on: of a body, or of the ground.
    fn guide_of(&self, at: [f64; 2]) -> Option<ImportedGuide> {
        let on = |guide: &[[f64; 2]; 2]| outline::to_segment(at, *guide) <= self.snap;
        let along = |guide: [[f64; 2]; 2]| {
            let length = apart(guide[0], guide[1]);
            [0, 1].map(|part| (guide[1][part] - guide[0][part]) / length)
        };
        let of_body = self.bodies.iter().enumerate().find_map(|(index, body)| {
            let guide = body.guides.iter().find(|guide| on(guide))?;
            (!body.has(at, 0.0)).then_some(ImportedGuide { on: Some(index), along: along(*guide) })
        });
        of_body.or_else(|| {
            self.guides.iter().find(|guide| on(guide)).map(|guide| ImportedGuide { on: None, along: along(*guide) })
        })
    }

    fn linkage(mut self) -> ImportedLinkage {
        let density = self.options.dxf.line_density.unwrap_or(1.0);
        match (self.options.dxf.line_density, self.options.dxf.plate) {
            (None, None) => self
                .notes
                .push("masses are assumed: 1 kg per metre of line; --line-density and --plate give others".to_owned()),
            (_, Some(plate)) => self.notes.push(format!("closed outlines are plates of {plate:.4} kg/m2")),
            (Some(density), None) => self.notes.push(format!("lines have {density:?} kg/m")),
        }
        if self.options.gravity.is_none() {
            self.notes.push("a drawing has no gravity; --gravity adds it".to_owned());
        }
        let pins = self.pins.iter().enumerate().map(|(index, at)| self.pin(index, *at));
        let tracers = self.tracers.iter().enumerate().map(|(index, at)| Pin {
            name: format!("tracer_{}", index + 1),
            at: *at,
            kind: PinKind::Turning,
            grounded: false,
            welded: false,
            traced: true,
        });
        let pins: Vec<Pin> = pins.chain(tracers).collect();
        let links = self.bodies.iter().map(|body| {
            let places = pins.iter().enumerate().filter(|(_, pin)| body.has(pin.at, self.snap)).map(|(index, _)| index);
            let uniform = body.uniform(density, self.options.dxf.plate);
            ImportedLink {
                name: body.name.clone(),
                pins: places.collect(),
                mass: Some(uniform.mass),
                inertia: Some(uniform.inertia),
                centre: Some(uniform.centre),
            }
        });
        let links = links.collect();
        ImportedLinkage {
            program: "a drawing (DXF)",
            title: String::new(),
            gravity: self.options.gravity,
            pins,
            links,
            drives: Vec::new(),
            forces: Vec::new(),
            notes: self.notes,
        }
    }

    fn pin(&self, index: usize, at: [f64; 2]) -> Pin {
        let guide = self.guide_of(at).filter(|_| !self.grounded[index]);
        let slides = self.bodies.iter().any(|body| body.is_slider && body.has(at, self.snap));
        let kind = match guide {
            None => PinKind::Turning,
            Some(guide) if slides => PinKind::Sliding(guide),
            Some(guide) => PinKind::Slot(guide),
        };
        let grounded = self.grounded[index] || guide.is_some_and(|guide| guide.on.is_none());
        Pin { name: format!("P{}", index + 1), at, kind, grounded, welded: false, traced: false }
    }
}

impl DrawnBody {
    fn uniform(&self, density: f64, plate: Option<f64>) -> Uniform {
        let closed = self.outlines.iter().any(|outline| outline.closed);
        match plate.filter(|_| closed) {
            Some(plate) => outline::plate(&self.outlines, &self.holes, plate),
            // A slider is a block: the mass of its outline is spread over its area.
            None if self.is_slider && closed => {
                let (mass, area) =
                    (outline::wire(&self.outlines, density).mass, outline::plate(&self.outlines, &[], 1.0));
                let spread = mass / area.mass;
                Uniform { mass, inertia: area.inertia * spread, ..area }
            }
            None => outline::wire(&self.outlines, density),
        }
    }
}

/// The next number above with one digit.
fn round_up(value: f64) -> f64 {
    let scale = 10f64.powf(value.max(1e-9).log10().floor());
    let digit = (value / scale * 1.0001).floor() + 1.0;
    let rounded = digit * scale;
    format!("{rounded:.9}").parse().unwrap_or(rounded)
}
