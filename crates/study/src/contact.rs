//! Contacts that would not hold: followers and rolling discs are bound to what they touch in both directions, where a real one is only pressed. A cam or a line that has
//! to pull is a follower or a disc that lifts off, and a disc rolls without slip only if friction is large enough. Found in a motion, not prevented in it.

use std::sync::Arc;

use cotree::compile::{Compiled, compile_asking};
use cotree::diagnostic::Fault;
use cotree::model::{DisplayUnit, Mechanism, Part, Quantity, Units};
use cotree::report::data::shown;
use cotree::run::points;
use cotree::scene::{Requested, Scene};
use cotree::typeset::rounded;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

/// `cotree check` looks at so many rows of an experiment at most, and does so much work for them, in instructions of tapes: a core of 2026 takes a fifth of a second for
/// either (a rolling disc, 10 microseconds a row).
const MOST_ROWS: usize = 20_000;
const MOST_WORK: u64 = 200_000_000;

/// Pulls below this share of the largest pressure are rounding errors.
const PULLS: f64 = 1e-9;
/// Where there is less pressure than this share of the largest, no friction coefficient is asked for: it has no bound where a contact opens.
const PRESSES: f64 = 1e-3;

/// What there is to say of the contacts of a mechanism.
#[derive(Clone, Debug, Default)]
pub struct ContactFindings {
    /// Those that would have to pull, each with the place of its joint.
    pub faults: Vec<Fault>,
    /// What friction must be for discs to roll.
    pub needed: Vec<String>,
    /// That only the beginning of a long experiment was looked at.
    pub unseen: Option<String>,
}

/// What says how the contacts of a scene are loaded; none if it has no contact.
pub fn requested(scene: &Scene) -> Option<(Requested, Mechanism)> {
    let mechanism = scene.resolve().ok()?.mechanism;
    let names: Vec<String> = mechanism.joints.iter().flat_map(forces).collect();
    (!names.is_empty()).then_some((Requested::These(names), mechanism))
}

/// The motion of the scene's experiment, as far as little work goes; nothing if it has no start, which is told elsewhere.
pub fn of_experiment(scene: &Scene) -> ContactFindings {
    let seen = requested(scene).and_then(|(requested, mechanism)| {
        Some((ContactLoads::of(&compile_asking(scene, &requested).ok()?.0)?, mechanism))
    });
    let Some((seen, mechanism)) = seen else { return ContactFindings::default() };
    let column = |name: &str| seen.columns.iter().find(|(known, _)| known == name).map(|(_, values)| values.clone());
    let found = over_time(&mechanism, &mechanism.units, &seen.times, column);
    let time = |time: f64| shown(&mechanism.units, "s").show(time);
    let unseen = seen.until.map(|until| {
        format!(
            "contacts stay closed from t = {} on as far as checked; `cotree simulate --summary` checks the whole experiment, to {}",
            time(until),
            time(mechanism.experiment.stop)
        )
    });
    ContactFindings { unseen, ..found }
}

/// How contacts are loaded in the beginning of an experiment.
struct ContactLoads {
    times: Vec<f64>,
    columns: Vec<(String, Vec<f64>)>,
    /// Where the work ended, if that is before the experiment does.
    until: Option<f64>,
}

impl ContactLoads {
    fn of(compiled: &Compiled) -> Option<Self> {
        let reported = compiled.reported();
        let variables = reported.iter().map(|&index| (compiled.description.variables[index].name.clone(), Vec::new()));
        let mut seen = ContactLoads { times: Vec::new(), columns: variables.collect(), until: None };
        let experiment = compiled.description.experiment;
        let mut instance = Instance::new(Arc::new(Model::new(compiled.program.clone()).ok()?));
        instance.setup(experiment.start, Some(experiment.stop), Some(experiment.tolerance)).ok()?;
        instance.initialise().ok()?;
        instance.limit_work(MOST_WORK);
        for time in points(experiment) {
            if seen.times.len() == MOST_ROWS || instance.statistics().work > MOST_WORK {
                seen.until = Some(instance.time());
                break;
            }
            let moved = if time > instance.time() { instance.step_to(time) } else { Ok(()) };
            match moved {
                Ok(()) => {}
                Err(error) if error.is_unfinished() => {
                    seen.until = Some(instance.time());
                    break;
                }
                // A motion that ends early is told of by its run; what there is of it counts.
                Err(_) => break,
            }
            let values: Result<Vec<f64>, _> = reported.iter().map(|&variable| instance.reading(variable)).collect();
            let Ok(values) = values else { break };
            seen.times.push(time);
            seen.columns.iter_mut().zip(values).for_each(|((_, column), value)| column.push(value));
        }
        Some(seen)
    }
}

/// The contacts of a mechanism over time \[s\], told in these units.
pub fn over_time(
    mechanism: &Mechanism,
    units: &Units,
    times: &[f64],
    values: impl Fn(&str) -> Option<Vec<f64>>,
) -> ContactFindings {
    over(mechanism, units, times, &ContactAxis { named: "t =".to_owned(), unit: shown(units, "s") }, values)
}

