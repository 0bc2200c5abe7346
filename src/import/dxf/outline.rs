//! Chains of straight lines and arcs: distances, and their mass as wires or plates by integrals along them.

/// A polyline; segment k, to the next corner, is an arc where its bulge is not zero: the tangent of a quarter of the angle that it turns by, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct DxfOutline {
    pub corners: Vec<[f64; 2]>,
    pub bulges: Vec<f64>,
    pub closed: bool,
}

/// Mass, mass centre, and moment of inertia about it.
#[derive(Clone, Copy, Debug)]
pub struct Uniform {
    pub mass: f64,
    pub centre: [f64; 2],
    pub inertia: f64,
}

/// Nodes and weights of Gauss and Legendre on [-1, 1], one half: exact to rounding for an arc of less than half a circle.
const GAUSS: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];

/// A place and the derivative by the parameter.
type CurvePoint = ([f64; 2], [f64; 2]);

impl DxfOutline {
    /// Its segments: two ends and the bulge.
    fn segments(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
        let count = self.corners.len();
        let last = if self.closed { count } else { count.saturating_sub(1) };
        (0..last).map(move |index| {
            (self.corners[index], self.corners[(index + 1) % count], self.bulges.get(index).copied().unwrap_or(0.0))
        })
    }

    /// Its segments without arcs.
    pub fn straight(&self) -> Vec<[[f64; 2]; 2]> {
        self.segments().filter(|(a, b, bulge)| *bulge == 0.0 && a != b).map(|(a, b, _)| [a, b]).collect()
    }

    pub fn distance(&self, at: [f64; 2]) -> f64 {
        let of = |(a, b, bulge): ([f64; 2], [f64; 2], f64)| match bulge == 0.0 {
            true => to_segment(at, [a, b]),
            false => to_arc(at, a, b, bulge),
        };
        self.segments().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Is a place within it, if it is closed? By the number of sides to the right; arcs are polygons that keep within 2e-4 of their radius.
    pub fn surrounds(&self, [x, y]: [f64; 2]) -> bool {
        const PIECES: usize = 80;
        let crosses = |a: [f64; 2], b: [f64; 2]| {
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        let of = |(a, b, bulge): ([f64; 2], [f64; 2], f64)| {
            if bulge == 0.0 {
                return usize::from(crosses(a, b));
            }
            // The ends are the corners themselves, so that no side is counted twice or not at all.
            let place = |piece: usize| match piece {
                0 => a,
                PIECES => b,
                _ => curve(a, b, bulge, piece as f64 / PIECES as f64).0,
            };
            (0..PIECES).filter(|&piece| crosses(place(piece), place(piece + 1))).count()
        };
        self.closed && self.segments().map(of).sum::<usize>() % 2 == 1
    }

    /// The integral of a density along it, by the parameter.
    fn integral<const N: usize>(&self, density: impl Fn(CurvePoint) -> [f64; N]) -> [f64; N] {
        let mut sum = [0.0; N];
        for (a, b, bulge) in self.segments() {
            for (node, weight) in GAUSS.iter().flat_map(|(node, weight)| [(*node, *weight), (-node, *weight)]) {
                let values = density(curve(a, b, bulge, 0.5 + 0.5 * node));
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += 0.5 * weight * value);
            }
        }
        sum
    }
}

/// Centre, radius, the angle where an arc begins and the one that it turns by.
fn circle(a: [f64; 2], b: [f64; 2], bulge: f64) -> ([f64; 2], f64, f64, f64) {
    let chord = [b[0] - a[0], b[1] - a[1]];
    let length = chord[0].hypot(chord[1]);
    let turn = 4.0 * bulge.atan();
    let beside = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = [(a[0] + b[0]) / 2.0 - beside * chord[1], (a[1] + b[1]) / 2.0 + beside * chord[0]];
    let radius = length * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
    (centre, radius, (a[1] - centre[1]).atan2(a[0] - centre[0]), turn)
}

fn curve(a: [f64; 2], b: [f64; 2], bulge: f64, t: f64) -> CurvePoint {
    if bulge == 0.0 {
        let along = [b[0] - a[0], b[1] - a[1]];
        return ([a[0] + t * along[0], a[1] + t * along[1]], along);
    }
    let (centre, radius, begin, turn) = circle(a, b, bulge);
    let (sine, cosine) = (begin + t * turn).sin_cos();
    ([centre[0] + radius * cosine, centre[1] + radius * sine], [-radius * turn * sine, radius * turn * cosine])
}

pub fn to_segment(at: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let from = [at[0] - a[0], at[1] - a[1]];
    let t = if square > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - t * along[0]).hypot(from[1] - t * along[1])
}

