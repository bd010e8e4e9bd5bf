//! Tests that the names in a document lead only to files in the folders that the run may read: the working folder, the
//! scene's folder, and the folders of models that the user has installed.

use std::{fs, path::Path, process::Command};

use tatu_core::{
    document::{self, LoadOptions, SourceFiles},
    plugins::{FolderOrigin, SearchPath},
};

use crate::kit::*;

const MODEL: &str = "format = 1\n[model]\ntext = \"T\"\n[[object]]\nkind = \"dummy\"\nalias = \"m\"\n";
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// Creates the folder `home` with the scene's folder `home/scene` and files beside it, which a scene must not read.
fn home() -> TestFolder {
    let place = TestFolder::new();
    place.write("home/secret.json", "{\"secret\": 1}").write("home/secret.lua", "").write("home/secret", "text");
    place.write("home/secret.obj", CUBE).write("home/secret.toml", MODEL).write("home/part.toml", "format = 1\n");
    place.write("home/robot.urdf", "<robot name=\"r\"><link name=\"base\"/></robot>");
    fs::write(place.path().join("home/secret.png"), b"\x89PNG").unwrap();
    place
}

fn check(place: &TestFolder, scene: &str, env: &[(&str, &str)]) -> RunOutput {
    place.write("home/scene/s.toml", &format!("format = 1\n{scene}"));
    run(program(), &place.path().join("home/scene"), &["check", "s.toml"], env)
}

fn dummy(rest: &str) -> String {
    format!("[[object]]\nkind = \"dummy\"\nalias = \"d\"\n{rest}\n")
}

/// Returns the ways in which a document can name a file.
fn ways(file: impl Fn(&str) -> String) -> Vec<String> {
    let shape = |rest: String| format!("[[object]]\nkind = \"shape\"\nalias = \"s\"\n{rest}\n");
    vec![
        dummy(&format!("script = \"{}\"", file("secret.lua"))),
        dummy(&format!("script = {{ file = \"{}\", language = \"lua\" }}", file("secret.json"))),
        dummy(&format!("scripts = [{{ file = \"{}\", language = \"lua\" }}]", file("secret"))),
        format!("{}[set]\n\"/d.script\" = {{ file = \"{}\", language = \"lua\" }}\n", dummy(""), file("secret.json")),
        format!("[[model]]\nmodel = \"{}\"\n", file("secret.toml")),
        format!("[[model]]\nfile = \"{}\"\n", file("part.toml")),
        format!("[[model]]\nfile = \"{}\"\n", file("robot.urdf")),
        format!("[[import]]\nfile = \"{}\"\n", file("robot.urdf")),
        format!("[[import]]\nfile = \"{}\"\n", file("secret.obj")),
        shape(format!("primitive = \"mesh\"\nmesh = \"{}\"", file("secret.obj"))),
        shape(format!("parts = [{{ primitive = \"mesh\", mesh = \"{}\" }}]", file("secret.obj"))),
        shape(format!("texture = {{ image = \"{}\" }}", file("secret.png"))),
    ]
}

#[test]
fn no_kind_of_path_leads_out_of_the_folders() {
    let place = home();
    let above = place.path().join("home");
    for scene in
        ways(|name| format!("../{name}")).into_iter().chain(ways(|name| above.join(name).display().to_string()))
    {
        check(&place, &scene, &[]).refused(&["E105", "is outside the folders that may be read", "s.toml:"]);
    }
    // Whether a file exists is not revealed.
    for scene in ways(|name| format!("../no_{name}")) {
        check(&place, &scene, &[]).refused(&["E105", "is outside the folders that may be read"]);
    }
    // The working folder may contain both the scene and the files that it names.
    let script = dummy("script = { file = \"../secret.lua\", language = \"lua\" }");
    place.write("home/scene/s.toml", &format!("format = 1\n{script}"));
    run(program(), &place.path().join("home"), &["check", "scene/s.toml"], &[]).good();
}

#[test]
fn paths_in_referenced_files_are_confined_to_the_scene_folder() {
    let place = home();
    let inner = [
        ("models/m/model.toml", format!("{MODEL}script = {{ file = \"../../../secret.json\", language = \"lua\" }}\n")),
        ("part.toml", format!("format = 1\n{}", dummy("script = { file = \"../secret.json\", language = \"lua\" }"))),
        ("deep/part.toml", "format = 1\n[[model]]\nfile = \"../../part.toml\"\n".to_owned()),
        ("deep/import.toml", "format = 1\n[[import]]\nfile = \"../../robot.urdf\"\n".to_owned()),
    ];
    for (file, text) in &inner {
        place.write(&format!("home/scene/{file}"), text);
    }
    for scene in [
        "[[model]]\nmodel = \"m\"\n",
        "[[model]]\nfile = \"models/m/model.toml\"\n",
        "[[model]]\nfile = \"part.toml\"\n",
        "[[model]]\nfile = \"deep/part.toml\"\n",
        "[[model]]\nfile = \"deep/import.toml\"\n",
    ] {
        check(&place, scene, &[]).refused(&["E105", "is outside the folders that may be read"]);
    }
}

