//! Lossless tokenizer for Lua, used to infer the dialect of a script and to convert Lua 5.1 to Lua 5.4.

use std::borrow::Cow;

/// The kind of a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// White space, comments, and invalid bytes.
    Space,
    /// A name or a keyword.
    Name,
    /// A numeral.
    Number,
    /// A quoted string.
    String,
    /// A string in long brackets.
    LongString,
    /// An operator or separator.
    Operator,
}

/// Iterator over the tokens in order; their concatenation is the source.
pub(crate) struct Tokens<'a> {
    text: &'a [u8],
    at: usize,
}

/// Operators of more than one character, longest first.
const OPERATORS: [&[u8]; 10] = [b"...", b"..", b"==", b"~=", b"<=", b">=", b"//", b"::", b"<<", b">>"];

impl<'a> Tokens<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Tokens { text, at: 0 }
    }
    /// Returns the length of the string in long brackets, `[==[ ... ]==]`, that starts at `at`, if any.
    fn long(&self, at: usize) -> Option<usize> {
        let rest = self.text[at..].strip_prefix(b"[")?;
        let level = rest.iter().take_while(|c| **c == b'=').count();
        let body = rest[level..].strip_prefix(b"[")?;
        let end = body.iter().enumerate().find(|(i, c)| {
            let close = &body[*i..];
            **c == b']'
                && close.len() >= level + 2
                && close[1..=level].iter().all(|c| *c == b'=')
                && close[level + 1] == b']'
        });
        Some(end.map_or(self.text.len() - at, |(i, _)| i + 2 * (level + 2)))
    }
    fn quoted(&self, quote: u8) -> usize {
        let rest = &self.text[self.at..];
        let mut i = 1;
        while i < rest.len() {
            match rest[i] {
                b'\\' => i += 1,
                b'\n' => return i,
                c if c == quote => return i + 1,
                _ => {}
            }
            i += 1;
        }
        rest.len()
    }
    fn number(&self) -> usize {
        let rest = &self.text[self.at..];
        let hex = rest.len() > 1 && rest[0] == b'0' && rest[1] | 32 == b'x';
        let exponent = if hex { b'p' } else { b'e' };
        let mut i = 0;
        while let Some(c) = rest.get(i) {
            let sign = matches!(c, b'+' | b'-') && i > 0 && rest[i - 1] | 32 == exponent;
            if !(c.is_ascii_alphanumeric() || *c == b'.' || *c == b'_' || sign) {
                break;
            }
            i += 1;
        }
        i
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = (TokenKind, &'a [u8]);
    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.text[self.at..];
        let word = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_';
        let line = || rest.iter().take_while(|c| **c != b'\n').count();
        let (kind, len) = match *rest.first()? {
            c if c.is_ascii_whitespace() => {
                (TokenKind::Space, rest.iter().take_while(|c| c.is_ascii_whitespace()).count())
            }
            b'-' if rest.starts_with(b"--") => (TokenKind::Space, self.long(self.at + 2).map_or_else(line, |n| n + 2)),
            b'#' if self.at == 0 => (TokenKind::Space, line()),
            c if c.is_ascii_digit() || c == b'.' && rest.get(1).is_some_and(u8::is_ascii_digit) => {
                (TokenKind::Number, self.number())
            }
            c if word(&c) => (TokenKind::Name, rest.iter().take_while(|c| word(c)).count()),
            c @ (b'"' | b'\'') => (TokenKind::String, self.quoted(c)),
            b'[' if self.long(self.at).is_some() => (TokenKind::LongString, self.long(self.at).unwrap_or(1)),
            c if c.is_ascii_graphic() => {
                (TokenKind::Operator, OPERATORS.iter().find(|s| rest.starts_with(s)).map_or(1, |s| s.len()))
            }
            _ => (TokenKind::Space, 1),
        };
        self.at += len;
        Some((kind, &rest[..len]))
    }
}

