//! Colours of bodies that people with any kind of colour vision can tell apart: Machado, Oliveira, Fernandes, "A physiologically-based model
//! for simulation of color vision deficiency", IEEE Trans. Vis. Comput. Graph. 15(6), 2009, at full severity; differences in CIELAB.

const STYLE: &str = include_str!("../../crates/page/src/page/page.css");

type Matrix = [[f64; 3]; 3];

const VISIONS: [(&str, Matrix); 4] = [
    ("all three", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ("no red", [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    ("no green", [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    ("no blue", [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
];

fn times(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
}

fn linear(colour: &str) -> [f64; 3] {
    [1, 3, 5].map(|start| {
        let value = f64::from(u8::from_str_radix(&colour[start..start + 2], 16).unwrap()) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    })
}

fn lab(rgb: [f64; 3]) -> [f64; 3] {
    const XYZ: Matrix = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    let bent = |t: f64| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let [x, y, z] = times(&XYZ, rgb.map(|value| value.clamp(0.0, 1.0)));
    let [x, y, z] = [bent(x / 0.95047), bent(y), bent(z / 1.08883)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The colours of the bodies in the light scheme and in both places of the dark one.
fn schemes() -> Vec<Vec<String>> {
    let all: Vec<String> = STYLE
        .split("--e")
        .skip(1)
        .filter(|rest| rest[1..].starts_with(":#"))
        .map(|rest| rest[2..9].to_owned())
        .collect();
    assert_eq!(all.len(), 24);
    all.chunks(8).map(<[String]>::to_vec).collect()
}

#[test]
fn bodies_differ_for_every_kind_of_colour_vision() {
    let schemes = schemes();
    assert_eq!(schemes[1], schemes[2], "the dark scheme is the same however it is chosen");
    for colours in &schemes {
        for (vision, matrix) in &VISIONS {
            let seen: Vec<[f64; 3]> = colours.iter().map(|colour| lab(times(matrix, linear(colour)))).collect();
            for (first, a) in seen.iter().enumerate() {
                for (second, b) in seen.iter().enumerate().take(first) {
                    let difference = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    // Ten is easily seen side by side; most mechanisms have at most four bodies.
                    let least = if first < 4 { 30.0 } else { 20.0 };
                    assert!(
                        difference > least,
                        "{} and {} differ by {difference:.1} for {vision}",
                        colours[second],
                        colours[first]
                    );
                }
            }
        }
    }
}
