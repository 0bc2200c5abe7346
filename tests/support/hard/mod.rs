//! Mechanisms through singular poses and other hard cases, each with what must hold of its motion.

mod branched;
mod change_points;
pub mod closed_form;
mod cranks;
mod driven;
pub mod dyad;
pub mod families;
mod far_starts;
mod flaps;
pub mod four_bar;
mod jansen;
pub mod law;
mod others;
mod pieces;
mod poles;
#[path = "../split_mix.rs"]
pub mod random;
pub mod reference;
mod steep;
mod switches_at_poses;
mod switching;
mod twofold;
mod unlike;

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::time::Instant;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

use change_points::{coupled, equal_slider_crank, loops, redundant, starts};
use four_bar::{FourBar, nearly_neutral, neutral};
use jansen::jansen;
use law::{Angle, Law, Watch};
use others::{andrews, free_floating, lock_up, lock_up_with_freedom, no_freedom, slider_crank, stiff};
use random::Random;
use reference::Reference;

/// A scene and what must come out.
pub struct Case {
    /// Row of the table.
    pub family: &'static str,
    pub scene: Scene,
    pub stop: f64,
    pub laws: Vec<Law>,
    /// Nothing drives or brakes it.
    pub conservative: bool,
    /// Part of its error that the scene must say, if it must end with one.
    pub refusal: Option<&'static str>,
    /// Parts of errors that it may end with instead of its motion.
    pub may_refuse: &'static [&'static str],
    pub tolerances: &'static [f64],
    /// The motion by an independent method.
    pub reference: Option<Reference>,
    /// How many tolerances an error may be, and how much besides: what rounding errors make of the motion.
    pub within: [f64; 2],
    pub input: Option<Input>,
}

/// An input that jumps.
pub struct Input {
    pub name: &'static str,
    /// How long each of the values lasts [s].
    pub period: f64,
    pub values: Vec<f64>,
}

/// How a run is asked for results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Points {
    /// At equal steps.
    Even(u32),
    /// At steps of very different lengths.
    Uneven(u32),
    /// At steps of this length [s].
    Every(f64),
}

/// What came of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Passed(Figures),
    /// On another branch, or with another energy.
    Lost(String),
    Failed(String),
    Refused(String),
}

/// What was measured in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Relative to the largest energy of motion.
    pub drift: f64,
    pub residual: f64,
    /// Against the reference, if there is one.
    pub error: f64,
    pub microseconds: f64,
    pub steps: u64,
    pub fallbacks: u64,
}

pub const ALL_TOLERANCES: [f64; 11] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];

/// Of cases with a reference.
const COMPARED_TOLERANCES: [f64; 10] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];

/// An energy that changes more than this is another motion.
const OTHER_MOTION: f64 = 0.2;

impl Case {
    /// Nothing drives or brakes it, unless said.
    pub fn new(family: &'static str, scene: Scene, stop: f64, laws: Vec<Law>) -> Self {
        Self {
            family,
            scene: scene.stop(stop),
            stop,
            laws,
            conservative: true,
            refusal: None,
            may_refuse: &[],
            tolerances: &ALL_TOLERANCES,
            reference: None,
            within: [1000.0, 1e-9],
            input: None,
        }
    }

    /// What must come out.
    pub fn against(mut self, reference: Reference) -> Self {
        self.reference = Some(reference);
        self.at(&COMPARED_TOLERANCES)
    }

    /// An error of the reference's variables of more than so many tolerances, and `more`, is a wrong result.
    pub fn within(mut self, tolerances: f64, more: f64) -> Self {
        self.within = [tolerances, more];
        self
    }

    pub fn input(mut self, input: Input) -> Self {
        self.input = Some(input);
        self
    }

    pub fn at(mut self, tolerances: &'static [f64]) -> Self {
        self.tolerances = tolerances;
        self
    }

    pub fn driven(mut self) -> Self {
        self.conservative = false;
        self
    }

    pub fn refused(mut self, message: &'static str) -> Self {
        self.refusal = Some(message);
        self
    }

    /// The model of a scene that has one.
    pub fn expect_model(&self) -> Arc<Model> {
        self.model().unwrap_or_else(|fault| panic!("{}: {fault}", self.scene.name.text))
    }

