//! `tatu new plugin`: creates the folder of a plugin.

use tatu_core::errors::Result;

use super::{
    choice::{Kind, Lang, Plugin, refused, word},
    files::Files,
    sdk,
};

/// The name used in plugin templates, which the plugin's name replaces.
const OWN: &str = "my_plugin";

pub fn plugin(args: &Plugin) -> Result {
    let (lang, kind) = (args.lang, args.kind);
    let mut files = Files::new(&args.named)?;
    let folder = format!("{}_{}", word(kind), word(lang));
    if sdk::template(&folder).next().is_none() {
        return Err(refused(format!("there is no template for a {} in C++", word(kind)))
            .expected("`command` or `sensor` in C++; all kinds in C and Rust")
            .help(
                "use C (`--lang c`), or add the C tables of this kind to a C++ plugin: see `other_extension` in \
                 tatu/plugin.hpp",
            ));
    }
    for (path, text) in sdk::template(&folder) {
        files.put(path, text, OWN);
    }
    for (path, text) in sdk::template(&format!("{}_check", word(kind))) {
        files.put(path, text, OWN);
    }
    let manifest = match lang {
        Lang::Rust => sdk::common("Cargo.toml"),
        Lang::Cpp => sdk::common("Makefile.cpp"),
        Lang::C => sdk::common("Makefile.c"),
    };
    files.put(if lang == Lang::Rust { "Cargo.toml" } else { "Makefile" }, manifest, OWN);
    files.put("README.md", &readme(lang, kind), OWN);
    files.put("tatu.toml", &settings(lang, kind), OWN);
    files.put(".gitignore", sdk::common("gitignore"), OWN);
    for (path, text) in sdk::files(lang) {
        files.add(&path, &text);
    }
    let (folder, source) = (files.shown(), source(lang).replace(OWN, files.name()));
    files.write(&[format!("tatu plugin run {folder}"), format!("change {folder}/{source}, and run it again")])
}

/// Returns the source file that contains the plugin's code.
fn source(lang: Lang) -> &'static str {
    match lang {
        Lang::C => "my_plugin.c",
        Lang::Cpp => "my_plugin.cpp",
        Lang::Rust => "src/lib.rs",
    }
}

fn settings(lang: Lang, kind: Kind) -> String {
    let text = sdk::common("tatu.toml").replace("LANGUAGE", &word(lang)).replace("KIND", &word(kind));
    text.replace("VERSION", sdk::VERSION)
}

fn readme(lang: Lang, kind: Kind) -> String {
    let summary = match kind {
        Kind::Command => "Commands for scripts",
        Kind::Sensor => "A kind of sensor",
        Kind::Actuator => "A kind of actuator",
        Kind::Model => "A robot model",
        Kind::Importer => "An importer of a file format",
        Kind::Service => "A service",
        Kind::Script => "A script language",
    };
    let (name, manifest, manual) = match lang {
        Lang::C => ("C", "Makefile", "`sdk/include/tatu.h`"),
        Lang::Cpp => ("C++", "Makefile", "`sdk/include/tatu.h` and `sdk/include/tatu/plugin.hpp`"),
        Lang::Rust => ("Rust", "Cargo.toml", "`cargo doc -p tatu-plugin-api --open`, and `sdk/rust/README.md`"),
    };
    sdk::common("README.md")
        .replace("SUMMARY", summary)
        .replace("LANG_NAME", name)
        .replace("SOURCE", source(lang))
        .replace("MANIFEST", manifest)
        .replace("AND_CRATE", if lang == Lang::Rust { " and its crate for plugins" } else { "" })
        .replace("MANUAL", manual)
}
