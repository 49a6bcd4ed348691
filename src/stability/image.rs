//! Images as oracles see them.

pub(super) type Rgb = [u8; 3];

pub(super) const BLACK: Rgb = [0; 3];

/// An image, and what else is known of it.
pub(super) struct Image {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Row by row from the upper left; none where a surface function failed.
    pub(super) pixels: Vec<Option<Rgb>>,
    /// Rays toward lights that met something.
    pub(super) n_blocked: u64,
}

/// A pixel, measured from the middle of its image in halves of pixels: exactly its ray's direction
/// but for a factor.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// To the right.
    pub(super) across: i64,
    pub(super) up: i64,
}

impl Place {
    /// Square of the distance from the middle.
    pub(super) fn off(self) -> i64 {
        self.across * self.across + self.up * self.up
    }
}

impl Image {
    /// The pixel at a place of the image.
    pub(super) fn at(&self, place: Place) -> Option<Rgb> {
        let (width, height) = (i64::from(self.width), i64::from(self.height));
        let column = (place.across + width - 1) / 2;
        let row = (height - 1 - place.up) / 2;
        self.pixels[(row * width + column) as usize]
    }

    /// All places, in reading order.
    pub(super) fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let (width, height) = (i64::from(self.width), i64::from(self.height));
        (0..height).flat_map(move |row| {
            let up = height - 1 - 2 * row;
            (0..width).map(move |column| Place { across: 2 * column + 1 - width, up })
        })
    }

    /// Whether there is something to see.
    pub(super) fn shows(&self) -> bool {
        self.pixels.iter().flatten().any(|&pixel| pixel != BLACK)
    }

    pub(super) fn n_pixels(&self) -> u64 {
        self.pixels.len() as u64
    }
}
