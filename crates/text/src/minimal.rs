//! The reduced equations in independent coordinates: with a = R a_w + g, where a_w are the accelerations of the independent coordinates,
//! R^T M R a_w = R^T (Q - M g). The multipliers are gone; the dependent coordinates follow from the loop equations, in closed form where each of these
//! has one unknown angle or displacement.

mod closed;
mod solve;

use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol};
use cotree::formulate::Formulated;
use cotree::resolve::symbolic::{Style, Symbolic};

use super::document::{DocumentBlock, Piece};
use super::motion::{Entry, MotionEquations, has_masses};
use super::name::Name;
use super::symbols::{values, with_names};
use super::tree::FormulaTree;
use super::{SymbolNotation, json, page};
use crate::steps::Moment;
use closed::Closed;
pub use solve::SingularStart;
use solve::{Solved, solve};

/// The equations with their independent coordinates first.
struct Minimal {
    independent: Vec<usize>,
    dependent: Vec<usize>,
    motion: MotionEquations,
    /// Coordinates whose loop equation has no closed form.
    open: Vec<usize>,
}

/// The reduced equations, with a name for every number on request.
///
/// # Errors
/// Why there are none: the loops do not determine a choice of coordinates where the motion starts.
pub fn minimal(formulated: &mut Formulated, written: SymbolNotation, symbols: bool) -> Result<String, SingularStart> {
    let start = Moment::new(&formulated.equations.system.mechanism, &formulated.state);
    if !symbols {
        return reduced(&mut formulated.equations, &start, Vec::new(), written);
    }
    let symbolic = Symbolic::new(&formulated.equations.system, Style::Owners);
    let mut renamed = with_names(&formulated.equations, &symbolic);
    let start = Moment::new(&symbolic.mechanism, &formulated.state);
    let blocks = values(&mut renamed, &symbolic.named);
    reduced(&mut renamed, &start, blocks, written)
}

fn reduced(
    equations: &mut Equations,
    start: &Moment,
    mut blocks: Vec<DocumentBlock>,
    written: SymbolNotation,
) -> Result<String, SingularStart> {
    let minimal = Minimal::new(equations, start)?;
    match written {
        SymbolNotation::Json => {
            let mut value = json::described(equations, &minimal.motion);
            let names = minimal
                .independent
                .iter()
                .map(|&independent| equations.coordinates[independent].name.position.as_str());
            value["independent"] = names.collect();
            Ok(format!("{value:#}\n"))
        }
        SymbolNotation::Prose(prose) => {
            blocks.extend(minimal.blocks(equations));
            let title = format!("Reduced equations of motion of {}", equations.system.mechanism.name);
            Ok(page(&title, &blocks, prose))
        }
    }
}

impl Minimal {
    fn new(equations: &mut Equations, start: &Moment) -> Result<Minimal, SingularStart> {
        let rows: Vec<usize> = equations.loops().filter(|(_, row)| !row.repeats()).map(|(index, _)| index).collect();
        let solved = solve(equations, start, &rows)?;
        let dynamic = has_masses(equations);
        let mut groups = Vec::new();
        if dynamic {
            groups.extend(motion_equations(equations, &solved));
        }
        let closed = Closed::new(equations, start, &rows, &solved.dependent);
        groups.push(("Dependent coordinates", entries(equations, &closed.positions, Order::Position)));
        let rates = followed(equations, &solved, Order::Velocity, &solved.rates);
        groups.push(("Their rates", entries(equations, &rates, Order::Velocity)));
        let accelerations = followed(equations, &solved, Order::Acceleration, &solved.accelerations);
        groups.push(("Their accelerations", entries(equations, &accelerations, Order::Acceleration)));
        let open: Vec<Entry> = closed
            .rows
            .iter()
            .map(|&(number, index)| (Name::entry("Phi", &[number]), equations.constraints[index].value))
            .collect();
        groups.push(("Loop equations without a closed form: = 0", open));
        groups.retain(|(_, entries)| !entries.is_empty());
        let Solved { independent, dependent, .. } = solved;
        Ok(Minimal {
            independent,
            dependent,
            open: closed.open,
            motion: MotionEquations { groups, dynamic, sums: Vec::new() },
        })
    }

