//! Expressions to formulas: names are looked up, units checked, numbers folded.

use std::f64::consts::PI;

use super::Resolver;
use super::formulas::FACTOR;
use super::names::{Named, one};
use super::parameters::hertz;
use super::signals::{ResolvedSignal, variables};
use crate::component::Section;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::expr::{Binary, Function, Unary};
use crate::model::{Class, DiscreteId, Exponents, Formula, JointId, LoadId, Owner, Quantity, Variable};
use crate::scene::constant;
use crate::scene::dimension::{self, KnownUnit};
use crate::scene::expression::{self, SyntaxKind, SyntaxTree};
use crate::scene::unit::from_exponents;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Context {
    Constant,
    Driver,
    /// All that, positions, velocities, and forces and torques of other loads; the own variables of this load by their bare names.
    Law(LoadId),
    /// As a law of a load: the rate of a state.
    Rate,
    /// As a law of a load, but for accelerations, forces and torques: how much friction holds at most.
    Level,
    /// Numbers, parameters and the own variables of this joint.
    Curve(JointId),
    Output,
    /// What happens at an instant, seen from just before it; in the next value of a value of this sampler, new ones of the others.
    Instant(Option<usize>),
    /// What a sampled value begins with.
    Start,
}

impl Context {
    /// Does what is written there not depend on the time or the motion, but for a part's own variables?
    fn is_constant(self) -> bool {
        matches!(self, Context::Constant | Context::Curve(_))
    }
}

/// A text that is being lowered, and its owner.
#[derive(Clone, Copy)]
struct Site<'a> {
    text: &'a Text,
    what: &'a str,
    context: Context,
}

