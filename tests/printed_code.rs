//! Printed code computes what the kernels compute: compiled and run in each language, for all models, at random inputs.
//!
//! C and Rust give the same bits where the equations need nothing beyond the four operations, roots, sines and cosines; Fortran and
//! Python agree to rounding. numpy comes into a private environment; a machine without gfortran leaves Fortran out and says so,
//! unless `COTREE_FORTRAN=1` asks for it.

use crate::outside::{command, python};
use crate::support::run;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use cotree::expr::{Expr, Order, Symbol};
use cotree::formulate::Formulated;
use cotree::model::{Discrete, Mechanism};
use cotree::scene::Scene;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_text::written::{self, EquationFormat};

use command::printed;
use run::{file, formulated, models, scene_of, sound};

/// How many random inputs.
const POINTS: usize = 5;

/// Arguments of the printed functions.
struct Point {
    t: f64,
    p: Vec<f64>,
    u: Vec<f64>,
    f: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
}

/// A generator of numbers between -1 and 1 (Knuth's constants).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn list(&mut self, count: usize, scale: f64) -> Vec<f64> {
        (0..count).map(|_| scale * self.next()).collect()
    }
}

/// The argument `p`: parameters, then discrete variables.
fn numbers(mechanism: &Mechanism) -> impl Iterator<Item = f64> {
    let parameters = mechanism.parameters.iter().map(|parameter| parameter.value);
    parameters.chain(mechanism.discrete.iter().map(Discrete::start))
}

fn points(formulated: &Formulated, seed: u64) -> Vec<Point> {
    let mechanism = &formulated.equations.system.mechanism;
    let mut random = Random(seed);
    let state = &formulated.state;
    (0..POINTS)
        .map(|_| Point {
            t: 3.0 + random.next(),
            p: numbers(mechanism).map(|value| value * (1.0 + 0.2 * random.next())).collect(),
            u: random.list(3 * mechanism.inputs.len(), 5.0),
            f: random.list(3 * formulated.equations.system.followers.len(), 2.0),
            // Near the assembled pose: no spring has length zero there.
            q: state.positions().iter().map(|q| q + 0.1 * random.next()).collect(),
            v: random.list(state.rates().len(), 4.0),
        })
        .collect()
}

/// The kernels' own arithmetic: all results, in the order in which the drivers print them.
fn expected(formulated: &mut Formulated, point: &Point) -> Vec<f64> {
    let n = formulated.equations.coordinates.len();
    let parameters = formulated.equations.system.mechanism.parameters.len();
    let dynamic = !formulated.lowered.solved.is_empty();
    let mut roots: Vec<Expr> = Vec::new();
    let dense = |roots: &mut Vec<Expr>, row: &[(usize, Expr)]| {
        roots.extend((0..n).map(|column| row.iter().find(|(at, _)| *at == column).map_or(Expr::ZERO, |(_, e)| *e)));
    };
    if dynamic {
        let dynamics = formulated.equations.dynamics().clone();
        dynamics.mass.iter().for_each(|row| dense(&mut roots, row));
        roots.extend(&dynamics.load);
    }
    let constraints: Vec<_> = formulated.equations.loops().map(|(_, row)| row.clone()).collect();
    roots.extend(constraints.iter().map(|row| row.value));
    constraints.iter().for_each(|row| dense(&mut roots, &row.jacobian));
    roots.extend(constraints.iter().map(|row| row.time_rate));
    roots.extend(constraints.iter().map(|row| row.gamma));
    let reactions = formulated.equations.loops().map(|(index, _)| n + index);
    let solved = &formulated.lowered.solved;
    roots.extend((0..n).chain(reactions).filter_map(|index| solved.get(index)));
    formulated.equations.system.arena.evaluate(&roots, &|symbol: Symbol| match symbol {
        Symbol::Time => point.t,
        Symbol::Parameter(i) => point.p[i],
        Symbol::Discrete(i) => point.p[parameters + i],
        Symbol::Input(i, order) => point.u[3 * i + order as usize],
        Symbol::Follower(i, order) => point.f[3 * i + order as usize],
        Symbol::Coordinate(i, Order::Position) => point.q[i],
        Symbol::Coordinate(i, Order::Velocity) => point.v[i],
        other => panic!("{other:?} is no argument"),
    })
}

