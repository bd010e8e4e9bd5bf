//! Builds the models, lights and sensors of a file in the scene.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};
use tatu_importers_robots::{
    BodyTree, BuildSettings, BuiltRobot, Element, FindingKind, Findings, Robot, RobotStructure, SensorBuilder, alias,
    build, magnetic_field, set_object_pose,
};
use tatu_plugin_api::safe::{Builder, Node, Params, Result};

use crate::{
    controllers::{self, WheelDrive},
    coverage::Coverage,
    files::SourceFiles,
    frames::{FrameReference, ModelScope, StatedPose, WORLD},
    joints::JointReader,
    model::{FileDraft, ModelDraft},
    propellers,
    shapes::{LinkPlace, LinkReader},
    world::{light, set_world},
};

/// The parts of an import that all models share.
struct FileBuilder<'w, 'b, 'e> {
    builder: &'w Builder<'b>,
    files: &'w SourceFiles<'w, 'b>,
    findings: &'w Findings,
    draft: &'w FileDraft<'e>,
    sensors: SensorBuilder<'w, 'b>,
    settings: &'w BuildSettings,
    /// Whether links of a model collide, if the parameter states it.
    self_collision: Option<bool>,
}

/// Builds a file, whose includes have been read.
pub fn file(
    builder: &Builder<'_>,
    root: &Element,
    files: &SourceFiles<'_, '_>,
    params: &Params<'_>,
    findings: &Findings,
) -> Result {
    let mut coverage = Coverage::default();
    coverage.add(root);
    for text in coverage.sentences() {
        findings.note(if text.starts_with("elements") { FindingKind::Unread } else { FindingKind::World }, 0, text);
    }
    let world = root.child("world");
    let around = world.unwrap_or(root);
    if root.named("world").count() > 1 {
        findings.warn(FindingKind::World, around.line, "the file has several worlds; the first one is read".to_owned());
    }
    set_world(builder, world, findings)?;
    let draft = FileDraft::new(around, findings)?;
    let settings = settings(params)?;
    let work = FileBuilder {
        builder,
        files,
        findings,
        draft: &draft,
        sensors: SensorBuilder { builder, findings, field: magnetic_field(world)? },
        settings: &settings,
        self_collision: params.get("self_collision")?.as_bool(),
    };
    // A model alone is the import itself.
    let others = around.children.iter().any(|c| matches!(c.name.as_str(), "light" | "actor"));
    if let ([model], None, false) = (draft.models.as_slice(), world, others) {
        return work.model(model, None).map(drop);
    }
    if draft.models.is_empty() && !others && world.is_none() {
        return Err(around.fail("the file contains no model and no world"));
    }
    let name = if around.label().is_empty() { "world" } else { around.label() };
    let base = builder.object("dummy", None, &alias(name))?.set("object.model_base", true)?;
    for model in &draft.models {
        work.model(model, Some(base))?;
    }
    for tag in around.named("light") {
        work.light(tag, base, &Isometry3::identity(), None)?;
    }
    if let Some(world) = world {
        // Models run no plugins of the world.
        let plugins: Vec<&Element> = world.named("plugin").collect();
        let mut none = empty_robot(String::new(), Isometry3::identity());
        controllers::apply(&plugins, &mut none, findings)?;
    }
    Ok(())
}

fn settings(params: &Params<'_>) -> Result<BuildSettings> {
    Ok(BuildSettings {
        fixed_base: params.bool("fixed_base")?,
        package_root: String::new(),
        motors: params.string("motors")?,
        default_effort: params.get("default_effort")?.as_f64(),
        friction: 1.0,
        wheels_as_balls: params.bool("wheels_as_balls")?,
        concave: params.bool("concave")?,
        decompose: params.get("decompose")?.as_i64().and_then(|n| u32::try_from(n).ok()).unwrap_or(0),
        self_collision: false,
        on_floor: params.bool("on_floor")?,
    })
}

fn empty_robot(name: String, pose: Isometry3<f64>) -> Robot {
    Robot { name, pose, links: Vec::new(), joints: Vec::new(), structure: RobotStructure::Graph, data: BTreeMap::new() }
}

