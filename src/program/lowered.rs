//! The kernels of a program.

use std::collections::HashMap;

use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Steep;
use cotree_fmu::program::arm_form::ArmForm;
use cotree_fmu::program::domain::{Domain, DomainTape};
use cotree_fmu::program::{
    Constraint, Coordinate, Discrete, Engine, Experiment, Follower, FollowerOrder, GapMeasure, Initial, Input,
    Instants, LawTape, Parameter, Program, Role, SparseTape, Tapes,
};
use cotree_fmu::tape::Tape;
use cotree_fmu::taylor::Jet;

use super::contacts::ContactKernels;
use super::dependencies::Moving;
use super::initial::{Conditions, Settable, conditions, listed, settable};
use super::instants::InstantKernels;
use super::kernels::Kernels;
use super::table::VariableTable;
use crate::arms::{NoSeries, arm_form, mass_form, repeat_exactly};
use crate::equations::{Constraint as Row, Equations, RowKind, Standing, if_positive, impulse_of};
use crate::expr::{Arena, Expr, ExprNode, Order, Symbol};
use crate::laws::{domains, motion_indicators, ranges, steep};
use crate::model::{DiscreteId, Method, Output, Owner};
use crate::network::{Constrained, Origin};
use crate::solve::{
    Block, BlockLoops, Incidence, LevelSolution, Levels, Obstacle, Shared, SolveTree, blocks, least_norm, solve_tree,
    typical,
};
use crate::tape::{Assembler, layout};

/// With more coordinates there are no implicit steps unless the scene asks for them: their matrices are full.
const MOST_IMPLICIT: usize = 500;

/// The program of a formulated and assembled mechanism, with its descriptions.
#[derive(Clone, Debug)]
pub struct Lowered {
    /// Its GUID is still to be set.
    pub program: Program,
    pub table: VariableTable,
    /// Accelerations and reactions as expressions; empty where drivers determine the motion.
    pub solved: Vec<Expr>,
    /// Which loop equations determine which coordinates, in the order of their solution; empty unless drivers determine the motion.
    pub blocks: Vec<Block>,
    /// Why the motion is not integrated by Taylor series, if it is not.
    pub no_series: Option<NoSeries>,
    /// The trees behind the acceleration kernel, where they are not those of the coordinates.
    pub solve_tree: Option<SolveTree>,
    pub shared: Shared,
}

impl Lowered {
    /// Gives the program the values of the mechanism of its equations, which differs in values only from the one that it was made for, and the natural units of this length. Where the motion begins is forgotten. False if other initial values can be set than in the program.
    pub(crate) fn set_values(&mut self, equations: &mut Equations, length: f64) -> bool {
        let starts = settable(equations);
        let parameters = parameters(equations, &starts);
        let program = &mut self.program;
        if !parameters
            .iter()
            .map(|parameter| &parameter.name)
            .eq(program.parameters.iter().map(|parameter| &parameter.name))
        {
            return false;
        }
        let roles: Vec<Role> = program.constraints.iter().map(|constraint| constraint.role).collect();
        let mechanism = &equations.system.mechanism;
        program.initial = Initial {
            positions: listed(mechanism, Order::Position, length),
            velocities: listed(mechanism, Order::Velocity, length),
            first_positions: Vec::new(),
            first_rates: Vec::new(),
            found_positions: Vec::new(),
            found_rates: Vec::new(),
            ..std::mem::take(&mut program.initial)
        };
        program.parameters = parameters;
        program.inputs = inputs(equations);
        program.followers = followers(equations, length);
        program.coordinates = coordinates(equations, length);
        program.constraints = constraints(equations, length, &roles);
        program.experiment = experiment(equations);
        program.length = length;
        true
    }
}

#[derive(Clone, Debug, Default)]
struct PositionKernels {
    constraint: Vec<Expr>,
    jacobian: Vec<((u32, u32), Expr)>,
    constraint_rate: Vec<Expr>,
    gamma: Vec<Expr>,
    positions: Conditions,
    velocities: Conditions,
}

