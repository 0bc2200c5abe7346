//! The first variation of the equations: every derivative that statics and small motions need, once as expressions, then
//! as numbers at as many points as wanted.

use std::ops::Range;

use cotree::equations::{Equations, Feedback, Level, MotionVariable, Pressing};
use cotree::expr::{Expr, Order, Symbol, Unary, indicators};
use cotree::formulate::Formulated;
use cotree::laws::motion_indicators;
use cotree::model::Output;
use cotree::network::{ElementId, Force};
use cotree::program::{Conditions, conditions};
use nalgebra::{DMatrix, DVector};

use super::{AnalysisFailure, OperatingPoint, saddle};

/// Ends no further apart than this share of the mechanism's length are together: an equilibrium is found to about as much.
const TOGETHER: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowBlock {
    /// Phi of the independent loop equations.
    Loops,
    /// Phi_t + Phi_q v of the same.
    Rates,
    /// M a + Phi_q^T lambda - Q; then z' - g of the states.
    Motion,
    /// Phi_q a - gamma.
    Accelerations,
    /// s - F - mu p(a, lambda) of what slides; then f - law of loads that read accelerations or reactions.
    Levels,
    Outputs,
    /// Known initial positions less what they should be.
    Starts,
    /// The same of rates.
    StartRates,
    /// Phi of the loop equations that repeat others.
    Repeated,
    /// Switching functions of the laws.
    Switches,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColumnBlock {
    Positions,
    Rates,
    Accelerations,
    /// lambda of the independent loop equations.
    Reactions,
    /// s of what slides, then f of loads that read accelerations or reactions.
    Levels,
    Signals,
}

#[derive(Clone, Debug)]
pub struct Variation {
    roots: Vec<Expr>,
    columns: Vec<Symbol>,
    /// (row, column) of each derivative that is not identically zero.
    places: Vec<(usize, usize)>,
    derivatives: Vec<Expr>,
    /// Where each kind of equation is among the roots.
    rows: Vec<(RowBlock, Range<usize>)>,
    coordinates: usize,
    /// The independent loop equations.
    active: Vec<usize>,
    /// Of each of them, what is 1 while it holds: those of what is held on one side only.
    masks: Vec<Option<Expr>>,
    /// The levels of what rubs.
    levels: Vec<Rubbing>,
    /// Loads that read accelerations or reactions; they stand after the levels, as one more kind of them.
    loads: Vec<Feedback>,
    /// Loads without a limit where their ends come together, with the squares of their lengths.
    lines: Vec<(String, Expr)>,
    /// Whose signs choose the pieces of the laws in the equations of motion.
    switches: Vec<Expr>,
    /// The names of the outputs, if they are differentiated.
    outputs: Vec<String>,
}

/// What rubs: a force of direction x level while it slides.
#[derive(Clone, Debug)]
pub(super) struct Rubbing {
    /// Its place among what the mechanism holds.
    pub place: usize,
    pub level: Level,
    /// 1 or -1 while it slides that way, else 0.
    direction: Expr,
}

/// What counts at a point.
#[derive(Clone, Debug)]
struct ActiveRows {
    /// Places among the independent loop equations of those that hold.
    loops: Vec<usize>,
    /// Places among the levels of those that slide, and of the loads after them.
    levels: Vec<usize>,
}

impl Variation {
    /// Differentiates the equations and the outputs of a mechanism by inputs, followers and discrete variables that are not those of modes.
    pub fn new(formulated: &mut Formulated) -> Self {
        let levels = acting(&mut formulated.equations);
        let roots = roots(formulated, &active(formulated), &levels);
        let symbols = formulated.equations.system.arena.symbols(roots.iter().flat_map(|(_, roots)| roots).copied());
        let mechanism = formulated.equations.system.mechanism.clone();
        let signals = symbols.into_iter().filter(|symbol| match *symbol {
            Symbol::Input(..) | Symbol::Follower(..) => true,
            Symbol::Discrete(index) => !mechanism.discrete[index].is_of_mode(),
            Symbol::Time | Symbol::Parameter(_) | Symbol::Coordinate(..) | Symbol::State(..) => false,
            Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => false,
        });
        Variation::by(formulated, signals.collect())
    }

    /// Derivatives by these symbols.
    pub(super) fn by(formulated: &mut Formulated, signals: Vec<Symbol>) -> Self {
        let active = active(formulated);
        let levels = acting(&mut formulated.equations);
        let roots = roots(formulated, &active, &levels);
        let outputs = names(&formulated.outputs);
        Variation { outputs, ..Variation::of(&mut formulated.equations, (active, levels), roots, signals) }
    }

    /// Of the loops, the start and the switching functions only.
    pub(super) fn of_constraints(formulated: &mut Formulated, signals: Vec<Symbol>) -> Self {
        let active = active(formulated);
        let equations = &mut formulated.equations;
        let mut roots = loops(equations, &active);
        for (row, order) in [(RowBlock::Starts, Order::Position), (RowBlock::StartRates, Order::Velocity)] {
            roots.push((row, starts(equations, order)));
        }
        roots.push((RowBlock::Repeated, repeated(equations, &active)));
        let switches = motion_indicators(equations, &formulated.lowered.solved);
        roots.push((RowBlock::Switches, switches));
        Variation::of(equations, (active, (Vec::new(), Vec::new())), roots, signals)
    }

    fn of(
        equations: &mut Equations,
        (active, (levels, loads)): (Vec<usize>, Acting),
        groups: Vec<(RowBlock, Vec<Expr>)>,
        signals: Vec<Symbol>,
    ) -> Self {
        let layout = equations.motion_layout();
        let arena = &mut equations.system.arena;
        let rows = levels.iter().map(|level| level.level.row).chain(loads.iter().map(|load| load.row));
        let columns: Vec<Symbol> = (Order::ALL.into_iter())
            .flat_map(|order| (0..layout.count()).map(move |index| layout.variable(index).symbol(order)))
            .chain(active.iter().copied().chain(rows).map(Symbol::Reaction))
            .chain(signals)
            .collect();
        let forces = groups.iter().filter(|(row, _)| *row == RowBlock::Motion).flat_map(|(_, group)| group);
        let switches = indicators(arena, &forces.copied().collect::<Vec<Expr>>());
        let (mut roots, mut rows) = (Vec::new(), Vec::new());
        for (row, group) in groups {
            rows.push((row, roots.len()..roots.len() + group.len()));
            roots.extend(group);
        }
        let (mut places, mut derivatives) = (Vec::new(), Vec::new());
        for (column, &symbol) in columns.iter().enumerate() {
            for (row, derivative) in arena.derivatives(&roots, symbol).into_iter().enumerate() {
                if derivative != Expr::ZERO {
                    places.push((row, column));
                    derivatives.push(derivative);
                }
            }
        }
        let lines = lines(equations);
        let mask = |&row: &usize| equations.constraints[row].contact().map(|gap| gap.closed);
        let masks = active.iter().map(mask).collect();
        let outputs = Vec::new();
        Variation {
            roots,
            columns,
            places,
            derivatives,
            rows,
            coordinates: layout.count(),
            active,
            masks,
            levels,
            loads,
            lines,
            switches,
            outputs,
        }
    }

    /// What counts at a point: what is open does not, nor does the level of what sticks.
    fn holding(&self, equations: &Equations, point: &OperatingPoint) -> ActiveRows {
        let counts = |mask: Expr| equations.system.arena.evaluate(&[mask], point)[0] != 0.0;
        let loops = (0..self.active.len()).filter(|&place| self.masks[place].is_none_or(counts)).collect();
        let slides = (0..self.levels.len()).filter(|&place| counts(self.levels[place].direction));
        let levels = slides.chain(self.levels.len()..self.levels.len() + self.loads.len()).collect();
        ActiveRows { loops, levels }
    }

    /// What rubs.
    pub(super) fn rubbing(&self) -> &[Rubbing] {
        &self.levels
    }

    /// The independent loop equations that hold at a point.
    pub(super) fn rows_at(&self, equations: &Equations, point: &OperatingPoint) -> Vec<usize> {
        self.holding(equations, point).loops.into_iter().map(|place| self.active[place]).collect()
    }

    /// The rows of the levels that act at a point.
    pub(super) fn levels_at(&self, equations: &Equations, point: &OperatingPoint) -> Vec<usize> {
        let row = |place: usize| match self.levels.get(place) {
            Some(friction) => friction.level.row,
            None => self.loads[place - self.levels.len()].row,
        };
        self.holding(equations, point).levels.into_iter().map(row).collect()
    }

    /// Inputs and followers with their derivatives, as far as anything depends on them.
    pub(super) fn signals(&self) -> &[Symbol] {
        &self.columns[self.column(ColumnBlock::Signals)]
    }

    /// The load whose ends are together, so that it has no direction and the forces of small motions no limit.
    pub(super) fn together(
        &self,
        equations: &Equations,
        point: &OperatingPoint,
        length: f64,
    ) -> Option<AnalysisFailure> {
        let squares: Vec<Expr> = self.lines.iter().map(|(_, square)| *square).collect();
        let values = equations.system.arena.evaluate(&squares, point);
        let near = (TOGETHER * length).powi(2);
        let ((name, _), _) = self.lines.iter().zip(values).find(|(_, square)| *square < near)?;
        let what = format!("the ends of `{name}` coincide, so it has no direction");
        Some(AnalysisFailure::NoDerivative { time: point.time(), what })
    }

    /// All numbers at a point.
    pub(super) fn at(&self, equations: &Equations, point: &OperatingPoint) -> Result<Numbers<'_>, AnalysisFailure> {
        self.numbers(equations, point, |_| true)
    }

    /// The same, where outputs may lack a value or a derivative.
    pub(super) fn motion_at(
        &self,
        equations: &Equations,
        point: &OperatingPoint,
    ) -> Result<Numbers<'_>, AnalysisFailure> {
        self.numbers(equations, point, |row| !self.row(RowBlock::Outputs).contains(&row))
    }

    /// The loop equations at a point, and those that repeat others; the rest may lack a value.
    pub(super) fn loops_at(
        &self,
        equations: &Equations,
        point: &OperatingPoint,
    ) -> Result<Numbers<'_>, AnalysisFailure> {
        let loops = [RowBlock::Loops, RowBlock::Repeated].map(|row| self.row(row));
        self.numbers(equations, point, |row| loops.iter().any(|range| range.contains(&row)))
    }

    fn numbers(
        &self,
        equations: &Equations,
        point: &OperatingPoint,
        requested: impl Fn(usize) -> bool,
    ) -> Result<Numbers<'_>, AnalysisFailure> {
        let wanted: Vec<Expr> = self.roots.iter().chain(&self.derivatives).copied().collect();
        let numbers = equations.system.arena.evaluate(&wanted, point);
        let (values, derivatives) = numbers.split_at(self.roots.len());
        let mut matrix = DMatrix::zeros(self.roots.len(), self.columns.len());
        for (&place, &value) in self.places.iter().zip(derivatives) {
            matrix[place] = value;
        }
        let holding = self.holding(equations, point);
        // The size of a force in a pin has no derivative at zero; where the pin sticks nobody asks for it.
        let levels = self.row(RowBlock::Levels);
        let idle = |row: usize| levels.contains(&row) && !holding.levels.contains(&(row - levels.start));
        let finite = |row: &usize| values[*row].is_finite() && matrix.row(*row).iter().all(|value| value.is_finite());
        if let Some(row) = (0..values.len()).find(|row| requested(*row) && !idle(*row) && !finite(row)) {
            let unknown = || AnalysisFailure::NotFinite { time: point.time(), what: self.name(equations, row) };
            return Err(self.together(equations, point, 1.0).unwrap_or_else(unknown));
        }
        Ok(Numbers { variation: self, holding, values: DVector::from_column_slice(values), matrix })
    }

    /// How the derivatives of these rows change with each of these symbols: matrices like that of [`Numbers`].
    pub(super) fn second(
        &self,
        equations: &mut Equations,
        point: &OperatingPoint,
        symbols: &[Symbol],
        rows: &[RowBlock],
    ) -> Result<Vec<DMatrix<f64>>, AnalysisFailure> {
        let is_wanted = |row: usize| rows.iter().any(|wanted| self.row(*wanted).contains(&row));
        let wanted: Vec<usize> = (0..self.places.len()).filter(|&index| is_wanted(self.places[index].0)).collect();
        let derivatives: Vec<Expr> = wanted.iter().map(|&index| self.derivatives[index]).collect();
        let mut found = Vec::with_capacity(symbols.len());
        for &symbol in symbols {
            let exprs = equations.system.arena.derivatives(&derivatives, symbol);
            let values = equations.system.arena.evaluate(&exprs, point);
            let mut matrix = DMatrix::zeros(self.roots.len(), self.columns.len());
            for (&index, value) in wanted.iter().zip(values) {
                if !value.is_finite() {
                    let what = self.name(equations, self.places[index].0);
                    return Err(AnalysisFailure::NotFinite { time: point.time(), what });
                }
                matrix[self.places[index]] = value;
            }
            found.push(matrix);
        }
        Ok(found)
    }

    /// The numbers of these rows at a point.
    pub(super) fn values(&self, equations: &Equations, point: &OperatingPoint, row: RowBlock) -> DVector<f64> {
        let roots = self.held_rows(row, &self.holding(equations, point)).into_iter().map(|root| self.roots[root]);
        DVector::from_vec(equations.system.arena.evaluate(&roots.collect::<Vec<Expr>>(), point))
    }

    /// The roots of this kind, of loop equations those that hold, of levels those of what slides.
    fn held_rows(&self, row: RowBlock, holding: &ActiveRows) -> Vec<usize> {
        let range = self.row(row);
        match row {
            RowBlock::Loops | RowBlock::Rates | RowBlock::Accelerations if !range.is_empty() => {
                holding.loops.iter().map(|place| range.start + place).collect()
            }
            RowBlock::Levels if !range.is_empty() => holding.levels.iter().map(|place| range.start + place).collect(),
            RowBlock::Loops
            | RowBlock::Rates
            | RowBlock::Accelerations
            | RowBlock::Levels
            | RowBlock::Motion
            | RowBlock::Outputs
            | RowBlock::Starts
            | RowBlock::StartRates
            | RowBlock::Repeated
            | RowBlock::Switches => range.collect(),
        }
    }

    /// The columns of this kind, of reactions those of loop equations that hold, of levels those of what slides.
    fn held_columns(&self, column: ColumnBlock, holding: &ActiveRows) -> Vec<usize> {
        let range = self.column(column);
        match column {
            ColumnBlock::Reactions => holding.loops.iter().map(|place| range.start + place).collect(),
            ColumnBlock::Levels => holding.levels.iter().map(|place| range.start + place).collect(),
            ColumnBlock::Positions | ColumnBlock::Rates | ColumnBlock::Accelerations | ColumnBlock::Signals => {
                range.collect()
            }
        }
    }

    /// Whose signs choose the pieces of the laws in the equations of motion.
    pub(super) fn switches(&self) -> &[Expr] {
        &self.switches
    }

    /// Positions and states, then their rates.
    pub(super) fn moving(&self) -> &[Symbol] {
        &self.columns[..2 * self.coordinates]
    }

    /// The roots of this kind and their derivatives.
    pub(super) fn with_derivatives(&self, row: RowBlock) -> Vec<Expr> {
        let range = self.row(row);
        let derivatives = self.places.iter().zip(&self.derivatives).filter(|((root, _), _)| range.contains(root));
        self.roots[range.clone()].iter().copied().chain(derivatives.map(|(_, derivative)| *derivative)).collect()
    }

    fn row(&self, row: RowBlock) -> Range<usize> {
        self.rows.iter().find(|(known, _)| *known == row).map_or(0..0, |(_, range)| range.clone())
    }

    fn column(&self, column: ColumnBlock) -> Range<usize> {
        let (n, m, l) = (self.coordinates, self.active.len(), self.levels.len() + self.loads.len());
        match column {
            ColumnBlock::Positions => 0..n,
            ColumnBlock::Rates => n..2 * n,
            ColumnBlock::Accelerations => 2 * n..3 * n,
            ColumnBlock::Reactions => 3 * n..3 * n + m,
            ColumnBlock::Levels => 3 * n + m..3 * n + m + l,
            ColumnBlock::Signals => 3 * n + m + l..self.columns.len(),
        }
    }

    /// The user's name of an equation's owner.
    fn name(&self, equations: &Equations, row: usize) -> String {
        let within =
            |group: RowBlock| Some(self.row(group)).filter(|range| range.contains(&row)).map(|range| row - range.start);
        if let Some(output) = within(RowBlock::Outputs) {
            self.outputs.get(output).cloned().unwrap_or_default()
        } else if let Some(coordinate) = within(RowBlock::Motion) {
            match equations.motion_layout().variable(coordinate) {
                MotionVariable::Coordinate(index) => equations.coordinates[index].name.position.clone(),
                MotionVariable::State(state) => equations.system.mechanism.states[state].name.clone(),
            }
        } else if let Some(level) = within(RowBlock::Levels) {
            match self.levels.get(level) {
                Some(friction) => equations.system.mechanism.contacts[friction.place].name.clone(),
                None => {
                    let row = self.loads[level - self.levels.len()].row;
                    equations.system.element(equations.constraints[row].element).name.clone()
                }
            }
        } else {
            let place = [RowBlock::Loops, RowBlock::Rates, RowBlock::Accelerations].into_iter().find_map(within);
            match place.and_then(|place| self.active.get(place)) {
                Some(&active) => equations.system.element(equations.constraints[active].element).name.clone(),
                None => equations.system.mechanism.name.clone(),
            }
        }
    }
}

