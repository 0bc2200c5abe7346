//! How accurate a motion can be at all.
//!
//! Where a light body moves what is heavy, little is left of its inertia: M_kk counts all that it carries, and the pivot that the elimination leaves of it is a small
//! difference of large numbers. Rounding errors of the equations of motion grow by M_kk (M^-1)_kk in the accelerations (Higham, Accuracy and
//! Stability of Numerical Algorithms, 2002, 7.2: the condition of a matrix scaled by its diagonal). No step is short enough against that, so it is said.

use std::fmt;

use super::together::Comparisons;
use crate::context::Context;
use crate::failure::number;
use crate::model::Model;
use crate::motion::Passage;
use crate::motion::Run;
use crate::taylor::Jet;

/// What is looked at now and then is so at the first step, and at every so many: how accurate a motion can be, and whether its series do what the tape demands.
pub(super) const EVERY: u32 = 16;

/// Why a motion may be less accurate than was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Inaccuracy {
    /// Rounding errors are larger than the tolerance.
    Rounding {
        /// When that was found \[s\].
        time: f64,
        /// Attainable relative accuracy of the accelerations.
        attainable: f64,
        /// The tolerance that was asked for.
        tolerance: f64,
        /// The coordinate whose acceleration it is.
        coordinate: Option<String>,
    },
    /// The sides of a comparison stay equal to within rounding errors, which decide how the mechanism accelerates.
    Comparison {
        /// Since when \[s\].
        time: f64,
        /// The coordinate that the comparison accelerates most.
        coordinate: String,
    },
    /// A singular pose was passed as if branches met in it that only almost do.
    Passage(Passage),
}

impl Inaccuracy {
    /// What to do about rounding errors.
    pub const ROUNDING: &str = "the body there is very light for the load on it: make it heavier, replace it (a `distance` joint is a massless rod), or use a larger tolerance";

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Rounding { .. } => Self::ROUNDING,
            Self::Comparison { .. } => {
                "compare with a margin, such as `if(a < b + 1e-6, ...)`, or write a law that does not jump where both sides are equal"
            }
            Self::Passage(_) => "make the lengths exactly equal, or more different",
        }
    }
}

impl fmt::Display for Inaccuracy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (time, attainable, tolerance, coordinate) = match self {
            Self::Rounding { time, attainable, tolerance, coordinate } => (time, attainable, tolerance, coordinate),
            Self::Passage(passage) => return passage.fmt(formatter),
            Self::Comparison { time, coordinate } => {
                return write!(
                    formatter,
                    "from t = {} s on both sides of a comparison stay equal to within rounding errors, which decide the acceleration of `{coordinate}`",
                    number(*time)
                );
            }
        };
        let coordinate = coordinate.as_ref().map(|name| format!(" of `{name}`")).unwrap_or_default();
        write!(
            formatter,
            "the attainable accuracy of about {attainable:.0e} exceeds the tolerance of {}: at t = {} s masses differ so much that rounding errors limit the acceleration{coordinate}",
            number(*tolerance),
            number(*time),
        )
    }
}

/// The masses of a motion that has no series.
#[derive(Clone, Debug)]
pub(crate) struct Masses(Jet);

impl Masses {
    /// Storage for them, if the program has them.
    pub fn new(model: &Model) -> Option<Self> {
        Some(Self(Jet::of(model, model.program().masses.as_ref()?)))
    }

    /// How many times rounding errors are multiplied where the last step ends, and the coordinate; none in a singular pose.
    pub fn amplification(&mut self, context: &mut Context, run: &Run) -> Option<(f64, Option<usize>)> {
        let Context { model, machine, .. } = context;
        machine.load_signals(model, &run.signals.origin, run.last.end_time);
        self.0.update(machine.registers());
        self.0.probe(model, machine.registers(), &run.last.end).ok()?;
        Some(self.0.amplification())
    }
}

/// What is known of it in a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Accuracy {
    /// The largest so far.
    attainable: f64,
    /// When it exceeded the tolerance first, by how much, and where.
    found: Option<(f64, [f64; 2], Option<usize>)>,
    reported: bool,
    /// The first pose since the last report that was passed as if branches met.
    passage: Option<Passage>,
    steps: u32,
    comparisons: Comparisons,
}

impl Accuracy {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self { comparisons: Comparisons::new(model), ..Self::default() }
    }

    /// The motion goes on from elsewhere.
    pub fn forget_steps(&mut self) {
        self.comparisons.forget();
    }

    /// The largest attainable accuracy so far; 0 if nothing limits it.
    pub fn attainable(&self) -> f64 {
        self.attainable
    }

    /// What is to be reported, once.
    pub fn take(&mut self, model: &Model) -> Option<Inaccuracy> {
        let Some((time, [attainable, tolerance], index)) = self.found.take() else {
            let name = |index: usize| model.program().coordinates[index].name.clone();
            let comparison = || {
                self.comparisons.take().map(|(time, index)| Inaccuracy::Comparison { time, coordinate: name(index) })
            };
            return self.passage.take().map(Inaccuracy::Passage).or_else(comparison);
        };
        self.reported = true;
        let coordinate = index.map(|index| model.program().coordinates[index].name.clone());
        Some(Inaccuracy::Rounding { time, attainable, tolerance, coordinate })
    }

    /// Poses that have been passed.
    pub fn note_passages(&mut self, passages: impl IntoIterator<Item = Passage>) {
        if let Some(passage) = passages.into_iter().find(Passage::is_inexact) {
            self.passage.get_or_insert(passage);
        }
    }

    /// Counts a step, looks at the comparisons of laws where it ends, and measures where it ends if it is time.
    /// `amplification` says how many times rounding errors are multiplied there, and in which coordinate most.
    pub fn note(
        &mut self,
        context: &mut Context,
        run: &Run,
        amplification: impl FnOnce(&mut Context, &Run) -> Option<(f64, Option<usize>)>,
    ) {
        self.comparisons.note(context, run);
        let due = self.steps.is_multiple_of(EVERY);
        self.steps = self.steps.wrapping_add(1);
        let found = if due { amplification(context, run) } else { None };
        let Some((amplification, index)) = found else { return };
        let attainable = f64::EPSILON * amplification;
        if attainable > self.attainable {
            self.attainable = attainable;
        }
        let tolerance = context.settings.tolerance;
        if attainable > tolerance && !self.reported && self.found.is_none() {
            self.found = Some((run.last.end_time, [attainable, tolerance], index));
        }
    }
}
