//! What the start contains, whether it changes with it or not: the parameters, inputs and known initial values behind each unknown. Unknowns that are
//! found together contain everything in their equations.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use super::dependencies::LISTED;
use super::footprints::footprints;
use super::start_levels::{Level, Search};
use crate::expr::{Arena, Expr, Symbol};

/// The places of what is given, by the symbols that follow from it.
#[derive(Debug)]
pub(super) struct Sources {
    places: HashMap<Symbol, Arc<[usize]>>,
    everything: Arc<[usize]>,
}

impl Sources {
    /// `given`: the places of what is given from outside, with its symbols.
    pub fn new(arena: &Arena, given: &[(usize, Vec<Symbol>)], search: &Search) -> Self {
        let mut places: HashMap<Symbol, Arc<[usize]>> = HashMap::new();
        for (place, symbols) in given {
            places.extend(symbols.iter().map(|&symbol| (symbol, Arc::from([*place]))));
        }
        for (symbol, input) in &search.followed {
            let followed = places.get(input).cloned();
            places.extend(followed.map(|places| (*symbol, places)));
        }
        let everything = given.iter().map(|(place, _)| *place).collect();
        let mut sources = Sources { places, everything };
        for level in &search.levels {
            let together = sources.behind(level);
            sources.places.extend(level.unknowns.iter().map(|&unknown| (unknown, together.clone())));
        }
        let (symbols, values): (Vec<Symbol>, Vec<Expr>) =
            search.solved.iter().map(|(&symbol, &value)| (symbol, value)).unzip();
        let solved = sources.of(arena, &values);
        sources.places.extend(symbols.into_iter().zip(solved));
        sources
    }

    /// What each of these expressions contains; everything if that is much.
    pub fn of(&self, arena: &Arena, values: &[Expr]) -> Vec<Arc<[usize]>> {
        footprints(arena, values, |symbol| self.places.get(&symbol).cloned(), (self.everything.clone(), LISTED))
    }

    /// What is in the equations of a level.
    fn behind(&self, level: &Level) -> Arc<[usize]> {
        // Many unknowns share one long list.
        let lists: HashMap<*const usize, &Arc<[usize]>> =
            level.knowns.iter().filter_map(|known| self.places.get(known)).map(|list| (list.as_ptr(), list)).collect();
        let all: BTreeSet<usize> = lists.values().flat_map(|list| list.iter().copied()).collect();
        if all.len() > LISTED { self.everything.clone() } else { all.into_iter().collect() }
    }
}
