//! Products of sines and cosines of two angles become one of their sum or difference where that is shorter: c1*c3 + s1*s3 is c2 if the third
//! angle is the first and the second together.

use super::normal::{Number, ProductTerm, Sum, TermFactor};
use super::read::Definition;

/// The sum with such products contracted, also within its parentheses and arguments. Definitions say what named angles are.
pub fn contracted(sum: &Sum, definitions: &[Definition]) -> Sum {
    let mut terms: Vec<ProductTerm> = sum.0.iter().map(|term| within(term, definitions)).collect();
    let mut changed = terms != sum.0;
    while let Some((first, second, term)) = pair(&terms, definitions) {
        terms.remove(second);
        terms[first] = term;
        changed = true;
    }
    if changed { Sum::collect(terms) } else { sum.clone() }
}

fn within(term: &ProductTerm, definitions: &[Definition]) -> ProductTerm {
    let mut product = ProductTerm::number(term.number.0);
    for (factor, power) in &term.factors {
        let inner = match factor {
            TermFactor::Sum(sum) => {
                Some(contracted(sum, definitions)).filter(|inner| inner != sum).map(|inner| inner.product())
            }
            TermFactor::Call(function, arguments) => {
                let arguments = arguments.iter().map(|argument| contracted(argument, definitions)).collect();
                Some(ProductTerm::factor(TermFactor::Call(*function, arguments)))
            }
            _ => None,
        };
        let inner = inner.unwrap_or_else(|| ProductTerm::factor(factor.clone()));
        let inner = if *power < 0 { inner.inverse() } else { inner };
        (0..power.unsigned_abs()).for_each(|_| product = product.times(&inner));
    }
    product
}

/// Two terms that are one, and what they are.
fn pair(terms: &[ProductTerm], definitions: &[Definition]) -> Option<(usize, usize, ProductTerm)> {
    let mut pairs = (0..terms.len()).flat_map(|second| (0..second).map(move |first| (first, second)));
    pairs.find_map(|(first, second)| Some((first, second, together([&terms[first], &terms[second]], definitions)?)))
}

fn together(terms: [&ProductTerm; 2], definitions: &[Definition]) -> Option<ProductTerm> {
    let both = Sum(terms.map(ProductTerm::clone).to_vec());
    let common = both.common(|_| true);
    let outside = ProductTerm { factors: common, number: Number(terms[0].number.0) };
    let [(one, other), (one_too, other_too)] = terms
        .map(|term| two_functions(&term.times(&outside.inverse())))
        .into_iter()
        .collect::<Option<Vec<_>>>()?
        .try_into()
        .ok()?;
    let ratio = terms[1].number.0 / terms[0].number.0;
    let is_pair = one.0 == one_too.0 && other.0 == other_too.0 && one.1 != one_too.1 && other.1 != other_too.1;
    if !is_pair || (ratio.abs() - 1.0).abs() > 1e-15 {
        return None;
    }
    // cos(a)*cos(b) -+ sin(a)*sin(b) = cos(a +- b), sin(a)*cos(b) +- cos(a)*sin(b) = sin(a +- b)
    let is_sine = one.1 != other.1;
    let is_difference = (ratio < 0.0) == is_sine;
    // Of the two terms the one with cos(a)*cos(b), or with sin(a)*cos(b), gives the sign.
    let sign = if one.1 == is_sine { 1.0 } else { ratio };
    let (a, b) = (resolved(&one.0, definitions), resolved(&other.0, definitions));
    let angle = Sum::collect(a.0.into_iter().chain(b.scaled(if is_difference { -1.0 } else { 1.0 }).0));
    let written = |angle: &Sum| if angle.single().is_some() { 1 } else { 2 + angle.leaves() };
    let function = function(angle, is_sine, definitions);
    let length: usize = function
        .factors
        .iter()
        .map(|(factor, _)| if let TermFactor::Trigonometric(angle, _) = factor { written(angle) } else { 1 })
        .sum();
    (length < 2 * (written(&one.0) + written(&other.0))).then(|| outside.scaled(sign).times(&function))
}

/// An angle, and whether it is its sine.
type Of = (Sum, bool);

/// The functions of two angles that a term is the product of, if it is nothing else.
fn two_functions(term: &ProductTerm) -> Option<(Of, Of)> {
    match term.factors.as_slice() {
        [(TermFactor::Trigonometric(a, first), 1), (TermFactor::Trigonometric(b, second), 1)] => {
            Some(((a.clone(), *first), (b.clone(), *second)))
        }
        _ => None,
    }
}

/// The sine or the cosine of an angle, by the name of the angle if it has one.
fn function(angle: Sum, is_sine: bool, definitions: &[Definition]) -> ProductTerm {
    if angle.0.is_empty() {
        return ProductTerm::number(if is_sine { 0.0 } else { 1.0 });
    }
    let opposite = angle.scaled(-1.0);
    let named = |angle: &Sum| {
        let is_it = |definition: &Definition| {
            definition.variable.is_some() && resolved(&definition.value, definitions) == *angle
        };
        let name = |index| Sum::of(ProductTerm::factor(TermFactor::Named(index, angle.is_constant())));
        if angle.single().is_some() { Some(angle.clone()) } else { definitions.iter().position(is_it).map(name) }
    };
    let (angle, sign) = match (named(&angle), named(&opposite)) {
        (Some(angle), _) => (angle, 1.0),
        (None, Some(angle)) => (angle, -1.0),
        (None, None) => (angle, 1.0),
    };
    ProductTerm::factor(TermFactor::Trigonometric(angle, is_sine)).scaled(if is_sine { sign } else { 1.0 })
}

