//! Parses expressions into trees that know where each part is written.
//!
//! ```text
//! sum     = product (('+' | '-') product)*
//! product = sign (('*' | '/') sign)*
//! sign    = ('-' | '+') sign | power
//! power   = primary ('^' sign)?                      2^3^2 = 2^(3^2), -2^2 = -(2^2)
//! primary = number ['[' unit ']'] | name | 'new' '(' name ')' | function '(' sum, ... ')' | 'if' '(' sum compare sum ',' sum ',' sum ')' | table '(' text ',' sum ')' | '(' sum ')'
//! name    = identifier ('.' identifier)*
//! ```

use super::quantity::{number_length, unit_in_expression, without_product};
use super::{lookalike, unit};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::expr::{Binary, Function, Unary};
use crate::model::{Comparison, Unit};

/// Stands before the name of a sampled value.
pub(crate) const NEW: &str = "new";

/// Deeper trees are refused, so that no expression can exhaust the stack, here or later.
const DEEPEST: usize = 250;

/// A part of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SyntaxTree {
    pub kind: SyntaxKind,
    /// First byte within the text of the expression.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
    depth: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SyntaxKind {
    Number(f64),
    /// A number with its unit, in SI.
    Measure(f64, Unit),
    Name(String),
    /// Operators too.
    Call(Function, Vec<SyntaxTree>),
    If(Comparison, Box<[SyntaxTree; 4]>),
    /// What a sampled value gets at the same tick.
    New(String),
    /// A file's table at a value.
    Table(Lookup, String, Box<SyntaxTree>),
}

impl SyntaxKind {
    /// What it is made of, from left to right.
    pub fn parts(&self) -> &[SyntaxTree] {
        match self {
            SyntaxKind::Number(_) | SyntaxKind::Measure(..) | SyntaxKind::Name(_) | SyntaxKind::New(_) => &[],
            SyntaxKind::Call(_, arguments) => arguments,
            SyntaxKind::If(_, parts) => &parts[..],
            SyntaxKind::Table(_, _, argument) => std::slice::from_ref(&**argument),
        }
    }
}

/// How a table is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lookup {
    /// By a cubic spline? Else by straight lines.
    pub smooth: bool,
    /// Does it begin anew where it ends?
    pub periodic: bool,
}

