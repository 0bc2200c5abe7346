//! Dependency sets of many expressions that share subexpressions: one pass over the subexpressions, each with the set of places that it depends on.
//! Equal sets are stored once, and a set beyond a limit is replaced by the set of all places, so that the cost is linear in the number of subexpressions.

use std::collections::HashMap;
use std::sync::Arc;

use crate::expr::{Arena, Expr, ExprNode, Symbol};

struct Sets {
    sets: Vec<Arc<[usize]>>,
    numbers: HashMap<Arc<[usize]>, usize>,
    unions: HashMap<(usize, usize), usize>,
    most: usize,
}

const NONE: usize = 0;
const EVERYTHING: usize = 1;

/// The dependency set of each root; for a root with more than `most` places, `everything`.
pub(crate) fn dependency_sets(
    arena: &Arena,
    roots: &[Expr],
    places: impl Fn(Symbol) -> Option<Arc<[usize]>>,
    (everything, most): (Arc<[usize]>, usize),
) -> Vec<Arc<[usize]>> {
    let mut sets = Sets { sets: Vec::new(), numbers: HashMap::new(), unions: HashMap::new(), most };
    sets.number(Arc::default());
    sets.sets.push(everything);
    let mut found = vec![NONE; roots.iter().map(|root| root.index() + 1).max().unwrap_or(0)];
    for expr in arena.reachable(roots.iter().copied()) {
        found[expr.index()] = match arena.node(expr) {
            ExprNode::Symbol(symbol) => places(symbol).map_or(NONE, |places| sets.intern(places)),
            node => node.operands().fold(NONE, |set, operand| sets.union(set, found[operand.index()])),
        };
    }
    roots.iter().map(|root| sets.sets[found[root.index()]].clone()).collect()
}

impl Sets {
    fn intern(&mut self, set: Arc<[usize]>) -> usize {
        if set.len() > self.most { EVERYTHING } else { self.number(set) }
    }

    fn number(&mut self, set: Arc<[usize]>) -> usize {
        let next = self.sets.len();
        let number = *self.numbers.entry(set.clone()).or_insert(next);
        if number == next {
            self.sets.push(set);
        }
        number
    }

    fn union(&mut self, a: usize, b: usize) -> usize {
        match (a.min(b), a.max(b)) {
            (NONE, other) => other,
            (EVERYTHING, _) => EVERYTHING,
            (a, b) if a == b => a,
            pair => match self.unions.get(&pair) {
                Some(&union) => union,
                None => {
                    let union = self.merged(pair);
                    self.unions.insert(pair, union);
                    union
                }
            },
        }
    }

    fn merged(&mut self, (a, b): (usize, usize)) -> usize {
        let mut union: Vec<usize> = self.sets[a].iter().chain(&*self.sets[b]).copied().collect();
        union.sort_unstable();
        union.dedup();
        self.intern(union.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Order;

    #[test]
    fn shared_parts_are_counted_once_and_large_sets_are_everything() {
        let mut arena = Arena::default();
        let symbols: Vec<Expr> = (0..5).map(|index| arena.symbol(Symbol::Coordinate(index, Order::Position))).collect();
        let time = arena.symbol(Symbol::Time);
        let pair = arena.multiply(symbols[3], symbols[1]);
        let sum = arena.add(pair, time);
        let product = arena.multiply(sum, pair);
        let all = arena.sum(symbols.iter().copied());
        let places =
            |symbol| if let Symbol::Coordinate(index, _) = symbol { Some(Arc::from([10 * index])) } else { None };
        let everything: Arc<[usize]> = Arc::new([0, 10, 20, 30, 40, 50]);
        let found = dependency_sets(&arena, &[product, time, all, symbols[2]], places, (everything.clone(), 4));
        assert_eq!(found, [Arc::from([10, 30]), Arc::default(), everything, Arc::from([20])]);
    }
}
