//! Where names are bound and used, for editors.
//!
//! A name means the nearest binder before it, in its brackets or in those around it: that can be told
//! from the text alone. It is told from tokens, not from the tree, so that it can be told of programs
//! whose brackets do not match, as those do that are being written. Of a value the type is found where
//! literals, operators, bindings, and calls of functions that are written out lead to it.

use std::collections::{HashMap, HashSet};
use std::fmt;
use std::sync::Arc;

use crate::lexer::{Token, TokenKind, is_identifier};
use crate::op::{Operator, Type};
use crate::source::Span;

/// A name that is given to a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// The name.
    pub name: Arc<str>,
    /// The binder, with its `/`; [`Span::NONE`] for a name that is bound before the program starts.
    pub span: Span,
    /// The type of the value, if it is known.
    pub ty: Option<Type>,
    /// What the value is written as, where one literal, function or array stands for it; else
    /// [`Span::NONE`].
    pub value: Span,
    /// Whether the value is what surface functions are called with, here face, u or v.
    pub is_surface_argument: bool,
    /// For a function what it does to the stack, if that is known.
    pub effect: Option<Effect>,
    /// How many brackets are open around it.
    pub depth: usize,
}

/// What a function does to the stack, as far as it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// How many values it takes.
    n_taken: usize,
    /// What it leaves.
    results: Vec<Known>,
}

impl fmt::Display for Effect {
    /// As a stack effect: `value value → object`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let results = self.results.iter().map(|value| value.ty.unwrap_or(Type::Any).name());
        let words = std::iter::repeat_n(Type::Any.name(), self.n_taken).chain(["→"]).chain(results);
        f.write_str(&words.collect::<Vec<_>>().join(" "))
    }
}

/// A name in the place of a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// The name.
    pub name: Arc<str>,
    /// Where it stands.
    pub span: Span,
    /// Index of its binding; none if it is not bound there.
    pub binding: Option<usize>,
}

/// All binders and uses of a program, each in the order of the text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// Those bound before the program starts come first.
    pub bindings: Vec<Binding>,
    /// The uses.
    pub uses: Vec<Use>,
}

/// Why a binding cannot get another name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Clash {
    /// The new name is none, or is reserved; says so in words.
    NoName(String),
    /// The use at the first place would come to mean the binder at the second, which may be none.
    Captured(Span, Option<Span>),
}

impl Names {
    /// Resolves the names of a program, with some bound before it starts.
    #[must_use]
    pub fn of(tokens: &[Token], predefined: &[(Arc<str>, Type)]) -> Names {
        let surfaces = Resolver::new(predefined, HashSet::new()).run(tokens, |_| false).surfaces;
        Resolver::new(predefined, surfaces).run(tokens, |_| false).found
    }

    /// The bindings in sight where a place in the text begins, by name. `is_behind` says whether a
    /// token stands there or later.
    #[must_use]
    pub fn in_sight(
        tokens: &[Token],
        predefined: &[(Arc<str>, Type)],
        is_behind: impl Fn(Span) -> bool,
    ) -> Vec<Binding> {
        let mut resolver = Resolver::new(predefined, HashSet::new()).run(tokens, is_behind);
        let mut names: Vec<_> = resolver.names.drain().collect();
        names.sort();
        names.into_iter().map(|(_, idx)| resolver.found.bindings[idx].clone()).collect()
    }

    /// The binding that a binder or a use at this address belongs to, and the place of that word.
    #[must_use]
    pub fn at(&self, address: u32) -> Option<(usize, Span)> {
        let is_here = |span: Span| !span.is_none() && (span.start..=span.end).contains(&address);
        let bound = self.bindings.iter().position(|binding| is_here(binding.span));
        if let Some(idx) = bound {
            return Some((idx, self.bindings[idx].span));
        }
        let used = self.uses.iter().find(|used| is_here(used.span))?;
        Some((used.binding?, used.span))
    }

    /// The uses of a binding.
    pub fn uses_of(&self, binding: usize) -> impl Iterator<Item = Span> {
        self.uses.iter().filter(move |used| used.binding == Some(binding)).map(|used| used.span)
    }

    /// Whether a binding can be called `new` with every use meaning what it does now.
    ///
    /// # Errors
    /// When it cannot.
    pub fn check_renaming(
        &self,
        tokens: &[Token],
        predefined: &[(Arc<str>, Type)],
        binding: usize,
        new: &str,
    ) -> Result<(), Clash> {
        if let Some(reason) = no_name(new) {
            return Err(Clash::NoName(reason));
        }
        let places: HashSet<Span> =
            self.uses_of(binding).chain([self.bindings[binding].span]).collect();
        let new: Arc<str> = new.into();
        let mut renamed = tokens.to_vec();
        for token in renamed.iter_mut().filter(|token| places.contains(&token.span)) {
            match &mut token.kind {
                TokenKind::Name(name) | TokenKind::Binder(name) => *name = Arc::clone(&new),
                _ => {}
            }
        }
        let after = Names::of(&renamed, predefined);
        let changed = self.uses.iter().zip(&after.uses).find(|(a, b)| a.binding != b.binding);
        match changed {
            Some((used, after_use)) => {
                let binder = after_use.binding.map(|idx| after.bindings[idx].span);
                Err(Clash::Captured(used.span, binder))
            }
            None => Ok(()),
        }
    }
}

