//! Documents and Ptex files as pictures; see `include/relievo/picture.h`.

use std::ffi::{CString, c_char, c_void};
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use relievo_bake::mosaic::{self, Meeting, Mosaic, Shown, Tesserae};
use relievo_core::{Error, ErrorKind, Result};
use relievo_document::Document;
use relievo_ptex::{BorderMode, DataType, MeshType, MetaValue, Reader};

use crate::border::array::{fixed, present, put, text};
use crate::border::descriptor::write_descriptor;
use crate::border::making::Making;
use crate::border::registry::{self, handle};
use crate::runtime::context::{ContextObject, RlvContext};

handle!(RlvPicture, 11, PictureObject);

constants! {
    u32:
    RLV_PICTURE_NAME_SIZE = 264,
    RLV_PICTURE_NONE = u32::MAX,
    RLV_PICTURE_DOCUMENT = 0,
    RLV_PICTURE_PTEX = 1,
    RLV_PICTURE_U8 = 0,
    RLV_PICTURE_U16 = 1,
    RLV_PICTURE_F16 = 2,
    RLV_PICTURE_F32 = 3,
    RLV_PICTURE_I32 = 4,
    RLV_PICTURE_F64 = 5,
    RLV_PICTURE_TEXT = 6,
    RLV_PICTURE_COLOR = 0,
    RLV_PICTURE_DISPLACEMENT = 1,
    RLV_PICTURE_VECTORS = 2,
    RLV_PICTURE_TRACES = 3,
    RLV_PICTURE_NUMBERS = 4,
}

descriptor! {
    pub struct RlvPictureInfo {
        struct_size: u32,
        format: u32,
        image_count: u32,
        face_count: u32,
        tile_count: u32,
        meta_count: u32,
    }
}

