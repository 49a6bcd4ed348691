//! The page in Chromium without a window, driven by Playwright; skipped where either is absent.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::gmlvm::Sandbox;

fn chromium() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let mut places = std::env::split_paths(&path).flat_map(|folder| names.map(|n| folder.join(n)));
    places.find(|place| place.is_file())
}

fn has_playwright() -> bool {
    let mut python = Command::new("python3");
    python.args(["-c", "import playwright.sync_api"]).stdout(Stdio::null()).stderr(Stdio::null());
    python.status().is_ok_and(|status| status.success())
}

/// The checks are in `browser.py`. Its screenshots stay in the folder for temporary files of the build.
#[test]
fn the_page_does_in_a_browser_what_it_should() {
    let Some(chromium) = chromium() else {
        println!("skipped: no Chromium is installed");
        return;
    };
    if !has_playwright() {
        println!("skipped: Playwright for Python is not installed");
        return;
    }
    let sandbox = Sandbox::new();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/view/browser.py");
    let shots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view");
    let output = Command::new("python3")
        .arg(script)
        .args([Path::new(env!("CARGO_BIN_EXE_gmlvm")), &chromium, &sandbox.path(""), &shots])
        .output()
        .expect("Python runs");
    let told = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}\n{errors}");
    assert!(told.ends_with("all checks passed\n"), "{told}\n{errors}");
}
