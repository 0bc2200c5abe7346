//! From the arm equations to their data.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use cotree_fmu::program::arm_form;
use cotree_fmu::program::arm_form::{
    ArmForm, Cause, Coefficient, ContactRow, CoordinatePlace, Factor as FactorData, Frame, MassCoupling, Product, Push,
    SeriesOperation, Slot, Source,
};

use super::friction::ArmLimit;
use super::linear::conjugate_product;
use super::series::{Coefficients, SeriesBuilder};
use super::{Arm, ArmEquations, ArmFactor, ArmLoad, ArmLoopEquation, Arms, NoSeries};
use crate::equations::{Constraint, Equations, FrameId, MotionLayout, MotionVariable};
use crate::expr::{Arena, Expr, ExprNode, Order, Property, Symbol, Unary, Values};

/// Loop equations that repeat others and are open by more than this, relative to their scales, repeat them but nearly: each choice of them is another motion.
const EXACTLY: f64 = 1e-13;
/// More unknowns and loop equations than these are not inverted as a whole, which equations that repeat others need.
const MOST_REPEATING: usize = 64;
/// A mean mass between 2^-20 and 2^20 [kg, kg m^2], a millionth and a million, is taken as it is: zero tests of pivots begin at 1e-13.
const ORDINARY: f64 = 20.0;

/// The arm form of a mechanism, with its coefficients still as expressions. Loop equations that repeat others in every pose are kept where they may: which of
/// them say what the others leave open changes with the pose. `values`: those of a consistent pose.
///
/// # Errors
/// Why there is none, as a clause.
pub fn arm_form(
    equations: &mut Equations,
    length: f64,
    values: &impl Values,
) -> Result<(ArmForm, Vec<Expr>), NoSeries> {
    let driven = equations.is_driven();
    let formulate = |equations: &mut Equations, counts: fn(&Constraint) -> bool| match driven {
        true => equations.arms_of_loops(counts, length),
        false => equations.arms(counts),
    };
    if repeat_exactly(equations, length, values) {
        let arms = formulate(equations, |row| row.is_imposed() || row.repeats())?;
        if may_choose(equations, &arms, values) {
            return lower(equations, arms, Vec::new(), values);
        }
    }
    let arms = formulate(equations, Constraint::is_imposed)?;
    let limits = if driven { Vec::new() } else { equations.friction_limits() };
    lower(equations, arms, limits, values)
}

/// Do loop equations repeat others, and do all of them hold in this pose?
pub(crate) fn repeat_exactly(equations: &mut Equations, length: f64, values: &impl Values) -> bool {
    let gaps = equations.gaps();
    let (repeating, gaps): (Vec<&Constraint>, Vec<Expr>) =
        equations.constraints.iter().zip(gaps).filter(|(row, _)| row.repeats()).unzip();
    let gaps = equations.system.arena.evaluate(&gaps, values);
    let hold = repeating.iter().zip(gaps).all(|(row, gap)| gap.abs() < EXACTLY * row.scale(length));
    hold && !repeating.is_empty()
}

/// May independent rows be chosen in every pose: does a mass resist each unknown, and are there few?
fn may_choose(equations: &Equations, arms: &ArmEquations, values: &impl Values) -> bool {
    let heavy = masses(equations, arms, values).iter().all(|mass| *mass > 0.0);
    let few = equations.coordinates.len() + arms.rows.len() <= MOST_REPEATING;
    let always = arms.rows.iter().all(|row| row.closed.is_none());
    heavy && few && always && arms.rods.is_empty() && arms.auxiliary.is_empty()
}

/// Masses and moments of inertia that resist the unknowns, where bodies are no links of a tree.
fn masses(equations: &Equations, arms: &ArmEquations, values: &impl Values) -> Vec<f64> {
    // From the last one, so that the first arm of each displacement is what stays.
    let diagonal = arms.coupling.iter().rev().filter(|((k, l), _)| k == l);
    let diagonal: HashMap<usize, Expr> =
        diagonal.filter_map(|((k, _), mass)| Some((k.displacement()?, mass[0]))).collect();
    let turning = arms.frames.iter().filter(|turning| !turning.coordinates.is_empty()).map(|turning| turning.inertia);
    let straight = equations.coordinates.iter().enumerate().filter(|(_, coordinate)| !coordinate.angular);
    let masses: Vec<Expr> =
        turning.chain(straight.map(|(index, _)| diagonal.get(&index).copied().unwrap_or(Expr::ZERO))).collect();
    equations.system.arena.evaluate(&masses, values)
}

