//! Linkages whose bars almost lie in line: whether branches meet there is geometry, whatever the tolerance.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::support::hard::four_bar::{FourBar, bar, nearly_neutral, neutral};
use crate::support::one_freedom::{Linkage, Motion};
use cotree::compile::compile;
use cotree::scene::{Body, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::program::arm_form::MAX_ORDER;
use cotree_fmu::taylor::Jet;

const STOP: f64 = 1.2;
const POINTS: u32 = 24;
/// What is left of the digits of a reference behind a pose with the smallest defect.
const ROUNDING: f64 = 1e-7;

/// A linkage with what is read of it.
struct Case {
    name: String,
    linkage: Linkage,
    scene: Scene,
    start: [f64; 3],
    rate: f64,
    read: [&'static str; 3],
}

fn four_bar(name: &str, bars: FourBar) -> Case {
    let [coupler, rocker] = bars.angles();
    let read = ["crank.angle", "coupler.angle", "rocker.angle"];
    let start = [bars.angle, coupler, rocker];
    Case {
        name: name.to_owned(),
        linkage: Linkage::FourBar(bars),
        scene: bars.scene("nearly"),
        start,
        rate: bars.omega,
        read,
    }
}

/// A crank and a rod of almost equal lengths: the slider's pin comes close to the crank's axle.
fn slider([crank, rod]: [f64; 2], angle: f64, rate: f64) -> Case {
    let (masses, gravity) = ([1.0, 0.7, 0.4], 9.81);
    let turned = -(crank * angle.sin() / rod).asin();
    let place = crank * angle.cos() + rod * turned.cos();
    let scene = Scene::new("slider")
        .gravity([0.0, -gravity])
        .ground_point("axle", [0.0, 0.0])
        .body("crank", bar(masses[0], crank))
        .body("rod", bar(masses[1], rod))
        .body("slider", Body::new().mass(masses[2]).point("pin", [0.0, 0.0]))
        .revolute("main", "ground.axle", "crank.a")
        .revolute("crank_pin", "crank.b", "rod.a")
        .revolute("slider_pin", "rod.b", "slider.pin")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", angle)
        .initial("crank.omega", rate)
        .guess("rod.angle", turned)
        .guess("slider.x", place);
    let read = ["crank.angle", "rod.angle", "slider.x"];
    let linkage = Linkage::Slider { crank, rod, masses, gravity };
    let name = format!("slider {crank} {rod} from {angle}");
    Case { name, linkage, scene, start: [angle, turned, place], rate, read }
}

fn cases(defect: f64) -> Vec<Case> {
    let fast = |bars: FourBar| FourBar { omega: 8.0, ..bars };
    let parallelogram = fast(FourBar { coupler: 2.0 - defect, ..FourBar::new(1.0, 2.0, 1.0, 2.0) });
    let kite = fast(FourBar { rocker: 1.5 - defect, ..FourBar::new(0.8, 1.5, 1.5, 0.8) });
    let mut cases = vec![
        four_bar(&format!("parallelogram {defect:e}"), parallelogram),
        four_bar(&format!("kite {defect:e}"), kite),
        slider([1.0, 1.0 - defect], 0.6, 8.0),
    ];
    cases.extend((0..6).map(|seed| four_bar(&format!("four-bar {seed} {defect:e}"), nearly_neutral(seed, defect))));
    cases
}

impl Case {
    fn model(&self) -> Arc<Model> {
        let scene = self.read.into_iter().fold(self.scene.clone(), |scene, name| scene.output(name));
        let compiled = compile(&scene.stop(STOP)).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
        Arc::new(Model::new(compiled.program).expect("a sound program"))
    }

    /// The coordinates as the curve has them; none if the motion turns back.
    fn expected(&self) -> Option<Vec<[f64; 3]>> {
        let mut motion = Motion::new(self.linkage, self.start, self.rate);
        (1..=POINTS).map(|point| motion.at(time(point))).collect()
    }

    /// The largest difference, and how many poses were passed as exact though they are not.
    fn run(
        &self,
        model: &Arc<Model>,
        engine: Option<Engine>,
        tolerance: f64,
        expected: &[[f64; 3]],
    ) -> Result<(f64, usize), String> {
        let mut instance = Instance::new(model.clone());
        instance.setup(0.0, Some(STOP), Some(tolerance)).expect("times");
        if let Some(engine) = engine {
            instance.set_engine(engine).expect("not begun");
        }
        instance.initialise().map_err(|error| error.to_string())?;
        let (mut worst, mut told): (f64, usize) = (0.0, 0);
        for (point, expected) in (1..).zip(expected) {
            instance.step_to(time(point)).map_err(|error| error.to_string())?;
            told += instance.take_passages().iter().filter(|passage| passage.is_inexact()).count();
            for (name, expected) in self.read.iter().zip(expected) {
                let variable = instance.variable(name).expect("an output");
                worst = worst.max((instance.get(variable).expect("defined") - expected).abs());
            }
        }
        Ok((worst, told))
    }
}

fn time(point: u32) -> f64 {
    STOP * f64::from(point) / f64::from(POINTS)
}

/// What came of runs at one defect and by one method.
#[derive(Debug, Default)]
struct Count {
    runs: usize,
    /// Further from the curve than a thousand tolerances, with a warning and without.
    told: usize,
    wrong: Vec<String>,
    refused: Vec<String>,
}

impl Count {
    /// Runs a linkage at a tolerance.
    fn note(&mut self, case: &Case, model: &Arc<Model>, engine: Option<Engine>, tolerance: f64, expected: &[[f64; 3]]) {
        self.runs += 1;
        let run = format!("{engine:?}, {} at {tolerance:e}", case.name);
        match case.run(model, engine, tolerance, expected) {
            Ok((worst, _)) if worst <= 1000.0 * tolerance + ROUNDING => {}
            Ok((_, told)) if told > 0 => self.told += 1,
            Ok((worst, _)) => self.wrong.push(format!("{run}: {worst:e}")),
            Err(message) => self.refused.push(format!("{run}: {message}")),
        }
    }
}

/// Runs a sample of the grid of defects and tolerances; each linkage at each defect at some of the tolerances.
fn sample(engine: Option<Engine>, power: i32, tolerances: impl Iterator<Item = i32> + Clone) -> Count {
    let mut count = Count::default();
    for (place, defect) in [1.0, -1.0].map(|sign| sign * 10.0_f64.powi(-power)).into_iter().enumerate() {
        for (number, case) in cases(defect).into_iter().enumerate() {
            let Some(expected) = case.expected() else { continue };
            let model = case.model();
            for digits in tolerances.clone().filter(|digits| (*digits as usize + number + place).is_multiple_of(3)) {
                count.note(&case, &model, engine, 10.0_f64.powi(-digits), &expected);
            }
        }
    }
    count
}

/// Whatever the tolerance, bars that miss each other turn off where they do, and what is passed as if they met is said to be.
#[test]
fn a_defect_of_lengths_is_followed_at_every_tolerance() {
    for power in 3..=9 {
        let count = sample(None, power, 3..=11);
        assert!(count.runs > 30 && count.wrong.is_empty() && count.told == 0, "1e-{power}: {count:?}");
        assert!(count.refused.is_empty(), "1e-{power}: {count:?}");
    }
}

#[test]
fn the_smallest_defects_are_followed_or_told_or_refused() {
    for power in 10..=11 {
        let count = sample(None, power, 4..=9);
        assert!(count.runs > 30 && count.wrong.is_empty(), "1e-{power}: {count:?}");
        assert!(5 * count.refused.len() < count.runs, "1e-{power}: {count:?}");
        assert!(count.told > 0, "1e-{power}: {count:?}");
    }
}

/// At coarse tolerances a step is as long as the way between poses. Starts and defects that no constant was chosen by.
#[test]
fn long_steps_leap_over_no_pose_wherever_they_begin() {
    let mut count = Count::default();
    for (place, defect) in [3e-6, 3e-7, -3e-7, 3e-8, -3e-8, 3e-9, -3e-9].into_iter().enumerate() {
        for start in 0..12 {
            let angle = 0.43 + 0.07 * f64::from(start) + 0.01 * place as f64;
            let bars = FourBar { coupler: 2.0 - defect, omega: 8.0, angle, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
            let case = four_bar(&format!("parallelogram {defect:e} from {angle}"), bars);
            let Some(expected) = case.expected() else { continue };
            let model = case.model();
            for tolerance in [1e-3, 1e-4, 1e-5] {
                count.note(&case, &model, None, tolerance, &expected);
            }
        }
    }
    assert!(count.runs > 180 && count.wrong.is_empty(), "{count:?}");
    assert!(count.told == 0 && count.refused.is_empty(), "{count:?}");
}

/// The same of other shapes and lengths, sliders among them.
#[test]
fn long_steps_leap_over_no_pose_of_other_shapes() {
    let mut count = Count::default();
    for (place, defect) in [8e-6, -2e-6, 5e-7, -6e-8, 7e-9].into_iter().enumerate() {
        for start in 0..7 {
            let angle = 0.39 + 0.11 * f64::from(start) + 0.013 * place as f64;
            let bars = |sides: [f64; 4], omega: f64| {
                let [crank, coupler, rocker, base] = sides;
                FourBar { omega, angle, ..FourBar::new(crank, coupler - defect, rocker, base) }
            };
            let shapes = [([0.7, 1.3, 0.7, 1.3], 7.0), ([0.6, 1.1, 1.1, 0.6], 6.0), ([0.5, 1.4, 1.2, 2.1], 11.0)];
            let mut cases: Vec<Case> = shapes
                .map(|(sides, omega)| four_bar(&format!("{sides:?} {defect:e} {angle}"), bars(sides, omega)))
                .into();
            cases.push(slider([0.8 + defect, 0.8], angle, 9.0));
            for case in cases {
                let Some(expected) = case.expected() else { continue };
                let model = case.model();
                for tolerance in [1e-3, 1e-4, 1e-5] {
                    count.note(&case, &model, None, tolerance, &expected);
                }
            }
        }
    }
    assert!(count.runs > 250 && count.wrong.is_empty(), "{count:?}");
    assert!(count.told == 0 && count.refused.is_empty(), "{count:?}");
}

/// Bars that turn as far as to the pose in which they are in line may have come by it, and bars that turn by a small part of that have not: the angles of that
/// pose are known, with the signs of the lengths that add up to nothing.
#[test]
fn a_pose_is_clear_of_another_until_arms_have_turned_as_far() {
    for seed in 0..40 {
        let bars = neutral(seed);
        let sides = [bars.crank, bars.coupler, -bars.rocker];
        let mut signs = (0..8).map(|bits| [0, 1, 2].map(|bar| if (bits >> bar) & 1 == 0 { 1.0 } else { -1.0 }));
        let in_line = |signs: &[f64; 3]| {
            (sides.iter().zip(signs).map(|(side, sign)| side * sign).sum::<f64>() - bars.base).abs() < 1e-12
        };
        let flat = signs.find(in_line).expect("bars that can lie in line").map(f64::acos);
        let case = four_bar("neutral", bars);
        let model = case.model();
        let mut machine = Machine::new(&model);
        machine.load(&model, &model.default_state(0.0));
        let mut jet = Jet::new(&model).expect("an arm form");
        let mut changes = jet.changes();
        let unknowns = |jet: &mut Jet, angles: [f64; 3]| {
            let motion: Vec<f64> = angles.into_iter().chain([0.0; 3]).collect();
            let regular = jet.begin(&model, machine.registers(), &motion).is_ok();
            let form = model.program().arms.as_ref().expect("an arm form");
            let mut values = vec![0.0; Jet::room(&model, form) / (MAX_ORDER + 1)];
            jet.write_polynomial(0, &mut values);
            (regular, values)
        };
        let [coupler, rocker] = bars.angles();
        let turn = |from: f64, to: f64| from + (to - from - TAU * ((to - from) / TAU).round());
        let there = [0, 1, 2].map(|bar| turn([bars.angle, coupler, rocker][bar], flat[bar]));
        let (singular, there) = unknowns(&mut jet, there);
        let (regular, here) = unknowns(&mut jet, [bars.angle, coupler, rocker]);
        assert!(regular && !singular, "{seed}: {regular} {singular}");
        let mut is_clear = |share: f64| {
            let way = here.iter().zip(&there).map(|(here, there)| share * (there - here));
            let polynomial: Vec<f64> = here.iter().copied().chain(way).collect();
            jet.stays_clear(&mut changes, (&polynomial, 1), 1.0)
        };
        assert!(!is_clear(1.0) && is_clear(0.1), "{seed}: {bars:?}");
    }
}

/// Methods that are named do not pass such places: they follow what is wide enough, and stop at the rest instead of taking the wrong branch.
#[test]
fn named_methods_follow_a_defect_or_stop_at_it() {
    for (engine, power) in [Engine::Dop853, Engine::Radau].into_iter().flat_map(|own| (3..=9).map(move |k| (own, k))) {
        let count = sample(Some(engine), power, 3..=8);
        assert!(count.wrong.is_empty() && count.told == 0, "1e-{power}: {count:?}");
        assert!(count.refused.iter().all(|refusal| refusal.contains("singular configuration")), "{:?}", count.refused);
    }
}
