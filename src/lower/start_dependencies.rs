//! What each variable depends on at the start: the parameters, inputs and known initial values in its expression and in the equations that
//! its unknowns are found from. Unknowns that share an equation, or are joined by others that do, depend on everything in their equations.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use petgraph::unionfind::UnionFind;

use super::dependencies::LISTED;
use super::footprints::footprints;
use super::initial::Conditions;
use super::program::inverse;
use super::start::Beginning;
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Symbol};

type Places = Arc<[usize]>;

/// For each of the values the places of what is `given` that it depends on.
pub(super) fn find(
    equations: &mut Equations,
    beginning: &Beginning,
    given: &[(usize, Vec<Symbol>)],
    values: &[Expr],
) -> Vec<Places> {
    let reacts = equations.system.arena.symbols(values.iter().copied());
    let reacts = reacts.iter().any(|symbol| matches!(symbol, Symbol::Reaction(_)));
    let stages = stages(equations, beginning, reacts);
    let mut sources = Sources::new(equations, given);
    let arena = &equations.system.arena;
    stages.iter().for_each(|stage| sources.add_stage(stage));
    if let Some(solved) = beginning.solved {
        let places = sources.of(arena, solved);
        sources.places.extend(beginning.symbols().zip(places));
    }
    sources.of(arena, values)
}

/// Unknowns and the equations that they are found from, once what was found before is known.
struct Stage {
    unknowns: Vec<Symbol>,
    equations: Vec<Vec<Symbol>>,
}

/// Positions and velocities; where drivers determine the motion also accelerations and, if anything `reacts`, reactions.
fn stages(equations: &mut Equations, beginning: &Beginning, reacts: bool) -> Vec<Stage> {
    let mut stages = vec![
        state(equations, beginning, Order::Position, beginning.conditions[0]),
        state(equations, beginning, Order::Velocity, beginning.conditions[1]),
    ];
    if beginning.solved.is_none() {
        stages.push(accelerations(equations, beginning));
        if reacts {
            stages.push(reactions(equations, beginning));
        }
    }
    stages
}

/// Loop equations of one order and the conditions on it, for coordinates and for what drivers integrate.
fn state(equations: &Equations, beginning: &Beginning, order: Order, conditions: &Conditions) -> Stage {
    let arena = &equations.system.arena;
    let followers = equations.system.followers.iter().enumerate();
    let free = followers.filter(|(_, (.., input_order))| order < *input_order);
    let values = beginning.constraints[usize::from(order == Order::Velocity)];
    let loops = loops(equations, beginning).map(|row| arena.symbols([values[row]]));
    let (conditions, targets) = conditions.results.split_at(conditions.conditions.len());
    let conditions = conditions.iter().zip(targets).map(|(&value, &target)| arena.symbols([value, target]));
    Stage {
        unknowns: coordinates(equations, order).chain(free.map(|(index, _)| Symbol::Follower(index, order))).collect(),
        equations: loops.chain(conditions).collect(),
    }
}

/// Phi_q a = gamma
fn accelerations(equations: &Equations, beginning: &Beginning) -> Stage {
    let rows = equations.constraints.iter().zip(beginning.constraints[2]).zip(beginning.active);
    let equation = |((row, &gamma), _): ((&crate::equations::Constraint, &Expr), &bool)| {
        let entries = row.jacobian.iter().map(|&(_, entry)| entry);
        let unknowns = row.jacobian.iter().map(|&(column, _)| Symbol::Coordinate(column, Order::Acceleration));
        equations.system.arena.symbols(entries.chain([gamma])).into_iter().chain(unknowns).collect()
    };
    Stage {
        unknowns: coordinates(equations, Order::Acceleration).collect(),
        equations: rows.filter(|(_, active)| **active).map(equation).collect(),
    }
}

/// Phi_q^T lambda = Q - M a
fn reactions(equations: &mut Equations, beginning: &Beginning) -> Stage {
    let residuals = inverse(equations);
    let arena = &equations.system.arena;
    let mut columns: Vec<Vec<Symbol>> = residuals.into_iter().map(|residual| arena.symbols([residual])).collect();
    let active = equations.constraints.iter().enumerate().filter(|(row, _)| beginning.active[*row]);
    let mut unknowns = Vec::new();
    for (row, constraint) in active {
        unknowns.push(Symbol::Reaction(row));
        for &(column, entry) in &constraint.jacobian {
            columns[column].push(Symbol::Reaction(row));
            columns[column].extend(arena.symbols([entry]));
        }
    }
    Stage { unknowns, equations: columns }
}

