//! The targets of beams and images, which are updated as objects move.

use ::tatu_beams::{BeamScene, BeamTarget};
use nalgebra::Isometry3;
use rayon::ThreadPool;
use tatu_scene::{Object, Scene, SensorTargets, Shape, visible_parts};

/// The forms of a scene that sensors can detect.
#[derive(Default)]
pub struct Targets {
    /// All detectable forms.
    pub detectable: TargetSet,
    /// All visible forms.
    pub visible: TargetSet,
    /// Subsets for sensors that do not detect all detectable or visible forms.
    special: Vec<(TargetFilter, TargetSet)>,
    /// The selections of objects that scenes declare for sensors: for each selection and each slot, whether the object
    /// is detected. Selections are numbered from 1.
    choices: Vec<Vec<bool>>,
    /// The version of the scene's shapes that was last examined, and whether any of them is detected by only some kinds
    /// of waves.
    selective: (u64, bool),
}

/// The properties of a sensor that determine its set of targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetFilter {
    /// Whether the sensor detects visible forms instead of detectable ones.
    pub visible: bool,
    /// The kinds of waves of its beams, `TATU_WAVES_*`.
    pub waves: u16,
    /// Number of the selection of objects that the sensor can detect, as returned by [`Targets::choice`]; 0 for all
    /// objects.
    pub choice: u32,
}

/// A subset of the scene's forms.
#[derive(Default)]
pub struct TargetSet {
    pub beams: BeamScene,
    /// For each target, the part of a shape from which it was created.
    places: Vec<TargetSource>,
    /// For each slot, the index of its first target plus one, or 0 if it has no target. The targets of a slot are
    /// adjacent.
    first: Vec<u32>,
    /// The versions of the scene's shapes and visibility from which the targets were created.
    built: (u64, u64),
    /// The version of the scene's colours that the targets reflect.
    colored: u64,
    /// Position in the scene's list of moves up to which the targets are up to date.
    followed: u64,
    /// Reused buffer of targets that have moved.
    moved: Vec<(usize, Isometry3<f64>)>,
}

/// The part of a shape from which a target was created.
struct TargetSource {
    slot: u32,
    pose: Isometry3<f64>,
}

impl Targets {
    /// Updates a set of targets from the scene. If several targets have moved, they are updated on the threads of
    /// `pool`.
    pub fn update(&mut self, scene: &Scene, sees: TargetFilter, pool: &ThreadPool) {
        if self.selective.0 != scene.versions.shape {
            let mut shapes = scene.subtree(0).into_iter().filter_map(|slot| scene.get(slot)?.shape());
            self.selective = (scene.versions.shape, shapes.any(|s| s.detectable_mask != u16::MAX));
            self.special.retain(|(sees, _)| sees.visible);
        }
        let TargetFilter { visible, waves, choice } = sees;
        let wanted = |o: &Object, s: &Shape| match visible {
            true => o.is_visible(),
            false => s.is_detectable() && s.detectable_mask & waves != 0,
        };
        if choice == 0 && (visible || waves == u16::MAX || !self.selective.1) {
            let all = if visible { &mut self.visible } else { &mut self.detectable };
            return all.update(scene, pool, |_, o, s| wanted(o, s));
        }
        let at = self.special.iter().position(|(s, _)| *s == sees).unwrap_or_else(|| {
            self.special.push((sees, TargetSet::default()));
            self.special.len() - 1
        });
        let chosen = choice.checked_sub(1).and_then(|i| self.choices.get(i as usize));
        let is_chosen = |slot: u32| chosen.is_none_or(|c| c.get(slot as usize) == Some(&true));
        self.special[at].1.update(scene, pool, |slot, o, s| is_chosen(slot) && wanted(o, s));
    }

    /// Returns a set of targets, as of its last update.
    pub fn filtered_beams(&self, sees: TargetFilter) -> &BeamScene {
        let own = self.special.iter().find(|(s, _)| *s == sees).map(|(_, seen)| &seen.beams);
        own.unwrap_or_else(|| self.beams(sees.visible))
    }

    /// Returns all visible or all detectable forms.
    pub fn beams(&self, visible: bool) -> &BeamScene {
        if visible { &self.visible.beams } else { &self.detectable.beams }
    }

    /// Discards all selections of objects.
    pub fn discard_choices(&mut self) {
        self.choices.clear();
        self.special.retain(|(sees, _)| sees.choice == 0);
    }

