//! What is traced: the description flattened into shapes with their placements, and the trees of
//! set operations above them.
//!
//! A scene is a union of components. Most are single shapes; the others are trees whose root is an
//! intersection or a difference. Shapes are numbered in the order of the program's operands, which
//! decides who paints coincident surfaces. A hierarchy over the components, and one over the leaves of
//! each tree, tell which of them a ray may meet.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use rayon::prelude::*;

use crate::bounds::{self, Bounds};
use crate::camera;
use crate::carving;
use crate::hierarchy::Hierarchy;
use crate::intern::Faces;
use crate::numeric::affine::Affine;
use crate::numeric::ball::Ball;
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::{NodeKind, Object, SetOp, ShapeKind};
use crate::placement::{Placement, Turns};
use crate::plan::{Omissions, Part};
use crate::ray::{Conditioning, Ray};
use crate::shape;
use crate::surface::SurfaceId;

/// The scene to trace, in the numbers `R`.
#[derive(Debug)]
pub struct Scene<R = f64> {
    pub(crate) leaves: Vec<Leaf<R>>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) components: Vec<Component>,
    /// Over the components, by index.
    pub(crate) hierarchy: Hierarchy,
    pub(crate) trees: Vec<Tree>,
    /// Of all leaves.
    pub(crate) conditioning: Conditioning,
    /// The size of the largest coordinate of bounded components.
    pub(crate) extent: f64,
    /// The world-space surface of each face, faces of one leaf in a row. Equal surfaces have equal
    /// numbers, and those that several faces share have the lowest.
    pub(crate) face_surfaces: Vec<u32>,
    pub(crate) n_shared: u32,
    /// What may be left out.
    pub(crate) omissions: Omissions,
}

/// A shape where it stands. In doubles, what tells whether a ray meets it lies in two cache lines.
#[derive(Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf<R> {
    pub(crate) object_from_world: Affine<R>,
    /// The eye in object space.
    pub(crate) eye: Vec3<R>,
    pub(crate) kind: ShapeKind,
    /// Whether `object_from_world` is treated as a diagonal matrix.
    pub(crate) is_unturned: bool,
    /// Faces, by bit, whose surfaces the eye lies on, as far as double-double can tell.
    pub(crate) at_eye: u8,
    /// Index of its first face in the scene's list.
    pub(crate) first_face: u32,
    pub(crate) world_from_object: Affine<R>,
    /// Sizes of the entries of `object_from_world`: of the matrix (largest sum of a row), and of
    /// the shift. They bound what rounding does to a ray's origin.
    pub(crate) linear_size: f64,
    pub(crate) shift_size: f64,
    pub(crate) surface: SurfaceId,
    /// Its node, if it is part of a tree.
    pub(crate) node: u32,
}

/// A part of the union that the scene is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Component {
    Leaf(u32),
    /// A tree by its root node, and its index among the trees.
    Tree {
        root: u32,
        tree: u32,
    },
}

/// The shapes of a tree of set operations, for finding those that a ray may meet.
#[derive(Debug)]
pub(crate) struct Tree {
    /// Of a carving, the shapes that it is carved from, which are few; of other trees none.
    pub(crate) whole: Vec<u32>,
    /// Of the others.
    pub(crate) hierarchy: Hierarchy,
}

/// A node of a tree of set operations: true inside its solid. Operands are numbered in their order.
///
/// An operation may have many operands, as many as follow from its being associative: a union of
/// unions is one, and so is the difference of a difference. All are sums with a threshold, of +1 for
/// an operand that is true, but -1 for those taken away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// The node above, [`NONE`] for a root.
    pub(crate) parent: u32,
    /// What it adds to the sum of the node above while it is true.
    pub(crate) weight: i32,
    /// The least sum that makes it true.
    pub(crate) threshold: i32,
    pub(crate) kind: Kind,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Leaf(u32),
    Combined(SetOp),
}

