//! From expressions to tapes: what depends on parameters only goes to a stage of its own, the rest becomes instructions over
//! registers that are used again as soon as their value is dead.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};

use cotree_fmu::program::Layout;
use cotree_fmu::tape::{Instruction, Operation, Tape};

use crate::expr::{Arena, Binary, Evaluation, Expansions, Expr, ExprNode, Order, Symbol, Unary};

/// Register allocation for the constants and parameter expressions that the kernels of one program share; then their tapes.
#[derive(Debug)]
pub struct Assembler<'a> {
    arena: Cow<'a, Arena>,
    /// Replacements of functions that the runtime has no operation for.
    expansions: Expansions,
    layout: Layout,
    /// Depends on nothing but parameters, for each expression of the kernels.
    fixed: Vec<bool>,
    /// Registers of constants and of the parameter stage, for each expression.
    shared: Vec<Option<u32>>,
    pub constants: Vec<f64>,
    pub stage: Tape,
    scratch: u32,
    pub registers: u32,
}

impl<'a> Assembler<'a> {
    /// Finds the constants and the parameter stage of the given kernels.
    pub fn new(arena: &'a Arena, layout: Layout, kernels: &[&[Expr]]) -> Self {
        let (arena, expansions) = arena.runnable(&kernels.concat());
        let roots: Vec<Expr> = kernels.iter().flat_map(|kernel| expansions.of(kernel)).collect();
        let used = arena.reachable(roots.iter().copied());
        let mut fixed = vec![false; arena.len()];
        for &expr in &used {
            fixed[expr.index()] = match arena.node(expr) {
                ExprNode::Constant(_) => true,
                ExprNode::Symbol(symbol) => symbol.is_constant_between_instants(),
                node => node.operands().all(|operand| fixed[operand.index()]),
            };
        }
        let mut assembler = Assembler {
            shared: vec![None; arena.len()],
            arena,
            expansions,
            layout,
            fixed,
            constants: Vec::new(),
            stage: Tape::default(),
            scratch: 0,
            registers: 0,
        };
        assembler.place_constants(&used);
        assembler.place_stage(&used, &roots);
        assembler
    }

    pub fn tape(&mut self, results: &[Expr]) -> Tape {
        let results: &[Expr] = &self.expansions.of(results);
        let order: Vec<Expr> = self
            .arena
            .reachable(results.iter().copied())
            .into_iter()
            .filter(|&expr| self.home(expr).is_none() && !self.fixed[expr.index()])
            .collect();
        let mut writer = TapeWriter::new(self, &order, results);
        writer.write();
        let results = results.iter().map(|&result| writer.register(result)).collect();
        let tape = Tape::new(writer.tape, results);
        self.registers = self.registers.max(writer.highest);
        tape
    }

    /// The register of an expression that needs no instruction.
    fn home(&self, expr: Expr) -> Option<u32> {
        match self.arena.node(expr) {
            ExprNode::Symbol(symbol) => Some(symbol_register(&self.layout, symbol) as u32),
            _ => self.shared[expr.index()],
        }
    }

    fn place_constants(&mut self, used: &[Expr]) {
        for &expr in used {
            if let Some(value) = self.arena.as_constant(expr) {
                self.shared[expr.index()] = Some((self.layout.constants() + self.constants.len()) as u32);
                self.constants.push(value);
            }
        }
        self.scratch = (self.layout.constants() + self.constants.len()) as u32;
        self.registers = self.scratch;
    }

    /// Allocates a permanent register to every fixed expression that is an operand of a varying one, or a result.
    fn place_stage(&mut self, used: &[Expr], results: &[Expr]) {
        let needed_by_moving =
            used.iter().filter(|e| !self.fixed[e.index()]).flat_map(|&e| self.arena.node(e).operands());
        let frontier = needed_by_moving
            .chain(results.iter().copied())
            .filter(|&e| self.fixed[e.index()] && self.home(e).is_none());
        let order: Vec<Expr> =
            self.arena.reachable(frontier).into_iter().filter(|&expr| self.home(expr).is_none()).collect();
        let first = self.scratch;
        let mut writer = TapeWriter::new(self, &order, &order);
        writer.write();
        let (tape, places, highest) = (std::mem::take(&mut writer.tape), writer.places, writer.highest);
        order.iter().zip(places).for_each(|(expr, place)| self.shared[expr.index()] = place);
        self.scratch = highest.max(first);
        self.registers = self.scratch;
        self.stage = Tape::new(tape, Vec::new());
    }
}

