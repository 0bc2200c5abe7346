//! The terminal equations of the elements: their rows of Table 1.

mod coupling;
mod law;

use cotree::equations::Equations;
use cotree::expr::Expr;
use cotree::model::{BodyId, Formula, Owner, Quantity, Variable};
use cotree::network::{
    Angle, CircleTangent, Direction, Element, ElementId, Force, Known, Origin, Resistance, Rotation, Torque,
    Translation,
};

use super::labels::number;
use super::letters::Letters;
use super::parts::kind;
use super::projection::{Rows, is_free};
use super::view::GraphView;
use super::{Lesson, heading, thinned, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::{FormulaTree, plain};

/// What writes the terminal equations of an element.
struct TerminalWriter<'l> {
    equations: &'l mut Equations,
    letters: Letters,
    translation: &'l GraphView<Translation>,
    rotation: &'l GraphView<Rotation>,
}

impl Lesson<'_> {
    /// Section 5: what each element says by itself.
    pub fn terminal(&mut self) -> Vec<DocumentBlock> {
        let count = self.equations.system.elements.len();
        let mut rows = Vec::new();
        for id in (0..count).map(ElementId) {
            if !self.equations.system.has_edges(id) {
                continue;
            }
            let element = self.equations.system.element(id).clone();
            let equations = self.sentence(id, &element);
            let row = vec![Piece::words(&element.label), equations, self.unknowns(&element)];
            rows.push((kind(&element).to_owned(), row));
        }
        let mut blocks = vec![heading("5. What is the law of each element? Terminal equations (Table 1)")];
        blocks.push(words("Nothing is eliminated yet; u and n are unit vectors along and across an axis, R turns by an angle, k is out of the plane."));
        blocks.extend(thinned("Terminal equations", &["edge", "equations", "unknown"], rows));
        blocks.extend(self.switching());
        blocks.extend(self.gravity());
        if self.letters.has_two_components() {
            blocks.push(words("What is fixed in a body, arms and axes, turns with it:"));
            blocks.push(DocumentBlock::Equations(turning()));
        }
        blocks.push(words(self.count_of_equations()));
        blocks
    }

    /// Its equations behind each other: those of all modes, then what holds in one only.
    fn sentence(&mut self, id: ElementId, element: &Element) -> Piece {
        let equation = |(left, right)| Piece::Math(FormulaTree::Relation("=", Box::new([left, right])));
        let list = |rows: Rows| Piece::list(";  ", rows.into_iter().map(equation));
        let mut rows = self.says(id);
        let when = match (element.origin, &element.slip) {
            (Origin::Contact(_), Some(_)) => "while it sticks: ",
            (Origin::Contact(_), None) => "while it is closed: ",
            _ => return list(rows),
        };
        let loads = if self.dynamic { element.coupling.as_ref().map_or(0, |coupling| coupling.terms.len()) } else { 0 };
        let always = rows.split_off(rows.len().saturating_sub(loads));
        let between = if always.is_empty() { "" } else { ";  " };
        Piece::Row(vec![list(always), Piece::words(format!("{between}{when}")), list(rows)])
    }

    /// What is to be known of terminal equations that switch.
    fn switching(&self) -> Option<DocumentBlock> {
        let modes = !self.equations.system.mechanism.contacts.is_empty();
        modes.then(|| {
            words(
                "A unilateral constraint or dry friction has another terminal equation in each mode: the one that is written holds in one \
                 mode, and in the others the multiplier is zero instead. Its edge remains a chord of every tree, so that graphs, coordinates \
                 and the number of equations do not change; section 7 has the modes.",
            )
        })
    }

    /// The components of gravity, if it acts.
    fn gravity(&mut self) -> Option<DocumentBlock> {
        let mechanism = &*self.equations.system.mechanism.clone();
        let gravity = mechanism.gravity.each_ref().map(|component| self.equations.system.value(component));
        let vector = self.letters.components(plain(&self.equations, &gravity));
        let acts = self.dynamic && gravity != [Expr::ZERO; 2];
        acts.then(|| DocumentBlock::Equations(vec![(self.letters.gravity(), vector)]))
    }

    /// The terminal equations of one element, forces and torques only if there are masses.
    pub fn says(&mut self, id: ElementId) -> Rows {
        let element = self.equations.system.element(id).clone();
        let Lesson { equations, letters, translation, rotation, .. } = self;
        let mut terminal = TerminalWriter { equations, letters: *letters, translation, rotation };
        let mut rows = terminal.displacement(&element);
        rows.extend(terminal.angle(&element));
        rows.extend(terminal.relation(id, &element));
        if self.dynamic {
            rows.extend(terminal.force(&element));
            rows.extend(terminal.torque(&element));
            rows.extend(terminal.loads(id, &element));
        }
        rows
    }

    /// What an element leaves unknown: r or s, F or lambda, theta, T.
    fn unknowns(&self, element: &Element) -> Piece {
        let (letters, label) = (self.letters, element.label.as_str());
        let mut unknown = Vec::new();
        if let Some(row) = &element.translation {
            match row.motion.first() {
                Some((Direction::Fixed(..), _)) => unknown.push(letters.slide(label)),
                Some(_) => unknown.push(letters.displacement(label)),
                None => {}
            }
            match (row.reaction.len(), matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_))) {
                (0, false) => {}
                (1, _) if letters.has_two_components() => {
                    let along = !row.motion.is_empty();
                    unknown.push(letters.projected(letters.force(label), row.reaction[0], element, !along));
                }
                _ => unknown.push(letters.force(label)),
            }
        }
        if let Some(row) = &element.rotation {
            let free = matches!(row.angle, Angle::Free(_));
            unknown.push(if free { letters.angle(label) } else { letters.torque(label) });
        }
        Piece::list(", ", unknown.into_iter().map(Piece::Math))
    }

    /// Two variables for each edge and direction against terminal, cutset and circuit equations.
    fn count_of_equations(&self) -> String {
        let directions = if self.letters.has_two_components() { 2 } else { 1 };
        let (t, r) = (self.translation.record.edges.len(), self.rotation.record.edges.len());
        let (t_cut, r_cut) = (directions * self.translation.record.cutsets.len(), self.rotation.record.cutsets.len());
        let (t_loop, r_loop) =
            (directions * self.translation.record.circuits.len(), self.rotation.record.circuits.len());
        let (unknowns, terminal) = (2 * directions * t + 2 * r, directions * t + r);
        let all = terminal + t_cut + r_cut + t_loop + r_loop;
        let verdict = if all == unknowns { "as many" } else { "NOT as many" };
        format!(
            "Check: two variables for each edge and direction are 2*{directions}*{t} + 2*{r} = {unknowns} unknowns; {terminal} terminal, {t_cut} + \
             {r_cut} cutset and {t_loop} + {r_loop} circuit equations are {all}, {verdict}. The four steps bring them to {}.",
            self.equations.coordinates.len() + self.equations.loops().count()
        )
    }
}

