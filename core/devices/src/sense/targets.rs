//! The scene as beams and images see it, followed as things move.

use ::tatu_beams::{BeamScene, Target};
use nalgebra::Isometry3;
use rayon::ThreadPool;
use tatu_scene::{Object, Scene, Shape, visible_parts};

/// The forms of a scene that can be seen.
#[derive(Default)]
pub struct Targets {
    /// What is detectable.
    pub detectable: Seen,
    /// What is visible.
    pub visible: Seen,
    /// What beams of some waves detect, where that is not all that is detectable.
    by_waves: Vec<(u16, Seen)>,
    /// Whether anything is detectable by some waves only, as of the scene's version of shapes.
    selective: (u64, bool),
}

/// Some of the scene's forms.
#[derive(Default)]
pub struct Seen {
    pub beams: BeamScene,
    /// Where each target comes from.
    places: Vec<Place>,
    /// For each slot, the first of its targets plus one; 0: it has none. They stand together.
    first: Vec<u32>,
    /// The scene's versions of shapes and of views that it was made of.
    built: (u64, u64),
    /// The scene's version of colors that it shows.
    colored: u64,
    /// Up to where the scene's moves have been followed.
    followed: u64,
    /// Room for targets that have moved.
    moved: Vec<(usize, Isometry3<f64>)>,
}

/// Where a target comes from.
struct Place {
    slot: u32,
    pose: Isometry3<f64>,
    /// The part's color, if not the shape's.
    color: Option<[f64; 3]>,
}

impl Targets {
    /// Brings what is detectable up to the scene, or what is visible; many moves are worked on by the threads of `pool`.
    pub fn follow(&mut self, scene: &Scene, visible: bool, pool: &ThreadPool) {
        if visible {
            self.visible.follow(scene, pool, |o, _| o.is_visible());
        } else {
            self.detectable.follow(scene, pool, |_, s| s.is_detectable() && s.detectable_mask != 0);
        }
    }

    /// Brings what these waves detect up to the scene.
    pub fn follow_waves(&mut self, scene: &Scene, waves: u16, pool: &ThreadPool) {
        if self.selective.0 != scene.shape_version {
            let mut shapes = scene.tree(0).into_iter().filter_map(|slot| scene.get(slot)?.shape());
            self.selective = (scene.shape_version, shapes.any(|s| s.detectable_mask != u16::MAX));
            self.by_waves.clear();
        }
        if waves == u16::MAX || !self.selective.1 {
            return self.follow(scene, false, pool);
        }
        let at = self.by_waves.iter().position(|(w, _)| *w == waves).unwrap_or_else(|| {
            self.by_waves.push((waves, Seen::default()));
            self.by_waves.len() - 1
        });
        self.by_waves[at].1.follow(scene, pool, |_, s| s.is_detectable() && s.detectable_mask & waves != 0);
    }

    /// What is visible, or what beams of these waves detect.
    pub fn seen(&self, visible: bool, waves: u16) -> &BeamScene {
        let own = || self.by_waves.iter().find(|(w, _)| *w == waves).map(|(_, seen)| &seen.beams);
        if visible { self.beams(true) } else { own().unwrap_or_else(|| self.beams(false)) }
    }

    /// What is visible, or detectable.
    pub fn beams(&self, visible: bool) -> &BeamScene {
        if visible { &self.visible.beams } else { &self.detectable.beams }
    }
}

impl Seen {
    fn follow(&mut self, scene: &Scene, pool: &ThreadPool, wanted: impl Fn(&Object, &Shape) -> bool) {
        let version = (scene.shape_version, scene.seen_version);
        if self.built == version {
            self.keep_up(scene, pool);
            if self.colored != scene.color_version {
                self.color(scene);
            }
            return;
        }
        (self.built, self.colored) = (version, scene.color_version);
        scene.moves.since(&mut self.followed);
        self.places.clear();
        self.first.clear();
        let mut targets = Vec::new();
        for slot in scene.tree(0) {
            let Some(o) = scene.get(slot) else { continue };
            let Some(shape) = o.shape().filter(|s| wanted(o, s)) else { continue };
            if self.first.len() <= slot as usize {
                self.first.resize(slot as usize + 1, 0);
            }
            self.first[slot as usize] = self.places.len() as u32 + 1;
            for part in visible_parts(shape) {
                self.places.push(Place { slot, pose: part.pose, color: part.color });
                targets.push(Target {
                    object: scene.id(slot),
                    group: scene.model_of(slot),
                    world_from_target: scene.world(slot) * part.pose,
                    form: part.form,
                    color: part.color.unwrap_or(shape.color).map(|x| x as f32),
                });
            }
        }
        self.beams.set(targets);
    }

    /// Brings the colors of targets up to the scene.
    fn color(&mut self, scene: &Scene) {
        self.colored = scene.color_version;
        for (i, place) in self.places.iter().enumerate() {
            let Some(shape) = scene.get(place.slot).and_then(|o| o.shape()) else { continue };
            let color = place.color.unwrap_or(shape.color).map(|x| x as f32);
            if self.beams.targets()[i].color != color {
                self.beams.set_color(i, color);
            }
        }
    }

    /// Moves the targets of shapes that have moved since the last look.
    fn keep_up(&mut self, scene: &Scene, pool: &ThreadPool) {
        let Seen { beams, places, first, moved, followed, .. } = self;
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
