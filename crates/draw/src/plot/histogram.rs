//! How often values occur.

use super::panel::{COLOURS, GRID, TICK, axes, place};
use super::ticks::Ticks;
use super::{BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, headed};
use crate::alike::Alike;
use crate::svg::{PictureFrame, Svg};

/// Histograms, one below the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    pub title: String,
    /// What is counted, such as `runs`.
    pub counted: String,
    pub samples: Vec<HistogramSample>,
}

/// The values of a quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HistogramSample {
    /// Its name, with its unit.
    pub name: String,
    /// Those that are not finite are left out.
    pub values: Vec<f64>,
}

/// Fewest and most bins.
const BINS: [usize; 2] = [5, 60];
/// Quantiles that are given, with their names.
const QUANTILES: [(f64, &str); 3] = [(0.05, "5 %"), (0.5, "median"), (0.95, "95 %")];

impl Histogram {
    pub fn svg(&self) -> String {
        let mut svg = headed(&self.title);
        let mut frame = PictureFrame { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT };
        for sample in &self.samples {
            let mut values: Vec<f64> = sample.values.iter().copied().filter(|value| value.is_finite()).collect();
            values.sort_by(f64::total_cmp);
            self.draw(&mut svg, frame, &sample.name, &values);
            figures(&mut svg, frame, &values);
            frame.y += HEIGHT + BOTTOM + 8.0;
        }
        svg.finish(PictureFrame { x: 0.0, y: 0.0, width: WIDTH, height: frame.y }, &self.title)
    }

    fn draw(&self, svg: &mut Svg, frame: PictureFrame, name: &str, sorted: &[f64]) {
        let along_axis = Ticks::around(sorted.iter().copied(), 8);
        let bins = bins(sorted, &along_axis);
        let most = bins.iter().map(|bin| bin.1).max().unwrap_or(1);
        let whole = Ticks::over([0.0, 1.05 * most.max(1) as f64].into_iter(), 5).whole();
        for &at in &whole.at {
            svg.line(place(frame, 0.0, whole.part(at)), place(frame, 1.0, whole.part(at)), GRID);
        }
        let style = format!(r##"fill="{}" stroke="#ffffff" stroke-width="0.6""##, COLOURS[0]);
        for &([from, to], count) in &bins {
            let low = place(frame, along_axis.part(from), 0.0);
            let high = place(frame, along_axis.part(to), whole.part(count as f64));
            let bar = PictureFrame { x: low[0], y: high[1], width: high[0] - low[0], height: low[1] - high[1] };
            svg.rectangle(bar, 0.0, &style);
        }
        axes(svg, frame, [&along_axis, &whole], [name, &self.counted]);
    }
}

/// Bins and how many values are in each: as wide as Freedman and Diaconis (1981) advise.
fn bins(sorted: &[f64], axis: &Ticks) -> Vec<([f64; 2], usize)> {
    let [Some(&low), Some(&high)] = [sorted.first(), sorted.last()] else { return Vec::new() };
    let wide = axis.range[1] - axis.range[0];
    // What differs by rounding only is one bin.
    if high - low < 1e-3 * wide {
        let middle = 0.5 * (low + high);
        return vec![([middle - 0.02 * wide, middle + 0.02 * wide], sorted.len())];
    }
    let quartiles = quantile(sorted, 0.75) - quantile(sorted, 0.25);
    let width = 2.0 * quartiles / (sorted.len() as f64).cube_root();
    let count = if width > 0.0 { ((high - low) / width).ceil().min(1e6) as usize } else { BINS[1] };
    let count = count.clamp(BINS[0], BINS[1]);
    let edge = |index: usize| low + (high - low) * index as f64 / count as f64;
    let below = |index: usize| match index {
        index if index == count => sorted.len(),
        index => sorted.partition_point(|&value| value < edge(index)),
    };
    (0..count).map(|index| ([edge(index), edge(index + 1)], below(index + 1) - below(index))).collect()
}

/// Of sorted values, linear between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * sorted.len().saturating_sub(1) as f64;
    let below = place as usize;
    let at = |index: usize| sorted.get(index).or(sorted.last()).copied().unwrap_or(f64::NAN);
    at(below) + (place - below as f64) * (at(below + 1) - at(below))
}

/// Beside the histogram: mean, standard deviation, quantiles.
fn figures(svg: &mut Svg, frame: PictureFrame, sorted: &[f64]) {
    let count = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / count;
    let squares = sorted.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    let mut lines = vec![("values", sorted.len().to_string())];
    if !sorted.is_empty() {
        lines.push(("mean", short(mean)));
        if sorted.len() > 1 {
            lines.push(("std. dev.", short((squares / (count - 1.0)).sqrt())));
        }
        lines.extend(QUANTILES.map(|(share, name)| (name, short(quantile(sorted, share)))));
    }
    for (row, (name, value)) in lines.iter().enumerate() {
        let (x, y) = (frame.x + frame.width + 14.0, frame.y + 12.0 + 19.0 * row as f64);
        svg.text([x, y], TICK, name);
        svg.text([x + 66.0, y], TICK, value);
    }
}

/// Six digits.
fn short(value: f64) -> String {
    let exponent = if value == 0.0 { 0 } else { value.abs().decimal_logarithm().floor() as i32 };
    match exponent {
        -4..=5 => format!("{value:.*}", (5 - exponent) as usize),
        _ => format!("{value:.5e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bin() {
        for count in [1, 2, 3, 10, 1000] {
            let values: Vec<f64> = (0..count).map(|index| f64::from(index).sqrt()).collect();
            let bins = bins(&values, &Ticks::around(values.iter().copied(), 8));
            assert_eq!(bins.iter().map(|bin| bin.1).sum::<usize>(), values.len());
            assert!(bins.windows(2).all(|pair| pair[0].0[1] == pair[1].0[0]));
        }
        let same = bins(&[2.0; 7], &Ticks::around([2.0].into_iter(), 8));
        assert_eq!(same.iter().map(|bin| bin.1).collect::<Vec<_>>(), [7]);
    }

    #[test]
    fn quantiles_are_linear_between_values() {
        let values = [0.0, 1.0, 2.0, 10.0];
        assert_eq!([0.0, 0.5, 1.0].map(|share| quantile(&values, share)), [0.0, 1.5, 10.0]);
    }

    #[test]
    fn without_values_there_is_still_a_picture() {
        let sample = HistogramSample { name: "x [m]".into(), values: vec![f64::NAN] };
        let svg = Histogram { samples: vec![sample], ..Histogram::default() }.svg();
        assert!(!svg.contains("NaN") && svg.contains("x [m]"), "{svg}");
    }
}
