//! `gmlvm view`: what its server answers, to whom, and within which limits; and the page in a browser,
//! where there is one.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::client::{PATIENCE, Server, choice};
use crate::gmlvm::{Sandbox, ball};

mod browser;
mod client;
#[allow(dead_code, reason = "it serves several test programs")]
#[path = "../support/gmlvm.rs"]
mod gmlvm;
mod hostile;
mod maps;

/// A scene that would take for ever, by itself.
pub(crate) const ENDLESS: &str = "{ /self self self apply } /f f f apply\n";

fn of_kind<'e>(events: &'e [Value], kind: &str) -> &'e Value {
    let found = events.iter().find(|event| event["event"] == kind);
    found.unwrap_or_else(|| panic!("no {kind}: {events:?}"))
}

fn file(server: &Server, event: &Value) -> Vec<u8> {
    let answer = server.get(&format!("file/{}", event["number"]));
    assert_eq!(answer.status, 200, "{answer:?}");
    answer.body
}

/// What `gmlvm run` makes of the scene.
fn png(sandbox: &Sandbox, scene: &str) -> Vec<u8> {
    let ended = sandbox.run(&["run", scene, "--format", "png", "--output", "-", "-q"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    ended.stdout
}

#[test]
fn a_scene_is_shown_with_all_there_is_to_know() {
    let sandbox = Sandbox::new();
    let large = ball("a.ppm").replace("8 6", "64 48");
    sandbox.file("s.gml", &large);
    let server = Server::start(&sandbox, &["s.gml"]);
    let mut events = server.events();
    let source = events.next();
    assert_eq!((&source["event"], &source["text"]), (&json!("source"), &json!(large)));
    assert_eq!((&source["edit"], &source["revision"]), (&json!(false), &json!(1)));
    let of_run = events.all_of(1);
    let started = of_kind(&of_run, "started");
    assert_eq!(started["choice"], choice());
    let image = of_kind(&of_run, "image");
    assert_eq!(
        (&image["width"], &image["height"], &image["name"]),
        (&json!(64), &json!(48), &json!("a.ppm"))
    );
    assert_eq!(file(&server, of_kind(&of_run, "picture")), png(&sandbox, "s.gml"));
    // The figures of `--stats`, but for times.
    let stats = &of_kind(&of_run, "stats")["stats"];
    sandbox.run(&["run", "s.gml", "--stats", "stats.json"]);
    let expected: Value = serde_json::from_slice(&sandbox.read("stats.json")).expect("JSON");
    for key in ["rays", "counts", "engine", "precision", "sampling", "threads", "scene"] {
        assert_eq!(stats[key], expected[key], "{key}");
    }
    let code = events.until("code", 1);
    let code: Value = serde_json::from_slice(&file(&server, &code)).expect("JSON");
    assert_eq!(code["files"][0]["name"], "s.gml");
    assert!(code["surfaces"][0]["outcome"].as_str().is_some_and(|o| o.starts_with("constant")));
    let plan = events.until("plan", 1);
    let explained = sandbox.run(&["run", "s.gml", "--explain"]).stderr;
    let uses = plan["lines"][0].as_str().expect("a line");
    assert!(explained.contains(uses), "{uses}\n{explained}");
    for diagram in ["rounding", "sampling"] {
        let chart = events.until("chart", 1);
        assert_eq!(chart["diagram"], diagram);
        assert!(chart["tables"][0]["rows"].as_array().is_some_and(|rows| rows.len() > 4));
        assert!(file(&server, &chart).starts_with(b"<svg"));
    }
    // Nothing has been written beside the scene.
    assert_eq!(sandbox.files(), ["a.ppm", "s.gml", "stats.json"]);
}

#[test]
fn errors_are_those_of_the_command_line_and_leave_the_last_image() {
    let sandbox = Sandbox::new();
    let broken = "1 2 addf\n";
    sandbox.file("s.gml", ball("a.ppm")).file("broken.gml", broken);
    let server = Server::start(&sandbox, &["s.gml"]);
    let mut events = server.events();
    let first = events.all_of(1);
    let picture = of_kind(&first, "picture");
    let run = server.run(broken);
    let ended = events.until("ended", run);
    assert_eq!(ended["ok"], false);
    let diagnostic = &ended["diagnostics"][0];
    let told = sandbox.run(&["run", "broken.gml", "--message-format", "json"]).stderr;
    let told: Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!((&diagnostic["code"], &diagnostic["message"]), (&told["code"], &told["message"]));
    assert_eq!(diagnostic["spans"][0]["column"], told["spans"][0]["column"]);
    assert_eq!(diagnostic["spans"][0]["file"], "s.gml");
    // Whoever comes now sees both, and the unsaved text.
    let mut late = server.events();
    assert_eq!(late.next()["event"], "source");
    assert!(late.all_of(1).iter().any(|event| event == picture));
    assert_eq!(late.until("started", run)["text"], broken);
    assert_eq!(file(&server, picture), png(&sandbox, "s.gml"));
    // Repaired, by another method.
    let dd = json!({ "engine": "interp", "precision": "dd", "sampling": "grid 2" });
    let answer = server.post("run", &json!({ "text": ball("b.ppm"), "choice": dd }));
    let run = answer.json()["run"].as_u64().expect("a number");
    let repaired = events.all_of(run);
    assert_eq!(of_kind(&repaired, "ended")["ok"], true);
    let stats = &of_kind(&repaired, "stats")["stats"];
    assert_eq!(
        (&stats["engine"], &stats["precision"], &stats["sampling"]),
        (&json!("interp"), &json!("dd"), &json!("grid 2"))
    );
    assert_eq!(server.get(&format!("file/{}", picture["number"])).status, 204);
}

#[test]
fn what_is_saved_by_any_program_is_rendered() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", "#include \"ball.ins\"\n");
    let server = Server::start(&sandbox, &["s.gml"]);
    let mut events = server.events();
    assert_eq!(events.until("ended", 1)["diagnostics"][0]["code"], "E0010");
    sandbox.file("ball.ins", ball("a.ppm"));
    assert_eq!(events.until("ended", 2)["ok"], true);
    // As editors do it: a new file in place of the old one.
    sandbox.file("s.gml.new", ball("b.ppm"));
    fs::rename(sandbox.path("s.gml.new"), sandbox.path("s.gml")).expect("renamed");
    let source = events.until("source", 0);
    assert_eq!((&source["revision"], &source["text"]), (&json!(2), &json!(ball("b.ppm"))));
    assert_eq!(events.until("image", 3)["name"], "b.ppm");
    assert_eq!(events.until("ended", 3)["ok"], true);
    fs::remove_file(sandbox.path("s.gml")).expect("removed");
    assert!(
        events.until("disk", 0)["error"].as_str().is_some_and(|e| e.contains("cannot be read"))
    );
    // Whoever comes now sees the text all the same.
    assert_eq!(server.events().next()["text"], ball("b.ppm"));
    // The same text again: the page is told that it is there.
    sandbox.file("s.gml", ball("b.ppm"));
    assert_eq!(events.until("source", 0)["revision"], 3);
    sandbox.file("s.gml", ball("c.ppm"));
    while events.next()["name"] != "c.ppm" {}
}

#[test]
fn slow_images_come_coarse_first_and_then_in_bands() {
    let sandbox = Sandbox::new();
    let scene = ball("a.ppm").replace("8 6", "320 240");
    sandbox.file("s.gml", &scene);
    let server = Server::start(&sandbox, &["s.gml", "--samples", "16"]);
    let mut events = server.events();
    let mut rows = 0..0;
    let first = events.until("coarse", 1);
    assert_eq!((&first["width"], &first["height"]), (&json!(40), &json!(30)));
    let picture = loop {
        let event = events.next();
        match event["event"].as_str() {
            Some("band") => {
                assert_eq!(event["y"], rows.end, "bands follow one another");
                rows.end += event["height"].as_u64().expect("a number");
            }
            Some("picture") => break event,
            other => panic!("{other:?}"),
        }
    };
    assert!(rows.end > 0 && rows.end < 240, "{rows:?}");
    let ended =
        sandbox.run(&["run", "s.gml", "--samples", "16", "--format", "png", "--output", "-"]);
    assert_eq!(file(&server, &picture), ended.stdout);
    // Drafts are of no use to whoever comes later.
    let mut late = server.events();
    let all = late.all_of(1);
    assert!(
        all.iter().all(|event| event["event"] != "coarse" && event["event"] != "band"),
        "{all:?}"
    );
}

#[test]
fn a_new_run_ends_the_one_before() {
    let sandbox = Sandbox::new();
    sandbox.file("cancelled.gml", ball("a.ppm"));
    let mut server = Server::start(&sandbox, &["cancelled.gml", "--fuel", "1000000000000000"]);
    let mut events = server.events();
    events.until("ended", 1);
    let endless = server.run(ENDLESS);
    events.until("started", endless);
    thread::sleep(Duration::from_millis(300));
    let begun = Instant::now();
    let next = server.run(&ball("b.ppm"));
    let all = events.all_of(next);
    assert_eq!(of_kind(&all, "ended")["ok"], true);
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    assert_eq!(workers(server.pid()).len(), 1);
    // And no worker survives its server, however that ends.
    server.run(ENDLESS);
    let workers = workers(server.pid());
    assert_eq!(workers.len(), 1);
    server.kill();
    let begun = Instant::now();
    while workers.iter().any(|pid| is_alive(*pid)) {
        assert!(begun.elapsed() < PATIENCE, "a worker is left");
        thread::sleep(Duration::from_millis(20));
    }
}

/// The processes that this one has started.
fn workers(parent: u32) -> Vec<u32> {
    let processes = fs::read_dir("/proc").expect("Linux").flatten();
    let numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_child = |pid: &u32| {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        let after_name = stat.rsplit(") ").next().unwrap_or_default().split(' ').nth(1);
        after_name.is_some_and(|found| found == parent.to_string())
    };
    numbers.filter(is_child).collect()
}

/// Whether there is such a process, and it has not ended.
fn is_alive(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with('Z'))
}

