//! `tatu new plugin`: creates the folder of a plugin.

use tatu_core::errors::{Result, with_article};

use super::{
    choice::{ExtensionKind, Lang, NewPluginArgs, refused, value_name},
    files::NewFiles,
    sdk,
};

/// The name used in plugin templates, which the plugin's name replaces.
const TEMPLATE_NAME: &str = "my_plugin";

pub fn plugin(args: &NewPluginArgs) -> Result {
    let (lang, kind) = (args.lang, args.kind);
    let mut files = NewFiles::new(&args.named)?;
    let folder = format!("{}_{}", value_name(kind), value_name(lang));
    if sdk::template(&folder).next().is_none() {
        return Err(refused(format!("there is no template for {} in C++", with_article(&value_name(kind))))
            .expected("any other kind in C++; all kinds in C and Rust")
            .help(
                "use C (`--lang c`), or add the C tables of this kind to a C++ plugin: see `other_extension` in \
                 tatu/plugin.hpp",
            ));
    }
    for (path, text) in sdk::template(&folder) {
        files.add_renamed(path, text, TEMPLATE_NAME);
    }
    for (path, text) in sdk::template(&format!("{}_check", value_name(kind))) {
        files.add_renamed(path, text, TEMPLATE_NAME);
    }
    let manifest = match lang {
        Lang::Rust => sdk::common("Cargo.toml"),
        Lang::Cpp => sdk::common("Makefile.cpp"),
        Lang::C => sdk::common("Makefile.c"),
    };
    files.add_renamed(if lang == Lang::Rust { "Cargo.toml" } else { "Makefile" }, manifest, TEMPLATE_NAME);
    files.add_renamed("README.md", &readme(lang, kind), TEMPLATE_NAME);
    files.add_renamed("tatu.toml", &settings(lang, kind), TEMPLATE_NAME);
    files.add_renamed(".gitignore", sdk::common("gitignore"), TEMPLATE_NAME);
    for (path, text) in sdk::files(lang) {
        files.add(&path, &text);
    }
    let (folder, source) = (files.shown(), source(lang).replace(TEMPLATE_NAME, files.name()));
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

fn settings(lang: Lang, kind: ExtensionKind) -> String {
    let text = sdk::common("tatu.toml").replace("LANGUAGE", &value_name(lang)).replace("KIND", &value_name(kind));
    text.replace("VERSION", sdk::VERSION)
}

fn readme(lang: Lang, kind: ExtensionKind) -> String {
    let summary = match kind {
        ExtensionKind::Command => "Commands for scripts",
        ExtensionKind::Sensor => "A kind of sensor",
        ExtensionKind::Actuator => "A kind of actuator",
        ExtensionKind::Part => "A controller",
        ExtensionKind::Model => "A robot model",
        ExtensionKind::Importer => "An importer of a file format",
        ExtensionKind::Service => "A service",
        ExtensionKind::Script => "A script language",
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
