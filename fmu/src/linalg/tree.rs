//! Arms that hang from each other: sums over masses and factors of their matrix, at a cost that grows with their number.
//!
//! For an arm k and an arm l further out the masses are A_kl = conj(z) m_l, where z is the place along k where the next arm on the way to l begins and m_l the
//! first moment of what l carries; A_lk is the conjugate, all other arms are not coupled. So forces A b'' follow from one walk outwards and one inwards. With
//! derivatives b' of the arms, c = z b'_k and d_l = m_l b'_l the mass matrix is M_kl = c . d_l (c of the branch from k towards l). Its factors L D L^T, from the
//! tips to the ground, follow from a symmetric 2 x 2 matrix that is handed on from arm to arm (as the inertia in the method of articulated bodies is;
//! Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7).

use super::SINGULAR;
use super::chain::{Complex, conjugate, product};
use super::matrix::most;
use super::number::Number;

/// An arm with what it carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limb<N = f64> {
    /// Place of the arm.
    pub place: usize,
    /// Place of its derivative by its unknown.
    pub derivative: usize,
    /// Its parent, an earlier one.
    pub parent: Option<usize>,
    /// The equation of its unknown; none if its motion is prescribed.
    pub equation: Option<usize>,
    /// z: where it begins along the arm of its parent.
    pub begin: Complex<N>,
    /// m
    pub carried: Complex<N>,
    /// What resists its acceleration by itself.
    pub inertia: N,
}

/// Coefficients of a limb: z, m, and the inertia.
pub(crate) type Masses = ([u32; 2], [u32; 2], u32);

/// All limbs, each after its parent.
#[derive(Clone, Debug)]
pub(crate) struct Tree<N = f64> {
    limbs: Vec<Limb<N>>,
    masses: Vec<Masses>,
    /// Frames, which come first, have their inertia about their own angle; arms from this place on have a mass along them.
    lines: usize,
    /// Of each limb, on the way: the acceleration of where it begins; the force on what it carries.
    begins: Vec<Complex<N>>,
    forces: Vec<Complex<N>>,
}

impl<N: Number> Tree<N> {
    /// Limbs whose masses will be filled in; those of frames have places before `lines`.
    pub fn new(limbs: Vec<Limb<N>>, masses: Vec<Masses>, lines: usize) -> Self {
        let zeros = vec![[N::ZERO; 2]; limbs.len()];
        Self { limbs, masses, lines, begins: zeros.clone(), forces: zeros }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, c: &[N]) {
        let complex = |place: [u32; 2]| place.map(|part| c[part as usize]);
        for (limb, &(begin, carried, inertia)) in self.limbs.iter_mut().zip(&self.masses) {
            (limb.begin, limb.carried, limb.inertia) = (complex(begin), complex(carried), c[inertia as usize]);
        }
    }

    /// All of them.
    pub fn limbs(&self) -> &[Limb<N>] {
        &self.limbs
    }

    /// Is it a single chain, numbered from the ground?
    pub fn is_chain(&self) -> bool {
        let follows = |(index, limb): (usize, &Limb<N>)| limb.place == index && limb.parent == index.checked_sub(1);
        self.limbs.iter().enumerate().all(follows)
    }

    /// The masses A_kl between two limbs of a chain.
    pub fn between(&self, k: usize, l: usize) -> Complex<N> {
        let mass = |inner: usize, outer: usize| {
            let begin = self.limbs.get(inner + 1).map_or([N::ZERO; 2], |next| next.begin);
            product(conjugate(begin), self.limbs[outer].carried)
        };
        if k < l { mass(k, l) } else { conjugate(mass(l, k)) }
    }

    /// Adds A (x + i y) to the forces on all arms.
    pub fn add_forces(&mut self, [x, y]: [&[N]; 2], [fx, fy]: [&mut [N]; 2]) {
        let Self { limbs, begins, forces, .. } = self;
        for (index, limb) in limbs.iter().enumerate() {
            let place = limb.place;
            begins[index] = limb.parent.map_or([N::ZERO; 2], |parent| {
                let (before, start) = (limbs[parent].place, begins[parent]);
                sum(start, product(limb.begin, [x[before], y[before]]))
            });
            let [gx, gy] = product(conjugate(limb.carried), begins[index]);
            fx[place] += gx;
            fy[place] += gy;
            if place >= self.lines {
                fx[place] += limb.inertia * x[place];
                fy[place] += limb.inertia * y[place];
            }
            forces[index] = product(limb.carried, [x[place], y[place]]);
        }
        for (index, limb) in limbs.iter().enumerate().rev() {
            let Some(parent) = limb.parent else { continue };
            let (force, before) = (forces[index], limbs[parent].place);
            let [gx, gy] = product(conjugate(limb.begin), force);
            fx[before] += gx;
            fy[before] += gy;
            forces[parent] = sum(forces[parent], force);
        }
    }
}

