//! Driven mechanisms whose loops meet, avoid or miss a pose in which two bars lie flat: crossed, followed or refused, by a defect of length from
//! 1e-3 down to 1e-11, or none. The reference is in closed form, with the side on which the bars meet counted.

use std::f64::consts::{PI, TAU};

use cotree::scene::{Driver, Scene};

use super::Case;
use super::four_bar::{FourBar, bar, neutral};
use super::random::Random;
use super::reference::Reference;

/// How long the runs are [s].
const STOP: f64 = 4.0;
/// A result so near to the flat pose is not compared: there a defect of rounding size moves the bars visibly [rad of the crank].
const CLEAR: f64 = 0.05;

/// Rounding errors of a distance [m].
const ROUNDING: f64 = 1e-14;

/// How the crank is driven.
#[derive(Clone, Copy)]
enum Drive {
    /// At this rate.
    Steady(f64),
    /// There and back, with a corner at that time.
    Corner(f64, f64),
    /// Up to an angle at that time, smoothly, and back.
    Touch(f64, f64, f64),
}

impl Drive {
    fn angle(self, from: f64, t: f64) -> f64 {
        match self {
            Drive::Steady(rate) => from + rate * t,
            Drive::Corner(rate, at) => from + rate * (at - (t - at).abs()),
            Drive::Touch(to, at, factor) => to - factor * (t - at) * (t - at),
        }
    }

    fn law(self, from: f64) -> String {
        match self {
            Drive::Steady(rate) => format!("{from:?} + {rate:?}*t"),
            Drive::Corner(rate, at) => format!("{from:?} + {rate:?}*({at:?} - abs(t - {at:?}))"),
            Drive::Touch(to, at, factor) => format!("{to:?} - {factor:?}*(t - {at:?})^2"),
        }
    }
}

/// A defect between 3e-10 and 1e-3 of either sign, or none: branches that miss each other by less than 1e-10 are passed as if they met.
fn defect(random: &mut Random) -> f64 {
    let size = 10.0_f64.powf(random.between(-9.5, -3.0));
    match (random.unit() * 5.0) as u32 {
        0 => 0.0,
        1 | 2 => size,
        _ => -size,
    }
}

/// A four-bar driven through its change point, or past it.
pub fn four_bar(seed: u64) -> Case {
    let mut random = Random(seed);
    let bars = with_defect(neutral(seed), defect(&mut random));
    let rate = random.between(1.6, 3.0) * bars.omega.signum();
    case("driven past a change point", seed, bars, Drive::Steady(rate))
}

/// A four-bar driven up to its change point and back: the rate is zero there, and it may be refused.
pub fn touching(seed: u64) -> Case {
    let mut random = Random(seed);
    let bars = neutral(seed);
    let at: f64 = random.between(1.0, 3.0);
    // Less than a turn on either side.
    let mut factor = random.between(1.0, 5.0) / at.max(STOP - at).powi(2) * bars.omega.signum();
    let begun = |factor: f64| FourBar { angle: flat_pose(&bars) - factor * at * at, ..bars };
    // A start out of reach is no motion; next to the flat pose there is one.
    while !reaches(&begun(factor)) && factor.abs() > 1e-3 {
        factor *= 0.5;
    }
    let bars = begun(factor);
    let case = case("driven up to a change point", seed, bars, Drive::Touch(flat_pose(&bars), at, factor));
    Case { may_refuse: &["reverse in a singular configuration", "has left its branch"], ..case }
}

/// A driver with a corner, of a mechanism that is regular there. Where a pose comes at once after it that is not passed.
pub fn corner(seed: u64) -> Case {
    let mut random = Random(seed);
    let bars = with_defect(neutral(seed), defect(&mut random));
    let [rate, at] = [random.between(0.5, 2.0) * bars.omega.signum(), random.between(0.5, 3.5)];
    let case = case("driver with a corner", seed, bars, Drive::Corner(rate, at));
    Case { may_refuse: &["no step that crosses it"], ..case }
}

/// The crank's angle where all bars lie on a line.
fn flat_pose(bars: &FourBar) -> f64 {
    let outer = (bars.base + bars.crank - bars.coupler - bars.rocker).abs();
    let inner = ((bars.base - bars.crank).abs() - (bars.coupler - bars.rocker).abs()).abs();
    if outer < inner { PI } else { 0.0 }
}

