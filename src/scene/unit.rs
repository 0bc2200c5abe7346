//! Units: `unit = factor (('.' | '*' | '/') factor)*`, `factor = [prefix] symbol ['^'] [exponent]`. An exponent is a whole number but zero; the unit 1 has none.

use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::{DisplayUnit, Exponents, Unit};
use std::f64::consts::{PI, TAU};

/// A text that is no unit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}; {}", .0.message, .0.help)]
pub struct UnitError(pub Box<Fault>);

/// A unit of which SI names are made.
struct Base {
    name: &'static str,
    exponents: Exponents,
}

const fn base(name: &'static str, exponents: Exponents) -> Base {
    Base { name, exponents }
}

const KG: Base = base("kg", Exponents::KILOGRAM);
const M: Base = base("m", Exponents::METRE);
const S: Base = base("s", Exponents::SECOND);
const RAD: Base = base("rad", Exponents::RADIAN);
const A: Base = base("A", Exponents::AMPERE);
const N: Base = base("N", Exponents::NEWTON);
const J: Base = base("J", Exponents::JOULE);
const W: Base = base("W", Exponents::WATT);
const PA: Base = base("Pa", Exponents::PASCAL);
const V: Base = base("V", Exponents::VOLT);
const OHM: Base = base("ohm", Exponents::OHM);
const H: Base = base("H", Exponents::HENRY);
const F: Base = base("F", Exponents::FARAD);
const C: Base = base("C", Exponents::COULOMB);
const WB: Base = base("Wb", Exponents::WEBER);
const T: Base = base("T", Exponents::TESLA);

/// A symbol: SI value of one of it, and the SI units that it is made of.
struct UnitSymbol {
    name: &'static str,
    factor: f64,
    si: &'static [(Base, i32)],
    /// Which prefixes may stand before it.
    prefixes: &'static str,
}

const fn symbol(name: &'static str, factor: f64, si: &'static [(Base, i32)], prefixes: &'static str) -> UnitSymbol {
    UnitSymbol { name, factor, si, prefixes }
}

const ALL: &str = "nuµμmckMG";
const NONE: &str = "";
/// Larger angles have no prefix: `Grad` and `grad` are degrees or gons to those who write them.
const SMALL: &str = "nuµμmk";
/// Centi is not used with electrical units: `cV` is a slip.
const ELECTRICAL: &str = "nuµμmkMG";

const POUND: f64 = 0.453_592_37;

const SYMBOLS: [UnitSymbol; 31] = [
    symbol("m", 1.0, &[(M, 1)], ALL),
    symbol("in", 0.0254, &[(M, 1)], NONE),
    symbol("ft", 0.3048, &[(M, 1)], NONE),
    symbol("g", 1e-3, &[(KG, 1)], ALL),
    symbol("tonne", 1e3, &[(KG, 1)], NONE),
    symbol("lb", POUND, &[(KG, 1)], NONE),
    symbol("s", 1.0, &[(S, 1)], ALL),
    symbol("min", 60.0, &[(S, 1)], NONE),
    symbol("h", 3600.0, &[(S, 1)], NONE),
    symbol("rad", 1.0, &[(RAD, 1)], SMALL),
    symbol("deg", PI / 180.0, &[(RAD, 1)], NONE),
    symbol("rev", TAU, &[(RAD, 1)], NONE),
    symbol("rpm", TAU / 60.0, &[(RAD, 1), (S, -1)], NONE),
    symbol("Hz", 1.0, &[(S, -1)], ALL),
    symbol("N", 1.0, &[(N, 1)], ALL),
    symbol("lbf", POUND * 9.80665, &[(N, 1)], NONE),
    symbol("J", 1.0, &[(J, 1)], ALL),
    symbol("W", 1.0, &[(W, 1)], ALL),
    symbol("Pa", 1.0, &[(PA, 1)], ALL),
    symbol("bar", 1e5, &[(PA, 1)], NONE),
    symbol("A", 1.0, &[(A, 1)], ELECTRICAL),
    symbol("V", 1.0, &[(V, 1)], ELECTRICAL),
    symbol("ohm", 1.0, &[(OHM, 1)], ELECTRICAL),
    // The Greek letter, and the sign that looks like it.
    symbol("Ω", 1.0, &[(OHM, 1)], ELECTRICAL),
    symbol("\u{2126}", 1.0, &[(OHM, 1)], ELECTRICAL),
    symbol("H", 1.0, &[(H, 1)], ELECTRICAL),
    symbol("F", 1.0, &[(F, 1)], ELECTRICAL),
    symbol("C", 1.0, &[(C, 1)], ELECTRICAL),
    symbol("Wb", 1.0, &[(WB, 1)], ELECTRICAL),
    symbol("T", 1.0, &[(T, 1)], ELECTRICAL),
    // `1/s`
    symbol("1", 1.0, &[], NONE),
];

