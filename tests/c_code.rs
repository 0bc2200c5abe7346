//! The C of `show --equations c` compiles alone, without a warning, and gives the very bits of the kernels.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cotree::equations::Equations;
use cotree::expr::{Expr, Symbol};
use cotree::scene::Scene;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_text::written::{self, EquationFormat};

use crate::support::point::value;
use crate::support::random::Random;
use crate::support::run::{RUBBING, formulated, models, scene_of, sound};

const POINTS: usize = 100;

#[test]
fn compiled_equations_have_the_bits_of_the_kernels() {
    let folder = tempfile::tempdir().unwrap();
    // Friction that sticks has no functions.
    for name in models().iter().filter(|name| !RUBBING.contains(&name.as_str())) {
        check(name, folder.path());
    }
}

fn check(model: &str, folder: &Path) {
    let scene = sound(Scene::from_toml(&scene_of(model)));
    let resolved = scene.resolve().unwrap();
    let name = &resolved.mechanism.name;
    let mut formulated = formulated(&resolved);
    let model = Model::new(formulated.lowered.program.clone()).unwrap();
    let loops: Vec<usize> = formulated.equations.loops().map(|(index, _)| index).collect();
    let scene_parameters = resolved.mechanism.parameters.len();
    let sizes = Sizes::new(&model, scene_parameters, &formulated.lowered.solved, loops.len());
    let code = written::equations(&scene, EquationFormat::C).unwrap() + &sizes.driver(name);
    // The C library's power and arc cosine are others than ours: both are right to about a unit of the last place.
    let exact = !["pow(", "acos("].iter().any(|function| code.contains(function));
    let program = compile(name, &code, folder);

    let results = results(&mut formulated.equations);
    let mut random = Random(7);
    let points: Vec<State> = (0..POINTS).map(|_| random_point(&model, &formulated.state, &mut random)).collect();
    let lines: Vec<String> = points.iter().map(|state| sizes.line(state)).collect();
    let output = run(&program, &lines.join(""));
    let mut found = output.split_whitespace().map(|word| u64::from_str_radix(word, 16).unwrap());
    for state in &points {
        let mut machine = Machine::new(&model);
        machine.load(&model, state);
        let tape = &model.program().tapes.acceleration;
        machine.run(tape);
        // Behind the accelerations the reactions, of which those of equations that say nothing are not printed.
        let n = sizes.coordinates;
        let printed = |index: &usize| index.checked_sub(n).is_none_or(|reaction| loops.contains(&reaction));
        // Printed equations of a driven mechanism end with its loop equations.
        let kernels = tape.results(machine.registers()).enumerate().filter(|_| !formulated.lowered.solved.is_empty());
        let kernels: Vec<f64> = kernels.filter(|(index, _)| printed(index)).map(|(_, value)| value).collect();
        let values = |symbol: Symbol| value(model.layout(), state.registers(), symbol);
        let equations = formulated.equations.system.arena.evaluate(&results, &values);
        for (index, expected) in equations.into_iter().chain(kernels).enumerate() {
            let bits = found.next().expect("the program printed all results");
            let found = f64::from_bits(bits);
            let same = if exact { bits == expected.to_bits() } else { is_close(found, expected) };
            assert!(same, "{}, result {index}: {found:?} instead of {expected:?}", name);
        }
    }
    assert_eq!(found.next(), None);
}

/// Do they agree to rounding errors of a few operations?
fn is_close(found: f64, expected: f64) -> bool {
    // A power of a negative number is none for both.
    found.is_nan() && expected.is_nan() || (found - expected).abs() <= 1e-13 * expected.abs().max(1.0)
}

/// Everything that `NAME_equations` computes, in the order of its arguments. A scene without masses has no M and Q.
fn results(equations: &mut Equations) -> Vec<Expr> {
    let dynamics = equations.dynamics().clone();
    let (n, m) = (equations.coordinates.len(), equations.loops().count());
    let dense = |row: &Vec<(usize, Expr)>| {
        let entry = |column| row.iter().find(|(at, _)| *at == column).map_or(Expr::ZERO, |(_, entry)| *entry);
        (0..n).map(entry).collect::<Vec<_>>()
    };
    let mut results: Vec<Expr> = dynamics.mass.iter().flat_map(dense).chain(dynamics.load).collect();
    let symbols = equations.system.arena.symbols(results.iter().copied());
    if symbols.iter().any(|symbol| matches!(symbol, Symbol::Missing(..))) {
        results = vec![Expr::ZERO; n * n + n];
    }
    let gaps = equations.gaps();
    let rows: Vec<_> = equations.loops().map(|(_, row)| row).collect();
    results.extend(equations.loops().map(|(index, _)| gaps[index]));
    results.extend(rows.iter().flat_map(|row| dense(&row.jacobian)));
    results.extend(rows.iter().map(|row| row.time_rate));
    results.extend(rows.iter().map(|row| row.gamma));
    assert_eq!(results.len(), n * n + n + 3 * m + m * n);
    results
}

