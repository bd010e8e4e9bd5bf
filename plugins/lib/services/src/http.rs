//! Parses the heads of HTTP requests, and writes HTTP responses.

use std::{
    io::{self, Read, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

/// Maximum size of the head of a request, bytes.
const MAX_HEAD_BYTES: usize = 16 << 10;
/// Time within which a client must send the head.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);

/// The head of a request.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HttpRequest {
    /// The method, such as "GET".
    pub method: String,
    /// The path, without the query.
    pub path: String,
    /// The query: everything after the first `?`; empty if there is none.
    pub query: String,
    /// The headers, with names in lower case.
    headers: Vec<(String, String)>,
}

impl HttpRequest {
    /// Returns the value of the header `name`, which must be in lower case.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
    /// Returns the value of the parameter `name` in the query, without percent-decoding.
    pub fn query_value(&self, name: &str) -> Option<&str> {
        self.query.split('&').find_map(|pair| pair.split_once('=').filter(|(n, _)| *n == name)).map(|(_, v)| v)
    }

    /// Reads the head of a request. Fails if the head is too large or does not arrive within `HEAD_TIMEOUT`.
    pub fn read(stream: &mut TcpStream) -> io::Result<HttpRequest> {
        let begin = Instant::now();
        stream.set_read_timeout(Some(Duration::from_millis(500)))?;
        let mut bytes = Vec::new();
        let mut part = [0; 2048];
        loop {
            match stream.read(&mut part) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(n) => bytes.extend_from_slice(&part[..n]),
                Err(e) if matches!(e.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
                Err(e) => return Err(e),
            }
            if let Some(request) = Self::parse(&bytes)? {
                return Ok(request);
            }
            if bytes.len() > MAX_HEAD_BYTES || begin.elapsed() > HEAD_TIMEOUT {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    "the head of the request is longer than 16 KiB, or did not arrive within 5 s",
                ));
            }
        }
    }

    /// Parses a head. Returns `None` if it is incomplete.
    fn parse(bytes: &[u8]) -> io::Result<Option<HttpRequest>> {
        let mut headers = [httparse::EMPTY_HEADER; 64];
        let mut head = httparse::Request::new(&mut headers);
        let wrong = |e: httparse::Error| io::Error::new(io::ErrorKind::InvalidData, e.to_string());
        if head.parse(bytes).map_err(wrong)?.is_partial() {
            return Ok(None);
        }
        let target = head.path.unwrap_or("/");
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let text = |v: &[u8]| String::from_utf8_lossy(v).into_owned();
        Ok(Some(HttpRequest {
            method: head.method.unwrap_or("").to_owned(),
            path: path.to_owned(),
            query: query.to_owned(),
            headers: head.headers.iter().map(|h| (h.name.to_ascii_lowercase(), text(h.value))).collect(),
        }))
    }
}

/// Writes a response with the given status, such as "200 OK". Its header announces that the connection will be closed.
pub fn write_response(stream: &mut TcpStream, status: &str, headers: &[(&str, &str)], body: &[u8]) -> io::Result<()> {
    let mut head = format!("HTTP/1.1 {status}\r\nContent-Length: {}\r\nConnection: close\r\n", body.len());
    for (name, value) in headers {
        head += &format!("{name}: {value}\r\n");
    }
    head += "\r\n";
    stream.set_write_timeout(Some(Duration::from_secs(10)))?;
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn head_is_parsed_only_when_complete() {
        assert_eq!(HttpRequest::parse(b"GET /a?b=c&token=x HTTP/1.1\r\nHost: h").unwrap(), None);
        let r = HttpRequest::parse(b"GET /a?b=c&token=x HTTP/1.1\r\nHost: h\r\n\r\n").unwrap().unwrap();
        assert_eq!((r.path.as_str(), r.query_value("token"), r.header("host")), ("/a", Some("x"), Some("h")));
        assert!(HttpRequest::parse(b"\x00\x01\x02\r\n\r\n").is_err());
    }
}
