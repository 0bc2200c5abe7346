//! Lines that a reader of TOML refuses: what is usually meant. A line is proposed only if it can be read.

use toml::de::DeTable;

use super::lookalike::{self, is_quote, names_of};

/// A line as it may be meant.
pub(super) struct Mended {
    /// What is wrong with it.
    pub what: String,
    /// Where, in bytes of the line.
    pub place: (usize, usize),
    /// What to write; two lines where there must be two.
    pub line: String,
}

/// Longer lines are written by programs, not by people.
const LONGEST: usize = 2000;

/// A step towards a line that can be read: what is wrong, where, and the line without it.
type Step = Option<(String, (usize, usize), String)>;

/// The line that is meant by one that cannot be read; `keys` are those at the top of a scene.
pub(super) fn mended(line: &str, keys: &[&str]) -> Option<Mended> {
    let line = line.trim_end_matches(['\n', '\r']);
    if line.len() > LONGEST {
        return None;
    }
    let steps: [&dyn Fn(&str) -> Step; 9] =
        [&plain, &commented, &ended, &headed(keys), &named, &measured, &assigned, &listed, &quoted];
    let mut text = line.to_owned();
    let mut first = None;
    for step in steps {
        let Some((what, place, better)) = step(&text) else { continue };
        text = better;
        first.get_or_insert((what, place));
        if is_read(&text) {
            let (what, place) = first?;
            return Some(Mended { what, place, line: text.trim().to_owned() });
        }
    }
    None
}

/// Can the line be read, alone or as a line of a list or a table that takes several?
fn is_read(line: &str) -> bool {
    let (before, after) = unmatched(line);
    let texts = [
        format!("{line}{after}"),
        format!("x = {before}{line}{after}"),
        format!("x = [{before}{line}{after}]"),
        format!("x = {{ {before}{line}{after} }}"),
    ];
    texts.iter().any(|text| DeTable::parse(text).is_ok())
}

/// The brackets that are open before a line, and those that close what it opens.
fn unmatched(line: &str) -> (String, String) {
    let (mut before, mut open) = (String::new(), Vec::new());
    for (_, c) in outside(line) {
        match c {
            '#' => break,
            '[' => open.push(']'),
            '{' => open.push('}'),
            ']' if open.pop().is_none() => before.insert(0, '['),
            '}' if open.pop().is_none() => before.insert(0, '{'),
            _ => {}
        }
    }
    (before, open.into_iter().rev().collect())
}

/// The characters of a text outside of quotes, with their places; quotes themselves are within.
fn outside(text: &str) -> impl Iterator<Item = (usize, char)> {
    let (mut quote, mut escaped) = (None, false);
    text.char_indices().filter(move |&(_, c)| match quote {
        Some(mark) => {
            if c == mark && !escaped {
                quote = None;
            }
            escaped = c == '\\' && !escaped && mark == '"';
            false
        }
        None => {
            quote = Some(c).filter(|c| matches!(c, '"' | '\''));
            quote.is_none()
        }
    })
}

/// Characters that look like others.
fn plain(line: &str) -> Step {
    let (mut text, mut first) = (String::new(), None);
    let mut quote: Option<char> = None;
    let mut last = ' ';
    for (at, c) in line.char_indices() {
        let rest = &line[at + c.len_utf8()..];
        let repeats = (is_quote(c) || c == '\'') && c == last;
        last = c;
        let shown = match quote {
            // A text that begins right may end wrong.
            Some('"') if c == '"' || is_quote(c) && !rest.contains('"') => '"',
            Some('\'') if c == '\'' => '\'',
            Some('\u{201c}') if c == '"' || c == '\'' && !rest.contains(is_quote) || is_quote(c) => '"',
            Some(_) => {
                text.push(c);
                continue;
            }
            None if matches!(c, '"' | '\'') => c,
            None if is_quote(c) => '"',
            None => match lookalike::plain(c) {
                Some(plain) => {
                    first.get_or_insert((at, c));
                    text.extend(plain);
                    continue;
                }
                None => {
                    text.push(c);
                    continue;
                }
            },
        };
        // LaTeX opens a text with two of them.
        if repeats {
            continue;
        }
        if shown != c {
            first.get_or_insert((at, c));
        }
        // All kinds of typographic quotation marks end each other.
        let opened = if shown == c { c } else { '\u{201c}' };
        quote = if quote.is_some() { None } else { Some(opened) };
        text.push(shown);
    }
    let (at, c) = first?;
    Some((lookalike::described(c), (at, at + c.len_utf8()), text))
}