#[test]
fn pixels_tell_what_they_are_about() {
    let sandbox = Sandbox::new();
    let scene =
        format!("% two lines\n\n{}", ball("a.ppm").replace(" 1.0 1.0 1.0", "\n1.0 1.0 1.0"));
    sandbox.file("s.gml", scene);
    let server = Server::start(&sandbox, &["s.gml"]);
    server.events().until("ended", 1);
    let centre = server.get("pixel?run=1&image=0&x=4&y=3").json();
    assert_eq!(centre["color"], json!([127, 127, 127]));
    let seen = &centre["seen"];
    assert_eq!(
        (&seen["kind"], &seen["shape"], &seen["surface"]),
        (&json!("sphere"), &json!(0), &json!(0))
    );
    assert_eq!(seen["function"], json!({ "file": "s.gml", "line": 3, "end": 4 }));
    assert_eq!(seen["how"], "interpreted: called too seldom to be worth compiling");
    assert_eq!(
        (&centre["rays"]["primary"], &centre["rays"]["surface_calls"]),
        (&json!(1), &json!(1))
    );
    assert!(centre["instructions"].as_u64().is_some_and(|n| n > 0));
    assert_eq!(centre["certainty"], "certain in doubles");
    let corner = server.get("pixel?run=1&image=0&x=0&y=0").json();
    assert_eq!((&corner["color"], &corner["seen"]), (&json!([0, 0, 0]), &Value::Null));
    for elsewhere in ["run=1&image=0&x=8&y=3", "run=1&image=1&x=0&y=0", "run=2&image=0&x=0&y=0"] {
        assert_eq!(server.get(&format!("pixel?{elsewhere}")).json(), Value::Null, "{elsewhere}");
    }
    for bad in ["", "run=1", "run=1&image=0&x=-1&y=0", "run=1&image=0&x=99999999999&y=0"] {
        assert_eq!(server.get(&format!("pixel?{bad}")).status, 400, "{bad}");
    }
}

