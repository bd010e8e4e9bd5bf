//! Scripts: the section `LST`, and `Soo` in script objects. Their sources are deciphered here.

use super::{
    cursor::{Cursor, ReadResult, decode},
    data::{self, ScriptParameter},
    section::{object, tags},
    unknown::UnknownElements,
};

/// Kind of a main script, which runs the scene.
pub const MAIN: i32 = 0;
/// Kind of a child script, which exists from the start to the end of a run.
pub const CHILD: i32 = 1;
/// Kind of a customization script, which exists while its scene is open.
pub const CUSTOMIZATION: i32 = 6;

/// A script with its source, and the object to which it belongs.
#[derive(Debug, Clone)]
pub struct FileScript {
    /// Id of the script.
    pub id: i32,
    /// Handle of the object to which the script belongs, or -1 for the scene. For a script in a script object, the
    /// handle of the script object.
    pub object: i32,
    /// Handle of the script object that contains the script, if any.
    pub holder: Option<i32>,
    /// 0 main, 1 child, 6 customization; others are obsolete.
    pub kind: i32,
    /// Flags. Bit 0: threaded; bit 1: disabled; bit 3: customized main script; bit 5: runs in the sensing phase.
    pub bits: u8,
    /// Position in the order in which scripts are called; before 4.4.
    pub order: i32,
    /// The deciphered source, without trailing zeros. Its first line can name the language.
    pub text: Vec<u8>,
    /// Name of the language; since 4.7.
    pub language: Option<String>,
    /// Handle of the object of a customization script; before 4.2.
    pub customized: i32,
    /// Handle of the object of a callback script; 3.0 to 3.6.
    pub called_back: i32,
    /// Parameters of the script; before 4.0.
    pub parameters: Vec<ScriptParameter>,
}

impl Default for FileScript {
    fn default() -> Self {
        FileScript {
            id: -1,
            object: -1,
            holder: None,
            kind: CHILD,
            bits: 8,
            order: 0,
            text: Vec::new(),
            language: None,
            customized: -1,
            called_back: -1,
            parameters: Vec::new(),
        }
    }
}

/// Reads a script from the section `LST` or the element `Soo`.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<FileScript> {
    let mut script = FileScript::default();
    let tags = tags!(FileScript {
        "Si2" => |s, c, _| Ok((s.id, s.object, s.kind) = (c.i32()?, c.i32()?, c.i32()?)),
        "Va2" => |s, c, _| Ok(s.bits = c.u8()?),
        "Seo" => |s, c, _| Ok(s.order = c.i32()?),
        "Ste" => |s, c, _| {
            let n = c.remaining();
            Ok(s.text = decipher(c.take(n)?))
        },
        "Lne" => |s, c, _| Ok(s.language = Some(c.text()?)),
        "Coc" => |s, c, _| Ok(s.customized = c.i32()?),
        "Coi" => |s, c, _| Ok(s.called_back = c.i32()?),
        "Prm" => |s, c, u| data::parameters(&mut s.parameters, c, u),
    });
    object(c, tags, &["Va3", "Pum", "Cod", "Sfi", "Ttd", "Dbl", "Cv2", "Uis", "Ups"], &mut script, unknown)?;
    Ok(script)
}

/// Deciphers a text, and removes trailing zeros.
fn decipher(bytes: &[u8]) -> Vec<u8> {
    let mut b = bytes.to_vec();
    if let ([first, .., last], n @ 3..) = (bytes, bytes.len()) {
        let (s, e) = (i64::from(*first as i8) / 2, i64::from(*last as i8) * 3);
        for (i, byte) in b.iter_mut().enumerate().take(n - 1).skip(1) {
            let i = i as i64;
            let mut x = i64::from(*byte);
            if i & 1 != 0 {
                x += i + s + e;
            }
            if i & 2 != 0 {
                x -= 3 * i + s;
            }
            if i & 4 != 0 {
                x += i / 2 + e;
            }
            *byte = x as u8;
        }
    }
    b.truncate(b.iter().rposition(|x| *x != 0).map_or(0, |i| i + 1));
    b
}

/// Enciphers a text; for tests, which build their own files.
#[cfg(test)]
pub fn encipher(text: &[u8]) -> Vec<u8> {
    let mut b = text.to_vec();
    if let ([first, .., last], n @ 3..) = (text, text.len()) {
        let (s, e) = (i64::from(*first as i8) / 2, i64::from(*last as i8) * 3);
        for i in 1..n as i64 - 1 {
            let mut x = i64::from(b[i as usize]);
            x -= if i & 1 != 0 { i + s + e } else { 0 };
            x += if i & 2 != 0 { 3 * i + s } else { 0 };
            x -= if i & 4 != 0 { i / 2 + e } else { 0 };
            b[i as usize] = x as u8;
        }
    }
    b
}

impl FileScript {
    /// Returns "lua", "python" or another name, from the file or the first line.
    pub fn language(&self) -> String {
        let first = self.text.split(|b| *b == b'\n').next().unwrap_or_default();
        match &self.language {
            Some(l) if !l.is_empty() => l.clone(),
            _ if first.trim_ascii().starts_with(b"#python") => "python".into(),
            _ => "lua".into(),
        }
    }

    /// Returns the source as UTF-8. A first line `--lua`, which only names the language, is blanked.
    pub fn code(&self) -> String {
        let text = decode(&self.text);
        let (first, rest) = text.split_once('\n').unwrap_or((text.as_str(), ""));
        match first.trim() {
            // Retain an empty line, so that line numbers in messages are those of the file.
            "--lua" => format!("\n{rest}"),
            _ => text,
        }
    }

    /// Returns the handle of the object to which the script belongs, if the script is not in a script object.
    pub fn owner(&self) -> i32 {
        [self.object, self.customized, self.called_back].into_iter().find(|h| *h >= 0).unwrap_or(-1)
    }

    /// Returns whether the script is a copy of the default main script of its version.
    pub fn is_default_main(&self) -> bool {
        let calls_default = || decode(&self.text).contains("defaultMainScript");
        self.kind == MAIN && (self.bits & 8 == 0 || calls_default())
    }
    /// Returns whether the script is disabled.
    pub fn is_off(&self) -> bool {
        self.bits & 2 != 0
    }
    /// Returns whether the script runs as a thread.
    pub fn is_threaded(&self) -> bool {
        self.bits & 1 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cipher_test_vectors_are_deciphered() {
        let cases: [(&[u8], &[u8]); 2] = [
            (&[0x70, 0x1B, 0xA7, 0x56, 0x54, 0xAD, 0x5A, 0xF8, 0x0A], b"print(1)\n"),
            (&[0x2D, 0x83, 0x3C, 0x36, 0x14, 0xC7, 0x0A, 0x22, 0x31], "-- é\nx=1".as_bytes()),
        ];
        for (cipher, text) in cases {
            assert_eq!(decipher(cipher), text);
            assert_eq!(encipher(text), cipher);
        }
        assert_eq!(decipher(b"ab"), b"ab");
        assert_eq!(decipher(&[]), b"");
    }

    #[test]
    fn language_line_is_removed_from_the_code() {
        let code = |t: &str| FileScript { text: t.into(), ..Default::default() }.code();
        assert_eq!(code("--lua\r\nx = 1"), "\nx = 1");
        assert_eq!(code("--luau\nx = 1"), "--luau\nx = 1");
        assert_eq!(FileScript { text: "  #python\nx".into(), ..Default::default() }.language(), "python");
    }
}
