//! Equations of a scene, as the commands write them.

use cotree::diagnostic::{Fault, Faults, Span};
use cotree::equations::{Equations, RowKind};
use cotree::expr::{Expr, Symbol};
use cotree::formulate::explain::size::check_written;
use cotree::formulate::{Formulated, formulate};
use cotree::network::Origin;
use cotree::scene::Scene;

use crate::{Prose, SymbolNotation, code};

/// How equations are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquationFormat {
    /// For people.
    Text,
    /// A LaTeX document.
    Latex,
    /// A self-contained HTML page.
    Html,
    /// C99 source.
    C,
    /// Fortran 2008 source.
    Fortran,
    /// Rust source.
    Rust,
    /// Python source, for numpy.
    Python,
    /// Names, and formulas as text and as trees, for other programs.
    Json,
}

impl EquationFormat {
    /// The words for them, and what each means.
    pub const WORDS: [(&'static str, &'static str, Self); 8] = [
        ("text", "For people", Self::Text),
        ("latex", "A LaTeX document", Self::Latex),
        ("html", "A self-contained HTML page", Self::Html),
        ("c", "C99 source", Self::C),
        ("fortran", "Fortran 2008 source", Self::Fortran),
        ("rust", "Rust source", Self::Rust),
        ("python", "Python source, for numpy", Self::Python),
        ("json", "Names, and formulas as text and as trees, for other programs", Self::Json),
    ];
}

/// The equations of a scene.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn equations(scene: &Scene, notation: EquationFormat) -> Result<String, Faults> {
    let resolved = scene.resolve()?;
    let text =
        formulate(&resolved.mechanism, &resolved.outputs).and_then(|mut formulated| written(&mut formulated, notation));
    text.map_err(|errors| resolved.refused(&scene.source, errors))
}

/// How a scene derives its equations, as a lesson.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn steps(scene: &Scene, prose: Prose) -> Result<String, Faults> {
    let resolved = scene.resolve()?;
    let text =
        formulate(&resolved.mechanism, &resolved.outputs).and_then(|mut formulated| derived(&mut formulated, prose));
    text.map_err(|errors| resolved.refused(&scene.source, errors))
}

/// Equations that have been formulated, in a notation.
///
/// # Errors
/// They are too large to be written.
pub fn written(formulated: &mut Formulated, notation: EquationFormat) -> Result<String, Vec<Fault>> {
    check(&formulated.equations)?;
    let Formulated { equations, lowered, redundant, .. } = formulated;
    let language: &dyn code::Language = match notation {
        EquationFormat::C => &code::C,
        EquationFormat::Fortran => &code::Fortran,
        EquationFormat::Rust => &code::Rust,
        EquationFormat::Python => &code::Python,
        EquationFormat::Text => return Ok(crate::motion(equations, Prose::Text)),
        EquationFormat::Latex => return Ok(crate::motion(equations, Prose::Latex)),
        EquationFormat::Html => return Ok(crate::motion(equations, Prose::Html)),
        EquationFormat::Json => return Ok(crate::json(equations)),
    };
    if let Some(fault) = without_code(equations, &lowered.solved) {
        return Err(vec![fault]);
    }
    Ok(code::code(equations, &lowered.solved, redundant, language))
}

/// Whether equations can be written.
fn check(equations: &Equations) -> Result<(), Vec<Fault>> {
    check_written(equations)?;
    let Some(contact) = equations.first_led().map(|index| &equations.system.mechanism.contacts[index]) else {
        return Ok(());
    };
    let message = format!(
        "`{}` slides, prescribed by drivers: its friction depends on the reactions, and printed equations of a driven motion do not include it",
        contact.name
    );
    let fault = Fault::new("equations::friction", message, contact.span).label("dry friction in a driven motion");
    Err(vec![fault.help("print the equations without this friction; `simulate`, `motion` and FMUs include it")])
}

