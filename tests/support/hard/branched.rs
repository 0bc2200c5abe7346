//! Bars in trees and loops, one of which is much heavier or much lighter than the others.
//!
//! As for the [chains](super::unlike) the reference is found with numbers of twice the precision, but from other equations: three absolute coordinates for each bar, the forces of all
//! joints, one saddle-point matrix a step, and Taylor series.

use cotree::scene::Scene;
use cotree_fmu::instance::Instance;

use super::four_bar::bar;
use super::reference::Reference;
use super::twofold::Twofold;
use super::unlike::follow;
use super::{Case, Random, law};

const GRAVITY: f64 = 9.81;
/// Orders of the series, and what the last one may contribute to a step.
const ORDER: usize = 24;
const NEGLIGIBLE: f64 = 1e-24;
/// A run lasts no longer than this, nor than so many radians of what oscillates fastest.
const LONGEST: f64 = 0.5;
const RADIANS: f64 = 20.0;
/// What rounding errors may do without a warning.
const ROUNDING: f64 = 1e-11;
/// A smaller pivot means that the joints depend on each other.
const DEPENDENT: f64 = 1e-3;

type Vector = [Twofold; 2];

/// A joint between the point of one bar and that of another, or of the ground.
#[derive(Clone, Copy)]
struct Joint {
    bars: [Option<usize>; 2],
    points: [[f64; 2]; 2],
}

/// Bars and the joints between them.
struct Linkage {
    lengths: Vec<f64>,
    masses: Vec<f64>,
    joints: Vec<Joint>,
    /// So many joints make the tree, the others close loops.
    tree: usize,
    angles: Vec<f64>,
    rates: Vec<f64>,
}

/// A tree of 3 to 9 bars with up to two loops, one bar of which is 1e-8 to 1e8 times as heavy as the others.
pub fn branched(seed: u64) -> Case {
    let mut random = Random(9300 + seed);
    let (linkage, ratio) = loop {
        let drawn = Linkage::draw(&mut random);
        if drawn.0.is_movable() {
            break drawn;
        }
    };
    let count = linkage.lengths.len();
    let stop = f64::min(LONGEST, RADIANS / linkage.fastest());
    let name = format!("branched_{seed}_{count}_bars_{}_loops_{ratio:.0e}", linkage.joints.len() - linkage.tree);
    let names: Vec<String> = (0..count).flat_map(|k| [format!("b{k}.angle"), format!("b{k}.omega")]).collect();
    let times = vec![0.3 * stop, stop];
    let case = Case::new("unlike masses, branched", linkage.scene(&name), stop, vec![]);
    let start = linkage.start(&case, &names);
    let reference = Reference { values: linkage.motion(&start, &times), names, times };
    case.against(reference).within(100.0, ROUNDING)
}

impl Linkage {
    fn draw(random: &mut Random) -> (Self, f64) {
        let count = 3 + (7.0 * random.unit()) as usize;
        let ratio = 10.0_f64.powf(random.between(-8.0, 8.0));
        let lengths: Vec<f64> = (0..count).map(|_| random.between(0.2, 0.6)).collect();
        let mut masses: Vec<f64> = (0..count).map(|_| random.between(0.5, 2.0)).collect();
        let angles: Vec<f64> = (0..count).map(|_| random.between(-3.0, 3.0)).collect();
        let end = |k: usize| [lengths[k] / 2.0, 0.0];
        let mut joints = Vec::new();
        let mut is_end = vec![true; count];
        for k in 0..count {
            let before = if k == 0 || random.unit() < 0.1 {
                None
            } else if random.unit() < 0.6 {
                Some(k - 1)
            } else {
                Some((random.unit() * k as f64) as usize)
            };
            if let Some(before) = before {
                is_end[before] = false;
            }
            joints.push(Joint {
                bars: [before, Some(k)],
                points: [before.map_or([0.0; 2], end), [-lengths[k] / 2.0, 0.0]],
            });
        }
        // An end of the tree is heavy, or any bar.
        let ends: Vec<usize> = (0..count).filter(|&k| is_end[k] || random.unit() < 0.2).collect();
        masses[ends[(random.unit() * ends.len() as f64) as usize]] *= ratio;
        let tree = joints.len();
        let rates = vec![0.0; count];
        let mut linkage = Self { lengths, masses, joints, tree, angles, rates };
        let loops = (random.unit() * 3.0) as usize;
        for k in (0..count).rev().filter(|&k| is_end[k]).take(loops) {
            linkage.close(random, k);
        }
        if linkage.joints.len() == tree {
            linkage.rates = (0..count).map(|_| random.between(-1.0, 1.0)).collect();
        }
        (linkage, ratio)
    }

