//! Least squares along the floor of long valleys: steps as in [`crate::least`], by orthogonal triangles instead of normal equations.
//!
//! Four-bars that are far apart draw pieces of curves that differ by 1e-9 of their size. Normal equations square what tells them apart and lose it below rounding; triangles do not.
//!
//! Source: A. Bjorck, *Numerical Methods for Least Squares Problems*, 1996, for the elimination of each term's local unknowns and the damping by more rows; the bent steps are those of
//! [`crate::least::minimise`].

use nalgebra::{DMatrix, DVector};

use crate::least::{AHEAD, BEND, EndCriteria, Terms, Unknowns};

/// The damping is at least this: none, beside anything that rounding leaves.
const UNDAMPED: f64 = 1e-24;
/// It starts here: the floor of a valley has been reached already.
const FIRST: f64 = 1e-6;

/// A term whose local unknowns are eliminated: its residuals and derivatives, turned so that only the first rows depend on the local unknowns.
struct Turned<const G: usize, const L: usize, const R: usize> {
    turn: [[f64; R]; R],
    local: [[f64; L]; R],
    shared: [[f64; G]; R],
    slopes: ([[f64; G]; R], [[f64; L]; R]),
    value: [f64; R],
}

impl<const G: usize, const L: usize, const R: usize> Turned<G, L, R> {
    fn new(terms: &impl Terms<G, L, R>, term: usize, at: &Unknowns<G, L>) -> Self {
        let found = terms.at(term, &at.shared, &at.local[term]);
        let mut turn = [[0.0; R]; R];
        (0..R).for_each(|i| turn[i][i] = 1.0);
        let mut local = found.by_local;
        for column in 0..L.min(R) {
            for row in (column + 1..R).rev() {
                let (a, b) = (local[column][column], local[row][column]);
                let size = a.hypot(b);
                if size > 0.0 {
                    let (c, s) = (a / size, b / size);
                    rotate(&mut local, column, row, c, s);
                    rotate(&mut turn, column, row, c, s);
                }
            }
        }
        let mut turned = Turned {
            turn,
            local,
            shared: [[0.0; G]; R],
            slopes: (found.by_shared, found.by_local),
            value: found.value,
        };
        turned.shared = std::array::from_fn(|row| {
            std::array::from_fn(|i| (0..R).map(|k| turn[row][k] * found.by_shared[k][i]).sum())
        });
        turned
    }

    fn turned(&self, value: &[f64; R]) -> [f64; R] {
        std::array::from_fn(|row| (0..R).map(|k| self.turn[row][k] * value[k]).sum())
    }

    /// The change of the local unknowns that belongs to one of the shared ones; none where they change nothing.
    fn local(&self, value: &[f64; R], shared: &[f64; G]) -> Option<[f64; L]> {
        let value = self.turned(value);
        let mut local = [0.0; L];
        for row in (0..L).rev() {
            let along = (0..G).map(|i| self.shared[row][i] * shared[i]).sum::<f64>();
            let others = (row + 1..L).map(|l| self.local[row][l] * local[l]).sum::<f64>();
            local[row] = -(value[row] + along + others) / self.local[row][row];
        }
        local.iter().all(|local| local.is_finite()).then_some(local)
    }
}

fn rotate<const N: usize, const R: usize>(rows: &mut [[f64; N]; R], first: usize, second: usize, c: f64, s: f64) {
    for column in 0..N {
        let (a, b) = (rows[first][column], rows[second][column]);
        (rows[first][column], rows[second][column]) = (c * a + s * b, c * b - s * a);
    }
}

/// All terms at a place.
struct TermsAtPlace<const G: usize, const L: usize, const R: usize> {
    terms: Vec<Turned<G, L, R>>,
    sum: f64,
}

/// A step: of the shared unknowns, and of those of each term.
type Way<const G: usize, const L: usize> = ([f64; G], Vec<[f64; L]>);

impl<const G: usize, const L: usize, const R: usize> TermsAtPlace<G, L, R> {
    fn new(terms: &impl Terms<G, L, R>, at: &Unknowns<G, L>) -> Self {
        let all: Vec<_> = (0..at.local.len()).map(|term| Turned::new(terms, term, at)).collect();
        let sum = all.iter().flat_map(|term| term.value).map(|value| value * value).sum();
        TermsAtPlace { terms: all, sum }
    }

    /// The rows that do not depend on local unknowns, each column in units of its size, with these sizes.
    fn rows(&self) -> (DMatrix<f64>, [f64; G]) {
        let rest = R - L;
        let mut rows = DMatrix::from_fn(rest * self.terms.len(), G, |row, column| {
            self.terms[row / rest].shared[L + row % rest][column]
        });
        let sizes = std::array::from_fn(|column| rows.column(column).norm().max(f64::MIN_POSITIVE.sqrt()));
        (0..G).for_each(|column| rows.column_mut(column).unscale_mut(sizes[column]));
        (rows, sizes)
    }
}

/// The damped rows as a triangle.
struct Damped<'p, const G: usize, const L: usize, const R: usize> {
    place: &'p TermsAtPlace<G, L, R>,
    sizes: [f64; G],
    triangle: nalgebra::QR<f64, nalgebra::Dyn, nalgebra::Dyn>,
    rows: usize,
}

