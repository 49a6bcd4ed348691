//! What a part is a part of: a scene with all that goes into it, and the settings that its pixels hang
//! on.

use compiler::source::SourceMap;
use serde::{Deserialize, Serialize};

use crate::args::RunArgs;
use crate::run::digest::Digest;

/// What parts must have in common to be joined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Identity {
    /// The version of gmlvm: another one may compute other pixels.
    gmlvm: String,
    /// Hash of the scene's text, of all that it includes, and of what the command line binds.
    scene: String,
    /// Hash of the options that the picture hangs on.
    settings: String,
}

impl Identity {
    /// Of a run of what was read into `sources`. Where the files are does not matter: machines may
    /// have them in different places.
    pub(super) fn new(args: &RunArgs, sources: &SourceMap) -> Self {
        let mut scene = Digest::default();
        let mut add = |text: &str| {
            scene.add(&(text.len() as u64).to_le_bytes());
            scene.add(text.as_bytes());
        };
        sources.files().for_each(|file| add(&file.text));
        args.inputs.defines.iter().for_each(|define| add(&define.text));
        let mut settings = Digest::default();
        // What is derived has all the options, those to come included.
        settings.add(
            format!("{:?} {:?} {:?}", args.picture, args.sampling, args.precision()).as_bytes(),
        );
        Identity {
            gmlvm: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.to_string(),
            settings: settings.to_string(),
        }
    }

    /// What tells `other` apart, in words; none if they are the same.
    pub(super) fn difference(&self, other: &Identity) -> Option<&'static str> {
        if self.gmlvm != other.gmlvm {
            Some("by another version of gmlvm")
        } else if self.scene != other.scene {
            Some("of another scene, or an earlier state of it")
        } else if self.settings != other.settings {
            Some("of this scene, but with other settings of the picture")
        } else {
            None
        }
    }
}
