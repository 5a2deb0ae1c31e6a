//! Bodies: a mesh or a tree from a file, in whichever of the ten node types.

use super::error::Error;
use super::mesh::{self, Empty, MeshData};
use super::{TreeOptions, progress};
use core::ops::ControlFlow;
use core::time::Duration;
use simdop::construct::{BuildError, Builder, Mesh, Progress};
use simdop::hierarchy::{Aligned, BakeError, Bvh, Header, MAGIC, Stats, TreeStats, VerifyError};
use simdop::isa::Isa;
use simdop::node::{Link, Node, Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Pair, Query};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// k and arity of a tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Shape {
    pub(super) k: usize,
    pub(super) arity: usize,
}

macro_rules! trees {
    ($($variant:ident $node:ident $k:literal),*) => {
        /// A tree of any node type.
        pub(super) enum Tree {
            $($variant(Bvh<$node<$k>>),)*
        }

        /// Evaluates an expression for whichever tree it is.
        macro_rules! with_tree {
            ($tree:expr, $bound:ident => $value:expr) => {
                match $tree { $(Tree::$variant($bound) => $value,)* }
            };
        }

        impl Tree {
            fn build(
                mesh: &Mesh<'_>,
                builder: &Builder,
                shape: Shape,
                observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
            ) -> Result<Self, BuildError> {
                $(if (shape.k, shape.arity) == ($k, $node::<$k>::ARITY) {
                    return builder.build_with(mesh, observer).map(Self::$variant);
                })*
                unreachable!("k and arity were checked with the arguments")
            }

            /// `None` if no node type has this k and arity.
            fn load(bytes: &[u8], shape: Shape) -> Option<Result<Self, BakeError>> {
                $(if (shape.k, shape.arity) == ($k, $node::<$k>::ARITY) {
                    return Some(Bvh::from_bytes(bytes).map(Self::$variant));
                })*
                None
            }

            /// Runs a query on two trees. `None` if their node types differ.
            pub(super) fn collide(&self, other: &Self, query: Query, pose: &Pose) -> Option<Answer> {
                match (self, other) {
                    $((Self::$variant(a), Self::$variant(b)) => Some(query.collide(&a.view(), &b.view(), pose)),)*
                    _ => None,
                }
            }

            /// Calls `visit` with every pair of triangles that meet, until it breaks. `None` if their node types differ.
            pub(super) fn for_each_pair(
                &self,
                other: &Self,
                query: Query,
                pose: &Pose,
                visit: &mut dyn FnMut(Pair) -> ControlFlow<()>,
            ) -> Option<Completion> {
                let (completion, _) = match (self, other) {
                    $((Self::$variant(a), Self::$variant(b)) => query.for_each_pair(&a.view(), &b.view(), pose, visit),)*
                    _ => return None,
                };
                Some(completion)
            }
        }
    };
}

trees!(
    A6 Node16 6, A14 Node16 14, A18 Node16 18, A26 Node16 26, A32 Node16 32,
    B6 Node4 6, B14 Node4 14, B18 Node4 18, B26 Node4 26, B32 Node4 32
);

impl Tree {
    pub(super) fn header(&self) -> Header {
        with_tree!(self, tree => *tree.view().header())
    }

    pub(super) fn shape(&self) -> Shape {
        let header = self.header();
        Shape { k: header.k.into(), arity: header.arity.into() }
    }

    pub(super) fn stats(&self) -> Stats {
        with_tree!(self, tree => tree.view().stats())
    }

    pub(super) fn tree_stats(&self) -> TreeStats {
        with_tree!(self, tree => tree.view().tree_stats())
    }

    pub(super) fn verify(&self) -> Result<(), VerifyError> {
        with_tree!(self, tree => tree.view().verify())
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        with_tree!(self, tree => tree.as_bytes())
    }

    /// Every triangle, with the lane of the root that it is below.
    pub(super) fn clusters(&self) -> Vec<(usize, [[f64; 3]; 3])> {
        with_tree!(self, tree => {
            let view = tree.view();
            let mut found = Vec::with_capacity(view.len());
            let root = view.nodes().first().map_or(&[][..], |root| root.children());
            let mut pending: Vec<_> = root.iter().enumerate().map(|(lane, child)| (lane, *child)).collect();
            while let Some((lane, child)) = pending.pop() {
                match child.link() {
                    Link::Empty => {}
                    Link::Leaf { first, count } => {
                        found.extend((first..first + count).map(|index| (lane, view.triangle(index))));
                    }
                    Link::Inner(node) => {
                        let children = view.nodes()[node as usize].children();
                        pending.extend(children.iter().map(|child| (lane, *child)));
                    }
                }
            }
            found
        })
    }

    /// The mesh that was built: its triangles in their order, its vertices as far as triangles use them.
    pub(super) fn mesh(&self) -> MeshData {
        with_tree!(self, tree => {
            let view = tree.view();
            let mut soup = vec![[[0.0; 3]; 3]; view.len()];
            for index in 0..view.len() as u32 {
                // No more than a hint in an unverified tree: the library proves ranges, not that sources are a permutation.
                if let Some(triangle) = soup.get_mut(view.source(index) as usize) {
                    *triangle = view.triangle(index);
                }
            }
            MeshData::of(&soup)
        })
    }
}

