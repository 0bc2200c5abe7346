//! Derivatives of a motion through what happens at an instant: the saltation matrix (Aizerman and Gantmakher 1958; Leine and Nijmeijer, *Dynamics and Bifurcations of Non-Smooth
//! Mechanical Systems*, 2004, chapter 7).
//!
//! Where y jumps to R(y, p, t) at a time t_e with g(y, p, t) = 0, that time changes by t_p = -(g_y S + g_p) / (g_y f- + g_t), and
//!
//! S+ = R_y (S- + f- t_p) + R_t t_p + R_p - f+ t_p.
//!
//! The direction of time, (1, f-), is carried through like those of the parameters: all derivatives come from the tapes of the model, along four directions at a time.

use thiserror::Error;

use super::instants::Happening;
use super::variational::Direction;
use crate::hybrid::contact::{Impact, TOUCHING, direction, is_closed};
use crate::hybrid::tick::Clock;
use crate::integrator::accelerations::Accelerations;
use crate::linalg::lane::{Lane, WIDTH, ZERO};
use crate::machine::{CANCELLED, Machine};
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::{Contact, Contacts, Role, Target, Write};
use crate::tape::Tape;

/// Why there are no derivatives behind what happens at an instant.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct PassageError(pub String);

/// A comparison whose excess is further from zero than this share of what it has been jumps there.
const JUMPED: f64 = 1e-6;

/// Derivatives of coordinates, rates and discrete variables: a column for each parameter.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    n: usize,
    discrete: usize,
    pub positions: Vec<f64>,
    pub rates: Vec<f64>,
    pub discrete_values: Vec<f64>,
}

/// What is differentiated: parameters, and values of inputs.
pub(super) struct Passage<'a> {
    pub model: &'a Model,
    pub parameters: &'a [Direction],
    pub tolerance: f64,
}

/// The registers at a state, with their tangents along four columns at a time.
struct Along {
    machine: Machine,
    /// One register file for every four columns.
    tangents: Vec<Vec<Lane>>,
    columns: usize,
}

impl Along {
    /// The value and the tangents of the results of a tape: for each result one for each column.
    fn run(&mut self, tape: &Tape) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut found = vec![Vec::with_capacity(self.columns); tape.results.len()];
        for lanes in &mut self.tangents {
            self.machine.run_tangents(tape, lanes);
            for (lane, &register) in found.iter_mut().zip(&tape.results) {
                lane.extend(lanes[register as usize]);
            }
        }
        found.iter_mut().for_each(|lane| lane.truncate(self.columns));
        let values = tape.results.iter().map(|&register| self.machine.registers()[register as usize]).collect();
        (values, found)
    }

    /// The value and the tangents of a register.
    fn register(&self, register: usize) -> (f64, Vec<f64>) {
        let tangents = self.tangents.iter().flat_map(|lanes| lanes[register]).take(self.columns);
        (self.machine.registers()[register], tangents.collect())
    }

    /// Sets the tangents of a register.
    fn set(&mut self, register: usize, tangents: &[f64]) {
        for (column, &tangent) in tangents.iter().enumerate() {
            self.tangents[column / WIDTH][register][column % WIDTH] = tangent;
        }
    }
}

impl Columns {
    /// `columns` of each, in order.
    pub fn new(n: usize, discrete: usize, [positions, rates, discrete_values]: [&[f64]; 3]) -> Self {
        let [positions, rates, discrete_values] = [positions, rates, discrete_values].map(<[f64]>::to_vec);
        Self { n, discrete, positions, rates, discrete_values }
    }

    /// Adds a column for the time.
    fn push(&mut self, rates: &[f64], accelerations: &[f64]) {
        self.positions.extend(rates);
        self.rates.extend(accelerations);
        self.discrete_values.extend(std::iter::repeat_n(0.0, self.discrete));
    }

