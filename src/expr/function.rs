//! Every operation that expressions are made of, each in one line of one table: the scene's parser, its units, values, derivatives, printed
//! equations, generated code, tapes and Taylor series all read it.
//!
//! A function that the runtime has no operation for is composed of others.

use cotree_fmu::math;
use cotree_fmu::tape::Operation;

use super::term::{ArenaTerm, build};
use super::{Arena, cam};

/// An operation of `N` operands.
#[derive(Debug)]
pub struct OperationDefinition<const N: usize> {
    /// Its name in scenes and in plain text; an operator's sign.
    pub name: &'static str,
    pub shown: Shown,
    pub units: UnitRule,
    /// Its derivative from operands, their derivatives and its value.
    pub derivative: for<'a> fn([ArenaTerm<'a>; N], [ArenaTerm<'a>; N], ArenaTerm<'a>) -> ArenaTerm<'a>,
    pub run: Evaluation<N>,
}

pub type Composed<const N: usize> = for<'a> fn([ArenaTerm<'a>; N]) -> ArenaTerm<'a>;

#[derive(Clone, Copy, Debug)]
pub enum Evaluation<const N: usize> {
    /// By an operation of its own. Its value; what it is for Taylor series, unless they have an operation for it; and in C, Fortran, Rust and
    /// Python its name, empty if it is the same, or a pattern of the operands `{a}` and `{b}`.
    Own(Operation, fn([f64; N]) -> f64, Option<Composed<N>>, [&'static str; 4]),
    /// In terms of others, there and in all languages.
    As(Composed<N>),
}

#[derive(Clone, Copy, Debug)]
pub enum Shown {
    Command(&'static str),
    Word,
    Between(&'static str, &'static str),
    /// As an operator, a fraction, a root or a power.
    Operator,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitRule {
    Kept,
    Halved,
    /// Any unit, the same of both operands; an angle.
    Bearing,
    /// Any unit; a pure number.
    Dropped,
    /// A pure number; an angle.
    Angle,
    /// A pure number or an angle; a pure number.
    Pure,
}

/// The functions of the scene language, by their numbers of operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    One(Unary),
    Two(Binary),
}

const SAME: [&str; 4] = [""; 4];

macro_rules! operations {
    ($(#[$about:meta])* $kind:ident of $count:literal: $($variant:ident = $name:literal, $shown:expr, $units:ident, $derivative:expr, $run:expr;)*) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $kind {
            $($variant,)*
        }

        impl $kind {
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            pub fn definition(self) -> &'static OperationDefinition<$count> {
                match self {
                    $(Self::$variant => {
                        const LINE: &OperationDefinition<$count> = &OperationDefinition {
                            name: $name, shown: $shown, units: UnitRule::$units, derivative: $derivative, run: $run,
                        };
                        LINE
                    })*
                }
            }
        }
    };
}

use self::Binary::{Atan2, Less, LessEqual};
use self::Unary::{Cosh, Exp, Log, Sign, Sinh, Sqrt, Tanh};
use Evaluation::{As, Own};
use Operation as Op;
use Shown::{Between, Command, Operator, Word};

// Columns: name, shown as, units, derivative; then either the operation of the runtime, the value, what it is for series (unless they have an
// operation for it) and its name or pattern in C, Fortran, Rust and Python (unless the same); or what it is composed of.
operations! {
    Unary of 1:
    Negate = "-", Operator, Kept, |_, [d], _| -d, Own(Op::Negate, |[x]| -x, None, ["-{a}"; 4]);
    Sqrt = "sqrt", Operator, Halved, |_, [d], f| 0.5 / f * d, Own(Op::SquareRoot, |[x]| x.sqrt(), None, SAME);
    Sin = "sin", Command("sin"), Pure, |[x], [d], _| x.cos() * d, Own(Op::SinCos, |[x]| math::sin_cos(x).0, None, SAME);
    Cos = "cos", Command("cos"), Pure, |[x], [d], _| -x.sin() * d, Own(Op::SinCos, |[x]| math::sin_cos(x).1, None, SAME);
    Tan = "tan", Command("tan"), Pure, |_, [d], f| (1.0 + f.square()) * d, Own(Op::Tangent, |[x]| libm::tan(x), Some(|[x]| x.sin() / x.cos()), SAME);
    Asin = "asin", Command("arcsin"), Angle, |[x], [d], _| 1.0 / (1.0 - x.square()).of(Sqrt) * d, Own(Op::ArcSine, |[x]| libm::asin(x), Some(|[x]| x.and(Atan2, (1.0 - x.square()).of(Sqrt))), ["", "", "", "arcsin"]);
    Acos = "acos", Command("arccos"), Angle, |[x], [d], _| -(1.0 / (1.0 - x.square()).of(Sqrt)) * d, Own(Op::ArcCosine, |[x]| libm::acos(x), Some(|[x]| (1.0 - x.square()).of(Sqrt).and(Atan2, x)), ["", "", "", "arccos"]);
    Atan = "atan", Command("arctan"), Angle, |[x], [d], _| 1.0 / (1.0 + x.square()) * d, Own(Op::ArcTangent, |[x]| libm::atan(x), Some(|[x]| x.and(Atan2, x.number(1.0))), ["", "", "", "arctan"]);
    Exp = "exp", Command("exp"), Pure, |_, [d], f| f * d, Own(Op::Exponential, |[x]| libm::exp(x), None, SAME);
    Log = "log", Command("ln"), Pure, |[x], [d], _| 1.0 / x * d, Own(Op::Logarithm, |[x]| libm::log(x), None, ["", "", "ln", ""]);
    Tanh = "tanh", Command("tanh"), Pure, |_, [d], f| (1.0 - f.square()) * d, Own(Op::HyperbolicTangent, |[x]| libm::tanh(x), None, SAME);
    Abs = "abs", Between("|", "|"), Kept, |[x], [d], _| x.of(Sign) * d, Own(Op::Absolute, |[x]| x.abs(), Some(|[x]| x.number(0.0).and(LessEqual, x).select(x, -x)), ["fabs", "", "", ""]);
    Sign = "sign", Word, Dropped, |[x], _, _| x.number(0.0), Own(Op::Sign, |[x]| math::sign(x), None, ["signum({a})", "signum({a})", "signum({a})", ""]);
    Floor = "floor", Between("⌊", "⌋"), Kept, |[x], _, _| x.number(0.0), Own(Op::Floor, |[x]| x.floor(), None, ["", "round_down", "", ""]);
    Sinh = "sinh", Command("sinh"), Pure, |[x], [d], _| x.of(Cosh) * d, As(|[x]| x.of(Tanh) * x.of(Cosh));
    Cosh = "cosh", Command("cosh"), Pure, |[x], [d], _| x.of(Sinh) * d, As(|[x]| 0.5 * (x.of(Exp) + (-x).of(Exp)));
    Smoothstep = "smoothstep", Word, Pure, |[x], [d], _| 6.0 * x.clamp(0.0, 1.0) * (1.0 - x.clamp(0.0, 1.0)) * d, As(|[x]| x.clamp(0.0, 1.0).square() * (3.0 - 2.0 * x.clamp(0.0, 1.0)));
    Harmonic = "harmonic", Word, Pure, |[x], [d], _| cam::harmonic_slope(x) * d, As(cam::harmonic);
    Cycloidal = "cycloidal", Word, Pure, |[x], [d], _| cam::cycloidal_slope(x) * d, As(cam::cycloidal);
    Poly345 = "poly345", Word, Pure, |[x], [d], _| cam::poly345_slope(x) * d, As(cam::poly345);
    Poly4567 = "poly4567", Word, Pure, |[x], [d], _| cam::poly4567_slope(x) * d, As(cam::poly4567);
    ModifiedSine = "modified_sine", Word, Pure, |[x], [d], _| cam::modified_sine_slope(x) * d, As(cam::modified_sine);
    ModifiedTrapezoid = "modified_trapezoid", Word, Pure, |[x], [d], _| cam::modified_trapezoid_slope(x) * d, As(cam::modified_trapezoid);
}

operations! {
    Binary of 2:
    Add = "+", Operator, Kept, |_, [d, e], _| d + e, Own(Op::Add, |[a, b]| a + b, None, ["{a} + {b}"; 4]);
    Subtract = "-", Operator, Kept, |_, [d, e], _| d - e, Own(Op::Subtract, |[a, b]| a - b, None, ["{a} - {b}"; 4]);
    Multiply = "*", Operator, Kept, |[a, b], [d, e], _| d * b + a * e, Own(Op::Multiply, |[a, b]| a * b, None, ["{a} * {b}"; 4]);
    Divide = "/", Operator, Kept, |[_, b], [d, e], f| (d - f * e) / b, Own(Op::Divide, |[a, b]| a / b, None, ["{a} / {b}", "{a} / {b}", "{a} / {b}", "divide"]);
    Power = "^", Operator, Pure, power_derivative, Own(Op::Power, |[a, b]| libm::pow(a, b), Some(|[a, b]| (b * a.of(Log)).of(Exp)), ["pow", "{a}**{b}", "powf", "power"]);
    Atan2 = "atan2", Word, Bearing, |[y, x], [d, e], _| (x * d - y * e) / (y.square() + x.square()), Own(Op::ArcTangent2, |[y, x]| libm::atan2(y, x), None, ["", "", "", "arctan2"]);
    Min = "min", Command("min"), Kept, |[a, b], [d, e], _| a.and(LessEqual, b).select(d, e), Own(Op::Minimum, |[a, b]| math::minimum(a, b), Some(|[a, b]| b.and(LessEqual, a).select(b, a)), ["smaller({a}, {b})", "smaller({a}, {b})", "smaller({a}, {b})", "minimum"]);
    Max = "max", Command("max"), Kept, |[a, b], [d, e], _| a.and(LessEqual, b).select(e, d), Own(Op::Maximum, |[a, b]| math::maximum(a, b), Some(|[a, b]| b.and(LessEqual, a).select(a, b)), ["larger({a}, {b})", "larger({a}, {b})", "larger({a}, {b})", "maximum"]);
    Less = "<", Operator, Dropped, |[a, _], _, _| a.number(0.0), Own(Op::Less, |[a, b]| f64::from(u8::from(a < b)), Some(|[a, b]| a.and(Less, b).select(a.number(1.0), a.number(0.0))), ["{a} < {b} ? 1.0 : 0.0", "merge(1.0_real64, 0.0_real64, {a} < {b})", "f64::from(u8::from({a} < {b}))", "np.float64({a} < {b})"]);
    LessEqual = "<=", Operator, Dropped, |[a, _], _, _| a.number(0.0), Own(Op::LessEqual, |[a, b]| f64::from(u8::from(a <= b)), Some(|[a, b]| a.and(LessEqual, b).select(a.number(1.0), a.number(0.0))), ["{a} <= {b} ? 1.0 : 0.0", "merge(1.0_real64, 0.0_real64, {a} <= {b})", "f64::from(u8::from({a} <= {b}))", "np.float64({a} <= {b})"]);
    Hypot = "hypot", Word, Kept, |[a, b], [d, e], f| (a * d + b * e) / f, As(|[a, b]| (a.square() + b.square()).of(Sqrt));
}

/// d a^b = b a^(b-1) da + a^b ln(a) db
fn power_derivative<'a>([a, b]: [ArenaTerm<'a>; 2], [d, e]: [ArenaTerm<'a>; 2], value: ArenaTerm<'a>) -> ArenaTerm<'a> {
    let base = b * a.power(b - b.number(1.0)) * d;
    if e.is_zero() { base } else { base + value * a.of(Log) * e }
}