impl Lookup {
    /// What each is called.
    pub const NAMES: [(&'static str, Lookup); 4] = [
        ("table", Lookup { smooth: false, periodic: false }),
        ("spline", Lookup { smooth: true, periodic: false }),
        ("periodic_table", Lookup { smooth: false, periodic: true }),
        ("periodic_spline", Lookup { smooth: true, periodic: true }),
    ];

    fn named(name: &str) -> Option<Lookup> {
        Lookup::NAMES.iter().find(|(spelling, _)| *spelling == name).map(|(_, lookup)| *lookup)
    }
}

pub(crate) fn parse(text: &Text) -> Result<SyntaxTree, Fault> {
    let tokens = tokens(text)?;
    let mut parser = Parser { text, tokens, at: 0, nesting: 0 };
    let tree = parser.sum()?;
    match parser.peek() {
        Token::End => Ok(tree),
        Token::Compare(_) => Err(parser
            .fault("a comparison is permitted only as the first argument of `if`")
            .label("not here")
            .help("write `if(a < b, value, otherwise)`")),
        _ => Err(parser.expected("an operator (+ - * / ^) or the end")),
    }
}

/// `a = b`, `a == b` or `a != b`, where one of the two directions must be chosen.
fn equality(text: &Text) -> Option<Fault> {
    let is_own = |at: usize| !text.text[..at].ends_with(['<', '>']);
    let at = text.text.char_indices().find(|&(at, c)| c == '=' && is_own(at)).map(|(at, _)| at)?;
    let (before, after) = (&text.text[..at], &text.text[at + 1..]);
    let (left, right) = (before.trim_end().trim_end_matches('!').trim(), after.trim_start_matches('=').trim());
    let from = if before.ends_with('!') { at - 1 } else { at };
    let to = at + 1 + (after.len() - after.trim_start_matches('=').len());
    let message = format!("`{}` is not a comparison that can become true", &text.text[from..to]);
    let help = format!(
        "an event happens when its comparison becomes true: write `{left} > {right}` for a rising crossing, `{left} < {right}` for a falling one"
    );
    Some(Fault::new("scene::bad_expression", message, text.part(from, to)).label("not understood").help(help))
}

/// A comparison of two expressions.
pub(crate) fn comparison(text: &Text) -> Result<(Comparison, [SyntaxTree; 2]), Fault> {
    const ONE: &str = "write one comparison, such as `beam.angle > 0.7`";
    const BOTH: &str =
        "combine two comparisons: `min(a, b) > 0` if a and b must be positive, `max(a, b) > 0` if one is enough";
    let or_one = |fault: Fault| if fault.help.is_empty() { fault.help(ONE) } else { fault };
    if let Some(fault) = equality(text) {
        return Err(fault);
    }
    let tokens = tokens(text)?;
    let mut parser = Parser { text, tokens, at: 0, nesting: 0 };
    let left = parser.sum()?;
    let Token::Compare(comparison) = parser.peek() else {
        return Err(or_one(parser.expected("`<`, `<=`, `>` or `>=`")));
    };
    parser.at += 1;
    let right = parser.sum()?;
    match parser.peek() {
        Token::End => Ok((comparison, [left, right])),
        Token::Compare(_) | Token::Name("and" | "or") => {
            Err(parser.fault("only one comparison is permitted here").label("a second one").help(BOTH))
        }
        _ => Err(or_one(parser.expected("an operator (+ - * / ^) or the end"))),
    }
}

/// The expression with other texts for some of its names; as it is if it cannot be read.
pub(crate) fn substituted(text: &str, replace: impl Fn(&str) -> Option<String>) -> String {
    rewritten(text, |token, next| match token {
        Token::Name(_) if next == Token::Open => None, // a function
        Token::Name(name) => replace(name),
        _ => None,
    })
}

/// The expression with other texts for the files of its tables; as it is if it cannot be read.
pub(crate) fn with_files(text: &str, mut replace: impl FnMut(&str) -> String) -> String {
    rewritten(text, |token, _| {
        let Token::Text(file) = token else { return None };
        let other = replace(file);
        let quote = if other.contains('"') { '\'' } else { '"' };
        Some(format!("{quote}{other}{quote}"))
    })
}

/// The expression with other texts for some of its tokens; `replace` is told the next one too.
fn rewritten(text: &str, mut replace: impl FnMut(Token, Token) -> Option<String>) -> String {
    let whole = Text::from(text);
    let Ok(tokens) = tokens(&whole) else { return text.to_owned() };
    let (mut result, mut done) = (String::new(), 0);
    for pair in tokens.windows(2) {
        let [PlacedToken { token, start, end }, next] = *pair else { continue };
        if let Some(other) = replace(token, next.token) {
            result += &text[done..start];
            result += &other;
            done = end;
        }
    }
    result + &text[done..]
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'t> {
    Number(f64),
    Name(&'t str),
    /// Between quotes of either kind.
    Text(&'t str),
    /// Between brackets.
    Unit(&'t str),
    Operator(Binary),
    Compare(Comparison),
    Open,
    Close,
    Comma,
    End,
}

/// A token and where it stands.
#[derive(Clone, Copy)]
struct PlacedToken<'t> {
    token: Token<'t>,
    start: usize,
    end: usize,
}

/// The last is always `End`.
fn tokens(text: &Text) -> Result<Vec<PlacedToken<'_>>, Fault> {
    let source = text.text.as_str();
    let mut tokens = Vec::new();
    let mut at = 0;
    loop {
        at += source[at..].len() - source[at..].trim_start().len();
        let (token, length) = token(&source[at..]).ok_or_else(|| unexpected(text, at))?;
        tokens.push(PlacedToken { token, start: at, end: at + length });
        if token == Token::End {
            return Ok(tokens);
        }
        at += length;
    }
}

/// The token at the start of a text and its length.
fn token(rest: &str) -> Option<(Token<'_>, usize)> {
    let Some(first) = rest.chars().next() else {
        return Some((Token::End, 0));
    };
    let or_equal = |plain, or_equal| match rest[1..].starts_with('=') {
        true => (Token::Compare(or_equal), 2),
        false => (Token::Compare(plain), 1),
    };
    Some(match first {
        '+' => (Token::Operator(Binary::Add), 1),
        '-' => (Token::Operator(Binary::Subtract), 1),
        '*' => (Token::Operator(Binary::Multiply), 1),
        '/' => (Token::Operator(Binary::Divide), 1),
        '^' => (Token::Operator(Binary::Power), 1),
        '(' => (Token::Open, 1),
        ')' => (Token::Close, 1),
        ',' => (Token::Comma, 1),
        '<' => or_equal(Comparison::Less, Comparison::LessEqual),
        '>' => or_equal(Comparison::Greater, Comparison::GreaterEqual),
        '"' | '\'' => {
            let length = rest[1..].find(first)?;
            (Token::Text(&rest[1..=length]), length + 2)
        }
        '[' => {
            let length = rest[1..].find(']')?;
            (Token::Unit(&rest[1..=length]), length + 2)
        }
        'a'..='z' | 'A'..='Z' | '_' => {
            let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '.').unwrap_or(rest.len());
            (Token::Name(&rest[..length]), length)
        }
        _ => {
            let length = number_length(rest)?;
            (Token::Number(rest[..length].parse().ok()?), length)
        }
    })
}

fn unexpected(text: &Text, at: usize) -> Fault {
    let character = text.text[at..].chars().next().unwrap_or(' ');
    if let Some(plain) = lookalike::plain(character) {
        let span = text.part(at, at + character.len_utf8());
        let help = plain.map_or("remove it".to_owned(), |plain| format!("write `{plain}`"));
        return Fault::new("scene::bad_expression", lookalike::described(character), span).label("here").help(help);
    }
    let help = match character {
        'π' => "write `pi`",
        '=' | '!' | '&' | '|' => "the comparisons are `<`, `<=`, `>`, `>=`, and only inside `if(a < b, x, y)`",
        _ => "expressions are made of numbers, names, `+ - * / ^`, parentheses and functions",
    };
    let span = text.part(at, at + character.len_utf8());
    Fault::new("scene::bad_expression", format!("`{character}` is not permitted in an expression"), span)
        .label("not understood")
        .help(help)
}

struct Parser<'t> {
    text: &'t Text,
    tokens: Vec<PlacedToken<'t>>,
    at: usize,
    nesting: usize,
}

