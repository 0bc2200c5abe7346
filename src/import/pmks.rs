//! Files of PMKS+ (<https://app.pmksplus.com>): one line, the same as in the addresses that it shares.
//!
//! Sections end with a point: switches, scale and speed of sliders, speed and time step, units; then joints, links and forces, each entry with a point and the
//! list with one more; what is selected; marks such as locks and colours. The last letter stands for the length. Files of earlier PMKS+ end sooner.
//!
//! A joint: switches and its own letter, name, x, y, angle of its guide; then, if its guide is in a link, that link and two of its joints on the guide; then a speed
//! of its own. A slider is two joints at one place: a pin, and one that slides, with a block between them.

use std::f64::consts::PI;

use super::linkage::{Drive, DriveLaw, ImportedGuide, ImportedLink, ImportedLinkage, LinkForce, Pin, PinKind};
use super::number::{decimal, flags, integer, is_whole, unescaped};
use super::pmks_older;
use crate::typeset::counted;

/// The speed of driven sliders, in units of length a second, that PMKS+ takes for files which have none.
const SPEED_OF_SLIDERS: f64 = 5.0;

/// How far a pin may be beside its guide, in units of length: the file rounds three places to thousandths, and the pin may be beyond the joints.
const ROUNDED: f64 = 0.005;

/// Metres of a length, kilograms of a mass, newtons of a force.
struct PmksUnits {
    length: f64,
    mass: f64,
    force: f64,
}

pub fn read(file: &str) -> Result<ImportedLinkage, Vec<String>> {
    // A name may have a question mark, too: what stands before the first one is an address only if it looks like one.
    let address = file.split_once('?').filter(|(before, _)| before.is_empty() || before.contains("://"));
    let line = address.map_or(file, |(_, query)| query);
    if pmks_older::is_older(line) {
        return pmks_older::read(line);
    }
    if line.starts_with("data=") {
        let why = "it is an address of a newer PMKS+, which is compressed; open it there and save a .pmks file with an older one, or export its CSV";
        return Err(vec![why.to_owned()]);
    }
    if !looks_like_it(line) {
        return Err(vec!["it is neither a file or address of PMKS+ nor JSON of pylinkage".to_owned()]);
    }
    // Browsers write blanks and other letters of names as codes; the last letter counts the letters.
    let plain = unescaped(line);
    let Some(whole) = [plain.as_str(), line].into_iter().find(|text| is_whole(text)) else {
        return Err(vec!["it is truncated or changed: its last letter does not match its length".to_owned()]);
    };
    let mut reader = PmksReader { rest: whole, faults: Vec::new() };
    let linkage = reader.linkage();
    if reader.faults.is_empty() { Ok(linkage) } else { Err(reader.faults) }
}

/// Does it begin with the settings of a file?
fn looks_like_it(line: &str) -> bool {
    let sections: Vec<&str> = line.split('.').collect();
    let numbers = |section: &str| section.split(',').all(|number| integer(number).is_some());
    sections.len() >= 8 && flags::<1>(sections[0]).is_some() && sections[1..4].iter().all(|section| numbers(section))
}

struct PmksReader<'a> {
    rest: &'a str,
    faults: Vec<String>,
}

/// A joint before its links are known.
struct JointDraft<'a> {
    id: &'a str,
    pin: Pin,
    driven: bool,
    slides: bool,
    /// The link that its guide is cut into, and the two joints of it on the guide.
    guide: Option<[&'a str; 3]>,
    /// Its own speed, or zero.
    speed: f64,
}

/// A link before its joints are known.
struct LinkDraft<'a> {
    link: ImportedLink,
    id: &'a str,
    /// The links that were welded into it.
    parts: Vec<&'a str>,
    joints: Vec<&'a str>,
}

/// Speeds of what is driven without one of its own, with their sense.
struct Speeds {
    turning: f64,
    sliding: f64,
}

