//! Arrays from and to C: pointer, count and byte stride (0 = packed). They are checked before anything is read or
//! written, and elements are copied one by one, so neither alignment nor overlap matters.

use std::mem::size_of;

use relievo_core::{Error, Result};

/// A type whose every bit pattern is a value.
///
/// # Safety
/// The type has no padding and every bit pattern is a value of it.
pub unsafe trait Plain: Copy + Default {}

// SAFETY: integers and floats have no padding and no invalid patterns, and arrays of them neither.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u16 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for i32 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for f64 {}
// SAFETY: as above.
unsafe impl Plain for [f32; 2] {}
// SAFETY: as above.
unsafe impl Plain for [f32; 3] {}
// SAFETY: as above.
unsafe impl Plain for [f32; 4] {}
// SAFETY: as above.
unsafe impl Plain for [f32; 6] {}
// SAFETY: as above.
unsafe impl Plain for [f32; 12] {}
// SAFETY: as above.
unsafe impl Plain for [f64; 2] {}
// SAFETY: as above.
unsafe impl Plain for [f64; 3] {}
// SAFETY: as above.
unsafe impl Plain for [u32; 2] {}
// SAFETY: as above.
unsafe impl Plain for [u32; 3] {}
// SAFETY: as above.
unsafe impl Plain for [u32; 4] {}

/// A place that a host gives as doubles, for kernels. A number that no float holds becomes infinite, which they refuse.
pub fn narrow(place: [f64; 3]) -> [f32; 3] {
    place.map(|value| value as f32)
}

/// The stride in bytes of `count` elements of `size` bytes at `pointer`, or why they cannot exist.
fn check(name: &str, null: bool, count: usize, stride: usize, size: usize) -> Result<usize> {
    let stride = if stride == 0 { size } else { stride };
    if count == 0 {
        return Ok(stride);
    }
    if null {
        return Err(Error::invalid(format!("the pointer is NULL but the count is {count}")).at(name));
    }
    if stride < size {
        return Err(Error::invalid(format!("the stride of {stride} bytes is less than an element"))
            .at(name)
            .advise(format!("use 0 for packed elements, or at least {size}")));
    }
    match stride.checked_mul(count) {
        Some(bytes) if isize::try_from(bytes).is_ok() => Ok(stride),
        _ => Err(Error::invalid(format!("{count} elements of {stride} bytes exceed the address space")).at(name)),
    }
}

/// An array that C lends for reading.
#[derive(Clone, Copy)]
pub struct Input<T> {
    start: *const u8,
    count: usize,
    stride: usize,
    element: std::marker::PhantomData<T>,
}

impl<T: Plain> Input<T> {
    /// The array called `name` in messages.
    ///
    /// # Errors
    /// Fails with `Invalid` if `count` is not zero and the pointer is NULL, the stride is less than an element, or the
    /// elements exceed the address space.
    ///
    /// # Safety
    /// If `count` is not zero and `pointer` not NULL, `count` elements can be read at `stride` bytes from one another
    /// until the call ends.
    pub unsafe fn new(name: &str, pointer: *const T, count: usize, stride: usize) -> Result<Self> {
        let stride = check(name, pointer.is_null(), count, stride, size_of::<T>())?;
        Ok(Self { start: pointer.cast(), count, stride, element: std::marker::PhantomData })
    }

    /// As [`Input::new`], where NULL means that there is no array.
    ///
    /// # Errors
    /// Fails with `Invalid` if the stride is less than an element, or the elements exceed the address space.
    ///
    /// # Safety
    /// As for [`Input::new`].
    pub unsafe fn optional(name: &str, pointer: *const T, count: usize, stride: usize) -> Result<Option<Self>> {
        if pointer.is_null() {
            return Ok(None);
        }
        // SAFETY: promised by the caller.
        unsafe { Self::new(name, pointer, count, stride) }.map(Some)
    }

