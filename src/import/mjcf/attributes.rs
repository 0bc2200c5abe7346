//! In which class each attribute of MJCF is: read exactly, replaced by an exact law, without effect on the motion, or refused because it acts.

/// How deep elements are nested in one that is idle or refused as a whole.
pub const DEEPEST: usize = 6;

/// What becomes of an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeClass {
    Exact,
    /// It says how soft MuJoCo holds what cotree holds exactly.
    Approximated,
    Idle,
    /// It acts and has no counterpart: refused, unless the user leaves it out.
    Refused,
}

/// Elements with their attributes that are exact, approximated, idle, refused.
type Row = (&'static str, [&'static str; 4]);

const SOFT_JOINT: &str = "solimpfriction solimplimit solreffriction solreflimit margin";

const ROWS: &[Row] = &[
    ("mujoco", ["", "", "model", ""]),
    (
        "compiler",
        [
            "angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq inertiafromgeom inertiagrouprange settotalmass",
            "",
            "assetdir conflict discardvisual fitaabb fusestatic meshdir passthrough savecanonical savecompiled saveinertial strippath texturedir usethread",
            "alignfree",
        ],
    ),
    (
        "compiler/lengthrange",
        ["", "", "accel interval inttotal maxforce mode timeconst timestep tolrange useexisting uselimit", ""],
    ),
    (
        "option",
        [
            "gravity density viscosity wind",
            "o_friction o_margin o_solimp o_solref",
            "actuatorgroupdisable ccd_iterations ccd_tolerance cone impratio integrator iterations jacobian ls_iterations ls_tolerance magnetic \
             noslip_iterations noslip_tolerance sdf_initpoints sdf_iterations sleep_tolerance solver timestep tolerance apirate collision mpr_iterations mpr_tolerance",
            "",
        ],
    ),
    (
        "option/flag",
        [
            "actuation clampctrl contact damper equality frictionloss gravity limit passive spring constraint filterparent",
            "",
            "autoreset diagexact energy eulerdamp fwdinv invdiscrete ipc island midphase multiccd nativeccd override refsafe sensor sleep speculative \
             warmstart",
            "",
        ],
    ),
    ("default", ["class", "", "", ""]),
    (
        "body",
        ["name childclass gravcomp mocap pos quat axisangle euler xyaxes zaxis", "", "fuse simple sleep user", ""],
    ),
    ("frame", ["name childclass pos quat axisangle euler xyaxes zaxis", "", "", ""]),
    ("inertial", ["mass diaginertia fullinertia pos quat axisangle euler xyaxes zaxis", "", "", ""]),
    (
        "joint",
        [
            "name class type pos axis ref springref stiffness damping frictionloss armature range limited actuatorfrclimited actuatorfrcrange",
            SOFT_JOINT,
            "group user",
            "actuatorgravcomp springdamper springyield",
        ],
    ),
    ("freejoint", ["name", "", "group", "align"]),
    (
        "geom",
        [
            "name class type pos quat axisangle euler xyaxes zaxis fromto size mass density shellinertia mesh hfield group contype conaffinity condim friction priority",
            "solimp solmix solref margin gap",
            "castshadow fitscale material rgba user fluidcoef",
            "adhesion surfacevel fluidshape",
        ],
    ),
    (
        "site",
        ["name class pos quat axisangle euler xyaxes zaxis fromto", "", "group material mesh rgba size type user", ""],
    ),
    (
        "contact/pair",
        ["name class geom1 geom2 condim friction", "gap margin solimp solref solreffriction", "", "adhesion"],
    ),
    ("contact/exclude", ["name body1 body2", "", "", ""]),
    ("equality/connect", ["name class active anchor body1 body2 site1 site2", "solimp solref", "", ""]),
    (
        "equality/weld",
        ["name class active anchor body1 body2 site1 site2 relpose", "solimp solref torquescale", "", ""],
    ),
    ("equality/joint", ["name class active joint1 joint2 polycoef", "solimp solref", "", ""]),
    ("equality/tendon", ["name class active tendon1 tendon2 polycoef", "solimp solref", "", ""]),
    (
        "tendon/spatial",
        [
            "name class stiffness damping springlength range limited",
            "margin solimpfriction solimplimit solreffriction solreflimit",
            "group material rgba user width",
            "armature frictionloss springyield actuatorfrclimited actuatorfrcrange",
        ],
    ),
    (
        "tendon/fixed",
        [
            "name class stiffness damping springlength",
            "margin solimpfriction solimplimit solreffriction solreflimit",
            "group user",
            "armature frictionloss springyield range limited actuatorfrclimited actuatorfrcrange",
        ],
    ),
    ("spatial/site", ["site", "", "", ""]),
    ("spatial/geom", ["geom sidesite", "", "", ""]),
    ("fixed/joint", ["joint coef", "", "", ""]),
    (
        "actuator/general",
        [
            "name class joint jointinparent tendon gear ctrllimited ctrlrange forcelimited forcerange actlimited actrange dyntype dynprm gaintype gainprm biastype \
             biasprm inheritrange",
            "",
            "group lengthrange user actearly nsample interp",
            "actdim armature body cranklength cranksite damping delay ffrange input refsite site slidersite velrange",
        ],
    ),
    (
        "actuator/motor",
        [
            "name class joint jointinparent tendon gear ctrllimited ctrlrange forcelimited forcerange",
            "",
            "group lengthrange user nsample interp",
            "armature cranklength cranksite damping delay refsite site slidersite",
        ],
    ),
    (
        "actuator/position",
        [
            "name class joint jointinparent tendon gear ctrllimited ctrlrange forcelimited forcerange kp kv timeconst inheritrange",
            "",
            "group lengthrange user nsample interp",
            "armature cranklength cranksite damping dampratio delay refsite site slidersite",
        ],
    ),
    (
        "actuator/velocity",
        [
            "name class joint jointinparent tendon gear ctrllimited ctrlrange forcelimited forcerange kv",
            "",
            "group lengthrange user nsample interp",
            "armature cranklength cranksite damping delay refsite site slidersite",
        ],
    ),
    (
        "actuator/intvelocity",
        [
            "name class joint jointinparent tendon gear ctrllimited ctrlrange forcelimited forcerange actlimited actrange kp kv inheritrange",
            "",
            "group lengthrange user nsample interp",
            "armature cranklength cranksite damping dampratio delay refsite site slidersite",
        ],
    ),
    (
        "actuator/damper",
        [
            "name class joint jointinparent tendon gear ctrlrange forcelimited forcerange kv",
            "",
            "group lengthrange user nsample interp",
            "armature cranklength cranksite damping delay refsite site slidersite",
        ],
    ),
    ("keyframe/key", ["name qpos qvel act ctrl", "", "mpos mquat plastic time", ""]),
    ("mujocoinclude", ["", "", "", ""]),
    ("include", ["file", "", "", ""]),
];

