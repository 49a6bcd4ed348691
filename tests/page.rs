//! The page of `gmlvm disasm --html`, in a browser without a window; skipped where there is none.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use support::gmlvm::Sandbox;

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod gmlvm;
}

const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Its text tries to leave the place where the page holds it, and to put a right-to-left mark in.
const SCENE: &str = "\
% </script><script>document.title = 'owned'</script> {style} \u{202e}
{ /factor
  { /v /u /face
    u v mulf /product % <img src=x onerror=\"document.title = 'owned'\">
    product product 0.5 point
    v 0.25 1.0 } } /made
{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 } /plain
0.5 0.5 0.5 point [] 1 made apply sphere plain plane union 1 90.0 4 3 \"a.ppm\" render
";

/// Goes over the page as a reader would, and leaves what there is to see in an element.
const READER: &str = include_str!("support/reader.js");

fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let found = std::env::split_paths(&path)
        .flat_map(|folder| BROWSERS.map(|name| folder.join(name)))
        .find(|path| path.is_file());
    if found.is_none() {
        println!("skipped: none of {} is installed", BROWSERS.join(", "));
    }
    found
}

/// The document that a page becomes.
fn document(browser: &Path, sandbox: &Sandbox, page: &str) -> String {
    let out = sandbox.path("document.html");
    let mut child = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", sandbox.path("profile").display()))
        .arg("--dump-dom")
        .arg(format!("file://{}", sandbox.path(page).display()))
        .stdin(Stdio::null())
        .stdout(File::create(&out).expect("a file"))
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser runs");
    let start = Instant::now();
    while child.try_wait().expect("it can be waited for").is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().expect("it can be ended");
            panic!("the browser does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    std::fs::read_to_string(out).expect("text")
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let name = "<b>&{data}.gml";
    sandbox.file(name, SCENE);
    let ended = sandbox.run(&["disasm", name, "--html", "page.html"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    sandbox
}

/// Undoes JavaScript's `encodeURIComponent`.
fn decoded(text: &str) -> Vec<u8> {
    let mut pieces = text.split('%');
    let mut bytes = pieces.next().unwrap_or_default().as_bytes().to_vec();
    for piece in pieces {
        let (code, rest) = piece.split_at(2);
        bytes.push(u8::from_str_radix(code, 16).expect("two digits"));
        bytes.extend_from_slice(rest.as_bytes());
    }
    bytes
}

/// What the reader saw.
fn seen(browser: &Path) -> Value {
    let sandbox = sandbox();
    let page = String::from_utf8(sandbox.read("page.html")).expect("text");
    // The page's policy would stop the reader, too.
    let (before, after) = page.split_once("script-src ").expect("a policy");
    let (_, after) = after.split_once(';').expect("it goes on");
    let page = format!("{before}script-src 'unsafe-inline';{after}");
    sandbox
        .file("read.html", page.replace("</body>", &format!("<script>{READER}</script></body>")));
    let document = document(browser, &sandbox, "read.html");
    let result = document.split("<pre id=\"seen\">").nth(1);
    let result = result.unwrap_or_else(|| panic!("{document}")).split('<').next();
    let result = result.expect("it ends");
    serde_json::from_slice(&decoded(result)).expect("JSON")
}

/// The rows lit in a pane; `how` is "near", for those of the same line, or "same".
fn lit(seen: &Value, pane: &str, how: &str) -> Vec<String> {
    let rows = seen[pane][how].as_array().expect("an array");
    rows.iter().map(|row| row.as_str().expect("text").to_owned()).collect()
}

#[test]
fn hovering_and_focus_light_what_belongs_together() {
    let Some(browser) = browser() else { return };
    let seen = seen(&browser);
    let at_source = &seen["source"];
    let line = lit(at_source, "source", "same");
    assert!(line.len() == 1 && line[0].starts_with("u v mulf /product"), "{line:?}");
    assert_eq!(lit(at_source, "bytecode", "near"), ["MulF              r3 r1 r0"]);
    let clif = lit(at_source, "clif", "near");
    assert!(clif.len() == 1 && clif[0].contains("= fmul.f64 v2, v3"), "{clif:?}");
    if cfg!(target_arch = "x86_64") {
        let asm = lit(at_source, "asm", "near");
        assert!(!asm.is_empty() && asm.iter().any(|row| row.contains("mulsd")), "{asm:?}");
        let at_asm = &seen["asm"];
        assert_eq!(lit(at_asm, "source", "near"), line);
        assert_eq!(lit(at_asm, "bytecode", "same"), ["MulF              r3 r1 r0"]);
        assert_eq!(lit(at_asm, "clif", "same"), clif);
    }
    for pane in ["source", "bytecode", "clif", "asm"] {
        assert!(lit(&seen["nothing"], pane, "near").is_empty(), "{pane}");
        assert!(lit(&seen["nothing"], pane, "same").is_empty(), "{pane}");
    }
    // By keyboard, from the source to the bytecode; what has the focus stays lit.
    assert_eq!(seen["focused"], "bytecode 0001MulF              r3 r1 r0");
    assert_eq!(lit(&seen["kept"], "bytecode", "same"), ["MulF              r3 r1 r0"]);
    assert_eq!(lit(&seen["kept"], "source", "near"), line);
}

#[test]
fn surfaces_and_forms_are_chosen() {
    let Some(browser) = browser() else { return };
    let seen = seen(&browser);
    assert_eq!(seen["names"][1], "surface 1: function 2 `plain`");
    assert!(seen["outcome"].as_str().is_some_and(|text| text.starts_with("constant, color")));
    assert!(seen["clif"].as_str().is_some_and(|text| text.starts_with("There is no code")));
    // The policy lets the style through.
    assert_eq!(seen["layout"], "flex");
    assert_eq!(seen["tabs"], serde_json::json!([false, true, true]));
}

#[test]
fn programs_stay_text() {
    let sandbox = sandbox();
    let page = String::from_utf8(sandbox.read("page.html")).expect("text");
    assert_eq!(page.matches("<script").count(), 2);
    assert!(!page.contains("<img") && !page.contains('\u{202e}') && !page.contains("<b>"));
    assert!(page.contains("<title>&lt;b&gt;&amp;{data}.gml</title>"));
    for elsewhere in ["http:", "https:", "src=\"", "href", "@import", "url("] {
        assert!(!page.contains(elsewhere), "{elsewhere}");
    }
    let Some(browser) = browser() else { return };
    // As it is, with its policy: the script runs, and so its hash is right.
    let document = document(&browser, &sandbox, "page.html");
    assert!(document.contains("<title>&lt;b&gt;&amp;{data}.gml</title>"), "{document}");
    assert!(document.contains("class=\"row linked\""), "{document}");
    let seen = seen(&browser);
    assert_eq!((&seen["title"], &seen["images"]), (&"<b>&{data}.gml".into(), &0.into()));
}
