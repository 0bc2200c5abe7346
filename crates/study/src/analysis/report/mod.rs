//! Results of the analyses and their reports.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::report::data::{Cell, Table, number, plain, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::Closure;

pub use changes::Features;
pub use equilibrium::Statics;
pub use linear::Linearization;
pub use modes::VibrationModes;

/// `t = 2 s`
fn at(time: f64) -> Cell {
    line!["t = ", number(time, "s")]
}

/// A number without unit as it is.
fn exact(value: f64) -> Cell {
    plain(value, 0.0)
}

/// How parts are held: closed, caught and sticking ones with their forces, open ones with their gaps, free ones with their rates, sliding ones with their friction and its direction.
pub(crate) const GROUPS: [&str; 7] = ["closed", "open", "caught", "free", "sticks", "slides", "idle"];

/// The values and units of what is held so. What sticks has a second one: the most that it could hold.
fn closures_of(closures: &[Closure], group: &str) -> Vec<(String, f64, String)> {
    let values = |closure: &Closure| {
        let [length, force] = closure.units();
        let (value, si) = match closure.group() {
            "open" => (closure.gap, length),
            "free" => (closure.rate, closure.unit_of_rate()),
            _ => (closure.force, force),
        };
        let named = |word: &str, value: f64, si: &str| (format!("{}{word}", closure.name), value, si.to_owned());
        let more = [
            closure.most().map(|most| named(".most", most, force)),
            closure.direction().map(|direction| named(".direction", direction, "")),
        ];
        std::iter::once(named("", value, si)).chain(more.into_iter().flatten()).collect::<Vec<_>>()
    };
    closures.iter().filter(|closure| closure.group() == group).flat_map(values).collect()
}

/// How everything is held that need not be, one table each.
fn closure_tables(closures: &[Closure]) -> impl Iterator<Item = Table> + '_ {
    let table = |group| {
        let rows = closures_of(closures, group);
        (!rows.is_empty())
            .then(|| Table::list(group, rows.iter().map(|(name, value, si)| row![name, number(*value, si), unit(si)])))
    };
    GROUPS.into_iter().filter_map(table)
}

/// The same as data; of stops both words, which of them are open or closed is asked for most.
fn closure_data(closures: &[Closure], data: &mut Value) {
    let is_stop = |closure: &Closure| GROUPS[..2].contains(&closure.group());
    for group in GROUPS {
        let values = closures_of(closures, group);
        if !values.is_empty() || GROUPS[..2].contains(&group) && closures.iter().any(is_stop) {
            data[group] = values.into_iter().map(|(name, value, _)| (name, json!(value))).collect();
        }
    }
}
