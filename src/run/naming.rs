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
    pub(crate) fn new(
        output: Option<&Path>,
        out_dir: &Path,
        has_frames: bool,
    ) -> Result<Self, Failure> {
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
        check_placeholders("--output", &text, has_frames)?;
        let is_here = out_dir == Path::new(".");
        Ok(Naming::Template(if is_here { output.to_owned() } else { out_dir.join(output) }))
    }

    /// Where the image goes that the scene calls `name`.
    ///
    /// # Errors
    /// When the scene's name is not allowed, or cannot be that of a file.
    pub(crate) fn destination(
        &self,
        name: &str,
        number: Number,
        format: Option<ImageFormat>,
    ) -> Result<Destination, Problem> {
        let (sink, by_name) = match self {
            Naming::Stdout => (Sink::Stdout, None),
            Naming::Memory => {
                output::stem(name).map_err(Problem::Refused)?;
                (Sink::Memory, formats::of_name(Path::new(name)))
            }
            Naming::Template(template) => {
                let target = filled(template, name, number)?;
                let by_name = formats::of_name(&target.shown());
                (Sink::File(target), by_name)
            }
            Naming::Scene(directory) => {
                let by_name = formats::of_name(Path::new(name));
                let name = match (format, by_name) {
                    (Some(format), Some(other)) if format != other => with_format(name, format),
                    _ => name.to_owned(),
                };
                let name = match number.frame {
                    // What is no name does not become one by its number.
                    Some(frame) => {
                        output::stem(&name).map_err(Problem::Refused)?;
                        with_frame(&name, frame)
                    }
                    None => name,
                };
                (Sink::File(Target::below(directory, &name)?), by_name)
            }
        };
        let format = format.or(by_name).unwrap_or(ImageFormat::Ppm);
        Ok(Destination { sink, format })
    }
}

/// Which image of a run one is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    /// The number in the run, from 1.
    pub(crate) image: u64,
    /// The frame that it belongs to, if there are frames.
    pub(crate) frame: Option<u32>,
}

/// The name with a frame's number before the extension.
fn with_frame(name: &str, frame: u32) -> String {
    let directory = name.rfind('/').map_or(0, |slash| slash + 1);
    match name[directory..].rfind('.') {
        Some(point) => {
            let (stem, extension) = name.split_at(directory + point);
            format!("{stem}-{frame:04}{extension}")
        }
        None => format!("{name}-{frame:04}"),
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
pub(super) fn check_placeholders(
    option: &str,
    template: &str,
    has_frames: bool,
) -> Result<(), Failure> {
    let rest = template.replace("{name}", "").replace("{n}", "");
    let rest = if has_frames { rest.replace("{frame}", "") } else { rest };
    if rest.contains(['{', '}']) {
        let shown = clean(template);
        let message = format!(
            "`{option} {shown}`: the placeholders are {{name}} and {{n}}, and with \
             `--frames` {{frame}}"
        );
        return Err(Failure::Usage(message));
    }
    Ok(())
}

/// The file that a template stands for, for the image that the scene calls `name`. From the component
/// on that has the scene's name in it, the path is trusted as little as the scene.
///
/// # Errors
/// When the scene's name is not allowed.
pub(super) fn filled(template: &Path, name: &str, number: Number) -> Result<Target, Problem> {
    let Some(text) = template.to_str() else { return Ok(Target::path(template.to_owned())) };
    // The scene's name could hold `{n}`, which is no placeholder there, and so comes last.
    let text = text.replace("{n}", &number.image.to_string());
    let text = number.frame.map_or(text.clone(), |n| text.replace("{frame}", &format!("{n:04}")));
    let Some(at) = text.find("{name}") else { return Ok(Target::path(PathBuf::from(text))) };
    let stem = output::stem(name).map_err(Problem::Refused)?;
    let (directory, below) = text.split_at(text[..at].rfind('/').map_or(0, |slash| slash + 1));
    let directory = if directory.is_empty() { "." } else { directory };
    Target::below(Path::new(directory), &below.replace("{name}", stem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_filled() {
        let number = Number { image: 7, frame: Some(12) };
        let fill = |template: &str, name: &str| {
            let target = filled(Path::new(template), name, number).ok()?;
            Some(target.shown().display().to_string())
        };
        assert_eq!(fill("{frame}/{name}", "{frame}.ppm").as_deref(), Some("0012/{frame}"));
        assert_eq!(fill("out/{name}-{n}.png", "a/b.ppm").as_deref(), Some("out/b-7.png"));
        assert_eq!(fill("{name}", "x{n}.ppm").as_deref(), Some("x{n}"));
        assert_eq!(fill("/{name}/{n}.png", "a").as_deref(), Some("/a/7.png"));
        assert_eq!(fill("{name}.png", "../b.ppm"), None);
        assert_eq!(fill("out/{name}/../b.png", "a.ppm"), None);
        assert_eq!(fill("x.png", "../b.ppm").as_deref(), Some("x.png"));
    }

    #[test]
    fn frames_stand_before_the_extension() {
        let names = ["a.ppm", "d.x/a", "d.x/a.b.png", "a"].map(|name| with_frame(name, 7));
        assert_eq!(names, ["a-0007.ppm", "d.x/a-0007", "d.x/a.b-0007.png", "a-0007"]);
    }

    #[test]
    fn a_format_replaces_the_extension_of_another() {
        assert_eq!(with_format("a.b/c.ppm", ImageFormat::Png), "a.b/c.png");
        assert_eq!(formats::of_name(Path::new("a/b.PNG")), Some(ImageFormat::Png));
        assert_eq!(formats::of_name(Path::new("ppm")), None);
    }
}
