//! Choice of the spanning trees, and with them of the branch coordinates.
//!
//! Must: each tree spans its graph without a loop; every rigid arm and ground vector is a branch; the user's choice is obeyed.
//! Desirable: the fewest coordinates (Tables 2 and 3 are Kruskal's algorithm with the number of coordinates as weight, so none has
//! fewer), and among those loops that are cut in their middle: revolutes are taken breadth first from the ground.

use std::collections::{HashMap, HashSet, VecDeque};

use super::element::Origin;
use super::graph::{ElementId, LinearGraph, Rotation, Translation, Tree};
use super::system::System;
use crate::diagnostic::{Fault, Span, suggest};
use crate::model::{BodyId, CoordinateChoice};

/// A spanning tree of each graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trees {
    /// Of the points.
    pub translation: Tree<Translation>,
    /// Of the bodies.
    pub rotation: Tree<Rotation>,
}

impl Trees {
    /// Those of Tables 2 and 3.
    pub fn recommended(system: &System) -> Trees {
        Trees::recommended_but(system, |_| false)
    }

    /// The same with some edges as chords, as far as others span the graphs.
    pub fn recommended_but(system: &System, chord: impl Fn(ElementId) -> bool) -> Trees {
        let (mut t_order, mut r_order) = Trees::order(system);
        let last = |id: ElementId| (system.element(id).closed.is_some(), chord(id));
        t_order.sort_by_key(|&id| last(id));
        r_order.sort_by_key(|&id| last(id));
        Trees { translation: system.translation.tree(t_order), rotation: system.rotation.tree(r_order) }
    }

    /// The orders in which Tables 2 and 3 take the edges of the translational and of the rotational graph.
    pub fn order(system: &System) -> (Vec<ElementId>, Vec<ElementId>) {
        let depth = depths(system);
        let key = |id: &ElementId| match system.element(*id).origin {
            Origin::Joint(joint) => depth[joint.0],
            _ => 0,
        };
        let t_order = ordered(system, &system.translation, |id| {
            (system.element(*id).translation.as_ref().map_or(u8::MAX, |row| row.priority), key(id))
        });
        let r_order = ordered(system, &system.rotation, |id| {
            system.element(*id).rotation.as_ref().map_or(u8::MAX, |row| row.priority)
        });
        (t_order, r_order)
    }

    /// The trees that the scene asks for.
    ///
    /// # Errors
    /// The user's own lists name something unknown, close a loop, or leave something out.
    pub fn select(system: &System, choice: &CoordinateChoice) -> Result<Trees, Vec<Fault>> {
        match choice {
            CoordinateChoice::Recommended => Ok(Trees::recommended(system)),
            CoordinateChoice::Absolute => Ok(absolute(system)),
            CoordinateChoice::Joint => Ok(joint(system)),
            CoordinateChoice::Chosen { translation, rotation } => {
                chosen(system, translation.as_deref(), rotation.as_deref())
            }
        }
    }

    /// These trees with some bodies as branches of the translational tree in the place of joints, as far as arms and position
    /// drivers permit.
    pub fn with_bodies(&self, system: &System, chosen: impl Fn(BodyId) -> bool) -> Trees {
        let branches: HashSet<ElementId> = self.translation.branches.iter().copied().collect();
        let order = ordered(system, &system.translation, |id| match system.element(*id).origin {
            Origin::Arm(..) | Origin::GroundVector(_) => 0,
            Origin::Driver(_) if branches.contains(id) => 1,
            Origin::Body(body) if chosen(body) => 2,
            _ if branches.contains(id) => 3,
            _ => 4,
        });
        Trees { translation: system.translation.tree(order), rotation: self.rotation.clone() }
    }
}

/// All bodies in both trees.
fn absolute(system: &System) -> Trees {
    let rank = |id: &ElementId| match system.element(*id).origin {
        Origin::Arm(..) | Origin::GroundVector(_) => 0,
        Origin::Body(_) => 1,
        _ => 2,
    };
    by_rank(system, rank)
}

