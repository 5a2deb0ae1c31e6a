//! Short runs, `cargo bench --bench NAME -- --test`: everything is executed and checked, on less data, within seconds.
//! Their figures mean nothing.

/// Whether this is a short run. The flag is criterion's.
pub(crate) fn is_short() -> bool {
    std::env::args().any(|argument| argument == "--test")
}

/// A number of poses, passes and the like: `full`, or `short` in a short run.
pub(crate) fn count(full: usize, short: usize) -> usize {
    if is_short() { short } else { full }
}

/// The named meshes to measure: in a short run only the first.
pub(crate) fn some<'a>(models: &'a [&'static str]) -> &'a [&'static str] {
    &models[..count(models.len(), 1)]
}

/// Names every helper once, so that a benchmark which uses only some of them compiles without a warning.
const _: () = {
    let _ = (is_short, count, some);
};