/// The unit of mass: beside loop equations, whose entries are numbers and lengths, masses of very small or very large mechanisms would count as nothing, or
/// make the loop equations do so. A power of two, so that no digit changes.
fn unit_of_mass(equations: &Equations, arms: &ArmEquations, values: &impl Values) -> f64 {
    if arms.rows.is_empty() {
        return 1.0;
    }
    let mean = mean_power(&masses(equations, arms, values));
    mean.filter(|power| power.abs() > ORDINARY).map_or(1.0, |power| power.round().exp2())
}

/// What stands for the mass behind a state: a power of two in the middle of the masses of displacements, so that they stay of one order.
fn mean_mass(equations: &Equations, arms: &ArmEquations, values: &impl Values) -> f64 {
    let straight = equations.coordinates.iter().filter(|coordinate| !coordinate.angular).count();
    let masses = masses(equations, arms, values);
    mean_power(&masses[masses.len() - straight..]).map_or(1.0, |power| power.round().exp2())
}

/// The mean of the logarithms to base 2 of the masses that are positive; none if nothing has a mass.
fn mean_power(masses: &[f64]) -> Option<f64> {
    let powers: Vec<f64> = masses.iter().filter(|mass| **mass > 0.0).map(|mass| mass.log2()).collect();
    (!powers.is_empty()).then(|| powers.iter().sum::<f64>() / powers.len() as f64)
}

/// The same without loads: what the accuracy of a motion is measured by that has no series.
///
/// # Errors
/// As [`arm_form`].
pub fn mass_form(equations: &mut Equations, values: &impl Values) -> Result<(ArmForm, Vec<Expr>), NoSeries> {
    let arms = equations.arms_without_loads(Constraint::is_imposed)?;
    lower(equations, arms, Vec::new(), values)
}

fn lower(
    equations: &mut Equations,
    mut arms: ArmEquations,
    limits: Vec<ArmLimit>,
    values: &impl Values,
) -> Result<(ArmForm, Vec<Expr>), NoSeries> {
    let unit_of_mass = unit_of_mass(equations, &arms, values);
    if !equations.states.is_empty() {
        let mass = mean_mass(equations, &arms, values);
        equations.state_arms(mass, &mut arms);
    }
    let arms = &arms;
    let angular: Vec<bool> = equations.coordinates.iter().map(|coordinate| coordinate.angular).collect();
    let layout = equations.motion_layout();
    let angular = [angular, vec![false; equations.states.len()]].concat();
    let repeats: Vec<bool> = equations.constraints.iter().map(Constraint::repeats).collect();
    let per_unit = equations.system.arena.constant(1.0 / unit_of_mass);
    let mut lowering = Lowering {
        per_unit,
        layout,
        repeats: &repeats,
        arena: &mut equations.system.arena,
        arms,
        builder: SeriesBuilder::default(),
        coefficients: Coefficients::default(),
        form: ArmForm { unit_of_mass, ..ArmForm::default() },
        numbers: BTreeMap::new(),
        displacements: BTreeMap::new(),
        vectors: BTreeMap::new(),
    };
    lowering.number(&angular);
    lowering.places(&angular)?;
    lowering.shapes()?;
    lowering.couplings();
    lowering.rows()?;
    lowering.lines();
    lowering.loads()?;
    lowering.pushes()?;
    lowering.frictions(limits)?;
    let Lowering { mut form, builder, coefficients, .. } = lowering;
    form.tape = builder.finish();
    let coefficients = coefficients.list().to_vec();
    let constant = |symbol: &Symbol| symbol.is_constant_between_instants();
    match equations.system.arena.symbols(coefficients.iter().copied()).into_iter().find(|symbol| !constant(symbol)) {
        None => Ok((form, coefficients)),
        Some(Symbol::Missing(body, property)) => {
            let key = if property == Property::Mass { "mass" } else { "inertia" };
            Err(NoSeries(format!("body `{body}` has no `{key}`", body = equations.system.mechanism.bodies[body].name)))
        }
        Some(_) => Err(NoSeries("a mass or a length does not depend on the parameters alone".to_owned())),
    }
}

