//! Where included files come from, and names of files.

/// The files that a xacro file may include: the importer decides which they are.
///
/// A path has `/` between its parts. It is the name in the file, after the folder of the file that is being read (`..` is
/// not resolved), unless it is absolute or begins with what `package` returned. The implementation refuses paths that lead
/// out of the folders that it allows.
pub trait Files {
    /// Reads a file. The error is a sentence for the user, such as "there is no such file".
    fn read(&mut self, path: &str) -> Result<Vec<u8>, String>;

    /// Returns the names in a folder, for includes with `*` or `?`, or a sentence why it cannot be listed; the folder is
    /// empty for that of the first file if its name has none.
    fn list(&mut self, folder: &str) -> Result<Vec<String>, String>;

    /// Returns the text for `$(find NAME)`, or `None` if the package is unknown, which is an error. With the text
    /// `package://NAME`, readers of the result find meshes in both usual forms: of `file://package://` in the result,
    /// `file://` is removed.
    fn package(&mut self, name: &str) -> Option<String> {
        Some(format!("package://{name}"))
    }
}

/// No files: for a text that includes none.
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&mut self, _: &str) -> Result<Vec<u8>, String> {
        Err("files cannot be included here".to_owned())
    }
    fn list(&mut self, _: &str) -> Result<Vec<String>, String> {
        Err("files cannot be included here".to_owned())
    }
}

/// The path of a file that is named in another one.
pub(crate) fn relative_to(file: &str, name: &str) -> String {
    let has_drive = name.as_bytes().get(1) == Some(&b':') && name.as_bytes()[0].is_ascii_alphabetic();
    match file.rfind('/') {
        Some(slash) if !(name.starts_with('/') || name.contains("://") || has_drive) => {
            format!("{}/{name}", &file[..slash])
        }
        _ => name.to_owned(),
    }
}

/// Whether a path stands for all files that match it.
pub(crate) fn is_pattern(path: &str) -> bool {
    path.contains(['*', '?', '['])
}

/// The files that match a path, sorted. `limit`: the maximum number of names that are looked at.
pub(crate) fn matching(path: &str, limit: usize, files: &mut dyn Files) -> Result<Vec<String>, String> {
    let mut found = vec![String::new()];
    let (mut seen, mut is_listed) = (0, false);
    for (i, part) in path.split('/').enumerate() {
        let join = |folder: &str, name: &str| if i == 0 { name.to_owned() } else { format!("{folder}/{name}") };
        let mut next = Vec::new();
        for folder in &found {
            if !is_pattern(part) {
                next.push(join(folder, part));
                continue;
            }
            let names = match files.list(if i == 1 && folder.is_empty() { "/" } else { folder }) {
                Ok(names) => names,
                // Below a pattern, a file that is not a folder is listed, too: nothing in it matches.
                Err(_) if is_listed => continue,
                Err(why) => return Err(format!("{path}: {why}")),
            };
            seen += names.len();
            if seen > limit {
                return Err(format!("the folders of {path} have more than {limit} entries"));
            }
            let is_match = |name: &&String| (!name.starts_with('.') || part.starts_with('.')) && matches(part, name);
            next.extend(names.iter().filter(is_match).map(|name| join(folder, name)));
        }
        is_listed |= is_pattern(part);
        found = next;
    }
    found.sort();
    Ok(found)
}

/// Whether a name matches a pattern with `*`, `?`, `[abc]`, `[a-c]` and `[!abc]`.
fn matches(pattern: &str, name: &str) -> bool {
    let pattern: Vec<char> = pattern.chars().collect();
    let name: Vec<char> = name.chars().collect();
    let (mut p, mut n) = (0, 0);
    // After a mismatch, the last `*` takes one character more.
    let mut last_star = None;
    while n < name.len() {
        if pattern.get(p) == Some(&'*') {
            last_star = Some((p, n));
            p += 1;
            continue;
        }
        match single(&pattern[p..], name[n]) {
            Some(len) => {
                p += len;
                n += 1;
            }
            None => match last_star {
                Some((star, taken)) => {
                    last_star = Some((star, taken + 1));
                    p = star + 1;
                    n = taken + 1;
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Length of the first part of a pattern if it matches a character.
fn single(pattern: &[char], c: char) -> Option<usize> {
    match pattern {
        [] => None,
        ['?', ..] => Some(1),
        ['[', rest @ ..] => {
            let is_negated = rest.first() == Some(&'!');
            let set = &rest[usize::from(is_negated)..];
            // A bracket directly at the start belongs to the set.
            let Some(end) = set.iter().skip(1).position(|c| *c == ']').map(|at| at + 1) else {
                return (c == '[').then_some(1);
            };
            let (mut i, mut found) = (0, false);
            while i < end {
                if i + 2 < end && set[i + 1] == '-' {
                    found |= (set[i]..=set[i + 2]).contains(&c);
                    i += 3;
                } else {
                    found |= set[i] == c;
                    i += 1;
                }
            }
            (found != is_negated).then_some(1 + usize::from(is_negated) + end + 1)
        }
        [other, ..] => (*other == c).then_some(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folder;

    impl Files for Folder {
        fn read(&mut self, path: &str) -> Result<Vec<u8>, String> {
            Err(path.to_owned())
        }
        fn list(&mut self, folder: &str) -> Result<Vec<String>, String> {
            let names: &[&str] = match folder {
                "a" => &["z.xacro", "b.xacro", ".hidden.xacro", "c.txt", "sub1", "sub2"],
                "a/sub1" | "a/sub2" => &["m.xacro"],
                _ => return Err("no folder".to_owned()),
            };
            Ok(names.iter().map(|name| (*name).to_owned()).collect())
        }
    }

    #[test]
    fn patterns_find_files_in_order() {
        let find = |path: &str| matching(path, 100, &mut Folder).unwrap();
        assert_eq!(find("a/*.xacro"), ["a/b.xacro", "a/z.xacro"]);
        assert_eq!(find("a/sub*/m.xacro"), ["a/sub1/m.xacro", "a/sub2/m.xacro"]);
        assert_eq!(matching("q/*", 100, &mut Folder), Err("q/*: no folder".to_owned()));
        assert!(matching("a/*", 3, &mut Folder).is_err());
    }

    #[test]
    fn names_match_as_in_a_shell() {
        for (pattern, name) in
            [("*", ""), ("a*b*c", "a_b_bc"), ("?[a-c]", "xb"), ("[!a]", "b"), ("[]]", "]"), ("[", "[")]
        {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("?", ""), ("a*b", "ac"), ("[!a]", "a"), ("", "a"), ("[a-c]", "d")] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }

    #[test]
    fn names_are_relative_to_the_folder_of_the_file() {
        assert_eq!(relative_to("a/b.xacro", "../c.xacro"), "a/../c.xacro");
        assert_eq!(relative_to("b.xacro", "c.xacro"), "c.xacro");
        assert_eq!(relative_to("package://p/urdf/b.xacro", "c.xacro"), "package://p/urdf/c.xacro");
        assert_eq!(relative_to("a/b.xacro", "package://p/c.xacro"), "package://p/c.xacro");
        assert_eq!(relative_to("/a/b.xacro", "/c.xacro"), "/c.xacro");
    }
}
