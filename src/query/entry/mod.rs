//! Common parts of all queries: settings, answers, and the tests of pairs of primitives.

mod answer;
mod hint;
mod pair;
mod primitive_pair;
mod query_stats;
mod settings;
mod tolerance;

pub use answer::{Answer, Completion, Verdict};
pub(super) use hint::Found;
pub use hint::Hint;
pub use pair::Pair;
pub use primitive_pair::PrimitivePair;
pub use query_stats::QueryStats;
pub use settings::Query;
pub use tolerance::ToleranceError;
pub(crate) use tolerance::checked;
