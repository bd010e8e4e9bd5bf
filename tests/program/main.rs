//! Tests of the built program from outside: with real plugin libraries, compilers and scripts.
//!
//! The tests form one binary, with a folder per subject and a module per question:
//!
//! | folder | tests |
//! |---|---|
//! | `kit` | Code shared by all tests: running the program, temporary folders for scenes, compiling plugins. |
//! | `scene` | Scenes: reading, importing, converting, refusing; and how bodies in them move. |
//! | `robots` | Robots that come with the program, against closed forms and the behaviour of V-REP's models. |
//! | `sensors` | Sensors against closed-form geometry, their noise, and that reading them has no side effects. |
//! | `scripts` | Scripts: when each is called, what old ones rely on, what commands return, how they are isolated. |
//! | `plugins` | Plugins: loading, refusal, crashes, misbehaviour, old and new versions; the header and its recorded layout. |
//! | `remote` | Services, with the real clients of each protocol where they are available. |
//! | `page` | The page, in a real browser where there is one. |
//! | `state` | The same scene and seed give the same bits in every run, after a snapshot, and in a replay. |
//! | `cli` | The command line: what it prints, writes, draws and describes. |
//! | `source` | The source tree itself: layers, names, lengths. |
//!
//! Tests of one plugin carry its name. Expected values name their source: a formula, or a fact restated in
//! `tests/facts/`. Tests that need files outside of the repository, or a compiler that is missing, are reported as
//! ignored. Time limits are generous: they detect a program that hangs, not a slow machine.

#![allow(clippy::disallowed_methods, reason = "expected values need not have the same bits on every processor")]

mod cli;
mod kit;
mod page;
mod plugins;
mod remote;
mod robots;
mod scene;
mod scripts;
mod sensors;
mod source;
mod state;