descriptor! {
    pub struct RlvPictureImage {
        struct_size: u32,
        content: u32,
        type_: u32,
        channels: u32,
        alpha: u32,
        width: u32,
        height: u32,
        level_count: u32,
        face: u32,
        columns: u32,
        cell: u32,
        side: u32,
        gutter: u32,
        is_layer: u32,
        blend: u32,
        is_visible: u32,
        opacity: f32,
        reserved: u32,
        name: [u8; RLV_PICTURE_NAME_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvPictureMeta {
        struct_size: u32,
        type_: u32,
        count: usize,
        name: *const c_char,
        values: *const c_void,
    }
}

/// A file with images. It never changes.
pub struct PictureObject {
    context: Arc<ContextObject>,
    path: String,
    file: File,
    meta: Vec<Meta>,
}

enum File {
    Document(Pages),
    Ptex(Reader<Vec<u8>>),
}

/// A document and what of it was read.
struct Pages {
    document: Document,
    meeting: Meeting,
    images: Vec<(Shown, OnceLock<Result<Mosaic>>)>,
}

/// Something that is said of the file.
struct Meta {
    name: CString,
    value: Value,
}

enum Value {
    Text(CString),
    I32(Vec<i32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Texts of C end at their first zero.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

impl Meta {
    fn new(name: &str, value: Value) -> Self {
        Self { name: c_text(name), value }
    }

    fn text(name: &str, text: &str) -> Self {
        Self::new(name, Value::Text(c_text(text)))
    }

    fn count(name: &str, count: usize) -> Self {
        Self::new(name, Value::I32(vec![i32::try_from(count).unwrap_or(i32::MAX)]))
    }

    fn of_document(document: &Document) -> Vec<Self> {
        let topology = document.topology();
        let mut all = vec![
            Self::text("writer", &document.writer),
            Self::count("version", document.version as usize),
            Self::count("faces", topology.face_count()),
            Self::count("corners", topology.corners().len()),
            Self::count("holes", topology.holes().len()),
            Self::count("tiles", mosaic::tile_count(document) as usize),
            Self::text("fingerprint", &format!("{:016x}", topology.fingerprint())),
            Self::text("surface", if topology.is_of_triangles() { "triangles" } else { "catmull-clark" }),
        ];
        all.extend(document.notes.iter().enumerate().map(|(index, note)| Self::text(&format!("note{index}"), note)));
        all
    }

    fn of_ptex<B: AsRef<[u8]>>(reader: &Reader<B>) -> Vec<Self> {
        let border = |mode: BorderMode| match mode {
            BorderMode::Clamp => "clamp",
            BorderMode::Black => "black",
            BorderMode::Periodic => "periodic",
        };
        let mesh = if reader.format().mesh == MeshType::Triangle { "triangle" } else { "quad" };
        let borders = reader.borders();
        let mut all = vec![
            Self::text("ptex:meshType", mesh),
            Self::text("wrapmodes", &format!("{},{}", border(borders.u), border(borders.v))),
        ];
        if reader.edit_count() > 0 {
            all.push(Self::count("ptex:hasEdits", 1));
        }
        all.extend(reader.meta().iter().map(|(name, value)| {
            Self::new(
                name,
                match value {
                    MetaValue::Text(text) => Value::Text(c_text(text)),
                    MetaValue::I8(values) => Value::I32(values.iter().map(|value| i32::from(*value)).collect()),
                    MetaValue::I16(values) => Value::I32(values.iter().map(|value| i32::from(*value)).collect()),
                    MetaValue::I32(values) => Value::I32(values.clone()),
                    MetaValue::F32(values) => Value::F32(values.clone()),
                    MetaValue::F64(values) => Value::F64(values.clone()),
                },
            )
        }));
        all
    }
}

/// The first bytes of a file.
fn magic(path: &str) -> Result<[u8; 8]> {
    let mut bytes = Vec::new();
    let mut file = std::fs::File::open(path).map_err(|error| {
        let kind = if error.kind() == std::io::ErrorKind::NotFound { ErrorKind::NotFound } else { ErrorKind::Io };
        Error::new(kind, format!("the file cannot be opened: {error}"))
    })?;
    (&mut file)
        .take(8)
        .read_to_end(&mut bytes)
        .map_err(|error| Error::new(ErrorKind::Io, format!("the file cannot be read: {error}")))?;
    bytes.resize(8, 0);
    bytes.try_into().map_err(|_| Error::internal("eight bytes are eight"))
}

impl PictureObject {
    fn open(context: Arc<ContextObject>, path: &str) -> Result<Self> {
        let limit = context.context.memory_limit();
        let magic = magic(path)?;
        let (file, meta) = if magic.starts_with(b"RLVDOC") {
            let document = Document::open(Path::new(path), limit)?;
            let images = mosaic::shown(&document)?.into_iter().map(|shown| (shown, OnceLock::new())).collect();
            let meeting = mosaic::meeting(&document)?;
            let meta = Meta::of_document(&document);
            (File::Document(Pages { document, meeting, images }), meta)
        } else if magic.starts_with(b"Ptex") {
            let reader = Reader::open(Path::new(path), limit)?;
            if reader.face_count() == 0 {
                return Err(Error::invalid("the file has no faces"));
            }
            let meta = Meta::of_ptex(&reader);
            (File::Ptex(reader), meta)
        } else {
            return Err(Error::unsupported("the file is neither a Relievo document nor Ptex"));
        };
        Ok(Self { context, path: path.to_string(), file, meta })
    }

    fn image_count(&self) -> u32 {
        match &self.file {
            File::Document(pages) => pages.images.len() as u32,
            File::Ptex(reader) => reader.face_count(),
        }
    }

    fn missing(&self, image: u32) -> Error {
        Error::new(ErrorKind::NotFound, format!("there is no image {image}"))
            .advise(format!("the picture has {}, counted from 0", self.image_count()))
    }

    fn image(&self, image: u32) -> Result<RlvPictureImage> {
        match &self.file {
            File::Document(pages) => {
                let (shown, _) = pages.images.get(image as usize).ok_or_else(|| self.missing(image))?;
                Ok(of_document(&pages.document, shown))
            }
            File::Ptex(reader) => of_ptex(reader, image),
        }
    }

    fn read(&self, image: u32, level: u32, columns: Range<u32>, rows: Range<u32>) -> Result<Vec<u8>> {
        match &self.file {
            File::Document(pages) => {
                let (shown, made) = pages.images.get(image as usize).ok_or_else(|| self.missing(image))?;
                let make = || Mosaic::new(&self.context.context, &pages.document, &pages.meeting, shown);
                made.get_or_init(make).as_ref().map_err(Clone::clone)?.read(level, columns, rows)
            }
            File::Ptex(reader) => read_ptex(reader, image, level, columns, rows),
        }
    }
}

fn of_document(document: &Document, shown: &Shown) -> RlvPictureImage {
    let (content, name) = match shown.kind {
        Tesserae::Colors => (RLV_PICTURE_COLOR, "color"),
        Tesserae::Heights => (RLV_PICTURE_DISPLACEMENT, "displacement"),
        Tesserae::Vectors => (RLV_PICTURE_VECTORS, "vectors"),
        Tesserae::Traces => (RLV_PICTURE_TRACES, "traces"),
    };
    let first = shown.layers.first().and_then(|index| document.layers().get(*index));
    let layer = first.filter(|_| shown.is_alone);
    let settings = layer.map(|layer| layer.settings());
    let [width, height] = shown.cells.size(0);
    let is_color = shown.kind == Tesserae::Colors;
    RlvPictureImage {
        struct_size: 0,
        content,
        type_: if is_color { RLV_PICTURE_F16 } else { RLV_PICTURE_F32 },
        channels: shown.kind.channels() as u32,
        alpha: if is_color { 3 } else { RLV_PICTURE_NONE },
        width,
        height,
        level_count: shown.cells.levels(),
        face: RLV_PICTURE_NONE,
        columns: shown.cells.columns,
        cell: shown.cells.cell(0),
        side: shown.cells.side,
        gutter: shown.cells.gutter(0),
        is_layer: u32::from(shown.is_alone),
        blend: settings.map_or(0, |settings| settings.blend as u32),
        is_visible: settings.map_or(1, |settings| u32::from(settings.visible)),
        opacity: settings.map_or(1.0, |settings| settings.opacity),
        reserved: 0,
        name: fixed(layer.map_or(name, |layer| layer.name())),
    }
}

fn of_ptex<B: AsRef<[u8]>>(reader: &Reader<B>, face: u32) -> Result<RlvPictureImage> {
    let (format, resolution) = (reader.format(), reader.face(face)?.resolution);
    Ok(RlvPictureImage {
        struct_size: 0,
        content: RLV_PICTURE_NUMBERS,
        type_: match format.data_type {
            DataType::U8 => RLV_PICTURE_U8,
            DataType::U16 => RLV_PICTURE_U16,
            DataType::F16 => RLV_PICTURE_F16,
            DataType::F32 => RLV_PICTURE_F32,
        },
        channels: u32::from(format.channels),
        alpha: format.alpha.map_or(RLV_PICTURE_NONE, u32::from),
        width: resolution.width() as u32,
        height: resolution.height() as u32,
        level_count: reader.reduction_count(face) as u32 + 1,
        face,
        columns: 0,
        cell: 0,
        side: 0,
        gutter: 0,
        is_layer: 0,
        blend: 0,
        is_visible: 1,
        opacity: 1.0,
        reserved: 0,
        name: fixed(&format!("face {face}")),
    })
}

fn read_ptex<B: AsRef<[u8]>>(
    reader: &Reader<B>,
    face: u32,
    level: u32,
    columns: Range<u32>,
    rows: Range<u32>,
) -> Result<Vec<u8>> {
    let (format, resolution) = (reader.format(), reader.face(face)?.resolution);
    let none = || Error::invalid(format!("there is no level {level}"));
    let halved = u8::try_from(level).ok().and_then(|times| resolution.halved(times)).ok_or_else(none)?;
    let (width, height) = (halved.width(), halved.height());
    if columns.end as usize > width || rows.end as usize > height {
        return Err(Error::invalid(format!("{columns:?} by {rows:?} is outside the picture"))
            .advise(format!("level {level} has {width} by {height} pixels")));
    }
    let mut texels = match level {
        0 => reader.texels(face)?,
        _ => reader.reduction(face, level as usize)?.ok_or_else(none)?,
    };
    if let (0, Some(alpha)) = (level, format.alpha) {
        // As reductions are.
        let mut numbers = format.data_type.decode(&texels);
        for texel in numbers.chunks_exact_mut(usize::from(format.channels)) {
            let share = texel[usize::from(alpha)];
            let colors = texel.iter_mut().enumerate().filter(|(channel, _)| *channel != usize::from(alpha));
            colors.for_each(|(_, number)| *number *= share);
        }
        texels = format.data_type.encode(&numbers);
    }
    let size = format.texel_size();
    let bytes = |row: u32| {
        let start = row as usize * width;
        (start + columns.start as usize) * size..(start + columns.end as usize) * size
    };
    let mut out = Vec::with_capacity(columns.len() * rows.len() * size);
    for row in rows {
        let damaged = || Error::invalid(format!("face {face} has too few texels"));
        out.extend_from_slice(texels.get(bytes(row)).ok_or_else(damaged)?);
    }
    Ok(out)
}

/// Reads which picture is opened.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file
/// that cannot be read, is damaged or neither a document nor Ptex, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn opening(context: RlvContext, path: *const c_char) -> Result<Making<RlvPicture>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = unsafe { text("path", path) }?.to_owned();
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let picture = PictureObject::open(context, &path).map_err(|error| error.at(path))?;
        progress.step(1.0, "read")?;
        registry::insert(picture)
    }))
}