/// Why a text cannot be bound, if so.
fn no_name(text: &str) -> Option<String> {
    if Operator::from_spelling(text).is_some() {
        return Some("it is the name of an operator".to_owned());
    }
    if matches!(text, "true" | "false") {
        return Some("it is a boolean".to_owned());
    }
    let rule = "an identifier is a letter, then letters, digits, `-` and `_`";
    (!is_identifier(text)).then(|| rule.to_owned())
}

/// What is known of a value on the stack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Known {
    ty: Option<Type>,
    /// Its text, if it is one literal.
    text: Span,
    /// For a function that the program writes out, its index.
    function: Option<usize>,
    is_surface_argument: bool,
}

impl Known {
    fn of(ty: Type, text: Span) -> Self {
        Known { ty: Some(ty), text, ..Known::default() }
    }

    /// What is known if it is either of two.
    fn or(self, other: Known) -> Known {
        let ty = self.ty.filter(|_| self.ty == other.ty);
        let function = self.function.filter(|_| self.function == other.function);
        Known { ty, function, ..Known::default() }
    }
}

/// The stack, as far as the code between the same brackets makes it.
#[derive(Default)]
struct Stack {
    /// The topmost values.
    values: Vec<Known>,
    /// How many values have been taken from what was there before; none if that is not known.
    n_taken: Option<usize>,
}

impl Stack {
    fn new() -> Self {
        Stack { values: Vec::new(), n_taken: Some(0) }
    }

    fn pop(&mut self) -> Known {
        self.values.pop().unwrap_or_else(|| {
            self.n_taken = self.n_taken.map(|n| n + 1);
            Known::default()
        })
    }

    fn push(&mut self, value: Known) {
        self.values.push(value);
    }

    /// Something unknown has been done to it.
    fn forget(&mut self) {
        *self = Stack::default();
    }

    /// Does what a function does.
    fn apply(&mut self, effect: &Effect) {
        for _ in 0..effect.n_taken {
            self.pop();
        }
        self.values.extend_from_slice(&effect.results);
    }
}

/// A function takes, and leaves, at most so many values for its effect to be known: those of functions
/// that call others twice double with each.
const MAX_EFFECT: usize = 8;

impl Effect {
    fn of(stack: Stack) -> Option<Self> {
        let n_taken = stack.n_taken.filter(|&n| n.max(stack.values.len()) <= MAX_EFFECT)?;
        let result = |value| Known { text: Span::NONE, is_surface_argument: false, ..value };
        Some(Effect { n_taken, results: stack.values.into_iter().map(result).collect() })
    }

    /// The effect of doing either.
    fn or(&self, other: &Effect) -> Option<Effect> {
        let is_alike = self.n_taken == other.n_taken && self.results.len() == other.results.len();
        let results = self.results.iter().zip(&other.results).map(|(a, b)| a.or(*b));
        is_alike.then(|| Effect { n_taken: self.n_taken, results: results.collect() })
    }
}

/// A bracket that is open.
struct Open {
    opener: Span,
    is_function: bool,
    /// Of the bindings to undo.
    mark: usize,
    /// The stack around it.
    outer: Stack,
}

struct Resolver {
    found: Names,
    names: HashMap<Arc<str>, usize>,
    /// What the bindings are bound to, in their order.
    bound: Vec<Known>,
    /// What bindings have hidden, in order.
    hidden: Vec<(Arc<str>, Option<usize>)>,
    open: Vec<Open>,
    stack: Stack,
    /// The functions by their indices: where each starts, and its effect if that is known.
    functions: Vec<(Span, Option<Effect>)>,
    /// Where functions start that a primitive is given, and those that an earlier pass has found.
    surfaces: HashSet<Span>,
    known_surfaces: HashSet<Span>,
}

impl Resolver {
    fn new(predefined: &[(Arc<str>, Type)], known_surfaces: HashSet<Span>) -> Self {
        let mut resolver = Resolver {
            found: Names::default(),
            names: HashMap::new(),
            bound: Vec::new(),
            hidden: Vec::new(),
            open: Vec::new(),
            stack: Stack::new(),
            functions: Vec::new(),
            surfaces: HashSet::new(),
            known_surfaces,
        };
        for (name, ty) in predefined {
            resolver.bind(name, Span::NONE, Known::of(*ty, Span::NONE));
        }
        resolver
    }

