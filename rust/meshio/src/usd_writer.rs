//! Writes USD: polygon meshes with subdivision tags, primvars and materials, at rest or over time with velocities, as
//! text. Binary files of the crate `openusd` have the names of children as another type than OpenUSD asks for.
//!
//! All frames of a stage are kept until it is written, because the format holds the values of a property together.

use std::collections::{BTreeMap, HashSet};
use std::io::Write;
use std::path::Path as FilePath;

use glam::DMat4;
use openusd::gf;
use openusd::sdf::{ChildrenKey, Data, FieldKey, ListOp, Path, SpecData, SpecType, Specifier, Value, Variability};
use openusd::usda::TextWriter;
use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use crate::budget::Budget;
use crate::file;
use crate::gltf::glb_writer::Instance;
use crate::stage_options::StageOptions;
use crate::usd::fenced;

/// Writes instances at rest. See [`StageWriter`].
///
/// # Errors
/// Fails as [`StageWriter::new`], [`StageWriter::frame`] and [`StageWriter::finish`] do.
pub fn write_usd(path: &FilePath, instances: &[Instance], options: &StageOptions) -> Result<()> {
    let mut writer = StageWriter::new(options, u64::MAX)?;
    writer.frame(0.0, instances).map_err(|error| error.at(path.display().to_string()))?;
    writer.finish(path)
}

/// The name of the prim above all others, which is the default one.
const ROOT: &str = "scene";
/// How the writer of text has the schema of bound prims, and how it must be. Quotes in names are escaped.
const ONE_SCHEMA: &str = "prepend apiSchemas = \"MaterialBindingAPI\"";
const ONE_SCHEMA_LISTED: &str = "prepend apiSchemas = [\"MaterialBindingAPI\"]";

/// Collects the frames of a stage.
///
/// Meshes are written with their faces, creases, sharp points and holes; `uv` as `st`, `color` as `displayColor` and
/// `displayOpacity`, `normal`, `velocity` (per second), `material` as subsets with materials, other attributes under
/// their names. A mesh with tags, or with polygons and no normals, is a subdivision surface.
#[derive(Debug)]
pub struct StageWriter {
    options: StageOptions,
    budget: Budget,
    codes: Vec<f64>,
    objects: Vec<Object>,
    /// Names of materials in the order they were met.
    materials: Vec<String>,
}

/// A mesh and what its properties were in every frame.
#[derive(Debug, Default)]
struct Object {
    /// As the first frame called it, and as its prim is called.
    name: String,
    prim: String,
    properties: BTreeMap<String, Track>,
    /// Faces of every material over time, by its number.
    subsets: BTreeMap<usize, Track>,
    /// The material of all faces.
    material: Option<usize>,
    /// Whether all frames have the faces of the first.
    faces: (Vec<u32>, Vec<u32>),
    is_steady: bool,
    has_velocities: bool,
}

/// A property over time.
#[derive(Debug)]
struct Track {
    kind: &'static str,
    interpolation: Option<&'static str>,
    is_uniform: bool,
    /// Values with the frames from which on they hold; the same one again before it changes.
    samples: Vec<(usize, Value)>,
    /// The last frame it was given in.
    last: usize,
}

impl Track {
    fn push(&mut self, frame: usize, value: Value) {
        match self.samples.last() {
            // What is uniform cannot change.
            Some(_) if self.is_uniform => {}
            Some((_, known)) if *known == value => {}
            Some((from, known)) => {
                // What stayed the same until now must not begin to change before.
                if *from < self.last {
                    let known = known.clone();
                    self.samples.push((self.last, known));
                }
                self.samples.push((frame, value));
            }
            None => self.samples.push((frame, value)),
        }
        self.last = frame;
    }
}

impl StageWriter {
    /// A stage without frames. Frames take at most `memory_limit` bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if the options are no positive numbers.
    pub fn new(options: &StageOptions, memory_limit: u64) -> Result<Self> {
        for number in [options.meters_per_unit, options.time_codes_per_second] {
            if !(number > 0.0 && number.is_finite()) {
                return Err(Error::invalid(format!("{number} is no unit of length or rate of time codes")));
            }
        }
        Ok(Self {
            options: *options,
            budget: Budget::new(memory_limit),
            codes: Vec::new(),
            objects: Vec::new(),
            materials: Vec::new(),
        })
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.codes.len()
    }