fn lines(equations: &mut Equations) -> Vec<(String, Expr)> {
    let mut lines = Vec::new();
    for index in 0..equations.system.elements.len() {
        let (id, element) = (ElementId(index), &equations.system.elements[index]);
        let Some(row) = element.translation.as_ref().filter(|row| matches!(row.through, Force::Line(_))) else {
            continue;
        };
        let (name, ends) = (element.name.clone(), row.ends);
        if equations.centred(id).is_none() {
            lines.push((name, equations.square_of_length(ends)));
        }
    }
    lines
}

/// The independent loop equations.
fn active(formulated: &Formulated) -> Vec<usize> {
    let constraints = formulated.lowered.program.constraints.iter().enumerate();
    constraints.filter(|(_, constraint)| constraint.is_imposed()).map(|(row, _)| row).collect()
}

fn names(outputs: &[Output]) -> Vec<String> {
    outputs.iter().map(|output| output.name.clone()).collect()
}

/// What rubs, and loads that read accelerations or reactions.
type Acting = (Vec<Rubbing>, Vec<Feedback>);

fn acting(equations: &mut Equations) -> Acting {
    (rubbing(equations), equations.feedback())
}

/// Everything that rubs.
fn rubbing(equations: &mut Equations) -> Vec<Rubbing> {
    let levels = equations.levels();
    let mechanism = equations.system.mechanism.clone();
    let of = |(place, level): (usize, Level)| {
        let direction = mechanism.contacts[place].state.direction?;
        let direction = equations.system.arena.symbol(Symbol::Discrete(direction.0));
        Some(Rubbing { place, level, direction })
    };
    levels.into_iter().filter_map(of).collect()
}

