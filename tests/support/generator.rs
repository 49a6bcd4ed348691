//! Random GML surface functions that are well typed by construction, mostly, and always end.
//!
//! A program binds some values, which the function captures, and leaves the function on the stack.
//! Now and then an expression of a wrong type or an index out of range is put in: what then happens
//! must be the same everywhere too.

use std::fmt::Write;

use renderer::surface::SurfacePoint;
use vm::machine::Limits;

/// Limits that generated programs run into now and then.
pub const LIMITS: Limits = Limits { fuel: 200_000, max_depth: 1000, max_memory: 64 << 20 };

/// A sequence of numbers: some that were given, then such as look random.
pub struct Random {
    /// What is given, the last first.
    given: Vec<u8>,
    state: u64,
}

impl Random {
    /// The seed names the sequence.
    pub fn new(seed: u64) -> Self {
        let state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
        Random { given: Vec::new(), state }
    }

    /// Each byte decides one thing, so that another byte makes a similar program.
    #[allow(dead_code, reason = "for the fuzz targets")]
    pub fn of_bytes(bytes: &[u8]) -> Self {
        Random { given: bytes.iter().rev().copied().collect(), ..Random::new(0) }
    }

    fn next(&mut self) -> u64 {
        // xorshift64* (Vigna 2016).
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        self.state.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number below `n`, which is not 0.
    pub fn below(&mut self, n: u64) -> u64 {
        match self.given.pop() {
            // Spread, as there are not as many bytes as numbers.
            Some(byte) => u64::from(byte).wrapping_mul(0x0101_0101) % n,
            None => (self.next() >> 33) % n,
        }
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

/// Where to call a surface function.
pub fn points(random: &mut Random) -> Vec<SurfacePoint> {
    let coordinate = |random: &mut Random| match random.below(6) {
        0 => 0.0,
        1 => 1.0,
        _ => random.below(1 << 20) as f64 / (1u64 << 20) as f64,
    };
    let mut point =
        |k: u8| SurfacePoint { face: k % 6, u: coordinate(random), v: coordinate(random) };
    (0..16).map(&mut point).collect()
}

/// A program that leaves a surface function.
pub fn program(random: &mut Random) -> String {
    let mut generator = Generator { random, text: String::new(), names: Vec::new(), n_names: 0 };
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

struct Generator<'r> {
    random: &'r mut Random,
    text: String,
    /// What is in scope.
    names: Vec<(String, Type)>,
    n_names: u64,
}

impl Generator<'_> {
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
        if depth > 0 && self.random.one_in(12) {
            return self.recursion(Type::Point, depth - 1);
        }
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
            11 => self.recursion(Type::Real, below),
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

    /// A recursion that does something after it has called itself, or after another function has
    /// that calls it. What it leaves is a real or a point.
    fn recursion(&mut self, ty: Type, depth: u32) {
        let n_functions = if self.random.one_in(4) { 2 } else { 1 };
        let is_summed_up = self.random.one_in(3);
        if is_summed_up {
            self.expression(Type::Real, depth);
        }
        self.count();
        let own: Vec<String> = (0..n_functions).map(|_| self.new_name()).collect();
        for _ in 0..n_functions {
            self.recursive_function(ty, n_functions, is_summed_up, depth);
        }
        let binders: String = own.iter().rev().map(|name| format!("/{name} ")).collect();
        let (first, last) = (&own[0], &own[n_functions - 1]);
        let arguments = if n_functions == 1 { first.clone() } else { format!("{last} {first}") };
        let _ = write!(self.text, "{binders} {arguments} {first} apply ");
    }

    /// How often a recursion takes place.
    fn count(&mut self) {
        match self.random.below(8) {
            0 | 1 => self.write("face"),
            2 => self.write("u 20.0 mulf floor"),
            3 => {
                let most = if self.random.one_in(4) { "1100.0" } else { "90.0" };
                let _ = write!(self.text, "v {most} mulf floor ");
            }
            _ => {
                let rounds = self.random.below(4);
                let _ = write!(self.text, "{rounds} ");
            }
        }
    }

    /// A function of a count and those to call, of which it calls the last with one less.
    fn recursive_function(&mut self, ty: Type, n_functions: usize, sums_up: bool, depth: u32) {
        let own: Vec<String> = (0..n_functions).map(|_| self.new_name()).collect();
        let (n, sum, left) = (self.new_name(), self.new_name(), self.new_name());
        let binders: String = own.iter().map(|name| format!("/{name} ")).collect();
        let in_scope = self.names.len();
        let _ = write!(self.text, "{{ {binders}/{n} ");
        self.names.push((n.clone(), Type::Int));
        if sums_up {
            let _ = write!(self.text, "/{sum} ");
            self.names.push((sum, Type::Real));
        }
        let _ = write!(self.text, "{n} 1 lessi {{ ");
        self.expression(ty, depth);
        self.write("} {");
        self.call_again(&own, &n, 1, sums_up, depth);
        let _ = write!(self.text, "/{left} ");
        self.names.push((left.clone(), ty));
        self.expression(ty, depth);
        let operator = ["addf", "subf", "mulf"][self.random.below(3) as usize];
        if ty == Type::Point {
            let _ = write!(self.text, "getx {left} getx {operator} {left} gety {left} getz point ");
        } else {
            let _ = write!(self.text, "{left} {operator} ");
        }
        if ty == Type::Real && self.random.one_in(6) {
            // Twice, not too deeply.
            let _ = write!(self.text, "{n} 6 lessi {{ ");
            self.call_again(&own, &n, 2, sums_up, 0);
            let _ = write!(self.text, "}} {{ {left} }} if subf ");
        }
        self.write("} if }");
        self.names.truncate(in_scope);
    }

    fn call_again(&mut self, own: &[String], n: &str, less: u64, sums_up: bool, depth: u32) {
        if sums_up {
            self.expression(Type::Real, depth);
        }
        let callee = &own[own.len() - 1];
        let functions = own.join(" ");
        let _ = write!(self.text, "{n} {less} subi {functions} {callee} apply ");
    }
}
