//! Removal of parts of models that a scene does not use.

use std::collections::BTreeSet;

use super::{Document, change::PropertyOverride, overrides};

impl Document {
    /// Removes objects with their descendants. The indices of objects before the first removed one do not change.
    /// Overrides of removed objects are dropped. The cost is proportional to the number of objects after the first
    /// removed one, not to the size of the document, because a scene can place thousands of models that remove parts.
    pub(super) fn remove(&mut self, tops: &BTreeSet<usize>) {
        let Some(first) = tops.first().copied() else { return };
        let mut gone: BTreeSet<usize> = BTreeSet::new();
        for (i, o) in self.objects.iter().enumerate().skip(first) {
            if tops.contains(&i) || o.parent.is_some_and(|p| gone.contains(&p)) {
                gone.insert(i);
            }
        }
        let lost = |o: &PropertyOverride| o.from.is_some_and(|f| gone.contains(&f));
        let mut dropped: BTreeSet<usize> = self.overrides_of(&gone).into_iter().collect();
        dropped.extend(self.reading.overrides.iter().enumerate().filter(|(_, o)| lost(o)).map(|(i, _)| i));
        if !dropped.is_empty() {
            let mut index = 0;
            self.reading.overrides.retain(|_| {
                index += 1;
                !dropped.contains(&(index - 1))
            });
        }
        // The new indices of the objects from the first removed one on.
        let mut next = first;
        let indices: Vec<usize> = (first..self.objects.len())
            .map(|i| {
                let index = next;
                next += usize::from(!gone.contains(&i));
                index
            })
            .collect();
        let move_to = |i: &mut usize| {
            if let Some(index) = i.checked_sub(first).and_then(|n| indices.get(n)) {
                *i = *index;
            }
        };
        self.reading.overrides.iter_mut().filter_map(|o| o.from.as_mut()).for_each(move_to);
        self.models.retain(|m| m.base < first || !gone.contains(&m.base));
        self.models.iter_mut().for_each(|m| move_to(&mut m.base));
        let rest = self.objects.split_off(first);
        self.objects.extend((first..).zip(rest).filter(|(i, _)| !gone.contains(i)).map(|(_, o)| o));
        self.objects[first..].iter_mut().filter_map(|o| o.parent.as_mut()).for_each(move_to);
        self.names.remove(&gone);
        for i in first..self.objects.len() {
            if let Some(suffix) = self.objects[i].specified_suffix() {
                self.names.specify_name(i, &self.objects[i].alias, suffix);
            }
        }
    }

    /// Returns the indices of the overrides in `overrides` that apply to one of these objects. Overrides that are not
    /// relative to a model are left out, because they are resolved when all objects exist.
    pub(super) fn overrides_of(&self, objects: &BTreeSet<usize>) -> Vec<usize> {
        // Most paths only descend, and need not be resolved unless they start at one of the objects or at an ancestor.
        let mut above = objects.clone();
        for object in objects {
            let mut at = self.objects[*object].parent;
            while let Some(parent) = at.filter(|p| above.insert(*p)) {
                at = self.objects[parent].parent;
            }
        }
        let leads_elsewhere = |path: &str| path.starts_with('/') || path.contains(':') || path.contains("..");
        let is_on = |o: &PropertyOverride| {
            let Some(from) = o.from.filter(|f| above.contains(f) || leads_elsewhere(&o.path)) else { return false };
            overrides::find_object(self, Some(from), &o.path).is_ok_and(|object| objects.contains(&object))
        };
        self.reading.overrides.iter().enumerate().filter(|(_, o)| is_on(o)).map(|(i, _)| i).collect()
    }
}
