//! The summary of a mechanism that `cotree show` prints.

use std::fmt;

use serde::Serialize;

use crate::cells;
use crate::diagnostic::suggest;
use crate::typeset::{aligned, counted};

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    pub bodies: Vec<String>,
    pub joints: Vec<JointSummary>,
    pub drivers: Vec<String>,
    pub loads: Vec<String>,
    pub parameters: Vec<String>,
    pub inputs: Vec<String>,
    /// Quantities whose rates are given.
    pub states: Vec<String>,
    pub outputs: Vec<String>,
    pub mobility: usize,
    /// Does the motion follow from drivers and loops alone, without forces?
    pub kinematic: bool,
    /// How the motion is found, and why not by Taylor series if it is not; empty if the drivers determine it.
    pub solver: String,
    /// The systems that the methods integrate; none if the drivers determine the motion.
    pub integrated: Option<Integrated>,
    pub coordinates: Vec<CoordinateSummary>,
    /// The owners of the loop equations, one name for each equation.
    pub constraints: Vec<String>,
    /// What is held on one side only or sticks, and the modes of each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<ModesSummary>,
    /// What the redundant ones among them belong to.
    pub redundant: Vec<String>,
    /// If the drivers determine the motion: coordinates that are solved for together, in the order of solution.
    pub blocks: Vec<Vec<String>>,
    pub trees: TreesSummary,
    pub counts: Counts,
    /// The trees behind the acceleration kernel, where they are not those of the coordinates.
    pub solve_tree: Option<SolveTreeSummary>,
}

/// Something that holds in some of its modes only.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ModesSummary {
    /// Such as `guide.max`.
    pub name: String,
    /// Such as `open` and `closed`.
    pub modes: Vec<&'static str>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Integrated {
    /// The arm form, if there are Taylor series.
    pub series: Option<SeriesSystem>,
    /// Runge-Kutta and Radau: branch coordinates and independent loop equations.
    pub stages: Count,
    pub outputs_of_state: usize,
    /// Outputs that need accelerations or reactions too.
    pub outputs_of_acceleration: usize,
}

