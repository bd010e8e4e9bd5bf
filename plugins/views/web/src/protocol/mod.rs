//! The text messages between the page and the program: one enum per direction. The key `type` of a message's JSON
//! object is the name of the variant. `page/protocol.d.ts` declares the same messages in TypeScript; a test compares
//! the two.

mod from_page;
mod object;
mod sensor_data;
mod to_page;

pub(crate) use from_page::{FromPage, RunAction, WatchedValue};
pub(crate) use object::{
    Joint, ModelCopy, ReadingSchema, SceneEntry, SceneObject, Script, SensorVolume, Texture, VisiblePart,
};
pub(crate) use sensor_data::{
    BodyMark, ContactMark, CurvePoints, Drawing, Reading, ReadingMap, StreamSamples, WatchSample,
};
pub(crate) use to_page::{Command, EditState, GallerySection, OutputLine, PropertyRow, RunState, SceneFile, ToPage};

#[cfg(test)]
mod tests {
    use std::{collections::BTreeMap, fs, path::Path};

    use ts_rs::{Config, TS, TypeVisitor};

    use super::*;

    /// Collects the TypeScript declarations of a type and of all types that it refers to, by name.
    struct TypeDeclarations<'a>(&'a Config, BTreeMap<String, String>);

    impl TypeVisitor for TypeDeclarations<'_> {
        fn visit<T: TS + 'static + ?Sized>(&mut self) {
            // Types from other crates have no output path and are not declared.
            if T::output_path().is_none() || self.1.contains_key(&T::ident(self.0)) {
                return;
            }
            let docs = T::docs().unwrap_or_default();
            self.1.insert(T::ident(self.0), format!("{docs}export {}\n", T::decl(self.0)));
            T::visit_dependencies(self);
        }
    }

    fn declarations() -> String {
        let config = Config::new();
        let mut all = TypeDeclarations(&config, BTreeMap::new());
        all.visit::<ToPage>();
        all.visit::<FromPage>();
        let head = "// The messages of the page and the program, generated from plugins/views/web/src/protocol/ by\n\
                    // `TATU_BLESS=page cargo test -p tatu-views-web protocol`.\n";
        let text = [head.to_owned()].into_iter().chain(all.1.into_values()).collect::<Vec<_>>().join("\n");
        // ts-rs leaves trailing spaces in declarations that span several lines.
        text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n") + "\n"
    }

    #[test]
    fn the_page_has_the_same_types() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("page/protocol.d.ts");
        let own = declarations();
        if std::env::var_os("TATU_BLESS").is_some_and(|v| v == "page") {
            fs::write(&file, &own).unwrap();
        }
        let known = fs::read_to_string(&file).unwrap_or_default().replace("\r\n", "\n");
        assert!(
            own == known,
            "page/protocol.d.ts differs from src/protocol/: regenerate it by \
             `TATU_BLESS=page cargo test -p tatu-views-web protocol`"
        );
    }
}
