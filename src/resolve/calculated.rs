//! Parameters that are expressions of others: in the place of each stands what it is calculated from, so that everything follows what is set.

use std::collections::{BTreeSet, HashMap};

use cotree_fmu::program::domain::Limit;

use super::order::{Pending, Uses, sorted};
use super::parameters::hertz;
use super::{Resolver, UNKNOWN};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::model::{Calculated, Exponents, Formula, Parameter, ParameterId, Unit};
use crate::scene::unit;

/// More operations than a calculated parameter may take when all that it uses is written out.
const LONGEST: usize = 10_000;

/// What a parameter's name stands for in expressions.
pub(super) struct Meaning {
    /// Its place among those with values of their own; nothing for calculated ones.
    id: Option<ParameterId>,
    /// Itself, or what it is calculated from.
    pub formula: Formula,
    pub unit: Option<Exponents>,
    /// How many of its seconds are written as hertz.
    pub hertz: i8,
}

impl Resolver<'_> {
    /// Gives the names of all parameters their meanings, still without values.
    pub(super) fn introduce_parameters(&mut self, declared: &[Option<Unit>], uses: &Uses) {
        let mut ids = 0..;
        for (index, unit) in declared.iter().enumerate() {
            let follows = uses.get(&index).is_some_and(|uses| !uses.is_empty());
            let id = if follows { None } else { ids.next().map(ParameterId) };
            let hertz = hertz(unit.as_ref(), None, self.scene.parameters[index].unit.as_ref());
            let unit = unit.as_ref().map(|unit| unit.exponents);
            self.parameters.push(Meaning { id, formula: id.map_or(UNKNOWN, Formula::Parameter), unit, hertz });
        }
        self.values = vec![f64::NAN; ids.start];
    }

    /// The value of a parameter of its own, or what another one is calculated from.
    pub(super) fn give(&mut self, index: usize, formula: Formula) {
        match self.parameters[index].id {
            Some(id) => self.values[id.0] = self.value(&formula),
            None => self.parameters[index].formula = formula,
        }
    }

    /// What a parameter is calculated from, if it has no value of its own.
    pub(super) fn calculated_from(&self, index: usize) -> Option<Formula> {
        let Meaning { id, formula, .. } = &self.parameters[index];
        id.is_none().then(|| formula.clone())
    }

    /// Its limits hold whatever the others are, and it changes in a run if one of these does.
    pub(super) fn calculated(
        &mut self,
        parameter: Parameter,
        formula: Formula,
        parameters: &[Parameter],
    ) -> Calculated {
        let name = format!("parameter `{}`", parameter.name);
        let limits = [parameter.min.map(Limit::AtLeast), parameter.max.map(Limit::AtMost)];
        limits.into_iter().flatten().for_each(|limit| self.keep_within(name.clone(), &formula, limit));
        let mut tunable = false;
        formula.visit_parameters(&mut |id| tunable |= parameters[id.0].tunable);
        Calculated { parameter: Parameter { tunable, ..parameter }, formula }
    }

    /// Gives the values of expressions to the parameters, each after those that it uses.
    pub(super) fn evaluate_in_order(
        &mut self,
        pending: &HashMap<usize, Pending>,
        uses: &Uses,
        units: &mut [Option<Unit>],
    ) {
        let scene = self.scene;
        let (order, circle) = sorted(uses);
        for index in order {
            self.evaluate(index, &pending[&index], &uses[&index], units);
        }
        let parameters = circle.iter().map(|&index| &scene.parameters[index]);
        let circle: Vec<_> = parameters.map(|parameter| (parameter.name.text.as_str(), parameter.value.span)).collect();
        self.refuse_circle(&circle, "parameters", "give one of them a number");
    }

    fn evaluate(&mut self, index: usize, pending: &Pending, uses: &BTreeSet<usize>, units: &mut [Option<Unit>]) {
        let what = format!("parameter `{}`", self.scene.parameters[index].name.text);
        let Some((formula, known)) = self.constant_tree(&pending.tree, &pending.text, &what) else {
            return;
        };
        let hertz = known.hertz();
        let known = known.unit();
        let found = known.map(unit::from_exponents);
        if let (Some(declared), Some(found)) = (&units[index], &found)
            && !declared.exponents.is_compatible(found.exponents)
        {
            let (declared, found) = (declared.clone(), found.clone());
            self.declared_mismatch(&what, &declared, &found, pending.text.span);
        }
        self.suspect_unit(&what, known, units[index].as_ref(), &pending.text);
        let value = self.value(&formula);
        let spoiled = uses.iter().any(|used| !self.value(&self.parameters[*used].formula).is_finite());
        if !value.is_finite() && !spoiled {
            let message = format!("{what} is not a finite number");
            let label = format!("this is {value}");
            self.faults.push(Fault::new("scene::not_finite", message, pending.text.span).label(label));
        }
        if formula.operations() > LONGEST {
            let message =
                format!("the scene is too large: {what} takes more than {LONGEST} operations when written out");
            let fault = Fault::new("scene::too_large", message, pending.text.span).label("too long when written out");
            self.faults.push(fault.help("give one of the parameters that it uses a number"));
            return;
        }
        self.give(index, formula);
        if units[index].is_none() {
            (self.parameters[index].unit, self.parameters[index].hertz) = (known, hertz);
            units[index] = found;
        }
    }

    /// Warns of an expression of mere numbers whose value could be meant in the declared unit: only a number that stands alone is in it.
    pub(super) fn suspect_unit(&mut self, what: &str, known: Option<Exponents>, declared: Option<&Unit>, text: &Text) {
        let is_mere =
            |unit: &&Unit| known.is_none_or(|known| known == Exponents::NONE && unit.exponents.is_compatible(known));
        let Some(unit) = declared.filter(is_mere) else { return };
        if unit.display.as_ref().is_some_and(|display| display.factor != 1.0) {
            let (written, si) = (unit.shown(), &unit.si);
            let message = format!("{what} is an expression without a unit, so it is in `{si}`, not in `{written}`");
            let fault = Fault::warning("scene::unit_in_expression", message, text.span).label(format!("in `{si}`"));
            self.faults.push(fault.help(format!(
                "give its numbers (`2[{written}]`) or parameters units; or remove `unit` if `{si}` is meant"
            )));
        }
    }
}