/// An angle without names of other angles.
fn resolved(angle: &Sum, definitions: &[Definition]) -> Sum {
    let parts = angle.0.iter().flat_map(|term| match term.factors.as_slice() {
        [(TermFactor::Named(index, _), 1)] if definitions[*index].variable.is_some() => {
            resolved(&definitions[*index].value, definitions).scaled(term.number.0).0
        }
        _ => vec![term.clone()],
    });
    Sum::collect(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::expr::{Order, Symbol};

    fn angle(index: usize) -> Sum {
        Sum::of(ProductTerm::factor(TermFactor::Symbol(Symbol::Coordinate(index, Order::Position), false)))
    }

    fn plus(a: &Sum, b: &Sum) -> Sum {
        Sum::collect(a.0.iter().chain(&b.0).cloned())
    }

    fn value(sum: &Sum, angles: &[f64; 3], definitions: &[Definition]) -> f64 {
        let factor = |factor: &TermFactor| match factor {
            TermFactor::Symbol(Symbol::Coordinate(index, _), _) => angles[*index],
            TermFactor::Symbol(Symbol::Parameter(_), _) => 0.7,
            TermFactor::Named(index, _) => value(&definitions[*index].value, angles, definitions),
            TermFactor::Trigonometric(angle, true) => value(angle, angles, definitions).sin(),
            TermFactor::Trigonometric(angle, false) => value(angle, angles, definitions).cos(),
            TermFactor::Sum(sum) => value(sum, angles, definitions),
            other => panic!("{other:?}"),
        };
        sum.0
            .iter()
            .map(|term| term.number.0 * term.factors.iter().map(|(of, power)| factor(of).powi(*power)).product::<f64>())
            .sum()
    }

    /// number*f(a)*g(b)*m
    fn product(number: f64, a: (&Sum, bool), b: (&Sum, bool)) -> ProductTerm {
        let of = |(angle, sine): (&Sum, bool)| ProductTerm::factor(TermFactor::Trigonometric(angle.clone(), sine));
        of(a).times(&of(b)).times(&ProductTerm::factor(TermFactor::Symbol(Symbol::Parameter(0), true))).scaled(number)
    }

    /// Every pair of functions with every sign, of angles of which the second is the first and another: both forms have the same values.
    #[test]
    fn what_is_contracted_has_the_same_value_and_is_shorter() {
        let whole = Definition { variable: Some("whole".to_owned()), value: plus(&angle(0), &angle(1)), uses: 1 };
        let definitions = [whole];
        let named = Sum::of(ProductTerm::factor(TermFactor::Named(0, false)));
        let mut contractions = 0;
        for (a, b) in [(&angle(0), &named), (&named, &angle(1)), (&angle(0), &angle(1)), (&angle(2), &angle(1))] {
            for case in 0..16 {
                let [first, second, one, other] = [1, 2, 4, 8].map(|bit| case & bit != 0);
                let sign = |minus| if minus { -1.0 } else { 1.0 };
                let sum = Sum::collect([
                    product(1.5 * sign(one), (a, first), (b, second)),
                    product(1.5 * sign(other), (a, !first), (b, !second)),
                ]);
                let short = contracted(&sum, &definitions);
                contractions += usize::from(short != sum);
                assert!(short == sum || short.leaves() < sum.leaves(), "{short:?}");
                for k in 0..20 {
                    let angles = [0.3 + 1.7 * f64::from(k), -0.9 * f64::from(k * k), 2.1 - 0.37 * f64::from(k)];
                    let (long, short) = (value(&sum, &angles, &definitions), value(&short, &angles, &definitions));
                    assert!((long - short).abs() < 1e-12, "{case}: {long} is not {short}");
                }
            }
        }
        // Half of the cases of the first two are differences; the sum of two coordinates has a name, their difference has none.
        assert_eq!(contractions, 8 + 8 + 8);
    }

    #[test]
    fn what_would_be_longer_or_has_other_coefficients_stays() {
        let (a, b) = (angle(0), angle(2));
        let difference = Sum::collect([product(1.0, (&a, true), (&b, false)), product(-1.0, (&a, false), (&b, true))]);
        assert_eq!(contracted(&difference, &[]), difference, "s1*c3 - c1*s3 is shorter than the sine of a difference");
        let unlike = Sum::collect([product(1.0, (&a, true), (&a, false)), product(2.0, (&b, false), (&b, true))]);
        assert_eq!(contracted(&unlike, &[]), unlike);
    }

    #[test]
    fn angles_that_are_sums_are_written_once() {
        let (a, b) = (plus(&angle(0), &angle(1)), plus(&angle(0), &angle(2)));
        let difference = Sum::collect([product(1.0, (&a, true), (&b, false)), product(-1.0, (&a, false), (&b, true))]);
        let short = contracted(&difference, &[]);
        assert_eq!(short.leaves(), 3, "m*sin(q2 - q3): {short:?}");
    }
}