fn sum<N: Number>([a, b]: Complex<N>, [c, d]: Complex<N>) -> Complex<N> {
    [a + c, b + d]
}

fn dot<N: Number>([a, b]: Complex<N>, [c, d]: Complex<N>) -> N {
    a * c + b * d
}

/// The symmetric matrix that is handed on from limb to limb: the sum of g r^T over the limbs further out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carried<N = f64> {
    xx: N,
    xy: N,
    yy: N,
}

impl<N: Number> Carried<N> {
    #[inline(always)]
    pub(super) fn times(&self, [x, y]: Complex<N>) -> Complex<N> {
        [self.xx * x + self.xy * y, self.xy * x + self.yy * y]
    }

    fn add(&mut self, other: Self) {
        *self = Self { xx: self.xx + other.xx, xy: self.xy + other.xy, yy: self.yy + other.yy };
    }

    /// Takes what is left of a limb's d, over its pivot and as it is, in.
    #[inline(always)]
    pub(super) fn hand_on(&mut self, [gx, gy]: Complex<N>, [rx, ry]: Complex<N>) {
        *self = Self { xx: self.xx + gx * rx, xy: self.xy + gx * ry, yy: self.yy + gy * ry };
    }
}

/// The factors L D L^T of the mass matrix of a tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recursion<N = f64> {
    limbs: Vec<Limb<N>>,
    joints: Vec<Joint<N>>,
    /// Limbs that hang from another one than the one before them.
    sides: Vec<Side<N>>,
    /// What comes from them, by the limbs that they hang from; of factors, then of a solution.
    factored: Vec<Branches<N>>,
    solved: Vec<[N; 3]>,
}

/// One pivot.
#[derive(Clone, Copy, Debug, Default)]
struct Joint<N = f64> {
    /// c towards the next limb, zero if that does not hang from this one.
    c: Complex<N>,
    /// What is left of d, over the pivot.
    g: Complex<N>,
    inverse: N,
    /// 1 - g c^T by rows, zero likewise.
    across: [Complex<N>; 2],
    /// The right-hand side over the pivot, on the way.
    rest: N,
    /// Do limbs hang from it besides the next one?
    forks: bool,
}

/// A limb that does not hang from the one before it.
#[derive(Clone, Copy, Debug)]
struct Side<N = f64> {
    limb: usize,
    parent: Option<usize>,
    /// c of the branch.
    c: Complex<N>,
}

/// Sums over side branches: of S, S c, and c . S c.
#[derive(Clone, Copy, Debug, Default)]
struct Branches<N = f64> {
    carried: Carried<N>,
    moved: Complex<N>,
    over: N,
}

impl<N: Number> Recursion<N> {
    /// Storage for these limbs.
    pub fn new(limbs: &[Limb<N>]) -> Self {
        let mut joints = vec![Joint::default(); limbs.len()];
        let mut sides = Vec::new();
        for (index, limb) in limbs.iter().enumerate() {
            if index == 0 || limb.parent != index.checked_sub(1) {
                limb.parent.into_iter().for_each(|parent| joints[parent].forks = true);
                sides.push(Side { limb: index, parent: limb.parent, c: [N::ZERO; 2] });
            }
        }
        let (factored, solved) = (vec![Branches::default(); limbs.len()], vec![[N::ZERO; 3]; limbs.len()]);
        Self { limbs: limbs.to_vec(), joints, sides, factored, solved }
    }

    /// The same limbs with other masses.
    pub fn renew(&mut self, limbs: &[Limb<N>]) {
        self.limbs.copy_from_slice(limbs);
    }

    /// Number of limbs.
    pub fn size(&self) -> usize {
        self.joints.len()
    }

