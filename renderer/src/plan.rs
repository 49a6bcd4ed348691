//! What of the model a scene does without.
//!
//! Most scenes use little of what the tracer can do. Before an image is traced, the parts that it has
//! no use for are found and left out, where no pixel changes by a bit; why, stands beside the code.
//! Each omission can be undone alone, to check that and to see what it saves.

use crate::light::Light;
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::scene::{Component, Scene};
use crate::shade::Illumination;

/// A part of the model that a scene may do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Texture coordinates that no surface function reads.
    Coordinates,
    /// Bringing the eye into each shape's space anew for each ray.
    Eye,
    /// Off-diagonal entries of matrices that are 0.
    Turns,
    /// Two rows of three of a plane's matrix, where the third tells that a ray misses it.
    Planes,
    /// Lists of crossings of intersections of shapes, and of what is taken away from them.
    Lists,
    /// The search for what is in the way of light that adds nothing to a surface.
    Shadows,
    /// The search for what is in the way, where the last that was in the way still is.
    Blockers,
    /// How light fades with distance, where it does not.
    Fading,
    /// In the search for what is in the way, planes that the light comes from in front of.
    Obstacles,
    /// The rest of a path that cannot change the pixel.
    Rest,
    /// Calls of surface functions at one point after the other, where one at many points is quicker.
    Calls,
}

impl Part {
    /// All parts.
    pub const ALL: [Part; 11] = [
        Part::Coordinates,
        Part::Eye,
        Part::Turns,
        Part::Planes,
        Part::Lists,
        Part::Shadows,
        Part::Blockers,
        Part::Fading,
        Part::Obstacles,
        Part::Rest,
        Part::Calls,
    ];
}

/// The parts that may be left out where a scene does without them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Omissions(u16);

impl Omissions {
    /// None may: everything is computed.
    pub const NONE: Omissions = Omissions(0);
    /// All may.
    pub const ALL: Omissions = Omissions((1 << Part::ALL.len()) - 1);

    /// The same, but this part may not.
    #[must_use]
    pub fn without(self, part: Part) -> Self {
        Omissions(self.0 & !(1 << part as u8))
    }

    /// The same, but this part may as well.
    #[must_use]
    pub fn with(self, part: Part) -> Self {
        Omissions(self.0 | 1 << part as u8)
    }

    /// Whether a part may be left out.
    #[inline(always)]
    #[must_use]
    pub fn holds(self, part: Part) -> bool {
        self.0 >> part as u8 & 1 == 1
    }
}

/// What a scene uses of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Use {
    /// Shapes.
    pub shapes: usize,
    /// Shapes that are part of no set operation but union, met without lists of crossings.
    pub single: usize,
    /// Shapes that are moved and scaled along the axes, but not turned.
    pub unturned: usize,
    /// Trees of set operations that are intersections of shapes, or such of which others are taken away.
    pub carvings: usize,
    /// Planes.
    pub planes: usize,
    /// Lights.
    pub lights: usize,
    /// Of these, those that are infinitely far away.
    pub directional: usize,
    /// Of these, spotlights.
    pub spots: usize,
    /// Of these, those that fade with distance.
    pub fading: usize,
}

impl Use {
    /// Of a scene and its lights.
    #[must_use]
    pub fn of<R: Real>(scene: &Scene<R>, illumination: &Illumination) -> Self {
        let mut used = Use { shapes: scene.leaves.len(), ..Use::default() };
        for component in &scene.components {
            match component {
                Component::Leaf(_) => used.single += 1,
                Component::Tree { tree, .. } => {
                    used.carvings += usize::from(!scene.trees[*tree as usize].whole.is_empty());
                }
            }
        }
        for leaf in &scene.leaves {
            used.unturned += usize::from(leaf.is_unturned);
            used.planes += usize::from(leaf.kind == ShapeKind::Plane);
        }
        let fades = !illumination.attenuation.is_constant();
        for light in &illumination.lights {
            used.lights += 1;
            match light {
                Light::Directional { .. } => used.directional += 1,
                Light::Point { .. } => used.fading += usize::from(fades),
                Light::Spot { .. } => {
                    used.spots += 1;
                    used.fading += usize::from(fades);
                }
            }
        }
        used
    }
}
