//! What is known of the images of a case, and how far images are from it.

use super::image::{BLACK, Image, Place, Rgb};

/// What is known of the images that a scene makes, in order.
#[derive(Clone, Copy)]
pub(super) enum Oracle {
    /// Every pixel, by the image's index and the pixel's place.
    Pixels(fn(usize, Place) -> Rgb),
    /// Which pixels are not black.
    Outline(fn(usize, Place) -> bool),
    /// All images are the first, which shows something.
    Same,
    /// Two images each are the same, and show something.
    Pairs,
    /// Each image is its own mirror image, left to right.
    Symmetric,
    /// Each image is the one before turned by 90 degrees, to the left.
    Turned,
    /// Each image is lit, and no ray toward a light is blocked.
    Unshadowed,
}

impl Oracle {
    /// The number of wrong pixels; for `Unshadowed`, of blocked rays as well.
    pub(super) fn error(self, images: &[Image]) -> u64 {
        let numbered = || images.iter().enumerate();
        match self {
            Oracle::Pixels(expected) => numbered()
                .map(|(index, image)| wrong(image, |place, pixel| pixel == expected(index, place)))
                .sum(),
            Oracle::Outline(is_inside) => numbered()
                .map(|(index, image)| {
                    wrong(image, |place, pixel| (pixel != BLACK) == is_inside(index, place))
                })
                .sum(),
            Oracle::Same => images.iter().map(|image| differences(&images[0], image)).sum(),
            Oracle::Pairs => {
                images.chunks(2).map(|pair| differences(&pair[0], &pair[pair.len() - 1])).sum()
            }
            Oracle::Symmetric => images
                .iter()
                .map(|image| {
                    let mirrored = |place: Place| Place { across: -place.across, ..place };
                    blank(image)
                        + wrong(image, |place, pixel| image.at(mirrored(place)) == Some(pixel))
                })
                .sum(),
            Oracle::Turned => images
                .windows(2)
                .map(|pair| {
                    let before = |place: Place| Place { across: place.up, up: -place.across };
                    blank(&pair[0])
                        + wrong(&pair[1], |place, pixel| pair[0].at(before(place)) == Some(pixel))
                })
                .sum(),
            Oracle::Unshadowed => images
                .iter()
                .map(|image| blank(image) + wrong(image, |_, _| true) + image.n_blocked)
                .sum(),
        }
    }
}

/// The number of pixels that are not right, as those are that do not exist.
fn wrong(image: &Image, is_right: impl Fn(Place, Rgb) -> bool) -> u64 {
    let is_wrong = |place: &Place| image.at(*place).is_none_or(|pixel| !is_right(*place, pixel));
    image.places().filter(is_wrong).count() as u64
}

/// The number of pixels in which `image` is not `expected`, which should show something.
fn differences(expected: &Image, image: &Image) -> u64 {
    blank(expected) + wrong(image, |place, pixel| expected.at(place) == Some(pixel))
}

/// All pixels of an image that shows nothing where something is to be seen.
fn blank(image: &Image) -> u64 {
    if image.shows() { 0 } else { image.n_pixels() }
}

#[cfg(test)]
mod tests;
