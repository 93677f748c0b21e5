//! USD: meshes of a stage with their subdivision tags, primvars, materials and motion, from text (`.usda`) and binary
//! (`.usdc`) layers.
//!
//! The crate `openusd` reads layers; what they say is composed here, because its composition has no bounds. Lengths
//! become metres and y becomes up, as in glTF: both by the node above all others. Second 0 is the stage's
//! `startTimeCode`, or time code 0.

mod archive;
mod binary;
mod hierarchy;
mod instancers;
mod layer;
mod old_names;
mod polygons;
mod stage;
mod text;
mod value;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use openusd::sdf::{Specifier, Value};
use relievo_core::{Error, Result};

use crate::budget::Budget;
use crate::model::{Animation, Model, Node, Placement};
use crate::root::Root;
use crate::transform;
use hierarchy::Clock;
use polygons::Slots;
use stage::{Prim, Stage, word};
use value::number;

pub use instancers::read_usd_instancers;
pub(crate) use layer::fenced;

/// The name of the animation of a stage on which something moves.
pub const ANIMATION: &str = "stage";

/// Reads a stage whose root layer is `bytes`; files that it names from `folder` are opened where `root` allows.
/// `memory_limit` bounds in bytes what is allocated for it.
///
/// Prims that are no meshes, files that cannot be opened, and what only other renderers need are left out with a note.
///
/// # Errors
/// Fails with `Invalid`, and the prim, if data are damaged, refer to nothing or are not finite, or the stage shows no
/// meshes; with `Unsupported` for too many or too deeply nested prims, or a binary layer of another version; and with
/// `Memory` above the limit.
pub fn read_usd(bytes: Vec<u8>, memory_limit: u64, folder: &Path, root: &Root) -> Result<Model> {
    let mut stage = Stage::open(bytes, Budget::new(memory_limit), folder, root)?;
    let (clock, space) = opened(&stage)?;
    let mut reader =
        Reader { model: Model::default(), slots: Slots::default(), animation: Animation::default(), clock };
    reader.node("", None, Placement::Matrix(space), None);
    let top = stage.top();
    reader.prims(&mut stage, &top)?;
    let Reader { mut model, slots, mut animation, .. } = reader;
    if !animation.shapes.is_empty() || !animation.transforms.is_empty() {
        animation.name = ANIMATION.into();
        model.animations.push(animation);
    }
    if model.meshes.is_empty() {
        return Err(Error::invalid("the stage shows no meshes").advise("export polygon meshes, not curves or shapes"));
    }
    (model.materials, model.groups) = (slots.materials, slots.groups);
    model.is_converted = true;
    model.notes = stage.into_notes();
    Ok(model)
}

/// Returns the clock of a stage, and the map from its space to metres with y up.
fn opened(stage: &Stage) -> Result<(Clock, DAffine3)> {
    let scalar = |name: &str| -> Result<Option<f64>> {
        Ok(stage.metadata(name)?.and_then(|value| number(&value)).filter(|number| number.is_finite()))
    };
    let positive = |number: &f64| *number > 0.0;
    let rate = match scalar("timeCodesPerSecond")?.filter(positive) {
        Some(rate) => rate,
        None => scalar("framesPerSecond")?.filter(positive).unwrap_or(24.0),
    };
    let clock = Clock { start: scalar("startTimeCode")?.unwrap_or(0.0), rate };
    let unit = scalar("metersPerUnit")?.filter(positive).unwrap_or_else(|| {
        stage.note("the stage does not say its unit, which then is the centimetre");
        0.01
    });
    let axes = match stage.metadata("upAxis")?.as_deref().and_then(word) {
        // x stays, z becomes y.
        Some("Z") => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        _ => DMat3::IDENTITY,
    };
    Ok((clock, DAffine3::from_mat3(axes * unit)))
}

/// What prims are turned into.
struct Reader {
    model: Model,
    slots: Slots,
    animation: Animation,
    clock: Clock,
}