impl<'b> FileBuilder<'_, 'b, '_> {
    /// Builds a model below the base of the world, or as the import itself. Returns its base.
    fn model(&self, model: &ModelDraft<'_>, world: Option<Node<'b>>) -> Result<Node<'b>> {
        let frames = &self.draft.frames;
        let pose = frames.world(model.frame)?;
        let mut robot = empty_robot(model.name.clone(), pose);
        if model.is_static {
            robot.structure = RobotStructure::Static;
        }
        let reader = LinkReader { files: self.files, frames, findings: self.findings };
        for link in model.links.iter().map(|link| &self.draft.links[*link]) {
            let place = LinkPlace { scope: &link.scope, frame: link.frame };
            let pose = frames.between(model.frame, link.frame)?;
            let mut read = reader.link(link.tag, link.name.clone(), pose, place)?;
            read.is_fixed = link.is_static;
            robot.links.push(read);
        }
        if robot.links.is_empty() && (model.is_static || model.joints.is_empty()) {
            let text = format!("the model `{}` has no links", model.name);
            self.findings.note(FindingKind::Unread, model.tag.line, text);
            let base = self.builder.object("dummy", world, &alias(&model.name))?.set("object.model_base", true)?;
            return set_object_pose(base, &pose);
        }
        let mut drive = None;
        if !model.is_static {
            let joints = JointReader { draft: self.draft, model, findings: self.findings };
            joints.read(&mut robot, |tag| self.files.version(tag))?;
            drive = controllers::apply(&model.plugins, &mut robot, self.findings)?;
        }
        let own = model.tag.flag("self_collide").unwrap_or(false);
        let settings = BuildSettings { self_collision: self.self_collision.unwrap_or(own), ..self.settings.clone() };
        let tree = BodyTree::new(&robot)?;
        let built = build(self.builder, world, &robot, &tree, &settings, self.findings)?;
        built.base.set("object.model_base", true)?;
        if let Some(drive) = &drive {
            self.drive(drive, &robot, &built, model)?;
        }
        for tag in
            model.plugins.iter().filter(|tag| controllers::short_name(tag) == propellers::PLUGIN && !model.is_static)
        {
            propellers::propeller(self.builder, tag, &robot, &built, self.findings)?;
        }
        self.attachments(model, &built)?;
        Ok(built.base)
    }

    /// Builds the sensors and lights of links.
    fn attachments(&self, model: &ModelDraft<'_>, built: &BuiltRobot<'b>) -> Result {
        let frames = &self.draft.frames;
        let reader = LinkReader { files: self.files, frames, findings: self.findings };
        for (number, link) in model.links.iter().enumerate() {
            let (part, place) = (&self.draft.links[*link], &built.links[number]);
            let own = LinkPlace { scope: &part.scope, frame: part.frame };
            for tag in part.tag.named("sensor") {
                let made =
                    reader.pose(tag, own).and_then(|pose| self.sensors.sensor(tag, place.node, &(place.pose * pose)));
                made.or_else(|e| self.left_out(&e, tag))?;
            }
            for tag in part.tag.named("light") {
                self.light(tag, place.node, &place.pose, Some(own))?;
            }
        }
        for tag in model.joints.iter().flat_map(|joint| joint.tag.named("sensor")) {
            let text = format!("the sensor `{}` of a joint is left out: place a `force_sensor` there", tag.label());
            self.findings.warn(FindingKind::Sensor, tag.line, text);
        }
        Ok(())
    }

    /// Reports that an element is left out because of an error in the file; other errors end the import.
    fn left_out(&self, e: &tatu_plugin_api::safe::Fail, tag: &Element) -> Result {
        let line = e.place().map_or(tag.line, |(_, line)| line);
        let text = format!("the {} `{}` is incomplete: {}", tag.name, tag.label(), e.text());
        self.findings.warn(FindingKind::Sensor, line, text);
        Ok(())
    }

    /// Builds a light below the object of a link, or in the world.
    fn light(&self, tag: &Element, parent: Node<'b>, at: &Isometry3<f64>, link: Option<LinkPlace<'_>>) -> Result {
        let pose = || match link {
            Some(place) => {
                LinkReader { files: self.files, frames: &self.draft.frames, findings: self.findings }.pose(tag, place)
            }
            None => {
                let StatedPose { pose, relative_to } = StatedPose::read(tag)?;
                let scope = ModelScope { prefix: String::new(), model: WORLD };
                let Some(name) = relative_to else { return Ok(pose) };
                let fail = || tag.fail(format!("its pose refers to the frame `{name}`, which does not exist"));
                let base = FrameReference::Named(scope, name.clone());
                let base = self.draft.frames.find(&base).ok_or_else(fail)?;
                Ok(self.draft.frames.world(base)? * pose)
            }
        };
        let made = pose().and_then(|pose| light(self.builder, tag, parent, &(at * pose)));
        made.or_else(|e| self.left_out(&e, tag))
    }

    /// Describes the drive of a model at its base.
    fn drive(&self, drive: &WheelDrive, robot: &Robot, built: &BuiltRobot<'b>, model: &ModelDraft<'_>) -> Result {
        let number = |name: &str| robot.joints.iter().position(|joint| joint.name == name);
        let path = |name: &str| {
            let of = number(name).and_then(|n| built.joints[n].as_ref());
            of.map_or(String::new(), |(_, path)| format!(":{path}"))
        };
        let frames = &self.draft.frames;
        let mut ahead = Vec::new();
        for name in &drive.joints {
            if let Some(part) = model.joints.iter().find(|part| part.name == *name) {
                let at = frames.between(model.frame, part.frame)? * Point3::origin();
                ahead.push(at.x);
            }
        }
        // Wheels of an axle have the same place ahead, those of several axles their middle.
        let axle = ahead.iter().sum::<f64>() / ahead.len().max(1) as f64;
        let is_complete = drive.joints.iter().chain(&drive.steering).all(|name| !path(name).is_empty());
        if is_complete {
            built.base.set("object.drive", drive.value(path, axle))?;
        }
        Ok(())
    }
}
