//! A grammar's text as words, numbers and signs, each with its place.

use crate::document::{Document, DocumentError};

/// A piece of text that means something.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    /// Letters, digits and underscores, a letter first.
    Word(String),
    /// Not negative, finite.
    Number(f32),
    /// What stands between quotes, on one line.
    Text(String),
    /// One or two signs.
    Sign(&'static str),
    /// Nothing more.
    End,
}

/// A token and the byte at which it begins.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placed {
    pub(super) token: Token,
    pub(super) offset: usize,
}

/// All signs; those of two characters first, since they begin like others.
const SIGNS: [&str; 29] = [
    "->", "<=", ">=", "==", "!=", "(", ")", "[", "]", "{", "}", ",", ":", "=", "<", ">", "+", "-",
    "*", "/", "&", "^", "\\", "|", "$", "!", "~", "@", ".",
];

/// All tokens of a document, [`Token::End`] last; `#` begins a comment.
pub(super) fn tokens(document: &Document) -> Result<Vec<Placed>, DocumentError> {
    let text = document.text.as_str();
    let mut tokens = Vec::new();
    let mut offset = 0;
    while let Some(first) = text[offset..].chars().next() {
        let rest = &text[offset..];
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if first == '#' {
            span(rest, |c| c != '\n')
        } else {
            let (token, length) = token(document, offset, rest, first)?;
            tokens.push(Placed { token, offset });
            length
        };
        offset += length;
    }
    let token = Token::End;
    tokens.push(Placed { token, offset });
    Ok(tokens)
}

/// The token that a text begins with, and its length.
fn token(
    document: &Document,
    offset: usize,
    rest: &str,
    first: char,
) -> Result<(Token, usize), DocumentError> {
    if first.is_ascii_alphabetic() {
        let length = span(rest, |c| c.is_ascii_alphanumeric() || c == '_');
        return Ok((Token::Word(rest[..length].to_owned()), length));
    }
    if first.is_ascii_digit() {
        let length = span(rest, |c| c.is_ascii_alphanumeric() || c == '.');
        let digits = &rest[..length];
        let number = digits
            .parse::<f32>()
            .ok()
            .filter(|number| number.is_finite());
        return match number {
            Some(number) => Ok((Token::Number(number), length)),
            None => {
                let message = format!("{digits:?} is no number, wanted one such as 12 or 0.75");
                Err(document.error(offset, message))
            }
        };
    }
    if first == '"' {
        let inside = &rest[1..];
        let length = span(inside, |c| c != '"' && c != '\n');
        return if inside[length..].starts_with('"') {
            Ok((Token::Text(inside[..length].to_owned()), length + 2))
        } else {
            Err(document.error(offset, "a text without its end, wanted \" on the same line"))
        };
    }
    let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
    sign.map(|sign| (Token::Sign(sign), sign.len()))
        .ok_or_else(|| {
            let message = format!("{first:?} means nothing here; comments begin with #");
            document.error(offset, message)
        })
}

/// How many bytes of a text, from its beginning, are characters of a kind.
fn span(text: &str, is_of_kind: impl Fn(char) -> bool) -> usize {
    text.find(|c| !is_of_kind(c)).unwrap_or(text.len())
}

impl Token {
    /// As it is named in errors.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Word(word) => format!("{word:?}"),
            Self::Number(number) => number.to_string(),
            Self::Text(text) => format!("the text {text:?}"),
            Self::Sign(sign) => format!("{sign:?}"),
            Self::End => "the end of the file".to_owned(),
        }
    }
}
