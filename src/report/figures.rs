//! The figures of `cotree show`.

use std::collections::HashSet;

use cotree_fmu::program::arm_form::ArmForm;
use cotree_fmu::program::{Engine, Source};

use super::summary::{
    CoordinateSummary, Count, Counts, GraphKind, Integrated, JointSummary, ModesSummary, SeriesSystem,
    SolveTreeSummary, Summary, TreesSummary,
};
use crate::equations::Equations;
use crate::formulate::{Formulated, equations};
use crate::model::{Contact, CoordinateChoice, Mechanism, Part};
use crate::network::{Angle, ElementId, Origin};
use crate::program::Lowered;
use crate::solve::Block;

pub fn summarise(formulated: &Formulated) -> Summary {
    let equations = &formulated.equations;
    let mechanism = &equations.system.mechanism;
    let owner = |index: usize| equations.system.element(equations.constraints[index].element).name.clone();
    let real: Vec<usize> =
        (0..equations.constraints.len()).filter(|&index| !equations.constraints[index].is_trivial()).collect();
    Summary {
        name: mechanism.name.clone(),
        description: mechanism.description.clone(),
        bodies: mechanism.bodies.iter().map(|body| body.name.clone()).collect(),
        joints: mechanism.joints.iter().map(|joint| describe_joint(mechanism, joint)).collect(),
        drivers: mechanism.drivers.iter().map(|driver| driver.name.clone()).collect(),
        loads: mechanism.loads.iter().map(|load| load.name.clone()).collect(),
        parameters: mechanism.parameters.iter().map(|parameter| parameter.name.clone()).collect(),
        inputs: mechanism.inputs.iter().map(|input| input.name.clone()).collect(),
        states: mechanism.states.iter().map(|state| state.name.clone()).collect(),
        outputs: formulated.outputs.iter().map(|output| output.name.clone()).collect(),
        mobility: formulated.mobility(),
        kinematic: formulated.lowered.program.is_driven(),
        solver: solver(&formulated.lowered),
        integrated: (!formulated.lowered.program.is_driven()).then(|| integrated(&formulated.lowered)),
        coordinates: coordinates(equations),
        constraints: real.iter().map(|&index| owner(index)).collect(),
        modes: modes(equations),
        redundant: formulated
            .redundant
            .iter()
            .filter(|index| real.contains(index))
            .map(|&index| owner(index))
            .collect(),
        blocks: blocks(&formulated.lowered),
        trees: TreesSummary {
            translation: names(equations, &equations.trees.translation.branches),
            rotation: names(equations, &equations.trees.rotation.branches),
        },
        counts: counts(equations),
        solve_tree: formulated.lowered.solve_tree.as_ref().map(|tree| solve_tree(equations, tree)),
    }
}

fn solver(lowered: &Lowered) -> String {
    let stiff = if lowered.program.automatic { "; Radau IIA(5) while it is stiff" } else { "" };
    match (lowered.program.engine, &lowered.no_series) {
        (Engine::Taylor, _) => format!("Taylor series{stiff}"),
        (engine, reason) => {
            let method = if engine == Engine::Radau { "Radau IIA(5)" } else { "Runge-Kutta (DOP853)" };
            let reason = reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
            format!("{method}{stiff}{reason}")
        }
    }
}

fn integrated(lowered: &Lowered) -> Integrated {
    let program = &lowered.program;
    let active = program.constraints.iter().filter(|constraint| constraint.is_imposed()).count();
    let needs_acceleration =
        |source: Source| matches!(source, Source::Acceleration(_) | Source::Output { accelerated: true, .. });
    let outputs = lowered.table.rows.iter().filter(|row| row.is_output());
    let (accelerated, state): (Vec<_>, Vec<_>) = outputs.partition(|row| needs_acceleration(row.source));
    Integrated {
        series: program.arms.as_ref().filter(|_| program.engine == Engine::Taylor).map(series_system),
        stages: Count { coordinates: program.coordinates.len(), constraints: active },
        outputs_of_state: state.len(),
        outputs_of_acceleration: accelerated.len(),
    }
}

/// What the series solve for.
fn series_system(form: &ArmForm) -> SeriesSystem {
    let [angles, displacements, loop_equations] = form.unknowns_and_equations();
    SeriesSystem { angles, displacements, loop_equations }
}

fn blocks(lowered: &Lowered) -> Vec<Vec<String>> {
    let names = |block: &Block| {
        block
            .columns
            .iter()
            .map(|&column| lowered.program.coordinates[column as usize].name.clone())
            .collect::<Vec<_>>()
    };
    lowered.blocks.iter().map(names).collect()
}

fn solve_tree(equations: &Equations, tree: &crate::solve::SolveTree) -> SolveTreeSummary {
    let before: HashSet<ElementId> = equations.trees.translation.branches.iter().copied().collect();
    let added = tree.trees.translation.branches.iter().filter(|id| !before.contains(id));
    let bodies = added.map(|&id| equations.system.element(id).name.clone()).collect();
    let saving = |branch_cost: crate::tape::Cost| 1.0 - tree.cost.nanoseconds() / branch_cost.nanoseconds();
    SolveTreeSummary { bodies, saving: tree.branch_cost.map(saving) }
}

/// The modes of everything that has some.
fn modes(equations: &Equations) -> Vec<ModesSummary> {
    let all = equations.system.mechanism.contacts.iter().enumerate();
    let of = |(index, contact): (usize, &Contact)| {
        let modes = if equations.is_led(index) { vec!["slides, prescribed by drivers"] } else { contact.modes() };
        ModesSummary { name: contact.name.clone(), modes }
    };
    all.map(of).collect()
}

fn describe_joint(mechanism: &Mechanism, joint: &Part) -> JointSummary {
    let between = joint.between.map(|place| mechanism.place_name(place));
    JointSummary { name: joint.name.clone(), kind: joint.component().name.to_string(), between }
}

fn coordinates(equations: &Equations) -> Vec<CoordinateSummary> {
    let tree = |element: ElementId, angular: bool| {
        let rotation = equations.system.element(element).rotation.as_ref();
        let turns = angular && rotation.is_some_and(|row| matches!(row.angle, Angle::Free(_)));
        if turns { GraphKind::Rotation } else { GraphKind::Translation }
    };
    let all = equations.coordinates.iter();
    all.map(|q| CoordinateSummary { name: q.name.position.clone(), tree: tree(q.element, q.angular) }).collect()
}

fn names(equations: &Equations, branches: &[ElementId]) -> Vec<String> {
    let elements = branches.iter().map(|&id| equations.system.element(id));
    let named = elements.filter(|element| !matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_)));
    named.map(|element| element.name.clone()).collect()
}

/// With more bodies the presets are not compared: relative angles of a long chain alone take more than all its other equations.
const COMPARED: usize = 200;

/// Coordinates and loop equations for the presets, and for the scene's own trees.
fn counts(counted: &Equations) -> Counts {
    let mechanism = &counted.system.mechanism;
    let of = |choice: &CoordinateChoice| {
        let small = mechanism.bodies.len() <= COMPARED;
        small.then(|| equations(mechanism, choice).ok().map(|other| count(&other))).flatten()
    };
    Counts {
        used: count(counted),
        recommended: of(&CoordinateChoice::Recommended),
        absolute: of(&CoordinateChoice::Absolute),
        joint: of(&CoordinateChoice::Joint),
    }
}

fn count(equations: &Equations) -> Count {
    let constraints = equations.constraints.iter().filter(|constraint| !constraint.is_trivial()).count();
    Count { coordinates: equations.coordinates.len(), constraints }
}
