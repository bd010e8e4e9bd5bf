//! Lua's pattern matching (after lstrlib.c of Lua 5.4) with a step limit, because a short pattern can take exponential
//! time, and C code does not check the budget.

/// Recursion limit, as in Lua.
const MAX_DEPTH: u32 = 200;
/// Capture limit, as in Lua.
const MAX_CAPTURES: usize = 32;

/// Reason for a failed match attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MatchError {
    /// The pattern is malformed or too complex.
    Pattern(&'static str),
    /// The step limit was reached.
    Steps,
}

#[derive(Clone, Copy)]
enum CaptureLength {
    Open,
    Position,
    Bytes(usize),
}

/// The value of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CaptureValue {
    /// A zero-based position in the subject.
    Position(usize),
    /// A range of the subject.
    Part(usize, usize),
}

/// State of a match. It is plain data without a destructor, because a Lua error may skip destructors.
pub(crate) struct Matcher<'a> {
    src: &'a [u8],
    pat: &'a [u8],
    captures: [(usize, CaptureLength); MAX_CAPTURES],
    level: usize,
    depth: u32,
    /// Number of steps so far, in all matches.
    pub steps: u64,
    max_steps: u64,
}

type MatchResult = Result<Option<usize>, MatchError>;

impl<'a> Matcher<'a> {
    /// Creates a matcher for a pattern without its anchor; `most` is the step limit.
    pub(crate) fn new(src: &'a [u8], pat: &'a [u8], most: u64) -> Self {
        Matcher {
            src,
            pat,
            captures: [(0, CaptureLength::Open); MAX_CAPTURES],
            level: 0,
            depth: 0,
            steps: 0,
            max_steps: most,
        }
    }
    /// Returns the end of the match that begins at `s`.
    pub(crate) fn match_at(&mut self, s: usize) -> MatchResult {
        (self.level, self.depth) = (0, 0);
        self.match_nested(s, 0)
    }
    /// Returns the number of captures. If the pattern has no captures and `whole` is set, the whole match is a capture.
    pub(crate) fn count(&self, whole: bool) -> usize {
        if self.level == 0 && whole { 1 } else { self.level }
    }
    /// Returns a capture of the match from `s` to `e`.
    pub(crate) fn capture(&self, i: usize, s: usize, e: usize) -> Result<CaptureValue, MatchError> {
        if i >= self.level {
            return if i == 0 {
                Ok(CaptureValue::Part(s, e))
            } else {
                Err(MatchError::Pattern("invalid capture index"))
            };
        }
        let (start, length) = self.captures[i];
        match length {
            CaptureLength::Open => Err(MatchError::Pattern("unfinished capture")),
            CaptureLength::Position => Ok(CaptureValue::Position(start)),
            CaptureLength::Bytes(n) => Ok(CaptureValue::Part(start, start + n)),
        }
    }

    /// Returns a byte of the pattern, or 0 at its end.
    fn p(&self, i: usize) -> u8 {
        self.pat.get(i).copied().unwrap_or(0)
    }