/// The tapes agree with the expressions bit for bit, so that what follows is about the kernels.
fn check_tapes(name: &str, formulated: &mut Formulated, point: &Point) {
    let model = Model::new(formulated.lowered.program.clone()).unwrap();
    let mut state = model.default_state(point.t);
    // Behind the scene's parameters come initial values that can be set; no kernel of the motion reads them.
    let (parameters, discrete) = point.p.split_at(formulated.equations.system.mechanism.parameters.len());
    state.parameters_mut()[..parameters.len()].copy_from_slice(parameters);
    state.discrete_mut().copy_from_slice(discrete);
    let layout = *model.layout();
    for (index, signal) in point.u.chunks(3).enumerate() {
        let places = [layout.inputs(), layout.input_rates(), layout.input_accelerations()];
        places.into_iter().zip(signal).for_each(|(place, value)| state.registers_mut()[place + index] = *value);
    }
    for (index, signal) in point.f.chunks(3).enumerate() {
        let places = [layout.followers(), layout.follower_rates(), layout.follower_accelerations()];
        places.into_iter().zip(signal).for_each(|(place, value)| state.registers_mut()[place + index] = *value);
    }
    state.positions_mut().copy_from_slice(&point.q);
    state.rates_mut().copy_from_slice(&point.v);
    let mut machine = Machine::new(&model);
    machine.load(&model, &state);
    let expected = expected(formulated, point);
    let (n, m) = (point.q.len(), formulated.equations.loops().count());
    let start = if formulated.lowered.solved.is_empty() { 0 } else { n * n + n };
    let tapes = &model.program().tapes;
    // The kernels have rows for loop equations that say nothing as well.
    let rows: Vec<usize> = formulated.equations.loops().map(|(index, _)| index).collect();
    let solved: Vec<usize> = (0..n).chain(rows.iter().map(|row| n + row)).collect();
    // Printed equations of a driven mechanism end with its loop equations.
    let printed = if formulated.lowered.solved.is_empty() { 2 } else { 3 };
    let kernels = [
        (&tapes.constraint, start, &rows),
        (&tapes.gamma, start + 2 * m + m * n, &rows),
        (&tapes.acceleration, start + 3 * m + m * n, &solved),
    ];
    for (tape, first, rows) in kernels.into_iter().take(printed) {
        let mut all = vec![0.0; tape.results.len()];
        machine.evaluate(tape, &mut all);
        let results: Vec<f64> = rows.iter().filter_map(|row| all.get(*row).copied()).collect();
        assert_bits(name, &results, &expected[first..first + results.len()]);
    }
}

fn assert_bits(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}: number of results");
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!(found == expected, "{name}: result {index} is {found:e}, not {expected:e}");
    }
}

fn assert_close(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{name}: number of results");
    let scale = expected.iter().fold(1e-9_f64, |largest, value| largest.max(value.abs()));
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        let bound = tolerance * (expected.abs() + 1e-3 * scale);
        assert!((found - expected).abs() <= bound, "{name}: result {index} is {found:e}, not {expected:e}");
    }
}

/// Sizes of the arrays of results, in the order in which they are printed.
struct Sizes {
    p: usize,
    u: usize,
    f: usize,
    n: usize,
    m: usize,
    dynamic: bool,
}

impl Sizes {
    fn new(formulated: &Formulated) -> Self {
        Sizes {
            p: numbers(&formulated.equations.system.mechanism).count(),
            u: 3 * formulated.equations.system.mechanism.inputs.len(),
            f: 3 * formulated.equations.system.followers.len(),
            n: formulated.equations.coordinates.len(),
            m: formulated.equations.loops().count(),
            dynamic: !formulated.lowered.solved.is_empty(),
        }
    }

    /// Names and sizes of what is printed.
    fn printed(&self, names: [&'static str; 8]) -> Vec<(&'static str, usize)> {
        let (n, m) = (self.n, self.m);
        let [mass, load, phi, phi_q, phi_t, gamma, a, lambda] = names;
        let mut list = Vec::new();
        if self.dynamic {
            list.extend([(mass, n * n), (load, n)]);
        }
        list.extend([(phi, m), (phi_q, m * n), (phi_t, m), (gamma, m)]);
        if self.dynamic {
            list.extend([(a, n), (lambda, m)]);
        }
        list
    }
}

/// Numbers in hexadecimal bits, one on a line, `POINTS` sets of them.
fn bits(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|word| f64::from_bits(u64::from_str_radix(word, 16).unwrap())).collect()
}

