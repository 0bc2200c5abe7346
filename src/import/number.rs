//! Numbers of PMKS+: digits to the base 64 that an address may have, thousandths, a leading `0` for a sign.

const DIGITS: &str = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-";

/// An integer; an empty text is none.
pub fn integer(text: &str) -> Option<i64> {
    let (digits, sign) = match text.strip_prefix('0') {
        Some(digits) => (digits, -1),
        None => (text, 1),
    };
    (!text.is_empty()).then(|| value(digits)).flatten().map(|value| sign * value)
}

/// A number with three decimals.
pub fn decimal(text: &str) -> Option<f64> {
    integer(text).map(|value| value as f64 / 1000.0)
}

/// So many flags, the first in the lowest place.
pub fn flags<const N: usize>(text: &str) -> Option<[bool; N]> {
    let value = value(text)?;
    Some(std::array::from_fn(|place| value >> place & 1 == 1))
}

fn value(digits: &str) -> Option<i64> {
    digits.chars().try_fold(0_i64, |value, c| value.checked_mul(64)?.checked_add(DIGITS.find(c)? as i64))
}

/// Is the last letter the one that the length of the rest asks for?
pub fn is_whole(text: &str) -> bool {
    const LETTERS: usize = 62;
    let Some(last) = text.chars().last() else { return false };
    let length = text.chars().count() - 1;
    DIGITS.chars().nth(length % LETTERS) == Some(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_sign_and_three_decimals() {
        assert_eq!(decimal("Fe"), Some(1.0));
        assert_eq!(decimal("0mv"), Some(-3.129));
        assert_eq!(decimal("0"), Some(0.0));
        assert_eq!(integer("K"), Some(20));
        assert_eq!(integer("00"), Some(0));
        for odd in ["", "+", "a b", "zzzzzzzzzzzzzzzz"] {
            assert_eq!(integer(odd), None, "{odd}");
        }
        assert_eq!(flags::<5>("M"), Some([false, true, true, false, true]));
    }
}
