//! The files that a process has written, so that no image takes the place of another unnoticed.

use std::collections::HashMap;
use std::fs;
use std::path::PathBuf;

use crate::clean::clean;
use crate::failure::Failure;
use crate::output::Target;

/// What a file holds: the image that the scene gives a name, or something else about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Contents {
    /// The scene's name for the image.
    pub(crate) name: String,
    /// The option by which the user can name the file.
    pub(crate) option: &'static str,
}

/// What a process has written so far, by where that is.
#[derive(Debug, Default)]
pub(crate) struct Written(HashMap<PathBuf, Contents>);

impl Written {
    /// Fails if something else has been written there. A scene that gives the same name twice has its
    /// way, but not where the user has given one name to all images.
    ///
    /// # Errors
    /// When it has.
    pub(crate) fn check(&self, target: &Target, contents: &Contents) -> Result<(), Failure> {
        let path = target.shown();
        let found = fs::canonicalize(&path).ok().and_then(|path| self.0.get(&path));
        let is_free =
            |found: &Contents| matches!(target, Target::Below { .. }) && found == contents;
        match found {
            Some(found) if !is_free(found) => Err(Failure::Usage(format!(
                "more than one image would go to `{}`; use {{n}} in the name that you give with `{}`",
                clean(&path.to_string_lossy()),
                contents.option
            ))),
            _ => Ok(()),
        }
    }

    /// Something has been written. Devices and pipes take any number of images.
    pub(crate) fn add(&mut self, target: &Target, contents: Contents) {
        let path = fs::canonicalize(target.shown()).ok();
        self.0.extend(path.filter(|path| path.is_file()).map(|path| (path, contents)));
    }
}