/// The register of a symbol. Missing masses are refused before, arguments of laws have been replaced.
pub fn symbol_register(layout: &Layout, symbol: Symbol) -> usize {
    match symbol {
        Symbol::Time => layout.time(),
        Symbol::Parameter(i) => layout.parameters() + i,
        Symbol::Discrete(i) => layout.discrete() + i,
        Symbol::Input(i, Order::Position) => layout.inputs() + i,
        Symbol::Input(i, Order::Velocity) => layout.input_rates() + i,
        Symbol::Input(i, Order::Acceleration) => layout.input_accelerations() + i,
        Symbol::Follower(i, Order::Position) => layout.followers() + i,
        Symbol::Follower(i, Order::Velocity) => layout.follower_rates() + i,
        Symbol::Follower(i, Order::Acceleration) => layout.follower_accelerations() + i,
        Symbol::Coordinate(i, Order::Position) => layout.positions() + i,
        Symbol::Coordinate(i, Order::Velocity) => layout.rates() + i,
        Symbol::Coordinate(i, Order::Acceleration) => layout.accelerations() + i,
        Symbol::State(i, Order::Position) => layout.states() + i,
        Symbol::State(i, _) => layout.state_rates() + i,
        Symbol::Reaction(i) => layout.reactions() + i,
        Symbol::Missing(..) | Symbol::Argument => layout.time(),
    }
}

/// The number of an expression that is not in an order.
const NONE: u32 = u32::MAX;

/// Lists by numbers instead of maps by expressions: neighbours in the order are neighbours in memory.
struct TapeWriter<'w, 'a> {
    assembler: &'w Assembler<'a>,
    /// What is computed, operands first.
    order: &'w [Expr],
    /// The number of each expression in the order.
    numbers: Vec<u32>,
    /// By numbers: products whose only use is a sum or a difference, which becomes one instruction with it.
    fused: Vec<bool>,
    schedule: Vec<Expr>,
    /// By numbers.
    last_use: Vec<usize>,
    /// By numbers.
    places: Vec<Option<u32>>,
    free: Vec<u32>,
    highest: u32,
    tape: Vec<Instruction>,
}

impl<'w, 'a> TapeWriter<'w, 'a> {
    fn new(assembler: &'w Assembler<'a>, order: &'w [Expr], results: &[Expr]) -> Self {
        let mut numbers = vec![NONE; order.last().map_or(0, |last| last.index() + 1)];
        order.iter().zip(0..).for_each(|(expr, number)| numbers[expr.index()] = number);
        let mut writer = TapeWriter {
            assembler,
            order,
            numbers,
            fused: vec![false; order.len()],
            schedule: Vec::new(),
            last_use: vec![0; order.len()],
            places: vec![None; order.len()],
            free: Vec::new(),
            highest: assembler.scratch,
            tape: Vec::new(),
        };
        writer.fuse(results);
        writer.schedule = writer.schedule();
        writer.find_last_uses(results);
        writer
    }

    fn fuse(&mut self, results: &[Expr]) {
        let mut uses = vec![0; self.order.len()];
        let mut depths = vec![0; self.order.len()];
        let arena = &self.assembler.arena;
        for (number, &expr) in self.order.iter().enumerate() {
            for used in arena.node(expr).operands().filter_map(|operand| self.number(operand)) {
                uses[used] += 1;
                depths[number] = depths[number].max(depths[used] + 1);
            }
        }
        results.iter().filter_map(|&result| self.number(result)).for_each(|result| uses[result] += 1);
        for &expr in self.order {
            if let Some(product) = self.fusible(expr, &uses, &depths) {
                self.fused[product] = true;
            }
        }
    }

    /// Of two products the one that more operations precede: it would be waited for, and results take three times as long through a register of the file as within an instruction.
    fn fusible(&self, expr: Expr, uses: &[usize], depths: &[usize]) -> Option<usize> {
        let arena = &self.assembler.arena;
        let ExprNode::Binary(Binary::Add | Binary::Subtract, a, b) = arena.node(expr) else { return None };
        let product = |operand: Expr| {
            let number = self.number(operand).filter(|&number| uses[number] == 1)?;
            matches!(arena.node(operand), ExprNode::Binary(Binary::Multiply, ..)).then_some(number)
        };
        [a, b].into_iter().filter_map(product).max_by_key(|&number| depths[number])
    }

    fn find_last_uses(&mut self, results: &[Expr]) {
        let mut last_use = std::mem::take(&mut self.last_use);
        for (position, &expr) in self.schedule.iter().enumerate() {
            self.operands(expr).filter_map(|operand| self.number(operand)).for_each(|used| last_use[used] = position);
        }
        results.iter().filter_map(|&result| self.number(result)).for_each(|result| last_use[result] = usize::MAX);
        self.last_use = last_use;
    }

    fn number(&self, expr: Expr) -> Option<usize> {
        self.numbers.get(expr.index()).filter(|number| **number != NONE).map(|&number| number as usize)
    }