/// No node.
pub(crate) const NONE: u32 = u32::MAX;

impl<R: Real> Scene<R> {
    /// Bytes that a scene takes for each shape while it is built, rounded up.
    pub const BYTES_PER_SHAPE: u64 = (size_of::<Leaf<R>>() + 2 * size_of::<Node>() + 1024) as u64;

    /// Flattens a description. `intern` gives each surface function its number.
    ///
    /// The time and memory it takes grow with [`Object::n_shapes`], which can be exponential in the
    /// size of the program: callers must have checked it.
    pub fn new<S>(object: &Object<S>, mut intern: impl FnMut(&S) -> SurfaceId) -> Self {
        let mut flattening = Flattening {
            scene: Scene {
                leaves: Vec::new(),
                nodes: Vec::new(),
                components: Vec::new(),
                hierarchy: Hierarchy::default(),
                trees: Vec::new(),
                conditioning: Conditioning::default(),
                extent: 0.0,
                face_surfaces: Vec::new(),
                n_shared: 0,
                omissions: Omissions::ALL,
            },
            faces: Faces::default(),
            turns: Turns::default(),
            n_trees: 0,
            tasks: vec![Task {
                object,
                placement: Rc::new(Placement::identity()),
                above: Above::Union,
            }],
        };
        while let Some(task) = flattening.tasks.pop() {
            flattening.perform(task, &mut intern);
        }
        let Flattening { mut scene, mut faces, .. } = flattening;
        let open = faces.open();
        let placements = if open.is_empty() { HashMap::new() } else { placements(object, &open) };
        (scene.face_surfaces, scene.n_shared) = faces.surfaces(&placements);
        scene.index();
        scene
    }

    /// Builds the hierarchies.
    fn index(&mut self) {
        let leaves: Vec<Bounds> = self.leaves.par_iter().map(Leaf::bounds).collect();
        self.conditioning = self
            .leaves
            .iter()
            .fold(Conditioning::default(), |all, leaf| all.or(leaf.conditioning()));
        let mut trees = self.nodes.chunk_by(|_, next| next.parent != NONE);
        let mut found = Vec::new();
        let mut bounds_of = |component: &Component| match *component {
            Component::Leaf(leaf) => leaves[leaf as usize],
            Component::Tree { root, .. } => {
                let nodes = trees.next().expect("a root for each tree");
                let relevant = bounds::relevant(nodes, root, |leaf| leaves[leaf as usize]);
                found.push(Tree::new(nodes, root, &relevant));
                relevant[0]
            }
        };
        let boxes = self.components.iter().map(&mut bounds_of);
        self.hierarchy = Hierarchy::new((0..).zip(boxes));
        let of_trees = found.iter().map(|tree| &tree.hierarchy);
        self.extent = of_trees.chain([&self.hierarchy]).map(Hierarchy::extent).fold(0.0, f64::max);
        self.trees = found;
    }

    /// The same scene, of which only these parts may be left out; at first, all may.
    #[must_use]
    pub fn leaving_out(mut self, omissions: Omissions) -> Self {
        self.omissions = omissions;
        for leaf in &mut self.leaves {
            leaf.is_unturned &= omissions.holds(Part::Turns);
        }
        self
    }

    /// Kind and surface function of each shape.
    pub fn shapes(&self) -> impl Iterator<Item = (ShapeKind, SurfaceId)> {
        self.leaves.iter().map(|leaf| (leaf.kind, leaf.surface))
    }

    /// The world-space surface that a face of a leaf is part of.
    pub(crate) fn face_surface(&self, leaf: &Leaf<R>, face: u8) -> u32 {
        self.face_surfaces[leaf.first_face as usize + face as usize]
    }
}

