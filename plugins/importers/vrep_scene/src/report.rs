//! Report on the parts of a file that are not built exactly as stored.

use std::collections::BTreeMap;

use crate::read::file::FileObject;

/// Objects, each as its handle and alias, by outcome and reason.
#[derive(Default)]
pub struct ImportReport(pub BTreeMap<(&'static str, String), Vec<(i32, String)>>);

impl ImportReport {
    /// Records an outcome for an object.
    pub fn add(&mut self, what: &'static str, why: impl Into<String>, o: &FileObject) {
        self.0.entry((what, why.into())).or_default().push((o.common.id, o.common.alias()));
    }
    /// Records an outcome for `count` items that are not objects.
    pub fn add_count(&mut self, what: &'static str, why: impl Into<String>, count: usize) {
        if count > 0 {
            let of = self.0.entry((what, why.into())).or_default();
            let before = of.first().and_then(|(_, text)| text.split(' ').next()?.parse::<usize>().ok()).unwrap_or(0);
            *of = vec![(-1, format!("{} in all", before + count))];
        }
    }
}