impl<const N: usize> OperationDefinition<N> {
    /// Its composition for Taylor series, if they have no operation for it.
    pub fn for_series(&self) -> Option<Composed<N>> {
        match self.run {
            Evaluation::Own(_, _, series, _) => series,
            Evaluation::As(composed) => Some(composed),
        }
    }

    /// How a language writes it: the name of a function, or a pattern of the operands.
    pub fn in_code(&self, language: usize) -> &'static str {
        match self.run {
            Evaluation::Own(.., code) if !code[language].is_empty() => code[language],
            _ => self.name,
        }
    }

    pub fn value(&self, operands: [f64; N]) -> f64 {
        match self.run {
            Evaluation::Own(_, value, ..) => value(operands),
            Evaluation::As(composed) => {
                let mut scratch = Arena::default();
                let operands = operands.map(|operand| scratch.constant(operand));
                let value = build(&mut scratch, operands, composed);
                scratch.as_constant(value).unwrap_or(f64::NAN)
            }
        }
    }
}

impl Function {
    /// All of them: those that are called by a name.
    pub fn all() -> impl Iterator<Item = Function> {
        let one = Unary::ALL.iter().map(|function| Function::One(*function));
        let two = Binary::ALL.iter().map(|function| Function::Two(*function));
        one.chain(two).filter(|function| function.name().starts_with(char::is_alphabetic))
    }

