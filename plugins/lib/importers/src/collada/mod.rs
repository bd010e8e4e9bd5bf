//! COLLADA 1.4 and 1.5: triangles, polygons and their materials, placed by the nodes of the scene. Animations, lights,
//! cameras and physics are ignored; skins are read in their bind pose.

mod geometry;
mod material;
mod scene;
mod tree;

use roxmltree::{Document, ParsingOptions};

use tatu_importers_xml::too_large;

use self::tree::ElementIndex;
use crate::{model::ImportedModel, picture::FileLoader};

/// Maximum number of nodes of the XML tree, which limits the memory to a few times the size of the file.
const MAX_NODES: u32 = 4_000_000;

pub fn read(bytes: &[u8], files: FileLoader<'_>) -> Result<ImportedModel, String> {
    let wrong = |e: &dyn std::fmt::Display| format!("the COLLADA file is incomplete or damaged: {e}");
    let text = std::str::from_utf8(bytes).map_err(|e| wrong(&e))?;
    if let Some((_, why)) = too_large(text) {
        return Err(wrong(&why));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{FEFF}'), options).map_err(|e| wrong(&e))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("expected a COLLADA file, but the root element is <{}>", root.tag_name().name()));
    }
    scene::read(&ElementIndex::new(root), files)
}
