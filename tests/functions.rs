//! Functions of the expression language: each is one line of a table, and everything that reads the table agrees.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::support::run::{compiled, file, model, started};
use cotree::expr::{Arena, Binary, Expr, Function, Order, Symbol, Unary};
use cotree::scene::Scene;
use cotree_fmu::program::Engine;
use cotree_text::written::{self, EquationFormat};

/// Functions composed of others, as a user without them would write them.
const WRITTEN_OUT: [(&str, &str); 8] = [
    ("sinh(steepness*arm.angle)", "((exp(steepness*arm.angle) - exp(-steepness*arm.angle))/2)"),
    ("sinh(arm.angle)", "((exp(arm.angle) - exp(-arm.angle))/2)"),
    ("cosh(t/2)", "((exp(t/2) + exp(-t/2))/2)"),
    ("hypot(arm.angle, 0.3)", "sqrt(arm.angle^2 + 0.09)"),
    (
        "smoothstep(arm.angle + 0.2)",
        "if(arm.angle + 0.2 < 0, 0, if(arm.angle + 0.2 > 1, 1, (arm.angle + 0.2)^2*(3 - 2*(arm.angle + 0.2))))",
    ),
    (
        "cycloidal(arm.angle + 0.4)",
        "if(arm.angle + 0.4 < 0, 0, if(arm.angle + 0.4 > 1, 1, arm.angle + 0.4 - sin(2*pi*(arm.angle + 0.4))/(2*pi)))",
    ),
    (
        "poly345(arm.angle + 0.4)",
        "if(arm.angle + 0.4 < 0, 0, if(arm.angle + 0.4 > 1, 1, 10*(arm.angle + 0.4)^3 - 15*(arm.angle + 0.4)^4 + 6*(arm.angle + 0.4)^5))",
    ),
    (
        "poly4567(arm.angle + 0.4)",
        "if(arm.angle + 0.4 < 0, 0, if(arm.angle + 0.4 > 1, 1, 35*(arm.angle + 0.4)^4 - 84*(arm.angle + 0.4)^5 + 70*(arm.angle + 0.4)^6 - 20*(arm.angle + 0.4)^7))",
    ),
];

fn scene() -> String {
    file("tests/scenes/functions.toml")
}

fn written_out() -> String {
    WRITTEN_OUT.iter().fold(scene(), |scene, (function, formula)| {
        assert!(scene.contains(function), "{function}");
        scene.replace(function, formula)
    })
}

/// The scene uses all of them, so that the printed code is tested with all of them too.
#[test]
fn every_function_is_in_the_scene_and_in_the_documentation() {
    for function in Function::all() {
        assert!(scene().contains(&format!("{}(", function.name())), "{}", function.name());
        assert!(file("docs/expressions.md").contains(&format!("`{}(", function.name())), "{}", function.name());
    }
}

#[test]
fn composed_functions_move_as_what_they_stand_for() {
    assert_eq!(compiled(&scene()).program.engine, Engine::Taylor);
    for engine in [Engine::Taylor, Engine::Dop853, Engine::Radau] {
        let [with, without] = [scene(), written_out()].map(|text| {
            let mut instance = started(&model(&text), Some(engine), 1.0, 1e-10);
            instance.step_to(1.0).expect("regular");
            (0..3).map(|place| instance.get(place + 1).expect("an output")).collect::<Vec<f64>>()
        });
        assert!(with.iter().any(|value| value.abs() > 0.1), "{with:?}");
        for (with, without) in with.iter().zip(&without) {
            assert!((with - without).abs() <= 1e-8 * without.abs().max(1.0), "{engine:?}: {with} for {without}");
        }
    }
}

#[test]
fn derivatives_are_those_that_differences_show() {
    let mut arena = Arena::default();
    let symbols = [0, 1].map(|index| Symbol::Coordinate(index, Order::Position));
    let [x, y] = symbols.map(|symbol| arena.symbol(symbol));
    let one = Unary::ALL.iter().map(|&function| (format!("{function:?}"), arena.unary(function, x)));
    let mut all: Vec<(String, Expr)> = one.collect();
    all.extend(Binary::ALL.iter().map(|&function| (format!("{function:?}"), arena.apply_binary(function, x, y))));
    for (name, expr) in all {
        for symbol in symbols {
            let slope = arena.derivative(expr, symbol);
            for point in [[0.3, 0.8], [0.7, 0.2], [0.55, 0.6]] {
                let at = |expr: Expr, by: f64| {
                    let values = |of: Symbol| {
                        let place = usize::from(of == symbols[1]);
                        point[place] + if of == symbol { by } else { 0.0 }
                    };
                    arena.evaluate(&[expr], &values)[0]
                };
                let difference = (at(expr, 1e-6) - at(expr, -1e-6)) / 2e-6;
                let slope = at(slope, 0.0);
                assert!((slope - difference).abs() < 1e-8, "{name} at {point:?}: {slope} for {difference}");
            }
        }
    }
}

