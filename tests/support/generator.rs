//! Random GML surface functions that are well typed by construction, mostly, and always end.
//!
//! A program binds some values, which the function captures, and leaves the function on the stack.
//! Now and then an expression of a wrong type or an index out of range is put in: what then happens
//! must be the same everywhere too.

use std::fmt::Write;

/// A sequence of numbers that looks random; the seed names the program.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    pub(crate) fn next(&mut self) -> u64 {
        // xorshift64* (Vigna 2016).
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        (self.next() >> 33) % n
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }
}

/// The types that expressions are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Real,
    Int,
    Bool,
    Point,
    /// From real to real.
    Function,
    /// Of reals, of this length.
    Reals(u64),
    /// Of functions, of this length.
    Functions(u64),
}

/// A program that leaves a surface function.
pub(crate) fn program(seed: u64) -> String {
    let mut generator =
        Generator { random: Random::new(seed), text: String::new(), names: Vec::new(), n_names: 0 };
    for _ in 0..generator.random.below(6) {
        generator.binding(2);
    }
    generator.text.push_str("\n{ /v /u /face\n");
    let outside = generator.names.clone();
    for (name, ty) in [("v", Type::Real), ("u", Type::Real), ("face", Type::Int)] {
        generator.names.push((name.to_owned(), ty));
    }
    for _ in 0..generator.random.below(5) {
        generator.binding(3);
    }
    generator.expression(Type::Point, 4);
    for _ in 0..3 {
        generator.expression(Type::Real, 3);
    }
    generator.names = outside;
    generator.text.push_str("\n}\n");
    generator.text
}

struct Generator {
    random: Random,
    text: String,
    /// What is in scope.
    names: Vec<(String, Type)>,
    n_names: u64,
}

impl Generator {
    fn write(&mut self, word: &str) {
        self.text.push_str(word);
        self.text.push(' ');
    }

    fn any_type(&mut self) -> Type {
        match self.random.below(10) {
            0..=3 => Type::Real,
            4 | 5 => Type::Int,
            6 => Type::Point,
            7 => Type::Function,
            8 => Type::Reals(1 + self.random.below(5)),
            _ => Type::Functions(1 + self.random.below(3)),
        }
    }

    fn new_name(&mut self) -> String {
        self.n_names += 1;
        format!("x{}", self.n_names)
    }

    /// `expression /name`
    fn binding(&mut self, depth: u32) {
        let ty = self.any_type();
        self.expression(ty, depth);
        let name = self.new_name();
        let _ = writeln!(self.text, "/{name}");
        self.names.push((name, ty));
    }

    fn known(&mut self, ty: Type) -> Option<String> {
        let fitting: Vec<_> =
            self.names.iter().filter(|(_, t)| *t == ty).map(|(n, _)| n.clone()).collect();
        if fitting.is_empty() {
            return None;
        }
        let pick = self.random.below(fitting.len() as u64) as usize;
        Some(fitting[pick].clone())
    }

    fn expression(&mut self, ty: Type, depth: u32) {
        if self.random.one_in(400) {
            let wrong = self.any_type();
            return self.expression(wrong, depth.saturating_sub(1));
        }
        let wants_name = depth == 0 || self.random.one_in(4);
        if wants_name && let Some(name) = self.known(ty) {
            return self.write(&name);
        }
        if depth > 0 && self.random.one_in(6) {
            return self.conditional(ty, depth - 1);
        }
        match ty {
            Type::Real => self.real(depth),
            Type::Int => self.int(depth),
            Type::Bool => self.bool(depth),
            Type::Point => self.point(depth),
            Type::Function => self.function(depth),
            Type::Reals(n) => self.array(Type::Real, n, depth),
            Type::Functions(n) => self.array(Type::Function, n, depth),
        }
    }

    /// `condition { ... } { ... } if`, with literal or with bound functions.
    fn conditional(&mut self, ty: Type, depth: u32) {
        self.expression(Type::Bool, depth);
        let bound = self.random.one_in(3);
        for _ in 0..2 {
            self.write("{");
            let in_scope = self.names.len();
            if self.random.one_in(4) {
                self.binding(depth);
            }
            self.expression(ty, depth);
            self.names.truncate(in_scope);
            self.write("}");
        }
        if bound {
            let (no, yes) = (self.new_name(), self.new_name());
            let _ = write!(self.text, "/{no} /{yes} {yes} {no} ");
        }
        self.write("if");
    }

    fn array(&mut self, item: Type, n: u64, depth: u32) {
        self.write("[");
        for _ in 0..n {
            self.expression(item, depth.saturating_sub(1));
        }
        self.write("]");
    }

    fn function(&mut self, depth: u32) {
        self.write("{");
        let in_scope = self.names.len();
        let name = self.new_name();
        let _ = write!(self.text, "/{name} ");
        self.names.push((name, Type::Real));
        self.expression(Type::Real, depth.saturating_sub(1));
        self.names.truncate(in_scope);
        self.write("}");
    }

    fn point(&mut self, depth: u32) {
        for _ in 0..3 {
            self.expression(Type::Real, depth.saturating_sub(1));
        }
        self.write("point");
    }

    fn bool(&mut self, depth: u32) {
        let below = depth.saturating_sub(1);
        match self.random.below(5) {
            0 => {
                let word = if self.random.one_in(2) { "true" } else { "false" };
                self.write(word);
            }
            1 | 2 => self.operate(&[Type::Real, Type::Real], &["lessf", "eqf"], below),
            _ => self.operate(&[Type::Int, Type::Int], &["lessi", "eqi"], below),
        }
    }

