//! Times the beams of `tatu-core`, and prints one JSON line per result, in the format of the peers' scripts.
//!
//! ```sh
//! cargo run --release -p bench-beams -- lidar [--beams 1080] [--mesh] [--seconds 3]
//! cargo run --release -p bench-beams -- sonars [--robots 1000] [--threads 1] [--seconds 3]
//! cargo run --release -p bench-beams -- depth [--mesh] [--all] [--threads 1] [--seconds 3]
//! ```

mod clock;
mod depth;
mod lidar;
mod scenes;
mod sonars;

use std::{collections::HashMap, process::ExitCode};

const USAGE: &str = "usage: bench-beams lidar|sonars|depth [--name value] [--mesh]";

/// The options of the command line.
struct BenchOptions(HashMap<String, String>);

impl BenchOptions {
    /// Parses `--name value` pairs; a name without a value has the value `true`.
    fn parse(words: impl Iterator<Item = String>) -> Option<Self> {
        let mut found = HashMap::new();
        let mut words = words.peekable();
        while let Some(word) = words.next() {
            let name = word.strip_prefix("--")?.to_string();
            let value = words.next_if(|next| !next.starts_with("--")).unwrap_or_else(|| "true".into());
            found.insert(name, value);
        }
        Some(Self(found))
    }

    /// Returns the number `--name`, or the default if the option is missing or not a number.
    fn number<T: std::str::FromStr>(&self, name: &str, default: T) -> T {
        self.0.get(name).and_then(|text| text.parse().ok()).unwrap_or(default)
    }

    fn flag(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }
}

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let bench = words.next();
    let Some(asked) = BenchOptions::parse(words) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let line = match bench.as_deref() {
        Some("lidar") => lidar::run(&asked),
        Some("sonars") => sonars::run(&asked),
        Some("depth") => depth::run(&asked),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    println!("{line}");
    ExitCode::SUCCESS
}
