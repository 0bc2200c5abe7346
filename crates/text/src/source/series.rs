//! A tape on Taylor series in time: a function in C that computes the coefficients of the rates, each order from those before it.
//!
//! The coefficients of order 0 are the values of the tape, line for line. Those above follow from the rules of [`SeriesWriter::rule`]: sums and products of series, and for a
//! function f the rule of its derivative, k r_k = sum of j a_j f'(a)_(k - j) over j = 1..k (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, I.8), whose series
//! f'(a) follows from the same rules. Where a function has no derivative (a step, a corner) the series of the active side is taken, as by the runtime.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use cotree_fmu::program::Program;
use cotree_fmu::tape::{Operation, Tape};

use super::tape::{Lines, TapeWriter, Value, written};

/// The highest coefficient of positions, rates and states.
pub(super) const ORDER: usize = 8;

/// A value that lines read.
#[derive(Clone, Debug)]
enum Term {
    /// Constant during a step, as it is written.
    Constant(String),
    /// A position, a rate or time: what it is at the start of the step, and the array of its coefficients.
    Known(String, String),
    /// The result of a rule, by its number.
    Series(usize),
}

/// How the coefficient of order k > 0 follows from those of the operands.
#[derive(Clone, Debug)]
enum Rule {
    /// Terms of a sum: the sign, and one factor or two.
    Sum(Vec<(char, Term, Option<Term>)>),
    Quotient(Term, Term),
    Root(Term),
    /// Of a function: the signs, the series of the slopes, and the arguments.
    Chain(Vec<(char, Term, Term)>),
    Power(Term, String),
    /// One of two by a condition.
    Choice(String, Term, Term),
}

/// A line of the function: the name of its value at order 0, how that is computed unless the tape does, and its rule.
struct Series {
    value: String,
    line: Option<String>,
    rule: Rule,
}

impl Rule {
    fn operands(&self) -> Vec<&Term> {
        match self {
            Self::Sum(terms) => terms.iter().flat_map(|(_, a, b)| std::iter::once(a).chain(b)).collect(),
            Self::Chain(terms) => terms.iter().flat_map(|(_, slope, a)| [slope, a]).collect(),
            Self::Quotient(a, b) | Self::Choice(_, a, b) => vec![a, b],
            Self::Root(a) | Self::Power(a, _) => vec![a],
        }
    }

    /// Series whose coefficients of lower order are read.
    fn histories<'t>(&'t self, term: &'t Term) -> Vec<&'t Term> {
        match self {
            Self::Sum(terms) => {
                let products = terms.iter().filter_map(|(_, a, b)| Some([a, b.as_ref()?]));
                products.filter(|factors| !factors.iter().any(|factor| is_constant(factor))).flatten().collect()
            }
            Self::Chain(_) => self.operands(),
            Self::Quotient(_, b) if is_constant(b) => Vec::new(),
            Self::Quotient(_, b) => vec![b, term],
            Self::Root(_) => vec![term],
            Self::Power(a, _) => vec![a, term],
            Self::Choice(..) => Vec::new(),
        }
    }
}

pub(super) struct SeriesWriter<'a, 'b> {
    program: &'a Program,
    tapes: &'b mut TapeWriter<'a>,
    all: Vec<Series>,
}

/// Which series are kept in arrays, as rules read all their coefficients, and where.
type Kept = BTreeMap<usize, usize>;

/// Functions of the text that rules call.
pub(super) const HELPERS: [&str; 6] = ["product", "quotient", "root", "chain", "power", "sign"];

impl<'a, 'b> SeriesWriter<'a, 'b> {
    pub fn new(program: &'a Program, tapes: &'b mut TapeWriter<'a>) -> Self {
        Self { program, tapes, all: Vec::new() }
    }

