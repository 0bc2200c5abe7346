//! Masses on a line (25)-(33): the cutset matrix by kinds of elements, and M, D, K as its products.

use cotree::equations::{ElementColumn, Vibration};
use cotree::expr::{Expr, Order, Symbol};
use cotree::network::{ElementId, Origin};
use cotree_study::analysis::dense;
use nalgebra::DMatrix;

use super::graphs::table;
use super::numbers::agree;
use super::{Lesson, check, columns, words};
use crate::document::DocumentBlock;
use crate::motion::vibration;
use crate::name::Name;
use crate::tree::FormulaTree;

/// Wider matrices are not written out.
const WIDEST: usize = 24;

/// The columns of one kind: its letter, and the elements with their constants.
struct ElementKind<'m> {
    letter: &'static str,
    columns: Vec<(&'m ElementColumn, Expr)>,
}

/// The matrices of a scene on a line; nothing for a scene in the plane.
pub fn matrices(lesson: &mut Lesson) -> Vec<DocumentBlock> {
    let matrices = match lesson.equations.linear() {
        None => return Vec::new(),
        Some(Err(why)) => return vec![words(format!("There are no matrices D and K (24): {why}."))],
        Some(Ok(matrices)) => matrices,
    };
    let kinds = kinds(lesson, &matrices);
    let mut blocks = vec![words(
        "On a line the cutset matrix alone gives everything. Its columns sorted by kinds of elements, masses, dampers, springs, other loads (25)-(27); its \
         rows are those of the coordinates:",
    )];
    let label = |element: ElementId| lesson.equations.system.element(element).label.clone();
    for kind in kinds.iter().filter(|kind| kind.columns.len() <= WIDEST) {
        let title = format!("A_{}", kind.letter);
        let sign = |row, column: &ElementColumn| {
            column.signs.iter().find(|(place, _)| *place == row).map_or(0, |(_, sign)| *sign)
        };
        let signs = |row| kind.columns.iter().map(|(column, _)| sign(row, column)).collect();
        let rows = lesson
            .equations
            .coordinates
            .iter()
            .zip(0..)
            .map(|(coordinate, row)| (label(coordinate.element), signs(row)));
        let names = kind.columns.iter().map(|(column, _)| label(column.element)).collect();
        blocks.extend(table(&format!("The part {title} of the cutset matrix"), &title, names, rows.collect()));
    }
    blocks.extend(products(&kinds));
    blocks.extend(entries(lesson));
    let same = agrees(lesson, &kinds);
    blocks.push(check("the three products in numbers are M, D and K, and these are symmetric", same));
    blocks.extend(floating(lesson, &kinds, &matrices));
    blocks
}

/// Whether anything holds the masses to the ground: what K and D make of a shift of all masses together.
fn floating(lesson: &Lesson, kinds: &[ElementKind], vibration: &Vibration) -> Option<DocumentBlock> {
    let masses = &kinds.iter().find(|kind| kind.letter == "m")?.columns;
    let n = vibration.force.len();
    if masses.len() != n || n == 0 || n > WIDEST {
        return None;
    }
    let shift = signs(n, masses).transpose().lu().solve(&DMatrix::from_element(n, 1, 1.0))?;
    let held = |matrix: &[Vec<Expr>]| {
        let matrix = numbers(lesson, matrix);
        (&matrix * &shift).amax() > 1e-9 * matrix.amax()
    };
    if held(&vibration.stiffness) || held(&vibration.damping) {
        return None;
    }
    let numbers: Vec<String> = shift.iter().map(|value| (value + 0.0).to_string()).collect();
    Some(words(format!(
        "Free-floating: K and D times {{q}} = {{{}}}, the shift of all masses together, are zero, so no spring or damper holds them to the ground; \
         every tree contains a mass.",
        numbers.join(", ")
    )))
}

/// Bodies, dampers, springs, other loads. A spring with a damper is in two.
fn kinds<'m>(lesson: &Lesson, vibration: &'m Vibration) -> Vec<ElementKind<'m>> {
    let mut kinds = ["m", "d", "k", "F"].map(|letter| ElementKind { letter, columns: Vec::new() });
    for column in &vibration.columns {
        let laws =
            [(1, column.damping), (2, column.stiffness)].into_iter().filter(|(_, constant)| *constant != Expr::ZERO);
        let mut constants: Vec<(usize, Expr)> = laws.collect();
        match lesson.equations.system.element(column.element).origin {
            Origin::Body(_) => constants.push((0, column.mass)),
            Origin::Load(_) if constants.is_empty() => constants.push((3, Expr::ONE)),
            _ => {}
        }
        constants.into_iter().for_each(|(kind, constant)| kinds[kind].columns.push((column, constant)));
    }
    kinds.into_iter().filter(|kind| !kind.columns.is_empty()).collect()
}