const PREFIXES: [(char, f64); 9] =
    [('n', 1e-9), ('u', 1e-6), ('µ', 1e-6), ('μ', 1e-6), ('m', 1e-3), ('c', 1e-2), ('k', 1e3), ('M', 1e6), ('G', 1e9)];

/// The units that "did you mean" knows beside the symbols.
const USUAL: [&str; 24] = [
    "mm", "cm", "km", "kg", "mg", "ms", "us", "kN", "mN", "kJ", "kW", "kPa", "MPa", "mA", "mV", "kV", "kohm", "mH",
    "uF", "N.m", "N.m/A", "V.s/rad", "kg.m2", "rad/s",
];

/// Other spellings of units, and how they are written here: each word with its plural; case does not count.
const OTHERWISE: [(&[&str], &str); 32] = [
    (&["°", "º", "˚", "degree", "degrees"], "deg"),
    (&["\"", "″", "”", "''", "inch", "inches"], "in"),
    (&["foot", "feet", "FT"], "ft"),
    (&["lbm", "lbs", "pound", "pounds"], "lb"),
    (&["RPM", "U/min", "r/min"], "rpm"),
    (&["turn", "turns", "revolution", "revolutions"], "rev"),
    (&["radian", "radians"], "rad"),
    (&["sec", "secs", "second", "seconds"], "s"),
    (&["millisecond", "milliseconds", "msec"], "ms"),
    (&["minute", "minutes"], "min"),
    (&["hr", "hour", "hours"], "h"),
    (&["metre", "meter", "metres", "meters"], "m"),
    (&["millimetre", "millimeter", "millimetres", "millimeters"], "mm"),
    (&["centimetre", "centimeter", "centimetres", "centimeters"], "cm"),
    (&["micrometre", "micrometer", "micron", "microns"], "um"),
    (&["gram", "grams"], "g"),
    (&["kgs", "kilogram", "kilograms"], "kg"),
    // By its letters alone it would be newtons on square metres.
    (&["Nmm"], "N.mm"),
    (&["newton", "newtons"], "N"),
    (&["kilonewton", "kilonewtons"], "kN"),
    (&["joule", "joules"], "J"),
    (&["watt", "watts"], "W"),
    (&["pascal", "pascals"], "Pa"),
    (&["hertz"], "Hz"),
    (&["amp", "amps", "ampere", "amperes"], "A"),
    (&["volt", "volts"], "V"),
    (&["Ohm", "ohms"], "ohm"),
    (&["henry", "henries"], "H"),
    (&["farad", "farads"], "F"),
    (&["coulomb", "coulombs"], "C"),
    (&["weber", "webers"], "Wb"),
    (&["tesla", "teslas"], "T"),
];