    /// Reads all tokens up to one that ends it.
    fn run(mut self, tokens: &[Token], ends: impl Fn(Span) -> bool) -> Self {
        for token in tokens.iter().take_while(|token| !ends(token.span)) {
            self.token(token);
        }
        self
    }

    fn token(&mut self, token: &Token) {
        let span = token.span;
        match &token.kind {
            TokenKind::Bool(_) => self.stack.push(Known::of(Type::Bool, span)),
            TokenKind::Int(_) => self.stack.push(Known::of(Type::Int, span)),
            TokenKind::Real(_) => self.stack.push(Known::of(Type::Real, span)),
            TokenKind::Str(_) => self.stack.push(Known::of(Type::Str, span)),
            TokenKind::Operator(op) => self.operator(*op),
            TokenKind::Name(name) => {
                let binding = self.names.get(name).copied();
                self.found.uses.push(Use { name: Arc::clone(name), span, binding });
                let value = binding.map(|idx| self.bound[idx]).unwrap_or_default();
                self.stack.push(Known { is_surface_argument: false, ..value });
            }
            TokenKind::Binder(name) => {
                let value = self.stack.pop();
                self.bind(name, span, value);
            }
            TokenKind::OpenFunction => self.open(span, true),
            TokenKind::OpenArray => self.open(span, false),
            TokenKind::CloseFunction | TokenKind::CloseArray => self.close(span),
        }
    }

    fn bind(&mut self, name: &Arc<str>, span: Span, value: Known) {
        let idx = self.bound.len();
        self.bound.push(value);
        self.found.bindings.push(Binding {
            name: Arc::clone(name),
            span,
            ty: value.ty,
            value: value.text,
            is_surface_argument: value.is_surface_argument,
            effect: value.function.and_then(|idx| self.functions[idx].1.clone()),
            depth: self.open.len(),
        });
        let hidden = self.names.insert(Arc::clone(name), idx);
        self.hidden.push((Arc::clone(name), hidden));
    }

    fn open(&mut self, opener: Span, is_function: bool) {
        let outer = std::mem::replace(&mut self.stack, Stack::new());
        self.open.push(Open { opener, is_function, mark: self.hidden.len(), outer });
        if is_function && self.known_surfaces.contains(&opener) {
            let argument =
                |ty| Known { ty: Some(ty), is_surface_argument: true, ..Known::default() };
            self.stack.values.extend([Type::Int, Type::Real, Type::Real].map(argument));
        }
    }

    fn close(&mut self, closer: Span) {
        let Some(open) = self.open.pop() else { return };
        for (name, hidden) in self.hidden.split_off(open.mark).into_iter().rev() {
            match hidden {
                Some(idx) => self.names.insert(name, idx),
                None => self.names.remove(&name),
            };
        }
        let inner = std::mem::replace(&mut self.stack, open.outer);
        let text = open.opener.to(closer);
        if !open.is_function {
            return self.stack.push(Known::of(Type::Array, text));
        }
        let function = Some(self.functions.len());
        // What a surface function takes is not written on the stack by the program.
        let effect =
            if self.known_surfaces.contains(&open.opener) { None } else { Effect::of(inner) };
        self.functions.push((open.opener, effect));
        self.stack.push(Known { function, ..Known::of(Type::Closure, text) });
    }

    fn operator(&mut self, op: Operator) {
        let takes_function = op.operands().last() == Some(&Type::Closure);
        let function = self.stack.values.last().and_then(|value| value.function);
        if takes_function && op.results() == [Type::Object] {
            self.surfaces.extend(function.map(|idx| self.functions[idx].0));
        }
        let operands: Vec<_> = op.operands().iter().map(|_| self.stack.pop()).collect();
        let effect = |value: &Known| self.functions[value.function?].1.as_ref();
        match (op, &operands[..]) {
            (Operator::Apply, [function]) => self.call(effect(function).cloned()),
            (Operator::If, [no, yes, _]) => {
                self.call(effect(yes).zip(effect(no)).and_then(|(yes, no)| yes.or(no)));
            }
            // It takes eight values or nine.
            (Operator::Render, _) => self.stack.forget(),
            _ => {
                let known =
                    |ty: &Type| Known { ty: (*ty != Type::Any).then_some(*ty), ..Known::default() };
                self.stack.values.extend(op.results().iter().map(known));
            }
        }
    }

    /// Calls a function with this effect, if that is known.
    fn call(&mut self, effect: Option<Effect>) {
        match effect {
            Some(effect) => self.stack.apply(&effect),
            None => self.stack.forget(),
        }
    }
}

#[cfg(test)]
mod tests;
