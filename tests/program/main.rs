//! Tests of the built program from outside: with real plugin libraries, compilers and scripts.
//!
//! The tests form one binary, with a folder per subject and a module per question:
//!
//! | folder | what is tried |
//! |---|---|
//! | `kit` | What all tests share: running the program, scenes in folders of their own, plugins compiled on the way. |
//! | `scene` | Scenes: read, imported, converted, refused; how bodies in them move. |
//! | `robots` | Robots that come with the program, against closed forms and what the original did. |
//! | `sensors` | Sensors against geometry written out, their noise, and what reading them may change: nothing. |
//! | `scripts` | Scripts: when each is called, what the eras find as it was, what commands return, what one cannot do to another. |
//! | `plugins` | Plugins: loaded, refused, crashing, misbehaving, old and new; the header and its record. |
//! | `remote` | Services, with the real clients of each protocol where they can be had. |
//! | `page` | The page, in a real browser where there is one. |
//! | `state` | The same scene and seed give the same bits: on every run, after a snapshot, in a replay, with other worlds beside. |
//! | `cli` | The command line: what it prints, writes, draws and describes. |
//! | `source` | The source tree itself: layers, names, lengths. |
//!
//! Tests of one plugin carry its name. Expected values name their source: a formula, or a fact restated in
//! `tests/facts/`. Tests that need files outside of the repository, or a compiler that is missing, count as ignored. No
//! test depends on how long something takes.

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
