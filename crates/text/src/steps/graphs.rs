//! Incidence, cutset and circuit matrices.

use cotree::equations::{Edge, EdgeRow};
use cotree::network::Origin;

use super::parts::kind;
use super::view::{GraphView, sign_of};
use super::{Lesson, check, folded, heading, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::FormulaTree;

/// Wider tables become lists.
const WIDEST: usize = 20;
/// Longer lists are folded behind so many of their rows.
const MOST: usize = 8;

/// The rows that are shown of a folded list have at most so many names.
const NAMES: usize = 80;

type Letter<'a> = &'a dyn Fn(&str) -> FormulaTree;

impl Lesson<'_> {
    pub fn incidence(&self) -> Vec<DocumentBlock> {
        let mut blocks = vec![
            heading("2. How are the parts joined?"),
            words(
                "Incidence (1: the edge arrives, -1: it leaves; the row of O, minus the sum of the others, is left out). Each row is \
                 the balance of forces, or of torques, of its node.",
            ),
        ];
        let letters = self.letters;
        blocks.extend(incidence("T", &self.translation, &|label| letters.force(label)));
        blocks.extend(incidence("R", &self.rotation, &|label| letters.torque(label)));
        let holds = is_incidence(&self.translation) && is_incidence(&self.rotation);
        blocks.push(check("every column has one 1 and one -1, or one of them and O", holds));
        blocks
    }

    pub fn topology(&mut self) -> Vec<DocumentBlock> {
        let letters = self.letters;
        let mut blocks = vec![heading("4. What do the trees give? Fundamental cutsets and circuits")];
        blocks.push(words(
            "Removing a branch parts the nodes in two; the edges between the parts are its cutset, a free body found without drawing it. With \
             the branches (b) first, the row-reduced incidence matrix is [1 | A] (8), and the branches' forces and torques are those of chords (c) (9):",
        ));
        blocks.push(DocumentBlock::Equations(vec![by_matrix("F", ["b", "c"], "A")]));
        blocks.extend(matrix("[A], T", &self.translation, &|label| letters.force(label)));
        blocks.extend(matrix("[A], R", &self.rotation, &|label| letters.torque(label)));
        blocks.extend(self.worked_cut());
        blocks.push(words(
            "Adding a chord to the tree closes one path, its circuit; the circuit matrix is [B | 1] (12), (13). The same lines hold for \
             velocities and accelerations:",
        ));
        let transposed =
            FormulaTree::power(FormulaTree::Name(Name::matrix("A", "")), FormulaTree::Name(Name::letter("T", "")));
        blocks.push(DocumentBlock::Equations(vec![
            by_matrix("r", ["c", "b"], "B"),
            (FormulaTree::Name(Name::matrix("B", "")), FormulaTree::Sum(vec![(true, transposed)])),
        ]));
        blocks.extend(circuits(&self.translation, &|label| letters.displacement(label), |edge| self.kind_of(edge)));
        blocks.extend(circuits(&self.rotation, &|label| letters.angle(label), |edge| self.kind_of(edge)));
        blocks.extend(self.picture_of_circuit());
        let holds = self.translation.is_orthogonal() && self.rotation.is_orthogonal();
        blocks.push(check("cutsets, found from the nodes, and circuits are orthogonal in both graphs", holds));
        blocks
    }

    fn kind_of<D>(&self, edge: &Edge<D>) -> String {
        kind(self.equations.system.element(edge.element)).to_owned()
    }

    /// One cutset as a sum of node balances: the longest that is not the whole mechanism.
    fn worked_cut(&mut self) -> Vec<DocumentBlock> {
        let Some((row, nodes)) = self.longest_cut() else { return Vec::new() };
        let system = &self.equations.system;
        let view = &self.translation;
        let centres: Vec<&str> = system
            .elements
            .iter()
            .filter_map(|element| match (&element.translation, element.origin) {
                (Some(row), Origin::Body(_)) if nodes.contains(&row.ends[1].index()) => Some(element.name.as_str()),
                _ => None,
            })
            .collect();
        let inside = view.inside(&nodes);
        let cancel = match inside.as_slice() {
            [] => String::new(),
            [one] => format!("; {one} has both ends inside and cancels"),
            list => format!("; {} have both ends inside and cancel", shortened(list)),
        };
        let names: Vec<&str> = nodes.iter().map(|&node| view.nodes[node].as_str()).collect();
        let whose =
            if centres.is_empty() { "these nodes".to_owned() } else { format!("{} together", shortened(&centres)) };
        let text = format!(
            "Row {} is the sum of the node rows {}{cancel}: the balance of forces of {whose}.",
            view.record.edge_of(row).label,
            shortened(&names)
        );
        let mut blocks =
            vec![words(text), DocumentBlock::Equations(view.balances([row], |label| self.letters.force(label)))];
        blocks.extend(self.picture_of_cut(&nodes));
        blocks
    }

    fn longest_cut(&self) -> Option<(&EdgeRow, std::collections::BTreeSet<usize>)> {
        let view = &self.translation;
        let origin = |row: &EdgeRow| self.equations.system.element(view.record.edge_of(row).element).origin;
        let cuts =
            view.record.cutsets.iter().filter(|row| !matches!(origin(row), Origin::Arm(..) | Origin::GroundVector(_)));
        let cuts = cuts.map(|row| (row, view.record.beyond(view.record.edge_of(row).element)));
        let whole = view.nodes.len().saturating_sub(2); // all nodes but O, or all but O and one on the ground
        cuts.max_by_key(|(row, nodes)| (nodes.len() < whole, row.len(), nodes.len()))
    }
}

