//! One pair of axes with its curves and its legend.

use super::PlotSeries;
use super::ticks::Ticks;
use crate::svg::{PictureFrame, Pixel, Svg, polyline, text_width};

pub struct Panel<'a> {
    pub unit: &'a str,
    pub series: Vec<&'a PlotSeries>,
    /// Measured values of some of them.
    pub measured: Vec<&'a PlotSeries>,
}

/// Colours that are distinct on white, also with most colour vision deficiencies.
pub const COLOURS: [&str; 8] = ["#2f6cab", "#d1701f", "#3f8f45", "#b8473f", "#7d55a8", "#2b8a84", "#9c8214", "#6b7280"];
pub const GRID: &str = r##"stroke="#e6eaef" stroke-width="1""##;
pub const AXIS: &str = r##"stroke="#9aa5b1" stroke-width="1""##;
pub const TICK: &str = r##"font-size="12" fill="#4b5563""##;
pub const TITLE: &str = r##"font-size="12.5" fill="#1f2933""##;
/// More dots than this are a band.
const MOST_DOTS: usize = 5000;
/// More curves than this have no room in the legend.
const LEGEND: usize = 9;

impl Panel<'_> {
    /// The axis upwards.
    pub fn values(&self) -> Ticks {
        let all = self.series.iter().chain(&self.measured);
        Ticks::around(all.flat_map(|series| series.values.iter().copied()), 5)
    }

    pub fn draw(&self, svg: &mut Svg, frame: PictureFrame, time: &[f64], times: &Ticks, values: &Ticks) {
        self.draw_axis(svg, frame, values, times);
        let pixels = |series: &PlotSeries| -> Vec<Option<Pixel>> {
            let at = series.at.as_deref().unwrap_or(time);
            let pixel = |(&t, &value): (&f64, &f64)| {
                let pixel = place(frame, times.part(t), values.part(value));
                pixel.iter().all(|x| x.is_finite()).then_some(pixel)
            };
            at.iter().zip(&series.values).map(pixel).collect()
        };
        let dashes: Vec<&str> = (0..self.series.len()).map(|index| self.dashes(index, values)).collect();
        for (index, series) in self.series.iter().enumerate() {
            let style = format!(
                r#"fill="none" stroke="{}" stroke-width="1.8" stroke-linejoin="round" stroke-linecap="round"{}"#,
                colour(index),
                dashes[index]
            );
            svg.path(&curve(pixels(series).into_iter()), &style);
        }
        for measured in &self.measured {
            let style = self.dots(measured);
            pixels(measured).into_iter().flatten().take(MOST_DOTS).for_each(|pixel| svg.circle(pixel, 2.2, &style));
        }
        self.draw_legend(svg, frame, &dashes);
    }

    /// Dashes for a curve that lies on an earlier one, which is seen between them.
    fn dashes(&self, index: usize, values: &Ticks) -> &'static str {
        let series = self.series[index];
        let near = 0.004 * (values.range[1] - values.range[0]);
        let is_same = |other: &&&PlotSeries| {
            let apart = |(a, b): (&f64, &f64)| (a - b).abs() > near;
            series.at == other.at && !series.values.is_empty() && !series.values.iter().zip(&other.values).any(apart)
        };
        match self.series[..index].iter().filter(is_same).count() {
            0 => "",
            1 => r#" stroke-dasharray="7 7""#,
            _ => r#" stroke-dasharray="2 9""#,
        }
    }

    /// Dots in the colour of the curve that they were measured for.
    fn dots(&self, measured: &PlotSeries) -> String {
        let of = self.series.iter().position(|series| Some(&series.name) == measured.measured.as_ref());
        format!(r##"fill="#ffffff" stroke="{}" stroke-width="1.3""##, colour(of.unwrap_or(0)))
    }

    fn draw_axis(&self, svg: &mut Svg, frame: PictureFrame, values: &Ticks, times: &Ticks) {
        for &at in &times.at {
            let part = times.part(at);
            svg.line(place(frame, part, 0.0), place(frame, part, 1.0), GRID);
        }
        for &at in &values.at {
            svg.line(place(frame, 0.0, values.part(at)), place(frame, 1.0, values.part(at)), GRID);
        }
        upwards(svg, frame, values);
        svg.line(place(frame, 0.0, 0.0), place(frame, 0.0, 1.0), AXIS);
        svg.line(place(frame, 0.0, 0.0), place(frame, 1.0, 0.0), AXIS);
        beside(svg, frame, &self.title());
    }

    /// The name if there is one curve or one for all of them, otherwise what they are, and the unit.
    fn title(&self) -> String {
        // No unit is no unit: it may be a pure number, or not known.
        let unit = if self.unit.is_empty() { String::new() } else { format!("[{}]", self.unit) };
        let title = match self.series[..] {
            [PlotSeries { panel: Some(name), .. }, ..] => format!("{} {unit}", shortened(name, 22)),
            [only] if text_width(&only.name, 12.5) < 130.0 => format!("{} {unit}", only.name),
            _ => format!("{} {unit}", quantity(self.unit)),
        };
        title.trim().to_owned()
    }

    fn draw_legend(&self, svg: &mut Svg, frame: PictureFrame, dashes: &[&str]) {
        let x = frame.x + frame.width + 14.0;
        for (index, series) in self.series.iter().take(LEGEND).enumerate() {
            let y = frame.y + 12.0 + 19.0 * index as f64;
            let dash = if dashes[index].is_empty() { "" } else { r#" stroke-dasharray="4 6""# };
            let style = format!(r#"stroke="{}" stroke-width="3" stroke-linecap="round"{dash}"#, colour(index));
            svg.line([x, y - 4.0], [x + 16.0, y - 4.0], &style);
            svg.text([x + 24.0, y], TICK, &shortened(&series.name, 19));
        }
        let mut next = self.series.len().min(LEGEND);
        if self.series.len() > LEGEND {
            let y = frame.y + 12.0 + 19.0 * next as f64;
            svg.text([x + 24.0, y], TICK, &format!("and {} more", self.series.len() - LEGEND));
            next += 1;
        }
        for (row, measured) in self.measured.iter().take((LEGEND + 1).saturating_sub(next)).enumerate() {
            let y = frame.y + 12.0 + 19.0 * (next + row) as f64;
            svg.circle([x + 8.0, y - 4.0], 2.6, &self.dots(measured));
            svg.text([x + 24.0, y], TICK, &shortened(&measured.name, 19));
        }
    }
}

/// Both axes with their titles.
pub fn axes(svg: &mut Svg, frame: PictureFrame, [x, y]: [&Ticks; 2], titles: [&str; 2]) {
    svg.line(place(frame, 0.0, 0.0), place(frame, 0.0, 1.0), AXIS);
    svg.line(place(frame, 0.0, 0.0), place(frame, 1.0, 0.0), AXIS);
    upwards(svg, frame, y);
    beside(svg, frame, titles[1]);
    along(svg, frame, x, titles[0]);
}

/// The axis below.
pub fn along(svg: &mut Svg, frame: PictureFrame, times: &Ticks, title: &str) {
    let bottom = frame.y + frame.height;
    for &at in &times.at {
        let [x, _] = place(frame, times.part(at), 0.0);
        svg.line([x, bottom], [x, bottom + 4.0], AXIS);
        svg.text([x, bottom + 18.0], &format!(r#"{TICK} text-anchor="middle""#), &times.label(at));
    }
    below(svg, frame, title);
}

/// The title of the axis below.
pub fn below(svg: &mut Svg, frame: PictureFrame, title: &str) {
    let middle = [frame.x + 0.5 * frame.width, frame.y + frame.height + 39.0];
    svg.text(middle, &format!(r#"{TITLE} text-anchor="middle""#), title);
}

/// The labels of the axis upwards.
fn upwards(svg: &mut Svg, frame: PictureFrame, values: &Ticks) {
    for &at in &values.at {
        let [x, y] = place(frame, 0.0, values.part(at));
        svg.text([x - 8.0, y + 4.2], &format!(r#"{TICK} text-anchor="end""#), &values.label(at));
    }
}

/// The title of the axis upwards.
pub fn beside(svg: &mut Svg, frame: PictureFrame, title: &str) {
    let [x, y] = [20.0, frame.y + 0.5 * frame.height];
    let style = format!(r#"{TITLE} text-anchor="middle" transform="rotate(-90 {x} {y})""#);
    svg.text([x, y], &style, title);
}

/// What is measured in a unit; nothing if that is not clear.
fn quantity(unit: &str) -> &'static str {
    match unit {
        "rad" | "deg" | "rev" => "angle",
        "rad/s" | "deg/s" | "rpm" => "angular velocity",
        "rad/s2" | "deg/s2" => "angular acceleration",
        "m" | "mm" | "cm" | "in" => "displacement",
        "m/s" | "mm/s" | "cm/s" | "in/s" => "velocity",
        "m/s2" | "mm/s2" | "cm/s2" | "in/s2" => "acceleration",
        "N" | "kN" | "mN" | "lbf" => "force",
        "N.m" | "kN.m" | "N.mm" => "torque",
        "J" | "kJ" | "mJ" => "energy",
        "W" | "kW" | "mW" => "power",
        "A" | "mA" => "current",
        "V" | "mV" | "kV" => "voltage",
        _ => "",
    }
}

fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// A point of the axes, from parts of their lengths.
pub fn place(frame: PictureFrame, right: f64, up: f64) -> Pixel {
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

pub fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    let end: String = name.chars().rev().take(most - 1).collect();
    format!("\u{2026}{}", end.chars().rev().collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alike::Alike;

    #[test]
    fn thinning_keeps_the_extremes() {
        let line: Vec<Pixel> = (0..10_000).map(|i| [f64::from(i) * 0.01, (f64::from(i) * 0.7).sine()]).collect();
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
