#version 450
// Shows the colour of the vertices.

layout(location = 0) in vec3 color;
layout(location = 0) out vec4 paint;

void main() {
    paint = vec4(color, 1.0);
}
