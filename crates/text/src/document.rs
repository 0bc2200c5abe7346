//! Pages of text, formulas and tables in plain text, LaTeX and HTML.

use cotree::typeset::aligned;
use cotree_draw::svg::escape;

use super::notation::latex::{self, LATEX};
use super::notation::lines::FormulaPart;
use super::notation::mathml::MATHML;
use super::notation::plain::PLAIN;
use super::notation::{Binding, Notation, unicode};
use super::tree::FormulaTree;
use crate::tikz::tikz;

/// The width of a printed page, in digits.
const PAGE_WIDTH: f64 = 95.0;
/// Left sides wider than this part of the page are not aligned.
const LEFT: f64 = 0.3;

#[derive(Clone, Debug, PartialEq)]
pub enum DocumentBlock {
    Heading(String),
    Text(Vec<Piece>),
    /// Equations below each other: left side, right side.
    Equations(Vec<(FormulaTree, FormulaTree)>),
    Table(DocumentTable),
    /// An SVG picture, and the option of `show` that writes it as a file, if there is one.
    Picture(String, &'static str),
    /// What is only shown on request where that is possible; a line about it.
    Folded(String, Vec<DocumentBlock>),
}

/// Rows of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct DocumentTable {
    /// What it shows; empty where a heading says it.
    pub caption: String,
    /// Names of the columns; may be empty.
    pub head: Vec<String>,
    pub rows: Vec<Vec<Piece>>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    Words(String),
    /// A name of the scene.
    Code(String),
    Math(FormulaTree),
    /// Pieces behind each other.
    Row(Vec<Piece>),
}

struct DocumentFormat {
    notation: &'static Notation,
    /// Formulas are broken at about so many digits.
    width: f64,
    words: fn(&str) -> String,
    code: fn(&str) -> String,
    math: fn(&str) -> String,
    heading: fn(&str) -> String,
    paragraph: fn(&str) -> String,
    equations: fn(Vec<DisplayRow>) -> String,
    table: fn(&DocumentTable) -> String,
    picture: fn(&str, &str) -> String,
    /// A line about what is folded, and that itself where it can be unfolded.
    folded: Option<fn(&str, &str) -> String>,
}

const TEXT: DocumentFormat = DocumentFormat {
    notation: &PLAIN,
    width: 110.0,
    words: str::to_owned,
    code: |name| format!("`{name}`"),
    math: str::to_owned,
    heading: |heading| format!("\n{heading}\n"),
    paragraph: |line| format!("  {line}\n"),
    equations: text_equations,
    table: text_table,
    picture: |_, option| {
        if option.is_empty() {
            return "  [picture: in this page in html or latex]\n".to_owned();
        }
        format!("  [picture: `cotree show` with `{option} FILE.svg`, or this page in html or latex]\n")
    },
    folded: None,
};

const DOCUMENT: DocumentFormat = DocumentFormat {
    notation: &LATEX,
    width: PAGE_WIDTH,
    words: latex::breakable,
    code: |name| format!(r"\texttt{{{}}}", latex::breakable(name)),
    math: |formula| format!("${formula}$"),
    heading: |heading| format!("\n\\subsection*{{{}}}\n", latex::escape(heading)),
    paragraph: |line| format!("{line}\n\n"),
    equations: latex_equations,
    table: latex_table,
    picture: |svg, _| match tikz(svg) {
        Ok(picture) => format!("\\begin{{center}}\n{picture}\\end{{center}}\n"),
        Err(why) => format!("% no picture: {why}\n"),
    },
    folded: None,
};

const HTML: DocumentFormat = DocumentFormat {
    notation: &MATHML,
    width: 120.0,
    words: escape,
    code: |name| format!("<code>{}</code>", escape(name)),
    math: |formula| format!("<math>{formula}</math>"),
    heading: |heading| format!("<h2>{}</h2>\n", escape(heading)),
    paragraph: |line| format!("<p>{line}</p>\n"),
    equations: html_equations,
    table: html_table,
    picture: |svg, _| format!("<figure>{svg}</figure>\n"),
    folded: Some(|summary, body| format!("<details><summary>{}</summary>\n{body}</details>\n", escape(summary))),
};

