//! The drawing of a mechanism at its start, or at another time.

mod coupling;
mod course;
mod held;
mod profile;

use std::collections::HashMap;

use cotree::component::{Icon, RoundGlyph};
use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol, Values};
use cotree::formulate::Formulated;
use cotree::formulate::explain::attempt::Attempt;
use cotree::model::{BodyId, Dimension, Formula, Outline, Owner, Part, Place, Quantity, Variable};
use cotree_fmu::model::State;

use super::drawing::{
    Drawing, DrawnBody, DrawnForce, DrawnJoint, DrawnShape, DrawnSpring, Hold, Target, Turn, widened,
};
use super::line;
use crate::alike::Alike;

pub fn draw(formulated: &mut Formulated) -> Drawing {
    drawn(PoseValues::new(formulated))
}

/// The drawing of a mechanism at another time.
pub fn draw_at(formulated: &mut Formulated, state: &State) -> Drawing {
    drawn(PoseValues { equations: &mut formulated.equations, state, known: HashMap::new() })
}

/// The drawing of a best attempt, with its gaps.
pub fn draw_attempt(attempt: &mut Attempt) -> Drawing {
    let mut drawing =
        drawn(PoseValues { equations: &mut attempt.equations, state: &attempt.state, known: HashMap::new() });
    drawing.mark_gaps();
    drawing
}

fn drawn(mut pose: PoseValues) -> Drawing {
    let mechanism = &*pose.equations.system.mechanism.clone();
    let mut drawing = Drawing {
        title: mechanism.name.clone(),
        bodies: (0..mechanism.bodies.len()).map(|index| pose.body(BodyId(index))).collect(),
        ..Drawing::default()
    };
    // What turns is drawn over the motors' arrows, so loads come before drivers.
    let mut fixed: Vec<Place> = mechanism.joints.iter().flat_map(|joint| joint.between).collect();
    for part in mechanism.joints.iter().chain(&mechanism.loads).chain(&mechanism.drivers) {
        let icon = (part.component().icon)(part);
        if let Icon::Line(_) = icon {
            fixed.extend(part.places());
        }
        pose.part(part, &icon, &mut drawing);
    }
    pose.held(&mut drawing);
    fixed.retain(|place| place.body().is_none());
    fixed.sort_unstable();
    fixed.dedup();
    drawing.ground = fixed.into_iter().map(|place| pose.at(place)).collect();
    let outlines = mechanism.ground_outlines.iter();
    drawing.ground_shapes = outlines.map(|outline| pose.shape(outline, None, [0.0; 2])).collect();
    if mechanism.dimension == Dimension::One {
        let pushed = drawing.targets.drain(..).map(|target| DrawnForce {
            name: target.name,
            on: target.on,
            at: target.at,
            direction: target.direction.unwrap_or([1.0, 0.0]),
        });
        drawing.forces.extend(pushed);
        line::lay_out(&mut drawing);
    }
    drawing.part_springs();
    drawing
}

/// Where the bodies are at the start, and how they are turned.
pub fn frames(formulated: &mut Formulated) -> Vec<[f64; 3]> {
    let mechanism = &*formulated.equations.system.mechanism.clone();
    let turns = mechanism.dimension == Dimension::Two;
    let mut pose = PoseValues::new(formulated);
    let mut frame = |body| {
        let [x, y] = pose.at(Place::Centre(body));
        [x, y, if turns { pose.angle(Some(body)) } else { 0.0 }]
    };
    (0..mechanism.bodies.len()).map(|index| frame(BodyId(index))).collect()
}

/// Where a place is at the start.
pub fn position(formulated: &mut Formulated, place: Place) -> [f64; 2] {
    PoseValues::new(formulated).at(place)
}

/// Where many places are at the start; they share what their paths share.
pub fn positions(formulated: &mut Formulated, places: impl IntoIterator<Item = Place>) -> Vec<[f64; 2]> {
    let mut pose = PoseValues::new(formulated);
    places.into_iter().map(|place| pose.at(place)).collect()
}

struct PoseValues<'a> {
    equations: &'a mut Equations,
    state: &'a State,
    /// Values of expressions: the places of a mechanism share most of theirs.
    known: HashMap<Expr, f64>,
}

/// Values of symbols at a state, if the inputs were changed like this.
fn values_at(state: &State, changed: impl Fn(f64) -> f64) -> impl Fn(Symbol) -> f64 {
    move |symbol| match symbol {
        Symbol::Input(_, Order::Position) => changed(state.value(symbol)),
        Symbol::Time
        | Symbol::Parameter(_)
        | Symbol::Discrete(_)
        | Symbol::Input(..)
        | Symbol::Coordinate(..)
        | Symbol::Follower(..)
        | Symbol::State(..)
        | Symbol::Reaction(_)
        | Symbol::Missing(..)
        | Symbol::Argument => state.value(symbol),
    }
}