    /// Joins the end of a bar, where it is, to the ground or to another bar.
    fn close(&mut self, random: &mut Random, k: usize) {
        let place = self.middle(k, 1.0);
        let other = (random.unit() < 0.5).then(|| (random.unit() * self.lengths.len() as f64) as usize);
        let other = other.filter(|&other| other != k);
        let point = other.map_or(place, |other| {
            let (middle, (s, c)) = (self.middle(other, 0.0), self.angles[other].sin_cos());
            let (x, y) = (place[0] - middle[0], place[1] - middle[1]);
            [c * x + s * y, c * y - s * x]
        });
        self.joints.push(Joint { bars: [other, Some(k)], points: [point, [self.lengths[k] / 2.0, 0.0]] });
    }

    /// Where the middle of a bar is, or a point so many half lengths further along it.
    fn middle(&self, k: usize, further: f64) -> [f64; 2] {
        let start = self.joints[k].bars[0].map_or([0.0; 2], |before| self.middle(before, 1.0));
        let (s, c) = self.angles[k].sin_cos();
        let along = self.lengths[k] / 2.0 * (1.0 + further);
        [start[0] + along * c, start[1] + along * s]
    }

    /// Can it move, and do no joints depend on each other where it starts?
    fn is_movable(&self) -> bool {
        let freedoms = self.lengths.len() as i32 - 2 * (self.joints.len() - self.tree) as i32;
        let angles: Vec<Twofold> = self.angles.iter().copied().map(Twofold::from).collect();
        let arms: Vec<Vector> = angles.iter().map(|angle| angle.cosine_and_sine()).collect();
        // Alike bars tell joints that depend on each other best.
        let alike = vec![1.0; self.masses.len()];
        freedoms >= 1 && Factors::new(self.matrix(&alike, &arms)).smallest > DEPENDENT
    }

    fn scene(&self, name: &str) -> Scene {
        let has_loops = self.joints.len() > self.tree;
        let mut scene = Scene::new(name).gravity([0.0, -GRAVITY]);
        let mut bodies: Vec<_> =
            self.masses.iter().zip(&self.lengths).map(|(mass, length)| bar(*mass, *length)).collect();
        let mut names = Vec::new();
        for (index, joint) in self.joints.iter().enumerate() {
            let ends = [0, 1].map(|side| match joint.bars[side] {
                None => format!("ground.p{index}"),
                Some(k) => format!("b{k}.p{index}_{side}"),
            });
            for side in 0..2 {
                match joint.bars[side] {
                    None => scene = scene.ground_point(&format!("p{index}"), joint.points[side]),
                    Some(k) => bodies[k] = bodies[k].clone().point(&format!("p{index}_{side}"), joint.points[side]),
                }
            }
            names.push(ends);
        }
        for (k, body) in bodies.into_iter().enumerate() {
            scene = scene.body(&format!("b{k}"), body);
            let angle = format!("b{k}.angle");
            scene = if has_loops {
                scene.guess(&angle, self.angles[k])
            } else {
                scene.initial(&angle, self.angles[k]).initial(&format!("b{k}.omega"), self.rates[k])
            };
        }
        names.iter().enumerate().fold(scene, |scene, (index, [a, b])| scene.revolute(&format!("j{index}"), a, b))
    }

    /// Angles and rates of the first consistent pose: where loops are closed to the last digit is for the scene to find.
    fn start(&self, case: &Case, names: &[String]) -> Vec<f64> {
        let outputs = names.iter().fold(case.scene.clone(), |scene, name| scene.output(name));
        let model = Case::new(case.family, outputs, case.stop, vec![]).model().expect("a sound scene");
        let mut instance = Instance::new(model);
        instance.setup(0.0, Some(case.stop), Some(1e-12)).expect("times");
        instance.initialise().expect("consistent");
        let start: Vec<f64> = names.iter().map(|name| law::get(&mut instance, name).expect("an output")).collect();
        for (pair, (angle, rate)) in start.chunks(2).zip(self.angles.iter().zip(&self.rates)) {
            assert!((pair[0] - angle).abs() < 1e-9 && (pair[1] - rate).abs() < 1e-9, "{start:?}");
        }
        start
    }

    /// About how fast a bar oscillates that all the others pull [rad/s].
    fn fastest(&self) -> f64 {
        let all: f64 = self.masses.iter().sum();
        let squares = self.masses.iter().zip(&self.lengths).map(|(mass, length)| GRAVITY * all / (mass * length));
        squares.fold(0.0, f64::max).sqrt()
    }

