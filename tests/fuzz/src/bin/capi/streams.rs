//! Crowds whose clusters are read while they are drawn: of a whole file, of one that ends early or is changed, and of none.

use std::ffi::CString;
use std::fs;
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use relievo_abi::context::RlvContext;
use relievo_abi::crowd::*;
use relievo_abi::crowd_stream::*;

use super::crowds::{MODEL, folder};
use super::{Handles, UNTOUCHED, called, count, made, sized};

/// The file of a model, and one that does not exist.
static FILES: LazyLock<[CString; 2]> = LazyLock::new(|| {
    let [path, none] = ["stream.rcrowd", "none.rcrowd"].map(|name| folder().join(name));
    fs::create_dir_all(folder()).and_then(|()| fs::write(&path, &*MODEL)).expect("a folder for files");
    [path, none].map(|path| CString::new(path.to_str().expect("a path")).expect("a path"))
});

/// Opens streams, and asks for what they read.
pub fn streams(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let damaged = folder().join("damaged.rcrowd");
    let mut paths = [bytes.choose(&FILES[..])?.as_ptr(), FILES[0].as_ptr()];
    let own = CString::new(damaged.to_str().expect("a path")).expect("a path");
    if bytes.ratio(1, 4)? {
        let mut changed = MODEL.clone();
        let at = bytes.int_in_range(0..=changed.len() - 1)?;
        changed[at] ^= bytes.arbitrary::<u8>()?;
        changed.truncate(if bytes.arbitrary()? { changed.len() } else { at });
        fs::write(&damaged, changed).expect("a folder for files");
        paths[0] = own.as_ptr();
    } else if bytes.ratio(1, 16)? {
        paths[0] = null();
    }
    let files = paths.map(|path| RlvCrowdStreamFile { path });
    let mut settings: RlvCrowdStreamSettings = sized(bytes)?;
    (settings.most_read, settings.budget) = (bytes.int_in_range(0..=9)?, bytes.int_in_range(0..=1 << 14)?);
    let given = if bytes.ratio(1, 8)? { null() } else { &raw const settings };
    let mut out = RlvCrowd { id: UNTOUCHED };
    // SAFETY: there are two files, texts end, and the descriptor is sized.
    let result = unsafe { rlv_crowd_stream_open(context, files.as_ptr(), count(bytes, 2)?, given, &mut out) };
    made(result, out.id, &mut handles.crowds);

    let crowd = RlvCrowd { id: handles.pick(bytes, 26)? };
    let mut info: RlvCrowdStreamInfo = sized(bytes)?;
    let mut model = RlvCrowdModel { id: UNTOUCHED };
    // SAFETY: the output is there, and the descriptor is sized.
    let result = unsafe { rlv_crowd_stream_model(crowd, bytes.int_in_range(0..=2)?, &mut model) };
    made(result, model.id, &mut handles.crowd_models);
    // SAFETY: the descriptor is sized.
    if !unsafe { called(rlv_crowd_stream_info(crowd, &mut info)) } {
        (info.read, info.slot_triangles, info.slot_count) = (4, 16, 4);
    }
    let read = (info.read as usize).min(1 << 10);
    let mut clusters = vec![RlvCrowdStreamCluster::default(); read];
    let room = count(bytes, (info.slot_triangles as usize).min(1 << 10))?;
    let (mut triangles, mut materials) = (vec![0_u32; 3 * room], vec![0_u32; room]);
    let slot = bytes.int_in_range(0..=info.slot_count)?;
    // SAFETY: arrays have the room that is said.
    unsafe {
        if called(rlv_crowd_stream_get_read(crowd, clusters.as_mut_ptr(), count(bytes, read)?, 0)) {
            assert!(clusters.iter().all(|it| it.slot < info.slot_count && it.triangle_count <= info.slot_triangles));
        }
        let materials = if bytes.arbitrary()? { materials.as_mut_ptr() } else { null_mut() };
        called(rlv_crowd_stream_get_triangles(crowd, slot, triangles.as_mut_ptr(), materials, room));
    }
    Ok(())
}
