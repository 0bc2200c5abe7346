//! The equations that the start is found from, in the order of their solution.

use std::collections::{BTreeMap, HashMap, HashSet};

use petgraph::unionfind::UnionFind;

use super::initial::Conditions;
use super::program::inverse;
use super::start::Beginning;
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Node, Order, Rounded, Slopes, Symbol};

/// Equations for unknowns that follow from what is known before.
#[derive(Clone, Debug, Default)]
pub(super) struct Level {
    /// What is solved for.
    pub unknowns: Vec<Symbol>,
    /// They are zero: loop equations, then known values.
    pub residuals: Vec<Expr>,
    /// How many of them are loop equations.
    pub loops: usize,
    /// They and the known values are made small first, with the loops open. What is left open goes on from there.
    pub guesses: Vec<Expr>,
    /// Is that so? It is with positions.
    pub guessing: bool,
    /// What else is in the equations.
    pub knowns: Vec<Symbol>,
    /// What they are made of, operands first.
    pub order: Vec<Expr>,
}

/// How the start is found.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    /// In the order of their solution: positions, rates, and where drivers determine the motion accelerations and reactions.
    pub levels: Vec<Level>,
    /// Accelerations and reactions in terms of the state, where loads determine the motion.
    pub solved: HashMap<Symbol, Expr>,
    /// What followers take from inputs: the same numbers.
    pub followed: Vec<(Symbol, Symbol)>,
    /// Typical length.
    pub length: f64,
}

impl Search {
    /// The equations of the start. `reacts`: where drivers determine the motion, are reactions wanted?
    pub fn new(equations: &mut Equations, beginning: &Beginning, (length, reacts): (f64, bool)) -> Self {
        let followers = equations.system.followers.clone();
        let mut search = Search { length, ..Search::default() };
        for (index, &(_, input, order)) in followers.iter().enumerate() {
            let mut follow = |order, input_order| {
                let symbol = (Symbol::Follower(index, order), Symbol::Input(input.0, input_order));
                search.followed.push(symbol);
            };
            follow(order, Order::Position);
            if order == Order::Velocity {
                follow(Order::Acceleration, Order::Velocity);
            }
        }
        for (order, conditions) in [Order::Position, Order::Velocity].into_iter().zip(beginning.conditions) {
            let values = beginning.constraints[usize::from(order == Order::Velocity)];
            let free = |(index, given): (usize, Order)| (order < given).then_some(Symbol::Follower(index, order));
            let mut level = Level {
                unknowns: coordinates(equations, order)
                    .chain(followers.iter().map(|follower| follower.2).enumerate().filter_map(free))
                    .collect(),
                residuals: loops(equations, beginning).map(|row| values[row]).collect(),
                guessing: order == Order::Position,
                ..Level::default()
            };
            level.loops = level.residuals.len();
            level.impose(&mut equations.system.arena, conditions);
            search.levels.extend(level.parts(&equations.system.arena));
        }
        match beginning.solved {
            Some(solved) => search.solved = beginning.symbols().zip(solved.iter().copied()).collect(),
            None => {
                let accelerations = driven(equations, beginning);
                search.levels.extend(accelerations.parts(&equations.system.arena));
                if reacts {
                    let reactions = reactions(equations, beginning);
                    search.levels.extend(reactions.parts(&equations.system.arena));
                }
            }
        }
        search
    }
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

/// Phi_q a - gamma
fn driven(equations: &mut Equations, beginning: &Beginning) -> Level {
    let mut level = Level { unknowns: coordinates(equations, Order::Acceleration).collect(), ..Level::default() };
    for (row, constraint) in equations.constraints.iter().enumerate().filter(|(row, _)| beginning.active[*row]) {
        let arena = &mut equations.system.arena;
        let start = arena.negate(beginning.constraints[2][row]);
        let sum = |sum, &(column, entry): &(usize, Expr)| {
            let acceleration = arena.symbol(Symbol::Coordinate(column, Order::Acceleration));
            let term = arena.multiply(entry, acceleration);
            arena.add(sum, term)
        };
        level.residuals.push(constraint.jacobian.iter().fold(start, sum));
    }
    level
}

/// Q - M a - Phi_q^T lambda
fn reactions(equations: &mut Equations, beginning: &Beginning) -> Level {
    let mut level = Level { residuals: inverse(equations), ..Level::default() };
    for (row, constraint) in equations.constraints.iter().enumerate().filter(|(row, _)| beginning.active[*row]) {
        let arena = &mut equations.system.arena;
        let reaction = arena.symbol(Symbol::Reaction(row));
        level.unknowns.push(Symbol::Reaction(row));
        for &(column, entry) in &constraint.jacobian {
            let term = arena.multiply(entry, reaction);
            level.residuals[column] = arena.subtract(level.residuals[column], term);
        }
    }
    level
}

impl Level {
    /// Adds conditions.
    fn impose(&mut self, arena: &mut Arena, conditions: &Conditions) {
        let (values, targets) = conditions.results.split_at(conditions.conditions.len());
        for ((condition, &value), &target) in conditions.conditions.iter().zip(values).zip(targets) {
            let residual = arena.subtract(value, target);
            match condition.known {
                true => self.residuals.push(residual),
                false if self.guessing => self.guesses.push(residual),
                false => (),
            }
        }
    }

