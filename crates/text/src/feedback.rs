//! Loads that read accelerations or reactions: printed as a term in addition to {Q}, which is a function of positions and rates.

use cotree::equations::{Constraint, Equations, RowKind};
use cotree::expr::{Expr, Symbol};
use cotree::network::{Constrained, Direction, Force};

use super::motion::{Entry, has_masses};
use super::name::{Name, symbol_name};

/// What such loads add to {Q}, and their laws.
pub fn feedback(equations: &mut Equations) -> [(&'static str, Vec<Entry>); 2] {
    let titles = ["Loads that read accelerations or reactions", "Their laws"];
    if !equations.constraints.iter().any(|row| matches!(row.kind, RowKind::LoadValue)) || !has_masses(equations) {
        return titles.map(|title| (title, Vec::new()));
    }
    let loads = beside_load(equations, |row| matches!(row.kind, RowKind::LoadValue), "feedback");
    let laws = equations.feedback();
    let laws = laws.into_iter().map(|law| (symbol_name(equations, Symbol::Reaction(law.row)), law.value)).collect();
    let [first, second] = titles;
    [(first, loads), (second, laws)]
}

/// What the multipliers of these rows add to {Q}, under this word.
pub fn beside_load(equations: &mut Equations, which: fn(&Constraint) -> bool, word: &str) -> Vec<Entry> {
    let reactions = equations.dynamics().reactions.clone();
    let mut entries = Vec::new();
    for (coordinate, row) in reactions.into_iter().enumerate() {
        let levels = row.into_iter().filter(|(index, _)| which(&equations.constraints[*index]));
        let levels: Vec<(usize, Expr)> = levels.collect();
        let arena = &mut equations.system.arena;
        let force = levels.into_iter().fold(Expr::ZERO, |sum, (index, entry)| {
            let level = arena.symbol(Symbol::Reaction(index));
            arena.subtract_product(sum, entry, level)
        });
        if force != Expr::ZERO {
            let number = coordinate + 1;
            let name = Name::letter("Q", &format!("{number}, {word}"));
            entries.push((Name { plain: format!("Q_{word}[{number}]"), ..name }, force));
        }
    }
    entries
}

/// What the value of such a load is called: the variable that it is, or a component in the axes of a body, which is none.
pub fn value_name(equations: &Equations, row: &Constraint) -> Name {
    let load = equations.system.name(row.element);
    let in_body = equations.system.element(row.element).translation.as_ref();
    let in_body = in_body.is_some_and(|row| matches!(row.through, Force::InBody(..)));
    let axis = if row.constrained == Constrained::Along(Direction::X) { "x" } else { "y" };
    match row.constrained {
        Constrained::Angle => Name::variable(&format!("{load}.torque")),
        Constrained::Length => Name::variable(&format!("{load}.force")),
        Constrained::Along(_) if in_body => {
            Name { plain: format!("f[{load},{axis}]"), ..Name::letter("f", &format!("{load}, {axis}")) }
        }
        Constrained::Along(_) => Name::variable(&format!("{load}.f{axis}")),
    }
}