#[derive(Clone, Debug, Default)]
struct MotionKernels {
    /// Accelerations, then reactions.
    solved: Vec<Expr>,
    reciprocal_pivots: Vec<Expr>,
    project_position: Vec<Expr>,
    project_velocity: Vec<Expr>,
    indicators: Vec<Expr>,
    laws: Vec<(Steep, Expr)>,
    domains: Vec<(Domain, Expr)>,
    outputs: Vec<Expr>,
    instants: InstantKernels,
    contacts: ContactKernels,
    arms: Option<(ArmForm, Vec<Expr>)>,
    masses: Option<(ArmForm, Vec<Expr>)>,
    solve_tree: Option<SolveTree>,
}

/// A program with which the mechanism can be assembled, but not moved.
pub fn positions(equations: &mut Equations, length: f64) -> Program {
    // What may be open is so until the loops are closed.
    let is_open = |row: &Row| equations.presses(row) || equations.opens_at_start(row);
    let presses: Vec<bool> = equations.constraints.iter().map(is_open).collect();
    let role = |(row, presses): (&Row, &bool)| if row.is_trivial() || *presses { Role::LeftOut } else { Role::Imposed };
    let roles: Vec<Role> = equations.constraints.iter().zip(&presses).map(role).collect();
    let kernels = PositionKernels::new(equations, length);
    assemble(equations, (length, &roles), &kernels, &MotionKernels::default(), &VariableTable::default())
}

/// The whole program; as many imposed loop equations as coordinates determine the motion. The poses are the start, and one where loop equations depend on each other only if they do in every pose.
///
/// # Errors
/// A coordinate that moves no mass and is not constrained.
pub fn program(
    equations: &mut Equations,
    outputs: &[Output],
    length: f64,
    [pose, generic]: [&State; 2],
) -> Result<Lowered, Obstacle> {
    let driven = equations.is_driven();
    let roles = roles(equations, length, pose);
    let kernels = PositionKernels::new(equations, length);
    let mut moving = MotionKernels::default();
    let blocks = if driven { solution_order(equations, &roles) } else { Vec::new() };
    if !driven {
        let (solver, solve_tree) = solve_tree::solver(equations, length, pose)?;
        moving.solve_tree = solve_tree;
        let constraints = equations.constraints.len();
        let levels = Levels::new(equations, |arena, column| solver.response(arena, column, constraints));
        let without = solver.motion(&mut equations.system.arena, equations.constraints.len());
        let LevelSolution { mut values, locks } = levels.solve(&mut equations.system.arena, without, false);
        let locks = if equations.rubs_dry() {
            locks
        } else {
            unknown_unless(&mut equations.system.arena, &mut values, &locks);
            Vec::new()
        };
        moving.solved = values;
        moving.add_states(equations);
        let arena = &mut equations.system.arena;
        moving.reciprocal_pivots = solver.reciprocal_pivots(arena);
        moving.contacts = ContactKernels::new(equations, &solver, (&levels, locks));
        let arena = &mut equations.system.arena;
        if equations.constraints.iter().any(|row| row.is_imposed()) {
            let states = vec![Expr::ZERO; equations.states.len()];
            moving.project(&kernels, |residuals| [solver.projection(arena, residuals), states.clone()].concat());
        }
    }
    moving.indicators = motion_indicators(equations, &moving.solved);
    let laws = if driven { equations.states.clone() } else { equations.law_values() };
    // A friction limit is a law as a load is; what presses is none of the scene.
    let levels = if driven { Vec::new() } else { equations.level_laws() };
    let values = [laws, levels, kernels.gamma.clone(), kernels.constraint_rate.clone()].concat();
    moving.laws = steep(&mut equations.system.arena, &values);
    if !driven {
        moving.read_the_motion(equations);
    }
    moving.domains = domains(equations);
    let shared = match blocks.iter().find(|block| block.repeats()) {
        Some(block) => least_norm::impose_in_every_pose(equations, block, length, generic)?,
        None => None,
    };
    let shared = match shared {
        Some(shared) => shared,
        None => least_norm::impose(equations, length, [pose, generic])?,
    };
    // The states of a driven mechanism are integrated beside it, as those of any other.
    let kinematic = driven && equations.states.is_empty();
    if driven && !kinematic {
        let outputs: Vec<Expr> = outputs.iter().map(|output| equations.formula(&output.value)).collect();
        let requested = [outputs, InstantKernels::new(equations).read(), equations.states.clone()].concat();
        moving.drive(equations, (&kernels, &blocks), &requested, (length, pose))?;
        moving.read_the_motion(equations);
        moving.indicators = motion_indicators(equations, &moving.solved);
    }
    let table = VariableTable::new(equations, outputs, kinematic, &Moving { solved: &moving.solved, blocks: &blocks });
    moving.outputs.clone_from(&table.results);
    moving.instants = InstantKernels::new(equations);
    if kinematic {
        let requested = [&table.results[..], &moving.instants.read()].concat();
        moving.drive(equations, (&kernels, &blocks), &requested, (length, pose))?;
    }
    if equations.first_led().is_some() {
        moving.lead(equations, length);
    }
    let mut no_series = None;
    match series(equations, length, pose) {
        Ok(arms) => moving.arms = Some(arms),
        Err(reason) => {
            no_series = Some(reason);
            if !driven && !equations.reads_the_motion() {
                moving.masses = mass_form(equations, &typical(pose)).ok();
            }
        }
    }
    let mut program = assemble(equations, (length, &roles), &kernels, &moving, &table);
    if is_too_large(&program) {
        program.engine = Engine::Dop853;
        no_series = Some(NoSeries("it has many equations that are weakly coupled".to_owned()));
    }
    let solved = if driven { Vec::new() } else { moving.solved };
    Ok(Lowered { program, table, solved, blocks, solve_tree: moving.solve_tree, no_series, shared })
}

