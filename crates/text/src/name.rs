//! Names of quantities: the user's, and a letter with a subscript and dots.

use cotree::diagnostic::Span;
use cotree::equations::{Equations, RowKind};
use cotree::expr::{Order, Property, Symbol};

#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// As the user writes it, such as `crank.omega`.
    pub plain: String,
    /// The letter or word, such as `theta`.
    pub base: String,
    /// Such as `crank`; may be empty.
    pub subscript: String,
    pub dots: usize,
    /// Is it written upright and bold: a vector or a matrix?
    pub bold: bool,
}

impl Name {
    /// A letter with a subscript; in plain text `letter_subscript`.
    pub fn letter(base: &str, subscript: &str) -> Name {
        let plain = if subscript.is_empty() { base.to_owned() } else { format!("{base}_{subscript}") };
        Name { plain, base: base.to_owned(), subscript: subscript.to_owned(), dots: 0, bold: false }
    }

    pub fn bold(base: &str, subscript: &str) -> Name {
        Name { bold: true, ..Name::letter(base, subscript) }
    }

    /// A variable of an edge of a graph, such as `F[h9]`; no name of the user's has brackets.
    pub fn edge(base: &str, label: &str, bold: bool) -> Name {
        Name { plain: format!("{base}[{label}]"), bold, ..Name::letter(base, label) }
    }

    /// A matrix of the page's own; in brackets in plain text, where a parameter may have the same name.
    pub fn matrix(base: &str, subscript: &str) -> Name {
        let name = Name::bold(base, subscript);
        Name { plain: format!("[{}]", name.plain), ..name }
    }

    /// A column of the page's own; in braces in plain text.
    pub fn column(base: &str, subscript: &str) -> Name {
        let name = Name::bold(base, subscript);
        Name { plain: format!("{{{}}}", name.plain), ..name }
    }

    /// An entry of a matrix or column, counted from 1 in plain text: `M[1,2]`. No name of the user's has brackets.
    pub fn entry(base: &str, places: &[usize]) -> Name {
        let places: Vec<String> = places.iter().map(|place| (place + 1).to_string()).collect();
        let places = places.join(",");
        Name { plain: format!("{base}[{places}]"), ..Name::letter(base, &places) }
    }

    /// A symbol that the page made up: a letter with what stands behind an underscore below it, such as `m_rod` and `s_12'`.
    pub fn symbol(plain: &str) -> Name {
        if plain.contains('.') {
            return Name::variable(plain); // the user's own
        }
        let dots = plain.bytes().rev().take_while(|byte| *byte == b'\'').count();
        match plain[..plain.len() - dots].split_once('_') {
            Some((letter, below)) if !below.is_empty() => {
                Name { plain: plain.to_owned(), dots, ..Name::letter(letter, below) }
            }
            _ => Name::word(plain),
        }
    }

    /// A word, such as the name of a parameter; digits at its end become a subscript.
    pub fn word(plain: &str) -> Name {
        let base = plain.trim_end_matches(|c: char| c.is_ascii_digit());
        // With a number below, these are entries of the page's own matrices and columns.
        let is_indexed = matches!(
            base,
            "M" | "Q" | "Phi" | "Phi_q" | "Phi_t" | "gamma" | "lambda" | "D" | "K" | "F" | "q" | "v" | "a"
        );
        let base = if base.is_empty() || base.ends_with('_') || is_indexed { plain } else { base };
        let subscript = &plain[base.len()..];
        Name { plain: plain.to_owned(), ..Name::letter(base, subscript) }
    }

    /// A variable of the naming table, such as `crank.omega`: a letter for what it is, with its owner below.
    pub fn variable(plain: &str) -> Name {
        let Some((owner, word)) = plain.rsplit_once('.') else { return Name::word(plain) };
        let (base, dots) = match word {
            "angle" => ("theta", 0),
            "omega" => ("theta", 1),
            "alpha" => ("theta", 2),
            "vx" => ("x", 1),
            "vy" => ("y", 1),
            "ax" => ("x", 2),
            "ay" => ("y", 2),
            "v" => ("s", 1),
            "a" => ("s", 2),
            "length" => ("r", 0),
            "rate" => ("r", 1),
            "acceleration" => ("r", 2),
            "inertia" => ("I", 0),
            "mass" => ("m", 0),
            word => (word, 0),
        };
        Name { plain: plain.to_owned(), dots, ..Name::letter(base, owner) }
    }

    /// Does it stand for a variable of the naming table?
    pub fn is_variable(&self) -> bool {
        self.plain.contains('.')
    }
}