/// Units that are not known, and what each is: exactly, but for the horsepower (550 ft lbf/s) and the pound on the square inch.
const UNKNOWN: [(&[&str], &str); 19] = [
    (&["t"], "`t` is the time; the unit of 1000 kg is `tonne`"),
    (&["ton", "tons"], "write `tonne` for 1000 kg; a ton of 2000 pounds is 907.18474 kg"),
    (&["dm"], "1 dm is 100 mm"),
    (&["psi"], "1 psi is 6894.757 Pa, or `lbf/in2`"),
    (&["gon", "grad", "gradian", "gradians"], "write `deg` for degrees; 1 gon is 0.9 deg"),
    (&["kgf", "kp"], "1 kgf is 9.80665 N"),
    (&["oz", "ounce", "ounces"], "1 oz is 0.028349523125 kg"),
    (&["slug", "slugs"], "1 slug is 14.5939 kg"),
    (&["yd", "yard", "yards"], "1 yd is 0.9144 m"),
    (&["mile", "miles"], "1 mile is 1609.344 m"),
    (&["mph"], "1 mph is 0.44704 m/s"),
    (&["kmh", "kph"], "write `km/h`"),
    (&["hp"], "1 hp is 745.69987 W"),
    (&["PS"], "1 PS is 735.49875 W"),
    (&["atm"], "1 atm is 101325 Pa"),
    (
        &["ft-lb", "lb-ft", "ft-lbs", "ft lb", "lb ft", "ft-lbf", "in-lb", "lb-in", "in lb", "in-lbf"],
        "write `lbf.ft` or `lbf.in`: `lb` is a mass",
    ),
    (&["°C", "degC", "°F", "degF", "kelvin"], "there are no temperatures; `C` is the coulomb, `F` the farad"),
    (&["Ah", "mAh"], "write `A.h` or `mA.h`"),
    (&["%", "percent"], "write a percentage as a number: 0.02 for 2 %"),
];

pub(crate) fn parse(text: &Text) -> Result<Unit, Fault> {
    let mut factor = 1.0;
    let mut parts: Vec<(&'static Base, i32)> = Vec::new();
    let mut sign = 1;
    let mut at = 0;
    loop {
        let end = text.text[at..].find(['.', '*', '/']).map_or(text.text.len(), |length| at + length);
        let (symbol, size, exponent) = parse_factor(text, at, end)?;
        let exponent = sign * exponent;
        factor *= size.powi(exponent);
        for (base, power) in symbol.si {
            add(&mut parts, base, power * exponent);
        }
        let Some(operator) = text.text[end..].chars().next() else {
            break;
        };
        sign = if operator == '/' { -1 } else { 1 };
        at = end + operator.len_utf8();
    }
    let powers = parts.iter().map(|(base, power)| (base.exponents, *power));
    let exponents = Exponents::product(powers).ok_or_else(|| unknown(text, 0, text.text.len()))?;
    let named: Vec<(&str, i32)> = parts.iter().map(|(base, power)| (base.name, *power)).collect();
    let si = name(&named);
    let display = (factor != 1.0).then(|| DisplayUnit { name: text.text.clone(), factor });
    Ok(Unit { exponents, si, display })
}

fn parse_factor(text: &Text, start: usize, end: usize) -> Result<(&'static UnitSymbol, f64, i32), Fault> {
    let word = text.text[start..end].trim();
    let letters = if word == "1" { 1 } else { word.find(|c: char| !c.is_alphabetic()).unwrap_or(word.len()) };
    let exponent = &word[letters..];
    let exponent = exponent.strip_prefix('^').unwrap_or(exponent);
    let is_whole = exponent.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    let sensible = |e: &i32| (1..=9).contains(&e.abs()) && is_whole;
    let exponent = if letters == word.len() { Some(1) } else { exponent.parse().ok().filter(sensible) };
    match (find(&word[..letters]), exponent) {
        (Some((symbol, size)), Some(exponent)) => Ok((symbol, size, exponent)),
        _ => Err(unknown(text, start, end)),
    }
}

/// A symbol with or without a prefix. The bare symbol comes first: `min` is a minute, not a milli-inch.
fn find(word: &str) -> Option<(&'static UnitSymbol, f64)> {
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| symbol.name == word) {
        return Some((symbol, symbol.factor));
    }
    let (prefix, scale) = PREFIXES.iter().find(|(prefix, _)| word.starts_with(*prefix))?;
    let rest = &word[prefix.len_utf8()..];
    let symbol = SYMBOLS.iter().find(|symbol| symbol.prefixes.contains(*prefix) && symbol.name == rest)?;
    // `kg` is exactly one: 1e3 * 1e-3 is 1.
    Some((symbol, scale * symbol.factor))
}

fn unknown(text: &Text, start: usize, end: usize) -> Fault {
    let word = text.text[start..end].trim();
    let known = SYMBOLS.iter().map(|symbol| symbol.name).filter(|name| *name != "1").chain(USUAL);
    let usual =
        || "units are written like `mm`, `kg.m2`, `N.s/m`, `deg`, `rpm`; the prefixes are n u m c k M G".to_string();
    let fault =
        |span| Fault::new("scene::unknown_unit", format!("unknown unit `{}`", text.text), span).label("no such unit");
    match (explained(&text.text), explained(word), separated(&text.text)) {
        (Some(help), ..) => fault(text.span).help(help),
        (None, Some(help), _) => fault(text.part(start, end)).help(help),
        (None, None, Some(meant)) => {
            fault(text.span).help(format!("write `{meant}`: units are multiplied with a point"))
        }
        (None, None, None) => fault(text.part(start, end)).help(suggest::hint(word, known, usual())),
    }
}

