//! ASCII DXF: pairs of a group code and a value, a line each. Units, layers, blocks and the entities in the model space, in metres.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::outline::DxfOutline;
use crate::import::options::ImportOptions;
use crate::import::refusal::{Fallible, FilePlace, ImportRefusal};

/// How deep blocks may be nested, and how many entities there may be with those in blocks.
const DEEPEST: usize = 20;
const MOST: usize = 100_000;

#[derive(Clone, Debug)]
pub enum DrawnShape {
    Outline(DxfOutline),
    Circle([f64; 2], f64),
    Point([f64; 2]),
    Block(Vec<DrawnEntity>),
}

#[derive(Clone, Debug)]
pub struct DrawnEntity {
    pub kind: String,
    pub layer: String,
    pub place: FilePlace,
    pub shape: DrawnShape,
    /// The name of the block that it inserts, and where.
    pub block: Option<String>,
    inserted: Option<[f64; 2]>,
}

impl DrawnEntity {
    /// The place of a circle, a point or a block.
    pub fn centre(&self) -> Option<[f64; 2]> {
        match &self.shape {
            DrawnShape::Circle(at, _) | DrawnShape::Point(at) => Some(*at),
            DrawnShape::Block(_) => self.inserted,
            DrawnShape::Outline(_) => None,
        }
    }
}

pub struct Drawing {
    /// Metres of its unit.
    pub unit: f64,
    pub entities: Vec<DrawnEntity>,
    pub layers: BTreeSet<String>,
    pub notes: Vec<String>,
}

/// A group code and its value, with the line of the code.
struct Pair<'a> {
    code: i32,
    value: &'a str,
    line: usize,
}

/// The groups of one entity.
struct Record<'a> {
    kind: &'a str,
    line: usize,
    groups: Vec<Pair<'a>>,
}

/// A similarity with or without a mirror: the images of the axes, and of the origin.
#[derive(Clone, Copy)]
struct Placement {
    x: [f64; 2],
    y: [f64; 2],
    at: [f64; 2],
}

impl Placement {
    fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|part| self.x[part] * u + self.y[part] * v + self.at[part])
    }

    fn mirrors(&self) -> bool {
        self.x[0] * self.y[1] - self.x[1] * self.y[0] < 0.0
    }

    fn scale(&self) -> f64 {
        self.x[0].hypot(self.x[1])
    }

    fn after(&self, inner: &Placement) -> Placement {
        let turned = |[u, v]: [f64; 2]| [0, 1].map(|part| self.x[part] * u + self.y[part] * v);
        Placement { x: turned(inner.x), y: turned(inner.y), at: self.apply(inner.at) }
    }
}

struct DxfReader<'a> {
    file: Rc<str>,
    blocks: BTreeMap<String, (Vec<Record<'a>>, [f64; 2])>,
    hidden: BTreeSet<String>,
    layers: BTreeSet<String>,
    skipped: BTreeMap<String, usize>,
    count: usize,
    elevation: Option<f64>,
}

/// Does a text begin as a drawing does?
pub fn looks_like_it(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim);
    let mut first = (lines.next(), lines.next());
    while first.0 == Some("999") {
        first = (lines.next(), lines.next());
    }
    first == (Some("0"), Some("SECTION"))
}

/// # Errors
/// What is no DXF, breaks off, or has entities in space.
pub fn read(file: &str, text: &str, options: &ImportOptions) -> Fallible<Drawing> {
    let file: Rc<str> = Rc::from(file);
    let pairs = pairs(&file, text)?;
    let mut reader = DxfReader {
        file,
        blocks: BTreeMap::new(),
        hidden: BTreeSet::new(),
        layers: BTreeSet::new(),
        skipped: BTreeMap::new(),
        count: 0,
        elevation: None,
    };
    let mut notes = Vec::new();
    let mut unit = None;
    let mut drawn = Vec::new();
    for (name, section) in sections(&pairs) {
        match name {
            "HEADER" => unit = header_unit(section, &mut notes),
            "TABLES" => reader.tables(section),
            "BLOCKS" => reader.read_blocks(section)?,
            "ENTITIES" => drawn = records(section),
            _ => {}
        }
    }
    let unit = match (options.dxf.unit, unit) {
        (Some(unit), _) => unit,
        (None, Some(unit)) => unit,
        (None, None) => {
            notes.push("the drawing has no unit: millimetres are assumed; --unit gives another".to_owned());
            1e-3
        }
    };
    let metres = Placement { x: [unit, 0.0], y: [0.0, unit], at: [0.0; 2] };
    let entities = reader.entities(&drawn, &metres, None, 0)?;
    notes.extend(
        reader.skipped.iter().map(|(kind, count)| format!("{count} x {kind} left out: no effect on the motion")),
    );
    Ok(Drawing { unit, entities, layers: reader.layers, notes })
}

