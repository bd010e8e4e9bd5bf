//! Meshes in files of their own: Wavefront OBJ, STL and PLY. `read` reads them; this makes a shape of one.

mod read;

use tatu_plugin_api::{
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it keeps nothing.
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
    const TEXT: &'static str = "A mesh in an OBJ, STL or PLY file, as a shape that stands still.";
    const SUFFIXES: &'static [&'static str] = &[".obj", ".stl", ".ply"];

    fn params() -> Vec<Param> {
        vec![
            Param::float("scale")
                .range(1e-9, 1e9)
                .default(1.0)
                .text("What the numbers of the file are multiplied by: 0.001 for mm."),
            Param::bool("respondable").default(false).text("Whether it collides."),
        ]
    }

    fn sniff(head: &[u8]) -> u32 {
        // The other formats have no mark of their own: they are known by their suffixes.
        if head.starts_with(b"ply\n") || head.starts_with(b"ply\r\n") { 80 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let mut mesh = read::mesh(bytes).map_err(Fail::argument)?;
        let scale = params.f64("scale")?;
        // 1 changes no bit.
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