/// Why there is no code: that of driven mechanisms solves for positions, and knows no states; and friction that sticks has no place in {Q}.
fn without_code(equations: &Equations, solved: &[Expr]) -> Option<Fault> {
    if let Some(contacts) = equations.system.mechanism.contacts.iter().find(|contact| contact.slip.is_some()) {
        let message = format!(
            "`{}` sticks or slides depending on the reactions: functions of positions and rates cannot give its part of Q",
            contacts.name
        );
        let fault = Fault::new("equations::friction", message, contacts.span).label("dry friction that sticks");
        return Some(fault.help(
            "print the equations as `text`, `latex`, `html` or `json`, which list the modes, or export an FMU; with a `velocity` friction is a function of the rates",
        ));
    }
    if let Some(part) = equations.system.mechanism.first_at_profile() {
        let message = format!(
            "`{}` touches a profile: events choose the line or arc of its loop equation, and functions of positions and rates have none",
            part.name
        );
        let fault = Fault::new("equations::modes", message, part.span).label("it touches a profile");
        return Some(fault.help("print the equations as `text`, `latex`, `html` or `json`, or export an FMU"));
    }
    if equations.reads_the_motion() {
        return Some(reads(
            equations,
            "functions of positions and rates cannot give it",
            "print the equations as `text`, `latex`, `html` or `json`, or export an FMU",
        ));
    }
    let state = equations.system.mechanism.states.first()?;
    let driven = solved.is_empty() && !equations.coordinates.is_empty();
    driven.then(|| {
        let message = format!(
            "drivers determine the motion beside the state `{}`: generated code does not support that",
            state.name
        );
        Fault::new("equations::driven_states", message, state.span)
            .label("a state")
            .help("print the equations as `text` or `latex`, or export an FMU")
    })
}

/// Equations that have been formulated, with a name for every number.
///
/// # Errors
/// They are too large to be written.
pub fn named(formulated: &mut Formulated, written: SymbolNotation) -> Result<String, Vec<Fault>> {
    check(&formulated.equations)?;
    Ok(crate::symbols::symbols(&formulated.equations, written))
}

/// The reduced equations in independent coordinates, with a name for every number on request; or why there are none where the motion starts.
///
/// # Errors
/// They are too large to be written, or there are others in each mode.
pub fn reduced(
    formulated: &mut Formulated,
    written: SymbolNotation,
    symbols: bool,
) -> Result<Result<String, crate::SingularStart>, Vec<Fault>> {
    check(&formulated.equations)?;
    if let Some(contact) = formulated.equations.system.mechanism.contacts.first() {
        let what = if contact.slip.is_some() { "sticks or slides" } else { "is a unilateral constraint" };
        let message = format!(
            "`{}` {what}: how many coordinates are independent depends on the mode, and so do the reduced equations",
            contact.name
        );
        let fault = Fault::new("equations::modes", message, contact.span).label("it has modes");
        return Err(vec![fault.help("print the equations without `--minimal`: these include a table of the modes")]);
    }
    if formulated.equations.reads_the_motion() {
        let why = "the reduced equations have no multipliers, so its law would have to be solved for";
        return Err(vec![reads(&formulated.equations, why, "print the equations without `--minimal`")]);
    }
    Ok(crate::minimal(formulated, written, symbols))
}

/// The derivation of equations that have been formulated.
///
/// # Errors
/// They are too large to be written.
pub fn derived(formulated: &mut Formulated, prose: Prose) -> Result<String, Vec<Fault>> {
    check(&formulated.equations)?;
    if formulated.equations.constraints.iter().any(|row| matches!(row.kind, RowKind::LoadValue)) {
        let why = "the lesson solves for accelerations with loads that are known";
        return Err(vec![reads(
            &formulated.equations,
            why,
            "print the equations with `show --equations`, which has its law",
        )]);
    }
    Ok(crate::steps(formulated, prose))
}

/// Something reads accelerations or reactions where it cannot.
fn reads(equations: &Equations, why: &str, help: &str) -> Fault {
    let row = equations.constraints.iter().find(|row| matches!(row.kind, RowKind::LoadValue));
    let (what, span) = match row {
        Some(row) => {
            let element = equations.system.element(row.element);
            let loads = &equations.system.mechanism.loads;
            let load = if let Origin::Load(load) = element.origin { loads.get(load.0) } else { None };
            (format!("load `{}`", element.name), load.map_or_else(Span::default, |load| load.span))
        }
        None => {
            let states = equations.states.iter().zip(&equations.system.mechanism.states);
            let mut reading =
                states.filter(|(rate, _)| equations.system.arena.symbols([**rate]).into_iter().any(Symbol::is_solved));
            reading.next().map_or_else(Default::default, |(_, state)| (format!("state `{}`", state.name), state.span))
        }
    };
    let message = format!("{what} reads an acceleration or a reaction: {why}");
    Fault::new("equations::feedback", message, span).label("reads a reaction or an acceleration").help(help)
}