/// (28) to (33)
fn products(kinds: &[ElementKind]) -> Vec<DocumentBlock> {
    let diagonal = |letter: &str| FormulaTree::Name(Name::matrix(letter, ""));
    let column = |base: &str, dots: usize| {
        let name = Name::column(base, "");
        FormulaTree::Name(Name { plain: format!("{{{base}{}}}", &"''"[..dots]), dots, ..name })
    };
    let matrix = |kind: &ElementKind| FormulaTree::Name(Name::matrix("A", kind.letter));
    let transposed = |kind: &ElementKind| FormulaTree::power(matrix(kind), FormulaTree::Name(Name::letter("T", "")));
    let balance = kinds.iter().map(|kind| {
        let force = FormulaTree::Name(Name::column("F", kind.letter));
        (false, FormulaTree::product(vec![matrix(kind), force]))
    });
    let mut rows = vec![(FormulaTree::sum(balance.collect()), FormulaTree::zero())];
    let mut sum = Vec::new();
    for kind in kinds.iter().filter(|kind| kind.letter != "F") {
        let dots = match kind.letter {
            "m" => 2,
            "d" => 1,
            _ => 0,
        };
        let law = FormulaTree::product(vec![diagonal(kind.letter), column("x", dots)]);
        rows.push((FormulaTree::Name(Name::column("F", kind.letter)), FormulaTree::Sum(vec![(true, law)])));
        rows.push((column("x", dots), FormulaTree::product(vec![transposed(kind), column("q", dots)])));
        sum.push((
            false,
            FormulaTree::product(vec![matrix(kind), diagonal(kind.letter), transposed(kind), column("q", dots)]),
        ));
    }
    let right = kinds.iter().find(|kind| kind.letter == "F").map_or_else(FormulaTree::zero, |kind| {
        FormulaTree::product(vec![matrix(kind), FormulaTree::Name(Name::column("F", "F"))])
    });
    rows.push((FormulaTree::sum(sum), right));
    let text = "Cutsets (28), terminal equations with diagonal m, d, k (29), circuits, which are the transposes by (13) (30)-(32), and the result (33); \
                free lengths and weights are with the forces:";
    vec![words(text), DocumentBlock::Equations(rows)]
}

/// The entries of D and K, and of {F}; those of M are above.
fn entries(lesson: &mut Lesson) -> Vec<DocumentBlock> {
    let (names, exprs) = columns(vibration(&mut lesson.equations).into_iter().flat_map(|(_, entries)| entries));
    lesson.equations(names, &exprs)
}

/// A square matrix at the start.
fn numbers(lesson: &Lesson, matrix: &[Vec<Expr>]) -> DMatrix<f64> {
    DMatrix::from_row_slice(matrix.len(), matrix.len(), &lesson.at_start(&matrix.concat()))
}

/// The columns of some elements in the n rows of the cutset matrix.
fn signs(n: usize, columns: &[(&ElementColumn, Expr)]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, columns.len());
    for (place, (column, _)) in columns.iter().enumerate() {
        column.signs.iter().for_each(|&(row, sign)| matrix[(row, place)] = f64::from(sign));
    }
    matrix
}

/// Are the products M, and the slopes of -Q by rates and coordinates, as Step 1 found them?
fn agrees(lesson: &mut Lesson, kinds: &[ElementKind]) -> bool {
    let (n, values) = (lesson.equations.coordinates.len(), lesson.start());
    let dynamics = lesson.equations.dynamics().clone();
    let mut slopes = |order: Order| {
        let arena = &mut lesson.equations.system.arena;
        let entries = dynamics.load.iter().flat_map(|load| (0..n).map(move |column| (*load, column)));
        let slope = |(load, column)| arena.derivative(load, Symbol::Coordinate(column, order));
        let slopes: Vec<Expr> = entries.map(slope).collect();
        -DMatrix::from_row_slice(n, n, &values.of(&lesson.equations, &slopes))
    };
    let (damping, stiffness) = (slopes(Order::Velocity), slopes(Order::Position));
    let mass = dense(&dynamics.mass, n, |exprs| values.of(&lesson.equations, exprs));
    [("m", mass), ("d", damping), ("k", stiffness)].into_iter().all(|(letter, written)| {
        let columns = kinds.iter().find(|kind| kind.letter == letter).map_or(&[][..], |kind| &kind.columns);
        let a = signs(n, columns);
        let constants: Vec<Expr> = columns.iter().map(|(_, constant)| *constant).collect();
        let constants = DMatrix::from_diagonal(&values.of(&lesson.equations, &constants).into());
        let product = &a * constants * a.transpose();
        agree(product.as_slice(), written.as_slice()) && agree(written.as_slice(), written.transpose().as_slice())
    })
}
