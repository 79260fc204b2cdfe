//! Names and what there is to say of them, wrapped to the terminal.

use crate::report::grouped;

/// Columns of names.
const NAMES: usize = 11;

/// Lines of a name and words.
#[derive(Debug)]
pub(super) struct Facts {
    width: usize,
    text: String,
}

impl Facts {
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            text: String::new(),
        }
    }

    /// A name and a sentence, its words whole; further lines begin below the first word.
    pub(super) fn add(&mut self, name: &str, sentence: impl AsRef<str>) {
        self.hang(format!("{name:NAMES$}"), NAMES, sentence.as_ref());
    }

    /// A sentence of one side, `A` or `B`, below the sentence before.
    pub(super) fn side(&mut self, side: &str, sentence: impl AsRef<str>) {
        let start = format!("{}{side}: ", " ".repeat(NAMES));
        self.hang(start, NAMES + 3, sentence.as_ref());
    }

    fn hang(&mut self, start: String, indent: usize, sentence: &str) {
        let mut line = start;
        let mut column = indent;
        let mut first = true;
        for word in sentence.split(' ') {
            let length = word.chars().count();
            if !first && column + 1 + length > self.width {
                self.end(&line);
                line = " ".repeat(indent);
                column = indent;
                first = true;
            }
            if !first {
                line.push(' ');
                column += 1;
            }
            line.push_str(word);
            column += length;
            first = false;
        }
        self.end(&line);
    }

    /// A line as it is, indented like a sentence, cut where the terminal ends.
    pub(super) fn row(&mut self, row: &str) {
        self.indented(NAMES, row);
    }

    /// The same for a line that needs the room.
    pub(super) fn wide_row(&mut self, row: &str) {
        self.indented(2, row);
    }

    fn indented(&mut self, indent: usize, row: &str) {
        let room = self.width.saturating_sub(indent).max(1);
        let mut cut: String = row.chars().take(room).collect();
        if cut.len() < row.len() {
            cut.pop();
            cut.push('…');
        }
        self.end(&format!("{}{cut}", " ".repeat(indent)));
    }

    /// Says how many more there are than were listed.
    pub(super) fn more(&mut self, all: u64, listed: usize) {
        let more = all.saturating_sub(listed as u64);
        if more > 0 {
            self.row(&format!("… and {more} more"));
        }
    }

    pub(super) fn blank(&mut self) {
        self.text.push('\n');
    }

    pub(super) fn text(self) -> String {
        self.text
    }

    fn end(&mut self, line: &str) {
        self.text += line.trim_end();
        self.text.push('\n');
    }
}

/// `1 range`, `2 ranges`: a count with its noun.
pub(super) fn counted(count: u64, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(count, ","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_hang_below_their_first_word() {
        let mut facts = Facts::new(24);
        facts.add("leaf 7", "made by collapse 3");
        facts.row("0123456789abcdef");
        facts.more(22, 20);
        assert_eq!(
            facts.text(),
            "leaf 7     made by\n           collapse 3\n           0123456789ab…\n           … and 2 more\n"
        );
    }
}