/// The arm form with the expressions of its coefficients, or why there is none: the scene asks for another method, or it is hopeless, because
/// many bodies move with many angles each.
fn series(equations: &mut Equations, length: f64, pose: &State) -> Result<(ArmForm, Vec<Expr>), NoSeries> {
    let values = typical(pose);
    if !equations.is_driven() && equations.rubs_dry() && has_other_modes(equations) {
        return Err(NoSeries("dry friction acts next to contacts, or to what drivers move".to_owned()));
    }
    if equations.reads_the_motion() {
        return Err(NoSeries(
            "a law reads accelerations or reactions, which Taylor series do not support yet".to_owned(),
        ));
    }
    match equations.system.mechanism.solver.method {
        Method::Auto => arm_form(equations, length, &values),
        Method::Explicit => Err(NoSeries("the scene asks for `method = \"explicit\"`".to_owned())),
        Method::Implicit => Err(NoSeries("the scene asks for `method = \"implicit\"`".to_owned())),
    }
}

/// Does anything open or close but friction that sticks? Each impact begins a series, which with friction costs more than a Runge-Kutta step.
fn has_other_modes(equations: &Equations) -> bool {
    let mechanism = &equations.system.mechanism;
    let has_contacts = mechanism.contacts.iter().any(|contact| contact.slip.is_none());
    has_contacts || !mechanism.engaging.is_empty() || equations.first_led().is_some()
}

/// Would a step by Taylor series cost too much? It factors a matrix at every order; a Runge-Kutta step evaluates a tape at every stage, but
/// predicts singular configurations less well.
fn is_too_large(program: &Program) -> bool {
    const SMALL: usize = 32;
    const STAGES: usize = 12;
    /// The inversion of a dense matrix of 1000 rows.
    const MOST_WITH_LOOPS: f64 = 5e7;
    let Some(arms) = program.arms.as_ref().filter(|arms| arms.coordinates.len() > SMALL) else { return false };
    let instructions = program.tapes.acceleration.instructions().len();
    // A step by series is about twice as long.
    let most = if arms.rows.is_empty() { (2 * STAGES * instructions) as f64 } else { MOST_WITH_LOOPS };
    let jet = Model::new(program.clone()).ok().and_then(|model| Jet::new(&model));
    jet.is_none_or(|jet| jet.cost() > most)
}

