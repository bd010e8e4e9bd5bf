//! Reads links: their masses, visuals and collisions.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{Mass, Solid};
use tatu_importers_robots::{
    Element, FindingKind, Findings, Geometry, Inertial, Link, LinkShape, Surface, gazebo_color, is_true, shortened,
};
use tatu_plugin_api::safe::{Fail, Result};

use crate::{
    files::SourceFiles,
    frames::{FrameIndex, FrameReference, FrameTable, ModelScope, StatedPose},
};

/// Density that applies to an inertia that is computed, kg/m^3.
const DENSITY: f64 = 1000.0;
/// Largest coefficient of friction.
const MAX_FRICTION: f64 = 100.0;

/// What is needed to read links.
pub struct LinkReader<'w, 'b> {
    pub files: &'w SourceFiles<'w, 'b>,
    pub frames: &'w FrameTable,
    pub findings: &'w Findings,
}

/// Where a link is: its frame, and the model in which it is.
#[derive(Clone, Copy)]
pub struct LinkPlace<'m> {
    pub scope: &'m ModelScope,
    pub frame: FrameIndex,
}

impl LinkReader<'_, '_> {
    /// Reads a link; `pose` is its pose in the model.
    pub fn link(&self, tag: &Element, name: String, pose: Isometry3<f64>, place: LinkPlace<'_>) -> Result<Link> {
        let visuals = self.shapes(tag, "visual", FindingKind::Visual, (&name, place));
        let collisions = self.shapes(tag, "collision", FindingKind::Collision, (&name, place));
        if tag.flag("gravity") == Some(false) {
            let text = format!("the link `{name}` has no gravity in the file; here, gravity acts on all bodies");
            self.findings.warn(FindingKind::Gravity, tag.line, text);
        }
        if tag.flag("kinematic") == Some(true) {
            let text = format!("the link `{name}` is kinematic in the file; here, forces move it");
            self.findings.warn(FindingKind::Gravity, tag.line, text);
        }
        let inertial = self.inertial(tag, &collisions, &name)?;
        Ok(Link { line: tag.line, name, pose, is_fixed: false, inertial, visuals, collisions, friction: None })
    }

    /// Returns the pose of an element in the frame of its link.
    pub fn pose(&self, tag: &Element, place: LinkPlace<'_>) -> Result<Isometry3<f64>> {
        let StatedPose { pose, relative_to } = StatedPose::read(tag)?;
        let Some(name) = relative_to else { return Ok(pose) };
        let base = self.frames.find(&FrameReference::Named(place.scope.clone(), name.clone()));
        let base = base.ok_or_else(|| tag.fail(format!("its pose refers to `{name}`, which does not exist")))?;
        Ok(self.frames.between(place.frame, base)? * pose)
    }

