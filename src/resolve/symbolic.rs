//! A mechanism in which every number has a name: lengths of arms, masses, stiffnesses, what the laws and motions contain.

use std::collections::HashSet;

use crate::expr::{Binary, Function, Unary};
use crate::model::measure::{ACCELERATION, INERTIA, LENGTH, MASS, NUMBER, Wanted};
use crate::model::{Formula, KeyValue, Mechanism, Motion, Parameter, ParameterId, Part, Place, Unit};
use crate::network::{Origin, System};
use crate::scene::constant::{evaluate, negate};
use crate::scene::key::Form;

/// What names are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// The number of the element's edge: `m_2`, `l_7`.
    Edges,
    /// The user's names of bodies, joints and loads; arms keep their numbers: `m_rod`, `l7`.
    Owners,
}

/// A number that got a name.
#[derive(Clone, Debug)]
pub struct NamedNumber {
    /// What it is, if that is more than a number.
    pub definition: Option<Formula>,
    /// The element that it belongs to; none for gravity.
    pub element: Option<String>,
    /// What it is of that element, such as "mass".
    pub what: &'static str,
}

/// A mechanism with parameters in the place of numbers, behind its own.
#[derive(Clone, Debug)]
pub struct Symbolic {
    /// The same mechanism.
    pub mechanism: Mechanism,
    /// The names, in the order of their parameters.
    pub named: Vec<NamedNumber>,
}

impl Symbolic {
    /// Names the numbers of a mechanism.
    pub fn new(system: &System, style: Style) -> Symbolic {
        let mechanism = &system.mechanism;
        let names = mechanism.parameters.iter().map(|parameter| parameter.name.clone());
        let names = names.chain(mechanism.inputs.iter().map(|input| input.name.clone()));
        let taken = names.chain(mechanism.drivers.iter().map(|driver| driver.name.clone())).collect();
        let mut namer = Namer { system, style, mechanism: (**mechanism).clone(), taken, named: Vec::new() };
        namer.gravity();
        namer.bodies();
        namer.ground();
        namer.parts();
        Symbolic { mechanism: namer.mechanism, named: namer.named }
    }
}

/// Laws with more numbers, such as tables, keep them.
const MOST: usize = 12;

struct Namer<'a> {
    system: &'a System,
    style: Style,
    mechanism: Mechanism,
    taken: HashSet<String>,
    named: Vec<NamedNumber>,
}

/// A number that is to be named: whose it is, what it is, its letter and its measure.
#[derive(Clone, Copy)]
struct About<'a> {
    owner: Option<&'a str>,
    /// What stands behind the letter.
    suffix: &'a str,
    letter: &'a str,
    what: &'static str,
    measure: Wanted,
    /// Is a negative number minus a positive one with a name? So are places.
    signed: bool,
}