/// Laws of cams: values, slopes and accelerations at 0.3, and the peaks of velocity, acceleration and jerk of Norton, *Design of Machinery*.
#[test]
fn laws_of_cams_have_their_known_values_and_peaks() {
    let laws = [
        (Unary::Harmonic, [0.2061073739, 1.270800923, 2.900603956], [FRAC_PI_2, 4.934802, 15.503139]),
        (Unary::Cycloidal, [0.1486346543, 1.309016994, 5.975664329], [2.0, TAU, 39.478418]),
        (Unary::Poly345, [0.16308, 1.323, 5.04], [1.875, 5.773503, 60.0]),
        (Unary::Poly4567, [0.126036, 1.29654, 7.4088], [2.1875, 7.513188, 52.5]),
        (Unary::ModifiedTrapezoid, [0.1605903487, 1.244406188, 4.888123763], [2.0, 4.888124, 61.425975]),
        (Unary::ModifiedSine, [0.1778877626, 1.322954207, 4.108072692], [1.759603, 5.527957, 69.466357]),
    ];
    for (law, values, peaks) in laws {
        let mut arena = Arena::default();
        let symbol = Symbol::Coordinate(0, Order::Position);
        let x = arena.symbol(symbol);
        let mut derivatives = vec![arena.unary(law, x)];
        for order in 0..3 {
            let next = arena.derivative(derivatives[order], symbol);
            derivatives.push(next);
        }
        let at = |place: f64| arena.evaluate(&derivatives, &|_: Symbol| place);
        let found = at(0.3);
        for (found, value) in found.iter().zip(values) {
            assert!((found - value).abs() < 1e-8, "{law:?}: {found} for {value}");
        }
        // Inside: at the ends themselves the law is held.
        let samples: Vec<Vec<f64>> = (1..4000).map(|index| at(f64::from(index) / 4000.0)).collect();
        for (order, peak) in (1..).zip(peaks) {
            let most = samples.iter().map(|sample| sample[order].abs()).fold(0.0, f64::max);
            assert!((most - peak).abs() < 2e-3 * peak, "{law:?}, derivative {order}: {most} for {peak}");
        }
        for (place, value) in [(-0.5, 0.0), (0.0, 0.0), (1.0, 1.0), (3.0, 1.0)] {
            assert!(
                (at(place)[0] - value).abs() < 1e-15 && at(place)[1].abs() < 1e-12,
                "{law:?} at {place}: {:?}",
                at(place)
            );
        }
        for place in [0.05, 0.125, 0.2, 0.375, 0.45, 0.5] {
            assert!((at(place)[0] + at(1.0 - place)[0] - 1.0).abs() < 1e-14, "{law:?} at {place}");
        }
    }
}

/// Hyperbolic sines keep their relative accuracy where the difference of exponentials loses it.
#[test]
fn composed_functions_are_accurate_near_zero() {
    for x in [1e-12_f64, -3e-9, 1e-4, 0.3, -2.5, 20.0] {
        for (function, exact) in [(Unary::Sinh, x.sinh()), (Unary::Cosh, x.cosh())] {
            let value = Function::One(function).value(&[x]);
            assert!((value - exact).abs() <= 1e-15 * exact.abs(), "{function:?}({x}): {value:e} for {exact:e}");
        }
    }
    assert_eq!(Function::Two(Binary::Hypot).value(&[3.0, -4.0]), 5.0);
    let steps = [-1.0, 0.0, 0.5, 1.0, 7.0].map(|x| Function::One(Unary::Smoothstep).value(&[x]));
    assert_eq!(steps, [0.0, 0.0, 0.5, 1.0, 1.0]);
}

#[test]
fn every_notation_shows_them_by_name() {
    let scene = Scene::from_toml(&scene()).expect("a scene");
    let printed = |notation| written::equations(&scene, notation).expect("equations");
    let expected: [(EquationFormat, &[&str]); 3] = [
        (EquationFormat::Text, &["sinh(", "cosh(", "hypot(", "smoothstep(", "asin("]),
        (
            EquationFormat::Latex,
            &[r"\sinh", r"\cosh", r"\operatorname{hypot}", r"\operatorname{smoothstep}", r"\arcsin"],
        ),
        (EquationFormat::Json, &["sinh", "cosh", "hypot", "smoothstep"]),
    ];
    for (notation, words) in expected {
        let text = printed(notation);
        words.iter().for_each(|word| assert!(text.contains(word), "{word}: {text}"));
    }
}

/// Functions that came later than the first version of the format take no name from older scenes.
#[test]
fn a_parameter_may_have_the_name_of_a_newer_function() {
    let text = scene().replace("steepness", "sinh").replace("sinh*", "(sinh)*");
    assert!(text.contains("sinh((sinh)*arm.angle)"));
    compiled(&text);
}
