//! Malformed and damaged contents of files.

/// Returns malformed contents of files, with descriptions. `heads` are beginnings that the importer recognizes.
pub fn malformed(heads: &[Vec<u8>]) -> Vec<(String, Vec<u8>)> {
    let mut out: Vec<(String, Vec<u8>)> = vec![
        ("an empty file".into(), Vec::new()),
        ("64 zero bytes".into(), vec![0; 64]),
        ("4 KB of 0xff".into(), vec![0xff; 4096]),
        ("a line of text".into(), b"not a file of this format\n".to_vec()),
        ("numbers".into(), b"1 2 3\n-1e999 nan 4\n".to_vec()),
        ("brackets 10,000 deep".into(), vec![b'['; 10_000]),
        ("tags".into(), b"<?xml version=\"1.0\"?><a><b></a>".to_vec()),
        ("an object in JSON".into(), b"{\"a\": [1, {\"b\": null}]}".to_vec()),
        ("a line of 1 MB".into(), vec![b'x'; 1 << 20]),
    ];
    let noise =
        |n: u64| (0..n).map(|i| (i.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1) >> 56) as u8).collect();
    out.push(("random bytes".into(), noise(5000)));
    for head in heads.iter().take(4) {
        let name = String::from_utf8_lossy(head).into_owned();
        for rest in
            ["", "\n", "\nx", "\n1 2", "\n1 2 3\n1 2 x\n", "\n\0\n", " 99999999999999999999\n", "\n-1 nan inf\n"]
        {
            out.push((format!("a file that begins with `{name}` and is malformed"), [head, rest.as_bytes()].concat()));
        }
    }
    out
}

/// Maximum number of positions of a sample that are damaged, and of its lines and numbers.
const MAX_POSITIONS: usize = 48;
const MAX_PARTS: usize = 12;

/// Numbers that take the place of those of a sample.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "nan",
    "inf",
    "1e999",
    "-1e308",
    "4294967295",
    "99999999999999999999",
    "2147483648",
    "1e-320",
    "0x10",
    "",
];

/// Returns a valid sample with damages: truncated, with changed bytes, lines and numbers, and with repeated parts.
pub fn damaged(sample: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut out = Vec::new();
    let n = sample.len();
    let step = (n / MAX_POSITIONS).max(1);
    for at in (0..n).step_by(step) {
        out.push((format!("the first {at} bytes of a sample"), sample[..at].to_vec()));
        for (how, change) in [("a bit", 0x15u8), ("the highest bit", 0x80)] {
            let mut changed = sample.to_vec();
            changed[at] ^= change;
            out.push((format!("a sample with {how} of byte {at} changed"), changed));
        }
        let mut changed = sample.to_vec();
        changed[at] = 0;
        out.push((format!("a sample whose byte {at} is 0"), changed));
        let mut changed = sample.to_vec();
        changed.remove(at);
        out.push((format!("a sample without its byte {at}"), changed));
    }
    if let Some((_, start)) = n.checked_sub(1).map(|last| (last, &sample[..last])) {
        out.push(("a sample without its last byte".into(), start.to_vec()));
    }
    let lines: Vec<&[u8]> = sample.split_inclusive(|b| *b == b'\n').collect();
    for k in 0..lines.len().min(MAX_PARTS) {
        let without = [&lines[..k], &lines[k + 1..]].concat().concat();
        out.push((format!("a sample without its line {}", k + 1), without));
        let mut twice = lines.clone();
        twice.insert(k, lines[k]);
        out.push((format!("a sample with its line {} twice", k + 1), twice.concat()));
        let long = [&lines[..k].concat(), vec![b'7'; 70_000].as_slice(), &lines[k..].concat()].concat();
        out.push((format!("a sample with 70,000 digits before its line {}", k + 1), long));
    }
    for range in numbers(sample).into_iter().take(MAX_PARTS) {
        for number in NUMBERS {
            let changed = [&sample[..range.start], number.as_bytes(), &sample[range.end..]].concat();
            out.push((format!("a sample with `{number}` as the number at byte {}", range.start), changed));
        }
    }
    let crlf = sample.iter().flat_map(|b| if *b == b'\n' { vec![b'\r', b'\n'] } else { vec![*b] }).collect();
    out.push(("a sample with other ends of lines".into(), crlf));
    out.push(("a sample followed by 100 bytes of 0xff".into(), [sample, &[0xff; 100]].concat()));
    out.push(("a sample repeated 50 times".into(), sample.repeat(50)));
    out
}

/// Returns the ranges of the numbers in a text.
fn numbers(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let is_part = |b: u8| b.is_ascii_digit() || b == b'.' || b == b'-';
    let mut out: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, b) in text.iter().enumerate() {
        match out.last_mut() {
            Some(range) if range.end == i && is_part(*b) => range.end += 1,
            _ if b.is_ascii_digit() || *b == b'-' => out.push(i..i + 1),
            _ => {}
        }
    }
    out.retain(|r| text[r.clone()].iter().any(u8::is_ascii_digit));
    out
}
