//! The models that a new scene can start from, as texts: a program that is alone on its machine has them too.

/// Each model by its name.
pub const MODELS: &[(&str, &str)] = &[
    ("andrews", include_str!("../models/andrews/scene.toml")),
    ("bench_slider_crank", include_str!("../models/bench_slider_crank/scene.toml")),
    ("cam_follower", include_str!("../models/cam_follower/scene.toml")),
    ("cam_oscillating", include_str!("../models/cam_oscillating/scene.toml")),
    ("cart_pole", include_str!("../models/cart_pole/scene.toml")),
    ("chebyshev", include_str!("../models/chebyshev/scene.toml")),
    ("double_pendulum", include_str!("../models/double_pendulum/scene.toml")),
    ("double_wishbone", include_str!("../models/double_wishbone/scene.toml")),
    ("engine", include_str!("../models/engine/scene.toml")),
    ("excavator", include_str!("../models/excavator/scene.toml")),
    ("five_bar_robot", include_str!("../models/five_bar_robot/scene.toml")),
    ("four_bar", include_str!("../models/four_bar/scene.toml")),
    ("friction", include_str!("../models/friction/scene.toml")),
    ("gas_strut", include_str!("../models/gas_strut/scene.toml")),
    ("gear_train", include_str!("../models/gear_train/scene.toml")),
    ("geneva_slot", include_str!("../models/geneva_slot/scene.toml")),
    ("jansen", include_str!("../models/jansen/scene.toml")),
    ("klann", include_str!("../models/klann/scene.toml")),
    ("landing_gear", include_str!("../models/landing_gear/scene.toml")),
    ("metronome", include_str!("../models/metronome/scene.toml")),
    ("peaucellier", include_str!("../models/peaucellier/scene.toml")),
    ("pendulum", include_str!("../models/pendulum/scene.toml")),
    ("planetary_gear", include_str!("../models/planetary_gear/scene.toml")),
    ("quick_return", include_str!("../models/quick_return/scene.toml")),
    ("rack_and_pinion", include_str!("../models/rack_and_pinion/scene.toml")),
    ("rolling_disc", include_str!("../models/rolling_disc/scene.toml")),
    ("scotch_yoke", include_str!("../models/scotch_yoke/scene.toml")),
    ("screw_lift", include_str!("../models/screw_lift/scene.toml")),
    ("slider_crank", include_str!("../models/slider_crank/scene.toml")),
    ("stephenson_six_bar", include_str!("../models/stephenson_six_bar/scene.toml")),
    ("toggle_press", include_str!("../models/toggle_press/scene.toml")),
    ("trammel", include_str!("../models/trammel/scene.toml")),
    ("vibration", include_str!("../models/vibration/scene.toml")),
    ("vibration_isolator", include_str!("../models/vibration_isolator/scene.toml")),
    ("watt_six_bar", include_str!("../models/watt_six_bar/scene.toml")),
    ("whitworth", include_str!("../models/whitworth/scene.toml")),
    ("wiper", include_str!("../models/wiper/scene.toml")),
];

/// The further files that models are made of: the model, the file and its text.
pub const FILES: &[(&str, &str, &str)] = &[
    ("cam_follower", "lift.csv", include_str!("../models/cam_follower/lift.csv")),
    ("double_wishbone", "corner.toml", include_str!("../models/double_wishbone/corner.toml")),
];
