//! A drawing in motion: an SVG that moves by itself, and its single pictures.

use super::coupling::tangents;
use super::held::{HeldPart, Legend, ring_with_name, star_with_name};
use super::shapes::{along, difference, dot, norm, normal, unit};
use super::view::View;
use super::{Drawing, FilmRange, is_finite, symbols};
use crate::alike::Alike;
use crate::carrier::{Anchor, Band, CarriedLine, Carrier, Stretch, Way, joined};
use crate::svg::{PictureFrame, Pixel, Svg, number, polyline};

/// Space around the whole motion [pins].
const ROOM: f64 = 5.0;
/// More of it if there are names of what is closed or sticks [pins].
const NAMES: f64 = 2.0;
const PATH: &str = "#0b7f73";

/// What a film that moves by itself leaves out between two samples is nowhere larger [px].
const NEAR: f64 = 0.5;
/// It leaves out at most so many samples, so that even slow motion is smooth.
const SPARSE: usize = 16;

/// A drawing at its start, and where everything is from then on.
#[derive(Clone, Debug)]
pub struct Film {
    drawing: Drawing,
    /// Of each sample the position and angle of each body.
    poses: Vec<Vec<[f64; 3]>>,
    /// Paths of points, one place for each sample.
    curves: Vec<Vec<[f64; 2]>>,
    /// What is closed or sticks, one for each of the drawing's.
    shows: Vec<Shows>,
    /// How long it takes [s].
    duration: f64,
    /// Samples from one picture to the next.
    step: usize,
}

/// What a film shows of something that has modes, at each sample: whether it holds, and whether it has struck since the sample before.
#[derive(Clone, Debug, Default)]
pub struct Shows {
    pub holds: Vec<bool>,
    pub strikes: Vec<bool>,
}

/// How long a star is seen after something has struck [s].
const FLASH: f64 = 0.15;

/// How a part of the picture moves.
enum Moves {
    Still,
    /// Place [px] and angle [deg] at each sample.
    Rigid(Vec<[f64; 3]>),
    Bending(Vec<Bent>),
    /// Names and symbolic arrows: true at the start only.
    Left,
}

/// A line that changes its shape: its styles from back to front, and its path data at each sample.
struct Bent {
    styles: Vec<String>,
    data: Vec<String>,
}

impl Film {
    /// A film of at least one sample, with a picture after so many of them; `poses` and `curves` have equally many samples.
    pub fn new(
        mut drawing: Drawing,
        poses: Vec<Vec<[f64; 3]>>,
        curves: Vec<Vec<[f64; 2]>>,
        duration: f64,
        step: usize,
    ) -> Self {
        drawing.range = FilmRange::default();
        let mut film = Film { drawing, poses, curves, shows: Vec::new(), duration, step: step.max(1) };
        let travel = |way: Option<Way>| way.map_or([0.0; 2], |way| film.travel(&way));
        let joints = film.drawing.joints.iter().map(|joint| travel(joint.way())).collect();
        let couplings = film.drawing.couplings.iter().map(|coupling| travel(coupling.way())).collect();
        let range = FilmRange { corners: film.corners(), joints, couplings };
        film.drawing.range = range;
        film
    }

    /// With what is closed or sticks, of each of the drawing's; equally many samples.
    #[must_use]
    pub fn showing(self, shows: Vec<Shows>) -> Self {
        Film { shows, ..self }
    }

    /// How many pictures there are.
    pub fn len(&self) -> usize {
        self.samples().count()
    }

    fn samples(&self) -> impl Iterator<Item = usize> + Clone {
        (0..self.poses.len()).step_by(self.step)
    }

    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The whole motion in one picture that moves, again and again. It has as many samples as it needs.
    pub fn svg(&self) -> String {
        let view = View::fit(&self.drawing);
        let mut step = SPARSE;
        while step > 1 && !self.is_smooth(step, &view) {
            step /= 2;
        }
        Film { step, ..self.clone() }.picture(None, &view)
    }

    /// One picture, and how many there are is [`Film::len`].
    pub fn frame(&self, index: usize) -> String {
        self.picture(Some(index.min(self.len().saturating_sub(1))), &View::fit(&self.drawing))
    }

