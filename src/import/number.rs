//! Numbers of PMKS+: digits to the base 64 that an address may have, thousandths, a leading `0` for a sign. And what else an address does to a text.

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

/// Is the last letter the one that the length of the rest asks for? The length is that of JavaScript, in units of UTF-16.
pub fn is_whole(text: &str) -> bool {
    const LETTERS: usize = 62;
    let Some(last) = text.chars().last() else { return false };
    let length = text.encode_utf16().count() - last.len_utf16();
    DIGITS.chars().nth(length % LETTERS) == Some(last)
}

/// The text that a part of an address stands for: `%20` is a blank. What is no such code stays.
pub fn unescaped(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after.split_at_checked(2).and_then(|(code, after)| {
            let code =
                std::str::from_utf8(code).ok().filter(|code| code.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
            Some((u8::from_str_radix(code, 16).ok()?, after))
        });
        let (byte, after) = code.filter(|_| first == b'%').unwrap_or((first, after));
        bytes.push(byte);
        rest = after;
    }
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_owned())
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

    #[test]
    fn codes_of_addresses_are_letters() {
        assert_eq!(unescaped("Tie%20rod%2c K%C3%BCrbel"), "Tie rod, Kürbel");
        for same in ["100%", "5%2", "%zz", "%+1", "%C3"] {
            assert_eq!(unescaped(same), same);
        }
    }
}
