//! Stills, films, curves and drawings for CAD: against the motion that `cotree simulate` gives.

use crate::outside::command;
use crate::support::ROOT;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use command::{code, cotree, stderr};
use resvg::tiny_skia::Pixmap;

fn model(name: &str) -> String {
    let path = Path::new(ROOT).join("models").join(name).join("scene.toml");
    path.to_str().unwrap().to_owned()
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = cotree(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
}

/// A table of `cotree`: its heads, and its rows.
fn table(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let heads = lines.next().unwrap().split(',').map(str::to_owned).collect();
    (heads, lines.map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect())
}

/// The value of a variable at a time of the run that `simulate` makes.
fn value(folder: &Path, scene: &str, variable: &str, time: f64) -> f64 {
    done(folder, &["simulate", scene, "-o", "run.csv"]);
    let (heads, rows) = table(&fs::read_to_string(folder.join("run.csv")).unwrap());
    let column = heads.iter().position(|head| head == variable).unwrap_or_else(|| panic!("no {variable}"));
    let row = rows.iter().find(|row| (row[0] - time).abs() < 1e-9).unwrap();
    row[column]
}

/// Entities of a DXF file: kind and layer, and all places that they have \[mm\].
fn entities(text: &str) -> Vec<(String, String, Vec<[f64; 2]>)> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let groups: Vec<(&str, &str)> = lines.chunks(2).map(|pair| (pair[0], pair[1])).collect();
    let start = groups.iter().position(|group| *group == ("2", "ENTITIES")).unwrap() + 1;
    let mut found: Vec<(String, String, Vec<[f64; 2]>)> = Vec::new();
    for &(group, value) in &groups[start..] {
        let Some((_, layer, places)) = found.last_mut().filter(|_| group != "0") else {
            found.push((value.to_owned(), String::new(), Vec::new()));
            continue;
        };
        match group {
            "8" => *layer = value.to_owned(),
            "10" => places.push([value.parse().unwrap(), 0.0]),
            "20" => places.last_mut().unwrap()[1] = value.parse().unwrap(),
            _ => {}
        }
    }
    found
}

/// The animated or the still SVG is well-formed XML.
fn elements(svg: &str) -> usize {
    let mut reader = quick_xml::Reader::from_str(svg);
    let mut count = 0;
    loop {
        match reader.read_event().unwrap_or_else(|error| panic!("{error}\n{svg}")) {
            quick_xml::events::Event::Eof => return count,
            quick_xml::events::Event::Start(_) | quick_xml::events::Event::Empty(_) => count += 1,
            _ => {}
        }
    }
}

#[test]
fn a_still_shows_the_pose_of_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("double_pendulum");
    done(folder, &["show", &scene, "--drawing", "pose.dxf", "--at", "500 ms"]);
    let text = fs::read_to_string(folder.join("pose.dxf")).unwrap();
    let angle = value(folder, &scene, "upper.angle", 0.5);
    let points = entities(&text);
    let of_upper: Vec<[f64; 2]> =
        points.iter().filter(|(kind, layer, _)| kind == "POINT" && layer == "UPPER").map(|(.., at)| at[0]).collect();
    let along = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]).atan2(b[0] - a[0]);
    let off = (along(of_upper[0], of_upper[1]) - angle) / std::f64::consts::PI;
    assert!((off - off.round()).abs() < 1e-6, "{of_upper:?} lie along {angle} rad");
    done(folder, &["show", &scene, "--drawing", "start.svg"]);
    done(folder, &["show", &scene, "--drawing", "pose.svg", "--at", "0.5 s"]);
    done(folder, &["show", &scene, "--drawing", "same.svg", "--at", "0 s"]);
    let svg = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_ne!(svg("start.svg"), svg("pose.svg"));
    assert_eq!(svg("start.svg"), svg("same.svg"));
    done(folder, &["show", &scene, "--drawing", "pose.PNG", "--at", "0.5 s"]);
    let png = Pixmap::decode_png(&fs::read(folder.join("pose.PNG")).unwrap()).unwrap();
    assert!(png.width() > 300 && png.pixels().iter().any(|pixel| pixel.red() < 100));
}