fn roots(formulated: &mut Formulated, active: &[usize], (levels, loads): &Acting) -> Vec<(RowBlock, Vec<Expr>)> {
    let Formulated { equations, outputs, .. } = formulated;
    let mut laws: Vec<Expr> = levels.iter().map(|friction| level(equations, &friction.level)).collect();
    laws.extend(loads.iter().map(|load| {
        let arena = &mut equations.system.arena;
        let value = arena.symbol(Symbol::Reaction(load.row));
        arena.subtract(value, load.value)
    }));
    let mut roots = loops(equations, active);
    roots.extend([
        (RowBlock::Motion, motion(equations)),
        (RowBlock::Accelerations, active.iter().map(|&row| acceleration(equations, row)).collect()),
        (RowBlock::Levels, laws),
        (RowBlock::Outputs, outputs.iter().map(|output| equations.formula(&output.value)).collect()),
        (RowBlock::Repeated, repeated(equations, active)),
    ]);
    roots
}

fn loops(equations: &mut Equations, active: &[usize]) -> Vec<(RowBlock, Vec<Expr>)> {
    vec![
        (RowBlock::Loops, active.iter().map(|&row| equations.gap(row)).collect()),
        (RowBlock::Rates, active.iter().map(|&row| equations.constraint_rate(row)).collect()),
    ]
}

