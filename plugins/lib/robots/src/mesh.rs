//! Finds the mesh files to which a file of a robot refers.

use tatu_importers_common::{ImportedModel, SUFFIXES, read};
use tatu_plugin_api::safe::Builder;

/// Finds and reads the mesh file to which a name in a robot's file refers. The error is a single sentence.
pub fn find(builder: &Builder<'_>, name: &str, package_root: &str) -> Result<ImportedModel, String> {
    // Files that were written on Windows can have its separators.
    let name = name.trim().replace('\\', "/");
    let lower = name.to_lowercase();
    if !SUFFIXES.iter().any(|s| lower.ends_with(s)) {
        return Err(format!("the format is not supported; expected one of {}", SUFFIXES.join(", ")));
    }
    let names = candidate_paths(&name, package_root);
    let Some((found, bytes)) = names.iter().find_map(|n| Some((n, builder.file(n)?))) else {
        return Err(format!("the file does not exist; searched for {}", names.join(", ")));
    };
    // Names of images are relative to the mesh file.
    let folder = found.rsplit_once('/').map_or("", |(folder, _)| folder);
    read(found, bytes, &|name: &str| builder.file(&resolve_relative(folder, name)).map(<[u8]>::to_vec))
}

/// Returns the path of a file whose name is relative to a folder. Components `..` are resolved as far as possible.
fn resolve_relative(folder: &str, name: &str) -> String {
    // The host resolves the components of a URI.
    if folder.contains("://") {
        return format!("{folder}/{name}");
    }
    let mut path: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." if path.last().is_some_and(|p| *p != "..") => drop(path.pop()),
            part => path.push(part),
        }
    }
    path.join("/")
}

/// Returns the names to which a name may refer, in the order in which they are tried. Paths are relative to the folder of
/// the robot's file. The host finds packages.
fn candidate_paths(name: &str, package_root: &str) -> Vec<String> {
    let Some((scheme, path)) = name.split_once(':').map(|(scheme, path)| (scheme, path.trim_start_matches('/'))) else {
        return vec![name.to_owned()];
    };
    match scheme {
        "package" => {
            let inside = path.split_once('/').map_or(path, |(_, rest)| rest);
            if !package_root.is_empty() {
                let root = package_root.trim_end_matches('/');
                return vec![format!("{root}/{path}"), format!("{root}/{inside}")];
            }
            let mut names = vec![format!("package://{path}")];
            // A folder without a manifest can hold the package's files or the package.
            if !path.split('/').any(|part| part == "..") {
                names.splice(0..0, [inside.to_owned(), path.to_owned()]);
            }
            names
        }
        "file" if name.starts_with("file:///") => vec![format!("file:///{path}")],
        "file" => vec![path.to_owned()],
        _ => vec![name.to_owned()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn package_names_are_resolved_to_paths() {
        let of = |name: &str| candidate_paths(name, "");
        let names = ["meshes/a.stl", "bot/meshes/a.stl", "package://bot/meshes/a.stl"];
        assert_eq!(of("package://bot/meshes/a.stl"), names);
        assert_eq!(of("package:/bot/meshes/a.stl"), names);
        assert_eq!(candidate_paths("package://bot/m/a.stl", "../"), ["../bot/m/a.stl", "../m/a.stl"]);
        assert_eq!(candidate_paths("m/a.stl", "x"), ["m/a.stl"]);
        assert_eq!(of("file://m/a.stl"), ["m/a.stl"]);
        assert_eq!(of("file:///m/a.stl"), ["file:///m/a.stl"]);
    }

    #[test]
    fn image_paths_are_relative_to_the_mesh() {
        assert_eq!(resolve_relative("bot/meshes", "../textures/a.png"), "bot/textures/a.png");
        assert_eq!(resolve_relative("../bot/m", "./a.png"), "../bot/m/a.png");
        assert_eq!(resolve_relative("", "../a.png"), "../a.png");
        assert_eq!(resolve_relative("package://bot/m", "../a.png"), "package://bot/m/../a.png");
    }
}
