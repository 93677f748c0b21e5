//! What every function of the ABI keeps to: errors at the border, handles, descriptors, arrays and texts.

use std::ffi::CStr;
use std::sync::RwLock;

use relievo::border::array::{Input, fixed, write_text};
use relievo::border::descriptor::{Descriptor, read_descriptor, write_descriptor};
use relievo::border::enter;
use relievo::border::registry::{Handle, get, insert, release, retain, try_read, try_write};
use relievo::error::{RLV_ERROR_INTERNAL, RLV_ERROR_INVALID, RLV_OK, rlv_error_last};
use relievo::version::{RLV_VERSION_MAJOR, RLV_VERSION_MINOR, RLV_VERSION_PATCH};
use relievo_core::{Error, ErrorKind};
use relievo_detail::{Falloff, PaintMode, SculptMode};
use relievo_document::Blend;

fn last_message() -> String {
    // SAFETY: the text lives until this thread's next failure.
    unsafe { CStr::from_ptr(rlv_error_last()) }.to_string_lossy().into_owned()
}

#[test]
fn the_version_is_the_package_version() {
    let package = format!("{RLV_VERSION_MAJOR}.{RLV_VERSION_MINOR}.{RLV_VERSION_PATCH}");
    assert_eq!(package, env!("CARGO_PKG_VERSION"));
}

#[test]
fn a_panic_becomes_an_internal_error() {
    assert_eq!(enter("rlv_test", || panic!("slot {}", 7)), RLV_ERROR_INTERNAL);
    assert!(last_message().starts_with("rlv_test: "));
    assert!(last_message().contains("slot 7"));
}

#[test]
fn an_error_keeps_its_place_and_success_keeps_the_last_error() {
    let result = enter("rlv_test", || Err(Error::invalid("it is bent").at("point 3").advise("straighten it")));
    assert_eq!(result, RLV_ERROR_INVALID);
    assert_eq!(enter("rlv_test", || Ok(())), RLV_OK);
    assert_eq!(last_message(), "rlv_test: point 3: it is bent; straighten it");
}

#[test]
fn texts_are_cut_between_characters() {
    for (text, kept) in [("", ""), ("aéb", "aéb"), ("abcdé", "abcd"), ("abcdefg", "abcde")] {
        let mut written = [7u8; 6];
        // SAFETY: it is an array.
        unsafe { write_text(&mut written, text) };
        let kept = kept.as_bytes();
        assert_eq!((&written[..kept.len()], written[kept.len()]), (kept, 0));
        assert!(written[kept.len() + 1..].iter().all(|byte| *byte == 7), "bytes behind the end stay");
        assert_eq!(fixed::<6>(text)[..=kept.len()], written[..=kept.len()]);
    }
}

#[test]
fn strides_and_counts_are_checked() {
    let data = [1_u32, 2, 3, 4];
    // SAFETY: `data` holds two elements 8 bytes apart.
    let every_other = unsafe { Input::new("ids", data.as_ptr(), 2, 8) }.unwrap();
    assert_eq!(every_other.to_vec("ids", 1 << 10).unwrap(), [1, 3]);
    assert!(every_other.to_vec("ids", 7).is_err());
    for (count, stride) in [(1, 3), (usize::MAX, 4), (usize::MAX / 2, 0), (2, usize::MAX)] {
        // SAFETY: refused before anything is read.
        assert!(unsafe { Input::new("ids", data.as_ptr(), count, stride) }.is_err());
    }
    // SAFETY: NULL is refused, or allowed for no elements.
    unsafe {
        assert!(Input::<u32>::new("ids", std::ptr::null(), 1, 0).is_err());
        assert!(Input::<u32>::new("ids", std::ptr::null(), 0, 0).unwrap().is_empty());
    }
}

#[test]
fn texts_are_cut_at_characters() {
    assert_eq!(&fixed::<4>("ab"), b"ab\0\0");
    assert_eq!(&fixed::<4>("abcd"), b"abc\0");
    assert_eq!(&fixed::<4>("abé"), b"ab\0\0");
}

/// Defines the handle type of a noun.
macro_rules! handle {
    ($name:ident, $tag:literal, $object:ty) => {
        #[derive(Clone, Copy, Debug)]
        struct $name {
            id: u64,
        }

        impl Handle for $name {
            const TAG: u8 = $tag;
            type Object = $object;
            fn id(self) -> u64 {
                self.id
            }
            fn of(id: u64) -> Self {
                Self { id }
            }
        }
    };
}

handle!(Apple, 1, u32);
handle!(Pear, 2, String);