/// The loop equations that repeat others.
fn repeated(equations: &Equations, active: &[usize]) -> Vec<Expr> {
    let repeated = equations.loops().map(|(index, _)| index).filter(|index| !active.contains(index));
    repeated.map(|index| equations.constraints[index].value).collect()
}

/// What is known at the start, less what it should be.
fn starts(equations: &mut Equations, order: Order) -> Vec<Expr> {
    let Conditions { conditions, results, .. } = conditions(equations, order, 1.0);
    let (values, targets) = results.split_at(conditions.len());
    let known = conditions.iter().zip(values.iter().zip(targets)).filter(|(condition, _)| condition.known);
    known.map(|(_, (&value, &target))| equations.system.arena.subtract(value, target)).collect()
}

/// M a + Phi_q^T lambda - Q, then z' - g
fn motion(equations: &mut Equations) -> Vec<Expr> {
    let dynamics = equations.dynamics().clone();
    let states = equations.states.clone();
    let arena = &mut equations.system.arena;
    let states: Vec<Expr> = (states.into_iter().enumerate())
        .map(|(index, rate)| {
            let derivative = arena.symbol(Symbol::State(index, Order::Velocity));
            arena.subtract(derivative, rate)
        })
        .collect();
    let rows = dynamics.mass.into_iter().zip(dynamics.reactions).zip(dynamics.load);
    let rows = rows.map(|((mass, reactions), load)| {
        let mut terms = vec![arena.negate(load)];
        for (index, entry) in mass {
            let acceleration = arena.symbol(Symbol::Coordinate(index, Order::Acceleration));
            terms.push(arena.multiply(entry, acceleration));
        }
        for (index, entry) in reactions {
            let reaction = arena.symbol(Symbol::Reaction(index));
            terms.push(arena.multiply(entry, reaction));
        }
        arena.sum(terms)
    });
    rows.collect::<Vec<Expr>>().into_iter().chain(states).collect()
}

