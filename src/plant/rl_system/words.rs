//! One token after another, of the kind that is wanted; or an error at its place.

use super::lexer::{Placed, Token};
use super::read::Reader;
use crate::document::DocumentError;
use crate::limits;

impl Reader<'_> {
    pub(super) fn peek(&self) -> &Placed {
        &self.tokens[self.next.min(self.tokens.len() - 1)]
    }

    pub(super) fn take(&mut self) -> Placed {
        let placed = self.peek().clone();
        self.next += 1;
        placed
    }

    pub(super) fn accepts(&mut self, sign: &str) -> bool {
        let found = matches!(&self.peek().token, Token::Sign(found) if *found == sign);
        self.next += usize::from(found);
        found
    }

    pub(super) fn sign(&mut self, sign: &str) -> Result<(), DocumentError> {
        if self.accepts(sign) {
            return Ok(());
        }
        Err(self.wanted(&format!("{sign:?}")))
    }

    pub(super) fn word(&mut self, word: &str) -> Result<(), DocumentError> {
        match &self.peek().token {
            Token::Word(found) if found == word => {
                self.next += 1;
                Ok(())
            }
            _ => Err(self.wanted(&format!("{word:?}"))),
        }
    }

    pub(super) fn any_word(&mut self, what: &str) -> Result<(usize, String), DocumentError> {
        match self.peek().clone() {
            Placed {
                token: Token::Word(word),
                offset,
            } => {
                self.next += 1;
                Ok((offset, word))
            }
            _ => Err(self.wanted(what)),
        }
    }

    pub(super) fn text(&mut self) -> Result<(usize, String), DocumentError> {
        match self.peek().clone() {
            Placed {
                token: Token::Text(text),
                offset,
            } if text.chars().count() <= limits::TEXT_CHARACTERS => {
                self.next += 1;
                Ok((offset, text))
            }
            _ => Err(self.wanted(&format!(
                "a text in quotes of at most {} characters",
                limits::TEXT_CHARACTERS
            ))),
        }
    }

    pub(super) fn number(&mut self, what: &str, low: f32, high: f32) -> Result<f32, DocumentError> {
        match self.peek().token {
            Token::Number(found) if (low..=high).contains(&found) => {
                self.next += 1;
                Ok(found)
            }
            _ => Err(self.wanted(&format!("{what} as a number from {low} to {high}"))),
        }
    }

    pub(super) fn whole(&mut self, what: &str, low: u32, high: u32) -> Result<u32, DocumentError> {
        let wanted = format!("{what} as a whole number from {low} to {high}");
        match self.peek().token {
            Token::Number(found) => {
                let whole = crate::math::whole_u32(f64::from(found));
                let is_whole = f64::from(whole).total_cmp(&f64::from(found)).is_eq();
                if !is_whole || !(low..=high).contains(&whole) {
                    return Err(self.wanted(&wanted));
                }
                self.next += 1;
                Ok(whole)
            }
            _ => Err(self.wanted(&wanted)),
        }
    }

    pub(super) fn color(&mut self) -> Result<[u8; 3], DocumentError> {
        let (offset, text) = self.text()?;
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        let all_hexadecimal = |digits: &&str| digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        let value = digits
            .filter(all_hexadecimal)
            .and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let Some(value) = value else {
            let message = format!("color is {text:?}, wanted \"#rrggbb\"");
            return Err(self.document.error(offset, message));
        };
        let [_, red, green, blue] = value.to_be_bytes();
        Ok([red, green, blue])
    }

    pub(super) fn unknown_key(&self, offset: usize, key: &str, wanted: &str) -> DocumentError {
        self.document
            .error(offset, format!("{key} is no key here, wanted {wanted}"))
    }

    pub(super) fn wanted(&self, what: &str) -> DocumentError {
        let Placed { token, offset } = self.peek();
        self.document
            .error(*offset, format!("{} found, wanted {what}", token.shown()))
    }
}
