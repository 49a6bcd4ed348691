//! Values as the machine holds them: a tag and up to three words of payload, copied freely.
//!
//! What does not fit lives in the heap of the machine, and a word says where. So copying counts
//! nothing, dropping does nothing, and machines on different threads share nothing that they write.

use compiler::op::Type;
use compiler::scalar::{Operands, Point};

use crate::value::Value;

/// What a word holds.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Tag {
    Bool,
    Int,
    Real,
    Point,
    Closure,
    Array,
    Str,
    Object,
    Light,
    /// In the heap only: what stands before the words of a closure or an array.
    Header,
}

/// A value, or part of the heap. What the payload means depends on the tag; of numbers only `x` is
/// written and copied.
#[derive(Clone, Copy)]
pub(crate) struct Word {
    pub(crate) tag: Tag,
    pub(crate) x: u64,
    pub(crate) y: u64,
    pub(crate) z: u64,
}

impl Word {
    /// A number of no meaning.
    pub(crate) const NOTHING: Word = Word::new(Tag::Bool, 0);

    #[inline(always)]
    pub(crate) const fn new(tag: Tag, x: u64) -> Self {
        Word { tag, x, y: 0, z: 0 }
    }

    /// Overwrites the word field by field: a copy of all its bytes would wait for the parts that
    /// have just been written.
    #[inline(always)]
    pub(crate) fn set(&mut self, from: &Word) {
        (self.tag, self.x) = (from.tag, from.x);
        if from.tag == Tag::Point {
            (self.y, self.z) = (from.y, from.z);
        }
    }

    /// Whether it refers to a value from outside that the heap holds.
    pub(crate) fn is_foreign(self) -> bool {
        matches!(self.tag, Tag::Str | Tag::Object | Tag::Light)
    }

    /// Where in the heap it refers to.
    #[inline(always)]
    pub(crate) fn address(self) -> usize {
        self.x as usize
    }

    #[inline(always)]
    pub(crate) fn as_bool(self) -> Option<bool> {
        (self.tag == Tag::Bool).then_some(self.x != 0)
    }

    /// The type of a value.
    pub(crate) fn type_of(self) -> Type {
        match self.tag {
            Tag::Bool => Type::Bool,
            Tag::Int => Type::Int,
            Tag::Real => Type::Real,
            Tag::Point => Type::Point,
            Tag::Closure => Type::Closure,
            Tag::Array => Type::Array,
            Tag::Str => Type::Str,
            Tag::Object => Type::Object,
            Tag::Light => Type::Light,
            Tag::Header => Type::Any,
        }
    }

    /// The value, if it does not refer to the heap.
    pub(crate) fn to_scalar(self) -> Option<Value> {
        Some(match self.tag {
            Tag::Bool => Value::Bool(self.x != 0),
            Tag::Int => Value::Int(self.x as i64),
            Tag::Real => Value::Real(f64::from_bits(self.x)),
            Tag::Point => Value::Point([self.x, self.y, self.z].map(f64::from_bits)),
            _ => return None,
        })
    }
}

impl Operands for Word {
    #[inline(always)]
    fn from_bool(value: bool) -> Self {
        Word::new(Tag::Bool, u64::from(value))
    }
    #[inline(always)]
    fn from_int(value: i64) -> Self {
        Word::new(Tag::Int, value as u64)
    }
    #[inline(always)]
    fn from_real(value: f64) -> Self {
        Word::new(Tag::Real, value.to_bits())
    }
    #[inline(always)]
    fn from_point(value: Point) -> Self {
        let [x, y, z] = value.map(f64::to_bits);
        Word { tag: Tag::Point, x, y, z }
    }
    #[inline(always)]
    fn as_int(&self) -> Option<i64> {
        (self.tag == Tag::Int).then_some(self.x as i64)
    }
    #[inline(always)]
    fn as_real(&self) -> Option<f64> {
        (self.tag == Tag::Real).then_some(f64::from_bits(self.x))
    }
    #[inline(always)]
    fn as_point(&self) -> Option<Point> {
        (self.tag == Tag::Point).then_some([self.x, self.y, self.z].map(f64::from_bits))
    }
}
