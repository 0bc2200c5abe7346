//! Which contacts and frictions have to be decided together: those of parts that act on each other.
//!
//! A mode of eight separate pendulums is eight modes of one each. Trials multiply within an island, a set of parts that share a loop equation, a load, a friction or something that touches, and add up over
//! islands. What acts on what stands in the tapes: a result belongs to all coordinates that it is made of, where a contact that is open makes products of zero. So parts are joined once for all, when the
//! program is known; what touches joins them for an instant.

use super::contact::{ContactValues, Place, is_closed};
use super::modes::Choices;
use crate::failure::Failure;
use crate::machine::CANCELLED;
use crate::math::maximum;
use crate::model::Model;
use crate::program::{Contact, Contacts};
use crate::tape::{Operation, Tape};

/// What a register is made of.
#[derive(Clone, Copy, PartialEq)]
enum Made {
    /// Zero as long as everything that may touch is open.
    Zero,
    /// Numbers, the time, and what changes at instants only.
    Known,
    /// This part of the mechanism, and those it is joined with.
    Of(u32),
}

/// What is decided island by island.
#[derive(Clone, Debug)]
pub(crate) struct Division {
    islands: Option<Islands>,
    /// True while an island is decided.
    pub is_part: bool,
    /// All that is undecided.
    whole: Choices,
    /// True for what touches or rubs.
    touches: Vec<bool>,
    /// The islands of what is undecided, in its order.
    order: Vec<u32>,
    /// What each contact and friction has been found to do in its island.
    found: Vec<f64>,
    /// The discrete variables with everything that is undecided open, and with what has been decided.
    open: Vec<f64>,
    decided: Vec<f64>,
}

impl Division {
    /// Storage for so many choices.
    pub fn new(model: &Model, choices: usize) -> Self {
        let (discrete, count) = (model.program().discrete.len(), model.program().instants.contacts().len());
        Self {
            islands: Islands::new(model),
            is_part: false,
            whole: Choices::with_capacity(choices),
            touches: vec![false; count],
            order: Vec::with_capacity(count),
            found: vec![0.0; count],
            open: vec![0.0; discrete],
            decided: vec![0.0; discrete],
        }
    }
}

impl ContactValues {
    /// Decides what is undecided, one island after the other, with all others open: they act on nothing there. `decide` leaves the mode of what it has been given and what it does in it, which `moves`
    /// reads, and `confirm` says whether all modes together are one. If they are not, or anything then moves otherwise, all are decided together. False if there is no such mode.
    pub(super) fn by_islands(
        &mut self,
        context: &mut Place,
        decide: impl Fn(&mut Self, &mut Place) -> Result<bool, Failure>,
        confirm: impl Fn(&mut Self, &mut Place) -> bool,
        moves: impl Fn(&Self, usize) -> f64,
    ) -> Result<bool, Failure> {
        if !self.find_islands(context) {
            return decide(self, context);
        }
        std::mem::swap(&mut self.choices, &mut self.division.whole);
        self.division.is_part = true;
        let decided = self.decide_islands(context, &decide, &moves);
        self.division.is_part = false;
        std::mem::swap(&mut self.choices, &mut self.division.whole);
        if !decided? {
            return Ok(false);
        }
        context.state.discrete_mut().copy_from_slice(&self.division.decided);
        if confirm(self, context) && self.moves_as_found(&moves) { Ok(true) } else { decide(self, context) }
    }

    /// True if everything that has been decided moves as it does in its island.
    fn moves_as_found(&self, moves: impl Fn(&Self, usize) -> f64) -> bool {
        let all = || self.choices.concerned().map(|index| (moves(self, index), self.division.found[index]));
        let size = all().fold(0.0, |most, (value, _)| maximum(most, value.abs()));
        all().all(|(value, found)| (value - found).abs() <= CANCELLED * size)
    }