impl DocumentFormat {
    fn body(&self, blocks: &[DocumentBlock]) -> String {
        let block = |block: &DocumentBlock| match block {
            DocumentBlock::Heading(heading) => (self.heading)(heading),
            DocumentBlock::Text(pieces) => {
                (self.paragraph)(&pieces.iter().map(|piece| self.piece(piece)).collect::<String>())
            }
            DocumentBlock::Equations(equations) => (self.equations)(self.rows(equations)),
            DocumentBlock::Table(table) => (self.table)(table),
            DocumentBlock::Picture(svg, option) => (self.picture)(svg, option),
            DocumentBlock::Folded(summary, blocks) => match self.folded {
                Some(folded) => folded(summary, &self.body(blocks)),
                None => (self.paragraph)(&(self.words)(&format!("({summary}: in html)"))),
            },
        };
        blocks.iter().map(block).collect()
    }

    fn piece(&self, piece: &Piece) -> String {
        match piece {
            Piece::Words(text) => (self.words)(text),
            Piece::Code(name) => (self.code)(name),
            Piece::Math(tree) => (self.math)(&self.notation.formula(tree)),
            Piece::Row(pieces) => pieces.iter().map(|piece| self.piece(piece)).collect(),
        }
    }

    fn width_of(&self, tree: &FormulaTree) -> f64 {
        (self.notation.width)(&FormulaPart::Whole(tree, Binding::Relation))
    }

    /// Equations with their left sides below each other; if one of these is wide, all equations are broken as a whole.
    fn rows(&self, equations: &[(FormulaTree, FormulaTree)]) -> Vec<DisplayRow> {
        let widest = equations.iter().map(|(left, _)| self.width_of(left)).fold(0.0, f64::max);
        let row = |(left, right): &(FormulaTree, FormulaTree)| match widest <= LEFT * self.width {
            true => DisplayRow {
                left: Some(self.notation.formula(left)),
                lines: self.notation.wrapped(right, self.width - widest - 4.0),
            },
            false => {
                let whole = FormulaTree::Relation("=", Box::new([left.clone(), right.clone()]));
                DisplayRow { left: None, lines: self.notation.wrapped(&whole, self.width) }
            }
        };
        equations.iter().map(row).collect()
    }
}

/// A row of a display: an aligned left side, and the lines of the rest.
struct DisplayRow {
    left: Option<String>,
    lines: Vec<String>,
}

impl DocumentBlock {
    /// A table under a heading that says what it shows.
    pub fn table(head: Vec<String>, rows: Vec<Vec<Piece>>) -> Self {
        DocumentBlock::Table(DocumentTable { caption: String::new(), head, rows })
    }

    /// The table with a caption.
    pub fn captioned(caption: impl Into<String>, head: Vec<String>, rows: Vec<Vec<Piece>>) -> Self {
        DocumentBlock::Table(DocumentTable { caption: caption.into(), head, rows })
    }
}

impl Piece {
    pub fn words(text: impl Into<String>) -> Self {
        Piece::Words(text.into())
    }

    /// Pieces with words between them.
    pub fn list(between: &str, pieces: impl Iterator<Item = Piece>) -> Piece {
        let gap = |index| (index > 0).then(|| Piece::words(between));
        Piece::Row(pieces.enumerate().flat_map(|(index, piece)| gap(index).into_iter().chain([piece])).collect())
    }

    /// In digits, printed.
    fn width(&self) -> f64 {
        match self {
            Piece::Words(text) => text.chars().count() as f64,
            Piece::Code(name) => 1.05 * name.chars().count() as f64,
            Piece::Math(tree) => DOCUMENT.width_of(tree),
            Piece::Row(pieces) => pieces.iter().map(Piece::width).sum(),
        }
    }
}

pub fn text(title: &str, blocks: &[DocumentBlock]) -> String {
    format!("{title}\n{}", TEXT.body(blocks))
}

fn text_equations(rows: Vec<DisplayRow>) -> String {
    let width = rows.iter().flat_map(|row| &row.left).map(|left| left.chars().count()).max().unwrap_or_default();
    let mut text = String::new();
    for row in rows {
        let Some(mut left) = row.left else {
            row.lines.iter().for_each(|line| text += &format!("  {line}\n"));
            continue;
        };
        let mut sign = "=";
        for line in row.lines {
            text += &format!("  {left:width$} {sign} {line}\n");
            sign = " ";
            left.clear();
        }
    }
    text
}

