//! Drivers that contradict what joints hold: where a run starts they agree, along the motion that they prescribe they do not.

use std::collections::BTreeSet;

use super::explain::assembly::{circuit_names, owner_span, show};
use super::restrictions::{Restrictions, owners};
use crate::diagnostic::Fault;
use crate::diagnostic::suggest::list;
use crate::equations::Standing;
use crate::network::Constrained;
use crate::redundancy::prescribed::first_contradiction;
use crate::typeset::rounded;

/// Loop equations that were left out because they repeat others at the start must hold along the motion, too.
pub(super) fn contradiction(found: &Restrictions) -> Option<Fault> {
    let Restrictions { equations, model, state, .. } = found;
    let kept = equations.rows_of(Standing::Imposed);
    let mut all = [kept.clone(), equations.rows_of(Standing::Repeats)].concat();
    all.sort_unstable();
    let open = first_contradiction(model, state, &kept, &all)?;
    let involved: BTreeSet<String> =
        open.rows.iter().flat_map(|&row| circuit_names(equations, &equations.constraints[row])).collect();
    let holding = owners(equations, &open.rows);
    let takes_part = |name: &String| involved.contains(name) || holding.contains(name);
    let drivers = equations.system.mechanism.drivers.iter().map(|driver| driver.name.clone());
    let drivers: Vec<String> = drivers.filter(takes_part).collect();
    let joints: Vec<String> = holding.into_iter().filter(|name| !drivers.contains(name)).collect();
    let last = drivers.last()?;
    let row = &equations.constraints[open.row];
    let owner = &equations.system.element(row.element).name;
    let [until, time] = open.times.map(|time| rounded(time, 4));
    let whose = if joints.is_empty() { "each other".to_owned() } else { list(&joints) };
    let message = format!(
        "{} {} {whose}: the constraints are compatible until t = {until} s, but at t = {time} s `{owner}` is open by {}",
        list(&drivers),
        if drivers.len() == 1 { "contradicts" } else { "contradict" },
        show(open.gap, row.constrained == Constrained::Angle),
    );
    let fault = Fault::new("scene::conflict", message, owner_span(equations, last));
    Some(fault.label("incompatible with the other constraints").help(
        "no motion satisfies the drivers and keeps all joints closed: make the laws of the drivers agree, remove a driver, or add a degree of freedom",
    ))
}
