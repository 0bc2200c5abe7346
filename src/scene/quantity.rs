//! Numbers as users write them: `2`, `"2 m"`, `"0.5*crank_length"`.

use super::unit;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::model::Unit;

/// A number, a number with a unit, or an expression, not yet read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantity {
    /// What is written.
    pub value: Value,
    /// Where.
    pub span: Span,
}

/// What is written for a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A bare number.
    Number(f64),
    /// A text: a number with a unit, or an expression.
    Text(String),
}

impl Default for Value {
    fn default() -> Value {
        Value::Number(0.0)
    }
}

impl From<f64> for Quantity {
    fn from(number: f64) -> Quantity {
        Quantity { value: Value::Number(number), span: Span::default() }
    }
}

impl From<i32> for Quantity {
    fn from(number: i32) -> Quantity {
        Quantity::from(f64::from(number))
    }
}

impl From<&str> for Quantity {
    fn from(text: &str) -> Quantity {
        Quantity::from(text.to_string())
    }
}

impl From<String> for Quantity {
    fn from(text: String) -> Quantity {
        Quantity { value: Value::Text(text), span: Span::default() }
    }
}

/// What a text turns out to be.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum QuantityReading {
    /// A number alone.
    Number(f64),
    /// A number with a unit: its SI value.
    Measure(f64, Unit),
    /// Something else: an expression.
    Expression,
}

/// Tells numbers, numbers with a unit and expressions apart.
pub(crate) fn read(text: &Text) -> Result<QuantityReading, Fault> {
    let Some((number, at)) = leading_number(&text.text) else {
        return Ok(QuantityReading::Expression);
    };
    let rest = text.text[at..].trim();
    if rest.is_empty() {
        return Ok(QuantityReading::Number(number));
    }
    if let Some(fault) = decimal_comma(text, at) {
        return Err(fault);
    }
    if !rest.starts_with(|c: char| c.is_alphabetic() || "°º˚%\"″”'′".contains(c)) && !rest.starts_with("1/") {
        return Ok(QuantityReading::Expression);
    }
    let begin = at + (text.text[at..].len() - text.text[at..].trim_start().len());
    let unit_text = Text::new(rest, text.part(begin, begin + rest.len()));
    if let Some(fault) = missing_product(text, begin) {
        return Err(fault);
    }
    if unit_text.text.contains(|c: char| "+-() ,<>".contains(c) && !unit_text.text.contains("^-")) {
        let known = unit::separated(&unit_text.text).is_some();
        return Err(unit::parse(&unit_text).err().filter(|_| known).unwrap_or_else(|| {
            let word = rest.split(|c: char| "+-() ,<>*".contains(c)).next().unwrap_or_default();
            let first = text.text.len() - text.text.trim_start().len();
            unit_in_expression(text.part(first, begin + word.len()), &format!("{}[{word}]", text.text[..at].trim()))
        }));
    }
    let unit = unit::parse(&unit_text).map_err(|fault| factor_with_unit(text, at, &unit_text).unwrap_or(fault))?;
    Ok(QuantityReading::Measure(number * unit.display.as_ref().map_or(1.0, |display| display.factor), unit))
}

/// `"0,5 m"`
fn decimal_comma(text: &Text, at: usize) -> Option<Fault> {
    let decimals = text.text[at..].strip_prefix(',')?;
    let digits = decimals.bytes().take_while(u8::is_ascii_digit).count();
    let meant = format!("{}.{decimals}", &text.text[..at]);
    (digits > 0).then(|| {
        Fault::new(
            "scene::decimal_comma",
            format!("`{}` has a comma for its decimal point", text.text),
            text.part(at, at + 1),
        )
        .label("a comma")
        .help(format!("write `{}`", meant.trim()))
    })
}

/// `"360 deg*t"`: a unit, and then something that is none.
fn factor_with_unit(text: &Text, number: usize, unit: &Text) -> Option<Fault> {
    let is_unit = |end: &usize| unit::parse(&Text::from(unit.text[..*end].trim())).is_ok();
    let end = unit.text.match_indices(['*', '/']).map(|(end, _)| end).rfind(is_unit)?;
    let first = Text::new(unit.text[..end].trim(), unit.part(0, end));
    let rest = || unit.text[end + 1..].split(['.', '*', '/']);
    if rest().all(|factor| unit::is_meant(factor.trim())) || unit::separated(&unit.text).is_some() {
        return None;
    }
    let meant = format!("{}[{}]{}", text.text[..number].trim(), first.text, &unit.text[end..]);
    Some(unit_in_expression(text.part(0, text.text.len()), &meant))
}