impl<'t> Parser<'t> {
    fn sum(&mut self) -> Result<SyntaxTree, Fault> {
        let mut left = self.product()?;
        while let Token::Operator(operator @ (Binary::Add | Binary::Subtract)) = self.peek() {
            self.at += 1;
            left = self.binary(operator, left, Parser::product)?;
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<SyntaxTree, Fault> {
        let mut left = self.sign()?;
        while let Token::Operator(operator @ (Binary::Multiply | Binary::Divide)) = self.peek() {
            self.at += 1;
            left = self.binary(operator, left, Parser::sign)?;
        }
        Ok(left)
    }

    fn sign(&mut self) -> Result<SyntaxTree, Fault> {
        self.nested(|parser| match parser.peek() {
            Token::Operator(Binary::Subtract) => {
                let start = parser.place().0;
                parser.at += 1;
                let inner = parser.sign()?;
                let end = inner.end;
                parser.tree(SyntaxKind::Call(Function::One(Unary::Negate), vec![inner]), start, end)
            }
            Token::Operator(Binary::Add) => {
                parser.at += 1;
                parser.sign()
            }
            _ => parser.power(),
        })
    }

    fn power(&mut self) -> Result<SyntaxTree, Fault> {
        let base = self.primary()?;
        if self.peek() == Token::Operator(Binary::Power) {
            self.at += 1;
            return self.binary(Binary::Power, base, Parser::sign);
        }
        Ok(base)
    }

    fn primary(&mut self) -> Result<SyntaxTree, Fault> {
        let (token, (start, end)) = (self.peek(), self.place());
        match token {
            Token::Number(number) => {
                self.at += 1;
                match self.peek() {
                    Token::Unit(unit) => self.measure(number, unit, start),
                    _ => self.tree(SyntaxKind::Number(number), start, end),
                }
            }
            Token::Name(name) => {
                self.at += 1;
                match self.peek() {
                    Token::Open if name == "if" => self.conditional(start),
                    Token::Open if name == NEW => self.newer(start),
                    Token::Open if Lookup::named(name).is_some() => self.lookup(name, start),
                    Token::Open => self.call(name, start, end),
                    _ => self.tree(SyntaxKind::Name(name.to_string()), start, end),
                }
            }
            Token::Open => {
                self.at += 1;
                let mut inner = self.sum()?;
                (inner.start, inner.end) = (start, self.close()?);
                Ok(inner)
            }
            Token::Operator(Binary::Multiply) if self.follows(Token::Operator(Binary::Multiply)) => {
                let span = self.text.part(self.tokens[self.at - 1].start, end);
                let fault =
                    Fault::new("scene::bad_expression", "`**` is not an operator", span).label("not understood");
                Err(fault.help("write a power with `^`: `x^2`"))
            }
            _ => Err(self.expected("a number, a name or `(`")),
        }
    }

    /// A number has been read, its unit is next.
    fn measure(&mut self, number: f64, unit: &str, start: usize) -> Result<SyntaxTree, Fault> {
        let (open, end) = self.place();
        self.at += 1;
        let unit = unit::parse(&Text::new(unit, self.text.part(open + 1, end - 1)))?;
        let factor = unit.display.as_ref().map_or(1.0, |display| display.factor);
        self.tree(SyntaxKind::Measure(number * factor, unit), start, end)
    }

    /// `if` has been read, `(` is next.
    fn conditional(&mut self, start: usize) -> Result<SyntaxTree, Fault> {
        self.at += 1;
        let left = self.sum()?;
        let Token::Compare(comparison) = self.peek() else {
            return Err(self
                .fault("the first argument of `if` must be a comparison")
                .label("expected `<`, `<=`, `>` or `>=`")
                .help("write `if(a < b, value, otherwise)`"));
        };
        self.at += 1;
        let right = self.sum()?;
        self.comma()?;
        let then = self.sum()?;
        self.comma()?;
        let otherwise = self.sum()?;
        let end = self.close()?;
        self.tree(SyntaxKind::If(comparison, Box::new([left, right, then, otherwise])), start, end)
    }

    /// `new` has been read, `(` is next.
    fn newer(&mut self, start: usize) -> Result<SyntaxTree, Fault> {
        self.at += 1;
        let Token::Name(name) = self.peek() else {
            let fault =
                self.fault("the argument of `new(...)` must be the name of a sampled value").label("expected a name");
            return Err(fault.help("write `new(x)` for the value that `x` gets at the same sample time"));
        };
        let name = name.to_owned();
        self.at += 1;
        let end = self.close()?;
        self.tree(SyntaxKind::New(name), start, end)
    }

    /// The name of a way to read a table has been read, `(` is next.
    fn lookup(&mut self, name: &str, start: usize) -> Result<SyntaxTree, Fault> {
        self.at += 1;
        let help = format!("write `{name}(\"file.csv\", x)`");
        let Token::Text(file) = self.peek() else {
            let fault = self
                .fault(&format!("the first argument of `{name}` must be a file"))
                .label("expected a file in quotes");
            return Err(fault.help(help));
        };
        let file = file.to_owned();
        self.at += 1;
        if self.peek() != Token::Comma {
            return Err(self.expected("`,`").help(help));
        }
        self.at += 1;
        let argument = self.sum()?;
        let end = self.close()?;
        let lookup = Lookup::named(name).unwrap_or(Lookup { smooth: false, periodic: false });
        self.tree(SyntaxKind::Table(lookup, file, Box::new(argument)), start, end)
    }

    /// `sind(30)` and the like: the function of an angle in degrees, as other programs call it.
    fn of_degrees(&self, name: &str, start: usize) -> Option<Fault> {
        let function = ["sin", "cos", "tan"].into_iter().find(|function| name.strip_suffix('d') == Some(function))?;
        let (open, mut depth) = (self.place().1, 0);
        let close = self.text.text[open..].find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth < 0
        })?;
        let argument = self.text.text[open..open + close].trim();
        let is_number = argument.parse::<f64>().is_ok();
        let angle = if is_number { format!("{argument}[deg]") } else { format!("({argument})*1[deg]") };
        let message = format!("there is no function `{name}`: angles have their unit");
        let span = self.text.part(start, open + close + 1);
        let fault = Fault::new("scene::unknown_function", message, span).label("not a function");
        Some(fault.help(format!("write `{function}({angle})`")))
    }