fn text_table(DocumentTable { caption, head, rows }: &DocumentTable) -> String {
    let caption = if caption.is_empty() { String::new() } else { format!("  {caption}:\n") };
    let cells = rows.iter().map(|row| row.iter().map(|cell| TEXT.piece(cell)).collect::<Vec<_>>());
    let lines: Vec<Vec<String>> = (!head.is_empty()).then(|| head.to_vec()).into_iter().chain(cells).collect();
    caption + &aligned(&lines, usize::MAX, "  ")
}

/// A page in LaTeX, ready to be compiled.
pub fn latex(title: &str, blocks: &[DocumentBlock]) -> String {
    let (title, body) = (latex::escape(title), DOCUMENT.body(blocks));
    let text = format!("\\begin{{document}}\n\\section*{{\\raggedright {title}}}\n{body}\\end{{document}}\n");
    let pictures = if body.contains("tikzpicture") { "\\usepackage{tikz}\n" } else { "" };
    let preamble = "\\documentclass[a4paper,10pt]{article}\n\\usepackage[margin=20mm]{geometry}\n\
                    \\usepackage{amsmath,array,longtable,lmodern}\n\\usepackage[T1]{fontenc}\n\\allowdisplaybreaks\n\
                    \\setlength{\\parindent}{0pt}\n";
    format!("{preamble}{pictures}{}{text}", unicode::declarations(&text))
}

fn latex_equations(rows: Vec<DisplayRow>) -> String {
    let row = |row: &DisplayRow| {
        // A blank ends the command: a line may begin with a letter.
        let lines: Vec<&str> = row.lines.iter().map(|line| line.trim_start()).collect();
        let lines = lines.join(" \\\\\n    &\\quad ");
        match &row.left {
            Some(left) => format!("  {left} &= {lines}"),
            None => format!("  &{lines}"),
        }
    };
    let rows: Vec<String> = rows.iter().map(row).collect();
    format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", rows.join(" \\\\\n"))
}

/// A table; a matrix that is wider than the page is cut into parts, of other tables the lines are broken within the cells.
fn latex_table(DocumentTable { caption, head, rows }: &DocumentTable) -> String {
    let columns = rows.iter().map(Vec::len).chain([head.len()]).max().unwrap_or_default();
    let widths: Vec<f64> = (0..columns).map(|column| column_width(head, rows, column)).collect();
    let total: f64 = widths.iter().sum();
    let all: Vec<usize> = (0..columns).collect();
    let is_matrix = widths.iter().skip(1).all(|&width| width <= NARROW);
    let caption = if caption.is_empty() {
        String::new()
    } else {
        format!("\\textbf{{{}}}\\nopagebreak\n\n", latex::escape(caption))
    };
    let table = if total <= PAGE_WIDTH {
        latex_columns(head, rows, &all, &"l".repeat(columns))
    } else if is_matrix {
        let part = |part: Vec<usize>| latex_columns(head, rows, &part, &"l".repeat(part.len()));
        parts(&widths, !head.is_empty()).into_iter().map(part).collect()
    } else {
        // What is narrow stays on its line; what is wide shares the rest.
        let wide: f64 = widths.iter().filter(|width| **width > NARROW).sum();
        let rest = (PAGE_WIDTH - (total - wide)).max(0.3 * PAGE_WIDTH) / PAGE_WIDTH;
        let cell = |width: &f64| match *width <= NARROW {
            true => "l".to_owned(),
            false => format!(">{{\\raggedright\\arraybackslash}}p{{{:.3}\\linewidth}}", 0.87 * rest * width / wide),
        };
        latex_columns(head, rows, &all, &widths.iter().map(cell).collect::<String>())
    };
    caption + &table
}

/// Wider cells are words, not entries of a matrix.
const NARROW: f64 = 16.0;
/// Longer cells may take several lines of a page in a browser.
const LONG: f64 = 32.0;
const GAP: f64 = 2.6;

fn column_width(head: &[String], rows: &[Vec<Piece>], column: usize) -> f64 {
    let cells = rows.iter().filter_map(|row| row.get(column)).map(Piece::width);
    let head = head.get(column).map(|cell| cell.chars().count() as f64);
    GAP + cells.chain(head).fold(0.0, f64::max)
}

/// Columns that fit on a page, each time after the first if that names the rows.
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