fn pairs<'a>(file: &Rc<str>, text: &'a str) -> Fallible<Vec<Pair<'a>>> {
    let place = |line: usize| FilePlace { file: file.clone(), line, column: 1 };
    let mut pairs = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((index, code)) = lines.next() {
        let trimmed = code.trim();
        if trimmed.is_empty() && lines.clone().all(|(_, line)| line.trim().is_empty()) {
            break;
        }
        let code = trimmed.parse::<i32>().map_err(|_| {
            ImportRefusal::new(format!("`{trimmed}` must be a group code, a whole number")).at(&place(index + 1))
        })?;
        let Some((_, value)) = lines.next() else {
            return Err(ImportRefusal::new("the file is truncated: a group code has no value").at(&place(index + 1)));
        };
        pairs.push(Pair { code, value: value.trim(), line: index + 1 });
        if (code, value.trim()) == (0, "EOF") {
            return Ok(pairs);
        }
    }
    let line = text.lines().count().max(1);
    Err(ImportRefusal::new("the file is truncated: its end (EOF) is missing").at(&place(line)))
}

/// Sections by their names.
fn sections<'p, 'a>(pairs: &'p [Pair<'a>]) -> Vec<(&'a str, &'p [Pair<'a>])> {
    let mut found = Vec::new();
    let mut start = None;
    for (index, pair) in pairs.iter().enumerate() {
        match (pair.code, pair.value, start) {
            (0, "SECTION", _) => start = Some(index + 1),
            (0, "ENDSEC" | "EOF", Some(begin)) => {
                let name = pairs.get(begin).filter(|pair| pair.code == 2).map_or("", |pair| pair.value);
                found.push((name, &pairs[(begin + 1).min(index)..index]));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn header_unit(section: &[Pair], notes: &mut Vec<String>) -> Option<f64> {
    let variable = |name: &str| {
        let at = section.iter().position(|pair| pair.code == 9 && pair.value == name)?;
        section.get(at + 1)?.value.parse::<i32>().ok()
    };
    match variable("$INSUNITS") {
        Some(1) => Some(0.0254),
        Some(2) => Some(0.3048),
        Some(4) => Some(1e-3),
        Some(5) => Some(1e-2),
        Some(6) => Some(1.0),
        Some(7) => Some(1e3),
        Some(8) => Some(0.0254e-6),
        Some(9) => Some(0.0254e-3),
        Some(10) => Some(0.9144),
        Some(13) => Some(1e-6),
        Some(14) => Some(0.1),
        None | Some(0) => match variable("$MEASUREMENT") {
            Some(0) => {
                notes.push(
                    "the drawing has no unit and imperial measures: inches are assumed; --unit gives another"
                        .to_owned(),
                );
                Some(0.0254)
            }
            Some(1) => {
                notes.push(
                    "the drawing has no unit and metric measures: millimetres are assumed; --unit gives another"
                        .to_owned(),
                );
                Some(1e-3)
            }
            _ => None,
        },
        Some(other) => {
            notes.push(format!(
                "the drawing's unit ({other}) is unusual: millimetres are assumed; --unit gives another"
            ));
            Some(1e-3)
        }
    }
}

/// Entities of a section; those of an old polyline keep its vertices.
fn records<'a>(section: &[Pair<'a>]) -> Vec<Record<'a>> {
    let mut records: Vec<Record> = Vec::new();
    for pair in section {
        if pair.code == 0 {
            records.push(Record { kind: pair.value, line: pair.line, groups: Vec::new() });
        } else if let Some(record) = records.last_mut() {
            record.groups.push(Pair { ..*pair });
        }
    }
    records
}

impl<'a> Record<'a> {
    fn text(&self, code: i32) -> Option<&'a str> {
        self.groups.iter().find(|pair| pair.code == code).map(|pair| pair.value)
    }

    fn numbers(&self, file: &Rc<str>, code: i32) -> Fallible<Vec<f64>> {
        let pairs = self.groups.iter().filter(|pair| pair.code == code);
        let number = |pair: &Pair| match pair.value.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let place = FilePlace { file: file.clone(), line: pair.line + 1, column: 1 };
                Err(ImportRefusal::new(format!("`{}` of {} must be a finite number", pair.value, self.kind)).at(&place))
            }
        };
        pairs.map(number).collect()
    }

    fn number(&self, file: &Rc<str>, code: i32, default: f64) -> Fallible<f64> {
        Ok(self.numbers(file, code)?.first().copied().unwrap_or(default))
    }

    fn point(&self, file: &Rc<str>, code: i32) -> Fallible<[f64; 2]> {
        Ok([self.number(file, code, 0.0)?, self.number(file, code + 10, 0.0)?])
    }

    fn flags(&self, code: i32) -> i32 {
        self.text(code).and_then(|text| text.parse().ok()).unwrap_or(0)
    }
}