    /// Factors the matrix of arms with these derivatives. False if it is singular.
    // One number after the other: a copy for AVX2 would gain nothing, and old versions of valgrind do not know all of its moves.
    #[inline(never)]
    pub fn factor(&mut self, [dx, dy]: [&[N]; 2]) -> bool {
        let Self { limbs, joints, sides, factored, .. } = self;
        let derivative = |limb: usize| [dx[limbs[limb].derivative], dy[limbs[limb].derivative]];
        let (mut carried, one) = (Carried::default(), N::all(1.0));
        let mut next = sides.len();
        for k in (0..limbs.len()).rev() {
            let (limb, joint, derivative_here) = (&limbs[k], &mut joints[k], derivative(k));
            let follows = limbs.get(k + 1).filter(|child| child.parent == Some(k));
            let c = follows.map_or([N::ZERO; 2], |child| product(child.begin, derivative_here));
            let [qx, qy] = carried.times(c);
            let (mut pivot, [mx, my]) = (limb.inertia - dot(c, [qx, qy]), product(limb.carried, derivative_here));
            let mut r = [mx - qx, my - qy];
            if joint.forks {
                let Branches { carried: others, moved, over } = std::mem::take(&mut factored[k]);
                pivot -= over;
                r = [r[0] - moved[0], r[1] - moved[1]];
                carried.add(others);
            }
            let inverse = if limb.equation.is_some() { one.over(pivot) } else { N::ZERO };
            // Written so that NaN is singular too.
            let regular = pivot.value() > SINGULAR * limb.inertia.value() || limb.equation.is_none();
            if !regular {
                factored.fill(Branches::default());
                return false;
            }
            let g = r.map(|part| part * inverse);
            carried.hand_on(g, r);
            let [[gx, gy], [cx, cy]] = [g, c];
            let across = follows.map_or([[N::ZERO; 2]; 2], |_| [[one - gx * cx, -gx * cy], [-gy * cx, one - gy * cy]]);
            *joint = Joint { c, g, inverse, across, rest: N::ZERO, forks: joint.forks };
            if let Some(side) = sides[..next].last_mut().filter(|side| side.limb == k) {
                next -= 1;
                if let Some(parent) = side.parent {
                    side.c = product(limb.begin, derivative(parent));
                    let [qx, qy] = carried.times(side.c);
                    let branches = &mut factored[parent];
                    branches.carried.add(carried);
                    branches.moved = sum(branches.moved, [qx, qy]);
                    branches.over += dot(side.c, [qx, qy]);
                }
                carried = Carried::default();
            }
        }
        true
    }

    /// The largest share of an inertia M_kk in its pivot, and the equation: so much larger do rounding errors become.
    pub fn cancellation(&self) -> (f64, usize) {
        let pivots = self.joints.iter().zip(&self.limbs).map(|(joint, limb)| (limb.inertia * joint.inverse).value());
        let (size, limb) = most(pivots);
        (size, self.limbs.get(limb).and_then(|limb| limb.equation).unwrap_or_default())
    }

    /// The smallest share of an inertia M_kk that is left as its pivot while all arms lie in line.
    pub fn share_left(limbs: &[Limb<N>]) -> f64 {
        let mut recursion = Self::new(limbs);
        let places = limbs.iter().map(|limb| limb.derivative + 1).max().unwrap_or(0);
        let (ones, zeros) = (vec![N::all(1.0); places], vec![N::ZERO; places]);
        let most = if recursion.factor([&ones, &zeros]) { recursion.cancellation().0 } else { f64::INFINITY };
        1.0 / most
    }

    /// The solution for right-hand sides by equations, at the places of the arms.
    #[inline(never)]
    pub fn solve(&mut self, vector: &[N], solution: &mut [N]) {
        self.reduce(vector);
        self.substitute(solution);
    }