    fn int(&mut self, depth: u32) {
        let below = depth.saturating_sub(1);
        let choice = if depth == 0 { 0 } else { self.random.below(8) };
        match choice {
            0 | 1 => {
                let literals = [
                    "0",
                    "1",
                    "2",
                    "3",
                    "-1",
                    "7",
                    "10",
                    "-9223372036854775808",
                    "4611686018427387904",
                ];
                let index = if self.random.one_in(30) { 9 } else { 7 };
                let literal = literals[self.random.below(index) as usize];
                self.write(literal);
            }
            2 => self.operate(&[Type::Real], &["floor"], below),
            3 => self.operate(&[Type::Int], &["negi"], below),
            4 => self.operate(&[Type::Int, Type::Int], &["divi", "modi"], below),
            _ => self.operate(&[Type::Int, Type::Int], &["addi", "subi", "muli"], below),
        }
    }

    fn real(&mut self, depth: u32) {
        let below = depth.saturating_sub(1);
        let choice = if depth == 0 { 0 } else { self.random.below(16) };
        match choice {
            0 | 1 => {
                let literals = [
                    "0.0", "1.0", "0.5", "-1.0", "2.0", "0.1", "30.0", "90.0", "1.0e9", "-0.0",
                    "1.0e300",
                ];
                let literal = literals[self.random.below(11) as usize];
                self.write(literal);
            }
            2 => self.operate(&[Type::Int], &["real"], below),
            3 => self.operate(&[Type::Real], &["sin", "cos", "asin", "acos"], below),
            4 => self.operate(&[Type::Real], &["negf", "frac", "clampf"], below),
            5 => {
                // Of a square, lest too many functions do nothing but fail.
                self.expression(Type::Real, below);
                let name = self.new_name();
                let _ = write!(self.text, "/{name} {name} {name} mulf sqrt ");
            }
            6 => self.operate(&[Type::Point], &["getx", "gety", "getz"], below),
            7 => self.element(below),
            8 => {
                self.expression(Type::Real, below);
                self.expression(Type::Function, below);
                self.write("apply");
            }
            9 => {
                let n = 1 + self.random.below(4);
                self.expression(Type::Real, below);
                self.expression(Type::Functions(n), below);
                self.index(n, below);
                self.write("get apply");
            }
            10 => self.tail_loop(below),
            11 => self.recursion(below),
            _ => self.operate(&[Type::Real, Type::Real], &["addf", "subf", "mulf", "divf"], below),
        }
    }

    fn operate(&mut self, operands: &[Type], operators: &[&str], depth: u32) {
        for ty in operands {
            self.expression(*ty, depth);
        }
        let operator = operators[self.random.below(operators.len() as u64) as usize];
        self.write(operator);
    }

    /// `array index get`
    fn element(&mut self, depth: u32) {
        let n = 1 + self.random.below(5);
        self.expression(Type::Reals(n), depth);
        self.index(n, depth);
        self.write("get");
    }

    /// An index that is in range, mostly.
    fn index(&mut self, n: u64, depth: u32) {
        match self.random.below(3) {
            0 => {
                let beyond = u64::from(self.random.one_in(50));
                let index = self.random.below(n + beyond);
                let _ = write!(self.text, "{index} ");
            }
            1 => {
                let _ = write!(self.text, "face {n} modi ");
            }
            _ => {
                self.expression(Type::Int, depth);
                let name = self.new_name();
                let _ = write!(
                    self.text,
                    "{n} modi /{name} {name} 0 lessi {{ {name} negi }} {{ {name} }} if "
                );
            }
        }
    }

    /// A loop: a function that calls itself last, a few times or until a value is large.
    fn tail_loop(&mut self, depth: u32) {
        let (own, n, x) = (self.new_name(), self.new_name(), self.new_name());
        let rounds = 1 + self.random.below(6);
        let start = if self.random.one_in(3) { "face" } else { "0" };
        self.expression(Type::Real, depth);
        let until =
            if self.random.one_in(2) { format!("{x} 4.0 lessf") } else { "true".to_owned() };
        let _ = write!(
            self.text,
            "{start} {{ /{own} /{n} /{x} {n} {rounds} lessi {{ {until} }} {{ false }} if {{ "
        );
        let in_scope = self.names.len();
        self.names.push((x.clone(), Type::Real));
        self.names.push((n.clone(), Type::Int));
        self.expression(Type::Real, depth);
        self.names.truncate(in_scope);
        let _ = write!(
            self.text,
            "{n} 1 addi {own} {own} apply }} {{ {x} }} if }} /{own} {own} {own} apply "
        );
    }

    /// A recursion that does something after it has called itself.
    fn recursion(&mut self, depth: u32) {
        let (own, n) = (self.new_name(), self.new_name());
        let rounds = self.random.below(4);
        let start = if self.random.one_in(3) { "face".to_owned() } else { rounds.to_string() };
        let _ = write!(self.text, "{start} {{ /{own} /{n} {n} 1 lessi {{ ");
        self.expression(Type::Real, depth);
        let _ = write!(self.text, "}} {{ {n} 1 subi {own} {own} apply ");
        let in_scope = self.names.len();
        self.names.push((n, Type::Int));
        self.expression(Type::Real, depth);
        self.names.truncate(in_scope);
        let operator = ["addf", "subf", "mulf"][self.random.below(3) as usize];
        let _ = write!(self.text, "{operator} }} if }} /{own} {own} {own} apply ");
    }
}