/// Returns the words of a script, sorted and unique: names, keywords, qualified names (`robot.arm.grip`) with their
/// prefixes, operators, and `require NAME` for modules. Comments and strings are ignored.
pub(crate) fn words(text: &[u8]) -> Vec<Vec<u8>> {
    let mut out: Vec<Vec<u8>> = Vec::new();
    let (mut path, mut open, mut require) = (Vec::new(), false, false);
    for (kind, token) in Tokens::new(text).filter(|(kind, _)| *kind != TokenKind::Space) {
        match (kind, token) {
            (TokenKind::Operator, b".") if !path.is_empty() => open = true,
            (TokenKind::Name, name) => {
                if !open {
                    path.clear();
                } else {
                    path.push(b'.');
                    out.push(name.to_vec());
                }
                path.extend_from_slice(name);
                out.push(path.clone());
                open = false;
                require = path == b"require";
                continue;
            }
            (TokenKind::String, quoted) if require => {
                out.push(
                    [b"require ", quoted.trim_ascii()].concat().into_iter().filter(|c| !b"\"'".contains(c)).collect(),
                );
            }
            (TokenKind::Operator, sign) => {
                path.clear();
                out.push(sign.to_vec());
            }
            _ => path.clear(),
        }
        require &= token == b"(";
    }
    out.sort_unstable();
    out.dedup();
    out
}

/// Returns the values `X` with a non-empty block, if a script consists only of blocks `if variable == X then ... end`;
/// for other values of the variable, such a script does nothing. Returns `None` if the script has any other form.
pub(crate) fn branches<'a>(text: &'a [u8], variable: &[u8]) -> Option<Vec<&'a [u8]>> {
    let tokens: Vec<&[u8]> =
        Tokens::new(text).filter(|(kind, _)| *kind != TokenKind::Space).map(|(_, token)| token).collect();
    let (mut rest, mut all, mut nonempty) = (tokens.as_slice(), Vec::new(), Vec::new());
    while let Some((first, after)) = rest.split_first() {
        rest = after;
        if *first == b";" {
            continue;
        }
        let open = rest.iter().take_while(|t| **t == b"(").count();
        let [tested, b"==", value, closed @ ..] = rest.get(open..)? else { return None };
        let then = closed.get(open)?;
        if *first != b"if" || *tested != variable || closed[..open].iter().any(|t| *t != b")") || *then != b"then" {
            return None;
        }
        let body = &closed[open + 1..];
        let n = end_of_block(body)?;
        all.push(*value);
        if n > 0 {
            nonempty.push(*value);
        }
        rest = &body[n + 1..];
    }
    // Any other use of the variable or of these names, such as an assignment, might change which branch runs.
    let occurrences = |name: &[u8]| tokens.iter().filter(|t| **t == name).count();
    let once =
        |name: &&[u8]| occurrences(name) == all.iter().filter(|n| *n == name).count() || name[0].is_ascii_digit();
    (!all.is_empty() && occurrences(variable) == all.len() && all.iter().all(once)).then_some(nonempty)
}

/// Returns the number of tokens before the `end` of a block; `None` if it is missing or preceded by an `else`.
fn end_of_block(tokens: &[&[u8]]) -> Option<usize> {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate() {
        match *token {
            b"end" | b"until" if depth > 0 => depth -= 1,
            b"end" => return Some(i),
            b"else" | b"elseif" if depth == 0 => return None,
            // `for` and `while` are counted by their `do`.
            b"if" | b"function" | b"do" | b"repeat" => depth += 1,
            _ => {}
        }
    }
    None
}