impl<'a> DxfReader<'a> {
    fn place(&self, line: usize) -> FilePlace {
        FilePlace { file: self.file.clone(), line, column: 1 }
    }

    /// Layers that are frozen or off.
    fn tables(&mut self, section: &[Pair<'a>]) {
        for record in records(section).iter().filter(|record| record.kind == "LAYER") {
            let name = record.text(2).unwrap_or_default();
            if record.flags(70) & 1 == 1 || record.flags(62) < 0 {
                self.hidden.insert(name.to_lowercase());
            }
        }
    }

    fn read_blocks(&mut self, section: &[Pair<'a>]) -> Fallible<()> {
        let mut open: Option<(String, [f64; 2], Vec<Record>)> = None;
        for record in records(section) {
            match (record.kind, &mut open) {
                ("BLOCK", _) => {
                    let base = record.point(&self.file, 10)?;
                    open = Some((record.text(2).unwrap_or_default().to_lowercase(), base, Vec::new()));
                }
                ("ENDBLK", _) => {
                    if let Some((name, base, records)) = open.take() {
                        self.blocks.insert(name, (records, base));
                    }
                }
                (_, Some((.., records))) => records.push(record),
                (_, None) => {}
            }
        }
        Ok(())
    }

    /// Entities where they are placed; those of layer 0 in a block are on the layer of the block.
    fn entities(
        &mut self,
        records: &[Record<'a>],
        within: &Placement,
        outer: Option<&str>,
        depth: usize,
    ) -> Fallible<Vec<DrawnEntity>> {
        let mut found = Vec::new();
        let mut index = 0;
        while let Some(record) = records.get(index) {
            index += 1;
            let vertices = records[index..].iter().take_while(|record| record.kind == "VERTEX").count();
            let corners = &records[index..index + vertices];
            if record.kind == "POLYLINE" {
                index += vertices;
            }
            self.count += 1;
            if self.count > MOST {
                return Err(
                    ImportRefusal::new(format!("it has more than {MOST} entities")).at(&self.place(record.line))
                );
            }
            let layer_name = record.text(8).unwrap_or("0");
            let layer = outer.filter(|_| layer_name == "0").unwrap_or(layer_name).to_owned();
            self.layers.insert(layer.clone());
            if record.flags(67) == 1 || self.hidden.contains(&layer_name.to_lowercase()) {
                *self.skipped.entry("entity on a hidden layer or in paper space".to_owned()).or_default() += 1;
                continue;
            }
            let placement = self.placed(record, within)?;
            let Some(shape) = self.shape(record, corners, &placement, &layer, depth)? else { continue };
            let block = (record.kind == "INSERT").then(|| record.text(2).unwrap_or_default().to_lowercase());
            let inserted =
                block.is_some().then(|| record.point(&self.file, 10)).transpose()?.map(|at| placement.apply(at));
            let place = self.place(record.line);
            found.push(DrawnEntity { kind: record.kind.to_lowercase(), layer, place, shape, block, inserted });
        }
        Ok(found)
    }

    /// The placement of an entity: one that looks from behind is mirrored, any other direction is out of the plane.
    fn placed(&mut self, record: &Record<'a>, within: &Placement) -> Fallible<Placement> {
        let axis = [210, 220, 230].map(|code| record.number(&self.file, code, if code == 230 { 1.0 } else { 0.0 }));
        let [x, y, z] = axis;
        let (x, y, z) = (x?, y?, z?);
        let heights = match record.kind {
            "LWPOLYLINE" => vec![record.number(&self.file, 38, 0.0)?],
            "LINE" => vec![record.number(&self.file, 30, 0.0)?, record.number(&self.file, 31, 0.0)?],
            "CIRCLE" | "ARC" | "POINT" | "INSERT" => vec![record.number(&self.file, 30, 0.0)?],
            _ => Vec::new(),
        };
        for height in heights {
            let first = *self.elevation.get_or_insert(height);
            if (height - first).abs() > 1e-9 * first.abs().max(1.0) {
                return Err(ImportRefusal::new(format!(
                    "{} has the elevation {height}, others {first}: the drawing is not in one plane",
                    record.kind.to_lowercase()
                ))
                .at(&self.place(record.line)));
            }
        }
        if x.abs() > 1e-9 || y.abs() > 1e-9 || z == 0.0 {
            return Err(ImportRefusal::new(format!(
                "{} is not in the plane x-y: its extrusion is ({x}, {y}, {z})",
                record.kind.to_lowercase()
            ))
            .at(&self.place(record.line)));
        }
        // Lines and points are in world coordinates whatever their extrusion.
        let mirrored = z < 0.0 && !matches!(record.kind, "LINE" | "POINT");
        Ok(if mirrored { Placement { x: within.x.map(|part| -part), ..*within } } else { *within })
    }

    fn shape(
        &mut self,
        record: &Record<'a>,
        vertices: &[Record<'a>],
        placement: &Placement,
        layer: &str,
        depth: usize,
    ) -> Fallible<Option<DrawnShape>> {
        let file = self.file.clone();
        let outline = |corners: Vec<[f64; 2]>, bulges: Vec<f64>, closed: bool| {
            let side = if placement.mirrors() { -1.0 } else { 1.0 };
            let corners = corners.into_iter().map(|corner| placement.apply(corner)).collect();
            let bulges = bulges.into_iter().map(|bulge| side * bulge).collect();
            DrawnShape::Outline(DxfOutline { corners, bulges, closed })
        };
        Ok(Some(match record.kind {
            "LINE" => outline(vec![record.point(&file, 10)?, record.point(&file, 11)?], vec![0.0], false),
            "LWPOLYLINE" => {
                let (corners, bulges) = self.light_corners(record)?;
                outline(corners, bulges, record.flags(70) & 1 == 1)
            }
            "POLYLINE" => {
                let corners = vertices.iter().map(|vertex| vertex.point(&file, 10)).collect::<Fallible<Vec<_>>>()?;
                let bulges =
                    vertices.iter().map(|vertex| vertex.number(&file, 42, 0.0)).collect::<Fallible<Vec<_>>>()?;
                outline(corners, bulges, record.flags(70) & 1 == 1)
            }
            "ARC" => {
                let (centre, radius) = (record.point(&file, 10)?, record.number(&file, 40, 0.0)?);
                let [from, to] =
                    [record.number(&file, 50, 0.0)?.to_radians(), record.number(&file, 51, 360.0)?.to_radians()];
                let turn = (to - from).rem_euclid(std::f64::consts::TAU);
                let at = |angle: f64| [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
                let bulge = (turn / 8.0).tan();
                outline(vec![at(from), at(from + turn / 2.0), at(from + turn)], vec![bulge, bulge], false)
            }
            "CIRCLE" => DrawnShape::Circle(
                placement.apply(record.point(&file, 10)?),
                record.number(&file, 40, 0.0)? * placement.scale(),
            ),
            "POINT" => DrawnShape::Point(placement.apply(record.point(&file, 10)?)),
            "INSERT" => DrawnShape::Block(self.insert(record, placement, layer, depth)?),
            "VERTEX" | "SEQEND" | "VIEWPORT" | "ATTRIB" => return Ok(None),
            "SPLINE" | "ELLIPSE"
                if super::LayerRole::named(&layer.to_lowercase())
                    .is_some_and(|role| role != super::LayerRole::Ignored) =>
            {
                let help = "explode it into lines and arcs, or move it to an ignored layer";
                return Err(ImportRefusal::new(format!(
                    "a {} on layer `{layer}` is not read",
                    record.kind.to_lowercase()
                ))
                .at(&self.place(record.line))
                .help(help));
            }
            other => {
                *self.skipped.entry(other.to_lowercase()).or_default() += 1;
                return Ok(None);
            }
        }))
    }

    /// Corners and bulges of a light polyline: a bulge follows its corner.
    fn light_corners(&self, record: &Record<'a>) -> Fallible<(Vec<[f64; 2]>, Vec<f64>)> {
        let (xs, ys) = (record.numbers(&self.file, 10)?, record.numbers(&self.file, 20)?);
        let mut bulges = vec![0.0; xs.len()];
        let mut corner = 0;
        for pair in &record.groups {
            match pair.code {
                10 => corner += 1,
                42 => {
                    if let (Some(bulge), Ok(value)) = (bulges.get_mut(corner.max(1) - 1), pair.value.parse::<f64>()) {
                        *bulge = value;
                    }
                }
                _ => {}
            }
        }
        Ok((xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect(), bulges))
    }

    fn insert(
        &mut self,
        record: &Record<'a>,
        placement: &Placement,
        layer: &str,
        depth: usize,
    ) -> Fallible<Vec<DrawnEntity>> {
        let file = self.file.clone();
        let name = record.text(2).unwrap_or_default().to_lowercase();
        let place = self.place(record.line);
        if depth >= DEEPEST {
            return Err(
                ImportRefusal::new(format!("block `{name}` is nested {DEEPEST} deep: it contains itself")).at(&place)
            );
        }
        if record.flags(70) > 1 || record.flags(71) > 1 {
            return Err(ImportRefusal::new(format!("block `{name}` is inserted as an array"))
                .at(&place)
                .help("explode the array into single blocks"));
        }
        let Some((records, base)) = self.blocks.remove(&name) else {
            return Err(ImportRefusal::new(format!("block `{name}` is not defined, or contains itself")).at(&place));
        };
        let [x, y] = [record.number(&file, 41, 1.0)?, record.number(&file, 42, 1.0)?];
        if (x.abs() - y.abs()).abs() > 1e-9 * x.abs() || x == 0.0 {
            self.blocks.insert(name.clone(), (records, base));
            return Err(ImportRefusal::new(format!(
                "block `{name}` is scaled by {x} and {y}: circles would be ellipses"
            ))
            .at(&place)
            .help("scale it alike in both directions"));
        }
        let (sine, cosine) = record.number(&file, 50, 0.0)?.to_radians().sin_cos();
        let at = record.point(&file, 10)?;
        let turned = Placement { x: [x * cosine, x * sine], y: [-y * sine, y * cosine], at };
        let based = Placement { x: [1.0, 0.0], y: [0.0, 1.0], at: base.map(|part| -part) };
        let inner = placement.after(&turned).after(&based);
        let found = self.entities(&records, &inner, Some(layer), depth + 1);
        self.blocks.insert(name, (records, base));
        Ok(found?.into_iter().flat_map(flattened).collect())
    }
}

/// A block in a block is a part of it.
fn flattened(entity: DrawnEntity) -> Vec<DrawnEntity> {
    match entity.shape {
        DrawnShape::Block(parts) => parts.into_iter().flat_map(flattened).collect(),
        _ => vec![entity],
    }
}
