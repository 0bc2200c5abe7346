//! From expressions to steps over scalar Taylor series.

use std::collections::HashMap;

use cotree_fmu::program::arm_form::MAX_SWITCHES;
use cotree_fmu::program::arm_form::{Given, SeriesOperation, SeriesStep, SeriesTape, Slot, Source, Term};

use super::NoSeries;
use crate::expr::{Arena, Binary, Expr, ExprNode, Order, Symbol, Unary};

/// Series of deeper expressions are not sought: each sum along a path would repeat those before it.
const DEEPEST: usize = 600;

/// What a series depends on; later levels may depend on earlier ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum SeriesLevel {
    Signals,
    Positions,
    Rates,
}

#[derive(Clone, Debug)]
enum ArmSeries {
    Constant(Expr),
    /// constant + sum of coefficient x source
    Sum(Expr, Vec<(Source, Expr)>, SeriesLevel),
}

#[derive(Debug, Default)]
pub struct Coefficients {
    list: Vec<Expr>,
    places: HashMap<Expr, u32>,
}

impl Coefficients {
    pub fn place(&mut self, expr: Expr) -> u32 {
        *self.places.entry(expr).or_insert_with(|| {
            self.list.push(expr);
            self.list.len() as u32 - 1
        })
    }

    pub fn list(&self) -> &[Expr] {
        &self.list
    }
}

#[derive(Debug, Default)]
pub struct SeriesBuilder {
    tape: SeriesTape,
    levels: Vec<SeriesLevel>,
    known: HashMap<Expr, Slot>,
    series: HashMap<Expr, ArmSeries>,
    /// Unknowns and arms that stand for expressions: coordinates and the unit vectors of frames.
    sources: HashMap<Expr, Vec<(Source, Expr)>>,
    constants: HashMap<Expr, bool>,
}

impl SeriesBuilder {
    /// From now on the expression is this sum of sources.
    pub fn define(&mut self, expr: Expr, sum: Vec<(Source, Expr)>) {
        self.sources.insert(expr, sum);
    }

    /// From now on the expression is the series in this slot.
    pub fn assign(&mut self, expr: Expr, slot: Slot) {
        self.known.insert(expr, slot);
    }

    pub fn finish(self) -> SeriesTape {
        self.tape
    }

    /// Does an expression depend on parameters alone?
    pub fn is_constant(&mut self, arena: &Arena, expr: Expr) -> bool {
        let mut pending = vec![expr];
        while let Some(&next) = pending.last() {
            let node = arena.node(next);
            let unknown = |operand: &Expr| !self.constants.contains_key(operand);
            let before = pending.len();
            if !self.constants.contains_key(&next) {
                pending.extend(node.operands().filter(unknown));
            }
            if pending.len() > before {
                continue;
            }
            let constant = match node {
                ExprNode::Constant(_) => true,
                ExprNode::Symbol(symbol) => symbol.is_constant_between_instants(),
                node => node.operands().all(|operand| self.constants[&operand]),
            };
            self.constants.insert(next, constant);
            pending.pop();
        }
        self.constants[&expr]
    }

    /// Is an expression so deep, down to what is known as a series, that finding its series would take too much room?
    fn is_too_deep(&self, arena: &Arena, expr: Expr) -> bool {
        let (mut depths, mut pending) = (HashMap::new(), vec![expr]);
        while let Some(&next) = pending.last() {
            let known = self.known.contains_key(&next) || self.series.contains_key(&next);
            let node = arena.node(next);
            let ends = known || self.sources.contains_key(&next) || self.constants.get(&next) == Some(&true);
            let before = pending.len();
            if !ends && !depths.contains_key(&next) {
                pending.extend(node.operands().filter(|operand| !depths.contains_key(operand)));
            }
            if pending.len() > before {
                continue;
            }
            let below = node.operands().map(|operand| depths.get(&operand).copied().unwrap_or(0)).max();
            depths.insert(next, if ends { 0 } else { below.map_or(0, |depth: usize| depth + 1) });
            pending.pop();
        }
        depths[&expr] > DEEPEST
    }

    pub fn slot(&mut self, arena: &mut Arena, c: &mut Coefficients, expr: Expr) -> Result<Slot, NoSeries> {
        if let Some(&slot) = self.known.get(&expr) {
            return Ok(slot);
        }
        if self.is_too_deep(arena, expr) {
            return Err(NoSeries("a law depends on too long a path".to_owned()));
        }
        let slot = match self.series(arena, c, expr)? {
            ArmSeries::Sum(Expr::ZERO, terms, _) if matches!(terms[..], [(Source::Slot(_), Expr::ONE)]) => {
                let Source::Slot(slot) = terms[0].0 else {
                    return Err(NoSeries("a Taylor series has no source".to_owned()));
                };
                slot
            }
            ArmSeries::Constant(value) => self.linear(c, value, &[], SeriesLevel::Signals),
            ArmSeries::Sum(constant, terms, level) => self.linear(c, constant, &terms, level),
        };
        self.known.insert(expr, slot);
        Ok(slot)
    }

