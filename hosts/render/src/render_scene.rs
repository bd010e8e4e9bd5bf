//! The contents of a picture.

use ::tatu_beams::{Beam, BeamScene, BeamTarget, Faces, Hit, Volume, bounds};
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use tatu_core::figures::Figures;
use tatu_geometry::Form;
use tatu_scene::{Scene, visible_parts};

use super::{Camera, LineSegment, light::LinearColor, marks};

/// The surfaces that a picture can show, as targets for rays.
pub(super) struct RenderScene {
    solids: BeamScene,
    /// The solids that cast shadows, if these are not all: translucent ones do not.
    occluders: Option<BeamScene>,
    marks: BeamScene,
    /// Colours of the solids, followed by those of the marks.
    colors: Vec<LinearColor>,
    /// Whether each solid is a plane.
    planes: Vec<bool>,
    /// Height of the rendered floor, in metres; `None` if the scene has a visible plane or no floor was requested.
    floor: Option<f64>,
}

/// The surface seen in a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenSurface {
    pub kind: SurfaceKind,
    pub distance: f64,
    pub point: Point3<f64>,
    /// Unit normal of the surface, on the side that faces the eye.
    pub normal: Vector3<f64>,
}

/// What a ray hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SurfaceKind {
    Sky,
    /// The floor rendered for a scene without one.
    Floor,
    /// A solid, by index, and the index of the primitive that was hit.
    Solid(u32, u32),
    Mark(u32),
}

/// Maximum viewing distance, in metres.
const MAX_VIEW_DISTANCE_M: f64 = 1e4;
/// Distance, in metres, by which the rendered floor is below z = 0 and the lowest form. It keeps the floor from
/// coinciding with floors built from boxes.
const FLOOR_GAP_M: f64 = 1e-4;

impl RenderScene {
    pub fn of(scene: &Scene, figures: &Figures, camera: &Camera, lines: &[LineSegment], ground: bool) -> Self {
        let (mut targets, mut colors) = (Vec::new(), Vec::new());
        for (slot, o) in scene.slots() {
            let Some(shape) = o.shape().filter(|_| o.is_visible()) else { continue };
            for part in visible_parts(shape) {
                let target = target(targets.len(), scene.world(slot) * part.pose, part.form);
                let color = part.color.unwrap_or(shape.color);
                let opacity = part.opacity.unwrap_or(shape.opacity) as f32;
                targets.push(BeamTarget { texture: part.texture, color: color.map(|x| x as f32), opacity, ..target });
                colors.push(LinearColor::of(color));
            }
        }
        let planes: Vec<bool> = targets.iter().map(|t| t.form == Form::Plane).collect();
        let mut drawn = Vec::new();
        for mark in marks::collect_marks(scene, figures, camera, lines) {
            drawn.push(target(targets.len() + drawn.len(), mark.pose, mark.form));
            colors.push(LinearColor::of(mark.color));
        }
        let (mut solids, mut marks) = (BeamScene::default(), BeamScene::default());
        let lowest =
            targets.iter().filter_map(|t| Some(bounds(&t.form, &t.world_from_target)?[0].z)).fold(0.0, f64::min);
        let floor = (ground && !planes.contains(&true)).then_some(lowest - FLOOR_GAP_M);
        solids.set(targets);
        marks.set(drawn);
        let occluders = solids.has_translucent_targets().then(|| {
            let mut opaque = BeamScene::default();
            opaque.set(solids.targets().iter().filter(|t| t.opacity >= 1.0).cloned());
            opaque
        });
        RenderScene { solids, occluders, marks, colors, planes, floor }
    }

