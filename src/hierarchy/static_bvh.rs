//! Trees in the program's read-only memory.

use super::layout::Layout;
use super::{BvhRef, FormatError};
use crate::node::Dop;
use crate::primitive::{Primitive, Triangles};
use core::marker::PhantomData;
use core::sync::atomic::{AtomicBool, Ordering};

/// Gives its content the alignment that [`BvhRef::from_bytes`] requires.
///
/// ```
/// use simdop::hierarchy::Aligned;
/// static TREE: Aligned<[u8; 4]> = Aligned(*b"tree");
/// assert_eq!(TREE.0.as_ptr() as usize % 64, 0);
/// ```
#[derive(Copy, Clone, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T: ?Sized>(pub T);

/// A tree in the program's read-only memory, such as a microcontroller's flash. [`include_tree!`](crate::include_tree)
/// makes one.
///
/// The compiler checked its header. The first call of [`StaticBvh::view`] validates its contents and stores the result:
/// later calls take a few instructions.
#[derive(Debug)]
pub struct StaticBvh<N, P = Triangles> {
    bytes: &'static [u8],
    layout: Layout,
    is_valid: AtomicBool,
    kind: PhantomData<(N, P)>,
}

impl<N: Dop, P: Primitive> StaticBvh<N, P> {
    /// A tree in bytes that are aligned to 64. In a constant, an invalid header is a compile error.
    ///
    /// # Panics
    /// If the bytes are not exactly one tree of this node type and these primitives.
    #[must_use]
    pub const fn new(bytes: &'static [u8]) -> Self {
        let layout = match Layout::of::<N, P>(bytes) {
            Ok(layout) => layout,
            Err(FormatError::NotATree) => panic!("the file is not a baked tree"),
            Err(FormatError::Version { .. }) => {
                panic!("the tree has a layout of another version: bake it anew")
            }
            Err(FormatError::OtherNode { .. }) => {
                panic!("the tree has another k or arity than the node type")
            }
            Err(FormatError::OtherPrimitive { .. }) => panic!("the tree has other primitives"),
            Err(FormatError::Truncated { .. }) => panic!("the tree's file ends early"),
            Err(FormatError::TooLong { .. }) => panic!("bytes follow after the end of the tree"),
            Err(_) => panic!("the tree has a bad header"),
        };
        Self { bytes, layout, is_valid: AtomicBool::new(false), kind: PhantomData }
    }

    /// Borrows the tree. The first call [validates](BvhRef::validate) it, in time linear in its size.
    ///
    /// # Errors
    /// [`FormatError`] if the contents are not safe to traverse, or the bytes are not aligned.
    pub fn view(&self) -> Result<BvhRef<'static, N, P>, FormatError> {
        // `Relaxed` suffices: the flag describes constant bytes, so no other memory has to be synchronised with it.
        if self.is_valid.load(Ordering::Relaxed) {
            return BvhRef::of_layout(self.bytes, &self.layout).ok_or(FormatError::Misaligned);
        }
        let view = BvhRef::from_bytes(self.bytes)?;
        self.is_valid.store(true, Ordering::Relaxed);
        Ok(view)
    }

    /// The baked bytes.
    #[must_use]
    pub const fn as_bytes(&self) -> &'static [u8] {
        self.bytes
    }
}

/// A [`StaticBvh`] from a file: aligned, with its header checked by the compiler. The path is relative to the source
/// file, as for [`include_bytes!`]; `concat!` and `env!` can make an absolute one.
///
/// ```ignore
/// static HAND: StaticBvh<Node16<18>> = include_tree!("hand.simdop");
/// let hand = HAND.view()?; // validated once
/// ```
#[macro_export]
macro_rules! include_tree {
    ($path:expr $(,)?) => {{
        const SIZE: usize = include_bytes!($path).len();
        static BYTES: $crate::hierarchy::Aligned<[u8; SIZE]> =
            $crate::hierarchy::Aligned(*include_bytes!($path));
        $crate::hierarchy::StaticBvh::new(&BYTES.0)
    }};
}
