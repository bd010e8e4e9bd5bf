//! Texts with `${...}` and `$(...)`.

use std::rc::Rc;

use super::Expander;
use crate::{
    error::{Fault, Origin, Result, excerpt, fail},
    expression::{
        context::{Context, Severity},
        evaluation::evaluate,
    },
    limits::Budget,
    template::{Piece, pieces},
    value::{
        Value,
        number::{float_from_text, int_from_text},
        text::to_text,
    },
};

/// Commands in `$(...)`.
const COMMANDS: [&str; 5] = ["find", "env", "optenv", "dirname", "arg"];

impl Expander<'_> {
    /// The value of a text at a place: that of its only expression, or a text.
    pub(super) fn value_at(&mut self, text: &str, origin: Origin) -> Result<Value> {
        let outer = std::mem::replace(&mut self.origin, origin);
        let value = self.value_of(text).map_err(|fault| fault.at(origin));
        self.origin = outer;
        value
    }

    /// A text at a place, with all parts evaluated.
    pub(super) fn text_at(&mut self, text: &str, origin: Origin) -> Result<Rc<str>> {
        let value = self.value_at(text, origin)?;
        to_text(&value, &mut self.budget).map_err(|fault| fault.at(origin))
    }

    pub(super) fn value_of(&mut self, text: &str) -> Result<Value> {
        self.budget.text(text.len())?;
        if !text.contains('$') {
            return Ok(Value::text(text));
        }
        let pieces = pieces(text)?;
        if let [piece] = pieces.as_slice() {
            return self.value_of_piece(*piece);
        }
        let mut out = String::new();
        for piece in pieces {
            let value = self.value_of_piece(piece)?;
            let part = to_text(&value, &mut self.budget).map_err(|fault| fault.at(self.origin))?;
            out.push_str(&part);
            self.budget.grown_text(out.len(), part.len())?;
        }
        Ok(Value::text(out))
    }

    fn value_of_piece(&mut self, piece: Piece<'_>) -> Result<Value> {
        match piece {
            Piece::Text(text) => Ok(Value::text(text)),
            Piece::Expression(inner) => {
                let result = self.inner_text(inner).and_then(|text| evaluate(text.trim(), self));
                let hint = if inner.contains('{') { " (it ends at the first `}`)" } else { "" };
                result.map_err(|fault| self.located(fault, &format!("${{{}}}{hint}", excerpt(inner))))
            }
            Piece::Substitution(inner) => {
                let result = self.inner_text(inner).and_then(|text| self.substitution(&text));
                result.map(Value::text).map_err(|fault| self.located(fault, &format!("$({})", excerpt(inner))))
            }
        }
    }

    /// What is between brackets may contain `$(...)` itself.
    fn inner_text(&mut self, inner: &str) -> Result<Rc<str>> {
        if !inner.contains('$') {
            return Ok(inner.into());
        }
        self.budget.enter_expression()?;
        let value = self.value_of(inner);
        self.budget.leave_expression();
        to_text(&value?, &mut self.budget)
    }

    /// Adds the expression and the place to an error that has none.
    fn located(&self, mut fault: Box<Fault>, expression: &str) -> Box<Fault> {
        if fault.origin.is_none() {
            fault.message = format!("{expression}: {}", fault.message);
        }
        fault.at(self.origin)
    }

    /// The value of `$(text)`.
    fn substitution(&mut self, text: &str) -> Result<String> {
        if let Some(expression) = text.strip_prefix("eval ") {
            if expression.contains("__") {
                fail!("two underscores are not allowed in $(eval ...)");
            }
            let value = evaluate(expression, &mut WithArguments(self))?;
            return to_text(&value, &mut self.budget).map(|text| text.to_string());
        }
        if text.is_empty() {
            return Ok("$()".to_owned());
        }
        if text.contains(['$', '(', ')']) {
            fail!("`$` and brackets are not possible in $(...)");
        }
        let resolved = self.command(text)?;
        self.found_packages(&resolved)
    }

    fn command(&mut self, text: &str) -> Result<String> {
        let mut words = text.split(' ').filter(|word| !word.is_empty());
        let command = words.next().unwrap_or("");
        let rest: Vec<&str> = words.collect();
        match (command, rest.as_slice()) {
            ("find", [package]) => self.package(package),
            ("arg", [name]) => Ok(to_text(&self.argument(name)?, &mut self.budget)?.to_string()),
            ("env", [name]) => fail!(
                "environment variables such as {name} are not read, so that a file gives the same everywhere: write \
                 $(optenv {name} DEFAULT) or an argument"
            ),
            ("optenv", [name, default @ ..]) => {
                let default = default.join(" ");
                let message = format!(
                    "environment variables are not read: for {name}, its default \"{}\" is used",
                    excerpt(&default)
                );
                self.add_note("environment", &message);
                Ok(default)
            }
            ("cwd" | "dirname", []) => {
                fail!("it depends on the folder of the program: write a relative path, or $(find PACKAGE)")
            }
            ("find" | "arg" | "env", _) => fail!("{command} takes one name"),
            _ => fail!("expected find, arg, optenv or eval"),
        }
    }

    fn package(&mut self, name: &str) -> Result<String> {
        match self.files.package(name) {
            Some(text) => Ok(text),
            None => fail!("the package {name} is not found"),
        }
    }

    /// Replaces `$(find ...)` in a value, such as one of an argument.
    fn found_packages(&mut self, text: &str) -> Result<String> {
        let mut out = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("$(") {
            let Some((inner, end)) = after.split_once(')') else { break };
            out.push_str(before);
            let words: Vec<&str> = inner.split(' ').filter(|word| !word.is_empty()).collect();
            match words.as_slice() {
                ["find", package] => out.push_str(&self.package(package)?),
                [command, ..] if COMMANDS.contains(command) => {
                    out.push_str("$(");
                    out.push_str(inner);
                    out.push(')');
                }
                _ => fail!("`$({})` in a value: expected find", excerpt(inner)),
            }
            self.budget.grown_text(out.len(), inner.len())?;
            rest = end;
        }
        out.push_str(rest);
        Ok(out)
    }
}

