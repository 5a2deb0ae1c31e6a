//! What every function does where C and Rust meet: pointers are looked at, failures kept, panics caught.

use crate::error::{Failure, simdop_error};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Does the work of a function, and returns the code of what came of it.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> simdop_error {
    // What a panic leaves half done is behind the caller's handles, which may only be destroyed after it.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => simdop_error::None,
        Ok(Err(failure)) => failure.keep(),
        Err(panic) => Failure::of_panic(panic.as_ref()).keep(),
    }
}

/// Does the work of a function that leaves an answer.
pub(crate) fn answered<A>(
    answer: Option<&mut MaybeUninit<A>>,
    work: impl FnOnce() -> Result<A, Failure>,
) -> simdop_error {
    guarded(|| {
        let answer = given(answer, "answer")?;
        answer.write(work()?);
        Ok(())
    })
}

/// Makes what is behind a handle, which is NULL if that fails.
pub(crate) fn make<T>(
    handle: Option<&mut MaybeUninit<Option<Box<T>>>>,
    name: &str,
    work: impl FnOnce() -> Result<T, Failure>,
) -> simdop_error {
    guarded(|| {
        let handle = given(handle, name)?.write(None);
        *handle = Some(Box::new(work()?));
        Ok(())
    })
}

/// What a pointer leads to, unless it is NULL.
pub(crate) fn given<T>(pointer: Option<T>, name: &str) -> Result<T, Failure> {
    pointer.ok_or_else(|| Failure::new(simdop_error::Null, format!("{name} is NULL")))
}

/// An array.
///
/// # Safety
/// Unless the pointer is NULL or misaligned, there are `count` items, which nobody writes during `'a`.
pub(crate) unsafe fn items<'a, T>(first: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    can_be_array(first, count, name)?;
    // SAFETY: the pointer is not NULL and aligned, the length not too large; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// An array to be written.
///
/// # Safety
/// Unless the pointer is NULL or misaligned, there are `count` places, which nobody else reads or writes during `'a`.
pub(crate) unsafe fn places<'a, T>(
    first: *mut T,
    count: usize,
    name: &str,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    can_be_array(first, count, name)?;
    // SAFETY: as of `items`; what is there need not be a `T` yet.
    Ok(unsafe { std::slice::from_raw_parts_mut(first.cast(), count) })
}

fn can_be_array<T>(first: *const T, count: usize, name: &str) -> Result<(), Failure> {
    if first.is_null() {
        return given(None, name);
    }
    if !first.is_aligned() {
        let message = format!("{name} does not start at a multiple of {}", align_of::<T>());
        return Err(Failure::new(simdop_error::Misaligned, message));
    }
    // Rust has no larger ones.
    if count > isize::MAX.unsigned_abs() / size_of::<T>() {
        return Err(Failure::new(simdop_error::TooLarge, format!("{name}: {count} items are too many")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_code_with_its_message() {
        let code = guarded(|| panic!("vertex {} is missing", 7));
        assert_eq!(code, simdop_error::Panic);
        assert!(crate::error::last_error().contains("vertex 7 is missing"));
        assert_eq!(guarded(|| std::panic::panic_any(7)), simdop_error::Panic);
    }
}