    /// The function, from the tape of the accelerations.
    pub fn function(mut self) -> String {
        let tape = &self.program.tapes.acceleration;
        let rates = self.program.coordinates.len();
        let results: Vec<u32> = tape.results.iter().take(rates).copied().collect();
        let lines = self.tapes.needed(tape, &results);
        let values = self.tapes.constants(tape, &lines);
        let results = self.series(tape, &lines);
        let needed = self.reached(&results);
        let kept = self.kept(&needed);
        let [begin, end] = [self.begin(kept.len()), self.end(&results, &kept)];
        let mut text = begin + &values;
        needed.iter().filter_map(|number| self.all[*number].line.as_deref()).for_each(|line| text += line);
        // Writing to a string cannot fail.
        for (series, slot) in &kept {
            let _ = writeln!(text, "    s[{slot}][0] = {};", self.all[*series].value);
        }
        for (row, value) in lines.results.iter().enumerate() {
            let _ = writeln!(text, "    v[{row}][1] = {};", written(value));
        }
        text += &format!(
            "    for (k = 1; k < {ORDER}; k++) {{\n        for (i = 0; i < @_COORDINATES; i++) {{\n            q[i][k] = v[i][k - 1] / (double)k;\n        }}\n"
        );
        for number in &needed {
            let coefficient = self.coefficient(*number, &kept);
            let _ = match kept.get(number) {
                Some(slot) => writeln!(text, "        s[{slot}][k] = {coefficient};"),
                None => writeln!(text, "        const double {}k = {coefficient};", self.all[*number].value),
            };
        }
        text + &end
    }

    /// The arrays of the function, and what is known before any rule.
    fn begin(&self, kept: usize) -> String {
        let width = ORDER + 1;
        let arrays = if kept > 0 { format!("    double s[{kept}][{ORDER}];\n") } else { String::new() };
        let mut text = format!(
            "/* Coefficients of the positions, rates and states up to order {ORDER}, each from those of lower order. */\nstatic void @_taylor(const @_model *m, const @_point *x, double q[][{width}], double v[][{width}])\n{{\n    double t[{ORDER}] = {{ x->t, 1.0 }};\n{arrays}"
        );
        if !self.program.followers.is_empty() {
            text += &format!("    double f[@_FOLLOWERS][{ORDER}], f_rate[@_FOLLOWERS][{ORDER}];\n");
        }
        text += "    int i, k;\n    (void)m;\n    (void)t;\n    for (i = 0; i < @_COORDINATES; i++) {\n        q[i][0] = x->q[i];\n    }\n    for (i = 0; i < @_RATES; i++) {\n        v[i][0] = x->v[i];\n    }\n";
        if !self.program.followers.is_empty() {
            text += &format!(
                "    for (i = 0; i < @_FOLLOWERS; i++) {{\n        for (k = 0; k < {ORDER}; k++) {{\n            f[i][k] = k == 0 ? x->f[i] : k == 1 ? x->f_rate[i] : k == 2 ? 0.5 * x->f_acceleration[i] : 0.0;\n            f_rate[i][k] = k == 0 ? x->f_rate[i] : k == 1 ? x->f_acceleration[i] : 0.0;\n        }}\n    }}\n"
            );
        }
        text
    }

    fn end(&self, results: &[Term], kept: &Kept) -> String {
        let mut text = String::new();
        for (row, term) in results.iter().enumerate() {
            let now = self.now(term, kept);
            let _ = writeln!(text, "        v[{row}][k + 1] = {now} / (double)(k + 1);"); // writing to a string cannot fail
        }
        text + &format!(
            "    }}\n    for (i = 0; i < @_COORDINATES; i++) {{\n        q[i][{ORDER}] = v[i][{}] / {ORDER}.0;\n    }}\n}}\n\n",
            ORDER - 1
        )
    }