fn to_arc(at: [f64; 2], a: [f64; 2], b: [f64; 2], bulge: f64) -> f64 {
    let (centre, radius, begin, turn) = circle(a, b, bulge);
    let from = [at[0] - centre[0], at[1] - centre[1]];
    let angle = (from[1].atan2(from[0]) - begin) * turn.signum();
    let full = std::f64::consts::TAU;
    let on_arc = angle.rem_euclid(full) <= turn.abs();
    let ends = [a, b].map(|end| (at[0] - end[0]).hypot(at[1] - end[1]));
    if on_arc { (from[0].hypot(from[1]) - radius).abs() } else { ends[0].min(ends[1]) }
}

/// From the integrals of 1, x, y and x^2 + y^2.
fn uniform([mass, x, y, square]: [f64; 4]) -> Uniform {
    let centre = if mass > 0.0 { [x / mass, y / mass] } else { [x, y] };
    let inertia = square - mass * (centre[0] * centre[0] + centre[1] * centre[1]);
    Uniform { mass, centre, inertia: inertia.max(0.0) }
}

/// Thin rods of so many kg/m along the outlines.
pub fn wire(outlines: &[DxfOutline], density: f64) -> Uniform {
    // About the first corner, so that nothing cancels for a drawing far from its origin.
    let [u, v] = outlines.iter().find_map(|outline| outline.corners.first().copied()).unwrap_or_default();
    let mut sum = [0.0; 4];
    for outline in outlines {
        let integral = outline.integral(|([x, y], [dx, dy])| {
            let (x, y, length) = (x - u, y - v, dx.hypot(dy));
            [length, x * length, y * length, (x * x + y * y) * length]
        });
        sum.iter_mut().zip(integral).for_each(|(sum, integral)| *sum += density * integral);
    }
    let line_mass = uniform(sum);
    Uniform { centre: [line_mass.centre[0] + u, line_mass.centre[1] + v], ..line_mass }
}

