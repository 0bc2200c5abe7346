//! The letters of through and across variables: vectors in the plane, numbers on a line.

use crate::component::{Direction, Element};
use crate::mechanism::Dimension;
use crate::output::text::name::Name;
use crate::output::text::tree::Tree;

/// How the variables of one mechanism are written.
#[derive(Clone, Copy, Debug)]
pub struct Letters {
    plane: bool,
}

impl Letters {
    pub fn new(dimension: Dimension) -> Self {
        Letters { plane: dimension == Dimension::Two }
    }

    pub fn force(self, label: &str) -> Tree {
        self.vector("F", label)
    }

    pub fn torque(self, label: &str) -> Tree {
        Tree::Name(Name::letter("T", label))
    }

    /// `r`; on a line `x`, as in the paper.
    pub fn displacement(self, label: &str) -> Tree {
        self.vector(if self.plane { "r" } else { "x" }, label)
    }

    pub fn acceleration(self, label: &str) -> Tree {
        self.vector("a", label)
    }

    pub fn angle(self, label: &str) -> Tree {
        Tree::Name(Name::letter("theta", label))
    }

    pub fn slide(self, label: &str) -> Tree {
        Tree::Name(Name::letter("s", label))
    }

    pub fn gravity(self) -> Tree {
        self.vector("g", "")
    }

    /// The unit vector of a direction, with the element whose axis it is: along it or across.
    pub fn direction(self, direction: Direction, element: &Element, along: bool) -> Tree {
        Tree::Name(match direction {
            Direction::X => Name::bold("i", ""),
            Direction::Y => Name::bold("j", ""),
            Direction::Fixed(..) => Name::bold(if along { "u" } else { "n" }, &element.label),
        })
    }

    /// The projection of a vector on the unit vector of a direction; on a line there is nothing to project.
    pub fn projected(self, vector: Tree, direction: Direction, element: &Element, along: bool) -> Tree {
        match self.plane {
            true => Tree::Relation(".", Box::new([vector, self.direction(direction, element, along)])),
            false => vector,
        }
    }

    pub fn has_two_components(self) -> bool {
        self.plane
    }

    fn vector(self, letter: &str, label: &str) -> Tree {
        Tree::Name(if self.plane { Name::bold(letter, label) } else { Name::letter(letter, label) })
    }
}
