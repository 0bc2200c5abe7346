//! Refuses what is too large before it is tried: expressions multiply with the coordinates that move one body, and matrices with those that one
//! island of joints connects.

use std::collections::HashMap;

use petgraph::unionfind::UnionFind;

use crate::element::{Angle, Direction, Known, Origin, System, TranslationalRow};
use crate::graph::{ElementId, Topology};
use crate::mechanism::BodyId;
use crate::scene::{Fault, Span};
use crate::tree::Trees;

/// Most coordinates of a scene.
const COORDINATES: usize = 20_000;
/// Most terms of the mass matrix before they are collected: about 250 bodies in one chain, a minute and a gigabyte.
const TERMS: usize = 5_000_000_000_000;
/// Most operations, up to a factor, to solve for all coordinates of one island at once.
const OPERATIONS: f64 = 5e28;

/// Is the scene small enough for these trees?
///
/// # Errors
/// It is not.
pub fn check(system: &System, trees: &Trees) -> Result<(), Vec<Fault>> {
    let result = coordinates(system, trees).and_then(|()| terms(system, trees)).and_then(|()| loops(system, trees));
    result.map_err(|fault| vec![fault.with_code()])
}

/// What a refusal says.
struct TooLarge {
    message: String,
    span: Span,
    label: &'static str,
    help: &'static str,
}

impl TooLarge {
    fn with_code(self) -> Fault {
        let message = format!("the scene is too large: {}", self.message);
        Fault::new("scene::too_large", message, self.span).label(self.label).help(self.help)
    }
}

/// Coordinates that an element brings as a branch of the translational tree.
fn free_directions(system: &System, branch: ElementId) -> usize {
    system.element(branch).translation.as_ref().map_or(0, |row| row.motion.len())
}

/// Does an element bring an angle as a branch of the rotational tree?
fn is_free_angle(system: &System, branch: ElementId) -> bool {
    system.element(branch).rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
}

fn coordinates(system: &System, trees: &Trees) -> Result<(), TooLarge> {
    let linear: usize = trees.translation.branches.iter().map(|&branch| free_directions(system, branch)).sum();
    let angular = trees.rotation.branches.iter().filter(|&&branch| is_free_angle(system, branch)).count();
    let count = linear + angular;
    if count <= COORDINATES {
        return Ok(());
    }
    Err(TooLarge {
        message: format!("it has {count} coordinates, and at most {COORDINATES} are possible"),
        span: Span::default(),
        label: "",
        help: "make a scene of each part that no joint or driver connects to the others: they move on their own",
    })
}

/// Sum over all bodies of the square of the number of coordinates that move it.
fn terms(system: &System, trees: &Trees) -> Result<(), TooLarge> {
    let topology = Topology::new(&system.translation, &trees.translation);
    let mut children: Vec<Vec<(usize, ElementId)>> = vec![Vec::new(); system.translation.nodes()];
    for (node, parent, branch, _) in topology.outward() {
        children[parent.index()].push((node.index(), branch));
    }
    let centres: HashMap<usize, BodyId> = system
        .elements
        .iter()
        .filter_map(|element| match (element.origin, &element.translation) {
            (Origin::Body(body), Some(row)) => Some((row.ends[1].index(), body)),
            _ => None,
        })
        .collect();
    let angles = Angles::new(system, trees);
    let mut moving = Moving::default();
    let mut total = 0;
    let mut walk: Vec<Step> = children[0].iter().map(|&(node, branch)| Step::Enter(node, branch)).collect();
    while let Some(step) = walk.pop() {
        let (node, branch) = match step {
            Step::Enter(node, branch) => (node, branch),
            Step::Leave(branch) => {
                moving.leave(&angles.of_branch(system, branch));
                continue;
            }
        };
        moving.enter(&angles.of_branch(system, branch));
        walk.push(Step::Leave(branch));
        walk.extend(children[node].iter().map(|&(child, branch)| Step::Enter(child, branch)));
        if let Some(&body) = centres.get(&node) {
            total += moving.0.len().pow(2);
            if total > TERMS {
                return Err(too_deep(system, body, moving.0.len()));
            }
        }
    }
    Ok(())
}

fn too_deep(system: &System, body: BodyId, count: usize) -> TooLarge {
    let body = &system.mechanism.bodies[body.0];
    TooLarge {
        message: format!("the place of `{}` depends on {count} coordinates, and so does that of many more", body.name),
        span: body.span,
        label: "very many joints lead from the ground to here",
        help: "about 250 bodies in one chain are possible: join fewer in a row, or make one body of those that need not move",
    }
}

/// A step of the walk through the translational tree.
enum Step {
    Enter(usize, ElementId),
    Leave(ElementId),
}

/// A coordinate: of a branch of the translational tree (direction), or of the rotational one (`None`).
type Key = (ElementId, Option<usize>);

/// The coordinates that move the place of the walk, and how many branches on its path depend on each.
#[derive(Default)]
struct Moving(HashMap<Key, usize>);

impl Moving {
    fn enter(&mut self, keys: &[Key]) {
        for key in keys {
            *self.0.entry(*key).or_default() += 1;
        }
    }

    fn leave(&mut self, keys: &[Key]) {
        for key in keys {
            if let Some(count) = self.0.get_mut(key) {
                *count -= 1;
                if *count == 0 {
                    self.0.remove(key);
                }
            }
        }
    }
}

/// The free angles between each body and the ground.
struct Angles {
    /// For each node of the rotational graph: the node before it, and the branch between if its angle is free.
    before: Vec<Option<(usize, Option<ElementId>)>>,
}