fn decimals(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|word| word.parse().unwrap()).collect()
}

fn list(values: &[f64], separator: &str, dummy: &str) -> String {
    let words: Vec<String> = values.iter().map(|value| format!("{value:e}")).collect();
    if words.is_empty() { dummy.to_owned() } else { words.join(separator) }
}

/// A folder with the printed code, and what is to be found.
struct Case<'a> {
    name: &'a str,
    folder: &'a Path,
    sizes: Sizes,
    points: &'a [Point],
}

impl Case<'_> {
    fn run_c(&self, code: &str) -> Vec<f64> {
        let mut main = String::from(
            "#include \"code.c\"\n#include <stdio.h>\nstatic void print(const double *x, int n) { for (int i = 0; i < n; i++) { uint64_t b; memcpy(&b, x + i, 8); printf(\"%016llx\\n\", (unsigned long long)b); } }\nint main(void) {\n",
        );
        let names = ["M", "Q", "Phi", "Phi_q", "Phi_t", "gamma_", "a", "lambda"];
        for name in names {
            let _ = writeln!(main, "double {name}[{}] = {{0}};", (self.sizes.n * (self.sizes.n + self.sizes.m)).max(1));
        }
        for point in self.points {
            let arrays = [("p", &point.p), ("u", &point.u), ("f", &point.f), ("q", &point.q), ("v", &point.v)];
            let _ = writeln!(main, "{{ const double t = {:e};", point.t);
            for (array, values) in arrays {
                let _ = writeln!(main, "const double {array}[] = {{{}}};", list(values, ", ", "0"));
            }
            let _ = writeln!(main, "{}_equations(t, p, u, f, q, v, M, Q, Phi, Phi_q, Phi_t, gamma_);", self.name);
            if self.sizes.dynamic {
                let _ = writeln!(main, "{}_accelerations(t, p, u, f, q, v, a, lambda);", self.name);
            }
            for (array, size) in self.sizes.printed(names) {
                let _ = writeln!(main, "print({array}, {size});");
            }
            main.push_str("}\n");
        }
        main.push_str("(void)a; (void)lambda; (void)M; (void)Q; return 0; }\n");
        let [source, program] = ["main.c", "main_c"].map(|file| self.folder.join(file));
        std::fs::write(self.folder.join("code.c"), code).unwrap();
        std::fs::write(&source, main).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-O1", "-ffp-contract=off"];
        printed(Command::new("gcc").args(flags).arg(&source).arg("-o").arg(&program).arg("-lm"));
        bits(&printed(&mut Command::new(program)))
    }

    fn run_rust(&self, code: &str) -> Vec<f64> {
        let names = ["mass", "load", "phi", "phi_q", "phi_t", "gamma", "a", "lambda"];
        let Sizes { n, m, .. } = self.sizes;
        let mut main = String::from(
            "mod code;\nfn print(x: &[f64]) { x.iter().for_each(|x| println!(\"{:016x}\", x.to_bits())); }\nfn main() {\n",
        );
        for point in self.points {
            let arrays = [&point.p, &point.u, &point.f, &point.q, &point.v];
            let arguments: Vec<String> = arrays
                .into_iter()
                .map(|values| {
                    let literals: Vec<String> = values.iter().map(|value| format!("{value:e}_f64")).collect();
                    format!("&[{}]", literals.join(", "))
                })
                .collect();
            let arguments = format!("{:e}, {}", point.t, arguments.join(", "));
            let _ = writeln!(
                main,
                "{{ let (mut mass, mut load) = ([[0.0; {n}]; {n}], [0.0; {n}]);\nlet (mut phi, mut phi_q, mut phi_t, mut gamma) = ([0.0; {m}], [[0.0; {n}]; {m}], [0.0; {m}], [0.0; {m}]);\ncode::{}_equations({arguments}, &mut mass, &mut load, &mut phi, &mut phi_q, &mut phi_t, &mut gamma);",
                self.name
            );
            if self.sizes.dynamic {
                let _ = writeln!(
                    main,
                    "let (mut a, mut lambda) = ([0.0; {n}], [0.0; {m}]);\ncode::{}_accelerations({arguments}, &mut a, &mut lambda);",
                    self.name
                );
            }
            for (array, _) in self.sizes.printed(names) {
                let flat = if matches!(array, "mass" | "phi_q") { ".as_flattened()" } else { "" };
                let _ = writeln!(main, "print(&{array}{flat}[..]);");
            }
            main.push_str("}\n");
        }
        main.push_str("}\n");
        let [source, program] = ["main.rs", "main_rust"].map(|file| self.folder.join(file));
        std::fs::write(self.folder.join("code.rs"), code).unwrap();
        std::fs::write(&source, main).unwrap();
        printed(Command::new("rustc").args(["--edition", "2021", "-D", "warnings", "-o"]).arg(&program).arg(&source));
        bits(&printed(&mut Command::new(program)))
    }

    fn run_fortran(&self, code: &str) -> Vec<f64> {
        let names = ["mass", "load", "phi", "phi_q", "phi_t", "gamma", "a", "lambda"];
        let Sizes { p, u, f, n, m, dynamic } = self.sizes;
        let mut main = format!(
            "program test\n  use {0}_model\n  use, intrinsic :: iso_fortran_env, only: real64\n  implicit none\n  \
             real(real64) :: p({p}), u({u}), f({f}), q({n}), v({n})\n  \
             real(real64) :: mass({n},{n}), load({n}), phi({m}), phi_q({m},{n}), phi_t({m}), gamma({m}), a({n}), lambda({m})\n",
            self.name
        );
        for point in self.points {
            let arrays = [("p", &point.p), ("u", &point.u), ("f", &point.f), ("q", &point.q), ("v", &point.v)];
            for (array, values) in arrays {
                for (index, value) in values.iter().enumerate() {
                    let _ = writeln!(main, "  {array}({}) = {value:e}_real64", index + 1);
                }
            }
            let arguments = format!("{:e}_real64, p, u, f, q, v", point.t);
            let _ = writeln!(
                main,
                "  call {}_equations({arguments}, &\n    mass, load, phi, phi_q, phi_t, gamma)",
                self.name
            );
            if dynamic {
                let _ = writeln!(main, "  call {}_accelerations({arguments}, a, lambda)", self.name);
            }
            for (array, _) in self.sizes.printed(names) {
                let rows = if matches!(array, "mass" | "phi_q") { "transpose" } else { "" };
                let _ = writeln!(main, "  print '(es25.17e3)', {rows}({array})");
            }
        }
        main.push_str("end program test\n");
        let [module, source, program] = ["code.f90", "main.f90", "main_fortran"].map(|file| self.folder.join(file));
        std::fs::write(&module, code).unwrap();
        std::fs::write(&source, main).unwrap();
        let flags = ["-std=f2008", "-O1", "-ffp-contract=off", "-o"];
        printed(Command::new("gfortran").current_dir(self.folder).args(flags).args([&program, &module, &source]));
        decimals(&printed(&mut Command::new(program)))
    }

    fn run_python(&self, code: &str) -> Vec<f64> {
        let names = ["M", "Q", "Phi", "Phi_q", "Phi_t", "gamma", "a", "lam"];
        let mut main = String::from("import numpy as np\nimport code_ as code\n");
        for point in self.points {
            let arrays = [&point.p, &point.u, &point.f, &point.q, &point.v];
            let arrays: Vec<String> =
                arrays.into_iter().map(|values| format!("[{}]", list(values, ", ", ""))).collect();
            let arguments = format!("{:e}, {}", point.t, arrays.join(", "));
            let _ = writeln!(main, "M, Q, Phi, Phi_q, Phi_t, gamma = code.{}_equations({arguments})", self.name);
            if self.sizes.dynamic {
                let _ = writeln!(main, "a, lam = code.{}_accelerations({arguments})", self.name);
            }
            for (array, _) in self.sizes.printed(names) {
                let _ = writeln!(main, "for x in np.ravel({array}): print(repr(float(x)))");
            }
        }
        std::fs::write(self.folder.join("code_.py"), code).unwrap();
        std::fs::write(self.folder.join("main.py"), main).unwrap();
        let (_, python) = numpy().expect("asked for before");
        decimals(&printed(Command::new(python).current_dir(self.folder).arg("main.py")))
    }
}

