//! Names from scenes: no file outside of the output directory ever changes, and an untrusted scene reads
//! none outside of its own.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use compiler::preprocess::Includes;

use crate::args::{ImageFormat, Inputs};
use crate::fuzzed::take;
use crate::load::FileIncludes;
use crate::output::Existing;
use crate::run::naming::{Destination, Naming, Number, Sink};

/// What others have, and no scene may read or change.
const PRECIOUS: &[u8] = b"precious";

/// What a scene may include.
const OWN: &[u8] = b"own";

/// Components of names that lead somewhere, or may be taken to.
const COMPONENTS: [&str; 22] = [
    "..", ".", "", "out", "victim", "d", "link", "outward", "x", "x.ppm", "new", "a.ppm",
    ".hidden", "\0", "\\", "..\\", "~", "-", "*", "fifo", "{name}", "\u{202e}",
];

/// A directory with two in it, one that is a scene's and one that is not, and links from the first to
/// the second.
#[derive(Debug)]
pub struct Worlds {
    root: PathBuf,
}

/// What there is below a directory: contents of files, none for what is no file.
type Listing = BTreeMap<PathBuf, Option<Vec<u8>>>;

impl Worlds {
    /// Makes them in an empty directory.
    ///
    /// # Errors
    /// When they cannot be made.
    pub fn new(root: &Path) -> io::Result<Self> {
        let worlds = Worlds { root: root.canonicalize()? };
        fs::create_dir_all(root.join("victim/d"))?;
        for name in ["victim/x", "victim/x.ppm", "victim/d/a.ppm", "x", "a.ppm"] {
            fs::write(root.join(name), PRECIOUS)?;
        }
        worlds.make_out()?;
        Ok(worlds)
    }

    fn make_out(&self) -> io::Result<()> {
        let out = self.root.join("out");
        fs::create_dir_all(out.join("d"))?;
        fs::write(out.join("x"), OWN)?;
        fs::write(out.join("d/x"), OWN)?;
        for (to, link) in [
            ("../victim/x", "link"),
            ("../victim", "outward"),
            ("../victim/x.ppm", "x.ppm"),
            ("../../victim/x", "d/link"),
            ("../../victim/new", "d/a.ppm"),
        ] {
            symlink(to, out.join(link))?;
        }
        Ok(())
    }

    /// Writes an image under a name that the bytes make, and includes a file of that name; whether there
    /// was an image.
    ///
    /// # Panics
    /// When something outside of the output directory changes or is read, or something in it that is no
    /// image.
    pub fn any_name(&self, mut bytes: &[u8]) -> bool {
        let options = take(&mut bytes);
        let existing = if options & 1 == 0 { Existing::Replace } else { Existing::Keep };
        let format = (options & 2 != 0).then_some(ImageFormat::Png);
        let frame = (options & 4 != 0).then_some(7);
        let name = name(options & 8 != 0, bytes);
        self.include(&name);
        let before = self.outside();
        let naming = Naming::Scene(self.root.join("out"));
        let written = match naming.destination(&name, Number { image: 1, frame }, format) {
            Ok(Destination { sink: Sink::File(target), .. }) => target
                .check(existing)
                .and_then(|()| target.write(existing, &mut |out| out.write_all(b"P6 image"))),
            Ok(destination) => panic!("{name:?} leads to {destination:?}"),
            Err(problem) => Err(problem),
        };
        assert_eq!(self.outside(), before, "{name:?} leads out");
        let own = [self.root.join("out/x"), self.root.join("out/d/x")];
        let is_kept = own.iter().all(|path| fs::read(path).is_ok_and(|bytes| bytes == OWN));
        assert!(is_kept, "{name:?} replaces what is no image");
        if written.is_ok() {
            fs::remove_dir_all(self.root.join("out")).expect("removed");
            self.make_out().expect("made anew");
        }
        written.is_ok()
    }

    /// Includes a file of this name from a scene in the directory; none but the scene's own is read.
    fn include(&self, name: &str) {
        let inputs =
            Inputs { defines: Vec::new(), include_dirs: Vec::new(), untrusted: true, max_words: 0 };
        let directory = self.root.join("out");
        let scene = directory.join("s.gml").display().to_string();
        let mut includes = FileIncludes::new(scene.clone(), Some(&directory), &inputs);
        if let Some((_, bytes)) = includes.load(&scene, name) {
            assert_eq!(bytes, OWN, "{name:?} is not the scene's own");
        }
    }

    fn outside(&self) -> Listing {
        let mut found = Listing::new();
        list(&self.root, &self.root.join("out"), &mut found);
        found
    }
}

/// A name of components that lead somewhere, or of any text.
fn name(is_any: bool, mut bytes: &[u8]) -> String {
    if is_any {
        return String::from_utf8_lossy(bytes).into_owned();
    }
    let mut name = String::new();
    while !bytes.is_empty() {
        let byte = usize::from(take(&mut bytes));
        name += COMPONENTS[byte % COMPONENTS.len()];
        if byte < 200 {
            name.push('/');
        }
    }
    name
}

fn list(directory: &Path, but: &Path, found: &mut Listing) {
    for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
        let path = entry.path();
        if path == but {
            continue;
        }
        let is_directory = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_directory {
            list(&path, but, found);
        }
        let contents = if is_directory { None } else { fs::read(&path).ok() };
        found.insert(path, contents);
    }
}
