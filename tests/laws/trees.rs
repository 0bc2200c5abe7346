//! Random spanning trees.

use cotree::model::{CoordinateChoice, Mechanism};
use cotree::network::{ElementId, LinearGraph, Origin, System};
use cotree::scene::Span;

use nalgebra::DMatrix;

use crate::support::random::{Case, Family, Random, random_case};
use crate::support::scene_text::scene_text;
use crate::support::variables::variables;

/// Any valid tree pair: bodies, joints, drivers and loads in random order behind the arms, which must be branches.
pub fn random_trees(mechanism: &Mechanism, random: &mut Random) -> CoordinateChoice {
    let system = System::new(mechanism);
    let translation = random_tree(&system, &system.translation, random);
    let rotation = random_tree(&system, &system.rotation, random);
    CoordinateChoice::Chosen { translation: Some(translation), rotation: Some(rotation) }
}

fn random_tree<D>(system: &System, graph: &LinearGraph<D>, random: &mut Random) -> Vec<(String, Span)> {
    let is_arm = |id: &ElementId| matches!(system.element(*id).origin, Origin::Arm(..) | Origin::GroundVector(_));
    let mut order: Vec<ElementId> = graph.edges().map(|(id, _)| id).collect();
    for last in (1..order.len()).rev() {
        order.swap(last, random.below(last + 1));
    }
    order.sort_by_key(|id| !is_arm(id));
    let branches = graph.tree(order).branches.into_iter().filter(|id| !is_arm(id));
    branches.map(|id| (system.element(id).name.clone(), Span::default())).collect()
}

/// A random mechanism in which about every third body has no inertia and some no mass either, and whose motion the others determine.
pub fn light_case(seed: u64, family: Family) -> Case {
    let mut random = Random(seed ^ 0x6c69_6768);
    loop {
        let mut case = random_case(random.below(1 << 30) as u64, family);
        for body in &mut case.system.bodies {
            if random.chance(0.35) {
                body.inertia = 0.0;
                if random.chance(0.5) {
                    body.mass = 0.0;
                }
            }
        }
        let lighter = case.system.bodies.iter().any(|body| body.inertia == 0.0);
        if lighter && is_determined(&case) {
            case.expected = variables(&case.system, &case.state, 0.0);
            case.scene = scene_text("light", &case.system, &case.state, &case.expected);
            return case;
        }
    }
}

/// Is \[M J^T; J 0\] far from singular in absolute coordinates?
fn is_determined(case: &Case) -> bool {
    let jacobian = case.system.constraints(&case.state, 0.0).jacobian;
    let (m, n) = jacobian.shape();
    let mut matrix = DMatrix::zeros(n + m, n + m);
    matrix.view_mut((0, 0), (n, n)).set_diagonal(&case.system.masses());
    matrix.view_mut((n, 0), (m, n)).copy_from(&jacobian);
    matrix.view_mut((0, n), (n, m)).copy_from(&jacobian.transpose());
    let values = matrix.singular_values();
    values.min() > 1e-3 * values.max()
}
