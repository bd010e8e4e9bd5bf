//! Describes equal models of a scene once: of a model that equals an earlier one, only the handles, the alias, the
//! scripts, and the poses that differ are sent. In a scene with many robots, the message with the scene is much smaller.

use std::collections::{BTreeMap, HashMap};

use crate::protocol::{ModelCopy, SceneEntry, SceneObject};

/// Minimum number of objects of a model that is described as a copy.
const MIN_OBJECTS: usize = 3;

/// Returns the entries of the message with a scene, for its objects in the order of the scene tree.
pub fn entries(objects: Vec<SceneObject>) -> Vec<SceneEntry> {
    let roots = roots(&objects);
    let mut models: BTreeMap<usize, Vec<&SceneObject>> = BTreeMap::new();
    for (object, root) in objects.iter().zip(&roots) {
        models.entry(*root).or_default().push(object);
    }
    let mut originals: HashMap<String, &[&SceneObject]> = HashMap::new();
    let mut copies: BTreeMap<usize, Option<ModelCopy>> = BTreeMap::new();
    for (root, model) in models.iter().filter(|(_, model)| model.len() >= MIN_OBJECTS) {
        let description = description(model);
        match originals.get(&description) {
            Some(original) => {
                copies.insert(*root, Some(copy(original, model)));
            }
            None => {
                originals.insert(description, model);
            }
        }
    }
    let all = objects.into_iter().zip(roots);
    // The entry of a copy replaces the root of the model, which precedes the other objects.
    let entries = all.filter_map(|(object, root)| match copies.get_mut(&root) {
        Some(copy) => copy.take().map(SceneEntry::Copy),
        None => Some(SceneEntry::Object(object)),
    });
    entries.collect()
}

/// Returns, for each object, the index of its ancestor that has no parent in the scene, or its own.
fn roots(objects: &[SceneObject]) -> Vec<usize> {
    let mut by_handle = BTreeMap::new();
    let mut roots = Vec::with_capacity(objects.len());
    for (i, object) in objects.iter().enumerate() {
        let root = *by_handle.get(&object.parent).unwrap_or(&i);
        by_handle.insert(object.id, root);
        roots.push(root);
    }
    roots
}

/// Returns a text that is equal for models that differ only in handles, the alias of the root, scripts and poses.
fn description(model: &[&SceneObject]) -> String {
    let indices: BTreeMap<u32, u32> = model.iter().zip(0..).map(|(object, i)| (object.id, i)).collect();
    let neutral = model.iter().zip(0..).map(|(object, i)| {
        let mut neutral = (*object).clone();
        (neutral.id, neutral.parent) = (i, indices.get(&object.parent).copied().unwrap_or(0));
        (neutral.pose, neutral.scripts) = ([0.0; 7], Vec::new());
        if i == 0 {
            neutral.alias.clear();
        }
        (neutral, object.scripts.len())
    });
    // This cannot fail: non-finite numbers become null, and all map keys are strings.
    serde_json::to_string(&neutral.collect::<Vec<_>>()).unwrap_or_default()
}

/// Describes a model by the one that it equals.
fn copy(original: &[&SceneObject], model: &[&SceneObject]) -> ModelCopy {
    let differing = original.iter().zip(model).zip(0..).filter(|((a, b), _)| a.pose != b.pose);
    ModelCopy {
        copy_of: original.first().map_or(0, |root| root.id),
        alias: model.first().map(|root| root.alias.clone()).unwrap_or_default(),
        ids: model.iter().map(|object| object.id).collect(),
        poses: differing.map(|((_, object), i)| (i, object.pose)).collect(),
        scripts: model.iter().flat_map(|object| object.scripts.clone()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::Script;

    fn object(id: u32, parent: u32, alias: &str) -> SceneObject {
        SceneObject {
            id,
            parent,
            alias: alias.to_owned(),
            kind: "dummy".to_owned(),
            pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            visible: true,
            layer: 1,
            model: parent == 0,
            parts: None,
            collides: false,
            joint: None,
            sensor: None,
            schema: None,
            depth: false,
            volume: None,
            points: None,
            closed: None,
            scripts: Vec::new(),
        }
    }

    #[test]
    fn equal_models_are_copies_and_others_are_not() {
        let robot = |n: u32| {
            let mut all =
                vec![object(n, 0, &format!("robot_{n}")), object(n + 2, n, "joint"), object(n + 1, n + 2, "wheel")];
            all[0].scripts = vec![Script {
                id: n + 9,
                name: String::new(),
                kind: String::new(),
                language: String::new(),
                version: n,
            }];
            all[0].pose[0] = f64::from(n);
            all
        };
        let mut different = robot(40);
        different[2].visible = false;
        let mut turned = robot(30);
        turned[1].pose[3] = 0.5;
        let all = [vec![object(1, 0, "floor")], robot(10), robot(20), turned, different].concat();
        let entries = entries(all);
        let handles = entries.iter().map(|entry| match entry {
            SceneEntry::Object(object) => object.id,
            SceneEntry::Copy(copy) => copy.ids[0],
        });
        assert_eq!(handles.collect::<Vec<_>>(), [1, 10, 12, 11, 20, 30, 40, 42, 41]);
        let copies: Vec<_> = entries
            .iter()
            .filter_map(|entry| if let SceneEntry::Copy(copy) = entry { Some(copy) } else { None })
            .collect();
        assert_eq!((copies[0].copy_of, &*copies[0].alias, &copies[0].ids[..]), (10, "robot_20", &[20, 22, 21][..]));
        assert_eq!((copies[0].poses.len(), copies[0].poses[&0][0], copies[0].scripts[0].id), (1, 20.0, 29));
        assert_eq!(copies[1].poses.keys().collect::<Vec<_>>(), [&0, &1]);
    }
}