impl Angles {
    fn new(system: &System, trees: &Trees) -> Self {
        let mut before = vec![None; system.rotation.nodes()];
        for (node, parent, branch, _) in Topology::new(&system.rotation, &trees.rotation).outward() {
            before[node.index()] = Some((parent.index(), is_free_angle(system, branch).then_some(branch)));
        }
        Angles { before }
    }

    /// The coordinates that a branch of the translational tree depends on.
    fn of_branch(&self, system: &System, branch: ElementId) -> Vec<Key> {
        let Some(row) = &system.element(branch).translation else { return Vec::new() };
        let mut keys: Vec<Key> = (0..row.motion.len()).map(|direction| (branch, Some(direction))).collect();
        let mut node = system.r_node(frame(row)).index();
        while let Some((parent, free)) = self.before.get(node).copied().flatten() {
            keys.extend(free.map(|branch| (branch, None)));
            node = parent;
        }
        keys
    }
}

/// The body in which an element's displacement is fixed.
fn frame(row: &TranslationalRow) -> Option<BodyId> {
    match (&row.known, row.motion.first()) {
        (Known::Fixed(body, _) | Known::Along(body, ..), _) => *body,
        (_, Some((Direction::Fixed(body, _), _))) => *body,
        _ => None,
    }
}

/// c m (c + m) over the islands of bodies, each with its c coordinates and m loop equations.
fn loops(system: &System, trees: &Trees) -> Result<(), TooLarge> {
    let islands = Islands::new(system, trees);
    let mut sizes: HashMap<usize, [usize; 2]> = HashMap::new();
    let mut count = |id: ElementId, kind: usize, number: usize| {
        if let Some(island) = islands.of(system, id) {
            sizes.entry(island).or_default()[kind] += number;
        }
    };
    let held = |id: ElementId| system.element(id).translation.as_ref().map_or(0, |row| row.reaction.len());
    trees.translation.branches.iter().for_each(|&id| count(id, 0, free_directions(system, id)));
    trees.rotation.branches.iter().for_each(|&id| count(id, 0, usize::from(is_free_angle(system, id))));
    trees.translation.chords.iter().for_each(|&id| count(id, 1, held(id)));
    trees.rotation.chords.iter().for_each(|&id| count(id, 1, usize::from(!is_free_angle(system, id))));
    let operations = |[c, m]: [usize; 2]| c as f64 * m as f64 * (c + m) as f64;
    let largest = sizes.into_iter().max_by(|a, b| operations(a.1).total_cmp(&operations(b.1)));
    match largest {
        Some((island, size)) if operations(size) > OPERATIONS => Err(too_connected(system, island, size)),
        _ => Ok(()),
    }
}

fn too_connected(system: &System, island: usize, [coordinates, equations]: [usize; 2]) -> TooLarge {
    let body = &system.mechanism.bodies[island];
    TooLarge {
        message: format!(
            "joints connect `{}` and others to one whole of {coordinates} coordinates and {equations} loop equations",
            body.name
        ),
        span: body.span,
        label: "one of these bodies",
        help: "about 250 bodies in one whole are possible: join fewer, make one body of those that need not move, or choose coordinates \
               with fewer loop equations (the recommended ones have the fewest)",
    }
}

/// Bodies that joints, drivers and branches connect other than through the ground.
struct Islands {
    classes: UnionFind<usize>,
    /// The body of each node of the translational graph.
    owner: HashMap<usize, usize>,
    /// The body of each node of the rotational graph.
    turning: HashMap<usize, usize>,
}

impl Islands {
    fn new(system: &System, trees: &Trees) -> Self {
        let classes = UnionFind::new(system.mechanism.bodies.len());
        let mut islands = Islands { classes, owner: HashMap::new(), turning: HashMap::new() };
        for element in &system.elements {
            if let (Origin::Body(body) | Origin::Arm(body, _), Some(row)) = (element.origin, &element.translation) {
                islands.owner.insert(row.ends[1].index(), body.0);
            }
            if let (Origin::Body(body), Some(row)) = (element.origin, &element.rotation) {
                islands.turning.insert(row.ends[1].index(), body.0);
            }
        }
        let branches = trees.translation.branches.iter().chain(&trees.rotation.branches);
        let holding = (0..system.elements.len()).map(ElementId).filter(|&id| holds(system, id));
        for id in branches.copied().chain(holding) {
            if let [Some(a), Some(b)] = islands.bodies(system, id) {
                islands.classes.union(a, b);
            }
        }
        islands
    }

    /// The bodies at both ends of an element, where they are not the ground.
    fn bodies(&self, system: &System, id: ElementId) -> [Option<usize>; 2] {
        let element = system.element(id);
        match (&element.translation, &element.rotation) {
            (Some(row), _) => row.ends.map(|node| self.owner.get(&node.index()).copied()),
            (None, Some(row)) => row.ends.map(|node| self.turning.get(&node.index()).copied()),
            (None, None) => [None; 2],
        }
    }

    fn of(&self, system: &System, id: ElementId) -> Option<usize> {
        self.bodies(system, id).into_iter().flatten().next().map(|body| self.classes.find(body))
    }
}

/// Does an element hold something, so that it brings a loop equation as a chord?
fn holds(system: &System, id: ElementId) -> bool {
    let element = system.element(id);
    let linear = element.translation.as_ref().is_some_and(|row| !row.reaction.is_empty());
    linear || element.rotation.as_ref().is_some_and(|row| !matches!(row.angle, Angle::Free(_)))
}