    pub fn sum(&mut self, c: &mut Coefficients, constant: Expr, terms: &[(Source, Expr)]) -> Slot {
        let level = terms.iter().map(|(source, _)| self.level(*source)).max().unwrap_or(SeriesLevel::Signals);
        self.linear(c, constant, terms, level)
    }

    pub fn operate(&mut self, operation: SeriesOperation) -> Slot {
        let mut level = SeriesLevel::Signals;
        self.tape.each_read(&SeriesStep { target: 0, operation }, |slot| level = level.max(self.levels[slot as usize]));
        if matches!(operation, SeriesOperation::Rate(_)) {
            level = SeriesLevel::Rates;
        }
        self.push(operation, level)
    }

    fn push(&mut self, operation: SeriesOperation, level: SeriesLevel) -> Slot {
        let target = self.allocate(level);
        let steps = match level {
            SeriesLevel::Signals => &mut self.tape.signals,
            SeriesLevel::Positions => &mut self.tape.positions,
            SeriesLevel::Rates => &mut self.tape.rates,
        };
        steps.push(SeriesStep { target, operation });
        target
    }

    fn allocate(&mut self, level: SeriesLevel) -> Slot {
        self.levels.push(level);
        self.tape.slots += 1;
        self.tape.slots - 1
    }

    /// The coefficients of a combination of the components of one frame's unit vector; none if an expression is anything else.
    pub fn in_frame(&mut self, arena: &mut Arena, c: &mut Coefficients, expr: Expr, frame: u32) -> Option<[Expr; 2]> {
        let ArmSeries::Sum(Expr::ZERO, terms, _) = self.series(arena, c, expr).ok()? else { return None };
        let mut components = [Expr::ZERO; 2];
        for (source, coefficient) in terms {
            let component = match source {
                Source::X(arm) if arm == frame => &mut components[0],
                Source::Y(arm) if arm == frame => &mut components[1],
                _ => return None,
            };
            *component = arena.add(*component, coefficient);
        }
        Some(components)
    }

    fn operate_twice(&mut self, a: Slot, operation: impl Fn(Slot, Slot) -> SeriesOperation) -> [Slot; 2] {
        let second = self.allocate(self.levels[a as usize]);
        [self.operate(operation(a, second)), second]
    }

    fn linear(&mut self, c: &mut Coefficients, constant: Expr, terms: &[(Source, Expr)], level: SeriesLevel) -> Slot {
        let first = self.tape.terms.len() as u32;
        self.tape
            .terms
            .extend(terms.iter().map(|&(source, coefficient)| Term { source, factor: c.place(coefficient) }));
        let constant = (constant != Expr::ZERO).then(|| c.place(constant));
        self.push(SeriesOperation::Linear { first, count: terms.len() as u32, constant }, level)
    }

    fn level(&self, source: Source) -> SeriesLevel {
        match source {
            Source::Slot(slot) => self.levels[slot as usize],
            Source::X(_) | Source::Y(_) | Source::Unknown(_) => SeriesLevel::Positions,
            Source::UnknownRate(_) => SeriesLevel::Rates,
        }
    }

    fn of_sources(&self, terms: Vec<(Source, Expr)>) -> ArmSeries {
        let level = terms.iter().map(|(source, _)| self.level(*source)).max().unwrap_or(SeriesLevel::Signals);
        ArmSeries::Sum(Expr::ZERO, terms, level)
    }

    fn of_slot(&self, slot: Slot) -> ArmSeries {
        ArmSeries::Sum(Expr::ZERO, vec![(Source::Slot(slot), Expr::ONE)], self.levels[slot as usize])
    }

    fn series(&mut self, arena: &mut Arena, c: &mut Coefficients, expr: Expr) -> Result<ArmSeries, NoSeries> {
        if let Some(series) = self.series.get(&expr) {
            return Ok(series.clone());
        }
        let series = self.find(arena, c, expr)?;
        self.series.insert(expr, series.clone());
        Ok(series)
    }

