//! The equations of motion as text.

use std::fmt::Write;

use super::formula::Printer;
use super::symbol_name;
use crate::element::{Direction, Held};
use crate::equations::Equations;
use crate::expr::{Expr, Symbol};

/// A titled list of named expressions.
type Block = (&'static str, Vec<(String, Expr)>);

/// Coordinates, reactions, and M, Q, Phi, Phi_q, gamma in the user's names. A kinematic model whose bodies have no mass has
/// no M and Q.
pub fn text(equations: &mut Equations) -> String {
    let dynamic = has_masses(equations);
    let blocks = blocks(equations, dynamic);
    let roots: Vec<Expr> = blocks.iter().flat_map(|(_, rows)| rows.iter().map(|(_, expr)| *expr)).collect();
    let equations = &*equations;
    let name = |symbol: Symbol| symbol_name(equations, symbol);
    let (printer, shared) = Printer::new(&equations.system.arena, &name, &roots);
    let mut text = heading(equations, dynamic);
    if !shared.is_empty() {
        section(&mut text, "with", shared.iter().map(|(name, expr)| (name.clone(), printer.definition(*expr))));
    }
    for (title, rows) in &blocks {
        section(&mut text, title, rows.iter().map(|(name, expr)| (name.clone(), printer.print(*expr))));
    }
    text
}

/// Are all masses and inertias that the equations need given?
pub(super) fn has_masses(equations: &mut Equations) -> bool {
    let dynamics = equations.dynamics();
    let mut roots: Vec<Expr> = dynamics.load.clone();
    roots.extend(dynamics.mass.iter().flatten().map(|(_, entry)| *entry));
    !equations.system.arena.symbols(roots).into_iter().any(|symbol| matches!(symbol, Symbol::Missing(..)))
}

fn heading(equations: &Equations, dynamic: bool) -> String {
    let mut text = format!("Equations of motion of `{}`\n", equations.system.mechanism.name);
    // Writing to a String cannot fail.
    let _ = if dynamic && equations.constraints.is_empty() {
        writeln!(text, "  M a = Q")
    } else if dynamic {
        writeln!(text, "  M a + Phi_q^T lambda = Q,  Phi = 0,  Phi_q v = -Phi_t,  Phi_q a = gamma")
    } else {
        writeln!(text, "  Phi = 0,  Phi_q v = -Phi_t,  Phi_q a = gamma")
    };
    let coordinates = equations.coordinates.iter().enumerate().map(|(index, coordinate)| {
        let unit = if coordinate.angular { "rad" } else { "m" };
        (format!("q{}", index + 1), format!("{} [{unit}], rate {}", coordinate.name.position, coordinate.name.rate))
    });
    section(&mut text, "coordinates q", coordinates);
    let reactions = equations.constraints.iter().enumerate().map(|(index, constraint)| {
        let along = match constraint.held {
            Held::Along(Direction::X) => "force along x [N]",
            Held::Along(Direction::Y) => "force along y [N]",
            Held::Along(Direction::Fixed(..)) => "force along the direction that it holds [N]",
            Held::Length => "force along the line that it holds [N]",
            Held::Angle => "torque [N.m]",
        };
        (format!("lambda{}", index + 1), format!("{} of {}", along, equations.system.element(constraint.element).name))
    });
    section(&mut text, "reactions lambda", reactions);
    text
}

fn blocks(equations: &mut Equations, dynamic: bool) -> Vec<Block> {
    let mut blocks = Vec::new();
    if dynamic {
        let dynamics = equations.dynamics().clone();
        let mass = dynamics.mass.iter().enumerate().flat_map(|(row, entries)| {
            let upper = entries.iter().filter(move |(column, _)| *column >= row);
            upper.map(move |(column, entry)| (format!("M[{},{}]", row + 1, column + 1), *entry))
        });
        blocks.push(("mass matrix M (symmetric, zeros left out)", mass.collect()));
        let load = dynamics.load.iter().enumerate().map(|(row, entry)| (format!("Q[{}]", row + 1), *entry));
        blocks.push(("loads Q", load.collect()));
    }
    let rows = |of: fn(&crate::equations::Constraint) -> Expr, symbol: &str| {
        let rows = equations.constraints.iter().enumerate();
        rows.map(|(index, constraint)| (format!("{symbol}[{}]", index + 1), of(constraint))).collect::<Vec<_>>()
    };
    let jacobian = equations.constraints.iter().enumerate().flat_map(|(row, constraint)| {
        constraint.jacobian.iter().map(move |(column, entry)| (format!("Phi_q[{},{}]", row + 1, column + 1), *entry))
    });
    blocks.push(("loop equations Phi", rows(|constraint| constraint.value, "Phi")));
    blocks.push(("Jacobian Phi_q (zeros left out)", jacobian.collect()));
    blocks.push(("rates Phi_t", rows(|constraint| constraint.time_rate, "Phi_t")));
    blocks.push(("gamma", rows(|constraint| constraint.gamma, "gamma")));
    blocks.retain(|(_, rows)| !rows.is_empty());
    blocks
}

fn section(text: &mut String, title: &str, rows: impl Iterator<Item = (String, String)>) {
    let rows: Vec<(String, String)> = rows.collect();
    if rows.is_empty() {
        return;
    }
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or_default();
    // Writing to a String cannot fail.
    let _ = writeln!(text, "\n{title}");
    for (name, value) in rows {
        let _ = writeln!(text, "  {name:width$} = {value}");
    }
}
