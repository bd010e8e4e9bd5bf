//! Reads the tree of bodies, with the elements that add poses to their contents: frames, replicas and attached files.

use std::rc::Rc;

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use tatu_importers_common::Mass;
use tatu_plugin_api::safe::Result;

use super::{MAX_ATTACHED, Reader, Source};
use crate::{
    attributes::Attributes,
    compiler::{Compiler, turn_to},
    defaults::MAIN,
    model::{Body, Camera, Joint, JointKind, Light, Site},
    xml::{Element, MAX_DEPTH},
};

/// Maximum number of replicas of one element.
const MAX_REPLICAS: i64 = 10_000;
/// Vertical angle of view of cameras that state none, degrees.
const DEFAULT_FOVY_DEG: f64 = 45.0;

/// Where the contents of a body are read.
#[derive(Clone)]
struct Surroundings {
    source: Rc<Source>,
    /// Index of the body.
    body: usize,
    /// Pose of the frames within the body.
    frame: Isometry3<f64>,
    /// Default class.
    class: String,
    /// What follows the names of replicas.
    suffix: String,
    depth: usize,
}

impl Surroundings {
    fn name(&self, element: &Element) -> Option<String> {
        let name = element.attribute("name").filter(|n| !n.is_empty())?;
        Some(format!("{}{}", self.source.named(name), self.suffix))
    }
    fn name_or(&self, element: &Element, default: impl Fn() -> String) -> String {
        self.name(element).unwrap_or_else(default)
    }
    fn attributes<'a>(&'a self, element: &'a Element, kind: &str) -> Result<Attributes<'a>> {
        self.source.defaults.attributes(element, kind, &self.class)
    }
    fn pose(&self, a: &Attributes<'_>) -> Result<Isometry3<f64>> {
        Ok(self.frame * self.source.compiler.pose(a)?)
    }
}

impl Reader<'_, '_> {
    /// Reads the world and everything in it.
    pub(super) fn world(&mut self, source: &Rc<Source>) -> Result {
        let place = source.root.place.clone();
        self.model.bodies.push(body("world".into(), 0, Isometry3::identity(), place));
        for element in source.root.named("worldbody") {
            let within = Surroundings {
                source: source.clone(),
                body: 0,
                frame: Isometry3::identity(),
                class: element.attribute("childclass").unwrap_or(MAIN).to_owned(),
                suffix: String::new(),
                depth: 1,
            };
            self.contents(element, &within)?;
        }
        Ok(())
    }

    fn contents(&mut self, of: &Element, within: &Surroundings) -> Result {
        if within.depth > MAX_DEPTH {
            return Err(of.fail(format!("bodies are nested more than {MAX_DEPTH} levels deep")));
        }
        for element in &of.children {
            match element.name.as_str() {
                "body" => self.body(element, within)?,
                "frame" => self.frame(element, within)?,
                "replicate" => self.replicate(element, within)?,
                "attach" => self.attach(element, within)?,
                "joint" | "freejoint" => self.joint(element, within)?,
                "inertial" => {
                    let found = inertial(&Attributes::new(element, None), &within.source.compiler)?;
                    self.model.bodies[within.body].inertial = Some(found.moved(&within.frame));
                }
                "geom" => {
                    let a = within.attributes(element, "geom")?;
                    let name = within.name_or(element, String::new);
                    self.count_part(element)?;
                    if let Some(mut geom) = self.geom(&within.source, &a, name)? {
                        geom.pose = within.frame * geom.pose;
                        geom.mass = geom.mass.moved(&within.frame);
                        self.model.bodies[within.body].geoms.push(geom);
                    }
                }
                "site" => self.site(element, within)?,
                "camera" => self.camera(element, within)?,
                "light" => self.light(element, within)?,
                "composite" | "flexcomp" | "flex" => {
                    self.report
                        .warn(&element.place, format!("<{}> is omitted: soft bodies are not supported", element.name));
                }
                // Listed by `coverage`.
                _ => {}
            }
        }
        Ok(())
    }

