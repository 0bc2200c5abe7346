//! Steps 1 to 3: cutsets on motion spaces, circuits on reaction spaces, and the elimination of secondary variables.

use super::view::{Edge, Row, View};
use super::{Lesson, heading, words};
use crate::component::{Angle, Direction, Held, Origin};
use crate::graph::Rotation;
use crate::output::text::document::Block;
use crate::output::text::tree::Tree;

type Rows = Vec<(Tree, Tree)>;

impl Lesson<'_, '_> {
    /// Step 1: cutsets of branches, projected on their motion spaces.
    pub fn cutset_equations(&self) -> Vec<Block> {
        let letters = self.letters;
        let mut rows = Rows::new();
        for (branch, cutset) in self.translation.branches.iter().zip(self.translation.cutsets()) {
            let element = self.equations.system.element(branch.element);
            for (along, _) in element.translation.iter().flat_map(|row| &row.motion) {
                let sum = signed(Some(&branch.label), &cutset, |label| letters.force(label));
                rows.push((letters.projected(sum, *along, element, true), Tree::zero()));
            }
        }
        for (branch, cutset) in self.rotation.branches.iter().zip(self.rotation.cutsets()) {
            if self.is_free(branch) {
                rows.push((signed(Some(&branch.label), &cutset, |label| letters.torque(label)), Tree::zero()));
            }
        }
        let mut blocks = vec![heading("Step 1: cutset equations on the motion spaces")];
        if rows.is_empty() {
            blocks.push(words("No branch is free to move: there are no equations of motion."));
        } else {
            blocks.push(words(
                "For each coordinate, the balance of its branch's cutset, projected on the direction in which the branch can move (14):",
            ));
            blocks.push(Block::Equations(rows));
        }
        let efforts = self.efforts();
        if !efforts.is_empty() {
            blocks.push(words("The cutset of a driver says what it must exert:"));
            blocks.push(Block::Equations(efforts));
        }
        blocks
    }

    fn efforts(&self) -> Rows {
        let is_driver = |element| matches!(self.equations.system.element(element).origin, Origin::Driver(_));
        let effort = |branch: &str, cutset: &Row, letter: &dyn Fn(&str) -> Tree| {
            (letter(branch), signed(None, &negated(cutset), letter))
        };
        let forces = self.translation.branches.iter().zip(self.translation.cutsets());
        let forces = forces
            .filter(|(branch, _)| is_driver(branch.element))
            .map(|(branch, cutset)| effort(&branch.label, &cutset, &|label| self.letters.force(label)));
        let torques = self.rotation.branches.iter().zip(self.rotation.cutsets());
        let torques = torques
            .filter(|(branch, _)| is_driver(branch.element))
            .map(|(branch, cutset)| effort(&branch.label, &cutset, &|label| self.letters.torque(label)));
        forces.chain(torques).collect()
    }

    /// Step 2: circuits of chords, projected on their reaction spaces; and the displacements of slides.
    pub fn circuit_equations(&self) -> Vec<Block> {
        let mut blocks = vec![heading("Step 2: circuit equations on the reaction spaces")];
        if self.equations.constraints.is_empty() {
            blocks.push(words("No chord has a reaction space: there are no loop equations."));
        }
        let mut section = |text: &str, rows: Rows, said_anyway: bool| {
            if said_anyway || !rows.is_empty() {
                blocks.push(words(text));
            }
            if !rows.is_empty() {
                blocks.push(Block::Equations(rows));
            }
        };
        section(
            "For each direction of a chord's reaction space, its circuit projected on that direction (15); the reaction in that direction is its \
             multiplier:",
            self.held(),
            false,
        );
        let coupled = self.coupled();
        let circuits = if coupled.is_empty() { "" } else { " The circuits of its chords give the variables:" };
        section(
            &format!(
                "Couplings: each relation between across variables in the terminal equations is a loop equation, and its reaction is the \
                 multiplier.{circuits}"
            ),
            coupled,
            self.equations.constraints.iter().any(|constraint| !constraint.coupled.is_empty()),
        );
        section(
            "Projected on the direction in which it slides, the circuit gives the slide itself:",
            self.slides(),
            false,
        );
        blocks
    }

    fn held(&self) -> Rows {
        let own = self.equations.constraints.iter().filter(|constraint| constraint.coupled.is_empty());
        let row = own.filter_map(|constraint| {
            let element = self.equations.system.element(constraint.element);
            let left = match constraint.held {
                Held::Along(along) => {
                    let chord = self.translation.chords.iter().find(|chord| chord.element == constraint.element)?;
                    let sum = signed(Some(&chord.label), &self.translation.circuit(chord), |label| {
                        self.letters.displacement(label)
                    });
                    self.letters.projected(sum, along, element, matches!(element.origin, Origin::Driver(_)))
                }
                Held::Angle | Held::Length => {
                    let chord = self.rotation.chords.iter().find(|chord| chord.element == constraint.element)?;
                    signed(Some(&chord.label), &self.rotation.circuit(chord), |label| self.letters.angle(label))
                }
            };
            Some((left, Tree::zero()))
        });
        row.collect()
    }

