use super::*;

fn socket(kind: Kind, peers: u64) -> SocketState {
    let mut socket = SocketState::new(kind, &QueuedBytes::default());
    for _ in 0..peers {
        let number = socket.add_peer();
        assert!(socket.peer_is_ready(number, Vec::new()));
    }
    socket
}

fn sent(socket: &mut SocketState, number: u64) -> Option<Message> {
    socket.peers.get_mut(&number).unwrap().outgoing.pop()
}

fn message(parts: &[&str]) -> Message {
    parts.iter().map(|part| part.as_bytes().to_vec()).collect()
}

#[test]
fn request_alternates_between_sending_and_receiving() {
    let mut socket = socket(Kind::Request, 1);
    assert_eq!(socket.receive(), Err(Errno::STATE));
    socket.send(b"a", false).unwrap();
    assert_eq!(sent(&mut socket, 1), Some(message(&["", "a"])));
    assert_eq!(socket.send(b"b", false), Err(Errno::STATE));
    assert_eq!(socket.receive(), Err(Errno::WOULD_BLOCK));
    socket.deposit(1, message(&["no delimiter"]));
    socket.deposit(1, message(&["", "1", "2"]));
    assert_eq!((socket.receive(), socket.more), (Ok(b"1".to_vec()), true));
    assert_eq!((socket.receive(), socket.more), (Ok(b"2".to_vec()), false));
    socket.send(b"b", false).unwrap();
    socket.options.relaxed = 1;
    socket.send(b"c", false).unwrap();
}

#[test]
fn reply_returns_the_envelope_to_its_sender() {
    let mut socket = socket(Kind::Reply, 2);
    assert_eq!(socket.send(b"x", false), Err(Errno::STATE));
    socket.deposit(2, message(&["client", "", "question"]));
    socket.deposit(1, message(&["", "other"]));
    let first = socket.receive().unwrap();
    assert_eq!(socket.receive(), Err(Errno::STATE));
    socket.send(b"answer", false).unwrap();
    assert_eq!(first, b"other");
    assert_eq!(sent(&mut socket, 1), Some(message(&["", "answer"])));
    assert_eq!(socket.receive().unwrap(), b"question");
    socket.send(b"one", true).unwrap();
    socket.send(b"two", false).unwrap();
    assert_eq!(sent(&mut socket, 2), Some(message(&["client", "", "one", "two"])));
}

#[test]
fn publisher_sends_to_matching_subscribers_only() {
    let mut socket = socket(Kind::Publish, 2);
    socket.deposit(1, message(&["\x01a"]));
    socket.deposit(2, message(&["\x01"]));
    socket.send(b"b", false).unwrap();
    socket.send(b"ab", false).unwrap();
    assert_eq!(sent(&mut socket, 1), Some(message(&["ab"])));
    assert_eq!((sent(&mut socket, 2), sent(&mut socket, 2)), (Some(message(&["b"])), Some(message(&["ab"]))));
    socket.deposit(2, message(&["\0"]));
    socket.send(b"b", false).unwrap();
    assert_eq!((sent(&mut socket, 2), socket.receive()), (None, Err(Errno::UNSUPPORTED)));
}

#[test]
fn subscriber_announces_its_topics_and_filters() {
    let mut socket = socket(Kind::Subscribe, 1);
    socket.subscribe(b"a").unwrap();
    assert_eq!(sent(&mut socket, 1), Some(message(&["\x01a"])));
    socket.deposit(1, message(&["b"]));
    socket.deposit(1, message(&["abc"]));
    assert_eq!(socket.receive().unwrap(), b"abc");
    assert_eq!(socket.receive(), Err(Errno::WOULD_BLOCK));
    // A peer that connects later, or reconnects, receives all subscriptions.
    let late = socket.add_peer();
    assert!(socket.peer_is_ready(late, Vec::new()));
    assert_eq!(sent(&mut socket, late), Some(message(&["\x01a"])));
    assert_eq!(socket.unsubscribe(b"b"), Err(Errno::INVALID));
    socket.unsubscribe(b"a").unwrap();
    assert_eq!((sent(&mut socket, 1), socket.send(b"", false)), (Some(message(&["\0a"])), Err(Errno::UNSUPPORTED)));
}

#[test]
fn push_serves_peers_in_turn_and_stops_at_full_queues() {
    let mut socket = socket(Kind::Push, 2);
    socket.options.set(23, &1_i32.to_le_bytes()).unwrap();
    for text in ["1", "2"] {
        socket.send(text.as_bytes(), false).unwrap();
    }
    assert!(!socket.can_send());
    socket.send(b"first", true).unwrap();
    assert_eq!(socket.send(b"last", false), Err(Errno::WOULD_BLOCK));
    assert_eq!((sent(&mut socket, 1), sent(&mut socket, 2)), (Some(message(&["1"])), Some(message(&["2"]))));
    socket.send(b"last", false).unwrap();
    assert_eq!(sent(&mut socket, 1), Some(message(&["first", "last"])));
    // Without a peer, nothing can be sent.
    assert_eq!(self::socket(Kind::Push, 0).send(b"", false), Err(Errno::WOULD_BLOCK));
}

#[test]
fn router_addresses_peers_by_identity() {
    let mut socket = socket(Kind::Router, 0);
    let (a, b) = (socket.add_peer(), socket.add_peer());
    assert!(socket.peer_is_ready(a, b"a".to_vec()));
    assert!(!socket.peer_is_ready(b, b"a".to_vec()), "an identity was accepted twice");
    assert!(socket.peer_is_ready(b, Vec::new()));
    socket.deposit(b, message(&["hello"]));
    assert_eq!(socket.receive().unwrap(), [0, 0, 0, 0, 2]);
    assert_eq!(socket.receive().unwrap(), b"hello");
    socket.send(b"a", true).unwrap();
    socket.send(b"x", false).unwrap();
    assert_eq!(sent(&mut socket, a), Some(message(&["x"])));
    socket.send(b"nobody", true).unwrap();
    socket.send(b"lost", false).unwrap();
    socket.options.router_mandatory = 1;
    socket.send(b"nobody", true).unwrap();
    assert_eq!(socket.send(b"lost", false), Err(Errno::UNREACHABLE));
}

#[test]
fn pull_receives_from_peers_in_turn() {
    let mut socket = socket(Kind::Pull, 2);
    for text in ["1", "2"] {
        socket.deposit(1, message(&[text]));
    }
    socket.deposit(2, message(&["3"]));
    let order: Vec<_> = (0..3).map(|_| socket.receive().unwrap()).collect();
    assert_eq!(order, [b"1", b"3", b"2"]);
    assert!(!socket.can_receive());
}

#[test]
fn oversized_messages_are_refused() {
    let mut socket = socket(Kind::Push, 1);
    let half = vec![0; MAX_MESSAGE_BYTES / 2 + 1];
    socket.send(&half, true).unwrap();
    assert_eq!(socket.send(&half, false), Err(Errno::TOO_LONG));
    for _ in 0..MAX_PARTS {
        socket.send(b"", true).unwrap();
    }
    assert_eq!(socket.send(b"", false), Err(Errno::TOO_LONG));
    assert_eq!(sent(&mut socket, 1), None);
}
