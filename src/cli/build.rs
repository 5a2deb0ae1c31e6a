//! `simdop build`.

use super::body;
use super::error::Error;
use super::{File, TreeOptions};
use clap::Args;
use std::io::Write;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The mesh, or a tree: then the mesh that it was built from.
    mesh: File,
    /// The tree to write.
    #[arg(short, long)]
    output: File,
    #[command(flatten)]
    tree: TreeOptions,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let mesh = body::read(&options.mesh, false)?.into_mesh();
    let name = options.mesh.display().to_string();
    let body = body::build(name, &mesh, &options.tree, body::shape(&options.tree, None), false)?;
    std::fs::write(&options.output, body.tree.as_bytes()).map_err(Error::io(&options.output))?;
    let stats = body.tree.stats();
    let milliseconds = body.build.unwrap_or_default().as_secs_f64() * 1e3;
    writeln!(
        std::io::stdout(),
        "{}: {} triangles, {} nodes, {} bytes, built in {milliseconds:.1} ms",
        options.output.display(),
        stats.triangles,
        stats.nodes,
        stats.total_bytes
    )
    .map_err(Error::Output)
}