#[test]
fn only_with_edit_is_the_file_written() {
    let sandbox = Sandbox::new();
    let (old, new) = (ball("a.ppm"), ball("b.ppm"));
    sandbox.file("s.gml", &old);
    let server = Server::start(&sandbox, &["s.gml"]);
    let save = json!({ "text": new, "revision": 1 });
    assert_eq!(server.post("save", &save).status, 403);
    assert_eq!(sandbox.read("s.gml"), old.as_bytes());

    let mode = || fs::metadata(sandbox.path("s.gml")).expect("a file").permissions().mode() & 0o777;
    fs::set_permissions(sandbox.path("s.gml"), Permissions::from_mode(0o600)).expect("set");
    let server = Server::start(&sandbox, &["s.gml", "--edit"]);
    let mut events = server.events();
    assert_eq!(events.next()["edit"], true);
    assert_eq!(server.post("save", &json!({ "text": new, "revision": 7 })).status, 409);
    assert_eq!(sandbox.read("s.gml"), old.as_bytes());
    let answer = server.post("save", &save);
    assert_eq!((answer.status, answer.json()), (200, json!({ "revision": 2 })));
    assert_eq!(sandbox.read("s.gml"), new.as_bytes());
    assert_eq!(mode(), 0o600, "still nobody else's business");
    assert_eq!(sandbox.files(), ["s.gml"]);
    // What somebody else has saved meanwhile is not lost, whether that has been noticed yet or not.
    sandbox.file("s.gml", "1");
    assert_eq!(server.post("save", &json!({ "text": old, "revision": 2 })).status, 409);
    assert_eq!(sandbox.read("s.gml"), b"1");
    // Text of another encoding is shown as it is rendered, but would not be the same if it were saved.
    sandbox.file("s.gml", b"% caf\xe9\n");
    let source = loop {
        let source = events.until("source", 0);
        if source["text"] == "% caf\u{e9}\n" {
            break source;
        }
    };
    assert_eq!(source["edit"], false);
    assert_eq!(
        server.post("save", &json!({ "text": old, "revision": source["revision"] })).status,
        409
    );
}

