//! What surfaces look like: the colours painted on them and, over these, the tint of their traces.

use half::f16;
use relievo_core::{Context, Result};
use relievo_gpu::wgsl::tints::TintBlock;
use relievo_gpu::{Device, wgpu};
use relievo_tiles::triangle::TriangleField;
use relievo_tiles::{AnyField, ByFormat, ColorTexel, DeviceTiles, Field, Rgba8, Rgba16, Trace, by_format};

use super::heap::{Heap, write_runs};

/// How traces of contact tint what they are on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tint {
    /// The colour of the full tint, linear Rec.709.
    pub color: [f32; 3],
    /// Object units at which the tint is full; 0, at once.
    pub depth: f32,
    /// Seconds after which it is gone; 0, never.
    pub fade: f32,
    /// Now, in seconds.
    pub time: f32,
}

impl From<Tint> for TintBlock {
    fn from(tint: Tint) -> Self {
        let per = |whole: f32| if whole > 0.0 { 1.0 / whole } else { 0.0 };
        Self {
            color: tint.color,
            per_depth: per(tint.depth),
            at_once: if tint.depth > 0.0 { 0.0 } else { 1.0 },
            per_second: per(tint.fade),
            time: tint.time,
            padding: 0,
        }
    }
}

/// Colours and traces of a surface of tiles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Coat<'a> {
    /// Colours, in place of the material's.
    pub colors: Option<AnyField<'a>>,
    /// Traces, and how they tint it.
    pub traces: Option<(&'a Field<Trace>, Tint)>,
}

/// Colours of a triangle mesh.
pub type TriangleColors<'a> = ByFormat<&'a TriangleField<Rgba8>, &'a TriangleField<Rgba16>>;

/// Colours and traces of a triangle mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct TriangleCoat<'a> {
    /// Colours, in place of the material's.
    pub colors: Option<TriangleColors<'a>>,
    /// Traces, and how they tint it.
    pub traces: Option<(&'a TriangleField<Trace>, Tint)>,
}

/// Colours on a device.
type DeviceColors = ByFormat<DeviceTiles<Rgba8>, DeviceTiles<Rgba16>>;

/// What a device has of a coat of tiles.
#[derive(Debug)]
pub struct DeviceCoat {
    colors: Option<(DeviceColors, Seams)>,
    traces: Option<(DeviceTiles<Trace>, Tint)>,
}

impl DeviceCoat {
    /// Brings a coat to a device.
    ///
    /// # Errors
    /// The device has no room.
    pub fn new(context: &Context, device: &Device, coat: Coat<'_>) -> Result<Self> {
        let mut made = Self { colors: None, traces: None };
        made.update(context, device, coat)?;
        Ok(made)
    }

    /// Makes the device have what `coat` is now: a later or earlier state of the same channels, or of others in their
    /// place.
    ///
    /// # Errors
    /// The channels are those of another surface, or the device has no room.
    pub fn update(&mut self, context: &Context, device: &Device, coat: Coat<'_>) -> Result<()> {
        let mut stale = Vec::new();
        match (&mut self.colors, coat.colors) {
            (Some((ByFormat::Rgba8(tiles), seams)), Some(ByFormat::Rgba8(field))) => {
                renew(device, tiles, field, &mut stale)?;
                seams.update(context, device, field, stale)?;
            }
            (Some((ByFormat::Rgba16(tiles), seams)), Some(ByFormat::Rgba16(field))) => {
                renew(device, tiles, field, &mut stale)?;
                seams.update(context, device, field, stale)?;
            }
            (held, Some(colors)) => {
                *held = Some(by_format!(colors, field => {
                    let mut seams = Seams::new(device, field.tile_count())?;
                    seams.update(context, device, field, Vec::new())?;
                    (bring(device, colors)?, seams)
                }));
            }
            (held, None) => *held = None,
        }
        match (&mut self.traces, coat.traces) {
            (Some((tiles, tint)), Some((traces, now))) => {
                tiles.update(device, traces)?;
                *tint = now;
            }
            (held, traces) => {
                let bring = |(traces, tint)| Ok((DeviceTiles::new(device, traces)?, tint));
                *held = traces.map(bring).transpose()?;
            }
        }
        Ok(())
    }

    /// 0 without colours, 1 with those of four bytes, 2 with those of four half floats.
    pub(super) fn format(&self) -> u8 {
        match &self.colors {
            None => 0,
            Some((ByFormat::Rgba8(_), _)) => 1,
            Some((ByFormat::Rgba16(_), _)) => 2,
        }
    }

    pub(super) fn has_traces(&self) -> bool {
        self.traces.is_some()
    }

    pub(super) fn tint(&self) -> Tint {
        self.traces.as_ref().map_or(Tint::default(), |(_, tint)| *tint)
    }

