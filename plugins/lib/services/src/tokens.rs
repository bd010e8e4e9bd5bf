//! The access tokens of a listener. Those of a fixed port are stored for later runs, so that an open page can reconnect
//! at the same address after the program has been restarted.

use std::io;

use crate::state::PrivateFolder;

/// Number of random bytes in a token, each of which is encoded as two hexadecimal digits.
const TOKEN_BYTES: usize = 16;
/// Maximum size of a token file, bytes.
const MAX_FILE_BYTES: u64 = 1 << 10;

/// The token for full rights, and the token for read-only rights.
pub type TokenPair = [String; 2];

/// Creates a random token of 32 hexadecimal digits.
pub fn random_token() -> io::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(|e| io::Error::other(format!("random numbers are not available: {e}")))?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

/// Creates two random tokens, which are not stored.
pub(crate) fn new() -> io::Result<TokenPair> {
    Ok([random_token()?, random_token()?])
}

/// Returns the tokens stored for a port. If there are none, creates new ones and stores them; if they cannot be stored,
/// returns the error together with the tokens.
pub(crate) fn load_or_create(
    state: io::Result<PrivateFolder>,
    port: u16,
) -> io::Result<(TokenPair, Option<io::Error>)> {
    let name = format!("port-{port}.tokens");
    let state = match state {
        Ok(state) => state,
        Err(e) => return Ok((new()?, Some(e))),
    };
    if let Some(tokens) = state.read(&name, MAX_FILE_BYTES).and_then(parse) {
        return Ok((tokens, None));
    }
    let tokens = new()?;
    let written = state.write(&name, format!("{}\n{}\n", tokens[0], tokens[1]).as_bytes());
    Ok((tokens, written.err()))
}

/// Parses a token file, which contains one token per line. Returns `None` if it is invalid.
fn parse(bytes: Vec<u8>) -> Option<TokenPair> {
    let text = String::from_utf8(bytes).ok()?;
    let is_token = |line: &str| line.len() == 2 * TOKEN_BYTES && line.bytes().all(|b| b.is_ascii_hexdigit());
    let mut lines = text.lines();
    let tokens = [lines.next()?.to_owned(), lines.next()?.to_owned()];
    // If both tokens were equal, the token for read-only rights would grant full rights.
    (lines.next().is_none() && tokens.iter().all(|t| is_token(t)) && tokens[0] != tokens[1]).then_some(tokens)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_stored_per_port() {
        let place = tempfile::tempdir().unwrap();
        let of = |port| load_or_create(PrivateFolder::at(place.path().join("tatu")), port).unwrap();
        let (first, error) = of(8000);
        assert!(error.is_none());
        assert_eq!(of(8000).0, first);
        assert_ne!(of(8001).0, first);
        assert_eq!(of(8000).0, first);
    }

    #[test]
    fn damaged_token_files_are_replaced() {
        let place = tempfile::tempdir().unwrap();
        let state = PrivateFolder::at(place.path().join("tatu")).unwrap();
        let of = || load_or_create(Ok(state.clone()), 8000).unwrap().0;
        let a = "0".repeat(32);
        for text in [String::new(), a.clone(), format!("{a}\n{a}\n"), format!("{a}\nshort\n"), "x".repeat(2000)] {
            state.write("port-8000.tokens", text.as_bytes()).unwrap();
            let tokens = of();
            assert!(tokens[0] != a && tokens[0].len() == 32, "{text}: {tokens:?}");
            assert_eq!(of(), tokens);
        }
    }

    #[cfg(unix)]
    #[test]
    fn exposed_token_files_are_replaced() {
        use std::os::unix::fs::PermissionsExt;
        let place = tempfile::tempdir().unwrap();
        let of = || load_or_create(PrivateFolder::at(place.path().join("tatu")), 8000).unwrap().0;
        let first = of();
        let file = place.path().join("tatu/port-8000.tokens");
        std::fs::set_permissions(&file, PermissionsExt::from_mode(0o644)).unwrap();
        let second = of();
        assert_ne!(second, first);
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        let moved = place.path().join("elsewhere");
        std::fs::rename(&file, &moved).unwrap();
        std::os::unix::fs::symlink(&moved, &file).unwrap();
        let third = of();
        assert_ne!(third, second);
        assert!(std::fs::symlink_metadata(&file).unwrap().is_file());
        assert!(std::fs::read_to_string(&moved).unwrap().starts_with(&second[0]));
    }

    #[test]
    fn without_a_folder_tokens_are_new() {
        let (first, error) = load_or_create(Err(io::ErrorKind::NotFound.into()), 8000).unwrap();
        assert!(error.is_some());
        assert_ne!(load_or_create(Err(io::ErrorKind::NotFound.into()), 8000).unwrap().0, first);
    }
}
