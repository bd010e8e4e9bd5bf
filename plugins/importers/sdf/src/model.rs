//! Collects the models of a file: their links, joints and frames, with those of models nested in them.

use std::collections::BTreeMap;

use tatu_importers_robots::{Element, FindingKind, Findings, is_true};
use tatu_plugin_api::safe::Result;

use crate::frames::{FrameIndex, FrameKind, FrameReference, FrameTable, ModelScope, StatedPose, WORLD};

/// Maximum number of models, links and joints in total.
const MAX_PARTS: usize = 50_000;

/// A link, or a joint.
pub struct PartDraft<'e> {
    pub tag: &'e Element,
    /// Its name, with those of nested models in front.
    pub name: String,
    pub frame: FrameIndex,
    /// The model that contains it.
    pub scope: ModelScope,
    /// Whether the model that contains it does not move.
    pub is_static: bool,
}

/// A model that is not nested in another one.
pub struct ModelDraft<'e> {
    pub tag: &'e Element,
    pub name: String,
    pub frame: FrameIndex,
    pub is_static: bool,
    /// Numbers of the links among those of all models.
    pub links: Vec<usize>,
    pub joints: Vec<PartDraft<'e>>,
    pub plugins: Vec<&'e Element>,
}

/// All models of a file.
pub struct FileDraft<'e> {
    pub frames: FrameTable,
    pub models: Vec<ModelDraft<'e>>,
    /// The links of all models.
    pub links: Vec<PartDraft<'e>>,
    parts: usize,
    /// For full names of models that occur several times, the number of the last one.
    numbers: BTreeMap<String, usize>,
}

impl<'e> FileDraft<'e> {
    /// Collects the models and frames in the element of a world or in the root.
    pub fn new(around: &'e Element, findings: &Findings) -> Result<Self> {
        let mut draft = FileDraft {
            frames: FrameTable::new(),
            models: Vec::new(),
            links: Vec::new(),
            parts: 0,
            numbers: BTreeMap::new(),
        };
        let scope = ModelScope { prefix: String::new(), model: WORLD };
        for tag in &around.children {
            match tag.name.as_str() {
                "model" => drop(draft.model(tag, &scope, None, false, findings)?),
                "frame" => draft.frame(tag, &scope)?,
                "joint" => {
                    let text = format!("the joint `{}` between models is left out", tag.label());
                    findings.warn(FindingKind::Joint, tag.line, text);
                }
                _ => {}
            }
        }
        Ok(draft)
    }

    /// Adds a model, which is nested in the model `top` unless that is `None`. Returns its canonical link.
    fn model(
        &mut self,
        tag: &'e Element,
        around: &ModelScope,
        top: Option<usize>,
        is_static: bool,
        findings: &Findings,
    ) -> Result<Option<FrameIndex>> {
        self.count(tag)?;
        let is_merged = tag.attribute("merge").is_some_and(is_true) && top.is_some();
        let name = self.free_name(tag, around, findings);
        let full = format!("{}{name}", around.prefix);
        let key = Some(full.clone()).filter(|_| !is_merged);
        let default = FrameReference::Known(around.model);
        let frame = self.frames.add(key, FrameKind::Model(None), StatedPose::read(tag)?, (default, around), tag.line);
        let prefix = if is_merged { around.prefix.clone() } else { format!("{full}::") };
        let scope = ModelScope { prefix, model: frame };
        if let Some(inside) = tag.attribute("placement_frame").filter(|name| !name.is_empty()) {
            self.frames.set_placement(frame, FrameReference::Named(scope.clone(), inside.to_owned()));
        }
        let is_static = is_static || tag.flag("static") == Some(true);
        let top = top.unwrap_or_else(|| {
            let (links, joints, plugins) = (Vec::new(), Vec::new(), Vec::new());
            self.models.push(ModelDraft { tag, name, frame, is_static, links, joints, plugins });
            self.models.len() - 1
        });
        let mut first = None;
        let mut of_nested = None;
        for child in &tag.children {
            match child.name.as_str() {
                "link" => {
                    let link = self.link(child, &scope, top, is_static)?;
                    first = first.or(Some(link));
                }
                "model" => {
                    let inner = self.model(child, &scope, Some(top), is_static, findings)?;
                    of_nested = of_nested.or(inner);
                }
                "frame" => self.frame(child, &scope)?,
                "plugin" => self.models[top].plugins.push(child),
                _ => {}
            }
        }
        // Links and frames come first, since a joint of an old file can have the name of a link.
        for child in tag.named("joint") {
            self.joint(child, &scope, top, is_static)?;
        }
        let named = tag.attribute("canonical_link").filter(|name| !name.is_empty());
        let named = named.and_then(|name| self.frames.find(&FrameReference::Named(scope.clone(), name.to_owned())));
        let canonical = named.or(first).or(of_nested);
        self.frames.set_canonical(frame, canonical);
        Ok(canonical)
    }

