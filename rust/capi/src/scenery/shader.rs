//! Exploration of shaders by feature vectors; see `include/relievo/shader.h`.

use std::ffi::c_char;

use relievo_core::{Error, ErrorKind, Result};
use relievo_shaderlab::annotation::MAX_FEATURES;
use relievo_shaderlab::instrument::{EXAMPLES_HEAD, LOG_HEAD};
use relievo_shaderlab::{
    Accumulation, Augmented, Class, Classes, Declared, Example, Language, Log, MAX_EXAMPLES, Mode, Shader, Source,
    Stage, Variable, membership,
};

use crate::border::array::{Input, Output, fixed, present, put, put_optional, text};
use crate::border::descriptor::{numbered, read_descriptor, read_optional, write_descriptor};
use crate::border::registry::{self, handle};
use crate::runtime::context::{RLV_NAME_SIZE, RLV_TEXT_SIZE};

handle!(RlvShader, 27, ShaderObject);

constants! {
    u32:
    RLV_SHADER_GLSL = 0,
    RLV_SHADER_WGSL = 1,
    RLV_SHADER_VERTEX = 0,
    RLV_SHADER_FRAGMENT = 1,
    RLV_SHADER_COMPUTE = 2,
    RLV_SHADER_MARKED = 0,
    RLV_SHADER_AUGMENTED = 1,
    RLV_SHADER_AUGMENTED_WGSL = 2,
    RLV_SHADER_GLOBAL = 0,
    RLV_SHADER_PARAMETER = 1,
    RLV_SHADER_LOCAL = 2,
    RLV_SHADER_AVERAGE = 0,
    RLV_SHADER_SUM = 1,
    RLV_SHADER_MIN = 2,
    RLV_SHADER_MAX = 3,
    RLV_SHADER_FIRST = 4,
    RLV_SHADER_LAST = 5,
    RLV_SHADER_NEGATIVE = 0,
    RLV_SHADER_POSITIVE = 1,
    RLV_SHADER_RENDER = 0,
    RLV_SHADER_CLASSIFY = 1,
    RLV_SHADER_MASK = 2,
    RLV_SHADER_CLASSIFY_VERTEX = 3,
    RLV_SHADER_VERTICES = 4,
}

descriptor! {
    pub struct RlvShaderOptions {
        struct_size: u32,
        language: u32,
        stage: u32,
        reserved: u32,
        name: *const c_char,
    }
}

descriptor! {
    pub struct RlvShaderVariable {
        struct_size: u32,
        components: u32,
        declared: u32,
        is_initialized: u32,
        line: u32,
        column: u32,
        scope_start: u64,
        scope_end: u64,
        name: [u8; RLV_NAME_SIZE as usize],
        label: [u8; RLV_NAME_SIZE as usize],
        function: [u8; RLV_NAME_SIZE as usize],
        description: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvShaderLayout {
        struct_size: u32,
        group: u32,
        examples_binding: u32,
        log_binding: u32,
        feature_count: u32,
        accumulation: u32,
        site_count: u32,
        uses_confidence: u32,
        examples_head: u32,
        log_head: u32,
    }
}

descriptor! {
    pub struct RlvShaderFeature {
        struct_size: u32,
        reserved: u32,
        name: [u8; RLV_TEXT_SIZE as usize],
        expression: [u8; RLV_TEXT_SIZE as usize],
        description: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvShaderExamples {
        struct_size: u32,
        feature_count: u32,
        count: usize,
        classes: *const u32,
        class_stride: usize,
        vectors: *const f32,
        vector_stride: usize,
        exponent: f32,
        is_scaled: u32,
    }
}

const LANGUAGES: &[(Language, &str)] = &[(Language::Glsl, "glsl"), (Language::Wgsl, "wgsl")];

const STAGES: &[(Stage, &str)] =
    &[(Stage::Vertex, "vertex"), (Stage::Fragment, "fragment"), (Stage::Compute, "compute")];

const CLASSES: &[(Class, &str)] = &[(Class::Negative, "negative"), (Class::Positive, "positive")];

/// A shader, with its augmentation if it takes vectors.
pub struct ShaderObject {
    shader: Shader,
    variables: Vec<Variable>,
    augmented: Option<Augmented>,
}

impl ShaderObject {
    fn new(source: Source) -> Result<Self> {
        let shader = Shader::new(source)?;
        let augmented = if shader.is_marked() { Some(shader.augment()?) } else { None };
        Ok(Self { variables: shader.variables(), shader, augmented })
    }

    fn augmented(&self) -> Result<&Augmented> {
        self.augmented.as_ref().ok_or_else(|| {
            Error::invalid("the shader takes no vector")
                .at("shader")
                .advise("mark variables with rlv_shader_mark, or write an annotation into its text")
        })
    }
}

/// Returns element `index` of a list whose elements are called `noun`.
fn element<'a, T>(noun: &str, list: &'a [T], index: usize) -> Result<&'a T> {
    list.get(index).ok_or_else(|| {
        let advice = format!("there are {}", list.len());
        Error::new(ErrorKind::NotFound, format!("{noun} {index} does not exist")).at("index").advise(advice)
    })
}