/// Phi_q a - gamma
fn acceleration(equations: &mut Equations, row: usize) -> Expr {
    let constraint = equations.constraints[row].clone();
    let arena = &mut equations.system.arena;
    let mut terms = vec![arena.negate(constraint.gamma)];
    for (index, entry) in constraint.jacobian {
        let acceleration = arena.symbol(Symbol::Coordinate(index, Order::Acceleration));
        terms.push(arena.multiply(entry, acceleration));
    }
    arena.sum(terms)
}

/// s - F - mu p(a, lambda)
fn level(equations: &mut Equations, law: &Level) -> Expr {
    let arena = &mut equations.system.arena;
    let pressing = match &law.pressing {
        Pressing::Sum(signed) => {
            let terms = signed.iter().map(|&(sign, sum)| arena.multiply(sign, sum));
            let terms: Vec<Expr> = terms.collect();
            arena.sum(terms)
        }
        Pressing::Sizes(vectors) => {
            let mut size = |vector: &Vec<Expr>| {
                let squares: Vec<Expr> = vector.iter().map(|&sum| arena.square(sum)).collect();
                let square = arena.sum(squares);
                arena.unary(Unary::Sqrt, square)
            };
            let sizes: Vec<Expr> = vectors.iter().map(&mut size).collect();
            arena.sum(sizes)
        }
    };
    let level = arena.symbol(Symbol::Reaction(law.row));
    let rest = arena.subtract(level, law.free);
    arena.subtract_product(rest, law.share, pressing)
}

