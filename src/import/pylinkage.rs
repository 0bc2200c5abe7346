//! Mechanisms of pylinkage (<https://github.com/HugoFara/pylinkage>) as its `mechanism_to_json` writes them.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use super::linkage::{Drive, DriveLaw, ImportedGuide, ImportedLink, ImportedLinkage, Pin, PinKind};

#[derive(Deserialize)]
#[serde(rename = "Mechanism")]
struct PylinkageMechanism {
    #[serde(default)]
    name: String,
    joints: Vec<PylinkageJoint>,
    links: Vec<PylinkageBody>,
}

#[derive(Deserialize)]
#[serde(rename = "Joint")]
struct PylinkageJoint {
    id: String,
    #[serde(rename = "type", default)]
    kind: String,
    position: [Option<f64>; 2],
    name: Option<String>,
    axis: Option<[f64; 2]>,
    ref_joint1_id: Option<String>,
    ref_joint2_id: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename = "Body")]
struct PylinkageBody {
    id: String,
    #[serde(rename = "type", default)]
    kind: String,
    #[serde(default)]
    joints: Vec<String>,
    name: Option<String>,
    angular_velocity: Option<f64>,
    motor_joint: Option<String>,
    arc_start: Option<f64>,
    arc_end: Option<f64>,
}

pub fn read(file: &str) -> Result<ImportedLinkage, Vec<String>> {
    let mechanism = mechanism(file).map_err(|why| vec![format!("it is not JSON of pylinkage: {why}")])?;
    let mut faults = Vec::new();
    let linkage = linkage(&mechanism, &mut faults);
    if faults.is_empty() { Ok(linkage) } else { Err(faults) }
}

/// The mechanism of a file: the file itself, or what an example of the editor has under `mechanism`, alone or as the only one of a gallery.
fn mechanism(file: &str) -> Result<PylinkageMechanism, String> {
    let value: serde_json::Value = serde_json::from_str(file).map_err(|error| error.to_string())?;
    let of_example = |example: &serde_json::Value| example.get("mechanism").cloned();
    let examples: Vec<(&String, serde_json::Value)> = match value.as_object() {
        Some(entries) if !entries.contains_key("joints") && !entries.contains_key("mechanism") => {
            entries.iter().filter_map(|(name, entry)| Some((name, of_example(entry)?))).collect()
        }
        _ => Vec::new(),
    };
    let mechanism = match &examples[..] {
        [(_, mechanism)] => mechanism.clone(),
        [] => of_example(&value).unwrap_or(value),
        _ => {
            let names: Vec<&str> = examples.iter().map(|(name, _)| name.as_str()).collect();
            return Err(format!("it has {} examples ({}); save one of them alone", names.len(), names.join(", ")));
        }
    };
    serde_json::from_value(mechanism).map_err(|error| error.to_string())
}

fn linkage(mechanism: &PylinkageMechanism, faults: &mut Vec<String>) -> ImportedLinkage {
    let places: HashMap<&str, usize> =
        mechanism.joints.iter().enumerate().map(|(place, joint)| (joint.id.as_str(), place)).collect();
    let ground: Vec<&String> =
        mechanism.links.iter().filter(|link| link.kind == "ground").flat_map(|link| &link.joints).collect();
    let pins = mechanism.joints.iter().filter_map(|joint| pin(joint, ground.contains(&&joint.id), faults)).collect();
    let mut links: Vec<ImportedLink> = Vec::new();
    let mut drives = Vec::new();
    for body in mechanism.links.iter().filter(|link| link.kind != "ground") {
        for id in body.joints.iter().filter(|id| !places.contains_key(id.as_str())) {
            faults.push(format!("link `{}` has the joint `{id}`, which is not there", body.id));
        }
        let joint_places: Vec<usize> = body.joints.iter().filter_map(|id| places.get(id.as_str()).copied()).collect();
        match body.kind.as_str() {
            "link" | "" => {}
            "driver" | "arc_driver" => match body.motor_joint.as_ref().and_then(|id| places.get(id.as_str())) {
                Some(&pin) => match course(body, pin, &joint_places, &mechanism.joints) {
                    Ok(course) => drives.push(Drive { pin, link: links.len(), course }),
                    Err(fault) => faults.push(fault.to_string()),
                },
                None => faults.push(format!("driver `{}` has no motor joint", body.id)),
            },
            other => faults.push(format!("link `{}` is of type `{other}`, which is not supported", body.id)),
        }
        let name = body.name.clone().unwrap_or_else(|| body.id.clone());
        links.push(ImportedLink { name, pins: joint_places, mass: None, inertia: None, centre: None });
    }
    trackers(mechanism, &places, &mut links, faults);
    let mut notes =
        vec!["pylinkage writes no units: lengths are taken as metres, its radians per step as rad/s".to_owned()];
    notes.push("pylinkage has no masses: 1 kg for each metre of a link is assumed".to_owned());
    ImportedLinkage {
        program: "pylinkage",
        title: mechanism.name.clone(),
        gravity: None,
        pins,
        links,
        drives,
        forces: Vec::new(),
        notes,
    }
}