    /// The name of a function has been read, `(` is next.
    fn call(&mut self, name: &str, start: usize, name_end: usize) -> Result<SyntaxTree, Fault> {
        let span = self.text.part(start, name_end);
        let Some(function) = Function::named(name) else {
            if let Some(fault) = self.of_degrees(name, start) {
                return Err(fault);
            }
            let names = || Function::all().map(Function::name).chain(Lookup::NAMES.map(|(name, _)| name));
            let otherwise =
                format!("the functions are {} and `if(a < b, x, y)`", names().collect::<Vec<_>>().join(", "));
            return Err(Fault::new("scene::unknown_function", format!("there is no function `{name}`"), span)
                .label("not a function")
                .help(suggest::hint(name, names(), otherwise)));
        };
        self.at += 1;
        let mut arguments = Vec::new();
        if self.peek() != Token::Close {
            arguments.push(self.sum()?);
            while self.peek() == Token::Comma {
                self.at += 1;
                arguments.push(self.sum()?);
            }
        }
        let end = self.close()?;
        let wanted = function.operands();
        if arguments.len() != wanted {
            let message = format!("`{name}` takes {}, not {}", count(wanted), arguments.len());
            return Err(Fault::new("scene::bad_expression", message, self.text.part(start, end))
                .label(format!("{} given", count(arguments.len()))));
        }
        self.tree(SyntaxKind::Call(function, arguments), start, end)
    }

