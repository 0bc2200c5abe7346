//! `cotree assemblies`

use std::path::PathBuf;

use clap::Args;
use cotree::compile::compile_with_equations;
use cotree::formulate::assemblies::{Assemblies, CoordinateValue, assemblies};
use cotree::model::{Mechanism, Unit};
use cotree::scene::Scene;
use cotree::typeset::{counted, fixed};
use cotree_draw::pose::draw;

use super::failure::Failure;
use super::{MessageFormat, output};

/// Find the assembly modes of a mechanism, with lines to paste that choose each
///
/// The loops are closed from many starts. Coordinates that neither drivers nor known initial values give are held at the start of the scene; if its guesses lead to no configuration, at the first one
/// that is found.
#[derive(Args)]
#[command(after_help = "Example:\n  cotree assemblies four_bar.toml --drawings poses")]
pub struct AssembliesCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Number of starts of the search
    #[arg(long, value_name = "NUMBER", default_value_t = 200)]
    starts: usize,
    /// Folder for a drawing of each, `1.png`, `2.png`, ...
    #[arg(long, value_name = "FOLDER")]
    drawings: Option<PathBuf>,
}

impl AssembliesCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let scene = output::load(&self.scene)?;
        let resolved = scene.resolve()?;
        let found =
            assemblies(&resolved.mechanism, self.starts).map_err(|errors| resolved.refused(&scene.source, errors))?;
        output::print(&text(&found, &resolved.mechanism, self.starts))?;
        let Some(folder) = self.drawings.as_ref().filter(|_| !found.is_continuous()) else { return Ok(()) };
        std::fs::create_dir_all(folder).map_err(|error| Failure::file("make", folder, error))?;
        for (index, pose) in found.poses.iter().enumerate() {
            let posed = posed(scene.clone(), found.held.iter().chain(pose));
            let picture = draw(&mut compile_with_equations(&posed)?.1).svg();
            let path = folder.join(format!("{}.png", index + 1));
            output::picture(&path, &picture, "the drawing of this assembly", format)?;
        }
        Ok(())
    }
}

/// The scene in one of its assemblies.
fn posed<'v>(mut scene: Scene, pose: impl Iterator<Item = &'v CoordinateValue>) -> Scene {
    scene.initial.retain(|initial| initial.known);
    for value in pose {
        if scene.initial.iter().all(|known| known.variable.text != value.name) {
            scene = scene.guess(&value.name, value.value);
        }
    }
    scene
}

fn text(found: &Assemblies, mechanism: &Mechanism, starts: usize) -> String {
    let shown = |value: &CoordinateValue| {
        let unit = mechanism.units.of(&if value.angular { Unit::angle() } else { Unit::length() });
        format!("{} {}", fixed(value.value / unit.factor), unit.name)
    };
    let held: Vec<String> = found.held.iter().map(|held| format!("`{}` at {}", held.name, shown(held))).collect();
    let with = if held.is_empty() { String::new() } else { format!(" with {}", held.join(", ")) };
    if found.is_continuous() {
        return format!(
            "{}: more than {} configurations{with}: they are not isolated\n",
            mechanism.name,
            found.poses.len() - 1
        );
    }
    let ways = counted(found.poses.len(), "assembly mode");
    let given = |name: &str| {
        let known = mechanism
            .initial
            .iter()
            .filter(|initial| initial.known)
            .map(|initial| mechanism.variable_name(initial.variable));
        found.held.iter().any(|held| held.name == name) || known.into_iter().any(|known| known == name)
    };
    let mut text = format!("{}: the loops close in {ways}{with} (from {starts} starts)\n", mechanism.name);
    if !found.is_own {
        text += "the guesses of the scene lead to none of them\n";
    }
    if found.loose > 0 {
        text += &format!(
            "{} led to configurations that can move although all degrees of freedom are fixed, such as coincident bars: they are not isolated and not listed\n",
            counted(found.loose, "start")
        );
    }
    for (index, (pose, times)) in found.poses.iter().zip(&found.found).enumerate() {
        let own = if index == 0 && found.is_own { ", the one of the scene" } else { "" };
        text += &format!("\n# {} (found {times} times{own})\n[initial]\n", index + 1);
        for value in pose.iter().filter(|value| !given(&value.name)) {
            text += &format!("\"{}\" = {{ guess = \"{}\" }}\n", value.name, shown(value));
        }
    }
    text
}
