//! XML as a tree of elements that know their places and which of their attributes were read, so that no attribute of a file is dropped unnoticed.

use std::cell::Cell;
use std::rc::Rc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::refusal::{Fallible, FilePlace, ImportRefusal};

/// How deep elements may be nested, and how many there may be: no file written by hand or by a converter comes near.
const DEEPEST: usize = 1000;
const MOST: usize = 200_000;

#[derive(Debug)]
pub struct Attribute {
    pub name: String,
    pub value: String,
    pub place: FilePlace,
    read: Cell<bool>,
}

#[derive(Debug)]
pub struct XmlElement {
    pub name: String,
    pub place: FilePlace,
    pub attributes: Vec<Attribute>,
    pub children: Vec<XmlElement>,
    /// Its text, without that of its children.
    pub text: String,
}

impl Attribute {
    /// The value, marked as read.
    pub fn value(&self) -> &str {
        self.read.set(true);
        &self.value
    }

    /// Its numbers, separated by blanks.
    ///
    /// # Errors
    /// What is not a finite number.
    pub fn numbers(&self) -> Fallible<Vec<f64>> {
        numbers(self.value()).map_err(|why| ImportRefusal::new(format!("`{}`: {why}", self.name)).at(&self.place))
    }

    /// Its one number.
    ///
    /// # Errors
    /// What is not one finite number.
    pub fn number(&self) -> Fallible<f64> {
        match self.numbers()?[..] {
            [number] => Ok(number),
            _ => Err(ImportRefusal::new(format!("`{}` is `{}`, but must be one number", self.name, self.value))
                .at(&self.place)),
        }
    }

    /// So many numbers.
    ///
    /// # Errors
    /// Another count, or what is not a finite number.
    pub fn array<const N: usize>(&self) -> Fallible<[f64; N]> {
        let numbers = self.numbers()?;
        <[f64; N]>::try_from(numbers).map_err(|_| {
            ImportRefusal::new(format!("`{}` is `{}`, but must be {N} numbers", self.name, self.value)).at(&self.place)
        })
    }
}

/// Finite numbers between blanks, or why not.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("`{word}` is not a finite number")),
        Err(_) if word.contains(',') => {
            Err(format!("`{word}` is not a number; numbers are separated by blanks and have a point, not a comma"))
        }
        Err(_) => Err(format!("`{word}` is not a number")),
    };
    text.split_whitespace().map(number).collect()
}

impl XmlElement {
    /// An attribute, not yet marked as read.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// The value of an attribute, marked as read.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(Attribute::value)
    }

    /// The value of an attribute that must be there.
    ///
    /// # Errors
    /// It is not there.
    pub fn must(&self, name: &str) -> Fallible<&str> {
        self.get(name).ok_or_else(|| self.refuse(format!("{} has no `{name}`", self.called())))
    }

    pub fn child(&self, name: &str) -> Option<&XmlElement> {
        self.children.iter().find(|child| child.name == name)
    }

    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a XmlElement> + 'a {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Its kind, and its name if it has one: joint `elbow`.
    pub fn called(&self) -> String {
        match self.attribute("name") {
            Some(name) => format!("{} `{}`", self.name, name.value),
            None => format!("<{}>", self.name),
        }
    }

    pub fn refuse(&self, message: impl Into<String>) -> ImportRefusal {
        ImportRefusal::new(message).at(&self.place)
    }

    /// Marks all that is in it as read.
    pub fn mark(&self) {
        self.attributes.iter().for_each(|attribute| attribute.read.set(true));
        self.children.iter().for_each(XmlElement::mark);
    }

    /// The numbers of its text.
    ///
    /// # Errors
    /// What is not a finite number.
    pub fn text_numbers(&self) -> Fallible<Vec<f64>> {
        numbers(&self.text).map_err(|why| self.refuse(format!("<{}>: {why}", self.name)))
    }

    /// The one number of its text.
    ///
    /// # Errors
    /// What is not one finite number.
    pub fn text_number(&self) -> Fallible<f64> {
        match self.text_numbers()?[..] {
            [number] => Ok(number),
            _ => Err(self.refuse(format!("<{}> is `{}`, but must be one number", self.name, self.text.trim()))),
        }
    }
}

