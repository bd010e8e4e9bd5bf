//! Importer for mesh files: Wavefront OBJ, STL and PLY. `read` parses them; this file makes a shape of the mesh.

mod read;

use tatu_plugin_api::{
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
    const TEXT: &'static str = "A mesh in an OBJ, STL or PLY file, as a static shape.";
    const SUFFIXES: &'static [&'static str] = &[".obj", ".stl", ".ply"];

    fn params() -> Vec<Param> {
        vec![
            Param::float("scale")
                .range(1e-9, 1e9)
                .default(1.0)
                .text("Factor for the numbers of the file: 0.001 for mm."),
            Param::bool("respondable").default(false).text("Whether it collides."),
        ]
    }

    fn sniff(head: &[u8]) -> u32 {
        // OBJ and STL files have no magic number: they are recognized by their suffix.
        if head.starts_with(b"ply\n") || head.starts_with(b"ply\r\n") { 80 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let mut mesh = read::mesh(bytes).map_err(Fail::argument)?;
        let scale = params.f64("scale")?;
        // A scale of 1 leaves every bit unchanged.
        mesh.points.iter_mut().flatten().for_each(|x| *x *= scale);
        let number = builder.mesh(&mesh.points, &mesh.triangles)?;
        let node = builder.object("shape", None, "mesh")?;
        node.set("shape.primitive", "mesh")?.set("shape.mesh", number)?;
        if params.bool("respondable")? {
            node.set("shape.respondable", true)?;
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
