//! What became of surface functions, for people to read.

use std::collections::HashMap;
use std::sync::Arc;

use renderer::surface::{Needs, SurfaceSample};
use vm::display;
use vm::value::{Closure, Value};

use crate::shaders::{Shaders, Tier, Variant};
pub use crate::sir::Site;
use crate::sir::{Inst, N_ARGUMENTS, Shader, Term, Type, Val};
use crate::sym::{Captures, Num, Sym};
pub use crate::text::Line;
use crate::text::Text;
use crate::unsupported::Unsupported;

/// A name or value is cut at this many characters: programs are not trusted to be brief.
const MAX_CHARS: usize = 60;

/// A surface function and what it was compiled to.
#[derive(Clone, Debug)]
pub struct Listing {
    /// The function.
    pub function: u32,
    /// The functions that its code comes from: itself, and those that it calls.
    pub functions: Vec<u32>,
    /// What is passed to the shader at run time, by slot.
    pub uniforms: Vec<Uniform>,
    /// What it is specialized on.
    pub known: Vec<Known>,
    /// What it is evaluated by.
    pub outcome: Outcome,
}

/// A captured number, or a component of a captured point, that a shader reads from its slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Uniform {
    /// The name under which it was captured, from the outermost closure on, as in `f.color.x`.
    pub name: String,
    /// `real` or `integer`.
    pub ty: &'static str,
    /// The value for this surface, as GML writes it.
    pub value: String,
}

/// A captured value that is part of the code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Known {
    /// The name under which it was captured.
    pub name: String,
    /// The value, as GML writes it.
    pub value: String,
}

/// What a surface function is evaluated by.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It ignores where it is asked.
    Constant(SurfaceSample),
    /// Machine code.
    Native(Native),
    /// The interpreter.
    Declined(Unsupported),
}

/// A shader.
#[derive(Clone, Debug)]
pub struct Native {
    /// Bytes of code, its constants included.
    pub n_bytes: usize,
    /// What it reads.
    pub needs: Needs,
    /// What is known of red, green, blue, kd, ks and n.
    pub results: [ShaderResult; 6],
    /// As handed to the code generator.
    pub clif: Vec<Line>,
    /// As executed.
    pub asm: Vec<Line>,
}

/// What is known of a shader's result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShaderResult {
    /// It is the same everywhere.
    Constant(f64),
    /// It is that of a slot.
    Uniform(u32),
    /// It depends on where the shader is asked.
    Computed,
}

impl Shaders<'_> {
    /// The surfaces that share a shader, in the order of the first of each.
    #[must_use]
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut by_cell = HashMap::new();
        for (index, closure) in self.surfaces.iter().enumerate() {
            let (_, cell) = self.cell(closure);
            let group = *by_cell.entry(Arc::as_ptr(&cell)).or_insert(groups.len());
            if group == groups.len() {
                groups.push(Vec::new());
            }
            groups[group].push(index);
        }
        groups
    }

    /// The listing of a surface whose tier has been decided, as all have been by
    /// [`Tiering::Eager`](crate::shaders::Tiering::Eager); none of another.
    #[must_use]
    pub fn listing(&self, index: usize) -> Option<Listing> {
        let closure = &self.surfaces[index];
        let (outline, _) = self.cell(closure);
        let specialized = self.variant(index).as_ref().map(|bound| &*bound.variant);
        let functions = match specialized {
            Ok(variant) => variant.shader.functions.iter().copied().collect(),
            Err(_) => vec![outline.function],
        };
        let native = |variant| self.native_listing(index, variant).map(Outcome::Native);
        let outcome = match self.slots[index].tier.get()? {
            Tier::Constant(sample) => Outcome::Constant(*sample),
            Tier::Interpreted(why) => Outcome::Declined(why.clone()),
            Tier::Native => {
                specialized.map_err(Clone::clone).and_then(native).unwrap_or_else(Outcome::Declined)
            }
        };
        let mut layout = Layout { shaders: self, uniforms: Vec::new(), known: Vec::new() };
        layout.closure("", closure, &outline.captures);
        let Layout { uniforms, known, .. } = layout;
        Some(Listing { function: outline.function, functions, uniforms, known, outcome })
    }

    fn native_listing(&self, index: usize, variant: &Variant) -> Result<Native, Unsupported> {
        let mut text = Text::default();
        let code = self.code(index, &variant.shader, Some(&mut text))?;
        Ok(Native {
            n_bytes: code.n_bytes,
            needs: variant.needs,
            results: results(&variant.shader),
            clif: text.clif,
            asm: text.asm,
        })
    }
}