/// A file as text: UTF-8 with or without a byte order mark, UTF-16 with one, else Latin-1.
///
/// # Errors
/// Bytes that are in none of them.
pub fn decode(bytes: &[u8]) -> Result<String, &'static str> {
    let bytes = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => rest,
        [0xff, 0xfe, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        _ => bytes,
    };
    if bytes.contains(&0) {
        return Err("it is a binary file, not a text");
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    })
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, &'static str> {
    let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    String::from_utf16(&units).map_err(|_| "it begins as UTF-16, but is not")
}

/// The tree of a document.
///
/// # Errors
/// Where it is not XML, breaks off, or is too large.
pub fn parse(file: &str, text: &str) -> Fallible<XmlElement> {
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let mut parser =
        XmlParser { file: Rc::from(file), text, starts, open: Vec::new(), count: 0, last: Cell::new((0, 1)) };
    let mut reader = Reader::from_str(text);
    loop {
        let begin = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            let place = parser.place(reader.error_position() as usize);
            let what = if error.to_string().contains("end of input") { "breaks off" } else { "is not well-formed XML" };
            ImportRefusal::new(format!("it {what}: {error}")).at(&place)
        })?;
        if let Some(root) = parser.event(event, begin)? {
            return Ok(root);
        }
    }
}

struct XmlParser<'a> {
    file: Rc<str>,
    text: &'a str,
    /// Where lines begin.
    starts: Vec<usize>,
    open: Vec<XmlElement>,
    count: usize,
    /// The offset and the column of the last place: a line may be as long as the file.
    last: Cell<(usize, usize)>,
}

