//! `run --preview`: images drawn in the terminal, two pixels to a character.
//!
//! The upper half of a character cell is a block in the one pixel's colour, the lower half the ground in
//! the other's. What is drawn goes to the standard error, as everything that is for the eye.

use std::fmt::Write;

use rustix::termios::tcgetwinsize;

use crate::console;
use crate::formats::Picture;
use crate::preview::scale::scaled;
use crate::report::Reporter;

mod scale;

/// Where the terminal does not tell its width.
const USUAL_COLUMNS: u32 = 80;

/// A place to draw in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Preview {
    colors: Colors,
    /// Width, in characters.
    columns: u32,
    /// Height in characters, if there is such a limit.
    rows: Option<u32>,
}

/// What colours a terminal knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Colors {
    /// A byte per channel.
    All,
    /// A cube of 6 x 6 x 6 and a ramp of greys, which nearly all terminals have alike.
    Few,
}

/// A colour as bytes.
type Rgb = [u8; 3];

impl Preview {
    /// The terminal; where nothing may be coloured there is no picture, which the user is told.
    pub(crate) fn new(reporter: &Reporter) -> Option<Self> {
        if !reporter.color {
            reporter.note(
                "no preview: the standard error is no terminal, or colours are off; `--color always` \
                 draws all the same",
            );
            return None;
        }
        let is_one_of = |name: &str, words: &[&str]| {
            std::env::var(name).is_ok_and(|text| words.iter().any(|word| text.contains(word)))
        };
        let knows_all = is_one_of("COLORTERM", &["truecolor", "24bit"])
            || is_one_of("TERM", &["direct", "truecolor", "kitty", "alacritty", "ghostty", "foot"]);
        let size = tcgetwinsize(std::io::stderr()).ok().filter(|size| size.ws_col > 0);
        let asked = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
        let asked = asked.filter(|columns| (1..=u32::from(u16::MAX)).contains(columns));
        Some(Preview {
            colors: if knows_all { Colors::All } else { Colors::Few },
            columns: asked.or(size.map(|size| size.ws_col.into())).unwrap_or(USUAL_COLUMNS),
            // The line below the picture is the shell's.
            rows: size.map(|size| u32::from(size.ws_row).saturating_sub(1).max(1)),
        })
    }

    /// Draws an image, made smaller until it fits.
    pub(crate) fn draw(self, picture: &Picture) {
        let (width, height) = self.size(picture);
        let pixels = scaled(picture, width, height);
        console::say(&text(&pixels, width as usize, self.colors));
    }

    /// The size of an image in the terminal, in pixels: at most its own.
    fn size(self, picture: &Picture) -> (u32, u32) {
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        let mut shrink = (width / f64::from(self.columns)).max(1.0);
        if let Some(rows) = self.rows {
            shrink = shrink.max(height / f64::from(2 * rows));
        }
        let shrunk = |length: f64| ((length / shrink).round() as u32).max(1);
        (shrunk(width), shrunk(height))
    }
}

/// Characters with colours for rows of pixels; a colour is named when it changes.
fn text(pixels: &[Rgb], width: usize, colors: Colors) -> String {
    let mut text = String::new();
    let rows: Vec<&[Rgb]> = pixels.chunks(width).collect();
    for pair in rows.chunks(2) {
        let mut now = (None, None);
        for (x, &upper) in pair[0].iter().enumerate() {
            let lower = pair.get(1).map(|row| row[x]);
            if now.0 != Some(upper) {
                text += &code(38, upper, colors);
            }
            if let Some(lower) = lower.filter(|_| now.1 != lower) {
                text += &code(48, lower, colors);
            }
            now = (Some(upper), lower);
            text.push('▀');
        }
        text += "\u{1b}[0m\n";
    }
    text
}

/// The command that makes `what`, 38 for blocks and 48 for the ground, of this colour.
fn code(what: u8, [r, g, b]: Rgb, colors: Colors) -> String {
    let mut code = format!("\u{1b}[{what};");
    let _ = match colors {
        Colors::All => write!(code, "2;{r};{g};{b}m"),
        Colors::Few => write!(code, "5;{}m", nearest([r, g, b])),
    };
    code
}

/// The number of the nearest of the 240 colours that terminals with 256 have alike.
fn nearest(color: Rgb) -> u8 {
    let distance = |number: &u8| -> u32 {
        let channels = fixed(*number).into_iter().zip(color);
        channels.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    };
    (16..=255).min_by_key(distance).unwrap_or(16)
}

/// The colour of a number from 16.
fn fixed(number: u8) -> Rgb {
    const LEVELS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let level = |digit: u8| LEVELS[usize::from(digit % 6)];
    match number - 16 {
        n @ 0..216 => [level(n / 36), level(n / 6), level(n)],
        n => [8 + 10 * (n - 216); 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Pixels;

    #[test]
    fn the_fixed_colours_are_found_and_named_when_they_change() {
        for number in 16..=255 {
            assert_eq!(fixed(nearest(fixed(number))), fixed(number), "{number}");
        }
        assert_eq!(
            (nearest([255, 0, 0]), nearest([9, 8, 9]), nearest([250, 130, 4])),
            (196, 232, 208)
        );
        let (red, blue) = ([255, 0, 0], [0, 0, 255]);
        let odd = text(&[red, red, red, blue, blue, red], 2, Colors::All);
        let lines: Vec<_> = odd.lines().collect();
        assert_eq!(
            lines,
            [
                "\u{1b}[38;2;255;0;0m\u{1b}[48;2;255;0;0m▀\u{1b}[48;2;0;0;255m▀\u{1b}[0m",
                "\u{1b}[38;2;0;0;255m▀\u{1b}[38;2;255;0;0m▀\u{1b}[0m"
            ]
        );
        assert_eq!(text(&[red], 1, Colors::Few), "\u{1b}[38;5;196m▀\u{1b}[0m\n");
    }

    #[test]
    fn images_fit_and_keep_their_shape() {
        let size = |columns, rows, width, height| {
            let picture = Picture { width, height, pixels: Pixels::Bytes(Vec::new()) };
            Preview { colors: Colors::All, columns, rows }.size(&picture)
        };
        assert_eq!(size(80, None, 320, 240), (80, 60));
        assert_eq!(size(80, Some(20), 320, 240), (53, 40));
        assert_eq!(size(80, Some(20), 8, 6), (8, 6));
        assert_eq!(size(80, None, 10_000, 1), (80, 1));
        assert_eq!(size(1, Some(1), 3, 10_000), (1, 2));
    }
}
