//! The derivation as a lesson, in the order of the paper: parts and graphs, trees, cutsets and circuits, terminal equations, Steps 1 to 4, then
//! rates, reactions and what was gained. Every section ends with a check that was carried out.

mod abbreviations;
mod centres;
mod distinct;
mod elimination;
mod gain;
mod graphs;
mod labels;
mod letters;
mod line;
mod numbers;
mod parts;
mod pictures;
mod projection;
mod rates;
mod reactions;
mod results;
mod terminal;
mod trees;
mod view;

use cotree::equations::Equations;
use cotree::expr::Expr;
use cotree::formulate::Formulated;
use cotree::network::{Rotation, Translation};
use cotree::resolve::symbolic::{Style, Symbolic};
use cotree_study::analysis::{AnalysisFailure, state_at};

use super::document::{DocumentBlock, Piece};
use super::motion::{Entry, context, has_masses};
use super::name::Names;
use super::symbols::with_names;
use super::tree::{FormulaTree, formulas};
use super::{Prose, page};
use abbreviations::Abbreviations;
use letters::Letters;
pub use numbers::Moment;
use view::GraphView;

/// The lesson of one mechanism: its equations with names for all numbers, and the mechanism with its numbers at the start.
struct Lesson<'a> {
    equations: Equations,
    source: &'a mut Formulated,
    letters: Letters,
    translation: GraphView<Translation>,
    rotation: GraphView<Rotation>,
    dynamic: bool,
    abbreviations: Abbreviations,
    /// Values that events alone change, as the motion begins with them; or why it does not begin.
    modes: Result<Vec<f64>, AnalysisFailure>,
}

/// The derivation of the equations, as a lesson.
pub fn steps(formulated: &mut Formulated, prose: Prose) -> String {
    let symbolic = Symbolic::new(&formulated.equations.system, Style::Edges);
    let mut equations = with_names(&formulated.equations, &symbolic);
    labels::name_coordinates(&mut equations);
    let mechanism = &*formulated.equations.system.mechanism.clone();
    let mut lesson = Lesson::new(equations, formulated);
    let mut blocks = lesson.parts();
    blocks.extend(lesson.incidence());
    blocks.extend(lesson.trees());
    blocks.extend(lesson.topology());
    blocks.extend(lesson.terminal());
    blocks.extend(lesson.cutset_equations());
    blocks.extend(lesson.circuit_equations());
    blocks.extend(lesson.eliminations());
    blocks.extend(lesson.results());
    blocks.extend(lesson.rates());
    blocks.extend(lesson.reactions());
    blocks.extend(lesson.gain());
    distinct::tell_apart(&mut blocks, mechanism);
    let title = format!("How the equations of motion of {} are derived", mechanism.name);
    page(&title, &blocks, prose)
}

impl<'a> Lesson<'a> {
    fn new(mut equations: Equations, source: &'a mut Formulated) -> Self {
        let dynamic = has_masses(&mut equations);
        let modes = modes_at_start(source);
        let system = &equations.system;
        let (points, bodies) = equations.record();
        Lesson {
            letters: Letters::new(system.mechanism.dimension),
            translation: GraphView { nodes: labels::nodes(system), record: points },
            rotation: GraphView { nodes: labels::bodies(system), record: bodies },
            equations,
            source,
            dynamic,
            abbreviations: Abbreviations::default(),
            modes,
        }
    }

    /// Formulas of expressions, and the abbreviations in them that have not been defined yet.
    fn formulas(&mut self, exprs: &[Expr]) -> (Vec<FormulaTree>, Vec<(FormulaTree, FormulaTree)>) {
        let context = context(&mut self.equations);
        let found = formulas(&self.equations, exprs, &context);
        self.abbreviations.settled(&Names::new(&self.equations), found)
    }

    /// Equations with names on the left, then the abbreviations in them.
    fn equations(&mut self, names: Vec<FormulaTree>, exprs: &[Expr]) -> Vec<DocumentBlock> {
        let (formulas, new) = self.formulas(exprs);
        let mut blocks = graphs::list(names.into_iter().zip(formulas).collect());
        blocks.extend(with(new));
        blocks
    }

    fn written(&mut self, entries: Vec<Entry>) -> Vec<DocumentBlock> {
        let (names, exprs): (Vec<FormulaTree>, Vec<Expr>) = columns(entries);
        self.equations(names, &exprs)
    }
}

/// The discrete variables with which the motion begins; nothing if there are no modes.
fn modes_at_start(source: &Formulated) -> Result<Vec<f64>, AnalysisFailure> {
    let mechanism = &source.equations.system.mechanism;
    if mechanism.contacts.is_empty() {
        return Ok(Vec::new());
    }
    let state = state_at(source, source.lowered.program.experiment.start)?;
    Ok(state.discrete().to_vec())
}

/// The definitions of abbreviations, after the formulas in which they occur.
fn with(definitions: Vec<(FormulaTree, FormulaTree)>) -> Vec<DocumentBlock> {
    let mut blocks = graphs::list(definitions);
    if !blocks.is_empty() {
        blocks.insert(0, words("with"));
    }
    blocks
}

/// Names and expressions of entries.
fn columns(entries: impl IntoIterator<Item = Entry>) -> (Vec<FormulaTree>, Vec<Expr>) {
    entries.into_iter().map(|(name, expr)| (FormulaTree::Name(name), expr)).unzip()
}

fn heading(text: &str) -> DocumentBlock {
    DocumentBlock::Heading(text.into())
}

fn words(text: impl Into<String>) -> DocumentBlock {
    DocumentBlock::Text(vec![Piece::words(text)])
}

fn folded(summary: impl Into<String>, blocks: Vec<DocumentBlock>) -> DocumentBlock {
    DocumentBlock::Folded(summary.into(), blocks)
}

/// The end of a section: what was checked, and with what result.
fn check(what: &str, holds: bool) -> DocumentBlock {
    words(format!("Check: {what}: {}.", if holds { "it holds" } else { "IT DOES NOT HOLD" }))
}

/// A table with rows of some kinds: where they are many, the first two of each kind, and the others folded.
fn thinned(caption: &str, head: &[&str], rows: Vec<(String, Vec<Piece>)>) -> Vec<DocumentBlock> {
    const MOST: usize = 26;
    let head: Vec<String> = head.iter().map(|&word| word.to_owned()).collect();
    if rows.len() <= MOST {
        return vec![DocumentBlock::captioned(caption, head, rows.into_iter().map(|(_, row)| row).collect())];
    }
    let mut seen = std::collections::BTreeMap::<String, usize>::new();
    let (mut first, mut rest) = (Vec::new(), Vec::new());
    for (kind, row) in rows {
        let count = seen.entry(kind).or_default();
        *count += 1;
        if *count <= 2 { first.push(row) } else { rest.push(row) }
    }
    let text = format!("{} more rows of these kinds", rest.len());
    vec![DocumentBlock::captioned(caption, head.clone(), first), folded(text, vec![DocumentBlock::table(head, rest)])]
}
