//! What has happened in a run, and when: events of the scene, and what is held on one side only.

use cotree_fmu::instance::Happening;
use cotree_fmu::model::Model;

/// Something that has happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Logged {
    /// \[s\]
    pub time: f64,
    /// An event of the scene, or a limit, contact or rope, such as `guide.max`.
    pub name: String,
    pub what: What,
}

/// What has happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// The comparison of an event has begun to hold.
    Event,
    /// An impact, with its impulse: N s, or N m s of an angle.
    Impact { impulse: f64, angular: bool },
    /// It stays closed from now on.
    Closes,
    /// It is open from now on.
    Opens,
}

impl What {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            What::Event => "event",
            What::Impact { .. } => "impact",
            What::Closes => "closes",
            What::Opens => "opens",
        }
    }
}

impl Logged {
    /// What there is to say of something that has happened at an instant.
    pub(super) fn all(model: &Model, own: &Happening) -> Vec<Logged> {
        let program = model.program();
        let entry = |name: &str, what| Logged { time: own.time(), name: name.to_owned(), what };
        let events = own.due.iter().filter_map(|&index| program.instants.events.get(index));
        let mut all: Vec<Logged> = events.map(|event| entry(&event.name, What::Event)).collect();
        let [before, after] = own.closed(model);
        for (index, contact) in program.instants.contacts().iter().enumerate() {
            if own.hit.contains(&index) {
                let impulse = own.after.parameters()[contact.closed as usize + 1];
                let angular = program.constraints[contact.constraint as usize].angular;
                all.push(entry(&contact.name, What::Impact { impulse, angular }));
            }
            if before[index] != after[index] {
                all.push(entry(&contact.name, if after[index] { What::Closes } else { What::Opens }));
            }
        }
        all
    }
}
