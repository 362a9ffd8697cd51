//! Tags: they tell which command an answer belongs to.

use std::fmt;

/// Tag of a command and of its answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tag {
    /// `00001` to `99999`: commands that wait for their turn.
    Number(u32),
    /// `E0001` to `E9999`: commands that are done at once. `E0000`: messages that nobody asked for.
    Event(u16),
}

impl Tag {
    /// Tag of messages that nobody asked for.
    pub const UNASKED: Tag = Tag::Event(0);

    /// The tag in five bytes; `None` where they are none, as `00000`.
    pub fn parse(bytes: &[u8]) -> Option<Tag> {
        let digits = |bytes: &[u8]| {
            let all = bytes.iter().all(u8::is_ascii_digit);
            all.then(|| bytes.iter().fold(0_u32, |sum, byte| sum * 10 + u32::from(byte - b'0')))
        };
        match bytes {
            [b'E', number @ ..] if number.len() == 4 => {
                Some(Tag::Event(u16::try_from(digits(number)?).ok()?))
            }
            number if number.len() == 5 => {
                digits(number).filter(|&number| number > 0).map(Tag::Number)
            }
            _ => None,
        }
    }
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tag::Number(number) => write!(f, "{number:05}"),
            Tag::Event(number) => write!(f, "E{number:04}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_read_as_they_are_written() {
        for tag in [Tag::Number(1), Tag::Number(99_999), Tag::UNASKED, Tag::Event(9999)] {
            assert_eq!(Tag::parse(tag.to_string().as_bytes()), Some(tag));
        }
        for strange in ["00000", "0001", "E001", "E00001", "e0001", "-0001", "+0001", "", "1E001"] {
            assert_eq!(Tag::parse(strange.as_bytes()), None, "{strange}");
        }
    }
}
