//! Diagnostics as data: what is wrong, where, and what would help.
//!
//! Rendering (terminal, one line, JSON) is the driver's business. Every diagnostic has a [`Code`]
//! from the one table below, which also holds the paragraph that `gmlvm explain CODE` prints.

use crate::source::Span;

/// What the process tells its caller when it ends with a diagnostic of this class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The GML program is wrong: exit 1.
    Program,
    /// The command line is wrong or the scene cannot be read: exit 2.
    Usage,
    /// An output could not be written: exit 3.
    Output,
    /// A limit was reached: exit 4.
    Limit,
    /// Refused by policy: exit 5.
    Policy,
}

macro_rules! codes {
    ($($(#[doc = $title:literal])+ $name:ident = $code:literal $class:ident $text:literal;)*) => {
        /// Identifies one kind of diagnostic, for ever.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Code { $($(#[doc = $title])+ $name,)* }

        impl Code {
            /// Every code, in the order of the table.
            pub const ALL: &[Code] = &[$(Code::$name,)*];

            /// The code as shown, such as `E0102`.
            #[must_use]
            pub fn as_str(self) -> &'static str {
                match self { $(Code::$name => $code,)* }
            }

            /// One line: what this code is about.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self { $(Code::$name => concat!($($title),+).trim_ascii(),)* }
            }

            /// The paragraph that `gmlvm explain` prints.
            #[must_use]
            pub fn explanation(self) -> &'static str {
                match self { $(Code::$name => $text,)* }
            }

            /// What kind of failure this is.
            #[must_use]
            pub fn class(self) -> Class {
                match self { $(Code::$name => Class::$class,)* }
            }
        }
    };
}

codes! {
    /// Character outside the GML character set
    BadCharacter = "E0001" Program
        "Outside strings and comments a GML program consists of letters, digits, white space and \
         the characters `- _ . / \" % [ ] { }`. A lone `-` or `.` is an error too: a real number \
         needs a digit on both sides of its point, and there is no `+` sign.";
    /// Malformed string
    BadString = "E0002" Program
        "A string runs from one `\"` to the next and holds printable ASCII characters only. It \
         has no escapes, and neither a line break nor a tab may stand in it.";
    /// Number out of range
    BadNumber = "E0003" Program
        "Integers are 64-bit two's complement numbers, reals IEEE 754 doubles. A literal outside \
         the range is an error, never a silently different number.";
    /// Binder without an identifier
    BadBinder = "E0004" Program
        "`/` starts a binder and must be followed at once by an identifier, as in `/radius`.";
    /// Reserved word bound
    ReservedBinder = "E0005" Program
        "The names of the 50 operators, `true` and `false` cannot be bound. Only the exact name \
         is reserved: `/sphere` is an error, `/Sphere` and `/sphere2` are not.";
    /// Brackets do not match
    BracketMismatch = "E0006" Program
        "`{` must be closed by `}` and `[` by `]`, properly nested. The message shows both ends.";
    /// Bracket never closed
    BracketUnclosed = "E0007" Program
        "The program ends inside a function or an array. The message shows where it was opened.";
    /// Brackets nested too deeply
    NestingTooDeep = "E0008" Limit
        "Functions and arrays nest more deeply in the text than gmlvm allows. This concerns the \
         source text only; how deeply a program calls itself is a limit of its own (E0402).";
    /// Bad preprocessor line
    BadDirective = "E0009" Program
        "A line that starts with `#` is a preprocessor line. gmlvm knows `#include \"file\"`, \
         `#define NAME`, `#undef NAME`, `#ifdef NAME`, `#ifndef NAME`, `#else` and `#endif`, and \
         skips `#line` and `# 12 \"file\"` marks. Macros are not expanded.";
    /// Included file cannot be read
    IncludeNotFound = "E0010" Program
        "`#include \"file\"` looks beside the including file, then in each `-I` directory. The \
         name must be relative and must not contain `..`, so that a scene cannot read what lies \
         outside; name other directories with `-I`.";
    /// Files include one another in a circle
    IncludeCycle = "E0011" Program
        "A file includes itself, directly or through others, and no `#ifndef` guard stops it.";
    /// Comment never closed
    CommentUnclosed = "E0012" Program
        "A `/*` comment has no `*/`. Comments from `%` to the end of the line need none.";
    /// Source text too long
    SourceTooLarge = "E0013" Limit
        "A program may have 64 MiB of source text and 4 194 304 words, each included file counted as \
         often as it is included.";
    /// Program too large for the bytecode
    ProgramTooLarge = "E0014" Limit
        "A program may have at most 2^24 functions, and each of them 2^24 instructions, constants and \
         slots. What the functions of a program capture, counted for each of them, may be 65 536 \
         values and two for each of its words.";
    /// Too few values on the stack
    StackUnderflow = "E0101" Program
        "An operator or a binder needs more values than there are. Code between `[` and `]` runs \
         on a fresh stack and cannot reach the values outside.";
    /// Name is not bound
    Unbound = "E0102" Program
        "The name has no value here. A function sees the bindings made before it was created, \
         bindings made inside `{ }` or `[ ]` end there, and a function cannot call itself by \
         name: pass it to itself, as in `5 fact fact apply`.";
    /// Operand of the wrong type
    TypeMismatch = "E0201" Program
        "An operator got a value of another type than it takes. There is no implicit conversion: \
         the integer operators end in `i`, those for reals in `f`; `real` turns an integer into a \
         real and `floor` a real into an integer.";
    /// Surface function with a wrong result
    SurfaceResult = "E0203" Program
        "A surface function is called with face, u and v on an otherwise empty stack (v on top) \
         and must leave exactly four values: the colour (a point) and the reals kd, ks and n, \
         with the Phong exponent n on top.";
    /// Integer overflow
    IntegerOverflow = "E0301" Program
        "The result does not fit in a 64-bit integer. gmlvm reports this and never wraps around.";
    /// Division by zero
    DivisionByZero = "E0302" Program
        "`divi` and `modi` have no result for a divisor of 0. (`divf` by 0.0 gives an infinity or \
         NaN, as IEEE 754 has it.)";
    /// Square root of a negative number
    NegativeRoot = "E0303" Program
        "`sqrt` takes a real that is not negative.";
    /// Subscript out of range
    Subscript = "E0304" Program
        "`get` takes an index from 0 to the array's length - 1.";
    /// No such integer
    FloorRange = "E0305" Program
        "`floor` of NaN, of an infinity, or of a real beyond 64-bit integers has no result.";
    /// Impossible transform
    BadTransform = "E0306" Program
        "A transform must be invertible and finite: no scale factor may be 0, no operand NaN or \
         infinite, and the product of all transforms must stay in the range of real numbers.";
    /// Bad operand of render
    BadRender = "E0307" Program
        "`render` takes, from the top of the stack: the file name, height and width (at least 1), \
         the horizontal field of view in degrees (above 0, below 180), the depth, the object, \
         then for the Chicago dialect the attenuation point, the array of lights, and the \
         ambient light.";
    /// Side effect in a surface function
    RenderInSurface = "E0308" Program
        "`render` cannot be used while an image is being rendered.";
    /// Instruction limit reached
    FuelLimit = "E0401" Limit
        "The program, or one call of a surface function, ran longer than `--fuel` allows. Most \
         often a recursion lacks its end.";
    /// Call depth limit reached
    DepthLimit = "E0402" Limit
        "More calls were active at once than `--max-depth` allows. A call in tail position (the \
         last thing a function does) does not count.";
    /// Memory limit reached
    MemoryLimit = "E0403" Limit
        "The program's values need more memory than `--max-memory` allows.";
    /// Image or scene size limit reached
    SizeLimit = "E0404" Limit
        "The image has more pixels than `--max-pixels` allows, the scene more solids than fit in \
         `--max-memory`, the program renders more images than `--max-images`, or light may be \
         reflected more often than `--max-reflections`: between two mirrors it would be.";
    /// Time limit reached
    TimeLimit = "E0405" Limit
        "The whole run took longer than `--timeout` allows. What was finished by then stays; the image \
         that was being rendered is not written.";
    /// File name refused
    RefusedPath = "E0501" Policy
        "The scene names its image files, and scenes are not trusted: the name must be relative, \
         stay below the output directory, follow no symbolic link, hold no control characters, \
         have no component that starts with a point, and not be that of another file than an \
         image. `--output NAME` replaces the scene's name by yours.";
    /// Output cannot be written
    CannotWrite = "E0601" Output
        "The image could not be written. It is written under a temporary name beside its target \
         and renamed when complete, so that nothing half-written is left behind.";
}

