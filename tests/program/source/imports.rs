//! Which file of a crate imports which, read from the sources: paths are followed through `pub use` to the file that
//! declares what they name. Tests and what macros write are not read.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// For each file, the files of the same crate from which it takes names, with one such name each.
pub type Imports = BTreeMap<PathBuf, BTreeMap<PathBuf, String>>;

/// A name that a `use` brings into a module.
#[derive(Debug)]
struct Use {
    path: Vec<String>,
    /// `*` for all names.
    alias: String,
    is_public: bool,
}

/// A module: a file, or a part of one in braces.
#[derive(Debug, Default)]
struct Module {
    file: PathBuf,
    items: BTreeSet<String>,
    uses: Vec<Use>,
    /// Paths in the code itself, such as `super::table::find`.
    paths: Vec<Vec<String>>,
    words: BTreeMap<String, usize>,
}

type Modules = BTreeMap<Vec<String>, Module>;

/// The imports within the crate whose sources are in `src`.
pub fn imports(src: &Path) -> Imports {
    let mut modules = Modules::new();
    read_folder(src, &mut Vec::new(), &mut modules);
    let mut out = Imports::new();
    for (at, module) in &modules {
        let mut add = |path: &[String]| {
            if let Some(file) = resolve(&modules, at, path, 0).filter(|f| *f != module.file) {
                out.entry(module.file.clone()).or_default().entry(file).or_insert(path.join("::"));
            }
        };
        for one in &module.uses {
            // What is only handed on is an import of whoever takes it.
            let used = |name: &str| module.words.get(name).is_some_and(|n| *n > 1);
            if one.alias == "*" {
                let whole = resolve_module(&modules, at, &one.path, 0);
                for name in whole.iter().flat_map(|m| names_of(&modules, m, 0)) {
                    if !one.is_public && module.words.contains_key(&name) && !module.items.contains(&name) {
                        let mut path = one.path.clone();
                        path.push(name);
                        add(&path);
                    }
                }
            } else if !one.is_public || used(&one.alias) {
                add(&one.path);
            }
        }
        for path in &module.paths {
            add(path);
        }
    }
    out
}

/// The circles: sets of files of which each reaches each other one, larger ones first.
pub fn circles(imports: &Imports) -> Vec<Vec<PathBuf>> {
    let reach: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> =
        imports.keys().map(|from| (from, reached(imports, from))).collect();
    let mut done = BTreeSet::new();
    let mut out = Vec::new();
    for (from, to) in &reach {
        if !to.contains(from) || !done.insert(*from) {
            continue;
        }
        let others = to.iter().filter(|other| reach.get(**other).is_some_and(|back| back.contains(from)));
        let circle: Vec<PathBuf> = others.map(|p| (*p).clone()).collect();
        done.extend(to.iter().filter(|p| circle.contains(p)));
        out.push(circle);
    }
    out.sort_by_key(|c| std::cmp::Reverse(c.len()));
    out
}

fn reached<'a>(imports: &'a Imports, from: &PathBuf) -> BTreeSet<&'a PathBuf> {
    let (mut out, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(at) = open.pop() {
        for next in imports.get(at).into_iter().flat_map(BTreeMap::keys) {
            if out.insert(next) {
                open.push(next);
            }
        }
    }
    out
}

fn read_folder(folder: &Path, at: &mut Vec<String>, out: &mut Modules) {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    entries.sort();
    for path in entries {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if stem == "tests" || stem.ends_with("_tests") {
            continue;
        }
        if path.is_dir() {
            at.push(stem);
            read_folder(&path, at, out);
            at.pop();
        } else if path.extension().is_some_and(|e| e == "rs") {
            let own = !matches!(stem.as_str(), "mod" | "lib" | "main");
            at.extend(own.then_some(stem));
            read_module(&tokens(&fs::read_to_string(&path).expect("text")), &mut 0, at, &path, out);
            at.truncate(at.len() - usize::from(own));
        }
    }
}

/// The text without comments, as words, `::` and single signs; literals are `"`.
fn tokens(text: &str) -> Vec<String> {
    let c: Vec<char> = text.chars().collect();
    let is_word = |i: usize| c.get(i).is_some_and(|c| c.is_alphanumeric() || *c == '_');
    let (mut out, mut i) = (Vec::new(), 0);
    while i < c.len() {
        let start = i;
        if c[i] == '/' && c.get(i + 1) == Some(&'/') {
            while i < c.len() && c[i] != '\n' {
                i += 1;
            }
        } else if c[i] == '"' || raw_quotes(&c, i).is_some() {
            i = end_of_text(&c, i);
            out.push("\"".to_owned());
        } else if c[i] == '\'' {
            // A character ends with a quote, a lifetime does not.
            let long = c.get(i + 1) == Some(&'\\');
            let end = (i + 2..(i + 12).min(c.len())).find(|j| c[*j] == '\'' && (!long || *j > i + 2));
            i = end.filter(|j| long || *j == start + 2).map_or(i + 1, |j| j + 1);
        } else if is_word(i) {
            while is_word(i) {
                i += 1;
            }
            out.push(c[start..i].iter().collect());
        } else if c[i] == ':' && c.get(i + 1) == Some(&':') {
            i += 2;
            out.push("::".to_owned());
        } else {
            i += 1;
            if !c[start].is_whitespace() {
                out.push(c[start].to_string());
            }
        }
    }
    out
}