    fn binary(
        &mut self,
        operator: Binary,
        left: SyntaxTree,
        right: impl Fn(&mut Self) -> Result<SyntaxTree, Fault>,
    ) -> Result<SyntaxTree, Fault> {
        let right = right(self)?;
        let (start, end) = (left.start, right.end);
        self.tree(SyntaxKind::Call(Function::Two(operator), vec![left, right]), start, end)
    }

    /// A tree that is not too deep.
    fn tree(&self, kind: SyntaxKind, start: usize, end: usize) -> Result<SyntaxTree, Fault> {
        let depth = 1 + kind.parts().iter().map(|part| part.depth).max().unwrap_or(0);
        if depth > DEEPEST {
            return Err(self.too_deep());
        }
        Ok(SyntaxTree { kind, start, end, depth })
    }

    fn nested(&mut self, parse: impl Fn(&mut Self) -> Result<SyntaxTree, Fault>) -> Result<SyntaxTree, Fault> {
        self.nesting += 1;
        let tree = if self.nesting > DEEPEST { Err(self.too_deep()) } else { parse(self) };
        self.nesting -= 1;
        tree
    }

    fn too_deep(&self) -> Fault {
        self.fault("the expression is too long or nested too deeply").label("too deep from here")
    }

    fn comma(&mut self) -> Result<(), Fault> {
        if self.peek() != Token::Comma {
            return Err(self.expected("`,`").help("`if` takes three arguments: `if(a < b, value, otherwise)`"));
        }
        self.at += 1;
        Ok(())
    }

    /// Reads `)`; where it ends.
    fn close(&mut self) -> Result<usize, Fault> {
        if self.peek() != Token::Close {
            return Err(self.expected("an operator or `)`"));
        }
        let end = self.place().1;
        self.at += 1;
        Ok(end)
    }

    fn peek(&self) -> Token<'t> {
        self.tokens[self.at].token
    }

    fn place(&self) -> (usize, usize) {
        (self.tokens[self.at].start, self.tokens[self.at].end)
    }

    fn follows_number(&self) -> bool {
        self.at > 0 && matches!(self.tokens[self.at - 1].token, Token::Number(_))
    }

    fn follows_factor(&self) -> bool {
        let before = self.at.checked_sub(1).map(|before| self.tokens[before].token);
        matches!(before, Some(Token::Number(_) | Token::Name(_) | Token::Close | Token::Unit(_)))
    }

    fn follows(&self, token: Token<'_>) -> bool {
        self.at > 0 && self.tokens[self.at - 1].token == token && self.tokens[self.at - 1].end == self.place().0
    }

    fn fault(&self, message: &str) -> Fault {
        let (start, end) = self.place();
        Fault::new("scene::bad_expression", message, self.text.part(start, end))
    }

    fn expected(&self, what: &str) -> Fault {
        let (start, end) = self.place();
        if let (Token::Name(unit), true) = (self.peek(), self.follows_number()) {
            let (number, until) = (self.tokens[self.at - 1].start, self.tokens[self.at - 1].end);
            if !unit::is_meant(unit) {
                return without_product(self.text, start, end);
            }
            let meant = format!("{}[{unit}]", &self.text.text[number..until]);
            return unit_in_expression(self.text.part(number, end), &meant);
        }
        if self.follows_factor() && matches!(self.peek(), Token::Name(_) | Token::Open | Token::Number(_)) {
            return without_product(self.text, start, end);
        }
        if let Token::Unit(_) = self.peek() {
            let fault =
                self.fault("a unit in brackets must follow a number, as in `0.5[m]`").label("no number before it");
            return fault.help("a name has the unit of its parameter, input or variable");
        }
        let found = match self.peek() {
            Token::End => "ends too early".to_string(),
            _ => format!("cannot be read at `{}`", &self.text.text[self.place().0..self.place().1]),
        };
        self.fault(&format!("the expression `{}` {found}", shortened(&self.text.text)))
            .label(format!("expected {what}"))
    }
}