    /// Angles and rates at these times.
    fn motion(&self, start: &[f64], times: &[f64]) -> Vec<Vec<f64>> {
        let count = self.lengths.len();
        let mut angles: Vec<Twofold> = (0..count).map(|k| start[2 * k].into()).collect();
        let rates: Vec<Twofold> = (0..count).map(|k| start[2 * k + 1].into()).collect();
        self.close_loops(&mut angles);
        follow(angles, rates, times, NEGLIGIBLE, |angles, rates| self.series(angles, rates))
    }
}

impl Linkage {
    /// The arm from the middle of a bar to the joint, turned as the bar is.
    fn arm(&self, joint: &Joint, side: usize, [c, s]: Vector) -> Vector {
        let [x, y] = joint.points[side].map(Twofold::from);
        [x * c - y * s, x * s + y * c]
    }

    /// Ends of joints on bars: joint, bar, side, and the sign with which they count.
    fn ends(&self) -> impl Iterator<Item = (usize, usize, usize, Twofold)> {
        let joints = self.joints.iter().enumerate();
        joints.flat_map(|(index, joint)| {
            let side = move |side: usize| Some((index, joint.bars[side]?, side, [-1.0, 1.0][side].into()));
            (0..2).filter_map(side)
        })
    }

    /// [M J^T; J 0]
    fn matrix(&self, masses: &[f64], arms: &[Vector]) -> Vec<Vec<Twofold>> {
        let count = masses.len();
        let size = 3 * count + 2 * self.joints.len();
        let mut matrix = vec![vec![Twofold::default(); size]; size];
        for (k, (mass, length)) in masses.iter().zip(&self.lengths).enumerate() {
            // The inertia is the number that the scene says.
            let own = [*mass, *mass, mass * length * length / 12.0];
            own.into_iter().enumerate().for_each(|(axis, own)| matrix[3 * k + axis][3 * k + axis] = own.into());
        }
        for (index, k, side, sign) in self.ends() {
            let [x, y] = self.arm(&self.joints[index], side, arms[k]);
            let row = 3 * count + 2 * index;
            for (row, column, value) in
                [(row, 0, sign), (row, 2, -(sign * y)), (row + 1, 1, sign), (row + 1, 2, sign * x)]
            {
                matrix[row][3 * k + column] = value;
                matrix[3 * k + column][row] = value;
            }
        }
        matrix
    }

    /// The series of the rates.
    fn series(&self, angles: &[Twofold], rates: &[Twofold]) -> Vec<Vec<Twofold>> {
        let count = angles.len();
        let mut arms: Vec<Vec<Vector>> = angles.iter().map(|angle| vec![angle.cosine_and_sine()]).collect();
        let mut omega: Vec<Vec<Twofold>> = rates.iter().map(|rate| vec![*rate]).collect();
        let first: Vec<Vector> = arms.iter().map(|arm| arm[0]).collect();
        let factors = Factors::new(self.matrix(&self.masses, &first));
        let mut forces: Vec<Vec<Vector>> = vec![Vec::new(); self.joints.len()];
        for k in 0..ORDER {
            for (arm, omega) in arms.iter_mut().zip(&omega) {
                let next = turned(&arm[..k + 1], omega).map(|part| part / (k as f64 + 1.0).into());
                arm.push(next);
            }
            let mut right = vec![Twofold::default(); 3 * count + 2 * self.joints.len()];
            if k == 0 {
                (0..count).for_each(|bar| right[3 * bar + 1] = Twofold::from(-GRAVITY) * self.masses[bar].into());
            }
            for (index, bar, side, sign) in self.ends() {
                let at = |order: usize| self.arm(&self.joints[index], side, arms[bar][order]);
                for order in 1..=k {
                    let ([x, y], [fx, fy]) = (at(order), forces[index][k - order]);
                    right[3 * bar + 2] = right[3 * bar + 2] - sign * (x * fy - y * fx);
                }
                // The second derivative of the arm, without what the new acceleration adds.
                let known = turned(&arms[bar][1..], &omega[bar]).map(|part| part * (k as f64 + 1.0).into());
                let [x, y] = self.arm(&self.joints[index], side, known);
                let row = 3 * count + 2 * index;
                right[row] = right[row] - sign * x;
                right[row + 1] = right[row + 1] - sign * y;
            }
            let found = factors.solve(right);
            for (bar, omega) in omega.iter_mut().enumerate() {
                omega.push(found[3 * bar + 2] / (k as f64 + 1.0).into());
            }
            for (index, force) in forces.iter_mut().enumerate() {
                force.push([0, 1].map(|axis| found[3 * count + 2 * index + axis]));
            }
        }
        omega
    }

