//! What is generic over objects, compiled here for the two kinds there are. Functions that are never inlined are shared
//! with the crates above if this one has an instance of them; otherwise each of these, every test and every fuzz target
//! would compile layers, fading and undo of all channels once more.

use crate::{
    Canvas, DecayingObject, DisplacedObject, History, LayeredObject, OpenStroke, Recorded, Stroke, TriangleObject,
};

/// Functions that are there for objects of one kind.
fn of_objects<O: LayeredObject>() -> Vec<*const ()> {
    vec![
        O::layers as *const (),
        O::add_layer as *const (),
        O::set_active_layer as *const (),
        O::set_layer as *const (),
        O::place_layer as *const (),
        O::remove_layer as *const (),
        O::merge_layer as *const (),
        O::flatten_layers as *const (),
        O::settle as *const (),
        O::settle_colors as *const (),
        O::layer_states as *const (),
        O::store as *const (),
        O::take_up as *const (),
        <O as Recorded>::states as *const (),
        <O as Recorded>::restore as *const (),
        <O as DecayingObject>::set_decay as *const (),
        <O as DecayingObject>::set_layer_decay as *const (),
        <O as DecayingObject>::stamp as *const (),
        <O as DecayingObject>::advance as *const (),
        <O as DecayingObject>::take_as_stamped as *const (),
        History::begin::<O> as *const (),
        History::end::<O> as *const (),
        History::abandon::<O> as *const (),
        History::undo::<O> as *const (),
        History::redo::<O> as *const (),
    ]
}

/// Functions that are there for what strokes are made on.
fn of_canvases<C: Canvas + ?Sized>() -> Vec<*const ()> {
    vec![
        Stroke::apply_all::<C> as *const (),
        Stroke::apply_stations::<C> as *const (),
        OpenStroke::begin::<C> as *const (),
        OpenStroke::extend::<C> as *const (),
        OpenStroke::end::<C> as *const (),
    ]
}

/// Where the instances are. Nothing needs to know; it makes them.
#[doc(hidden)]
pub fn instances() -> Vec<*const ()> {
    let objects = [of_objects::<DisplacedObject>(), of_objects::<TriangleObject>()];
    let canvases = [of_canvases::<DisplacedObject>(), of_canvases::<TriangleObject>(), of_canvases::<dyn Canvas>()];
    objects.into_iter().chain(canvases).flatten().collect()
}