impl PositionKernels {
    fn new(equations: &mut Equations, length: f64) -> Self {
        let coordinates = equations.motion_layout().count();
        let mut jacobian = Vec::new();
        for (row, constraint) in equations.constraints.iter().enumerate() {
            let followers = constraint.followers.iter().map(|&(index, entry)| (coordinates + index, entry));
            for (column, entry) in constraint.jacobian.iter().copied().chain(followers) {
                jacobian.push(((row as u32, column as u32), entry));
            }
        }
        PositionKernels {
            constraint: equations.gaps(),
            jacobian,
            constraint_rate: (0..equations.constraints.len()).map(|index| equations.constraint_rate(index)).collect(),
            gamma: equations.constraints.iter().map(|constraint| constraint.gamma).collect(),
            positions: conditions(equations, Order::Position, length),
            velocities: conditions(equations, Order::Velocity, length),
        }
    }
}

impl MotionKernels {
    /// Where drivers determine the motion: accelerations from Phi_q a = gamma and, if an output needs them, reactions from
    /// Phi_q^T lambda = Q - M a.
    fn drive(
        &mut self,
        equations: &mut Equations,
        (kernels, blocks): (&PositionKernels, &[Block]),
        requested: &[Expr],
        (length, pose): (f64, &State),
    ) -> Result<(), Obstacle> {
        let loops = BlockLoops::new(equations, blocks, length, pose)?;
        self.solved = loops.solve(&mut equations.system.arena, &kernels.gamma);
        let results = equations.system.arena.symbols(requested.iter().copied());
        let reactions = if results.iter().any(|symbol| matches!(symbol, Symbol::Reaction(_))) {
            balanced(equations, &loops, &self.solved)
        } else {
            vec![Expr::ZERO; kernels.gamma.len()]
        };
        self.solved.extend(reactions);
        self.add_states(equations);
        let states = vec![Expr::ZERO; equations.states.len()];
        let arena = &mut equations.system.arena;
        self.reciprocal_pivots = loops.reciprocal_pivots(arena);
        if !blocks.is_empty() {
            self.project(kernels, |residuals| {
                let minus: Vec<Expr> = residuals.iter().map(|&residual| arena.negate(residual)).collect();
                [loops.solve(arena, &minus), states.clone()].concat()
            });
        }
        Ok(())
    }

    /// Where drivers lead the motion, what rubs slides as they say.
    fn lead(&mut self, equations: &mut Equations, length: f64) {
        let directions = equations.known_directions(&self.solved, length);
        let before = equations.system.arena.clone();
        let arena = &mut equations.system.arena;
        let mut lead = |kernel: &mut Vec<Expr>| *kernel = arena.import(&before, kernel, &directions);
        let InstantKernels { begin, clocks, written, sides } = &mut self.instants;
        for kernel in [&mut self.solved, &mut self.indicators, &mut self.outputs, begin, clocks, written, sides] {
            lead(kernel);
        }
        // What may stick does so whatever drivers lead, but what locks is the levels of all.
        lead(&mut self.contacts.locks);
        let (kinds, mut laws): (Vec<Steep>, Vec<Expr>) = self.laws.drain(..).unzip();
        lead(&mut laws);
        self.laws.extend(kinds.into_iter().zip(laws));
    }

    /// Rates of states stand between accelerations and reactions, which they may read.
    fn add_states(&mut self, equations: &mut Equations) {
        let first = equations.motion_layout().states().start;
        let rates = self.known(equations, &equations.states.clone());
        self.solved.splice(first..first, rates);
    }

    /// Gives the arguments of steep laws what they read of the motion.
    fn read_the_motion(&mut self, equations: &mut Equations) {
        let (kinds, laws): (Vec<Steep>, Vec<Expr>) = self.laws.drain(..).unzip();
        self.laws = kinds.into_iter().zip(self.known(equations, &laws)).collect();
    }

