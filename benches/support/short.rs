//! Short runs, `cargo bench --bench NAME -- --test`: everything is executed and checked, on less, within
//! seconds. Their figures mean nothing.

/// Whether this is one. The flag is criterion's.
pub(crate) fn is_short() -> bool {
    std::env::args().any(|argument| argument == "--test")
}

/// A count of poses, passes and the like: `full`, or `short` in a short run.
pub(crate) fn count(full: usize, short: usize) -> usize {
    if is_short() { short } else { full }
}

/// Those of the named meshes that are measured: of a short run the first only.
pub(crate) fn some<'a>(models: &'a [&'static str]) -> &'a [&'static str] {
    &models[..count(models.len(), 1)]
}

/// Names every helper once, so that a bench which needs only some of them compiles without a warning.
const _: () = {
    let _ = (is_short, count, some);
};
