//! How a fault looks in a terminal: its code, its message, the lines it is about with what is wrong below them, and what to do.

use std::fmt::Write;

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

use super::span::{Source, Span};

/// A line longer than this on either side of what is wrong is shown in part only \[bytes\].
const LONGEST_LINE: usize = 400;
/// Tabs go to the next multiple of so many columns.
const TAB: usize = 4;

/// Colours of a terminal, by their numbers in ECMA-48, 8.3.117 (SGR).
const ERROR: &str = "31";
const WARNING: &str = "33";
const HELP: &str = "36";
const PLACE: &str = "36;1;4";
const NUMBER: &str = "2";
const LABELS: [&str; 3] = ["35;1", "33;1", "32;1"];

/// A fault as it is shown: every text is fit for a terminal.
pub(super) struct Shown<'a> {
    pub is_error: bool,
    pub code: &'a str,
    pub message: &'a str,
    pub help: &'a str,
    pub source: &'a Source,
    /// What is written below the text, the main one first.
    pub labels: Vec<Label>,
}

/// What is wrong with a part of the text.
pub(super) struct Label {
    pub span: Span,
    pub text: String,
}

/// A terminal of so many columns, with colours or without.
#[derive(Clone, Copy)]
pub(super) struct Terminal {
    pub colour: bool,
    pub width: usize,
}

/// A line of the text, without its end, or what is shown of it.
struct Line<'t> {
    number: usize,
    start: usize,
    text: &'t str,
}

impl Terminal {
    pub fn show(self, out: &mut String, shown: &Shown) {
        let (colour, sign) = if shown.is_error { (ERROR, '×') } else { (WARNING, '⚠') };
        let (code, sign, bar) = (self.paint(shown.code, colour), self.paint(sign, colour), self.paint('│', colour));
        let width = self.width.saturating_sub(2);
        let _ = write!(out, "{code}\n\n"); // writing to a string cannot fail, here and below
        out.push_str(&wrapped(shown.message, width, [&format!("  {sign} "), &format!("  {bar} ")], 4));
        for (lines, labels) in contexts(&shown.source.text, &shown.labels) {
            self.show_lines(out, shown, &lines, &labels);
        }
        if !shown.help.is_empty() {
            let head = self.paint("  help: ", HELP);
            out.push_str(&wrapped(shown.help, width, [&head, "        "], 8));
        }
    }

    /// Lines that follow each other, each with what is wrong below it.
    fn show_lines(self, out: &mut String, shown: &Shown, lines: &[Line], labels: &[usize]) {
        let width = lines.last().map_or(1, |line| line.number.to_string().len());
        let margin = " ".repeat(width + 2);
        let main = labels.iter().min().map_or(0, |&index| shown.labels[index].span.start);
        let before = &shown.source.text[..shown.source.text.floor_char_boundary(main)];
        let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count());
        let place = format!("{}:{}:{}", shown.source.name, before.matches('\n').count() + 1, column + 1);
        let _ = writeln!(out, "{margin}╭─[{}]", self.paint(&place, PLACE));
        for (index, line) in lines.iter().enumerate() {
            let number = self.paint(format!("{:>width$}", line.number), NUMBER);
            let _ = writeln!(out, " {number} │ {}", expanded(line.text));
            let next = lines.get(index + 1).map_or(usize::MAX, |next| next.start);
            let here = |&&label: &&usize| (line.start..next).contains(&shown.labels[label].span.start);
            let in_line: Vec<usize> = labels.iter().filter(here).copied().collect();
            self.show_labels(out, shown, line, (&in_line, width));
        }
        let _ = writeln!(out, "{margin}╰────");
    }

    /// Underlines the labels of a line, and writes their texts below, the last one first.
    fn show_labels(self, out: &mut String, shown: &Shown, line: &Line, (labels, width): (&[usize], usize)) {
        if labels.is_empty() {
            return;
        }
        let margin = format!(" {:width$} · ", "");
        let (mut underlines, mut highest, mut stems) = (String::new(), 0, Vec::new());
        for &index in labels {
            let Label { span, text } = &shown.labels[index];
            let start = line.column(span.start).max(highest);
            let end = line.column(span.end).max(start + 1);
            let stem = usize::midpoint(start, end);
            let sign = match (span.start == span.end, text.is_empty()) {
                (true, _) => '▲',
                (false, false) => '┬',
                (false, true) => '─',
            };
            let (left, right) = ("─".repeat(stem - start), "─".repeat(end - stem - 1));
            let line = self.paint(format!("{left}{sign}{right}"), colour_of(index));
            let _ = write!(underlines, "{}{line}", " ".repeat(start - highest));
            highest = end;
            stems.push((index, stem));
        }
        let _ = writeln!(out, "{margin}{underlines}");
        for (count, &(index, stem)) in stems.iter().enumerate().rev() {
            let text = &shown.labels[index].text;
            if text.is_empty() {
                continue;
            }
            let (mut row, mut at) = (String::new(), 0);
            for &(other, stem) in &stems[..count] {
                let _ = write!(row, "{}{}", " ".repeat(stem - at), self.paint('│', colour_of(other)));
                at = stem + 1;
            }
            let text = self.paint(format!("╰── {text}"), colour_of(index));
            let _ = writeln!(out, "{margin}{row}{}{text}", " ".repeat(stem - at));
        }
    }

    fn paint(self, text: impl std::fmt::Display, colour: &str) -> String {
        if self.colour { format!("\u{1b}[{colour}m{text}\u{1b}[0m") } else { text.to_string() }
    }
}

