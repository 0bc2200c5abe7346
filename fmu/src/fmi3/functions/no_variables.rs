//! Values of types that no variable has: any access that is not empty is refused.

use crate::fmi::boundary::plain;
use crate::fmi::component::Refusal;
use crate::fmi3::component::Fmi3;
use crate::fmi3::types::*;

fn refuse(instance: fmi3Instance, call: &'static str, count: usize) -> fmi3Status {
    plain::<Fmi3>(instance, call, |_| match count {
        0 => Ok(()),
        _ => Err(Refusal::new(format!("{call}: all variables of this FMU are of type Float64"))),
    })
}

/// The getter and the setter of a type.
macro_rules! no_variables {
    ($($get:ident, $set:ident: $type:ty;)*) => {$(
        /// There is no variable of this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: fmi3Instance,
            _valueReferences: *const fmi3ValueReference,
            nValueReferences: usize,
            _values: *mut $type,
            nValues: usize,
        ) -> fmi3Status {
            refuse(instance, stringify!($get), nValueReferences.max(nValues))
        }

        /// There is no variable of this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: fmi3Instance,
            _valueReferences: *const fmi3ValueReference,
            nValueReferences: usize,
            _values: *const $type,
            nValues: usize,
        ) -> fmi3Status {
            refuse(instance, stringify!($set), nValueReferences.max(nValues))
        }
    )*};
}

no_variables! {
    fmi3GetFloat32, fmi3SetFloat32: fmi3Float32;
    fmi3GetInt8, fmi3SetInt8: fmi3Int8;
    fmi3GetUInt8, fmi3SetUInt8: fmi3UInt8;
    fmi3GetInt16, fmi3SetInt16: fmi3Int16;
    fmi3GetUInt16, fmi3SetUInt16: fmi3UInt16;
    fmi3GetInt32, fmi3SetInt32: fmi3Int32;
    fmi3GetUInt32, fmi3SetUInt32: fmi3UInt32;
    fmi3GetInt64, fmi3SetInt64: fmi3Int64;
    fmi3GetUInt64, fmi3SetUInt64: fmi3UInt64;
    fmi3GetBoolean, fmi3SetBoolean: fmi3Boolean;
    fmi3GetString, fmi3SetString: fmi3String;
}

/// There is no variable of this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBinary(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _valueSizes: *mut usize,
    _values: *mut fmi3Binary,
    nValues: usize,
) -> fmi3Status {
    refuse(instance, "fmi3GetBinary", nValueReferences.max(nValues))
}

/// There is no variable of this type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBinary(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _valueSizes: *const usize,
    _values: *const fmi3Binary,
    nValues: usize,
) -> fmi3Status {
    refuse(instance, "fmi3SetBinary", nValueReferences.max(nValues))
}

/// There is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetClock(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3Clock,
) -> fmi3Status {
    refuse(instance, "fmi3GetClock", nValueReferences)
}

/// There is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetClock(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3Clock,
) -> fmi3Status {
    refuse(instance, "fmi3SetClock", nValueReferences)
}
