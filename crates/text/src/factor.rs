//! Factoring: terms with the same parameters are collected, and terms with the same functions of the motion.

use std::collections::BTreeMap;

use super::normal::{Number, ProductTerm, Sum, TermFactor};
use super::weight::by_weight;

pub type Factors = Vec<(TermFactor, i32)>;

impl Sum {
    /// The sum in its shortest form.
    pub fn tidy(self) -> Sum {
        let sum = self.expanded().by_motion().by_parameters();
        match sum.common(|factor| !factor.is_constant()) {
            common if common.is_empty() || sum.0.len() < 2 => sum,
            common => {
                let rest = sum.without(&common).tidy();
                Sum::of(ProductTerm { factors: common, number: Number(1.0) }.times(&rest.product()))
            }
        }
    }

    /// The sum as one product: the common factor of all terms times the rest in parentheses.
    pub fn product(&self) -> ProductTerm {
        match self.0.as_slice() {
            [] => ProductTerm::number(0.0),
            [term] => term.clone(),
            [first, ..] => {
                let common = self.common(|_| true);
                let size = first.number.0.abs();
                let equal = self.0.iter().all(|term| (term.number.0.abs() - size).abs() <= 1e-15 * size);
                let mut rest = self.without(&common);
                let sign = rest.0.first().map_or(1.0, |term| term.number.0.signum());
                let number = if equal { size * sign } else { sign };
                rest.0.iter_mut().for_each(|term| term.number.0 /= number);
                let outside = ProductTerm { factors: common, number: Number(number) };
                outside.times(&ProductTerm::factor(TermFactor::Sum(rest)))
            }
        }
    }

    /// Collects the coefficients of the same function of the motion.
    fn by_motion(self) -> Sum {
        let mut groups: BTreeMap<Factors, Vec<ProductTerm>> = BTreeMap::new();
        for term in self.0 {
            let (factors, motion) = term.split();
            groups.entry(motion).or_default().push(ProductTerm { factors, number: term.number });
        }
        let mut terms = Vec::new();
        for (motion, coefficients) in groups {
            let coefficient = Sum::collect(coefficients).of_parameters();
            if motion.is_empty() {
                terms.extend(coefficient.0);
            } else {
                terms.push(ProductTerm { factors: motion, number: Number(1.0) }.times(&coefficient.product()));
            }
        }
        Sum::collect(terms)
    }

    /// Puts together the parts of the motion that the same parameters multiply.
    fn by_parameters(self) -> Sum {
        let count = self.0.len();
        let mut groups: BTreeMap<(Factors, Number), Vec<ProductTerm>> = BTreeMap::new();
        for term in self.0 {
            let (parameters, motion) = term.split();
            let size = Number(term.number.0.abs());
            let rest = ProductTerm { factors: motion, number: Number(term.number.0.signum()) };
            groups.entry((parameters, size)).or_default().push(rest);
        }
        let mut terms = Vec::new();
        for ((factors, number), rest) in groups {
            let outside = ProductTerm { factors, number };
            // A number alone is factored out only of the whole sum.
            let worth = !outside.factors.is_empty() || (rest.len() == count && number.0 != 1.0);
            if rest.len() > 1 && worth && rest.iter().all(|term| !term.factors.is_empty()) {
                terms.push(outside.times(&Sum::collect(rest).product()));
            } else {
                terms.extend(rest.iter().map(|term| outside.times(term)));
            }
        }
        Sum::collect(terms)
    }

    fn of_parameters(self) -> Sum {
        let weighed = by_weight(&self);
        let plain = self.expanded().shared_parameters();
        weighed.filter(|sum| sum.leaves() <= plain.leaves()).unwrap_or(plain)
    }

    /// Factors the parameter that shortens the sum most out of it, recursively.
    pub(super) fn shared_parameters(self) -> Sum {
        let mut savings: BTreeMap<&TermFactor, usize> = BTreeMap::new();
        for (factor, _) in self.0.iter().flat_map(|term| &term.factors).filter(|(_, power)| *power > 0) {
            *savings.entry(factor).or_default() += factor.leaves();
        }
        let saved = |(factor, sum): &(&TermFactor, usize)| sum - factor.leaves();
        let best = savings.into_iter().rev().max_by_key(saved).filter(|found| saved(found) > 0);
        let Some(best) = best.map(|(factor, _)| factor.clone()) else { return self };
        let has = |term: &ProductTerm| term.factors.iter().any(|(factor, power)| *factor == best && *power > 0);
        let (with, without): (Vec<ProductTerm>, Vec<ProductTerm>) = self.0.into_iter().partition(has);
        let group = Sum(with);
        let common = group.common(|_| true);
        let inner = Sum::collect(group.without(&common).0).shared_parameters();
        let grouped = ProductTerm { factors: common, number: Number(1.0) }.times(&inner.product());
        let rest = Sum::collect(without).shared_parameters();
        Sum::collect(rest.0.into_iter().chain([grouped]))
    }

    pub(super) fn common(&self, of_kind: impl Fn(&TermFactor) -> bool) -> Factors {
        let Some((first, others)) = self.0.split_first() else { return Factors::new() };
        let power_in = |term: &ProductTerm, factor: &TermFactor| {
            term.factors.iter().find(|(other, _)| other == factor).map_or(0, |(_, power)| *power)
        };
        let candidates = first.factors.iter().filter(|(factor, power)| *power > 0 && of_kind(factor));
        let shared = candidates.map(|(factor, power)| {
            let least = others.iter().map(|term| power_in(term, factor)).min().unwrap_or(0).min(*power);
            (factor.clone(), least)
        });
        shared.filter(|(_, power)| *power > 0).collect()
    }

    pub(super) fn without(&self, common: &Factors) -> Sum {
        let divisor = ProductTerm { factors: common.clone(), number: Number(1.0) }.inverse();
        Sum::sorted(self.0.iter().map(|term| term.times(&divisor)).collect())
    }
}
