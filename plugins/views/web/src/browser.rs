//! Passes the address of the page to a browser. The address contains the token that grants control, so it must not
//! appear in the arguments of a process, which every user of the machine can read. Instead, the browser opens a file
//! that redirects to the address and that only its owner can read.

use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
    process::{Command, Stdio},
};

use tatu_services_common::tokens::random_token;

/// The temporary folder with the redirecting file. Both are removed when this value is dropped.
pub(crate) struct BrowserRedirect(PathBuf);

impl BrowserRedirect {
    /// Writes the file and opens it in the user's browser.
    pub(crate) fn open_browser(url: &str) -> io::Result<Self> {
        let folder = folder()?;
        let opened = BrowserRedirect(folder);
        let file = opened.0.join("open.html");
        let mut options = fs::File::options();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let page = format!("<!doctype html><title>Tatu</title><meta http-equiv=\"refresh\" content=\"0;url={url}\">\n");
        options.open(&file)?.write_all(page.as_bytes())?;
        Command::new("xdg-open").arg(&file).stdin(Stdio::null()).stdout(Stdio::null()).spawn()?;
        Ok(opened)
    }
}

impl Drop for BrowserRedirect {
    fn drop(&mut self) {
        // The system may have removed the folder already.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Creates a folder that only the user can access. It is in the runtime directory of the login session if there is one,
/// otherwise in the temporary directory.
fn folder() -> io::Result<PathBuf> {
    let place = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|p| p.is_dir());
    let name = random_token().map(|t| format!("tatu-{t}"))?;
    let folder = place.unwrap_or_else(std::env::temp_dir).join(name);
    #[cfg_attr(not(unix), expect(unused_mut, reason = "the mode exists only on Unix"))]
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(&folder)?;
    Ok(folder)
}
