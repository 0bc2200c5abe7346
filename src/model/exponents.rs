//! Exponents of the SI units that all other units are products of.

/// The kind of value that a unit measures: the powers of kilogram, metre, second, radian and ampere that it is the product of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exponents {
    pub kilogram: i8,
    pub metre: i8,
    pub second: i8,
    pub radian: i8,
    pub ampere: i8,
}

impl Exponents {
    /// Those of a pure number.
    pub const NONE: Exponents = Exponents::of([0; 5]);
    pub const KILOGRAM: Exponents = Exponents::of([1, 0, 0, 0, 0]);
    pub const METRE: Exponents = Exponents::of([0, 1, 0, 0, 0]);
    pub const SECOND: Exponents = Exponents::of([0, 0, 1, 0, 0]);
    pub const RADIAN: Exponents = Exponents::of([0, 0, 0, 1, 0]);
    pub const AMPERE: Exponents = Exponents::of([0, 0, 0, 0, 1]);
    pub const HERTZ: Exponents = Exponents::NONE.over(Exponents::SECOND);
    pub const NEWTON: Exponents = Exponents::KILOGRAM.times(Exponents::METRE).over(Exponents::SECOND.squared());
    pub const PASCAL: Exponents = Exponents::NEWTON.over(Exponents::METRE.squared());
    pub const JOULE: Exponents = Exponents::NEWTON.times(Exponents::METRE);
    pub const WATT: Exponents = Exponents::JOULE.over(Exponents::SECOND);
    pub const COULOMB: Exponents = Exponents::AMPERE.times(Exponents::SECOND);
    pub const VOLT: Exponents = Exponents::WATT.over(Exponents::AMPERE);
    pub const OHM: Exponents = Exponents::VOLT.over(Exponents::AMPERE);
    pub const WEBER: Exponents = Exponents::VOLT.times(Exponents::SECOND);
    pub const TESLA: Exponents = Exponents::WEBER.over(Exponents::METRE.squared());
    pub const HENRY: Exponents = Exponents::WEBER.over(Exponents::AMPERE);
    pub const FARAD: Exponents = Exponents::COULOMB.over(Exponents::VOLT);

    const fn of([kilogram, metre, second, radian, ampere]: [i8; 5]) -> Exponents {
        Exponents { kilogram, metre, second, radian, ampere }
    }

    const fn each(self) -> [i8; 5] {
        [self.kilogram, self.metre, self.second, self.radian, self.ampere]
    }

    /// Those of a product of two units; an exponent beyond 127 stays there.
    #[must_use]
    pub const fn times(self, other: Exponents) -> Exponents {
        Exponents {
            kilogram: self.kilogram.saturating_add(other.kilogram),
            metre: self.metre.saturating_add(other.metre),
            second: self.second.saturating_add(other.second),
            radian: self.radian.saturating_add(other.radian),
            ampere: self.ampere.saturating_add(other.ampere),
        }
    }

    /// Those of a quotient of two units; an exponent beyond 127 stays there.
    #[must_use]
    pub const fn over(self, other: Exponents) -> Exponents {
        Exponents {
            kilogram: self.kilogram.saturating_sub(other.kilogram),
            metre: self.metre.saturating_sub(other.metre),
            second: self.second.saturating_sub(other.second),
            radian: self.radian.saturating_sub(other.radian),
            ampere: self.ampere.saturating_sub(other.ampere),
        }
    }

    /// Those of the square of a unit.
    #[must_use]
    pub const fn squared(self) -> Exponents {
        self.times(self)
    }

    /// Those of a product of powers; none if one of them is out of all reason.
    pub(crate) fn product(powers: impl IntoIterator<Item = (Exponents, i32)>) -> Option<Exponents> {
        let mut sums = [0_i32; 5];
        for (exponents, power) in powers {
            for (sum, exponent) in sums.iter_mut().zip(exponents.each()) {
                *sum = sum.checked_add(i32::from(exponent).checked_mul(power)?)?;
            }
        }
        let mut exponents = [0_i8; 5];
        for (exponent, sum) in exponents.iter_mut().zip(sums) {
            *exponent = i8::try_from(sum).ok()?;
        }
        Some(Exponents::of(exponents))
    }

    /// Those of a power; none if they are not whole. The radian counts as a pure number, and so does its root.
    pub(crate) fn raised(self, power: f64) -> Option<Exponents> {
        let raised = |exponent: i8| {
            let raised = f64::from(exponent) * power;
            (raised.fract() == 0.0 && raised.abs() <= f64::from(i8::MAX)).then_some(raised as i8)
        };
        Some(Exponents {
            kilogram: raised(self.kilogram)?,
            metre: raised(self.metre)?,
            second: raised(self.second)?,
            radian: if (f64::from(self.radian) * power).fract() == 0.0 { raised(self.radian)? } else { 0 },
            ampere: raised(self.ampere)?,
        })
    }

    #[must_use]
    pub(crate) fn without_radian(self) -> Exponents {
        Exponents { radian: 0, ..self }
    }

    #[must_use]
    pub(crate) fn without_second(self) -> Exponents {
        Exponents { second: 0, ..self }
    }

    /// May two values with these exponents be added? The radian counts as a pure number.
    pub(crate) fn is_compatible(self, other: Exponents) -> bool {
        self.without_radian() == other.without_radian()
    }

    /// The SI units with their exponents, without those that are zero.
    pub(crate) fn powers(self) -> impl Iterator<Item = (&'static str, i8)> {
        ["kg", "m", "s", "rad", "A"].into_iter().zip(self.each()).filter(|(_, power)| *power != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::Exponents;

    #[test]
    fn electrical_units_are_made_of_mechanical_ones_and_the_ampere() {
        let powers = |exponents: Exponents| exponents.powers().collect::<Vec<_>>();
        assert_eq!(powers(Exponents::VOLT), [("kg", 1), ("m", 2), ("s", -3), ("A", -1)]);
        assert_eq!(powers(Exponents::OHM), [("kg", 1), ("m", 2), ("s", -3), ("A", -2)]);
        assert_eq!(powers(Exponents::HENRY), [("kg", 1), ("m", 2), ("s", -2), ("A", -2)]);
        assert_eq!(powers(Exponents::FARAD), [("kg", -1), ("m", -2), ("s", 4), ("A", 2)]);
        assert_eq!(powers(Exponents::TESLA), [("kg", 1), ("s", -2), ("A", -1)]);
        assert_eq!(Exponents::WEBER, Exponents::JOULE.over(Exponents::AMPERE), "a torque by a current");
    }

    #[test]
    fn exponents_out_of_all_reason_are_none() {
        let nine = |times: usize| Exponents::product((0..times).map(|_| (Exponents::METRE, 9)));
        assert_eq!((nine(14).map(|exponents| exponents.metre), nine(15)), (Some(126), None));
        assert_eq!(Exponents::METRE.squared().raised(0.5), Some(Exponents::METRE));
        assert_eq!(Exponents::METRE.raised(0.5), None);
        assert_eq!(Exponents::RADIAN.raised(0.5), Some(Exponents::NONE));
        assert_eq!(Exponents::METRE.raised(f64::NAN), None);
    }
}
