//! A decal that is laid by hand: a click puts an image on the surface, pins are added and dragged, and it is written into the
//! active layer of colour as one edit.

use std::path::Path;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Error, Mesh, Result};
use relievo_decal::{Artwork, Decal, DecalSettings, Pin, Place, Placement, Pose, Quality, Sticker};
use relievo_detail::with_object;
use relievo_render::read_image;

use super::{Picked, Session};
use crate::model::stamp::name_of;

/// How far outside of a triangle of the decal, in barycentric coordinates, a place still belongs to it.
const SLACK: f64 = 1e-3;

/// An image that is laid on the surface.
pub struct HandDecal {
    name: String,
    sticker: Sticker,
    artwork: Artwork,
    laid: Option<Laid>,
    /// The pin that keys act on.
    pub(crate) selected: Option<usize>,
    /// Why it could not be laid as it was asked to.
    fault: Option<String>,
    /// Counts images that were opened.
    pub(crate) serial: u64,
}

/// Where it lies.
struct Laid {
    placement: Placement,
    decal: Decal,
    pose: Pose,
    /// The pins in space, and the normals of their faces.
    dots: Vec<(DVec3, DVec3)>,
    /// The pins before one was dragged.
    before: Option<Vec<Pin>>,
    /// The changes of the model, and its division into triangles, that it follows.
    changes: u64,
    serial: u64,
}

impl HandDecal {
    /// The name of the image's file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it lies on the surface.
    pub fn is_laid(&self) -> bool {
        self.laid.is_some()
    }

    /// The pins in space, with the normals of the surface there.
    pub fn pins(&self) -> &[(DVec3, DVec3)] {
        self.laid.as_ref().map_or(&[], |laid| &laid.dots)
    }

    /// The distortion, where it lies.
    pub fn quality(&self) -> Option<&Quality> {
        self.laid.as_ref().map(|laid| &laid.decal.quality)
    }

    /// Why it could not be laid as it was asked to last, if so.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Its triangles and their places in the image, where it lies.
    pub(crate) fn decal(&self) -> Option<&Decal> {
        self.laid.as_ref().map(|laid| &laid.decal)
    }

    /// Its image.
    pub(crate) fn artwork(&self) -> &Artwork {
        &self.artwork
    }
}

impl Laid {
    /// Brings what is shown to the placement.
    fn refresh(&mut self) -> Result<()> {
        self.decal = self.placement.decal();
        self.dots.clear();
        for pin in self.placement.pins() {
            let point = DVec3::from(self.placement.position(pin.place)?);
            self.dots.push((point, normal(self.placement.mesh(), pin.place.face)));
        }
        Ok(())
    }
}

