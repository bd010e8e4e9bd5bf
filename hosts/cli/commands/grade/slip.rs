//! Grade slips: one line that states what was graded and with what result, so that it can be checked.

use std::fmt::{self, Display};

use sha2::{Digest, Sha256};
use tatu_core::errors::{Error, Result};

/// Number of hexadecimal digits of the hashes of files.
const DIGITS: usize = 16;
/// The first word of a slip.
const WORD: &str = "tatu-slip";

/// What a grade follows from, and the grade.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slip(pub Vec<(&'static str, String)>);

/// Returns the hash of what was graded.
pub fn hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut sum = Sha256::new();
    for part in parts {
        sum.update((part.len() as u64).to_le_bytes());
        sum.update(part);
    }
    let digits: String = sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    digits[..DIGITS].to_owned()
}

impl Display for Slip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(WORD)?;
        self.0.iter().try_for_each(|(key, value)| write!(f, " {key}={value}"))
    }
}

impl Slip {
    /// Returns in which parts a given slip differs from this one.
    pub fn differences(&self, given: &str) -> Result<Vec<String>> {
        let mut words = given.split_whitespace();
        if words.next() != Some(WORD) {
            let error = Error::new("E105", "this is not a grade slip");
            return Err(error.expected(format!("the line `{WORD} ...` that `tatu grade` prints, in quotes")));
        }
        let given: Vec<(&str, &str)> = words.filter_map(|word| word.split_once('=')).collect();
        let mut differences = Vec::new();
        for (key, value) in &self.0 {
            match given.iter().find(|(k, _)| k == key) {
                Some((_, stated)) if stated == value => {}
                Some((_, stated)) => differences.push(format!("it states {key} {stated}, but it is {value}")),
                None => differences.push(format!("it does not state {key}")),
            }
        }
        Ok(differences)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_slips_are_found() {
        let slip = Slip(vec![("scene", "12ab".to_owned()), ("points", "3/4".to_owned())]);
        assert!(slip.differences(&slip.to_string()).unwrap().is_empty());
        let changed = slip.to_string().replace("3/4", "4/4");
        assert_eq!(slip.differences(&changed).unwrap(), ["it states points 4/4, but it is 3/4"]);
        assert_eq!(slip.differences("tatu-slip points=3/4").unwrap(), ["it does not state scene"]);
        assert!(slip.differences("points=3/4").is_err());
    }

    #[test]
    fn hashes_depend_on_the_limits_of_parts() {
        assert_ne!(hash([b"ab".as_slice(), b"c"]), hash([b"a".as_slice(), b"bc"]));
    }
}