impl TerminalWriter<'_> {
    fn displacement(&mut self, element: &Element) -> Rows {
        let Some(row) = &element.translation else { return Rows::new() };
        let displacement = self.letters.displacement(&element.label);
        let axis = row.motion.first().map(|(along, _)| *along).and_then(|along| match along {
            Direction::Fixed(body, axis) => {
                Some((self.letters.direction(along, element, true), self.turned(body, axis)))
            }
            Direction::X | Direction::Y => None,
        });
        let slide = |axis: &FormulaTree| FormulaTree::product(vec![self.letters.slide(&element.label), axis.clone()]);
        match (&row.known, axis) {
            (Known::Zero, Some(axis)) => vec![(displacement, slide(&axis.0)), axis],
            (Known::Zero, None) if matches!(element.origin, Origin::Joint(_)) => {
                vec![(displacement, FormulaTree::zero())]
            }
            (Known::Zero, None) => Rows::new(),
            // A rolling disc: along the line, and a radius beside it.
            (Known::Fixed(body, at), Some(axis)) => {
                let arm = FormulaTree::Name(Name::edge("h", &element.label, true));
                let both = FormulaTree::Sum(vec![(false, slide(&axis.0)), (false, arm.clone())]);
                vec![(displacement, both), axis, (arm, self.turned(*body, *at))]
            }
            (Known::Fixed(body, at), None) => vec![(displacement, self.turned(*body, *at))],
            (Known::Given([x, y]), _) => vec![(displacement, self.components([x.value, y.value]))],
            (Known::Along(body, axis, signal), _) => {
                let name = FormulaTree::Name(Name::edge("u", &element.label, true));
                vec![(displacement, self.times(signal.value, name.clone())), (name, self.turned(*body, *axis))]
            }
        }
    }

    fn force(&mut self, element: &Element) -> Rows {
        let Some(row) = &element.translation else { return Rows::new() };
        let force = self.letters.force(&element.label);
        let along = |along: &Direction| self.letters.projected(force.clone(), *along, element, true);
        let mut motion = row.motion.iter().map(|(direction, _)| along(direction));
        let right = match &row.through {
            // The free direction of a rolling disc belongs to its coupling.
            Force::None if element.coupling.is_some() => return Rows::new(),
            Force::None if row.armature == Expr::ZERO => {
                return motion.map(|projected| (projected, FormulaTree::zero())).collect();
            }
            Force::None => {
                let projected = motion.next().unwrap_or(force);
                return vec![(projected, self.slide_armature(element, row.armature, FormulaTree::zero()))];
            }
            Force::Inertia(body) => self.inertia_force(element, *body),
            Force::Resistance(law) => {
                let speed = self.letters.rate_of_slide(&element.label);
                let projected = motion.next().unwrap_or(force);
                let resisting = self.resisting(element, *law, speed, Quantity::V);
                return vec![(projected, self.slide_armature(element, row.armature, resisting))];
            }
            Force::World(vector) => {
                self.letters.components(vector.iter().map(|component| self.law(component)).collect())
            }
            Force::InBody(body, vector) => {
                let vector = self.letters.components(vector.iter().map(|component| self.law(component)).collect());
                FormulaTree::product(vec![FormulaTree::Call("R", vec![self.angle_of(*body)]), vector])
            }
            Force::Line(law) if self.letters.has_two_components() => {
                sum(vec![(self.law(law), Some(self.unit(&element.label)))])
            }
            Force::Line(law) => self.law(law),
            Force::Tangent(law, tangent) => {
                let unit = self.unit_tangent(&element.label, *tangent);
                sum(vec![(self.law(law), Some(unit))])
            }
        };
        vec![(force, right)]
    }

    /// -m (a - g); a body that opts out of gravity has no g.
    fn inertia_force(&mut self, element: &Element, body: BodyId) -> FormulaTree {
        let mass = self.value_name(body, "mass");
        let system = &mut self.equations.system;
        let mechanism = &*system.mechanism.clone();
        let weightless = mechanism.bodies[body.0].weightless
            || mechanism.gravity.each_ref().map(|component| system.value(component)) == [Expr::ZERO; 2];
        let acceleration = self.letters.acceleration(&element.label);
        match weightless {
            _ if mass == FormulaTree::zero() => mass,
            true => FormulaTree::Sum(vec![(true, FormulaTree::product(vec![mass, acceleration]))]),
            false => FormulaTree::product(vec![
                mass,
                FormulaTree::sum(vec![(true, acceleration), (false, self.letters.gravity())]),
            ]),
        }
    }

    /// The direction from one end of an element to the other.
    fn unit(&self, label: &str) -> FormulaTree {
        let size = FormulaTree::Call("abs", vec![self.letters.displacement(label)]);
        FormulaTree::Quotient(Box::new([self.letters.displacement(label), size]))
    }

    /// The same along a tangent of circles about them: (sqrt(|r|^2 - k^2) r - k J r)/|r|^2, where J turns by a quarter turn.
    pub fn unit_tangent(&self, label: &str, tangent: CircleTangent) -> FormulaTree {
        if tangent.difference == Expr::ZERO {
            return self.unit(label);
        }
        let displacement = || self.letters.displacement(label);
        let square = FormulaTree::power(FormulaTree::Call("abs", vec![displacement()]), FormulaTree::Number(2.0));
        let across = FormulaTree::Call("turned", vec![displacement()]);
        let along = FormulaTree::product(vec![self.straight_length(label, tangent), displacement()]);
        let sideways = FormulaTree::product(vec![self.formula(tangent.difference), across]);
        FormulaTree::quotient(vec![FormulaTree::Sum(vec![(false, along), (true, sideways)])], vec![square])
    }

    /// The length of a tangent between circles.
    pub fn straight_length(&self, label: &str, tangent: CircleTangent) -> FormulaTree {
        let distance = FormulaTree::Call("abs", vec![self.letters.displacement(label)]);
        if tangent.difference == Expr::ZERO {
            return distance;
        }
        let square = |tree: FormulaTree| FormulaTree::power(tree, FormulaTree::Number(2.0));
        let difference = square(self.formula(tangent.difference));
        FormulaTree::Root(Box::new(FormulaTree::Sum(vec![(false, square(distance)), (true, difference)])))
    }

    fn angle(&self, element: &Element) -> Option<(FormulaTree, FormulaTree)> {
        let value = match element.rotation.as_ref()?.angle {
            Angle::Free(_) => return None,
            Angle::Constant(value) => value,
            Angle::Given(signal) => signal.value,
        };
        Some((self.letters.angle(&element.label), self.formula(value)))
    }

    fn torque(&mut self, element: &Element) -> Option<(FormulaTree, FormulaTree)> {
        let row = element.rotation.as_ref()?;
        let right = match &row.through {
            Torque::None if is_free(element) && element.coupling.is_none() => FormulaTree::zero(),
            Torque::None => return None,
            Torque::Inertia(body) => self.inertia_torque(element, *body),
            Torque::Resistance(law) => {
                self.resisting(element, *law, self.letters.omega(&element.label), Quantity::Omega)
            }
            Torque::Law(law) => self.law(law),
        };
        let right = self.with_armature(right, row.armature, self.letters.alpha(&element.label));
        Some((self.letters.torque(&element.label), right))
    }

    fn slide_armature(&mut self, element: &Element, armature: Expr, force: FormulaTree) -> FormulaTree {
        let acceleration = self.letters.acceleration_of_slide(&element.label);
        self.with_armature(force, armature, acceleration)
    }

    /// Less armature times acceleration.
    fn with_armature(&mut self, right: FormulaTree, armature: Expr, acceleration: FormulaTree) -> FormulaTree {
        if armature == Expr::ZERO {
            return right;
        }
        let inertia = FormulaTree::product(vec![self.formula(armature), acceleration]);
        let before = (right != FormulaTree::zero()).then_some((false, right));
        FormulaTree::Sum(before.into_iter().chain([(true, inertia)]).collect())
    }

    /// -I alpha - k . sum r x F over the edges that turn with the body (6).
    fn inertia_torque(&mut self, element: &Element, body: BodyId) -> FormulaTree {
        let inertia = self.value_name(body, "inertia");
        let mut terms = Vec::new();
        if inertia != FormulaTree::zero() {
            terms.push((true, FormulaTree::product(vec![inertia, self.letters.alpha(&element.label)])));
        }
        let carried = self.translation.record.edges.iter().filter(|edge| edge.carrier == Some(body));
        let moments = carried.map(|edge| {
            let moment = [self.letters.displacement(&edge.label), self.letters.force(&edge.label)];
            (false, FormulaTree::Relation("x", Box::new(moment)))
        });
        let moments: Vec<(bool, FormulaTree)> = moments.collect();
        if !moments.is_empty() {
            terms.push((true, self.letters.out_of_plane(FormulaTree::Sum(moments))));
        }
        FormulaTree::sum(terms)
    }

    /// -c v; with friction the whole law of the joint's velocity.
    fn resisting(&mut self, element: &Element, law: Resistance, speed: FormulaTree, quantity: Quantity) -> FormulaTree {
        match (law.damper(), element.origin) {
            (None, Origin::Joint(joint)) => {
                let velocity = self.equations.variable(Variable { owner: Owner::Joint(joint), quantity });
                let resisting = law.at(&mut self.equations.system.arena, velocity);
                self.formula(resisting)
            }
            (damper, _) => {
                let minus = self.equations.system.arena.negate(damper.unwrap_or(Expr::ZERO));
                self.times(minus, speed)
            }
        }
    }

    fn law(&self, law: &Formula) -> FormulaTree {
        law::tree(self.equations, self.letters, law)
    }

    fn formula(&self, expr: Expr) -> FormulaTree {
        plain(self.equations, &[expr]).pop().unwrap_or_else(FormulaTree::zero)
    }

    fn times(&self, factor: Expr, tree: FormulaTree) -> FormulaTree {
        sum(vec![(self.formula(factor), Some(tree))])
    }

    /// R(theta) (x, y); the ground does not turn, nor does anything on a line.
    fn turned(&self, body: Option<BodyId>, at: [Expr; 2]) -> FormulaTree {
        match body {
            Some(body) if self.letters.has_two_components() => {
                FormulaTree::product(vec![FormulaTree::Call("R", vec![self.angle_of(body)]), self.components(at)])
            }
            _ => self.components(at),
        }
    }

    fn components(&self, vector: [Expr; 2]) -> FormulaTree {
        self.letters.components(vector.map(|component| self.formula(component)).into())
    }

    /// The symbol of a body's mass or inertia.
    fn value_name(&mut self, body: BodyId, word: &str) -> FormulaTree {
        let described = &self.equations.system.mechanism.clone().bodies[body.0];
        let (formula, letter) = if word == "mass" { (&described.mass, "m") } else { (&described.inertia, "I") };
        match formula {
            Some(formula) => {
                let value = self.equations.system.value(formula);
                self.formula(value)
            }
            // A body that does not turn needs no inertia: its symbol stands, and goes with its angular acceleration.
            None => {
                let system = &self.equations.system;
                let number = system.find(Origin::Body(body)).map(|id| number(system, id));
                FormulaTree::Name(Name::symbol(&format!("{letter}_{}", number.unwrap_or_default())))
            }
        }
    }

    /// theta of the edge of a body.
    fn angle_of(&self, body: BodyId) -> FormulaTree {
        let system = &self.equations.system;
        let id = system.find(Origin::Body(body));
        self.letters.angle(id.map_or("", |id| &system.element(id).label))
    }
}