/// The Python of a private environment with numpy; nothing if the user leaves Python out.
fn numpy() -> Option<(PathBuf, PathBuf)> {
    python::python("numpy", "numpy==2.4.6")
}

/// Calls `check` for every model with its equations, random points and what the kernels give there.
fn for_all_models(notation: EquationFormat, check: impl Fn(&Case, &str, &[f64], bool)) {
    // Friction that sticks has no functions.
    let own =
        models().into_iter().filter(|name| !run::RUBBING.contains(&name.as_str())).map(|name| (scene_of(&name), name));
    let scenes = ["functions", "equal_sides"].map(|name| (file(&format!("tests/scenes/{name}.toml")), name.to_owned()));
    for (text, name) in own.chain(scenes) {
        let scene = sound(Scene::from_toml(&text));
        let code = written::equations(&scene, notation).unwrap_or_else(|faults| panic!("{faults}"));
        let resolved = sound(scene.resolve());
        // Functions with states take one argument more: `c_code` compares those.
        if !resolved.mechanism.states.is_empty() {
            continue;
        }
        let mut formulated = formulated(&resolved);
        let points = points(&formulated, 7 + name.len() as u64);
        check_tapes(&name, &mut formulated, &points[0]);
        let expected: Vec<f64> = points.iter().flat_map(|point| expected(&mut formulated, point)).collect();
        assert!(expected.iter().all(|value| value.is_finite()), "{name}: {expected:?}");
        let folder = tempfile::tempdir().unwrap();
        let case = Case {
            name: &resolved.mechanism.name,
            folder: folder.path(),
            sizes: Sizes::new(&formulated),
            points: &points,
        };
        check(&case, &code, &expected, is_elementary(&formulated));
    }
}