    /// The colour of tiles without a block.
    pub(super) fn blank(&self) -> [f32; 3] {
        fn of<T: ColorTexel>(tiles: &DeviceTiles<T>) -> [f32; 3] {
            tiles.field().blank().color().truncate().to_array()
        }
        self.colors.as_ref().map_or([0.0; 3], |(colors, _)| by_format!(colors, tiles => of(tiles)))
    }

    /// How many tiles the surface has, if anything is known of them.
    pub(super) fn tile_counts(&self) -> impl Iterator<Item = usize> {
        let colors = self.colors.as_ref().map(|(colors, _)| by_format!(colors, tiles => tiles.field().tile_count()));
        let traces = self.traces.as_ref().map(|(traces, _)| traces.field().tile_count());
        colors.into_iter().chain(traces)
    }

    /// What is bound for colours, their seams and traces; `nothing` for what is not there.
    pub(super) fn buffers<'a>(&'a self, nothing: &'a wgpu::Buffer) -> [&'a wgpu::Buffer; 5] {
        let [entries, texels, seams] = match &self.colors {
            Some((colors, seams)) => {
                let [entries, texels] = by_format!(colors, tiles => tiles.buffers());
                [entries, texels, seams.lists.wgpu()]
            }
            None => [nothing; 3],
        };
        let [traces, marks] = self.traces.as_ref().map_or([nothing; 2], |(traces, _)| traces.buffers());
        [entries, texels, seams, traces, marks]
    }
}

fn bring(device: &Device, colors: AnyField<'_>) -> Result<DeviceColors> {
    Ok(match colors {
        ByFormat::Rgba8(field) => ByFormat::Rgba8(DeviceTiles::new(device, field)?),
        ByFormat::Rgba16(field) => ByFormat::Rgba16(DeviceTiles::new(device, field)?),
    })
}

/// Brings what changed of colours to a device; `stale` become the tiles in which something else is seen.
fn renew<T: ColorTexel>(
    device: &Device,
    tiles: &mut DeviceTiles<T>,
    field: &Field<T>,
    stale: &mut Vec<u32>,
) -> Result<()> {
    let before = tiles.field().clone();
    let changed = tiles.update(device, field)?;
    field.seen_from(&before, &changed, stale);
    Ok(())
}

/// What coarser tiles add to the colours of those beside them (`color_seams` of `tiles_draw.wgsl`).
#[derive(Debug)]
struct Seams {
    /// Where the list of a tile is, and its texels a side.
    heads: Vec<[u32; 2]>,
    /// Where coarser tiles were around it.
    uneven: Vec<u8>,
    lists: Heap<[u32; 2]>,
}

/// The head of a tile without a list.
const NO_SEAMS: [u32; 2] = [u32::MAX, 0];

impl Seams {
    fn new(device: &Device, tiles: usize) -> Result<Self> {
        let lists = Heap::new(device, "seams of colours", tiles)?;
        let heads = vec![NO_SEAMS; tiles];
        lists.write(device, 0, &heads)?;
        Ok(Self { heads, uneven: vec![0; tiles], lists })
    }

    /// Makes the lists of `stale` tiles anew, and of those around which other ones are coarser than before.
    fn update<T: ColorTexel>(
        &mut self,
        context: &Context,
        device: &Device,
        field: &Field<T>,
        mut stale: Vec<u32>,
    ) -> Result<()> {
        for (tile, held) in (0..).zip(&mut self.uneven) {
            if std::mem::replace(held, field.uneven(tile)) != *held {
                stale.push(tile);
            }
        }
        stale.sort_unstable();
        stale.dedup();
        stale.retain(|tile| self.uneven[*tile as usize] != 0 || self.heads[*tile as usize] != NO_SEAMS);
        if stale.is_empty() {
            return Ok(());
        }
        let packed = |tile: u32| {
            let half = |value: f32| u32::from(f16::from_f32(value).to_bits());
            let list = field.seams(tile).unwrap_or_default();
            list.iter().map(|item| [half(item.x) | half(item.y) << 16, half(item.z)]).collect::<Vec<_>>()
        };
        let lists = context.map(stale.len(), |at| packed(stale[at]));
        let mut heads = Vec::with_capacity(stale.len());
        for (tile, list) in stale.iter().zip(&lists) {
            let head = &mut self.heads[*tile as usize];
            let before = if *head == NO_SEAMS { 0 } else { 4 + 4 * (2 * head[1] + 1) };
            let first = self.lists.place(head[0], before, list.len() as u32)?;
            *head = if list.is_empty() { NO_SEAMS } else { [first, field.size(*tile)] };
            heads.push((*tile, *head));
        }
        self.lists.grow(device)?;
        for ((_, [first, _]), list) in heads.iter().zip(&lists) {
            self.lists.write(device, *first, list)?;
        }
        write_runs(device, &heads, |device, first, values| self.lists.write(device, first, values))
    }
}