impl<'a> PmksReader<'a> {
    fn linkage(&mut self) -> ImportedLinkage {
        // Gravity acts unless the ninth switch takes it away; the second one is a relic that PMKS+ ignores.
        let [clockwise, .., weightless]: [bool; 9] = flags(self.section()).unwrap_or_default();
        let sense = if clockwise { -1.0 } else { 1.0 };
        let of_sliders = self.section().split(',').nth(1).and_then(decimal).filter(|speed| *speed > 0.0);
        let rpm = self.section().split(',').next().and_then(integer).unwrap_or_default() as f64;
        let units = units(self.section());
        let speeds = Speeds { turning: sense * rpm, sliding: sense * of_sliders.unwrap_or(SPEED_OF_SLIDERS) };
        let mut points: Vec<JointDraft> = self.list().into_iter().filter_map(|text| self.point(text, &units)).collect();
        let drafts: Vec<LinkDraft> = self.list().into_iter().filter_map(|text| self.draft(text, &units)).collect();
        // Older files do not say what is selected: the letter for their length stands alone.
        let forces: Vec<&str> = self.list().into_iter().filter(|entry| entry.contains(',')).collect();
        self.guides(&mut points, &drafts, &units);
        let links = self.links(&points, &drafts);
        let forces = forces.into_iter().filter_map(|text| self.force(text, &drafts, &units)).collect();
        let drives = points.iter().enumerate().filter(|(_, point)| point.driven);
        let drives: Vec<Drive> =
            drives.filter_map(|(pin, point)| self.drive(pin, point, &links, &speeds, &units)).collect();
        let mut notes = vec!["PMKS+ writes no units of mass: masses are taken as kilograms (pounds if forces are in lbf), moments of inertia as mass times the unit of length squared".to_owned()];
        if of_sliders.is_none() && points.iter().any(|point| point.driven && point.slides && point.speed == 0.0) {
            notes.push(format!("the file has no speed of driven sliders: {SPEED_OF_SLIDERS} units of length a second, as PMKS+ takes it"));
        }
        if self.rest.split('.').nth(1).is_some_and(|marks| marks.split(',').any(|mark| mark.starts_with('P'))) {
            notes
                .push("numbers are read to a thousandth: the further digits at the file's end are left out".to_owned());
        }
        let pins = points.into_iter().map(|point| point.pin).collect();
        ImportedLinkage {
            program: "PMKS+",
            title: String::new(),
            gravity: (!weightless).then_some([0.0, -9.81]),
            pins,
            links,
            drives,
            forces,
            notes,
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

    fn point(&mut self, text: &'a str, units: &PmksUnits) -> Option<JointDraft<'a>> {
        let (flag, rest) = text.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(2).take(3).filter_map(|part| decimal(part)).collect();
        let (Some(switches), [id, name, ..], [x, y, angle], true) =
            (flags::<6>(flag), &parts[..], &numbers[..], parts.len() <= 9)
        else {
            self.faults.push(format!("joint `{text}` is not as PMKS+ writes one"));
            return None;
        };
        let [slides, driven, grounded, welded, traced, _] = switches;
        let part = |place: usize| parts.get(place).copied().unwrap_or_default();
        let guide = [part(5), part(6), part(7)];
        let carried = guide.iter().any(|part| !part.is_empty());
        if slides && !grounded && !carried {
            self.faults.push(format!("joint `{name}` slides, but neither on the ground nor on a link"));
        }
        let along = [angle.cos(), angle.sin()];
        let kind = if slides { PinKind::Sliding(ImportedGuide { on: None, along }) } else { PinKind::Turning };
        let at = [x * units.length, y * units.length];
        let pin = Pin { name: (*name).to_owned(), at, kind, grounded: grounded && !carried, welded, traced };
        let speed = decimal(part(8)).unwrap_or_default();
        Some(JointDraft { id, pin, driven, slides, guide: (slides && carried).then_some(guide), speed })
    }

    fn draft(&mut self, text: &'a str, units: &PmksUnits) -> Option<LinkDraft<'a>> {
        let (flag, rest) = text.split_at_checked(1)?;
        // Whether it is a whole, whether mass centre and moment of inertia are chosen by hand, whether it is drawn as a disc. Parts of a welded link follow
        // it: only the whole is a body.
        if "Namg4567".contains(flag) {
            return None;
        }
        let (kind, rest) = rest.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(2).take(4).filter_map(|part| decimal(part)).collect();
        let known = "YAMG0123".contains(flag) && ["R", "P"].contains(&kind) && parts.len() > 7;
        let (true, [id, name, ..], [mass, inertia, x, y]) = (known, &parts[..], &numbers[..]) else {
            self.faults.push(format!("link `{text}` is not as PMKS+ writes one"));
            return None;
        };
        let block = kind == "P";
        let link = ImportedLink {
            name: (*name).to_owned(),
            pins: Vec::new(),
            mass: Some(mass * units.mass),
            inertia: (!block).then_some(inertia * units.mass * units.length * units.length),
            centre: (!block).then_some([x * units.length, y * units.length]),
        };
        let mut lists = parts[7..].split(|part| part.is_empty());
        let [joints, parts] = [lists.next(), lists.next()].map(|list| list.unwrap_or_default().to_vec());
        Some(LinkDraft { link, id, parts, joints })
    }

    /// Puts guides that are cut into links in their place: along two joints of the link.
    fn guides(&mut self, points: &mut [JointDraft<'a>], drafts: &[LinkDraft], units: &PmksUnits) {
        let places: Vec<(&str, [f64; 2])> = points.iter().map(|point| (point.id, point.pin.at)).collect();
        for point in points {
            let Some([link, first, second]) = point.guide else { continue };
            let name = &point.pin.name;
            let place = |id: &str| places.iter().find(|(known, _)| *known == id).map(|(_, at)| *at);
            let on = whole(drafts, link);
            let held = |id: &str| on.is_some_and(|on| drafts[on].joints.contains(&id));
            let (Some(on), Some(from), Some(to), true) = (on, place(first), place(second), held(first) && held(second))
            else {
                self.faults.push(format!("joint `{name}` slides along `{first}` and `{second}` of the link `{link}`, but there is no such link with these joints"));
                continue;
            };
            // The pin is on the guide but for what the file has rounded: the line through it and the farther joint closes the loops in the pose of the file.
            let at = point.pin.at;
            let apart = |one: [f64; 2], other: [f64; 2]| (one[0] - other[0]).hypot(one[1] - other[1]);
            let (start, end) = if apart(at, from) >= apart(at, to) { (from, at) } else { (at, to) };
            let (length, span) = (apart(start, end), apart(from, to));
            let beside = (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0]);
            if span == 0.0 || length == 0.0 || (beside / span).abs() > ROUNDED * units.length {
                self.faults.push(format!(
                    "joint `{name}` slides along the joints `{first}` and `{second}`, but is not on a line with them"
                ));
                continue;
            }
            let way = [end[0] - start[0], end[1] - start[1]];
            let sense = if way[0] * (to[0] - from[0]) + way[1] * (to[1] - from[1]) < 0.0 { -length } else { length };
            point.pin.kind = PinKind::Sliding(ImportedGuide { on: Some(on), along: way.map(|part| part / sense) });
        }
    }

    fn links(&mut self, points: &[JointDraft], drafts: &[LinkDraft]) -> Vec<ImportedLink> {
        let mut links = Vec::new();
        for draft in drafts {
            let place = |id: &&str| points.iter().position(|point| point.id == *id);
            for id in draft.joints.iter().filter(|id| place(id).is_none()) {
                self.faults.push(format!("link `{}` has the joint `{id}`, which is not there", draft.id));
            }
            links.push(ImportedLink { pins: draft.joints.iter().filter_map(place).collect(), ..draft.link.clone() });
        }
        links
    }

    fn force(&mut self, text: &str, drafts: &[LinkDraft], units: &PmksUnits) -> Option<LinkForce> {
        let (flag, rest) = text.split_at_checked(1)?;
        let parts: Vec<&str> = rest.split(',').collect();
        let numbers: Vec<f64> = parts.iter().skip(3).filter_map(|part| decimal(part)).collect();
        let read = (flags::<2>(flag), &parts[..], &numbers[..]);
        let (Some([turns, outward]), [_, link, name, ..], [x, y, to_x, to_y, size]) = read else {
            self.faults.push(format!("force `{text}` is not as PMKS+ writes one"));
            return None;
        };
        let Some(link) = whole(drafts, link) else {
            self.faults.push(format!("force `{name}` acts on the link `{link}`, which is not there"));
            return None;
        };
        let [along, across] = [to_x - x, to_y - y];
        let length = along.hypot(across);
        let share = if length > 0.0 { size * units.force / length } else { 0.0 } * if outward { 1.0 } else { -1.0 };
        let at = [x * units.length, y * units.length];
        Some(LinkForce { name: (*name).to_owned(), link, at, vector: [share * along, share * across], turns })
    }

    /// A driven joint moves the second of two bodies against the first: the ground, then links in the order of the file; a block against its guide.
    fn drive(
        &mut self,
        pin: usize,
        point: &JointDraft,
        links: &[ImportedLink],
        speeds: &Speeds,
        units: &PmksUnits,
    ) -> Option<Drive> {
        let here: Vec<usize> = (0..links.len()).filter(|&link| links[link].pins.contains(&pin)).collect();
        let speed = (point.speed != 0.0).then_some(point.speed);
        let name = &point.pin.name;
        let against_other = point.pin.grounded || point.guide.is_some();
        let course = if point.slides {
            DriveLaw::Steady(speed.unwrap_or(speeds.sliding) * units.length)
        } else {
            DriveLaw::Steady(speed.unwrap_or(speeds.turning) * PI / 30.0)
        };
        match (&here[..], against_other) {
            _ if point.pin.welded => {
                self.faults.push(format!("joint `{name}` is driven, but welded: nothing moves there"))
            }
            (&[link], true) | (&[_, link], false) => return Some(Drive { pin, link, course }),
            (links, _) => {
                let bodies = counted(links.len() + usize::from(against_other), "body");
                self.faults.push(format!(
                    "joint `{name}` is driven, but joins {bodies}: a driven joint must join exactly two"
                ));
            }
        }
        None
    }
}

/// The link of this letter, or the one that it was welded into.
fn whole(drafts: &[LinkDraft], id: &str) -> Option<usize> {
    let named = drafts.iter().position(|draft| draft.id == id);
    named.or_else(|| drafts.iter().position(|draft| draft.parts.contains(&id)))
}

/// The last letter of the units may be missing: PMKS+ cuts it.
fn units(text: &str) -> PmksUnits {
    let digit = |place: usize| text.get(place..place + 1).and_then(|digit| digit.parse::<u8>().ok());
    let length = match digit(0) {
        Some(0) => 0.0254,
        Some(2) => 1.0,
        _ => 0.01,
    };
    let (mass, force) = if digit(2) == Some(0) { (0.453_592_37, 4.448_221_615_260_5) } else { (1.0, 1.0) };
    PmksUnits { length, mass, force }
}
