//! Types as the calling convention of C sees them.

use std::ffi::c_void;

/// What is passed, as text: two types of the same shape can stand for each other in a call.
pub trait Shape {
    fn shape() -> String;
}

macro_rules! plain {
    ($($type:ty: $shape:literal;)*) => {$(
        impl Shape for $type {
            fn shape() -> String {
                $shape.to_owned()
            }
        }
    )*};
}

plain! {
    (): "void";
    c_void: "void";
    f32: "f32";
    f64: "f64";
    i8: "i8";
    u8: "u8";
    i16: "i16";
    u16: "u16";
    i32: "i32";
    u32: "u32";
    i64: "i64";
    u64: "u64";
    usize: "usize";
    // One byte, 0 or 1: ours is a number, because what an importer takes for true may be any other byte.
    bool: "u8";
    // An enumeration without negative numbers is an unsigned int; the names of the numbers are compared as constants.
    cotree_fmu::fmi2::types::fmi2Status: "u32";
    cotree_fmu::fmi3::types::fmi3Status: "u32";
}

const _: () = assert!(size_of::<cotree_fmu::fmi2::types::fmi2Status>() == 4);
const _: () = assert!(size_of::<cotree_fmu::fmi3::types::fmi3Status>() == 4);

impl<T: Shape> Shape for *const T {
    fn shape() -> String {
        format!("*const {}", T::shape())
    }
}

impl<T: Shape> Shape for *mut T {
    fn shape() -> String {
        format!("*mut {}", T::shape())
    }
}

/// A function that may be missing is a pointer that may be null.
impl<T: Shape> Shape for Option<T> {
    fn shape() -> String {
        T::shape()
    }
}

macro_rules! functions {
    ($($name:ident($($argument:ident)*);)*) => {$(
        impl<R: Shape, $($argument: Shape),*> Shape for unsafe extern "C" fn($($argument),*) -> R {
            fn shape() -> String {
                let arguments: Vec<String> = vec![$($argument::shape()),*];
                format!("fn({}) -> {}", arguments.join(", "), R::shape())
            }
        }

        /// The shape of a function with so many arguments.
        pub fn $name<R: Shape, $($argument: Shape),*>(_: unsafe extern "C" fn($($argument),*) -> R) -> String {
            <unsafe extern "C" fn($($argument),*) -> R>::shape()
        }
    )*};
}

functions! {
    f0();
    f1(A);
    f2(A B);
    f3(A B C);
    f4(A B C D);
    f5(A B C D E);
    f6(A B C D E F);
    f7(A B C D E F G);
    f8(A B C D E F G H);
    f9(A B C D E F G H I);
    f10(A B C D E F G H I J);
    f12(A B C D E F G H I J K L);
}

/// The logger of FMI 2.0 takes as many arguments more as the message has places.
impl<R: Shape, A: Shape, B: Shape, C: Shape, D: Shape, E: Shape> Shape
    for unsafe extern "C" fn(A, B, C, D, E, ...) -> R
{
    fn shape() -> String {
        let arguments = [A::shape(), B::shape(), C::shape(), D::shape(), E::shape()];
        format!("fn({}, ...) -> {}", arguments.join(", "), R::shape())
    }
}

/// The shape of a field, seen through a function that reaches it.
pub fn field<S, T: Shape>(_: fn(&S) -> &T) -> String {
    T::shape()
}

/// The shape of a structure: size, alignment, and where which field lies.
#[macro_export]
macro_rules! structure {
    ($type:ty: $($field:ident)*) => {
        impl $crate::shape::Shape for $type {
            fn shape() -> String {
                let fields: Vec<String> = vec![$(format!(
                    "{}: {} at {}",
                    stringify!($field),
                    $crate::shape::field(|whole: &$type| &whole.$field),
                    std::mem::offset_of!($type, $field)
                )),*];
                format!("{} bytes at {}: {}", size_of::<$type>(), align_of::<$type>(), fields.join(", "))
            }
        }
    };
}
