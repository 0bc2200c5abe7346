//! Words that an option takes.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Takes one of them, each with what it means.
pub fn one_of<T: Copy + Send + Sync>(
    words: &'static [(&'static str, &'static str, T)],
) -> impl TypedValueParser<Value = T> {
    let known = words.iter().map(|(word, meaning, _)| PossibleValue::new(*word).help(*meaning));
    PossibleValuesParser::new(known).try_map(move |given| {
        words.iter().find(|(word, ..)| *word == given).map(|(.., value)| *value).ok_or("is none of the words")
    })
}
