//! Random trees of bodies with gears, racks, rolling discs, slots and distance links put where they close.

use super::absolute::{At, JointKind, Load, State};
use super::parts::{Extended, Part};
use super::random::{Family, Random, random_case};
use super::scene_text::scene_text;
use super::variables::{Variables, owner};
use nalgebra::{Rotation2, Vector2};
use std::f64::consts::PI;
use std::fmt::Write;

/// A mechanism in a random state, as a scene, and what its variables must be.
pub struct PartsCase {
    pub scene: String,
    pub expected: Variables,
}

/// The mechanism of a seed, with at least `count` parts.
pub fn random_parts(seed: u64, count: usize) -> PartsCase {
    let mut random = Random(seed.wrapping_mul(7919) + 17);
    for attempt in 0.. {
        let case = random_case(1000 * seed + attempt, Family::Tree);
        let mut draft = Draft {
            extended: Extended { system: case.system, parts: Vec::new() },
            marks: Vec::new(),
            state: case.state,
            random: &mut random,
        };
        for _ in 0..count {
            draft.add_part();
        }
        if let Some(case) = draft.finish(seed, count) {
            return case;
        }
    }
    unreachable!("the attempts have no end")
}

struct Draft<'a> {
    extended: Extended,
    /// For each part the load that marks its points.
    marks: Vec<Option<usize>>,
    state: State,
    random: &'a mut Random,
}

impl Draft<'_> {
    fn vector(&mut self) -> Vector2<f64> {
        Vector2::new(self.random.number(-1.0, 1.0), self.random.number(-1.0, 1.0))
    }

    /// Different bodies, at most one the ground; `None` if there are too few.
    fn bodies<const N: usize>(&mut self) -> Option<[Option<usize>; N]> {
        let mut all: Vec<Option<usize>> =
            (0..=self.extended.system.bodies.len()).map(|index| index.checked_sub(1)).collect();
        if all.len() < N {
            return None;
        }
        Some(std::array::from_fn(|_| all.remove(self.random.below(all.len()))))
    }

    fn local(&self, body: Option<usize>, world: Vector2<f64>) -> At {
        let centre = body.map_or(Vector2::zeros(), |b| State::vector(&self.state.q, b));
        At { body, local: self.to_body(body, world - centre) }
    }

    fn to_body(&self, body: Option<usize>, world: Vector2<f64>) -> Vector2<f64> {
        Rotation2::new(-self.state.angle(body)) * world
    }

    fn add_part(&mut self) {
        let part = match self.random.below(5) {
            0 => self.slot(),
            1 => self.rolling(),
            2 => self.distance(),
            3 => self.gear(),
            _ => self.rack(),
        };
        let Some(part) = part else { return };
        let points = match part {
            Part::Slot { between, .. } | Part::Rolling { between, .. } | Part::Distance { between, .. } => {
                Some(between)
            }
            Part::Rack { slide, .. } => Some(slide),
            Part::Gear { .. } => None,
        };
        let loads = &mut self.extended.system.loads;
        self.marks.push(points.map(|between| {
            // A spring without stiffness: it gives the points names and does nothing else.
            loads.push(Load::Spring { between, stiffness: 0.0, length: 0.0, damping: 0.0 });
            loads.len() - 1
        }));
        self.extended.parts.push(part);
    }

    /// A line through two points: ends in their bodies, and the direction in the first.
    fn line(&mut self, [a, b]: [Option<usize>; 2], height: f64) -> ([At; 2], Vector2<f64>, f64) {
        let along = Rotation2::new(self.random.number(-PI, PI)) * Vector2::x();
        let (start, s) = (self.vector(), self.random.number(-1.0, 1.0));
        let end = start + s * along + height * Vector2::new(-along.y, along.x);
        ([self.local(a, start), self.local(b, end)], self.to_body(a, along), s)
    }

    fn slot(&mut self) -> Option<Part> {
        let bodies = self.bodies()?;
        let (between, axis, _) = self.line(bodies, 0.0);
        Some(Part::Slot { between, axis })
    }

    fn rolling(&mut self) -> Option<Part> {
        let bodies = self.bodies()?;
        let radius = self.random.number(0.1, 0.8);
        let (between, axis, s) = self.line(bodies, radius);
        let displacement = s + radius * (self.state.angle(bodies[1]) - self.state.angle(bodies[0]));
        Some(Part::Rolling { between, axis, radius, displacement })
    }

    fn distance(&mut self) -> Option<Part> {
        let [a, b] = self.bodies()?;
        let (first, second) = (self.vector(), self.vector());
        let length = (second - first).norm();
        (length > 0.2).then(|| Part::Distance { between: [self.local(a, first), self.local(b, second)], length })
    }

    fn gear(&mut self) -> Option<Part> {
        let [a, b, carrier] = self.bodies()?;
        let sign = if self.random.chance(0.5) { -1.0 } else { 1.0 };
        let ratio = sign * self.random.number(0.3, 2.0);
        let turn = |body| self.state.angle(body) - self.state.angle(carrier);
        let angle = turn(b) - ratio * turn(a);
        Some(Part::Gear { between: [a, b], carrier, ratio, angle })
    }

    fn rack(&mut self) -> Option<Part> {
        let [pinion, carrier, rack] = self.bodies()?;
        let height = self.random.number(-0.5, 0.5);
        let (slide, axis, s) = self.line([carrier, rack], height);
        let radius = self.random.number(-0.6, -0.1);
        let displacement = s - radius * (self.state.angle(pinion) - self.state.angle(carrier));
        Some(Part::Rack { pinion, slide, axis, radius, displacement })
    }

    /// `None` if the constraints are not clearly independent, or leave no freedom.
    fn finish(mut self, seed: u64, count: usize) -> Option<PartsCase> {
        if self.extended.parts.len() < count {
            return None;
        }
        let (residual, jacobian, _) = self.extended.constraints(&self.state);
        assert!(residual.amax() < 1e-12, "the parts are put where they close: {residual}");
        let clear = jacobian.nrows() < jacobian.ncols() && jacobian.singular_values().min() > 0.05;
        if !clear {
            return None;
        }
        self.state.v = self.extended.permitted_velocity(&self.state);
        let expected = self.expected();
        let mut scene = scene_text(&format!("parts_{seed}"), &self.extended.system, &self.state, &expected);
        for (i, part) in self.extended.parts.iter().enumerate() {
            let _ = write!(scene, "\n[joints.p{i}]\n{}", part_text(part, self.marks[i]));
        }
        Some(PartsCase { scene, expected })
    }

    fn expected(&self) -> Variables {
        let (state, loads) = (&self.state, self.extended.solve(&self.state));
        let mut values = Variables::new();
        let mut add = |owner: String, names: &[&str], numbers: &[f64]| {
            values.extend(names.iter().zip(numbers).map(|(name, value)| (format!("{owner}.{name}"), *value)));
        };
        for b in 0..self.extended.system.bodies.len() {
            let of = |x: &nalgebra::DVector<f64>| [x[3 * b], x[3 * b + 1], x[3 * b + 2]];
            add(format!("b{b}"), &["x", "y", "angle"], &of(&state.q));
            add(format!("b{b}"), &["vx", "vy", "omega"], &of(&state.v));
            add(format!("b{b}"), &["ax", "ay", "alpha"], &of(&loads.acceleration));
        }
        let mut multipliers = loads.joints.into_iter();
        for (i, joint) in self.extended.system.joints.iter().enumerate() {
            let names: &[&str] = match joint.kind {
                JointKind::Revolute => &["fx", "fy"],
                JointKind::Prismatic { .. } => &["fn", "torque"],
                JointKind::Weld { .. } => &["fx", "fy", "torque"],
            };
            let numbers: Vec<f64> = multipliers.by_ref().take(names.len()).collect();
            add(format!("j{i}"), names, &numbers);
        }
        for (i, (part, load)) in self.extended.parts.iter().zip(&loads.parts).enumerate() {
            let names: &[&str] = match part {
                Part::Slot { .. } => &["fn"],
                Part::Rolling { .. } => &["fn", "ft"],
                Part::Distance { .. } | Part::Rack { .. } => &["force"],
                Part::Gear { .. } => &["torque"],
            };
            add(format!("p{i}"), names, load);
            if let Some([slide, turn]) = self.extended.motion(part, state, &loads.acceleration) {
                add(format!("p{i}"), &["s", "v", "a"], &slide);
                add(format!("p{i}"), &["angle", "omega", "alpha"], &turn);
            }
            if let Part::Rack { radius, .. } = part {
                add(format!("p{i}"), &["torque"], &[-radius * load[0]]);
            }
        }
        values
    }
}

