//! `cotree motion`: distances between outlines and the ranges in which they overlap, against closed forms and 20 000 samples of these.

use std::f64::consts::{PI, TAU};

use crate::outside::command;
use crate::support::hard::random::Random;

use command::{code, cotree, stderr, stdout};
use cotree::scene::{Body, Outline, Scene};
use cotree_study::motion::{self, MotionRequest, PairClearance};
use serde_json::Value;

type Point = [f64; 2];
type Pose = [f64; 3];

/// What a scene reports, with its input and its range.
fn clearances(scene: &str, input: &str, range: Option<[f64; 2]>) -> Vec<PairClearance> {
    let scene = Scene::from_toml(scene).unwrap_or_else(|faults| panic!("{faults}"));
    let request = MotionRequest { input: Some(input.to_owned()), range, ..MotionRequest::default() };
    let figures = motion::study(&scene, &request).unwrap_or_else(|error| panic!("{error}"));
    figures.clearance.unwrap_or_default()
}

/// A point of a body in the frame of the ground.
fn placed([x, y, angle]: Pose, [u, v]: Point) -> Point {
    let (sine, cosine) = angle.sin_cos();
    [x + cosine * u - sine * v, y + sine * u + cosine * v]
}

/// The distance of two polygons that do not cross, from corners to sides.
fn apart(a: &[Point], b: &[Point]) -> f64 {
    let one = |from: &[Point], to: &[Point]| {
        let mut least = f64::INFINITY;
        for p in from {
            for side in 0..to.len() {
                let (q, r) = (to[side], to[(side + 1) % to.len()]);
                let along = [r[0] - q[0], r[1] - q[1]];
                let square = along[0] * along[0] + along[1] * along[1];
                let share = (((p[0] - q[0]) * along[0] + (p[1] - q[1]) * along[1]) / square).clamp(0.0, 1.0);
                least = least.min((q[0] + share * along[0] - p[0]).hypot(q[1] + share * along[1] - p[1]));
            }
        }
        least
    };
    one(a, b).min(one(b, a))
}

/// Do the sides of two polygons cross, or is one within the other?
fn meet(a: &[Point], b: &[Point]) -> bool {
    let turn = |p: Point, q: Point, r: Point| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let sides = |of: &[Point]| (0..of.len()).map(|k| [of[k], of[(k + 1) % of.len()]]).collect::<Vec<_>>();
    let crosses = |[p, q]: [Point; 2], [r, s]: [Point; 2]| {
        turn(p, q, r) * turn(p, q, s) < 0.0 && turn(r, s, p) * turn(r, s, q) < 0.0
    };
    let within = |point: Point, of: &[Point]| {
        let angle = |[p, q]: [Point; 2]| {
            let (p, q) = ([p[0] - point[0], p[1] - point[1]], [q[0] - point[0], q[1] - point[1]]);
            (p[0] * q[1] - p[1] * q[0]).atan2(p[0] * q[0] + p[1] * q[1])
        };
        sides(of).into_iter().map(angle).sum::<f64>().abs() > PI
    };
    sides(a).iter().any(|one| sides(b).iter().any(|other| crosses(*one, *other))) || within(a[0], b) || within(b[0], a)
}

const FOUR_BAR: &str = r#"
name = "clearance_four_bar"
[ground]
points = { d = [1, 0] }
outline = { polygon = [[0.1, 0.75], [0.4, 0.75], [0.4, 0.95], [0.1, 0.95]] }
[bodies]
crank = { points = { o = [0, 0], a = [0.3, 0] } }
coupler = { points = { a = [0, 0], b = [1, 0] }, outline = { polygon = [[0, -0.02], [1, -0.02], [0.5, 0.25]] } }
rocker = { points = { d = [0, 0], b = [0.7, 0] } }
[joints]
p1 = { type = "revolute", between = ["ground", "crank.o"] }
p2 = { type = "revolute", between = ["crank.a", "coupler.a"] }
p3 = { type = "revolute", between = ["coupler.b", "rocker.b"] }
p4 = { type = "revolute", between = ["ground.d", "rocker.d"] }
[initial]
"p1.angle" = "60 deg"
"coupler.angle" = { guess = "20 deg" }
"rocker.angle" = { guess = "80 deg" }
"#;

