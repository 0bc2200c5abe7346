//! Scenes with modes, of the families that tests have of them: contacts, stops, ropes, play, freewheels, dry friction, profiles, joints that engage, samples and events.

use cotree::scene::Scene;
use cotree_fmu::math::Random;

use crate::support::hard::random::Random as OfFrictions;
use crate::{
    backlash, coincidences, engaging, flights, freewheel, friction_levels, lifting_cams, one_sided_families, profiles,
    rolling_on_circles, ropes, several_frictions,
};

const CHAINS: u64 = 12;
const FRICTIONS: u64 = 8;
const LADDERS: u64 = 2;
const FLIGHTS: usize = 3;

/// Name, text, and where a run ends \[s\].
type Text = (String, String, f64);

/// The scenes that compile, each with the end of its run; random chains may be refused.
pub fn scenes() -> Vec<(Scene, f64)> {
    let texts = [free(), trains(), frictions(), outlines(), engaged()].concat();
    let read = |(name, text, stop): Text| {
        let mut scene = Scene::from_toml(&text).ok()?;
        scene.name.text = name;
        Some((scene, stop))
    };
    texts.into_iter().filter_map(read).collect()
}

/// Chains and loops with limits, contacts, ropes, play and freewheels; discs, pendulums between stops, a rope.
fn free() -> Vec<Text> {
    let chains = (0..CHAINS).map(|seed| (format!("chain {seed}"), one_sided_families::case(seed).scene, 1.0));
    let mut random = Random::new(1);
    let discs = [0.3, 0.8].map(|share| (format!("discs {share}"), flights::discs(3, share, &mut random).0, 2.0));
    let arms = [0.0, 0.5, 0.9];
    let arms = arms.map(|share| (format!("stops {share}"), flights::pendulum_between_stops(0.3, 0.7, share), 1.5));
    let rope = ("rope".to_owned(), flights::rope(0.4), 2.0);
    chains.chain(discs).chain(arms).chain([rope]).collect()
}

/// Gears, racks and screws with play, a valve that its cam throws off, a freewheel.
fn trains() -> Vec<Text> {
    let pairs = backlash::pairs(0.4);
    let pairs = [1, 3, 4].map(|pair| backlash::scene(&pairs[pair], [0.1, 0.0], [1.0, -0.5]));
    let pairs = pairs.into_iter().enumerate().map(|(index, text)| (format!("play {index}"), text, 2.0));
    let others = [
        ("train", flights::train(0.02, 0.4), 1.5),
        ("valve", flights::valve(260.0), 0.15),
        ("lifter", lifting_cams::lifter(20.0, 0.3), 0.6),
        ("freewheel", freewheel::disc("", "1[N.m]*sin(2[1/s]*t)", 1.0), 6.0),
    ];
    pairs.chain(others.map(named)).collect()
}

fn named((name, text, stop): (&str, String, f64)) -> Text {
    (name.to_owned(), text, stop)
}

/// Dry friction of joints and contacts: wheels, crank mechanisms, ladders, discs that roll or slide, a rope over a drum.
fn frictions() -> Vec<Text> {
    let all = (0..FRICTIONS).map(|seed| (format!("friction {seed}"), several_frictions::case(seed).1.scene, 2.0));
    let ladder = |seed| several_frictions::ladder(&mut OfFrictions(seed + 1)).scene;
    let ladders = (0..LADDERS).map(|seed| (format!("ladder {seed}"), ladder(seed), 1.5));
    let thrown = ropes::capstan([1.0, 2.0], ", mu = 0.3").replace("\"guide_2.v\" = 0", "\"guide_2.v\" = 3");
    let others = [
        ("hill", rolling_on_circles::disc("outside", 0.3, [1.3, -0.4]), 1.5),
        ("bowl", rolling_on_circles::disc("inside", 0.2, [-0.4, 0.5]), 1.5),
        ("capstan", thrown, 1.5),
        ("braked", friction_levels::wheel("1[N.m] + 4[N.m.s]*abs(wheel.omega)", "[initial]\n\"wheel.omega\" = 3"), 1.5),
    ];
    all.chain(ladders).chain(others.map(named)).collect()
}

/// Discs that fly at polygons, and one that falls onto a step.
fn outlines() -> Vec<Text> {
    let mut random = Random::new(5);
    let flights = std::iter::repeat_with(|| profiles::Flight::new(&mut random));
    let flights = flights.filter(|flight| flight.gap(0.0) > 1e-3).take(FLIGHTS);
    let flights: Vec<String> = flights.map(|flight| flight.scene()).collect();
    let floor = "profile = [[-1, 0], [0.5, 0], [0.5, -0.2], [3, -0.2]]\nradius = 0.1\nrestitution = 0.5";
    let steps = profiles::disc(floor, [0.0, 0.3], [1.0, 0.0], "");
    let flights = flights.into_iter().enumerate().map(|(index, text)| (format!("flight {index}"), text, 1.0));
    flights.chain([named(("steps", steps, 1.5))]).collect()
}

/// Joints that events engage and release, samples beside impacts.
fn engaged() -> Vec<Text> {
    let weld = "{ type = \"weld\", between = [\"a\", \"b\"], engaged = false }";
    let part = "[events.part]\nwhen = \"t > 1\"\nrelease = [\"coupling\"]\n";
    let outputs = |names: &str| format!("[outputs]\nvariables = [{names}]\n");
    let carts = format!("{}{part}{}", engaging::MEET, outputs("\"rail_a.s\", \"rail_b.v\""));
    let texts = [
        ("carts", engaging::carts(weld, &carts), 1.5),
        ("catch", engaging::catch(&outputs("\"pin.angle\", \"disc.x\", \"disc.omega\"")), 1.0),
        ("counted", coincidences::counted(0.1, 0.3, 0.8), 1.5),
    ];
    texts.map(named).into()
}
