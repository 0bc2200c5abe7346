//! From expressions to tapes: what depends on parameters only goes to a stage of its own, the rest becomes instructions over
//! registers that are used again as soon as their value is dead.

use std::collections::{HashMap, HashSet};

use cotree_fmu::program::Layout;
use cotree_fmu::tape::{Instruction, Operation, Tape};

use crate::expr::{Arena, Binary, Expr, Node, Order, Symbol, Unary};

/// Assigns registers to everything that the kernels of one program share, then makes their tapes.
#[derive(Debug)]
pub struct Assembler<'a> {
    arena: &'a Arena,
    layout: Layout,
    /// Depends on nothing but parameters, for each expression of the kernels.
    fixed: Vec<bool>,
    shared: HashMap<Expr, u32>,
    /// Values of the constant registers.
    pub constants: Vec<f64>,
    /// The parameter stage.
    pub stage: Tape,
    scratch: u32,
    /// Registers needed by all tapes so far.
    pub registers: u32,
}

impl<'a> Assembler<'a> {
    /// Finds the constants and the parameter stage of the given kernels.
    pub fn new(arena: &'a Arena, layout: Layout, kernels: &[&[Expr]]) -> Self {
        let used = arena.reachable(kernels.iter().flat_map(|kernel| kernel.iter().copied()));
        let mut fixed = vec![false; arena.len()];
        for &expr in &used {
            fixed[expr.index()] = match arena.node(expr) {
                Node::Constant(_) => true,
                Node::Symbol(symbol) => matches!(symbol, Symbol::Parameter(_)),
                node => node.operands().all(|operand| fixed[operand.index()]),
            };
        }
        let mut assembler = Assembler {
            arena,
            layout,
            fixed,
            shared: HashMap::new(),
            constants: Vec::new(),
            stage: Tape::default(),
            scratch: 0,
            registers: 0,
        };
        assembler.place_constants(&used);
        assembler.place_stage(&used, kernels);
        assembler
    }

    /// The tape that computes the given results.
    pub fn tape(&mut self, results: &[Expr]) -> Tape {
        let order: Vec<Expr> = self
            .arena
            .reachable(results.iter().copied())
            .into_iter()
            .filter(|&expr| self.home(expr).is_none() && !self.fixed[expr.index()])
            .collect();
        let mut writer = Writer::new(self, &order, results);
        writer.write(&order);
        let tape = Tape {
            results: results.iter().map(|&result| writer.register(result)).collect(),
            instructions: writer.tape,
        };
        self.registers = self.registers.max(writer.highest);
        tape
    }

    /// The register of something that needs no instruction.
    fn home(&self, expr: Expr) -> Option<u32> {
        match self.arena.node(expr) {
            Node::Symbol(symbol) => Some(symbol_register(&self.layout, symbol)),
            _ => self.shared.get(&expr).copied(),
        }
    }

    fn place_constants(&mut self, used: &[Expr]) {
        for &expr in used {
            if let Some(value) = self.arena.as_constant(expr) {
                self.shared.insert(expr, (self.layout.constants() + self.constants.len()) as u32);
                self.constants.push(value);
            }
        }
        self.scratch = (self.layout.constants() + self.constants.len()) as u32;
        self.registers = self.scratch;
    }

    /// Every fixed expression that something moving (or a result) needs gets a register for good.
    fn place_stage(&mut self, used: &[Expr], kernels: &[&[Expr]]) {
        let needed_by_moving =
            used.iter().filter(|e| !self.fixed[e.index()]).flat_map(|&e| self.arena.node(e).operands());
        let results = kernels.iter().flat_map(|kernel| kernel.iter().copied());
        let frontier: HashSet<Expr> =
            needed_by_moving.chain(results).filter(|&e| self.fixed[e.index()] && self.home(e).is_none()).collect();
        let order: Vec<Expr> =
            self.arena.reachable(frontier).into_iter().filter(|&expr| self.home(expr).is_none()).collect();
        let first = self.scratch;
        let mut writer = Writer::new(self, &order, &order);
        writer.write(&order);
        let (tape, places, highest) = (std::mem::take(&mut writer.tape), writer.places, writer.highest);
        self.shared.extend(places);
        self.scratch = highest.max(first);
        self.registers = self.scratch;
        self.stage = Tape { instructions: tape, results: Vec::new() };
    }
}

