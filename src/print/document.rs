//! Pages of text, formulas and tables in plain text, LaTeX and HTML.

use std::fmt::Write;

use super::notation::{latex, mathml, plain};
use super::tree::Tree;
use crate::report::svg::escape;

/// Formulas are broken at about so many characters.
const WIDTH: usize = 100;
/// The same where letters are proportional and names are short.
const PRINTED_WIDTH: usize = 120;

/// Part of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(Vec<Piece>),
    /// Equations below each other: left side, right side.
    Equations(Vec<(Tree, Tree)>),
    /// A table; the head may be empty.
    Table(Vec<String>, Vec<Vec<Piece>>),
}

/// Part of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Words.
    Words(String),
    /// What stands so in the scene.
    Code(String),
    /// A formula.
    Math(Tree),
}

impl Piece {
    /// Words.
    pub fn words(text: impl Into<String>) -> Self {
        Piece::Words(text.into())
    }

    fn plain(&self) -> String {
        match self {
            Piece::Words(text) => text.clone(),
            Piece::Code(name) => format!("`{name}`"),
            Piece::Math(tree) => plain::plain(tree),
        }
    }

    fn latex(&self) -> String {
        match self {
            Piece::Words(text) => latex::escape(text),
            Piece::Code(name) => format!(r"\texttt{{{}}}", latex::escape(name)),
            Piece::Math(tree) => format!("${}$", latex::latex(tree)),
        }
    }

    fn html(&self) -> String {
        match self {
            Piece::Words(text) => escape(text),
            Piece::Code(name) => format!("<code>{}</code>", escape(name)),
            Piece::Math(tree) => format!("<math>{}</math>", mathml::mathml(tree)),
        }
    }
}

/// A page in plain text.
pub fn text(title: &str, blocks: &[Block]) -> String {
    let mut text = format!("{title}\n");
    for block in blocks {
        match block {
            Block::Heading(heading) => add(&mut text, format_args!("\n{heading}\n")),
            Block::Text(pieces) => {
                let line: String = pieces.iter().map(Piece::plain).collect();
                add(&mut text, format_args!("  {line}\n"));
            }
            Block::Equations(rows) => text_equations(&mut text, rows),
            Block::Table(head, rows) => text_table(&mut text, head, rows),
        }
    }
    text
}

fn text_equations(text: &mut String, rows: &[(Tree, Tree)]) {
    let rows: Vec<(String, Vec<String>)> =
        rows.iter().map(|(left, right)| (plain::plain(left), plain::wrapped(right, WIDTH))).collect();
    let short = rows.iter().map(|(left, _)| left.chars().count()).filter(|&width| width <= WIDTH / 3);
    let width = short.max().unwrap_or_default();
    for (left, lines) in rows {
        let mut sign = "=";
        let mut left = left;
        for line in lines {
            add(text, format_args!("  {left:width$} {sign} {line}\n"));
            sign = " ";
            left.clear();
        }
    }
}

fn text_table(text: &mut String, head: &[String], rows: &[Vec<Piece>]) {
    let cells = rows.iter().map(|row| row.iter().map(Piece::plain).collect::<Vec<_>>());
    let lines: Vec<Vec<String>> = (!head.is_empty()).then(|| head.to_vec()).into_iter().chain(cells).collect();
    let columns = lines.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or_default()
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for line in lines {
        let cells: String = line.iter().zip(&widths).map(|(cell, width)| format!("  {cell:width$}")).collect();
        add(text, format_args!("{}\n", cells.trim_end()));
    }
}

/// A page in LaTeX, ready to be compiled.
pub fn latex(title: &str, blocks: &[Block]) -> String {
    let title = latex::escape(title);
    let mut text = format!(
        "\\documentclass[a4paper,10pt]{{article}}\n\\usepackage[margin=20mm]{{geometry}}\n\
         \\usepackage{{amsmath,longtable,lmodern}}\n\\usepackage[T1]{{fontenc}}\n\\allowdisplaybreaks\n\
         \\setlength{{\\parindent}}{{0pt}}\n\\begin{{document}}\n\\section*{{{title}}}\n"
    );
    for block in blocks {
        match block {
            Block::Heading(heading) => add(&mut text, format_args!("\n\\subsection*{{{}}}\n", latex::escape(heading))),
            Block::Text(pieces) => {
                let line: String = pieces.iter().map(Piece::latex).collect();
                add(&mut text, format_args!("{line}\n\n"));
            }
            Block::Equations(rows) => latex_equations(&mut text, rows),
            Block::Table(head, rows) => latex_table(&mut text, head, rows),
        }
    }
    text.push_str("\\end{document}\n");
    text
}

