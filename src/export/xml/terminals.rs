//! `terminalsAndIcons.xml` of FMI 3.0.

use std::io;

use super::{Out, document, element, leaf};
use crate::export::description::{Description, Flow, Terminal};

/// The document; nothing if there is no terminal.
pub fn terminals(description: &Description) -> io::Result<Option<Vec<u8>>> {
    let terminals = &description.terminals;
    if terminals.is_empty() {
        return Ok(None);
    }
    let version = vec![("fmiVersion", "3.0".to_owned())];
    let written = document("fmiTerminalsAndIcons", version, |out| {
        element(out, "Terminals", vec![], |out| {
            terminals.iter().try_for_each(|terminal| write(out, terminal, description))
        })
    });
    written.map(Some)
}

fn write(out: &mut Out, terminal: &Terminal, description: &Description) -> io::Result<()> {
    // A scene asks for some of the variables of a part, seldom for all: members may be missing.
    let attributes = vec![("name", terminal.name.clone()), ("matchingRule", "bus".to_owned())];
    element(out, "Terminal", attributes, |out| {
        terminal.members.iter().try_for_each(|member| {
            let kind = match member.flow {
                Flow::None => "signal",
                Flow::In => "inflow",
                Flow::Out => "outflow",
            };
            let attributes = vec![
                ("variableName", description.variables[member.variable].name.clone()),
                ("memberName", member.name.clone()),
                ("variableKind", kind.to_owned()),
            ];
            leaf(out, "TerminalMemberVariable", attributes)
        })
    })
}