    /// How many elements there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether it has no element.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The elements.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        (0..self.count).map(|index| {
            // SAFETY: `new` was promised `count` readable elements and checked that their offsets do not overflow.
            unsafe { self.start.add(index * self.stride).cast::<T>().read_unaligned() }
        })
    }

    /// Element `index`, which is below the count.
    pub fn get(&self, index: usize) -> T {
        assert!(index < self.count);
        // SAFETY: as in `iter`.
        unsafe { self.start.add(index * self.stride).cast::<T>().read_unaligned() }
    }

    /// A copy of the elements.
    ///
    /// # Errors
    /// Fails with `Memory` if it takes more than `limit` bytes, or the machine does not have them.
    pub fn to_vec(&self, name: &str, limit: u64) -> Result<Vec<T>> {
        let mut copy = Vec::new();
        self.copy_to(name, limit, &mut copy)?;
        Ok(copy)
    }

    /// As [`Self::to_vec`], in place of what `copy` holds, whose room is used again.
    ///
    /// # Errors
    /// Fails with `Memory` if there is too little room in `copy`, and more takes over `limit` bytes or is not there.
    pub fn copy_to(&self, name: &str, limit: u64, copy: &mut Vec<T>) -> Result<()> {
        if copy.capacity() < self.count {
            *copy = reserve(name, self.count, limit)?;
        }
        copy.clear();
        copy.extend(self.iter());
        Ok(())
    }
}

/// The places of `count` structs called `name` in messages, which start with their size.
///
/// # Errors
/// Fails with `Invalid` if `count` is not zero and the pointer is NULL, the stride is less than a struct, or they
/// exceed the address space.
///
/// # Safety
/// If `count` is not zero and `pointer` not NULL, they can be read at `stride` bytes from one another until the call ends.
pub unsafe fn descriptors<T>(
    name: &str,
    pointer: *const T,
    count: usize,
    stride: usize,
) -> Result<impl ExactSizeIterator<Item = *const T>> {
    let stride = check(name, pointer.is_null(), count, stride, size_of::<T>())?;
    Ok((0..count).map(move |at| pointer.wrapping_byte_add(at * stride)))
}

/// An empty vector with room for `count` elements.
///
/// # Errors
/// Fails with `Memory` if it takes more than `limit` bytes, or the machine does not have them.
pub fn reserve<T>(name: &str, count: usize, limit: u64) -> Result<Vec<T>> {
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    let mut room = Vec::new();
    if bytes > limit || room.try_reserve_exact(count).is_err() {
        return Err(Error::memory(format!("{bytes} bytes are more than there is room for"))
            .at(name)
            .advise("raise the memory limit of the context or pass less"));
    }
    Ok(room)
}

/// An array that C lends for writing, or none.
#[derive(Clone, Copy)]
pub struct Output<T> {
    start: *mut u8,
    count: usize,
    stride: usize,
    element: std::marker::PhantomData<T>,
}

impl<T: Plain> Output<T> {
    /// The array called `name` in messages, with room for `count` elements.
    ///
    /// # Errors
    /// Fails with `Invalid` if `count` is not zero and the pointer is NULL, the stride is less than an element, or the
    /// elements exceed the address space.
    ///
    /// # Safety
    /// If `pointer` is not NULL, `count` elements can be written at `stride` bytes from one another until the call
    /// ends.
    pub unsafe fn new(name: &str, pointer: *mut T, count: usize, stride: usize) -> Result<Self> {
        let stride = check(name, pointer.is_null(), count, stride, size_of::<T>())?;
        Ok(Self { start: pointer.cast(), count, stride, element: std::marker::PhantomData })
    }

    /// As [`Output::new`], where NULL means that the array is not wanted.
    ///
    /// # Errors
    /// Fails with `Invalid` if the stride is less than an element, or the elements exceed the address space.
    ///
    /// # Safety
    /// As for [`Output::new`].
    pub unsafe fn optional(name: &str, pointer: *mut T, count: usize, stride: usize) -> Result<Option<Self>> {
        if pointer.is_null() {
            return Ok(None);
        }
        // SAFETY: promised by the caller.
        unsafe { Self::new(name, pointer, count, stride) }.map(Some)
    }

    /// Checks that there is room for `needed` elements.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is less.
    pub fn holds(self, name: &str, needed: usize) -> Result<Self> {
        if needed <= self.count {
            return Ok(self);
        }
        Err(Error::invalid(format!("there is room for {} elements, but there are {needed}", self.count))
            .at(name)
            .advise("ask for the count first and pass an array of that size"))
    }

    /// Writes element `index`; indices beyond the array are ignored.
    pub fn set(&self, index: usize, value: T) {
        if index < self.count {
            // SAFETY: `new` was promised `count` writable elements and checked that their offsets do not overflow.
            unsafe { self.start.add(index * self.stride).cast::<T>().write_unaligned(value) };
        }
    }