    /// Adds what there is at a time code, which must be higher than that of the frame before. Every frame has the same
    /// instances in the same order; of their materials the first frame's count.
    ///
    /// # Errors
    /// Fails with `Invalid` if the time code does not come after the one before, a mesh cannot be used (see
    /// [`Mesh::check`]), no instance is given or not as many as before, or a transform is not finite, and with `Memory`
    /// if all frames together need more than the memory limit.
    pub fn frame(&mut self, code: f64, instances: &[Instance]) -> Result<()> {
        if !code.is_finite() || self.codes.last().is_some_and(|last| *last >= code) {
            return Err(Error::invalid(format!("time code {code} does not come after the one before")));
        }
        if instances.is_empty() {
            return Err(Error::invalid("there is no mesh to write"));
        }
        if !self.codes.is_empty() && self.objects.len() != instances.len() {
            return Err(Error::invalid(format!("{} meshes follow {}", instances.len(), self.objects.len())));
        }
        for (index, instance) in instances.iter().enumerate() {
            let place = |error: Error| error.at(format!("instance {index} `{}`", instance.name));
            instance.mesh.check().map_err(place)?;
            if !instance.transform.is_finite() {
                return Err(place(Error::invalid("its transform is not finite")));
            }
            self.charge(instance.mesh).map_err(place)?;
        }
        let frame = self.codes.len();
        self.codes.push(code);
        for (index, instance) in instances.iter().enumerate() {
            if frame == 0 {
                let prim = unused(&identifier(instance.name), self.objects.iter().map(|object| object.prim.as_str()));
                self.objects.push(Object {
                    name: instance.name.into(),
                    prim,
                    is_steady: true,
                    faces: (instance.mesh.face_sizes.clone(), instance.mesh.corners.clone()),
                    ..Object::default()
                });
            }
            self.bind(frame, index, instance);
            self.objects[index].add(frame, instance);
        }
        Ok(())
    }

    /// Counts what a frame adds at most: values, and as much again while they are written.
    fn charge(&mut self, mesh: &Mesh) -> Result<()> {
        let attributes: usize = mesh.attributes.iter().map(|attribute| attribute.values.len()).sum();
        let numbers = 6 * mesh.points.len() + mesh.corners.len() + mesh.face_sizes.len() + attributes;
        self.budget.charge(8 * numbers as u64).map_err(|_| {
            Error::memory("all frames of a USD stage together need more than the memory limit")
                .advise("write fewer frames, or a format of a file for each frame, or raise the memory limit")
        })
    }

    /// The materials of an instance: of all of it, or of subsets of its faces.
    fn bind(&mut self, frame: usize, index: usize, instance: &Instance) {
        let Some(Attribute { domain: Domain::Face, width: 1, values: Values::U32(slots), indices: None, .. }) =
            instance.mesh.attribute("material")
        else {
            return;
        };
        let mut subsets: BTreeMap<u32, Vec<i32>> = BTreeMap::new();
        for (face, slot) in slots.iter().enumerate() {
            subsets.entry(*slot).or_default().push(face as i32);
        }
        if self.objects[index].material.is_some() {
            return;
        }
        let whole = frame == 0 && subsets.len() == 1;
        for (slot, faces) in subsets {
            let name = match instance.materials.get(slot as usize) {
                Some(name) if name.is_empty() => continue,
                Some(name) => name.clone(),
                None => format!("material_{slot}"),
            };
            let known = self.materials.iter().position(|known| *known == name);
            let material = known.unwrap_or_else(|| {
                self.materials.push(name);
                self.materials.len() - 1
            });
            let object = &mut self.objects[index];
            if whole {
                object.material = Some(material);
            } else {
                let fresh = || Track {
                    kind: "int[]",
                    interpolation: None,
                    is_uniform: false,
                    samples: Vec::new(),
                    last: frame,
                };
                object.subsets.entry(material).or_insert_with(fresh).push(frame, Value::IntVec(faces));
            }
        }
    }