    pub fn named(name: &str) -> Option<Function> {
        Function::all().find(|function| function.name() == name)
    }

    pub fn name(self) -> &'static str {
        match self {
            Function::One(function) => function.definition().name,
            Function::Two(function) => function.definition().name,
        }
    }

    pub fn operands(self) -> usize {
        match self {
            Function::One(_) => 1,
            Function::Two(_) => 2,
        }
    }

    pub fn units(self) -> UnitRule {
        match self {
            Function::One(function) => function.definition().units,
            Function::Two(function) => function.definition().units,
        }
    }

    pub fn shown(self) -> Shown {
        match self {
            Function::One(function) => function.definition().shown,
            Function::Two(function) => function.definition().shown,
        }
    }

    /// Is its name reserved? Composed functions were added later, and their names stay available to older scenes.
    pub fn is_reserved(self) -> bool {
        match self {
            Function::One(function) => matches!(function.definition().run, Own(..)),
            Function::Two(function) => matches!(function.definition().run, Own(..)),
        }
    }

    /// Its value; not a number if operands are missing.
    pub fn value(self, operands: &[f64]) -> f64 {
        let of = |index: usize| operands.get(index).copied().unwrap_or(f64::NAN);
        match self {
            Function::One(function) => function.definition().value([of(0)]),
            Function::Two(function) => function.definition().value([of(0), of(1)]),
        }
    }
}
