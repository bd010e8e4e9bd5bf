//! Reads assets when a geom first uses them: meshes, height fields and materials.

use std::rc::Rc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_importers_common::{DecodedImage, MeshPiece};
use tatu_plugin_api::safe::Result;

use super::{MeanImage, Reader, Source};
use crate::{
    attributes::Attributes,
    compiler::quaternion,
    defaults::MAIN,
    include::{folder_of, join},
    mesh::{MeshAsset, MeshInertia, MeshSettings},
    model::{Look, Picture},
    xml::Element,
};

/// Maximum number of pixels of all images.
const MAX_PIXELS: usize = 1 << 26;
/// Maximum number of samples of a height field.
const MAX_SAMPLES: usize = 1 << 22;

/// Rows, columns and heights of a height field.
type HeightSamples = (usize, usize, Vec<f64>);

/// Returns the name of an asset: its own, or that of its file without folder and suffix.
fn asset_name(element: &Element) -> Option<&str> {
    let of_file = || {
        let file = element.attribute("file")?.rsplit(['/', '\\']).next()?;
        Some(file.rsplit_once('.').map_or(file, |(stem, _)| stem))
    };
    element.attribute("name").filter(|n| !n.is_empty()).or_else(of_file)
}

impl Source {
    fn asset(&self, kind: &str, name: &str) -> Option<&Element> {
        self.root.section("asset").find(|a| a.name == kind && asset_name(a) == Some(name))
    }

    /// Returns the path of a file in one of the folders of assets.
    fn path(&self, folder: &str, file: &str) -> String {
        let file = file.replace('\\', "/");
        let file = if self.compiler.strip_path { file.rsplit('/').next().unwrap_or(&file).to_owned() } else { file };
        join(self.folder(), &join(folder, &file))
    }
}