    /// From the tips to the ground.
    #[inline(always)]
    fn reduce(&mut self, vector: &[N]) {
        let Self { limbs, joints, sides, solved, .. } = self;
        let (mut sx, mut sy) = (N::ZERO, N::ZERO);
        let mut next = sides.len();
        let mut begins = sides.last().map_or(usize::MAX, |side| side.limb);
        for (k, (joint, limb)) in joints.iter_mut().zip(limbs.iter()).enumerate().rev() {
            let Joint { c: [cx, cy], g: [gx, gy], inverse, across: [[a, b], [c, d]], forks, rest } = joint;
            let mut value = limb.equation.and_then(|equation| vector.get(equation)).copied().unwrap_or(N::ZERO);
            let mut more = [N::ZERO; 2];
            if *forks {
                let [over, x, y] = std::mem::take(&mut solved[k]);
                value -= over;
                more = [x, y];
            }
            *rest = (value - *cx * sx - *cy * sy) * *inverse;
            (sx, sy) = ((*gx * value + *a * sx) + *b * sy, (*gy * value + *c * sx) + *d * sy);
            if *forks {
                (sx, sy) = (sx + more[0], sy + more[1]);
            }
            if begins == k {
                next -= 1;
                let Side { parent, c: [cx, cy], .. } = sides[next];
                if let Some(parent) = parent {
                    let [over, x, y] = solved[parent];
                    solved[parent] = [over + cx * sx + cy * sy, x + sx, y + sy];
                }
                (sx, sy) = (N::ZERO, N::ZERO);
                begins = sides[..next].last().map_or(usize::MAX, |side| side.limb);
            }
        }
    }

