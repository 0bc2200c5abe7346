//! What is reported of a singular configuration that the motion has passed.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Branches that miss each other by less than this are passed as if they met, whatever the tolerance: next to the pose rounding errors of positions, divided by the
/// distance from it, are of the order of the distance of the branches, its root.
const MEET: f64 = 1e-10;
/// More bodies than this are counted.
const NAMED_BODIES: usize = 4;

/// A singular configuration that the motion has passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passage {
    /// When [s].
    pub time: f64,
    /// Joints and drivers whose loop equations depend on each other there.
    pub joints: Vec<String>,
    /// Bodies that turn in these loops; joints, where their angles are the coordinates.
    pub bodies: Vec<String>,
    /// How many loop equations follow from the others there.
    pub freedoms: usize,
    /// By how much the branches miss each other there, relative to the scales of the loop equations; 0 if it is no more than rounding errors.
    pub defect: f64,
}

impl Passage {
    /// Do the branches only come close to each other?
    pub fn is_avoided(&self) -> bool {
        self.defect > MEET
    }

    /// Was it passed as if the branches met, though they do not?
    pub fn is_inexact(&self) -> bool {
        self.defect > 0.0
    }
}

impl fmt::Display for Passage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "t = {:.6} s: ", self.time)?;
        match (self.joints.as_slice(), self.bodies.as_slice()) {
            // One loop, whose joints are then on a line.
            ([_], [_, _, ..]) => write!(formatter, "{} are collinear", listed(&self.bodies))?,
            ([], _) => write!(formatter, "singular configuration")?,
            _ => write!(formatter, "singular configuration of the loops at {}", listed(&self.joints))?,
        }
        let freedoms = if self.freedoms == 1 { "degree of freedom" } else { "degrees of freedom" };
        write!(formatter, "; crossing it with {} {freedoms} gained", self.freedoms)?;
        match self.is_inexact() {
            true => write!(
                formatter,
                "; it is crossed as if the branches of the motion met, but they miss each other by {:.0e} of the lengths",
                self.defect
            ),
            false => Ok(()),
        }
    }
}

/// Names in backticks, the last ones counted if there are many.
fn listed(names: &[String]) -> String {
    let shown = if names.len() > NAMED_BODIES { NAMED_BODIES - 1 } else { names.len() };
    let mut words: Vec<String> = names[..shown].iter().map(|name| format!("`{name}`")).collect();
    if shown < names.len() {
        words.push(format!("{} others", names.len() - shown));
    }
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_the_bodies_in_line() {
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let mut passage =
            Passage { time: 3.25, joints: names(&["pin"]), bodies: names(&["crank", "rod"]), freedoms: 1, defect: 0.0 };
        assert_eq!(
            passage.to_string(),
            "t = 3.250000 s: `crank` and `rod` are collinear; crossing it with 1 degree of freedom gained"
        );
        assert!(!passage.is_inexact() && !passage.is_avoided());
        passage.defect = 3e-11;
        assert!(passage.to_string().ends_with("miss each other by 3e-11 of the lengths"));
        assert!(passage.is_inexact() && !passage.is_avoided());
        passage.defect = 0.0;
        passage.bodies = names(&["a", "b", "c", "d", "e"]);
        assert!(passage.to_string().contains("`a`, `b`, `c` and 2 others are collinear"), "{passage}");
        (passage.joints, passage.freedoms) = (names(&["left", "right"]), 2);
        assert!(
            passage.to_string().ends_with("loops at `left` and `right`; crossing it with 2 degrees of freedom gained"),
            "{passage}"
        );
    }
}