/// What is to be written for a unit that is not known, or for a spelling near to one of a few letters more.
fn explained(word: &str) -> Option<String> {
    let is = |other: &&str| other.to_lowercase() == word.to_lowercase();
    let meant = |(_, unit): &(&[&str], &str)| format!("write `{unit}` for `{word}`");
    if let Some((_, what)) = UNKNOWN.iter().find(|(words, _)| words.iter().any(|candidate| candidate == &word)) {
        return Some((*what).to_owned());
    }
    if let Some(found) = OTHERWISE.iter().find(|(words, _)| words.iter().any(|candidate| candidate == &word)) {
        return Some(meant(found));
    }
    if word.chars().count() < 3 {
        return None;
    }
    if let Some((_, what)) = UNKNOWN.iter().find(|(words, _)| words.iter().any(&is)) {
        return Some((*what).to_owned());
    }
    let long = || {
        OTHERWISE.iter().flat_map(|(words, _)| words.iter().copied()).filter(|candidate| candidate.chars().count() > 4)
    };
    let near = suggest::nearest(word, long());
    OTHERWISE.iter().find(|(words, _)| words.iter().any(|word| is(word) || near == Some(*word))).map(meant)
}

/// Is a word a unit, or clearly meant as one? `t` is the time.
pub(crate) fn is_meant(word: &str) -> bool {
    let is_other = || word != "t" && explained(word).is_some();
    parse(&Text::from(word)).is_ok() || separated(word).is_some() || is_other()
}

/// The unit that is meant where its factors are not separated by points: `Nm`, `kg m2`, `m/s²`.
pub(crate) fn separated(text: &str) -> Option<String> {
    let plain = text.replace('°', "deg").replace('²', "2").replace('³', "3").replace('¹', "1").replace('⁻', "-");
    let plain = plain.replace("**", "^").replace(" ^", "^");
    let next = plain.chars().skip(1).map(Some).chain([None]);
    let point = |(c, next): (char, Option<char>)| match c {
        '-' if next.is_some_and(|next| next.is_ascii_digit()) => c,
        '·' | '×' | '⋅' | '-' | ' ' => '.',
        c => c,
    };
    let mut meant: String = plain.chars().zip(next).map(point).collect();
    while let Some(shorter) =
        Some(meant.replace("..", ".").replace("./", "/").replace("/.", "/")).filter(|s| *s != meant)
    {
        meant = shorter;
    }
    let factors: Option<Vec<String>> = meant.split_inclusive(['.', '/', '*']).map(split).collect();
    let meant = factors?.concat();
    (meant != text && parse(&Text::from(meant.as_str())).is_ok()).then_some(meant)
}

/// One factor with the operator behind it; several factors if it is none by itself: `N.m` for `Nm`.
fn split(factor: &str) -> Option<String> {
    let word = factor.trim_end_matches(['.', '/', '*']);
    let letters = word.find(|c: char| !c.is_alphabetic()).unwrap_or(word.len());
    if word.starts_with('1') || find(&word[..letters]).is_some() {
        return Some(factor.to_string());
    }
    let bare = |word: &str| SYMBOLS.iter().any(|symbol| symbol.name == word);
    let factors = factors(&word[..letters], &bare).or_else(|| factors(&word[..letters], &|word| find(word).is_some()));
    Some(factors?.join(".") + &factor[letters..])
}

/// The fewest symbols that a word can be written with.
fn factors<'w>(word: &'w str, known: &dyn Fn(&str) -> bool) -> Option<Vec<&'w str>> {
    const LONGEST: usize = 12;
    if word.is_empty() || word.len() > LONGEST {
        return None;
    }
    if known(word) {
        return Some(vec![word]);
    }
    let cuts = word.char_indices().skip(1).map(|(at, _)| at).filter(|&at| known(&word[..at]));
    let rest = cuts.filter_map(|at| Some([vec![&word[..at]], factors(&word[at..], known)?].concat()));
    rest.min_by_key(Vec::len)
}