/// How a tree holds its vertices.
pub(super) fn vertex_format(header: &Header) -> &'static str {
    if header.vertex_size == 12 { "f32" } else { "f64" }
}

/// What a file holds.
pub(super) enum Source {
    Tree(Box<Tree>),
    Mesh(MeshData),
}

/// A tree, its name, and how long it took to read its file and to build it.
pub(super) struct Body {
    pub(super) name: String,
    pub(super) tree: Tree,
    /// `None`: generated.
    pub(super) read: Option<Duration>,
    /// `None`: the file held the tree.
    pub(super) build: Option<Duration>,
}

/// Files of fewer bytes are read at once, as far as a person can tell.
const LONG_READ: usize = 4 << 20;
/// Meshes of fewer triangles are built at once.
const LONG_BUILD: usize = 100_000;

/// Reads a file: a tree if it begins as one, whatever its name; else a mesh.
pub(super) fn read(path: &Path, options: &TreeOptions, quiet: bool) -> Result<Source, Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let _spinner = progress::step(format!("reading {}", path.display()), quiet || bytes.len() < LONG_READ);
    if bytes.starts_with(&MAGIC) {
        let tree = load(&bytes).map_err(|error| Error::Tree { path: path.into(), error })?;
        Ok(Source::Tree(Box::new(tree)))
    } else {
        let empty = if options.allow_empty { Empty::Allowed } else { Empty::Refused };
        mesh::read(path, &bytes, empty).map(Source::Mesh)
    }
}

/// The bytes of a file have no alignment: the header is copied first, to find out which node type to load.
fn load(bytes: &[u8]) -> Result<Tree, BakeError> {
    const SIZE: usize = size_of::<Header>();
    let mut head = Aligned([0_u8; SIZE]);
    let part = bytes.get(..SIZE).ok_or(BakeError::Truncated { have: bytes.len(), need: SIZE })?;
    head.0.copy_from_slice(part);
    let &Header { k, arity, .. } = Header::read(&head.0)?;
    let shape = Shape { k: k.into(), arity: arity.into() };
    Tree::load(bytes, shape).unwrap_or(Err(BakeError::OtherNode { k, arity }))
}

/// Builds the tree of a mesh.
pub(super) fn build(
    name: String,
    mesh: &MeshData,
    options: &TreeOptions,
    shape: Shape,
    quiet: bool,
) -> Result<Body, Error> {
    let levels = progress::levels(mesh.triangles.len(), options.leaf_size() as usize, shape.arity);
    let bar = progress::build(&name, levels, quiet || mesh.triangles.len() < LONG_BUILD);
    let mut observer = |_: Progress| {
        // A tree may be deeper than a full one.
        bar.set_position((bar.position() + 1).min(levels));
        ControlFlow::Continue(())
    };
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let builder = Builder::new().leaf_size(options.leaf_size()).splitter(options.splitter().into());
    let start = Instant::now();
    let tree = Tree::build(&mesh, &builder, shape, &mut observer)
        .map_err(|error| Error::Build { name: name.clone(), error })?;
    Ok(Body { name, tree, read: None, build: Some(start.elapsed()) })
}

/// The shape that the options ask for, where they do, and else the one of a given tree, or the default.
pub(super) fn shape(options: &TreeOptions, given: Option<Shape>) -> Shape {
    let default = given.unwrap_or(Shape { k: 18, arity: 16 });
    Shape { k: options.k.unwrap_or(default.k), arity: options.arity.unwrap_or(default.arity) }
}

/// What two bodies are: [`pair`] and the built-in scene see to that.
pub(super) const SAME: &str = "bodies of one node type";

/// Two bodies of one node type, from files that may be trees.
pub(super) fn pair(paths: [&PathBuf; 2], options: &TreeOptions, quiet: bool) -> Result<[Body; 2], Error> {
    let timed = |path: &PathBuf| -> Result<(Source, Duration), Error> {
        let start = Instant::now();
        Ok((read(path, options, quiet)?, start.elapsed()))
    };
    let [a, b] = [timed(paths[0])?, timed(paths[1])?];
    if let (Source::Tree(_), Source::Tree(_), Some(option)) = (&a.0, &b.0, options.first_given()) {
        return Err(Error::idle(option, &paths[0].display()));
    }
    let given = [&a.0, &b.0].into_iter().find_map(|source| match source {
        Source::Tree(tree) => Some(tree.shape()),
        Source::Mesh(_) => None,
    });
    let shape = shape(options, given);
    let body = |(source, time): (Source, Duration), path: &PathBuf| -> Result<Body, Error> {
        let name = path.display().to_string();
        let body = match source {
            Source::Mesh(mesh) => build(name, &mesh, options, shape, quiet)?,
            Source::Tree(tree) if tree.shape() == shape => {
                Body { name, tree: *tree, read: None, build: None }
            }
            Source::Tree(tree) => return Err(Error::OtherShape { name, has: tree.shape(), asked: shape }),
        };
        Ok(Body { read: Some(time), ..body })
    };
    Ok([body(a, paths[0])?, body(b, paths[1])?])
}

/// The query that the options ask for.
pub(super) fn query(isa: Isa, budget: Option<u64>) -> Query {
    let query = Query::new(isa);
    budget.map_or(query, |visits| query.with_budget(visits))
}