/// Anywhere: the loops are open and the parameters are not the scene's.
fn random_point(model: &Model, start: &State, random: &mut Random) -> State {
    let mut state = start.clone();
    let first_signal = model.layout().inputs();
    state.parameters_mut().iter_mut().for_each(|p| *p *= random.number(0.5, 1.5));
    state.registers_mut()[first_signal..].iter_mut().for_each(|x| *x = random.number(-4.0, 4.0));
    state.registers_mut()[0] = random.number(0.0, 3.0);
    state
}

struct Sizes {
    parameters: usize,
    discrete: usize,
    /// Initial values that can be set: parameters of the program alone.
    starts: usize,
    inputs: usize,
    followers: usize,
    coordinates: usize,
    /// How many of the coordinates are integrals of states.
    states: usize,
    constraints: usize,
    accelerations: bool,
}

impl Sizes {
    fn new(model: &Model, scene_parameters: usize, solved: &[Expr], constraints: usize) -> Self {
        let program = model.program();
        Sizes {
            parameters: scene_parameters,
            discrete: program.discrete.len(),
            starts: program.parameters.len() - scene_parameters,
            inputs: program.inputs.len(),
            followers: program.followers.len(),
            coordinates: program.coordinates.len(),
            states: program.states as usize,
            constraints,
            accelerations: !solved.is_empty(),
        }
    }

    /// A C program that reads arguments and prints results, all as the bits of doubles in hexadecimal.
    fn driver(&self, name: &str) -> String {
        let (n, m) = (self.coordinates - self.states, self.constraints);
        let all = self.coordinates;
        let offsets = [1, self.parameters + self.discrete, 3 * self.inputs, 3 * self.followers, all, all];
        let starts: Vec<usize> =
            offsets.iter().scan(0, |sum, size| Some(std::mem::replace(sum, *sum + size))).collect();
        let mut arguments = format!(
            "in[0], in + {}, in + {}, in + {}, in + {}, in + {}",
            starts[1], starts[2], starts[3], starts[4], starts[5]
        );
        if self.states > 0 {
            let _ = write!(arguments, ", in + {}", starts[5] + n);
        }
        let (matrices, rates) =
            ([("M", n * n), ("Q", n), ("Phi", m), ("Phi_q", m * n), ("Phi_t", m)], ("dz", self.states));
        let arrays = [&matrices[..], &[("gamma", m), ("a", n), rates, ("lambda", m)]].concat();
        let used = if self.accelerations { 9 } else { 6 };
        let mut body = String::new();
        for (array, size) in &arrays[..used] {
            let _ = writeln!(body, "        double {array}[{}] = {{0}};", (*size).max(1));
        }
        let _ = writeln!(body, "        {name}_equations({arguments}, M, Q, Phi, Phi_q, Phi_t, gamma);");
        if self.accelerations {
            let _ = writeln!(body, "        {name}_accelerations({arguments}, a, lambda);");
        }
        if self.states > 0 {
            let _ = writeln!(body, "        {name}_states({arguments}, dz);");
        }
        for (array, size) in &arrays[..used] {
            let _ = writeln!(body, "        print({array}, {size});");
        }
        format!(
            r#"
#include <inttypes.h>
#include <stdio.h>

static void print(const double *x, int count)
{{
    for (int i = 0; i < count; i++) {{
        uint64_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        printf("%" PRIx64 "\n", bits);
    }}
}}

int main(void)
{{
    double in[{inputs}];
    for (;;) {{
        for (int i = 0; i < {inputs}; i++) {{
            uint64_t bits;
            if (scanf("%" SCNx64, &bits) != 1)
                return 0;
            memcpy(&in[i], &bits, sizeof bits);
        }}
{body}    }}
}}
"#,
            inputs = offsets.iter().sum::<usize>()
        )
    }

    /// The arguments at a state: inputs and followers come with their value, rate and acceleration side by side.
    fn line(&self, state: &State) -> String {
        let registers = state.registers();
        let discrete = 1 + self.parameters + self.starts;
        let signals = discrete + self.discrete;
        let followers = signals + 3 * self.inputs;
        let motion = followers + 3 * self.followers;
        let triples = |first: usize, count: usize| {
            (0..count).flat_map(move |i| (0..3).map(move |order| first + order * count + i))
        };
        let places = (0..=self.parameters)
            .chain(discrete..signals)
            .chain(triples(signals, self.inputs))
            .chain(triples(followers, self.followers))
            .chain(motion..motion + 2 * self.coordinates);
        places.map(|place| format!("{:x}\n", registers[place].to_bits())).collect()
    }
}

fn compile(name: &str, code: &str, folder: &Path) -> PathBuf {
    let (source, program) = (folder.join(format!("{name}.c")), folder.join(name));
    std::fs::write(&source, code).unwrap();
    let mut gcc = Command::new("gcc");
    gcc.args(["-O2", "-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-o"]);
    let output = gcc.arg(&program).arg(&source).arg("-lm").output().unwrap_or_else(|error| {
        panic!("gcc cannot be started ({error}): this test compiles C, install a C compiler named gcc (Debian: apt install gcc libc6-dev)")
    });
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    program
}

fn run(program: &Path, input: &str) -> String {
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_string();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}
