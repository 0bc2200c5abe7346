//! Short names of nodes and coordinates, made of the labels of edges.

use std::collections::BTreeMap;

use cotree::equations::Equations;
use cotree::model::{BodyId, Place};
use cotree::network::{CoordinateName, ElementId, Origin, System};

use super::Lesson;

/// Letters of points that are neither a mass centre nor on the ground.
const POINTS: &str = "ABPDEHJKLMNQSUVWXYZ";

/// The digits of a label, or all of it if others have the same digits.
pub fn number(system: &System, id: ElementId) -> String {
    let digits = |label: &str| label.trim_start_matches(|c: char| !c.is_ascii_digit()).to_owned();
    let shown = digits(&system.element(id).label);
    let same = system.elements.iter().filter(|other| digits(&other.label) == shown).count();
    if same > 1 { system.element(id).label.clone() } else { shown }
}

/// Names of the translational nodes: O, G, C1, A, B.
pub fn nodes(system: &System) -> Vec<String> {
    let mut names = vec!["O".to_owned(); system.translation.nodes()];
    let mut points = 0;
    let ground = system.mechanism.ground.iter().enumerate();
    let ground: Vec<Place> = ground.map(|(index, _)| Place::Ground(index)).filter(|&p| system.has_node(p)).collect();
    for (index, &place) in ground.iter().enumerate() {
        let name = if ground.len() > 1 { format!("G{}", index + 1) } else { "G".to_owned() };
        names[system.t_node(place).index()] = name;
    }
    for (index, body) in system.mechanism.bodies.iter().enumerate() {
        let id = BodyId(index);
        let shown = system.find(Origin::Body(id)).map(|element| number(system, element)).unwrap_or_default();
        names[system.t_node(Place::Centre(id)).index()] = format!("C{shown}");
        for point in (0..body.points.len()).map(|point| Place::Point(id, point)).filter(|&p| system.has_node(p)) {
            let (round, letter) = (points / POINTS.len(), points % POINTS.len());
            let suffix = if round > 0 { (round + 1).to_string() } else { String::new() };
            names[system.t_node(point).index()] = format!("{}{suffix}", &POINTS[letter..=letter]);
            points += 1;
        }
    }
    names
}

/// Names of the rotational nodes: the bodies.
pub fn bodies(system: &System) -> Vec<String> {
    let names = system.rotation.node_names().enumerate();
    names.map(|(index, name)| if index == 0 { "O".to_owned() } else { name.to_owned() }).collect()
}

/// Gives the coordinates letters with the numbers of their edges: `theta_1`, `omega_1`, `s_12`.
pub fn name_coordinates(equations: &mut Equations) {
    let mut used: BTreeMap<String, usize> = BTreeMap::new();
    let letter_of = |equations: &Equations, index: usize| {
        let coordinate = &equations.coordinates[index];
        let number = number(&equations.system, coordinate.element);
        let word = coordinate.name.position.rsplit('.').next().unwrap_or_default().to_owned();
        let letter = match word.as_str() {
            "angle" => "theta",
            "s" => "s",
            "y" => "y",
            _ => "x",
        };
        (letter, format!("{letter}_{number}"))
    };
    let names: Vec<(&str, String)> =
        (0..equations.coordinates.len()).map(|index| letter_of(equations, index)).collect();
    for (_, name) in &names {
        *used.entry(name.clone()).or_default() += 1;
    }
    for (index, (letter, name)) in names.into_iter().enumerate() {
        if used[&name] > 1 || taken(equations, &name) {
            continue; // the user's own name says it
        }
        let below = name[letter.len()..].to_owned();
        let (rate, acceleration) = match letter {
            "theta" => (format!("omega{below}"), format!("alpha{below}")),
            _ => (format!("{name}'"), format!("{name}''")),
        };
        equations.coordinates[index].name = CoordinateName { position: name, rate, acceleration };
    }
}

fn taken(equations: &Equations, name: &str) -> bool {
    let mechanism = &equations.system.mechanism;
    let below = name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let names = [name.to_owned(), format!("omega{below}"), format!("alpha{below}")];
    let is_own = |letter: &str| names.iter().any(|name| name == letter);
    mechanism.parameters.iter().any(|parameter| is_own(&parameter.name))
        || mechanism.inputs.iter().any(|input| is_own(&input.name))
        || mechanism.drivers.iter().any(|driver| is_own(&driver.name))
}

impl Lesson<'_> {
    /// "O datum; G guide; C1 C2 mass centres of ...; A B on crank; ...": where nodes are many, the first of them.
    pub fn node_legend(&self) -> String {
        const MOST: usize = 6;
        let system = &self.equations.system;
        let name = |place: Place| self.translation.nodes[system.t_node(place).index()].clone();
        let mut parts = vec!["O datum".to_owned()];
        for (index, point) in system.mechanism.ground.iter().enumerate() {
            if system.has_node(Place::Ground(index)) {
                parts.push(format!("{} {}", name(Place::Ground(index)), point.name));
            }
        }
        let bodies = system.mechanism.bodies.iter().enumerate();
        for (index, body) in bodies.clone().take(MOST) {
            let id = BodyId(index);
            let points = (0..body.points.len()).map(|point| Place::Point(id, point));
            let points: Vec<String> = points.filter(|&place| system.has_node(place)).map(name).collect();
            let more = if points.is_empty() { String::new() } else { format!(", {} on it", points.join(" ")) };
            parts.push(format!("{} mass centre of {}{more}", name(Place::Centre(id)), body.name));
        }
        let rest = bodies.count().saturating_sub(MOST);
        let rest = if rest > 0 { format!("; and so on for {rest} more bodies") } else { String::new() };
        format!("Nodes: {}{rest}.", parts.join("; "))
    }
}
