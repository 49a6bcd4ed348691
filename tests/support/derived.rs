//! Text in documents that derives from the code: it stands between `<!-- NAME -->` and
//! `<!-- /NAME -->`, and `GMLVM_BLESS=1` rewrites it.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Compares a derived block of a document in `docs/` with what it should be, or replaces it.
#[track_caller]
pub(crate) fn check_block(document: &str, name: &str, expected: &str) {
    // Tests run at the same time and may have to rewrite the same document.
    static TURN: Mutex<()> = Mutex::new(());
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let text = std::fs::read_to_string(docs.join(document)).expect("the manual is there");
    let (opener, closer) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->"));
    let (before, rest) = text.split_once(&opener).expect("the block begins");
    let (found, after) = rest.split_once(&closer).expect("the block ends");
    if found == expected {
        return;
    }
    if std::env::var_os("GMLVM_BLESS").is_none() {
        panic!(
            "docs/{document}: `{name}` is out of date; GMLVM_BLESS=1 rewrites it to\n{expected}"
        );
    }
    // Renamed into place, so that a test reading it meanwhile sees a whole document.
    let blessed = format!("{before}{opener}{expected}{closer}{after}");
    let draft = docs.join(format!("{document}.new"));
    std::fs::write(&draft, blessed).expect("the document can be written");
    std::fs::rename(draft, docs.join(document)).expect("the document can be replaced");
}
