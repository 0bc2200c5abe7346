//! Refuses what is too large before it is tried. Long chains and many loops are none of it: what they cost grows with their number. What does grow
//! faster are angles that are sums of many coordinates, and loops that share most of their coordinates with many others.

use crate::diagnostic::{Fault, Span};
use crate::equations::Equations;
use crate::model::{BodyId, Method};
use crate::network::{
    Angle, Direction, ElementId, Known, OutwardNode, System, TNode, Topology, TranslationalRow, Trees,
};

const COORDINATES: usize = 20_000;
/// Most coordinates of a scene that asks for the implicit method, whose matrices are full.
const IMPLICIT: usize = 2_000;
/// Most terms of inertia before they are collected: about 250 bodies whose angles are counted from one to the next.
const TERMS: usize = 5_000_000;
/// Most entries of the matrix of the loop equations.
const ENTRIES: usize = 1_000_000;

/// Is the scene small enough for these trees?
///
/// # Errors
/// It is not.
pub fn check(system: &System, trees: &Trees) -> Result<(), Vec<Fault>> {
    let angles = Angles::new(system, trees);
    let result =
        coordinates(system, trees).and_then(|()| angles.check(system)).and_then(|()| loops(system, trees, &angles));
    result.map_err(|fault| vec![fault])
}

/// Can the mass matrix in branch coordinates be written out? Motion does not need it, but equations on paper and linear systems do.
///
/// # Errors
/// Paths are too deep for it.
pub fn check_written(equations: &Equations) -> Result<(), Vec<Fault>> {
    let mut total = 0;
    for (index, body) in equations.system.mechanism.bodies.iter().enumerate() {
        let size = equations.moving(BodyId(index));
        total += size * size;
        if total > TERMS {
            let message = format!(
                "the position of `{}` depends on {size} coordinates, and so do the positions of many other bodies",
                body.name
            );
            let help = "written-out equations are possible for chains of up to about 250 bodies; `check`, `simulate` and `export` do not write them out";
            return Err(vec![
                too_large(&message, body.span).label("moves with all bodies before it in the chain").help(help),
            ]);
        }
    }
    Ok(())
}

/// The fault of a mechanism whose elimination exceeds the limit.
pub fn too_connected(equations: &Equations) -> Fault {
    let rows = equations.constraints.iter().filter(|row| !row.is_trivial()).count();
    let message =
        format!("too many of its {} coordinates and {rows} loop equations are coupled", equations.coordinates.len());
    too_large(&message, Span::default()).help(
        "very many joints meet at one body, or loops form a dense net: remove some of them, or merge bodies that do not move relative to each other",
    )
}

fn too_large(message: &str, span: Span) -> Fault {
    Fault::new("scene::too_large", format!("the scene is too large: {message}"), span)
}

/// Coordinates that an element brings as a branch of the translational tree.
fn free_directions(system: &System, branch: ElementId) -> usize {
    system.element(branch).translation.as_ref().map_or(0, |row| row.motion.len())
}

/// Does an element bring an angle as a branch of the rotational tree?
fn is_free_angle(system: &System, branch: ElementId) -> bool {
    system.element(branch).rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
}

fn coordinates(system: &System, trees: &Trees) -> Result<(), Fault> {
    let linear: usize = trees.translation.branches.iter().map(|&branch| free_directions(system, branch)).sum();
    let angular = trees.rotation.branches.iter().filter(|&&branch| is_free_angle(system, branch)).count();
    let count = linear + angular;
    let implicit = system.mechanism.solver.method == Method::Implicit;
    if implicit && count > IMPLICIT {
        let message = format!("it has {count} coordinates, but `method = \"implicit\"` supports at most {IMPLICIT}");
        return Err(
            too_large(&message, Span::default()).help("remove `method` from `[solver]`, or set it to \"explicit\"")
        );
    }
    if count > COORDINATES {
        let message = format!("it has {count} coordinates, but at most {COORDINATES} are supported");
        return Err(too_large(&message, Span::default())
            .help("write a separate scene for each part that no joint or driver connects to the others"));
    }
    Ok(())
}

/// How many free angles each body's angle is the sum of.
struct Angles {
    count: Vec<usize>,
}

impl Angles {
    fn new(system: &System, trees: &Trees) -> Self {
        let mut count = vec![0; system.rotation.nodes()];
        for OutwardNode { node, parent, branch, .. } in Topology::new(&system.rotation, &trees.rotation).outward() {
            count[node.index()] = count[parent.index()] + usize::from(is_free_angle(system, branch));
        }
        Angles { count }
    }

    fn of(&self, system: &System, body: Option<BodyId>) -> usize {
        self.count.get(system.r_node(body).index()).copied().unwrap_or(0)
    }

    /// The square of its number of angles for each body: terms of its inertia.
    fn check(&self, system: &System) -> Result<(), Fault> {
        let mut total = 0;
        for (index, body) in system.mechanism.bodies.iter().enumerate() {
            let size = self.of(system, Some(BodyId(index)));
            total += size * size;
            if total > TERMS {
                let message = format!(
                    "the angle of `{}` is the sum of {size} coordinates, and so are the angles of many other bodies",
                    body.name
                );
                return Err(too_large(&message, body.span)
                    .label("turns with all bodies before it in the chain")
                    .help("choose the angles of bodies as coordinates, as `preset = \"recommended\"` does"));
            }
        }
        Ok(())
    }
}

/// Coordinates on the circuits of all chords with a reaction space.
fn loops(system: &System, trees: &Trees, angles: &Angles) -> Result<(), Fault> {
    let nodes = system.translation.nodes();
    let (mut before, mut depth, mut free) = (vec![0; nodes], vec![0_usize; nodes], vec![0_usize; nodes]);
    for OutwardNode { node, parent, branch, .. } in Topology::new(&system.translation, &trees.translation).outward() {
        before[node.index()] = parent.index();
        depth[node.index()] = depth[parent.index()] + 1;
        let turning = system.element(branch).translation.as_ref().map_or(0, |row| angles.of(system, frame(row)));
        free[node.index()] = free_directions(system, branch) + turning;
    }
    let mut total = 0;
    for &chord in &trees.translation.chords {
        let element = system.element(chord);
        let Some(row) = element.translation.as_ref().filter(|row| !row.reaction.is_empty()) else { continue };
        let [mut a, mut b] = row.ends.map(TNode::index);
        let mut circuit = 0;
        while a != b {
            let deeper = if depth[a] >= depth[b] { &mut a } else { &mut b };
            circuit += free[*deeper];
            *deeper = before[*deeper];
        }
        total += row.reaction.len() * circuit;
        if total > ENTRIES {
            let message =
                format!("the loop of `{}` has {circuit} coordinates, and so have many other loops", element.name);
            return Err(too_large(&message, system.span(chord))
                .label("closes a long loop")
                .help("choose coordinates with shorter loops: `preset = \"absolute\"` has the shortest"));
        }
    }
    Ok(())
}

/// The body in which an element's displacement is fixed.
fn frame(row: &TranslationalRow) -> Option<BodyId> {
    match (&row.known, row.motion.first()) {
        (Known::Fixed(body, _) | Known::Along(body, ..), _) => *body,
        (_, Some((Direction::Fixed(body, _), _))) => *body,
        _ => None,
    }
}