impl<R: Real> Leaf<R> {
    /// A box around it, with room for rounding.
    fn bounds(&self) -> Bounds {
        let maps = [&self.world_from_object, &self.object_from_world].map(Affine::to_daffine3);
        let bounds = bounds::of_shape(self.kind, &maps[0], &maps[1]);
        bounds.padded(|size| self.conditioning().error(size))
    }

    /// A point of world space in object space.
    #[inline(always)]
    pub(crate) fn local_point(&self, p: Vec3<R>) -> Vec3<R> {
        let map = &self.object_from_world;
        if self.is_unturned { map.point_by_diagonal(p) } else { map.point(p) }
    }

    /// A vector of world space in object space.
    #[inline(always)]
    pub(crate) fn local_vector(&self, v: Vec3<R>) -> Vec3<R> {
        let map = &self.object_from_world;
        if self.is_unturned { map.vector_by_diagonal(v) } else { map.vector(v) }
    }

    /// The size of the terms that a ray's origin is computed from in object space.
    #[inline]
    pub(crate) fn origin_size(&self, ray: &Ray<R>) -> f64 {
        self.linear_size * ray.origin.max_norm().to_f64() + self.shift_size
    }

    fn conditioning(&self) -> Conditioning {
        let rows = self.world_from_object.rows.iter();
        let stretch = rows.map(row_size).fold(0.0, f64::max);
        Conditioning { linear: stretch * self.linear_size, shift: stretch * self.shift_size }
    }
}

impl Tree {
    /// Of nodes, in preorder, and where they matter.
    fn new(nodes: &[Node], root: u32, relevant: &[Bounds]) -> Self {
        let leaves = nodes.iter().zip(relevant).filter_map(|(node, bounds)| match node.kind {
            Kind::Leaf(leaf) => Some((leaf, *bounds)),
            Kind::Combined(_) => None,
        });
        let whole = carving::whole(nodes, root);
        let others = leaves.filter(|(leaf, _)| whole.binary_search(leaf).is_err());
        Tree { hierarchy: Hierarchy::new(others), whole }
    }
}

/// The sum of the sizes of a row's entries.
fn row_size<R: Real>(row: &Vec3<R>) -> f64 {
    (row.x.abs() + row.y.abs() + row.z.abs()).to_f64()
}

/// What a part of the description is an operand of.
#[derive(Clone, Copy)]
enum Above {
    /// The union that the scene is.
    Union,
    /// A node; whether as its first operand.
    Node(u32, bool),
}

/// A part of the description to be visited.
struct Task<'o, S> {
    object: &'o Object<S>,
    placement: Rc<Placement>,
    above: Above,
}

/// The placements of these shapes. They are large, and few are needed once shapes are placed.
fn placements<S>(object: &Object<S>, shapes: &HashSet<u32>) -> HashMap<u32, Rc<Placement>> {
    let (mut turns, mut found, mut n_shapes) = (Turns::default(), HashMap::new(), 0);
    let mut tasks = vec![(object, Rc::new(Placement::identity()))];
    while let Some((object, placement)) = tasks.pop() {
        let placement = match object.kind() {
            NodeKind::Transformed(op) => Rc::new(placement.of_transformed(*op, &mut turns)),
            NodeKind::Combined(_) => placement,
            NodeKind::Shape(..) => {
                if shapes.contains(&n_shapes) {
                    found.insert(n_shapes, placement);
                }
                n_shapes += 1;
                continue;
            }
        };
        // Pushed last is visited first.
        tasks.extend(object.children().rev().map(|operand| (operand, placement.clone())));
    }
    found
}

struct Flattening<'o, S, R> {
    scene: Scene<R>,
    faces: Faces,
    turns: Turns,
    n_trees: u32,
    /// What is left to do, the next last.
    tasks: Vec<Task<'o, S>>,
}