    /// Expressions with accelerations and reactions as they have been solved for.
    fn known(&self, equations: &mut Equations, values: &[Expr]) -> Vec<Expr> {
        let reactions = self.solved.len() - equations.constraints.len();
        let arena = &mut equations.system.arena;
        let solved = |symbol: Symbol| match symbol {
            Symbol::Coordinate(index, Order::Acceleration) => Some((symbol, self.solved[index])),
            Symbol::Reaction(row) => Some((symbol, self.solved[reactions + row])),
            Symbol::Coordinate(_, Order::Position | Order::Velocity)
            | Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::State(..)
            | Symbol::Missing(..)
            | Symbol::Argument => None,
        };
        let given: HashMap<Symbol, Expr> =
            arena.symbols(values.iter().copied()).into_iter().filter_map(solved).collect();
        if given.is_empty() {
            return values.to_vec();
        }
        let before = arena.clone();
        arena.import(&before, values, &given)
    }

    /// Both projections: the residuals, and the corrections that cancel them.
    fn project(&mut self, kernels: &PositionKernels, mut corrections: impl FnMut(&[Expr]) -> Vec<Expr>) {
        for (residuals, kernel) in
            [(&kernels.constraint, &mut self.project_position), (&kernels.constraint_rate, &mut self.project_velocity)]
        {
            kernel.clone_from(residuals);
            kernel.extend(corrections(residuals));
        }
    }
}

/// The multipliers of all loop equations of a driven mechanism, with the levels of what rubs; none is a number where it locks itself.
fn balanced(equations: &mut Equations, loops: &BlockLoops, accelerations: &[Expr]) -> Vec<Expr> {
    let (first, count) = (accelerations.len(), equations.constraints.len());
    let loads = inverse(equations, accelerations);
    let without = loops.balance(&mut equations.system.arena, &loads, count);
    let levels =
        Levels::new(equations, |arena, column| [vec![Expr::ZERO; first], loops.balance(arena, column, count)].concat());
    if levels.is_empty() {
        return without;
    }
    let arena = &mut equations.system.arena;
    let LevelSolution { mut values, locks } = levels.solve(arena, [accelerations, &without].concat(), false);
    unknown_unless(arena, &mut values[first..], &locks);
    values.split_off(first)
}

/// Makes values no numbers unless these are positive.
fn unknown_unless(arena: &mut Arena, values: &mut [Expr], positive: &[Expr]) {
    for &expr in positive {
        let known = if_positive(arena, expr);
        values.iter_mut().for_each(|value| *value = arena.add(*value, known));
    }
}

/// Q - M a, by coordinates.
pub(crate) fn inverse(equations: &mut Equations, accelerations: &[Expr]) -> Vec<Expr> {
    let dynamics = equations.dynamics().clone();
    let arena = &mut equations.system.arena;
    let rows = dynamics.load.into_iter().zip(dynamics.mass);
    let rest = |(load, mass): (Expr, Vec<(usize, Expr)>)| {
        mass.into_iter().fold(load, |rest, (column, entry)| arena.subtract_product(rest, entry, accelerations[column]))
    };
    rows.map(rest).collect()
}

