//! Characters outside the encodings of pdfLaTeX: other engines print them, pdfLaTeX a replacement.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::GREEK;

/// For the preamble of a document: replacements of its characters that pdfLaTeX does not know.
pub fn declarations(document: &str) -> String {
    let unknown: BTreeSet<char> = document.chars().filter(|&c| !is_known(c)).collect();
    if unknown.is_empty() {
        return String::new();
    }
    let mut text = String::from("\\ifdefined\\DeclareUnicodeCharacter\n");
    for c in unknown {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\\DeclareUnicodeCharacter{{{:04X}}}{{{}}}", c as u32, replacement(c));
    }
    text + "\\fi\n"
}

/// Does every pdfLaTeX print it in the encodings T1 and TS1?
fn is_known(c: char) -> bool {
    match c {
        '\u{b8}' | '\u{126}' | '\u{127}' | '\u{138}' | '\u{13f}' | '\u{140}' | '\u{149}' | '\u{166}' | '\u{167}' => {
            false
        }
        c => c.is_ascii() || ('\u{a1}'..='\u{17e}').contains(&c),
    }
}

fn replacement(c: char) -> String {
    let letter = c.to_string();
    match GREEK.iter().find(|(_, sign)| *sign == letter) {
        Some((name, _)) => format!(r"\ensuremath{{\{name}}}"),
        None => format!(r"[U+{:04X}]\allowbreak{{}}", c as u32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_pdflatex_knows_is_left_to_it() {
        assert_eq!(declarations("Schubkurbel, Größe 3, čep, 5 µm"), "");
    }

    #[test]
    fn other_characters_are_declared_once() {
        let expected = "\\ifdefined\\DeclareUnicodeCharacter\n\\DeclareUnicodeCharacter{03B1}{\\ensuremath{\\alpha}}\n\
                        \\DeclareUnicodeCharacter{4E2D}{[U+4E2D]\\allowbreak{}}\n\\DeclareUnicodeCharacter{1F600}{[U+1F600]\\allowbreak{}}\n\\fi\n";
        assert_eq!(declarations("中 α 😀 中"), expected);
    }
}