/// A picture for LaTeX says what the SVG says, and a document takes it as it is.
#[test]
fn pictures_for_latex_can_be_typeset() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("double_pendulum");
    done(folder, &["show", &scene, "--drawing", "pose.tex", "--graph", "graphs.TEX", "--at", "0.5 s"]);
    done(folder, &["show", &scene, "--drawing", "start.tex"]);
    done(folder, &["check", &scene, "--drawing", "checked.tex"]);
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    for name in ["pose.tex", "graphs.TEX"] {
        let text = text(name);
        assert!(text.starts_with("\\begin{tikzpicture}") && text.ends_with("\\end{tikzpicture}\n"), "{name}: {text}");
        assert!(text.contains("{upper};") && text.contains("{lower};"), "{name}: {text}");
    }
    assert_ne!(text("pose.tex"), text("start.tex"));
    assert_eq!(text("checked.tex"), text("start.tex"));
    let page = "\\documentclass{article}\\usepackage{tikz}\\begin{document}\\input{pose.tex}\\input{graphs.TEX}\\end{document}";
    fs::write(folder.join("page.tex"), page).unwrap();
    let mut latex = Command::new("pdflatex");
    latex.args(["-interaction=nonstopmode", "-halt-on-error", "page.tex"]).current_dir(folder);
    // Elsewhere the pictures of lessons hold the writer to known commands.
    if let Ok(output) = latex.output() {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
}

#[test]
fn impossible_stills_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = model("double_pendulum");
    for (arguments, words) in [
        (&["--drawing", "a.svg", "--at", "-1 s"][..], "before the start"),
        (&["--drawing", "a.svg", "--at", "1 kg"], "not in s"),
        (&["--drawing", "a.bmp"], "`.png`"),
        (&["--drawing", "a.pdf"], "its name must end with `.svg` or `.png` or `.tex` or `.dxf`"),
        (&["--at", "1 s"], "--drawing"),
    ] {
        let output = cotree(folder.path(), &[&["show", &scene], arguments].concat());
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(words), "{arguments:?}: {}", stderr(&output));
    }
}

/// The values of every `animateTransform` of a type in an SVG.
fn animations(svg: &str, kind: &str) -> Vec<Vec<Vec<f64>>> {
    let numbers = |text: &str| text.split(' ').map(|number| number.parse().unwrap()).collect();
    let values = |element: &str| {
        let values = element.split("values=\"").nth(1).unwrap().split('"').next().unwrap();
        values.split(';').map(numbers).collect()
    };
    svg.split("<animateTransform")
        .skip(1)
        .filter(|element| element.contains(&format!("type=\"{kind}\"")))
        .map(values)
        .collect()
}

#[test]
fn an_animated_svg_turns_the_bodies_as_the_run_does() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, body) in [("four_bar", "crank"), ("slider_crank", "crank"), ("planetary_gear", "sun")] {
        let scene = model(name);
        done(folder, &["view", &scene, "--svg", "-o", "film.svg"]);
        let svg = fs::read_to_string(folder.join("film.svg")).unwrap();
        assert!(elements(&svg) > 10 && !svg.contains("NaN") && !svg.contains("<script"), "{name}");
        done(folder, &["simulate", &scene, "-o", "run.csv"]);
        let (heads, rows) = table(&fs::read_to_string(folder.join("run.csv")).unwrap());
        let column = heads.iter().position(|head| *head == format!("{body}.angle")).unwrap();
        let turned = -(rows.last().unwrap()[column] - rows[0][column]).to_degrees();
        let all = animations(&svg, "rotate");
        let is_it = |values: &Vec<Vec<f64>>| (values.last().unwrap()[0] - turned).abs() < 0.02;
        assert!(all.iter().any(is_it), "{name}: nothing turns by {turned} degrees");
    }
}

#[test]
fn springs_bend_and_every_model_has_a_film() {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(Path::new(ROOT).join("models")).unwrap() {
        let name = entry.unwrap().file_name().to_str().unwrap().to_owned();
        done(folder.path(), &["view", &model(&name), "--svg", "-o", "film.svg"]);
        let svg = fs::read_to_string(folder.path().join("film.svg")).unwrap();
        assert!(svg.contains("<animate") && !svg.contains("NaN") && !svg.contains("inf"), "{name}");
        assert!(elements(&svg) > 5, "{name}");
        if name == "slider_crank" {
            assert!(svg.contains("attributeName=\"d\""), "its spring");
        }
    }
}

