//! Four numbers at a time, every one rounded as if it were alone.

use super::number::Number;

/// Something at each of at most eight places, without a loop: these stand wherever numbers meet, and unrolling them took a third of all compilation.
macro_rules! at_each {
    ($count:ident, $i:ident => $action:expr) => {
        at_each!($count, $i => $action; 0 1 2 3 4 5 6 7)
    };
    ($count:ident, $i:ident => $action:expr; $($place:literal)+) => {
        const { assert!($count <= 8) };
        $(if $place < $count {
            let $i = $place;
            $action;
        })+
    };
}
pub(crate) use at_each;

/// Numbers in a lane.
pub(crate) const WIDTH: usize = 4;

/// Numbers that take part in the same operation: four of plain ones, unless said otherwise.
pub(crate) type Lane<N = f64, const L: usize = WIDTH> = [N; L];

/// Nothing.
pub(crate) const ZERO: Lane = [0.0; WIDTH];

/// Lanes that hold so many numbers.
pub(crate) fn lanes(count: usize) -> usize {
    count.div_ceil(WIDTH)
}

/// One number in every place.
#[inline(always)]
pub(crate) fn splat<N: Copy, const L: usize>(value: N) -> Lane<N, L> {
    [value; L]
}

/// In each place of a lane like this one what an expression says.
macro_rules! each {
    ($of:expr, $i:ident => $value:expr) => {{
        let mut lane = $of;
        at_each!(L, $i => lane[$i] = $value);
        lane
    }};
}

/// a + b
#[inline(always)]
pub(crate) fn add<N: Number, const L: usize>(a: Lane<N, L>, b: Lane<N, L>) -> Lane<N, L> {
    each!(a, i => a[i] + b[i])
}

/// a - b
#[inline(always)]
pub(crate) fn subtract<N: Number, const L: usize>(a: Lane<N, L>, b: Lane<N, L>) -> Lane<N, L> {
    each!(a, i => a[i] - b[i])
}

/// a b
#[inline(always)]
pub(crate) fn multiply<N: Number, const L: usize>(a: Lane<N, L>, b: Lane<N, L>) -> Lane<N, L> {
    each!(a, i => a[i] * b[i])
}

/// c a
#[inline(always)]
pub(crate) fn times<N: Number, const L: usize>(c: f64, a: Lane<N, L>) -> Lane<N, L> {
    each!(a, i => a[i].times(c))
}

/// sum + a b, rounded twice
#[inline(always)]
pub(crate) fn plus<N: Number, const L: usize>(sum: Lane<N, L>, a: Lane<N, L>, b: Lane<N, L>) -> Lane<N, L> {
    each!(sum, i => sum[i] + a[i] * b[i])
}

/// sum - a b, rounded twice
#[inline(always)]
pub(crate) fn minus<N: Number, const L: usize>(sum: Lane<N, L>, a: Lane<N, L>, b: Lane<N, L>) -> Lane<N, L> {
    each!(sum, i => sum[i] - a[i] * b[i])
}

/// The larger magnitudes; NaN stays: the bits of magnitudes are in their order, with NaN above all. Four plain numbers, in one expression: the compiler
/// keeps them together.
#[inline(always)]
pub(crate) fn larger(a: Lane, b: Lane) -> Lane {
    [above(a[0], b[0]), above(a[1], b[1]), above(a[2], b[2]), above(a[3], b[3])]
}

/// The largest magnitude of the four, or NaN.
#[inline(always)]
pub(crate) fn largest(lane: Lane) -> f64 {
    above(above(lane[0], lane[1]), above(lane[2], lane[3]))
}

/// The larger magnitude, or NaN.
#[inline(always)]
pub(crate) fn above(a: f64, b: f64) -> f64 {
    let (a, b) = (a.abs().to_bits() as i64, b.abs().to_bits() as i64);
    f64::from_bits(if b > a { b } else { a } as u64)
}

/// A method that is compiled twice, for AVX2 and for any processor; both give the same bits. Generics stand in brackets.
macro_rules! by_width {
    ($(#[$meta:meta])* $vis:vis fn $name:ident $([$($of:tt)*])? (&mut self: $owner:ty $(, $arg:ident: $type:ty)*) $(-> $result:ty)? = $body:ident) => {
        by_width! { [&mut] [$($($of)*)?] $(#[$meta])* $vis fn $name(self: $owner $(, $arg: $type)*) $(-> $result)? = $body }
    };
    ($(#[$meta:meta])* $vis:vis fn $name:ident $([$($of:tt)*])? (&self: $owner:ty $(, $arg:ident: $type:ty)*) $(-> $result:ty)? = $body:ident) => {
        by_width! { [&] [$($($of)*)?] $(#[$meta])* $vis fn $name(self: $owner $(, $arg: $type)*) $(-> $result)? = $body }
    };
    ([$($by:tt)+] [$($of:tt)*] $(#[$meta:meta])* $vis:vis fn $name:ident(self: $owner:ty $(, $arg:ident: $type:ty)*) $(-> $result:ty)? = $body:ident) => {
        $(#[$meta])*
        $vis fn $name($($by)+ self $(, $arg: $type)*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide<$($of)*>(this: $($by)+ $owner $(, $arg: $type)*) $(-> $result)? {
                    this.$body($($arg),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has AVX2.
                    return unsafe { wide(self $(, $arg)*) };
                }
            }
            self.$body($($arg),*)
        }
    };
}
pub(crate) use by_width;
