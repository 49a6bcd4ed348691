//! Each oracle takes what is right and counts what is not.

use super::*;

const WHITE: Rgb = [255; 3];

/// A row of pixels; a dot is black, a question mark no pixel, anything else white.
fn row(text: &str) -> Image {
    let pixel = |c: char| match c {
        '?' => None,
        '.' => Some(BLACK),
        _ => Some(WHITE),
    };
    let pixels: Vec<_> = text.chars().map(pixel).collect();
    Image { width: pixels.len() as u32, height: 1, pixels, n_blocked: 0 }
}

/// A square of pixels.
fn square(text: &str) -> Image {
    Image { width: 2, height: 2, ..row(text) }
}

#[test]
fn pixels_and_outlines_are_counted() {
    let right = |_: usize, at: Place| if at.across > 0 { WHITE } else { BLACK };
    assert_eq!(Oracle::Pixels(right).error(&[row("..##"), row("..##")]), 0);
    assert_eq!(Oracle::Pixels(right).error(&[row("..##"), row(".##?")]), 2);
    let first = |index: usize, _: Place| index == 0;
    assert_eq!(Oracle::Outline(first).error(&[row("###"), row("...")]), 0);
    assert_eq!(Oracle::Outline(first).error(&[row("##."), row("#.?")]), 3);
}

#[test]
fn equal_images_show_something() {
    assert_eq!(Oracle::Same.error(&[row("#."), row("#."), row("#.")]), 0);
    assert_eq!(Oracle::Same.error(&[row("#."), row("#."), row(".#")]), 2);
    assert_eq!(Oracle::Same.error(&[row("?#"), row("?#")]), 2);
    assert!(Oracle::Same.error(&[row(".."), row("..")]) > 0);
    let pairs = [row("#."), row("#."), row(".#"), row(".#")];
    assert_eq!(Oracle::Pairs.error(&pairs), 0);
    assert_eq!(Oracle::Pairs.error(&[row("#."), row("##"), row(".#"), row(".#")]), 1);
}

#[test]
fn symmetries_hold_pixel_by_pixel() {
    assert_eq!(Oracle::Symmetric.error(&[row("#..#")]), 0);
    assert_eq!(Oracle::Symmetric.error(&[row("#.##")]), 2);
    assert!(Oracle::Symmetric.error(&[row("....")]) > 0);
    // In reading order: upper left, upper right, lower left, lower right.
    let turned = ["#...", "..#.", "...#", ".#.."].map(square);
    assert_eq!(Oracle::Turned.error(&turned), 0);
    let other_way = ["#...", ".#.."].map(square);
    assert_eq!(Oracle::Turned.error(&other_way), 2);
}

#[test]
fn blocked_rays_count() {
    let shadowed = Image { n_blocked: 3, ..row("##") };
    assert_eq!(Oracle::Unshadowed.error(&[row("##")]), 0);
    assert_eq!(Oracle::Unshadowed.error(&[row("##"), shadowed]), 3);
    assert_eq!(Oracle::Unshadowed.error(&[row("#?")]), 1);
    assert!(Oracle::Unshadowed.error(&[row("..")]) > 0);
}
