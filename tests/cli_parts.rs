//! Images in parts: however many runs, shards and interruptions they come from, they are those of a
//! single run, to the last byte; and nothing else is ever taken for a part of them.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::gmlvm::{Ended, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// Three images of different kinds, of 16, 2 and 1 bands.
fn scene() -> String {
    let shiny = "{ /v /u /face u v u point 0.7 0.6 9.0 }";
    let world = format!(
        "0.3 0.3 0.3 point [ 1.0 -1.0 1.0 point 1.0 1.0 1.0 point light ] {shiny} sphere 0.0 0.0 3.0 \
         translate {shiny} plane 0.0 -1.0 0.0 translate union 4 70.0"
    );
    format!(
        "{world} 40 62 \"a.ppm\" render\n{world} 9 7 \"sub/b.pfm\" render\n{world} 5 3 \"c.png\" \
         render\n"
    )
}

const IMAGES: [&str; 3] = ["a.ppm", "sub/b.pfm", "c.png"];

/// A sandbox with the scene, and in `single/` what a single run makes of it.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", scene());
    ok(&sandbox.run(&["s.gml", "-o", "single"]));
    sandbox
}

#[track_caller]
fn ok(ended: &Ended) {
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

#[track_caller]
fn same(sandbox: &Sandbox, directory: &str) {
    for image in IMAGES {
        let [made, single] = [directory, "single"].map(|d| sandbox.read(&format!("{d}/{image}")));
        assert!(made == single, "{directory}/{image}");
    }
}

fn run<'a>(sandbox: &Sandbox, options: impl AsRef<[&'a str]>) -> Ended {
    sandbox.run(&[&["run", "s.gml"], options.as_ref()].concat())
}

/// The part files in `p`, but for the one that tells of the end.
fn bands(sandbox: &Sandbox) -> Vec<String> {
    let files = sandbox.files().into_iter();
    files.filter(|f| f.starts_with("p/") && f.ends_with(".part") && !f.contains("end")).collect()
}

#[test]
fn parts_make_the_image() {
    let sandbox = sandbox();
    let ended = run(&sandbox, ["--parts", "p", "-o", "out", "-j", "3"]);
    ok(&ended);
    assert!(ended.stderr.contains("a.ppm  40x62  16 of 16 bands  "), "{}", ended.stderr);
    same(&sandbox, "out");
    assert_eq!(bands(&sandbox).len(), 16 + 2 + 1);
    // What is there is not rendered again, nor is it written.
    let before = fs::metadata(sandbox.path("p/0001-000008.part")).expect("there").modified();
    let ended = run(&sandbox, ["--parts", "p", "-o", "again", "--stats", "stats.json"]);
    ok(&ended);
    assert!(ended.stderr.contains("16 of 16 bands, 16 of them there already"), "{}", ended.stderr);
    same(&sandbox, "again");
    let after = fs::metadata(sandbox.path("p/0001-000008.part")).expect("there").modified();
    assert_eq!(before.expect("a time"), after.expect("a time"));
    let stats = String::from_utf8(sandbox.read("stats.json")).expect("text");
    assert!(stats.contains("\"primary\": 0,") && stats.contains("\"pixels\": 0,"), "{stats}");
    ok(&sandbox.run(&["merge", "p", "-o", "merged"]));
    same(&sandbox, "merged");
}

#[test]
fn any_shards_make_the_image() {
    let sandbox = sandbox();
    for n in [1, 2, 3, 7, 40] {
        let _ = fs::remove_dir_all(sandbox.path("p"));
        for k in 1..=n {
            let engine = if k % 2 == 0 { "interp" } else { "jit" };
            let shard = format!("{k}/{n}");
            let threads = (k % 3 + 1).to_string();
            let options = [
                "--parts", "p", "--shard", &shard, "-j", &threads, "--engine", engine, "-o", "none",
            ];
            let ended = run(&sandbox, options);
            ok(&ended);
            assert!(
                ended.stderr.contains(&format!("of 16 bands, shard {shard}")),
                "{}",
                ended.stderr
            );
            // A shard of so many may have nothing to do.
            if k < n && n < 19 {
                assert_eq!(sandbox.run(&["merge", "p", "-o", "early"]).code, 2);
            }
        }
        assert!(!sandbox.path("none").exists() && !sandbox.path("early").exists());
        ok(&sandbox.run(&["merge", "p", "-o", "merged"]));
        same(&sandbox, "merged");
        // A last run without a shard is as good as merging.
        ok(&run(&sandbox, ["--parts", "p", "-o", "whole"]));
        same(&sandbox, "whole");
        for directory in ["merged", "whole"] {
            fs::remove_dir_all(sandbox.path(directory)).expect("there");
        }
    }
}

