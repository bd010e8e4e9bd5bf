//! Detection of a script's kind from its source.

use super::Registry;

impl Registry {
    /// Returns the kind that a script appears to be, according to the first mark of its language that matches, or
    /// `None` if no mark matches.
    pub fn kind_of_script(&self, language: usize, text: &[u8]) -> Option<&str> {
        let language = &self.scripting.languages.get(language)?.id;
        let mark = self.scripting.kind_marks.iter().find(|m| m.language == *language && m.matches_script(text))?;
        Some(&mark.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::super::types::ScriptKindMark;

    #[test]
    fn kind_mark_matches_only_at_start_of_names() {
        let mark =
            |word: &str, last| ScriptKindMark { language: "l".into(), kind: "k".into(), word: word.into(), last };
        for (word, last, text, fits) in [
            ("wake", false, "x = wakeUp()", true),
            ("wake", false, "x = awake()", false),
            ("wake", false, "s.wake()", true),
            ("", false, "anything", false),
            ("return", true, "f()\nreturn x \n\n", true),
            ("return", true, "return x\nf()", false),
            ("return", true, "", false),
        ] {
            assert_eq!(mark(word, last).matches_script(text.as_bytes()), fits, "{word} in {text:?}");
        }
    }
}
