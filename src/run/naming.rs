//! Where an image goes: the name from the scene or the command line, and the format.

use std::path::{Path, PathBuf};

use crate::args::ImageFormat;
use crate::clean::clean;
use crate::failure::Failure;
use crate::formats;
use crate::output::{self, Problem, Target};

/// Where the images of a run go.
#[derive(Debug)]
pub(crate) enum Naming {
    /// Under the scene's names, below a directory.
    Scene(PathBuf),
    /// Under the user's name, in which `{name}` and `{n}` are replaced.
    Template(PathBuf),
    /// To the standard output.
    Stdout,
    /// Nowhere: they are encoded in memory, and hashed.
    Memory,
}

/// What takes the bytes of one image.
#[derive(Debug)]
pub(crate) enum Sink {
    File(Target),
    Stdout,
    Memory,
}

/// Where one image goes, and as what.
#[derive(Debug)]
pub(crate) struct Destination {
    pub(crate) sink: Sink,
    pub(crate) format: ImageFormat,
}

impl Naming {
    /// The naming that the command line asks for.
    ///
    /// # Errors
    /// When the template has a placeholder that does not exist.
    pub(crate) fn new(output: Option<&Path>, out_dir: &Path) -> Result<Self, Failure> {
        let Some(output) = output else { return Ok(Naming::Scene(out_dir.to_owned())) };
        if output.as_os_str() == "-" {
            return Ok(Naming::Stdout);
        }
        let text = output.to_string_lossy();
        if text.ends_with('/') {
            return Err(Failure::Usage(format!(
                "`--output {}` names a directory, not a file; see `--out-dir`",
                clean(&text)
            )));
        }
        check_placeholders("--output", &text)?;
        let is_here = out_dir == Path::new(".");
        Ok(Naming::Template(if is_here { output.to_owned() } else { out_dir.join(output) }))
    }

    /// Where the image goes that the scene calls `name`, the `number`th of the run.
    ///
    /// # Errors
    /// When the scene's name is not allowed, or cannot be that of a file.
    pub(crate) fn destination(
        &self,
        name: &str,
        number: u64,
        format: Option<ImageFormat>,
    ) -> Result<Destination, Problem> {
        let (sink, by_name) = match self {
            Naming::Stdout => (Sink::Stdout, None),
            Naming::Memory => {
                output::stem(name).map_err(Problem::Refused)?;
                (Sink::Memory, formats::of_name(Path::new(name)))
            }
            Naming::Template(template) => {
                let path = filled(template, name, number)?;
                let by_name = formats::of_name(&path);
                (Sink::File(Target::path(path)), by_name)
            }
            Naming::Scene(directory) => {
                let by_name = formats::of_name(Path::new(name));
                let name = match (format, by_name) {
                    (Some(format), Some(other)) if format != other => with_format(name, format),
                    _ => name.to_owned(),
                };
                (Sink::File(Target::below(directory, &name)?), by_name)
            }
        };
        let format = format.or(by_name).unwrap_or(ImageFormat::Ppm);
        Ok(Destination { sink, format })
    }
}

/// The name with the extension of a format in place of another format's.
fn with_format(name: &str, format: ImageFormat) -> String {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    format!("{stem}.{}", format.extension())
}

/// Whether a template has no placeholders but those that there are.
///
/// # Errors
/// When it has others.
pub(super) fn check_placeholders(option: &str, template: &str) -> Result<(), Failure> {
    let rest = template.replace("{name}", "").replace("{n}", "");
    if rest.contains(['{', '}']) {
        let shown = clean(template);
        let message = format!("`{option} {shown}`: the placeholders are {{name}} and {{n}}");
        return Err(Failure::Usage(message));
    }
    Ok(())
}

/// The template with its placeholders replaced, for the image that the scene calls `name`.
///
/// # Errors
/// When the scene's name is not allowed.
pub(super) fn filled(template: &Path, name: &str, number: u64) -> Result<PathBuf, Problem> {
    let Some(text) = template.to_str() else { return Ok(template.to_owned()) };
    // The scene's name could hold `{n}`, which is no placeholder there, and so comes last.
    let text = text.replace("{n}", &number.to_string());
    if !text.contains("{name}") {
        return Ok(PathBuf::from(text));
    }
    let stem = output::stem(name).map_err(Problem::Refused)?;
    Ok(PathBuf::from(text.replace("{name}", stem)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_filled() {
        let fill = |template: &str, name: &str| {
            filled(Path::new(template), name, 7).map(|path| path.display().to_string()).ok()
        };
        assert_eq!(fill("out/{name}-{n}.png", "a/b.ppm").as_deref(), Some("out/b-7.png"));
        assert_eq!(fill("{name}", "x{n}.ppm").as_deref(), Some("x{n}"));
        assert_eq!(fill("{name}.png", "../b.ppm"), None);
        assert_eq!(fill("x.png", "../b.ppm").as_deref(), Some("x.png"));
    }

    #[test]
    fn a_format_replaces_the_extension_of_another() {
        assert_eq!(with_format("a.b/c.ppm", ImageFormat::Png), "a.b/c.png");
        assert_eq!(formats::of_name(Path::new("a/b.PNG")), Some(ImageFormat::Png));
        assert_eq!(formats::of_name(Path::new("ppm")), None);
    }
}