pub(super) struct Lowering<'a> {
    /// One over the unit of mass.
    pub(super) per_unit: Expr,
    /// Which entries of the motion are coordinates, and which are integrals of states.
    pub(super) layout: MotionLayout,
    /// Which loop equations repeat others.
    repeats: &'a [bool],
    pub(super) arena: &'a mut Arena,
    pub(super) arms: &'a ArmEquations,
    pub(super) builder: SeriesBuilder,
    pub(super) coefficients: Coefficients,
    pub(super) form: ArmForm,
    pub(super) numbers: BTreeMap<Arm, u32>,
    pub(super) displacements: BTreeMap<usize, u32>,
    vectors: BTreeMap<Vec<(Arm, [Expr; 2])>, [Slot; 2]>,
}

impl Lowering<'_> {
    /// Numbers the arms: frames, products, world.
    fn number(&mut self, angular: &[bool]) {
        let arms = self.arms;
        let mut used: BTreeSet<Arm> = BTreeSet::new();
        used.extend(arms.coupling.keys().flat_map(|(k, l)| [*k, *l]));
        used.extend(arms.links.iter().map(|link| link.arm));
        used.extend(arms.rows.iter().flat_map(|row| row.arms.keys().copied()));
        used.extend(arms.loads.iter().flat_map(|load| load.across.keys().chain(load.along.keys()).copied()));
        used.extend(arms.lines.iter().flat_map(|(_, _, across)| across.keys().copied()));
        let borne: BTreeSet<usize> = used.iter().filter_map(Arm::displacement).collect();
        for (index, _) in angular.iter().enumerate().filter(|(index, angular)| !**angular && !borne.contains(index)) {
            used.insert(Arm { frame: FrameId::WORLD, factor: ArmFactor::Displacement(index) });
        }
        let frames = arms.frames.iter().map(|turning| turning.frame).chain(arms.rods.iter().map(|rod| rod.frame));
        let frames = frames.map(Arm::of);
        let changing = used.iter().copied().filter(|arm| arm.factor != ArmFactor::One);
        let (world, products): (Vec<Arm>, Vec<Arm>) = changing.partition(|arm| arm.frame == FrameId::WORLD);
        for (number, arm) in frames.chain(products).chain(world).enumerate() {
            self.numbers.insert(arm, number as u32);
            if let Some(index) = arm.displacement() {
                self.displacements.insert(index, number as u32);
            }
        }
    }

    /// The unknown of the arm form behind each coordinate, and the inverse.
    fn places(&mut self, angular: &[bool]) -> Result<(), NoSeries> {
        let mut places: Vec<Option<CoordinatePlace>> = angular
            .iter()
            .enumerate()
            .map(|(index, angular)| {
                let arm = *self.displacements.get(&index)?;
                (!angular).then_some(CoordinatePlace::Displacement { arm })
            })
            .collect();
        let mut known: BTreeMap<Vec<usize>, u32> = BTreeMap::new();
        let mut by_size: Vec<usize> = (0..self.arms.frames.len()).collect();
        by_size.sort_by_key(|&frame| self.arms.frames[frame].coordinates.len());
        for frame in by_size {
            let coordinates = &self.arms.frames[frame].coordinates;
            let all: Vec<usize> = coordinates.keys().copied().collect();
            let Some(&first) = all.iter().find(|&&index| places[index].is_none()) else { continue };
            let rest: Vec<usize> = all.iter().copied().filter(|&index| index != first).collect();
            let parent = match rest.is_empty() {
                true => None,
                false => {
                    Some(*known.get(&rest).ok_or_else(|| NoSeries("an angle has no chain of coordinates".to_owned()))?)
                }
            };
            known.insert(all, frame as u32);
            places[first] =
                Some(CoordinatePlace::Angle { arm: frame as u32, parent, reversed: coordinates[&first] < 0.0 });
        }
        for (index, place) in places.into_iter().enumerate() {
            let place = place.ok_or_else(|| NoSeries("a coordinate does not turn any body".to_owned()))?;
            self.define_coordinate(index, place);
            self.form.coordinates.push(place);
        }
        Ok(())
    }

    fn define_coordinate(&mut self, index: usize, place: CoordinatePlace) {
        let terms = unknowns_of(place);
        let variable = self.layout.variable(index);
        let mut define = |order: Order, source: fn(u32) -> Source| {
            let symbol = self.arena.symbol(variable.symbol(order));
            let sum = terms.iter().map(|&(arm, sign)| (source(arm), self.arena.constant(sign))).collect();
            self.builder.define(symbol, sum);
        };
        // Nothing depends on the integral of a state.
        if matches!(variable, MotionVariable::Coordinate(_)) {
            define(Order::Position, Source::Unknown);
        }
        define(Order::Velocity, Source::UnknownRate);
    }

    fn shapes(&mut self) -> Result<(), NoSeries> {
        let mut first: HashMap<Vec<(usize, u64)>, u32> = HashMap::new();
        for (index, turning) in self.arms.frames.iter().enumerate() {
            let angle = turning.coordinates.iter().map(|(&coordinate, sign)| (coordinate, sign.to_bits())).collect();
            let first = *first.entry(angle).or_insert(index as u32);
            let unknown = (!turning.coordinates.is_empty()).then_some(first);
            let signal = match turning.signal == Expr::ZERO {
                true => None,
                false => Some(self.builder.slot(self.arena, &mut self.coefficients, turning.signal)?),
            };
            let inertia = self.mass(turning.inertia);
            self.form.frames.push(Frame { unknown, signal, inertia });
            for (unit, source) in turning.unit.into_iter().zip([Source::X(index as u32), Source::Y(index as u32)]) {
                let (unit, sign) = match self.arena.node(unit) {
                    ExprNode::Unary(Unary::Negate, inner) => (inner, self.arena.constant(-1.0)),
                    _ => (unit, Expr::ONE),
                };
                self.builder.define(unit, vec![(source, sign)]);
            }
        }
        let inertia = self.coefficients.place(Expr::ZERO);
        for rod in &self.arms.rods {
            let unknown = Some(self.numbers[&Arm::of(rod.frame)]);
            self.form.frames.push(Frame { unknown, signal: None, inertia });
        }
        let mut ordered: Vec<(u32, Arm)> = self.numbers.iter().map(|(arm, number)| (*number, *arm)).collect();
        ordered.sort_unstable();
        for (_, arm) in ordered {
            let factor = match arm.factor {
                ArmFactor::One => continue,
                ArmFactor::Displacement(_) => FactorData::Unknown,
                ArmFactor::Signal(signal) => {
                    FactorData::Signal(self.builder.slot(self.arena, &mut self.coefficients, signal)?)
                }
            };
            match self.numbers.get(&Arm::of(arm.frame)) {
                Some(&frame) => self.form.products.push(Product { factor, frame }),
                None => self.form.world.push(factor),
            }
        }
        Ok(())
    }

    /// A mass, or a force, in the unit of mass.
    pub(super) fn mass(&mut self, mass: Expr) -> Coefficient {
        let mass = self.arena.multiply(self.per_unit, mass);
        self.coefficients.place(mass)
    }

    fn couplings(&mut self) {
        for (&(k, l), mass) in &self.arms.coupling {
            if *mass != [Expr::ZERO; 2] {
                let mass = mass.map(|part| self.mass(part));
                self.form.coupling.push(MassCoupling { on: self.numbers[&k], from: self.numbers[&l], mass });
            }
        }
        for link in &self.arms.links {
            let arm = self.numbers[&link.arm];
            let inertia = match self.form.frames.get(arm as usize) {
                Some(frame) => frame.inertia,
                None => self.mass(link.carried.inertia),
            };
            let link = arm_form::Link {
                arm,
                parent: link.parent.map(|parent| parent as u32),
                begin: link.begin.map(|part| self.coefficients.place(part)),
                carried: link.carried.moment.map(|part| self.mass(part)),
                inertia,
            };
            self.form.links.push(link);
        }
    }

    fn rows(&mut self) -> Result<(), NoSeries> {
        for auxiliary in &self.arms.auxiliary {
            self.form.auxiliary.push(arm_form::Auxiliary {
                arm: self.displacements[&auxiliary.displacement],
                row: auxiliary.row as u32,
                direction: auxiliary.free.map(|part| self.coefficients.place(part)),
            });
        }
        for rod in &self.arms.rods {
            let length = self.coefficients.place(rod.length);
            self.form.rods.push(arm_form::Rod {
                frame: self.numbers[&Arm::of(rod.frame)],
                row: rod.row as u32,
                length,
            });
        }
        for row in &self.arms.rows {
            let repeats = self.repeats[row.constraint];
            let mut data = arm_form::LoopEquation {
                constraint: row.constraint as u32,
                repeats,
                ..arm_form::LoopEquation::default()
            };
            for (arm, p) in &row.arms {
                data.arms.push((self.numbers[arm], p.map(|part| self.coefficients.place(part))));
            }
            for &(index, factor) in &row.displacements {
                data.unknowns.push((self.displacements[&index], self.coefficients.place(factor)));
            }
            for &(frame, factor) in &row.angles {
                if let Some(unknown) = self.angle(frame) {
                    data.unknowns.push((unknown, self.coefficients.place(factor)));
                }
            }
            for &(signal, factor) in row.signals.iter().filter(|(signal, _)| *signal != Expr::ZERO) {
                let slot = self.builder.slot(self.arena, &mut self.coefficients, signal)?;
                data.signals.push((slot, self.coefficients.place(factor)));
            }
            self.slopes(row)?;
            let constant = self.arena.sum(row.constant.iter().copied());
            data.constant = self.coefficients.place(constant);
            if let Some(closed) = row.closed {
                let open = self.arena.subtract(closed, Expr::ONE);
                let (row, open) = (self.form.rows.len() as u32, self.coefficients.place(open));
                self.form.contacts.push(ContactRow { row, open, friction: None });
            }
            self.form.rows.push(data);
        }
        Ok(())
    }

    /// How the next loop equation changes with angles, where that is no constant.
    fn slopes(&mut self, row: &ArmLoopEquation) -> Result<(), NoSeries> {
        for &(frame, slope, factor) in &row.slopes {
            let Some(unknown) = self.angle(frame) else { continue };
            let slope = self.builder.slot(self.arena, &mut self.coefficients, slope)?;
            let value = Cause::Reaction { row: self.form.rows.len() as u32, slope };
            self.form.pushes.push(Push { unknown, value, factor: self.coefficients.place(factor) });
        }
        Ok(())
    }

    /// The unknown that a frame turns with.
    pub(super) fn angle(&self, frame: FrameId) -> Option<u32> {
        self.form.frames[self.numbers[&Arm::of(frame)] as usize].unknown
    }

    /// Lengths of lines that laws use, and their rates, from their components.
    fn lines(&mut self) {
        let values = self.arms.loads.iter().map(|load| load.value);
        let used: BTreeSet<Expr> =
            self.arena.reachable(values.chain(self.arms.pushes.iter().map(|push| push.value))).into_iter().collect();
        for (length, rate, across) in &self.arms.lines {
            if !used.contains(length) && !used.contains(rate) {
                continue;
            }
            let [x, y] = self.vector(across);
            let square = self.builder.operate(SeriesOperation::SquareSum(x, y));
            let slot = self.builder.operate(SeriesOperation::SquareRoot(square));
            self.builder.assign(*length, slot);
            if used.contains(rate) && rate != length {
                let slot = self.builder.operate(SeriesOperation::Rate(slot));
                self.builder.assign(*rate, slot);
            }
        }
    }

    fn vector(&mut self, arms: &Arms) -> [Slot; 2] {
        let key: Vec<(Arm, [Expr; 2])> = arms.iter().map(|(arm, z)| (*arm, *z)).collect();
        if let Some(&slots) = self.vectors.get(&key) {
            return slots;
        }
        let (mut constant, mut x, mut y) = ([Expr::ZERO; 2], Vec::new(), Vec::new());
        for (arm, &[re, im]) in arms {
            let Some(&number) = self.numbers.get(arm) else {
                constant = [re, im];
                continue;
            };
            let minus = self.arena.negate(im);
            x.extend([(Source::X(number), re), (Source::Y(number), minus)]);
            y.extend([(Source::Y(number), re), (Source::X(number), im)]);
        }
        let slots = [(constant[0], x), (constant[1], y)].map(|(constant, mut terms)| {
            terms.retain(|(_, factor)| *factor != Expr::ZERO);
            self.builder.sum(&mut self.coefficients, constant, &terms)
        });
        self.vectors.insert(key, slots);
        slots
    }

    fn loads(&mut self) -> Result<(), NoSeries> {
        for load in &self.arms.loads {
            let fixed = load.along.keys().all(Arm::is_constant);
            let constant = self.builder.is_constant(self.arena, load.value);
            let direction = load.along.get(&Arm::of(FrameId::WORLD)).copied().unwrap_or([Expr::ZERO; 2]);
            if fixed && constant {
                let force = direction.map(|part| self.arena.multiply(part, load.value));
                self.apply(load, None, force);
            } else if fixed {
                let value = self.builder.slot(self.arena, &mut self.coefficients, load.value)?;
                self.apply(load, Some(value), direction);
            } else {
                let [x, y] = self.vector(&load.along);
                let [x, y] = match (constant, load.value) {
                    (true, Expr::ONE) => [x, y],
                    (true, value) => [x, y].map(|part| {
                        self.builder.sum(&mut self.coefficients, Expr::ZERO, &[(Source::Slot(part), value)])
                    }),
                    (false, value) => {
                        let value = self.builder.slot(self.arena, &mut self.coefficients, value)?;
                        [x, y].map(|part| self.builder.operate(SeriesOperation::Multiply(value, part)))
                    }
                };
                self.apply(load, Some(x), [Expr::ONE, Expr::ZERO]);
                self.apply(load, Some(y), [Expr::ZERO, Expr::ONE]);
            }
        }
        Ok(())
    }

    /// value x force works along the arms of the load: conj(z) force on each.
    fn apply(&mut self, load: &ArmLoad, value: Option<Slot>, force: [Expr; 2]) {
        for (arm, &z) in &load.across {
            let Some(&number) = self.numbers.get(arm) else { continue };
            let moves = match arm.frame == FrameId::WORLD {
                true => matches!(arm.factor, ArmFactor::Displacement(_)),
                false => self.angle(arm.frame).is_some() || matches!(arm.factor, ArmFactor::Displacement(_)),
            };
            let along = conjugate_product(self.arena, z, force);
            if moves && along != [Expr::ZERO; 2] {
                let along = along.map(|part| self.mass(part));
                self.form.loads.push(arm_form::Load { arm: number, value, along });
            }
        }
    }

    fn pushes(&mut self) -> Result<(), NoSeries> {
        for push in &self.arms.pushes {
            let unknown = match push.on {
                Ok(frame) => self.angle(frame),
                Err(displacement) => self.displacements.get(&displacement).copied(),
            };
            let Some(unknown) = unknown else { continue };
            let (value, factor) = match self.builder.is_constant(self.arena, push.value) {
                true => (Cause::One, self.arena.multiply(push.value, push.factor)),
                false => {
                    let slot = self.builder.slot(self.arena, &mut self.coefficients, push.value)?;
                    (Cause::Series(slot), push.factor)
                }
            };
            let factor = self.mass(factor);
            self.form.pushes.push(Push { unknown, value, factor });
        }
        Ok(())
    }
}

/// The unknowns that a coordinate is made of, with their signs.
pub(super) fn unknowns_of(place: CoordinatePlace) -> Vec<(u32, f64)> {
    match place {
        CoordinatePlace::Displacement { arm } => vec![(arm, 1.0)],
        CoordinatePlace::Angle { arm, parent, reversed } => {
            let sign = if reversed { -1.0 } else { 1.0 };
            [(arm, sign)].into_iter().chain(parent.map(|parent| (parent, -sign))).collect()
        }
    }
}

impl Arm {
    fn displacement(&self) -> Option<usize> {
        match self.factor {
            ArmFactor::Displacement(index) => Some(index),
            ArmFactor::One | ArmFactor::Signal(_) => None,
        }
    }
}
