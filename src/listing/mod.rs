//! What became of the surface functions of a run: gathered here, shown as text or as a page.

use std::io;
use std::sync::Arc;

use compiler::bytecode::Program;
use jit::listing::{Listing, ShaderResult};
use jit::shaders::{Shaders, Tiering};
use renderer::surface::Needs;
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::surfaces;

pub(crate) mod html;
pub(crate) mod text;

/// Surfaces are named one by one, or in ranges, so far.
const MAX_RANGES: usize = 6;

/// The names of a shader's results.
const RESULTS: [&str; 6] = ["red", "green", "blue", "kd", "ks", "n"];

/// Surfaces that share a shader.
pub(crate) struct Surfaces {
    /// Their numbers, counted through all images of the run.
    pub(crate) numbers: Vec<usize>,
    /// The listing of the first of them.
    pub(crate) listing: Listing,
}

/// Which surfaces are wanted.
#[derive(Clone)]
pub(crate) struct Selection {
    /// This one only.
    pub(crate) surface: Option<usize>,
    /// Closures of these functions only.
    pub(crate) functions: Option<Vec<u32>>,
}

/// Goes through the surfaces of one image after another.
pub(crate) struct Walk {
    selection: Selection,
    limits: Limits,
    /// Surfaces of the images so far.
    pub(crate) n_surfaces: usize,
}

impl Walk {
    /// Starts before the first image; the limits are those of each call of a surface function.
    pub(crate) fn new(selection: Selection, limits: Limits) -> Self {
        Walk { selection, limits, n_surfaces: 0 }
    }

    /// Compiles the surfaces of a job, and shows those that are wanted.
    ///
    /// # Errors
    /// Those of `show`.
    pub(crate) fn visit(
        &mut self,
        job: &RenderJob<'_>,
        show: &mut dyn FnMut(&Surfaces) -> io::Result<()>,
    ) -> io::Result<()> {
        let (_, closures): (renderer::scene::Scene, _) = surfaces::scene(&job.object);
        let first = self.n_surfaces;
        self.n_surfaces += closures.len();
        let shaders = Shaders::new(job.program, &closures, self.limits, Tiering::Eager);
        for group in shaders.groups() {
            let mut numbers: Vec<usize> = group.iter().map(|index| first + index).collect();
            if let Some(surface) = self.selection.surface {
                numbers.retain(|number| *number == surface);
            }
            let Some(&number) = numbers.first() else { continue };
            let index = number - first;
            let function = closures[index].function;
            if self.selection.functions.as_ref().is_some_and(|wanted| !wanted.contains(&function)) {
                continue;
            }
            if let Some(listing) = shaders.listing(index) {
                show(&Surfaces { numbers, listing })?;
            }
        }
        Ok(())
    }
}

/// The functions that a word of the command line names: by number, or all with that name.
pub(crate) fn functions_named(program: &Program, word: &str) -> Vec<u32> {
    let all = 0..program.functions.len() as u32;
    match word.parse::<u32>() {
        Ok(number) => all.filter(|index| *index == number).collect(),
        Err(_) => {
            let name: Option<Arc<str>> = Some(word.into());
            all.filter(|index| program.functions[*index as usize].name == name).collect()
        }
    }
}

/// Surfaces by their numbers, which ascend, as in "surfaces 0-7, 9".
pub(crate) fn numbered(numbers: &[usize]) -> String {
    let ranges: Vec<_> = numbers.chunk_by(|a, b| a + 1 == *b).collect();
    let shown = ranges.iter().take(MAX_RANGES).map(|range| match range {
        [first, .., last] => format!("{first}-{last}"),
        _ => range[0].to_string(),
    });
    let mut text = if numbers.len() == 1 { "surface " } else { "surfaces " }.to_owned();
    text.push_str(&shown.collect::<Vec<_>>().join(", "));
    let n_hidden: usize = ranges.iter().skip(MAX_RANGES).map(|range| range.len()).sum();
    if n_hidden > 0 {
        text.push_str(&format!(" and {n_hidden} more"));
    }
    text
}

/// Which of face, u and v a shader reads, in words.
fn needs(needs: Needs) -> String {
    let needs = [needs.face, needs.u, needs.v];
    let named = ["face", "u", "v"].into_iter().zip(needs);
    let names: Vec<_> = named.filter_map(|(name, is_read)| is_read.then_some(name)).collect();
    names.join(", ")
}

/// The results of a shader that are known, each as "kd = 1.0".
fn known_results(results: &[ShaderResult; 6]) -> Vec<String> {
    let known = |(name, result): (&str, &ShaderResult)| match result {
        ShaderResult::Constant(value) => Some(format!("{name} = {value:?}")),
        ShaderResult::Uniform(slot) => Some(format!("{name} = uniform {slot}")),
        ShaderResult::Computed => None,
    };
    RESULTS.into_iter().zip(results).filter_map(known).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_named_in_ranges() {
        assert_eq!(numbered(&[4]), "surface 4");
        assert_eq!(numbered(&[0, 1, 2, 5, 7, 8]), "surfaces 0-2, 5, 7-8");
        let odd: Vec<usize> = (0..10).map(|n| 2 * n).collect();
        assert_eq!(numbered(&odd), "surfaces 0, 2, 4, 6, 8, 10 and 4 more");
    }
}