    /// Writes the stage as text, whose extension is `.usda` or `.usd`. The file appears whole or not at all.
    ///
    /// # Errors
    /// Fails with `Unsupported` for another extension, with `Invalid` without frames, with `Internal` if the stage
    /// cannot be put into text, and with `NotFound` or `Io` if the system refuses.
    pub fn finish(self, path: &FilePath) -> Result<()> {
        let named = |error: Error| error.at(path.display().to_string());
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        if !matches!(extension.as_deref(), Some("usda" | "usd")) {
            let error = Error::unsupported("USD is written as text only");
            return Err(named(error.advise("use the extension .usda, and usdcat to make it binary")));
        }
        if self.codes.is_empty() {
            return Err(named(Error::invalid("there is no frame to write")));
        }
        let data = self.data().map_err(named)?;
        let text = fenced(|| TextWriter::write_to_string(&data)).map_err(named)?;
        drop(data);
        // The writer leaves the brackets of a list of one away, which only reads again what may be no list.
        let text = text.replace(ONE_SCHEMA, ONE_SCHEMA_LISTED);
        file::store(path, |out| out.write_all(text.as_bytes()))
    }

    /// Everything as specs.
    fn data(self) -> Result<Data> {
        let Self { options, codes, objects, materials, .. } = self;
        let mut stage = Specs { data: Data::new(), codes };
        let axis = if options.z_up { "Z" } else { "Y" };
        let root = stage.data.create_spec(Path::abs_root(), SpecType::PseudoRoot);
        root.add(FieldKey::DefaultPrim, Value::token(ROOT));
        root.add("metersPerUnit", Value::Double(options.meters_per_unit));
        root.add("upAxis", Value::token(axis));
        root.add(FieldKey::TimeCodesPerSecond, Value::Double(options.time_codes_per_second));
        root.add(FieldKey::FramesPerSecond, Value::Double(options.time_codes_per_second));
        if let [first, .., last] = stage.codes[..] {
            root.add(FieldKey::StartTimeCode, Value::Double(first));
            root.add(FieldKey::EndTimeCode, Value::Double(last));
        }
        root.add(ChildrenKey::PrimChildren, Value::token_vec([ROOT]));
        let top = path(format!("/{ROOT}"))?;
        let folder = unused("materials", objects.iter().map(|object| object.prim.as_str()));
        let mut children: Vec<&str> = objects.iter().map(|object| object.prim.as_str()).collect();
        if !materials.is_empty() {
            children.push(&folder);
        }
        stage.prim(&top, "Xform", &children);
        let scope = path(format!("/{ROOT}/{folder}"))?;
        let mut named: Vec<String> = Vec::new();
        for name in &materials {
            named.push(unused(&identifier(name), named.iter().map(String::as_str)));
        }
        if !materials.is_empty() {
            stage.prim(&scope, "Scope", &named.iter().map(String::as_str).collect::<Vec<_>>());
        }
        let targets: Vec<Path> =
            named.iter().map(|name| path(format!("{}/{name}", scope.as_str()))).collect::<Result<_>>()?;
        for target in &targets {
            stage.prim(target, "Material", &[]);
        }
        for object in objects {
            let at = path(format!("{}/{}", top.as_str(), object.prim))?;
            stage.object(&at, object, &named, &targets, options.time_codes_per_second)?;
        }
        Ok(stage.data)
    }
}

impl Object {
    /// What a property is from a frame on.
    fn set(&mut self, frame: usize, name: &str, kind: &'static str, interpolation: Option<&'static str>, value: Value) {
        let is_uniform = matches!(name, "subdivisionScheme" | "xformOpOrder");
        let fresh = || Track { kind, interpolation, is_uniform, samples: Vec::new(), last: frame };
        self.properties.entry(name.into()).or_insert_with(fresh).push(frame, value);
    }

