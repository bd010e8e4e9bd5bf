//! Bounds on what a file may cost, whatever it contains.

use crate::error::{Result, fail};

/// Bounds of an expansion. A file that exceeds one is refused with an error that names it.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Size of a source file in bytes.
    pub file_bytes: usize,
    /// Number of files that are read, counting each time.
    pub files: usize,
    /// Depth of includes.
    pub include_depth: usize,
    /// Depth of elements and of calls of macros, together.
    pub depth: usize,
    /// Work: about one unit for each part of an expression, each element, and each 8 bytes of text that are made.
    pub work: u64,
    /// Size of a string in an expression, or of the text of an attribute, in bytes.
    pub text_bytes: usize,
    /// Number of items in a list, dictionary or range.
    pub items: usize,
    /// Size of the result in bytes.
    pub result_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            file_bytes: 16 << 20,
            files: 2000,
            include_depth: 32,
            depth: 600,
            work: 8_000_000,
            text_bytes: 1 << 20,
            items: 100_000,
            result_bytes: 16 << 20,
        }
    }
}

/// Maximum depth of brackets and operators in an expression, and of lists in lists.
pub(crate) const MAX_NESTING: usize = 64;

/// Maximum depth of properties whose values use other properties.
const MAX_CHAIN: usize = 100;

/// Maximum depth of expressions, with those of the properties that they use.
const MAX_EXPRESSION_DEPTH: usize = 400;

/// What is left of the bounds.
pub(crate) struct Budget {
    pub limits: Limits,
    work: u64,
    depth: usize,
    chain: usize,
    expression_depth: usize,
}

impl Budget {
    pub fn new(limits: Limits) -> Self {
        Budget { work: limits.work, limits, depth: 0, chain: 0, expression_depth: 0 }
    }

    /// Accounts for work.
    pub fn spend(&mut self, units: usize) -> Result<()> {
        match self.work.checked_sub(units as u64) {
            Some(left) => self.work = left,
            None => {
                fail!("the file takes more than {} steps to expand: does a macro multiply itself?", self.limits.work)
            }
        }
        Ok(())
    }

    /// Accounts for a text that is made, before it is made.
    pub fn text(&mut self, bytes: usize) -> Result<()> {
        if bytes > self.limits.text_bytes {
            fail!("a text has {bytes} bytes, more than {}", self.limits.text_bytes);
        }
        self.spend(1 + bytes / 8)
    }

    /// Checks the size of a text to which a part was added, whose size is accounted for by itself.
    pub fn grown_text(&mut self, bytes: usize, part: usize) -> Result<()> {
        if bytes > self.limits.text_bytes {
            fail!("a text has more than {} bytes", self.limits.text_bytes);
        }
        self.spend(1 + part / 8)
    }

    /// Accounts for a list or dictionary that is made, before it is made.
    pub fn items(&mut self, count: usize) -> Result<()> {
        if count > self.limits.items {
            fail!("a list has {count} items, more than {}", self.limits.items);
        }
        self.spend(1 + count.saturating_mul(4))
    }

    /// Accounts for one more item in a list or dictionary that has `count`.
    pub fn another_item(&mut self, count: usize) -> Result<()> {
        if count >= self.limits.items {
            fail!("a list has more than {} items", self.limits.items);
        }
        self.spend(4)
    }

    /// Enters an element or a call; `leave` must follow if it succeeds.
    pub fn enter(&mut self) -> Result<()> {
        if self.depth >= self.limits.depth {
            fail!(
                "elements and calls of macros are nested deeper than {}: does a macro call itself without end?",
                self.limits.depth
            );
        }
        self.depth += 1;
        self.spend(1)
    }

    pub fn leave(&mut self) {
        self.depth = self.depth.saturating_sub(1);
    }

    /// Enters the value of a property; `leave_property` must follow if it succeeds.
    pub fn enter_property(&mut self) -> Result<()> {
        if self.chain >= MAX_CHAIN {
            fail!(
                "more than {MAX_CHAIN} properties use one another in a chain: set lazy_eval=\"false\" for those that are \
                 counted up"
            );
        }
        self.chain += 1;
        self.spend(1)
    }

    pub fn leave_property(&mut self) {
        self.chain = self.chain.saturating_sub(1);
    }

    /// Enters a part of an expression; `leave_expression` must follow if it succeeds.
    pub fn enter_expression(&mut self) -> Result<()> {
        if self.expression_depth >= MAX_EXPRESSION_DEPTH {
            fail!("the expression and the properties that it uses are nested deeper than {MAX_EXPRESSION_DEPTH}");
        }
        self.expression_depth += 1;
        self.spend(1)
    }

    pub fn leave_expression(&mut self) {
        self.expression_depth = self.expression_depth.saturating_sub(1);
    }
}