    /// From the ground to the tips.
    #[inline(always)]
    fn substitute(&mut self, solution: &mut [N]) {
        let Self { limbs, joints, sides, solved, .. } = self;
        let (mut tx, mut ty) = (N::ZERO, N::ZERO);
        let mut others = sides.iter();
        let mut side = others.next();
        for (k, (joint, limb)) in joints.iter().zip(limbs.iter()).enumerate() {
            if let Some(Side { parent, c: [cx, cy], .. }) = side.filter(|side| side.limb == k) {
                let [x, ox, oy] = parent.map_or([N::ZERO; 3], |parent| solved[parent]);
                (tx, ty) = (ox + *cx * x, oy + *cy * x);
                side = others.next();
            }
            let Joint { c: [cx, cy], g: [gx, gy], across: [[a, b], [c, d]], rest, forks, .. } = *joint;
            let value = rest - gx * tx - gy * ty;
            if forks {
                solved[k] = [value, tx, ty];
            }
            if limb.equation.is_some() {
                solution[limb.place] = value;
            }
            (tx, ty) = ((cx * rest + a * tx) + c * ty, (cy * rest + b * tx) + d * ty);
        }
        sides.iter().filter_map(|side| side.parent).for_each(|parent| solved[parent] = [N::ZERO; 3]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::lane::{Lane, WIDTH, lanes};
    use nalgebra::{DMatrix, DVector};

    const COUNT: usize = 19;

    /// A tree with branches, two roots, a limb whose motion is prescribed, and a line in the end, whose place is its own.
    fn limbs() -> Vec<Limb> {
        let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(5), Some(0), None, Some(8), Some(9)];
        let parent = |k: usize| if k < parents.len() { parents[k] } else { Some(k - 1 - (k % 3)) };
        let wave = |k: usize, pace: f64| (pace * (k + 1) as f64).sin();
        let mut next = 0;
        let limb = |k: usize| Limb {
            place: k,
            derivative: k,
            parent: parent(k),
            equation: (k != 5).then(|| {
                next += 1;
                next - 1
            }),
            begin: [wave(k, 0.7), wave(k, 1.9)],
            carried: [0.0; 2],
            inertia: 0.0,
        };
        let mut limbs: Vec<Limb> = (0..COUNT).map(limb).collect();
        let mut masses = [0.0; COUNT];
        for k in (0..COUNT).rev() {
            let (mass, at) = (1.5 + wave(k, 2.3), [wave(k, 0.4), wave(k, 3.1)]);
            masses[k] += mass;
            limbs[k].inertia += 0.3 + mass * dot(at, at);
            limbs[k].carried = sum(limbs[k].carried, at.map(|part| mass * part));
            if let Some(parent) = limbs[k].parent {
                let (begin, mass) = (limbs[k].begin, masses[k]);
                masses[parent] += mass;
                limbs[parent].inertia += mass * dot(begin, begin);
                limbs[parent].carried = sum(limbs[parent].carried, begin.map(|part| mass * part));
            }
        }
        limbs
    }

    /// A_kl for all k and l that differ: from the definition, by the paths.
    fn masses(limbs: &[Limb], k: usize, l: usize) -> Complex {
        let mut at = l;
        while let Some(parent) = limbs[at].parent {
            if parent == k {
                return product(conjugate(limbs[at].begin), limbs[l].carried);
            }
            at = parent;
        }
        [0.0; 2]
    }

    fn all_masses(limbs: &[Limb]) -> Vec<Vec<Complex>> {
        let mass = |k: usize, l: usize| sum(masses(limbs, k, l), conjugate(masses(limbs, l, k)));
        (0..COUNT).map(|k| (0..COUNT).map(|l| mass(k, l)).collect()).collect()
    }

    fn waves(pace: f64) -> Vec<Lane> {
        (0..lanes(COUNT)).map(|k| std::array::from_fn(|i| (pace * (k * WIDTH + i) as f64).sin())).collect()
    }

    #[test]
    fn sums_along_a_tree_are_those_over_all_masses() {
        let limbs = limbs();
        let all = all_masses(&limbs);
        let (x, y) = (waves(0.7), waves(1.3));
        let mut tree = Tree::new(limbs.clone(), Vec::new(), COUNT - 1);
        let (mut fx, mut fy) = (vec![0.5; COUNT], vec![-0.5; COUNT]);
        tree.add_forces([x.as_flattened(), y.as_flattened()], [&mut fx, &mut fy]);
        let arm = |k: usize| [x.as_flattened()[k], y.as_flattened()[k]];
        for k in 0..COUNT {
            let others = (0..COUNT).fold([0.5, -0.5], |force, l| sum(force, product(all[k][l], arm(l))));
            // The last one is a line, which has its mass along it.
            let inertia = if k + 1 == COUNT { arm(k).map(|part| limbs[k].inertia * part) } else { [0.0; 2] };
            let expected = sum(others, inertia);
            assert!((fx[k] - expected[0]).abs() + (fy[k] - expected[1]).abs() < 1e-11, "{k}");
        }
    }

    #[test]
    fn the_factors_of_a_tree_solve_its_equations() {
        let limbs = limbs();
        let all = all_masses(&limbs);
        let angles: Vec<f64> = (0..lanes(COUNT) * WIDTH).map(|k| 2.0 * (0.9 * k as f64).sin()).collect();
        let lane = |f: fn(f64) -> f64| angles.iter().map(|a| f(*a)).collect::<Vec<f64>>().as_chunks().0.to_vec();
        let (dx, dy): (Vec<Lane>, Vec<Lane>) = (lane(f64::cos), lane(f64::sin));
        let arm = |k: usize| [dx.as_flattened()[k], dy.as_flattened()[k]];
        let free: Vec<usize> = (0..COUNT).filter(|k| limbs[*k].equation.is_some()).collect();
        let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            let (k, l) = (free[i], free[j]);
            if k == l { limbs[k].inertia } else { dot(arm(k), product(all[k][l], arm(l))) }
        });
        let expected = DVector::from_fn(free.len(), |i, _| 1.0 - 0.3 * i as f64);
        let mut recursion = Recursion::new(&limbs);
        assert!(recursion.factor([dx.as_flattened(), dy.as_flattened()]));
        // Twice: nothing is left of the first solution.
        for _ in 0..2 {
            let mut found = vec![0.0; COUNT];
            recursion.solve((&matrix * &expected).as_slice(), &mut found);
            for (i, &k) in free.iter().enumerate() {
                assert!((found[k] - expected[i]).abs() < 1e-11, "{k}: {} instead of {}", found[k], expected[i]);
            }
        }
        let inverse = matrix.clone().cholesky().expect("a mass matrix").inverse();
        let least = (0..free.len()).map(|i| 1.0 / (matrix[(i, i)] * inverse[(i, i)])).fold(f64::INFINITY, f64::min);
        assert!(1.0 / recursion.cancellation().0 >= least, "{} < {least}", recursion.cancellation().0);
    }

    #[test]
    fn a_tree_that_is_singular_is_said_to_be() {
        let mut limbs = limbs();
        let (ones, zeros) = (vec![1.0; COUNT], vec![0.0; COUNT]);
        let mut recursion = Recursion::new(&limbs);
        assert!(recursion.factor([&ones, &zeros]));
        for inertia in [0.0, f64::NAN] {
            limbs[COUNT - 1].inertia = inertia;
            recursion.renew(&limbs);
            assert!(!recursion.factor([&ones, &zeros]), "{inertia}");
        }
    }
}
