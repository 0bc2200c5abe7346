//! Large scenes: what they cost grows with the number of bodies, and their motion is right.

#[path = "../benches/performance/scenes.rs"]
#[allow(dead_code, reason = "the benchmark has more scenes")]
mod scenes;

use crate::support::run::{file, formulated};
use std::fmt::Write;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::export::xml::fmi2::model_description;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::{Engine, Program};
use cotree_fmu::taylor::Jet;
use nalgebra::{DMatrix, DVector};

const GRAVITY: f64 = 9.81;

fn program(text: &str) -> Program {
    compile(&Scene::from_toml(text).unwrap()).unwrap().program
}

/// Expressions, instructions, registers, bytes of the program and of the model description.
fn counts(text: &str) -> [usize; 5] {
    let scene = Scene::from_toml(text).unwrap();
    let expressions = formulated(&scene.resolve().unwrap()).equations.system.arena.len();
    let compiled = compile(&scene).unwrap();
    let (program, tapes) = (&compiled.program, &compiled.program.tapes);
    let tapes = [&tapes.acceleration, &tapes.constraint, &tapes.project_position, &tapes.project_velocity];
    let instructions = tapes.into_iter().map(|tape| tape.instructions().len()).sum();
    let description = model_description(&compiled.description).unwrap().len();
    [expressions, instructions, program.registers as usize, program.to_bytes().unwrap().len(), description]
}

/// Twice as many more bodies cost twice as much more, up to the digits of larger numbers.
#[test]
fn cost_grows_with_the_number_of_bodies() {
    // Indices of registers take three bytes from 16384 on, where there are about 900 bodies.
    let most = [2.2, 2.2, 2.2, 2.9, 2.2];
    for scene in [scenes::chain, scenes::four_bars] {
        let [small, middle, large] = [400, 800, 1600].map(|size| counts(&scene(size)));
        for index in 0..small.len() {
            let (first, second) = (middle[index] - small[index], large[index] - middle[index]);
            let ratio = second as f64 / first as f64;
            assert!((1.8..most[index]).contains(&ratio), "count {index}: {small:?}, {middle:?}, {large:?}");
        }
    }
}

/// What the series of a chain or a ladder keep: arms, masses between them, links, loads, coefficients, and what a step costs.
fn arm_form(text: &str) -> [usize; 6] {
    let program = program(text);
    let form = program.arms.clone().expect("an arm form");
    let (arms, coefficients) =
        (form.frames.len() + form.products.len() + form.world.len(), form.coefficients.results.len());
    let cost = Jet::new(&Model::new(program).unwrap()).expect("series").cost() as usize;
    [arms, form.coupling.len(), form.links.len(), form.loads.len(), coefficients, cost]
}

/// The arm form of long chains is as long as they are: no masses of every two bars.
#[test]
fn the_arm_form_grows_with_the_number_of_bodies() {
    for (scene, sizes) in [
        (scenes::chain as fn(usize) -> String, [20, 139, 141, 200, 2000]),
        (scenes::four_bars, [20, 70, 100, 200, 1000]),
    ] {
        let counts = sizes.map(|size| arm_form(&scene(size)));
        for index in 0..6 {
            let slope =
                |a: usize, b: usize| (counts[b][index] as f64 - counts[a][index] as f64) / (sizes[b] - sizes[a]) as f64;
            let [first, last] = [slope(0, 1), slope(3, 4)];
            assert!(last <= 1.1 * first + 0.01, "count {index}: {sizes:?} have {counts:?}");
            let cliff = slope(1, 2);
            assert!(cliff <= 1.5 * first + 1.0, "count {index}: {sizes:?} have {counts:?}");
        }
    }
}

/// Steps by series and explicit ones, on both sides of what used to be the longest chain that had an arm form.
#[test]
fn series_of_chains_of_any_length_agree_with_explicit_steps() {
    for links in [10, 50, 139, 141, 200, 1000] {
        let text = scenes::chain(links);
        let span = 0.2 / (links as f64).sqrt();
        let ends = ["auto", "explicit"].map(|method| {
            let program = program(&format!("{text}[solver]\nmethod = \"{method}\"\n"));
            let series = program.engine == Engine::Taylor;
            assert_eq!(series, method == "auto", "{links}");
            run_at(program, span, 1e-11).1
        });
        let [series, explicit] = ends.each_ref().map(|state| [state.positions(), state.rates()].concat());
        let largest = explicit.iter().fold(1.0, |largest: f64, value| largest.max(value.abs()));
        let error = series.iter().zip(&explicit).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / largest;
        assert!(error < 1e-8, "{links} bars: {error}");
    }
}