fn coordinates(equations: &Equations, order: Order) -> impl Iterator<Item = Symbol> + use<> {
    (0..equations.coordinates.len()).map(move |index| Symbol::Coordinate(index, order))
}

/// The loop equations that count: independent ones, and those about followers alone.
fn loops<'a>(equations: &'a Equations, beginning: &'a Beginning) -> impl Iterator<Item = usize> + use<'a> {
    let constraints = equations.constraints.iter().zip(beginning.active).enumerate();
    let counts = constraints.filter(|(_, (row, active))| **active || (row.is_trivial() && !row.says_nothing()));
    counts.map(|(row, _)| row)
}

impl Stage {
    /// Unknowns that belong together, with everything else in their equations.
    fn groups(&self) -> Vec<(Vec<Symbol>, BTreeSet<Symbol>)> {
        let numbers: HashMap<Symbol, usize> = self.unknowns.iter().copied().zip(0..).collect();
        let mut sets = UnionFind::<usize>::new(self.unknowns.len());
        let member = |equation: &Vec<Symbol>| equation.iter().find_map(|symbol| numbers.get(symbol).copied());
        for equation in &self.equations {
            let Some(first) = member(equation) else { continue };
            let members = equation.iter().filter_map(|symbol| numbers.get(symbol));
            members.for_each(|&other| _ = sets.union(first, other));
        }
        let mut groups: BTreeMap<usize, (Vec<Symbol>, BTreeSet<Symbol>)> = BTreeMap::new();
        for (index, &unknown) in self.unknowns.iter().enumerate() {
            groups.entry(sets.find(index)).or_default().0.push(unknown);
        }
        for equation in &self.equations {
            let group = member(equation).and_then(|member| groups.get_mut(&sets.find(member)));
            let known = equation.iter().filter(|symbol| !numbers.contains_key(symbol));
            group.into_iter().for_each(|group| group.1.extend(known.clone()));
        }
        groups.into_values().collect()
    }
}

struct Sources {
    places: HashMap<Symbol, Places>,
    everything: Places,
}

impl Sources {
    /// What is given stands for itself, and what a driver takes from an input for that.
    fn new(equations: &Equations, given: &[(usize, Vec<Symbol>)]) -> Self {
        let mut places: HashMap<Symbol, Places> = HashMap::new();
        for (place, symbols) in given {
            places.extend(symbols.iter().map(|&symbol| (symbol, Arc::from([*place]))));
        }
        for (index, &(_, input, order)) in equations.system.followers.iter().enumerate() {
            let Some(followed) = places.get(&Symbol::Input(input.0, Order::Position)).cloned() else { continue };
            let orders = [Order::Position, Order::Velocity, Order::Acceleration].into_iter();
            let taken = orders.filter(|taken| *taken >= order).map(|order| Symbol::Follower(index, order));
            places.extend(taken.map(|symbol| (symbol, followed.clone())));
        }
        Sources { places, everything: given.iter().map(|(place, _)| *place).collect() }
    }

    /// Unknowns that belong together depend on whatever is behind their equations.
    fn add_stage(&mut self, stage: &Stage) {
        for (unknowns, known) in stage.groups() {
            let behind = self.behind(&known);
            self.places.extend(unknowns.into_iter().map(|unknown| (unknown, behind.clone())));
        }
    }

    /// What each of these expressions depends on; everything if that is much.
    fn of(&self, arena: &Arena, values: &[Expr]) -> Vec<Places> {
        footprints(arena, values, |symbol| self.places.get(&symbol).cloned(), (self.everything.clone(), LISTED))
    }

    fn behind(&self, known: &BTreeSet<Symbol>) -> Places {
        // Many symbols share one long list.
        let lists: HashMap<*const usize, &Places> =
            known.iter().filter_map(|known| self.places.get(known)).map(|list| (list.as_ptr(), list)).collect();
        let all: BTreeSet<usize> = lists.values().flat_map(|list| list.iter().copied()).collect();
        if all.len() > LISTED { self.everything.clone() } else { all.into_iter().collect() }
    }
}
