//! From the description to the scene.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use rayon::prelude::*;

use crate::bounds::{self, Bounds};
use crate::carving;
use crate::hierarchy::{Hierarchy, Item};
use crate::intern::Faces;
use crate::numeric::affine::Affine;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::{NodeKind, Object, SetOp};
use crate::placement::{Placement, Turns};
use crate::plan::Omissions;
use crate::ray::Conditioning;
use crate::scene::building::Built;
use crate::scene::{Component, Detail, Kind, Leaf, NONE, Node, Scene, Tree};
use crate::shape;
use crate::surface::SurfaceId;

/// So many leaves are made at a time, which stay in the cache until they are added to the scene.
const BATCH: usize = 4096;

/// Leaves that are worth a thread's while: of what takes some hundred nanoseconds each.
const MIN_LEAVES: usize = 64;

impl<R: Real> Scene<R> {
    /// Bytes that a scene takes for each shape while it is built, at most: what is kept of it, and 960 for
    /// placements that wait or are compared, boxes, and what the allocator loses. Of 400,000 shapes in
    /// doubles, where this is 1,224, there were measured 309 for spheres in a union, 458 for turned cubes,
    /// 1,044 for cubes in transforms nested as deep, and 1,095 for pairs of equal spheres, intersected.
    pub const BYTES_PER_SHAPE: u64 =
        (size_of::<Leaf<R>>() + 4 * size_of::<Vec3<R>>() + 2 * size_of::<Node>() + 960) as u64;

    /// Flattens a description. `intern` gives each surface function its number.
    ///
    /// The memory it takes grows with [`Object::n_shapes`], which can be exponential in the size of the
    /// program: callers must have checked it. The time grows with the transforms of each of these shapes,
    /// as those of a shared object are gone through for each place where it stands.
    pub fn new<S: Sync + Send>(
        object: &Object<S>,
        mut intern: impl FnMut(&S) -> SurfaceId,
    ) -> Self {
        let Flattened { mut scene, faces, items, tree_bounds } =
            Flattening::new(object).flattened(&mut intern);
        scene.intern(faces, object);
        scene.index(items, &tree_bounds);
        scene
    }

    /// Adds the leaf of the next detail, whose first face has this number.
    #[inline]
    fn add_leaf(&mut self, built: Built<R>, first_face: u32) {
        let Built { leaf, world_from_object: Affine { rows: [x, y, z], shift }, .. } = built;
        self.details[self.leaves.len()].map = self.maps.len() as u32;
        if leaf.is_diagonal {
            self.maps.extend([Vec3::new(x.x, y.y, z.z), shift]);
        } else {
            self.maps.extend([x, y, z, shift]);
        }
        self.conditioning = self.conditioning.or(built.conditioning);
        self.leaves.push(Leaf { first_face, ..leaf });
    }

    /// Numbers the surfaces of faces.
    fn intern<S>(&mut self, mut faces: Faces, object: &Object<S>) {
        let leaf_of = |face: u32| self.leaves.partition_point(|leaf| leaf.first_face <= face) - 1;
        let open: HashSet<u32> = faces.open().map(|face| leaf_of(face) as u32).collect();
        let placements = if open.is_empty() { HashMap::new() } else { placements(object, &open) };
        (self.face_surfaces, self.n_shared) = faces.surfaces(|face| {
            let index = leaf_of(face);
            let Leaf { kind, first_face, .. } = self.leaves[index];
            let form = shape::forms(kind)[(face - first_face) as usize];
            (form, &*placements[&(index as u32)])
        });
    }

    /// Builds the hierarchies, of boxes around the leaves that are components, and around those of trees.
    fn index(&mut self, mut items: Vec<Item>, mut tree_bounds: &[Bounds]) {
        let mut trees = Vec::new();
        let mut chunks = self.nodes.chunk_by(|_, next| next.parent != NONE);
        for (number, component) in (0..).zip(&self.components) {
            let Component::Tree { root, .. } = *component else { continue };
            let nodes = chunks.next().expect("nodes of each tree");
            let n_leaves = nodes.iter().filter(|node| matches!(node.kind, Kind::Leaf(_))).count();
            let (bounds, others) = tree_bounds.split_at(n_leaves);
            tree_bounds = others;
            trees.push((number, root, nodes, bounds));
        }
        let built = trees.into_par_iter().map(|(component, root, nodes, bounds)| {
            let (tree, bounds) = tree(nodes, root, bounds);
            (tree, Item::new(component, &bounds))
        });
        let of_trees: Vec<Item>;
        (self.trees, of_trees) = built.unzip();
        items.extend(of_trees);
        self.hierarchy = Hierarchy::new(items);
        let hierarchies = self.trees.iter().map(|tree| &tree.hierarchy).chain([&self.hierarchy]);
        self.extent = hierarchies.map(Hierarchy::extent).fold(0.0, f64::max);
    }
}