#[test]
fn a_film_in_pictures_has_one_for_each_moment() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("four_bar"); // five seconds
    done(folder, &["view", &scene, "--frames", "film", "--fps", "2", "--speed", "2", "--width", "300"]);
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder.join("film")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len(), 6);
    let pictures: Vec<Pixmap> =
        files.iter().map(|file| Pixmap::decode_png(&fs::read(file).unwrap()).unwrap()).collect();
    assert!(pictures.iter().all(|picture| picture.width() == 300 && picture.height() == pictures[0].height()));
    assert!(pictures.windows(2).all(|pair| pair[0].data() != pair[1].data()), "every picture is another");
    let again = ["view", &scene, "--frames", "film", "--fps", "1", "--speed", "2"];
    let output = cotree(folder, &again);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("longer film"), "{}", stderr(&output));
    for (arguments, words) in [
        (&["--frames", "other", "--fps", "0"][..], "must be positive"),
        (&["--frames", "other", "--fps", "1e9"], "too long"),
        (&["--fps", "3"], "--frames"),
        (&["--svg", "--frames", "other"], "cannot be used"),
    ] {
        let output = cotree(folder, &[&["view", &scene], arguments].concat());
        assert_ne!(code(&output), 0, "{arguments:?}");
        assert!(stderr(&output).contains(words), "{arguments:?}: {}", stderr(&output));
    }
    assert!(!folder.join("other").exists());
}

#[test]
fn traces_are_those_of_the_run_in_csv_and_in_millimetres_for_cad() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("four_bar");
    done(folder, &["trace", &scene, "-o", "curve.csv"]);
    done(folder, &["simulate", &scene, "-o", "run.csv"]);
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let ((heads, rows), (all, run)) = (table(&read("curve.csv")), table(&read("run.csv")));
    assert_eq!(heads, ["time", "coupler.tracer.x", "coupler.tracer.y"]);
    for (place, head) in heads.iter().enumerate() {
        let column = all.iter().position(|name| name == head).unwrap();
        assert!(rows.iter().zip(&run).all(|(row, of_run)| row[place].to_bits() == of_run[column].to_bits()), "{head}");
    }
    done(folder, &["trace", &scene, "rocker.pin", "coupler.tracer", "coupler.tracer", "-o", "curves.dxf"]);
    let found = entities(&read("curves.dxf"));
    let layers: Vec<&str> =
        found.iter().filter(|(kind, ..)| kind == "POLYLINE").map(|(_, layer, _)| layer.as_str()).collect();
    assert_eq!(layers, ["ROCKER_PIN", "COUPLER_TRACER"]);
    let vertices = found.iter().filter(|(kind, layer, _)| kind == "VERTEX" && layer == "COUPLER_TRACER");
    let places: Vec<[f64; 2]> = vertices.map(|(.., places)| places[0]).collect();
    assert_eq!(places.len(), rows.len());
    for (place, row) in places.iter().zip(&rows) {
        assert!((place[0] - 1e3 * row[1]).abs() < 1e-6 && (place[1] - 1e3 * row[2]).abs() < 1e-6, "{place:?} {row:?}");
    }
    for (file, said) in [("a.csv", "rows of `coupler.tracer`"), ("a.dxf", "the curves of `coupler.tracer`")] {
        let output = cotree(folder, &["trace", &scene, "-o", file]);
        assert!(stderr(&output).contains(&format!("wrote {file}: ")) && stderr(&output).contains(said), "{output:?}");
    }
    assert_eq!(stderr(&cotree(folder, &["trace", &scene])), "");
    let output = cotree(folder, &["trace", &scene, "coupler.traser"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("did you mean `coupler.tracer`?"), "{}", stderr(&output));
}

/// The stop of the slider stands where its limit is, a block's half length further on; the scale is that of the crank, 0.2 m.
#[test]
fn stops_stand_where_limits_are() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, &["show", &model("end_stop"), "--drawing", "stop.svg"]);
    let svg = fs::read_to_string(folder.join("stop.svg")).unwrap();
    let value = |element: &str, name: &str| -> f64 {
        let rest = element.split_once(&format!(" {name}=\"")).unwrap().1;
        rest.split('"').next().unwrap().parse().unwrap()
    };
    let pins: Vec<[f64; 3]> = svg
        .lines()
        .filter(|line| line.contains("<circle") && line.contains("stroke-width=\"1.7\""))
        .map(|line| ["cx", "cy", "r"].map(|name| value(line, name)))
        .collect();
    let [pivot, outer, ..] = pins[..] else { panic!("{pins:?}") };
    let scale = (pivot[0] - outer[0]).hypot(pivot[1] - outer[1]) / 0.2;
    let upright = |line: &&str| line.contains("<line") && (value(line, "x1") - value(line, "x2")).abs() < 1e-9;
    let stops: Vec<f64> = svg.lines().filter(upright).map(|line| value(line, "x1")).collect();
    let expected = pivot[0] + 0.66 * scale + 3.7 * pivot[2] / 0.85;
    assert!(stops.len() == 1 && (stops[0] - expected).abs() < 0.1, "{stops:?} instead of {expected}");
}