/// The names of everything in the equations of one mechanism.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    equations: &'a Equations,
    pub coordinates: usize,
    /// Letters for cosines and sines that no numbered name of the user's begins with, and the number of underscores between letter and number.
    trigonometric: ([&'static str; 2], usize),
    /// The same for shared parts.
    shared: (&'static str, usize),
}

impl<'a> Names<'a> {
    pub fn new(equations: &'a Equations) -> Self {
        let mechanism = &equations.system.mechanism;
        let taken = mechanism.parameters.iter().map(|parameter| parameter.name.as_str());
        let taken = taken.chain(mechanism.inputs.iter().map(|input| input.name.as_str()));
        let taken: Vec<&str> = taken.chain(mechanism.drivers.iter().map(|driver| driver.name.as_str())).collect();
        let is_free = |letter: &str, lines: usize| {
            let stem = format!("{letter}{}", "_".repeat(lines));
            let is_numbered = |name: &&str| {
                name.strip_prefix(stem.as_str())
                    .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()))
            };
            !taken.iter().any(is_numbered)
        };
        // As many underscores as there are names are enough: each name excludes one number of them.
        let lines = |letters: &[&str]| {
            (1..=taken.len() + 1).find(|&lines| letters.iter().all(|letter| is_free(letter, lines))).unwrap_or(1)
        };
        let short = is_free("c", 0) && is_free("s", 0);
        Names {
            equations,
            coordinates: highest(equations),
            trigonometric: if short { (["c", "s"], 0) } else { (["cos", "sin"], lines(&["cos", "sin"])) },
            shared: if is_free("z", 0) { ("z", 0) } else { ("part", lines(&["part"])) },
        }
    }

    pub fn symbol(&self, symbol: Symbol) -> Name {
        symbol_name(self.equations, symbol)
    }

    /// The number of a coordinate that is an angle, counted from 1.
    pub fn coordinate(&self, symbol: Symbol) -> Option<usize> {
        match symbol {
            Symbol::Coordinate(index, Order::Position) if self.equations.coordinates[index].angular => {
                // `theta_9` has `c9` and `s9`.
                let written = self.equations.coordinates[index].name.position.strip_prefix("theta_");
                written.map_or(Some(index + 1), |number| number.parse().ok())
            }
            Symbol::Coordinate(..) | Symbol::Time | Symbol::Parameter(_) | Symbol::Discrete(_) => None,
            Symbol::Input(..) | Symbol::Follower(..) => None,
            Symbol::State(..) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => None,
        }
    }

    /// `c1`, `s1`
    pub fn trigonometric(&self, sine: bool, number: usize) -> Name {
        let (letters, lines) = self.trigonometric;
        numbered(letters[usize::from(sine)], lines, number)
    }

    /// `z1`
    pub fn shared(&self, number: usize) -> Name {
        numbered(self.shared.0, self.shared.1, number)
    }
}

/// The highest number of a coordinate.
fn highest(equations: &Equations) -> usize {
    let numbers = equations
        .coordinates
        .iter()
        .filter_map(|coordinate| coordinate.name.position.strip_prefix("theta_")?.parse().ok());
    numbers.chain([equations.coordinates.len()]).max().unwrap_or_default()
}

fn numbered(letter: &str, lines: usize, number: usize) -> Name {
    Name { plain: format!("{letter}{}{number}", "_".repeat(lines)), ..Name::letter(letter, &number.to_string()) }
}

pub fn symbol_name(equations: &Equations, symbol: Symbol) -> Name {
    let mechanism = &equations.system.mechanism;
    let derivative = |name: Name, order: Order| {
        let dots = order as usize;
        Name { plain: format!("{}{}", name.plain, &"''"[..dots]), dots, ..name }
    };
    match symbol {
        Symbol::Time => Name::word("t"),
        Symbol::Parameter(i) => {
            let parameter = &mechanism.parameters[i];
            // Parameters that the page made up stand nowhere in the scene.
            if equations.symbolic && parameter.span == Span::default() {
                Name::symbol(&parameter.name)
            } else {
                Name::word(&parameter.name)
            }
        }
        Symbol::Discrete(i) => Name::word(&mechanism.discrete[i].name),
        Symbol::Input(i, order) => derivative(Name::word(&mechanism.inputs[i].name), order),
        Symbol::State(i, order) => derivative(Name::word(&mechanism.states[i].name), order),
        Symbol::Follower(i, order) => {
            let driver = equations.system.followers[i].0;
            derivative(Name::word(&mechanism.drivers[driver.0].name), order)
        }
        Symbol::Coordinate(i, order) => {
            let name = &equations.coordinates[i].name;
            let name = match order {
                Order::Position => &name.position,
                Order::Velocity => &name.rate,
                Order::Acceleration => &name.acceleration,
            };
            Name::symbol(name)
        }
        Symbol::Reaction(row) => reaction_name(equations, row),
        Symbol::Argument => Name::letter("theta", ""),
        Symbol::Missing(body, Property::Mass) => Name::variable(&format!("{}.mass", mechanism.bodies[body].name)),
        Symbol::Missing(body, Property::Inertia) => Name::variable(&format!("{}.inertia", mechanism.bodies[body].name)),
    }
}

/// A multiplier, the level of friction, or the value of a load.
fn reaction_name(equations: &Equations, row: usize) -> Name {
    // Counted among the loop equations that constrain the motion.
    let multiplier = || Name::entry("lambda", &[equations.loops().filter(|(index, _)| *index < row).count()]);
    let Some(constraint) = equations.constraints.get(row) else { return multiplier() };
    match constraint.kind {
        RowKind::FrictionLimit | RowKind::DrivenContact(_) => {
            super::modes::level_name(equations.system.name(constraint.element))
        }
        RowKind::LoadValue => super::feedback::value_name(equations, constraint),
        RowKind::Loop(_) | RowKind::Contact(_) => multiplier(),
    }
}