    fn match_nested(&mut self, s: usize, p: usize) -> MatchResult {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(MatchError::Pattern("pattern too complex"));
        }
        let found = self.run(s, p);
        self.depth -= 1;
        found
    }

    fn run(&mut self, mut s: usize, mut p: usize) -> MatchResult {
        loop {
            self.step()?;
            if p >= self.pat.len() {
                return Ok(Some(s));
            }
            match (self.p(p), self.p(p + 1)) {
                (b'(', b')') => return self.open(s, p + 2, CaptureLength::Position),
                (b'(', _) => return self.open(s, p + 1, CaptureLength::Open),
                (b')', _) => return self.close(s, p + 1),
                (b'$', _) if p + 1 == self.pat.len() => {
                    return Ok((s == self.src.len()).then_some(s));
                }
                (b'%', b'b') => match self.balance(s, p + 2)? {
                    Some(e) => (s, p) = (e, p + 4),
                    None => return Ok(None),
                },
                (b'%', b'f') => {
                    p += 2;
                    if self.p(p) != b'[' {
                        return Err(MatchError::Pattern("missing '[' after '%f' in pattern"));
                    }
                    let end = self.class_end(p)?;
                    self.class_steps(3 * (end - p))?;
                    let before = if s == 0 { 0 } else { self.src[s - 1] };
                    let here = self.src.get(s).copied().unwrap_or(0);
                    if self.set(before, p, end - 1) || !self.set(here, p, end - 1) {
                        return Ok(None);
                    }
                    p = end;
                }
                (b'%', digit @ b'0'..=b'9') => match self.match_back_reference(s, digit)? {
                    Some(e) => (s, p) = (e, p + 2),
                    None => return Ok(None),
                },
                _ => {
                    let end = self.class_end(p)?;
                    self.class_steps(2 * (end - p))?;
                    let one = self.single(s, p, end);
                    match self.p(end) {
                        b'?' if one => {
                            if let Some(e) = self.match_nested(s + 1, end + 1)? {
                                return Ok(Some(e));
                            }
                            p = end + 1;
                        }
                        b'+' if one => return self.match_greedy(s + 1, p, end),
                        b'*' if one => return self.match_greedy(s, p, end),
                        b'-' if one => return self.match_lazy(s, p, end),
                        b'?' | b'*' | b'-' => p = end + 1,
                        _ if one => (s, p) = (s + 1, end),
                        _ => return Ok(None),
                    }
                }
            }
        }
    }

    fn step(&mut self) -> Result<(), MatchError> {
        self.steps_of(1)
    }

    /// Counts the steps for matching a byte of the subject against a class that occupies `bytes` bytes of the pattern.
    fn class_steps(&mut self, bytes: usize) -> Result<(), MatchError> {
        self.steps_of(bytes as u64 / 4)
    }

    fn steps_of(&mut self, n: u64) -> Result<(), MatchError> {
        self.steps += n;
        if self.steps > self.max_steps {
            return Err(MatchError::Steps);
        }
        Ok(())
    }

    /// Matches a repetition by `*` or `+`, which takes as many characters as possible.
    fn match_greedy(&mut self, s: usize, p: usize, end: usize) -> MatchResult {
        let mut i = 0;
        while self.single(s + i, p, end) {
            self.step()?;
            self.class_steps(end - p)?;
            i += 1;
        }
        loop {
            if let Some(e) = self.match_nested(s + i, end + 1)? {
                return Ok(Some(e));
            }
            if i == 0 {
                return Ok(None);
            }
            i -= 1;
        }
    }

    /// Matches a repetition by `-`, which takes as few characters as possible.
    fn match_lazy(&mut self, mut s: usize, p: usize, end: usize) -> MatchResult {
        loop {
            if let Some(e) = self.match_nested(s, end + 1)? {
                return Ok(Some(e));
            }
            if !self.single(s, p, end) {
                return Ok(None);
            }
            self.class_steps(end - p)?;
            s += 1;
        }
    }

    fn open(&mut self, s: usize, p: usize, length: CaptureLength) -> MatchResult {
        if self.level >= MAX_CAPTURES {
            return Err(MatchError::Pattern("too many captures"));
        }
        self.captures[self.level] = (s, length);
        self.level += 1;
        let found = self.match_nested(s, p)?;
        if found.is_none() {
            self.level -= 1;
        }
        Ok(found)
    }

    fn close(&mut self, s: usize, p: usize) -> MatchResult {
        let open = (0..self.level)
            .rev()
            .find(|i| matches!(self.captures[*i].1, CaptureLength::Open))
            .ok_or(MatchError::Pattern("invalid pattern capture"))?;
        self.captures[open].1 = CaptureLength::Bytes(s - self.captures[open].0);
        let found = self.match_nested(s, p)?;
        if found.is_none() {
            self.captures[open].1 = CaptureLength::Open;
        }
        Ok(found)
    }

    /// Matches the text of an earlier capture.
    fn match_back_reference(&mut self, s: usize, digit: u8) -> MatchResult {
        let i = usize::from(digit).wrapping_sub(usize::from(b'1'));
        let (start, n) = match self.captures[..self.level].get(i) {
            Some((start, CaptureLength::Bytes(n))) => (*start, *n),
            Some((_, CaptureLength::Position)) => return Ok(None),
            _ => return Err(MatchError::Pattern("invalid capture index in pattern")),
        };
        self.steps_of(n as u64 / 16)?;
        let caught = &self.src[start..start + n];
        Ok(self.src[s..].starts_with(caught).then_some(s + n))
    }

    fn balance(&mut self, s: usize, p: usize) -> MatchResult {
        if p + 1 >= self.pat.len() {
            return Err(MatchError::Pattern("missing arguments to '%b' in pattern"));
        }
        let (open, close) = (self.p(p), self.p(p + 1));
        if self.src.get(s) != Some(&open) {
            return Ok(None);
        }
        let mut inside = 1;
        for (i, c) in self.src.iter().enumerate().skip(s + 1) {
            self.step()?;
            if *c == close {
                inside -= 1;
                if inside == 0 {
                    return Ok(Some(i + 1));
                }
            } else if *c == open {
                inside += 1;
            }
        }
        Ok(None)
    }

    /// Returns the end of the class that begins at `p`.
    fn class_end(&self, p: usize) -> Result<usize, MatchError> {
        let n = self.pat.len();
        match self.p(p) {
            b'%' if p + 1 >= n => Err(MatchError::Pattern("malformed pattern (ends with '%')")),
            b'%' => Ok(p + 2),
            b'[' => {
                let mut i = p + 1;
                if self.p(i) == b'^' {
                    i += 1;
                }
                loop {
                    if i >= n {
                        return Err(MatchError::Pattern("malformed pattern (missing ']')"));
                    }
                    i += if self.p(i) == b'%' { 2 } else { 1 };
                    if i < n && self.p(i) == b']' {
                        return Ok(i + 1);
                    }
                }
            }
            _ => Ok(p + 1),
        }
    }

    fn single(&self, s: usize, p: usize, end: usize) -> bool {
        let Some(c) = self.src.get(s).copied() else {
            return false;
        };
        match self.p(p) {
            b'.' => true,
            b'%' => class(c, self.p(p + 1)),
            b'[' => self.set(c, p, end - 1),
            byte => byte == c,
        }
    }

    /// Returns whether a byte is in the set from `[` at `p` to `]` at `end`.
    fn set(&self, c: u8, mut p: usize, end: usize) -> bool {
        let mut inside = true;
        if self.p(p + 1) == b'^' {
            inside = false;
            p += 1;
        }
        p += 1;
        while p < end {
            if self.p(p) == b'%' {
                p += 1;
                if class(c, self.p(p)) {
                    return inside;
                }
            } else if self.p(p + 1) == b'-' && p + 2 < end {
                if (self.p(p)..=self.p(p + 2)).contains(&c) {
                    return inside;
                }
                p += 2;
            } else if self.p(p) == c {
                return inside;
            }
            p += 1;
        }
        !inside
    }
}

