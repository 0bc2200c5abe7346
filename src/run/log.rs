//! What has happened in a run, and when: events of the scene, and what is held on one side only.

use cotree_fmu::instance::{Happening, Instance};
use cotree_fmu::model::Model;
use cotree_fmu::program::Role;

/// Something that has happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Logged {
    /// \[s\]
    pub time: f64,
    /// An event of the scene, a limit, contact or rope, such as `guide.max`, or what rubs, such as `guide.friction`.
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
    /// What rubs holds from now on.
    Sticks,
    /// What rubs slides from now on, or does not rub any more.
    Slips,
    /// What rubs slides the other way.
    Turns,
    /// A joint engages; its impulses follow as impacts. They take energy \[J\].
    Engages { lost: f64 },
    /// A joint is released.
    Releases,
}

impl What {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            What::Event => "event",
            What::Impact { .. } => "impact",
            What::Closes => "closes",
            What::Opens => "opens",
            What::Sticks => "sticks",
            What::Slips => "slips",
            What::Turns => "turns",
            What::Engages { .. } => "engages",
            What::Releases => "releases",
        }
    }
}

impl Logged {
    /// What has happened in an instance that records it, since this was last asked.
    pub fn taken(instance: &mut Instance) -> Vec<Logged> {
        let record = instance.take_record();
        record.iter().flat_map(|happening| Logged::all(instance.model(), happening)).collect()
    }

    /// What there is to say of something that has happened at an instant.
    fn all(model: &Model, happening: &Happening) -> Vec<Logged> {
        let program = model.program();
        let entry = |name: &str, what| Logged { time: happening.time(), name: name.to_owned(), what };
        let events = happening.due.iter().filter_map(|&index| program.instants.events.get(index));
        let events = events.filter(|event| event.is_of_scene());
        let mut all: Vec<Logged> = events.map(|event| entry(&event.name, What::Event)).collect();
        all.extend(Logged::engaging(model, happening));
        let ([before, after], [came, goes]) = (happening.closed(model), happening.directions(model));
        for (index, contact) in program.instants.contacts().iter().enumerate() {
            if happening.hit.contains(&index) {
                let impulse = happening.after.discrete()[contact.state.impulse as usize];
                let angular = program.constraints[contact.constraint as usize].is_angle();
                all.push(entry(&contact.name, What::Impact { impulse, angular }));
            }
            let rubs = contact.slip.is_some();
            let what = match (before[index], after[index]) {
                (false, true) => Some(if rubs { What::Sticks } else { What::Closes }),
                (true, false) => Some(if rubs { What::Slips } else { What::Opens }),
                _ => (came[index] * goes[index] < 0.0).then_some(What::Turns),
            };
            all.extend(what.map(|what| entry(&contact.name, what)));
        }
        all
    }

    /// Joints that engage and are released, with their impulses, and those along rates that an event has set.
    fn engaging(model: &Model, happening: &Happening) -> Vec<Logged> {
        let program = model.program();
        let mut all: Vec<Logged> = Vec::new();
        for (row, joins) in happening.joining(model) {
            let constraint = &program.constraints[row];
            let entry = |what| Logged { time: happening.time(), name: constraint.owner.clone(), what };
            let (Role::Engaging { impulse, .. } | Role::Set { impulse, .. }) = constraint.role else { continue };
            if let Role::Engaging { lost, .. } = constraint.role {
                let engages = What::Engages { lost: happening.after.discrete()[lost as usize] };
                let change = entry(if joins { engages } else { What::Releases });
                if !all.iter().any(|known| known.name == change.name && known.what == change.what) {
                    all.push(change);
                }
            }
            let impulse = happening.after.discrete()[impulse as usize];
            if joins && impulse != 0.0 {
                all.push(entry(What::Impact { impulse, angular: constraint.is_angle() }));
            }
        }
        all
    }
}