impl<'a> PoseValues<'a> {
    fn new(formulated: &'a mut Formulated) -> Self {
        PoseValues { equations: &mut formulated.equations, state: &formulated.state, known: HashMap::new() }
    }

    fn values(&mut self, exprs: &[Expr]) -> Vec<f64> {
        self.equations.system.arena.evaluate_more(exprs, self.state, &mut self.known)
    }

    fn at(&mut self, place: Place) -> [f64; 2] {
        let of = |quantity| Variable { owner: Owner::Place(place), quantity };
        let exprs = [Quantity::X, Quantity::Y].map(|quantity| self.equations.variable(of(quantity)));
        let values = self.values(&exprs);
        [values[0], values[1]]
    }

    fn angle(&mut self, body: Option<BodyId>) -> f64 {
        let Some(body) = body else { return 0.0 };
        let angle = Variable { owner: Owner::Place(Place::Centre(body)), quantity: Quantity::Angle };
        let expr = self.equations.variable(angle);
        self.values(&[expr])[0]
    }

    fn body(&mut self, id: BodyId) -> DrawnBody {
        let body = &self.equations.system.mechanism.clone().bodies[id.0];
        let mut points: Vec<[f64; 2]> = (0..body.points.len()).map(|point| self.at(Place::Point(id, point))).collect();
        let centre = self.at(Place::Centre(id));
        let shape = body.outline.as_ref().map(|outline| self.shape(outline, Some(id), centre));
        let shape = match shape {
            // A thin rod is drawn as the bar between its ends.
            Some(DrawnShape::Polygon(ends)) if ends.len() == 2 => {
                points.extend(ends);
                None
            }
            other => other,
        };
        DrawnBody { name: body.name.clone(), points, centre, shape }
    }

    /// The shape of a body, or of the ground, in the world.
    fn shape(&mut self, outline: &Outline, id: Option<BodyId>, centre: [f64; 2]) -> DrawnShape {
        let place = |pose: &mut Self, at: &[Formula; 2]| {
            let [x, y] = pose.direction(at, id);
            [centre[0] + x, centre[1] + y]
        };
        match outline {
            Outline::Polygon(corners) => {
                DrawnShape::Polygon(corners.iter().map(|corner| place(self, corner)).collect())
            }
            Outline::Disc(at, radius) => {
                let radius = self.equations.formula(radius);
                DrawnShape::Disc(place(self, at), self.values(&[radius])[0])
            }
            Outline::Rounded(corners, offset) => {
                let corners: Vec<[f64; 2]> = corners.iter().map(|corner| place(self, corner)).collect();
                let offset = self.equations.formula(offset);
                match (&corners[..], self.values(&[offset])[0]) {
                    ([centre], radius) => DrawnShape::Disc(*centre, radius),
                    (_, offset) => DrawnShape::Polygon(widened(&corners, offset)),
                }
            }
        }
    }

    fn part(&mut self, part: &Part, icon: &Icon, drawing: &mut Drawing) {
        let name = part.name.clone();
        let between = part.between.map(|place| place.body().map(|body| body.0));
        match icon {
            Icon::Pin => drawing.joints.push(self.joint(part, Hold::Pin)),
            Icon::Fixed => drawing.joints.push(self.joint(part, Hold::Fixed)),
            Icon::Slider(axis) => {
                let axis = self.direction(axis, part.between[0].body());
                drawing.joints.push(self.joint(part, Hold::Slider(axis)));
            }
            Icon::Slot(axis) => {
                let axis = self.direction(axis, part.between[0].body());
                drawing.joints.push(self.joint(part, Hold::Slot(axis)));
            }
            Icon::Line(_) if part.contour().is_some() => drawing.springs.extend(self.profile(part)),
            Icon::Line(glyph) if part.course().is_some() => drawing.springs.extend(self.course(part, *glyph)),
            Icon::Line(glyph) => {
                let ends = part.between.map(|place| self.at(place));
                drawing.springs.push(DrawnSpring { name, between, ends, glyph: *glyph, beside: 0.0 });
            }
            Icon::Arrow { vector, in_body } => {
                let direction = self.arrow(vector, part.between[1].body().filter(|_| *in_body));
                drawing.forces.push(DrawnForce { name, on: between[1], at: self.at(part.between[1]), direction });
            }
            Icon::Turn => drawing.turns.push(self.turn(part, None)),
            Icon::Round(glyph) => drawing.turns.push(self.turn(part, Some(*glyph))),
            Icon::Push => drawing.forces.extend(self.push(part, &drawing.joints)),
            Icon::Target(position) => {
                let exprs = position.each_ref().map(|component| self.equations.formula(component));
                let (at, direction) = (self.at(part.between[1]), self.leaving(exprs));
                drawing.targets.push(Target { name, on: between[1], at, direction });
            }
            Icon::Link
            | Icon::Gears { .. }
            | Icon::Band { .. }
            | Icon::Rack { .. }
            | Icon::Rolling { .. }
            | Icon::Cam => {
                drawing.couplings.extend(self.coupling(part, icon));
            }
        }
    }

