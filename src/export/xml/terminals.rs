//! `terminalsAndIcons.xml` of FMI 3.0: what belongs to one joint, body or point is one terminal.

use std::io;

use super::{Out, document, element, leaf};
use crate::export::description::{Causality, Description, ScalarVariable};

/// The document; nothing if there is no terminal.
pub fn terminals(description: &Description) -> io::Result<Option<Vec<u8>>> {
    let terminals = collect(description);
    if terminals.is_empty() {
        return Ok(None);
    }
    let version = vec![("fmiVersion", "3.0".to_owned())];
    let written = document("fmiTerminalsAndIcons", version, |out| {
        element(out, "Terminals", vec![], |out| terminals.iter().try_for_each(|terminal| terminal.write(out)))
    });
    written.map(Some)
}

/// A part of the mechanism, and its variables by what they are called within it.
struct Terminal<'a> {
    owner: &'a str,
    members: Vec<(&'a str, &'a ScalarVariable)>,
}

/// In the order of the variables. What an importer can connect: outputs and inputs.
fn collect(description: &Description) -> Vec<Terminal<'_>> {
    let mut terminals: Vec<Terminal> = Vec::new();
    let mut places = std::collections::HashMap::new();
    for variable in &description.variables {
        if !matches!(variable.causality, Causality::Output | Causality::Input { .. }) {
            continue;
        }
        let Some((owner, member)) = variable.name.rsplit_once('.') else { continue };
        let place = *places.entry(owner).or_insert_with(|| {
            terminals.push(Terminal { owner, members: Vec::new() });
            terminals.len() - 1
        });
        terminals[place].members.push((member, variable));
    }
    terminals
}

impl Terminal<'_> {
    fn write(&self, out: &mut Out) -> io::Result<()> {
        // A scene asks for some of the variables of a part, seldom for all: members may be missing.
        let attributes = vec![("name", self.owner.to_owned()), ("matchingRule", "bus".to_owned())];
        element(out, "Terminal", attributes, |out| {
            self.members.iter().try_for_each(|(member, variable)| {
                let attributes = vec![
                    ("variableName", variable.name.clone()),
                    ("memberName", (*member).to_owned()),
                    ("variableKind", "signal".to_owned()),
                ];
                leaf(out, "TerminalMemberVariable", attributes)
            })
        })
    }
}