/// Bars of length and mass 1/n, one hanging from the other, by closed formulas.
struct Chain {
    length: f64,
    mass: f64,
    angles: Vec<f64>,
    rates: Vec<f64>,
}

impl Chain {
    fn new(program: &Program, state: &State) -> Self {
        let links = program.coordinates.len();
        let place = |link: usize| {
            let name = format!("b{link}.angle");
            program.coordinates.iter().position(|coordinate| coordinate.name == name).unwrap()
        };
        let of = |values: &[f64]| (0..links).map(|link| values[place(link)]).collect();
        let part = 1.0 / links as f64;
        Chain { length: part, mass: part, angles: of(state.positions()), rates: of(state.rates()) }
    }

    /// Half of its own mass, and all of what hangs from it.
    fn carried(&self, link: usize) -> f64 {
        self.mass * (0.5 + (self.angles.len() - 1 - link) as f64)
    }

    fn accelerations(&self) -> DVector<f64> {
        let (n, square) = (self.angles.len(), self.length * self.length);
        let coupling = |i: usize, j: usize| square * self.carried(i.max(j));
        let mass = DMatrix::from_fn(n, n, |i, j| match i == j {
            true => square * (self.carried(i) - self.mass * 0.5 + self.mass / 3.0),
            false => coupling(i, j) * (self.angles[i] - self.angles[j]).cos(),
        });
        let load = DVector::from_fn(n, |i, _| {
            let turning = |j: usize| coupling(i, j) * (self.angles[i] - self.angles[j]).sin() * self.rates[j].powi(2);
            let centrifugal: f64 = (0..n).filter(|&j| j != i).map(turning).sum();
            -GRAVITY * self.length * self.carried(i) * self.angles[i].cos() - centrifugal
        });
        mass.lu().solve(&load).unwrap()
    }

    fn energy(&self) -> f64 {
        let (mut at, mut speed, mut energy) = ([0.0; 2], [0.0; 2], 0.0);
        for (angle, rate) in self.angles.iter().zip(&self.rates) {
            let (sine, cosine) = angle.sin_cos();
            let half = [0.5 * self.length * cosine, 0.5 * self.length * sine];
            let moved = [-half[1] * rate, half[0] * rate];
            let [vx, vy] = [speed[0] + moved[0], speed[1] + moved[1]];
            let turning = self.mass * self.length * self.length / 12.0 * rate * rate;
            energy += 0.5 * (self.mass * (vx * vx + vy * vy) + turning) + self.mass * GRAVITY * (at[1] + half[1]);
            at = [at[0] + 2.0 * half[0], at[1] + 2.0 * half[1]];
            speed = [speed[0] + 2.0 * moved[0], speed[1] + 2.0 * moved[1]];
        }
        energy
    }
}

fn accelerations(model: &Model, state: &State) -> Vec<f64> {
    let mut machine = Machine::new(model);
    machine.load(model, state);
    let mut values = vec![0.0; model.coordinates()];
    machine.evaluate(&model.program().tapes.acceleration, &mut values);
    values
}

#[test]
fn a_long_chain_accelerates_as_the_full_mass_matrix_says() {
    let model = Model::new(program(&scenes::chain(300))).unwrap();
    let mut state = model.default_state(0.0);
    for (index, angle) in state.positions_mut().iter_mut().enumerate() {
        *angle = (0.7 * index as f64).sin();
    }
    for (index, rate) in state.rates_mut().iter_mut().enumerate() {
        *rate = (1.3 * index as f64).cos();
    }
    let expected = Chain::new(model.program(), &state).accelerations();
    let largest = expected.amax();
    let found = accelerations(&model, &state);
    for link in 0..300 {
        let name = format!("b{link}.angle");
        let place = model.program().coordinates.iter().position(|coordinate| coordinate.name == name).unwrap();
        let error = (found[place] - expected[link]).abs() / largest;
        assert!(error < 1e-9, "link {link}: {} instead of {}", found[place], expected[link]);
    }
}

fn run(program: Program, until: f64) -> (Arc<Model>, State) {
    run_at(program, until, 1e-8)
}

fn run_at(program: Program, until: f64, tolerance: f64) -> (Arc<Model>, State) {
    let model = Arc::new(Model::new(program).unwrap());
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, None, Some(tolerance)).unwrap();
    instance.initialise().unwrap();
    if until > 0.0 {
        instance.step_to(until).unwrap();
    }
    (model, instance.state().clone())
}