    fn add(&mut self, frame: usize, instance: &Instance) {
        let mesh = instance.mesh;
        let ints = |list: &[u32]| Value::IntVec(list.iter().map(|number| *number as i32).collect());
        let triples = |list: &[[f32; 3]]| Value::Vec3fVec(bytemuck::cast_slice(list).to_vec());
        self.is_steady &= self.faces.0 == mesh.face_sizes && self.faces.1 == mesh.corners;
        self.set(frame, "points", "point3f[]", None, triples(&mesh.points));
        let (low, high) = mesh.bounds().unwrap_or_default();
        self.set(frame, "extent", "float3[]", None, triples(&[low, high]));
        self.set(frame, "faceVertexCounts", "int[]", None, ints(&mesh.face_sizes));
        self.set(frame, "faceVertexIndices", "int[]", None, ints(&mesh.corners));
        let tagged = !(mesh.creases.is_empty() && mesh.sharp_points.is_empty() && mesh.holes.is_empty());
        let polygons = mesh.face_sizes.iter().any(|size| *size != 3);
        let is_surface = tagged || polygons && mesh.attribute("normal").is_none();
        let scheme = if is_surface { "catmullClark" } else { "none" };
        self.set(0, "subdivisionScheme", "token", None, Value::token(scheme));
        if tagged {
            let points: Vec<u32> = mesh.creases.iter().flat_map(|crease| crease.points).collect();
            let sharpness = Value::FloatVec(mesh.creases.iter().map(|crease| crease.sharpness).collect());
            self.set(frame, "creaseIndices", "int[]", None, ints(&points));
            self.set(frame, "creaseLengths", "int[]", None, ints(&vec![2; mesh.creases.len()]));
            self.set(frame, "creaseSharpnesses", "float[]", None, sharpness);
            let (points, sharpness): (Vec<u32>, Vec<f32>) = mesh.sharp_points.iter().copied().unzip();
            self.set(frame, "cornerIndices", "int[]", None, ints(&points));
            self.set(frame, "cornerSharpnesses", "float[]", None, Value::FloatVec(sharpness));
            self.set(frame, "holeIndices", "int[]", None, ints(&mesh.holes));
        }
        // Rows for row vectors are the columns of a matrix for column vectors.
        let matrix = gf::Matrix4d(DMat4::from(instance.transform).to_cols_array());
        self.set(frame, "xformOp:transform", "matrix4d", None, Value::Matrix4d(matrix));
        self.set(0, "xformOpOrder", "token[]", None, Value::token_vec(["xformOp:transform"]));
        let mut used = HashSet::new();
        for attribute in &mesh.attributes {
            self.attribute(frame, attribute, &mut used);
        }
    }

    fn attribute(&mut self, frame: usize, attribute: &Attribute, used: &mut HashSet<String>) {
        let interpolation = Some(match attribute.domain {
            Domain::Point => "vertex",
            Domain::Corner => "faceVarying",
            Domain::Face => "uniform",
        });
        let Attribute { name, width, values, indices, .. } = attribute;
        if name == "material" {
            return;
        }
        let property = match (name.as_str(), values, width) {
            ("normal", Values::F32(_), 3) => "normals".to_owned(),
            ("velocity", Values::F32(_), 3) if attribute.domain == Domain::Point => "velocities".into(),
            ("uv", Values::F32(_), 2) => "primvars:st".into(),
            ("color", Values::F32(_), 3 | 4) => "primvars:displayColor".into(),
            _ => {
                let name = identifier(name);
                // Not under the names of those above, whatever the others are called.
                let taken = ["st", "displayColor", "displayOpacity", "normals"];
                format!("primvars:{}", unused(&name, taken.into_iter().chain(used.iter().map(String::as_str))))
            }
        };
        if let Some(plain) = property.strip_prefix("primvars:") {
            used.insert(plain.to_owned());
        }
        let is = |wanted: &str| property == wanted;
        self.has_velocities |= is("velocities");
        // Values that corners share have no indices outside primvars.
        let flat = if is("normals") { indices.as_ref() } else { None };
        let (kind, value) = match values {
            Values::F32(list) => {
                let spread: Vec<f32>;
                let list = match flat {
                    Some(indices) => {
                        let width = *width as usize;
                        let value = |index: &u32| &list[*index as usize * width..(*index as usize + 1) * width];
                        spread = indices.iter().flat_map(value).copied().collect();
                        &spread
                    }
                    None => list,
                };
                match width {
                    1 => ("float[]", Value::FloatVec(list.clone())),
                    2 => (
                        if is("primvars:st") { "texCoord2f[]" } else { "float2[]" },
                        Value::Vec2fVec(bytemuck::cast_slice(list).to_vec()),
                    ),
                    4 if is("primvars:displayColor") => {
                        let (rgba, _) = list.as_chunks::<4>();
                        let alpha = rgba.iter().map(|color| color[3]).collect();
                        let opacity = "primvars:displayOpacity";
                        self.set(frame, opacity, "float[]", interpolation, Value::FloatVec(alpha));
                        if let Some(indices) = indices {
                            self.indices(frame, opacity, indices);
                        }
                        let rgb = rgba.iter().map(|color| gf::vec3f(color[0], color[1], color[2])).collect();
                        ("color3f[]", Value::Vec3fVec(rgb))
                    }
                    3 => {
                        let kind = match property.as_str() {
                            "normals" => "normal3f[]",
                            "velocities" => "vector3f[]",
                            "primvars:displayColor" => "color3f[]",
                            _ => "float3[]",
                        };
                        (kind, Value::Vec3fVec(bytemuck::cast_slice(list).to_vec()))
                    }
                    _ => ("float4[]", Value::Vec4fVec(bytemuck::cast_slice(list).to_vec())),
                }
            }
            Values::U32(list) if *width == 1 => match list.iter().map(|number| i32::try_from(*number)).collect() {
                Ok(list) => ("int[]", Value::IntVec(list)),
                Err(_) => ("int64[]", Value::Int64Vec(list.iter().map(|number| i64::from(*number)).collect())),
            },
            // Tuples of integers have no more than 31 bits, and nothing but skins has them.
            Values::U32(_) => return,
        };
        self.set(frame, &property, kind, interpolation, value);
        if let (Some(indices), None) = (indices, flat) {
            self.indices(frame, &property, indices);
        }
    }