impl XmlParser<'_> {
    fn place(&self, offset: usize) -> FilePlace {
        let line = self.starts.partition_point(|&start| start <= offset).max(1);
        let (start, end) = (self.starts[line - 1], offset.min(self.text.len()));
        let (from, column) =
            Some(self.last.get()).filter(|(last, _)| *last >= start && *last <= end).unwrap_or((start, 1));
        let between = self.text.as_bytes().get(from..end).unwrap_or_default();
        // Bytes that continue a character are no characters.
        let column = column + between.iter().filter(|byte| **byte & 0xc0 != 0x80).count();
        self.last.set((end, column));
        FilePlace { file: self.file.clone(), line, column }
    }

    /// Takes an event in; the root when it is closed.
    fn event(&mut self, event: Event<'_>, begin: usize) -> Fallible<Option<XmlElement>> {
        match event {
            Event::Start(tag) => {
                let element = self.element(&tag, begin)?;
                if self.open.len() >= DEEPEST {
                    return Err(element.refuse(format!("elements are nested more than {DEEPEST} deep")));
                }
                self.open.push(element);
            }
            Event::Empty(tag) => {
                let element = self.element(&tag, begin)?;
                return Ok(self.close(element));
            }
            Event::End(_) => {
                if let Some(element) = self.open.pop() {
                    return Ok(self.close(element));
                }
            }
            Event::Text(text) => self.add_text(&text),
            Event::CData(text) => self.add_text(&text),
            Event::GeneralRef(name) => self.reference(&name, begin)?,
            Event::DocType(text) if text.contains("<!ENTITY") => {
                return Err(ImportRefusal::new("it defines entities, which are not expanded")
                    .at(&self.place(begin))
                    .help("write their texts where they are used"));
            }
            Event::Eof => {
                let message = match self.open.last() {
                    Some(open) => {
                        format!("the file is truncated: {} of line {} is not closed", open.called(), open.place.line)
                    }
                    None => "it has no element".to_owned(),
                };
                return Err(ImportRefusal::new(message).at(&self.place(self.text.len())));
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
        }
        Ok(None)
    }

    fn add_text(&mut self, text: &str) {
        if let Some(open) = self.open.last_mut() {
            open.text.push_str(text);
        }
    }

    fn reference(&mut self, name: &str, begin: usize) -> Fallible<()> {
        let text = quick_xml::escape::unescape(&format!("&{name};")).map(|text| text.into_owned());
        let text =
            text.map_err(|_| ImportRefusal::new(format!("entity `&{name};` is not known")).at(&self.place(begin)))?;
        self.add_text(&text);
        Ok(())
    }

    fn close(&mut self, element: XmlElement) -> Option<XmlElement> {
        match self.open.last_mut() {
            Some(parent) => parent.children.push(element),
            None => return Some(element),
        }
        None
    }

    fn element(&mut self, tag: &BytesStart<'_>, begin: usize) -> Fallible<XmlElement> {
        self.count += 1;
        let place = self.place(begin);
        if self.count > MOST {
            return Err(ImportRefusal::new(format!("it has more than {MOST} elements")).at(&place));
        }
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let wrong = |error: &dyn std::fmt::Display| {
                ImportRefusal::new(format!("<{}> has a wrong attribute: {error}", tag.name().as_ref())).at(&place)
            };
            let attribute = attribute.map_err(|error| wrong(&error))?;
            let value = quick_xml::escape::unescape(&attribute.value).map_err(|error| wrong(&error))?;
            let offset = (attribute.key.as_ref().as_ptr() as usize).checked_sub(self.text.as_ptr() as usize);
            let at = offset.filter(|offset| *offset < self.text.len()).map_or(place.clone(), |at| self.place(at));
            let name = attribute.key.as_ref().to_owned();
            attributes.push(Attribute { name, value: value.into_owned(), place: at, read: Cell::new(false) });
        }
        let name = tag.name().as_ref().to_owned();
        Ok(XmlElement { name, place, attributes, children: Vec::new(), text: String::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_attributes_know_their_places() {
        let root = parse("a.xml", "<a>\n  <b c='1 2'\n     d=\"&lt;3\">x &amp; y<e/></b></a>").unwrap();
        let b = root.child("b").unwrap();
        assert_eq!((b.place.line, b.place.column), (2, 3));
        let [c, d] = ["c", "d"].map(|name| b.attribute(name).unwrap());
        assert_eq!((c.place.line, c.place.column, d.place.line, d.place.column), (2, 6, 3, 6));
        assert!(!c.read.get());
        assert_eq!(c.array::<2>().unwrap(), [1.0, 2.0]);
        assert!(c.read.get() && !d.read.get());
        assert_eq!((d.value(), &b.text[..]), ("<3", "x & y"));
    }

    #[test]
    fn what_is_not_xml_is_one_error_with_its_place() {
        let deep = "<a>".repeat(2000);
        for (text, place, why) in [
            ("<a>\n<b></a>", "a.xml:2:", "well-formed"),
            ("<a>\n<b>", "a.xml:2:4", "truncated"),
            ("", "a.xml:1:1", "no element"),
            ("<a>&no;</a>", "a.xml:1:4", "`&no;`"),
            ("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "a.xml:1:1", "entities"),
            (&deep, "a.xml:1:3001", "nested"),
        ] {
            let refusal = parse("a.xml", text).unwrap_err().to_string();
            assert!(refusal.starts_with(place) && refusal.contains(why), "{refusal}");
        }
        for (value, why) in
            [("nan", "finite"), ("inf", "finite"), ("1e400", "finite"), ("1,5", "comma"), ("x", "number")]
        {
            let root = parse("a.xml", &format!("<a b='{value}'/>")).unwrap();
            let refusal = root.attribute("b").unwrap().number().unwrap_err().to_string();
            assert!(refusal.starts_with("a.xml:1:4: `b`") && refusal.contains(why), "{refusal}");
        }
    }

    #[test]
    fn texts_are_read_in_the_usual_encodings() {
        let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain("<ä/>".encode_utf16().flat_map(u16::to_le_bytes)).collect();
        for bytes in [&b"\xef\xbb\xbf<\xc3\xa4/>"[..], b"<\xc3\xa4/>", b"<\xe4/>", &utf16] {
            assert_eq!(decode(bytes).unwrap(), "<ä/>");
        }
        assert!(decode(b"MJB\0\x01").is_err());
    }
}
