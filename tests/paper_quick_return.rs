//! Section 5.2 of the paper: the kinematics of the quick-return mechanism, equation by equation.

use crate::support::ROOT;
use std::f64::consts::PI;
use std::path::Path;

use cotree::equations::{Constraint, Equations};
use cotree::expr::{Expr, Order, Symbol};
use cotree::model::{Mechanism, Owner, Quantity, Variable};
use cotree::network::{System, Trees};
use cotree::scene::Scene;
use proptest::prelude::*;

fn mechanism() -> Mechanism {
    let path = Path::new(ROOT).join("models/quick_return/scene.toml");
    Scene::read(&path).and_then(|scene| scene.resolve()).unwrap().mechanism
}

fn equations(mechanism: &Mechanism) -> Equations {
    let system = System::new(mechanism);
    let trees = Trees::select(&system, &mechanism.coordinates).unwrap();
    Equations::new(system, trees)
}

/// Angles, their rates, time, and the lengths l1 to l8.
#[derive(Clone, Debug)]
struct Point {
    th: [f64; 2],
    w: [f64; 2],
    t: f64,
    l: [f64; 9],
}

fn point() -> impl Strategy<Value = Point> {
    let angles = [-7.0..7.0, -7.0..7.0];
    (angles.clone(), angles, 0.0..2.0, prop::collection::vec(0.05..2.0, 9)).prop_map(|(th, w, t, l)| Point {
        th,
        w,
        t,
        l: l.try_into().unwrap(),
    })
}

impl Point {
    fn evaluate(&self, equations: &Equations, expr: Expr) -> f64 {
        let mechanism = &equations.system.mechanism;
        let value = |symbol: Symbol| match symbol {
            Symbol::Coordinate(i, Order::Position) => self.th[i],
            Symbol::Coordinate(i, Order::Velocity) => self.w[i],
            Symbol::Time => self.t,
            Symbol::Parameter(i) => self.l[mechanism.parameters[i].name[1..].parse::<usize>().unwrap()],
            other => panic!("the equations must not contain {other:?}"),
        };
        equations.system.arena.evaluate(&[expr], &value)[0]
    }

    fn crank(&self) -> f64 {
        0.4356 + 4.0 * PI * self.t
    }

    fn eq38(&self) -> f64 {
        let (l, th9, th11) = (&self.l, self.th[0], self.crank());
        (l[7] + l[8]) * (th9.sin() * th11.cos() - th9.cos() * th11.sin()) - l[2] * th9.cos()
    }

    fn eq39(&self) -> f64 {
        let (l, [th9, th12]) = (&self.l, self.th);
        l[1] + l[2] - (l[3] + l[4]) * th9.sin() - (l[5] + l[6]) * th12.cos()
    }

    fn eq42(&self) -> f64 {
        let (l, [th9, th12]) = (&self.l, self.th);
        (l[3] + l[4]) * th9.cos() - (l[5] + l[6]) * th12.sin()
    }
}

fn row<'a>(equations: &'a Equations, name: &str) -> &'a Constraint {
    let named = |row: &&Constraint| equations.system.element(row.element).name == name && !row.is_trivial();
    equations.constraints.iter().find(named).unwrap()
}

/// Angles of up to 30 rad are rounded to 4e-15; their sines carry that into terms of the given size.
fn close(value: f64, expected: f64, size: f64) -> Result<(), TestCaseError> {
    prop_assert!((value - expected).abs() <= 3e-14 * size, "{value} instead of {expected}");
    Ok(())
}

#[test]
fn the_coordinates_are_the_angles_of_rocker_and_rod() {
    let mechanism = mechanism();
    let names: Vec<String> = equations(&mechanism).coordinates.iter().map(|c| c.name.position.clone()).collect();
    assert_eq!(names, ["rocker.angle", "rod.angle"]);
}

/// "Rank structure": (38) contains the rocker's angle only, so it can be solved on its own.
#[test]
fn eq38_holds_the_rocker_alone() {
    let mechanism = mechanism();
    let equations = equations(&mechanism);
    let columns: Vec<usize> = row(&equations, "rocker_slot").jacobian.iter().map(|(column, _)| *column).collect();
    assert_eq!(columns, [0]);
}

proptest! {
    /// The edge of the slot runs from the rocker to the block and Phi is minus its own displacement along n = k x u: the sign of the print.
    #[test]
    fn eq38(point in point()) {
        let mechanism = mechanism();
        let equations = equations(&mechanism);
        close(point.evaluate(&equations, row(&equations, "rocker_slot").value), point.eq38(), 10.0)?;
    }

    #[test]
    fn eq39(point in point()) {
        let mechanism = mechanism();
        let equations = equations(&mechanism);
        close(point.evaluate(&equations, row(&equations, "tool_slide").value), point.eq39(), 10.0)?;
    }

    /// The projection of the tool's circuit on the direction of sliding.
    #[test]
    fn eq42(point in point()) {
        let mechanism = mechanism();
        let mut equations = equations(&mechanism);
        let joint = mechanism.joints.iter().position(|joint| joint.name == "tool_slide").unwrap();
        let slide = Variable { owner: Owner::Joint(cotree::model::JointId(joint)), quantity: Quantity::S };
        let expr = equations.variable(slide);
        // The paper's s20 counts from the line of both pivots; so does the guide at x = 0.
        close(point.evaluate(&equations, expr), point.eq42(), 10.0)?;
    }

    /// Equations (19)-(21) of (38), by hand: the rates and accelerations that the crank's 4 pi rad/s demand.
    #[test]
    fn eq38_rates(point in point()) {
        let mechanism = mechanism();
        let equations = equations(&mechanism);
        let slot = row(&equations, "rocker_slot");
        let (l, difference, crank) = (point.l[7] + point.l[8], point.th[0] - point.crank(), 4.0 * PI);
        let by_rocker = l * difference.cos() + point.l[2] * point.th[0].sin();
        close(point.evaluate(&equations, slot.jacobian[0].1), by_rocker, 10.0)?;
        close(point.evaluate(&equations, slot.time_rate), -l * difference.cos() * crank, 100.0)?;
        let gamma = l * difference.sin() * (point.w[0] - crank).powi(2) - point.l[2] * point.th[0].cos() * point.w[0].powi(2);
        close(point.evaluate(&equations, slot.gamma), gamma, 3000.0)?;
    }
}