    fn indices(&mut self, frame: usize, property: &str, indices: &[u32]) {
        let list = Value::IntVec(indices.iter().map(|index| *index as i32).collect());
        self.set(frame, &format!("{property}:indices"), "int[]", None, list);
    }
}

/// Specs under way.
struct Specs {
    data: Data,
    codes: Vec<f64>,
}

impl Specs {
    fn prim(&mut self, path: &Path, kind: &str, children: &[&str]) -> &mut SpecData {
        let spec = self.data.create_spec(path.clone(), SpecType::Prim);
        spec.add(FieldKey::Specifier, Value::Specifier(Specifier::Def));
        spec.add(FieldKey::TypeName, Value::token(kind));
        if !children.is_empty() {
            spec.add(ChildrenKey::PrimChildren, Value::token_vec(children.iter().copied()));
        }
        spec
    }

    fn property(&mut self, prim: &Path, name: &str, kind: SpecType) -> Result<&mut SpecData> {
        let path = prim.append_property(name).map_err(|error| Error::internal(format!("{error:#}")))?;
        Ok(self.data.create_spec(path, kind))
    }

    /// The relationship to a material.
    fn binding(&mut self, prim: &Path, target: &Path) -> Result<()> {
        let spec = self.property(prim, "material:binding", SpecType::Relationship)?;
        let targets = ListOp { explicit: true, explicit_items: vec![target.clone()], ..ListOp::default() };
        spec.add(FieldKey::TargetPaths, Value::PathListOp(targets));
        Ok(())
    }

    fn object(&mut self, at: &Path, object: Object, names: &[String], targets: &[Path], rate: f64) -> Result<()> {
        let Object { mut properties, subsets, material, is_steady, has_velocities, name, .. } = object;
        let identity = Value::Matrix4d(gf::Matrix4d(DMat4::IDENTITY.to_cols_array()));
        if properties
            .get("xformOp:transform")
            .is_some_and(|track| matches!(&track.samples[..], [(_, one)] if *one == identity))
        {
            properties.retain(|name, _| !name.starts_with("xformOp"));
        }
        let velocities = match properties.get("points") {
            Some(points) if is_steady && !has_velocities => velocities(&self.codes, points, rate),
            _ => Vec::new(),
        };
        let is_bound = material.is_some() || !subsets.is_empty();
        let mut listed: Vec<String> = properties.keys().cloned().collect();
        for (name, wanted) in [
            ("velocities", !velocities.is_empty()),
            ("material:binding", material.is_some()),
            ("subsetFamily:materialBind:familyType", !subsets.is_empty()),
        ] {
            if wanted {
                listed.push(name.into());
            }
        }
        let children: Vec<&str> = subsets.keys().map(|material| names[*material].as_str()).collect();
        let spec = self.prim(at, "Mesh", &children);
        spec.add(ChildrenKey::PropertyChildren, Value::token_vec(listed));
        let schema = || ListOp { prepended_items: vec!["MaterialBindingAPI".into()], ..ListOp::default() };
        if is_bound {
            spec.add(FieldKey::ApiSchemas, Value::TokenListOp(schema()));
        }
        if at.name() != Some(name.as_str()) {
            spec.add("displayName", Value::String(name));
        }
        for (name, track) in properties {
            self.track(at, &name, track)?;
        }
        if !velocities.is_empty() {
            let samples = self.codes.iter().copied().zip(velocities).collect();
            let spec = self.property(at, "velocities", SpecType::Attribute)?;
            spec.add(FieldKey::TypeName, Value::token("vector3f[]"));
            spec.add(FieldKey::TimeSamples, Value::TimeSamples(samples));
        }
        if let Some(material) = material {
            self.binding(at, &targets[material])?;
        }
        if subsets.is_empty() {
            return Ok(());
        }
        let spec = self.property(at, "subsetFamily:materialBind:familyType", SpecType::Attribute)?;
        spec.add(FieldKey::TypeName, Value::token("token"));
        spec.add(FieldKey::Variability, Value::Variability(Variability::Uniform));
        spec.add(FieldKey::Default, Value::token("nonOverlapping"));
        for (material, faces) in subsets {
            let path = path(format!("{}/{}", at.as_str(), names[material]))?;
            let spec = self.prim(&path, "GeomSubset", &[]);
            let listed = ["elementType", "familyName", "indices", "material:binding"];
            spec.add(ChildrenKey::PropertyChildren, Value::token_vec(listed));
            spec.add(FieldKey::ApiSchemas, Value::TokenListOp(schema()));
            for (name, value) in [("elementType", "face"), ("familyName", "materialBind")] {
                let spec = self.property(&path, name, SpecType::Attribute)?;
                spec.add(FieldKey::TypeName, Value::token("token"));
                spec.add(FieldKey::Variability, Value::Variability(Variability::Uniform));
                spec.add(FieldKey::Default, Value::token(value));
            }
            self.track(&path, "indices", faces)?;
            self.binding(&path, &targets[material])?;
        }
        Ok(())
    }