/// Returns the columns of `count` vectors at `stride` bytes from one another, one for each of the features.
///
/// # Safety
/// If `count` is not zero and `pointer` not NULL, so many vectors can be read until the call ends.
unsafe fn columns(pointer: *const f32, count: usize, features: usize, stride: usize) -> Result<Vec<Input<f32>>> {
    let row = size_of::<f32>() * features;
    let stride = if stride == 0 { row } else { stride };
    if stride < row {
        return Err(Error::invalid(format!("the stride of {stride} bytes is less than a vector"))
            .at("vectors")
            .advise(format!("use 0 for packed vectors, or at least {row}")));
    }
    let start = |feature| if pointer.is_null() { pointer } else { pointer.wrapping_add(feature) };
    // SAFETY: the caller promises `count` vectors, and a stride is at least as long as one.
    (0..features).map(|feature| unsafe { Input::new("vectors", start(feature), count, stride) }).collect()
}

/// Reads examples.
///
/// # Safety
/// `from` is NULL or a descriptor that starts with its size, with classes and vectors of its count.
unsafe fn read_examples(from: *const RlvShaderExamples) -> Result<Classes> {
    let default = RlvShaderExamples {
        struct_size: 0,
        feature_count: 0,
        count: 0,
        classes: std::ptr::null(),
        class_stride: 0,
        vectors: std::ptr::null(),
        vector_stride: 0,
        exponent: relievo_shaderlab::EXPONENT,
        is_scaled: 0,
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(from, default) }?;
    let features = given.feature_count as usize;
    if !(1..=MAX_FEATURES).contains(&features) {
        return Err(Error::invalid(format!("the vectors have {features} features"))
            .at("feature_count")
            .advise(format!("use 1 to {MAX_FEATURES}")));
    }
    if given.count > MAX_EXAMPLES {
        return Err(Error::invalid(format!("there are {} examples", given.count))
            .at("count")
            .advise(format!("use at most {MAX_EXAMPLES}")));
    }
    // SAFETY: promised by the caller.
    let (kinds, columns) = unsafe {
        (
            Input::new("classes", given.classes, given.count, given.class_stride)?,
            columns(given.vectors, given.count, features, given.vector_stride)?,
        )
    };
    let mut classes = Classes::new(vec![String::new(); features]);
    (classes.exponent, classes.is_scaled) = (given.exponent, given.is_scaled != 0);
    for index in 0..given.count {
        let class = numbered("class", CLASSES, kinds.get(index)).map_err(|error| error.at("classes"))?;
        let vector = columns.iter().map(|column| column.get(index)).collect();
        classes.examples.push(Example { pixel: [0, 0], class, vector });
    }
    classes.check()?;
    Ok(classes)
}

/// Registers a shader.
fn register(source: Source) -> Result<RlvShader> {
    registry::insert(ShaderObject::new(source)?)
}

