# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that artists read, where those of the library's parameters and values say little: labels by table and parameter,
and tooltips of modes."""

# What panels call parameters of the library, by the group of settings; others have their own name.
LABELS = {
    "RelievoBrushSettings": {
        "depth": "Reach in depth",
        "strength_pressure": "Strength by pressure",
        "size_pressure": "Radius by pressure",
        "angle_pressure": "Angle by pressure",
        "jitter_position": "Place",
        "jitter_size": "Radius",
        "jitter_strength": "Strength",
        "jitter_angle": "Angle",
        "string": "Stabilize",
        "rate": "Airbrush rate",
        "symmetry_x": "X",
        "symmetry_y": "Y",
        "symmetry_z": "Z",
        "reach": "Reach to the surface",
        "level": "Coarseness",
    },
    "RelievoStampSettings": {"mid": "Middle grey", "scale": "Contrast"},
    "RelievoImprintSettings": {
        "voxels": "Most voxels",
        "jitter": "Grid turn",
        "share": "Softness",
        "depth_limit": "Depth per frame",
        "smoothing_passes": "Smoothing passes",
        "sub_steps": "Most sub-steps",
        "culling": "Skip what is not touched",
        "compaction": "Update changed tiles alone",
        "repose": "Rim slope",
    },
    "RelievoRepairSettings": {
        "weld": "Weld points",
        "tolerance": "Weld distance",
        "degenerate": "Drop degenerate faces",
        "duplicates": "Drop doubled faces",
        "orient": "Turn faces outwards",
        "split": "Split edges of many faces",
        "fill": "Fill holes",
        "hole_edges": "Most edges of a hole",
        "hole_area": "Largest filling",
        "refine": "Refine fillings",
        "fair": "Smooth fillings",
        "unused": "Drop loose points",
    },
    "RelievoFoamSettings": {
        "air_min": "Trapped air from",
        "air_max": "Trapped air to",
        "crest_min": "Crests from",
        "crest_max": "Crests to",
        "energy_min": "Energy from",
        "energy_max": "Energy to",
        "air_rate": "Foam of trapped air",
        "crest_rate": "Foam of crests",
        "lifetime_min": "Shortest life",
        "lifetime_max": "Longest life",
        "spray_below": "Spray below neighbours",
        "bubbles_above": "Bubbles above neighbours",
        "drag": "Bubble drag",
        "steps": "Steps of a frame",
        "most": "Most particles",
    },
    "RelievoFoamLook": {
        "spray_n": "Spray core",
        "spray_m": "Spray edge",
        "foam_n": "Foam core",
        "foam_m": "Foam edge",
        "bubble_n": "Bubble core",
        "bubble_m": "Bubble edge",
        "lifetime_n": "Fading core",
        "lifetime_m": "Fading edge",
        "eta_max": "Visible depth",
        "eta_n": "Depth fading core",
        "eta_m": "Depth fading edge",
        "rho_mod": "Half brightness at",
        "rho_exp": "Brightness contrast",
        "ao_init_sr_fac": "Occlusion radius",
        "ao_sr_inc_fac": "Radius growth of a pass",
        "ao_passes": "Occlusion passes",
        "ao_s_dens": "Sample density",
        "ao_min_samp": "Fewest samples",
        "ao_max_samp": "Most samples",
        "ao_max_occl_dist": "Occlusion distance",
        "ao_fluid_opacity": "Occlusion by fluid",
        "ao_solid_opacity": "Occlusion by solids",
        "ao_hemisphere": "Outer side alone",
        "ao_sh_scale": "Shadow strength",
        "ao_sh_exp": "Shadow contrast",
    },
}

# What modes of brushes and other choices do, by their values.
TIPS = {
    "RlvPaintMode": {
        "MIX": "Lay the colour over what is there",
        "ADD": "Add the colour to what is there",
        "MULTIPLY": "Multiply what is there by the colour",
        "ERASE": "Take paint away",
        "BLUR": "Blend neighbouring colours",
        "SMEAR": "Drag colours along the stroke",
    },
    "RlvSculptMode": {
        "DRAW": "Raise the surface along its normal",
        "SMOOTH": "Smooth relief away",
        "FLATTEN": "Bring the surface to the plane under the brush",
        "ERASE": "Bring the surface back to the mesh",
        "CLAY": "Build up to a plane over the surface",
        "SCRAPE": "Take off what stands out of the plane under the brush",
        "LAYER": "Raise to the height, and no further within a stroke",
        "INFLATE": "Grow bumps to all sides",
        "PINCH": "Pull the surface to the middle of the brush",
        "VECTOR": "Move the surface as the colours of the stamp say",
    },
    "RlvFalloff": {
        "CONSTANT": "The same in the whole square around the circle, which a stamp fills",
        "LINEAR": "Falls evenly to the border",
        "SMOOTH": "Falls smoothly at the middle and at the border",
        "SPHERE": "Round as a ball",
        "GAUSSIAN": "A bell",
    },
    "RlvLayerKind": {"DISPLACEMENT": "Relief", "COLOR": "Paint"},
    "RlvFluidContact": {
        "SLIP": "Particles slide along it",
        "STOP": "Particles that touch it stay",
        "FRICTION": "Particles slide along it and are slowed down",
    },
    "RlvBlend": {
        "NORMAL": "Cover what is below",
        "ADD": "Add to what is below",
        "SUBTRACT": "Take from what is below",
        "MULTIPLY": "Multiply what is below",
        "SCREEN": "Lighten what is below",
        "OVERLAY": "Darken what is dark below and lighten what is light",
        "MAX": "The larger of both",
        "MIN": "The smaller of both",
    },
}


def of(group, name):
    """Returns what panels call a parameter of a group of settings."""
    return LABELS.get(group, {}).get(name, name.replace("_", " ").capitalize())


def tip(enum, name):
    """Returns what a tooltip says of a value of an enum of the library, "" where there is nothing to say."""
    return TIPS.get(enum, {}).get(name, "")
