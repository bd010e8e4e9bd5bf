//! Keys from the terminal: some control the run, all others are passed to scripts.

use std::{io::IsTerminal, time::Duration};

use crossterm::{
    event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers},
    terminal,
};
use tatu_core::errors::Error;

/// What a key on the terminal does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TerminalKey {
    /// F5: play or pause.
    Play,
    /// F6: one step.
    Step,
    /// F7 or Ctrl-C: end the run.
    Stop,
    /// +: faster.
    Faster,
    /// -: slower.
    Slower,
    /// A key for scripts: a character or a name, with its modifiers.
    Key(String),
}

/// Keeps the terminal in raw mode until it is dropped.
pub struct Terminal(());

impl Terminal {
    /// Switches the terminal to raw mode. Fails with E105 if there is no terminal.
    pub fn open() -> Result<Self, Error> {
        let none = |why: String| {
            Error::new("E105", format!("--interactive requires a terminal: {why}"))
                .help("start the program in a terminal, or supply key presses with `--keys FILE`")
        };
        if !std::io::stdin().is_terminal() {
            return Err(none("standard input is not a terminal".into()));
        }
        terminal::enable_raw_mode().map_err(|e| none(e.to_string()))?;
        let terminal = Terminal(());
        restore_line_endings();
        Ok(terminal)
    }

    /// Returns the next key that is pressed within the time `wait`, if any.
    pub fn next(&mut self, wait: Duration) -> Option<TerminalKey> {
        // A terminal that was closed sends no more keys; its hang-up signal ends the run.
        if !event::poll(wait).unwrap_or(false) {
            return None;
        }
        match event::read().ok()? {
            Event::Key(key) if key.kind != KeyEventKind::Release => button(key),
            _ => None,
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = terminal::disable_raw_mode();
    }
}

/// Restores the conversion of line feeds, which raw mode disables, so that each output line starts in the first column.
#[cfg(unix)]
fn restore_line_endings() {
    use rustix::termios::{OptionalActions, OutputModes, tcgetattr, tcsetattr};
    let input = std::io::stdin();
    if let Ok(mut settings) = tcgetattr(&input) {
        settings.output_modes |= OutputModes::OPOST;
        // If it fails, lines begin in the wrong column.
        let _ = tcsetattr(&input, OptionalActions::Now, &settings);
    }
}
#[cfg(not(unix))]
fn restore_line_endings() {}

fn button(key: KeyEvent) -> Option<TerminalKey> {
    let ctrl = key.modifiers.contains(KeyModifiers::CONTROL);
    let name = match key.code {
        KeyCode::F(5) => return Some(TerminalKey::Play),
        KeyCode::F(6) => return Some(TerminalKey::Step),
        KeyCode::F(7) => return Some(TerminalKey::Stop),
        KeyCode::Char('c') if ctrl => return Some(TerminalKey::Stop),
        KeyCode::Char('+') => return Some(TerminalKey::Faster),
        KeyCode::Char('-') => return Some(TerminalKey::Slower),
        KeyCode::Char(' ') => "space".into(),
        KeyCode::Char(c) => c.to_string(),
        KeyCode::Up => "up".into(),
        KeyCode::Down => "down".into(),
        KeyCode::Left => "left".into(),
        KeyCode::Right => "right".into(),
        KeyCode::Enter => "enter".into(),
        KeyCode::Tab => "tab".into(),
        KeyCode::Backspace => "backspace".into(),
        KeyCode::Delete => "delete".into(),
        KeyCode::Esc => "esc".into(),
        _ => return None,
    };
    let held = [(ctrl, "ctrl+"), (key.modifiers.contains(KeyModifiers::SHIFT), "shift+")];
    let held: String = held.iter().filter(|(down, _)| *down).map(|(_, name)| *name).collect();
    Some(TerminalKey::Key(held + &name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_keys_are_mapped() {
        let of = |code, modifiers| button(KeyEvent::new(code, modifiers));
        let key = |s: &str| Some(TerminalKey::Key(s.into()));
        assert_eq!(of(KeyCode::Char('s'), KeyModifiers::NONE), key("s"));
        assert_eq!(of(KeyCode::Char('S'), KeyModifiers::SHIFT), key("shift+S"));
        assert_eq!(of(KeyCode::Char('s'), KeyModifiers::CONTROL), key("ctrl+s"));
        assert_eq!(of(KeyCode::Up, KeyModifiers::NONE), key("up"));
        assert_eq!(of(KeyCode::Char(' '), KeyModifiers::NONE), key("space"));
        assert_eq!(of(KeyCode::Char('c'), KeyModifiers::CONTROL), Some(TerminalKey::Stop));
        assert_eq!(of(KeyCode::F(5), KeyModifiers::NONE), Some(TerminalKey::Play));
        assert_eq!(of(KeyCode::F(9), KeyModifiers::NONE), None);
    }
}
