//! Prints the expansion of a xacro file, or the values of expressions, for comparisons with other programs:
//!
//! ```sh
//! cargo run -p tatu-importers-xacro --example expand -- FILE [NAME:=VALUE ...] [--package NAME=FOLDER ...]
//! cargo run -p tatu-importers-xacro --example expand -- --expressions < LINES
//! ```
//!
//! Notes and errors go to stderr. With `--lines`, each line is preceded by its origin. Of expressions, one per line, the
//! values are printed as elements, or `!` and the error.

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead, stdin},
    process::ExitCode,
};

use tatu_importers_xacro::{Arguments, Files, NoFiles, expand};

/// All files of the machine, and packages by name.
#[derive(Default)]
struct Disk {
    packages: BTreeMap<String, String>,
}

impl Files for Disk {
    fn read(&mut self, path: &str) -> Result<Vec<u8>, String> {
        fs::read(path).map_err(|error| error.to_string())
    }

    fn list(&mut self, folder: &str) -> Result<Vec<String>, String> {
        let folder = if folder.is_empty() { "." } else { folder };
        let entries = fs::read_dir(folder).map_err(|error| error.to_string())?;
        Ok(entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
    }

    fn package(&mut self, name: &str) -> Option<String> {
        self.packages.get(name).cloned()
    }
}

fn expressions() {
    for line in stdin().lock().lines().map_while(Result::ok) {
        let escaped = line.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let file = format!("<a v=\"${{{escaped}}}\"/>");
        match expand("expression", file.as_bytes(), &Arguments::new(), &mut NoFiles) {
            Ok(expansion) => println!("{}", expansion.text.split('\n').nth(1).unwrap_or("")),
            Err(error) => println!("!{}", error.message.replace('\n', " ")),
        }
    }
}

fn main() -> ExitCode {
    let mut disk = Disk::default();
    let (mut arguments, mut file, mut with_lines) = (Arguments::new(), None, false);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        if word == "--expressions" {
            expressions();
            return ExitCode::SUCCESS;
        } else if word == "--lines" {
            with_lines = true;
        } else if word == "--package" {
            let value = words.next().unwrap_or_default();
            let (name, folder) = value.split_once('=').unwrap_or((&value, "."));
            disk.packages.insert(name.to_owned(), folder.to_owned());
        } else if let Some((name, value)) = word.split_once(":=") {
            arguments.set(name, value);
        } else {
            file = Some(word);
        }
    }
    let Some(file) = file else {
        eprintln!("expected a file");
        return ExitCode::FAILURE;
    };
    let expanded = fs::read(&file).map_err(|error| format!("{file}: {error}"));
    let expanded = expanded.and_then(|bytes| expand(&file, &bytes, &arguments, &mut disk).map_err(|e| e.to_string()));
    match expanded {
        Ok(expansion) => {
            for note in &expansion.notes {
                let place = note.first.as_ref().map_or(file.clone(), ToString::to_string);
                eprintln!("note: {place}: {} ({} times)", note.message, note.count);
            }
            for (line, text) in (1..).zip(expansion.text.lines()) {
                match expansion.origin(line).filter(|_| with_lines) {
                    Some((name, line)) => println!("{name}:{line}: {text}"),
                    None => println!("{text}"),
                }
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