/// {F}_b = -[A]{F}_c
fn by_matrix(letter: &str, [left, right]: [&str; 2], matrix: &str) -> (FormulaTree, FormulaTree) {
    let column = |below| FormulaTree::Name(Name::column(letter, below));
    let product = FormulaTree::product(vec![FormulaTree::Name(Name::matrix(matrix, "")), column(right)]);
    (column(left), FormulaTree::Sum(vec![(true, product)]))
}

/// A list of words, its middle left out if it is long.
pub fn shortened(list: &[&str]) -> String {
    match list {
        [first @ .., last] if list.len() > 12 => {
            format!("{} ... {last} ({} in all)", first[..8].join(", "), list.len())
        }
        list => list.join(", "),
    }
}

fn is_incidence<D>(view: &GraphView<D>) -> bool {
    let is_node = |node: usize| node < view.nodes.len();
    view.record.edges.iter().all(|edge| {
        let [a, b] = edge.ends.map(|end| end.index());
        a != b && is_node(a) && is_node(b)
    })
}

fn incidence<D>(title: &str, view: &GraphView<D>, letter: Letter) -> Vec<DocumentBlock> {
    if view.nodes.len() < 2 {
        return Vec::new();
    }
    let edges = &view.record.edges;
    let rows = (1..view.nodes.len()).map(|node| {
        let at = |edge: &Edge<D>| edge.ends.map(|end| i8::from(end.index() == node));
        edges.iter().map(at).map(|[from, to]| to - from).collect::<Vec<i8>>()
    });
    if edges.len() <= WIDEST {
        return table(
            &format!("Incidence of nodes and edges in {title}"),
            title,
            edges.iter().map(|edge| edge.label.clone()).collect(),
            view.nodes[1..].iter().cloned().zip(rows).collect(),
        );
    }
    let rows: Vec<EdgeRow> =
        rows.map(|signs| signs.into_iter().enumerate().filter(|(_, sign)| *sign != 0).collect()).collect();
    let text = format!("{title} is {} x {}; as a list, node by node:", rows.len(), edges.len());
    std::iter::once(words(text)).chain(list(view.balances(&rows, letter))).collect()
}

/// Equations; where they are many, the first of them, and the others folded.
pub fn list(mut rows: Vec<(FormulaTree, FormulaTree)>) -> Vec<DocumentBlock> {
    if rows.is_empty() || rows.len() <= 3 * MOST {
        return if rows.is_empty() { Vec::new() } else { vec![DocumentBlock::Equations(rows)] };
    }
    let mut names = 0;
    let short = rows.iter().take_while(|(left, right)| {
        names += left.count_names() + right.count_names();
        names <= NAMES
    });
    let shown = short.count().clamp(1, MOST);
    let rest = rows.split_off(shown);
    let text = format!("{} more of the same kind", rest.len());
    vec![DocumentBlock::Equations(rows), folded(text, vec![DocumentBlock::Equations(rest)])]
}

fn matrix<D>(title: &str, view: &GraphView<D>, letter: Letter) -> Vec<DocumentBlock> {
    let (branches, chords) = (view.record.cutsets.len(), view.record.circuits.len());
    if chords > WIDEST || branches > 2 * WIDEST {
        let text = format!("{title} is {branches} x {chords}; as a list of balances:");
        return std::iter::once(words(text)).chain(list(view.balances(&view.record.cutsets, letter))).collect();
    }
    let signs = |row: &EdgeRow| view.record.circuits.iter().map(|chord| sign_of(row, chord[0].0)).collect();
    let rows = view.record.cutsets.iter().map(|row| (view.record.edge_of(row).label.clone(), signs(row)));
    let columns = view.record.circuits.iter().map(|row| view.record.edge_of(row).label.clone());
    table(&format!("The matrix {title}: branches by chords"), title, columns.collect(), rows.collect())
}

/// The paths that chords equal: the longest of each kind where they are many.
fn circuits<D>(view: &GraphView<D>, letter: Letter, kind: impl Fn(&Edge<D>) -> String) -> Vec<DocumentBlock> {
    let mut chords: Vec<&EdgeRow> = view.record.circuits.iter().collect();
    let row = |chord: &&EdgeRow| view.by_others(chord, letter);
    if chords.len() <= 3 * MOST {
        return list(chords.iter().map(row).collect());
    }
    chords.sort_by_key(|chord| std::cmp::Reverse(chord.len()));
    let mut kinds = std::collections::BTreeSet::new();
    let (first, rest): (Vec<_>, Vec<_>) =
        chords.into_iter().partition(|chord| kinds.insert(kind(view.record.edge_of(chord))));
    let text = format!("{} more of these kinds", rest.len());
    let rest = vec![DocumentBlock::Equations(rest.iter().map(row).collect())];
    vec![DocumentBlock::Equations(first.iter().map(row).collect()), folded(text, rest)]
}

/// A matrix of signs with names beside the rows and above the columns.
pub fn table(caption: &str, title: &str, columns: Vec<String>, rows: Vec<(String, Vec<i8>)>) -> Vec<DocumentBlock> {
    if rows.is_empty() || columns.is_empty() {
        return Vec::new();
    }
    let cell = |sign: i8| match sign {
        0 => Piece::words("."),
        sign if sign < 0 => Piece::Math(FormulaTree::Sum(vec![(true, FormulaTree::Number(f64::from(-sign)))])),
        sign => Piece::Math(FormulaTree::Number(f64::from(sign))),
    };
    let rows = rows
        .into_iter()
        .map(|(name, signs)| std::iter::once(Piece::words(name)).chain(signs.into_iter().map(cell)).collect());
    let head = std::iter::once(title.to_owned()).chain(columns).collect();
    vec![DocumentBlock::captioned(caption, head, rows.collect())]
}
