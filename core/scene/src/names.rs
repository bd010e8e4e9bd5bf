//! Paths ("/a/b[1]", "./b", ":/b") and unique names ("b#0").

use std::collections::BTreeMap;

use super::{Object, ObjectKind, Scene};

/// Description of a valid alias, for error messages.
pub const ALIAS_RULE: &str = "a non-empty string without `/` or control characters";

/// Returns whether a string is a valid alias. An alias must not contain `/`, which separates the parts of a path, or
/// control characters, because aliases are displayed in lists.
pub fn is_alias(text: &str) -> bool {
    !text.is_empty() && !text.contains(|c: char| c == '/' || c.is_control())
}

impl Scene {
    /// Returns the path of an object, such as `/robot[1]/arm`. A part has an index if siblings share its alias.
    pub fn path(&self, slot: u32) -> String {
        let Some(o) = self.get(slot) else { return "/".into() };
        let siblings = self.children(o.parent);
        let same: Vec<_> =
            siblings.iter().copied().filter(|s| self.get(*s).is_some_and(|x| x.alias == o.alias)).collect();
        let index = same.iter().position(|s| *s == slot).unwrap_or(0);
        let above = if o.parent == 0 { String::new() } else { self.path(o.parent) };
        if same.len() > 1 { format!("{above}/{}[{index}]", o.alias) } else { format!("{above}/{}", o.alias) }
    }

    /// Returns the paths of all objects, by slot, in one pass; see [`Scene::path`].
    pub fn paths(&self) -> BTreeMap<u32, String> {
        let mut all = BTreeMap::new();
        let mut ahead: Vec<(u32, String)> = vec![(0, String::new())];
        while let Some((base, above)) = ahead.pop() {
            let mut count: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
            for o in self.children(base).iter().filter_map(|s| self.get(*s)) {
                count.entry(&o.alias).or_default().0 += 1;
            }
            for slot in self.children(base) {
                let Some(o) = self.get(*slot) else { continue };
                let Some((same, index)) = count.get_mut(o.alias.as_str()) else { continue };
                let path = match *same {
                    1 => format!("{above}/{}", o.alias),
                    _ => format!("{above}/{}[{index}]", o.alias),
                };
                *index += 1;
                if !o.children.is_empty() {
                    ahead.push((*slot, path.clone()));
                }
                all.insert(*slot, path);
            }
        }
        all
    }

    /// Finds an object by path or unique name. `from` is the object that "." refers to.
    pub fn find(&self, from: u32, path: &str) -> Option<u32> {
        let (mut base, rest) = match path.as_bytes().first()? {
            b'/' => (0, path),
            b'.' | b':' => self.base(from, path)?,
            _ => return self.find_name(path),
        };
        for part in rest.split('/').filter(|p| !p.is_empty()) {
            base = self.find_below(base, part)?;
        }
        (base != 0).then_some(base)
    }

