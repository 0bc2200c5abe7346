//! Which elements of a format its reader knows, level by level. What it reads and what has no effect on the motion is listed; everything else may act, and is
//! reported so: a file is not the poorer for an element that nobody thought of.

use super::report::ImportReport;
use super::xml::{self, XmlElement};

/// What may stand in an element; words are separated by blanks.
pub struct Level {
    /// The element, or several that are alike.
    pub names: &'static str,
    /// Elements that are read, each with a level of its own unless nothing may stand in it.
    pub read: &'static str,
    /// Elements without effect on the motion, with everything in them.
    pub idle: &'static str,
    /// Elements that are without effect where they are zero, false or empty.
    pub off: &'static str,
    pub attributes: &'static str,
}

impl Level {
    pub const fn new(names: &'static str, read: &'static str) -> Self {
        Level { names, read, idle: "", off: "", attributes: "name" }
    }

    pub const fn idle(self, idle: &'static str) -> Self {
        Level { idle, ..self }
    }

    pub const fn off(self, off: &'static str) -> Self {
        Level { off, ..self }
    }

    pub const fn attributes(self, attributes: &'static str) -> Self {
        Level { attributes, ..self }
    }
}

/// Parts of file names of plugins that compute the physics, show it, or measure it.
const IDLE_PLUGINS: &[&str] = &[
    "physics-system",
    "scene-broadcaster",
    "user-commands",
    "sensors-system",
    "imu-system",
    "contact-system",
    "altimeter-system",
    "forcetorque-system",
    "joint-state-publisher",
    "pose-publisher",
    "odometry-publisher",
    "joint_state_publisher",
    "gazebo_ros_p3d",
    "gazebo_ros_camera",
    "gazebo_ros_imu",
    "gazebo_ros_laser",
    "gazebo_ros_ray_sensor",
];

fn has(words: &str, word: &str) -> bool {
    words.split_whitespace().any(|other| other == word)
}

/// Reports what an element has that its reader does not: as without effect, or as what may act.
pub fn check(element: &XmlElement, levels: &[Level], report: &mut ImportReport) {
    let level = levels.iter().find(|level| has(level.names, &element.name));
    let (read, idle, off, attributes) =
        level.map_or(("", "", "", "name"), |level| (level.read, level.idle, level.off, level.attributes));
    for attribute in &element.attributes {
        if !has(attributes, &attribute.name) && !attribute.name.starts_with("xmlns") {
            let line = attribute.place.line;
            report.acting(&format!("unknown attribute `{}`", attribute.name), line, &element.called());
        }
    }
    for child in &element.children {
        let name = child.name.as_str();
        if has(read, name) {
            check(child, levels, report);
        } else if has(idle, name) || name == "plugin" && measures(child) {
            report.idle(format!("<{name}>"));
        } else if !(has(off, name) && is_off(child)) {
            let what = if name == "plugin" { plugin(child) } else { format!("<{name}>") };
            report.acting(&what, child.place.line, &element.called());
        }
    }
}

/// True if an element is zero, false or empty, with everything in it.
fn is_off(element: &XmlElement) -> bool {
    let zero = |text: &str| xml::numbers(text).is_ok_and(|numbers| numbers.iter().all(|number| *number == 0.0));
    let text = element.text.trim();
    let mut values = element.attributes.iter().filter(|attribute| attribute.name == "value");
    (zero(text) || matches!(text, "false" | "inf" | "-1"))
        && values.all(|attribute| zero(&attribute.value))
        && element.children.iter().all(is_off)
}

fn measures(plugin: &XmlElement) -> bool {
    let file = plugin.attribute("filename").map(|file| file.value.to_lowercase()).unwrap_or_default();
    IDLE_PLUGINS.iter().any(|part| file.contains(part))
}

fn plugin(element: &XmlElement) -> String {
    let named = element.attribute("filename").or_else(|| element.attribute("name"));
    named.map_or_else(|| "<plugin>".to_owned(), |file| format!("plugin `{}`", file.value))
}
