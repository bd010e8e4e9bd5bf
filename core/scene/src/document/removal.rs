//! Parts of models that the scene takes out again.

use std::collections::BTreeSet;

use super::{Document, names::Names, overrides};
use crate::rows::Row;
use tatu_plugin_api::safe::Value;

impl Document {
    /// Removes objects with everything below them. Indices of the objects before the first of them stay the same. What
    /// the files set on removed objects is dropped.
    pub(super) fn remove(&mut self, tops: &BTreeSet<usize>) {
        let Some(first) = tops.first().copied() else { return };
        let mut gone: BTreeSet<usize> = BTreeSet::new();
        for (i, o) in self.objects.iter().enumerate().skip(first) {
            if tops.contains(&i) || o.parent.is_some_and(|p| gone.contains(&p)) {
                gone.insert(i);
            }
        }
        let sets = std::mem::take(&mut self.sets);
        let stays = |from: Option<usize>, path: &str| {
            from.is_none_or(|f| !gone.contains(&f))
                && overrides::find(self, from, path).map_or(true, |object| !gone.contains(&object))
        };
        // Paths that begin outside of the model are looked up when all objects exist.
        let mut sets: Vec<_> = sets.into_iter().filter(|o| o.from.is_none() || stays(o.from, &o.path)).collect();
        let moved = |i: usize| i - gone.range(..i).count();
        sets.iter_mut().for_each(|o| o.from = o.from.map(moved));
        self.models.retain(|m| !gone.contains(&m.base));
        self.models.iter_mut().for_each(|m| m.base = moved(m.base));
        let mut index = 0;
        self.objects.retain(|_| {
            index += 1;
            !gone.contains(&(index - 1))
        });
        self.objects.iter_mut().skip(first).for_each(|o| o.parent = o.parent.map(moved));
        self.sets = sets;
        self.name_again();
    }

    /// Builds the index of names again.
    fn name_again(&mut self) {
        let mut names = Names::default();
        for (i, o) in self.objects.iter().enumerate() {
            names.add(o.parent, &o.alias);
            for (_, value) in o.rows.iter().filter(|(r, _)| *r == Row::Name && o.group == 0) {
                let Value::Text(name) = value else { continue };
                if let Some(suffix) = super::names::suffix_of(&String::from_utf8_lossy(name), &o.alias) {
                    names.tell(i, &o.alias, suffix);
                }
            }
        }
        self.names = names;
    }
}