/// The unknowns of Taylor series, whose angles are those of the bodies themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SeriesSystem {
    pub angles: usize,
    pub displacements: usize,
    pub loop_equations: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JointSummary {
    pub name: String,
    /// `revolute`, `prismatic` or `weld`.
    #[serde(rename = "type")]
    pub kind: String,
    pub between: [String; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinateSummary {
    /// Its name, such as `crank.angle`.
    pub name: String,
    pub tree: GraphKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GraphKind {
    Translation,
    Rotation,
}

/// Branches of the trees, by the names of their elements; rigid arms are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TreesSummary {
    pub translation: Vec<String>,
    pub rotation: Vec<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolveTreeSummary {
    /// Bodies that are branches of its translational tree, but not of that of the coordinates.
    pub bodies: Vec<String>,
    /// The share of the cost that it saves by the cost model; `None` if the mechanism is too large to count.
    pub saving: Option<f64>,
}

/// Numbers of equations for each choice of trees; `None` where a choice is not possible, or the mechanism too large to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub used: Count,
    /// Tables 2 and 3 of McPhee (1998).
    pub recommended: Option<Count>,
    pub absolute: Option<Count>,
    pub joint: Option<Count>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Count {
    /// Branch coordinates, and as many equations of motion.
    pub coordinates: usize,
    pub constraints: usize,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let about = if self.description.is_empty() { String::new() } else { format!(": {}", self.description) };
        writeln!(f, "{}{about}\n", self.name)?;
        list(f, "bodies", &self.bodies)?;
        self.write_joints(f)?;
        let Summary { drivers, loads, parameters, inputs, states, outputs, .. } = self;
        let lists = [
            ("drivers", drivers),
            ("loads", loads),
            ("parameters", parameters),
            ("inputs", inputs),
            ("states", states),
            ("outputs", outputs),
        ];
        lists.into_iter().try_for_each(|(title, names)| list(f, title, names))?;
        let motion = match (self.kinematic, self.mobility) {
            (true, _) if self.drivers.is_empty() => "nothing can move",
            (true, _) => "the drivers determine the motion",
            (false, 1) => "degree of freedom",
            (false, _) => "degrees of freedom",
        };
        line(f, "mobility", self.mobility, motion)?;
        writeln!(f)?;
        self.write_equations(f)?;
        self.write_counts(f)?;
        self.write_savings(f)
    }
}

impl Summary {
    fn write_joints(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let row = |joint: &JointSummary| cells![joint.name, format!("{:<9}", joint.kind), joint.between.join(" - ")];
        let joints = aligned(&self.joints.iter().map(row).collect::<Vec<_>>(), usize::MAX, "");
        joints.lines().enumerate().try_for_each(|(index, joint)| match index {
            0 => line(f, "joints", self.joints.len(), joint),
            _ => line(f, "", "", joint),
        })
    }

    fn write_equations(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (tree, title) in [(GraphKind::Translation, "translation"), (GraphKind::Rotation, "rotation")] {
            let names: Vec<&str> =
                self.coordinates.iter().filter(|q| q.tree == tree).map(|q| q.name.as_str()).collect();
            list(f, title, &names)?;
        }
        counted_names(f, "loops", self.constraints.len(), &tally(&self.constraints))?;
        let modes = self.modes.iter().map(|mode| format!("{} ({})", mode.name, mode.modes.join(", ")));
        list(f, "modes", &modes.collect::<Vec<_>>())?;
        counted_names(f, "redundant", self.redundant.len(), &tally(&self.redundant))?;
        if !self.solver.is_empty() {
            line(f, "solver", "", &self.solver)?;
        }
        self.write_integrated(f)?;
        list(f, "blocks", &self.blocks.iter().map(|names| names.join(" with ")).collect::<Vec<_>>())
    }

    fn write_integrated(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(Integrated { series, stages, outputs_of_state, outputs_of_acceleration }) = self.integrated else {
            return Ok(());
        };
        let loops = |count: usize| counted(count, "loop equation");
        if let Some(SeriesSystem { angles, displacements, loop_equations }) = series {
            let unknowns =
                format!("{} in the world, {}", counted(angles, "angle"), counted(displacements, "displacement"));
            line(f, "series", "", &format!("{unknowns}, {}: the arm form; the trees say", loops(loop_equations)))?;
            line(f, "", "", "what the loops cut, but not what its angles count from")?;
        }
        let stages = format!("{}, {}", counted(stages.coordinates, "coordinate"), loops(stages.constraints));
        line(f, "Runge-Kutta", "", &format!("{stages}: the printed equations, in the coordinates of both trees"))?;
        let [state, more] = [outputs_of_state, outputs_of_acceleration].map(|count| counted(count, "output"));
        line(f, "read", "", &format!("{state} from positions and rates, {more} from accelerations or reactions"))
    }

    fn write_counts(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let choices = [
            ("recommended", self.counts.recommended),
            ("absolute", self.counts.absolute),
            ("joint", self.counts.joint),
            ("this scene", Some(self.counts.used)),
        ];
        let mut rows = vec![cells!["choice", "coordinates", "loop equations"]];
        rows.extend(choices.map(|(name, count)| match count {
            Some(count) => cells![name, count.coordinates, count.constraints],
            None => cells![name, "-", "-"],
        }));
        write!(f, "\n{}", aligned(&rows, 1, "  "))
    }

    fn write_savings(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(tree) = &self.solve_tree else { return Ok(()) };
        let saving = tree.saving.map_or_else(String::new, |saving| format!(", {:.0} % cheaper", 100.0 * saving));
        writeln!(f, "\n  solve tree: accelerations through {} bodies as branches{saving}", tree.bodies.len())
    }
}

fn line(f: &mut fmt::Formatter<'_>, title: &str, count: impl fmt::Display, text: &str) -> fmt::Result {
    writeln!(f, "  {title:<12}{count:>4}  {text}")
}

/// A line of names; no line if there are none.
fn list<S: AsRef<str>>(f: &mut fmt::Formatter<'_>, title: &str, names: &[S]) -> fmt::Result {
    counted_names(f, title, names.len(), names)
}

/// The same for names that stand for `count` things.
fn counted_names<S: AsRef<str>>(f: &mut fmt::Formatter<'_>, title: &str, count: usize, names: &[S]) -> fmt::Result {
    const MOST: usize = 24;
    if names.is_empty() { Ok(()) } else { line(f, title, count, &suggest::joined(names, MOST)) }
}

/// Names in the order of their first use; those that occur again say how often.
fn tally(names: &[String]) -> Vec<String> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match counts.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    counts.into_iter().map(|(name, n)| if n > 1 { format!("{name} ({n})") } else { name.to_owned() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn slider_crank() -> Summary {
        let joint = |name: &str, kind: &str, first: &str, second: &str| JointSummary {
            name: name.into(),
            kind: kind.into(),
            between: [first.into(), second.into()],
        };
        let coordinate = |name: &str| CoordinateSummary { name: name.into(), tree: GraphKind::Rotation };
        Summary {
            name: "slider_crank".into(),
            description: "McPhee 1998, Fig. 1".into(),
            bodies: names(&["crank", "rod", "slider"]),
            joints: vec![
                joint("main_bearing", "revolute", "ground.bearing", "crank.inner"),
                joint("cylinder", "prismatic", "ground.guide", "slider"),
            ],
            outputs: names(&["crank.angle"]),
            mobility: 1,
            solver: "Taylor series".into(),
            integrated: Some(Integrated {
                series: Some(SeriesSystem { angles: 2, displacements: 0, loop_equations: 1 }),
                stages: Count { coordinates: 2, constraints: 1 },
                outputs_of_state: 1,
                outputs_of_acceleration: 0,
            }),
            coordinates: vec![coordinate("crank.angle"), coordinate("rod.angle")],
            constraints: names(&["cylinder", "cylinder"]),
            counts: Counts {
                used: Count { coordinates: 2, constraints: 1 },
                recommended: Some(Count { coordinates: 2, constraints: 1 }),
                absolute: Some(Count { coordinates: 9, constraints: 8 }),
                joint: None,
            },
            ..Summary::default()
        }
    }

    #[test]
    fn the_text_is_a_table() {
        insta::assert_snapshot!(slider_crank(), @r"
        slider_crank: McPhee 1998, Fig. 1

          bodies         3  crank, rod, slider
          joints         2  main_bearing  revolute   ground.bearing - crank.inner
                            cylinder      prismatic  ground.guide - slider
          outputs        1  crank.angle
          mobility       1  degree of freedom

          rotation       2  crank.angle, rod.angle
          loops          2  cylinder (2)
          solver            Taylor series
          series            2 angles in the world, 0 displacements, 1 loop equation: the arm form; the trees say
                            what the loops cut, but not what its angles count from
          Runge-Kutta       2 coordinates, 1 loop equation: the printed equations, in the coordinates of both trees
          read              1 output from positions and rates, 0 outputs from accelerations or reactions

          choice       coordinates  loop equations
          recommended            2               1
          absolute               9               8
          joint                  -               -
          this scene             2               1
        ");
    }

    #[test]
    fn what_a_solve_tree_saves_is_reported() {
        let solve_tree = SolveTreeSummary { bodies: names(&["a", "b"]), saving: Some(0.336) };
        let text = Summary { solve_tree: Some(solve_tree), ..slider_crank() }.to_string();
        let reported: String = text.lines().rev().take(2).collect::<Vec<_>>().into_iter().rev().collect();
        assert_eq!(reported, "  solve tree: accelerations through 2 bodies as branches, 34 % cheaper");
    }
}
