//! Least squares: Levenberg's and Marquardt's method for terms that share some unknowns and have some of their own.
//!
//! Each term, a point of a path or a pose, has `R` residuals, which depend on `G` shared unknowns and on `L` unknowns of its own. Those of its own are
//! eliminated term by term, so that a step costs O(number of terms).

/// The residuals of a task, term by term.
pub(crate) trait Terms<const G: usize, const L: usize, const R: usize> {
    /// How many terms there are.
    fn count(&self) -> usize;
    /// The residuals of a term with their derivatives by the shared unknowns and by its own.
    fn at(&self, term: usize, shared: &[f64; G], local: &[f64; L]) -> TermResiduals<G, L, R>;
}

/// Residuals of one term and their derivatives.
pub(crate) struct TermResiduals<const G: usize, const L: usize, const R: usize> {
    pub value: [f64; R],
    pub by_shared: [[f64; G]; R],
    pub by_local: [[f64; L]; R],
}

impl<const G: usize, const L: usize, const R: usize> TermResiduals<G, L, R> {
    pub fn zero() -> Self {
        TermResiduals { value: [0.0; R], by_shared: [[0.0; G]; R], by_local: [[0.0; L]; R] }
    }
}

/// Values of all unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns<const G: usize, const L: usize> {
    pub shared: [f64; G],
    pub local: Vec<[f64; L]>,
}

/// When to end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EndCriteria {
    /// After so many steps.
    pub steps: usize,
    /// Where the sum of squares is below this.
    pub sum: f64,
    /// Where a step makes the sum less by this share only.
    pub share: f64,
}

impl EndCriteria {
    pub fn after(steps: usize) -> EndCriteria {
        EndCriteria { steps, sum: 1e-28, share: 1e-9 }
    }
}

/// The normal equations of one term's local unknowns.
#[derive(Clone)]
struct LocalEquations<const G: usize, const L: usize> {
    square: [[f64; L]; L],
    coupling: [[f64; G]; L],
}

/// A right side of the normal equations.
struct Right<const G: usize, const L: usize> {
    shared: [f64; G],
    local: Vec<[f64; L]>,
}

/// The normal equations at a place, and the residuals that they are made of.
struct Normal<const G: usize, const L: usize, const R: usize> {
    sum: f64,
    square: [[f64; G]; G],
    blocks: Vec<LocalEquations<G, L>>,
    residuals: Vec<TermResiduals<G, L, R>>,
}

impl<const G: usize, const L: usize, const R: usize> Normal<G, L, R> {
    fn empty() -> Self {
        Normal { sum: 0.0, square: [[0.0; G]; G], blocks: Vec::new(), residuals: Vec::new() }
    }

    fn fill(&mut self, terms: &impl Terms<G, L, R>, at: &Unknowns<G, L>) {
        (self.sum, self.square) = (0.0, [[0.0; G]; G]);
        self.blocks.clear();
        self.residuals.clear();
        for (term, local) in at.local.iter().enumerate() {
            let found = terms.at(term, &at.shared, local);
            let mut block = LocalEquations { square: [[0.0; L]; L], coupling: [[0.0; G]; L] };
            for row in 0..R {
                let (shared, mine) = (&found.by_shared[row], &found.by_local[row]);
                self.sum += found.value[row] * found.value[row];
                for i in 0..G {
                    for j in 0..=i {
                        self.square[i][j] += shared[i] * shared[j];
                    }
                }
                for i in 0..L {
                    for j in 0..L {
                        block.square[i][j] += mine[i] * mine[j];
                    }
                    for j in 0..G {
                        block.coupling[i][j] += mine[i] * shared[j];
                    }
                }
            }
            self.blocks.push(block);
            self.residuals.push(found);
        }
    }

    /// The right side for residuals in place of those that are there.
    fn right(&self, value: impl Fn(usize) -> [f64; R]) -> Right<G, L> {
        let mut right = Right { shared: [0.0; G], local: Vec::with_capacity(self.residuals.len()) };
        for (term, found) in self.residuals.iter().enumerate() {
            let (value, mut local) = (value(term), [0.0; L]);
            for row in 0..R {
                (0..G).for_each(|i| right.shared[i] -= found.by_shared[row][i] * value[row]);
                (0..L).for_each(|i| local[i] -= found.by_local[row][i] * value[row]);
            }
            right.local.push(local);
        }
        right
    }
}

/// Cholesky's factor of a symmetric matrix, of which the lower half is read; none if it is not positive definite.
pub(crate) fn factor<const N: usize>(mut a: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    for j in 0..N {
        for k in 0..j {
            let by = a[j][k];
            for i in j..N {
                a[i][j] -= a[i][k] * by;
            }
        }
        if a[j][j].is_nan() || a[j][j] <= 0.0 {
            return None;
        }
        let root = a[j][j].sqrt();
        for i in j..N {
            a[i][j] /= root;
        }
    }
    Some(a)
}