    /// Makes the series of all lines that are needed; those of the results.
    fn series(&mut self, tape: &Tape, lines: &Lines) -> Vec<Term> {
        let mut terms: Vec<[Term; 2]> = Vec::new();
        for (line, instruction) in tape.instructions().iter().enumerate() {
            let [first, second] = [format!("x{line}"), format!("y{line}")];
            if !lines.needed[line] {
                terms.push([Term::Constant(first), Term::Constant(second)]);
                continue;
            }
            let operands: Vec<Term> = lines.operands[line].iter().map(|value| self.term(value, &terms)).collect();
            terms.push(match instruction.operation {
                Operation::SinCos => self.sine_and_cosine([first, second], &operands[0]),
                operation => [self.add(first, operation, &operands), Term::Constant(second)],
            });
        }
        lines.results.iter().map(|value| self.term(value, &terms)).collect()
    }

    fn term(&self, value: &Value, terms: &[[Term; 2]]) -> Term {
        match value {
            Value::Line(line) => terms[*line][0].clone(),
            Value::Second(line) => terms[*line][1].clone(),
            Value::Known(text) => self.known(text),
        }
    }

    /// Positions, rates, time, and drivers whose acceleration is an input change during a step, all else is constant.
    fn known(&self, text: &str) -> Term {
        let changes = |name: &str| {
            let index = |array: &str| name.strip_prefix(array)?.strip_suffix(']')?.parse::<usize>().ok();
            name == "t"
                || index("q[").is_some_and(|index| index < self.program.mechanical())
                || ["v[", "f[", "f_rate["].iter().any(|array| index(array).is_some())
        };
        match text.strip_prefix("x->").filter(|name| changes(name)) {
            Some(name) => Term::Known(text.to_owned(), name.to_owned()),
            None => Term::Constant(text.to_owned()),
        }
    }

    /// The series of a line.
    fn add(&mut self, value: String, operation: Operation, operands: &[Term]) -> Term {
        let steps = [Operation::Sign, Operation::Floor, Operation::Less, Operation::LessEqual];
        if steps.contains(&operation) || operands.iter().all(is_constant) {
            return Term::Constant(value);
        }
        match operands {
            [base, exponent] if operation == Operation::Power && !is_constant(exponent) => {
                self.power(value, base, exponent)
            }
            _ => {
                let term = self.push(value, None);
                let rule = self.rule(operation, operands, &term);
                self.set(&term, rule);
                term
            }
        }
    }

    /// e^(b ln a), after its exponent: a rule reads the coefficients of an argument up to its own order.
    fn power(&mut self, value: String, base: &Term, exponent: &Term) -> Term {
        let logarithm = self.slope(Operation::Logarithm, std::slice::from_ref(base));
        let product = self.slope(Operation::Multiply, &[exponent.clone(), logarithm]);
        let term = self.push(value, None);
        self.set(&term, Rule::Chain(vec![('+', term.clone(), product)]));
        term
    }

    fn push(&mut self, value: String, line: Option<String>) -> Term {
        self.all.push(Series { value, line, rule: Rule::Sum(Vec::new()) });
        Term::Series(self.all.len() - 1)
    }

    fn set(&mut self, term: &Term, rule: Rule) {
        if let Term::Series(number) = term {
            self.all[*number].rule = rule;
        }
    }

    fn sine_and_cosine(&mut self, [first, second]: [String; 2], angle: &Term) -> [Term; 2] {
        if let Term::Constant(_) = angle {
            return [Term::Constant(first), Term::Constant(second)];
        }
        let [sine, cosine] = [self.push(first, None), self.push(second, None)];
        self.set(&sine, Rule::Chain(vec![('+', cosine.clone(), angle.clone())]));
        self.set(&cosine, Rule::Chain(vec![('-', sine.clone(), angle.clone())]));
        [sine, cosine]
    }

    /// A series that no line of the tape has: part of the slope of a function.
    fn slope(&mut self, operation: Operation, operands: &[Term]) -> Term {
        let given: Vec<String> = operands.iter().map(|operand| self.value(operand)).collect();
        let expression = self.tapes.expression(operation, &given);
        if operands.iter().all(is_constant) {
            return Term::Constant(format!("({expression})"));
        }
        let value = format!("w{}", self.all.len());
        let line = format!("    const double {value} = {expression};\n");
        let term = self.push(value, Some(line));
        let rule = self.rule(operation, operands, &term);
        self.set(&term, rule);
        term
    }

