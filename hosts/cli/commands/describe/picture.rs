//! `tatu describe MODEL --picture FILE`: renders a model on a floor, or several models on one sheet.

use std::{path::Path, sync::Arc};

use tatu_core::{
    World,
    document::{self, LoadOptions},
    errors::Error,
    plugins::Registry,
};
use tatu_render::Picture;
use tatu_terminal::report;

use crate::commands::look::{
    canvas::{Canvas, HPos, VPos},
    file,
};

/// Size of the picture of a single model, and of each model in a sheet: columns and rows of pixels.
const SINGLE_SIZE: [u32; 2] = [480, 360];
const CELL_SIZE: [u32; 2] = [160, 120];
/// Height of the caption below each picture of a sheet, and of its letters, pixels.
const CAPTION_HEIGHT: u32 = 22;
const CAPTION_FONT_SIZE: f64 = 13.0;
/// Horizontal field of view, rad. It is narrow to keep perspective distortion small.
const FOV: f64 = 0.55;

/// Writes a picture of one model, or a sheet of several, to a file.
pub fn write(registry: &Arc<Registry>, ids: &[String], output: &Path) -> Result<(), Error> {
    if let [id] = ids {
        return file::write(output, &of_model(registry, id, SINGLE_SIZE, true)?);
    }
    let columns = (ids.len() as f64 * 1.2).sqrt().ceil() as u32;
    let rows = (ids.len() as u32).div_ceil(columns);
    let mut sheet = Canvas::new(columns * CELL_SIZE[0], rows * (CELL_SIZE[1] + CAPTION_HEIGHT));
    for (i, id) in (0..).zip(ids) {
        let (x, y) = (i % columns * CELL_SIZE[0], i / columns * (CELL_SIZE[1] + CAPTION_HEIGHT));
        // Without floors and with 32 levels of each colour, the file is a third as large.
        let mut picture = of_model(registry, id, CELL_SIZE, false)?;
        picture.rgb.iter_mut().for_each(|c| *c = (*c & 0xf8) | (*c >> 5));
        sheet.put((x, y), &picture);
        let at = (f64::from(x + CELL_SIZE[0] / 2), f64::from(y + CELL_SIZE[1] + CAPTION_HEIGHT / 2));
        let drawn = sheet.text(at, id, CAPTION_FONT_SIZE, (HPos::Center, VPos::Center));
        drawn.map_err(|why| Error::new("E105", format!("cannot draw the caption `{id}`: {why}")))?;
    }
    file::write(output, &sheet.picture())
}

/// Renders a model in a folder.
fn of_model(registry: &Arc<Registry>, id: &str, size: [u32; 2], ground: bool) -> Result<Picture, Error> {
    let found = registry.find_model(id).ok_or_else(|| {
        let error = Error::new("E130", format!("there is no model `{id}` that is stored in a folder"));
        error.help("`--picture` renders only models that are stored in folders; `tatu list models` lists all models")
    })?;
    let document = document::load(&found.file, registry, &LoadOptions::default())?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let world = World::with_threads(Arc::new(document), registry.clone(), all)?;
    let camera = tatu_render::model_camera(&world, FOV, size);
    let picture = tatu_render::picture(&world, &camera, &[], ground);
    world.end();
    world.faults().iter().for_each(|f| report::warn_text(&f.message));
    Ok(picture)
}
