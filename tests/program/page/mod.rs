//! Tests of the page and its server, by clients without a browser and in a real browser if there is one.
//!
//! - `program`: the program with its page; `drive`: helpers for tests in a browser;
//! - `access`, `messages`, `repeat`: clients without a browser;
//! - `student`, `handling`, `looking`, `scripting`, `opening`, `film`, `building`, `saving`, `moving`, `details`,
//!   `overlays`, `looks`, `panes`, `exercise`, `accessible`, `drafts`, `adding`, `small_screens`: in a browser; `pictures`: for the guide;
//! - `gallery`, `reconnect`: with and without a browser.

mod access;
mod accessible;
mod adding;
mod building;
mod details;
mod drafts;
mod drive;
mod exercise;
mod film;
mod gallery;
mod handling;
mod looking;
mod looks;
mod messages;
mod moving;
mod opening;
mod overlays;
mod panes;
mod pictures;
mod program;
mod reconnect;
mod repeat;
mod saving;
mod scripting;
mod small_screens;
mod student;
