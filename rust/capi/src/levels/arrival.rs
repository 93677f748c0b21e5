//! Progressive meshes that arrive piece by piece; see `include/relievo/arrival.h`.

use std::ffi::c_void;
use std::sync::{Arc, RwLock};

use relievo_core::{Error, ErrorKind};
use relievo_lod::progressive::Arrival;

use crate::border::array::{Input, present, put};
use crate::border::descriptor::{check_optional, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::levels::progressive::{self, RlvProgressive};
use crate::runtime::context::{ContextObject, RlvContext};

handle!(RlvArrival, 19, ArrivalObject);

descriptor! {
    pub struct RlvArrivalInfo {
        struct_size: u32,
        is_complete: u32,
        triangle_count: usize,
    }
}

pub struct ArrivalObject {
    context: Arc<ContextObject>,
    arrival: RwLock<Arrival>,
}

entry! {
    fn rlv_arrival_create(context: RlvContext, out: *mut RlvArrival) {
        present("out", out)?;
        let context = registry::get(context)?;
        let arrival = RwLock::new(Arrival::new(&context.context));
        let made = registry::insert(ArrivalObject { context, arrival })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_arrival_retain(arrival: RlvArrival) {
        registry::retain(arrival)
    }

    fn rlv_arrival_release(arrival: RlvArrival) {
        registry::release(arrival)
    }

    fn rlv_arrival_push(arrival: RlvArrival, bytes: *const c_void, byte_count: usize, out: *mut RlvArrivalInfo) {
        let object = registry::get(arrival)?;
        let context = &object.context.context;
        // SAFETY: the caller promises so many bytes, and NULL or a descriptor that starts with its size.
        let bytes = unsafe {
            check_optional(out)?;
            Input::new("bytes", bytes.cast::<u8>(), byte_count, 0)?
        };
        let bytes = bytes.to_vec("bytes", context.memory_limit())?;
        let mut arrival = try_write(&object.arrival, "arrival")?;
        let triangle_count = arrival.push(context, &bytes)?;
        let info = RlvArrivalInfo { struct_size: 0, is_complete: u32::from(arrival.is_complete()), triangle_count };
        // SAFETY: as above.
        unsafe { write_optional(out, info) }
    }

    fn rlv_arrival_progressive(arrival: RlvArrival, out: *mut RlvProgressive) {
        present("out", out)?;
        let object = registry::get(arrival)?;
        let nothing = || Error::new(ErrorKind::NotFound, "its base is not there").at("arrival").advise("push more");
        let mesh = try_read(&object.arrival, "arrival")?.mesh().cloned().ok_or_else(nothing)?;
        let made = progressive::register(object.context.clone(), mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
