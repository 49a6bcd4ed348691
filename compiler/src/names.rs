//! Where names are bound and used, for editors.
//!
//! A name means the nearest binder before it, in its brackets or in those around it: that can be told
//! from the text alone. It is told from tokens, not from the tree, so that it can be told of programs
//! whose brackets do not match, as those do that are being written. Of a value the type is found where
//! literals, operators and bindings lead to it; functions that are called are not looked into.

use std::collections::{HashMap, HashSet};
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
    /// How many brackets are open around it.
    pub depth: usize,
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
#[derive(Clone, Copy, Default)]
struct Known {
    ty: Option<Type>,
    /// Its text, if it is one literal.
    text: Span,
    /// For a function, the place of its opening bracket.
    function: Option<Span>,
    is_surface_argument: bool,
}

impl Known {
    fn of(ty: Type, text: Span) -> Self {
        Known { ty: Some(ty), text, ..Known::default() }
    }
}

/// A bracket that is open.
struct Open {
    opener: Span,
    is_function: bool,
    /// Of the bindings to undo.
    mark: usize,
    /// The stack around it.
    outer: Vec<Known>,
}

struct Resolver {
    found: Names,
    names: HashMap<Arc<str>, usize>,
    /// What bindings have hidden, in order.
    hidden: Vec<(Arc<str>, Option<usize>)>,
    open: Vec<Open>,
    /// The topmost values, as far as anything is known of them.
    stack: Vec<Known>,
    /// Functions that a primitive was given in this pass, and those that an earlier pass has found.
    surfaces: HashSet<Span>,
    known_surfaces: HashSet<Span>,
}

impl Resolver {
    fn new(predefined: &[(Arc<str>, Type)], known_surfaces: HashSet<Span>) -> Self {
        let mut resolver = Resolver {
            found: Names::default(),
            names: HashMap::new(),
            hidden: Vec::new(),
            open: Vec::new(),
            stack: Vec::new(),
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
            TokenKind::Name(name) => self.name(name, span),
            TokenKind::Binder(name) => {
                let value = self.stack.pop().unwrap_or_default();
                self.bind(name, span, value);
            }
            TokenKind::OpenFunction => self.open(span, true),
            TokenKind::OpenArray => self.open(span, false),
            TokenKind::CloseFunction | TokenKind::CloseArray => self.close(span),
        }
    }

    fn name(&mut self, name: &Arc<str>, span: Span) {
        let binding = self.names.get(name).copied();
        self.found.uses.push(Use { name: Arc::clone(name), span, binding });
        let value = binding.map(|idx| {
            let Binding { ty, value, is_surface_argument, .. } = self.found.bindings[idx];
            let function = (ty == Some(Type::Closure)).then_some(value);
            Known { ty, text: value, function, is_surface_argument }
        });
        self.stack.push(value.unwrap_or_default());
    }

    fn bind(&mut self, name: &Arc<str>, span: Span, value: Known) {
        let idx = self.found.bindings.len();
        self.found.bindings.push(Binding {
            name: Arc::clone(name),
            span,
            ty: value.ty,
            value: value.text,
            is_surface_argument: value.is_surface_argument,
            depth: self.open.len(),
        });
        let hidden = self.names.insert(Arc::clone(name), idx);
        self.hidden.push((Arc::clone(name), hidden));
    }

    fn open(&mut self, opener: Span, is_function: bool) {
        let outer = std::mem::take(&mut self.stack);
        self.open.push(Open { opener, is_function, mark: self.hidden.len(), outer });
        if is_function && self.known_surfaces.contains(&opener) {
            let argument =
                |ty| Known { ty: Some(ty), is_surface_argument: true, ..Known::default() };
            self.stack.extend([Type::Int, Type::Real, Type::Real].map(argument));
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
        self.stack = open.outer;
        let ty = if open.is_function { Type::Closure } else { Type::Array };
        let function = open.is_function.then_some(open.opener);
        self.stack.push(Known { function, ..Known::of(ty, open.opener.to(closer)) });
    }

    fn operator(&mut self, op: Operator) {
        if op.operands() == [Type::Closure] && op.results() == [Type::Object] {
            // A binding knows its function by the whole text, which starts where its bracket does.
            let start = self.stack.last().and_then(|value| value.function);
            self.surfaces.extend(start.map(|span| Span { end: span.start + 1, ..span }));
        }
        let n_left = self.stack.len().saturating_sub(op.operands().len());
        self.stack.truncate(n_left);
        if matches!(op, Operator::Apply | Operator::If | Operator::Render) {
            // What a function leaves is not known, nor how much `render` takes.
            self.stack.clear();
        }
        let known = |ty: &Type| Known { ty: (*ty != Type::Any).then_some(*ty), ..Known::default() };
        self.stack.extend(op.results().iter().map(known));
    }
}

#[cfg(test)]
mod tests;
