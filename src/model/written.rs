//! Formulas as text, with the user's names.

use super::{Comparison, Formula, Mechanism};
use crate::expr::{Binary, Function, Unary};

/// How tightly an operation binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    Sum,
    Product,
    Sign,
    Power,
    Whole,
}

/// How tightly an operator binds, and what stands on its left and on its right without parentheses; nothing for other functions.
fn bindings(function: Function) -> Option<[Precedence; 3]> {
    use Precedence::{Power, Product, Sum, Whole};
    match function {
        Function::Two(Binary::Add) => Some([Sum, Sum, Sum]),
        Function::Two(Binary::Subtract) => Some([Sum, Sum, Product]),
        Function::Two(Binary::Multiply) => Some([Product, Product, Product]),
        Function::Two(Binary::Divide) => Some([Product, Product, Power]),
        Function::Two(Binary::Power) => Some([Power, Whole, Power]),
        _ => None,
    }
}

impl Mechanism {
    /// A formula as a scene could write it, in SI units.
    pub fn written(&self, formula: &Formula) -> String {
        formula.written(&|symbol| match symbol {
            Formula::Parameter(id) => self.parameters[id.0].name.clone(),
            Formula::Input(id) => self.inputs[id.0].name.clone(),
            Formula::Discrete(id) => self.discrete[id.0].name.clone(),
            Formula::State(id) => self.states[id.0].name.clone(),
            Formula::Variable(variable) => self.variable_name(*variable),
            Formula::Time | Formula::Number(_) | Formula::Call(..) | Formula::If(..) => String::new(),
        })
    }
}

impl Formula {
    /// As a scene could write it, with the name of each parameter, input, state and variable.
    pub(crate) fn written(&self, name: &dyn Fn(&Formula) -> String) -> String {
        self.write(name).0
    }

    fn write(&self, name: &dyn Fn(&Formula) -> String) -> (String, Precedence) {
        let list = |arguments: &[Formula]| {
            let arguments: Vec<String> = arguments.iter().map(|argument| argument.written(name)).collect();
            arguments.join(", ")
        };
        match self {
            Formula::Number(value) if *value < 0.0 => (value.to_string(), Precedence::Sign),
            Formula::Number(value) => (value.to_string(), Precedence::Whole),
            Formula::Time => ("t".into(), Precedence::Whole),
            Formula::Parameter(_)
            | Formula::Input(_)
            | Formula::Discrete(_)
            | Formula::State(_)
            | Formula::Variable(_) => (name(self), Precedence::Whole),
            Formula::Call(Function::One(Unary::Negate), inner) => {
                (format!("-{}", inner[0].within(name, Precedence::Sign)), Precedence::Sign)
            }
            Formula::Call(function, arguments) => match bindings(*function) {
                Some([precedence, left, right]) => {
                    let [left, right] =
                        [(0, left), (1, right)].map(|(side, around)| arguments[side].within(name, around));
                    (format!("{left}{}{right}", function.name()), precedence)
                }
                None => (format!("{}({})", function.name(), list(arguments)), Precedence::Whole),
            },
            Formula::If(comparison, parts) => {
                let sign = match comparison {
                    Comparison::Less => "<",
                    Comparison::LessEqual => "<=",
                    Comparison::Greater => ">",
                    Comparison::GreaterEqual => ">=",
                };
                let [left, right] = [0, 1].map(|side| parts[side].written(name));
                (format!("if({left} {sign} {right}, {})", list(&parts[2..])), Precedence::Whole)
            }
        }
    }

    /// In parentheses if it binds less tightly than what is around it.
    fn within(&self, name: &dyn Fn(&Formula) -> String, around: Precedence) -> String {
        let (text, precedence) = self.write(name);
        if precedence < around { format!("({text})") } else { text }
    }
}