    /// The rule of each operation.
    fn rule(&mut self, operation: Operation, operands: &[Term], term: &Term) -> Rule {
        use Operation as Of;
        let one = || Term::Constant("1.0".to_owned());
        let [a, b, c] = [0, 1, 2].map(|index| operands.get(index).cloned().unwrap_or_else(one));
        let alone = |sign, term: &Term| (sign, term.clone(), None);
        let product = |sign| (sign, a.clone(), Some(b.clone()));
        let [first, second] = [self.value(&a), self.value(&b)];
        match operation {
            Of::Add => Rule::Sum(vec![alone('+', &a), alone('+', &b)]),
            Of::Subtract => Rule::Sum(vec![alone('+', &a), alone('-', &b)]),
            Of::Negate => Rule::Sum(vec![alone('-', &a)]),
            Of::Copy => Rule::Sum(vec![alone('+', &a)]),
            Of::Multiply => Rule::Sum(vec![product('+')]),
            Of::MultiplyAdd => Rule::Sum(vec![product('+'), alone('+', &c)]),
            Of::MultiplySubtract => Rule::Sum(vec![product('+'), alone('-', &c)]),
            Of::SubtractProduct => Rule::Sum(vec![alone('+', &c), product('-')]),
            Of::Divide => Rule::Quotient(a, b),
            Of::SquareRoot => Rule::Root(a),
            Of::Absolute => Rule::Sum(vec![('+', Term::Constant(format!("@_sign({first})")), Some(a))]),
            Of::Exponential => Rule::Chain(vec![('+', term.clone(), a)]),
            Of::Logarithm => Rule::Chain(vec![('+', self.slope(Of::Divide, &[one(), a.clone()]), a)]),
            Of::Tangent => {
                Rule::Chain(vec![('+', self.slope(Of::MultiplyAdd, &[term.clone(), term.clone(), one()]), a)])
            }
            Of::HyperbolicTangent => {
                Rule::Chain(vec![('+', self.slope(Of::SubtractProduct, &[term.clone(), term.clone(), one()]), a)])
            }
            Of::ArcTangent => {
                let size = self.slope(Of::MultiplyAdd, &[a.clone(), a.clone(), one()]);
                Rule::Chain(vec![('+', self.slope(Of::Divide, &[one(), size]), a)])
            }
            Of::ArcSine | Of::ArcCosine => {
                let square = self.slope(Of::SubtractProduct, &[a.clone(), a.clone(), one()]);
                let root = self.slope(Of::SquareRoot, &[square]);
                let sign = if operation == Of::ArcSine { '+' } else { '-' };
                Rule::Chain(vec![(sign, self.slope(Of::Divide, &[one(), root]), a)])
            }
            Of::ArcTangent2 => {
                let square = self.slope(Of::Multiply, &[b.clone(), b.clone()]);
                let size = self.slope(Of::MultiplyAdd, &[a.clone(), a.clone(), square]);
                let sides = [('+', &b, &a), ('-', &a, &b)].into_iter().filter(|(_, _, side)| !is_constant(side));
                let slope = |(sign, other, side): (char, &Term, &Term)| {
                    (sign, self.slope(Of::Divide, &[other.clone(), size.clone()]), side.clone())
                };
                Rule::Chain(sides.map(slope).collect())
            }
            Of::Power => Rule::Power(a, second),
            Of::Minimum => Rule::Choice(format!("{first} < {second} || {first} != {first}"), a, b),
            Of::Maximum => Rule::Choice(format!("{first} > {second} || {first} != {first}"), a, b),
            Of::Select => Rule::Choice(format!("{first} != 0.0"), b, c),
            // Steps have no rule: see `add`; sine and cosine are a pair.
            Of::Sign | Of::Floor | Of::Less | Of::LessEqual | Of::SinCos => Rule::Sum(Vec::new()),
        }
    }

