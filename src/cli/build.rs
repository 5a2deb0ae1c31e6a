//! `simdop build`.

use super::body;
use super::error::Error;
use super::picture;
use super::{File, TreeOptions};
use clap::Args;
use std::io::Write;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The mesh, or a tree: then the mesh that it was built from.
    mesh: File,
    /// The tree to write.
    #[arg(short, long, required_unless_present = "picture")]
    output: Option<File>,
    /// An SVG image to write: the mesh, coloured by the child of the root that each triangle is below.
    #[arg(long, value_name = "FILE")]
    picture: Option<File>,
    #[command(flatten)]
    tree: TreeOptions,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let mesh = body::read(&options.mesh, &options.tree, false)?.into_mesh();
    let name = options.mesh.display().to_string();
    let shape = body::shape(&options.tree, None);
    let body = body::build(name, &mesh, &options.tree, shape, false)?;
    if let Some(path) = &options.output {
        std::fs::write(path, body.tree.as_bytes()).map_err(Error::io(path))?;
    }
    if let Some(path) = &options.picture {
        let title = format!("{}, {:?}, arity {}", body.name, options.tree.splitter, shape.arity);
        std::fs::write(path, picture::svg(&body.tree, &title)).map_err(Error::io(path))?;
    }
    let stats = body.tree.stats();
    let milliseconds = body.build.unwrap_or_default().as_secs_f64() * 1e3;
    writeln!(
        std::io::stdout(),
        "{}: {} triangles, {} nodes, {} bytes, built in {milliseconds:.1} ms",
        options.output.as_ref().unwrap_or(&options.mesh).display(),
        stats.triangles,
        stats.nodes,
        stats.total_bytes
    )
    .map_err(Error::Output)
}