    fn body(&mut self, element: &Element, within: &Surroundings) -> Result {
        self.count_part(element)?;
        let number = self.model.bodies.len();
        let a = Attributes::new(element, None);
        let name = within.name_or(element, || format!("body_{number}"));
        let mut new = body(name, within.body, within.pose(&a)?, element.place.clone());
        new.is_mocap = a.switch("mocap")?.unwrap_or(false);
        self.model.bodies.push(new);
        let inside = Surroundings {
            source: within.source.clone(),
            body: number,
            frame: Isometry3::identity(),
            class: element.attribute("childclass").unwrap_or(&within.class).to_owned(),
            suffix: within.suffix.clone(),
            depth: within.depth + 1,
        };
        self.contents(element, &inside)?;
        let body = &self.model.bodies[number];
        if body.is_free && (within.body != 0 || !body.joints.is_empty()) {
            return Err(element.fail("a body that moves freely must be at the top level and have no other joints"));
        }
        Ok(())
    }

    fn frame(&mut self, element: &Element, within: &Surroundings) -> Result {
        let a = Attributes::new(element, None);
        let inside = Surroundings {
            frame: within.pose(&a)?,
            class: element.attribute("childclass").unwrap_or(&within.class).to_owned(),
            depth: within.depth + 1,
            ..within.clone()
        };
        self.contents(element, &inside)
    }

    fn replicate(&mut self, element: &Element, within: &Surroundings) -> Result {
        let a = Attributes::new(element, None);
        let count = a.integer("count", 0)?;
        if !(0..=MAX_REPLICAS).contains(&count) {
            return Err(a.invalid("count", &format!("0 to {MAX_REPLICAS}")));
        }
        let offset = Vector3::from(a.array::<3>("offset")?.unwrap_or_default());
        let euler = a.array::<3>("euler")?.unwrap_or_default();
        let separator = a.text("sep").unwrap_or_default();
        let width = (count - 1).max(0).to_string().len();
        let mut at = Vector3::zeros();
        for i in 0..count {
            self.count_part(element)?;
            let turn = within.source.compiler.euler(euler.map(|x| x * i as f64));
            let pose = Isometry3::from_parts(Translation3::from(at), turn);
            // Each offset is along the axes of the replica before it.
            at += turn * offset;
            let inside = Surroundings {
                frame: within.frame * pose,
                suffix: format!("{separator}{i:0width$}{}", within.suffix),
                depth: within.depth + 1,
                ..within.clone()
            };
            self.contents(element, &inside)?;
        }
        Ok(())
    }

    /// Reads a body of another file, with that file's settings and the sections that concern it.
    fn attach(&mut self, element: &Element, within: &Surroundings) -> Result {
        let outer = within.source.clone();
        let model = element.attribute("model").ok_or_else(|| element.fail("<attach> has no `model`"))?;
        let asset = outer.root.section("asset").find(|a| {
            let named =
                || a.attribute("file").map(|f| f.rsplit('/').next().unwrap_or(f).split('.').next().unwrap_or(f));
            a.name == "model" && a.attribute("name").or_else(named) == Some(model)
        });
        let asset = asset.ok_or_else(|| element.fail(format!("there is no model asset `{model}`")))?;
        if outer.depth >= MAX_ATTACHED {
            return Err(element.fail(format!("files are attached more than {MAX_ATTACHED} levels deep")));
        }
        let file = asset.attribute("file").ok_or_else(|| asset.fail("<model> has no `file`"))?;
        let Some((path, bytes)) = self.files.find(file, outer.folder(), &asset.place.file) else {
            return Err(asset.fail(format!("the file `{file}` of the model `{model}` does not exist")));
        };
        let prefix = outer.named(element.attribute("prefix").unwrap_or_default());
        let source = self.source(bytes, &path, &prefix, outer.depth + 1)?;
        let inside =
            Surroundings { source: source.clone(), class: MAIN.into(), depth: within.depth + 1, ..within.clone() };
        match element.attribute("body") {
            Some(name) => {
                let found = source.root.named("worldbody").find_map(|w| find_body(w, name));
                let found = found.ok_or_else(|| element.fail(format!("`{path}` has no body `{name}`")))?;
                self.body(found, &inside)?;
            }
            None => source.root.named("worldbody").try_for_each(|w| self.contents(w, &inside))?,
        }
        self.sections(&source)
    }

