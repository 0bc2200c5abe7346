//! The derivation as a lesson, in the order of the paper: elements and graphs, trees, cutsets and circuits, terminal equations, then
//! Steps 1 to 4.

mod graphs;
mod letters;
mod own;
mod projection;
mod terminal;
mod view;

use super::document::{Block, Piece};
use super::motion::Motion;
use super::{Prose, page};
use crate::equations::Equations;
use crate::graph::{Rotation, Translation};
use letters::Letters;
use view::View;

struct Lesson<'a, 'm> {
    equations: &'a Equations<'m>,
    letters: Letters,
    translation: View<Translation>,
    rotation: View<Rotation>,
}

pub fn steps(equations: &mut Equations, prose: Prose) -> String {
    let motion = Motion::new(equations);
    let terminal = terminal::equations(equations, motion.dynamic);
    let lesson = Lesson::new(equations);
    let mut blocks = lesson.elements();
    blocks.extend(lesson.incidence());
    blocks.extend(lesson.topology());
    blocks.push(heading("Terminal equations (Table 1)"));
    blocks.push(words("What each element says by itself; u and n are unit vectors along and across an axis."));
    blocks.push(Block::Equations(terminal));
    if motion.dynamic {
        blocks.extend(lesson.cutset_equations());
    }
    blocks.extend(lesson.circuit_equations());
    blocks.extend(lesson.eliminations(motion.dynamic));
    blocks.push(heading("Step 4: the equations of motion"));
    blocks.push(words("With all secondary variables eliminated, in the branch coordinates alone:"));
    own::tell_apart(&mut blocks, &equations.system);
    blocks.extend(motion.blocks(equations));
    let title = format!("How the equations of motion of {} are derived", equations.system.mechanism.name);
    page(&title, &blocks, prose)
}

impl<'a, 'm> Lesson<'a, 'm> {
    fn new(equations: &'a Equations<'m>) -> Self {
        let (system, trees) = (&equations.system, &equations.trees);
        Lesson {
            equations,
            letters: Letters::new(system.mechanism.dimension),
            translation: View::new(system, &system.translation, &trees.translation, system.coupled_points()),
            rotation: View::new(system, &system.rotation, &trees.rotation, system.coupled_bodies()),
        }
    }
}

fn heading(text: &str) -> Block {
    Block::Heading(text.into())
}

fn words(text: impl Into<String>) -> Block {
    Block::Text(vec![Piece::words(text)])
}
