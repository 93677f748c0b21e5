//! Where texels are: heaps under a byte budget, pages of references, and blocks as histories and documents see them.

pub mod blocks;
pub mod heap;
pub(crate) mod pages;
pub mod paging;
pub mod sets;
pub(crate) mod slot;
pub(crate) mod spare;
pub mod stored;
