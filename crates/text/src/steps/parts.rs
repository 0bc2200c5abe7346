//! The parts of the mechanism: degrees of freedom, nodes, and edges with their data.

use std::collections::BTreeMap;

use cotree::expr::{Expr, Symbol};
use cotree::model::BodyId;
use cotree::network::{Direction, Element, ElementId, Known, Origin};
use cotree::typeset::counted;

use super::projection::is_free;
use super::{Lesson, heading, thinned, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::symbol_name;
use crate::symbols::number;
use crate::tree::{FormulaTree, plain};

impl Lesson<'_> {
    pub fn parts(&mut self) -> Vec<DocumentBlock> {
        let mut blocks = vec![heading("1. What is the mechanism?"), self.mechanism()];
        blocks.push(words(self.freedoms()));
        blocks.push(words(self.node_legend()));
        blocks.push(words(
            "An edge's across variable is its second node's minus its first's (displacement, velocity, acceleration; angle and its \
             rates); its through variable is the load of the first side on the second (force; torque).",
        ));
        let ids: Vec<ElementId> = (0..self.equations.system.elements.len()).map(ElementId).collect();
        let ids: Vec<ElementId> = ids.into_iter().filter(|&id| self.equations.system.has_edges(id)).collect();
        let rows = ids.into_iter().map(|id| (kind(self.equations.system.element(id)).to_owned(), self.part(id)));
        let rows: Vec<_> = rows.collect();
        let head = ["edge", "name", "kind", "T graph", "R graph", "data", "value"];
        blocks.extend(thinned("Edges of both graphs", &head, rows));
        blocks.push(words(self.sizes()));
        blocks
    }

    /// An edge of the table.
    fn part(&mut self, id: ElementId) -> Vec<Piece> {
        let element = self.equations.system.element(id).clone();
        let (data, parameters) = self.data(&element);
        vec![
            Piece::words(&element.label),
            Piece::Code(self.equations.system.name(id).to_owned()),
            Piece::words(kind(&element)),
            self.translation.ends(id),
            self.rotation.ends(id),
            data,
            self.values(&parameters),
        ]
    }

    /// What the scene says of an element in symbols, and the parameters in it.
    fn data(&mut self, element: &Element) -> (Piece, Vec<usize>) {
        let at = element.translation.as_ref().and_then(|row| match row.known {
            Known::Fixed(body, at) => Some((body, at)),
            _ => None,
        });
        if let (Some((body, at)), true) = (at, matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_))) {
            let vector = Piece::Math(self.letters.components(plain(&self.equations, &at)));
            return (Piece::Row(vec![vector, self.carrier(body)]), self.parameters_in(&at));
        }
        let parameters = self.parameters_of(element.origin);
        let mut pieces = self.axis(element);
        for &index in &parameters {
            if !pieces.is_empty() {
                pieces.push(Piece::words(", "));
            }
            pieces.push(Piece::Math(self.parameter(index)));
        }
        (Piece::Row(pieces), parameters)
    }

    /// u = (1, 0), with the body that carries it.
    fn axis(&mut self, element: &Element) -> Vec<Piece> {
        let joint = matches!(element.origin, Origin::Joint(_)) && self.letters.has_two_components();
        let row = element.translation.as_ref().filter(|_| joint);
        let Some(&(Direction::Fixed(body, unit), _)) = row.and_then(|row| row.motion.first()) else {
            return Vec::new();
        };
        let vector = self.letters.components(plain(&self.equations, &unit));
        let axis = self.letters.direction(Direction::Fixed(body, unit), element, true);
        vec![Piece::Math(FormulaTree::Relation("=", Box::new([axis, vector]))), self.carrier(body)]
    }

    /// " in rod"
    fn carrier(&self, body: Option<BodyId>) -> Piece {
        let bodies = &self.equations.system.mechanism.bodies;
        Piece::words(body.map_or_else(String::new, |body| format!(" in {}", bodies[body.0].name)))
    }

    pub fn parameter(&self, index: usize) -> FormulaTree {
        FormulaTree::Name(symbol_name(&self.equations, Symbol::Parameter(index)))
    }

    fn parameters_in(&self, exprs: &[Expr]) -> Vec<usize> {
        let symbols = self.equations.system.arena.symbols(exprs.iter().copied());
        let mut found: Vec<usize> = symbols
            .into_iter()
            .filter_map(|symbol| if let Symbol::Parameter(index) = symbol { Some(index) } else { None })
            .collect();
        found.sort_unstable();
        found
    }

    fn parameters_of(&self, origin: Origin) -> Vec<usize> {
        let mechanism = &self.equations.system.mechanism;
        let mut found = Vec::new();
        let mut visit = |id: cotree::model::ParameterId| found.push(id.0);
        match origin {
            Origin::Body(id) => {
                let body = &mechanism.bodies[id.0];
                body.mass.iter().chain(&body.inertia).for_each(|formula| formula.visit_parameters(&mut visit));
            }
            Origin::Joint(id) => {
                mechanism.joints[id.0].visit_parameters(&mut visit);
                let elsewhere =
                    mechanism.contacts.iter().filter(|contact| contact.owner == mechanism.joints[id.0].owner);
                let mut theirs = Vec::new();
                elsewhere.for_each(|formula| formula.visit_parameters(&mut |id| theirs.push(id.0)));
                found.retain(|parameter| !theirs.contains(parameter));
            }
            Origin::Driver(id) => mechanism.drivers[id.0].visit_parameters(&mut visit),
            Origin::Load(id) => mechanism.loads[id.0].visit_parameters(&mut visit),
            Origin::Contact(index) => mechanism.contacts[index].visit_parameters(&mut visit),
            Origin::Arm(..) | Origin::GroundVector(_) | Origin::Implied(_) | Origin::SetRate(_) => {}
        }
        found.dedup();
        found
    }

    /// "0.25 m", or what a named number is in the scene's own parameters.
    fn values(&self, parameters: &[usize]) -> Piece {
        let all = &self.equations.system.mechanism.parameters;
        Piece::list(", ", parameters.iter().map(|&index| number(all[index].value, &all[index].unit)))
    }

    /// The freedoms of the bodies, and what joints and drivers take.
    fn freedoms(&self) -> String {
        let system = &self.equations.system;
        let (bodies, each) = (system.mechanism.bodies.len(), if self.letters.has_two_components() { 3 } else { 1 });
        let mut takers: BTreeMap<(&str, usize), usize> = BTreeMap::new();
        for (index, element) in system.elements.iter().enumerate() {
            let takes_some = matches!(element.origin, Origin::Joint(_) | Origin::Driver(_));
            if takes_some && system.has_edges(ElementId(index)) {
                *takers.entry((kind(element), takes(element))).or_default() += 1;
            }
        }
        let taken: usize = takers.iter().map(|((_, takes), count)| takes * count).sum();
        let list: Vec<String> = takers
            .iter()
            .map(|((kind, takes), count)| match count {
                1 => format!("1 {kind} takes {takes}"),
                count => format!("{count} {} take {takes} each", plural(kind)),
            })
            .collect();
        let (all, mobility) = (bodies * each, self.source.mobility());
        let bodies = format!("{} {}", counted(bodies, "moving body"), if bodies == 1 { "has" } else { "have" });
        let rest = match (all.checked_sub(taken), mobility) {
            (Some(0), 0) => "; nothing is left: the drivers prescribe the motion.".to_owned(),
            (Some(1), 1) => "; 1 degree of freedom remains.".to_owned(),
            (Some(left), mobility) if left == mobility => format!("; {mobility} degrees of freedom remain."),
            (_, mobility) => format!(
                ", of which {} repeat others; {mobility} degrees of freedom remain.",
                (taken + mobility).saturating_sub(all)
            ),
        };
        let list =
            if list.is_empty() { "nothing takes any".to_owned() } else { format!("{}: {taken}", list.join(", ")) };
        format!("{bodies} {each}*{} = {all} degrees of freedom; {list}{rest}", all / each)
    }

    fn sizes(&self) -> String {
        let edges = self.translation.record.edges.len();
        let first = format!("T has {edges} edges and {} nodes besides O", self.translation.nodes.len() - 1);
        if self.rotation.nodes.len() < 2 {
            return format!("{first}. Nothing turns: there is no rotational graph, and there are no arms that turn.");
        }
        let without: Vec<&str> = ["rigid arm", "ground vector", "load"]
            .into_iter()
            .filter(|name| {
                let of_kind = self.equations.system.elements.iter().filter(|element| kind(element) == *name);
                of_kind.clone().next().is_some() && of_kind.clone().all(|element| element.rotation.is_none())
            })
            .collect();
        let without = match without.as_slice() {
            [] => String::new(),
            list => format!(" Of what lies between points of bodies ({}s) R has no edge.", list.join("s, ")),
        };
        format!(
            "{first}; R has {} edges and {}. The points of one body are one node of R: they turn alike.{without}",
            self.rotation.record.edges.len(),
            self.rotation.nodes.len() - 1
        )
    }
}