#[test]
fn null_dead_foreign_and_forged_handles_are_refused() {
    let apple: Apple = insert(5).unwrap();
    assert_eq!(*get(apple).unwrap(), 5);
    assert!(get(Apple { id: 0 }).is_err());
    assert!(get(Pear { id: apple.id }).unwrap_err().to_string().contains("of a context"));
    assert!(get(Pear { id: apple.id & !(0xff << 56) | 2 << 56 }).is_err());
    assert!(get(Apple { id: apple.id + (1 << 32) }).is_err());
    assert!(get(Apple { id: apple.id | 0xffff_ffff }).is_err());
    retain(apple).unwrap();
    release(apple).unwrap();
    assert_eq!(*get(apple).unwrap(), 5);
    release(apple).unwrap();
    assert!(get(apple).unwrap_err().to_string().contains("not alive"));
    assert!(release(apple).is_err());
    let next: Pear = insert("b".to_string()).unwrap();
    assert_ne!(next.id, apple.id);
    assert!(get(apple).is_err());
    release(next).unwrap();
}

#[test]
fn locks_do_not_wait() {
    let lock = RwLock::new(1);
    let first = try_read(&lock, "mesh").unwrap();
    let second = try_read(&lock, "mesh").unwrap();
    assert_eq!(try_write(&lock, "mesh").unwrap_err().kind, ErrorKind::Busy);
    drop((first, second));
    let alone = try_write(&lock, "mesh").unwrap();
    assert_eq!(try_read(&lock, "mesh").unwrap_err().kind, ErrorKind::Busy);
    drop(alone);
}

/// Two or three numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct Small {
    struct_size: u32,
    a: u32,
}

// SAFETY: it begins with a `u32` and has fields of plain numbers only.
unsafe impl Descriptor for Small {
    const NAME: &'static str = "Small";
    const FIRST_SIZE: usize = size_of::<Small>();
}

/// Two or three numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct Wide {
    struct_size: u32,
    a: u32,
    b: u32,
}

// SAFETY: it begins with a `u32` and has fields of plain numbers only.
unsafe impl Descriptor for Wide {
    const NAME: &'static str = "Wide";
    const FIRST_SIZE: usize = size_of::<Wide>();
}

#[test]
fn sizes_are_understood_in_both_directions() {
    let default = Small { struct_size: 8, a: 7 };
    let newer = Wide { struct_size: 12, a: 1, b: 0 };
    // SAFETY: `newer` has the 12 bytes it declares.
    let read = unsafe { read_descriptor((&raw const newer).cast::<Small>(), default) }.unwrap();
    assert_eq!(read.a, 1);
    let used = Wide { b: 5, ..newer };
    // SAFETY: as above.
    let error = unsafe { read_descriptor((&raw const used).cast::<Small>(), default) }.unwrap_err();
    assert_eq!(error.kind, ErrorKind::Unsupported);
    let short = Small { struct_size: 3, a: 1 };
    // SAFETY: `short` has more bytes than it declares.
    assert!(unsafe { read_descriptor(&raw const short, default) }.is_err());
    // SAFETY: NULL is allowed.
    assert!(unsafe { read_descriptor(std::ptr::null(), default) }.is_err());
}

#[test]
fn writing_keeps_the_size_and_what_lies_beyond() {
    let mut out = Wide { struct_size: 8, a: 0, b: 9 };
    let value = Small { struct_size: 0, a: 4 };
    // SAFETY: `out` has the 8 bytes it declares.
    unsafe { write_descriptor((&raw mut out).cast::<Small>(), value) }.unwrap();
    assert_eq!((out.struct_size, out.a, out.b), (8, 4, 9));
}

#[test]
fn numbers_of_modes_and_falloffs_are_those_of_their_names() {
    let lists: [(&str, Vec<&str>); 3] = [
        ("RLV_PAINT_", PaintMode::NAMES.iter().map(|(_, name)| *name).collect()),
        ("RLV_SCULPT_", SculptMode::NAMES.iter().map(|(_, name)| *name).collect()),
        ("RLV_FALLOFF_", Falloff::NAMES.iter().map(|(_, name)| *name).collect()),
    ];
    for (prefix, names) in lists {
        let of_c: Vec<String> = relievo::brush::CONSTANTS
            .iter()
            .filter_map(|(name, value)| Some((value, name.strip_prefix(prefix)?.to_lowercase())))
            .enumerate()
            .map(|(index, (value, name))| {
                assert_eq!(index as i64, *value);
                name
            })
            .collect();
        assert_eq!(of_c, names, "{prefix}");
    }
}

#[test]
fn numbers_of_blend_modes_are_those_of_documents() {
    let names =
        relievo::layer::CONSTANTS.iter().filter_map(|(name, value)| Some((*value, name.strip_prefix("RLV_BLEND_")?)));
    let of_c: Vec<(i64, String)> = names.map(|(value, name)| (value, name.to_lowercase())).collect();
    let expected: Vec<(i64, String)> = (0..).zip(Blend::NAMES.map(|(_, name)| name.to_string())).collect();
    assert_eq!(of_c, expected);
}