    fn turn(&mut self, part: &Part, glyph: Option<RoundGlyph>) -> Turn {
        let is_point = matches!(part.between[1], Place::Point(..) | Place::Ground(_));
        let place = if is_point { part.between[1] } else { self.turning_point(part.bodies()) };
        Turn { name: part.name.clone(), on: place.body().map(|body| body.0), at: self.at(place), glyph }
    }

    fn joint(&mut self, part: &Part, hold: Hold) -> DrawnJoint {
        DrawnJoint {
            name: part.name.clone(),
            kind: hold,
            between: part.bodies().map(|body| body.map(|body| body.0)),
            at: part.between.map(|place| self.at(place)),
            open: self.is_open(part),
        }
    }

    /// True for a joint that events engage, while it is not engaged.
    fn is_open(&self, part: &Part) -> bool {
        let engaging = self.equations.system.mechanism.engaging(part.owner);
        engaging.is_some_and(|engaging| self.state.discrete().get(engaging.engaged.0) == Some(&0.0))
    }

    /// The driver of a joint that slides, as an arrow along it.
    fn push(&mut self, part: &Part, joints: &[DrawnJoint]) -> Option<DrawnForce> {
        let driven = &self.equations.system.mechanism.joints[part.joint()?.0].name;
        let joint = joints.iter().find(|joint| joint.name == *driven)?;
        let (Hold::Slider(direction) | Hold::Slot(direction)) = joint.kind else { return None };
        Some(DrawnForce { name: part.name.clone(), on: joint.between[1], at: joint.at[1], direction })
    }

    /// A force that is zero at the start is drawn as if its inputs were positive; if that does not help, along the
    /// components that can have another value.
    fn arrow(&mut self, vector: &[Formula; 2], frame: Option<BodyId>) -> [f64; 2] {
        let exprs = vector.each_ref().map(|component| self.equations.formula(component));
        let pushed = values_at(self.state, |input| if input == 0.0 { 1.0 } else { input });
        let values = self.equations.system.arena.evaluate(&exprs, &pushed);
        let mut direction = [values[0], values[1]];
        if direction == [0.0; 2] {
            direction = exprs.map(|expr| f64::from(u8::from(expr != Expr::ZERO)));
        }
        let (sine, cosine) = self.angle(frame).sine_and_cosine();
        let [x, y] = direction;
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    /// Where bodies turn against each other: at a joint between them, or at the second.
    fn turning_point(&self, between: [Option<BodyId>; 2]) -> Place {
        let joint = self.equations.system.mechanism.joints.iter().find(|joint| {
            let bodies = joint.bodies();
            bodies == between || bodies == [between[1], between[0]]
        });
        joint.map_or_else(|| between[1].map_or(Place::Origin, Place::Centre), |joint| joint.between[1])
    }

    /// A direction that is fixed in a body, in the world.
    fn direction(&mut self, axis: &[Formula; 2], body: Option<BodyId>) -> [f64; 2] {
        let axis = axis.each_ref().map(|component| self.equations.formula(component));
        let axis = self.values(&axis);
        let (sine, cosine) = self.angle(body).sine_and_cosine();
        [cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1]]
    }

    /// Along the velocity at the start; if the point rests there, along its acceleration; if it does not accelerate either, along the
    /// components that can change at all.
    fn leaving(&mut self, position: [Expr; 2]) -> Option<[f64; 2]> {
        let arena = &mut self.equations.system.arena;
        let rate = position.map(|component| arena.time_derivative(component));
        let acceleration = rate.map(|component| arena.time_derivative(component));
        let values = [rate, acceleration].map(|pair| {
            let values = self.values(&pair);
            [values[0], values[1]]
        });
        let may_change = rate.map(|component| f64::from(u8::from(component != Expr::ZERO)));
        values.into_iter().chain([may_change]).find(|direction| direction.iter().any(|x| x.abs() > 1e-12))
    }
}
