//! "Did you mean": the nearest of the names that would have been right.

/// The candidate nearest to `name`, if any is near.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (name.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .filter(|candidate| candidate.len().abs_diff(name.len()) <= limit && candidate.len() < 64)
        .map(|candidate| (strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase()), candidate))
        // A name of one letter is not near to every other letter.
        .filter(|(distance, candidate)| *distance <= limit && *distance < candidate.len().min(name.len()))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// So many names are listed at most.
pub const MOST: usize = 12;

/// Names in backticks, joined by commas; a long list is cut.
pub fn list(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    joined(names.into_iter().map(|name| format!("`{}`", name.as_ref())), MOST)
}

/// Names joined by commas, `most` of them.
pub fn joined(names: impl IntoIterator<Item = impl AsRef<str>>, most: usize) -> String {
    let mut names = names.into_iter();
    let mut shown: Vec<String> = names.by_ref().take(most).map(|name| name.as_ref().to_owned()).collect();
    let further = names.count();
    shown.extend((further > 0).then(|| format!("and {further} more")));
    shown.join(", ")
}

/// "did you mean `x`?", or else the sentence `otherwise`.
pub(crate) fn hint<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>, otherwise: String) -> String {
    match nearest(name, candidates) {
        Some(candidate) => format!("did you mean `{candidate}`?"),
        None => otherwise,
    }
}

/// "did you mean `x`?", or else the names that there are.
pub fn known<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str, IntoIter: Clone>) -> String {
    let candidates = candidates.into_iter();
    match list(candidates.clone()) {
        names if names.is_empty() => "there are none".to_owned(),
        names => hint(name, candidates, format!("there are: {names}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_name_is_found_and_a_far_one_is_not() {
        assert_eq!(nearest("smal_end", ["big_end", "small_end"]), Some("small_end"));
        assert_eq!(nearest("Mass", ["mass", "points"]), Some("mass"));
        assert_eq!(nearest("zebra", ["mass", "points"]), None);
    }

    #[test]
    fn what_is_known_is_the_near_name_or_a_few_others() {
        assert_eq!(known("mas", ["mass", "points"]), "did you mean `mass`?");
        assert_eq!(known("zebra", ["mass", "points"]), "there are: `mass`, `points`");
        assert_eq!(known("zebra", []), "there are none");
        assert!(known("zebra", ["mass"; 40]).ends_with("`mass`, and 28 more"));
    }
}
