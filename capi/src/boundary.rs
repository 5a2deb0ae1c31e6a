//! The boundary between C and Rust: checks pointers, stores failures, catches panics.

use crate::error::{Failure, simdop_error};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs the body of a C function and returns its error code.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> simdop_error {
    // A panic can leave only the objects behind the caller's handles in an inconsistent state; after it they may only
    // be destroyed.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => simdop_error::None,
        Ok(Err(failure)) => failure.keep(),
        Err(panic) => Failure::of_panic(panic.as_ref()).keep(),
    }
}

/// Runs the body of a C function that writes an answer.
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

/// Creates the object of a handle. The handle is NULL if that fails.
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

/// The target of a pointer, or an error if it is NULL.
pub(crate) fn given<T>(pointer: Option<T>, name: &str) -> Result<T, Failure> {
    pointer.ok_or_else(|| Failure::new(simdop_error::Null, format!("{name} is NULL")))
}

/// An array.
///
/// # Safety
/// Unless the pointer is NULL or misaligned, there are `count` items, which nobody writes during `'a`.
pub(crate) unsafe fn items<'a, T>(first: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    can_be_array(first, count, name)?;
    // SAFETY: the pointer is not NULL and aligned, and the length is not too large; the caller guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// An array to write to.
///
/// # Safety
/// Unless the pointer is NULL or misaligned, there is room for `count` items, which nobody else reads or writes during
/// `'a`.
pub(crate) unsafe fn places<'a, T>(
    first: *mut T,
    count: usize,
    name: &str,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    can_be_array(first, count, name)?;
    // SAFETY: as in `items`; the memory need not hold a valid `T` yet.
    Ok(unsafe { std::slice::from_raw_parts_mut(first.cast(), count) })
}

/// An array with a value in each place.
pub(crate) fn filled<T: Copy>(places: &mut [MaybeUninit<T>], value: T) -> &mut [T] {
    for place in places.iter_mut() {
        place.write(value);
    }
    // SAFETY: each place was written.
    unsafe { places.assume_init_mut() }
}

/// All items after conversion, or the error of the first invalid one.
pub(crate) fn checked<T, C>(
    items: &[T],
    name: &str,
    check: impl Fn(&T) -> Result<C, Failure>,
) -> Result<Vec<C>, Failure> {
    let check = |(i, item)| check(item).map_err(|failure| failure.of(&format!("{name} {i}")));
    items.iter().enumerate().map(check).collect()
}

fn can_be_array<T>(first: *const T, count: usize, name: &str) -> Result<(), Failure> {
    if first.is_null() {
        return given(None, name);
    }
    if !first.is_aligned() {
        let message = format!("{name} does not start at a multiple of {}", align_of::<T>());
        return Err(Failure::new(simdop_error::Misaligned, message));
    }
    // No Rust array is larger.
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