/// Signs that begin comments elsewhere.
const COMMENTS: [&str; 6] = ["//", "/*", ";", "%", "--", "!"];

fn commented(line: &str) -> Step {
    let begins = |at: usize| {
        let (before, rest) = line.split_at(at);
        let sign = COMMENTS.iter().find(|sign| rest.starts_with(**sign))?;
        let text = rest[sign.len()..].trim();
        // Two keys in one line are no comment, and a sign at the end of a line begins none.
        let is_comment = before.trim().is_empty() || before.ends_with([' ', '\t']) || sign.starts_with('/');
        (is_comment && !text.is_empty() && !(sign == &";" && text.contains('='))).then_some((at, sign.len(), text))
    };
    let (at, length, text) = outside(line).take_while(|(_, c)| *c != '#').find_map(|(at, _)| begins(at))?;
    let text = text.trim_end_matches("*/").trim();
    Some(("a comment begins with `#`".into(), (at, at + length), format!("{}# {text}", &line[..at])))
}

/// Signs that end a line elsewhere, or that stand between two keys of a line.
fn ended(line: &str) -> Step {
    let (code, comment) = without_comment(line);
    if let Some(code) = code.trim_end().strip_suffix([';', ',']) {
        let sign = &line[code.len()..=code.len()];
        let text = format!("{}{}", code.trim_end(), if comment.is_empty() { "" } else { " " }) + comment;
        return Some((format!("a line ends without `{sign}`"), (code.len(), code.len() + 1), text));
    }
    let mut signs = outside(code).filter(|(_, c)| *c == ';');
    let (at, _) = signs.find(|(at, _)| code[at + 1..].contains('='))?;
    let text = format!("{}\n{}", code[..at].trim_end(), code[at + 1..].trim());
    Some(("write each key on its own line".into(), (at, at + 1), text))
}

fn without_comment(line: &str) -> (&str, &str) {
    let end = outside(line).find(|(_, c)| *c == '#').map_or(line.len(), |(at, _)| at);
    line.split_at(end)
}

/// Headers of tables: their brackets, and their names.
fn headed(keys: &[&str]) -> impl Fn(&str) -> Step {
    |line| {
        let code = without_comment(line).0.trim();
        let inner = code.strip_prefix(['[', '{', '(', '<'])?.trim_end_matches([']', '}', ')', '>']);
        if code.contains('=') || inner.contains(['[', ']', ',']) {
            return None;
        }
        let end = inner.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(inner.len());
        let (section, rest) = inner.split_at(end);
        if !keys.contains(&section) {
            return None;
        }
        let rest = rest.trim_start_matches(['.', ':', '/', '\\', '-', ' ']);
        let parts = rest.split('.').map(|name| names_of(name.trim().trim_matches(['"', '\''])));
        let header = std::iter::once(section.to_owned()).chain(parts.filter(|name| !name.is_empty()));
        let header = format!("[{}]", header.collect::<Vec<_>>().join("."));
        let at = line.find(code)?;
        let name = inner[end..].strip_prefix('.').filter(|_| code.starts_with('[') && code.ends_with(']'));
        let (what, place) = match name {
            Some(name) => (format!("`{name}` is not a name"), (at + end + 2, at + 1 + inner.len())),
            None => ("this is not the header of a table".to_owned(), (at, at + code.len())),
        };
        Some((what, place, header))
    }
}

/// Keys that are no names.
fn named(line: &str) -> Step {
    let (at, _) = outside(line).find(|(_, c)| matches!(c, '=' | '#')).filter(|(_, c)| *c == '=')?;
    let key = line[..at].trim();
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' ');
    let is_bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    if key.is_empty() || key.chars().all(is_bare) || !key.chars().all(is_word) {
        return None;
    }
    let name: Vec<String> = key.split('.').map(|part| names_of(part.trim())).collect();
    let start = line.find(key)?;
    let text = format!("{}{} {}", &line[..start], name.join("."), &line[at..]);
    Some((format!("`{key}` is not a name"), (start, start + key.len()), text))
}