impl Namer<'_> {
    fn gravity(&mut self) {
        let gravity = self.mechanism.gravity.clone();
        let both = gravity.iter().all(|component| *component != Formula::Number(0.0));
        let letters = if both { ["g_x", "g_y"] } else { ["g", "g"] };
        let mut component = |index: usize| {
            let letter = letters[index];
            let about = About { owner: None, suffix: "", letter, what: "gravity", measure: ACCELERATION, signed: true };
            self.number(&gravity[index], about)
        };
        self.mechanism.gravity = [component(0), component(1)];
    }

    fn bodies(&mut self) {
        for index in 0..self.mechanism.bodies.len() {
            let id = crate::model::BodyId(index);
            let body = self.mechanism.bodies[index].clone();
            let suffix = self.suffix(Origin::Body(id), &body.name);
            let about = |letter, what, measure| About {
                owner: Some(&body.name),
                suffix: &suffix,
                letter,
                what,
                measure,
                signed: false,
            };
            let mass = body.mass.as_ref().map(|mass| self.number(mass, about("m", "mass", MASS)));
            let inertia =
                body.inertia.as_ref().map(|inertia| self.number(inertia, about("I", "moment of inertia", INERTIA)));
            for (point, data) in body.points.iter().enumerate() {
                let name = self.mechanism.place_name(Place::Point(id, point));
                self.mechanism.bodies[index].points[point].at =
                    self.place(Origin::Arm(id, point), &name, &data.at, ["l", "l"]);
            }
            let body = &mut self.mechanism.bodies[index];
            (body.mass, body.inertia) = (mass, inertia);
        }
    }

    fn ground(&mut self) {
        for index in 0..self.mechanism.ground.len() {
            let point = self.mechanism.ground[index].clone();
            let name = format!("ground.{}", point.name);
            self.mechanism.ground[index].at = self.place(Origin::GroundVector(index), &name, &point.at, ["x", "y"]);
        }
    }

    /// The components of an arm; a point that no element uses has no edge and keeps its numbers.
    fn place(&mut self, origin: Origin, name: &str, at: &[Formula; 2], single: [&str; 2]) -> [Formula; 2] {
        let Some(id) = self.system.find(origin) else { return at.clone() };
        let number = number_of(&self.system.element(id).label).to_owned();
        let suffix = if self.style == Style::Edges { format!("_{number}") } else { number };
        let both = at.iter().all(|component| *component != Formula::Number(0.0));
        let letters = if both { ["x", "y"] } else { single };
        let mut component = |index: usize| {
            let letter = letters[index];
            let about = About {
                owner: Some(name),
                suffix: &suffix,
                letter,
                what: ["along x", "along y"][index],
                measure: LENGTH,
                signed: true,
            };
            self.number(&at[index], about)
        };
        [component(0), component(1)]
    }

    fn parts(&mut self) {
        let lists = [&self.mechanism.joints, &self.mechanism.drivers, &self.mechanism.loads].map(Clone::clone);
        let [joints, drivers, loads] =
            lists.map(|list| list.into_iter().map(|part| self.part(part)).collect::<Vec<Part>>());
        (self.mechanism.joints, self.mechanism.drivers, self.mechanism.loads) = (joints, drivers, loads);
        self.mechanism.rename_contacts();
    }

    fn part(&mut self, mut part: Part) -> Part {
        let Some(origin) = Origin::of(part.owner) else { return part };
        let suffix = self.suffix(origin, &part.name);
        let name = part.name.clone();
        let keys = part.component().keys;
        for (key, value) in &mut part.values {
            let measure = keys
                .iter()
                .find(|candidate| candidate.name == *key)
                .map_or(NUMBER, |candidate| measure(candidate.form));
            let letter = letter(key);
            let about = About { owner: Some(&name), suffix: &suffix, letter, what: key, measure, signed: false };
            self.value(value, about);
        }
        part
    }

    fn value(&mut self, value: &mut KeyValue, about: About) {
        match value {
            KeyValue::Formula(formula) => *formula = self.formula(formula, about),
            KeyValue::Motion(Motion::Given(formula)) => *formula = self.formula(formula, about),
            KeyValue::Vector(both) if both.iter().all(is_unit) && about.what == "axis" => {}
            KeyValue::Vector(both) => {
                let single = both.contains(&Formula::Number(0.0));
                let letters = ["x", "y"].map(|axis| match single {
                    true => about.letter.to_owned(),
                    false => format!("{}_{axis}", about.letter),
                });
                let [x, y] = [0, 1].map(|i| self.formula(&both[i], About { letter: &letters[i], ..about }));
                *both = [x, y];
            }
            KeyValue::Friction(friction) => {
                friction.coulomb = self.formula(&friction.coulomb, About { letter: "C", ..about });
                let named = [(&mut friction.velocity, "w"), (&mut friction.radius, "r"), (&mut friction.length, "l")];
                for (value, letter) in named {
                    *value = value.as_ref().map(|formula| self.formula(formula, About { letter, ..about }));
                }
                for (value, letter) in friction.belt.iter_mut().flatten().zip(["phi", "P"]) {
                    *value = self.formula(value, About { letter, ..about });
                }
                friction.mu = self.formula(&friction.mu, About { letter: "mu", ..about });
                if friction.ratio != Formula::Number(1.0) {
                    friction.ratio = self.formula(&friction.ratio, About { letter: "static", ..about });
                }
            }
            KeyValue::Limits(limits) => {
                let letters = ["min", "max"];
                for (end, letter) in limits.ends.iter_mut().zip(letters) {
                    *end = end.as_ref().map(|end| self.formula(end, About { letter, signed: true, ..about }));
                }
                limits.restitution = self.formula(&limits.restitution, About { letter: "e", ..about });
            }
            KeyValue::Course(course) => {
                for pulley in course.pulleys_mut() {
                    pulley.radius = self.formula(&pulley.radius, About { letter: "r", measure: LENGTH, ..about });
                    let mu = pulley.mu.as_ref();
                    pulley.mu = mu.map(|mu| self.formula(mu, About { letter: "mu", measure: NUMBER, ..about }));
                }
            }
            KeyValue::Motion(_)
            | KeyValue::Place(_)
            | KeyValue::Joint(_)
            | KeyValue::Choice(_)
            | KeyValue::Contour(_)
            | KeyValue::Switch(_) => {}
        }
    }

    /// A number, or a law with the numbers in it: then each has a letter of its own.
    fn formula(&mut self, formula: &Formula, about: About) -> Formula {
        if self.constant(formula).is_some() {
            self.number(formula, about)
        } else if numbers(formula) > MOST {
            formula.clone() // a table
        } else {
            self.within(formula, About { measure: NUMBER, ..about })
        }
    }

    fn within(&mut self, formula: &Formula, about: About) -> Formula {
        if self.constant(formula).is_some() {
            let letter = "abdefhjknopqruvw".chars().find(|letter| self.is_free(&self.name(*letter, about)));
            let letter = letter.map_or_else(|| "a".to_owned(), String::from);
            return self.number(formula, About { letter: &letter, signed: true, ..about });
        }
        let mut named = formula.clone();
        let exponent = usize::from(matches!(formula, Formula::Call(Function::Two(Binary::Power), _)));
        let parts = named.parts_mut();
        let count = parts.len() - exponent;
        parts[..count].iter_mut().for_each(|part| *part = self.within(part, about));
        named
    }

    /// A formula with a name; parameters, zero and what is one keep their own.
    fn number(&mut self, formula: &Formula, about: About) -> Formula {
        let Some(value) = self.constant(formula) else { return formula.clone() };
        let is_named = match formula {
            Formula::Number(number) => *number == 0.0,
            Formula::Parameter(_) => true,
            Formula::Call(Function::One(Unary::Negate), inner) => matches!(inner[..], [Formula::Parameter(_)]),
            _ => !value.is_finite(),
        };
        if is_named {
            return formula.clone();
        }
        let minus = about.signed && value < 0.0;
        let positive = if minus { negate(formula.clone()) } else { formula.clone() };
        let symbol = Formula::Parameter(self.push(positive, if minus { -value } else { value }, about));
        if minus { negate(symbol) } else { symbol }
    }

    fn push(&mut self, formula: Formula, value: f64, about: About) -> ParameterId {
        // A mass of the body `m1`, a stiffness of the spring `k13`: they are called so already.
        let owner = about.owner.filter(|owner| self.style == Style::Owners && is_numbered(owner, about.letter));
        let mut name = owner.map_or_else(|| format!("{}{}", about.letter, about.suffix), str::to_owned);
        while !self.is_free(&name) {
            name.push('_');
        }
        self.taken.insert(name.clone());
        let parameter = ParameterId(self.mechanism.parameters.len());
        self.mechanism.parameters.push(Parameter {
            name,
            unit: Unit::of(&about.measure, None),
            value,
            ..Parameter::default()
        });
        let definition = (!matches!(formula, Formula::Number(_))).then_some(formula);
        let element = about.owner.map(str::to_owned);
        self.named.push(NamedNumber { definition, element, what: about.what });
        parameter
    }

    fn name(&self, letter: char, about: About) -> String {
        format!("{letter}{}", about.suffix)
    }

    fn is_free(&self, name: &str) -> bool {
        !self.taken.contains(name)
    }

    /// The value of a formula of numbers and parameters.
    fn constant(&self, formula: &Formula) -> Option<f64> {
        (!moves(formula)).then(|| evaluate(formula, &self.mechanism.parameter_values()))
    }

    fn suffix(&self, origin: Origin, name: &str) -> String {
        let label = self.system.find(origin).map(|id| self.system.element(id).label.as_str());
        match (self.style, label) {
            (Style::Edges, Some(label)) => format!("_{}", number_of(label)),
            _ => format!("_{name}"),
        }
    }
}

