//! Masses on a line (25)-(33): the cutset matrix by kinds of elements, and M, D, K as its products.

use cotree::component::Origin;
use cotree::equations::Vibration;
use cotree::expr::Expr;
use cotree::graph::ElementId;
use cotree::mechanism::Formula;
use nalgebra::DMatrix;

use super::graphs::table;
use super::numbers::agree;
use super::view::TopologyRow;
use super::{Lesson, check, columns, words};
use crate::document::Block;
use crate::motion::vibration;
use crate::name::Name;
use crate::tree::Tree;

/// Wider matrices are not written out.
const WIDEST: usize = 24;

/// The columns of one kind: its letter, the elements, and their constants.
struct ElementKind {
    letter: &'static str,
    title: &'static str,
    elements: Vec<(String, Expr)>,
}

/// The matrices of a scene on a line; nothing for a scene in the plane.
pub fn matrices(lesson: &mut Lesson) -> Vec<Block> {
    let matrices = match lesson.equations.linear() {
        None => return Vec::new(),
        Some(Err(why)) => return vec![words(format!("There are no matrices D and K (24): {why}."))],
        Some(Ok(matrices)) => matrices,
    };
    let kinds = kinds(lesson);
    let rows = rows(lesson);
    let mut blocks = vec![words(
        "On a line the cutset matrix alone gives everything. Its columns sorted by kinds of elements, masses, dampers, springs, other loads (25)-(27); its \
         rows are those of the coordinates:",
    )];
    for kind in &kinds {
        let names: Vec<String> = kind.elements.iter().map(|(label, _)| label.clone()).collect();
        if names.len() <= WIDEST {
            let sign =
                |row: &TopologyRow, name: &String| row.iter().find(|(own, _)| own == name).map_or(0, |(_, sign)| *sign);
            let signs = rows.iter().map(|(own, row)| (own.clone(), names.iter().map(|name| sign(row, name)).collect()));
            let signs: Vec<(String, Vec<i8>)> = signs.collect();
            blocks.extend(table(&format!("The part {} of the cutset matrix", kind.title), kind.title, names, signs));
        }
    }
    blocks.extend(products(&kinds));
    blocks.extend(entries(lesson));
    let same = agrees(lesson, &kinds, &rows, &matrices);
    blocks.push(check("the three products in numbers are M, D and K, and these are symmetric", same));
    blocks.extend(floating(lesson, &kinds, &rows, &matrices));
    blocks
}