    /// Returns the name of a model, which differs from those of other models.
    fn free_name(&mut self, tag: &Element, around: &ModelScope, findings: &Findings) -> String {
        let wanted = if tag.label().is_empty() { "model" } else { tag.label() };
        let full = format!("{}{wanted}", around.prefix);
        if !self.frames.has(&full) {
            return wanted.to_owned();
        }
        let number = self.numbers.entry(full).or_default();
        let name = loop {
            *number += 1;
            let name = format!("{wanted}_{number}");
            if !self.frames.has(&format!("{}{name}", around.prefix)) {
                break name;
            }
        };
        findings.note(FindingKind::Doubled, tag.line, format!("there are two models `{wanted}`; this one is `{name}`"));
        name
    }

    fn name_in_model(&self, tag: &Element, scope: &ModelScope, top: usize) -> String {
        let full = format!("{}{}", scope.prefix, tag.label());
        let own = format!("{}::", self.models[top].name);
        full.strip_prefix(&own).unwrap_or(&full).to_owned()
    }

    fn count(&mut self, tag: &Element) -> Result {
        self.parts += 1;
        if self.parts > MAX_PARTS {
            return Err(tag.fail(format!("the file has more than {MAX_PARTS} models, links and joints")));
        }
        Ok(())
    }

    fn link(&mut self, tag: &'e Element, scope: &ModelScope, top: usize, is_static: bool) -> Result<FrameIndex> {
        self.count(tag)?;
        if tag.label().is_empty() {
            return Err(tag.fail("a link has no name: expected a nonempty attribute `name`"));
        }
        let number = self.links.len();
        let key = Some(format!("{}{}", scope.prefix, tag.label()));
        let default = (FrameReference::Known(scope.model), scope);
        let frame = self.frames.add(key, FrameKind::Link(number), StatedPose::read(tag)?, default, tag.line);
        let name = self.name_in_model(tag, scope, top);
        self.links.push(PartDraft { tag, name, frame, scope: scope.clone(), is_static });
        self.models[top].links.push(number);
        Ok(frame)
    }

    fn joint(&mut self, tag: &'e Element, scope: &ModelScope, top: usize, is_static: bool) -> Result {
        self.count(tag)?;
        let child =
            tag.text_of("child").ok_or_else(|| tag.fail(format!("the joint `{}` has no <child>", tag.label())))?;
        let key = Some(format!("{}{}", scope.prefix, tag.label()));
        let default = (FrameReference::Named(scope.clone(), child.to_owned()), scope);
        let frame = self.frames.add(key, FrameKind::Attached, StatedPose::read(tag)?, default, tag.line);
        let name = self.name_in_model(tag, scope, top);
        self.models[top].joints.push(PartDraft { tag, name, frame, scope: scope.clone(), is_static });
        Ok(())
    }

    fn frame(&mut self, tag: &Element, scope: &ModelScope) -> Result {
        let attached = tag.attribute("attached_to").filter(|name| !name.is_empty());
        let default = match attached {
            Some(name) => FrameReference::Named(scope.clone(), name.to_owned()),
            None => FrameReference::Known(scope.model),
        };
        let key = Some(format!("{}{}", scope.prefix, tag.label()));
        self.frames.add(key, FrameKind::Attached, StatedPose::read(tag)?, (default, scope), tag.line);
        Ok(())
    }
}
