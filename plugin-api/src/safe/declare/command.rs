//! Commands: declared once, and callable from every script language, remote client and plugin.

use std::{ffi::c_void, ptr::null};

use crate::abi::*;
use crate::safe::{
    Call, IntoResult, Param, Plugin, Result, SharedCall, Value,
    call::running::{call_exclusive, call_shared},
    declare::plugin::{Command, CommandFunction, CommandNameSpec, ExclusiveFn, SharedFn, Status},
    value::table_arena::TableArena,
};

impl<P: Plugin> Command<P> {
    /// Creates a command with its first name and its function, which worlds on several threads may call concurrently.
    /// If the function uses [`Call::instance`] or [`SharedCall::plugin`], the compiler needs the type of the plugin:
    /// `Command::<Self>::new(...)`.
    ///
    /// A function that may wait returns [`Outcome::Done`](crate::safe::Outcome), or the result of `wait_steps` or
    /// another `wait_*` function, which is `Outcome::Waiting`:
    ///
    /// ```
    /// # use tatu_plugin_api::safe::*;
    /// # fn offer<P: Plugin>(offer: &mut Offer<P>) {
    /// offer.command(Command::<P>::new("mine.later", |c| {
    ///     if c.resumed() == 0 {
    ///         return c.wait_steps(10, 1); // called again with `resumed() == 1`, and without arguments
    ///     }
    ///     c.ret("ten steps later");
    ///     Ok(Outcome::Done)
    /// }));
    /// # }
    /// ```
    pub fn new<T: IntoResult + 'static>(
        name: impl Into<String>,
        run: impl Fn(&mut Call<'_, P>) -> Result<T> + Send + Sync + 'static,
    ) -> Self {
        Self::with(
            name.into(),
            CommandFunction::Exclusive(Box::new(move |call| run(call).map(IntoResult::into_outcome))),
        )
    }
    /// Creates a command that may also be called by scripts that run in parallel, on several threads at once. It can
    /// read the world, but change only the drives of joints, with [`SharedWorld::set`](crate::safe::SharedWorld::set).
    pub fn side_by_side<T: IntoResult + 'static>(
        name: impl Into<String>,
        run: impl Fn(&mut SharedCall<'_, P>) -> Result<T> + Send + Sync + 'static,
    ) -> Self {
        Self::with(name.into(), CommandFunction::Shared(Box::new(move |call| run(call).map(IntoResult::into_outcome))))
    }
    fn with(name: String, run: CommandFunction<P>) -> Self {
        Command {
            names: vec![CommandNameSpec { name, on_error: None, until: None }],
            params: Vec::new(),
            returns: Vec::new(),
            text: String::new(),
            example: String::new(),
            no_wait: None,
            raw: false,
            status: Status::Full,
            notes: String::new(),
            subject: String::new(),
            run,
        }
    }
    /// Adds an alternative name.
    pub fn alias(mut self, name: impl Into<String>) -> Self {
        self.names.push(CommandNameSpec { name: name.into(), on_error: None, until: None });
        self
    }
    /// Adds an old name. If a call by this name fails, the error is logged, and `on_error` is returned instead.
    pub fn old_name(mut self, name: impl Into<String>, on_error: impl Into<Vec<Value>>) -> Self {
        self.names.push(CommandNameSpec { name: name.into(), on_error: Some(on_error.into()), until: None });
        self
    }
    /// Sets the first dialect whose scripts receive the errors of calls by old names, instead of the values of
    /// `on_error`.
    pub fn old_names_until(mut self, dialect: &str) -> Self {
        self.names.iter_mut().filter(|n| n.on_error.is_some()).for_each(|n| n.until = Some(dialect.into()));
        self
    }
    /// Marks the command as partial; `notes` describe what is missing.
    pub fn partial(mut self, notes: impl Into<String>) -> Self {
        (self.status, self.notes) = (Status::Partial, notes.into());
        self
    }
    /// Marks the command as a stub that returns a neutral value; `notes` give the reason.
    pub fn stub(mut self, notes: impl Into<String>) -> Self {
        (self.status, self.notes) = (Status::Stub, notes.into());
        self
    }
    /// Adds a note for users about differences from the documented behaviour; the command remains complete.
    pub fn notes(mut self, notes: impl Into<String>) -> Self {
        self.notes = notes.into();
        self
    }
    /// Sets the command's subject, one word, unless it is already set.
    pub fn subject(mut self, subject: &str) -> Self {
        if self.subject.is_empty() {
            self.subject = subject.into();
        }
        self
    }
    /// Returns the command's first name.
    pub fn name(&self) -> &str {
        &self.names[0].name
    }
    /// Returns whether the command has an example.
    pub fn has_example(&self) -> bool {
        !self.example.is_empty()
    }
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|n| n.name.as_str())
    }
    /// Adds the next parameter.
    pub fn param(mut self, param: Param) -> Self {
        self.params.push(param);
        self
    }
    /// Passes arguments without checks or conversion; declared parameters are then documentation only.
    pub fn raw(mut self) -> Self {
        self.raw = true;
        self
    }
    /// Adds the next result.
    pub fn returns(mut self, param: Param) -> Self {
        self.returns.push(param);
        self
    }
    /// Sets the command's description, one sentence.
    pub fn text(mut self, text: impl Into<String>) -> Self {
        self.text = text.into();
        self
    }
    /// Sets an example in Lua, which must raise an error if the command has no effect.
    pub fn example(mut self, example: impl Into<String>) -> Self {
        self.example = example.into();
        self
    }
    /// Sets the error message for callers that cannot wait: what is not possible, and what to do instead.
    pub fn no_wait(mut self, text: impl Into<String>) -> Self {
        self.no_wait = Some(text.into());
        self
    }

    pub(crate) fn into_table(self, keep: &mut TableArena) -> *const tatu_command {
        let names = self
            .names
            .iter()
            .map(|n| {
                let raw = tatu_name {
                    size: size_of::<tatu_name>() as u32,
                    flags: if n.on_error.is_some() { TATU_NAME_OLD_ERRORS } else { 0 },
                    name: keep.text(&n.name),
                    n_on_error: n.on_error.as_ref().map_or(0, |v| v.len() as u32),
                    reserved: 0,
                    on_error: n.on_error.as_ref().map_or(null(), |v| keep.values(v)),
                    on_error_until: n.until.as_ref().map_or(null(), |u| keep.text(u)),
                };
                keep.table(raw)
            })
            .collect();
        let params = self.params.iter().map(|p| p.to_table(keep)).collect();
        let returns = self.returns.iter().map(|p| p.to_table(keep)).collect();
        let side_by_side = matches!(self.run, CommandFunction::Shared(_));
        let (user, call): (*const c_void, unsafe extern "C" fn(*mut tatu_call) -> tatu_status) = match self.run {
            CommandFunction::Exclusive(run) => (keep.table::<ExclusiveFn<P>>(run).cast(), call_exclusive::<P>),
            CommandFunction::Shared(run) => (keep.table::<SharedFn<P>>(run).cast(), call_shared::<P>),
        };
        let raw = tatu_command {
            size: size_of::<tatu_command>() as u32,
            flags: if self.raw { TATU_COMMAND_RAW } else { 0 }
                | if side_by_side { TATU_COMMAND_SIDE_BY_SIDE } else { 0 },
            names: keep.list(names),
            params: keep.list(params),
            returns: keep.list(returns),
            text: keep.text(&self.text),
            example: keep.text(&self.example),
            no_wait: self.no_wait.as_ref().map_or(null(), |t| keep.text(t)),
            user,
            call: Some(call),
            status: self.status as u32,
            reserved: 0,
            notes: if self.notes.is_empty() { null() } else { keep.text(&self.notes) },
            subject: if self.subject.is_empty() { null() } else { keep.text(&self.subject) },
        };
        keep.table(raw)
    }
}

/// A named constant for scripts.
#[derive(Debug, Clone)]
pub struct Constant {
    pub(crate) name: String,
    pub(crate) value: Value,
}

impl Constant {
    /// Creates a constant.
    pub fn new(name: impl Into<String>, value: impl Into<Value>) -> Self {
        Constant { name: name.into(), value: value.into() }
    }
}
