//! Models without code: `models/NAME/model.toml`, in the scene format with a table `[model]`.
//!
//! - `model`: the table `[model]`; `params`: its parameters; `table`: access to TOML tables; `error`: errors with a
//!   line;
//! - `expression`: arithmetic in values; `fill`: replaces the expressions in a text with their results;
//! - `sections`: the ranges of the tables in the file; `entries`: selection and repetition of entries.

mod entries;
mod error;
mod expression;
mod fill;
mod model;
mod params;
mod sections;
mod table;

use tatu_plugin_api::{
    safe::{Builder, Fail, Host, ModelInfo, ModelReader, Offer, Params, Plugin, Result},
    tatu_plugin,
};

use entries::BuildPlan;
use model::ParsedModel;

/// The plugin. It has no state.
pub struct FolderModelsPlugin;

impl Plugin for FolderModelsPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(FolderModelsPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.model_reader::<FolderModelReader>();
    }
}

/// Reads models from `model.toml`.
struct FolderModelReader;

impl ModelReader for FolderModelReader {
    type Plugin = FolderModelsPlugin;
    type Model = ParsedModel;

    fn read(_: &FolderModelsPlugin, name: &str, text: &str) -> Result<(ModelInfo, ParsedModel)> {
        match model::read(text).map_err(|wrong| wrong.into_fail(name, text))? {
            Some(read) => Ok(read),
            None => Err(Fail::unsupported("the file has no table [model]")),
        }
    }
    fn build(model: &ParsedModel, builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let refused = |wrong: error::ModelError| wrong.into_fail("", &model.text);
        let mut plan = BuildPlan::new(model, params).map_err(refused)?;
        // The base is the only object in the first piece of scene text; all other objects are attached to it.
        let mut is_base = true;
        while let Some(text) = plan.next_text() {
            builder.scene((!is_base).then(|| builder.base()), "", &text.map_err(refused)?)?;
            is_base = false;
        }
        Ok(())
    }
}

tatu_plugin! {
    plugin: FolderModelsPlugin,
    id: "tatu.models.folder",
    name: "Models without code",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
