//! Tests of a page whose program is restarted.

use std::{
    io::{Read, Write},
    net::TcpListener,
    path::Path,
    process::Command,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use serde_json::Value;

use super::program::PageServer;
use crate::kit::{
    browser::{BrowserPage, browser},
    *,
};

const SCENE: &str = "scenes/first/pioneer_avoids_walls.toml";

/// Returns a port that is currently free.
fn free_port() -> u16 {
    TcpListener::bind(("127.0.0.1", 0)).unwrap().local_addr().unwrap().port()
}

fn served(port: u16, state: &Path) -> PageServer {
    PageServer::with_state(root(), &["open", SCENE, "--no-browser", "--port", &port.to_string()], state)
}

/// Returns the description that the program sends to any client.
fn about(served: &PageServer) -> Value {
    let answer = served.ask(&format!("GET /tatu HTTP/1.1\r\nHost: {}\r\n\r\n", served.host()));
    serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap()
}

/// A server other than Tatu, which listens on a port.
struct ForeignServer(Arc<AtomicBool>, Option<std::thread::JoinHandle<()>>);

impl ForeignServer {
    fn new(port: u16) -> ForeignServer {
        let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
        listener.set_nonblocking(true).unwrap();
        let end = Arc::new(AtomicBool::new(false));
        let ended = end.clone();
        let thread = std::thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                let Ok((mut stream, _)) = listener.accept() else {
                    std::thread::sleep(Duration::from_millis(10));
                    continue;
                };
                let _ = stream.set_nonblocking(false);
                let _ = stream.set_read_timeout(Some(Duration::from_millis(500)));
                let _ = stream.read(&mut [0; 4096]);
                let _ = stream.write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\nConnection: close\r\n\r\nhello");
            }
        });
        ForeignServer(end, Some(thread))
    }
}

impl Drop for ForeignServer {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        let _ = self.1.take().map(std::thread::JoinHandle::join);
    }
}

#[test]
fn the_address_of_a_fixed_port_remains() {
    let state = tempfile::tempdir().unwrap();
    let port = free_port();
    let first = served(port, state.path());
    let (url, told) = (first.url.clone(), about(&first));
    assert_eq!((&told["name"], &told["service"]), (&"tatu".into(), &"web".into()));
    assert!(!told.to_string().contains(first.token()));
    let elsewhere = first.ask("GET /tatu HTTP/1.1\r\nHost: elsewhere.org\r\n\r\n");
    assert!(elsewhere.starts_with("HTTP/1.1 421"), "{elsewhere}");
    drop(first);
    let second = served(port, state.path());
    assert_eq!(second.url, url);
    assert_ne!(about(&second)["instance"], told["instance"]);
    drop(second);
    // If the port is not specified, each program has a new token.
    let any = || served(0, state.path()).token().to_owned();
    assert_ne!(any(), any());
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let file = state.path().join(format!("tatu/port-{port}.tokens"));
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        std::fs::set_permissions(&file, PermissionsExt::from_mode(0o644)).unwrap();
        assert_ne!(served(port, state.path()).url, url, "a token that others can read is reused");
    }
}

#[cfg(unix)]
#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_page_reconnects_by_itself() {
    let state = tempfile::tempdir().unwrap();
    let port = free_port();
    let first = served(port, state.path());
    let mut page = BrowserPage::open(&browser(), &first.url);
    page.until("document.querySelectorAll('#tree .item').length > 1");
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
    page.js("window.mark = 'not reloaded'");
    page.click("#tree .tool");
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise = 3.0')");
    page.js("(async () => { const { EditorView } = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         const at = v.state.doc.toString().indexOf('cruise = 3.0') + 9; \
         v.dispatch({ changes: { from: at, to: at + 3, insert: '1.0' } }); })()");

    // A call that was sent but not answered fails.
    succeed(Command::new("kill").args(["-STOP", &first.process.id().to_string()]));
    page.js("import('tatu/net/connection').then((m) => { m.call('tatu.list').catch((e) => { window.refused = e.error; }); })");
    drop(first);
    page.until("(window.refused ?? '').includes('the connection was lost before the program answered `tatu.list`')");
    let says = |text: &str| {
        format!(
            "(() => {{ const b = document.getElementById('lost'); return !b.hidden && b.textContent.includes({text:?}); }})()"
        )
    };
    page.until(&says(&format!("No program answers at 127.0.0.1:{port}")));
    let at_once = "import('tatu/net/connection').then((m) => m.call('tatu.list')).catch((e) => e.error)";
    assert_eq!(page.js(at_once), "`tatu.list` was not done: there is no connection to the program");

    let other = ForeignServer::new(port);
    page.until(&says("Another program answers"));
    drop(other);

    let second = served(port, state.path());
    page.until("document.getElementById('lost').hidden");
    page.until("document.querySelectorAll('#tree .item').length > 1");
    assert_eq!(page.js("window.mark"), "not reloaded");
    // The text in the editor is retained, and is saved to the new program.
    assert!(page.text(".cm-content").contains("cruise = 1.0"));
    page.click("#script-save");
    page.until("document.getElementById('output').textContent.includes('the new text is in the scene')");
    page.click("#play");
    page.until("document.getElementById('play').className === 'on'");
    page.until("!document.getElementById('time').textContent.startsWith('00:00:00.00')");

    // A program with other tokens refuses the page.
    drop(second);
    let apart = tempfile::tempdir().unwrap();
    let _third = served(port, apart.path());
    page.until(&says("this address is old"));
}