/// Loads and motions at both ends of a path whose mass matrix is never written out.
#[test]
fn what_is_asked_of_a_long_chain_is_what_its_links_say() {
    let names = ["j0.fx", "j0.fy", "b299.ax", "b299.ay", "b299.b.x", "b299.b.vy"];
    let text = scenes::chain(300) + &format!("[outputs]\nvariables = {names:?}\n");
    let model = Arc::new(Model::new(program(&text)).unwrap());
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, None, Some(1e-8)).unwrap();
    instance.initialise().unwrap();
    instance.step_to(0.02).unwrap();
    let found = names.map(|name| {
        let variable = model.program().variables.iter().position(|variable| variable.name == name).unwrap();
        instance.get(variable).unwrap()
    });
    let chain = Chain::new(model.program(), &instance.state());
    let accelerations = chain.accelerations();
    // Of the end of each link: acceleration, place across, and speed upwards.
    let (mut end, mut x, mut vy) = ([0.0; 2], 0.0, 0.0);
    let (mut force, mut centre) = ([0.0, 0.0], [0.0; 2]);
    for ((angle, rate), alpha) in chain.angles.iter().zip(&chain.rates).zip(&accelerations) {
        let (sine, cosine) = angle.sin_cos();
        let across = [-sine * alpha - cosine * rate * rate, cosine * alpha - sine * rate * rate];
        centre = [0, 1].map(|axis| end[axis] + 0.5 * chain.length * across[axis]);
        force = [force[0] + chain.mass * centre[0], force[1] + chain.mass * (centre[1] + GRAVITY)];
        end = [0, 1].map(|axis| end[axis] + chain.length * across[axis]);
        x += chain.length * cosine;
        vy += chain.length * cosine * rate;
    }
    let expected = [force[0], force[1], centre[0], centre[1], x, vy];
    for (name, (found, expected)) in names.iter().zip(found.iter().zip(expected)) {
        assert!((found - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{name}: {found} instead of {expected}");
    }
}

/// A spring from the ground to the end of a chain, and one along all of it: stretched as far as the end is away.
#[test]
fn springs_across_a_long_chain_pull_as_far_as_it_reaches() {
    let spring = "[loads.band]\ntype = \"spring\"\nbetween = [\"ground\", \"b99.b\"]\nstiffness = 3\nlength = 0.25\n";
    let outputs =
        "[outputs]\nvariables = [\"band.length\", \"band.rate\", \"b99.b.x\", \"b99.b.y\", \"energy.total\"]\n";
    let model = Arc::new(Model::new(program(&(scenes::chain(100) + spring + outputs))).unwrap());
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, None, Some(1e-9)).unwrap();
    instance.initialise().unwrap();
    let mut energy = Vec::new();
    for point in 0..=4 {
        if point > 0 {
            instance.step_to(0.02 * f64::from(point)).unwrap();
        }
        let of = |instance: &mut Instance, name: &str| {
            let variable = model.program().variables.iter().position(|variable| variable.name == name).unwrap();
            instance.get(variable).unwrap()
        };
        let [length, x, y] = ["band.length", "b99.b.x", "b99.b.y"].map(|name| of(&mut instance, name));
        assert!((length - x.hypot(y)).abs() < 1e-12);
        let own = Chain::new(model.program(), &instance.state()).energy() + 1.5 * (length - 0.25).powi(2);
        assert!((of(&mut instance, "energy.total") - own).abs() < 1e-10);
        energy.push(own);
    }
    energy.iter().for_each(|after| assert!((after - energy[0]).abs() < 1e-7 * energy[0].abs(), "{energy:?}"));
}

#[test]
fn a_long_chain_keeps_its_energy() {
    let energy = |until: f64| {
        let (model, state) = run(program(&scenes::chain(300)), until);
        Chain::new(model.program(), &state).energy()
    };
    let (before, after) = (energy(0.0), energy(0.05));
    assert!((after - before).abs() < 1e-7 * before.abs(), "{before} became {after}");
}

