//! Bodies that hang from each other: the masses between arms as a tree, which grows with the number of arms where the masses of every two of them would
//! grow with its square.
//!
//! Where every path from the ground passes an arm at most once, and every arm begins at one place of one other, the arms are links of a tree. With z the place
//! along an arm where the next one begins, m the first moment (along its own arm) of all that a link carries, the masses between an arm k and an arm l
//! further out are conj(z) m, whatever lies between.

use std::collections::{HashMap, HashSet};

use super::linear::conjugate_product;
use super::{Arm, ArmEquations, ArmFactor, Equations, NoSeries};
use crate::equations::inertias::mass;
use crate::equations::vector::FrameId;
use crate::expr::{Arena, Expr};
use crate::model::{BodyId, Place};

/// With fewer masses between arms than this for each link, they cost less one by one.
const FEW: usize = 12;

/// An arm, and all that hangs from it.
#[derive(Clone, Debug)]
pub struct ArmLink {
    pub arm: Arm,
    /// The place of the link that it hangs from, which comes before it.
    pub parent: Option<usize>,
    /// Where it begins along the arm of that link.
    pub begin: [Expr; 2],
    pub carried: Carried,
    /// The same of what has weight.
    pub heavy: Carried,
}

/// Masses along an arm.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    pub mass: Expr,
    /// First and second moment.
    pub moment: [Expr; 2],
    pub inertia: Expr,
}

impl Default for Carried {
    fn default() -> Self {
        Carried { mass: Expr::ZERO, moment: [Expr::ZERO; 2], inertia: Expr::ZERO }
    }
}

impl Carried {
    /// Adds a mass at a place along the arm.
    fn add(&mut self, arena: &mut Arena, mass: Expr, at: [Expr; 2]) {
        let moment = at.map(|part| arena.multiply(mass, part));
        let [square, _] = conjugate_product(arena, at, moment);
        self.mass = arena.add(self.mass, mass);
        self.moment = [0, 1].map(|axis| arena.add(self.moment[axis], moment[axis]));
        self.inertia = arena.add(self.inertia, square);
    }
}

/// Where a point lies: along the arm of a link.
#[derive(Clone, Copy, Debug)]
struct Seat {
    link: Option<usize>,
    at: [Expr; 2],
}

/// Links by their arms.
#[derive(Debug, Default)]
struct ArmTree {
    links: Vec<ArmLink>,
    places: HashMap<Arm, usize>,
}

impl ArmTree {
    /// The seat after another part of a path; none if the arm is elsewhere already.
    fn enter(&mut self, arena: &mut Arena, seat: Seat, arm: Arm, z: [Expr; 2]) -> Option<Seat> {
        if seat.link.is_some_and(|link| self.links[link].arm == arm) {
            return Some(Seat { at: [0, 1].map(|axis| arena.add(seat.at[axis], z[axis])), ..seat });
        }
        let link = match self.places.get(&arm) {
            Some(&link) => {
                let known = &self.links[link];
                (known.parent == seat.link && (seat.link.is_none() || known.begin == seat.at)).then_some(link)?
            }
            None => {
                self.places.insert(arm, self.links.len());
                let (parent, empty) = (seat.link, Carried::default());
                self.links.push(ArmLink { arm, parent, begin: seat.at, carried: empty, heavy: empty });
                self.links.len() - 1
            }
        };
        Some(Seat { link: Some(link), at: z })
    }

    /// What a link carries is carried by the one that it hangs from.
    fn sum(&mut self, arena: &mut Arena) {
        for link in (0..self.links.len()).rev() {
            let ArmLink { parent, begin, carried, heavy, .. } = self.links[link];
            if let Some(parent) = parent.and_then(|parent| self.links.get_mut(parent)) {
                parent.carried.add(arena, carried.mass, begin);
                parent.heavy.add(arena, heavy.mass, begin);
            }
        }
    }

    /// Is it deep, is every arm a frame of constant length or moves along a line of the world, and is there a link for each displacement?
    fn serves(&self, displacements: usize) -> bool {
        let simple = |arm: &Arm| match arm.factor {
            ArmFactor::One => arm.frame != FrameId::WORLD,
            ArmFactor::Displacement(_) | ArmFactor::Signal(_) => arm.frame == FrameId::WORLD,
        };
        let moved = self.links.iter().filter(|link| matches!(link.arm.factor, ArmFactor::Displacement(_))).count();
        self.is_deep() && self.links.iter().all(|link| simple(&link.arm)) && moved == displacements
    }

