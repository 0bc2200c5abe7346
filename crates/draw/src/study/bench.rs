//! The work-precision diagram: time over error, one curve for each method.

use cotree_study::bench::Bench;

use crate::plot::{LogScale, draw_axes, headed, place};
use crate::svg::{PictureFrame, Pixel, Svg, polyline};

const WIDTH: f64 = 720.0;
const AXES: PictureFrame = PictureFrame { x: 84.0, y: 52.0, width: 600.0, height: 360.0 };
/// Below the axes [px].
const BOTTOM: f64 = 52.0;
const COLOURS: [&str; 4] = ["#1f2933", "#2f6cab", "#b4532a", "#3f7d4e"];

/// The picture, self-contained. Runs whose errors may be the reference's own are left out.
pub fn svg(bench: &Bench) -> String {
    let mut methods: Vec<(&str, Vec<[f64; 2]>)> = Vec::new();
    for run in &bench.runs {
        let Ok(measured) = &run.result else { continue };
        let Some(seconds) = measured.cpu_seconds.filter(|_| measured.resolved) else { continue };
        let point = [measured.error, 1e3 * seconds];
        match methods.iter_mut().find(|(method, _)| *method == run.method) {
            Some((_, points)) => points.push(point),
            None => methods.push((run.method, vec![point])),
        }
    }
    let title = format!("{}: time over error", bench.name);
    let mut svg = headed(&title);
    if methods.is_empty() {
        let place = [AXES.x, AXES.y + 20.0];
        let text = "No error is larger than the reference's own: there are no errors to draw.";
        svg.text(place, r##"font-size="12.5" fill="#1f2933""##, text);
    } else {
        draw(&mut svg, &methods, &format!("{} [ms]", bench.clock));
    }
    svg.finish(PictureFrame { x: 0.0, y: 0.0, width: WIDTH, height: AXES.y + AXES.height + BOTTOM }, &title)
}

fn draw(svg: &mut Svg, methods: &[(&str, Vec<[f64; 2]>)], time: &str) {
    let all = || methods.iter().flat_map(|(_, points)| points);
    let [across, up] = [0, 1].map(|axis| LogScale::over(all().map(|point| point[axis])));
    draw_axes(svg, AXES, [&across, &up], ["largest relative error", time]);
    for (index, (method, points)) in methods.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let pixels: Vec<Pixel> = points.iter().map(|[x, y]| place(AXES, across.part(*x), up.part(*y))).collect();
        // The first method lies under one of the others where it has chosen that.
        let width = if index == 0 { 5.0 } else { 1.8 };
        let style = format!(
            r#"fill="none" stroke="{colour}" stroke-width="{width}" stroke-opacity="{}" stroke-linejoin="round""#,
            if index == 0 { 0.25 } else { 1.0 }
        );
        svg.path(&polyline(&pixels), &style);
        for pixel in pixels {
            svg.circle(pixel, 3.2, &format!(r##"fill="{colour}" stroke="#ffffff" stroke-width="1""##));
        }
        let x = AXES.x + AXES.width - 90.0;
        let y = AXES.y + 14.0 + 18.0 * index as f64;
        svg.line([x - 26.0, y - 4.0], [x - 6.0, y - 4.0], &style);
        svg.text([x, y], r##"font-size="12.5" fill="#1f2933""##, method);
    }
}

#[cfg(test)]
mod tests {
    use cotree_study::bench::Reference;

    use super::*;

    #[test]
    fn without_errors_the_picture_says_so() {
        let reference = Reference { method: "auto", tolerance: 1e-13, error: 0.0, other: None, confirmed: false };
        let (name, span, points, clock, share) = ("four_bar".to_owned(), [0.0, 1.0], 1024, "processor time", 0.5);
        let (energy_kept, attainable, runs) = (false, 0.0, Vec::new());
        let bench = Bench { name, span, reference, points, clock, share, energy_kept, attainable, runs };
        assert!(svg(&bench).contains("there are no errors to draw"));
    }
}