    /// Unknowns that share no equation, not even by others, are found apart. Those that are in no equation are left as they are.
    fn parts(self, arena: &Arena) -> Vec<Level> {
        let numbers: HashMap<Symbol, usize> = self.unknowns.iter().copied().zip(0..).collect();
        let mut sets = UnionFind::<usize>::new(self.unknowns.len());
        let member_of = |residual: Expr| {
            let symbols = arena.symbols([residual]);
            let mut members = symbols.iter().filter_map(|symbol| numbers.get(symbol).copied());
            let first = members.next()?;
            members.for_each(|member| _ = sets.union(first, member));
            Some(first)
        };
        let members: Vec<Option<usize>> = self.all().into_iter().map(member_of).collect();
        let mut parts: BTreeMap<Option<usize>, Level> = BTreeMap::new();
        for (index, (residual, member)) in self.all().into_iter().zip(members).enumerate() {
            let part = parts.entry(member.map(|member| sets.find(member))).or_default();
            part.guessing = self.guessing;
            part.loops += usize::from(index < self.loops);
            if index < self.residuals.len() { part.residuals.push(residual) } else { part.guesses.push(residual) }
        }
        for (index, &unknown) in self.unknowns.iter().enumerate() {
            if let Some(part) = parts.get_mut(&Some(sets.find(index))) {
                part.unknowns.push(unknown);
            }
        }
        parts.into_values().map(|part| part.in_order(arena)).collect()
    }

    fn in_order(self, arena: &Arena) -> Level {
        let order = arena.reachable(self.all());
        let symbols = order.iter().filter_map(|&expr| match arena.node(expr) {
            Node::Symbol(symbol) => Some(symbol),
            _ => None,
        });
        let unknowns: HashSet<Symbol> = self.unknowns.iter().copied().collect();
        let knowns = symbols.filter(|symbol| !unknowns.contains(symbol)).collect();
        Level { order, knowns, ..self }
    }

    /// All residuals, those of guesses last.
    pub fn all(&self) -> Vec<Expr> {
        self.residuals.iter().chain(&self.guesses).copied().collect()
    }

    /// Derivatives of roots by the unknowns, by rows.
    pub fn jacobian(&self, slopes: &Slopes, roots: &[Expr]) -> Vec<Vec<Rounded>> {
        let one = |of: Symbol| move |symbol| if symbol == of { Rounded::exact(1.0) } else { Rounded::default() };
        let columns: Vec<Vec<Rounded>> =
            self.unknowns.iter().map(|&unknown| slopes.slopes(roots, one(unknown))).collect();
        (0..roots.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }
}
