//! The abbreviations of the lesson: a name means the same in all of its sections.

use crate::name::{Name, Names};
use crate::tree::{FormulaTree, Formulas};

/// Names and what they stand for, in the order of their definitions.
#[derive(Debug, Default)]
pub(super) struct Abbreviations(Vec<(Name, FormulaTree)>);

impl Abbreviations {
    /// Formulas whose abbreviations have names that stand for nothing else, and the definitions that are new.
    pub fn settled(&mut self, names: &Names, found: Formulas) -> (Vec<FormulaTree>, Vec<(FormulaTree, FormulaTree)>) {
        let Formulas { angles, definitions, mut formulas } = found;
        let (mut renamed, mut new) = (Vec::new(), Vec::new());
        for (name, mut value) in angles.into_iter().chain(definitions) {
            let FormulaTree::Name(old) = name else { continue };
            rename(&mut value, &renamed);
            let known = self.0.iter().find(|(name, known)| *known == value && (*name == old || !old.is_variable()));
            let name = known.map_or_else(|| self.free(names, &old, &value), |(name, _)| name.clone());
            if known.is_none() {
                self.0.push((name.clone(), value.clone()));
                new.push((FormulaTree::Name(name.clone()), value));
            }
            renamed.push((old, name));
        }
        formulas.iter_mut().for_each(|formula| rename(formula, &renamed));
        (formulas, new)
    }

    /// A name like this one for a new value.
    fn free(&self, names: &Names, like: &Name, value: &FormulaTree) -> Name {
        let is_taken = |name: &Name| self.0.iter().any(|(other, _)| other == name);
        let number = like.subscript.parse().unwrap_or(1);
        match value {
            _ if like.is_variable() => like.clone(),
            FormulaTree::Call(function @ ("sin" | "cos"), argument) if is_angle(names, like, number) => {
                let sine = *function == "sin";
                let other = FormulaTree::Call(if sine { "cos" } else { "sin" }, argument.clone());
                // Sine and cosine of an angle have the same number.
                let known = self.0.iter().find(|(_, value)| *value == other);
                let known = known.and_then(|(name, _)| name.subscript.parse().ok());
                let both = |number: usize| [false, true].map(|sine| names.trigonometric(sine, number));
                let is_free = |number: &usize| !both(*number).iter().any(is_taken);
                let number = known.or_else(|| (number..).find(is_free)).unwrap_or(number);
                names.trigonometric(sine, number)
            }
            _ if !is_taken(like) => like.clone(),
            _ => (1..).map(|number| names.shared(number)).find(|name| !is_taken(name)).unwrap_or_else(|| like.clone()),
        }
    }
}

fn is_angle(names: &Names, name: &Name, number: usize) -> bool {
    [false, true].iter().any(|&sine| names.trigonometric(sine, number) == *name)
}

fn rename(tree: &mut FormulaTree, renamed: &[(Name, Name)]) {
    tree.visit_names(&mut |name| {
        if let Some((_, new)) = renamed.iter().find(|(old, _)| old == name) {
            *name = new.clone();
        }
    });
}