#[test]
fn scenes_are_not_trusted() {
    let sandbox = Sandbox::new();
    sandbox.file("secret.ins", "\"secret\"").file("d/s.gml", "#include \"../secret.ins\"\n");
    let server = Server::start(&sandbox, &["d/s.gml", "--timeout", "1", "--fuel", "1000000000000"]);
    let mut events = server.events();
    assert_eq!(events.until("ended", 1)["diagnostics"][0]["code"], "E0010");
    let code = |text: &str| {
        let run = server.run(text);
        server.events().until("ended", run)["diagnostics"][0]["code"].clone()
    };
    assert_eq!(code(ENDLESS), "E0405");
    let size = |size: &str| ball("a.ppm").replace("8 6", size);
    assert_eq!(code(&size("100000 100000")), "E0404");
    // Names are only shown: nothing is written anywhere.
    let run = server.run(&ball("../../etc/passwd"));
    assert_eq!(events.until("image", run)["name"], "../../etc/passwd");
    assert_eq!(events.until("ended", run)["ok"], true);
    assert_eq!(sandbox.files(), ["d/", "d/s.gml", "secret.ins"]);
}

#[test]
fn two_hundred_runs_leave_the_server_as_it_was() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let server = Server::start(&sandbox, &["s.gml"]);
    let mut events = server.events();
    let mut run_some = |n: u64| {
        for index in 0..n {
            let run = server.run(&format!("{index} pop {}", ball("a.ppm")).replace("pop", "/x"));
            assert_eq!(events.until("ended", run)["ok"], true);
        }
    };
    run_some(10);
    let before = server.resident();
    run_some(200);
    let after = server.resident();
    let allowed = 20 << 20;
    assert!(after < before + allowed, "{before} bytes, then {after}");
}

#[test]
fn the_worker_is_nobodys_business() {
    let sandbox = Sandbox::new();
    for args in [&["view", "--help"][..], &["completions", "bash"], &["completions", "fish"]] {
        assert!(!sandbox.run(args).text().contains("worker"), "{args:?}");
    }
    let refused = sandbox.run(&["view", "-"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("cannot be viewed"), "{}", refused.stderr);
    assert_eq!(sandbox.run(&["view", "none.gml"]).code, 2);
    assert!(!Path::new(&sandbox.path("none.gml")).exists());
}