    /// Is every sample between others that are so many apart where straight lines between them lead?
    fn is_smooth(&self, step: usize, view: &View) -> bool {
        let sizes: Vec<f64> =
            self.drawing.bodies.iter().map(|body| view.length(super::shapes::extent(&body.extent()))).collect();
        // With a single sample nothing moves.
        step < self.poses.len()
            && (0..self.poses.len().saturating_sub(step)).step_by(step).all(|first| {
                (1..step).all(|between| {
                    let share = between as f64 / step as f64;
                    let [a, now, b] = [first, first + between, first + step].map(|sample| &self.poses[sample]);
                    (0..sizes.len().min(now.len())).all(|body| {
                        let off = |axis: usize| (1.0 - share) * a[body][axis] + share * b[body][axis] - now[body][axis];
                        view.length(off(0).length_with(off(1))) + sizes[body] * off(2).abs() < NEAR
                    })
                })
            })
    }

    fn picture(&self, sample: Option<usize>, view: &View) -> String {
        let drawn = self.drawing.elements(view);
        let mut svg = Svg::default();
        let parts = joined(drawn.parts(), Carrier::rigid);
        for (carrier, elements) in parts.iter().filter(|(_, elements)| !elements.is_empty()) {
            match self.motion(carrier, view) {
                Moves::Still => svg.raw(elements.trim_end()),
                Moves::Rigid(places) => self.rigid(&mut svg, elements, &places, sample),
                Moves::Bending(lines) => self.bending(&mut svg, &lines, sample),
                Moves::Left => {}
            }
        }
        for curve in &self.curves {
            self.curve(&mut svg, curve, view, sample);
        }
        let legend = self.marks(&mut svg, view, sample);
        let corners: Vec<Pixel> =
            self.drawing.range.corners.iter().filter(|at| is_finite(at)).map(|&at| view.pixel(at)).collect();
        let frames: Vec<PictureFrame> = corners.iter().map(|&at| PictureFrame::centred(at, 0.0, 0.0)).collect();
        let mut frame = PictureFrame::around(frames.iter()).widened(ROOM * view.pin);
        if !legend.is_empty() {
            frame = legend.draw(&mut svg, view, frame.widened(NAMES * view.pin));
        }
        svg.finish(frame, &self.drawing.title)
    }

    /// Rings around what is closed or sticks, stars where something has just struck; returns what is to be explained.
    fn marks(&self, svg: &mut Svg, view: &View, sample: Option<usize>) -> Legend {
        let mut legend = Legend::default();
        for (held, shows) in self.drawing.held.iter().zip(&self.shows) {
            let places = match self.places(view, |sample| (self.spot(held, sample), 0.0)) {
                Moves::Rigid(places) => places,
                Moves::Still => {
                    vec![[view.pixel(held.spot.place())[0], view.pixel(held.spot.place())[1], 0.0]; self.len()]
                }
                Moves::Bending(_) | Moves::Left => continue,
            };
            let at = [places[0][0], places[0][1]];
            let lasts = (FLASH / self.duration * (self.poses.len() - 1) as f64).ceil() as usize;
            let struck = |k: usize| (k.saturating_sub(lasts)..=k).any(|k| shows.strikes.get(k) == Some(&true));
            let mut star = Svg::default();
            star_with_name(&mut star, view, at, &held.name);
            legend.strikes |= self.shown(svg, star.elements(), &places, &|k| struck(k), sample);
            let mut ring = Svg::default();
            ring_with_name(&mut ring, view, at, held);
            let holds = self.shown(svg, ring.elements(), &places, &|k| shows.holds.get(k) == Some(&true), sample);
            legend.sticks |= holds && held.sticks;
            legend.closed |= holds && !held.sticks;
        }
        legend
    }

    /// What is seen at some samples only; true if it is seen at any.
    fn shown(
        &self,
        svg: &mut Svg,
        elements: &str,
        places: &[[f64; 3]],
        is_seen: &dyn Fn(usize) -> bool,
        sample: Option<usize>,
    ) -> bool {
        let seen: Vec<bool> = self.samples().map(is_seen).collect();
        if !seen.contains(&true) {
            return false;
        }
        match sample {
            Some(sample) if seen[sample] => self.rigid(svg, elements, places, Some(sample)),
            Some(_) => {}
            None => {
                let hidden = if seen[0] { "visible" } else { "hidden" };
                svg.raw(&format!("<g visibility=\"{hidden}\">{}", self.blinks(&seen)));
                self.rigid(svg, elements, places, None);
                svg.raw("</g>");
            }
        }
        true
    }

