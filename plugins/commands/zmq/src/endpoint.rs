//! Endpoints: TCP ports and Unix domain sockets, on this machine only.

use std::{
    net::{Ipv4Addr, SocketAddr},
    path::PathBuf,
};

use tatu_commands_common::permission;

use crate::errors::Errno;

/// The address of a socket.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Endpoint {
    /// A TCP port on a loopback address.
    Tcp(SocketAddr),
    /// A Unix domain socket, by the path of its file.
    Ipc(PathBuf),
}

/// Why an endpoint cannot be used.
#[derive(Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The call returns -1, with this error number.
    Error(Errno),
    /// The run is not permitted to use the endpoint. The values are the error message and advice.
    Denied(String, String),
}

impl From<Errno> for Refusal {
    fn from(errno: Errno) -> Self {
        Refusal::Error(errno)
    }
}

const LOCAL_ONLY: &str = "use tcp://127.0.0.1:PORT or ipc://FILE; a program on another machine can be reached through a tunnel, such as that of ssh -L";

/// Parses an endpoint, and checks that `allowed`, the permissions of the run, include it. If `bind` is set, a socket
/// will be bound to the endpoint; `*` then stands for this machine as the host, and for any free port as the port.
pub fn open(text: &str, bind: bool, allowed: &str) -> Result<Endpoint, Refusal> {
    let (protocol, address) = text.split_once("://").ok_or(Errno::INVALID)?;
    match protocol {
        "tcp" => tcp(text, address, bind, allowed),
        "ipc" if address.is_empty() || address.starts_with('@') || address == "*" || address.contains('\0') => {
            Err(Errno::INVALID.into())
        }
        "ipc" if permission::allows_ipc(allowed) => Ok(Endpoint::Ipc(address.into())),
        "ipc" => Err(denied(text, "ipc:*")),
        _ => Err(Errno::NO_PROTOCOL.into()),
    }
}

fn tcp(text: &str, address: &str, bind: bool, allowed: &str) -> Result<Endpoint, Refusal> {
    let (host, port) = address.rsplit_once(':').ok_or(Errno::INVALID)?;
    let port = match port {
        "*" if bind => 0,
        _ => port.parse::<u16>().ok().filter(|port| bind || *port != 0).ok_or(Errno::INVALID)?,
    };
    if host.is_empty() || host.contains(['/', ';']) {
        return Err(Errno::INVALID.into());
    }
    // Scripts for CoppeliaSim usually bind sockets to `*`, although their peers are on the same machine.
    let ip = match host {
        "*" | "0.0.0.0" if bind => Some(Ipv4Addr::LOCALHOST),
        "localhost" => Some(Ipv4Addr::LOCALHOST),
        _ => host.parse().ok().filter(Ipv4Addr::is_loopback),
    };
    let Some(ip) = ip else {
        return Err(Refusal::Denied(
            format!("`{text}` is not an address of this machine; simZMQ supports only local sockets"),
            LOCAL_ONLY.into(),
        ));
    };
    let at = SocketAddr::from((ip, port));
    let host = if host == "*" || host == "0.0.0.0" { "127.0.0.1" } else { host };
    // If any free port may be chosen, a permission for any port suffices.
    let granted = if port == 0 { permission::allows_any(allowed) } else { permission::allows(allowed, host, at) };
    if granted {
        return Ok(Endpoint::Tcp(at));
    }
    Err(denied(text, &format!("127.0.0.1:{}", if port == 0 { "*".to_owned() } else { port.to_string() })))
}

fn denied(text: &str, needs: &str) -> Refusal {
    Refusal::Denied(
        format!("permission denied: this run may not use the socket `{text}`"),
        format!("to allow it, pass `--allow net={needs}`"),
    )
}

impl std::fmt::Display for Endpoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Endpoint::Tcp(at) => write!(f, "tcp://{at}"),
            Endpoint::Ipc(path) => write!(f, "ipc://{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, bind: bool) -> String {
        match open(text, bind, "net=127.0.0.1:*,net=ipc:*") {
            Ok(endpoint) => endpoint.to_string(),
            Err(Refusal::Error(errno)) => errno.text(),
            Err(Refusal::Denied(text, help)) => format!("{text}; {help}"),
        }
    }

    #[test]
    fn endpoints_on_this_machine_are_accepted() {
        for (text, bind, expected) in [
            ("tcp://*:5555", true, "tcp://127.0.0.1:5555"),
            ("tcp://0.0.0.0:*", true, "tcp://127.0.0.1:0"),
            ("tcp://localhost:5555", false, "tcp://127.0.0.1:5555"),
            ("ipc:///run/a", false, "ipc:///run/a"),
            ("tcp://*:5555", false, "is not an address of this machine"),
            ("tcp://192.168.1.2:5555", false, "use tcp://127.0.0.1:PORT"),
            ("tcp://eth0:5555", true, "is not an address of this machine"),
            ("tcp://localhost", false, "Invalid argument"),
            ("tcp://localhost:0", false, "Invalid argument"),
            ("tcp://localhost:70000", false, "Invalid argument"),
            ("tcp://127.0.0.1:1;127.0.0.1:2", false, "Invalid argument"),
            ("localhost:5", false, "Invalid argument"),
            ("ipc://", true, "Invalid argument"),
            ("inproc://a", true, "Protocol not supported"),
            ("udp://127.0.0.1:5", true, "Protocol not supported"),
        ] {
            assert!(shown(text, bind).contains(expected), "{text}: {}", shown(text, bind));
        }
    }

    #[test]
    fn denial_names_the_missing_permission() {
        for (text, allowed, expected) in [
            ("tcp://localhost:5555", "", "--allow net=127.0.0.1:5555"),
            ("tcp://localhost:5555", "net=127.0.0.1:5556", "--allow net=127.0.0.1:5555"),
            ("tcp://*:*", "exec", "--allow net=127.0.0.1:*"),
            ("ipc:///run/a", "net=127.0.0.1:*", "--allow net=ipc:*"),
        ] {
            let Err(Refusal::Denied(_, help)) = open(text, true, allowed) else { panic!("{text} was not denied") };
            assert!(help.contains(expected), "{text}: {help}");
        }
    }
}