/// A tree with these nodes, of which the root has this number, whose leaves have these bounds, and a box
/// around it.
fn tree(nodes: &[Node], root: u32, leaves: &[Bounds]) -> (Tree, Bounds) {
    let mut leaves = leaves.iter();
    let relevant = bounds::relevant(nodes, root, |_| *leaves.next().expect("bounds of each leaf"));
    let whole = carving::whole(nodes, root);
    let items = nodes.iter().zip(&relevant).filter_map(|(node, bounds)| match node.kind {
        Kind::Leaf(leaf) if whole.binary_search(&leaf).is_err() => Some(Item::new(leaf, bounds)),
        Kind::Leaf(_) | Kind::Combined(_) => None,
    });
    (Tree { hierarchy: Hierarchy::new(items.collect()), whole }, relevant[0])
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
    placement: Arc<Placement>,
    above: Above,
}

/// The placements of these shapes. They are large, and few are needed once shapes are placed.
fn placements<S>(object: &Object<S>, shapes: &HashSet<u32>) -> HashMap<u32, Arc<Placement>> {
    let (mut turns, mut found, mut n_shapes) = (Turns::default(), HashMap::new(), 0);
    let mut tasks = vec![(object, Arc::new(Placement::identity()))];
    while let Some((object, placement)) = tasks.pop() {
        let placement = match object.kind() {
            NodeKind::Transformed(op) => Arc::new(placement.of_transformed(*op, &mut turns)),
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

/// A shape in transforms, where these are to stand, and the number of the component that it is, or
/// [`NONE`].
struct Placed<'o, S> {
    object: &'o Object<S>,
    placement: Arc<Placement>,
    component: u32,
}

impl<S> Placed<'_, S> {
    fn built<R: Real>(&self, turns: &mut Turns) -> Built<R> {
        let NodeKind::Shape(kind, _) = inside_transforms(self.object).kind() else {
            unreachable!("shapes become leaves")
        };
        let mut placement = Placement::clone(&self.placement);
        go_inside(self.object, &mut placement, turns);
        Built::new(*kind, &placement)
    }
}

/// What is inside all transforms of an object.
fn inside_transforms<S>(object: &Object<S>) -> &Object<S> {
    let mut inner = object;
    while let NodeKind::Transformed(_) = inner.kind() {
        inner = inner.children().next().expect("a transform has an operand");
    }
    inner
}

/// Makes the placement of an object that of what is inside all its transforms.
fn go_inside<S>(object: &Object<S>, placement: &mut Placement, turns: &mut Turns) {
    let mut inner = object;
    while let NodeKind::Transformed(op) = inner.kind() {
        placement.transform(*op, turns);
        inner = inner.children().next().expect("a transform has an operand");
    }
}

/// A scene whose surfaces are not numbered and whose hierarchies are not built, and what for that.
struct Flattened<R> {
    scene: Scene<R>,
    faces: Faces,
    /// Boxes around the leaves that are components, with the components' numbers.
    items: Vec<Item>,
    /// Those of the leaves of trees, in order.
    tree_bounds: Vec<Bounds>,
}

struct Flattening<'o, S, R> {
    scene: Scene<R>,
    faces: Faces,
    turns: Turns,
    n_trees: u32,
    /// What is left to do, the next last.
    tasks: Vec<Task<'o, S>>,
    /// Whether leaves are made by one thread.
    is_alone: bool,
    /// Shapes that are yet to become leaves, the next of the scene.
    placed: Vec<Placed<'o, S>>,
    /// Memory for making leaves.
    built: Vec<Built<R>>,
    items: Vec<Item>,
    tree_bounds: Vec<Bounds>,
}

