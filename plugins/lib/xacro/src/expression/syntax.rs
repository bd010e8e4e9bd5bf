//! The tree of an expression.

use std::rc::Rc;

use crate::value::Value;

#[derive(Clone, Debug)]
pub(super) enum Expression {
    Value(Value),
    Name(Rc<str>),
    /// `a.name`
    Attribute(Box<Expression>, Rc<str>),
    /// `a[b]`
    Index(Box<(Expression, Expression)>),
    /// `a[b:c:d]`
    Slice(Box<(Expression, [Option<Expression>; 3])>),
    Call(Box<Call>),
    Negative(Box<Expression>),
    Positive(Box<Expression>),
    /// `~a`
    Inverse(Box<Expression>),
    Not(Box<Expression>),
    Binary(Operator, Box<(Expression, Expression)>),
    /// `a < b <= c`
    Comparison(Box<(Expression, Vec<(Comparator, Expression)>)>),
    And(Box<(Expression, Expression)>),
    Or(Box<(Expression, Expression)>),
    /// `yes if condition else no`, as condition, yes, no
    Choice(Box<[Expression; 3]>),
    List(Vec<Expression>),
    Tuple(Vec<Expression>),
    Dict(Vec<(Expression, Expression)>),
}

#[derive(Clone, Debug)]
pub(super) struct Call {
    pub function: Expression,
    pub arguments: Vec<Expression>,
    pub named: Vec<(Rc<str>, Expression)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    FloorDivide,
    Remainder,
    Power,
    BitOr,
    BitXor,
    BitAnd,
    ShiftLeft,
    ShiftRight,
}

impl Operator {
    pub fn symbol(self) -> &'static str {
        match self {
            Operator::Add => "+",
            Operator::Subtract => "-",
            Operator::Multiply => "*",
            Operator::Divide => "/",
            Operator::FloorDivide => "//",
            Operator::Remainder => "%",
            Operator::Power => "**",
            Operator::BitOr => "|",
            Operator::BitXor => "^",
            Operator::BitAnd => "&",
            Operator::ShiftLeft => "<<",
            Operator::ShiftRight => ">>",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparator {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    In,
    NotIn,
    Is,
    IsNot,
}