/// A place to show, with a short text beside the caret (may be empty).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is there: lower case, no full stop.
    pub text: String,
}

/// An active call at the time of an error, outermost first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceEntry {
    /// The place of the call.
    pub span: Span,
    /// Where that place is: `the main program`, `` `tree` ``, `a surface function`.
    pub within: String,
    /// How many times the entry stands in a row.
    pub repeats: usize,
}

/// One thing that is wrong with a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Which kind.
    pub code: Code,
    /// What is the case, then what was wanted: lower case, no full stop, code in back-ticks.
    pub message: String,
    /// The place that the message is about.
    pub primary: Label,
    /// Other places that matter.
    pub secondary: Vec<Label>,
    /// Calls that led here, outermost first.
    pub trace: Vec<TraceEntry>,
    /// Facts that explain.
    pub notes: Vec<String>,
    /// What to do, at most two.
    pub helps: Vec<String>,
}

impl Diagnostic {
    /// A diagnostic with nothing but a message and a place.
    #[must_use]
    pub fn new(code: Code, span: Span, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            message: message.into(),
            primary: Label { span, text: String::new() },
            secondary: Vec::new(),
            trace: Vec::new(),
            notes: Vec::new(),
            helps: Vec::new(),
        }
    }

    /// Sets the text beside the primary caret.
    #[must_use]
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.primary.text = text.into();
        self
    }

    /// Adds another place.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Self {
        self.secondary.push(Label { span, text: text.into() });
        self
    }

    /// Adds a fact.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// Adds advice.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.helps.push(text.into());
        self
    }
}

/// A number as messages show it, its digits in groups of three.
#[must_use]
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (idx, digit) in digits.chars().enumerate() {
        if idx > 0 && (digits.len() - idx).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        assert_eq!([1, 999, 1000, 1_234_567].map(grouped), ["1", "999", "1 000", "1 234 567"]);
    }
}
