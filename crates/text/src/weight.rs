//! Augmented inertias: every mass with its lengths, I1 + m1 l5^2 + (m2 + m3)(l5 + l6)^2. Nested sums are expanded, sorted by masses, and divided by
//! the sums of lengths that occurred in them.

use std::collections::{BTreeMap, BTreeSet};

use super::factor::Factors;
use super::normal::{Number, ProductTerm, Sum, TermFactor};

const MOST_TERMS: usize = 80;

/// The form by masses, if there are any and the sum is not too long.
pub fn by_weight(sum: &Sum) -> Option<Sum> {
    let mut lengths = BTreeSet::new();
    sums_of_symbols(sum, &mut lengths);
    let mut by_weight: BTreeMap<Factors, Vec<ProductTerm>> = BTreeMap::new();
    for term in multiplied_out(sum)?.0 {
        let is_weight = |(factor, _): &(TermFactor, i32)| matches!(factor, TermFactor::Symbol(_, true));
        let (weight, factors) = term.factors.into_iter().partition(is_weight);
        by_weight.entry(weight).or_default().push(ProductTerm { factors, number: term.number });
    }
    // Weights with the same lengths are added.
    let mut by_length: BTreeMap<Factors, Vec<ProductTerm>> = BTreeMap::new();
    for (weight, coefficient) in by_weight {
        for part in unrelated(coefficient) {
            let ProductTerm { factors, number } = divided(Sum::collect(part), &lengths);
            by_length.entry(factors).or_default().push(ProductTerm { factors: weight.clone(), number });
        }
    }
    let terms = by_length.into_iter().map(|(factors, weights)| {
        let lengths = ProductTerm { factors, number: Number(1.0) };
        lengths.times(&Sum::collect(weights).product())
    });
    let sum = Sum::collect(terms);
    Some(if sum.0.len() > 1 { Sum::collect([sum.product()]) } else { sum })
}

/// All sums of symbols without weights.
fn sums_of_symbols(sum: &Sum, found: &mut BTreeSet<Sum>) {
    for (factor, _) in sum.0.iter().flat_map(|term| &term.factors) {
        if let TermFactor::Sum(inner) = factor {
            let is_symbol = |term: &ProductTerm| matches!(term.factors.as_slice(), [(TermFactor::Symbol(_, false), 1)]);
            if inner.0.iter().all(is_symbol) {
                found.insert(inner.clone());
            }
            sums_of_symbols(inner, found);
        }
    }
}

/// Without parentheses, but for those with negative powers.
fn multiplied_out(sum: &Sum) -> Option<Sum> {
    let mut terms = Vec::new();
    for term in &sum.0 {
        let mut products = vec![ProductTerm::number(term.number.0)];
        for (factor, power) in &term.factors {
            let (factors, times) = match factor {
                TermFactor::Sum(inner) if *power > 0 => (multiplied_out(inner)?.0, *power),
                _ => (vec![ProductTerm { factors: vec![(factor.clone(), *power)], number: Number(1.0) }], 1),
            };
            for _ in 0..times {
                products = products.iter().flat_map(|product| factors.iter().map(|f| product.times(f))).collect();
                if products.len() + terms.len() > MOST_TERMS {
                    return None;
                }
            }
        }
        terms.extend(products);
    }
    Some(Sum::collect(terms))
}

/// Terms in groups that have no factor in common, directly or through others.
fn unrelated(terms: Vec<ProductTerm>) -> Vec<Vec<ProductTerm>> {
    let mut groups: Vec<Vec<ProductTerm>> = Vec::new();
    for term in terms {
        let meets = |other: &ProductTerm| other.factors.iter().any(|(a, _)| term.factors.iter().any(|(b, _)| a == b));
        let (related, mut apart): (Vec<Vec<ProductTerm>>, Vec<Vec<ProductTerm>>) =
            groups.into_iter().partition(|group| group.iter().any(meets));
        let mut group: Vec<ProductTerm> = related.into_iter().flatten().collect();
        group.push(term);
        apart.push(group);
        groups = apart;
    }
    groups
}