/// Converts Lua 5.1 to Lua 5.4, preserving line numbers. In 5.1, `goto` was a name, an unknown escape represented the
/// letter itself, all numbers were floats, and functions with `...` had a table `arg`.
pub(crate) fn to_lua54(text: &[u8]) -> Cow<'_, [u8]> {
    let mut out = Vec::new();
    let mut same = true;
    // Labels occur only in scripts that use the statement `goto`.
    let labels = Tokens::new(text).any(|t| t == (TokenKind::Operator, b"::"));
    for (kind, token) in Tokens::new(text) {
        let before = out.len();
        match kind {
            TokenKind::Name if token == b"goto" && !labels => out.extend_from_slice(b"goto_"),
            TokenKind::String => escapes(token, &mut out),
            // 5.1 read an integer with more digits than a float can represent as a float.
            TokenKind::Number if token.len() > 15 && token.iter().all(u8::is_ascii_digit) => {
                out.extend_from_slice(token);
                out.extend_from_slice(b".0");
            }
            _ => out.extend_from_slice(token),
        }
        same &= out[before..] == *token;
    }
    let args = arguments(&out);
    if args.is_empty() {
        return if same { Cow::Borrowed(text) } else { Cow::Owned(out) };
    }
    for at in args.into_iter().rev() {
        out.splice(at..at, b" local arg = {n = select('#', ...), ...} ".iter().copied());
    }
    Cow::Owned(out)
}

fn escapes(quoted: &[u8], out: &mut Vec<u8>) {
    let mut i = 0;
    while i < quoted.len() {
        if quoted[i] == b'\\' && i + 1 < quoted.len() {
            let c = quoted[i + 1];
            if c.is_ascii_digit() || b"abfnrtv\\\"'\r\n".contains(&c) {
                out.push(b'\\');
            }
            i += 1;
        }
        out.push(quoted[i]);
        i += 1;
    }
}

/// A function whose `end` has not been reached yet, for [`arguments`].
struct OpenFunction {
    /// Number of blocks that are open within the function.
    depth: u32,
    /// Start of the body, if the parameters end with `...`.
    varargs: Option<usize>,
    uses_arg: bool,
    uses_dots: bool,
}

