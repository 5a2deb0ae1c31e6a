//! Text for the page.

/// The name of a peer in the plots.
pub(super) fn letter(index: usize) -> String {
    char::from(b'a' + (index % 26) as u8).to_string()
}
