//! Lines and words of a certificate. Nothing is allocated by a count that the file states.

use super::interval::point;
use super::scene::{Point, Pose, rotation};

/// Greatest magnitude of a number.
pub const LARGEST: f64 = 1e6;

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

/// Certificate that is read line by line, each word by word.
pub struct Lines<'a> {
    text: &'a str,
    /// First byte of the present line, that after it, and its number from 1.
    pub begin: usize,
    end: usize,
    pub number: usize,
    /// Words of the line that are not read yet.
    words: std::str::Split<'a, char>,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a str) -> Self {
        let mut lines = Self { text, begin: 0, end: 0, number: 0, words: "".split(' ') };
        lines.advance();
        lines
    }

    /// Goes to the next line; one without an end, and that after the last one, are empty.
    fn advance(&mut self) {
        let line = self.text[self.end..].split_inclusive('\n').next().unwrap_or_default();
        (self.begin, self.number) = (self.end, self.number + 1);
        self.end += line.len();
        self.words = line.strip_suffix('\n').unwrap_or_default().split(' ');
    }

    /// Returns true if the present line begins with this word.
    pub fn is(&self, kind: &str) -> bool {
        self.words.clone().next() == Some(kind)
    }

    /// Returns the text from this byte to the present line.
    pub fn since(&self, begin: usize) -> &'a str {
        &self.text[begin..self.begin]
    }

    pub fn is_at_end(&self) -> bool {
        self.begin == self.text.len()
    }

    /// Reads a line that begins with this word.
    pub fn read<T>(&mut self, kind: &str, words: impl FnOnce(&mut Self) -> Checked<T>) -> Checked<T> {
        if self.words.next() != Some(kind) {
            return Err(format!("a line `{kind}` is missing here, or this one is of no known kind"));
        }
        let value = words(self)?;
        unless(self.words.next().is_none(), "more words, or marks, than expected")?;
        self.advance();
        Ok(value)
    }

    pub fn word(&mut self) -> Checked<&'a str> {
        let is_word = |word: &&str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_graphic());
        let reason = || "a word, or mark, is missing, or not of printable ASCII characters".to_owned();
        self.words.next().filter(is_word).ok_or_else(reason)
    }

    pub fn number(&mut self) -> Checked<f64> {
        let word = self.word()?;
        let number = word.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST && word.len() <= 32);
        number.ok_or_else(|| "a number that is none, or too large".to_owned())
    }

    pub fn point(&mut self) -> Checked<Point> {
        Ok([self.number()?, self.number()?, self.number()?])
    }

    pub fn size(&mut self) -> Checked<f64> {
        self.number().and_then(|size| unless(size >= 0.0, "a size is not negative").map(|()| size))
    }

    /// Reads one value for each joint.
    pub fn values(&mut self, joints: usize) -> Checked<Vec<f64>> {
        (0..joints).map(|_| self.number()).collect()
    }

    pub fn index(&mut self, below: usize) -> Checked<usize> {
        let word = self.word()?;
        let index = word.parse().ok().filter(|index: &usize| *index < below && index.to_string() == word);
        index.ok_or_else(|| "an index out of range".to_owned())
    }

    pub fn pose(&mut self) -> Checked<Pose> {
        let translation = self.point()?.map(point);
        let quaternion = [self.number()?, self.number()?, self.number()?, self.number()?];
        has_size(&quaternion)?;
        Ok(Pose { rotation: rotation(quaternion.map(point)), translation })
    }
}