    fn is_fused(&self, expr: Expr) -> bool {
        self.number(expr).is_some_and(|number| self.fused[number])
    }

    fn place(&self, expr: Expr) -> Option<u32> {
        self.places[self.number(expr)?]
    }

    fn set_place(&mut self, expr: Expr, register: u32) {
        if let Some(number) = self.number(expr) {
            self.places[number] = Some(register);
        }
    }

    /// What an instruction reads: for a fused product its factors.
    fn operands(&self, expr: Expr) -> impl Iterator<Item = Expr> {
        let arena = &self.assembler.arena;
        arena.node(expr).operands().flat_map(move |operand| {
            let factors = self.is_fused(operand).then(|| arena.node(operand).operands());
            let single = factors.is_none().then_some(operand);
            factors.into_iter().flatten().chain(single)
        })
    }

    /// Operands before what uses them, and operations of the same kind in sequence as far as dependencies permit (list scheduling): the interpreter branches once for a
    /// sequence. Among the kinds that are ready, the most frequent is scheduled first.
    fn schedule(&self) -> Vec<Expr> {
        let size = self.order.len();
        let written = || (0..size).filter(move |&number| !self.fused[number]);
        let (mut users, mut missing) = (vec![Vec::new(); size], vec![0; size]);
        for number in written() {
            for operand in self.operands(self.order[number]).filter_map(|operand| self.number(operand)) {
                users[operand].push(number);
                missing[number] += 1;
            }
        }
        let mut ready: BTreeMap<u8, VecDeque<usize>> = BTreeMap::new();
        let kind = |number: usize| self.kind(self.order[number]) as u8;
        for number in written().filter(|&number| missing[number] == 0) {
            ready.entry(kind(number)).or_default().push_back(number);
        }
        let mut schedule = Vec::with_capacity(size);
        while let Some(next) =
            ready.iter().max_by_key(|(kind, queue)| (queue.len(), Reverse(**kind))).map(|(kind, _)| *kind)
        {
            while let Some(number) = ready.get_mut(&next).and_then(VecDeque::pop_front) {
                schedule.push(self.order[number]);
                for &user in &users[number] {
                    missing[user] -= 1;
                    if missing[user] == 0 {
                        ready.entry(kind(user)).or_default().push_back(user);
                    }
                }
            }
            ready.remove(&next);
        }
        schedule
    }

    fn write(&mut self) {
        for (position, expr) in std::mem::take(&mut self.schedule).into_iter().enumerate() {
            if self.place(expr).is_none() {
                self.write_one(expr);
            }
            self.release(expr, position);
        }
    }

    fn write_one(&mut self, expr: Expr) {
        if let ExprNode::Unary(function @ (Unary::Sin | Unary::Cos), angle) = self.assembler.arena.node(expr) {
            self.write_sin_cos(expr, function, angle);
            return;
        }
        let (operation, operands) = self.operation(expr);
        let [a, b, c] = operands;
        let target = self.allocate();
        self.set_place(expr, target);
        self.tape.push(Instruction { operation, target, a, b, c });
    }

    /// Sine and cosine are computed together; the register of an unused one is free at once.
    fn write_sin_cos(&mut self, expr: Expr, function: Unary, angle: Expr) {
        let other = if function == Unary::Sin { Unary::Cos } else { Unary::Sin };
        let partner =
            self.assembler.arena.existing(ExprNode::Unary(other, angle)).filter(|p| self.number(*p).is_some());
        let a = self.register(angle);
        let (place, beside) = (self.allocate(), self.allocate());
        self.set_place(expr, place);
        match partner {
            Some(partner) => self.set_place(partner, beside),
            None => self.free.push(beside),
        }
        let (target, c) = if function == Unary::Sin { (place, beside) } else { (beside, place) };
        self.tape.push(Instruction { operation: Operation::SinCos, target, a, b: 0, c });
    }

    fn kind(&self, expr: Expr) -> Operation {
        match self.assembler.arena.node(expr) {
            ExprNode::Binary(Binary::Add, a, b) if self.is_fused(a) || self.is_fused(b) => Operation::MultiplyAdd,
            ExprNode::Binary(Binary::Subtract, a, _) if self.is_fused(a) => Operation::MultiplySubtract,
            ExprNode::Binary(Binary::Subtract, _, b) if self.is_fused(b) => Operation::SubtractProduct,
            ExprNode::Binary(function, ..) => operation(function.definition().run),
            ExprNode::Unary(function, _) => operation(function.definition().run),
            ExprNode::Select(..) => Operation::Select,
            // Constants and symbols have registers of their own and are not scheduled.
            ExprNode::Constant(_) | ExprNode::Symbol(_) => Operation::Copy,
        }
    }