    /// The element that shows and hides; nothing if it does neither.
    fn blinks(&self, seen: &[bool]) -> String {
        let changes: Vec<usize> = (0..seen.len()).filter(|&k| k == 0 || seen[k] != seen[k - 1]).collect();
        if changes.len() < 2 {
            return String::new();
        }
        let last = (seen.len() - 1) as f64;
        let times: Vec<String> = changes.iter().map(|&k| format!("{:.5}", k as f64 / last)).collect();
        let values: Vec<&str> = changes.iter().map(|&k| if seen[k] { "visible" } else { "hidden" }).collect();
        format!(
            "<animate attributeName=\"visibility\" calcMode=\"discrete\" dur=\"{}s\" repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{}\"/>",
            number(self.duration),
            times.join(";"),
            values.join(";")
        )
    }

    /// Where something that has modes is at a sample.
    fn spot(&self, held: &HeldPart, sample: usize) -> [f64; 2] {
        let [x, y] = self.at(held.spot.on, held.spot.at, sample);
        let Some((body, off)) = held.spot.off else { return [x, y] };
        let angle = |sample: usize| body.and_then(|body| self.poses.get(sample)?.get(body)).map_or(0.0, |pose| pose[2]);
        let [u, v] = rotated(off, angle(sample) - angle(0));
        [x + u, y + v]
    }

    fn motion(&self, carrier: &Carrier, view: &View) -> Moves {
        match (carrier.rigid(), carrier) {
            (Some(None), _) => Moves::Still,
            (Some(Some(body)), _) => self.places(view, |sample| {
                let [x, y, angle] = self.poses[sample].get(body).copied().unwrap_or_default();
                ([x, y], angle)
            }),
            (None, Carrier::Point { at } | Carrier::Turn { at, .. }) => {
                self.places(view, |sample| (self.place(at, sample), 0.0))
            }
            (None, Carrier::Stretch(stretch)) => self.stretch(stretch, view),
            (None, Carrier::Band(band)) => self.band(band, view),
            _ => Moves::Left,
        }
    }

    /// Places and angles at all samples, if they change.
    fn places(&self, view: &View, place: impl Fn(usize) -> ([f64; 2], f64)) -> Moves {
        let mut before: Option<f64> = None;
        let places = self.samples().map(|sample| {
            let (at, angle) = place(sample);
            // An angle from two points jumps by a turn.
            let turns = before.map_or(0.0, |before| ((before - angle) / std::f64::consts::TAU).round());
            let angle = angle + turns * std::f64::consts::TAU;
            before = Some(angle);
            let [x, y] = view.pixel(at);
            [x, y, -angle.to_degrees()]
        });
        let places: Vec<[f64; 3]> = places.collect();
        let finite = places.iter().flatten().all(|x| x.is_finite());
        match places.iter().any(|place| *place != places[0]) {
            _ if !finite => Moves::Left,
            false => Moves::Still,
            true => Moves::Rigid(places),
        }
    }

    fn rigid(&self, svg: &mut Svg, elements: &str, places: &[[f64; 3]], sample: Option<usize>) {
        let [x0, y0, angle0] = places[0];
        let back = format!("translate({} {})", number(-x0), number(-y0));
        let place = |[x, y, _]: &[f64; 3]| format!("{} {}", number(*x), number(*y));
        let turn = |[_, _, angle]: &[f64; 3]| number(angle - angle0);
        let elements = elements.trim_end();
        if let Some(sample) = sample {
            let (at, turned) = (place(&places[sample]), turn(&places[sample]));
            svg.raw(&format!("<g transform=\"translate({at}) rotate({turned}) {back}\">\n{elements}\n</g>"));
            return;
        }
        let moved =
            self.animate("animateTransform", "transform\" type=\"translate", places.iter().map(place).collect());
        let turned = self.animate("animateTransform", "transform\" type=\"rotate", places.iter().map(turn).collect());
        let at = place(&places[0]);
        svg.raw(&format!(
            "<g transform=\"translate({at})\">{moved}<g>{turned}<g transform=\"{back}\">\n{elements}\n</g></g></g>"
        ));
    }

    /// Lines with their halos: drawn twice, written once.
    fn bending(&self, svg: &mut Svg, lines: &[Bent], sample: Option<usize>) {
        let name = svg.elements().len();
        for (index, Bent { data, .. }) in lines.iter().enumerate() {
            let now = &data[sample.unwrap_or(0)];
            let animation = if sample.is_some() { String::new() } else { self.animate("animate", "d", data.clone()) };
            svg.raw(&format!("<defs><path id=\"line{name}-{index}\" d=\"{now}\">{animation}</path></defs>"));
        }
        let layers = lines.iter().map(|line| line.styles.len()).max().unwrap_or(0);
        for layer in 0..layers {
            for (index, line) in lines.iter().enumerate() {
                let style = line.styles.get(layer).map_or("", String::as_str);
                svg.raw(&format!("<use href=\"#line{name}-{index}\" {style}/>"));
            }
        }
    }

