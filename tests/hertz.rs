//! 1 Hz is one turn a second to some and one radian a second to others: an angle that is made of it, without a factor that says which, is refused.

use cotree::scene::Scene;

fn scene(parameters: &str, angle: &str, start: &str) -> String {
    format!(
        "name = \"h\"\n[parameters]\n{parameters}\n[bodies.b]\nmass = 1\ninertia = 1\n[joints.p]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\n{}{start}",
        if angle.is_empty() { String::new() } else { format!("[drivers.d]\njoint = \"p\"\nangle = \"{angle}\"\n") }
    )
}

#[test]
fn angles_of_hertz_without_a_factor_are_refused() {
    let own = "w = \"10 Hz\"\nphase = \"1 rad\"\nturn = \"1 rev\"\ntwice = \"w\"\nclear = \"2*pi*w\"\nrate = \"3 1/s\"\nlong = { value = 2, unit = \"kHz\" }";
    let refused = [
        "w*t",
        "phase + w*t",
        "w*t + phase",
        "-w*t",
        "twice*t",
        "sin(w*t)",
        "long*t",
        "w*w*t*t",
        "2[Hz]*t",
        "2[kHz]*t",
    ];
    for angle in refused {
        let faults = Scene::from_toml(&scene(own, angle, "")).and_then(|scene| scene.resolve()).expect_err(angle);
        assert!(
            faults.to_string().contains("but `Hz` does not say whether of turns or of radians"),
            "{angle}: {faults}"
        );
    }
    let taken = [
        "2*pi*w*t",
        "2*pi*2[Hz]*t",
        "phase*w*t",
        "turn*w*t",
        "clear*t",
        "phase + 2*pi*w*t",
        "sin(2*pi*w*t)",
        "rate*t",
        "0.1*exp(-w*t)",
        "w/twice",
        "sin(clear*t)",
    ];
    for angle in taken {
        if let Err(faults) = Scene::from_toml(&scene(own, angle, "")).and_then(|scene| scene.resolve()) {
            panic!("{angle}: {faults}");
        }
    }
    let start = "[initial]\n\"p.omega\" = \"w\"\n";
    let faults = Scene::from_toml(&scene(own, "", start)).and_then(|scene| scene.resolve()).expect_err("open");
    assert!(faults.to_string().contains("but `Hz` does not say whether of turns or of radians"), "{faults}");
    let clear = "[initial]\n\"p.omega\" = \"2*pi*w\"\n";
    assert!(Scene::from_toml(&scene(own, "", clear)).and_then(|scene| scene.resolve()).is_ok());
}