impl<'o, S: Sync + Send, R: Real> Flattening<'o, S, R> {
    fn new(object: &'o Object<S>) -> Self {
        // Room at once for what large scenes need at least, or at most: what a growing list leaves behind
        // would be lost between the others. Memory that is not used is not taken.
        let n_leaves = usize::try_from(object.n_shapes()).unwrap_or(usize::MAX);
        let mut tasks = Vec::with_capacity(n_leaves);
        let placement = Arc::new(Placement::identity());
        tasks.push(Task { object, placement, above: Above::Union });
        Flattening {
            scene: Scene {
                leaves: Vec::with_capacity(n_leaves),
                details: Vec::with_capacity(n_leaves),
                maps: Vec::with_capacity(2 * n_leaves),
                nodes: Vec::new(),
                components: Vec::with_capacity(n_leaves),
                hierarchy: Hierarchy::default(),
                trees: Vec::new(),
                conditioning: Conditioning::default(),
                extent: 0.0,
                face_surfaces: Vec::new(),
                n_shared: 0,
                omissions: Omissions::ALL,
            },
            faces: Faces::with_room_for(n_leaves),
            turns: Turns::default(),
            n_trees: 0,
            tasks,
            is_alone: rayon::current_num_threads() == 1,
            placed: Vec::new(),
            built: Vec::new(),
            items: Vec::with_capacity(n_leaves),
            tree_bounds: Vec::new(),
        }
    }

    fn flattened(mut self, intern: &mut impl FnMut(&S) -> SurfaceId) -> Flattened<R> {
        while let Some(task) = self.tasks.pop() {
            self.perform(task, intern);
        }
        self.make_leaves();
        let Flattening { mut scene, faces, items, tree_bounds, .. } = self;
        scene.maps.shrink_to_fit();
        scene.nodes.shrink_to_fit();
        scene.components.shrink_to_fit();
        Flattened { scene, faces, items, tree_bounds }
    }

    fn perform(&mut self, task: Task<'o, S>, intern: &mut impl FnMut(&S) -> SurfaceId) {
        let Task { object, mut placement, above } = task;
        let inner = inside_transforms(object);
        match inner.kind() {
            NodeKind::Shape(_, surface) => self.shape(object, placement, intern(surface), above),
            NodeKind::Combined(op) => {
                if let NodeKind::Transformed(_) = object.kind() {
                    go_inside(object, Arc::make_mut(&mut placement), &mut self.turns);
                }
                self.combined(inner, *op, &placement, above);
            }
            NodeKind::Transformed(_) => {}
        }
    }

    fn combined(
        &mut self,
        object: &'o Object<S>,
        op: SetOp,
        placement: &Arc<Placement>,
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
        for (operand, is_left) in object.children().rev().zip([false, true]) {
            let above = match operands_of {
                Above::Node(node, is_first) => Above::Node(node, is_first && is_left),
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

    /// Adds a shape to those that become leaves.
    fn shape(
        &mut self,
        object: &'o Object<S>,
        placement: Arc<Placement>,
        surface: SurfaceId,
        above: Above,
    ) {
        let index = self.scene.details.len() as u32;
        let (component, node) = match above {
            Above::Union => {
                self.scene.components.push(Component::Leaf(index));
                (self.scene.components.len() as u32 - 1, NONE)
            }
            Above::Node(..) => (NONE, self.node(Kind::Leaf(index), above)),
        };
        self.scene.details.push(Detail { surface, node, map: 0 });
        let shape = Placed { object, placement, component };
        if self.is_alone {
            let built = shape.built(&mut self.turns);
            return self.add(component, built);
        }
        self.placed.push(shape);
        if self.placed.len() == BATCH {
            self.make_leaves();
        }
    }

    /// Makes leaves of shapes.
    fn make_leaves(&mut self) {
        let placed = self.placed.par_iter().with_min_len(MIN_LEAVES);
        let made = placed.map_init(Turns::default, |turns, placed| placed.built(turns));
        made.collect_into_vec(&mut self.built);
        let (mut placed, mut built) =
            (std::mem::take(&mut self.placed), std::mem::take(&mut self.built));
        for (Placed { component, .. }, built) in placed.drain(..).zip(built.drain(..)) {
            self.add(component, built);
        }
        (self.placed, self.built) = (placed, built);
    }

    /// Adds a leaf, and the number of the component that it is.
    #[inline]
    fn add(&mut self, component: u32, built: Built<R>) {
        match component {
            NONE => self.tree_bounds.push(built.bounds),
            _ => self.items.push(Item::new(component, &built.bounds)),
        }
        let first_face = self.faces.add(built.keys());
        self.scene.add_leaf(built, first_face);
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