    /// Evaluates the selection of objects that the scene declares for a sensor, and returns its number. Equal
    /// selections share a number.
    pub fn choice(&mut self, scene: &Scene, sensor: u32, view: &SensorTargets) -> u32 {
        let found = |paths: &[String]| paths.iter().filter_map(|p| scene.find(sensor, p)).collect::<Vec<_>>();
        let (targets, ignored) = (found(&view.targets), found(&view.ignored));
        // If a selection lists targets but all of them have been removed, nothing is detected rather than everything.
        let otherwise = view.targets.is_empty();
        let mut chosen = Vec::new();
        // Parents precede their children.
        for slot in scene.subtree(0) {
            let above = scene.get(slot).map_or(0, |o| o.parent) as usize;
            let sees = match slot {
                _ if ignored.contains(&slot) => false,
                _ if targets.contains(&slot) => true,
                _ if above == 0 => otherwise,
                _ => chosen.get(above).copied().unwrap_or(otherwise),
            };
            if chosen.len() <= slot as usize {
                chosen.resize(slot as usize + 1, otherwise);
            }
            chosen[slot as usize] = sees;
        }
        let at = self.choices.iter().position(|c| *c == chosen).unwrap_or_else(|| {
            self.choices.push(chosen);
            self.choices.len() - 1
        });
        at as u32 + 1
    }
}

impl TargetSet {
    fn update(&mut self, scene: &Scene, pool: &ThreadPool, wanted: impl Fn(u32, &Object, &Shape) -> bool) {
        let version = (scene.versions.shape, scene.versions.seen);
        if self.built == version {
            self.move_targets(scene, pool);
            if self.colored != scene.versions.color {
                self.update_colors(scene);
            }
            return;
        }
        (self.built, self.colored) = (version, scene.versions.color);
        scene.moves.since(&mut self.followed);
        self.places.clear();
        self.first.clear();
        let mut targets = Vec::new();
        for slot in scene.subtree(0) {
            let Some(o) = scene.get(slot) else { continue };
            let Some(shape) = o.shape().filter(|s| wanted(slot, o, s)) else { continue };
            if self.first.len() <= slot as usize {
                self.first.resize(slot as usize + 1, 0);
            }
            self.first[slot as usize] = self.places.len() as u32 + 1;
            for part in visible_parts(shape) {
                self.places.push(TargetSource { slot, pose: part.pose });
                targets.push(BeamTarget {
                    object: scene.id(slot),
                    group: scene.model_of(slot),
                    world_from_target: scene.world(slot) * part.pose,
                    form: part.form,
                    color: part.color.unwrap_or(shape.color).map(|x| x as f32),
                    opacity: part.opacity.unwrap_or(shape.opacity) as f32,
                    texture: part.texture,
                });
            }
        }
        self.beams.set(targets);
    }

    /// Updates the colours of targets from the scene.
    fn update_colors(&mut self, scene: &Scene) {
        self.colored = scene.versions.color;
        // The parts of the last shape, and the index of the first of them.
        let (mut parts, mut first, mut last) = (Vec::new(), 0, None);
        for (i, place) in self.places.iter().enumerate() {
            let Some(shape) = scene.get(place.slot).and_then(|o| o.shape()) else { continue };
            if last != Some(place.slot) {
                (parts, first, last) = (visible_parts(shape), i, Some(place.slot));
            }
            let own = parts.get(i - first);
            let color = own.and_then(|p| p.color).unwrap_or(shape.color).map(|x| x as f32);
            let opacity = own.and_then(|p| p.opacity).unwrap_or(shape.opacity) as f32;
            let target = &self.beams.targets()[i];
            if (target.color, target.opacity) != (color, opacity) {
                self.beams.set_color(i, color, opacity);
            }
        }
    }

    /// Moves the targets of shapes that have moved since the last update.
    fn move_targets(&mut self, scene: &Scene, pool: &ThreadPool) {
        let TargetSet { beams, places, first, moved, followed, .. } = self;
        match scene.moves.since(followed) {
            Some([]) => return,
            Some(slots) => {
                for slot in slots {
                    let Some(from) = first.get(*slot as usize).and_then(|i| i.checked_sub(1)) else { continue };
                    let world = scene.world(*slot);
                    let parts = places.iter().enumerate().skip(from as usize).take_while(|(_, p)| p.slot == *slot);
                    moved.extend(parts.map(|(i, p)| (i, world * p.pose)));
                }
            }
            None => {
                let all = places.iter().enumerate();
                moved.extend(all.map(|(i, p)| (i, scene.world(p.slot) * p.pose)));
                moved.retain(|(i, world)| *world != beams.targets()[*i].world_from_target);
            }
        }
        match moved[..] {
            [] => {}
            [(one, world)] => beams.update_pose(one, world),
            _ => pool.install(|| beams.update_poses(moved)),
        }
        moved.clear();
    }
}
