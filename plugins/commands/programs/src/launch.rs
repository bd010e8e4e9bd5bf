//! The command `sim.launchExecutable`.

use std::{
    path::{Path, PathBuf},
    process::Command as Process,
};

use tatu_plugin_api::{
    abi::*,
    safe::{Call, Command, Fail, Offer, Param, Value},
};

use crate::{bubblerob, plugin::Programs};

type Ctx<'a> = Call<'a, Programs>;

/// Kind of this plugin's entries in the input log.
const KIND: &str = "program";

pub(crate) fn offer(offer: &mut Offer<Programs>) {
    offer.command(
        Command::new("sim.launchExecutable", |c: &mut Ctx<'_>| {
            if c.caller_script() == 0 {
                return Err(Fail::unsupported("only scripts can start programs; remote clients cannot"));
            }
            let file = c.text(0)?;
            let args = match c.arg(1).as_f64() {
                Some(number) => number.to_string(),
                None if c.has(1) => c.text(1)?,
                None => String::new(),
            };
            // A replay does not start the program, but must return the recorded result, because scripts can depend on
            // it.
            let started = c.world().observe(KIND, || if launch(c, &file, &args) { "1".into() } else { "-1".into() })?;
            c.ret(if started == "1" { 1i64 } else { -1 });
            Ok(())
        })
        .old_name("simLaunchExecutable", [Value::Int(-1)])
        .param(
            Param::string("file")
                .text("a file in the folder of the scene, or a path; `@name`: a command of the operating system"),
        )
        .param(Param::any("args").optional().text("a string that is split at spaces, or a number"))
        .param(Param::int("show").optional().text("ignored"))
        .returns(Param::int("result").text("1; -1: the program was not started"))
        .text(
            "Starts a program without waiting for it, if the run is permitted to: `--allow exec`. If `bubbleRobServer` \
             does not exist, a built-in server listens instead on the port given as the argument.",
        )
        .partial("Only if the run was started with `--allow exec`.")
        .example("assert(sim.launchExecutable('nowhere', 20000) == -1)"),
    );
}

fn launch(c: &Ctx<'_>, file: &str, args: &str) -> bool {
    let world = c.world();
    let text = |prop| world.get(0, prop).ok().and_then(|v| v.as_str().map(|s| s.into_owned())).unwrap_or_default();
    let (allow, scene) = (text(c.plugin().allow), PathBuf::from(text(c.plugin().file)));
    let tell = |level, what: String| world.log(level, what.as_bytes());
    let folder = scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let program = match file.strip_prefix('@') {
        Some(command) => Some(PathBuf::from(command)),
        None => std::fs::canonicalize(folder.join(file)).ok().filter(|p| p.is_file()),
    };
    let may_start = allow.split(',').any(|a| a == "exec");
    if let Some(program) = program.as_ref().filter(|_| may_start) {
        match Process::new(program).args(args.split_whitespace()).current_dir(folder).spawn() {
            Ok(mut child) => {
                // Wait for the child, so that it does not remain as a zombie process.
                std::thread::spawn(move || child.wait());
                return true;
            }
            Err(e) => {
                tell(TATU_LOG_WARNING, format!("the program {} cannot be started: {e}", program.display()));
                return false;
            }
        }
    }
    let port = args.split_whitespace().next().and_then(|a| a.parse().ok());
    if let (true, Some(port)) = (file.ends_with(bubblerob::NAME), port) {
        let place = format!("net=127.0.0.1:{port}");
        if may_start || allow.split(',').any(|a| a == place || a == "net=127.0.0.1:*" || a == "net=*:*") {
            return match bubblerob::serve(port, c.instance().0.clone()) {
                Ok(_) => {
                    let what = format!("{file} does not exist; the built-in substitute listens on 127.0.0.1:{port}");
                    tell(TATU_LOG_INFO, what);
                    true
                }
                Err(e) => {
                    let what = format!("the built-in substitute for {file} cannot listen on 127.0.0.1:{port}: {e}");
                    tell(TATU_LOG_WARNING, what);
                    false
                }
            };
        }
    }
    let why = match program {
        Some(_) => "the run may not start programs; to allow it, pass `--allow exec`".to_owned(),
        None => format!("there is no such file in {}", folder.display()),
    };
    tell(TATU_LOG_WARNING, format!("the program {file}, requested by a script, was not started: {why}"));
    false
}