/// Do the equations need functions for which the languages have their own versions?
fn is_elementary(formulated: &Formulated) -> bool {
    use cotree::expr::{Binary, ExprNode, Unary};
    let arena = &formulated.equations.system.arena;
    let foreign = |expr| {
        matches!(
            arena.node(expr),
            ExprNode::Unary(
                Unary::Sinh
                    | Unary::Cosh
                    | Unary::Tan
                    | Unary::Asin
                    | Unary::Acos
                    | Unary::Atan
                    | Unary::Exp
                    | Unary::Log
                    | Unary::Tanh,
                _
            ) | ExprNode::Binary(Binary::Power | Binary::Atan2, ..)
        )
    };
    !arena.all().any(foreign)
}

fn assert_same(name: &str, found: &[f64], expected: &[f64], elementary: bool) {
    if elementary { assert_bits(name, found, expected) } else { assert_close(name, found, expected, 1e-13) }
}

/// Is gfortran there? Where it is asked for, it must be.
fn has_fortran() -> bool {
    let found = Command::new("gfortran").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        let wanted = std::env::var_os("COTREE_FORTRAN").is_some_and(|value| value == "1");
        assert!(!wanted, "gfortran is missing: install it, or unset COTREE_FORTRAN to leave this test out");
        // Not `eprintln!`: the test harness would hide it.
        let note = "SKIPPED: the printed Fortran was not run, because gfortran is missing";
        writeln!(std::io::stderr(), "{note}").expect("standard error is open");
    }
    found
}

#[test]
fn c_gives_the_same_bits() {
    for_all_models(EquationFormat::C, |case, code, expected, elementary| {
        assert_same(&format!("{} in C", case.name), &case.run_c(code), expected, elementary);
    });
}

#[test]
fn rust_gives_the_same_bits() {
    for_all_models(EquationFormat::Rust, |case, code, expected, elementary| {
        assert_same(&format!("{} in Rust", case.name), &case.run_rust(code), expected, elementary);
    });
}

#[test]
fn fortran_agrees() {
    if has_fortran() {
        for_all_models(EquationFormat::Fortran, |case, code, expected, _| {
            assert_close(&format!("{} in Fortran", case.name), &case.run_fortran(code), expected, 1e-11);
        });
    }
}

#[test]
fn python_agrees() {
    if numpy().is_some() {
        for_all_models(EquationFormat::Python, |case, code, expected, _| {
            assert_close(&format!("{} in Python", case.name), &case.run_python(code), expected, 1e-11);
        });
    }
}
