//! Files of PMKS+ (<https://app.pmksplus.com>): one line, the same as in the addresses that it shares.
//!
//! Flags, scale, speed and time step, units, joints, links, forces, and what is selected, with a letter for its length at the end.

use super::linkage::{Drive, Force, Link, Linkage, Pin, PinKind};
use super::number::{decimal, flags, integer, is_whole};
use super::pmks_older;

/// Metres of a length, kilograms of a mass, newtons of a force.
struct Units {
    length: f64,
    mass: f64,
    force: f64,
}

pub fn read(file: &str) -> Result<Linkage, Vec<String>> {
    let line = file.split_once('?').map_or(file, |(_, query)| query);
    if pmks_older::is_older(line) {
        return pmks_older::read(line);
    }
    if line.contains(char::is_whitespace) || line.split('.').count() < 8 {
        return Err(vec!["it is neither a file or address of PMKS+ nor JSON of pylinkage".to_owned()]);
    }
    if line.starts_with("data=") {
        let why = "it is an address of a newer PMKS+, which is compressed; open it there and save a .pmks file with an older one, or export its CSV";
        return Err(vec![why.to_owned()]);
    }
    if !is_whole(line) {
        return Err(vec!["it is cut or changed: its last letter does not fit its length".to_owned()]);
    }
    let mut reader = Reader { rest: line, faults: Vec::new() };
    let linkage = reader.linkage();
    if reader.faults.is_empty() { Ok(linkage) } else { Err(reader.faults) }
}

struct Reader<'a> {
    rest: &'a str,
    faults: Vec<String>,
}

/// A link before its joints are known.
struct Draft {
    link: Link,
    id: String,
    joints: Vec<String>,
}

impl<'a> Reader<'a> {
    fn linkage(&mut self) -> Linkage {
        let settings: [bool; 8] = flags(self.section()).unwrap_or_default();
        let [clockwise, gravity, ..] = settings;
        self.section(); // the scale of the picture
        let speed = self.section().split(',').next().and_then(integer);
        let units = units(self.section());
        let rpm = speed.map_or(0.0, |speed| speed as f64) * if clockwise { -1.0 } else { 1.0 };
        let joints: Vec<(String, Pin, bool)> = self.list().iter().filter_map(|text| self.joint(text, &units)).collect();
        let drafts: Vec<Draft> = self.list().iter().filter_map(|text| self.link(text, &units)).collect();
        // Older files do not say what is selected: the letter for their length stands alone.
        let forces: Vec<&str> = self.list().into_iter().filter(|entry| entry.contains(',')).collect();
        let mut links: Vec<Link> = Vec::new();
        for draft in &drafts {
            let place = |id: &String| joints.iter().position(|(known, ..)| known == id);
            for id in draft.joints.iter().filter(|id| place(id).is_none()) {
                self.faults.push(format!("link `{}` has the joint `{id}`, which is not there", draft.id));
            }
            links.push(Link { pins: draft.joints.iter().filter_map(place).collect(), ..draft.link.clone() });
        }
        let ids: Vec<&str> = drafts.iter().map(|draft| draft.id.as_str()).collect();
        let forces = forces.iter().filter_map(|text| self.force(text, &ids, &units)).collect();
        let drives = self.drives(&joints, &links, rpm * std::f64::consts::PI / 30.0);
        let note = "PMKS+ writes no units of mass: masses are taken as kilograms (pounds if forces are in lbf), moments of inertia as mass times the unit of length squared".to_owned();
        Linkage {
            program: "PMKS+",
            title: String::new(),
            gravity,
            pins: joints.into_iter().map(|(_, pin, _)| pin).collect(),
            links,
            drives,
            forces,
            notes: vec![note],
        }
    }

