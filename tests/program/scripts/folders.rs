//! Tests that scripts can open files only in their folders, and that links, pipes and devices are refused with an
//! error.

#![cfg(unix)]

use std::{fs, os::unix::fs::symlink, process::Command};

use crate::kit::*;

/// Creates a scene folder beside a forbidden folder, with links into the forbidden folder.
fn place(script: &str) -> TestFolder {
    let place = TestFolder::new();
    let p = place.path();
    place.write("scene/scene.toml", &format!("format = 1\n{}", watcher("d", script)));
    place.write("scene/own.txt", "own\n").write("scene/sub/inner.txt", "inner\n");
    place.write("outside/secret.lua", "return 'secret'\n").write("outside/secret.txt", "secret\n");
    fs::write(p.join("outside/picture.png"), b"\x89PNG").unwrap();
    for (to, link) in [
        ("../outside/secret.txt", "read.txt"),
        ("../outside/secret.txt", "write.txt"),
        ("../outside/secret.txt", "saved.toml"),
        ("../outside/secret.txt", "image.png"),
        ("../outside/picture.png", "picture.png"),
        ("../outside/secret.lua", "secret.lua"),
        ("../outside/new.txt", "dangling.txt"),
        ("../outside/new.toml", "dangling.toml"),
        ("../outside", "away"),
        ("/dev/zero", "device.txt"),
        ("own.txt", "link.txt"),
        ("sub", "folder_link"),
    ] {
        symlink(to, p.join("scene").join(link)).unwrap();
    }
    // The folder for the meshes of a saved scene is a link.
    symlink("../outside", p.join("scene/parts_files")).unwrap();
    succeed(Command::new("mkfifo").arg(p.join("scene/pipe.txt")));
    place
}

/// Runs the scene in its folder, and checks that nothing outside has changed.
fn ran(place: &TestFolder) -> RunOutput {
    let done = run(
        program(),
        &place.path().join("scene"),
        &["run", "scene.toml", "--steps", "2", "--no-addons", "--json"],
        &[],
    );
    let mut outside: Vec<_> =
        fs::read_dir(place.path().join("outside")).unwrap().map(|e| e.unwrap().file_name()).collect();
    outside.sort();
    assert_eq!(outside, ["picture.png", "secret.lua", "secret.txt"]);
    assert_eq!(place.read("outside/secret.txt"), "secret\n");
    done
}

#[test]
fn links_lead_neither_reading_nor_writing_out() {
    let script = "function refused(name, f, ...)
            local ok, why, more = pcall(f, ...)
            if ok then why = more end
            assert(why ~= nil and tostring(why):find(name, 1, true) and tostring(why):find('link'), name .. ': ' .. tostring(why))
        end
        function sysCall_init()
            for _, mode in ipairs({'r', 'r+', 'a', 'w', 'w+', 'a+'}) do
                refused('read.txt', io.open, 'read.txt', mode)
                refused('dangling.txt', io.open, 'dangling.txt', mode)
                refused('away/secret.txt', io.open, 'away/secret.txt', mode)
            end
            refused('write.txt', io.lines, 'write.txt')
            refused('saved.toml', sim.saveScene, 'saved.toml')
            refused('dangling.toml', sim.saveScene, 'dangling.toml')
            refused('image.png', sim.saveImage, string.rep('x', 12), {2, 2}, 0, 'image.png', -1)
            refused('picture.png', sim.loadImage, 0, 'picture.png')
            refused('secret.lua', dofile, 'secret.lua')
            local found, why = pcall(require, 'secret')
            assert(not found, why)
            print('done')
        end";
    let done = ran(&place(script)).good();
    done.reports(&["done"]);
}

#[test]
fn links_beside_a_saved_scene_are_not_followed() {
    // A mesh becomes a file in the folder `parts_files` beside `parts.toml`, which is a link.
    let script = "function sysCall_init()
            local shape = sim.createMeshShape(0, 0, {0,0,0, 1,0,0, 0,1,0, 0,0,1}, {0,1,2, 0,1,3, 0,2,3, 1,2,3})
            local ok, why = pcall(sim.saveScene, 'parts.toml')
            assert(not ok and tostring(why):find('link'), why)
            assert(sim.saveScene('whole.toml') == 1)
            print('done')
        end";
    let place = place(script);
    ran(&place).good().reports(&["done"]);
    assert!(place.path().join("scene/whole.toml").is_file());
}