/// What the forces are looked at over.
pub struct ContactAxis {
    /// `t =`
    pub named: String,
    pub unit: DisplayUnit,
}

/// The contacts of a mechanism over some input, told in these units.
pub fn over(
    mechanism: &Mechanism,
    units: &Units,
    inputs: &[f64],
    input: &ContactAxis,
    values: impl Fn(&str) -> Option<Vec<f64>>,
) -> ContactFindings {
    let newton = shown(units, "N");
    let mut contacts = ContactFindings::default();
    for joint in &mechanism.joints {
        let of = |quantity: Quantity| values(&quantity.of(&joint.name));
        let Some(normal) = forces(joint).next().and(of(Quantity::Fn)) else { continue };
        let angle = of(Quantity::PressureAngle);
        let look = Look { inputs, normal: &normal, angle: angle.as_deref(), input, newton: &newton };
        contacts.faults.extend(look.lost(joint));
        // With friction of its own a disc slides in the motion itself.
        let along = of(Quantity::Ft).filter(|_| mechanism.slip_of(joint.owner).is_none());
        contacts.needed.extend(along.and_then(|along| look.friction(&joint.name, &along)));
    }
    contacts
}

/// The variables that say how a contact is loaded; none of other joints.
fn forces(joint: &Part) -> impl Iterator<Item = String> {
    let quantities: &[Quantity] = match joint.component().name {
        // What is held on one side only lifts off in the motion itself.
        "cam" if joint.choice("closure") == Some("form") || joint.limits().is_some() => &[],
        "cam" => &[Quantity::Fn, Quantity::PressureAngle],
        "rolling" => &[Quantity::Fn, Quantity::Ft],
        _ => &[],
    };
    quantities.iter().map(|quantity| quantity.of(&joint.name))
}

/// A contact over the input.
struct Look<'a> {
    inputs: &'a [f64],
    normal: &'a [f64],
    angle: Option<&'a [f64]>,
    input: &'a ContactAxis,
    newton: &'a DisplayUnit,
}

impl Look<'_> {
    fn largest(&self) -> f64 {
        self.normal.iter().fold(0.0, |largest: f64, force| largest.max(force.abs()))
    }

    /// The fault of a contact that would have to pull.
    fn lost(&self, joint: &Part) -> Option<Fault> {
        let least = PULLS * self.largest();
        let pulls = |index: usize| self.normal[index] < -least;
        let first = (0..self.normal.len()).find(|&index| pulls(index))?;
        let last = (first..self.normal.len()).find(|&index| !pulls(index));
        let until = last.map_or(String::new(), |last| format!(" to {}", self.input.unit.show(self.crossing(last))));
        let from = self.input.unit.show(if first == 0 { self.inputs[0] } else { self.crossing(first) });
        let (worst, force) = self.normal.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let again = last.is_some_and(|last| (last..self.normal.len()).any(pulls));
        let (more, place, is_cam) =
            (if again { ", and again" } else { "" }, self.input.unit.show(self.inputs[worst]), self.angle.is_some());
        let (name, named) = (&joint.name, &self.input.named);
        let what = if is_cam { "the follower would leave the cam" } else { "the disc would lift off" };
        let message = format!(
            "`{name}` would have to pull: {what} from {named} {from}{until}{more}; its contact force is down to {} at {named} {place}",
            self.newton.show(*force)
        );
        let help = match self.pressure() {
            Some(pressure) if is_cam => format!(
                "press the follower along its guide with at least {} more by a spring, turn slower, or use a gentler rise",
                self.newton.show(pressure)
            ),
            _ => "the motion shown is that of a bilateral contact, which can pull".to_owned(),
        };
        Some(Fault::warning("contact::lifts_off", message, joint.span).label("lifts off").help(help))
    }

    /// Where the contact begins or ceases to pull before a sample, by a straight line.
    fn crossing(&self, index: usize) -> f64 {
        let (Some(before), [to, end]) = (index.checked_sub(1), [self.inputs[index], self.normal[index]]) else {
            return self.inputs[index];
        };
        let [from, begin] = [self.inputs[before], self.normal[before]];
        from + (to - from) * begin / (begin - end)
    }

    /// What presses the follower along its guide so that the cam never pulls \[N\].
    fn pressure(&self) -> Option<f64> {
        let along = self.angle?.iter().zip(self.normal).map(|(angle, force)| -force * libm::cos(*angle));
        Some(along.fold(0.0, f64::max))
    }

    /// The friction that rolling takes.
    fn friction(&self, name: &str, along: &[f64]) -> Option<String> {
        let least = PRESSES * self.largest();
        let pairs = self.normal.iter().zip(along).enumerate();
        let needed = pairs
            .filter(|(_, (normal, along))| **normal > least && along.is_finite())
            .map(|(index, (n, t))| (index, (t / n).abs()));
        let (index, most) = needed.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let place = self.input.unit.show(self.inputs[index]);
        (most > 1e-6).then(|| {
            format!(
                "`{name}` rolls without slip, which needs a coefficient of friction of at least {} (at {} {place})",
                rounded(most, 4),
                self.input.named
            )
        })
    }
}