/// The same with a motor, so that it runs without masses.
fn driven_four_bar() -> String {
    let driven = FOUR_BAR.replace("\"p1.angle\" = \"60 deg\"\n", "");
    format!("{driven}[drivers]\nturn = {{ joint = \"p1\", angle = \"1 + t\" }}\n")
}

const PAIR: &str = "[clearance]\npairs = [[\"coupler\", \"ground\"]]\n";

/// The distance of the coupler and the block, from the circles about the pins.
fn of_four_bar(angle: f64) -> f64 {
    let a = [0.3 * angle.cos(), 0.3 * angle.sin()];
    let (dx, dy) = (1.0 - a[0], -a[1]);
    let d = dx.hypot(dy);
    let coupler = dy.atan2(dx) + ((d * d + 1.0 - 0.49) / (2.0 * d)).acos();
    let corners = [[0.0, -0.02], [1.0, -0.02], [0.5, 0.25]].map(|corner| placed([a[0], a[1], coupler], corner));
    let block = [[0.1, 0.75], [0.4, 0.75], [0.4, 0.95], [0.1, 0.95]];
    if meet(&corners, &block) { 0.0 } else { apart(&corners, &block) }
}

#[test]
fn a_coupler_passes_a_block() {
    let found = clearances(&format!("{FOUR_BAR}{PAIR}"), "p1", None);
    let [PairClearance { pair, least, at, points, overlaps }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(pair, &["coupler", "ground"].map(str::to_owned));
    assert!((least - 0.022361453978).abs() < 1e-9 && overlaps.is_empty(), "{least}");
    assert!((of_four_bar(at.input) - least).abs() < 1e-12, "{at:?}");
    let near = |by: f64| of_four_bar(at.input + by);
    assert!(near(1e-5) > *least && near(-1e-5) > *least);
    assert!(((points[0][0] - points[1][0]).hypot(points[0][1] - points[1][1]) - least).abs() < 1e-14);
    assert_eq!(at.time, Some(at.input));
    // Backwards the same, in another time; and a range that ends before.
    let back = &clearances(&format!("{FOUR_BAR}{PAIR}"), "p1", Some([2.0, 1.0]))[0];
    assert!((back.least - least).abs() < 1e-12 && (back.at.time.unwrap() - (2.0 - at.input)).abs() < 1e-7);
    let short = &clearances(&format!("{FOUR_BAR}{PAIR}"), "p1", Some([0.5, 1.25]))[0];
    assert!((short.at.input - 1.25).abs() < 1e-12 && (short.least - of_four_bar(1.25)).abs() < 1e-9);
}

/// A slider-crank with outlines of its bodies and of the ground, all polygons that are widened.
struct SliderCrank {
    crank: f64,
    rod: f64,
    offset: f64,
    /// Of the ground, the crank, the rod and the slider.
    outlines: [(Vec<Point>, f64); 4],
}

const NAMES: [&str; 4] = ["ground", "crank", "rod", "slider"];

impl SliderCrank {
    fn random(random: &mut Random) -> SliderCrank {
        let crank = random.between(0.05, 0.15);
        let offset = random.between(-0.05, 0.05);
        let rod = crank + offset.abs() + random.between(0.05, 0.3);
        let outline = |random: &mut Random| {
            let centre = [random.between(-0.2, 0.2), random.between(-0.2, 0.2)];
            let count = 3 + random.between(0.0, 5.0) as usize;
            let corner = |k: usize, radius: f64| {
                let angle = TAU * k as f64 / count as f64;
                [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
            };
            let corners = (0..count).map(|k| corner(k, random.between(0.01, 0.06))).collect();
            let round = if random.between(0.0, 1.0) < 0.5 { 0.0 } else { random.between(0.0, 0.02) };
            (corners, round)
        };
        let outlines = [outline(random), outline(random), outline(random), outline(random)];
        SliderCrank { crank, rod, offset, outlines }
    }

    fn scene(&self) -> String {
        let outline = |index: usize| {
            let (corners, round) = &self.outlines[index];
            format!("{{ polygon = {corners:?}, round = {round:?} }}")
        };
        let SliderCrank { crank, rod, offset, .. } = self;
        let pairs: Vec<String> =
            (0..4).flat_map(|a| (0..a).map(move |b| format!("[\"{}\", \"{}\"]", NAMES[a], NAMES[b]))).collect();
        format!(
            r#"
name = "slider_crank"
ground = {{ points = {{ rail = [0, {offset}] }}, outline = {} }}
[bodies]
crank = {{ com = [0.01, 0.02], points = {{ o = [0, 0], a = [{crank}, 0] }}, outline = {} }}
rod = {{ points = {{ a = [0, 0], b = [{rod}, 0] }}, outline = {} }}
slider = {{ points = {{ b = [0, 0] }}, outline = {} }}
[joints]
pin = {{ type = "revolute", between = ["ground", "crank.o"] }}
big = {{ type = "revolute", between = ["crank.a", "rod.a"] }}
small = {{ type = "revolute", between = ["rod.b", "slider.b"] }}
rail = {{ type = "prismatic", between = ["ground.rail", "slider.b"], axis = [1, 0] }}
[clearance]
pairs = [{}]
[initial]
"crank.angle" = 0.3
"rod.angle" = {{ guess = 0 }}
"slider.x" = {{ guess = {} }}
"#,
            outline(0),
            outline(1),
            outline(2),
            outline(3),
            pairs.join(", "),
            crank + rod
        )
    }

    fn poses(&self, angle: f64) -> [Pose; 4] {
        let a = [self.crank * angle.cos(), self.crank * angle.sin()];
        let rod = ((self.offset - a[1]) / self.rod).asin();
        [[0.0; 3], [0.0, 0.0, angle], [a[0], a[1], rod], [a[0] + self.rod * rod.cos(), self.offset, 0.0]]
    }

    /// The distance of two of them; none if they overlap.
    fn distance(&self, pair: [usize; 2], angle: f64) -> Option<f64> {
        let poses = self.poses(angle);
        let corners = pair
            .map(|index| self.outlines[index].0.iter().map(|corner| placed(poses[index], *corner)).collect::<Vec<_>>());
        let [a, b] = &corners;
        let reach = self.outlines[pair[0]].1 + self.outlines[pair[1]].1;
        let gap = if meet(a, b) { -reach } else { apart(a, b) - reach };
        (gap > 0.0).then_some(gap)
    }
}

/// Of 204 random pairs the distance is never above 20 000 samples, is that of the closed form there, and is not below what samples so near to each other
/// leave room for; overlaps are where samples overlap.
#[test]
fn random_outlines_are_never_closer_in_any_sample() {
    const SAMPLES: usize = 20_000;
    let mut random = Random(29);
    let (mut free, mut overlapping) = (0, 0);
    for case in 0..34 {
        let mechanism = SliderCrank::random(&mut random);
        let found = clearances(&mechanism.scene(), "pin", None);
        assert_eq!(found.len(), 6);
        for PairClearance { pair, least, at, points, overlaps } in &found {
            let pair = pair.each_ref().map(|name| NAMES.iter().position(|known| known == name).unwrap());
            let step = TAU / SAMPLES as f64;
            let samples: Vec<Option<f64>> = (0..SAMPLES).map(|k| mechanism.distance(pair, step * k as f64)).collect();
            let what = format!("case {case}, {pair:?}: {least} at {}, {overlaps:?}", at.input);
            if overlaps.is_empty() {
                free += 1;
                let sampled = samples.iter().map(|gap| gap.unwrap_or_else(|| panic!("{what}: a sample overlaps")));
                let sampled = sampled.fold(f64::INFINITY, f64::min);
                assert!(*least <= sampled + 1e-9 && *least > sampled - step, "{what}, {sampled} in samples");
                let there = mechanism.distance(pair, at.input).unwrap();
                let between = (points[0][0] - points[1][0]).hypot(points[0][1] - points[1][1]);
                assert!((there - least).abs() < 1e-9 && (between - least).abs() < 1e-12, "{what}, {there}, {between}");
                continue;
            }
            overlapping += 1;
            let within = |angle: f64, margin: f64| {
                overlaps.iter().any(|[from, to]| {
                    [angle, angle + TAU].into_iter().any(|angle| angle > from - margin && angle < to + margin)
                })
            };
            for (k, gap) in samples.iter().enumerate() {
                let angle = step * k as f64;
                let is_right = if gap.is_none() { within(angle, 1e-9) } else { !within(angle, -1e-9) };
                assert!(is_right, "{what}: {gap:?} at {angle}");
            }
            // On both sides of each end there is something else.
            let is_whole = overlaps.iter().any(|[from, to]| to - from > TAU - 1e-9);
            for end in overlaps.iter().flatten().filter(|_| !is_whole) {
                let [before, behind] = [-1e-8, 1e-8].map(|by| mechanism.distance(pair, end + by).is_some());
                assert!(before != behind, "{what}: {end} is not an end");
            }
        }
    }
    assert!(free > 50 && overlapping > 50, "{free} {overlapping}");
}

#[test]
fn overlaps_end_where_circles_and_lines_meet() {
    // The tip of a thin crank above a line; a disc on the crank that meets one on the ground.
    let scene = |crank: &str, ground: &str| {
        format!(
            "name = \"a\"\nground.outline = {ground}\n[bodies]\ncrank = {{ points = {{ a = [0, 0], b = [0.5, 0] }}, outline = {crank} }}\n[joints]\n\
             pin = {{ type = \"revolute\", between = [\"ground\", \"crank.a\"] }}\n[clearance]\npairs = [[\"ground\", \"crank\"]]\n"
        )
    };
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-10, "{found}, not {wanted}");
    let block = "{ polygon = [[-1, 0.3], [1, 0.3], [1, 0.6], [-1, 0.6]] }";
    let found = &clearances(&scene("{ rod = [\"a\", \"b\"] }", block), "pin", None)[0];
    let begin = (0.3f64 / 0.5).asin();
    let [[from, to]] = found.overlaps[..] else { panic!("{found:?}") };
    near(from, begin);
    near(to, PI - begin);
    near(found.at.input, begin);
    assert_eq!(found.least, 0.0);
    // The same bar of 40 mm reaches its width's half farther.
    let found = &clearances(&scene("{ rod = [\"a\", \"b\"], width = \"40 mm\" }", block), "pin", None)[0];
    near(found.overlaps[0][0], (0.28f64 / 0.5).asin());
    // Through the angle 0: from below it to above it, beyond the end of the turn.
    let disc = "{ disc = \"b\", radius = \"0.1 m\" }";
    let found = &clearances(&scene(disc, "{ disc = [0.7, 0], radius = 0.2 }"), "pin", None)[0];
    let half = ((0.25f64 + 0.49 - 0.09) / (2.0 * 0.5 * 0.7)).acos();
    let [[from, to]] = found.overlaps[..] else { panic!("{found:?}") };
    near(from, TAU - half);
    near(to, TAU + half);
    // A little farther away they only come near, at 0.
    let found = &clearances(&scene(disc, "{ disc = [0.9, 0], radius = 0.2 }"), "pin", None)[0];
    near(found.least, 0.1);
    assert!(found.overlaps.is_empty() && found.at.input.sin().abs() < 1e-6);
    // Always, and never nearer.
    let found = &clearances(&scene("{ disc = \"b\", radius = 0.1 }", "{ disc = [0, 0], radius = 1 }"), "pin", None)[0];
    let [[from, to]] = found.overlaps[..] else { panic!("{found:?}") };
    near(to - from, TAU);
    let found =
        &clearances(&scene("{ disc = \"b\", radius = 0.1 }", "{ disc = [0, 0], radius = 0.2 }"), "pin", None)[0];
    near(found.least, 0.2);
}

/// An overlap of a tenth of a degree between two samples, which none of them sees.
#[test]
fn an_overlap_between_samples_is_found() {
    let depth = 0.5 - 0.5 * 0.05f64.to_radians().cos();
    let scene = format!(
        "name = \"a\"\nground.outline = {{ rod = [[{x}, -1], [{x}, 1]] }}\n[bodies]\ncrank = {{ points = {{ a = [0, 0], b = [0.5, 0] }}, outline = {{ rod = [\"a\", \"b\"] }} }}\n\
         [joints]\npin = {{ type = \"revolute\", between = [\"ground\", \"crank.a\"] }}\n[clearance]\npairs = [[\"ground\", \"crank\"]]\n",
        x = 0.5 - depth
    );
    let found = &clearances(&scene, "pin", Some([-0.25f64.to_radians(), TAU - 0.25f64.to_radians()]))[0];
    let overlaps: f64 = found.overlaps.iter().map(|[from, to]| to - from).sum();
    // What is within 1e-12 of the size touches, and the tip moves nearly along the line.
    assert!((overlaps - 0.1f64.to_radians()).abs() < 2e-8, "{found:?}");
}

/// Driven by its slider, a slider-crank has dead points at both ends, where the crank's angle has no derivative.
#[test]
fn the_distance_next_to_a_dead_point_is_that_of_the_closed_form() {
    let scene = r#"
name = "a"
ground.outline = { disc = [0.06, 0.05], radius = 0.01 }
[bodies]
crank = { points = { o = [0, 0], a = [0.1, 0] }, outline = { rod = ["o", "a"], width = 0.004 } }
rod = { points = { a = [0, 0], b = [0.3, 0] } }
slider = { points = { b = [0, 0] } }
[joints]
pin = { type = "revolute", between = ["ground", "crank.o"] }
big = { type = "revolute", between = ["crank.a", "rod.a"] }
small = { type = "revolute", between = ["rod.b", "slider.b"] }
rail = { type = "prismatic", between = ["ground", "slider.b"], axis = [1, 0] }
[clearance]
pairs = [["crank", "ground"]]
[initial]
"crank.angle" = 0.5
"rod.angle" = { guess = -0.1 }
"slider.x" = { guess = 0.38 }
"#;
    // With the slider nearly at the end the crank is nearly at zero; it is nearest to the disc at the other end of the range.
    for range in [[0.3975, 0.3999], [0.39, 0.39999], [0.398, 0.399999]] {
        let found = &clearances(scene, "rail", Some(range))[0];
        let crank = ((range[0] * range[0] + 0.01 - 0.09f64) / (2.0 * range[0] * 0.1)).acos();
        let wanted = apart(&[[0.06, 0.05]], &[[0.0, 0.0], [0.1 * crank.cos(), 0.1 * crank.sin()]]) - 0.012;
        assert!((found.least - wanted).abs() < 1e-9, "{found:?}, not {wanted}");
        let at_end = ((range[1] * range[1] + 0.01 - 0.09f64) / (2.0 * range[1] * 0.1)).acos();
        let inside = &clearances(&scene.replace("[0.06, 0.05]", "[0.06, -0.05]"), "rail", Some(range))[0];
        let wanted = apart(&[[0.06, -0.05]], &[[0.0, 0.0], [0.1 * at_end.cos(), 0.1 * at_end.sin()]]) - 0.012;
        assert!((inside.least - wanted).abs() < 1e-9, "{inside:?}, not {wanted}");
    }
}

#[test]
fn pairs_are_those_that_share_no_joint() {
    let pairs = |scene: &str| -> Vec<[String; 2]> {
        clearances(scene, "p1", None).into_iter().map(|found| found.pair).collect()
    };
    let rods = FOUR_BAR.replace("a = [0.3, 0] }", "a = [0.3, 0] }, shape = { rod = [\"o\", \"a\"] }");
    let rods = rods.replace("b = [0.7, 0] }", "b = [0.7, 0] }, outline = { rod = [\"d\", \"b\"], width = \"10 mm\" }");
    let named = |pairs: &[[&str; 2]]| pairs.iter().map(|pair| pair.map(str::to_owned)).collect::<Vec<_>>();
    assert_eq!(pairs(&rods), named(&[["crank", "rocker"], ["coupler", "ground"]]));
    assert_eq!(pairs(&format!("{rods}[clearance]\n")), named(&[["crank", "rocker"], ["coupler", "ground"]]));
    assert_eq!(pairs(&format!("{rods}[clearance]\npairs = []\n")), named(&[]));
    // Shapes alone are no question.
    let shapes = "shape = { rod = [\"o\", \"a\"] }";
    let only = FOUR_BAR.lines().filter(|line| !line.starts_with("outline")).collect::<Vec<_>>().join("\n");
    let only = only.replace(", outline = { polygon = [[0, -0.02], [1, -0.02], [0.5, 0.25]] }", "");
    assert_eq!(pairs(&only.replace("a = [0.3, 0] }", &format!("a = [0.3, 0] }}, {shapes}"))), named(&[]));
}

fn ran(scene: &str, more: &[&str]) -> std::process::Output {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    cotree(folder.path(), &[&["motion", "a.toml", "--input", "p1"], more].concat())
}

#[test]
fn the_command_reports_it_and_ends_with_1_below_the_limit() {
    let output = ran(&format!("{FOUR_BAR}{PAIR}least = \"22 mm\"\n"), &[]);
    assert!(
        code(&output) == 0 && stdout(&output).contains("least distance 22.3615 mm at 86.758"),
        "{}",
        stdout(&output)
    );
    let output = ran(&format!("{FOUR_BAR}{PAIR}least = \"23 mm\"\n"), &["--json"]);
    assert_eq!(code(&output), 1);
    let said = stderr(&output);
    assert!(said.contains("`coupler` and `ground` falls to 22.36") && said.contains("is 23 mm"), "{said}");
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let clearance = &figures["clearance"][0];
    assert_eq!(clearance["pair"], serde_json::json!(["coupler", "ground"]));
    assert!((clearance["at"]["input"].as_f64().unwrap() - 1.514212).abs() < 1e-6);
    let column =
        figures["table"].as_array().unwrap().iter().find(|column| column["name"] == "clearance coupler ground");
    let values = column.unwrap()["values"].as_array().unwrap();
    assert!(values.len() == 720 && (values[90].as_f64().unwrap() - of_four_bar(PI / 4.0)).abs() < 1e-9);
    let output = ran(&format!("{FOUR_BAR}{PAIR}least = \"1 mm\"\n").replace("0.75]", "0.7]"), &[]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("overlap") && stdout(&output).contains("overlap from"), "{}", stdout(&output));
    // Static forces: no time.
    let output = ran(&format!("{FOUR_BAR}{PAIR}"), &["--speed", "0", "--json"]);
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert!(figures["clearance"][0]["at"]["time"].is_null());
}

#[test]
fn parameters_change_outlines_and_an_outline_that_is_none_is_refused() {
    let scene = format!("{FOUR_BAR}{PAIR}[parameters]\ngrow = \"5 mm\"\n")
        .replace("[0.5, 0.25]] }", "[0.5, 0.25]], round = \"grow\" }");
    let least = |more: &[&str]| {
        let figures: Value = serde_json::from_str(&stdout(&ran(&scene, &[&["--json"], more].concat()))).unwrap();
        figures["clearance"][0]["least"].as_f64().unwrap()
    };
    assert!(
        (least(&[]) - 0.017361453978).abs() < 1e-9 && (least(&["--set", "grow=0.01"]) - 0.012361453978).abs() < 1e-9
    );
    let output = ran(&scene, &["--set", "grow=-0.01"]);
    assert!(
        code(&output) == 2 && stderr(&output).contains("the outline of `coupler` has a negative"),
        "{}",
        stderr(&output)
    );
}

/// A program is the same bytes with outlines and without, whatever parameters these have.
#[test]
fn outlines_are_no_part_of_the_program() {
    let bare = |text: &str| {
        text.replace(", outline = { polygon = [[0, -0.02], [1, -0.02], [0.5, 0.25]], round = \"grow\" }", "")
            .lines()
            .filter(|line| !line.starts_with("outline") && !line.contains("pairs") && *line != "[clearance]")
            .collect::<Vec<_>>()
            .join("\n")
    };
    let text = format!("{}{PAIR}[parameters]\ngrow = \"5 mm\"\n", driven_four_bar())
        .replace("[0.5, 0.25]] }", "[0.5, 0.25]], round = \"grow\" }");
    let program = |text: &str| {
        let scene = Scene::from_toml(text).unwrap_or_else(|faults| panic!("{faults}"));
        cotree::compile::compile(&scene).unwrap_or_else(|faults| panic!("{faults}")).program
    };
    assert_ne!(bare(&text), text);
    assert_eq!(program(&bare(&text)), program(&text));
}

#[test]
fn a_scene_of_rust_has_the_same() {
    let scene = Scene::from_toml(FOUR_BAR).unwrap();
    let coupler = Body::new().point("a", [0.0, 0.0]).point("b", [1.0, 0.0]).outline(Outline::polygon([
        [0.0, -0.02],
        [1.0, -0.02],
        [0.5, 0.25],
    ]));
    let block = Outline::polygon([[0.1, 0.75], [0.4, 0.75], [0.4, 0.95], [0.1, 0.95]]);
    let built = Scene::new("clearance_four_bar")
        .ground_point("d", [1.0, 0.0])
        .ground_outline(block)
        .body("crank", Body::new().point("o", [0.0, 0.0]).point("a", [0.3, 0.0]))
        .body("coupler", coupler)
        .body("rocker", Body::new().point("d", [0.0, 0.0]).point("b", [0.7, 0.0]))
        .revolute("p1", "ground", "crank.o")
        .revolute("p2", "crank.a", "coupler.a")
        .revolute("p3", "coupler.b", "rocker.b")
        .revolute("p4", "ground.d", "rocker.d")
        .clearance("coupler", "ground")
        .least_clearance("1 mm")
        .initial("p1.angle", "60 deg")
        .guess("coupler.angle", "20 deg")
        .guess("rocker.angle", "80 deg");
    let request = MotionRequest { input: Some("p1".to_owned()), ..MotionRequest::default() };
    let figures = |scene: &Scene| motion::study(scene, &request).unwrap_or_else(|error| panic!("{error}"));
    let (built, read) = (figures(&built), figures(&scene));
    assert_eq!(built.least_clearance, Some(1e-3));
    assert_eq!(built.clearance.unwrap()[0].least, read.clearance.unwrap()[0].least);
}

/// The outline of a part's ground stands where the part is; one of a part on a body is refused.
#[test]
fn the_ground_of_a_part_has_its_outline() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "post.toml",
        "name = \"post\"\n[ground]\npoints = { top = [0.2, 0.1] }\noutline = { rod = [\"top\", [0.2, 0]], width = \"20 mm\" }\n[bodies.arm]\npoints = { a = [0, 0] }\n\
         [joints.pin]\ntype = \"revolute\"\nbetween = [\"ground.top\", \"arm.a\"]\n[drivers.still]\njoint = \"pin\"\nangle = 0\n",
    );
    let scene = |keys: &str| {
        format!(
            "name = \"a\"\n[parts.post]\nfile = \"post.toml\"\n{keys}\n[bodies.crank]\npoints = {{ o = [0, 0], tip = [0.5, 0] }}\noutline = {{ disc = \"tip\", radius = \"30 mm\" }}\n\
             [joints.shaft]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank.o\"]\n[clearance]\npairs = [[\"crank\", \"ground\"]]\n"
        )
    };
    // The rod stands from (-0.9, 0.1) to (-0.9, 0), seen mirrored and moved.
    write("a.toml", &scene("at = [-0.7, 0]\nmirror = true"));
    let output = cotree(folder.path(), &["motion", "a.toml", "--input", "shaft", "--json"]);
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)));
    let least = figures["clearance"][0]["least"].as_f64().unwrap();
    assert!((least - (0.9 - 0.5 - 0.03 - 0.01)).abs() < 1e-9, "{least}");
    write("a.toml", &scene("on = \"crank\""));
    let output = cotree(folder.path(), &["check", "a.toml"]);
    assert!(code(&output) == 1 && stderr(&output).contains("its ground has an outline"), "{}", stderr(&output));
}

#[test]
fn outlines_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let rounded = driven_four_bar().replace("[0.5, 0.25]] }", "[0.5, 0.25]], round = \"20 mm\" }");
    std::fs::write(folder.path().join("a.toml"), rounded).unwrap();
    for name in ["a.svg", "a.dxf"] {
        let output = cotree(folder.path(), &["show", "a.toml", "--drawing", name]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("a.svg").contains("fill=\"#dfe3e8\" stroke=\"#2b333d\" stroke-width=\"1.3\""));
    let dxf = read("a.dxf");
    // The block's corners [mm], and the rounded coupler's many.
    assert!(dxf.contains(" 10\r\n400.0\r\n 20\r\n950.0\r\n"), "{dxf}");
    assert!(dxf.matches("VERTEX").count() > 50);
    let output = cotree(folder.path(), &["view", "a.toml", "-o", "a.html"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}