    /// Finds the islands of what is undecided; false if it is one.
    fn find_islands(&mut self, context: &Place) -> bool {
        let Some(islands) = self.division.islands.as_mut().filter(|_| !self.joining.any) else { return false };
        for (index, touches) in self.division.touches.iter_mut().enumerate() {
            *touches = is_closed(context.data, context.state, index) || context.direction(index) != 0.0;
        }
        self.choices.concerned().for_each(|index| self.division.touches[index] = true);
        islands.find(|index| self.division.touches[index]);
        self.division.order.clear();
        for index in self.choices.owners() {
            let island = islands.of(index);
            if !self.division.order.contains(&island) {
                self.division.order.push(island);
            }
        }
        self.division.order.len() > 1
    }

    fn decide_islands(
        &mut self,
        context: &mut Place,
        decide: impl Fn(&mut Self, &mut Place) -> Result<bool, Failure>,
        moves: impl Fn(&Self, usize) -> f64,
    ) -> Result<bool, Failure> {
        let discrete = context.state.discrete_mut();
        self.division.whole.open(context.data, discrete);
        self.division.open.copy_from_slice(discrete);
        self.division.decided.copy_from_slice(discrete);
        for place in 0..self.division.order.len() {
            let island = self.division.order[place];
            let Division { islands, whole, .. } = &self.division;
            self.choices.take_part(whole, |index| islands.as_ref().is_some_and(|all| all.of(index) == island));
            context.state.discrete_mut().copy_from_slice(&self.division.open);
            if !decide(self, context)? {
                return Ok(false);
            }
            self.choices.copy(context.data, context.state.discrete(), &mut self.division.decided);
            for index in self.choices.concerned() {
                self.division.found[index] = moves(self, index);
            }
        }
        Ok(true)
    }

    /// True for what is being decided, and for all if there is one island.
    pub(super) fn is_concerned(&self, index: usize) -> bool {
        !self.division.is_part || self.choices.owners().any(|other| other == index)
    }
}

/// Parts of a mechanism, and which of them act on each other.
#[derive(Clone, Debug)]
pub(crate) struct Islands {
    /// Of each coordinate, then each multiplier, then each contact and friction: another one of its island, or itself. What is joined for all time, and at the present instant.
    always: Vec<u32>,
    now: Vec<u32>,
    /// The place of the first contact.
    contacts: usize,
    /// Contacts with parts that they join while they touch.
    links: Vec<[u32; 2]>,
}

impl Islands {
    /// Those of a model; none if all parts act on each other, however they touch.
    pub fn new(model: &Model) -> Option<Self> {
        let program = model.program();
        let data = program.instants.contacts.as_ref().filter(|data| data.all.len() > 1)?;
        let contacts = program.coordinates.len() + program.constraints.len();
        let mut parts = Parts { model, data, contacts, joined: (0..(contacts + data.all.len()) as u32).collect() };
        parts.join_for_all_time();
        let links = parts.links();
        let mut islands = Self { now: parts.joined.clone(), always: parts.joined, contacts, links };
        islands.find(|_| true);
        let first = islands.of(0);
        (1..data.all.len()).any(|index| islands.of(index) != first).then_some(islands)
    }

    /// The islands while these contacts touch, and these frictions rub.
    pub fn find(&mut self, touches: impl Fn(usize) -> bool) {
        self.now.copy_from_slice(&self.always);
        for &[contact, part] in &self.links {
            if touches(contact as usize) {
                join(&mut self.now, self.contacts as u32 + contact, part);
            }
        }
    }

    /// The island of a contact, by one of its parts.
    pub fn of(&self, contact: usize) -> u32 {
        root(&self.now, (self.contacts + contact) as u32)
    }
}

/// The parts of a model while they are joined for all time.
struct Parts<'a> {
    model: &'a Model,
    data: &'a Contacts,
    contacts: usize,
    joined: Vec<u32>,
}

