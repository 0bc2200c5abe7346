//! Names that other languages take.

/// A C identifier made from a name: letters, digits and underscores are kept, anything else becomes an
/// underscore.
pub fn identifier(name: &str) -> String {
    let mut text: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit()) {
        text.insert(0, '_');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_c_identifiers() {
        assert_eq!(identifier("slider_crank"), "slider_crank");
        assert_eq!(identifier("4-bar Größe"), "_4_bar_Gr__e");
        assert_eq!(identifier(""), "_");
    }
}