fn colour_of(label: usize) -> &'static str {
    LABELS[label % LABELS.len()]
}

/// The lines with labels, each with the one above and the one below it, in parts that follow each other; and which labels are in each, from left to right.
fn contexts<'t>(text: &'t str, labels: &[Label]) -> Vec<(Vec<Line<'t>>, Vec<usize>)> {
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    // What comes after the last line end is a line only if there is something.
    let count = starts.len() - usize::from(starts.len() > 1 && text.ends_with('\n'));
    let line_of = |place: usize| starts[..count].partition_point(|&start| start <= place).saturating_sub(1);
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by_key(|&index| labels[index].span.start);
    let mut parts: Vec<(std::ops::Range<usize>, Vec<usize>)> = Vec::new();
    for index in order {
        let line = line_of(labels[index].span.start);
        let (first, last) = (line.saturating_sub(1), (line + 2).min(count));
        match parts.last_mut() {
            // A single line between two of them is shown, too.
            Some((lines, in_block)) if first <= lines.end + 1 => {
                lines.end = lines.end.max(last);
                in_block.push(index);
            }
            _ => parts.push((first..last, vec![index])),
        }
    }
    let line = |number: usize, members: &[usize]| {
        let (start, end) = (starts[number], starts.get(number + 1).copied().unwrap_or(text.len()));
        let (start, end) = near((start, end), members.iter().map(|&index| labels[index].span), text);
        Line { number: number + 1, start, text: text[start..end].trim_end_matches(['\n', '\r']) }
    };
    parts.into_iter().map(|(lines, members)| (lines.map(|number| line(number, &members)).collect(), members)).collect()
}

/// Of a very long line what is near the spans in it, or its beginning.
fn near((start, end): (usize, usize), spans: impl Iterator<Item = Span>, text: &str) -> (usize, usize) {
    let nearby: Vec<Span> = spans.filter(|span| (start..end).contains(&span.start)).collect();
    let first = nearby.iter().map(|span| span.start).min().unwrap_or(start);
    let last = nearby.iter().map(|span| span.end).max().unwrap_or(start).min(end);
    let from = text.floor_char_boundary(first.saturating_sub(LONGEST_LINE)).max(start);
    (from, text.ceil_char_boundary(last.max(first) + LONGEST_LINE).min(end))
}

impl Line<'_> {
    /// In which column a place of the text is shown; what lies behind the line is one column behind it.
    fn column(&self, place: usize) -> usize {
        let at = place.saturating_sub(self.start);
        match self.text.get(..self.text.floor_char_boundary(at)) {
            Some(before) if at <= self.text.len() => expanded(before).width(),
            _ => expanded(self.text).width() + 1,
        }
    }
}

/// Tabs as spaces.
fn expanded(text: &str) -> String {
    let mut wide = String::with_capacity(text.len());
    let mut column = 0;
    for c in text.chars() {
        let width = if c == '\t' { TAB - column % TAB } else { c.width().unwrap_or(0) };
        if c == '\t' {
            wide.extend(std::iter::repeat_n(' ', width))
        } else {
            wide.push(c)
        }
        column += width;
    }
    wide
}