/// Returns whether a byte is in a class such as `%d`.
fn class(c: u8, class: u8) -> bool {
    let member = match class.to_ascii_lowercase() {
        b'a' => c.is_ascii_alphabetic(),
        b'c' => c.is_ascii_control(),
        b'd' => c.is_ascii_digit(),
        b'g' => c.is_ascii_graphic(),
        b'l' => c.is_ascii_lowercase(),
        b'p' => c.is_ascii_punctuation(),
        b's' => c.is_ascii_whitespace() || c == 0x0B,
        b'u' => c.is_ascii_uppercase(),
        b'w' => c.is_ascii_alphanumeric(),
        b'x' => c.is_ascii_hexdigit(),
        b'z' => c == 0,
        _ => return class == c,
    };
    member != class.is_ascii_uppercase()
}

/// Returns whether a pattern has no special characters.
pub(crate) fn is_plain(pattern: &[u8]) -> bool {
    !pattern.iter().any(|b| b"^$*+?.([%-".contains(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mlua_sys::*;

    /// Returns the result of Lua's own `string.find`: "3 4 a @2", "nil" or "error".
    fn find_with_lua(l: *mut lua_State, src: &[u8], pat: &[u8]) -> String {
        // SAFETY: the test owns the state, slot 1 holds `string.find`, and `lua_pcall` catches errors.
        unsafe {
            lua_settop(l, 1);
            lua_pushvalue(l, 1);
            lua_pushlstring(l, src.as_ptr().cast(), src.len());
            lua_pushlstring(l, pat.as_ptr().cast(), pat.len());
            if lua_pcall(l, 2, LUA_MULTRET, 0) != LUA_OK {
                return "error".into();
            }
            let mut out = Vec::new();
            for i in 2..=lua_gettop(l) {
                out.push(match lua_type(l, i) {
                    LUA_TNIL => "nil".into(),
                    LUA_TNUMBER if i > 3 => format!("@{}", lua_tointeger(l, i)),
                    LUA_TNUMBER => lua_tointeger(l, i).to_string(),
                    _ => String::from_utf8_lossy(crate::stack::bytes(l, i)).into_owned(),
                });
            }
            out.join(" ")
        }
    }

    fn find_with_matcher(src: &[u8], pat: &[u8]) -> String {
        if is_plain(pat) {
            let at = (0..=src.len()).find(|i| src[*i..].starts_with(pat));
            return at.map_or("nil".into(), |i| format!("{} {}", i + 1, i + pat.len()));
        }
        let anchored = pat.strip_prefix(b"^");
        let mut m = Matcher::new(src, anchored.unwrap_or(pat), u64::MAX);
        for s in 0..=src.len() {
            let e = match m.match_at(s) {
                Err(_) => return "error".into(),
                Ok(Some(e)) => e,
                Ok(None) if anchored.is_some() => break,
                Ok(None) => continue,
            };
            let mut out = vec![(s + 1).to_string(), e.to_string()];
            for i in 0..m.count(false) {
                match m.capture(i, s, e) {
                    Err(_) => return "error".into(),
                    Ok(CaptureValue::Position(at)) => out.push(format!("@{}", at + 1)),
                    Ok(CaptureValue::Part(a, b)) => {
                        out.push(String::from_utf8_lossy(&src[a..b]).into_owned());
                    }
                }
            }
            return out.join(" ");
        }
        "nil".into()
    }

    #[test]
    fn matcher_agrees_with_lua() {
        // SAFETY: the state is created here and used by this test only.
        let l = unsafe {
            let l = luaL_newstate();
            luaL_requiref(l, c"string".as_ptr(), luaopen_string, 1);
            lua_getfield(l, -1, c"find".as_ptr());
            lua_replace(l, 1);
            l
        };
        let mut seed = 1u64;
        let mut next = |n: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) as usize % n
        };
        let mut matches = 0;
        for _ in 0..200_000 {
            let src: Vec<u8> = (0..next(10)).map(|_| b"aabb1 ](\x0b%"[next(10)]).collect();
            let pieces = [
                "a", "b", ".", "%", "%a", "%d", "%S", "%w", "[", "]", "^", "$", "(", ")", "()", "*", "+", "-", "?",
                "%1", "%2", "%b()", "%bab", "%f", "%f[%w]", "[ab]", "[^a]", "[a-b]", "[]]", "(a)", "(.-)", "%)", "%%",
            ];
            let pat: String = (0..next(6)).map(|_| pieces[next(pieces.len())]).collect();
            let theirs = find_with_lua(l, &src, pat.as_bytes());
            assert_eq!(find_with_matcher(&src, pat.as_bytes()), theirs, "{pat:?} on {src:?}");
            matches += u32::from(theirs.starts_with(|c: char| c.is_ascii_digit()));
        }
        assert!(matches > 20_000, "{matches}");
        // SAFETY: the test owns the state and does not use it afterwards.
        unsafe { lua_close(l) };
    }

    #[test]
    fn exponential_match_ends_at_the_step_limit() {
        let src = vec![b'a'; 30];
        let pat = format!("{}{}b", "a?".repeat(30), "a".repeat(30));
        let mut m = Matcher::new(&src, pat.as_bytes(), 100_000);
        assert_eq!(m.match_at(0), Err(MatchError::Steps));
    }
}
