//! An equilibrium with its reactions and loads.

use cotree::expr::{Expr, Symbol};
use cotree::formulate::Formulated;
use cotree::model::{Dimension, Mechanism, Quantity, Variable};
use cotree::report::data::{Report, Table, number, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::{GROUPS, at, contact_groups};
use crate::analysis::contacts::statuses;
use crate::analysis::{ContactStatus, Equilibrium, OperatingPoint, Stability};

/// What holds as much as it can but for this share is about to slide: an equilibrium is found to about as much.
const VERGE: f64 = 1e-9;

#[derive(Clone, Debug, PartialEq)]
pub struct Statics {
    pub name: String,
    /// When drivers and loads were read \[s\].
    pub time: f64,
    pub stability: Stability,
    /// Was it judged by the linearised motion, or by stiffness alone?
    pub by_motion: bool,
    /// Eigenvalues of the projected stiffness \[J\].
    pub stiffness: Vec<f64>,
    pub groups: Vec<Group>,
    /// What sticks or is caught, and so holds wherever it was put: the rest is one of many.
    pub standing: Vec<String>,
    /// What of it holds all that it can, alone: it is about to slide.
    pub verging: Vec<String>,
    /// What holds something together with others: how they share it is not determined, and one way is given.
    pub shared: Vec<String>,
    /// A body whose missing mass keeps the reactions unknown.
    pub weightless: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    pub title: &'static str,
    /// Names, values \[SI\] and units.
    pub values: Vec<(String, f64, String)>,
}

impl Statics {
    pub fn new(formulated: &mut Formulated, equilibrium: &Equilibrium) -> Self {
        let mechanism = &*formulated.equations.system.mechanism.clone();
        let mut reader = PointReader { formulated, point: &equilibrium.point };
        let mut groups = vec![reader.coordinates(), reader.states(), reader.read("pose", mechanism.pose())];
        let efforts = [("joints", joints(mechanism)), ("drivers", mechanism.driver_efforts())];
        let weightless = efforts.iter().find_map(|(_, variables)| reader.missing_mass(variables));
        if weightless.is_none() {
            groups.extend(efforts.map(|(title, variables)| reader.read(title, variables)));
        }
        groups.push(reader.loads());
        let statuses = statuses(formulated, &equilibrium.point);
        groups.extend(GROUPS.map(|title| Group { title, values: contact_groups(&statuses, title) }));
        groups.push(margins(&statuses, &equilibrium.shared));
        groups.retain(|group| !group.values.is_empty());
        Statics {
            name: mechanism.name.clone(),
            time: equilibrium.point.time(),
            stability: equilibrium.stability.clone(),
            by_motion: equilibrium.by_motion,
            stiffness: equilibrium.stiffness.clone(),
            groups,
            verging: verging(&statuses, &equilibrium.shared),
            shared: equilibrium.shared.clone(),
            standing: statuses.iter().filter(|status| status.stands()).map(|status| status.name.clone()).collect(),
            weightless,
        }
    }

    pub fn value(&self, name: &str) -> Option<f64> {
        let mut values = self.groups.iter().flat_map(|group| &group.values);
        values.find(|(known, ..)| known == name).map(|(_, value, _)| *value)
    }

    pub fn report(&self) -> Report {
        let (word, mut sentence, most) = self.stability.told();
        let holds = |title: &str| self.groups.iter().any(|group| group.title == title);
        if self.stability == Stability::Held && !self.standing.is_empty() {
            sentence =
                "joints, drivers, sticking friction, engaged freewheels and closed contacts leave 0 degrees of freedom";
        } else if self.stability == Stability::Held && holds(GROUPS[0]) {
            sentence = "joints, drivers and closed contacts leave 0 degrees of freedom";
        }
        let moving = most.map_or(String::new(), |most| format!("; `{most}` moves most in it"));
        let mut title = row![line![self.name, " at rest, ", at(self.time)], format!("{sentence}{moving}")];
        let listed = |names: &[String]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let within: Vec<String> = self.standing.iter().filter(|name| !self.verging.contains(name)).cloned().collect();
        if !within.is_empty() {
            let names = listed(&within);
            let line = format!(
                "one of many equilibria: {names} would stick elsewhere too; `[initial]` chooses the configuration"
            );
            title.push(line.into());
        }
        if !self.verging.is_empty() {
            title.push(format!("about to slide: {} is at its friction limit", listed(&self.verging)).into());
        }
        if !self.shared.is_empty() {
            let names = listed(&self.shared);
            title.push(format!("statically indeterminate: the loads of {names} are one of many solutions").into());
        }
        if !self.by_motion {
            title.push("(judged by stiffness alone: the motion cannot be linearized here)".into());
        }
        let unknown =
            |body| line!["\nThe reactions are not known: body `", body, "` has no mass, so its weight is not known."];
        let row = |(name, value, si): &(String, f64, String)| row![name, number(*value, si), unit(si)];
        let entry = |group: &Group, value| [row![group.title], row(value)].concat();
        let sheet = self.groups.iter().flat_map(|group| group.values.iter().map(move |value| entry(group, value)));
        let values =
            |group: &Group| group.values.iter().map(|(name, value, _)| (name.clone(), *value)).collect::<Value>();
        let groups = self.groups.iter().map(|group| (group.title, values(group)));
        Report {
            tables: self.groups.iter().map(|group| Table::list(group.title, group.values.iter().map(row))).collect(),
            notes: self.weightless.iter().map(unknown).collect(),
            sheet: Table::new(row!["group", "name", "value", "unit"], sheet),
            data: json!({
                "name": self.name,
                "time": self.time,
                "stability": word,
                "moves_most": most,
                "judged_by": if self.by_motion { "motion" } else { "stiffness" },
                "stiffness": self.stiffness,
                "standing": self.standing,
                "verging": self.verging,
                "shared": self.shared,
                "values": groups.collect::<Value>(),
            }),
            ..Report::new(title)
        }
    }
}

struct PointReader<'a> {
    formulated: &'a mut Formulated,
    point: &'a OperatingPoint,
}

