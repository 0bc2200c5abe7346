//! `cotree new`

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use cotree::diagnostic::suggest;
use cotree::mechanism::identifier;

use super::failure::Failure;
use super::output;

const TEMPLATE: &str = include_str!("template.toml");

/// The models that can be started from.
const MODELS: &[(&str, &str)] = &[
    ("andrews", include_str!("../../../models/andrews/scene.toml")),
    ("bench_slider_crank", include_str!("../../../models/bench_slider_crank/scene.toml")),
    ("cam_follower", include_str!("../../../models/cam_follower/scene.toml")),
    ("cam_oscillating", include_str!("../../../models/cam_oscillating/scene.toml")),
    ("cart_pole", include_str!("../../../models/cart_pole/scene.toml")),
    ("chebyshev", include_str!("../../../models/chebyshev/scene.toml")),
    ("double_pendulum", include_str!("../../../models/double_pendulum/scene.toml")),
    ("double_wishbone", include_str!("../../../models/double_wishbone/scene.toml")),
    ("engine", include_str!("../../../models/engine/scene.toml")),
    ("excavator", include_str!("../../../models/excavator/scene.toml")),
    ("five_bar_robot", include_str!("../../../models/five_bar_robot/scene.toml")),
    ("four_bar", include_str!("../../../models/four_bar/scene.toml")),
    ("friction", include_str!("../../../models/friction/scene.toml")),
    ("gas_strut", include_str!("../../../models/gas_strut/scene.toml")),
    ("gear_train", include_str!("../../../models/gear_train/scene.toml")),
    ("geneva_slot", include_str!("../../../models/geneva_slot/scene.toml")),
    ("jansen", include_str!("../../../models/jansen/scene.toml")),
    ("klann", include_str!("../../../models/klann/scene.toml")),
    ("landing_gear", include_str!("../../../models/landing_gear/scene.toml")),
    ("metronome", include_str!("../../../models/metronome/scene.toml")),
    ("peaucellier", include_str!("../../../models/peaucellier/scene.toml")),
    ("pendulum", include_str!("../../../models/pendulum/scene.toml")),
    ("planetary_gear", include_str!("../../../models/planetary_gear/scene.toml")),
    ("quick_return", include_str!("../../../models/quick_return/scene.toml")),
    ("rack_and_pinion", include_str!("../../../models/rack_and_pinion/scene.toml")),
    ("rolling_disc", include_str!("../../../models/rolling_disc/scene.toml")),
    ("scotch_yoke", include_str!("../../../models/scotch_yoke/scene.toml")),
    ("screw_lift", include_str!("../../../models/screw_lift/scene.toml")),
    ("slider_crank", include_str!("../../../models/slider_crank/scene.toml")),
    ("stephenson_six_bar", include_str!("../../../models/stephenson_six_bar/scene.toml")),
    ("toggle_press", include_str!("../../../models/toggle_press/scene.toml")),
    ("trammel", include_str!("../../../models/trammel/scene.toml")),
    ("vibration", include_str!("../../../models/vibration/scene.toml")),
    ("vibration_isolator", include_str!("../../../models/vibration_isolator/scene.toml")),
    ("watt_six_bar", include_str!("../../../models/watt_six_bar/scene.toml")),
    ("whitworth", include_str!("../../../models/whitworth/scene.toml")),
    ("wiper", include_str!("../../../models/wiper/scene.toml")),
];

/// The further files that models are made of.
const FILES: &[(&str, &str, &str)] = &[
    ("cam_follower", "lift.csv", include_str!("../../../models/cam_follower/lift.csv")),
    ("double_wishbone", "corner.toml", include_str!("../../../models/double_wishbone/corner.toml")),
];

/// Write a commented scene to start from: a slider-crank that works as it is
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree new my_mechanism                    writes my_mechanism.toml\n  \
                  cotree new my_mechanism --from four_bar    begins with a model instead of the commented slider-crank")]
pub struct New {
    /// Name of the mechanism; the file gets the ending `.toml`
    name: PathBuf,
    /// Begin with one of the models
    #[arg(long, value_name = "MODEL")]
    from: Option<String>,
}