    fn joint(&mut self, element: &Element, within: &Surroundings) -> Result {
        self.count_part(element)?;
        let a = match element.name.as_str() {
            "freejoint" => Attributes::new(element, None),
            _ => within.attributes(element, "joint")?,
        };
        let c = &within.source.compiler;
        let kind = match a.text("type").as_deref() {
            Some("free") => None,
            _ if element.name == "freejoint" => None,
            None | Some("hinge") => Some(JointKind::Hinge),
            Some("slide") => Some(JointKind::Slide),
            Some("ball") => Some(JointKind::Ball),
            Some(_) => return Err(a.invalid("type", "free, ball, slide or hinge")),
        };
        let Some(kind) = kind else {
            self.model.bodies[within.body].is_free = true;
            self.model.bodies[within.body].damping = a.positive("damping", 0.0)?;
            for name in ["stiffness", "armature", "frictionloss"] {
                if a.number(name, 0.0)? != 0.0 {
                    self.report.warn(&element.place, format!("`{name}` of free joints is omitted"));
                }
            }
            return Ok(());
        };
        if within.body == 0 {
            return Err(element.fail("the world cannot have a joint"));
        }
        let unit = |x: f64| if kind == JointKind::Slide { x } else { c.angle(x) };
        let axis = Unit::try_new(Vector3::from(a.array::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0])), 1e-14);
        let axis = axis.ok_or_else(|| a.invalid("axis", "a vector that is not 0"))?;
        let range = a.array::<2>("range")?;
        let limited = match a.switch("limited")? {
            Some(limited) => limited,
            None => c.auto_limits && range.is_some_and(|r| r != [0.0, 0.0]),
        };
        let range = range.filter(|_| limited).map(|r| r.map(unit));
        if kind != JointKind::Ball && range.is_some_and(|[low, high]| low > high) {
            return Err(a.invalid("range", "the lower limit first"));
        }
        let forces = a.array::<2>("actuatorfrcrange")?;
        let bounded =
            a.switch("actuatorfrclimited")?.unwrap_or(c.auto_limits && forces.is_some_and(|r| r != [0.0, 0.0]));
        let number = self.model.bodies[within.body].joints.len();
        let body_name = self.model.bodies[within.body].name.clone();
        let unnamed = || if number == 0 { format!("{body_name}_joint") } else { format!("{body_name}_joint_{number}") };
        let at = Vector3::from(a.array::<3>("pos")?.unwrap_or_default());
        let joint = Joint {
            name: within.name_or(element, unnamed),
            kind,
            at: within.frame.transform_point(&at.into()).coords,
            axis: within.frame.rotation * axis.into_inner(),
            range,
            reference: if kind == JointKind::Ball { 0.0 } else { unit(a.number("ref", 0.0)?) },
            rest: unit(a.number("springref", 0.0)?),
            stiffness: a.positive("stiffness", 0.0)?,
            damping: a.positive("damping", 0.0)?,
            armature: a.positive("armature", 0.0)?,
            friction: a.positive("frictionloss", 0.0)?,
            max_force: forces.filter(|_| bounded).map(|[low, high]| low.abs().max(high.abs())),
            spring_damper: a.array::<2>("springdamper")?.filter(|[time, ratio]| *time > 0.0 && *ratio > 0.0),
            place: element.place.clone(),
        };
        self.model.bodies[within.body].joints.push(joint);
        Ok(())
    }

    fn site(&mut self, element: &Element, within: &Surroundings) -> Result {
        self.count_part(element)?;
        let a = within.attributes(element, "site")?;
        let mut pose = within.source.compiler.pose(&a)?;
        let [x, y, z] = a.partial("size", [0.005; 3])?;
        let mut size = match a.text("type").as_deref() {
            None | Some("sphere") => [x; 3],
            Some("capsule") => [x, x, x + y],
            Some("cylinder") => [x, x, y],
            _ => [x, y, z],
        };
        if let Some((middle, half)) = ends(&a)? {
            pose = middle;
            size[2] = half;
        }
        let number = self.model.bodies[within.body].sites.len();
        let unnamed = || format!("site_{number}");
        let site = Site { name: within.name_or(element, unnamed), pose: within.frame * pose, size };
        self.model.bodies[within.body].sites.push(site);
        Ok(())
    }

    fn camera(&mut self, element: &Element, within: &Surroundings) -> Result {
        self.count_part(element)?;
        let a = within.attributes(element, "camera")?;
        let mut angle = a.number("fovy", DEFAULT_FOVY_DEG)?.to_radians();
        if let (Some([_, height]), Some([_, focal])) = (a.array::<2>("sensorsize")?, a.array::<2>("focal")?)
            && focal > 0.0
        {
            angle = 2.0 * libm::atan(height / (2.0 * focal));
        }
        if a.text("mode").is_some_and(|m| m != "fixed") {
            self.report.note(&element.place, "`mode` of cameras is omitted: they are fixed to their bodies");
        }
        let camera = Camera { name: within.name_or(element, || "camera".into()), pose: within.pose(&a)?, angle };
        self.model.bodies[within.body].cameras.push(camera);
        Ok(())
    }

    fn light(&mut self, element: &Element, within: &Surroundings) -> Result {
        self.count_part(element)?;
        let a = within.attributes(element, "light")?;
        let direction = Unit::try_new(Vector3::from(a.array::<3>("dir")?.unwrap_or([0.0, 0.0, -1.0])), 1e-14);
        let turn = direction.map_or_else(UnitQuaternion::identity, |d| turn_to(&d));
        let at = Translation3::from(Vector3::from(a.array::<3>("pos")?.unwrap_or_default()));
        let kind = a.text("type").unwrap_or_default();
        let light = Light {
            name: within.name_or(element, || "light".into()),
            pose: within.frame * Isometry3::from_parts(at, turn),
            directional: a.switch("directional")?.unwrap_or(kind == "directional"),
            diffuse: a.array("diffuse")?.unwrap_or([0.7; 3]),
            cutoff: a.number("cutoff", 45.0)?.to_radians(),
        };
        self.model.bodies[within.body].lights.push(light);
        Ok(())
    }
}

