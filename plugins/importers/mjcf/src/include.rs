//! Reads a file together with the files that it includes.
//!
//! `<include file="..."/>` is replaced by the children of the other file's root element, whatever that is called.

use std::rc::Rc;

use tatu_plugin_api::safe::{Builder, Fail, Result};

use crate::xml::{Element, MAX_DEPTH, parse};

/// Maximum size of the text of all files, bytes.
pub const MAX_BYTES: usize = 1 << 24;
/// Maximum number of files.
const MAX_FILES: usize = 1000;

/// The files that have been read.
pub struct TextFiles<'w, 'b> {
    builder: &'w Builder<'b>,
    bytes: usize,
    count: usize,
}

impl<'w, 'b> TextFiles<'w, 'b> {
    pub fn new(builder: &'w Builder<'b>) -> Self {
        TextFiles { builder, bytes: 0, count: 0 }
    }

    /// Reads the text of a file, which is given by its bytes, with all files that it includes. `file` is its name, and
    /// is empty for the imported file.
    pub fn tree(&mut self, bytes: &[u8], file: &str) -> Result<Element> {
        let mut open = vec![file.to_owned()];
        let file: Rc<str> = file.into();
        let mut root = self.parse(bytes, &file)?;
        let folder = folder_of(&file);
        self.expand(&mut root, folder, &mut open, 1)?;
        Ok(root)
    }

    /// Reads a file whose name is relative to the folder `folder`, or to that of the file `from`.
    pub fn find(&self, name: &str, folder: &str, from: &str) -> Option<(String, &'b [u8])> {
        let name = name.replace('\\', "/");
        let mut candidates = [join(folder, &name), join(folder_of(from), &name)];
        // The host reports names that lead outside the allowed folders, so the one below the model is tried first.
        candidates.sort_by_key(|path| path.starts_with(".."));
        candidates.into_iter().find_map(|path| Some((path.clone(), self.builder.file(&path)?)))
    }

    fn parse(&mut self, bytes: &[u8], file: &Rc<str>) -> Result<Element> {
        (self.bytes, self.count) = (self.bytes + bytes.len(), self.count + 1);
        if self.bytes > MAX_BYTES || self.count > MAX_FILES {
            let text = format!("the model has more than {MAX_FILES} files or {MAX_BYTES} bytes of XML");
            return Err(Fail::argument(text).at(&**file, 1));
        }
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            Fail::argument("the file is not valid UTF-8 text").at(&**file, line as u64)
        })?;
        parse(text, file)
    }

    fn expand(&mut self, element: &mut Element, folder: &str, open: &mut Vec<String>, depth: usize) -> Result {
        if depth > MAX_DEPTH {
            return Err(element.fail(format!("includes nest elements more than {MAX_DEPTH} levels deep")));
        }
        if !element.children.iter().any(|c| c.name == "include") {
            return element.children.iter_mut().try_for_each(|c| self.expand(c, folder, open, depth + 1));
        }
        let mut children = Vec::with_capacity(element.children.len());
        for mut child in std::mem::take(&mut element.children) {
            if child.name != "include" {
                self.expand(&mut child, folder, open, depth + 1)?;
                children.push(child);
                continue;
            }
            let name = child.attribute("file").ok_or_else(|| child.fail("<include> has no `file`"))?;
            let Some((path, bytes)) = self.find(name, folder, &child.place.file) else {
                let text = format!(
                    "the included file `{name}` does not exist, or is outside the folders that the import may read"
                );
                return Err(child.fail(text));
            };
            if open.contains(&path) {
                return Err(child.fail(format!("`{path}` includes itself")));
            }
            open.push(path.clone());
            let mut root = self.parse(bytes, &path.as_str().into())?;
            self.expand(&mut root, folder, open, depth + 1)?;
            open.pop();
            children.append(&mut root.children);
        }
        element.children = children;
        Ok(())
    }
}

/// Returns the folder of a file, empty for the file's own folder.
pub fn folder_of(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Returns the path of a file in a folder. Components `..` are resolved as far as possible.
pub fn join(folder: &str, name: &str) -> String {
    if name.starts_with('/') {
        return name.to_owned();
    }
    let mut path: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." if path.last().is_some_and(|p| *p != "..") => drop(path.pop()),
            part => path.push(part),
        }
    }
    let start = if folder.starts_with('/') { "/" } else { "" };
    format!("{start}{}", path.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_folders() {
        assert_eq!(join("assets/meshes", "../a.stl"), "assets/a.stl");
        assert_eq!(join("", "./a.stl"), "a.stl");
        assert_eq!(join("../common", "../../b.xml"), "../../b.xml");
        assert_eq!(join("assets", "/b.xml"), "/b.xml");
    }
}
