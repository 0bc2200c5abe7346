//! Quantities to formulas: numbers and units to SI, and checks of the values.

use std::f64::consts::TAU;

use cotree_fmu::program::domain::Limit;

use super::calculated::Meaning;
use super::context::Context;
use super::{Resolver, UNKNOWN};
use crate::diagnostic::degrees;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::metres;
use crate::diagnostic::span::{Span, Text};
use crate::expr::{Binary, Function};
use crate::model::measure::{
    ANGLE, ANGULAR_VELOCITY, DAMPING, INERTIA, LENGTH, STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS, Wanted,
};
use crate::model::{Bound, Exponents, Formula, Range, Unit};
use crate::scene::constant;
use crate::scene::dimension::KnownUnit;
use crate::scene::expression::{self, SyntaxKind, SyntaxTree, shortened};
use crate::scene::model::Vector;
use crate::scene::quantity::{Quantity, QuantityReading, Value, read};
use crate::scene::unit::from_exponents;
use crate::typeset::counted;

/// What says whether turns or radians are meant.
pub(super) const FACTOR: &str =
    "write the unit as `rev/s`, `rpm` or `rad/s`, or a factor before it: `2*pi*frequency*t`";

/// A formula and what is known of its unit.
pub(super) struct ReadFormula {
    pub formula: Formula,
    /// None if it is not known.
    pub unit: Option<Unit>,
    /// If it is not, whether the formula is made of numbers alone.
    pub known: KnownUnit,
}

impl ReadFormula {
    /// The formula of a text that cannot be read.
    const UNKNOWN: ReadFormula = ReadFormula { formula: UNKNOWN, unit: None, known: KnownUnit::Nothing };
}