/// v = omega k x r, a = alpha k x r - omega^2 r
fn turning() -> Vec<(FormulaTree, FormulaTree)> {
    let [k, r, v, a] = ["k", "r", "v", "a"].map(|letter| FormulaTree::Name(Name::bold(letter, "")));
    let [omega, alpha] = ["omega", "alpha"].map(|letter| FormulaTree::Name(Name::word(letter)));
    let across = |rate: &FormulaTree| {
        FormulaTree::Relation("x", Box::new([FormulaTree::product(vec![rate.clone(), k.clone()]), r.clone()]))
    };
    let square = FormulaTree::product(vec![FormulaTree::power(omega.clone(), FormulaTree::Number(2.0)), r.clone()]);
    vec![(v, across(&omega)), (a, FormulaTree::Sum(vec![(false, across(&alpha)), (true, square)]))]
}

/// Products with their signs in front; ones and zeros are left out.
fn sum(terms: Vec<(FormulaTree, Option<FormulaTree>)>) -> FormulaTree {
    let one = FormulaTree::Number(1.0);
    let term = |(factor, tree): (FormulaTree, Option<FormulaTree>)| {
        let (minus, factor) = match factor {
            FormulaTree::Sum(mut only) if only.len() == 1 => only.remove(0),
            other => (false, other),
        };
        let product = match tree {
            Some(tree) if factor == one => tree,
            Some(tree) if factor != FormulaTree::zero() => FormulaTree::product(vec![factor, tree]),
            _ => factor,
        };
        (minus, product)
    };
    FormulaTree::sum(terms.into_iter().map(term).filter(|(_, tree)| *tree != FormulaTree::zero()).collect())
}
