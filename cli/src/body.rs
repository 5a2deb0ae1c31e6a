//! Bodies: a mesh or a tree of any node type from a file.

use super::error::Error;
use super::{TreeOptions, demo, progress};
use core::fmt;
use core::ops::ControlFlow;
use core::time::Duration;
use serde::Serialize;
use simdop::construct::{Builder, ConvexHull, Mesh, Progress, SphereSet};
use simdop::hierarchy::{AnyBvh, AnyBvhRef, Bvh, BvhRef, CapStats, Header, Lane, MAGIC, NodeType};
use simdop::isa::Isa;
use simdop::mesh_io::{self, FileError, MeshData};
use simdop::node::{Dop, Link, Node16};
use simdop::primitive::{Primitive, Sphere, Spheres};
use simdop::query::Query;
use simdop::with_bvh;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Every triangle, with the lane of the root it is below.
pub(super) fn clusters(tree: &AnyBvh) -> Vec<(usize, [[f64; 3]; 3])> {
    with_bvh!(tree.view(), tree => primitives_by_root_lane(&tree))
}

/// Every primitive, with the lane of the root it is below.
pub(super) fn primitives_by_root_lane<N: Dop, P: Primitive>(
    tree: &BvhRef<'_, N, P>,
) -> Vec<(usize, P::Item)> {
    let mut found = Vec::with_capacity(tree.len());
    let mut walk = tree.walk();
    while let Some(Lane { child, .. }) = walk.next() {
        let Link::Leaf { first, count } = child.link() else { continue };
        let root_lane = walk.path().next().map_or(0, |(_, lane)| lane);
        found.extend((first..first + count).map(|index| (root_lane, tree.primitive(index))));
    }
    found
}

/// The mesh that the tree was built from: its triangles in their original order, and the vertices that they use.
pub(super) fn mesh_of(tree: &AnyBvh) -> MeshData {
    with_bvh!(tree.view(), tree => {
        let mut soup = vec![[[0.0; 3]; 3]; tree.len()];
        for index in 0..tree.len() as u32 {
            // In an unverified tree, the source is only a hint: validation checks its range, but not that sources are a
            // permutation.
            if let Some(triangle) = soup.get_mut(tree.source(index) as usize) {
                *triangle = tree.primitive(index);
            }
        }
        MeshData::of(&soup)
    })
}

/// The format in which a tree stores its vertices.
pub(super) fn vertex_format(header: &Header) -> &'static str {
    if header.vertex_size == 12 { "f32" } else { "f64" }
}

/// The contents of a file.
pub(super) enum Source {
    Tree(Box<AnyBvh>),
    Mesh(MeshData),
}

impl Source {
    /// The mesh, or the mesh that the tree was built from.
    pub(super) fn into_mesh(self) -> MeshData {
        match self {
            Self::Mesh(mesh) => mesh,
            Self::Tree(tree) => mesh_of(&tree),
        }
    }

    /// The width of the capped holes, if it is the tree of a solid with caps.
    pub(super) fn cap_width(&self) -> Option<f64> {
        match self {
            Self::Tree(tree) => Some(tree.view().cap_stats().width).filter(|width| *width > 0.0),
            Self::Mesh(_) => None,
        }
    }

    /// The node type of a tree.
    fn node_type(&self) -> Option<NodeType> {
        match self {
            Self::Tree(tree) => Some(tree.view().node_type()),
            Self::Mesh(_) => None,
        }
    }

    /// Whether it is the tree of a solid.
    pub(super) fn is_solid(&self) -> bool {
        matches!(self, Self::Tree(tree) if tree.view().header().is_solid != 0)
    }
}

/// A tree, its name, and the time it took to read its file and to build it.
pub(super) struct Body {
    pub(super) name: String,
    pub(super) tree: AnyBvh,
    /// `None` if it was generated.
    pub(super) read: Option<Duration>,
    /// `None` if the file held the tree.
    pub(super) build: Option<Duration>,
}

/// A file that a body is made from.
#[derive(Clone, Debug)]
pub(super) struct BodyFile {
    pub(super) path: PathBuf,
    /// Whether the body is the convex hull of its points.
    pub(super) is_hull: bool,
}

impl BodyFile {
    /// The name as on the command line.
    pub(super) fn name(&self) -> String {
        format!("{}{}", if self.is_hull { "hull:" } else { "" }, self.path.display())
    }

    /// The options for this file.
    fn options(&self, options: &TreeOptions) -> TreeOptions {
        let mut options = options.clone();
        options.hull |= self.is_hull;
        options
    }
}

/// Files smaller than this are read instantly, in a user's eyes.
const LONG_READ: usize = 4 << 20;
/// Meshes of fewer triangles than this are built instantly.
const LONG_BUILD: usize = 100_000;

