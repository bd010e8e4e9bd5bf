//! The syntax of expressions, from the weakest binding to the strongest:
//!
//! ```text
//! or
//! and
//! not
//! ==  !=  <  <=  >  >=        (not chained)
//! +  -
//! *  /  %
//! -x
//! ^                           (from right to left)
//! x[i]
//! 1.5  'text'  name  name(a, b)  (x)  [a, b]  [x for name in y]
//! ```

use super::functions::RESERVED;
use crate::wrong::{Result, Wrong};

/// Maximum nesting depth.
const DEEPEST: usize = 60;
/// Maximum length of an expression, bytes.
const LONGEST: usize = 64 << 10;

/// An expression. A sequence of operators or of indices is one node, so that the depth of a tree is limited by that of
/// the parser's recursion. This matters because trees are evaluated and dropped recursively.
#[derive(Debug, Clone, PartialEq)]
pub enum Tree {
    Number(f64),
    Text(String),
    Name(String),
    List(Vec<Tree>),
    Call(String, Vec<Tree>),
    /// The expression, the name of the loop variable, and the list of elements.
    Each(Box<Tree>, String, Box<Tree>),
    /// A list, and the indices applied to it.
    Index(Box<Tree>, Vec<Tree>),
    Negative(Box<Tree>),
    Not(Box<Tree>),
    /// A value, and operators of equal precedence with their right operands, applied from left to right.
    Row(Box<Tree>, Vec<(&'static str, Tree)>),
}

/// Parses an expression.
pub fn parse(text: &str) -> Result<Tree> {
    if text.len() > LONGEST {
        return Err(Wrong::new(format!("the expression has {} bytes, but the maximum is {LONGEST}", text.len()))
            .help("split it into several numbers in [model.numbers]"));
    }
    let mut parser = Parser { rest: text, depth: 0 };
    let tree = parser.any()?;
    match parser.rest.trim_start() {
        "" => Ok(tree),
        rest => Err(Wrong::new(format!("expected an operator or the end of the expression, found `{rest}`"))),
    }
}

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
}

/// Binary operators except `^`, from the weakest binding to the strongest. Within a level, `<=` precedes `<`, because
/// the parser uses the first operator that matches.
const LEVELS: &[&[&str]] = &[&["or"], &["and"], &["==", "!=", "<=", ">=", "<", ">"], &["+", "-"], &["*", "/", "%"]];
/// Index of the comparisons in `LEVELS`; `not` binds more weakly than they do.
const COMPARES: usize = 2;

impl Parser<'_> {
    fn any(&mut self) -> Result<Tree> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Wrong::new(format!("the expression is nested more than {DEEPEST} levels deep")));
        }
        let tree = self.level(0);
        self.depth -= 1;
        tree
    }

    fn level(&mut self, n: usize) -> Result<Tree> {
        let Some(operators) = LEVELS.get(n) else { return self.sign() };
        if n == COMPARES && self.takes("not") {
            self.deeper()?;
            let inner = self.level(n)?;
            self.depth -= 1;
            return Ok(Tree::Not(inner.into()));
        }
        let left = self.level(n + 1)?;
        let mut row = Vec::new();
        while let Some(operator) = operators.iter().find(|o| self.takes(o)) {
            row.push((*operator, self.level(n + 1)?));
            if n == COMPARES {
                break;
            }
        }
        Ok(if row.is_empty() { left } else { Tree::Row(left.into(), row) })
    }

    fn deeper(&mut self) -> Result {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Wrong::new(format!("the expression is nested more than {DEEPEST} levels deep")));
        }
        Ok(())
    }

    fn sign(&mut self) -> Result<Tree> {
        if self.takes("-") {
            self.deeper()?;
            let inner = self.sign()?;
            self.depth -= 1;
            return Ok(Tree::Negative(inner.into()));
        }
        let base = self.indexed()?;
        if self.takes("^") {
            self.deeper()?;
            let power = self.sign()?;
            self.depth -= 1;
            return Ok(Tree::Row(base.into(), vec![("^", power)]));
        }
        Ok(base)
    }

    fn indexed(&mut self) -> Result<Tree> {
        let tree = self.single()?;
        let mut indices = Vec::new();
        while self.takes("[") {
            indices.push(self.any()?);
            self.needs("]")?;
        }
        Ok(if indices.is_empty() { tree } else { Tree::Index(tree.into(), indices) })
    }

    fn single(&mut self) -> Result<Tree> {
        self.rest = self.rest.trim_start();
        let rest = self.rest;
        let Some(first) = rest.chars().next() else {
            return Err(Wrong::new("expected a value, found the end of the expression"));
        };
        if first.is_ascii_digit() || first == '.' {
            return self.number();
        }
        if first == '\'' || first == '"' {
            let inner = &rest[1..];
            let end = inner.find(first).ok_or_else(|| Wrong::new(format!("the string {rest} has no closing quote")))?;
            self.rest = &inner[end + 1..];
            return Ok(Tree::Text(inner[..end].to_owned()));
        }
        if self.takes("(") {
            let inner = self.any()?;
            self.needs(")")?;
            return Ok(inner);
        }
        if self.takes("[") {
            return self.elements();
        }
        let name = self.word()?;
        match self.takes("(") {
            true => self.list(")").map(|args| Tree::Call(name, args)),
            false => Ok(Tree::Name(name)),
        }
    }

    /// Parses the rest of a list after its opening bracket: either elements or `x for name in y`.
    fn elements(&mut self) -> Result<Tree> {
        if self.takes("]") {
            return Ok(Tree::List(Vec::new()));
        }
        let first = self.any()?;
        if self.takes("for") {
            let name = self.word()?;
            if RESERVED.contains(&name.as_str()) {
                let wrong = Wrong::new(format!("`{name}` is a reserved name in expressions"));
                return Err(wrong.help("choose another name"));
            }
            self.needs("in")?;
            let list = self.any()?;
            self.needs("]")?;
            return Ok(Tree::Each(first.into(), name, list.into()));
        }
        let mut all = vec![first];
        while self.takes(",") {
            all.push(self.any()?);
        }
        self.needs("]").map(|()| Tree::List(all))
    }

    fn word(&mut self) -> Result<String> {
        let rest = self.rest.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        if end == 0 {
            return Err(Wrong::new(format!("expected a value, found `{rest}`")));
        }
        self.rest = &rest[end..];
        Ok(rest[..end].to_owned())
    }

    fn number(&mut self) -> Result<Tree> {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while let Some(b) = bytes.get(end) {
            let sign = matches!(b, b'+' | b'-') && end > 0 && matches!(bytes[end - 1], b'e' | b'E');
            if !(b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'E') || sign) {
                break;
            }
            end += 1;
        }
        let (number, rest) = self.rest.split_at(end);
        self.rest = rest;
        number.parse().map(Tree::Number).map_err(|_| Wrong::new(format!("`{number}` is not a number")))
    }

    fn list(&mut self, end: &'static str) -> Result<Vec<Tree>> {
        let mut all = Vec::new();
        if self.takes(end) {
            return Ok(all);
        }
        loop {
            all.push(self.any()?);
            if !self.takes(",") {
                self.needs(end)?;
                return Ok(all);
            }
        }
    }

    /// Consumes `what` if it is the next word or symbol, and returns whether it did.
    fn takes(&mut self, what: &str) -> bool {
        let rest = self.rest.trim_start();
        let Some(after) = rest.strip_prefix(what) else { return false };
        let is_word = what.starts_with(|c: char| c.is_ascii_alphabetic());
        if is_word && after.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_') {
            return false;
        }
        self.rest = after;
        true
    }

    fn needs(&mut self, what: &str) -> Result {
        if self.takes(what) {
            return Ok(());
        }
        let found = match self.rest.trim_start() {
            "" => "the end of the expression".to_owned(),
            rest => format!("`{rest}`"),
        };
        Err(Wrong::new(format!("expected `{what}`, found {found}")))
    }
}
