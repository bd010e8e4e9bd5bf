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

/// Precedence of operators, from the weakest.
pub(super) mod binding {
    pub const OR: u8 = 1;
    pub const AND: u8 = 2;
    pub const NOT: u8 = 3;
    pub const COMPARISON: u8 = 4;
    pub const BIT_OR: u8 = 5;
    pub const BIT_XOR: u8 = 6;
    pub const BIT_AND: u8 = 7;
    pub const SHIFT: u8 = 8;
    pub const SUM: u8 = 9;
    pub const PRODUCT: u8 = 10;
    pub const SIGN: u8 = 11;
    pub const POWER: u8 = 12;
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
    /// The operator of a symbol, with its precedence.
    pub fn of_symbol(symbol: &str) -> Option<(Self, u8)> {
        Some(match symbol {
            "+" => (Operator::Add, binding::SUM),
            "-" => (Operator::Subtract, binding::SUM),
            "*" => (Operator::Multiply, binding::PRODUCT),
            "/" => (Operator::Divide, binding::PRODUCT),
            "//" => (Operator::FloorDivide, binding::PRODUCT),
            "%" => (Operator::Remainder, binding::PRODUCT),
            "**" => (Operator::Power, binding::POWER),
            "|" => (Operator::BitOr, binding::BIT_OR),
            "^" => (Operator::BitXor, binding::BIT_XOR),
            "&" => (Operator::BitAnd, binding::BIT_AND),
            "<<" => (Operator::ShiftLeft, binding::SHIFT),
            ">>" => (Operator::ShiftRight, binding::SHIFT),
            _ => return None,
        })
    }

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
