//! Which modes there are to choose from at an instant: who is open or closed, sticks or slips, and with which sign something presses.
//!
//! Modes are numbers among the discrete variables of the state. All combinations of what is undecided are tried in an order in which the likely one comes first; what fits is for others to say.

use crate::program::{Contact, Contacts};

/// More combinations than these are not tried: four contacts whose friction sticks, slips either way, or is held by the others, have fewer.
pub(crate) const MOST_TRIALS: usize = 1 << 15;
/// So many options has something at most.
const OPTIONS: usize = 6;

/// Something undecided, with its options.
#[derive(Clone, Copy, Debug)]
struct Choice {
    what: What,
    /// None of friction whose motion other parts hold, and that takes no share.
    options: [Option<f64>; OPTIONS],
    count: usize,
}

impl Choice {
    fn of(what: What, given: &[Option<f64>]) -> Self {
        let mut options = [None; OPTIONS];
        options[..given.len()].copy_from_slice(given);
        Self { what, options, count: given.len() }
    }
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// 1 if it is closed, else 0.
    Closed(usize),
    /// 0 if it sticks, 1 or -1 if it slips, a level at rest by that while it slips if other parts hold it and it takes its full share, or none if it does not rub.
    Slips(usize),
    /// A sign of what presses a friction, by its place among the discrete variables.
    Sign(usize, u32),
}

impl What {
    /// The contact or friction.
    fn index(self) -> usize {
        match self {
            What::Closed(index) | What::Slips(index) | What::Sign(index, _) => index,
        }
    }

    /// True for a sign, whose friction need not be undecided.
    fn is_sign(self) -> bool {
        matches!(self, What::Sign(..))
    }
}

/// What is undecided.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choices {
    all: Vec<Choice>,
}

impl Choices {
    pub fn with_capacity(most: usize) -> Self {
        Self { all: Vec::with_capacity(most) }
    }

    pub fn clear(&mut self) {
        self.all.clear();
    }

    /// A contact may be closed or open, more likely as it `closes`.
    pub fn contact(&mut self, index: usize, closes: bool) {
        let likely = f64::from(u8::from(closes));
        self.all.push(Choice::of(What::Closed(index), &[Some(likely), Some(1.0 - likely)]));
    }

    /// Something sticks or slips, in the order in which that is likely.
    pub fn slip(&mut self, index: usize, options: [f64; 3]) {
        self.all.push(Choice::of(What::Slips(index), &options.map(Some)));
    }

    /// The same of what may be held by a joint that engages, without any share.
    pub fn joined(&mut self, index: usize, [first, second, third]: [f64; 3]) {
        self.all.push(Choice::of(What::Slips(index), &[Some(first), Some(second), None, Some(third)]));
    }

    /// Something that has been found to slip does so, one way or the other, unless others still hold it: then it takes its full share, which is its level at rest, `ratio` times that while it slips.
    pub fn slips(&mut self, index: usize, [first, second]: [f64; 2], ratio: f64) {
        let all = [first, second, ratio * first, ratio * second].map(Some);
        self.all.push(Choice::of(What::Slips(index), if ratio == 1.0 { &all[..2] } else { &all }));
    }

    /// The same of what rests, which may also stick, or be held by other parts without any share.
    pub fn rest(&mut self, index: usize, [first, second]: [f64; 2], ratio: f64) {
        let all = [Some(0.0), None, Some(first), Some(second), Some(ratio * first), Some(ratio * second)];
        self.all.push(Choice::of(What::Slips(index), if ratio == 1.0 { &all[..4] } else { &all }));
    }

    /// A sign of what presses a friction, more likely this one.
    pub fn sign(&mut self, index: usize, sign: u32, likely: f64) {
        self.all.push(Choice::of(What::Sign(index, sign), &[Some(likely), Some(-likely)]));
    }

    /// Those of others that belong to some contacts and frictions.
    pub fn take_part(&mut self, others: &Choices, belongs: impl Fn(usize) -> bool) {
        self.all.clear();
        self.all.extend(others.all.iter().filter(|choice| belongs(choice.what.index())));
    }

    /// The contact or friction of each.
    pub fn owners(&self) -> impl Iterator<Item = usize> {
        self.all.iter().map(|choice| choice.what.index())
    }

    /// Opens what is undecided, and lets nothing undecided rub.
    pub fn open(&self, data: &Contacts, discrete: &mut [f64]) {
        for index in self.concerned() {
            data.all[index].slips(discrete, None);
        }
    }

    /// Copies how all of them are set.
    pub fn copy(&self, data: &Contacts, from: &[f64], to: &mut [f64]) {
        for choice in &self.all {
            let state = &data.all[choice.what.index()].state;
            let places = match choice.what {
                What::Sign(_, place) => [Some(place), None],
                What::Closed(_) | What::Slips(_) => [Some(state.closed), state.direction],
            };
            places.into_iter().flatten().for_each(|place| to[place as usize] = from[place as usize]);
        }
    }

    /// How many combinations there are.
    pub fn trials(&self) -> usize {
        self.all.iter().fold(1, |trials: usize, choice| trials.saturating_mul(choice.count))
    }

    /// The contacts, and what slips, that are undecided.
    pub fn concerned(&self) -> impl Iterator<Item = usize> {
        self.all.iter().filter(|choice| !choice.what.is_sign()).map(|choice| choice.what.index())
    }

    /// True for what is undecided.
    pub fn includes(&self, index: usize) -> bool {
        self.concerned().any(|concerned| concerned == index)
    }

    /// Sets one of the combinations among the discrete variables; false if it is the same as another one, because nothing rubs at what is open.
    pub fn set(&self, trial: usize, data: &Contacts, discrete: &mut [f64]) -> bool {
        let (mut rest, mut is_new) = (trial, true);
        for choice in &self.all {
            let option = choice.options[rest % choice.count];
            let is_first = rest % choice.count == 0;
            rest /= choice.count;
            match choice.what {
                What::Closed(index) => discrete[data.all[index].state.closed as usize] = option.unwrap_or(0.0),
                What::Slips(index) => {
                    let on = data.all[index].slip.as_ref().and_then(|slip| slip.on);
                    let rubs = on.is_none_or(|on| discrete[data.all[on as usize].state.closed as usize] != 0.0);
                    is_new &= rubs || is_first;
                    data.all[index].slips(discrete, option.filter(|_| rubs));
                }
                What::Sign(_, sign) => discrete[sign as usize] = option.unwrap_or(0.0),
            }
        }
        is_new
    }
}

impl Contact {
    /// Sets how it rubs: 0 if it sticks, 1 or -1 if it slips that way, none if it does not.
    pub(crate) fn slips(&self, discrete: &mut [f64], mode: Option<f64>) {
        discrete[self.state.closed as usize] = f64::from(u8::from(mode == Some(0.0)));
        if let Some(direction) = self.state.direction {
            discrete[direction as usize] = mode.unwrap_or(0.0);
        }
    }
}