    fn find(&mut self, arena: &mut Arena, c: &mut Coefficients, expr: Expr) -> Result<ArmSeries, NoSeries> {
        if self.is_constant(arena, expr) {
            return Ok(ArmSeries::Constant(expr));
        }
        if let Some(sum) = self.sources.get(&expr) {
            return Ok(self.of_sources(sum.clone()));
        }
        if let Some(&slot) = self.known.get(&expr) {
            return Ok(self.of_slot(slot));
        }
        match arena.node(expr) {
            ExprNode::Symbol(symbol) => self.given(symbol),
            ExprNode::Unary(function, a) => self.unary(arena, c, function, a),
            ExprNode::Binary(function, a, b) => self.binary(arena, c, function, a, b),
            ExprNode::Constant(_) => Ok(ArmSeries::Constant(expr)),
            ExprNode::Select(condition, yes, no) => self.select(arena, c, condition, [yes, no]),
        }
    }

    fn given(&mut self, symbol: Symbol) -> Result<ArmSeries, NoSeries> {
        let times = |order: Order| match order {
            Order::Position => 0,
            Order::Velocity => 1,
            Order::Acceleration => 2,
        };
        let given = match symbol {
            Symbol::Time => Given::Time,
            Symbol::Input(index, order) => Given::Input(index as u32, times(order)),
            Symbol::Follower(index, order) => Given::Follower(index as u32, times(order)),
            Symbol::Coordinate(_, Order::Acceleration) | Symbol::State(_, Order::Velocity) | Symbol::Reaction(_) => {
                return Err(NoSeries("a law depends on accelerations or reactions".to_owned()));
            }
            Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Missing(..)
            | Symbol::Argument => {
                return Err(NoSeries("a law depends on a quantity that has no Taylor series".to_owned()));
            }
        };
        let slot = self.allocate(SeriesLevel::Signals);
        self.tape.given.push((slot, given));
        Ok(self.of_slot(slot))
    }

    fn unary(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        function: Unary,
        a: Expr,
    ) -> Result<ArmSeries, NoSeries> {
        let direct: fn(Slot) -> SeriesOperation = match function {
            Unary::Negate => {
                let minus = arena.constant(-1.0);
                return self.scaled(arena, c, a, minus);
            }
            Unary::Floor => return self.floor(arena, c, a),
            Unary::Sign => {
                let values = [1.0, 0.0, -1.0].map(|value| arena.constant(value));
                return self.choose(arena, c, a, values);
            }
            Unary::Sin | Unary::Cos => {
                let angle = self.slot(arena, c, a)?;
                let [sine, cosine] = self.operate_twice(angle, SeriesOperation::SineCosine);
                for (function, slot) in [(Unary::Sin, sine), (Unary::Cos, cosine)] {
                    let expr = arena.unary(function, a);
                    self.series.insert(expr, self.of_slot(slot));
                }
                return Ok(self.of_slot(if function == Unary::Sin { sine } else { cosine }));
            }
            Unary::Tanh => {
                let a = self.slot(arena, c, a)?;
                let [slot, _] = self.operate_twice(a, SeriesOperation::HyperbolicTangent);
                return Ok(self.of_slot(slot));
            }
            Unary::Sqrt => SeriesOperation::SquareRoot,
            Unary::Exp => SeriesOperation::Exponential,
            Unary::Log => SeriesOperation::Logarithm,
            _ => {
                let composed = arena.series_of_unary(function, a).ok_or_else(|| {
                    NoSeries(format!("`{name}` has no Taylor series", name = function.definition().name))
                })?;
                return self.series(arena, c, composed);
            }
        };
        let a = self.slot(arena, c, a)?;
        let slot = self.operate(direct(a));
        Ok(self.of_slot(slot))
    }

    /// `if`: a comparison switches where its sides are equal, and says what holds there; any other condition is false where it is zero.
    fn select(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        condition: Expr,
        [yes, no]: [Expr; 2],
    ) -> Result<ArmSeries, NoSeries> {
        let (function, pieces) = match arena.node(condition) {
            ExprNode::Binary(Binary::Less, a, b) => (arena.subtract(b, a), [yes, no, no]),
            ExprNode::Binary(Binary::LessEqual, a, b) => (arena.subtract(b, a), [yes, yes, no]),
            _ => (condition, [yes, no, yes]),
        };
        self.choose(arena, c, function, pieces)
    }

    /// The first piece while a switching function is positive, the second while it is zero, the third while it is negative.
    fn choose(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        function: Expr,
        pieces: [Expr; 3],
    ) -> Result<ArmSeries, NoSeries> {
        let function = self.slot(arena, c, function)?;
        let [first, second, third] = pieces;
        let [above, equal, below] =
            [self.slot(arena, c, first)?, self.slot(arena, c, second)?, self.slot(arena, c, third)?];
        let switch = self.switch(function)?;
        let slot = self.operate(SeriesOperation::Choose { switch, above, equal, below });
        Ok(self.of_slot(slot))
    }

