//! Modes of unilateral constraints and of friction: the equation of each mode, the condition under which it lasts, and the effect of an impact.
//!
//! All modes are one system of equations. The factor of a relation is 1 in the mode in which it holds, and its multiplier is zero in the others.

use cotree::equations::{Equations, RowKind};
use cotree::expr::{Binary, Expr, Symbol};
use cotree::model::{Contact, DiscreteId, DiscreteKind, Formula, Pressed, Quantity, Slip, Variable};
use serde_json::{Value, json};

use super::document::{DocumentBlock, Piece};
use super::feedback::beside_load;
use super::json::{formula, tree};
use super::motion::{Entry, has_masses};
use super::name::{Name, symbol_name};
use super::notation::plain::PLAIN;
use super::tree::{FormulaTree, plain};

/// What holds on one side only or rubs, with its loop equation.
struct ContactRow<'m> {
    contact: &'m Contact,
    row: usize,
}

/// A mode of one of them.
struct HoldingMode {
    /// What holds in it.
    holds: Vec<FormulaTree>,
    /// As long as this is so.
    lasts: Lasts,
    then: Vec<Piece>,
}

enum Lasts {
    While(FormulaTree),
    /// As long as what presses is open.
    Open(String),
}

/// The modes of everything in a mechanism that has some, and the levels of friction.
pub struct Modes {
    all: Vec<(String, Vec<(&'static str, HoldingMode)>)>,
    levels: Vec<(Name, FormulaTree)>,
    /// True if anything strikes.
    strikes: bool,
    /// True if anything rubs in proportion to what presses.
    rubs: bool,
}

impl Modes {
    /// None if nothing has modes.
    pub fn new(equations: &mut Equations) -> Option<Self> {
        let mechanism = equations.system.mechanism.clone();
        let edges = edges(equations, &mechanism.contacts);
        let mut modes = Modes { all: Vec::new(), levels: Vec::new(), strikes: false, rubs: false };
        for edge in edges {
            let names = match &edge.contact.slip {
                Some(slip) => {
                    modes.rubs |= !matches!(slip.pressed, Pressed::Nothing | Pressed::Belt)
                        && slip.law.mu != Formula::Number(0.0);
                    let level = level(equations, &edge, slip);
                    modes.levels.push((level_name(&edge.contact.name), level));
                    edge.of_friction(equations, slip)
                }
                None => {
                    modes.strikes = true;
                    edge.of_one_side(equations)
                }
            };
            let named = edge.contact.modes().into_iter().zip(names);
            modes.all.push((edge.contact.name.clone(), named.collect()));
        }
        (!modes.all.is_empty()).then_some(modes)
    }

    /// The table with what is needed to read it.
    pub fn blocks(&self) -> Vec<DocumentBlock> {
        let presses = if self.strikes { " A negative multiplier is a compressive contact force." } else { "" };
        let text = format!(
            "Each of these unilateral constraints and frictions is in one of its modes. Where its factor is 0 its loop equation is not active, and its multiplier is zero. Only events change modes.{presses}"
        );
        let mut blocks = vec![DocumentBlock::Text(vec![Piece::words(text)])];
        let head = ["of", "mode", "holds", "as long as", "then"].map(str::to_owned);
        blocks.push(DocumentBlock::table(head.into(), self.rows()));
        if !self.levels.is_empty() {
            blocks.push(DocumentBlock::Text(vec![Piece::words("Friction limits while sliding:")]));
            let levels = self.levels.iter().map(|(name, level)| (FormulaTree::Name(name.clone()), level.clone()));
            blocks.push(DocumentBlock::Equations(levels.collect()));
        }
        if self.strikes {
            blocks.extend(self.impact());
        }
        blocks
    }

    fn rows(&self) -> Vec<Vec<Piece>> {
        let mut rows = Vec::new();
        for (name, modes) in &self.all {
            for (index, (mode_name, mode)) in modes.iter().enumerate() {
                let of = if index == 0 { Piece::Code(name.clone()) } else { Piece::words("") };
                let holds = Piece::list(", ", mode.holds.iter().cloned().map(Piece::Math));
                let lasts = match &mode.lasts {
                    Lasts::While(relation) => Piece::Math(relation.clone()),
                    Lasts::Open(of) => Piece::Row(vec![Piece::Code(of.clone()), Piece::words(" is open")]),
                };
                rows.push(vec![of, Piece::words(*mode_name), holds, lasts, Piece::Row(mode.then.clone())]);
            }
        }
        rows
    }

    /// What happens at one instant.
    fn impact(&self) -> Vec<DocumentBlock> {
        let column = |base: &str, below: &str| FormulaTree::Name(Name::column(base, below));
        let matrix = |base: &str, below: &str| FormulaTree::Name(Name::matrix(base, below));
        let change = FormulaTree::Sum(vec![(false, column("v", "after")), (true, column("v", "before"))]);
        let transposed = FormulaTree::power(matrix("Phi", "q"), FormulaTree::Name(Name::letter("T", "")));
        let mut terms = vec![
            (false, FormulaTree::product(vec![matrix("M", ""), change])),
            (false, FormulaTree::product(vec![transposed, column("P", "")])),
        ];
        if self.rubs {
            terms.push((true, column("P", "friction")));
        }
        let mut text = vec![
            Piece::words("An impact changes rates at one instant, with impulses "),
            Piece::Math(column("P", "")),
            Piece::words(
                " instead of multipliers: of all closed contacts, those with compressive impulses take part together. The rates before and after are those of the gaps.",
            ),
        ];
        if self.rubs {
            text.extend([
                Piece::words(
                    " Friction in proportion to a normal force takes part by Coulomb's law for impulses, with ",
                ),
                Piece::Math(column("P", "friction")),
                Piece::words(
                    " from the friction limit while sliding; friction without a normal impulse has no impulse.",
                ),
            ]);
        }
        vec![DocumentBlock::Text(text), DocumentBlock::Equations(vec![(FormulaTree::Sum(terms), FormulaTree::zero())])]
    }

    /// For other programs.
    pub fn json(&self) -> [Value; 2] {
        let relation = |formula: &FormulaTree| json!({ "text": PLAIN.formula(formula), "tree": tree(formula) });
        let text = |pieces: &[Piece]| -> String {
            let piece = |piece: &Piece| match piece {
                Piece::Math(tree) => PLAIN.formula(tree),
                Piece::Words(text) | Piece::Code(text) => text.clone(),
                Piece::Row(_) => String::new(),
            };
            pieces.iter().map(piece).collect()
        };
        let modes = self.all.iter().flat_map(|(name, modes)| {
            modes.iter().map(move |(mode_name, mode)| {
                let lasts = match &mode.lasts {
                    Lasts::While(formula) => relation(formula),
                    Lasts::Open(of) => json!({ "open": of }),
                };
                let holds: Vec<Value> = mode.holds.iter().map(relation).collect();
                json!({ "of": name, "mode": mode_name, "holds": holds, "while": lasts, "then": text(&mode.then) })
            })
        });
        [modes.collect(), self.levels.iter().map(|(name, level)| formula(name, level)).collect()]
    }
}

impl ContactRow<'_> {
    /// Open, closed; of a freewheel: free, caught.
    fn of_one_side(&self, equations: &mut Equations) -> Vec<HoldingMode> {
        let (contact, name) = (self.contact, &self.contact.name);
        let closed = discrete(equations, contact.state.closed);
        let lambda = FormulaTree::Name(symbol_name(equations, Symbol::Reaction(self.row)));
        let presses = Lasts::While(relation("<=", lambda.clone(), FormulaTree::zero()));
        let share = equations.system.value(&contact.gap.restitution);
        let share = plain(equations, &[share]).pop().unwrap_or_else(FormulaTree::zero);
        let what = if contact.gap.of_rate { rate_name(name) } else { gap_name(name) };
        let quantity = FormulaTree::Name(what);
        let after = match share {
            _ if contact.gap.of_rate => FormulaTree::zero(),
            share if share == FormulaTree::zero() => share,
            share => FormulaTree::Sum(vec![(
                true,
                FormulaTree::product(vec![share, FormulaTree::Name(instant(name, "before"))]),
            )]),
        };
        let strikes = relation("=", FormulaTree::Name(instant(name, "after")), after);
        let ends = if contact.gap.of_rate {
            vec![Piece::words("it engages at the current angle; with an impact: "), Piece::Math(strikes)]
        } else {
            vec![Piece::words("impact: "), Piece::Math(strikes)]
        };
        vec![
            HoldingMode {
                holds: vec![is(closed.clone(), 0.0), is(lambda, 0.0)],
                lasts: Lasts::While(relation("<=", FormulaTree::zero(), quantity.clone())),
                then: ends,
            },
            HoldingMode {
                holds: vec![is(closed, 1.0), is(quantity, 0.0)],
                lasts: presses,
                then: vec![Piece::words(if contact.gap.of_rate { "it disengages" } else { "it opens" })],
            },
        ]
    }

    /// It sticks, slides, slides back; and does none of these where nothing touches.
    fn of_friction(&self, equations: &mut Equations, slip: &Slip) -> Vec<HoldingMode> {
        let sticks = discrete(equations, self.contact.state.closed);
        let direction = self.contact.state.direction.map_or_else(FormulaTree::zero, |way| discrete(equations, way));
        let lambda = FormulaTree::Name(symbol_name(equations, Symbol::Reaction(self.row)));
        let rate = FormulaTree::Name(rate_name(&self.contact.name));
        let level = FormulaTree::Name(level_name(&self.contact.name));
        let ratio = equations.formula(&slip.law.ratio);
        let most = match plain(equations, &[ratio]).pop() {
            Some(ratio) if ratio != FormulaTree::Number(1.0) => FormulaTree::product(vec![ratio, level]),
            _ => level,
        };
        let holds = |first: f64, second: f64, third: FormulaTree| {
            vec![is(sticks.clone(), first), is(direction.clone(), second), is(third, 0.0)]
        };
        let size = FormulaTree::Call("abs", vec![lambda.clone()]);
        let ends = |other: &str| vec![Piece::words(format!("it sticks, or slides {other}"))];
        let mut modes = vec![
            HoldingMode {
                holds: holds(1.0, 0.0, rate.clone()),
                lasts: Lasts::While(relation("<=", size, most)),
                then: vec![Piece::words("it slides in the direction of the load")],
            },
            HoldingMode {
                holds: holds(0.0, 1.0, lambda.clone()),
                lasts: Lasts::While(relation("<=", FormulaTree::zero(), rate.clone())),
                then: ends("back"),
            },
            HoldingMode {
                holds: holds(0.0, -1.0, lambda.clone()),
                lasts: Lasts::While(relation("<=", rate, FormulaTree::zero())),
                then: ends("on"),
            },
        ];
        let on = slip.on.map(|on| equations.system.mechanism.contacts[on].name.clone());
        modes.extend(on.map(|on| HoldingMode {
            holds: holds(0.0, 0.0, lambda),
            lasts: Lasts::Open(on),
            then: vec![Piece::words("its friction acts")],
        }));
        modes
    }
}

/// Those that have a loop equation.
fn edges<'m>(equations: &Equations, all: &'m [Contact]) -> Vec<ContactRow<'m>> {
    let rows = all.iter().enumerate().filter_map(|(index, contact)| Some((contact, equations.row_of_contact(index)?)));
    rows.map(|(contact, row)| ContactRow { contact, row }).collect()
}