/// Elements below which nothing has an effect on the motion.
const IDLE: &[&str] = &[
    "visual",
    "statistic",
    "size",
    "sensor",
    "custom",
    "asset",
    "camera",
    "light",
    "texture",
    "material",
    "layer",
    "skin",
    "mesh",
];

/// Elements that act and have no counterpart, with everything in them.
pub const REFUSED: &[&str] = &[
    "attach",
    "composite",
    "flexcomp",
    "replicate",
    "plugin",
    "deformable",
    "extension",
    "flex",
    "flexstrain",
    "orientation",
    "pid",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "pulley",
    "edge",
    "elasticity",
    "pin",
];

/// Those of them that make bodies.
pub const GENERATED: &[&str] = &["attach", "composite", "flexcomp", "replicate"];

/// The key of an element under its parent.
fn key(parent: &str, name: &str) -> String {
    match (parent, name) {
        (_, "worldbody") => "body".to_owned(),
        (
            "compiler" | "option" | "contact" | "equality" | "tendon" | "actuator" | "spatial" | "fixed" | "keyframe",
            _,
        ) => {
            format!("{parent}/{name}")
        }
        _ => name.to_owned(),
    }
}

/// The rows that an element has; a default has those of all that it is a default of.
fn rows<'a>(parent: &'a str, name: &'a str) -> impl Iterator<Item = &'static Row> + 'a {
    let row_key = key(parent, name);
    ROWS.iter().filter(move |(key, _)| {
        let of_default = match (parent == "default", name) {
            (true, "equality" | "tendon") => key.starts_with(&format!("{name}/")),
            (true, "pair") => *key == "contact/pair",
            (true, _) => key.strip_prefix("actuator/") == Some(name),
            (false, _) => false,
        };
        *key == row_key || of_default
    })
}

/// Is an element known, with its own attributes or as one without?
pub fn knows(parent: &str, name: &str) -> bool {
    const SECTIONS: &[&str] =
        &["worldbody", "contact", "equality", "tendon", "actuator", "keyframe", "default", "flag", "lengthrange"];
    SECTIONS.contains(&name) || is_idle(parent, name) || REFUSED.contains(&name) || rows(parent, name).next().is_some()
}

/// Is it without effect, with everything in it?
pub fn is_idle(parent: &str, name: &str) -> bool {
    IDLE.contains(&name) && !matches!((parent, name), ("extension", _))
}

/// The class of an attribute of an element, whose names from the root lead to it; none if MuJoCo has no such attribute.
pub fn class_of(path: &[&str], attribute: &str) -> Option<AttributeClass> {
    // Below a body no element that counts here is deeper.
    let path = &path[path.len().saturating_sub(DEEPEST)..];
    let parents = path.iter().zip(path.iter().skip(1));
    if path.iter().any(|name| REFUSED.contains(name)) {
        return Some(AttributeClass::Refused);
    }
    if parents.clone().any(|(parent, name)| is_idle(parent, name)) {
        return Some(AttributeClass::Idle);
    }
    let name = path.last()?;
    let parent = path.len().checked_sub(2).map_or("", |index| path[index]);
    let classes = [AttributeClass::Exact, AttributeClass::Approximated, AttributeClass::Idle, AttributeClass::Refused];
    rows(parent, name).find_map(|(_, lists)| {
        let at = lists.iter().position(|list| list.split_whitespace().any(|word| word == attribute))?;
        Some(classes[at])
    })
}