    /// Returns the object that a path starts from, and the remaining parts.
    pub fn start_of<'p>(&self, from: u32, path: &'p str) -> Option<(u32, &'p str)> {
        if path.starts_with('/') { Some((0, path)) } else { self.base(from, path) }
    }

    /// Resolves leading ".", "..", ":" and "::"; returns the object and the rest of the path.
    fn base<'p>(&self, from: u32, path: &'p str) -> Option<(u32, &'p str)> {
        let mut at = from;
        let mut rest = path;
        loop {
            let (part, tail) = rest.split_once('/').unwrap_or((rest, ""));
            at = match part {
                "." => at,
                ".." => self.get(at)?.parent,
                ":" => self.model_of(at),
                "::" => self.model_of(self.get(self.model_of(at))?.parent),
                _ => return Some((at, rest)),
            };
            rest = tail;
        }
    }

    /// Returns the first object below `base` (at any depth, breadth first) that matches a part of a path.
    pub fn find_below(&self, base: u32, part: &str) -> Option<u32> {
        let (pattern, sibling, index) = split_index(part)?;
        let wild = pattern.contains(['*', '?']);
        let fits = |o: &Object| if wild { matches(&pattern, &o.alias) } else { o.alias == pattern };
        // The search proceeds level by level and stops early, because matches are mostly near the base.
        let mut level = vec![base];
        let mut left = index;
        while !level.is_empty() {
            let mut next = Vec::new();
            for parent in level {
                let children = self.children(parent);
                next.extend(children);
                let mut meant = children.iter().copied().filter(|s| self.get(*s).is_some_and(fits));
                let meant: &mut dyn Iterator<Item = u32> = match sibling {
                    Some(n) => &mut meant.nth(n).into_iter(),
                    None => &mut meant,
                };
                for s in meant {
                    if left == 0 {
                        return Some(s);
                    }
                    left -= 1;
                }
            }
            level = next;
        }
        // Scripts are not among the children. If no other object matches, a plain name can refer to a script. Patterns
        // never match scripts, because programs iterate over the matches of a pattern by index.
        if wild {
            return None;
        }
        let is_below =
            |slot: u32| std::iter::successors(self.get(slot), |o| self.get(o.parent)).any(|o| o.parent == base);
        let mut scripts =
            self.scripts(0).into_iter().filter(|s| self.get(*s).is_some_and(fits) && (base == 0 || is_below(*s)));
        scripts.nth(sibling.unwrap_or(left))
    }

    /// Returns all objects below `base`, at any depth, whose alias matches a pattern with `*` and `?`.
    pub fn all_below(&self, base: u32, pattern: &str) -> Vec<u32> {
        let fits = |slot: &u32| *slot != base && self.get(*slot).is_some_and(|o| matches(pattern, &o.alias));
        self.subtree(base).into_iter().filter(fits).collect()
    }

    /// Finds an object by unique name: "b", "b#0", or "b#" for exactly "b".
    pub fn find_name(&self, name: &str) -> Option<u32> {
        let (alias, suffix) = match name.split_once('#') {
            Some((alias, "")) => (alias, -1),
            Some((alias, n)) => (alias, n.parse().ok()?),
            None => (name, -1),
        };
        let is_script = |s: &u32| self.get(*s).is_none_or(|o| o.kind() == ObjectKind::Script);
        self.index.objects_named(alias, suffix).find(|s| !is_script(s))
    }

    /// Returns the only object with this alias, or `None` if no object or several objects have it.
    pub fn only(&self, alias: &str) -> Option<u32> {
        self.index.only(alias)
    }

    /// Sets the alias of an object, and the suffix of its unique name, which is -1 for a name without a suffix.
    pub fn set_name(&mut self, slot: u32, alias: &str, suffix: i32) {
        let Some(o) = self.slots.get_mut(slot as usize).and_then(|s| s.object.as_mut()) else { return };
        if o.alias == alias && o.suffix == suffix {
            return self.index.add(alias, suffix, slot);
        }
        self.index.remove(&o.alias, o.suffix, slot);
        alias.clone_into(&mut o.alias);
        o.suffix = suffix;
        self.index.add(alias, suffix, slot);
    }

    /// Rebuilds the index of names, which is not serialized, after the tree has been deserialized.
    pub fn index_names(&mut self) {
        let mut index = super::name_index::NameIndex::default();
        self.slots().for_each(|(slot, o)| index.add(&o.alias, o.suffix, slot));
        self.index = index;
    }

    /// Assigns objects that were added together the smallest suffix that is free for all of them.
    pub fn make_unique(&mut self, slots: &[u32]) {
        let aliases: Vec<String> = slots.iter().filter_map(|s| self.get(*s).map(|o| o.alias.clone())).collect();
        for (slot, alias) in slots.iter().zip(&aliases) {
            let suffix = self.get(*slot).map_or(-1, |o| o.suffix);
            self.index.remove(alias, suffix, *slot);
        }
        let suffix = self.index.free_suffix(aliases.iter().map(String::as_str));
        for (slot, alias) in slots.iter().zip(&aliases) {
            self.set_name(*slot, alias, suffix);
        }
    }

    /// Returns the alias that is most similar to a misspelt name, for messages.
    pub fn nearest(&self, name: &str) -> Option<String> {
        let wanted = name.rsplit('/').next().unwrap_or(name).trim_end_matches('#');
        let known: Vec<String> = self.slots().map(|(_, o)| o.alias.clone()).collect();
        tatu_errors::nearest(wanted, known.iter().map(String::as_str)).map(str::to_owned)
    }
}