fn assemble(
    equations: &mut Equations,
    (length, roles): (f64, &[Role]),
    position: &PositionKernels,
    moving: &MotionKernels,
    table: &VariableTable,
) -> Program {
    let mechanism = &*equations.system.mechanism.clone();
    let starts = settable(equations);
    let layout = layout(equations, starts.len());
    let entries = |entries: &[((u32, u32), Expr)]| -> Vec<Expr> { entries.iter().map(|(_, entry)| *entry).collect() };
    let [jacobian, q_jacobian, v_jacobian] =
        [&position.jacobian, &position.positions.jacobian, &position.velocities.jacobian].map(|matrix| entries(matrix));
    let (kinds, laws): (Vec<Steep>, Vec<Expr>) = moving.laws.iter().copied().unzip();
    let (domains, arguments): (Vec<Domain>, Vec<Expr>) = moving.domains.iter().cloned().unzip();
    let (ranges, bounded): (Vec<Domain>, Vec<Expr>) = ranges(equations).into_iter().unzip();
    let acceleration: Vec<Expr> = moving.solved.iter().chain(&moving.reciprocal_pivots).copied().collect();
    let [arms, masses] =
        [&moving.arms, &moving.masses].map(|form| form.as_ref().map_or(&[][..], |(_, coefficients)| coefficients));
    let kernels: Kernels<&[Expr]> = Kernels {
        constraint: &position.constraint,
        jacobian: &jacobian,
        constraint_rate: &position.constraint_rate,
        gamma: &position.gamma,
        position: &position.positions.results,
        position_jacobian: &q_jacobian,
        velocity: &position.velocities.results,
        velocity_jacobian: &v_jacobian,
        acceleration: &acceleration,
        project_position: &moving.project_position,
        project_velocity: &moving.project_velocity,
        indicators: &moving.indicators,
        laws: &laws,
        domains: &arguments,
        ranges: &bounded,
        outputs: &moving.outputs,
        begin: &moving.instants.begin,
        clocks: &moving.instants.clocks,
        written: &moving.instants.written,
        sides: &moving.instants.sides,
        gaps: &moving.contacts.gaps,
        gap_rates: &moving.contacts.rates,
        gap_accelerations: &moving.contacts.accelerations,
        restitutions: &moving.contacts.restitutions,
        impact: &moving.contacts.impact,
        pressing: &moving.contacts.pressing,
        locks: &moving.contacts.locks,
        row_sizes: &moving.contacts.row_sizes,
        places: &moving.contacts.places,
        arms,
        masses,
    };
    let mut assembler = Assembler::new(&equations.system.arena, layout, &kernels.all());
    let mut kernels = kernels.map(|results| assembler.tape(results));
    let reciprocal_pivots = kernels.acceleration.results.split_off(moving.solved.len());
    let sparse = |entries: &[((u32, u32), Expr)], tape: Tape| SparseTape {
        entries: entries.iter().map(|(place, _)| *place).collect(),
        tape,
    };
    let tapes = Tapes {
        parameters: assembler.stage.clone(),
        constraint: kernels.constraint,
        jacobian: sparse(&position.jacobian, kernels.jacobian),
        constraint_rate: kernels.constraint_rate,
        gamma: kernels.gamma,
        acceleration: kernels.acceleration,
        reciprocal_pivots,
        project_position: kernels.project_position,
        project_velocity: kernels.project_velocity,
        indicators: kernels.indicators,
        laws: LawTape { kinds, tape: kernels.laws },
        domains: DomainTape { domains, tape: kernels.domains },
        ranges: DomainTape { domains: ranges, tape: kernels.ranges },
        outputs: kernels.outputs,
    };
    let initial = Initial {
        positions: position.positions.conditions.clone(),
        position: kernels.position,
        position_jacobian: sparse(&position.positions.jacobian, kernels.position_jacobian),
        velocities: position.velocities.conditions.clone(),
        velocity: kernels.velocity,
        velocity_jacobian: sparse(&position.velocities.jacobian, kernels.velocity_jacobian),
        ..Initial::default()
    };
    let of_contacts = [
        kernels.gaps,
        kernels.gap_rates,
        kernels.gap_accelerations,
        kernels.restitutions,
        kernels.impact,
        kernels.pressing,
        kernels.locks,
        kernels.row_sizes,
        kernels.places,
    ];
    let contacts = ContactKernels::lower(equations, of_contacts);
    let instants = moving.instants.lower(mechanism, [kernels.begin, kernels.clocks, kernels.written, kernels.sides]);
    let instants = Instants { masks: masks(equations, roles), contacts, ..instants };
    let form = |form: &Option<(ArmForm, Vec<Expr>)>, coefficients: Tape| {
        form.as_ref().map(|(form, _)| ArmForm { coefficients, ..form.clone() })
    };
    let (arms, masses) = (form(&moving.arms, kernels.arms), form(&moving.masses, kernels.masses));
    Program {
        name: mechanism.name.clone(),
        guid: String::from("draft"),
        experiment: experiment(equations),
        parameters: parameters(equations, &starts),
        discrete: discrete(equations),
        inputs: inputs(equations),
        followers: followers(equations, length),
        coordinates: coordinates(equations, length),
        states: equations.states.len() as u32,
        constraints: constraints(equations, length, roles),
        length,
        variables: table.variables(),
        constants: assembler.constants.clone(),
        registers: assembler.registers,
        tapes,
        initial,
        engine: match mechanism.solver.method {
            Method::Implicit => Engine::Radau,
            Method::Auto if arms.is_some() => Engine::Taylor,
            Method::Auto | Method::Explicit => Engine::Dop853,
        },
        automatic: mechanism.solver.method == Method::Auto && equations.motion_layout().count() <= MOST_IMPLICIT,
        instants,
        arms,
        masses,
    }
}

