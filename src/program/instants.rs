//! What ticks and events write, and when: the kernels of discrete variables.

use cotree_fmu::program::{Event, Instants, Sampler, Write};
use cotree_fmu::tape::Tape;

use crate::equations::Equations;
use crate::expr::Expr;
use crate::model::{self, Discrete, DiscreteKind, Formula, Mechanism};

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
        let clocks = all(mechanism.samplers.iter().flat_map(|sampler| [&sampler.period, &sampler.offset]).collect());
        let mut written = all(writes(&mechanism).into_iter().map(|(_, formula)| formula).collect());
        let mut sides = all(mechanism.events.iter().flat_map(|event| event.ordered()).collect());
        let begin = |discrete: &Discrete| match discrete.kind {
            DiscreteKind::Course(owner, value) => equations.begin_of_course(owner, value),
            DiscreteKind::Sampled
            | DiscreteKind::Time
            | DiscreteKind::Presence(_)
            | DiscreteKind::Contact
            | DiscreteKind::Captured(_)
            | DiscreteKind::Impulse
            | DiscreteKind::Setting => equations.formula(&discrete.begin),
        };
        let begin = of_scene(&mechanism).map(begin).collect();
        let (turned, angles) = equations.course_turns();
        sides.extend(turned.into_iter().chain(equations.course_lifts()).flatten());
        written.extend(angles);
        Self { begin, clocks, written, sides }
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
        let targets = writes(mechanism).into_iter().map(|(target, _)| target).enumerate();
        let mut all = targets.map(|(result, target)| Write { target, result: result as u32 });
        let mut next = |count: usize| all.by_ref().take(count).collect();
        let samplers = mechanism
            .samplers
            .iter()
            .map(|sampler| Sampler { name: sampler.name.clone(), writes: next(sampler.writes.len()) });
        let samplers: Vec<Sampler> = samplers.collect();
        let events = mechanism.events.iter().map(|event| Event {
            name: event.name.clone(),
            strict: event.is_strict(),
            once: event.once,
            stop: event.stop,
            writes: next(event.writes.len() + event.states.len()),
            removes: removes(mechanism, event),
        });
        let mut events: Vec<Event> = events.collect();
        // What the turning of straight parts writes comes after what the scene does.
        let own = writes(mechanism).len();
        events.extend(mechanism.turns().enumerate().map(|(number, (id, ..))| Event {
            name: mechanism.discrete[id.0].name.clone(),
            strict: false,
            once: false,
            stop: false,
            writes: vec![Write { target: id.0 as u32, result: (own + number) as u32 }],
            removes: Vec::new(),
        }));
        events.extend(mechanism.lying().map(|(part, number)| Event {
            name: format!("{}.wrap_{}", part.name, number + 1),
            strict: false,
            once: false,
            stop: false,
            writes: Vec::new(),
            removes: Vec::new(),
        }));
        Instants { samplers, events, begin, clocks, written, sides, ..Instants::default() }
    }
}

/// What becomes 0 where an event removes parts.
fn removes(mechanism: &Mechanism, event: &model::Event) -> Vec<u32> {
    let parts = mechanism.discrete.iter().filter_map(|discrete| match discrete.kind {
        DiscreteKind::Presence(owner) => Some(owner).filter(|owner| event.removes.contains(owner)),
        DiscreteKind::Sampled | DiscreteKind::Time | DiscreteKind::Contact => None,
        DiscreteKind::Captured(_) | DiscreteKind::Impulse | DiscreteKind::Setting => None,
        DiscreteKind::Course(..) => None,
    });
    parts.flat_map(|owner| mechanism.values_of_presence(owner)).map(|part| part.0 as u32).collect()
}

/// The discrete variables that are not those of contacts.
fn of_scene(mechanism: &Mechanism) -> impl Iterator<Item = &Discrete> {
    mechanism.discrete.iter().take_while(|discrete| discrete.kind != DiscreteKind::Contact)
}

/// Everything that is written at instants, those of samplers first, each with its target.
fn writes(mechanism: &Mechanism) -> Vec<(u32, &Formula)> {
    let states = mechanism.discrete.len();
    let ticks = mechanism.samplers.iter().flat_map(|sampler| &sampler.writes);
    let mut all: Vec<(u32, &Formula)> = ticks.map(|(id, formula)| (id.0 as u32, formula)).collect();
    for event in &mechanism.events {
        all.extend(event.writes.iter().map(|(id, formula)| (id.0 as u32, formula)));
        all.extend(event.states.iter().map(|(id, formula)| ((states + id.0) as u32, formula)));
    }
    all
}
