//! Parses and validates values of the command line.

use std::path::PathBuf;

use clap::builder::{OsStringValueParser, TypedValueParser};

/// Returns a parser for a scene: a file, or the name of a scene that comes with the program. A packed scene is unpacked.
pub fn scene() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|given| tatu_embed::search::scene_file(&PathBuf::from(given)))
}

/// A point X, Y, Z in the world frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldPoint(pub [f64; 3]);

pub fn speed(text: &str) -> Result<f64, String> {
    let f = text.parse().ok().filter(|f: &f64| *f > 0.0 && f.is_finite());
    f.ok_or_else(|| "expected a finite number above 0, as a multiple of real time".into())
}

pub fn point(text: &str) -> Result<WorldPoint, String> {
    let number = |x: &str| x.trim().parse().ok().filter(|x: &f64| x.is_finite() && x.abs() <= 1e6);
    let all: Option<Vec<f64>> = text.split(',').map(number).collect();
    all.and_then(|v| v.try_into().ok())
        .map(WorldPoint)
        .ok_or_else(|| "expected three numbers X,Y,Z in m, such as -3,0,1".into())
}

pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |x: &str| x.parse().ok().filter(|n: &u32| (1..=MAX_SIDE).contains(n));
    let found = text.split_once(['x', 'X']).and_then(|(c, r)| Some([side(c)?, side(r)?]));
    found.ok_or_else(|| format!("expected columns and rows, from 1 to {MAX_SIDE} each, such as 1280x720"))
}

/// Maximum width and height of a picture, pixels.
const MAX_SIDE: u32 = 8192;

pub fn angle(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|x: &f64| (1.0..=170.0).contains(x));
    found.ok_or_else(|| "expected an angle from 1 to 170 degrees".into())
}

pub fn seconds(text: &str) -> Result<f64, String> {
    let s: f64 = text.parse().map_err(|_| "expected a number of seconds, at least 0".to_owned())?;
    if s.is_finite() && s >= 0.0 { Ok(s) } else { Err("expected a number of seconds, at least 0".into()) }
}

/// Parses the length of a run, s; `inf` means until it is stopped.
pub fn length(text: &str) -> Result<f64, String> {
    match text {
        "inf" => Ok(f64::INFINITY),
        _ => seconds(text).map_err(|e| e + ", or `inf`"),
    }
}

/// Validates a value of `--allow`.
pub fn permission(text: &str) -> Result<String, String> {
    let (host, port) = text.strip_prefix("net=").and_then(|p| p.rsplit_once(':')).unwrap_or_default();
    let net = !host.is_empty() && (port == "*" || port.parse::<u16>().is_ok());
    // Which words exist depends on the plugins, so they are checked when the scene is loaded.
    let word = text.starts_with(|c: char| c.is_ascii_lowercase())
        && text != "net"
        && text.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    match word || net {
        true => Ok(text.to_owned()),
        false => {
            Err("expected `exec`, `native`, `plugins`, the word of a script language, or `net=HOST:PORT`, such as \
                      `net=127.0.0.1:*`"
                .into())
        }
    }
}

/// Parses a shard `I/N`: its index, counted from 0, and the number of shards.
pub fn shard(text: &str) -> Result<(usize, usize), String> {
    let both = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    both.filter(|(i, n): &(usize, usize)| i < n)
        .ok_or_else(|| "expected I/N with I from 0 to N - 1, such as 0/4, 1/4, 2/4 or 3/4".into())
}
