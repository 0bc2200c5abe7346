//! Text that somebody else wrote, as it may be shown: a terminal obeys control characters, and characters that set the direction of writing make
//! text look like what it is not (Unicode Technical Report 36, 3.1; CVE-2021-42574).

use std::borrow::Cow;
use std::fmt::Write;

/// Does it show as something other than itself?
fn is_hidden(c: char) -> bool {
    let directs = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let separates = matches!(c, '\u{2028}' | '\u{2029}');
    (c.is_control() && !matches!(c, '\n' | '\t')) || directs || separates
}

/// Text for a terminal: what is hidden is written as `\u001b`, as TOML and JSON write it. JSON so changed says the same as before.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 64);
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        // The end of a line as Windows writes it.
        if !is_hidden(c) || (c == '\r' && characters.peek() == Some(&'\n')) {
            shown.push(c);
        } else {
            // Writing to a string cannot fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        }
    }
    shown.into()
}

/// The same on one line: line breaks and tabs do not break the layout around it.
pub(crate) fn on_one_line(text: &str) -> String {
    visible(text).replace('\r', "\\u000d").replace('\n', "\\u000a").replace('\t', "\\u0009")
}

/// The same text with something visible instead of what is hidden, of as many bytes: places in it stay what they are.
pub(crate) fn masked(text: &str) -> Cow<'_, str> {
    let ends_line = |at: usize| text[at..].starts_with("\r\n");
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mask = |(at, c): (usize, char)| match c.len_utf8() {
        _ if !is_hidden(c) || ends_line(at) => c,
        1 => '?',
        2 => '\u{a4}',
        _ => '\u{fffd}',
    };
    text.char_indices().map(mask).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOREIGN: &str = "a\u{1b}[2J\u{9b}31m\u{202e}b\u{2066}\u{7f}\rc";

    #[test]
    fn what_is_hidden_shows() {
        assert_eq!(visible(FOREIGN), r"a\u001b[2J\u009b31m\u202eb\u2066\u007f\u000dc");
        for plain in ["größe\t1\r\nx\n", "\u{5d0}\u{5d1}", "☃"] {
            assert_eq!((visible(plain), masked(plain)), (plain.into(), plain.into()));
        }
        assert_eq!(on_one_line("a\tb\r\n\u{1b}"), r"a\u0009b\u000d\u000a\u001b");
        let json = serde_json::to_string(FOREIGN).unwrap();
        assert_eq!(serde_json::from_str::<String>(&visible(&json)).unwrap(), FOREIGN);
    }

    #[test]
    fn a_mask_keeps_places() {
        let shown = masked(FOREIGN);
        assert_eq!(shown, "a?[2J\u{a4}31m\u{fffd}b\u{fffd}??c");
        assert_eq!(shown.len(), FOREIGN.len());
    }
}
