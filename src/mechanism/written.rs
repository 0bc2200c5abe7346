//! Formulas as text, with the user's names.

use super::{BinaryOperator, Comparison, Formula, Mechanism};

/// How tightly an operation binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Sign,
    Power,
    Whole,
}

impl Mechanism {
    /// A formula as a scene could write it, in SI units.
    pub fn written(&self, formula: &Formula) -> String {
        self.write(formula).0
    }

    fn write(&self, formula: &Formula) -> (String, Binding) {
        let list = |arguments: &[Formula]| {
            let arguments: Vec<String> = arguments.iter().map(|argument| self.written(argument)).collect();
            arguments.join(", ")
        };
        match formula {
            Formula::Number(value) if *value < 0.0 => (value.to_string(), Binding::Sign),
            Formula::Number(value) => (value.to_string(), Binding::Whole),
            Formula::Time => ("t".into(), Binding::Whole),
            Formula::Parameter(id) => (self.parameters[id.0].name.clone(), Binding::Whole),
            Formula::Input(id) => (self.inputs[id.0].name.clone(), Binding::Whole),
            Formula::Variable(variable) => (self.variable_name(*variable), Binding::Whole),
            Formula::Negate(inner) => (format!("-{}", self.within(inner, Binding::Sign)), Binding::Sign),
            Formula::Binary(operator, sides) => {
                let (sign, own, left, right) = match operator {
                    BinaryOperator::Add => ("+", Binding::Sum, Binding::Sum, Binding::Sum),
                    BinaryOperator::Subtract => ("-", Binding::Sum, Binding::Sum, Binding::Product),
                    BinaryOperator::Multiply => ("*", Binding::Product, Binding::Product, Binding::Product),
                    BinaryOperator::Divide => ("/", Binding::Product, Binding::Product, Binding::Power),
                    BinaryOperator::Power => ("^", Binding::Power, Binding::Whole, Binding::Power),
                };
                (format!("{}{sign}{}", self.within(&sides[0], left), self.within(&sides[1], right)), own)
            }
            Formula::Call(function, arguments) => (format!("{}({})", function.name(), list(arguments)), Binding::Whole),
            Formula::If(comparison, parts) => {
                let sign = match comparison {
                    Comparison::Less => "<",
                    Comparison::LessEqual => "<=",
                    Comparison::Greater => ">",
                    Comparison::GreaterEqual => ">=",
                };
                let [left, right] = [0, 1].map(|side| self.written(&parts[side]));
                (format!("if({left} {sign} {right}, {})", list(&parts[2..])), Binding::Whole)
            }
        }
    }

    /// In parentheses if it binds less tightly than what is around it.
    fn within(&self, formula: &Formula, around: Binding) -> String {
        let (text, own) = self.write(formula);
        if own < around { format!("({text})") } else { text }
    }
}