/// What is known of the results: that all ways return the same.
fn results(shader: &Shader) -> [ShaderResult; 6] {
    let mut constants = HashMap::new();
    for (val, inst, _) in shader.main.blocks.iter().flat_map(|block| &block.insts) {
        if let Inst::Real(value) = inst {
            constants.insert(*val, *value);
        }
    }
    let uniforms = N_ARGUMENTS..N_ARGUMENTS + shader.n_uniforms;
    let of = |val: Val| match constants.get(&val) {
        Some(value) => ShaderResult::Constant(*value),
        None if uniforms.contains(&val.0) => ShaderResult::Uniform(val.0 - N_ARGUMENTS),
        None => ShaderResult::Computed,
    };
    let ways = shader.main.blocks.iter().filter_map(|block| match &block.term {
        Some((Term::Return(vals), _)) => Some(std::array::from_fn(|index| of(vals[index]))),
        _ => None,
    });
    let either = |a: ShaderResult, b: ShaderResult| {
        let is_same = match (a, b) {
            (ShaderResult::Constant(x), ShaderResult::Constant(y)) => x.to_bits() == y.to_bits(),
            _ => a == b,
        };
        if is_same { a } else { ShaderResult::Computed }
    };
    ways.reduce(|a, b| std::array::from_fn(|index| either(a[index], b[index])))
        .unwrap_or([ShaderResult::Computed; 6])
}

/// Walks through a closure beside its outline.
struct Layout<'s> {
    shaders: &'s Shaders<'s>,
    uniforms: Vec<Uniform>,
    known: Vec<Known>,
}

impl Layout<'_> {
    /// The recursion is as deep as the outline's, which is bounded.
    fn closure(&mut self, prefix: &str, closure: &Closure, syms: &[Sym]) {
        let program = &self.shaders.program.bytecode;
        let names = &program.functions[closure.function as usize].capture_names;
        for ((name, sym), value) in names.iter().zip(syms).zip(closure.captures()) {
            let name = format!("{prefix}{}", brief(name));
            self.value(name, sym, value);
        }
    }

    fn value(&mut self, name: String, sym: &Sym, value: &Value) {
        match (sym, value) {
            (Sym::Real(Num::Ssa(_)), _) => self.uniform(name, Type::Real, value),
            (Sym::Int(Num::Ssa(_)), _) => self.uniform(name, Type::Int, value),
            (Sym::Point([Num::Ssa(_), ..]), Value::Point(point)) => {
                for (axis, component) in ["x", "y", "z"].iter().zip(point) {
                    let value = Value::Real(*component);
                    self.uniform(format!("{name}.{axis}"), Type::Real, &value);
                }
            }
            (Sym::Closure(function, Captures::Parts(parts)), Value::Closure(closure)) => {
                let prefix = format!("{name}.");
                let title = compiler::disasm::title(&self.shaders.program.bytecode, *function);
                self.known.push(Known { name, value: brief(&title) });
                self.closure(&prefix, closure, parts);
            }
            _ => self.known.push(Known { name, value: brief(&display::to_text(value)) }),
        }
    }

    fn uniform(&mut self, name: String, ty: Type, value: &Value) {
        let ty = if ty == Type::Int { "integer" } else { "real" };
        self.uniforms.push(Uniform { name, ty, value: display::to_text(value) });
    }
}

fn brief(text: &str) -> String {
    match text.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
