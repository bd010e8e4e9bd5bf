//! Decoder for a static Huffman code, whose tree precedes the data.

use super::cursor::{ReadError, ReadResult};

/// Number of bits that a table lookup decodes.
const LOOKUP_BITS: u32 = 11;
/// Maximum number of nodes of a tree: inner nodes and leaves for 256 bytes.
const MAX_NODES: usize = 511;

/// A node: its two branches; a leaf is stored as `LEAF_FLAG + byte`.
type HuffmanNode = [u16; 2];
const LEAF_FLAG: u16 = 0x8000;

/// Reads bits, most significant first.
struct BitReader<'a> {
    data: &'a [u8],
    /// Index of the byte to load next.
    next: usize,
    /// Loaded bits, left-aligned.
    held: u64,
    /// Number of loaded bits.
    count: u32,
}

impl BitReader<'_> {
    /// Loads whole bytes while there is room; beyond the end, loads zeros, which are not counted.
    fn fill(&mut self) {
        while self.count <= 56 {
            let Some(byte) = self.data.get(self.next) else { return };
            self.held |= u64::from(*byte) << (56 - self.count);
            self.count += 8;
            self.next += 1;
        }
    }
    fn bits(&mut self, n: u32) -> Option<u32> {
        self.fill();
        if self.count < n {
            return None;
        }
        let out = (self.held >> (64 - n)) as u32;
        self.skip(n);
        Some(out)
    }
    fn skip(&mut self, n: u32) {
        self.held <<= n;
        self.count -= n;
    }
}

/// Reads the tree; returns its inner nodes and its root, which is the index of a node, or a leaf.
fn tree(bits: &mut BitReader<'_>) -> Option<(Vec<HuffmanNode>, u16)> {
    let mut nodes: Vec<HuffmanNode> = Vec::new();
    // The branches to fill, as node and side. The stack is explicit, so that deep trees cannot overflow the call stack.
    let mut open: Vec<(usize, usize)> = Vec::new();
    let mut root = None;
    let mut seen = 0;
    loop {
        seen += 1;
        if seen > MAX_NODES {
            return None;
        }
        let made = match bits.bits(1)? {
            1 => LEAF_FLAG + bits.bits(8)? as u16,
            _ => {
                nodes.push([0; 2]);
                (nodes.len() - 1) as u16
            }
        };
        match open.pop() {
            Some((node, side)) => nodes[node][side] = made,
            None => root = Some(made),
        }
        if made & LEAF_FLAG == 0 {
            open.push((made.into(), 1));
            open.push((made.into(), 0));
        }
        if open.is_empty() {
            return Some((nodes, root?));
        }
    }
}

/// Builds the lookup table: for each value of `LOOKUP_BITS` bits, a leaf and the length of its code, or the inner node
/// from which to continue.
fn table(nodes: &[HuffmanNode], root: u16) -> Vec<(u16, u8)> {
    (0..1_u32 << LOOKUP_BITS)
        .map(|code| {
            let (mut at, mut used) = (root, 0);
            while at & LEAF_FLAG == 0 && used < LOOKUP_BITS {
                at = nodes[usize::from(at)][(code >> (LOOKUP_BITS - 1 - used) & 1) as usize];
                used += 1;
            }
            (at, used as u8)
        })
        .collect()
}

/// Unpacks exactly `size` bytes. The caller must have checked that the data can contain that many bytes.
pub fn unpack(packed: &[u8], size: usize) -> ReadResult<Vec<u8>> {
    let mut bits = BitReader { data: packed, next: 0, held: 0, count: 0 };
    let broken = |at: usize, what: &str| ReadError::new(at, what).within("packed data");
    let (nodes, root) = tree(&mut bits).ok_or_else(|| broken(0, "the Huffman tree is damaged"))?;
    let mut out = Vec::with_capacity(size);
    if root & LEAF_FLAG != 0 {
        out.resize(size, root as u8);
        return Ok(out);
    }
    let table = table(&nodes, root);
    while out.len() < size {
        bits.fill();
        let (mut at, used) = table[(bits.held >> (64 - LOOKUP_BITS)) as usize];
        let mut used = u32::from(used);
        if at & LEAF_FLAG == 0 {
            // Decode the rest of a long code bit by bit. A code has up to 255 bits, so more bits may have to be loaded.
            if bits.count < used {
                return Err(broken(out.len(), "the packed data ends before all bytes are unpacked"));
            }
            bits.skip(used);
            used = 0;
            while at & LEAF_FLAG == 0 {
                let bit = bits
                    .bits(1)
                    .ok_or_else(|| broken(out.len(), "the packed data ends before all bytes are unpacked"))?;
                at = nodes[usize::from(at)][bit as usize];
            }
        }
        if bits.count < used {
            return Err(broken(out.len(), "the packed data ends before all bytes are unpacked"));
        }
        bits.skip(used);
        out.push(at as u8);
    }
    Ok(out)
}

/// Packs data in the format that `unpack` reads; for tests, which build their own files.
#[cfg(test)]
pub fn pack(data: &[u8]) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    let push = |bits: &mut Vec<bool>, value: u32, n: u32| (0..n).rev().for_each(|i| bits.push(value >> i & 1 == 1));
    // A complete tree of 256 leaves is valid for any data.
    fn node(bits: &mut Vec<bool>, from: u32, n: u32) {
        bits.push(n == 1);
        if n == 1 {
            (0..8).rev().for_each(|i| bits.push(from >> i & 1 == 1));
        } else {
            node(bits, from, n / 2);
            node(bits, from + n / 2, n / 2);
        }
    }
    node(&mut bits, 0, 256);
    data.iter().for_each(|b| push(&mut bits, u32::from(*b), 8));
    bits.chunks(8).map(|c| c.iter().enumerate().fold(0, |byte, (i, b)| byte | u8::from(*b) << (7 - i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huffman_test_vector_is_unpacked() {
        let packed = [0x28, 0xB5, 0x05, 0x4A, 0xAD, 0xC3, 0xC0];
        assert_eq!(unpack(&packed, 6).unwrap(), b"VREPVR");
        assert!(unpack(&packed, 20).unwrap_err().what.contains("ends before all bytes"));
        for n in 0..packed.len() {
            assert!(unpack(&packed[..n], 6).is_err(), "cut at {n}");
        }
    }

    #[test]
    fn packed_data_is_unpacked_unchanged() {
        let data: Vec<u8> = (0..5000_u32).map(|i| (i * i / 7) as u8).collect();
        assert_eq!(unpack(&pack(&data), data.len()).unwrap(), data);
    }

    #[test]
    fn codes_longer_than_the_lookup_table_are_decoded() {
        // In this degenerate tree, the code of byte n has n + 1 bits; the longest code has 20 bits.
        let mut bits = String::new();
        for n in 0..20_u8 {
            bits += &format!("01{n:08b}");
        }
        bits += "100010100";
        for n in [19, 0, 20, 7] {
            bits += &match n {
                20 => "1".repeat(20),
                n => "1".repeat(n) + "0",
            };
        }
        let bits: Vec<u8> = bits.bytes().map(|b| b - b'0').collect();
        let bytes: Vec<u8> =
            bits.chunks(8).map(|c| c.iter().enumerate().fold(0, |x, (i, b)| x | b << (7 - i))).collect();
        assert_eq!(unpack(&bytes, 4).unwrap(), [19, 0, 20, 7]);
    }
}
