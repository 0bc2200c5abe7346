//! One pair of axes with its curves and its legend.

use super::Series;
use super::ticks::Ticks;
use crate::output::svg::{Frame, Pixel, Svg, polyline, text_width};

pub struct Panel<'a> {
    pub unit: &'a str,
    pub series: Vec<&'a Series>,
}

/// Colours that are distinct on white, also with most colour vision deficiencies.
const COLOURS: [&str; 8] = ["#2f6cab", "#d1701f", "#3f8f45", "#b8473f", "#7d55a8", "#2b8a84", "#9c8214", "#6b7280"];
const GRID: &str = r##"stroke="#e6eaef" stroke-width="1""##;
const AXIS: &str = r##"stroke="#9aa5b1" stroke-width="1""##;
const TICK: &str = r##"font-size="12" fill="#4b5563""##;
const TITLE: &str = r##"font-size="12.5" fill="#1f2933""##;
/// More curves than this have no room in the legend.
const LEGEND: usize = 9;

impl Panel<'_> {
    pub fn draw(&self, svg: &mut Svg, frame: Frame, time: &[f64], times: &Ticks) {
        let values = Ticks::around(self.series.iter().flat_map(|series| series.values.iter().copied()), 5);
        self.draw_axis(svg, frame, &values, times);
        for (index, series) in self.series.iter().enumerate() {
            let pixels = time.iter().zip(&series.values).map(|(&t, &value)| {
                let pixel = place(frame, times.part(t), values.part(value));
                pixel.iter().all(|x| x.is_finite()).then_some(pixel)
            });
            let style = format!(
                r#"fill="none" stroke="{}" stroke-width="1.8" stroke-linejoin="round" stroke-linecap="round""#,
                colour(index)
            );
            svg.path(&curve(pixels), &style);
        }
        self.draw_legend(svg, frame);
    }

    fn draw_axis(&self, svg: &mut Svg, frame: Frame, values: &Ticks, times: &Ticks) {
        for &at in &times.at {
            let part = times.part(at);
            svg.line(place(frame, part, 0.0), place(frame, part, 1.0), GRID);
        }
        for &at in &values.at {
            let [x, y] = place(frame, 0.0, values.part(at));
            svg.line([x, y], place(frame, 1.0, values.part(at)), GRID);
            svg.text([x - 8.0, y + 4.2], &format!(r#"{TICK} text-anchor="end""#), &values.label(at));
        }
        svg.line(place(frame, 0.0, 0.0), place(frame, 0.0, 1.0), AXIS);
        svg.line(place(frame, 0.0, 0.0), place(frame, 1.0, 0.0), AXIS);
        let [x, y] = [20.0, frame.y + 0.5 * frame.height];
        let style = format!(r#"{TITLE} text-anchor="middle" transform="rotate(-90 {x} {y})""#);
        svg.text([x, y], &style, &self.title());
    }

    /// The name if there is one curve, otherwise what they are, and the unit.
    fn title(&self) -> String {
        // No unit is no unit: it may be a pure number, or not known.
        let unit = if self.unit.is_empty() { String::new() } else { format!("[{}]", self.unit) };
        let title = match self.series[..] {
            [only] if text_width(&only.name, 12.5) < 130.0 => format!("{} {unit}", only.name),
            _ => format!("{} {unit}", quantity(self.unit)),
        };
        title.trim().to_owned()
    }

    fn draw_legend(&self, svg: &mut Svg, frame: Frame) {
        let x = frame.x + frame.width + 14.0;
        for (index, series) in self.series.iter().take(LEGEND).enumerate() {
            let y = frame.y + 12.0 + 19.0 * index as f64;
            let style = format!(r#"stroke="{}" stroke-width="3" stroke-linecap="round""#, colour(index));
            svg.line([x, y - 4.0], [x + 16.0, y - 4.0], &style);
            svg.text([x + 24.0, y], TICK, &shortened(&series.name, 19));
        }
        if self.series.len() > LEGEND {
            let y = frame.y + 12.0 + 19.0 * LEGEND as f64;
            svg.text([x + 24.0, y], TICK, &format!("and {} more", self.series.len() - LEGEND));
        }
    }
}

pub fn time_axis(svg: &mut Svg, frame: Frame, times: &Ticks) {
    let bottom = frame.y + frame.height;
    for &at in &times.at {
        let [x, _] = place(frame, times.part(at), 0.0);
        svg.line([x, bottom], [x, bottom + 4.0], AXIS);
        svg.text([x, bottom + 18.0], &format!(r#"{TICK} text-anchor="middle""#), &times.label(at));
    }
    let middle = [frame.x + 0.5 * frame.width, bottom + 39.0];
    svg.text(middle, &format!(r#"{TITLE} text-anchor="middle""#), "time [s]");
}

/// What is measured in a unit; nothing if that is not clear.
fn quantity(unit: &str) -> &'static str {
    match unit {
        "rad" => "angle",
        "rad/s" => "angular velocity",
        "rad/s2" => "angular acceleration",
        "m" => "displacement",
        "m/s" => "velocity",
        "m/s2" => "acceleration",
        "N" => "force",
        "N.m" => "torque",
        "J" => "energy",
        "W" => "power",
        _ => "",
    }
}

fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// A point of the axes, from parts of their lengths.
fn place(frame: Frame, right: f64, up: f64) -> Pixel {
    [frame.x + right * frame.width, frame.y + (1.0 - up) * frame.height]
}

/// Path data of a curve. Of all points in one half pixel of time only the first, lowest, highest and last are kept:
/// the picture is the same for any number of points. A gap starts a new line.
fn curve(pixels: impl Iterator<Item = Option<Pixel>>) -> String {
    let mut data = String::new();
    let mut line: Vec<Pixel> = Vec::new();
    for pixel in pixels.chain([None]) {
        match pixel {
            Some(pixel) => line.push(pixel),
            None => data += &polyline(&thinned(&std::mem::take(&mut line))),
        }
    }
    data
}

fn thinned(line: &[Pixel]) -> Vec<Pixel> {
    let mut kept = Vec::new();
    for column in line.chunk_by(|a, b| (2.0 * a[0]).floor() == (2.0 * b[0]).floor()) {
        if column.len() <= 4 {
            kept.extend_from_slice(column);
            continue;
        }
        let index = |pick: fn(&(usize, &Pixel), &(usize, &Pixel)) -> std::cmp::Ordering| {
            column.iter().enumerate().min_by(pick).map_or(0, |(index, _)| index)
        };
        let mut wanted =
            [0, index(|a, b| a.1[1].total_cmp(&b.1[1])), index(|a, b| b.1[1].total_cmp(&a.1[1])), column.len() - 1];
        wanted.sort_unstable();
        kept.extend(wanted.map(|index| column[index]));
    }
    kept
}

fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    let end: String = name.chars().rev().take(most - 1).collect();
    format!("\u{2026}{}", end.chars().rev().collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes() {
        let line: Vec<Pixel> = (0..10_000).map(|i| [f64::from(i) * 0.01, (f64::from(i) * 0.7).sin()]).collect();
        let kept = thinned(&line);
        assert!(kept.len() <= 4 * 202);
        let lowest = |line: &[Pixel]| line.iter().map(|pixel| pixel[1]).fold(f64::MAX, f64::min);
        assert_eq!(lowest(&kept), lowest(&line));
        assert_eq!(kept.last(), line.last());
    }

    #[test]
    fn long_names_keep_their_end() {
        assert_eq!(shortened("upper_arm.left_hand.small_end.x", 12), "…small_end.x");
    }
}