entry! {
    fn rlv_picture_open(context: RlvContext, path: *const c_char, out: *mut RlvPicture) {
        present("out", out)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let handle = unsafe { opening(context, path) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_picture_retain(picture: RlvPicture) {
        registry::retain(picture)
    }

    fn rlv_picture_release(picture: RlvPicture) {
        registry::release(picture)
    }

    fn rlv_picture_info(picture: RlvPicture, out: *mut RlvPictureInfo) {
        let picture = registry::get(picture)?;
        let (format, face_count, tile_count) = match &picture.file {
            File::Document(pages) => {
                let faces = pages.document.topology().face_count() as u32;
                (RLV_PICTURE_DOCUMENT, faces, mosaic::tile_count(&pages.document))
            }
            File::Ptex(reader) => (RLV_PICTURE_PTEX, reader.face_count(), reader.face_count()),
        };
        let info = RlvPictureInfo {
            struct_size: 0,
            format,
            image_count: picture.image_count(),
            face_count,
            tile_count,
            meta_count: picture.meta.len() as u32,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_picture_image(picture: RlvPicture, image: u32, out: *mut RlvPictureImage) {
        let found = registry::get(picture)?.image(image)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, found) }
    }

    fn rlv_picture_meta(picture: RlvPicture, index: u32, out: *mut RlvPictureMeta) {
        let picture = registry::get(picture)?;
        let meta = picture.meta.get(index as usize).ok_or_else(|| {
            Error::new(ErrorKind::NotFound, format!("there is nothing at index {index}"))
                .advise(format!("the picture has {} of them, counted from 0", picture.meta.len()))
        })?;
        let (type_, count, values) = match &meta.value {
            Value::Text(text) => (RLV_PICTURE_TEXT, text.as_bytes().len(), text.as_ptr().cast()),
            Value::I32(values) => (RLV_PICTURE_I32, values.len(), values.as_ptr().cast()),
            Value::F32(values) => (RLV_PICTURE_F32, values.len(), values.as_ptr().cast()),
            Value::F64(values) => (RLV_PICTURE_F64, values.len(), values.as_ptr().cast()),
        };
        let found = RlvPictureMeta { struct_size: 0, type_, count, name: meta.name.as_ptr(), values };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, found) }
    }

    fn rlv_picture_read(
        picture: RlvPicture,
        image: u32,
        level: u32,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
        pixels: *mut c_void,
        row_stride: usize,
    ) {
        let picture = registry::get(picture)?;
        present("pixels", pixels)?;
        let info = picture.image(image)?;
        let number = match info.type_ {
            RLV_PICTURE_U8 => 1,
            RLV_PICTURE_F32 => 4,
            _ => 2,
        };
        let row = u64::from(width) * u64::from(info.channels) * number;
        let stride = if row_stride == 0 { row } else { row_stride as u64 };
        if stride < row || stride.saturating_mul(u64::from(height)) > isize::MAX as u64 {
            return Err(Error::invalid(format!("rows of {row} bytes cannot be {stride} bytes apart")).at("row_stride"));
        }
        let end = |first: u32, count: u32, what: &str| {
            first.checked_add(count).ok_or_else(|| Error::invalid("it is outside the picture").at(what))
        };
        let (columns, rows) = (x..end(x, width, "width")?, y..end(y, height, "height")?);
        if columns.end > info.width || rows.end > info.height {
            return Err(Error::invalid(format!("{columns:?} by {rows:?} is outside the picture"))
                .advise(format!("it has {} by {} pixels", info.width, info.height)));
        }
        if row * u64::from(height) > picture.context.context.memory_limit() {
            return Err(Error::memory(format!("{width} by {height} pixels do not fit the memory limit"))
                .advise("read fewer at a time"));
        }
        let bytes = picture.read(image, level, columns, rows).map_err(|error| error.at(&picture.path))?;
        if row > 0 {
            for (index, bytes) in bytes.chunks_exact(row as usize).enumerate() {
                // SAFETY: the caller gives `height` rows of `row` bytes, `stride` bytes apart.
                unsafe {
                    let to = pixels.cast::<u8>().add(index * stride as usize);
                    std::ptr::copy_nonoverlapping(bytes.as_ptr(), to, bytes.len());
                }
            }
        }
        Ok(())
    }
}