/// One joint after another in both trees, welds and revolutes and slides alike breadth first from the ground, until they span; what no joint
/// reaches moves by its body.
fn joint(system: &System) -> Trees {
    let depth = depths(system);
    let rank = |id: &ElementId| match system.element(*id).origin {
        Origin::Arm(..) | Origin::GroundVector(_) => (0, 0),
        Origin::Joint(joint) => (1, depth[joint.0]),
        Origin::Body(_) => (2, 0),
        Origin::Driver(_) | Origin::Load(_) | Origin::Implied(_) | Origin::Contact(_) | Origin::SetRate(_) => (3, 0),
    };
    by_rank(system, rank)
}

fn by_rank<K: Ord>(system: &System, rank: impl Fn(&ElementId) -> K + Copy) -> Trees {
    Trees {
        translation: system.translation.tree(ordered(system, &system.translation, rank)),
        rotation: system.rotation.tree(ordered(system, &system.rotation, rank)),
    }
}

/// The edges of a graph by rank; what does not always hold comes last, so that it is a chord.
fn ordered<D, K: Ord>(system: &System, graph: &LinearGraph<D>, rank: impl Fn(&ElementId) -> K) -> Vec<ElementId> {
    let mut order: Vec<ElementId> = graph.edges().map(|(element, _)| element).collect();
    order.sort_by_key(|id| (system.element(*id).closed.is_some(), rank(id)));
    order
}

/// How far each joint is from the ground, counted in joints; joints of what is not connected to the ground come last.
fn depths(system: &System) -> Vec<usize> {
    let mechanism = &system.mechanism;
    let body_of = |joint: usize, side: usize| mechanism.joints[joint].between[side].body();
    let mut at: HashMap<_, Vec<usize>> = HashMap::new();
    // What only couples is no way from body to body.
    let joins = system.elements.iter().filter(|element| element.translation.is_some());
    for joint in
        joins.filter_map(|element| if let Origin::Joint(joint) = element.origin { Some(joint.0) } else { None })
    {
        at.entry(body_of(joint, 0)).or_default().push(joint);
        at.entry(body_of(joint, 1)).or_default().push(joint);
    }
    let mut depths = vec![usize::MAX; mechanism.joints.len()];
    let mut reached = HashMap::from([(None, 0)]);
    let mut queue = VecDeque::from([None]);
    while let Some(body) = queue.pop_front() {
        let depth = reached[&body];
        for &joint in at.get(&body).into_iter().flatten() {
            depths[joint] = depths[joint].min(depth);
            for side in [0, 1] {
                let next = body_of(joint, side);
                reached.entry(next).or_insert_with(|| {
                    queue.push_back(next);
                    depth + 1
                });
            }
        }
    }
    depths
}

type Names<'a> = Option<&'a [(String, Span)]>;

/// The user's own trees; a list that is not given is the recommended one.
fn chosen(system: &System, translation: Names, rotation: Names) -> Result<Trees, Vec<Fault>> {
    let default = Trees::recommended(system);
    let mut faults = Vec::new();
    let mut obey = |result: Result<Vec<ElementId>, Vec<Fault>>| result.map_err(|found| faults.extend(found)).ok();
    let t_branches = translation.map_or(Some(default.translation.branches), |names| {
        obey(branches(system, &system.translation, names, "translation"))
    });
    let r_branches = rotation
        .map_or(Some(default.rotation.branches), |names| obey(branches(system, &system.rotation, names, "rotation")));
    match (t_branches, r_branches) {
        (Some(t), Some(r)) => {
            Ok(Trees { translation: system.translation.tree_of(t), rotation: system.rotation.tree_of(r) })
        }
        _ => Err(faults),
    }
}

