//! Generates the reference pages of all commands from their declarations: one for each subject, and an index.

use std::{collections::BTreeMap, fmt::Write, fs, io, path::Path};

use tatu_core::plugins::{CommandEntry, CommandStatus, ParameterSpec, Registry};

/// Groups commands by subject. A command without a subject is listed under the last part of its plugin's id.
fn pages(r: &Registry) -> BTreeMap<String, Vec<&CommandEntry>> {
    let mut pages: BTreeMap<String, Vec<&CommandEntry>> = BTreeMap::new();
    for c in &r.command_offers.commands {
        let plugin = &r.plugins[c.plugin].id;
        let subject = match c.subject.as_str() {
            "" => plugin.rsplit('.').next().unwrap_or(plugin).to_owned(),
            s => s.to_owned(),
        };
        pages.entry(subject).or_default().push(c);
    }
    pages
}

/// Writes the pages into a folder; returns the number of pages.
pub fn write(r: &Registry, folder: &Path) -> io::Result<usize> {
    fs::create_dir_all(folder)?;
    let pages = pages(r);
    let mut list = String::from(
        "# Commands\n\nGenerated from the declarations by `tatu describe --all --markdown docs/reference/commands`. All names of \
         a command do the same; in scripts for versions before 4.2, flat names log errors and return a value.\n\n\
         | Page | full | partial | stub |\n|---|---|---|---|\n",
    );
    for (subject, commands) in &pages {
        let of = |s: CommandStatus| commands.iter().filter(|c| c.status == s).count();
        let (full, partial, stub) = (of(CommandStatus::Full), of(CommandStatus::Partial), of(CommandStatus::Stub));
        let _ = writeln!(list, "| [{subject}]({subject}.md) | {full} | {partial} | {stub} |");
        fs::write(folder.join(format!("{subject}.md")), page(subject, commands))?;
    }
    fs::write(folder.join("README.md"), list)?;
    Ok(pages.len())
}

fn page(subject: &str, commands: &[&CommandEntry]) -> String {
    let title = subject[..1].to_uppercase() + &subject[1..];
    let mut out = format!("# Commands: {title}\n");
    let (stubs, real): (Vec<&&CommandEntry>, Vec<_>) = commands.iter().partition(|c| c.status == CommandStatus::Stub);
    for c in real {
        command(&mut out, c);
    }
    if !stubs.is_empty() {
        out += "\n## Stubs\n\nThey accept any arguments, and return a neutral value.\n\n| Command | Other names | Why \
                |\n|---|---|---|\n";
        for c in stubs {
            let others: Vec<_> = c.names[1..].iter().map(|n| format!("`{}`", n.name)).collect();
            let _ = writeln!(out, "| `{}` | {} | {} |", c.names[0].name, others.join(" "), c.notes);
        }
    }
    out
}

fn command(out: &mut String, c: &CommandEntry) {
    let params: Vec<String> =
        c.params.iter().map(|p| if p.optional() { format!("[{}]", p.key) } else { p.key.clone() }).collect();
    let _ = writeln!(out, "\n## `{}({})`\n\n{}", c.names[0].name, params.join(", "), c.text);
    let others: Vec<_> = c.names[1..].iter().map(|n| format!("`{}`", n.name)).collect();
    if !others.is_empty() {
        let _ = writeln!(out, "\nOther names: {}", others.join(", "));
    }
    if c.status != CommandStatus::Full || !c.notes.is_empty() {
        let _ = writeln!(out, "\n*{}.* {}", c.status.name(), c.notes);
    }
    facts(out, "Parameters", &c.params);
    facts(out, "Returns", &c.returns);
    if !c.example.is_empty() {
        let _ = writeln!(out, "\n```lua\n{}\n```", c.example);
    }
}

fn facts(out: &mut String, title: &str, all: &[ParameterSpec]) {
    if all.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{title}:\n");
    for p in all {
        let unit = p.unit.as_ref().map_or(String::new(), |u| format!(", {u}"));
        let optional = if p.optional() { ", optional" } else { "" };
        let text = if p.text.is_empty() { String::new() } else { format!(": {}", p.text) };
        let _ = writeln!(out, "- `{}` ({}{unit}{optional}){text}", p.key, p.expectation());
    }
}