/// The number of `#` of a raw text that begins here.
fn raw_quotes(c: &[char], at: usize) -> Option<usize> {
    let letters = c[at..].iter().take_while(|c| matches!(c, 'b' | 'c' | 'r')).count();
    if letters == 0 || letters > 2 || at > 0 && (c[at - 1].is_alphanumeric() || c[at - 1] == '_') {
        return None;
    }
    let hashes = c[at + letters..].iter().take_while(|c| **c == '#').count();
    (c.get(at + letters + hashes) == Some(&'"')).then_some(hashes)
}

fn end_of_text(c: &[char], at: usize) -> usize {
    let hashes = raw_quotes(c, at).unwrap_or(0);
    let quote = (at..c.len()).find(|i| c[*i] == '"').unwrap_or(at);
    let raw = c[at..quote].contains(&'r');
    let mut i = quote + 1;
    while i < c.len() {
        if c[i] == '\\' && !raw {
            i += 1;
        } else if c[i] == '"' && c[i + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes {
            return i + 1 + hashes;
        }
        i += 1;
    }
    i
}

const DECLARES: [&str; 9] = ["fn", "struct", "enum", "union", "trait", "type", "const", "static", "macro_rules"];

/// Reads a module up to its closing brace.
fn read_module(t: &[String], i: &mut usize, at: &mut Vec<String>, file: &Path, out: &mut Modules) {
    let mut own = Module { file: file.to_owned(), ..Module::default() };
    let (mut level, mut test, mut public) = (0usize, false, false);
    let get = |i: usize| t.get(i).map_or("", String::as_str);
    while *i < t.len() {
        let word = get(*i);
        match word {
            "{" => level += 1,
            "}" if level == 0 => break,
            "}" => level -= 1,
            ";" => (test, public) = (false, false),
            "#" if get(*i + 1) == "[" && get(*i + 2) == "cfg" && get(*i + 4) == "test" => test = true,
            "pub" => public = true,
            "mod" if level == 0 && get(*i + 2) == "{" => {
                let name = get(*i + 1).to_owned();
                *i += 3;
                at.push(name);
                let mut inner = Modules::new();
                read_module(t, i, at, file, &mut inner);
                at.pop();
                if !test {
                    out.append(&mut inner);
                }
                (test, public) = (false, false);
                *i += 1;
                continue;
            }
            "use" => {
                *i += 1;
                read_use(t, i, &mut Vec::new(), public, &mut own.uses);
                for one in &own.uses {
                    own.words.entry(one.alias.clone()).or_insert(1);
                }
                public = false;
            }
            _ if DECLARES.contains(&word) && level == 0 => {
                let name = if word == "macro_rules" { *i + 2 } else { *i + 1 };
                let name = if matches!(get(name), "mut" | "unsafe") { name + 1 } else { name };
                own.items.insert(get(name).to_owned());
                public = false;
            }
            _ => {
                let starts = *i == 0 || get(*i - 1) != "::";
                if starts && get(*i + 1) == "::" && is_name(word) {
                    own.paths.push(path_from(t, *i));
                }
                if starts && is_name(word) {
                    *own.words.entry(word.to_owned()).or_insert(0) += 1;
                }
            }
        }
        *i += 1;
    }
    out.insert(at.clone(), own);
}

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

fn path_from(t: &[String], mut i: usize) -> Vec<String> {
    let mut out = vec![t[i].clone()];
    while t.get(i + 1).is_some_and(|s| s == "::") && t.get(i + 2).is_some_and(|s| is_name(s)) {
        out.push(t[i + 2].clone());
        i += 2;
    }
    out
}

/// One tree of a `use`; ends at the sign behind it.
fn read_use(t: &[String], i: &mut usize, before: &mut Vec<String>, is_public: bool, out: &mut Vec<Use>) {
    let length = before.len();
    while *i < t.len() {
        match t[*i].as_str() {
            "{" => {
                while t.get(*i).is_some_and(|s| s != "}") {
                    *i += 1;
                    read_use(t, i, before, is_public, out);
                }
                *i += 1;
                break;
            }
            "::" => *i += 1,
            "*" => {
                out.push(Use { path: before.clone(), alias: "*".into(), is_public });
                *i += 1;
                break;
            }
            word if is_name(word) => {
                before.push(word.to_owned());
                *i += 1;
                if t.get(*i).is_some_and(|s| s == "::") {
                    continue;
                }
                if before.last().is_some_and(|s| s == "self") && before.len() > 1 {
                    before.pop();
                }
                let mut alias = before.last().cloned().unwrap_or_default();
                if t.get(*i).is_some_and(|s| s == "as") {
                    alias = t.get(*i + 1).cloned().unwrap_or_default();
                    *i += 2;
                }
                out.push(Use { path: before.clone(), alias, is_public });
                break;
            }
            _ => break,
        }
    }
    before.truncate(length);
}

/// The file that declares what a path names, seen from a module; none if it is not of this crate, or a module itself.
fn resolve(modules: &Modules, from: &[String], path: &[String], depth: usize) -> Option<PathBuf> {
    let (mut at, rest) = start(modules, from, path, depth)?;
    for (n, name) in rest.iter().enumerate() {
        match step(modules, &at, name, depth)? {
            Step::Module(next) => at = next,
            Step::Item(file) => return Some(file),
        }
        if n + 1 == rest.len() {
            return None;
        }
    }
    None
}

fn resolve_module(modules: &Modules, from: &[String], path: &[String], depth: usize) -> Option<Vec<String>> {
    let (mut at, rest) = start(modules, from, path, depth)?;
    for name in rest {
        match step(modules, &at, name, depth)? {
            Step::Module(next) => at = next,
            Step::Item(_) => return None,
        }
    }
    Some(at)
}

/// Where a path begins: the crate, a module above, a child, or a name that a `use` has brought.
fn start<'a>(
    modules: &Modules,
    from: &[String],
    path: &'a [String],
    depth: usize,
) -> Option<(Vec<String>, &'a [String])> {
    let first = path.first()?.as_str();
    match first {
        "crate" => Some((Vec::new(), &path[1..])),
        "self" => Some((from.to_vec(), &path[1..])),
        "super" => {
            let up = path.iter().take_while(|s| *s == "super").count();
            Some((from[..from.len().checked_sub(up)?].to_vec(), &path[up..]))
        }
        _ => {
            if !child(modules, from, first)
                && !modules.get(from)?.uses.iter().any(|u| u.alias == first && u.path != [first])
            {
                return None;
            }
            // Guards against a `use` of the name itself, from another crate.
            (depth < 8).then_some((from.to_vec(), path))
        }
    }
}