/// The register of a symbol. A missing mass never gets here: it is refused before.
fn symbol_register(layout: &Layout, symbol: Symbol) -> u32 {
    let register = match symbol {
        Symbol::Time => layout.time(),
        Symbol::Parameter(i) => layout.parameters() + i,
        Symbol::Input(i, Order::Position) => layout.inputs() + i,
        Symbol::Input(i, Order::Velocity) => layout.input_rates() + i,
        Symbol::Input(i, Order::Acceleration) => layout.input_accelerations() + i,
        Symbol::Follower(i, Order::Position) => layout.followers() + i,
        Symbol::Follower(i, Order::Velocity) => layout.follower_rates() + i,
        Symbol::Follower(i, Order::Acceleration) => layout.follower_accelerations() + i,
        Symbol::Coordinate(i, Order::Position) => layout.positions() + i,
        Symbol::Coordinate(i, Order::Velocity) => layout.rates() + i,
        Symbol::Coordinate(i, Order::Acceleration) => layout.accelerations() + i,
        Symbol::Reaction(i) => layout.reactions() + i,
        Symbol::Missing(..) => layout.time(),
    };
    register as u32
}

/// Writes one tape.
struct Writer<'w, 'a> {
    assembler: &'w Assembler<'a>,
    /// Products that are added to something at their only use.
    fused: HashSet<Expr>,
    last_use: HashMap<Expr, usize>,
    places: HashMap<Expr, u32>,
    free: Vec<u32>,
    highest: u32,
    tape: Vec<Instruction>,
}

impl<'w, 'a> Writer<'w, 'a> {
    fn new(assembler: &'w Assembler<'a>, order: &[Expr], results: &[Expr]) -> Self {
        let mut uses: HashMap<Expr, usize> = HashMap::new();
        for &expr in order {
            for operand in assembler.arena.node(expr).operands() {
                *uses.entry(operand).or_default() += 1;
            }
        }
        for &result in results {
            *uses.entry(result).or_default() += 1;
        }
        let mut writer = Writer {
            assembler,
            fused: HashSet::new(),
            last_use: HashMap::new(),
            places: HashMap::new(),
            free: Vec::new(),
            highest: assembler.scratch,
            tape: Vec::new(),
        };
        for &expr in order {
            if let Some(product) = writer.fusible(expr, &uses) {
                writer.fused.insert(product);
            }
        }
        for (position, &expr) in order.iter().enumerate() {
            for operand in writer.operands(expr) {
                writer.last_use.insert(operand, position);
            }
        }
        for &result in results {
            writer.last_use.insert(result, usize::MAX);
        }
        writer
    }

    /// A product that only this sum uses.
    fn fusible(&self, expr: Expr, uses: &HashMap<Expr, usize>) -> Option<Expr> {
        let Node::Binary(Binary::Add, a, b) = self.assembler.arena.node(expr) else { return None };
        [a, b].into_iter().find(|&operand| {
            matches!(self.assembler.arena.node(operand), Node::Binary(Binary::Multiply, ..))
                && uses.get(&operand) == Some(&1)
                && self.assembler.home(operand).is_none()
        })
    }

    /// Operands after fusion.
    fn operands(&self, expr: Expr) -> Vec<Expr> {
        let node = self.assembler.arena.node(expr);
        node.operands()
            .flat_map(|operand| {
                if self.fused.contains(&operand) {
                    self.assembler.arena.node(operand).operands().collect()
                } else {
                    vec![operand]
                }
            })
            .collect()
    }

    fn write(&mut self, order: &[Expr]) {
        for (position, &expr) in order.iter().enumerate() {
            if self.fused.contains(&expr) {
                continue;
            }
            if !self.places.contains_key(&expr) {
                self.write_one(expr);
            }
            self.release(expr, position);
        }
    }

