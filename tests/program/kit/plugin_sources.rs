//! Plugins in C with replaceable parts, for tests of rejected plugins and of conflicting ids.

use std::{fs, process::Command};

use crate::kit::*;

/// A plugin in C with one command, `<name>.one`; each part can be replaced.
#[derive(Clone)]
pub struct PluginSource {
    /// C code at file scope, before the tables.
    pub before: String,
    /// Id of the plugin, as a C literal.
    pub id: String,
    pub major: String,
    pub size: String,
    pub needs: String,
    pub init: String,
    /// Body of the C function `extension`, whose argument `id` is the requested extension.
    pub extension: String,
    pub tail: String,
}

impl PluginSource {
    pub fn new(name: &str) -> Self {
        let before = format!(
            "static tatu_status one(tatu_call *c) {{ return tatu_return(c, tatu_int(1)); }}
static const tatu_name one_name = {{.size = sizeof(tatu_name), .name = \"{name}.one\"}};
static const tatu_name *const one_names[] = {{&one_name, NULL}};
static const tatu_command one_command = {{.size = sizeof(tatu_command), .names = one_names, .text = \"One.\", .call = one}};
static const tatu_command *const commands[] = {{&one_command, NULL}};
static const tatu_ext_command ext_command = {{.size = sizeof(tatu_ext_command), .commands = commands}};
"
        );
        PluginSource {
            before,
            id: format!("\"org.test.{name}\""),
            major: "TATU_ABI_MAJOR".into(),
            size: "sizeof(tatu_plugin_t)".into(),
            needs: "NULL".into(),
            init: "NULL".into(),
            extension: "return strcmp(id, TATU_COMMAND) ? NULL : (const void *)&ext_command;".into(),
            tail: String::new(),
        }
    }
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
    pub fn text(&self) -> String {
        let PluginSource { before, id, major, size, needs, init, extension, tail } = self;
        let init_field = if init == "NULL" { "NULL" } else { "init" };
        let init = if init == "NULL" {
            String::new()
        } else {
            format!(
                "static tatu_status init(const tatu_host *host, void **self, tatu_error *e) {{ (void)host; (void)self; (void)e; {init} }}"
            )
        };
        let (offer, extension) = match extension.as_str() {
            "NULL" => ("NULL", String::new()),
            body => (
                "extension",
                format!("static const void *extension(void *self, const char *id) {{ (void)self; {body} }}"),
            ),
        };
        format!(
            "#include \"tatu.h\"\n#include <math.h>\n#include <string.h>\n{before}\n{init}\n{extension}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {{.size = {size}, .abi_major = {major}, .abi_minor = TATU_ABI_MINOR,
  .id = {id}, .name = \"Test\", .version = \"1\", .licence = \"MIT\", .needs = {needs}, .init = {init_field},
  .extension = {offer}}};\n{tail}\n"
        )
    }
}

/// Returns the C code of a sensor that measures nothing, and of the tables of a plugin that offers it.
fn sensor(id: &str, table: &str) -> String {
    format!(
        "static tatu_status create(void *s, const tatu_instance *i, void **d, tatu_error *e) {{ (void)s; (void)i; (void)d; (void)e; return TATU_OK; }}
static void destroy(void *d) {{ (void)d; }}
static tatu_status measure(void *s, const tatu_sensor_batch *b, tatu_error *e) {{ (void)s; (void)b; (void)e; MEASURE return TATU_OK; }}
static const char *const schemas[] = {{\"eye/1\", NULL}};
static const tatu_life life = {{.size = sizeof(tatu_life), .create = create, .destroy = destroy}};
static const tatu_sensor eye = {{.size = sizeof(tatu_sensor), .id = \"{id}\", .text = \"An eye.\", .schemas = schemas, .life = &life, .measure = measure{table}}};
static const tatu_sensor *const kinds[] = {{&eye, NULL}};
static const tatu_ext_sensor ext_sensor = {{.size = sizeof(tatu_ext_sensor), .kinds = kinds}};
"
    )
}

/// Returns a plugin with the sensor kind `id`.
pub fn eye(name: &str, id: &str, table: &str) -> PluginSource {
    let before = format!("#ifndef MEASURE\n#define MEASURE\n#endif\n{}", sensor(id, table));
    PluginSource::new(name).with(|s| {
        s.before += &before;
        s.extension = format!("if (!strcmp(id, TATU_SENSOR)) return &ext_sensor; {}", s.extension);
    })
}

/// Compiles a plugin into `mine/`.
pub fn compile(place: &TestFolder, name: &str, source: &str) {
    compile_with(place, name, source, &[]);
}

/// Like [`compile`], with further arguments of the compiler after the source.
pub fn compile_with(place: &TestFolder, name: &str, source: &str, more: &[&str]) {
    place.write(&format!("mine/{name}.c"), source);
    let file = place.path().join("mine").join(library(&format!("tatu_{name}")));
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Wno-unused-function", "-Wno-unused-const-variable"])
            .args(["-Wno-override-init", "-shared", "-fPIC", "-fvisibility=hidden", "-I"])
            .arg(root().join("plugin-api/include"))
            .arg("-o")
            .arg(file)
            .arg(place.path().join("mine").join(format!("{name}.c")))
            .args(more)
            .current_dir(place.path().join("mine")),
    );
}

/// Complete tables of a model, a language, an actuator, an importer and a service.
const OTHER_TABLES: &str = "static tatu_status build(void *s, const tatu_builder *b, const tatu_value *p, tatu_error *e) { (void)s; (void)p; (void)e; b->object(b, \"dummy\", 0, tatu_text(\"BUILT\")); return TATU_OK; }
static const tatu_model model = {.size = sizeof(tatu_model), .id = \"thing\", .text = \"A thing.\", .build = build};
static const tatu_model *const models[] = {&model, NULL};
static const tatu_ext_model ext_model = {.size = sizeof(tatu_ext_model), .models = models};
static tatu_status made(void *s, const tatu_instance *i, void **d, tatu_error *e) { (void)s; (void)i; (void)e; *d = (void *)&model; return TATU_OK; }
static void ended(void *d) { (void)d; }
static tatu_status load(void *d, tatu_str t, tatu_str c, tatu_str a, tatu_str *o, tatu_error *e) { (void)d; (void)t; (void)c; (void)a; (void)o; return tatu_fail(e, TATU_ERR_SCRIPT, \"loaded by LANGUAGE\"); }
static uint32_t find(void *d, uint32_t h, tatu_str n) { (void)d; (void)h; (void)n; return 0; }
static tatu_status call(void *d, uint32_t i, tatu_call *f, const tatu_budget *b, uint64_t *u, tatu_error *e) { (void)d; (void)i; (void)f; (void)b; (void)u; (void)e; return TATU_OK; }
static tatu_status resume(void *d, uint64_t t, tatu_status x, tatu_call *f, const tatu_budget *b, uint64_t *u, tatu_error *e) { (void)d; (void)t; (void)x; (void)f; (void)b; (void)u; (void)e; return TATU_OK; }
static uint32_t keep(void *d, uint32_t l) { (void)d; return l; }
static void drop(void *d, uint32_t l) { (void)d; (void)l; }
static const tatu_life script_life = {.size = sizeof(tatu_life), .create = made, .destroy = ended};
static const char *const suffixes[] = {\".tongue\", NULL};
static const tatu_language language = {.size = sizeof(tatu_language), .id = \"tongue\", .text = \"A language.\", .suffixes = suffixes, .life = &script_life, .load = load, .find = find, .call = call, .resume = resume, .keep_func = keep, .drop_func = drop, .call_func = call};
static const tatu_language *const languages[] = {&language, NULL};
static const tatu_ext_script ext_script = {.size = sizeof(tatu_ext_script), .languages = languages};
static tatu_status apply(void *s, const tatu_actuator_batch *b, tatu_error *e) { (void)s; (void)b; (void)e; return TATU_OK; }
static const tatu_actuator arm = {.size = sizeof(tatu_actuator), .id = \"arm\", .text = \"An arm.\", .apply = apply};
static const tatu_actuator *const arms[] = {&arm, NULL};
static const tatu_ext_actuator ext_actuator = {.size = sizeof(tatu_ext_actuator), .kinds = arms};
static tatu_status read(void *s, tatu_str t, const tatu_builder *b, const tatu_value *p, tatu_error *e) { (void)t; return build(s, b, p, e); }
static const char *const endings[] = {\".scroll\", NULL};
static const tatu_importer reader = {.size = sizeof(tatu_importer), .id = \"reader\", .text = \"A reader.\", .suffixes = endings, .load = read};
static const tatu_importer *const readers[] = {&reader, NULL};
static const tatu_ext_importer ext_importer = {.size = sizeof(tatu_ext_importer), .importers = readers};
static tatu_status start(void *s, const tatu_instance *i, void **d, tatu_error *e) { (void)s; (void)i; (void)d; return tatu_fail(e, TATU_ERR, \"started by LANGUAGE\"); }
static void stop(void *d) { (void)d; }
static const tatu_life butlers = {.size = sizeof(tatu_life), .create = start, .destroy = stop};
static tatu_status barrier(void *d, tatu_world *w, uint64_t n, tatu_error *e) { (void)d; (void)w; (void)n; (void)e; return TATU_GO; }
static const tatu_service butler = {.size = sizeof(tatu_service), .id = \"butler\", .text = \"A service.\", .life = &butlers, .barrier = barrier};
static const tatu_service *const services[] = {&butler, NULL};
static const tatu_ext_service ext_service = {.size = sizeof(tatu_ext_service), .services = services};
";

/// Returns a plugin that declares one item of each type; its texts contain `mark`, to identify the plugin.
pub fn all(name: &str, mark: &str) -> PluginSource {
    eye(name, "eye", "").with(|s| {
        s.before += &OTHER_TABLES.replace("BUILT", &format!("built_by_{mark}")).replace("LANGUAGE", mark);
        s.extension = format!(
            "if (!strcmp(id, TATU_MODEL)) return &ext_model; if (!strcmp(id, TATU_SCRIPT)) return &ext_script; \
             if (!strcmp(id, TATU_ACTUATOR)) return &ext_actuator; if (!strcmp(id, TATU_IMPORTER)) return &ext_importer; \
             if (!strcmp(id, TATU_SERVICE)) return &ext_service; {}",
            s.extension
        );
    })
}

/// Creates a scene that loads plugins from the folder `mine`.
pub fn place(more: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\n{FLOOR}{more}"));
    fs::create_dir(place.path().join("mine")).unwrap();
    place
}
