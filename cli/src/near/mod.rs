//! `simdop near`.

mod body;
mod cloud;
mod histogram;
mod neighbours;
mod options;
mod timing;

pub(super) use options::Options;

use crate::error::Error;
use crate::output;

pub(super) fn run(options: &Options) -> Result<u8, Error> {
    output::check_targets(
        options.cloud.as_deref(),
        [("--output", options.output.as_deref()), ("--output", None)],
    )?;
    match &options.body {
        Some(given) => body::run(given, options),
        None => neighbours::run(options).map(|()| 0),
    }
}