/// A model that the user has installed may name the files in its folder, and no others.
#[test]
fn a_model_is_confined_to_its_own_folder() {
    let place = home();
    let model = |script: &str| format!("{MODEL}script = {{ file = \"{script}\", language = \"lua\" }}\n");
    place.write("far/models/m/model.toml", &model("own.lua")).write("far/models/m/own.lua", "");
    place.write("far/secret.lua", "");
    let models = place.path().join("far/models");
    let env = [("TATU_MODEL_PATH", models.to_str().unwrap())];
    check(&place, "[[model]]\nmodel = \"m\"\n", &env).good();
    place.write("far/models/m/model.toml", &model("../../secret.lua"));
    check(&place, "[[model]]\nmodel = \"m\"\n", &env).refused(&["E105", "is outside the folders that may be read"]);
    place.write("far/models/m/model.toml", &model(&place.path().join("home/secret.lua").display().to_string()));
    check(&place, "[[model]]\nmodel = \"m\"\n", &env).refused(&["E105", "is outside the folders that may be read"]);
}

#[cfg(unix)]
#[test]
fn links_pipes_and_devices_are_refused_in_every_name() {
    use std::os::unix::fs::symlink;
    let place = home();
    let scene = place.path().join("home/scene");
    fs::create_dir_all(scene.join("models")).unwrap();
    for name in
        ["secret.lua", "secret.json", "secret", "secret.toml", "part.toml", "robot.urdf", "secret.obj", "secret.png"]
    {
        symlink(Path::new("..").join(name), scene.join(name)).unwrap();
    }
    for text in ways(str::to_owned) {
        check(&place, &text, &[]).refused(&["E105", "is outside the folders that may be read"]);
    }
    // A model beside the scene, or its file, is a link.
    place.write("home/far/model.toml", MODEL);
    symlink("../../far", scene.join("models/folder")).unwrap();
    fs::create_dir(scene.join("models/file")).unwrap();
    symlink("../../../far/model.toml", scene.join("models/file/model.toml")).unwrap();
    for name in ["folder", "file"] {
        check(&place, &format!("[[model]]\nmodel = \"{name}\"\n"), &[])
            .refused(&["E105", "is outside the folders that may be read"]);
    }
    // Reading a pipe would block for ever.
    succeed(Command::new("mkfifo").arg(scene.join("pipe.lua")));
    succeed(Command::new("mkfifo").arg(scene.join("pipe.toml")));
    check(&place, &dummy("script = \"pipe.lua\""), &[]).refused(&["E105", "pipe.lua", "not a plain file"]);
    check(&place, "[[model]]\nmodel = \"pipe.toml\"\n", &[]).refused(&["E105", "pipe.toml", "not a plain file"]);
    check(&place, "[[import]]\nfile = \"pipe.toml\"\n", &[]).refused(&["E105", "pipe.toml", "not a plain file"]);
}

/// A script writes a document and loads it. The document may refer only to files that the script may read, and does not
/// give the script access to further folders.
#[test]
fn documents_that_a_script_writes_are_confined_like_the_script() {
    let place = home();
    let other = place.path().join("home/secret.json").display().to_string();
    let script = format!(
        "function sysCall_init()
            assert(not io.open('{other}'))
            local function made(text)
                local f = io.open('made.toml', 'w')
                f:write('format = 1\\n' .. text)
                f:close()
                return pcall(sim.loadModel, 'made.toml')
            end
            for _, name in ipairs({{'{other}', '../secret.json', '../none.json'}}) do
                for _, text in ipairs({{'script = {{ file = \"NAME\", language = \"lua\" }}', 'mesh = \"NAME\"', 'texture = {{ image = \"NAME\" }}'}}) do
                    local kind = text:find('script') and 'dummy' or 'shape'
                    local ok, why = made('[[object]]\\nkind = \"' .. kind .. '\"\\nalias = \"k\"\\n' .. text:gsub('NAME', name))
                    assert(not ok and why:find('outside the folders'), why)
                end
            end
            assert(not io.open('{other}'))
            assert(made('[[object]]\\nkind = \"dummy\"\\nalias = \"k\"\\nscript = \"own.lua\"\\n'))
            print('done')
        end"
    );
    place.write("home/scene/own.lua", "").write("home/scene/s.toml", &format!("format = 1\n{}", watcher("d", &script)));
    for more in [&[][..], &["--files", "."]] {
        let args = [&["run", "s.toml", "--steps", "1", "--no-addons"], more].concat();
        let done = run(program(), &place.path().join("home/scene"), &args, &[]).good();
        assert!(done.out.contains("done"), "{}{}", done.out, done.err);
    }
}

/// The files in an input log are not read from disk, but their paths must not open folders for modules either.
#[test]
fn paths_in_stored_documents_open_no_folders() {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), FolderOrigin::Built));
    search.built = vec!["tatu_scripts_lua".to_owned()];
    let registry = load_registry(search);
    let scene =
        "format = 1\n[[object]]\nkind = \"dummy\"\nscript = { file = \"/etc/host.conf\", language = \"lua\" }\n";
    let files = [("/srv/s.toml", scene), ("/etc/host.conf", "")];
    let sources = SourceFiles::of(files.map(|(path, text)| (path.into(), text.into())));
    let document =
        document::load(Path::new("/srv/s.toml"), &registry, &LoadOptions { sources, ..LoadOptions::default() })
            .unwrap();
    assert_eq!(document.objects[0].scripts.len(), 1);
    assert!(document.modules.is_empty(), "{:?}", document.modules);
}
