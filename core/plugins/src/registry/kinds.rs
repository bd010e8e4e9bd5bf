//! What kind of script a text is, where nothing but the text tells.

use super::Registry;

/// A word by which a text tells its kind.
pub struct KindMark {
    /// Language.
    pub language: String,
    /// Kind of script.
    pub kind: String,
    /// The word.
    pub word: String,
    /// The last line begins with it; else a name anywhere in the text does.
    pub last: bool,
}

impl KindMark {
    fn fits(&self, text: &[u8]) -> bool {
        let word = self.word.as_bytes();
        if self.last {
            let last = text.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).rfind(|line| !line.is_empty());
            return last.is_some_and(|line| line.starts_with(word));
        }
        let is_name = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
        let begins = |at: usize| at == 0 || !is_name(&text[at - 1]);
        !word.is_empty() && text.windows(word.len()).enumerate().any(|(at, w)| w == word && begins(at))
    }
}

impl Registry {
    /// The kind of script that a text shows itself to be, by the first mark of its language that fits; `None`: none.
    pub fn kind_of_script(&self, language: usize, text: &[u8]) -> Option<&str> {
        let language = &self.languages.get(language)?.id;
        let mark = self.kind_marks.iter().find(|m| m.language == *language && m.fits(text))?;
        Some(&mark.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_begin_where_names_begin() {
        let mark = |word: &str, last| KindMark { language: "l".into(), kind: "k".into(), word: word.into(), last };
        for (word, last, text, fits) in [
            ("wake", false, "x = wakeUp()", true),
            ("wake", false, "x = awake()", false),
            ("wake", false, "s.wake()", true),
            ("", false, "anything", false),
            ("return", true, "f()\nreturn x \n\n", true),
            ("return", true, "return x\nf()", false),
            ("return", true, "", false),
        ] {
            assert_eq!(mark(word, last).fits(text.as_bytes()), fits, "{word} in {text:?}");
        }
    }
}
