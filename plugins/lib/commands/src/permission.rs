//! Addresses that the user allows a run to access, with `--allow net=HOST:PORT`.

use std::net::SocketAddr;

/// Returns whether access to `at` is allowed; `host` is the host name in the script. In `allowed`, `*` matches any host
/// or port.
pub fn allows(allowed: &str, host: &str, at: SocketAddr) -> bool {
    allowed_addresses(allowed).any(|(h, p)| {
        let host = h == "*" || h == host || h == at.ip().to_string();
        host && (p == "*" || p.parse() == Ok(at.port()))
    })
}

/// Returns whether access to sockets that are files is allowed: by `net=ipc:*`, or for any host by `net=*:*`.
pub fn allows_ipc(allowed: &str) -> bool {
    allowed_addresses(allowed).any(|(h, p)| matches!(h, "*" | "ipc") && p == "*")
}

/// Returns whether any address is allowed.
pub fn allows_any(allowed: &str) -> bool {
    allowed_addresses(allowed).next().is_some()
}

fn allowed_addresses(allowed: &str) -> impl Iterator<Item = (&str, &str)> {
    allowed.split(',').filter_map(|a| a.strip_prefix("net=")).filter_map(|place| place.rsplit_once(':'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn access_is_limited_to_allowed_hosts_and_ports() {
        let at: SocketAddr = "127.0.0.1:20000".parse().unwrap();
        for (allowed, host, expected) in [
            ("", "127.0.0.1", false),
            ("exec", "127.0.0.1", false),
            ("exec,net=127.0.0.1:20000", "127.0.0.1", true),
            ("net=127.0.0.1:*", "localhost", true),
            ("net=localhost:*", "localhost", true),
            ("net=localhost:*", "127.0.0.1", false),
            ("net=*:20000", "robot.example", true),
            ("net=127.0.0.1:20001", "127.0.0.1", false),
            ("net=127.0.0.1", "127.0.0.1", false),
        ] {
            assert_eq!(allows(allowed, host, at), expected, "{allowed} {host}");
        }
        assert!(allows_any("exec,net=a:1") && !allows_any("exec"));
        assert!(allows_ipc("net=a:1,net=ipc:*") && allows_ipc("net=*:*"));
        assert!(!allows_ipc("net=127.0.0.1:*") && !allows_ipc("net=ipc:1"));
    }
}