    /// The text up to the next point.
    fn section(&mut self) -> &'a str {
        let (section, rest) = self.rest.split_once('.').unwrap_or((self.rest, ""));
        self.rest = rest;
        section
    }

    /// Entries that each end with a point, up to an empty one.
    fn list(&mut self) -> Vec<&'a str> {
        std::iter::from_fn(|| Some(self.section()).filter(|entry| !entry.is_empty())).collect()
    }

    /// Its own name in the file, the pin, and is it driven?
    fn joint(&mut self, text: &str, units: &Units) -> Option<(String, Pin, bool)> {
        let (flag, rest) = text.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(2).filter_map(|part| decimal(part)).collect();
        let (Some([sliding, driven, grounded, _, traced]), [id, name, ..], [x, y, angle]) =
            (flags::<5>(flag), &parts[..], &numbers[..])
        else {
            self.faults.push(format!("joint `{text}` is not as PMKS+ writes one"));
            return None;
        };
        if sliding && !grounded {
            self.faults.push(format!("joint `{name}` slides on a link that moves, which is not supported"));
        }
        if sliding && driven {
            self.faults.push(format!("joint `{name}` is a driven slider, which is not supported"));
        }
        let kind = if sliding { PinKind::Sliding([angle.cos(), angle.sin()]) } else { PinKind::Turning };
        let at = [x * units.length, y * units.length];
        Some(((*id).to_owned(), Pin { name: (*name).to_owned(), at, kind, grounded, traced }, driven))
    }

    fn link(&mut self, text: &str, units: &Units) -> Option<Draft> {
        // The parts of a welded link follow it; only the whole is a body.
        let rest = text.strip_prefix('Y')?;
        let (kind, rest) = rest.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(2).take(4).filter_map(|part| decimal(part)).collect();
        let (true, [id, name, ..], [mass, inertia, x, y]) = (parts.len() > 7, &parts[..], &numbers[..]) else {
            self.faults.push(format!("link `{text}` is not as PMKS+ writes one"));
            return None;
        };
        let block = kind == "P";
        let link = Link {
            name: (*name).to_owned(),
            pins: Vec::new(),
            mass: Some(mass * units.mass),
            inertia: (!block).then_some(inertia * units.mass * units.length * units.length),
            centre: (!block).then_some([x * units.length, y * units.length]),
        };
        let joints = parts[7..].iter().take_while(|joint| !joint.is_empty()).map(|joint| (*joint).to_owned()).collect();
        Some(Draft { link, id: (*id).to_owned(), joints })
    }

    fn force(&mut self, text: &str, links: &[&str], units: &Units) -> Option<Force> {
        let (flag, rest) = text.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(3).filter_map(|part| decimal(part)).collect();
        let read = (flags::<2>(flag), &parts[..], &numbers[..]);
        let (Some([turns, outward]), [_, link, name, ..], [x, y, to_x, to_y, size]) = read else {
            self.faults.push(format!("force `{text}` is not as PMKS+ writes one"));
            return None;
        };
        let Some(link) = links.iter().position(|known| known == link) else {
            self.faults.push(format!("force `{name}` acts on the link `{link}`, which is not there"));
            return None;
        };
        let [along, across] = [to_x - x, to_y - y];
        let length = along.hypot(across);
        let share = if length > 0.0 { size * units.force / length } else { 0.0 } * if outward { 1.0 } else { -1.0 };
        let at = [x * units.length, y * units.length];
        Some(Force { name: (*name).to_owned(), link, at, vector: [share * along, share * across], turns })
    }

    fn drives(&mut self, joints: &[(String, Pin, bool)], links: &[Link], rate: f64) -> Vec<Drive> {
        let mut drives = Vec::new();
        for (pin, (_, joint, _)) in joints.iter().enumerate().filter(|(_, (.., driven))| *driven) {
            match links.iter().position(|link| link.pins.contains(&pin)) {
                Some(link) if joint.grounded => drives.push(Drive { pin, link, rate }),
                _ => self
                    .faults
                    .push(format!("joint `{}` is driven, but does not join a link to the ground", joint.name)),
            }
        }
        drives
    }
}

/// The last letter of the units may be missing: PMKS+ cuts it.
fn units(text: &str) -> Units {
    let digit = |place: usize| text.get(place..place + 1).and_then(|digit| digit.parse::<u8>().ok());
    let length = match digit(0) {
        Some(0) => 0.0254,
        Some(2) => 1.0,
        _ => 0.01,
    };
    let (mass, force) = if digit(2) == Some(0) { (0.453_592_37, 4.448_221_615_260_5) } else { (1.0, 1.0) };
    Units { length, mass, force }
}
