//! Accelerations of mass centres in the coordinates, and which bodies a coordinate moves.

use cotree::expr::Expr;
use cotree::model::{BodyId, Owner, Place, Quantity, Variable};
use cotree::network::{ElementId, Origin};

use super::graphs::{list, shortened};
use super::numbers::agree;
use super::{Lesson, check, with, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::FormulaTree;

/// So many bodies are written out.
const BODIES: usize = 8;
/// So many coordinates are read.
const COORDINATES: usize = 8;

impl Lesson<'_> {
    /// The accelerations of section 8 (b) as components, of the bodies whose mass centres are no coordinates.
    pub fn components(&mut self) -> Vec<DocumentBlock> {
        let (mut bodies, chords) = (self.bodies(), &self.equations.trees.translation.chords);
        bodies.retain(|(id, ..)| chords.contains(id));
        if bodies.is_empty() || bodies.len() > BODIES {
            return Vec::new();
        }
        let (mut positions, mut accelerations) = (Vec::new(), Vec::new());
        for (.., body) in &bodies {
            for (position, acceleration) in [(Quantity::X, Quantity::Ax), (Quantity::Y, Quantity::Ay)] {
                let mut of = |quantity| {
                    self.equations.variable(Variable { owner: Owner::Place(Place::Centre(*body)), quantity })
                };
                positions.push(of(position));
                accelerations.push(of(acceleration));
            }
        }
        let arena = &mut self.equations.system.arena;
        let rates: Vec<Expr> = positions.into_iter().map(|position| arena.time_derivative(position)).collect();
        let twice: Vec<Expr> = rates.into_iter().map(|rate| arena.time_derivative(rate)).collect();
        let mut values = self.moving();
        values.accelerations = values.rates.iter().map(|rate| 0.4 * rate - 1.1).collect();
        let holds = agree(&values.of(&self.equations, &accelerations), &values.of(&self.equations, &twice));
        let (formulas, new) = self.formulas(&accelerations);
        let mut formulas = formulas.into_iter();
        let mut rows = Vec::new();
        for (_, label, _) in &bodies {
            let components: Vec<FormulaTree> = formulas.by_ref().take(2).collect();
            rows.push((self.letters.acceleration(label), self.letters.components(components)));
        }
        let mut blocks = vec![words("With the rates of the arms put in, in the axes of the ground:")];
        blocks.extend(list(rows));
        blocks.extend(with(new));
        blocks.push(check("they are the second derivatives of the positions by time", holds));
        blocks
    }

    /// Whose inertia the entries of M are.
    pub fn reading(&mut self) -> Vec<DocumentBlock> {
        let count = self.equations.coordinates.len();
        let bodies = self.bodies();
        if count > COORDINATES {
            return Vec::new();
        }
        let moved: Vec<Vec<usize>> = bodies.iter().map(|(.., body)| self.equations.moved_by(*body)).collect();
        let mut pieces = vec![Piece::words(
            "Reading: an entry of M is the inertia of the bodies that both of its coordinates move. ",
        )];
        for column in 0..count {
            let moving =
                bodies.iter().zip(&moved).filter(|(_, moved)| moved.contains(&column)).map(|((_, _, body), _)| *body);
            let mechanism = &self.equations.system.mechanism;
            let names: Vec<&str> = moving.map(|body| mechanism.bodies[body.0].name.as_str()).collect();
            let name = FormulaTree::Name(Name::symbol(&self.equations.coordinates[column].name.position));
            pieces.push(Piece::Math(name));
            pieces.push(Piece::words(format!(
                " moves {}{}",
                shortened(&names),
                if column + 1 < count { "; " } else { "." }
            )));
        }
        let apart =
            |row: usize, column: usize| !moved.iter().any(|moved| moved.contains(&row) && moved.contains(&column));
        let mass = self.equations.dynamics().mass.clone();
        let entries = mass
            .iter()
            .enumerate()
            .flat_map(|(row, entries)| entries.iter().map(move |(column, entry)| (row, *column, *entry)));
        let foreign: Vec<Expr> =
            entries.filter(|(row, column, _)| apart(*row, *column)).map(|(.., entry)| entry).collect();
        let zero = agree(&self.moving().of(&self.equations, &foreign), &vec![0.0; foreign.len()]);
        vec![DocumentBlock::Text(pieces), check("where there is no such body M has no entry", zero)]
    }

    /// The bodies with their edges and labels.
    fn bodies(&self) -> Vec<(ElementId, String, BodyId)> {
        let elements = self.equations.system.elements.iter().enumerate();
        let bodies = elements.filter_map(|(index, element)| match element.origin {
            Origin::Body(body) => Some((ElementId(index), element.label.clone(), body)),
            _ => None,
        });
        bodies.collect()
    }
}