/// `"2 pi t"`, `"2pi"`: a number, and then a name that is no unit in an expression of several words, or that of a constant.
fn missing_product(text: &Text, at: usize) -> Option<Fault> {
    let rest = &text.text[at..];
    let word = &rest[..rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != '.').unwrap_or(rest.len())];
    // `sin(` is a function, though seconds and inches have these letters.
    let is_called = rest[word.len()..].trim_start().starts_with('(');
    let is_unit = !is_called && unit::is_meant(word) || unit::separated(rest.trim()).is_some();
    let is_expression = word == "pi" || rest.trim().contains(|c: char| "+-() ,<>*^".contains(c));
    (is_expression && !is_unit && !word.is_empty()).then(|| without_product(text, at, at + word.len()))
}

/// A name or a parenthesis behind a number or a name, with no `*` between them.
pub(crate) fn without_product(text: &Text, start: usize, end: usize) -> Fault {
    let (before, behind) = (text.text[..start].trim_end(), &text.text[start..]);
    let found = &text.text[start..end];
    Fault::new("scene::bad_expression", format!("a `*` is missing before `{found}`"), text.part(start, end))
        .label("a factor, or a unit that is not known")
        .help(format!("write a product with `*`: `{}`", with_products(&format!("{before}*{behind}"))))
}

/// With `*` for the blanks between two factors.
fn with_products(text: &str) -> String {
    let mut words = text.split_whitespace();
    let mut written = words.next().unwrap_or_default().to_owned();
    for word in words {
        let is_factor = |c: char| c.is_alphanumeric() || c == '_';
        if written.ends_with(|c: char| c.is_ascii_digit()) && unit::parse(&Text::from(word)).is_ok() {
            written += &format!("[{word}]");
            continue;
        }
        let product = written.ends_with(|c: char| is_factor(c) || c == ')')
            && word.starts_with(|c: char| is_factor(c) || c == '(');
        written += if product { "*" } else { " " };
        written += word;
    }
    written
}

/// `"2 m + x"` and the like.
pub(crate) fn unit_in_expression(span: Span, meant: &str) -> Fault {
    Fault::new("scene::unit_in_expression", "the unit of a number in an expression must be in brackets", span)
        .label("a unit inside an expression")
        .help(format!("write `{meant}`"))
}

/// The number at the start of a text, with its sign, and where it ends.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let start = text.len() - text.trim_start().len();
    let sign = usize::from(text[start..].starts_with(['+', '-']));
    let after_sign = start + sign + (text[start + sign..].len() - text[start + sign..].trim_start_matches(' ').len());
    let length = number_length(&text[after_sign..])?;
    let magnitude: f64 = text[after_sign..after_sign + length].parse().ok()?;
    let number = if text[start..].starts_with('-') { -magnitude } else { magnitude };
    Some((number, after_sign + length))
}

