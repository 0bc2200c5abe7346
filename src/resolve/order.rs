//! Expressions that use each other by name: each comes after those that it uses, and a circle is a fault.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::Resolver;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::scene::expression::{self, SyntaxKind, SyntaxTree};
use crate::scene::quantity::{Quantity, QuantityReading, Value, read};

/// Which others each uses, by their places.
pub(super) type Uses = BTreeMap<usize, BTreeSet<usize>>;

/// A value that is given by an expression.
pub(super) struct Pending {
    pub text: Text,
    pub tree: SyntaxTree,
}

impl Resolver<'_> {
    /// The values that are expressions which can be parsed, and which of the values each uses; `place` tells the place of a name among them.
    pub(super) fn expressions<'q>(
        &self,
        values: impl Iterator<Item = &'q Quantity>,
        place: fn(Named) -> Option<usize>,
    ) -> (HashMap<usize, Pending>, Uses) {
        let (mut pending, mut uses) = (HashMap::new(), Uses::new());
        for (index, value) in values.enumerate() {
            let Some(expression) = parsed(value) else { continue };
            let used = uses.entry(index).or_default();
            expression.tree.visit_names(&mut |name| used.extend(self.names.get(name).and_then(place)));
            pending.insert(index, expression);
        }
        (pending, uses)
    }

    /// The signals that an expression uses, or whose states it uses.
    pub(super) fn signals_in(&self, text: &Text) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        let tree = expression::parse(text).ok();
        tree.iter().for_each(|tree| tree.visit_names(&mut |name| found.extend(self.signal_in(name))));
        found
    }

    fn signal_in(&self, name: &str) -> Option<usize> {
        let first = name.split('.').next().unwrap_or(name);
        if let Named::Signal(index) = self.names.get(first)? { Some(index) } else { None }
    }

    /// Reports a circle if there is one: names and places, each of which uses the next; the last is the first again.
    pub(super) fn refuse_circle(&mut self, circle: &[(&str, Span)], what: &str, help: &str) {
        let Some((_, span)) = circle.first() else { return };
        let names: Vec<String> = circle.iter().map(|(name, _)| format!("`{name}`")).collect();
        let message = format!("{what} depend on each other in a cycle: {}", names.join(" -> "));
        self.faults.push(Fault::new("scene::cycle", message, *span).label("part of the cycle").help(help));
    }
}

/// A value that is an expression, if it can be parsed.
fn parsed(quantity: &Quantity) -> Option<Pending> {
    let Value::Text(text) = &quantity.value else {
        return None;
    };
    let text = Text::new(text.as_str(), quantity.span);
    if !matches!(read(&text), Ok(QuantityReading::Expression)) {
        return None;
    }
    let tree = expression::parse(&text).ok()?;
    Some(Pending { text, tree })
}

impl SyntaxTree {
    fn visit_names(&self, visit: &mut dyn FnMut(&str)) {
        match &self.kind {
            SyntaxKind::Name(name) => visit(name),
            kind => kind.parts().iter().for_each(|part| part.visit_names(visit)),
        }
    }
}

/// The order of those that depend on no circle, and one circle if there is any.
pub(super) fn sorted(uses: &Uses) -> (Vec<usize>, Vec<usize>) {
    let mut waiting: BTreeMap<usize, usize> = BTreeMap::new();
    let mut users: HashMap<usize, Vec<usize>> = HashMap::new();
    for (&user, used) in uses {
        let used = used.iter().filter(|used| uses.contains_key(used));
        waiting.insert(user, used.clone().count());
        used.for_each(|&used| users.entry(used).or_default().push(user));
    }
    let mut order: Vec<usize> = waiting.iter().filter(|(_, count)| **count == 0).map(|(index, _)| *index).collect();
    let mut done = 0;
    while let Some(&index) = order.get(done) {
        done += 1;
        waiting.remove(&index);
        for user in users.get(&index).into_iter().flatten() {
            if let Some(count) = waiting.get_mut(user) {
                *count -= 1;
                if *count == 0 {
                    order.push(*user);
                }
            }
        }
    }
    (order, circle(uses, &waiting))
}

/// A circle among those that wait for each other.
fn circle(uses: &Uses, waiting: &BTreeMap<usize, usize>) -> Vec<usize> {
    let mut path: Vec<usize> = waiting.keys().take(1).copied().collect();
    let mut at: HashMap<usize, usize> = path.iter().map(|&first| (first, 0)).collect();
    // Each that waits uses another that does, so the walk returns to where it was.
    while let Some(&next) = path.last().and_then(|last| uses[last].iter().find(|used| waiting.contains_key(used))) {
        path.push(next);
        if let Some(start) = at.insert(next, path.len() - 1) {
            return path.split_off(start);
        }
    }
    Vec::new()
}