/// Returns the pose of something between two ends, whose z axis points from the second to the first, and half their
/// distance.
pub(super) fn ends(a: &Attributes<'_>) -> Result<Option<(Isometry3<f64>, f64)>> {
    let Some([x1, y1, z1, x2, y2, z2]) = a.array::<6>("fromto")? else { return Ok(None) };
    let (one, other) = (Vector3::new(x1, y1, z1), Vector3::new(x2, y2, z2));
    let direction = Unit::try_new(one - other, 1e-12).ok_or_else(|| a.invalid("fromto", "two different points"))?;
    let pose = Isometry3::from_parts(Translation3::from((one + other) / 2.0), turn_to(&direction));
    Ok(Some((pose, (one - other).norm() / 2.0)))
}

fn body(name: String, parent: usize, pose: Isometry3<f64>, place: crate::xml::Place) -> Body {
    Body {
        name,
        parent,
        pose,
        joints: Vec::new(),
        is_free: false,
        damping: 0.0,
        is_mocap: false,
        geoms: Vec::new(),
        sites: Vec::new(),
        cameras: Vec::new(),
        lights: Vec::new(),
        inertial: None,
        mass: Mass::ZERO,
        place,
    }
}

fn find_body<'a>(within: &'a Element, name: &str) -> Option<&'a Element> {
    within.children.iter().find_map(|c| match c.name.as_str() {
        "body" if c.attribute("name") == Some(name) => Some(c),
        "body" | "frame" => find_body(c, name),
        _ => None,
    })
}

fn inertial(a: &Attributes<'_>, compiler: &Compiler) -> Result<Mass> {
    let mass = a.positive("mass", 0.0)?;
    let pose = compiler.pose(a)?;
    let inertia = match (a.array::<6>("fullinertia")?, a.array::<3>("diaginertia")?) {
        (Some([xx, yy, zz, xy, xz, yz]), _) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        (None, Some(moments)) => Matrix3::from_diagonal(&Vector3::from(moments)),
        (None, None) => Matrix3::zeros(),
    };
    Ok(Mass { mass, com: Vector3::zeros(), inertia }.moved(&pose))
}