/// Returns the start positions of the bodies of vararg functions that use `arg` but not `...`.
fn arguments(text: &[u8]) -> Vec<usize> {
    if !text.windows(3).any(|w| w == b"arg") {
        return Vec::new();
    }
    let (mut found, mut functions, mut at) = (Vec::new(), Vec::<OpenFunction>::new(), 0);
    // Whether the current position is in a parameter list, and whether this list contains `...`.
    let (mut head, mut dots) = (false, false);
    for (kind, token) in Tokens::new(text) {
        at += token.len();
        match (kind, token) {
            (TokenKind::Name, b"function") => (head, dots) = (true, false),
            (TokenKind::Operator, b"...") if head => dots = true,
            (TokenKind::Operator, b")") if head => {
                head = false;
                let varargs = dots.then_some(at);
                functions.push(OpenFunction { depth: 1, varargs, uses_arg: false, uses_dots: false });
            }
            (TokenKind::Operator, b"...") => {
                if let Some(f) = functions.last_mut() {
                    f.uses_dots = true;
                }
            }
            (TokenKind::Name, b"arg") => {
                if let Some(f) = functions.last_mut() {
                    f.uses_arg = true;
                }
            }
            (TokenKind::Name, b"do" | b"if" | b"repeat") => {
                if let Some(f) = functions.last_mut() {
                    f.depth += 1;
                }
            }
            (TokenKind::Name, b"end" | b"until") => {
                if let Some(f) = functions.last_mut() {
                    f.depth -= 1;
                    if f.depth == 0 {
                        let done = functions.pop();
                        found.extend(done.filter(|f| f.uses_arg && !f.uses_dots).and_then(|f| f.varargs));
                    }
                }
            }
            _ => {}
        }
    }
    found.sort_unstable();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The concatenated tokens are the source, for arbitrary input.
        #[test]
        fn tokens_are_the_text(text in prop::collection::vec(prop::sample::select(
            b"ab_1.0eE+-[]=\"'\\\n\r -~/<>:{}()gotoarg\xff".to_vec()), 0..60))
        {
            let all: Vec<u8> = Tokens::new(&text).flat_map(|(_, t)| t.to_vec()).collect();
            prop_assert_eq!(all, text.clone());
            let lines = |t: &[u8]| t.iter().filter(|c| **c == b'\n').count();
            prop_assert_eq!(lines(&to_lua54(&text)), lines(&text));
            words(&text);
        }
    }

    fn words_of(text: &str) -> Vec<String> {
        words(text.as_bytes()).into_iter().map(|w| String::from_utf8(w).unwrap()).collect()
    }

    #[test]
    fn names_keywords_and_operators_are_collected() {
        let text =
            "-- hidden.name\n--[[ also\n hidden ]] a.b.c(x) s = 'not.this' local m = require 'arm'  y = [[nor this]]";
        assert_eq!(
            words_of(text),
            ["(", ")", "=", "a", "a.b", "a.b.c", "b", "c", "local", "m", "require", "require arm", "s", "x", "y"]
        );
        assert!(words_of("require('arm')").contains(&"require arm".to_owned()));
        assert!(!words_of("require(x, 'arm')").contains(&"require arm".to_owned()));
        assert!(words_of("a = 7 // 2").contains(&"//".to_owned()));
    }

    #[test]
    fn old_syntax_is_converted_to_lua_5_4() {
        let cases = [
            ("goto = 1 x.goto(goto)", "goto_ = 1 x.goto_(goto_)"),
            ("goto a ::a::", "goto a ::a::"),
            (r#"s = "50\% \/ \x41 \n \065 \\d" .. '\"'"#, r#"s = "50% / x41 \n \065 \\d" .. '\"'"#),
            ("s = [[\\%]] -- \\%", "s = [[\\%]] -- \\%"),
            (
                "n = 12345678901234567 m = 123456789012345 o = 0x1234567890ABCDEF",
                "n = 12345678901234567.0 m = 123456789012345 o = 0x1234567890ABCDEF",
            ),
            (
                "function f(...) return arg.n end",
                "function f(...) local arg = {n = select('#', ...), ...}  return arg.n end",
            ),
            ("function f(...) local arg = {...} end", "function f(...) local arg = {...} end"),
            ("function f(a) if a then return arg end end", "function f(a) if a then return arg end end"),
            (
                "function f(...) local function g(...) return ... end while x do y() end return g(arg[1]) end",
                "function f(...) local arg = {n = select('#', ...), ...}  local function g(...) return ... end while x do y() end return g(arg[1]) end",
            ),
        ];
        for (old, new) in cases {
            assert_eq!(String::from_utf8_lossy(&to_lua54(old.as_bytes())), new);
        }
        assert!(matches!(to_lua54(b"x = 1"), Cow::Borrowed(_)));
    }

    #[test]
    fn only_a_plain_sequence_of_branches_is_detected() {
        let of = |text: &str| {
            let found = branches(text.as_bytes(), b"what")?;
            Some(found.iter().map(|b| String::from_utf8_lossy(b).into_owned()).collect::<Vec<_>>())
        };
        let row = "-- a comment\nif (what==A) then x = 1 end\nif what == B then if x then y() else z() end end; \
                   if ((what == C)) then -- nothing\nend if what == 3 then repeat x() until y for i=1,2 do z() end end";
        assert_eq!(of(row), Some(vec!["A".into(), "B".into(), "3".into()]));
        for other in [
            "",
            "x()",
            "if what == A then x() end y()",
            "local n = 1 if what == A then x() end",
            "if what == A then x() else y() end",
            "if what == A then x() elseif what == B then y() end",
            "if what ~= A then x() end",
            "if what == A or z then x() end",
            "if (what == A then x() end",
            "if what == A then what = B end if what == B then x() end",
            "if what == A then B = A end if what == B then x() end",
            "if what == A then x(",
            "if what == A then x() end return y()",
        ] {
            assert_eq!(of(other), None, "{other}");
        }
    }
}