/// Why a driver cannot move within its arc.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct ArcError(pub String);

/// The course of a driver from the pose of the file: on and on, or to and fro within its arc.
fn course(
    body: &PylinkageBody,
    pin: usize,
    joint_places: &[usize],
    joints: &[PylinkageJoint],
) -> Result<DriveLaw, ArcError> {
    let rate = body.angular_velocity.unwrap_or(TAU / 360.0);
    if body.kind != "arc_driver" {
        return Ok(DriveLaw::Steady(rate));
    }
    let place = |pin: usize| match joints.get(pin)?.position {
        [Some(x), Some(y)] => Some([x, y]),
        _ => None,
    };
    let crank = joint_places.iter().find(|other| **other != pin).and_then(|other| Some([place(pin)?, place(*other)?]));
    let (start, end) = (body.arc_start.unwrap_or(0.0), body.arc_end.unwrap_or(PI));
    let Some([[x, y], [u, v]]) = crank.filter(|_| start < end && rate > 0.0) else {
        return Err(ArcError(format!(
            "driver `{driver}` has no arc: it needs two joints with positions, an upper end above the lower one and a positive speed",
            driver = body.id
        )));
    };
    // The turn of the angle that is nearest to the middle of the arc.
    let (angle, middle) = ((v - y).atan2(u - x), 0.5 * (start + end));
    let angle = angle + TAU * ((middle - angle) / TAU).round();
    // The places of the file have rounding errors.
    let slack = 1e-9 * (end - start);
    if angle < start - slack || angle > end + slack {
        return Err(ArcError(format!(
            "driver `{driver}` is at {angle:.6} rad, but its arc is from {start:?} to {end:?} rad",
            driver = body.id
        )));
    }
    Ok(DriveLaw::ToAndFro { rate, from: (start - angle).min(0.0), to: (end - angle).max(0.0) })
}

fn pin(joint: &PylinkageJoint, in_ground: bool, faults: &mut Vec<String>) -> Option<Pin> {
    let name = joint.name.clone().unwrap_or_else(|| joint.id.clone());
    let [Some(x), Some(y)] = joint.position else {
        faults.push(format!("joint `{}` has no position; build the mechanism before it is saved", joint.id));
        return None;
    };
    let kind = match joint.kind.as_str() {
        "ground" | "revolute" | "tracker" | "" => PinKind::Turning,
        "prismatic" => PinKind::Slot(ImportedGuide { on: None, along: joint.axis.unwrap_or([1.0, 0.0]) }),
        other => {
            faults.push(format!("joint `{}` is of type `{other}`, which is not supported", joint.id));
            return None;
        }
    };
    let grounded = joint.kind == "ground" || in_ground || kind != PinKind::Turning;
    Some(Pin { name, at: [x, y], kind, grounded, welded: false, traced: joint.kind == "tracker" })
}

/// A tracker is a point of the link that both its references are on.
fn trackers(
    mechanism: &PylinkageMechanism,
    places: &HashMap<&str, usize>,
    links: &mut [ImportedLink],
    faults: &mut Vec<String>,
) {
    for (place, joint) in mechanism.joints.iter().enumerate().filter(|(_, joint)| joint.kind == "tracker") {
        let of = |id: &Option<String>| id.as_ref().and_then(|id| places.get(id.as_str()).copied());
        let references = (of(&joint.ref_joint1_id), of(&joint.ref_joint2_id));
        let (Some(first), Some(second)) = references else {
            faults.push(format!("tracker `{}` has a reference that is not there", joint.id));
            continue;
        };
        match links.iter_mut().find(|link| link.pins.contains(&first) && link.pins.contains(&second)) {
            Some(link) if !link.pins.contains(&place) => link.pins.push(place),
            Some(_) => {}
            None => faults.push(format!("the references of tracker `{}` are on no common link", joint.id)),
        }
    }
}