fn add(parts: &mut Vec<(&'static Base, i32)>, base: &'static Base, exponent: i32) {
    match parts.iter_mut().find(|(other, _)| other.name == base.name) {
        Some((_, sum)) => *sum += exponent,
        None => parts.push((base, exponent)),
    }
}

/// `N.m/rad`, `1/s2`; empty for a pure number.
fn name(parts: &[(&str, i32)]) -> String {
    let power = |name: &str, exponent: i32| {
        if exponent == 1 { name.to_string() } else { format!("{name}{exponent}") }
    };
    let above: Vec<String> = parts.iter().filter(|part| part.1 > 0).map(|(name, e)| power(name, *e)).collect();
    let below: String =
        parts.iter().filter(|part| part.1 < 0).map(|(name, e)| format!("/{}", power(name, -e))).collect();
    match (above.is_empty(), below.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!("1{below}"),
        (false, _) => above.join(".") + &below,
    }
}

/// The usual names of units that are not made of kilograms, metres and seconds for people.
const NAMED: [(&str, Exponents); 18] = [
    ("N", Exponents::NEWTON),
    ("N.m", NEWTON_METRE),
    ("N.m/rad", NEWTON_METRE.over(Exponents::RADIAN)),
    ("W", Exponents::WATT),
    ("N/m", Exponents::NEWTON.over(Exponents::METRE)),
    ("N.s/m", Exponents::NEWTON.times(Exponents::SECOND).over(Exponents::METRE)),
    ("N.m.s", NEWTON_METRE.times(Exponents::SECOND)),
    ("N.m.s/rad", NEWTON_METRE.times(Exponents::SECOND).over(Exponents::RADIAN)),
    ("V", Exponents::VOLT),
    ("V/s", Exponents::VOLT.over(Exponents::SECOND)),
    ("V.s/rad", Exponents::WEBER.over(Exponents::RADIAN)),
    ("N.m/A", Exponents::WEBER),
    ("N/A", Exponents::NEWTON.over(Exponents::AMPERE)),
    ("ohm", Exponents::OHM),
    ("H", Exponents::HENRY),
    ("F", Exponents::FARAD),
    ("C", Exponents::COULOMB),
    ("T", Exponents::TESLA),
];
const NEWTON_METRE: Exponents = Exponents::JOULE;

/// The unit with these exponents, by its usual name.
pub(crate) fn from_exponents(exponents: Exponents) -> Unit {
    let usual = NAMED.iter().find(|(_, named)| *named == exponents).map(|(name, _)| (*name).to_owned());
    let made = || {
        let Exponents { kilogram, metre, second, radian, ampere } = exponents;
        // The radian first: rad/s, rad/s2.
        let powers = [("rad", radian), ("kg", kilogram), ("m", metre), ("A", ampere), ("s", second)];
        name(&powers.map(|(name, power)| (name, i32::from(power))))
    };
    Unit { exponents, si: usual.unwrap_or_else(made), display: None }
}

impl Unit {
    /// As the user writes it.
    pub fn shown(&self) -> &str {
        self.display.as_ref().map_or(&self.si, |display| &display.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::measure::*;

    #[test]
    fn names_and_exponents_of_units_agree() {
        for wanted in [
            TIME,
            MASS,
            INERTIA,
            LENGTH,
            CURVATURE,
            AREA,
            DENSITY,
            AREA_DENSITY,
            LINE_DENSITY,
            VELOCITY,
            ACCELERATION,
            ANGLE,
            ANGULAR_VELOCITY,
            ANGULAR_ACCELERATION,
            FORCE,
            TORQUE,
            ENERGY,
            POWER,
            STIFFNESS,
            TORSION_STIFFNESS,
            CUBIC_STIFFNESS,
            CUBIC_TORSION_STIFFNESS,
            DAMPING,
            TORSION_DAMPING,
        ] {
            let unit = parse(&Text::from(wanted.si)).unwrap();
            assert_eq!(Some(unit.exponents), wanted.exponents, "{}", wanted.what);
            assert_eq!(unit.display, None, "{}", wanted.what);
        }
    }
}