/// How many freedoms a joint or driver takes: the size of its reaction spaces.
fn takes(element: &Element) -> usize {
    let forces = element.translation.as_ref().map_or(0, |row| row.reaction.len());
    let turns = element.rotation.is_some() && !is_free(element);
    forces + usize::from(turns) + usize::from(element.coupling.is_some())
}

fn plural(kind: &str) -> String {
    match kind {
        "pin in slot" => "pins in slots".to_owned(),
        kind => format!("{kind}s"),
    }
}

pub fn kind(element: &Element) -> &'static str {
    match element.origin {
        Origin::Body(_) => "rigid body",
        Origin::Arm(..) => "rigid arm",
        Origin::GroundVector(_) => "ground vector",
        Origin::Driver(_) => "driver",
        Origin::Load(_) => "load",
        Origin::Implied(_) => "implied relation",
        Origin::SetRate(_) => "rate that an event sets",
        Origin::Contact(_) if element.slip.is_some() => "dry friction",
        Origin::Contact(_) => "contact",
        Origin::Joint(_) if element.translation.is_none() && element.rotation.is_none() => "coupling",
        Origin::Joint(_) if element.coupling.is_some() => "rolling disc",
        Origin::Joint(_) => match &element.translation {
            Some(row) if !row.motion.is_empty() && is_free(element) => "pin in slot",
            Some(row) if !row.motion.is_empty() => "prismatic joint",
            _ if is_free(element) => "revolute joint",
            _ => "weld",
        },
    }
}
