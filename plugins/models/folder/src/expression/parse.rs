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
use crate::error::{ModelError, Result};

/// Maximum nesting depth of an expression.
const MAX_DEPTH: usize = 60;
/// Maximum length of an expression, bytes.
const MAX_EXPRESSION_BYTES: usize = 64 << 10;

/// An expression. A sequence of operators or of indices is one node, so that the depth of a tree is limited by that of
/// the parser's recursion. This matters because trees are evaluated and dropped recursively.
#[derive(Debug, Clone, PartialEq)]
pub enum ExpressionTree {
    Number(f64),
    Text(String),
    Name(String),
    List(Vec<ExpressionTree>),
    Call(String, Vec<ExpressionTree>),
    /// The expression, the name of the loop variable, and the list of elements.
    Each(Box<ExpressionTree>, String, Box<ExpressionTree>),
    /// A list, and the indices applied to it.
    Index(Box<ExpressionTree>, Vec<ExpressionTree>),
    Negative(Box<ExpressionTree>),
    Not(Box<ExpressionTree>),
    /// A value, and operators of equal precedence with their right operands, applied from left to right.
    Chain(Box<ExpressionTree>, Vec<(&'static str, ExpressionTree)>),
}

/// Parses an expression. Fails if it is malformed, too long, or nested too deeply.
pub fn parse(text: &str) -> Result<ExpressionTree> {
    if text.len() > MAX_EXPRESSION_BYTES {
        return Err(ModelError::new(format!(
            "the expression has {} bytes, but the maximum is {MAX_EXPRESSION_BYTES}",
            text.len()
        ))
        .help("split it into several numbers in [model.numbers]"));
    }
    let mut parser = ExpressionParser { rest: text, depth: 0 };
    let tree = parser.expression()?;
    match parser.rest.trim_start() {
        "" => Ok(tree),
        rest => Err(ModelError::new(format!("expected an operator or the end of the expression, found `{rest}`"))),
    }
}

struct ExpressionParser<'a> {
    rest: &'a str,
    depth: usize,
}

/// Binary operators except `^`, from the weakest binding to the strongest. Within a level, `<=` precedes `<`, because
/// the parser uses the first operator that matches.
const PRECEDENCE_LEVELS: &[&[&str]] =
    &[&["or"], &["and"], &["==", "!=", "<=", ">=", "<", ">"], &["+", "-"], &["*", "/", "%"]];
/// Index of the comparisons in `PRECEDENCE_LEVELS`; `not` binds more weakly than they do.
const COMPARISON_LEVEL: usize = 2;

impl ExpressionParser<'_> {
    fn expression(&mut self) -> Result<ExpressionTree> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(ModelError::new(format!("the expression is nested more than {MAX_DEPTH} levels deep")));
        }
        let tree = self.level(0);
        self.depth -= 1;
        tree
    }

    fn level(&mut self, n: usize) -> Result<ExpressionTree> {
        let Some(operators) = PRECEDENCE_LEVELS.get(n) else { return self.sign() };
        if n == COMPARISON_LEVEL && self.accept("not") {
            self.enter()?;
            let inner = self.level(n)?;
            self.depth -= 1;
            return Ok(ExpressionTree::Not(inner.into()));
        }
        let left = self.level(n + 1)?;
        let mut row = Vec::new();
        while let Some(operator) = operators.iter().find(|o| self.accept(o)) {
            row.push((*operator, self.level(n + 1)?));
            if n == COMPARISON_LEVEL {
                break;
            }
        }
        Ok(if row.is_empty() { left } else { ExpressionTree::Chain(left.into(), row) })
    }

    fn enter(&mut self) -> Result {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(ModelError::new(format!("the expression is nested more than {MAX_DEPTH} levels deep")));
        }
        Ok(())
    }

    fn sign(&mut self) -> Result<ExpressionTree> {
        if self.accept("-") {
            self.enter()?;
            let inner = self.sign()?;
            self.depth -= 1;
            return Ok(ExpressionTree::Negative(inner.into()));
        }
        let base = self.indexed()?;
        if self.accept("^") {
            self.enter()?;
            let power = self.sign()?;
            self.depth -= 1;
            return Ok(ExpressionTree::Chain(base.into(), vec![("^", power)]));
        }
        Ok(base)
    }

    fn indexed(&mut self) -> Result<ExpressionTree> {
        let tree = self.single()?;
        let mut indices = Vec::new();
        while self.accept("[") {
            indices.push(self.expression()?);
            self.expect("]")?;
        }
        Ok(if indices.is_empty() { tree } else { ExpressionTree::Index(tree.into(), indices) })
    }

    fn single(&mut self) -> Result<ExpressionTree> {
        self.rest = self.rest.trim_start();
        let rest = self.rest;
        let Some(first) = rest.chars().next() else {
            return Err(ModelError::new("expected a value, found the end of the expression"));
        };
        if first.is_ascii_digit() || first == '.' {
            return self.number();
        }
        if first == '\'' || first == '"' {
            let inner = &rest[1..];
            let end =
                inner.find(first).ok_or_else(|| ModelError::new(format!("the string {rest} has no closing quote")))?;
            self.rest = &inner[end + 1..];
            return Ok(ExpressionTree::Text(inner[..end].to_owned()));
        }
        if self.accept("(") {
            let inner = self.expression()?;
            self.expect(")")?;
            return Ok(inner);
        }
        if self.accept("[") {
            return self.elements();
        }
        let name = self.word()?;
        match self.accept("(") {
            true => self.list(")").map(|args| ExpressionTree::Call(name, args)),
            false => Ok(ExpressionTree::Name(name)),
        }
    }

    /// Parses the rest of a list after its opening bracket: either elements or `x for name in y`.
    fn elements(&mut self) -> Result<ExpressionTree> {
        if self.accept("]") {
            return Ok(ExpressionTree::List(Vec::new()));
        }
        let first = self.expression()?;
        if self.accept("for") {
            let name = self.word()?;
            if RESERVED.contains(&name.as_str()) {
                let wrong = ModelError::new(format!("`{name}` is a reserved name in expressions"));
                return Err(wrong.help("choose another name"));
            }
            self.expect("in")?;
            let list = self.expression()?;
            self.expect("]")?;
            return Ok(ExpressionTree::Each(first.into(), name, list.into()));
        }
        let mut all = vec![first];
        while self.accept(",") {
            all.push(self.expression()?);
        }
        self.expect("]").map(|()| ExpressionTree::List(all))
    }

    fn word(&mut self) -> Result<String> {
        let rest = self.rest.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        if end == 0 {
            return Err(ModelError::new(format!("expected a value, found `{rest}`")));
        }
        self.rest = &rest[end..];
        Ok(rest[..end].to_owned())
    }

    fn number(&mut self) -> Result<ExpressionTree> {
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
        number.parse().map(ExpressionTree::Number).map_err(|_| ModelError::new(format!("`{number}` is not a number")))
    }

    fn list(&mut self, end: &'static str) -> Result<Vec<ExpressionTree>> {
        let mut all = Vec::new();
        if self.accept(end) {
            return Ok(all);
        }
        loop {
            all.push(self.expression()?);
            if !self.accept(",") {
                self.expect(end)?;
                return Ok(all);
            }
        }
    }

    /// Consumes `what` if it is the next word or symbol, and returns whether it did.
    fn accept(&mut self, what: &str) -> bool {
        let rest = self.rest.trim_start();
        let Some(after) = rest.strip_prefix(what) else { return false };
        let is_word = what.starts_with(|c: char| c.is_ascii_alphabetic());
        if is_word && after.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_') {
            return false;
        }
        self.rest = after;
        true
    }

    fn expect(&mut self, what: &str) -> Result {
        if self.accept(what) {
            return Ok(());
        }
        let found = match self.rest.trim_start() {
            "" => "the end of the expression".to_owned(),
            rest => format!("`{rest}`"),
        };
        Err(ModelError::new(format!("expected `{what}`, found {found}")))
    }
}