fn count(arguments: usize) -> String {
    match arguments {
        0 => "no arguments".to_string(),
        1 => "1 argument".to_string(),
        more => format!("{more} arguments"),
    }
}

/// A text that fits into a message.
pub(crate) fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    if text.chars().count() <= MOST { text.to_string() } else { text.chars().take(MOST).chain("...".chars()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::formula_of_numbers;
    use crate::scene::constant::evaluate;

    fn value(text: &str) -> f64 {
        evaluate(&formula_of_numbers(text).unwrap(), &[])
    }

    #[test]
    fn precedence() {
        assert_eq!(value("-2^2"), -4.0);
        assert_eq!(value("2^3^2"), 512.0);
        assert_eq!(value("2^-1"), 0.5);
        assert_eq!(value("2+3*4"), 14.0);
        assert_eq!(value("2-3-4"), -5.0);
        assert_eq!(value("24/4/3"), 2.0);
        assert_eq!(value("(2+3)*-4"), -20.0);
        assert_eq!(value("2*-3^2"), -18.0);
        assert_eq!(value("if(1 <= 2, min(3, 4), 5)"), 3.0);
        assert_eq!(value("atan2(1, 1)*4 - pi"), 0.0);
        assert_eq!(value("1.5e1 + .5 + 2."), 17.5);
        assert_eq!(value("2*500[g]"), 1.0);
        assert_eq!(value("-3 [N/mm]^2"), -9e6);
        assert_eq!(value("180[deg]/pi"), 1.0);
    }

    #[test]
    fn faults_point_at_the_place() {
        let cases = [
            ("2 * ", "scene::bad_expression", (4, 4)),
            ("foo(1)", "scene::unknown_function", (0, 3)),
            ("1 + atan2(1)", "scene::bad_expression", (4, 12)),
            ("a < b", "scene::bad_expression", (2, 3)),
            ("if(a, 1, 2)", "scene::bad_expression", (4, 5)),
            ("x + 3 mm", "scene::unit_in_expression", (4, 8)),
            ("x + 2 pi", "scene::bad_expression", (6, 8)),
            ("2(x + 1)", "scene::bad_expression", (1, 2)),
            ("x y", "scene::bad_expression", (2, 3)),
            ("x + 3[mn]", "scene::unknown_unit", (6, 8)),
            ("x[mm]", "scene::bad_expression", (1, 5)),
            ("x + 3[mm", "scene::bad_expression", (5, 6)),
            ("2 & 3", "scene::bad_expression", (2, 3)),
            ("(1 + 2", "scene::bad_expression", (6, 6)),
            ("x**2", "scene::bad_expression", (1, 3)),
        ];
        for (text, code, (start, end)) in cases {
            let fault = parse(&Text::new(text, crate::scene::Span::new(0, text.len()))).unwrap_err();
            assert_eq!((fault.code, fault.span.start, fault.span.end), (code, start, end), "{text}: {fault:?}");
        }
    }

    #[test]
    fn depth_is_limited() {
        for text in ["(".repeat(100_000), "-".repeat(100_000), "2^".repeat(100_000), "1+".repeat(100_000) + "1"] {
            assert_eq!(parse(&Text::from(text)).unwrap_err().code, "scene::bad_expression");
        }
    }
}
