//! Pages of text, formulas and tables in plain text, LaTeX and HTML.

use std::fmt::Write;

use super::notation::lines::printed;
use super::notation::{latex, mathml, plain, unicode};
use super::tree::Tree;
use crate::output::svg::escape;

/// Formulas are broken at about so many characters.
const WIDTH: f64 = 110.0;
/// The width of a printed page and of a web page, in digits.
const PAGE_WIDTH: f64 = 95.0;
const SCREEN_WIDTH: f64 = 120.0;
/// Left sides wider than this part of the page do not stand below each other.
const LEFT: f64 = 0.3;

#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    Heading(String),
    Text(Vec<Piece>),
    /// Equations below each other: left side, right side.
    Equations(Vec<(Tree, Tree)>),
    /// A table; the head may be empty.
    Table(Vec<String>, Vec<Vec<Piece>>),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    Words(String),
    Code(String),
    Math(Tree),
}

impl Piece {
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
            Piece::Words(text) => latex::breakable(text),
            Piece::Code(name) => format!(r"\texttt{{{}}}", latex::breakable(name)),
            Piece::Math(tree) => format!("${}$", latex::latex(tree)),
        }
    }

    fn width(&self) -> f64 {
        match self {
            Piece::Words(text) => text.chars().count() as f64,
            Piece::Code(name) => 1.05 * name.chars().count() as f64,
            Piece::Math(tree) => printed(tree),
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

/// A row of a display: a left side that stands before the sign, and the lines of the rest.
struct Row {
    left: Option<Tree>,
    lines: Vec<String>,
}

/// Equations with their left sides below each other; if one of these is wide, all equations are broken as a whole.
fn rows(
    rows: &[(Tree, Tree)],
    page: f64,
    width: impl Fn(&Tree) -> f64,
    wrapped: impl Fn(&Tree, f64) -> Vec<String>,
) -> Vec<Row> {
    let widest = rows.iter().map(|(left, _)| width(left)).fold(0.0, f64::max);
    let row = |(left, right): &(Tree, Tree)| match widest <= LEFT * page {
        true => Row { left: Some(left.clone()), lines: wrapped(right, page - widest - 4.0) },
        false => {
            let whole = Tree::Relation("=", Box::new([left.clone(), right.clone()]));
            Row { left: None, lines: wrapped(&whole, page) }
        }
    };
    rows.iter().map(row).collect()
}

fn text_equations(text: &mut String, equations: &[(Tree, Tree)]) {
    let width = |tree: &Tree| plain::plain(tree).chars().count() as f64;
    let rows = rows(equations, WIDTH, width, plain::wrapped);
    let lefts = rows.iter().flat_map(|row| &row.left).map(|left| plain::plain(left).chars().count());
    let width = lefts.max().unwrap_or_default();
    for row in rows {
        let Some(left) = row.left else {
            row.lines.iter().for_each(|line| add(text, format_args!("  {line}\n")));
            continue;
        };
        let (mut left, mut sign) = (plain::plain(&left), "=");
        for line in row.lines {
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

pub fn latex(title: &str, blocks: &[Block]) -> String {
    let mut text = format!("\\begin{{document}}\n\\section*{{\\raggedright {}}}\n", latex::escape(title));
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
    let preamble = "\\documentclass[a4paper,10pt]{article}\n\\usepackage[margin=20mm]{geometry}\n\
                    \\usepackage{amsmath,array,longtable,lmodern}\n\\usepackage[T1]{fontenc}\n\\allowdisplaybreaks\n\
                    \\setlength{\\parindent}{0pt}\n";
    format!("{preamble}{}{text}", unicode::declarations(&text))
}

fn latex_equations(text: &mut String, equations: &[(Tree, Tree)]) {
    text.push_str("\\begin{align*}\n");
    let rows = rows(equations, PAGE_WIDTH, printed, latex::wrapped);
    for (index, row) in rows.iter().enumerate() {
        let lines = row.lines.join(" \\\\\n    &\\quad");
        let end = if index + 1 < rows.len() { r" \\" } else { "" };
        match &row.left {
            Some(left) => add(text, format_args!("  {} &= {lines}{end}\n", latex::latex(left))),
            None => add(text, format_args!("  &{lines}{end}\n")),
        }
    }
    text.push_str("\\end{align*}\n");
}

/// A table; a matrix that is wider than the page is cut into parts, of other tables the lines are broken within the cells.
fn latex_table(text: &mut String, head: &[String], rows: &[Vec<Piece>]) {
    let columns = rows.iter().map(Vec::len).chain([head.len()]).max().unwrap_or_default();
    let widths: Vec<f64> = (0..columns).map(|column| column_width(head, rows, column)).collect();
    let total: f64 = widths.iter().sum();
    let all: Vec<usize> = (0..columns).collect();
    let is_matrix = widths.iter().skip(1).all(|&width| width <= NARROW);
    if total <= PAGE_WIDTH {
        latex_columns(text, head, rows, &all, &"l".repeat(columns));
    } else if is_matrix {
        for part in parts(&widths, !head.is_empty()) {
            latex_columns(text, head, rows, &part, &"l".repeat(part.len()));
        }
    } else {
        let cell =
            |width: &f64| format!(">{{\\raggedright\\arraybackslash}}p{{{:.3}\\linewidth}}", 0.87 * width / total);
        latex_columns(text, head, rows, &all, &widths.iter().map(cell).collect::<String>());
    }
}

/// Wider cells are words, not entries of a matrix.
const NARROW: f64 = 16.0;
const GAP: f64 = 2.6;

fn column_width(head: &[String], rows: &[Vec<Piece>], column: usize) -> f64 {
    let cells = rows.iter().filter_map(|row| row.get(column)).map(Piece::width);
    let head = head.get(column).map(|cell| cell.chars().count() as f64);
    GAP + cells.chain(head).fold(0.0, f64::max)
}

/// Columns that fit on a page, each time behind the first if that names the rows.
fn parts(widths: &[f64], named: bool) -> Vec<Vec<usize>> {
    let first: Vec<usize> = named.then_some(0).into_iter().collect();
    let mut parts = vec![first.clone()];
    let mut used = first.iter().map(|&column| widths[column]).sum::<f64>();
    for (column, width) in widths.iter().enumerate().skip(first.len()) {
        if used + width > PAGE_WIDTH && parts.last().is_some_and(|part| part.len() > first.len()) {
            parts.push(first.clone());
            used = first.iter().map(|&column| widths[column]).sum();
        }
        used += width;
        parts.last_mut().into_iter().for_each(|part| part.push(column));
    }
    parts
}

fn latex_columns(text: &mut String, head: &[String], rows: &[Vec<Piece>], columns: &[usize], format: &str) {
    add(text, format_args!("\\begin{{longtable}}[l]{{{format}}}\n"));
    if !head.is_empty() {
        let cells: Vec<String> =
            columns.iter().filter_map(|&column| head.get(column)).map(|cell| latex::escape(cell)).collect();
        add(text, format_args!("{} \\\\ \\hline\n", cells.join(" & ")));
    }
    for row in rows {
        let cells: Vec<String> = columns.iter().filter_map(|&column| row.get(column)).map(Piece::latex).collect();
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
                html_equations(&mut text, rows);
                text.push_str("</mtable></math></div>\n");
            }
            Block::Table(head, rows) => html_table(&mut text, head, rows),
        }
    }
    text
}

fn html_equations(text: &mut String, equations: &[(Tree, Tree)]) {
    for row in rows(equations, SCREEN_WIDTH, printed, mathml::wrapped) {
        let (mut left, sign) = match &row.left {
            Some(left) => (mathml::mathml(left), "<mo>=</mo>"),
            None => (String::new(), ""),
        };
        let mut sign = sign;
        for line in row.lines {
            add(text, format_args!("<mtr><mtd>{left}</mtd><mtd><mrow>{sign}{line}</mrow></mtd></mtr>\n"));
            left.clear();
            sign = "";
        }
    }
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
