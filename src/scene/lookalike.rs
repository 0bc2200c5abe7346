//! Characters that look like those of a scene and are others, as word processors, web pages and input methods write them; and names without
//! what no name may have.

/// Is it a quotation mark that only looks like one, or stands for one elsewhere?
pub(super) fn is_quote(c: char) -> bool {
    matches!(
        c,
        '\u{2018}'
            ..='\u{201f}' | '\u{2032}' | '\u{2033}' | '«' | '»' | '\u{2039}' | '\u{203a}' | '＂' | '＇' | '`' | '´'
    )
}

/// What is meant by a character that looks like another: none if it is itself, nothing inside if it is not to be seen.
pub(crate) fn plain(c: char) -> Option<Option<char>> {
    /// From here the full-width characters (Unicode: Halfwidth and Fullwidth Forms) are those of ASCII, in the same order.
    const FULL_WIDTH: u32 = 0xfee0;
    Some(match c {
        '！'..='～' => char::from_u32(u32::from(c) - FULL_WIDTH),
        '\u{a0}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\u{205f}' | '\u{3000}' => Some(' '),
        '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}' => None,
        '\u{2010}'..='\u{2015}' | '\u{2212}' => Some('-'),
        '×' | '·' | '\u{22c5}' | '\u{2217}' | '\u{2219}' => Some('*'),
        '÷' | '\u{2044}' | '\u{2215}' => Some('/'),
        '\u{2236}' => Some(':'),
        '、' => Some(','),
        '。' => Some('.'),
        '【' => Some('['),
        '】' => Some(']'),
        _ => return None,
    })
}

/// What is wrong with such a character.
pub(crate) fn described(c: char) -> String {
    let code = format!("U+{:04X}", u32::from(c));
    match plain(c) {
        _ if c == '`' => "a backtick is not the quotation mark `\"`".to_owned(),
        _ if is_quote(c) => format!("`{c}` is not the quotation mark `\"`"),
        Some(None) => format!("here is an invisible character ({code})"),
        Some(Some(' ')) => format!("this blank is not a space ({code})"),
        Some(Some(plain)) => format!("`{c}` ({code}) is not `{plain}`"),
        None => format!("`{c}` ({code}) is not permitted here"),
    }
}

/// Letters that names may be wanted with, and how they are written without them.
const LETTERS: [(&str, &str); 31] = [
    ("äæ", "ae"),
    ("öœø", "oe"),
    ("ü", "ue"),
    ("Ä", "Ae"),
    ("Ö", "Oe"),
    ("Ü", "Ue"),
    ("ß", "ss"),
    ("àáâãåąă", "a"),
    ("çćč", "c"),
    ("èéêëęě", "e"),
    ("ìíîïı", "i"),
    ("łľ", "l"),
    ("ñńň", "n"),
    ("òóôõő", "o"),
    ("ř", "r"),
    ("śšş", "s"),
    ("ùúûűů", "u"),
    ("ýÿ", "y"),
    ("źżž", "z"),
    ("α", "alpha"),
    ("β", "beta"),
    ("γ", "gamma"),
    ("δΔ", "delta"),
    ("θϑ", "theta"),
    ("λ", "lambda"),
    ("μ", "mu"),
    ("π", "pi"),
    ("ρ", "rho"),
    ("φϕΦ", "phi"),
    ("ψ", "psi"),
    ("ωΩ", "omega"),
];

/// A name as near as possible to what is no name.
pub(crate) fn names_of(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        let c = plain(c).flatten().unwrap_or(c);
        match LETTERS.iter().find(|(letters, _)| letters.contains(c)) {
            Some((_, written)) => name += written,
            None if c.is_ascii_alphanumeric() => name.push(c),
            None if name.ends_with('_') => {}
            None => name.push('_'),
        }
    }
    let name = name.trim_end_matches('_');
    if name.starts_with(|c: char| c.is_ascii_digit()) { format!("_{name}") } else { name.to_owned() }
}