impl<'p, const G: usize, const L: usize, const R: usize> Damped<'p, G, L, R> {
    fn new(place: &'p TermsAtPlace<G, L, R>, (rows, sizes): &(DMatrix<f64>, [f64; G]), damping: f64) -> Self {
        let count = rows.nrows();
        let mut all = rows.clone().resize_vertically(count + G, 0.0);
        (0..G).for_each(|column| all[(count + column, column)] = damping.sqrt());
        Damped { place, sizes: *sizes, triangle: all.qr(), rows: count }
    }

    /// The step for these residuals of the terms.
    fn solve(&self, value: &[[f64; R]]) -> Option<Way<G, L>> {
        let rest = R - L;
        let mut right = DVector::zeros(self.rows + G);
        for (term, (block, value)) in self.place.terms.iter().zip(value).enumerate() {
            let turned = block.turned(value);
            (0..rest).for_each(|row| right[rest * term + row] = -turned[L + row]);
        }
        self.triangle.q_tr_mul(&mut right);
        let mut shared = right.rows(0, G).into_owned();
        self.triangle.r().solve_upper_triangular_mut(&mut shared).then_some(())?;
        let shared: [f64; G] = std::array::from_fn(|column| shared[column] / self.sizes[column]);
        let local: Option<Vec<[f64; L]>> =
            self.place.terms.iter().zip(value).map(|(block, value)| block.local(value, &shared)).collect();
        Some((shared, local?)).filter(|_| shared.iter().all(|shared| shared.is_finite()))
    }

    /// The size of a step.
    fn size(&self, (shared, local): &Way<G, L>) -> f64 {
        let shared = shared.iter().zip(&self.sizes).map(|(value, size)| (value * size).powi(2));
        shared.chain(local.iter().flatten().map(|local| local * local)).sum::<f64>().sqrt()
    }
}

fn moved<const G: usize, const L: usize>(
    from: &Unknowns<G, L>,
    (shared, local): &Way<G, L>,
    share: f64,
) -> Unknowns<G, L> {
    Unknowns {
        shared: std::array::from_fn(|i| from.shared[i] + share * shared[i]),
        local: from
            .local
            .iter()
            .zip(local)
            .map(|(from, way)| std::array::from_fn(|l| from[l] + share * way[l]))
            .collect(),
    }
}

/// The step from a place, bent as the valley is; none if it bends too much.
fn step<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    damped: &Damped<G, L, R>,
    at: &Unknowns<G, L>,
) -> Option<Unknowns<G, L>> {
    let here = &damped.place.terms;
    let values: Vec<[f64; R]> = here.iter().map(|block| block.value).collect();
    let mut way = damped.solve(&values)?;
    let ahead = moved(at, &way, AHEAD);
    let second = |term: usize| -> [f64; R] {
        let there = terms.at(term, &ahead.shared, &ahead.local[term]).value;
        let (by_shared, by_local) = &here[term].slopes;
        std::array::from_fn(|row| {
            let slope = (0..G).map(|i| by_shared[row][i] * way.0[i]).sum::<f64>()
                + (0..L).map(|l| by_local[row][l] * way.1[term][l]).sum::<f64>();
            ((there[row] - values[term][row]) / AHEAD - slope) / AHEAD
        })
    };
    let seconds: Vec<[f64; R]> = (0..here.len()).map(second).collect();
    let bend = damped.solve(&seconds)?;
    let share = damped.size(&bend) / damped.size(&way);
    if share.is_nan() || share > 2.0 * BEND {
        return None;
    }
    if share < BEND {
        (0..G).for_each(|i| way.0[i] += bend.0[i]);
        way.1.iter_mut().zip(&bend.1).for_each(|(way, bend)| (0..L).for_each(|l| way[l] += bend[l]));
    }
    Some(moved(at, &way, 1.0))
}

/// Goes along the floor of a valley to where the sum of squares is least; gives the sum.
pub(crate) fn descend<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    at: &mut Unknowns<G, L>,
    end: EndCriteria,
) -> f64 {
    let mut here = TermsAtPlace::new(terms, at);
    let (mut rows, mut damping, mut small) = (here.rows(), FIRST, 0);
    for _ in 0..end.steps {
        if here.sum.is_nan() || here.sum < end.sum || damping > 1e4 {
            break;
        }
        let next =
            step(terms, &Damped::new(&here, &rows, damping), at).map(|next| (TermsAtPlace::new(terms, &next), next));
        match next.filter(|(there, _)| there.sum < here.sum) {
            Some((there, next)) => {
                small = if here.sum - there.sum < end.share * here.sum { small + 1 } else { 0 };
                (here, *at) = (there, next);
                rows = here.rows();
                damping = (0.2 * damping).max(UNDAMPED);
                if small > SMALL {
                    break;
                }
            }
            None => damping *= 4.0,
        }
    }
    here.sum
}

/// So many steps one after the other that gain next to nothing are the end.
const SMALL: usize = 5;