impl Parts<'_> {
    /// Joins what acts on each other with all contacts open: coordinates with what their accelerations read, frictions with what they brake, and whatever a loop equation ties.
    fn join_for_all_time(&mut self) {
        let (program, layout) = (self.model.program(), self.model.layout());
        let mut registers = self.registers(None);
        for first in [layout.positions(), layout.rates()] {
            (0..program.coordinates.len()).for_each(|part| registers[first + part] = Made::Of(part as u32));
        }
        for (index, contact) in self.data.all.iter().enumerate().filter(|(index, _)| !self.may_open(*index)) {
            let friction = Made::Of((self.contacts + index) as u32);
            flags(contact).for_each(|place| registers[layout.discrete() + place as usize] = friction);
        }
        let made = self.results(&program.tapes.acceleration, registers);
        for (part, made) in made[..self.contacts].iter().enumerate() {
            self.join(Made::Of(part as u32), *made);
        }
        let opens: Vec<u32> = (0..self.data.all.len())
            .filter(|&index| self.may_open(index))
            .map(|index| self.data.all[index].constraint)
            .collect();
        for row in (0..program.constraints.len()).filter(|row| !opens.contains(&(*row as u32))) {
            let tape = &program.tapes.constraint_rate;
            let multiplier = Made::Of((program.coordinates.len() + row) as u32);
            parts_of(self.model, tape, tape.results[row])
                .into_iter()
                .for_each(|part| self.join(multiplier, Made::Of(part as u32)));
        }
    }

    /// True for a contact, and for what rubs in one.
    fn may_open(&self, index: usize) -> bool {
        self.data.all[index].slip.as_ref().is_none_or(|slip| slip.on.is_some())
    }

    /// Registers in which everything that may open is open, but one contact or friction and what it rubs on.
    fn registers(&self, closed: Option<usize>) -> Vec<Made> {
        let mut registers = vec![Made::Known; register_count(self.model)];
        let on = closed.and_then(|index| self.data.all[index].slip.as_ref()?.on);
        for index in (0..self.data.all.len()).filter(|&index| self.may_open(index)) {
            if Some(index) != closed && Some(index as u32) != on {
                let first = self.model.layout().discrete();
                flags(&self.data.all[index]).for_each(|place| registers[first + place as usize] = Made::Zero);
            }
        }
        registers
    }

    fn join(&mut self, one: Made, other: Made) {
        if let (Made::Of(one), Made::Of(other)) = (one, other) {
            join(&mut self.joined, one, other);
        }
    }

    /// Which parts the results of a tape are made of, given those of what it reads.
    fn results(&mut self, tape: &Tape, mut registers: Vec<Made>) -> Vec<Made> {
        for tape in [&self.model.program().tapes.parameters, tape] {
            for instruction in tape.instructions() {
                let operands = [instruction.a, instruction.b, instruction.c].map(|place| registers[place as usize]);
                let made = self.made(instruction.operation, operands);
                registers[instruction.target as usize] = made;
                if instruction.operation == Operation::SinCos {
                    registers[instruction.c as usize] = made;
                }
            }
        }
        tape.results.iter().map(|&register| registers[register as usize]).collect()
    }

    /// What each contact and friction joins while it touches or rubs: the parts that its gap, its rate, its coefficients and what presses it are made of, and those that its impulse moves.
    fn links(&mut self) -> Vec<[u32; 2]> {
        let (n, data, layout) = (self.model.coordinates(), self.data, self.model.layout());
        let mut links = Vec::new();
        for (index, contact) in data.all.iter().enumerate() {
            let row = n + contact.constraint as usize;
            let mut parts = vec![row];
            for tape in [&data.gaps, &data.rates, &data.accelerations, &data.restitutions] {
                parts.extend(parts_of(self.model, tape, tape.results[index]));
            }
            if let Some(slip) = &contact.slip {
                parts.push(n + slip.level as usize);
                parts.extend(slip.on.map(|on| self.contacts + on as usize));
                let sums = data.pressing.results[slip.sums as usize..].iter().take(contact.state.signs.len());
                sums.for_each(|&sum| parts.extend(parts_of(self.model, &data.pressing, sum)));
            }
            let mut registers = self.registers(Some(index));
            registers[layout.reactions() + contact.constraint as usize] = Made::Of(row as u32);
            let moved = self.results(&data.impact, registers);
            parts.extend((0..n).filter(|&part| matches!(moved[part], Made::Of(_))));
            links.extend(parts.into_iter().map(|part| [index as u32, part as u32]));
        }
        links
    }

    /// What the result of an operation is made of; its operands are of one part from now on.
    fn made(&mut self, operation: Operation, [a, b, c]: [Made; 3]) -> Made {
        use Operation::{
            Absolute, Add, Copy, Divide, Multiply, MultiplyAdd, MultiplySubtract, Negate, SquareRoot, Subtract,
            SubtractProduct,
        };
        match operation {
            Multiply => self.product(a, b),
            Divide if a == Made::Zero => Made::Zero,
            Add | Subtract => self.sum(a, b),
            Negate | SquareRoot | Absolute | Copy => a,
            MultiplyAdd | MultiplySubtract | SubtractProduct => {
                let product = self.product(a, b);
                self.sum(product, c)
            }
            _ => [a, b, c][..operation.operands()].iter().fold(Made::Known, |made, &operand| self.sum(made, operand)),
        }
    }

    fn product(&mut self, a: Made, b: Made) -> Made {
        if a == Made::Zero || b == Made::Zero { Made::Zero } else { self.sum(a, b) }
    }

    fn sum(&mut self, a: Made, b: Made) -> Made {
        self.join(a, b);
        match (a, b) {
            (Made::Zero, other) | (other, Made::Zero) => other,
            (Made::Known, other) | (other, Made::Known) => other,
            (one, _) => one,
        }
    }
}