/// Whether anything holds the masses to the ground: what K and D make of a shift of all masses together.
fn floating(
    lesson: &Lesson,
    kinds: &[ElementKind],
    rows: &[(String, TopologyRow)],
    vibration: &Vibration,
) -> Option<Block> {
    let masses = &kinds.iter().find(|kind| kind.letter == "m")?.elements;
    let n = rows.len();
    if masses.len() != n || n == 0 || n > WIDEST {
        return None;
    }
    let shift = signs(rows, masses).transpose().lu().solve(&DMatrix::from_element(n, 1, 1.0))?;
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
fn kinds(lesson: &mut Lesson) -> Vec<ElementKind> {
    let mut kinds = [("m", "A_m"), ("d", "A_d"), ("k", "A_k"), ("F", "A_F")].map(|(letter, title)| ElementKind {
        letter,
        title,
        elements: Vec::new(),
    });
    let mechanism = &*lesson.equations.system.mechanism.clone();
    for id in (0..lesson.equations.system.elements.len()).map(ElementId) {
        let element = lesson.equations.system.element(id).clone();
        let zero = Formula::Number(0.0);
        match element.origin {
            Origin::Body(body) => {
                let mass = mechanism.bodies[body.0].mass.as_ref().unwrap_or(&zero);
                let mass = lesson.equations.system.value(mass);
                kinds[0].elements.push((element.label, mass));
            }
            Origin::Load(load) => {
                let part = &mechanism.loads[load.0];
                let mut other = true;
                for (place, key) in [(1, "damping"), (2, "stiffness")] {
                    if *part.formula(key) != zero {
                        let constant = lesson.equations.system.value(part.formula(key));
                        kinds[place].elements.push((element.label.clone(), constant));
                        other = false;
                    }
                }
                if other {
                    kinds[3].elements.push((element.label, Expr::ONE));
                }
            }
            _ => {}
        }
    }
    kinds.into_iter().filter(|kind| !kind.elements.is_empty()).collect()
}

/// The cutsets of the coordinates, found from the nodes.
fn rows(lesson: &Lesson) -> Vec<(String, TopologyRow)> {
    let view = &lesson.translation;
    let branch = |id: ElementId| view.branches.iter().find(move |branch| branch.element == id);
    let own = lesson.equations.coordinates.iter().filter_map(|own| branch(own.element));
    own.map(|branch| (branch.label.clone(), view.cut(branch))).collect()
}

/// (28) to (33)
fn products(kinds: &[ElementKind]) -> Vec<Block> {
    let diagonal = |letter: &str| Tree::Name(Name::matrix(letter, ""));
    let column = |base: &str, dots: usize| {
        let own = Name::column(base, "");
        Tree::Name(Name { plain: format!("{{{base}{}}}", &"''"[..dots]), dots, ..own })
    };
    let matrix = |kind: &ElementKind| Tree::Name(Name::matrix("A", kind.letter));
    let transposed = |kind: &ElementKind| Tree::power(matrix(kind), Tree::Name(Name::letter("T", "")));
    let balance = kinds.iter().map(|kind| {
        let force = Tree::Name(Name::column("F", kind.letter));
        (false, Tree::product(vec![matrix(kind), force]))
    });
    let mut rows = vec![(Tree::sum(balance.collect()), Tree::zero())];
    let mut sum = Vec::new();
    for kind in kinds.iter().filter(|kind| kind.letter != "F") {
        let dots = match kind.letter {
            "m" => 2,
            "d" => 1,
            _ => 0,
        };
        let law = Tree::product(vec![diagonal(kind.letter), column("x", dots)]);
        rows.push((Tree::Name(Name::column("F", kind.letter)), Tree::Sum(vec![(true, law)])));
        rows.push((column("x", dots), Tree::product(vec![transposed(kind), column("q", dots)])));
        sum.push((
            false,
            Tree::product(vec![matrix(kind), diagonal(kind.letter), transposed(kind), column("q", dots)]),
        ));
    }
    let right = kinds
        .iter()
        .find(|kind| kind.letter == "F")
        .map_or_else(Tree::zero, |kind| Tree::product(vec![matrix(kind), Tree::Name(Name::column("F", "F"))]));
    rows.push((Tree::sum(sum), right));
    let text = "Cutsets (28), terminal equations with diagonal m, d, k (29), circuits, which are the transposes by (13) (30)-(32), and the result (33); \
                free lengths and weights are with the forces:";
    vec![words(text), Block::Equations(rows)]
}

/// The entries of D and K, and of {F}; those of M are above.
fn entries(lesson: &mut Lesson) -> Vec<Block> {
    let (names, exprs) = columns(vibration(&mut lesson.equations).into_iter().flat_map(|(_, entries)| entries));
    lesson.equations(names, &exprs)
}

/// A square matrix at the start.
fn numbers(lesson: &Lesson, matrix: &[Vec<Expr>]) -> DMatrix<f64> {
    DMatrix::from_row_slice(matrix.len(), matrix.len(), &lesson.at_start(&matrix.concat()))
}

/// The columns of some elements in the rows of the cutset matrix.
fn signs(rows: &[(String, TopologyRow)], elements: &[(String, Expr)]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), elements.len(), |row, column| {
        let sign = rows[row].1.iter().find(|(label, _)| *label == elements[column].0);
        sign.map_or(0.0, |(_, sign)| f64::from(*sign))
    })
}

/// The products in numbers.
fn agrees(lesson: &Lesson, kinds: &[ElementKind], rows: &[(String, TopologyRow)], vibration: &Vibration) -> bool {
    let n = rows.len();
    [("m", &vibration.mass), ("d", &vibration.damping), ("k", &vibration.stiffness)].into_iter().all(
        |(letter, matrix)| {
            let own = numbers(lesson, matrix);
            let elements = kinds.iter().find(|kind| kind.letter == letter).map_or(&[][..], |kind| &kind.elements);
            let a = signs(rows, elements);
            let constants: Vec<Expr> = elements.iter().map(|(_, constant)| *constant).collect();
            let constants = lesson.at_start(&constants);
            let scaled = DMatrix::from_fn(n, elements.len(), |row, column| a[(row, column)] * constants[column]);
            let product = scaled * a.transpose();
            agree(product.as_slice(), own.as_slice()) && agree(own.as_slice(), own.transpose().as_slice())
        },
    )
}