    fn blocks(&self, equations: &mut Equations) -> Vec<DocumentBlock> {
        let names = |columns: &[usize]| {
            let name = |&column: &usize| equations.coordinates[column].name.position.clone();
            columns.iter().map(name).collect::<Vec<_>>().join(", ")
        };
        let mut blocks = vec![DocumentBlock::Heading("Coordinates".into())];
        let independent = match self.independent.len() {
            0 => "There are no independent coordinates: the drivers prescribe every motion.".to_owned(),
            count => format!("Independent, as many as degrees of freedom ({count}): {}.", names(&self.independent)),
        };
        blocks.push(DocumentBlock::Text(vec![Piece::words(independent)]));
        if !self.dependent.is_empty() {
            let text = format!(
                "Dependent, through the loop equations: {}. The choice is that of the start.",
                names(&self.dependent)
            );
            blocks.push(DocumentBlock::Text(vec![Piece::words(text)]));
        }
        if !self.open.is_empty() {
            let text = format!(
                "No loop equation gives one of these alone, so they are solved for by iteration: {}.",
                names(&self.open)
            );
            blocks.push(DocumentBlock::Text(vec![Piece::words(text)]));
        }
        if self.motion.dynamic && !self.independent.is_empty() {
            let product = FormulaTree::product(vec![
                FormulaTree::Name(Name::matrix("M", "")),
                FormulaTree::Name(Name::column("a", "")),
            ]);
            blocks.push(DocumentBlock::Equations(vec![(product, FormulaTree::Name(Name::column("Q", "")))]));
            blocks.push(DocumentBlock::Text(vec![Piece::words(
                "with the accelerations {a} of the independent coordinates alone.",
            )]));
        }
        blocks.extend(self.motion.formula_blocks(equations));
        blocks
    }
}

/// R^T M R and R^T (Q - M g)
fn motion_equations(equations: &mut Equations, solved: &Solved) -> [(&'static str, Vec<Entry>); 2] {
    let dynamics = equations.dynamics().clone();
    let n = equations.coordinates.len();
    let arena = &mut equations.system.arena;
    let count = solved.independent.len();
    // M R, and Q - M g
    let mut products = vec![vec![Expr::ZERO; count]; n];
    let mut rest = dynamics.load.clone();
    for (row, entries) in dynamics.mass.iter().enumerate() {
        for &(column, entry) in entries {
            for (place, product) in products[row].iter_mut().enumerate() {
                *product = arena.add_product(*product, entry, solved.ratio(column, place));
            }
            rest[row] = arena.subtract_product(rest[row], entry, solved.acceleration(column));
        }
    }
    let (mut mass, mut load) = (Vec::new(), Vec::new());
    for place in 0..count {
        let column = |arena: &mut cotree::expr::Arena, of: &dyn Fn(usize) -> Expr| {
            (0..n).fold(Expr::ZERO, |sum, row| arena.add_product(sum, solved.ratio(row, place), of(row)))
        };
        for other in place..count {
            let entry = column(arena, &|row| products[row][other]);
            if entry != Expr::ZERO {
                mass.push((Name::entry("M", &[place, other]), entry));
            }
        }
        load.push((Name::entry("Q", &[place]), column(arena, &|row| rest[row])));
    }
    [("Mass matrix (symmetric; zeros left out)", mass), ("Loads", load)]
}

fn entries(equations: &Equations, values: &[(usize, Expr)], order: Order) -> Vec<Entry> {
    let name = |column| super::name::symbol_name(equations, Symbol::Coordinate(column, order));
    values.iter().map(|&(column, value)| (name(column), value)).collect()
}

/// v_u = R v_w + r, or a_u = R a_w + g
fn followed(equations: &mut Equations, solved: &Solved, order: Order, constants: &[Expr]) -> Vec<(usize, Expr)> {
    let arena = &mut equations.system.arena;
    let mut values = Vec::new();
    for (&column, &constant) in solved.dependent.iter().zip(constants) {
        let mut value = constant;
        for (place, &independent) in solved.independent.iter().enumerate() {
            let symbol = arena.symbol(Symbol::Coordinate(independent, order));
            value = arena.add_product(value, solved.ratio(column, place), symbol);
        }
        values.push((column, value));
    }
    values
}
