//! The operations of tapes, one line each: those of arithmetic by what they are of any registers, functions by their value, their slope and their series.

use serde::{Deserialize, Serialize};

use super::field::{Field, Real};
use super::file::File;
use super::series::Series;
use super::{Instruction, Tape};
use crate::math;

/// Everything that follows from the table. Names of operands are those of the fields of [`super::Instruction`]; of functions `value` is the result, `d` means the
/// derivative along a direction.
macro_rules! operations {
    (
        ($a:ident, $b:ident, $c:ident), ($da:ident, $db:ident, $dc:ident), $value:ident;
        $($simple:ident($($given:ident),+): $said:literal = $result:expr;)+
        ;
        $($name:ident($($operand:ident),+): $words:literal = $of:expr, slope $slope:expr, series $series:expr;)+
    ) => {
        /// What an instruction does. No fused multiply-add: every operation rounds once, so that results have the same bits everywhere.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum Operation {
            $(#[doc = $said] $simple,)+
            /// target = sin a, register c = cos a
            SinCos,
            $(#[doc = $words] $name,)+
        }

        impl Operation {
            /// Every one of them.
            #[cfg(test)]
            pub(super) const ALL: &[Self] = &[$(Self::$simple,)+ Self::SinCos, $(Self::$name),+];

            /// How many of the operands a, b, c it reads.
            pub fn operands(self) -> usize {
                match self {
                    $(Self::$simple => [$(stringify!($given)),+].len(),)+
                    Self::SinCos => 1,
                    $(Self::$name => [$(stringify!($operand)),+].len(),)+
                }
            }

            /// The result of a function.
            #[inline(always)]
            pub(super) fn value(self, [$a, $b, $c]: [f64; 3]) -> f64 {
                match self {
                    $(Self::$name => $of,)+
                    // Arithmetic has its own arm wherever tapes are run.
                    _ => f64::NAN,
                }
            }

            /// Runs instructions that are all this function.
            pub(super) fn run_values<F: File<Value = f64> + ?Sized>(self, instructions: &[Instruction], file: &mut F) {
                match self {
                    $(Self::$name => {
                        for instruction in instructions {
                            $(let $operand = file.get(instruction.$operand);)+
                            file.set(instruction.target, $of);
                        }
                    })+
                    _ => {}
                }
            }

            /// Derivative of the result of a function, given it, the operands and their derivatives.
            #[allow(unused_variables, reason = "no slope needs the third operand")]
            pub(super) fn slope(self, $value: f64, [$a, $b, $c]: [f64; 3], [$da, $db, $dc]: [f64; 3]) -> f64 {
                match self {
                    $(Self::$name => $slope,)+
                    _ => f64::NAN,
                }
            }

            /// Series of the result of a function.
            pub(super) fn series(self, [$a, $b, $c]: [Series; 3]) -> Series {
                match self {
                    $(Self::$name => $series,)+
                    _ => Series::constant(f64::NAN),
                }
            }
        }

        impl Tape {
            /// Runs the tape over a file of registers. What the exporter has put side by side needs no decision for each.
            #[inline(always)]
            pub(super) fn run_over<F: File + ?Sized>(&self, file: &mut F) {
                let mut rest = &self.instructions[..];
                for &count in &self.runs {
                    let (alike, after) = rest.split_at(count as usize);
                    rest = after;
                    match alike[0].operation {
                        $(Operation::$simple => {
                            for instruction in alike {
                                $(let $given = file.get(instruction.$given);)+
                                file.set(instruction.target, $result);
                            }
                        })+
                        Operation::SinCos => Field::run_sines_and_cosines(alike, file),
                        function => Field::run_functions(function, alike, file),
                    }
                }
            }
        }
    };
}

/// slope * direction, but nothing for nothing.
fn chain(slope: f64, direction: f64) -> f64 {
    Real::chain(slope, direction)
}

operations! {
    (a, b, c), (da, db, dc), value;
    Add(a, b): "a + b" = a.add(b);
    Subtract(a, b): "a - b" = a.subtract(b);
    Multiply(a, b): "a * b" = a.multiply(b);
    Divide(a, b): "a / b" = a.divide(b);
    Negate(a): "-a" = a.negate();
    MultiplyAdd(a, b, c): "a * b + c, rounded twice" = a.multiply(b).add(c);
    MultiplySubtract(a, b, c): "a * b - c, rounded twice" = a.multiply(b).subtract(c);
    SubtractProduct(a, b, c): "c - a * b, rounded twice" = c.subtract(a.multiply(b));
    SquareRoot(a): "sqrt a" = a.square_root();
    ;
    Absolute(a): "|a|" = a.abs(), slope chain(math::sign(a), da),
        series a.scale(if a.0[0] == 0.0 { 0.0 } else { math::sign(a.0[0]) });
    Tangent(a): "tan a" = libm::tan(a), slope chain(1.0 + value * value, da),
        series a.map(libm::tan(a.0[0]), |value| value.multiply(value).plus(1.0));
    ArcSine(a): "asin a" = libm::asin(a), slope chain(1.0 / (1.0 - a * a).sqrt(), da),
        series a.map(libm::asin(a.0[0]), |_| a.arc_slope());
    ArcCosine(a): "acos a" = libm::acos(a), slope chain(-1.0 / (1.0 - a * a).sqrt(), da),
        series a.map(libm::acos(a.0[0]), |_| a.arc_slope().scale(-1.0));
    ArcTangent(a): "atan a" = libm::atan(a), slope chain(1.0 / (1.0 + a * a), da),
        series a.map(libm::atan(a.0[0]), |_| Series::constant(1.0).divide(a.multiply(a).plus(1.0)));
    ArcTangent2(a, b): "atan2(a, b)" = libm::atan2(a, b), slope (chain(b, da) - chain(a, db)) / (a * a + b * b),
        series a.arc_tangent(b);
    Exponential(a): "e^a" = libm::exp(a), slope chain(value, da), series a.map(libm::exp(a.0[0]), |value| value);
    Logarithm(a): "ln a" = libm::log(a), slope chain(1.0 / a, da),
        series a.map(libm::log(a.0[0]), |_| Series::constant(1.0).divide(a));
    HyperbolicTangent(a): "tanh a" = libm::tanh(a), slope chain(1.0 - value * value, da),
        series a.map(libm::tanh(a.0[0]), |value| value.multiply(value).scale(-1.0).plus(1.0));
    Power(a, b): "a^b" = libm::pow(a, b),
        slope chain(b * libm::pow(a, b - 1.0), da) + if db == 0.0 { 0.0 } else { value * libm::log(a) * db },
        series a.power(b);
    Sign(a): "-1, 0 or 1" = math::sign(a), slope 0.0, series Series::constant(math::sign(a.0[0]));
    Floor(a): "largest integer not above a" = a.floor(), slope 0.0, series Series::constant(a.0[0].floor());
    Minimum(a, b): "the smaller" = math::minimum(a, b), slope if a < b { da } else { db },
        series if a.0[0] < b.0[0] || a.0[0].is_nan() { a } else { b };
    Maximum(a, b): "the larger" = math::maximum(a, b), slope if a > b { da } else { db },
        series if a.0[0] > b.0[0] || a.0[0].is_nan() { a } else { b };
    Less(a, b): "1 if a < b, else 0" = f64::from(u8::from(a < b)), slope 0.0,
        series Series::constant(f64::from(u8::from(a.0[0] < b.0[0])));
    LessEqual(a, b): "1 if a <= b, else 0" = f64::from(u8::from(a <= b)), slope 0.0,
        series Series::constant(f64::from(u8::from(a.0[0] <= b.0[0])));
    Select(a, b, c): "b if a is not 0, else c" = if a != 0.0 { b } else { c }, slope if a != 0.0 { db } else { dc },
        series if a.0[0] != 0.0 { b } else { c };
    Copy(a): "a, unchanged" = a, slope da, series a;
}
