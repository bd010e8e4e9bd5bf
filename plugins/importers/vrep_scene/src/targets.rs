//! Declares the objects that a sensor detects, if it does not detect all objects: a single object, or a collection.

use std::collections::BTreeSet;

use tatu_plugin_api::safe::{Node, Result, Value};

use crate::{
    dynamics::ObjectTree,
    read::{
        file::{FileObject, VrepFile},
        registered::Collection,
    },
    report::ImportReport,
    scripts::is_holder,
};

/// Handle that selects all objects.
const ALL_OBJECTS: i32 = -1;

/// Declares the targets of a sensor; `entity` is the handle of an object or a collection.
pub fn declare_targets(
    (file, tree): (&VrepFile, &ObjectTree<'_>),
    entity: i32,
    o: &FileObject,
    node: Node<'_>,
    report: &mut ImportReport,
) -> Result {
    let collection = file.collections.iter().find(|k| k.handle == entity);
    let objects: Vec<(i32, i32)> =
        file.objects.iter().filter(|o| !is_holder(o)).map(|o| (o.common.id, o.common.parent)).collect();
    let known: BTreeSet<i32> = objects.iter().map(|(id, _)| *id).collect();
    let (seen, all) = match collection {
        _ if entity == ALL_OBJECTS => return Ok(()),
        Some(k) => (
            members(&known, |id| tree.with_ancestors(id), k),
            k.items.first().is_some_and(|i| i.kind == 5 && !i.remove),
        ),
        None if known.contains(&entity) => (BTreeSet::from([entity]), false),
        None => {
            report.add(
                "replaced",
                "the entity that the sensor detects is not in the file, so it detects all objects",
                o,
            );
            return Ok(());
        }
    };
    let (mut targets, ignored) = match differences(&objects, &seen, all) {
        // If any object is listed as a target, the core does not detect unlisted objects.
        (targets, _) if all && !targets.is_empty() => differences(&objects, &seen, false),
        both => both,
    };
    let paths = |handles: &[i32]| -> Value {
        Value::List(handles.iter().filter_map(|h| tree.path(o.common.id, *h)).map(Value::text).collect())
    };
    if targets.is_empty() && !all {
        // An empty list would mean all objects, so list only the sensor itself, which it never detects.
        targets.push(o.common.id);
    }
    if !targets.is_empty() {
        node.set("sensor.targets", paths(&targets))?;
    }
    if !ignored.is_empty() {
        node.set("sensor.ignored", paths(&ignored))?;
    }
    Ok(())
}

/// Returns the objects of a collection in a scene with the objects `all`; `above` returns an object and its ancestors.
fn members(all: &BTreeSet<i32>, above: impl Fn(i32) -> Vec<i32>, collection: &Collection) -> BTreeSet<i32> {
    let mut out = BTreeSet::new();
    for item in &collection.items {
        let base = item.object;
        let mut meant: BTreeSet<i32> = match item.kind {
            0 => [base].into(),
            1 | 2 => all.iter().copied().filter(|id| above(*id).contains(&base)).collect(),
            3 | 4 => above(base).into_iter().filter(|id| all.contains(id)).collect(),
            _ => all.clone(),
        };
        if matches!(item.kind, 2 | 4) {
            meant.remove(&base);
        }
        match item.remove {
            true => out.retain(|id| !meant.contains(id)),
            false => out.extend(meant),
        }
    }
    out
}

/// Returns the objects that are detected although their parent is not, and those that are not detected although their
/// parent is. `objects` lists pairs of object and parent; `world` states whether the parent of root objects is treated
/// as detected.
fn differences(objects: &[(i32, i32)], seen: &BTreeSet<i32>, world: bool) -> (Vec<i32>, Vec<i32>) {
    let known: BTreeSet<i32> = objects.iter().map(|(id, _)| *id).collect();
    let differs = |(id, parent): &&(i32, i32)| {
        let above = if known.contains(parent) { seen.contains(parent) } else { world };
        seen.contains(id) != above
    };
    objects.iter().filter(differs).map(|(id, _)| *id).partition(|id| seen.contains(id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::registered::CollectionItem;

    /// 1 is a robot with the children 2 and 3, where 3 has the child 4; 5 is a single object.
    const OBJECTS: [(i32, i32); 5] = [(1, -1), (2, 1), (3, 1), (4, 3), (5, -1)];

    fn above(id: i32) -> Vec<i32> {
        match OBJECTS.iter().find(|(o, _)| *o == id) {
            Some((_, parent)) => [vec![id], above(*parent)].concat(),
            None => vec![id],
        }
    }

    #[test]
    fn items_of_a_collection_select_its_members() {
        let all = OBJECTS.iter().map(|(id, _)| *id).collect();
        let members = |items: &[(i32, u8, bool)]| -> Vec<i32> {
            let items = items.iter().map(|(object, kind, remove)| CollectionItem {
                object: *object,
                kind: *kind,
                remove: *remove,
            });
            let collection = Collection { items: items.collect(), ..Default::default() };
            members(&all, above, &collection).into_iter().collect()
        };
        assert_eq!(members(&[(-1, 5, false), (1, 1, true)]), [5]);
        assert_eq!(members(&[(3, 2, false), (5, 0, false)]), [4, 5]);
        assert_eq!(members(&[(4, 3, false)]), [1, 3, 4]);
        assert_eq!(members(&[(4, 4, false)]), [1, 3]);
        assert_eq!(members(&[]), [0_i32; 0]);
    }

    #[test]
    fn objects_that_differ_from_their_parent_are_listed() {
        let differ = |seen: &[i32], all| differences(&OBJECTS, &seen.iter().copied().collect(), all);
        assert_eq!(differ(&[5], true), (vec![], vec![1]));
        assert_eq!(differ(&[4, 5], true), (vec![4], vec![1]));
        assert_eq!(differ(&[4, 5], false), (vec![4, 5], vec![]));
        assert_eq!(differ(&[1, 2], false), (vec![1], vec![3]));
    }
}
