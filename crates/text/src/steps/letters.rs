//! The letters of through and across variables: vectors in the plane, numbers on a line.

use cotree::model::Dimension;
use cotree::network::{Direction, Element};

use crate::name::Name;
use crate::tree::Tree;

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
        Tree::Name(Name::edge("T", label, false))
    }

    /// `r`; on a line `x`, as in the paper.
    pub fn displacement(self, label: &str) -> Tree {
        self.vector(if self.plane { "r" } else { "x" }, label)
    }

    pub fn velocity(self, label: &str) -> Tree {
        self.vector("v", label)
    }

    pub fn acceleration(self, label: &str) -> Tree {
        self.vector("a", label)
    }

    pub fn angle(self, label: &str) -> Tree {
        Tree::Name(Name::edge("theta", label, false))
    }

    pub fn omega(self, label: &str) -> Tree {
        Tree::Name(Name::edge("omega", label, false))
    }

    pub fn alpha(self, label: &str) -> Tree {
        Tree::Name(Name::edge("alpha", label, false))
    }

    pub fn slide(self, label: &str) -> Tree {
        Tree::Name(Name::edge("s", label, false))
    }

    /// s' of an edge.
    pub fn rate_of_slide(self, label: &str) -> Tree {
        let name = Name::edge("s", label, false);
        Tree::Name(Name { plain: format!("{}'", name.plain), dots: 1, ..name })
    }

    pub fn gravity(self) -> Tree {
        Tree::Name(if self.plane { Name::bold("g", "") } else { Name::letter("g", "") })
    }

    /// k . a: the component of a couple out of the plane.
    pub fn out_of_plane(self, vector: Tree) -> Tree {
        Tree::Relation(".", Box::new([Tree::Name(Name::bold("k", "")), vector]))
    }

    /// The unit vector of a direction, with the element whose axis it is: along it or across.
    pub fn direction(self, direction: Direction, element: &Element, along: bool) -> Tree {
        Tree::Name(match direction {
            Direction::X => Name::bold("i", ""),
            Direction::Y => Name::bold("j", ""),
            Direction::Fixed(..) => Name::edge(if along { "u" } else { "n" }, &element.label, true),
        })
    }

    /// The projection of a vector on the unit vector of a direction; on a line there is nothing to project.
    pub fn projected(self, vector: Tree, direction: Direction, element: &Element, along: bool) -> Tree {
        match self.plane {
            true => Tree::Relation(".", Box::new([vector, self.direction(direction, element, along)])),
            false => vector,
        }
    }

    /// A vector by its components; on a line it has one.
    pub fn components(self, components: Vec<Tree>) -> Tree {
        if self.plane { Tree::Call("", components) } else { components.into_iter().next().unwrap_or_else(Tree::zero) }
    }

    pub fn has_two_components(self) -> bool {
        self.plane
    }

    fn vector(self, letter: &str, label: &str) -> Tree {
        Tree::Name(Name::edge(letter, label, self.plane))
    }
}