impl Reader {
    fn node(&mut self, name: &str, parent: Option<usize>, local: Placement, mesh: Option<usize>) -> usize {
        self.model.nodes.push(Node { name: name.into(), parent, local, mesh, skin: None, weights: None });
        self.model.nodes.len() - 1
    }

    /// Reads the prims below one, whose node is the first.
    fn prims(&mut self, stage: &mut Stage, top: &Prim) -> Result<()> {
        let mut waiting: Vec<(Prim, usize)> = stage.children(top)?.into_iter().rev().map(|prim| (prim, 0)).collect();
        while let Some((prim, parent)) = waiting.pop() {
            let place = |error: Error| error.at(prim.path.clone());
            if !shown(stage, &prim).map_err(place)? {
                continue;
            }
            let children = stage.children(&prim)?;
            let node = self.prim(stage, &prim, &children, parent).map_err(place)?;
            waiting.extend(children.into_iter().rev().map(|child| (child, node)));
        }
        Ok(())
    }

    /// The node of a prim, with its mesh if it is one.
    fn prim(&mut self, stage: &Stage, prim: &Prim, children: &[Prim], parent: usize) -> Result<usize> {
        let kind = stage.field(prim, "typeName")?.as_deref().and_then(word).unwrap_or_default().to_owned();
        let (operations, reset) = hierarchy::placement(stage, prim, self.clock)?;
        let local = Placement::Matrix(transform::map(&operations, None));
        stage.charge(256)?;
        let node = self.node(prim.name(), Some(if reset { 0 } else { parent }), local, None);
        if operations.iter().any(|operation| !operation.keys.is_empty()) {
            self.animation.transforms.push((node, operations));
        }
        match kind.as_str() {
            "Mesh" => {
                let is_subset = |child: &&Prim| {
                    let kind = stage.field(child, "typeName");
                    kind.is_ok_and(|kind| kind.as_deref().and_then(word) == Some("GeomSubset"))
                };
                let subsets: Vec<Prim> = children.iter().filter(is_subset).cloned().collect();
                if let Some((part, keys)) = polygons::part(stage, prim, &subsets, &mut self.slots, self.clock)? {
                    self.model.nodes[node].mesh = Some(self.model.meshes.len());
                    self.model.meshes.push(part);
                    self.animation.shapes.extend(keys.map(|keys| crate::model::ShapeKeys { node, ..keys }));
                }
            }
            "Cube" | "Sphere" | "Cylinder" | "Cone" | "Capsule" | "Plane" | "BasisCurves" | "NurbsCurves"
            | "NurbsPatch" | "HermiteCurves" | "Points" | "PointInstancer" | "TetMesh" | "Volume" => {
                stage.note(&format!("prims of type {kind} are left out"));
            }
            _ => {}
        }
        Ok(node)
    }
}

/// Whether a prim is there, and is not only for other ways to look at the stage.
fn shown(stage: &Stage, prim: &Prim) -> Result<bool> {
    let active = stage.field(prim, "active")?;
    if matches!(active.as_deref(), Some(Value::Bool(false))) {
        return Ok(false);
    }
    if !stage.any(prim, "specifier", |value| matches!(value, Value::Specifier(Specifier::Def)))? {
        return Ok(false);
    }
    if stage.any(prim, "specifier", |value| matches!(value, Value::Specifier(Specifier::Class)))?
        && !matches!(stage.field(prim, "specifier")?.as_deref(), Some(Value::Specifier(Specifier::Def)))
    {
        return Ok(false);
    }
    let is = |name: &str, words: &[&str]| -> Result<bool> {
        let value = stage.property(prim, name)?;
        Ok(value.rest().and_then(word).is_some_and(|value| words.contains(&value)))
    };
    if is("purpose", &["proxy", "guide"])? {
        stage.note("prims that are proxies or guides are left out");
        return Ok(false);
    }
    if is("visibility", &["invisible"])? {
        stage.note("prims that are invisible are left out");
        return Ok(false);
    }
    Ok(true)
}
