//! Splits files into their sections, and writes each section to FOLDER as a seed: `split FILE... FOLDER`. Sections of
//! more than 20 kB are omitted, because small seeds are processed faster.

use std::{env, fs, path::Path};

use tatu_importers_vrep_scene::read::{
    cursor::Cursor,
    file::VrepFile,
    section,
    test_files::ElementBytes,
};

const MAX_SEED_BYTES: usize = 20_000;

fn main() {
    let mut arguments: Vec<String> = env::args().skip(1).collect();
    let Some(folder) = arguments.pop() else { return eprintln!("usage: split FILE... FOLDER") };
    fs::create_dir_all(&folder).expect("the folder for the seeds cannot be created");
    for path in arguments {
        let Ok(bytes) = fs::read(&path) else { continue };
        let Ok(file) = VrepFile::read(&bytes) else { continue };
        let mut c = Cursor::new(&file.data);
        let name = Path::new(&path).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let mut at = 0;
        while let Ok(Ok(mut element)) = section::next(&mut c) {
            let span = element.body.take_rest();
            at += 1;
            if span.len > MAX_SEED_BYTES {
                continue;
            }
            let body = ElementBytes::new().bytes(span.of(&file.data));
            let seed = ElementBytes::new().element(&element.tag, body).mark("EOF");
            fs::write(format!("{folder}/{name}-{at}"), seed.0).expect("a seed cannot be written");
        }
    }
}