/// Reads a file: as a tree if it begins like one, whatever its name; otherwise as a mesh.
pub(super) fn read(path: &Path, options: &TreeOptions, quiet: bool) -> Result<Source, Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let _spinner = progress::step(format!("reading {}", path.display()), quiet || bytes.len() < LONG_READ);
    if bytes.starts_with(&MAGIC) {
        let tree = AnyBvh::from_bytes(&bytes).map_err(|error| Error::Tree { path: path.into(), error })?;
        Ok(Source::Tree(Box::new(tree)))
    } else {
        let mesh = if options.hull { corners(path, &bytes) } else { mesh_io::read(path, &bytes) };
        let mesh = mesh.map_err(Error::content(path))?;
        if mesh.triangles.is_empty() && (mesh.vertices.is_empty() || !options.hull) && !options.allow_empty {
            // Usually a damaged file.
            let problem = "there is no triangle in the file (--allow-empty takes it for an empty body)";
            return Err(Error::content(path)(FileError::file(problem)));
        }
        Ok(Source::Mesh(mesh))
    }
}

/// Reads the points of a mesh, or of a cloud, which becomes a mesh without triangles.
fn corners(path: &Path, bytes: &[u8]) -> Result<MeshData, FileError> {
    let is = |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if is("xyz") || is("ply") && mesh_io::read(path, bytes)?.triangles.is_empty() {
        return Ok(MeshData { vertices: mesh_io::points(path, bytes)?, triangles: Vec::new() });
    }
    mesh_io::read(path, bytes)
}

/// A file's name and contents. Without a file: a built-in gear.
pub(super) fn source_or_gear(path: Option<&Path>, quiet: bool) -> Result<(String, Source), Error> {
    let Some(path) = path else { return Ok(("gear ring (built in)".into(), Source::Mesh(demo::gear()))) };
    Ok((path.display().to_string(), read(path, &TreeOptions::default(), quiet)?))
}

/// Adds caps over the holes of a mesh, if none is wider than `width`.
pub(super) fn cap(name: &str, mesh: &mut MeshData, width: f64) -> Result<CapStats, Error> {
    let caps = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }.caps(width);
    let caps = caps.map_err(|error| Error::Build { name: name.into(), error })?;
    mesh.triangles.extend(caps.triangles);
    Ok(caps.stats)
}

/// The capped holes of a body.
#[derive(Serialize, Copy, Clone, Debug)]
pub(super) struct CapsReport {
    pub(super) holes: usize,
    pub(super) triangles: usize,
    /// Width of the widest hole.
    pub(super) width: f64,
}

impl CapsReport {
    /// `None` if no hole is capped.
    pub(super) fn of(CapStats { holes, triangles, width }: CapStats) -> Option<Self> {
        (holes > 0).then_some(Self { holes, triangles, width })
    }
}

impl fmt::Display for CapsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let many = if self.holes == 1 { "" } else { "s" };
        write!(f, "{} hole{many} capped, at most {} wide", self.holes, rounded_up(self.width))
    }
}

/// A width with five digits, rounded up, so that it is a sufficient limit.
pub(super) fn rounded_up(width: f64) -> f64 {
    let step = 10_f64.powf(width.log10().floor() - 4.0);
    let digits = |x: f64| format!("{x:.4e}").parse().unwrap_or(x);
    let near: f64 = digits(width);
    if near < width { digits(near + step) } else { near }
}

/// Builds the tree of a mesh, or of its hull.
pub(super) fn build(
    name: String,
    mesh: &MeshData,
    options: &TreeOptions,
    node: NodeType,
    quiet: bool,
) -> Result<Body, Error> {
    let (start, failed) = (Instant::now(), |error| Error::Build { name: name.clone(), error });
    let hull = options.hull.then(|| ConvexHull::of(&mesh.vertices)).transpose().map_err(failed)?;
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let mesh = hull.as_ref().map_or(mesh, |hull| hull.mesh.as_mesh());
    let levels = progress::levels(mesh.triangles.len(), options.leaf_size() as usize, node.arity);
    let bar = progress::build(&name, levels, quiet || mesh.triangles.len() < LONG_BUILD);
    let mut observer = |_: Progress| {
        // A tree may be deeper than a tree with full nodes.
        bar.set_position((bar.position() + 1).min(levels));
        ControlFlow::Continue(())
    };
    let is_solid = hull.as_ref().map_or(options.solid, |hull| hull.is_solid);
    let builder = Builder::new().leaf_size(options.leaf_size()).splitter(options.splitter().into());
    let builder = if options.without_normal_slabs { builder.without_normal_slabs() } else { builder };
    let builder = match options.cap {
        Some(width) if hull.is_none() => builder.solid_with_caps(width),
        _ if is_solid => builder.solid(),
        _ => builder,
    };
    let tree = builder.build_any(&mesh, node, &mut observer).map_err(failed)?;
    Ok(Body { name, tree, read: None, build: Some(start.elapsed()) })
}