    /// The element that changes an attribute; nothing if it does not change.
    fn animate(&self, element: &str, attribute: &str, values: Vec<String>) -> String {
        if values.iter().all(|value| *value == values[0]) {
            return String::new();
        }
        format!(
            "<{element} attributeName=\"{attribute}\" dur=\"{}s\" repeatCount=\"indefinite\" values=\"{}\"/>",
            number(self.duration),
            values.join(";")
        )
    }

    fn curve(&self, svg: &mut Svg, curve: &[[f64; 2]], view: &View, sample: Option<usize>) {
        let pixels: Vec<Pixel> = curve.iter().filter(|at| is_finite(at)).map(|&at| view.pixel(at)).collect();
        if pixels.len() != curve.len() || pixels.is_empty() {
            return;
        }
        svg.path(
            &polyline(&pixels),
            &format!(r#"fill="none" stroke="{PATH}" stroke-width="1.6" stroke-linejoin="round""#),
        );
        let places: Vec<[f64; 3]> = self.samples().map(|sample| [pixels[sample][0], pixels[sample][1], 0.0]).collect();
        let mut dot = Svg::default();
        dot.circle(pixels[0], 0.72 * view.pin, &format!(r##"fill="{PATH}" stroke="#ffffff" stroke-width="1.5""##));
        self.rigid(svg, dot.elements(), &places, sample);
    }

    fn stretch(&self, stretch: &Stretch, view: &View) -> Moves {
        let at = |sample: usize| stretch.ends.map(|end| view.pixel(self.place(&end, sample)));
        let bent = |line: &CarriedLine| Bent {
            styles: line.styles.to_vec(),
            data: self.samples().map(|sample| line_data(line, at(sample), stretch, view.pin)).collect(),
        };
        Moves::Bending(stretch.lines.iter().map(bent).collect())
    }

    fn band(&self, Band { ends, radii }: &Band, view: &View) -> Moves {
        let data = self.samples().map(|sample| {
            let at = ends.map(|end| view.pixel(self.place(&end, sample)));
            tangents(at, *radii).into_iter().flatten().map(|line| polyline(&line)).collect::<String>()
        });
        Moves::Bending(vec![Bent { styles: vec![symbols::band_style()], data: data.collect() }])
    }

    fn place(&self, anchor: &Anchor, sample: usize) -> [f64; 2] {
        self.at(anchor.body, anchor.at, sample)
    }

    /// Where a point of a body, given at the start, is at a sample.
    fn at(&self, body: Option<usize>, [x, y]: [f64; 2], sample: usize) -> [f64; 2] {
        let pose = |sample: usize| body.and_then(|body| self.poses.get(sample)?.get(body)).copied().unwrap_or_default();
        let ([x0, y0, start], [x1, y1, angle]) = (pose(0), pose(sample));
        let [u, v] = rotated([x - x0, y - y0], angle - start);
        [x1 + u, y1 + v]
    }

    /// Every place that the mechanism reaches.
    fn corners(&self) -> Vec<[f64; 2]> {
        let Drawing { bodies, joints, springs, couplings, stops, .. } = &self.drawing;
        let of_bodies = bodies
            .iter()
            .enumerate()
            .flat_map(|(index, body)| body.extent().into_iter().map(move |at| (Some(index), at)));
        let of_joints = joints.iter().flat_map(|joint| [0, 1].map(|side| (joint.between[side], joint.at[side])));
        let of_springs = springs.iter().flat_map(|spring| [0, 1].map(|side| (spring.between[side], spring.ends[side])));
        let of_stops = stops.iter().map(|stop| (stop.on, stop.at));
        let points: Vec<(Option<usize>, [f64; 2])> =
            of_bodies.chain(of_joints).chain(of_springs).chain(of_stops).collect();
        let wheels = couplings.iter().flat_map(|coupling| coupling.wheels());
        let mut corners: Vec<[f64; 2]> = self.curves.iter().flatten().copied().collect();
        for wheel in wheels {
            for sample in 0..self.poses.len() {
                let [x, y] = self.at(wheel.body, wheel.centre, sample);
                corners.extend([[x - wheel.radius, y - wheel.radius], [x + wheel.radius, y + wheel.radius]]);
            }
        }
        corners.extend(
            points.iter().flat_map(|&(body, at)| (0..self.poses.len()).map(move |sample| self.at(body, at, sample))),
        );
        corners
    }

    /// The least and the largest displacement along a way, from the start on.
    fn travel(&self, way: &Way) -> [f64; 2] {
        let axis = unit(way.axis);
        let turned = |sample: usize| {
            let angle =
                |sample: usize| way.base.body.and_then(|body| self.poses[sample].get(body)).map_or(0.0, |pose| pose[2]);
            rotated(axis, angle(sample) - angle(0))
        };
        let reach = |sample: usize| {
            dot(difference(self.place(&way.moving, sample), self.place(&way.base, sample)), turned(sample))
        };
        let moved = (0..self.poses.len()).map(|sample| reach(sample) - reach(0)).filter(|x| x.is_finite());
        moved.fold([0.0, 0.0], |[low, high], x| [low.min(x), high.max(x)])
    }
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sine_and_cosine();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// A line of a sign between two places, as it is stretched now.
fn line_data(line: &CarriedLine, [a, b]: [Pixel; 2], stretch: &Stretch, pin: f64) -> String {
    let (axis, full) = (unit(difference(b, a)), norm(difference(b, a)));
    let [from, to] = stretch.retreat.map(|retreat| retreat.min(0.3 * full));
    let length = (full - from - to) / pin;
    let begin = along(a, from, axis);
    let place = |&[x, y, slope]: &[f64; 3]| {
        let reach = (x + slope * (length - stretch.length)).clamp(0.0, length.max(0.0));
        along(along(begin, reach * pin, axis), y * pin, normal(axis))
    };
    let points: Vec<Pixel> = line.points.iter().map(place).collect();
    // A tenth of a pixel will do: these are the longest texts of a film.
    let points: Vec<Pixel> = points.iter().map(|point| point.map(|x| (10.0 * x).round() / 10.0)).collect();
    format!("{}{}", polyline(&points), if line.closed { "Z" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::super::{DrawnBody, DrawnJoint, Hold};
    use super::*;

    fn swinging() -> Film {
        let body =
            DrawnBody { name: "bar".into(), points: vec![[0.0, 0.0], [1.0, 0.0]], centre: [0.5, 0.0], shape: None };
        let hinge = DrawnJoint {
            name: "hinge".into(),
            kind: Hold::Pin,
            between: [None, Some(0)],
            at: [[0.0; 2]; 2],
            open: false,
        };
        let drawing = Drawing { bodies: vec![body], joints: vec![hinge], ..Drawing::default() };
        let angles = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * std::f64::consts::FRAC_PI_2);
        let poses = angles.map(|angle| vec![[0.5 * f64::cos(angle), 0.5 * f64::sin(angle), angle]]);
        let tip = angles.map(|angle| [f64::cos(angle), f64::sin(angle)]);
        Film::new(drawing, poses.to_vec(), vec![tip.to_vec()], 2.0, 1)
    }

    #[test]
    fn points_are_carried_by_their_bodies() {
        let film = swinging();
        for (sample, tip) in film.curves[0].iter().enumerate() {
            let at = film.at(Some(0), [1.0, 0.0], sample);
            assert!(norm(difference(at, *tip)) < 1e-12, "{at:?} {tip:?}");
        }
    }

    #[test]
    fn a_film_moves_and_its_pictures_stand_still() {
        let film = swinging();
        let svg = film.svg();
        assert!(svg.contains("<animateTransform") && svg.contains("repeatCount=\"indefinite\""), "{svg}");
        assert!(svg.contains("0;-22.5;-45;-67.5;-90"), "a quarter turn cannot be drawn with fewer samples: {svg}");
        let frame = film.frame(4);
        assert!(!frame.contains("<animate") && frame.contains("rotate(-90)"), "{frame}");
        let view = |svg: &str| svg.split("viewBox=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        assert_eq!(view(&svg), view(&frame), "all pictures show the same part of the world");
    }

    #[test]
    fn a_stroke_follows_its_ends_and_keeps_its_height() {
        let points = vec![[0.0, 0.0, 0.0], [5.0, 1.0, 0.5], [10.0, 0.0, 1.0]];
        let line = CarriedLine { closed: false, points, styles: Default::default() };
        let (name, ends) = (String::new(), [Anchor::new(None, [0.0; 2]); 2]);
        let stretch = Stretch { name, ends, retreat: [0.0; 2], length: 10.0, lines: Vec::new() };
        assert_eq!(line_data(&line, [[0.0, 0.0], [20.0, 0.0]], &stretch, 1.0), "M0 0L10 1L20 0");
        assert_eq!(line_data(&line, [[0.0, 0.0], [0.0, 10.0]], &stretch, 1.0), "M0 0L-1 5L0 10");
    }
}
