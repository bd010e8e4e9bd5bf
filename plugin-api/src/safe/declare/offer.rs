//! Collects what a plugin offers, and owns the memory of its C tables.

use std::{collections::HashSet, ptr::null};

use crate::abi::*;
use crate::safe::{
    Actuator, Command, Constant, Event, HeardFunction, Importer, Language, Model, ModelReader, Part, PerWorld, Plugin,
    Sensor, Service,
    declare::{
        event,
        plugin::{ExtensionTables, Offer, OfferedEvents},
    },
    entry::life::{self, WorldState},
    value::{fail::bytes_raw, table_arena::TableArena},
};

impl<P: Plugin> Offer<P> {
    pub(crate) fn new() -> Self {
        Offer {
            arena: TableArena::default(),
            per_world: null(),
            commands: Vec::new(),
            names: HashSet::new(),
            constants: Vec::new(),
            preludes: Vec::new(),
            kind_marks: Vec::new(),
            sensors: Vec::new(),
            actuators: Vec::new(),
            parts: Vec::new(),
            models: Vec::new(),
            read_model: None,
            importers: Vec::new(),
            languages: Vec::new(),
            services: Vec::new(),
            events: OfferedEvents { published: Vec::new(), listener: None },
        }
    }
    /// Makes the host create an instance of [`PerWorld::World`] for each world, for use by commands.
    pub fn per_world(&mut self)
    where
        P: PerWorld,
    {
        self.per_world = self.arena.table(life::table::<WorldState<P>>(0));
    }
    /// Adds a command for scripts, remote clients and other plugins.
    pub fn command(&mut self, command: Command<P>) {
        self.names.extend(command.names().map(str::to_owned));
        self.commands.push(command);
    }
    /// Returns whether a command with this name has been added.
    pub fn has_command(&self, name: &str) -> bool {
        self.names.contains(name)
    }
    /// Sets the subject of all commands that `offers` adds, unless a command already has one.
    pub fn subject(&mut self, subject: &str, offers: impl FnOnce(&mut Self)) {
        let before = self.commands.len();
        offers(self);
        let new = self.commands.split_off(before);
        self.commands.extend(new.into_iter().map(|c| c.subject(subject)));
    }
    /// Applies `change` to every command added so far, for settings that they share or that are defined elsewhere, such
    /// as examples.
    pub fn each_command(&mut self, mut change: impl FnMut(Command<P>) -> Command<P>) {
        self.commands = std::mem::take(&mut self.commands).into_iter().map(&mut change).collect();
        self.names = self.commands.iter().flat_map(|c| c.names().map(str::to_owned)).collect();
    }
    /// Adds a named constant for scripts.
    pub fn constant(&mut self, constant: Constant) {
        let raw = tatu_constant {
            size: size_of::<tatu_constant>() as u32,
            reserved: 0,
            name: self.arena.text(&constant.name),
            value: self.arena.value(&constant.value),
        };
        let raw = self.arena.table(raw);
        self.constants.push(raw);
    }
    /// Adds a module for scripts of a language, as source text. If `module` is "", the text is run in every new script
    /// state; otherwise scripts load it with `require`.
    pub fn prelude(&mut self, language: &str, module: &str, text: &str) {
        let text = bytes_raw(self.arena.store(text.as_bytes().to_vec()));
        let raw = tatu_prelude {
            size: size_of::<tatu_prelude>() as u32,
            reserved: 0,
            language: self.arena.text(language),
            module: self.arena.text(module),
            text,
        };
        let raw = self.arena.table(raw);
        self.preludes.push(raw);
    }
    /// Adds a word by which the kind of a script is recognized if the script is run without its scene: "main", "child",
    /// "threaded", "customization", "add-on" or "module". A script matches if a name in its source begins with the word
    /// or, with `TATU_MARK_LAST_LINE` in `flags`, if its last non-empty line does. The first mark that matches
    /// determines the kind.
    pub fn kind_mark(&mut self, language: &str, kind: &str, word: &str, flags: u32) {
        let raw = tatu_kind_mark {
            size: size_of::<tatu_kind_mark>() as u32,
            flags,
            language: self.arena.text(language),
            kind: self.arena.text(kind),
            word: self.arena.text(word),
        };
        let raw = self.arena.table(raw);
        self.kind_marks.push(raw);
    }
    /// Adds a kind of sensor.
    pub fn sensor<S: Sensor<Plugin = P>>(&mut self) {
        let raw = crate::safe::entry::sensor_table::table::<S>(&mut self.arena);
        self.sensors.push(raw);
    }
    /// Adds a kind of actuator.
    pub fn actuator<A: Actuator<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::actuator::table::<A>(&mut self.arena);
        self.actuators.push(raw);
    }
    /// Adds a kind of part.
    pub fn part<A: Part<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::part::table::<A>(&mut self.arena);
        self.parts.push(raw);
    }
    /// Adds a model.
    pub fn model<M: Model<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::model::table::<M>(&mut self.arena);
        self.models.push(raw);
    }
    /// Sets the reader for models that are described by text.
    pub fn model_reader<R: ModelReader<Plugin = P>>(&mut self) {
        self.read_model = Some(crate::safe::declare::model_reader::read::<R>);
    }
    /// Adds an importer.
    pub fn importer<I: Importer<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::importer::table::<I>(&mut self.arena);
        self.importers.push(raw);
    }
    /// Adds a script language.
    pub fn language<L: Language<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::language::table::<L>(&mut self.arena, 0);
        self.languages.push(raw);
    }
    /// Adds a script language whose scripts may be called concurrently on different threads, each on one thread at a
    /// time. A script must be able to move between threads, and scripts must not share mutable state.
    pub fn language_side_by_side<L: Language<Plugin = P> + Send>(&mut self) {
        let raw = crate::safe::declare::language::table::<L>(&mut self.arena, TATU_LANGUAGE_SIDE_BY_SIDE);
        self.languages.push(raw);
    }

    /// Adds a service.
    pub fn service<S: Service<Plugin = P>>(&mut self) {
        let raw = crate::safe::declare::service::table::<S>(&mut self.arena);
        self.services.push(raw);
    }
    /// Adds an event that the plugin publishes.
    pub fn event(&mut self, event: Event) {
        let raw = event.into_table(&mut self.arena);
        self.events.published.push(raw);
    }

    /// Makes the plugin receive these events of each world: `heard` is called where events are delivered, after scripts
    /// and parts. `*` means all except "collision", "separation" and "contact". If `heard` fails, it is not called again
    /// in that world.
    pub fn listen(&mut self, events: &[&str], heard: HeardFunction<P>) {
        self.events.listener = Some((heard, events.iter().map(|e| (*e).to_owned()).collect()));
    }

    pub(crate) fn finish(mut self) -> ExtensionTables {
        let keep = &mut self.arena;
        let offers_commands = !self.commands.is_empty()
            || !self.constants.is_empty()
            || !self.preludes.is_empty()
            || !self.kind_marks.is_empty()
            || !self.per_world.is_null();
        let command = offers_commands.then(|| {
            let table = tatu_ext_command {
                size: size_of::<tatu_ext_command>() as u32,
                reserved: 0,
                commands: {
                    let commands = self.commands.into_iter().map(|c| c.into_table(keep)).collect();
                    keep.list(commands)
                },
                constants: keep.list(self.constants),
                preludes: keep.list(self.preludes),
                per_world: self.per_world,
                kind_marks: keep.list(self.kind_marks),
            };
            keep.table(table)
        });
        let sensor = (!self.sensors.is_empty()).then(|| {
            let kinds = keep.list(self.sensors);
            keep.table(tatu_ext_sensor { size: size_of::<tatu_ext_sensor>() as u32, reserved: 0, kinds })
        });
        let actuator = (!self.actuators.is_empty()).then(|| {
            let kinds = keep.list(self.actuators);
            keep.table(tatu_ext_actuator { size: size_of::<tatu_ext_actuator>() as u32, reserved: 0, kinds })
        });
        let part = (!self.parts.is_empty()).then(|| {
            let kinds = keep.list(self.parts);
            keep.table(tatu_ext_part { size: size_of::<tatu_ext_part>() as u32, reserved: 0, kinds })
        });
        let model = (!self.models.is_empty() || self.read_model.is_some()).then(|| {
            let (models, read) = (keep.list(self.models), self.read_model);
            keep.table(tatu_ext_model { size: size_of::<tatu_ext_model>() as u32, reserved: 0, models, read })
        });
        let importer = (!self.importers.is_empty()).then(|| {
            let importers = keep.list(self.importers);
            keep.table(tatu_ext_importer { size: size_of::<tatu_ext_importer>() as u32, reserved: 0, importers })
        });
        let script = (!self.languages.is_empty()).then(|| {
            let languages = keep.list(self.languages);
            keep.table(tatu_ext_script { size: size_of::<tatu_ext_script>() as u32, reserved: 0, languages })
        });
        let service = (!self.services.is_empty()).then(|| {
            let services = keep.list(self.services);
            keep.table(tatu_ext_service { size: size_of::<tatu_ext_service>() as u32, reserved: 0, services })
        });
        let event = (!self.events.published.is_empty() || self.events.listener.is_some()).then(|| {
            let events = keep.list(self.events.published);
            let names =
                self.events.listener.as_ref().map(|(_, names)| names.iter().map(String::as_str).collect::<Vec<_>>());
            let listens = names.map_or(null(), |names| keep.texts(&names));
            let heard = self.events.listener.as_ref().map(|_| event::heard::<P> as HeardFn);
            keep.table(tatu_ext_event { size: size_of::<tatu_ext_event>() as u32, reserved: 0, events, heard, listens })
        });
        ExtensionTables {
            command: command.unwrap_or(null()),
            sensor: sensor.unwrap_or(null()),
            actuator: actuator.unwrap_or(null()),
            part: part.unwrap_or(null()),
            model: model.unwrap_or(null()),
            importer: importer.unwrap_or(null()),
            script: script.unwrap_or(null()),
            service: service.unwrap_or(null()),
            event: event.unwrap_or(null()),
            _arena: self.arena,
        }
    }
}