/// Number of spheres of the packing in a tree.
pub(super) fn packed_spheres(tree: &AnyBvhRef<'_>) -> usize {
    with_bvh!(tree, tree => tree.packing().map_or(0, |packing| packing.len()))
}

/// Builds the tree of spheres.
pub(super) fn of_spheres(name: &str, spheres: &[Sphere]) -> Result<Bvh<Node16<18>, Spheres>, Error> {
    Builder::new()
        .build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(()))
        .map_err(|error| Error::Build { name: name.into(), error })
}

/// The node type given by the options; otherwise that of a given tree, or the default.
pub(super) fn node_type(options: &TreeOptions, given: Option<NodeType>) -> NodeType {
    let default = given.unwrap_or_default();
    NodeType {
        k: options.k.unwrap_or(default.k),
        arity: options.arity.unwrap_or(default.arity),
        storage: options.storage.map_or(default.storage, Into::into),
    }
}

/// [`pair`] and the built-in scene guarantee this for two bodies.
pub(super) const SAME: &str = "bodies of one node type";

/// A file's contents, and the time it took to read it. If the hull of a tree is requested, the contents are the tree's
/// mesh.
fn timed(file: &BodyFile, options: &TreeOptions, quiet: bool) -> Result<(Source, Duration), Error> {
    let start = Instant::now();
    let source = read(&file.path, &file.options(options), quiet)?;
    let source = if file.is_hull { Source::Mesh(source.into_mesh()) } else { source };
    Ok((source, start.elapsed()))
}

/// Two bodies of one node type, from files that may hold trees.
pub(super) fn pair(files: [&BodyFile; 2], options: &TreeOptions, quiet: bool) -> Result<[Body; 2], Error> {
    pair_as(files, options, options, quiet)
}

/// [`pair`], with meshes built as solids.
pub(super) fn solids(files: [&BodyFile; 2], options: &TreeOptions, quiet: bool) -> Result<[Body; 2], Error> {
    let solid = TreeOptions { solid: options.cap.is_none(), ..options.clone() };
    pair_as(files, options, &solid, quiet)
}

/// [`pair`], with the options as given, and those to build meshes with.
fn pair_as(
    files: [&BodyFile; 2],
    given: &TreeOptions,
    options: &TreeOptions,
    quiet: bool,
) -> Result<[Body; 2], Error> {
    let [a, b] = [timed(files[0], options, quiet)?, timed(files[1], options, quiet)?];
    if let (Source::Tree(_), Source::Tree(_), Some(option)) = (&a.0, &b.0, given.first_given()) {
        return Err(Error::idle(option, &files[0].path.display()));
    }
    let type_of_tree = a.0.node_type().or_else(|| b.0.node_type());
    let node = node_type(options, type_of_tree);
    Ok([of_source(a, files[0], options, node, quiet)?, of_source(b, files[1], options, node, quiet)?])
}

/// A body from a file that may hold a tree.
pub(super) fn single(file: &BodyFile, options: &TreeOptions, quiet: bool) -> Result<Body, Error> {
    let source = timed(file, options, quiet)?;
    if let (Source::Tree(_), Some(option)) = (&source.0, options.first_given()) {
        return Err(Error::idle(option, &file.path.display()));
    }
    let node = node_type(options, source.0.node_type());
    of_source(source, file, options, node, quiet)
}

fn of_source(
    (source, time): (Source, Duration),
    file: &BodyFile,
    options: &TreeOptions,
    node: NodeType,
    quiet: bool,
) -> Result<Body, Error> {
    let name = file.name();
    let body = match source {
        Source::Mesh(mesh) => build(name, &mesh, &file.options(options), node, quiet)?,
        Source::Tree(tree) if tree.view().node_type() == node => {
            Body { name, tree: *tree, read: None, build: None }
        }
        Source::Tree(tree) => {
            return Err(Error::OtherNode { name, has: tree.view().node_type(), asked: node });
        }
    };
    Ok(Body { read: Some(time), ..body })
}

/// The query that the options describe.
pub(super) fn query(isa: Isa, budget: Option<u64>) -> Query {
    let query = Query::new(isa);
    budget.map_or(query, |visits| query.with_budget(visits))
}

#[cfg(test)]
mod tests {
    use super::rounded_up;

    #[test]
    fn widths_are_rounded_up_to_five_digits() {
        let of = [2.0_f64.sqrt(), 0.5, 1.0, 99_999.2, 1e-9, 1.000_01e-7, 123_456.0, 0.003_784_741];
        let want = [1.4143, 0.5, 1.0, 1e5, 1e-9, 1.0001e-7, 123_460.0, 0.003_784_8];
        assert_eq!(of.map(rounded_up), want);
        assert!(of.iter().all(|x| rounded_up(*x) >= *x));
    }
}