entry! {
    fn rlv_shader_create(source: *const c_char, options: *const RlvShaderOptions, out: *mut RlvShader) {
        present("out", out)?;
        let default = RlvShaderOptions {
            struct_size: 0,
            language: RLV_SHADER_GLSL,
            stage: RLV_SHADER_FRAGMENT,
            reserved: 0,
            name: std::ptr::null(),
        };
        // SAFETY: the caller gives NULL or a NUL-terminated text, and NULL or a descriptor that starts with its size.
        let (source, given) = unsafe { (text("source", source)?, read_optional(options, default)?) };
        let language = numbered("language", LANGUAGES, given.language)?;
        let stage = numbered("stage", STAGES, given.stage)?;
        let name = match given.name.is_null() {
            true => "shader",
            // SAFETY: the caller gives a NUL-terminated text.
            false => unsafe { text("name", given.name) }?,
        };
        let made = register(Source::new(name, source, language, stage))?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_shader_retain(shader: RlvShader) {
        registry::retain(shader)
    }

    fn rlv_shader_release(shader: RlvShader) {
        registry::release(shader)
    }

    fn rlv_shader_variable_count(shader: RlvShader, out: *mut usize) {
        present("out", out)?;
        let object = registry::get(shader)?;
        // SAFETY: checked above.
        unsafe { put(out, object.variables.len()) };
        Ok(())
    }

    fn rlv_shader_variable(shader: RlvShader, index: usize, out: *mut RlvShaderVariable) {
        let object = registry::get(shader)?;
        let variable = element("variable", &object.variables, index)?;
        let (line, column) = object.shader.source().place(&variable.place);
        let optional = |text: &Option<String>| fixed(text.as_deref().unwrap_or_default());
        let made = RlvShaderVariable {
            struct_size: 0,
            components: variable.components,
            declared: match variable.declared {
                Declared::Global => RLV_SHADER_GLOBAL,
                Declared::Parameter => RLV_SHADER_PARAMETER,
                Declared::Local => RLV_SHADER_LOCAL,
            },
            is_initialized: u32::from(variable.is_initialized),
            line: line as u32,
            column: column as u32,
            scope_start: variable.scope.start as u64,
            scope_end: variable.scope.end as u64,
            name: fixed(&variable.name),
            label: optional(&variable.label),
            function: optional(&variable.function),
            description: fixed(variable.description.as_deref().unwrap_or_default()),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_shader_mark(
        shader: RlvShader,
        variables: *const u32,
        count: usize,
        weight: *const c_char,
        out: *mut RlvShader,
    ) {
        present("out", out)?;
        let object = registry::get(shader)?;
        if count > MAX_FEATURES {
            return Err(Error::invalid(format!("{count} variables are chosen"))
                .at("variables")
                .advise(format!("choose at most {MAX_FEATURES}")));
        }
        // SAFETY: the caller gives `count` numbers, and a NUL-terminated text or NULL.
        let (chosen, weight) = unsafe {
            let weight = if weight.is_null() { "1.0" } else { text("weight", weight)? };
            (Input::new("variables", variables, count, 0)?, weight)
        };
        let chosen: Vec<usize> = chosen.iter().map(|index| index as usize).collect();
        let source = object.shader.source();
        let marked = object.shader.with_vector(&chosen, weight)?;
        let made = register(Source::new(source.name.clone(), marked, source.language, source.stage))?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_shader_text(shader: RlvShader, kind: u32, text: *mut c_char, size: usize, length: *mut usize) {
        present("length", length)?;
        let object = registry::get(shader)?;
        let translated;
        let found = match kind {
            RLV_SHADER_MARKED => &*object.shader.source().text,
            RLV_SHADER_AUGMENTED => &*object.augmented()?.text,
            RLV_SHADER_AUGMENTED_WGSL => {
                translated = object.augmented()?.wgsl(&object.shader)?;
                &*translated
            }
            _ => {
                return Err(Error::invalid(format!("there is no text {kind}"))
                    .at("kind")
                    .advise("use a value of RlvShaderText"));
            }
        };
        // SAFETY: the caller gives room for `size` bytes, or NULL to ask for the length alone.
        if let Some(out) = unsafe { Output::<u8>::optional("text", text.cast(), size, 0) }? {
            out.holds("text", found.len() + 1)?.fill(found.bytes().chain([0]));
        }
        // SAFETY: checked above.
        unsafe { put(length, found.len()) };
        Ok(())
    }

    fn rlv_shader_layout(shader: RlvShader, out: *mut RlvShaderLayout) {
        let object = registry::get(shader)?;
        let augmented = object.augmented()?;
        let made = RlvShaderLayout {
            struct_size: 0,
            group: augmented.group,
            examples_binding: augmented.binding,
            log_binding: augmented.binding + 1,
            feature_count: augmented.features.len() as u32,
            accumulation: match augmented.accumulation {
                Accumulation::Average => RLV_SHADER_AVERAGE,
                Accumulation::Sum => RLV_SHADER_SUM,
                Accumulation::Min => RLV_SHADER_MIN,
                Accumulation::Max => RLV_SHADER_MAX,
                Accumulation::First => RLV_SHADER_FIRST,
                Accumulation::Last => RLV_SHADER_LAST,
            },
            site_count: augmented.sites.len() as u32,
            uses_confidence: u32::from(augmented.uses_confidence),
            examples_head: EXAMPLES_HEAD as u32,
            log_head: LOG_HEAD as u32,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_shader_feature(shader: RlvShader, index: usize, out: *mut RlvShaderFeature) {
        let object = registry::get(shader)?;
        let feature = element("feature", &object.augmented()?.features, index)?;
        let made = RlvShaderFeature {
            struct_size: 0,
            reserved: 0,
            name: fixed(&feature.name),
            expression: fixed(&feature.expression),
            description: fixed(&feature.description),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_shader_pack_examples(
        examples: *const RlvShaderExamples,
        mode: u32,
        x: u32,
        y: u32,
        words: *mut u32,
        capacity: usize,
        count: *mut usize,
    ) {
        present("count", count)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of its count.
        let classes = unsafe { read_examples(examples) }?;
        let mode = match mode {
            RLV_SHADER_RENDER => Mode::Render,
            RLV_SHADER_CLASSIFY => Mode::Classify([x, y]),
            RLV_SHADER_MASK => Mode::Mask([x, y]),
            RLV_SHADER_CLASSIFY_VERTEX => Mode::ClassifyVertex([x, y]),
            RLV_SHADER_VERTICES => Mode::Vertices([x, y]),
            _ => {
                return Err(Error::invalid(format!("there is no mode {mode}"))
                    .at("mode")
                    .advise("use a value of RlvShaderMode"));
            }
        };
        let packed = classes.words(mode);
        // SAFETY: checked above.
        unsafe { put(count, packed.len()) };
        // SAFETY: the caller gives room for `capacity` words, or NULL to ask for the count alone.
        if let Some(out) = unsafe { Output::optional("words", words, capacity, 0) }? {
            out.holds("words", packed.len())?.fill(packed.iter().copied());
        }
        Ok(())
    }

    fn rlv_shader_unpack_log(
        shader: RlvShader,
        words: *const u32,
        count: usize,
        vector: *mut f32,
        capacity: usize,
        taken: *mut u32,
    ) {
        let object = registry::get(shader)?;
        let augmented = object.augmented()?;
        let features = augmented.features.len();
        // SAFETY: the caller promises `count` words, and room for `capacity` numbers.
        let (words, out) =
            unsafe { (Input::new("words", words, count, 0)?, Output::new("vector", vector, capacity, 0)?) };
        let out = out.holds("vector", features)?;
        // The records of single vectors behind the sums are not needed.
        let head: Vec<u32> = words.iter().take(LOG_HEAD + features).collect();
        let log = Log::of(&head, features, augmented.accumulation)?;
        out.fill(log.vector);
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(taken, log.taken) };
        Ok(())
    }

    fn rlv_shader_membership(
        examples: *const RlvShaderExamples,
        vectors: *const f32,
        count: usize,
        stride: usize,
        out: *mut f32,
    ) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of its count.
        let classes = unsafe { read_examples(examples) }?;
        // SAFETY: the caller promises `count` vectors, and room for as many numbers.
        let (columns, out) = unsafe {
            (columns(vectors, count, classes.features.len(), stride)?, Output::new("out", out, count, 0)?)
        };
        let factors = classes.factors();
        let mut vector = vec![0.0; columns.len()];
        for index in 0..count {
            vector.iter_mut().zip(&columns).for_each(|(value, column)| *value = column.get(index));
            let examples = classes.examples.iter().map(|it| (it.class.value(), it.vector.as_slice()));
            out.set(index, membership(&vector, examples, &factors, classes.exponent));
        }
        Ok(())
    }
}
