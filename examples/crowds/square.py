"""Writes a list of people who cross a square in four streams around a statue: python square.py > square.txt

The people are models 0 and 1 of `relievo crowd view` and `relievo crowd render`, the statue is model 2. With the
characters girl and robot of raylib's examples (CC0), and a statue whose lowest point is 0.73 units below its origin:

    relievo crowd build girl.glb -o girl.rcrowd --clip RunTrack
    relievo crowd build robot.glb -o robot.rcrowd --clip Robot_Walking
    relievo crowd build statue.glb -o statue.rcrowd
    relievo crowd render girl.rcrowd robot.rcrowd statue.rcrowd --agents square.txt -o square.png --show agents \\
        --frames 3 --step 2 --eye 6,4.2,19 --target 0,0.9,0 --size 900x280

A list has one agent a line: x y z, heading in degrees about y, scale, clip, phase in seconds, model, and speed along the
heading in units a second."""

import random

PEOPLE = 1000
SIDE = 70.0  # metres
STATUE = 3.5  # metres from its middle that people do not enter
STATUE_SCALE = 3.0
STATUE_HEIGHT = 0.73 * STATUE_SCALE
# Scale to about 1.7 m, seconds of the clip, and metres a second, for each model of a person.
MODELS = [(1.1, 1.0, 2.6), (0.37, 0.97, 1.3)]

generator = random.Random(1)
print("# x y z heading scale clip phase model speed")
print(f"0 {STATUE_HEIGHT} 0 160 {STATUE_SCALE} 0 0 2 0")
for person in range(PEOPLE):
    model = generator.randrange(2)
    scale, seconds, speed = MODELS[model]
    along = generator.uniform(-SIDE / 2, SIDE / 2)
    # Streams along x pass the statue in front and behind, streams along z at its sides.
    across = generator.choice([-1, 1]) * generator.uniform(STATUE, SIDE / 2)
    direction = generator.choice([-1, 1])
    if person % 2 == 0:
        x, z, heading = along, across, 90 * direction
    else:
        x, z, heading = across, along, 90 - 90 * direction
    size = scale * generator.uniform(0.92, 1.08)
    phase = generator.uniform(0, seconds)
    print(f"{x:.3f} 0 {z:.3f} {heading} {size:.3f} 0 {phase:.3f} {model} {speed * generator.uniform(0.9, 1.1):.2f}")