    fn inertial(&self, link: &Element, collisions: &[LinkShape], name: &str) -> Result<Inertial> {
        let default = Inertial { pose: Isometry3::identity(), mass: 1.0, inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] };
        let Some(tag) = link.child("inertial") else { return Ok(default) };
        if tag.attribute("auto").is_some_and(is_true) {
            let stated = tag.finite("mass")?.filter(|mass| *mass > 0.0);
            return self.computed(link, tag, collisions, name).map(|computed| scaled(computed, stated));
        }
        let mass = tag.finite("mass")?.unwrap_or(default.mass);
        let pose = StatedPose::read(tag)?.pose;
        let mut inertia = default.inertia;
        if let Some(moments) = tag.child("inertia") {
            for (value, key) in inertia.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
                *value = moments.finite(key)?.unwrap_or(*value);
            }
        }
        Ok(Inertial { pose, mass, inertia })
    }

    /// Computes an inertia from the collisions and their densities.
    fn computed(&self, link: &Element, tag: &Element, collisions: &[LinkShape], name: &str) -> Result<Inertial> {
        let density = tag.finite("density")?.unwrap_or(DENSITY);
        let mut sum = Mass::ZERO;
        for collision in collisions {
            let Some(solid) = solid(&collision.geometry) else {
                let text = format!("the inertia of the link `{name}` is computed without its meshes and planes");
                self.findings.warn(FindingKind::ComputedInertia, collision.line, text);
                continue;
            };
            let own = link.named("collision").find(|c| c.line == collision.line);
            let density = own.map(|c| c.finite("density")).transpose()?.flatten().unwrap_or(density);
            sum = sum.combined_with(&solid.mass(None, density).moved(&collision.pose));
        }
        let i = sum.inertia;
        let inertia = [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]];
        Ok(Inertial { pose: Isometry3::translation(sum.com.x, sum.com.y, sum.com.z), mass: sum.mass, inertia })
    }

    fn shapes(
        &self,
        link: &Element,
        role: &str,
        kind: FindingKind,
        (name, place): (&str, LinkPlace<'_>),
    ) -> Vec<LinkShape> {
        let read = |tag: &Element| match self.shape(tag, place) {
            Ok(shape) => shape,
            Err(e) => {
                let line = e.place().map_or(tag.line, |(_, line)| line);
                let text = format!("the {role} `{}` of the link `{name}` is left out: {}", tag.label(), e.text());
                self.findings.warn(kind, line, text);
                None
            }
        };
        link.named(role).filter_map(read).collect()
    }

    fn shape(&self, tag: &Element, place: LinkPlace<'_>) -> Result<Option<LinkShape>> {
        let geometry = tag.child("geometry").ok_or_else(|| tag.fail("it has no <geometry>"))?;
        let Some((geometry, turn)) = self.geometry(geometry)? else { return Ok(None) };
        let pose = self.pose(tag, place)?;
        if let Some(mask) = tag.at(&["surface", "contact"]).and_then(|contact| contact.text_of("collide_bitmask")) {
            let is_zero = mask.trim().trim_start_matches("0x").chars().all(|c| c == '0');
            let outcome = if is_zero { "it is left out" } else { "it collides with everything" };
            let text = format!("the bits of a collision, `{}`, have no counterpart: {outcome}", shortened(mask));
            self.findings.warn(FindingKind::Collision, tag.line, text);
            if is_zero {
                return Ok(None);
            }
        }
        let surface = match tag.child("surface") {
            Some(surface) => self.surface(surface, &pose)?,
            None => Surface::default(),
        };
        Ok(Some(LinkShape { line: tag.line, pose: pose * turn, geometry, color: self.color(tag)?, surface }))
    }

    /// Reads a geometry, and how it is turned.
    fn geometry(&self, tag: &Element) -> Result<Option<(Geometry, Isometry3<f64>)>> {
        let upright = Isometry3::identity();
        let Some(form) = tag.children.iter().find(|c| c.name != "empty") else {
            return if tag.child("empty").is_some() { Ok(None) } else { Err(tag.fail("<geometry> is empty")) };
        };
        let geometry = match form.name.as_str() {
            "box" => Geometry::Box { size: form.numbers("size")?.unwrap_or([1.0; 3]) },
            "sphere" => Geometry::Sphere { radius: form.finite("radius")?.unwrap_or(1.0) },
            "ellipsoid" => Geometry::Ellipsoid { radii: form.numbers("radii")?.unwrap_or([1.0; 3]) },
            "cylinder" => {
                let length = form.finite("length")?.unwrap_or(1.0);
                Geometry::Cylinder { radius: form.finite("radius")?.unwrap_or(1.0), length }
            }
            "capsule" => {
                let length = form.finite("length")?.unwrap_or(1.0);
                Geometry::Capsule { radius: form.finite("radius")?.unwrap_or(0.5), length }
            }
            "plane" => {
                let normal = Vector3::from(form.numbers("normal")?.unwrap_or([0.0, 0.0, 1.0]));
                let normal = normal.try_normalize(1e-9).ok_or_else(|| form.fail("the normal of a plane is 0 0 0"))?;
                let size = Geometry::Plane { size: form.numbers("size")?.unwrap_or([1.0; 2]) };
                return Ok(Some((size, turn_z_to(&normal))));
            }
            "mesh" => {
                let uri = form.text_of("uri").ok_or_else(|| form.fail("<mesh> has no <uri>"))?;
                if form.child("submesh").is_some() {
                    let text = format!("a part of the mesh `{uri}` is named; the whole mesh is used");
                    self.findings.warn(FindingKind::MeshPart, form.line, text);
                }
                Geometry::Mesh { filename: self.files.path(form, uri), scale: form.numbers("scale")? }
            }
            other => return Err(form.fail(format!("the geometry <{other}> is not supported"))),
        };
        Ok(Some((geometry, upright)))
    }

    /// Reads how a collision rubs and rebounds; `pose` is that of the collision in its link.
    fn surface(&self, tag: &Element, pose: &Isometry3<f64>) -> Result<Surface> {
        let mut surface = Surface::default();
        let bounce = tag.child("bounce").map(|b| b.finite("restitution_coefficient")).transpose()?.flatten();
        surface.restitution = bounce.unwrap_or(0.0).clamp(0.0, 1.0);
        let Some(friction) = tag.child("friction") else { return Ok(surface) };
        let (ode, bullet) = (friction.child("ode"), friction.child("bullet"));
        let number = |of: Option<&Element>, name: &str| of.map(|e| e.number(name)).transpose().map(Option::flatten);
        let limited = |x: f64| if x.is_nan() { 1.0 } else { x.clamp(0.0, MAX_FRICTION) };
        let first = number(ode, "mu")?.or(number(bullet, "friction")?).map_or(1.0, limited);
        let second = number(ode, "mu2")?.or(number(bullet, "friction2")?).map_or(first, limited);
        let direction = match ode.filter(|e| e.child("fdir1").is_some()).or(bullet) {
            Some(of) => of.numbers::<3>("fdir1")?.map(Vector3::from).unwrap_or_default(),
            None => Vector3::zeros(),
        };
        if ode.is_some() || bullet.is_some() {
            surface.friction = Some((first + second) / 2.0);
        }
        if first != second {
            match direction.try_normalize(1e-9) {
                Some(axis) => {
                    surface.friction = Some(second);
                    surface.axis = Some(((pose * axis).into(), first));
                }
                None => {
                    let text = "`mu` and `mu2` differ without a direction `fdir1`: their mean is used".to_owned();
                    self.findings.warn(FindingKind::FrictionAxis, tag.line, text);
                }
            }
        }
        Ok(surface)
    }

    /// Returns the color and opacity of a visual.
    fn color(&self, tag: &Element) -> Result<Option<[f64; 4]>> {
        let opacity = 1.0 - tag.finite("transparency")?.unwrap_or(0.0).clamp(0.0, 1.0);
        let Some(material) = tag.child("material") else {
            // A mesh has the colours of its file.
            return Ok((opacity < 1.0).then_some([0.7, 0.7, 0.7, opacity]));
        };
        let numbers = |name: &str| {
            // Some files omit the opacity.
            let tag = material.child(name)?;
            let rgb = || tag.own_numbers().map(|[r, g, b]: [f64; 3]| [r, g, b, 1.0]);
            tag.own_numbers::<4>().or_else(|_| rgb()).ok()
        };
        let script = material.at(&["script"]).and_then(|s| s.text_of("name")).and_then(gazebo_color);
        if material.at(&["pbr", "metal", "albedo_map"]).or(material.at(&["pbr", "specular", "albedo_map"])).is_some() {
            let text = "images of materials are left out; the colour `diffuse` is used".to_owned();
            self.findings.note(FindingKind::Material, material.line, text);
        }
        let color = numbers("diffuse").or(script).or_else(|| numbers("ambient"));
        Ok(color.map(|[r, g, b, a]| [r, g, b, a * opacity]))
    }
}