/// Does it depend on time, an input or a variable?
fn moves(formula: &Formula) -> bool {
    matches!(formula, Formula::Time | Formula::Input(_) | Formula::Discrete(_) | Formula::Variable(_))
        || formula.parts().iter().any(moves)
}

/// How many numbers a formula has.
fn numbers(formula: &Formula) -> usize {
    usize::from(matches!(formula, Formula::Number(_))) + formula.parts().iter().map(numbers).sum::<usize>()
}

fn is_unit(component: &Formula) -> bool {
    matches!(component, Formula::Number(number) if [0.0, 1.0, -1.0].contains(number))
}

/// Is it this letter with a number?
fn is_numbered(name: &str, letter: &str) -> bool {
    name.strip_prefix(letter).is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|digit| digit.is_ascii_digit()))
}

/// The digits of a label, `9` of `h9`.
fn number_of(label: &str) -> &str {
    label.trim_start_matches(|c: char| !c.is_ascii_digit())
}

fn measure(form: Form) -> Wanted {
    match form {
        Form::Constant(wanted, _) | Form::Law(wanted) | Form::Vector(wanted) | Form::ConstantVector(wanted) => wanted,
        Form::Curve(_, [wanted, _]) => wanted,
        _ => NUMBER,
    }
}

/// The letter of a key's numbers, as the field writes it; other keys are written out.
fn letter(key: &'static str) -> &'static str {
    match key {
        "stiffness" => "k",
        "damping" => "d",
        "length" | "displacement" | "lead" => "l",
        "angle" => "phi",
        "ratio" => "i",
        "radius" => "r",
        "vector" | "force" => "f",
        "value" => "tau",
        "axis" => "u",
        "position" => "p",
        "restitution" => "e",
        other => other,
    }
}