impl Resolver<'_> {
    /// Parses and resolves an expression; faults are reported.
    pub(super) fn expression(&mut self, text: &Text, what: &str, context: Context) -> Option<(Formula, KnownUnit)> {
        match expression::parse(text) {
            Ok(tree) => self.lower(&tree, Site { text, what, context }),
            Err(fault) => {
                self.faults.push(fault);
                None
            }
        }
    }

    pub(super) fn constant_tree(&mut self, tree: &SyntaxTree, text: &Text, what: &str) -> Option<(Formula, KnownUnit)> {
        self.lower(tree, Site { text, what, context: Context::Constant })
    }

    pub(super) fn law_tree(&mut self, tree: &SyntaxTree, text: &Text, what: &str) -> Option<(Formula, KnownUnit)> {
        self.lower(tree, Site { text, what, context: Context::Output })
    }

    fn lower(&mut self, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        match &tree.kind {
            SyntaxKind::Number(number) => Some((Formula::Number(*number), KnownUnit::Number)),
            SyntaxKind::Measure(value, unit) => {
                let written = site.text.text.get(tree.start..tree.end).unwrap_or_default();
                let hertz = hertz(Some(unit), None, Some(&written.into()));
                Some((Formula::Number(*value), KnownUnit::written(unit.exponents).in_hertz(hertz)))
            }
            SyntaxKind::Name(name) => self.lower_name(name, tree, site),
            SyntaxKind::New(name) => {
                let sampler = if let Context::Instant(sampler) = site.context { sampler } else { None };
                let name = Text::new(name.as_str(), site.text.part(tree.start, tree.end));
                self.new_value(&name, sampler, site.what)
            }
            SyntaxKind::Call(function, arguments) => self.lower_call(*function, arguments, tree, site),
            SyntaxKind::Table(lookup, file, argument) => {
                let argument = self.lower(argument, site)?;
                let place = site.text.part(tree.start, tree.end);
                self.lookup(*lookup, file, argument, (site.what, place))
            }
            SyntaxKind::If(comparison, parts) => {
                let lowered = [0, 1, 2, 3].map(|index| self.lower(&parts[index], site));
                let [Some((a, a_unit)), Some((b, b_unit)), Some((then, then_unit)), Some((other, other_unit))] =
                    lowered
                else {
                    return None;
                };
                self.join(a_unit, b_unit, "compared with", tree, site);
                let known = self.join(then_unit, other_unit, "an alternative to", tree, site);
                Some((Formula::If(*comparison, Box::new([a, b, then, other])), known))
            }
        }
    }

    fn lower_call(
        &mut self,
        function: Function,
        arguments: &[SyntaxTree],
        tree: &SyntaxTree,
        site: Site<'_>,
    ) -> Option<(Formula, KnownUnit)> {
        let lowered: Vec<Option<(Formula, KnownUnit)>> =
            arguments.iter().map(|argument| self.lower(argument, site)).collect();
        let (formulas, units): (Vec<Formula>, Vec<KnownUnit>) = lowered.into_iter().collect::<Option<_>>()?;
        let known = match (function, &units[..]) {
            (Function::One(Unary::Negate), [unit]) => *unit,
            (Function::Two(Binary::Add), [a, b]) => self.join(*a, *b, "added to", tree, site),
            (Function::Two(Binary::Subtract), [a, b]) => self.join(*a, *b, "subtracted from", tree, site),
            (Function::Two(operator @ (Binary::Multiply | Binary::Divide | Binary::Power)), [a, b]) => {
                // A quotient of numbers is reported as the number that it is.
                let by_zero = operator == Binary::Divide && constant::number(&formulas[1]) == Some(0.0);
                if by_zero && constant::number(&formulas[0]).is_none() {
                    let message = format!("{} divides by zero", site.what);
                    let span = site.text.part(arguments[1].start, arguments[1].end);
                    self.faults.push(Fault::new("scene::not_finite", message, span).label("zero"));
                }
                dimension::multiply(operator, *a, *b, &formulas[1])
            }
            _ => self.returned(function, &units, tree, site),
        };
        Some((constant::apply(function, formulas), known))
    }

    /// The unit of a function's value, given those of its arguments.
    fn returned(&mut self, function: Function, units: &[KnownUnit], tree: &SyntaxTree, site: Site<'_>) -> KnownUnit {
        let mut known = KnownUnit::Number;
        for unit in units {
            known = self.join(known, *unit, "used together with", tree, site);
        }
        if known.hertz() != 0 && matches!(function.name(), "sin" | "cos" | "tan") {
            let what = format!("in {}, `{}` takes an angle", site.what, function.name());
            self.open_hertz(&what, site.text.part(tree.start, tree.end), FACTOR);
        } else if !dimension::accepts(function, known) {
            let (name, unit) = (function.name(), known.unit().map(unit_name).unwrap_or_default());
            self.faults.push(
                Fault::new(
                    "scene::wrong_unit",
                    format!("in {}, `{name}` takes a pure number or an angle, not a value in {unit}", site.what),
                    site.text.part(tree.start, tree.end),
                )
                .label(format!("in {unit}"))
                .help(format!("divide by a number or parameter of the same unit: `{name}(x/0.01)`")),
            );
        }
        dimension::returned(function, known)
    }

    /// The common unit of two values; a fault if they have none.
    fn join(&mut self, a: KnownUnit, b: KnownUnit, how: &str, tree: &SyntaxTree, site: Site<'_>) -> KnownUnit {
        dimension::join(a, b).unwrap_or_else(|(a, b)| {
            let (first, second) = if how == "added to" || how == "subtracted from" { (b, a) } else { (a, b) };
            self.faults.push(
                Fault::new(
                    "scene::wrong_unit",
                    format!(
                        "in {}, a value in {} is {how} a value in {}",
                        site.what,
                        unit_name(first),
                        unit_name(second)
                    ),
                    site.text.part(tree.start, tree.end),
                )
                .label(format!("{} and {}", unit_name(a), unit_name(b)))
                .help("check the units of the parameters, and the parentheses"),
            );
            KnownUnit::Nothing
        })
    }

    fn lower_name(&mut self, name: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let variable = self.own_variable(name, site.context);
        match self.named(name) {
            Some(named) if named.is_number() && variable.is_some() => self.refuse(
                "scene::ambiguous_name",
                format!(
                    "in {}, `{name}` is both the {}'s own and {} of the scene",
                    site.what,
                    if let Context::Curve(_) = site.context { "joint" } else { "load" },
                    one(named.word())
                ),
                &format!("rename the {}", named.word()),
                (tree, site),
            ),
            Some(Named::Parameter(index)) => {
                self.used_parameters.insert(index);
                let meaning = &self.parameters[index];
                // What it cannot be calculated from has its fault already.
                let is_unknown = constant::number(&meaning.formula).is_some_and(f64::is_nan);
                let known = KnownUnit::constant(meaning.unit).in_hertz(meaning.hertz);
                (!is_unknown).then(|| (meaning.formula.clone(), known))
            }
            Some(Named::Input(_)) if site.context.is_constant() => {
                self.not_constant(&format!("the input `{name}`"), tree, site)
            }
            Some(Named::Input(id)) => {
                self.used_inputs.insert(id);
                let unit = self.input_units.get(id.0).copied().flatten();
                let (exponents, hertz) = unit.unzip();
                Some((Formula::Input(id), KnownUnit::moving(exponents).in_hertz(hertz.unwrap_or(0))))
            }
            Some(Named::State(_)) if site.context.is_constant() => {
                self.not_constant(&format!("the state `{name}`"), tree, site)
            }
            Some(Named::State(_)) if site.context == Context::Driver => {
                self.refuse_in_driver("state", &format!("the state `{name}`"), tree, site)
            }
            Some(Named::State(id)) => {
                self.used_states.insert(id);
                let unit = self.state_units.get(id.0).copied().flatten();
                let (exponents, hertz) = unit.unzip();
                Some((Formula::State(id), KnownUnit::moving(exponents).in_hertz(hertz.unwrap_or(0))))
            }
            Some(Named::Sampled(_)) if site.context.is_constant() => {
                self.not_constant(&format!("the sampled value `{name}`"), tree, site)
            }
            Some(Named::Sampled(_)) if site.context == Context::Driver => {
                self.refuse_in_driver("sampled value", &format!("the sampled value `{name}`"), tree, site)
            }
            Some(Named::Sampled(_)) if site.context == Context::Start => {
                self.refuse_discrete(&format!("`{name}`"), tree, site)
            }
            Some(Named::Sampled(id)) => Some(self.discrete_value(id)),
            Some(Named::Signal(index)) => self.lower_signal(index, name, tree, site),
            _ => match (name, variable) {
                ("pi", _) => Some((Formula::Number(PI), KnownUnit::Number)),
                ("t" | "time", _) if site.context.is_constant() => {
                    self.not_constant(&format!("the time `{name}`"), tree, site)
                }
                ("t" | "time", _) => Some((Formula::Time, KnownUnit::moving(Some(Exponents::SECOND)))),
                (_, Some(variable)) => self.seen_there(variable, tree, site),
                _ if self.scene.event_of_time(name).is_some() => self.lower_event_time(name, tree, site),
                _ if name.contains('.') => self.lower_variable(name, tree, site),
                _ => self.unknown_name(name, tree, site),
            },
        }
    }

    fn discrete_value(&mut self, id: DiscreteId) -> (Formula, KnownUnit) {
        self.used_discrete.insert(id);
        let (exponents, hertz) = self.discrete_units.get(id.0).copied().flatten().unzip();
        (Formula::Discrete(id), KnownUnit::moving(exponents).in_hertz(hertz.unwrap_or(0)))
    }

    /// When an event happened last.
    fn lower_event_time(&mut self, name: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let (_, id) = self.scene.event_of_time(name)?;
        match site.context {
            _ if site.context.is_constant() => self.not_constant(&format!("`{name}`"), tree, site),
            Context::Driver => self.refuse_in_driver("sampled value", &format!("`{name}`"), tree, site),
            Context::Start => self.refuse_discrete(&format!("`{name}`"), tree, site),
            _ => Some(self.discrete_value(id)),
        }
    }

    /// The names of a state and of a discrete variable that occur in a formula.
    fn changing_in(&self, formula: &Formula) -> (Option<String>, Option<String>) {
        let (mut state, mut discrete) = (None, None);
        formula.visit(&mut |part| {
            if let Formula::State(id) = part {
                state = Some(self.state_name(*id));
            } else if let Formula::Discrete(id) = part {
                discrete = discrete.take().or_else(|| self.name_of_discrete(*id));
            }
        });
        (state, discrete)
    }

    fn refuse_discrete(&mut self, used: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let message = format!("{} depends on {used}, whose start value is found at the same time", site.what);
        let help = "use parameters, inputs, and positions, velocities and states at the start";
        self.refuse("scene::begin_depends", message, help, (tree, site))
    }

    /// One side of a comparison of an event.
    pub(super) fn instant_tree(&mut self, tree: &SyntaxTree, text: &Text, what: &str) -> Option<(Formula, KnownUnit)> {
        self.lower(tree, Site { text, what, context: Context::Instant(None) })
    }

    /// The two sides of a comparison must have the same unit.
    pub(super) fn must_compare(&mut self, left: KnownUnit, right: KnownUnit, text: &Text, what: &str) {
        if let Err((a, b)) = dimension::join(left, right) {
            let message =
                format!("in {what}, a value in {} is compared with a value in {}", unit_name(a), unit_name(b));
            let fault = Fault::new("scene::wrong_unit", message, text.span);
            self.faults.push(fault.label(format!("{} and {}", unit_name(a), unit_name(b))));
        }
    }

    /// `length` and `rate` of an actuator, `angle`, `omega` and `alpha` of a torsion actuator, `angle` of a cam.
    fn own_variable(&self, name: &str, context: Context) -> Option<Variable> {
        let (part, section, owner) = match context {
            Context::Law(load) => (self.scene.loads.get(load.0)?, Section::Loads, Owner::Load(load)),
            Context::Curve(joint) => (self.scene.joints.get(joint.0)?, Section::Joints, Owner::Joint(joint)),
            _ => return None,
        };
        let quantities = part.component(section)?.law_variables;
        let quantity = quantities.iter().copied().find(|quantity| quantity.word() == name)?;
        // An angle of the scene may be called `alpha`: it keeps its name.
        let is_taken = quantity == Quantity::Alpha && self.named(name).is_some();
        (!is_taken).then_some(Variable { owner, quantity })
    }

    /// A variable of the load that is read, which its law can use by its full name only.
    fn own_by_its_name(&self, name: &str, site: Site<'_>) -> Option<String> {
        let Context::Law(load) = site.context else { return None };
        let load_name = &self.scene.loads.get(load.0)?.name.text;
        let quantity = *self.find_owner(load_name)?.has.iter().find(|quantity| quantity.word() == name)?;
        let variable = Variable { owner: Owner::Load(load), quantity };
        refusal(variable, site, name).is_none().then(|| format!("{load_name}.{name}"))
    }

    fn lower_variable(&mut self, name: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let text = Text::new(name, site.text.part(tree.start, tree.end));
        let variable = self.variable(&text, site.what, "scene::unknown_variable")?;
        if site.context.is_constant() {
            return self.not_constant(&format!("the variable `{name}`"), tree, site);
        }
        match refusal(variable, site, &format!("`{name}`")) {
            None => self.seen_there(variable, tree, site),
            Some(Dependence { code, message, help }) => self.refuse(code, message, help, (tree, site)),
        }
    }

    fn seen_there(&mut self, variable: Variable, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let seen = self.seen(variable);
        if seen.is_none() {
            let help = "let it depend on variables of joints and springs only";
            self.refuse_place(site.what, site.text.part(tree.start, tree.end), help);
        }
        Some((seen?, KnownUnit::moving(variable.quantity.measure().exponents)))
    }

    /// What a signal is given by; what may not stand there may not come with it.
    fn lower_signal(
        &mut self,
        index: usize,
        name: &str,
        tree: &SyntaxTree,
        site: Site<'_>,
    ) -> Option<(Formula, KnownUnit)> {
        self.used_signals.insert(index);
        if site.context.is_constant() {
            return self.not_constant(&format!("the signal `{name}`"), tree, site);
        }
        let ResolvedSignal { formula, known, .. } = self.signals[index].clone()?;
        let (state, discrete) = self.changing_in(&formula);
        let used = |kind: &str, user: String| format!("the {kind} `{user}` (in signal `{name}`)");
        match (site.context, state, discrete) {
            (Context::Driver, Some(state), _) => {
                return self.refuse_in_driver("state", &used("state", state), tree, site);
            }
            (Context::Driver, None, Some(sampled)) => {
                return self.refuse_in_driver("sampled value", &used("sampled value", sampled), tree, site);
            }
            (Context::Start, _, Some(sampled)) => {
                return self.refuse_discrete(&used("sampled value", sampled), tree, site);
            }
            _ => {}
        }
        let named =
            |variable| format!("`{}` (in signal `{name}`)", self.called.get(&variable).map_or("", String::as_str));
        let mut refused =
            variables(&formula).into_iter().filter_map(|variable| refusal(variable, site, &named(variable)));
        let Some(Dependence { code, message, help }) = refused.next() else { return Some((formula, known)) };
        let span = site.text.part(tree.start, tree.end);
        if !self.is_reported(&Text::new(name, span), name) {
            self.faults.push_about(name, Fault::new(code, message, span).label("not here").help(help));
        }
        None
    }

    fn not_constant(&mut self, used: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let (message, help) = match site.context {
            Context::Curve(_) => (
                format!("{} may depend on the angle of its cam only, but uses {used}", site.what),
                "use `angle`, numbers and parameters",
            ),
            _ => (
                format!("{} must be constant, but uses {used}", site.what),
                "use numbers and parameters; for a varying value use a driver, a force, a torque or an actuator",
            ),
        };
        self.refuse("scene::not_constant", message, help, (tree, site))
    }

    /// A prescribed motion is differentiated twice: the rate of a state may depend on the motion, and discrete variables jump.
    fn refuse_in_driver(
        &mut self,
        kind: &str,
        used: &str,
        tree: &SyntaxTree,
        site: Site<'_>,
    ) -> Option<(Formula, KnownUnit)> {
        let message = format!("{} depends on {used}, but a prescribed motion cannot depend on a {kind}", site.what);
        let help = format!(
            "a driver may use the time `t`, parameters and inputs; let the {kind} act through a force or a torque"
        );
        self.refuse("scene::driver_depends", message, &help, (tree, site))
    }

    fn refuse(
        &mut self,
        code: &'static str,
        message: String,
        help: &str,
        at: (&SyntaxTree, Site<'_>),
    ) -> Option<(Formula, KnownUnit)> {
        let (tree, site) = at;
        let span = site.text.part(tree.start, tree.end);
        self.faults.push(Fault::new(code, message, span).label("not here").help(help));
        None
    }

    fn unknown_name(&mut self, name: &str, tree: &SyntaxTree, site: Site<'_>) -> Option<(Formula, KnownUnit)> {
        let span = site.text.part(tree.start, tree.end);
        if self.is_reported(&Text::new(name, span), name) {
            return None;
        }
        if let Some(named) = self.names.get(name) {
            let has = suggest::list(self.variables_of(name).iter().copied());
            let message = format!("{} uses `{name}` as a number, but it is a {}", site.what, named.word());
            let help = format!(
                "its variables are {has}, to be used like `{name}.{}`",
                self.variables_of(name).first().unwrap_or(&"")
            );
            self.faults
                .push(Fault::new("scene::not_a_number", message, span).label(format!("a {}", named.word())).help(help));
            return None;
        }
        if let Some(variable) = self.own_by_its_name(name, site) {
            let message = format!("{} uses a name that is not in the scene: `{name}`", site.what);
            let fault =
                Fault::new("scene::unknown_name", message, span).label("no such parameter, input, state or signal");
            self.faults.push(fault.help(format!("write `{variable}`: it is a variable of the load itself")));
            return None;
        }
        let mut known = self.names.all(Named::is_number);
        let given = suggest::list(known.iter().copied());
        known.extend(["pi", "t", "time"]);
        known.extend(
            [Quantity::Length, Quantity::Rate, Quantity::Angle, Quantity::Omega, Quantity::Alpha]
                .map(Quantity::word)
                .into_iter()
                .filter(|variable| self.own_variable(variable, site.context).is_some()),
        );
        let otherwise = match given.is_empty() {
            true => format!("give it in `[parameters]`: `{name} = 1.0`"),
            false => format!("the scene has {given}; a new one goes into `[parameters]`"),
        };
        let message = format!("{} uses a name that is not in the scene: `{name}`", site.what);
        let fault = Fault::new("scene::unknown_name", message, span).label("no such parameter, input, state or signal");
        self.faults.push_about(name, fault.help(suggest::hint(name, known, otherwise)));
        None
    }
}