/// `mass [kg] = 0.5`
fn measured(line: &str) -> Step {
    let (code, comment) = without_comment(line);
    let (key, value) = code.split_once('=')?;
    let open = key.find(['[', '('])?;
    let unit = key[open + 1..].trim().strip_suffix([']', ')'])?.trim();
    let value = value.trim();
    value.parse::<f64>().ok()?;
    let text = format!("{} = \"{value} {unit}\" {comment}", key[..open].trim_end());
    let end = open + key[open..].trim_end().len();
    Some(("write a unit after its number".into(), (open, end), text.trim_end().to_owned()))
}

/// What stands between a key and its value elsewhere, or nothing.
fn assigned(line: &str) -> Step {
    const WHAT: &str = "write `=` between a key and its value";
    let (code, comment) = without_comment(line);
    let (mut text, mut first, mut done) = (String::new(), None, 0);
    let (mut depth, mut has_sign) = (0_usize, false);
    for (at, c) in outside(code).filter(|(_, c)| "{}:=-".contains(*c)) {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        let sign = [":=", "==", "=>", "->", ":"].into_iter().find(|sign| code[at..].starts_with(sign));
        let sign = sign.filter(|_| at >= done && (!has_sign || depth > 0));
        if let Some(sign) = sign {
            first.get_or_insert((at, at + sign.len()));
            text += code[done..at].trim_end();
            text += " =";
            done = at + sign.len();
        }
        has_sign |= sign.is_some() || c == '=';
    }
    match first {
        Some(place) => Some((WHAT.into(), place, text + &code[done..] + comment)),
        None if has_sign => None,
        None => without_sign(line)
            .map(|(end, value)| (WHAT.into(), (end, line.len() - value.len()), format!("{} = {value}", &line[..end]))),
    }
}

/// Where the key of a line ends whose value follows it at once, and that value.
fn without_sign(line: &str) -> Option<(usize, &str)> {
    let start = line.len() - line.trim_start().len();
    let is_key = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
    let end = start + line[start..].find(|c: char| !is_key(c))?;
    let value = line[end..].trim_start();
    let is_value = value.starts_with(|c: char| c.is_ascii_digit() || "\"'[{+-.".contains(c));
    (end > start && is_value && line[end..].starts_with([' ', '\t'])).then_some((end, value))
}

/// Lists in other brackets, or with other signs between their items.
fn listed(line: &str) -> Step {
    let (code, comment) = without_comment(line);
    let at = code.find('=').map_or(0, |at| at + 1);
    let value = code[at..].trim();
    let open = at + (code[at..].len() - code[at..].trim_start().len());
    if let Some(items) = value.strip_prefix('(').and_then(|value| value.strip_suffix(')'))
        && items.contains([',', ';'])
    {
        let text = format!("{}[{}] {comment}", &code[..open], items.replace(';', ","));
        return Some(("write a list in `[` and `]`".into(), (open, open + 1), text.trim_end().to_owned()));
    }
    let signs: Vec<usize> = outside(code).filter(|(_, c)| *c == ';').map(|(at, _)| at).collect();
    let mut text = line.to_owned();
    signs.iter().for_each(|&at| text.replace_range(at..=at, ","));
    let first = *signs.first()?;
    Some(("write commas between the items of a list".into(), (first, first + 1), text))
}

/// Values that are none of TOML's.
fn quoted(line: &str) -> Step {
    let (code, comment) = without_comment(line);
    // A word alone is no item of a list.
    if !code.contains(['=', ',', '[', ']', '"']) {
        return None;
    }
    let (mut text, mut first, mut done) = (String::new(), None, 0);
    for WrittenValue { start, end, in_list } in values(code) {
        let value = &code[start..end];
        if DeTable::parse(&format!("x = {value}")).is_ok() {
            continue;
        }
        let Some((what, better)) = meant(value, in_list) else { continue };
        first.get_or_insert((what, (start, end)));
        text += &code[done..start];
        text += &better;
        done = end;
    }
    let (what, place) = first?;
    Some((what.into(), place, text + &code[done..] + comment))
}

/// Where a value stands in a line.
struct WrittenValue {
    start: usize,
    end: usize,
    /// In a list or a table?
    in_list: bool,
}