impl<'o, S, R: Real> Flattening<'o, S, R> {
    fn perform(&mut self, task: Task<'o, S>, intern: &mut impl FnMut(&S) -> SurfaceId) {
        let Task { object, placement, above } = task;
        match object.kind() {
            NodeKind::Shape(kind, surface) => self.leaf(*kind, intern(surface), placement, above),
            NodeKind::Transformed(op) => {
                let placement = Rc::new(placement.of_transformed(*op, &mut self.turns));
                let inner = object.children().next().expect("a transform has an operand");
                self.tasks.push(Task { object: inner, placement, above });
            }
            NodeKind::Combined(op) => self.combined(object, *op, &placement, above),
        }
    }

    fn combined(
        &mut self,
        object: &'o Object<S>,
        op: SetOp,
        placement: &Rc<Placement>,
        above: Above,
    ) {
        let operands_of = match above {
            Above::Union if op == SetOp::Union => Above::Union,
            Above::Node(node, is_first) if self.is_part_of(op, node, is_first) => above,
            _ => Above::Node(self.node(Kind::Combined(op), above), true),
        };
        if let (Above::Union, Above::Node(root, _)) = (above, operands_of) {
            let tree = self.n_trees;
            self.n_trees += 1;
            self.scene.components.push(Component::Tree { root, tree });
        }
        // Pushed last is visited first: the second operand waits.
        for (side, operand) in object.children().enumerate().collect::<Vec<_>>().into_iter().rev() {
            let above = match operands_of {
                Above::Node(node, is_first) => Above::Node(node, is_first && side == 0),
                Above::Union => Above::Union,
            };
            self.tasks.push(Task { object: operand, placement: placement.clone(), above });
        }
    }

    /// Whether the operands of an operation may be operands of the node above it.
    fn is_part_of(&self, op: SetOp, node: u32, is_first: bool) -> bool {
        let is_same = self.scene.nodes[node as usize].kind == Kind::Combined(op);
        is_same && (is_first || op != SetOp::Difference)
    }

    fn leaf(
        &mut self,
        kind: ShapeKind,
        surface: SurfaceId,
        placement: Rc<Placement>,
        above: Above,
    ) {
        let index = self.scene.leaves.len() as u32;
        let node = match above {
            Above::Union => {
                self.scene.components.push(Component::Leaf(index));
                NONE
            }
            Above::Node(..) => self.node(Kind::Leaf(index), above),
        };
        let first_face = self
            .scene
            .leaves
            .last()
            .map_or(0, |leaf| leaf.first_face + shape::forms(leaf.kind).len() as u32);
        let object_from_world: Affine<R> = placement.object_from_world.rounded();
        let eye = placement.object_from_world.rounded::<Ball<Dd>>().point(camera::eye());
        self.scene.leaves.push(Leaf {
            kind,
            surface,
            node,
            first_face,
            world_from_object: placement.world_from_object.rounded(),
            object_from_world,
            linear_size: object_from_world.rows.iter().map(row_size).fold(0.0, f64::max),
            shift_size: object_from_world.shift.max_norm().to_f64(),
            is_unturned: object_from_world.is_diagonal(),
            eye: object_from_world.point(camera::eye()),
            at_eye: shape::faces_at(kind, eye),
        });
        self.faces.add(kind, &placement);
    }

    /// Makes a node below another.
    fn node(&mut self, kind: Kind, above: Above) -> u32 {
        let (parent, weight) = match above {
            Above::Union => (NONE, 0),
            Above::Node(parent, is_first) => {
                let above = &mut self.scene.nodes[parent as usize];
                let is_taken_away = above.kind == Kind::Combined(SetOp::Difference) && !is_first;
                if above.kind == Kind::Combined(SetOp::Intersect) {
                    above.threshold += 1;
                }
                (parent, if is_taken_away { -1 } else { 1 })
            }
        };
        let threshold = if kind == Kind::Combined(SetOp::Intersect) { 0 } else { 1 };
        self.scene.nodes.push(Node { parent, weight, threshold, kind });
        self.scene.nodes.len() as u32 - 1
    }
}