fn latex_columns(head: &[String], rows: &[Vec<Piece>], columns: &[usize], format: &str) -> String {
    let mut text = format!("\\begin{{longtable}}[l]{{{format}}}\n");
    if !head.is_empty() {
        let cells: Vec<String> =
            columns.iter().filter_map(|&column| head.get(column)).map(|cell| latex::escape(cell)).collect();
        text += &format!("{} \\\\ \\hline\\noalign{{\\smallskip}}\n", cells.join(" & "));
    }
    for row in rows {
        let cells = columns.iter().filter_map(|&column| row.get(column)).map(|cell| DOCUMENT.piece(cell));
        text += &format!("{} \\\\\n", cells.collect::<Vec<_>>().join(" & "));
    }
    text + "\\end{longtable}\n"
}

/// In the dark a picture is the negative of its white sheet, turned back to its hues.
const STYLE: &str = ":root{color-scheme:light dark;--text:#1f2933;--page:#fff;--soft:#f3f5f8;--link:#1d4ed8}\
@media (prefers-color-scheme:dark){:root{--text:#e8ecf1;--page:#0e1216;--soft:#1e262e;--link:#8ab8f5}\
figure svg{filter:invert(.93) hue-rotate(180deg)}}\
body{font:16px/1.5 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;color:var(--text);background:var(--page);max-width:72rem;\
margin:2rem auto;padding:0 1rem;overflow-wrap:break-word}h1{font-size:clamp(1.4rem,6vw,2rem);line-height:1.25}h2{line-height:1.3}\
code{font-size:.92em;background:var(--soft);padding:.1em .3em;border-radius:3px}\
p,details,figure{overflow-x:auto;overflow-y:hidden}figure{margin:1rem 0}figure svg{max-width:max(100%,36rem);height:auto}\
details{margin:.4rem 0}summary{cursor:pointer;color:var(--link)}@media print{:root{color-scheme:light}}";

/// Equations align at their signs; what is wide scrolls by itself, whatever page it is put into. A short cell stays on its line.
const BLOCK_STYLE: &str = ".equations,.table{overflow-x:auto;margin:.6rem 0}.equations mtd{text-align:left;padding:.25em .15em}\
.equations mtd:first-child{text-align:right}.table table{border-collapse:collapse;font-size:.92rem}\
.table caption{text-align:left;font-weight:600;padding:.3rem 0}.table th,.table td{text-align:left;white-space:nowrap;\
padding:.15rem .7rem;border-bottom:1px solid #8886}.table .long{white-space:normal;min-width:14rem}";

pub fn html(title: &str, blocks: &[DocumentBlock]) -> String {
    html_page(title, STYLE, &fragment(blocks))
}

/// A page of its own.
pub fn html_page(title: &str, style: &str, body: &str) -> String {
    let name = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{name}</title>\n\
         <style>{style}</style>\n</head>\n<body>\n<h1>{name}</h1>\n{body}</body>\n</html>\n"
    )
}

/// The same without the frame of a page, to be put into one.
pub fn fragment(blocks: &[DocumentBlock]) -> String {
    format!("<style>{BLOCK_STYLE}</style>\n{}", HTML.body(blocks))
}

fn html_equations(rows: Vec<DisplayRow>) -> String {
    let mut text = String::from("<div class=\"equations\"><math display=\"block\"><mtable>\n");
    for row in rows {
        let mut sign = if row.left.is_some() { "<mo>=</mo>" } else { "" };
        let mut left = row.left.unwrap_or_default();
        for line in row.lines {
            text += &format!("<mtr><mtd>{left}</mtd><mtd><mrow>{sign}{line}</mrow></mtd></mtr>\n");
            left.clear();
            sign = "";
        }
    }
    text + "</mtable></math></div>\n"
}

fn html_table(DocumentTable { caption, head, rows }: &DocumentTable) -> String {
    let mut text = String::from("<div class=\"table\"><table>\n");
    if !caption.is_empty() {
        text += &format!("<caption>{}</caption>\n", escape(caption));
    }
    if !head.is_empty() {
        let cells: String = head.iter().map(|cell| format!("<th>{}</th>", escape(cell))).collect();
        text += &format!("<tr>{cells}</tr>\n");
    }
    let cell = |cell: &Piece| {
        let class = if cell.width() > LONG { " class=\"long\"" } else { "" };
        format!("<td{class}>{}</td>", HTML.piece(cell))
    };
    for row in rows {
        text += &format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
    }
    text + "</table></div>\n"
}
