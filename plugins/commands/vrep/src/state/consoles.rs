//! Auxiliary consoles, which buffer printed text until a line is complete.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Callback that receives complete lines.
pub(crate) type LineCallback<'a> = &'a mut dyn FnMut(&[u8]);

/// All consoles of a world.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Consoles {
    open: BTreeMap<i64, Console>,
    opened: i64,
}

#[derive(Serialize, Deserialize)]
struct Console {
    title: Vec<u8>,
    line: Vec<u8>,
}

/// Maximum length of a line, in bytes; longer lines are split, because some scripts never print a line feed.
const MAX_LINE_BYTES: usize = 1000;

impl Console {
    fn log_line(&mut self, log: LineCallback<'_>) {
        let line = std::mem::take(&mut self.line);
        log(&[b"[", self.title.as_slice(), b"] ", &line].concat());
    }
}

impl Consoles {
    pub(crate) fn open(&mut self, title: Vec<u8>) -> i64 {
        self.opened += 1;
        self.open.insert(self.opened, Console { title, line: Vec::new() });
        self.opened
    }
    pub(crate) fn title(&self, console: i64) -> Option<Vec<u8>> {
        Some(self.open.get(&console)?.title.clone())
    }
    pub(crate) fn has(&self, console: i64) -> bool {
        self.open.contains_key(&console)
    }
    pub(crate) fn print(&mut self, console: i64, text: Option<&[u8]>, tell: LineCallback<'_>) -> bool {
        let Some(console) = self.open.get_mut(&console) else {
            return false;
        };
        let Some(text) = text else {
            console.line.clear();
            return true;
        };
        for b in text {
            match b {
                b'\n' => console.log_line(tell),
                b'\r' => {}
                _ => console.line.push(*b),
            }
            if console.line.len() == MAX_LINE_BYTES {
                console.log_line(tell);
            }
        }
        true
    }
    pub(crate) fn close(&mut self, console: i64, tell: LineCallback<'_>) -> bool {
        let Some(mut console) = self.open.remove(&console) else {
            return false;
        };
        if !console.line.is_empty() {
            console.log_line(tell);
        }
        true
    }
    pub(crate) fn close_all(&mut self, tell: LineCallback<'_>) {
        while let Some((console, _)) = self.open.first_key_value() {
            self.close(*console, tell);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_logged_when_complete() {
        let (mut consoles, mut told) = (Consoles::default(), Vec::new());
        let mut tell = |line: &[u8]| told.push(String::from_utf8_lossy(line).into_owned());
        let a = consoles.open(b"A".to_vec());
        assert!(consoles.print(a, Some(b"S["), &mut tell));
        assert!(consoles.print(a, Some(b"1] \nnext"), &mut tell));
        assert!(consoles.print(a, None, &mut tell), "nil clears the console");
        assert!(consoles.print(a, Some(b"rest"), &mut tell));
        assert!(consoles.close(a, &mut tell));
        assert!(!consoles.print(a, Some(b"x\n"), &mut tell));
        assert!(!consoles.close(a, &mut tell));
        assert_eq!(told, ["[A] S[1] ", "[A] rest"]);
    }

    #[test]
    fn long_lines_are_split() {
        let (mut consoles, mut lines) = (Consoles::default(), 0);
        let a = consoles.open(b"A".to_vec());
        let mut tell = |_: &[u8]| lines += 1;
        consoles.print(a, Some(&[b'x'; 2500]), &mut tell);
        assert_eq!(lines, 2);
    }
}
