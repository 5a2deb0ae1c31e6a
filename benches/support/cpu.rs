//! The processor, for pages of results.

/// The processor's name, and family and model, since one name can cover several kinds.
pub(crate) fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let of = |key: &str| {
        let line = info.lines().find(|line| line.starts_with(key));
        line.and_then(|line| line.split(": ").nth(1)).unwrap_or("unknown").to_owned()
    };
    format!("{} (family {}, model {})", of("model name"), of("cpu family"), of("model\t"))
}