/// Upright bars that are tied together turn as one: (n + 1) of them about their pivots, and n ties with the speed of their ends.
#[test]
fn many_four_bars_turn_as_one() {
    let loops = 300;
    let (model, state) = run(program(&scenes::four_bars(loops)), 0.1);
    let program = model.program();
    assert_eq!((program.coordinates.len(), model.active().len()), (2 * loops + 1, 2 * loops));
    let place = |name: &str| program.coordinates.iter().position(|coordinate| coordinate.name == name).unwrap();
    let angle = state.positions()[place("v0.angle")];
    let (bars, ties) = (loops as f64 + 1.0, loops as f64);
    let inertia = bars / 3.0 + ties;
    let expected = -GRAVITY * (bars / 2.0 + ties) * angle.cos() / inertia;
    let found = accelerations(&model, &state);
    for index in 0..=loops {
        let bar = place(&format!("v{index}.angle"));
        assert!((state.positions()[bar] - angle).abs() < 1e-9);
        assert!((found[bar] - expected).abs() < 1e-6 * expected.abs(), "{} instead of {expected}", found[bar]);
    }
    for index in 1..=loops {
        assert!(found[place(&format!("h{index}.angle"))].abs() < 1e-6);
    }
    let energy = |angle: f64, rate: f64| 0.5 * inertia * rate * rate + GRAVITY * (bars / 2.0 + ties) * angle.sin();
    let before = energy(std::f64::consts::FRAC_PI_2, 1.0);
    let after = energy(angle, state.rates()[place("v0.angle")]);
    assert!((after - before).abs() < 1e-7 * before, "{before} became {after}");
}

/// Bars that turn so far in a step that a singular pose could be in it take the steps of 1e-6 at every coarser tolerance; what stays clear of such poses takes fewer. Five loops were
/// half as slow again at 1e-5, for three poses were looked at in each step.
#[test]
fn coarser_tolerances_take_no_more_work() {
    let cases = [
        (scenes::four_bars(1), 10.0),
        (scenes::four_bars(5), 10.0),
        (scenes::four_bars(40), 3.0),
        (file("models/bench_slider_crank/scene.toml"), 10.0),
        (file("models/andrews/scene.toml"), 0.03),
    ];
    for (scene, stop) in cases {
        let model = Arc::new(Model::new(program(&scene)).unwrap());
        let work = |tolerance: f64| {
            let mut instance = Instance::new(model.clone());
            instance.setup(0.0, Some(stop), Some(tolerance)).unwrap();
            instance.initialise().unwrap();
            instance.step_to(stop).unwrap();
            let done = instance.statistics();
            done.steps + done.rejected + done.evaluations
        };
        let fine = work(1e-6);
        for tolerance in [1e-3, 1e-4, 1e-5] {
            let coarse = work(tolerance);
            // The step after which this is known is taken twice.
            assert!(coarse <= fine + fine / 20, "{tolerance:e}: {coarse} {fine}: {scene}");
        }
    }
}

/// Equal legs carry one table: the loops have two coordinates in common, and the elimination fills all of the matrix.
fn table(legs: usize) -> String {
    let place = |leg: usize| 0.02 * leg as f64;
    let mut text = String::from("format = 1\nname = \"table\"\ngravity = [0, -9.81]\n[ground.points]\n");
    (0..legs).for_each(|leg| writeln!(text, "p{leg} = [{:?}, 0]", place(leg)).unwrap());
    text += "[bodies.top]\nmass = 1\ninertia = 1\n[bodies.top.points]\n";
    (0..legs).for_each(|leg| writeln!(text, "q{leg} = [{:?}, 0]", place(leg)).unwrap());
    for leg in 0..legs {
        let joint =
            |name: &str, between: &str| format!("[joints.{name}{leg}]\ntype = \"revolute\"\nbetween = [{between}]\n");
        text += &format!("[bodies.l{leg}]\nmass = 1\ninertia = 0.1\npoints = {{ a = [-0.5, 0], b = [0.5, 0] }}\n");
        text += &joint("foot", &format!("\"ground.p{leg}\", \"l{leg}.a\""));
        text += &joint("head", &format!("\"l{leg}.b\", \"top.q{leg}\""));
    }
    text += "[initial]\n\"l0.angle\" = \"80 deg\"\n\"top.angle\" = { guess = 0 }\n";
    (1..legs).for_each(|leg| writeln!(text, "\"l{leg}.angle\" = {{ guess = \"80 deg\" }}").unwrap());
    text
}

#[test]
fn what_depends_on_each_other_too_much_is_refused() {
    assert!(compile(&Scene::from_toml(&table(20)).unwrap()).is_ok());
    let faults = compile(&Scene::from_toml(&table(400)).unwrap()).unwrap_err();
    let codes: Vec<&str> = faults.list.iter().map(|fault| fault.code).collect();
    assert_eq!(codes, ["scene::too_large"]);
    insta::assert_snapshot!("too_connected", faults.render(false, 100));
}
