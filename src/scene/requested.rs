//! What is asked of a scene.

/// Which outputs are computed. They are a question: the mechanism is the same whatever is asked of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Requested {
    /// The outputs of the scene.
    #[default]
    Own,
    /// These variables, signals and outputs of the scene, and no others.
    These(Vec<String>),
    /// The outputs of the scene, and then these variables and signals, unless they are parameters or inputs, which every program has.
    Also(Vec<String>),
    /// The outputs of the scene, and then every variable that it has.
    Everything,
}

impl Requested {
    /// These variables, signals and outputs of the scene, and no others.
    pub fn these<N: Into<String>>(names: impl IntoIterator<Item = N>) -> Requested {
        Requested::These(names.into_iter().map(Into::into).collect())
    }

    /// The outputs of the scene, and then these variables and signals.
    pub fn also<N: Into<String>>(names: impl IntoIterator<Item = N>) -> Requested {
        Requested::Also(names.into_iter().map(Into::into).collect())
    }
}
