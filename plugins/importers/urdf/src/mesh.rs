//! Reads STL and OBJ mesh files.

use std::io::Cursor;

use tatu_plugin_api::safe::Builder;

/// Most triangles of a file, or of all files of one import.
const MOST_TRIANGLES: usize = 4_000_000;

/// A triangle mesh, m.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    pub points: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Reads the mesh of a URDF file name through the builder. The error is one sentence.
pub fn find(builder: &Builder<'_>, name: &str, package_root: &str) -> Result<Mesh, String> {
    let lower = name.to_lowercase();
    let read = match lower.rsplit('.').next() {
        Some("stl") => stl,
        Some("obj") => obj,
        Some("dae") => return Err("COLLADA files are not supported: convert it to STL or OBJ".into()),
        _ => return Err("expected a mesh file ending in `.stl` or `.obj`".into()),
    };
    let names = candidates(name, package_root);
    let Some(bytes) = names.iter().find_map(|n| builder.file(n)) else {
        return Err(format!("the file does not exist; looked for {}", names.join(", ")));
    };
    let mesh = read(bytes)?;
    if mesh.triangles.is_empty() {
        return Err("it contains no triangles".into());
    }
    if mesh.points.iter().flatten().any(|x| !x.is_finite()) {
        return Err("one of its points is not finite".into());
    }
    Ok(mesh)
}

/// Returns the paths that a name may refer to, relative to the file's folder.
fn candidates(name: &str, package_root: &str) -> Vec<String> {
    let Some(path) = name.strip_prefix("package://") else {
        return vec![name.strip_prefix("file://").unwrap_or(name).to_owned()];
    };
    let inside = path.split_once('/').map_or(path, |(_, rest)| rest);
    if !package_root.is_empty() {
        let root = package_root.trim_end_matches('/');
        return vec![format!("{root}/{path}"), format!("{root}/{inside}")];
    }
    vec![inside.to_owned(), path.to_owned()]
}

/// Parses STL, binary or text.
fn stl(bytes: &[u8]) -> Result<Mesh, String> {
    let count = bytes.get(80..84).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let binary = count.is_some_and(|n| (bytes.len() - 84) as u64 == 50 * n as u64);
    let mut bytes = bytes.to_vec();
    if binary {
        // Many programs begin the header of binary files with `solid`, so that they look like text; blanks avoid that.
        bytes[..80].fill(b' ');
    }
    let mesh =
        stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| format!("the STL file is incomplete or damaged: {e}"))?;
    check(mesh.faces.len())?;
    Ok(Mesh {
        points: mesh.vertices.iter().map(|v| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect(),
    })
}

/// Parses Wavefront OBJ; materials are ignored.
fn obj(bytes: &[u8]) -> Result<Mesh, String> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(|e| format!("the OBJ file is incomplete or damaged: {e}"))?;
    let mut out = Mesh::default();
    for m in models {
        let first = out.points.len() as u32;
        out.points
            .extend(m.mesh.positions.chunks_exact(3).map(|p| [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])]));
        out.triangles.extend(m.mesh.indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
        check(out.triangles.len())?;
    }
    let n = out.points.len() as u32;
    match out.triangles.iter().flatten().all(|i| *i < n) {
        true => Ok(out),
        false => Err("the OBJ file is damaged: a face refers to a point that does not exist".into()),
    }
}

fn check(triangles: usize) -> Result<(), String> {
    if triangles > MOST_TRIANGLES {
        return Err(format!("the meshes have {triangles} triangles; at most {MOST_TRIANGLES} are supported"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One triangle.
    const TEXT: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendloop\nendfacet\nendsolid a\n";

    fn binary(header: &[u8]) -> Vec<u8> {
        let mut out = header.to_vec();
        out.resize(80, 0);
        out.extend(1u32.to_le_bytes());
        for x in [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0] {
            out.extend(x.to_le_bytes());
        }
        out.extend([0, 0]);
        out
    }

    #[test]
    fn all_sorts_give_the_same_triangle() {
        let text = stl(TEXT.as_bytes()).unwrap();
        assert_eq!((text.points.len(), text.triangles.len()), (3, 1));
        assert_eq!(stl(&binary(b"exported")).unwrap(), text);
        assert_eq!(stl(&binary(b"solid of a program that calls all files so")).unwrap(), text);
        assert_eq!(obj(b"v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n").unwrap(), text);
        assert_eq!(obj(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap().triangles.len(), 2);
    }

    #[test]
    fn cut_and_wrong_files_are_errors() {
        let whole = binary(b"x");
        for n in 0..whole.len() {
            assert!(stl(&whole[..n]).is_err() || stl(&whole[..n]).unwrap().triangles.is_empty(), "{n} bytes");
        }
        for n in 0..TEXT.len() {
            let _ = stl(&TEXT.as_bytes()[..n]);
        }
        assert!(obj(b"v 0 0 0\nf 1 2 3\n").is_err() || obj(b"v 0 0 0\nf 1 2 3\n").unwrap().triangles.is_empty());
        assert!(obj(b"v 0 x 0\n").is_err());
        // A count larger than the file must not allocate memory.
        let mut many = binary(b"x");
        many[80..84].fill(0xFF);
        assert!(stl(&many).is_err());
    }

    #[test]
    fn package_names_lead_to_files() {
        assert_eq!(candidates("package://bot/meshes/a.stl", ""), ["meshes/a.stl", "bot/meshes/a.stl"]);
        assert_eq!(candidates("package://bot/m/a.stl", "../"), ["../bot/m/a.stl", "../m/a.stl"]);
        assert_eq!(candidates("m/a.stl", "x"), ["m/a.stl"]);
    }
}