/// A polynomial as a product: the common factor of all terms, the sums that divide it, and the rest.
fn divided(sum: Sum, divisors: &BTreeSet<Sum>) -> ProductTerm {
    let common = sum.common(|_| true);
    let mut outside = ProductTerm { factors: common, number: Number(1.0) };
    let mut rest = sum.without(&outside.factors);
    for divisor in divisors {
        while let Some(quotient) = quotient(&rest, divisor) {
            outside = outside.times(&ProductTerm::factor(TermFactor::Sum(divisor.clone())));
            rest = quotient;
        }
    }
    outside.times(&rest.shared_parameters().product())
}

/// sum / divisor, if nothing remains: division by the first symbol of the divisor, highest power first.
fn quotient(sum: &Sum, divisor: &Sum) -> Option<Sum> {
    let leading = divisor.0.first()?;
    let (symbol, _) = leading.factors.first()?;
    let degree =
        |term: &ProductTerm| term.factors.iter().find(|(factor, _)| factor == symbol).map_or(0, |(_, power)| *power);
    let mut rest = sum.clone();
    let mut quotient = Vec::new();
    for _ in 0..=MOST_TERMS {
        let Some(highest) = rest.0.iter().max_by_key(|term| degree(term)).cloned() else {
            return Some(Sum::collect(quotient));
        };
        if degree(&highest) < 1 {
            return None;
        }
        let part = highest.times(&leading.inverse());
        let product = divisor.0.iter().map(|term| term.times(&part).scaled(-1.0));
        rest = Sum::collect(rest.0.iter().cloned().chain(product));
        quotient.push(part);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::expr::Symbol;

    /// Masses 0..10, lengths from 10 on.
    fn symbol(index: usize) -> ProductTerm {
        ProductTerm::factor(TermFactor::Symbol(Symbol::Parameter(index), index < 10))
    }

    fn sum(indices: &[usize]) -> Sum {
        Sum::collect(indices.iter().map(|&index| symbol(index)))
    }

    #[test]
    fn an_augmented_body_is_found() {
        // I + l6 (m2 + m3)(l5 + l6) + l5 (m1 l5 + (m2 + m3)(l5 + l6)) = I + m1 l5^2 + (m2 + m3)(l5 + l6)^2
        let (inertia, m1, [l5, l6]) = (symbol(0), symbol(1), [10, 11].map(symbol));
        let both = sum(&[2, 3]).product().times(&sum(&[10, 11]).product());
        let inner = Sum::collect([m1.times(&l5), both.clone()]).product();
        let nested = Sum::collect([inertia.clone(), l6.times(&both), l5.times(&inner)]);
        let length = sum(&[10, 11]).product();
        let expected =
            Sum::collect([inertia, m1.times(&l5).times(&l5), sum(&[2, 3]).product().times(&length).times(&length)]);
        assert_eq!(by_weight(&nested), Some(expected));
    }

    #[test]
    fn what_does_not_divide_stays() {
        assert_eq!(quotient(&sum(&[10, 12]), &sum(&[10, 11])), None);
        let square = Sum::collect([symbol(10).times(&symbol(10)), symbol(11).times(&symbol(11)).scaled(-1.0)]);
        let difference = Sum::collect([symbol(10), symbol(11).scaled(-1.0)]);
        assert_eq!(quotient(&square, &sum(&[10, 11])), Some(difference));
    }

    #[test]
    fn long_products_are_left_alone() {
        let long = sum(&[10, 11, 12, 13, 14]).product();
        let product = long.times(&sum(&[15, 16, 17, 18, 19]).product()).times(&sum(&[20, 21, 22, 23]).product());
        assert_eq!(by_weight(&Sum::of(product)), None);
    }
}