/// Splits a part of a path into alias, index among siblings and index in the tree: "a[2]" is the third of the siblings
/// with the alias `a`, and "a{4}" the fifth match of `a` in the tree.
fn split_index(part: &str) -> Option<(String, Option<usize>, usize)> {
    for (open, close) in [('[', ']'), ('{', '}')] {
        if let Some(body) = part.strip_suffix(close) {
            let (alias, n) = body.rsplit_once(open)?;
            let n: usize = n.parse().ok()?;
            return Some(if open == '[' { (alias.into(), Some(n), 0) } else { (alias.into(), None, n) });
        }
    }
    Some((part.into(), None, 0))
}

/// Returns whether a string matches a pattern, in which `*` matches any string and `?` any single character.
fn matches(pattern: &str, text: &str) -> bool {
    let (p, t): (Vec<char>, Vec<char>) = (pattern.chars().collect(), text.chars().collect());
    // A row of the dynamic-programming table: `row[j]` is whether the pattern so far matches the first j characters.
    let mut row = vec![false; t.len() + 1];
    row[0] = true;
    for c in p {
        let mut next = vec![false; t.len() + 1];
        next[0] = row[0] && c == '*';
        for j in 1..=t.len() {
            next[j] = match c {
                '*' => next[j - 1] || row[j],
                '?' => row[j - 1],
                _ => row[j - 1] && t[j - 1] == c,
            };
        }
        row = next;
    }
    row[t.len()]
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::ObjectVariant;

    fn scene() -> Scene {
        let mut s = Scene::default();
        for parts in [&["arm", "hand"][..], &["arm"]] {
            let add =
                |s: &mut Scene, p, a: &str| s.add(p, a, Isometry3::identity(), ObjectVariant::Dummy(None)).unwrap();
            let robot = add(&mut s, 0, "robot");
            parts.iter().fold(robot, |above, part| add(&mut s, above, part));
            s.set_model_base(robot, true);
            let tree = s.subtree(robot);
            s.make_unique(&tree);
        }
        s
    }

    #[test]
    fn paths_of_all_objects_equal_individual_paths() {
        let s = scene();
        let one_by_one: BTreeMap<u32, String> = s.slots().map(|(slot, _)| (slot, s.path(slot))).collect();
        assert_eq!(s.paths(), one_by_one);
    }

    #[test]
    fn paths_resolve_to_their_objects() {
        let s = scene();
        for (slot, _) in s.slots() {
            assert_eq!(s.find(0, &s.path(slot)), Some(slot), "{}", s.path(slot));
        }
        assert_eq!(s.path(s.find(0, "/robot[1]/arm").unwrap()), "/robot[1]/arm");
        assert_eq!(s.find(0, "/hand"), s.find(0, "/robot/arm/hand"));
        assert_eq!(s.find(0, "/rob*{1}"), s.find(0, "/robot[1]"));
        assert_eq!(s.find(0, "/nothing"), None);
    }

    #[test]
    fn relative_paths_start_at_the_caller() {
        let s = scene();
        let hand = s.find(0, "/hand").unwrap();
        assert_eq!(s.find(hand, "."), Some(hand));
        assert_eq!(s.find(hand, ".."), s.find(0, "/robot/arm"));
        assert_eq!(s.find(hand, ":/arm"), s.find(0, "/robot[0]/arm"));
    }

    #[test]
    fn parts_of_a_copy_share_one_suffix() {
        let s = scene();
        assert_eq!(s.find(0, "arm#0"), s.find(0, "/robot[1]/arm"));
        assert_eq!(s.find(0, "arm"), s.find(0, "/robot[0]/arm"));
        assert_eq!(s.find(0, "hand#0"), None);
    }
}