/// Lines of words up to a width, the first one with its own indent; both take so many columns.
fn wrapped(text: &str, width: usize, [first, further]: [&str; 2], indent: usize) -> String {
    let room = width.saturating_sub(indent).max(1);
    let mut lines: Vec<String> = Vec::new();
    for paragraph in text.split('\n') {
        let (mut line, mut words) = (String::new(), 0);
        for mut word in paragraph.split(' ') {
            if words > 0 && line.width() + 1 + word.width() > room {
                lines.push(std::mem::take(&mut line));
            } else if words > 0 {
                line.push(' ');
            }
            words += 1;
            // One that is longer than a line goes over several.
            while word.width() > room {
                let mut wide = 0;
                let is_beyond = |&(at, c): &(usize, char)| {
                    wide += c.width().unwrap_or(0);
                    wide > room && at > 0
                };
                let cut = word.char_indices().find(is_beyond).map_or(word.len(), |(at, _)| at);
                lines.push(word[..cut].to_owned());
                word = &word[cut..];
            }
            line.push_str(word);
        }
        lines.push(line);
    }
    let indents = std::iter::once(first).chain(std::iter::repeat(further));
    lines.iter().zip(indents).map(|(line, indent)| format!("{}\n", format!("{indent}{line}").trim_end())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, labels: &[(&str, &str)], message: &str, colour: bool) -> String {
        let place = |part: &str| {
            let start = text.find(part).unwrap();
            Span::new(start, start + part.len())
        };
        let labels = labels.iter().map(|(part, text)| Label { span: place(part), text: (*text).to_owned() }).collect();
        let source = Source::new("a.toml", text);
        let fault =
            Shown { is_error: true, code: "scene::unknown_key", message, help: "do it", source: &source, labels };
        let mut out = String::new();
        Terminal { colour, width: 40 }.show(&mut out, &fault);
        out
    }

    #[test]
    fn what_is_wrong_stands_below_its_text() {
        let text = "one = 1\n\ttwo = 漢字 bad worse\r\nthree = 3\n";
        let expected = "scene::unknown_key\n\n  × it is odd\n   ╭─[a.toml:2:11]\n 1 │ one = 1\n 2 │     two = 漢字 bad worse\n   ·                ─┬─ ──┬──\n   ·                 │    ╰── here too\n   ·                 ╰── no\n 3 │ three = 3\n   ╰────\n  help: do it\n";
        assert_eq!(shown(text, &[("bad", "no"), ("worse", "here too")], "it is odd", false), expected);
        let coloured = shown(text, &[("bad", "no"), ("worse", "here too")], "it is odd", true);
        let plain = coloured.split('\u{1b}').map(|part| part.split_once('m').map_or(part, |(_, rest)| rest));
        // The first part has no colour before it.
        assert!(coloured.starts_with("\u{1b}[31mscene::unknown_key\u{1b}[0m\n"));
        assert_eq!(plain.collect::<String>(), expected);
    }

    #[test]
    fn lines_between_places_are_left_out_but_single_ones() {
        let lines: String = (1..=12).map(|line| format!("line{line} = {line}\n")).collect();
        let found = shown(&lines, &[("line2", "no"), ("line10", "here too")], "odd", false);
        assert!(found.contains("[a.toml:2:1]\n 1 │ line1 = 1\n 2 │ line2 = 2\n"), "{found}");
        assert!(
            found.contains("[a.toml:10:1]\n  9 │ line9 = 9\n 10 │ line10 = 10\n") && !found.contains("line5"),
            "{found}"
        );
        let near = shown(&lines, &[("line2", "no"), ("line6", "here too")], "odd", false);
        assert!(near.contains(" 4 │ line4 = 4\n") && near.matches("╭─").count() == 1, "{near}");
    }

    #[test]
    fn messages_are_broken_between_words_and_words_where_they_must() {
        let message = format!("a message of several words and {}\n  indented", "x".repeat(70));
        let found = shown("", &[], &message, false);
        let lines: Vec<&str> = found.lines().collect();
        assert_eq!(lines[2], "  × a message of several words and");
        assert_eq!(
            lines[3..6].iter().map(|line| line.trim_start_matches("  │ ").len()).collect::<Vec<_>>(),
            [34, 34, 2]
        );
        assert_eq!(lines[6], "  │   indented");
        assert!(lines.iter().all(|line| line.width() <= 38));
    }

    #[test]
    fn of_a_very_long_line_the_part_is_shown_that_is_wrong() {
        let text = format!("{}bad{}\n", "é".repeat(5000), "x".repeat(5000));
        let found = shown(&text, &[("bad", "no")], "odd", false);
        assert!(found.contains("[a.toml:1:5001]") && found.contains("bad") && found.len() < 3000, "{}", found.len());
    }
}