impl Resolver<'_> {
    /// A formula of numbers and parameters, finite at their default values.
    pub(super) fn constant(&mut self, quantity: &Quantity, what: &str, wanted: &Wanted) -> Formula {
        let formula = self.formula(quantity, what, wanted, Context::Constant);
        self.check_finite(formula, quantity, what)
    }

    /// A constant within a range, at the default parameters; at others the runtime sees to it.
    pub(super) fn constant_in(&mut self, range: Range, quantity: &Quantity, what: &str, wanted: &Wanted) -> Formula {
        let formula = self.constant(quantity, what, wanted);
        self.keep_in(range, formula, quantity, what, wanted)
    }

    /// As [`Self::constant_in`], of a formula that may not be finite either.
    pub(super) fn check_positive(
        &mut self,
        formula: Formula,
        quantity: &Quantity,
        what: &str,
        wanted: &Wanted,
    ) -> Formula {
        let formula = self.check_finite(formula, quantity, what);
        self.keep_in(Range::Positive, formula, quantity, what, wanted)
    }

    /// A formula within a range, at the default parameters; at others the runtime sees to it.
    pub(super) fn keep_in(
        &mut self,
        range: Range,
        formula: Formula,
        quantity: &Quantity,
        what: &str,
        wanted: &Wanted,
    ) -> Formula {
        let (value, is_number) = (self.value(&formula), constant::number(&formula).is_some());
        if !value.is_nan() && !range.permits(value) {
            let by_default = if is_number { "" } else { " with the default parameters" };
            let unit = if wanted.si.is_empty() { String::new() } else { format!(" {}", wanted.si) };
            // Adding zero makes a negative zero positive.
            let value = value + 0.0;
            let (code, message, label) = match range {
                Range::NotNegative => (
                    "scene::negative",
                    format!("{what} is negative: {value}{unit}{by_default}"),
                    "must not be negative",
                ),
                Range::Any | Range::Positive | Range::NotZero | Range::Share | Range::FromOne => {
                    let rule = match range {
                        Range::NotZero => "must not be zero",
                        Range::Share => "must be from 0 to 1",
                        Range::FromOne => "must be 1 or more",
                        Range::Any | Range::Positive | Range::NotNegative => "must be positive",
                    };
                    ("scene::out_of_range", format!("{what} {rule}, but is {value}{unit}{by_default}"), rule)
                }
            };
            let fault = Fault::new(code, message, quantity.span).label(label);
            self.faults.push(match positive(quantity).filter(|_| is_number && value < 0.0) {
                Some(positive) => fault.help(format!("write `{positive}`")),
                None => fault,
            });
        }
        if let Some(limit) = range.limit() {
            self.keep_within(what.to_string(), &formula, limit);
        }
        formula
    }

    /// A value that has to keep to a limit whatever the parameters are.
    pub(super) fn keep_within(&mut self, name: String, value: &Formula, limit: Limit) {
        if constant::number(value).is_none() {
            self.bounds.push(Bound { name, value: value.clone(), limit });
        }
    }

    /// The value of a constant formula at the default parameters.
    pub(super) fn value(&self, formula: &Formula) -> f64 {
        constant::evaluate(formula, &self.values)
    }

    pub(super) fn number(&mut self, quantity: &Quantity, what: &str, wanted: &Wanted) -> f64 {
        let formula = self.constant(quantity, what, wanted);
        self.value(&formula)
    }

    pub(super) fn formula(&mut self, quantity: &Quantity, what: &str, wanted: &Wanted, context: Context) -> Formula {
        self.formula_and_unit(quantity, what, wanted, context).0
    }

    /// A formula and its unit if that is known.
    pub(super) fn formula_and_unit(
        &mut self,
        quantity: &Quantity,
        what: &str,
        wanted: &Wanted,
        context: Context,
    ) -> (Formula, Option<Unit>) {
        let ReadFormula { formula, unit, .. } = self.formula_and_known(quantity, what, wanted, context);
        (formula, unit)
    }

    /// A formula with all that is known of its unit.
    pub(super) fn formula_and_known(
        &mut self,
        quantity: &Quantity,
        what: &str,
        wanted: &Wanted,
        context: Context,
    ) -> ReadFormula {
        let text = match &quantity.value {
            Value::Number(number) => {
                self.suspect_bare(*number, what, wanted, quantity.span);
                let formula = self.finite(*number, what, quantity.span);
                return ReadFormula { formula, unit: None, known: KnownUnit::Number };
            }
            Value::Text(text) => Text::new(text.as_str(), quantity.span),
        };
        if text.text.trim().is_empty() {
            self.faults.push(
                Fault::new("scene::bad_expression", format!("{what} is empty"), quantity.span)
                    .label("a number, a number with a unit, or an expression is wanted"),
            );
            return ReadFormula::UNKNOWN;
        }
        match read(&text) {
            Err(fault) => {
                self.faults.push(fault);
                ReadFormula::UNKNOWN
            }
            Ok(QuantityReading::Number(number)) => {
                self.suspect_bare(number, what, wanted, quantity.span);
                ReadFormula { formula: self.finite(number, what, quantity.span), unit: None, known: KnownUnit::Number }
            }
            Ok(QuantityReading::Measure(value, unit)) => {
                self.check_measure(&unit, &text, what, wanted);
                self.written_in.add(unit.clone());
                let known = KnownUnit::constant(Some(unit.exponents));
                ReadFormula { formula: self.finite(value, what, quantity.span), unit: Some(unit), known }
            }
            Ok(QuantityReading::Expression) => {
                let Some((formula, known)) = self.expression(&text, what, context) else {
                    return ReadFormula::UNKNOWN;
                };
                self.check_unit(known, what, wanted, quantity.span, context);
                self.suspect_table(&text, what, wanted);
                if !text.text.contains('[') {
                    self.suspect_turns(&formula, what, wanted, quantity.span);
                }
                let formula = match constant::number(&formula) {
                    Some(number) => self.finite(number, what, quantity.span),
                    None => formula,
                };
                if let (Formula::Parameter(_), KnownUnit::Nothing) = (&formula, known) {
                    self.suspect_bare(self.value(&formula), what, wanted, quantity.span);
                }
                ReadFormula { formula, unit: known.unit().map(from_exponents), known }
            }
        }
    }

    /// Warns of a bare angle that is a usual number of degrees: as radians it would be many turns; and of bare lengths that are too large for metres, once for all of them.
    fn suspect_bare(&mut self, number: f64, what: &str, wanted: &Wanted, span: Span) {
        if wanted.exponents == ANGLE.exponents && degrees::is_usual(number) {
            self.faults.push(degrees::warning(what, number, span));
        }
        let is_long = wanted.exponents == LENGTH.exponents && metres::is_unusual(number);
        if is_long && !self.faults.again(metres::SUBJECT, span) {
            self.faults.push_about(metres::SUBJECT, metres::warning(what, number, span));
        }
    }

    /// Warns of an angle that is read from a table whose second column has no unit and looks like degrees.
    fn suspect_table(&mut self, text: &Text, what: &str, wanted: &Wanted) {
        if wanted.exponents != ANGLE.exponents {
            return;
        }
        let Ok(SyntaxTree { kind: SyntaxKind::Table(_, file, _), .. }) = expression::parse(text) else { return };
        let Some(table) = self.table(&file, text.span).filter(|table| table.units[1].is_none()) else { return };
        if let Some(angle) = degrees::among(&table.y) {
            let what = format!("{what}, from the second column of `{file}`,");
            self.faults.push(degrees::of_column(&what, "angle", angle, text.span));
        }
    }

    /// Warns of an angle that is a usual number of degrees times the time.
    fn suspect_turns(&mut self, formula: &Formula, what: &str, wanted: &Wanted, span: Span) {
        let Formula::Call(Function::Two(Binary::Multiply), sides) = formula else { return };
        let ([Formula::Number(number), Formula::Time] | [Formula::Time, Formula::Number(number)]) = sides[..] else {
            return;
        };
        let usual = number.abs() >= 90.0 && number % 45.0 == 0.0;
        if usual && wanted.exponents == ANGLE.exponents {
            let message = format!("{what} grows by {number} rad/s, {:.1} turns per second", number / TAU);
            let fault = Fault::warning("scene::degrees", message, span).label("degrees?");
            self.faults
                .push(fault.help(format!("write `{number}[deg]*t` for degrees, or `{number}[rad]*t` for radians")));
        }
    }

    /// Warns of a stiffness or damping below zero: the motion then grows by itself.
    pub(super) fn suspect_growth(&mut self, formula: &Formula, what: &str, wanted: &Wanted, span: Span) {
        let value = self.value(formula);
        let effect = match wanted.exponents {
            known if [STIFFNESS, TORSION_STIFFNESS].iter().any(|stiffness| stiffness.exponents == known) => {
                "it pushes away from equilibrium instead of back"
            }
            known if [DAMPING, TORSION_DAMPING].iter().any(|damping| damping.exponents == known) => {
                "it adds energy instead of dissipating it"
            }
            _ => return,
        };
        if value < 0.0 {
            let message = format!("{what} is negative, {value} {}: {effect}", wanted.si);
            let fault = Fault::warning("scene::negative", message, span).label("below zero");
            self.faults.push(fault.help("remove the minus sign, unless an unstable motion is meant"));
        }
    }

    pub(super) fn finite(&mut self, number: f64, what: &str, span: Span) -> Formula {
        if number.is_finite() {
            return Formula::Number(number);
        }
        self.faults.push(
            Fault::new("scene::not_finite", format!("{what} is not a finite number"), span)
                .label(format!("this is {number}")),
        );
        UNKNOWN
    }

    /// A constant formula must have a value at the default parameters.
    pub(super) fn check_finite(&mut self, formula: Formula, quantity: &Quantity, what: &str) -> Formula {
        let is_number = constant::number(&formula).is_some();
        let value = self.value(&formula);
        if is_number || !self.values_are_known() || value.is_finite() {
            return formula;
        }
        self.faults.push(
            Fault::new(
                "scene::not_finite",
                format!("{what} is not a finite number with the default parameters"),
                quantity.span,
            )
            .label(format!("this is {value}")),
        );
        UNKNOWN
    }

    /// Has every parameter a value, or has one of them a fault, which spoils the values of the others?
    fn values_are_known(&self) -> bool {
        let is_known = |meaning: &Meaning| constant::number(&meaning.formula).is_none_or(f64::is_finite);
        self.values.iter().all(|value| value.is_finite()) && self.parameters.iter().all(is_known)
    }

    fn check_measure(&mut self, unit: &Unit, text: &Text, what: &str, wanted: &Wanted) {
        let Some(exponents) = wanted.exponents else {
            return;
        };
        if !unit.exponents.is_compatible(exponents) {
            self.wrong_unit(unit.shown(), what, wanted, text.span, "a bare number is taken as SI");
        } else if exponents == ANGULAR_VELOCITY.exponents.unwrap_or_default() && text.text.contains("Hz") {
            // 1 Hz is one turn per second to some and one radian per second to others.
            self.open_hertz(&format!("{what} is {}", wanted.what), text.span, "write `rev/s`, `rpm` or `rad/s`");
        }
    }

    /// Refuses an angle, or a rate of one, that is made of hertz.
    pub(super) fn open_hertz(&mut self, what: &str, span: Span, help: &str) {
        let fault = Fault::new(
            "scene::wrong_unit",
            format!("{what}, but `Hz` does not say whether of turns or of radians"),
            span,
        );
        self.faults.push(fault.label("turns or radians?").help(help));
    }

    /// The unit of an expression against the wanted one. Where the time may occur, seconds pass: an angle of `t`.
    pub(super) fn check_unit(&mut self, known: KnownUnit, what: &str, wanted: &Wanted, span: Span, context: Context) {
        let (Some(exponents), Some(unit)) = (wanted.exponents, known.unit()) else {
            return;
        };
        let is_time = unit == Exponents::SECOND && context != Context::Constant;
        let is_mass_written_out = known.is_area_times_number() && Some(exponents) == INERTIA.exponents;
        if known.hertz() != 0 && unit.is_compatible(exponents) && wanted.is_turning() {
            self.open_hertz(&format!("{what} is {}", wanted.what), span, FACTOR);
        } else if !unit.is_compatible(exponents) && !is_time && !is_mass_written_out {
            let factors = "a number in an expression may carry its unit: `0.5[m]`";
            self.wrong_unit(&from_exponents(unit).si, what, wanted, span, factors);
        }
    }

    fn wrong_unit(&mut self, found: &str, what: &str, wanted: &Wanted, span: Span, numbers: &str) {
        let found = if found.is_empty() { "a pure number".to_string() } else { format!("in `{found}`") };
        let help = match wanted.si {
            "" => "remove the unit".to_string(),
            si => format!("give {} (SI: `{si}`); {numbers}", wanted.what),
        };
        self.faults.push(
            Fault::new("scene::wrong_unit", format!("{what} must be {}, but is {found}", wanted.what), span)
                .label(format!("not {}", wanted.what))
                .help(help),
        );
    }

    /// The components of a vector; in one dimension the second is absent or zero.
    pub(super) fn vector(&mut self, vector: &Vector, what: &str, wanted: &Wanted, context: Context) -> [Formula; 2] {
        let formulas: Vec<Formula> = vector
            .components
            .iter()
            .take(2)
            .map(|component| {
                let formula = self.formula(component, what, wanted, context);
                if context == Context::Constant { self.check_finite(formula, component, what) } else { formula }
            })
            .collect();
        let count = vector.components.len();
        let mut formulas = formulas.into_iter();
        let (x, y) = (formulas.next().unwrap_or(UNKNOWN), formulas.next());
        if self.one_dimensional() {
            if count == 0 || count > 2 || y.is_some_and(|y| constant::number(&y).is_none_or(|y| y != 0.0)) {
                self.faults.push(
                    Fault::new(
                        "scene::one_dimension",
                        format!("{what} is off the line of this one-dimensional scene"),
                        vector.span,
                    )
                    .label("one component is wanted")
                    .help("write `[x]` or `[x, 0]`"),
                );
            }
            return [x, Formula::Number(0.0)];
        }
        if count != 2 {
            let components = counted(count, "component");
            self.faults.push(
                Fault::new("scene::wrong_value", format!("{what} has {components}, but must have two"), vector.span)
                    .label("x and y are wanted")
                    .help("write `[x, y]`, with decimal points"),
            );
        }
        [x, y.unwrap_or(UNKNOWN)]
    }

    pub(super) fn wording(quantity: &Quantity) -> String {
        match &quantity.value {
            Value::Number(number) => number.to_string(),
            Value::Text(text) => shortened(text),
        }
    }
}

/// A quantity as it is written, without its minus sign.
fn positive(quantity: &Quantity) -> Option<String> {
    match &quantity.value {
        Value::Number(number) => Some(format!("{}", -number)),
        Value::Text(text) => text.trim_start().strip_prefix('-').map(|rest| rest.trim_start().to_owned()),
    }
}