    /// Are there many masses between arms for each link?
    fn is_deep(&self) -> bool {
        let mut depths: Vec<usize> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            depths.push(link.parent.map_or(0, |parent| depths[parent] + 1));
        }
        2 * depths.iter().sum::<usize>() >= FEW * self.links.len()
    }

    /// Links in an order in which the first that hangs from another one follows it.
    fn in_rows(self) -> Vec<ArmLink> {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); self.links.len()];
        let mut next: Vec<usize> = Vec::new();
        for (index, link) in self.links.iter().enumerate().rev() {
            match link.parent {
                Some(parent) => children[parent].push(index),
                None => next.push(index),
            }
        }
        let (mut sorted, mut places) = (Vec::with_capacity(self.links.len()), vec![None; self.links.len()]);
        while let Some(index) = next.pop() {
            places[index] = Some(sorted.len());
            next.append(&mut children[index]);
            let link = &self.links[index];
            sorted.push(ArmLink { parent: link.parent.and_then(|parent| places[parent]), ..link.clone() });
        }
        sorted
    }
}

impl Equations {
    /// Finds the tree, if there is one and it has many links; then takes the inertias over and puts the frames into its order.
    pub(super) fn tree(&mut self, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let displacements = self.coordinates.iter().filter(|coordinate| !coordinate.angular).count();
        if arms.frames.len() + displacements <= FEW {
            return Ok(());
        }
        let tree_frames: HashSet<Vec<usize>> =
            arms.frames.iter().map(|turning| turning.coordinates.keys().copied().collect()).collect();
        let driven = arms.frames.iter().filter(|turning| turning.coordinates.is_empty()).count();
        if tree_frames.len() + driven.saturating_sub(1) != arms.frames.len() {
            return Ok(());
        }
        let mut tree = ArmTree::default();
        let Some(seats) = self.seats(&mut tree)? else { return Ok(()) };
        self.seat_masses(&mut tree, &seats);
        tree.sum(&mut self.system.arena);
        if !tree.serves(displacements) {
            return Ok(());
        }
        self.inertias(arms);
        let mut links = tree.in_rows();
        let places: HashMap<Arm, usize> = links.iter().enumerate().map(|(place, link)| (link.arm, place)).collect();
        let place = |frame: FrameId| places.get(&Arm::of(frame)).copied();
        arms.frames.sort_by_key(|turning| place(turning.frame).unwrap_or(usize::MAX));
        for turning in &mut arms.frames {
            match place(turning.frame) {
                Some(place) => {
                    turning.inertia = self.system.arena.add(turning.inertia, links[place].carried.inertia);
                }
                // It turns about its own centre, and nothing hangs from it.
                None => links.push(ArmLink {
                    arm: Arm::of(turning.frame),
                    parent: None,
                    begin: [Expr::ZERO; 2],
                    carried: Carried::default(),
                    heavy: Carried::default(),
                }),
            }
        }
        arms.links = links;
        Ok(())
    }

    /// Where each node of the translational graph lies; none if the arms are no tree.
    fn seats(&mut self, tree: &mut ArmTree) -> Result<Option<Vec<Seat>>, NoSeries> {
        let nodes: Vec<_> =
            self.kinematics.outward().map(|(node, before, vector)| (node, before, vector.clone())).collect();
        let mut seats = vec![Seat { link: None, at: [Expr::ZERO; 2] }; self.system.translation.nodes()];
        for (node, before, vector) in nodes {
            let mut seat = seats[before];
            for (arm, z) in self.decompose(&vector)? {
                if arm.is_constant() {
                    continue;
                }
                let Some(next) = tree.enter(&mut self.system.arena, seat, arm, z) else { return Ok(None) };
                seat = next;
            }
            seats[node] = seat;
        }
        Ok(Some(seats))
    }

    fn seat_masses(&mut self, tree: &mut ArmTree, seats: &[Seat]) {
        for body in (0..self.system.mechanism.bodies.len()).map(BodyId) {
            let centre = self.system.t_node(Place::Centre(body)).index();
            let Seat { link: Some(link), at } = seats[centre] else { continue };
            let mass = mass(&mut self.system, body);
            let arena = &mut self.system.arena;
            tree.links[link].carried.add(arena, mass, at);
            if !self.system.mechanism.bodies[body.0].weightless {
                tree.links[link].heavy.add(arena, mass, at);
            }
        }
    }
}
