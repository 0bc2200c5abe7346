//! What ticks and events write, and when: the kernels of discrete variables.

use cotree_fmu::program::{Event, Instants, Sampler, Write};
use cotree_fmu::tape::Tape;

use crate::equations::Equations;
use crate::expr::Expr;
use crate::model::{self, Discrete, DiscreteId, DiscreteKind, Formula, Mechanism};

/// The expressions behind [`Instants`].
#[derive(Clone, Debug, Default)]
pub(super) struct InstantKernels {
    pub begin: Vec<Expr>,
    pub clocks: Vec<Expr>,
    pub written: Vec<Expr>,
    pub sides: Vec<Expr>,
}

impl InstantKernels {
    pub fn new(equations: &mut Equations) -> Self {
        let mechanism = equations.system.mechanism.clone();
        let mut all = |formulas: Vec<&Formula>| -> Vec<Expr> {
            formulas.into_iter().map(|formula| equations.formula(formula)).collect()
        };
        Self {
            begin: all(of_scene(&mechanism).map(|discrete| &discrete.begin).collect()),
            clocks: all(mechanism.samplers.iter().flat_map(|sampler| [&sampler.period, &sampler.offset]).collect()),
            written: all(writes(&mechanism).map(|(_, formula)| formula).collect()),
            sides: all(mechanism.events.iter().flat_map(|event| event.ordered()).collect()),
        }
    }

    /// What is read of the motion at instants.
    pub fn read(&self) -> Vec<Expr> {
        [&self.written[..], &self.sides].concat()
    }

    /// With the tapes of its kernels.
    pub fn lower(&self, mechanism: &Mechanism, [begin, clocks, written, sides]: [Tape; 4]) -> Instants {
        // A program of positions alone has no kernels of the motion, and nothing happens in it.
        if self.begin.len() < of_scene(mechanism).count() {
            return Instants::default();
        }
        let mut result = 0;
        let mut write = |(discrete, _): &(DiscreteId, Formula)| {
            result += 1;
            Write { discrete: discrete.0 as u32, result: result - 1 }
        };
        let samplers = mechanism.samplers.iter().map(|sampler| Sampler {
            name: sampler.name.clone(),
            writes: sampler.writes.iter().map(&mut write).collect(),
        });
        let samplers = samplers.collect();
        let events = mechanism.events.iter().map(|event| Event {
            name: event.name.clone(),
            strict: event.is_strict(),
            once: event.once,
            stop: event.stop,
            writes: event.writes.iter().map(&mut write).collect(),
            removes: removes(mechanism, event),
        });
        Instants { samplers, events: events.collect(), begin, clocks, written, sides, ..Instants::default() }
    }
}

/// What becomes 0 where an event removes parts.
fn removes(mechanism: &Mechanism, event: &model::Event) -> Vec<u32> {
    let parts = mechanism.discrete.iter().filter_map(|discrete| match discrete.kind {
        DiscreteKind::Presence(owner) => Some(owner).filter(|owner| event.removes.contains(owner)),
        DiscreteKind::Sampled | DiscreteKind::Time | DiscreteKind::Contact => None,
    });
    parts.flat_map(|owner| mechanism.values_of_presence(owner)).map(|part| part.0 as u32).collect()
}

/// The discrete variables that are not those of contacts.
fn of_scene(mechanism: &Mechanism) -> impl Iterator<Item = &Discrete> {
    mechanism.discrete.iter().take_while(|discrete| discrete.kind != DiscreteKind::Contact)
}

/// Everything that is written at instants, those of samplers first.
fn writes(mechanism: &Mechanism) -> impl Iterator<Item = &(DiscreteId, Formula)> {
    let ticks = mechanism.samplers.iter().flat_map(|sampler| &sampler.writes);
    ticks.chain(mechanism.events.iter().flat_map(|event| &event.writes))
}