/// The values in a line.
fn values(code: &str) -> Vec<WrittenValue> {
    let (mut found, mut start, mut depth, mut within) = (Vec::new(), 0, 0_usize, 0_usize);
    let mut push = |start: usize, end: usize, depth: usize| {
        let value = code[start..end].trim();
        let from = start + (code[start..end].len() - code[start..end].trim_start().len());
        if !value.is_empty() {
            found.push(WrittenValue { start: from, end: from + value.len(), in_list: depth > 0 });
        }
    };
    for (at, c) in outside(code) {
        let begins = code[start..at].trim().is_empty();
        match c {
            '=' if within == 0 => start = at + 1,
            '[' | '{' if begins => (depth, start) = (depth + 1, at + 1),
            // Units stand in brackets, too, and functions have commas.
            '[' | '(' => within += 1,
            ']' | ')' if within > 0 => within -= 1,
            ',' | ']' | '}' if depth > 0 && within == 0 => {
                push(start, at, depth);
                depth -= usize::from(c != ',');
                start = at + 1;
            }
            _ => {}
        }
    }
    push(start, code.len(), depth);
    found
}

/// What a value is meant to be, and what is wrong with it.
fn meant(value: &str, in_list: bool) -> Option<(&'static str, String)> {
    const QUOTES: &str = "write texts, numbers with a unit and expressions in quotes";
    const NUMBER: &str = "write a number with digits on both sides of its point, and without spaces";
    match value.to_lowercase().as_str() {
        "true" | "yes" | "on" => return Some(("this is written `true`", "true".into())),
        "false" | "no" | "off" => return Some(("this is written `false`", "false".into())),
        // What is none is left out.
        "none" | "null" | "nil" | "nan" => return None,
        _ => {}
    }
    if value.contains(['"', '\'']) {
        let text = value.trim_matches(['"', '\'']);
        let is_one = !text.is_empty() && !text.contains(['"', '\'', '\\']);
        return is_one.then(|| ("write a text between two equal quotation marks", format!("\"{text}\"")));
    }
    let pair: Vec<&str> = value.split_whitespace().collect();
    if in_list && pair.len() == 2 && pair.iter().all(|number| number.parse::<f64>().is_ok()) {
        return Some(("write commas between the items of a list", pair.join(", ")));
    }
    let sign = value.find(|c| c != '+' && c != '-').unwrap_or(0);
    let end =
        value[sign..].find(|c: char| !c.is_ascii_digit() && !". ,'".contains(c)).map_or(value.len(), |at| sign + at);
    let (digits, unit) = value.split_at(end);
    match number(digits.trim_end()) {
        Some(number) if unit.is_empty() => Some((NUMBER, number)),
        Some(number) if unit.starts_with('[') && unit.ends_with(']') => {
            Some((QUOTES, format!("\"{number} {}\"", unit.trim_matches(['[', ']']).trim())))
        }
        Some(number) if is_expression(unit) => {
            Some((QUOTES, format!("\"{number}{}{unit}\"", &digits[digits.trim_end().len()..])))
        }
        None if is_expression(value) => Some((QUOTES, format!("\"{value}\""))),
        _ => None,
    }
}

/// Is it made of what words, units and expressions are made of?
fn is_expression(text: &str) -> bool {
    text.contains(char::is_alphanumeric)
        && text.chars().all(|c| c.is_alphanumeric() || " +-*/^()[].,<>=_°µ%²³".contains(c))
}

/// A number as TOML writes it: a point before the decimals, digits on both sides of it, no gaps.
fn number(digits: &str) -> Option<String> {
    let groups: Vec<&str> = digits.split([' ', '\'']).collect();
    let is_grouped = groups.len() > 1 && groups[1..].iter().all(|group| group.len() == 3);
    let text = if is_grouped { groups.concat() } else { digits.to_owned() };
    let text = if text.contains('.') { text } else { text.replacen(',', ".", 1) };
    let (sign, size) = text.split_at(text.len() - text.trim_start_matches(['+', '-']).len());
    let (whole, decimals) = size.split_once('.').unwrap_or((size, ""));
    let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if size.is_empty() || size == "." || !are_digits(whole) || !are_digits(decimals) {
        return None;
    }
    let whole = whole.trim_start_matches('0');
    let whole = if whole.is_empty() { "0" } else { whole };
    Some(match size.contains('.') {
        true => format!("{sign}{whole}.{}", if decimals.is_empty() { "0" } else { decimals }),
        false => format!("{sign}{whole}"),
    })
}
