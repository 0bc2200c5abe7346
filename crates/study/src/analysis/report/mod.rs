//! Results of the analyses and their reports.

mod changes;
mod equilibrium;
mod linear;
mod modes;

use cotree::report::data::{Cell, Table, number, plain, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::ContactStatus;

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
fn contact_groups(statuses: &[ContactStatus], group: &str) -> Vec<(String, f64, String)> {
    let values = |status: &ContactStatus| {
        let [length, force] = status.units();
        let (value, si) = match status.group() {
            "open" => (status.gap, length),
            "free" => (status.rate, status.unit_of_rate()),
            _ => (status.force, force),
        };
        let named = |word: &str, value: f64, si: &str| (format!("{}{word}", status.name), value, si.to_owned());
        let more = [
            status.most().map(|most| named(".most", most, force)),
            status.direction().map(|direction| named(".direction", direction, "")),
        ];
        std::iter::once(named("", value, si)).chain(more.into_iter().flatten()).collect::<Vec<_>>()
    };
    statuses.iter().filter(|status| status.group() == group).flat_map(values).collect()
}

/// How everything is held that need not be, one table each.
fn contact_tables(statuses: &[ContactStatus]) -> impl Iterator<Item = Table> + '_ {
    let table = |group| {
        let rows = contact_groups(statuses, group);
        (!rows.is_empty())
            .then(|| Table::list(group, rows.iter().map(|(name, value, si)| row![name, number(*value, si), unit(si)])))
    };
    GROUPS.into_iter().filter_map(table)
}

/// The same as data; of stops both words, which of them are open or closed is asked for most.
fn contact_data(statuses: &[ContactStatus], data: &mut Value) {
    let is_stop = |status: &ContactStatus| GROUPS[..2].contains(&status.group());
    for group in GROUPS {
        let values = contact_groups(statuses, group);
        if !values.is_empty() || GROUPS[..2].contains(&group) && statuses.iter().any(is_stop) {
            data[group] = values.into_iter().map(|(name, value, _)| (name, json!(value))).collect();
        }
    }
}