/// How many bytes at the start of a text are an unsigned decimal number, if any.
pub(crate) fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let whole = digits(0);
    let mut end = whole;
    let mut any = whole > 0;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        any |= fraction > 0;
        end += 1 + fraction;
    }
    if !any {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = if end + 1 + sign < bytes.len() { digits(end + 1 + sign) } else { 0 };
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    Some(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(text: &str) -> (f64, String) {
        match read(&Text::from(text)).unwrap() {
            QuantityReading::Measure(value, unit) => (value, unit.si),
            other => panic!("{text} is {other:?}"),
        }
    }

    #[test]
    fn numbers_with_units_become_si() {
        let turn = std::f64::consts::TAU;
        let cases = [
            ("120 mm", 0.12, "m"),
            ("2 m", 2.0, "m"),
            ("30 deg", turn / 12.0, "rad"),
            ("600 rpm", 10.0 * turn, "rad/s"),
            ("-0.19 rad", -0.19, "rad"),
            ("1e-3 kg", 1e-3, "kg"),
            ("1 in", 0.0254, "m"),
            ("1 ft", 0.3048, "m"),
            ("1 lbf", 4.448_221_615_260_5, "N"),
            ("2 tonne", 2000.0, "kg"),
            ("36 km/h", 10.0, "m/s"),
            ("3 N/mm", 3000.0, "N/m"),
            ("5 N.mm", 0.005, "N.m"),
            ("5 N*mm", 0.005, "N.m"),
            ("180 N.m/deg", 180.0 * 360.0 / turn, "N.m/rad"),
            ("7 g.mm^2", 7e-9, "kg.m2"),
            ("7 kg*m^2", 7.0, "kg.m2"),
            ("4 N.m.s/rad", 4.0, "N.m.s/rad"),
            ("9.81 m/s^2", 9.81, "m/s2"),
            ("2 1/s", 2.0, "1/s"),
            ("5 us", 5e-6, "s"),
            ("5 min", 300.0, "s"),
            ("5 kJ", 5000.0, "J"),
            ("5 MW", 5e6, "W"),
            ("2 m.s^-1", 2.0, "m/s"),
        ];
        for (text, value, name) in cases {
            let (read, unit) = si(text);
            assert!((read - value).abs() <= 1e-14 * value.abs(), "{text}: {read} is not {value}");
            assert_eq!(unit, name, "{text}");
        }
    }

    #[test]
    fn a_unit_follows_a_number_and_nothing_else() {
        assert_eq!(read(&Text::from("2*m")).unwrap(), QuantityReading::Expression);
        assert_eq!(read(&Text::from("crank_length")).unwrap(), QuantityReading::Expression);
        assert_eq!(read(&Text::from("-2")).unwrap(), QuantityReading::Number(-2.0));
        assert_eq!(read(&Text::from(" 2e3 ")).unwrap(), QuantityReading::Number(2000.0));
        assert_eq!(read(&Text::from("2 m + x")).unwrap_err().code, "scene::unit_in_expression");
        let fault = read(&Text::from("360 deg*t")).unwrap_err();
        assert_eq!((fault.code, &*fault.help), ("scene::unit_in_expression", "write `360[deg]*t`"));
        assert_eq!(&*read(&Text::from("2 rad/s*t")).unwrap_err().help, "write `2[rad/s]*t`");
        assert!(matches!(read(&Text::from("360[deg]*t")), Ok(QuantityReading::Expression)));
        assert_eq!(read(&Text::from("2 furlong")).unwrap_err().code, "scene::unknown_unit");
        assert_eq!(read(&Text::from("2 t")).unwrap_err().code, "scene::unknown_unit");
        for (text, meant) in [
            ("2 pi t", "`2*pi*t`"),
            ("2pi", "`2*pi`"),
            ("2pi*t", "`2*pi*t`"),
            ("3 l + 2 m", "`3*l + 2[m]`"),
            ("-2 sin(t)", "`-2*sin(t)`"),
        ] {
            let fault = read(&Text::from(text)).unwrap_err();
            assert_eq!(fault.code, "scene::bad_expression", "{text}");
            assert!(fault.help.ends_with(meant), "{text}: {}", fault.help);
        }
    }

    /// Nothing becomes a number by accident, and the advice is a unit that can be written.
    #[test]
    fn what_is_no_unit_is_refused_with_what_is_meant() {
        for (text, meant) in [
            ("30 Grad", "`deg`"),
            ("30 grad", "`deg`"),
            ("2 g0", ""),
            ("2 m^0", ""),
            ("2 Mrad", ""),
            ("5 Nm", "`N.m`"),
            ("5 kNm", "`kN.m`"),
            ("5 Nmm", "`N.mm`"),
            ("5 Nm/rad", "`N.m/rad`"),
            ("30°", "`deg`"),
            ("3 °/s", "`deg`"),
            ("9.81 m/s²", "`m/s2`"),
            ("9.81 m·s⁻²", "`m.s-2`"),
            ("9.81 m s-2", "`m.s-2`"),
            ("2\"", "`in`"),
            ("2 inches", "`in`"),
            ("2 lbm", "`lb`"),
            ("2 lbs", "`lb`"),
            ("2 lbm/s", "`lb`"),
            ("3 psi", "6894.757 Pa"),
            ("3 RPM", "`rpm`"),
            ("3 Rpm", "`rpm`"),
            ("3 U/min", "`rpm`"),
            ("2 t", "`tonne`"),
            ("2 dm", "100 mm"),
            ("50 milimeter", "`mm`"),
            ("5 ft-lb", "`lbf.ft`"),
            ("3 rad/sec", "`s`"),
            ("2 kgs", "`kg`"),
            ("5 kgf", "9.80665 N"),
        ] {
            let fault = read(&Text::from(text)).unwrap_err();
            assert_eq!(fault.code, "scene::unknown_unit", "{text}");
            assert!(fault.help.contains(meant), "{text}: {}", fault.help);
        }
        for text in ["11", "1^2", "12", "m0", "m+2", "m^^2", "g0", "Grad", ""] {
            assert!(unit::parse(&Text::from(text)).is_err(), "{text}");
        }
    }
}
