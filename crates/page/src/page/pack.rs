//! Data inside a page: compressed bytes as letters, and text that cannot end the element it is in.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Bytes as a zlib stream (RFC 1950) in base64 (RFC 4648); nothing for no bytes.
pub fn packed(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return String::new();
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    // Writing to a vector cannot fail.
    let done = encoder.write_all(bytes).and_then(|()| encoder.finish());
    base64(&done.unwrap_or_default())
}

/// Columns of samples of a motion as bytes that a compressor makes small, without a loss: bits as whole numbers, of these the third differences, which are small where a motion is smooth, with their signs as the
/// lowest bits; first the lowest bytes of all columns, then the next ones. A run of forty loops takes 0.5 MB, not 2.2.
pub fn smooth_columns(columns: &[Vec<f32>]) -> Vec<u8> {
    let differences = |column: &Vec<f32>| {
        let mut bits: Vec<u32> = column.iter().map(|value| value.to_bits()).collect();
        for _ in 0..3 {
            (1..bits.len()).rev().for_each(|sample| bits[sample] = bits[sample].wrapping_sub(bits[sample - 1]));
        }
        bits.into_iter().map(|difference| difference << 1 ^ (difference.cast_signed() >> 31).cast_unsigned())
    };
    let all: Vec<u32> = columns.iter().flat_map(differences).collect();
    (0..4).flat_map(|place| all.iter().map(move |number| number.to_le_bytes()[place])).collect()
}

fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |place: usize| u32::from(group.get(place).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place > group.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

/// JSON that means the same to a parser and nothing to HTML.
pub fn inert(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        for (bytes, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn hostile_text_stays_text() {
        let json = serde_json::to_string("</script><script>alert(1)</script><!--").unwrap();
        let inert = inert(&json);
        assert!(!inert.contains('<'), "{inert}");
        assert_eq!(serde_json::from_str::<String>(&inert).unwrap(), "</script><script>alert(1)</script><!--");
    }
}