/// What the motion has to do with each loop equation. Those that repeat others but nearly are left out: each choice of them is another motion.
fn roles(equations: &mut Equations, length: f64, pose: &State) -> Vec<Role> {
    let chosen = equations.is_driven()
        && equations.states.is_empty()
        && equations.constraints.iter().all(|row| row.standing() != Some(Standing::SecondOrder))
        && repeat_exactly(equations, length, &typical(pose));
    let role = |row: &Row| match row.kind {
        RowKind::Loop(Standing::Imposed) => Role::Imposed,
        RowKind::Contact(_) => masked_role(equations, row),
        RowKind::Loop(Standing::Repeats) if chosen => Role::Repeating,
        RowKind::Loop(Standing::Repeats | Standing::SecondOrder | Standing::Trivial) => Role::LeftOut,
        RowKind::DrivenContact(_) | RowKind::FrictionLimit | RowKind::LoadValue => Role::LeftOut,
    };
    equations.constraints.iter().map(role).collect()
}

/// The role of what does not always hold, with the discrete variables that the runtime writes to.
fn masked_role(equations: &Equations, row: &Row) -> Role {
    let system = &equations.system;
    let place = |id: DiscreteId| id.0 as u32;
    match system.element(row.element).origin {
        Origin::SetRate(index) => {
            let set = &system.mechanism.set_rates[index];
            Role::Set { value: place(set.value), impulse: place(set.impulse) }
        }
        Origin::Joint(joint) => {
            let engaging = system.mechanism.engaging(Owner::Joint(joint));
            let written = engaging.and_then(|engaging| {
                let quantity = impulse_of(row.constrained, engaging)?;
                let (_, impulse) = engaging.impulses.iter().find(|(other, _)| *other == quantity)?;
                Some([*impulse, engaging.lost?])
            });
            written
                .map_or(Role::Contact, |[impulse, lost]| Role::Engaging { impulse: place(impulse), lost: place(lost) })
        }
        _ => Role::Contact,
    }
}

/// The blocks of the loop equations that determine the motion.
fn solution_order(equations: &Equations, roles: &[Role]) -> Vec<Block> {
    let [independent, repeating] = [Role::Imposed, Role::Repeating].map(|role| incidence(equations, roles, role));
    blocks(&independent, &repeating, equations.coordinates.len())
}

/// The coordinates that occur in each loop equation of a role.
fn incidence(equations: &Equations, roles: &[Role], role: Role) -> Vec<Incidence> {
    let rows = equations.constraints.iter().enumerate().filter(|(row, _)| roles[*row] == role);
    rows.map(|(row, constraint)| (row as u32, constraint.jacobian.iter().map(|&(column, _)| column as u32).collect()))
        .collect()
}

