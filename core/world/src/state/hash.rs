//! Computes the hash of a world's state, with a hash per object.

use tatu_devices::actuators::Actuators;
use tatu_scene::{Dynamics, ObjectVariant, Scene};
use xxhash_rust::xxh3::Xxh3;

use crate::cell::{Clock, WorldCell};

/// A hash of the dynamic state, and a hash of each object in it, so that a difference can be located.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateHash {
    /// Hash of the whole dynamic state.
    pub total: u64,
    /// Path and hash of each object, in order of slots.
    pub objects: Vec<(String, u64)>,
}

impl StateHash {
    /// Returns the hash of an object and all its descendants.
    pub fn subtree(&self, path: &str) -> u64 {
        self.subtrees([path])[0]
    }
    /// Like `subtree`, but for several objects, in a single pass over all objects.
    pub fn subtrees<'a>(&self, paths: impl IntoIterator<Item = &'a str>) -> Vec<u64> {
        let mut all = Vec::new();
        let mut number = std::collections::BTreeMap::new();
        for path in paths {
            number.insert(path, all.len());
            all.push(Xxh3::new());
        }
        for (path, hash) in &self.objects {
            let above = path.match_indices('/').map(|(i, _)| &path[..i]).chain([path.as_str()]);
            for i in above.filter_map(|p| number.get(p)) {
                all[*i].update(&hash.to_le_bytes());
            }
        }
        all.iter().map(Xxh3::digest).collect()
    }
}

/// Hashes the poses and velocities of objects that physics moves, the states of joints, the commands of actuators, and
/// the poses of all other objects. Of parts, which have no place in the world, hashes the commands and the state
/// blocks, if there are any. The total also includes the number of steps. Sensors, scripts and graphs are omitted. -0
/// and 0 have the same hash.
pub(crate) fn hash(scene: &Scene, dynamics: &Dynamics, actuators: &Actuators, clock: &Clock) -> StateHash {
    let mut total = Xxh3::new();
    total.update(&clock.step.get().to_le_bytes());
    let twists: std::collections::BTreeMap<u32, tatu_physics::Twist> = dynamics.twists().collect();
    let (mut objects, mut paths) = (Vec::new(), scene.paths());
    let parts: std::collections::BTreeMap<u32, &[u64]> = actuators.part_states().collect();
    for (slot, o) in scene.slots() {
        let mut h = Xxh3::new();
        if let ObjectVariant::Part(p) = &o.data {
            let state = parts.get(&slot).copied().unwrap_or_default();
            if p.commands.is_empty() && state.is_empty() {
                continue;
            }
            p.commands.iter().for_each(|x| h.update(&(x + 0.0).to_bits().to_le_bytes()));
            state.iter().for_each(|word| h.update(&word.to_le_bytes()));
            let digest = h.digest();
            total.update(&digest.to_le_bytes());
            objects.push((paths.remove(&slot).unwrap_or_else(|| scene.path(slot)), digest));
            continue;
        }
        let mut put = |x: f64| h.update(&(x + 0.0).to_bits().to_le_bytes());
        match &o.data {
            ObjectVariant::Sensor(_) | ObjectVariant::Script | ObjectVariant::Graph(_) => continue,
            ObjectVariant::Actuator(a) => a.commands.iter().copied().for_each(&mut put),
            ObjectVariant::Joint(j) => {
                let own = [j.position, j.velocity, j.target_velocity, j.target_position, j.max_force];
                let course = j.course.filter(|c| c.is_moving() || c.direct).map(|c| c.points);
                own.into_iter().chain(course.into_iter().flatten()).for_each(&mut put);
            }
            _ => {}
        }
        tatu_scene::pose_to_array(&scene.world(slot)).into_iter().for_each(&mut put);
        if let Some(t) = twists.get(&slot) {
            t.linear.iter().chain(t.angular.iter()).copied().for_each(&mut put);
        }
        let digest = h.digest();
        total.update(&digest.to_le_bytes());
        objects.push((paths.remove(&slot).unwrap_or_else(|| scene.path(slot)), digest));
    }
    StateHash { total: total.digest(), objects }
}

/// Returns the total hash of a world's current state.
pub(crate) fn hash_of(cell: &WorldCell) -> u64 {
    let (scene, dynamics) = (cell.state.scene.borrow(), cell.state.dynamics.borrow());
    hash(&scene, &dynamics, &cell.devices.actuators.borrow(), &cell.state.clock).total
}