    fn operation(&self, expr: Expr) -> (Operation, [u32; 3]) {
        let at = |e: Expr| self.register(e);
        let operands = match self.assembler.arena.node(expr) {
            ExprNode::Binary(Binary::Add | Binary::Subtract, a, b) if self.is_fused(a) || self.is_fused(b) => {
                let (product, other) = if self.is_fused(a) { (a, b) } else { (b, a) };
                let factors: Vec<u32> = self.assembler.arena.node(product).operands().map(at).collect();
                [factors[0], factors[1], at(other)]
            }
            ExprNode::Binary(_, a, b) => [at(a), at(b), 0],
            ExprNode::Unary(_, a) => [at(a), 0, 0],
            ExprNode::Select(a, b, c) => [at(a), at(b), at(c)],
            ExprNode::Constant(_) | ExprNode::Symbol(_) => [at(expr), 0, 0],
        };
        (self.kind(expr), operands)
    }

    fn register(&self, expr: Expr) -> u32 {
        self.place(expr).or_else(|| self.assembler.home(expr)).unwrap_or_default()
    }

    fn allocate(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.highest += 1;
            self.highest - 1
        })
    }

    fn release(&mut self, expr: Expr, position: usize) {
        let dies = |number: &usize| self.last_use[*number] == position;
        let mut dying: Vec<usize> =
            self.operands(expr).filter_map(|operand| self.number(operand)).filter(dies).collect();
        dying.sort_unstable();
        dying.dedup();
        self.free.extend(dying.into_iter().filter_map(|number| self.places[number]));
    }
}

/// Functions composed of others are expanded before they get here.
fn operation<const N: usize>(run: Evaluation<N>) -> Operation {
    match run {
        Evaluation::Own(operation, ..) => operation,
        Evaluation::As(_) => Operation::Copy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COORDINATES: [f64; 4] = [0.31, -0.77, 1.2, 0.05];
    const PARAMETERS: [f64; 3] = [0.9, -0.4, 2.2];

    fn value(symbol: Symbol) -> f64 {
        match symbol {
            Symbol::Coordinate(i, _) => COORDINATES[i],
            Symbol::Parameter(i) => PARAMETERS[i],
            Symbol::Time | Symbol::Discrete(_) | Symbol::Input(..) | Symbol::Follower(..) => f64::NAN,
            Symbol::State(..) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => f64::NAN,
        }
    }

    /// Expressions that are made of each other at random.
    fn pool(arena: &mut Arena, pick: &mut impl FnMut(usize) -> usize) -> Vec<Expr> {
        let coordinates = (0..COORDINATES.len()).map(|i| Symbol::Coordinate(i, Order::Position));
        let symbols = coordinates.chain((0..PARAMETERS.len()).map(Symbol::Parameter));
        let mut pool: Vec<Expr> = symbols.map(|symbol| arena.symbol(symbol)).collect();
        for _ in 0..5 + pick(120) {
            let [a, b, c] = [(); 3].map(|()| pool[pick(pool.len())]);
            let product = arena.multiply(a, b);
            pool.push(match pick(6) {
                0 => arena.add(a, b),
                1 => arena.subtract(a, b),
                2 => product,
                3 => arena.add(product, c),
                4 => arena.sin(a),
                _ => arena.cos(a),
            });
        }
        pool
    }

    #[test]
    fn tapes_have_the_bits_of_their_expressions() {
        let mut seed = 7_u64;
        let mut pick = move |count: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % count
        };
        for _ in 0..300 {
            let mut arena = Arena::default();
            let pool = pool(&mut arena, &mut pick);
            let kernels = [(); 2].map(|()| (0..1 + pick(6)).map(|_| pool[pick(pool.len())]).collect::<Vec<Expr>>());
            let layout = Layout::new([PARAMETERS.len(), 0, 0, 0], [COORDINATES.len(), 0], 0);
            let mut assembler = Assembler::new(&arena, layout, &kernels.each_ref().map(Vec::as_slice));
            let tapes = kernels.each_ref().map(|kernel| assembler.tape(kernel));
            let mut registers = vec![0.0; assembler.registers as usize];
            registers[layout.positions()..][..COORDINATES.len()].copy_from_slice(&COORDINATES);
            registers[layout.parameters()..][..PARAMETERS.len()].copy_from_slice(&PARAMETERS);
            registers[layout.constants()..][..assembler.constants.len()].copy_from_slice(&assembler.constants);
            assembler.stage.run(&mut registers);
            for (tape, kernel) in tapes.iter().zip(&kernels) {
                tape.run(&mut registers);
                let found: Vec<u64> = tape.results(&registers).map(f64::to_bits).collect();
                let expected: Vec<u64> = arena.evaluate(kernel, &value).into_iter().map(f64::to_bits).collect();
                assert_eq!(found, expected);
            }
        }
    }
}
