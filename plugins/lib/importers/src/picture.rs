//! Images of materials: PNG, JPEG, BMP, TIFF and PNM files.

use std::{collections::HashMap, io::Cursor, rc::Rc};

use image::io::{Limits, Reader};

/// Maximum number of pixels, the same as for images in a scene.
const MAX_PIXELS: u64 = 16 << 20;

/// Callback that returns the content of a file to which a mesh file refers, or `None` if it does not exist. The name is
/// relative to the mesh file.
pub type FileLoader<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// A decoded image.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedImage {
    /// Width, in pixels.
    pub columns: u32,
    /// Height, in pixels.
    pub rows: u32,
    /// Red, green, blue and opacity of each pixel, top row first.
    pub rgba: Vec<u8>,
}

impl DecodedImage {
    /// Decodes the content of an image file; the error describes what is wrong with it.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let open = || Reader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string());
        let mut reader = open()?;
        if reader.format().is_none() {
            return Err("the image format is not supported; expected PNG, JPEG, BMP, TIFF or PNM".into());
        }
        let (columns, rows) = open()?.into_dimensions().map_err(|e| e.to_string())?;
        if columns == 0 || rows == 0 || u64::from(columns) * u64::from(rows) > MAX_PIXELS {
            return Err(format!("the image has {columns} x {rows} pixels; expected 1 to {MAX_PIXELS} pixels in total"));
        }
        let mut limits = Limits::default();
        limits.max_alloc = Some(8 * MAX_PIXELS);
        reader.limits(limits);
        let rgba = reader.decode().map_err(|e| e.to_string())?.into_rgba8().into_raw();
        Ok(DecodedImage { columns, rows, rgba })
    }
}

/// Images of a mesh file, by name; each is read only once.
pub struct ImageCache<'a> {
    files: FileLoader<'a>,
    known: HashMap<String, Option<Rc<DecodedImage>>>,
    /// Notes on images that could not be read.
    pub notes: Vec<String>,
}

impl<'a> ImageCache<'a> {
    pub fn new(files: FileLoader<'a>) -> Self {
        ImageCache { files, known: HashMap::new(), notes: Vec::new() }
    }

    /// Returns the image in a separate file.
    pub fn file(&mut self, name: &str) -> Option<Rc<DecodedImage>> {
        let name = name.trim().replace('\\', "/");
        let name = name.strip_prefix("file://").unwrap_or(&name).trim_start_matches("./").replace("%20", " ");
        if let Some(known) = self.known.get(&name) {
            return known.clone();
        }
        let bytes = (self.files)(&name).ok_or_else(|| "the file does not exist".to_owned());
        self.insert(name, bytes.and_then(|b| DecodedImage::decode(&b)))
    }

    /// Returns an image that is embedded in the mesh file.
    pub fn bytes(&mut self, name: String, bytes: Option<&[u8]>) -> Option<Rc<DecodedImage>> {
        if let Some(known) = self.known.get(&name) {
            return known.clone();
        }
        let bytes = bytes.ok_or_else(|| "the data of the image is missing from the file".to_owned());
        self.insert(name, bytes.and_then(DecodedImage::decode))
    }

    fn insert(&mut self, name: String, read: Result<DecodedImage, String>) -> Option<Rc<DecodedImage>> {
        let kept = match read {
            Ok(picture) => Some(Rc::new(picture)),
            Err(why) => {
                self.notes.push(format!("the image `{name}` is ignored: {why}"));
                None
            }
        };
        self.known.insert(name, kept.clone());
        kept
    }
}
