//! `run --preview`: what is drawn in a terminal, and where nothing is.

use std::fs::{File, OpenOptions};
use std::io::Read;
use std::os::fd::AsFd;
use std::process::Stdio;
use std::thread;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

use crate::gmlvm::{PPM_HEADER, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// A terminal of 40 columns and 20 lines: our end of it, and the program's.
fn terminal() -> (File, File) {
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&ours).and_then(|()| unlockpt(&ours)).expect("it may be opened");
    let name = ptsname(&ours, Vec::new()).expect("it has a name").into_string().expect("text");
    let theirs = OpenOptions::new().read(true).write(true).open(name).expect("it opens");
    let size = Winsize { ws_row: 20, ws_col: 40, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(theirs.as_fd(), size).expect("it takes a size");
    (File::from(ours), theirs)
}

/// Runs with these variables and the standard error, and output if wanted, in a terminal. Returns the exit
/// code and what the terminal has got.
fn in_terminal(
    sandbox: &Sandbox,
    args: &[&str],
    variables: &[(&str, &str)],
    with_output: bool,
) -> (Option<i32>, String) {
    let (mut ours, theirs) = terminal();
    let mut command = sandbox.command(args);
    command.env_remove("COLORTERM").env_remove("COLUMNS").env("TERM", "xterm");
    command.envs(variables.iter().copied()).stdout(Stdio::null());
    if with_output {
        command.stdout(theirs.try_clone().expect("a copy"));
    }
    let mut child = command.stderr(theirs).spawn().expect("it runs");
    // It keeps copies of the other end.
    drop(command);
    let reading = thread::spawn(move || {
        let mut text = Vec::new();
        // The end of a terminal is an error on Linux.
        let _ = ours.read_to_end(&mut text);
        String::from_utf8(text).expect("text")
    });
    let code = child.wait().expect("it ends").code();
    (code, reading.join().expect("no panic"))
}

/// A scene with an image of this size, striped finely.
fn stripes(size: &str) -> String {
    ball("a.ppm").replace("8 6", size).replace(
        "/v /u /face 1.0 1.0 1.0 point",
        "/v /u /face u 40.0 mulf frac v 9.0 mulf frac u point",
    )
}

/// The colours that text of all colours draws, upper and lower half, row by row.
fn drawn(text: &str) -> Vec<Vec<[Option<[u8; 3]>; 2]>> {
    let lines = text.lines().filter(|line| line.contains('▀'));
    let cells = |line: &str| {
        let (mut now, mut cells) = ([None; 2], Vec::new());
        let mut rest = line;
        while let Some(at) = rest.find(['\u{1b}', '▀']) {
            if let Some(tail) = rest[at..].strip_prefix('▀') {
                cells.push(now);
                rest = tail;
                continue;
            }
            let (code, tail) = rest[at + 2..].split_once(['m', 'K']).expect("a whole command");
            let words: Vec<u8> = code.split(';').filter_map(|word| word.parse().ok()).collect();
            match words[..] {
                [38, 2, r, g, b] => now[0] = Some([r, g, b]),
                [48, 2, r, g, b] => now[1] = Some([r, g, b]),
                _ => now = [None; 2],
            }
            rest = tail;
        }
        cells
    };
    lines.map(cells).collect()
}

/// The pixels of a PPM file of ours.
fn pixels(file: &[u8], width: usize) -> Vec<Vec<[u8; 3]>> {
    let header =
        file.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(3).expect("four lines").0;
    let pixels = file[header + 1..].as_chunks::<3>().0;
    pixels.chunks(width).map(<[_]>::to_vec).collect()
}

#[test]
fn small_images_are_drawn_as_they_are() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", stripes("9 7"));
    let variables = [("COLORTERM", "truecolor")];
    let (code, text) = in_terminal(&sandbox, &["s.gml", "--preview"], &variables, true);
    assert_eq!(code, Some(0), "{text}");
    let image = pixels(&sandbox.read("a.ppm"), 9);
    let drawn = drawn(&text);
    assert_eq!(drawn.len(), 4, "{text}");
    for (y, row) in image.iter().enumerate() {
        let halves: Vec<_> = drawn[y / 2].iter().map(|cell| cell[y % 2]).collect();
        assert_eq!(halves, row.iter().copied().map(Some).collect::<Vec<_>>(), "row {y}");
    }
    assert!(drawn[3].iter().all(|cell| cell[1].is_none()), "there is no eighth row: {text}");
}

