//! Addresses that PMKS+ shared before its files of one line: names and numbers as they are, in rows. `j` has the joints, `l` the links, `s` the settings.
//!
//! A joint: name, x, y, its links, its kind, is it on the ground, angle, friction, is it the input. A link: name, mass, moment of inertia, mass centre, its joints; what
//! follows is how it is drawn. The settings: speed, two switches, the unit of lengths. The switches and the axes of sliders were never described: addresses with them
//! are refused.

use std::f64::consts::PI;

use super::linkage::{Drive, DriveLaw, ImportedLink, ImportedLinkage, Pin, PinKind};
use super::number::unescaped;

/// Is it such an address, without what stands before its `?`?
pub fn is_older(query: &str) -> bool {
    query.starts_with("j=") && query.contains("&l=")
}

pub fn read(query: &str) -> Result<ImportedLinkage, Vec<String>> {
    let parts: Vec<(&str, String)> =
        query.split('&').filter_map(|part| part.split_once('=')).map(|(key, value)| (key, unescaped(value))).collect();
    let part = |key: &str| parts.iter().find(|(known, _)| *known == key).map_or("", |(_, value)| value.as_str());
    let mut faults = Vec::new();
    for (key, what) in [("f", "forces"), ("pp", "points of paths"), ("tp", "traced points")] {
        if !part(key).trim().is_empty() {
            faults.push(format!(
                "it is an older address of PMKS+ with {what}, which is not read: only its joints and links are"
            ));
        }
    }
    let (length, rpm) = settings(part("s"), &mut faults);
    let joints: Vec<OlderPmksJoint> =
        rows(part("j")).filter_map(|row| OlderPmksJoint::read(row, length, &mut faults)).collect();
    let links =
        rows(part("l")).filter_map(|row| link(row, &joints, length, &mut faults)).collect::<Vec<ImportedLink>>();
    let drives = drives(&joints, &links, rpm * PI / 30.0, &mut faults);
    if !faults.is_empty() {
        return Err(faults);
    }
    let note = "an older address of PMKS+ names no units of mass: masses are taken as kilograms, moments of inertia as kilograms times the unit of length squared";
    Ok(ImportedLinkage {
        program: "PMKS+",
        pins: joints.into_iter().map(|joint| joint.pin).collect(),
        links,
        drives,
        notes: vec![note.to_owned()],
        ..ImportedLinkage::default()
    })
}

fn rows(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(str::trim).filter(|row| !row.is_empty())
}

/// Metres of a length, and revolutions a minute.
fn settings(text: &str, faults: &mut Vec<String>) -> (f64, f64) {
    let parts: Vec<&str> = text.trim().split(',').collect();
    let unit = |name: &str| match name {
        "cm" => Some(0.01),
        "m" => Some(1.0),
        _ => None,
    };
    match parts[..] {
        [speed, "false", "false", name] => match (speed.parse::<f64>(), unit(name)) {
            (Ok(speed), Some(length)) if speed.is_finite() => return (length, speed),
            (Ok(_), None) => faults.push(format!("its lengths are in `{name}`, but only cm and m are supported in older addresses")),
            _ => faults.push(format!("the speed `{speed}` is not a number")),
        },
        [_, _, _, _] => faults.push(
            "it is an older address of PMKS+ with a switch for gravity or the sense of turning: which of the two is not known; open it in PMKS+ and save it anew"
                .to_owned(),
        ),
        _ => faults.push("its settings `s` are truncated: they need a speed, two switches and the unit of lengths".to_owned()),
    }
    (1.0, 0.0)
}

struct OlderPmksJoint {
    pin: Pin,
    driven: bool,
}

impl OlderPmksJoint {
    fn read(row: &str, length: f64, faults: &mut Vec<String>) -> Option<OlderPmksJoint> {
        let parts: Vec<&str> = row.split(',').collect();
        let [name, x, y, _, kind, ground, _, _, input, ..] = parts[..] else {
            faults.push(format!("joint `{row}` is truncated"));
            return None;
        };
        let [Some(x), Some(y)] = [x, y].map(number) else {
            faults.push(format!("joint `{name}` has no position: `{x}`, `{y}`"));
            return None;
        };
        if kind != "R" {
            faults.push(format!("joint `{name}` slides, but only revolute joints are supported in older addresses"));
        }
        let pin = Pin {
            name: name.to_owned(),
            at: [x * length, y * length],
            kind: PinKind::Turning,
            grounded: ground == "t",
            welded: false,
            traced: false,
        };
        Some(OlderPmksJoint { pin, driven: input == "t" })
    }
}

fn link(row: &str, joints: &[OlderPmksJoint], length: f64, faults: &mut Vec<String>) -> Option<ImportedLink> {
    let parts: Vec<&str> = row.split(',').collect();
    let [name, mass, inertia, x, y, of, ..] = parts[..] else {
        faults.push(format!("link `{row}` is truncated"));
        return None;
    };
    let [Some(mass), Some(inertia), Some(x), Some(y)] = [mass, inertia, x, y].map(number) else {
        faults.push(format!("link `{name}` has a mass, a moment of inertia or a mass centre that is not a number"));
        return None;
    };
    let mut pins = Vec::new();
    for joint in of.split('|') {
        match joints.iter().position(|candidate| candidate.pin.name == joint) {
            Some(pin) => pins.push(pin),
            None => faults.push(format!("link `{name}` has the joint `{joint}`, which is not there")),
        }
    }
    Some(ImportedLink {
        name: name.to_owned(),
        pins,
        mass: Some(mass),
        inertia: Some(inertia * length * length),
        centre: Some([x * length, y * length]),
    })
}

fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

fn drives(joints: &[OlderPmksJoint], links: &[ImportedLink], rate: f64, faults: &mut Vec<String>) -> Vec<Drive> {
    let mut drives = Vec::new();
    for (pin, joint) in joints.iter().enumerate().filter(|(_, joint)| joint.driven) {
        match links.iter().position(|link| link.pins.contains(&pin)) {
            Some(link) if joint.pin.grounded => drives.push(Drive { pin, link, course: DriveLaw::Steady(rate) }),
            _ => faults.push(format!("joint `{}` is driven, but does not join a link to the ground", joint.pin.name)),
        }
    }
    drives
}