    /// The integer below, with a switching function of its own.
    fn floor(&mut self, arena: &mut Arena, c: &mut Coefficients, a: Expr) -> Result<ArmSeries, NoSeries> {
        let argument = self.slot(arena, c, a)?;
        let function = self.allocate(self.levels[argument as usize]);
        let switch = self.switch(function)?;
        let slot = self.operate(SeriesOperation::Floor { argument, switch, function });
        Ok(self.of_slot(slot))
    }

    fn switch(&mut self, function: Slot) -> Result<u32, NoSeries> {
        let known = self.tape.switches.iter().position(|slot| *slot == function);
        let switch = known.unwrap_or(self.tape.switches.len());
        if known.is_none() {
            self.tape.switches.push(function);
        }
        if self.tape.switches.len() > MAX_SWITCHES {
            return Err(NoSeries(format!("its laws have more than {most} pieces", most = MAX_SWITCHES)));
        }
        Ok(switch as u32)
    }

    fn arc_tangent(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        y: Expr,
        x: Expr,
    ) -> Result<ArmSeries, NoSeries> {
        let (y, x) = (self.slot(arena, c, y)?, self.slot(arena, c, x)?);
        let square = self.operate(SeriesOperation::SquareSum(x, y));
        let slot = self.operate(SeriesOperation::ArcTangent(y, x, square));
        Ok(self.of_slot(slot))
    }

    fn binary(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        function: Binary,
        a: Expr,
        b: Expr,
    ) -> Result<ArmSeries, NoSeries> {
        match function {
            Binary::Add => self.added(arena, c, [(a, 1.0), (b, 1.0)]),
            Binary::Subtract => self.added(arena, c, [(a, 1.0), (b, -1.0)]),
            Binary::Multiply if self.is_constant(arena, a) => self.scaled(arena, c, b, a),
            Binary::Multiply if self.is_constant(arena, b) => self.scaled(arena, c, a, b),
            Binary::Divide if self.is_constant(arena, b) => {
                let inverse = arena.divide(Expr::ONE, b);
                self.scaled(arena, c, a, inverse)
            }
            Binary::Multiply | Binary::Divide => {
                let (a, b) = (self.slot(arena, c, a)?, self.slot(arena, c, b)?);
                let operation =
                    if function == Binary::Multiply { SeriesOperation::Multiply } else { SeriesOperation::Divide };
                let slot = self.operate(operation(a, b));
                Ok(self.of_slot(slot))
            }
            Binary::Power if self.is_constant(arena, b) => {
                let a = self.slot(arena, c, a)?;
                let slot = self.operate(SeriesOperation::Power(a, c.place(b)));
                Ok(self.of_slot(slot))
            }
            Binary::Atan2 => self.arc_tangent(arena, c, a, b),
            _ => {
                let composed = arena.series_of_binary(function, a, b);
                let composed = composed.ok_or_else(|| {
                    NoSeries(format!("`{name}` has no Taylor series", name = function.definition().name))
                })?;
                self.series(arena, c, composed)
            }
        }
    }

    fn added(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        operands: [(Expr, f64); 2],
    ) -> Result<ArmSeries, NoSeries> {
        let (mut constant, mut all, mut highest) = (Expr::ZERO, Vec::new(), SeriesLevel::Signals);
        for (operand, sign) in operands {
            let sign = arena.constant(sign);
            match self.series(arena, c, operand)? {
                ArmSeries::Constant(value) => constant = arena.add_product(constant, sign, value),
                ArmSeries::Sum(value, terms, level) => {
                    constant = arena.add_product(constant, sign, value);
                    for (source, coefficient) in terms {
                        all.push((source, arena.multiply(sign, coefficient)));
                    }
                    highest = highest.max(level);
                }
            }
        }
        Ok(ArmSeries::Sum(constant, all, highest))
    }

    fn scaled(
        &mut self,
        arena: &mut Arena,
        c: &mut Coefficients,
        operand: Expr,
        factor: Expr,
    ) -> Result<ArmSeries, NoSeries> {
        Ok(match self.series(arena, c, operand)? {
            ArmSeries::Constant(value) => ArmSeries::Constant(arena.multiply(factor, value)),
            ArmSeries::Sum(constant, terms, level) => {
                let constant = arena.multiply(factor, constant);
                let scaled = terms.into_iter().map(|(source, value)| (source, arena.multiply(factor, value))).collect();
                ArmSeries::Sum(constant, scaled, level)
            }
        })
    }
}
