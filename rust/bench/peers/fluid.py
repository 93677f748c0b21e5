"""Fluids by SPlisHSPlasH and meshes of particles by splashsurf, for the bench.

`simulate METHOD SPACING SIDE SECONDS`: a cube of SIDE particles along each axis falls in a basin of three by one by two of
its sides. `mesh FILE RADIUS CELL`: the particles of a file of 32-bit floats. Both tell JSON on the last line.
"""

import json
import resource
import sys
import tempfile
import time

import numpy as np


def basin(path, low, high):
    """The sides of a box, seen from inside."""
    corners = [[[low, high][(n >> k) & 1][k] for k in range(3)] for n in range(8)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    with open(path, "w") as file:
        file.writelines("v {} {} {}\n".format(*corner) for corner in corners)
        for a, b, c, d in sides:
            file.write(f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n")


def simulate(method, spacing, side, seconds):
    """Errors of density are those at the places where a step ends, as the next one finds them."""
    import pysplishsplash as sph

    spacing, side, seconds = float(spacing), int(side), float(seconds)
    width, radius = spacing * side, spacing / 2
    folder = tempfile.mkdtemp()
    # Its walls are particles on the surface; fluid that begins nearer than this is thrown back.
    gap = 0.75 * spacing
    basin(f"{folder}/basin.obj", [-gap] * 3, [3 * width + gap, 2 * width + gap, width + gap])
    scene = {
        "Configuration": {
            "particleRadius": radius, "density0": 1000, "gravitation": [0, -9.81, 0], "stopAt": seconds,
            "simulationMethod": {"PCISPH": 1, "DFSPH": 4}[method], "boundaryHandlingMethod": 0, "enableZSort": True,
            "cflMethod": 1, "cflFactor": 1, "cflMaxTimeStepSize": 0.001, "timeStepSize": 0.001,
            "maxIterations": 100, "maxError": 0.1, "maxIterationsV": 100, "maxErrorV": 0.1,
        },
        "Materials": [{"id": "Fluid", "viscosityMethod": 1, "viscosity": 0.001, "viscosityBoundary": 0.001}],
        "RigidBodies": [{"geometryFile": f"{folder}/basin.obj", "isDynamic": False, "isWall": True, "mapInvert": True,
                         "translation": [0, 0, 0], "scale": [1, 1, 1]}],
        "FluidBlocks": [{"denseMode": 0, "start": [-radius] * 3, "end": [width] * 3}],
    }
    with open(f"{folder}/scene.json", "w") as file:
        json.dump(scene, file)
    base = sph.Exec.SimulatorBase()
    base.init(useGui=False, sceneFile=f"{folder}/scene.json", outputDir=f"{folder}/out", stopAt=seconds)
    base.initSimulation()
    simulation = sph.Simulation.getCurrent()
    fluid = simulation.getFluidModel(0)
    solver = simulation.getTimeStep()
    density = np.array(fluid.getFieldBuffer("density"), copy=False)
    told = {"steps": 0, "iterations": 0, "most": 0.0, "mean": 0.0}
    watching = 0.0

    def watch():
        nonlocal watching
        start = time.process_time()
        excess = np.maximum(density / 1000.0 - 1.0, 0.0)
        told["steps"] += 1
        told["iterations"] += solver.getNumIterations()
        if method == "DFSPH":
            told["iterations"] += solver.getValueUInt(solver.SOLVER_ITERATIONS_V)
        told["most"] = max(told["most"], float(excess.max()))
        told["mean"] += float(excess.mean())
        watching += time.process_time() - start

    base.setTimeStepCB(watch)
    start = time.process_time()
    base.runSimulation()
    told["core_seconds"] = time.process_time() - start - watching
    told["particles"] = fluid.numActiveParticles()
    told["seconds"] = sph.TimeManager.getCurrent().getTime()
    told["mean"] /= told["steps"]
    return told


def mesh(path, radius, cell):
    """Smoothing length and cell are relative to the radius of particles."""
    import pysplashsurf

    points = np.fromfile(path, np.float32).reshape(-1, 3)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    made = pysplashsurf.reconstruct_surface(points, particle_radius=float(radius), smoothing_length=2.0,
                                            cube_size=float(cell), iso_surface_threshold=0.6)
    seconds = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"seconds": seconds, "vertices": len(made.mesh.vertices), "peak": 1024 * (after - before)}


print("\n" + json.dumps(globals()[sys.argv[1]](*sys.argv[2:])))
