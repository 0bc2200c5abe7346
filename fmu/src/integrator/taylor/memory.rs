//! What the series know from the steps before.

use serde::{Deserialize, Serialize};

use crate::events::Choices;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct TaylorMemory {
    /// Branches of laws that the next step begins on, where the last one has ended at a switch.
    pub branches: Choices,
    /// Did the last step begin the series at its end, and with the loops closed tightly? None if there is no series yet.
    pub series: Option<bool>,
    /// Steps since one was last compared with the tape of the accelerations.
    pub unseen: u32,
    /// True once arms could turn so far in a step that a singular pose was in it. The rest of the run is then taken as one at [`SIGHTED`](crate::singular::detect::SIGHTED).
    pub turns_far: bool,
}
