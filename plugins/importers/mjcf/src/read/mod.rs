//! Reads the contents of a file into a [`Model`].
//!
//! `bodies` reads the tree of bodies, `geoms` their geoms, `assets` meshes, height fields and materials, `actuators`,
//! `couplings` and `others` the sections beside the tree.

mod actuators;
mod assets;
mod bodies;
mod couplings;
mod geoms;
mod others;

use std::{collections::BTreeMap, rc::Rc};

use tatu_importers_common::DecodedImage;
use tatu_plugin_api::safe::{Builder, Result};

use crate::{
    compiler::Compiler,
    coverage,
    defaults::Defaults,
    include::{TextFiles, folder_of},
    mesh::MeshAsset,
    model::{Look, Model},
    report::ImportReport,
    xml::Element,
};

/// Maximum number of bodies, joints, geoms, sites, replicas, actuators and the like in total.
const MAX_PARTS: usize = 50_000;
/// Maximum number of triangles and samples of all meshes and height fields.
const MAX_TRIANGLES: usize = 16_000_000;
/// Maximum number of files that `<attach>` adds, each within another.
const MAX_ATTACHED: usize = 8;

/// A file with its own settings, classes and assets.
pub struct Source {
    pub root: Element,
    pub compiler: Compiler,
    pub defaults: Defaults,
    /// Number of the source, which distinguishes assets with the same name.
    number: usize,
    /// Name of the file, empty for the imported one.
    file: String,
    /// What precedes the names of the file's objects.
    prefix: String,
    /// Number of files around this one.
    depth: usize,
}

impl Source {
    fn folder(&self) -> &str {
        folder_of(&self.file)
    }
    /// Returns a name of this file, as it is in the model.
    fn named(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}

/// An image and its mean colour.
type MeanImage = (Rc<DecodedImage>, [f64; 3]);

/// A reader in progress.
pub struct Reader<'w, 'b> {
    builder: &'w Builder<'b>,
    files: TextFiles<'w, 'b>,
    pub report: ImportReport,
    pub model: Model,
    meshes: BTreeMap<(usize, String), Option<Rc<MeshAsset>>>,
    looks: BTreeMap<(usize, String), Option<Look>>,
    /// Images with their mean colours, by path.
    images: BTreeMap<String, Option<MeanImage>>,
    pixels: usize,
    parts: usize,
    triangles: usize,
    sources: usize,
}

/// Reads a whole file.
pub fn model(builder: &Builder<'_>, bytes: &[u8]) -> Result<(Model, ImportReport)> {
    let mut reader = Reader {
        builder,
        files: TextFiles::new(builder),
        report: ImportReport::default(),
        model: Model::default(),
        meshes: BTreeMap::new(),
        looks: BTreeMap::new(),
        images: BTreeMap::new(),
        pixels: 0,
        parts: 0,
        triangles: 0,
        sources: 0,
    };
    let source = reader.source(bytes, "", "", 0)?;
    reader.model.name = source.root.attribute("model").unwrap_or_default().to_owned();
    reader.options(&source)?;
    reader.world(&source)?;
    reader.sections(&source)?;
    reader.finish_masses(&source.compiler)?;
    Ok((reader.model, reader.report))
}

impl Reader<'_, '_> {
    /// Reads the settings and classes of a file.
    fn source(&mut self, bytes: &[u8], file: &str, prefix: &str, depth: usize) -> Result<Rc<Source>> {
        let root = self.files.tree(bytes, file)?;
        if root.name != "mujoco" {
            let text = format!("the root element is <{}>; expected <mujoco>, an MJCF file", root.name);
            let is_part = root.name == "mujocoinclude";
            let help = if is_part { "open the file that includes this one" } else { "an MJCF file is a MuJoCo model" };
            return Err(root.fail(text).help(help));
        }
        coverage::report(&root, &mut self.report);
        let (compiler, defaults) = (Compiler::read(&root)?, Defaults::read(&root)?);
        let number = self.sources;
        self.sources += 1;
        let source =
            Source { root, compiler, defaults, number, file: file.to_owned(), prefix: prefix.to_owned(), depth };
        Ok(Rc::new(source))
    }

    /// Reads what a file describes beside its bodies.
    fn sections(&mut self, source: &Source) -> Result {
        self.tendons(source)?;
        self.actuators(source)?;
        self.equalities(source)?;
        self.contacts(source)?;
        self.sensors(source)?;
        self.keyframes(source)
    }

    /// Counts the triangles of another mesh.
    fn count_triangles(&mut self, mesh: &MeshAsset, element: &Element) -> Result {
        self.triangles += mesh.pieces.iter().map(|p| p.triangles.len()).sum::<usize>();
        match self.triangles > MAX_TRIANGLES {
            true => Err(element.fail(format!("the meshes of the model have more than {MAX_TRIANGLES} triangles"))),
            false => Ok(()),
        }
    }

    /// Counts one more part of the model.
    fn count_part(&mut self, element: &Element) -> Result {
        self.parts += 1;
        match self.parts > MAX_PARTS {
            true => {
                Err(element.fail(format!("the model has more than {MAX_PARTS} bodies, joints, geoms and other parts")))
            }
            false => Ok(()),
        }
    }
}
