//! Importer for mesh files: Wavefront OBJ, STL, PLY, COLLADA and glTF. It builds a shape from the file.

use tatu_importers_common::{SUFFIXES, ShapeBuilder, read};
use tatu_plugin_api::{
    abi::TATU_REPORT_WARNING,
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct MeshFiles;

impl Plugin for MeshFiles {
    fn start(_: &Host) -> Result<Self> {
        Ok(MeshFiles)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<MeshFile>();
    }
}

/// The importer "mesh".
pub struct MeshFile;

impl Importer for MeshFile {
    type Plugin = MeshFiles;
    const ID: &'static str = "mesh";
    const TEXT: &'static str = "A mesh in an OBJ, STL, PLY, COLLADA or glTF file, as a static shape.";
    const SUFFIXES: &'static [&'static str] = SUFFIXES;

    fn params() -> Vec<Param> {
        vec![
            Param::float("scale")
                .range(1e-9, 1e9)
                .default(1.0)
                .text("Factor for the lengths in the file: 0.001 for mm. COLLADA files specify their unit."),
            Param::bool("respondable").default(false).text("Whether the shape collides."),
            Param::bool("materials").default(true).text("Whether the shape has the colors and images of the file."),
        ]
    }

    fn sniff(head: &[u8]) -> u32 {
        // OBJ and STL files have no magic number, so they are recognized by their suffix.
        let magic: [&[u8]; 3] = [b"ply\n", b"ply\r\n", b"glTF"];
        if magic.iter().any(|m| head.starts_with(m)) { 80 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let files = |name: &str| builder.file(name).map(<[u8]>::to_vec);
        let mut read = read("", bytes, &files).map_err(Fail::argument)?;
        read.model.turn_y_up_to_z_up();
        let scale = params.f64("scale")?;
        // A scale of 1 leaves every bit unchanged.
        let points = read.model.pieces.iter_mut().flat_map(|p| &mut p.points);
        points.flatten().for_each(|x| *x *= scale);
        let node = builder.object("shape", None, "mesh")?;
        ShapeBuilder::default().shape(builder, node, &read.model.pieces, params.bool("materials")?)?;
        if params.bool("respondable")? {
            node.set("shape.respondable", true)?;
        }
        for note in &read.notes {
            builder.report(TATU_REPORT_WARNING, Some(node), note);
        }
        Ok(())
    }
}

tatu_plugin! {
    plugin: MeshFiles,
    id: "tatu.importer.mesh",
    name: "Mesh files",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