/// What expressions in `$(eval ...)` see: arguments as variables, no properties.
struct WithArguments<'a, 'b>(&'a mut Expander<'b>);

impl Context for WithArguments<'_, '_> {
    fn budget(&mut self) -> &mut Budget {
        &mut self.0.budget
    }

    fn property(&mut self, name: &str) -> Result<Option<Value>> {
        match name {
            "true" => return Ok(Some(Value::Bool(true))),
            "false" => return Ok(Some(Value::Bool(false))),
            _ if crate::expression::is_global(name) => return Ok(None),
            _ => {}
        }
        let value = self.0.arguments.get(name).cloned();
        if value.is_some() {
            self.0.known_arguments.insert(name.to_owned());
        }
        Ok(value.map(|text| typed(&text)))
    }

    fn property_in(&mut self, _: usize, _: &str) -> Result<Option<Value>> {
        Ok(None)
    }

    fn argument(&mut self, name: &str) -> Result<Value> {
        self.0.argument(name)
    }

    fn file_name(&mut self, name: &str) -> String {
        self.0.file_name(name)
    }

    fn load_yaml(&mut self, _: &str) -> Result<Value> {
        fail!("load_yaml() is not possible in $(eval ...)")
    }

    fn say(&mut self, severity: Severity, text: &str) {
        self.0.say(severity, text);
    }

    fn note(&mut self, kind: &'static str, text: &str) {
        self.0.note(kind, text);
    }
}

/// The value of an argument in `$(eval ...)`: a number or a truth value if it is written as one.
fn typed(text: &str) -> Value {
    let number = match text.contains('.') {
        true => float_from_text(text).map(Value::Float),
        false => int_from_text(text).map(Value::Int),
    };
    number.unwrap_or_else(|| match text.to_lowercase().as_str() {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => Value::text(text),
    })
}