/// An image of 400 x 300 is drawn with 40 x 30 pixels, each as bright as the hundred that it stands for.
#[test]
fn large_images_fit_and_keep_their_light() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", stripes("400 300"));
    let variables = [("COLORTERM", "24bit")];
    let (code, text) = in_terminal(&sandbox, &["s.gml", "--preview", "-q"], &variables, false);
    assert_eq!(code, Some(0), "{text}");
    let image = pixels(&sandbox.read("a.ppm"), 400);
    let drawn = drawn(&text);
    assert_eq!((drawn.len(), drawn[0].len()), (15, 40));
    // The light of a byte on a screen of sRGB.
    let light = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    let mut n_mixed = 0;
    for (y, x, channel) in
        (0..30).flat_map(|y| (0..40).flat_map(move |x| (0..3).map(move |c| (y, x, c))))
    {
        let covered = || (0..100).map(|k| image[10 * y + k / 10][10 * x + k % 10][channel]);
        let mean = covered().map(light).sum::<f64>() / 100.0;
        n_mixed += u32::from(covered().max() > covered().min());
        let byte = drawn[y / 2][x][y % 2].expect("a colour")[channel];
        // No byte is nearer on the curve, between whose steps the mean lies.
        let (below, above) = (byte.saturating_sub(1), byte.saturating_add(1));
        assert!((light(below)..=light(above)).contains(&mean), "({x}, {y}): {byte} for {mean}");
    }
    assert!(n_mixed > 500, "{n_mixed}: nothing is averaged");
}

#[test]
fn colours_are_those_that_there_are() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let run = |args: &[&str], variables: &[(&str, &str)]| {
        let args = [&["s.gml", "--preview"], args].concat();
        let (code, text) = in_terminal(&sandbox, &args, variables, false);
        assert_eq!(code, Some(0), "{text}");
        assert!(sandbox.read("a.ppm").starts_with(PPM_HEADER));
        text
    };
    let few = run(&[], &[]);
    assert!(few.contains("\u{1b}[38;5;") && !few.contains(";2;"), "{few:?}");
    for (args, variables) in [
        (&[][..], &[("NO_COLOR", "1"), ("COLORTERM", "truecolor")][..]),
        (&[], &[("TERM", "dumb")]),
        (&["--color", "never"], &[]),
    ] {
        let text = run(args, variables);
        assert!(!text.contains('▀') && text.contains("no preview"), "{text:?}");
    }
    // No terminal: nothing, but for those who insist, of the width that they say.
    let ended = sandbox.run(&["s.gml", "--preview"]);
    assert!(!ended.stderr.contains('▀') && ended.stderr.contains("no preview"), "{}", ended.stderr);
    let mut command =
        sandbox.command(&["s.gml", "--preview", "--color", "always", "--output", "-"]);
    let output = command.env("COLORTERM", "truecolor").env("COLUMNS", "4").output().expect("runs");
    assert!(output.stdout.starts_with(PPM_HEADER));
    let text = String::from_utf8(output.stderr).expect("text");
    assert_eq!(drawn(&text).iter().map(Vec::len).collect::<Vec<_>>(), [4, 4], "{text}");
}

#[test]
fn image_bytes_do_not_go_to_a_terminal() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    for args in [&["s.gml", "--output", "-"][..], &["s.gml", "--output", "-", "--preview"]] {
        let (code, text) = in_terminal(&sandbox, args, &[], true);
        assert_eq!(code, Some(2), "{text}");
        assert!(
            text.contains("will not write image bytes to a terminal") && text.contains("--preview"),
            "{text}"
        );
        assert!(!text.contains("P6"), "{text}");
    }
}