/// The gaps, and the rates of what slides or turns freely.
pub fn indicators(equations: &mut Equations) -> [(&'static str, Vec<Entry>); 2] {
    let mechanism = equations.system.mechanism.clone();
    let (mut gaps, mut rates) = (Vec::new(), Vec::new());
    for ContactRow { contact, row } in edges(equations, &mechanism.contacts) {
        let Some(gap) = equations.constraints[row].contact().cloned() else { continue };
        if contact.slip.is_none() && !contact.gap.of_rate {
            gaps.push((gap_name(&contact.name), gap.value));
            continue;
        }
        rates.push((rate_name(&contact.name), gap.rate(&mut equations.system.arena)));
    }
    [("Gaps", gaps), ("Sliding speeds, and relative speeds of freewheels", rates)]
}

/// What friction adds to {Q} while it slides.
pub fn sliding(equations: &mut Equations) -> (&'static str, Vec<Entry>) {
    let title = "Dry friction while it slides";
    if !equations.rubs_dry() || !has_masses(equations) {
        return (title, Vec::new());
    }
    (
        title,
        beside_load(
            equations,
            |row| matches!(row.kind, RowKind::FrictionLimit | RowKind::DrivenContact(_)),
            "friction",
        ),
    )
}

/// coulomb + mu x what presses, in the scene's names.
fn level(equations: &mut Equations, edge: &ContactRow, slip: &Slip) -> FormulaTree {
    let coulomb = equations.formula(&slip.law.coulomb);
    let free = equations.system.arena.binary(Binary::Max, Expr::ZERO, coulomb);
    let mut factors = vec![equations.formula(&slip.law.mu)];
    if let (Pressed::Pin, Some(radius)) = (slip.pressed, &slip.law.radius) {
        factors.push(equations.system.value(radius));
    }
    let mut trees = plain(equations, &[vec![free], factors].concat()).into_iter();
    let free = trees.next().unwrap_or_else(FormulaTree::zero);
    let factors: Vec<FormulaTree> = trees.filter(|factor| *factor != FormulaTree::Number(1.0)).collect();
    let pressing = pressing(equations, edge, slip);
    let mut terms = vec![(false, free)];
    if let Some(pressing) = pressing.filter(|_| !factors.contains(&FormulaTree::zero())) {
        terms.push((false, FormulaTree::product([factors, vec![pressing]].concat())));
    }
    terms.retain(|(_, term)| *term != FormulaTree::zero());
    FormulaTree::sum(terms)
}

/// What presses: a size, or a sum of two.
fn pressing(equations: &mut Equations, edge: &ContactRow, slip: &Slip) -> Option<FormulaTree> {
    let size = |tree: FormulaTree| FormulaTree::Call("abs", vec![tree]);
    let variable = |equations: &Equations, quantity| {
        let variable = Variable { owner: edge.contact.owner, quantity };
        FormulaTree::Name(Name::variable(&equations.system.mechanism.variable_name(variable)))
    };
    Some(match slip.pressed {
        Pressed::Nothing | Pressed::Belt => return None,
        Pressed::Pin => {
            let squares = [Quantity::Fx, Quantity::Fy]
                .map(|velocity| FormulaTree::power(variable(equations, velocity), FormulaTree::Number(2.0)));
            FormulaTree::Root(Box::new(FormulaTree::Sum(squares.map(|square| (false, square)).into())))
        }
        Pressed::Guide { .. } => match &slip.law.length {
            None => size(variable(equations, Quantity::Fn)),
            Some(length) => {
                let length = equations.system.value(length);
                let length = plain(equations, &[length]).pop()?;
                let half =
                    FormulaTree::Quotient(Box::new([variable(equations, Quantity::Fn), FormulaTree::Number(2.0)]));
                let tilting = FormulaTree::Quotient(Box::new([variable(equations, Quantity::Torque), length]));
                let end = |minus| size(FormulaTree::Sum(vec![(false, half.clone()), (minus, tilting.clone())]));
                FormulaTree::Sum(vec![(false, end(false)), (false, end(true))])
            }
        },
        Pressed::Reaction(quantity) => size(variable(equations, quantity)),
        Pressed::Contact => {
            let row = equations.row_of_contact(slip.on?)?;
            let lambda = FormulaTree::Name(symbol_name(equations, Symbol::Reaction(row)));
            size(lambda)
        }
    })
}

/// The meaning of a discrete variable that distinguishes modes; none if no equation reads it, and none for other discrete variables.
pub fn words_of_mode(equations: &Equations, id: DiscreteId) -> Option<&'static str> {
    let mechanism = &equations.system.mechanism;
    for contact in &mechanism.contacts {
        if contact.state.closed == id {
            return Some(match (&contact.slip, contact.gap.of_rate) {
                (Some(_), _) => "1 while it sticks, else 0",
                (None, true) => "1 while it is engaged, else 0",
                (None, false) => "1 while it is closed, else 0",
            });
        }
        if contact.state.direction == Some(id) {
            return Some("1 while it slides, -1 while it slides back, else 0");
        }
        if contact.state.place == Some(id) {
            return Some(if contact.slip.is_some() { "where it sticks" } else { "the angle at which it engaged" });
        }
    }
    let discrete = &mechanism.discrete[id.0];
    match discrete.kind {
        DiscreteKind::Presence(owner) if mechanism.engaging(owner).is_some() => Some("1 while it is engaged, else 0"),
        DiscreteKind::Setting => Some("1 at the instant at which an event sets this rate, else 0"),
        DiscreteKind::Presence(_) => discrete.is_of_mode().then_some("1 until it is removed, then 0"),
        DiscreteKind::Sampled | DiscreteKind::Time | DiscreteKind::Contact => None,
        DiscreteKind::Captured(_) | DiscreteKind::Course(..) | DiscreteKind::Impulse => None,
    }
}

/// `guide.max.gap`
fn gap_name(of: &str) -> Name {
    Name::variable(&format!("{of}.gap"))
}

/// `rubbing.friction.rate`
fn rate_name(of: &str) -> Name {
    Name { plain: format!("{of}.rate"), ..Name::letter("u", of) }
}

/// `rubbing.friction.level`
pub fn level_name(of: &str) -> Name {
    Name::variable(&format!("{of}.level"))
}

/// The rate of what is held on one side, before or after an impact.
fn instant(of: &str, when: &str) -> Name {
    Name { plain: format!("{of}.rate_{when}"), ..Name::letter("u", &format!("{of}, {when}")) }
}

fn discrete(equations: &Equations, id: DiscreteId) -> FormulaTree {
    FormulaTree::Name(symbol_name(equations, Symbol::Discrete(id.0)))
}

fn relation(sign: &'static str, left: FormulaTree, right: FormulaTree) -> FormulaTree {
    FormulaTree::Relation(sign, Box::new([left, right]))
}

fn is(left: FormulaTree, value: f64) -> FormulaTree {
    relation("=", left, FormulaTree::number(value))
}
