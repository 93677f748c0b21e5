//! Binds Embree to the TBB that it is linked to, where a host has another one under the same names.
//!
//! The dynamic linker looks for a name in the program and in what was opened for all names first, so a host that exports
//! oneTBB's functions answers Embree's calls of them, and the calls that TBB makes among its own functions, though both
//! are opened with local symbols. So the tables of these calls (System V ABI, "Procedure Linkage Table") are corrected
//! before the first of them.

use std::ffi::{CStr, c_char, c_void};

use libc::{Elf64_Ehdr, Elf64_Phdr, Elf64_Rela, Elf64_Sym};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

/// How the names of oneTBB's functions start.
const TBB: &[u8] = b"_ZN3tbb6detail";
/// One of them, by which its library is found.
const INITIALIZE: &CStr = c"_ZN3tbb6detail2r110initializeERNS0_2d115task_arena_baseE";
/// The type of a relocation of that table.
const JUMP: u64 = if cfg!(target_arch = "aarch64") { 1026 } else { 7 };

/// Tags of entries of a dynamic section.
const END: i64 = 0;
const TABLE_SIZE: i64 = 2;
const STRINGS: i64 = 5;
const SYMBOLS: i64 = 6;
const TABLE: i64 = 23;

/// The beginning of `link_map`.
#[repr(C)]
struct LinkMap {
    address: usize,
    name: *const c_char,
    dynamic: *const Dynamic,
    next: *const Self,
}

/// `Elf64_Dyn`.
#[repr(C)]
struct Dynamic {
    tag: i64,
    value: usize,
}

/// Opens `file` with local symbols. One that was not open before calls the TBB that it is linked to from now on.
pub fn open(file: &str) -> Result<Library, libloading::Error> {
    let flags = RTLD_NOW | RTLD_LOCAL;
    // SAFETY: a library that is open already runs nothing and is not changed.
    let is_open = unsafe { Library::open(Some(file), flags | libc::RTLD_NOLOAD) }.is_ok();
    // SAFETY: opening a library runs its initialisers; which library that is, is the user's choice.
    let library = unsafe { Library::open(Some(file), flags) }?;
    Ok(if is_open { library } else { to_own_tbb(library) })
}

/// Has a library that was just opened, and of which nothing was called yet, call the TBB that it is linked to.
fn to_own_tbb(library: Library) -> Library {
    let handle = library.into_raw();
    let mut map: *const LinkMap = std::ptr::null();
    // SAFETY: the handle is that of an open library, for which the linker returns its record.
    unsafe {
        if libc::dlinfo(handle, libc::RTLD_DI_LINKMAP, (&raw mut map).cast()) == 0 && !map.is_null() {
            correct_all(handle, map);
        }
        Library::from_raw(handle)
    }
}

/// Corrects the calls of the library of `handle`, and those of its TBB if that was opened together with it: it follows in the
/// linker's list then. One that the host had before is left as it is.
///
/// # Safety
/// `first` is the record of the library of `handle`, which is relocated.
unsafe fn correct_all(handle: *mut c_void, first: *const LinkMap) {
    // SAFETY: the list ends with a null pointer; libraries that are in it are relocated. `dlsym` looks in the library and in
    // what it is linked to, and in nothing else.
    unsafe {
        correct(handle, &*first);
        let function = libc::dlsym(handle, INITIALIZE.as_ptr());
        let mut tbb: libc::Dl_info = std::mem::zeroed();
        if function.is_null() || libc::dladdr(function, &mut tbb) == 0 {
            return;
        }
        let mut map = (*first).next;
        while !map.is_null() {
            if (*map).address == tbb.dli_fbase as usize {
                correct(handle, &*map);
            }
            map = (*map).next;
        }
    }
}

/// # Safety
/// `map` is the record of the library of `handle` or of one that it is linked to, which is relocated.
unsafe fn correct(handle: *mut c_void, map: &LinkMap) {
    let address = map.address;
    let value = |tag| {
        // SAFETY: a dynamic section ends with an entry of that tag.
        let entries = (0..).map(|k| unsafe { &*map.dynamic.add(k) }).take_while(|entry| entry.tag != END);
        entries.filter(|entry| entry.tag == tag).map(|entry| entry.value).next()
    };
    // glibc has added the address of the library to these already; other linkers have not.
    let place = |tag| value(tag).map(|value: usize| if value < address { address + value } else { value });
    let (Some(strings), Some(symbols), Some(table), Some(size)) =
        (place(STRINGS), place(SYMBOLS), place(TABLE), value(TABLE_SIZE))
    else {
        return;
    };
    for k in 0..size / size_of::<Elf64_Rela>() {
        // SAFETY: the dynamic section says where the tables are and how long this one is; symbols and names are looked up
        // by it as the linker does. `dlsym` looks in the library and in what it is linked to, and in nothing else.
        unsafe {
            let relocation = &*(table as *const Elf64_Rela).add(k);
            let symbol = &*(symbols as *const Elf64_Sym).add((relocation.r_info >> 32) as usize);
            let name = CStr::from_ptr((strings as *const c_char).add(symbol.st_name as usize));
            if relocation.r_info & 0xffff_ffff != JUMP || !name.to_bytes().starts_with(TBB) {
                continue;
            }
            let own = libc::dlsym(handle, name.as_ptr());
            let entry = (address + relocation.r_offset as usize) as *mut *mut c_void;
            if !own.is_null() && *entry != own {
                write(address, entry, own);
            }
        }
    }
}

/// Writes an entry, whose page the linker may have made read-only.
///
/// # Safety
/// `entry` is an entry of the table of the library at `address`, and nobody reads it at the same time.
unsafe fn write(address: usize, entry: *mut *mut c_void, own: *mut c_void) {
    // SAFETY: the library's headers are at its address; the page of the entry is its own.
    unsafe {
        let header = &*(address as *const Elf64_Ehdr);
        let length = libc::sysconf(libc::_SC_PAGESIZE) as usize;
        let parts = (address + header.e_phoff as usize) as *const Elf64_Phdr;
        let is_protected = (0..header.e_phnum as usize).map(|k| &*parts.add(k)).any(|part| {
            let start = address + part.p_vaddr as usize;
            // Of the last page the linker protects nothing, unless the part ends with it.
            let end = (start + part.p_memsz as usize) & !(length - 1);
            part.p_type == libc::PT_GNU_RELRO && (start..end).contains(&(entry as usize))
        });
        let page = (entry as usize & !(length - 1)) as *mut c_void;
        if is_protected && libc::mprotect(page, length, libc::PROT_READ | libc::PROT_WRITE) != 0 {
            return;
        }
        *entry = own;
        if is_protected {
            libc::mprotect(page, length, libc::PROT_READ);
        }
    }
}