    /// At order 0.
    fn value(&self, term: &Term) -> String {
        match term {
            Term::Constant(value) | Term::Known(value, _) => value.clone(),
            Term::Series(number) => self.all[*number].value.clone(),
        }
    }

    /// At order k.
    fn now(&self, term: &Term, kept: &Kept) -> String {
        match term {
            Term::Constant(_) => "0.0".to_owned(),
            Term::Known(_, array) => format!("{array}[k]"),
            Term::Series(number) => {
                kept.get(number).map_or_else(|| format!("{}k", self.all[*number].value), |slot| format!("s[{slot}][k]"))
            }
        }
    }

    /// The series that the results need, in order.
    fn reached(&self, results: &[Term]) -> BTreeSet<usize> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<&Term> = results.iter().collect();
        while let Some(term) = open.pop() {
            if let Term::Series(number) = term
                && reached.insert(*number)
            {
                open.extend(self.all[*number].rule.operands());
            }
        }
        reached
    }

    fn kept(&self, needed: &BTreeSet<usize>) -> Kept {
        let mut read = BTreeSet::new();
        for &number in needed {
            let term = Term::Series(number);
            for term in self.all[number].rule.histories(&term) {
                if let Term::Series(number) = term {
                    read.insert(*number);
                }
            }
        }
        read.into_iter().enumerate().map(|(slot, number)| (number, slot)).collect()
    }

    /// The rule of a series, as C writes it.
    fn coefficient(&self, number: usize, kept: &Kept) -> String {
        let array = |term: &Term| match term {
            // No rule reads the coefficients of a constant.
            Term::Constant(value) => value.clone(),
            Term::Known(_, array) => array.clone(),
            Term::Series(number) => format!("s[{}]", kept.get(number).copied().unwrap_or_default()),
        };
        let target = array(&Term::Series(number));
        match &self.all[number].rule {
            Rule::Sum(terms) => {
                let moving = terms.iter().filter_map(|(sign, a, b)| {
                    let factors = match b {
                        None if is_constant(a) => return None,
                        None => self.now(a, kept),
                        Some(b) => match [is_constant(a), is_constant(b)] {
                            [true, true] => return None,
                            [true, false] => format!("{} * {}", self.value(a), self.now(b, kept)),
                            [false, true] => format!("{} * {}", self.now(a, kept), self.value(b)),
                            [false, false] => format!("@_product({}, {}, k)", array(a), array(b)),
                        },
                    };
                    Some((*sign, factors))
                });
                sum(moving)
            }
            Rule::Quotient(a, b) if is_constant(b) => format!("{} / {}", self.now(a, kept), self.value(b)),
            Rule::Quotient(a, b) => format!("@_quotient({}, {}, {target}, k)", self.now(a, kept), array(b)),
            Rule::Root(a) => format!("@_root({}, {target}, k)", self.now(a, kept)),
            Rule::Chain(terms) => {
                sum(terms.iter().map(|(sign, slope, a)| (*sign, format!("@_chain({}, {}, k)", array(slope), array(a)))))
            }
            Rule::Power(a, exponent) => format!("@_power({}, {exponent}, {target}, k)", array(a)),
            Rule::Choice(condition, a, b) => {
                format!("{condition} ? {} : {}", self.now(a, kept), self.now(b, kept))
            }
        }
    }
}

fn is_constant(term: &Term) -> bool {
    matches!(term, Term::Constant(_))
}

fn sum(terms: impl Iterator<Item = (char, String)>) -> String {
    let mut text = String::new();
    for (sign, term) in terms {
        match (text.is_empty(), sign) {
            (true, '-') => text = format!("-{term}"),
            (true, _) => text = term,
            (false, _) => text += &format!(" {sign} {term}"),
        }
    }
    if text.is_empty() { "0.0".to_owned() } else { text }
}
