//! What came on a connection before any device of it was known to be there, in words for who looks for the mistake.

/// Bytes of a connection that were no telegram of any of its devices.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Heard {
    bytes: u64,
    printable: u64,
}

impl Heard {
    pub(super) fn take(&mut self, bytes: &[u8]) {
        let is_text = |byte: &&u8| matches!(byte, b' '..=b'~' | b'\t' | b'\r' | b'\n');
        self.bytes += bytes.len() as u64;
        self.printable += bytes.iter().filter(is_text).count() as u64;
    }

    /// Counts bytes between the frames of an adapter: they are not held any more, so nothing is known of their kind.
    pub(super) fn discard(&mut self, bytes: u64) {
        self.bytes += bytes;
    }

    /// "890 bytes of text, no telegram: wrong device or baud rate?"; `None` where nothing came.
    pub(super) fn words(self) -> Option<String> {
        if self.bytes == 0 {
            return None;
        }
        // Noise and other baud rates give any byte: of those two in five are printable.
        let kind = if self.printable * 10 >= self.bytes * 9 { " of text" } else { "" };
        Some(format!("{} bytes{kind}, no telegram: wrong device or baud rate?", self.bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_told_from_noise_and_nothing_from_both() {
        let mut heard = Heard::default();
        assert_eq!(heard.words(), None);
        heard.take(&b"$GPGGA,123519,4807.038,N\r\n".repeat(10));
        let said = "260 bytes of text, no telegram: wrong device or baud rate?";
        assert_eq!(heard.words().as_deref(), Some(said));
        heard.take(&(0..=255).collect::<Vec<u8>>());
        let said = "516 bytes, no telegram: wrong device or baud rate?";
        assert_eq!(heard.words().as_deref(), Some(said));
    }
}