fn experiment(equations: &Equations) -> Experiment {
    let mechanism = &equations.system.mechanism;
    let experiment = mechanism.experiment;
    Experiment {
        start: experiment.start,
        stop: experiment.stop,
        step: experiment.step,
        tolerance: mechanism.solver.rtol.unwrap_or(experiment.tolerance),
        max_step: mechanism.solver.max_step.unwrap_or(f64::INFINITY),
        budget: mechanism.solver.time_budget.unwrap_or(f64::INFINITY),
    }
}

/// Those of the scene, then the initial values that can be set.
fn parameters(equations: &Equations, starts: &[Settable]) -> Vec<Parameter> {
    let of = |parameter: &crate::model::Parameter| Parameter {
        name: parameter.name.clone(),
        start: parameter.value,
        min: parameter.min,
        max: parameter.max,
        tunable: parameter.tunable,
    };
    let mechanism = &equations.system.mechanism;
    let start = |start: &Settable| Parameter {
        name: start.given.name(mechanism),
        start: start.value,
        min: None,
        max: None,
        tunable: false,
    };
    mechanism.parameters.iter().map(of).chain(starts.iter().map(start)).collect()
}

fn discrete(equations: &Equations) -> Vec<Discrete> {
    let of = |discrete: &crate::model::Discrete| Discrete { name: discrete.name.clone(), start: discrete.start() };
    equations.system.mechanism.discrete.iter().map(of).collect()
}

fn inputs(equations: &Equations) -> Vec<Input> {
    let of = |input: &crate::model::Input| Input {
        name: input.name.clone(),
        start: input.start,
        min: input.min,
        max: input.max,
    };
    equations.system.mechanism.inputs.iter().map(of).collect()
}

fn followers(equations: &Equations, length: f64) -> Vec<Follower> {
    let system = &equations.system;
    let of = |&(driver, input, order): &(crate::model::DriverId, crate::model::InputId, Order)| {
        let driver = &system.mechanism.drivers[driver.0];
        let angular = driver.is_angular();
        Follower {
            name: driver.name.clone(),
            input: input.0 as u32,
            order: if order == Order::Velocity { FollowerOrder::Velocity } else { FollowerOrder::Acceleration },
            scale: if angular { 1.0 } else { length },
        }
    };
    system.followers.iter().map(of).collect()
}

fn coordinates(equations: &Equations, length: f64) -> Vec<Coordinate> {
    let of = |coordinate: &crate::equations::Coordinate| Coordinate {
        name: coordinate.name.position.clone(),
        scale: if coordinate.angular { 1.0 } else { length },
    };
    let states = equations.system.mechanism.states.iter();
    // A state is the rate of its integral, whose size is that of the state in a second.
    let states = states.map(|state| Coordinate { name: state.name.clone(), scale: state.nominal });
    equations.coordinates.iter().map(of).chain(states).collect()
}

/// The loop equations that do not always hold, with the discrete variables that say whether they do.
fn masks(equations: &Equations, roles: &[Role]) -> Vec<(u32, u32)> {
    let rows = equations.constraints.iter().zip(roles).enumerate();
    let masked = rows.filter(|(_, (_, role))| role.is_masked()).filter_map(|(index, (row, _))| {
        let ExprNode::Symbol(Symbol::Discrete(closed)) = equations.system.arena.node(row.contact()?.closed) else {
            return None;
        };
        Some((index as u32, closed as u32))
    });
    masked.collect()
}

fn measure(row: &Row) -> GapMeasure {
    match (row.constrained, row.period) {
        (Constrained::Angle, Some(_)) => GapMeasure::Direction,
        (Constrained::Angle, None) => GapMeasure::Angle,
        (Constrained::Along(_) | Constrained::Length, _) => GapMeasure::Length,
    }
}

fn constraints(equations: &Equations, length: f64, roles: &[Role]) -> Vec<Constraint> {
    let rows = equations.constraints.iter().zip(roles);
    rows.map(|(constraint, &role)| Constraint {
        owner: equations.system.element(constraint.element).name.clone(),
        scale: constraint.scale(length),
        measure: measure(constraint),
        role,
        implied: matches!(equations.system.element(constraint.element).origin, Origin::Implied(_)),
    })
    .collect()
}
