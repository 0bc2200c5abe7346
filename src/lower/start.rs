//! What the values at the start depend on: parameters, inputs, and the initial values that hold.
//!
//! The initial state solves the loop equations together with the conditions of `[initial]`. Coordinates that share an equation are found
//! together, and depend on everything in their equations.

use std::collections::{BTreeSet, HashMap};

use petgraph::unionfind::UnionFind;

use super::initial::Conditions;
use crate::expr::{Arena, Expr, Order, Symbol};

/// Places of variables in the table.
pub(super) type Places = BTreeSet<usize>;

/// The equations that the initial state solves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning<'a> {
    /// Phi, its rate, gamma.
    pub constraints: [&'a [Expr]; 3],
    /// Conditions on positions and on velocities.
    pub conditions: [&'a Conditions; 2],
    /// Which loop equations are independent.
    pub active: &'a [bool],
    /// Accelerations, then reactions, in terms of the state; nothing if the drivers determine the motion.
    pub solved: Option<&'a [Expr]>,
    /// Number of coordinates.
    pub coordinates: usize,
}

impl Beginning<'_> {
    /// What is solved for where loads determine the motion: accelerations, then reactions.
    pub fn symbols(&self) -> impl Iterator<Item = Symbol> {
        let coordinates = self.coordinates;
        (0..).map(move |index: usize| match index.checked_sub(coordinates) {
            None => Symbol::Coordinate(index, Order::Acceleration),
            Some(reaction) => Symbol::Reaction(reaction),
        })
    }
}

/// An equation for what it contains of some order.
struct Equation {
    unknown: (Expr, Order),
    terms: Vec<Expr>,
}

/// What each symbol depends on.
#[derive(Debug)]
pub(super) struct Sources<'a> {
    arena: &'a Arena,
    places: HashMap<Symbol, Places>,
    /// Of symbols about which nothing else is known.
    everything: Places,
}

impl<'a> Sources<'a> {
    /// `given`: the places of what is given from outside.
    pub fn new(arena: &'a Arena, given: &HashMap<Symbol, usize>, beginning: &Beginning) -> Self {
        let places = given.iter().map(|(&symbol, &place)| (symbol, Places::from([place]))).collect();
        let mut sources = Self { arena, places, everything: given.values().copied().collect() };
        let [phi, rate, gamma] = beginning.constraints;
        sources.solve(Order::Position, level(phi, &beginning.conditions[0].results, Order::Position));
        sources.solve(Order::Velocity, level(rate, &beginning.conditions[1].results, Order::Velocity));
        match beginning.solved {
            Some(solved) => {
                let found: Vec<_> =
                    beginning.symbols().zip(solved).map(|(symbol, &value)| (symbol, sources.of(value))).collect();
                sources.places.extend(found);
            }
            None => {
                let pairs = rate.iter().zip(gamma);
                let equations = pairs
                    .map(|(&rate, &gamma)| Equation { unknown: (rate, Order::Velocity), terms: vec![rate, gamma] });
                sources.solve(Order::Acceleration, equations.collect());
            }
        }
        sources
    }

    /// What an expression depends on.
    pub fn of(&self, value: Expr) -> Places {
        self.all(&[value], |_| true)
    }

    fn all(&self, values: &[Expr], wanted: impl Fn(Symbol) -> bool) -> Places {
        let symbols = self.arena.symbols(values.iter().copied()).into_iter().filter(|&symbol| wanted(symbol));
        symbols.flat_map(|symbol| self.places_of(symbol)).copied().collect()
    }

    fn places_of(&self, symbol: Symbol) -> &Places {
        static NONE: Places = Places::new();
        self.places.get(&symbol).unwrap_or(match symbol {
            Symbol::Reaction(_) | Symbol::Coordinate(_, Order::Acceleration) => &self.everything,
            // Time, and coordinates that no equation is about.
            _ => &NONE,
        })
    }

    /// Unknowns that share an equation depend on the same.
    fn solve(&mut self, order: Order, equations: Vec<Equation>) {
        let mut numbers: HashMap<Symbol, usize> = HashMap::new();
        let mut rows = Vec::new();
        for Equation { unknown: (value, of), terms } in equations {
            let symbols = self.arena.symbols([value]);
            let members: Vec<usize> = symbols
                .into_iter()
                .filter_map(|symbol| raised(symbol, of, order))
                .map(|symbol| {
                    let next = numbers.len();
                    *numbers.entry(symbol).or_insert(next)
                })
                .collect();
            rows.push((members, self.all(&terms, |symbol| raised(symbol, order, order).is_none())));
        }
        let mut groups = UnionFind::<usize>::new(numbers.len());
        for (members, _) in &rows {
            for pair in members.windows(2) {
                groups.union(pair[0], pair[1]);
            }
        }
        let mut found = vec![Places::new(); numbers.len()];
        for (members, places) in rows {
            if let Some(&member) = members.first() {
                found[groups.find(member)].extend(places);
            }
        }
        // A follower's rate or acceleration is what its input says, whatever else.
        for (symbol, number) in numbers {
            self.places.entry(symbol).or_default().extend(&found[groups.find(number)]);
        }
    }
}

/// Loop equations and conditions of one order.
fn level(loops: &[Expr], conditions: &[Expr], order: Order) -> Vec<Equation> {
    let (values, targets) = conditions.split_at(conditions.len() / 2);
    let loops = loops.iter().map(|&value| Equation { unknown: (value, order), terms: vec![value] });
    let pairs = values.iter().zip(targets);
    let known = pairs.map(|(&value, &target)| Equation { unknown: (value, order), terms: vec![value, target] });
    loops.chain(known).collect()
}

/// The same signal in another order, if it is one of the motion and of the order `from`.
fn raised(symbol: Symbol, from: Order, to: Order) -> Option<Symbol> {
    match symbol {
        Symbol::Coordinate(index, order) if order == from => Some(Symbol::Coordinate(index, to)),
        Symbol::Follower(index, order) if order == from => Some(Symbol::Follower(index, to)),
        _ => None,
    }
}