/// By how much the coupler and the rocker reach further than they must in the flat pose.
fn spare(bars: &FourBar) -> f64 {
    match flat_pose(bars) {
        0.0 => (bars.base - bars.crank).abs() - (bars.coupler - bars.rocker).abs(),
        _ => bars.coupler + bars.rocker - bars.base - bars.crank,
    }
}

/// The same with so much to spare.
fn with_defect(bars: FourBar, defect: f64) -> FourBar {
    let base = match flat_pose(&bars) {
        0.0 if bars.base > bars.crank => bars.base + defect,
        _ => bars.base - defect,
    };
    FourBar { base, ..bars }
}

fn case(family: &'static str, seed: u64, bars: FourBar, drive: Drive) -> Case {
    let spare = spare(&bars);
    // What is left of a defect of nothing are rounding errors.
    let crosses = spare.abs() < 1e-14;
    let clear = |t: f64| {
        let turned = (drive.angle(bars.angle, t) - flat_pose(&bars)).rem_euclid(TAU);
        turned.min(TAU - turned) > CLEAR
    };
    let times: Vec<f64> = (1..40).map(|k| 0.1 * f64::from(k)).filter(|&t| clear(t)).chain([STOP]).collect();
    let out_of_reach = |&t: &f64| !reaches(&FourBar { angle: drive.angle(bars.angle, t), ..bars });
    let moments: Vec<f64> = (0..=4000).map(|part| STOP * f64::from(part) / 4000.0).collect();
    let passes = passages(&bars, drive, STOP) > 0;
    let locks = (spare < 0.0 && !crosses && passes) || moments.iter().any(out_of_reach);
    let values = |&t: &f64| {
        let angle = drive.angle(bars.angle, t);
        let up = bars.up != (crosses && passages(&bars, drive, t) % 2 == 1);
        let [coupler, rocker] = FourBar { angle, up, ..bars }.angles();
        vec![coupler, rocker]
    };
    let values = if locks { vec![vec![0.0; 2]; times.len()] } else { times.iter().map(values).collect() };
    let names = ["coupler.angle", "rocker.angle"].map(String::from).into();
    let [coupler, rocker] = bars.angles();
    let scene = scene(&format!("driven_{seed}"), &bars, drive).guess("coupler.angle", coupler);
    let scene = scene.guess("rocker.angle", rocker);
    let case = Case::new(family, scene, STOP, vec![]).driven();
    match locks {
        true => case.refused("the mechanism locks"),
        false => case.against(Reference { names, times, values }).within(0.0, 1e-8),
    }
}

/// Do coupler and rocker meet?
fn reaches(bars: &FourBar) -> bool {
    let (x, y) = (bars.crank * bars.angle.cos(), bars.crank * bars.angle.sin());
    let distance = (bars.base - x).hypot(y);
    (bars.coupler - bars.rocker).abs() < distance + ROUNDING && distance < bars.coupler + bars.rocker + ROUNDING
}

/// How often the crank has passed the flat pose. Where it turns back in the very pose it has not.
fn passages(bars: &FourBar, drive: Drive, t: f64) -> u32 {
    if let Drive::Touch(..) = drive {
        return 0;
    }
    const PARTS: u32 = 4000;
    let turns = |part: u32| {
        let angle = drive.angle(bars.angle, t * f64::from(part) / f64::from(PARTS));
        ((angle - flat_pose(bars)) / TAU).floor()
    };
    (1..=PARTS).filter(|&part| turns(part) != turns(part - 1)).count() as u32
}

fn scene(name: &str, bars: &FourBar, drive: Drive) -> Scene {
    Scene::new(name)
        .gravity([0.0, -bars.gravity])
        .ground_point("far", [bars.base, 0.0])
        .body("crank", bar(bars.masses[0], bars.crank))
        .body("coupler", bar(bars.masses[1], bars.coupler))
        .body("rocker", bar(bars.masses[2], bars.rocker))
        .revolute("crank_pivot", "ground", "crank.a")
        .revolute("crank_pin", "crank.b", "coupler.a")
        .revolute("rocker_pin", "coupler.b", "rocker.b")
        .revolute("rocker_pivot", "rocker.a", "ground.far")
        .driver("motor", Driver::angle("crank_pivot", drive.law(bars.angle).as_str()))
}
