//! What is wrong is said at once.

use std::fmt::Display;

/// All of them, or everything that is wrong.
///
/// # Errors
/// Those of all that failed, in their order.
pub fn every<T, E>(results: impl Iterator<Item = Result<T, E>>) -> Result<Vec<T>, Vec<E>> {
    let (mut good, mut wrong) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(one) => good.push(one),
            Err(error) => wrong.push(error),
        }
    }
    if wrong.is_empty() { Ok(good) } else { Err(wrong) }
}

/// What is wrong, a line for each.
pub fn lines(wrong: &[impl Display]) -> String {
    wrong.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}