/// The named elements of one graph behind its arms and ground vectors, if they form a spanning tree.
fn branches<D>(
    system: &System,
    graph: &LinearGraph<D>,
    names: &[(String, Span)],
    list: &'static str,
) -> Result<Vec<ElementId>, Vec<Fault>> {
    let mut faults = Vec::new();
    let mut branches: Vec<ElementId> = graph.edges().map(|(id, _)| id).filter(|&id| is_arm(system, id)).collect();
    for (name, span) in names {
        match graph.edges().map(|(id, _)| id).find(|&id| !is_arm(system, id) && system.element(id).name == *name) {
            None => faults.push(not_in_graph(system, name, *span, list)),
            Some(id) if system.element(id).closed.is_some() => faults.push(not_always(name, *span, list)),
            Some(id) => match closes_loop(system, graph, &branches, id) {
                Some(others) => faults.push(loop_fault(name, *span, list, &others)),
                None => branches.push(id),
            },
        }
    }
    let unreached = graph.unreached(&branches);
    if faults.is_empty() && !unreached.is_empty() {
        let span = names.first().map_or_else(Span::default, |(_, span)| *span);
        let missing = suggest::list(&unreached);
        faults.push(
            Fault::new("coordinates::not_spanning", format!("the {list} tree does not connect {missing}"), span)
                .label("these branches do not span the graph")
                .help(format!("add a body, joint, driver or load that connects {missing} to the rest")),
        );
    }
    if faults.is_empty() { Ok(branches) } else { Err(faults) }
}

fn is_arm(system: &System, id: ElementId) -> bool {
    matches!(system.element(id).origin, Origin::Arm(..) | Origin::GroundVector(_))
}

fn not_in_graph(system: &System, name: &str, span: Span, list: &str) -> Fault {
    let known = system.elements.iter().any(|element| element.name == name);
    let message = if known {
        format!("`{name}` cannot be a branch of the {list} tree")
    } else {
        format!("the {list} tree names `{name}`, which is not in the scene")
    };
    let help = match (known, list) {
        (true, "rotation") => {
            "the rotational tree is made of bodies, joints, angle drivers and torque loads; gears, racks and distance links are in no tree"
        }
        (true, _) => {
            "the translational tree is made of bodies, joints, position drivers and force loads; rigid arms are always in it; gears, racks and distance links are in no tree"
        }
        (false, _) => "name a body, joint, driver or load of the scene",
    };
    let label = match (known, list) {
        (true, "rotation") => "has no angle and no torque",
        (true, _) => "has no displacement and no force",
        (false, _) => "not in the scene",
    };
    Fault::new("coordinates::unknown_branch", message, span).label(label).help(help)
}

fn not_always(name: &str, span: Span, list: &str) -> Fault {
    let message = format!("`{name}` cannot be a branch of the {list} tree: an event removes it");
    Fault::new("coordinates::unknown_branch", message, span)
        .label("may be removed during the run")
        .help("choose a branch that is not removed, such as the body itself")
}

fn loop_fault(name: &str, span: Span, list: &str, others: &[String]) -> Fault {
    let message = if others.is_empty() {
        format!("`{name}` closes a loop of the {list} tree by itself")
    } else {
        format!("`{name}` closes a loop with {}", suggest::list(others))
    };
    Fault::new("coordinates::loop", message, span)
        .label("the tree already connects both ends")
        .help(format!("leave `{name}` or one of the others out of `{list}`"))
}

/// The named elements with which a further branch would form a loop, if it would.
fn closes_loop<D>(
    system: &System,
    graph: &LinearGraph<D>,
    branches: &[ElementId],
    id: ElementId,
) -> Option<Vec<String>> {
    let with: Vec<ElementId> = branches.iter().copied().chain([id]).collect();
    if graph.tree(with).branches.len() == branches.len() + 1 {
        return None;
    }
    // Whatever can be left out without opening the loop is not in it.
    let mut circle = branches.to_vec();
    let mut index = 0;
    while index < circle.len() {
        let mut fewer = circle.clone();
        fewer.remove(index);
        let closed = graph.tree(fewer.iter().copied().chain([id])).branches.len() == fewer.len();
        if closed {
            circle = fewer;
        } else {
            index += 1;
        }
    }
    Some(
        circle
            .into_iter()
            .filter(|&other| !is_arm(system, other))
            .map(|other| system.element(other).name.clone())
            .collect(),
    )
}
