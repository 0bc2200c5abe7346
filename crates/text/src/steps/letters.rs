//! The letters of through and across variables: vectors in the plane, numbers on a line.

use cotree::model::Dimension;
use cotree::network::{Direction, Element};

use crate::name::Name;
use crate::tree::FormulaTree;

/// How the variables of one mechanism are written.
#[derive(Clone, Copy, Debug)]
pub struct Letters {
    plane: bool,
}

impl Letters {
    pub fn new(dimension: Dimension) -> Self {
        Letters { plane: dimension == Dimension::Two }
    }

    pub fn force(self, label: &str) -> FormulaTree {
        self.vector("F", label)
    }

    pub fn torque(self, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge("T", label, false))
    }

    /// `r`; on a line `x`, as in the paper.
    pub fn displacement(self, label: &str) -> FormulaTree {
        self.vector(if self.plane { "r" } else { "x" }, label)
    }

    pub fn velocity(self, label: &str) -> FormulaTree {
        self.vector("v", label)
    }

    pub fn acceleration(self, label: &str) -> FormulaTree {
        self.vector("a", label)
    }

    pub fn angle(self, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge("theta", label, false))
    }

    pub fn omega(self, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge("omega", label, false))
    }

    pub fn alpha(self, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge("alpha", label, false))
    }

    pub fn slide(self, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge("s", label, false))
    }

    /// s' of an edge.
    pub fn rate_of_slide(self, label: &str) -> FormulaTree {
        let name = Name::edge("s", label, false);
        FormulaTree::Name(Name { plain: format!("{}'", name.plain), dots: 1, ..name })
    }

    /// s'' of an edge.
    pub fn acceleration_of_slide(self, label: &str) -> FormulaTree {
        let name = Name::edge("s", label, false);
        FormulaTree::Name(Name { plain: format!("{}''", name.plain), dots: 2, ..name })
    }

    pub fn gravity(self) -> FormulaTree {
        FormulaTree::Name(if self.plane { Name::bold("g", "") } else { Name::letter("g", "") })
    }

    /// k . a: the component of a couple out of the plane.
    pub fn out_of_plane(self, vector: FormulaTree) -> FormulaTree {
        FormulaTree::Relation(".", Box::new([FormulaTree::Name(Name::bold("k", "")), vector]))
    }

    /// The unit vector of a direction, with the element whose axis it is: along it or across.
    pub fn direction(self, direction: Direction, element: &Element, along: bool) -> FormulaTree {
        FormulaTree::Name(match direction {
            Direction::X => Name::bold("i", ""),
            Direction::Y => Name::bold("j", ""),
            Direction::Fixed(..) => Name::edge(if along { "u" } else { "n" }, &element.label, true),
        })
    }

    /// The projection of a vector on the unit vector of a direction; on a line there is nothing to project.
    pub fn projected(self, vector: FormulaTree, direction: Direction, element: &Element, along: bool) -> FormulaTree {
        match self.plane {
            true => FormulaTree::Relation(".", Box::new([vector, self.direction(direction, element, along)])),
            false => vector,
        }
    }

    /// A vector by its components; on a line it has one.
    pub fn components(self, components: Vec<FormulaTree>) -> FormulaTree {
        if self.plane {
            FormulaTree::Call("", components)
        } else {
            components.into_iter().next().unwrap_or_else(FormulaTree::zero)
        }
    }

    pub fn has_two_components(self) -> bool {
        self.plane
    }

    fn vector(self, letter: &str, label: &str) -> FormulaTree {
        FormulaTree::Name(Name::edge(letter, label, self.plane))
    }
}