    /// A property with its values over time, or its only one.
    fn track(&mut self, prim: &Path, name: &str, track: Track) -> Result<()> {
        let times: Vec<f64> = track.samples.iter().map(|(frame, _)| self.codes[*frame]).collect();
        let spec = self.property(prim, name, SpecType::Attribute)?;
        spec.add(FieldKey::TypeName, Value::token(track.kind));
        if track.is_uniform {
            spec.add(FieldKey::Variability, Value::Variability(Variability::Uniform));
        }
        if let Some(interpolation) = track.interpolation {
            spec.add("interpolation", Value::token(interpolation));
        }
        let mut values: Vec<Value> = track.samples.into_iter().map(|(_, value)| value).collect();
        if values.len() == 1 {
            values.drain(..).for_each(|value| spec.add(FieldKey::Default, value));
        } else {
            spec.add(FieldKey::TimeSamples, Value::TimeSamples(times.into_iter().zip(values).collect()));
        }
        Ok(())
    }
}

/// Velocities per second of points in all frames: from the frame before to the one after. None if nothing moves.
fn velocities(codes: &[f64], points: &Track, rate: f64) -> Vec<Value> {
    if codes.len() < 2 || points.samples.len() < 2 {
        return Vec::new();
    }
    let at = |frame: usize| -> &[gf::Vec3f] {
        let after = points.samples.partition_point(|(from, _)| *from <= frame);
        match points.samples.get(after.saturating_sub(1)) {
            Some((_, Value::Vec3fVec(list))) => list,
            _ => &[],
        }
    };
    let last = codes.len() - 1;
    let between = |frame: usize| {
        let (a, b) = (frame.saturating_sub(1), (frame + 1).min(last));
        let share = rate / (codes[b] - codes[a]);
        let speed = |from: f32, to: f32| ((f64::from(to) - f64::from(from)) * share) as f32;
        let pairs = at(a).iter().zip(at(b));
        Value::Vec3fVec(pairs.map(|(a, b)| gf::vec3f(speed(a.x, b.x), speed(a.y, b.y), speed(a.z, b.z))).collect())
    };
    (0..=last).map(between).collect()
}

fn path(text: String) -> Result<Path> {
    Path::new(&text).map_err(|error| Error::internal(format!("{text}: {error:#}")))
}

/// A name as USD allows it: letters, digits and underscores of ASCII, not beginning with a digit.
fn identifier(name: &str) -> String {
    let letters = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
    let mut plain: String = letters.collect();
    if plain.is_empty() || plain.starts_with(|first: char| first.is_ascii_digit()) {
        plain.insert(0, '_');
    }
    plain
}

/// `name`, with a number if it is used.
fn unused<'a>(name: &str, used: impl Iterator<Item = &'a str>) -> String {
    let used: HashSet<&str> = used.collect();
    let numbered = (1..).map(|number| format!("{name}_{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !used.contains(name.as_str())).unwrap_or_default()
}
