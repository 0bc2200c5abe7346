//! Section 5.3 of the paper: the dynamics of the slider-crank, equation by equation, on a scene laid out as in Fig. 1.

use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol};
use cotree::model::Mechanism;
use cotree::network::{System, Trees};
use cotree::scene::Scene;

const SCENE: &str = r#"
format = 1
name = "figure_1"
[parameters]
m1 = "2 kg"
m2 = "3 kg"
m3 = "1.5 kg"
I1 = "0.1 kg.m2"
I2 = "0.4 kg.m2"
l5 = "0.3 m"
l6 = "0.2 m"
l7 = "0.7 m"
l8 = "0.8 m"
[inputs]
F = "0 N"
[ground.points]
guide = [0, 0]
[bodies.crank]
mass = "m1"
inertia = "I1"
points = { inner = ["-l5", 0], outer = ["l6", 0] }
[bodies.rod]
mass = "m2"
inertia = "I2"
points = { near = [0, "-l7"], far = [0, "l8"] }
[bodies.slider]
mass = "m3"
[joints.h9]
type = "revolute"
between = ["ground", "crank.inner"]
[joints.h10]
type = "revolute"
between = ["crank.outer", "rod.near"]
[joints.h11]
type = "revolute"
between = ["rod.far", "slider"]
[joints.s12]
type = "prismatic"
between = ["ground.guide", "slider"]
axis = [1, 0]
[loads.F13]
type = "force"
on = "slider"
vector = ["F", 0]
[initial]
"crank.angle" = 0.6
"rod.angle" = { guess = -1.7 }
[outputs]
variables = ["s12.s"]
"#;

/// Values of the symbols at one point of the test.
struct Point {
    th: [f64; 2],
    w: [f64; 2],
    force: f64,
}

const POINTS: [Point; 3] = [
    Point { th: [0.3, -1.1], w: [1.7, -0.4], force: 2.5 },
    Point { th: [2.9, 0.8], w: [-3.1, 5.2], force: -11.0 },
    Point { th: [-4.0, 7.3], w: [0.6, 2.2], force: 0.7 },
];

const L: [f64; 4] = [0.3, 0.2, 0.7, 0.8];
const M: [f64; 3] = [2.0, 3.0, 1.5];
const I: [f64; 2] = [0.1, 0.4];

impl Point {
    fn symbol(&self, mechanism: &Mechanism, symbol: Symbol) -> f64 {
        match symbol {
            Symbol::Coordinate(i, Order::Position) => self.th[i],
            Symbol::Coordinate(i, Order::Velocity) => self.w[i],
            Symbol::Parameter(i) => mechanism.parameters[i].value,
            Symbol::Input(0, Order::Position) => self.force,
            other => panic!("the equations must not contain {other:?}"),
        }
    }

    /// c1, s1, c2, s2
    fn trigonometry(&self) -> [f64; 4] {
        let [a, b] = self.th;
        [a.cos(), a.sin(), b.cos(), b.sin()]
    }
}

fn check(pick: impl Fn(&mut Equations) -> Expr, printed: impl Fn(&Point) -> f64) {
    let mechanism =
        Scene::from_toml(SCENE).and_then(|scene| scene.resolve()).map_err(|f| f.to_string()).unwrap().mechanism;
    let system = System::new(&mechanism);
    let trees = Trees::select(&system, &mechanism.coordinates).unwrap();
    let mut equations = Equations::new(system, trees);
    let names: Vec<&str> = equations.coordinates.iter().map(|c| c.name.position.as_str()).collect();
    assert_eq!(names, ["crank.angle", "rod.angle"]);
    assert_eq!(equations.constraints.len(), 1);
    let picked = pick(&mut equations);
    for point in &POINTS {
        let value = equations.system.arena.evaluate(&[picked], &|symbol| point.symbol(&mechanism, symbol))[0];
        let expected = printed(point);
        assert!((value - expected).abs() <= 1e-13 * (1.0 + expected.abs()), "{value} instead of {expected}");
    }
}

fn mass(row: usize, column: usize) -> impl Fn(&mut Equations) -> Expr {
    move |equations| {
        let row = &equations.dynamics().mass[row];
        row.iter().find(|(at, _)| *at == column).unwrap().1
    }
}

#[test]
fn eq48_constraint() {
    // With the one convention for reactions (n = k x u, edge from the ground to the slider) the sign is the opposite of the print.
    let [l5, l6, l7, l8] = L;
    check(
        |equations| equations.constraints[0].value,
        |point| {
            let [_, s1, c2, _] = point.trigonometry();
            -((l7 + l8) * c2 + (l5 + l6) * s1)
        },
    );
}

#[test]
fn eq57_mass_matrix_11() {
    let [l5, l6, ..] = L;
    check(mass(0, 0), |_| I[0] + M[0] * l5 * l5 + (M[1] + M[2]) * (l5 + l6).powi(2));
}

#[test]
fn eq58_mass_matrix_12() {
    let [l5, l6, l7, l8] = L;
    let printed = |point: &Point| {
        let [c1, s1, c2, s2] = point.trigonometry();
        -(M[1] * l7 + M[2] * (l7 + l8)) * (l5 + l6) * (c1 * s2 - s1 * c2)
    };
    check(mass(0, 1), printed);
    check(mass(1, 0), printed);
}

#[test]
fn eq59_mass_matrix_22() {
    let [_, _, l7, l8] = L;
    check(mass(1, 1), |_| I[1] + M[1] * l7 * l7 + M[2] * (l7 + l8).powi(2));
}

#[test]
fn eq60_jacobian() {
    let [l5, l6, l7, l8] = L;
    check(|equations| equations.constraints[0].jacobian[0].1, |point| -(l5 + l6) * point.trigonometry()[0]);
    check(|equations| equations.constraints[0].jacobian[1].1, |point| (l7 + l8) * point.trigonometry()[3]);
}

#[test]
fn eq56_reactions_enter_through_the_transposed_jacobian() {
    for row in 0..2 {
        check(
            |equations| {
                let entry = equations.dynamics().reactions[row][0].1;
                let jacobian = equations.constraints[0].jacobian[row].1;
                equations.system.arena.subtract(entry, jacobian)
            },
            |_| 0.0,
        );
    }
}

#[test]
fn eq61_load_1() {
    let [l5, l6, l7, l8] = L;
    check(
        |equations| equations.dynamics().load[0],
        |point| {
            // The paper's F13 points along -x; here the force input is along +x.
            let [c1, s1, c2, s2] = point.trigonometry();
            let w2 = point.w[1];
            -point.force * (l5 + l6) * s1 + (M[1] * l7 + M[2] * (l7 + l8)) * (l5 + l6) * w2 * w2 * (c1 * c2 + s1 * s2)
        },
    );
}

#[test]
fn eq62_load_2() {
    let [l5, l6, l7, l8] = L;
    check(
        |equations| equations.dynamics().load[1],
        |point| {
            let [c1, s1, c2, s2] = point.trigonometry();
            let w1 = point.w[0];
            -point.force * (l7 + l8) * c2 - (M[1] * l7 + M[2] * (l7 + l8)) * (l5 + l6) * w1 * w1 * (c1 * c2 + s1 * s2)
        },
    );
}