    /// Returns the nearest surface along a ray from `eye`.
    pub fn nearest_surface(&self, eye: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> SeenSurface {
        let sight = EyeRay::new(eye, direction);
        let hit = self.solids.cast_one(&sight.beam);
        let best = if hit.is_some() { sight.solid(&hit) } else { sight.sky() };
        self.nearest_other(&sight, best)
    }

    /// Returns the nearest surface along a ray from `eye` that is not invisible, and fills `behind` with the surfaces
    /// that are seen through it, from near to far; the last one is opaque.
    pub fn visible_surfaces(
        &self,
        eye: &Point3<f64>,
        direction: &Unit<Vector3<f64>>,
        behind: &mut Vec<SeenSurface>,
    ) -> SeenSurface {
        behind.clear();
        let nearest = self.nearest_surface(eye, direction);
        if self.opacity(&nearest) >= 1.0 {
            return nearest;
        }
        let (sight, mut layers) = (EyeRay::new(eye, direction), Vec::new());
        self.solids.surfaces_along(&sight.beam, &mut layers);
        let last = self.nearest_other(&sight, sight.sky());
        behind.extend(layers.iter().map(|l| sight.solid(&l.hit)).filter(|s| s.distance <= last.distance));
        if behind.last().is_none_or(|s| self.opacity(s) < 1.0) {
            behind.push(last);
        }
        behind.remove(0)
    }

    /// Returns the opacity of a surface.
    pub fn opacity(&self, seen: &SeenSurface) -> f64 {
        match seen.kind {
            SurfaceKind::Solid(i, _) => self.solids.targets().get(i as usize).map_or(1.0, |t| f64::from(t.opacity)),
            _ => 1.0,
        }
    }

    /// Returns the floor or a mark, if it is nearer than `best`, otherwise `best`.
    fn nearest_other(&self, sight: &EyeRay, mut best: SeenSurface) -> SeenSurface {
        let mark = self.marks.cast_one(&sight.beam);
        if let Some(floor) = self.floor
            && sight.eye.z > floor
            && let down = (floor - sight.eye.z) / sight.direction.z
            && down > 0.0
            && down < best.distance.min(MAX_VIEW_DISTANCE_M)
        {
            let point = sight.at(down);
            best = SeenSurface { kind: SurfaceKind::Floor, distance: down, point, normal: Vector3::z() };
        }
        if mark.distance < best.distance {
            best = sight.seen(&mark, SurfaceKind::Mark(mark.object as u32));
        }
        best
    }

    /// Returns whether a ray from a point hits a solid within the distance `far`. Marks and translucent solids cast
    /// no shadows.
    pub fn is_blocked(&self, from: &Point3<f64>, direction: &Unit<Vector3<f64>>, far: f64) -> bool {
        self.occluders.as_ref().unwrap_or(&self.solids).cast_one(&ray(from, direction, 0.0, far)).is_some()
    }

    /// Returns the unlit colour of a surface.
    pub fn color(&self, seen: &SeenSurface) -> LinearColor {
        match seen.kind {
            SurfaceKind::Solid(i, primitive) => {
                let color = self.colors.get(i as usize).copied().unwrap_or(LinearColor::FLOOR);
                let target = &self.solids.targets()[i as usize];
                let Some(texture) = &target.texture else { return color };
                let point = target.world_from_target.inverse_transform_point(&seen.point);
                let normal = target.world_from_target.rotation.inverse_transform_vector(&seen.normal);
                let surface = (&target.form, primitive);
                LinearColor::of(texture.color(surface, &point, &normal, target.color).map(f64::from))
            }
            SurfaceKind::Mark(i) => self.colors.get(i as usize).copied().unwrap_or(LinearColor::FLOOR),
            SurfaceKind::Floor | SurfaceKind::Sky => LinearColor::FLOOR,
        }
    }

    /// Returns whether the grid is drawn on a surface: on the rendered floor, and on other surfaces that face up and
    /// either are planes or are within 1 mm of z = 0.
    pub fn has_grid(&self, seen: &SeenSurface) -> bool {
        match seen.kind {
            SurfaceKind::Floor => true,
            SurfaceKind::Solid(i, _) => {
                let flat = seen.normal.z > 0.999;
                flat && (self.planes.get(i as usize) == Some(&true) || seen.point.z.abs() < 1e-3)
            }
            _ => false,
        }
    }
}

/// A ray from the eye.
struct EyeRay {
    eye: Point3<f64>,
    direction: Vector3<f64>,
    beam: Beam,
}

impl EyeRay {
    fn new(eye: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> Self {
        let beam = ray(eye, direction, 0.0, MAX_VIEW_DISTANCE_M);
        EyeRay { eye: *eye, direction: direction.into_inner(), beam }
    }

    fn at(&self, distance: f64) -> Point3<f64> {
        self.eye + self.direction * distance
    }

    fn seen(&self, hit: &Hit, kind: SurfaceKind) -> SeenSurface {
        let normal = self.beam.world_from_beam.rotation * hit.normal;
        SeenSurface { kind, distance: hit.distance, point: self.at(hit.distance), normal }
    }

    fn solid(&self, hit: &Hit) -> SeenSurface {
        self.seen(hit, SurfaceKind::Solid(hit.object as u32, hit.primitive))
    }

    fn sky(&self) -> SeenSurface {
        SeenSurface { kind: SurfaceKind::Sky, distance: f64::INFINITY, point: self.eye, normal: Vector3::zeros() }
    }
}

fn target(index: usize, pose: Isometry3<f64>, form: Form) -> BeamTarget {
    BeamTarget {
        object: index as u64,
        group: 0,
        world_from_target: pose,
        form,
        color: [0.0; 3],
        opacity: 1.0,
        texture: None,
    }
}

fn ray(from: &Point3<f64>, direction: &Unit<Vector3<f64>>, near: f64, far: f64) -> Beam {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Beam {
        world_from_beam: Isometry3::from_parts((*from).into(), turn),
        volume: Volume::Ray,
        near,
        far,
        max_incidence: std::f64::consts::FRAC_PI_2,
        faces: Faces::BOTH,
        skip_group: None,
        only_object: None,
    }
}
