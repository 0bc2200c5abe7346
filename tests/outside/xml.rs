//! Documents as lists of start tags.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// A start tag: path of names, attributes.
pub type Tag = (String, Vec<(String, String)>);

/// Every start tag of a document.
pub fn tags(document: &[u8]) -> Vec<Tag> {
    let mut reader = Reader::from_reader(document);
    let (mut tags, mut path, mut buffer) = (vec![], Vec::<String>::new(), vec![]);
    loop {
        match reader.read_event_into(&mut buffer).expect("well-formed") {
            Event::Start(tag) => {
                path.push(tag.name().as_ref().to_owned());
                tags.push((path.join("/"), attributes(&tag)));
            }
            Event::Empty(tag) => tags.push((format!("{}/{}", path.join("/"), tag.name().as_ref()), attributes(&tag))),
            Event::End(_) => drop(path.pop()),
            Event::Eof => return tags,
            _ => {}
        }
        buffer.clear();
    }
}

fn attributes(tag: &BytesStart) -> Vec<(String, String)> {
    let attributes = tag.attributes().map(|attribute| attribute.expect("well-formed"));
    attributes
        .map(|attribute| {
            let value = quick_xml::escape::unescape(&attribute.value).expect("well-formed").into_owned();
            (attribute.key.as_ref().to_owned(), value)
        })
        .collect()
}

pub fn attribute<'a>(tag: &'a Tag, key: &str) -> Option<&'a str> {
    tag.1.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
}