    /// Closes the loops by the smallest change of the angles, to twice the precision.
    fn close_loops(&self, angles: &mut [Twofold]) {
        for _ in 0..2 {
            let count = angles.len();
            let arms: Vec<Vector> = angles.iter().map(|angle| angle.cosine_and_sine()).collect();
            // Points and their derivatives along the tree.
            let zero = || (vec![Twofold::default(); 2], vec![vec![Twofold::default(); count]; 2]);
            let mut middles = Vec::new();
            let point = |middles: &[(Vec<Twofold>, Vec<Vec<Twofold>>)], joint: &Joint, side: usize| {
                let Some(k) = joint.bars[side] else {
                    let (_, slopes) = zero();
                    return (joint.points[side].map(Twofold::from).to_vec(), slopes);
                };
                let (mut place, mut slopes) = middles[k].clone();
                let [x, y] = self.arm(joint, side, arms[k]);
                (place[0], place[1]) = (place[0] + x, place[1] + y);
                (slopes[0][k], slopes[1][k]) = (slopes[0][k] - y, slopes[1][k] + x);
                (place, slopes)
            };
            for (k, joint) in self.joints[..self.tree].iter().enumerate() {
                let (mut place, mut slopes) = point(&middles, joint, 0);
                let [x, y] = self.arm(joint, 1, arms[k]);
                (place[0], place[1]) = (place[0] - x, place[1] - y);
                (slopes[0][k], slopes[1][k]) = (slopes[0][k] + y, slopes[1][k] - x);
                middles.push((place, slopes));
            }
            let (mut gaps, mut rows) = (Vec::new(), Vec::new());
            for joint in &self.joints[self.tree..] {
                let ends = [0, 1].map(|side| point(&middles, joint, side));
                for axis in 0..2 {
                    gaps.push(ends[1].0[axis] - ends[0].0[axis]);
                    let slopes = ends[1].1[axis].iter().zip(&ends[0].1[axis]);
                    rows.push(slopes.map(|(b, a)| *b - *a).collect::<Vec<Twofold>>());
                }
            }
            let dot =
                |a: &[Twofold], b: &[Twofold]| a.iter().zip(b).fold(Twofold::default(), |sum, (a, b)| sum + *a * *b);
            let squares: Vec<Vec<Twofold>> =
                rows.iter().map(|row| rows.iter().map(|other| dot(row, other)).collect()).collect();
            let shares = Factors::new(squares).solve(gaps);
            for (row, share) in rows.iter().zip(shares) {
                angles.iter_mut().zip(row).for_each(|(angle, slope)| *angle = *angle - *slope * share);
            }
        }
    }
}

/// i times the last order of the product of rates and arms.
fn turned(arm: &[Vector], omega: &[Twofold]) -> Vector {
    let mut sum = [Twofold::default(); 2];
    for ([c, s], rate) in arm.iter().rev().zip(omega) {
        sum = [sum[0] - *rate * *s, sum[1] + *rate * *c];
    }
    sum
}

/// Factors of a matrix, rows exchanged for the largest pivots.
struct Factors {
    rows: Vec<Vec<Twofold>>,
    order: Vec<usize>,
    smallest: f64,
}

impl Factors {
    fn new(mut rows: Vec<Vec<Twofold>>) -> Self {
        let count = rows.len();
        let mut order: Vec<usize> = (0..count).collect();
        let mut smallest = f64::INFINITY;
        for pivot in 0..count {
            let size = |row: usize| rows[row][pivot].high.abs();
            let best = (pivot..count).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(pivot);
            smallest = smallest.min(size(best));
            rows.swap(pivot, best);
            order.swap(pivot, best);
            let (above, below) = rows.split_at_mut(pivot + 1);
            let own = &above[pivot];
            for row in below.iter_mut().filter(|row| row[pivot].high != 0.0) {
                let factor = row[pivot] / own[pivot];
                row[pivot] = factor;
                for column in pivot + 1..count {
                    row[column] = row[column] - factor * own[column];
                }
            }
        }
        Self { rows, order, smallest }
    }

    fn solve(&self, right: Vec<Twofold>) -> Vec<Twofold> {
        let mut x: Vec<Twofold> = self.order.iter().map(|&row| right[row]).collect();
        for row in 0..x.len() {
            for column in 0..row {
                x[row] = x[row] - self.rows[row][column] * x[column];
            }
        }
        for row in (0..x.len()).rev() {
            for column in row + 1..x.len() {
                x[row] = x[row] - self.rows[row][column] * x[column];
            }
            x[row] = x[row] / self.rows[row][row];
        }
        x
    }
}