fn part_text(part: &Part, mark: Option<usize>) -> String {
    let names = |[a, b]: [At; 2]| {
        let mark = mark.expect("a part with points has a mark");
        [format!("{}.l{mark}a", owner(a.body)), format!("{}.l{mark}b", owner(b.body))]
    };
    let between = |ends: [At; 2]| format!("between = {:?}", names(ends));
    let pair = |v: Vector2<f64>| format!("[{:?}, {:?}]", v.x, v.y);
    match *part {
        Part::Slot { between: ends, axis } => format!("type = \"slot\"\n{}\naxis = {}\n", between(ends), pair(axis)),
        Part::Rolling { between: ends, axis, radius, displacement } => format!(
            "type = \"rolling\"\n{}\naxis = {}\nradius = {radius:?}\ndisplacement = {displacement:?}\n",
            between(ends),
            pair(axis)
        ),
        Part::Distance { between: ends, length } => {
            format!("type = \"distance\"\n{}\nlength = {length:?}\n", between(ends))
        }
        Part::Gear { between: [a, b], carrier, ratio, angle } => format!(
            "type = \"gear\"\nbetween = {:?}\ncarrier = \"{}\"\nratio = {ratio:?}\nangle = {angle:?}\n",
            [owner(a), owner(b)],
            owner(carrier)
        ),
        Part::Rack { pinion, slide, axis, radius, displacement } => {
            let [carrier, rack] = names(slide);
            format!(
                "type = \"rack\"\nbetween = {:?}\ncarrier = \"{carrier}\"\naxis = {}\nradius = {radius:?}\ndisplacement = {displacement:?}\n",
                [owner(pinion), rack],
                pair(axis)
            )
        }
    }
}