    /// Writes `values` from the first element on.
    pub fn fill(&self, values: impl IntoIterator<Item = T>) {
        for (index, value) in values.into_iter().enumerate().take(self.count) {
            self.set(index, value);
        }
    }
}

/// A host's array of rows of numbers of four bytes, into which a call writes.
pub struct Rows {
    first: Output<u32>,
    width: usize,
}

impl Rows {
    /// The array called `name` in messages with room for `count` rows of `width` numbers, which NULL says is not wanted.
    ///
    /// # Errors
    /// Fails with `Invalid` if the stride is less than a row, or the rows exceed the address space.
    ///
    /// # Safety
    /// If the pointer is not NULL, `count` rows can be written at `stride` bytes from one another until the call ends.
    pub unsafe fn optional(
        (name, pointer, count, stride): (&str, *mut u32, usize, usize),
        width: usize,
    ) -> Result<Option<Self>> {
        if pointer.is_null() {
            return Ok(None);
        }
        let stride = check(name, false, count, stride, 4 * width.max(1))?;
        let first = Output { start: pointer.cast(), count, stride, element: std::marker::PhantomData };
        Ok(Some(Self { first, width }))
    }

    /// Checks that there is room for `needed` rows.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is less.
    pub fn holds(&self, name: &str, needed: usize) -> Result<()> {
        self.first.holds(name, needed).map(drop)
    }

    /// Writes row `index`; indices beyond the array are ignored.
    pub fn set(&self, index: usize, values: impl Iterator<Item = u32>) {
        if index < self.first.count {
            for (column, value) in values.take(self.width).enumerate() {
                // SAFETY: `optional` was promised `count` writable rows of `width` numbers and checked that their offsets do
                // not overflow.
                unsafe {
                    self.first.start.add(index * self.first.stride + 4 * column).cast::<u32>().write_unaligned(value)
                };
            }
        }
    }
}

/// Writes one value through an output pointer that [`present`] has checked.
///
/// # Safety
/// `to` is a pointer to which a `T` may be written.
pub unsafe fn put<T>(to: *mut T, value: T) {
    // SAFETY: promised by the caller.
    unsafe { to.write_unaligned(value) };
}

/// Writes one value through an output pointer, where NULL says that it is not wanted.
///
/// # Safety
/// `to` is NULL or a pointer to which a `T` may be written.
pub unsafe fn put_optional<T>(to: *mut T, value: T) {
    if !to.is_null() {
        // SAFETY: promised by the caller.
        unsafe { put(to, value) };
    }
}

/// Checks that the output pointer called `name` is there; called before the work whose result goes there.
///
/// # Errors
/// Fails with `Invalid` if it is NULL.
pub fn present<T>(name: &str, pointer: *mut T) -> Result<()> {
    if pointer.is_null() {
        return Err(Error::invalid("the output pointer is NULL").at(name).advise("pass a place for the result"));
    }
    Ok(())
}

/// The text at `pointer`, which is called `name` in messages.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL or the text not UTF-8.
///
/// # Safety
/// `pointer` is NULL or points to a NUL-terminated string that lives until the call ends.
pub unsafe fn text<'a>(name: &str, pointer: *const std::ffi::c_char) -> Result<&'a str> {
    if pointer.is_null() {
        return Err(Error::invalid("the text is NULL").at(name));
    }
    // SAFETY: the caller promises a NUL-terminated string.
    let text = unsafe { std::ffi::CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Error::invalid("the text is not UTF-8").at(name))
}

/// As much of a text as C keeps in an array of `room` bytes: cut at a character boundary, so that NUL has room.
fn cut(text: &str, room: usize) -> &[u8] {
    let mut end = text.len().min(room - 1);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text.as_bytes()[..end]
}

/// A text as C keeps it in an array of `N` bytes: cut at a character boundary if it is too long, NUL-terminated.
pub fn fixed<const N: usize>(text: &str) -> [u8; N] {
    let text = cut(text, N);
    let mut bytes = [0; N];
    bytes[..text.len()].copy_from_slice(text);
    bytes
}

/// Writes a text and its NUL to an array, cut as by [`fixed`].
///
/// # Safety
/// `to` can be written to.
pub unsafe fn write_text<const N: usize>(to: *mut [u8; N], text: &str) {
    let text = cut(text, N);
    // SAFETY: the text and its NUL are no longer than the array, by the caller's promise.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr(), to.cast(), text.len());
        to.cast::<u8>().add(text.len()).write(0);
    }
}
