"""Launches the job "dam" on OpenCue."""

import os

import outline
import outline.cuerun
from outline.modules.shell import Shell

job = outline.Outline("dam", show=os.environ.get("SHOW", "testing"), shot=os.environ.get("SHOT", "dam"))

simulate = Shell("simulate", command=["relievo", "fluid", "sim", "/projects/dam.toml", "-o", "/projects/out/frames", "--threads", "2"], range="0-0", cores=2, overrideCores=True)
job.add_layer(simulate)

mesh = Shell("mesh", command=["relievo", "fluid", "mesh", "/projects/out/frames", "-o", "/projects/out/meshes", "--frames", "#FRAME_START#..#FRAME_END#", "--threads", "2", "--cell", "0.75"], range="0-5", chunk=2, cores=2, overrideCores=True)
mesh.depend_all(simulate)
job.add_layer(mesh)

foam = Shell("foam", command=["relievo", "foam", "generate", "/projects/out/frames", "-o", "/projects/out/foam", "--threads", "2"], range="0-0", cores=2, overrideCores=True)
foam.depend_all(simulate)
job.add_layer(foam)

render = Shell("render", command=["relievo", "foam", "render", "/projects/out/foam", "--fluid", "/projects/out/frames", "-o", "/projects/out/pictures", "--frames", "#FRAME_START#..#FRAME_END#", "--threads", "2"], range="0-5", chunk=2, cores=2, overrideCores=True)
render.depend_all(foam)
job.add_layer(render)
outline.cuerun.launch(job, use_pycuerun=False)