impl PointReader<'_> {
    fn values(&self, exprs: &[Expr]) -> Vec<f64> {
        self.formulated.equations.system.arena.evaluate(exprs, self.point)
    }

    fn coordinates(&self) -> Group {
        let coordinates = self.formulated.equations.coordinates.iter().zip(self.point.positions());
        let values = coordinates.map(|(coordinate, &value)| {
            (coordinate.name.position.clone(), value, if coordinate.angular { "rad" } else { "m" }.to_owned())
        });
        Group { title: "coordinates", values: values.collect() }
    }

    fn states(&self) -> Group {
        let states = self.formulated.equations.system.mechanism.states.iter().zip(self.point.states());
        Group {
            title: "states",
            values: states.map(|(state, &value)| (state.name.clone(), value, state.unit.si.clone())).collect(),
        }
    }

    fn exprs(&mut self, variables: &[Variable]) -> Vec<Expr> {
        variables.iter().map(|&variable| self.formulated.equations.variable(variable)).collect()
    }

    fn read(&mut self, title: &'static str, mut variables: Vec<Variable>) -> Group {
        variables.retain(|variable| !self.formulated.lowered.shared.undetermined.contains(variable));
        let exprs = self.exprs(&variables);
        let values = variables.into_iter().zip(self.values(&exprs)).map(|(variable, value)| {
            let name = self.formulated.equations.system.mechanism.variable_name(variable);
            (name, value, variable.quantity.measure().si.to_owned())
        });
        Group { title, values: values.collect() }
    }

    /// A body without mass of which these values depend: its weight is not known.
    fn missing_mass(&mut self, variables: &[Variable]) -> Option<String> {
        let mechanism = &*self.formulated.equations.system.mechanism.clone();
        let gravity = mechanism.gravity.each_ref().map(|component| self.formulated.equations.formula(component));
        if self.values(&gravity) == [0.0; 2] {
            return None;
        }
        let exprs = self.exprs(variables);
        let symbols = self.formulated.equations.system.arena.symbols(exprs);
        symbols.into_iter().find_map(|symbol| match symbol {
            Symbol::Missing(body, cotree::expr::Property::Mass) => Some(mechanism.bodies[body].name.clone()),
            Symbol::Missing(..) => None,
            Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Argument => None,
        })
    }

    /// Loads by their variables; forces in the world's axes, whatever axes the scene gives them in.
    fn loads(&mut self) -> Group {
        let mechanism = &self.formulated.equations.system.mechanism;
        let plane = mechanism.dimension == Dimension::Two;
        let variables = mechanism.loads.iter().flat_map(|load| {
            let quantities = load.component().pose.iter().filter(|quantity| plane || **quantity != Quantity::Fy);
            quantities.map(|&quantity| Variable { owner: load.owner, quantity })
        });
        self.read("loads", variables.collect())
    }
}

/// What sticks alone with all that it can.
fn verging(statuses: &[ContactStatus], shared: &[String]) -> Vec<String> {
    let alone = statuses.iter().filter(|status| !shared.contains(&status.name));
    let verges =
        alone.filter(|alone| alone.most().is_some_and(|most| most > 0.0 && alone.force.abs() >= (1.0 - VERGE) * most));
    verges.map(|verge| verge.name.clone()).collect()
}

/// The loads that may be added along what sticks, one at a time, until it slides. Its own friction takes all of such a load, so that nothing else changes.
fn margins(statuses: &[ContactStatus], shared: &[String]) -> Group {
    let alone = statuses.iter().filter(|status| !shared.contains(&status.name));
    let values = alone.filter_map(|support| {
        let (most, [_, force]) = (support.most()?, support.units());
        let end = |word: &str, load: f64| (format!("{}.{word}", support.name), load, force.to_owned());
        Some([end("from", support.force - most), end("to", support.force + most)])
    });
    Group { title: "margins", values: values.flatten().collect() }
}

fn joints(mechanism: &Mechanism) -> Vec<Variable> {
    let mut variables = Vec::new();
    for joint in &mechanism.joints {
        let component = joint.component();
        let quantities = component.pose.iter().copied().chain(component.reactions(mechanism.dimension));
        variables.extend(quantities.map(|quantity| Variable { owner: joint.owner, quantity }));
    }
    variables
}

impl Stability {
    /// In a word, in a sentence, and what moves most in the mode that these are about.
    fn told(&self) -> (&'static str, &'static str, Option<&String>) {
        match self {
            Stability::Held => ("held", "joints and drivers leave 0 degrees of freedom", None),
            Stability::Stable => {
                ("stable", "stable: every displacement meets a restoring force, and no mode grows", None)
            }
            Stability::Neutral(most) => ("neutral", "neutral: a mode has no stiffness", Some(most)),
            Stability::Undecided(most) => {
                ("undecided", "undecided: to first order a mode neither grows nor decays", Some(most))
            }
            Stability::Unstable(most) => ("unstable", "unstable: a mode grows", Some(most)),
        }
    }
}