impl New {
    pub fn run(self) -> Result<(), Failure> {
        let text = match &self.from {
            None => TEMPLATE.to_string(),
            Some(name) => model(name)?,
        };
        let path = if self.name.extension().is_some_and(|end| end == "toml") {
            self.name
        } else {
            let mut name = self.name.into_os_string();
            name.push(".toml");
            name.into()
        };
        let mut files = vec![(path.clone(), scene(&text, &path))];
        let further = FILES.iter().filter(|(of, ..)| self.from.as_deref() == Some(of));
        files.extend(further.map(|(_, name, text)| (path.with_file_name(name), (*text).to_owned())));
        create_all(&files)?;
        let names: String = files.iter().map(|(path, _)| format!("{}\n", path.display())).collect();
        output::print(&format!("{names}Next: cotree check {}\n", path.display()))
    }
}

/// Writes files that must not exist: all of them or none.
fn create_all(files: &[(PathBuf, String)]) -> Result<(), Failure> {
    for (index, (path, text)) in files.iter().enumerate() {
        create(path, text).map_err(|error| {
            for (written, _) in &files[..index] {
                let _ = std::fs::remove_file(written); // the reason is told already
            }
            match error.kind() {
                std::io::ErrorKind::AlreadyExists => {
                    Failure::Usage(format!("`{}` exists already; choose another name", path.display()))
                }
                _ => Failure::file("write", path, error),
            }
        })?;
    }
    Ok(())
}

/// The scene of a model, without the place of its schema, which is another from elsewhere.
fn model(name: &str) -> Result<String, Failure> {
    let found = MODELS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let text = found.ok_or_else(|| {
        let known = suggest::known(name, MODELS.iter().map(|(known, _)| *known));
        Failure::Usage(format!("there is no model `{name}`; {known}"))
    })?;
    Ok(text.lines().filter(|line| !line.starts_with("#:schema")).map(|line| format!("{line}\n")).collect())
}

/// A scene under the file's own name.
fn scene(text: &str, path: &Path) -> String {
    let stem = path.file_stem().map(|stem| identifier(&stem.to_string_lossy())).unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("name")).unwrap_or_default();
    let (key, _) = line.split_once('=').unwrap_or((line, ""));
    text.replacen(line, &format!("{key}= \"{stem}\""), 1)
}

/// Writes a file that must not exist; removed again if it cannot be written whole.
fn create(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(text.as_bytes()).inspect_err(|_| {
        let _ = std::fs::remove_file(path); // the reason is told already
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::scene::Scene;

    #[test]
    fn the_template_is_a_scene_without_faults() {
        let text = scene(TEMPLATE, Path::new("folder/my mechanism.toml"));
        let resolved = Scene::from_toml(&text).unwrap().resolve().unwrap();
        assert_eq!(resolved.mechanism.name, "my_mechanism");
        assert_eq!(resolved.warnings, []);
    }

    #[test]
    fn every_model_can_be_started_from() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let mut models: Vec<String> =
            folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        models.sort();
        assert_eq!(MODELS.iter().map(|(name, _)| *name).collect::<Vec<_>>(), models);
        let place = std::env::temp_dir().join(format!("cotree_new_{}", std::process::id()));
        for name in models {
            let path = place.join(&name).join("mine.toml");
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            New { name: path.clone(), from: Some(name.clone()) }.run().unwrap();
            assert_eq!(Scene::read(&path).unwrap().resolve().unwrap().mechanism.name, "mine", "{name}");
            assert!(New { name: path, from: Some(name) }.run().is_err());
        }
        std::fs::remove_dir_all(place).unwrap();
        assert!(model("fourbar").is_err());
    }

    #[test]
    fn what_the_template_comments_out_works_too() {
        let text: String = TEMPLATE.lines().map(|line| format!("{}\n", uncommented(line))).collect();
        let resolved = Scene::from_toml(&text).unwrap().resolve().unwrap();
        assert_eq!(resolved.mechanism.loads.len(), 2);
    }

    /// A line of TOML that is commented out; prose stays a comment.
    fn uncommented(line: &str) -> &str {
        line.strip_prefix("# ").filter(|rest| rest.starts_with('[') || rest.contains(" = ")).unwrap_or(line)
    }
}
