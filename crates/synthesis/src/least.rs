//! Least squares: Levenberg's and Marquardt's method for terms that share some unknowns and have some of their own.
//!
//! Each term, a point of a path or a pose, has `R` residuals, which depend on `G` shared unknowns and on `L` unknowns of its own. Those of its own are
//! eliminated term by term, so that a step costs O(number of terms).

/// The residuals of a task, term by term.
pub(crate) trait Terms<const G: usize, const L: usize, const R: usize> {
    /// How many terms there are.
    fn count(&self) -> usize;
    /// The residuals of a term with their derivatives by the shared unknowns and by its own.
    fn at(&self, term: usize, shared: &[f64; G], own: &[f64; L]) -> Residuals<G, L, R>;
}

/// Residuals of one term and their derivatives.
pub(crate) struct Residuals<const G: usize, const L: usize, const R: usize> {
    pub value: [f64; R],
    pub by_shared: [[f64; G]; R],
    pub by_own: [[f64; L]; R],
}

impl<const G: usize, const L: usize, const R: usize> Residuals<G, L, R> {
    pub fn zero() -> Self {
        Residuals { value: [0.0; R], by_shared: [[0.0; G]; R], by_own: [[0.0; L]; R] }
    }
}

/// Values of all unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns<const G: usize, const L: usize> {
    pub shared: [f64; G],
    pub own: Vec<[f64; L]>,
}

/// When to end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// After so many steps.
    pub steps: usize,
    /// Where the sum of squares is below this.
    pub sum: f64,
    /// Where a step makes the sum less by this share only.
    pub share: f64,
}

impl End {
    pub fn after(steps: usize) -> End {
        End { steps, sum: 1e-28, share: 1e-9 }
    }
}

/// The normal equations of one term's own unknowns.
#[derive(Clone)]
struct Block<const G: usize, const L: usize> {
    square: [[f64; L]; L],
    beside: [[f64; G]; L],
    right: [f64; L],
}

struct Normal<const G: usize, const L: usize> {
    sum: f64,
    square: [[f64; G]; G],
    right: [f64; G],
    blocks: Vec<Block<G, L>>,
}

fn normal<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    at: &Unknowns<G, L>,
    out: &mut Normal<G, L>,
) {
    *out = Normal { sum: 0.0, square: [[0.0; G]; G], right: [0.0; G], blocks: std::mem::take(&mut out.blocks) };
    out.blocks.clear();
    for (term, own) in at.own.iter().enumerate() {
        let found = terms.at(term, &at.shared, own);
        let mut block = Block { square: [[0.0; L]; L], beside: [[0.0; G]; L], right: [0.0; L] };
        for row in 0..R {
            let (value, shared, mine) = (found.value[row], &found.by_shared[row], &found.by_own[row]);
            out.sum += value * value;
            for i in 0..G {
                out.right[i] -= shared[i] * value;
                for j in 0..=i {
                    out.square[i][j] += shared[i] * shared[j];
                }
            }
            for i in 0..L {
                block.right[i] -= mine[i] * value;
                for j in 0..L {
                    block.square[i][j] += mine[i] * mine[j];
                }
                for j in 0..G {
                    block.beside[i][j] += mine[i] * shared[j];
                }
            }
        }
        out.blocks.push(block);
    }
}

/// Cholesky's factor of a symmetric matrix, of which the lower half is read; none if it is not positive definite.
fn factor<const N: usize>(mut a: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
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

fn solve<const N: usize>(factor: &[[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
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

/// The unknowns after a step that is damped so much; none if the equations cannot be solved.
fn step<const G: usize, const L: usize>(
    normal: &Normal<G, L>,
    at: &Unknowns<G, L>,
    damping: f64,
    next: &mut Unknowns<G, L>,
) -> Option<()> {
    let (mut square, mut right) = (normal.square, normal.right);
    let own = |block: &Block<G, L>| {
        let mut square = block.square;
        (0..L).for_each(|i| square[i][i] += damping * square[i][i] + 1e-12);
        factor(square)
    };
    for block in &normal.blocks {
        let factor = own(block)?;
        let reduced = solve(&factor, block.right);
        for i in 0..G {
            let column = solve(&factor, std::array::from_fn(|l| block.beside[l][i]));
            for l in 0..L {
                right[i] -= block.beside[l][i] * reduced[l];
                for j in i..G {
                    square[j][i] -= block.beside[l][j] * column[l];
                }
            }
        }
    }
    (0..G).for_each(|i| square[i][i] += damping * normal.square[i][i].max(1e-6) + 1e-14);
    let change = solve(&factor(square)?, right);
    next.shared = std::array::from_fn(|i| at.shared[i] + change[i]);
    next.own.clear();
    for (block, before) in normal.blocks.iter().zip(&at.own) {
        let rest =
            std::array::from_fn(|l| block.right[l] - (0..G).map(|i| block.beside[l][i] * change[i]).sum::<f64>());
        let way = solve(&own(block)?, rest);
        next.own.push(std::array::from_fn(|l| before[l] + way[l].clamp(-LONGEST, LONGEST)));
    }
    Some(())
}

/// Makes the sum of squares least from a start on; gives the sum.
///
/// Source: K. Levenberg 1944, D. Marquardt 1963, with Marquardt's scaling; the damping falls to 0.3 of itself or doubles.
pub(crate) fn minimise<const G: usize, const L: usize, const R: usize>(
    terms: &impl Terms<G, L, R>,
    at: &mut Unknowns<G, L>,
    end: End,
) -> f64 {
    debug_assert_eq!(terms.count(), at.own.len());
    let empty =
        || Normal { sum: 0.0, square: [[0.0; G]; G], right: [0.0; G], blocks: Vec::with_capacity(at.own.len()) };
    let (mut here, mut there) = (empty(), empty());
    let mut next = at.clone();
    normal(terms, at, &mut here);
    let mut damping = 1e-2;
    for _ in 0..end.steps {
        if here.sum.is_nan() || here.sum < end.sum || damping > 1e8 {
            break;
        }
        let moved = step(&here, at, damping, &mut next).is_some();
        if moved {
            normal(terms, &next, &mut there);
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