    /// The model, or why there is none.
    pub fn model(&self) -> Result<Arc<Model>, String> {
        let names = ["energy.total", "energy.kinetic", "constraint.position"].map(String::from);
        let laws = self.laws.iter().flat_map(Law::variables);
        let compared = self.reference.iter().flat_map(|reference| reference.names.iter().cloned());
        let outputs: BTreeSet<String> = names.into_iter().chain(laws).chain(compared).collect();
        let known = |name: &str| self.scene.outputs.variables.iter().any(|known| known.text == name);
        let scene =
            outputs.iter().filter(|name| !known(name)).fold(self.scene.clone(), |scene, name| scene.output(name));
        let compiled = compile(&scene).map_err(|faults| faults.render(false, 100))?;
        Ok(Arc::new(Model::new(compiled.program).map_err(|fault| fault.to_string())?))
    }

    /// Runs it to its end.
    pub fn run(&self, model: &Arc<Model>, engine: Option<Engine>, tolerance: f64, points: Points) -> Outcome {
        match self.follow(model, engine, tolerance, points) {
            Ok(outcome) => outcome,
            Err(error) if self.refusal.iter().chain(self.may_refuse).any(|part| error.contains(part)) => {
                Outcome::Refused(error)
            }
            Err(error) => Outcome::Failed(error),
        }
    }

    fn follow(
        &self,
        model: &Arc<Model>,
        engine: Option<Engine>,
        tolerance: f64,
        points: Points,
    ) -> Result<Outcome, String> {
        let mut instance = Instance::new(model.clone());
        instance.setup(0.0, Some(self.stop), Some(tolerance)).map_err(|error| error.to_string())?;
        if let Some(engine) = engine {
            instance.set_engine(engine).map_err(|error| error.to_string())?;
        }
        let mut figures = Figures::default();
        self.set_input(&mut instance, 0.0)?;
        instance.initialise().map_err(|error| error.to_string())?;
        let mut watch = Watch::new(self, &mut instance)?;
        for time in self.times(points) {
            let start = Instant::now();
            instance.step_to(time).map_err(|error| error.to_string())?;
            figures.microseconds += start.elapsed().as_secs_f64() * 1e6;
            if let Some(lost) = watch.look(&mut instance)? {
                return Ok(Outcome::Lost(format!("t = {time:.4}: {lost}")));
            }
            figures.error = figures.error.max(self.error(&mut instance, time)?);
            // What a run warns of is no wrong result.
            let warned = if instance.attainable_accuracy() > tolerance { instance.attainable_accuracy() } else { 0.0 };
            let most = self.within[0] * (tolerance + warned) + self.within[1];
            if figures.error > most {
                return Ok(Outcome::Lost(format!("t = {time:.4}: off by {:.1e}", figures.error)));
            }
            self.set_input(&mut instance, time)?;
        }
        (figures.drift, figures.residual) = (if self.conservative { watch.drift() } else { 0.0 }, watch.residual);
        (figures.steps, figures.fallbacks) = (instance.statistics().steps, instance.statistics().fallbacks);
        if self.conservative && figures.drift > OTHER_MOTION {
            return Ok(Outcome::Lost(format!("the energy changes by {:.1e}", figures.drift)));
        }
        match self.refusal {
            Some(part) => Ok(Outcome::Failed(format!("runs to its end instead of refusing with `{part}`"))),
            None => Ok(Outcome::Passed(figures)),
        }
    }