/// Machines may have the scene elsewhere, and its parts in several directories.
#[test]
fn parts_come_from_anywhere() {
    let sandbox = sandbox();
    let two = scene().replace("\"c.png\"", "c");
    sandbox.file("x/s.gml", format!("#include \"i.ins\"\n{two}")).file("x/i.ins", "\"c.png\" /c\n");
    sandbox
        .file("y/z/s.gml", format!("#include \"i.ins\"\n{two}"))
        .file("y/z/i.ins", "\"c.png\" /c\n");
    ok(&sandbox.run(&["run", "x/s.gml", "--parts", "p1", "--shard", "1/2"]));
    let stdin = sandbox.read("y/z/s.gml");
    ok(&sandbox.run_with(&["-", "-I", "y/z", "--parts", "p2", "--shard", "2/2"], &stdin));
    let end = sandbox.run(&["merge", "p1", "-o", "merged"]);
    assert_eq!(end.code, 2, "{}", end.stderr);
    ok(&sandbox.run(&["merge", "p1", "p2", "-o", "merged"]));
    same(&sandbox, "merged");
    ok(&sandbox.run(&["merge", "p2", "p1/0001-000004.part", "p1", "-o", "again"]));
    same(&sandbox, "again");
}

#[test]
fn merging_names_and_formats() {
    let sandbox = sandbox();
    ok(&run(&sandbox, ["--parts", "p", "-o", "out"]));
    ok(&sandbox.run(&["merge", "p", "--output", "{n}-{name}"]));
    assert_eq!(sandbox.read("1-a"), sandbox.read("single/a.ppm"));
    assert_eq!(sandbox.read("2-b"), sandbox.read("single/sub/b.pfm"));
    assert_eq!(sandbox.read("3-c"), sandbox.read("single/c.png"));
    let ended = sandbox.run(&["merge", "p", "--output", "-"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    // As with `run`, nothing is replaced if that is asked for.
    sandbox.file("2-b", "P6 precious");
    let ended = sandbox.run(&["merge", "p", "--output", "{n}-{name}", "--no-clobber"]);
    assert_eq!(ended.code, 3, "{}", ended.stderr);
    let message =
        "could not write `1-a`: it exists already; remove it, or allow replacing with `--clobber`";
    assert!(ended.stderr.contains(message), "{}", ended.stderr);
    assert_eq!(sandbox.read("2-b"), b"P6 precious");
    ok(&sandbox.run(&["merge", "p", "--output", "{n}+{name}", "--no-clobber"]));
    ok(&sandbox.run(&["merge", "p", "--output", "{n}-{name}", "--no-clobber", "--clobber"]));
    assert_eq!(sandbox.read("2-b"), sandbox.read("2+b"));
    // Nor does one image take the place of another.
    let ended = sandbox.run(&["merge", "p", "--output", "joined"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("more than one image would go to `joined`"), "{}", ended.stderr);
    assert_eq!(sandbox.read("joined"), sandbox.read("single/a.ppm"));
    let ended = sandbox.run(&["merge", "p", "--format", "pfm", "-o", "none"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("the parts hold bytes"), "{}", ended.stderr);
    let ended = sandbox.run(&["merge", "p", "--max-pixels", "1000", "-o", "none"]);
    assert_eq!(ended.code, 4);
    assert!(ended.stderr.contains("--max-pixels"), "{}", ended.stderr);
    assert!(!sandbox.path("none").exists());
    // Parts of bytes serve both formats of bytes.
    sandbox.file("one.gml", ball("a.ppm"));
    ok(&sandbox.run(&["one.gml", "--parts", "q", "--format", "png", "-o", "png"]));
    ok(&sandbox.run(&["one.gml", "--parts", "q", "-o", "ppm"]));
    ok(&sandbox.run(&["merge", "q", "-o", "merged"]));
    assert_eq!(sandbox.read("merged/a.png"), sandbox.read("png/a.png"));
    let ended = sandbox.run(&["merge", "q", "--output", "-", "--format", "ppm", "-q"]);
    assert_eq!(ended.stdout, sandbox.read("ppm/a.ppm"));
    let ended = sandbox.run(&["one.gml", "--parts", "q", "--format", "pfm", "-o", "none"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("linear light (PFM)"), "{}", ended.stderr);
}

/// With `--region` only its rows are rendered, and only they are missed.
#[test]
fn regions_have_parts() {
    let sandbox = sandbox();
    let region = ["--region", "3,1,30,27"];
    ok(&run(&sandbox, [&region[..], &["-o", "region"]].concat()));
    for shard in ["2/2", "1/2"] {
        ok(&run(&sandbox, [&region[..], &["--parts", "p", "--shard", shard]].concat()));
    }
    ok(&sandbox.run(&["merge", "p", "-o", "merged"]));
    for image in IMAGES {
        let [made, single] = ["merged", "region"].map(|d| sandbox.read(&format!("{d}/{image}")));
        assert!(made == single && made != sandbox.read(&format!("single/{image}")), "{image}");
    }
}

/// A part that is not whole is rendered again; merging it is refused.
#[test]
fn damaged_parts_are_rendered_again() {
    let sandbox = sandbox();
    ok(&run(&sandbox, ["--parts", "p", "-o", "out"]));
    let part = "p/0001-000020.part";
    let whole = sandbox.read(part);
    let mut flipped = whole.clone();
    *flipped.last_mut().expect("not empty") ^= 1;
    let mut header = whole.clone();
    let at = header.windows(9).position(|w| w == b"\"scene\":\"").expect("a header") + 10;
    header[at] = if header[at] == b'0' { b'1' } else { b'0' };
    let longer = [&whole[..], b"\0"].concat();
    for damaged in [
        &flipped,
        &header,
        &longer,
        &whole[..whole.len() - 1].to_vec(),
        &whole[..20].to_vec(),
        &vec![],
    ] {
        sandbox.file(part, damaged);
        let ended = sandbox.run(&["merge", "p", "-o", "merged"]);
        assert_eq!(ended.code, 2);
        assert!(ended.stderr.contains("`p/0001-000020.part` is damaged: "), "{}", ended.stderr);
        assert_eq!(sandbox.run(&["merge", "p", "-o", "merged", "--allow-missing"]).code, 2);
        assert!(!sandbox.path("merged").exists());
        let ended = run(&sandbox, ["--parts", "p", "-o", "out"]);
        ok(&ended);
        assert!(ended.stderr.contains("`p/0001-000020.part` is damaged: "), "{}", ended.stderr);
        assert!(
            ended.stderr.contains("16 of 16 bands, 15 of them there already"),
            "{}",
            ended.stderr
        );
        assert_eq!(sandbox.read(part), whole);
        same(&sandbox, "out");
    }
    // So is the part that tells of the end.
    let end = sandbox.read("p/end.part");
    sandbox.file("p/end.part", &end[..end.len() - 1]);
    assert_eq!(sandbox.run(&["merge", "p", "-o", "merged"]).code, 2);
    ok(&run(&sandbox, ["--parts", "p", "-o", "out"]));
    assert_eq!(sandbox.read("p/end.part"), end);
}

/// What belongs to something else is neither used nor replaced.
#[test]
fn foreign_parts_are_refused() {
    let sandbox = sandbox();
    sandbox.file("other.gml", scene().replace("0.7 0.6 9.0", "0.7 0.6 8.0"));
    sandbox.file("inc.gml", "#include \"i.ins\"\n".to_owned() + &scene()).file("i.ins", "1 /one\n");
    ok(&run(&sandbox, ["--parts", "p", "--shard", "1/2"]));
    let before: Vec<_> = bands(&sandbox).iter().map(|name| sandbox.read(name)).collect();
    let settings = "of this scene, but with other settings";
    for (args, why) in [
        (&["other.gml"][..], "of another scene"),
        (&["inc.gml"], "of another scene"),
        (&["s.gml", "-D", "unused=1"], "of another scene"),
        (&["s.gml", "--size", "40x62"], settings),
        (&["s.gml", "--depth", "4"], settings),
        (&["s.gml", "--region", "0,0,40,62"], settings),
        (&["s.gml", "--dialect", "chicago"], settings),
        (&["s.gml", "--precision", "dd"], settings),
    ] {
        let ended = sandbox.run(&[args, &["--parts", "p", "-o", "none"]].concat());
        assert_eq!(ended.code, 2, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(why), "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains("give `--parts` another directory"), "{}", ended.stderr);
        assert!(!sandbox.path("none").exists());
        // Nor are they joined.
        let _ = fs::remove_dir_all(sandbox.path("q"));
        ok(&sandbox.run(&[args, &["--parts", "q", "--shard", "2/2"]].concat()));
        let ended = sandbox.run(&["merge", "p", "q", "-o", "none", "--allow-missing"]);
        assert_eq!(ended.code, 2, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains("parts do not belong together"), "{}", ended.stderr);
        assert!(ended.stderr.contains(why), "{args:?}: {}", ended.stderr);
        assert!(!sandbox.path("none").exists());
    }
    // A change of what is included is one of the scene.
    ok(&sandbox.run(&["inc.gml", "--parts", "r", "--shard", "1/2"]));
    sandbox.file("i.ins", "1  /one\n");
    let ended = sandbox.run(&["inc.gml", "--parts", "r"]);
    assert!(ended.code == 2 && ended.stderr.contains("of another scene"), "{}", ended.stderr);
    let after: Vec<_> = bands(&sandbox).iter().map(|name| sandbox.read(name)).collect();
    assert_eq!(before, after);
}

#[test]
fn other_files_are_not_parts() {
    let sandbox = sandbox();
    ok(&run(&sandbox, ["--parts", "p", "--shard", "1/2"]));
    let missing = "p/0001-000000.part";
    assert!(!sandbox.path(missing).exists());
    let other = sandbox.read("p/0001-000004.part");
    let newer = String::from_utf8_lossy(&other).replacen("gmlvm-part 1\n", "gmlvm-part 2\n", 1);
    for (contents, why) in [
        (&b"precious"[..], "is no part file"),
        (newer.as_bytes(), "of a format that this version of gmlvm does not know"),
        (&other, "holds another part than its name says"),
    ] {
        sandbox.file(missing, contents);
        let ended = run(&sandbox, ["--parts", "p", "-o", "none"]);
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        assert!(ended.stderr.contains(why), "{}", ended.stderr);
        assert_eq!(sandbox.read(missing), contents);
        assert_ne!(sandbox.run(&["merge", "p", "-o", "none"]).code, 0);
    }
    fs::remove_file(sandbox.path(missing)).expect("there");
    fs::create_dir(sandbox.path(missing)).expect("a directory");
    assert_eq!(run(&sandbox, ["--parts", "p", "-o", "none"]).code, 2);
    assert_eq!(run(&sandbox, ["--parts", "s.gml", "-o", "none"]).code, 2);
    assert_eq!(sandbox.run(&["merge", "single"]).code, 2);
    assert_eq!(sandbox.run(&["merge", "nothing"]).code, 2);
    assert_eq!(sandbox.run(&["merge", "s.gml"]).code, 2);
    assert!(!sandbox.path("none").exists());
    for options in [
        &["--shard", "1/2"][..],
        &["--parts", "q", "--shard", "3/2"],
        &["--parts", "q", "--certify"],
        &["--parts", "q", "--precision", "certified"],
    ] {
        assert_eq!(run(&sandbox, options).code, 2, "{options:?}");
    }
    assert!(!sandbox.path("q").exists());
}

/// What is missing is said, and is black if that is wanted.
#[test]
fn missing_rows_are_named() {
    let sandbox = sandbox();
    ok(&run(&sandbox, ["--parts", "p", "-o", "out"]));
    for name in ["p/0001-000008.part", "p/0001-000012.part", "p/0001-000060.part"] {
        fs::remove_file(sandbox.path(name)).expect("there");
    }
    let ended = sandbox.run(&["merge", "p", "-o", "merged"]);
    assert_eq!(ended.code, 2);
    let message = "of image 1, `a.ppm`, rows 8 to 15, and more are missing";
    assert!(ended.stderr.contains(message), "{}", ended.stderr);
    assert!(!sandbox.path("merged").exists());
    let ended = sandbox.run(&["merge", "p", "-o", "merged", "--allow-missing"]);
    ok(&ended);
    assert!(ended.stderr.contains("a.ppm  40x62  10 rows missing"), "{}", ended.stderr);
    let (made, single) = (sandbox.read("merged/a.ppm"), sandbox.read("single/a.ppm"));
    let row = |n: usize| single.len() - (62 - n) * 40 * 3;
    assert_eq!(made[..row(8)], single[..row(8)]);
    assert!(made[row(8)..row(16)].iter().all(|byte| *byte == 0));
    assert_eq!(made[row(16)..row(60)], single[row(16)..row(60)]);
    // Whole images of which nothing is there are missed too.
    fs::remove_file(sandbox.path("p/0003-000000.part")).expect("there");
    let ended = sandbox.run(&["merge", "p", "-o", "none"]);
    assert!(ended.stderr.contains("there is no part of image 3 of 3"), "{}", ended.stderr);
    fs::remove_file(sandbox.path("p/end.part")).expect("there");
    let ended = sandbox.run(&["merge", "p", "-o", "none"]);
    assert!(ended.stderr.contains("no run has come to its end"), "{}", ended.stderr);
    assert_eq!((ended.code, sandbox.path("none").exists()), (2, false));
}

/// An interrupted run goes on where it was: killed or ended at any time, it leaves whole parts, and in
/// the end the image is that of a single run.
#[test]
fn interrupted_runs_go_on() {
    let sandbox = sandbox();
    let size = ["--size", "160x250"];
    ok(&run(&sandbox, [&size[..], &["-o", "single"]].concat()));
    for try_number in 0..12 {
        let args = [&["run", "s.gml", "--parts", "p", "-o", "out", "-q"], &size[..]].concat();
        let mut child = sandbox.command(&args).stderr(Stdio::null()).spawn().expect("runs");
        thread::sleep(Duration::from_millis(30 * (1 + try_number % 4)));
        if try_number % 2 == 0 {
            child.kill().expect("it can be killed");
        } else {
            let sent = Command::new("kill").arg(child.id().to_string()).status();
            sent.expect("kill runs");
        }
        child.wait().expect("ends");
    }
    assert!(bands(&sandbox).len() > 10);
    let ended = run(&sandbox, [&size[..], &["--parts", "p", "-o", "out"]].concat());
    ok(&ended);
    assert!(!ended.stderr.contains("damaged"), "{}", ended.stderr);
    same(&sandbox, "out");
}

/// A part that cannot be written ends the run; those before it are there.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_what_is_done() {
    let sandbox = sandbox();
    let script = format!(
        "mkdir p && mount -t tmpfs -o size=96k none p || exit 99
         {} run s.gml --size 160x250 --parts p -o out; code=$?; ls p | wc -l; ls -A p | grep -c tmp; exit $code",
        env!("CARGO_BIN_EXE_gmlvm")
    );
    let Some(output) = sandbox.mounting(&script) else { return };
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("could not write `p/0001-"), "{stderr}");
    assert!(stderr.contains("no space left on device"), "{stderr}");
    let shown = String::from_utf8_lossy(&output.stdout);
    let [n_parts, n_temporary] = [0, 1].map(|line| shown.lines().nth(line).expect("a number"));
    assert!(n_parts.parse::<u32>().expect("a number") > 4 && n_temporary == "0", "{shown}");
    assert!(!sandbox.path("out").exists());
}

/// A part's name for its image is that of a scene: it leads nowhere else in merging either.
#[test]
fn names_in_parts_are_not_trusted() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("../x.ppm"));
    assert_eq!(sandbox.run(&["s.gml", "--parts", "p", "--shard", "1/1"]).code, 5);
    // With a name of the user's own the scene's is not looked at.
    ok(&sandbox.run(&["s.gml", "--parts", "p", "--shard", "1/1", "--output", "fine.ppm"]));
    let ended = sandbox.run(&["merge", "p", "-o", "d"]);
    assert_eq!(ended.code, 5, "{}", ended.stderr);
    assert!(ended.stderr.contains("E0501") && ended.stderr.contains("leaves the output directory"));
    assert!(!Path::new(&sandbox.path("x.ppm")).exists() && !sandbox.path("d").exists());
    ok(&sandbox.run(&["merge", "p", "--output", "fine.ppm"]));
}

/// The environment of a job says which shard it is.
#[test]
fn jobs_tell_of_shards() {
    let sandbox = sandbox();
    for number in 1..=3 {
        let mut command = sandbox.command(&["s.gml", "--parts", "p", "--shard", "auto"]);
        command.env("SLURM_ARRAY_TASK_ID", (number + 4).to_string());
        command.envs([("SLURM_ARRAY_TASK_MIN", "5"), ("SLURM_ARRAY_TASK_COUNT", "3")]);
        let output = command.output().expect("runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains(&format!("shard {number}/3")), "{stderr}");
    }
    ok(&sandbox.run(&["merge", "p", "-o", "merged"]));
    same(&sandbox, "merged");
    let ended = run(&sandbox, ["--parts", "q", "--shard", "auto"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("the environment tells of no job"), "{}", ended.stderr);
}