    /// The across variables of the terms of couplings, but for those that Step 3 has anyway: a rolling disc's.
    fn coupled(&self) -> Rows {
        let (displacement, angle) =
            (|label: &str| self.letters.displacement(label), |label: &str| self.letters.angle(label));
        let points = self.translation.chords.iter().filter(|chord| chord.is_term);
        let points = points.map(|chord| self.by_branches(&self.translation, chord, displacement));
        let bodies = self.rotation.chords.iter().filter(|chord| chord.is_term);
        points.chain(bodies.map(|chord| self.by_branches(&self.rotation, chord, angle))).collect()
    }

    fn slides(&self) -> Rows {
        let slides = self.translation.chords.iter().filter(|chord| !chord.is_term).filter_map(|chord| {
            let element = self.equations.system.element(chord.element);
            let along: Direction = match (element.origin, &element.translation) {
                (Origin::Joint(_), Some(row)) => row.motion.first().map(|(along, _)| *along)?,
                _ => return None,
            };
            let sum = signed(None, &self.translation.path(chord), |label| self.letters.displacement(label));
            Some((self.letters.slide(&chord.label), self.letters.projected(sum, along, element, true)))
        });
        slides.collect()
    }

    /// Step 3: arm forces by chords; chord accelerations and angles by branches.
    pub fn eliminations(&self, dynamic: bool) -> Vec<Block> {
        let mut sections = Vec::new();
        if dynamic {
            sections.push(("Forces in rigid arms, by the chord transformation (16):".to_owned(), self.arms()));
        }
        let what = if dynamic { "Accelerations of mass centres" } else { "Positions of mass centres" };
        let arms = match (dynamic, self.letters.has_two_components()) {
            (true, true) => "; an arm's is alpha x r - omega^2 r of its body",
            (true, false) => "; an arm's is zero",
            (false, _) => "",
        };
        let text = format!("{what}, by the branch transformation of the translational tree (17){arms}:");
        sections.push((text, self.centres(dynamic)));
        let text = "Angles of chords, and in the same way their rates, by the branch transformation of the rotational tree (18):";
        sections.push((text.to_owned(), self.angles()));
        sections.retain(|(_, rows)| !rows.is_empty());
        let mut blocks = vec![heading("Step 3: secondary variables are eliminated")];
        if sections.is_empty() {
            blocks.push(words("There are none: every variable is a coordinate, known, or a reaction."));
        }
        blocks.extend(sections.into_iter().flat_map(|(text, rows)| [words(text), Block::Equations(rows)]));
        blocks
    }

    fn arms(&self) -> Rows {
        let branches = self.translation.branches.iter().zip(self.translation.cutsets());
        let is_arm = |edge: &Edge<_>| matches!(self.equations.system.element(edge.element).origin, Origin::Arm(..));
        let row = |(branch, cutset): (&Edge<_>, Row)| {
            let sum = signed(None, &negated(&cutset), |label| self.letters.force(label));
            (self.letters.force(&branch.label), sum)
        };
        branches.filter(|(branch, _)| is_arm(branch)).map(row).collect()
    }

    fn centres(&self, dynamic: bool) -> Rows {
        let is_body = |edge: &&Edge<_>| matches!(self.equations.system.element(edge.element).origin, Origin::Body(_));
        let letter = |label: &str| match dynamic {
            true => self.letters.acceleration(label),
            false => self.letters.displacement(label),
        };
        let bodies = self.translation.chords.iter().filter(|chord| !chord.is_term).filter(is_body);
        bodies.map(|chord| self.by_branches(&self.translation, chord, letter)).collect()
    }

    fn angles(&self) -> Rows {
        let free = self.rotation.chords.iter().filter(|chord| !chord.is_term && self.is_free(chord));
        free.map(|chord| self.by_branches(&self.rotation, chord, |label| self.letters.angle(label))).collect()
    }

    /// An across variable of a chord as a sum of those of branches.
    fn by_branches<D>(&self, view: &View<D>, chord: &Edge<D>, letter: impl Fn(&str) -> Tree) -> (Tree, Tree) {
        (letter(&chord.label), signed(None, &view.path(chord), &letter))
    }

    fn is_free(&self, edge: &Edge<Rotation>) -> bool {
        let row = self.equations.system.element(edge.element).rotation.as_ref();
        row.is_some_and(|row| matches!(row.angle, Angle::Free(_)))
    }
}

fn negated(row: &Row) -> Row {
    row.iter().map(|(label, sign)| (label.clone(), -sign)).collect()
}

/// A sum of variables of edges with the signs of a row.
fn signed(own: Option<&str>, row: &Row, letter: impl Fn(&str) -> Tree) -> Tree {
    let others = row.iter().map(|(label, sign)| (*sign < 0, letter(label)));
    Tree::sum(own.map(|label| (false, letter(label))).into_iter().chain(others).collect())
}
