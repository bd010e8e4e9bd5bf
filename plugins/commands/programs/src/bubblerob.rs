//! A substitute for `bubbleRobServer`, the program that steers the robot of V-REP's BubbleRob tutorial.
//!
//! A message is one or more packets: the bytes 59 and 57, two bytes with the length of the data, two with the number of
//! packets that follow, all little-endian, and the data. A request contains the distance that the nose sensor measures
//! (0 if nothing is detected) and the simulation time; the answer contains the velocities of the left and right wheels
//! in rad/s. All values are 32-bit floats. The format and the steering were observed on the socket of
//! CoppeliaRobotics/bubbleRobServer (2025).

use std::{
    io::{self, ErrorKind, Read, Write},
    net::{TcpListener, TcpStream},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// File name of the program as written in scripts.
pub const NAME: &str = "bubbleRobServer";
const HEADER: [u8; 2] = [59, 57];
/// Forward speed of the wheels, rad/s.
const FORWARD_SPEED: f32 = 7.0;
/// Duration of the backward motion after a detection, s.
const BACKWARD_TIME_S: f32 = 3.0;
/// Interval at which the server checks for connections and whether its world still exists.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Listens on `port` of 127.0.0.1 and serves the first client that connects, until `ends` becomes true. Returns the
/// port; the operating system chooses it if `port` is 0.
pub fn serve(port: u16, ends: Arc<AtomicBool>) -> io::Result<u16> {
    let listener = TcpListener::bind(("127.0.0.1", port))?;
    let port = listener.local_addr()?.port();
    listener.set_nonblocking(true)?;
    std::thread::spawn(move || {
        while !ends.load(Ordering::Relaxed) {
            match listener.accept() {
                Ok((stream, _)) => {
                    // Any error closes the connection, which the script can detect.
                    let _ = serve_client(stream, &ends);
                    return;
                }
                Err(_) => std::thread::sleep(POLL_INTERVAL),
            }
        }
    });
    Ok(port)
}

fn serve_client(mut stream: TcpStream, ends: &AtomicBool) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(POLL_INTERVAL))?;
    let mut seen = f32::NEG_INFINITY;
    loop {
        let [distance, time] = read_request(&mut stream, ends)?;
        let speeds = if time - seen < BACKWARD_TIME_S {
            [-0.5 * FORWARD_SPEED, -0.25 * FORWARD_SPEED]
        } else {
            if distance > 0.0 {
                seen = time;
            }
            [FORWARD_SPEED; 2]
        };
        let mut packet = vec![HEADER[0], HEADER[1], 8, 0, 0, 0];
        packet.extend(speeds.iter().flat_map(|v| v.to_le_bytes()));
        stream.write_all(&packet)?;
    }
}

fn read_request(stream: &mut TcpStream, ends: &AtomicBool) -> io::Result<[f32; 2]> {
    let mut data = Vec::new();
    loop {
        let mut header = [0; 6];
        read_full(stream, &mut header, ends)?;
        if header[..2] != HEADER || data.len() > 8 {
            return Err(ErrorKind::InvalidData.into());
        }
        let mut part = vec![0; usize::from(u16::from_le_bytes([header[2], header[3]]))];
        read_full(stream, &mut part, ends)?;
        data.extend(part);
        if header[4..] == [0, 0] {
            break;
        }
    }
    match *data.as_slice() {
        [a, b, c, d, e, f, g, h] => Ok([f32::from_le_bytes([a, b, c, d]), f32::from_le_bytes([e, f, g, h])]),
        _ => Err(ErrorKind::InvalidData.into()),
    }
}

fn read_full(stream: &mut TcpStream, mut room: &mut [u8], ends: &AtomicBool) -> io::Result<()> {
    while !room.is_empty() && !ends.load(Ordering::Relaxed) {
        match stream.read(room) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(n) => room = &mut room[n..],
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(e) => return Err(e),
        }
    }
    if room.is_empty() { Ok(()) } else { Err(ErrorKind::ConnectionAborted.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(text: &str) -> Vec<u8> {
        text.split_whitespace().map(|b| u8::from_str_radix(b, 16).unwrap()).collect()
    }

    /// Compares with bytes that were captured on the socket of the original program.
    #[test]
    fn server_answers_like_the_original_program() {
        let port = serve(0, Arc::default()).unwrap();
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        for (data, expected) in [
            ("00 00 00 00 00 00 00 00", "00 00 e0 40 00 00 e0 40"),
            ("00 00 00 00 cd cc 4c 3d", "00 00 e0 40 00 00 e0 40"),
            ("cd cc cc 3d 00 00 80 3f", "00 00 e0 40 00 00 e0 40"),
            ("cd cc cc 3d 66 66 86 3f", "00 00 60 c0 00 00 e0 bf"),
            ("00 00 00 00 cd cc 7c 40", "00 00 60 c0 00 00 e0 bf"),
            ("00 00 00 00 00 00 80 40", "00 00 e0 40 00 00 e0 40"),
        ] {
            stream.write_all(&hex(&format!("3b 39 08 00 00 00 {data}"))).unwrap();
            let mut answer = [0; 14];
            stream.read_exact(&mut answer).unwrap();
            assert_eq!(answer.to_vec(), hex(&format!("3b 39 08 00 00 00 {expected}")), "{data}");
        }
        // A message can be split into two packets, and can arrive byte by byte.
        for byte in hex("3b 39 04 00 01 00 00 00 00 00 3b 39 04 00 00 00 00 00 a0 40") {
            stream.write_all(&[byte]).unwrap();
        }
        let mut answer = [0; 14];
        stream.read_exact(&mut answer).unwrap();
        assert_eq!(answer[6..].to_vec(), hex("00 00 e0 40 00 00 e0 40"));
        // The server must close the connection on bytes that are not a message.
        stream.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
        assert!(matches!(stream.read(&mut answer), Ok(0) | Err(_)));
    }
}
