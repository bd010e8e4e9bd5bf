use super::*;
use crate::endpoint::open;

const TEST_TIMEOUT: Duration = Duration::from_secs(20);

/// Creates two sockets, of which the first is bound to an endpoint and the second is connected to it.
fn pair(bound: Kind, connected: Kind, endpoint: &str) -> (Socket, Socket) {
    let limits = Limits::default();
    let (mut a, mut b) = (Socket::new(bound, &limits), Socket::new(connected, &limits));
    a.bind(&parsed(endpoint)).unwrap();
    b.connect(&parsed(&a.with(|state| state.last_endpoint.clone()))).unwrap();
    (a, b)
}

fn parsed(endpoint: &str) -> Endpoint {
    open(endpoint, true, "net=*:*").unwrap()
}

fn receive(socket: &Socket) -> Result<Vec<u8>, Errno> {
    socket.wait(TEST_TIMEOUT, SocketState::receive)
}

fn send(socket: &Socket, text: &[u8], more: bool) {
    socket.wait(TEST_TIMEOUT, |state| state.send(text, more)).unwrap();
}

#[test]
fn requests_are_answered_over_tcp_and_files() {
    let file = std::env::temp_dir().join(format!("zmq-links-{}", std::process::id()));
    for endpoint in ["tcp://*:*".to_owned(), format!("ipc://{}", file.display())] {
        let (reply, request) = pair(Kind::Reply, Kind::Request, &endpoint);
        for size in [0, 1, 300, 100_000] {
            send(&request, &vec![1; size], true);
            send(&request, b"end", false);
            assert_eq!(receive(&reply).unwrap(), vec![1; size]);
            assert_eq!(receive(&reply).unwrap(), b"end");
            send(&reply, &vec![2; size], false);
            assert_eq!(receive(&request).unwrap(), vec![2; size]);
        }
    }
    assert!(!file.exists(), "the file of a socket remains");
}

#[test]
fn queued_messages_are_sent_after_close_and_before_a_listener_exists() {
    let limits = Limits::default();
    let mut pull = Socket::new(Kind::Pull, &limits);
    pull.bind(&parsed("tcp://*:*")).unwrap();
    let endpoint = parsed(&pull.with(|state| state.last_endpoint.clone()));
    let mut push = Socket::new(Kind::Push, &limits);
    push.connect(&endpoint).unwrap();
    send(&push, b"last words", false);
    drop(push);
    assert_eq!(receive(&pull).unwrap(), b"last words");
    // The peer reconnects to a new socket that is bound to the same endpoint.
    let mut push = Socket::new(Kind::Push, &limits);
    push.connect(&endpoint).unwrap();
    drop(pull);
    let mut pull = Socket::new(Kind::Pull, &limits);
    pull.bind(&endpoint).unwrap();
    // Some messages may be lost with the old connection.
    let end = Instant::now() + TEST_TIMEOUT;
    while pull.with(|state| !state.can_receive()) && Instant::now() < end {
        let _ = push.with(|state| state.send(b"again", false));
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(receive(&pull).unwrap(), b"again");
}

#[test]
fn incompatible_and_invalid_peers_are_disconnected() {
    use std::io::{Read, Write};
    let (pull, _request) = pair(Kind::Pull, Kind::Request, "tcp://*:*");
    let Endpoint::Tcp(at) = parsed(&pull.with(|state| state.last_endpoint.clone())) else { unreachable!() };
    let mut strange = std::net::TcpStream::connect(at).unwrap();
    strange.write_all(&[b'x'; 64]).unwrap();
    let _ = strange.read_to_end(&mut Vec::new());
    thread::sleep(Duration::from_millis(50));
    assert!(pull.with(|state| state.peers.is_empty()));
}

#[test]
fn number_of_connections_is_limited() {
    let limits = Limits::default();
    let mut push = Socket::new(Kind::Push, &limits);
    let to = parsed("ipc:///nonexistent/socket");
    for _ in 0..MAX_LINKS {
        push.connect(&to).unwrap();
    }
    assert_eq!(push.connect(&to), Err(Errno::TOO_MANY));
    drop(push);
    assert_eq!(limits.links.load(Ordering::Acquire), 0);
}

#[test]
fn replaced_file_of_a_socket_is_left_alone() {
    let file = std::env::temp_dir().join(format!("zmq-replaced-{}", std::process::id()));
    let mut reply = Socket::new(Kind::Reply, &Limits::default());
    reply.bind(&Endpoint::Ipc(file.clone())).unwrap();
    // A file is reported as in use if a socket listens on it, or if it is not a socket at all.
    assert_eq!(reply.bind(&Endpoint::Ipc(file.clone())), Err(Errno::IN_USE));
    // The old file is renamed instead of removed, so that the new file gets a different inode.
    let moved = file.with_extension("moved");
    std::fs::rename(&file, &moved).unwrap();
    std::fs::write(&file, "another").unwrap();
    assert_eq!(reply.bind(&Endpoint::Ipc(file.clone())), Err(Errno::IN_USE));
    drop(reply);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "another");
    std::fs::remove_file(&file).unwrap();
    // A file that was left by a program that has ended is replaced.
    let mut reply = Socket::new(Kind::Reply, &Limits::default());
    reply.bind(&Endpoint::Ipc(moved.clone())).unwrap();
    drop(reply);
    assert!(!moved.exists());
}