/// A page takes a stop away when a parameter is changed with which it would stand elsewhere; only where there is something of that kind it has such data.
#[test]
fn pages_know_what_stops_stand_on() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let geometry = |name: &str| -> serde_json::Value {
        done(folder, &["view", &model(name), "-o", "page.html"]);
        let page = fs::read_to_string(folder.join("page.html")).unwrap();
        let data = page.split_once("id=\"model\">").unwrap().1.split("</script>").next().unwrap();
        serde_json::from_str::<serde_json::Value>(data).unwrap()["geometry"].clone()
    };
    let stop = geometry("end_stop");
    assert_eq!(stop["stops"][0]["needs"], serde_json::json!(["restitution", "travel"]));
    assert_eq!(stop["held"][0]["while"], serde_json::json!([["guide.mode", 1.0]]));
    assert_eq!(stop["held"][0]["impulse"], "guide.impulse");
    let other = geometry("four_bar");
    assert!(other.get("stops").is_none() && other.get("held").is_none());
}

/// Times at which an element is seen, as shares of the film.
fn seen(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let of_element = |element: &str| {
        let list = |name: &str| -> Vec<String> {
            let rest = element.split_once(&format!("{name}=\"")).unwrap().1;
            rest.split('"').next().unwrap().split(';').map(str::to_owned).collect()
        };
        let times: Vec<f64> = list("keyTimes").iter().map(|time| time.parse().unwrap()).chain([1.0]).collect();
        let values = list("values").into_iter().enumerate().filter(|(_, value)| value == "visible");
        values.map(|(place, _)| [times[place], times[place + 1]]).collect()
    };
    svg.split("<animate attributeName=\"visibility\"").skip(1).map(of_element).collect()
}

/// A star where the slider strikes, by the log of the command; a ring from when on it stays there; both are explained.
#[test]
fn a_film_shows_impacts_and_what_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("end_stop");
    done(folder, &["view", &scene, "-o", "film.svg"]);
    done(folder, &["simulate", &scene, "--log", "log.csv", "-o", "run.csv"]);
    let log = fs::read_to_string(folder.join("log.csv")).unwrap();
    let impacts: Vec<f64> = log
        .lines()
        .filter(|line| line.contains(",impact,"))
        .map(|line| line.split(',').next().unwrap().parse().unwrap())
        .collect();
    let svg = fs::read_to_string(folder.join("film.svg")).unwrap();
    let [stars, rings] = &seen(&svg)[..] else { panic!("{svg}") };
    let near = |share: f64, time: f64| (3.0 * share - time).abs() < 0.03;
    assert!(near(stars[0][0], impacts[0]) && near(stars[1][0], impacts[1]), "{stars:?} {impacts:?}");
    assert!(near(stars[0][1], impacts[0] + 0.15), "a star goes out: {stars:?}");
    assert!(rings.len() == 1 && near(rings[0][0], *impacts.last().unwrap()) && rings[0][1] == 1.0, "{rings:?}");
    for word in [">closed<", ">strikes<", ">guide.max<"] {
        assert!(svg.contains(word), "{word} is missing");
    }
    assert!(!svg.contains(">sticks<"), "nothing sticks");
    done(folder, &["view", &scene, "--frames", "frames", "--fps", "5", "--width", "400"]);
    done(folder, &["view", &model("four_bar"), "-o", "other.svg"]);
    let other = fs::read_to_string(folder.join("other.svg")).unwrap();
    assert!(!other.contains("visibility") && !other.contains("closed"), "nothing there has modes");
}

/// A block sticks to its belt and slips: the ring follows the variable of the run.
#[test]
fn a_film_shows_what_sticks() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = model("stick_slip");
    done(folder, &["view", &scene, "-o", "film.svg"]);
    let svg = fs::read_to_string(folder.join("film.svg")).unwrap();
    assert!(svg.contains("stroke-dasharray") && svg.contains(">sticks<") && !svg.contains(">strikes<"));
    done(folder, &["simulate", &scene, "-o", "run.csv"]);
    let (heads, rows) = table(&fs::read_to_string(folder.join("run.csv")).unwrap());
    let sliding = heads.iter().position(|head| head == "rubbing.sliding").unwrap();
    let [rings] = &seen(&svg)[..] else { panic!("{svg}") };
    // Not beside a change, where the film has its own samples.
    let inner = rows.windows(7).filter(|part| part.iter().all(|row| row[sliding] == part[3][sliding]));
    let mut compared = 0;
    for row in inner.map(|part| &part[3]) {
        let share = row[0] / 5.0;
        let is_seen = rings.iter().any(|[from, to]| (*from..*to).contains(&share));
        assert_eq!(is_seen, row[sliding] == 0.0, "{row:?} {rings:?}");
        compared += 1;
    }
    assert!(compared > 300, "{compared}");
}