/// If a script replaced the scene's own file, the user of the page could no longer save the scene.
#[test]
fn scripts_do_not_save_to_the_scenes_own_file() {
    let script = "function sysCall_init()
            for _, name in ipairs({'scene.toml', './scene.toml', 'sub/../scene.toml'}) do
                local ok, why = pcall(sim.saveScene, name)
                assert(not ok and tostring(why):find(\"scene's own file\"), why)
                ok, why = pcall(sim.saveModel, sim.getObject('/d'), name)
                assert(not ok and tostring(why):find(\"scene's own file\"), why)
            end
            assert(sim.saveScene('other.toml') == 1)
            print('done')
        end";
    let place = place(script);
    let before = place.read("scene/scene.toml");
    ran(&place).good().reports(&["done"]);
    assert_eq!(place.read("scene/scene.toml"), before);
}

#[test]
fn links_within_the_folder_are_followed() {
    let script = "function sysCall_init()
            assert(io.open('link.txt'):read() == 'own')
            assert(io.open('folder_link/inner.txt'):read() == 'inner')
            local f = io.open('link.txt', 'w') f:write('new') f:close()
            assert(io.open('own.txt'):read() == 'new')
            f = io.open('made.txt', 'a+') f:write('one') f:close()
            f = io.open('made.txt', 'a') f:write(' two') f:close()
            f = io.open('made.txt', 'r+') f:write('ONE') f:close()
            assert(io.open('made.txt'):read() == 'ONE two')
            f = io.open('made.txt', 'w+') f:write('x') f:seek('set') assert(f:read() == 'x') f:close()
            assert(io.open('none.txt') == nil and io.open('none.txt', 'r+') == nil)
            print('done')
        end";
    ran(&place(script)).good().reports(&["done"]);
}

#[test]
fn pipes_devices_and_folders_are_no_files() {
    let script = "function sysCall_init()
            for _, name in ipairs({'pipe.txt', 'device.txt', 'sub'}) do
                for _, mode in ipairs({'r', 'w', 'a', 'r+'}) do
                    local f, why = io.open(name, mode)
                    assert(f == nil and why:find(name, 1, true), name .. ' ' .. mode .. ': ' .. tostring(why))
                end
            end
            print('done')
        end";
    ran(&place(script)).good().reports(&["done"]);
}

/// Scripts of a model find the model's modules wherever the model is. Other scripts do not find them, and no path leads
/// out of the folder.
#[test]
fn scripts_of_models_require_modules_of_their_folder() {
    let place = TestFolder::new();
    let model = "format = 1\n[model]\ntext = \"T\"\n[[object]]\nkind = \"dummy\"\nalias = \"m\"\nscript = \"m.lua\"\n";
    place.write("far/models/m/model.toml", model).write("far/models/m/parts/help.lua", "return 'helped'\n");
    place.write("secret.lua", "return 'secret'\n");
    symlink("../../../secret.lua", place.path().join("far/models/m/away.lua")).unwrap();
    let script = "function sysCall_init()
            print(require 'parts.help')
            assert(not pcall(require, 'away') and not pcall(dofile, 'parts/help.lua') and not pcall(io.lines, 'm.lua'))
        end";
    place.write("far/models/m/m.lua", script);
    let other = "function sysCall_init() assert(not pcall(require, 'parts.help')) end";
    let scene = format!("format = 1\n[[model]]\nmodel = \"m\"\n{}", watcher("d", other));
    place.write("near/scene.toml", &scene);
    let models = place.path().join("far/models");
    let near = place.path().join("near");
    let env = [("TATU_MODEL_PATH", models.to_str().unwrap())];
    for more in [&[][..], &["--files", "."]] {
        let args = [&["run", "scene.toml", "--steps", "1", "--no-addons"], more].concat();
        let done = run(program(), &near, &args, &env).good();
        assert!(done.out.contains("helped"), "{}{}", done.out, done.err);
    }
    // The names of scripts may be relative to the working folder.
    let args = ["run", "near/scene.toml", "--steps", "1", "--no-addons", "--files", "near"];
    let done = run(program(), place.path(), &args, &[("TATU_MODEL_PATH", "far/models")]).good();
    assert!(done.out.contains("helped"), "{}{}", done.out, done.err);
}
