//! Our descriptions, read and written by the crate `fmi-schema`.

use std::collections::BTreeMap;

use fmi::schema::traits::FmiModelDescription;

/// Every attribute of a document: element and name, and what it says.
fn attributes(document: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for tag in document.split('<').skip(1) {
        let name = tag.split([' ', '/', '>', '\n']).next().unwrap_or_default();
        if name.is_empty() || name.starts_with('?') {
            continue;
        }
        let mut rest = &tag[name.len()..];
        while let Some((key, after)) = rest.split_once("=\"") {
            let Some((value, after)) = after.split_once('"') else { break };
            // Numbers may be written in another way.
            let value = value.parse::<f64>().map_or_else(|_| value.to_owned(), |number| format!("{number:?}"));
            found.push((format!("{name} {}", key.trim()), value));
            rest = after;
        }
    }
    found
}

/// Reads a description and writes it again: the attributes that are lost, with how often.
pub fn lost<D: FmiModelDescription>(document: &str) -> Result<Vec<String>, String> {
    let description = D::deserialize(document).map_err(|error| error.to_string())?;
    let written = description.serialize().map_err(|error| error.to_string())?;
    let mut kept: BTreeMap<_, usize> = BTreeMap::new();
    attributes(&written).into_iter().for_each(|attribute| *kept.entry(attribute).or_default() += 1);
    let mut lost: BTreeMap<String, usize> = BTreeMap::new();
    for attribute in attributes(document) {
        match kept.get_mut(&attribute).filter(|count| **count > 0) {
            Some(count) => *count -= 1,
            None => *lost.entry(attribute.0).or_default() += 1,
        }
    }
    Ok(lost.into_iter().map(|(attribute, count)| format!("{attribute} ({count} x)")).collect())
}