/// The discrete variables that are zero while a contact is open, or a friction is none.
fn flags(contact: &Contact) -> impl Iterator<Item = u32> {
    [Some(contact.state.closed), contact.state.direction].into_iter().flatten()
}

/// The parts of which a result of a tape is made: what is read on the way back from it.
fn parts_of(model: &Model, tape: &Tape, result: u32) -> Vec<usize> {
    let (layout, n) = (model.layout(), model.coordinates());
    let mut needed = vec![false; register_count(model)];
    needed[result as usize] = true;
    for instruction in tape.instructions().iter().rev() {
        let is_second = instruction.operation == Operation::SinCos;
        let targets = [Some(instruction.target), is_second.then_some(instruction.c)];
        let is_needed = targets.into_iter().flatten().any(|target| std::mem::take(&mut needed[target as usize]));
        if is_needed {
            let operands = [instruction.a, instruction.b, instruction.c];
            operands[..instruction.operation.operands()].iter().for_each(|&operand| needed[operand as usize] = true);
        }
    }
    let read = |first: usize, count: usize| (0..count).map(move |place| (first + place, place));
    let motion =
        [layout.positions(), layout.rates(), layout.accelerations()].into_iter().flat_map(|first| read(first, n));
    let reactions =
        read(layout.reactions(), model.program().constraints.len()).map(|(register, row)| (register, n + row));
    motion.chain(reactions).filter(|(register, _)| needed[*register]).map(|(_, part)| part).collect()
}

fn register_count(model: &Model) -> usize {
    (model.program().registers as usize).max(model.layout().constants())
}

/// Joins the islands of two parts.
fn join(joined: &mut [u32], one: u32, other: u32) {
    let (one, other) = (root(joined, one), root(joined, other));
    joined[one.max(other) as usize] = one.min(other);
}

/// The first part of an island.
fn root(joined: &[u32], mut part: u32) -> u32 {
    while joined[part as usize] != part {
        part = joined[part as usize];
    }
    part
}
