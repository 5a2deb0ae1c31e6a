//! `simdop build`.

use super::body::{self, Body, CapsReport, Source};
use super::error::Error;
use super::output;
use super::pack;
use super::picture::{self, Format};
use super::{File, TreeOptions};
use clap::Args;
use simdop::construct::Builder;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// A mesh, or a tree, for the mesh that it was built from. With --hull also a cloud of points.
    mesh: File,
    /// The tree to write. An existing file is replaced atomically, once the tree is complete.
    #[arg(short, long, required_unless_present = "picture")]
    output: Option<File>,
    /// An image to write, .svg or (with the feature `png`) .png by its extension: the mesh, each triangle coloured by
    /// the child of the root that holds it.
    #[arg(long, value_name = "FILE")]
    picture: Option<File>,
    /// Fill the solid with this many spheres, and write them into the tree, so that `simdop depth` finds lower bounds
    /// sooner.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    pack: Option<u32>,
    #[command(flatten)]
    tree: TreeOptions,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let format = options.picture.as_deref().map(Format::of).transpose()?;
    let targets = [("--output", options.output.as_deref()), ("--picture", options.picture.as_deref())];
    output::check_targets(Some(&options.mesh), targets)?;
    let mut tree_options = options.tree.clone();
    let source = body::read(&options.mesh, &options.tree, false)?;
    let (mesh, given) = match source {
        Source::Mesh(mesh) => (mesh, None),
        Source::Tree(_) if options.tree.allow_empty => {
            let name = options.mesh.display();
            return Err(Error::idle("--allow-empty", &name));
        }
        Source::Tree(ref tree) => {
            // The tree of a solid becomes one again.
            tree_options.solid |= tree.view().header().is_solid != 0;
            tree_options.cap = tree_options.cap.or(source.cap_width());
            (body::mesh_of(tree), Some(tree.view().node_type()))
        }
    };
    let name = options.mesh.display().to_string();
    let node = body::node_type(&options.tree, given);
    let mut body = body::build(name, &mesh, &tree_options, node, false)?;
    if let Some(spheres) = options.pack {
        add_packing(&mut body, spheres, tree_options.cap)?;
    }
    let picture = format.map(|format| {
        let title = format!("{}, {:?}, arity {}", body.name, options.tree.splitter(), node.arity);
        picture::paint(&body.tree, &title, format)
    });
    let tree = options.output.as_deref().map(|path| (path, body.tree.as_bytes()));
    output::replace(tree.into_iter().chain(options.picture.as_deref().zip(picture.as_deref())))?;

    let (header, stats) = (*body.tree.view().header(), body.tree.view().stats());
    let milliseconds = body.build.unwrap_or_default().as_secs_f64() * 1e3;
    let caps = CapsReport::of(body.tree.view().cap_stats());
    let is_flat = options.tree.hull && header.is_solid == 0;
    let summary = format!(
        "{}: {} triangles, {} vertices in {}, {} nodes, {} bytes, {}{}{}built in {milliseconds:.1} ms",
        options.output.as_ref().unwrap_or(&options.mesh).display(),
        stats.primitives,
        header.vertex_count,
        body::vertex_format(&header),
        stats.nodes,
        stats.total_bytes,
        caps.map_or_else(String::new, |caps| format!("{caps}, ")),
        options
            .pack
            .map_or_else(String::new, |_| format!("{} spheres, ", body::packed_spheres(&body.tree.view()))),
        if is_flat { "a surface, since all points are in one plane, " } else { "" }
    );
    output::say(options.output.as_deref(), |out| writeln!(out, "{summary}"))
}

/// Fills a solid, after capping its holes, and adds the spheres to its tree.
fn add_packing(body: &mut Body, spheres: u32, cap: Option<f64>) -> Result<(), Error> {
    let mut mesh = body::mesh_of(&body.tree);
    if let Some(width) = cap {
        body::cap(&body.name, &mut mesh, width)?;
    }
    if body.tree.view().header().is_solid == 0 {
        return Err(Error::Option { option: "--pack", problem: "the mesh is not treated as a solid".into() });
    }
    let packing = pack::fill(&body.name, &mesh, spheres, false)?;
    body.tree = Builder::new()
        .add_packing_any(&body.tree, &packing.spheres)
        .map_err(|error| Error::Build { name: body.name.clone(), error })?;
    Ok(())
}