pub(crate) fn solve<const N: usize>(factor: &[[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for i in 0..N {
        for j in 0..i {
            b[i] -= factor[i][j] * b[j];
        }
        b[i] /= factor[i][i];
    }
    for i in (0..N).rev() {
        for j in i + 1..N {
            b[i] -= factor[j][i] * b[j];
        }
        b[i] /= factor[i][i];
    }
    b
}

/// No unknown of a term changes by more than this in a step: most are angles.
const LONGEST: f64 = 1.0;

/// The normal equations, damped and factored.
struct Factored<'n, const G: usize, const L: usize> {
    blocks: &'n [LocalEquations<G, L>],
    local: Vec<[[f64; L]; L]>,
    shared: [[f64; G]; G],
}

impl<'n, const G: usize, const L: usize> Factored<'n, G, L> {
    /// None if the equations cannot be solved.
    fn new<const R: usize>(normal: &'n Normal<G, L, R>, damping: f64) -> Option<Self> {
        let mut square = normal.square;
        let mut local = Vec::with_capacity(normal.blocks.len());
        for block in &normal.blocks {
            let mut damped = block.square;
            (0..L).for_each(|i| damped[i][i] += damping * damped[i][i] + 1e-12);
            let factor = factor(damped)?;
            for i in 0..G {
                let column = solve(&factor, std::array::from_fn(|l| block.coupling[l][i]));
                for l in 0..L {
                    for j in i..G {
                        square[j][i] -= block.coupling[l][j] * column[l];
                    }
                }
            }
            local.push(factor);
        }
        (0..G).for_each(|i| square[i][i] += damping * normal.square[i][i].max(1e-6) + 1e-14);
        Some(Factored { blocks: &normal.blocks, local, shared: factor(square)? })
    }

    fn solve(&self, mut right: Right<G, L>) -> Right<G, L> {
        let terms = || self.blocks.iter().zip(&self.local);
        for ((block, factor), local) in terms().zip(&right.local) {
            let reduced = solve(factor, *local);
            for l in 0..L {
                (0..G).for_each(|i| right.shared[i] -= block.coupling[l][i] * reduced[l]);
            }
        }
        right.shared = solve(&self.shared, right.shared);
        for ((block, factor), local) in terms().zip(&mut right.local) {
            (0..L).for_each(|l| local[l] -= (0..G).map(|i| block.coupling[l][i] * right.shared[i]).sum::<f64>());
            *local = solve(factor, *local);
        }
        right
    }
}

/// How far along a step its bend is measured, and how large the bend may be beside it.
pub(crate) const AHEAD: f64 = 0.1;
pub(crate) const BEND: f64 = 0.375;

fn moved<const G: usize, const L: usize>(
    from: &Unknowns<G, L>,
    way: &Right<G, L>,
    share: f64,
    to: &mut Unknowns<G, L>,
) {
    to.shared = std::array::from_fn(|i| from.shared[i] + share * way.shared[i]);
    to.local.clear();
    let local = from.local.iter().zip(&way.local);
    to.local.extend(local.map(|(local, way)| -> [f64; L] {
        std::array::from_fn(|l| local[l] + share * way[l].clamp(-LONGEST, LONGEST))
    }));
}

/// The unknowns after a step that is damped so much and bent as the valley is; none if there is no such step.
fn step<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    normal: &Normal<G, L, R>,
    at: &Unknowns<G, L>,
    damping: f64,
    next: &mut Unknowns<G, L>,
) -> Option<()> {
    let factored = Factored::new(normal, damping)?;
    let mut way = factored.solve(normal.right(|term| normal.residuals[term].value));
    moved(at, &way, AHEAD, next);
    // The second derivative of the residuals along the step.
    let second = |term: usize| -> [f64; R] {
        let (here, there) = (&normal.residuals[term], terms.at(term, &next.shared, &next.local[term]).value);
        std::array::from_fn(|row| {
            let slope = (0..G).map(|i| here.by_shared[row][i] * way.shared[i]).sum::<f64>()
                + (0..L).map(|l| here.by_local[row][l] * way.local[term][l]).sum::<f64>();
            ((there[row] - here.value[row]) / AHEAD - slope) / AHEAD
        })
    };
    let bend = factored.solve(normal.right(second));
    let size = |way: &Right<G, L>| {
        let shared = (0..G).map(|i| way.shared[i] * way.shared[i] * normal.square[i][i].max(1e-6));
        let local = way.local.iter().flatten().map(|local| local * local);
        shared.chain(local).sum::<f64>().sqrt()
    };
    let share = size(&bend) / size(&way);
    if share.is_finite() && share < BEND {
        (0..G).for_each(|i| way.shared[i] += bend.shared[i]);
        way.local.iter_mut().zip(&bend.local).for_each(|(way, bend)| (0..L).for_each(|l| way[l] += bend[l]));
    } else if share.is_nan() || share > 2.0 * BEND {
        return None;
    }
    moved(at, &way, 1.0, next);
    Some(())
}

/// Makes the sum of squares least from a start on; gives the sum.
///
/// Source: K. Levenberg 1944, D. Marquardt 1963, with Marquardt's scaling, the damping falling to 0.3 of itself or doubling; the steps bent along valleys:
/// M. K. Transtrum, J. P. Sethna, *Geodesic acceleration and the small-curvature approximation for nonlinear least squares*, 2012.
pub(crate) fn minimise<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    at: &mut Unknowns<G, L>,
    end: EndCriteria,
) -> f64 {
    debug_assert_eq!(terms.count(), at.local.len());
    let (mut here, mut there) = (Normal::empty(), Normal::empty());
    let mut next = at.clone();
    here.fill(terms, at);
    let mut damping = 1e-2;
    for _ in 0..end.steps {
        if here.sum.is_nan() || here.sum < end.sum || damping > 1e8 {
            break;
        }
        let moved = step(terms, &here, at, damping, &mut next).is_some();
        if moved {
            there.fill(terms, &next);
        }
        if moved && there.sum < here.sum {
            let gained = here.sum - there.sum;
            let small = gained < end.share * here.sum;
            std::mem::swap(&mut here, &mut there);
            std::mem::swap(at, &mut next);
            damping = (damping * 0.3f64).max(1e-12);
            if small {
                break;
            }
        } else {
            damping *= 2.0;
        }
    }
    here.sum
}
