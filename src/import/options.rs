//! What a user decides about an import.

/// Which plane of the world, and its axes as those of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldPlane {
    Xy,
    Xz,
    Yz,
}

/// Which contacts are imported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactChoice {
    None,
    /// Planes of the world with spheres, ends of capsules and corners of boxes.
    #[default]
    Floor,
    /// Those, and spheres with spheres.
    All,
}

/// The options of `cotree import`.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// The plane, instead of the one that the hinges have.
    pub plane: Option<WorldPlane>,
    /// Joints that are held at their start value.
    pub lock: Vec<String>,
    /// The body whose subtree is imported, held as ground.
    pub root: Option<String>,
    /// Lets free and ball joints move in the plane only.
    pub in_plane: bool,
    /// What acts, but is left out; `all` is everything.
    pub leave_out: Vec<String>,
    /// The keyframe that the motion starts from, by its name or number.
    pub key: Option<String>,
    pub contacts: ContactChoice,
    /// Gravity of files without one, m/s2.
    pub gravity: Option<[f64; 2]>,
    pub dxf: DxfOptions,
}

impl ImportOptions {
    /// Is what has this name, or is of this kind, left out?
    pub fn leaves_out(&self, names: &[&str]) -> bool {
        self.leave_out.iter().any(|name| name == "all" || names.contains(&name.as_str()))
    }
}

/// The options for drawings.
#[derive(Clone, Debug, Default)]
pub struct DxfOptions {
    /// Metres of the drawing's unit, instead of the one it says.
    pub unit: Option<f64>,
    /// How far apart ends may be that are joined, metres.
    pub snap: Option<f64>,
    /// Places of pins on the ground, in the drawing's units.
    pub ground: Vec<[f64; 2]>,
    /// Roles of layers.
    pub layers: Vec<(String, String)>,
    /// kg/m of lines.
    pub line_density: Option<f64>,
    /// kg/m2 of closed outlines.
    pub plate: Option<f64>,
}