fn latex_equations(text: &mut String, rows: &[(Tree, Tree)]) {
    text.push_str("\\begin{align*}\n");
    for (index, (left, right)) in rows.iter().enumerate() {
        let lines = latex::wrapped(right, PRINTED_WIDTH).join(" \\\\\n    &\\quad");
        let end = if index + 1 < rows.len() { r" \\" } else { "" };
        add(text, format_args!("  {} &= {lines}{end}\n", latex::latex(left)));
    }
    text.push_str("\\end{align*}\n");
}

fn latex_table(text: &mut String, head: &[String], rows: &[Vec<Piece>]) {
    let columns = rows.iter().map(Vec::len).chain([head.len()]).max().unwrap_or_default();
    add(text, format_args!("\\begin{{longtable}}[l]{{{}}}\n", "l".repeat(columns)));
    if !head.is_empty() {
        let cells: Vec<String> = head.iter().map(|cell| latex::escape(cell)).collect();
        add(text, format_args!("{} \\\\ \\hline\n", cells.join(" & ")));
    }
    for row in rows {
        let cells: Vec<String> = row.iter().map(Piece::latex).collect();
        add(text, format_args!("{} \\\\\n", cells.join(" & ")));
    }
    text.push_str("\\end{longtable}\n");
}

const STYLE: &str = "body{font:16px/1.5 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;color:#1f2933;max-width:72rem;\
margin:2rem auto;padding:0 1rem}table{border-collapse:collapse;font-size:.92rem}th,td{text-align:left;\
padding:.15rem .7rem;border-bottom:1px solid #e6eaef}code{font-size:.92em;background:#f3f5f8;padding:.1em .3em;\
border-radius:3px}";

/// Equations align at their signs; wide ones scroll.
const MATH_STYLE: &str = ".equations{overflow-x:auto;margin:.6rem 0}.equations mtd{text-align:left;padding:.25em .15em}\
.equations mtd:first-child{text-align:right}";

/// A self-contained page in HTML.
pub fn html(title: &str, blocks: &[Block]) -> String {
    let name = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{name}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n{}</body>\n</html>\n",
        fragment(blocks)
    )
}

/// The same without the frame of a page, to be put into one.
pub fn fragment(blocks: &[Block]) -> String {
    let mut text = format!("<style>{MATH_STYLE}</style>\n");
    for block in blocks {
        match block {
            Block::Heading(heading) => add(&mut text, format_args!("<h2>{}</h2>\n", escape(heading))),
            Block::Text(pieces) => {
                let line: String = pieces.iter().map(Piece::html).collect();
                add(&mut text, format_args!("<p>{line}</p>\n"));
            }
            Block::Equations(rows) => {
                text.push_str("<div class=\"equations\"><math display=\"block\"><mtable>\n");
                for (left, right) in rows {
                    add(&mut text, format_args!("{}\n", mathml::equation(left, right, PRINTED_WIDTH)));
                }
                text.push_str("</mtable></math></div>\n");
            }
            Block::Table(head, rows) => html_table(&mut text, head, rows),
        }
    }
    text
}

fn html_table(text: &mut String, head: &[String], rows: &[Vec<Piece>]) {
    text.push_str("<table>\n");
    if !head.is_empty() {
        let cells: String = head.iter().map(|cell| format!("<th>{}</th>", escape(cell))).collect();
        add(text, format_args!("<tr>{cells}</tr>\n"));
    }
    for row in rows {
        let cells: String = row.iter().map(|cell| format!("<td>{}</td>", cell.html())).collect();
        add(text, format_args!("<tr>{cells}</tr>\n"));
    }
    text.push_str("</table>\n");
}

fn add(text: &mut String, line: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(line);
}