    /// The changes at fixed time, of which the last column is taken: the instant moves by so much with each parameter, and what comes after it moves on like this.
    fn move_on(&mut self, moves: &[f64], [rates, accelerations]: [&[f64]; 2]) {
        let rest = vec![0.0; self.discrete];
        let of = |columns: &mut Vec<f64>, size: usize, after: &[f64]| {
            let time = columns.split_off(columns.len() - size);
            for (column, shift) in columns.chunks_mut(size.max(1)).zip(moves) {
                let changes = time.iter().zip(after).map(|(by_time, after)| (by_time - after) * shift);
                column.iter_mut().zip(changes).for_each(|(value, change)| *value += change);
            }
        };
        of(&mut self.positions, self.n, rates);
        of(&mut self.rates, self.n, accelerations);
        of(&mut self.discrete_values, self.discrete, &rest);
    }
}

impl Passage<'_> {
    /// Carries derivatives over everything that has happened at one instant; says how that changes with each parameter.
    ///
    /// # Errors
    /// Why there are none.
    pub fn pass(&self, happened: &[Happening], columns: &mut Columns) -> Result<Vec<f64>, PassageError> {
        let (Some(first), Some(last)) = (happened.first(), happened.last()) else { return Ok(Vec::new()) };
        let n = self.model.coordinates();
        let [before, after] = [&first.before, &last.after].map(|state| self.accelerations(state));
        columns.push(first.before.rates(), &before[..n]);
        let moves = self.moves(first, columns)?;
        if let Some(other) = happened[1..].iter().find(|happening| happening.is_first()) {
            return Err(PassageError(format!(
                "{} and {} happen at the same time",
                self.names(first),
                self.names(other)
            )));
        }
        for happening in happened {
            self.jump(happening, &moves, columns)?;
        }
        columns.move_on(&moves, [last.after.rates(), &after[..n]]);
        let all = [&columns.positions, &columns.rates, &columns.discrete_values];
        match all.iter().flat_map(|all| all.iter()).all(|value| value.is_finite()) {
            true => Ok(moves),
            false => Err(PassageError(format!("the motion after {} has no derivative", self.names(first)))),
        }
    }

    /// How discrete variables change that begin with what the scene says of them.
    ///
    /// # Errors
    /// What holds wherever it stands begins at rest, and slides or turns with other values.
    pub fn begin(&self, state: &State, columns: &mut Columns) -> Result<(), PassageError> {
        let before = columns.clone();
        let count = self.parameters.len();
        let (_, begin) = self.along(state, &before, false).run(&self.model.program().instants.begin);
        for (place, tangents) in begin.iter().enumerate() {
            (0..count).for_each(|column| columns.discrete_values[column * columns.discrete + place] = tangents[column]);
        }
        let contacts = self.model.program().instants.contacts();
        self.hold(state, &vec![true; contacts.len()], columns);
        self.check_rest(state, columns)
    }

    fn check_rest(&self, state: &State, columns: &Columns) -> Result<(), PassageError> {
        let program = self.model.program();
        let Some(data) = &program.instants.contacts else { return Ok(()) };
        let (values, changes) = self.along(state, columns, false).run(&data.rates);
        let largest = columns.rates.iter().fold(1.0, |most, change| maximum(most, change.abs()));
        let moves = |(index, contact): &(usize, &Contact)| {
            let scale = program.constraints[contact.constraint as usize].scale;
            let rests = contact.state.place.is_some() && values[*index].abs() <= CANCELLED * scale;
            rests && changes[*index].iter().any(|change| change.abs() > CANCELLED * scale * largest)
        };
        match data.all.iter().enumerate().find(moves) {
            None => Ok(()),
            Some((_, contact)) => Err(PassageError(format!(
                "`{}` starts at rest, but would start to slide for any other value; start in motion",
                contact.name
            ))),
        }
    }

    /// What is held wherever it stands is held where it stands in a state: the places of these change so that their gaps do not.
    fn hold(&self, state: &State, which: &[bool], columns: &mut Columns) {
        let Some(data) = &self.model.program().instants.contacts else { return };
        let places = data.all.iter().enumerate().filter(|(index, _)| which[*index]);
        let places = places.filter_map(|(index, contact)| Some((index, contact.state.place? as usize)));
        let places: Vec<(usize, usize)> = places.collect();
        if places.is_empty() {
            return;
        }
        let (_, gaps) = self.along(state, columns, false).run(&data.gaps);
        for (index, place) in places {
            for (column, gap) in gaps[index].iter().enumerate() {
                columns.discrete_values[column * columns.discrete + place] += gap;
            }
        }
    }

    /// What has happened, by its names.
    fn names(&self, happening: &Happening) -> String {
        let instants = &self.model.program().instants;
        let samplers =
            happening.ticks.iter().map(|&index| format!("a sample time of `{}`", instants.samplers[index].name));
        let events = instants.events.iter().map(|event| &event.name);
        let names: Vec<&String> = events.chain(instants.contacts().iter().map(|contact| &contact.name)).collect();
        let due = happening.due.iter().map(|&index| match names.get(index) {
            Some(name) => format!("`{name}`"),
            None => "a change of sign of a normal force".to_owned(),
        });
        let all: Vec<String> = samplers.chain(due).collect();
        if all.is_empty() { "the start".to_owned() } else { all.join(" and ") }
    }

    /// Accelerations, then reactions.
    fn accelerations(&self, state: &State) -> Vec<f64> {
        let mut machine = Machine::new(self.model);
        machine.load(self.model, state);
        // What has no value is found by its derivatives.
        let _ = Accelerations::new(self.model).evaluate(self.model, &mut machine);
        let layout = self.model.layout();
        machine.registers()[layout.accelerations()..layout.constants()].to_vec()
    }

    /// The registers at a state and their tangents; those of accelerations and reactions, if they are `solved` for.
    fn along(&self, state: &State, columns: &Columns, solved: bool) -> Along {
        let (model, layout, tapes) = (self.model, self.model.layout(), &self.model.program().tapes);
        let count = columns.positions.len() / columns.n.max(1);
        let mut machine = Machine::new(model);
        machine.load(model, state);
        if solved {
            machine.load_accelerations(model, &self.accelerations(state)[..columns.n]);
            machine.load_reactions(model, &self.accelerations(state)[columns.n..]);
        }
        let results = layout.accelerations()..layout.constants();
        let files = (0..count.div_ceil(WIDTH)).map(|_| vec![ZERO; model.program().registers as usize]);
        let mut along = Along { machine, tangents: files.collect(), columns: count };
        for column in 0..count {
            let lanes = &mut along.tangents[column / WIDTH];
            let mut set = |register: usize, tangent: f64| lanes[register][column % WIDTH] = tangent;
            match self.parameters.get(column) {
                Some(direction) => direction.changes(state.time()).for_each(|(register, change)| set(register, change)),
                None => {
                    set(layout.time(), 1.0);
                    for input in 0..model.program().inputs.len() {
                        let [_, rate, acceleration] = state.input_polynomial(input);
                        set(layout.inputs() + input, rate);
                        set(layout.input_rates() + input, acceleration);
                    }
                }
            }
            let lanes = |all: &[f64], size: usize| all[column * size..][..size].to_vec();
            let (n, discrete) = (columns.n, columns.discrete);
            let places = (layout.positions()..).zip(lanes(&columns.positions, n));
            let rates = (layout.rates()..).zip(lanes(&columns.rates, n));
            let discrete = (layout.discrete()..).zip(lanes(&columns.discrete_values, discrete));
            places.chain(rates).chain(discrete).for_each(|(register, tangent)| set(register, tangent));
        }
        for lanes in &mut along.tangents {
            along.machine.run_tangents(&tapes.parameters, lanes);
            if solved {
                along.machine.run_tangents(&tapes.acceleration, lanes);
                let found: Vec<Lane> =
                    tapes.acceleration.results.iter().map(|&register| lanes[register as usize]).collect();
                lanes[results.clone()].copy_from_slice(&found);
            }
        }
        along
    }

    /// How the instant moves with each parameter; the last column is the direction of time.
    fn moves(&self, happening: &Happening, columns: &Columns) -> Result<Vec<f64>, PassageError> {
        let still = vec![0.0; self.parameters.len()];
        if !happening.ticks.is_empty() {
            return self.ticks(happening, columns);
        }
        // What happens at the start, or where an input jumps, does so at that time.
        let (Some([length, reached]), Some(&event)) = (happening.seen, happening.due.first()) else { return Ok(still) };
        if happening.due.len() > 1 {
            return Err(PassageError(format!(
                "{} happen at the same time, and their order matters",
                self.names(happening)
            )));
        }
        let (value, mut changes) = self.excess(happening, columns, event);
        if value.abs() > JUMPED * reached + self.errors(event) {
            return Err(PassageError(format!(
                "{} happens at a discontinuity of its comparison",
                self.names(happening)
            )));
        }
        let speed = changes.pop().unwrap_or_default();
        // Written so that what is not a number grazes, too.
        let crosses = speed.abs() * length > self.tolerance.sqrt() * reached;
        if !crosses {
            return Err(PassageError(format!("{} is touched without being crossed", self.names(happening))));
        }
        Ok(changes.into_iter().map(|change| -change / speed).collect())
    }

    /// The rounding errors of a gap: the last flights of a series of bounces are hardly higher.
    fn errors(&self, event: usize) -> f64 {
        let program = self.model.program();
        let contact =
            event.checked_sub(program.instants.events.len()).and_then(|index| program.instants.contacts().get(index));
        let gap = contact.filter(|contact| contact.slip.is_none() && !contact.of_rate);
        gap.map_or(0.0, |contact| TOUCHING * program.constraints[contact.constraint as usize].scale)
    }

    /// By how much an event or a contact exceeds what it begins to hold at, with its changes.
    fn excess(&self, happening: &Happening, columns: &Columns, event: usize) -> (f64, Vec<f64>) {
        let instants = &self.model.program().instants;
        let mut along = self.along(&happening.before, columns, true);
        if event < instants.events.len() {
            let (values, changes) = along.run(&instants.sides);
            let [one, other] = [2 * event, 2 * event + 1];
            let change = changes[one].iter().zip(&changes[other]).map(|(a, b)| a - b).collect();
            return (values[one] - values[other], change);
        }
        let index = event - instants.events.len();
        let Some(data) = &instants.contacts else { return (0.0, vec![f64::NAN]) };
        let of = |(values, changes): (Vec<f64>, Vec<Vec<f64>>), place: usize, factor: f64| {
            (factor * values[place], changes[place].iter().map(|change| factor * change).collect())
        };
        let Some(contact) = data.all.get(index) else {
            // It changes sign.
            return of(along.run(&data.pressing), index - data.all.len(), 1.0);
        };
        let reactions = self.model.layout().reactions();
        let (reaction, closed) = (reactions + contact.constraint as usize, happening.closed(self.model)[0][index]);
        match &contact.slip {
            None if closed => along.register(reaction),
            None => of(along.run(if contact.of_rate { &data.rates } else { &data.gaps }), index, -1.0),
            Some(_) if !closed => of(along.run(&data.rates), index, -happening.directions(self.model)[0][index]),
            Some(slip) => {
                let share = of(along.run(&data.restitutions), index, 1.0);
                let level = along.register(reactions + slip.level as usize);
                let level = product(&share, &level);
                let (force, squares) = (along.register(reaction), product(&level, &level));
                let (square, changes) = product(&force, &force);
                (square - squares.0, changes.iter().zip(&squares.1).map(|(one, other)| one - other).collect())
            }
        }
    }

    /// How the time of a tick moves with each parameter: that of offset + k period.
    fn ticks(&self, happening: &Happening, columns: &Columns) -> Result<Vec<f64>, PassageError> {
        let (values, changes) =
            self.along(&happening.before, columns, false).run(&self.model.program().instants.clocks);
        let count = self.parameters.len();
        let moved = |&sampler: &usize| -> Vec<f64> {
            let [period, offset] = [2 * sampler, 2 * sampler + 1];
            let number = Clock { period: values[period], offset: values[offset] }.number(happening.before.time());
            (0..count).map(|column| changes[offset][column] + number * changes[period][column]).collect()
        };
        let all: Vec<Vec<f64>> = happening.ticks.iter().map(moved).collect();
        let Some((first, others)) = all.split_first() else { return Ok(vec![0.0; count]) };
        let is_same = |other: &Vec<f64>| {
            first.iter().zip(other).all(|(one, other)| (one - other).abs() <= CANCELLED * (one.abs() + other.abs()))
        };
        match others.iter().all(is_same) {
            true => Ok(first.clone()),
            false => Err(PassageError(format!("{} coincide for these values only", self.names(happening)))),
        }
    }

    /// What happens to the state itself.
    fn jump(&self, happening: &Happening, moves: &[f64], columns: &mut Columns) -> Result<(), PassageError> {
        let instants = &self.model.program().instants;
        let ticking = happening.ticks.iter().flat_map(|&index| &instants.samplers[index].writes);
        let events =
            happening.due.iter().filter_map(|&index| instants.events.get(index)).flat_map(|event| &event.writes);
        let writes: Vec<Write> = ticking.chain(events).copied().collect();
        let joining = happening.joining(self.model).into_iter().filter(|(_, joins)| *joins);
        let joining: Vec<usize> = joining.map(|(row, _)| row).collect();
        let written = match writes.is_empty() {
            true => Vec::new(),
            false => self.along(&happening.before, columns, true).run(&instants.written).1,
        };
        if !joining.is_empty() {
            // Impulses along what begins to hold follow from what has been written.
            self.write(&writes, &written, columns);
        }
        if let Some(data) = &instants.contacts {
            self.check_hits(happening, data)?;
            let mut state = happening.before.clone();
            for impact in &happening.impacts {
                let found = self.strike(&mut state, (impact, data), (happening, &joining), columns);
                self.check_modes([&happening.before, &state], (impact, data), found, (columns, moves))?;
            }
        }
        let [before, after] = happening.closed(self.model);
        let caught: Vec<bool> = before.iter().zip(after).map(|(before, after)| after && !before).collect();
        self.hold(&happening.before, &caught, columns);
        if joining.is_empty() {
            self.write(&writes, &written, columns);
        }
        Ok(())
    }

    /// What is written changes like this.
    fn write(&self, writes: &[Write], written: &[Vec<f64>], columns: &mut Columns) {
        for write in writes {
            for (column, tangent) in written[write.result as usize].iter().enumerate() {
                match self.model.program().target(*write) {
                    Target::Discrete(place) => columns.discrete_values[column * columns.discrete + place] = *tangent,
                    Target::State(state) => {
                        columns.rates[column * columns.n + self.model.mechanical() + state] = *tangent;
                    }
                }
            }
        }
    }

    /// Looks whether at most one contact hits, and nothing else happens by itself at that time.
    fn check_hits(&self, happening: &Happening, data: &Contacts) -> Result<(), PassageError> {
        let events = self.model.program().instants.events.len();
        let name = |&index: &usize| format!("`{}`", data.all[index].name);
        match happening.hit.as_slice() {
            [] => Ok(()),
            [index] if happening.due == [index + events] => Ok(()),
            [index] => Err(PassageError(format!(
                "{} and an impact of {} happen at the same time",
                self.names(happening),
                name(index)
            ))),
            hit => {
                let names: Vec<String> = hit.iter().map(name).collect();
                Err(PassageError(format!("{} hit at the same time, and their order matters", names.join(" and "))))
            }
        }
    }

    /// An impact in the mode that has been found for it: v+ = v- - M^-1 J^T (J M^-1 J^T)^-1 (J v- - what is requested), with the friction of what slips. Contacts that hit leave with their share of the speed,
    /// joints that engage have no rate, and what an event sets has that one. `state` is the one before it, whose rates become those after it. Gives the changes of rates, then the multipliers, with their changes.
    fn strike(
        &self,
        state: &mut State,
        (impact, data): (&Impact, &Contacts),
        (happening, joining): (&Happening, &[usize]),
        columns: &mut Columns,
    ) -> (Vec<f64>, Vec<Vec<f64>>) {
        let (model, layout, n) = (self.model, self.model.layout(), columns.n);
        state.discrete_mut().copy_from_slice(&impact.discrete);
        let mut along = self.along(state, columns, false);
        let ((rates, rate_changes), (shares, share_changes)) = (along.run(&data.rates), along.run(&data.restitutions));
        let mut requested = vec![0.0; model.program().constraints.len()];
        for (place, contact) in data.all.iter().enumerate().filter(|(place, _)| is_closed(data, state, *place)) {
            let row = contact.constraint as usize;
            let share = if impact.rebounds[place] { shares[place] } else { 0.0 };
            requested[row] = (1.0 + share) * rates[place];
            let by =
                |column: usize| if impact.rebounds[place] { share_changes[place][column] * rates[place] } else { 0.0 };
            let changes = rate_changes[place].iter().enumerate();
            let changes: Vec<f64> = changes.map(|(column, rate)| (1.0 + share) * rate + by(column)).collect();
            along.set(layout.reactions() + row, &changes);
        }
        let joined = self.request_joined(joining, &mut along, &mut requested);
        along.machine.load_reactions(model, &requested);
        let (values, changes) = along.run(&data.impact);
        for column in 0..along.columns {
            (0..n).for_each(|place| columns.rates[column * n + place] += changes[place][column]);
        }
        state.rates_mut().iter_mut().zip(&values).for_each(|(rate, change)| *rate += change);
        for &index in &happening.hit {
            let (row, place) = (data.all[index].constraint as usize, data.all[index].state.impulse as usize);
            for column in 0..along.columns {
                columns.discrete_values[column * columns.discrete + place] = -changes[n + row][column];
            }
        }
        self.keep_joined(joining, &joined, (&values, &changes), columns);
        (values, changes)
    }

    /// Requests the rates of what begins to hold; gives their values and changes before the impact.
    fn request_joined(&self, joining: &[usize], along: &mut Along, requested: &mut [f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let (program, layout) = (self.model.program(), self.model.layout());
        if joining.is_empty() {
            return Default::default();
        }
        let (rates, rate_changes) = along.run(&program.tapes.constraint_rate);
        for &row in joining {
            let (set, set_changes) = match program.constraints[row].role {
                Role::Set { value, .. } => along.register(layout.discrete() + value as usize),
                _ => (0.0, vec![0.0; along.columns]),
            };
            requested[row] = rates[row] + set;
            let changes: Vec<f64> = rate_changes[row].iter().zip(&set_changes).map(|(rate, set)| rate + set).collect();
            along.set(layout.reactions() + row, &changes);
        }
        (rates, rate_changes)
    }

    /// The impulses of what has begun to hold, and the energy that they take.
    fn keep_joined(
        &self,
        joining: &[usize],
        (rates, rate_changes): &(Vec<f64>, Vec<Vec<f64>>),
        (impulses, changes): (&[f64], &[Vec<f64>]),
        columns: &mut Columns,
    ) {
        let (program, n) = (self.model.program(), columns.n);
        let count = columns.discrete;
        for (column, discrete) in columns.discrete_values.chunks_mut(count.max(1)).enumerate() {
            for &row in joining {
                if let Role::Engaging { lost, .. } = program.constraints[row].role {
                    discrete[lost as usize] = 0.0;
                }
            }
            for &row in joining {
                let change = changes[n + row][column];
                match program.constraints[row].role {
                    Role::Engaging { impulse, lost } => {
                        let of_rate = impulses[n + row] * rate_changes[row][column];
                        discrete[impulse as usize] = change;
                        discrete[lost as usize] += 0.5 * (change * rates[row] + of_rate);
                    }
                    Role::Set { impulse, .. } => discrete[impulse as usize] = change,
                    Role::Imposed | Role::Repeating | Role::LeftOut | Role::Contact => {}
                }
            }
        }
    }

    /// Looks whether the mode of an impact is the same for other values: what is closed presses, what is open moves apart, and friction is within its limit or slides, unless that does not depend on the values.
    fn check_modes(
        &self,
        [before, state]: [&State; 2],
        (impact, data): (&Impact, &Contacts),
        (values, changes): (Vec<f64>, Vec<Vec<f64>>),
        (columns, moves): (&Columns, &[f64]),
    ) -> Result<(), PassageError> {
        let n = columns.n;
        let after = self.along(state, columns, false).run(&data.rates);
        let largest = |all: &mut dyn Iterator<Item = &f64>| all.fold(0.0, |most, value| maximum(most, value.abs()));
        let impulses = [largest(&mut values[n..].iter()), largest(&mut changes[n..].iter().flatten())];
        let rates = [largest(&mut state.rates().iter()), largest(&mut columns.rates.iter())];
        // Where nothing moves before nor after it, all impulses and rates are rounding errors, and none of them is clear of the others.
        let rests = |state: &State| {
            let mut rates = state.rates().iter().zip(&self.model.program().coordinates);
            rates.all(|(rate, coordinate)| rate.abs() <= TOUCHING * coordinate.scale)
        };
        let is_still = rests(before) && rests(state);
        let decided = |(index, contact): &(usize, &Contact)| {
            let multiplier = |row: u32| (values[n + row as usize], changes[n + row as usize].as_slice());
            let rate = (after.0[*index], after.1[*index].as_slice());
            let (closed, way) = (is_closed(data, state, *index), direction(data, state, *index));
            let rubs = |on: Option<u32>| on.is_none_or(|on| is_closed(data, state, on as usize));
            let (margin, sizes) = match &contact.slip {
                None if closed => (sum([-1.0, 0.0], [multiplier(contact.constraint); 2]), impulses),
                None => (sum([1.0, 0.0], [rate; 2]), rates),
                Some(slip) if closed => {
                    let force = multiplier(contact.constraint);
                    (sum([1.0, -force.0.signum()], [multiplier(slip.level), force]), impulses)
                }
                // Other parts hold what neither sticks nor slides.
                Some(slip) if way == 0.0 || !rubs(slip.on) => return true,
                Some(_) => (sum([way, 0.0], [rate; 2]), rates),
            };
            let is_clear = !is_still && margin.0.abs() > CANCELLED * sizes[0];
            // At the time to which the instant moves.
            let by_time = margin.1.last().copied().unwrap_or_default();
            let mut changes = margin.1.iter().zip(moves).map(|(change, shift)| change + by_time * shift);
            is_clear || changes.all(|change| change.abs() <= CANCELLED * sizes[1])
        };
        let mut undecided = data.all.iter().enumerate().filter(|(index, _)| impact.undecided[*index]);
        match undecided.find(|contact| !decided(contact)) {
            None => Ok(()),
            Some((_, contact)) => Err(PassageError(format!(
                "`{}` takes no impulse in an impact, and would for other values: derivatives differ on both sides",
                contact.name
            ))),
        }
    }
}

/// A linear combination of two values, with its changes.
fn sum([one, other]: [f64; 2], [(a, by_a), (b, by_b)]: [(f64, &[f64]); 2]) -> (f64, Vec<f64>) {
    (one * a + other * b, by_a.iter().zip(by_b).map(|(a, b)| one * a + other * b).collect())
}

/// The product of two values, with its changes.
fn product((one, changes): &(f64, Vec<f64>), (other, others): &(f64, Vec<f64>)) -> (f64, Vec<f64>) {
    let both = changes.iter().zip(others).map(|(change, by)| change * other + one * by);
    (one * other, both.collect())
}