enum Step {
    Module(Vec<String>),
    Item(PathBuf),
}

fn child(modules: &Modules, at: &[String], name: &str) -> bool {
    modules.contains_key(&[at, &[name.to_owned()]].concat())
}

fn step(modules: &Modules, at: &[String], name: &str, depth: usize) -> Option<Step> {
    if depth > 8 {
        return None;
    }
    if child(modules, at, name) {
        return Some(Step::Module([at, &[name.to_owned()]].concat()));
    }
    let module = modules.get(at)?;
    if module.items.contains(name) {
        return Some(Step::Item(module.file.clone()));
    }
    for one in module.uses.iter().filter(|u| u.alias == name) {
        if one.path.first().is_some_and(|first| first == name) && !child(modules, at, name) {
            continue;
        }
        if let Some(found) = resolve_module(modules, at, &one.path, depth + 1) {
            return Some(Step::Module(found));
        }
        if let Some(file) = resolve(modules, at, &one.path, depth + 1) {
            return Some(Step::Item(file));
        }
    }
    for one in module.uses.iter().filter(|u| u.alias == "*") {
        let inner = resolve_module(modules, at, &one.path, depth + 1).filter(|m| m != at);
        if let Some(found) = inner.and_then(|m| step(modules, &m, name, depth + 1)) {
            return Some(found);
        }
    }
    None
}

/// The names that a module offers to a `use` of all.
fn names_of(modules: &Modules, at: &[String], depth: usize) -> Vec<String> {
    let Some(module) = modules.get(at).filter(|_| depth < 8) else { return Vec::new() };
    let mut out: Vec<String> = module.items.iter().cloned().collect();
    for one in &module.uses {
        if one.alias == "*" {
            let inner = resolve_module(modules, at, &one.path, depth + 1).filter(|m| m != at);
            out.extend(inner.iter().flat_map(|m| names_of(modules, m, depth + 1)));
        } else {
            out.push(one.alias.clone());
        }
    }
    out
}