/// The normal of a triangle of a mesh, of length 1.
fn normal(mesh: &Mesh, face: u32) -> DVec3 {
    let [a, b, c] = corners(mesh, face).unwrap_or([DVec3::ZERO; 3]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// The corners of a triangle of a mesh.
fn corners(mesh: &Mesh, face: u32) -> Option<[DVec3; 3]> {
    let corners = mesh.corners.as_chunks::<3>().0.get(face as usize)?;
    Some(
        corners
            .map(|corner| mesh.points.get(corner as usize).map_or(DVec3::ZERO, |it| glam::Vec3::from(*it).as_dvec3())),
    )
}

/// The point of the image, in pixels from its lower left corner, that lies on a place of the surface; `None` beside it.
fn image_at(decal: &Decal, sticker: &Sticker, picked: &Picked) -> Option<[f64; 2]> {
    let mut best: Option<(f64, [f64; 2])> = None;
    let faces = decal.faces.iter().zip(&decal.triangles).filter(|(face, _)| **face == picked.triangle);
    for (_, triangle) in faces {
        let [a, b, c] = triangle.map(|corner| DVec3::from(decal.points[corner as usize]));
        let across = (b - a).cross(c - a);
        let share =
            |from: DVec3, to: DVec3| across.dot((to - from).cross(picked.point - from)) / across.length_squared();
        let weights = [share(b, c), share(c, a), share(a, b)];
        let least = weights.into_iter().fold(f64::INFINITY, f64::min);
        if least >= -SLACK && best.is_none_or(|(other, _)| least > other) {
            let uv = triangle.map(|corner| decal.uv[corner as usize]);
            best = Some((least, [0, 1].map(|axis| (0..3).map(|at| weights[at] * uv[at][axis]).sum())));
        }
    }
    let (_, uv) = best.filter(|(_, uv)| sticker.covers(*uv))?;
    let [width, height] = sticker.pixels().map(f64::from);
    Some([uv[0] * width, uv[1] * height])
}

impl Session {
    /// Opens a PNG or EXR file as the image that is laid by hand, in place of another one.
    ///
    /// # Errors
    /// The file cannot be read, is damaged or too large. The image before stays.
    pub fn open_decal(&mut self, path: &Path) -> Result<()> {
        let image = read_image(path, self.context.memory_limit())?;
        let named = |error: Error| error.at(path.display().to_string());
        let sticker = Sticker::whole([image.width(), image.height()]).map_err(named)?;
        let artwork = Artwork::new(&sticker, &image).map_err(named)?;
        let serial = self.decal.as_ref().map_or(0, |decal| decal.serial) + 1;
        let name = name_of(path);
        self.decal =
            Some(Box::new(HandDecal { name, sticker, artwork, laid: None, selected: None, fault: None, serial }));
        Ok(())
    }

    /// The image that is laid by hand.
    pub fn decal(&self) -> Option<&HandDecal> {
        self.decal.as_deref()
    }

    /// Selects one of its pins, or none.
    pub fn select_pin(&mut self, pin: Option<usize>) {
        if let Some(decal) = &mut self.decal {
            decal.selected = pin.filter(|pin| *pin < decal.pins().len());
        }
    }

    /// Whether an image lies on the surface that is not written yet.
    pub fn is_laid(&self) -> bool {
        self.decal.as_ref().is_some_and(|decal| decal.is_laid())
    }

    /// Does something with the decal, and notes why it was refused.
    fn with_decal<T>(&mut self, act: impl FnOnce(&mut Self, &mut HandDecal) -> Result<T>) -> Result<T> {
        let Some(mut decal) = self.decal.take() else {
            return Err(Error::invalid("there is no image to lay").advise("open one, or drop its file on the window"));
        };
        let done = act(self, &mut decal);
        decal.fault = done.as_ref().err().map(Error::to_string);
        self.decal = Some(decal);
        done
    }

    /// Lays the decal with other pins.
    fn lay(&mut self, decal: &mut HandDecal, pins: &[Pin], pose: Pose) -> Result<()> {
        let Self { costs, triangles, changes, .. } = self;
        let settings = DecalSettings::default();
        let made = || Placement::new(triangles.mesh(), &decal.sticker, pins, Some(pose), &settings, &mut Silent);
        let placement = costs.other("decal", made)?;
        let (changes, serial) = (*changes + triangles.serial, triangles.serial);
        let laid = placement.decal();
        let before = decal.laid.take().and_then(|laid| laid.before);
        let mut laid = Laid { placement, decal: laid, pose, dots: Vec::new(), before, changes, serial };
        laid.refresh()?;
        decal.laid = Some(laid);
        Ok(())
    }

    /// Puts a pin where the surface was picked. The first one lays the middle of the image there, as wide as the brush, with
    /// `up` upwards; the others hold what lies there. Returns its number.
    ///
    /// # Errors
    /// There is no image, it does not lie at the place, or cannot be laid with that pin. It stays as it was.
    pub fn add_pin(&mut self, picked: &Picked, up: DVec3) -> Result<usize> {
        self.follow_decal()?;
        self.with_decal(|session, decal| {
            let place = Place { face: picked.triangle, barycentric: picked.weights };
            let width = 2.0 * session.brush.radius;
            let (pins, pose) = match &decal.laid {
                Some(laid) => {
                    let image = image_at(&laid.decal, &decal.sticker, picked).ok_or_else(|| {
                        Error::invalid("the image does not lie there").advise("put the pin on the image")
                    })?;
                    let mut pins = laid.placement.pins();
                    pins.push(Pin { image, place });
                    (pins, laid.pose)
                }
                None => {
                    let image = decal.sticker.pixels().map(|side| 0.5 * f64::from(side));
                    (vec![Pin { image, place }], Pose { width, up: up.to_array() })
                }
            };
            session.lay(decal, &pins, pose)?;
            decal.selected = Some(pins.len() - 1);
            Ok(pins.len() - 1)
        })
    }

    /// Removes a pin; with the last one the image is taken off.
    ///
    /// # Errors
    /// There is no such pin, or the image cannot be laid without it. It stays as it was.
    pub fn remove_pin(&mut self, pin: usize) -> Result<()> {
        self.follow_decal()?;
        self.with_decal(|session, decal| {
            let Some(laid) = decal.laid.as_ref().filter(|laid| pin < laid.dots.len()) else {
                return Err(Error::invalid(format!("there is no pin {}", pin + 1)));
            };
            let (mut pins, pose) = (laid.placement.pins(), laid.pose);
            pins.remove(pin);
            if pins.is_empty() {
                decal.laid = None;
            } else {
                session.lay(decal, &pins, pose)?;
            }
            decal.selected = None;
            Ok(())
        })
    }

    /// Moves a pin to where the surface was picked.
    ///
    /// # Errors
    /// There is no such pin, or the image cannot follow without folds. It stays as it was.
    pub fn drag_pin(&mut self, pin: usize, picked: &Picked) -> Result<()> {
        self.with_decal(|session, decal| {
            let Some(laid) = &mut decal.laid else { return Err(Error::invalid("the image lies nowhere")) };
            if laid.before.is_none() {
                laid.before = Some(laid.placement.pins());
            }
            let place = Place { face: picked.triangle, barycentric: picked.weights };
            let placement = &mut laid.placement;
            let dragged = session.costs.other("drag a pin", || placement.drag(pin, place));
            // Where the image did not lie it has to grow; far away it is laid anew.
            let dragged = dragged.or_else(|_| {
                placement.settle(&mut Silent)?;
                placement.drag(pin, place)
            });
            if dragged.is_ok() {
                return laid.refresh();
            }
            let (mut pins, pose) = (placement.pins(), laid.pose);
            if let Some(moved) = pins.get_mut(pin) {
                moved.place = place;
            }
            session.lay(decal, &pins, pose)
        })
    }

    /// Ends the drag of a pin: the image is laid as well as it can be with the pins as they are.
    ///
    /// # Errors
    /// It cannot be laid without folds. It stays as it was.
    pub fn end_pin(&mut self) -> Result<()> {
        self.with_decal(|session, decal| {
            let Some(laid) = decal.laid.as_mut().filter(|laid| laid.before.is_some()) else { return Ok(()) };
            laid.before = None;
            session.costs.other("decal", || laid.placement.settle(&mut Silent))?;
            laid.refresh()
        })
    }

    /// Takes the drag of a pin back.
    ///
    /// # Errors
    /// The image cannot be laid as it was.
    pub fn cancel_pin(&mut self) -> Result<()> {
        self.with_decal(|session, decal| {
            let Some((pins, pose)) = decal.laid.as_mut().and_then(|laid| Some((laid.before.take()?, laid.pose))) else {
                return Ok(());
            };
            session.lay(decal, &pins, pose)
        })
    }

    /// Takes the image off the surface.
    pub fn drop_decal(&mut self) {
        if let Some(decal) = &mut self.decal {
            (decal.laid, decal.selected, decal.fault) = (None, None, None);
        }
    }

    /// Has the image follow edits of the model, and the size of the brush while it has one pin.
    ///
    /// # Errors
    /// The image does not fit the changed surface. The function then removes it.
    pub(crate) fn follow_decal(&mut self) -> Result<()> {
        let Some(laid) = self.decal.as_ref().and_then(|decal| decal.laid.as_ref()) else { return Ok(()) };
        let is_same = laid.changes == self.changes();
        let width = 2.0 * self.brush.radius;
        let is_as_wide = laid.dots.len() != 1 || laid.pose.width == width;
        if self.is_drawing() || laid.before.is_some() || (is_same && is_as_wide) {
            return Ok(());
        }
        let done = self.with_decal(|session, decal| {
            let Some(laid) = &mut decal.laid else { return Ok(()) };
            if laid.serial != session.triangles.serial {
                return Err(Error::invalid("the faces of the model are divided anew").advise("lay the image again"));
            }
            if !is_as_wide {
                let (pins, pose) = (laid.placement.pins(), Pose { width, ..laid.pose });
                return session.lay(decal, &pins, pose);
            }
            laid.changes = session.changes();
            if laid.placement.mesh().points == session.triangles.points() {
                return Ok(());
            }
            session.costs.other("decal", || laid.placement.pose(session.triangles.points(), &mut Silent))?;
            laid.refresh()
        });
        if done.is_err()
            && let Some(decal) = &mut self.decal
        {
            (decal.laid, decal.selected) = (None, None);
        }
        done
    }

    /// Writes the image into the active layer of colour, as one edit, and takes it off the hand.
    ///
    /// # Errors
    /// It lies nowhere, the layer is hidden, another edit is under way, or the journal cannot be written.
    pub fn write_decal(&mut self) -> Result<()> {
        self.follow_decal()?;
        self.with_decal(|session, decal| {
            let Some(laid) = &mut decal.laid else {
                return Err(Error::invalid("the image lies nowhere").advise("click on the surface first"));
            };
            if laid.before.take().is_some() {
                laid.placement.settle(&mut Silent)?;
                laid.refresh()?;
            }
            let label = format!("decal {}", decal.name);
            let Self { context, object, history, triangles, .. } = session;
            with_object!(&mut *object, it => history.begin(context, &mut **it, &label))?;
            let painted = triangles.paint_decal(context, object, &laid.decal, &decal.artwork);
            let refused = painted.as_ref().map_or(0, |printed| printed.refused.len());
            session.finish(&label, painted.map(drop))?;
            if refused > 0 {
                session.message =
                    Some(format!("the image is missing on {refused} faces: the budget of memory is used up"));
            }
            (decal.laid, decal.selected) = (None, None);
            Ok(())
        })
    }
}
