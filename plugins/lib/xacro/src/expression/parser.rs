//! Parses expressions, by precedence.

use std::rc::Rc;

use super::{
    lexer::{Token, is_identifier, tokens},
    syntax::{Call, Comparator, Expression, Operator, binding},
};
use crate::{
    error::{Result, excerpt, fail},
    limits::MAX_NESTING,
    value::Value,
};

/// Maximum height of the tree: the number of operators in a row, or brackets in one another.
const MAX_HEIGHT: usize = 200;

/// A tree with its height.
type Tree = (Expression, usize);

/// Parses a whole text.
pub(super) fn parse(text: &str) -> Result<Expression> {
    let mut parser = Parser { tokens: tokens(text)?, next: 0, nesting: 0, text };
    let (expression, _) = parser.list_or_one()?;
    match parser.peek() {
        Token::End => Ok(expression),
        _ => parser.unexpected("an operator or the end"),
    }
}

struct Parser<'a> {
    tokens: Vec<(Token, usize)>,
    next: usize,
    nesting: usize,
    text: &'a str,
}

impl Parser<'_> {
    fn peek(&self) -> &Token {
        self.tokens.get(self.next).map_or(&Token::End, |(token, _)| token)
    }

    fn is(&self, symbol: &str) -> bool {
        matches!(self.peek(), Token::Symbol(s) if *s == symbol)
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self.peek(), Token::Name(name) if &**name == word)
    }

    fn take(&mut self, symbol: &str) -> bool {
        let found = self.is(symbol);
        self.next += usize::from(found);
        found
    }

    fn take_word(&mut self, word: &str) -> bool {
        let found = self.is_word(word);
        self.next += usize::from(found);
        found
    }

    fn expect(&mut self, symbol: &str) -> Result<()> {
        if self.take(symbol) { Ok(()) } else { self.unexpected(&format!("`{symbol}`")) }
    }

    fn unexpected<T>(&self, expected: &str) -> Result<T> {
        let at = self.tokens.get(self.next).map_or(self.text.len(), |(_, at)| *at);
        match self.text[at..].trim() {
            "" => fail!("the expression ends too early: expected {expected}"),
            rest if self.is_word("for") || self.is_word("lambda") => {
                fail!("`{}`: loops and lambda in expressions are not supported", excerpt(rest))
            }
            rest => fail!("expected {expected} before `{}`", excerpt(rest)),
        }
    }

    fn grown(&self, height: usize) -> Result<usize> {
        if height >= MAX_HEIGHT {
            fail!("the expression has more than {MAX_HEIGHT} operators in a row");
        }
        Ok(height + 1)
    }

    /// One expression, or several with commas, which are a tuple.
    fn list_or_one(&mut self) -> Result<Tree> {
        let (first, height) = self.expression()?;
        if !self.is(",") {
            return Ok((first, height));
        }
        let (mut items, mut highest) = (vec![first], height);
        while self.take(",") {
            if matches!(self.peek(), Token::End) || self.is(")") || self.is("]") {
                break;
            }
            let (item, height) = self.expression()?;
            items.push(item);
            highest = highest.max(height);
        }
        Ok((Expression::Tuple(items), self.grown(highest)?))
    }

    fn expression(&mut self) -> Result<Tree> {
        if self.nesting >= MAX_NESTING {
            fail!("the expression is nested deeper than {MAX_NESTING}");
        }
        self.nesting += 1;
        let tree = self.choice();
        self.nesting -= 1;
        tree
    }

    fn choice(&mut self) -> Result<Tree> {
        let (yes, a) = self.operation(binding::OR)?;
        if !self.take_word("if") {
            return Ok((yes, a));
        }
        let (condition, b) = self.operation(binding::OR)?;
        if !self.take_word("else") {
            return self.unexpected("`else`");
        }
        let (no, c) = self.expression()?;
        Ok((Expression::Choice(Box::new([condition, yes, no])), self.grown(a.max(b).max(c))?))
    }

    /// Operators that bind at least as strongly as `weakest`, with their operands.
    fn operation(&mut self, weakest: u8) -> Result<Tree> {
        let (mut left, mut height) = self.prefixed(weakest)?;
        while let Some((operator, strength)) = self.infix() {
            if strength < weakest {
                break;
            }
            if strength == binding::COMPARISON {
                let mut chain = Vec::new();
                while let Some(comparator) = self.comparator() {
                    let (right, right_height) = self.operation(binding::BIT_OR)?;
                    height = height.max(right_height);
                    chain.push((comparator, right));
                }
                if chain.is_empty() {
                    return self.unexpected("an operator");
                }
                left = Expression::Comparison(Box::new((left, chain)));
                height = self.grown(height)?;
                continue;
            }
            self.next += 1;
            let least = if strength == binding::POWER { binding::SIGN } else { strength + 1 };
            let (right, right_height) = self.nested(|parser| parser.operation(least))?;
            height = self.grown(height.max(right_height))?;
            let both = Box::new((left, right));
            left = match (operator, strength) {
                (Some(operator), _) => Expression::Binary(operator, both),
                (None, binding::AND) => Expression::And(both),
                (None, _) => Expression::Or(both),
            };
        }
        Ok((left, height))
    }

    fn nested(&mut self, parse: impl FnOnce(&mut Self) -> Result<Tree>) -> Result<Tree> {
        if self.nesting >= MAX_NESTING {
            fail!("the expression is nested deeper than {MAX_NESTING}");
        }
        self.nesting += 1;
        let tree = parse(self);
        self.nesting -= 1;
        tree
    }

    fn prefixed(&mut self, weakest: u8) -> Result<Tree> {
        type Make = fn(Box<Expression>) -> Expression;
        let (make, strength): (Make, u8) = match self.peek() {
            Token::Symbol("-") => (Expression::Negative, binding::SIGN),
            Token::Symbol("+") => (Expression::Positive, binding::SIGN),
            Token::Symbol("~") => (Expression::Inverse, binding::SIGN),
            Token::Name(name) if &**name == "not" && weakest <= binding::NOT => (Expression::Not, binding::NOT),
            _ => return self.postfixed(),
        };
        self.next += 1;
        let (inner, height) = self.nested(|parser| parser.operation(strength))?;
        Ok((make(Box::new(inner)), self.grown(height)?))
    }

    /// The operator that follows, with its precedence; `None` for `and`, `or` and comparisons.
    fn infix(&self) -> Option<(Option<Operator>, u8)> {
        let found = match self.peek() {
            Token::Symbol("<" | "<=" | ">" | ">=" | "==" | "!=") => return Some((None, binding::COMPARISON)),
            Token::Symbol(symbol) => Operator::of_symbol(symbol)?,
            Token::Name(name) => match &**name {
                "or" => return Some((None, binding::OR)),
                "and" => return Some((None, binding::AND)),
                "in" | "is" | "not" => return Some((None, binding::COMPARISON)),
                _ => return None,
            },
            _ => return None,
        };
        Some((Some(found.0), found.1))
    }

    fn comparator(&mut self) -> Option<Comparator> {
        let simple = match self.peek() {
            Token::Symbol("<") => Comparator::Less,
            Token::Symbol("<=") => Comparator::LessEqual,
            Token::Symbol(">") => Comparator::Greater,
            Token::Symbol(">=") => Comparator::GreaterEqual,
            Token::Symbol("==") => Comparator::Equal,
            Token::Symbol("!=") => Comparator::NotEqual,
            Token::Name(name) => match &**name {
                "in" => Comparator::In,
                "is" => Comparator::Is,
                "not" => {
                    let is_in = matches!(self.tokens.get(self.next + 1), Some((Token::Name(n), _)) if &**n == "in");
                    self.next += usize::from(is_in) * 2;
                    return is_in.then_some(Comparator::NotIn);
                }
                _ => return None,
            },
            _ => return None,
        };
        self.next += 1;
        if simple == Comparator::Is && self.take_word("not") {
            return Some(Comparator::IsNot);
        }
        Some(simple)
    }

    /// A value with what follows it directly: calls, indices, attributes.
    fn postfixed(&mut self) -> Result<Tree> {
        let (mut tree, mut height) = self.atom()?;
        loop {
            if self.take(".") {
                let Token::Name(name) = self.peek().clone() else { return self.unexpected("a name") };
                self.next += 1;
                tree = Expression::Attribute(Box::new(tree), checked(name)?);
            } else if self.take("(") {
                let (call, inner) = self.call(tree)?;
                tree = Expression::Call(Box::new(call));
                height = height.max(inner);
            } else if self.take("[") {
                let (indexed, inner) = self.index(tree)?;
                tree = indexed;
                height = height.max(inner);
            } else {
                return Ok((tree, height));
            }
            height = self.grown(height)?;
        }
    }

    fn call(&mut self, function: Expression) -> Result<(Call, usize)> {
        let mut call = Call { function, arguments: Vec::new(), named: Vec::new() };
        let mut highest = 0;
        while !self.take(")") {
            if self.is("*") || self.is("**") {
                fail!("`*` and `**` in calls are not supported");
            }
            let is_named = matches!(self.tokens.get(self.next + 1), Some((Token::Symbol("="), _)));
            let name = match self.peek() {
                Token::Name(name) if is_named => Some(name.clone()),
                _ => None,
            };
            self.next += if name.is_some() { 2 } else { 0 };
            let (value, height) = self.expression()?;
            highest = highest.max(height);
            match name {
                Some(name) => call.named.push((name, value)),
                None if !call.named.is_empty() => fail!("an argument without a name follows one with a name"),
                None => call.arguments.push(value),
            }
            if !self.is(")") {
                self.expect(",")?;
            }
        }
        Ok((call, highest))
    }

    fn index(&mut self, of: Expression) -> Result<Tree> {
        let mut parts = [None, None, None];
        let (mut highest, mut count) = (0, 0);
        loop {
            if !self.is(":") && !self.is("]") {
                let (part, height) = if count == 0 { self.list_or_one()? } else { self.expression()? };
                highest = highest.max(height);
                parts[count] = Some(part);
            }
            if count < 2 && self.take(":") {
                count += 1;
                continue;
            }
            self.expect("]")?;
            break;
        }
        if count > 0 {
            return Ok((Expression::Slice(Box::new((of, parts))), highest));
        }
        match parts {
            [Some(part), ..] => Ok((Expression::Index(Box::new((of, part))), highest)),
            _ => fail!("the brackets [] are empty: expected an index"),
        }
    }

    fn atom(&mut self) -> Result<Tree> {
        let token = self.peek().clone();
        let value = match token {
            Token::Int(i) => Value::Int(i),
            Token::Float(f) => Value::Float(f),
            Token::Text(first) => {
                let mut text = first.to_string();
                self.next += 1;
                while let Token::Text(more) = self.peek() {
                    text.push_str(more);
                    self.next += 1;
                }
                return Ok((Expression::Value(Value::text(text)), 0));
            }
            Token::Name(name) => match &*name {
                "True" => Value::Bool(true),
                "False" => Value::Bool(false),
                "None" => Value::None,
                word if is_identifier(word) => {
                    self.next += 1;
                    return Ok((Expression::Name(checked(name)?), 0));
                }
                _ => return self.unexpected("a value"),
            },
            Token::Symbol("(") => return self.parenthesis(),
            Token::Symbol("[") => return self.list(),
            Token::Symbol("{") => return self.dict(),
            _ => return self.unexpected("a value"),
        };
        self.next += 1;
        Ok((Expression::Value(value), 0))
    }

    fn parenthesis(&mut self) -> Result<Tree> {
        self.next += 1;
        if self.take(")") {
            return Ok((Expression::Tuple(Vec::new()), 1));
        }
        let tree = self.list_or_one()?;
        self.expect(")")?;
        Ok(tree)
    }

    fn list(&mut self) -> Result<Tree> {
        self.next += 1;
        let (mut items, mut highest) = (Vec::new(), 0);
        while !self.take("]") {
            let (item, height) = self.expression()?;
            items.push(item);
            highest = highest.max(height);
            if !self.is("]") {
                self.expect(",")?;
            }
        }
        Ok((Expression::List(items), self.grown(highest)?))
    }

    fn dict(&mut self) -> Result<Tree> {
        self.next += 1;
        let (mut entries, mut highest) = (Vec::new(), 0);
        while !self.take("}") {
            let (key, key_height) = self.expression()?;
            self.expect(":")?;
            let (value, height) = self.expression()?;
            entries.push((key, value));
            highest = highest.max(height).max(key_height);
            if !self.is("}") {
                self.expect(",")?;
            }
        }
        Ok((Expression::Dict(entries), self.grown(highest)?))
    }
}

/// Refuses names that are Python's inner ones.
fn checked(name: Rc<str>) -> Result<Rc<str>> {
    if name.starts_with("__") {
        fail!("`{name}`: names that begin with two underscores are not allowed");
    }
    Ok(name)
}
