/* Relievo: surfaces that take imprints, for plugins of DCC applications and renderers. Everything, in C.
 * The rules that hold for every noun are in relievo/context.h. */
#ifndef RELIEVO_RELIEVO_H
#define RELIEVO_RELIEVO_H

#include "relievo/adapter.h"
#include "relievo/arrival.h"
#include "relievo/bake.h"
#include "relievo/bezier.h"
#include "relievo/brush.h"
#include "relievo/buffer.h"
#include "relievo/caster.h"
#include "relievo/collider.h"
#include "relievo/color_buffer.h"
#include "relievo/context.h"
#include "relievo/detail.h"
#include "relievo/device_level.h"
#include "relievo/document.h"
#include "relievo/error.h"
#include "relievo/evaluate.h"
#include "relievo/fluid.h"
#include "relievo/imprint.h"
#include "relievo/isosurface.h"
#include "relievo/job.h"
#include "relievo/layer.h"
#include "relievo/level.h"
#include "relievo/mesh.h"
#include "relievo/parameter.h"
#include "relievo/picture.h"
#include "relievo/procedural.h"
#include "relievo/progressive.h"
#include "relievo/ptex.h"
#include "relievo/simplify.h"
#include "relievo/stroke.h"
#include "relievo/surface.h"
#include "relievo/tessellate.h"
#include "relievo/version.h"

#endif