/// A plate of so many kg/m2 in closed outlines, those inside others and holes left out, by Green's formula.
pub fn plate(outlines: &[DxfOutline], holes: &[([f64; 2], f64)], density: f64) -> Uniform {
    let closed: Vec<&DxfOutline> = outlines.iter().filter(|outline| outline.closed).collect();
    let [u, v] = closed.first().and_then(|outline| outline.corners.first().copied()).unwrap_or_default();
    let mut sum = [0.0; 4];
    for (index, outline) in closed.iter().enumerate() {
        let integral = outline.integral(|([x, y], [dx, dy])| {
            let (x, y) = (x - u, y - v);
            [0.5 * (x * dy - y * dx), 0.5 * x * x * dy, -0.5 * y * y * dx, (x * x * x * dy - y * y * y * dx) / 3.0]
        });
        let around = closed
            .iter()
            .enumerate()
            .filter(|(other, hole)| *other != index && hole.surrounds(outline.corners[0]))
            .count();
        let sign = integral[0].signum() * if around % 2 == 1 { -1.0 } else { 1.0 };
        sum.iter_mut().zip(integral).for_each(|(sum, integral)| *sum += sign * density * integral);
    }
    for (at, radius) in holes.iter().filter(|(at, _)| closed.iter().any(|outline| outline.surrounds(*at))) {
        let (x, y, mass) = (at[0] - u, at[1] - v, density * std::f64::consts::PI * radius * radius);
        let integral = [mass, mass * x, mass * y, mass * (x * x + y * y + radius * radius / 2.0)];
        sum.iter_mut().zip(integral).for_each(|(sum, integral)| *sum -= integral);
    }
    let plate_mass = uniform(sum);
    Uniform { centre: [plate_mass.centre[0] + u, plate_mass.centre[1] + v], ..plate_mass }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-13 * b.abs().max(1.0)
    }

    /// A stadium: a rectangle 2 by 1 with half discs of radius 1/2 at both ends.
    #[test]
    fn a_stadium_has_the_mass_of_a_rectangle_and_a_disc() {
        let outline = DxfOutline {
            corners: vec![[4.0, 7.0], [6.0, 7.0], [6.0, 8.0], [4.0, 8.0]],
            bulges: vec![0.0, 1.0, 0.0, 1.0],
            closed: true,
        };
        let mass = plate(std::slice::from_ref(&outline), &[], 3.0);
        assert!(
            close(mass.mass, 3.0 * (2.0 + PI / 4.0)) && close(mass.centre[0], 5.0) && close(mass.centre[1], 7.5),
            "{mass:?}"
        );
        // A half disc's centre is 4 r/(3 pi) from its side; about the disc's centre it has m r^2/2.
        let (half, r) = (3.0 * PI / 8.0, 0.5);
        let beside = 4.0 * r / (3.0 * PI);
        let discs = 2.0 * (half * r * r / 2.0 - half * beside * beside + half * (1.0 + beside) * (1.0 + beside));
        assert!(close(mass.inertia, 6.0 * (4.0 + 1.0) / 12.0 + discs), "{mass:?}");
        let holed = plate(&[outline], &[([5.0, 7.5], 0.25)], 3.0);
        let hole = 3.0 * PI / 16.0;
        assert!(close(holed.mass, mass.mass - hole) && close(holed.inertia, mass.inertia - hole / 32.0), "{holed:?}");
    }

    /// A hole in the round end of a bar, about the middle of the arc's chord.
    #[test]
    fn arcs_surround_what_is_behind_their_chords() {
        for turn in [0.0f64, 0.7, 2.0] {
            let (sine, cosine) = turn.sin_cos();
            let turned = |[x, y]: [f64; 2]| [cosine * x - sine * y, sine * x + cosine * y];
            let bar = DxfOutline {
                corners: [[0.0, -5.0], [100.0, -5.0], [100.0, 5.0], [0.0, 5.0]].map(turned).to_vec(),
                bulges: vec![0.0, 1.0, 0.0, 1.0],
                closed: true,
            };
            for (at, inside) in [
                ([100.0, 0.0], true),
                ([104.9, 0.0], true),
                ([-4.9, 0.1], true),
                ([105.1, 0.0], false),
                ([104.0, 4.0], false),
            ] {
                assert_eq!(bar.surrounds(turned(at)), inside, "{at:?} {turn}");
            }
            let mass =
                plate(std::slice::from_ref(&bar), &[(turned([100.0, 0.0]), 2.0), (turned([0.0, 0.0]), 2.0)], 1.0);
            assert!(close(mass.mass, 1000.0 + 25.0 * PI - 8.0 * PI), "{mass:?}");
        }
    }

    #[test]
    fn an_arc_of_wire_has_its_length_and_centre() {
        let arc = DxfOutline { corners: vec![[1.0, 0.0], [0.0, 1.0]], bulges: vec![(PI / 8.0).tan()], closed: false };
        let mass = wire(std::slice::from_ref(&arc), 2.0);
        assert!(close(mass.mass, PI) && close(mass.centre[0], 2.0 / PI) && close(mass.centre[1], 2.0 / PI), "{mass:?}");
        let (on, off) = (arc.distance([0.5f64.sqrt(), 0.5f64.sqrt()]), arc.distance([-1.0, 0.0]));
        assert!(on < 1e-15 && close(off, 2f64.sqrt()), "{on} {off}");
    }
}