    /// When results are read: where they are asked for, where they are compared, and where an input jumps.
    fn times(&self, points: Points) -> Vec<f64> {
        let stop = self.stop;
        let mut times = match points {
            Points::Even(count) => even(count, stop),
            Points::Every(step) => (1..).map(|k| f64::from(k) * step).take_while(|&time| time < stop).collect(),
            Points::Uneven(count) => {
                let mut random = Random(u64::from(count));
                (1..count).map(|_| stop * random.unit().powf(0.7)).collect()
            }
        };
        let jumps = self.input.iter().flat_map(|input| (1..input.values.len()).map(|k| k as f64 * input.period));
        let compared = self.reference.iter().flat_map(|reference| reference.times.iter().copied());
        times.extend(jumps.chain(compared).filter(|&time| time < stop).chain([stop]));
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Sets the input where it jumps.
    fn set_input(&self, instance: &mut Instance, time: f64) -> Result<(), String> {
        let Some(input) = &self.input else { return Ok(()) };
        let index = (time / input.period).round();
        let jumps = time == index * input.period;
        let Some(&value) = input.values.get(index as usize).filter(|_| jumps) else { return Ok(()) };
        let variable = instance.variable(input.name).ok_or("no such input")?;
        instance.set(variable, value).map_err(|error| error.to_string())
    }

    /// The error at this time, if results are compared there.
    fn error(&self, instance: &mut Instance, time: f64) -> Result<f64, String> {
        let Some(reference) = &self.reference else { return Ok(0.0) };
        let Some(index) = reference.times.iter().position(|&known| known == time) else { return Ok(0.0) };
        let found = reference.names.iter().map(|name| law::get(instance, name));
        Ok(reference.error(index, &found.collect::<Result<Vec<f64>, String>>()?))
    }
}

fn even(count: u32, stop: f64) -> Vec<f64> {
    (1..=count).map(|k| stop * f64::from(k) / f64::from(count)).collect()
}

/// The whole set: families with so many members each.
pub fn cases(members: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let parallelogram = FourBar { omega: 5.0, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
    for seed in 0..members {
        let mut random = Random(1000 + seed);
        let omega = random.between(2.0, 9.0);
        let angle = random.between(0.4, 2.6);
        cases.push(FourBar { omega, angle, ..parallelogram }.case("parallelogram", "parallelogram", 10.0));
        cases.push(FourBar { omega, angle, ..FourBar::new(0.8, 1.5, 1.5, 0.8) }.case("kite", "kite", 10.0));
        cases.push(FourBar { omega, angle, ..FourBar::new(1.0, 1.0, 1.0, 1.0) }.case("rhombus", "rhombus", 10.0));
        cases.push(coupled(seed));
        cases.push(equal_slider_crank(omega, angle));
        cases.push(redundant(omega + 3.0));
        cases.extend(starts(seed));
    }
    for seed in 0..3 * members {
        cases.push(neutral(seed).case("neutral four-bar", &format!("neutral_{seed}"), 8.0));
    }
    for (seed, power) in (0..members).flat_map(|seed| (3..=8).map(move |power| (seed, power))) {
        let bars = nearly_neutral(seed, 10.0_f64.powi(-power));
        let name = format!("nearly_neutral_{seed}_1e-{power}");
        cases.push(bars.case("nearly neutral four-bar", &name, 8.0).at(&[1e-6, 1e-7, 1e-8, 1e-9, 1e-10]));
    }
    for count in [1, 2, 5, 10, 20, 40, 100] {
        // The benchmark itself: upright, 1 m/s.
        cases.push(loops(count, PI / 2.0, 1.0));
    }
    for mass in [1e-9, 1e-14, 0.0] {
        let bars = FourBar { masses: [1.0, mass, 1.0], ..parallelogram };
        cases.push(bars.case("near-massless coupler", "massless", 10.0));
    }
    for masses in [[1.0, 1.0, 1e6], [1.0, 1e-6, 1.0], [1e6, 1.0, 1.0]] {
        cases.push(FourBar { masses, ..parallelogram }.case("mass ratio 1e6", "ratio", 10.0));
    }
    cases.extend([stiff(1e6, 1e2, 1.0), stiff(1e9, 1e3, 0.02), stiff(1e7, 0.0, 1.0)]);
    cases.push(Case::new("1000 s", slider_crank("long", 20.0), 1000.0, vec![]).at(&[1e-6, 1e-8, 1e-10, 1e-12]));
    let fast = slider_crank("fast", 10_000.0 * TAU / 60.0);
    cases.push(Case::new("10 000 rpm for 60 s", fast, 60.0, vec![]).at(&[1e-6, 1e-9, 1e-12]));
    cases.extend([jansen(), andrews(), no_freedom(), free_floating(), lock_up(), lock_up_with_freedom()]);
    cases
}