impl<'b> Reader<'_, 'b> {
    /// Returns a mesh by name; `None` if it cannot be read, which is reported.
    pub(super) fn mesh(&mut self, source: &Source, name: &str, of: &Element) -> Result<Option<Rc<MeshAsset>>> {
        let key = (source.number, format!("mesh {name}"));
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let element = source.asset("mesh", name).ok_or_else(|| of.fail(format!("there is no mesh `{name}`")))?;
        let read = self.read_mesh(source, element)?;
        let mesh = match read {
            Ok(mesh) => {
                self.count_triangles(&mesh, element)?;
                mesh.notes.iter().for_each(|n| self.report.note(&element.place, format!("the mesh `{name}`: {n}")));
                Some(Rc::new(mesh))
            }
            Err(why) => {
                self.report.warn(&element.place, format!("the mesh `{name}` is omitted: {why}"));
                None
            }
        };
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }

    fn read_mesh(&mut self, source: &Source, element: &Element) -> Result<Result<MeshAsset, String>> {
        let class = element.attribute("class").unwrap_or(MAIN);
        let a = source.defaults.attributes(element, "mesh", class)?;
        let turn = a.array("refquat")?.map(|q| quaternion(q).ok_or_else(|| a.invalid("refquat", "a quaternion")));
        let at = Translation3::from(Vector3::from(a.array::<3>("refpos")?.unwrap_or_default()));
        let inertia = match a.text("inertia").as_deref() {
            None | Some("legacy") => MeshInertia::Legacy,
            Some("exact") => MeshInertia::Exact,
            Some("shell") => MeshInertia::Shell,
            Some(_) => {
                self.report.warn(&a.element.place, "meshes whose `inertia` is `convex` are weighed as `exact`");
                MeshInertia::Exact
            }
        };
        let settings = MeshSettings {
            scale: a.array("scale")?.unwrap_or([1.0; 3]),
            reference: Isometry3::from_parts(at, turn.transpose()?.unwrap_or_else(UnitQuaternion::identity)),
            inertia,
        };
        if let Some(points) = a.numbers("vertex")? {
            let Some(faces) = a.numbers("face")? else {
                return Ok(Err("a mesh of points without faces is not supported".into()));
            };
            let points: Vec<[f64; 3]> = points.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
            let faces: Vec<[u32; 3]> = faces.chunks_exact(3).map(|f| [f[0] as u32, f[1] as u32, f[2] as u32]).collect();
            if faces.iter().flatten().any(|i| *i as usize >= points.len()) {
                return Err(a.invalid("face", "numbers of points, from 0"));
            }
            return Ok(MeshAsset::of(vec![MeshPiece { points, triangles: faces, ..Default::default() }], &settings));
        }
        let Some(file) = a.text("file") else {
            return Ok(Err("a mesh without a file or points is not supported".into()));
        };
        let path = source.path(&source.compiler.mesh_folder, &file);
        let builder = self.builder;
        let Some(bytes) = builder.file(&path) else {
            return Ok(Err(format!("the file `{path}` does not exist")));
        };
        let beside = |name: &str| builder.file(&join(folder_of(&path), name)).map(<[u8]>::to_vec);
        Ok(MeshAsset::read(&path, bytes, &settings, &beside))
    }

    /// Returns a height field as triangles; `None` if it cannot be read, which is reported.
    pub(super) fn height_field(&mut self, source: &Source, name: &str, of: &Element) -> Result<Option<Rc<MeshAsset>>> {
        let key = (source.number, format!("hfield {name}"));
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let element = source.asset("hfield", name);
        let element = element.ok_or_else(|| of.fail(format!("there is no height field `{name}`")))?;
        let a = Attributes::new(element, None);
        let samples = self.heights(source, &a)?;
        let Some([x, y, height, _]) = a.array::<4>("size")? else { return Err(a.invalid("size", "4 lengths")) };
        let (rows, columns, heights) = match samples {
            Ok(samples) => samples,
            Err(why) => {
                self.report.warn(&element.place, format!("the height field `{name}` is omitted: {why}"));
                return Ok(None);
            }
        };
        // The lowest sample is at 0 and the highest at the stated height.
        let low = heights.iter().copied().fold(f64::MAX, f64::min);
        let span = heights.iter().copied().fold(f64::MIN, f64::max) - low;
        let scaled = |h: f64| if span > 0.0 { (h - low) / span * height } else { 0.0 };
        let along = |i: usize, n: usize, half: f64| half * (2.0 * i as f64 / (n - 1) as f64 - 1.0);
        let point = |i: usize| {
            let (row, column) = (i / columns, i % columns);
            [along(column, columns, x), along(row, rows, y), scaled(heights[i])]
        };
        let points: Vec<[f64; 3]> = (0..rows * columns).map(point).collect();
        let mut triangles = Vec::with_capacity(2 * (rows - 1) * (columns - 1));
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let a = (row * columns + column) as u32;
                let (b, c) = (a + 1, a + columns as u32);
                triangles.extend([[a, b, c], [b, c + 1, c]]);
            }
        }
        let settings = MeshSettings { scale: [1.0; 3], reference: Isometry3::identity(), inertia: MeshInertia::Shell };
        let made = MeshAsset::of(vec![MeshPiece { points, triangles, ..Default::default() }], &settings);
        let made = made.ok().map(Rc::new);
        if let Some(made) = &made {
            self.count_triangles(made, element)?;
        }
        self.meshes.insert(key, made.clone());
        Ok(made)
    }

    /// Returns rows, columns and heights, with the row at the lowest y first.
    fn heights(&mut self, source: &Source, a: &Attributes<'_>) -> Result<Result<HeightSamples, String>> {
        let count = |n: i64| usize::try_from(n).ok().filter(|n| (2..=MAX_SAMPLES).contains(n));
        let Some(file) = a.text("file") else {
            let (rows, columns) = (count(a.integer("nrow", 0)?), count(a.integer("ncol", 0)?));
            let (Some(rows), Some(columns)) = (rows, columns) else {
                return Err(a.invalid("nrow", "at least 2 rows and columns"));
            };
            if rows.saturating_mul(columns) > MAX_SAMPLES {
                return Err(a.invalid("nrow", &format!("at most {MAX_SAMPLES} samples in total")));
            }
            let flat = || vec![0.0; rows * columns];
            let mut heights = a.numbers("elevation")?.unwrap_or_else(flat);
            if heights.len() != rows * columns {
                return Err(a.invalid("elevation", "a number for each row and column"));
            }
            // The text begins with the row at the highest y.
            heights = heights.chunks_exact(columns).rev().flatten().copied().collect();
            return Ok(Ok((rows, columns, heights)));
        };
        let path = join(source.folder(), &file.replace('\\', "/"));
        let Some(bytes) = self.builder.file(&path) else {
            return Ok(Err(format!("the file `{path}` does not exist")));
        };
        let image = match DecodedImage::decode(bytes) {
            Ok(image) => image,
            Err(why) => return Ok(Err(format!("`{path}`: {why}"))),
        };
        let (rows, columns) = (image.rows as usize, image.columns as usize);
        if rows < 2 || columns < 2 || rows * columns > MAX_SAMPLES {
            return Ok(Err(format!(
                "`{path}` has {columns} x {rows} pixels; expected 2 x 2 to {MAX_SAMPLES} in total"
            )));
        }
        let grey: Vec<f64> = image.rgba.chunks_exact(4).map(|p| f64::from(p[0])).collect();
        Ok(Ok((rows, columns, grey.chunks_exact(columns).rev().flatten().copied().collect())))
    }

    /// Returns the look of a material.
    pub(super) fn material(&mut self, source: &Source, name: &str, of: &Element) -> Result<Option<Look>> {
        let key = (source.number, name.to_owned());
        if let Some(known) = self.looks.get(&key) {
            return Ok(known.clone());
        }
        let Some(element) = source.asset("material", name) else {
            return Err(of.fail(format!("there is no material `{name}`")));
        };
        let class = element.attribute("class").unwrap_or(MAIN);
        let a = source.defaults.attributes(element, "material", class)?;
        let stated = a.array::<4>("rgba")?;
        let texture = match a.text("texture") {
            Some(texture) => self.texture(source, &texture, &a)?,
            None => None,
        };
        let rgba = stated.unwrap_or([1.0; 4]);
        let look = Look { rgba, texture: texture.map(Rc::new), is_default: false };
        self.looks.insert(key, Some(look.clone()));
        Ok(Some(look))
    }

    /// Returns a texture; `None` if it has no colour that could be drawn.
    fn texture(&mut self, source: &Source, name: &str, material: &Attributes<'_>) -> Result<Option<Picture>> {
        let Some(element) = source.asset("texture", name) else { return Ok(None) };
        let a = Attributes::new(element, None);
        let (one, other) = (a.array::<3>("rgb1")?.unwrap_or([0.8; 3]), a.array::<3>("rgb2")?.unwrap_or([0.5; 3]));
        let mean = [0, 1, 2].map(|i| (one[i] + other[i]) / 2.0);
        let repeat = material.array("texrepeat")?.unwrap_or([1.0; 2]);
        let per_metre = material.switch("texuniform")?.unwrap_or(false);
        let picture = |mean, image| Some(Picture { image, mean, repeat, per_metre });
        let is_flat = a.text("type").is_some_and(|t| t == "2d");
        match (a.text("builtin").as_deref(), a.text("file")) {
            (Some("checker"), _) if is_flat => Ok(picture(mean, Some(Rc::new(checker([one, other]))))),
            (Some("flat"), _) => Ok(picture(one, None)),
            (Some("checker" | "gradient"), _) => Ok(picture(mean, None)),
            (_, Some(file)) if is_flat => {
                let image = self.image(source, &file, element);
                Ok(image.and_then(|(image, mean)| picture(mean, Some(image))))
            }
            _ => {
                self.report.note(&element.place, "images on cubes are omitted: the colour of the material applies");
                Ok(None)
            }
        }
    }

    /// Returns an image and its mean colour; `None` if it cannot be read, which is reported.
    fn image(&mut self, source: &Source, file: &str, element: &Element) -> Option<MeanImage> {
        let path = source.path(&source.compiler.texture_folder, file);
        if let Some(known) = self.images.get(&path) {
            return known.clone();
        }
        let read = match self.builder.file(&path) {
            None => Err("it does not exist".to_owned()),
            Some(_) if self.pixels > MAX_PIXELS => Err(format!("the images have more than {MAX_PIXELS} pixels")),
            Some(bytes) => DecodedImage::decode(bytes),
        };
        let found = match read {
            Ok(image) => {
                self.pixels += image.rgba.len() / 4;
                let sum = image.rgba.chunks_exact(4).fold([0u64; 3], |s, p| [0, 1, 2].map(|i| s[i] + u64::from(p[i])));
                let count = (image.rgba.len() / 4).max(1) as f64;
                Some((Rc::new(image), sum.map(|x| x as f64 / count / 255.0)))
            }
            Err(why) => {
                self.report.note(&element.place, format!("the image `{path}` is omitted: {why}"));
                None
            }
        };
        self.images.insert(path, found.clone());
        found
    }
}

/// Returns an image of two by two squares.
fn checker(colors: [[f64; 3]; 2]) -> DecodedImage {
    const SIDE: u32 = 32;
    let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0) as u8;
    let pixels = (0..SIDE * SIDE).flat_map(|i| {
        let odd = (i % SIDE >= SIDE / 2) != (i / SIDE >= SIDE / 2);
        let [r, g, b] = colors[usize::from(odd)].map(byte);
        [r, g, b, 255]
    });
    DecodedImage { rgba: pixels.collect(), columns: SIDE, rows: SIDE }
}