/// Scales a computed inertia to a mass, if the file states one, as if the density had been chosen for it.
fn scaled(computed: Inertial, mass: Option<f64>) -> Inertial {
    match mass {
        Some(mass) if computed.mass > 0.0 => {
            let share = mass / computed.mass;
            Inertial { mass, inertia: computed.inertia.map(|x| x * share), ..computed }
        }
        _ => computed,
    }
}

/// Returns the least rotation that turns the z axis to a direction.
pub fn turn_z_to(direction: &Vector3<f64>) -> Isometry3<f64> {
    let half = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let turn = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), direction).unwrap_or(half);
    Isometry3::from_parts(nalgebra::Translation3::identity(), turn)
}

/// Returns the volume and inertia of a form; `None` for meshes and planes.
fn solid(geometry: &Geometry) -> Option<Solid> {
    Some(match geometry {
        Geometry::Box { size } => Solid::cuboid(size.map(|x| x / 2.0)),
        Geometry::Sphere { radius } => Solid::ellipsoid([*radius; 3]),
        Geometry::Ellipsoid { radii } => Solid::ellipsoid(*radii),
        Geometry::Cylinder { radius, length } => Solid::cylinder(*radius, length / 2.0),
        Geometry::Capsule { radius, length } => Solid::capsule(*radius, length / 2.0),
        Geometry::Plane { .. } | Geometry::Mesh { .. } => return None,
    })
}

/// Adds the name of what could not be read to an error.
pub fn with_context(e: Fail, tag: &Element) -> Fail {
    let line = e.place().map_or(tag.line, |(_, line)| line);
    Fail::argument(format!("the {} `{}` cannot be read: {}", tag.name, tag.label(), e.text())).at("", line)
}