#[derive(Clone, Debug)]
pub(super) struct Numbers<'v> {
    variation: &'v Variation,
    holding: ActiveRows,
    values: DVector<f64>,
    matrix: DMatrix<f64>,
}

impl Numbers<'_> {
    pub fn values(&self, row: RowBlock) -> DVector<f64> {
        let rows = self.variation.held_rows(row, &self.holding);
        DVector::from_iterator(rows.len(), rows.into_iter().map(|row| self.values[row]))
    }

    pub fn block(&self, row: RowBlock, column: ColumnBlock) -> DMatrix<f64> {
        self.block_of(&self.matrix, row, column)
    }

    /// A block of a matrix of [`Variation::second`] at the same point.
    pub fn block_of(&self, matrix: &DMatrix<f64>, row: RowBlock, column: ColumnBlock) -> DMatrix<f64> {
        let rows = self.variation.held_rows(row, &self.holding);
        let columns = self.variation.held_columns(column, &self.holding);
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| matrix[(rows[i], columns[j])])
    }

    /// What stands for each column of this kind.
    pub fn symbols(&self, column: ColumnBlock) -> Vec<Symbol> {
        let columns = self.variation.held_columns(column, &self.holding);
        columns.into_iter().map(|place| self.variation.columns[place]).collect()
    }

    /// The independent loop equations that hold.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.holding.loops.iter().map(|&place| self.variation.active[place])
    }

    /// \[M Phi_q^T; Phi_q 0\]; where something slides its level is one more unknown, with its law as one more row.
    pub fn system(&self) -> DMatrix<f64> {
        let [mass, reactions] =
            [ColumnBlock::Accelerations, ColumnBlock::Reactions].map(|column| self.block(RowBlock::Motion, column));
        let without = saddle(&mass, &reactions, &self.block(RowBlock::Accelerations, ColumnBlock::Accelerations));
        let (size, levels) = (without.nrows(), self.holding.levels.len());
        if levels == 0 {
            return without;
        }
        let mut whole = without.resize(size + levels, size + levels, 0.0);
        let (n, m) = (mass.ncols(), reactions.ncols());
        whole.view_mut((0, size), (n, levels)).copy_from(&self.block(RowBlock::Motion, ColumnBlock::Levels));
        for (first, count, column) in
            [(0, n, ColumnBlock::Accelerations), (n, m, ColumnBlock::Reactions), (size, levels, ColumnBlock::Levels)]
        {
            whole.view_mut((size, first), (levels, count)).copy_from(&self.block(RowBlock::Levels, column));
        }
        whole
    }
}
