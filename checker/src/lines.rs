//! Lines and words of a certificate. Nothing is allocated by a count that the file states.

use super::interval::point;
use super::scene::{Point, Pose, rotation};

/// Greatest magnitude of a number.
pub const LARGEST: f64 = 1e6;

/// Greatest size of a certificate, in bytes, with repeated lines in their place.
const MOST_BYTES: usize = 64 << 20;

/// Maximum number of lines, likewise; it limits the memory.
const MOST_LINES: usize = 4_000_000;

/// Result of a check: a value, or the reason why a line fails.
pub type Checked<T = ()> = Result<T, String>;

pub fn unless(holds: bool, reason: &str) -> Checked {
    if holds { Ok(()) } else { Err(reason.to_owned()) }
}

/// Checks the greatest number of a quaternion or a direction.
pub fn has_size(numbers: &[f64]) -> Checked {
    let most = numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    unless((1e-3..=1e3).contains(&most), "a quaternion or a direction that is too short or too long")
}

/// Certificate that is read line by line, each word by word. A line `= FROM COUNT` stands for lines before it.
pub struct Lines<'a> {
    text: &'a str,
    /// First byte of each line of the file up to the present one, or that which repeats it; and of the next one.
    pub starts: Vec<usize>,
    end: usize,
    /// Lines of the file, from 0, that are still to be repeated.
    again: std::ops::Range<usize>,
    /// Lines that were read, and the present one, each with its end; and their size.
    read: Vec<&'a str>,
    size: usize,
    /// Words of the line that are not read yet.
    words: std::str::Split<'a, char>,
}

impl<'a> Lines<'a> {
    /// Begins before the first line.
    pub fn new(text: &'a str) -> Self {
        Self { text, starts: vec![], end: 0, again: 0..0, read: vec![], size: 0, words: "".split(' ') }
    }

    /// Goes to the next line; one without an end, and that after the last one, are empty. A repeated line that repeats others
    /// is of no known kind.
    pub fn advance(&mut self) -> Checked {
        if self.again.is_empty() {
            let (line, number) = (self.line_at(self.end), self.starts.len() + 1);
            self.again = number - 1..number;
            self.starts.push(self.end);
            self.end += line.len();
            if let Some(words) = line.strip_prefix("= ") {
                self.words = words.trim_end_matches('\n').split(' ');
                const FAULT: &str = "FROM and COUNT of lines to repeat that are all before are expected";
                let mut next = || self.index(number).map_err(|_| FAULT.to_owned());
                let (from, count) = (next()?, next()?);
                let is_before = self.words.next().is_none() && from > 0 && from + count <= number;
                unless(is_before && count > 0, FAULT)?;
                self.again = from - 1..from - 1 + count;
            }
        }
        let line = self.again.next().map_or("", |index| self.line_at(self.starts[index]));
        self.size += line.len();
        self.read.push(line);
        let is_small = self.size <= MOST_BYTES && self.read.len() <= MOST_LINES;
        unless(is_small, "more text than a certificate may have, with repeated lines")?;
        self.words = line.strip_suffix('\n').unwrap_or_default().split(' ');
        Ok(())
    }

    fn line_at(&self, start: usize) -> &'a str {
        self.text[start..].split_inclusive('\n').next().unwrap_or_default()
    }

    /// Returns the index of the present line among those that were read, from 0.
    pub fn at(&self) -> usize {
        self.read.len() - 1
    }

    /// Returns true if the present line begins with this word.
    pub fn is(&self, kind: &str) -> bool {
        self.words.clone().next() == Some(kind)
    }

    /// Returns the text from this line that was read up to the present one.
    pub fn since(&self, begin: usize) -> String {
        self.read[begin..self.at()].concat()
    }

    pub fn is_at_end(&self) -> bool {
        self.read.last() == Some(&"")
    }

    /// Reads a line that begins with this word.
    pub fn read<T>(&mut self, kind: &str, words: impl FnOnce(&mut Self) -> Checked<T>) -> Checked<T> {
        if self.words.next() != Some(kind) {
            return Err(format!("a line `{kind}` is missing here, or this one is of no known kind"));
        }
        let value = words(self)?;
        unless(self.words.next().is_none(), "more words, or marks, than expected")?;
        self.advance().map(|()| value)
    }

    pub fn word(&mut self) -> Checked<&'a str> {
        let is_word = |word: &&str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_graphic());
        let reason = || "a word, or mark, is missing, or not of printable ASCII characters".to_owned();
        self.words.next().filter(is_word).ok_or_else(reason)
    }

    pub fn real(&mut self) -> Checked<f64> {
        self.word().and_then(Self::parsed)
    }

    pub fn parsed(word: &str) -> Checked<f64> {
        let number = word.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST && word.len() <= 32);
        number.ok_or_else(|| "a number that is none, or too large".to_owned())
    }

    pub fn point(&mut self) -> Checked<Point> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    pub fn size(&mut self) -> Checked<f64> {
        self.real().and_then(|size| unless(size >= 0.0, "a size is not negative").map(|()| size))
    }

    /// Reads one value for each joint.
    pub fn values(&mut self, joints: usize) -> Checked<Vec<f64>> {
        (0..joints).map(|_| self.real()).collect()
    }

    pub fn index(&mut self, below: usize) -> Checked<usize> {
        self.word().and_then(|word| Self::whole(word, below))
    }

    /// Reads a whole number in its shortest form.
    pub fn whole(word: &str, below: usize) -> Checked<usize> {
        let index = word.parse().ok().filter(|index: &usize| *index < below && index.to_string() == word);
        index.ok_or_else(|| "an index out of range".to_owned())
    }

    pub fn pose(&mut self) -> Checked<Pose> {
        let translation = self.point()?.map(point);
        let quaternion = [self.real()?, self.real()?, self.real()?, self.real()?];
        has_size(&quaternion)?;
        Ok(Pose { rotation: rotation(quaternion.map(point)), translation })
    }
}