/// What is wrong with a formula that depends on something that it may not depend on.
struct Dependence {
    code: &'static str,
    message: String,
    help: &'static str,
}

/// Why a formula may not depend on a variable that is called so.
fn refusal(variable: Variable, site: Site<'_>, called: &str) -> Option<Dependence> {
    let what = site.what;
    let (code, help) = match site.context {
        Context::Output | Context::Instant(_) => return None,
        Context::Constant | Context::Curve(_) | Context::Driver => {
            let message = format!("{what} depends on {called}, but a prescribed motion cannot depend on the motion");
            let help = "a driver may use the time `t`, parameters and inputs";
            return Some(Dependence { code: "scene::driver_depends", message, help });
        }
        Context::Law(_) => (
            "scene::load_depends",
            "a load may depend on positions, velocities, accelerations, reactions, forces along springs and actuators, torques of loads, states, the time `t`, parameters and inputs",
        ),
        Context::Level => (
            "scene::load_depends",
            "a friction limit may depend on positions, velocities, states, sampled values, the time `t`, parameters and inputs; for friction in proportion to a normal force give `mu`",
        ),
        Context::Start => (
            "scene::begin_depends",
            "the start of a sampled value may depend on positions, velocities and states at the start, the time `t`, parameters and inputs",
        ),
        Context::Rate => (
            "scene::rate_depends",
            "the rate of a state may depend on states, positions, velocities, accelerations, reactions, forces along springs and actuators, torques of loads, the time `t`, parameters and inputs",
        ),
    };
    let is_own = matches!(site.context, Context::Law(load) if variable.owner == Owner::Load(load));
    let refused = match (variable.quantity.class(), variable.owner, variable.quantity) {
        (Class::Position | Class::Velocity | Class::State, ..) => return None,
        (Class::Effort, ..) if is_own => {
            let message = format!("{what} depends on itself: {called}");
            let help = "a load may depend on positions and velocities";
            return Some(Dependence { code: "scene::cycle", message, help });
        }
        (Class::Acceleration, ..) | (Class::Effort, Owner::Joint(_) | Owner::Driver(_), _)
            if matches!(site.context, Context::Law(_) | Context::Rate) =>
        {
            return None;
        }
        (Class::Acceleration, ..) => "an acceleration",
        (Class::Effort, ..) if site.context == Context::Level => "a force or torque, which may depend on it",
        (Class::Effort, ..) if site.context == Context::Start => "a force or torque, which may depend on it",
        // Their laws are written out in its place.
        (Class::Effort, Owner::Load(_), Quantity::Force | Quantity::Torque) => return None,
        (Class::Effort, Owner::Load(_), _) => "a component or the power of another load",
        (Class::Effort, ..) => "a reaction",
        (Class::Contact, ..) => "a result of impacts",
        (Class::System, ..) => "a sum over the whole system",
    };
    Some(Dependence { code, message: format!("{what} depends on {called}, {refused}"), help })
}

fn unit_name(exponents: Exponents) -> String {
    let name = from_exponents(exponents).si;
    if name.is_empty() { "no unit".to_string() } else { format!("`{name}`") }
}

/// The formula of an expression without names.
#[cfg(test)]
pub(crate) fn formula_of_numbers(text: &str) -> Option<Formula> {
    let scene = crate::scene::Scene::new("test");
    let mut faults = crate::diagnostic::fault::Sink::default();
    let names = super::SceneNames::collect(&scene, &mut faults);
    let mut resolver = Resolver::new(&scene, names, &mut faults);
    resolver.expression(&Text::from(text), "test", Context::Constant).map(|(formula, _)| formula)
}
