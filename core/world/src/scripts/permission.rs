//! Scripts whose language needs a permission that the user has not granted.

use tatu_plugin_api::abi::*;

use crate::cell::{Script, WorldCell};

impl Script {
    /// Returns the permission that the script's language needs, if the user has not granted it.
    pub(super) fn lacking_permission<'w>(&self, world: &'w WorldCell) -> Option<&'w str> {
        let word = world.model.registry.scripting.languages[self.language].permission.as_deref()?;
        let granted = world.model.settings.borrow().allow.iter().any(|allowed| allowed == word);
        (!granted).then_some(word)
    }

    /// Reports once for all scripts of this language that they do not run.
    pub(super) fn report_withheld(&self, world: &WorldCell) {
        let Some(word) = self.lacking_permission(world) else { return };
        let language = &world.model.registry.scripting.languages[self.language].id;
        let same: Vec<u32> =
            world.run.scripts.borrow().list.iter().filter(|s| s.language == self.language).map(|s| s.slot).collect();
        if same.first() == Some(&self.slot) {
            let (scripts, run) = if same.len() == 1 { ("script", "does") } else { ("scripts", "do") };
            let text = format!(
                "{} {scripts} in the language `{language}` {run} not run, because such scripts can do anything that \
                 your account can; if you trust the scene, allow them with `--allow {word}`",
                same.len()
            );
            world.log(TATU_LOG_WARNING, &text);
        }
    }
}
