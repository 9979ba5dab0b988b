use std::fmt;
use std::hint::black_box;

/// Secret of the user of a server: 128 random bits of the operating system, as hexadecimal digits. It is included in the address
/// of the server, because every user of a machine can open its ports.
#[derive(Clone)]
pub(crate) struct Token(String);

/// Size in bytes: enough that the token cannot be guessed.
const BYTES: usize = 16;

impl Token {
    /// # Errors
    /// Returns an error if the system has no random numbers.
    pub fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(
            bytes
                .iter()
                .flat_map(|byte| [byte >> 4, byte & 15])
                .filter_map(|half| char::from_digit(half.into(), 16))
                .collect(),
        ))
    }

    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns true if `other` is this token. The comparison takes constant time for equal lengths.
    pub fn is(&self, other: &str) -> bool {
        let pairs = self.0.bytes().zip(other.bytes());
        let difference = pairs.fold(0, |sum: u8, (a, b)| black_box(sum | (a ^ b)));
        self.0.len() == other.len() && difference == 0
    }
}

/// Omits the token itself, which would otherwise appear in logs.
impl fmt::Debug for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_token_itself_is_it() {
        let token = Token::random().expect("random numbers");
        let text = token.text().to_owned();
        assert_eq!(text.len(), 2 * BYTES);
        assert!(token.is(&text));
        let longer = format!("{text}0");
        let last = if text.ends_with('0') { '1' } else { '0' };
        let other = format!("{}{last}", &text[..text.len() - 1]);
        for wrong in ["", "0", &text[1..], &text[..text.len() - 1], &longer, &other, &text.to_uppercase()] {
            assert!(wrong == text || !token.is(wrong), "{wrong}");
        }
        assert_ne!(Token::random().expect("random numbers").text(), text);
        assert!(!format!("{token:?}").contains(&text));
    }
}
