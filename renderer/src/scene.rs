//! What is traced: the description flattened into shapes with their placements, and the trees of
//! set operations above them.
//!
//! A scene is a union of components. Most are single shapes; the others are trees whose root is an
//! intersection or a difference. Shapes are numbered in the order of the program's operands, which
//! decides who paints coincident surfaces. Bounds and a hierarchy over components would go here.

use std::rc::Rc;

use crate::intern;
use crate::numeric::affine::Affine;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::{NodeKind, Object, SetOp, ShapeKind};
use crate::placement::Placement;
use crate::shape;
use crate::surface::SurfaceId;

/// The scene to trace, in the numbers `R`.
#[derive(Debug)]
pub struct Scene<R = f64> {
    pub(crate) leaves: Vec<Leaf<R>>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) components: Vec<Component>,
    /// The world-space surface of each face, faces of one leaf in a row. Equal surfaces have equal
    /// numbers, and those that several faces share have the lowest.
    pub(crate) face_surfaces: Vec<u32>,
    pub(crate) n_shared: u32,
}

/// A shape where it stands.
#[derive(Debug)]
pub(crate) struct Leaf<R> {
    pub(crate) kind: ShapeKind,
    pub(crate) surface: SurfaceId,
    /// Its node, if it is part of a tree.
    pub(crate) node: u32,
    /// Index of its first face in the scene's list.
    pub(crate) first_face: u32,
    pub(crate) world_from_object: Affine<R>,
    pub(crate) object_from_world: Affine<R>,
    /// Sizes of the entries of `object_from_world`: of the matrix (largest sum of a row), and of
    /// the shift. They bound what rounding does to a ray's origin.
    pub(crate) linear_size: f64,
    pub(crate) shift_size: f64,
}

/// A part of the union that the scene is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Component {
    Leaf(u32),
    /// A tree by its root node, and its leaves.
    Tree {
        root: u32,
        first_leaf: u32,
        end_leaf: u32,
    },
}

/// A node of a tree of set operations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// The node above, [`NONE`] for a root.
    pub(crate) parent: u32,
    pub(crate) kind: Operands,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Operands {
    Leaf(u32),
    Both(SetOp, [u32; 2]),
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
                face_surfaces: Vec::new(),
                n_shared: 0,
            },
            placements: Vec::new(),
            tasks: vec![Task::Visit {
                object,
                placement: Rc::new(Placement::identity()),
                above: Above::Union,
            }],
        };
        while let Some(task) = flattening.tasks.pop() {
            flattening.perform(task, &mut intern);
        }
        let Flattening { mut scene, placements, .. } = flattening;
        let kinds: Vec<ShapeKind> = scene.leaves.iter().map(|leaf| leaf.kind).collect();
        (scene.face_surfaces, scene.n_shared) = intern::face_surfaces(&kinds, &placements);
        scene
    }

    /// Number of shapes.
    #[must_use]
    pub fn n_shapes(&self) -> usize {
        self.leaves.len()
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

/// What a part of the description is an operand of.
#[derive(Clone, Copy)]
enum Above {
    /// The union that the scene is.
    Union,
    /// A node, as its first or second operand.
    Node(u32, usize),
}

enum Task<'o, S> {
    Visit {
        object: &'o Object<S>,
        placement: Rc<Placement>,
        above: Above,
    },
    /// All leaves of the last tree have been made.
    EndTree,
}

struct Flattening<'o, S, R> {
    scene: Scene<R>,
    placements: Vec<Rc<Placement>>,
    /// What is left to do, the next last.
    tasks: Vec<Task<'o, S>>,
}

impl<'o, S, R: Real> Flattening<'o, S, R> {
    fn perform(&mut self, task: Task<'o, S>, intern: &mut impl FnMut(&S) -> SurfaceId) {
        let (object, placement, above) = match task {
            Task::Visit { object, placement, above } => (object, placement, above),
            Task::EndTree => return self.end_tree(),
        };
        match object.kind() {
            NodeKind::Shape(kind, surface) => self.leaf(*kind, intern(surface), placement, above),
            NodeKind::Transformed(op) => {
                let placement = Rc::new(placement.of_transformed(*op));
                let inner = object.children().next().expect("a transform has an operand");
                self.tasks.push(Task::Visit { object: inner, placement, above });
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
        let is_top_union = matches!((op, above), (SetOp::Union, Above::Union));
        let node =
            if is_top_union { NONE } else { self.node(Operands::Both(op, [NONE; 2]), above) };
        if matches!(above, Above::Union) && !is_top_union {
            let first_leaf = self.scene.leaves.len() as u32;
            self.scene.components.push(Component::Tree {
                root: node,
                first_leaf,
                end_leaf: first_leaf,
            });
            self.tasks.push(Task::EndTree);
        }
        // Pushed last is visited first: the second operand waits.
        for (side, operand) in object.children().enumerate().collect::<Vec<_>>().into_iter().rev() {
            let above = if is_top_union { Above::Union } else { Above::Node(node, side) };
            self.tasks.push(Task::Visit { object: operand, placement: placement.clone(), above });
        }
    }

    fn end_tree(&mut self) {
        let n_leaves = self.scene.leaves.len() as u32;
        if let Some(Component::Tree { end_leaf, .. }) = self.scene.components.last_mut() {
            *end_leaf = n_leaves;
        }
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
            Above::Node(..) => self.node(Operands::Leaf(index), above),
        };
        let first_face = self
            .scene
            .leaves
            .last()
            .map_or(0, |leaf| leaf.first_face + shape::forms(leaf.kind).len() as u32);
        let object_from_world: Affine<R> = placement.object_from_world.rounded();
        let row_size = |row: &Vec3<R>| (row.x.abs() + row.y.abs() + row.z.abs()).to_f64();
        self.scene.leaves.push(Leaf {
            kind,
            surface,
            node,
            first_face,
            world_from_object: placement.world_from_object.rounded(),
            object_from_world,
            linear_size: object_from_world.rows.iter().map(row_size).fold(0.0, f64::max),
            shift_size: object_from_world.shift.max_norm().to_f64(),
        });
        self.placements.push(placement);
    }

    /// Makes a node and enters it above.
    fn node(&mut self, kind: Operands, above: Above) -> u32 {
        let index = self.scene.nodes.len() as u32;
        let parent = if let Above::Node(parent, side) = above {
            if let Operands::Both(_, operands) = &mut self.scene.nodes[parent as usize].kind {
                operands[side] = index;
            }
            parent
        } else {
            NONE
        };
        self.scene.nodes.push(Node { parent, kind });
        index
    }
}