    fn write_one(&mut self, expr: Expr) {
        if let Node::Unary(function @ (Unary::Sin | Unary::Cos), angle) = self.assembler.arena.node(expr) {
            self.write_sin_cos(expr, function, angle);
            return;
        }
        let (operation, operands) = self.operation(expr);
        let [a, b, c] = operands;
        let target = self.allocate();
        self.places.insert(expr, target);
        self.tape.push(Instruction { operation, target, a, b, c });
    }

    /// Sine and cosine come together; one that nobody uses dies at once.
    fn write_sin_cos(&mut self, expr: Expr, function: Unary, angle: Expr) {
        let other = if function == Unary::Sin { Unary::Cos } else { Unary::Sin };
        let partner =
            self.assembler.arena.existing(Node::Unary(other, angle)).filter(|p| self.last_use.contains_key(p));
        let a = self.register(angle);
        let (own, beside) = (self.allocate(), self.allocate());
        self.places.insert(expr, own);
        match partner {
            Some(partner) => {
                self.places.insert(partner, beside);
            }
            None => self.free.push(beside),
        }
        let (target, c) = if function == Unary::Sin { (own, beside) } else { (beside, own) };
        self.tape.push(Instruction { operation: Operation::SinCos, target, a, b: 0, c });
    }

    fn operation(&self, expr: Expr) -> (Operation, [u32; 3]) {
        let at = |e: Expr| self.register(e);
        match self.assembler.arena.node(expr) {
            Node::Binary(Binary::Add, a, b) if self.fused.contains(&a) || self.fused.contains(&b) => {
                let (product, other) = if self.fused.contains(&a) { (a, b) } else { (b, a) };
                let factors: Vec<u32> = self.assembler.arena.node(product).operands().map(at).collect();
                (Operation::MultiplyAdd, [factors[0], factors[1], at(other)])
            }
            Node::Binary(function, a, b) => (binary_operation(function), [at(a), at(b), 0]),
            Node::Unary(function, a) => (unary_operation(function), [at(a), 0, 0]),
            Node::Select(a, b, c) => (Operation::Select, [at(a), at(b), at(c)]),
            // Constants and symbols have registers of their own and never come here.
            Node::Constant(_) | Node::Symbol(_) => (Operation::Copy, [at(expr), 0, 0]),
        }
    }

    fn register(&self, expr: Expr) -> u32 {
        let own = self.places.get(&expr).copied();
        own.or_else(|| self.assembler.home(expr)).unwrap_or_default()
    }

    fn allocate(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.highest += 1;
            self.highest - 1
        })
    }

    /// Frees what is used here for the last time.
    fn release(&mut self, expr: Expr, position: usize) {
        let mut dying = self.operands(expr);
        dying.sort_unstable();
        dying.dedup();
        for operand in dying {
            if self.last_use.get(&operand) == Some(&position)
                && let Some(&register) = self.places.get(&operand)
            {
                self.free.push(register);
            }
        }
    }
}

fn unary_operation(function: Unary) -> Operation {
    match function {
        Unary::Negate => Operation::Negate,
        Unary::Sqrt => Operation::SquareRoot,
        Unary::Sin | Unary::Cos => Operation::SinCos,
        Unary::Tan => Operation::Tangent,
        Unary::Asin => Operation::ArcSine,
        Unary::Acos => Operation::ArcCosine,
        Unary::Atan => Operation::ArcTangent,
        Unary::Exp => Operation::Exponential,
        Unary::Log => Operation::Logarithm,
        Unary::Tanh => Operation::HyperbolicTangent,
        Unary::Abs => Operation::Absolute,
        Unary::Sign => Operation::Sign,
        Unary::Floor => Operation::Floor,
    }
}

fn binary_operation(function: Binary) -> Operation {
    match function {
        Binary::Add => Operation::Add,
        Binary::Subtract => Operation::Subtract,
        Binary::Multiply => Operation::Multiply,
        Binary::Divide => Operation::Divide,
        Binary::Power => Operation::Power,
        Binary::Atan2 => Operation::ArcTangent2,
        Binary::Min => Operation::Minimum,
        Binary::Max => Operation::Maximum,
        Binary::Less => Operation::Less,
        Binary::LessEqual => Operation::LessEqual,
    }
}
